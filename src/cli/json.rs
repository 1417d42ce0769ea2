//! What commands print with `--json`: the keys of the contract, SI numbers in full precision.

use super::output::bare;
use super::{beams, modals, text};
use crate::constraint::LoopReaction;
use crate::dynamics::{BeamState, Fault, System};
use crate::model::{Model, Output};
use crate::simulate::events::{Kind, Occurrence};
use crate::simulate::verify::{Verified, quaternion_error};
use crate::simulate::{State, Summary};
use crate::spatial::{Pose, Wrench};
use crate::statics::Equilibrium;
use serde_json::{Map, Value, json};
use std::sync::Arc;

/// One list per hinge, by the name of the body it carries; welded bodies have none.
pub(super) fn by_hinge(model: &Model, numbers: &[f64], of_position: bool) -> Value {
    let mut map = Map::new();
    for body in &model.bodies {
        let (positions, velocities) = body.hinge.kind.counts();
        let (at, count) = match of_position {
            true => (body.hinge.position, positions),
            false => (body.hinge.velocity, velocities),
        };
        if count > 0 {
            map.insert(body.name.clone(), json!(numbers[at..at + count]));
        }
    }
    Value::Object(map)
}

/// Loops and gears with redundant rows.
pub(super) fn redundant(redundant: &[(String, usize, usize)]) -> Value {
    let one = |(name, redundant, rows): &(String, usize, usize)| json!({ "element": bare(name), "redundant": redundant, "rows": rows });
    Value::Array(redundant.iter().map(one).collect())
}

/// Names and lists of numbers.
fn lists(lists: &[(String, Vec<f64>)]) -> Value {
    Value::Object(lists.iter().map(|(name, list)| (bare(name), json!(list))).collect())
}

/// What the loops pass, by their names.
pub(super) fn loops(model: &Model, loops: &[LoopReaction]) -> Value {
    let of_loop = |one: &LoopReaction| {
        let (f, m) = (one.force, one.moment);
        let mut value = json!({
            "force": [f.x, f.y, f.z],
            "moment": [m.x, m.y, m.z],
            "gap": one.gap,
            "unique": one.unique,
            "around": one.around.iter().map(|body| &model.bodies[*body].name).collect::<Vec<_>>(),
        });
        if let Some(pull) = one.pull {
            value["pull"] = json!(pull);
        }
        (one.name.clone(), value)
    };
    Value::Object(loops.iter().map(of_loop).collect())
}

/// The outputs by name: a number, or a list of several.
pub(super) fn outputs(model: &Model, values: &[f64]) -> Value {
    let of = |output: &Output| {
        let values = values.get(output.range()).unwrap_or_default();
        (output.name.clone(), if let [one] = values { json!(one) } else { json!(values) })
    };
    Value::Object(model.outputs.iter().map(of).collect())
}

/// What every drive or motor pushes, by its name (N or N m).
pub(super) fn pushes(forces: &[(String, f64)]) -> Value {
    Value::Object(forces.iter().map(|(name, force)| (name.clone(), json!(force))).collect())
}

/// What every rope and curve pulls with (N).
fn pulls(model: &Arc<Model>, q: &[f64], v: &[f64]) -> Value {
    let mut system = System::new(model);
    let at = system.at(0.0, q, v);
    Value::Object(at.pulls().map(|(name, pull)| (name.to_owned(), json!(pull))).collect())
}

pub(super) fn poses(model: &Model, poses: &[Pose]) -> Value {
    let of_body = |(body, pose): (&crate::model::Body, &Pose)| {
        let (p, q) = (pose.translation.vector, pose.rotation);
        (body.name.clone(), json!({ "position": [p.x, p.y, p.z], "quaternion": [q.w, q.i, q.j, q.k] }))
    };
    let mut all: Map<_, _> = model.bodies.iter().zip(poses).filter(|(body, _)| !body.is_inner).map(of_body).collect();
    for beam in &model.beams {
        // A beam's name stands for its tip.
        if let Some(last) = beam.elements.last() {
            let (_, tip) = of_body((&model.bodies[last.body], &poses[last.body]));
            all.insert(beam.name.clone(), tip);
        }
    }
    Value::Object(all)
}

fn reactions(model: &Model, reactions: &[Wrench]) -> Value {
    let of_body = |(body, wrench): (&crate::model::Body, &Wrench)| {
        let (f, m) = (wrench.force, wrench.moment);
        (body.name.clone(), json!({ "force": [f.x, f.y, f.z], "moment": [m.x, m.y, m.z] }))
    };
    let bodies = model.bodies.iter().zip(reactions).filter(|(body, _)| !body.is_inner);
    Value::Object(bodies.map(of_body).collect())
}

pub(super) fn statics(model: &Arc<Model>, found: &Equilibrium, wall_seconds: f64) -> Value {
    let stability = found.stability.as_ref();
    let modes: Vec<Value> = stability.map_or(Vec::new(), |s| s.modes.iter().map(mode).collect());
    let frequencies: Vec<f64> = stability.map_or(Vec::new(), |stability| stability.frequencies().collect());
    let (beams, unknown) = told_of_beams(crate::statics::beams(model, found));
    let mut value = json!({
        "converged": found.converged,
        "balanced": found.balanced,
        "method": found.method,
        "stage": found.stage,
        "iterations": found.iterations,
        "stages": found.stages.iter().map(stage).collect::<Vec<_>>(),
        "force_evaluations": found.force_evaluations,
        "acceleration_evaluations": found.acceleration_evaluations,
        "stiffness_evaluations": found.stiffness_evaluations,
        "factorizations": found.factorizations,
        "residual_acceleration": found.residual_acceleration,
        "residual_force": found.residual_force,
        "residual_unit": found.residual_at.map(|at| model.force_unit(at)),
        "residual_at": found.residual_at.map(|at| bare(&model.label(at))),
        "relative_residual": found.relative_residual,
        "round_off": found.round_off,
        "positions": by_hinge(model, &found.position, true),
        "bodies": poses(model, &found.poses),
        "stability": stability.map(|s| s.verdict.name()),
        "stability_supposes": stability.and_then(|s| s.supposes),
        "unstable_directions": stability.map(|s| s.unstable_directions),
        "neutral_directions": stability.map(|s| s.neutral_directions),
        "frequencies_hz": frequencies,
        "modes": modes,
        "damped_modes": stability.map_or(Vec::new(), |s| s.damped.iter().map(damped).collect::<Vec<_>>()),
        "reactions": reactions(model, &found.reactions),
        "beams": beams,
        "modal": modals::json(model, &found.position, &found.poses),
        "holding": found.holding.iter().map(|(name, force)| json!({ "hinge": bare(name), "force": force })).collect::<Vec<_>>(),
        "stops": found.stops.iter().map(bearing).collect::<Vec<_>>(),
        "aimed": found.aimed.iter().map(|(name, value)| (name.clone(), json!(value))).collect::<Map<_, _>>(),
        "unknowns": found.unknowns.iter().map(|(name, value)| (name.clone(), json!(value))).collect::<Map<_, _>>(),
        "drives": pushes(&found.drive_forces),
        "motors": pushes(&model.motor_forces(&found.position, &found.velocity)),
        "pulls": pulls(model, &found.position, &found.velocity),
        "multipliers": lists(&found.carried),
        "redundant": redundant(&found.redundant),
        "loop_reactions": loops(model, &found.loops),
        "notes": found.notes.iter().cloned().chain(unknown).collect::<Vec<_>>(),
        "wall_seconds": wall_seconds,
    });
    if let Some(standing) = &found.standing {
        value["standing"] = super::standing::json(model, standing);
        if !standing.margins.inputs.is_empty() {
            value["inputs"] = super::standing::inputs(standing);
        }
    }
    value
}

/// The key `beams`; `null` if what they bear cannot be computed, and the note that says why.
fn told_of_beams(beams: Result<Vec<BeamState>, Fault>) -> (Value, Option<String>) {
    match beams {
        Ok(beams) => (beams::json(&beams), None),
        Err(fault) => (Value::Null, Some(format!("what the beams bear is not known: {fault}"))),
    }
}

fn bearing(stop: &crate::statics::BearingStop) -> Value {
    json!({
        "hinge": bare(&stop.hinge),
        "side": stop.side.name(),
        "limit": stop.limit,
        "load": stop.load,
        "depth": stop.depth,
    })
}

fn damped(mode: &crate::statics::DampedMode) -> Value {
    json!({
        "decay_rate": mode.decay_rate,
        "frequency_hz": mode.frequency_hz,
        "damping_ratio": mode.damping_ratio,
        "hinges": mode.shares.iter().take(5).map(|(name, share)| json!({ "hinge": name, "share": share })).collect::<Vec<_>>(),
    })
}

fn stage(stage: &crate::statics::Stage) -> Value {
    json!({
        "name": stage.name,
        "iterations": stage.iterations,
        "force_evaluations": stage.force_evaluations,
        "factorizations": stage.factorizations,
        "relative_residual": stage.relative_residual,
        "balanced": stage.balanced,
    })
}

fn mode(mode: &crate::statics::NaturalMode) -> Value {
    json!({
        "frequency_hz": mode.frequency_hz,
        "growth_rate": mode.growth_rate,
        "hinges": mode.shares.iter().take(5).map(|(name, share)| json!({ "hinge": name, "share": share })).collect::<Vec<_>>(),
    })
}

/// What `run --verify` found.
pub(super) fn verified(verified: &Verified) -> Value {
    let Verified { method, tolerance, captured, length, angle, speed, rate, time, events } = verified;
    let events = events.as_ref().map(|found| {
        json!({
            "events": found.events, "same": found.same, "apart": found.apart, "differ_from": found.differ_from,
            "scanned": found.scanned, "beyond": found.beyond,
        })
    });
    json!({
        "method": method.name(), "tolerance": tolerance, "captured": captured,
        "length": length, "angle": angle, "speed": speed, "rate": rate, "time": time, "events": events,
    })
}

fn event(event: &Occurrence, told: &[(String, String, f64)]) -> Value {
    let Occurrence { time, kind, name, value, unit, speed, between } = event;
    let mut event =
        json!({ "time": time, "kind": kind.name(), "name": name, "value": value, "unit": unit, "speed": speed });
    match kind {
        Kind::Force(_) => event["force"] = json!(name),
        Kind::Crossing | Kind::Switch => {}
        Kind::Stage => {
            let of_stage = told.iter().filter(|(stage, ..)| stage == name);
            event["outputs"] = of_stage.map(|(_, label, value)| (label.clone(), json!(value))).collect();
        }
        _ if between.is_some() => event["between"] = json!(between),
        _ => event["hinge"] = json!(name),
    }
    event
}

/// The end of a run, in the model that it ends with.
pub(super) fn run(scenario: &str, recording: &str, start: Value, summary: &Summary) -> Value {
    let model = &summary.model;
    let State { position, velocity } = &summary.state;
    let integrators: Vec<&str> = summary.integrators.iter().map(|method| method.name()).collect();
    let counters = &summary.statistics;
    let (beams, unknown) = told_of_beams(beams::moving(model, position, velocity));
    json!({
        "scenario": scenario,
        "recording": recording,
        "start": start,
        "end_time": summary.end_time,
        "interrupted": summary.interrupted,
        "integrator": integrators.join(", "),
        "integrator_choice": summary.choice,
        "steps": counters.steps,
        "rejected_steps": counters.rejected_steps,
        "acceleration_evaluations": counters.acceleration_evaluations,
        "residual_evaluations": counters.residual_evaluations,
        "jacobian_evaluations": counters.jacobian_evaluations,
        "error_sum": counters.error_sum,
        "energy_start": summary.energy_start,
        "energy_end": summary.energy_end,
        "energy_work": summary.work,
        "energy_dissipated": summary.dissipated,
        "energy_drift": summary.energy_drift,
        "constraint_error": summary.constraint_error,
        "quaternion_error": quaternion_error(model, &summary.state),
        "events": summary.events.iter().map(|one| event(one, &summary.told)).collect::<Vec<_>>(),
        "impacts": summary.impacts,
        "capture_steps": summary.capture_steps,
        "impacts_held_back": summary.held_back,
        "stopped_by": summary.stopped_by,
        "stages_pending": summary.pending.iter().map(|(name, _)| name).collect::<Vec<_>>(),
        "samples": summary.samples,
        "final": {
            "positions": by_hinge(model, position, true),
            "velocities": by_hinge(model, velocity, false),
            "bodies": poses(model, &summary.poses),
        },
        "beams": beams,
        "modal": modals::json(model, position, &summary.poses),
        "notes": unknown.into_iter().chain(text::doubt(model, summary)).chain(text::wound(summary)).chain(text::across(summary)).collect::<Vec<_>>(),
        "outputs": outputs(model, &summary.outputs),
        "wall_seconds": summary.wall.as_secs_f64(),
    })
}
