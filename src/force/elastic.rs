//! The numbers of a force element that has a stiffness and an unstretched length, as addresses reach them.

/// The number that a key names, with its unit; an empty list for another key.
pub(super) fn numbers(stiffness: f64, length: f64, key: &str) -> Vec<(f64, &'static str)> {
    match key {
        "stiffness" => vec![(stiffness, "N/m")],
        "length" => vec![(length, "m")],
        _ => Vec::new(),
    }
}

/// Sets the number that a key names; another key, which [`numbers`] does not have, changes nothing.
pub(super) fn set(stiffness: &mut f64, length: &mut f64, key: &str, value: f64) {
    match key {
        "stiffness" => *stiffness = value,
        "length" => *length = value,
        _ => {}
    }
}
