//! Angle between two directions `a` and `b`: by how much `b` must be turned to come to `a`.
//!
//! ```text
//! (1) without an axis   φ = atan2(|b × a|, a·b),                    0 … π
//! (2) about n           φ = atan2(n·(b × a), a·b − (a·n)(b·n)),    −π … π
//! (3) δφ = (x δy − y δx) / (x² + y²)
//! ```
//!
//! (2) is the angle of the projections along `n`; by it the sign of a camber or a toe angle is known.

use super::question::{At, Measure, Variation};
use crate::model::output::AngleQuantity;
use nalgebra::Vector3;

impl AngleQuantity {
    /// a, b and n in inertial axes.
    fn directions(&self, at: &At<'_>) -> ([Vector3<f64>; 2], Option<Vector3<f64>>) {
        let links = &at.balanced.motion().links;
        let about = self.about.map(|about| links[self.directions[1].0].turn * about);
        (self.directions.map(|(link, direction)| links[link].turn * direction), about)
    }
}

impl Measure for AngleQuantity {
    fn value(&self, at: &At<'_>, out: &mut [f64]) {
        let ([a, b], about) = self.directions(at);
        let cross = b.cross(&a);
        out[0] = match about {
            None => cross.norm().atan2(a.dot(&b)),
            Some(n) => n.dot(&cross).atan2(a.dot(&b) - a.dot(&n) * b.dot(&n)),
        };
    }

    /// Without a sign there is none where the directions are parallel.
    fn vary(&self, at: &At<'_>, by: &Variation<'_>, out: &mut [f64]) -> bool {
        let ([a, b], about) = self.directions(at);
        let turns = self.directions.map(|(link, _)| by.links[link].turn);
        let (da, db) = (turns[0].cross(&a), turns[1].cross(&b));
        let (cross, varied) = (b.cross(&a), db.cross(&a) + b.cross(&da));
        let [x, y, dx, dy] = match about {
            None => {
                let size = cross.norm();
                [a.dot(&b), size, da.dot(&b) + a.dot(&db), cross.dot(&varied) / size]
            }
            Some(n) => {
                let dn = turns[1].cross(&n);
                let (an, bn) = (a.dot(&n), b.dot(&n));
                let dx = da.dot(&b) + a.dot(&db) - (da.dot(&n) + a.dot(&dn)) * bn - an * (db.dot(&n) + b.dot(&dn));
                [a.dot(&b) - an * bn, n.dot(&cross), dx, dn.dot(&cross) + n.dot(&varied)]
            }
        };
        out[0] = (x * dy - y * dx) / (x * x + y * y);
        out[0].is_finite()
    }
}
