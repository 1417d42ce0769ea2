//! `bench`: what this scene's own routines cost.

use super::stopwatch::{Cost, time};
use super::{Common, Exit, Memory, output, scene, text};
use crate::dynamics::{AccelerationJacobians, Coefficients, System, TangentSolver};
use crate::integrate::{Method, Options, Start};
use crate::model::Model;
use crate::simulate::problem::Motion;
use crate::statics::equilibrium;
use anyhow::Context;
use clap::Args;
use serde_json::json;

/// Above so many coordinates the dense Jacobians are left out: three of them would not fit into the caches, let alone
/// be wanted.
const MOST_DENSE: usize = 2000;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
}

/// What was measured.
struct Costs {
    acceleration: Cost,
    jacobian: Option<Cost>,
    tangent_solve: Option<Cost>,
    static_step: Option<Cost>,
    statics: Cost,
    bytes_per_body: f64,
    allocations_per_step: f64,
}

pub(super) fn main(arguments: &Arguments, memory: fn() -> Memory) -> anyhow::Result<Exit> {
    let common = &arguments.common;
    let (scenario, model) = match scene::load(common)? {
        Ok(loaded) => loaded,
        Err(exit) => return Ok(exit),
    };
    let costs = measure(&scenario, &model, memory).with_context(|| format!("{}: cannot measure", scenario.name))?;
    if common.json {
        let cost = |cost: Option<Cost>| cost.map_or(serde_json::Value::Null, Cost::json);
        let result = json!({
            "acceleration_ns": costs.acceleration.json(),
            "jacobian_ns": cost(costs.jacobian),
            "tangent_solve_ns": cost(costs.tangent_solve),
            "static_step_ns": cost(costs.static_step),
            "statics_ms": costs.statics.min * 1e-6,
            "bodies": model.bodies.len(),
            "degrees_of_freedom": model.velocity_count(),
            "bytes_per_body": costs.bytes_per_body,
            "allocations_per_step": costs.allocations_per_step,
        });
        output::print(&result.to_string())?;
        return Ok(Exit::Done);
    }
    output::print(&text::heading(&model, &scenario.name))?;
    output::print(&report(&costs, model.bodies.len()))?;
    Ok(Exit::Done)
}

fn measure(scenario: &crate::scenario::Scenario, model: &Model, memory: fn() -> Memory) -> anyhow::Result<Costs> {
    let (q, v) = (&model.start_position, &model.start_velocity);
    let before = memory().bytes;
    let copy = model.clone();
    let mut system = System::new(model);
    let mut solver = TangentSolver::covers(model).then(|| TangentSolver::new(model));
    let bytes = memory().bytes.saturating_sub(before);
    drop(copy);

    let mut a = v.clone();
    system.accelerations(q, v, &mut a)?;
    let acceleration = time(|| system.accelerations(q, v, &mut a));
    let jacobian = match model.velocity_count() <= MOST_DENSE {
        true => {
            let mut jacobians = AccelerationJacobians::new(model);
            Some(time(|| system.acceleration_jacobians_into(q, v, &mut jacobians)))
        }
        false => None,
    };
    // A step well within what happens in the scene, as an implicit method takes it.
    let rate = 100.0 / model.time_scale();
    let with = Coefficients { c1: rate, c2: rate * rate, ..Coefficients::default() };
    let rest = vec![0.0; v.len()];
    let mut x = v.clone();
    let mut tangent_solve = None;
    let mut static_step = None;
    if let Some(solver) = &mut solver {
        tangent_solve = Some(time(|| {
            let regular = system.factorize_tangent(solver, q, v, &a, &with);
            x.fill(1.0);
            solver.solve(model, &mut x);
            regular
        }));
        static_step = Some(time(|| {
            let regular = system.factorize_tangent(solver, q, &rest, &rest, &Coefficients::default());
            x.fill(1.0);
            solver.solve(model, &mut x);
            regular
        }));
    }
    equilibrium(model, &scenario.statics, q)?;
    let statics = time(|| equilibrium(model, &scenario.statics, q));
    Ok(Costs {
        acceleration,
        jacobian,
        tangent_solve,
        static_step,
        statics,
        bytes_per_body: bytes as f64 / model.bodies.len() as f64,
        allocations_per_step: allocations(model, memory)?,
    })
}

/// Requests for memory in one step of the default method, from the second step on.
fn allocations(model: &Model, memory: fn() -> Memory) -> anyhow::Result<f64> {
    const STEPS: usize = 4;
    let mut motion = Motion::new(model);
    let start = Start {
        time: 0.0,
        position: &model.start_position,
        velocity: &model.start_velocity,
        end: 1e3 * model.time_scale(),
    };
    let mut stepper = Method::Sdirk4.start(&mut motion, &Options::default(), start)?;
    stepper.step(&mut motion)?;
    let before = memory().allocations;
    for _ in 0..STEPS {
        stepper.step(&mut motion)?;
    }
    Ok((memory().allocations - before) as f64 / STEPS as f64)
}

fn report(costs: &Costs, bodies: usize) -> String {
    let line = |name: &str, cost: Option<Cost>| match cost {
        Some(cost) => format!(
            "  {name:<22} {:>11}   {:>11}   {:>9.1}\n",
            text::nanoseconds(cost.min),
            text::nanoseconds(cost.median),
            cost.min / bodies as f64
        ),
        None => format!("  {name:<22} {:>11}\n", "–"),
    };
    let mut out = format!("  {:<22} {:>11}   {:>11}   {:>9}\n", "routine", "fastest", "median", "ns a body");
    out += &line("accelerations", Some(costs.acceleration));
    out += &line("tangent, solved", costs.tangent_solve);
    out += &line("static step", costs.static_step);
    out += &line("jacobian, dense", costs.jacobian);
    out += &line("equilibrium", Some(costs.statics));
    out += &format!(
        "  memory                 {:.0} bytes a body\n  allocations            {} in a step of sdirk4",
        costs.bytes_per_body, costs.allocations_per_step
    );
    out
}
