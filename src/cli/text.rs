//! Reports for people.

use super::output::bold;
use crate::constraint::Assembly;
pub(super) use crate::model::problem::number;
use crate::model::{Model, Output};
use crate::simulate::Summary;
use crate::simulate::events::Kind;
use crate::simulate::verify::{Verified, VerifiedEvents};
use crate::statics::{Equilibrium, Mode, Stability};
use std::fmt::Write;
use std::time::Duration;

/// Long lists stop here; `--json` has all.
const MOST_LINES: usize = 8;
/// Zero-stiffness motions among them.
const MOST_IDLE: usize = 3;
/// What is left of a sum of numbers of size one that should cancel.
const ROUND_OFF: f64 = 1e-12;
/// Below this tolerance the share of a step is no longer a three-hundredth of it.
const FLOOR: f64 = 2.7e-11;
/// A smaller part of critical damping is round-off.
const UNDAMPED: f64 = 1e-10;

/// `3 bodies`, `1 body`.
pub(super) fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// `25 ×`, `0.31 ×`.
pub(super) fn times(factor: f64) -> String {
    if factor >= 10.0 { format!("{factor:.0} ×") } else { format!("{factor:.2} ×") }
}

pub(super) fn duration(wall: Duration) -> String {
    let seconds = wall.as_secs_f64();
    match seconds {
        s if s < 1e-3 => format!("{:.0} µs", s * 1e6),
        s if s < 1.0 => format!("{:.1} ms", s * 1e3),
        s => format!("{s:.2} s"),
    }
}

/// A cost in the unit that suits it.
pub(super) fn nanoseconds(cost: f64) -> String {
    match cost {
        c if c < 1e4 => format!("{c:.0} ns"),
        c if c < 1e7 => format!("{:.1} µs", c * 1e-3),
        c => format!("{:.1} ms", c * 1e-6),
    }
}

/// Title and size of a scene.
pub(super) fn heading(model: &Model, name: &str) -> String {
    let title = if model.title.is_empty() { name } else { &model.title };
    format!(
        "{}\n  {}, {}, {} kg",
        bold(title),
        count(model.bodies.iter().filter(|body| !body.is_element).count(), "body", "bodies"),
        count(model.degrees_of_freedom(), "degree of freedom", "degrees of freedom"),
        number(model.total_mass())
    )
}

/// What is said of loops, drives and gears.
pub(super) fn couplings(assembly: &Assembly) -> Vec<String> {
    let redundant = |(name, redundant, rows): &(String, usize, usize)| {
        format!("{name}: {redundant} of {rows} rows redundant, its reactions and those around it are not unique")
    };
    assembly.redundant.iter().map(redundant).collect()
}

/// Two digits for what should be small: `7.3e-10`, `0`; without an exponent where it is not.
pub(super) fn small(x: f64) -> String {
    match x.abs() {
        0.0 => "0".to_owned(),
        size if (1e-3..1e4).contains(&size) => {
            let digits = (1.0 - size.log10().floor()).max(0.0) as usize;
            format!("{x:.digits$}")
        }
        _ => format!("{x:.1e}"),
    }
}

/// Zero where a number is round-off beside others of size `scale`.
pub(super) fn without_noise(x: f64, scale: f64) -> f64 {
    if x.abs() <= ROUND_OFF * scale { 0.0 } else { x }
}

fn numbers(list: impl Iterator<Item = f64>) -> String {
    list.map(number).collect::<Vec<_>>().join(", ")
}

/// The certificate of statics.
pub(super) fn statics(model: &Model, found: &Equilibrium, wall: Duration) -> String {
    let mut out = String::new();
    let verdict = match (&found.stability, found.balanced) {
        (Some(stability), true) => format!("{} equilibrium", stability.verdict.name()),
        _ if found.stage == "given" => "the pose does not stand".to_owned(),
        _ => "no equilibrium found".to_owned(),
    };
    let stage = match found.stage {
        "start" if found.balanced => "the guess is one already".to_owned(),
        "start" => "no search".to_owned(),
        "inverse" | "given" => "of the given pose".to_owned(),
        stage => format!("{}, {stage}", count(found.iterations, "step", "steps")),
    };
    let _ = writeln!(out, "{} ({stage}, {})", bold(&verdict), duration(wall));
    let _ = writeln!(
        out,
        "  residual     {} of the forces that cancel ({} N or N m; acceleration {})",
        small(found.relative_residual),
        small(found.residual_force),
        small(found.residual_acceleration)
    );
    if let Some(standing) = &found.standing {
        out += &super::standing::text(model, standing);
    }
    if let Some(stability) = &found.stability {
        modes(&mut out, stability);
        damped_modes(&mut out, stability);
    }
    for (line, (name, value)) in found.unknowns.iter().enumerate() {
        let head = if line == 0 { "inputs" } else { "" };
        let _ = writeln!(out, "  {head:<12} {name} = {}", number(*value));
    }
    if found.stages.len() > 1 {
        stages(&mut out, found);
    }
    let title = match found.balanced {
        true => "pose",
        false if found.method == "inverse" => "given pose",
        false if found.position == model.start_position => "the guess",
        false => "last pose",
    };
    pose(&mut out, model, &found.position, title);
    bearings(&mut out, model, found);
    for (name, redundant, rows) in found.redundant.iter().filter(|_| found.balanced) {
        let _ = writeln!(out, "  not unique   reactions in and around {name}: {redundant} of {rows} rows redundant");
    }
    for note in &found.notes {
        let _ = writeln!(out, "  note         {note}");
    }
    out.trim_end().to_owned()
}

/// Directions that are not stable, and the modes.
fn modes(out: &mut String, stability: &Stability) {
    if stability.unstable_directions > 0 {
        let _ = writeln!(out, "  unstable     in {}", count(stability.unstable_directions, "direction", "directions"));
    }
    if stability.neutral_directions > 0 {
        let motions = count(stability.neutral_directions, "motion", "motions");
        let _ = writeln!(out, "  neutral      {motions} of zero stiffness");
    }
    // Of zero-stiffness motions a few will do: their number is above.
    let idle = |mode: &Mode| mode.frequency_hz == 0.0 && mode.growth_rate == 0.0;
    let mut seen = 0;
    let told: Vec<&Mode> = (stability.modes.iter())
        .filter(|mode| {
            seen += usize::from(idle(mode));
            !idle(mode) || seen <= MOST_IDLE
        })
        .take(MOST_LINES)
        .collect();
    for (line, mode) in told.iter().enumerate() {
        let what = match mode.growth_rate > 0.0 {
            true => format!("grows {} per second", number(mode.growth_rate)),
            false if mode.frequency_hz == 0.0 => "zero stiffness".to_owned(),
            false => format!("{} Hz", number(mode.frequency_hz)),
        };
        let head = if line == 0 { "modes" } else { "" };
        let _ = writeln!(out, "  {head:<12} {what:<24} {}", carriers(&mode.shares));
    }
    left_out(out, stability.modes.len() - told.len());
}

/// The damped modes.
fn damped_modes(out: &mut String, stability: &Stability) {
    for (line, mode) in stability.damped.iter().take(MOST_LINES).enumerate() {
        let decay = match mode.decay_rate {
            _ if mode.damping_ratio.abs() < UNDAMPED => "undamped".to_owned(),
            rate if rate < 0.0 => format!("grows {} per second", number(-rate)),
            rate => format!("decays {} per second", number(rate)),
        };
        let what = match mode.frequency_hz {
            0.0 => decay,
            hz => format!("{} Hz, {decay}", number(hz)),
        };
        let head = if line == 0 { "damped" } else { "" };
        let _ = writeln!(out, "  {head:<12} {what:<42} {}", carriers(&mode.shares));
    }
    more(out, stability.damped.len());
}

/// What every stage of the search worked.
fn stages(out: &mut String, found: &Equilibrium) {
    for (line, stage) in found.stages.iter().enumerate() {
        let head = if line == 0 { "stages" } else { "" };
        let ended = if stage.balanced { "balanced" } else { "failed" };
        let _ = writeln!(
            out,
            "  {head:<12} {:<12} {}, {}, {}: {ended} at {}",
            stage.name,
            count(stage.iterations, "step", "steps"),
            count(stage.force_evaluations, "balance", "balances"),
            count(stage.factorizations, "factorization", "factorizations"),
            small(stage.relative_residual)
        );
    }
}

/// What drives, motors, locks and stops bear.
fn bearings(out: &mut String, model: &Model, found: &Equilibrium) {
    let weight = model.total_mass() * model.gravity.norm() * model.length_scale().max(1.0);
    let motors = model.motor_forces(&found.position, &found.velocity);
    let drives = model.drives.iter().map(|drive| drive.coordinate.slides);
    pushes(out, "drives", &found.drive_forces, drives);
    pushes(out, "motors", &motors, model.motors.iter().map(|motor| motor.coordinate.slides));
    for (name, force) in &found.holding {
        let held = match without_noise(*force, weight) {
            0.0 => "nothing".to_owned(),
            force => format!("{} N or N m", number(force)),
        };
        let _ = writeln!(out, "  locked       {name} holds {held}");
    }
    for stop in &found.stops {
        let side = if stop.low { "low" } else { "high" };
        let load = match without_noise(stop.load, weight) {
            0.0 => "nothing".to_owned(),
            load => format!("{} N or N m", number(load)),
        };
        let depth = if stop.depth > 0.0 { format!(", {} deep", number(stop.depth)) } else { String::new() };
        let _ = writeln!(
            out,
            "  on a stop    {} at its {side} limit {}: bears {load}{depth}",
            stop.hinge,
            number(stop.limit)
        );
    }
}

/// What drives or motors push with.
fn pushes(out: &mut String, title: &str, forces: &[(String, f64)], slides: impl Iterator<Item = bool>) {
    for (line, ((name, force), slides)) in forces.iter().zip(slides).take(MOST_LINES).enumerate() {
        let head = if line == 0 { title } else { "" };
        let _ = writeln!(out, "  {head:<12} {name:<20} {} {}", number(*force), if slides { "N" } else { "N m" });
    }
    more(out, forces.len());
}

/// The outputs, one line each; `None` without any.
pub(super) fn outputs(model: &Model, values: &[f64]) -> Option<String> {
    let line = |(index, output): (usize, &Output)| {
        let head = if index == 0 { "outputs" } else { "" };
        let shown = numbers(values.get(output.range()).unwrap_or_default().iter().copied());
        let mut units: Vec<&str> = output.units.iter().map(String::as_str).filter(|unit| *unit != "1").collect();
        units.dedup();
        format!("  {head:<12} {:<20} {shown} {}", output.name, units.join(", ")).trim_end().to_owned()
    };
    let lines: Vec<String> = model.outputs.iter().enumerate().map(line).collect();
    (!lines.is_empty()).then(|| lines.join("\n"))
}

fn carriers(shares: &[(String, f64)]) -> String {
    let shown: Vec<String> = shares
        .iter()
        .take(3)
        .filter(|(_, share)| *share >= 0.005)
        .map(|(name, share)| format!("{name} {:.0} %", 100.0 * share))
        .collect();
    shown.join(", ")
}

fn more(out: &mut String, total: usize) {
    left_out(out, total.saturating_sub(MOST_LINES));
}

fn left_out(out: &mut String, count: usize) {
    if count > 0 {
        let _ = writeln!(out, "  {:<12} … and {count} more (--json has all)", "");
    }
}

fn pose(out: &mut String, model: &Model, position: &[f64], title: &str) {
    let hinges = model.bodies.iter().filter(|body| body.hinge.kind.counts().0 > 0);
    let total = hinges.clone().count();
    let length = model.length_scale();
    for (line, body) in hinges.take(MOST_LINES).enumerate() {
        let names: Vec<&str> = body.hinge.kind.positions().iter().map(|(name, _)| *name).collect();
        let head = if line == 0 { title } else { "" };
        let scales = body.hinge.kind.positions().iter().map(|(_, unit)| if *unit == "m" { length } else { 1.0 });
        let values = numbers(scales.zip(&position[body.hinge.position..]).map(|(scale, x)| without_noise(*x, scale)));
        let _ = writeln!(out, "  {head:<12} {:<20} {} = {values}", body.name, names.join(", "));
    }
    more(out, total);
}

/// What `run --verify` found.
pub(super) fn verified(verified: &Verified) -> String {
    let kinds = [
        (verified.length, "m"),
        (verified.angle, "rad"),
        (verified.speed, "m/s"),
        (verified.rate, "rad/s"),
        (verified.time, "s"),
    ];
    let parts: Vec<String> = kinds
        .iter()
        .filter(|(error, _)| *error > 0.0)
        .map(|(error, unit)| format!("{} {unit}", small(*error)))
        .collect();
    let errors = if parts.is_empty() { "nothing".to_owned() } else { parts.join(", ") };
    let (method, tolerance) = (verified.method.name(), verified.tolerance);
    let mut out = format!("  error        {errors} at the end, estimated by a second run: {method} at {tolerance:.0e}");
    if let Some(VerifiedEvents { events, same, apart, differ_from, scanned, beyond }) = &verified.events {
        let _ = write!(out, "\n  checked      {same} of {} in both runs", count(*events, "event", "events"));
        if *same > 0 {
            let _ = write!(out, ", times within {} s", small(*apart));
        }
        if let Some(time) = differ_from {
            let _ = write!(out, "; they differ from {} s on", number(*time));
        }
        let passed = if *beyond > 0.0 { format!("by {} at most", small(*beyond)) } else { "nowhere".to_owned() };
        let _ = write!(out, "\n               rigid stops passed {passed} in {}", count(*scanned, "state", "states"));
    }
    out
}

/// The energies of a run; what is below the round-off of their scale is 0, and that is said.
fn energies(model: &Model, summary: &Summary) -> String {
    let Summary { energy_start, energy_end, work, dissipated, energy_drift, .. } = *summary;
    // Heights are known to the round-off of the scene's length, whatever the sum of their energies is.
    let weight = model.total_mass() * model.gravity.norm() * model.length_scale();
    let scale =
        [energy_start, energy_end, work, dissipated].iter().fold(weight, |scale, energy| scale.max(energy.abs()));
    let shown = |energy: f64| without_noise(energy, scale);
    let part = |what: &str, energy: f64| match shown(energy) {
        0.0 => String::new(),
        energy => format!(", {} J {what}", number(energy)),
    };
    let is_noise = |energy: &f64| *energy != 0.0 && shown(*energy) == 0.0;
    let floor = match [energy_start, energy_end, energy_drift].iter().any(is_noise) {
        true => format!(" (0: below the round-off of {} J)", small(ROUND_OFF * scale)),
        false => String::new(),
    };
    format!(
        "{} J at the start, {} J at the end{}{}, unaccounted for {} J at most{floor}",
        number(shown(energy_start)),
        number(shown(energy_end)),
        part("put in", work),
        part("dissipated", dissipated),
        small(shown(energy_drift)),
    )
}

/// The end of a run.
pub(super) fn run(model: &Model, summary: &Summary, recording: &str) -> String {
    let mut out = String::new();
    let methods: Vec<&str> = summary.integrators.iter().map(|method| method.name()).collect();
    let counters = &summary.statistics;
    let state = if summary.interrupted { "stopped at" } else { "simulated" };
    let speed = summary.end_time / summary.wall.as_secs_f64().max(1e-9);
    let _ = writeln!(
        out,
        "{} {} s in {} ({} real time) {}",
        bold(state),
        number(summary.end_time),
        duration(summary.wall),
        times(speed),
        if methods.is_empty() { "at rest".to_owned() } else { format!("with {}", methods.join(", then ")) }
    );
    // Changes of the integrator are told of with the method.
    let events: Vec<_> = summary.events.iter().filter(|event| event.kind != Kind::Switch).collect();
    for (line, event) in events.iter().take(MOST_LINES).enumerate() {
        let head = if line == 0 { "events" } else { "" };
        let (time, name, kind, value) = (number(event.time), &event.name, event.kind.name(), number(event.value));
        let what = match event.kind {
            _ if event.between.is_some() => event.to_string(),
            Kind::Slip | Kind::Stick => format!("`{name}` {kind} at {value}"),
            _ => format!("{kind} of `{name}` at {value}, speed {}", number(event.speed)),
        };
        let _ = writeln!(out, "  {head:<12} {time} s: {what}");
    }
    more(&mut out, events.len());
    if let Some(event) = &summary.stopped_by {
        let _ = writeln!(out, "  ended        by the event `{event}`");
    }
    if let Some(choice) = &summary.choice {
        let _ = writeln!(out, "  method       {choice}");
    }
    let work: Vec<String> = [
        (counters.acceleration_evaluations, "acceleration", "accelerations"),
        (counters.residual_evaluations, "force balance", "force balances"),
        (counters.jacobian_evaluations, "Jacobian", "Jacobians"),
    ]
    .iter()
    .filter(|(n, ..)| *n > 0)
    .map(|(n, one, many)| format!("{n} {}", if *n == 1 { one } else { many }))
    .collect();
    let _ =
        writeln!(out, "  steps        {} ({} rejected), {}", counters.steps, counters.rejected_steps, work.join(", "));
    // Rounding adds up as a random walk: √n of n steps.
    let rounding = f64::EPSILON * (counters.steps as f64).sqrt();
    if counters.error_sum > summary.tolerance {
        let _ = writeln!(
            out,
            "  accuracy     the errors of {} steps add up to {} at most, above the tolerance of {:.0e}: {}; rounding adds {}",
            counters.steps,
            small(counters.error_sum),
            summary.tolerance,
            match summary.tolerance < FLOOR {
                true => "no step is held to less than 9e-14",
                false => "a tighter one brings them down",
            },
            small(rounding)
        );
    }
    let _ = writeln!(out, "  energy       {}", energies(model, summary));
    let _ = writeln!(out, "  recording    {recording} ({})", count(summary.samples, "sample", "samples"));
    let _ = write!(out, "  to see it    stillpoint view {recording}");
    out
}
