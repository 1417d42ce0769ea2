//! `linearize`: the equations about the equilibrium, or about a start.

mod bode;
mod files;
mod response;

use super::inputs::Inputs;
use super::number::in_unit;
use super::palette::Theme;
use super::{Common, Exit, json, output, pixels, scene, statics, text};
use crate::linear::{self, Input, Mat, Place, Signal, StateSpace};
use crate::model::motor::MotorLawDescription;
use crate::model::{Description, Model, StopLaw};
use crate::simulate::State;
use crate::statics::{Equilibrium, idle_stops};
use anyhow::{Context, anyhow, bail};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    structure: scene::Structure,
    /// What pushes: a motor, a drive (by the acceleration of its target), by name or by place as `drive[0]`, `crank.force` of a
    /// hinge or `push.force[0]` of a load; may be repeated. Default: all motors of type `input`
    #[arg(long, value_name = "ADDRESS")]
    input: Vec<String>,
    /// What is observed: an `[[output]]` of the scenario; may be repeated. Default: all
    #[arg(long, value_name = "NAME")]
    output: Vec<String>,
    /// About the state of this file, as it stands, in place of the equilibrium
    #[arg(long, value_name = "START.toml")]
    start: Option<PathBuf>,
    /// Write the matrices there
    #[arg(long, short = 'o', value_name = "FILE.json|npz|mat")]
    out: Option<PathBuf>,
    /// Plot the frequency response from every input to every output there
    #[arg(long, value_name = "FILE.svg|png|pdf")]
    bode: Option<PathBuf>,
    /// Paper and ink of that plot
    #[arg(long, value_enum, value_name = "THEME", default_value_t, requires = "bode")]
    theme: Theme,
    /// Also the equations from step to step (s), inputs held constant over each
    #[arg(long, value_name = "STEP", value_parser = step, allow_negative_numbers = true)]
    discretize: Option<f64>,
    /// Also how much outputs swing at these frequencies (Hz), and by how much later: by one of each input, of drives by how far they move
    #[arg(long, value_name = "HZ", value_parser = frequency, value_delimiter = ',', allow_negative_numbers = true)]
    response: Vec<f64>,
}

fn frequency(text: &str) -> Result<f64, String> {
    match in_unit(text, "Hz")? {
        number if number >= 0.0 && number.is_finite() => Ok(number),
        _ => Err("a frequency in Hz is wanted, at least 0".to_owned()),
    }
}

fn step(text: &str) -> Result<f64, String> {
    match in_unit(text, "s")? {
        number if number > 0.0 && number.is_finite() => Ok(number),
        _ => Err("a number > 0 is wanted".to_owned()),
    }
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let common = &arguments.common;
    let (mut scenario, mut model) =
        match scene::load_structure(common, &arguments.structure, arguments.start.as_deref())? {
            Ok(loaded) => loaded,
            Err(exit) => return Ok(exit),
        };
    let read = Inputs::of_scenario(common, &scenario, arguments.start.as_deref());
    arguments.out.iter().chain(&arguments.bode).try_for_each(|written| read.spare(written))?;
    let format = arguments.out.as_deref().map(files::Format::of).transpose()?;
    let (place, idle) = match arguments.start {
        Some(_) => {
            let (position, velocity) = (model.start_position.clone(), model.start_velocity.clone());
            (of_state(scenario.simulate.begin(), State { position, velocity }), Vec::new())
        }
        None => {
            let (found, _) = statics::find(&mut scenario, &mut model)?;
            if !found.converged {
                let why = found.notes.first().map_or(String::new(), |note| format!(": {note}"));
                output::error(&anyhow!("{}: there is no equilibrium to linearize about{why}", scenario.name));
                return Ok(Exit::No);
            }
            (of_equilibrium(&model, &found), idle_stops(&model, &found))
        }
    };
    let [input, output] = [&arguments.input, &arguments.output].map(|names| (!names.is_empty()).then_some(&names[..]));
    let found = about(&scenario.description, &model, (&place, &idle), (input, of_option), output)
        .with_context(|| scenario.name.clone())?;
    if !common.quiet {
        found.notes.iter().for_each(|note| output::note(note));
    }
    // What cannot be drawn is refused before anything is written.
    let title = if model.title.is_empty() { &scenario.name } else { &model.title };
    let picture = |path| pixels::by_name(path)?(bode::draw(&found, title, arguments.theme)?);
    let picture = arguments.bode.as_deref().map(picture).transpose()?;
    let mut answer = answer(&model, &place, &found, arguments.discretize)
        .with_context(|| format!("{}: `--discretize`", scenario.name))?;
    let swings = response::swings(&found, &arguments.response);
    if !swings.is_empty() {
        answer["response"] = response::json(&swings);
    } else if !arguments.response.is_empty() {
        bail!("{}: `--response` is from an input to an output, and there is none", scenario.name);
    }
    if let Some((path, format)) = arguments.out.as_deref().zip(format) {
        output::save(path, &format.bytes(&found, arguments.discretize, &answer)?)?;
    }
    if let Some((path, picture)) = arguments.bode.as_deref().zip(picture) {
        output::save(path, &picture)?;
    }
    if common.json {
        output::print(&answer.to_string())?;
    } else if !common.quiet {
        output::print(&(report(&model, &scenario.name, &found) + &response::lines(&swings)))?;
    }
    Ok(Exit::Done)
}

/// The equations about an equilibrium, from inputs (`None`: all motors of type `input`) to outputs (`None`: all).
///
/// # Errors
/// An input or output that is not known, or a scene that cannot be linearized.
pub(super) fn about_equilibrium(
    description: &Description,
    model: &Arc<Model>,
    found: &Equilibrium,
    input: Option<&[String]>,
    output: Option<&[String]>,
) -> anyhow::Result<StateSpace> {
    about(description, model, (&of_equilibrium(model, found), &idle_stops(model, found)), (input, of_argument), output)
}

/// These equations about a state as it stands, at a time (s).
///
/// # Errors
/// As [`about_equilibrium`].
pub(super) fn about_state(
    description: &Description,
    model: &Arc<Model>,
    (time, state): (f64, State),
    input: Option<&[String]>,
    output: Option<&[String]>,
) -> anyhow::Result<StateSpace> {
    about(description, model, (&of_state(time, state), &[]), (input, of_argument), output)
}

fn of_state(time: f64, State { position, velocity }: State) -> Place {
    Place { time, position, velocity, multipliers: None, held: Vec::new(), pressed: Vec::new() }
}

/// Where the name of an input comes from, in words.
type InputLabel = fn(&str) -> String;

/// On the command line.
fn of_option(name: &str) -> String {
    format!("`--input {name}`")
}

/// In an argument of a function.
fn of_argument(_: &str) -> String {
    "`inputs`".to_owned()
}

/// The equations about a place, at which stops of these hinges touch and bear next to nothing.
fn about(
    description: &Description,
    model: &Arc<Model>,
    (place, idle): (&Place, &[String]),
    (input, label): (Option<&[String]>, InputLabel),
    output: Option<&[String]>,
) -> anyhow::Result<StateSpace> {
    for name in output.unwrap_or_default() {
        if !model.outputs.iter().any(|output| output.name == *name) {
            let known = model.outputs.iter().map(|output| output.name.as_str());
            let near = crate::suggest::closest(name, known).map(|near| format!("; did you mean `{near}`?"));
            bail!("the scenario has no output `{name}`{}", near.unwrap_or_default());
        }
    }
    let mut found = linear::linearize(model, place, &inputs((input, label), description, model)?, output)?;
    if let Some(name) = found.idle.first().filter(|_| input.is_some()) {
        bail!(
            "nothing feels the input `{name}`: at this place it pushes what is locked, held by a stop or a drive, or across all \
             motions that there are"
        );
    }
    let mut notes = Vec::new();
    if !found.idle.is_empty() {
        notes.push(format!("nothing feels the inputs `{}` at this place", found.idle.join("`, `")));
    }
    for hinge in idle {
        notes.push(format!(
            "the stop of {hinge} touches and bears next to nothing: the equations are those of one side"
        ));
    }
    if !(model.hinge_friction.is_empty() && model.contacts.is_empty()) {
        notes.push(
            "dry friction and contact are left out of the equations: they are those of the smooth scene".to_owned(),
        );
    }
    if !model.controllers.is_empty() {
        notes.push("controllers are left out of the equations: they are those from the inputs".to_owned());
    }
    found.notes.extend(notes);
    Ok(found)
}

/// What is held and what gives way at an equilibrium.
fn of_equilibrium(model: &Model, found: &Equilibrium) -> Place {
    let mut held: Vec<usize> = (0..model.velocity_count()).filter(|at| model.coordinates[*at].lock).collect();
    let mut pressed = Vec::new();
    for bearing in &found.stops {
        let is_it = |stop: &&crate::model::Stop| {
            model.label(stop.velocity) == bearing.hinge && stop.limit(bearing.side) == bearing.limit
        };
        let Some(index) = model.stops.iter().position(|stop| is_it(&stop)) else { continue };
        match model.stops[index].law {
            StopLaw::Rigid { .. } => held.push(model.stops[index].velocity),
            StopLaw::Compliant { .. } => pressed.push(index),
        }
    }
    held.sort_unstable();
    held.dedup();
    Place {
        time: 0.0,
        position: found.position.clone(),
        velocity: found.velocity.clone(),
        multipliers: Some(found.multipliers.clone()),
        held,
        pressed,
    }
}

fn inputs(
    (named, label): (Option<&[String]>, InputLabel),
    description: &Description,
    model: &Model,
) -> anyhow::Result<Vec<Input>> {
    let motors = description.motors.iter().filter(|motor| matches!(motor.law, MotorLawDescription::Input { .. }));
    let own: Vec<String> = motors.map(|motor| motor.name.clone()).collect();
    let names = named.unwrap_or(&own);
    let mut all: Vec<Input> = Vec::new();
    for name in names {
        let found = Input::find(description, model, name).map_err(|unfit| {
            let help = unfit.help.map_or(String::new(), |help| format!("\nhint: {help}"));
            anyhow!("{}: {}{help}", label(name), unfit.message)
        })?;
        for input in found {
            if all.contains(&input) {
                bail!("{}: `{}` is an input already", label(name), input.name());
            }
            all.push(input);
        }
    }
    Ok(all)
}

/// The rows of a matrix.
fn rows(matrix: &Mat<f64>) -> Vec<Vec<f64>> {
    (0..matrix.nrows()).map(|i| (0..matrix.ncols()).map(|j| matrix[(i, j)]).collect()).collect()
}

fn names(signals: &[Signal]) -> Vec<&str> {
    signals.iter().map(|signal| signal.name.as_str()).collect()
}

fn answer(model: &Model, place: &Place, found: &StateSpace, step: Option<f64>) -> Result<Value, linear::Overflow> {
    let units = |signals: &[Signal]| signals.iter().map(|signal| signal.unit.clone()).collect::<Vec<_>>();
    let mut value = json!({
        "A": rows(&found.a), "B": rows(&found.b), "C": rows(&found.c), "D": rows(&found.d),
        "states": names(&found.states), "inputs": names(&found.inputs), "outputs": names(&found.outputs),
        "units": {
            "states": units(&found.states), "inputs": units(&found.inputs), "outputs": units(&found.outputs),
        },
        "eigenvalues": found.eigenvalues(),
        "dependent": found.dependent,
        "left_out": found.left_out,
        "notes": found.notes,
        "about": {
            "equilibrium": place.multipliers.is_some(),
            "time": place.time,
            "positions": json::by_hinge(model, &place.position, true),
            "velocities": json::by_hinge(model, &place.velocity, false),
        },
    });
    if let Some(step) = step {
        let (a, b) = found.hold(step)?;
        value["discrete"] = json!({ "step": step, "A": rows(&a), "B": rows(&b) });
    }
    Ok(value)
}

/// Eigenvalues that are printed; `--json` has all.
const MOST_LINES: usize = 12;

fn report(model: &Model, name: &str, found: &StateSpace) -> String {
    let list = |signals: &[Signal]| match signals {
        [] => "none".to_owned(),
        _ => names(signals).join(", "),
    };
    let mut out = text::heading(model, name);
    out += &format!(
        "\n  states       {}\n  inputs       {}\n  outputs      {}",
        list(&found.states),
        list(&found.inputs),
        list(&found.outputs)
    );
    if !found.dependent.is_empty() {
        out += &format!("\n  follow       {}", found.dependent.join(", "));
    }
    let all = found.eigenvalues();
    // Computed eigenvalues are those of a matrix that is wrong by round-off.
    let round_off = found.a.nrows() as f64 * f64::EPSILON * found.a.norm_l2();
    let told = || all.iter().take(MOST_LINES);
    let part = |of: f64| if of.abs() <= round_off { 0.0 } else { of };
    let [real, imaginary] =
        [0, 1].map(|k| text::aligned(told().map(|value| if k == 0 { part(value[0]) } else { part(value[1]).abs() })));
    for (line, ((value, re), im)) in told().zip(real).zip(imaginary).enumerate() {
        let head = if line == 0 { "eigenvalues" } else { "" };
        let sign = if value[1] < 0.0 { '-' } else { '+' };
        out += &format!("\n  {head:<12} {re} {sign} {im}i 1/s");
    }
    if all.len() > MOST_LINES {
        out += &format!("\n  {:<12} … and {} more (--json has all)", "", all.len() - MOST_LINES);
    }
    out
}
