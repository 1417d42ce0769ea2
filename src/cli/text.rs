//! Reports for people.

mod ended;

pub(super) use super::number::{aligned, count, number, small, times, without_noise};
use super::output::{bold, verdict};
use crate::constraint::Assembly;
use crate::contact::support;
use crate::model::{Body, Model, Output, Parameter, Stop};
use crate::round_off::ON_A_LIMIT;
use crate::statics::{DampedMode, Equilibrium, NaturalMode, Stability, StabilityVerdict};
pub(super) use ended::{across, doubt, run, verified, wound};
use std::fmt::Write;
use std::time::Duration;

/// Long lists stop here; `--json` has all.
const MOST_LINES: usize = 8;
/// Zero-stiffness motions among them.
const MOST_IDLE: usize = 3;
/// Loops of a group that share a load, named.
const MOST_SHARED: usize = 4;
/// A smaller part of critical damping is round-off.
pub(super) const UNDAMPED: f64 = 1e-10;

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
        count(model.bodies.iter().filter(|body| !body.is_inner).count(), "body", "bodies"),
        count(model.degrees_of_freedom(), "degree of freedom", "degrees of freedom"),
        number(model.total_mass())
    )
}

/// What is said of loops, drives and gears.
pub(super) fn couplings(assembly: &Assembly) -> Vec<String> {
    let redundant = |(name, redundant, rows): &(String, usize, usize)| {
        format!(
            "{name}: {redundant} of {} redundant, its reactions and those around it are not unique",
            count(*rows, "row", "rows")
        )
    };
    assembly.redundant.iter().map(redundant).collect()
}

fn numbers(list: impl Iterator<Item = f64>) -> String {
    list.map(number).collect::<Vec<_>>().join(", ")
}

/// The verdict of statics, how it was found, and how long that took.
fn found_by(model: &Model, found: &Equilibrium, wall: Duration) -> String {
    let (text, fine) = match (&found.stability, found.balanced) {
        (Some(stability), true) if !found.converged && !found.aimed.is_empty() => {
            (format!("aim missed, {} equilibrium", stability.verdict.name()), false)
        }
        (Some(stability), true) => {
            let if_so = stability.supposes.map_or(String::new(), |what| format!(" if {what}"));
            let text = format!("{} equilibrium{if_so}", stability.verdict.name());
            (text, is_fine(found.converged, Some(stability.verdict.name())))
        }
        _ if found.stage == "given" => ("the pose does not stand".to_owned(), false),
        _ => ("no equilibrium found".to_owned(), false),
    };
    let stage = match found.stage {
        "start" if found.balanced && is_beyond(model) => {
            "the guess is one at its limits, which it was beyond".to_owned()
        }
        "start" if found.balanced => "the guess is one already".to_owned(),
        "start" => "no search".to_owned(),
        "inverse" | "given" => "of the given pose".to_owned(),
        // Its own Newton steps are not those of the cascade.
        stage if found.method == "lagrange" => {
            format!("{}, lagrange: {stage}", count(found.iterations, "step", "steps"))
        }
        stage => format!("{}, {stage}", count(found.iterations, "step", "steps")),
    };
    format!("{} ({stage}, {})", verdict(&text, fine), duration(wall))
}

/// Whether an equilibrium is one that was hoped for: of the kind that was asked for, and no small displacement grows from it. `stability` is
/// the name of its verdict.
pub(super) fn is_fine(converged: bool, stability: Option<&str>) -> bool {
    converged && stability != Some(StabilityVerdict::Unstable.name())
}

/// Whether the guess is beyond rigid limits: statics moves it to them.
fn is_beyond(model: &Model) -> bool {
    let is_passed = |stop: &Stop| {
        let value = model.start_position[stop.position];
        stop.passed(value, ON_A_LIMIT.of(value.abs().max(1.0))).is_some()
    };
    model.stops.iter().any(|stop| stop.is_rigid() && is_passed(stop))
}

/// What proves the equilibrium: the residual relative to the forces that cancel, and where it is largest.
fn residual(model: &Model, found: &Equilibrium) -> String {
    let share = format!("{} of the forces that cancel", small(found.relative_residual));
    match found.residual_at.filter(|_| found.residual_force > 0.0) {
        Some(at) => {
            let (force, unit) = (small(found.residual_force), model.force_unit(at));
            format!("{share} (at most {force} {unit}, in {})", model.label(at))
        }
        None => share,
    }
}

/// The certificate of statics that a run begins with: one line, with what a person should know. All of it if it is asked for, or if
/// nothing can begin.
pub(super) fn equilibrium(
    model: &Model,
    found: &Equilibrium,
    unknown: &[Parameter],
    wall: Duration,
    verbose: bool,
) -> String {
    let Some(stability) = found.stability.as_ref().filter(|_| found.converged && !verbose) else {
        return statics(model, found, unknown, wall);
    };
    let mut out = format!(
        "{}: residual {} of the forces that cancel",
        found_by(model, found, wall),
        small(found.relative_residual)
    );
    if found.standing.as_ref().is_some_and(|standing| standing.verdict == support::Verdict::Stands) {
        out += ", stands";
    }
    if let Some(fastest) =
        stability.modes.iter().map(|mode| mode.growth_rate).max_by(f64::total_cmp).filter(|rate| *rate > 0.0)
    {
        let _ = write!(out, ", grows {} per second", number(fastest));
    }
    if let Some(first) = stability.frequencies().find(|frequency| *frequency > 0.0) {
        let _ = write!(out, ", first mode {} Hz", number(first));
    }
    for note in &found.notes {
        let _ = write!(out, "\n  note         {note}");
    }
    out
}

/// The certificate of statics; `unknown` are the numbers that may have been found with it.
pub(super) fn statics(model: &Model, found: &Equilibrium, unknown: &[Parameter], wall: Duration) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "{}", found_by(model, found, wall));
    let _ = writeln!(out, "  residual     {}", residual(model, found));
    if let Some(standing) = &found.standing {
        out += &super::standing::text(model, standing, found.converged);
    }
    if let Some(stability) = &found.stability {
        modes(&mut out, stability);
        damped_modes(&mut out, stability);
    }
    let inputs = aligned(found.unknowns.iter().map(|(_, value)| *value));
    let width = found.unknowns.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    for (line, ((name, _), value)) in found.unknowns.iter().zip(inputs).enumerate() {
        let head = if line == 0 { "inputs" } else { "" };
        let unit = unknown.iter().find(|one| one.address == *name).map_or("", |one| one.quantity.unit());
        let _ = writeln!(out, "{}", format!("  {head:<12} {name:<width$} = {} {unit}", value.trim_end()).trim_end());
    }
    for (line, (name, value)) in found.aimed.iter().enumerate() {
        let output =
            model.outputs.iter().find_map(|one| one.labels().position(|label| label == *name).map(|at| &one.units[at]));
        let unit = output.map_or("", |unit| if unit == "1" { "" } else { unit });
        let head = if line == 0 { "aimed" } else { "" };
        let _ = writeln!(out, "{}", format!("  {head:<12} {name} = {} {unit}", number(*value)).trim_end());
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
        let _ = writeln!(
            out,
            "  not unique   reactions in and around {name}: {redundant} of {} redundant",
            count(*rows, "row", "rows")
        );
    }
    if let Some(group) = not_unique(found) {
        let _ = writeln!(out, "  not unique   {group}");
    }
    for note in &found.notes {
        let _ = writeln!(out, "  note         {note}");
    }
    out.trim_end().to_owned()
}

/// The loops whose reactions are not unique, if these are more than those with redundant rows: which rows of a group are left
/// out is a matter of their order.
fn not_unique(found: &Equilibrium) -> Option<String> {
    let shared: Vec<&str> = found
        .loops
        .iter()
        .filter(|one| !one.unique)
        .map(|one| one.name.as_str())
        .filter(|name| !name.is_empty())
        .collect();
    if !found.balanced || shared.len() <= found.redundant.len() {
        return None;
    }
    let named: Vec<String> = shared.iter().take(MOST_SHARED).map(|name| format!("`{name}`")).collect();
    let more = match shared.len() - named.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    Some(format!("what {} pass together: {}{more}", count(shared.len(), "loop", "loops"), named.join(", ")))
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
    let idle = |mode: &NaturalMode| mode.frequency_hz == 0.0 && mode.growth_rate == 0.0;
    let mut seen = 0;
    let told: Vec<&NaturalMode> = (stability.modes.iter())
        .filter(|mode| {
            seen += usize::from(idle(mode));
            !idle(mode) || seen <= MOST_IDLE
        })
        .take(MOST_LINES)
        .collect();
    let mut hertz = aligned(told.iter().filter(|mode| is_oscillation(mode)).map(|mode| mode.frequency_hz)).into_iter();
    let what = |mode: &&NaturalMode| match mode.growth_rate > 0.0 {
        true if mode.frequency_hz > 0.0 => {
            format!("grows {} per second at {} Hz", number(mode.growth_rate), number(mode.frequency_hz))
        }
        true => format!("grows {} per second", number(mode.growth_rate)),
        false if mode.frequency_hz == 0.0 => "zero stiffness".to_owned(),
        false => format!("{} Hz", hertz.next().unwrap_or_default()),
    };
    let what = padded(told.iter().map(what));
    for (line, (mode, what)) in told.iter().zip(what).enumerate() {
        let head = if line == 0 { "modes" } else { "" };
        let _ = writeln!(out, "  {head:<12} {what}   {}", carriers(&mode.shares));
    }
    left_out(out, stability.modes.len() - told.len());
}

fn is_oscillation(mode: &NaturalMode) -> bool {
    mode.growth_rate <= 0.0 && mode.frequency_hz > 0.0
}

/// The damped modes: frequency, damping ratio ζ and decay.
fn damped_modes(out: &mut String, stability: &Stability) {
    let told = &stability.damped[..stability.damped.len().min(MOST_LINES)];
    let swings = || told.iter().filter(|mode| mode.frequency_hz > 0.0);
    let ratio = |mode: &DampedMode| if mode.damping_ratio.abs() < UNDAMPED { 0.0 } else { mode.damping_ratio };
    let [hertz, ratios] = [aligned(swings().map(|mode| mode.frequency_hz)), aligned(swings().map(ratio))];
    let mut swing = hertz.into_iter().zip(ratios).map(|(hertz, ratio)| format!("{hertz} Hz   ζ {ratio}   "));
    let what = |mode: &DampedMode| {
        let decay = match mode.decay_rate {
            _ if ratio(mode) == 0.0 => "undamped".to_owned(),
            rate if rate < 0.0 => format!("grows {} per second", number(-rate)),
            rate => format!("decays {} per second", number(rate)),
        };
        if mode.frequency_hz > 0.0 { swing.next().unwrap_or_default() + &decay } else { decay }
    };
    let what = padded(told.iter().map(what));
    for (line, (mode, what)) in told.iter().zip(what).enumerate() {
        let head = if line == 0 { "damped" } else { "" };
        let _ = writeln!(out, "  {head:<12} {what}   {}", carriers(&mode.shares));
    }
    more(out, stability.damped.len());
}

/// Texts of one column, all of the same width.
fn padded(texts: impl Iterator<Item = String>) -> Vec<String> {
    let texts: Vec<String> = texts.collect();
    let width = texts.iter().map(|text| text.chars().count()).max().unwrap_or(0);
    texts.iter().map(|text| format!("{text:<width$}")).collect()
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
    let weight = weight(model);
    let motors = model.motor_forces(&found.position, &found.velocity);
    let of = |force: f64| without_noise(force, weight);
    let drives = model.drives.iter().map(|drive| drive.coordinate.velocity);
    let motored = model.motors.iter().map(|motor| motor.coordinate.velocity);
    let named = |forces: Vec<(String, f64)>, at: Vec<usize>| {
        let one = |((name, force), at): ((String, f64), usize)| (name, of(force), model.force_unit(at));
        forces.into_iter().zip(at).map(one).collect::<Vec<_>>()
    };
    pushes(out, "drives", &named(found.drive_forces.clone(), drives.collect()));
    pushes(out, "motors", &named(motors, motored.collect()));
    for (name, force) in &found.holding {
        let _ = writeln!(out, "  locked       {name} holds {}", borne(model, name, of(*force)));
    }
    for stop in &found.stops {
        let side = stop.side.name();
        let load = borne(model, &stop.hinge, of(stop.load));
        let depth = if stop.depth > 0.0 { format!(", {} deep", number(stop.depth)) } else { String::new() };
        let _ = writeln!(
            out,
            "  on a stop    {} at its {side} limit {}: bears {load}{depth}",
            stop.hinge,
            number(stop.limit)
        );
    }
}

/// The weight of a scene, or its moment about a length of the scene if that is larger (N, N m).
fn weight(model: &Model) -> f64 {
    model.total_mass() * model.gravity.norm() * model.length_scale().max(1.0)
}

/// A force along a coordinate with its unit, in words.
pub(super) fn borne(model: &Model, label: &str, force: f64) -> String {
    match force {
        0.0 => "nothing".to_owned(),
        force => format!("{} {}", number(force), model.labelled(label).map_or("", |at| model.force_unit(at))),
    }
}

/// What drives or motors push with.
fn pushes(out: &mut String, title: &str, forces: &[(String, f64, &str)]) {
    let told = &forces[..forces.len().min(MOST_LINES)];
    let shown = aligned(told.iter().map(|(_, force, _)| *force));
    for (line, ((name, _, unit), force)) in told.iter().zip(shown).enumerate() {
        let head = if line == 0 { title } else { "" };
        let _ = writeln!(out, "  {head:<12} {name:<20} {force} {unit}");
    }
    more(out, forces.len());
}

/// The size that numbers of a unit have in a scene of some length (m) and weight (N), for what is round-off of it; zero for units of which
/// nothing is known.
pub(super) fn size(unit: &str, length: f64, weight: f64) -> f64 {
    match unit {
        "m" => length,
        "rad" | "1" => 1.0,
        "N" | "N m" | "J" => weight,
        _ => 0.0,
    }
}

/// The outputs, one line each; `None` without any.
pub(super) fn outputs(model: &Model, values: &[f64]) -> Option<String> {
    let (length, weight) = (model.length_scale(), weight(model));
    let line = |(index, output): (usize, &Output)| {
        let head = if index == 0 { "outputs" } else { "" };
        let of = values.get(output.range()).unwrap_or_default().iter().zip(&output.units);
        let shown = numbers(of.map(|(value, unit)| without_noise(*value, size(unit, length, weight))));
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
    let hinges: Vec<&Body> = model.bodies.iter().filter(|body| body.hinge.kind.counts().0 > 0).collect();
    let length = model.length_scale();
    let told = &hinges[..hinges.len().min(MOST_LINES)];
    let values = |body: &Body| -> Vec<f64> {
        let scales = body.hinge.kind.positions().iter().map(|(_, unit)| if *unit == "m" { length } else { 1.0 });
        scales.zip(&position[body.hinge.position..]).map(|(scale, x)| without_noise(*x, scale)).collect()
    };
    let names = |body: &Body| body.hinge.kind.positions().iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    let is_single = |body: &&&Body| body.hinge.kind.counts().0 == 1;
    let mut single = aligned(told.iter().filter(is_single).flat_map(|body| values(body))).into_iter();
    let width = told.iter().filter(is_single).map(|body| names(body).len()).max().unwrap_or(0);
    for (line, body) in told.iter().enumerate() {
        let head = if line == 0 { title } else { "" };
        let (names, shown) = match is_single(&body) {
            true => (format!("{:<width$}", names(body)), single.next().unwrap_or_default()),
            false => (names(body), numbers(values(body).into_iter())),
        };
        let _ = writeln!(out, "  {head:<12} {:<20} {names} = {}", body.name, shown.trim_end());
    }
    more(out, hinges.len());
}
