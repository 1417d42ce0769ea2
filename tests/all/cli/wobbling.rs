//! A disc that wobbles about its resting centre (Moffatt, "Euler's disk and its finite-time singularity", Nature 404, 2000): the
//! contact goes around the rim and nothing else moves up or down.

use super::Bench;
use crate::common::Random;

const G: f64 = 9.80665;

/// A thin disc of 1 kg and radius R that leans by an angle α turns about the line from its contact to its centre at `Ω sin α`,
/// with `Ω² = 4 g / (R sin α)` the rate at which the contact goes around. With spheres far away, of which the disc may meet any, there
/// are more pairs than events follow.
fn scene(radius: f64, lean: f64, heading: f64, spheres: usize, tolerance: f64) -> String {
    let turning = (4.0 * G * lean.sin() / radius).sqrt();
    let (disc, far) = (radius * radius / 4.0, "[[contact]]\nbetween = [\"disc\", \"far[*]\"]\nfriction = 0.5\n");
    // Turned by `heading` about z, then leaned about the new y.
    let ([c, s], [h, k]) = ([(0.5 * lean).cos(), (0.5 * lean).sin()], [(0.5 * heading).cos(), (0.5 * heading).sin()]);
    let turn = format!("{:?}, {:?}, {:?}, {:?}", h * c, -k * s, h * s, k * c);
    let others = match spheres {
        0 => String::new(),
        n => format!(
            "[[body]]\nname = \"far\"\nrepeat = {n}\nshape = {{ sphere = 0.01 }}\nhinge = {{ type = \"fixed\", at = [100, 0, 0] }}\n\
             next = [0.1, 0, 0]\n{far}"
        ),
    };
    format!(
        "simulate = {{ start = \"given\", duration = 0.2, tolerance = {tolerance:e} }}\n\
         [[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\" }}\n\
         [[body]]\nname = \"disc\"\nmass = 1.0\ninertia = [{disc:?}, {disc:?}, {:?}]\n\
         shape = {{ cylinder = [{radius:?}, 0.01], at = [0, 0, 0.005] }}\n\
         hinge = {{ type = \"free\", position = [0, 0, {:?}, {turn}], velocity = [0, 0, 0, {turning:?}, 0, 0] }}\n\
         [[contact]]\nbetween = [\"disc\", \"floor\"]\nfriction = 0.9\n{others}",
        2.0 * disc,
        radius * lean.sin(),
    )
}

/// How far the centre and the energy are off at the end, in parts of the height and of the energy, and how many steps were captured.
fn off(bench: &Bench, text: &str) -> ([f64; 2], u64) {
    bench.write("scene.toml", text);
    let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
    let number = |of: &serde_json::Value| of.as_f64().expect("a number");
    let (start, end) = (number(&told["energy_start"]), number(&told["energy_end"]));
    let at = told["final"]["bodies"]["disc"]["position"].as_array().expect("three numbers");
    let height = number(&at[2]);
    let potential = G * height;
    // Half of the energy is that of the height, and as much that of turning: ½ (R²/4) (4 g sin α / R).
    let off = (potential - start * 2.0 / 3.0).abs() / potential;
    ([off, (end - start).abs() / start], told["capture_steps"].as_u64().expect("a count"))
}

#[test]
fn a_disc_wobbles_about_its_resting_centre_by_events() {
    let (bench, mut random) = (Bench::new(), Random::new(41));
    for _ in 0..6 {
        let (radius, lean, heading) = (random.between(0.05, 0.5), random.between(0.1, 0.7), random.between(0.0, 6.0));
        let (off, captured) = off(&bench, &scene(radius, lean, heading, 0, 1e-9));
        assert!(off.iter().all(|off| *off < 1e-8) && captured == 0, "{radius} {lean} {heading}: {off:?}");
    }
}

/// Captured steps follow the rim to their tolerance, the root of the run's (in parts of the largest shape), and with order 2: of several discs, as the errors of one may cancel.
#[test]
fn a_disc_wobbles_about_its_resting_centre_by_captured_steps() {
    let (bench, mut random) = (Bench::new(), Random::new(42));
    let mut sums = [[0.0; 2]; 2];
    for _ in 0..6 {
        let (radius, lean, heading) = (random.between(0.08, 0.4), random.between(0.2, 0.5), random.between(0.0, 6.0));
        for (sum, (tolerance, allowed)) in sums.iter_mut().zip([(1e-8, 3e-3), (1e-10, 3e-4)]) {
            let (off, captured) = off(&bench, &scene(radius, lean, heading, 1001, tolerance));
            assert!(
                off.iter().all(|off| *off < allowed) && captured > 10,
                "{radius} {lean} {heading}: {off:?} {captured}"
            );
            *sum = [sum[0] + off[0], sum[1] + captured as f64];
        }
    }
    let [[coarse, few], [fine, many]] = sums;
    let order = (coarse / fine).ln() / (many / few).ln();
    assert!(order > 1.7, "{order}: {sums:?}");
}
