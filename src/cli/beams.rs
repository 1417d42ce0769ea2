//! What beams bear, as text and as JSON.

use super::text::{number, without_noise};
use crate::dynamics::{BeamState, Fault, SectionForces, System};
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

/// By their names.
pub(super) fn json(beams: &[BeamState]) -> Value {
    let section = |one: &SectionForces| {
        let f = &one.forces;
        json!({ "s": one.s, "n": f[0], "qy": f[1], "qz": f[2], "t": f[3], "my": f[4], "mz": f[5] })
    };
    let beam = |beam: &BeamState| {
        let (p, q) = (beam.tip.translation.vector, beam.tip.rotation);
        let value = json!({
            "tip": { "position": [p.x, p.y, p.z], "quaternion": [q.w, q.i, q.j, q.k] },
            "sections": beam.sections.iter().map(section).collect::<Vec<_>>(),
            "discretization_error": beam.discretization_error,
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

/// Of a beam its tip and the largest moment, of a cable its tensions; and the discretization error. `length` is that of the scene (m).
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
        let error = number(beam.discretization_error);
        line("error", format!("{error} of the section forces (discretization)"));
    }
    lines.join("\n")
}
