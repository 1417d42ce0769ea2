//! The tangent of a system with its forces: gathers what the sweep of [`crate::transfer::tangent`] needs.

use super::border::{Border, UNKNOWNS};
use super::{Fault, System};
use crate::forces;
use crate::model::{End, Joint, Model};
use crate::motion::LinkMotion;
use crate::motion::variation::LinkVariation;
use crate::spatial::Wrench;
use crate::transfer::tangent::{Applied, At, Breakdown, Coupling, Tangent};
use nalgebra::{Matrix3, Vector3};

/// A factorized tangent: solves `(c₂ M + c₁ C + K) x = rhs` in O(n). Valid until the next factorization, whatever the
/// system evaluates in between.
#[derive(Debug, Clone)]
pub struct TangentSolver {
    tangent: Tangent,
    diagonal: Vec<f64>,
    shifted: Vec<f64>,
    applied: Vec<(usize, Applied)>,
    coupled: Vec<(usize, Coupling)>,
    ball_springs: Vec<(usize, Matrix3<f64>)>,
    /// The balls among the links, and the stiffness of all other coordinates.
    balls: Vec<usize>,
    springs: Vec<f64>,
    unit: Vec<LinkVariation>,
    /// Elements that reach further, by their index among the forces and then the loops.
    far: Vec<Option<usize>>,
    border: Border,
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
        let mut links = Vec::new();
        let mut far = Vec::with_capacity(model.forces.len());
        for ends in elements(model) {
            far.push(match ends {
                [a, b] if !is_near(model, ends) => {
                    links.push([a.link, b.link]);
                    Some(links.len() - 1)
                }
                _ => None,
            });
        }
        let is_ball = |index: &usize| matches!(model.links[*index].joint, Joint::Ball { .. });
        let balls: Vec<usize> = (0..model.links.len()).filter(is_ball).collect();
        let mut springs: Vec<f64> = model.coordinates.iter().map(|coordinate| coordinate.stiffness).collect();
        balls.iter().map(|index| model.links[*index].velocity).for_each(|first| springs[first..first + 3].fill(0.0));
        Self {
            tangent: Tangent::new(model),
            diagonal: vec![0.0; model.velocity_count()],
            shifted: vec![0.0; model.velocity_count()],
            applied: Vec::with_capacity(2 * far.len()),
            coupled: Vec::with_capacity(2 * far.len()),
            ball_springs: Vec::with_capacity(balls.len()),
            balls,
            springs,
            unit: vec![LinkVariation::default(); model.links.len()],
            far,
            border: Border::new(model, links),
        }
    }

    /// Whether the sweep alone covers every force of a model: none reaches further than from a link to its parent, and no
    /// loop, drive or gear ties coordinates together. Forces that reach further cost a dozen more right sides each.
    pub fn covers(model: &Model) -> bool {
        !model.is_constrained() && elements(model).all(|ends| is_near(model, ends))
    }

    /// Whether the dense tangent has to do: far elements, loops among them, bring more unknowns than the scene has.
    pub fn is_for_dense(model: &Model) -> bool {
        Self::further_sides(model) > model.velocity_count()
    }

    /// `x ← (c₂ M + c₁ C + K)⁻¹ x`.
    pub fn solve(&mut self, x: &mut [f64]) {
        self.tangent.solve(x);
        if !self.border.links.is_empty() {
            self.border.complete(&self.tangent, x);
        }
    }

    /// A direction of negative curvature after a factorization that broke down at `link` for not being definite.
    pub fn negative_direction(&mut self, model: &Model, breakdown: Breakdown, x: &mut [f64]) {
        self.tangent.negative_direction(model, breakdown, x);
    }

    /// Number of right sides that elements which reach far cost a factorization.
    pub fn further_sides(model: &Model) -> usize {
        UNKNOWNS * elements(model).filter(|ends| !is_near(model, ends)).count()
    }

    /// Negative eigenvalues of the matrix that was factorized last, where that is symmetric; elements that reach far
    /// count. Not after a factorization for a definite matrix.
    pub fn negatives(&self) -> usize {
        self.tangent.negative_pivots().saturating_add_signed(self.border.negatives())
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
            solver.diagonal[i] = with.c1 * coordinate.damping + with.c2 * coordinate.armature + solver.springs[i];
        }
        for (motor, push) in model.motors.iter().zip(&self.pushes) {
            solver.diagonal[motor.coordinate.velocity] -= push.by_position + with.c1 * push.by_velocity;
        }
        self.gather_springs(solver, q, with.symmetric);
        self.gather_forces(solver);
        Ok(self.factorize_shifted(solver, a, with).is_ok())
    }

    /// Factorizes again with another shift; positions, velocities, forces and `c₁`, `c₂` as in the last call of
    /// [`System::factorize_tangent`] or [`System::residual`].
    ///
    /// # Errors
    /// The link whose pivot does not do; the ground where the elements that reach far make it singular.
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
            wrenches: &self.applied,
            coupled: &solver.coupled,
            ball_springs: &solver.ball_springs,
        };
        solver.tangent.factorize(self.model, &at, with.definite)?;
        let regular = solver.border.links.is_empty() || solver.border.factorize(self.model, &mut solver.tangent);
        if regular { Ok(()) } else { Err(Breakdown { link: 0, axis: None }) }
    }

    /// Springs of balls. With `symmetric`, off equilibrium, their stiffness is rid of its connection term: the residual of
    /// the last evaluation (in `scratch`) turns it by `½ [r]×`.
    fn gather_springs(&self, solver: &mut TangentSolver, q: &[f64], symmetric: bool) {
        solver.ball_springs.clear();
        for index in &solver.balls {
            let link = &self.model.links[*index];
            let first = link.velocity;
            let spring = forces::hinge::ball_tangent(self.model, link, q).map(|tangent| -tangent);
            let r = Vector3::from_column_slice(&self.scratch[first..first + 3]);
            let connection = symmetric.then(|| -0.5 * r.cross_matrix());
            if spring.is_some() || connection.is_some() {
                let none = Matrix3::zeros();
                solver.ball_springs.push((*index, spring.unwrap_or(none) + connection.unwrap_or(none)));
            }
        }
    }

    /// Force elements, and loops at fixed multipliers, column by column: the links they act on are moved one way at a
    /// time.
    fn gather_forces(&self, solver: &mut TangentSolver) {
        solver.applied.clear();
        solver.coupled.clear();
        for (index, ends) in elements(self.model).enumerate() {
            let far = solver.far[index];
            for (end, link) in ends.iter().map(|end| end.link).enumerate() {
                if link == 0 || (end == 1 && link == ends[0].link) {
                    continue;
                }
                let blocks = self.blocks(index, link, &mut solver.unit);
                let mut own = Applied::default();
                for (other, (felt, block)) in ends.iter().zip(&blocks).enumerate() {
                    match (felt.link, far) {
                        (0, _) => {}
                        (at, _) if at == link => add(&mut own, block),
                        (_, Some(element)) => solver.border.felt[element][other] = *block,
                        (parent, None) if parent < link => {
                            solver.coupled.push((link, Coupling { on_parent: *block, ..Coupling::default() }));
                        }
                        (child, None) => {
                            solver.coupled.push((child, Coupling { by_parent: *block, ..Coupling::default() }));
                        }
                    }
                }
                solver.applied.push((link, own));
            }
        }
        solver.applied.sort_unstable_by_key(|(link, _)| *link);
        solver.coupled.sort_unstable_by_key(|(link, _)| *link);
        solver.coupled.dedup_by(|next, sum| {
            let same = next.0 == sum.0;
            if same {
                add(&mut sum.1.by_parent, &next.1.by_parent);
                add(&mut sum.1.on_parent, &next.1.on_parent);
            }
            same
        });
    }

    /// What both ends of a force element feel when one link moves.
    fn blocks(&self, index: usize, link: usize, unit: &mut [LinkVariation]) -> [Applied; 2] {
        let vary = |unit: &[LinkVariation]| match (self.model.forces.get(index), &self.constraints) {
            (Some(force), _) => forces::vary_law(&force.law, &self.motion, unit),
            (None, Some(_)) => self.vary_loop(index - self.model.forces.len(), unit),
            (None, None) => [Wrench::ZERO; 2],
        };
        let mut blocks = [Applied::default(); 2];
        for block in 0..blocks[0].len() {
            for axis in 0..3 {
                unit[link] = unit_variation(block, axis, &self.motion.links[link]);
                let wrenches = vary(unit);
                for (end, wrench) in wrenches.iter().enumerate() {
                    blocks[end][block].force.set_column(axis, &wrench.force);
                    blocks[end][block].moment.set_column(axis, &wrench.moment);
                }
            }
        }
        unit[link] = LinkVariation::default();
        blocks
    }
}

/// `sum += more`.
fn add(sum: &mut Applied, more: &Applied) {
    for (sum, more) in sum.iter_mut().zip(more) {
        sum.force += more.force;
        sum.moment += more.moment;
    }
}

/// The ends of every element that pushes on links: forces, then loops.
fn elements(model: &Model) -> impl Iterator<Item = &[End]> {
    let forces = model.forces.iter().map(|force| force.law.ends());
    forces.chain(model.loops.iter().map(|closed| &closed.ends[..]))
}

/// Whether an element acts on the ground, on one link, or on a link and its parent.
fn is_near(model: &Model, ends: &[End]) -> bool {
    let parent = |link: usize| model.links[link].parent;
    match ends {
        [a, b] => {
            let (a, b) = (a.link, b.link);
            a == 0 || b == 0 || a == b || parent(a) == b || parent(b) == a
        }
        _ => true,
    }
}

/// One small turn, shift, or change of velocity, in the order of [`Applied`]. What a link turns with turns with it.
fn unit_variation(block: usize, axis: usize, link: &LinkMotion) -> LinkVariation {
    let e = Vector3::ith(axis, 1.0);
    let zero = LinkVariation::default();
    match block {
        0 => LinkVariation { turn: e, angular_velocity: e.cross(&link.angular_velocity), ..zero },
        1 => LinkVariation { position: e, ..zero },
        2 => LinkVariation { angular_velocity: e, ..zero },
        _ => LinkVariation { velocity: e, ..zero },
    }
}
