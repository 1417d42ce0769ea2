//! What has to hold whatever the numbers are.

use super::{FOUR_BAR, coordinate, read, run};
use nalgebra::{Isometry3, Vector3};
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::integrate::Method;
use stillpoint::model::Model;
use stillpoint::simulate::{Integrator, Settings};

fn settings(duration: f64) -> Settings {
    Settings {
        duration,
        integrator: Integrator::Method(Method::Dop853),
        tolerance: 1e-11,
        absolute_tolerance: 1e-11,
        ..Settings::default()
    }
}

fn pose(model: &Arc<Model>, position: &[f64], body: &str) -> Isometry3<f64> {
    let mut system = System::new(model);
    let mut poses = Vec::new();
    system.at(0.0, position, &vec![0.0; model.velocity_count()]).poses(&mut poses);
    poses[model.body(body).expect("a body")]
}

const CARRIER: &str = r#"
[[body]]
name = "carrier"
mass = 3.0
center = [0.1, 0.2, -0.3]
inertia = [0.5, 0.4, 0.3]
hinge = { type = "revolute", at = [0.1, 0.0, 0.2], axis = [0.3, 1.0, 0.2], velocity = 1.5 }
"#;

/// A body that a loop hinge ties to its carrier moves like one that hangs on it by that hinge.
#[test]
fn a_loop_hinge_is_a_hinge() {
    for (kind, extra) in [
        ("revolute", "axis = [0.2, -0.5, 1.0]"),
        ("prismatic", "axis = [0.2, -0.5, 1.0]"),
        ("screw", "axis = [0.2, -0.5, 1.0], pitch = -0.05"),
        ("cylindrical", "axis = [0.2, -0.5, 1.0]"),
        ("universal", "axes = [[1.0, 0.2, 0.0], [0.0, 1.0, 0.5]]"),
        ("planar", ""),
        ("spherical", ""),
    ] {
        let extra = if extra.is_empty() { String::new() } else { format!(", {extra}") };
        let body = "[[body]]\nname = \"load\"\nmass = 2.0\ncenter = [0.3, -0.1, 0.2]\ninertia = [0.2, 0.25, 0.3]\n";
        let hung = format!(
            "{CARRIER}{body}hinge = {{ type = \"{kind}\", parent = \"carrier\", at = [0.4, 0.1, 0.0], rpy = [0.3, -0.2, 0.5]{extra} }}\n"
        );
        let (_, tree) = read(&hung);
        // Where it stands at the start, and how its carrier moves it there: a free body with the same state.
        let at = pose(&tree, &tree.start_position, "load");
        let carrier = pose(&tree, &tree.start_position, "carrier");
        let turn = Vector3::new(0.3, 1.0, 0.2).normalize() * 1.5;
        let velocity = turn.cross(&(at.translation.vector - carrier.translation.vector));
        let (p, q) = (at.translation.vector, at.rotation);
        let spin = q.inverse() * turn;
        let (rest, keys) = (at.translation.vector, extra.trim_start_matches(", ").replace(", pitch", "\npitch"));
        let tied = format!(
            "{CARRIER}{body}hinge = {{ type = \"free\", position = [{:?}, {:?}, {:?}, {:?}, {:?}, {:?}, {:?}], velocity = [{:?}, {:?}, {:?}, {:?}, {:?}, {:?}] }}\n\
             [[loop]]\ntype = \"{kind}\"\nbetween = [{{ body = \"carrier\", at = [0.4, 0.1, 0.0] }}, \"load\"]\nrpy = [0.3, -0.2, 0.5]\n{keys}\n",
            p.x, p.y, p.z, q.w, q.i, q.j, q.k, velocity.x, velocity.y, velocity.z, spin.x, spin.y, spin.z
        );
        let (_, looped) = read(&tied);
        assert_eq!(looped.degrees_of_freedom(), tree.velocity_count(), "{kind}");
        let (one, other) = (run(&tree, &settings(1.0)), run(&looped, &settings(1.0)));
        let (expected, found) = (one.poses[1], other.poses[1]);
        let apart = (expected.translation.vector - found.translation.vector).norm();
        let turned = expected.rotation.angle_to(&found.rotation);
        assert!((rest - expected.translation.vector).norm() > 0.1, "{kind}: it moves");
        assert!(apart < 1e-8 && turned < 1e-7, "{kind}: {apart:e} m, {turned:e} rad");
        assert!(other.constraint_error < 1e-12, "{kind}: {:e}", other.constraint_error);
        assert!(other.energy_drift < 1e-8, "{kind}: {:e}", other.energy_drift);
    }
}

/// Of a planar four-bar of spatial revolute hinges three rows of five are redundant; the crank's velocity is kept.
#[test]
fn redundant_rows_are_counted_and_given_velocities_kept() {
    let (scenario, model) = read(FOUR_BAR);
    let again = Model::build(&scenario.description).expect("a model");
    let (_, assembly) = stillpoint::constraint::assemble(again).expect("an assembly");
    assert_eq!(assembly.degrees_of_freedom, 1);
    assert_eq!(assembly.redundant, [("loop `coupler-rocker`".to_owned(), 3, 5)]);
    assert!(assembly.given_gap > 1e-2 && assembly.gap < 1e-14, "{assembly:?}");
    assert!(assembly.notes.iter().any(|note| note.contains("nearest assembly")), "{:?}", assembly.notes);
    // They weigh 10¹² times as much as what follows from them.
    assert!((model.start_velocity[0] - 14.0).abs() < 1e-10);
}

/// A screw in a cylindrical hinge: a falling nut turns its screw, and weight times height becomes motion. The energy is
/// kept, and the acceleration is that of the nut's mass beside the screw's inertia over the square of the lead.
#[test]
fn gears_keep_the_energy_and_add_inertia_by_the_square_of_their_ratio() {
    let lead = 0.05;
    let text = format!(
        "[[body]]\nname = \"nut\"\nmass = 2.0\ninertia = [0.01, 0.01, 0.02]\n\
         hinge = {{ type = \"cylindrical\", axis = [0.0, 0.0, 1.0] }}\n\
         [[gear]]\ntype = \"screw\"\nlead = {lead}\n\
         between = [{{ hinge = \"nut\", coordinate = 0 }}, {{ hinge = \"nut\", coordinate = 1 }}]\n"
    );
    let (_, model) = read(&text);
    assert_eq!(model.degrees_of_freedom(), 1);
    let end = run(&model, &settings(1.0));
    let per_turn = std::f64::consts::TAU / lead;
    let acceleration = 9.80665 * 2.0 / (2.0 + 0.02 * per_turn * per_turn);
    assert!((end.state.position[0] + 0.5 * acceleration).abs() < 1e-10, "{:?}", end.state.position);
    assert!((end.state.position[1] - per_turn * end.state.position[0]).abs() < 1e-11);
    assert!(end.energy_drift < 1e-10, "{:e}", end.energy_drift);
    // A pinion that lifts a rack, and a pair of wheels: the same law.
    let rack = "[[body]]\nname = \"rack\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\nhinge = { type = \"prismatic\", axis = [0, 0, 1] }\n\
                [[body]]\nname = \"pinion\"\nmass = 1.0\ninertia = [0.2, 0.2, 0.3]\nhinge = { type = \"revolute\", axis = [0, 0, 1] }\n\
                [[body]]\nname = \"wheel\"\nmass = 1.0\ninertia = [0.5, 0.5, 0.8]\nhinge = { type = \"revolute\", axis = [0, 0, 1] }\n\
                [[gear]]\ntype = \"rack\"\nradius = 0.2\nbetween = [\"rack\", \"pinion\"]\n\
                [[gear]]\ntype = \"ratio\"\nratio = -0.5\nbetween = [\"wheel\", \"pinion\"]\n";
    let (_, model) = read(rack);
    let end = run(&model, &settings(1.0));
    let seen = 1.0 + (0.3 + 0.8 * 0.25) / (0.2 * 0.2);
    let fall = -0.5 * 9.80665 / seen;
    assert!((coordinate(&model, &end.state.position, "rack") - fall).abs() < 1e-10);
    assert!((coordinate(&model, &end.state.position, "wheel") + 0.5 * fall / 0.2).abs() < 1e-10);
}

/// The force of a drive is what Newton's law asks for, and its work is the energy that comes in.
#[test]
fn drives_report_their_force_and_their_work() {
    let text = "gravity = [0.0, 0.0, -10.0]\n[[body]]\nname = \"lift\"\nmass = 3.0\ninertia = [1, 1, 1]\n\
                hinge = { type = \"prismatic\", axis = [0, 0, 1], position = 0.4 }\n\
                [[drive]]\nname = \"winch\"\nhinge = \"lift\"\ntype = \"expression\"\nexpression = \"0.4 + 0.5*t^2 + 0.1*sin(3*t)\"\n";
    let (_, model) = read(text);
    assert!((model.start_velocity[0] - 0.3).abs() < 1e-15, "the drive's velocity at the start");
    let mut system = System::new(&model);
    let mut a = [0.0];
    for time in [0.0, 0.7_f64, 2.0] {
        let q = [0.4 + 0.5 * time * time + 0.1 * (3.0 * time).sin()];
        let v = [time + 0.3 * (3.0 * time).cos()];
        system.at(time, &q, &v).accelerations(&mut a).expect("accelerations");
        let expected = 1.0 - 0.9 * (3.0 * time).sin();
        let rows = system.constraints().expect("rows");
        let (name, force) = rows.drive_forces(&model, &a).next().expect("a drive");
        assert_eq!(name, "winch");
        assert!((a[0] - expected).abs() < 1e-13 && (force - 3.0 * (expected + 10.0)).abs() < 1e-12);
    }
    let end = run(&model, &settings(2.0));
    // The work is a quadrature over steps that this simple motion allows to be long.
    assert!(end.energy_drift < 1e-6, "{:e}", end.energy_drift);
    assert!(end.energy_end - end.energy_start > 50.0);
    assert!((end.state.position[0] - (0.4 + 2.0 + 0.1 * 6.0_f64.sin())).abs() < 1e-13);
}

/// A scene without them holds nothing of them; with them an evaluation asks for no memory.
#[test]
fn rows_are_solved_without_allocating() {
    let (_, model) = read(FOUR_BAR);
    let (mut q, mut v, mut a) = (model.start_position.clone(), model.start_velocity.clone(), vec![0.0; 3]);
    let mut system = System::new(&model);
    let counted = allocation_counter::measure(|| {
        system.at(0.0, &q.clone(), &v).accelerations(&mut a).expect("accelerations");
    });
    assert_eq!(counted.count_total, 1, "the clone of the caller only: {counted:?}");
    q[0] += 1e-6;
    let counted = allocation_counter::measure(|| {
        assert!(system.settle(0.0, &mut q, &mut v).expect("a state").moved);
    });
    assert_eq!(counted.count_total, 0, "{counted:?}");
    let (_, free) = read(FOUR_BAR.split("[[loop]]").next().expect("the bodies"));
    assert!(System::new(&free).constraints().is_none());
}

/// The Jacobians of the accelerations of a closed loop are what differences say, along every coordinate.
#[test]
fn jacobians_know_loops() {
    let spring = "[[force]]\ntype = \"spring\"\nbetween = [\"coupler.pin\", { body = \"ground\", at = [0.1, 0.0, 0.5] }]\n\
                  stiffness = 300.0\nlength = 0.2\ndamping = 3.0\n";
    let (_, model) = read(&format!("{FOUR_BAR}{spring}"));
    let (q, v) = (&model.start_position, &model.start_velocity);
    let mut system = System::new(&model);
    let (by_position, by_velocity) = system.at(0.0, q, v).acceleration_jacobians().expect("Jacobians");
    let mut at = |q: &[f64], v: &[f64]| {
        let mut a = vec![0.0; 3];
        system.at(0.0, q, v).accelerations(&mut a).expect("accelerations");
        a
    };
    let h = 1e-6;
    for j in 0..3 {
        let moved = |list: &[f64], by: f64| {
            let mut list = list.to_vec();
            list[j] += by;
            list
        };
        let of_position = (at(&moved(q, h), v), at(&moved(q, -h), v));
        let of_velocity = (at(q, &moved(v, h)), at(q, &moved(v, -h)));
        for ((ahead, behind), matrix) in [(of_position, &by_position), (of_velocity, &by_velocity)] {
            for i in 0..3 {
                let difference = (ahead[i] - behind[i]) / (2.0 * h);
                // Round-off of accelerations of 1e3 over 1e-6.
                let size = matrix.norm_max();
                assert!((matrix[(i, j)] - difference).abs() < 1e-6 * size, "{i} {j}: {} {difference}", matrix[(i, j)]);
            }
        }
    }
}
