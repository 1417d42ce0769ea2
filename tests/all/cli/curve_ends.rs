//! What a curve leaves of a body whose hinge opens at its end.

use super::Bench;
use crate::common::Random;

/// What follows a curve keeps its turning where the curve ends and its hinge opens there, to the last digit of the arc length or a little before.
#[test]
fn what_leaves_at_the_end_of_a_curve_goes_on_turning() {
    for seed in 0..20 {
        let mut random = Random::new(9_500 + seed);
        let (radius, speed, inertia) = (random.between(0.3, 2.0), random.between(1.0, 6.0), random.between(0.01, 0.5));
        let (backward, before) = (seed % 2 == 1, if seed % 3 == 0 { 1e-9 } else { 0.0 });
        let (first, last) = (random.between(-2.0, -0.5), random.between(0.5, 2.0));
        let curve = format!(
            "{{ parameter = \"u\", x = \"{radius:?}*sin(u)\", y = \"{radius:?}*(1 - cos(u))\", range = [{first:?}, {last:?}] }}"
        );
        let end = if backward { first * radius + before } else { last * radius - before };
        let velocity = if backward { -speed } else { speed };
        let text = format!(
            "gravity = [0, 0, 0]\n[simulate]\nstart = \"given\"\nduration = 4\ntolerance = 1e-11\n[[body]]\nname = \"b\"\nmass = 1.0\n\
             inertia = [{inertia:?}, {inertia:?}, {inertia:?}]\nhinge = {{ type = \"along\", curve = {curve}, velocity = {velocity:?} }}\n\
             [[stage]]\nname = \"fly\"\nwhen = {{ event = \"end\" }}\nopen = [\"b\"]\n[[event]]\nname = \"end\"\nhinge = \"b\"\nvalue = {end:?}\n"
        );
        let bench = Bench::new();
        bench.write("scene.toml", text);
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        let v: Vec<f64> =
            told["final"]["velocities"]["b"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        let turning = (v[3] * v[3] + v[4] * v[4] + v[5] * v[5]).sqrt();
        assert!((turning - speed / radius).abs() < 1e-8 * speed / radius, "seed {seed}: {v:?}");
    }
}
