//! Scenes at the edges: ends that cancel to zero, what nothing but contact holds, beams whose tips are on their cones.

use super::Bench;

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
