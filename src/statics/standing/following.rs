//! Ends of ranges of scenes in which something follows a load: coordinates that no support pushes, of beams and springs, find their balance
//! anew for each value, while all that is supported stays where it stands.
//!
//! ```text
//! (1)  f_e(α, q_e) = 0                        what follows, all else held
//! (2)  d = df/dα along (1),   α ← α + α*(f, d)   with (L) of the supports: Newton's method
//! ```
//!
//! Where nothing that follows finds a balance, as what slides without friction, the load on it is what ends the range. A tangent that ends
//! nowhere is followed all the same, as far as loads go: what a rope bears grows by the square of what pushes across it.

use super::Unanswered;
use super::closed::Scene;
use super::settle::way;
use super::supports::{Bearers, load};
use crate::contact::support::{Limit, Undecided};
use crate::model::Model;
use crate::statics::search::{Observers, equilibrium_observed};
use crate::statics::settings::Settings;
use std::sync::Arc;

/// Step of the difference (2), in parts of what makes the loads as large again: its error makes Newton's method slower, not wrong.
const STEP: f64 = 1e-4;
/// An end is found once it moves by less than this part of what makes the loads as large again, or of itself.
const FOUND: f64 = 1e-9;
/// Beyond so many times what makes the loads as large again a range has no end.
const ENDLESS: f64 = 1e4;
/// What follows moves by no more than this part of the scene's length from one value to the next: further off it has jumped.
const JUMP: f64 = 0.5;
/// Steps of (2), and halvings of one.
const MOST_STEPS: usize = 60;
const MOST_HALVINGS: usize = 12;

/// A scene as a function of a number that loads it.
pub(super) struct Following<'a> {
    /// The model at a value; its own at 0.
    pub(super) at: &'a dyn Fn(f64) -> Result<Arc<Model>, Unanswered>,
    pub(super) settings: &'a Settings,
    pub(super) pose: &'a [f64],
    /// Velocity coordinates that supports push.
    pub(super) pushed: &'a [bool],
    /// The value at which the number is as small as it may be, if there is one.
    pub(super) least: Option<f64>,
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
        let sense = if upwards { 1.0 } else { -1.0 };
        let mut here = State { value: 0.0, model: (self.at)(0.0)?, pose: self.pose.to_vec() };
        let mut before: Option<State> = None;
        for _ in 0..MOST_STEPS {
            let tangent = match (self.tangent(&here, sense * STEP * unit, upwards), before.take()) {
                // A step has gone beyond the end by so little that no program decides it: it ends halfway.
                (Err(Unanswered::Undecided(Undecided::Inexact { .. })), Some(last)) => {
                    let Some(middle) = self.state(0.5 * (last.value + here.value), &last.pose)? else { break };
                    (here, before) = (middle, Some(last));
                    continue;
                }
                (tangent, _) => tangent?,
            };
            let Some(Limit { mut value, motion }) = tangent else { break };
            let is_end = match value.is_finite() {
                true => value.abs() <= FOUND * unit.max((here.value + value).abs()),
                false => here.value.abs() >= ENDLESS * unit,
            };
            if is_end {
                return Ok(Some(Limit { value: here.value + value, motion }));
            }
            // The tangent says little of what is further away.
            let most = unit.max(here.value.abs());
            value = value.clamp(-most, most);
            if let Some(end) = self.least.filter(|end| here.value + value <= *end) {
                let near = end + FOUND * unit;
                if near >= here.value || self.state(near, &here.pose)?.is_some() {
                    return Ok(Some(Limit { value: end, motion: Vec::new() }));
                }
            }
            // A long step may lead beyond where there is a balance.
            let tried = (0..MOST_HALVINGS).find_map(|halving| {
                let part = here.value + value * 0.5_f64.powi(halving as i32);
                self.state(part, &here.pose).transpose()
            });
            let Some(found) = tried.transpose()? else { break };
            before = Some(std::mem::replace(&mut here, found));
        }
        match here.value {
            0.0 => Ok(None),
            value => Err(Unanswered::Unbalanced { value }),
        }
    }

    /// `α*` of (2), from a difference over `step`; `None` if there is no balance at its end.
    fn tangent(&self, here: &State, step: f64, upwards: bool) -> Result<Option<Limit>, Unanswered> {
        let Some(beside) = self.state(here.value + step, &here.pose)? else { return Ok(None) };
        let scene = Scene::new(&here.model, &here.pose, self.settings.gap)?;
        let mut bearers = Bearers::new(&here.model, &here.pose, &scene)?;
        let (from, to) = (load(&here.model, &here.pose)?, load(&beside.model, &beside.pose)?);
        let mut direction: Vec<f64> = from.iter().zip(&to).map(|(from, to)| (to - from) / step).collect();
        direction.iter_mut().zip(self.pushed).filter(|(_, pushed)| !**pushed).for_each(|(d, _)| *d = 0.0);
        Ok(Some(bearers.supports.limit(&bearers.load, &direction, upwards)?))
    }

    /// (1) from a pose nearby; `None` if that finds no balance, or one elsewhere, or the number cannot have that value.
    fn state(&self, value: f64, from: &[f64]) -> Result<Option<State>, Unanswered> {
        let model = match (self.at)(value) {
            Err(Unanswered::Fixed { .. }) => return Ok(None),
            model => model?,
        };
        let held = Arc::clone(&model).locking((0..self.pushed.len()).filter(|i| self.pushed[*i]));
        let found = equilibrium_observed(&held, self.settings, from, Observers::default())?;
        let is_near = found.balanced && way(&model, from, &found.position).0 <= JUMP * model.length_scale();
        Ok(is_near.then_some(State { value, model, pose: found.position }))
    }
}
