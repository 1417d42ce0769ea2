//! Three shipped scenarios against solutions by other programs; what each method needs for them.

use nalgebra::Point3;
use stillpoint::record::{Memory, Opening};
use stillpoint::simulate::{self, State, Summary};

use super::case::{Node, case};
use crate::scenarios::shipped;

/// A run of a shipped scenario with an integrator and a tolerance, and where the marker that counts ends.
fn run(name: &str, integrator: &str, tolerance: f64) -> (Summary, Point3<f64>) {
    let changes = [format!("simulate.integrator={integrator:?}"), format!("simulate.tolerance={tolerance:e}")];
    let (scenario, model) = shipped(name, &[&changes[0], &changes[1]]);
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let still = simulate::scene(&model);
    let mut memory = Memory::new(&Opening { scene: &still, scenario: &scenario.text, statics: None });
    let summary = simulate::run(&model, &scenario.simulate, 1.0, &start, &mut memory, &mut |_, _| true)
        .unwrap_or_else(|error| panic!("{name} with {integrator}: {error}"));
    let last = model.bodies.len() - 1;
    let (_, marker) = &model.bodies[last].markers[0];
    let tip = summary.poses[last] * Point3::from(*marker);
    (summary, tip)
}

fn check(name: &str, integrator: &str, tolerance: f64) {
    let case = case("integration_speed");
    let (_, tip) = run(name, integrator, tolerance);
    expected(&case, name).check_list(tip.coords.as_slice(), case.tolerance(name));
}

fn expected(case: &Node, name: &str) -> Node {
    case.at("reference").at(name).at("position")
}

fn error(name: &str, tip: &Point3<f64>) -> f64 {
    (tip - Point3::from(expected(&case("integration_speed"), name).array::<3>())).norm()
}

#[test]
fn five_links_end_where_another_program_says() {
    for method in ["dop853", "radau9"] {
        check("five_links", method, 1e-13);
    }
}

#[test]
fn heavy_top_ends_where_another_program_says() {
    for method in ["dop853", "radau9"] {
        check("heavy_top", method, 1e-13);
    }
}

#[test]
fn stiff_chain_ends_where_another_program_says() {
    for method in ["radau5", "radau9"] {
        check("stiff_chain", method, 1e-11);
    }
}

/// At a tolerance of 1e-10 all three are met to 1e-8.
#[test]
fn a_tolerance_of_ten_digits_gives_eight() {
    for (name, methods) in [
        ("five_links", &["dopri5", "dop853", "radau9"][..]),
        ("heavy_top", &["dopri5", "dop853", "sdirk4", "radau5", "radau9"]),
        ("stiff_chain", &["sdirk4", "radau5", "radau9", "auto"]),
    ] {
        for method in methods {
            let (summary, tip) = run(name, method, 1e-10);
            let error = error(name, &tip);
            println!("{name} {method}: error {error:.1e}, {} steps", summary.statistics.steps);
            assert!(error < 1e-8, "{name} {method}: {error:e}");
        }
    }
}

/// Work that counts: accelerations of `dop853`, and for the stiff chain residuals and tangents of `radau9`.
#[test]
fn an_error_of_a_millionth_and_of_a_billionth_cost_what_is_told() {
    for (name, tolerance, most, accelerations) in [
        ("five_links", 3e-5, 1e-6, 2_500),
        ("five_links", 3e-7, 1e-9, 4_400),
        ("heavy_top", 1.5e-4, 1e-6, 2_000),
        ("heavy_top", 3e-7, 1e-9, 4_400),
    ] {
        let (summary, tip) = run(name, "dop853", tolerance);
        let error = error(name, &tip);
        println!("{name}: error {error:.1e}, {} accelerations", summary.statistics.acceleration_evaluations);
        assert!(error < most && summary.statistics.acceleration_evaluations < accelerations, "{name}: {error:e}");
    }
    for (tolerance, most, residuals, tangents) in [(1e-6, 1e-6, 2_200, 220), (1e-8, 3e-9, 3_600, 310)] {
        let (summary, tip) = run("stiff_chain", "radau9", tolerance);
        let (error, work) = (error("stiff_chain", &tip), summary.statistics);
        println!("stiff_chain: error {error:.1e}, {work:?}");
        assert!(error < most && work.residual_evaluations < residuals && work.jacobian_evaluations < tangents);
    }
}
