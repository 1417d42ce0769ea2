//! The equilibrium with its certificate.

use super::beams;
use super::closed;
use super::known;
use super::stability::{Stability, StabilityVerdict};
use super::unbalanced::describe;
use crate::constraint::LoopReaction;
use crate::dynamics::{Fault, System};
use crate::model::{Model, Side};
use crate::spatial::{Pose, Wrench};
use crate::statics::effort::{Effort, Iteration, Stage};
use crate::statics::problem::Landscape;
use crate::statics::problem::linear::General;
use crate::statics::problem::place::{BALANCED, Place};
use crate::statics::settings::{Method, Settings, Want};
use crate::statics::standing::answer::StandingReport;
use std::sync::Arc;

/// What is said of an unstable answer where a stable one was wanted.
pub(in crate::statics) const ONLY_UNSTABLE: &str =
    "only an unstable equilibrium was found; `want = \"any\"` would accept it";

/// What the search found, with the evidence.
#[derive(Debug, Clone)]
pub struct Equilibrium {
    /// Whether the residual proves an equilibrium of the kind that was wanted.
    pub converged: bool,
    /// Whether the residual proves an equilibrium of any kind.
    pub balanced: bool,
    /// `newton` (the method of the differentiated transfer equations), `relaxation` or `lagrange`; `inverse` where the
    /// pose was given.
    pub method: &'static str,
    /// The stage that won: `start` (nothing to do, or nothing that would help), `newton`, `trust region`, `release`,
    /// `relaxation` or `active set`; of `lagrange` `newton` or `pseudo-transient`.
    pub stage: &'static str,
    /// What each stage of the cascade worked, in their order; empty for the baselines.
    pub stages: Vec<Stage>,
    /// Steps of all stages; time steps of a relaxation.
    pub iterations: usize,
    /// Static balances: sweeps, and for `lagrange` also evaluations in maximal coordinates.
    pub force_evaluations: usize,
    /// Accelerations computed by a relaxation.
    pub acceleration_evaluations: usize,
    /// Stiffness matrices assembled.
    pub stiffness_evaluations: usize,
    /// Matrices, or tangents by sweeps, factorized.
    pub factorizations: usize,
    /// Largest hinge acceleration at rest (m/s², rad/s²), locked hinges held.
    pub residual_acceleration: f64,
    /// Largest unbalanced hinge force (N, N m), locked hinges left out.
    pub residual_force: f64,
    /// The velocity coordinate that it is along; `None` if nothing is free to move.
    pub residual_at: Option<usize>,
    /// Largest unbalanced hinge force, relative to the forces that cancel there.
    pub relative_residual: f64,
    /// What rounding alone may leave of the forces there, relative to them: nobody can ask for less.
    pub round_off: f64,
    /// Hinge coordinates.
    pub position: Vec<f64>,
    /// What every drive pushes, by its name (N or N m).
    pub drive_forces: Vec<(String, f64)>,
    /// Hinge velocities: zero, but for drives that keep theirs.
    pub velocity: Vec<f64>,
    /// Root markers of the named bodies: `world_from_body`.
    pub poses: Vec<Pose>,
    /// What the hinge passes to each named body at its root marker, inertial axes.
    pub reactions: Vec<Wrench>,
    /// Verdict and modes; `None` if there is no equilibrium.
    pub stability: Option<Stability>,
    /// What locked hinges have to hold: coordinate name and force (N, N m).
    pub holding: Vec<(String, f64)>,
    /// Stops of hinges that it rests on.
    pub stops: Vec<BearingStop>,
    /// Whether the given pose stands; `None` for a scene without dry friction and contact.
    pub standing: Option<Box<StandingReport>>,
    /// Multipliers of the independent rows of loops, drives and gears (N or N m).
    pub multipliers: Vec<f64>,
    /// Multipliers of all rows by loop, drive and gear (N or N m): zero for linearly dependent rows.
    pub carried: Vec<(String, Vec<f64>)>,
    /// Loops and gears with such rows, how many, of how many: reactions in and around them are not unique.
    pub redundant: Vec<(String, usize, usize)>,
    /// What the loops pass; of reactions that are not unique, here and in [`Equilibrium::reactions`], the smallest.
    pub loops: Vec<LoopReaction>,
    /// Of inverse statics: address and value of every unknown.
    pub unknowns: Vec<(String, f64)>,
    /// With an aim: what was aimed at, and its value here.
    pub aimed: Vec<(String, f64)>,
    /// What a person should know: saddles that were left, what is unbalanced.
    pub notes: Vec<String>,
    /// For `lagrange`: what its multipliers say of [`Equilibrium::reactions`]; empty for the others.
    pub multiplier_reactions: Vec<Wrench>,
    /// Every step; of a relaxation every new start from rest.
    pub history: Vec<Iteration>,
}

/// A stop that an equilibrium rests on.
#[derive(Debug, Clone, PartialEq)]
pub struct BearingStop {
    /// The body whose hinge it is, as in [`Model::label`].
    pub hinge: String,
    /// Which of its limits.
    pub side: Side,
    /// The limit (m or rad).
    pub limit: f64,
    /// What it bears (N or N m), ≥ 0.
    pub load: f64,
    /// How far it gives way (m or rad); 0 for a rigid one.
    pub depth: f64,
}

/// The certificate of a pose as it stands: nothing is searched for. `by` is its method and stage; `allowed` is the part of the forces that may be left,
/// if that is more than of what is searched for.
pub(in crate::statics) fn examine(
    model: &Arc<Model>,
    settings: &Settings,
    pose: &[f64],
    (by, allowed): (&'static str, f64),
    mut notes: Vec<String>,
) -> Result<Equilibrium, Fault> {
    let mut system = System::new(model);
    let mut landscape = Landscape::new(&mut system, pose)?;
    let place = Place::at(&mut landscape, pose.to_vec())?;
    if !place.is_balanced_to(allowed)
        && let (_, Some(worst)) = place.residual()
    {
        let others =
            (0..place.force.len()).filter(|i| *i != worst && place.force[*i].abs() > BALANCED * place.scales.force[*i]);
        let names: Vec<String> = others.map(|i| model.label(landscape.free[i])).collect();
        let nor = if names.is_empty() { String::new() } else { format!(", nor the forces in {}", names.join(", ")) };
        notes.push(format!("no unknown balances {}{nor}", describe(&mut landscape, &place, worst)));
    }
    // Whatever it is, it is the one that was given.
    let settings = Settings { want: Want::Any, ..*settings };
    let found =
        certify(landscape, &settings, place, Effort { stage: by, allowed, ..Effort::default() }, Vec::new(), notes)?;
    Ok(Equilibrium { method: by, ..found })
}

/// What is said of a balance that is one only up to round-off.
fn round_off_note(place: &Place) -> Option<String> {
    let (relative, known) = (place.residual().0, place.round_off());
    let what = match known < 1.0 {
        true => format!(
            "the residual, {relative:.1e} of the forces, is round-off: no Newton step halves it. With lengths this large, or loops \
             this close to taut, forces are known to {known:.1e} at best"
        ),
        false => "no force here is above round-off, and so is the residual".to_owned(),
    };
    (relative > BALANCED && place.is_balanced()).then_some(what)
}

pub(in crate::statics) fn certify(
    mut landscape: Landscape<'_>,
    settings: &Settings,
    place: Place,
    effort: Effort,
    history: Vec<Iteration>,
    mut notes: Vec<String>,
) -> Result<Equilibrium, Fault> {
    let model = &Arc::clone(landscape.model());
    let (free, steady, rest) = (landscape.free.clone(), landscape.steady.clone(), vec![0.0; model.velocity_count()]);
    let (force_evaluations, stiffness_evaluations) = (landscape.residuals + effort.forces, landscape.stiffnesses);
    let factorizations = landscape.factorizations + effort.factorizations;
    let shared = landscape.shared(&place.q);
    notes.extend(closed::notes(&landscape, shared.as_ref()));
    let balanced = place.is_balanced_to(effort.allowed);
    let (residual_acceleration, stability) = match landscape.ties.is_some() {
        true => {
            let examined = closed::examine(&mut landscape, &place)?;
            notes.extend(closed::prestress_note(&landscape));
            examined
        }
        false => {
            let acceleration = held_acceleration(landscape.system(), &place, &free)?;
            (acceleration, balanced.then(|| known::of_tree(&mut landscape, &place)).transpose()?)
        }
    };
    let system = landscape.system();
    let (carried, redundant) =
        system.constraints().map(|rows| (rows.by_element(), rows.redundant())).unwrap_or_default();
    let multipliers = system.constraints().map_or(Vec::new(), |rows| rows.independent_multipliers());
    let mut at = system.at(0.0, &place.q, &steady);
    at.share_multipliers()?;
    shared.iter().for_each(|shared| at.share_with_others(&shared.rows));
    let loops = at.loop_reactions();
    let (mut residual, mut poses, mut reactions) = (rest.clone(), Vec::new(), Vec::new());
    let at_rest = at.residual(&rest, &mut residual)?;
    at_rest.reactions(&mut reactions);
    let of_beams = balanced.then(|| beams::judge(&at_rest, &place.q));
    let balanced = of_beams.as_ref().is_some_and(|judged| judged.hold);
    notes.splice(0..0, of_beams.into_iter().flat_map(|judged| judged.notes));
    at.poses(&mut poses);
    notes.extend(shared.filter(|_| balanced).and_then(|shared| closed::shared_note(model, &shared, &loops)));
    let drive_forces = system.constraints().map_or(Vec::new(), |rows| rows.drive_forces(model, &rest).collect());
    let holding = holding(model, &residual);
    notes.extend(balanced.then(|| round_off_note(&place)).flatten());
    let largest = largest(&place.force);
    let stability = stability.filter(|_| balanced);
    notes.extend(stability.as_ref().and_then(|stability| stability.flutter_note(model)));
    let is_unstable = stability.as_ref().is_some_and(|stability| stability.verdict == StabilityVerdict::Unstable);
    if is_unstable && settings.want == Want::Stable {
        notes.push(ONLY_UNSTABLE.to_owned());
    }
    let kind = settings.want == Want::Any || !is_unstable;
    Ok(Equilibrium {
        converged: balanced && kind,
        balanced,
        method: if settings.method == Method::Auto { "newton" } else { settings.method.name() },
        stage: effort.stage,
        iterations: effort.steps.unwrap_or(history.len()),
        stages: effort.stages,
        force_evaluations,
        acceleration_evaluations: effort.accelerations,
        factorizations,
        stiffness_evaluations,
        residual_acceleration,
        residual_force: largest.map_or(0.0, |at| place.force[at].abs()),
        residual_at: largest.map(|at| free[at]),
        relative_residual: place.residual().0,
        round_off: place.round_off(),
        drive_forces,
        velocity: steady,
        position: place.q,
        poses,
        reactions,
        stability,
        holding,
        stops: Vec::new(),
        standing: None,
        multipliers,
        carried,
        redundant,
        loops,
        unknowns: Vec::new(),
        aimed: Vec::new(),
        notes,
        multiplier_reactions: by_body(model, &effort.reactions),
        history,
    })
}

/// What locked coordinates have to hold.
fn holding(model: &Model, residual: &[f64]) -> Vec<(String, f64)> {
    (0..residual.len()).filter(|i| model.coordinates[*i].lock).map(|i| (model.label(i), residual[i])).collect()
}

/// Where the largest force is.
fn largest(force: &[f64]) -> Option<usize> {
    (0..force.len()).max_by(|a, b| force[*a].abs().total_cmp(&force[*b].abs()))
}

/// Reactions of the links that carry a named hinge, by body; welded bodies have none.
fn by_body(model: &Model, reactions: &[Wrench]) -> Vec<Wrench> {
    if reactions.is_empty() {
        return Vec::new();
    }
    let own = |(index, body): (usize, &crate::model::Body)| match body.link != 0 && model.links[body.link].body == index
    {
        true => reactions[body.link],
        false => Wrench::ZERO,
    };
    model.bodies.iter().enumerate().map(own).collect()
}

/// Largest hinge acceleration at rest with locked hinges held.
fn held_acceleration(system: &mut System, place: &Place, free: &[usize]) -> Result<f64, Fault> {
    let rest = vec![0.0; system.model().velocity_count()];
    let mut a = rest.clone();
    system.at(0.0, &place.q, &rest).accelerations(&mut a)?;
    if free.len() == rest.len() {
        return Ok(a.iter().fold(0.0, |m, a| m.max(a.abs())));
    }
    let mass = system.at(0.0, &place.q, &rest).linearize(&rest)?.mass;
    let held = faer::Mat::from_fn(free.len(), free.len(), |i, j| mass[(free[i], free[j])]);
    let a = General::of(&held, &[]).solve(&place.force);
    Ok(a.iter().fold(0.0, |m, a| m.max(a.abs())))
}
