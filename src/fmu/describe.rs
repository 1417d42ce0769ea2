//! `modelDescription.xml`.

use super::{Role, Scene, Variable, Variables};
use crate::markup::escape;
use crate::quantity::Dimension;
use std::collections::BTreeSet;
use std::fmt::Write;

/// The model description of FMI 3.0, for co-simulation. `identifier` is a C identifier: what the library is called. `token` ties the
/// description to its resources.
pub fn describe(scene: &Scene, variables: &Variables, identifier: &str, token: &str) -> String {
    let scenario = &scene.scenario;
    let title = if scene.model.title.is_empty() { identifier } else { &scene.model.title };
    let mut out = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned();
    out += &format!(
        "<fmiModelDescription\n  fmiVersion=\"3.0\"\n  modelName=\"{}\"\n  instantiationToken=\"{}\"\n  \
         generationTool=\"stillpoint {}\">\n\n",
        attribute(title),
        attribute(token),
        env!("CARGO_PKG_VERSION")
    );
    out += &format!(
        "  <CoSimulation\n    modelIdentifier=\"{identifier}\"\n    canHandleVariableCommunicationStepSize=\"true\"\n    \
         canGetAndSetFMUState=\"true\"\n    canSerializeFMUState=\"true\"\n    providesDirectionalDerivatives=\"true\"/>\n\n"
    );
    units(&mut out, &variables.list);
    out += "  <LogCategories>\n    <Category name=\"logStatusError\" description=\"Why a call failed\"/>\n    \
            <Category name=\"logEvents\" description=\"Impacts, stops and events of the scene\"/>\n  </LogCategories>\n\n";
    out += &format!(
        "  <DefaultExperiment startTime=\"0\" stopTime=\"{:?}\" tolerance=\"{:?}\" stepSize=\"{:?}\"/>\n\n",
        scenario.simulate.duration,
        scenario.simulate.tolerance,
        1.0 / scenario.record.rate
    );
    out += "  <ModelVariables>\n";
    for (reference, variable) in variables.list.iter().enumerate() {
        out += &line(reference, variable);
    }
    out += "  </ModelVariables>\n\n  <ModelStructure>\n";
    for element in ["Output", "InitialUnknown"] {
        for reference in (0..variables.list.len()).filter(|at| is_output(&variables.list[*at])) {
            // Writing to a text never fails.
            let _ = writeln!(out, "    <{element} valueReference=\"{reference}\"/>");
        }
    }
    out + "  </ModelStructure>\n</fmiModelDescription>\n"
}

fn is_output(variable: &Variable) -> bool {
    match variable.role {
        Role::Time | Role::Input(_) | Role::Parameter => false,
        Role::Position(_) | Role::Velocity(_) | Role::Output(_) => true,
    }
}

fn line(reference: usize, variable: &Variable) -> String {
    let kind = match variable.role {
        Role::Time => "causality=\"independent\" variability=\"continuous\"",
        Role::Input(_) => "causality=\"input\" variability=\"continuous\"",
        Role::Parameter => "causality=\"parameter\" variability=\"fixed\" initial=\"exact\"",
        Role::Position(_) | Role::Velocity(_) | Role::Output(_) => {
            "causality=\"output\" variability=\"continuous\" initial=\"calculated\""
        }
    };
    let unit = match variable.unit.as_str() {
        "" => String::new(),
        unit => format!(" unit=\"{}\"", attribute(unit)),
    };
    let start = variable.start.map(|start| format!(" start=\"{start:?}\"")).unwrap_or_default();
    format!(
        "    <Float64 name=\"{}\" valueReference=\"{reference}\" {kind}{unit}{start}/>\n",
        attribute(&variable.name)
    )
}

/// Each unit once, with the powers of base units that it is made of.
fn units(out: &mut String, list: &[Variable]) {
    let all: BTreeSet<&str> = list.iter().map(|one| one.unit.as_str()).filter(|unit| !unit.is_empty()).collect();
    let power = |(symbol, power): (&str, i8)| match power {
        0 => String::new(),
        _ => format!(" {symbol}=\"{power}\""),
    };
    *out += "  <UnitDefinitions>\n";
    for unit in all {
        let base = match Dimension::of(unit) {
            Ok(dimension) => dimension.powers().map(power).concat(),
            // Of pure numbers.
            Err(_) if unit == "1" => String::new(),
            Err(_) => {
                *out += &format!("    <Unit name=\"{}\"/>\n", attribute(unit));
                continue;
            }
        };
        *out += &format!("    <Unit name=\"{}\"><BaseUnit{base}/></Unit>\n", attribute(unit));
    }
    *out += "  </UnitDefinitions>\n\n";
}

/// A text within an attribute: control characters are not allowed in XML 1.0, or read as a space.
fn attribute(text: &str) -> String {
    escape(&text.replace(char::is_control, " "))
}
