//! The keys that scripts rely on.

use super::{Bench, shipped};
use serde_json::Value;

#[track_caller]
fn has(value: &Value, keys: &[&str]) {
    for key in keys {
        assert!(value.get(key).is_some(), "no `{key}` in {value}");
    }
}

#[track_caller]
fn numbers(value: &Value, count: usize) {
    let list = value.as_array().unwrap_or_else(|| panic!("no list: {value}"));
    assert!(list.len() == count && list.iter().all(Value::is_number), "{value}");
}

#[track_caller]
fn is_statics(statics: &Value) {
    has(
        statics,
        &[
            "converged",
            "method",
            "stage",
            "iterations",
            "residual_acceleration",
            "residual_force",
            "positions",
            "bodies",
            "stability",
            "unstable_directions",
            "frequencies_hz",
            "reactions",
            "wall_seconds",
        ],
    );
    assert_eq!(statics["converged"], true);
    assert_eq!(statics["stability"], "stable");
    numbers(&statics["positions"]["machine"], 7);
    assert!(statics["positions"].get("motor").is_none(), "a weld has no coordinates");
    numbers(&statics["frequencies_hz"], 6);
    let frequencies: Vec<f64> =
        statics["frequencies_hz"].as_array().expect("a list").iter().map(|f| f.as_f64().expect("a number")).collect();
    assert!(frequencies.is_sorted(), "{frequencies:?}");
    for body in ["machine", "motor"] {
        numbers(&statics["bodies"][body]["position"], 3);
        numbers(&statics["bodies"][body]["quaternion"], 4);
        numbers(&statics["reactions"][body]["force"], 3);
        numbers(&statics["reactions"][body]["moment"], 3);
    }
}

#[test]
fn statics() {
    let bench = Bench::new();
    let answer = bench.call(&["statics", &shipped("machine_on_mounts"), "--json", "--out", "found.json"]).code(0);
    is_statics(&answer.json());
    let written = std::fs::read_to_string(bench.path().join("found.json")).expect("the result");
    assert_eq!(serde_json::from_str::<Value>(&written).expect("JSON"), answer.json());
}

#[test]
fn run() {
    let bench = Bench::new();
    let answer = bench.call(&["run", &shipped("machine_on_mounts"), "--json"]).code(0);
    assert!(answer.err.is_empty(), "{answer:#?}");
    let run = answer.json();
    has(
        &run,
        &[
            "scenario",
            "recording",
            "start",
            "end_time",
            "integrator",
            "steps",
            "rejected_steps",
            "acceleration_evaluations",
            "jacobian_evaluations",
            "energy_start",
            "energy_end",
            "energy_drift",
            "constraint_error",
            "final",
            "wall_seconds",
        ],
    );
    is_statics(&run["start"]);
    assert_eq!((&run["recording"], &run["constraint_error"]), (&"machine_on_mounts.mcap".into(), &0.0.into()));
    assert_eq!(run["end_time"], 10.0);
    numbers(&run["final"]["positions"]["machine"], 7);
    numbers(&run["final"]["velocities"]["machine"], 6);
    numbers(&run["final"]["bodies"]["motor"]["quaternion"], 4);
    assert_eq!(bench.names(), ["machine_on_mounts.mcap"]);
    let given = bench.call(&["run", &shipped("pendulum"), "--json"]).code(0).json();
    assert_eq!(given["start"], "given");
}

#[test]
fn rest() {
    let bench = Bench::new();
    let rest = bench.call(&["rest", &shipped("machine_on_mounts"), "--json"]).code(0).json();
    has(&rest, &["rested", "duration", "max_displacement", "max_speed", "tolerance", "statics"]);
    assert_eq!((&rest["rested"], &rest["duration"]), (&true.into(), &10.0.into()));
    for largest in ["max_displacement", "max_speed"] {
        assert_eq!(rest[largest]["hinge"], "machine");
        assert!(rest[largest]["value"].is_number());
    }
    is_statics(&rest["statics"]);
    assert!(bench.names().is_empty(), "a proof is recorded where it is asked for");
    bench.call(&["rest", &shipped("pendulum"), "--quiet", "--out", "proof.mcap"]).code(0);
    assert_eq!(bench.names(), ["proof.mcap"]);
    bench.write("brick.toml", super::BRICK);
    let falls = bench.call(&["rest", "brick.toml", "--json"]).code(1).json();
    has(&falls, &["rested", "duration", "max_displacement", "max_speed", "tolerance", "statics"]);
}

#[test]
fn inspect() {
    let bench = Bench::new();
    let inspect = bench.call(&["inspect", &shipped("machine_on_mounts"), "--json"]).code(0).json();
    has(
        &inspect,
        &[
            "bodies",
            "degrees_of_freedom",
            "loops",
            "total_mass",
            "center_of_mass",
            "kinetic_energy",
            "potential_energy",
            "positions",
            "velocities",
            "accelerations",
        ],
    );
    assert_eq!(
        (&inspect["bodies"], &inspect["degrees_of_freedom"], &inspect["loops"]),
        (&3.into(), &6.into(), &0.into())
    );
    numbers(&inspect["center_of_mass"], 3);
    numbers(&inspect["positions"]["machine"], 7);
    numbers(&inspect["accelerations"]["machine"], 6);
}

/// What a routine costs is positive, the median is no less than the minimum, and a step asks for no memory.
#[test]
fn bench() {
    let answer = Bench::new().call(&["bench", &shipped("double_pendulum"), "--json"]).code(0).json();
    for key in ["acceleration_ns", "jacobian_ns", "tangent_solve_ns", "static_step_ns"] {
        let (min, median) = (answer[key]["min"].as_f64().expect(key), answer[key]["median"].as_f64().expect(key));
        assert!(0.0 < min && min <= median, "{key}: {answer}");
    }
    assert!(answer["statics_ms"].as_f64().expect("a time") > 0.0);
    assert_eq!((&answer["bodies"], &answer["degrees_of_freedom"]), (&2.into(), &2.into()));
    if cfg!(feature = "count-allocations") {
        assert!(answer["bytes_per_body"].as_f64().expect("a size") > 100.0);
        assert_eq!(answer["allocations_per_step"], 0.0);
    } else {
        assert_eq!((&answer["bytes_per_body"], &answer["allocations_per_step"]), (&Value::Null, &Value::Null));
    }
}
