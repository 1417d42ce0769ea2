//! How thick the coils of springs and the cylinders of dampers are.

use crate::record::Scene;
use crate::record::scene::LinePicture;

/// More springs than this are drawn as plain lines.
const MOST_COILS: usize = 32;

/// Radius of the coils of each spring and of the cylinder of each damper (m); `None` for what is drawn as a line.
pub(in crate::record) fn coil_radii(scene: &Scene, size: f64) -> Vec<Option<f64>> {
    let coiled = |line: &LinePicture| {
        let damper = line.is_damper.then_some(0.0);
        free_length(line).filter(|_| !line.pulls_only).or(damper)
    };
    let springs = scene.lines.iter().filter(|line| coiled(line).is_some()).count();
    let radius = |line: &LinePicture| {
        let length = coiled(line)?;
        let length = if length > 0.0 { length } else { 0.2 * size };
        (springs <= MOST_COILS).then(|| (0.05 * length).min(0.02 * size))
    };
    scene.lines.iter().map(radius).collect()
}

/// The free length of a spring (m).
pub(super) fn free_length(line: &LinePicture) -> Option<f64> {
    line.spring.map(|[_, length]| length).or(line.coil)
}
