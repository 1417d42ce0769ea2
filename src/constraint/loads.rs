//! What rows push on links and hinges; of redundant rows, the least that balances.

use super::depend::{Dependence, Sparse};
use super::row::{Ends, Rule};
use super::{Constraints, Owner, RowGroup};
use crate::model::Model;
use crate::motion::Motion;
use crate::motion::variation::LinkVariation;
use crate::spatial::Wrench;
use crate::transfer::Reduction;
use nalgebra::{DMatrix, DVector, Vector3};

/// Least coefficient of a linearly dependent row: one whose coefficients are all smaller depends on none, its own part in the motion
/// is zero.
/// Axes that are parallel to five digits count as parallel (see `rank`), and leave as much.
const PART: f64 = 1e-4;

/// What a loop passes to the body of its second end.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopReaction {
    /// Name of the loop.
    pub name: String,
    /// On the body of the second end, inertial axes (N). Its opposite acts on the first.
    pub force: Vector3<f64>,
    /// Moment on the body of the second end, about that end, inertial axes (N m).
    pub moment: Vector3<f64>,
    /// What pulls the ends together along the line between them (N); of a rod, whose only load it is.
    pub pull: Option<f64>,
    /// Widest gap (m; rad times the reach of the mechanism).
    pub gap: f64,
    /// Whether nothing else balances: false if rows are redundant. Of all reactions that do, this one is the smallest.
    pub unique: bool,
    /// Bodies whose hinges lie between the ends of the loop: what these pass is not unique either where the loop's is not.
    pub around: Vec<usize>,
}

impl Constraints {
    /// Calls `push` with every row that may push, and its element.
    fn each_pushing(&self, mut push: impl FnMut(&RowGroup, usize)) {
        if self.is_shared {
            self.elements.iter().for_each(|element| element.rows.clone().for_each(|row| push(element, row)));
        } else {
            for group in &self.plan.groups {
                let element = &self.elements[group.element];
                group.rows.iter().for_each(|row| push(element, *row));
            }
        }
    }

    /// Adds what the multipliers push to the links' wrenches and to the hinge forces.
    pub(crate) fn add_loads(&self, wrenches: &mut [Wrench], tau: &mut [f64]) {
        self.each_pushing(|element, row| {
            let multiplier = self.multipliers[row];
            if let Some(ends) = &element.ends {
                for (end, w) in ends.iter().zip(&self.placed[row].wrenches) {
                    let link = &mut wrenches[end.link];
                    link.force += multiplier * w.force;
                    link.moment += multiplier * w.moment;
                }
            }
            if let Rule::Motion { parts } = &self.rules[row] {
                parts.iter().for_each(|(scalar, factor)| tau[scalar.velocity] += factor * multiplier);
            }
        });
    }

    /// Adds what the multipliers push to the named bodies of the loops' ends, at the root markers of their links.
    pub(crate) fn add_to_bodies(&self, wrenches: &mut [Wrench]) {
        self.each_pushing(|element, row| {
            let Some(ends) = &element.ends else { return };
            for (end, w) in ends.iter().zip(&self.placed[row].wrenches) {
                if let Some(body) = end.body {
                    wrenches[body].force += self.multipliers[row] * w.force;
                    wrenches[body].moment += self.multipliers[row] * w.moment;
                }
            }
        });
    }

    /// Adds how the wrenches of [`Constraints::add_loads`], taken as applied ones, vary with the links at fixed
    /// multipliers.
    pub(crate) fn add_variation(&self, motion: &Motion, by: &[LinkVariation], wrenches: &mut [Wrench]) {
        for (index, element) in self.elements.iter().enumerate() {
            let Some(ends) = &element.ends else { continue };
            for (end, w) in ends.iter().zip(self.vary_loop(index, motion, by)) {
                wrenches[end.link] += w;
            }
        }
    }

    /// How the wrenches of one loop vary with its links at fixed multipliers.
    pub(crate) fn vary_loop(&self, index: usize, motion: &Motion, by: &[LinkVariation]) -> [Wrench; 2] {
        let mut sum = [Wrench::ZERO; 2];
        let element = &self.elements[index];
        let Some(ends) = &element.ends else { return sum };
        let geometry = Ends::of(ends, &element.branches, motion);
        let links = [&by[ends[0].link], &by[ends[1].link]];
        for row in element.rows.clone().filter(|row| self.multipliers[*row] != 0.0) {
            for (sum, w) in sum.iter_mut().zip(geometry.vary(&self.rules[row], links)) {
                sum.force += self.multipliers[row] * w.force;
                sum.moment += self.multipliers[row] * w.moment;
            }
        }
        sum
    }

    /// Power that drives put in at the last solution (W), with the accelerations that belong to it.
    pub fn power(&self, model: &Model, accelerations: &[f64]) -> f64 {
        let speed = |(element, _): (&RowGroup, usize)| -self.placed[element.rows.start].drift;
        self.driven().map(speed).zip(self.drive_pushes(model, accelerations)).map(|(speed, push)| speed * push).sum()
    }

    /// What drives push with at the last solution, in the order of the model (N or N m), with the accelerations that belong to
    /// it: the multipliers without what the drives' own armatures take.
    pub(crate) fn drive_pushes(&self, model: &Model, accelerations: &[f64]) -> impl Iterator<Item = f64> {
        let push = |(element, index): (&RowGroup, usize)| {
            let drive = &model.drives[index];
            self.multipliers[element.rows.start] - drive.armature * accelerations[drive.coordinate.velocity]
        };
        self.driven().map(push)
    }

    /// Rows of drives, and their indices in the model.
    fn driven(&self) -> impl Iterator<Item = (&RowGroup, usize)> {
        self.elements.iter().filter_map(|element| match element.owner {
            Owner::Drive(index) => Some((element, index)),
            _ => None,
        })
    }

    /// What gears push with on the first of their coordinates (N or N m), and their gaps (m or rad), in the order of the
    /// model.
    pub(crate) fn gear_pushes(&self) -> impl Iterator<Item = [f64; 2]> {
        let geared = self.elements.iter().filter(|element| matches!(element.owner, Owner::Gear(_)));
        geared.map(|element| [self.multipliers[element.rows.start], self.placed[element.rows.start].gap])
    }

    /// Of all multipliers that balance what the last ones do, takes the smallest: the least sum of squares, moments
    /// divided by the span of their component. `all` are the same rows, none left out. At the position of the tree's last
    /// factorization.
    ///
    /// ```text
    /// G_d = C G_i      the rows left out, by those solved for: C of `depend`
    /// λ_i ← λ_i − Cᵀ z,   λ_d = z,   (1 + C Cᵀ) z = C λ_i
    /// ω = (−Cᵀ e, e)   self-stresses, Gᵀ ω = 0, one for each row left out
    /// ```
    pub(crate) fn share(&mut self, all: &mut Self, model: &Model, motion: &Motion, reduction: &Reduction, q: &[f64]) {
        self.clear_shares();
        if self.rank() == self.rules.len() {
            return;
        }
        if self.rules.len() > self.independent.len() || self.rules.len() != all.rules.len() {
            // Coordinates that stops hold come and go.
            *all = self.clone();
            all.keep(|_| true);
        }
        self.place(model, motion, q, false);
        all.set_time(self.time);
        all.place(model, motion, q, true);
        let mut unknown = vec![0; self.rules.len()];
        all.plan.rows().enumerate().for_each(|(index, row)| unknown[row] = index);
        let solved: Vec<usize> = self.plan.rows().collect();
        let unknowns: Vec<usize> = solved.iter().map(|row| unknown[*row]).collect();
        let sparse = if self.is_wide() { Sparse::new(all, model, motion, &unknowns) } else { None };
        if sparse.is_none() {
            self.factorize(model, motion, reduction, 0.0);
            all.assemble(model, motion, reduction);
            all.size_rows();
        }
        let mut left_out = vec![true; self.rules.len()];
        solved.iter().for_each(|row| left_out[*row] = false);
        let redundant: Vec<usize> = (0..self.rules.len()).filter(|row| left_out[*row]).collect();
        redundant.iter().for_each(|row| self.not_unique[*row] = true);
        let dependence = match sparse {
            Some(sparse) => Dependence::Coordinates(Box::new(sparse)),
            None => Dependence::Inertia { kept: self, all },
        };
        let mut self_stresses = Vec::new();
        // By rows, in the units of the sum of squares.
        let (mut dependent, mut parts) = (Vec::new(), Vec::new());
        for row in redundant {
            let own = unknown[row];
            let mut stress = vec![(row, self.weights[row])];
            if !dependence.is_nothing(own) {
                let part = dependence.part((row, own), &solved, &unknowns);
                if part.iter().any(|part| part.abs() > PART) {
                    stress.extend(part.iter().zip(&solved).map(|(part, row)| (*row, -part * self.weights[*row])));
                    dependent.push(row);
                    parts.push(part);
                }
            }
            self_stresses.push(stress);
        }
        self.self_stresses = self_stresses;
        self.take_shares(&solved, &dependent, &parts);
    }

    /// The smallest multipliers, by the rows `parts` of C of the rows that depend on those solved for.
    fn take_shares(&mut self, solved: &[usize], redundant: &[usize], parts: &[Vec<f64>]) {
        let matrix = DMatrix::from_fn(redundant.len(), solved.len(), |d, i| parts[d][i]);
        let carried =
            DVector::from_iterator(solved.len(), solved.iter().map(|row| self.multipliers[*row] / self.weights[*row]));
        let normal = DMatrix::identity(redundant.len(), redundant.len()) + &matrix * matrix.transpose();
        let Some(factors) = normal.cholesky().filter(|_| !redundant.is_empty()) else { return };
        let share = factors.solve(&(&matrix * &carried));
        let carried = carried - matrix.tr_mul(&share);
        if !carried.iter().chain(share.iter()).all(|x| x.is_finite()) {
            return;
        }
        self.remember_unshared();
        for (rows, numbers) in [(solved, &carried), (redundant, &share)] {
            rows.iter().zip(numbers.iter()).for_each(|(row, x)| self.multipliers[*row] = x * self.weights[*row]);
        }
        for (i, row) in solved.iter().enumerate() {
            self.not_unique[*row] = parts.iter().any(|part| part[i].abs() > PART);
        }
    }

    /// Marks the rows solved for whose clearance at the last factorization is not above a limit, and takes their
    /// multipliers as zero.
    pub(crate) fn drop_weak(&mut self, limit: f64, weak: &mut [bool]) {
        for (unknown, (row, weak)) in self.plan.rows().zip(weak).enumerate() {
            *weak = !(self.matrix.pivot(unknown, self.sizes[unknown]) > limit * limit);
            if *weak {
                self.multipliers[row] = 0.0;
            }
        }
    }

    /// Takes these as the multipliers, one per row solved for.
    pub(crate) fn set_multipliers(&mut self, unknowns: &[f64]) {
        if self.is_shared {
            self.clear_shares();
        }
        for (unknown, row) in unknowns.iter().zip(self.plan.rows()) {
            self.multipliers[row] = *unknown;
        }
    }

    /// From here on rows that are left out push, too.
    fn remember_unshared(&mut self) {
        if !self.is_shared {
            self.unshared.clone_from(&self.multipliers);
            self.is_shared = true;
        }
    }

    /// Rows that are left out push nothing again, those solved for all of the load.
    pub(super) fn clear_shares(&mut self) {
        if self.is_shared {
            self.multipliers.clone_from(&self.unshared);
            self.is_shared = false;
        }
        self.not_unique.fill(false);
    }

    /// Rows that are left out as linearly dependent on others.
    pub(crate) fn left_out(&self) -> usize {
        self.rules.len() - self.rank()
    }

    /// The self-stresses found by [`Constraints::share`].
    pub(crate) fn self_stresses(&self) -> usize {
        self.self_stresses.len()
    }

    /// The loops, drives and gears in whose rows the `j`-th self-stress is, by name.
    pub(crate) fn stressed(&self, j: usize) -> Vec<String> {
        let Some(stress) = self.self_stresses.get(j) else { return Vec::new() };
        let push = |(row, x): &(usize, f64)| (x / self.weights[*row]).abs();
        let most = stress.iter().map(push).fold(0.0, f64::max);
        let is_in =
            |element: &&RowGroup| stress.iter().any(|one| element.rows.contains(&one.0) && push(one) > PART * most);
        self.elements.iter().filter(is_in).map(|element| element.name.clone()).collect()
    }

    /// Adds self-stresses, one number for each (N or N m at the row left out), to multipliers that are shared.
    pub(crate) fn add_self_stress(&mut self, alpha: &[f64]) {
        self.remember_unshared();
        for (stress, alpha) in self.self_stresses.iter().zip(alpha) {
            stress.iter().for_each(|(row, x)| self.multipliers[*row] += alpha * x);
        }
    }

    /// The root of the sum of squares of all multipliers, moments divided by the span of their component (N).
    pub(crate) fn multiplier_size(&self) -> f64 {
        self.multipliers.iter().zip(&self.weights).map(|(x, weight)| (x / weight).powi(2)).sum::<f64>().sqrt()
    }

    /// Marks rows solved for whose multipliers are not unique, as something beside the rows bears with them.
    pub(crate) fn share_with_others(&mut self, shares: &[bool]) {
        for (row, shares) in self.plan.rows().zip(shares) {
            self.not_unique[row] |= *shares;
        }
    }

    /// Whether rows that are left out of the solution push, after [`Constraints::share`].
    pub(crate) fn is_shared(&self) -> bool {
        self.is_shared
    }

    /// What the loops pass, after [`Constraints::share`] and with all rows placed where the motion is.
    pub(crate) fn loop_reactions(&self, model: &Model, motion: &Motion) -> Vec<LoopReaction> {
        let of_loop = |element: &RowGroup| {
            let (Owner::Loop(index), Some(ends)) = (element.owner, &element.ends) else { return None };
            let mut sum = Wrench::ZERO;
            for row in element.rows.clone() {
                let w = &self.placed[row].wrenches[1];
                sum.force += self.multipliers[row] * w.force;
                sum.moment += self.multipliers[row] * w.moment;
            }
            let at_end = sum.shifted(-(motion.links[ends[1].link].turn * ends[1].point));
            let is_rod = matches!(self.rules[element.rows.start..], [Rule::Distance { .. }, ..]);
            let links = element.branches.iter().flatten();
            let mut around: Vec<usize> = links.map(|link| model.links[*link].body).collect();
            around.sort_unstable();
            around.dedup();
            Some(LoopReaction {
                name: model.loops[index].name.clone(),
                force: at_end.force,
                moment: at_end.moment,
                pull: is_rod.then(|| -self.multipliers[element.rows.start]),
                gap: element.rows.clone().map(|row| self.reaches[row] * self.relative_gap(row)).fold(0.0, f64::max),
                unique: !element.rows.clone().any(|row| self.not_unique[row]),
                around,
            })
        };
        self.elements.iter().filter_map(of_loop).collect()
    }
}
