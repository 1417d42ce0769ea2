//! What is worked out once: the pattern of the matrix, the order in which its entries are come to, and where pairs meet.

use super::{Meeting, Pair, TangentMatrix};
use crate::model::Model;

impl TangentMatrix {
    /// How many entries the upper triangle has at most.
    pub fn most_entries(model: &Model, pairs: &[Pair]) -> usize {
        let mut inboard = vec![0; model.links.len()];
        let mut sum = 0_usize;
        for (index, link) in model.links.iter().enumerate().skip(1) {
            let own = link.joint.counts().1;
            sum = sum.saturating_add(own * inboard[link.parent] + own * (own + 1) / 2);
            inboard[index] = inboard[link.parent] + own;
        }
        let across = |pair: &Pair| {
            let at = meet(model, *pair);
            (inboard[pair.feels] - inboard[at]) * (inboard[pair.moves] - inboard[at])
        };
        pairs.iter().fold(sum, |sum, pair| sum.saturating_add(across(pair)))
    }

    /// Rows and columns in the order in which columns and pairs come to them.
    fn walk(&self, n: usize) -> (Vec<usize>, Vec<[usize; 2]>, Vec<[usize; 2]>) {
        let (mut inboard, mut starts, mut across) = (Vec::new(), vec![0; n + 1], Vec::new());
        for link in 1..self.plan.len() {
            let (first, count) = self.coordinates[link];
            for j in first..first + count {
                let mut at = link;
                while at != 0 {
                    let (first, count) = self.coordinates[at];
                    inboard.extend((first..first + count).map(|i| [i, j]));
                    at = self.parent(at);
                }
                starts[j + 1] = inboard.len();
            }
        }
        for Meeting { pair, link, .. } in &self.meetings {
            let mut b = pair.moves;
            while b != *link {
                for j in self.of_link(b) {
                    let mut a = pair.feels;
                    while a != *link {
                        across.extend(self.of_link(a).map(|i| [i, j]));
                        a = self.parent(a);
                    }
                }
                b = self.parent(b);
            }
        }
        (starts, inboard, across)
    }

    pub(super) fn find_pattern(&mut self, n: usize) {
        let (starts, inboard, across) = self.walk(n);
        let mut columns: Vec<Vec<usize>> = vec![Vec::new(); n];
        for [i, j] in inboard.iter().chain(&across) {
            columns[*i.max(j)].push(*i.min(j));
        }
        self.starts.push(0);
        for column in &mut columns {
            column.sort_unstable();
            column.dedup();
            self.rows.extend_from_slice(column);
            self.starts.push(self.rows.len());
        }
        let place = |[i, j]: &[usize; 2]| {
            let (row, column) = (*i.min(j), *i.max(j));
            let before = columns[column].partition_point(|other| *other < row);
            u32::try_from(2 * (self.starts[column] + before) + usize::from(i > j)).unwrap_or(u32::MAX)
        };
        self.inboard = inboard.iter().map(place).collect();
        self.across = across.iter().map(place).collect();
        self.inboard_starts = starts;
        self.upper = vec![0.0; self.rows.len()];
        self.lower = vec![0.0; self.rows.len()];
    }

    pub(super) fn find_gains(&mut self, n: usize) {
        let mut at: Vec<Vec<usize>> = vec![Vec::new(); n];
        for Meeting { pair, link, .. } in self.meetings.iter().filter(|meeting| meeting.link != 0) {
            for mut end in [pair.feels, pair.moves] {
                while end != *link {
                    self.of_link(end).for_each(|j| at[j].push(*link));
                    end = self.parent(end);
                }
            }
        }
        self.gain_starts.push(0);
        for links in &mut at {
            links.sort_unstable_by(|a, b| b.cmp(a));
            links.dedup();
            self.gain_links.extend_from_slice(links);
            self.gain_starts.push(self.gain_links.len());
        }
        self.column_gains = vec![Default::default(); self.gain_links.len()];
        self.row_gains = vec![Default::default(); self.gain_links.len()];
    }
}

/// The link where the ways of two links to the root meet.
pub(super) fn meet(model: &Model, Pair { feels: mut a, moves: mut b }: Pair) -> usize {
    // Parents come before their children.
    while a != b {
        if a > b { a = model.links[a].parent } else { b = model.links[b].parent }
    }
    a
}
