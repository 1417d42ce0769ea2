//! The harmonic response as numbers: how much each output swings by one of each input, and by how much later.

use super::bode::quotient;
use crate::cli::number::aligned;
use crate::linear::StateSpace;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// One pair of input and output at one frequency.
pub(super) struct Swing {
    hz: f64,
    input: String,
    output: String,
    unit: String,
    amplitude: f64,
    /// Of the output after the input, −180 to 180 (degrees).
    phase: f64,
}

/// All pairs, frequency by frequency (Hz). Drives count by how far they move.
pub(super) fn swings(found: &StateSpace, frequencies: &[f64]) -> Vec<Swing> {
    let mut all = Vec::new();
    for hz in frequencies {
        let response = found.transmissibility(TAU * hz);
        for (j, input) in found.inputs.iter().enumerate() {
            let of = match input.unit.as_str() {
                "m/s²" => "m",
                "rad/s²" => "rad",
                other => other,
            };
            for (i, output) in found.outputs.iter().enumerate() {
                let (re, im) = (response[(i, j)].re, response[(i, j)].im);
                let unit = if output.unit == of { "1".to_owned() } else { quotient(&output.unit, of) };
                all.push(Swing {
                    hz: *hz,
                    input: input.name.clone(),
                    output: output.name.clone(),
                    unit,
                    amplitude: re.hypot(im),
                    phase: im.atan2(re).to_degrees(),
                });
            }
        }
    }
    all
}

/// What is said of an amplitude that grows without bound.
const UNBOUNDED: &str = "nothing holds it back";

/// As `--json` has them. An amplitude that grows without bound is `null`, and `note` says so.
pub(super) fn json(swings: &[Swing]) -> Value {
    let one = |swing: &Swing| {
        let mut value = json!({
            "frequency_hz": swing.hz, "input": swing.input, "output": swing.output,
            "amplitude": swing.amplitude, "phase_deg": swing.phase, "unit": swing.unit,
        });
        if !swing.amplitude.is_finite() {
            value["note"] = UNBOUNDED.into();
        }
        value
    };
    swings.iter().map(one).collect()
}

/// The lines of the report.
pub(super) fn lines(swings: &[Swing]) -> String {
    let (sizes, phases) =
        (aligned(swings.iter().map(|swing| swing.amplitude)), aligned(swings.iter().map(|swing| swing.phase)));
    let pair = |swing: &Swing| format!("{} by {}", swing.output, swing.input);
    let widest = swings.iter().map(|swing| pair(swing).chars().count()).max().unwrap_or(0);
    let units = swings.iter().map(|swing| swing.unit.chars().count()).max().unwrap_or(0);
    let frequencies = aligned(swings.iter().map(|swing| swing.hz));
    let mut out = String::new();
    for (index, swing) in swings.iter().enumerate() {
        let head = if index == 0 { "response" } else { "" };
        let unit = if swing.unit == "1" { "" } else { &swing.unit };
        out += &format!("\n  {head:<12} {} Hz  {:<widest$}  ", frequencies[index], pair(swing));
        out += &match swing.amplitude.is_finite() {
            true => format!("{} {unit:<units$}  {}°", sizes[index], phases[index].trim_end()),
            false => UNBOUNDED.to_owned(),
        };
    }
    out
}
