//! Whether a scene with friction or contact stands, in words and as JSON.

use super::number::{count, number};
use super::output::{bare, verdict};
use crate::contact::support::Verdict;
use crate::model::Model;
use crate::model::problem::significant;
use crate::statics::standing::{Giving, Interval, Mechanism, StandingReport};
use nalgebra::Vector3;
use serde_json::{Map, Value, json};
use std::fmt::Write;

/// Forces that use less than this part of their cone stick; the rest is at its limit.
const AT_THE_LIMIT: f64 = 1.0 - 1e-8;

/// What a contact does: open if it bears nothing, slipping at the limit of its cone.
fn mode(force: &Vector3<f64>, share: f64) -> &'static str {
    match share {
        _ if force.norm() == 0.0 => "open",
        share if share < AT_THE_LIMIT => "stick",
        _ => "slip",
    }
}

/// The key `standing`.
pub(super) fn json(model: &Model, standing: &StandingReport) -> Value {
    let of_contact = |one: &crate::statics::standing::ContactForce| {
        json!({
            "between": one.contact.bodies.map(|body| &model.bodies[body].name),
            "point": <[f64; 3]>::from(one.contact.point),
            "normal": <[f64; 3]>::from(one.contact.normal),
            "force": <[f64; 3]>::from(one.force),
            "mode": mode(&one.force, one.share),
            "use": one.share,
        })
    };
    let of_hinge = |one: &crate::statics::standing::FrictionForce| json!({ "hinge": bare(&one.hinge), "force": one.force, "use": one.share });
    let mut margins: Map<String, Value> =
        standing.margins.numbers.iter().map(|one| (one.name.clone(), range(one))).collect();
    if let Some(part) = standing.friction_margin {
        margins.insert("friction".to_owned(), json!({ "low": part, "high": null }));
    }
    if !standing.margins.tilt.is_empty() {
        let tilt = standing.margins.tilt.iter().map(|(name, value, _)| (name.clone(), finite(*value)));
        margins.insert("tilt".to_owned(), Value::Object(tilt.collect()));
    }
    json!({
        "verdict": standing.verdict.name(),
        "slack": standing.slack,
        "contacts": standing.contacts.len(),
        "self_stresses": standing.self_stresses,
        "forces": standing.contacts.iter().map(of_contact).collect::<Vec<_>>(),
        "hinges": standing.friction.iter().map(of_hinge).collect::<Vec<_>>(),
        "friction_margin": standing.friction_margin,
        "margins": margins,
        "squeeze": standing.squeeze,
        "mechanism": standing.mechanism.as_ref().map(mechanism),
        "certificate": {
            "unbalanced": standing.certificate.unbalanced,
            "outside": standing.certificate.outside,
            "gap": standing.certificate.gap,
        },
    })
}

/// The key `inputs`: ranges of unknown inputs.
pub(super) fn inputs(standing: &StandingReport) -> Value {
    let range = |one: &Interval| (one.name.clone(), json!(one.range.map(finite)));
    Value::Object(standing.margins.inputs.iter().map(range).collect())
}

/// JSON has no infinity: nothing limits it.
fn finite(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { Value::Null }
}

fn range(one: &Interval) -> Value {
    json!({ "low": finite(one.range[0]), "high": finite(one.range[1]) })
}

fn mechanism(mechanism: &Mechanism) -> Value {
    let giving = |list: &[Giving]| -> Vec<Value> {
        let one = |one: &Giving| match &one.names[..] {
            [hinge] => json!({ "hinge": hinge, "rate": one.rate }),
            names => json!({ "between": names, "rate": one.rate }),
        };
        list.iter().map(one).collect()
    };
    let body = |(name, v, w): &(String, Vector3<f64>, Vector3<f64>)| {
        (name.clone(), json!({ "velocity": <[f64; 3]>::from(*v), "angular_velocity": <[f64; 3]>::from(*w) }))
    };
    json!({
        "opens": giving(&mechanism.opens),
        "slides": giving(&mechanism.slides),
        "bodies": mechanism.bodies.iter().map(body).collect::<Map<_, _>>(),
    })
}

/// To a hundredth.
fn percent(part: f64) -> String {
    number((1e4 * part).round() / 100.0)
}

/// As [`percent`]; a part below that is no zero.
fn lack(part: f64) -> String {
    if part < 1e-4 { significant(100.0 * part, 2) } else { percent(part) }
}

/// What it stands on, in words.
fn supports(standing: &StandingReport) -> String {
    let bears = standing.contacts.iter().filter(|one| one.force.norm() > 0.0).count();
    match (standing.contacts.is_empty(), standing.friction.len()) {
        (true, 0) => "and touches nothing".to_owned(),
        (true, hinges) => format!("by the friction of {}", count(hinges, "hinge", "hinges")),
        (false, 0) => format!("on {}", count(bears, "contact", "contacts")),
        (false, hinges) => {
            format!(
                "on {} and the friction of {}",
                count(bears, "contact", "contacts"),
                count(hinges, "hinge", "hinges")
            )
        }
    }
}

/// The lines of a report; `elsewhere` if what does not stand as given has an equilibrium at another pose.
pub(super) fn text(model: &Model, standing: &StandingReport, elsewhere: bool) -> String {
    let mut out = String::new();
    let on = supports(standing);
    let stresses = match standing.self_stresses {
        0 => String::new(),
        n => format!(" ({})", count(n, "self-stress", "self-stresses")),
    };
    let said = verdict(standing.verdict.name(), standing.verdict == Verdict::Stands);
    let _ = match standing.verdict {
        Verdict::Stands => {
            writeln!(out, "  {said}       {on}{stresses}, {} % of the loads to spare", percent(standing.slack))
        }
        Verdict::Wedged => writeln!(
            out,
            "  {said}       {on}{stresses}: it stands only if it has been squeezed, with at least {} N",
            number(standing.squeeze.unwrap_or(0.0))
        ),
        Verdict::Falls => {
            let said = if elsewhere { format!("as given     it {said}:") } else { format!("{said}       ") };
            writeln!(out, "  {said} supports lack {} % of the loads", lack(-standing.slack))
        }
    };
    let gives = standing.mechanism.as_ref().map(ToString::to_string).unwrap_or_default();
    let _ = match (standing.verdict, standing.friction_margin) {
        (Verdict::Falls, Some(part)) => {
            writeln!(out, "  friction     would hold from {} % of its coefficients; now {gives}", percent(part))
        }
        (Verdict::Falls, None) => writeln!(out, "  friction     however large does not hold it; {gives}"),
        (_, Some(0.0)) => writeln!(out, "  friction     is not needed"),
        (_, Some(part)) => {
            writeln!(out, "  friction     holds down to {} % of its coefficients; then {gives}", percent(part))
        }
        (_, None) => Ok(()),
    };
    for (towards, value, _) in &standing.margins.tilt {
        let _ = match value.is_finite() {
            true => writeln!(out, "  tilt         to {:.2}° towards {towards}", value.atan().to_degrees()),
            false => writeln!(out, "  tilt         without end towards {towards}"),
        };
    }
    for one in standing.margins.numbers.iter().chain(&standing.margins.inputs) {
        let _ = writeln!(out, "  range        {} from {} to {}", one.name, number(one.range[0]), number(one.range[1]));
    }
    for one in standing.friction.iter().filter(|one| one.share > 0.0) {
        let force = one.force.iter().map(|f| number(*f)).collect::<Vec<_>>().join(", ");
        let unit = model.labelled(&one.hinge).map_or("", |at| model.force_unit(at));
        let _ =
            writeln!(out, "  holds        {}: {force} {unit} ({} % of its friction)", one.hinge, percent(one.share));
    }
    let mut pairs: Vec<([usize; 2], Vector3<f64>, f64)> = Vec::new();
    for one in &standing.contacts {
        match pairs.iter_mut().find(|(bodies, ..)| *bodies == one.contact.bodies) {
            Some((_, force, share)) => (*force, *share) = (*force + one.force, share.max(one.share)),
            None => pairs.push((one.contact.bodies, one.force, one.share)),
        }
    }
    let largest = pairs.iter().map(|(_, force, _)| force.amax()).fold(0.0, f64::max);
    for (bodies, force, share) in pairs.iter().take(MOST_PAIRS) {
        let [a, b] = bodies.map(|body| &model.bodies[body].name);
        // What the solver leaves of a zero is none.
        let said = |x: f64| number(if x.abs() > 1e-9 * largest { x } else { 0.0 });
        let [x, y, z] = [force.x, force.y, force.z].map(said);
        let _ = writeln!(
            out,
            "  contact      `{a}` pushes `{b}` with [{x}, {y}, {z}] N (up to {} % of the cone)",
            percent(*share)
        );
    }
    if pairs.len() > MOST_PAIRS {
        let _ = writeln!(out, "               … and {} more pairs (`--json` has all)", pairs.len() - MOST_PAIRS);
    }
    out
}

/// Pairs of bodies that a report lists.
const MOST_PAIRS: usize = 12;
