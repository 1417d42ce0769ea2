//! `[[force]]`: springs, bushings, ropes, curves, sliders and loads.

use super::body::Names;
use super::curve::{interpolation, points};
use super::findings::Finding;
use super::reader::{Reader, Value};
use crate::model::description::{
    Attachment, Bushing, Curve, ForceDescription, ForceKind, Load, LoadAxes, OverTime, Rope, Slider, Spring, Timeline,
};
use toml::de::DeValue;

/// What a force without a name is called.
fn default_name(index: usize) -> String {
    format!("force[{index}]")
}

/// Reads a `[[force]]`; `None` if too little of it is readable.
pub(super) fn force(table: &Reader<'_>, index: usize, bodies: &Names<'_>) -> Option<ForceDescription> {
    let name = table.text("name").map_or_else(|| default_name(index), str::to_owned);
    let kind = match table.text("type")? {
        "spring" => spring(table, &name, bodies)?,
        "bushing" => Bushing {
            between: between(table, bodies)?,
            frame: table.turn("rpy"),
            stiffness: six(table, "stiffness"),
            damping: six(table, "damping"),
            preload: six(table, "preload"),
        }
        .into(),
        "rope" => Rope {
            through: path(table, "through", bodies)?,
            stiffness: table.number("stiffness")?,
            length: table.number("length")?,
            damping: table.number("damping").unwrap_or(0.0),
        }
        .into(),
        "curve" => curve(table, &name, bodies)?,
        "slider" => {
            let on = end(table, table.value("on")?, bodies)?;
            let damping = table.number("damping").unwrap_or(0.0);
            Slider::new(on, table.text("along")?.to_owned(), table.number("stiffness")?, damping).into()
        }
        "load" => Load {
            on: end(table, table.value("on")?, bodies)?,
            force: table.vector("force").unwrap_or_default(),
            torque: table.vector("torque").unwrap_or_default(),
            axes: if table.text("axes") == Some("body") { LoadAxes::Body } else { LoadAxes::Inertial },
            over_time: table.table("over_time").and_then(|over_time| {
                let timeline = Timeline { times: over_time.numbers("times")? };
                Some(OverTime { timeline, values: over_time.numbers("values")? })
            }),
        }
        .into(),
        _ => return None,
    };
    Some(ForceDescription { name, kind })
}

fn spring(table: &Reader<'_>, name: &str, bodies: &Names<'_>) -> Option<ForceKind> {
    let stiffness = table.number("stiffness").unwrap_or(0.0);
    if stiffness > 0.0 && !table.has("length") {
        let message = format!("force `{name}`: `length` is missing beside `stiffness`");
        let help = "without its unstretched length [m] the tension of a spring is not known; write `length = 0.0` if it is meant";
        table.findings.push(Finding::error(table.key_span("stiffness"), message).help(help));
    }
    let spring = Spring {
        between: between(table, bodies)?,
        stiffness,
        length: table.number("length").unwrap_or(0.0),
        damping: table.number("damping").unwrap_or(0.0),
    };
    Some(spring.into())
}

fn curve(table: &Reader<'_>, name: &str, bodies: &Names<'_>) -> Option<ForceKind> {
    let (mut extension, mut rate) = (None, None);
    match table.table("force") {
        None => extension = Some(points(table, "force", &format!("force `{name}`: its curve"))?),
        Some(parts) => {
            for (key, found) in [("extension", &mut extension), ("rate", &mut rate)] {
                if parts.has(key) {
                    *found = Some(points(&parts, key, &format!("force `{name}`: its curve against the {key}"))?);
                }
            }
            if extension.is_none() && rate.is_none() {
                let message = format!("force `{name}`: `force` has neither `extension` nor `rate`");
                table.findings.push(Finding::error(parts.span, message));
                return None;
            }
        }
    }
    if extension.is_some() && !table.has("length") {
        let message = format!("force `{name}`: `length` is missing beside a curve against the extension");
        let help = "extension is distance less `length` [m]; write `length = 0.0` if it is the distance itself";
        table.findings.push(Finding::error(table.key_span("force"), message).help(help));
    }
    let curve = Curve {
        between: between(table, bodies)?,
        extension: extension.unwrap_or_default(),
        rate: rate.unwrap_or_default(),
        interpolation: interpolation(table),
        length: table.number("length").unwrap_or(0.0),
    };
    Some(curve.into())
}

pub(super) fn between(table: &Reader<'_>, bodies: &Names<'_>) -> Option<[Attachment; 2]> {
    match &table.value("between")?.get_ref().as_array()?[..] {
        [first, second] => Some([end(table, first, bodies)?, end(table, second, bodies)?]),
        _ => None,
    }
}

/// A list of points; `None` if one of them cannot be read.
fn path(table: &Reader<'_>, key: &str, bodies: &Names<'_>) -> Option<Vec<Attachment>> {
    table.value(key)?.get_ref().as_array()?.iter().map(|item| end(table, item, bodies)).collect()
}

pub(super) fn end(table: &Reader<'_>, value: Value<'_>, bodies: &Names<'_>) -> Option<Attachment> {
    match value.get_ref() {
        DeValue::String(text) => Some(bodies.attachment(text)),
        DeValue::Table(inner) => bodies.attachment_table(&Reader::new(inner, value.span(), table.findings)),
        _ => None,
    }
}

/// Six numbers, or three along and three about.
fn six(table: &Reader<'_>, key: &str) -> [f64; 6] {
    if let Some(list) = table.numbers(key) {
        return <[f64; 6]>::try_from(list).unwrap_or_default();
    }
    let Some(parts) = table.table(key) else { return [0.0; 6] };
    let three = |key: &str| match parts.number(key) {
        Some(number) => [number; 3],
        None => parts.vector(key).map_or([0.0; 3], Into::into),
    };
    let ([x, y, z], [a, b, c]) = (three("translation"), three("rotation"));
    [x, y, z, a, b, c]
}
