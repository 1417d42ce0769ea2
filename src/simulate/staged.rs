//! Runs through changes of structure: one run after the other, each of a model of its own.
//!
//! ```text
//! (1)  M⁺ v⁺ + Gᵀ Λ = Jᵀ M v⁻,   G v⁺ = ċ        v⁻ the velocities of the bodies before, J those of the new coordinates
//! (2)  W = v⁺ᵀ M⁺ (v⁺ − v⁻) = T⁺ − T⁻ + T(v⁺ − v⁻)     work of drives that move: their impulses −Λ, times ċ
//! (3)  E⁻ − E⁺ + W                                booked as dissipated, or as work if it is negative
//! ```
//!
//! The bodies and their order stay the same. Where a hinge opens its body becomes free, with pose and velocity as they are: no
//! velocity of a body changes, so that `v⁺` is a copy but for that body. What closes is a row more: (1) is the projection in the
//! metric of the inertia by which a run settles any state on its rows, an impact without rebound that exchanges momentum at once.
//! It never gains energy unless a drive of a moving coordinate does work in it, which is (2), as Gᵀ Λ = M⁺ (v⁻ − v⁺): what is lost is
//! the energy of the velocities that are lost (Carnot). A spring of a hinge that opens keeps its energy: (3) has it among what goes
//! out.
//!
//! A model of another structure is built in the positions of the file, from which drives and gears count. From then on everything in
//! it is of the instant at which its stage comes: where drives are, what closes, which rows are independent.
//!
//! A scene without stages does not come here: [`crate::simulate::entry`] asks once whether there are any.

mod flying;
mod relay;

pub(super) use relay::scene;

use crate::constraint::{assemble_at, open_at};
use crate::contact::pairs::Untouchable;
use crate::dynamics::{Energies, Fault, System};
use crate::model::description::{Description, StageDescription, When};
use crate::model::problem::{in_one_line, number, significant};
use crate::model::structure::Structure;
use crate::model::{Model, Problem, Watched};
use crate::record::{Event, Recorder};
use crate::round_off::{ENERGY, TIME, has_come};
use crate::simulate::asked::Asked;
use crate::simulate::error::RunError;
use crate::simulate::events::{Kind, Occurrence};
use crate::simulate::problem::Equations;
use crate::simulate::run::{Summary, run_one};
use crate::simulate::samples::ledger::Booked;
use crate::simulate::samples::sampler::keep_worst;
use crate::simulate::samples::scene::of_structure;
use crate::simulate::settings::{Resume, Settings, Start};
use crate::simulate::state::State;
use crate::spatial::Pose;
use crate::statics::standing::{Unanswered, overlap};
use crate::suggest;
use nalgebra::{UnitQuaternion, Vector3};
use relay::{Layout, Relay};
use std::collections::BTreeMap;
use std::sync::Arc;

/// What closes may be open by this part of the scene's length, or so many rad: what the search for events leaves, many times over.
const OPEN: f64 = 1e-9;

/// Refuses what stages do not go with.
pub(super) fn refuse(_: &Description, settings: &Settings, has_function: bool) -> Result<(), RunError> {
    if settings.resume.is_some() {
        return Err(RunError::Stages("a run with stages begins at t = 0 and goes to its end"));
    }
    if has_function {
        return Err(RunError::Stages("a function that sets inputs knows the structure at the start alone"));
    }
    Ok(())
}

/// The scene that a stage leaves, with the stages of the file before it; and what is locked in it, and what flies, in words. Each stage comes in
/// the positions of the last one, the first in these or, if there are none, in those of the file; a coordinate whose event a stage waits for is
/// where that is. What flies is held during statics: the rest has an equilibrium without it.
///
/// # Errors
/// What is wrong with the scene on the way there, or that there is no such stage.
pub fn at_stage(
    whole: &Description,
    name: &str,
    position: Option<&[f64]>,
) -> Result<(Description, Vec<String>), String> {
    let Some(last) = whole.stages.iter().position(|stage| stage.name == name) else {
        let near = suggest::closest(name, whole.stages.iter().map(|stage| stage.name.as_str()));
        return Err(format!(
            "there is no stage `{name}`{}",
            near.map_or_else(String::new, |near| format!("; did you mean `{near}`?"))
        ));
    };
    let mut structure = Structure::first(whole);
    // Of bodies whose hinges have opened.
    let mut rates: BTreeMap<usize, [f64; 6]> = BTreeMap::new();
    let listed = |problems: Vec<Problem>| problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    let mut model = Model::build(&structure.describe(whole)).map_err(listed)?;
    let mut at = position.map_or_else(|| model.start_position.clone(), <[f64]>::to_vec);
    let mut locked = Vec::new();
    for stage in 0..=last {
        let velocity = model.start_velocity.clone();
        if stage == 0 {
            structure.frames = Now::new(&model, 0.0, &at, &velocity).frames(whole, &structure);
        }
        let awaited = awaited(whole, &model, stage);
        awaited.iter().for_each(|(index, value)| at[*index] = *value);
        let now = Now::new(&model, 0.0, &at, &velocity);
        let before = structure.clone();
        structure.apply(whole, stage).map_err(|wrong| wrong.why)?;
        now.fill(whole, &before, &mut structure);
        locked.retain(|(body, _): &(usize, String)| structure.locked.contains_key(body));
        for (body, held) in structure.locked.iter().filter(|(body, _)| !before.locked.contains_key(*body)) {
            let values: Vec<String> = held.iter().flatten().map(|value| number(*value)).collect();
            let (body_name, by) = (&whole.bodies[*body].name, &whole.stages[stage].name);
            locked.push((*body, format!("stage `{by}` locks `{body_name}` at {}", values.join(", "))));
        }
        let fresh: Vec<usize> =
            structure.freed.keys().filter(|body| !before.freed.contains_key(body)).copied().collect();
        for body in &fresh {
            let [linear, angular] = &now.velocities[*body];
            rates.insert(*body, relay::free_rates(&now.poses[*body], linear, angular));
        }
        let next = Model::build(&with_rates(structure.describe(whole), &rates)).map_err(listed)?;
        at = carried(&now, &velocity, &next, &fresh).position;
        model = next;
    }
    let mut said: Vec<String> = locked.into_iter().map(|(_, said)| said).collect();
    let flying = flying::bodies(&model, &structure);
    said.extend(flying.iter().map(|body| {
        let name = &whole.bodies[*body].name;
        format!("`{name}` flies: nothing else acts on it, and statics holds it where its hinge opens")
    }));
    let left = move |whole: &Description| {
        let mut scene = with_rates(structure.describe(whole), &rates);
        flying.iter().for_each(|body| scene.bodies[*body].hinge.lock = true);
        scene
    };
    let mut scene = left(whole);
    scene.named = whole.named.then(left);
    Ok((scene, said))
}

/// A scene whose bodies fly at these rates.
fn with_rates(mut scene: Description, rates: &BTreeMap<usize, [f64; 6]>) -> Description {
    rates.iter().for_each(|(body, rates)| scene.bodies[*body].hinge.velocity = rates.to_vec());
    scene
}

/// The position of a hinge that an event watches for which a stage waits: its place among the coordinates, and its value there.
fn awaited(whole: &Description, model: &Model, stage: usize) -> Option<(usize, f64)> {
    let When::Event(name) = &whole.stages[stage].when else { return None };
    let event = model.events.iter().find(|event| event.name == *name)?;
    match event.of {
        Watched::Position(index) => Some((index, event.value)),
        Watched::Point(..) | Watched::Output(_) => None,
    }
}

/// Bodies at an instant, of one structure.
struct Now<'a> {
    model: &'a Arc<Model>,
    position: &'a [f64],
    poses: Vec<Pose>,
    /// Velocities of the root markers and angular velocities, inertial axes.
    velocities: Vec<[Vector3<f64>; 2]>,
}

impl<'a> Now<'a> {
    fn new(model: &'a Arc<Model>, time: f64, position: &'a [f64], velocity: &[f64]) -> Self {
        let mut system = System::new(model);
        let at = system.at(time, position, velocity);
        let mut poses = Vec::new();
        at.poses(&mut poses);
        let links = &at.motion().links;
        let of_body = |body: &crate::model::Body| {
            let link = &links[body.link];
            let arm = link.turn * body.link_from_body.translation.vector;
            [link.velocity + link.angular_velocity.cross(&arm), link.angular_velocity]
        };
        let velocities = model.bodies.iter().map(of_body).collect();
        Self { model, position, poses, velocities }
    }

    fn turn(&self, name: &str) -> UnitQuaternion<f64> {
        let found = self.model.bodies.iter().position(|body| body.name == name);
        found.map_or_else(UnitQuaternion::identity, |body| self.poses[body].rotation)
    }

    /// The turn of a loop's frame in its second body by which both frames coincide here.
    fn frame(&self, whole: &Description, index: usize) -> UnitQuaternion<f64> {
        let closed = &whole.loops[index];
        let [first, second] = [0, 1].map(|end| self.turn(&closed.between[end].body));
        second.inverse() * first * closed.frame
    }

    /// The frames of all loops that are closed and have none of their own.
    fn frames(&self, whole: &Description, structure: &Structure) -> BTreeMap<usize, UnitQuaternion<f64>> {
        let loops = whole.loops.iter().enumerate();
        let closed = loops.filter(|(index, one)| structure.is_closed(*index) && one.second_frame.is_none());
        closed.map(|(index, _)| (index, self.frame(whole, index))).collect()
    }

    /// Fills in where things are that a stage has changed.
    fn fill(&self, whole: &Description, before: &Structure, structure: &mut Structure) {
        for (body, pose) in &mut structure.freed {
            if !before.freed.contains_key(body) {
                *pose = self.poses[*body];
            }
        }
        for (body, held) in &mut structure.locked {
            if !before.locked.contains_key(body) {
                let hinge = &self.model.bodies[*body].hinge;
                *held = Some(self.position[hinge.position..hinge.position + hinge.kind.counts().0].to_vec());
            }
        }
        for (index, _) in whole.loops.iter().enumerate().filter(|(_, one)| one.second_frame.is_none()) {
            if structure.is_closed(index) && !before.is_closed(index) {
                structure.frames.insert(index, self.frame(whole, index));
            }
        }
    }
}

/// The coordinates of a state in the model of another structure, in which `freed` bodies are free.
fn carried(now: &Now<'_>, velocity: &[f64], next: &Model, freed: &[usize]) -> State {
    let mut state = State { position: next.start_position.clone(), velocity: next.start_velocity.clone() };
    let (from, to) = (relay::segments(now.model), relay::segments(next));
    for body in 0..next.bodies.len() {
        if freed.contains(&body) {
            let (pose, [linear, angular]) = (&now.poses[body], &now.velocities[body]);
            let (p, v) = (to[body].position.start, to[body].velocity.start);
            state.position[p..p + 7].copy_from_slice(&relay::free_position(pose));
            state.velocity[v..v + 6].copy_from_slice(&relay::free_rates(pose, linear, angular));
        } else {
            state.position[to[body].position.clone()].copy_from_slice(&now.position[from[body].position.clone()]);
            state.velocity[to[body].velocity.clone()].copy_from_slice(&velocity[from[body].velocity.clone()]);
        }
    }
    state
}

/// A run through all stages.
struct Staged<'a> {
    whole: &'a Arc<Description>,
    structure: Structure,
    model: Arc<Model>,
    state: State,
    time: f64,
    booked: Option<Booked>,
    happened: Vec<Occurrence>,
    /// Outputs at the end of the last run, before whatever changes then; empty before the first.
    outputs: Vec<f64>,
    told: Vec<(String, String, f64)>,
}

impl Staged<'_> {
    /// The stages that have not come, and their numbers.
    fn pending(&self) -> impl Iterator<Item = (usize, &StageDescription)> {
        self.whole.stages.iter().enumerate().filter(|(index, _)| !self.structure.has_come(*index))
    }

    /// The next stage that comes at a time which has not been reached (s), at most `end`.
    fn next(&self, end: f64) -> f64 {
        let times = self.pending().filter_map(|(_, stage)| match stage.when {
            When::Time(time) => Some(time),
            When::Event(_) => None,
        });
        times.fold(end, f64::min)
    }

    /// The stages that come now, `events` being what ended the run so far.
    fn due(&self, events: &[String]) -> Vec<usize> {
        let is_due = |when: &When| match when {
            When::Time(time) => has_come(*time, self.time),
            When::Event(name) => events.contains(name),
        };
        self.pending().filter(|(_, stage)| is_due(&stage.when)).map(|(index, _)| index).collect()
    }

    /// Changes the structure: see (1) and (2). `gap` is what counts as closed, as in [`Settings`].
    fn change(&mut self, stage: usize, gap: f64, recorder: &mut dyn Recorder) -> Result<(), RunError> {
        let (time, name) = (self.time, self.whole.stages[stage].name.clone());
        let stop = |why: String| RunError::Stage { time, name: name.clone(), why };
        let listed = |problems: Vec<Problem>| stop(in_one_line(&problems));
        let fault = |fault| RunError::Sample { time, fault };
        let labels = self.model.outputs.iter().flat_map(|output| output.labels().map(|label| (&output.name, label)));
        for ((output, label), value) in labels.zip(&self.outputs) {
            if self.whole.stages[stage].outputs.contains(output) {
                self.told.push((name.clone(), label, *value));
            }
        }
        let State { position, velocity } = &self.state;
        let mut old = Equations::new(&self.model);
        let energy = old.energies(time, position, velocity);
        let now = Now::new(&self.model, time, position, velocity);
        let before = self.structure.clone();
        self.structure.apply(self.whole, stage).map_err(|wrong| stop(wrong.why))?;
        now.fill(self.whole, &before, &mut self.structure);
        let next = Model::build(&self.structure.describe(self.whole)).map_err(listed)?;
        let fresh = |body: &&usize| !before.freed.contains_key(*body);
        let freed: Vec<usize> = self.structure.freed.keys().filter(fresh).copied().collect();
        let mut state = carried(&now, velocity, &next, &freed);
        let next = next.starting_in(&state.position, &state.velocity);
        let apart = |problems: Vec<Problem>| {
            let why: Vec<String> = problems.iter().map(ToString::to_string).collect();
            stop(format!("{}; let the parts meet before it closes", why.join("; ")))
        };
        meets(&next, time).map_err(stop)?;
        let (next, _) = assemble_at(next, time).map_err(apart)?;
        apart_or_closed(&next, gap, &state.position).map_err(stop)?;
        let (after, work) = exchanged(&next, time, &mut state).map_err(fault)?;
        let lost = energy.kinetic + energy.potential - after.kinetic - after.potential + work;
        let start = energy.kinetic + energy.potential;
        let largest = energy.kinetic.max(start.abs());
        let none = Booked { start, work: 0.0, dissipated: 0.0, drift: 0.0, largest, has_run: false };
        let booked = self.booked.get_or_insert(none);
        booked.work += work;
        *(if lost > 0.0 { &mut booked.dissipated } else { &mut booked.work }) += lost.abs();
        (self.model, self.state) = (next, state);
        let size = energy.size() + after.size() + work.abs();
        let value = if ENERGY.hides(lost, size) { 0.0 } else { lost };
        let happened =
            Occurrence { time, kind: Kind::Stage, name, value, unit: "J".to_owned(), speed: 0.0, between: None };
        recorder.event(&Event { time, name: happened.name.clone(), text: happened.to_string() })?;
        self.happened.push(happened);
        Ok(())
    }
}

/// Loops, drives and gears meet where a model starts, at a time (s).
fn meets(model: &Model, time: f64) -> Result<(), String> {
    let Some(open) = open_at(model, time) else { return Ok(()) };
    let (gap, allowed, unit) = match open.angle {
        Some(angle) => (angle, OPEN, "rad"),
        None => (open.gap, OPEN * model.length_scale(), "m"),
    };
    if gap <= allowed {
        return Ok(());
    }
    Err(format!(
        "{} is open by {}, allowed: {} {unit}; let the parts meet before it closes",
        open.element,
        open.words(),
        significant(allowed, 2)
    ))
}

/// (1): the state on all rows of the new structure; with its energies, and what drives put into the exchange (J), (2).
fn exchanged(model: &Arc<Model>, time: f64, state: &mut State) -> Result<(Energies, f64), Fault> {
    let mut motion = Equations::beginning(model, time, state);
    let before = state.velocity.clone();
    motion.settle(time, &mut state.position, &mut state.velocity)?;
    let after = motion.energies(time, &state.position, &state.velocity);
    if model.drives.iter().all(|drive| drive.motion.at(time).velocity == 0.0) {
        return Ok((after, 0.0));
    }
    let lost: Vec<f64> = state.velocity.iter().zip(&before).map(|(after, before)| after - before).collect();
    let mut kinetic = |velocity: &[f64]| motion.energies(time, &state.position, velocity).kinetic;
    let [old, lost] = [kinetic(&before), kinetic(&lost)];
    let work = after.kinetic - old + lost;
    Ok((after, if ENERGY.hides(work, after.kinetic + old + lost) { 0.0 } else { work }))
}

/// Bodies whose contacts act from now on do not overlap by more than counts as closed.
fn apart_or_closed(model: &Arc<Model>, gap: f64, position: &[f64]) -> Result<(), String> {
    let Some(rule) = model.contacts.first() else { return Ok(()) };
    overlap(model, gap, position).map_err(|why| match why {
        Unanswered::Untouchable(Untouchable::Overlap { between: [one, other], depth, allowed, .. }) => format!(
            "`{one}` and `{other}` overlap by {} m, and {} m count as closed; let them be apart when it comes",
            number(depth),
            significant(allowed, 2)
        ),
        why => format!("contact `{}`: {why}", rule.name),
    })
}

/// A length of time (s) after which `begin` is `end`, to the last digit where there is one.
fn between(begin: f64, end: f64) -> f64 {
    let near = end - begin;
    let candidates = [near, near.next_up(), near.next_down()];
    candidates.into_iter().find(|length| begin + length == end).unwrap_or(near)
}

/// Runs from stage to stage; `first` is the model before the first one.
///
/// # Errors
/// As [`run_one`], and of a stage that cannot come.
pub(super) fn run(
    whole: &Arc<Description>,
    first: &Arc<Model>,
    start: &State,
    asked: Asked<'_, '_>,
) -> Result<Summary, RunError> {
    let Asked { settings, rate, recorder, go_on, search, .. } = asked;
    let layout = Layout::new(whole, first);
    let mut structure = Structure::first(whole);
    // Frames coincide in the positions as they are given, not where the run starts.
    if let Ok(given) = Model::build(&structure.describe(whole)) {
        let now = Now::new(&given, 0.0, &given.start_position, &given.start_velocity);
        structure.frames = now.frames(whole, &structure);
    }
    let mut staged = Staged {
        whole,
        structure,
        model: Arc::clone(first),
        state: start.clone(),
        time: settings.begin(),
        booked: None,
        happened: Vec::new(),
        outputs: Vec::new(),
        told: Vec::new(),
    };
    let mut end = settings.begin() + settings.duration;
    let mut total: Option<Summary> = None;
    let (mut events, mut stopped_by): (Vec<String>, Option<String>) = (Vec::new(), None);
    loop {
        for stage in staged.due(&events) {
            staged.change(stage, settings.gap, recorder)?;
        }
        let until = staged.next(end);
        let after = |done: &Summary| Resume {
            time: staged.time,
            step: None,
            grid: None,
            mode: None,
            method: done.resume.method,
        };
        let resume = total.as_ref().map(after);
        let start = if total.is_some() { Start::Given } else { settings.start };
        let part = Settings { duration: between(staged.time, until), resume, start, ..settings.clone() };
        let mut relay = Relay::new(&layout, &staged.model, recorder);
        let asked = Asked { settings: &part, rate, recorder: &mut relay, go_on: &mut *go_on, search, function: None };
        let done = run_one(&staged.model, &staged.state, asked, staged.booked.as_ref())?;
        let happened = std::mem::take(&mut staged.happened);
        let summary = joined(total, happened, done);
        staged.time = summary.end_time;
        staged.state.clone_from(&summary.state);
        staged.outputs.clone_from(&summary.outputs);
        staged.booked = Some(Booked::of(&summary));
        events = summary.stopped_by.iter().chain(&summary.stopped_with).cloned().collect();
        let ends = |name: &&String| whole.events.iter().any(|event| event.name == **name && event.stops);
        if let Some(name) = events.iter().find(ends) {
            // What comes at this instant comes, and nothing after it.
            (stopped_by, end) = (Some(name.clone()), staged.time);
        }
        let is_over = summary.interrupted || summary.end_time >= TIME.below(end);
        if staged.due(&events).is_empty() && (is_over || !events.is_empty()) || summary.interrupted {
            let pending = staged.pending().map(|(_, stage)| (stage.name.clone(), stage.when.clone())).collect();
            let stopped_by = stopped_by.or(summary.stopped_by);
            return Ok(Summary { told: staged.told, pending, stopped_by, ..summary });
        }
        total = Some(Summary { stopped_by: None, ..summary });
    }
}

impl Booked {
    /// Of a run that has ended.
    fn of(summary: &Summary) -> Self {
        Self {
            start: summary.energy_start,
            work: summary.work,
            dissipated: summary.dissipated,
            drift: summary.energy_drift,
            largest: summary.energy_largest,
            has_run: true,
        }
    }
}

/// The summary of a run and of the one that goes on from it.
fn joined(total: Option<Summary>, happened: Vec<Occurrence>, done: Summary) -> Summary {
    let Some(mut total) = total else {
        let events = happened.into_iter().chain(done.events).collect();
        return Summary { events, ..done };
    };
    total.events.extend(happened);
    total.events.extend(done.events.iter().cloned());
    for method in &done.integrators {
        if total.integrators.last() != Some(method) {
            total.integrators.push(*method);
        }
    }
    total.statistics.add(&done.statistics);
    keep_worst(&mut total.wound, done.wound.iter().cloned());
    total.across.extend(done.across.iter().filter(|name| !total.across.contains(name)).cloned().collect::<Vec<_>>());
    let choice = done.choice.clone().or(total.choice);
    Summary {
        events: total.events,
        integrators: total.integrators,
        statistics: total.statistics,
        energy_start: total.energy_start,
        constraint_error: total.constraint_error.max(done.constraint_error),
        impacts: total.impacts + done.impacts,
        held_back: total.held_back + done.held_back,
        capture_steps: total.capture_steps + done.capture_steps,
        samples: total.samples + done.samples,
        wound: total.wound,
        across: total.across,
        wall: total.wall + done.wall,
        choice,
        ..done
    }
}
