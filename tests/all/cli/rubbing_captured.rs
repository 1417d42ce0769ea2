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

/// Four boxes topple over each other with a load on the last, from a moment after friction has given way: nothing is won by that, nor does
/// anything pull.
#[test]
fn a_toppling_stack_gains_nothing_by_friction() {
    let bench = Bench::new();
    let body = |name: &str, mass: f64, inertia: [f64; 3], edges: [f64; 3], position: [f64; 7], velocity: [f64; 6]| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = {mass:?}\ninertia = {inertia:?}\nshape = {{ box = {edges:?} }}\n\
             hinge = {{ type = \"free\", position = {position:?}, velocity = {velocity:?} }}\n"
        )
    };
    let scene = "gravity = [3.2499479653918404, -0.31408885978394147, -9.247138510528814]\n\
                 simulate = { start = \"given\", duration = 0.1, tolerance = 1e-8 }\nrecord = { rate = 200.0 }\n\
                 [[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n"
        .to_owned()
        + &body(
            "b0",
            0.7857746997521394,
            [0.0018918957255285246, 0.007889504094564534, 0.009269010024045633],
            [0.3414271316393914, 0.15804965022078885, 0.06254993183206696],
            [
                -3.083894924151021e-11,
                1.462369212338349e-11,
                0.031274965916033494,
                0.8451205649210821,
                -2.306103930331993e-17,
                -1.9380262031135365e-17,
                0.5345757483719881,
            ],
            [
                -1.3765277770037584e-16,
                2.5830452805339687e-16,
                5.126474681751912e-16,
                -6.489203181795413e-15,
                -1.941185984851907e-15,
                -9.881116205817073e-17,
            ],
        )
        + &body(
            "b1",
            0.7856039542282262,
            [0.009219762340374346, 0.013812346208129165, 0.015090291577779044],
            [0.38771987758092974, 0.2831529124473897, 0.2462826011485873],
            [
                0.11136905092831371,
                -0.09714320775539746,
                0.1682940800264359,
                0.8523749706293248,
                0.22401180714356692,
                0.17060828253311702,
                0.4406454738630946,
            ],
            [
                0.37856437052309483,
                -0.17951039693430418,
                -0.25050675997574345,
                3.9024368204796462,
                0.6850010115994946,
                1.5945704399169025e-15,
            ],
        )
        + &body(
            "b2",
            1.3295410715554614,
            [0.00715381711309541, 0.017894461004576968, 0.02307469509542143],
            [0.3906444143982054, 0.23592698610713803, 0.09437401818116538],
            [
                0.12377912956713608,
                -0.1959013941132332,
                0.3363469663576983,
                0.9434812822406954,
                0.16497611076345312,
                0.22819149564782493,
                0.1747987249748329,
            ],
            [
                0.9801942121257274,
                -0.46479559565593864,
                -0.46258596458982204,
                2.867431500036286,
                2.7342414151510637,
                -3.5238481899306794e-15,
            ],
        )
        + &body(
            "b3",
            0.4005902817839292,
            [0.00275482454316617, 0.0032051513253777467, 0.0032687155148690443],
            [0.23601574661919697, 0.2054593300049908, 0.20077206108793733],
            [
                0.19081638213744267,
                -0.26229756210377286,
                0.4545954838261148,
                0.900652857735922,
                0.20089052993169287,
                0.19713750249366258,
                0.33106529559354664,
            ],
            [
                1.403426141968421,
                -0.662954153031846,
                -0.8077584089854138,
                3.556559803036869,
                1.6283807904872303,
                0.0004514773908468478,
            ],
        )
        + "[[force]]\ntype = \"load\"\nname = \"push\"\non = \"b3\"\n\
           force = [0.22096672148948227, -0.5830017604841421, -0.4783488617163204]\n\
           torque = [-0.02943277078342905, 0.008580046871837317, 0.01937802343382489]\n\
           [[contact]]\nbetween = [\"floor\", \"b0\"]\nfriction = 1.144314372648997\n\
           [[contact]]\nbetween = [\"b0\", \"b1\"]\nfriction = 0.9219709338483482\n\
           [[contact]]\nbetween = [\"b1\", \"b2\"]\nfriction = 1.1499053604673584\n\
           [[contact]]\nbetween = [\"b2\", \"b3\"]\nfriction = 1.0014405249054275\n";
    bench.write("scene.toml", &scene);
    let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
    let number = |key: &str| told[key].as_f64().expect("a number");
    assert!(number("energy_dissipated") > 0.0, "{} J dissipated", number("energy_dissipated"));
    assert!(number("energy_end") < number("energy_start") + number("energy_work"), "{told}");
}

/// Stacks of seven boxes that fall some millimetres onto each other and bounce: captured steps keep them apart to the end.
#[test]
fn stacks_that_bounce_are_kept_apart() {
    let (bench, mut random) = (Bench::new(), Random::new(73));
    for _ in 0..2 {
        let mut scene = "simulate = { start = \"given\", duration = 0.3, tolerance = 1e-6 }\n\
                         [[body]]\nname = \"table\"\nshape = { box = [2.0, 2.0, 0.1], at = [0, 0, -0.05] }\nhinge = { type = \"fixed\" }\n"
            .to_owned();
        let mut top = 0.0;
        for k in 0..7 {
            let edges = [random.between(0.25, 0.4), random.between(0.25, 0.4), random.between(0.06, 0.12)];
            let at = top + random.between(0.001, 0.03) + 0.5 * edges[2];
            top = at + 0.5 * edges[2];
            let [x, y] = [0; 2].map(|_| random.between(-0.02, 0.02));
            scene += &format!(
                "[[body]]\nname = \"b{k}\"\ndensity = 200\nshape = {{ box = {edges:?} }}\n\
                 hinge = {{ type = \"free\", position = [{x:?}, {y:?}, {at:?}, 1, 0, 0, 0] }}\n"
            );
        }
        scene += "[[contact]]\nbetween = [\"*\", \"*\"]\nfriction = 0.5\nrestitution = 0.2\n";
        bench.write("scene.toml", &scene);
        // What sinks by a hundredth of its size ends a run.
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        let number = |key: &str| told[key].as_f64().expect("a number");
        assert!(number("energy_end") < number("energy_start"), "{told}");
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
