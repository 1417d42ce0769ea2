//! Contacts where surfaces end: joints of level tables are no steps, and what slides over an edge tips when its middle is beyond what
//! friction allows. Wheels at the limit of their grip, contacts under a controller, what settles with a beam, and the ledger of captured steps.

use super::Bench;
use crate::common::Random;
use serde_json::Value;

const G: f64 = 9.80665;

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// The columns of a recording, by the beginning of their headings.
fn columns(bench: &Bench, names: &[&str]) -> Vec<Vec<f64>> {
    bench.call(&["export", "a.mcap", "--csv", "a.csv"]).code(0);
    let table = std::fs::read_to_string(bench.path().join("a.csv")).expect("a table");
    let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let heads = rows.next().expect("headings");
    let place = |name: &&str| heads.iter().position(|head| head.starts_with(*name)).unwrap_or_else(|| panic!("{name}"));
    let places: Vec<usize> = names.iter().map(place).collect();
    let mut columns = vec![Vec::new(); names.len()];
    for row in rows {
        places.iter().zip(&mut columns).for_each(|(at, column)| column.push(row[*at].parse().expect("a number")));
    }
    columns
}

/// A box or an upright cylinder slides over level tables side by side, as far as over one: `x = v²/2μg`. Heights of tables are not round
/// numbers, so that their tops are level but for rounding.
#[test]
fn joints_of_level_tables_are_no_steps() {
    let (bench, mut random) = (Bench::new(), Random::new(81));
    for case in 0..24 {
        let (size, height) = (random.between(0.1, 0.4), random.between(0.05, 0.2));
        let (tile, top) = (random.between(0.3, 0.6), random.between(-1.0, 1.0));
        let (friction, speed) = (random.between(0.1, 0.3), random.between(0.8, 2.0));
        let yaw = if case % 2 == 0 { 0.0 } else { random.between(0.0, 1.5) };
        let gap = if case % 3 == 0 { random.between(0.0, 0.05) } else { 0.0 };
        let shape = match case % 4 {
            3 => format!("cylinder = [{:?}, {height:?}]", 0.5 * size),
            _ => format!("box = [{size:?}, {size:?}, {height:?}]"),
        };
        let tables: String = (0..8)
            .map(|k| {
                format!(
                    "[[body]]\nname = \"t{k}\"\nshape = {{ box = [{tile:?}, 2.0, 0.1] }}\n\
                     hinge = {{ type = \"fixed\", at = [{:?}, 0, {:?}] }}\n",
                    (tile + gap) * f64::from(k),
                    top - 0.05
                )
            })
            .collect();
        bench.write(
            "scene.toml",
            format!(
                "simulate = {{ start = \"given\", duration = 1.5, tolerance = 1e-9 }}\nstatics = {{ gap = 1e-6 }}\n{tables}\
                 [[body]]\nname = \"load\"\ndensity = 500\nshape = {{ {shape} }}\n\
                 hinge = {{ type = \"free\", position = [0, 0, {:?}, {:?}, 0, 0, {:?}], velocity = [{speed:?}, 0, 0, 0, 0, 0] }}\n\
                 [[contact]]\nbetween = [\"t*\", \"load\"]\nfriction = {friction:?}\n",
                top + 0.5 * height,
                (0.5 * yaw).cos(),
                (0.5 * yaw).sin(),
            ),
        );
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        assert_eq!(told["impacts"], 0, "case {case}");
        let end = &told["final"]["positions"]["load"];
        let time = speed / (friction * G);
        let way = if time < 1.5 { 0.5 * speed * time } else { speed * 1.5 - 0.5 * friction * G * 2.25 };
        assert!((number(&end[0]) - way).abs() < 1e-7, "case {case}: {end} not {way}");
        assert!(number(&end[1]).abs() < 1e-7, "case {case}: {end}");
    }
}

/// A box that stands in the way of another on the same floor is hit all the same: their sides meet at their rims.
#[test]
fn what_stands_in_the_way_is_hit() {
    let (bench, mut random) = (Bench::new(), Random::new(82));
    for _ in 0..6 {
        let (first, second) = (random.between(0.5, 3.0), random.between(0.5, 3.0));
        let (speed, restitution) = (random.between(0.5, 2.0), random.between(0.0, 1.0));
        bench.write(
            "scene.toml",
            format!(
                "simulate = {{ start = \"given\", duration = 1.0, tolerance = 1e-9 }}\n\
                 [[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\" }}\n\
                 [[body]]\nname = \"one\"\nmass = {first:?}\ninertia = [0.01, 0.01, 0.01]\nshape = {{ box = [0.2, 0.2, 0.2] }}\n\
                 hinge = {{ type = \"free\", position = [0, 0, 0.1, 1, 0, 0, 0], velocity = [{speed:?}, 0, 0, 0, 0, 0] }}\n\
                 [[body]]\nname = \"two\"\nmass = {second:?}\ninertia = [0.01, 0.01, 0.01]\nshape = {{ box = [0.2, 0.2, 0.2] }}\n\
                 hinge = {{ type = \"free\", position = [0.4, 0, 0.1, 1, 0, 0, 0] }}\n\
                 [[contact]]\nbetween = [\"floor\", \"*\"]\nfriction = 0.0\n\
                 [[contact]]\nbetween = [\"one\", \"two\"]\nfriction = 0.0\nrestitution = {restitution:?}\n"
            ),
        );
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        let after =
            |own: f64, other: f64, sign: f64| (first * speed + sign * other * restitution * speed) / (own + other);
        let found = ["one", "two"].map(|name| number(&told["final"]["velocities"][name][0]));
        let right = [after(first, second, -1.0), after(second, first, 1.0)];
        assert!((0..2).all(|i| (found[i] - right[i]).abs() < 1e-7), "{found:?} not {right:?}");
    }
}

/// An upright cylinder slides off a table: it stands flat until its middle is `μ h/2` before the edge, then tips about the edge as a box
/// would do. By the equations of a body that slides on an edge, integrated here.
#[test]
fn a_cylinder_tips_over_an_edge_as_a_box_does() {
    let bench = Bench::new();
    let (radius, height, mass, inertia) = (0.06, 0.1, 0.5, 0.001);
    for (speed, friction) in [(1.5, 0.2), (1.4, 0.1)] {
        let mut angles = Vec::new();
        for shape in
            [format!("cylinder = [{radius:?}, {height:?}]"), format!("box = [{:?}, 0.1, {height:?}]", 2.0 * radius)]
        {
            bench.write(
                "scene.toml",
                format!(
                    "simulate = {{ start = \"given\", duration = 0.3, tolerance = 1e-9 }}\nrecord = {{ rate = 100.0 }}\n\
                     [[body]]\nname = \"table\"\nshape = {{ box = [2.0, 1, 0.1], at = [-1.0, 0, -0.05] }}\nhinge = {{ type = \"fixed\" }}\n\
                     [[body]]\nname = \"load\"\nmass = {mass:?}\ninertia = [0.002, {inertia:?}, 0.001]\nshape = {{ {shape} }}\n\
                     hinge = {{ type = \"free\", position = [-0.3, 0, 0.05, 1, 0, 0, 0], velocity = [{speed:?}, 0, 0, 0, 0, 0] }}\n\
                     [[contact]]\nbetween = [\"table\", \"load\"]\nfriction = {friction:?}\n"
                ),
            );
            let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
            assert!(number(&told["energy_drift"]) < 1e-8, "{shape}: {}", told["energy_drift"]);
            assert_eq!(told["capture_steps"], 0, "{shape}");
            angles.push(columns(&bench, &["load.qy"]).remove(0));
        }
        let [round, square] = &angles[..] else { unreachable!() };
        assert!(square.last().is_some_and(|angle| *angle > 0.01), "it tips");
        let off = round.iter().zip(square).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Both meet the edge with other points: their events are found at times that differ.
        assert!(off < 1e-6, "{speed}: {off}");
    }
}

/// Four wheels, two of them driven with a torque T: as long as what each bears is within its cone a car rolls with
/// `a = (T₁ + T₂)/r / (m + 4 I/r²)`, from the first sample on; beyond, the driven ones slip.
#[test]
fn wheels_at_the_limit_of_their_grip_act_alike() {
    let bench = Bench::new();
    let (radius, inertia, mass, axle) = (0.1, 0.002, 12.0, 0.3);
    let grip = 0.3;
    for torque in [0.3, 0.9, 0.95, 0.96, 0.98, 1.0, 1.5, 3.0] {
        let wheel = |name: &str, x: f64, y: f64| {
            format!(
                "[[body]]\nname = \"{name}\"\nmass = 0.5\ninertia = [{inertia:?}, {inertia:?}, {inertia:?}]\nshape = {{ sphere = {radius:?} }}\n\
                 hinge = {{ type = \"revolute\", axis = [0, 1, 0], parent = \"car\", at = [{x:?}, {y:?}, 0] }}\n"
            )
        };
        let motor = |name: &str| {
            format!("[[motor]]\nname = \"m {name}\"\nhinge = \"{name}\"\ntype = \"constant\"\nforce = {torque:?}\n")
        };
        bench.write(
            "scene.toml",
            format!(
                "simulate = {{ start = \"given\", duration = 0.2, tolerance = 1e-8 }}\nrecord = {{ rate = 50.0 }}\n\
                 [[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\" }}\n\
                 [[body]]\nname = \"car\"\nmass = 10.0\ninertia = [0.12, 0.3, 0.4]\n\
                 hinge = {{ type = \"free\", position = [0, 0, {radius:?}, 1, 0, 0, 0] }}\n{}{}{}{}{}{}\
                 [[contact]]\nbetween = [\"floor\", \"w*\"]\nfriction = {grip:?}\n\
                 [[output]]\nname = \"a\"\ntype = \"acceleration\"\nof = \"car\"\naxis = [1, 0, 0]\n\
                 [[output]]\nname = \"b\"\ntype = \"acceleration\"\nof = \"car\"\naxis = [0, 1, 0]\n",
                wheel("w0", axle, 0.2),
                wheel("w1", axle, -0.2),
                wheel("w2", -axle, 0.2),
                wheel("w3", -axle, -0.2),
                motor("w2"),
                motor("w3"),
            ),
        );
        bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0);
        // All roll, with T/r − I a/r² at each rear wheel; or these slip, and with moments about the middle of all
        // m a = 2 μ N − 2 I a/r²,   4 l N = m g l + m a r + 2 I a/r + 2 (T − μ N r).
        let rolls = 2.0 * torque / radius / (mass + 4.0 * inertia / (radius * radius));
        let bears = |a: f64, spin: f64| {
            0.25 * mass * G + (mass * a * radius + 2.0 * inertia * a / radius + 2.0 * inertia * spin) / (4.0 * axle)
        };
        let needs = torque / radius - inertia * rolls / (radius * radius);
        let right = if needs <= grip * bears(rolls, rolls / radius) {
            rolls
        } else {
            let by_a = (mass * radius + 2.0 * inertia / radius) / (4.0 * axle);
            let load = (0.25 * mass * G + 2.0 * torque / (4.0 * axle), 1.0 + 2.0 * grip * radius / (4.0 * axle));
            let held = mass + 2.0 * inertia / (radius * radius);
            2.0 * grip * load.0 / (load.1 * held - 2.0 * grip * by_a)
        };
        let [a, b] = <[Vec<f64>; 2]>::try_from(columns(&bench, &["a ", "b "])).expect("two columns");
        let off = a.iter().map(|a| (a - right).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6 * right, "{torque}: {a:?}, not {right}");
        assert!(b.iter().all(|b| b.abs() < 1e-8), "{torque}: {b:?}");
    }
}

/// What a controller sets at the very start lifts what touches at once, and pulls a cart from under what it carries.
#[test]
fn contacts_know_what_controllers_set_at_the_start() {
    let (bench, mut random) = (Bench::new(), Random::new(83));
    for case in 0..8 {
        let (cart, load, push) = (random.between(0.5, 2.0), random.between(0.5, 2.0), random.between(5.0, 40.0));
        let (friction, lifts) = (random.between(0.1, 0.5), case % 2 == 0);
        let axis = if lifts { "[0, 0, 1]" } else { "[1, 0, 0]" };
        bench.write(
            "scene.toml",
            format!(
                "simulate = {{ start = \"given\", duration = 0.4, tolerance = 1e-9 }}\nrecord = {{ rate = 20.0 }}\n\
                 [[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1], at = [0, 0, -0.2] }}\nhinge = {{ type = \"fixed\" }}\n\
                 [[body]]\nname = \"cart\"\nmass = {cart:?}\ninertia = [0.1, 0.1, 0.1]\nshape = {{ box = [9, 1, 0.2], at = [0, 0, -0.1] }}\n\
                 hinge = {{ type = \"prismatic\", axis = {axis} }}\n\
                 [[body]]\nname = \"load\"\nmass = {load:?}\ninertia = [0.1, 0.1, 0.1]\nshape = {{ box = [0.4, 0.4, 0.1] }}\n\
                 hinge = {{ type = \"free\", position = [0, 0, 0.05, 1, 0, 0, 0] }}\n\
                 [[motor]]\nname = \"pull\"\ntype = \"input\"\nhinge = \"cart\"\n\
                 [[output]]\nname = \"x\"\ntype = \"coordinate\"\nof = \"cart\"\n\
                 [[controller]]\nname = \"c\"\ntype = \"expression\"\nperiod = 0.5\nsenses = \"x\"\ndrives = \"pull\"\nexpression = \"{push:?}\"\n\
                 [[contact]]\nbetween = [\"cart\", \"load\"]\nfriction = {friction:?}\n\
                 {}",
                if lifts { "[[contact]]\nbetween = [\"floor\", \"cart\"]\nfriction = 0.0\n" } else { "" }
            ),
        );
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        let together = push / (cart + load);
        let a = match (lifts, together <= friction * G) {
            (true, _) => (together - G).max(0.0),
            (false, true) => together,
            (false, false) => (push - friction * load * G) / cart,
        };
        let end = number(&told["final"]["positions"]["cart"][0]);
        assert!((end - 0.08 * a).abs() < 1e-8 * (1.0 + a), "{lifts} {push} {cart} {load} {friction}: {end}");
    }
}

/// The tip of a cantilever that a load presses onto a floor slides inwards while it settles: it ends where friction just holds it, that stands, and
/// a run from there stays.
#[test]
fn what_has_slid_to_where_it_stays_stands() {
    let (bench, mut random) = (Bench::new(), Random::new(84));
    for _ in 0..4 {
        let (load, friction) = (random.between(0.2, 0.6), random.between(0.1, 0.5));
        // Without the floor the tip would go down by F L³/3 E I, with E I = 8.33 N m².
        let gap = load / 25.0 * random.between(0.2, 0.6);
        bench.write(
            "scene.toml",
            format!(
                "gravity = [0, 0, 0]\nsimulate = {{ start = \"equilibrium\", duration = 0.1 }}\nstatics = {{ contact = \"settle\" }}\n\
                 [[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1], at = [0, 0, {:?}] }}\nhinge = {{ type = \"fixed\" }}\n\
                 [[body]]\nname = \"tip\"\nmass = 0.5\ninertia = [0.001, 0.001, 0.001]\nshape = {{ sphere = 0.03 }}\n\
                 hinge = {{ type = \"fixed\", parent = \"arm\" }}\n\
                 [[beam]]\nname = \"arm\"\nhinge = {{ type = \"fixed\" }}\nlength = 1.0\nelements = 2\nsection = {{ rectangle = [0.05, 0.01] }}\n\
                 material = {{ young = 2e9, poisson = 0.3, density = 1000.0 }}\n\
                 [[force]]\nname = \"load\"\ntype = \"load\"\non = \"tip\"\nforce = [0, 0, {:?}]\n\
                 [[contact]]\nbetween = [\"floor\", \"tip\"]\nfriction = {friction:?}\n",
                -0.03 - gap,
                -load
            ),
        );
        let told = bench.call(&["statics", "scene.toml", "--json"]).code(0).json();
        assert_eq!(told["standing"]["verdict"], "stands");
        // What the beam does not bear; its moments lengthen nothing, and the tip goes inwards by 3 w²/5 L.
        let bears = number(&told["standing"]["forces"][0]["force"][2]);
        assert!((bears - load + 25.0 * gap).abs() < 0.02 * load, "{bears} of {load}, {gap}");
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        assert_eq!(told["energy_dissipated"], 0.0);
    }
}

/// A table with dry friction in its hinge is driven with a load on it, by captured steps: at every sample its friction has taken out `μ` times its
/// path, and the drive has put in that and what the kinetic energy has more.
#[test]
fn ledgers_of_captured_steps_are_those_of_their_time() {
    let (bench, mut random) = (Bench::new(), Random::new(85));
    for _ in 0..4 {
        let (table, load, rubs) = (random.between(2.0, 6.0), random.between(0.5, 2.0), random.between(0.5, 2.0));
        let (amplitude, frequency) = (random.between(0.01, 0.03), random.between(1.0, 2.5));
        let pace = std::f64::consts::TAU * frequency;
        let speed = amplitude * pace;
        bench.write(
            "scene.toml",
            format!(
                "simulate = {{ start = \"given\", duration = 0.4, tolerance = 1e-6 }}\nrecord = {{ rate = 200.0 }}\n\
                 [[body]]\nname = \"table\"\nmass = {table:?}\ninertia = [1, 1, 1]\nshape = {{ box = [2, 2, 0.1], at = [0, 0, -0.05] }}\n\
                 hinge = {{ type = \"prismatic\", axis = [1, 0, 0], friction = {rubs:?}, velocity = {speed:?} }}\n\
                 [[body]]\nname = \"load\"\nmass = {load:?}\ninertia = [0.01, 0.01, 0.01]\nshape = {{ box = [0.3, 0.3, 0.1] }}\n\
                 hinge = {{ type = \"free\", position = [0, 0, 0.05, 1, 0, 0, 0], velocity = [{speed:?}, 0, 0, 0, 0, 0] }}\n\
                 [[contact]]\nbetween = [\"table\", \"load\"]\nfriction = 0.9\n\
                 [[drive]]\nhinge = \"table\"\ntype = \"sine\"\namplitude = {amplitude:?}\nfrequency = {frequency:?}\n"
            ),
        );
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        assert!(number(&told["capture_steps"]) > 0.0, "they are captured");
        let [time, work, dissipated] =
            <[Vec<f64>; 3]>::try_from(columns(&bench, &["time", "work", "dissipated"])).expect("three columns");
        let kinetic = |time: f64| 0.5 * (table + load) * (speed * (pace * time).cos()).powi(2);
        // |sin| goes up and down: half a turn is twice the amplitude.
        let path = |time: f64| {
            let quarters = pace * time / std::f64::consts::FRAC_PI_2;
            let (whole, rest) = ((quarters / 2.0 + 0.5).floor(), (pace * time).sin());
            amplitude * (2.0 * whole + if whole % 2.0 == 0.0 { rest } else { -rest })
        };
        // Captured steps are of order 1 where friction turns round.
        let most = 1e-3 * kinetic(0.0);
        for ((time, work), dissipated) in time.into_iter().zip(work).zip(dissipated) {
            let (taken, given) = (rubs * path(time), rubs * path(time) + kinetic(time) - kinetic(0.0));
            assert!((dissipated - taken).abs() < most, "{time} s: {dissipated} J taken out, not {taken}");
            assert!((work - given).abs() < most, "{time} s: {work} J put in, not {given}");
        }
    }
}

/// An upright cylinder that slides over a step down by less than its rim can be told from the lower table's goes on: nothing lies ahead of it.
#[test]
fn small_steps_down_stop_nothing() {
    let (bench, mut random) = (Bench::new(), Random::new(83));
    for step in [0.0, 1e-8, 3e-7, 1e-6, 5e-6, 2e-5, 1e-4] {
        let (radius, height, speed) = (random.between(0.1, 0.3), random.between(0.03, 0.1), random.between(1.0, 2.5));
        bench.write(
            "scene.toml",
            format!(
                "simulate = {{ start = \"given\", duration = 0.5 }}\n\
                 [[body]]\nname = \"high\"\nshape = {{ box = [20, 20, 1], at = [-9.4, 0, -0.5] }}\nhinge = {{ type = \"fixed\" }}\n\
                 [[body]]\nname = \"low\"\nshape = {{ box = [20, 20, 1], at = [10.6, 0, {:?}] }}\nhinge = {{ type = \"fixed\" }}\n\
                 [[body]]\nname = \"load\"\ndensity = 1000\nshape = {{ cylinder = [{radius:?}, {height:?}] }}\n\
                 hinge = {{ type = \"free\", position = [0, 0, {:?}, 1, 0, 0, 0], velocity = [{speed:?}, 0, 0, 0, 0, 0] }}\n\
                 [[contact]]\nbetween = [\"*\", \"load\"]\n",
                -0.5 - step,
                0.5 * height,
            ),
        );
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        let end = number(&told["final"]["velocities"]["load"][0]);
        // What falls by the step gains its energy, and bounces no more.
        assert!((end - speed).abs() < 1e-6 + 2.0 * G * step / speed, "{step:e}: {end} not {speed}");
    }
}

/// Feet without a radius slide over joints of level tables, as far as over one: `x = v t - μ g t²/2`.
#[test]
fn points_are_carried_on_over_joints() {
    let (bench, mut random) = (Bench::new(), Random::new(84));
    for case in 0..12 {
        let friction = if case % 3 == 0 { 0.0 } else { random.between(0.05, 0.4) };
        let (speed, heading) = (random.between(1.0, 3.0), random.between(-1.0, 1.0));
        let turn = random.between(0.0, 2.0);
        let foot = |k: u8| {
            let angle = turn + std::f64::consts::TAU / 3.0 * f64::from(k);
            format!("{{ sphere = 0.0, at = [{:?}, {:?}, -0.1] }}", 0.2 * angle.cos(), 0.2 * angle.sin())
        };
        let tables: String = (0..6)
            .map(|k| {
                let at = 0.31 * f64::from(k);
                format!("[[body]]\nname = \"t{k}\"\nshape = {{ box = [0.31, 20, 1], at = [{at:?}, 0, -0.5] }}\nhinge = {{ type = \"fixed\" }}\n")
            })
            .collect();
        bench.write(
            "scene.toml",
            format!(
                "simulate = {{ start = \"given\", duration = 0.4, tolerance = 1e-8 }}\n{tables}\
                 [[body]]\nname = \"stool\"\nmass = 10\ninertia = [0.3, 0.3, 0.3]\nshape = [{}, {}, {}]\n\
                 hinge = {{ type = \"free\", position = [0.1, 0, 0.1, 1, 0, 0, 0], velocity = [{:?}, {:?}, 0, 0, 0, 0] }}\n\
                 [[contact]]\nbetween = [\"t*\", \"stool\"]\nfriction = {friction:?}\n",
                foot(0),
                foot(1),
                foot(2),
                speed * heading.cos(),
                speed * heading.sin(),
            ),
        );
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        let time = if friction > 0.0 { (speed / (friction * G)).min(0.4) } else { 0.4 };
        let way = speed * time - 0.5 * friction * G * time * time;
        let end = &told["final"]["positions"]["stool"];
        let off =
            [number(&end[0]) - 0.1 - way * heading.cos(), number(&end[1]) - way * heading.sin(), number(&end[2]) - 0.1];
        assert!(off.iter().all(|x| x.abs() < 1e-9), "case {case}: off by {off:?}");
        assert_eq!((&told["impacts"], &told["capture_steps"]), (&0.into(), &0.into()), "case {case}");
    }
}

/// An upright cylinder that is turned about its axis slides without friction over a step down that is hardly more than rounding: the point at which
/// its rim comes down lies between those that are fixed to it. It keeps its speed, and ends lower by the step.
#[test]
fn turned_cylinders_pass_over_steps_of_a_nanometre() {
    let (bench, mut random) = (Bench::new(), Random::new(86));
    for case in 0..12 {
        let step = if case % 3 == 0 { 2e-9 } else { 1e-9 };
        let (radius, height, speed) = (random.between(0.2, 0.3), 0.04, random.between(1.8, 2.2));
        let yaw: f64 = random.between(0.1, 0.4);
        bench.write(
            "scene.toml",
            format!(
                "simulate = {{ start = \"given\", duration = 0.5, tolerance = 1e-8 }}\n\
                 [[body]]\nname = \"high\"\nshape = {{ box = [20, 20, 1], at = [-9.6, 0, -0.5] }}\nhinge = {{ type = \"fixed\" }}\n\
                 [[body]]\nname = \"low\"\nshape = {{ box = [20, 20, 1], at = [10.4, 0, {:?}] }}\nhinge = {{ type = \"fixed\" }}\n\
                 [[body]]\nname = \"load\"\ndensity = 1000\nshape = {{ cylinder = [{radius:?}, {height:?}] }}\n\
                 hinge = {{ type = \"free\", position = [0, 0, {:?}, {:?}, 0, 0, {:?}], velocity = [{speed:?}, 0, 0, 0, 0, 0] }}\n\
                 [[contact]]\nbetween = [\"*\", \"load\"]\n",
                -0.5 - step,
                0.5 * height,
                (0.5 * yaw).cos(),
                (0.5 * yaw).sin(),
            ),
        );
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        let (end, velocity) = (&told["final"]["positions"]["load"], &told["final"]["velocities"]["load"]);
        // What is captured on the way is so by steps of order 1.
        assert!((number(&velocity[0]) - speed).abs() < 1e-5, "case {case}: {velocity} not {speed}");
        // A rim of this size stands to some 1e-9 of it.
        let off = number(&end[2]) - 0.5 * height + step;
        assert!(off.abs() < 1e-9, "case {case}: {off:e} above the lower table");
    }
}

/// An upright cylinder slides without friction over a step down, tips over its rim behind the edge and comes down flat on the floor below: it
/// lands, instead of running around its rim. It keeps its speed along, ends lower by the step, and what its landings took is said.
#[test]
fn upright_cylinders_come_down_flat_behind_an_edge() {
    let (bench, mut random) = (Bench::new(), Random::new(87));
    for case in 0..16 {
        let step = 10_f64.powf(random.between(-5.0, -3.5));
        let (radius, height, speed) = (random.between(0.2, 0.3), 0.04, random.between(1.8, 2.2));
        let duration = random.between(0.45, 0.6);
        bench.write(
            "scene.toml",
            format!(
                "simulate = {{ start = \"given\", duration = {duration:?}, tolerance = 1e-8 }}\n\
                 [[body]]\nname = \"high\"\nshape = {{ box = [20, 20, 1], at = [-9.4, 0, -0.5] }}\nhinge = {{ type = \"fixed\" }}\n\
                 [[body]]\nname = \"low\"\nshape = {{ plane = [0, 0, 1], at = [0, 0, {:?}] }}\nhinge = {{ type = \"fixed\" }}\n\
                 [[body]]\nname = \"load\"\ndensity = 1000\nshape = {{ cylinder = [{radius:?}, {height:?}] }}\n\
                 hinge = {{ type = \"free\", position = [0, 0, {:?}, 1, 0, 0, 0], velocity = [{speed:?}, 0, 0, 0, 0, 0] }}\n\
                 [[contact]]\nbetween = [\"*\", \"load\"]\n",
                -step,
                0.5 * height,
            ),
        );
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        let (end, velocity) = (&told["final"]["positions"]["load"], &told["final"]["velocities"]["load"]);
        // The edge pushes it on, by no more than the height of the step gives: `v² − v₀² = 2 g step`.
        let gained = number(&velocity[0]) - speed;
        assert!(gained > -1e-9 && gained < G * step / speed, "case {case}: {velocity} not {speed}");
        let off = number(&end[2]) - 0.5 * height + step;
        assert!(off.abs() < 1e-8, "case {case}: {off:e} above the floor");
        // Some twenty rolls and landings within milliseconds take some hundreds.
        assert!(number(&told["steps"]) < 2000.0, "case {case}: {} steps", told["steps"]);
        let mass = 1000.0 * std::f64::consts::PI * radius * radius * height;
        // It lands with a gap of half of 10⁻⁹ of its size on one side.
        let size = mass * G * (1e-5 * step + 1e-9 * radius);
        let drift = number(&told["energy_drift"]);
        assert!(drift < size, "case {case}: {drift:e} of {size:e} J unaccounted for");
    }
}

/// A cylinder on its side slides without friction over a joint that crosses its axis at a small angle: the point where they cross runs along it, from
/// one end to the other. Its motion is uniform, and costs no more than a few steps.
#[test]
fn joints_nearly_along_a_cylinder_cost_nothing() {
    let (bench, mut random) = (Bench::new(), Random::new(87));
    for angle in [1e-2, 1e-3, 1e-4, 1e-4] {
        let (radius, length) = (random.between(0.05, 0.1), random.between(0.2, 0.5));
        let [along, across] = [random.between(-1.5, 1.5), random.between(1.0, 3.0)];
        bench.write(
            "scene.toml",
            format!(
                "simulate = {{ start = \"given\", duration = 0.3, tolerance = 1e-8 }}\n\
                 [[body]]\nname = \"one\"\nshape = {{ box = [20, 40, 1], at = [-9.9, 0, -0.5] }}\nhinge = {{ type = \"fixed\" }}\n\
                 [[body]]\nname = \"two\"\nshape = {{ box = [20, 40, 1], at = [10.1, 0, -0.5] }}\nhinge = {{ type = \"fixed\" }}\n\
                 [[body]]\nname = \"load\"\ndensity = 1000\nshape = {{ cylinder = [{radius:?}, {length:?}], rpy = [{:?}, 0, {angle:?}] }}\n\
                 hinge = {{ type = \"free\", position = [0, 0, {radius:?}, 1, 0, 0, 0], velocity = [{across:?}, {along:?}, 0, 0, 0, 0] }}\n\
                 [[contact]]\nbetween = [\"*\", \"load\"]\n",
                std::f64::consts::FRAC_PI_2,
            ),
        );
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        let end = &told["final"]["positions"]["load"];
        let off = [number(&end[0]) - 0.3 * across, number(&end[1]) - 0.3 * along, number(&end[2]) - radius];
        assert!(off.iter().all(|x| x.abs() < 1e-8), "{angle}: off by {off:?}");
        assert!(number(&told["acceleration_evaluations"]) < 2000.0, "{angle}: {}", told["acceleration_evaluations"]);
        assert_eq!((&told["impacts"], &told["capture_steps"]), (&0.into(), &0.into()), "{angle}");
        let kinds: Vec<&str> =
            told["events"].as_array().expect("events").iter().filter_map(|e| e["kind"].as_str()).collect();
        assert_eq!(kinds, ["goes on"], "{angle}");
    }
}

/// A cart on wheels that are cylinders, of which two are driven with a torque `T`, rolls over joints of level tables as over one, with
/// `a = 2 T/r / (m + n I/r²)`: nothing lifts, slips or is struck.
#[test]
fn wheels_roll_over_joints() {
    let (bench, mut random) = (Bench::new(), Random::new(88));
    for case in 0..6 {
        let wheels = if case % 3 == 0 { 4 } else { 6_u8 };
        let (radius, width, speed) = (random.between(0.08, 0.15), random.between(0.03, 0.05), random.between(0.8, 1.5));
        let (tile, torque, begin) = (random.between(0.31, 0.39), random.between(0.2, 0.4), random.between(0.15, 0.3));
        let tables: String = (0..6)
            .map(|k| {
                let at = tile * (f64::from(k) - begin);
                format!("[[body]]\nname = \"t{k}\"\nshape = {{ box = [{tile:?}, 20, 1], at = [{at:?}, 0, -0.5] }}\nhinge = {{ type = \"fixed\" }}\n")
            })
            .collect();
        let wheel = |k: u8| {
            let (x, y) = (0.25 * f64::from(k / 2) - 0.07, if k.is_multiple_of(2) { 0.2 } else { -0.2 });
            format!(
                "[[body]]\nname = \"w{k}\"\nmass = 1.0\ninertia = [0.004, 0.008, 0.004]\nshape = {{ cylinder = [{radius:?}, {width:?}], rpy = [{:?}, 0, 0] }}\n\
                 hinge = {{ type = \"revolute\", parent = \"cart\", at = [{x:?}, {y:?}, 0], axis = [0, 1, 0], velocity = {:?}{} }}\n",
                std::f64::consts::FRAC_PI_2,
                speed / radius,
                if k < 2 { format!(", force = {torque:?}") } else { String::new() },
            )
        };
        bench.write(
            "scene.toml",
            format!(
                "simulate = {{ start = \"given\", duration = 0.4, tolerance = 1e-9 }}\n{tables}\
                 [[body]]\nname = \"cart\"\nmass = 9\ninertia = [0.2, 0.2, 0.2]\n\
                 hinge = {{ type = \"free\", position = [0, 0, {radius:?}, 1, 0, 0, 0], velocity = [{speed:?}, 0, 0, 0, 0, 0] }}\n{}\
                 [[contact]]\nbetween = [\"t*\", \"w*\"]\nfriction = 0.8\n",
                (0..wheels).map(wheel).collect::<String>()
            ),
        );
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        let (end, velocity) = (&told["final"]["positions"]["cart"], &told["final"]["velocities"]["cart"]);
        let all = f64::from(wheels);
        let a = 2.0 * torque / radius / (9.0 + all + all * 0.008 / (radius * radius));
        assert!((number(&end[0]) - 0.4 * speed - 0.08 * a).abs() < 1e-7, "case {case}: {end}");
        assert!((number(&velocity[0]) - speed - 0.4 * a).abs() < 1e-7, "case {case}: {velocity}");
        assert_eq!((&told["impacts"], &told["capture_steps"]), (&0.into(), &0.into()), "case {case}");
        let events = told["events"].as_array().expect("events");
        assert!(!events.is_empty() && events.iter().all(|event| event["kind"] == "goes on"), "case {case}: {events:?}");
    }
}
