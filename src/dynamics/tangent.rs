//! The tangent of a system with its forces: gathers what the sweep of [`crate::transfer::tangent`] needs.

use super::applied;
use super::border::Border;
use super::dense::DenseTangent;
use super::reach::{self, Reach, reaches};
use super::sparse::Sparse;
use super::{Evaluated, Fault, System};
use crate::force::Act;
use crate::model::Model;
use crate::motion::LinkMotion;
use crate::motion::variation::LinkVariation;
use crate::sparse::SparseRows;
use crate::spatial::Wrench;
use crate::transfer::tangent::{Applied, At, Breakdown, Column, Coupling, Pull, Tangent};
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeMap;
use std::ops::AddAssign;

/// A factorized tangent: solves `(c₂ M + c₁ C + K) x = rhs`. Valid until the next factorization, whatever the system evaluates
/// in between.
///
/// | elements that act on links further apart than a link and its parent | factorization |
/// |---|---|
/// | none | the sweep, O(n) |
/// | few | the sweep, bordered by six unknowns for each link that they act on |
/// | many | a sparse matrix in hinge coordinates |
/// | more than coordinates, in a small scene | a dense matrix |
///
/// Whether a border or a sparse matrix follows from the estimated number of operations.
#[derive(Debug, Clone)]
pub struct TangentSolver {
    tangent: Tangent,
    diagonal: Vec<f64>,
    shifted: Vec<f64>,
    /// Ascending by link.
    applied: Vec<(usize, Applied)>,
    /// Where among those each link of each element stands.
    places: Vec<usize>,
    coupled: Vec<(usize, Coupling)>,
    ball_springs: Vec<(usize, Matrix3<f64>)>,
    /// The balls among the links, and the stiffness of all other coordinates.
    balls: Vec<usize>,
    springs: Vec<f64>,
    unit: Vec<LinkVariation>,
    /// Forces, then loops.
    elements: Vec<Reach>,
    /// What the links of one element feel when one of them moves.
    blocks: Vec<Applied>,
    border: Border,
    /// Instead of the sweep and the border.
    sparse: Option<Box<Sparse>>,
    dense: Option<Box<DenseTangent>>,
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
        let mut elements: Vec<Reach> = reaches(model).collect();
        let (mut further, mut pairs, mut known) = (Vec::new(), Vec::new(), BTreeMap::new());
        let is_sparse = Self::is_sparse(model);
        let is_dense = !is_sparse && Self::is_for_dense(model);
        for element in &mut elements {
            if is_sparse && element.links.len() > 1 {
                element.far = Some(*known.entry(element.links.clone()).or_insert_with(|| {
                    let first = pairs.len();
                    pairs.extend(element.pairs());
                    first
                }));
            } else if !is_sparse && !is_dense && !element.is_near(model) {
                element.far = Some(*known.entry(element.links.clone()).or_insert_with(|| {
                    further.push(element.links.clone());
                    further.len() - 1
                }));
            }
        }
        let most = elements.iter().map(|element| element.links.len()).max().unwrap_or(0);
        // Of each link of each element, in their order, the place of what it feels of itself, ascending by link.
        let moved: Vec<usize> = elements.iter().flat_map(|element| element.links.iter().copied()).collect();
        let mut order: Vec<usize> = (0..moved.len()).collect();
        order.sort_by_key(|at| moved[*at]);
        let applied = order.iter().map(|at| (moved[*at], Applied::default())).collect();
        let mut places = vec![0; moved.len()];
        order.iter().enumerate().for_each(|(place, at)| places[*at] = place);
        let is_ball = |index: &usize| model.links[*index].joint.is_ball();
        let balls: Vec<usize> = (0..model.links.len()).filter(is_ball).collect();
        let mut springs: Vec<f64> = model.coordinates.iter().map(|coordinate| coordinate.stiffness).collect();
        balls.iter().map(|index| model.links[*index].velocity).for_each(|first| springs[first..first + 3].fill(0.0));
        Self {
            tangent: Tangent::new(model),
            diagonal: vec![0.0; model.velocity_count()],
            shifted: vec![0.0; model.velocity_count()],
            applied,
            coupled: Vec::with_capacity(moved.len()),
            places,
            ball_springs: Vec::with_capacity(balls.len()),
            balls,
            springs,
            unit: vec![LinkVariation::default(); model.links.len()],
            elements,
            blocks: vec![Applied::default(); most],
            border: Border::new(model, &further),
            sparse: is_sparse.then(|| Box::new(Sparse::new(model, &pairs))),
            dense: is_dense.then(|| Box::new(DenseTangent::new(model))),
        }
    }

    /// Whether the sweep alone covers every force of a model: none reaches further than from a link to its parent, and no
    /// loop, drive or gear ties coordinates together. Forces that reach further cost six more right sides for each link
    /// that they act on.
    pub fn covers(model: &Model) -> bool {
        reach::covers(model)
    }

    /// Whether the dense tangent has to do: in a small scene far elements, loops among them, bring more unknowns than it has.
    pub fn is_for_dense(model: &Model) -> bool {
        reach::further_sides(model) > model.velocity_count()
    }

    /// Whether the tangent is a sparse matrix: in a large scene whose far elements would make the border the longer way, and that
    /// has no flexible elements.
    pub fn is_sparse(model: &Model) -> bool {
        reach::is_sparse(model)
    }

    /// Whether this tangent is a sparse matrix: it stays as it was gathered, whatever the system does next.
    pub fn is_written(&self) -> bool {
        self.sparse.is_some()
    }

    /// Number of right sides that elements which reach far take at each factorization: none beside a sparse matrix.
    pub fn further_sides(model: &Model) -> usize {
        reach::further_sides(model)
    }

    /// `x ← (c₂ M + c₁ C + K)⁻¹ x`.
    pub fn solve(&mut self, x: &mut [f64]) {
        if let Some(sparse) = &mut self.sparse {
            return sparse.solve(x);
        }
        if let Some(dense) = &mut self.dense {
            return dense.solve(x);
        }
        self.tangent.solve(x);
        if !self.border.is_empty() {
            self.border.complete(&self.tangent, x);
        }
    }

    /// Whether the last factorization was that of the sparse matrix with the links' motions among its unknowns.
    pub fn is_by_twists(&self) -> bool {
        self.sparse.as_ref().is_some_and(|sparse| sparse.is_by_twists())
    }

    /// Whether solutions by a sparse matrix are refined to half their digits alone.
    pub fn be_rough(&mut self, rough: bool) {
        if let Some(sparse) = &mut self.sparse {
            sparse.be_rough(rough);
        }
    }

    /// `[T Gᵀ; G 0] [x; λ] = [x; s]` with the rows `G` of `TangentSolver::set_rows` and `s` for each of them; not numbers of a
    /// tangent that is no sparse matrix.
    pub fn solve_with_rows(&mut self, x: &mut [f64], s: &[f64]) {
        match &mut self.sparse {
            Some(sparse) => sparse.solve_with_rows(x, s),
            None => x.fill(f64::NAN),
        }
    }

    /// A direction of negative curvature after a factorization that broke down at `link` for not being definite.
    pub fn negative_direction(&mut self, model: &Model, breakdown: Breakdown, x: &mut [f64]) {
        self.tangent.negative_direction(model, breakdown, x);
    }

    /// Holds what these rows hold from the next factorization on: then solutions are those along the motions that they
    /// leave, and negative eigenvalues those of these motions. Only of a tangent that is a sparse matrix. `pulls` say the same of the links;
    /// none where that is not known.
    pub fn set_rows(&mut self, rows: &SparseRows, pulls: &[Pull]) {
        if let Some(sparse) = &mut self.sparse {
            sparse.set_rows(rows, pulls);
        }
    }

    /// Whether far elements border the sweep or make it dense: then a pivot of it says nothing of the whole.
    pub fn is_bordered(&self) -> bool {
        !self.border.is_empty() || self.dense.is_some()
    }

    /// Negative eigenvalues of the matrix that was factorized last, where that is symmetric; elements that reach far
    /// count. `None` if they could not be counted. Not after a factorization for a definite matrix.
    pub fn negatives(&self) -> Option<usize> {
        match (&self.sparse, &self.dense) {
            (Some(sparse), _) => sparse.negatives(),
            (None, Some(dense)) => dense.negatives(),
            (None, None) => Some(self.tangent.negative_pivots().saturating_add_signed(self.border.negatives())),
        }
    }
}

impl Evaluated<'_> {
    /// Factorizes the tangent with hinge accelerations `a`. `Ok(false)` where a pivot does not do.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub fn factorize_tangent(
        &mut self,
        solver: &mut TangentSolver,
        a: &[f64],
        with: &Coefficients<'_>,
    ) -> Result<bool, Fault> {
        self.gather_tangent(solver, a, with)?;
        Ok(self.system.factorize_shifted(solver, a, with).is_ok())
    }

    /// Gathers what [`System::factorize_shifted`] needs, with hinge accelerations `a`; the shift is left to it.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub fn gather_tangent(
        &mut self,
        solver: &mut TangentSolver,
        a: &[f64],
        with: &Coefficients<'_>,
    ) -> Result<(), Fault> {
        if let Some(mut dense) = solver.dense.take() {
            let written = self.write_dense(&mut dense, a, [with.c1, with.c2], with.symmetric);
            solver.dense = Some(dense);
            return written;
        }
        self.balance(a)?;
        let model = &*self.system.model;
        for (i, coordinate) in model.coordinates.iter().enumerate() {
            solver.diagonal[i] = with.c1 * coordinate.damping + with.c2 * coordinate.armature + solver.springs[i];
        }
        for (coordinate, push) in model.pushed().zip(&self.system.pushes) {
            solver.diagonal[coordinate.velocity] -= push.by_position + with.c1 * push.by_velocity;
        }
        self.gather_springs(solver, with.symmetric);
        self.gather_forces(solver, !self.system.motion.still || with.c1 != 0.0);
        if let Some(mut sparse) = solver.sparse.take() {
            let at = At {
                motion: &self.system.motion,
                balance: &self.system.balance,
                hinge: a,
                c1: with.c1,
                c2: with.c2,
                diagonal: &solver.diagonal,
                applied: &solver.applied,
                wrenches: &self.system.applied,
                coupled: &[],
                ball_springs: &solver.ball_springs,
            };
            sparse.assemble(model, &at, with.symmetric);
            solver.sparse = Some(sparse);
        }
        Ok(())
    }

    /// Springs of balls. With `symmetric`, off equilibrium, their stiffness is rid of its connection term: the residual of
    /// the last evaluation (in `scratch`) turns it by `½ [r]×`.
    fn gather_springs(&self, solver: &mut TangentSolver, symmetric: bool) {
        solver.ball_springs.clear();
        for index in &solver.balls {
            let link = &self.system.model.links[*index];
            let first = link.velocity;
            let spring = applied::hinge::ball_tangent(&self.system.model, link, self.q).map(|tangent| -tangent);
            let r = Vector3::from_column_slice(&self.system.scratch[first..first + 3]);
            let connection = symmetric.then(|| -0.5 * r.cross_matrix());
            if spring.is_some() || connection.is_some() {
                let none = Matrix3::zeros();
                solver.ball_springs.push((*index, spring.unwrap_or(none) + connection.unwrap_or(none)));
            }
        }
    }

    /// Force elements, and loops at fixed multipliers, column by column: the links they act on are moved one way at a
    /// time. Velocities count if `rated`.
    fn gather_forces(&self, solver: &mut TangentSolver, rated: bool) {
        solver.coupled.clear();
        let mut places = solver.places.iter();
        // At rest what varies is the same for every link, as for the ground.
        let ground = &self.system.motion.links[0];
        let still: [LinkVariation; 6] = std::array::from_fn(|i| unit_variation(i / 3, i % 3, ground));
        let still = (!rated).then_some(&still[..]);
        match &mut solver.sparse {
            Some(sparse) => sparse.clear_felt(),
            None => solver.border.clear_felt(),
        }
        for (index, element) in solver.elements.iter().enumerate() {
            for (moved, link) in element.links.iter().copied().enumerate() {
                let blocks = &mut solver.blocks[..element.links.len()];
                self.blocks((index, still), element, link, &mut solver.unit, blocks);
                if let Some(place) = places.next() {
                    solver.applied[*place].1 = blocks[moved];
                }
                for (felt, (at, block)) in element.links.iter().copied().zip(blocks).enumerate() {
                    match element.far {
                        _ if felt == moved => {}
                        Some(far) => match &mut solver.sparse {
                            Some(sparse) => {
                                let others = element.links.len() - 1;
                                add(sparse.felt(far + moved * others + felt - usize::from(felt > moved)), block);
                            }
                            None => add(solver.border.felt(far, felt, moved), block),
                        },
                        None if at < link => {
                            solver.coupled.push((link, Coupling { on_parent: *block, ..Coupling::default() }));
                        }
                        None => solver.coupled.push((at, Coupling { by_parent: *block, ..Coupling::default() })),
                    }
                }
            }
        }
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

    /// What the links of an element feel when one link moves; at rest in one of the ways of `still`.
    fn blocks(
        &self,
        (index, still): (usize, Option<&[LinkVariation]>),
        element: &Reach,
        link: usize,
        unit: &mut [LinkVariation],
        blocks: &mut [Applied],
    ) {
        blocks.fill(Applied::default());
        let give = &mut |variation: usize, end: usize, wrench: Wrench| {
            if let Some(place) = element.places[end] {
                let (Column { force, moment }, axis) = (&mut blocks[place][variation / 3], variation % 3);
                force.column_mut(axis).add_assign(&wrench.force);
                moment.column_mut(axis).add_assign(&wrench.moment);
            }
        };
        let at = &self.system.motion.links[link];
        let moving = |i: usize| unit_variation(i / 3, i % 3, at);
        match still {
            Some(variations) => self.vary_element(index, unit, (link, variations), give),
            None => self.vary_element(index, unit, (link, &std::array::from_fn::<_, 12, _>(moving)), give),
        }
    }

    /// The variation of the wrenches of an element, by its index among the forces and then the loops, with each of some variations
    /// of one link.
    fn vary_element(
        &self,
        index: usize,
        by: &mut [LinkVariation],
        (link, variations): (usize, &[LinkVariation]),
        give: &mut impl FnMut(usize, usize, Wrench),
    ) {
        if let Some(force) = self.system.laws.forces.get(index) {
            return force.law.vary_each(&self.system.motion.links, by, (link, variations), give);
        }
        for (variation, varied) in variations.iter().enumerate() {
            by[link] = *varied;
            let wrenches = self.system.vary_loop(index - self.system.model.forces.len(), by);
            wrenches.into_iter().enumerate().for_each(|(end, wrench)| give(variation, end, wrench));
        }
        by[link] = LinkVariation::default();
    }
}

impl System {
    /// Factorizes the tangent of the last [`Evaluated::gather_tangent`] with a shift; accelerations, `c₁` and
    /// `c₂` as there.
    ///
    /// # Errors
    /// The link whose pivot does not do; the ground where the elements that reach far make it singular.
    pub fn factorize_shifted(
        &self,
        solver: &mut TangentSolver,
        a: &[f64],
        with: &Coefficients<'_>,
    ) -> Result<(), Breakdown> {
        let regular = match (&mut solver.sparse, &mut solver.dense) {
            (Some(sparse), _) => Some(sparse.factorize(&self.model, with.shift, with.definite)),
            (_, Some(dense)) => Some(dense.factorize(with.shift, with.definite)),
            _ => None,
        };
        if let Some(regular) = regular {
            return if regular { Ok(()) } else { Err(Breakdown { link: 0, axis: None }) };
        }
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
        solver.tangent.factorize(&self.model, &at, with.definite)?;
        let regular = solver.border.is_empty() || solver.border.factorize(&self.model, &mut solver.tangent);
        if regular { Ok(()) } else { Err(Breakdown { link: 0, axis: None }) }
    }
}

/// `sum += more`.
fn add(sum: &mut Applied, more: &Applied) {
    for (sum, more) in sum.iter_mut().zip(more) {
        sum.force += more.force;
        sum.moment += more.moment;
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
