//! Dry friction and contact beside beams: what stands on a beam stands on it as it is bent.

use crate::common::{Random, answered};
use std::sync::Arc;
use stillpoint::contact::support::Verdict;
use stillpoint::model::Model;
use stillpoint::motion::Motion;
use stillpoint::record::Fanout;
use stillpoint::scenario::{Scenario, parse};
use stillpoint::simulate::{State, run};
use stillpoint::statics::{Equilibrium, beams};

fn read(text: &str) -> (Scenario, Arc<Model>) {
    let scenario = parse("scene.toml", text, &[]).unwrap_or_else(|problem| panic!("{}\n{text}", problem.render(false)));
    let model = Model::build(&scenario.description).expect("a sound scene");
    (scenario, model)
}

fn found(text: &str) -> (Arc<Model>, Equilibrium) {
    let (scenario, model) = read(text);
    let found = answered(&scenario, Arc::clone(&model));
    (model, found.unwrap_or_else(|error| panic!("{error}\n{text}")).found)
}

/// How far the tip of the beam points down (rad).
fn slope(model: &Model, pose: &[f64]) -> f64 {
    let mut motion = Motion::new(model);
    motion.update(model, pose, &vec![0.0; model.velocity_count()]);
    let last = model.beams[0].elements.last().expect("an element").link;
    let x = motion.links[last].turn.column(0).into_owned();
    -x.z.atan2(x.x)
}

fn cantilever(length: f64, bending: f64) -> String {
    format!(
        "[[beam]]\nname = \"jib\"\nhinge = {{ type = \"fixed\" }}\nlength = {length:?}\nelements = 2\nfree = [\"bend\"]\n\
         section = {{ stiffness = [1e6, 1e6, 1e6, 1e5, {bending:?}, {bending:?}] }}\nmass_per_length = 1e-4\n"
    )
}

/// A weight in a slide at the tip of a cantilever: it stays where it is while dry friction bears its part down the slope, which
/// is that of the bent beam; and the friction needed for that is told.
#[test]
fn a_slide_on_a_bent_cantilever_sticks_by_its_slope() {
    let (mut stands, mut slides) = (0, 0);
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let (length, mass) = (random.between(0.5, 2.0), random.between(1.0, 5.0));
        let (angle, weight) = (random.between(0.01, 0.05), mass * 9.80665);
        let bending = weight * length * length / (2.0 * angle);
        let stick = weight * angle * random.between(0.5, 2.0);
        let text = cantilever(length, bending)
            + &format!(
                "[[body]]\nname = \"weight\"\nmass = {mass:?}\nhinge = {{ parent = \"jib\", type = \"prismatic\", axis = [1, 0, 0], \
                 limits = [-0.1, 0.1], friction = {stick:?} }}\n"
            );
        let (model, found) = found(&text);
        let standing = found.standing.as_ref().expect("a verdict");
        let slide = model.bodies.iter().find(|body| body.name == "weight").expect("the weight").hinge.position;
        let needed = angle.sin() * weight / stick;
        if needed > 1.02 {
            assert_eq!(standing.verdict, Verdict::Falls, "seed {seed}\n{text}");
            assert!(
                found.position[slide].abs() > 0.09,
                "seed {seed}: it lies at its stop, not at {}",
                found.position[slide]
            );
            slides += 1;
        } else if needed < 0.98 {
            assert!(found.converged && standing.verdict == Verdict::Stands, "seed {seed}: {:?}\n{text}", found.notes);
            assert!(found.position[slide].abs() < 1e-12, "seed {seed}: {}", found.position[slide]);
            // The slope of a beam that bends by an angle of hundredths: to the square of it, and its own weight.
            let there = slope(&model, &found.position);
            assert!((there - angle).abs() < angle.powi(3) + 1e-4 * angle, "seed {seed}: {there} rad, not {angle}");
            let margin = standing.friction_margin.expect("friction bears");
            assert!((margin - there.sin() * weight / stick).abs() < 1e-6, "seed {seed}: {margin}");
            stands += 1;
        }
    }
    assert!(stands > 10 && slides > 10, "{stands} {slides}");
}

fn shelf(length: f64, bending: f64, friction: f64) -> String {
    cantilever(length, bending)
        + &format!(
            "[[body]]\nname = \"shelf\"\nmass = 1e-3\ninertia = [1e-5, 1e-5, 1e-5]\nshape = {{ box = [0.4, 0.4, 0.02], at = [0, 0, -0.01] }}\n\
             hinge = {{ parent = \"jib\", type = \"fixed\" }}\n\
             [[body]]\nname = \"crate\"\nmass = 2.0\ninertia = [0.003, 0.003, 0.003]\nshape = {{ box = [0.1, 0.1, 0.1] }}\n\
             hinge = {{ type = \"free\", position = [{length:?}, 0.0, 0.05, 1, 0, 0, 0] }}\n\
             [[contact]]\nbetween = [\"shelf\", \"crate\"]\nfriction = {friction:?}\n"
        )
}

/// A crate that is put on a shelf at the end of a cantilever settles with it, and needs the friction of the slope there.
#[test]
fn a_crate_on_a_bent_shelf_needs_the_tangent_of_its_slope() {
    for seed in 0..10 {
        let mut random = Random::new(seed);
        let (length, angle) = (random.between(0.5, 1.5), random.between(0.02, 0.15));
        let bending = 2.0 * 9.80665 * length * length / (2.0 * angle);
        let friction = angle.tan() * random.between(1.2, 3.0);
        let text = format!("[statics]\ncontact = \"settle\"\n{}", shelf(length, bending, friction));
        let (model, found) = found(&text);
        assert!(found.converged, "seed {seed}: {:?}\n{text}", found.notes);
        let standing = found.standing.as_ref().expect("a verdict");
        // What the beam bears at its root is the crate's weight at where it stands.
        let bears = beams(&model, &found).expect("sections")[0].sections[0].forces;
        let crate_at = model.bodies.iter().find(|body| body.name == "crate").expect("the crate").hinge.position;
        let moment = 2.0 * 9.80665 * found.position[crate_at];
        assert!((bears[4].abs() - moment).abs() < 2e-3 * moment, "seed {seed}: {bears} of {moment} N m");
        let there = slope(&model, &found.position);
        assert!((there - angle).abs() < 0.1 * angle, "seed {seed}: {there} rad, about {angle}");
        let margin = standing.friction_margin.expect("friction bears");
        assert!((margin - there.tan() / friction).abs() < 1e-6, "seed {seed}: {margin} of {}", there.tan() / friction);
    }
}

/// A crate dropped onto the shelf: all of its energy is accounted for, in the beam that swings, too.
#[test]
fn a_crate_falls_onto_a_shelf_that_swings() {
    let text = shelf(1.0, 300.0, 0.4).replace("0.05, 1, 0, 0, 0]", "0.12, 1, 0, 0, 0]")
        + "[simulate]\nduration = 0.3\nintegrator = \"dopri5\"\ntolerance = 1e-8\nstart = \"given\"\n";
    let heavy = [
        ("mass_per_length = 1e-4", "mass_per_length = 0.5\ndamping = 0.002"),
        ("mass = 1e-3\ninertia = [1e-5, 1e-5, 1e-5]", "mass = 0.5\ninertia = [0.01, 0.01, 0.01]"),
    ];
    let text = heavy.iter().fold(text, |text, (light, heavy)| text.replace(light, heavy));
    let (scenario, model) = read(&text);
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let summary = run(&model, &scenario.simulate, 10.0, &start, &mut Fanout::new(), &mut |_, _| true).expect("a run");
    assert!(summary.impacts > 0 && summary.dissipated > 0.1, "{} blows, {} J", summary.impacts, summary.dissipated);
    assert!(
        summary.capture_steps == 0 && summary.energy_drift < 1e-8 * 2.0 * 9.8,
        "{:e} J unaccounted for",
        summary.energy_drift
    );
}
