//! Modal bodies: as described, checked, and taken apart into bodies.
//!
//! A modal body becomes its own body on its hinge, without mass, then one that has its coordinates, then one at each interface
//! but the root. A point that is given by the name of an interface is one of the body there.

use super::description::{BodyDescription, Description, HingeDescription, Point};
use super::problem::{Element, Problem};
use crate::element::modal::{MOST_MODAL_COORDINATES, Modal};
use nalgebra::Vector3;
use std::path::PathBuf;
use std::sync::Arc;

/// That a body is a modal one.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalDescription {
    /// Name of the body.
    pub body: String,
    /// What it is made of.
    pub modal: Arc<Modal>,
    /// The file that it comes from.
    pub file: Option<PathBuf>,
    /// Its coordinates at the start; none for zero.
    pub position: Vec<f64>,
    /// Their rates.
    pub velocity: Vec<f64>,
}

/// A compiled modal body.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalBody {
    /// Name.
    pub name: String,
    /// The body on its hinge.
    pub root: usize,
    /// The body and the link that have its coordinates.
    pub inner: usize,
    /// See `inner`.
    pub link: usize,
    /// The bodies at its interfaces but the root.
    pub tips: Vec<usize>,
    /// Their links.
    pub links: Vec<usize>,
    /// What it is made of.
    pub modal: Arc<Modal>,
}

/// The bodies of a modal body.
#[derive(Debug)]
pub(in crate::model) struct ModalBodies {
    pub(in crate::model) name: String,
    pub(in crate::model) root: usize,
    pub(in crate::model) inner: usize,
    pub(in crate::model) tips: Vec<usize>,
    pub(in crate::model) modal: Arc<Modal>,
    pub(in crate::model) start: [Vec<f64>; 2],
}

impl ModalBodies {
    /// The body and the point of it that a point of the modal body is, if it is at an interface.
    pub(in crate::model) fn place(&self, point: &Point) -> Option<(usize, Vector3<f64>)> {
        let Point::Marker(name) = point else { return None };
        let tip = self.modal.tips.iter().position(|tip| tip.name == *name)?;
        Some((self.tips[tip], Vector3::zeros()))
    }
}

/// What is wrong with the modal bodies.
pub(super) fn check(description: &Description) -> Vec<Problem> {
    let of_modal = |given: &ModalDescription| {
        let index = description.bodies.iter().position(|body| body.name == given.body)?;
        let body = &description.bodies[index];
        let problem = |message: String, help: &str| {
            let help = Some(help.to_owned());
            Some(Problem { element: Element::Body(index), field: "modal".to_owned(), message, help })
        };
        let (name, m) = (&given.body, given.modal.count());
        if body.mass.mass != 0.0 || body.mass.inertia.iter().any(|x| *x != 0.0) {
            return problem(
                format!("`{name}` is a modal body and has a mass beside that"),
                "its mass is that of its file; weld another body to it with a fixed hinge",
            );
        }
        if m > MOST_MODAL_COORDINATES {
            return problem(
                format!("`{name}` has {m} coordinates: six for every interface but the root, and its modes"),
                "allowed: 96; ask for fewer `modes`, or merge interfaces",
            );
        }
        for (list, what) in [(&given.position, "positions"), (&given.velocity, "velocities")] {
            if !(list.is_empty() || list.len() == m) || list.iter().any(|x| !x.is_finite()) {
                return problem(
                    format!("`{name}` needs {m} finite {what} of its coordinates, not {}", list.len()),
                    "one number per coordinate: `inspect --json` names them",
                );
            }
        }
        let both = given.modal.tips.iter().find(|tip| body.markers.iter().any(|(marker, _)| *marker == tip.name));
        let tip = both?;
        problem(format!("`{name}` has a marker and an interface `{}`", tip.name), "call the marker something else")
    };
    description.modals.iter().filter_map(of_modal).collect()
}

/// Adds the bodies of all modal bodies after the others.
pub(super) fn expand(description: &mut Description) -> Vec<ModalBodies> {
    let given = description.modals.clone();
    given.iter().filter_map(|modal| add(description, modal)).collect()
}

fn add(description: &mut Description, given: &ModalDescription) -> Option<ModalBodies> {
    let bodies = &mut description.bodies;
    let root = bodies.iter().position(|body| body.name == given.body)?;
    let inner = bodies.len();
    let own = format!("{}/modes", given.body);
    bodies.push(BodyDescription::new(&own, HingeDescription::fixed().on(&given.body, Vector3::zeros())));
    let mut tips = Vec::with_capacity(given.modal.tips.len());
    for tip in &given.modal.tips {
        tips.push(bodies.len());
        let hinge = HingeDescription::fixed().on(&own, Vector3::zeros());
        bodies.push(BodyDescription::new(&format!("{}/{}", given.body, tip.name), hinge));
        bodies[root].markers.push((tip.name.clone(), tip.place));
    }
    let start = [given.position.clone(), given.velocity.clone()];
    Some(ModalBodies { name: given.body.clone(), root, inner, tips, modal: Arc::clone(&given.modal), start })
}
