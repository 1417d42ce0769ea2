//! An instance: the states of co-simulation, and the calls that are allowed in each.
//!
//! ```text
//!               enter_initialization       exit_initialization            terminate
//! Instantiated ─────────────────────► Initialization ─────────────► Step ──────────► Terminated
//!      ▲ parameters, inputs             parameters, inputs; outputs   inputs, steps,     outputs
//!      └────────────────────────────── reset ──────────────────────── outputs ───────────────┘
//! ```
//!
//! What is read during initialization is that of the equilibrium with what is set so far.

use super::FmuError;
use super::derivative;
use super::manifest::Manifest;
use super::scene::{Scene, at_start};
use super::state::{Phase, Situation};
use super::variables::{Role, Variable, Variables};
use crate::simulate::Start;
use crate::simulator::Simulator;
use crate::text_file;
use std::collections::BTreeMap;
use std::path::Path;

/// A communication point may differ from the time that was reached by this part of the step: rounding of sums.
const SAME_POINT: f64 = 1e-6;

/// An input that statics finds may be set to what it finds, but for this part.
const SAME_INPUT: f64 = 1e-9;

/// An instance of an FMU.
#[derive(Debug)]
pub struct Instance {
    manifest: Manifest,
    /// The scenario's name in messages, and its text.
    source: [String; 2],
    variables: Variables,
    now: Situation,
}

/// What a communication step came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Stepped {
    /// The time reached (s).
    pub time: f64,
    /// The event of the scene that ended the run there.
    pub stopped_by: Option<String>,
    /// What happened on the way: time (s) and text.
    pub events: Vec<(f64, String)>,
}

impl Instance {
    /// Reads what lies in a folder of resources. `token` is that of the model description.
    ///
    /// # Errors
    /// If the resources are not those of this FMU, and if the scenario is wrong.
    pub fn new(resources: &Path, token: &str) -> Result<Self, FmuError> {
        let manifest = Manifest::read(resources)?;
        if manifest.token != token {
            let message = format!(
                "the instantiation token is `{token}`, that of the resources in {} is `{}`",
                resources.display(),
                manifest.token
            );
            return Err(FmuError::Resources(message));
        }
        let path = manifest.scenario.split('/').fold(resources.to_owned(), |path, part| path.join(part));
        let text = text_file::read(&path, "scenario").map_err(|error| FmuError::Resources(error.to_string()))?;
        let source = [path.display().to_string(), text];
        let scene = Scene::read(&source[0], &source[1], &manifest.set)?;
        let variables = Variables::of(&scene, &scene.model, &manifest.parameters)?;
        Ok(Self { manifest, source, variables, now: Situation::default() })
    }

    /// Its variables.
    pub fn variables(&self) -> &Variables {
        &self.variables
    }

    fn order(&self, allowed: &[Phase], when: &'static str) -> Result<(), FmuError> {
        match allowed.contains(&self.now.phase) {
            true => Ok(()),
            false => Err(FmuError::Order { state: self.now.phase.said(), allowed: when }),
        }
    }

    /// Enters initialization: the experiment begins at a time (s) and never steps beyond `stop`; `tolerance` stands in the place of
    /// the scenario's.
    ///
    /// # Errors
    /// Out of order; times and tolerances that make no sense, and a start other than 0 of a scene that starts at its equilibrium.
    pub fn enter_initialization(
        &mut self,
        tolerance: Option<f64>,
        begin: f64,
        stop: Option<f64>,
    ) -> Result<(), FmuError> {
        self.order(&[Phase::Instantiated], "after instantiation and after a reset")?;
        if let Some(value) = tolerance.filter(|value| !(*value > 0.0 && *value < 1.0)) {
            return Err(FmuError::Time(format!("the tolerance is {value}, allowed: between 0 and 1")));
        }
        if !(begin >= 0.0 && begin.is_finite()) {
            return Err(FmuError::Time(format!("the start time is {begin} s, allowed: a finite number ≥ 0")));
        }
        if let Some(stop) = stop.filter(|stop| !(*stop > begin)) {
            return Err(FmuError::Time(format!("the stop time is {stop} s, allowed: later than {begin} s")));
        }
        (self.now.tolerance, self.now.begin, self.now.stop) = (tolerance, begin, stop);
        self.now.phase = Phase::Initialization;
        Ok(())
    }

    /// Ends initialization: with the scene at its equilibrium, or as given.
    ///
    /// # Errors
    /// Out of order; values of parameters that the scene does not allow, and a scene without equilibrium.
    pub fn exit_initialization(&mut self) -> Result<(), FmuError> {
        self.order(&[Phase::Initialization], "in initialization mode")?;
        self.started()?;
        self.now.phase = Phase::Step;
        Ok(())
    }

    /// The simulator, once initialization has begun: made with what is set if nothing was asked of it so far.
    fn started(&mut self) -> Result<&mut Simulator, FmuError> {
        if self.now.simulator.is_none() {
            self.now.simulator = Some(self.start()?);
        }
        self.now.simulator.as_mut().ok_or_else(|| FmuError::Scene("there is no scene".to_owned()))
    }

    /// The scene with what is set, at its start.
    pub(super) fn start(&self) -> Result<Simulator, FmuError> {
        let named = |(reference, value): (&u32, &f64)| (&self.variables.list[*reference as usize], *value);
        let given: Vec<(&Variable, f64)> = self.now.given.iter().map(named).collect();
        let mut set = self.manifest.set.clone();
        let unknown = |scene: &Scene, address: &str| scene.scenario.unknown.iter().any(|one| one.address == address);
        let first = self.read(&set)?;
        for (variable, value) in &given {
            match variable.role {
                Role::Input(_) => {
                    let address = format!("{}.force", variable.name);
                    if !unknown(&first, &address) {
                        set.push(format!("{address}={value:?}"));
                    }
                }
                Role::Parameter => set.push(format!("{}={value:?}", variable.name)),
                Role::Time | Role::Position(_) | Role::Velocity(_) | Role::Output(_) => {}
            }
        }
        let mut scene = if given.is_empty() { first } else { self.read(&set)? };
        let settings = &mut scene.scenario.simulate;
        if let Some(tolerance) = self.now.tolerance {
            (settings.tolerance, settings.absolute_tolerance) = (tolerance, tolerance);
        }
        if self.now.begin != 0.0 && settings.start == Start::Equilibrium {
            return Err(FmuError::Time(format!(
                "the start time is {} s: the equilibrium is that of the scene at 0 s, where an experiment with it begins",
                self.now.begin
            )));
        }
        let settings = settings.clone();
        let (model, state) = at_start(&scene)?;
        let found = Variables::of(&scene, &model, &self.manifest.parameters)?;
        let names = |variables: &Variables| variables.list.iter().map(|one| one.name.clone()).collect::<Vec<_>>();
        if names(&found) != names(&self.variables) {
            let message =
                "these values of the parameters make a scene with other variables than the model description has";
            return Err(FmuError::Scene(message.to_owned()));
        }
        let mut simulator = Simulator::new(model, settings, state);
        simulator.begin(self.now.begin);
        let forces = simulator.snapshot().inputs.clone();
        for (variable, value) in &given {
            let Role::Input(place) = variable.role else { continue };
            if (forces[place] - value).abs() > SAME_INPUT * forces[place].abs().max(value.abs()) {
                let why = format!(
                    "statics finds it ({:?}) before it can be set, and it was set to {value:?}; set it after initialization",
                    forces[place]
                );
                return Err(FmuError::Fixed { name: variable.name.clone(), why });
            }
        }
        Ok(simulator)
    }

    fn read(&self, set: &[String]) -> Result<Scene, FmuError> {
        Scene::read(&self.source[0], &self.source[1], set)
    }

    /// Ends the experiment.
    ///
    /// # Errors
    /// Out of order.
    pub fn terminate(&mut self) -> Result<(), FmuError> {
        self.order(&[Phase::Step], "in step mode")?;
        self.now.phase = Phase::Terminated;
        Ok(())
    }

    /// As it was after instantiation.
    pub fn reset(&mut self) {
        self.now = Situation::default();
    }

    /// The value of a variable.
    ///
    /// # Errors
    /// Without such a variable; if an output is asked for before initialization; if there is no equilibrium.
    pub fn value(&mut self, reference: u32) -> Result<f64, FmuError> {
        let variable = self.variables.get(reference)?;
        let given = || self.now.given.get(&reference).copied().or(variable.start).unwrap_or_default();
        match variable.role {
            Role::Time => Ok(self.now.simulator.as_ref().map_or(self.now.begin, |one| one.snapshot().time)),
            Role::Parameter => Ok(given()),
            Role::Input(place) => Ok(match &self.now.simulator {
                Some(simulator) => simulator.snapshot().inputs[place],
                None => given(),
            }),
            Role::Position(place) => Ok(self.observed()?.snapshot().state.position[place]),
            Role::Velocity(place) => Ok(self.observed()?.snapshot().state.velocity[place]),
            Role::Output(place) => Ok(self.observed()?.outputs()?[place]),
        }
    }

    /// The simulator, if outputs may be read now.
    fn observed(&mut self) -> Result<&mut Simulator, FmuError> {
        let when = [Phase::Initialization, Phase::Step, Phase::Terminated];
        self.order(&when, "of outputs from initialization mode on")?;
        self.started()
    }

    /// Sets variables: parameters until initialization ends, inputs until the end; all of them or, with an error, none.
    ///
    /// # Errors
    /// Without such a variable; one that cannot be set, or not now; a value that is not a finite number.
    pub fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), FmuError> {
        if references.len() != values.len() {
            return Err(FmuError::Count { given: values.len(), wanted: references.len() });
        }
        self.order(&[Phase::Instantiated, Phase::Initialization, Phase::Step], "until the experiment is terminated")?;
        let stepping = self.now.phase == Phase::Step;
        let mut inputs = Vec::new();
        for (reference, value) in references.iter().zip(values) {
            let variable = self.variables.get(*reference)?;
            let name = variable.name.clone();
            match variable.role {
                Role::Input(place) => inputs.push((place, *value)),
                Role::Parameter if !stepping => {}
                Role::Parameter => {
                    let why =
                        "it is a fixed parameter: allowed until initialization ends, and after a reset".to_owned();
                    return Err(FmuError::Fixed { name, why });
                }
                Role::Time => return Err(FmuError::Fixed { name, why: "it is the independent variable".to_owned() }),
                Role::Position(_) | Role::Velocity(_) | Role::Output(_) => {
                    return Err(FmuError::Fixed { name, why: "it is an output".to_owned() });
                }
            }
            if !value.is_finite() {
                return Err(FmuError::NotFinite { name, value: *value });
            }
        }
        if let Some(simulator) = self.now.simulator.as_mut().filter(|_| stepping) {
            let mut all = simulator.snapshot().inputs.clone();
            inputs.iter().for_each(|(place, value)| all[*place] = *value);
            simulator.set_inputs(&all);
        } else {
            let set: BTreeMap<u32, f64> = references.iter().copied().zip(values.iter().copied()).collect();
            self.now.given.extend(set);
            self.now.simulator = None;
        }
        Ok(())
    }

    /// Goes on from a communication point by a step (s). A step that fails leaves the instance at the point.
    ///
    /// # Errors
    /// Out of order; a point that is not the time that was reached, a step that is not above 0 or leads beyond the stop time; a run
    /// that an event has ended; and what the integration says.
    pub fn step(&mut self, point: f64, step: f64) -> Result<Stepped, FmuError> {
        self.order(&[Phase::Step], "in step mode")?;
        let stop = self.now.stop;
        let Some(simulator) = &mut self.now.simulator else {
            return Err(FmuError::Scene("there is no scene".to_owned()));
        };
        let now = simulator.snapshot().time;
        if !(step > 0.0 && step.is_finite()) {
            return Err(FmuError::Time(format!("the step is {step} s, allowed: a finite number > 0")));
        }
        if !((point - now).abs() <= SAME_POINT * step) {
            return Err(FmuError::Time(format!(
                "the communication point is {point} s, the time that was reached is {now} s"
            )));
        }
        let until = point + step;
        if !(until > now && until.is_finite()) {
            return Err(FmuError::Time(format!("a step of {step} s from {now} s leads nowhere: it is below rounding")));
        }
        if let Some(stop) = stop.filter(|stop| until - stop > SAME_POINT * step) {
            return Err(FmuError::Time(format!("the step leads to {until} s, the stop time is {stop} s")));
        }
        if let Some(event) = &simulator.snapshot().stopped_by {
            return Err(FmuError::Time(format!("the event `{event}` has ended the run at {now} s")));
        }
        let before = simulator.events().len();
        simulator.advance(until, &|| true)?;
        let events = simulator.events()[before..].iter().map(|event| (event.time, event.to_string())).collect();
        Ok(Stepped { time: simulator.snapshot().time, stopped_by: simulator.snapshot().stopped_by.clone(), events })
    }

    /// How outputs answer at once to inputs that move along `seed`, at this place and time: `∂y/∂u · seed`. Hinge coordinates and
    /// velocities are states, which do not.
    ///
    /// # Errors
    /// Outside step mode; if an unknown is no output or a known no input; if a variation is not known.
    pub fn directional_derivative(&self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> Result<Vec<f64>, FmuError> {
        self.order(&[Phase::Step], "in step mode")?;
        if seed.len() != knowns.len() {
            return Err(FmuError::Count { given: seed.len(), wanted: knowns.len() });
        }
        let Some(simulator) = &self.now.simulator else { return Err(FmuError::Scene("there is no scene".to_owned())) };
        let mut by = vec![0.0; simulator.model().inputs.len()];
        for (reference, value) in knowns.iter().zip(seed) {
            let variable = self.variables.get(*reference)?;
            let Role::Input(place) = variable.role else {
                return Err(FmuError::Derivative(format!(
                    "`{}` is no input: derivatives are by inputs",
                    variable.name
                )));
            };
            if !value.is_finite() {
                return Err(FmuError::NotFinite { name: format!("the seed of `{}`", variable.name), value: *value });
            }
            by[place] += value;
        }
        let mut outputs = None;
        let mut answer = Vec::with_capacity(unknowns.len());
        for reference in unknowns {
            let variable = self.variables.get(*reference)?;
            answer.push(match variable.role {
                Role::Position(_) | Role::Velocity(_) => 0.0,
                Role::Output(place) => {
                    if outputs.is_none() {
                        outputs = Some(derivative::of_outputs(simulator, &by)?);
                    }
                    let known = outputs.as_ref().map_or(f64::NAN, |all: &Vec<f64>| all[place]);
                    if !known.is_finite() {
                        return Err(FmuError::Derivative(format!("how `{}` varies is not known", variable.name)));
                    }
                    known
                }
                Role::Time | Role::Input(_) | Role::Parameter => {
                    return Err(FmuError::Derivative(format!("`{}` is no output", variable.name)));
                }
            });
        }
        Ok(answer)
    }

    /// All that its next step follows from.
    pub fn situation(&self) -> &Situation {
        &self.now
    }

    /// Goes back to a situation of this instance, or of another one of the same FMU.
    pub fn restore(&mut self, situation: &Situation) {
        self.now = situation.clone();
    }

    /// A situation as bytes, which another instance of the same FMU can read.
    pub fn to_bytes(&self, situation: &Situation) -> Vec<u8> {
        situation.to_bytes(&self.manifest.token)
    }

    /// The situation of bytes. If a scene was initialized, its equilibrium is found again.
    ///
    /// # Errors
    /// If the bytes are no situation of this FMU.
    pub fn of_bytes(&mut self, bytes: &[u8]) -> Result<Situation, FmuError> {
        let (mut situation, snapshot) = Situation::of_bytes(bytes, &self.manifest.token, self.variables.list.len())?;
        let Some(snapshot) = snapshot else { return Ok(situation) };
        let here = std::mem::replace(&mut self.now, situation.clone());
        let started = self.start();
        self.now = here;
        let mut simulator = started?;
        simulator.restore(snapshot).map_err(|error| FmuError::State(error.to_string()))?;
        situation.simulator = Some(simulator);
        Ok(situation)
    }
}

impl From<crate::dynamics::Fault> for FmuError {
    fn from(fault: crate::dynamics::Fault) -> Self {
        Self::Derivative(fault.to_string())
    }
}
