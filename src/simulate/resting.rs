//! Scenes that contact holds at rest: nothing moves, so that a run has nothing to integrate.
//!
//! With Coulomb's law a scene whose velocities are zero stays where it is if forces within the cones of its contacts balance
//! its loads, and goes on to do so as long as those do not change: `(q, v) = (q₀, 0)` solves
//!
//! ```text
//! (1)  M(q) q̈ = f(t, q, v) + Jᵀλ,    λ ∈ K(μ),    f(t, q₀, 0) = f(t₀, q₀, 0),    v(t₀) = 0
//! ```
//!
//! Whether there are such forces is the question of statics ([`crate::statics::standing`]). Its forces act in the run as
//! loads at the points of contact, so that reactions and outputs have them; (1) is then evaluated, and what it leaves of
//! accelerations has to be nothing ([`STILL`]). Positions are kept bit for bit, by every method and for every duration.
//!
//! If the forces at rest are not unique, those of least norm act. What moves, or does not stand, is refused.

use crate::integrate::{Progress, Start, StepError, Stepper};
use crate::model::Model;
use crate::model::problem::rounded;
use crate::record::ContactPush;
use crate::simulate::error::RunError;
use crate::simulate::problem::Equations;
use crate::simulate::settings::Settings;
use crate::simulate::state::State;
use crate::statics::standing::{BearingContacts, ContactForce, Verdict, bearing, by_rule, overlap, with_contacts};
use nalgebra::Vector3;
use std::sync::Arc;

/// What (1) may leave of accelerations, in parts of the scene's own: its loads are balanced to the tolerance of the conic
/// program, 10⁻¹² of the largest of them, on bodies that may be 10⁵ times lighter than the heaviest.
const STILL: f64 = 1e-7;
/// Forces that are balanced to this part of those that cancel in a coordinate leave round-off: of what is stiff and light, as a beam's section,
/// that accelerates more than [`STILL`].
const BALANCED: f64 = 1e-9;

/// What is said of the integrator.
pub(super) const SAID: &str = "none: contact holds the scene at rest, by the forces of statics";

/// Whether runs have everything that a scene has, from this state on.
///
/// # Errors
/// [`RunError::Contact`] of what would be left out.
pub fn check(model: &Arc<Model>, settings: &Settings, start: &State) -> Result<(), RunError> {
    held(model, settings, start).map(drop)
}

/// What contacts bear from `state` on as loads of a model, if they hold it at rest to the end of a run; `None` for a model
/// without contact, and one that moves.
///
/// # Errors
/// [`RunError::Contact`] where that cannot be decided, and of what contact in motion does not have.
pub(super) fn held(model: &Arc<Model>, settings: &Settings, state: &State) -> Result<Option<HeldAtRest>, RunError> {
    let Some(rule) = model.contacts.first() else { return Ok(None) };
    // What has been followed goes on to be, however deep captured steps have let it sink.
    if settings.resume.iter().filter_map(|resume| resume.mode.as_ref()).any(|mode| mode.has_contacts()) {
        return Ok(None);
    }
    let refuse = |why: String| RunError::Contact { name: rule.name.clone(), why };
    // What is compliant moves into what bears it.
    let compliant = model.contacts.iter().any(|rule| !rule.law.is_rigid());
    let moves = compliant || state.velocity.iter().any(|v| *v != 0.0) || !is_steady(model);
    let found = match moves {
        true => overlap(model, settings.gap, &state.position).map(|()| None),
        false => bearing(model, settings.gap, &state.position).map(Some),
    };
    match found.map_err(|why| refuse(why.to_string()))? {
        Some(found) if found.verdict == Verdict::Stands => {
            return Ok(Some(HeldAtRest {
                model: with_contacts(model, &state.position, &found.contacts),
                contacts: pushes(model, &found),
                by_rule: by_rule(model, &found.contacts),
            }));
        }
        Some(found) if found.verdict == Verdict::Wedged => {
            return Err(refuse("the scene stands only if its contacts are squeezed beforehand".to_owned()));
        }
        _ => {}
    }
    Ok(None)
}

/// Proves that what is held does not accelerate: (1).
///
/// # Errors
/// [`RunError::Contact`] where it does, [`RunError::Sample`] where that cannot be evaluated.
pub(super) fn prove(motion: &mut Equations, time: f64, state: &State) -> Result<(), RunError> {
    let Some(rule) = motion.model().contacts.first().cloned() else { return Ok(()) };
    let model = Arc::clone(motion.model());
    let (length, span) = (model.length_scale(), model.time_scale());
    let mut a = vec![0.0; state.velocity.len()];
    let fault = |fault| RunError::Sample { time, fault };
    motion.accelerations(time, &state.position, &state.velocity, &mut a).map_err(fault)?;
    let mut left = vec![0.0; a.len()];
    let rest = vec![0.0; a.len()];
    let mut at = motion.at(time, &state.position, &state.velocity);
    let force = at.residual(&rest, &mut left).map_err(fault)?.magnitudes().force;
    // Forces of loops are not among them.
    let is_balanced = |i: usize| !model.is_constrained() && left[i].abs() <= BALANCED * force[i];
    for link in model.links.iter().skip(1) {
        let unit = if link.joint.is_distance() { length } else { 1.0 } / (span * span);
        let velocities = link.velocity..link.velocity + link.joint.counts().1;
        // Written so that what is not a number is none.
        if let Some(index) = velocities.into_iter().find(|i| !(a[*i].abs() <= STILL * unit || is_balanced(*i))) {
            let why = format!(
                "the forces that statics has found for its supports do not keep {} still: it would accelerate with {} {}",
                model.label(index),
                rounded(a[index]),
                if link.joint.is_distance() { "m/s²" } else { "rad/s²" }
            );
            return Err(RunError::Contact { name: rule.name, why });
        }
    }
    Ok(())
}

/// Whether no drive, motor or controller changes with time.
pub(super) fn is_steady(model: &Model) -> bool {
    let drive = model.drives.iter().find(|drive| !(drive.motion.is_steady() && drive.motion.at(0.0).velocity == 0.0));
    drive.is_none()
        && model.table_times().next().is_none()
        && model.motors.iter().all(|motor| motor.is_steady())
        && model.controllers.is_empty()
}

/// What holds a scene at rest.
pub(super) struct HeldAtRest {
    /// The model with the forces of its contacts as loads.
    pub(super) model: Arc<Model>,
    /// These forces.
    pub(super) contacts: Vec<ContactPush>,
    /// Their sums, contact rule by contact rule (N).
    pub(super) by_rule: Vec<Vector3<f64>>,
}

fn pushes(model: &Model, found: &BearingContacts) -> Vec<ContactPush> {
    let push = |one: &ContactForce| ContactPush {
        between: one.contact.bodies.map(|body| model.bodies[body].name.clone()),
        point: one.contact.point.into(),
        normal: one.contact.normal.into(),
        force: one.force.into(),
        slips: false,
    };
    found.contacts.iter().map(push).collect()
}

/// A step of any length along which nothing moves.
pub(super) struct AtRest(Progress);

impl AtRest {
    /// From a start to its end.
    ///
    /// # Errors
    /// As [`Method::start`](crate::integrate::Method::start).
    pub(super) fn new(motion: &Equations, start: Start<'_>) -> Result<Self, StepError> {
        Progress::at_rest(motion, start).map(Self)
    }
}

impl Stepper<Equations> for AtRest {
    fn step(&mut self, _: &mut Equations) -> Result<(), StepError> {
        self.0.stay();
        Ok(())
    }

    fn progress(&self) -> &Progress {
        &self.0
    }

    fn interpolate(&mut self, _: &mut Equations, _: f64, q: &mut [f64], v: &mut [f64]) -> Result<(), StepError> {
        q.copy_from_slice(self.0.position());
        v.copy_from_slice(self.0.velocity());
        Ok(())
    }
}
