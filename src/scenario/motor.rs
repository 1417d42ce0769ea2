//! `[[motor]]`.

use super::couplings::{hinge_coordinate, motion, name};
use super::formulas::formula;
use super::quantities::Parameters;
use super::reader::Reader;
use crate::model::couplings::MotionDescription;
use crate::model::motor::{self, MotorDescription, MotorLawDescription, Over, TargetDescription};

/// Reads a `[[motor]]`; `None` if too little of it is readable.
pub(super) fn motor(table: &Reader<'_>, index: usize, parameters: &Parameters) -> Option<MotorDescription> {
    let name = name(table, "motor", index);
    let owner = format!("motor `{name}`");
    let law = match table.text("type")? {
        "constant" => MotorLawDescription::Constant { force: table.number("force")? },
        "table" => {
            let over = if table.text("over")? == "speed" { Over::Speed } else { Over::Time };
            MotorLawDescription::Table { over, at: table.numbers("at")?, forces: table.numbers("forces")? }
        }
        "input" => MotorLawDescription::Input { force: table.number("force") },
        "pd" => MotorLawDescription::Pd {
            target: target(table, &owner, parameters)?,
            stiffness: table.number("stiffness").unwrap_or(0.0),
            damping: table.number("damping").unwrap_or(0.0),
            force: table.number("force").unwrap_or(0.0),
        },
        "expression" => {
            MotorLawDescription::Expression { text: formula(table, &owner, &motor::VARIABLES, parameters)? }
        }
        _ => return None,
    };
    let limit = table.number("limit");
    Some(MotorDescription { name, coordinate: hinge_coordinate(table)?, law, limit })
}

fn target(table: &Reader<'_>, owner: &str, parameters: &Parameters) -> Option<TargetDescription> {
    if !table.has("target") {
        return Some(TargetDescription::Motion(MotionDescription::Hold));
    }
    match table.table("target") {
        Some(inner) => motion(&inner, owner, parameters).map(TargetDescription::Motion),
        None => table.number("target").map(TargetDescription::Value),
    }
}
