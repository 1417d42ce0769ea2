//! Dry friction and contact beside beams: what stands on a beam stands on it as it is bent.

use crate::common::{Random, answered};
use std::f64::consts::TAU;
use std::sync::Arc;
use stillpoint::contact::support::Verdict;
use stillpoint::model::Model;
use stillpoint::motion::Motion;
use stillpoint::record::Fanout;
use stillpoint::scenario::{Scenario, parse};
use stillpoint::simulate::{State, run};
use stillpoint::statics::StabilityVerdict::{Stable, Unstable};
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

/// A mast with a head on a base, which is held by `hold`; 9.81 m/s².
fn mast(head: f64, bending: f64, hold: &str, more: &str) -> String {
    format!(
        "gravity = [0, 0, -9.81]\n{more}[[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\" }}\n\
         [[body]]\nname = \"base\"\nmass = 18.0\ninertia = [0.5, 0.5, 0.5]\nshape = {{ box = [0.46, 0.42, 0.25] }}\nhinge = {{ {hold} }}\n\
         [[beam]]\nname = \"mast\"\nlength = 1.75\nelements = 6\nmass_per_length = 1.0\n\
         section = {{ stiffness = [1e9, 1e9, 1e9, {bending:?}, {bending:?}, {bending:?}] }}\n\
         hinge = {{ type = \"fixed\", parent = \"base\", at = [0, 0, 0.125], rpy = [0, -1.5707963267948966, 0] }}\n\
         [[body]]\nname = \"head\"\nmass = {head:?}\ninertia = [0.01, 0.01, 0.01]\nhinge = {{ type = \"fixed\", parent = \"mast\" }}\n\
         [[force]]\nname = \"push\"\ntype = \"load\"\non = \"head\"\nforce = [0.0, 0.0, 0.0]\n\
         [[contact]]\nbetween = [\"base\", \"floor\"]\nfriction = 0.43\n"
    )
}

const STANDS: &str = "type = \"free\", position = [0, 0, 0.125, 1, 0, 0, 0]";
const CLAMPED: &str = "type = \"fixed\", at = [0, 0, 0.125]";

/// Contact that holds a base holds it as a clamp does: its mast has the modes of the clamped one, and buckles where that does.
#[test]
fn a_mast_on_what_stands_has_the_modes_of_the_clamped_one() {
    for (head, bending) in [(1.2, 900.0), (40.0, 900.0), (80.0, 900.0), (1.2, 1e4)] {
        let [on_floor, clamped] = [STANDS, CLAMPED].map(|hold| found(&mast(head, bending, hold, "")).1);
        let [on_floor, clamped] = [&on_floor, &clamped].map(|found| found.stability.as_ref().expect("a verdict"));
        assert_eq!(on_floor.verdict, clamped.verdict, "{head} kg");
        assert_eq!(on_floor.verdict, if head > 60.0 { Unstable } else { Stable }, "{head} kg");
        for (one, clamp) in on_floor.modes.iter().zip(&clamped.modes).take(6) {
            let sizes = [one, clamp].map(|mode| mode.frequency_hz.max(mode.growth_rate));
            // Squares are known to the rounding of the fastest one, of waves along the mast: some 10^11 per second squared.
            let [square, other] =
                sizes.map(|size| if one.growth_rate > 0.0 { size * size } else { (TAU * size).powi(2) });
            assert!((square - other).abs() < 1e-6 * other + 1e-4, "{head} kg: {square} {other}");
            assert_eq!(one.growth_rate > 0.0, clamp.growth_rate > 0.0, "{head} kg");
        }
    }
}

/// How far a head may be pushed, and its scene be tilted, until the base tips or slides, while the mast bends with it: right where the pose
/// that has bent that far begins to fall, and less than of a rigid mast.
#[test]
fn ranges_are_those_of_the_mast_that_bends_with_them() {
    let asked = "statics = { margin = [\"push.force[0]\", \"tilt\"] }\n";
    let ends = |bending: f64, force: f64| {
        let text = mast(1.2, bending, STANDS, asked).replace("[0.0, 0.0, 0.0]", &format!("[{force:?}, 0.0, 0.0]"));
        let found = found(&text).1;
        let standing = found.standing.expect("a verdict");
        let tilt = standing.margins.tilt.iter().find(|(name, ..)| name == "+x").map(|(_, tilt, _)| *tilt);
        (standing.verdict, standing.margins.numbers.first().map(|range| range.range), tilt)
    };
    let (verdict, range, tilt) = ends(900.0, 3.0);
    let (range, tilt) = (range.expect("a range"), tilt.expect("a tilt"));
    assert_eq!(verdict, Verdict::Stands);
    let (_, other, _) = ends(900.0, 12.0);
    let other = other.expect("a range");
    assert!((range[0] - other[0]).abs() + (range[1] - other[1]).abs() < 1e-6 * range[1], "{range:?} {other:?}");
    for (force, expected) in [(0.9999, Verdict::Stands), (1.0001, Verdict::Falls)] {
        assert_eq!(ends(900.0, force * range[1]).0, expected, "{force} of {range:?}");
        assert_eq!(ends(900.0, force * range[0]).0, expected, "{force} of {range:?}");
    }
    // The edge is 0.23 m off, the head 2 m up, which moves by P l³ / 3 EI under P: 0.046 m.
    let (_, rigid, level) = ends(1e7, 3.0);
    let (rigid, level) = (rigid.expect("a range"), level.expect("a tilt"));
    let part = range[1] / rigid[1];
    assert!(part > 0.95 && part < 0.995 && tilt < level && tilt > 0.95 * level, "{range:?} {rigid:?} {tilt} {level}");
}
