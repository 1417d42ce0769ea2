//! Damped modes: how the linearized motion dies away.
//!
//! A pair of complex roots (see `motion`) is one mode that swings, a real root one that creeps.

use super::modes::{NaturalMode, momentum, scaled, shares};
use super::motion::{self, LinearMotion, Root};
use crate::dynamics::System;
use crate::model::Model;
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

/// All damped modes of motions `y` that are `of(y)` in free coordinates, whose mass matrix is `mass`: by frequency, then by decay.
pub(in crate::statics) fn modes(
    model: &Model,
    free: &[usize],
    motion: &LinearMotion,
    mass: &Mat<f64>,
    of: &dyn Fn(Vec<f64>) -> Vec<f64>,
) -> Vec<DampedMode> {
    all(model, free, motion.roots(), mass, of)
}

fn all(
    model: &Model,
    free: &[usize],
    roots: Vec<Root>,
    mass: &Mat<f64>,
    of: &dyn Fn(Vec<f64>) -> Vec<f64>,
) -> Vec<DampedMode> {
    let of_root = |Root { value, parts }: Root| {
        let shapes = parts.map(of);
        let momenta = shapes.each_ref().map(|part| momentum(mass, part));
        named(model, free, value, shapes, &momenta)
    };
    let mut found: Vec<DampedMode> = roots.into_iter().map(of_root).collect();
    sort(&mut found);
    found
}

/// The modes of `M ẍ + G ẋ + K x = 0`, the motion without its damping: `G` is the part of `C` that does no work, which a steady
/// motion has by Coriolis forces, and `K` may be without a potential. Of each pair ±s of real roots one is a mode, and each pair of complex
/// ones: what grows first, then what has no stiffness, then by frequency.
pub(in crate::statics) fn natural(
    model: &Model,
    free: &[usize],
    motion: &LinearMotion,
    mass: &Mat<f64>,
    of: &dyn Fn(Vec<f64>) -> Vec<f64>,
) -> Vec<NaturalMode> {
    let mut neutral = 0;
    let mut one_of_each = |mode: DampedMode| {
        if mode.frequency_hz == 0.0 && mode.decay_rate == 0.0 {
            neutral += 1;
            // Both roots are zero.
            if neutral % 2 == 0 {
                return None;
            }
        }
        let [real, imaginary] = mode.shape;
        let size = |shape: &[f64]| shape.iter().map(|x| x * x).sum::<f64>();
        let shape = if size(&real) >= size(&imaginary) { real } else { imaginary };
        (mode.decay_rate <= 0.0 || mode.frequency_hz > 0.0).then(|| NaturalMode {
            frequency_hz: mode.frequency_hz,
            growth_rate: (-mode.decay_rate).max(0.0),
            swings: mode.decay_rate == 0.0,
            shape: scaled(&shape),
            shares: mode.shares,
        })
    };
    let found = all(model, free, motion.undamped_roots(), mass, of);
    let mut modes: Vec<NaturalMode> = found.into_iter().filter_map(&mut one_of_each).collect();
    sort_natural(&mut modes);
    modes
}

fn sort_natural(modes: &mut [NaturalMode]) {
    modes.sort_by(|a, b| b.growth_rate.total_cmp(&a.growth_rate).then(a.frequency_hz.total_cmp(&b.frequency_hz)));
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
    let mut found: Vec<DampedMode> = motion::of(&k, &c)
        .into_iter()
        .map(|Root { value, parts }| {
            let shapes = parts.each_ref().map(|part| combined(part, &vectors));
            let momenta = parts.each_ref().map(|part| combined(part, &momenta));
            named(model, free, value, shapes, &momenta)
        })
        .collect();
    sort(&mut found);
    found
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

/// How many motions run away: at least those along which the stiffness is negative, more if something feeds them, as a motor that
/// pushes with the speed does.
pub(in crate::statics) fn runaway(damped: &[DampedMode], unstable: usize) -> usize {
    damped.iter().filter(|mode| mode.decay_rate < 0.0).count().max(unstable)
}

/// Growth rates of the damped motion for the modes along which the stiffness is negative, or if something feeds others for those.
pub(in crate::statics) fn grow(modes: &mut [NaturalMode], damped: &[DampedMode], unstable: usize) {
    if runaway(damped, unstable) > unstable {
        return label(modes, damped);
    }
    let mut rates: Vec<f64> = damped.iter().map(|mode| -mode.decay_rate).collect();
    rates.sort_by(|a, b| b.total_cmp(a));
    for (mode, rate) in modes.iter_mut().take(unstable).zip(rates) {
        mode.growth_rate = rate;
    }
}

/// Of loads without a potential, of steady motions and of what is fed the damped motion alone says what grows: undamped, such loads feed
/// pairs of motions of nearly one frequency however small they are. A damped mode that grows is the undamped one whose root is nearest to
/// its own, the fastest first; each keeps its undamped frequency.
pub(in crate::statics) fn label(modes: &mut [NaturalMode], damped: &[DampedMode]) {
    let undamped: Vec<[f64; 2]> = modes.iter().map(|mode| [mode.growth_rate, mode.frequency_hz]).collect();
    let mut growing: Vec<&DampedMode> = damped.iter().filter(|mode| mode.decay_rate < 0.0).collect();
    growing.sort_by(|a, b| a.decay_rate.total_cmp(&b.decay_rate));
    let mut left: Vec<usize> = (0..modes.len()).collect();
    modes.iter_mut().for_each(|mode| mode.growth_rate = 0.0);
    for mode in growing {
        let away = |k: &usize| {
            let [growth, hertz] = undamped[*k];
            (growth + mode.decay_rate).hypot(std::f64::consts::TAU * (hertz - mode.frequency_hz))
        };
        let nearest = (0..left.len()).min_by(|a, b| away(&left[*a]).total_cmp(&away(&left[*b])));
        let Some(nearest) = nearest else { break };
        modes[left.swap_remove(nearest)].growth_rate = -mode.decay_rate;
    }
    sort_natural(modes);
}
