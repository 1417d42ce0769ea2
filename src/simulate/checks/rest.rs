//! The rest proof: a run from the equilibrium that must stay where it is.
//!
//! At a stable or neutral equilibrium nothing may move: the largest displacement of any hinge is compared with
//! [`TOLERANCE`]. With drives at a constant rate an equilibrium is a steady motion, and displacements are those from it;
//! where a drive begins to move otherwise, the proof ends. An explicit method lets round-off grow to the size of its own tolerance before it takes a smaller
//! step, so adaptive methods run with a tolerance well below that, whatever the scene asks for in other runs. An unstable one would stay too, as long as round-off leaves it alone; it is pushed by 10⁻⁶ along
//! the direction that runs away fastest, and the growth that is observed is compared with the eigenvalue that predicts it.

use crate::force::Act;
use crate::model::Model;
use crate::record::Recorder;
use crate::simulate::control::check_steady;
use crate::simulate::entry::run;
use crate::simulate::error::RunError;
use crate::simulate::settings::Settings;
use crate::simulate::state::State;
use crate::statics::{Equilibrium, StabilityVerdict, outputs};
use std::sync::Arc;

/// A hinge that moved further than this did not rest (m or rad).
pub const TOLERANCE: f64 = 1e-9;
/// Largest tolerance of adaptive methods in a proof: what they let pass must not be taken for motion.
const STEP_TOLERANCE: f64 = 1e-2 * TOLERANCE;
/// Size of the push at an unstable equilibrium, of the coordinate that moves most (m or rad).
const PUSH: f64 = 1e-6;
/// Growth is measured between these displacements: late enough for other modes to be gone, early enough to be linear.
const GROWTH_WINDOW: (f64, f64) = (1e-5, 1e-3);

/// The largest of something, and the hinge it was seen in.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Largest {
    /// Body whose hinge it is.
    pub hinge: String,
    /// Value (m, rad or per second).
    pub value: f64,
}

/// Growth away from an unstable equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct Growth {
    /// Body whose hinge leaves first.
    pub hinge: String,
    /// From the eigenvalue (1/s).
    pub predicted: f64,
    /// From the run (1/s); `None` if it did not leave in time.
    pub observed: Option<f64>,
}

/// The answer.
#[derive(Debug, Clone)]
pub struct Rest {
    /// Whether it stayed.
    pub rested: bool,
    /// Simulated time (s).
    pub duration: f64,
    /// Largest displacement of any hinge, from its steady motion where there is one.
    pub displacement: Largest,
    /// Largest hinge speed beside that motion.
    pub speed: Largest,
    /// Present at an unstable equilibrium.
    pub growth: Option<Growth>,
    /// What changed before the time was over.
    pub disturbed: Option<Disturbance>,
    /// Whether it was stopped from outside.
    pub interrupted: bool,
}

/// Proves that the model stays at `equilibrium`, or shows how it leaves.
///
/// # Errors
/// If the run cannot be made.
pub fn rest(
    model: &Arc<Model>,
    equilibrium: &Equilibrium,
    settings: &Settings,
    rate: f64,
    recorder: &mut dyn Recorder,
    go_on: &mut dyn FnMut(f64) -> bool,
) -> Result<Rest, RunError> {
    let model = &Model::before_stages(model);
    // What controllers hold does not run away, whatever the verdict on the scene alone is.
    let pushed = if model.controllers.is_empty() { Push::of(model, equilibrium) } else { None };
    if !model.controllers.is_empty() {
        let outputs = outputs(model, equilibrium).map_err(|fault| RunError::Sample { time: 0.0, fault })?;
        check_steady(model, &outputs)?;
    }
    let start = match &pushed {
        Some(push) => push.start(model, equilibrium),
        None => State { position: equilibrium.position.clone(), velocity: equilibrium.velocity.clone() },
    };
    let disturbed = disturbance(model, settings.duration);
    // A drive that moves from the start on is part of what is shown.
    let undisturbed = disturbed.as_ref().map_or(settings.duration, |by| by.time);
    let undisturbed = if undisturbed > 0.0 { undisturbed } else { settings.duration };
    let duration = pushed.as_ref().map_or(undisturbed, |push| push.duration().min(undisturbed));
    let settings = Settings {
        duration,
        tolerance: settings.tolerance.min(STEP_TOLERANCE),
        absolute_tolerance: settings.absolute_tolerance.min(STEP_TOLERANCE),
        ..settings.clone()
    };
    let mut watch = Watch::new(model, equilibrium);
    let summary = run(model, &settings, rate, &start, recorder, &mut |time, state| {
        watch.see(time, state);
        go_on(time)
    })?;
    let growth = pushed.map(|push| Growth {
        hinge: push.hinge,
        predicted: push.rate,
        observed: watch
            .window
            .map(|(first, last)| (last.1 / first.1).ln() / (last.0 - first.0))
            .filter(|r| r.is_finite()),
    });
    let rested = growth.is_none() && watch.displacement.value <= TOLERANCE && !summary.interrupted;
    Ok(Rest {
        rested,
        duration: summary.end_time,
        displacement: watch.displacement,
        speed: watch.speed,
        growth,
        disturbed,
        interrupted: summary.interrupted,
    })
}

/// What does not go on as it starts.
#[derive(Debug, Clone, PartialEq)]
pub struct Disturbance {
    /// `drive` or `load`.
    pub by: &'static str,
    /// Its name.
    pub name: String,
    /// When (s).
    pub time: f64,
}

/// The first drive or load that does not go on as it starts.
fn disturbance(model: &Model, duration: f64) -> Option<Disturbance> {
    let by = |by: &'static str, name: &String, time: f64| Disturbance { by, name: name.clone(), time };
    let drives = model.drives.iter().map(|drive| by("drive", &drive.name, drive.motion.steady_until(duration)));
    let loads = model.forces.iter().map(|force| by("load", &force.name, force.law.steady_until()));
    drives.chain(loads).filter(|one| one.time < duration).min_by(|a, b| a.time.total_cmp(&b.time))
}

/// A push along the direction that runs away fastest.
struct Push {
    hinge: String,
    rate: f64,
    /// Displacement of every velocity coordinate.
    shape: Vec<f64>,
}

impl Push {
    fn of(model: &Model, equilibrium: &Equilibrium) -> Option<Self> {
        let stability = equilibrium.stability.as_ref().filter(|s| s.verdict == StabilityVerdict::Unstable)?;
        let mode = stability.modes.iter().max_by(|a, b| a.growth_rate.total_cmp(&b.growth_rate))?;
        let mut shape = vec![0.0; model.velocity_count()];
        let free = (0..shape.len()).filter(|i| !model.coordinates[*i].lock);
        for (i, part) in free.zip(&mode.shape) {
            shape[i] = PUSH * part;
        }
        // What rolls on contacts has no shares: the body that moves most.
        let most = (0..shape.len()).max_by(|a, b| shape[*a].abs().total_cmp(&shape[*b].abs()));
        let moves = || most.map_or(String::new(), |i| model.bodies[model.coordinates[i].body].name.clone());
        let hinge = mode.shares.first().map_or_else(moves, |(name, _)| name.clone());
        (mode.growth_rate > 0.0).then_some(Self { hinge, rate: mode.growth_rate, shape })
    }

    /// On the growing motion itself: displacement and, rate times it, velocity.
    fn start(&self, model: &Model, equilibrium: &Equilibrium) -> State {
        let mut position = equilibrium.position.clone();
        crate::dynamics::System::displace(model, &mut position, &self.shape);
        let velocity = equilibrium.velocity.iter().zip(&self.shape).map(|(v, x)| v + self.rate * x).collect();
        State { position, velocity }
    }

    /// Time to grow through the window, with as much again to spare.
    fn duration(&self) -> f64 {
        2.0 * (GROWTH_WINDOW.1 / PUSH).ln() / self.rate
    }
}

struct Watch<'a> {
    model: &'a Model,
    equilibrium: &'a Equilibrium,
    /// Where the steady motion is now.
    expected: Vec<f64>,
    /// How far it went.
    way: Vec<f64>,
    displacement: Largest,
    speed: Largest,
    /// First and last (time, displacement) within the growth window.
    window: Option<((f64, f64), (f64, f64))>,
}

impl<'a> Watch<'a> {
    fn new(model: &'a Model, equilibrium: &'a Equilibrium) -> Self {
        let expected = equilibrium.position.clone();
        let way = vec![0.0; model.velocity_count()];
        let (displacement, speed) = (Largest::default(), Largest::default());
        Self { model, equilibrium, expected, way, displacement, speed, window: None }
    }

    fn see(&mut self, time: f64, state: &State) {
        let steady = &self.equilibrium.velocity;
        if steady.iter().any(|v| *v != 0.0) {
            self.way.iter_mut().zip(steady).for_each(|(way, v)| *way = v * time);
            self.expected.copy_from_slice(&self.equilibrium.position);
            crate::motion::displace(self.model, &mut self.expected, &self.way);
        }
        let mut now = 0.0_f64;
        for link in self.model.links.iter().skip(1) {
            let moved = crate::motion::distance(link, &self.expected, &state.position);
            let velocities = link.velocity..link.velocity + link.joint.counts().1;
            let fast = velocities.map(|i| (state.velocity[i] - steady[i]).powi(2)).sum::<f64>().sqrt();
            now = now.max(moved);
            for (largest, value) in [(&mut self.displacement, moved), (&mut self.speed, fast)] {
                if value > largest.value || largest.hinge.is_empty() {
                    *largest = Largest { hinge: self.model.bodies[link.body].name.clone(), value };
                }
            }
        }
        if now >= GROWTH_WINDOW.0 && now <= GROWTH_WINDOW.1 {
            let first = self.window.map_or((time, now), |(first, _)| first);
            self.window = Some((first, (time, now)));
        }
    }
}
