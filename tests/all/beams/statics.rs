//! Statics of beams against answers from outside, with at most 16 elements, from the unstrained guess at full load.

use nalgebra::Vector3;
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::model::Model;
use stillpoint::model::description::{
    BeamDescription, BeamShape, Description, ForceDescription, FreeStrains, HingeDescription, Load, LoadAxes,
};
use stillpoint::statics::{Equilibrium, Settings, StabilityVerdict, Want, equilibrium};

pub(super) fn case(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/reference/beams/{name}.json"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).expect("JSON")
}

/// The numbers of an expected value, and its tolerance.
pub(super) fn expected(case: &Value, index: usize) -> (Vec<f64>, f64) {
    let one = &case["expected"][index];
    let value = &one["value"];
    let list = value.as_array().map_or_else(|| vec![value.as_f64()], |list| list.iter().map(Value::as_f64).collect());
    (list.into_iter().map(|x| x.expect("a number")).collect(), one["tolerance"].as_f64().unwrap_or(0.0))
}

const BEND: FreeStrains = FreeStrains { bend: true, twist: false, stretch: false, shear: false };
const ALL: FreeStrains = FreeStrains { bend: true, twist: true, stretch: true, shear: true };

fn rod(elements: usize, degree: usize) -> BeamDescription {
    BeamDescription::new("rod", HingeDescription::fixed())
        .stiffness([1e4, 1e4, 1e4, 1.0, 1.0, 1.0])
        .mass_per_length(1.0)
        .elements(elements)
        .degree(degree)
        .free(BEND)
}

fn weightless(beam: BeamDescription) -> Description {
    Description::new("Rod").gravity([0.0, 0.0, 0.0]).beam(beam)
}

pub(super) fn solve(description: &Description) -> (Arc<Model>, Equilibrium) {
    let model = Model::build(description).expect("a sound scene");
    let (model, _) = stillpoint::constraint::assemble(model).expect("it closes");
    let found = equilibrium(&model, &Settings::default(), &model.start_position).expect("no fault");
    (model, found)
}

fn tip(model: &Arc<Model>, found: &Equilibrium) -> (Vector3<f64>, nalgebra::UnitQuaternion<f64>) {
    let mut system = System::new(model);
    let rest = vec![0.0; model.velocity_count()];
    let at = system.at(0.0, &found.position, &rest);
    let pose = at.motion().links[model.beams[0].elements.last().expect("elements").link].pose();
    (pose.translation.vector, pose.rotation)
}

pub(super) fn order(errors: &[f64]) -> f64 {
    (errors[errors.len() - 2] / errors[errors.len() - 1]).log2()
}

/// The elastica to the tolerance that sixteen elements of degree 1 have at least, in few factorizations; the error falls
/// with the fourth power of the number of elements.
#[test]
fn elastica() {
    let case = case("elastica_tip_force");
    for (index, load) in [1.0, 2.0, 5.0, 10.0].into_iter().enumerate() {
        let (value, _) = expected(&case, index);
        let mut errors = Vec::new();
        for elements in [4, 8, 16] {
            let force = ForceDescription::load("tip", ("rod", "tip"), [0.0, load, 0.0]);
            let (model, found) = solve(&weightless(rod(elements, 1)).force(force));
            assert!(found.converged, "{load}: {:?}", found.notes);
            assert_eq!(found.stability.as_ref().map(|s| s.verdict), Some(StabilityVerdict::Stable));
            assert!(found.factorizations <= 40, "{load}: {} factorizations", found.factorizations);
            let (at, turn) = tip(&model, &found);
            let off = [1.0 - at.x - value[0], at.y - value[1], turn.angle() - value[2]];
            errors.push(off.iter().fold(0.0_f64, |m, x| m.max(x.abs())));
        }
        assert!(errors[2] < 1e-6 && (order(&errors) - 4.0).abs() < 0.5, "{load}: errors {errors:?}");
    }
}

/// The arc of Bathe and Bolourchi under three loads out of its plane.
#[test]
fn bathe_and_bolourchi() {
    let case = case("bathe_bolourchi_45");
    for (index, load) in [300.0, 450.0, 600.0].into_iter().enumerate() {
        let (value, _) = expected(&case, index);
        let mut errors = Vec::new();
        for elements in [4, 8, 16] {
            let stiffness = [1e7, 5e6, 5e6, 1e7 / 12.0, 1e7 / 12.0, 1e7 / 12.0];
            let arc = rod(elements, 1).shape(BeamShape::Arc { radius: 100.0, angle: std::f64::consts::FRAC_PI_4 });
            let force = ForceDescription::load("tip", ("rod", "tip"), [0.0, 0.0, load]);
            let (model, found) = solve(&weightless(arc.stiffness(stiffness).free(ALL)).force(force));
            assert!(found.converged, "{load}: {:?}", found.notes);
            errors.push((tip(&model, &found).0 - Vector3::from_column_slice(&value)).norm() / 100.0);
        }
        assert!(errors[2] < 2e-7 && (order(&errors) - 4.0).abs() < 0.5, "{load}: errors {errors:?}");
    }
}

/// A moment that turns with the tip bends the rod into a half circle and a full one, to round-off, whatever the mesh.
#[test]
fn end_moments_make_circles() {
    let case = case("end_moment_circle");
    for (index, turns) in [0.5, 1.0].into_iter().enumerate() {
        let (value, tolerance) = expected(&case, index);
        for elements in [4, 8] {
            let torque = Vector3::new(0.0, 0.0, turns * std::f64::consts::TAU);
            let (on, force) = (("rod", "tip").into(), Vector3::zeros());
            let kind = Load { on, force, torque, axes: LoadAxes::Body, over_time: None };
            let force = ForceDescription { name: "tip".to_owned(), kind: kind.into() };
            let model = Model::build(&weightless(rod(elements, 1)).force(force)).expect("sound");
            // Bent once around, it flutters out of its plane.
            let settings = Settings { want: Want::Any, ..Settings::default() };
            let found = equilibrium(&model, &settings, &model.start_position).expect("no fault");
            assert!(found.converged, "{turns}: {:?}", found.notes);
            let off = tip(&model, &found).0 - Vector3::from_column_slice(&value);
            assert!(off.norm() < tolerance.max(1e-12), "{turns}: off by {:.1e}", off.norm());
        }
    }
}

fn bending_modes(found: &Equilibrium) -> Vec<f64> {
    let stability = found.stability.as_ref().expect("an equilibrium");
    stability.modes.iter().map(|mode| mode.frequency_hz * std::f64::consts::TAU).collect()
}

/// Frequencies of a clamped rod without rotary inertia, each twice; orders 4 with degree 1.
#[test]
fn modes_of_a_cantilever() {
    let (value, _) = expected(&case("beam_modes_euler_bernoulli"), 0);
    let mut errors = Vec::new();
    for elements in [4, 8, 16] {
        let (_, found) = solve(&weightless(rod(elements, 1)));
        let modes = bending_modes(&found);
        errors.push((modes[0] / value[0] - 1.0).abs().max((modes[1] / value[0] - 1.0).abs()));
        if elements == 16 {
            for (k, value) in value.iter().enumerate() {
                assert!((modes[2 * k] / value - 1.0).abs() < 1e-3, "{k}: {} {value}", modes[2 * k]);
            }
        }
    }
    assert!(errors[2] < 3e-7 && (order(&errors) - 4.0).abs() < 0.5, "errors {errors:?}");
}

/// A thick rod, with shear and rotary inertia.
#[test]
fn modes_of_a_thick_cantilever() {
    let case = case("timoshenko_cantilever_modes");
    let (value, _) = expected(&case, 0);
    let of = |key: &str| case["parameters"][key].as_f64().expect("a number");
    let (mass, inertia, shear, bend) = (of("rhoA"), of("rhoI"), of("kGA"), of("EI"));
    let beam = rod(16, 1)
        .stiffness([1e12, shear, shear, 1e9, bend, bend])
        .mass_per_length(mass)
        .rotary([2.0 * inertia, inertia, inertia])
        .free(FreeStrains { bend: true, twist: false, stretch: false, shear: true });
    let (_, found) = solve(&weightless(beam));
    let modes = bending_modes(&found);
    assert!((modes[0] / value[0] - 1.0).abs() < 1e-6, "{} {}", modes[0], value[0]);
    assert!((modes[2] / value[1] - 1.0).abs() < 2e-5, "{} {}", modes[2], value[1]);
}

/// Euler's and Greenhill's columns: on this side of the critical load the straight rod is stable, on the other side it is not.
#[test]
fn columns_buckle_where_they_should() {
    let (euler, _) = expected(&case("euler_columns"), 0);
    let (greenhill, _) = expected(&case("greenhill_self_buckling"), 0);
    for part in [0.9999, 1.0001] {
        let upright = || {
            let hinge = HingeDescription::fixed()
                .turned(nalgebra::UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -std::f64::consts::FRAC_PI_2));
            BeamDescription { hinge, ..rod(8, 1) }
        };
        let load = ForceDescription::load("push", ("rod", "tip"), [0.0, 0.0, -part * euler[0]]);
        let pushed = weightless(upright()).force(load);
        let heavy = Description::new("").gravity([0.0, 0.0, -part * greenhill[0]]).beam(upright());
        for scene in [pushed, heavy] {
            let model = Model::build(&scene).expect("sound");
            let settings = Settings { want: Want::Any, ..Settings::default() };
            let found = equilibrium(&model, &settings, &model.start_position).expect("no fault");
            let verdict = found.stability.as_ref().map(|s| s.verdict);
            assert_eq!(
                verdict,
                Some(if part < 1.0 { StabilityVerdict::Stable } else { StabilityVerdict::Unstable }),
                "{part}"
            );
        }
    }
}

/// A heavy cantilever: its section forces are the weight beyond, to the last digit, and its root holds all of it.
#[test]
fn section_forces_are_what_is_beyond() {
    let description = Description::new("Heavy").gravity([0.0, 0.0, -10.0]).beam(rod(8, 1).mass_per_length(5.0));
    let (model, found) = solve(&description);
    assert!(found.converged, "{:?}", found.notes);
    let mut system = System::new(&model);
    let n = model.velocity_count();
    let (rest, mut left) = (vec![0.0; n], vec![0.0; n]);
    let beams = system.at(0.0, &found.position, &rest).residual(&rest, &mut left).expect("finite").beams();
    let beam = &beams[0];
    assert!(beam.error.forces < 0.02, "{}", beam.error.forces);
    for section in &beam.sections {
        let force = section.forces.fixed_rows::<3>(0).norm();
        assert!((force - 50.0 * (1.0 - section.s)).abs() < 1e-11, "{force} at {}", section.s);
    }
    let root = &beam.sections[0].forces;
    assert_eq!(model.bodies[0].name, "rod");
    assert!((found.reactions[0].force - Vector3::new(0.0, 0.0, 50.0)).norm() < 1e-11, "{}", found.reactions[0].force);
    assert!((found.reactions[0].moment.norm() - root.fixed_rows::<3>(3).norm()).abs() < 1e-10);
}

/// Section forces that are round-off have no error, whatever acts elsewhere; those of the smallest load that is a load have one.
#[test]
fn a_beam_without_load_has_no_error_of_its_forces() {
    let mut random = crate::common::Random::new(5);
    for case in 0..24 {
        let [length, radius] = [random.between(0.2, 3.0), random.between(0.002, 0.02)];
        let (turn, elements) = (random.between(-3.0, 3.0), 1 + random.below(8));
        let load = if case % 2 == 0 { 0.0 } else { 1e-3 };
        let text = format!(
            "gravity = [0, 0, 0]\n[[body]]\nname = \"s\"\nmass = 1.0\ninertia = [1, 1, 1]\n\
             hinge = {{ type = \"revolute\", axis = [0, 0, 1], position = {turn:?}, stiffness = 5.0, rest = 0.3 }}\n\
             [[beam]]\nname = \"bm\"\nhinge = {{ type = \"fixed\", parent = \"s\", rpy = [0, -1.5707963267948966, 0.3] }}\n\
             length = {length:?}\nelements = {elements}\nsection = {{ circle = {radius:?} }}\n\
             material = {{ young = 2e11, poisson = 0.3, density = 7850.0 }}\n\
             [[body]]\nname = \"tip\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\nhinge = {{ type = \"fixed\", parent = \"bm\" }}\n\
             [[force]]\ntype = \"load\"\non = \"tip\"\nforce = [0, 0, {load:?}]\n\
             [[body]]\nname = \"other\"\nmass = 1.0\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0], at = [0, 3, 0], stiffness = 1e3, force = 50.0 }}\n"
        );
        let scenario = stillpoint::scenario::parse("idle.toml", &text, &[])
            .unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        let model = Model::build(&scenario.description).expect("a model");
        let found = equilibrium(&model, &scenario.statics, &model.start_position).expect("statics");
        assert!(found.converged, "{:?}\n{text}", found.notes);
        let error = stillpoint::statics::beams(&model, &found).expect("numbers")[0].error;
        assert_eq!(error.idle, load == 0.0, "{error:?}\n{text}");
        assert!(!error.idle || (error.forces, error.deflections) == (0.0, 0.0), "{error:?}");
    }
}

/// A steel cantilever that is pushed with a newton beside a stiff spring at its length: both stiffnesses add up (closed form, deflections of a
/// micrometre). The potential is rounding there, and the forces are not.
#[test]
fn a_light_push_beside_a_stiff_spring_at_its_length() {
    let (young, radius, length, stiffness) = (210e9_f64, 0.025_f64, 1.0_f64, 1e5_f64);
    let to = Vector3::new(0.3, 0.2, 1.0);
    for elements in [2, 4, 8] {
        let text = format!(
            "gravity = [0, 0, 0]\n[[beam]]\nname = \"a\"\nhinge = {{ type = \"fixed\" }}\nlength = {length:?}\nsection = {{ circle = {radius:?} }}\n\
             elements = {elements}\nfree = [\"bend\"]\nmaterial = {{ young = {young:?}, density = 7800.0 }}\n\
             [[force]]\ntype = \"load\"\non = \"a.tip\"\nforce = [0, 0.3, -1.0]\n\
             [[force]]\ntype = \"spring\"\nbetween = [\"a.tip\", {{ body = \"ground\", at = [1.3, 0.2, 1.0] }}]\nstiffness = {stiffness:?}\nlength = {:?}\n",
            to.norm()
        );
        let scenario =
            stillpoint::scenario::parse("light.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
        let model = Model::build(&scenario.description).expect("a sound scene");
        let found = equilibrium(&model, &Settings::default(), &model.start_position).expect("statics");
        assert!(found.converged && found.iterations < 20, "{elements}: {} {:?}", found.iterations, found.notes);
        let bends = 3.0 * young * std::f64::consts::PI * radius.powi(4) / 4.0 / length.powi(3);
        let along = to.normalize().yz();
        let matrix = nalgebra::Matrix2::identity() * bends + along * along.transpose() * stiffness;
        let expected = matrix.lu().solve(&nalgebra::Vector2::new(0.3, -1.0)).expect("a deflection");
        let moved = tip(&model, &found).0;
        let off = (moved.yz() - expected).norm() / expected.norm();
        assert!(off < 1e-5, "{elements}: {moved} {expected} {off:e}");
    }
}
