//! What follows from an event: blows, what comes to rest on stops and what leaves them, all at one instant.
//!
//! ```text
//! (1)  blow        v⁺ = v⁻ + M⁻¹ Hᵀ λ,   0 ≤ λ ⊥ u⁺ + e u⁻ ≥ 0,   u = H v
//! (2)  energy      T⁺ − T⁻ = ½ λ·(u⁺ + u⁻) + ν·ṡ,   the second the work of drives, ν their impulses
//! (3)  rest        a = a₀ + M⁻¹ Hᵀ λ,    0 ≤ λ ⊥ H a ≥ 0      among the rows with u = 0
//! ```
//!
//! `u` are the speeds at which coordinates part from the stops that they touch; `M⁻¹` is that beside loops, drives and gears.
//!
//! **Simultaneous blows are one problem**: (1) is Newton's law of restitution for all stops that are touched and not parting,
//! each with its own coefficient, as a linear complementarity problem (`complementarity.rs`). A row with λ > 0 has u⁺ = −e u⁻
//! and u⁻ ≤ 0, so that (2) never gains energy, whatever the coefficients. A blow that drives another coordinate onto a stop it
//! touches is followed by the next one, at the same instant; after [`MOST_BLOWS`] of them all coefficients are zero, and one
//! projection ends them.
//!
//! **Sequences of blows that accumulate** (Zeno's) lose the same part of their speed with each blow, and with an inward
//! acceleration a what is left of them from a speed u on takes 2 e u / (a (1 − e)). When what would come back is no more than
//! the tolerance of a speed, or would rise by no more than rounding, the coefficient is zero and the coordinate at the limit of
//! the sequence.
//!
//! **What rests** is decided by (3), among the rows that no blow has lifted by more than the speed of rest: what presses is held,
//! up to the round-off of what presses, and a projection takes what is left of its speed.

use super::complementarity::{Problem, Solution};
use super::error::RunError;
use super::events::{Kind, Occurrence, Turn};
use super::problem::Motion;
use super::run::State;
use super::stops::{Held, Side};
use crate::dynamics::Fault;
use crate::integrate::Problem as _;
use crate::model::StopLaw;

/// What comes back from a blow with fewer than this many tolerances of a speed comes to rest.
const REST_SPEEDS: f64 = 10.0;
/// So does what would rise by less than about this part of the scene's length (1 rad), some roundings of a coordinate: it would
/// fall as fast by rounding alone.
const ROUNDED_HEIGHT: f64 = 8.0 * f64::EPSILON;
/// The same beside loops and gears, on which positions are settled to 10⁻¹⁴.
const SETTLED_HEIGHT: f64 = 32e-14;
/// Speeds and accelerations below this part of the scene's, or of the largest, are round-off.
const ROUND_OFF: f64 = 1e-12;
/// Blows at one instant; each lets all stops that are approached answer.
const MOST_BLOWS: usize = 50;
/// A row is answered when what is left of its rate is this part of the largest one.
const ANSWERED: f64 = 1e-10;
/// A row that others hold up to this part presses with what a free one would press with.
const NEARLY_TIED: f64 = 1e-9;

/// What an instant changed.
#[derive(Debug, Default)]
pub(super) struct Outcome {
    /// What happened to stops.
    pub(super) happened: Vec<Occurrence>,
    /// Energy that blows took out (J).
    pub(super) lost: f64,
    /// Work of drives in blows (J).
    pub(super) work: f64,
}

/// An instant being resolved: the stops that are touched, and how coordinates answer to what pushes off them.
struct Instant<'a> {
    motion: &'a mut Motion,
    time: f64,
    state: &'a mut State,
    /// Absolute tolerance of the run.
    tolerance: f64,
    sides: Vec<Side>,
    /// `H M⁻¹ Hᵀ` by rows, and its diagonal without loops, drives and gears.
    matrix: Vec<f64>,
    free: Vec<f64>,
    /// Accelerations towards the stops as nothing holds, ≥ 0 (m/s², rad/s²).
    inward: Vec<f64>,
    /// Rows that parted from their stops before the blows.
    parted: Vec<bool>,
    /// The last speed of each coordinate before a blow that left it none (m/s, rad/s).
    stopped: Vec<Option<f64>>,
    outcome: Outcome,
}

/// Resolves what happens at an instant: the state after it, and the mode in which the run goes on. `turn` is the event that
/// was found, `None` at the start of a run.
///
/// # Errors
/// A stop that nothing can keep from being passed, or a system that cannot be evaluated.
pub(super) fn resolve(
    motion: &mut Motion,
    time: f64,
    state: &mut State,
    tolerance: f64,
    turn: Option<Turn>,
) -> Result<Outcome, RunError> {
    let fault = |fault| RunError::Sample { time, fault };
    let before: Vec<Held> = motion.mode().map_or_else(Vec::new, |mode| mode.held.clone());
    let sides = touched(motion, state, &before);
    let mut instant = Instant {
        motion,
        time,
        state,
        tolerance,
        parted: vec![false; sides.len()],
        stopped: vec![None; sides.len()],
        sides,
        matrix: Vec::new(),
        free: Vec::new(),
        inward: Vec::new(),
        outcome: Outcome::default(),
    };
    if instant.sides.is_empty() {
        instant.let_push(turn);
        return Ok(instant.outcome);
    }
    instant.lift().map_err(fault)?;
    instant.motion.hold(time, instant.state, &[]).map_err(fault)?;
    instant.respond().map_err(fault)?;
    instant.blows()?;
    let switched = instant.motion.switch_laws(time, instant.state, tolerance);
    instant.outcome.happened.extend(switched);
    instant.let_push(turn);
    let released = match turn {
        Some(Turn::Release(side)) => Some(side),
        _ => None,
    };
    let held = instant.decide(released)?;
    instant.settle(&before, &held).map_err(fault)?;
    Ok(instant.outcome)
}

/// Rigid stops that are touched, or hold.
fn touched(motion: &Motion, state: &State, held: &[Held]) -> Vec<Side> {
    let rigid = |side: &Side| matches!(motion.model().stops[side.stop].law, StopLaw::Rigid { .. });
    let touches = |side: &Side| {
        let depth = motion.model().stops[side.stop].depth(side.sign, &state.position);
        depth >= -motion.touching(*side) || held.iter().any(|held| held.side == *side)
    };
    sides(motion).into_iter().filter(|side| rigid(side) && touches(side)).collect()
}

/// The sides of all stops.
pub(super) fn sides(motion: &Motion) -> Vec<Side> {
    let stops = motion.model().stops.iter().enumerate();
    stops.flat_map(|(index, stop)| stop.signs().map(move |sign| Side { stop: index, sign })).collect()
}

impl Instant<'_> {
    /// Brings what is beyond a limit back to it: the search finds times just after the limit.
    fn lift(&mut self) -> Result<(), Fault> {
        let depth = |side: &Side| self.motion.model().stops[side.stop].depth(side.sign, &self.state.position);
        let beyond: Vec<Side> = self.sides.iter().copied().filter(|side| depth(side) > 0.0).collect();
        match beyond.is_empty() {
            true => Ok(()),
            false => self.motion.lift(self.time, self.state, &beyond),
        }
    }

    /// How all coordinates answer to a unit push off each stop.
    fn respond(&mut self) -> Result<(), Fault> {
        let n = self.state.velocity.len();
        let mut a = vec![0.0; n];
        self.accelerate(&mut a)?;
        let (mut force, mut change, m) = (vec![0.0; n], vec![0.0; n], self.sides.len());
        self.matrix = vec![0.0; m * m];
        self.free = vec![0.0; m];
        self.inward = self.rates(&a).iter().map(|rate| (-rate).max(0.0)).collect();
        for column in 0..m {
            let (i, sign) = self.coordinate(column);
            force[i] = -sign;
            self.motion.system.factorized(&self.state.position, &self.state.velocity).solve_mass(&force, &mut change);
            self.free[column] = -sign * change[i];
            self.motion
                .system
                .factorized(&self.state.position, &self.state.velocity)
                .answer_impulse(&force, &mut change);
            for row in 0..m {
                self.matrix[row * m + column] = self.rate(row, &change);
            }
            force[i] = 0.0;
        }
        Ok(())
    }

    /// Accelerations as nothing holds, with the factorization that belongs to the state.
    fn accelerate(&mut self, a: &mut [f64]) -> Result<(), Fault> {
        let State { position, velocity } = &*self.state;
        let system = &mut self.motion.system;
        if let Some(stops) = &self.motion.stops {
            stops.press(position, velocity, system.outside());
        }
        system.at(self.time, position, velocity).accelerations(a).map(|_| ())
    }

    /// The velocity coordinate of a row, and the side of its stop.
    fn coordinate(&self, row: usize) -> (usize, f64) {
        let side = self.sides[row];
        (self.motion.model().stops[side.stop].velocity, side.sign)
    }

    /// A row's component of velocities or accelerations: > 0 if they part it from the stop.
    fn rate(&self, row: usize, of: &[f64]) -> f64 {
        let (i, sign) = self.coordinate(row);
        -sign * of[i]
    }

    fn rates(&self, of: &[f64]) -> Vec<f64> {
        (0..self.sides.len()).map(|row| self.rate(row, of)).collect()
    }

    /// Round-off of a row's component: of the scene's speed, or that times `per` second, or of the largest component.
    fn round_off(&self, row: usize, of: &[f64], per: f64) -> f64 {
        let (_, scales) = self.motion.scales();
        let largest = of.iter().zip(scales).map(|(x, scale)| x.abs() / scale).fold(per, f64::max);
        ROUND_OFF * largest * scales[self.coordinate(row).0]
    }

    /// The speed below which nothing comes back from a blow: that of the tolerance, or of a rise `u² / (2 a)` by rounding.
    fn least(&self, row: usize) -> f64 {
        let (positions, velocities) = self.motion.scales();
        let model = self.motion.model();
        let speed = velocities[self.coordinate(row).0];
        let part = if model.is_constrained() { SETTLED_HEIGHT } else { ROUNDED_HEIGHT };
        let height = part * positions[model.stops[self.sides[row].stop].position];
        // At least the scene's own acceleration: what presses may do so later.
        let inward = self.inward[row].max(0.5 * speed / model.time_scale());
        (REST_SPEEDS * self.tolerance * speed).max((2.0 * inward * height).sqrt())
    }

    fn restitution(&self, row: usize) -> f64 {
        match self.motion.model().stops[self.sides[row].stop].law {
            StopLaw::Rigid { restitution } => restitution,
            StopLaw::Compliant { .. } => 0.0,
        }
    }

    /// (1), until nothing approaches.
    fn blows(&mut self) -> Result<(), RunError> {
        let m = self.sides.len();
        let mut unanswered = vec![false; m];
        let speeds = self.rates(&self.state.velocity);
        self.parted = (0..m).map(|row| speeds[row] > self.round_off(row, &self.state.velocity, 1.0)).collect();
        for blow in 0..=MOST_BLOWS {
            let last = blow == MOST_BLOWS;
            let before = self.rates(&self.state.velocity);
            let noise: Vec<f64> = (0..m).map(|row| self.round_off(row, &self.state.velocity, 1.0)).collect();
            let approaching: Vec<bool> = (0..m).map(|row| before[row] < -noise[row] && !unanswered[row]).collect();
            let approaches = |row: usize| approaching[row];
            if !(0..m).any(approaches) {
                break;
            }
            let rows: Vec<usize> = (0..m).filter(|row| last || before[*row] <= noise[*row]).collect();
            let returned = |row: usize| match self.restitution(row) * before[row].abs() > self.least(row) {
                true if !last && approaches(row) => self.restitution(row),
                _ => 0.0,
            };
            let factors: Vec<f64> = rows.iter().map(|row| returned(*row)).collect();
            let rates: Vec<f64> = rows.iter().zip(&factors).map(|(row, e)| (1.0 + e) * before[*row]).collect();
            let floor: Vec<f64> = rows.iter().map(|row| noise[*row]).collect();
            let found = self.solve(&rows, &rates, &floor);
            for (at, row) in rows.iter().enumerate().filter(|(at, row)| !found.active[*at] && approaches(**row)) {
                let after = found.rates[at] - factors[at] * before[*row];
                if found.violated[at] && after < -self.least(*row) {
                    return Err(self.jam(*row));
                }
                // A drive that touches a stop at the speed of rounding.
                unanswered[*row] = after < -noise[*row];
            }
            self.note_blows(&rows, &factors, &before, &noise);
            self.apply(&rows, &found.multipliers, &before);
        }
        Ok(())
    }

    /// `A` and its diagonal without ties, of some of the rows.
    fn among(&self, rows: &[usize]) -> (Vec<f64>, Vec<f64>) {
        let (m, all) = (self.sides.len(), &self.matrix);
        let matrix = rows.iter().flat_map(|row| rows.iter().map(move |column| all[row * m + column]));
        (matrix.collect(), rows.iter().map(|row| self.free[*row]).collect())
    }

    /// The problem of some of the rows.
    fn solve(&self, rows: &[usize], rates: &[f64], floor: &[f64]) -> Solution {
        let (matrix, free) = self.among(rows);
        let largest = rates.iter().zip(&free).map(|(rate, free)| rate.abs() / free.sqrt()).fold(0.0, f64::max);
        let tolerances: Vec<f64> =
            free.iter().zip(floor).map(|(free, floor)| floor.max(ANSWERED * largest * free.sqrt())).collect();
        Problem { matrix: &matrix, free: &free, rates, tolerances: &tolerances }.solve()
    }

    /// Impacts of what comes back; what does not is told of once it is known whether it rests.
    fn note_blows(&mut self, rows: &[usize], factors: &[f64], before: &[f64], noise: &[f64]) {
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
    fn apply(&mut self, rows: &[usize], impulses: &[f64], before: &[f64]) {
        let n = self.state.velocity.len();
        let (mut impulse, mut change) = (vec![0.0; n], vec![0.0; n]);
        for (row, push) in rows.iter().zip(impulses) {
            let (i, sign) = self.coordinate(*row);
            impulse[i] -= sign * push;
        }
        self.motion.system.factorized(&self.state.position, &self.state.velocity).answer_impulse(&impulse, &mut change);
        self.outcome.work += self.motion.system.impulse_work(&change);
        self.state.velocity.iter_mut().zip(&change).for_each(|(v, change)| *v += change);
        for (row, push) in rows.iter().zip(impulses) {
            self.outcome.lost -= 0.5 * push * (self.rate(*row, &self.state.velocity) + before[*row]);
        }
    }

    /// Which compliant stops push after the blows: what was found by the search, and what follows from new speeds.
    fn let_push(&mut self, turn: Option<Turn>) {
        let compliant = |side: &Side| match self.motion.model().stops[side.stop].law {
            StopLaw::Compliant { stiffness, .. } => Some((*side, stiffness * self.motion.touching(*side))),
            StopLaw::Rigid { .. } => None,
        };
        let sides: Vec<(Side, f64)> = sides(self.motion).iter().filter_map(compliant).collect();
        for (side, noise) in sides {
            let stop = &self.motion.model().stops[side.stop];
            let State { position, velocity } = &*self.state;
            let (depth, push) = (stop.depth(side.sign, position), stop.push(side.sign, position, velocity));
            let (inward, touching) = (side.sign * velocity[stop.velocity], self.motion.touching(side));
            let now = self.motion.pushes(side);
            let wanted = match turn {
                Some(Turn::Push(found, pushes)) if found == side => pushes,
                _ if now => push >= -noise,
                _ if depth > touching => push > noise,
                _ => depth >= -touching && inward > self.motion.still(stop.velocity),
            };
            if wanted == now {
                continue;
            }
            let speed = velocity[stop.velocity];
            self.motion.push(side, wanted);
            let kind = if wanted { Kind::Contact } else { Kind::Separation };
            self.note_side(side, kind, speed);
        }
    }

    /// (3): what is held from now on.
    fn decide(&mut self, released: Option<Side>) -> Result<Vec<Held>, RunError> {
        let m = self.sides.len();
        let speeds = self.rates(&self.state.velocity);
        // Blows below the speed of rest lift nothing: two stops would pass each other's blows to and fro for ever.
        let lifted = |row: usize| self.parted[row] || speeds[row] > self.least(row);
        let still = |row: usize| speeds[row] <= self.round_off(row, &self.state.velocity, 1.0);
        let rests = |row: &usize| still(*row) || !lifted(*row);
        let rows: Vec<usize> = (0..m).filter(rests).collect();
        if rows.is_empty() {
            return Ok(Vec::new());
        }
        let mut a = vec![0.0; self.state.velocity.len()];
        self.accelerate(&mut a).map_err(|fault| RunError::Sample { time: self.time, fault })?;
        let noise = self.noise(&rows, &a);
        // What neither presses nor parts counts as pressing.
        let rate = |(row, noise): (&usize, &f64)| match released == Some(self.sides[*row]) {
            true => self.rate(*row, &a),
            false => self.rate(*row, &a) - noise,
        };
        let rates: Vec<f64> = rows.iter().zip(&noise).map(rate).collect();
        let floor: Vec<f64> = noise.iter().map(|noise| 0.1 * noise).collect();
        let found = self.solve(&rows, &rates, &floor);
        let (mut held, mut holding) = (Vec::new(), Vec::new());
        for (at, row) in rows.iter().enumerate() {
            let tied = found.rates[at] < -ANSWERED.sqrt() * rates[at].abs() - 10.0 * noise[at];
            if tied && found.violated[at] {
                return Err(self.jam(*row));
            }
            if found.active[at] {
                let inverse = self.matrix[row * m + row].max(NEARLY_TIED * self.free[*row]);
                held.push(Held { side: self.sides[*row], slack: 2.0 * noise[at] / inverse });
                holding.push(*row);
            }
        }
        self.stop(&holding);
        Ok(held)
    }

    /// What the accelerations of rows are known to: their round-off, and what the problem of all of them leaves unanswered. A
    /// row within that of rest presses as little as it parts.
    fn noise(&self, rows: &[usize], a: &[f64]) -> Vec<f64> {
        let per = 1.0 / self.motion.model().time_scale();
        let size = |row: &usize| self.rate(*row, a).abs() / self.free[*row].sqrt();
        let largest = rows.iter().map(size).fold(0.0, f64::max);
        let unanswered = |row: &usize| 2.0 * ANSWERED * largest * self.free[*row].sqrt();
        rows.iter().map(|row| self.round_off(*row, a, per).max(unanswered(row))).collect()
    }

    /// Takes what is left of their speeds from rows that are held from now on: a projection, which gains no energy.
    fn stop(&mut self, rows: &[usize]) {
        let before = self.rates(&self.state.velocity);
        let moving = |row: &usize| before[*row].abs() > self.round_off(*row, &self.state.velocity, 1.0);
        if !rows.iter().any(moving) {
            return;
        }
        let (matrix, free) = self.among(rows);
        let rates: Vec<f64> = rows.iter().map(|row| before[*row]).collect();
        let tolerances = vec![0.0; rows.len()];
        let problem = Problem { matrix: &matrix, free: &free, rates: &rates, tolerances: &tolerances };
        let all: Vec<usize> = (0..rows.len()).collect();
        if let Some(impulses) = problem.stationary(&all) {
            self.apply(rows, &impulses, &before);
        }
    }

    /// Puts what is held onto its limits, at rest; says what came to rest and what left.
    fn settle(&mut self, before: &[Held], held: &[Held]) -> Result<(), Fault> {
        let sides: Vec<Side> = held.iter().map(|held| held.side).collect();
        for side in &sides {
            self.state.velocity[self.motion.model().stops[side.stop].velocity] = 0.0;
        }
        if !sides.is_empty() {
            self.motion.lift(self.time, self.state, &sides)?;
        }
        self.motion.hold(self.time, self.state, held)?;
        let holds: Vec<Side> =
            self.motion.mode().map_or_else(Vec::new, |mode| mode.held.iter().map(|h| h.side).collect());
        for row in 0..self.sides.len() {
            let side = self.sides[row];
            let (was, is) = (before.iter().any(|held| held.side == side), holds.contains(&side));
            match (was, is, self.stopped[row]) {
                (false, true, speed) => self.note(row, Kind::Rest, speed.unwrap_or(0.0)),
                (true, false, _) => self.note(row, Kind::Release, 0.0),
                (false, false, Some(speed)) => self.note(row, Kind::Impact, speed),
                _ => {}
            }
        }
        Ok(())
    }

    fn note(&mut self, row: usize, kind: Kind, speed: f64) {
        self.note_side(self.sides[row], kind, speed);
    }

    fn note_side(&mut self, side: Side, kind: Kind, speed: f64) {
        let model = self.motion.model();
        let stop = &model.stops[side.stop];
        let (name, value) = (model.bodies[stop.body].name.clone(), stop.limit(side.sign));
        self.outcome.happened.push(Occurrence { time: self.time, kind, name, value, speed });
    }

    /// A stop that something without another way runs through.
    fn jam(&self, row: usize) -> RunError {
        let model = self.motion.model();
        let (side, stop) = (self.sides[row], &model.stops[self.sides[row].stop]);
        let drives: Vec<String> = model.drives.iter().map(|drive| format!("`{}`", drive.name)).collect();
        let by = if drives.is_empty() { "loops and gears".to_owned() } else { drives.join(", ") };
        let hinge = model.bodies[stop.body].name.clone();
        RunError::Jam { time: self.time, hinge, limit: stop.limit(side.sign), by }
    }
}
