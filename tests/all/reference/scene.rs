//! Scenes from scenario text, put to rest or run through a list of times.

use super::survey;
use nalgebra::{Isometry3, Vector3};
use std::sync::Arc;
use stillpoint::constraint::assemble;
use stillpoint::dynamics::System;
use stillpoint::model::Model;
use stillpoint::record::{Memory, Opening};
use stillpoint::scenario::{self, Scenario};
use stillpoint::simulate::{self, Settings, State, Summary};
use stillpoint::statics::{self, Equilibrium, Stability};

/// The head of a scenario that starts as given: gravity and how it is run.
pub(super) fn head(gravity: [f64; 3], integrator: &str, tolerance: f64) -> String {
    let (integrator, tolerance) = survey::asked(integrator, tolerance);
    format!(
        "gravity = {gravity:?}\n[simulate]\nstart = \"given\"\nintegrator = \"{integrator}\"\ntolerance = {tolerance:e}\n"
    )
}

/// A scenario, read and compiled.
pub(super) struct Scene {
    scenario: Scenario,
    pub(super) model: Arc<Model>,
}

impl Scene {
    pub(super) fn read(text: &str) -> Self {
        let scenario = scenario::parse("reference.toml", text, &[])
            .unwrap_or_else(|problems| panic!("{}\n{text}", problems.render(false)));
        let model = Model::build(&scenario.description).unwrap_or_else(|problems| panic!("{problems:?}"));
        let (model, _) = assemble(model).unwrap_or_else(|problems| panic!("{problems:?}"));
        Self { scenario, model }
    }

    /// The equilibrium that is found from the guess; not necessarily one.
    pub(super) fn search(&self) -> Equilibrium {
        statics::equilibrium(&self.model, &self.scenario.statics, &self.model.start_position)
            .unwrap_or_else(|fault| panic!("{fault}"))
    }

    /// Kind and modes of the equilibrium that is found from the guess, stable or not.
    pub(super) fn rest_or_not(&self) -> Option<Stability> {
        self.search().stability
    }

    /// The equilibrium that was asked for.
    #[track_caller]
    pub(super) fn rest(&self) -> Equilibrium {
        let found = self.search();
        assert!(found.converged, "{:?} {:e} {:?}", found.notes, found.relative_residual, found.stability);
        found
    }

    /// Hinge accelerations at the start.
    pub(super) fn accelerations(&self) -> Vec<f64> {
        let mut a = vec![0.0; self.model.velocity_count()];
        System::new(&self.model)
            .at(0.0, &self.model.start_position, &self.model.start_velocity)
            .accelerations(&mut a)
            .unwrap_or_else(|fault| panic!("{fault}"));
        a
    }

    /// A run from the start.
    pub(super) fn run(&self) -> Run<'_> {
        let state = State { position: self.model.start_position.clone(), velocity: self.model.start_velocity.clone() };
        Run { scene: self, time: 0.0, state, poses: Vec::new(), drift: 0.0, energy: f64::NAN, steps: 0, gap: 0.0 }
    }

    fn range(&self, body: &str, velocities: bool) -> std::ops::Range<usize> {
        let index = self.model.body(body).unwrap_or_else(|| panic!("no body {body}"));
        let hinge = &self.model.bodies[index].hinge;
        let (positions, speeds) = hinge.kind.counts();
        match velocities {
            false => hinge.position..hinge.position + positions,
            true => hinge.velocity..hinge.velocity + speeds,
        }
    }

    /// The coordinates of a body's hinge out of all.
    pub(super) fn position<'a>(&self, body: &str, all: &'a [f64]) -> &'a [f64] {
        &all[self.range(body, false)]
    }

    /// The velocities or accelerations of a body's hinge out of all.
    pub(super) fn velocity<'a>(&self, body: &str, all: &'a [f64]) -> &'a [f64] {
        &all[self.range(body, true)]
    }
}

/// Frequencies of an equilibrium's modes in rad/s, ascending; growth rates of those that run away are left out.
pub(super) fn frequencies(found: &Equilibrium) -> Vec<f64> {
    let modes = &found.stability.as_ref().expect("an equilibrium").modes;
    modes.iter().map(|mode| mode.frequency_hz * std::f64::consts::TAU).filter(|w| *w > 0.0).collect()
}

/// Growth rates of the modes that run away (1/s), largest first.
pub(super) fn growth_rates(found: &Equilibrium) -> Vec<f64> {
    let modes = &found.stability.as_ref().expect("an equilibrium").modes;
    modes.iter().map(|mode| mode.growth_rate).filter(|rate| *rate > 0.0).collect()
}

/// A run that stops at times of interest.
pub(super) struct Run<'a> {
    scene: &'a Scene,
    time: f64,
    state: State,
    poses: Vec<Isometry3<f64>>,
    /// Largest imbalance of energy so far (J).
    pub(super) drift: f64,
    energy: f64,
    /// Widest gap of loops so far (m).
    pub(super) gap: f64,
    /// Accepted steps so far.
    pub(super) steps: usize,
}

impl Run<'_> {
    /// Goes on to `time`, with the settings of the scenario.
    #[track_caller]
    pub(super) fn until(&mut self, time: f64) {
        let duration = time - self.time;
        let settings = Settings { duration, ..self.scene.scenario.simulate.clone() };
        let model = &self.scene.model;
        let still = simulate::scene(model);
        let opening = Opening { scene: &still, scenario: &self.scene.scenario.text, statics: None };
        let mut memory = Memory::new(&opening);
        let rate = 1.0 / duration;
        let summary: Summary = simulate::run(model, &settings, rate, &self.state, &mut memory, &mut |_, _| true)
            .unwrap_or_else(|error| panic!("after t = {}: {error}", self.time));
        self.time = time;
        self.state = summary.state;
        self.poses = summary.poses;
        self.drift = self.drift.max(summary.energy_drift);
        self.energy = summary.energy_end;
        self.gap = self.gap.max(summary.constraint_error);
        self.steps += summary.statistics.steps as usize;
        survey::ran(&summary.statistics, summary.wall);
    }

    pub(super) fn time(&self) -> f64 {
        self.time
    }

    /// Kinetic plus potential energy (J).
    pub(super) fn energy(&self) -> f64 {
        self.energy
    }

    /// The only coordinate of a body's hinge.
    pub(super) fn coordinate(&self, body: &str) -> f64 {
        self.positions(body)[0]
    }

    /// The only velocity of a body's hinge.
    pub(super) fn speed(&self, body: &str) -> f64 {
        self.velocities(body)[0]
    }

    pub(super) fn positions(&self, body: &str) -> &[f64] {
        self.scene.position(body, &self.state.position)
    }

    pub(super) fn velocities(&self, body: &str) -> &[f64] {
        self.scene.velocity(body, &self.state.velocity)
    }

    /// Where a body's root marker stands.
    pub(super) fn pose(&self, body: &str) -> &Isometry3<f64> {
        let index = self.scene.model.body(body).unwrap_or_else(|| panic!("no body {body}"));
        &self.poses[index]
    }

    /// A point of a body, given in its axes.
    pub(super) fn point(&self, body: &str, at: [f64; 3]) -> Vector3<f64> {
        let pose = self.pose(body);
        pose.translation.vector + pose.rotation * Vector3::from(at)
    }
}
