//! What the accelerations say when they cannot be computed: which number, of which element.

use crate::common::{build, take_inertia};
use nalgebra::{Matrix3, Vector3};
use stillpoint::dynamics::{Fault, System};
use stillpoint::model::Description;
use stillpoint::model::description::*;

/// `arm` on the ground, `hand` on the arm, a spring from the ground to the hand whose ends meet on the axis of both hinges.
fn scene(length: f64) -> Description {
    let body = |name: &str, parent: &str| BodyDescription {
        name: name.to_owned(),
        mass: MassProperties { mass: 1.0, center: Vector3::x(), inertia: Matrix3::identity() },
        markers: Vec::new(),
        shapes: Vec::new(),
        hinge: HingeDescription {
            parent: parent.to_owned(),
            ..HingeDescription::new(HingeKind::Revolute { axis: Vector3::y() })
        },
    };
    let end = |body: &str| Attachment { body: body.to_owned(), point: Point::At(Vector3::new(0.0, 0.3, 0.0)) };
    let between = [end(GROUND), end("hand")];
    let kind = ForceKind::Spring(Spring { between, stiffness: 10.0, length, damping: 1.0 });
    let forces = vec![ForceDescription { name: "band".to_owned(), kind }];
    Description { bodies: vec![body("arm", GROUND), body("hand", "arm")], forces, ..Description::default() }
}

fn faults(length: f64, q: [f64; 2], v: [f64; 2]) -> [Fault; 2] {
    let model = build(&scene(length));
    let mut system = System::new(&model);
    let mut out = [0.0; 2];
    let accelerations = system.at(0.0, &q, &v).accelerations(&mut out).unwrap_err();
    [accelerations, system.at(0.0, &q, &v).residual(&[0.0; 2], &mut out).unwrap_err()]
}

/// Not the hand's, which merely goes with it, nor the spring's.
#[test]
fn a_position_that_is_no_number_is_named_by_its_hinge() {
    for fault in faults(0.0, [f64::NAN, 0.1], [0.0; 2]) {
        assert_eq!(fault.to_string(), "the position of `arm` is not a finite number");
    }
}

#[test]
fn a_velocity_that_is_no_number_is_named_by_its_hinge() {
    for fault in faults(0.0, [0.1, 0.2], [0.0, f64::INFINITY]) {
        assert_eq!(fault.to_string(), "the velocity of `hand` is not a finite number");
    }
}

/// Both ends of the spring lie on the axis of both hinges: it has no direction.
#[test]
fn a_spring_whose_ends_meet_is_named() {
    for fault in faults(0.5, [0.1, 0.2], [0.0; 2]) {
        assert!(fault.to_string().starts_with("both ends of `band` are in one place"), "{fault}");
    }
}

/// A point mass on the axis of its own hinge: nothing resists the turn. (A model is refused that has one at its end: it is
/// taken from the link here.)
#[test]
fn a_hinge_that_nothing_resists_is_named() {
    let mut description = scene(0.0);
    description.bodies[1].hinge.kind = HingeKind::Revolute { axis: Vector3::x() };
    let mut model = build(&description);
    take_inertia(&mut model, "hand");
    let fault = System::new(&model).at(0.0, &[0.3, 0.2], &[0.0; 2]).accelerations(&mut [0.0; 2]).unwrap_err();
    assert!(matches!(&fault, Fault::Singular { body, .. } if body == "hand"), "{fault}");
}
