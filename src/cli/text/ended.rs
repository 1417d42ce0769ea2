//! Reports of a run that has ended.

use super::super::number::{digits_apart, mean_and_deviation, number_to};
use super::super::output::bold;
use super::{MOST_LINES, count, duration, more, number, small, times, without_noise};
use crate::model::description::When;
use crate::model::{Model, Output};
use crate::round_off::SHOWN;
use crate::simulate::Summary;
use crate::simulate::events::{Kind, Occurrence};
use crate::simulate::verify::{Verified, VerifiedEvents};
use std::fmt::Write;

/// Below this tolerance the share of a step is no longer a three-hundredth of it.
const FLOOR: f64 = 2.7e-11;
/// After more steps than this it is said what their errors add up to, however little.
const LONG: u64 = 2000;

/// What `run --verify` found.
pub(in crate::cli) fn verified(verified: &Verified) -> String {
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
    if verified.captured {
        out += ", captured steps an eighth as long";
    }
    if let Some(VerifiedEvents { events, same, apart, differ_from, scanned, beyond }) = &verified.events {
        let _ = write!(out, "\n  checked      {same} of {} in both runs", count(*events, "event", "events"));
        if *same > 0 {
            let _ = write!(out, ", times within {} s", small(*apart));
        }
        if let Some(time) = differ_from {
            let _ = write!(out, "; they differ from {} s on", number(*time));
        }
        if *scanned == 0 {
            return out + "\n               rigid stops are not looked at where stages change the hinges";
        }
        let passed = if *beyond > 0.0 { format!("by {} at most", small(*beyond)) } else { "nowhere".to_owned() };
        let _ = write!(out, "\n               rigid stops passed {passed} in {}", count(*scanned, "state", "states"));
    }
    out
}

/// More than this part of the largest energy of the run that is unaccounted for makes the rest worth little, if it is more than that part of the weight over
/// the scene's length, too: energies may cancel.
const DOUBTFUL: f64 = 0.01;
const NOTICEABLE: f64 = 1e-4;

/// The size of the energies of a run (J): heights are known to the round-off of the scene's length, whatever their sum is.
fn scale(model: &Model, summary: &Summary) -> f64 {
    summary.energy_largest.max(model.total_mass() * model.gravity.norm() * model.length_scale())
}

/// What is to be known before anything else is believed of a run.
pub(in crate::cli) fn doubt(model: &Model, summary: &Summary) -> Option<String> {
    let (drift, scale, largest) = (summary.energy_drift, scale(model, summary), summary.energy_largest);
    let captured = if summary.capture_steps > 0 { ", or give what is stiff some damping" } else { "" };
    (drift > DOUBTFUL * largest && drift > NOTICEABLE * scale).then(|| {
        format!(
            "{} % of the largest energy of the run is unaccounted for: what the run says is as doubtful as that; take a smaller `tolerance`{captured}",
            small(100.0 * drift / largest)
        )
    })
}

/// The energies of a run; what is below the round-off of their scale is 0, and that is said.
fn energies(model: &Model, summary: &Summary) -> String {
    let Summary { energy_start, energy_end, work, dissipated, energy_drift, .. } = *summary;
    let scale = scale(model, summary);
    let shown = |energy: f64| without_noise(energy, scale);
    let part = |what: &str, energy: f64| match shown(energy) {
        0.0 => String::new(),
        energy => format!(", {} J {what}", number(energy)),
    };
    let is_noise = |energy: &f64| *energy != 0.0 && shown(*energy) == 0.0;
    let floor = match [energy_start, energy_end, energy_drift].iter().any(is_noise) {
        true => format!(" (0: below the round-off of {} J)", small(SHOWN.of(scale))),
        false => String::new(),
    };
    format!(
        "{} J at the start, {} J at the end{}{}, unaccounted for {} J at most{floor}",
        number(shown(energy_start)),
        number(shown(energy_end)),
        part("put in", work),
        part("dissipated", dissipated),
        small(shown(energy_drift)),
    ) + &doubt(model, summary).map_or_else(String::new, |doubt| format!("\n  beware       {doubt}"))
}

/// What is said of beams whose elements turned by too much.
pub(in crate::cli) fn wound(summary: &Summary) -> impl Iterator<Item = String> {
    summary.wound.iter().map(|(time, wound)| format!("at {} s {}", number(*time), wound.note()))
}

/// Formulas of motors that steps went across.
pub(in crate::cli) fn across(summary: &Summary) -> impl Iterator<Item = String> {
    summary.across.iter().map(|motor| {
        format!(
            "the formula of `{motor}` switches to and fro: steps go across it, to the error that they see of that; `--verify` measures what is left \
             (dry friction is `friction` of a hinge)"
        )
    })
}

/// From so many stages with one output on it is said how it scatters.
const SCATTER: usize = 3;

/// An output that several stages tell of.
struct Scatter<'s> {
    label: &'s str,
    values: Vec<f64>,
    /// Significant digits that tell the values apart.
    digits: usize,
}

impl<'s> Scatter<'s> {
    /// Of all outputs that so many stages tell of, in the order in which they are told.
    fn all(summary: &'s Summary) -> Vec<Self> {
        let mut found: Vec<Self> = Vec::new();
        for (_, label, value) in &summary.told {
            match found.iter_mut().find(|one| one.label == label) {
                Some(one) => one.values.push(*value),
                None => found.push(Self { label, values: vec![*value], digits: 0 }),
            }
        }
        found.retain(|one| one.values.len() >= SCATTER && one.values.iter().all(|value| value.is_finite()));
        found.iter_mut().for_each(|one| one.digits = digits_apart(&one.values));
        found
    }

    fn line(&self, model: &Model) -> String {
        let units = |output: &Output| output.labels().zip(output.units.clone()).collect::<Vec<_>>();
        let known = model.outputs.iter().flat_map(units).find(|(label, unit)| *label == self.label && unit != "1");
        let unit = known.map_or(String::new(), |(_, unit)| format!(" {unit}"));
        let [mean, deviation] = mean_and_deviation(&self.values);
        format!(
            "  told         {} by {} stages: mean {}{unit}, standard deviation {}{unit}\n",
            self.label,
            self.values.len(),
            number_to(mean, self.digits),
            number(deviation)
        )
    }
}

/// The outputs that are told with a stage.
fn told(summary: &Summary, stage: &str, scatter: &[Scatter<'_>]) -> String {
    let of_stage = summary.told.iter().filter(|(name, ..)| name == stage);
    let digits = |label: &str| scatter.iter().find(|one| one.label == label).map_or(0, |one| one.digits);
    let each: Vec<String> =
        of_stage.map(|(_, label, value)| format!("{label} {}", number_to(*value, digits(label)))).collect();
    if each.is_empty() { String::new() } else { format!(": {}", each.join(", ")) }
}

/// Stages that have not come, a line each.
fn pending(summary: &Summary) -> String {
    let line = |(name, when): &(String, When)| format!("  not come     stage `{name}` waits for {when} still\n");
    summary.pending.iter().map(line).collect()
}

/// What contacts did otherwise than their laws and events say.
fn of_contacts(summary: &Summary) -> String {
    let mut out = String::new();
    if summary.held_back > 0 {
        let impacts = count(summary.held_back, "impact", "impacts");
        let _ = writeln!(
            out,
            "  held back    {impacts} came back with less than the restitution, which would have gained energy there"
        );
    }
    if summary.capture_steps > 0 {
        let steps = count(summary.capture_steps, "step", "steps");
        let _ = writeln!(out, "  captured     {steps} of order 1 where contacts were not followed from event to event");
    }
    out
}

/// The end of a run.
pub(in crate::cli) fn run(model: &Model, summary: &Summary, recording: &str) -> String {
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
    // Changes of the integrator are told of with the method, what a stage waits for with the stage.
    let begins = |time: f64| summary.events.iter().any(|event| event.kind == Kind::Stage && event.time == time);
    let is_told = |event: &&Occurrence| match event.kind {
        Kind::Switch => false,
        Kind::Crossing => !begins(event.time),
        _ => true,
    };
    let (stages, others): (Vec<_>, Vec<_>) =
        summary.events.iter().filter(is_told).partition(|event| event.kind == Kind::Stage);
    let mut events: Vec<_> = stages.into_iter().chain(others.iter().take(MOST_LINES).copied()).collect();
    events.sort_by(|a, b| a.time.total_cmp(&b.time));
    let scatter = Scatter::all(summary);
    for (line, event) in events.into_iter().enumerate() {
        let head = if line == 0 { "events" } else { "" };
        let told = if event.kind == Kind::Stage { told(summary, &event.name, &scatter) } else { String::new() };
        let _ = writeln!(out, "  {head:<12} {} s: {}{told}", number(event.time), event.in_words(number));
    }
    more(&mut out, others.len());
    scatter.iter().for_each(|one| out += &one.line(model));
    out += &pending(summary);
    if let Some(event) = &summary.stopped_by {
        let _ = writeln!(out, "  ended        by the event `{event}`");
    }
    out += &of_contacts(summary);
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
    let work: String = work.iter().map(|part| format!(", {part}")).collect();
    let _ = writeln!(out, "  steps        {} ({} rejected){work}", counters.steps, counters.rejected_steps);
    // Rounding adds up as a random walk: √n of n steps.
    let rounding = f64::EPSILON * (counters.steps as f64).sqrt();
    let is_above = counters.error_sum > summary.tolerance;
    if is_above || counters.steps > LONG && counters.error_sum > 0.0 {
        let advice = match summary.tolerance < FLOOR {
            true => "no step is held to less than 9e-14",
            false => "a tighter one brings them down",
        };
        let above = format!(", above the tolerance of {:.0e}: {advice}", summary.tolerance);
        let _ = writeln!(
            out,
            "  accuracy     the errors of {} steps, each by itself, add up to {}{}; rounding adds {}; what the motion makes of \
             them until the end is not in this: `--verify` measures it",
            counters.steps,
            small(counters.error_sum),
            if is_above { &above } else { "" },
            small(rounding)
        );
    }
    let _ = writeln!(out, "  energy       {}", energies(model, summary));
    for note in wound(summary).chain(across(summary)) {
        let _ = writeln!(out, "  note         {note}");
    }
    let _ = writeln!(out, "  recording    {recording} ({})", count(summary.samples, "sample", "samples"));
    let _ = write!(out, "  to see it    stillpoint view {recording}");
    out
}
