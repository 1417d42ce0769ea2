//! `inspect`: what the model is, and its accelerations at the given state.

use super::{Common, Exit, json, output, scene, text};
use crate::dynamics::System;
use crate::model::Model;
use anyhow::Context;
use clap::Args;
use nalgebra::Vector3;
use serde_json::json;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let common = &arguments.common;
    let (scenario, model) = match scene::load(common)? {
        Ok(loaded) => loaded,
        Err(exit) => return Ok(exit),
    };
    let (q, v) = (&model.start_position, &model.start_velocity);
    let mut system = System::new(&model);
    let mut accelerations = v.clone();
    system
        .accelerations(q, v, &mut accelerations)
        .with_context(|| format!("{}: no accelerations at the given state", scenario.name))?;
    let energies = system.energies(q, v);
    let center = center_of_mass(&model, &system);
    if common.json {
        let result = json!({
            "bodies": model.bodies.len(),
            "degrees_of_freedom": model.velocity_count(),
            "loops": 0,
            "total_mass": model.total_mass(),
            "center_of_mass": [center.x, center.y, center.z],
            "kinetic_energy": energies.kinetic,
            "potential_energy": energies.potential,
            "positions": json::by_hinge(&model, q, true),
            "velocities": json::by_hinge(&model, v, false),
            "accelerations": json::by_hinge(&model, &accelerations, false),
        });
        output::print(&result.to_string());
        return Ok(Exit::Done);
    }
    output::print(&text::heading(&model, &scenario.name));
    output::print(&format!(
        "  centre       {}, {}, {} m\n  energy       kinetic {} J, potential {} J\n",
        text::number(center.x),
        text::number(center.y),
        text::number(center.z),
        text::number(energies.kinetic),
        text::number(energies.potential)
    ));
    output::print(&table(&model, &accelerations));
    Ok(Exit::Done)
}

fn center_of_mass(model: &Model, system: &System<'_>) -> Vector3<f64> {
    let mut poses = Vec::new();
    system.poses(&mut poses);
    let moment: Vector3<f64> = model
        .bodies
        .iter()
        .zip(&poses)
        .map(|(body, pose)| body.mass.mass * (pose * nalgebra::Point3::from(body.mass.center)).coords)
        .sum();
    moment / model.total_mass().max(f64::MIN_POSITIVE)
}

/// One line per hinge.
fn table(model: &Model, accelerations: &[f64]) -> String {
    let wide = model.bodies.iter().map(|body| body.name.chars().count()).max().unwrap_or(0).max(4);
    let mut lines =
        vec![format!("  {:<wide$}  {:<11}  {:<wide$}  position | velocity | acceleration", "body", "hinge", "parent")];
    for body in &model.bodies {
        let hinge = &body.hinge;
        let (positions, velocities) = hinge.kind.counts();
        let parent = body.parent.map_or("ground", |parent| model.bodies[parent].name.as_str());
        let show = |list: &[f64]| list.iter().map(|x| text::number(*x)).collect::<Vec<_>>().join(" ");
        let state = match velocities {
            0 => "–".to_owned(),
            _ => format!(
                "{} | {} | {}",
                show(&model.start_position[hinge.position..hinge.position + positions]),
                show(&model.start_velocity[hinge.velocity..hinge.velocity + velocities]),
                show(&accelerations[hinge.velocity..hinge.velocity + velocities])
            ),
        };
        lines.push(format!("  {:<wide$}  {:<11}  {parent:<wide$}  {state}", body.name, hinge.kind.name()));
    }
    lines.join("\n")
}
