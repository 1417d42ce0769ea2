//! How the velocity coordinates of a tree hang together: worked out once per model.

use crate::model::{Joint, Model};
use std::ops::Range;

/// A velocity coordinate in the sweeps. Coordinates stand in the order of their links.
#[derive(Debug, Clone)]
pub(super) struct ColumnPlace {
    pub kind: ColumnKind,
    /// First coordinate of its link, and one past the link's last.
    pub first: usize,
    pub next: usize,
    /// One past the last coordinate of the subtree of its link.
    pub end: usize,
    /// First coordinate of the parent link; `None` on the ground.
    pub above: Option<usize>,
    /// All coordinates of the branch from the ground that it is part of.
    pub branch: Range<usize>,
    /// Where the outward sweep comes from.
    pub from: From,
    /// Where the field is kept for branches that come later.
    pub keep: Option<usize>,
}

/// What a coordinate moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ColumnKind {
    /// A turn, or the first axis of a ball.
    Turn,
    Slide,
    /// A turn with a slide of `pitch` per radian (m/rad).
    Screw {
        pitch: f64,
    },
    /// A further axis of a ball, at the same marker.
    Further,
}

/// Where the outward sweep comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum From {
    /// The coordinate before.
    Before,
    /// The ground, where nothing varies.
    Ground,
    /// A field kept earlier.
    Kept(usize),
}

/// The places of all velocity coordinates, and how many fields have to be kept at the same time.
pub(super) fn places(model: &Model) -> (Vec<ColumnPlace>, usize) {
    let mut places: Vec<ColumnPlace> = Vec::with_capacity(model.velocity_count());
    let mut most_kept = 0;
    // Slots in use on the way from the ground to each link, its own included.
    let mut slots = vec![0; model.links.len()];
    let past = |link: usize| model.links.get(link).map_or(model.velocity_count(), |link| link.velocity);
    for (index, link) in model.links.iter().enumerate().skip(1) {
        let (_, count) = link.joint.counts();
        let next = link.velocity + count;
        let has_several = index + 1 < link.subtree_end && model.links[index + 1].subtree_end < link.subtree_end;
        let above = (link.parent != 0).then(|| model.links[link.parent].velocity);
        let branch = above.map_or(link.velocity..past(link.subtree_end), |above| places[above].branch.clone());
        slots[index] = slots[link.parent] + usize::from(has_several);
        most_kept = most_kept.max(slots[index]);
        for i in link.velocity..next {
            let is_first = i == link.velocity;
            places.push(ColumnPlace {
                kind: match link.joint {
                    Joint::Slide { .. } => ColumnKind::Slide,
                    Joint::Screw { pitch } => ColumnKind::Screw { pitch },
                    _ if is_first => ColumnKind::Turn,
                    _ => ColumnKind::Further,
                },
                first: link.velocity,
                next,
                end: past(link.subtree_end),
                above,
                branch: branch.clone(),
                from: match link.parent {
                    _ if !is_first => From::Before,
                    0 => From::Ground,
                    parent if parent + 1 == index => From::Before,
                    parent => From::Kept(slots[parent] - 1),
                },
                keep: (has_several && i + 1 == next).then(|| slots[index] - 1),
            });
        }
    }
    (places, most_kept)
}

/// For every link the first one with mass on its branch from the ground (itself where there is none).
pub(super) fn references(model: &Model) -> Vec<usize> {
    let mut references = vec![0; model.links.len()];
    let mut index = 1;
    while index < model.links.len() {
        let branch = index..model.links[index].subtree_end;
        let first = branch.clone().find(|i| !model.links[*i].is_massless()).unwrap_or(index);
        references[branch.clone()].fill(first);
        index = branch.end;
    }
    references
}
