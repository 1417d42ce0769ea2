//! Poses that follow each other without a simulation: the iterates of a search, mode shapes, and how a scene gives way.

use super::{Common, json, recording};
use crate::dynamics::System;
use crate::model::Model;
use crate::record::gltf::Clip;
use crate::record::view::Sink;
use crate::record::{Energy, Fanout, Opening, Outcome, Recorder, Sample, Scene, Tubes, mode_name};
use crate::scenario::Scenario;
use crate::simulate;
use crate::statics::{Equilibrium, NaturalMode};
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
        recorder = recorder
            .recorder(recording::recording_file(path, common.quiet)?.with_ros(scenario.record.ros).begin(&opening)?);
    }
    for sink in sinks {
        recorder = recording::add_viewer(recorder, sink, &opening, common.quiet)?;
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
    let (mut frames, mut told) = (Vec::new(), Vec::new());
    for (index, mode) in shown(found).iter().enumerate() {
        let start = SHOWN * index as f64;
        told.push(json!({ "from": start, "to": start + SHOWN, "frequency_hz": mode.frequency_hz, "growth_rate": mode.growth_rate }));
        frames.extend(swing(model, found, mode).into_iter().map(|(time, q)| (start + time, q)));
    }
    let shown = told.len();
    let summary = json!({ "modes": told });
    film(common, scenario, model, found, &frames, (Some(path), &[]), &summary)?;
    Ok(shown)
}

/// The modes that are shown.
fn shown(found: &Equilibrium) -> &[NaturalMode] {
    let modes = found.stability.as_ref().map_or(&[][..], |stability| &stability.modes);
    &modes[..modes.len().min(MOST_MODES)]
}

/// How a scene gives way: from rest, ever faster, as far as a mode swings. Returns what happens, in words; `None` if nothing gives way.
pub(super) fn collapse(
    common: &Common,
    scenario: &Scenario,
    model: &Arc<Model>,
    found: &Equilibrium,
    path: &Path,
) -> anyhow::Result<Option<String>> {
    let mechanism = found.standing.as_ref().and_then(|standing| standing.mechanism.as_ref());
    let Some(mechanism) = mechanism.filter(|mechanism| mechanism.motion.iter().any(|rate| *rate != 0.0)) else {
        return Ok(None);
    };
    let unit = units(model);
    let largest = mechanism.motion.iter().zip(&unit).map(|(rate, unit)| (rate / unit).abs()).fold(0.0, f64::max);
    let frames = (SHOWN * RATE) as usize;
    let frame = |frame: usize| {
        let part = frame as f64 / frames as f64;
        let far = AMPLITUDE / largest * part * part;
        let step: Vec<f64> = mechanism.motion.iter().map(|rate| far * rate).collect();
        let mut q = found.position.clone();
        System::displace(model, &mut q, &step);
        (SHOWN * part, q)
    };
    let frames: Vec<Frame> = (0..=frames).map(frame).collect();
    let said = mechanism.to_string();
    film(common, scenario, model, found, &frames, (Some(path), &[]), &json!({ "collapse": said }))?;
    Ok(Some(said))
}

/// What a velocity coordinate is compared with: 1 rad, or the scene's length (m).
fn units(model: &Model) -> Vec<f64> {
    let mut unit = vec![1.0; model.velocity_count()];
    for link in model.links.iter().filter(|link| link.joint.is_distance()) {
        unit[link.velocity] = model.length_scale();
    }
    unit
}

/// A mode as it swings about the equilibrium, from time zero.
fn swing(model: &Model, found: &Equilibrium, mode: &NaturalMode) -> Vec<Frame> {
    let free: Vec<usize> = (0..model.velocity_count()).filter(|i| !model.coordinates[*i].lock).collect();
    let unit = units(model);
    let largest = free.iter().zip(&mode.shape).map(|(i, x)| (x / unit[*i]).abs()).fold(0.0, f64::max);
    let frames = (SHOWN * RATE) as usize;
    let frame = |frame: usize| {
        let part = frame as f64 / frames as f64;
        let swing = AMPLITUDE / largest * (SWINGS * std::f64::consts::TAU * part).sin();
        let mut step = vec![0.0; model.velocity_count()];
        free.iter().zip(&mode.shape).for_each(|(i, x)| step[*i] = swing * x);
        let mut q = found.position.clone();
        System::displace(model, &mut q, &step);
        (SHOWN * part, q)
    };
    (0..frames).map(frame).collect()
}

/// The modes as motions.
pub(super) fn mode_clips(model: &Arc<Model>, found: &Equilibrium) -> Vec<Clip> {
    let mut system = System::new(model);
    let rest = vec![0.0; model.velocity_count()];
    let tubes = Tubes::new(&simulate::scene(model));
    let mut clip = |(index, mode): (usize, &NaturalMode)| {
        let mut clip = Clip { name: mode_name(index, mode.frequency_hz, mode.growth_rate), ..Clip::default() };
        for (time, q) in swing(model, found, mode) {
            let mut poses = Vec::new();
            system.at(0.0, &q, &rest).poses(&mut poses);
            tubes.extend(&q, &mut poses);
            clip.times.push(time);
            clip.poses.push(poses);
        }
        clip
    };
    shown(found).iter().enumerate().map(&mut clip).collect()
}
