//! What follows from an event: impacts, what comes to rest on stops and what leaves them, all at one instant.
//!
//! ```text
//! (1)  impact        v⁺ = v⁻ + M⁻¹ Hᵀ λ,   0 ≤ λ ⊥ u⁺ + e u⁻ ≥ 0,   u = H v
//! (2)  energy      T⁺ − T⁻ = ½ λ·(u⁺ + u⁻) + ν·ṡ,   the second the work of drives, ν their impulses
//! ```
//!
//! `u` are the speeds at which coordinates part from the stops that they touch; `M⁻¹` is that beside loops, drives and gears.
//!
//! **Simultaneous impacts are one problem**: (1) is Newton's law of restitution for all stops that are touched and not parting,
//! each with its own coefficient, as a linear complementarity problem (`complementarity.rs`). A row with λ > 0 has u⁺ = −e u⁻
//! and u⁻ ≤ 0, so that (2) never gains energy, whatever the coefficients. An impact that drives another coordinate onto a stop it
//! touches is followed by the next one, at the same instant; after [`MOST_IMPACTS`] of them all coefficients are zero, and one
//! projection ends them.
//!
//! **Sequences of impacts that accumulate** (Zeno's) lose the same part of their speed with each impact, and with an inward
//! acceleration a what is left of them from a speed u on takes 2 e u / (a (1 − e)). When what would come back is no more than
//! the tolerance of a speed, or would rise by no more than rounding, the coefficient is zero and the coordinate at the limit of
//! the sequence. Where only dampers end it, rises below the tolerance of a place are none (`fading.rs`).
//!
//! **Dry friction** has no part in impacts: its forces are bounded, and an impact takes no time. What an impact sets in motion slides.

use super::complementarity::{ONE_SIDED, Problem, Solution};
use super::nonsmooth::Holding;
use crate::dynamics::Fault;
use crate::integrate::Problem as _;
use crate::model::stop::sides;
use crate::model::{StopLaw, StopSide};
use crate::round_off::{REBOUND, REBOUND_BESIDE_LOOPS, SPEED};
use crate::simulate::error::RunError;
use crate::simulate::events::{Kind, Occurrence, Transition};
use crate::simulate::problem::Equations;
use crate::simulate::state::State;

/// Impacts at one instant; each lets all stops that are approached answer.
const MOST_IMPACTS: usize = 50;
/// A row is answered when what is left of its rate is this part of the largest one.
pub(in crate::simulate) const ANSWERED: f64 = 1e-10;

/// What an instant changed.
#[derive(Debug, Default)]
pub(in crate::simulate) struct Outcome {
    /// What happened to stops.
    pub(in crate::simulate) happened: Vec<Occurrence>,
    /// Energy that impacts took out (J).
    pub(in crate::simulate) lost: f64,
    /// Work of drives in impacts (J).
    pub(in crate::simulate) work: f64,
}

/// What a row is of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::simulate) enum Of {
    /// A stop that is touched; its rate is that of parting.
    Stop(StopSide),
    /// The dry friction of this index in the model, and which of its coordinates; its rate is the coordinate's.
    Friction(usize, usize),
}

/// An instant being resolved: the stops that are touched and the dry friction, and how coordinates answer to what pushes there.
pub(in crate::simulate) struct Instant<'a> {
    pub(in crate::simulate) motion: &'a mut Equations,
    pub(in crate::simulate) time: f64,
    pub(in crate::simulate) state: &'a mut State,
    /// Absolute tolerance of the run.
    pub(super) tolerance: f64,
    /// Stops that are touched, then dry friction.
    pub(in crate::simulate) rows: Vec<Of>,
    /// `H M⁻¹ Hᵀ` by rows, and its diagonal without loops, drives and gears.
    pub(in crate::simulate) matrix: Vec<f64>,
    pub(in crate::simulate) free: Vec<f64>,
    /// Accelerations towards the stops, the larger of those as nothing holds and beside what was held, ≥ 0 (m/s², rad/s²).
    inward: Vec<f64>,
    /// Which part of the energy of what rebounds from each stop dampers take in a second.
    pub(super) fading: Vec<f64>,
    /// Rows that parted from their stops before the impacts.
    pub(in crate::simulate) parted: Vec<bool>,
    /// The last speed of each coordinate before an impact that left it none (m/s, rad/s).
    pub(in crate::simulate) stopped: Vec<Option<f64>>,
    pub(in crate::simulate) outcome: Outcome,
}

/// Resolves what happens at an instant: the state after it, and the discrete state in which the run goes on. `transition` is the
/// event that was found, `None` at the start of a run.
///
/// # Errors
/// A stop that nothing can keep from being passed, or a system that cannot be evaluated.
pub(in crate::simulate) fn resolve(
    motion: &mut Equations,
    time: f64,
    state: &mut State,
    tolerance: f64,
    transition: Option<Transition>,
) -> Result<Outcome, RunError> {
    let fault = |fault| RunError::Sample { time, fault };
    let before: Vec<Holding> = motion.held().to_vec();
    let mut beside = vec![0.0; state.velocity.len()];
    if !before.is_empty() {
        motion.accelerations(time, &state.position, &state.velocity, &mut beside).map_err(fault)?;
    }
    let rows = rows(motion, state, &before);
    let mut instant = Instant::new(motion, time, state, tolerance, rows);
    if instant.rows.is_empty() {
        instant.let_push(transition);
        return Ok(instant.outcome);
    }
    instant.lift().map_err(fault)?;
    instant.motion.hold(time, instant.state, &[]).map_err(fault)?;
    instant.respond().map_err(fault)?;
    instant.press(&beside);
    let approach = instant.state.velocity.clone();
    instant.impacts()?;
    let switched = instant.motion.switch_laws(time, instant.state, tolerance);
    instant.outcome.happened.extend(switched);
    instant.let_push(transition);
    let rubbed = instant.rub(&approach, transition);
    let held = instant.decide(transition)?;
    instant.settle(&before, &held, &rubbed, transition).map_err(fault)?;
    Ok(instant.outcome)
}

/// Lets compliant stops push, or no longer, by a state that a captured step has led to, in which velocities may have jumped; what happened.
pub(in crate::simulate) fn press(motion: &mut Equations, time: f64, state: &mut State) -> Vec<Occurrence> {
    let mut instant = Instant::new(motion, time, state, 0.0, Vec::new());
    instant.let_push(None);
    instant.outcome.happened
}

/// Rigid stops that are touched, or hold, and all dry friction.
fn rows(motion: &Equations, state: &State, held: &[Holding]) -> Vec<Of> {
    let frictions = motion.model().hinge_friction.iter().enumerate();
    let of_friction = frictions.flat_map(|(index, friction)| (0..friction.count).map(move |k| Of::Friction(index, k)));
    touched(motion, state, held).into_iter().map(Of::Stop).chain(of_friction).collect()
}

/// Rigid stops that are touched, or hold.
fn touched(motion: &Equations, state: &State, held: &[Holding]) -> Vec<StopSide> {
    let stops = &motion.model().stops;
    let rigid = |side: &StopSide| stops[side.stop].is_rigid();
    let touches = |side: &StopSide| {
        let depth = stops[side.stop].depth(side.at, &state.position);
        depth >= -motion.touching(*side) || held.iter().any(|held| held.stop == Some(*side))
    };
    sides(stops).filter(|side| rigid(side) && touches(side)).collect()
}

impl<'a> Instant<'a> {
    fn new(motion: &'a mut Equations, time: f64, state: &'a mut State, tolerance: f64, rows: Vec<Of>) -> Self {
        Self {
            motion,
            time,
            state,
            tolerance,
            parted: vec![false; rows.len()],
            stopped: vec![None; rows.len()],
            rows,
            matrix: Vec::new(),
            free: Vec::new(),
            inward: Vec::new(),
            fading: Vec::new(),
            outcome: Outcome::default(),
        }
    }
}

impl Instant<'_> {
    /// The stops that are touched.
    pub(super) fn sides(&self) -> impl Iterator<Item = StopSide> {
        self.rows.iter().filter_map(|row| match row {
            Of::Stop(side) => Some(*side),
            Of::Friction(..) => None,
        })
    }

    /// Brings what is beyond a limit back to it: the search finds times just after the limit.
    fn lift(&mut self) -> Result<(), Fault> {
        let depth = |side: &StopSide| self.motion.model().stops[side.stop].depth(side.at, &self.state.position);
        let beyond: Vec<StopSide> = self.sides().filter(|side| depth(side) > 0.0).collect();
        match beyond.is_empty() {
            true => Ok(()),
            false => self.motion.lift(self.time, self.state, &beyond),
        }
    }

    /// How all coordinates answer to a unit push off each stop.
    fn respond(&mut self) -> Result<(), Fault> {
        let n = self.state.velocity.len();
        let (mut a, mut force, mut change, m) = (vec![0.0; n], vec![0.0; n], vec![0.0; n], self.rows.len());
        let coordinates: Vec<(usize, f64)> = (0..m).map(|row| self.coordinate(row)).collect();
        let (mut matrix, mut free, mut changes) = (vec![0.0; m * m], vec![0.0; m], Vec::with_capacity(m));
        let State { position, velocity } = &*self.state;
        let mut at = self.motion.system.at(self.time, position, velocity);
        let mut mass = at.accelerations(&mut a)?;
        for (column, (i, sign)) in coordinates.iter().enumerate() {
            force[*i] = -sign;
            mass.solve_mass(&force, &mut change);
            free[column] = -sign * change[*i];
            mass.answer_impulse(&force, &mut change);
            for (row, (j, sign)) in coordinates.iter().enumerate() {
                matrix[row * m + column] = -sign * change[*j];
            }
            force[*i] = 0.0;
            changes.push(change.clone());
        }
        (self.matrix, self.free, self.inward) = (matrix, free, vec![0.0; m]);
        self.press(&a);
        self.fade(&changes);
        Ok(())
    }

    /// Takes in with which accelerations rows approach their stops: as nothing holds, and beside what was held up to the instant, which may
    /// press much more.
    fn press(&mut self, a: &[f64]) {
        let rates = self.rates(a);
        self.inward.iter_mut().zip(rates).for_each(|(inward, rate)| *inward = inward.max(-rate));
    }

    /// Accelerations as no stop and no friction holds; contacts push as they did last.
    pub(in crate::simulate) fn accelerate(&mut self, a: &mut [f64]) -> Result<(), Fault> {
        let State { position, velocity } = &*self.state;
        self.motion.system.at(self.time, position, velocity).accelerations(a).map(drop)
    }

    /// The velocity coordinate of a row, and the sign of its stop's side; −1 for dry friction.
    pub(in crate::simulate) fn coordinate(&self, row: usize) -> (usize, f64) {
        let model = self.motion.model();
        match self.rows[row] {
            Of::Stop(side) => (model.stops[side.stop].velocity, side.at.sign()),
            Of::Friction(index, k) => (model.hinge_friction[index].velocity + k, -1.0),
        }
    }

    /// A row's component of velocities or accelerations: > 0 if they part it from the stop.
    pub(in crate::simulate) fn rate(&self, row: usize, of: &[f64]) -> f64 {
        let (i, sign) = self.coordinate(row);
        -sign * of[i]
    }

    pub(in crate::simulate) fn rates(&self, of: &[f64]) -> Vec<f64> {
        (0..self.rows.len()).map(|row| self.rate(row, of)).collect()
    }

    /// Round-off of a row's component: of the scene's speed, or that times `per` second, or of the largest component.
    pub(in crate::simulate) fn round_off(&self, row: usize, of: &[f64], per: f64) -> f64 {
        let (_, scales) = self.motion.scales();
        let largest = of.iter().zip(scales).map(|(x, scale)| x.abs() / scale).fold(per, f64::max);
        SPEED.of(largest) * scales[self.coordinate(row).0]
    }

    /// The speed below which nothing comes back from an impact: that of the tolerance, or of a rise `u² / (2 a)` by rounding. A coordinate
    /// that falls from its limit is found beyond it by a rounding of its own, and with the speed of that: less would be given for ever.
    pub(in crate::simulate) fn least(&self, row: usize) -> f64 {
        let part = if self.motion.model().is_constrained() { REBOUND_BESIDE_LOOPS } else { REBOUND };
        let Of::Stop(side) = self.rows[row] else { return 0.0 };
        let height = part.of(self.motion.size(side));
        self.slow(self.coordinate(row).0).max((2.0 * self.inward(row) * height).sqrt())
    }

    /// The acceleration towards a stop, at least the scene's own: what presses may do so later.
    pub(super) fn inward(&self, row: usize) -> f64 {
        let (_, velocities) = self.motion.scales();
        self.inward[row].max(0.5 * velocities[self.coordinate(row).0] / self.motion.model().time_scale())
    }

    /// A speed that is no more than the tolerance of one.
    pub(in crate::simulate) fn slow(&self, velocity: usize) -> f64 {
        self.motion.rest_speed(velocity, self.tolerance)
    }

    pub(super) fn restitution(&self, row: usize) -> f64 {
        let Of::Stop(side) = self.rows[row] else { return 0.0 };
        self.motion.model().stops[side.stop].law.restitution()
    }

    /// (1), until nothing approaches.
    fn impacts(&mut self) -> Result<(), RunError> {
        let m = self.sides().count();
        let mut unanswered = vec![false; m];
        let speeds = self.rates(&self.state.velocity);
        self.parted =
            (0..self.rows.len()).map(|row| speeds[row] > self.round_off(row, &self.state.velocity, 1.0)).collect();
        for impact in 0..=MOST_IMPACTS {
            let last = impact == MOST_IMPACTS;
            let before = self.rates(&self.state.velocity);
            let noise: Vec<f64> = (0..m).map(|row| self.round_off(row, &self.state.velocity, 1.0)).collect();
            let approaching: Vec<bool> = (0..m).map(|row| before[row] < -noise[row] && !unanswered[row]).collect();
            let approaches = |row: usize| approaching[row];
            if !(0..m).any(approaches) {
                break;
            }
            let rows: Vec<usize> = (0..m).filter(|row| last || before[*row] <= noise[*row]).collect();
            let returned = |row: usize| {
                let back = self.restitution(row) * before[row].abs();
                let returns = back > self.least(row) && !self.fades(row, back);
                if returns && !last && approaches(row) { self.restitution(row) } else { 0.0 }
            };
            let factors: Vec<f64> = rows.iter().map(|row| returned(*row)).collect();
            let rates: Vec<f64> = rows.iter().zip(&factors).map(|(row, e)| (1.0 + e) * before[*row]).collect();
            let floor: Vec<f64> = rows.iter().map(|row| noise[*row]).collect();
            let found = self.solve(&rows, &rates, &vec![ONE_SIDED; rows.len()], &floor);
            for (at, row) in rows.iter().enumerate().filter(|(at, row)| !found.active[*at] && approaches(**row)) {
                let after = found.rates[at] - factors[at] * before[*row];
                if let Of::Stop(side) = self.rows[*row]
                    && found.violated[at]
                    && after < -self.least(*row)
                {
                    return Err(self.jam(side));
                }
                // A drive that touches a stop at the speed of rounding.
                unanswered[*row] = after < -noise[*row];
            }
            self.note_impacts(&rows, &factors, &before, &noise);
            self.apply(&rows, &found.multipliers, &before)
                .map_err(|fault| RunError::Sample { time: self.time, fault })?;
        }
        Ok(())
    }

    /// `A` and its diagonal without ties, of some of the rows.
    pub(in crate::simulate) fn among(&self, rows: &[usize]) -> (Vec<f64>, Vec<f64>) {
        let (m, all) = (self.rows.len(), &self.matrix);
        let matrix = rows.iter().flat_map(|row| rows.iter().map(move |column| all[row * m + column]));
        (matrix.collect(), rows.iter().map(|row| self.free[*row]).collect())
    }

    /// The problem of some of the rows.
    pub(in crate::simulate) fn solve(
        &self,
        rows: &[usize],
        rates: &[f64],
        bounds: &[[f64; 2]],
        floor: &[f64],
    ) -> Solution {
        let (matrix, free) = self.among(rows);
        let largest = rates.iter().zip(&free).map(|(rate, free)| rate.abs() / free.sqrt()).fold(0.0, f64::max);
        let tolerances: Vec<f64> =
            free.iter().zip(floor).map(|(free, floor)| floor.max(ANSWERED * largest * free.sqrt())).collect();
        Problem { matrix: &matrix, free: &free, rates, bounds, tolerances: &tolerances }.solve()
    }

    /// Impacts of what comes back; what does not is told of once it is known whether it rests.
    fn note_impacts(&mut self, rows: &[usize], factors: &[f64], before: &[f64], noise: &[f64]) {
        for (row, factor) in rows.iter().zip(factors) {
            if before[*row] >= -noise[*row] {
                continue;
            }
            let speed = self.state.velocity[self.coordinate(*row).0];
            match *factor > 0.0 {
                true => self.note(*row, Kind::Impact, speed),
                false => self.stopped[*row] = Some(speed),
            }
        }
    }

    /// Velocities after the impulses of rows, and (2).
    ///
    /// # Errors
    /// As [`Evaluated::accelerations`](crate::dynamics::Evaluated::accelerations).
    pub(in crate::simulate) fn apply(&mut self, rows: &[usize], impulses: &[f64], before: &[f64]) -> Result<(), Fault> {
        let n = self.state.velocity.len();
        let (mut impulse, mut change) = (vec![0.0; n], vec![0.0; n]);
        for (row, push) in rows.iter().zip(impulses) {
            let (i, sign) = self.coordinate(*row);
            impulse[i] -= sign * push;
        }
        let State { position, velocity } = &*self.state;
        let mut at = self.motion.system.at(self.time, position, velocity);
        let mut mass = at.accelerations(&mut vec![0.0; n])?;
        self.outcome.work += mass.answer_impulse_with_work(&impulse, &mut change);
        self.state.velocity.iter_mut().zip(&change).for_each(|(v, change)| *v += change);
        for (row, push) in rows.iter().zip(impulses) {
            self.outcome.lost -= 0.5 * push * (self.rate(*row, &self.state.velocity) + before[*row]);
        }
        Ok(())
    }

    /// Which compliant stops push after the impacts: what was found by the search, and what follows from new speeds.
    fn let_push(&mut self, transition: Option<Transition>) {
        let compliant = |side: &StopSide| match self.motion.model().stops[side.stop].law {
            StopLaw::Compliant { stiffness, .. } => Some((*side, stiffness * self.motion.touching(*side))),
            StopLaw::Rigid { .. } => None,
        };
        let sides: Vec<(StopSide, f64)> =
            sides(&self.motion.model().stops).filter_map(|side| compliant(&side)).collect();
        for (side, noise) in sides {
            let stop = &self.motion.model().stops[side.stop];
            let State { position, velocity } = &*self.state;
            let (depth, push) = (stop.depth(side.at, position), stop.push(side.at, position, velocity));
            let (inward, touching) = (side.at.sign() * velocity[stop.velocity], self.motion.touching(side));
            let now = self.motion.system.phase().pushes(side);
            let wanted = match transition {
                Some(Transition::Push(found, pushes)) if found == side => pushes,
                _ if now => push >= -noise,
                _ if depth > touching => push > noise,
                _ => depth >= -touching && inward > self.motion.still(stop.velocity),
            };
            if wanted == now {
                continue;
            }
            let speed = velocity[stop.velocity];
            self.motion.system.phase_mut().push(side, wanted);
            let kind = if wanted { Kind::Contact } else { Kind::Separation };
            self.note_side(side, kind, speed);
        }
    }

    pub(in crate::simulate) fn note(&mut self, row: usize, kind: Kind, speed: f64) {
        if let Of::Stop(side) = self.rows[row] {
            self.note_side(side, kind, speed);
        }
    }

    pub(in crate::simulate) fn note_side(&mut self, side: StopSide, kind: Kind, speed: f64) {
        let model = self.motion.model();
        let stop = &model.stops[side.stop];
        let (name, value) = (model.bodies[stop.body].name.clone(), stop.limit(side.at));
        let unit = model.coordinate_unit(stop.velocity).to_owned();
        self.outcome.happened.push(Occurrence { time: self.time, kind, name, value, unit, speed, between: None });
    }

    /// A stop that something without another way runs through.
    pub(in crate::simulate) fn jam(&self, side: StopSide) -> RunError {
        let model = self.motion.model();
        let stop = &model.stops[side.stop];
        let drives: Vec<String> = model.drives.iter().map(|drive| format!("`{}`", drive.name)).collect();
        let by = if drives.is_empty() { "loops and gears".to_owned() } else { drives.join(", ") };
        let hinge = model.bodies[stop.body].name.clone();
        RunError::Jam { time: self.time, hinge, limit: stop.limit(side.at), by }
    }
}
