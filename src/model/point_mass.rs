//! Hinges that turn a last body about a line about which it has no inertia: that is so in every position, and no run of
//! such a scene gets anywhere.

use super::description::Description;
use super::problem::{Element, Problem};
use super::{Joint, Link, Model};
use crate::round_off::PIVOT;
use crate::spatial::Sym3;
use nalgebra::Vector3;

pub(super) fn problems(description: &Description, model: &Model) -> Vec<Problem> {
    let links = model.links.iter().enumerate().skip(1);
    let last = links.filter(|(index, link)| link.subtree_end == index + 1 && link.mass != 0.0);
    last.filter(|(_, link)| !resists(model, link)).map(|(_, link)| problem(description, link.body)).collect()
}

/// Whether the link has inertia in all that its joint lets it do.
fn resists(model: &Model, link: &Link) -> bool {
    let armature = |i: usize| model.coordinates[link.velocity + i].armature;
    match link.joint {
        Joint::Turn | Joint::Screw { .. } => link.axial_inertia() + armature(0) > PIVOT.of(link.inertia.trace()),
        Joint::Ball { .. } => {
            let whole = link.inertia + Sym3::diagonal(Vector3::from([0, 1, 2].map(armature)));
            whole.inverse().is_some_and(|(_, pivots)| pivots.min() > PIVOT.of(whole.trace()))
        }
        Joint::None
        | Joint::Slide { .. }
        | Joint::Flex { .. }
        | Joint::Along { .. }
        | Joint::Modal { .. }
        | Joint::Interface { .. } => true,
    }
}

fn problem(description: &Description, body: usize) -> Problem {
    let name = &description.bodies[body].name;
    Problem {
        element: Element::Body(body),
        field: "inertia".to_owned(),
        message: format!(
            "`{name}` has no inertia about a line that its hinge lets it turn about: a point mass on its own axis, whose turn \
             would be undetermined"
        ),
        help: Some(format!(
            "give it `inertia` (kg m²), or `density` beside a `shape`, or the hinge an armature, as with `--set \
             {}.armature=1e-6`",
            name.split('[').next().unwrap_or(name)
        )),
    }
}
