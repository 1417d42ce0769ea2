//! The step of a trust region: Newton's, cut to it; with a shift from one factorization for every trial, or from a space of solutions.

use super::{NO_SIGN, Newton, Search, Trial};
use crate::statics::search::krylov::Krylov;

/// Poles that are tried for the space of one step, and what the next one is larger by where nothing is known.
const MOST_POLES: usize = 30;
const NEXT_POLE: f64 = 10.0;
/// How far a pole is above the lowest eigenvalue, as part of that.
const ABOVE: f64 = 0.1;
/// Trials for one step's shift.
const MOST_SHIFTS: usize = 40;
/// Inverse iterations for the lowest mode in the hard case, at a shift within a thousandth of its curvature.
const LOWEST: usize = 4;
/// Newton's step is cut to this part of it at least: a region smaller than that turns the step towards the force. Of nets let down from flat
/// the first step is long: 50 × 50 balls take 0.05 of it, 200 × 200 0.002. Turned steps crumple them, and unfolding takes three times as many.
const LEAST_CUT: f64 = 1e-3;

impl Search<'_, '_> {
    /// Newton's step of a sparse tangent, cut to the region if the stiffness is definite and that leaves enough of it.
    pub(super) fn cut_newton(&mut self) -> Option<Trial> {
        if self.shift != 0.0 {
            return None;
        }
        if matches!(self.newton, Newton::Unknown) {
            self.is_at_pole = false;
            self.newton = match self.landscape.factorize(0.0) {
                true => {
                    let x = self.landscape.solve(&self.outcome.place.force);
                    let size = self.landscape.size(&x);
                    if size.is_finite() { Newton::Step(x, size) } else { Newton::None }
                }
                false => Newton::None,
            };
        }
        let Newton::Step(x, whole) = &self.newton else { return None };
        let part = if *whole > self.radius { self.radius / whole } else { 1.0 };
        let x = || x.iter().map(|x| part * x).collect();
        (part >= LEAST_CUT).then(|| Trial { x: x(), size: part * whole, shift: 0.0, part })
    }

    /// The step of the trust region in a space of solutions with one factorization. Its pole is the last shift, or above the lowest
    /// eigenvalue of the place before; one that turns out too low is raised, one too far from `σ` is put there.
    pub(super) fn within_space(&mut self) -> Option<Trial> {
        let (metric, radius) = (self.landscape.metric.clone(), self.radius);
        let force = self.outcome.place.force.clone();
        let typical = force.iter().zip(&metric).map(|(f, b)| f * (f / b)).sum::<f64>().sqrt() / radius;
        let mut pole = self.shift.max((1.0 + ABOVE) * -self.lowest);
        // What is known to be too low, and to be high enough.
        let (mut low, mut high) = (0.0_f64, f64::INFINITY);
        for _ in 0..MOST_POLES {
            if let Some(krylov) = &self.krylov {
                high = high.min(krylov.pole());
            } else {
                let is_regular = self.landscape.factorize(pole);
                self.is_at_pole = is_regular;
                self.krylov = if is_regular { self.space_of(pole, &force, &metric) } else { None };
                if self.krylov.is_none() {
                    low = low.max(pole);
                    pole = match high.is_finite() {
                        true => (low.max(1e-6 * high) * high).sqrt(),
                        false => (NEXT_POLE * low).max(1e-3 * typical),
                    };
                    continue;
                }
                high = high.min(pole);
            }
            let (shift, lowest, step) = self.settle(&metric, radius)?;
            self.lowest = lowest;
            if let Some(x) = step {
                let size = self.landscape.size(&x);
                self.shift = shift;
                return Some(Trial { x, size, shift, part: 1.0 }).filter(|trial| trial.size.is_finite());
            }
            self.krylov = None;
            pole = shift.max(low + ABOVE * (shift - low)).max((1.0 + ABOVE) * -lowest);
            if pole <= low {
                pole = (low.max(1e-6 * high) * high).sqrt();
            }
        }
        None
    }

    /// The space of the stiffness that was factorized with a shift.
    fn space_of(&mut self, pole: f64, force: &[f64], metric: &[f64]) -> Option<Krylov> {
        let some = |(i, b): (usize, &f64)| b.sqrt() * (0.5 + (i as f64 * 1.618_033_988_75).fract());
        let other: Vec<f64> = metric.iter().enumerate().map(some).collect();
        let (first, other) = (self.landscape.solve_roughly(force), self.landscape.solve_roughly(&other));
        Krylov::new(pole, metric, first, &other)
    }

    /// Lets the space grow until the step is settled: `σ`, the lowest eigenvalue, and the step, if it is.
    fn settle(&mut self, metric: &[f64], radius: f64) -> Option<(f64, f64, Option<Vec<f64>>)> {
        let mut krylov = self.krylov.take()?;
        let mut found = if krylov.is_empty() { None } else { krylov.within(radius) };
        while found.as_ref().is_none_or(|(within, _)| !within.is_settled) && krylov.grows() {
            if !self.is_at_pole {
                self.is_at_pole = self.landscape.factorize(krylov.pole());
                if !self.is_at_pole {
                    return None;
                }
            }
            let next = self.landscape.solve_roughly(&krylov.last(metric));
            krylov.grow(metric, next);
            found = krylov.within(radius);
        }
        let (within, y) = found?;
        let step = within.is_settled.then(|| krylov.step(&y));
        self.krylov = Some(krylov);
        Some((within.shift, within.lowest, step))
    }

    /// The step of the trust region: `σ` bracketed and found by Newton on the secular equation.
    pub(super) fn within_radius(&mut self) -> Option<Trial> {
        let (metric, force, radius) = (self.landscape.metric.clone(), &self.outcome.place.force, self.radius);
        let typical = force.iter().zip(&metric).map(|(f, b)| f * (f / b)).sum::<f64>().sqrt() / radius;
        let (mut low, mut high) = (0.0_f64, f64::INFINITY);
        let mut least = f64::INFINITY;
        let between = |low: f64, high: f64| match high.is_finite() {
            true => (low.max(1e-6 * high) * high).sqrt(),
            false => (4.0 * low).max(1e-3 * typical),
        };
        let mut shift = self.shift;
        let mut best = None;
        for _ in 0..MOST_SHIFTS {
            least = least.min(shift);
            if !self.landscape.factorize(shift) {
                low = low.max(shift);
                shift = between(low, high);
                continue;
            }
            let x = self.landscape.solve(force);
            let size = self.landscape.size(&x);
            if !size.is_finite() {
                low = low.max(shift);
                shift = between(low, high);
                continue;
            }
            let narrow = high.is_finite() && high - low < 1e-3 * high;
            let done = size <= 1.1 * radius && (shift == 0.0 || size >= 0.75 * radius || narrow);
            let weighted: Vec<f64> = x.iter().zip(&metric).map(|(x, b)| b * x).collect();
            if size <= 1.1 * radius {
                best = Some(Trial { x, size, shift, part: 1.0 });
            }
            if done {
                break;
            }
            if size < radius {
                high = high.min(shift);
            } else {
                low = low.max(shift);
            }
            let y = self.landscape.solve(&weighted);
            let slope: f64 = weighted.iter().zip(&y).map(|(w, y)| w * y).sum();
            let new = shift + (size / radius - 1.0) * size * size / slope;
            shift = match low < new && new < high {
                true => new,
                // The region may hold the whole Newton step.
                false if new <= 0.0 && least > 0.0 => 0.0,
                false => between(low, high),
            };
        }
        self.shift = best.as_ref().map_or(self.shift, |trial: &Trial| trial.shift);
        best.map(|trial| if trial.shift > 0.0 && trial.size < 0.75 * radius { self.with_lowest(trial) } else { trial })
    }

    /// The hard case of Moré and Sorensen: forces without a part along the lowest mode `z`, as in a symmetric pose, leave
    /// `x(σ)` within the region for every `σ > −λ₁`. The step is then `x + τ z` of size Δ; as `(K + σB) z ≈ 0`, it gains what
    /// [`Search::predicted`] says with that size.
    fn with_lowest(&mut self, trial: Trial) -> Trial {
        if !self.landscape.factorize(trial.shift) {
            return trial;
        }
        let metric = self.landscape.metric.clone();
        let mut z: Vec<f64> =
            metric.iter().enumerate().map(|(i, b)| (0.5 + (i as f64 * 1.618_033_988_75).fract()) / b.sqrt()).collect();
        let mut size = self.landscape.size(&z);
        for _ in 0..LOWEST {
            let weighted: Vec<f64> = z.iter().zip(&metric).map(|(z, b)| b * z / size).collect();
            z = self.landscape.solve(&weighted);
            size = self.landscape.size(&z);
        }
        // λ₁ = 1/|(K + σB)⁻¹ B z| − σ. Along a motion of zero stiffness nothing falls: a step along it would only carry the scene away.
        let curvatures = self.outcome.place.scales.stiffness.iter().zip(&metric).map(|(k, b)| k / b);
        let is_lowest = size.is_finite() && trial.shift - 1.0 / size > NO_SIGN * curvatures.fold(0.0, f64::max);
        if !is_lowest {
            return trial;
        }
        z.iter_mut().for_each(|z| *z /= size);
        let along: f64 = trial.x.iter().zip(&z).zip(&metric).map(|((x, z), b)| b * x * z).sum();
        let rest = self.radius * self.radius - trial.size * trial.size;
        let sign = if along < 0.0 { -1.0 } else { 1.0 };
        let part = -along + sign * (along * along + rest).max(0.0).sqrt();
        let x: Vec<f64> = trial.x.iter().zip(&z).map(|(x, z)| x + part * z).collect();
        let size = self.landscape.size(&x);
        Trial { x, size, shift: trial.shift, part: 1.0 }
    }
}
