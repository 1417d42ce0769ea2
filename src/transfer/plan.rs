//! How the links of a tree hang together, as the inward sweeps see it: worked out once per model.

use crate::model::{Joint, Model};
use crate::pages::Pages;
use crate::spatial::Sym3;

/// Below this part of the sum of its moments, the one about its axis counts as small: the round-off of the others would be
/// multiplied by the inverse square of it. A thin rod across its axis has a half, along it 0.
const SLENDER: f64 = 1.0 / 32.0;

/// A body whose smallest moment about its centre of mass is below this part of the sum of those about its root marker may
/// let motions be that hardly anything resists: a point mass, a thin rod.
const DELICATE: f64 = 1e-3;

/// One link in the inward sweep.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Nothing hangs on it.
    pub is_leaf: bool,
    /// So, it turns (or screws) about an axis about which it has hardly any inertia.
    pub is_slender: bool,
    /// It turns and is slender, or its body is such that digits may be lost with it.
    pub is_delicate: bool,
    /// It has neither mass nor inertia.
    pub is_massless: bool,
    /// It slides, and so does everything that it hangs on: nothing there can turn.
    pub translates: bool,
    /// Where all its children but the first are summed; `None` with one child or none.
    pub join: Option<u32>,
    /// Where it passes on what it carries.
    pub to: To,
    /// Index of a ball among the balls; of a flexible element or a modal body among those.
    pub ball: u32,
    /// Index of an interface among those of its modal body.
    pub tip: u32,
    /// Its parent, its first velocity and what moves there, the armature of a single coordinate (kg or kg m²) and its mass (kg):
    /// compared with the rest, for a link as a whole is long.
    pub parent: u32,
    pub velocity: u32,
    pub kind: Kind,
    pub armature: f64,
    pub mass: f64,
    /// A pivot below this lost digits in the difference of much larger numbers: what it carries is so much heavier than its own
    /// body (kg or kg m²); 0 elsewhere.
    pub least: f64,
}

/// What a hinge leaves free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    None,
    Turn,
    Slide,
    Screw,
    Ball,
    Flex,
    Modal,
    Interface,
}

/// Where a link passes on what it carries.
#[derive(Debug, Clone, Copy)]
pub(super) enum To {
    /// The ground, which takes everything.
    Ground,
    /// The link before it: it is the first child.
    Previous,
    /// The sum of a link with several children.
    Join(u32),
}

/// A pivot below this part of what the heaviest body outboard would resist at the end of the link lost five digits or more.
const LIGHT: f64 = 1e-5;
/// With a pivot below this part of it the residual of what the link carries may drown that of the link.
const OUTWEIGHED: f64 = 1e-3;

/// [`Place::least`] of all links. What their hinges leave of a chain is no heavier than its heaviest body: bodies are compared one
/// by one, and not with all that hangs on them. Above 0 for links whose own part is below `part`.
fn least_pivots(model: &Model, part: f64) -> Vec<f64> {
    let count = model.links.len();
    // Of all bodies outboard the largest mass and moment of inertia about a root marker, of the children the largest distance.
    let (mut mass, mut moment, mut arm) = (vec![0.0_f64; count], vec![0.0_f64; count], vec![0.0_f64; count]);
    let mut least = vec![0.0; count];
    for index in (1..count).rev() {
        let link = &model.links[index];
        // Of a hinge of several links the body is the last one's.
        let own = model.links[index..].iter().take_while(|other| other.body == link.body).last().unwrap_or(link);
        let (resists, carried) = match link.joint.is_slide() {
            true => (own.mass, mass[index]),
            false => (own.inertia.trace(), moment[index] + mass[index] * arm[index] * arm[index]),
        };
        if resists < part * carried {
            least[index] = part * carried;
        }
        let parent = link.parent;
        mass[parent] = mass[parent].max(mass[index]).max(link.mass);
        moment[parent] = moment[parent].max(moment[index]).max(link.inertia.trace());
        arm[parent] = arm[parent].max(link.offset.norm());
    }
    least
}

/// Whether links carry bodies so much heavier that pivots may lose five digits or more.
pub(super) fn has_light_links(model: &Model) -> bool {
    least_pivots(model, LIGHT).iter().any(|least| *least > 0.0)
}

/// Whether links carry bodies so much heavier that an implicit step's Newton iteration may take what those need for what the links do.
pub(super) fn has_outweighed_links(model: &Model) -> bool {
    least_pivots(model, OUTWEIGHED).iter().any(|least| *least > 0.0)
}

/// Of a hinge of several links it is the last one's body.
fn is_delicate(model: &Model, index: usize) -> bool {
    let of_hinge = model.links[index..].iter().take_while(|link| link.body == model.links[index].body);
    let Some(link) = of_hinge.last() else { return false };
    let central =
        link.inertia + Sym3::steiner(-link.mass, link.center) + Sym3::scalar(-DELICATE * link.inertia.trace());
    !central.inverse().is_some_and(|(_, pivots)| pivots.min() > 0.0)
}

/// The index of what a joint's coordinates belong to.
fn element_of(joint: &Joint) -> Option<usize> {
    joint.rod().or_else(|| joint.modal()).or_else(|| joint.interface().map(|(modal, _)| modal))
}

/// The places of all links, the number of sums, and the number of balls.
pub(super) fn plan(model: &Model) -> (Pages<Place>, usize, usize) {
    let (mut joins, mut balls) = (0, 0);
    let mut plan: Vec<Place> = Vec::with_capacity(model.links.len());
    let least = least_pivots(model, LIGHT);
    for (index, link) in model.links.iter().enumerate() {
        let is_leaf = link.subtree_end == index + 1;
        // In depth-first order the first child comes right after its parent.
        let has_more = !is_leaf && index != 0 && model.links[index + 1].subtree_end < link.subtree_end;
        let join = has_more.then_some(joins);
        joins += u32::from(has_more);
        let to = match (link.parent, index) {
            (0, _) => To::Ground,
            (parent, index) if parent + 1 == index => To::Previous,
            (parent, _) => plan[parent].join.map_or(To::Previous, To::Join),
        };
        let slides = link.joint.is_slide();
        let translates = slides && (link.parent == 0 || plan[link.parent].translates);
        let kind = match link.joint {
            Joint::None => Kind::None,
            Joint::Turn => Kind::Turn,
            Joint::Slide { .. } => Kind::Slide,
            Joint::Screw { .. } => Kind::Screw,
            Joint::Ball { .. } => Kind::Ball,
            Joint::Flex { .. } | Joint::Along { .. } => Kind::Flex,
            Joint::Modal { .. } => Kind::Modal,
            Joint::Interface { .. } => Kind::Interface,
        };
        let (parent, velocity, is_massless) = (link.parent as u32, link.velocity as u32, link.is_massless());
        let axial = link.inertia.zz / link.inertia.trace();
        let has_axis = matches!(kind, Kind::Turn | Kind::Screw);
        let is_slender = is_leaf && has_axis && axial < SLENDER;
        plan.push(Place {
            is_leaf,
            is_slender,
            is_delicate: is_slender || has_axis && is_delicate(model, index),
            is_massless,
            translates,
            join,
            to,
            ball: element_of(&link.joint).map_or(balls, |element| element as u32),
            tip: link.joint.interface().map_or(0, |(_, tip)| tip as u32),
            parent,
            velocity,
            kind,
            armature: model.coordinates.get(link.velocity).map_or(0.0, |coordinate| coordinate.armature),
            mass: link.mass,
            least: least[index],
        });
        balls += u32::from(kind == Kind::Ball);
    }
    (plan.into_iter().collect(), joins as usize, balls as usize)
}
