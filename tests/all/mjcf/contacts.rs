//! Which geoms touch, and with how much friction: as MuJoCo's rules say, whatever bodies and patterns the scenario makes of it.

use crate::common::Random;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use stillpoint::hinge::HingeKind;
use stillpoint::import::{Options, import_text};
use stillpoint::model::Description;
use stillpoint::model::shape::Geometry;
use stillpoint::scenario::parse;

/// A ball of a radius that no other has, so that it is found again.
struct Ball {
    body: usize,
    radius: f64,
    masks: [u32; 2],
    dimension: u32,
    friction: f64,
    priority: i32,
}

struct Scene {
    /// Parent of every body, and how many joints it has; the first is the world.
    bodies: Vec<(usize, usize)>,
    balls: Vec<Ball>,
    excluded: Vec<[usize; 2]>,
    pairs: Vec<([usize; 2], Option<f64>)>,
    filters: bool,
}

fn scene(random: &mut Random) -> Scene {
    let count = 3 + random.below(5);
    let mut bodies = vec![(0, 0)];
    for index in 1..=count {
        bodies.push((random.below(index), [0, 1, 1, 2][random.below(4)]));
    }
    // Many alike, so that patterns are worth their while.
    let plain = random.below(2) == 0;
    let mut balls = Vec::new();
    for body in 0..bodies.len() {
        for _ in 0..if plain { 1 } else { random.below(3) } {
            let mut any = |usual: usize, n: usize| if plain && random.below(8) > 0 { usual } else { random.below(n) };
            let masks = [any(1, 4) as u32, any(1, 4) as u32];
            let (dimension, priority) = ([3, 1][any(0, 2)], any(0, 2) as i32);
            let friction = [0.5, 0.8, 0.2][any(0, 3)];
            let radius = 0.1 + 0.001 * balls.len() as f64;
            balls.push(Ball { body, radius, masks, dimension, friction, priority });
        }
    }
    let two = |random: &mut Random, n: usize| [random.below(n), random.below(n)];
    let excluded = (0..random.below(3)).map(|_| two(random, bodies.len())).filter(|[a, b]| a != b).collect();
    let mut pairs: Vec<([usize; 2], Option<f64>)> = Vec::new();
    for _ in 0..if balls.len() < 2 { 0 } else { random.below(3) } {
        let pair = two(random, balls.len());
        let apart = balls[pair[0]].body != balls[pair[1]].body;
        let known = pairs.iter().any(|(other, _)| *other == pair || *other == [pair[1], pair[0]]);
        if apart && !known {
            pairs.push((pair, [None, Some(0.9)][random.below(2)]));
        }
    }
    Scene { bodies, balls, excluded, pairs, filters: random.below(4) > 0 }
}

impl Scene {
    fn text(&self) -> String {
        let flag = if self.filters { "enable" } else { "disable" };
        let mut text = format!("<mujoco><option><flag filterparent=\"{flag}\"/></option><worldbody>");
        self.inside(0, &mut text);
        text += "</worldbody><contact>";
        let name = |body: usize| if body == 0 { "world".to_owned() } else { format!("b{body}") };
        for [one, other] in &self.excluded {
            let _ = write!(text, "<exclude body1=\"{}\" body2=\"{}\"/>", name(*one), name(*other));
        }
        for ([one, other], friction) in &self.pairs {
            let friction = friction.map_or(String::new(), |f| format!(" friction=\"{f} {f}\""));
            let _ = write!(text, "<pair geom1=\"g{one}\" geom2=\"g{other}\"{friction}/>");
        }
        text + "</contact></mujoco>"
    }

    fn inside(&self, body: usize, text: &mut String) {
        for (index, ball) in self.balls.iter().enumerate().filter(|(_, ball)| ball.body == body) {
            let Ball { radius, masks: [kind, to], dimension, friction, priority, .. } = ball;
            let _ = write!(
                text,
                "<geom name=\"g{index}\" size=\"{radius}\" contype=\"{kind}\" conaffinity=\"{to}\" condim=\"{dimension}\" \
                 friction=\"{friction}\" priority=\"{priority}\"/>"
            );
        }
        for (index, (_, joints)) in
            self.bodies.iter().enumerate().filter(|(at, (parent, _))| *at > 0 && *parent == body)
        {
            let _ = write!(text, "<body name=\"b{index}\"><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>");
            for axis in ["0 1 0", "1 0 0"].iter().take(*joints) {
                let _ = write!(text, "<joint axis=\"{axis}\"/>");
            }
            self.inside(index, text);
            *text += "</body>";
        }
    }

    fn weld(&self, body: usize) -> usize {
        if body == 0 || self.bodies[body].1 > 0 { body } else { self.weld(self.bodies[body].0) }
    }

    /// The coefficient of friction of two geoms that may touch, by "Collision detection: Selection" and "Contact parameters" of
    /// MuJoCo's manual.
    fn expected(&self, one: usize, other: usize) -> Option<f64> {
        let [a, b] = [&self.balls[one], &self.balls[other]];
        let [u, v] = [a, b].map(|ball| self.weld(ball.body));
        if u == v {
            return None;
        }
        let same = |pair: &[usize; 2], x: usize, y: usize| *pair == [x, y] || *pair == [y, x];
        let (dimension, friction) = match a.priority.cmp(&b.priority) {
            std::cmp::Ordering::Greater => (a.dimension, a.friction),
            std::cmp::Ordering::Less => (b.dimension, b.friction),
            std::cmp::Ordering::Equal => (a.dimension.max(b.dimension), a.friction.max(b.friction)),
        };
        let coefficient = |friction: f64| if dimension == 1 { 0.0 } else { friction };
        if let Some((_, own)) = self.pairs.iter().find(|(pair, _)| same(pair, one, other)) {
            // A pair has its own defaults.
            return Some(own.unwrap_or(1.0));
        }
        let above = |weld: usize| self.weld(self.bodies[weld].0);
        let family = u != 0 && v != 0 && (above(u) == v || above(v) == u);
        let willing = a.masks[0] & b.masks[1] != 0 || b.masks[0] & a.masks[1] != 0;
        let excluded = self.excluded.iter().any(|pair| same(pair, a.body, b.body));
        (willing && !excluded && !(family && self.filters)).then(|| coefficient(friction))
    }
}

/// What a scenario says of two balls: the last contact that names their bodies counts.
fn said(scene: &Description, one: f64, other: f64) -> Option<f64> {
    let owner = |radius: f64| {
        let has =
            |shape: &stillpoint::model::shape::Shape| shape.collides && shape.geometry == Geometry::Sphere(radius);
        scene.bodies.iter().find(|body| body.shapes.iter().any(has))
    };
    let (a, b) = (owner(one)?, owner(other)?);
    let parent = |name: &str| scene.bodies.iter().find(|body| body.name == name).map(|body| &body.hinge);
    let weld = |name: &str| {
        let mut at = name.to_owned();
        while let Some(hinge) = parent(&at).filter(|hinge| matches!(hinge.kind, HingeKind::Fixed)) {
            at.clone_from(&hinge.parent);
        }
        at
    };
    if weld(&a.name) == weld(&b.name) {
        return None;
    }
    let fits = |pattern: &str, name: &str| pattern == "*" || pattern == name;
    let hangs = a.hinge.parent == b.name || b.hinge.parent == a.name;
    let rule = scene.contacts.iter().rev().find(|contact| {
        let [x, y] = &contact.between;
        let named = x != "*" && y != "*";
        let both = fits(x, &a.name) && fits(y, &b.name) || fits(x, &b.name) && fits(y, &a.name);
        both && (named || !hangs)
    });
    rule.map(|contact| contact.friction.stick)
}

fn taken(scene: &Scene) -> Description {
    let options = Options { contact: true, ..Options::default() };
    let text = scene.text();
    let imported = import_text(Path::new("model.xml"), text.clone(), &options);
    let imported = imported.unwrap_or_else(|refused| panic!("{refused}\n{text}"));
    let parsed = parse("model.toml", &imported.scenario, &[]);
    parsed.unwrap_or_else(|problems| panic!("{problems}\n{}", imported.scenario)).description
}

#[test]
fn geoms_touch_as_masks_parents_pairs_and_exclusions_say() {
    let mut random = Random::new(0xc0_1de5);
    let (mut touching, mut apart, mut patterns) = (0, 0, 0);
    for _ in 0..300 {
        let scene = scene(&mut random);
        let description = taken(&scene);
        patterns +=
            usize::from(description.contacts.iter().any(|contact| contact.between.iter().any(|side| side == "*")));
        for one in 0..scene.balls.len() {
            for other in one + 1..scene.balls.len() {
                let expected = scene.expected(one, other);
                let found = said(&description, scene.balls[one].radius, scene.balls[other].radius);
                assert_eq!(found, expected, "g{one} and g{other}: {}", scene.text());
                *if expected.is_some() { &mut touching } else { &mut apart } += 1;
            }
        }
    }
    assert!(touching > 1000 && apart > 1000 && patterns > 50, "{touching} {apart} {patterns}");
}

/// All balls stand in one place: MuJoCo then has a contact for every pair that may touch.
#[test]
#[ignore = "needs Python with mujoco-core (tests/python/requirements.txt)"]
fn geoms_touch_as_in_mujoco() {
    let mut random = Random::new(0xc0_1de6);
    let folder = tempfile::tempdir().expect("a folder");
    let scenes: Vec<Scene> = (0..60).map(|_| scene(&mut random)).collect();
    for (index, scene) in scenes.iter().enumerate() {
        std::fs::write(folder.path().join(format!("{index}.xml")), scene.text()).expect("written");
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/mjcf_contacts.py");
    let files = (0..scenes.len()).map(|index| format!("{index}.xml"));
    let output = Command::new("python3").arg(script).args(files).current_dir(folder.path()).output().expect("run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let mut touching = 0;
    for (index, scene) in scenes.iter().enumerate() {
        let description = taken(scene);
        for one in 0..scene.balls.len() {
            for other in one + 1..scene.balls.len() {
                // What is welded together has a contact in MuJoCo if a <pair> names it, and nothing that it could do.
                if scene.weld(scene.balls[one].body) == scene.weld(scene.balls[other].body) {
                    continue;
                }
                let found = said(&description, scene.balls[one].radius, scene.balls[other].radius);
                let theirs = read[format!("{index}.xml")][format!("g{one} g{other}")].as_f64();
                assert_eq!(found.is_some(), theirs.is_some(), "g{one} and g{other}: {}", scene.text());
                // MuJoCo lets no friction be below 1e-5; `condim` 1 has none.
                assert!(
                    (found.unwrap_or(0.0) - theirs.unwrap_or(0.0)).abs() < 1e-12,
                    "{found:?} {theirs:?}: {}",
                    scene.text()
                );
                touching += usize::from(found.is_some());
            }
        }
    }
    assert!(touching > 100, "{touching}");
}
