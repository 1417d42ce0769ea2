//! Coordinates and velocities of a hinge. Of a ball's quaternion `δp = ½ p (0, δφ)`, with δφ in link axes.

use super::question::{At, Measure, Variation};
use crate::model::output::{CoordinateQuantity, RateQuantity};
use nalgebra::{Quaternion, Vector3};

impl Measure for CoordinateQuantity {
    fn value(&self, at: &At<'_>, out: &mut [f64]) {
        out.copy_from_slice(&at.balanced.position()[self.range.clone()]);
    }

    fn vary(&self, at: &At<'_>, by: &Variation<'_>, out: &mut [f64]) -> bool {
        let (q, step) = (at.balanced.position(), by.by.position);
        out.fill(0.0);
        if step.is_empty() {
            return true;
        }
        for link in &at.balanced.system().model().links {
            let (from, to) = (link.position, link.velocity);
            let mut put = |index: usize, change: f64| {
                if self.range.contains(&index) {
                    out[index - self.range.start] = change;
                }
            };
            match link.joint.counts().0 {
                // No output is a coordinate of a flexible element.
                _ if link.joint.is_flex() => {}
                0 => {}
                1 => put(from, step[to]),
                _ => {
                    let p = Quaternion::new(q[from], q[from + 1], q[from + 2], q[from + 3]);
                    let turn = Vector3::new(step[to], step[to + 1], step[to + 2]);
                    let change = p * Quaternion::from_imag(0.5 * turn);
                    [change.w, change.i, change.j, change.k]
                        .into_iter()
                        .enumerate()
                        .for_each(|(i, x)| put(from + i, x));
                }
            }
        }
        true
    }
}

impl Measure for RateQuantity {
    fn value(&self, at: &At<'_>, out: &mut [f64]) {
        out.copy_from_slice(&at.balanced.velocity()[self.range.clone()]);
    }

    fn vary(&self, _at: &At<'_>, by: &Variation<'_>, out: &mut [f64]) -> bool {
        match by.by.velocity {
            [] => out.fill(0.0),
            velocity => out.copy_from_slice(&velocity[self.range.clone()]),
        }
        true
    }
}
