//! Newton within a trust region: goes down the potential, so it ends at a stable equilibrium or says why not.
//!
//! ```text
//! step      (K + σB) x = f,   |x|_B ≤ Δ,   σ ≥ 0,   K + σB positive definite          (Moré & Sorensen 1983)
//! σ from Newton on the secular equation |x(σ)|_B = Δ:
//!           σ ← σ + (|x|/Δ − 1) |x|² / (xᵀ B y),   (K + σB) y = B x
//! ```
//!
//! Where `|x(σ)|_B < Δ` for every σ that makes `K + σB` definite (the hard case) the lowest mode makes up the rest.
//! `B` is the inertia that each hinge sees, so radians and metres compare. With σ = 0 the step is Newton's. At a point
//! without force where K has negative directions (a saddle, a dead centre) the search leaves along
//! one of them.
//!
//! **Sparse tangents** take far longer to factorize than to solve with, and than the forces to evaluate. There Newton's step, as long as
//! `K` is definite, is cut to the region instead, and what needs a shift is found in a space of solutions with one factorization
//! ([`Krylov`]): further trials of either take no factorization.
//!
//! **Rigid limits** bound the coordinates of a tree. The active set is chosen at every place (see
//! [`crate::statics::problem`]), the step is that of the free coordinates, a coordinate at its limit that the step would push
//! beyond is held for it, and every other one ends at its limits. A step that is cut there is measured by `½ fᵀ x`: short
//! enough it goes along the projected gradient, so that the potential falls. Among loops and gears the search halts at the
//! first limit on its way instead (see [`super::active`]).

mod steps;

use super::krylov::Krylov;
use super::progress::Progress;
use super::saddle::{NO_SIGN, WayOut, downhill, way_out};
use crate::dynamics::Fault;
use crate::round_off::ENERGY;
use crate::statics::certify::cone;
use crate::statics::certify::falling::Fall;
use crate::statics::effort::Iteration;
use crate::statics::problem::place::{BALANCED, Place};
use crate::statics::problem::{FAR, Landscape};

/// Steps, and sweeps over one link (or entries of a matrix, if there is one): what fails says so in seconds, a large scene
/// in some tens of them. Beside springs of 10⁹ N/m, or bodies a million times heavier than others, twenty thousand steps may
/// be the way along a valley.
const MOST_ITERATIONS: usize = 40_000;
const MOST_WORK: usize = 16_000_000;
/// Minimum iterations, and sweeps, before stagnation is judged.
const LEAST_ITERATIONS: [usize; 2] = [400, 4000];
const LEAST_SWEEPS: usize = 4_000_000;
/// A search of more steps goes along a valley that bends, or falls for ever: after every so many steps it is asked whether it does.
const BENT: usize = 40;
/// Part of a step over which its bend is differenced.
const PART: f64 = 1e-2;
/// A step is taken if the potential falls by this part of what the quadratic model says. With steps that are worth
/// next to nothing a long chain crumples, and takes four times as long to unfold.
const WORTH: f64 = 0.1;
/// What a cut step is shortened by at once: within these bounds to where a parabola through its gain has its lowest point.
const SHORTENED: [f64; 2] = [0.1, 0.6];
/// How the search ended.
#[derive(Debug, Clone)]
pub(in crate::statics) struct Outcome {
    pub place: Place,
    /// Saddles that were left, each with the velocity coordinates that carried the direction of negative curvature.
    pub left: Vec<Vec<usize>>,
    /// Whether the potential fell without end.
    pub fell: bool,
    /// The motion along which it does, where one is known.
    pub fall: Option<Fall>,
    /// Whether a step needed a shift: else the whole search was Newton's.
    pub shifted: bool,
}

struct Search<'l, 's> {
    landscape: &'l mut Landscape<'s>,
    /// Δ (m √kg).
    radius: f64,
    /// Where Δ begins, and begins again after a saddle.
    first_radius: f64,
    potential: f64,
    /// The shift of the last step: where the search for the next one starts.
    shift: f64,
    /// Whether the way down bends: then steps are corrected.
    bent: bool,
    /// Of a sparse tangent Newton's step from the place, found at the first trial there.
    newton: Newton,
    /// Of a sparse tangent the space in which steps from the place are looked for, and whether the last factorization is that of its
    /// pole.
    krylov: Option<Krylov>,
    is_at_pole: bool,
    /// Of a sparse tangent the lowest eigenvalue at the last place where it was asked for.
    lowest: f64,
    outcome: Outcome,
}

/// Runs from `place`. Needs loads with a potential.
pub(in crate::statics) fn run(
    landscape: &mut Landscape<'_>,
    place: Place,
    history: &mut Vec<Iteration>,
) -> Result<Outcome, Fault> {
    let potential = landscape.potential(&place.q);
    // One radian, or one length of the scene, of every coordinate at once.
    let radius = landscape.reach();
    // A scene that has moved so many of its lengths downhill, or of the guess's distance from where its springs are relaxed, has
    // no equilibrium.
    let far = FAR * radius.max(distance_from_rest(landscape, &place.q));
    let outcome = Outcome { place, left: Vec::new(), fell: false, fall: None, shifted: false };
    let mut search = Search {
        landscape,
        radius,
        first_radius: radius,
        potential,
        shift: 0.0,
        bent: false,
        newton: Newton::Unknown,
        krylov: None,
        is_at_pole: false,
        lowest: 0.0,
        outcome,
    };
    let mut travelled = 0.0;
    let mut progress = Progress::new(potential);
    let (links, work) = (search.landscape.model().links.len(), search.landscape.work());
    let least = (LEAST_SWEEPS / links).clamp(LEAST_ITERATIONS[0], LEAST_ITERATIONS[1]);
    let most = (MOST_WORK / work).clamp(least, MOST_ITERATIONS);
    for iteration in 0..most {
        if !search.landscape.goes_on() {
            break;
        }
        if let Some(place) = search.landscape.choose_active(&search.outcome.place.q)? {
            search.outcome.place = place;
        }
        search.bent = iteration >= BENT;
        if iteration % BENT == BENT - 1 || travelled > far {
            search.outcome.fall = search.landscape.falling(&search.outcome.place.q);
        }
        if travelled > far || search.outcome.fall.is_some() {
            search.outcome.fell = true;
            break;
        }
        if search.outcome.place.is_balanced() {
            if !(search.leave_saddle(history)? || search.leave_stops(history)?) {
                break;
            }
            continue;
        }
        let Some(step) = search.step(history)? else { break };
        if search.landscape.halted_at().is_some() {
            break;
        }
        travelled += step;
        if !progress.goes_on(iteration, search.potential, search.outcome.place.residual().0) {
            break;
        }
    }
    Ok(search.outcome)
}

/// How far turns and slides are from where their springs are relaxed (m √kg).
fn distance_from_rest(landscape: &Landscape<'_>, q: &[f64]) -> f64 {
    let model = landscape.model();
    let mut away = vec![0.0; model.velocity_count()];
    for link in model.links.iter().filter(|link| link.joint.counts() == (1, 1)) {
        away[link.velocity] = q[link.position] - model.coordinates[link.velocity].rest;
    }
    let away: Vec<f64> = landscape.free.iter().map(|i| away[*i]).collect();
    landscape.size(&away)
}

/// Newton's step from one place.
enum Newton {
    Unknown,
    /// It is known by its size; the stiffness is definite.
    Step(Vec<f64>, f64),
    /// The stiffness is not definite.
    None,
}

/// A trial step and what the quadratic model says of it.
struct Trial {
    x: Vec<f64>,
    size: f64,
    shift: f64,
    /// Which part of the step with this shift it is.
    part: f64,
}

impl Trial {
    /// The beginning of it.
    fn up_to(self, part: f64) -> Self {
        let x = self.x.iter().map(|x| part * x).collect();
        Self { x, size: part * self.size, shift: self.shift, part: part * self.part }
    }
}

/// Where a corrected step ends.
struct Lower {
    q: Vec<f64>,
    potential: f64,
}

impl Search<'_, '_> {
    /// One accepted step, or none where even the smallest region gives no descent. Returns its size.
    fn step(&mut self, history: &mut Vec<Iteration>) -> Result<Option<f64>, Fault> {
        self.landscape.look(&self.outcome.place.q)?;
        (self.newton, self.krylov) = (Newton::Unknown, None);
        let smallest = 1e-14 * self.radius.max(f64::MIN_POSITIVE);
        while self.radius > smallest && self.landscape.goes_on() {
            let trial = match self.landscape.is_written() {
                true => self.cut_newton().or_else(|| self.within_space()),
                false => self.within_radius(),
            };
            let Some(trial) = trial else {
                self.radius *= 0.25;
                continue;
            };
            let stretch = self.landscape.stretch(&self.outcome.place.q, &trial.x);
            if stretch > 1.0 {
                self.radius = trial.size.min(self.radius) * (0.9 / stretch).max(0.1);
                continue;
            }
            if self.hold_blocked(&trial.x)? {
                (self.newton, self.krylov) = (Newton::Unknown, None);
                continue;
            }
            let halt = self.landscape.halted(&self.outcome.place.q, &trial.x);
            let trial = trial.up_to(halt.map_or(1.0, |halt| halt.part));
            let taken = if trial.size > 0.0 { self.try_step(&trial, history)? } else { None };
            if let Some(halt) = halt.filter(|_| taken.is_some() || trial.size == 0.0) {
                self.landscape.halt_at(halt.stop, &self.outcome.place.q);
            }
            if taken.is_some() || self.landscape.halted_at().is_some() {
                return Ok(taken);
            }
            if !(trial.size > 0.0) {
                // Nothing was tried: the shift is beyond all numbers, or so far above the stiffness that the step vanishes.
                self.radius *= 0.25;
            }
            // The trial moved the system: back to where the step starts.
            self.landscape.look(&self.outcome.place.q)?;
        }
        Ok(None)
    }

    /// Holds the coordinates at their limits that a step would push beyond, unless they carry all that is unbalanced.
    fn hold_blocked(&mut self, x: &[f64]) -> Result<bool, Fault> {
        let place = &self.outcome.place;
        let blocked = self.landscape.blocked(&place.q, x);
        let free = &self.landscape.free;
        let others = |row: &usize| !blocked.contains(&free[*row]);
        let unbalanced =
            |row: usize| place.force[row].abs() > place.scales.noise[row] + BALANCED * place.scales.force[row];
        if blocked.is_empty() || !(0..free.len()).filter(others).any(unbalanced) {
            return Ok(false);
        }
        self.landscape.hold(&blocked);
        self.outcome.place = Place::at(self.landscape, self.outcome.place.q.clone())?;
        self.landscape.look(&self.outcome.place.q)?;
        Ok(true)
    }

    /// What a step `x` is expected to gain, `½ (xᵀ f + σ |x|²)` since `xᵀ K x = xᵀ f − σ |x|²`, and `(1 − ½ p) xᵀ f` of the part
    /// `p` of Newton's; of one that limits cut `½ xᵀ f`.
    fn predicted(&self, trial: &Trial, linear: f64, is_cut: bool) -> f64 {
        let model = (1.0 - 0.5 * trial.part) * linear + 0.5 * trial.shift * trial.size * trial.size;
        if is_cut { 0.5 * linear } else { model }
    }

    /// Takes the step if the potential falls as the model says, and sets the next radius.
    fn try_step(&mut self, trial: &Trial, history: &mut Vec<Iteration>) -> Result<Option<f64>, Fault> {
        let place = &self.outcome.place;
        let cut = self.landscape.cut(&place.q, &trial.x);
        let x = cut.as_ref().unwrap_or(&trial.x);
        let linear: f64 = place.force.iter().zip(x).map(|(f, x)| f * x).sum();
        let predicted = self.predicted(trial, linear, cut.is_some());
        if cut.is_some() && !(predicted > 0.0) {
            self.radius = 0.3 * trial.size.min(self.radius);
            return Ok(None);
        }
        let mut q = self.landscape.moved(&place.q, x);
        let mut potential = self.landscape.potential(&q);
        // Below the round-off of the potential, and along zero-stiffness motions, the forces can tell.
        let round_off = ENERGY.of(self.potential.abs() + self.landscape.stirred(place));
        let tiny = predicted.abs().max((self.potential - potential).abs()) < round_off;
        let mut ratio = match tiny {
            true => self.worth_by_forces(x, linear, &q)? / predicted,
            false => (self.potential - potential) / predicted,
        };
        if self.bent
            && !tiny
            && !(ratio > 0.75)
            && let Some(lower) = self.corrected(trial, &q, 0.75 * predicted)?
        {
            let better = (self.potential - lower.potential) / predicted;
            if better > WORTH && !(better <= ratio) {
                (ratio, q, potential) = (better, lower.q, lower.potential);
            }
        }
        if !(ratio > WORTH) && matches!(self.newton, Newton::Step(..)) {
            // Where a parabola through this gain has its lowest point; ratio and prediction are of the potential.
            let lowest = 0.5 * linear / (linear - ratio * predicted);
            let part = if lowest.is_finite() { lowest.clamp(SHORTENED[0], SHORTENED[1]) } else { SHORTENED[0] };
            self.radius = part * trial.size.min(self.radius);
        } else if !(ratio >= 0.25) {
            self.radius = 0.3 * trial.size.min(self.radius);
        } else if ratio > 0.75 && (trial.shift > 0.0 || trial.part < 1.0) {
            self.radius *= 2.5;
        }
        if !(ratio > WORTH) {
            return Ok(None);
        }
        let next = match Place::at(self.landscape, q) {
            Ok(next) => next,
            // A position that cannot be evaluated is outside the region.
            Err(_) => return Ok(None),
        };
        self.outcome.shifted |= trial.shift > 0.0 || trial.part < 1.0;
        self.outcome.place = next;
        self.potential = potential;
        let residual = self.outcome.place.residual().0;
        history.push(Iteration { stage: "trust region", residual, step: trial.size, shift: trial.shift });
        Ok(Some(trial.size))
    }

    /// How far the potential falls along a step, from the forces at both ends: where it is so little that the potential's
    /// own round-off hides it.
    fn worth_by_forces(&mut self, x: &[f64], linear: f64, q: &[f64]) -> Result<f64, Fault> {
        let Ok(force) = self.landscape.force(q) else { return Ok(f64::NAN) };
        let there: f64 = force.iter().zip(x).map(|(f, x)| f * x).sum();
        Ok(0.5 * (linear + there))
    }

    /// If a valley bends (a stiff spring beside soft ones, a heavy body among light ones) the step leaves its floor: back
    /// to it from the end of the step, from the end of the parabola of the floor, or that end itself, whichever is lowest.
    fn corrected(&mut self, trial: &Trial, q: &[f64], enough: f64) -> Result<Option<Lower>, Fault> {
        let back = self.back(trial, &trial.x, q);
        if back.as_ref().is_some_and(|back| self.potential - back.potential > enough) {
            return Ok(back);
        }
        let Some((x, bent)) = self.along_parabola(trial)? else { return Ok(back) };
        let again = self.back(trial, &x, &bent.q);
        let all = [back, Some(bent), again].into_iter().flatten();
        Ok(all.min_by(|a, b| a.potential.total_cmp(&b.potential)))
    }

    /// One step back, `(K + σB) y = f − σ B x`, with the stiffness at the end of `x`. In the metric it may be longer than the
    /// step itself: a heavy body moves back by little. Far from the floor stiff springs have another force, and with it another,
    /// often a negative, stiffness of the soft directions: then there is none.
    fn back(&mut self, trial: &Trial, x: &[f64], q: &[f64]) -> Option<Lower> {
        let force = self.landscape.force(q).ok()?;
        self.landscape.look(q).ok()?;
        self.is_at_pole = false;
        if !self.landscape.factorize(trial.shift) {
            return None;
        }
        let held = |(i, f): (usize, &f64)| f - trial.shift * self.landscape.metric[i] * x[i];
        let rhs: Vec<f64> = force.iter().enumerate().map(held).collect();
        let y = self.landscape.solve(&rhs);
        self.lower(q, &y)
    }

    /// The step along the parabola of the floor, from what the forces do around the place where it begins:
    ///
    /// ```text
    /// f(q ⊞ s x) = f₀ − s K x + s² f₂ + …,      (K + σB) y = f₂:      q ⊞ (x + y)
    /// ```
    fn along_parabola(&mut self, trial: &Trial) -> Result<Option<(Vec<f64>, Lower)>, Fault> {
        let from = self.outcome.place.q.clone();
        self.landscape.look(&from)?;
        self.is_at_pole = false;
        if !self.landscape.factorize(trial.shift) {
            return Ok(None);
        }
        let mut bend: Vec<f64> = self.outcome.place.force.iter().map(|f| -2.0 * f).collect();
        for part in [PART, -PART] {
            let x: Vec<f64> = trial.x.iter().map(|x| part * x).collect();
            let q = self.landscape.moved(&from, &x);
            let Ok(force) = self.landscape.force(&q) else { return Ok(None) };
            bend.iter_mut().zip(&force).for_each(|(bend, f)| *bend += f);
        }
        bend.iter_mut().for_each(|bend| *bend /= 2.0 * PART * PART);
        let y = self.landscape.solve(&bend);
        let x: Vec<f64> = trial.x.iter().zip(&y).map(|(x, y)| x + y).collect();
        Ok(self.lower(&from, &x).map(|end| (x, end)))
    }

    /// A place and its potential; none from where loops might close otherwise.
    fn lower(&mut self, q: &[f64], step: &[f64]) -> Option<Lower> {
        if !(self.landscape.stretch(q, step) <= 1.0) {
            return None;
        }
        let q = self.landscape.moved(q, step);
        let potential = self.landscape.potential(&q);
        potential.is_finite().then_some(Lower { q, potential })
    }

    /// At a balanced place: whether K has a direction that runs away; if so, goes along it while the potential falls. How short
    /// the last steps into the saddle were says nothing about the direction of negative curvature.
    fn leave_saddle(&mut self, history: &mut Vec<Iteration>) -> Result<bool, Fault> {
        if self.landscape.free.is_empty() {
            return Ok(false);
        }
        self.radius = self.radius.max(self.first_radius);
        let place = &self.outcome.place;
        self.landscape.look(&place.q)?;
        match way_out(self.landscape, place, self.potential, self.radius) {
            Some(way) => self.leave(way, history).map(|()| true),
            None => Ok(false),
        }
    }

    /// At a balanced place on stops that bear nothing: whether the potential falls off them.
    fn leave_stops(&mut self, history: &mut Vec<Iteration>) -> Result<bool, Fault> {
        let Some(descent) = cone::descent(self.landscape, &self.outcome.place)? else { return Ok(false) };
        self.landscape.let_go(&descent.leaving);
        let direction: Vec<f64> = self.landscape.free.iter().map(|i| descent.direction[*i]).collect();
        let place = Place::at(self.landscape, self.outcome.place.q.clone())?;
        self.landscape.look(&place.q)?;
        match downhill(self.landscape, &place, &direction, self.potential, self.radius) {
            Some(way) => self.leave(way, history).map(|()| true),
            None => {
                if let Some(place) = self.landscape.choose_active(&place.q)? {
                    self.outcome.place = place;
                }
                Ok(false)
            }
        }
    }

    fn leave(&mut self, way: WayOut, history: &mut Vec<Iteration>) -> Result<(), Fault> {
        let WayOut { step: x, potential } = way;
        let step = self.landscape.size(&x);
        let q = self.landscape.moved(&self.outcome.place.q, &x);
        self.outcome.place = Place::at(self.landscape, q)?;
        self.potential = potential;
        self.outcome.shifted = true;
        let carried = carriers(&x, &self.landscape.metric);
        self.outcome.left.push(carried.into_iter().map(|row| self.landscape.free[row]).collect());
        let residual = self.outcome.place.residual().0;
        history.push(Iteration { stage: "leave saddle", residual, step, shift: 0.0 });
        Ok(())
    }
}

/// The coordinates that carry a direction: those with at least a tenth of the largest part.
fn carriers(x: &[f64], metric: &[f64]) -> Vec<usize> {
    let part: Vec<f64> = x.iter().zip(metric).map(|(x, b)| b * x * x).collect();
    let largest = part.iter().fold(0.0_f64, |m, p| m.max(*p));
    (0..x.len()).filter(|i| part[*i] >= 0.1 * largest).collect()
}
