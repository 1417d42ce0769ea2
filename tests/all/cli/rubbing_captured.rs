//! Friction never drives: what is nearly at rest comes to rest. Dry friction of hinges, stops and couplings beside contacts push with
//! what Newton's laws ask for, from the first sample on.

use super::Bench;
use crate::common::Random;

/// A box that lies on a floor and hardly moves: what its edges take away turns the direction of its slip round.
#[test]
fn friction_does_not_set_off_what_is_nearly_at_rest() {
    let (bench, mut random) = (Bench::new(), Random::new(71));
    for _ in 0..60 {
        let [a, b, c] = [0; 3].map(|_| random.between(0.1, 0.4));
        let (slip, turn) = (random.between(-2e-8, 2e-8), random.between(-2e-7, 2e-7));
        let (friction, restitution) = (random.between(0.1, 0.8), random.between(0.0, 0.9));
        bench.write(
            "scene.toml",
            format!(
                "simulate = {{ start = \"given\", duration = 0.2, tolerance = 1e-8 }}\n\
                 [[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\" }}\n\
                 [[body]]\nname = \"box\"\ndensity = 500\nshape = {{ box = [{a:?}, {b:?}, {c:?}] }}\n\
                 hinge = {{ type = \"free\", position = [0, 0, {:?}, 1, 0, 0, 0], velocity = [{slip:?}, 0, 0, 0, {turn:?}, 0] }}\n\
                 [[contact]]\nbetween = [\"floor\", \"box\"]\nfriction = {friction:?}\nrestitution = {restitution:?}\n",
                0.5 * c
            ),
        );
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        let velocities = told["final"]["velocities"]["box"].as_array().expect("six numbers").iter();
        let fastest = velocities.map(|v| v.as_f64().expect("a number").abs()).fold(0.0, f64::max);
        assert!(fastest < 1e-6, "{slip} {turn}: {fastest}");
        assert!(told["energy_dissipated"].as_f64().expect("a number") > -1e-12, "{slip} {turn}");
    }
}

/// A cart with dry friction in its hinge carries a box: what drives it, turns a flywheel with it or holds it by a rod pushes against
/// friction, too; a stop that a motor presses on bears that. At t = 0 and at the end.
#[test]
fn couplings_push_against_dry_friction_beside_contact() {
    let (bench, mut random) = (Bench::new(), Random::new(72));
    for _ in 0..4 {
        let [cart, load, wheel] = [0; 3].map(|_| random.between(0.5, 4.0));
        let (rubs, a) = (random.between(0.5, 4.0), random.between(0.5, 2.0));
        let scene = |more: &str, output: &str| {
            format!(
                "simulate = {{ start = \"given\", duration = 0.3, tolerance = 1e-8 }}\nrecord = {{ rate = 100.0 }}\n\
                 [[body]]\nname = \"cart\"\nmass = {cart:?}\ninertia = [0.1, 0.1, 0.1]\n\
                 shape = {{ box = [6.0, 1.0, 0.1], at = [0, 0, -0.05] }}\n\
                 hinge = {{ type = \"prismatic\", axis = [1, 0, 0], friction = {rubs:?}, velocity = 1.0{more}\n\
                 [[body]]\nname = \"load\"\nmass = {load:?}\ninertia = [0.01, 0.01, 0.01]\nshape = {{ box = [0.4, 0.4, 0.1] }}\n\
                 hinge = {{ type = \"free\", position = [0, 0, 0.05, 1, 0, 0, 0], velocity = [1, 0, 0, 0, 0, 0] }}\n\
                 [[contact]]\nbetween = [\"cart\", \"load\"]\nfriction = 0.9\n\
                 [[output]]\nname = \"push\"\ntype = \"force\"\nof = \"{output}\"\n"
            )
        };
        // A flywheel of a gear with ratio 1, pulled by a motor; a drive that accelerates.
        let force = rubs + (cart + load + wheel) * a;
        let geared = scene(
            &format!(
                ", force = {force:?} }}\n[[body]]\nname = \"wheel\"\nmass = {wheel:?}\ninertia = [0.1, 0.1, 0.1]\n\
                 hinge = {{ type = \"prismatic\", axis = [0, 1, 0], at = [0, 9, 0], velocity = 1.0 }}\n\
                 [[gear]]\nname = \"gear\"\ntype = \"ratio\"\nbetween = [\"wheel\", \"cart\"]\nratio = 1.0"
            ),
            "gear",
        );
        let driven = scene(
            &format!(
                " }}\n[[drive]]\nname = \"drive\"\nhinge = \"cart\"\ntype = \"expression\"\nexpression = \"t + {:?}*t^2\"",
                0.5 * a
            ),
            "drive",
        );
        for (scene, right) in [(geared, wheel * a), (driven, rubs + (cart + load) * a)] {
            bench.write("scene.toml", &scene);
            bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0);
            bench.call(&["export", "a.mcap", "--csv", "a.csv"]).code(0);
            let table = std::fs::read_to_string(bench.path().join("a.csv")).expect("a table");
            let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
            let heads = rows.next().expect("headings");
            let at = heads.iter().position(|head| head.starts_with("push")).expect("the output");
            for row in rows {
                let push: f64 = row[at].parse().expect("a number");
                assert!((push.abs() - right).abs() < 1e-6 * right, "t = {}: {push}, not {right}", row[0]);
            }
        }
    }
}

/// The motor that presses a cart on its stop is what the stop bears.
#[test]
fn a_stop_bears_what_presses_on_it_beside_contact() {
    let bench = Bench::new();
    bench.write(
        "scene.toml",
        "simulate = { start = \"given\", duration = 0.5, tolerance = 1e-8 }\n\
         [[body]]\nname = \"cart\"\nmass = 2.0\ninertia = [0.1, 0.1, 0.1]\nshape = { box = [6.0, 1.0, 0.1], at = [0, 0, -0.05] }\n\
         hinge = { type = \"prismatic\", axis = [1, 0, 0], force = 12.0, limits = { high = 0.05 } }\n\
         [[body]]\nname = \"load\"\nmass = 1.0\ninertia = [0.01, 0.01, 0.01]\nshape = { box = [0.4, 0.4, 0.1] }\n\
         hinge = { type = \"free\", position = [0, 0, 0.05, 1, 0, 0, 0] }\n\
         [[contact]]\nbetween = [\"cart\", \"load\"]\nfriction = 0.9\n[[output]]\nname = \"stop\"\ntype = \"force\"\nof = \"cart\"\n",
    );
    let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
    let stop = told["outputs"]["stop"].as_f64().expect("a number");
    // Forces of captured steps are found as far as positions ask for it.
    assert!((stop + 12.0).abs() < 1e-6, "{stop}");
}
