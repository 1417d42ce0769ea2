//! What is held after an instant, among the coordinates at rest.
//!
//! ```text
//! (1)  a = a₀ + M⁻¹ Hᵀ λ,   l ≤ λ ≤ h,   H a ≥ 0 where λ = l,   H a ≤ 0 where λ = h,   H a = 0 between
//! (2)  w = A λ + b,   λ = −slide w / |w|     of a spherical hinge that begins to slide
//! ```
//!
//! Every coordinate at rest is a row with a range for its multiplier: a stop pushes and never pulls, dry friction holds up to its
//! largest force at rest, a coordinate that rests on a stop and has friction is held by both. The problem of all of them
//! (`complementarity.rs`) says which of them hold. A row holds to within the round-off of its load, and a projection takes
//! its remaining speed.
//!
//! **Friction that gives way** opposes the motion that begins with its force in motion, `slide ≤ stick`. When it drops to that,
//! others may have to give way, too: the problem of those that still hold is solved again, until none does. The direction in
//! which a spherical hinge begins to slide is that of its acceleration, (2), by the proximal
//! iteration `d ← (w + ρ d) / |w + ρ d|`, `ρ = slide · mean A_ii` (De Saxcé and Feng's).

use super::complementarity::{ONE_SIDED, Problem, Solution};
use super::instant::{ANSWERED, Instant, Of};
use super::nonsmooth::Holding;
use crate::dynamics::Fault;
use crate::dynamics::applied::{Rubbing, rate_of};
use crate::simulate::error::RunError;
use crate::simulate::events::{Kind, Occurrence, Transition};
use nalgebra::{DMatrix, Vector3};

/// A row that others hold up to this part presses with what a free one would press with.
const NEARLY_TIED: f64 = 1e-9;
/// The search for a direction ends when it changes by less.
const DIRECTION: f64 = 1e-13;
/// A direction that changes by less has not changed.
const TURNED: f64 = 1e-9;
/// Rounds in which directions are decided again.
const MOST_TURNS: usize = 30;
/// Rounds in search of a direction: it converges linearly.
const MOST_ROUNDS: usize = 500;

/// A coordinate at rest.
struct Rest {
    /// The row of the instant.
    row: usize,
    /// Dry friction that acts on it.
    friction: Option<usize>,
    /// The range of its multiplier.
    bounds: [f64; 2],
    /// Its rate as nothing holds, and what of it is round-off.
    rate: f64,
    noise: f64,
    /// The multiplier of what has given way.
    slides: Option<f64>,
}

impl Instant<'_> {
    /// What dry friction does after the impacts, which changed the velocities of the `approach`: what moves slides, also what would
    /// have come to rest had no impact set it in motion; the rest is to be decided. What it did before.
    pub(in crate::simulate) fn rub(&mut self, approach: &[f64], transition: Option<Transition>) -> Vec<Rubbing> {
        let model = self.motion.model().clone();
        let mut now = Vec::with_capacity(model.hinge_friction.len());
        for (index, friction) in model.hinge_friction.iter().enumerate() {
            let rate = rate_of(friction, &self.state.velocity);
            let row = self.rows.iter().position(|row| *row == Of::Friction(index, 0)).unwrap_or_default();
            let moves = rate.norm() > self.round_off(row, &self.state.velocity, 1.0);
            // A spherical hinge may turn about at a speed that is small and not zero.
            let slow = friction.count == 1 || rate.norm() <= 2.0 * self.slow(friction.velocity);
            let by_impacts = (rate - rate_of(friction, approach)).norm();
            let is_struck = by_impacts > self.round_off(row, &self.state.velocity, 1.0);
            let comes_to_rest = transition == Some(Transition::Still(index)) && slow && !is_struck;
            now.push(if moves && !comes_to_rest { Rubbing::Slides(rate.normalize()) } else { Rubbing::Sticks });
        }
        let rubbing = &mut self.motion.system.phase_mut().rubbing;
        let before = std::mem::replace(rubbing, now);
        if transition.is_some() { before } else { rubbing.clone() }
    }

    /// (1): what is held from now on.
    pub(in crate::simulate) fn decide(&mut self, transition: Option<Transition>) -> Result<Vec<Holding>, RunError> {
        let mut rest = self.at_rest();
        if rest.is_empty() {
            return Ok(Vec::new());
        }
        let mut a = vec![0.0; self.state.velocity.len()];
        self.accelerate(&mut a).map_err(|fault| RunError::Sample { time: self.time, fault })?;
        self.rate_rows(&mut rest, &a, transition);
        let mut found = self.solve_beside(&rest);
        for _ in 0..MOST_TURNS {
            while self.give_way(&mut rest, &found) {
                found = self.solve_beside(&rest);
            }
            if !self.turn_back(&mut rest, &found) {
                break;
            }
            found = self.solve_beside(&rest);
        }
        for (at, one) in rest.iter().enumerate() {
            let tied = found.rates[at] < -ANSWERED.sqrt() * one.rate.abs() - 10.0 * one.noise;
            if let (true, true, Of::Stop(side)) = (tied, found.violated[at], self.rows[one.row]) {
                return Err(self.jam(side));
            }
        }
        self.share(&rest, &found);
        let holding: Vec<usize> =
            rest.iter().zip(&found.active).filter(|(_, active)| **active).map(|(one, _)| one.row).collect();
        self.stop(&holding).map_err(|fault| RunError::Sample { time: self.time, fault })?;
        Ok(self.held(&rest, &found))
    }

    /// The coordinates at rest: of stops those that no impact has lifted by more than the speed of rest.
    fn at_rest(&self) -> Vec<Rest> {
        let speeds = self.rates(&self.state.velocity);
        let new = |row: usize, friction: Option<usize>, bounds: [f64; 2]| Rest {
            row,
            friction,
            bounds,
            rate: 0.0,
            noise: 0.0,
            slides: None,
        };
        let mut rest: Vec<Rest> = Vec::new();
        for row in 0..self.rows.len() {
            match self.rows[row] {
                Of::Stop(_) => {
                    // Impacts below the speed of rest lift nothing: two stops would pass each other's impacts to and fro for ever.
                    let lifted = self.parted[row] || speeds[row] > self.least(row);
                    let still = speeds[row] <= self.round_off(row, &self.state.velocity, 1.0);
                    if still || !lifted {
                        rest.push(new(row, None, ONE_SIDED));
                    }
                }
                Of::Friction(index, _) if self.rubbing(index) == Some(Rubbing::Sticks) => {
                    let friction = &self.motion.model().hinge_friction[index];
                    let most = if friction.count == 1 { friction.friction.stick } else { f64::INFINITY };
                    let coordinate = self.coordinate(row).0;
                    match rest.iter_mut().find(|other| self.coordinate(other.row).0 == coordinate) {
                        Some(stop) => (stop.friction, stop.bounds[0]) = (Some(index), -most),
                        None => rest.push(new(row, Some(index), [-most, most])),
                    }
                }
                Of::Friction(..) => {}
            }
        }
        rest
    }

    fn rubbing(&self, friction: usize) -> Option<Rubbing> {
        self.motion.system.phase().rubbing.get(friction).copied()
    }

    fn set_rubbing(&mut self, friction: usize, rubbing: Rubbing) {
        self.motion.system.phase_mut().rubbing[friction] = rubbing;
    }

    /// Rates of rows with these accelerations, and what of them is known: their round-off, and what the problem of all of them
    /// leaves unanswered. A row within that of rest presses as little as it parts; at a stop that counts as pressing.
    fn rate_rows(&self, rest: &mut [Rest], a: &[f64], transition: Option<Transition>) {
        let per = 1.0 / self.motion.model().time_scale();
        let size = |one: &Rest| self.rate(one.row, a).abs() / self.free[one.row].sqrt();
        let largest = rest.iter().map(size).fold(0.0, f64::max);
        for one in rest {
            let unanswered = 2.0 * ANSWERED * largest * self.free[one.row].sqrt();
            one.noise = self.round_off(one.row, a, per).max(unanswered);
            let released = transition == Some(Transition::Release(self.coordinate(one.row).0));
            let presses = matches!(self.rows[one.row], Of::Stop(_)) && !released;
            one.rate = self.rate(one.row, a) - if presses { one.noise } else { 0.0 };
        }
    }

    /// The problem of what has not given way; of all rows.
    fn solve_beside(&self, rest: &[Rest]) -> Solution {
        let open: Vec<usize> = (0..rest.len()).filter(|at| rest[*at].slides.is_none()).collect();
        let rows: Vec<usize> = open.iter().map(|at| rest[*at].row).collect();
        let beside =
            |row: usize| -> f64 { rest.iter().map(|one| one.slides.unwrap_or(0.0) * self.entry(row, one.row)).sum() };
        let rates: Vec<f64> = open.iter().map(|at| rest[*at].rate + beside(rest[*at].row)).collect();
        let bounds: Vec<[f64; 2]> = open.iter().map(|at| rest[*at].bounds).collect();
        let floor: Vec<f64> = open.iter().map(|at| 0.1 * rest[*at].noise).collect();
        let (matrix, free) = self.among(&rows);
        let problem = Problem { matrix: &matrix, free: &free, rates: &rates, bounds: &bounds, tolerances: &floor };
        let mut among = self.solve(&rows, &rates, &bounds, &floor);
        // What friction need not hold is held all the same.
        for at in 0..open.len() {
            let inside = bounds[at][0] < among.multipliers[at] && among.multipliers[at] < bounds[at][1];
            if rest[open[at]].friction.is_some() && inside && !among.active[at] {
                among.active[at] = !problem.follows(&among, at);
            }
        }
        let mut found = Solution {
            multipliers: rest.iter().map(|one| one.slides.unwrap_or(0.0)).collect(),
            active: vec![false; rest.len()],
            rates: rest.iter().map(|one| one.rate).collect(),
            violated: vec![false; rest.len()],
        };
        for (from, to) in open.iter().enumerate() {
            found.multipliers[*to] = among.multipliers[from];
            (found.active[*to], found.violated[*to]) = (among.active[from], among.violated[from]);
        }
        for (at, one) in rest.iter().enumerate() {
            let pushes = rest.iter().zip(&found.multipliers).map(|(other, by)| by * self.entry(one.row, other.row));
            found.rates[at] += pushes.sum::<f64>();
        }
        found
    }

    fn entry(&self, row: usize, column: usize) -> f64 {
        self.matrix[row * self.rows.len() + column]
    }

    /// Lets friction slide that cannot hold; whether that changed what the others have to hold.
    fn give_way(&mut self, rest: &mut [Rest], found: &Solution) -> bool {
        let mut changed = false;
        for at in 0..rest.len() {
            let Some(index) = rest[at].friction.filter(|_| rest[at].slides.is_none()) else { continue };
            let law = self.motion.model().hinge_friction[index];
            let (slide, stick) = (law.friction.slide, law.friction.stick);
            if law.count != 1 {
                if matches!(self.rows[rest[at].row], Of::Friction(_, 0)) {
                    let forces = Vector3::from_fn(|k, _| found.multipliers[at + k]);
                    let inverse = self.entry(rest[at].row, rest[at].row).max(f64::MIN_POSITIVE);
                    if forces.norm() > stick + 2.0 * rest[at].noise / inverse {
                        let direction = self.direction(rest, at, -forces.normalize(), slide);
                        (0..3).for_each(|k| rest[at + k].slides = Some(-slide * direction[k]));
                        // Its remaining speed has another direction.
                        self.state.velocity[law.velocity..law.velocity + law.count].fill(0.0);
                        self.set_rubbing(index, Rubbing::Slides(direction));
                        changed = true;
                    }
                }
                continue;
            }
            let [low, high] = rest[at].bounds;
            let bound = if found.multipliers[at] <= low { -1.0 } else { 1.0 };
            let saturated = found.multipliers[at] <= low || found.multipliers[at] >= high;
            if saturated && !found.active[at] && self.moves(rest, found, at) {
                rest[at].slides = Some(bound * slide);
                let along = self.coordinate(rest[at].row).1 * bound;
                self.set_rubbing(index, Rubbing::Slides(Vector3::new(along, 0.0, 0.0)));
                changed |= slide < stick;
            }
        }
        changed
    }

    /// What has given way together with others may be taken along by them, against the direction in which it would have moved
    /// alone: such a coordinate is decided again, and directions of spherical hinges are those beside all others. Whether any was
    /// changed.
    fn turn_back(&mut self, rest: &mut [Rest], found: &Solution) -> bool {
        let mut changed = false;
        for at in 0..rest.len() {
            let (Some(index), Some(_)) = (rest[at].friction, rest[at].slides) else { continue };
            let Some(Rubbing::Slides(before)) = self.rubbing(index) else { continue };
            let law = self.motion.model().hinge_friction[index];
            if law.count == 1 {
                let along = -self.coordinate(rest[at].row).1 * found.rates[at] * before.x;
                let is_back = along < -rest[at].noise;
                if is_back && law.friction.slide == 0.0 {
                    // Nothing opposes it either way.
                    self.set_rubbing(index, Rubbing::Slides(-before));
                } else if is_back {
                    rest[at].slides = None;
                    self.set_rubbing(index, Rubbing::Sticks);
                    changed = true;
                }
            } else if matches!(self.rows[rest[at].row], Of::Friction(_, 0)) {
                let now = self.direction(rest, at, before, law.friction.slide);
                (0..3).for_each(|k| rest[at + k].slides = Some(-law.friction.slide * now[k]));
                self.set_rubbing(index, Rubbing::Slides(now));
                changed |= (now - before).norm() > TURNED;
            }
        }
        changed
    }

    /// Whether a coordinate that is not held begins to move. One that depends on those that are held rests with them, to within their
    /// round-off, of which a gear may make many times its own.
    fn moves(&self, rest: &[Rest], found: &Solution, at: usize) -> bool {
        let rows: Vec<usize> = rest.iter().map(|one| one.row).collect();
        let (matrix, free) = self.among(&rows);
        let empty = vec![0.0; rows.len()];
        let bounds = vec![ONE_SIDED; rows.len()];
        let problem = Problem { matrix: &matrix, free: &free, rates: &empty, bounds: &bounds, tolerances: &empty };
        let Some(by) = problem.combination(found, at) else { return true };
        let passed: f64 = by.into_iter().map(|(other, factor)| factor.abs() * rest[other].noise).sum();
        found.rates[at].abs() > rest[at].noise + passed
    }

    /// The direction in which a spherical hinge begins to slide; `at` is its first row.
    fn direction(&self, rest: &mut [Rest], at: usize, first: Vector3<f64>, slide: f64) -> Vector3<f64> {
        let mean = (0..3).map(|k| self.entry(rest[at + k].row, rest[at + k].row)).sum::<f64>() / 3.0;
        let mut direction = first;
        for _ in 0..MOST_ROUNDS {
            (0..3).for_each(|k| rest[at + k].slides = Some(-slide * direction[k]));
            let found = self.solve_beside(rest);
            let rates = Vector3::from_fn(|k, _| found.rates[at + k]);
            let next = (rates + slide * mean * direction).try_normalize(0.0).unwrap_or(direction);
            let moved = (next - direction).norm();
            direction = next;
            if moved < DIRECTION {
                break;
            }
        }
        direction
    }

    /// What friction pushes with whose coordinates rest by what others hold.
    fn share(&mut self, rest: &[Rest], found: &Solution) {
        for (at, one) in rest.iter().enumerate() {
            let Some(index) = one.friction.filter(|_| one.slides.is_none() && !found.active[at]) else { continue };
            if self.motion.model().hinge_friction[index].count == 1 && self.rubbing(index) == Some(Rubbing::Sticks) {
                let force = -self.coordinate(one.row).1 * found.multipliers[at];
                self.set_rubbing(index, Rubbing::Dependent(force));
            }
        }
    }

    /// What of the multipliers of rows that hold is round-off: that of all their rates, `Σⱼ |A⁻¹|ᵢⱼ noiseⱼ`. Rows within what [`decide`]
    /// takes for pressing hold, so that less would let go of them as soon as they do.
    ///
    /// [`decide`]: Self::decide
    fn noise_of_multipliers(&self, holding: &[&Rest]) -> Vec<f64> {
        let entry = |i: usize, j: usize| {
            let tied = if i == j { NEARLY_TIED * self.free[holding[i].row] } else { 0.0 };
            self.entry(holding[i].row, holding[j].row) + tied
        };
        let n = holding.len();
        let symmetric = DMatrix::from_fn(n, n, |i, j| 0.5 * (entry(i, j) + entry(j, i)));
        match symmetric.cholesky() {
            Some(factors) => {
                let inverse = factors.inverse();
                (0..n).map(|i| (0..n).map(|j| inverse[(i, j)].abs() * holding[j].noise).sum()).collect()
            }
            None => (0..n).map(|i| holding[i].noise / entry(i, i)).collect(),
        }
    }

    /// What is held by the rows whose multipliers are free.
    fn held(&self, rest: &[Rest], found: &Solution) -> Vec<Holding> {
        let mut held: Vec<Holding> = Vec::new();
        let holding: Vec<&Rest> =
            rest.iter().zip(&found.active).filter(|(_, active)| **active).map(|(one, _)| one).collect();
        for (one, noise) in holding.iter().zip(self.noise_of_multipliers(&holding)) {
            let (coordinate, sign) = self.coordinate(one.row);
            let slack = 2.0 * noise;
            let law = one.friction.map(|index| self.motion.model().hinge_friction[index]);
            if let Some(law) = law.filter(|law| law.count != 1) {
                match held.iter_mut().find(|held| held.velocity == law.velocity) {
                    Some(ball) => ball.slack = ball.slack.max(slack),
                    None => {
                        let (velocity, count, range) =
                            (law.velocity, law.count, [-law.friction.stick, law.friction.stick]);
                        held.push(Holding { velocity, count, stop: None, friction: one.friction, range, slack });
                    }
                }
                continue;
            }
            let stop = match self.rows[one.row] {
                Of::Stop(side) => Some(side),
                Of::Friction(..) => None,
            };
            let [low, high] = one.bounds;
            let range = if sign > 0.0 { [-high, -low] } else { [low, high] };
            held.push(Holding { velocity: coordinate, count: 1, stop, friction: one.friction, range, slack });
        }
        held
    }

    /// Takes the remaining speed from rows that are held from now on: a projection, which gains no energy.
    ///
    /// # Errors
    /// A system that cannot be evaluated.
    fn stop(&mut self, rows: &[usize]) -> Result<(), Fault> {
        let before = self.rates(&self.state.velocity);
        let moving = |row: &usize| before[*row].abs() > self.round_off(*row, &self.state.velocity, 1.0);
        if !rows.iter().any(moving) {
            return Ok(());
        }
        let (matrix, free) = self.among(rows);
        let rates: Vec<f64> = rows.iter().map(|row| before[*row]).collect();
        let (tolerances, bounds) = (vec![0.0; rows.len()], vec![ONE_SIDED; rows.len()]);
        let problem = Problem { matrix: &matrix, free: &free, rates: &rates, bounds: &bounds, tolerances: &tolerances };
        let all: Vec<usize> = (0..rows.len()).collect();
        match problem.stationary(&all) {
            Some(impulses) => self.apply(rows, &impulses, &before),
            None => Ok(()),
        }
    }

    /// Puts what is held onto its limits, at rest; says what came to rest and what left.
    pub(in crate::simulate) fn settle(
        &mut self,
        before: &[Holding],
        held: &[Holding],
        rubbed: &[Rubbing],
        transition: Option<Transition>,
    ) -> Result<(), Fault> {
        for held in held {
            self.state.velocity[held.velocity..held.velocity + held.count].fill(0.0);
        }
        let sides: Vec<_> = held.iter().filter_map(|held| held.stop).collect();
        if !sides.is_empty() {
            self.motion.lift(self.time, self.state, &sides)?;
        }
        self.motion.hold(self.time, self.state, held)?;
        let now: Vec<Holding> = self.motion.held().to_vec();
        for row in 0..self.rows.len() {
            let Of::Stop(side) = self.rows[row] else { continue };
            let rests = |list: &[Holding]| list.iter().any(|held| held.stop == Some(side));
            match (rests(before), rests(&now), self.stopped[row]) {
                (false, true, speed) => self.note(row, Kind::Rest, speed.unwrap_or(0.0)),
                (true, false, _) => self.note(row, Kind::Release, 0.0),
                (false, false, Some(speed)) => self.note(row, Kind::Impact, speed),
                _ => {}
            }
        }
        for (index, before) in rubbed.iter().enumerate() {
            if self.rubbing(index) == Some(Rubbing::Sticks) && !now.iter().any(|held| held.friction == Some(index)) {
                // Its row depends on others: it is not known which part of their forces is its own.
                self.set_rubbing(index, Rubbing::Dependent(0.0));
            }
            let along = |rubbing: &Rubbing| match rubbing {
                Rubbing::Slides(direction) => Some(*direction),
                Rubbing::Sticks | Rubbing::Dependent(_) => None,
            };
            match (along(before), self.rubbing(index).and_then(|now| along(&now))) {
                (Some(_), None) => self.note_friction(index, Kind::Stick),
                (None, Some(_)) => self.note_friction(index, Kind::Slip),
                // At rest for no time: it slides back.
                (Some(one), Some(other)) if transition == Some(Transition::Still(index)) && one.dot(&other) < 0.0 => {
                    self.note_friction(index, Kind::Slip);
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn note_friction(&mut self, index: usize, kind: Kind) {
        let model = self.motion.model();
        let friction = &model.hinge_friction[index];
        let link = model.links.iter().find(|link| link.velocity == friction.velocity && link.joint.is_scalar());
        let value = link.map_or(0.0, |link| self.state.position[link.position]);
        let speed = rate_of(friction, &self.state.velocity).norm();
        let name = model.bodies[friction.body].name.clone();
        let unit = model.coordinate_unit(friction.velocity).to_owned();
        self.outcome.happened.push(Occurrence { time: self.time, kind, name, value, unit, speed, between: None });
    }
}
