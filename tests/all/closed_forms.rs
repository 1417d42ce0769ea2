//! Accelerations against formulas derived by hand or found in every textbook.
//!
//! Tolerance throughout: a few tens of roundings on numbers of order one to ten, 1e-13.

use crate::common::build;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use stillpoint::dynamics::System;
use stillpoint::model::Description;
use stillpoint::model::description::*;
use stillpoint::spatial::Wrench;

const GRAVITY: f64 = 9.80665;
const TOLERANCE: f64 = 1e-13;

/// A body at the end of a list; gravity is the default, along −z.
fn body(
    name: &str,
    parent: &str,
    kind: HingeKind,
    mass: f64,
    center: Vector3<f64>,
    moments: [f64; 3],
) -> BodyDescription {
    let inertia = Matrix3::from_diagonal(&Vector3::from(moments));
    BodyDescription {
        name: name.to_owned(),
        mass: MassProperties { mass, center, inertia },
        markers: Vec::new(),
        shapes: Vec::new(),
        hinge: HingeDescription { parent: parent.to_owned(), ..HingeDescription::new(kind) },
    }
}

fn scene(bodies: Vec<BodyDescription>) -> Description {
    Description { bodies, ..Description::default() }
}

/// Accelerations and reactions at the start.
fn start(description: &Description) -> (Vec<f64>, Vec<Wrench>) {
    let model = build(description);
    let mut system = System::new(&model);
    let (q, v) = (&model.start_position, &model.start_velocity);
    let (mut a, mut residual, mut reactions) = (v.clone(), v.clone(), Vec::new());
    let mut at = system.at(0.0, q, v);
    at.accelerations(&mut a).unwrap();
    at.residual(&a, &mut residual).unwrap().reactions(&mut reactions);
    (a, reactions)
}

fn assert_near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= TOLERANCE * (1.0 + b.abs()));
    assert!(near, "{found:?} is not {expected:?}");
}

/// θ̈ = −m g l sin θ / (J + m l²); the bearing carries the weight and the centripetal force.
#[test]
fn compound_pendulum_swings_by_its_moment_about_the_bearing() {
    let (m, l, j, angle, rate) = (1.7_f64, 0.6_f64, 0.05_f64, 0.8_f64, 1.3_f64);
    let turn = HingeKind::Revolute { axis: Vector3::new(0.0, -2.0, 0.0) };
    let mut pendulum = body("pendulum", GROUND, turn, m, Vector3::new(0.0, 0.0, -l), [0.06, j, 0.02]);
    pendulum.hinge.position = vec![angle];
    pendulum.hinge.velocity = vec![rate];
    let (a, reactions) = start(&scene(vec![pendulum]));
    let expected = -m * GRAVITY * l * angle.sin() / (j + m * l * l);
    assert_near(&a, &[expected]);
    // About −y a positive angle leads from −z to +x.
    let (outward, along) = (Vector3::new(angle.sin(), 0.0, -angle.cos()), Vector3::new(angle.cos(), 0.0, angle.sin()));
    let force = m * (l * expected * along - l * rate * rate * outward + GRAVITY * Vector3::z());
    assert_near(reactions[0].force.as_slice(), force.as_slice());
    assert_near(reactions[0].moment.as_slice(), &[0.0; 3]);
}

/// The textbook equations of the double pendulum of point masses in absolute angles.
#[test]
fn double_pendulum_follows_the_textbook() {
    let (m1, m2, l1, l2) = (1.2, 0.7, 0.9, 0.5);
    let (t1, t2, w1, w2) = (0.7_f64, -0.4_f64, 1.1_f64, 2.3_f64);
    let turn = HingeKind::Revolute { axis: -Vector3::y() };
    let mut upper = body("upper", GROUND, turn, m1, Vector3::new(0.0, 0.0, -l1), [0.0; 3]);
    let mut lower = body("lower", "upper", turn, m2, Vector3::new(0.0, 0.0, -l2), [0.0; 3]);
    lower.hinge.at = Point::At(Vector3::new(0.0, 0.0, -l1));
    (upper.hinge.position, upper.hinge.velocity) = (vec![t1], vec![w1]);
    (lower.hinge.position, lower.hinge.velocity) = (vec![t2 - t1], vec![w2 - w1]);
    let (a, _) = start(&scene(vec![upper, lower]));
    let (s, c) = (t1 - t2).sin_cos();
    let shared = 2.0 * m1 + m2 - m2 * (2.0 * (t1 - t2)).cos();
    let first = (-GRAVITY * (2.0 * m1 + m2) * t1.sin()
        - m2 * GRAVITY * (t1 - 2.0 * t2).sin()
        - 2.0 * s * m2 * (w2 * w2 * l2 + w1 * w1 * l1 * c))
        / (l1 * shared);
    let second =
        2.0 * s * (w1 * w1 * l1 * (m1 + m2) + GRAVITY * (m1 + m2) * t1.cos() + w2 * w2 * l2 * m2 * c) / (l2 * shared);
    assert_near(&a, &[first, second - first]);
}

/// Two weights over a drum: the other weight and the drum's inertia are armature, the other weight's pull a motor.
#[test]
fn atwood_machine_is_a_slide_with_armature() {
    let (m1, m2, drum, radius) = (3.0, 2.0, 0.04, 0.2);
    let slide = HingeKind::Prismatic { axis: -Vector3::z() };
    let mut weight = body("weight", GROUND, slide, m1, Vector3::zeros(), [0.0; 3]);
    weight.hinge.armature = vec![m2 + drum / (radius * radius)];
    weight.hinge.force = vec![-m2 * GRAVITY];
    let (a, _) = start(&scene(vec![weight]));
    assert_near(&a, &[(m1 - m2) * GRAVITY / (m1 + m2 + drum / (radius * radius))]);
}

/// A block on a wedge that is free to slide: A = −m g sin α cos α / (M + m sin² α), s̈ = (M + m) g sin α / (M + m sin² α).
#[test]
fn block_and_wedge_push_each_other_aside() {
    let (wedge_mass, m, alpha) = (5.0, 1.5, 0.5_f64);
    let (s, c) = alpha.sin_cos();
    let wedge =
        body("wedge", GROUND, HingeKind::Prismatic { axis: Vector3::x() }, wedge_mass, Vector3::zeros(), [0.1; 3]);
    let slope = HingeKind::Prismatic { axis: Vector3::new(c, 0.0, -s) };
    let mut block = body("block", "wedge", slope, m, Vector3::new(0.1, 0.0, 0.2), [0.02; 3]);
    block.hinge.velocity = vec![4.0];
    let (a, _) = start(&scene(vec![wedge, block]));
    let shared = wedge_mass + m * s * s;
    assert_near(&a, &[-m * GRAVITY * s * c / shared, (wedge_mass + m) * GRAVITY * s / shared]);
}

/// A bead on a turning rod: s̈ = s θ̇², (J + m s²) θ̈ = −2 m s ṡ θ̇.
#[test]
fn bead_on_a_turning_rod_feels_centrifugal_and_coriolis_forces() {
    let (j, m, s, slip, rate) = (0.3, 0.4, 0.7, 1.5, 2.0);
    let mut rod = body("rod", GROUND, HingeKind::Revolute { axis: Vector3::z() }, 1.0, Vector3::zeros(), [0.2, 0.2, j]);
    rod.hinge.velocity = vec![rate];
    let mut bead = body("bead", "rod", HingeKind::Prismatic { axis: Vector3::x() }, m, Vector3::zeros(), [0.0; 3]);
    (bead.hinge.position, bead.hinge.velocity) = (vec![s], vec![slip]);
    let (a, _) = start(&scene(vec![rod, bead]));
    assert_near(&a, &[-2.0 * m * s * slip * rate / (j + m * s * s), s * rate * rate]);
}

/// Euler's equations for the spin; the centre of mass falls.
#[test]
fn spinning_free_body_obeys_eulers_equations_and_its_centre_falls() {
    let moments = Vector3::new(0.3, 0.4, 0.6);
    let (center, spin) = (Vector3::new(0.2, -0.1, 0.3), Vector3::new(1.0, -2.0, 0.5));
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.4, 1.1, -0.7));
    let mut stone = body("stone", GROUND, HingeKind::Free, 2.5, center, moments.into());
    stone.hinge.position = vec![1.0, 2.0, 3.0, turn.w, turn.i, turn.j, turn.k];
    stone.hinge.velocity = vec![3.0, 0.5, -1.0, spin.x, spin.y, spin.z];
    let (a, reactions) = start(&scene(vec![stone]));
    let turning = -spin.cross(&moments.component_mul(&spin)).component_div(&moments);
    let from_center = turn * (turning.cross(&center) + spin.cross(&spin.cross(&center)));
    let falling = -GRAVITY * Vector3::z() - from_center;
    assert_near(&a, &[falling.x, falling.y, falling.z, turning.x, turning.y, turning.z]);
    assert!(reactions[0].force.norm() + reactions[0].moment.norm() < 1e-12);
}

/// A plate on ice, turned by a motor in its hinge: nothing pushes it sideways, so its centre of mass does not accelerate
/// and J θ̈ = τ; the root marker circles around the centre.
#[test]
fn plate_on_ice_turns_about_its_centre_of_mass() {
    let (j, torque, angle, rate, offset) = (0.2, 0.7, 0.6_f64, 3.0, 0.25);
    let mut plate = body("plate", GROUND, HingeKind::Planar, 4.0, Vector3::new(offset, 0.0, 0.1), [0.15, 0.1, j]);
    plate.hinge.position = vec![1.0, -2.0, angle];
    plate.hinge.velocity = vec![0.3, 0.8, rate];
    plate.hinge.force = vec![0.0, 0.0, torque];
    let (a, reactions) = start(&scene(vec![plate]));
    let (s, c) = angle.sin_cos();
    let turning = torque / j;
    let away = offset * rate * rate;
    assert_near(&a, &[offset * turning * s + away * c, -offset * turning * c + away * s, turning]);
    assert_near(reactions[0].force.as_slice(), &[0.0, 0.0, 4.0 * GRAVITY]);
    assert!((reactions[0].moment.z - torque).abs() < TOLERANCE);
}

/// A heavy symmetric top in steady precession: J₃ω₃Ω − J₁Ω² cos θ = m g l keeps the inclination θ, and the spin's
/// change is that of a vector carried around by Ω.
#[test]
fn top_in_steady_precession_keeps_its_inclination() {
    let (m, l, j1, j3, tilt, precession) = (0.8, 0.3, 0.02, 0.01, 0.5_f64, 1.5);
    let about_tip = j1 + m * l * l;
    let axial = (m * GRAVITY * l + about_tip * precession * precession * tilt.cos()) / (j3 * precession);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -tilt);
    let axis = turn * Vector3::z();
    let precessing = precession * Vector3::z();
    let own = (axial - precession * tilt.cos()) * axis;
    let spin = turn.inverse() * (precessing + own);
    let mut top = body("top", GROUND, HingeKind::Spherical, m, Vector3::new(0.0, 0.0, l), [j1, j1, j3]);
    top.hinge.position = vec![turn.w, turn.i, turn.j, turn.k];
    top.hinge.velocity = spin.as_slice().to_vec();
    let (a, _) = start(&scene(vec![top]));
    // Rates of components in body axes are components of the rate: ω × ω adds nothing.
    let expected = turn.inverse() * precessing.cross(&own);
    let scale = expected.norm();
    let error = (Vector3::from_column_slice(&a) - expected).norm();
    assert!(error < 1e-13 * scale, "{error:e} of {scale}");
}
