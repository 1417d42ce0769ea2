//! What an instance is in, as it is kept and as bytes.

use super::FmuError;
use crate::integrate::Method;
use crate::simulate::{Grid, Mode, Resume, State};
use crate::simulator::{Simulator, Snapshot};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The states of co-simulation without event mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Phase {
    #[default]
    Instantiated,
    Initialization,
    Step,
    Terminated,
}

impl Phase {
    const ALL: [Self; 4] = [Self::Instantiated, Self::Initialization, Self::Step, Self::Terminated];

    /// Within “it is not allowed …”.
    pub(super) fn said(self) -> &'static str {
        match self {
            Self::Instantiated => "before initialization",
            Self::Initialization => "in initialization mode",
            Self::Step => "in step mode",
            Self::Terminated => "after the experiment was terminated",
        }
    }
}

/// All that the next call of an instance depends on.
#[derive(Debug, Clone, Default)]
pub struct Situation {
    pub(super) phase: Phase,
    /// What was set before the scene was put at its start, by value reference.
    pub(super) given: BTreeMap<u32, f64>,
    pub(super) tolerance: Option<f64>,
    /// Start of the simulation (s).
    pub(super) begin: f64,
    /// End of the simulation, if one is given (s).
    pub(super) stop: Option<f64>,
    /// Once the scene is at its start.
    pub(super) simulator: Option<Simulator>,
}

/// A number with all its bits, whatever reads and writes JSON.
fn bits(number: f64) -> Value {
    Value::from(number.to_bits())
}

fn list(numbers: &[f64]) -> Value {
    numbers.iter().copied().map(bits).collect()
}

fn number(value: &Value) -> Option<f64> {
    value.as_u64().map(f64::from_bits)
}

fn numbers(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(number).collect()
}

/// What may be missing: `null` for that.
fn maybe<T>(value: &Value, read: impl FnOnce(&Value) -> Option<T>) -> Option<Option<T>> {
    if value.is_null() { Some(None) } else { read(value).map(Some) }
}

impl Situation {
    /// As JSON.
    pub(super) fn to_bytes(&self, token: &str) -> Vec<u8> {
        let snapshot = self.simulator.as_ref().map(|simulator| written(simulator.snapshot()));
        let value = json!({
            "token": token,
            "phase": self.phase as u8,
            "references": self.given.keys().collect::<Vec<_>>(),
            "given": list(&self.given.values().copied().collect::<Vec<_>>()),
            "tolerance": self.tolerance.map(bits),
            "begin": bits(self.begin),
            "stop": self.stop.map(bits),
            "snapshot": snapshot,
        });
        value.to_string().into_bytes()
    }

    /// The situation, still without its simulator, and where that is.
    pub(super) fn of_bytes(bytes: &[u8], token: &str, variables: usize) -> Result<(Self, Option<Snapshot>), FmuError> {
        let value: Value = serde_json::from_slice(bytes).map_err(|error| FmuError::State(error.to_string()))?;
        if value["token"] != token {
            return Err(FmuError::State("they are of another FMU".to_owned()));
        }
        let read = || {
            let known = |reference: &Value| {
                reference.as_u64().filter(|at| (*at as usize) < variables).and_then(|at| u32::try_from(at).ok())
            };
            let references: Vec<u32> = value["references"].as_array()?.iter().map(known).collect::<Option<_>>()?;
            let given = numbers(&value["given"]).filter(|given| given.len() == references.len())?;
            let situation = Self {
                phase: *Phase::ALL.get(value["phase"].as_u64()? as usize)?,
                given: references.into_iter().zip(given).collect(),
                tolerance: maybe(&value["tolerance"], number)?,
                begin: number(&value["begin"])?,
                stop: maybe(&value["stop"], number)?,
                simulator: None,
            };
            Some((situation, maybe(&value["snapshot"], snapshot)?))
        };
        read().ok_or_else(|| FmuError::State("they are damaged".to_owned()))
    }
}

fn written(now: &Snapshot) -> Value {
    let resume = now.resume.as_ref().map(|resume| {
        json!({
            "time": bits(resume.time),
            "method": resume.method.name(),
            "step": resume.step.map(bits),
            "origin": resume.grid.map(|grid| bits(grid.origin)),
            "steps": resume.grid.map(|grid| grid.steps),
            "mode": resume.mode.as_ref().map(|mode| list(&mode.numbers())),
        })
    });
    json!({
        "time": bits(now.time),
        "position": list(&now.state.position),
        "velocity": list(&now.state.velocity),
        "inputs": list(&now.inputs),
        "memories": now.memories.iter().map(|memory| list(memory)).collect::<Vec<_>>(),
        "resume": resume,
        "stopped_by": now.stopped_by,
    })
}

fn snapshot(value: &Value) -> Option<Snapshot> {
    let resume = |value: &Value| {
        let name = value["method"].as_str()?;
        let grid = |value: &Value| Some(Grid { origin: number(&value["origin"])?, steps: value["steps"].as_u64()? });
        Some(Resume {
            time: number(&value["time"])?,
            method: Method::ALL.into_iter().find(|method| method.name() == name)?,
            step: maybe(&value["step"], number)?,
            grid: if value["origin"].is_null() { None } else { Some(grid(value)?) },
            mode: maybe(&value["mode"], |mode| Mode::of_numbers(&numbers(mode)?).map(Arc::new))?,
        })
    };
    Some(Snapshot {
        time: number(&value["time"])?,
        state: State { position: numbers(&value["position"])?, velocity: numbers(&value["velocity"])? },
        inputs: numbers(&value["inputs"])?,
        memories: value["memories"].as_array()?.iter().map(numbers).collect::<Option<_>>()?,
        resume: maybe(&value["resume"], resume)?,
        stopped_by: maybe(&value["stopped_by"], |text| text.as_str().map(str::to_owned))?,
    })
}
