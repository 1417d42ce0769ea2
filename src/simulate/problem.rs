//! A system of bodies seen as a problem of time stepping: the only place where mechanics and integrators meet.

use super::bordered::Bordered;
use super::passage::Passage;
use crate::dynamics::{Coefficients, DenseTangent, Energies, Fault, Powers, System, TangentSolver};
use crate::force::{Act, Switch};
use crate::integrate::{Failure, ImplicitProblem, Point, Problem};
use crate::model::{End, Joint, Model};
use crate::simulate::run::State;
use crate::simulate::stops::{Side, Stops};
use nalgebra::Vector3;
use std::ops::Range;

/// [`System`] with what integrators ask for: this and a [`Method`](crate::integrate::Method) step a model by hand.
///
/// ```
/// use stillpoint::integrate::{Method, Options, Start};
/// use stillpoint::model::Model;
/// use stillpoint::model::description::{BodyDescription, Description, HingeDescription};
/// use stillpoint::simulate::problem::Motion;
///
/// let hinge = HingeDescription::prismatic([0.0, 0.0, 1.0]).position([10.0]);
/// let scene = Description::new("Fall").body(BodyDescription::new("stone", hinge).mass(1.0));
/// let model = Model::build(&scene).expect("a sound scene");
/// let mut motion = Motion::new(&model);
/// let start = Start { time: 0.0, position: &model.start_position, velocity: &model.start_velocity, end: 1.0 };
/// let mut stepper = Method::Dopri5.start(&mut motion, &Options::default(), start)?;
/// while !stepper.finished() {
///     stepper.step(&mut motion)?;
///     let fallen = 0.5 * 9.80665 * stepper.time().powi(2);
///     assert!((stepper.position()[0] - (10.0 - fallen)).abs() < 1e-12);
/// }
/// # Ok::<(), stillpoint::integrate::StepError>(())
/// ```
///
/// Loops want [`constraint::assemble`](crate::constraint::assemble) first; stops and events are
/// [`simulate::run`](super::run)'s.
pub struct Motion<'m> {
    system: System<'m>,
    runs: Vec<Run>,
    position_scales: Vec<f64>,
    velocity_scales: Vec<f64>,
    tangent: Tangent,
    /// `None` for a model without stops.
    stops: Option<Stops<'m>>,
    /// Where a run stands with respect to singular positions; `None` without loops.
    passage: Option<Passage>,
    /// Scratch for residuals near those.
    allowed: Vec<f64>,
    balance: Vec<f64>,
}

/// Coordinates one after the other.
enum Run {
    /// Of turns and slides, whose rates are the velocities.
    Plain { positions: Range<usize>, velocities: Range<usize> },
    /// The numbers of a quaternion and the angular velocities, from these places on.
    Ball(usize, usize),
}

/// The coordinates of a model; a long chain of turns is one run.
fn runs(model: &Model) -> Vec<Run> {
    let mut runs = Vec::new();
    for link in &model.links {
        let (at, from) = (link.position, link.velocity);
        match (link.joint, runs.last_mut()) {
            (Joint::None, _) => {}
            (Joint::Ball { .. }, _) => runs.push(Run::Ball(at, from)),
            (_, Some(Run::Plain { positions, velocities })) if positions.end == at && velocities.end == from => {
                (positions.end, velocities.end) = (at + 1, from + 1);
            }
            _ => runs.push(Run::Plain { positions: at..at + 1, velocities: from..from + 1 }),
        }
    }
    runs
}

/// The factorized tangent of an implicit step.
enum Tangent {
    /// Not asked for yet.
    None,
    /// In O(n), by sweeps.
    Sweep(Box<TangentSolver>),
    /// Dense: where more forces reach across the tree than it has coordinates.
    Dense(Box<DenseTangent>),
    /// With loops, drives or gears: bordered by their rows.
    Bordered(Box<Bordered>),
}

impl From<Fault> for Failure {
    fn from(fault: Fault) -> Self {
        Self { message: fault.to_string() }
    }
}

impl<'m> Motion<'m> {
    /// Scratch memory for a model.
    pub fn new(model: &'m Model) -> Self {
        let (length, time) = (model.length_scale(), model.time_scale());
        let mut position_scales = vec![1.0; model.position_count()];
        let mut velocity_scales = vec![1.0 / time; model.velocity_count()];
        for link in &model.links {
            if matches!(link.joint, Joint::Slide { .. }) {
                position_scales[link.position] = length;
                velocity_scales[link.velocity] = length / time;
            }
        }
        let mut system = System::new(model);
        let sizes = velocity_scales.iter().map(|scale| scale * time).collect();
        let passage = model.is_constrained().then(|| Passage::new(model, &mut system, sizes));
        let tangent = Tangent::None;
        let stops = Stops::new(model);
        let scratch = vec![0.0; if passage.is_some() { model.velocity_count() } else { 0 }];
        let (allowed, balance) = (scratch.clone(), scratch);
        Self { system, runs: runs(model), position_scales, velocity_scales, tangent, stops, passage, allowed, balance }
    }

    /// The system at a time (s), for what is recorded between steps.
    pub fn at(&mut self, time: f64) -> &mut System<'m> {
        at_time(&mut self.system, time)
    }

    /// The model.
    pub fn model(&self) -> &'m Model {
        self.system.model()
    }

    /// `a ← q̈(t, q, v)`, stops included.
    ///
    /// # Errors
    /// As [`System::accelerations`].
    pub fn accelerations(&mut self, time: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<(), Fault> {
        let system = at_time(&mut self.system, time);
        if let Some(stops) = &self.stops {
            stops.press(q, v, system.outside());
        }
        match &mut self.passage {
            Some(passage) if passage.is_near() => passage.accelerations(system, q, v, a)?,
            _ => system.accelerations(q, v, a)?,
        }
        if let Some(stops) = &mut self.stops {
            stops.correct(a, &mut |rhs, x| system.solve_mass(rhs, x));
        }
        Ok(())
    }

    /// Brings a state onto loops, drives and gears, but for one that touches a singular position.
    ///
    /// # Errors
    /// As [`System::settle`].
    pub(super) fn settle(&mut self, time: f64, q: &mut [f64], v: &mut [f64]) -> Result<(), Fault> {
        match &mut self.passage {
            Some(passage) => passage.settle(at_time(&mut self.system, time), q, v).map(drop),
            None => Ok(()),
        }
    }

    /// Kinetic and potential energy, stops included.
    pub fn energies(&mut self, time: f64, q: &[f64], v: &[f64]) -> Energies {
        let mut energies = self.at(time).energies(q, v);
        energies.potential += self.stops.as_ref().map_or(0.0, |stops| stops.potential(q));
        energies
    }

    /// Powers that no potential stands for, stops included.
    pub fn powers(&mut self, time: f64, q: &[f64], v: &[f64]) -> Powers {
        let mut powers = self.at(time).powers(q, v);
        powers.dissipated += self.stops.as_ref().map_or(0.0, |stops| stops.dissipated(v));
        powers
    }

    /// Coordinates that rest on a rigid stop.
    pub(super) fn held(&self) -> &[Side] {
        self.stops.as_ref().map_or(&[], |stops| &stops.held)
    }

    /// Whether a compliant stop pushes.
    pub(super) fn pushes(&self, side: Side) -> bool {
        self.stops.as_ref().is_some_and(|stops| stops.pushing.contains(&side))
    }

    /// Lets a compliant stop push from now on, or no longer.
    pub(super) fn push(&mut self, side: Side, pushes: bool) {
        if let Some(stops) = &mut self.stops {
            stops.pushing.retain(|other| *other != side);
            if pushes {
                stops.pushing.push(side);
            }
        }
    }

    /// Holds a coordinate on a stop from now on.
    ///
    /// # Errors
    /// As [`System::accelerations`].
    pub(super) fn hold(&mut self, time: f64, state: &State, side: Side) -> Result<(), Fault> {
        if let Some(stops) = &mut self.stops {
            stops.held.push(side);
        }
        self.tie(time, state)
    }

    /// Lets the coordinate in this place of the list go.
    ///
    /// # Errors
    /// As [`System::accelerations`].
    pub(super) fn release(&mut self, time: f64, state: &State, held: usize) -> Result<(), Fault> {
        if let Some(stops) = &mut self.stops {
            stops.held.remove(held);
        }
        self.tie(time, state)
    }

    /// Makes rows of what stops hold, beside loops, drives and gears.
    fn tie(&mut self, time: f64, state: &State) -> Result<(), Fault> {
        let (Some(stops), Some(passage)) = (&mut self.stops, &mut self.passage) else { return Ok(()) };
        let State { position, velocity } = state;
        let system = at_time(&mut self.system, time);
        stops.counts = Some(system.hold(position, velocity, &stops.rows())?);
        passage.start(system, position, velocity);
        // It has other rows now.
        self.tangent = Tangent::None;
        Ok(())
    }

    /// What presses on the stop in this place of the list; not a number where that cannot be evaluated. One that only
    /// rests with others is pressed as long as it is not passed.
    pub(super) fn pressure(&mut self, time: f64, state: &State, held: usize) -> f64 {
        let mut a = vec![0.0; state.velocity.len()];
        if self.accelerations(time, &state.position, &state.velocity, &mut a).is_err() {
            return f64::NAN;
        }
        let Some(stops) = &self.stops else { return f64::NAN };
        let side = stops.held[held];
        let stop = &stops.stops[side.stop];
        match &stops.counts {
            None => stops.pressure(held),
            Some(_) if self.rests_with_others(held) => {
                PASSED * self.position_scales[stop.position] - stop.depth(side.sign, &state.position)
            }
            Some(_) => self.round_off(stop.velocity) - side.sign * self.system.held_force(stop.velocity),
        }
    }

    /// A force (N, N m) that is round-off of the forces in the scene: what pulls a coordinate that loops or gears balance
    /// exactly off its stop changes its sign as rounding has it.
    fn round_off(&self, velocity: usize) -> f64 {
        let model = self.system.model();
        let (length, time) = (model.length_scale(), model.time_scale());
        let mass: f64 = model.bodies.iter().map(|body| body.mass.mass).sum();
        let force = ROUND_OFF * mass * length / (time * time);
        let slides =
            model.links.iter().any(|link| link.velocity == velocity && matches!(link.joint, Joint::Slide { .. }));
        if slides { force } else { force * length }
    }

    /// Whether the coordinate in this place of the list is held by loops, drives, gears and other stops.
    pub(super) fn rests_with_others(&self, held: usize) -> bool {
        let counts = self.stops.as_ref().and_then(|stops| stops.counts.as_ref());
        counts.is_some_and(|counts| counts.get(held) == Some(&false))
    }

    /// The velocities after a coordinate hit a stop; false where loops, drives, gears and what rests on stops leave it no
    /// other speed.
    ///
    /// # Errors
    /// As [`System::accelerations`].
    pub(super) fn strike(&mut self, time: f64, state: &mut State, side: Side, restitution: f64) -> Result<bool, Fault> {
        let Some(stops) = &mut self.stops else { return Ok(true) };
        let system = at_time(&mut self.system, time);
        if self.passage.is_some() {
            let after = -restitution * state.velocity[stops.stops[side.stop].velocity];
            let mut rows = stops.rows();
            rows.push(stops.row(side, after));
            let free = system.hold(&state.position, &state.velocity, &rows)?.last() == Some(&true);
            if free {
                system.settle(&mut state.position, &mut state.velocity)?;
            }
            return self.tie(time, state).map(|()| free);
        }
        let State { position, velocity } = state;
        let mut a = vec![0.0; velocity.len()];
        system.accelerations(position, velocity, &mut a)?;
        stops.strike(side, restitution, velocity, &mut |rhs, x| system.solve_mass(rhs, x));
        Ok(true)
    }

    /// The rate of a coordinate that has one (not of a quaternion's numbers).
    pub(super) fn position_speed(&self, index: usize, state: &State) -> f64 {
        let mut rate = vec![0.0; state.position.len()];
        self.position_rate(&state.position, &state.velocity, &mut rate);
        rate[index]
    }

    /// Where a point is (m).
    pub(super) fn point(&mut self, time: f64, end: &End, state: &State) -> Vector3<f64> {
        let system = self.at(time);
        system.energies(&state.position, &state.velocity);
        let link = &system.motion().links[end.link];
        link.position + link.turn * end.point
    }

    /// Where a force element stands with respect to its switching.
    pub(super) fn switch(&mut self, time: f64, force: usize, state: &State) -> Switch {
        let system = self.at(time);
        system.energies(&state.position, &state.velocity);
        system.model().forces[force].law.switch(&system.motion().links)
    }

    /// How fast a point moves (m/s).
    pub(super) fn point_velocity(&mut self, time: f64, end: &End, state: &State) -> Vector3<f64> {
        let system = self.at(time);
        system.energies(&state.position, &state.velocity);
        let link = &system.motion().links[end.link];
        link.velocity + link.angular_velocity.cross(&(link.turn * end.point))
    }
}

/// Of the forces in a scene, those below this part are round-off.
const ROUND_OFF: f64 = 1e-12;
/// A coordinate that is further beyond a stop than this (rad, part of the scene's length) is driven through it.
const PASSED: f64 = 1e-6;

/// The one way from a time to the system.
pub(super) fn at_time<'a, 'm>(system: &'a mut System<'m>, time: f64) -> &'a mut System<'m> {
    system.set_time(time);
    system
}

/// `½ p ∘ (0, ω)`: the rate of a quaternion from the angular velocity in the axes it leads from.
fn half_product(p: &[f64], w: &[f64]) -> [f64; 4] {
    [
        0.5 * (-p[1] * w[0] - p[2] * w[1] - p[3] * w[2]),
        0.5 * (p[0] * w[0] + p[2] * w[2] - p[3] * w[1]),
        0.5 * (p[0] * w[1] + p[3] * w[0] - p[1] * w[2]),
        0.5 * (p[0] * w[2] + p[1] * w[1] - p[2] * w[0]),
    ]
}

impl Problem for Motion<'_> {
    fn position_count(&self) -> usize {
        self.system.model().position_count()
    }

    fn velocity_count(&self) -> usize {
        self.system.model().velocity_count()
    }

    fn acceleration(&mut self, time: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<(), Failure> {
        Ok(self.accelerations(time, q, v, a)?)
    }

    fn position_rate(&self, q: &[f64], v: &[f64], rate: &mut [f64]) {
        for run in &self.runs {
            match run {
                Run::Plain { positions, velocities } => rate[positions.clone()].copy_from_slice(&v[velocities.clone()]),
                Run::Ball(at, from) => {
                    rate[*at..at + 4].copy_from_slice(&half_product(&q[*at..at + 4], &v[*from..from + 3]));
                }
            }
        }
    }

    fn normalize(&self, q: &mut [f64]) {
        for run in &self.runs {
            if let Run::Ball(at, _) = run {
                let p = &mut q[*at..at + 4];
                let norm = p.iter().map(|x| x * x).sum::<f64>().sqrt();
                p.iter_mut().for_each(|x| *x /= norm);
            }
        }
    }

    fn project(&mut self, time: f64, q: &mut [f64], v: &mut [f64]) -> Result<bool, Failure> {
        let Some(passage) = &mut self.passage else { return Ok(false) };
        let settled = passage.settle(at_time(&mut self.system, time), q, v)?;
        passage.advance(&settled);
        Ok(settled.moved)
    }

    fn scales(&self) -> (&[f64], &[f64]) {
        (&self.position_scales, &self.velocity_scales)
    }
}

impl ImplicitProblem for Motion<'_> {
    fn implicit_position(&self, start: &[f64], step: f64, v: &[f64], q: &mut [f64]) {
        for run in &self.runs {
            match run {
                Run::Plain { positions, velocities } => {
                    let known = start[positions.clone()].iter().zip(&v[velocities.clone()]);
                    q[positions.clone()].iter_mut().zip(known).for_each(|(q, (start, v))| *q = start + step * v);
                }
                Run::Ball(at, from) => {
                    let (at, from) = (*at, *from);
                    // (1 − ½ h Ω) p = p*, with Ω skew and Ω² = −|ω|²: p = (p* + ½ h Ω p*) / (1 + ¼ h² |ω|²)
                    let (p, w) = (&start[at..at + 4], &v[from..from + 3]);
                    let turned = half_product(p, w);
                    let scale = 1.0 + 0.25 * step * step * w.iter().map(|w| w * w).sum::<f64>();
                    for i in 0..4 {
                        q[at + i] = (p[i] + step * turned[i]) / scale;
                    }
                }
            }
        }
    }

    fn displace(&self, from: &[f64], by: &[f64], q: &mut [f64]) {
        q.copy_from_slice(from);
        System::displace(self.system.model(), q, by);
    }

    fn residual(&mut self, time: f64, q: &[f64], v: &[f64], a: &[f64], r: &mut [f64]) -> Result<(), Failure> {
        let system = at_time(&mut self.system, time);
        if let Some(stops) = &self.stops {
            stops.press(q, v, system.outside());
        }
        match &mut self.passage {
            // The accelerations that the rows allow, see `passage`; at equal multipliers the difference is M (a − a_c).
            Some(passage) if passage.is_near() => {
                passage.accelerations(system, q, v, r)?;
                self.allowed.copy_from_slice(r);
                system.residual(q, v, &self.allowed, &mut self.balance)?;
                system.residual(q, v, a, r)?;
                r.iter_mut().zip(&self.balance).for_each(|(r, allowed)| *r -= allowed);
            }
            // The multipliers of this state, see `bordered`.
            Some(_) => {
                system.accelerations(q, v, r)?;
                system.residual(q, v, a, r)?;
            }
            None => system.residual(q, v, a, r)?,
        }
        if let Some(stops) = &self.stops {
            stops.balance(r);
        }
        Ok(())
    }

    fn reserve(&mut self) {
        let model = self.system.model();
        if matches!(self.tangent, Tangent::None) {
            self.tangent = match (model.is_constrained(), TangentSolver::is_for_dense(model)) {
                (true, _) => Tangent::Bordered(Box::new(Bordered::new(&self.system))),
                (false, false) => Tangent::Sweep(Box::new(TangentSolver::new(model))),
                (false, true) => Tangent::Dense(Box::new(DenseTangent::new(model))),
            };
        }
    }

    fn factorize(&mut self, at: Point<'_>, c1: f64, c2: f64) -> Result<(), Failure> {
        let Point { time, q, v, a } = at;
        let system = at_time(&mut self.system, time);
        // Compliant stops push, as they do on the residual.
        if let Some(stops) = &self.stops {
            stops.press(q, v, system.outside());
        }
        let shift = self.stops.as_mut().map_or(&[][..], |stops| stops.diagonal(c1));
        let regular = match &mut self.tangent {
            Tangent::None => false,
            Tangent::Sweep(solver) => {
                let with = Coefficients { c1, c2, shift, ..Coefficients::default() };
                system.factorize_tangent(solver, q, v, a, &with)?
            }
            Tangent::Dense(factors) => system.factorize_dense(factors, q, v, a, [c1, c2], shift)?,
            Tangent::Bordered(factors) => {
                let weak = self.passage.as_ref().filter(|passage| passage.is_near()).map_or(0.0, Passage::weak);
                factors.factorize(system, at, [c1, c2], shift, weak)?
            }
        };
        match regular {
            true => Ok(()),
            false => Err(Failure { message: "the tangent of the implicit step is singular".to_owned() }),
        }
    }

    fn solve(&mut self, rhs: &mut [f64]) {
        match &mut self.tangent {
            Tangent::None => {}
            Tangent::Sweep(solver) => solver.solve(rhs),
            Tangent::Dense(factors) => factors.solve(rhs),
            Tangent::Bordered(factors) => factors.solve(&mut self.system, rhs),
        }
    }
}
