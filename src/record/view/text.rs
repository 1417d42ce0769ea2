//! What statics found, as text beside the picture.

use serde_json::Value;
use std::fmt::Write;

/// Most modes and poses that are listed.
const MOST: usize = 12;

/// The statics result as Markdown; `None` if there is none.
pub(super) fn equilibrium(statics: Option<&str>) -> Option<String> {
    let found: Value = serde_json::from_str(statics?).ok()?;
    let mut text = String::new();
    let verdict = match (found["balanced"].as_bool(), found["stability"].as_str()) {
        (Some(false), _) | (None, None) => "No equilibrium".to_owned(),
        (_, Some(kind)) => format!("{}{} equilibrium", kind[..1].to_uppercase(), &kind[1..]),
        (_, None) => "Equilibrium".to_owned(),
    };
    // Writing to a `String` cannot fail.
    let _ = writeln!(text, "### {verdict}\n");
    if let (Some(stage), Some(steps)) = (found["stage"].as_str(), found["iterations"].as_u64()) {
        let _ = writeln!(text, "Found by {stage} in {steps} steps.\n");
    }
    if let Some(residual) = found["relative_residual"].as_f64() {
        let _ = writeln!(text, "Unbalanced: {residual:.1e} of the forces that cancel.\n");
    }
    list(&mut text, "Modes", found["modes"].as_array(), mode);
    let damped = |mode: &Value| {
        let decay = mode["decay_rate"].as_f64()?;
        Some(format!("{:.4} Hz, decays {decay:.4} /s", mode["frequency_hz"].as_f64()?))
    };
    list(&mut text, "Damped", found["damped_modes"].as_array(), damped);
    let unknowns = found["unknowns"].as_object().filter(|unknowns| !unknowns.is_empty());
    if let Some(unknowns) = unknowns {
        text.push_str("**Inputs**\n\n");
        for (name, value) in unknowns.iter().take(MOST) {
            let _ = writeln!(text, "- `{name}` = {value}");
        }
        text.push('\n');
    }
    list(&mut text, "Notes", found["notes"].as_array(), |note| note.as_str().map(str::to_owned));
    Some(text)
}

fn list(text: &mut String, title: &str, items: Option<&Vec<Value>>, line: impl Fn(&Value) -> Option<String>) {
    let lines: Vec<String> = items.into_iter().flatten().filter_map(line).collect();
    if lines.is_empty() {
        return;
    }
    let _ = writeln!(text, "**{title}**\n");
    for line in lines.iter().take(MOST) {
        let _ = writeln!(text, "- {line}");
    }
    if lines.len() > MOST {
        let _ = writeln!(text, "- … and {} more", lines.len() - MOST);
    }
    text.push('\n');
}

fn mode(mode: &Value) -> Option<String> {
    let shares = mode["hinges"].as_array().into_iter().flatten().take(2);
    let share = |share: &Value| Some(format!("{} {:.0} %", share["hinge"].as_str()?, 100.0 * share["share"].as_f64()?));
    let carriers: Vec<String> = shares.filter_map(share).collect();
    let rate = match mode["growth_rate"].as_f64() {
        Some(growth) if growth != 0.0 => format!("grows {growth:.4} /s"),
        _ => format!("{:.4} Hz", mode["frequency_hz"].as_f64()?),
    };
    Some(if carriers.is_empty() { rate } else { format!("{rate}: {}", carriers.join(", ")) })
}

/// What is shown from when on: the modes of a recording of modes, each at its time (s).
pub(super) fn captions(outcome: Option<&str>, statics: Option<&str>) -> Vec<(f64, String)> {
    let parse = |text: Option<&str>| text.and_then(|text| serde_json::from_str::<Value>(text).ok()).unwrap_or_default();
    let (outcome, statics) = (parse(outcome), parse(statics));
    let shown = outcome["modes"].as_array().into_iter().flatten().enumerate();
    let caption = |(index, shown): (usize, &Value)| {
        let told = mode(&statics["modes"][index]).or_else(|| mode(shown))?;
        Some((shown["from"].as_f64()?, format!("### Mode {}\n\n{told}\n", index + 1)))
    };
    shown.filter_map(caption).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATICS: &str = r#"{ "balanced": true, "stability": "stable", "stage": "newton", "iterations": 4,
        "relative_residual": 1.5e-16, "notes": ["left a saddle"], "unknowns": { "strut.length": 2.5 },
        "modes": [{ "frequency_hz": 1.25, "growth_rate": 0.0, "hinges": [{ "hinge": "arm", "share": 0.75 }] }] }"#;

    #[test]
    fn the_verdict_comes_first() {
        let text = equilibrium(Some(STATICS)).expect("a result");
        assert!(text.starts_with("### Stable equilibrium\n"), "{text}");
        for part in ["newton in 4 steps", "1.5e-16", "- 1.2500 Hz: arm 75 %", "`strut.length` = 2.5", "- left a saddle"]
        {
            assert!(text.contains(part), "no {part} in {text}");
        }
        assert_eq!(equilibrium(None), None);
        assert_eq!(equilibrium(Some("not JSON")), None);
    }

    #[test]
    fn each_mode_has_its_caption() {
        let outcome = r#"{ "modes": [{ "from": 0.0, "to": 2.0, "frequency_hz": 1.25, "growth_rate": 0.0 }] }"#;
        let captions = captions(Some(outcome), Some(STATICS));
        assert_eq!(captions, [(0.0, "### Mode 1\n\n1.2500 Hz: arm 75 %\n".to_owned())]);
        assert!(super::captions(Some(r#"{"end_time":2.0}"#), None).is_empty());
    }
}
