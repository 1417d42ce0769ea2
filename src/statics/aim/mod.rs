//! Aimed equilibria: what outputs shall be is given, the numbers of the scene that make them so are found.
//!
//! The outputs `y` of the equilibrium are functions of the unknown numbers `u`. Newton's method on
//!
//! ```text
//! y(u) = ŷ,      (dy/du) Δu = ŷ − y(u),      least |S⁻¹ Δu|                                   (1)
//! ```
//!
//! with the sensitivities of the equilibrium, and an equilibrium searched for from the last one at every step. As long as steps bring the
//! outputs much nearer, the next one takes the sensitivities of the last, changed by what it has taught (Broyden's rank-one update,
//! 1965; Nocedal & Wright, *Numerical Optimization*, 11.1):
//!
//! ```text
//! J⁺ = J + (y(u + s) − y(u) − J s) sᵀ / sᵀs                         (2)
//! ```
//!
//! Steps are no longer than
//! a radius that follows how well they keep what (1) promises, and keep lengths, masses and stiffnesses within what they can be (see
//! `bounded`). `S` and the units of the outputs are the scene's own, as in `inverse`. The answer is the
//! equilibrium of a scene that is built with the numbers, and proved as every other; how far its outputs are from the aim is told.

mod bounded;
mod words;

use super::certify::equilibrium::Equilibrium;
use super::certify::stability::StabilityVerdict;
use super::inverse::{InverseAnswer, unit};
use super::outputs::outputs;
use super::search::{Observers, equilibrium_observed};
use super::sensitivity::sensitivities;
use super::settings::{Aim, Settings, Sought, Want};
use crate::constraint;
use crate::dynamics::Fault;
use crate::model::description::Description;
use crate::model::parameter::{Field, Quantity};
use crate::model::problem::number;
use crate::model::structure::Structure;
use crate::model::{Model, Parameter, Problem};
use crate::round_off::OUTPUT;
use faer::Mat;
use std::sync::Arc;
use std::time::Instant;

/// Outputs this near to the aim, in their units, are there: equilibria are known to some 1e-12 of the scene's size, outputs of them
/// to a hundred times that where the stiffness is bad.
const AIMED: f64 = 1e-9;
/// Singular values below this part of the largest one: sensitivities are proved to 1e-7.
const RANK: f64 = 1e-7;
/// Steps; short ones of strongly bent outputs count as others.
const MOST_STEPS: usize = 60;
/// Trials of a step, each within a shorter radius.
const MOST_TRIALS: usize = 12;
/// Part of the decrease that (1) promises which a step has to give; below and above these the radius shrinks and grows by a factor.
const DECREASE: f64 = 1e-4;
const POOR: f64 = 0.25;
const GOOD: f64 = 0.75;
const FACTOR: f64 = 4.0;
/// The first radius: every number by as much as its unit.
const FIRST_RADIUS: f64 = 1.0;
/// A step that leaves less than this part of a miss is followed by one with sensitivities by (2).
const TEACHES: f64 = 0.1;
/// Outputs that change by so many times what (1) says have jumped to another equilibrium.
const JUMP: f64 = 10.0;
/// Part of the way to its bound that a number goes in one step: a body without mass has no motion.
const TO_BOUND: f64 = 0.9;

/// A scene of the way, and where it stands.
struct Stand {
    description: Description,
    /// As the search sees it: without what happens later in a run.
    scene: Description,
    model: Arc<Model>,
    found: Equilibrium,
    /// What its outputs miss the aim by, in their units.
    miss: Vec<f64>,
}

impl Stand {
    fn size(&self) -> f64 {
        self.miss.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    fn is_within(&self, part: f64) -> bool {
        self.miss.iter().all(|x| x.abs() <= part)
    }
}

struct Search<'a> {
    sought: Sought<'a>,
    /// The unknown numbers in the scenes of the search.
    unknown: Vec<Parameter>,
    /// Whether these are the first structure of a scene with stages, which costs many times less to build than all of them.
    of_first: bool,
    settings: &'a Settings,
    /// Places of the aims among the numbers of the outputs.
    places: Vec<usize>,
    /// Of the outputs.
    units: Vec<f64>,
    /// `S`.
    scales: Vec<f64>,
    go_on: &'a dyn Fn() -> bool,
}

/// The equilibrium whose outputs are what is aimed at, by the values of the unknown numbers that make it so. The time limit of the
/// settings is that of all searches together.
///
/// # Errors
/// If the system cannot be evaluated at the start.
pub(super) fn aim(
    description: Description,
    model: Arc<Model>,
    sought: Sought<'_>,
    settings: &Settings,
    go_on: &dyn Fn() -> bool,
) -> Result<InverseAnswer, Fault> {
    let (before, limit) = (Instant::now(), settings.time_limit);
    let go_on = &|| before.elapsed().as_secs_f64() < limit && go_on();
    let labels: Vec<(String, String)> =
        model.outputs.iter().flat_map(|output| output.labels().zip(output.units.clone())).collect();
    let place = |aim: &Aim| labels.iter().position(|(label, _)| *label == aim.output);
    let first = search(&model, settings, go_on)?;
    let Some(places) = sought.aim.iter().map(place).collect::<Option<Vec<_>>>() else {
        let known = labels.iter().map(|(label, _)| format!("`{label}`")).collect::<Vec<_>>().join(", ");
        let note = format!("an output that is aimed at is none of the scene: it has {known}");
        return Ok(missed(description, model, first, sought, note));
    };
    let largest = first.reactions.iter().map(|wrench| wrench.force.norm()).fold(0.0, f64::max);
    let of_output = |(place, aim): (&usize, &Aim)| {
        let quantity = Quantity::of_unit(&labels[*place].1).unwrap_or(Quantity::Plain);
        unit(quantity, aim.value, &model, largest).max(aim.value.abs())
    };
    let units = places.iter().zip(sought.aim).map(of_output).collect();
    let scales = sought.unknown.iter().map(|one| {
        let value = one.value(&description);
        unit(one.quantity, value, &model, largest).max(value.abs())
    });
    // Named numbers make the whole scene anew.
    let of_first = !description.stages.is_empty() && sought.unknown.iter().all(|one| one.field != Field::Named);
    let scene = of(&description, of_first);
    let found = |one: &Parameter| Parameter::find(&scene, &one.address).ok().and_then(|found| found.into_iter().next());
    let Some(unknown) = sought.unknown.iter().map(found).collect::<Option<Vec<_>>>() else {
        let note = "a number is unknown of what is not there before the first stage".to_owned();
        return Ok(missed(description, model, first, sought, note));
    };
    let search = Search { sought, unknown, of_first, settings, places, units, scales: scales.collect(), go_on };
    let Some(stand) = search.stand(description.clone(), scene, Arc::clone(&model), first.clone()) else {
        let note = "there is no equilibrium to begin with, whose outputs could be brought to the aim".to_owned();
        return Ok(missed(description, model, first, sought, note));
    };
    let InverseAnswer { description, model, mut found } = search.go(stand);
    if !of_first {
        return Ok(InverseAnswer { description, model, found });
    }
    match built(&description, &found.position) {
        Ok(model) => Ok(InverseAnswer { description, model, found }),
        Err(problems) => {
            let problems: Vec<String> = problems.iter().map(ToString::to_string).collect();
            found.converged = false;
            found.notes.insert(0, format!("with these numbers the stages cannot be: {}", problems.join("; ")));
            Ok(InverseAnswer { description, model, found })
        }
    }
}

/// A scene as a search sees it.
fn of(whole: &Description, of_first: bool) -> Description {
    if of_first { Structure::first(whole).describe(whole) } else { whole.clone() }
}

/// The model of a description, put together beside a pose.
fn built(description: &Description, pose: &[f64]) -> Result<Arc<Model>, Vec<Problem>> {
    let model = Model::build(description)?;
    let near = beginning(&model, pose);
    Ok(constraint::assemble(model.starting_at(&near))?.0)
}

fn search(model: &Arc<Model>, settings: &Settings, go_on: &dyn Fn() -> bool) -> Result<Equilibrium, Fault> {
    let observers = Observers { go_on: Some(go_on), ..Observers::default() };
    equilibrium_observed(model, settings, &model.start_position, observers)
}

impl Search<'_> {
    /// What is missed at an equilibrium; `None` if it is none.
    fn stand(
        &self,
        description: Description,
        scene: Description,
        model: Arc<Model>,
        found: Equilibrium,
    ) -> Option<Stand> {
        if !found.converged {
            return None;
        }
        let values = outputs(&model, &found).ok()?;
        let miss = |((place, aim), unit): ((&usize, &Aim), &f64)| (values[*place] - aim.value) / unit;
        let miss = self.places.iter().zip(self.sought.aim).zip(&self.units).map(miss).collect();
        Some(Stand { description, scene, model, found, miss })
    }

    /// Newton steps from an equilibrium to the end.
    fn go(&self, mut now: Stand) -> InverseAnswer {
        let (mut trouble, radius) = (None, FIRST_RADIUS * (self.scales.len() as f64).sqrt());
        let mut trust = Trust { radius, ends: false };
        let mut taught: Option<Mat<f64>> = None;
        for _ in 0..MOST_STEPS {
            if now.is_within(OUTPUT.of(1.0)) || !(self.go_on)() {
                break;
            }
            let was_taught = taught.is_some();
            let slopes = taught.take().map_or_else(|| self.slopes(&now), Ok);
            match slopes.and_then(|slopes| self.step(&now, slopes, &mut trust)) {
                Ok((next, slopes)) => {
                    taught = (next.size() < TEACHES * now.size()).then_some(slopes);
                    now = next;
                }
                // With its own sensitivities, then.
                Err(_) if was_taught && !now.is_within(AIMED) => {}
                Err(why) => {
                    trouble = Some(why);
                    break;
                }
            }
        }
        let arrived = now.is_within(AIMED);
        let Stand { description, model, mut found, .. } = now;
        found.aimed = self.told(&model, &found);
        found.unknowns = values(&description, self.sought.unknown);
        if !arrived {
            let why = match (trouble, (self.go_on)()) {
                (Some(why), true) => why,
                (None, true) => format!("{MOST_STEPS} steps did not bring it there"),
                (_, false) => "interrupted, or the time limit came first".to_owned(),
            };
            found
                .notes
                .insert(0, format!("the aim is missed: {}; {why}", words::missed(&found.aimed, self.sought.aim)));
            found.converged = false;
        }
        InverseAnswer { description, model, found }
    }

    /// The values of what is aimed at.
    fn told(&self, model: &Arc<Model>, found: &Equilibrium) -> Vec<(String, f64)> {
        let values = outputs(model, found).unwrap_or_default();
        let value = |place: &usize| values.get(*place).copied().unwrap_or(f64::NAN);
        self.sought.aim.iter().zip(&self.places).map(|(aim, place)| (aim.output.clone(), value(place))).collect()
    }

    /// `dy/du`, over the units of both; or why there is none.
    fn slopes(&self, now: &Stand) -> Result<Mat<f64>, String> {
        let Sought { unknown, aim } = self.sought;
        let names: Vec<String> = aim.iter().map(|one| one.output.clone()).collect();
        let numbers = Some(self.unknown.clone());
        let table = sensitivities(&now.scene, &now.model, &now.found, &names, numbers, self.go_on)
            .map_err(|why| why.to_string())?;
        let mut slopes = Mat::<f64>::zeros(aim.len(), unknown.len());
        for (i, (row, unit)) in table.derivatives.iter().zip(&self.units).enumerate() {
            for (j, (slope, scale)) in row.iter().zip(&self.scales).enumerate() {
                let Some(slope) = slope else { return Err(table.notes.join("; ")) };
                slopes[(i, j)] = slope * scale / unit;
            }
        }
        let useless = |i: &usize| (0..unknown.len()).all(|j| slopes[(*i, j)] == 0.0);
        if let Some(row) = (0..aim.len()).find(useless) {
            let held = words::held(&now.model, &now.found, unknown);
            return Err(format!("no unknown moves `{}`{held}", aim[row].output));
        }
        Ok(slopes)
    }

    /// How far each number may go down, over its unit: what cannot be negative stays what it is or above zero, unless the file has it
    /// below.
    fn low(&self, now: &Stand) -> Vec<f64> {
        let of = |(one, scale): (&Parameter, &f64)| {
            let value = one.value(&now.description);
            let bounded =
                value >= 0.0 && matches!(one.field, Field::Mass | Field::Length | Field::Stiffness | Field::Young);
            if bounded { -TO_BOUND * value / scale } else { f64::NEG_INFINITY }
        };
        self.sought.unknown.iter().zip(&self.scales).map(of).collect()
    }

    /// The step within the radius, which shrinks until it brings the outputs nearer, and the slopes with (2); or why there is none.
    fn step(&self, now: &Stand, mut slopes: Mat<f64>, trust: &mut Trust) -> Result<(Stand, Mat<f64>), String> {
        let (mut why, low) = (String::new(), self.low(now));
        let trials = if now.is_within(AIMED) { 1 } else { MOST_TRIALS };
        for trial in 0..trials {
            let Some(step) = bounded::step(&slopes, &now.miss, &low, trust.radius, RANK) else {
                return Err("its sensitivities are not finite".to_owned());
            };
            let length = step.s.iter().map(|x| x * x).sum::<f64>().sqrt();
            let promised = now.size() - step.left;
            let held = words::at_bound(&step.held, self.sought.unknown, &now.description);
            if !(promised > OUTPUT.of(now.size())) {
                return Err(format!("no change of the unknown numbers brings it nearer{held}"));
            }
            let change: Vec<f64> = step.s.iter().zip(&self.scales).map(|(s, scale)| s * scale).collect();
            match self.moved(now, &change) {
                Ok(next) => {
                    let part = (now.size() - next.size()) / promised;
                    if part > GOOD && length > 0.5 * trust.radius {
                        trust.radius *= FACTOR;
                    } else if !(part > POOR) {
                        trust.radius = length / FACTOR;
                    }
                    if part >= DECREASE {
                        trust.ends &= trial > 0;
                        learn(&mut slopes, &step.s, &now.miss, &next.miss);
                        return Ok((next, slopes));
                    }
                    let moved = next.miss.iter().zip(&now.miss).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
                    trust.ends |= moved > JUMP * step.moves;
                    why = format!("no step of the unknown numbers brings it nearer{held}");
                }
                Err(refused) => {
                    trust.radius = length / FACTOR;
                    why = refused.why;
                    trust.ends |= refused.ends;
                }
            }
            if !(self.go_on)() {
                break;
            }
        }
        let kind = if self.settings.want == Want::Stable { "stable " } else { "" };
        let words = format!("; the {kind}equilibria end on the way there: beyond is another one, or none");
        Err(if trust.ends { why + &words } else { why })
    }

    /// The equilibrium with a change made.
    fn moved(&self, now: &Stand, change: &[f64]) -> Result<Stand, Refused> {
        let refused = |why: String| Refused { why, ends: false };
        let mut description = now.description.clone();
        for (one, change) in self.sought.unknown.iter().zip(change) {
            let value = one.value(&description) + change;
            let place = |why| format!("`{}` = {} {}: {why}", one.address, number(value), one.quantity.unit());
            one.set(&mut description, value).map_err(place).map_err(refused)?;
        }
        let told = |problems: Vec<Problem>| {
            let values = values(&description, self.sought.unknown);
            let values = values.iter().map(|(name, value)| format!("`{name}` = {}", number(*value)));
            let problems: Vec<String> = problems.iter().map(ToString::to_string).collect();
            refused(format!("{}: {}", values.collect::<Vec<_>>().join(", "), problems.join("; ")))
        };
        let scene = of(&description, self.of_first);
        let model = built(&scene, &now.found.position).map_err(&told)?;
        let found = search(&model, self.settings, self.go_on).map_err(|fault| refused(fault.to_string()))?;
        let notes = found.notes.join("; ");
        let is_unstable =
            |found: &Equilibrium| found.stability.as_ref().is_some_and(|of| of.verdict == StabilityVerdict::Unstable);
        let ends = found.balanced && is_unstable(&found);
        let why = format!("no equilibrium on the way: {notes}");
        self.stand(description, scene, model, found).ok_or(Refused { why, ends })
    }
}

/// (2), in units of the outputs and numbers.
fn learn(slopes: &mut Mat<f64>, s: &[f64], before: &[f64], after: &[f64]) {
    let square: f64 = s.iter().map(|x| x * x).sum();
    for i in 0..before.len() {
        let told: f64 = s.iter().enumerate().map(|(j, x)| slopes[(i, j)] * x).sum();
        let untold = (after[i] - before[i] - told) / square;
        s.iter().enumerate().for_each(|(j, x)| slopes[(i, j)] += untold * x);
    }
}

/// How far steps go.
struct Trust {
    /// In units of the numbers.
    radius: f64,
    /// Whether a step that had to be shortened led to another equilibrium, or to an unstable one.
    ends: bool,
}

/// Why a change is none.
struct Refused {
    why: String,
    /// Whether the equilibrium there is one that runs away.
    ends: bool,
}

/// Where the search of a model begins beside another equilibrium: there, except in what hinges hold.
fn beginning(model: &Model, beside: &[f64]) -> Vec<f64> {
    let mut pose = beside.to_vec();
    for link in &model.links {
        let (positions, velocities) = link.joint.counts();
        if velocities > 0 && model.coordinates[link.velocity].lock {
            let held = link.position..link.position + positions;
            pose[held.clone()].copy_from_slice(&model.start_position[held]);
        }
    }
    pose
}

fn values(description: &Description, unknown: &[Parameter]) -> Vec<(String, f64)> {
    unknown.iter().map(|one| (one.address.clone(), one.value(description))).collect()
}

/// The scene as it was, and why it stays so.
fn missed(
    description: Description,
    model: Arc<Model>,
    mut found: Equilibrium,
    sought: Sought<'_>,
    note: String,
) -> InverseAnswer {
    found.converged = false;
    found.unknowns = values(&description, sought.unknown);
    let numbers = outputs(&model, &found).unwrap_or_default();
    let labels = model.outputs.iter().flat_map(|output| output.labels());
    let of_aim = |(label, _): &(String, f64)| sought.aim.iter().any(|aim| aim.output == *label);
    found.aimed = labels.zip(numbers).filter(of_aim).collect();
    found.notes.insert(0, note);
    InverseAnswer { description, model, found }
}
