//! What beams bear, as text, as JSON and as diagrams.

pub(super) mod diagram;

use super::text::{count, number, small, without_noise};
use crate::dynamics::{BeamState, Discretization, Fault, SectionForces, System};
use crate::element::stress::Stress;
use crate::model::Model;
use crate::statics::{self, Equilibrium};
use serde_json::{Map, Value, json};
use std::sync::Arc;

/// The beams at a state of a run, with its accelerations.
pub(super) fn moving(model: &Arc<Model>, q: &[f64], v: &[f64]) -> Result<Vec<BeamState>, Fault> {
    if model.beams.is_empty() {
        return Ok(Vec::new());
    }
    let mut system = System::new(model);
    let (mut a, mut residual) = (vec![0.0; v.len()], vec![0.0; v.len()]);
    let mut at = system.at(0.0, q, v);
    at.accelerations(&mut a)?;
    at.share_multipliers()?;
    Ok(at.residual(&a, &mut residual)?.beams())
}

/// Section forces whose error is this part of the largest are good enough for most uses.
const ENOUGH: f64 = 1e-3;

/// By their names.
pub(super) fn json(beams: &[BeamState]) -> Value {
    let section = |one: &SectionForces| {
        let f = &one.forces;
        let mut value = json!({ "s": one.s, "n": f[0], "qy": f[1], "qz": f[2], "t": f[3], "my": f[4], "mz": f[5] });
        if let Some(stress) = &one.stress {
            value["stress"] = stress.von_mises.into();
        }
        value
    };
    let stress = |(s, stress): &(f64, Stress)| json!({ "max": stress.von_mises, "s": s, "at": stress.at, "normal": stress.normal, "shear": stress.shear });
    let beam = |beam: &BeamState| {
        let (p, q) = (beam.tip.translation.vector, beam.tip.rotation);
        let value = json!({
            "tip": { "position": [p.x, p.y, p.z], "quaternion": [q.w, q.i, q.j, q.k] },
            "sections": beam.sections.iter().map(section).collect::<Vec<_>>(),
            "stress": beam.stress.as_ref().map(stress),
            "discretization_error": beam.error.forces,
            "deflection_error": beam.error.deflections,
            "elements": beam.error.elements,
            "elements_advised": beam.error.elements_for(ENOUGH),
            "elements_advised_at_least": !beam.error.is_asymptotic(),
            "largest_turn": beam.error.turn,
            "strains": beam.strains,
        });
        (beam.name.clone(), value)
    };
    Value::Object(beams.iter().map(beam).collect::<Map<_, _>>())
}

/// The beams of an equilibrium as text; `None` without beams.
pub(super) fn found(model: &Arc<Model>, found: &Equilibrium) -> Result<Option<String>, Fault> {
    let beams = statics::beams(model, found)?;
    Ok((!beams.is_empty()).then(|| text(&beams, model.length_scale())))
}

/// Of a beam its tip and the largest moment, of a cable its tensions; the largest stress, and the discretization error. `length` is that
/// of the scene (m).
fn text(beams: &[BeamState], length: f64) -> String {
    let mut lines = Vec::new();
    for beam in beams {
        lines.push(format!("  {:<12} `{}`", if beam.is_cable { "cable" } else { "beam" }, beam.name));
        let mut line = |what: &str, text: String| lines.push(format!("  {:<12} {what:<10} {text}", ""));
        let by = |of: &dyn Fn(&SectionForces) -> f64| beam.sections.iter().max_by(|a, b| of(a).total_cmp(&of(b)));
        let moment = |section: &SectionForces| section.forces.fixed_rows::<3>(3).norm();
        if beam.is_cable {
            let tension = |section: &SectionForces| section.forces[0];
            if let (Some(least), Some(most)) = (by(&|section| -tension(section)), by(&tension)) {
                let [least, most] =
                    [least, most].map(|at| format!("{} N at s = {} m", number(tension(at)), number(at.s)));
                line("tension", format!("{least} to {most}"));
            }
        } else {
            let p = beam.tip.translation.vector;
            let [x, y, z] = [p.x, p.y, p.z].map(|along| number(without_noise(along, length)));
            line("tip", format!("{x} {y} {z} m"));
            if let Some(most) = by(&moment) {
                line("moment", format!("{} N m at s = {} m", number(moment(most)), number(most.s)));
            }
        }
        if let Some((s, stress)) = &beam.stress {
            line("stress", stress_text(*s, stress));
        }
        line("error", error_text(&beam.error));
    }
    lines.join("\n")
}

/// Von Mises' stress, where it is and what it consists of.
fn stress_text(s: f64, stress: &Stress) -> String {
    let [y, z] = stress.at.map(|x| number(without_noise(x * 1e3, stress.at[0].hypot(stress.at[1]) * 1e3)));
    let parts = match stress.shear.abs() > 1e-3 * stress.von_mises {
        true => format!(": normal {}, shear {}", number(stress.normal * 1e-6), number(stress.shear * 1e-6)),
        false => format!(", {}", if stress.normal < 0.0 { "compression" } else { "tension" }),
    };
    format!("{} MPa at s = {} m, y = {y} mm, z = {z} mm{parts}", number(stress.von_mises * 1e-6), number(s))
}

/// Both errors, and how many elements are enough.
fn error_text(error: &Discretization) -> String {
    if error.idle {
        return "none: no section force is above round-off".to_owned();
    }
    let elements = |n: usize| count(n, "element", "elements");
    let advised = error.elements_for(ENOUGH);
    let advice = match (error.is_asymptotic(), advised <= error.elements) {
        (true, true) => format!("{} would have 1e-3 of the forces", elements(advised)),
        (true, false) => format!("{} are needed for 1e-3 of the forces", elements(advised)),
        (false, true) => "too few to say how many have 1e-3 of the forces".to_owned(),
        (false, false) => format!("at least {} are needed for 1e-3 of the forces", elements(advised)),
    };
    format!(
        "{} of the section forces, {} of deflections, by {}; {advice}",
        small(error.forces),
        small(without_noise(error.deflections, 1.0)),
        elements(error.elements)
    )
}
