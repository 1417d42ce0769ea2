//! What contacts push with, as outputs: at rest, while things slide, in captured steps, and as something that happens.

use super::Bench;
use crate::common::Random;
use serde_json::Value;

const G: f64 = 9.80665;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

fn near(found: &Value, right: &[f64], tolerance: f64, what: &str) {
    let found = numbers(found);
    assert!(found.iter().zip(right).all(|(a, b)| (a - b).abs() < tolerance), "{what}: {found:?} not {right:?}");
}

/// A crate on a slope about y, which falls towards +x.
fn slope(angle: f64, mass: f64, friction: f64, between: [&str; 2], more: &str) -> String {
    let inertia = mass * 0.04 / 6.0;
    let [first, second] = between;
    format!(
        "simulate = {{ start = \"given\", duration = 0.5 }}\n{more}\
         [[body]]\nname = \"slope\"\nshape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\", rpy = [0, {angle:?}, 0] }}\n\
         [[body]]\nname = \"crate\"\nmass = {mass:?}\ninertia = [{inertia:?}, {inertia:?}, {inertia:?}]\nshape = {{ box = [0.2, 0.2, 0.2] }}\n\
         hinge = {{ type = \"free\", position = [{:?}, 0, {:?}, {:?}, 0, {:?}, 0] }}\n\
         [[contact]]\nname = \"under\"\nbetween = [\"{first}\", \"{second}\"]\nfriction = {friction:?}\n\
         [[output]]\nname = \"held\"\ntype = \"force\"\nof = \"under\"\n\
         [[output]]\nname = \"up\"\ntype = \"force\"\nof = \"contact[0]\"\ncomponent = \"fz\"\n",
        0.1 * angle.sin(),
        0.1 * angle.cos(),
        (0.5 * angle).cos(),
        (0.5 * angle).sin(),
    )
}

/// What holds a crate is its weight, and what it slides with is Coulomb's law: on the second body of the contact, whichever that is.
#[test]
fn slopes_push_as_newtons_law_says() {
    let (bench, mut random) = (Bench::new(), Random::new(91));
    for case in 0..12 {
        let (angle, mass) = (random.between(0.1, 0.5), random.between(0.5, 20.0));
        let part = if case % 2 == 0 { random.between(1.01, 2.0) } else { random.between(0.2, 0.99) };
        let friction = part * angle.tan();
        let turned = case % 3 == 0;
        let (between, sign) = if turned { (["crate", "slope"], -1.0) } else { (["slope", "crate"], 1.0) };
        bench.write("scene.toml", slope(angle, mass, friction, between, ""));
        let normal = mass * G * angle.cos();
        let along = if part > 1.0 { mass * G * angle.sin() } else { friction * normal };
        // The slope falls along (cos, 0, −sin), its normal is (sin, 0, cos).
        let right = [normal * angle.sin() - along * angle.cos(), 0.0, normal * angle.cos() + along * angle.sin()];
        let right = right.map(|x| sign * x);
        let what = format!("case {case}");
        let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
        near(&told["outputs"]["held"], &right, 1e-6 * mass * G, &what);
        near(&Value::Array(vec![told["outputs"]["up"].clone()]), &right[2..], 1e-6 * mass * G, &what);
        if part > 1.0 {
            let told = bench.call(&["statics", "scene.toml", "--json"]).code(0).json();
            near(&told["outputs"]["held"], &right, 1e-6 * mass * G, &what);
        }
    }
}

/// The forces of all that a pattern fits are one, in captured steps as well.
#[test]
fn forces_of_a_pattern_are_summed() {
    let (bench, mut random) = (Bench::new(), Random::new(92));
    let mut text = "simulate = { start = \"given\", duration = 0.6, tolerance = 1e-6 }\n\
         [[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n"
        .to_owned();
    let mut weight = 0.0;
    for k in 0..14 {
        let mass = random.between(0.5, 2.0);
        weight += mass * G;
        text += &format!(
            "[[body]]\nname = \"crate[{k}]\"\nmass = {mass:?}\ninertia = [0.01, 0.01, 0.01]\nshape = {{ box = [0.2, 0.2, 0.2] }}\n\
             hinge = {{ type = \"free\", position = [{:?}, 0, 0.12, 1, 0, 0, 0], velocity = [0.3, 0, 0, 0, 0, 0] }}\n",
            0.5 * f64::from(k)
        );
    }
    text += "[[contact]]\nname = \"under\"\nbetween = [\"floor\", \"crate[*]\"]\nfriction = 0.4\n\
         [[output]]\nname = \"held\"\ntype = \"force\"\nof = \"under\"\n";
    bench.write("scene.toml", text);
    let told = bench.call(&["run", "scene.toml", "--json", "--out", "a.mcap"]).code(0).json();
    assert!(told["capture_steps"].as_u64().is_some_and(|steps| steps > 0));
    near(&told["outputs"]["held"], &[0.0, 0.0, weight], 1e-3 * weight, "at rest");
}

/// A run ends when a contact is relieved to a given force: a crate is lifted by a force that grows.
#[test]
fn a_contact_that_is_relieved_ends_a_run() {
    let bench = Bench::new();
    let lift = "[[force]]\ntype = \"load\"\non = \"crate\"\nforce = [0, 0, 1]\nover_time = { times = [0, 10], values = [0, 100] }\n\
         [[event]]\nname = \"relieved\"\noutput = \"up\"\nvalue = 15.0\naction = \"stop\"\n";
    let scene = slope(0.0, 2.0, 0.5, ["slope", "crate"], "") + lift;
    bench.write("scene.toml", scene);
    let told =
        bench.call(&["run", "scene.toml", "--set", "simulate.duration=3", "--json", "--out", "a.mcap"]).code(0).json();
    let end = told["end_time"].as_f64().expect("a time");
    assert!((end - (2.0 * G - 15.0) / 10.0).abs() < 1e-9, "{end}");
}

/// A component that a contact does not have, and a name that is nearly one.
#[test]
fn contacts_have_no_moment() {
    let bench = Bench::new();
    let scene = slope(0.1, 1.0, 0.5, ["slope", "crate"], "");
    for (from, to, said) in [
        ("\"fz\"", "\"mz\"", "the force of a contact has no moment"),
        ("of = \"under\"", "of = \"undr\"", "did you mean `under`?"),
    ] {
        bench.write("scene.toml", scene.replace(from, to));
        let answer = bench.call(&["check", "scene.toml"]).code(2);
        assert!(answer.err.contains(said), "{}", answer.err);
    }
}
