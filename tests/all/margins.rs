//! How far numbers may go while a scene stands, where it follows them: ropes, what hangs on a body that stands, what is squeezed.

use crate::common::{Random, answered};
use stillpoint::contact::support::Verdict;
use stillpoint::model::Model;
use stillpoint::scenario::parse;
use stillpoint::statics::standing::StandingReport;

const G: f64 = 9.80665;
const FLOOR: &str = "[[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n";

fn judged(text: &str) -> StandingReport {
    let scenario = parse("scene.toml", text, &[]).unwrap_or_else(|problem| panic!("{}\n{text}", problem.render(false)));
    let model = Model::build(&scenario.description).unwrap();
    let found = answered(&scenario, model).unwrap_or_else(|why| panic!("{why}\n{text}")).found;
    *found.standing.expect("supports")
}

fn range(found: &StandingReport, name: &str) -> [f64; 2] {
    let one = found.margins.numbers.iter().find(|one| one.name == name);
    one.unwrap_or_else(|| panic!("{name}: {:?}", found.margins.notes)).range
}

/// Boxes that lie on each other without friction, each turned about any axis by what rounding leaves, stand, and push with their weights.
#[test]
fn what_lies_on_each_other_stands_in_spite_of_its_rounding() {
    let mut random = Random::new(71);
    for case in 0..60 {
        let count = 2 + random.below(3);
        let tilt = [0.0, 1e-13, 1e-12, 1e-11, 1e-10][case % 5];
        let mut text = FLOOR.to_owned();
        for k in 0..count {
            let [x, y] = [0; 2].map(|_| if k == 0 { 0.0 } else { random.between(-0.02, 0.02) });
            let [a, b] = [0; 2].map(|_| 0.5 * tilt * random.between(-0.7, 0.7));
            let yaw = random.between(-1.5, 1.5);
            text += &format!(
                "[[body]]\nname = \"b{k}\"\nmass = 10.0\ninertia = [1.0, 1.0, 1.0]\nshape = {{ box = [1.0, 1.0, 0.5] }}\n\
                 hinge = {{ type = \"free\", position = [{:?}, {:?}, {:?}, {:?}, {a:?}, {b:?}, {:?}] }}\n",
                x,
                y,
                0.25 + 0.5 * k as f64,
                yaw.cos(),
                yaw.sin(),
            );
        }
        text += "[[contact]]\nbetween = [\"*\", \"*\"]\nfriction = 0.0\n";
        let found = judged(&text);
        assert_eq!(found.verdict, Verdict::Stands, "{count} boxes, {tilt:e}\n{text}");
        let pushed = found.contacts.iter().filter(|one| one.contact.bodies.contains(&0));
        let sum: f64 = pushed.map(|one| one.force.z.abs()).sum();
        assert!((sum - 10.0 * G * count as f64).abs() < 1e-7 * sum, "{sum}\n{text}");
    }
}

/// A ball on a rope over two pulleys that a block on the floor holds: pushed sideways the rope bears the root of the sum of squares, which
/// has no slope where it begins; the block lifts off when that is its weight.
#[test]
fn a_rope_ends_what_its_tangent_does_not() {
    for (ball, block) in [(4.0, 10.0), (1.5, 6.0), (0.5, 12.0)] {
        // At rest the rope is longer by what the ball weighs.
        let length = 5.8 - ball * G / 1e5;
        let text = format!(
            "[statics]\nmargin = [\"push.force[0]\", \"push.force[1]\", \"push.force[2]\", \"ball.mass\"]\n{FLOOR}\
             [[body]]\nname = \"block\"\nmass = {block:?}\ninertia = [0.1, 0.1, 0.1]\nshape = {{ box = [0.4, 0.4, 0.2] }}\n\
             hinge = {{ type = \"free\", position = [1, 0, 0.1, 1, 0, 0, 0] }}\n\
             [[body]]\nname = \"ball\"\nmass = {ball:?}\ninertia = [0.01, 0.01, 0.01]\nshape = {{ sphere = 0.1 }}\n\
             hinge = {{ type = \"free\", position = [0, 0, 1, 1, 0, 0, 0] }}\n\
             [[force]]\nname = \"push\"\ntype = \"load\"\non = \"ball\"\nforce = [0, 0, 0]\n\
             [[force]]\nname = \"rope\"\ntype = \"rope\"\nthrough = [\"ball\", {{ body = \"ground\", at = [0, 0, 3] }}, \
             {{ body = \"ground\", at = [1, 0, 3] }}, {{ body = \"block\", at = [0, 0, 0.1] }}]\nstiffness = 1e5\nlength = {length:?}\n\
             [[contact]]\nbetween = [\"*\", \"*\"]\nfriction = 0.5\n"
        );
        let found = judged(&text);
        let across = G * (block * block - ball * ball).sqrt();
        for name in ["push.force[0]", "push.force[1]"] {
            let [low, high] = range(&found, name);
            assert!(
                (high - across).abs() < 1e-3 * across && (low + high).abs() < 1e-5 * across,
                "{name}: {low} {high}, {across}"
            );
        }
        assert!((range(&found, "ball.mass")[1] - block).abs() < 1e-3 * block, "{:?}", range(&found, "ball.mass"));
        // Upwards the ball flies where the rope bears nothing: that is told, and no end in words of the supports.
        let up = found.margins.numbers.iter().find(|one| one.name == "push.force[2]");
        assert!(up.is_none_or(|up| up.range[1] < 1.001 * ball * G), "{up:?}");
        assert!(up.is_some() || found.margins.notes.iter().any(|note| note.contains("push.force[2]")));
    }
}

/// What hangs on a block that stands may be as light as nothing, and the range says so; it was an error of the mass that it tried.
#[test]
fn a_mass_may_be_none() {
    for mass in [0.4, 1.0, 2.5] {
        let text = format!(
            "[statics]\nmargin = [\"ball.mass\"]\n{FLOOR}\
             [[body]]\nname = \"block\"\nmass = 10.0\ninertia = [0.1, 0.1, 0.1]\nmarkers = {{ hook = [0.15, 0.0, 1.9] }}\n\
             shape = {{ box = [0.4, 0.4, 0.2] }}\nhinge = {{ type = \"free\", position = [0, 0, 0.1, 1, 0, 0, 0] }}\n\
             [[body]]\nname = \"ball\"\nmass = {mass:?}\ninertia = [0.01, 0.01, 0.01]\ncenter = [0, 0, -0.5]\n\
             hinge = {{ type = \"spherical\", parent = \"block\", at = \"hook\" }}\n\
             [[contact]]\nbetween = [\"*\", \"*\"]\nfriction = 0.5\n"
        );
        // The hook is within the block's foot: any ball holds it down.
        assert_eq!(range(&judged(&text), "ball.mass"), [0.0, f64::INFINITY]);
    }
}
