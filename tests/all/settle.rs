//! `[statics] contact = "settle"`: guesses that do not stand, moved to where they do.

use crate::common::{Random, answered};
use nalgebra::Vector3;
use std::fmt::Write as _;
use std::sync::Arc;
use stillpoint::contact::support::Verdict;
use stillpoint::model::Model;
use stillpoint::motion::Motion;
use stillpoint::scenario::parse;
use stillpoint::statics::settings::Margin;
use stillpoint::statics::standing::{StandingReport, Unanswered, standing};
use stillpoint::statics::{Equilibrium, Settings};

fn settled(text: &str) -> (Arc<Model>, Result<Equilibrium, Unanswered>) {
    let text = format!("[statics]\ncontact = \"settle\"\n{text}");
    let scenario =
        parse("scene.toml", &text, &[]).unwrap_or_else(|problem| panic!("{}\n{text}", problem.render(false)));
    let model = Model::build(&scenario.description).unwrap();
    let found = answered(&scenario, Arc::clone(&model));
    (model, found.map(|held| held.found))
}

/// Judged anew, from the pose alone.
fn judged(text: &str, pose: &[f64]) -> StandingReport {
    let scenario = parse("scene.toml", text, &[]).unwrap();
    let model = Model::build(&scenario.description).unwrap();
    standing(&scenario.description, &model, &Settings::default(), &Margin::default(), pose).unwrap()
}

fn place(model: &Arc<Model>, pose: &[f64], body: &str) -> Vector3<f64> {
    let mut motion = Motion::new(model);
    motion.update(model, pose, &vec![0.0; model.velocity_count()]);
    let body = model.bodies.iter().find(|one| one.name == body).unwrap();
    motion.body_pose(body).translation.vector
}

const BIN: &str = "[[body]]\nname = \"bin\"\nshape = [{ plane = [0, 0, 1] }, { plane = [1, 0, 0], at = [-0.3, 0, 0] }, { plane = [-1, 0, 0], at = \
                   [0.3, 0, 0] }, { plane = [0, 1, 0], at = [0, -0.3, 0] }, { plane = [0, -1, 0], at = [0, 0.3, 0] }]\nhinge = { type = \
                   \"fixed\" }\n";

/// Balls, capsules and boxes above each other over a bin, turned anyhow.
fn heap(random: &mut Random, count: usize, friction: f64) -> String {
    let mut text = BIN.to_owned();
    for k in 0..count {
        let mut size = |low: f64, high: f64| random.between(low, high);
        let shape = match k % 3 {
            0 => format!("{{ box = [{:?}, {:?}, {:?}] }}", size(0.08, 0.2), size(0.08, 0.2), size(0.08, 0.2)),
            1 => format!("{{ sphere = {:?} }}", size(0.05, 0.1)),
            _ => format!("{{ capsule = [{:?}, {:?}] }}", size(0.03, 0.06), size(0.1, 0.2)),
        };
        let (x, y, mass) = (size(-0.12, 0.12), size(-0.12, 0.12), size(0.2, 2.0));
        let q = random.turn();
        let at = [x, y, 0.2 + 0.28 * k as f64, q.w, q.i, q.j, q.k];
        let _ = write!(
            text,
            "[[body]]\nname = \"b{k}\"\nmass = {mass:?}\ninertia = [0.002, 0.003, 0.004]\nshape = {shape}\nhinge = {{ type = \"free\", \
             position = {at:?} }}\n"
        );
    }
    text + &format!("[[contact]]\nbetween = [\"*\", \"*\"]\nfriction = {friction:?}\n")
}

#[test]
fn random_heaps_settle_to_where_they_stand() {
    let mut random = Random::new(0x5e77_1e01);
    let mut slick = 0;
    for case in 0..60 {
        let friction = if case % 4 == 0 { 0.0 } else { random.between(0.2, 0.9) };
        slick += usize::from(friction == 0.0);
        let text = heap(&mut random, 1 + case % 4, friction);
        let (_, found) = settled(&text);
        let found = found.unwrap_or_else(|error| panic!("case {case}: {error}\n{text}"));
        assert!(found.converged, "case {case}: {:?}\n{text}", found.notes);
        let again = judged(&text, &found.position);
        assert_eq!(again.verdict, Verdict::Stands, "case {case}: {}", again.slack);
        assert!(found.notes.iter().any(|note| note.contains("settled from the given pose")), "{:?}", found.notes);
    }
    assert_eq!(slick, 15);
}

/// A ball on three fixed ones without friction: its centre is at the distance of both radii from each of theirs.
#[test]
fn a_ball_settles_between_three_others() {
    let mut random = Random::new(0xba11);
    for case in 0..40 {
        let centers: Vec<(Vector3<f64>, f64)> = (0..3)
            .map(|k| {
                let angle = std::f64::consts::TAU * (f64::from(k) + random.between(-0.1, 0.1)) / 3.0;
                let radius = random.between(0.08, 0.12);
                (Vector3::new(0.12 * angle.cos(), 0.12 * angle.sin(), random.between(0.0, 0.02)), radius)
            })
            .collect();
        let radius = random.between(0.1, 0.14);
        let shapes: Vec<String> = centers
            .iter()
            .map(|(at, r)| format!("{{ sphere = {r:?}, at = [{:?}, {:?}, {:?}] }}", at.x, at.y, at.z))
            .collect();
        let text = format!(
            "[[body]]\nname = \"nest\"\nshape = [{}]\nhinge = {{ type = \"fixed\" }}\n[[body]]\nname = \"ball\"\nmass = 1.0\ninertia = [0.004, \
             0.004, 0.004]\nshape = {{ sphere = {radius:?} }}\nhinge = {{ type = \"free\", position = [{:?}, {:?}, 0.4, 1, 0, 0, 0] \
             }}\n[[contact]]\nbetween = [\"nest\", \"ball\"]\n",
            shapes.join(", "),
            random.between(-0.03, 0.03),
            random.between(-0.03, 0.03),
        );
        let (model, found) = settled(&text);
        let found = found.unwrap_or_else(|error| panic!("case {case}: {error}\n{text}"));
        assert!(found.converged, "case {case}: {:?}", found.notes);
        let at = place(&model, &found.position, "ball");
        for (center, r) in &centers {
            let off = (at - center).norm() - r - radius;
            assert!(off.abs() < 1e-10, "case {case}: {off:e}");
        }
        assert!(at.z > centers[0].0.z);
    }
}

/// A bar on a hinge with a spring comes down on a floor: it leans on its round end, or the spring holds it off the floor.
#[test]
fn a_flap_leans_on_the_floor_or_hangs_in_its_spring() {
    let mut random = Random::new(0xf1a9);
    let (mut leaning, mut hanging) = (0, 0);
    for case in 0..40 {
        let (length, radius, height) = (0.5, random.between(0.01, 0.03), random.between(0.1, 0.4));
        let stiffness = random.between(0.1, 30.0);
        let text = format!(
            "[[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\" }}\n[[body]]\nname = \"flap\"\nmass = \
             1.0\ncenter = [0.25, 0, 0]\ninertia = [0.001, 0.03, 0.03]\nshape = {{ sphere = {radius:?}, at = [{length:?}, 0, 0] }}\nhinge = {{ \
             type = \"revolute\", axis = [0, -1, 0], at = [0, 0, {height:?}], position = [0.6], stiffness = [{stiffness:?}] }}\n[[contact]]\nbetween = \
             [\"floor\", \"flap\"]\nfriction = 0.3\n"
        );
        let (_, found) = settled(&text);
        let found = found.unwrap_or_else(|error| panic!("case {case}: {error}\n{text}"));
        assert!(found.converged, "case {case}: {:?}\n{text}", found.notes);
        let angle = found.position[0];
        let touching = -((height - radius) / length).asin();
        // What the spring lacks at an angle (N m).
        let falls = |angle: f64| 9.80665 * 0.25 * angle.cos() + stiffness * angle;
        if falls(touching) > 0.0 {
            leaning += 1;
            assert!((angle - touching).abs() < 1e-12, "case {case}: {angle} {touching}");
        } else {
            hanging += 1;
            assert!(falls(angle).abs() < 1e-9 && angle > touching, "case {case}: {angle} {touching}");
        }
    }
    assert!(leaning > 5 && hanging > 5, "{leaning} {hanging}");
}

#[test]
fn what_falls_for_ever_does_not_settle() {
    let text = "[[body]]\nname = \"table\"\nshape = { box = [0.3, 0.3, 0.1] }\nhinge = { type = \"fixed\" }\n[[body]]\nname = \"cup\"\nmass = \
                1.0\ninertia = [0.01, 0.01, 0.01]\nshape = { box = [0.2, 0.2, 0.2] }\nhinge = { type = \"free\", position = [0.24, 0, 0.18, 1, 0, \
                0, 0] }\n[[contact]]\nbetween = [\"table\", \"cup\"]\nfriction = 0.4\n";
    let error = settled(text).1.unwrap_err().to_string();
    assert!(error.contains("does not settle") && error.contains("nothing stops it"), "{error}");
}

/// Every shipped scene that asks whether it stands does, two of them where they settle or with the inputs that they ask for.
#[test]
fn the_shipped_scenes_stand() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/standing");
    let mut count = 0;
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let scenario = stillpoint::scenario::load(&path).unwrap_or_else(|error| panic!("{error}"));
        let model = Model::build(&scenario.description).unwrap();
        let found = answered(&scenario, model).unwrap_or_else(|error| panic!("{}: {error}", path.display())).found;
        assert!(found.converged, "{}: {:?}", path.display(), found.notes);
        count += 1;
    }
    assert!(count >= 7, "{count}");
}

/// What stands as it is given is kept bit for bit, settling asked for or not.
#[test]
fn what_stands_does_not_settle() {
    let text = "[[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n[[body]]\nname = \"box\"\nmass = \
                1.0\ninertia = [0.01, 0.01, 0.01]\nshape = { box = [0.2, 0.2, 0.2] }\nhinge = { type = \"free\", position = [0.24, 0, 0.1, 1, 0, \
                0, 0] }\n[[contact]]\nbetween = [\"floor\", \"box\"]\nfriction = 0.4\n";
    let (model, found) = settled(text);
    let found = found.unwrap();
    assert!(found.converged && found.position == model.start_position && found.stage == "given");
}

/// An arm on a spring settles on what stands: what its hinge lacks in the end is round-off of what cancels there, and no light load that is
/// refused beside heavy ones. The angle is that at which spring and weight balance.
#[test]
fn an_arm_on_a_spring_settles_on_a_foot() {
    let mut random = Random::new(0xa3);
    for case in 0..12 {
        let (stiffness, length) = (random.between(500.0, 5000.0), random.between(0.05, 0.1));
        let (mass, start) = (random.between(0.05, 0.5), random.between(-0.2, 0.3));
        let text = format!(
            "[[body]]\nname = \"table\"\nshape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\" }}\n[[body]]\nname = \"foot\"\ndensity = \
             7800.0\nshape = {{ box = [0.2, 0.2, 0.02], at = [0, 0, 0.01] }}\nhinge = {{ type = \"free\" }}\n[[body]]\nname = \"arm\"\nmass = \
             {mass:?}\ninertia = [2e-3, 2e-3, 1e-5]\ncenter = [0, 0, 0.19]\nhinge = {{ type = \"revolute\", parent = \"foot\", at = [0, 0, 0.02], axis \
             = [0, 1, 0], position = {start:?} }}\n[[force]]\ntype = \"spring\"\nbetween = [{{ body = \"foot\", at = [-0.03, 0, 0.06] }}, {{ body = \
             \"arm\", at = [0, 0, 0.12] }}]\nstiffness = {stiffness:?}\nlength = {length:?}\n[[contact]]\nbetween = [\"foot\", \"table\"]\nfriction = \
             0.4\n"
        );
        let (_, found) = settled(&text);
        let found = found.unwrap_or_else(|error| panic!("case {case}: {error}\n{text}"));
        assert!(found.converged, "case {case}: {:?}\n{text}", found.notes);
        // The moment about the hinge (N m) of spring and weight.
        let angle = *found.position.last().unwrap();
        let eye = Vector3::new(0.12 * angle.sin(), 0.0, 0.12 * angle.cos());
        let off = Vector3::new(-0.03, 0.0, 0.04) - eye;
        let tension = stiffness * (off.norm() - length);
        let spring = eye.cross(&(off.normalize() * tension)).y;
        let weight = mass * 9.80665 * 0.19 * angle.sin();
        // Hinges are balanced to 1e-12 of what cancels in them.
        assert!((spring + weight).abs() < 1e-11 * (1.0 + tension.abs()), "case {case}: {spring} {weight}");
    }
}

/// Capsules without friction whose centre of mass is off their axis, in funnels: nothing turns them about that axis but their weight, which
/// hangs below it at last.
#[test]
fn a_capsule_settles_with_its_heavy_side_down() {
    let funnels = [
        "{ plane = [-0.5144, 0.1882, 0.8366], at = [0.1131, -0.0021, 0] }, { plane = [-0.2434, -0.6088, 0.7551], at = [0.0321, 0.192, 0] }, \
         { plane = [0.4964, -0.3115, 0.8103], at = [-0.0266, 0.0502, 0] }, { plane = [0.2332, 0.3405, 0.9109], at = [-0.07, -0.0382, 0] }",
        "{ plane = [0.7915, -0.241, 0.5617], at = [-0.1043, 0.0789, 0] }, { plane = [0.1068, 0.1974, 0.9745], at = [-0.0411, -0.0271, 0] }, \
         { plane = [-0.31, 0.561, 0.7676], at = [0.0771, -0.0038, 0] }, { plane = [-0.4815, -0.0872, 0.8721], at = [0.0427, 0.021, 0] }, \
         { plane = [-0.1271, -0.7863, 0.6046], at = [0.0243, 0.0924, 0] }",
    ];
    let capsules = [
        ([-0.023, 0.0074, 0.0166], [0.0976, 0.3064], [-0.0081, -0.0875, 1.2, 0.88774, 0.28104, 0.28815, -0.22338]),
        ([0.0036, -0.0184, 0.0218], [0.0973, 0.3608], [0.0925, 0.0212, 1.2, -0.736, 0.35512, -0.48407, 0.31285]),
    ];
    for (planes, (center, shape, mut start)) in funnels.iter().zip(capsules) {
        let size = start[3..].iter().map(|x: &f64| x * x).sum::<f64>().sqrt();
        start[3..].iter_mut().for_each(|x| *x /= size);
        let text = format!(
            "[[body]]\nname = \"funnel\"\nshape = [{planes}]\nhinge = {{ type = \"fixed\" }}\n\
             [[body]]\nname = \"capsule\"\nmass = 1.0\ncenter = {center:?}\ninertia = [0.01, 0.01, 0.01]\n\
             shape = {{ capsule = {shape:?} }}\nhinge = {{ type = \"free\", position = {start:?} }}\n\
             [[contact]]\nbetween = [\"capsule\", \"funnel\"]\nfriction = 0.0\n"
        );
        let (_, found) = settled(&text);
        let found = found.unwrap_or_else(|why| panic!("{why}\n{text}"));
        assert!(found.converged, "{:?}\n{text}", found.notes);
        let q = &found.position[3..7];
        let turn = nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]));
        let across = Vector3::new(center[0], center[1], 0.0).normalize();
        // Across the axis, the weight pulls to where the centre is and no way beside it: to the rounding of positions over its arm.
        let (to_center, beside) = (turn * across, turn * Vector3::z().cross(&across));
        assert!(to_center.z < 0.0 && beside.z.abs() < 1e-9, "{to_center} {beside}\n{text}");
    }
}

/// Planes around the vertical axis, steep or flat, that pass beside the origin by up to `aside` (m): what lies in them has a lowest place.
fn bowl(random: &mut Random, aside: f64) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let (count, turn) = (3 + random.below(3), random.between(0.0, 6.0));
    let plane = |k: usize| {
        let around = turn + std::f64::consts::TAU * k as f64 / count as f64 + random.between(-0.2, 0.2);
        let steep = random.between(0.15, 1.2);
        let normal = Vector3::new(around.cos() * steep.sin(), around.sin() * steep.sin(), steep.cos());
        (normal, Vector3::new(-normal.x, -normal.y, 0.0) * random.between(0.0, 1.0) * aside)
    };
    (0..count).map(plane).collect()
}

fn in_bowl(planes: &[(Vector3<f64>, Vector3<f64>)], shape: &str, start: [f64; 7], friction: f64) -> String {
    let planes = planes.iter().map(|(n, at)| {
        format!("{{ plane = [{:?}, {:?}, {:?}], at = [{:?}, {:?}, {:?}] }}", n.x, n.y, n.z, at.x, at.y, at.z)
    });
    format!(
        "[[body]]\nname = \"bowl\"\nshape = [{}]\nhinge = {{ type = \"fixed\" }}\n[[body]]\nname = \"one\"\nmass = 1.3\ninertia = [0.01, \
         0.01, 0.01]\n{shape}\nhinge = {{ type = \"free\", position = {start:?} }}\n[[contact]]\nbetween = [\"one\", \"bowl\"]\nfriction = \
         {friction:?}\n",
        planes.collect::<Vec<_>>().join(", ")
    )
}

/// The lowest place of the middle of a ball: of the corners of three planes at the ball's radius the lowest that is on the right side of all others.
fn lowest(planes: &[(Vector3<f64>, Vector3<f64>)], radius: f64) -> Option<Vector3<f64>> {
    let mut found: Option<Vector3<f64>> = None;
    for (i, j, k) in (0..planes.len()).flat_map(|i| (0..i).flat_map(move |j| (0..j).map(move |k| (i, j, k)))) {
        let rows = [i, j, k].map(|p| planes[p].0.transpose());
        let right = Vector3::from_iterator([i, j, k].map(|p| planes[p].0.dot(&planes[p].1) + radius));
        let Some(inverse) = nalgebra::Matrix3::from_rows(&rows).try_inverse() else { continue };
        let at = inverse * right;
        let inside = planes.iter().all(|(normal, point)| (at - point).dot(normal) > radius - 1e-9);
        if inside && found.is_none_or(|found| at.z < found.z) {
            found = Some(at);
        }
    }
    found
}

/// A ball settles in bowls of planes, whatever its friction: without any in the lowest place, with some no lower.
#[test]
fn a_ball_settles_in_a_bowl() {
    let (mut random, mut refused) = (Random::new(0xb0), 0);
    for case in 0..30 {
        let (planes, radius) = (bowl(&mut random, 0.4), random.between(0.05, 0.2));
        // In turns as free of a ball as the lowest place is only if planes lean to all sides.
        let Some(low) = lowest(&planes, radius) else { continue };
        let start = [random.between(-0.4, 0.4), random.between(-0.4, 0.4), 2.0, 1.0, 0.0, 0.0, 0.0];
        for friction in [0.0, 0.01, 0.1, 0.3, 1.0] {
            let text = in_bowl(&planes, &format!("shape = {{ sphere = {radius:?} }}"), start, friction);
            let (model, found) = settled(&text);
            let Ok(found) = found else {
                refused += 1;
                continue;
            };
            assert!(found.converged, "case {case}, {friction}: {:?}\n{text}", found.notes);
            let at = place(&model, &found.position, "one");
            // What counts as closed is 1e-6 of the radius; corners of flat angles magnify it.
            assert!(at.z > low.z - 1e-5 && (friction > 0.0 || (at.z - low.z).abs() < 1e-5), "case {case}: {at} {low}");
            assert_eq!(judged(&text, &found.position).verdict, Verdict::Stands, "case {case}, {friction}\n{text}");
        }
    }
    // What is not found is said; of 100 and more it may be one.
    assert!(refused <= 1, "{refused} balls did not settle");
}

/// Capsules, cylinders and boxes settle in funnels, with friction and without.
#[test]
fn what_is_long_settles_in_a_funnel() {
    let (mut random, mut refused) = (Random::new(0xf1), 0);
    for case in 0..45 {
        let planes = bowl(&mut random, 0.4 * (case % 2) as f64);
        let (radius, length) = (random.between(0.03, 0.1), random.between(0.1, 0.4));
        let shape = match case % 3 {
            0 => format!("capsule = [{radius:?}, {length:?}]"),
            1 => format!("cylinder = [{radius:?}, {length:?}]"),
            _ => format!("box = [{:?}, {:?}, {length:?}]", 2.0 * radius, 3.0 * radius),
        };
        let center = [0; 3].map(|_| random.between(-0.02, 0.02));
        let q = random.turn();
        for friction in [0.0, 0.3] {
            let shape = format!("center = {center:?}\nshape = {{ {shape} }}");
            let text = in_bowl(&planes, &shape, [0.0, 0.0, 1.5, q.w, q.i, q.j, q.k], friction);
            let (_, found) = settled(&text);
            let Some(found) = found.ok().filter(|found| found.converged) else {
                refused += 1;
                continue;
            };
            assert_eq!(judged(&text, &found.position).verdict, Verdict::Stands, "case {case}, {friction}\n{text}");
        }
    }
    // As above, of 90; one is told to fall, by a load of 1e-12 of its weight that no support feels.
    assert!(refused <= 2, "{refused} scenes did not settle");
}

/// A four-bar of capsules, free or on a pivot, over a floor that holds it by friction or not at all.
fn ring(random: &mut Random) -> String {
    let mut size = |low: f64, high: f64| random.between(low, high);
    let (base, side) = (size(0.2, 0.4), size(0.15, 0.35));
    let lengths = [base, side, side * size(0.8, 1.2), base * size(0.8, 1.1)];
    let angles = [-size(1.0, 2.0), -size(1.0, 2.0), -size(1.0, 2.0)];
    let free = size(0.0, 1.0) < 0.6;
    let friction = if size(0.0, 1.0) < 0.5 { 0.0 } else { size(0.2, 0.9) };
    let root = match free {
        true => format!(
            "{{ type = \"free\", at = [0, 0, 0.7], rpy = [{:?}, {:?}, {:?}] }}",
            size(-1.0, 1.0),
            size(-0.5, 0.5),
            size(-3.0, 3.0)
        ),
        false => format!(
            "{{ type = \"revolute\", axis = [0, 1, 0], at = [0, 0, {:?}], position = {:?} }}",
            size(0.2, 0.5),
            size(-0.5, 0.5)
        ),
    };
    let on = |parent: &str, angle: f64| {
        format!("{{ type = \"revolute\", {parent}, axis = [0, 1, 0], position = {angle:?} }}")
    };
    let hinges = [
        root,
        on("parent = \"l0\", at = \"tip\"", angles[0]),
        on("parent = \"l0\"", angles[1]),
        on("parent = \"l1\", at = \"tip\"", angles[2]),
    ];
    let mut text =
        "[[body]]\nname = \"land\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n".to_owned();
    for (k, (length, hinge)) in lengths.iter().zip(hinges).enumerate() {
        let (mass, radius) = (10.0_f64.powf(size(-1.0, 0.5)), size(0.02, 0.04));
        let across = mass * length * length / 12.0 + 1e-4;
        let _ = write!(
            text,
            "[[body]]\nname = \"l{k}\"\nmass = {mass:?}\ncenter = [{:?}, 0, 0]\ninertia = [{:?}, {across:?}, {across:?}]\nmarkers = {{ tip = \
             [{length:?}, 0, 0] }}\nshape = {{ capsule = [{radius:?}, {length:?}], at = [{:?}, 0, 0], rpy = [0, {:?}, 0] }}\nhinge = {hinge}\n\
             [[contact]]\nbetween = [\"land\", \"l{k}\"]\nfriction = {friction:?}\n",
            length / 2.0,
            mass * radius * radius,
            length / 2.0,
            std::f64::consts::FRAC_PI_2,
        );
    }
    text + "[[loop]]\nname = \"close\"\ntype = \"revolute\"\nbetween = [\"l3.tip\", \"l2.tip\"]\naxis = [0, 1, 0]\n"
}

/// What only its contacts hold up, as a ring of bars that lies down, converges as Newton's method does, and is as near to its balance as that
/// can be told. (One of them, without friction, leaves the edge that it stands on so slowly that it still moves when the search ends.)
#[test]
fn rings_of_bars_settle_quickly() {
    let mut random = Random::new(0x0417_4b0d);
    let mut slow = 0;
    for case in 0..40 {
        let text = ring(&mut random);
        let scenario = parse("ring.toml", &format!("[statics]\ncontact = \"settle\"\n{text}"), &[]).unwrap();
        let (model, _) = stillpoint::constraint::assemble(Model::build(&scenario.description).unwrap()).unwrap();
        let found = match answered(&scenario, model).map(|held| held.found) {
            Ok(found) => found,
            Err(error) => {
                assert!(error.to_string().contains("still moves"), "case {case}: {error}\n{text}");
                slow += 1;
                continue;
            }
        };
        assert!(
            found.converged && found.iterations < 400,
            "case {case}: {} {:?}\n{text}",
            found.iterations,
            found.notes
        );
        assert!(found.relative_residual < 1e-10, "case {case}: {:e}", found.relative_residual);
    }
    assert!(slow <= 1, "{slow}");
}

/// Rods that are clamped above a floor, each with a head that it presses on it: the head slides until friction just holds it, and there is one
/// pose that bears it. What the floor pushes with is within the cone, and bends the rod as it is bent.
#[test]
fn heads_of_rods_settle_on_a_floor() {
    let mut random = Random::new(0x0d5_0f00);
    let (mut pressed, mut slips) = (0, 0);
    for case in 0..40 {
        let mut between = |low: f64, high: f64| random.between(low, high);
        let (high, tilt, length) = (between(0.1, 0.5), between(-0.6, 1.0), between(0.4, 0.8));
        let (young, thick) = (10f64.powf(between(8.5, 10.5)), between(0.004, 0.01));
        let (radius, mass, friction) = (between(0.03, 0.06), 10f64.powf(between(-1.0, 0.3)), between(0.1, 0.9));
        let inertia = mass * radius * radius;
        let text = format!(
            "[[body]]\nname = \"land\"\nhinge = {{ type = \"fixed\" }}\nshape = {{ plane = [0, 0, 1] }}\n[[beam]]\nname = \"rod\"\nhinge = {{ \
             type = \"fixed\", at = [0, 0, {high:?}], rpy = [0, {tilt:?}, 0] }}\nlength = {length:?}\nelements = {}\nsection = {{ circle = \
             {thick:?} }}\nmaterial = {{ young = {young:?}, poisson = 0.3, density = 1500.0 }}\n[[body]]\nname = \"head\"\nmass = \
             {mass:?}\ninertia = [{inertia:?}, {inertia:?}, {inertia:?}]\nshape = {{ sphere = {radius:?} }}\nhinge = {{ type = \"fixed\", parent = \
             \"rod\", at = \"tip\" }}\n[[contact]]\nbetween = [\"land\", \"head\"]\nfriction = {friction:?}\n",
            2 + 2 * (case % 2)
        );
        let (_, found) = settled(&text);
        let found = found.unwrap_or_else(|error| panic!("case {case}: {error}\n{text}"));
        assert!(
            found.converged && found.relative_residual < 1e-9,
            "case {case}: {} {:?}\n{text}",
            found.relative_residual,
            found.notes
        );
        let standing = found.standing.expect("a scene with contact");
        for one in &standing.contacts {
            pressed += 1;
            slips += usize::from(one.share > 1.0 - 1e-5);
            assert!(one.share <= 1.0, "case {case}: {}", one.share);
        }
    }
    assert!(pressed >= 15 && slips > 5, "{pressed} {slips}");
}
