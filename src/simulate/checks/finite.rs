//! Numbers that are not finite, found before they are recorded.

use crate::dynamics::Fault;
use crate::model::Model;
use crate::record::{ContactPush, Energy, Sample};
use crate::simulate::error::RunError;
use crate::simulate::samples::couplings;
use crate::simulate::state::State;
use crate::spatial::Wrench;

/// The first number of a sample and of its contacts that is not finite is an error that names its owner; outputs have been checked.
///
/// # Errors
/// [`Fault::NotFinite`].
pub(in crate::simulate) fn check(model: &Model, sample: &Sample<'_>, contacts: &[ContactPush]) -> Result<(), RunError> {
    let Sample { time, positions, velocities, accelerations, bodies, reactions, couplings, energy, .. } = *sample;
    let owner = |index: usize| model.owner(index).to_owned();
    let body = |index: usize| model.bodies[index].name.clone();
    let first = |numbers: &[f64]| numbers.iter().position(|x| !x.is_finite());
    let by_position = |index: usize| {
        let mut of = model.bodies.iter().rev();
        of.find(|body| body.hinge.position <= index).map_or_else(String::new, |body| body.name.clone())
    };
    let pose = |pose: &crate::spatial::Pose| {
        let turn = pose.rotation.coords.iter().all(|x| x.is_finite());
        turn && pose.translation.vector.iter().all(|x| x.is_finite())
    };
    let wrench = |w: &Wrench| w.force.iter().chain(w.moment.iter()).all(|x| x.is_finite());
    let Energy { kinetic, potential, work, dissipated, error } = energy;
    let found = first(positions).map(|index| ("the position", by_position(index)));
    let found = found.or_else(|| first(velocities).map(|index| ("the velocity", owner(index))));
    let found = found.or_else(|| first(accelerations).map(|index| ("the acceleration", owner(index))));
    let found = found.or_else(|| bodies.iter().position(|p| !pose(p)).map(|index| ("the place", body(index))));
    let found =
        found.or_else(|| reactions.iter().position(|w| !wrench(w)).map(|i| ("the reaction at the hinge", body(i))));
    let found = found.or_else(|| {
        let channel =
            |index: usize| couplings::channels(model).into_iter().nth(index).map_or_else(String::new, |c| c.body);
        first(couplings).map(|index| ("what pushes", channel(index)))
    });
    let found = found.or_else(|| {
        let whole = |push: &ContactPush| [push.point, push.normal, push.force].iter().flatten().all(|x| x.is_finite());
        let bad = contacts.iter().find(|push| !whole(push));
        bad.map(|ContactPush { between: [one, other], .. }| {
            ("the force of the contact", format!("{one}` and `{other}"))
        })
    });
    let found = found.or_else(|| {
        let energies = [("the kinetic energy", kinetic), ("the potential energy", potential), ("the work", work)];
        let energies = energies.into_iter().chain([("the dissipated energy", dissipated), ("the energy error", error)]);
        let mut bad = energies.filter(|(_, value)| !value.is_finite());
        // What moves fastest overflows first.
        let fastest = (0..velocities.len()).max_by(|a, b| velocities[*a].abs().total_cmp(&velocities[*b].abs()));
        let of = || fastest.map_or_else(|| model.title.clone(), owner);
        bad.next().map(|(what, _)| (what, of()))
    });
    match found {
        Some((what, element)) => Err(RunError::Sample { time, fault: Fault::NotFinite { what, element } }),
        None => Ok(()),
    }
}

/// Angles of a start that are so large that their rounding is above the tolerance of a run.
///
/// # Errors
/// [`RunError::Coarse`], with the hinge.
pub(in crate::simulate) fn check_start(model: &Model, start: &State, tolerance: f64) -> Result<(), RunError> {
    for link in model.links.iter().filter(|link| link.joint.is_angle()) {
        let angle = start.position[link.position];
        let rounding = f64::EPSILON * angle.abs();
        if rounding > tolerance.max(FINEST) {
            return Err(RunError::Coarse { hinge: model.label(link.velocity), angle, rounding, tolerance });
        }
    }
    Ok(())
}

/// Rounding of an angle below this is of no account (rad).
const FINEST: f64 = 1e-10;

#[cfg(test)]
mod tests {
    use super::*;

    /// One hanging body, at rest.
    fn checked(force: [f64; 3]) -> Result<(), RunError> {
        use crate::model::description::{BodyDescription, Description, HingeDescription};
        let ball = BodyDescription::new("ball", HingeDescription::free()).mass(1.0).inertia([1.0; 3]);
        let scene = Description::new("touching").body(ball);
        let model = Model::build(&scene).expect("a model");
        let energy = Energy { kinetic: 0.0, potential: 0.0, work: 0.0, dissipated: 0.0, error: 0.0 };
        let sample = Sample {
            time: 0.5,
            positions: &[],
            velocities: &[],
            accelerations: &[],
            bodies: &[],
            reactions: &[],
            couplings: &[],
            outputs: &[],
            energy,
        };
        let between = ["ball", "floor"].map(str::to_owned);
        let push = ContactPush { between, point: [0.0; 3], normal: [0.0, 0.0, 1.0], force, slips: false };
        check(&model, &sample, &[push])
    }

    #[test]
    fn forces_of_contacts_that_are_no_numbers_are_found_before_they_are_recorded() {
        assert!(checked([0.0, 0.0, 1.0]).is_ok());
        for wrong in [f64::NAN, f64::INFINITY] {
            let said = checked([0.0, wrong, 1.0]).expect_err("no number").to_string();
            assert!(said.contains("the force of the contact of `ball` and `floor`"), "{said}");
        }
    }
}
