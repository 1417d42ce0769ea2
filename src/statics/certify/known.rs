//! What is known of a stiffness that is small beside the terms it is the sum of: a weight on a wire of 10¹⁰ N/m swings with a few N/m.
//!
//! A stiffness `κ = xᵀ K x` along a motion `x` with terms of the size `N = xᵀ diag(Nᵢ) x` errs in two ways:
//!
//! ```text
//! (1)  by the round-off of its terms:        16 ε · n · N
//! (2)  by where the equilibrium is:          forces err by φ = Σ |xᵢ| (|fᵢ| + their round-off), so it lies anywhere within
//!                                            t = φ/|κ| along x, where the stiffness is κ(± t)
//! (3)  κ(t):  q ⊞ t x, all other motions come to rest there;  S = (Uᵀ (K + U Uᵀ)⁻¹ U)⁻¹ − 1,  U = N X
//! ```
//!
//! `X` are all motions in doubt, each with `xᵀ N x = 1`; `S` is what is seen along them where everything else gives way (a Schur
//! complement), so that a pendulum on a stiff wire is followed on its arc. A motion is neutral if its stiffness is within (1), or
//! differs from κ(± t) by half of itself: a potential that is flat to third order has no stiffness however far a search came.

use super::stability::{Stability, by_matrices, classify};
use crate::dynamics::Fault;
use crate::round_off::{CLOSED_STIFFNESS, FORCE};
use crate::statics::problem::Landscape;
use crate::statics::problem::place::Place;
use crate::statics::problem::sizes::{NEUTRAL, comparable, relative, sizes};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// How many times the round-off a stiffness has to be.
const CLEAR: f64 = 4.0;
/// How far (2) may lead: radians, or part of the scene's length.
const FARTHEST: f64 = 1e-2;
/// Newton steps to rest in (3): the first leaves the square of the distance, the second its fourth power.
const STEPS: usize = 2;
/// Part of itself by which a stiffness that is known differs along (2) at most.
const DIFFERS: f64 = 0.5;

/// What a closer look at the motions says whose stiffness is within [`NEUTRAL`] of zero.
pub(in crate::statics) struct Known {
    /// All directions that run away.
    pub unstable: usize,
    /// Directions of zero stiffness.
    pub neutral: usize,
    /// A motion that runs away with a stiffness within [`NEUTRAL`], in free coordinates.
    pub falls: Option<Vec<f64>>,
}

/// Verdict and modes of an equilibrium of a tree.
pub(in crate::statics) fn of_tree(landscape: &mut Landscape<'_>, place: &Place) -> Result<Stability, Fault> {
    let (free, conservative) = (landscape.free.clone(), landscape.conservative);
    let sizes = &place.scales.stiffness;
    let looked = landscape.take_solver(&place.q);
    let first = classify(landscape.system(), &place.q, &free, sizes, conservative, None, looked)?;
    if !conservative || first.neutral_directions == 0 || !by_matrices(landscape.model(), free.len()) {
        return Ok(first);
    }
    let Known { unstable, neutral, .. } = look_closer(landscape, place)?;
    match neutral == first.neutral_directions {
        true => Ok(first),
        false => classify(landscape.system(), &place.q, &free, sizes, conservative, Some((unstable, neutral)), None),
    }
}

/// Looks closer at an equilibrium of loads with a potential some of whose motions have next to no stiffness. The landscape is at
/// `place` before and after.
pub(in crate::statics) fn look_closer(landscape: &mut Landscape<'_>, place: &Place) -> Result<Known, Fault> {
    let At { z, stiffness } = At::of(landscape, &place.q)?;
    let magnitude = comparable(&sizes(z.as_ref(), &place.scales.stiffness));
    let n = magnitude.len();
    let scaled = relative(&stiffness, &magnitude);
    let Ok(eigen) = scaled.self_adjoint_eigen(Side::Lower) else {
        return Ok(Known { unstable: 0, neutral: n, falls: None });
    };
    let values: Vec<f64> = (0..n).map(|k| eigen.S()[k]).collect();
    let mut known = Known { unstable: values.iter().filter(|x| **x < -NEUTRAL).count(), neutral: 0, falls: None };
    let doubtful: Vec<usize> = (0..n).filter(|k| !(values[*k].abs() > NEUTRAL)).collect();
    let moves: Vec<Vec<f64>> =
        doubtful.iter().map(|k| (0..n).map(|i| eigen.U()[(i, *k)] / magnitude[i].sqrt()).collect()).collect();
    // `N x` as a force in free coordinates, and `x` there.
    let metric = landscape.metric.clone();
    let force = |y: &Vec<f64>| {
        let along: Vec<f64> = y.iter().zip(&magnitude).map(|(y, size)| y * size).collect();
        match &z {
            Some(z) => spread(z, &along).iter().zip(&metric).map(|(x, b)| b * x).collect(),
            None => along,
        }
    };
    let held: Vec<Vec<f64>> = moves.iter().map(force).collect();
    let mut doubt = Doubt { landscape, place, held };
    for (j, k) in doubtful.into_iter().enumerate() {
        let x = z.as_ref().map_or_else(|| moves[j].clone(), |z| spread(z, &moves[j]));
        match doubt.is_known(values[k], &x, j) {
            false => known.neutral += 1,
            true if values[k] < 0.0 => {
                known.unstable += 1;
                known.falls.get_or_insert(x);
            }
            true => {}
        }
    }
    if landscape.ties.is_some() {
        landscape.take_view(&place.q)?;
    }
    Ok(known)
}

/// The motions at a position, a basis of them with loops, and their stiffness.
struct At {
    z: Option<Mat<f64>>,
    stiffness: Mat<f64>,
}

impl At {
    fn of(landscape: &mut Landscape<'_>, q: &[f64]) -> Result<Self, Fault> {
        if landscape.ties.is_none() {
            return Ok(Self { z: None, stiffness: landscape.dense_stiffness(q)? });
        }
        let (z, stiffness) = landscape.stiffness_along(q)?;
        Ok(Self { z: Some(z), stiffness })
    }

    /// `Zᵀ f`
    fn reduced(&self, force: &[f64]) -> Vec<f64> {
        let Some(z) = &self.z else { return force.to_vec() };
        (0..z.ncols()).map(|j| force.iter().enumerate().map(|(i, f)| z[(i, j)] * f).sum()).collect()
    }

    /// `(K + U Uᵀ)⁻¹` times these columns, for the columns `u` of `held`.
    fn solve(&self, held: &Mat<f64>, rhs: &Mat<f64>) -> Mat<f64> {
        (&self.stiffness + held * held.transpose()).partial_piv_lu().solve(rhs)
    }

    /// `Zᵀ U`
    fn held(&self, held: &[Vec<f64>]) -> Mat<f64> {
        let columns: Vec<Vec<f64>> = held.iter().map(|force| self.reduced(force)).collect();
        Mat::from_fn(self.stiffness.nrows(), columns.len(), |i, j| columns[j][i])
    }
}

/// `Z y`
fn spread(z: &Mat<f64>, y: &[f64]) -> Vec<f64> {
    (0..z.nrows()).map(|i| y.iter().enumerate().map(|(j, y)| z[(i, j)] * y).sum()).collect()
}

struct Doubt<'a, 's> {
    landscape: &'a mut Landscape<'s>,
    place: &'a Place,
    /// `U`
    held: Vec<Vec<f64>>,
}

impl Doubt<'_, '_> {
    /// Whether the stiffness `value` along the motion `x`, the `j`-th in doubt, is more than its errors.
    fn is_known(&mut self, value: f64, x: &[f64], j: usize) -> bool {
        let closed = if self.landscape.ties.is_some() { CLOSED_STIFFNESS.of(1.0) } else { 0.0 };
        let round_off = FORCE.of(x.len() as f64).max(closed);
        if !(value.abs() > CLEAR * round_off) {
            return false;
        }
        let Place { force, scales, .. } = self.place;
        let error: f64 = x.iter().enumerate().map(|(i, x)| x.abs() * (force[i].abs() + scales.noise[i])).sum();
        let far = error / value.abs();
        let reach = x.iter().enumerate().map(|(i, x)| (far * x / self.landscape.lever(i)).abs()).fold(0.0, f64::max);
        if !(far.is_finite() && reach <= FARTHEST) {
            return false;
        }
        [far, -far].into_iter().all(|by| {
            let step: Vec<f64> = x.iter().map(|x| by * x).collect();
            let there = self.seen(&step, j);
            there.is_some_and(|there| (there - value).abs() <= DIFFERS * value.abs())
        })
    }

    /// (3) after a step, of the `j`-th motion in doubt.
    fn seen(&mut self, step: &[f64], j: usize) -> Option<f64> {
        let mut q = self.landscape.moved(&self.place.q, step);
        for _ in 0..STEPS {
            if q.iter().any(|x| !x.is_finite()) {
                return None;
            }
            let force = self.landscape.force(&q).ok()?;
            let at = At::of(self.landscape, &q).ok()?;
            let force = at.reduced(&force);
            let rhs = Mat::from_fn(force.len(), 1, |i, _| force[i]);
            let y = at.solve(&at.held(&self.held), &rhs);
            let y: Vec<f64> = (0..y.nrows()).map(|i| y[(i, 0)]).collect();
            q = self.landscape.moved(&q, &at.z.as_ref().map_or_else(|| y.clone(), |z| spread(z, &y)));
        }
        let at = At::of(self.landscape, &q).ok()?;
        let held = at.held(&self.held);
        let compliance = held.transpose() * at.solve(&held, &held);
        let count = compliance.nrows();
        let seen = compliance.partial_piv_lu().solve(Mat::<f64>::identity(count, count));
        Some(seen[(j, j)] - 1.0)
    }
}
