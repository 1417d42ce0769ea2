//! `precision`: its table, its files, its JSON.

use super::{Bench, shipped};

const SHORT: [&str; 4] = ["--set", "simulate.duration=0.5", "--limit", "1"];

#[test]
fn precision_writes_a_table_and_a_plot_and_recommends() {
    let bench = Bench::new();
    let scenario = shipped("double_pendulum");
    let value =
        bench.call(&[&["precision", &scenario, "--json", "--error", "1e-5"], &SHORT[..]].concat()).code(0).json();
    assert_eq!(bench.names(), ["double_pendulum.precision.csv", "double_pendulum.precision.svg"]);
    assert_eq!((&value["reference"]["method"], &value["reference"]["tolerance"]), (&"dop853".into(), &1e-13.into()));
    let points = value["points"].as_array().expect("points");
    for point in points {
        let fixed = point["integrator"] == "rk4" || point["integrator"] == "gauss";
        assert_eq!(point["step"].is_number(), fixed, "{point}");
        assert_ne!(point["tolerance"].is_number(), point["step"].is_number(), "{point}");
        // A method of order 2 cannot reach the tightest tolerances in time, and says so.
        if point["failed"] == true {
            assert_eq!(point["integrator"], "generalized-alpha", "{point}");
            assert!(point["why"].as_str().expect("a reason").ends_with(" 1 s"), "{point}");
            continue;
        }
        for key in ["error", "wall_seconds", "steps", "acceleration_evaluations"] {
            assert!(point[key].is_number(), "{key}: {point}");
        }
    }
    assert!(value["recommended"]["error"].as_f64().expect("an error") <= 1e-5);

    let read = |name: &str| std::fs::read_to_string(bench.path().join(name)).expect("a file");
    let csv = read("double_pendulum.precision.csv");
    assert_eq!(csv.lines().count(), points.len() + 1);
    assert!(csv.starts_with("integrator,tolerance,step,error,energy_error,wall_seconds,steps,"));
    let svg = read("double_pendulum.precision.svg");
    for text in [
        "rk4",
        "dopri5",
        "dop853",
        "adams",
        "sdirk4",
        "radau9",
        "gauss",
        "time of the steps (s)",
        "Chaotic double pendulum",
    ] {
        assert!(svg.contains(text), "`{text}` is not in the plot");
    }
}

#[test]
fn precision_prints_what_it_compares_with_and_takes_another_name() {
    let bench = Bench::new();
    let scenario = shipped("double_pendulum");
    let answer = bench.call(&[&["precision", &scenario, "--out", "mine"], &SHORT[..]].concat()).code(0);
    assert!(answer.out.contains("reference    dop853 at 1e-13; for dop853 itself radau9 at 1e-13"), "{answer:#?}");
    assert!(answer.out.contains("recommended  "), "{answer:#?}");
    assert_eq!(bench.names(), ["mine.precision.csv", "mine.precision.svg"]);
    let wrong = bench.call(&["precision", &scenario, "--error", "-1"]).code(2);
    assert!(wrong.err.contains("allowed is a number above 0"), "{wrong:#?}");
}
