//! Outputs of a run: at one state, and over the samples of a run.

use crate::dynamics::{Fault, Powers};
use crate::model::{Model, Output};
use crate::output::{Given, Outputs, Varied};
use crate::record::{Outcome, RecordError, Recorder, Sample};
use crate::simulate::problem::Equations;
use crate::simulate::state::State;
use crate::spatial::Wrench;
use nalgebra::Vector3;
use std::sync::Arc;

/// Evaluates the outputs of a model at states of a run, stops included.
#[derive(Debug, Clone)]
pub(in crate::simulate) struct StateOutputs {
    outputs: Outputs,
    asks_power: bool,
    /// Time and state of the last evaluation, and what it gave: numbers, and rates; not a number for one that is not known.
    last: Option<(f64, State)>,
    values: Vec<f64>,
    rates: Vec<f64>,
    accelerations: Vec<f64>,
    residual: Vec<f64>,
    stops: Vec<f64>,
    reactions: Vec<Wrench>,
    contacts: Vec<Vector3<f64>>,
}

impl StateOutputs {
    /// `None` for a model without outputs.
    pub(in crate::simulate) fn new(model: &Model) -> Option<Self> {
        let n = model.velocity_count();
        Some(Self {
            outputs: Outputs::new(model)?,
            asks_power: Outputs::asks_power(model),
            last: None,
            values: Vec::new(),
            rates: Vec::new(),
            accelerations: vec![0.0; n],
            residual: vec![0.0; n],
            stops: vec![0.0; n],
            reactions: Vec::new(),
            contacts: Vec::new(),
        })
    }

    /// Forgets the last evaluation: what is discrete has changed.
    pub(in crate::simulate) fn forget(&mut self) {
        self.last = None;
    }

    /// All numbers at a state; `account` is the work put in and the energy taken out so far (J).
    ///
    /// # Errors
    /// As [`Outputs::evaluate`], and a state that cannot be evaluated.
    pub(in crate::simulate) fn at(
        &mut self,
        motion: &mut Equations,
        time: f64,
        state: &State,
        account: [f64; 2],
    ) -> Result<&[f64], Fault> {
        let (q, v) = (&state.position[..], &state.velocity[..]);
        // Powers of drives solve for accelerations of their own.
        let powers = if self.asks_power { motion.powers(time, q, v) } else { Powers::default() };
        let energies = motion.energies(time, q, v);
        motion.accelerations(time, q, v, &mut self.accelerations)?;
        motion.choose_forces(time, q, v)?;
        motion.stop_forces(q, v, &mut self.stops);
        motion.contact_forces(&mut self.contacts);
        let mut at = motion.at(time, q, v);
        at.share_multipliers()?;
        let balanced = at.residual(&self.accelerations, &mut self.residual)?;
        balanced.reactions(&mut self.reactions);
        let given = Given {
            accelerations: &self.accelerations,
            reactions: &self.reactions,
            stops: &self.stops,
            contacts: &self.contacts,
            energies,
            account,
            powers,
        };
        let values = self.outputs.evaluate(&balanced, &given)?;
        self.values.clear();
        self.values.extend_from_slice(values);
        let by = Varied { time: 1.0, position: v, velocity: &self.accelerations, acceleration: &[], others: &[] };
        self.rates.clear();
        self.rates.extend_from_slice(self.outputs.vary(&balanced, &given, &by));
        Ok(&self.values)
    }

    /// All numbers at a state and their rates; `None` if the state cannot be evaluated.
    pub(in crate::simulate) fn seen(
        &mut self,
        motion: &mut Equations,
        time: f64,
        state: &State,
    ) -> Option<[&[f64]; 2]> {
        let same = |(at, of): &(f64, State)| *at == time && of == state;
        if !self.last.as_ref().is_some_and(same) {
            if self.at(motion, time, state, [0.0; 2]).is_err() {
                self.last = None;
                return None;
            }
            let (at, of) = self.last.get_or_insert_default();
            *at = time;
            of.clone_from(state);
        }
        Some([&self.values, &self.rates])
    }

    /// One number at a state and its rate; not a number for a rate that is not known, and for both if the state cannot be
    /// evaluated.
    pub(in crate::simulate) fn watched(
        &mut self,
        motion: &mut Equations,
        time: f64,
        state: &State,
        number: usize,
    ) -> [f64; 2] {
        self.seen(motion, time, state).map_or([f64::NAN; 2], |all| all.map(|of| of[number]))
    }
}

/// The outputs of a model at its start and a time (s), with no stop touched; empty for a model without.
///
/// # Errors
/// The output that is not a finite number, or a start that cannot be evaluated.
pub fn at_start(model: &Arc<Model>, time: f64) -> Result<Vec<f64>, Fault> {
    let Some(mut outputs) = StateOutputs::new(model) else { return Ok(Vec::new()) };
    let state = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    outputs.at(&mut Equations::new(model), time, &state, [0.0; 2]).map(<[f64]>::to_vec)
}

/// Names and values of the outputs at a place, one for each number.
pub fn columns(model: &Model, values: &[f64]) -> Vec<(String, f64)> {
    model.outputs.iter().flat_map(Output::labels).zip(values.iter().copied()).collect()
}

/// Outputs over the samples of a run: a [`Recorder`] that keeps the extremes and the mean square of each number.
#[derive(Debug, Clone, Default)]
pub struct OutputRanges {
    /// Of each number: the least, the largest, and the integral of the square over time.
    ranges: Vec<[f64; 3]>,
    /// The last sample.
    last: Vec<f64>,
    /// Of the first and the last sample (s).
    times: Option<[f64; 2]>,
}

impl Recorder for OutputRanges {
    fn sample(&mut self, sample: &Sample) -> Result<(), RecordError> {
        let [first, before] = self.times.unwrap_or([sample.time; 2]);
        self.times = Some([first, sample.time]);
        if self.ranges.is_empty() {
            self.ranges = vec![[f64::INFINITY, f64::NEG_INFINITY, 0.0]; sample.outputs.len()];
            self.last = sample.outputs.to_vec();
        }
        for (([least, largest, square], last), x) in self.ranges.iter_mut().zip(&mut self.last).zip(sample.outputs) {
            (*least, *largest) = (least.min(*x), largest.max(*x));
            // The square of what is straight between two samples, integrated.
            *square += (sample.time - before) * (*last * *last + *last * x + x * x) / 3.0;
            *last = *x;
        }
        Ok(())
    }

    fn finish(&mut self, _outcome: &Outcome) -> Result<(), RecordError> {
        Ok(())
    }
}

impl OutputRanges {
    /// Names and values of what a run says of its outputs, `end` being those at its end: `camber.end`, `camber.min`,
    /// `camber.max`, `camber.rms`. The last three are of the samples.
    pub fn columns(&self, model: &Model, end: &[f64]) -> Vec<(String, f64)> {
        let span = self.times.map_or(0.0, |[first, last]| last - first);
        let each = |(label, (end, (range, last))): (String, (&f64, (&[f64; 3], &f64)))| {
            let [least, largest, square] = range;
            let rms = if span > 0.0 { (square / span).sqrt() } else { last.abs() };
            [("end", *end), ("min", *least), ("max", *largest), ("rms", rms)]
                .map(|(what, x)| (format!("{label}.{what}"), x))
        };
        let labels = model.outputs.iter().flat_map(Output::labels);
        labels.zip(end.iter().zip(self.ranges.iter().zip(&self.last))).flat_map(each).collect()
    }
}
