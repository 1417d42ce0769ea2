//! Which rows are independent: decided on closed positions, by a pivoted factorization of `A`.
//!
//! A row that hangs on others keeps a pivot of the size of round-off. It is looked for at the position itself and at
//! closed positions around it: at a singular position (a change point, a dead centre) rows hang on each other that do
//! not elsewhere, and those have to be kept.

use super::Constraints;
use super::close::Closing;
use super::rows::Owner;
use crate::model::{Joint, Model};

/// A pivot below this part of the row's own entry, and an entry below this part of the largest of its element, counts as
/// zero: axes that are parallel to five digits are meant to be parallel.
const DEPENDENT: f64 = 1e-10;
/// How far around the position is looked (rad; part of the scene's length).
const AROUND: f64 = 0.05;

/// What was decided.
#[derive(Debug, Clone)]
pub(super) struct Ranking {
    /// Per row.
    pub(super) independent: Vec<bool>,
    /// At the position itself fewer rows are independent than around it.
    pub(super) singular: bool,
}

/// Decides at a closed position, at the time of the drives.
pub(super) fn decide(model: &Model, q: &[f64], time: f64) -> Ranking {
    let mut closing = Closing::new(model, &[], time);
    let here = independent_at(model, &mut closing, q);
    let mut best = here.clone();
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for _ in 0..2 {
        let mut near = q.to_vec();
        let step = random.step(model);
        crate::motion::displace(model, &mut near, &step);
        let metric = closing.nearby();
        let closed = matches!(closing.close(&mut near, metric), Ok(gap) if gap <= 1e-9 * model.length_scale());
        if closed {
            let there = independent_at(model, &mut closing, &near);
            if count(&there) > count(&best) {
                best = there;
            }
        }
    }
    let singular = count(&best) > count(&here);
    let independent = if singular { best } else { here };
    Ranking { independent, singular }
}

fn count(rows: &[bool]) -> usize {
    rows.iter().filter(|row| **row).count()
}

/// Independent rows at one position; none where the tree itself is singular there.
fn independent_at(model: &Model, closing: &mut Closing<'_>, q: &[f64]) -> Vec<bool> {
    closing.gap(q);
    if !closing.prepare() {
        return vec![false; closing.rows.rules.len()];
    }
    closing.rows.assemble(model, &closing.motion, &closing.reduction);
    closing.rows.independent_now()
}

impl Constraints {
    /// Independent rows among all, from the matrix as assembled: loops first, then gears, drives last.
    pub(super) fn independent_now(&self) -> Vec<bool> {
        let rows: Vec<usize> = self.plan.rows().collect();
        let mut kept = vec![false; self.rules.len()];
        for component in self.components() {
            let unknowns: Vec<usize> = component
                .iter()
                .flat_map(|group| {
                    let group = &self.plan.groups[*group];
                    group.first..group.first + group.rows.len()
                })
                .collect();
            self.choose(&unknowns, &rows, &mut kept);
        }
        kept
    }

    /// Groups that meet, directly or through others.
    fn components(&self) -> Vec<Vec<usize>> {
        let mut root: Vec<usize> = (0..self.plan.groups.len()).collect();
        let find = |root: &[usize], mut at: usize| {
            while root[at] != at {
                at = root[at];
            }
            at
        };
        for meeting in &self.plan.meetings {
            let [a, b] = meeting.groups.map(|group| find(&root, group));
            root[a.max(b)] = a.min(b);
        }
        let mut components: Vec<Vec<usize>> = vec![Vec::new(); root.len()];
        for group in 0..root.len() {
            components[find(&root, group)].push(group);
        }
        components.retain(|component| !component.is_empty());
        components
    }

    /// Cholesky with the largest pivot first, within one component.
    fn choose(&self, unknowns: &[usize], rows: &[usize], kept: &mut [bool]) {
        let weight = |unknown: usize| self.weights[rows[unknown]];
        let entry = |i: usize, j: usize| {
            let (i, j) = (unknowns[i], unknowns[j]);
            weight(i) * weight(j) * self.matrix.get(i, j)
        };
        let n = unknowns.len();
        let own: Vec<f64> = (0..n).map(|i| entry(i, i)).collect();
        let rank_of = |i: usize| self.element_of(rows[unknowns[i]]).map_or(0, |element| element.class());
        let classes: Vec<usize> = (0..n).map(rank_of).collect();
        let element: Vec<usize> = (0..n).map(|i| self.element_index(rows[unknowns[i]])).collect();
        let largest = |i: usize| {
            let same = (0..n).filter(|j| element[*j] == element[i]);
            same.map(|j| own[j]).fold(0.0, f64::max)
        };
        let floor: Vec<f64> = (0..n).map(|i| DEPENDENT * largest(i)).collect();
        let mut pivots = own.clone();
        // By rows, what is not zero: chains of loops leave little.
        let mut factor: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n];
        let mut of_next = vec![0.0; n];
        let mut steps = 0;
        let mut open: Vec<usize> = (0..n).filter(|i| own[*i] > floor[*i] && own[*i] > 0.0).collect();
        while !open.is_empty() {
            open.retain(|i| pivots[*i] > DEPENDENT * own[*i]);
            let Some(class) = open.iter().map(|i| classes[*i]).min() else { return };
            let candidates = open.iter().copied().filter(|i| classes[*i] == class);
            let Some(next) = candidates.max_by(|a, b| pivots[*a].total_cmp(&pivots[*b])) else { return };
            kept[rows[unknowns[next]]] = true;
            open.retain(|i| *i != next);
            let root = pivots[next].sqrt();
            of_next.fill(0.0);
            factor[next].iter().for_each(|(step, l)| of_next[*step] = *l);
            for i in &open {
                let known: f64 = factor[*i].iter().map(|(step, l)| l * of_next[*step]).sum();
                let l = (entry(*i, next) - known) / root;
                if l != 0.0 {
                    factor[*i].push((steps, l));
                    pivots[*i] -= l * l;
                }
            }
            steps += 1;
        }
    }

    fn element_index(&self, row: usize) -> usize {
        self.elements.iter().position(|element| element.rows.contains(&row)).unwrap_or(0)
    }
}

impl super::Element {
    /// What is chosen before what.
    fn class(&self) -> usize {
        match self.owner {
            Owner::Loop(_) => 0,
            Owner::Gear(_) => 1,
            Owner::Drive(_) => 2,
            Owner::Held(_) => 3,
        }
    }
}

/// Numbers without a pattern, the same in every run (xorshift).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn step(&mut self, model: &Model) -> Vec<f64> {
        let mut step = vec![0.0; model.velocity_count()];
        let length = model.length_scale();
        for link in &model.links {
            let per = if matches!(link.joint, Joint::Slide { .. }) { AROUND * length } else { AROUND };
            let (_, count) = link.joint.counts();
            step[link.velocity..link.velocity + count].iter_mut().for_each(|x| *x = per * self.next());
        }
        step
    }
}
