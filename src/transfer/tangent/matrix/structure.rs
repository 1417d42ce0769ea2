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
    fn walk(&self, n: usize) -> (Vec<usize>, Vec<[u32; 2]>, Vec<[u32; 2]>) {
        let (mut inboard, mut starts, mut across) = (Vec::new(), vec![0; n + 1], Vec::new());
        for link in 1..self.plan.len() {
            let (first, count) = self.coordinates[link];
            for j in first..first + count {
                let mut at = link;
                while at != 0 {
                    let (first, count) = self.coordinates[at];
                    inboard.extend((first..first + count).map(|i| [i as u32, j as u32]));
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
                        across.extend(self.of_link(a).map(|i| [i as u32, j as u32]));
                        a = self.parent(a);
                    }
                }
                b = self.parent(b);
            }
        }
        (starts, inboard, across)
    }

    /// The pattern, and the place of every entry that columns and pairs come to: these are many more than there are places
    /// where pairs couple long branches, so they are sorted by columns alone.
    pub(super) fn find_pattern(&mut self, n: usize) {
        let (starts, inboard, across) = self.walk(n);
        let entries = || inboard.iter().chain(&across).map(|[i, j]| (i.min(j), i.max(j), i > j));
        let mut begins = vec![0; n + 1];
        entries().for_each(|(_, column, _)| begins[*column as usize + 1] += 1);
        (0..n).for_each(|j| begins[j + 1] += begins[j]);
        let (mut next, mut by_column) = (begins.clone(), vec![(0_u32, 0_u32, false); inboard.len() + across.len()]);
        for (index, (row, column, below)) in entries().enumerate() {
            let at = &mut next[*column as usize];
            by_column[*at] = (index as u32, *row, below);
            *at += 1;
        }
        let (mut seen, mut place_of) = (vec![usize::MAX; n], vec![0; n]);
        let mut places = vec![0; by_column.len()];
        self.starts.push(0);
        for column in 0..n {
            let (own, first) = (&by_column[begins[column]..begins[column + 1]], self.rows.len());
            for row in own.iter().map(|(_, row, _)| *row as usize) {
                if std::mem::replace(&mut seen[row], column) != column {
                    self.rows.push(row);
                }
            }
            self.rows[first..].sort_unstable();
            self.rows[first..].iter().enumerate().for_each(|(k, row)| place_of[*row] = first + k);
            for (index, row, below) in own {
                places[*index as usize] =
                    u32::try_from(2 * place_of[*row as usize] + usize::from(*below)).unwrap_or(u32::MAX);
            }
            self.starts.push(self.rows.len());
        }
        self.across = places.split_off(inboard.len());
        self.inboard = places;
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
