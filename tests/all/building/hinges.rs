//! Coordinates, axes and points of hinges.

use super::{ARM, HAND, assert_problem, at_marker, bushing, force, on, sound, spring};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use stillpoint::model::description::*;
use stillpoint::model::{Description, Element, Model};

#[test]
fn unknown_marker_gets_the_nearest_name_or_all_names() {
    let hang = |name: &str| {
        let name = name.to_owned();
        move |d: &mut Description| d.bodies[1].hinge.at = Point::Marker(name)
    };
    assert_problem(HAND, "hinge.at", &["`arm` has no marker `tpi`", "did you mean `tip`?"], hang("tpi"));
    assert_problem(HAND, "hinge.at", &["`arm` has no marker `shoulder`", "it has `tip`"], hang("shoulder"));
    assert_problem(ARM, "hinge.at", &["`ground` has no marker `tip`", "give coordinates"], |d| {
        d.bodies[0].hinge.at = Point::Marker("tip".to_owned());
    });
    assert_problem(Element::Force(0), "between[1]", &["`hand` has no marker `top`", "did you mean `tip`?"], |d| {
        d.forces = vec![force("band", spring([on("arm"), at_marker("hand", "top")]))];
    });
}

#[test]
fn lists_of_a_hinge_have_one_number_per_coordinate_or_velocity() {
    type Field = (&'static str, usize, fn(&mut HingeDescription) -> &mut Vec<f64>);
    let fields: [Field; 7] = [
        ("position", 7, |hinge| &mut hinge.position),
        ("velocity", 6, |hinge| &mut hinge.velocity),
        ("stiffness", 6, |hinge| &mut hinge.stiffness),
        ("damping", 6, |hinge| &mut hinge.damping),
        ("rest", 7, |hinge| &mut hinge.rest),
        ("armature", 6, |hinge| &mut hinge.armature),
        ("force", 6, |hinge| &mut hinge.force),
    ];
    for (name, count, field) in fields {
        let path = format!("hinge.{name}");
        let needed = format!("`{name}` of the free hinge of `hand` has 2 numbers, {count} are needed");
        assert_problem(HAND, &path, &[&needed], |d| {
            d.bodies[1].hinge.kind = HingeKind::Free;
            *field(&mut d.bodies[1].hinge) = vec![0.0, 0.0];
        });
        let words = [&format!("`{name}` of the hinge of `hand` is NaN"), "finite numbers"];
        assert_problem(HAND, &path, &words, |d| *field(&mut d.bodies[1].hinge) = vec![f64::NAN]);
    }
    for (name, field) in [("damping", fields[3].2), ("armature", fields[5].2)] {
        let words = [&format!("`{name}` of the hinge of `hand` is -0.5"), "≥ 0"];
        assert_problem(HAND, &format!("hinge.{name}"), &words, |d| *field(&mut d.bodies[1].hinge) = vec![-0.5]);
    }
    let mut softening = sound();
    softening.bodies[1].hinge.stiffness = vec![-0.5];
    assert!(Model::build(&softening).is_ok(), "a hinge spring may push away from its rest");
}

#[test]
fn quaternions_must_have_norm_one() {
    assert_problem(HAND, "hinge.position", &["hinge of `hand` has norm 2", "no turn is 1, 0, 0, 0"], |d| {
        d.bodies[1].hinge.kind = HingeKind::Spherical;
        d.bodies[1].hinge.position = vec![2.0, 0.0, 0.0, 0.0];
    });
    assert_problem(HAND, "hinge.rest", &["has norm 0"], |d| {
        d.bodies[1].hinge.kind = HingeKind::Free;
        d.bodies[1].hinge.rest = vec![0.0; 7];
    });
    let mut rounded = sound();
    rounded.bodies[1].hinge.kind = HingeKind::Spherical;
    rounded.bodies[1].hinge.position = vec![0.923880, 0.382683, 0.0, 0.0];
    assert!(Model::build(&rounded).is_ok(), "six digits are enough");
}

#[test]
fn axes_must_point_somewhere() {
    let kinds: [fn(Vector3<f64>) -> HingeKind; 3] = [
        |axis| HingeKind::Revolute { axis },
        |axis| HingeKind::Prismatic { axis },
        |axis| HingeKind::Cylindrical { axis },
    ];
    for kind in kinds {
        for axis in [Vector3::zeros(), Vector3::new(f64::NAN, 0.0, 1.0)] {
            let words = ["axis of the hinge of `hand`", "not zero"];
            assert_problem(HAND, "hinge.axis", &words, |d| d.bodies[1].hinge.kind = kind(axis));
        }
    }
    let universal = |axes| move |d: &mut Description| d.bodies[1].hinge.kind = HingeKind::Universal { axes };
    let zero = universal([Vector3::x(), Vector3::zeros()]);
    assert_problem(HAND, "hinge.axes", &["an axis of the universal hinge of `hand` is zero"], zero);
    let parallel = universal([Vector3::x(), -2.0 * Vector3::x()]);
    assert_problem(HAND, "hinge.axes", &["universal hinge of `hand` are parallel", "span a plane"], parallel);
}

#[test]
fn hinge_points_and_frames_must_be_finite() {
    assert_problem(HAND, "hinge.at", &["the hinge of `hand` is at [inf, 0, 0]"], |d| {
        d.bodies[1].hinge.at = Point::At(Vector3::new(f64::INFINITY, 0.0, 0.0));
    });
    let not_a_turn = UnitQuaternion::new_unchecked(Quaternion::new(f64::NAN, 0.0, 0.0, 0.0));
    assert_problem(HAND, "hinge.rpy", &["the hinge frame of `hand` is not a turn"], |d| {
        d.bodies[1].hinge.frame = not_a_turn;
    });
    assert_problem(Element::Force(0), "rpy", &["the axes of `mount` are not a turn"], |d| {
        let mut kind = bushing([on("arm"), on(GROUND)]);
        if let ForceKind::Bushing(Bushing { frame, .. }) = &mut kind {
            *frame = not_a_turn;
        }
        d.forces = vec![force("mount", kind)];
    });
}
