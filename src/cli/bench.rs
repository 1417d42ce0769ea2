//! `bench`: what this scene's own routines cost.

mod beside;

use super::inputs::Inputs;
use super::stopwatch::{Cost, time};
use super::{Common, Exit, Memory, output, scene, text};
use crate::dynamics::ensemble::WIDTH;
use crate::dynamics::{AccelerationJacobians, Coefficients, Fault, System, TangentSolver};
use crate::integrate::{Method, Options, Start};
use crate::model::Model;
use crate::simulate::problem::Equations;
use crate::statics::settings::Margin;
use crate::statics::{answer, equilibrium};
use anyhow::Context;
use beside::Beside;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use std::sync::Arc;

/// Above so many coordinates the dense Jacobians are left out: three of them would not fit into the caches, let alone
/// be wanted.
const MOST_DENSE: usize = 2000;

/// Cases side by side.
const LANES: f64 = WIDTH as f64;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// Call one routine only, `--calls` times, and time nothing: for profilers that count for themselves
    #[arg(long, value_enum, value_name = "ROUTINE", requires = "calls")]
    only: Option<Routine>,
    /// How often `--only` calls it
    #[arg(long, requires = "only")]
    calls: Option<usize>,
    /// Write the answer there as JSON
    #[arg(long, short = 'o', value_name = "PATH", conflicts_with = "only")]
    out: Option<PathBuf>,
}

/// What is measured.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Routine {
    /// One evaluation of the accelerations
    Acceleration,
    /// Both dense Jacobians of the accelerations
    Jacobian,
    /// The tangent of an implicit step, factorized and solved once
    TangentSolve,
    /// The stiffness at rest, factorized and solved once
    StaticStep,
    /// Accelerations of as many cases as are computed side by side
    LaneAcceleration,
    /// A step of `rk4` of as many cases
    LaneStep,
}

/// The routines with all they need.
struct Routines {
    system: System,
    /// None where too many force elements reach too far for the sweep.
    solver: Option<TangentSolver>,
    jacobians: Option<AccelerationJacobians>,
    beside: Option<Box<Beside>>,
    rest: Vec<f64>,
    a: Vec<f64>,
    x: Vec<f64>,
}

impl Routines {
    fn new(model: &Arc<Model>) -> anyhow::Result<Self> {
        let mut routines = Self {
            system: System::new(model),
            solver: (!TangentSolver::is_for_dense(model)).then(|| TangentSolver::new(model)),
            jacobians: None,
            beside: None,
            rest: vec![0.0; model.velocity_count()],
            a: model.start_velocity.clone(),
            x: model.start_velocity.clone(),
        };
        routines.system.at(0.0, &model.start_position, &model.start_velocity).accelerations(&mut routines.a)?;
        Ok(routines)
    }

    /// Whether the scene has the routine.
    fn prepare(&mut self, routine: Routine) -> bool {
        let model = &Arc::clone(self.system.model());
        match routine {
            Routine::Acceleration => true,
            Routine::Jacobian if model.is_constrained() || model.velocity_count() > MOST_DENSE => false,
            Routine::Jacobian => {
                self.jacobians.get_or_insert_with(|| AccelerationJacobians::new(model));
                true
            }
            Routine::TangentSolve | Routine::StaticStep => self.solver.is_some(),
            Routine::LaneAcceleration | Routine::LaneStep => {
                self.beside = self.beside.take().or_else(|| Beside::new(model));
                self.beside.is_some()
            }
        }
    }

    /// Calls a routine that [`Routines::prepare`] said the scene has.
    fn call(&mut self, routine: Routine) -> Result<bool, Fault> {
        match (routine, &mut self.beside) {
            (Routine::LaneAcceleration, Some(beside)) => return beside.accelerations().map(|()| true),
            (Routine::LaneStep, Some(beside)) => return Ok(beside.step()),
            _ => {}
        }
        let model = &Arc::clone(self.system.model());
        let (q, v) = (&model.start_position, &model.start_velocity);
        // A step well within what happens in the scene, as an implicit method takes it.
        let rate = 100.0 / model.time_scale();
        let implicit = Coefficients { c1: rate, c2: rate * rate, ..Coefficients::default() };
        let (v, a, with) = match (routine, &mut self.jacobians, &mut self.solver) {
            (Routine::Acceleration, ..) => {
                return self.system.at(0.0, q, v).accelerations(&mut self.x).map(|_| true);
            }
            (Routine::Jacobian, Some(jacobians), _) => {
                return self.system.at(0.0, q, v).acceleration_jacobians_into(jacobians).map(|()| true);
            }
            (Routine::TangentSolve, _, Some(_)) => (v, &self.a, implicit),
            (Routine::StaticStep, _, Some(_)) => (&self.rest, &self.rest, Coefficients::default()),
            _ => return Ok(false),
        };
        let Some(solver) = &mut self.solver else { return Ok(false) };
        let regular = self.system.at(0.0, q, v).factorize_tangent(solver, a, &with)?;
        self.x.fill(1.0);
        solver.solve(&mut self.x);
        Ok(regular)
    }

    fn cost(&mut self, routine: Routine) -> Option<Cost> {
        self.prepare(routine).then(|| time(|| self.call(routine)))
    }
}

/// What was measured.
struct Costs {
    acceleration: Cost,
    jacobian: Option<Cost>,
    tangent_solve: Option<Cost>,
    static_step: Option<Cost>,
    /// Of one of the cases side by side.
    lane_acceleration: Option<Cost>,
    lane_step: Option<Cost>,
    statics: Cost,
    /// Of a program that counts them.
    allocated: Option<Allocated>,
}

/// What a scene asks of the allocator.
struct Allocated {
    bytes_per_body: f64,
    per_step: f64,
}

pub(super) fn main(arguments: &Arguments, memory: Option<fn() -> Memory>) -> anyhow::Result<Exit> {
    let common = &arguments.common;
    let (scenario, model) = match scene::load(common)? {
        Ok(loaded) => loaded,
        Err(exit) => return Ok(exit),
    };
    let inputs = Inputs::of_scenario(common, &scenario, None);
    arguments.out.iter().try_for_each(|out| inputs.spare(out))?;
    if let (Some(routine), Some(calls)) = (arguments.only, arguments.calls) {
        let mut routines = Routines::new(&model)?;
        if !routines.prepare(routine) {
            anyhow::bail!(
                "{}: this scene does not have that routine: it is too large for the dense Jacobians, or has loops, drives, gears or forces that the sweep of the tangent does not cover",
                scenario.name
            );
        }
        for _ in 0..calls {
            routines.call(routine)?;
        }
        return Ok(Exit::Done);
    }
    let costs = measure(&scenario, &model, memory).with_context(|| format!("{}: cannot measure", scenario.name))?;
    if common.json || arguments.out.is_some() {
        let cost = |cost: Option<Cost>| cost.map_or(serde_json::Value::Null, Cost::json);
        let result = json!({
            "acceleration_ns": costs.acceleration.json(),
            "jacobian_ns": cost(costs.jacobian),
            "tangent_solve_ns": cost(costs.tangent_solve),
            "static_step_ns": cost(costs.static_step),
            "lanes": costs.lane_acceleration.zip(costs.lane_step).map(|(acceleration, step)| json!({
                "width": WIDTH, "acceleration_ns": acceleration.json(), "rk4_step_ns": step.json(),
                // Statics goes one by one, in sweeps as well.
                "static_step_ns": cost(costs.static_step),
            })),
            "statics_ms": costs.statics.min * 1e-6,
            "bodies": model.bodies.len(),
            "degrees_of_freedom": model.degrees_of_freedom(),
            "bytes_per_body": costs.allocated.as_ref().map(|allocated| allocated.bytes_per_body),
            "allocations_per_step": costs.allocated.as_ref().map(|allocated| allocated.per_step),
        });
        arguments.out.iter().try_for_each(|path| output::save(path, format!("{result:#}\n").as_bytes()))?;
        if common.json {
            output::print(&result.to_string())?;
        }
    }
    if common.json || common.quiet {
        return Ok(Exit::Done);
    }
    output::print(&text::heading(&model, &scenario.name))?;
    output::print(&report(&costs, model.bodies.len()))?;
    Ok(Exit::Done)
}

fn measure(
    scenario: &crate::scenario::Scenario,
    model: &Arc<Model>,
    memory: Option<fn() -> Memory>,
) -> anyhow::Result<Costs> {
    let allocated = memory.map(|memory| allocated(model, memory)).transpose()?;
    let mut routines = Routines::new(model)?;
    let acceleration = time(|| routines.call(Routine::Acceleration));
    let [jacobian, tangent_solve, static_step] =
        [Routine::Jacobian, Routine::TangentSolve, Routine::StaticStep].map(|routine| routines.cost(routine));
    let of_one = |Cost { min, median }: Cost| Cost { min: min / LANES, median: median / LANES };
    let [lane_acceleration, lane_step] =
        [Routine::LaneAcceleration, Routine::LaneStep].map(|routine| routines.cost(routine).map(of_one));
    let statics = match scenario.unknown.is_empty() {
        true => time(|| equilibrium(model, &scenario.statics, &model.start_position).map(drop)),
        false => time(|| {
            let (scene, model) = (scenario.description.clone(), Arc::clone(model));
            answer(scene, model, scenario.sought(), &scenario.statics, &Margin::default(), &|| true).map(drop)
        }),
    };
    Ok(Costs { acceleration, jacobian, tangent_solve, static_step, lane_acceleration, lane_step, statics, allocated })
}

fn allocated(model: &Arc<Model>, memory: fn() -> Memory) -> anyhow::Result<Allocated> {
    let before = memory().bytes;
    let scene = (model.clone(), Routines::new(model)?);
    let bytes = memory().bytes.wrapping_sub(before);
    drop(scene);
    Ok(Allocated { bytes_per_body: bytes as f64 / model.bodies.len() as f64, per_step: per_step(model, memory)? })
}

/// Requests for memory in one step of the default method, from the second step on.
fn per_step(model: &Arc<Model>, memory: fn() -> Memory) -> anyhow::Result<f64> {
    const STEPS: usize = 4;
    let mut motion = Equations::new(model);
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
    if costs.lane_acceleration.is_some() {
        out += &line(&format!("  {WIDTH} cases at once"), costs.lane_acceleration);
        out += &line(&format!("  step of rk4, {WIDTH} cases"), costs.lane_step);
    }
    out += &line("tangent, solved", costs.tangent_solve);
    out += &line("static step", costs.static_step);
    out += &line("jacobian, dense", costs.jacobian);
    out += &line("equilibrium", Some(costs.statics));
    out += &match &costs.allocated {
        Some(Allocated { bytes_per_body, per_step }) => format!(
            "  memory                 {bytes_per_body:.0} bytes a body\n  allocations            {per_step} in a step of sdirk4"
        ),
        None => "  memory                 not counted: build with `--features count-allocations`".to_owned(),
    };
    out
}
