//! Poses that follow each other without a simulation: the iterates of a search, and mode shapes.

use super::{Common, json, run};
use crate::dynamics::System;
use crate::model::Model;
use crate::record::view::Sink;
use crate::record::{Energy, Fanout, Opening, Outcome, Recorder, Sample, Scene};
use crate::scenario::Scenario;
use crate::simulate;
use crate::statics::Equilibrium;
use anyhow::Context;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;

/// Seconds that one mode is shown, swings in that time, and frames per second.
const SHOWN: f64 = 2.0;
const SWINGS: f64 = 3.0;
const RATE: f64 = 50.0;
/// Most modes that are shown.
const MOST_MODES: usize = 12;
/// How far the coordinate that moves most swings: this many radians, or this part of the scene's length.
const AMPLITUDE: f64 = 0.25;

/// One pose at its time (s).
type Frame = (f64, Vec<f64>);

/// Writes frames into a recording, if one is asked for, and shows them in viewers.
fn film(
    common: &Common,
    scenario: &Scenario,
    model: &Arc<Model>,
    found: &Equilibrium,
    frames: &[Frame],
    outlets: (Option<&Path>, &[Sink]),
    summary: &Value,
) -> anyhow::Result<()> {
    // Poses alone: what would hold them is not known where nothing balances.
    let still = Scene { couplings: Vec::new(), outputs: Vec::new(), watched: false, ..simulate::scene(model) };
    let statics = json::statics(model, found, 0.0).to_string();
    let opening = Opening { scene: &still, scenario: &scenario.text, statics: Some(&statics) };
    let (file, sinks) = outlets;
    let mut recorder = Fanout::new();
    if let Some(path) = file {
        recorder =
            recorder.recorder(run::recording_file(path, common.quiet)?.with_ros(scenario.record.ros).begin(&opening)?);
    }
    for sink in sinks {
        recorder = run::add_viewer(recorder, sink, &opening, common.quiet)?;
    }
    let mut system = System::new(model);
    let rest = vec![0.0; model.velocity_count()];
    let (mut unbalanced, mut bodies, mut reactions) = (rest.clone(), Vec::new(), Vec::new());
    for (time, q) in frames {
        let mut at = system.at(0.0, q, &rest);
        let potential = at.energies().potential;
        let balanced = at.residual(&rest, &mut unbalanced).context("a pose that cannot be evaluated")?;
        balanced.reactions(&mut reactions);
        at.poses(&mut bodies);
        recorder.sample(&Sample {
            time: *time,
            positions: q,
            velocities: &rest,
            accelerations: &rest,
            bodies: &bodies,
            reactions: &reactions,
            couplings: &[],
            outputs: &[],
            energy: Energy { potential, ..Energy::default() },
        })?;
    }
    recorder.finish(&Outcome { summary: summary.to_string() })?;
    for lost in recorder.take_lost() {
        super::output::warning(&format!("{lost}\nthe result is not affected"));
    }
    Ok(())
}

/// The way of a search, one pose per second.
pub(super) fn iterates(
    common: &Common,
    scenario: &Scenario,
    model: &Arc<Model>,
    found: &Equilibrium,
    trail: Vec<Vec<f64>>,
    outlets: (Option<&Path>, &[Sink]),
) -> anyhow::Result<usize> {
    let last = trail.last().is_none_or(|last| *last != found.position).then(|| found.position.clone());
    let frames: Vec<Frame> = trail.into_iter().chain(last).enumerate().map(|(i, q)| (i as f64, q)).collect();
    let summary = json!({ "iterates": frames.len() });
    film(common, scenario, model, found, &frames, outlets, &summary)?;
    Ok(frames.len())
}

/// The mode shapes, one after the other, as many as are shown.
pub(super) fn modes(
    common: &Common,
    scenario: &Scenario,
    model: &Arc<Model>,
    found: &Equilibrium,
    path: &Path,
) -> anyhow::Result<usize> {
    let modes = found.stability.as_ref().map_or(&[][..], |stability| &stability.modes);
    let shown = modes.len().min(MOST_MODES);
    let free: Vec<usize> = (0..model.velocity_count()).filter(|i| !model.coordinates[*i].lock).collect();
    let length = model.length_scale();
    let mut unit = vec![1.0; model.velocity_count()];
    for link in model.links.iter().filter(|link| link.joint.is_slide()) {
        unit[link.velocity] = length;
    }
    let frames_each = (SHOWN * RATE) as usize;
    let (mut frames, mut told) = (Vec::new(), Vec::new());
    for (index, mode) in modes.iter().take(shown).enumerate() {
        let largest = free.iter().zip(&mode.shape).map(|(i, x)| (x / unit[*i]).abs()).fold(0.0, f64::max);
        let start = SHOWN * index as f64;
        told.push(json!({ "from": start, "to": start + SHOWN, "frequency_hz": mode.frequency_hz, "growth_rate": mode.growth_rate }));
        for frame in 0..frames_each {
            let part = frame as f64 / frames_each as f64;
            let swing = AMPLITUDE / largest * (SWINGS * std::f64::consts::TAU * part).sin();
            let mut step = vec![0.0; model.velocity_count()];
            free.iter().zip(&mode.shape).for_each(|(i, x)| step[*i] = swing * x);
            let mut q = found.position.clone();
            System::displace(model, &mut q, &step);
            frames.push((start + SHOWN * part, q));
        }
    }
    let summary = json!({ "modes": told });
    film(common, scenario, model, found, &frames, (Some(path), &[]), &summary)?;
    Ok(shown)
}
