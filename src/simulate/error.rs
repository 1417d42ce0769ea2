//! Why a run ended early, with the hinge's name.

use crate::dynamics::Fault;
use crate::integrate::{Component, Limit, StepError};
use crate::model::Model;
use crate::record::RecordError;

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The integrator cannot go on.
    #[error("{0}")]
    Step(String),
    /// An explicit method on a scene that is far too stiff for it.
    #[error(
        "`{method}` is an explicit method and would need steps below {step:.1e} s: the hinge coordinate {hinge} moves at \
         {rate:.1e} per second; try `integrator = \"radau9\"`, \"sdirk4\" or \"auto\", or softer springs and dampers around it"
    )]
    Stiff {
        /// The method.
        method: &'static str,
        /// The velocity coordinate that moves fastest.
        hinge: String,
        /// Its angular frequency or decay rate (1/s).
        rate: f64,
        /// Longest stable step (s).
        step: f64,
    },
    /// The steps are so short that the end is out of reach.
    #[error(
        "at t = {time} s the run creeps: its steps are {step:.1e} s, {left:.0e} of them to the end; the hinge coordinate \
         {hinge} moves at {rate:.1e} per second; try softer springs and dampers around it, a looser tolerance, or a shorter run"
    )]
    Creep {
        /// Reached time (s).
        time: f64,
        /// Mean step (s).
        step: f64,
        /// Steps to the end.
        left: f64,
        /// The velocity coordinate that moves fastest.
        hinge: String,
        /// Its angular frequency or decay rate (1/s).
        rate: f64,
    },
    /// The start is beyond a stop.
    #[error("the hinge of `{hinge}` starts at {value}, beyond its limits {low} to {high}")]
    Limit {
        /// Body whose hinge it is.
        hinge: String,
        /// (m or rad)
        value: f64,
        /// (m or rad)
        low: f64,
        /// (m or rad)
        high: f64,
    },
    /// A stop in the way of a motion that is prescribed.
    #[error(
        "at t = {time} s the hinge of `{hinge}` is driven through its limit {limit}: {by} leave it no other way; widen \
         `limits`, or let the motion end before"
    )]
    Jam {
        /// (s)
        time: f64,
        /// Body whose hinge it is.
        hinge: String,
        /// (m or rad)
        limit: f64,
        /// What drives it.
        by: String,
    },
    /// The system cannot be evaluated where a sample is due.
    #[error("at t = {time} s: {fault}")]
    Sample {
        /// (s)
        time: f64,
        /// Why.
        fault: Fault,
    },
    /// The recording cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
}
/// The error with the hinge's name in place of an index.
pub(super) fn named(model: &Model, error: &StepError) -> RunError {
    let text = error.to_string();
    let component = match error.limit() {
        Some(Limit::ErrorEstimate(component) | Limit::NotFinite(component)) => *component,
        _ => return RunError::Step(text),
    };
    let body = match component {
        Component::Position(index) => model
            .bodies
            .iter()
            .find(|body| (body.hinge.position..body.hinge.position + body.hinge.kind.counts().0).contains(&index))
            .map(|body| format!("the position of `{}`", body.name)),
        Component::Velocity(index) => Some(format!("the velocity of {}", model.label(index))),
    };
    RunError::Step(match body {
        Some(body) => text.replace(&component.to_string(), &body),
        None => text,
    })
}
