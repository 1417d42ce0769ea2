//! `watch`: the equilibrium, or the run, again whenever a file of the scene is saved.

use super::inputs::Inputs;
use super::output::Interrupt;
use super::recording::Viewers;
use super::report::material::Material;
use super::report::{self, words};
use super::text::{number, size, without_noise};
use super::{Common, Exit, output};
use crate::record::scene::Channel;
use anyhow::bail;
use clap::Args;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::Duration;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The scenario file, or that of a model (URDF, MJCF) alone
    scenario: PathBuf,
    /// Change a value of the file, as `upper.stiffness=5`; may be repeated
    #[arg(long = "set", value_name = "PATH=VALUE")]
    set: Vec<String>,
    /// Simulate each time, too
    #[arg(long)]
    run: bool,
    /// Write a report each time: a page to be loaded again in a browser
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    viewers: Viewers,
    /// End after this many times
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    times: Option<u64>,
    /// Print errors and changes only
    #[arg(long, short)]
    quiet: bool,
}

/// How often the files are looked at.
const PERIOD: Duration = Duration::from_millis(100);
/// A change of less than this part is none.
const SAME: f64 = 1e-9;
/// Changes of one kind that are told.
const MOST_LINES: usize = 12;

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    if arguments.scenario.as_os_str() == "-" {
        bail!("standard input cannot be watched: name a file");
    }
    let common =
        Common { scenario: arguments.scenario.clone(), set: arguments.set.clone(), json: true, quiet: arguments.quiet };
    let mut before: Option<Material> = None;
    let mut left = arguments.times;
    loop {
        refuse_pipe(&arguments.scenario)?;
        // Files that are saved while this goes on are seen afterwards.
        let alone = Inputs::new([arguments.scenario.as_path()]);
        let mut inputs = before.as_ref().map_or(&alone, |material| &material.inputs);
        let mut stamps = inputs.stamps();
        let exit = match Material::of_scenario(&common, !arguments.run, false) {
            Ok(Ok(material)) => {
                tell(&material, before.as_ref())?;
                material.show(&arguments.viewers.sinks(), arguments.quiet)?;
                if let Some(file) = &arguments.report {
                    report::write(&material, file)?;
                }
                let exit = material.exit;
                before = Some(material);
                inputs = before.as_ref().map_or(&alone, |material| &material.inputs);
                if inputs.stamps().len() != stamps.len() {
                    stamps = inputs.stamps();
                }
                exit
            }
            Ok(Err(exit)) => exit,
            Err(error) => {
                output::error(&error);
                Exit::Wrong
            }
        };
        left = left.map(|left| left - 1);
        if left == Some(0) {
            return Ok(exit);
        }
        if !arguments.quiet {
            output::note(&format!("watching `{}`; Ctrl-C ends it", arguments.scenario.display()));
        }
        let interrupt = Interrupt::install()?;
        while inputs.stamps() == stamps {
            if interrupt.requested() {
                return Ok(Exit::Done);
            }
            sleep(PERIOD);
        }
    }
}

/// A pipe or a device has no time of its last change, and may be waited for without end.
fn refuse_pipe(scenario: &Path) -> anyhow::Result<()> {
    match std::fs::metadata(scenario) {
        Ok(about) if !about.is_file() && !about.is_dir() => {
            bail!("`{}` cannot be watched: it is a device or a pipe", scenario.display())
        }
        _ => Ok(()),
    }
}

/// The verdict, and what differs from the time before.
fn tell(now: &Material, before: Option<&Material>) -> anyhow::Result<()> {
    let words::Headline { text, fine } = words::verdict(now);
    output::print(&output::verdict(&text, fine))?;
    let Some(before) = before else { return frequencies(now) };
    let changes = [poses(now, before), modes(now, before)];
    let mut any = false;
    for list in changes {
        for line in list.iter().take(MOST_LINES) {
            output::print(line)?;
        }
        if list.len() > MOST_LINES {
            output::print(&format!("  {:<12} … and {} more", "", list.len() - MOST_LINES))?;
        }
        any |= !list.is_empty();
    }
    if !any {
        output::print("  no change of pose or frequencies")?;
    }
    Ok(())
}

fn frequencies(now: &Material) -> anyhow::Result<()> {
    let list: Vec<String> = hertz(&now.statics).into_iter().take(MOST_LINES).map(number).collect();
    if list.is_empty() { Ok(()) } else { output::print(&format!("  frequencies  {} Hz", list.join(", "))) }
}

fn hertz(statics: &Value) -> Vec<f64> {
    statics["frequencies_hz"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect()
}

/// Coordinates that changed, appeared or went.
fn poses(now: &Material, before: &Material) -> Vec<String> {
    let coordinates = |material: &Material| -> Vec<(String, f64)> {
        let length = material.scene.extent.map_or(0.0, |extent| extent.length);
        let hinges = material.statics["positions"].as_object().into_iter().flatten();
        let of_hinge = |(body, values): (&String, &Value)| {
            let channels = material.scene.positions.iter().filter(|channel| channel.body == *body);
            let values: Vec<f64> = values.as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
            let clean = |channel: &Channel, x: f64| without_noise(x, size(&channel.unit, length, 0.0));
            let named = |(channel, x): (&Channel, f64)| (format!("{body}.{}", channel.name), clean(channel, x));
            channels.zip(values).map(named).collect::<Vec<_>>()
        };
        hinges.flat_map(of_hinge).collect()
    };
    let (old, new) = (coordinates(before), coordinates(now));
    differences("pose", &old, &new, |a, b| format!("{} → {} ({})", number(a), number(b), signed(b - a)))
}

/// A change, with its sign.
fn signed(change: f64) -> String {
    format!("{}{}", if change > 0.0 { "+" } else { "" }, number(change))
}

fn modes(now: &Material, before: &Material) -> Vec<String> {
    let named = |material: &Material| -> Vec<(String, f64)> {
        let list = hertz(&material.statics);
        list.into_iter().enumerate().map(|(k, hz)| (format!("mode {}", k + 1), hz)).collect()
    };
    let told = |a: f64, b: f64| match a > 0.0 {
        true => format!("{} → {} Hz ({:+.2} %)", number(a), number(b), 100.0 * (b / a - 1.0)),
        false => format!("{} → {} Hz", number(a), number(b)),
    };
    differences("frequency", &named(before), &named(now), told)
}

fn differences(
    head: &str,
    old: &[(String, f64)],
    new: &[(String, f64)],
    told: impl Fn(f64, f64) -> String,
) -> Vec<String> {
    let of = |list: &[(String, f64)], name: &str| list.iter().find(|(other, _)| other == name).map(|(_, x)| *x);
    let scale = old.iter().chain(new).fold(0.0_f64, |scale, (_, x)| scale.max(x.abs()));
    let mut lines = Vec::new();
    for (name, x) in new {
        match of(old, name) {
            Some(before) if (x - before).abs() <= SAME * scale => {}
            Some(before) => lines.push(format!("{name:<20} {}", told(before, *x))),
            None => lines.push(format!("{name:<20} {} (new)", number(*x))),
        }
    }
    let gone = old.iter().filter(|(name, _)| of(new, name).is_none());
    lines.extend(gone.map(|(name, x)| format!("{name:<20} was {} (gone)", number(*x))));
    let with_head = |(k, line): (usize, String)| format!("  {:<12} {line}", if k == 0 { head } else { "" });
    lines.into_iter().enumerate().map(with_head).collect()
}
