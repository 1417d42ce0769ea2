//! `rest`: prove that a run from the equilibrium stays there.

use super::inputs::Inputs;
use super::output::{Interrupt, Progress};
use super::{Common, Exit, output, recording, scene, statics, statics_answer, text};
use crate::model::Model;
use crate::record::{Fanout, Opening, Outcome, Recorder};
use crate::simulate::rest::{Disturbance, Largest, Rest, TOLERANCE, rest};
use crate::simulate::{self, RunError};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    structure: scene::Structure,
    /// Prove it for the pose and inputs of this file, as `statics --save` writes it
    #[arg(long, value_name = "START.toml")]
    start: Option<PathBuf>,
    /// Record the proof there
    #[arg(long, short = 'o', value_name = "PATH")]
    out: Option<PathBuf>,
    /// Print all of the equilibrium, as `statics` does, not one line of it
    #[arg(long, short)]
    verbose: bool,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let common = &arguments.common;
    let (mut scenario, mut model) =
        match scene::load_structure(common, &arguments.structure, arguments.start.as_deref())? {
            Ok(loaded) => loaded,
            Err(exit) => return Ok(exit),
        };
    if arguments.start.is_some() && model.start_velocity.iter().any(|v| *v != 0.0) {
        anyhow::bail!("the start file gives velocities that are not zero: what moves is not at rest");
    }
    let interrupt = Interrupt::install()?;
    let inputs = Inputs::of_scenario(common, &scenario, arguments.start.as_deref());
    arguments.out.iter().try_for_each(|out| inputs.spare(out))?;
    let file = arguments.out.as_deref().map(|out| recording::recording_file(out, common.quiet)).transpose()?;
    let (found, wall) = statics::find(&mut scenario, &mut model)?;
    let statics = statics_answer(&model, &found, wall.as_secs_f64());
    if !common.json && !common.quiet {
        output::announce(&text::heading(&model, &scenario.name));
        output::announce(&text::equilibrium(&model, &found, &scenario.unknown, wall, arguments.verbose));
    }
    if !found.balanced {
        if common.json {
            let none = Value::Null;
            output::print(&json!({ "rested": false, "duration": 0.0, "max_displacement": none, "max_speed": none, "tolerance": TOLERANCE, "statics": statics }).to_string())?;
        }
        return Ok(Exit::No);
    }
    let model = model.before_stages();
    let still = simulate::scene(&model);
    let statics_text = statics.to_string();
    let opening = Opening { scene: &still, scenario: &scenario.text, statics: Some(&statics_text) };
    let mut recorder = Fanout::new();
    if let Some(file) = file {
        recorder = recorder.recorder(file.begin(&opening)?);
    }
    let outcome = {
        let mut progress = Progress::new(scenario.simulate.duration, common.quiet || common.json);
        let mut go_on = |time: f64| {
            progress.at(time);
            !interrupt.requested()
        };
        rest(&model, &found, &scenario.simulate, scenario.record.rate, &mut recorder, &mut go_on)
    };
    let proof = match outcome {
        Ok(proof) => proof,
        Err(RunError::Record(error)) => return Err(error.into()),
        Err(error) => {
            output::error(&anyhow::Error::new(error));
            return Ok(Exit::No);
        }
    };
    let result = to_json(&proof, statics);
    if let Some(out) = arguments.out.as_deref().filter(|_| proof.interrupted) {
        recording::keep_complete(out, common.quiet)?;
    }
    recorder.finish(&Outcome { summary: result.to_string() })?;
    if common.json {
        output::print(&result.to_string())?;
    } else if !common.quiet {
        let moves = found.velocity.iter().any(|v| *v != 0.0);
        output::print(&to_text(&model, &proof, moves))?;
    }
    Ok(match (proof.interrupted, proof.rested) {
        (true, _) => Exit::Interrupted,
        (false, true) => Exit::Done,
        (false, false) => Exit::No,
    })
}

fn to_json(proof: &Rest, statics: Value) -> Value {
    let largest = |l: &Largest| json!({ "hinge": l.hinge, "value": l.value });
    json!({
        "rested": proof.rested,
        "duration": proof.duration,
        "max_displacement": largest(&proof.displacement),
        "max_speed": largest(&proof.speed),
        "tolerance": TOLERANCE,
        "growth": proof.growth.as_ref().map(|g| json!({ "hinge": g.hinge, "predicted": g.predicted, "observed": g.observed })),
        "disturbed_by": proof.disturbed.as_ref().map(|one| json!({ one.by: one.name, "time": one.time })),
        "statics": statics,
    })
}

/// A displacement, or with `per` a speed, in the unit of its hinge; without one if the hinge has coordinates of several.
fn of_hinge(model: &Model, largest: &Largest, per: &str) -> String {
    let body = model.bodies.iter().find(|body| body.name == largest.hinge);
    let mut units: Vec<&str> =
        body.map_or(&[][..], |body| body.hinge.kind.velocities()).iter().map(|(_, unit)| *unit).collect();
    units.dedup();
    let value = text::small(largest.value);
    match units[..] {
        [unit] => format!("{value} {}{per}", unit.trim_end_matches("/s")),
        _ => format!("{value}{}", if per.is_empty() { "" } else { " per second" }),
    }
}

/// `moves`: the equilibrium is a steady motion.
fn to_text(model: &Model, proof: &Rest, moves: bool) -> String {
    let steady = if moves { ", beside the steady motion" } else { "" };
    let seconds = text::number(proof.duration);
    let Some(growth) = &proof.growth else {
        let answer = if proof.rested { "at rest" } else { "not at rest" };
        let until = match &proof.disturbed {
            Some(Disturbance { by, name, time }) if *time > 0.0 => format!(", until the {by} `{name}` changes,"),
            Some(Disturbance { by, name, .. }) => format!(", in which the {by} `{name}` changes,"),
            None => String::new(),
        };
        return format!(
            "{}: in {seconds} s{until} no hinge moved further than {} (`{}`; allowed {TOLERANCE:.0e}) or faster than {} (`{}`){steady}",
            output::verdict(answer, proof.rested),
            of_hinge(model, &proof.displacement, ""),
            proof.displacement.hinge,
            of_hinge(model, &proof.speed, "/s"),
            proof.speed.hinge,
        );
    };
    let observed = growth.observed.map_or("not seen in time".to_owned(), text::number);
    format!(
        "{}: pushed by a millionth, `{}` leaves; growth {observed} per second, predicted {}",
        output::verdict("not at rest", false),
        growth.hinge,
        text::number(growth.predicted)
    )
}
