//! `[[loop]]`, `[[drive]]`, `[[gear]]`.

use super::body::Names;
use super::force::between;
use super::formulas::formula;
use super::hinge::{axes, kind};
use super::quantities::Parameters;
use super::reader::{Reader, Value};
use crate::model::couplings::{
    Closure, CoordinateName, DriveDescription, GearDescription, GearKind, LoopDescription, MotionDescription,
};
use crate::model::prescribed;
use toml::de::DeValue;

pub(super) fn name(table: &Reader<'_>, what: &str, index: usize) -> String {
    table.text("name").map_or_else(|| format!("{what}[{index}]"), str::to_owned)
}

/// Reads a `[[loop]]`; `None` if too little of it is readable.
pub(super) fn closed_loop(table: &Reader<'_>, index: usize, bodies: &Names<'_>) -> Option<LoopDescription> {
    let closure = match table.text("type")? {
        "rod" => Closure::Rod { length: table.number("length")? },
        "universal" => {
            axes(table)?;
            Closure::Hinge(kind(table)?)
        }
        _ => Closure::Hinge(kind(table)?),
    };
    Some(LoopDescription {
        name: name(table, "loop", index),
        closure,
        between: between(table, bodies)?,
        frame: table.turn("rpy"),
        second_frame: table.has("rpy_second").then(|| table.turn("rpy_second")),
    })
}

/// Reads a `[[drive]]`; `None` if too little of it is readable.
pub(super) fn drive(table: &Reader<'_>, index: usize, parameters: &Parameters) -> Option<DriveDescription> {
    let name = name(table, "drive", index);
    let motion = motion(table, &format!("drive `{name}`"), parameters)?;
    Some(DriveDescription { name, coordinate: hinge_coordinate(table)?, motion })
}

/// `hinge` and `coordinate` of a table.
pub(super) fn hinge_coordinate(table: &Reader<'_>) -> Option<CoordinateName> {
    Some(CoordinateName { body: table.text("hinge")?.to_owned(), index: table.count("coordinate").unwrap_or(0) })
}

/// A motion of a drive or a motor's target.
pub(super) fn motion(table: &Reader<'_>, owner: &str, parameters: &Parameters) -> Option<MotionDescription> {
    Some(match table.text("type")? {
        "hold" => MotionDescription::Hold,
        "rate" => MotionDescription::Rate { rate: table.number("rate")? },
        "ramp" => MotionDescription::Ramp {
            to: table.number("to")?,
            begin: table.number("begin").unwrap_or(0.0),
            duration: table.number("duration")?,
        },
        "sine" => MotionDescription::Sine {
            offset: table.number("offset"),
            amplitude: table.number("amplitude")?,
            frequency: table.number("frequency")?,
            phase: table.number("phase").unwrap_or(0.0),
        },
        "table" => MotionDescription::Table { times: table.numbers("times")?, values: table.numbers("values")? },
        "expression" => {
            MotionDescription::Expression { text: formula(table, owner, &prescribed::VARIABLES, parameters)? }
        }
        _ => return None,
    })
}

/// Reads a `[[gear]]`; `None` if too little of it is readable.
pub(super) fn gear(table: &Reader<'_>, index: usize) -> Option<GearDescription> {
    let kind = match table.text("type")? {
        "ratio" => GearKind::Ratio { ratio: table.number("ratio")? },
        "rack" => GearKind::Rack { radius: table.number("radius")? },
        "screw" => GearKind::Screw { lead: table.number("lead")? },
        _ => return None,
    };
    let between = match &table.value("between")?.get_ref().as_array()?[..] {
        [first, second] => [coordinate(table, first)?, coordinate(table, second)?],
        _ => return None,
    };
    Some(GearDescription { name: name(table, "gear", index), between, kind, offset: table.number("offset") })
}

fn coordinate(table: &Reader<'_>, value: Value<'_>) -> Option<CoordinateName> {
    match value.get_ref() {
        DeValue::String(body) => Some(CoordinateName { body: body.as_ref().to_owned(), index: 0 }),
        DeValue::Table(inner) => {
            let inner = Reader::new(inner, value.span(), table.findings);
            hinge_coordinate(&inner)
        }
        _ => None,
    }
}
