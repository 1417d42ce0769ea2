//! Dense derivatives: mass, damping and stiffness matrices (docs/guide/method.md: the transfer equations
//! differentiated column by column).

use super::applied;
use super::{Evaluated, Fault};
use crate::force::Act;
use crate::motion::variation::Direction;
use faer::Mat;
use std::ops::Range;

/// Derivatives of the residual `M a + b − τ`, n×n each, in velocity coordinates.
#[derive(Debug, Clone)]
pub struct Linearization {
    /// ∂/∂q at fixed accelerations: at rest in equilibrium the Hessian of the potential.
    pub stiffness: Mat<f64>,
    /// ∂/∂q̇.
    pub damping: Mat<f64>,
    /// ∂/∂q̈.
    pub mass: Mat<f64>,
}

/// Which of the three a column belongs to.
#[derive(Clone, Copy)]
pub(super) enum Of {
    Position,
    Velocity,
    Acceleration,
}

impl Evaluated<'_> {
    /// Mass, damping and stiffness matrices at a state with hinge accelerations `a`.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub fn linearize(&mut self, a: &[f64]) -> Result<Linearization, Fault> {
        self.balance(a)?;
        Ok(Linearization {
            stiffness: self.columns(a, Of::Position),
            damping: self.columns(a, Of::Velocity),
            mass: self.columns(a, Of::Acceleration),
        })
    }

    /// The stiffness matrix alone, at rest or in a steady motion: without accelerations.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub fn stiffness(&mut self) -> Result<Mat<f64>, Fault> {
        let rest = vec![0.0; self.system.model.velocity_count()];
        self.balance(&rest)?;
        Ok(self.columns(&rest, Of::Position))
    }

    /// `K Z` at rest or in a steady motion: one sweep for each column of `Z`.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub fn stiffness_times(&mut self, z: &Mat<f64>) -> Result<Mat<f64>, Fault> {
        let n = self.system.model.velocity_count();
        let rest = vec![0.0; n];
        let mut column = rest.clone();
        self.balance(&rest)?;
        let mut product = Mat::zeros(n, z.ncols());
        let mut direction = rest.clone();
        for j in 0..z.ncols() {
            (0..n).for_each(|i| direction[i] = z[(i, j)]);
            column.fill(0.0);
            let by = Direction { position: &direction, ..Direction::default() };
            self.column(&rest, &by, 1..self.system.model.links.len(), &mut column);
            (0..n).for_each(|i| product[(i, j)] = column[i]);
        }
        Ok(product)
    }

    /// One matrix, column by column, after [`Evaluated::balance`] with these accelerations.
    pub(super) fn columns(&mut self, a: &[f64], of: Of) -> Mat<f64> {
        let n = self.system.model.velocity_count();
        let mut matrix = Mat::zeros(n, n);
        let mut unit = vec![0.0; n];
        let mut column = vec![0.0; n];
        for link in 1..self.system.model.links.len() {
            let (first, (_, count)) =
                (self.system.model.links[link].velocity, self.system.model.links[link].joint.counts());
            for j in first..first + count {
                unit[j] = 1.0;
                column.fill(0.0);
                let by = match of {
                    Of::Position => Direction { position: &unit, ..Direction::default() },
                    Of::Velocity => Direction { velocity: &unit, ..Direction::default() },
                    Of::Acceleration => Direction { acceleration: &unit, ..Direction::default() },
                };
                self.column(a, &by, link..self.system.model.links[link].subtree_end, &mut column);
                unit[j] = 0.0;
                for (i, x) in column.iter().enumerate() {
                    matrix[(i, j)] = *x;
                }
            }
        }
        matrix
    }

    /// The residual's variation when hinges of one subtree vary: it moves, and the way to the root feels it. Forces
    /// between bodies reach further.
    pub(super) fn column(&mut self, a: &[f64], by: &Direction<'_>, subtree: Range<usize>, out: &mut [f64]) {
        let (model, motion, balance) = (&self.system.model, &self.system.motion, &self.system.balance);
        self.system.variation.outward_subtree(model, motion, balance, a, by, subtree.clone());
        let constrained = self.system.constraints.is_some();
        let forces = (!model.forces.is_empty() || constrained) && !(by.position.is_empty() && by.velocity.is_empty());
        if forces {
            applied::vary(&self.system.laws, motion, &self.system.variation.links, &mut self.system.variation.applied);
        }
        if forces && constrained {
            let mut applied = std::mem::take(&mut self.system.variation.applied);
            self.system.vary_multipliers(&self.system.variation.links, &mut applied);
            self.system.variation.applied = applied;
        }
        let (motion, balance) = (&self.system.motion, &self.system.balance);
        if forces && (constrained || model.forces.iter().any(|force| reaches_far(&force.law))) {
            self.system.variation.inward(model, motion, balance, by, out);
        } else {
            self.system.variation.inward_subtree(model, motion, balance, by, subtree.clone(), out);
        }
        if forces {
            self.system.variation.applied.fill(crate::spatial::Wrench::ZERO);
        }
        self.system.variation.clear(subtree);
        applied::hinge::vary(model, self.q, by.position, by.velocity, &mut self.system.scratch);
        applied::motor::vary(model, &self.system.pushes, by.position, by.velocity, &mut self.system.scratch);
        for (out, change) in out.iter_mut().zip(&self.system.scratch) {
            *out -= change;
        }
    }
}

/// Whether a force element can load a link that does not move itself.
fn reaches_far(law: &impl Act) -> bool {
    law.ends().iter().filter(|end| end.link != 0).count() > 1
}
