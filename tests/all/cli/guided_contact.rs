//! Contacts of bodies that cannot move along all directions of the contact: what a slide, a loop or a drive takes away bears nothing, and
//! friction and pressure in the others are those of a free body.

use super::Bench;
use crate::common::Random;

const G: f64 = 9.80665;

/// A ball on a floor, on two of three slides or held by a loop, under a load that grows from zero to this within a second.
fn pulled(kept: &str, mass: f64, friction: f64, load: [f64; 3]) -> String {
    let slide = |name: &str, parent: &str, axis: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nhinge = {{ type = \"prismatic\", parent = \"{parent}\", axis = {axis} }}\n"
        )
    };
    let ball = |hinge: &str| {
        format!(
            "[[body]]\nname = \"ball\"\nmass = {mass:?}\ninertia = [0.01, 0.01, 0.01]\nshape = {{ sphere = 0.1 }}\nhinge = {{ {hinge} }}\n"
        )
    };
    let up = |parent: &str| {
        ball(&format!("type = \"prismatic\", parent = \"{parent}\", axis = [0, 0, 1], at = [0, 0, 0.1]"))
    };
    let held = match kept {
        "along x" => slide("along", "ground", "[1, 0, 0]") + &up("along"),
        "along y" => slide("along", "ground", "[0, 1, 0]") + &up("along"),
        "everywhere" => slide("along", "ground", "[1, 0, 0]") + &slide("across", "along", "[0, 1, 0]") + &up("across"),
        "in a plane by a loop" => {
            ball("type = \"free\", position = [0, 0, 0.1, 1, 0, 0, 0]")
                + "[[loop]]\nname = \"plane\"\ntype = \"planar\"\nrpy = [1.5707963267948966, 0, 0]\nbetween = [\"ground\", \"ball\"]\n"
        }
        "beside a drive" => {
            slide("along", "ground", "[1, 0, 0]")
                + &slide("across", "along", "[0, 1, 0]")
                + &up("across")
                + "[[drive]]\nhinge = \"across\"\ntype = \"hold\"\n"
        }
        other => panic!("{other}"),
    };
    format!(
        "simulate = {{ start = \"given\", duration = 1.0, tolerance = 1e-9 }}\n\
         [[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\" }}\n{held}\
         [[contact]]\nbetween = [\"floor\", \"ball\"]\nfriction = {friction:?}\n\
         [[force]]\ntype = \"load\"\non = \"ball\"\nforce = {load:?}\nover_time = {{ times = [0.0, 1.0], values = [0.0, 1.0] }}\n"
    )
}

fn place(bench: &Bench, text: &str) -> [f64; 3] {
    bench.write("scene.toml", text);
    let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
    assert_eq!(told["capture_steps"], 0, "{text}");
    let at = told["final"]["bodies"]["ball"]["position"].as_array().expect("three numbers");
    [0, 1, 2].map(|k| at[k].as_f64().expect("a number"))
}

/// Where a load that grows as `p t` has moved a mass one second after zero, from when it exceeds what holds it: `p (1 − t₀)³ / 6 m`.
fn moved(mass: f64, load: f64, holds: f64) -> f64 {
    let left = (1.0 - holds / load).max(0.0);
    load * left.powi(3) / (6.0 * mass)
}

#[test]
fn what_is_pulled_up_lifts_when_its_weight_is_borne() {
    let (bench, mut random) = (Bench::new(), Random::new(51));
    for kept in ["along x", "along y", "everywhere", "in a plane by a loop", "beside a drive"] {
        for _ in 0..3 {
            let (mass, friction) = (random.between(0.3, 5.0), random.between(0.05, 0.9));
            let load = mass * G * random.between(1.2, 4.0);
            let [x, y, z] = place(&bench, &pulled(kept, mass, friction, [0.0, 0.0, load]));
            let expected = 0.1 + moved(mass, load, mass * G);
            assert!((z - expected).abs() < 1e-7 && x.abs() + y.abs() < 1e-9, "{kept} {mass} {load}: {z} {expected}");
        }
    }
}

#[test]
fn what_is_pulled_aside_slips_at_its_friction() {
    let (bench, mut random) = (Bench::new(), Random::new(52));
    for (kept, along) in [("along x", 0), ("along y", 1), ("everywhere", 0), ("beside a drive", 0)] {
        for _ in 0..3 {
            let (mass, friction) = (random.between(0.3, 5.0), random.between(0.05, 0.9));
            let holds = friction * mass * G;
            let load = holds * random.between(1.2, 4.0);
            let mut force = [0.0; 3];
            force[along] = load;
            let at = place(&bench, &pulled(kept, mass, friction, force));
            // Friction goes on as large as it was.
            let expected = moved(mass, load, holds);
            assert!((at[along] - expected).abs() < 1e-7, "{kept} {mass} {friction} {load}: {} {expected}", at[along]);
        }
    }
}

/// A box that a drive takes along a floor rubs from the first to the last of its way: μ m g s.
#[test]
fn what_a_drive_takes_along_rubs_on_its_way() {
    let (bench, mut random) = (Bench::new(), Random::new(53));
    for shape in ["box = [0.2, 0.2, 0.2]", "sphere = 0.1"] {
        let (mass, friction, way) = (random.between(0.3, 5.0), random.between(0.05, 0.9), random.between(0.2, 0.8));
        bench.write(
            "scene.toml",
            format!(
                "simulate = {{ start = \"given\", duration = 1.0, tolerance = 1e-9 }}\n\
                 [[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\" }}\n\
                 [[body]]\nname = \"along\"\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0] }}\n\
                 [[body]]\nname = \"ball\"\nmass = {mass:?}\ninertia = [0.01, 0.01, 0.01]\nshape = {{ {shape} }}\n\
                 hinge = {{ type = \"prismatic\", parent = \"along\", axis = [0, 0, 1], at = [0, 0, 0.1] }}\n\
                 [[contact]]\nbetween = [\"floor\", \"ball\"]\nfriction = {friction:?}\n\
                 [[drive]]\nname = \"d\"\nhinge = \"along\"\ntype = \"ramp\"\nto = {way:?}\nbegin = 0.1\nduration = 0.8\n"
            ),
        );
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        let number = |key: &str| told[key].as_f64().expect("a number");
        let rubbed = friction * mass * G * way;
        // Below a ten-thousandth of the scene's speed what is taken along counts as at rest.
        assert!((number("energy_dissipated") - rubbed).abs() < 1e-5 * rubbed, "{shape}: {rubbed} {told}");
        assert!(number("energy_drift") < 1e-6 * rubbed, "{shape}: {told}");
    }
}
