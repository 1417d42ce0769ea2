//! Components of a mechanism: elements whose rows share hinges, directly or through others.
//!
//! Only hinges between the two ends of a loop move these against each other, so rows of different components have no
//! column of `G` in common: each component is closed, and its rank decided, by itself and in lengths of its own. Nothing
//! that another component, a mass, or a unit is made of enters.
//!
//! ```text
//! lever   the longest distance from a revolute or spherical hinge of the component to the end of a loop that it moves (m)
//! reach   the longest way along links from one end of a loop of the component to the other (m)
//! span    the lever if all links between lay in one line and no hinge were moved (m)
//! ```
//!
//! A lever makes the entries of `G` comparable: a turn by 1 rad moves ends by about one lever. A reach is what gaps are
//! small or large compared with: the round-off of a gap is that of the way it is summed over. A span is of the mechanism and not of
//! a pose: what is told of one pose in parts of it, as shared multipliers, is the same wherever a search has begun.

use super::row::{Ends, Rule};
use super::rows::RowGroup;
use crate::model::{End, Model};
use crate::motion::Motion;

/// A reach below this part of the scene's length is none: what is left of places that cancel to zero.
const NOWHERE: f64 = 1e-30;

/// Levers below this part of the reach are round-off.
const NO_LEVER: f64 = 1e-9;

/// Lengths of one component (m).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Lengths {
    pub(super) lever: f64,
    pub(super) reach: f64,
}

impl Lengths {
    fn max(self, other: Self) -> Self {
        Self { lever: self.lever.max(other.lever), reach: self.reach.max(other.reach) }
    }
}

/// The links whose coordinates move the ends of an element against each other.
pub(super) fn between_ends(model: &Model, element: &RowGroup) -> Vec<usize> {
    let named = element.named.iter().copied().filter(|link| *link != 0);
    let mut links: Vec<usize> = element.branches.iter().flatten().copied().chain(named).collect();
    if model.modals.is_empty() {
        return links;
    }
    // The coordinates that move an interface are those of the frame that carries it.
    let is_interface = |link: &&usize| model.links[**link].joint.interface().is_some();
    let mut frames: Vec<usize> = links.iter().filter(is_interface).map(|link| model.links[*link].parent).collect();
    frames.sort_unstable();
    frames.dedup();
    frames.retain(|frame| !links.contains(frame));
    links.extend(frames);
    links
}

/// Lists of elements, one for each component, by its first element; empty for the others.
pub(super) fn members(of: &[usize]) -> Vec<Vec<usize>> {
    let mut members = vec![Vec::new(); of.len()];
    of.iter().enumerate().for_each(|(element, first)| members[*first].push(element));
    members
}

/// Of every element the first one of its component.
pub(super) fn components(model: &Model, elements: &[RowGroup]) -> Vec<usize> {
    let inner: Vec<Vec<usize>> = elements.iter().map(|element| between_ends(model, element)).collect();
    sharing(&inner, model.links.len())
}

/// Of lists of links, for each the first one that it shares a link with, directly or through others.
pub(super) fn sharing(lists: &[Vec<usize>], links: usize) -> Vec<usize> {
    let mut root: Vec<usize> = (0..lists.len()).collect();
    fn find(root: &mut [usize], mut at: usize) -> usize {
        while root[at] != at {
            root[at] = root[root[at]];
            at = root[at];
        }
        at
    }
    let mut owner = vec![usize::MAX; links];
    for (list, links) in lists.iter().enumerate() {
        for link in links {
            match owner[*link] {
                usize::MAX => owner[*link] = list,
                other => {
                    let (a, b) = (find(&mut root, list), find(&mut root, other));
                    root[a.max(b)] = a.min(b);
                }
            }
        }
    }
    (0..lists.len()).map(|list| find(&mut root, list)).collect()
}

/// The lengths of every element's component, where `motion` is.
pub(super) fn lengths(model: &Model, elements: &[RowGroup], rules: &[Rule], motion: &Motion) -> Vec<Lengths> {
    let own: Vec<Lengths> = elements.iter().map(|element| of_element(element, rules, model, motion)).collect();
    of_components(model, elements, &own)
}

/// The span of every element's component (m).
pub(super) fn spans(model: &Model, elements: &[RowGroup], rules: &[Rule]) -> Vec<f64> {
    let mut unmoved = Motion::new(model);
    unmoved.update(model, &model.unmoved_position(), &vec![0.0; model.velocity_count()]);
    let own = |element: &RowGroup| {
        let lengths = of_element(element, rules, model, &unmoved);
        Lengths { lever: span_of(element, model, &unmoved).unwrap_or(lengths.lever), ..lengths }
    };
    let own: Vec<Lengths> = elements.iter().map(own).collect();
    of_components(model, elements, &own).into_iter().map(|lengths| lengths.lever).collect()
}

/// `None` of what has no ends.
fn span_of(element: &RowGroup, model: &Model, unmoved: &Motion) -> Option<f64> {
    let ends = element.ends.as_ref()?;
    let of_branch = |(branch, end): (&Vec<usize>, &End)| {
        let (mut longest, mut way) = (0.0_f64, end.point.norm());
        for link in branch {
            if model.links[*link].joint.turns() {
                longest = longest.max(way);
            }
            way += unmoved.links[*link].arm.norm();
        }
        longest
    };
    Some(element.branches.iter().zip(ends).map(of_branch).fold(0.0, f64::max))
}

/// The levers of every element: its component's, and that of its own hinges (m).
pub(super) fn levers(model: &Model, elements: &[RowGroup], rules: &[Rule], motion: &Motion) -> Vec<[f64; 2]> {
    let own: Vec<Lengths> = elements.iter().map(|element| of_element(element, rules, model, motion)).collect();
    let shared = of_components(model, elements, &own);
    let lever = |(own, shared): (&Lengths, &Lengths)| match own.lever > NO_LEVER * own.reach {
        true => [shared.lever, own.lever],
        false => [shared.lever, if own.reach > 0.0 { own.reach } else { shared.lever }],
    };
    own.iter().zip(&shared).map(lever).collect()
}

fn of_components(model: &Model, elements: &[RowGroup], own: &[Lengths]) -> Vec<Lengths> {
    let of = components(model, elements);
    let mut found = vec![Lengths::default(); elements.len()];
    own.iter().zip(&of).for_each(|(own, first)| found[*first] = found[*first].max(*own));
    // If no hinge reaches from end to end, the bodies themselves are the only lengths there are.
    let nothing = NOWHERE * model.length_scale();
    found.iter_mut().filter(|lengths| lengths.reach <= nothing).for_each(|lengths| lengths.reach = 0.0);
    let mut bodies = vec![0.0_f64; elements.len()];
    for (element, first) in elements.iter().zip(&of).filter(|(_, first)| found[**first].reach == 0.0) {
        for link in between_ends(model, element) {
            bodies[*first] = bodies[*first].max(model.bodies[model.links[link].body].extent());
        }
    }
    for (lengths, body) in found.iter_mut().zip(&bodies) {
        if lengths.reach == 0.0 {
            lengths.reach = if *body > 0.0 { *body } else { 1.0 };
        }
        if lengths.lever <= NO_LEVER * lengths.reach {
            lengths.lever = lengths.reach;
        }
    }
    of.into_iter().map(|first| found[first]).collect()
}

fn of_element(element: &RowGroup, rules: &[Rule], model: &Model, motion: &Motion) -> Lengths {
    let Some(ends) = &element.ends else {
        // Metres per radian of a rack or a screw.
        let ratio = |rule: &Rule| match rule {
            Rule::Motion { parts: [(first, _), (second, factor)] } if first.slides && !second.slides => factor.abs(),
            _ => 0.0,
        };
        let lever = rules[element.rows.clone()].iter().map(ratio).fold(0.0, f64::max);
        return Lengths { lever, reach: lever };
    };
    let arms = ends.map(|end| motion.links[end.link].turn * end.point);
    let way = |branch: &Vec<usize>| branch.iter().map(|link| motion.links[*link].arm.norm()).sum::<f64>();
    let reach = element.branches.iter().map(way).sum::<f64>() + arms[0].norm() + arms[1].norm();
    // Rows along axes of the first link act on it where the second end is.
    let slides = rules[element.rows.clone()].iter().any(|rule| matches!(rule, Rule::Along { .. }));
    let between = if slides { Ends::of(ends, &element.branches, motion).between() } else { Default::default() };
    let mut lever = 0.0_f64;
    for (end, branch) in element.branches.iter().enumerate() {
        let mut arm = if end == 0 { arms[0] + between } else { arms[1] };
        for link in branch {
            if model.links[*link].joint.turns() {
                lever = lever.max(arm.norm());
            }
            arm += motion.links[*link].arm;
        }
    }
    Lengths { lever, reach }
}
