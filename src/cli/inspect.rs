//! `inspect`: what the model is, and its accelerations at the given state.

use super::inputs::Inputs;
use super::{Common, Exit, conditioning, json, output, scene, text};
use crate::constraint;
use crate::dynamics::{Evaluated, System};
use crate::element::modal::ModalMotion;
use crate::element::{Rod, RodMotion};
use crate::model::{ModalBody, Model};
use crate::simulate;
use anyhow::{Context, anyhow};
use clap::Args;
use nalgebra::Vector3;
use serde_json::json;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    structure: scene::Structure,
    /// Look at the pose, velocities and inputs of this file, as `statics --save` writes it
    #[arg(long, value_name = "START.toml")]
    start: Option<PathBuf>,
    /// Write the answer there as JSON
    #[arg(long, short = 'o', value_name = "PATH")]
    out: Option<PathBuf>,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let common = &arguments.common;
    let (scenario, model) = match scene::load_structure(common, &arguments.structure, arguments.start.as_deref())? {
        Ok(loaded) => loaded,
        Err(exit) => return Ok(exit),
    };
    let inputs = Inputs::of_scenario(common, &scenario, arguments.start.as_deref());
    arguments.out.iter().try_for_each(|out| inputs.spare(out))?;
    let (q, v) = (&model.start_position, &model.start_velocity);
    let begin = scenario.simulate.begin();
    let asked = simulate::outputs::at_start(&model, begin).with_context(|| scenario.name.clone())?;
    let mut system = System::new(&model);
    let mut accelerations = v.clone();
    let mut at = system.at(begin, q, v);
    at.accelerations_alone(&mut accelerations)
        .with_context(|| format!("{}: no accelerations at the given state", scenario.name))?;
    let forces: Vec<(String, f64)> =
        at.system().constraints().map_or(Vec::new(), |rows| rows.drive_forces(&model, &accelerations).collect());
    at.share_multipliers()?;
    let loops = at.loop_reactions();
    let motors: Vec<(String, f64)> = at.motor_forces().map(|(name, force)| (name.to_owned(), force)).collect();
    let energies = at.energies();
    let (_, assembly) = constraint::assemble(model.clone())
        .map_err(|problems| anyhow!("{}", problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")))?;
    let center = center_of_mass(&model, &at);
    let light = conditioning::ill_conditioned(&model);
    let left_out = left_out(&model);
    if !common.quiet {
        warn(&scenario.name, &light, &left_out);
    }
    if common.json || arguments.out.is_some() {
        // What a model calls its joints; hinges go by the names of bodies.
        let all = scenario.models.iter().flat_map(|taken| &taken.joints);
        let joints: serde_json::Map<_, _> = all.map(|(joint, body)| (joint.clone(), json!(body))).collect();
        let result = json!({
            "bodies": model.bodies.len(),
            "degrees_of_freedom": assembly.degrees_of_freedom,
            "loops": model.loops.len(),
            "redundant": json::redundant(&assembly.redundant),
            "gap": assembly.gap,
            "loop_reactions": json::loops(&model, &loops),
            "drives": json::pushes(&forces),
            "motors": json::pushes(&motors),
            "joints": joints,
            "total_mass": model.total_mass(),
            "center_of_mass": [center.x, center.y, center.z],
            "kinetic_energy": energies.kinetic,
            "potential_energy": energies.potential,
            "positions": json::by_hinge(&model, q, true),
            "velocities": json::by_hinge(&model, v, false),
            "ill_conditioned": light.iter().map(conditioning::Light::json).collect::<Vec<_>>(),
            "accelerations": json::by_hinge(&model, &accelerations, false),
            "left_out": left_out,
            "outputs": json::outputs(&model, &asked),
        });
        arguments.out.iter().try_for_each(|path| output::save(path, format!("{result:#}\n").as_bytes()))?;
        if common.json {
            output::print(&result.to_string())?;
        }
    }
    if common.json || common.quiet {
        return Ok(Exit::Done);
    }
    output::print(&text::heading(&model, &scenario.name))?;
    let along = |x: f64| text::number(text::without_noise(x, model.length_scale()));
    output::print(&format!(
        "  centre       {}, {}, {} m\n  energy       kinetic {} J, potential {} J\n",
        along(center.x),
        along(center.y),
        along(center.z),
        text::number(energies.kinetic),
        text::number(energies.potential)
    ))?;
    for line in text::couplings(&assembly) {
        output::print(&format!("  {line}"))?;
    }
    output::print(&table(&model, &accelerations))?;
    text::outputs(&model, &asked).map_or(Ok(()), |table| output::print(&table))?;
    Ok(Exit::Done)
}

fn warn(scene: &str, light: &[conditioning::Light], left_out: &[&str]) {
    conditioning::warn(scene, light);
    if !left_out.is_empty() {
        let what = left_out.join(" and ");
        output::warning(&format!(
            "{scene}: accelerations and outputs are those without {what}; the first sample of `run` has them with it"
        ));
    }
}

fn center_of_mass(model: &Model, at: &Evaluated<'_>) -> Vector3<f64> {
    let mut poses = Vec::new();
    at.poses(&mut poses);
    let moment: Vector3<f64> = model
        .bodies
        .iter()
        .zip(&poses)
        .map(|(body, pose)| body.mass.mass * (pose * nalgebra::Point3::from(body.mass.center)).coords)
        .sum();
    let slices = |(rod, at): (&Rod, &RodMotion)| {
        let inner = rod.slices.iter().zip(&at.stations).skip(1).take(rod.steps() - 1);
        inner.map(|(slice, station)| slice.mass * station.link.position).sum::<Vector3<f64>>()
    };
    let modal =
        |(body, here): (&ModalBody, &ModalMotion)| body.modal.mass * at.motion().links[body.link].position + here.first;
    let modals = model.modals.iter().zip(&at.motion().modals).map(modal).sum::<Vector3<f64>>();
    let moment = moment + modals + model.rods.iter().zip(&at.motion().rods).map(slices).sum::<Vector3<f64>>();
    moment / model.total_mass().max(f64::MIN_POSITIVE)
}

/// One line per hinge, in columns.
fn table(model: &Model, accelerations: &[f64]) -> String {
    let (length, gravity) = (model.length_scale(), model.gravity.norm());
    let fastest = model.start_velocity.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    // What cancels in an acceleration: others in the scene, gravity, and what fast turning needs.
    let usual = gravity.max(gravity / length).max(fastest * fastest);
    let largest = accelerations.iter().fold(usual, |m, a| m.max(a.abs()));
    // Numbers, each with the size beside which it is round-off.
    let show = |list: &[f64], scale: &dyn Fn(usize) -> f64| match list {
        [] => "–".to_owned(),
        _ => {
            let shown = |(at, x): (usize, &f64)| text::number(text::without_noise(*x, scale(at)));
            list.iter().enumerate().map(shown).collect::<Vec<_>>().join(" ")
        }
    };
    let mut rows = vec![["body", "hinge", "parent", "position", "velocity", "acceleration"].map(str::to_owned)];
    for body in model.bodies.iter().filter(|body| !body.is_inner) {
        let hinge = &body.hinge;
        let (positions, velocities) = hinge.kind.counts();
        let rates = hinge.velocity..hinge.velocity + velocities;
        let extent = |at: usize| if hinge.kind.positions()[at].1 == "m" { length } else { 1.0 };
        rows.push([
            body.name.clone(),
            hinge.kind.name().to_owned(),
            body.parent.map_or("ground", |parent| &model.bodies[parent].name).to_owned(),
            show(&model.start_position[hinge.position..hinge.position + positions], &extent),
            show(&model.start_velocity[rates.clone()], &|_| fastest),
            show(&accelerations[rates], &|_| largest),
        ]);
    }
    let widths: [usize; 6] = std::array::from_fn(|i| rows.iter().map(|row| row[i].chars().count()).max().unwrap_or(0));
    let line = |row: &[String; 6]| {
        let cells: Vec<String> = row.iter().zip(widths).map(|(cell, wide)| format!("{cell:<wide$}")).collect();
        format!("  {}", cells.join("  ")).trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// What acts in a run and not here.
fn left_out(model: &Model) -> Vec<&'static str> {
    let parts = [(!model.hinge_friction.is_empty(), "dry friction of hinges"), (!model.contacts.is_empty(), "contact")];
    parts.into_iter().filter(|(acts, _)| *acts).map(|(_, what)| what).collect()
}
