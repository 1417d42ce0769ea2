//! Damped modes: how the linearized motion dies away.
//!
//! `M ẍ + C ẋ + K x = 0` with `x = X e^(st)` is written in first order, lengths of time in units of `1/ω`:
//!
//! ```text
//!      [  0        ω 1 ]
//! s =  [               ],   y = (ω x, ẋ),   ω² = |M⁻¹ K|                                      (1)
//!      [ −M⁻¹K/ω  −M⁻¹C ]
//! ```
//!
//! A pair of complex roots is one mode that swings, a real root one that creeps.

use super::eigen;
use super::modes::{NaturalMode, momentum, scaled, shares};
use crate::dynamics::{Linearization, System};
use crate::model::Model;
use crate::round_off::DOUBLE_ROOT;
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};
use std::sync::Arc;

/// A damped mode.
#[derive(Debug, Clone, PartialEq)]
pub struct DampedMode {
    /// Amplitudes fall as `e^(−rate t)` (1/s); negative where they grow.
    pub decay_rate: f64,
    /// Frequency of the swing (Hz); 0 for one that creeps.
    pub frequency_hz: f64,
    /// Decay rate over `|s|`: 0 undamped, 1 for what creeps, negative where it grows.
    pub damping_ratio: f64,
    /// Bodies whose hinges carry it and their share of its kinetic energy, largest first.
    pub shares: Vec<(String, f64)>,
    /// Shape, one number per free coordinate, largest 1; its parts a quarter period apart.
    pub shape: [Vec<f64>; 2],
}

/// All damped modes: by frequency, then by decay.
pub(in crate::statics) fn modes(model: &Model, free: &[usize], linear: &Linearization) -> Vec<DampedMode> {
    of_motions(model, free, linear, &linear.mass, &|part| part)
}

/// All damped modes of motions `y` that are `of(y)` in free coordinates, whose mass matrix is `mass`.
pub(in crate::statics) fn of_motions(
    model: &Model,
    free: &[usize],
    linear: &Linearization,
    mass: &Mat<f64>,
    of: &dyn Fn(Vec<f64>) -> Vec<f64>,
) -> Vec<DampedMode> {
    let n = linear.mass.nrows();
    let lu = linear.mass.partial_piv_lu();
    let (k, c) = (lu.solve(&linear.stiffness), lu.solve(&linear.damping));
    let of_pair = |root: c64, parts: [Vec<f64>; 2]| {
        let shapes = parts.map(of);
        let momenta = shapes.each_ref().map(|part| momentum(mass, part));
        named(model, free, root, shapes, &momenta)
    };
    let mut found: Vec<DampedMode> = roots(&k, &c, n).into_iter().map(|(root, parts)| of_pair(root, parts)).collect();
    sort(&mut found);
    found
}

/// The modes of `M ẍ + G ẋ + K x = 0`, the motion without its damping: `G` is the part of `C` that does no work, which a steady
/// motion has by Coriolis forces, and `K` may be without a potential. Of each pair ±s one is a mode: what grows first, then what has no
/// stiffness, then by frequency.
pub(in crate::statics) fn natural(
    model: &Model,
    free: &[usize],
    linear: &Linearization,
    mass: &Mat<f64>,
    of: &dyn Fn(Vec<f64>) -> Vec<f64>,
) -> Vec<NaturalMode> {
    let n = linear.mass.nrows();
    let c = &linear.damping;
    let undamped = Linearization {
        damping: Mat::from_fn(n, n, |i, j| 0.5 * (c[(i, j)] - c[(j, i)])),
        stiffness: linear.stiffness.clone(),
        mass: linear.mass.clone(),
    };
    let mut neutral = 0;
    let mut one_of_each = |mode: DampedMode| {
        if mode.frequency_hz == 0.0 && mode.decay_rate == 0.0 {
            neutral += 1;
            // Both roots are zero.
            if neutral % 2 == 0 {
                return None;
            }
        }
        let grows = mode.damping_ratio < -GROWS;
        let [real, imaginary] = mode.shape;
        let size = |shape: &[f64]| shape.iter().map(|x| x * x).sum::<f64>();
        let shape = if size(&real) >= size(&imaginary) { real } else { imaginary };
        (mode.damping_ratio <= GROWS).then(|| NaturalMode {
            frequency_hz: mode.frequency_hz,
            growth_rate: if grows { -mode.decay_rate } else { 0.0 },
            shape: scaled(&shape),
            shares: mode.shares,
        })
    };
    let found = of_motions(model, free, &undamped, mass, of);
    let mut modes: Vec<NaturalMode> = found.into_iter().filter_map(&mut one_of_each).collect();
    modes.sort_by(|a, b| b.growth_rate.total_cmp(&a.growth_rate).then(a.frequency_hz.total_cmp(&b.frequency_hz)));
    modes
}

/// The damped motion of a large system within the space of its lowest undamped modes. `momenta` are `M x` of each.
pub(in crate::statics) fn within(
    system: &mut System,
    q: &[f64],
    free: &[usize],
    modes: &[(f64, Vec<f64>)],
    momenta: &[Vec<f64>],
) -> Vec<DampedMode> {
    let (model, count) = (&Arc::clone(system.model()), modes.len());
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let size: Vec<f64> = modes.iter().zip(momenta).map(|((_, x), p)| dot(x, p).sqrt()).collect();
    // `C x`, from balances with velocities `x` and `−x`: what is quadratic in them cancels.
    let n = model.velocity_count();
    let mut damped = Vec::new();
    for (_, x) in modes {
        let (mut velocity, mut there, rest) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let mut back = there.clone();
        free.iter().zip(x).for_each(|(i, x)| velocity[*i] = *x);
        let forth = system.at(0.0, q, &velocity).residual(&rest, &mut there).is_ok();
        velocity.iter_mut().for_each(|v| *v = -*v);
        if !forth || system.at(0.0, q, &velocity).residual(&rest, &mut back).is_err() {
            return Vec::new();
        }
        damped.push(free.iter().map(|i| 0.5 * (there[*i] - back[*i])).collect::<Vec<f64>>());
    }
    let k = Mat::from_fn(count, count, |i, j| if i == j { modes[i].0 } else { 0.0 });
    let c = Mat::from_fn(count, count, |i, j| dot(&modes[i].1, &damped[j]) / (size[i] * size[j]));
    let combined = |parts: &[f64], of: &[&[f64]]| {
        let mut sum = vec![0.0; free.len()];
        for ((part, size), of) in parts.iter().zip(&size).zip(of) {
            let part = part / size;
            sum.iter_mut().zip(*of).for_each(|(sum, x)| *sum += part * x);
        }
        sum
    };
    let vectors: Vec<&[f64]> = modes.iter().map(|(_, x)| &x[..]).collect();
    let momenta: Vec<&[f64]> = momenta.iter().map(Vec::as_slice).collect();
    let mut found: Vec<DampedMode> = roots(&k, &c, count)
        .into_iter()
        .map(|(root, parts)| {
            let shapes = parts.each_ref().map(|part| combined(part, &vectors));
            let momenta = parts.each_ref().map(|part| combined(part, &momenta));
            named(model, free, root, shapes, &momenta)
        })
        .collect();
    sort(&mut found);
    found
}

/// Roots of (1), one of each pair, with the real and the imaginary part of `x`.
pub(super) fn roots(k: &Mat<f64>, c: &Mat<f64>, n: usize) -> Vec<(c64, [Vec<f64>; 2])> {
    let largest = (0..n).map(|i| (0..n).map(|j| k[(i, j)].abs()).sum::<f64>()).fold(0.0, f64::max);
    let unit = if largest > 0.0 { largest.sqrt() } else { 1.0 };
    let first_order = Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => 0.0,
        (true, false) => unit * f64::from(u8::from(i + n == j)),
        (false, true) => -k[(i - n, j)] / unit,
        (false, false) => -c[(i - n, j - n)],
    });
    let Some(pairs) = eigen::pairs(&first_order) else { return Vec::new() };
    let one_of_each = |(root, vector): (c64, Vec<c64>)| {
        let size = root.re.hypot(root.im);
        let root = if size > DOUBLE_ROOT.of(unit) { root } else { c64::new(0.0, 0.0) };
        let swings = root.im.abs() > DOUBLE_ROOT.of(size);
        (!swings || root.im > 0.0).then(|| {
            let root = if swings { root } else { c64::new(root.re, 0.0) };
            let part = |of: fn(&c64) -> f64| vector[..n].iter().map(of).collect::<Vec<f64>>();
            (root, [part(|x| x.re), part(|x| x.im)])
        })
    };
    pairs.into_iter().filter_map(one_of_each).collect()
}

fn named(model: &Model, free: &[usize], root: c64, shape: [Vec<f64>; 2], momenta: &[Vec<f64>; 2]) -> DampedMode {
    let size = root.re.hypot(root.im);
    // Both parts as one list: the energy of a period is the sum of theirs.
    let both = shape.concat();
    let twice: Vec<usize> = free.iter().chain(free).copied().collect();
    let all = shares(model, &twice, &momenta.concat(), &both);
    let largest = scaled(&both);
    let (real, imaginary) = largest.split_at(free.len());
    DampedMode {
        decay_rate: -root.re,
        frequency_hz: root.im / std::f64::consts::TAU,
        damping_ratio: if size > 0.0 { -root.re / size } else { 0.0 },
        shares: all,
        shape: [real.to_vec(), imaginary.to_vec()],
    }
}

/// Slow ones first, by `|s|`: what decays within a thousandth of a second is not what one looks for.
fn sort(modes: &mut [DampedMode]) {
    let size = |mode: &DampedMode| mode.decay_rate.hypot(std::f64::consts::TAU * mode.frequency_hz);
    modes.sort_by(|a, b| size(a).total_cmp(&size(b)).then(a.decay_rate.total_cmp(&b.decay_rate)));
}

/// Motions that grow faster than this part of their `|s|` run away: what is less is the round-off of a double root.
const GROWS: f64 = 1e-6;

/// Whether a motion whose root has this real part and this size runs away.
pub(super) fn grows(real: f64, size: f64) -> bool {
    real > GROWS * size
}

/// How many motions run away: at least those along which the stiffness is negative, more if something feeds them, as a motor that
/// pushes with the speed does.
pub(in crate::statics) fn runaway(damped: &[DampedMode], unstable: usize) -> usize {
    damped.iter().filter(|mode| mode.damping_ratio < -GROWS).count().max(unstable)
}

/// Growth rates of the damped motion for the modes that run away.
pub(in crate::statics) fn grow(modes: &mut [NaturalMode], damped: &[DampedMode], unstable: usize) {
    let mut rates: Vec<f64> = damped.iter().map(|mode| -mode.decay_rate).collect();
    rates.sort_by(|a, b| b.total_cmp(a));
    for (mode, rate) in modes.iter_mut().take(unstable).zip(rates) {
        mode.growth_rate = rate;
    }
}

/// Of loads without a potential the damped motion alone says what grows: undamped, such loads feed pairs of motions of nearly one
/// frequency however small they are.
pub(in crate::statics) fn still(modes: &mut [NaturalMode], damped: &[DampedMode]) {
    // One that swings is a pair of roots, as it is a pair of modes.
    let twice = |mode: &DampedMode| std::iter::repeat_n(-mode.decay_rate, if mode.frequency_hz > 0.0 { 2 } else { 1 });
    let mut rates: Vec<f64> = damped.iter().filter(|mode| mode.damping_ratio < -GROWS).flat_map(twice).collect();
    rates.sort_by(|a, b| b.total_cmp(a));
    let mut rates = rates.into_iter();
    modes.iter_mut().for_each(|mode| mode.growth_rate = rates.next().unwrap_or(0.0));
    modes.sort_by(|a, b| b.growth_rate.total_cmp(&a.growth_rate).then(a.frequency_hz.total_cmp(&b.frequency_hz)));
}
