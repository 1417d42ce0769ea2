//! Dry friction and contact at rest: does the scene stand as it is put, by how much, and how would it fall?
//!
//! With friction the equilibria of a scene are a set, not a point. The pose is kept as given and asked whether forces in
//! the cones of its supports balance what pushes it there ([`crate::contact::support`]): contacts that are closed, hinges with
//! dry friction, stops that are touched; loops, drives, gears and locks bear whatever they have to.
//!
//! ```text
//! (1)  f(q) + Gᵀλ + Jᵀ c + τ = 0,    c ∈ K_contact,   |τ| ≤ stick,   λ free,  stops that press
//! ```
//!
//! `f` is what the balance of the hinges lacks at rest. The size of the loads is that of the largest part of `f`, moments by
//! the scene's length. What stands is the pose, bit for bit.

mod closed;
mod margins;
mod mechanism;
mod supports;

pub use closed::{Contact, Untouchable};
pub use margins::{Interval, Margins};
pub use mechanism::{Giving, Mechanism};

use self::closed::Scene;
use self::supports::{Bears, Bearers};
use super::settings::{Margin, Settings};
use crate::contact::support::{Certificate, Undecided, Verdict};
use crate::dynamics::Fault;
use crate::model::{Description, Model};
use nalgebra::Vector3;

/// What a contact bears.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactForce {
    /// Where, and between which bodies.
    pub contact: Contact,
    /// On the second body, inertial axes (N).
    pub force: Vector3<f64>,
    /// Part of the cone that it uses, 0 … 1.
    pub share: f64,
}

/// What dry friction of a hinge holds.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionForce {
    /// The hinge, as in [`Model::label`].
    pub hinge: String,
    /// First velocity coordinate.
    pub velocity: usize,
    /// (N or N m), one number per velocity coordinate that is bounded together.
    pub force: Vec<f64>,
    /// Part of what it can hold, 0 … 1.
    pub share: f64,
}

/// Whether a pose stands.
#[derive(Debug, Clone)]
pub struct Standing {
    /// The verdict.
    pub verdict: Verdict,
    /// What there is to spare, or is lacking (negative), in parts of the loads.
    pub slack: f64,
    /// What closed contacts bear: the forces of least norm if it stands, else those that come nearest.
    pub contacts: Vec<ContactForce>,
    /// What dry friction holds.
    pub friction: Vec<FrictionForce>,
    /// Dimension of the forces that balance each other at supports that bear.
    pub self_stresses: usize,
    /// The smallest part of all coefficients and bounds of friction at which it stands; `None` if no friction changes the
    /// verdict.
    pub friction_margin: Option<f64>,
    /// The ranges that were asked for.
    pub margins: Margins,
    /// What a wedged scene has to be squeezed with at least (N).
    pub squeeze: Option<f64>,
    /// How it gives way: along which motion it falls, or would fall first as friction is taken away.
    pub mechanism: Option<Mechanism>,
    /// How far the answer is from exact.
    pub certificate: Certificate,
    /// Forces of all supports as generalized forces, for a certificate of the pose: hinge forces by velocity coordinate.
    pub(super) hinge_forces: Vec<f64>,
}

/// Why the question has no answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unanswered {
    /// The system cannot be evaluated.
    #[error(transparent)]
    Fault(#[from] Fault),
    /// Shapes that cannot touch, or overlap.
    #[error(transparent)]
    Untouchable(#[from] Untouchable),
    /// The conic program.
    #[error(transparent)]
    Undecided(#[from] Undecided),
}

/// Whether a scene has dry friction or contact.
pub fn is_for(model: &Model) -> bool {
    !(model.hinge_friction.is_empty() && model.contacts.is_empty())
}

/// Whether a pose stands, and the margins that are `asked` for. `description` is the scene's, for the numbers that they move.
///
/// # Errors
/// [`Unanswered`].
pub fn standing(
    description: &Description,
    model: &Model,
    settings: &Settings,
    asked: &Margin,
    pose: &[f64],
) -> Result<Standing, Unanswered> {
    let scene = Scene::new(model, pose, settings.gap)?;
    let bearers = Bearers::new(model, pose, &scene)?;
    let found = bearers.supports.standing(&bearers.load)?;
    let wedged = found.verdict == Verdict::Wedged;
    let friction_margin = if wedged { None } else { bearers.supports.friction_margin(&bearers.load)? };
    let squeeze = wedged.then(|| bearers.supports.least_squeeze(&bearers.load)).transpose()?;
    let margins = margins::margins(description, model, asked, pose, &bearers)?;
    let motion = match (found.verdict, friction_margin) {
        (Verdict::Falls, _) => Some(found.motion.clone()),
        // At its margin, not here: here nothing moves.
        (Verdict::Stands, Some(part)) if part > 0.0 => Some(bearers.supports.motion_at(&bearers.load, part)?),
        _ => None,
    };
    let mechanism = motion.map(|motion| mechanism::mechanism(model, pose, &scene, &bearers, &motion));
    let (mut contacts, mut friction, mut hinge_forces) = (Vec::new(), Vec::new(), vec![0.0; bearers.load.len()]);
    for (i, bears) in bearers.list.iter().enumerate() {
        let f = &found.forces[bearers.supports.range(i)];
        let share = bearers.supports.cones()[i].share(f).unwrap_or(0.0);
        match bears {
            Bears::Contact(k) => {
                let contact = scene.contacts[*k].clone();
                contacts.push(ContactForce { force: contact.force(f), contact, share });
            }
            Bears::Friction { velocity } => {
                hinge_forces[*velocity..velocity + f.len()].copy_from_slice(f);
                friction.push(FrictionForce {
                    hinge: model.label(*velocity),
                    velocity: *velocity,
                    force: f.to_vec(),
                    share,
                });
            }
            Bears::Stop { velocity, sign } => hinge_forces[*velocity] += sign * f[0],
            Bears::Other => {}
        }
    }
    Ok(Standing {
        verdict: found.verdict,
        slack: found.slack,
        contacts,
        friction,
        self_stresses: found.self_stresses,
        friction_margin,
        margins,
        squeeze,
        mechanism,
        certificate: found.certificate,
        hinge_forces,
    })
}
