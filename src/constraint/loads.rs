//! What multipliers push with: on links, in coordinates, on named bodies; and of many that do the same, the least.
//!
//! Rows left out hang on those solved for, `G_d = C G_k` with `C = G_d M⁻¹ G_kᵀ A⁻¹`. So multipliers `λ_k − Cᵀ μ` and `μ`
//! push the tree as `λ_k` and 0 do, whatever μ is: reactions of such rows are not unique. The smallest ones, moments
//! weighed as forces at the scene's length (`W`), solve
//!
//! ```text
//! (W_d + C W_k Cᵀ) μ = C W_k λ_k
//! ```

use super::row::{Ends, Rule};
use super::rows::Owner;
use super::{Constraints, Rate};
use crate::model::Model;
use crate::motion::Motion;
use crate::motion::variation::LinkVariation;
use crate::spatial::Wrench;
use crate::transfer::Reduction;
use nalgebra::{DMatrix, DVector, Vector3};

/// A smaller part of a row in another is round-off.
const ALONE: f64 = 1e-7;

/// What a loop passes from its first to its second body.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopReaction {
    /// Name of the loop.
    pub name: String,
    /// On the second body at its end of the loop, inertial axes (N).
    pub force: Vector3<f64>,
    /// The same (N m).
    pub moment: Vector3<f64>,
    /// Whether no other reactions would do; of many these are the smallest.
    pub unique: bool,
    /// Widest gap (m; rad times the scene's length).
    pub gap: f64,
}

impl Constraints {
    /// Adds what the multipliers push to the links' wrenches and to the hinge forces.
    pub(crate) fn add_loads(&self, wrenches: &mut [Wrench], tau: &mut [f64]) {
        for element in &self.elements {
            for row in self.pushing(element.rows.clone()) {
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
            }
        }
    }

    /// Whether rows that are left out push since multipliers have been shared.
    pub(crate) fn is_shared(&self) -> bool {
        self.shared.contains(&true)
    }

    fn pushing(&self, rows: std::ops::Range<usize>) -> impl Iterator<Item = usize> {
        rows.filter(|row| self.multipliers[*row] != 0.0)
    }

    /// Adds what the multipliers push to the named bodies of the loops' ends, at the root markers of their links.
    pub(crate) fn add_to_bodies(&self, wrenches: &mut [Wrench]) {
        for element in &self.elements {
            let Some(ends) = &element.ends else { continue };
            for row in self.pushing(element.rows.clone()) {
                for (end, w) in ends.iter().zip(&self.placed[row].wrenches) {
                    if let Some(body) = end.body {
                        wrenches[body].force += self.multipliers[row] * w.force;
                        wrenches[body].moment += self.multipliers[row] * w.moment;
                    }
                }
            }
        }
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
        for row in self.pushing(element.rows.clone()) {
            for (sum, w) in sum.iter_mut().zip(geometry.vary(&self.rules[row], links)) {
                sum.force += self.multipliers[row] * w.force;
                sum.moment += self.multipliers[row] * w.moment;
            }
        }
        sum
    }

    /// The drives and what each pushes at the last solution (N or N m).
    pub fn drive_forces(&self) -> impl Iterator<Item = (String, f64)> {
        self.coordinate_forces(|owner| matches!(owner, Owner::Drive(_)))
    }

    /// The gears and what each pushes in its first coordinate at the last solution (N or N m).
    pub fn gear_forces(&self) -> impl Iterator<Item = (String, f64)> {
        self.coordinate_forces(|owner| matches!(owner, Owner::Gear(_)))
    }

    fn coordinate_forces(&self, wanted: impl Fn(Owner) -> bool) -> impl Iterator<Item = (String, f64)> {
        self.elements.iter().filter(move |element| wanted(element.owner)).map(|element| {
            let name = element.name.split('`').nth(1).unwrap_or_default();
            (name.to_owned(), self.multipliers[element.rows.start])
        })
    }

    /// Power that drives put in at the last solution (W).
    pub fn power(&self) -> f64 {
        let driven = self.elements.iter().filter(|element| matches!(element.owner, Owner::Drive(_)));
        driven.map(|element| -self.multipliers[element.rows.start] * self.placed[element.rows.start].drift).sum()
    }

    /// What the loops pass, of the last multipliers and the last placement of all rows.
    pub fn loop_reactions(&self, model: &Model, motion: &Motion) -> Vec<LoopReaction> {
        let of_loop = |(closed, element): (&crate::model::Loop, &super::Element)| {
            let (end, mut sum, mut gap) = (&closed.ends[1], Wrench::ZERO, 0.0_f64);
            for row in element.rows.clone() {
                let w = &self.placed[row].wrenches[1];
                sum.force += self.multipliers[row] * w.force;
                sum.moment += self.multipliers[row] * w.moment;
                gap = gap.max(self.weights[row] * self.rate(row, element.links(), motion, Rate::Gap).abs());
            }
            let arm = motion.links[end.link].turn * end.point;
            let at_end = sum.shifted(-arm);
            let unique = element.rows.clone().all(|row| !self.shared[row]);
            LoopReaction { name: closed.name.clone(), force: at_end.force, moment: at_end.moment, unique, gap }
        };
        // Loops come first among the elements.
        model.loops.iter().zip(&self.elements).map(of_loop).collect()
    }

    /// Spreads the multipliers of the last solution over rows that hang on each other; `all` are the same rows with none
    /// left out.
    pub(crate) fn share(&mut self, all: &mut Self, model: &Model, motion: &Motion, reduction: &Reduction, q: &[f64]) {
        self.shared.fill(false);
        let kept: Vec<usize> = self.plan.rows().collect();
        let mut place = vec![usize::MAX; self.rules.len()];
        all.plan.rows().enumerate().for_each(|(unknown, row)| place[row] = unknown);
        let dropped: Vec<usize> = (0..self.rules.len()).filter(|row| !kept.contains(row)).collect();
        if dropped.is_empty() {
            return;
        }
        all.time = self.time;
        all.place(model, motion, q, true);
        all.assemble(model, motion, reduction);
        let weight = |row: usize| 1.0 / (self.weights[row] * self.weights[row]);
        let mut parts = DMatrix::zeros(dropped.len(), kept.len());
        for (d, row) in dropped.iter().enumerate() {
            let mut part: Vec<f64> = kept.iter().map(|other| all.matrix.get(place[*row], place[*other])).collect();
            self.matrix.solve(&mut part);
            part.iter().enumerate().for_each(|(k, x)| parts[(d, k)] = *x);
        }
        let weights = DVector::from_iterator(kept.len(), kept.iter().map(|row| weight(*row)));
        let known = DVector::from_iterator(kept.len(), kept.iter().map(|row| self.multipliers[*row]));
        let mut matrix = &parts * DMatrix::from_diagonal(&weights) * parts.transpose();
        dropped.iter().enumerate().for_each(|(d, row)| matrix[(d, d)] += weight(*row));
        let Some(factor) = matrix.cholesky() else { return };
        let mu = factor.solve(&(&parts * weights.component_mul(&known)));
        let taken = parts.transpose() * &mu;
        for (d, row) in dropped.iter().enumerate() {
            self.multipliers[*row] = mu[d];
            self.shared[*row] = true;
            self.placed[*row] = all.placed[*row];
        }
        for (k, row) in kept.iter().enumerate() {
            self.multipliers[*row] -= taken[k];
            let part = |d: usize| parts[(d, k)].abs() * (weight(*row) / weight(dropped[d])).sqrt();
            self.shared[*row] = (0..dropped.len()).any(|d| part(d) > ALONE);
        }
    }
}
