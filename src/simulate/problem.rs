//! A system of bodies seen as a problem of time stepping: the only place where mechanics and integrators meet.

use crate::dynamics::{Energies, Evaluated, Fault, Powers, System};
use crate::integrate::{Failure, Problem};
use crate::model::problem::number;
use crate::model::stop::sides;
use crate::model::{End, Model, StopSide};
use crate::round_off::{EVENT_TIME, ON_A_LIMIT, SPEED};
use crate::simulate::contact::Contacts;
use crate::simulate::coordinates::Coordinates;
use crate::simulate::error::RunError;
use crate::simulate::implicit::tangent::Tangent;
use crate::simulate::passage::Passage;
use crate::simulate::state::State;
use crate::simulate::stops::nonsmooth::{Holding, Nonsmooth, within};
use crate::simulate::stride::Stride;
use nalgebra::Vector3;
use std::sync::Arc;

/// [`System`] with what integrators ask for: this and a [`Method`](crate::integrate::Method) step a model by hand.
///
/// ```
/// use stillpoint::integrate::{Method, Options, Start};
/// use stillpoint::model::Model;
/// use stillpoint::model::description::{BodyDescription, Description, HingeDescription};
/// use stillpoint::simulate::problem::Equations;
///
/// let hinge = HingeDescription::prismatic([0.0, 0.0, 1.0]).position([10.0]);
/// let scene = Description::new("Fall").body(BodyDescription::new("stone", hinge).mass(1.0));
/// let model = Model::build(&scene).expect("a sound scene");
/// let mut motion = Equations::new(&model);
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
/// [`simulate::run`](crate::simulate::run)'s.
pub struct Equations {
    pub(super) system: System,
    pub(super) coordinates: Coordinates,
    position_scales: Vec<f64>,
    pub(super) velocity_scales: Vec<f64>,
    pub(super) tangent: Tangent,
    /// `None` for a model without stops and dry friction.
    pub(super) nonsmooth: Option<Nonsmooth>,
    /// What touches; `None` for a model without contact, and one that contact holds at rest.
    pub(super) contacts: Option<Box<Contacts>>,
    /// What the contacts of a scene that they hold at rest push with, rule by rule (N): its model has that as loads.
    pub(super) resting: Vec<Vector3<f64>>,
    /// Where a run stands with respect to singular positions; `None` without loops.
    pub(super) passage: Option<Passage>,
    /// How far a step may go.
    stride: Stride,
    /// Scratch for residuals near those.
    pub(super) allowed: Vec<f64>,
    pub(super) balance: Vec<f64>,
}

impl From<Fault> for Failure {
    fn from(fault: Fault) -> Self {
        Self { message: fault.to_string() }
    }
}

impl Equations {
    /// Scratch memory for a model.
    pub fn new(model: &Arc<Model>) -> Self {
        let (length, time) = (model.length_scale(), model.time_scale());
        let mut position_scales = vec![1.0; model.position_count()];
        let mut velocity_scales = vec![1.0 / time; model.velocity_count()];
        for link in &model.links {
            if link.joint.is_distance() {
                position_scales[link.position] = length;
                velocity_scales[link.velocity] = length / time;
            }
        }
        let mut system = System::new(model);
        let sizes = velocity_scales.iter().map(|scale| scale * time).collect();
        let passage = model.is_constrained().then(|| Passage::new(model, &mut system, sizes));
        let tangent = Tangent::None;
        let nonsmooth = Nonsmooth::new(model);
        let room = |wanted: bool| vec![0.0; if wanted { model.velocity_count() } else { 0 }];
        let (allowed, balance) = (room(passage.is_some()), room(passage.is_some()));
        let contacts = None;
        let coordinates = Coordinates::new(model);
        Self {
            system,
            coordinates,
            stride: Stride::new(model),
            position_scales,
            velocity_scales,
            tangent,
            nonsmooth,
            contacts,
            resting: Vec::new(),
            passage,
            allowed,
            balance,
        }
    }

    /// Scratch memory for a model that begins at a time (s) and in a state, which its loops, drives and gears agree with then.
    pub(super) fn beginning(model: &Arc<Model>, time: f64, State { position, velocity }: &State) -> Self {
        let mut motion = Self::new(model);
        if let Some(passage) = &mut motion.passage {
            passage.start(&mut motion.system, time, position, velocity);
        }
        motion
    }

    /// The system at a time (s) and a state, for what is recorded between steps.
    pub fn at<'a>(&'a mut self, time: f64, q: &'a [f64], v: &'a [f64]) -> Evaluated<'a> {
        self.system.at(time, q, v)
    }

    /// The model.
    pub fn model(&self) -> &Arc<Model> {
        self.system.model()
    }

    /// Whether captured steps are at work.
    pub(super) fn is_captured(&self) -> bool {
        self.contacts.as_ref().is_some_and(|contacts| contacts.is_captured())
    }

    /// `a ← q̈(t, q, v)`, stops included.
    ///
    /// # Errors
    /// As [`Evaluated::accelerations`].
    pub fn accelerations(&mut self, time: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<(), Fault> {
        let mut mass = if let Some(passage) = self.passage.as_mut().filter(|passage| passage.is_near()) {
            self.system.let_go_of_contacts();
            passage.accelerations(&mut self.system, time, q, v, a)?;
            if self.contacts.is_none() {
                return Ok(());
            }
            // Contacts push here; the factorization is that of a place nearby.
            self.system.at(time, q, v);
            self.system.factorized_beside(q, v)
        } else {
            let mut mass = self.system.at_without_contact(time, q, v).into_accelerations(a)?;
            if let Some(nonsmooth) = &mut self.nonsmooth {
                nonsmooth.correct(a, &mut |rhs, x| mass.solve_mass(rhs, x));
            }
            mass
        };
        if let Some(contacts) = &mut self.contacts {
            contacts.correct(&mut mass, a);
        }
        Ok(())
    }

    /// What contacts, loops, drives and gears push with at a state whose accelerations were asked for last: of forces of contacts that are not
    /// unique those that are within their cones, and multipliers with them, which were found by solving for other ones.
    ///
    /// # Errors
    /// As [`Evaluated::accelerations`].
    pub(super) fn choose_forces(&mut self, time: f64, q: &[f64], v: &[f64]) -> Result<(), Fault> {
        let touches = self.contacts.as_ref().is_some_and(|contacts| contacts.pushes_any());
        if let Some(contacts) = &mut self.contacts {
            contacts.take_others(&mut self.system, q, v);
        }
        let near = self.passage.as_ref().is_none_or(Passage::is_near);
        if !touches || near {
            return Ok(());
        }
        self.system.at(time, q, v).accelerations(&mut vec![0.0; v.len()]).map(drop)
    }

    /// Brings a state onto loops, drives and gears, but for one that touches a singular position.
    ///
    /// # Errors
    /// As [`System::settle`].
    pub(super) fn settle(&mut self, time: f64, q: &mut [f64], v: &mut [f64]) -> Result<(), Fault> {
        match &mut self.passage {
            Some(passage) => passage.settle(&mut self.system, time, q, v).map(drop),
            None => Ok(()),
        }
    }

    /// Kinetic and potential energy, stops included.
    pub fn energies(&mut self, time: f64, q: &[f64], v: &[f64]) -> Energies {
        let mut energies = self.at(time, q, v).energies();
        energies.potential += self.nonsmooth.as_ref().map_or(0.0, |nonsmooth| nonsmooth.potential(q));
        if let Some(contacts) = &mut self.contacts {
            energies.potential += contacts.potential(&self.system);
        }
        energies
    }

    /// Powers that no potential stands for, stops included.
    pub fn powers(&mut self, time: f64, q: &[f64], v: &[f64]) -> Powers {
        // What drives push with depends on what contacts push with.
        if self.contacts.is_some() && self.accelerations(time, q, v, &mut vec![0.0; v.len()]).is_err() {
            return Powers { input: f64::NAN, dissipated: f64::NAN };
        }
        let mut powers = self.system.at(time, q, v).powers();
        powers.dissipated += self.contacts.as_ref().map_or(0.0, |contacts| contacts.dissipated());
        powers.dissipated +=
            self.nonsmooth.as_ref().map_or(0.0, |nonsmooth| nonsmooth.dissipated(self.system.phase(), q, v));
        powers
    }

    /// Powers for the ledger: captured steps book what their impulses and stops do, by themselves and by drives, at their ends.
    pub(super) fn booked_powers(&mut self, time: f64, q: &[f64], v: &[f64]) -> Powers {
        match self.is_captured() {
            true => self.system.at_without_contact(time, q, v).powers(),
            false => self.powers(time, q, v),
        }
    }

    /// Lets compliant stops push, or no longer, as a state says by itself: what captured steps go by, who look at none of their events.
    pub(super) fn press_stops(&mut self, q: &[f64], v: &[f64]) {
        let Some(nonsmooth) = &self.nonsmooth else { return };
        for side in sides(&nonsmooth.model.stops) {
            let stop = &nonsmooth.model.stops[side.stop];
            if !stop.is_rigid() {
                self.system.phase_mut().push(side, stop.depth(side.at, q) > 0.0 && stop.push(side.at, q, v) > 0.0);
            }
        }
    }

    /// What stops and dry friction hold at rest.
    pub(super) fn held(&self) -> &[Holding] {
        self.nonsmooth.as_ref().map_or(&[], |nonsmooth| &nonsmooth.held)
    }

    /// Holds these coordinates from now on and no others; with loops, drives and gears those whose rows are linearly
    /// independent of theirs.
    ///
    /// # Errors
    /// As [`Evaluated::accelerations`].
    pub(super) fn hold(&mut self, time: f64, state: &State, held: &[Holding]) -> Result<(), Fault> {
        let Some(nonsmooth) = &mut self.nonsmooth else { return Ok(()) };
        nonsmooth.set_held(held);
        let Some(passage) = &mut self.passage else { return Ok(()) };
        let State { position, velocity } = state;
        let rows = nonsmooth.rows(held, position);
        let mut counts = self.system.at(time, position, velocity).hold(&rows)?.into_iter();
        nonsmooth.held.retain(|_| counts.next() == Some(true));
        passage.start(&mut self.system, time, position, velocity);
        // It has other rows now.
        self.tangent = Tangent::None;
        Ok(())
    }

    /// Puts coordinates on their limits, what loops and gears tie to them along; velocities stay. To be followed by
    /// [`Equations::hold`].
    ///
    /// # Errors
    /// As [`Evaluated::accelerations`].
    pub(super) fn lift(&mut self, time: f64, state: &mut State, sides: &[StopSide]) -> Result<(), Fault> {
        let Some(nonsmooth) = &mut self.nonsmooth else { return Ok(()) };
        if self.passage.is_none() {
            for side in sides {
                let stop = &nonsmooth.model.stops[side.stop];
                state.position[stop.position] = stop.limit(side.at);
            }
            return Ok(());
        }
        let row = |side: &StopSide| nonsmooth.row(*side, &state.position, &state.velocity);
        let rows: Vec<_> = sides.iter().filter_map(row).collect();
        self.system.at(time, &state.position, &state.velocity).hold(&rows)?;
        self.system.settle(time, &mut state.position, &mut state.velocity)?;
        Ok(())
    }

    /// Accelerations (m/s², rad/s²), and how far the forces of each part of the list of what is held are within their range,
    /// slack included (N or N m): below zero if it has to let go, not a number if that cannot be evaluated.
    pub(super) fn press(&mut self, time: f64, state: &State, a: &mut [f64], reserves: &mut Vec<f64>) {
        let evaluated = self.accelerations(time, &state.position, &state.velocity, a).is_ok();
        reserves.clear();
        let Some(nonsmooth) = &self.nonsmooth else { return };
        reserves.extend(nonsmooth.held.iter().enumerate().map(|(index, held)| match (&self.passage, evaluated) {
            (_, false) => f64::NAN,
            (None, true) => nonsmooth.reserve(index) + held.slack,
            (Some(_), true) => within(held, self.system.held_force(held.velocity)) + held.slack,
        }));
        if !evaluated {
            a.fill(f64::NAN);
        }
    }

    /// `out` ← what each contact rule exerts on its second bodies at a state whose accelerations were the last ones (N, inertial axes);
    /// empty for a scene without contact.
    pub(super) fn contact_forces(&self, out: &mut Vec<Vector3<f64>>) {
        match &self.contacts {
            Some(contacts) => contacts.by_rule(out),
            None => out.clone_from(&self.resting),
        }
    }

    /// `out` ← what stops push each velocity coordinate with at a state, whose accelerations were the last ones (N or N m). A
    /// coordinate that rests on a stop and has dry friction is held by both: the sum is not split.
    pub(super) fn stop_forces(&self, q: &[f64], v: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        if let Some(contacts) = &self.contacts {
            contacts.stop_forces(out);
        }
        let Some(nonsmooth) = &self.nonsmooth else { return };
        for side in &self.system.phase().pushing {
            let stop = &nonsmooth.model.stops[side.stop];
            out[stop.velocity] -= side.at.sign() * stop.push(side.at, q, v);
        }
        for (index, held) in nonsmooth.held.iter().enumerate().filter(|(_, held)| held.stop.is_some()) {
            out[held.velocity] += match self.passage {
                None => nonsmooth.held_force(index),
                Some(_) => self.system.held_force(held.velocity).first().copied().unwrap_or(0.0),
            };
        }
    }

    /// Whether every rigid stop is kept to [`Equations::passing`] and the rounding of time: independent of the search for
    /// events.
    ///
    /// # Errors
    /// [`RunError::Passed`].
    pub(super) fn guard(&self, time: f64, state: &State) -> Result<(), RunError> {
        for (index, stop) in self.model().stops.iter().enumerate() {
            for at in stop.sides() {
                let side = StopSide { stop: index, at };
                // What a coordinate moves by in the rounding of time.
                let rounding = EVENT_TIME.of(time.abs()) * state.velocity[stop.velocity].abs();
                let beyond = !(stop.depth(at, &state.position) <= self.passing(side).max(rounding));
                if beyond && stop.is_rigid() {
                    let hinge = self.model().bodies[stop.body].name.clone();
                    let (value, limit) = (state.position[stop.position], stop.limit(at));
                    return Err(RunError::Passed { time, hinge, value, limit });
                }
            }
        }
        Ok(())
    }

    /// Whether no shapes have sunk into each other between events: not all pairs of features have a gap.
    ///
    /// # Errors
    /// [`RunError::Touch`].
    pub(super) fn guard_shapes(&mut self, time: f64, state: &State) -> Result<(), RunError> {
        let Self { contacts: Some(contacts), system, .. } = self else { return Ok(()) };
        if contacts.is_captured() || contacts.is_at_rest() {
            return Ok(());
        }
        system.at(time, &state.position, &state.velocity);
        let Some((between, depth)) = contacts.sunk(system) else { return Ok(()) };
        let part = number(100.0 * depth);
        let why = format!("one is inside the other by {part} % of their size, where none of their features meet");
        Err(RunError::Touch { time, between, why })
    }

    /// A rigid stop may be passed by this and no more (m or rad).
    pub(super) fn passing(&self, side: StopSide) -> f64 {
        PASSED * self.size(side)
    }

    /// A coordinate this near to a limit is on it (m or rad): rounding of coordinates and times.
    pub(super) fn touching(&self, side: StopSide) -> f64 {
        ON_A_LIMIT.of(self.size(side))
    }

    /// Below this a velocity coordinate is still but for round-off (m/s or rad/s).
    pub(super) fn still(&self, velocity: usize) -> f64 {
        SPEED.of(self.velocity_scales[velocity])
    }

    /// What has no more than this speed is at rest, for a run of this absolute tolerance (m/s or rad/s).
    pub(super) fn rest_speed(&self, velocity: usize, tolerance: f64) -> f64 {
        REST_SPEEDS * tolerance * self.velocity_scales[velocity]
    }

    /// From which speed on spherical hinges slide in the direction of their own angular velocity.
    pub(super) fn set_tolerance(&mut self, tolerance: f64) {
        self.system.phase_mut().slow = SLOW * REST_SPEEDS * tolerance / self.model().time_scale();
    }

    /// What a coordinate of a stop is compared with: its limit, or the scene's length (1 rad).
    pub(super) fn size(&self, side: StopSide) -> f64 {
        let stop = &self.model().stops[side.stop];
        self.position_scales[stop.position].max(stop.limit(side.at).abs())
    }

    /// Where a point is (m).
    pub(super) fn point(&mut self, time: f64, end: &End, state: &State) -> Vector3<f64> {
        let at = self.at(time, &state.position, &state.velocity);
        let link = &at.motion().links[end.link];
        link.position + link.turn * end.point
    }

    /// How fast a point moves (m/s).
    pub(super) fn point_velocity(&mut self, time: f64, end: &End, state: &State) -> Vector3<f64> {
        let at = self.at(time, &state.position, &state.velocity);
        let link = &at.motion().links[end.link];
        link.velocity + link.angular_velocity.cross(&(link.turn * end.point))
    }
}

/// A rigid stop that is passed by more than this part of its coordinate is passed.
const PASSED: f64 = 1e-9;
/// What comes back from an impact with fewer than this many tolerances of a speed comes to rest.
pub(super) const REST_SPEEDS: f64 = 10.0;
/// Spherical hinges that slide more slowly than so many speeds of rest have the direction of the last step.
const SLOW: f64 = 100.0;
impl Problem for Equations {
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
        self.coordinates.rate(q, v, rate);
    }

    fn normalize(&self, q: &mut [f64]) {
        self.coordinates.normalize(q);
    }

    fn project(&mut self, time: f64, q: &mut [f64], v: &mut [f64]) -> Result<bool, Failure> {
        let mut moved = false;
        if let Some(passage) = &mut self.passage {
            let settled = passage.settle(&mut self.system, time, q, v)?;
            passage.advance(&settled);
            moved = settled.moved;
        }
        match &mut self.contacts {
            Some(contacts) => Ok(contacts.project(&mut self.system, time, q, v)? || moved),
            None => Ok(moved),
        }
    }

    fn longest_step(&self, q: &[f64], v: &[f64]) -> f64 {
        self.stride.longest(q, v)
    }

    fn scales(&self) -> (&[f64], &[f64]) {
        (&self.position_scales, &self.velocity_scales)
    }
}
