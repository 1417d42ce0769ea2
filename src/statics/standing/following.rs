//! Ends of ranges of scenes in which something follows a load: coordinates that no support pushes, of beams and springs, find their balance
//! anew for each value, while all that is supported stays where it stands.
//!
//! ```text
//! (1)  f_e(α, q_e) = 0                        what follows, all else held
//! (2)  d = df/dα along (1),   α ← α + α*(f, d)   with (L) of the supports: Newton's method
//! ```
//!
//! Where nothing that follows finds a balance, as what slides without friction, the load on it is what ends the range.

use super::Unanswered;
use super::closed::Scene;
use super::supports::{Bearers, load};
use crate::contact::support::Limit;
use crate::model::Model;
use crate::statics::search::{Observers, equilibrium_observed};
use crate::statics::settings::Settings;
use std::sync::Arc;

/// Step of the difference (2), in parts of what makes the loads as large again: its error makes Newton's method slower, not wrong.
const STEP: f64 = 1e-4;
/// An end is found once it moves by less than this part of what makes the loads as large again, or of itself.
const FOUND: f64 = 1e-9;
/// Steps of (2), and halvings of one.
const MOST_STEPS: usize = 40;
const MOST_HALVINGS: usize = 12;

/// A scene as a function of a number that loads it.
pub(super) struct Following<'a> {
    /// The model at a value; its own at 0.
    pub(super) at: &'a dyn Fn(f64) -> Result<Arc<Model>, Unanswered>,
    pub(super) settings: &'a Settings,
    pub(super) pose: &'a [f64],
    /// Velocity coordinates that supports push.
    pub(super) pushed: &'a [bool],
}

/// The scene at a value.
struct State {
    value: f64,
    model: Arc<Model>,
    pose: Vec<f64>,
}

impl Following<'_> {
    /// The end upwards or downwards from 0; `None` where what follows has no balance beside the given pose, so that supports alone say it.
    /// `unit` makes the loads as large again.
    pub(super) fn end(&self, unit: f64, upwards: bool) -> Result<Option<Limit>, Unanswered> {
        let mut here = State { value: 0.0, model: (self.at)(0.0)?, pose: self.pose.to_vec() };
        for _ in 0..MOST_STEPS {
            let Some(beside) = self.state(here.value + STEP * unit, &here.pose)? else { break };
            let scene = Scene::new(&here.model, &here.pose, self.settings.gap)?;
            let mut bearers = Bearers::new(&here.model, &here.pose, &scene)?;
            let [from, to] = [&here, &beside].map(|state| load(&state.model, &state.pose));
            let mut direction: Vec<f64> =
                from?.iter().zip(&to?).map(|(from, to)| (to - from) / (STEP * unit)).collect();
            direction.iter_mut().zip(self.pushed).filter(|(_, pushed)| !**pushed).for_each(|(d, _)| *d = 0.0);
            let Limit { value, motion } = bearers.supports.limit(&bearers.load, &direction, upwards)?;
            let next = here.value + value;
            if value.is_infinite() || value.abs() <= FOUND * unit.max(next.abs()) {
                return Ok(Some(Limit { value: next, motion }));
            }
            // A long step may lead beyond where there is a balance.
            let tried = (0..MOST_HALVINGS).find_map(|halving| {
                let part = here.value + value * 0.5_f64.powi(halving as i32);
                self.state(part, &here.pose).transpose()
            });
            let Some(found) = tried.transpose()? else { break };
            here = found;
        }
        match here.value {
            0.0 => Ok(None),
            value => Err(Unanswered::Unbalanced { value }),
        }
    }

    /// (1) from a pose nearby; `None` if that finds no balance.
    fn state(&self, value: f64, from: &[f64]) -> Result<Option<State>, Unanswered> {
        let model = (self.at)(value)?;
        let held = Arc::clone(&model).locking((0..self.pushed.len()).filter(|i| self.pushed[*i]));
        let found = equilibrium_observed(&held, self.settings, from, Observers::default())?;
        Ok(found.balanced.then_some(State { value, model, pose: found.position }))
    }
}
