//! What contacts do to what they have nothing to do with, and what both do together: forces of drives, gears and loops, rigid stops and dry
//! friction of hinges in captured steps.

use super::Bench;
use crate::common::Random;

const G: f64 = 9.80665;

const FLOOR: &str = "[[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n";

/// A free box that rests on the floor.
fn resting(at: f64) -> String {
    format!(
        "[[body]]\nname = \"rest\"\nmass = 2.0\ninertia = [0.02, 0.02, 0.02]\nshape = {{ box = [0.4, 0.3, 0.1] }}\n\
         hinge = {{ type = \"free\", position = [{at:?}, 5.0, 0.05, 1, 0, 0, 0] }}\n\
         [[contact]]\nbetween = [\"floor\", \"rest\"]\nfriction = 0.4\n"
    )
}

fn output(name: &str, of: &str) -> String {
    format!("[[output]]\nname = \"{name}\"\ntype = \"force\"\nof = \"{of}\"\n")
}

/// Gear, drive and loop push what they have to, whether a box rests somewhere or not; a drive bears what lies on what it holds.
#[test]
fn drives_gears_and_loops_push_the_same_beside_contact() {
    let (bench, mut random) = (Bench::new(), Random::new(61));
    for _ in 0..4 {
        let [one, other, arm, load] = [0; 4].map(|_| random.between(0.5, 4.0));
        let (push, length) = (random.between(1.0, 9.0), random.between(0.2, 0.9));
        let slide = |name: &str, mass: f64, more: &str| {
            format!(
                "[[body]]\nname = \"{name}\"\nmass = {mass:?}\ninertia = [0.1, 0.1, 0.1]\nhinge = {{ type = \"prismatic\", {more} }}\n"
            )
        };
        let scene = "simulate = { start = \"given\", duration = 0.2, tolerance = 1e-9 }\n".to_owned()
            + FLOOR
            + &slide("x", one, &format!("axis = [1, 0, 0], force = {push:?}"))
            + &slide("y", other, "axis = [0, 1, 0], at = [9, 0, 0]")
            + &slide("table", one, "axis = [0, 0, 1], at = [20, 0, 1]")
            + "shape = { box = [1.0, 1.0, 0.2] }\n"
            + &format!(
                "[[body]]\nname = \"arm\"\nmass = {arm:?}\ncenter = [{length:?}, 0, 0]\ninertia = [0.1, 0.1, 0.1]\n\
                 hinge = {{ type = \"revolute\", axis = [0, 1, 0], at = [0, 9, 0] }}\n\
                 [[body]]\nname = \"hung\"\nmass = {arm:?}\ninertia = [0.1, 0.1, 0.1]\nhinge = {{ type = \"prismatic\", axis = [0, 0, 1], at = [30, 0, -2] }}\n\
                 [[loop]]\nname = \"rod\"\ntype = \"rod\"\nbetween = [\"hung\", {{ body = \"ground\", at = [30, 0, 0] }}]\nlength = 2.0\n\
                 [[body]]\nname = \"load\"\nmass = {load:?}\ninertia = [0.1, 0.1, 0.1]\nshape = {{ box = [0.2, 0.2, 0.2] }}\n\
                 hinge = {{ type = \"free\", position = [20, 0, 1.2, 1, 0, 0, 0] }}\n\
                 [[contact]]\nbetween = [\"table\", \"load\"]\nfriction = 0.5\n\
                 [[gear]]\nname = \"gear\"\ntype = \"ratio\"\nbetween = [\"y\", \"x\"]\nratio = 1.0\n\
                 [[drive]]\nname = \"holds\"\nhinge = \"arm\"\ntype = \"hold\"\n[[drive]]\nname = \"lifts\"\nhinge = \"table\"\ntype = \"hold\"\n"
            )
            + &resting(0.0)
            + &output("of gear", "gear")
            + &output("of arm", "holds")
            + &output("of table", "lifts")
            + &output("of rod", "rod");
        bench.write("scene.toml", &scene);
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        let expected = [
            ("of gear", other * push / (one + other)),
            ("of arm", -arm * G * length),
            ("of table", (one + load) * G),
            ("of rod", arm * G),
        ];
        for (name, right) in expected {
            let value = told["outputs"][name].as_f64().expect("a number");
            assert!((value - right).abs() < 1e-8 * right.abs(), "{name}: {value}, not {right}\n{scene}");
        }
    }
}

/// A cart under a ball that spins hits a stop: the slip turns round, and friction with it. Dry friction of its rail makes steps capture it.
#[test]
fn friction_turns_with_the_slip_in_captured_steps() {
    let (bench, mut random) = (Bench::new(), Random::new(62));
    let (cart, ball, radius, friction, rail, speed, limit) = (100.0, 1.0, 0.1, 0.5, 0.001, 1.0, 0.05);
    let (inertia, spin, first) = (0.004, 8.0, 0.2);
    for _ in 0..4 {
        let (restitution, duration) = (random.between(0.2, 0.8), random.between(0.055, 0.065));
        bench.write(
            "scene.toml",
            format!(
                "simulate = {{ start = \"given\", duration = {duration:?}, tolerance = 1e-8 }}\n\
                 [[body]]\nname = \"cart\"\nmass = {cart:?}\ninertia = [0.1, 0.1, 0.1]\nshape = {{ box = [4.0, 1.0, 0.1] }}\n\
                 hinge = {{ type = \"prismatic\", axis = [1, 0, 0], velocity = {speed:?}, friction = {rail:?}, \
                 limits = {{ high = {limit:?}, restitution = {restitution:?} }} }}\n\
                 [[body]]\nname = \"ball\"\nmass = {ball:?}\ninertia = [{inertia:?}, {inertia:?}, {inertia:?}]\nshape = {{ sphere = {radius:?} }}\n\
                 hinge = {{ type = \"free\", position = [0, 0, 0.15, 1, 0, 0, 0], velocity = [{first:?}, 0, 0, 0, {spin:?}, 0] }}\n\
                 [[contact]]\nbetween = [\"cart\", \"ball\"]\nfriction = {friction:?}\n"
            ),
        );
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        // The ball slips backward to the impact, forward from there on: its own friction, and that on the cart.
        let own = friction * G;
        let braked = -(own * ball + rail) / cart;
        let hit = (-speed + (speed * speed + 2.0 * braked * limit).sqrt()) / braked;
        let after = duration - hit;
        let at_hit = first + own * hit;
        let x = first * hit + 0.5 * own * hit * hit + at_hit * after - 0.5 * own * after * after;
        let end = at_hit - own * after;
        let slip = end - radius * (spin - radius * own * ball * (hit - after) / inertia) + restitution * speed;
        assert!(slip > 0.0, "it still slips forward: {slip}");
        let [place, moves] =
            ["positions", "velocities"].map(|of| told["final"][of]["ball"][0].as_f64().expect("a number"));
        // Of order 1 at the impact.
        assert!((place - x).abs() < 2e-5 && (moves - end).abs() < 1e-3, "{restitution}: {place} {x}, {moves} {end}");
    }
}

/// Rigid stops hold in captured steps whatever drives and gears there are elsewhere, and let nothing creep away or gain.
#[test]
fn stops_hold_in_captured_steps_beside_drives() {
    let bench = Bench::new();
    let drive = "[[body]]\nname = \"motor\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\nhinge = { type = \"revolute\", axis = [0, 0, 1], at = [20, 0, 0] }\n\
                 [[drive]]\nname = \"d\"\nhinge = \"motor\"\ntype = \"rate\"\nrate = 3.0\n";
    for (beside, restitution) in [("", 0.0), ("", 1.0), (drive, 0.0), (drive, 1.0)] {
        bench.write(
            "scene.toml",
            format!(
                "simulate = {{ start = \"given\", duration = 0.2, tolerance = 1e-9 }}\n\
                 [[body]]\nname = \"cart\"\nmass = 2.0\ninertia = [0.1, 0.1, 0.1]\nshape = {{ box = [3.0, 1.0, 0.1] }}\n\
                 hinge = {{ type = \"prismatic\", axis = [1, 0, 0], velocity = 1.0, limits = {{ high = 0.1, restitution = {restitution:?} }} }}\n\
                 [[body]]\nname = \"b\"\nmass = 1.0\ninertia = [0.01, 0.01, 0.01]\nshape = {{ box = [0.4, 0.3, 0.02] }}\n\
                 hinge = {{ type = \"free\", position = [0, 0, 0.06, 1, 0, 0, 0], velocity = [1, 0, 0, 0, 0, 0] }}\n\
                 [[contact]]\nbetween = [\"cart\", \"b\"]\nfriction = 0.0\n{beside}"
            ),
        );
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        let number = |of: &str| {
            told["final"][of]["cart"][0].as_f64().or_else(|| told["final"][of]["cart"].as_f64()).expect("a number")
        };
        let (x, v) = (number("positions"), number("velocities"));
        assert!((v + restitution).abs() < 1e-9, "{restitution} {beside}: {v}");
        assert!((x - (0.1 - restitution * 0.1)).abs() < 1e-3, "{restitution} {beside}: {x}");
        let lost = told["energy_dissipated"].as_f64().expect("a number");
        assert!((lost - (1.0 - restitution)).abs() < 1e-8, "{restitution} {beside}: {lost}");
    }
}

/// Where friction at rest is more than in motion, what comes to rest stays where that holds it, on one point of contact or on many.
#[test]
fn what_stops_is_held_by_the_friction_of_rest() {
    let (bench, mut random) = (Bench::new(), Random::new(63));
    let ball = |x: f64, y: f64| format!("{{ sphere = 0.05, at = [{x:?}, {y:?}, 0.0] }}");
    let balls = format!("[{}, {}, {}]", ball(0.3, 0.0), ball(-0.3, 0.2), ball(-0.3, -0.2));
    for shape in ["{ box = [0.8, 0.3, 0.1] }", "{ cylinder = [0.5, 0.1] }", &balls] {
        for _ in 0..3 {
            let (mass, slide) = (random.between(0.5, 5.0), random.between(0.1, 0.4));
            let slope = slide + random.between(0.05, 0.2);
            let stick = slope * random.between(1.05, 1.5);
            let speed = random.between(0.2, 0.6);
            let (sine, cosine) = (slope / slope.hypot(1.0), 1.0 / slope.hypot(1.0));
            bench.write(
                "scene.toml",
                format!(
                    "gravity = [{:?}, 0, {:?}]\nsimulate = {{ start = \"given\", duration = 0.5, tolerance = 1e-9 }}\n{FLOOR}\
                     [[body]]\nname = \"b\"\nmass = {mass:?}\ninertia = [0.1, 0.1, 0.1]\nshape = {shape}\n\
                     hinge = {{ type = \"free\", position = [0, 0, 0.05, 1, 0, 0, 0], velocity = [{speed:?}, 0, 0, 0, 0, 0] }}\n\
                     [[contact]]\nbetween = [\"floor\", \"b\"]\nfriction = {{ stick = {stick:?}, slide = {slide:?} }}\n",
                    -G * sine,
                    -G * cosine
                ),
            );
            let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
            let x = told["final"]["positions"]["b"][0].as_f64().expect("a number");
            let expected = 0.5 * speed * speed / (G * (sine + slide * cosine));
            assert!((x - expected).abs() < 1e-8, "{shape} {slope} {stick} {slide}: {x}, not {expected}");
        }
    }
}

/// Boxes that lie across each other stay where they are in captured steps, which a foot that glides along the floor far away on a slider with dry
/// friction asks for: that alone takes energy.
#[test]
fn stacks_of_crossed_boxes_stand_in_captured_steps() {
    let (bench, mut random) = (Bench::new(), Random::new(64));
    for count in [2, 2, 3, 3, 4, 5] {
        let (friction, mut height, mut boxes, mut middles) = (random.between(0.3, 0.6), 0.0, String::new(), Vec::new());
        for index in 0..count {
            let edges = [random.between(0.3, 0.6), random.between(0.3, 0.6), random.between(0.05, 0.15)];
            middles.push((height + 0.5 * edges[2], edges[2]));
            boxes += &format!(
                "[[body]]\nname = \"b{index}\"\ndensity = 500\nshape = {{ box = {edges:?} }}\n\
                 hinge = {{ type = \"free\", position = [0, 0, {:?}, 1, 0, 0, 0] }}\n",
                height + 0.5 * edges[2]
            );
            height += edges[2];
        }
        let scene = format!(
            "simulate = {{ start = \"given\", duration = 1.0, tolerance = 1e-6 }}\n{FLOOR}{boxes}\
             [[body]]\nname = \"slider\"\nmass = 0.5\ninertia = [0.1, 0.1, 0.1]\n\
             hinge = {{ type = \"prismatic\", axis = [1, 0, 0], at = [0, 20, 1], velocity = 5.0, friction = 1.0 }}\n\
             [[body]]\nname = \"foot\"\nmass = 0.5\ninertia = [0.1, 0.1, 0.1]\nshape = {{ sphere = 0.05 }}\n\
             hinge = {{ type = \"prismatic\", parent = \"slider\", axis = [0, 0, 1], position = -0.95 }}\n\
             [[contact]]\nbetween = [\"*\", \"*\"]\nfriction = {friction:?}\n\
             [[contact]]\nbetween = [\"floor\", \"foot\"]\nfriction = 0.0\n"
        );
        bench.write("scene.toml", &scene);
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        assert!(told["capture_steps"].as_u64().expect("a number") > 10, "{told}");
        for (index, (middle, edge)) in middles.iter().enumerate() {
            let at = told["final"]["positions"][format!("b{index}")].as_array().expect("a place");
            let off = [0, 1].map(|k| at[k].as_f64().expect("a number").abs());
            // Up to a ten-thousandth of a size what has sunk is left as it is.
            let sunk = (at[2].as_f64().expect("a number") - middle).abs();
            assert!(sunk < 2e-4 * edge && off[0].max(off[1]) < 2e-4 * edge, "{index} of {count}: {at:?}\n{scene}");
        }
        // From 5 to 4 m/s against 1 N.
        let lost = told["energy_dissipated"].as_f64().expect("a number");
        assert!((lost - 4.5).abs() < 1e-3, "{lost}\n{scene}");
    }
}
