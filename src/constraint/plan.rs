//! Which rows are solved together, in which order, and where they meet: the sparse structure of `A = G M⁻¹ Gᵀ`.
//!
//! A row loads two links; what it does to the tree is felt on the ways from these to the root. Two rows meet where their
//! ways do: loops that share no moving link have no entry in `A`. Elements are ordered by Cuthill and McKee's rule,
//! reversed, so that the entries of a chain of loops stay near the diagonal.

use std::borrow::Borrow;
use std::ops::Range;

/// The rows of one element that are solved for.
#[derive(Debug, Clone)]
pub(super) struct Group {
    /// Index of the element.
    pub(super) element: usize,
    /// Indices of its rows.
    pub(super) rows: Vec<usize>,
    /// Unknown of its first row.
    pub(super) first: usize,
    /// Where its pushes begin: one per part of the links of its way and row.
    pub(super) pushes: usize,
}

/// Two groups that meet, and the runs of both ways that they share.
#[derive(Debug, Clone)]
pub(super) struct Meeting {
    pub(super) groups: [usize; 2],
    pub(super) common: Range<usize>,
}

/// Parts that two ways share without a gap: the place of the first one on each way, and how many.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run {
    pub(super) places: [usize; 2],
    pub(super) count: usize,
}

/// Where the groups of a plan meet.
#[derive(Debug, Clone, Default)]
pub(super) struct Meetings {
    /// Every pair of groups that meet, the later one first; a group meets itself.
    pub(super) pairs: Vec<Meeting>,
    /// What the ways of both groups of a meeting share.
    pub(super) common: Vec<Run>,
}

/// Structure and order of one system of rows.
#[derive(Debug, Clone, Default)]
pub(super) struct Plan {
    pub(super) groups: Vec<Group>,
    /// Number of unknowns.
    pub(super) unknowns: usize,
    /// Number of pushes.
    pub(super) pushes: usize,
    /// First column of every row of the matrix.
    pub(super) first_columns: Vec<usize>,
}

impl Plan {
    /// The plan for `rows_of` each element; `ways` are the links from the ends to the root, tips first, `parts` how many
    /// pushes there are at each link, and `grounded` says which links are fixed to the ground. Ways that share a link share the
    /// one on the ground, too.
    pub(super) fn new(rows_of: Vec<Vec<usize>>, ways: &[Vec<usize>], parts: &[usize], grounded: &[bool]) -> Self {
        let with_rows: Vec<usize> = (0..ways.len()).filter(|element| !rows_of[*element].is_empty()).collect();
        let on_ground = |way: &Vec<usize>| way.iter().copied().filter(|link| grounded[*link]).collect::<Vec<usize>>();
        let roots: Vec<Vec<usize>> = ways.iter().map(on_ground).collect();
        let order = reordered(&with_rows, &roots);
        let mut plan = Self::default();
        let mut first_at: Vec<Option<usize>> = vec![None; grounded.len()];
        for element in order {
            let rows = rows_of[element].clone();
            let group = Group { element, first: plan.unknowns, pushes: plan.pushes, rows };
            let before = roots[element].iter().filter_map(|link| first_at[*link]).min();
            let first_column = before.unwrap_or(group.first);
            plan.first_columns.extend(vec![first_column; group.rows.len()]);
            for link in &roots[element] {
                first_at[*link].get_or_insert(group.first);
            }
            plan.unknowns += group.rows.len();
            plan.pushes += group.rows.len() * ways[element].iter().map(|link| parts[*link]).sum::<usize>();
            plan.groups.push(group);
        }
        plan
    }

    /// Where the groups meet, for the arguments of [`Plan::new`]: as many pairs as the matrix has blocks.
    pub(super) fn meetings(&self, ways: &[Vec<usize>], parts: &[usize], grounded: &[bool]) -> Meetings {
        let places: Vec<Vec<usize>> = ways.iter().map(|way| places(way, parts)).collect();
        let mut found = Meetings::default();
        let mut at_link: Vec<Vec<usize>> = vec![Vec::new(); grounded.len()];
        let mut seen = vec![false; self.groups.len()];
        for (later, group) in self.groups.iter().enumerate() {
            let roots = || ways[group.element].iter().filter(|link| grounded[**link]);
            let mut earlier = distinct(roots().flat_map(|link| &at_link[*link]), &mut seen);
            earlier.sort_unstable();
            earlier.iter().for_each(|group| seen[*group] = false);
            earlier.push(later);
            for other in earlier {
                let start = found.common.len();
                let both = [group.element, self.groups[other].element];
                meet(
                    both.map(|element| &ways[element][..]),
                    both.map(|element| &places[element][..]),
                    &mut found.common,
                );
                found.pairs.push(Meeting { groups: [later, other], common: start..found.common.len() });
            }
            roots().for_each(|link| at_link[*link].push(later));
        }
        found
    }

    /// Operations of a factorization, about.
    pub(super) fn operations(&self) -> usize {
        self.first_columns.iter().enumerate().map(|(row, first)| (row - first).pow(2)).sum()
    }

    /// The rows in the order of the unknowns.
    pub(super) fn rows(&self) -> impl Iterator<Item = usize> + '_ {
        self.groups.iter().flat_map(|group| group.rows.iter().copied())
    }
}

/// Each index once; those that were come to are `seen`.
fn distinct<I: Borrow<usize>>(indices: impl Iterator<Item = I>, seen: &mut [bool]) -> Vec<usize> {
    indices.map(|index| *index.borrow()).filter(|index| !std::mem::replace(&mut seen[*index], true)).collect()
}

/// Of every link of a way the place of its first part on it; then the number of all parts.
fn places(way: &[usize], parts: &[usize]) -> Vec<usize> {
    let mut next = 0;
    let mut places = vec![0];
    places.extend(way.iter().map(|link| {
        next += parts[*link];
        next
    }));
    places
}

/// What two ways, both from tips to root, share: links that come later have lower indices.
fn meet([one, other]: [&[usize]; 2], [here, there]: [&[usize]; 2], common: &mut Vec<Run>) {
    let (mut i, mut j) = (0, 0);
    while i < one.len() && j < other.len() {
        if one[i] != other[j] {
            i += one[i..].partition_point(|link| *link > other[j]);
            j += one.get(i).map_or(0, |at| other[j..].partition_point(|link| link > at));
            continue;
        }
        let first = [i, j];
        while i < one.len() && j < other.len() && one[i] == other[j] {
            (i, j) = (i + 1, j + 1);
        }
        let places = [here[first[0]], there[first[1]]];
        common.push(Run { places, count: here[i] - places[0] });
    }
}

/// Elements by the reversed rule of Cuthill and McKee: breadth first from one with few neighbours. Those with a link on the
/// ground in common, `roots`, are neighbours.
fn reordered(elements: &[usize], roots: &[Vec<usize>]) -> Vec<usize> {
    let links = elements.iter().flat_map(|e| &roots[*e]).max().map_or(0, |link| link + 1);
    let mut at_link: Vec<Vec<usize>> = vec![Vec::new(); links];
    for (index, element) in elements.iter().enumerate() {
        roots[*element].iter().for_each(|link| at_link[*link].push(index));
    }
    let mut seen = vec![false; elements.len()];
    let degrees: Vec<usize> = elements
        .iter()
        .map(|element| match &roots[*element][..] {
            [] => 0,
            [link] => at_link[*link].len(),
            several => {
                let all = distinct(several.iter().flat_map(|link| &at_link[*link]), &mut seen);
                all.iter().for_each(|index| seen[*index] = false);
                all.len()
            }
        })
        .collect();
    let mut by_degree: Vec<usize> = (0..elements.len()).collect();
    by_degree.sort_by_key(|index| degrees[*index]);
    let mut order = Vec::with_capacity(elements.len());
    for start in by_degree {
        if std::mem::replace(&mut seen[start], true) {
            continue;
        }
        let mut next = order.len();
        order.push(start);
        while next < order.len() {
            // Of a link that was come to, all elements have been seen.
            let links = &roots[elements[order[next]]];
            let mut fresh = distinct(links.iter().flat_map(|link| std::mem::take(&mut at_link[*link])), &mut seen);
            fresh.sort_by_key(|index| (degrees[*index], *index));
            order.append(&mut fresh);
            next += 1;
        }
    }
    order.reverse();
    order.into_iter().map(|index| elements[index]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Loops along a chain, given in a shuffled order: every row's entries stay within the neighbouring loop.
    #[test]
    fn a_chain_of_loops_stays_near_the_diagonal() {
        let loops = 12;
        let shuffled: Vec<usize> = (0..loops).map(|i| (7 * i) % loops).collect();
        let ways: Vec<Vec<usize>> = shuffled.iter().map(|i| vec![2 * i + 3, 2 * i + 2, 2 * i + 1]).collect();
        // None of them goes down to the ground: every link may be where ways meet.
        let plan = Plan::new(vec![vec![0, 1]; loops], &ways, &vec![1; 2 * loops + 2], &vec![true; 2 * loops + 2]);
        for (row, first) in plan.first_columns.iter().enumerate() {
            assert!(row - first <= 3, "row {row} starts at {first}");
        }
    }

    /// Two ways over two branches each share what lies below the tips of both, branch by branch; a link of two parts takes two
    /// places.
    #[test]
    fn ways_share_runs() {
        let (parts, ways) = ([1, 1, 2, 1, 1, 1, 1, 1], [vec![7, 6, 3, 2, 1], vec![6, 5, 4, 2, 1]]);
        let places = [places(&ways[0], &parts), places(&ways[1], &parts)];
        let mut common = Vec::new();
        meet([&ways[0], &ways[1]], [&places[0], &places[1]], &mut common);
        let common: Vec<_> = common.iter().map(|run| (run.places, run.count)).collect();
        assert_eq!(common, [([1, 0], 1), ([3, 3], 3)]);
    }
}
