//! Runs of scenes that contact holds at rest: kept bit for bit, their forces in the recording.

use crate::common::Random;
use nalgebra::{UnitQuaternion, Vector3};
use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use stillpoint::constraint::assemble;
use stillpoint::integrate::Method;
use stillpoint::model::Model;
use stillpoint::record::{Memory, Opening, OwnedSample};
use stillpoint::scenario::{Scenario, load, parse};
use stillpoint::simulate::{self, Integrator, RunError, Settings, State, Summary, run};

const G: f64 = 9.80665;

fn read(text: &str) -> (Scenario, Arc<Model>) {
    let scenario = parse("scene.toml", text, &[]).unwrap_or_else(|problem| panic!("{}\n{text}", problem.render(false)));
    let (model, _) = assemble(Model::build(&scenario.description).unwrap()).unwrap();
    (scenario, model)
}

fn given(model: &Model) -> State {
    State { position: model.start_position.clone(), velocity: model.start_velocity.clone() }
}

fn go(model: &Arc<Model>, settings: &Settings) -> Result<(Summary, Vec<OwnedSample>), RunError> {
    let scene = simulate::scene(model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: "", statics: None });
    let summary = run(model, settings, 7.0 / settings.duration, &given(model), &mut memory, &mut |_, _| true)?;
    Ok((summary, memory.samples))
}

/// What rests stays bit for bit: one step, no event, no energy that is unaccounted for.
fn stays(model: &Arc<Model>, settings: &Settings) -> Vec<OwnedSample> {
    let (summary, samples) = go(model, settings).unwrap_or_else(|error| panic!("{error}"));
    let start = given(model);
    assert!(samples.len() >= 8 && summary.end_time == settings.duration, "{summary:?}");
    for sample in &samples {
        assert_eq!(sample.positions, start.position, "t = {}", sample.time);
        assert!(sample.velocities.iter().all(|v| *v == 0.0), "t = {}", sample.time);
        // Of moments of inertia and masses within two decades of each other.
        assert!(sample.accelerations.iter().all(|a| a.abs() < 1e-7 * G), "{:?}", sample.accelerations);
    }
    assert_eq!(summary.state, start);
    assert_eq!((summary.statistics.steps, summary.events.len(), summary.integrators.len()), (1, 0, 0));
    assert!(summary.energy_drift == 0.0 && summary.work == 0.0 && summary.dissipated == 0.0, "{summary:?}");
    samples
}

/// A box on a plane that is turned about any axis, its slope at this part of the friction cone.
fn on_a_slope(random: &mut Random, part: f64) -> String {
    let (friction, mass) = (random.between(0.1, 0.6), random.between(0.1, 50.0));
    let edges = [random.between(0.4, 1.0), random.between(0.4, 1.0), random.between(0.05, 0.1)];
    let (slope, heading) = ((part * friction).atan(), random.between(-3.0, 3.0));
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading)
        * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), slope)
        * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), random.between(-3.0, 3.0));
    let normal = turn * Vector3::z();
    let at = normal * (0.5 * edges[2]);
    format!(
        "[[body]]\nname = \"floor\"\nshape = {{ plane = {:?} }}\nhinge = {{ type = \"fixed\" }}\n[[body]]\nname = \"box\"\n\
         mass = {mass:?}\ninertia = {:?}\nshape = {{ box = {edges:?} }}\n\
         hinge = {{ type = \"free\", position = {:?} }}\n[[contact]]\nbetween = [\"box\", \"floor\"]\nfriction = {friction:?}\n",
        [normal.x, normal.y, normal.z],
        [mass * 0.05, mass * 0.05, mass * 0.08],
        [at.x, at.y, at.z, turn.w, turn.i, turn.j, turn.k],
    )
}

/// Reference `incline_sticks`: displacement 0, for every method and any duration, up to a millionth of the cone; beyond it the
/// box slides (`contact_in_motion.rs`).
#[test]
fn a_box_within_its_cone_does_not_move_at_all() {
    let mut random = Random::new(61);
    for case in 0..60 {
        for part in [0.999, 1.0 - 1e-6, 0.0] {
            let (scenario, model) = read(&on_a_slope(&mut random, part));
            let method = Method::ALL[case % Method::ALL.len()];
            let duration = if case % 2 == 0 { 10.0 } else { 1000.0 };
            let integrator = Integrator::Method(method);
            stays(
                &model,
                &Settings { integrator, duration, step: method.needs_step().then_some(0.01), ..scenario.simulate },
            );
        }
    }
}

/// The floor pushes the same whatever the pile is; each box of it keeps its place.
#[test]
fn piles_rest_for_a_thousand_seconds() {
    let mut random = Random::new(62);
    for count in 1..=8 {
        let (mut text, mut height) = ("[simulate]\nduration = 1000\n[[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n".to_owned(), 0.0);
        for k in 0..count {
            let (edge, mass) = (random.between(0.2, 0.4), random.between(0.5, 20.0));
            let at = [random.between(-0.01, 0.01), random.between(-0.01, 0.01)];
            write!(
                text,
                "[[body]]\nname = \"b{k}\"\nmass = {mass:?}\ninertia = {:?}\nshape = {{ box = [{edge:?}, {edge:?}, {edge:?}] }}\n\
                 hinge = {{ type = \"free\", position = [{:?}, {:?}, {:?}, 1, 0, 0, 0] }}\n",
                [mass * edge * edge / 6.0; 3],
                at[0],
                at[1],
                height + 0.5 * edge
            )
            .unwrap();
            height += edge;
        }
        text.push_str("[[contact]]\nbetween = [\"*\", \"*\"]\nfriction = 0.4\n");
        let (scenario, model) = read(&text);
        stays(&model, &scenario.simulate);
    }
}

#[test]
fn shipped_scenes_that_stand_run_where_they_stand() {
    for name in ["brick_wall", "four_balls", "ladder", "rocking_stone"] {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenarios/standing");
        let scenario = load(&folder.join(format!("{name}.toml"))).unwrap_or_else(|problem| panic!("{problem}"));
        let (model, _) = assemble(Model::build(&scenario.description).unwrap()).unwrap();
        stays(&model, &scenario.simulate);
    }
}

/// An arm on a hinge that lies with its ball on a post: what the post bears is missing at the hinge, in every sample and in the
/// outputs.
#[test]
fn the_hinge_bears_what_the_contact_does_not() {
    let mut random = Random::new(63);
    for _ in 0..40 {
        let (mass, length, centre) = (random.between(0.5, 20.0), random.between(0.5, 2.0), random.between(0.1, 0.9));
        let text = format!(
            "[[body]]\nname = \"post\"\nshape = {{ plane = [0, 0, 1], at = [0, 0, -0.05] }}\nhinge = {{ type = \"fixed\" }}\n\
             [[body]]\nname = \"arm\"\nmass = {mass:?}\ncenter = [{:?}, 0, 0]\ninertia = {:?}\n\
             shape = {{ sphere = 0.05, at = [{length:?}, 0, 0] }}\nhinge = {{ type = \"revolute\", axis = [0, 1, 0] }}\n\
             [[contact]]\nbetween = [\"arm\", \"post\"]\nfriction = 0.0\n",
            centre * length,
            [0.1 * mass; 3]
        );
        let (scenario, model) = read(&text);
        let arm = model.body("arm").unwrap();
        for sample in stays(&model, &scenario.simulate) {
            let force = sample.reactions[arm].force;
            let expected = mass * G * (1.0 - centre);
            assert!((force.z.abs() - expected).abs() < 1e-9 * mass * G, "{force:?} {expected}");
        }
    }
}

/// What is beyond its cone is held by nothing: it slides, with implicit methods as far as with explicit ones.
#[test]
fn what_is_beyond_its_cone_slides_with_any_kind_of_method() {
    let mut random = Random::new(64);
    let (_, model) = read(&on_a_slope(&mut random, 1.5));
    let slides = |method: Method| {
        let settings = Settings {
            start: simulate::Start::Given,
            duration: 1.0,
            tolerance: 1e-9,
            absolute_tolerance: 1e-9,
            integrator: Integrator::Method(method),
            ..Settings::default()
        };
        let (summary, _) = go(&model, &settings).unwrap_or_else(|error| panic!("{method:?}: {error}"));
        Vector3::from_column_slice(&summary.state.position[..3])
    };
    let explicit = slides(Method::Dop853);
    assert!((explicit - Vector3::from_column_slice(&model.start_position[..3])).norm() > 0.1, "{explicit:?}");
    for method in [Method::Sdirk4, Method::Radau5, Method::Radau9] {
        let off = (slides(method) - explicit).norm();
        // Some tolerances.
        assert!(off < 1e-8, "{method:?}: {off:e}");
    }
}
