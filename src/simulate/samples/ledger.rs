//! The energy ledger: where energy is, what loads put in, what dampers take out, and what the integrator lost.
//!
//! Powers are integrated from one time that is asked for to the next: ends of steps, samples, events. No quadrature reaches
//! across an event, at which powers jump.
//!
//! Of methods with implicit stages that is done with the powers at those stages and the method's own weights, as it would
//! integrate one more equation. Between them, stiff forces belong to no solution: the interpolant of a beam's axial strain is wrong
//! by less than the tolerance, and what a drive needs to hold that up by many times the power that flows. Of other methods, and
//! of steps that an event ends before their last stage, the powers along the interpolant are integrated by a Gauss rule.
//!
//! What a drive moves may turn far within a step, see `driven.rs`: where powers change with that by more than either rule sees, the step is
//! taken in pieces of half a radian along its interpolant.

use super::driven::{Driven, missed};
use crate::dynamics::{Energies, Powers};
use crate::integrate::Stepper;
use crate::model::{Model, StopLaw};
use crate::record::Energy;
use crate::simulate::error::{RunError, named};
use crate::simulate::problem::Equations;
use crate::simulate::state::State;

/// Nodes and weights of the Gauss rule on 0…1 that integrates powers over a step: exact to degree 9.
const WHOLE: [(f64, f64); 5] = [
    (0.046_910_077_030_668_004, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

/// That for a part of a step, exact to degree 5.
const PART: [(f64, f64); 3] =
    [(0.112_701_665_379_258_31, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Over this turn of what is driven (rad) [`WHOLE`] misses 10⁻¹² of what its waves do.
const PIECE: f64 = 0.5;
/// Over this one [`PART`] does.
const SHORT_PIECE: f64 = 0.1;
/// Pieces of a step, at most: of what turns faster the account says that it is in doubt.
const MOST_PIECES: f64 = 65_536.0;
/// What a rule may miss of the waves of what is driven, as part of the largest energy: about its rounding.
const MISSED: f64 = 1e-14;
/// Both ways to integrate differ by no more than so many times what the stages miss of a wave, whose height a few powers show in part.
const EXPLAINED: f64 = 4.0;
/// Over a further turn in a step (rad) a few stages say nothing of a wave, nor of what they miss of it.
const FAR: f64 = 2.0;

/// Energies of a run so far.
#[derive(Debug, Clone)]
pub(in crate::simulate) struct Ledger {
    start: Energies,
    /// Up to when powers are integrated (s).
    time: f64,
    work: f64,
    dissipated: f64,
    /// Largest imbalance so far (J).
    pub drift: f64,
    /// The largest energy so far: kinetic, kinetic plus potential, put in, taken out (J).
    pub largest: f64,
    /// The last one (J).
    error: f64,
    /// Whether any power flows that no potential stands for.
    flows: bool,
    /// Whether nothing happens within the last step or cuts it short: the powers at its stages lie on one curve.
    pub undisturbed: bool,
    driven: Driven,
    stages: StagePowers,
}

/// The powers at the stages of a step.
#[derive(Debug, Clone, Default)]
struct StagePowers {
    /// When that step began and ended (s).
    step: [f64; 2],
    powers: Vec<Powers>,
    waves: Waves,
}

/// What a few powers say of what is driven.
#[derive(Debug, Clone, Copy, Default)]
struct Waves {
    /// How fast it goes (rad/s).
    rate: f64,
    /// The lowest and the highest of both kinds (W).
    input: Option<[f64; 2]>,
    dissipated: Option<[f64; 2]>,
}

impl Waves {
    fn see(&mut self, rate: f64, Powers { input, dissipated }: Powers) {
        let wider = |range: Option<[f64; 2]>, x: f64| range.map_or([x; 2], |[low, high]| [low.min(x), high.max(x)]);
        self.rate = self.rate.max(rate);
        self.input = Some(wider(self.input, input));
        self.dissipated = Some(wider(self.dissipated, dissipated));
    }

    /// How far powers are from each other (W).
    fn height(&self) -> f64 {
        [self.input, self.dissipated].iter().flatten().map(|[low, high]| high - low).sum()
    }
}

/// No method has more stages.
const MOST_STAGES: usize = 8;

/// What the ledger of a run has at its end, for the run that goes on with another structure (J).
#[derive(Debug, Clone, Copy)]
pub(in crate::simulate) struct Booked {
    /// Kinetic plus potential energy at the very start.
    pub(in crate::simulate) start: f64,
    pub(in crate::simulate) work: f64,
    pub(in crate::simulate) dissipated: f64,
    pub(in crate::simulate) drift: f64,
    pub(in crate::simulate) largest: f64,
    /// Whether a run has come before it: a structure may change at the very start.
    pub(in crate::simulate) has_run: bool,
}

impl Ledger {
    /// Goes on with what an earlier run has booked.
    pub(in crate::simulate) fn going_on(self, booked: Option<&Booked>) -> Self {
        let Some(&Booked { start, work, dissipated, drift, largest, .. }) = booked else { return self };
        let largest = largest.max(self.largest);
        Self { start: Energies { kinetic: start, potential: 0.0 }, work, dissipated, drift, largest, ..self }
    }

    pub(in crate::simulate) fn new(model: &Model, time: f64, start: Energies) -> Self {
        let damped = |law: StopLaw| matches!(law, StopLaw::Compliant { damping, .. } if damping > 0.0);
        let stops = model.stops.iter().any(|stop| damped(stop.law));
        let flows = model.has_damping()
            || stops
            || !model.hinge_friction.is_empty()
            || !model.contacts.is_empty()
            || !model.is_conservative()
            || !model.drives.is_empty()
            || !model.motors.is_empty();
        let stages =
            StagePowers { step: [f64::NAN; 2], powers: Vec::with_capacity(MOST_STAGES), waves: Waves::default() };
        let driven = Driven::new(model);
        let largest = start.kinetic.max((start.kinetic + start.potential).abs());
        let (work, dissipated, drift, error) = (0.0, 0.0, 0.0, 0.0);
        Self { start, time, work, dissipated, drift, largest, error, flows, undisturbed: true, driven, stages }
    }

    /// Integrates powers up to a time within the last step, `state` being scratch: a scene without dampers, loads and motors
    /// pays nothing.
    ///
    /// # Errors
    /// A state within the step that cannot be evaluated.
    pub(in crate::simulate) fn advance(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        state: &mut State,
        until: f64,
    ) -> Result<(), RunError> {
        let (from, length) = (self.time, until - self.time);
        if !(length > 0.0) {
            return Ok(());
        }
        self.time = until;
        if !self.flows {
            return Ok(());
        }
        // Compliant stops take power out in bursts: of parts of a step a few stages know it only with either sign.
        let is_steady = self.undisturbed && motion.model().stops.is_empty();
        let by_stages = (is_steady && self.stages.evaluate(motion, stepper, &self.driven))
            .then(|| self.stages.integral(stepper, [from, until]));
        let found = match by_stages {
            None => self.in_pieces(motion, stepper, state, [from, until])?.0,
            Some((powers, unseen)) if !(unseen * self.stages.waves.height() > MISSED * self.largest) => powers,
            Some((powers, unseen)) => {
                let (along, waves) = self.in_pieces(motion, stepper, state, [from, until])?;
                let apart = (along.input - powers.input).abs() + (along.dissipated - powers.dissipated).abs();
                let explained = EXPLAINED * unseen * waves.height().max(self.stages.waves.height());
                // What is further apart than waves explain is what the interpolant makes of stiff forces.
                if apart > explained && self.stages.turn() < FAR { powers } else { along }
            }
        };
        self.work += found.input;
        self.dissipated += found.dissipated;
        Ok(())
    }

    /// What powers along the interpolant come to (J), in pieces where what is driven turns far, and what they are there.
    fn in_pieces(
        &self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        state: &mut State,
        [from, until]: [f64; 2],
    ) -> Result<(Powers, Waves), RunError> {
        let (length, mut waves) = (until - from, Waves::default());
        let is_part = length < 0.5 * (stepper.time() - stepper.previous_time());
        let (rule, piece) = if is_part { (&PART[..], SHORT_PIECE) } else { (&WHOLE[..], PIECE) };
        let powers = self.along(motion, stepper, state, [from, until], rule, &mut waves)?;
        let turn = waves.rate * length;
        if !(turn > piece && waves.height() * length > MISSED * self.largest) {
            return Ok((powers, waves));
        }
        let pieces = (turn / PIECE).ceil().min(MOST_PIECES);
        let end = |k: u32| from + length * f64::from(k) / pieces;
        let mut sum = Powers::default();
        for k in 0..pieces as u32 {
            let powers = self.along(motion, stepper, state, [end(k), end(k + 1)], &WHOLE, &mut waves)?;
            sum.input += powers.input;
            sum.dissipated += powers.dissipated;
        }
        Ok((sum, waves))
    }

    /// What the powers along the interpolant come to by a rule (J); what they are there is taken note of.
    fn along(
        &self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        state: &mut State,
        [from, until]: [f64; 2],
        rule: &[(f64, f64)],
        waves: &mut Waves,
    ) -> Result<Powers, RunError> {
        let (length, mut sum) = (until - from, Powers::default());
        for (node, weight) in rule {
            let time = from + node * length;
            interpolate(motion, stepper, time, state)?;
            let powers = motion.booked_powers(time, &state.position, &state.velocity);
            waves.see(self.driven.rate(&state.velocity), powers);
            sum.input += weight * length * powers.input;
            sum.dissipated += weight * length * powers.dissipated;
        }
        Ok(sum)
    }

    /// Energy that springs of contact hold from the start (J).
    pub(in crate::simulate) fn held_from_start(&mut self, energy: f64) {
        self.start.potential += energy;
    }

    /// Kinetic plus potential energy at the very start (J).
    pub(in crate::simulate) fn start(&self) -> f64 {
        self.start.kinetic + self.start.potential
    }

    /// Energy that an impact takes out (J).
    pub(in crate::simulate) fn lose(&mut self, energy: f64) {
        self.dissipated += energy;
    }

    /// Work of drives in an impact (J).
    pub(in crate::simulate) fn put_in(&mut self, energy: f64) {
        self.work += energy;
    }

    /// The ledger of a state at the end of what was integrated.
    pub(in crate::simulate) fn energy(&self, now: &Energies) -> Energy {
        let total = now.kinetic + now.potential + self.dissipated - self.work;
        Energy {
            kinetic: now.kinetic,
            potential: now.potential,
            work: self.work,
            dissipated: self.dissipated,
            error: total - self.start.kinetic - self.start.potential,
        }
    }

    /// Takes note of the state at the end of what was integrated, of a step or at a sample; gives its ledger.
    pub(in crate::simulate) fn close(&mut self, now: &Energies) -> Energy {
        let energy = self.energy(now);
        self.error = energy.error;
        self.drift = self.drift.max(energy.error.abs());
        let sizes = [now.kinetic, now.kinetic + now.potential, energy.work, energy.dissipated];
        self.largest = sizes.iter().fold(self.largest, |most, energy| most.max(energy.abs()));
        energy
    }

    /// The ledger of a state on the way through a captured step, whose impulses are booked at its end. `put_in` is what drives have put into
    /// them so far; what they have taken out so far is what this state has less, between nothing and all that they do, `taken_out` (J). The
    /// balance is that of the last step's end.
    pub(in crate::simulate) fn on_the_way(&self, now: &Energies, [taken_out, put_in]: [f64; 2]) -> Energy {
        let Energy { work, error, .. } = self.energy(now);
        let work = work + put_in;
        let dissipated = self.dissipated + (self.error - error + put_in).clamp(0.0, taken_out);
        Energy { kinetic: now.kinetic, potential: now.potential, work, dissipated, error: self.error }
    }
}

impl StagePowers {
    /// Powers at the stages of the last step, unless they are known; false for a method without.
    fn evaluate(&mut self, motion: &mut Equations, stepper: &dyn Stepper<Equations>, driven: &Driven) -> bool {
        let Some(stages) = stepper.stages() else { return false };
        let step = [stepper.previous_time(), stepper.time()];
        if self.step != step {
            self.step = step;
            self.waves = Waves::default();
            self.powers.clear();
            for i in 0..stages.count() {
                let (q, v) = stages.state(i);
                let time = step[0] + stages.node(i) * (step[1] - step[0]);
                // What jumps where the step ends, as a table does, has not jumped yet.
                let powers = motion.booked_powers(time.min(step[1].next_down()), q, v);
                self.waves.see(driven.rate(v), powers);
                self.powers.push(powers);
            }
        }
        true
    }

    /// How far what is driven turns in the step (rad).
    fn turn(&self) -> f64 {
        self.waves.rate * (self.step[1] - self.step[0])
    }

    /// What they come to between two times within the step (J), and what they miss of the waves of what is driven, per height of these powers (s).
    fn integral(&self, stepper: &dyn Stepper<Equations>, [from, until]: [f64; 2]) -> (Powers, f64) {
        let mut sum = Powers::default();
        let Some(stages) = stepper.stages() else { return (sum, 0.0) };
        let [begin, end] = self.step;
        let length = end - begin;
        let parts = [from, until].map(|time| ((time - begin) / length).clamp(0.0, 1.0));
        let weight = |i: usize| stages.weight(i, parts[1]) - stages.weight(i, parts[0]);
        for (i, powers) in self.powers.iter().enumerate() {
            sum.input += length * weight(i) * powers.input;
            sum.dissipated += length * weight(i) * powers.dissipated;
        }
        let turn = self.turn();
        if turn == 0.0 {
            return (sum, 0.0);
        }
        let rule = (0..self.powers.len()).map(|i| (stages.node(i), weight(i)));
        // Over less than a radian powers show a part of a wave's height.
        let missed = if turn < FAR { missed(rule, parts, turn) } else { 1.0 };
        (sum, missed * length / turn.min(1.0))
    }
}

/// The state at a time within the last step. Between the ends of a step loops are closed to the accuracy of the
/// interpolation only: it is settled on them.
///
/// # Errors
/// A time at which the state cannot be evaluated.
pub(in crate::simulate) fn interpolate(
    motion: &mut Equations,
    stepper: &mut dyn Stepper<Equations>,
    time: f64,
    State { position, velocity }: &mut State,
) -> Result<(), RunError> {
    stepper.interpolate(motion, time, position, velocity).map_err(|error| named(motion.model(), &error))?;
    motion.settle(time, position, velocity).map_err(|fault| RunError::Sample { time, fault })
}
