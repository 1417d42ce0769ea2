//! A curve as it is drawn: points, straight between each other.

use super::Guide;
use nalgebra::Vector3;

/// Pieces of equal length that a curve is looked at in: sixteen for each turn of a helix of 64.
const LOOKS: usize = 1024;
/// Points of a curve that is drawn are left out if it passes them by less than this part of its extent: in a picture of a thousand pixels
/// that is less than one.
const PASSED: f64 = 5e-4;
impl Guide {
    /// Points of the curve from its beginning to its end, straight between each other (m).
    pub fn outline(&self) -> Vec<Vector3<f64>> {
        let [from, to] = self.range();
        let place = |k: usize| self.at(from + (to - from) * k as f64 / LOOKS as f64).place;
        let points: Vec<Vector3<f64>> = (0..=LOOKS).map(place).collect();
        let (low, high) = points.iter().fold((points[0], points[0]), |(low, high), at| (low.inf(at), high.sup(at)));
        simplified(&points, PASSED * (high - low).amax())
    }
}

/// Points of a path that are needed so that no other point is further than `passed` (m) from the lines between them (Ramer, 1972; Douglas,
/// Peucker, 1973).
fn simplified(points: &[Vector3<f64>], passed: f64) -> Vec<Vector3<f64>> {
    let mut kept = vec![false; points.len()];
    let mut open = vec![(0, points.len() - 1)];
    while let Some((from, to)) = open.pop() {
        (kept[from], kept[to]) = (true, true);
        let away = |k: usize| {
            let (chord, at) = (points[to] - points[from], points[k] - points[from]);
            let square = chord.norm_squared();
            let part = if square > 0.0 { (at.dot(&chord) / square).clamp(0.0, 1.0) } else { 0.0 };
            (at - part * chord).norm()
        };
        let farthest = (from + 1..to).map(|k| (k, away(k))).max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((k, _)) = farthest.filter(|(_, away)| *away > passed) {
            open.extend([(from, k), (k, to)]);
        }
    }
    points.iter().zip(kept).filter(|(_, kept)| *kept).map(|(at, _)| *at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::guide::GuideCurve;

    fn drawn(curve: &GuideCurve) -> Vec<Vector3<f64>> {
        Guide::new(curve, true).expect("a curve").outline()
    }

    #[test]
    fn a_straight_curve_has_its_ends_alone_and_a_helix_stays_on_its_cylinder() {
        assert_eq!(drawn(&GuideCurve::Straight { length: 2.0 }), [Vector3::zeros(), Vector3::new(2.0, 0.0, 0.0)]);
        let helix = drawn(&GuideCurve::Helix { radius: 0.5, pitch: 0.1, turns: 3.0 });
        // Between points the chord passes its arc by less than half a thousandth of a metre.
        let middles = helix.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        for at in helix.iter().copied().chain(middles) {
            assert!((at.xy().norm() - 0.5).abs() < 6e-4, "{at}");
        }
        assert!(helix.len() < LOOKS / 2, "{}", helix.len());
    }
}
