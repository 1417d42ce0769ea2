//! Beams as they are written in files, and beside what they cannot be combined with.

use crate::common::build;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::PI;
use stillpoint::dynamics::System;
use stillpoint::record::Fanout;
use stillpoint::scenario::{self, Scenario};
use stillpoint::simulate::{Start, State, run};

fn read(text: &str) -> Scenario {
    scenario::parse("beam.toml", text, &[]).unwrap_or_else(|found| panic!("{found}"))
}

/// A rod that widens from 10 to 30 mm over a millimetre: its mass is that of two cylinders and a frustum, however many elements.
#[test]
fn elements_end_where_the_section_changes() {
    let cone = 0.001 * (0.01_f64.powi(2) + 0.01 * 0.03 + 0.03_f64.powi(2)) / 3.0;
    let expected = 2700.0 * PI * (0.4 * 0.01_f64.powi(2) + cone + 0.599 * 0.03_f64.powi(2));
    for elements in [1, 8, 13] {
        let text = format!(
            "[[beam]]\nname = \"b\"\nhinge = {{ type = \"fixed\" }}\nlength = 1.0\nelements = {elements}\n\
             section = [{{ s = 0.0, circle = 0.01 }}, {{ s = 0.4, circle = 0.01 }}, {{ s = 0.401, circle = 0.03 }}, \
             {{ s = 1.0, circle = 0.03 }}]\nmaterial = {{ young = 70e9, density = 2700.0 }}\n"
        );
        let mass = build(&read(&text).description).total_mass();
        // Lobatto's rule is exact for squares of linear laws.
        assert!((mass / expected - 1.0).abs() < 1e-12, "{elements} elements: {mass} kg and not {expected}");
    }
}

/// A beam through points ends at the last of them, whatever its hinge is turned by, and where an arc would if they are on one;
/// sections that are twisted leave the centre line where it is.
#[test]
fn a_centre_line_goes_through_its_points() {
    let tip = |curve: &str, rest: &str| {
        let text = format!(
            "[[beam]]\nname = \"b\"\nhinge = {{ type = \"fixed\", at = [1.0, 2.0, 3.0], rpy = [0.3, -0.2, 0.5] }}\n\
             curve = {{ {curve} }}\nelements = 16\nsection = {{ circle = 0.01 }}\nmaterial = {{ young = 70e9, density = 2700.0 }}\n{rest}"
        );
        let model = build(&read(&text).description);
        let mut system = System::new(&model);
        let rest = vec![0.0; model.velocity_count()];
        let mut poses = Vec::new();
        system.at(0.0, &model.start_position, &rest).poses(&mut poses);
        let pose = poses[model.beams[0].elements.last().expect("elements").body];
        (pose, model.total_mass())
    };
    let root =
        Isometry3::from_parts(Translation3::new(1.0, 2.0, 3.0), UnitQuaternion::from_euler_angles(0.3, -0.2, 0.5));
    let (at, _) = tip("points = [[0, 0, 0], [0.2, 0.1, 0.4], [0.1, 0.5, 0.9], [-0.3, 0.8, 1.0]]", "");
    let expected = root * Point3::new(-0.3, 0.8, 1.0);
    assert!((at * Point3::origin() - expected).norm() < 1e-5, "{at} {expected}");

    let on_arc = |i: f64| format!("[{:?}, {:?}, 0]", (0.1 * i).sin(), 1.0 - (0.1 * i).cos());
    let list = (0..=10).map(|i| on_arc(f64::from(i))).collect::<Vec<_>>().join(", ");
    let (through, mass) = tip(&format!("points = [{list}]"), "");
    let (arc, mass_of_arc) = tip("arc = [1.0, 1.0]", "");
    assert!((through.translation.vector - arc.translation.vector).norm() < 1e-6, "{through} {arc}");
    assert!(through.rotation.angle_to(&arc.rotation) < 1e-4, "{through} {arc}");
    assert!((mass / mass_of_arc - 1.0).abs() < 1e-6);

    let (twisted, _) = tip("arc = [1.0, 1.0]", "twist = 0.7\n");
    assert!((twisted.translation.vector - arc.translation.vector).norm() < 1e-8, "{twisted} {arc}");
    let about = arc.rotation * UnitQuaternion::from_scaled_axis(Vector3::x() * 0.7);
    assert!(twisted.rotation.angle_to(&about) < 1e-8, "{twisted} {arc}");
}

/// Elements that cannot follow the points are an error, those that hardly can a warning: a hairpin is no gentle bend.
#[test]
fn elements_that_stray_from_their_points_are_told() {
    let read = |points: &str, elements: usize| {
        let text = format!(
            "[[beam]]\nname = \"b\"\nhinge = {{ type = \"fixed\" }}\ncurve = {{ points = {points} }}\nelements = {elements}\n\
             section = {{ circle = 0.01 }}\nmaterial = {{ young = 70e9, density = 2700.0 }}\n"
        );
        scenario::parse("beam.toml", &text, &[])
    };
    let error = read("[[0, 0, 0], [1, 0, 0], [0.5, 0.001, 0]]", 8).expect_err("a hairpin").to_string();
    assert!(error.contains("stray from its points by") && error.contains("more elements"), "{error}");
    let bend = "[[0, 0, 0], [0.5, 0.1, 0.2], [1.0, 0, 0.1], [1.4, -0.3, 0.3]]";
    assert!(read(bend, 16).expect("a bend").warnings.is_empty());
    let coarse = read(bend, 2).expect("a bend").warnings.to_string();
    assert!(coarse.contains("stray") || coarse.contains("turns by"), "{coarse}");
}

/// What Kelvin–Voigt damping takes out is in the account of the energy.
#[test]
fn damping_is_accounted_for() {
    let text = "[simulate]\nstart = \"given\"\nduration = 0.3\ntolerance = 1e-8\n[[beam]]\nname = \"b\"\nhinge = { type = \"fixed\" }\n\
                section = { stiffness = [1e4, 1e4, 1e4, 1.0, 1.0, 1.0] }\nmass_per_length = 1.0\nlength = 1.0\nelements = 3\n\
                free = [\"bend\"]\ndamping = 0.02\n";
    let scenario = read(text);
    let model = build(&scenario.description);
    let start = State { position: model.start_position.clone(), velocity: vec![0.0; model.velocity_count()] };
    assert_eq!(scenario.simulate.start, Start::Given);
    let summary = run(&model, &scenario.simulate, 10.0, &start, &mut Fanout::new(), &mut |_, _| true).expect("a run");
    assert!(summary.dissipated > 1e-3, "{} J dissipated", summary.dissipated);
    assert!(summary.energy_drift < 1e-4 * summary.dissipated, "{:e} J unaccounted for", summary.energy_drift);
}
