//! Whether the balance of a beam's elements is one of the beam.
//!
//! The residual proves that elements balance. Elements that turn by far more than their steps are made for are no beam: their steps no
//! longer follow their strains, and a search down the potential finds shapes that no beam has. Where such elements are, the error of the
//! deflections by the two ways to section forces ([`Discretization`](crate::dynamics::Discretization)) has to bear the answer out.

use crate::dynamics::{Balanced, LockedStrain};
use crate::model::problem::{rounded, significant};

/// Deflections that are wrong by more than this part of a beam's length are not those of the beam.
const WRONG: f64 = 0.1;

/// A strain that is left out and would be more than this is told: section forces are asked for to this part, too.
const MUCH: f64 = 1e-3;

/// What is said of the beams of an equilibrium.
pub(super) struct Judged {
    /// Whether they may be in balance as their elements are.
    pub hold: bool,
    /// What a person should know.
    pub notes: Vec<String>,
}

/// Judges the beams in a position.
pub(super) fn judge(balanced: &Balanced<'_>, q: &[f64]) -> Judged {
    let mut judged = Judged { hold: true, notes: Vec::new() };
    for (wound, error) in balanced.wound(q) {
        // No number is no proof, either.
        if !(error <= WRONG) {
            judged.hold = false;
            judged.notes.push(format!(
                "the elements of `{}` balance, but by the estimate its deflections are wrong by {} times its length: this is no \
                 equilibrium of the beam",
                wound.beam,
                rounded(error)
            ));
        }
        judged.notes.push(wound.note());
    }
    if judged.hold {
        judged.notes.extend(balanced.locked_strains().iter().filter(|locked| locked.strain > MUCH).map(told));
    }
    judged
}

/// What is said of a strain that is not free.
fn told(locked: &LockedStrain) -> String {
    let LockedStrain { beam, name, strain, force, s } = locked;
    let (force, s, strain) = (rounded(*force), rounded(*s), significant(*strain, 3));
    let makes = match *name {
        "stretch" | "shear" => format!("{force} N at s = {s} m would make {strain} of it"),
        _ => format!("{force} N m at s = {s} m would turn the beam by {strain} rad over its length"),
    };
    format!("`{beam}` leaves out {name}: the {makes}; \"{name}\" in `free` has it")
}
