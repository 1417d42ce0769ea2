//! Settling: from a guess that does not stand to a pose that does, along a quasi-static path.
//!
//! ```text
//! (1)  (K + σB) x = f + Jᵀλ,    w = J x + n gap,    w and λ obey Coulomb's law        ([`crate::contact::cone`])
//! (2)  −½ (f + f⁺)·x − Σ λ_n (gap⁺ − gap) − Σ λ_t·J_t x    against    −σ xᵀBx − ½ xᵀKx
//! ```
//!
//! (1) is a step of implicit Euler's method, h = 1/σ, for a motion without inertia, `B q̇ = f + Jᵀλ`: pseudo-transient continuation
//! (Kelley, Keyes, SIAM J. Numer. Anal. 35, 1998) with the cone problem of an instant. As σ falls it becomes Newton's method
//! on the contacts that stay closed. (2) compares the fall of the Lagrangian along a step with what the linear model says of it, curvature of
//! the contacts included; σ follows from their ratio as in a trust region. Rigid stops and dry friction of hinges are supports as contacts are.
//!
//! The path depends on friction and on the guess. What has slid on its way ends where friction just holds it; it ends within that limit, so that
//! the pose can be certified. That it stands is not claimed here.

mod bracing;

use super::Unanswered;
use crate::contact::cone::{Law, Problem};
use crate::contact::frame::{Column, Frame, along, carried};
use crate::contact::hinges::{self, Id, Support};
use crate::contact::pairs::{LOOSE, Pairs};
use crate::dynamics::System;
use crate::model::Model;
use crate::model::problem::rounded;
use crate::motion::Motion;
use crate::round_off::{CLOSED, ENERGY};
use crate::statics::problem::Landscape;
use crate::statics::problem::place::Place;
use crate::statics::settings::Settings;
use crate::statics::watch::Watch;
use bracing::Bracing;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// A step moves no shape by more than this part of the smallest one, so that none is passed.
const LONGEST: f64 = 0.3;
/// Steps until the search ends.
const MOST_STEPS: usize = 3000;
/// Trials of one step.
const MOST_TRIALS: usize = 60;
/// A scene that has moved by this many of its lengths falls for ever.
const FAR: f64 = 100.0;
/// What has gone so much of its way in one direction falls, or rolls, which is half of the way of its farthest point; else it moves to and fro.
const STRAIGHT: f64 = 0.25;
/// What is left of the forces in parts of those that cancel, and the last step in parts of the scene's length; what is left falls on to
/// its rounding, where the next step leaves more than this part of it.
const BALANCED: f64 = 1e-9;
const STILL: f64 = 1e-10;
const FLOOR: f64 = 1e-15;
const FALLS_ON: f64 = 0.99;
/// Steps that become shorter by this part converge still; of what rests already, or moves by rounding alone, no more than so many are taken.
const CONVERGES: f64 = 0.9;
const MOST_STILL: usize = 50;
/// Forces below this part of them may be rounding that is magnified.
const LITTLE: f64 = 1e-7;
/// A step is taken if the Lagrangian falls by this part of what the model says; σ falls or rises beyond these ratios (Conn, Gould,
/// Toint, "Trust-region methods", 2000, 6.1).
const WORTH: f64 = 0.05;
const RATIOS: [f64; 2] = [0.25, 0.75];
/// After steps below this part of the scene's length impulses are found to the last digits.
const NEAR: f64 = 1e-5;
/// Impulses are found to this part of the largest then, before that to a thousand times as much in a tenth of the sweeps.
const FOUND: f64 = 1e-12;
const MOST_SWEEPS: usize = 3000;
/// Overlaps up to this part of the scene's length are parted in so many rounds behind a step, to this part of the largest way.
const LITTLE_WAY: f64 = 1e-5;
const MOST_PARTINGS: usize = 4;
const NEARLY: f64 = 1e-6;
/// Gaps may be missed by this part of a step.
const MISSED: f64 = 0.1;
/// Friction is less by this part on the way than it is.
const WITHIN: f64 = 1e-6;

/// Where a guess has settled.
#[derive(Debug, Clone)]
pub(super) struct Settled {
    pub(super) pose: Vec<f64>,
    /// The largest way of a body's origin (m), and of which.
    pub(super) moved: f64,
    pub(super) body: usize,
    pub(super) steps: usize,
}

struct Search<'l, 's> {
    landscape: &'l mut Landscape<'s>,
    model: Arc<Model>,
    pairs: Pairs,
    /// The longest step of a shape (m).
    longest: f64,
    sigma: f64,
    /// Where σ begins, and begins again after what overlaps deeply has been freed.
    first_sigma: f64,
    warm: Vec<(Id, Vector3<f64>)>,
    /// Whether the last step was short, or left little.
    close: bool,
    /// σ of the last step and what it left of the forces.
    last: Option<(f64, f64)>,
    /// `κ` of the supports that bear (1/s²), and the matrix of the step with them where it is not definite without.
    brace: f64,
    bracing: Option<Bracing>,
}

/// A step of (1).
struct Step {
    /// Free coordinates, and all of them.
    x: Vec<f64>,
    full: Vec<f64>,
    supports: Vec<Support>,
    forces: Vec<Vector3<f64>>,
    /// What the model says of (2) (J).
    predicted: f64,
    /// What contacts miss of their gaps at its end (m).
    missed: f64,
    sigma: f64,
    /// `σ |x|_B`: what the step leaves of the forces (in the metric of `B⁻¹`).
    left: f64,
    /// Whether the model says less of (2) than rounding makes of it.
    slight: bool,
}

/// Lets a scene settle from a pose.
///
/// # Errors
/// [`Unanswered`]: shapes that cannot touch, a scene that cannot be evaluated, or one that does not come to rest.
pub(super) fn settle(
    model: &Arc<Model>,
    settings: &Settings,
    pose: &[f64],
    go_on: &dyn Fn() -> bool,
) -> Result<Settled, Unanswered> {
    let watch = Watch::new(settings.time_limit, go_on);
    let mut system = System::new(model);
    let mut landscape = Landscape::new(&mut system, pose)?;
    landscape.watch = Some(&watch);
    if !model.is_constrained() {
        landscape.heed_limits();
    }
    let none = vec![0.0; landscape.free.len()];
    let q = landscape.moved(pose, &none);
    if !q.iter().all(|q| q.is_finite()) {
        return Err(Unanswered::Unsettled("its loops cannot be closed".to_owned()));
    }
    let pairs = Pairs::new(model)?;
    let sizes = pairs.pieces.iter().map(|piece| piece.size);
    let longest = LONGEST * sizes.fold(model.length_scale(), f64::min);
    let place = Place::at(&mut landscape, q)?;
    landscape.begin(&place);
    let unbalanced = place.force.iter().zip(&landscape.metric).map(|(f, b)| f * f / b).sum::<f64>().sqrt();
    let sigma = (unbalanced / (0.1 * landscape.reach())).max(f64::MIN_POSITIVE);
    let mut search = Search {
        landscape: &mut landscape,
        model: Arc::clone(model),
        pairs,
        longest,
        sigma,
        first_sigma: sigma,
        warm: Vec::new(),
        close: false,
        last: None,
        brace: 0.0,
        bracing: None,
    };
    let (place, steps) = search.run(place)?;
    let (moved, body) = way(model, pose, &place.q);
    Ok(Settled { pose: place.q, moved, body, steps })
}

/// The largest distance between the origins of a body in two poses, and of which body.
pub(super) fn way(model: &Model, from: &[f64], to: &[f64]) -> (f64, usize) {
    let rest = vec![0.0; model.velocity_count()];
    let (mut before, mut after) = (Motion::new(model), Motion::new(model));
    before.update(model, from, &rest);
    after.update(model, to, &rest);
    let of = |body: &crate::model::Body| {
        (after.body_pose(body).translation.vector - before.body_pose(body).translation.vector).norm()
    };
    let all = model.bodies.iter().enumerate().map(|(index, body)| (of(body), index));
    all.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 0))
}

/// Size of the forces that cancel, in the metric of `B⁻¹`.
fn pull(place: &Place, metric: &[f64]) -> f64 {
    place.scales.force.iter().zip(metric).map(|(f, b)| f * f / b).sum::<f64>().sqrt()
}

/// Sizes of the terms in the work of a step (J).
fn stirred(place: &Place, x: &[f64]) -> f64 {
    place.scales.force.iter().zip(x).map(|(force, x)| force * x.abs()).sum()
}

impl Search<'_, '_> {
    fn run(&mut self, mut place: Place) -> Result<(Place, usize), Unanswered> {
        let (mut travelled, mut still, start) = (0.0, 0, place.q.clone());
        let mut last_far = f64::INFINITY;
        for steps in 1..=MOST_STEPS {
            if !self.landscape.goes_on() {
                return Err(Unanswered::Unsettled(format!("the search was ended after {steps} steps")));
            }
            self.landscape.look(&place.q)?;
            let Some((step, next)) = self.accepted(&place)? else {
                let far;
                (place, far) = self.freed(place, || format!("no length of step {steps} goes down"))?;
                travelled += far;
                continue;
            };
            let far = self.farthest(&place.q, &step.full);
            travelled += far;
            let pull = pull(&place, &self.landscape.metric);
            let falls_on = step.left > FLOOR * pull && self.falls_on(&step);
            self.close = far <= NEAR * self.model.length_scale() || step.left <= LITTLE * pull;
            self.last = Some((step.sigma, step.left));
            let parted;
            (place, parted) = self.parted(next, false)?;
            let length = self.model.length_scale();
            let short = far.max(parted) <= STILL * length;
            // What is stiff is as far from its balance as a step that is no longer seen.
            let converges = far > f64::EPSILON * length && far < CONVERGES * last_far;
            // Where nothing holds it, rounding moves it on for ever.
            let rests = (short || step.slight) && step.left <= BALANCED * pull;
            (still, last_far) = (if rests { still + 1 } else { 0 }, far);
            if rests && (short && !falls_on && !converges || still > MOST_STILL) {
                return Ok((place, steps));
            }
            if far > 0.0 && far <= f64::EPSILON * STILL * self.model.length_scale() {
                let far;
                (place, far) = self.freed(place, || {
                    let left = step.left / pull;
                    format!("nothing moves any more after {steps} steps, and {left:.1e} of the forces are not borne")
                })?;
                travelled += far;
                continue;
            }
            self.warm = step.supports.iter().map(|support| support.id).zip(step.forces).collect();
            if travelled > FAR * self.model.length_scale() {
                let (away, body) = way(&self.model, &start, &place.q);
                let name = &self.model.bodies[body].name;
                let why = if away > STRAIGHT * travelled {
                    format!("`{name}` has moved by {} m, and nothing stops it", rounded(away))
                } else {
                    format!(
                        "it has moved by {} m, {FAR} times its own size, and does not come to rest",
                        rounded(travelled)
                    )
                };
                return Err(Unanswered::Unsettled(why));
            }
        }
        let (away, body) = way(&self.model, &start, &place.q);
        let name = &self.model.bodies[body].name;
        Err(Unanswered::Unsettled(format!(
            "it still moves after {MOST_STEPS} steps; `{name}` has moved by {} m",
            rounded(away)
        )))
    }

    /// Frees what friction holds together in a deep overlap with forces of any size; how far that moves a shape (m), too. Where nothing overlaps
    /// so it is stuck, for this reason.
    fn freed(&mut self, place: Place, why: impl Fn() -> String) -> Result<(Place, f64), Unanswered> {
        self.sigma = self.first_sigma;
        let (place, far) = self.parted(place, true)?;
        if !(far > STILL * self.model.length_scale()) {
            return Err(Unanswered::Unsettled(why()));
        }
        self.last = None;
        Ok((place, far))
    }

    /// Whether a step leaves less than the last one of this σ did, or there is none.
    fn falls_on(&self, step: &Step) -> bool {
        self.last.is_none_or(|(sigma, left)| sigma != step.sigma || step.left <= FALLS_ON * left)
    }

    /// Whether a step leaves less than the last one of this σ did.
    fn creeps(&self, step: &Step) -> bool {
        self.last.is_some_and(|(sigma, left)| sigma == step.sigma && step.left < left)
    }

    /// The largest displacement of a point of any shape (m).
    fn farthest(&mut self, q: &[f64], x: &[f64]) -> f64 {
        let motion = self.landscape.system().at(0.0, q, x);
        self.pairs.place(motion.motion());
        let speeds = (0..self.pairs.pieces.len()).map(|piece| self.pairs.speed(piece, motion.motion()));
        let finite = speeds.map(|(v, turning)| v.norm() + turning);
        finite.fold(0.0, f64::max)
    }

    /// A step that is worth taking, and where it leads; σ is that of the next one.
    fn accepted(&mut self, place: &Place) -> Result<Option<(Step, Place)>, Unanswered> {
        let supports = self.supports(&place.q);
        let mut supports = Some(supports);
        for _ in 0..MOST_TRIALS {
            if !self.factorize(&place.q, supports.as_deref().unwrap_or_default()) {
                self.sigma *= 4.0;
                continue;
            }
            let mut step = self.step(place, supports.take().unwrap_or_default());
            let far = self.farthest(&place.q, &step.full);
            let is_long = !(far <= self.longest);
            // Forces are found to a part of the largest: where that moves by more than gaps, these are missed.
            if is_long || step.missed > MISSED * far.max(STILL * self.model.length_scale()) {
                self.sigma *= if is_long { (1.2 * far / self.longest).clamp(2.0, 1e6) } else { 4.0 };
                self.landscape.look(&place.q)?;
                supports = Some(step.supports);
                continue;
            }
            let q = self.landscape.moved(&place.q, &step.x);
            let next = if q.iter().all(|q| q.is_finite()) { Place::at(self.landscape, q).ok() } else { None };
            let ratio = next.as_ref().map_or(-1.0, |next| self.fall(place, &step, next) / step.predicted);
            // Below rounding of the forces there is nothing to compare.
            let borne: f64 = step.forces.iter().map(|force| force.norm()).sum();
            let noise = ENERGY.of(borne * self.model.length_scale() + stirred(place, &step.x));
            step.slight = step.predicted.abs() <= noise;
            let little = step.left <= LITTLE * pull(place, &self.landscape.metric);
            let ratio = match (step.slight, little) {
                (false, _) => ratio,
                (true, true) if !self.creeps(&step) => 0.5,
                (true, _) => 1.0,
            };
            // What is left is rounding if it counts as balanced and does not fall on: a shorter step magnifies it less.
            let rounding = step.left <= BALANCED * pull(place, &self.landscape.metric) && !self.falls_on(&step);
            if step.slight && rounding || ratio < RATIOS[0] || !ratio.is_finite() {
                self.sigma *= 4.0;
            } else if ratio > RATIOS[1] {
                self.sigma /= 4.0;
            }
            if let Some(next) = next.filter(|_| ratio > WORTH) {
                return Ok(Some((step, next)));
            }
            self.landscape.look(&place.q)?;
            supports = Some(step.supports);
        }
        Ok(None)
    }

    /// The left side of (2) (J).
    fn fall(&mut self, place: &Place, step: &Step, next: &Place) -> f64 {
        let work = place.force.iter().zip(&next.force).zip(&step.x).map(|((a, b), x)| 0.5 * (a + b) * x);
        let mut fall = -work.sum::<f64>();
        let rest = vec![0.0; step.full.len()];
        let motion = self.landscape.system().at(0.0, &next.q, &rest);
        self.pairs.place(motion.motion());
        for (support, force) in step.supports.iter().zip(&step.forces).filter(|(_, force)| **force != Vector3::zeros())
        {
            let rates = support.rates(&step.full);
            let opened = match support.id {
                Id::Contact(key) => self.pairs.meeting(&key).map_or(rates.x, |meeting| meeting.gap - support.gap),
                Id::Stop(_) | Id::Friction(_) => rates.x,
            };
            fall -= force.x * opened + force.y * rates.y + force.z * rates.z;
        }
        fall
    }

    /// The solution of (1) with the last factorization.
    fn step(&mut self, place: &Place, supports: Vec<Support>) -> Step {
        let ways: Vec<f64> = supports.iter().map(|one| self.way(one.gap)).collect();
        let (found, most) = if self.close { (FOUND, MOST_SWEEPS) } else { (1e3 * FOUND, MOST_SWEEPS / 10) };
        let (full, forces) = self.pushed(&place.force, &supports, &ways, (found, most));
        let mut pushed = self.spread(&place.force);
        for (support, force) in supports.iter().zip(&forces) {
            for (c, column) in support.columns.iter().enumerate() {
                column.iter().for_each(|(i, value)| pushed[*i] += value * force[c]);
            }
        }
        let x: Vec<f64> = self.landscape.free.iter().map(|i| full[*i]).collect();
        let worked: f64 = pushed.iter().zip(&full).map(|(f, x)| f * x).sum();
        let size = self.landscape.size(&x);
        let predicted = -0.5 * worked - 0.5 * self.sigma * size.powi(2);
        let missed = supports.iter().zip(&forces).zip(&ways).map(|((one, force), way)| {
            let gap = one.rates(&full).x + way;
            if matches!(one.id, Id::Contact(_)) { if force.x > 0.0 { gap.abs() } else { (-gap).max(0.0) } } else { 0.0 }
        });
        let missed = missed.fold(0.0, f64::max);
        Step { x, full, supports, forces, predicted, missed, sigma: self.sigma, left: self.sigma * size, slight: false }
    }

    /// Free coordinates among all, those that are held being zero.
    fn spread(&self, x: &[f64]) -> Vec<f64> {
        let mut full = vec![0.0; self.model.velocity_count()];
        self.landscape.free.iter().zip(x).for_each(|(i, x)| full[*i] = *x);
        full
    }

    /// How all coordinates move by a force and what supports push with, which may go by these ways along their normals (m); and these forces,
    /// `found` to a part of the largest in so many sweeps.
    fn pushed(
        &mut self,
        force: &[f64],
        supports: &[Support],
        ways: &[f64],
        (found, most): (f64, usize),
    ) -> (Vec<f64>, Vec<Vector3<f64>>) {
        let loose = self.solve(&self.pulled(force, supports, ways));
        let unborne = self.spread(&loose);
        let mut answers: Vec<[Vec<f64>; 3]> = Vec::with_capacity(supports.len());
        for support in supports {
            let mut answer = |column: &Column| {
                let mut full = vec![0.0; unborne.len()];
                if column.is_empty() {
                    return full;
                }
                column.iter().for_each(|(i, c)| full[*i] = *c);
                let rhs: Vec<f64> = self.landscape.free.iter().map(|i| full[*i]).collect();
                let solved = self.solve(&rhs);
                self.spread(&solved)
            };
            answers.push([0, 1, 2].map(|i| answer(&support.columns[i])));
        }
        let block = |i: usize, j: usize| Matrix3::from_fn(|r, c| along(&supports[i].columns[r], &answers[j][c]));
        let row = |i: usize| {
            let all = (0..supports.len()).map(|j| (j, block(i, j)));
            all.filter(|(j, block)| *j == i || *block != Matrix3::zeros()).collect()
        };
        let rates = supports.iter().zip(ways).map(|(one, way)| one.rates(&unborne) + Vector3::x() * *way);
        let problem = Problem {
            blocks: (0..supports.len()).map(row).collect(),
            rates: rates.collect(),
            laws: supports.iter().map(|one| one.law).collect(),
        };
        let guess = supports.iter().map(|one| self.known(one.id).unwrap_or_else(Vector3::zeros));
        let guess: Vec<Vector3<f64>> = guess.collect();
        let forces = problem.solve(&guess, found, most).forces;
        let mut full = unborne;
        for (answer, force) in answers.iter().zip(&forces) {
            for c in 0..3 {
                full.iter_mut().zip(&answer[c]).for_each(|(x, a)| *x += force[c] * a);
            }
        }
        (full, forces)
    }

    /// What a step may use up of a gap: nothing of its rounding and of a little overlap, which is parted behind it, and of a deep one what it
    /// can take back (m).
    fn way(&self, gap: f64) -> f64 {
        let length = self.model.length_scale();
        let little = CLOSED.hides(gap, length) || gap < 0.0 && -gap <= LITTLE_WAY * length;
        if little { 0.0 } else { gap.max(-0.25 * self.longest) }
    }

    /// Parts what overlaps a little: `min ½ xᵀ(K + σB)x` with `J_n x ≥ −gap`, without friction. In (1) contacts that stick would share the overlap,
    /// and where none parts them all forces grow without end.
    /// What overlaps deeply is parted as far as a step goes, if it is asked to be. Gives how far that moves a shape (m), too.
    fn parted(&mut self, mut place: Place, deeply: bool) -> Result<(Place, f64), Unanswered> {
        let (length, mut far) = (self.model.length_scale(), 0.0);
        for _ in 0..MOST_PARTINGS {
            let mut supports = self.supports(&place.q);
            supports.retain(|support| !matches!(support.id, Id::Friction(_)));
            let deepest = supports.iter().map(|support| -support.gap).fold(0.0, f64::max);
            if CLOSED.hides(deepest, length) || deepest > LITTLE_WAY * length && !deeply {
                break;
            }
            supports.iter_mut().for_each(|support| support.law = Law::Coulomb { stick: 0.0, slide: 0.0 });
            self.landscape.look(&place.q)?;
            let mut sigma = self.sigma;
            self.bracing = None;
            while !self.landscape.factorize(sigma) && sigma.is_finite() {
                sigma *= 4.0;
            }
            let ways: Vec<f64> = supports.iter().map(|support| support.gap.max(-0.25 * self.longest)).collect();
            let rest = vec![0.0; place.force.len()];
            let warm = std::mem::take(&mut self.warm);
            let (full, _) = self.pushed(&rest, &supports, &ways, (NEARLY, MOST_SWEEPS));
            self.warm = warm;
            let x: Vec<f64> = self.landscape.free.iter().map(|i| full[*i]).collect();
            let q = self.landscape.moved(&place.q, &x);
            match Place::at(self.landscape, q) {
                Ok(next) if next.q.iter().all(|q| q.is_finite()) => {
                    far += self.farthest(&place.q, &full);
                    place = next;
                }
                _ => break,
            }
        }
        Ok((place, far))
    }

    /// What may bear within a step from a pose.
    fn supports(&mut self, q: &[f64]) -> Vec<Support> {
        let rest = vec![0.0; self.model.velocity_count()];
        let motion = self.landscape.system().at(0.0, q, &rest);
        let motion = motion.motion();
        let mut links = Vec::new();
        carried(motion, &self.model, &mut links);
        self.pairs.place(motion);
        let mut found = Vec::new();
        let margins = vec![self.longest; self.pairs.pieces.len()];
        for couple in self.pairs.near(&margins) {
            self.pairs.facing(couple, LOOSE, 2.0 * self.longest, &mut found);
        }
        let contact = |(key, meeting)| {
            let frame = Frame::new(&self.model, motion, &self.pairs, &links, key, meeting, None);
            let friction = self.model.contacts[self.pairs.couples[key.couple].rule].friction;
            let within = friction.stick * (1.0 - WITHIN);
            let law = Law::Coulomb { stick: within, slide: within };
            Support { id: Id::Contact(key), columns: frame.columns, gap: frame.meeting.gap, law, at_rest: None }
        };
        let mut supports: Vec<Support> = found.into_iter().map(contact).collect();
        supports.extend(hinges::supports(&self.model, q, &rest, 0.0));
        supports
    }
}
