//! What a run begins with.

use crate::model::problem::{Element, Problem};
use crate::model::{Body, Description, Model, Stop};
use crate::record::ContactPush;
use crate::round_off::ON_A_LIMIT;
use crate::simulate::checks::finite;
use crate::simulate::error::RunError;
use crate::simulate::problem::Equations;
use crate::simulate::resting;
use crate::simulate::settings::Settings;
use crate::simulate::state::State;
use std::sync::Arc;

/// A run before its first instant: the state at which it begins, and the model as contact holds it.
pub(super) struct Prepared {
    pub(super) model: Arc<Model>,
    pub(super) state: State,
    pub(super) contacts: Vec<ContactPush>,
    /// Whether contact holds it at rest.
    pub(super) rests: bool,
}

impl Prepared {
    /// Of a model that starts in a state; with `may_rest` contact may hold it there.
    ///
    /// # Errors
    /// A start that no run can begin at.
    pub(super) fn new(
        model: &Arc<Model>,
        settings: &Settings,
        start: &State,
        may_rest: bool,
    ) -> Result<(Self, Equations), RunError> {
        let begin = settings.begin();
        let (mut motion, mut state) = (Equations::beginning(model, begin, start), start.clone());
        motion
            .system
            .settle(begin, &mut state.position, &mut state.velocity)
            .map_err(|fault| RunError::Sample { time: begin, fault })?;
        check_limits(model, &state)?;
        finite::check_start(model, &state, settings.tolerance)?;
        let held = if may_rest { resting::held(model, settings, &state)? } else { None };
        let Some(held) = held else {
            return Ok((Self { model: Arc::clone(model), state, contacts: Vec::new(), rests: false }, motion));
        };
        let mut motion = Equations::beginning(&held.model, begin, &state);
        motion.resting = held.by_rule;
        Ok((Self { model: held.model, state, contacts: held.contacts, rests: true }, motion))
    }
}

/// A run starts within its rigid limits: they are walls.
fn check_limits(model: &Model, start: &State) -> Result<(), RunError> {
    passed(model, &start.position).next().map_or(Ok(()), |(_, error)| Err(error))
}

/// The rigid stops that a position is beyond, with what is said of each.
fn passed<'m>(model: &'m Model, position: &'m [f64]) -> impl Iterator<Item = (&'m Stop, RunError)> {
    model.stops.iter().filter(|stop| stop.is_rigid()).filter_map(|stop| {
        let value = position[stop.position];
        stop.passed(value, ON_A_LIMIT.of(value.abs().max(1.0)))?;
        let hinge = model.bodies[stop.body].name.clone();
        Some((stop, RunError::Limit { hinge, value, low: stop.range[0], high: stop.range[1] }))
    })
}

/// What is wrong with the pose that a scene gives as the start of a run: the hinges that are beyond their rigid limits once loops, drives and
/// gears are closed at t = 0. Empty if that pose cannot be evaluated: whoever runs it is told why.
pub fn check_given(model: &Arc<Model>, description: &Description) -> Vec<Problem> {
    if !model.stops.iter().any(Stop::is_rigid) {
        return Vec::new();
    }
    let (mut q, mut v) = (model.start_position.clone(), model.start_velocity.clone());
    let start = State { position: q.clone(), velocity: v.clone() };
    if Equations::beginning(model, 0.0, &start).system.settle(0.0, &mut q, &mut v).is_err() {
        return Vec::new();
    }
    let problem = |(stop, error): (&Stop, RunError)| {
        let Body { name, hinge, .. } = &model.bodies[stop.body];
        let of_beam = description.beams.iter().position(|beam| beam.name == *name).map(Element::Beam);
        let of_body = description.bodies.iter().position(|body| body.name == *name).map(Element::Body);
        // A list of a repeat is one of its copies.
        let is_only = hinge.kind.counts().0 == 1 || name.ends_with(']');
        let index = if is_only { String::new() } else { format!("[{}]", stop.position - hinge.position) };
        Some(Problem {
            element: of_body.or(of_beam)?,
            field: format!("hinge.position{index}"),
            message: error.to_string(),
            help: Some(
                "rigid limits are walls: begin the run within them, widen `limits`, or give the stop a `stiffness`"
                    .to_owned(),
            ),
        })
    };
    passed(model, &q).filter_map(problem).collect()
}
