//! Motions that contacts leave free without sliding: rolling and pivoting, and what bends. Forces at rest do not say whether they come back.
//!
//! ```text
//! (1)  J Z = 0                                          J: rows of all supports that bear without giving way
//! (2)  r(q) = Z(q)ᵀ f(q),   r = 0 at rest,   Z(q): Z made tangent to the contacts of q
//! (3)  K = −∂r/∂q Z = Zᵀ (−∂f/∂q) Z − (∂Z/∂q Z)ᵀ f,   M = Zᵀ M Z,   K x = ω² M x
//! ```
//!
//! Rolling is not holonomic: `K` is not symmetric. Its first part is the tangent of the scene. A step along `Z` is a rolling motion to
//! first order, so that a central difference of `Z` alone is the second part to second order in the step: what is stiff takes no part in it.

use super::Unanswered;
use super::closed::Scene;
use super::supports::{Bearers, Bears};
use crate::contact::support::Cone;
use crate::dynamics::System;
use crate::model::Model;
use crate::motion::displace;
use crate::round_off::SINGULAR_VALUE;
use crate::sparse::{SparseRows, kernel};
use crate::statics::certify::modes::NaturalMode;
use crate::statics::certify::stability::Stability;
use crate::statics::problem::sizes::NEUTRAL;
use crate::transfer::mass::MassAction;
use faer::{Mat, Side};
use std::sync::Arc;

/// Step of the difference, in parts of the scene's length (rad): its square is the relative error of `K`.
const STEP: f64 = 1e-4;

/// What kind of rest it is along the motions that nothing holds.
pub(super) fn stability(
    model: &Arc<Model>,
    pose: &[f64],
    gap: f64,
    bearers: &Bearers,
    forces: &[f64],
) -> Result<Stability, Unanswered> {
    let bears: Vec<usize> = (0..bearers.list.len()).filter(|i| holds(bearers, *i, forces)).collect();
    let free = null_space(bearers, &bears);
    let modes = match free.ncols() {
        0 => Vec::new(),
        k => match rolling(model, pose, gap, bearers, &free) {
            Ok(modes) => modes,
            // Nothing presses where it would have to give way: it is free there, to one side.
            Err(Unanswered::Untouchable(_)) => {
                return Ok(Stability::of(0, k, Vec::new(), Vec::new()));
            }
            Err(other) => return Err(other),
        },
    };
    let unstable = modes.iter().filter(|mode| mode.growth_rate > 0.0).count();
    let neutral = modes.iter().filter(|mode| mode.growth_rate == 0.0 && mode.frequency_hz == 0.0).count();
    Ok(Stability::of(unstable, neutral, modes, Vec::new()))
}

/// Whether a support keeps its rows: it bears, with forces as far inside of all cones as they can be.
fn holds(bearers: &Bearers, support: usize, forces: &[f64]) -> bool {
    let f = &forces[bearers.supports.range(support)];
    match bearers.supports.cones()[support] {
        Cone::Free => true,
        Cone::Ray => f[0] > 0.0,
        Cone::Coulomb { .. } => f[0] > 0.0,
        Cone::Ball { bound, .. } => bound > 0.0,
    }
}

/// `Z` in coordinates divided by their units: an orthonormal basis of the motions that these supports leave.
fn null_space(bearers: &Bearers, supports: &[usize]) -> Mat<f64> {
    let mut rows = vec![Vec::new(); bearers.load.len()];
    let columns = supports.iter().flat_map(|support| bearers.supports.scaled_columns(*support));
    let mut count = 0;
    for column in columns {
        column.into_iter().for_each(|(row, entry)| rows[row].push((count, entry)));
        count += 1;
    }
    kernel(&SparseRows::of(rows), count)
}

fn rolling(
    model: &Arc<Model>,
    pose: &[f64],
    gap: f64,
    bearers: &Bearers,
    free: &Mat<f64>,
) -> Result<Vec<NaturalMode>, Unanswered> {
    let (n, k) = (free.nrows(), free.ncols());
    let length = model.length_scale();
    let in_scene = |row: usize| bearers.supports.unit(row);
    let mut stiffness = along(model, pose, bearers, free)?;
    // What entries are known to: those of a part each by its own rounding, and the square of the step of the other.
    let largest = stiffness.col_iter().flat_map(|column| column.iter().map(|x| x.abs())).fold(0.0, f64::max);
    // Loads over the scene's length are the stiffness that could be there.
    let size = bearers.load.iter().fold(0.0_f64, |most, load| most.max(load.abs())) / length;
    let known = SINGULAR_VALUE.of(n as f64 * largest) + 1e2 * NEUTRAL.max(STEP * STEP) * size;
    let force: Vec<f64> = bearers.load.iter().enumerate().map(|(row, f)| f / in_scene(row)).collect();
    for j in 0..k {
        for sign in [1.0, -1.0] {
            let mut moved = pose.to_vec();
            let step: Vec<f64> = (0..n).map(|row| sign * STEP * length * free[(row, j)] / in_scene(row)).collect();
            displace(model, &mut moved, &step);
            let scene = Scene::new(model, &moved, gap)?;
            let there = Bearers::new(model, &moved, &scene)?;
            let touching: Vec<usize> = (0..there.list.len()).filter(|i| keeps(&there, *i, bearers)).collect();
            let tangent = null_space(&there, &touching);
            // Z(q) = T Tᵀ Z for the orthonormal motions T of the contacts there.
            let along: Vec<f64> =
                (0..tangent.ncols()).map(|t| (0..n).map(|row| tangent[(row, t)] * force[row]).sum()).collect();
            for i in 0..k {
                let back: f64 = (0..tangent.ncols())
                    .map(|t| along[t] * (0..n).map(|row| tangent[(row, t)] * free[(row, i)]).sum::<f64>())
                    .sum();
                stiffness[(i, j)] -= sign * back / (2.0 * STEP * length);
            }
        }
    }
    let mass = mass(model, pose, bearers, free)?;
    Ok(modes(&stiffness, &mass, known, bearers, free))
}

/// `Zᵀ (−∂f/∂q) Z`.
fn along(model: &Arc<Model>, pose: &[f64], bearers: &Bearers, free: &Mat<f64>) -> Result<Mat<f64>, Unanswered> {
    let (n, k) = (free.nrows(), free.ncols());
    let unit = |row: usize| bearers.supports.unit(row);
    let z = Mat::from_fn(n, k, |row, j| free[(row, j)] / unit(row));
    let mut product = System::new(model).at(0.0, pose, &vec![0.0; n]).stiffness_times(&z)?;
    for stop in &model.stops {
        let pressed = stop.pressed(pose).map_or(0.0, |[stiffness, _]| stiffness);
        (0..k).for_each(|j| product[(stop.velocity, j)] += pressed * z[(stop.velocity, j)]);
    }
    Ok(Mat::from_fn(k, k, |i, j| (0..n).map(|row| z[(row, i)] * product[(row, j)]).sum()))
}

/// Whether a support of a moved pose is one of those that bear: of the same two bodies, or the same hinge.
fn keeps(there: &Bearers, support: usize, bearers: &Bearers) -> bool {
    match there.list[support] {
        Bears::Contact(_) => true,
        other => bearers.list.contains(&other),
    }
}

/// `Zᵀ M Z`.
fn mass(model: &Arc<Model>, pose: &[f64], bearers: &Bearers, free: &Mat<f64>) -> Result<Mat<f64>, Unanswered> {
    let (n, k) = (free.nrows(), free.ncols());
    let mut system = System::new(model);
    let rest = vec![0.0; n];
    let at = system.at(0.0, pose, &rest);
    let mut action = MassAction::new(model);
    let motion = |j: usize| -> Vec<f64> { (0..n).map(|row| free[(row, j)] / bearers.supports.unit(row)).collect() };
    let mut mass = Mat::zeros(k, k);
    let mut product = vec![0.0; n];
    for j in 0..k {
        at.mass_times(&mut action, &motion(j), &mut product);
        for i in 0..k {
            mass[(i, j)] = motion(i).iter().zip(&product).map(|(z, p)| z * p).sum();
        }
    }
    Ok(mass)
}

/// The roots of (3): running away first, then neutral, then by frequency; entries of `K` are `known` to so much.
fn modes(stiffness: &Mat<f64>, mass: &Mat<f64>, known: f64, bearers: &Bearers, free: &Mat<f64>) -> Vec<NaturalMode> {
    let k = free.ncols();
    let Ok(factor) = mass.llt(Side::Lower) else { return Vec::new() };
    use faer::linalg::solvers::Solve;
    let ratio = factor.solve(stiffness);
    let Ok(eigen) = ratio.eigen() else { return Vec::new() };
    let mut modes: Vec<NaturalMode> = (0..k)
        .map(|i| {
            let value = eigen.S()[i];
            let (square, flutter) = (value.re, value.im.abs());
            let x: Vec<f64> = (0..k).map(|j| eigen.U()[(j, i)].re).collect();
            let of_mass = |a: usize| (0..k).map(|b| mass[(a, b)] * x[b]).sum::<f64>();
            let inertia: f64 = (0..k).map(|a| x[a] * of_mass(a)).sum();
            // What is rounding of K along this motion.
            let zero = known * x.iter().map(|x| x * x).sum::<f64>() / inertia;
            // q̈ = −λ q: growth is the real part of √−λ.
            let root = ((square.hypot(flutter) - square) / 2.0).max(0.0).sqrt();
            // Of a complex pair one grows, and one decays.
            let grows = if flutter > zero { value.im < 0.0 } else { square < -zero };
            let growth_rate = if grows { root } else { 0.0 };
            let frequency_hz = if square > zero { square.sqrt() / std::f64::consts::TAU } else { 0.0 };
            let shape = (0..free.nrows())
                .map(|row| (0..k).map(|j| x[j] * free[(row, j)]).sum::<f64>() / bearers.supports.unit(row))
                .collect::<Vec<f64>>();
            let largest = shape.iter().fold(f64::MIN_POSITIVE, |most, x| if x.abs() > most.abs() { *x } else { most });
            NaturalMode {
                frequency_hz,
                growth_rate,
                swings: square >= -zero && flutter <= zero,
                shape: shape.iter().map(|x| x / largest).collect(),
                shares: Vec::new(),
            }
        })
        .collect();
    let order = |mode: &NaturalMode| (mode.growth_rate == 0.0, mode.frequency_hz);
    modes.sort_by(|a, b| order(a).partial_cmp(&order(b)).unwrap_or(std::cmp::Ordering::Equal));
    modes
}
