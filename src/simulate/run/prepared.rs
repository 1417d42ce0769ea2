//! What a run begins with.

use crate::model::Model;
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
    for stop in &model.stops {
        let value = start.position[stop.position];
        let slack = ON_A_LIMIT.of(value.abs().max(1.0));
        if stop.passed(value, slack).is_some() && stop.is_rigid() {
            let hinge = model.bodies[stop.body].name.clone();
            return Err(RunError::Limit { hinge, value, low: stop.range[0], high: stop.range[1] });
        }
    }
    Ok(())
}
