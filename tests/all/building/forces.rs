//! Springs, bushings and loads.

use super::{assert_problem, at_marker, bushing, force, load, on, spring};
use nalgebra::{UnitQuaternion, Vector3};
use stillpoint::model::Element;
use stillpoint::model::description::*;

#[test]
fn both_ends_of_a_force_are_known_points_of_different_bodies() {
    let first = Element::Force(0);
    for kind in [spring as fn([Attachment; 2]) -> ForceKind, bushing] {
        assert_problem(first, "between", &["both ends of `band` are on `arm`", "does nothing"], |d| {
            d.forces = vec![force("band", kind([on("arm"), at_marker("arm", "tip")]))];
        });
        assert_problem(first, "between[0]", &["there is no body `hnad`", "did you mean `hand`?"], |d| {
            d.forces = vec![force("band", kind([on("hnad"), on(GROUND)]))];
        });
        assert_problem(first, "between[1]", &["coordinate that is not finite"], |d| {
            let nowhere = Point::At(Vector3::new(0.0, f64::NAN, 0.0));
            d.forces = vec![force("band", kind([on("arm"), Attachment { body: "hand".to_owned(), point: nowhere }]))];
        });
    }
    assert_problem(first, "on", &["there is no body `amr`", "did you mean `arm`?"], |d| {
        d.forces = vec![force("push", load(on("amr")))];
    });
    assert_problem(first, "on", &["`push` loads the ground", "acts on a body"], |d| {
        d.forces = vec![force("push", load(on(GROUND)))];
    });
}

#[test]
fn numbers_of_a_force_must_be_finite_and_those_of_springs_not_negative() {
    let first = Element::Force(0);
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        for field in ["stiffness", "length", "damping"] {
            let value = |name: &str| if name == field { bad } else { 1.0 };
            let kind = ForceKind::Spring(Spring {
                between: [on("arm"), on(GROUND)],
                stiffness: value("stiffness"),
                length: value("length"),
                damping: value("damping"),
            });
            let words = [&format!("`{field}` of `band` is {bad}"), "≥ 0"];
            assert_problem(first, field, &words, |d| d.forces = vec![force("band", kind)]);
        }
        for field in ["stiffness", "damping"] {
            let value = |name: &str| if name == field { [1.0, 1.0, 1.0, 1.0, bad, 1.0] } else { [1.0; 6] };
            let kind = ForceKind::Bushing(Bushing {
                between: [on("arm"), on(GROUND)],
                frame: UnitQuaternion::identity(),
                stiffness: value("stiffness"),
                damping: value("damping"),
                preload: [0.0; 6],
            });
            let words = [&format!("`{field}` of `mount` is {bad}"), "≥ 0"];
            assert_problem(first, field, &words, |d| d.forces = vec![force("mount", kind)]);
        }
    }
    let bad = Vector3::new(0.0, f64::NAN, 0.0);
    for (field, pair) in [("force", [bad, Vector3::x()]), ("torque", [Vector3::x(), bad])] {
        let [push, twist] = pair;
        let kind =
            ForceKind::Load(Load { on: on("arm"), force: push, torque: twist, axes: LoadAxes::Body, over_time: None });
        assert_problem(first, field, &[&format!("`{field}` of `push` is [0, NaN, 0]")], |d| {
            d.forces = vec![force("push", kind)];
        });
    }
}
