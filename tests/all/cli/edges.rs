//! Scenes at the edges: ends that cancel to zero, what nothing but contact holds, beams whose tips are on their cones.

use super::Bench;
use std::f64::consts::PI;

/// Two loops hold a body to the ground where the world has its origin, so that their ends are apart by what rounding leaves of zero.
#[test]
fn what_is_held_at_the_origin_is_held_after_another_loop_opens() {
    let bench = Bench::new();
    bench.write(
        "scene.toml",
        "simulate = { start = \"given\", duration = 1.0 }\n\
         [[body]]\nname = \"held\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\ncenter = [0.1, 0.05, 0.02]\nhinge = { type = \"free\" }\n\
         [[body]]\nname = \"swings\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\ncenter = [0.1, 0.05, 0.02]\n\
         hinge = { type = \"free\", position = [0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0] }\n\
         [[loop]]\nname = \"turns\"\ntype = \"revolute\"\naxis = [0, 1, 0]\nbetween = [\"ground\", \"held\"]\n\
         [[loop]]\nname = \"welds\"\ntype = \"fixed\"\nbetween = [\"ground\", \"held\"]\n\
         [[loop]]\nname = \"opens\"\ntype = \"revolute\"\naxis = [0, 1, 0]\nbetween = [{ body = \"held\", at = [0.5, 0, 0] }, \"swings\"]\n\
         [[stage]]\nname = \"let go\"\nwhen = { time = 0.3 }\nopen = [\"opens\"]\n",
    );
    let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
    let held: Vec<f64> = told["final"]["positions"]["held"]
        .as_array()
        .expect("seven numbers")
        .iter()
        .map(|x| x.as_f64().expect("a number"))
        .collect();
    // Of a metre that the loops reach.
    assert!(held[..3].iter().all(|x| x.abs() < 1e-12) && (held[3] - 1.0).abs() < 1e-12, "{held:?}");
    // 1 kg falls freely for 0.7 s: of some 25 J that it gains and loses, at a tolerance of 1e-6.
    assert!(told["energy_drift"].as_f64().expect("a number") < 1e-6, "{told}");
}

/// A pin on its end is an unstable rest that no spring, only contact holds: what leaves it has a name.
#[test]
fn what_leaves_its_place_on_a_floor_is_named() {
    let bench = Bench::new();
    bench.write(
        "scene.toml",
        "[[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n\
         [[body]]\nname = \"pin\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.01]\nshape = { capsule = [0.05, 0.5] }\n\
         hinge = { type = \"free\", position = [0, 0, 0.3, 1, 0, 0, 0] }\n\
         [[contact]]\nbetween = [\"floor\", \"pin\"]\nfriction = 0.5\n\
         [statics]\nwant = \"any\"\n",
    );
    let told = bench.call(&["rest", "scene.toml"]).code(1);
    assert!(told.out.contains("`pin` leaves"), "{told:?}");
}

/// The ball at the tip of a beam rests on a floor, as hard as the beam and its own friction press it there.
#[test]
fn the_tip_of_a_beam_presses_on_the_floor_that_props_it() {
    let bench = Bench::new();
    bench.write(
        "scene.toml",
        "[[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n\
         [[body]]\nname = \"tip\"\nmass = 1.0\ninertia = [0.001, 0.001, 0.001]\nshape = { sphere = 0.05 }\n\
         hinge = { type = \"fixed\", parent = \"beam\" }\n\
         [[contact]]\nbetween = [\"floor\", \"tip\"]\nfriction = 0.3\n\
         [[beam]]\nname = \"beam\"\nlength = 1.0\nelements = 6\nhinge = { type = \"fixed\", parent = \"ground\", at = [0, 0, 0.05] }\n\
         section = { rectangle = [0.05, 0.01] }\nmaterial = { young = 2e10, poisson = 0.3, density = 4000.0 }\n\
         free = [\"bend\", \"twist\", \"stretch\"]\n",
    );
    let told = bench.call(&["statics", "scene.toml", "--json"]);
    let forces = told.json()["standing"]["forces"].clone();
    // The tip's weight, three eighths of the beam's (2 kg), and what friction at the bottom of the ball bends it up by: R = W + ⅜ w L + ³⁄₂ μ R r / L.
    let lifts = forces[0]["force"][2].as_f64().expect("a number").abs();
    let expected = (1.0 + 0.375 * 2.0) * 9.80665 / (1.0 - 1.5 * 0.3 * 0.05);
    // Friction shortens and loads the beam along itself, which a beam of small deflections does not see.
    assert!((lifts - expected).abs() < 1e-3 * expected, "{lifts} {expected}");
}

/// A lock at the very start stops what moves: the energy of that is lost, and told. What waits for an event that never happens is
/// named.
#[test]
fn stages_at_the_start_are_booked_and_stages_that_never_come_are_named() {
    let bench = Bench::new();
    let slide = |name: &str, mass: f64, speed: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = {mass:?}\ninertia = [0.1, 0.1, 0.1]\n\
             hinge = {{ type = \"prismatic\", axis = [1, 0, 0], velocity = {speed:?} }}\n"
        )
    };
    let settings = "gravity = [0, 0, 0]\nsimulate = { start = \"given\", duration = 1.0 }\n".to_owned();
    let scene = settings
        + &slide("stopped", 2.0, 3.0)
        + &slide("runs", 1.0, 4.0)
        + "[[event]]\nname = \"far\"\nhinge = \"runs\"\nvalue = 100.0\n\
           [[stage]]\nname = \"brake\"\nwhen = { time = 0.0 }\nlock = [\"stopped\"]\n\
           [[stage]]\nname = \"end\"\nwhen = { event = \"far\" }\nlock = [\"runs\"]\n";
    bench.write("scene.toml", &scene);
    let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
    let number = |key: &str| told[key].as_f64().expect("a number");
    // ½ · 2 · 3² and ½ · 1 · 4² J.
    assert!((number("energy_start") - 17.0).abs() < 1e-12 && (number("energy_end") - 8.0).abs() < 1e-12, "{told}");
    assert!((number("energy_dissipated") - 9.0).abs() < 1e-12 && number("energy_drift") < 1e-12, "{told}");
    assert_eq!(told["stages_pending"], serde_json::json!(["end"]));
    let said = bench.call(&["run", "scene.toml", "--out", "b.mcap"]).code(0).out;
    assert!(said.contains("stage `end` waits for event `far` still"), "{said}");
}

/// Two half spaces that move against each other overlap wherever they are: `check` says so before anything runs.
#[test]
fn what_can_never_touch_is_said_by_check() {
    let bench = Bench::new();
    let scene = |shape: &str| {
        format!(
            "[[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\" }}\n\
             [[body]]\nname = \"lid\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\nshape = {{ {shape} }}\n\
             hinge = {{ type = \"free\", position = [0, 0, 1, 1, 0, 0, 0] }}\n\
             [[contact]]\nbetween = [\"floor\", \"lid\"]\nfriction = 0.5\n"
        )
    };
    bench.write("planes.toml", scene("plane = [0, 0, -1]"));
    let told = bench.call(&["check", "planes.toml"]).code(2);
    assert!(told.err.contains("`lid` is a half space as well") && told.err.contains("planes.toml"), "{told:?}");
    bench.write("box.toml", scene("box = [1, 1, 1]"));
    bench.call(&["check", "box.toml"]).code(0);
}

/// A small turn has a quaternion near (1, 0, 0, 0) on both sides of none, whatever the axis of its hinge.
#[test]
fn small_turns_have_quaternions_near_one() {
    let bench = Bench::new();
    for axis in ["[0, 1, 0]", "[0, -1, 0]", "[1, 0, 0]", "[0, 0, 1]", "[1, 2, -3]"] {
        for angle in [-0.2_f64, 0.0, 0.2] {
            bench.write(
                "scene.toml",
                format!(
                    "[[body]]\nname = \"rod\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
                     hinge = {{ type = \"revolute\", axis = {axis}, position = {angle:?} }}\n\
                     [[output]]\nname = \"turn\"\ntype = \"orientation\"\nof = \"rod\"\n"
                ),
            );
            let told = bench.call(&["inspect", "scene.toml", "--json"]).code(0).json();
            let turn: Vec<f64> = told["outputs"]["turn"]
                .as_array()
                .expect("four numbers")
                .iter()
                .map(|x| x.as_f64().expect("a number"))
                .collect();
            let axis: Vec<f64> = serde_json::from_str::<Vec<f64>>(axis).expect("an axis");
            let along: f64 = turn[1..].iter().zip(&axis).map(|(x, a)| x * a).sum();
            let size = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
            assert!((turn[0] - (0.5 * angle).cos()).abs() < 1e-15, "{axis:?} {angle} {turn:?}");
            assert!((along / size - (0.5 * angle).sin()).abs() < 1e-15, "{axis:?} {angle} {turn:?}");
        }
    }
}

/// An angle about an axis jumps by a turn half a turn from zero: that is no crossing of zero, and values near half a turn are crossed once.
#[test]
fn an_angle_crosses_its_value_and_not_where_it_jumps() {
    let bench = Bench::new();
    for (value, turned) in [(0.0, 2.0 * PI - 0.5), (3.1, 3.1 - 0.5), (-3.1, 2.0 * PI - 3.1 - 0.5), (1.0, 0.5)] {
        bench.write(
            "scene.toml",
            format!(
                "gravity = [0, 0, 0]\nsimulate = {{ start = \"given\", duration = 1.0 }}\n\
                 [[body]]\nname = \"rotor\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
                 hinge = {{ type = \"revolute\", axis = [0, 0, 1], position = 0.5, velocity = 10.0 }}\n\
                 [[output]]\nname = \"heading\"\ntype = \"angle\"\nabout = [0, 0, 1]\n\
                 of = {{ body = \"rotor\", axis = [1, 0, 0] }}\nagainst = {{ body = \"ground\", axis = [1, 0, 0] }}\n\
                 [[event]]\nname = \"there\"\noutput = \"heading\"\nvalue = {value:?}\naction = \"stop\"\n"
            ),
        );
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        assert_eq!(told["stopped_by"], "there");
        let time = told["end_time"].as_f64().expect("a time");
        assert!((time - turned / 10.0).abs() < 1e-9, "{value}: {time} for {}", turned / 10.0);
    }
}

/// `inspect` says what it leaves out of its accelerations.
#[test]
fn inspect_says_that_it_knows_no_friction_and_no_contact() {
    let bench = Bench::new();
    let slide = |friction: &str| {
        format!(
            "[[body]]\nname = \"slide\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
             hinge = {{ type = \"prismatic\", axis = [1, 0, 0], velocity = 1.0{friction} }}\n"
        )
    };
    bench.write("rubs.toml", slide(", friction = 5.0"));
    let told = bench.call(&["inspect", "rubs.toml", "--json"]).code(0);
    assert!(told.err.contains("without dry friction of hinges"), "{told:?}");
    assert_eq!(told.json()["left_out"], serde_json::json!(["dry friction of hinges"]));
    bench.write("free.toml", slide(""));
    let told = bench.call(&["inspect", "free.toml", "--json"]).code(0);
    assert_eq!((told.err.as_str(), &told.json()["left_out"]), ("", &serde_json::json!([])));
}

/// A box that carries a beam stands on a floor as long as it is pushed with less than `μ (m + m_b) g`, however the beam bends.
#[test]
fn a_box_with_a_beam_stands_until_it_slides() {
    let bench = Bench::new();
    for (young, elements) in [("2e8", 8), ("2e9", 8), ("2e10", 4), ("2e11", 8), ("2e12", 8)] {
        bench.write(
            "scene.toml",
            format!(
                "[statics]\nmargin = [\"push.force[0]\"]\n[[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1] }}\n\
                 hinge = {{ type = \"fixed\" }}\n[[body]]\nname = \"box\"\nmass = 10.0\ninertia = [0.5, 0.5, 0.5]\n\
                 shape = {{ box = [1, 1, 0.4] }}\nhinge = {{ type = \"free\", position = [0, 0, 0.2, 1, 0, 0, 0] }}\n\
                 [[beam]]\nname = \"bm\"\nhinge = {{ type = \"fixed\", parent = \"box\" }}\nlength = 1.0\nelements = {elements}\n\
                 section = {{ tube = [0.02, 0.018] }}\nmaterial = {{ young = {young}, density = 7800 }}\n\
                 [[force]]\nname = \"push\"\ntype = \"load\"\non = \"box\"\nforce = [5.0, 0, 0]\n\
                 [[contact]]\nbetween = [\"floor\", \"box\"]\nfriction = 0.5\n"
            ),
        );
        let told = bench.call(&["statics", "scene.toml", "--json"]).code(0).json();
        assert_eq!(told["standing"]["verdict"], "stands", "{young}: {told}");
        let weight = 9.80665 * (10.0 + 7800.0 * PI * (0.02_f64.powi(2) - 0.018_f64.powi(2)));
        let high = told["standing"]["margins"]["push.force[0]"]["high"].as_f64().expect("a number");
        // Conic programs are asked for eight digits of the loads.
        assert!((high / (0.5 * weight) - 1.0).abs() < 1e-6, "{young}: {high} for {}", 0.5 * weight);
    }
}

/// A plate on two welds with a four-bar that hangs on it: how the welds share is a convention, but one of the pose, wherever its search began.
#[test]
fn redundant_loops_share_by_the_pose_alone() {
    let bench = Bench::new();
    bench.write(
        "scene.toml",
        r#"
[[body]]
name = "plate"
mass = 10.0
inertia = [1.0, 1.0, 1.0]
center = [0.3, 0.0, 0.0]
hinge = { type = "free" }
[[loop]]
name = "left"
type = "fixed"
between = [{ body = "ground", at = [0.0, 0.0, 0.0] }, "plate"]
[[loop]]
name = "right"
type = "fixed"
between = [{ body = "ground", at = [1.0, 0.0, 0.0] }, { body = "plate", at = [1.0, 0.0, 0.0] }]
[[body]]
name = "crank"
mass = 1.0
center = [0.0, 0.0, -0.5]
inertia = [0.1, 0.1, 0.01]
markers = { tip = [0.0, 0.0, -3.0] }
hinge = { type = "revolute", parent = "plate", at = [2.0, 0.5, 0.0], axis = [0.0, 1.0, 0.0], position = -1.2 }
[[loop]]
name = "bar"
type = "rod"
between = ["crank.tip", { body = "rocker", at = [0.0, 0.0, -3.0] }]
length = 3.0
[[body]]
name = "rocker"
mass = 1.0
center = [0.0, 0.0, -0.5]
inertia = [0.1, 0.1, 0.01]
hinge = { type = "revolute", at = [5.0, 0.5, 0.0], axis = [0.0, 1.0, 0.0], position = -1.2 }
"#,
    );
    let far = bench.call(&["statics", "scene.toml", "--json", "--save", "rest.toml"]).code(0).json();
    let near = bench.call(&["statics", "scene.toml", "--json", "--start", "rest.toml"]).code(0);
    assert!(!near.err.contains("warning"), "{}", near.err);
    let near = near.json();
    for weld in ["left", "right"] {
        for part in ["force", "moment"] {
            for k in 0..3 {
                let [one, other] =
                    [&far, &near].map(|told| told["loop_reactions"][weld][part][k].as_f64().expect("a number"));
                // Of 108 N, at poses that differ by round-off.
                assert!((one - other).abs() < 1e-9, "{weld} {part}[{k}]: {one} and {other}");
            }
        }
    }
}
