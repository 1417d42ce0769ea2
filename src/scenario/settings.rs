//! `[simulate]`, `[statics]` and `[record]`.

use super::findings::Finding;
use super::reader::Reader;
use crate::model::description::{BodyDescription, Description};
use crate::simulate::settings::{Integrator, Settings as Simulate, Start};
use crate::statics::settings::{Method, Settings as Statics, Want};

/// The samples of a run: with a few coordinates a recording of tens of gigabytes.
const MOST_SAMPLES: f64 = 1e8;

pub(super) fn simulate(scenario: &Reader<'_>) -> Simulate {
    let mut settings = Simulate { gap: statics(scenario).gap, ..Simulate::default() };
    let Some(table) = scenario.table("simulate") else { return settings };
    match table.text("start") {
        Some("given") => settings.start = Start::Given,
        Some("equilibrium") => settings.start = Start::Equilibrium,
        _ => {}
    }
    settings.integrator = table.text("integrator").and_then(Integrator::named).unwrap_or(settings.integrator);
    settings.duration = table.number("duration").unwrap_or(settings.duration);
    settings.tolerance = table.number("tolerance").unwrap_or(settings.tolerance);
    settings.absolute_tolerance = table.number("absolute_tolerance").unwrap_or(settings.tolerance);
    settings.rho_infinity = table.number("rho_infinity").unwrap_or(settings.rho_infinity);
    settings.step = table.number("step");
    settings
}

pub(super) fn statics(scenario: &Reader<'_>) -> Statics {
    let mut settings = Statics::default();
    let Some(table) = scenario.table("statics") else { return settings };
    match table.text("want") {
        Some("any") => settings.want = Want::Any,
        Some("stable") => settings.want = Want::Stable,
        _ => {}
    }
    let named = |method: &Method| Some(method.name()) == table.text("method");
    settings.method = Method::ALL.into_iter().find(named).unwrap_or(settings.method);
    settings.gap = table.number("gap").unwrap_or(settings.gap);
    settings.settle = table.text("contact") == Some("settle");
    settings.time_limit = table.number("time_limit").unwrap_or(settings.time_limit);
    settings
}

/// What `[statics]` asks of scenes with contact or dry friction alone, and what knows neither.
pub(super) fn check_supports(scenario: &Reader<'_>, description: &Description) {
    let Some(table) = scenario.table("statics") else { return };
    let rubs = |body: &BodyDescription| body.hinge.friction.iter().any(|friction| friction.stick > 0.0);
    let refuse = |key: &str, message: &str, help: &str| {
        table.findings.push(Finding::error(table.key_span(key), message.to_owned()).help(help));
    };
    if description.contacts.is_empty() && !description.bodies.iter().any(rubs) {
        if table.has("margin") {
            let message =
                "`margin` asks what may move while contact or dry friction holds the pose: the scene has neither";
            refuse("margin", message, "add `[[contact]]`, or `friction` to a hinge; or leave `margin` out");
        }
        return;
    }
    if table.has("path") {
        let message = "`statics.path` knows neither contact nor dry friction, and the scene has them";
        refuse("path", message, "leave `path` out, or take contact and friction out");
    }
    if table.text("method").is_some_and(|method| method != Method::Auto.name()) {
        let message = "this method of statics knows neither contact nor dry friction, and the scene has them";
        refuse("method", message, "leave `method` out, or take contact and friction out");
    }
}

pub(super) fn record(scenario: &Reader<'_>) -> crate::record::Settings {
    let default = crate::record::Settings::default();
    let Some(table) = scenario.table("record") else { return default };
    crate::record::Settings {
        rate: table.number("rate").unwrap_or(default.rate),
        ros: table.flag("ros").unwrap_or(default.ros),
    }
}

/// The instants of one controller in a run: at a microsecond each a quarter of an hour.
const MOST_INSTANTS: f64 = 1e9;

/// A controller that acts more often than any run could follow is refused before it.
pub(super) fn check_periods(scenario: &Reader<'_>, simulate: &Simulate, description: &Description) {
    for (table, one) in scenario.tables("controller").iter().zip(&description.controllers) {
        let instants = simulate.duration / one.period;
        if instants > MOST_INSTANTS {
            let message = format!(
                "controller `{}` acts every {:e} s: {instants:.1e} times in {} s, more than {MOST_INSTANTS:.0e}",
                one.name, one.period, simulate.duration
            );
            let finding = Finding::error(table.span_of("period"), message).label("too many instants");
            scenario.findings.push(finding.help("a period is in seconds, as `0.001` or `\"1 ms\"`"));
        }
    }
}

/// A recording that no disk would hold is refused before the run.
pub(super) fn check_samples(scenario: &Reader<'_>, simulate: &Simulate, record: &crate::record::Settings) {
    let samples = record.rate * simulate.duration;
    if samples <= MOST_SAMPLES {
        return;
    }
    let keys = [("record", "rate"), ("simulate", "duration")];
    let mut places = keys.iter().filter_map(|(table, key)| {
        scenario.table(table).filter(|table| table.has(key)).map(|table| table.span_of(key))
    });
    let message = format!(
        "{} samples per second for {} s are {samples:.1e} samples, more than {MOST_SAMPLES:.0e}",
        record.rate, simulate.duration
    );
    let place = places.next().unwrap_or_else(|| scenario.span.clone());
    let help = "lower `record.rate` or `simulate.duration`";
    scenario.findings.push(Finding::error(place, message).label("too many samples").help(help));
}
