//! The certificate of a pose that friction and contact hold.

use super::super::certify::equilibrium::{Equilibrium, examine};
use super::super::certify::stability;
use super::super::problem::assembled::Assembled;
use super::super::settings::{Settings, Want};
use super::{StandingReport, Unanswered};
use crate::contact::support::{BALANCED, Verdict};
use crate::model::description::{Attachment, ForceDescription, Point};
use crate::model::problem::in_one_line;
use crate::model::{Description, Model};
use crate::motion::Motion;
use std::sync::Arc;

/// The pose with what its supports push as loads on it: reactions, residual, and how the coordinates that nothing holds
/// move about it.
pub(super) fn certificate(
    description: &Description,
    model: &Arc<Model>,
    settings: &Settings,
    pose: &[f64],
    standing: &StandingReport,
) -> Result<Equilibrium, Unanswered> {
    let loaded = loaded(description, model, pose, standing);
    let (_, assembled) = Assembled::of(model.clone()).map_err(Unanswered::Open)?;
    let built = Model::build(&loaded).map_err(|problems| Unanswered::Open(in_one_line(&problems)))?;
    let built = assembled.apply(built, &mut pose.to_vec()).map_err(Unanswered::Open)?.starting_at(pose);
    // What sticks holds its coordinate, as a lock does.
    let sticking = standing.friction.iter().flat_map(|one| one.velocity..one.velocity + one.force.len());
    let sticking: Vec<usize> = sticking.chain(standing.stop_forces.iter().map(|(velocity, _)| *velocity)).collect();
    let held = built.locking(sticking.iter().copied());
    let mut found = examine(&held, settings, pose, ("standing", BALANCED), Vec::new())?;
    found.holding.retain(|(name, _)| !sticking.iter().any(|velocity| model.label(*velocity) == *name));
    let stands = standing.verdict == Verdict::Stands;
    (found.converged, found.stage) = (stands && found.balanced, "given");
    if !standing.contacts.is_empty() {
        found.stability.clone_from(&standing.stability);
    }
    let unstable =
        found.stability.as_ref().is_some_and(|stability| stability.verdict == stability::StabilityVerdict::Unstable);
    found.converged &= !(unstable && settings.want == Want::Stable);
    if !stands {
        (found.balanced, found.stability) = (false, None);
    }
    found.notes.extend_from_slice(&standing.margins.notes);
    Ok(found)
}

/// The scene with the forces of contacts and stops as loads and hinge forces.
fn loaded(description: &Description, model: &Model, pose: &[f64], standing: &StandingReport) -> Description {
    let mut motion = Motion::new(model);
    motion.update(model, pose, &vec![0.0; model.velocity_count()]);
    let mut loaded = description.clone();
    for (k, one) in standing.contacts.iter().enumerate() {
        for (body, force) in one.contact.bodies.into_iter().zip([-one.force, one.force]) {
            let body = &model.bodies[body];
            let at = motion.body_pose(body).inverse_transform_point(&one.contact.point.into());
            let on = Attachment { body: body.name.clone(), point: Point::At(at.coords) };
            loaded.forces.push(ForceDescription::load(&format!("contact {k} on {}", body.name), on, force));
        }
    }
    for (velocity, force) in standing.stop_forces.iter() {
        let coordinate = &model.coordinates[*velocity];
        let name = &model.bodies[coordinate.body].name;
        let of_bodies = loaded.bodies.iter_mut().map(|body| (&body.name, &mut body.hinge));
        let of_beams = loaded.beams.iter_mut().map(|beam| (&beam.name, &mut beam.hinge));
        let Some((_, hinge)) = of_bodies.chain(of_beams).find(|(body, _)| *body == name) else { continue };
        hinge.force.resize(hinge.kind.counts().1, 0.0);
        hinge.force[velocity - model.bodies[coordinate.body].hinge.velocity] += force;
    }
    loaded
}
