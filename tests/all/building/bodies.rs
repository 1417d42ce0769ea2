//! Names, parents and mass properties.

use super::{ARM, HAND, TURN, assert_problem, body, force, load, on, problem_after, sound};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use stillpoint::model::description::*;
use stillpoint::model::{Description, Element, Model};

#[test]
fn names_must_be_unique_present_and_not_the_grounds() {
    assert_problem(HAND, "name", &["two bodies are called `arm`", "unique"], |d| {
        d.bodies[1] = body("arm", GROUND, TURN);
    });
    assert_problem(HAND, "name", &["name is empty"], |d| d.bodies[1].name.clear());
    assert_problem(HAND, "name", &["cannot be called `ground`", "inertial frame"], |d| {
        d.bodies[1].name = GROUND.to_owned();
    });
    assert_problem(Element::Force(1), "name", &["two forces are called `push`"], |d| {
        d.forces = vec![force("push", load(on("arm"))), force("push", load(on("hand")))];
    });
}

#[test]
fn unknown_parent_gets_the_nearest_name() {
    assert_problem(HAND, "hinge.parent", &["there is no body `amr`", "did you mean `arm`?"], |d| {
        d.bodies[1].hinge.parent = "amr".to_owned();
    });
    let found = problem_after(|d| d.bodies[1].hinge.parent = "elephant".to_owned());
    assert_eq!(found.help, None, "nothing is near");
    assert_problem(HAND, "hinge.parent", &["did you mean `ground`?"], |d| {
        d.bodies[1].hinge.parent = "Ground".to_owned();
    });
}

#[test]
fn parents_in_a_ring_are_listed_in_order() {
    let ring = |d: &mut Description| {
        d.bodies[1].hinge.parent = "finger".to_owned();
        d.bodies.push(body("palm", "hand", TURN));
        d.bodies.push(body("finger", "palm", TURN));
        d.bodies.push(body("nail", "finger", TURN));
    };
    let words = ["cycle: `hand` hangs on `finger` hangs on `palm` hangs on `hand`", "must hang on `ground`"];
    assert_problem(HAND, "hinge.parent", &words, ring);
    assert_problem(ARM, "hinge.parent", &["`arm` hangs on `arm`"], |d| d.bodies[0].hinge.parent = "arm".to_owned());
}

#[test]
fn masses_must_be_finite_and_not_negative() {
    assert_problem(ARM, "mass", &["the mass of `arm` is -1", "≥ 0 kg"], |d| d.bodies[0].mass.mass = -1.0);
    assert_problem(ARM, "mass", &["the mass of `arm` is NaN"], |d| d.bodies[0].mass.mass = f64::NAN);
    assert_problem(ARM, "mass", &["the mass of `arm` is inf"], |d| d.bodies[0].mass.mass = f64::INFINITY);
    assert_problem(ARM, "center", &["centre of mass of `arm`", "NaN"], |d| d.bodies[0].mass.center.x = f64::NAN);
    assert_problem(ARM, "markers.tip", &["marker `tip` of `arm`", "inf"], |d| {
        d.bodies[0].markers[0].1.z = f64::INFINITY;
    });
}

#[test]
fn inertia_must_be_that_of_some_body() {
    let moments = |x: f64, y: f64, z: f64| {
        move |d: &mut Description| d.bodies[0].mass.inertia = Matrix3::from_diagonal(&Vector3::new(x, y, z))
    };
    // 1 − (0.48207 + 0.48207) = 0.03586
    let words = ["no body can have the inertia of `arm`", "by 3.586 %", "about the centre of mass"];
    assert_problem(ARM, "inertia", &words, moments(0.48207, 1.0, 0.48207));
    assert_problem(ARM, "inertia", &["negative principal moment"], moments(1.0, -0.1, 1.0));
    assert_problem(ARM, "inertia", &["inertia of `arm` is not finite"], moments(1.0, f64::NAN, 1.0));
    assert_problem(ARM, "inertia", &["inertia of `arm` is not symmetric"], |d| d.bodies[0].mass.inertia[(0, 1)] = 0.1);
}

/// Off the axes too: 1.1 > 0.5 + 0.5 in principal axes only.
#[test]
fn inertia_is_judged_in_principal_axes() {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.9, -0.5)).to_rotation_matrix();
    let turned = |x: f64, y: f64, z: f64| turn * Matrix3::from_diagonal(&Vector3::new(x, y, z)) * turn.transpose();
    assert_problem(ARM, "inertia", &["by 9.091 %"], |d| d.bodies[0].mass.inertia = turned(1.1, 0.5, 0.5));
    let mut flat = sound();
    flat.bodies[0].mass.inertia = turned(0.7, 0.4, 0.3);
    assert!(Model::build(&flat).is_ok(), "rounding breaks the limit by less than one part in 10⁹");
}

/// A plate's largest moment is exactly the sum of the others; a rod's least is zero; a point has none.
#[test]
fn plates_rods_and_points_are_bodies() {
    for moments in [[0.1, 0.2, 0.1 + 0.2], [1.0 / 3.0, 1.0 / 3.0, 0.0], [0.0, 0.0, 0.0]] {
        let mut description = sound();
        description.bodies[0].mass.inertia = Matrix3::from_diagonal(&Vector3::from(moments));
        assert!(Model::build(&description).is_ok(), "{moments:?}");
    }
}

#[test]
fn inertia_needs_mass() {
    assert_problem(ARM, "mass", &["`arm` has inertia but no mass", "armature"], |d| d.bodies[0].mass.mass = 0.0);
}

#[test]
fn hinges_on_which_no_mass_hangs_need_armature() {
    let massless = |d: &mut Description, index: usize| {
        d.bodies[index].mass.mass = 0.0;
        d.bodies[index].mass.inertia = Matrix3::zeros();
    };
    let words = ["neither `hand` nor anything it carries has mass", "armature"];
    assert_problem(HAND, "mass", &words, |d| massless(d, 1));
    assert_problem(HAND, "mass", &words, |d| {
        massless(d, 1);
        d.bodies[1].hinge.kind = HingeKind::Cylindrical { axis: Vector3::x() };
        d.bodies[1].hinge.armature = vec![0.0, 0.1];
    });
    let mut carried = sound();
    massless(&mut carried, 0);
    assert!(Model::build(&carried).is_ok(), "the arm carries the hand");
    let mut rotor = sound();
    massless(&mut rotor, 1);
    rotor.bodies[1].hinge.armature = vec![0.1];
    assert!(Model::build(&rotor).is_ok(), "a rotor has inertia of its own");
    let mut welded = sound();
    massless(&mut welded, 1);
    welded.bodies[1].hinge.kind = HingeKind::Fixed;
    assert!(Model::build(&welded).is_ok(), "a weld leaves nothing undetermined");
}

/// What turns about a line through all of its mass, in every position: the last body of a branch.
#[test]
fn point_masses_that_turn_about_themselves_are_named() {
    let point = |d: &mut Description, index: usize, at: Vector3<f64>| {
        d.bodies[index].mass.center = at;
        d.bodies[index].mass.inertia = Matrix3::zeros();
    };
    let words = ["`hand` has no inertia about a line", "point mass on its own axis", "hand.armature=1e-6", "density"];
    let (axial, beside) = (Vector3::new(0.0, 0.3, 0.0), Vector3::new(0.3, 0.3, 0.0));
    assert_problem(HAND, "inertia", &words, |d| point(d, 1, axial));
    for kind in [HingeKind::Free, HingeKind::Spherical] {
        for at in [Vector3::zeros(), beside] {
            assert_problem(HAND, "inertia", &words, |d| {
                point(d, 1, at);
                d.bodies[1].hinge.kind = kind;
            });
        }
    }
    let fine = |change: &dyn Fn(&mut Description)| {
        let mut description = sound();
        change(&mut description);
        Model::build(&description).map(|_| ()).map_err(|problems| format!("{problems:?}"))
    };
    assert_eq!(fine(&|d| point(d, 1, beside)), Ok(()), "off its axis");
    assert_eq!(fine(&|d| point(d, 0, axial)), Ok(()), "it carries the hand");
    let slides = HingeKind::Prismatic { axis: Vector3::x() };
    let slide = |d: &mut Description| {
        point(d, 1, Vector3::zeros());
        d.bodies[1].hinge.kind = slides;
    };
    assert_eq!(fine(&slide), Ok(()), "a slide turns nothing");
    let rotor = |d: &mut Description| {
        point(d, 1, beside);
        d.bodies[1].hinge.kind = HingeKind::Spherical;
        d.bodies[1].hinge.armature = vec![1e-6; 3];
    };
    assert_eq!(fine(&rotor), Ok(()), "a rotor has inertia of its own");
}
