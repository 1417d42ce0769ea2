//! Springs and dampers by tables in hinge coordinates.
//!
//! ```text
//! spring  τ = −f(q − rest);    potential ∫₀ f
//! damper  τ = −g(q̇);           potential g(0) (q − rest), dissipated (g(q̇) − g(0)) q̇
//! ```

use crate::model::motor::Push;
use crate::model::{CurveOver, HingeCurve};

/// What one of them pushes its coordinate with.
pub(super) fn push(curve: &HingeCurve, q: &[f64], v: &[f64]) -> Push {
    let (q, v) = (q[curve.coordinate.position], v[curve.coordinate.velocity]);
    match curve.over {
        CurveOver::Position => {
            let [force, slope] = curve.table.value(q - curve.rest);
            Push { force: -force, by_position: -slope, by_velocity: 0.0 }
        }
        CurveOver::Velocity => {
            let [force, slope] = curve.table.value(v);
            Push { force: -force, by_position: 0.0, by_velocity: -slope }
        }
    }
}

pub(super) fn potential(curves: &[HingeCurve], q: &[f64]) -> f64 {
    let of = |curve: &HingeCurve| {
        let far = q[curve.coordinate.position] - curve.rest;
        match curve.over {
            CurveOver::Position => curve.table.integral(far),
            CurveOver::Velocity => curve.at_rest * far,
        }
    };
    curves.iter().map(of).sum()
}

/// Power taken out by those that take out, and put in by those that put in (W), each ≥ 0.
pub(super) fn powers(curves: &[HingeCurve], v: &[f64]) -> [f64; 2] {
    let dampers = curves.iter().filter(|curve| curve.over == CurveOver::Velocity);
    dampers.fold([0.0; 2], |[out, input], curve| {
        let v = v[curve.coordinate.velocity];
        let power = (curve.table.value(v)[0] - curve.at_rest) * v;
        [out + power.max(0.0), input + (-power).max(0.0)]
    })
}
