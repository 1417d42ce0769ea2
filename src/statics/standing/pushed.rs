//! Contacts as loads, for whatever asks for the forces of a scene that they hold.

use super::answer::ContactForce;
use crate::force::load::LoadLaw;
use crate::force::{End, Force, Law};
use crate::model::Model;
use crate::motion::Motion;
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
            forces.push(Force { name, law: Law::Load(LoadLaw::dead(on, force)) });
        }
    }
    model.with_forces(forces)
}
