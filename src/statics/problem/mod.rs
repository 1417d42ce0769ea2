//! Statics seen as a landscape: generalized forces, stiffness and potential as functions of the free coordinates.
//!
//! | file | its one job |
//! |---|---|
//! | `place` | a position of the search: its unbalanced forces, and whether they prove a balance |
//! | `stiffness` | the stiffness of the free coordinates, factorized; `linear` has dense matrices, `sizes` what their entries are compared with |
//! | `limits` | limits of hinges in a tree: which are active at a place |
//! | `fence` | limits of hinges at which a search among loops and gears halts |
//! | `ties` | closed positions: the landscape of a scene with loops, drives and gears |
//! | `split`, `row_space` | what rows hold and what they leave free at a position: dense, and of many rows sparse |
//! | `bordered` | rows beside a sweep, without a matrix of the size of the scene |
//! | `braced` | the stiffness beside supports that bear |
//! | `prestress`, `taut` | self-stresses of linearly dependent rows, and loads across rows that are taut |
//! | `parts` | what is joined to each other |
//! | `assembled` | what the assembly of a scene has decided, kept as its numbers move |

pub(in crate::statics) mod assembled;
pub(in crate::statics) mod bordered;
pub(in crate::statics) mod braced;
mod fence;
mod limits;
pub(in crate::statics) mod linear;
pub(in crate::statics) mod parts;
pub(in crate::statics) mod place;
mod prestress;
mod row_space;
pub(in crate::statics) mod shared;
pub(in crate::statics) mod sizes;
mod split;
mod stiffness;
mod taut;
mod ties;

use super::certify::falling::{Fall, falling};
use super::watch::Watch;
use crate::dynamics::{Fault, Matrices, System, TangentSolver};
use crate::model::Model;
use crate::round_off::FORCE;
use faer::Mat;
use fence::Fence;
pub(in crate::statics) use fence::Gate;
use limits::Limits;
pub(in crate::statics) use limits::{Weak, within_limits};
use place::{BALANCED, Place, SHIFT};
pub(in crate::statics) use prestress::Prestress;
pub(in crate::statics) use split::{Across, Branch};
use std::borrow::Cow;
use std::sync::Arc;
use stiffness::Stiffness;
pub(in crate::statics) use ties::{MOST_MODES, by_sweeps};
use ties::{Ties, by_sparse_rows};

/// Least part of the largest inertia of a ball's three turns that any of them counts with.
const ROUND: f64 = 0.1;
/// Dense matrices that a search and its certificate hold at once: stiffness, mass, damping, factors and vectors.
pub(in crate::statics) const DENSE: usize = 6;
/// A scene that has moved by this many of its own lengths has left every scale of its own.
pub(in crate::statics) const FAR: f64 = 1e6;

/// Where a search begins.
#[derive(Debug, Clone)]
struct Origin {
    q: Vec<f64>,
    /// The largest of the forces that cancel there, over a radian or a length of the scene (J).
    work: f64,
}

/// The static problem of a model with its locked hinges held; of one with loops, drives or gears on its closed positions.
pub(in crate::statics) struct Landscape<'s> {
    system: &'s mut System,
    /// Indices of the velocity coordinates that may move.
    pub free: Vec<usize>,
    /// `B`: the inertia each free coordinate sees (kg, kg m²), of a ball's turns evened out; makes radians and metres comparable.
    pub metric: Vec<f64>,
    /// Whether loads have a potential: then the stiffness is a Hessian and equilibria are its stationary points.
    pub conservative: bool,
    /// Work counters.
    pub residuals: usize,
    /// Stiffness matrices looked at.
    pub stiffnesses: usize,
    /// Factorizations of them.
    pub factorizations: usize,
    /// Every position whose forces were looked at, for whoever watches the search; `None` if nobody does.
    pub(in crate::statics) trail: Option<Vec<Vec<f64>>>,
    stiffness: Stiffness,
    /// The position that a stiffness written down was looked at last; empty if there is none.
    looked: Vec<f64>,
    /// Which velocity coordinates are distances, and the scene's length.
    slides: Vec<bool>,
    length: f64,
    /// Velocities: zero, but for drives that keep theirs.
    pub(in crate::statics) steady: Vec<f64>,
    rest: Vec<f64>,
    full: Vec<f64>,
    pub(in crate::statics) ties: Option<Box<Ties>>,
    /// Of a tree whose limits are heeded.
    limits: Option<Box<Limits>>,
    /// Of a search that halts at limits.
    fence: Option<Box<Fence>>,
    /// Where the search began; `None` if nothing is searched for.
    origin: Option<Origin>,
    /// Says whether the search may go on.
    pub(in crate::statics) watch: Option<&'s Watch<'s>>,
}

/// The sparse solver of a landscape.
pub(in crate::statics) struct Looked {
    pub solver: Box<TangentSolver>,
    /// Whether it has the stiffness of the place that is asked about.
    pub here: bool,
}

/// How large the terms are that must cancel in each free coordinate.
#[derive(Debug, Clone, Default)]
pub(in crate::statics) struct Scales {
    /// Sum of the magnitudes of the forces in the balance (N, N m).
    pub force: Vec<f64>,
    /// Round-off that the balance may have (N, N m).
    pub noise: Vec<f64>,
    /// Magnitude of the stiffness terms (N/m, N m/rad).
    pub stiffness: Vec<f64>,
}

impl<'s> Landscape<'s> {
    /// The landscape around `q`.
    ///
    /// # Errors
    /// A singular hinge, or the element whose numbers are not finite.
    pub(in crate::statics) fn new(system: &'s mut System, q: &[f64]) -> Result<Self, Fault> {
        let model = &Arc::clone(system.model());
        let n = model.velocity_count();
        let rest = vec![0.0; n];
        let mut full = vec![0.0; n];
        system.at(0.0, q, &rest).articulated_inertia(&mut full)?;
        let free: Vec<usize> = (0..n).filter(|i| !model.coordinates[*i].lock).collect();
        even_out_balls(model, &mut full);
        let metric = free.iter().map(|i| full[*i]).collect();
        let conservative = model.is_conservative_at_rest();
        let (steady, ties) = match model.is_constrained() {
            false => (rest.clone(), None),
            true => {
                let (steady, frozen) = ties::steady(system, q);
                let sparse = conservative && by_sparse_rows(model, &free, &steady);
                let sweeps = sparse || (conservative && by_sweeps(model, &free, &steady));
                (steady, Some(Box::new(Ties::new(frozen, [sweeps, sparse]))))
            }
        };
        let bordered = conservative && ties.is_none() && by_sweeps(model, &free, &steady);
        let sweeps = ties.as_ref().map_or_else(|| bordered || TangentSolver::covers(model), |ties| ties.sweeps);
        if sweeps { Matrices::OfTangent } else { Matrices::Dense(DENSE) }.check(model)?;
        let stiffness = Stiffness::new(model, &free, bordered);
        let (residuals, stiffnesses, factorizations) = (0, 0, 0);
        Ok(Self {
            system,
            free,
            metric,
            conservative,
            residuals,
            stiffnesses,
            factorizations,
            trail: None,
            stiffness,
            looked: Vec::new(),
            slides: slides(model),
            length: model.length_scale(),
            steady,
            rest,
            full,
            ties,
            limits: None,
            fence: None,
            origin: None,
            watch: None,
        })
    }

    /// The model.
    pub(in crate::statics) fn model(&self) -> &Arc<Model> {
        self.system.model()
    }

    /// Says that a search begins at `place`: distances and forces far away are measured by those there.
    pub(in crate::statics) fn begin(&mut self, place: &Place) {
        let work = (0..place.force.len()).map(|row| place.scales.force[row] * self.lever(row)).fold(0.0, f64::max);
        self.origin = Some(Origin { q: place.q.clone(), work });
    }

    /// Whether a position is [`FAR`] from where the search began.
    pub(in crate::statics) fn is_far(&self, q: &[f64]) -> bool {
        let Some(origin) = &self.origin else { return false };
        let all = apart(self.model(), &origin.q, q);
        // Full turns lead nowhere.
        all.iter().zip(&self.slides).any(|(x, slides)| *slides && !(x.abs() <= FAR * self.length))
    }

    /// Far away springs hold forces beside which everything is round-off: what is unbalanced there is judged by the forces that
    /// act where the search began.
    fn judge_by_origin(&self, q: &[f64], scales: &mut Scales) {
        let Some(origin) = self.origin.as_ref().filter(|origin| origin.work > 0.0 && self.is_far(q)) else { return };
        for row in 0..scales.force.len() {
            let most = origin.work / self.lever(row);
            scales.force[row] = scales.force[row].min(most);
            scales.noise[row] = scales.noise[row].min(BALANCED * most);
        }
    }

    /// What makes work of the force in a free coordinate: the scene's length for a distance, 1 for an angle.
    pub(in crate::statics) fn lever(&self, row: usize) -> f64 {
        if self.slides[self.free[row]] { self.length } else { 1.0 }
    }

    /// A motion from `q` along which the potential falls for ever.
    pub(in crate::statics) fn falling(&mut self, q: &[f64]) -> Option<Fall> {
        let model = Arc::clone(self.model());
        falling(&model, self.system.at(0.0, q, &self.rest).motion())
    }

    /// What one factorization works: links of a sweep, entries of a matrix.
    pub(in crate::statics) fn work(&self) -> usize {
        let dense = match &self.ties {
            Some(ties) => !ties.sweeps,
            None => self.stiffness.is_dense(),
        };
        if dense { self.free.len().pow(2).max(1) } else { self.model().links.len() }
    }

    /// The system, for what comes after the search.
    pub(in crate::statics) fn system(&mut self) -> &mut System {
        self.system
    }

    /// Whether the search may go on: asked once for every step.
    pub(in crate::statics) fn goes_on(&self) -> bool {
        self.watch.is_none_or(Watch::goes_on)
    }

    /// The unbalanced force in each free coordinate: `−∂V/∂q` where there is a potential.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub(in crate::statics) fn force(&mut self, q: &[f64]) -> Result<Vec<f64>, Fault> {
        self.residuals += 1;
        if self.ties.is_some() {
            return Ok(self.tied_forces(q)?.0);
        }
        self.take_residual(q)?;
        Ok(self.free.iter().map(|i| -self.full[*i]).collect())
    }

    /// The residual of all coordinates of a tree in `full`, compliant stops included.
    fn take_residual(&mut self, q: &[f64]) -> Result<(), Fault> {
        self.system.at(0.0, q, &self.rest).residual(&self.rest, &mut self.full)?;
        if let Some(limits) = &self.limits {
            limits.add_residual(q, &mut self.full);
        }
        Ok(())
    }

    /// Takes the stiffness at `q` for the solutions that follow.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub(in crate::statics) fn look(&mut self, q: &[f64]) -> Result<(), Fault> {
        if let Some(limits) = &mut self.limits {
            limits.look(q, &self.free);
        }
        if self.looked == q && self.is_sparse() {
            return Ok(());
        }
        self.looked.clear();
        self.stiffnesses += 1;
        if self.ties.is_some() {
            // Which way it is may follow from what is seen here.
            self.take_view(q)?;
            self.heed_prestress(q)?;
            let sweeps = self.ties.as_ref().is_some_and(|ties| ties.sweeps);
            return if sweeps { self.look_along(q) } else { self.look_densely(q) };
        }
        if self.stiffness.is_dense() {
            let matrix = self.dense_stiffness(q)?;
            self.stiffness.set_dense(matrix);
            return Ok(());
        }
        self.residuals += 1;
        self.stiffness.look(self.system, q, &self.rest, self.conservative)?;
        self.looked.extend_from_slice(q);
        Ok(())
    }

    /// Whether the stiffness of a tree is written down as a sparse matrix: it is factorized without the system.
    pub(in crate::statics) fn is_sparse(&self) -> bool {
        self.ties.is_none() && self.stiffness.is_sparse()
    }

    /// Whether the stiffness is written down as a sparse matrix, beside loops, too.
    pub(in crate::statics) fn is_written(&self) -> bool {
        self.stiffness.is_sparse()
    }

    /// The sparse solver, and whether it has the stiffness at `q`; whoever looks again makes another.
    pub(in crate::statics) fn take_solver(&mut self, q: &[f64]) -> Option<Looked> {
        let here = self.is_sparse() && self.looked == q && self.conservative;
        let solver = self.stiffness.is_sparse().then(|| self.stiffness.take_solver())??;
        Some(Looked { solver, here })
    }

    /// Looks at a position with the stiffness as a matrix, for methods that need it; without loops as [`Landscape::look`].
    ///
    /// # Errors
    /// As [`Landscape::look`].
    pub(in crate::statics) fn look_densely(&mut self, q: &[f64]) -> Result<(), Fault> {
        if self.ties.is_none() {
            return self.look(q);
        }
        let (tangent, matrix) = self.stiffness_along(q)?;
        self.step_from_view();
        self.stiffness = Stiffness::Closed { tangent, matrix, factor: None };
        Ok(())
    }

    /// Factorizes `K + σB` at the place last looked at; false if it is not positive definite.
    pub(in crate::statics) fn factorize(&mut self, shift: f64) -> bool {
        self.factorizations += 1;
        if let Stiffness::Closed { .. } = self.stiffness {
            return self.stiffness.factorize_along(shift);
        }
        let diagonal: Vec<f64> = self.metric.iter().map(|b| shift * b).collect();
        self.stiffness.factorize(self.system, &self.with_stops(&diagonal), true)
    }

    /// A diagonal with the stiffness of the compliant stops that are pressed.
    fn with_stops<'d>(&self, diagonal: &'d [f64]) -> Cow<'d, [f64]> {
        match &self.limits {
            Some(limits) => diagonal.iter().zip(&limits.pressed).map(|(d, k)| d + k).collect(),
            None => Cow::Borrowed(diagonal),
        }
    }

    /// Solves with the last factorization.
    pub(in crate::statics) fn solve(&mut self, rhs: &[f64]) -> Vec<f64> {
        self.stiffness.solve(rhs)
    }

    /// [`Landscape::solve`] to half the digits where each of them costs: for what is only a step on a way.
    pub(in crate::statics) fn solve_roughly(&mut self, rhs: &[f64]) -> Vec<f64> {
        self.stiffness.solve_roughly(rhs)
    }

    /// `K x = rhs` at the place last looked at, definite or not; `None` where K is singular.
    pub(in crate::statics) fn newton(&mut self, rhs: &[f64]) -> Option<Vec<f64>> {
        let none = vec![0.0; self.free.len()];
        self.newton_shifted(rhs, &none)
    }

    /// `(K + diag(shift)) x = rhs`; `None` if that is singular.
    pub(in crate::statics) fn newton_shifted(&mut self, rhs: &[f64], shift: &[f64]) -> Option<Vec<f64>> {
        self.factorizations += 1;
        if !self.stiffness.factorize(self.system, &self.with_stops(shift), false) {
            return None;
        }
        let x = self.stiffness.solve(rhs);
        x.iter().all(|x| x.is_finite()).then_some(x)
    }

    /// The damped step of Levenberg and Marquardt at the place last looked at, whose dense stiffness is given.
    pub(in crate::statics) fn levenberg(&self, stiffness: &Mat<f64>, force: &[f64], part: f64) -> Option<Vec<f64>> {
        self.stiffness.levenberg(stiffness, &self.metric, force, part)
    }

    /// `σB` with σ this part of the largest curvature.
    pub(in crate::statics) fn shift(&self, place: &Place, part: f64) -> Vec<f64> {
        let curvatures = place.scales.stiffness.iter().zip(&self.metric).map(|(k, b)| k / b);
        let largest = curvatures.fold(0.0, f64::max);
        self.metric.iter().map(|b| part * largest * b).collect()
    }

    /// `K x = rhs` at the place last looked at; where K is singular, of a stiffness next to it.
    pub(in crate::statics) fn solved_nearby(&mut self, q: &[f64], rhs: &[f64]) -> Result<Option<Vec<f64>>, Fault> {
        if let Some(x) = self.newton(rhs) {
            return Ok(Some(x));
        }
        let place = Place::at(self, q.to_vec())?;
        let shift = self.shift(&place, SHIFT);
        Ok(self.newton_shifted(rhs, &shift))
    }

    /// Negative directions of `K + diag(shift)` at the place last looked at, where sweeps can tell.
    pub(in crate::statics) fn negatives(&mut self, shift: &[f64]) -> Option<usize> {
        if !self.conservative || self.stiffness.is_dense() {
            return None;
        }
        self.factorizations += 1;
        self.stiffness.negatives(self.system, &self.with_stops(shift))
    }

    /// The size of one radian, or one length of the scene, of every coordinate that no lock holds at once (m √kg).
    pub(in crate::statics) fn reach(&self) -> f64 {
        let square = |i: &usize, b: f64| b * if self.slides[*i] { self.length.powi(2) } else { 1.0 };
        let of = match &self.limits {
            Some(limits) => limits.inertias().map(|(i, b)| square(i, b)).sum::<f64>(),
            None => self.free.iter().zip(&self.metric).map(|(i, b)| square(i, *b)).sum(),
        };
        of.sqrt()
    }

    /// If the stiffness is negative by more than `shift` (a diagonal) at the place last looked at: a direction to look for
    /// the most negative one from.
    pub(in crate::statics) fn negative_direction(&mut self, shift: &[f64]) -> Option<Vec<f64>> {
        self.factorizations += 1;
        self.stiffness.negative_direction(self.system, &self.with_stops(shift))
    }

    /// The dense stiffness matrix of the free coordinates; symmetric where loads have a potential.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub(in crate::statics) fn dense_stiffness(&mut self, q: &[f64]) -> Result<Mat<f64>, Fault> {
        if self.ties.is_some() {
            self.take_view(q)?;
        }
        let full = self.system.at(0.0, q, &self.steady).stiffness()?;
        let (free, n) = (&self.free, self.free.len());
        Ok(if self.conservative {
            // Off equilibrium the coordinates of a ball have a connection term: the Hessian is the symmetric part.
            Mat::from_fn(n, n, |i, j| 0.5 * (full[(free[i], free[j])] + full[(free[j], free[i])]))
        } else {
            Mat::from_fn(n, n, |i, j| full[(free[i], free[j])])
        })
    }

    /// Potential energy, less the kinetic energy of a steady motion (J).
    pub(in crate::statics) fn potential(&mut self, q: &[f64]) -> f64 {
        let energies = self.system.at(0.0, q, &self.steady).energies_at_rest();
        let stops = self.limits.as_ref().map_or(0.0, |limits| limits.potential(q));
        energies.potential - energies.kinetic + stops
    }

    /// `q ⊞ x` with `x` in free coordinates, loops closed again and within the limits that are heeded; numbers that are not finite
    /// where loops cannot be closed, and beyond a fence.
    pub(in crate::statics) fn moved(&mut self, q: &[f64], x: &[f64]) -> Vec<f64> {
        self.full.fill(0.0);
        for (i, x) in self.free.iter().zip(x) {
            self.full[*i] = *x;
        }
        let mut moved = q.to_vec();
        System::displace(self.system.model(), &mut moved, &self.full);
        if let Some(limits) = &self.limits {
            limits.project(&mut moved);
        }
        if !self.close(&mut moved) || self.is_beyond(&moved) {
            moved.fill(f64::NAN);
        }
        moved
    }

    /// Sizes of the terms in the potential that the rounding of a position stirs, together (J): a stiff spring that is all but relaxed has next to
    /// no potential and much of its rounding, and each loop of a long row of them closes with an error of its own.
    pub(in crate::statics) fn stirred(&self, place: &Place) -> f64 {
        (0..self.free.len()).map(|row| place.scales.force[row] * self.lever(row)).sum()
    }

    /// `√(xᵀ B x)`.
    pub(in crate::statics) fn size(&self, x: &[f64]) -> f64 {
        x.iter().zip(&self.metric).map(|(x, b)| b * x * x).sum::<f64>().sqrt()
    }

    /// The unbalanced forces at `q`, and the magnitudes of the terms whose sums they are (a sweep of absolute
    /// values).
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub(in crate::statics) fn forces_and_scales(&mut self, q: &[f64]) -> Result<(Vec<f64>, Scales), Fault> {
        self.residuals += 1;
        let (force, mut scales) = match self.ties.is_some() {
            true => self.tied_forces(q)?,
            false => {
                let free = std::mem::take(&mut self.free);
                let result = self.forces_of(&free, q);
                self.free = free;
                result?
            }
        };
        self.heed_least(&self.free, &mut scales);
        self.judge_by_origin(q, &mut scales);
        Ok((force, scales))
    }

    /// Less than the machine precision of a radian, or of the scene's length, is no position: what the stiffest coordinate would
    /// push over so small a part of that is no force anywhere, as in a scene without loads whose springs are all but relaxed.
    fn heed_least(&self, which: &[usize], scales: &mut Scales) {
        let lever = |i: usize| if self.slides[i] { self.length } else { 1.0 };
        let works = which.iter().zip(&scales.stiffness).map(|(i, k)| k * lever(*i).powi(2));
        let least = f64::EPSILON.powi(2) * works.filter(|work| work.is_finite()).fold(0.0, f64::max);
        for (i, noise) in which.iter().zip(&mut scales.noise) {
            *noise = noise.max(least / lever(*i));
        }
    }

    /// Forces and scales in these velocity coordinates of a tree.
    fn forces_of(&mut self, which: &[usize], q: &[f64]) -> Result<(Vec<f64>, Scales), Fault> {
        let mut magnitudes = self.system.at(0.0, q, &self.rest).residual(&self.rest, &mut self.full)?.magnitudes();
        if let Some(limits) = &self.limits {
            limits.add_residual(q, &mut self.full);
            limits.add_magnitudes(q, &mut magnitudes);
        }
        let force = which.iter().map(|i| -self.full[*i]).collect();
        let length = self.length;
        let pick = |of: &dyn Fn(usize) -> f64| which.iter().map(|i| of(*i)).collect::<Vec<f64>>();
        let stiffness = |i: usize| {
            let per = if self.slides[i] { length } else { 1.0 };
            magnitudes.force[i] / per + magnitudes.stiffness[i]
        };
        let scales = Scales {
            force: pick(&|i| magnitudes.force[i]),
            noise: pick(&|i| FORCE.of(magnitudes.noise[i])),
            stiffness: pick(&stiffness),
        };
        Ok((force, scales))
    }
}

/// Which velocity coordinates are distances.
pub(in crate::statics) fn slides(model: &Model) -> Vec<bool> {
    let mut slides = vec![false; model.velocity_count()];
    model.lengths().for_each(|velocity| slides[velocity] = true);
    slides
}

/// How two positions differ, in velocity coordinates.
pub(in crate::statics) fn apart(model: &Model, from: &[f64], to: &[f64]) -> Vec<f64> {
    let mut all = vec![0.0; model.velocity_count()];
    for link in &model.links {
        let (first, count) = (link.velocity, link.joint.counts().1);
        crate::motion::relative(link, from, to, &mut all[first..first + count]);
    }
    all
}

/// Away from balance a ball's three turns are coupled by the moment that is left there: one about an axis of next to no
/// inertia (a rod about itself) would need a shift so large that nothing else moves.
fn even_out_balls(model: &Model, inertia: &mut [f64]) {
    for link in model.links.iter().filter(|link| link.joint.is_ball()) {
        let turns = &mut inertia[link.velocity..link.velocity + 3];
        let largest = turns.iter().fold(0.0_f64, |m, x| m.max(*x));
        turns.iter_mut().for_each(|x| *x = x.max(ROUND * largest));
    }
}
