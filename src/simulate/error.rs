//! Why a run ended early, with the hinge's name.

use crate::dynamics::Fault;
use crate::integrate::{Component, Limit, StepError};
use crate::model::Model;
use crate::model::problem::{apart, number};
use crate::record::RecordError;

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The integrator cannot go on.
    #[error("{0}")]
    Step(String),
    /// Contact that a run cannot have.
    #[error("contact `{name}`: {why}")]
    Contact {
        /// The first one.
        name: String,
        /// Why not.
        why: String,
    },
    /// What another run has left, of another scene.
    #[error("what stops, dry friction and contacts did at t = {} s is of another scene: leave `mode` out of the start file, and it is decided anew", number(*.time))]
    Mode {
        /// When (s).
        time: f64,
    },
    /// Bodies whose contact cannot be decided.
    #[error("at t = {} s the contact of `{}` and `{}` cannot be decided: {why}", number(*.time), .between[0], .between[1])]
    Touch {
        /// Time (s).
        time: f64,
        /// Names of the bodies.
        between: [String; 2],
        /// What is in the way.
        why: String,
    },
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
        "at t = {} s the run creeps: its steps are {step:.1e} s, {left:.0e} of them to the end; the error of \
         {component} asks for them; try softer springs and dampers around it, a looser tolerance, or a shorter run", number(*.time)
    )]
    Creep {
        /// Reached time (s).
        time: f64,
        /// Mean step (s).
        step: f64,
        /// Steps to the end.
        left: f64,
        /// What decides the length of the last one, in words.
        component: String,
    },
    /// The start is beyond a stop.
    #[error("the hinge of `{hinge}` starts at {}", beyond(*.value, *.low, *.high))]
    Limit {
        /// Body whose hinge it is.
        hinge: String,
        /// Value (m or rad).
        value: f64,
        /// Lower limit (m or rad).
        low: f64,
        /// Upper limit (m or rad).
        high: f64,
    },
    /// A stop in the way of a motion that is prescribed.
    #[error(
        "at t = {} s the hinge of `{hinge}` is driven through its limit {}: {by} leave it no other way; widen \
         `limits`, or let the motion end before", number(*.time), number(*.limit)
    )]
    Jam {
        /// Time (s).
        time: f64,
        /// Body whose hinge it is.
        hinge: String,
        /// Limit (m or rad).
        limit: f64,
        /// What drives it.
        by: String,
    },
    /// A rigid stop that was passed without an event: the guard behind the search for events.
    #[error(
        "at t = {} s the hinge of `{hinge}` is at {}: the stop was passed between two looks; try a \
         smaller `tolerance` or `step`, or a compliant stop, and please report the scene", number(*.time), apart(*.value, *.limit).join(", beyond its rigid limit ")
    )]
    Passed {
        /// Time (s).
        time: f64,
        /// Body whose hinge it is.
        hinge: String,
        /// Where it is (m or rad).
        value: f64,
        /// Limit (m or rad).
        limit: f64,
    },
    /// A body at the end of its curve.
    #[error(
        "at t = {} s `{hinge}` leaves its curve at its end, an arc length of {} m, with {} m/s; let it go there by a `[[stage]]` with \
         `open = [\"{hinge}\"]` and an `[[event]]` of this hinge at the end; or give the hinge `limits`, make the curve longer, or end the \
         run by an event with `action = \"stop\"`", number(*.time), number(*.at), number(*.speed)
    )]
    Leaves {
        /// (s)
        time: f64,
        /// The body.
        hinge: String,
        /// (m)
        at: f64,
        /// (m/s)
        speed: f64,
    },
    /// Events in ever shorter times.
    #[error(
        "at t = {} s the run creeps: {count} events within {span:.1e} s, the last at `{name}`, and {} s to go; try a smaller \
         `restitution`, a compliant stop with `damping`, or a shorter run", number(*.time), number(*.left)
    )]
    Storm {
        /// Time (s).
        time: f64,
        /// Events counted.
        count: u64,
        /// The time they took (s).
        span: f64,
        /// Time to the end (s).
        left: f64,
        /// Body whose hinge the last one was at, or the force.
        name: String,
    },
    /// What both sides of a switch drive back to.
    #[error(
        "at t = {} s the formula of `{motor}` switches to and fro: what it does on both sides drives back to the switch, where it has no value; \
         dry friction is `friction` of a hinge, a control that switches needs a band (`tanh(v/0.01)` for `sign(v)`), and a method of fixed steps \
         (`integrator = \"rk4\"`) goes across", number(*.time)
    )]
    Chatters {
        /// Time (s).
        time: f64,
        /// The motor.
        motor: String,
    },
    /// An angle with too few digits after the point.
    #[error(
        "the hinge coordinate {hinge} starts at {} rad, where angles are {rounding:.1e} rad apart and the tolerance is \
         {tolerance:.1e}; take whole turns off its position", number(*.angle)
    )]
    Coarse {
        /// The coordinate.
        hinge: String,
        /// Angle (rad).
        angle: f64,
        /// Rounding (rad).
        rounding: f64,
        /// Tolerance of the run.
        tolerance: f64,
    },
    /// A controller that cannot act.
    #[error("at t = {} s the controller `{name}` cannot act: {reason}", number(*.time))]
    Controller {
        /// Time (s).
        time: f64,
        /// Its name; `function` for one of a program.
        name: String,
        /// What is wrong.
        reason: String,
    },
    /// A controller that does not let an equilibrium be one.
    #[error(
        "at the equilibrium that statics has found with `{input}` at {}: give its \
         `bias` and `setpoint` the values that belong to each other there, or start at a given state", apart(*.given, *.asked).join(&format!(" the controller `{name}` sets it to "))
    )]
    Unsteady {
        /// The controller.
        name: String,
        /// The motor that it drives.
        input: String,
        /// What statics has seen (N or N m).
        given: f64,
        /// Force or torque asked for (N or N m).
        asked: f64,
    },
    /// The system cannot be evaluated where a sample is due.
    #[error("at t = {} s: {fault}", number(*.time))]
    Sample {
        /// Time (s).
        time: f64,
        /// Why.
        fault: Fault,
    },
    /// A change of structure that cannot be made.
    #[error("at t = {} s stage `{name}` cannot come: {why}", number(*.time))]
    Stage {
        /// Time (s).
        time: f64,
        /// Its name.
        name: String,
        /// What is in the way.
        why: String,
    },
    /// A run that stages cannot be part of.
    #[error("stages cannot be followed here: {0}")]
    Stages(&'static str),
    /// The recording cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// A coordinate and the limits that it is beyond, with as many digits as tell them apart.
fn beyond(value: f64, low: f64, high: f64) -> String {
    let ([at, shown], is_low) = if value < low { (apart(value, low), true) } else { (apart(value, high), false) };
    let [low, high] = if is_low { [shown, number(high)] } else { [number(low), shown] };
    format!("{at}, beyond its limits {low} to {high}")
}

/// The error with the hinge's name in place of an index.
pub(super) fn named(model: &Model, error: &StepError) -> RunError {
    let text = error.to_string();
    let component = match error.limit() {
        Some(Limit::ErrorEstimate(component) | Limit::NotFinite(component)) => *component,
        _ => return RunError::Step(text),
    };
    RunError::Step(match component_name(model, component) {
        Some(name) => text.replace(&component.to_string(), &name),
        None => text,
    })
}

/// A component of the state in words; `None` for a position of a flexible element.
pub(super) fn component_name(model: &Model, component: Component) -> Option<String> {
    match component {
        Component::Position(index) => model
            .bodies
            .iter()
            .find(|body| (body.hinge.position..body.hinge.position + body.hinge.kind.counts().0).contains(&index))
            .map(|body| format!("the position of `{}`", body.name)),
        Component::Velocity(index) => Some(format!("the velocity of {}", model.label(index))),
    }
}
