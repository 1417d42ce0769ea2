//! Curves of all kinds: arc length, frames and subspaces against differences.

use super::{Guide, GuideCurve};
use nalgebra::{Matrix3, Vector3, Vector6};

/// Numbers between −1 and 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn curve(random: &mut Random, kind: u64) -> GuideCurve {
    match kind % 4 {
        0 => GuideCurve::Straight { length: 1.5 + random.next() },
        1 => {
            let count = 3 + (4.0 * (1.0 + random.next())) as usize;
            let mut at = Vector3::zeros();
            let mut step = || {
                at += Vector3::new(0.6 + 0.2 * random.next(), 0.4 * random.next(), 0.4 * random.next());
                at
            };
            GuideCurve::Points { points: (0..count).map(|_| step()).collect() }
        }
        2 => GuideCurve::Helix { radius: 0.6 + 0.4 * random.next(), pitch: random.next(), turns: 2.2 + random.next() },
        _ => {
            let [a, b, c] = [0; 3].map(|_| random.next());
            let place = [format!("u + {a}*sin(u)/2"), format!("{b}*u^2 + exp(-u)"), format!("{c}*cos(2*u)")];
            GuideCurve::Formulas { parameter: "u".to_owned(), place, range: [-1.0, 2.0 + c] }
        }
    }
}

/// `Z` is the rate of turn and place, `Z'` and `Z''` are its derivatives, and the tangent is a unit vector: so is the
/// coordinate an arc length. Across the joints of pieces too.
#[test]
fn subspaces_are_derivatives() {
    for seed in 0..400 {
        let random = &mut Random(seed);
        let curve = curve(random, seed);
        let guide = Guide::new(&curve, seed % 3 > 0).unwrap();
        let [from, to] = guide.range();
        let inner = (guide.knots.len() > 2).then(|| guide.knots[1].s);
        let inside = from + (to - from) * (0.5 + 0.4 * random.next());
        for s in [Some(inside), inner].into_iter().flatten() {
            let (at, h) = (guide.at(s), 1e-3);
            let differences = |of: &dyn Fn(f64) -> Vector6<f64>| {
                (8.0 * (of(s + h) - of(s - h)) - of(s + 2.0 * h) + of(s - 2.0 * h)) / (12.0 * h)
            };
            let size = 1.0 + at.subspaces.iter().map(Vector6::norm).sum::<f64>().powi(2);
            let moved = |s: f64| {
                let near = guide.at(s);
                let spin: Matrix3<f64> = at.turn.tr_mul(&(near.turn - at.turn));
                let shift = at.turn.tr_mul(&(near.place - at.place));
                let axial = 0.5 * Vector3::new(spin.m32 - spin.m23, spin.m13 - spin.m31, spin.m21 - spin.m12);
                Vector6::new(shift.x, shift.y, shift.z, axial.x, axial.y, axial.z)
            };
            assert!((differences(&moved) - at.subspaces[0]).amax() < 1e-9 * size.powi(2), "{seed} {s}: {curve:?}");
            for k in 0..2 {
                let by_difference = differences(&|s| guide.at(s).subspaces[k]);
                let off = (by_difference - at.subspaces[k + 1]).amax();
                assert!(off < 1e-8 * size.powi(2), "{seed} {s} {k}: {off} {curve:?}");
            }
            assert!((at.turn.tr_mul(&at.turn) - Matrix3::identity()).amax() < 1e-13, "{seed}");
            if guide.follows() {
                let along = guide.along(guide.parameter(s).1).tangent[0];
                assert!((at.turn * Vector3::x() - along).amax() < 1e-13, "{seed}");
            }
        }
    }
}

/// A helix by its formulas is the helix; a circle of a thousand points is a circle.
#[test]
fn kinds_agree() {
    let place = ["0.5*cos(u)", "0.5*sin(u)", "0.2*u/(2*pi)"].map(str::to_owned);
    let formulas = GuideCurve::Formulas { parameter: "u".to_owned(), place, range: [0.0, 3.0 * std::f64::consts::TAU] };
    let helix = GuideCurve::Helix { radius: 0.5, pitch: 0.2, turns: 3.0 };
    let [by_formulas, helix] = [formulas, helix].map(|curve| Guide::new(&curve, true).unwrap());
    let length = 3.0 * (0.5 * std::f64::consts::TAU).hypot(0.2);
    for guide in [&by_formulas, &helix] {
        assert!((guide.range()[1] - length).abs() < 1e-13 * length, "{:?}", guide.range());
    }
    for i in 0..=50 {
        let [a, b] = [&by_formulas, &helix].map(|guide| guide.at(length * f64::from(i) / 50.0));
        assert!((a.place - b.place).norm() < 1e-13 && (a.turn - b.turn).norm() < 1e-12, "{i}");
    }
}

/// A step of a logistic function goes on level on both sides, where its exponential is too large for a number.
#[test]
fn steps_end_level() {
    for (text, height) in [("0.1/(1+exp(-1e3*u))", 0.1), ("0.05*tanh(sinh(800*u))", 0.1)] {
        let place = ["u".to_owned(), text.to_owned(), "0".to_owned()];
        let curve = GuideCurve::Formulas { parameter: "u".to_owned(), place, range: [-1.0, 2.0] };
        let guide = Guide::new(&curve, false).unwrap();
        let [from, to] = guide.range().map(|end| guide.at(end));
        assert!((to.place - from.place - Vector3::new(3.0, height, 0.0)).norm() < 1e-12, "{text}");
        assert!((from.subspaces[0] - to.subspaces[0]).amax() < 1e-14, "{text}");
    }
}

/// Kinks, cusps, places without a number, and curves without ends are refused.
#[test]
fn what_is_not_smooth_is_refused() {
    let formulas = |x: &str, y: &str, range| GuideCurve::Formulas {
        parameter: "u".to_owned(),
        place: [x.to_owned(), y.to_owned(), "0".to_owned()],
        range,
    };
    for (curve, says) in [
        (formulas("u", "abs(u - 0.3)", [-1.0, 1.0]), "smooth near parameter 0.3"),
        (formulas("u", "abs(u - 0.3)*(u - 0.3)", [-1.0, 1.0]), "smooth near parameter 0.3"),
        (formulas("(u-0.1)^2", "(u-0.1)^3", [-1.0, 1.0]), "smooth near parameter 0.1"),
        (formulas("u", "sqrt(u)", [-1.0, 1.0]), "no tangent at parameter -1"),
        (formulas("cos(u)", "sin(u)", [0.0, std::f64::consts::TAU]), "closes on itself"),
        (formulas("u", "v", [0.0, 1.0]), "`v`"),
        (formulas("u", "u", [1.0, 1.0]), "to 1"),
        (GuideCurve::Helix { radius: 0.1, pitch: 0.0, turns: 1.5 }, "closes on itself"),
        (GuideCurve::Straight { length: 0.0 }, "0 m long"),
        (GuideCurve::Points { points: vec![Vector3::x()] }, "1 point"),
        (GuideCurve::Points { points: vec![Vector3::x(), Vector3::x()] }, "at one place"),
    ] {
        let flaw = Guide::new(&curve, true).unwrap_err();
        assert!(flaw.message.contains(says), "{flaw:?}");
    }
}

/// A hump of half a metre on a way of a hundred: its arc length counts.
#[test]
fn what_is_narrow_has_its_arc_length() {
    let place = ["u".to_owned(), "0".to_owned(), "5.2*exp(-((u-37.3)/0.5)^2)".to_owned()];
    let hump = GuideCurve::Formulas { parameter: "u".to_owned(), place, range: [-5.0, 100.0] };
    let guide = Guide::new(&hump, false).expect("a curve");
    let slope = |u: f64| {
        let x = (u - 37.3) / 0.5;
        -2.0 * x / 0.5 * 5.2 * (-x * x).exp()
    };
    // The middle of many short pieces, from parameter 0 on.
    let (mut u, mut s, step) = (0.0, 0.0, 1e-4);
    while s < 60.0 {
        s += step * 1.0_f64.hypot(slope(u + 0.5 * step));
        u += step;
    }
    let found = guide.at(s).place.x;
    assert!((found - u).abs() < 1e-5, "{found} {u}");
}
