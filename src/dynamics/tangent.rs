//! The tangent of a system with its forces: gathers what the sweep of [`crate::transfer::tangent`] needs.

use super::{Fault, System};
use crate::forces;
use crate::model::{Joint, Model};
use crate::motion::variation::LinkVariation;
use crate::transfer::tangent::{At, Blocks, Breakdown, Tangent};
use nalgebra::{Matrix3, Vector3};

/// A factorized tangent: solves `(c₂ M + c₁ C + K) x = rhs` in O(n). Valid until the next factorization, whatever the
/// system evaluates in between.
#[derive(Debug, Clone)]
pub struct TangentSolver {
    tangent: Tangent,
    diagonal: Vec<f64>,
    shifted: Vec<f64>,
    applied: Vec<(usize, Blocks)>,
    ball_springs: Vec<(usize, Matrix3<f64>)>,
    unit: Vec<LinkVariation>,
}

/// Coefficients of a tangent.
#[derive(Debug, Clone, Copy, Default)]
pub struct Coefficients<'a> {
    /// Factor of the damping matrix (1/s).
    pub c1: f64,
    /// Factor of the mass matrix (1/s²).
    pub c2: f64,
    /// Added to the diagonal; infinite for a coordinate that is held. Empty for nothing.
    pub shift: &'a [f64],
    /// Stop at the first pivot that is not positive.
    pub definite: bool,
    /// Take the symmetric part: off equilibrium the coordinates of a ball have a connection term, `½ [residual]×`.
    pub symmetric: bool,
}

impl TangentSolver {
    /// Room for a model.
    pub fn new(model: &Model) -> Self {
        let grounded = model.forces.len();
        Self {
            tangent: Tangent::new(model),
            diagonal: vec![0.0; model.velocity_count()],
            shifted: vec![0.0; model.velocity_count()],
            applied: Vec::with_capacity(grounded),
            ball_springs: Vec::with_capacity(model.links.len()),
            unit: vec![LinkVariation::default(); model.links.len()],
        }
    }

    /// Whether the sweep covers every force of a model: no element between two bodies, no loop, drive or gear.
    pub fn covers(model: &Model) -> bool {
        !model.is_constrained() && !model.forces.iter().any(|force| super::linearize::reaches_far(&force.law))
    }

    /// `x ← (c₂ M + c₁ C + K)⁻¹ x`.
    pub fn solve(&mut self, model: &Model, x: &mut [f64]) {
        self.tangent.solve(model, x);
    }

    /// A direction of negative curvature after a factorization that broke down at `link` for not being definite.
    pub fn negative_direction(&mut self, model: &Model, breakdown: Breakdown, x: &mut [f64]) {
        self.tangent.negative_direction(model, breakdown, x);
    }

    /// Number of negative pivots of the last factorization.
    pub fn negative_pivots(&self) -> usize {
        self.tangent.negative_pivots()
    }
}

impl System<'_> {
    /// Factorizes the tangent at a state with hinge accelerations `a`. `Ok(false)` where a pivot does not do.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub fn factorize_tangent(
        &mut self,
        solver: &mut TangentSolver,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        with: &Coefficients<'_>,
    ) -> Result<bool, Fault> {
        let mut residual = std::mem::take(&mut self.scratch);
        let evaluated = self.residual(q, v, a, &mut residual);
        self.scratch = residual;
        evaluated?;
        let model = self.model;
        for (i, coordinate) in model.coordinates.iter().enumerate() {
            solver.diagonal[i] = with.c1 * coordinate.damping + with.c2 * coordinate.armature;
        }
        self.gather_springs(solver, q);
        if with.symmetric {
            self.take_connection_off(solver);
        }
        self.gather_forces(solver);
        Ok(self.factorize_shifted(solver, a, with).is_ok())
    }

    /// Factorizes again with another shift; positions, velocities, forces and `c₁`, `c₂` as in the last call of
    /// [`System::factorize_tangent`] or [`System::residual`].
    ///
    /// # Errors
    /// The link whose pivot does not do.
    pub fn factorize_shifted(
        &self,
        solver: &mut TangentSolver,
        a: &[f64],
        with: &Coefficients<'_>,
    ) -> Result<(), Breakdown> {
        solver.shifted.copy_from_slice(&solver.diagonal);
        for (diagonal, shift) in solver.shifted.iter_mut().zip(with.shift) {
            *diagonal += shift;
        }
        let at = At {
            motion: &self.motion,
            balance: &self.balance,
            hinge: a,
            c1: with.c1,
            c2: with.c2,
            diagonal: &solver.shifted,
            applied: &solver.applied,
            ball_springs: &solver.ball_springs,
        };
        solver.tangent.factorize(self.model, &at, with.definite)
    }

    /// The residual of the last evaluation (in `scratch`) turns the stiffness of a ball by `½ [r]×`.
    fn take_connection_off(&self, solver: &mut TangentSolver) {
        for (index, link) in self.model.links.iter().enumerate() {
            if matches!(link.joint, Joint::Ball { .. }) {
                let first = link.velocity;
                let r = Vector3::new(self.scratch[first], self.scratch[first + 1], self.scratch[first + 2]);
                let connection = -0.5 * r.cross_matrix();
                match solver.ball_springs.iter_mut().find(|(ball, _)| *ball == index) {
                    Some((_, spring)) => *spring += connection,
                    None => solver.ball_springs.push((index, connection)),
                }
            }
        }
        solver.ball_springs.sort_by_key(|(ball, _)| *ball);
    }

    fn gather_springs(&self, solver: &mut TangentSolver, q: &[f64]) {
        solver.ball_springs.clear();
        for (index, link) in self.model.links.iter().enumerate() {
            match link.joint {
                Joint::None => {}
                Joint::Turn | Joint::Slide { .. } => {
                    solver.diagonal[link.velocity] += self.model.coordinates[link.velocity].stiffness;
                }
                Joint::Ball { .. } => {
                    if let Some(tangent) = forces::hinge::ball_tangent(self.model, link, q) {
                        solver.ball_springs.push((index, -tangent));
                    }
                }
            }
        }
    }

    /// Force elements to the ground and loads, column by column: the link they act on is moved one way at a time.
    fn gather_forces(&self, solver: &mut TangentSolver) {
        solver.applied.clear();
        for force in &self.model.forces {
            let Some(end) = force.law.ends().iter().position(|end| end.link != 0) else { continue };
            let link = force.law.ends()[end].link;
            let mut blocks = Blocks::default();
            for (block, column) in blocks.iter_mut().enumerate().take(4) {
                for axis in 0..3 {
                    solver.unit[link] = unit(block, axis);
                    let wrench = forces::vary_law(&force.law, &self.motion, &solver.unit)[end];
                    column.force.set_column(axis, &wrench.force);
                    column.moment.set_column(axis, &wrench.moment);
                }
            }
            solver.unit[link] = LinkVariation::default();
            solver.applied.push((link, blocks));
        }
    }
}

/// One small turn, shift, or change of velocity, in the order of the blocks of `z`.
fn unit(block: usize, axis: usize) -> LinkVariation {
    let e = Vector3::ith(axis, 1.0);
    let zero = LinkVariation::default();
    match block {
        0 => LinkVariation { turn: e, ..zero },
        1 => LinkVariation { position: e, ..zero },
        2 => LinkVariation { angular_velocity: e, ..zero },
        _ => LinkVariation { velocity: e, ..zero },
    }
}
