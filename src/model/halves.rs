//! Where a large tree falls into two halves that can be computed at once.

use super::Link;
use std::ops::Range;

/// Links in both halves from which on there is a second thread: as fast as one then, and faster while it does not fall asleep
/// between two evaluations, which from ten thousand links on it hardly does (docs/speed.md, “Two cores”).
const LEAST: usize = 2000;
/// Of the links of both halves, the most that the larger one may have: with more, less than a third would be saved.
const LARGEST: f64 = 0.7;

/// Two groups of branches of one link. Links stand in depth-first order, so each is a range.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Halves {
    /// The link that carries both; 0 is the ground.
    pub hub: usize,
    /// Links of each: the first half begins right after the hub, the second right after the first.
    pub links: [Range<usize>; 2],
    /// Velocities of each.
    pub velocities: [Range<usize>; 2],
    /// How many turns come before each half, and before what follows them.
    pub turns: [usize; 3],
}

impl Halves {
    /// The largest that are even enough; none in a small tree or a chain.
    pub(super) fn of(links: &[Link]) -> Option<Self> {
        let end = |link: usize| if link == 0 { links.len() } else { links[link].subtree_end };
        let mut hub = 0;
        loop {
            let (first, last) = (hub + 1, end(hub));
            if last - first < LEAST {
                return None;
            }
            let children = || std::iter::successors(Some(first), |child| Some(end(*child)).filter(|next| *next < last));
            let larger = |middle: usize| (middle - first).max(last - middle);
            if let Some(middle) = children().skip(1).min_by_key(|middle| larger(*middle))
                && larger(middle) as f64 <= LARGEST * (last - first) as f64
            {
                return Some(Self::at(links, hub, [first..middle, middle..last]));
            }
            hub = children().max_by_key(|child| end(*child) - child)?;
        }
    }

    fn at(links: &[Link], hub: usize, halves: [Range<usize>; 2]) -> Self {
        // Velocities stand in the order of the links.
        let velocities = |half: &Range<usize>| {
            let last = &links[half.end - 1];
            links[half.start].velocity..last.velocity + last.joint.counts().1
        };
        let turns = |before: usize| links[..before].iter().filter(|link| link.joint.is_angle()).count();
        let [one, other] = &halves;
        Self {
            hub,
            velocities: [velocities(one), velocities(other)],
            turns: [one.start, other.start, other.end].map(turns),
            links: halves,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Joint;

    /// A tree from the parents of its links, all turns.
    fn tree(parents: &[usize]) -> Vec<Link> {
        let mut links = vec![Link::ground()];
        for (index, parent) in parents.iter().enumerate() {
            links.push(Link { parent: *parent, joint: Joint::Turn, velocity: index, ..Link::ground() });
        }
        for index in (1..links.len()).rev() {
            links[index].subtree_end = links[index].subtree_end.max(index + 1);
            let (parent, end) = (links[index].parent, links[index].subtree_end);
            if parent > 0 {
                links[parent].subtree_end = links[parent].subtree_end.max(end);
            }
        }
        links
    }

    #[test]
    fn branches_are_shared_out_evenly_below_the_trunk() {
        // A trunk of two links, then three branches of 1300, 100 and 1250.
        let mut parents = vec![0, 1];
        for length in [1300, 100, 1250] {
            parents.push(2);
            (1..length).for_each(|_| parents.push(parents.len()));
        }
        let halves = Halves::of(&tree(&parents)).expect("halves");
        assert_eq!((halves.hub, halves.links), (2, [3..1303, 1303..2653]));
        assert_eq!((halves.velocities, halves.turns), ([2..1302, 1302..2652], [2, 1302, 2652]));
    }

    #[test]
    fn chains_and_small_trees_stay_whole() {
        assert_eq!(Halves::of(&tree(&(0..3000).collect::<Vec<_>>())), None);
        assert_eq!(Halves::of(&tree(&[0, 1, 1, 0])), None);
    }
}
