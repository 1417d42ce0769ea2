//! Modal bodies as text and as JSON.

use super::text::{number, without_noise};
use crate::model::{ModalBody, Model};
use crate::spatial::Pose;
use serde_json::{Map, Value, json};

/// By their names: poses of the interfaces, coordinates, and whether they have geometric stiffness.
pub(super) fn json(model: &Model, position: &[f64], poses: &[Pose]) -> Value {
    let modal = |modal: &ModalBody| {
        let interface = |(body, tip): (&usize, &crate::element::modal::ModalTip)| {
            let (p, q) = (poses[*body].translation.vector, poses[*body].rotation);
            (tip.name.clone(), json!({ "position": [p.x, p.y, p.z], "quaternion": [q.w, q.i, q.j, q.k] }))
        };
        let first = model.links[modal.link].position;
        let coordinate = |(i, (name, _)): (usize, &(String, bool))| (name.clone(), json!(position[first + i]));
        let value = json!({
            "interfaces": modal.tips.iter().zip(&modal.modal.tips).map(interface).collect::<Map<_, _>>(),
            "coordinates": modal.modal.coordinates.iter().enumerate().map(coordinate).collect::<Map<_, _>>(),
            "geometric_stiffness": modal.modal.stiffens,
        });
        (modal.name.clone(), value)
    };
    Value::Object(model.modals.iter().map(modal).collect::<Map<_, _>>())
}

/// Where the interfaces are, and how far they have moved; `None` without modal bodies.
pub(super) fn text(model: &Model, position: &[f64], poses: &[Pose]) -> Option<String> {
    if model.modals.is_empty() {
        return None;
    }
    let mut lines = Vec::new();
    for modal in &model.modals {
        lines.push(format!("  {:<12} `{}`", "modal body", modal.name));
        let mut line = |what: &str, text: String| lines.push(format!("  {:<12} {what:<10} {text}", ""));
        let first = model.links[modal.link].position;
        for (tip, body) in modal.tips.iter().enumerate() {
            let p = poses[*body].translation.vector;
            let [x, y, z] = [p.x, p.y, p.z].map(|along| number(without_noise(along, model.length_scale())));
            let moved = position[first + 6 * tip..][..3].iter().map(|x| x * x).sum::<f64>().sqrt();
            line(&modal.modal.tips[tip].name, format!("{x} {y} {z} m, displaced by {} m", number(moved)));
        }
        if !modal.modal.stiffens {
            line("note", "no geometric stiffness: neither spin nor loads along it stiffen it".to_owned());
        }
    }
    Some(lines.join("\n"))
}
