//! Contacts as loads, for whatever asks for the forces of a scene that they hold.

use super::answer::ContactForce;
use crate::contact::pairs::rule_of;
use crate::force::{End, Force};
use crate::model::Model;
use crate::motion::Motion;
use nalgebra::Vector3;
use std::sync::Arc;

/// A model with the forces of contacts at a pose as loads on both bodies: they have no power and, as pairs, no potential.
pub fn with_contacts(model: &Arc<Model>, q: &[f64], contacts: &[ContactForce]) -> Arc<Model> {
    let mut place = Motion::new(model);
    place.update(model, q, &vec![0.0; model.velocity_count()]);
    let mut forces = model.forces.to_vec();
    for (k, one) in contacts.iter().enumerate() {
        for (index, force) in one.contact.bodies.into_iter().zip([-one.force, one.force]) {
            let body = &model.bodies[index];
            let link = &place.links[body.link];
            let point = link.turn.tr_mul(&(one.contact.point - link.position));
            let on = End { link: body.link, body: Some(index), point };
            let name = format!("contact {k} on {}", body.name);
            forces.push(Force::dead(name, on, force));
        }
    }
    model.with_forces(forces)
}

/// What each contact rule exerts on its second bodies, summed over all that touches (N, inertial axes).
pub fn by_rule(model: &Model, contacts: &[ContactForce]) -> Vec<Vector3<f64>> {
    let mut sums = vec![Vector3::zeros(); model.contacts.len()];
    for one in contacts {
        let [first, second] = one.contact.bodies;
        if let Some((rule, swapped)) = rule_of(model, first, second) {
            sums[rule] += if swapped { -one.force } else { one.force };
        }
    }
    sums
}
