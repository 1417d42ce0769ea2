//! `[simulate]`, `[statics]` and `[record]`.

use super::findings::Finding;
use super::reader::Reader;
use crate::simulate::settings::{Integrator, Settings as Simulate, Start};
use crate::statics::settings::{Method, Settings as Statics, Want};

/// The samples of a run: with a few coordinates a recording of tens of gigabytes.
const MOST_SAMPLES: f64 = 1e8;

pub(super) fn simulate(scenario: &Reader<'_>) -> Simulate {
    let mut settings = Simulate::default();
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
    settings.time_limit = table.number("time_limit").unwrap_or(settings.time_limit);
    settings
}

pub(super) fn record(scenario: &Reader<'_>) -> crate::record::Settings {
    let default = crate::record::Settings::default();
    let Some(table) = scenario.table("record") else { return default };
    crate::record::Settings {
        rate: table.number("rate").unwrap_or(default.rate),
        ros: table.flag("ros").unwrap_or(default.ros),
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
