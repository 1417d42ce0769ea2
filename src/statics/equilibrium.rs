//! The equilibrium with its certificate.

use super::cascade::{self, Effort, Found, Stage};
use super::landscape::Landscape;
use super::search::{BALANCED, Iteration, Place};
use super::stability::{Stability, Verdict, classify};
use super::stops::{self, Bearing};
use super::unheld::{self, Unheld};
use super::watch::Watch;
use super::{Method, Settings, Want, bounded, tied};
use crate::constraint::LoopReaction;
use crate::dynamics::{Fault, System};
use crate::model::Model;
use crate::model::problem::number;
use crate::spatial::{Pose, Wrench};
use nalgebra::Vector3;
use std::sync::Arc;

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
    /// The stage that won: `start` (nothing to do, or nothing that would help), `newton`, `trust region`, `release` or
    /// `relaxation`; of `lagrange` `newton` or `pseudo-transient`.
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
    /// The same relative to the forces that cancel there.
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
    /// Verdict and modes; `None` where there is no equilibrium.
    pub stability: Option<Stability>,
    /// What locked hinges have to hold: coordinate name and force (N, N m).
    pub holding: Vec<(String, f64)>,
    /// Stops of hinges that it rests on.
    pub stops: Vec<Bearing>,
    /// Multipliers of the independent rows of loops, drives and gears (N or N m).
    pub multipliers: Vec<f64>,
    /// The same by loop, drive and gear, all of its rows: zero for those that others stand for.
    pub carried: Vec<(String, Vec<f64>)>,
    /// Loops and gears with such rows, how many, of how many: reactions in and around them are not unique.
    pub redundant: Vec<(String, usize, usize)>,
    /// What the loops pass; of reactions that are not unique, here and in [`Equilibrium::reactions`], the smallest.
    pub loops: Vec<LoopReaction>,
    /// Of inverse statics: address and value of every unknown.
    pub unknowns: Vec<(String, f64)>,
    /// What a person should know: saddles that were left, what is unbalanced.
    pub notes: Vec<String>,
    /// For `lagrange`: what its multipliers say of [`Equilibrium::reactions`]; empty for the others.
    pub multiplier_reactions: Vec<Wrench>,
    /// Every step; of a relaxation every new start from rest.
    pub history: Vec<Iteration>,
}

/// Finds the equilibrium from the guess `start`.
///
/// ```
/// use stillpoint::model::Model;
/// use stillpoint::model::description::{BodyDescription, Description, HingeDescription};
/// use stillpoint::statics::{Settings, Verdict, equilibrium};
///
/// // A weight on a slide with a spring: it sinks by m g / k.
/// let slide = HingeDescription::prismatic([0.0, 0.0, 1.0]).stiffness([100.0]);
/// let scene = Description::new("Scale").body(BodyDescription::new("pan", slide).mass(2.0));
/// let model = Model::build(&scene).expect("a sound scene");
/// let found = equilibrium(&model, &Settings::default(), &model.start_position)?;
/// assert!(found.converged && found.residual_force < 1e-9);
/// assert!((found.position[0] + 2.0 * 9.80665 / 100.0).abs() < 1e-12);
/// assert_eq!(found.stability.expect("an equilibrium").verdict, Verdict::Stable);
/// # Ok::<(), stillpoint::dynamics::Fault>(())
/// ```
///
/// # Errors
/// Where the system cannot be evaluated at the guess: a singular hinge, a number that is not finite.
pub fn equilibrium(model: &Arc<Model>, settings: &Settings, start: &[f64]) -> Result<Equilibrium, Fault> {
    equilibrium_observed(model, settings, start, &mut || {})
}

/// The same as long as `go_on`, asked once for every step of the search, says so: after that the answer is what was found until
/// then, not converged unless it is balanced.
///
/// # Errors
/// As [`equilibrium`].
pub fn equilibrium_while(
    model: &Arc<Model>,
    settings: &Settings,
    start: &[f64],
    go_on: &dyn Fn() -> bool,
) -> Result<Equilibrium, Fault> {
    let watch = Watch::new(settings.time_limit, go_on);
    search(model, settings, start, &watch, &mut || {}, None).map(|(found, _)| found)
}

/// The same; `searched` is called between the search and the certificate, for whoever holds a clock.
///
/// # Errors
/// As [`equilibrium`].
pub fn equilibrium_observed(
    model: &Arc<Model>,
    settings: &Settings,
    start: &[f64],
    searched: &mut dyn FnMut(),
) -> Result<Equilibrium, Fault> {
    let watch = Watch::new(settings.time_limit, &|| true);
    search(model, settings, start, &watch, searched, None).map(|(found, _)| found)
}

/// As [`equilibrium_while`] with the way there: every pose whose forces the search has looked at, the guess first.
///
/// # Errors
/// As [`equilibrium`].
pub fn equilibrium_watched(
    model: &Arc<Model>,
    settings: &Settings,
    start: &[f64],
    go_on: &dyn Fn() -> bool,
) -> Result<(Equilibrium, Vec<Vec<f64>>), Fault> {
    let watch = Watch::new(settings.time_limit, go_on);
    search(model, settings, start, &watch, &mut || {}, Some(Vec::new()))
}

fn search(
    model: &Arc<Model>,
    settings: &Settings,
    start: &[f64],
    watch: &Watch<'_>,
    searched: &mut dyn FnMut(),
    mut trail: Option<Vec<Vec<f64>>>,
) -> Result<(Equilibrium, Vec<Vec<f64>>), Fault> {
    if let Some(found) = unresting(model, settings, start)? {
        searched();
        return Ok((found, trail.map_or_else(Vec::new, |_| vec![start.to_vec()])));
    }
    if model.stops.is_empty() {
        return search_free(model, settings, start, watch, searched, trail);
    }
    let mut found = stops::search(model, settings, start, watch, searched, trail.as_mut())?;
    bounded::examine_weak(model, settings, &mut found)?;
    Ok((found, trail.unwrap_or_default()))
}

/// What is told at once of a scene with a constant force that nothing feels: the cascade would follow it without end. `None` for
/// others.
fn unresting(model: &Arc<Model>, settings: &Settings, start: &[f64]) -> Result<Option<Equilibrium>, Fault> {
    let held = || (settings.method == Method::Auto).then(|| unheld::unheld(model)).flatten();
    let Some(Unheld { body, force }) = held() else { return Ok(None) };
    let mut system = System::new(model);
    let mut landscape = Landscape::new(&mut system, start)?;
    let place = Place::at(&mut landscape, start.to_vec())?;
    if place.is_balanced() {
        return Ok(None);
    }
    let (size, along) = (number(force.norm()), force.normalize());
    let notes = vec![
        unbalanced(&mut landscape, &place),
        format!(
            "no position is an equilibrium: {size} N along [{:.3}, {:.3}, {:.3}] move `{body}` and what hangs together with it \
             wherever it is, and no hinge, force or loop holds it in that direction",
            along.x, along.y, along.z
        ),
    ];
    certify(landscape, settings, place, Effort { stage: "start", ..Effort::default() }, Vec::new(), notes).map(Some)
}

/// The same for a model without stops.
pub(super) fn search_free(
    model: &Arc<Model>,
    settings: &Settings,
    start: &[f64],
    watch: &Watch<'_>,
    searched: &mut dyn FnMut(),
    trail: Option<Vec<Vec<f64>>>,
) -> Result<(Equilibrium, Vec<Vec<f64>>), Fault> {
    let mut system = System::new(model);
    let mut landscape = Landscape::new(&mut system, start)?;
    landscape.trail = trail;
    landscape.watch = Some(watch);
    let mut history = Vec::new();
    let first = Place::at(&mut landscape, start.to_vec())?;
    landscape.begin(&first);
    let guess = first.clone();
    let Found { mut place, mut notes, effort } = cascade::search(&mut landscape, settings, first, &mut history)?;
    searched();
    if !place.is_balanced() {
        // Where the search ran away, what is missing shows best where it started.
        if landscape.is_far(&place.q) && !effort.fell {
            notes.push(
                "the search ran away, beyond all lengths of the scene: balance there would be round-off".to_owned(),
            );
        }
        if effort.fell || landscape.is_far(&place.q) {
            place = guess;
        }
        let ended = watch.note(effort.stage, place.residual().0);
        notes.push(ended.unwrap_or_else(|| unbalanced(&mut landscape, &place)));
    }
    let trail = landscape.trail.take().unwrap_or_default();
    Ok((certify(landscape, settings, place, effort, history, notes)?, trail))
}

/// What a start leaves unbalanced.
#[derive(Debug, Clone, PartialEq)]
pub struct Leftover {
    /// Largest unbalanced force, relative to the forces that cancel there.
    pub relative: f64,
    /// That force (N or N m).
    pub force: f64,
    /// Its coordinate, as in [`Model::label`].
    pub hinge: String,
}

/// Whether a state holds itself: what is left over where it does not. `None` where it does, and for a state that moves
/// otherwise than its drives.
///
/// # Errors
/// Where the system cannot be evaluated there.
pub fn leftover(model: &Arc<Model>, position: &[f64], velocity: &[f64]) -> Result<Option<Leftover>, Fault> {
    let (model, position) = &stops::bearing(model, position);
    let mut system = System::new(model);
    let mut landscape = Landscape::new(&mut system, position)?;
    let size = velocity.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if landscape.steady.iter().zip(velocity).any(|(steady, v)| (steady - v).abs() > 1e-9 * size) {
        return Ok(None);
    }
    let place = Place::at(&mut landscape, position.clone())?;
    let (relative, worst) = place.residual();
    Ok(worst.filter(|_| !place.is_balanced()).map(|worst| Leftover {
        relative,
        force: place.force[worst],
        hinge: model.label(landscape.free[worst]),
    }))
}

/// The certificate of a pose as it stands: nothing is searched for. `by` is its method and stage.
pub(super) fn examine(
    model: &Arc<Model>,
    settings: &Settings,
    pose: &[f64],
    by: &'static str,
    mut notes: Vec<String>,
) -> Result<Equilibrium, Fault> {
    let mut system = System::new(model);
    let mut landscape = Landscape::new(&mut system, pose)?;
    let place = Place::at(&mut landscape, pose.to_vec())?;
    if !place.is_balanced()
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
    let found = certify(landscape, &settings, place, Effort { stage: by, ..Effort::default() }, Vec::new(), notes)?;
    Ok(Equilibrium { method: by, ..found })
}

/// Names what is not balanced: hinge, body, force and direction.
pub(super) fn unbalanced(landscape: &mut Landscape<'_>, place: &Place) -> String {
    let (_, largest) = place.residual();
    let Some(worst) = unresisted(landscape, place).or(largest) else { return "no residual".to_owned() };
    format!(
        "nothing balances {}: a spring, a load or a lock is missing, or the guess is too far away",
        describe(landscape, place, worst)
    )
}

/// An unbalanced force with its hinge, direction and size.
fn describe(landscape: &mut Landscape<'_>, place: &Place, worst: usize) -> String {
    let relative = place.force[worst].abs() / place.scales.force[worst];
    let share = if relative >= 0.01 { format!("{:.0} %", 100.0 * relative) } else { format!("{relative:.1e}") };
    let (model, coordinate) = (&Arc::clone(landscape.model()), landscape.free[worst]);
    let size = number(place.force[worst]);
    let unit = if super::landscape::slides(model)[coordinate] { "N" } else { "N m" };
    let direction = direction(landscape, coordinate);
    let towards = direction.map_or(String::new(), |d| format!(" along [{:.3}, {:.3}, {:.3}]", d.x, d.y, d.z));
    format!("{size} {unit} in {}{towards} ({share} of the forces there)", model.label(coordinate))
}

/// The coordinate whose force nothing resists: a shifted solve leaves it to the shift, `σ B x` with `(K + σB) x = f`,
/// while it hands every other force to the stiffness. `None` where the stiffness resists them all.
fn unresisted(landscape: &mut Landscape<'_>, place: &Place) -> Option<usize> {
    landscape.look(&place.q).ok()?;
    let curvatures = place.scales.stiffness.iter().zip(&landscape.metric).map(|(k, b)| k / b);
    let sigma = 1e-8 * curvatures.fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let shift: Vec<f64> = landscape.metric.iter().map(|b| sigma * b).collect();
    let x = landscape.newton_shifted(&place.force, &shift)?;
    let left = |i: usize| (shift[i] * x[i]).abs() / place.scales.force[i].max(f64::MIN_POSITIVE);
    let largest = (0..x.len()).map(left).fold(0.0, f64::max);
    // Of several that nothing resists a force says more than its moment.
    let slides = super::landscape::slides(landscape.model());
    let equals = (0..x.len()).filter(|i| left(*i) >= 0.99 * largest);
    (largest > 1e-3).then(|| equals.min_by_key(|i| !slides[landscape.free[*i]]))?
}

/// The axis of a turn or slide in inertial axes; of the ball's axis for a ball.
fn direction(landscape: &mut Landscape<'_>, coordinate: usize) -> Option<Vector3<f64>> {
    let model = &Arc::clone(landscape.model());
    let (index, link) = model.links.iter().enumerate().skip(1).find(|(_, link)| {
        let (_, count) = link.joint.counts();
        (link.velocity..link.velocity + count).contains(&coordinate)
    })?;
    let motion = &landscape.system().motion().links[index];
    let (_, count) = link.joint.counts();
    Some(if count == 1 { motion.axis } else { motion.turn.column(coordinate - link.velocity).into_owned() })
}

/// What is said of a balance that is one only up to round-off.
fn round_off_note(place: &Place) -> Option<String> {
    let (relative, known) = (place.residual().0, place.round_off());
    let what = match known < 1.0 {
        true => format!(
            "what is left of the forces, {relative:.1e} of them, is round-off, and no step of Newton's halves it: large \
             lengths, or loops that are nearly taut, do not let them be known better than to {known:.1e} here"
        ),
        false => {
            "nothing carries a load here that would be above round-off: what is left of the forces is round-off too"
                .to_owned()
        }
    };
    (relative > BALANCED).then_some(what)
}

pub(super) fn certify(
    mut landscape: Landscape<'_>,
    settings: &Settings,
    place: Place,
    effort: Effort,
    history: Vec<Iteration>,
    mut notes: Vec<String>,
) -> Result<Equilibrium, Fault> {
    let model = &Arc::clone(landscape.model());
    let (free, conservative) = (landscape.free.clone(), landscape.conservative);
    let (force_evaluations, stiffness_evaluations) = (landscape.residuals + effort.forces, landscape.stiffnesses);
    let factorizations = landscape.factorizations + effort.factorizations;
    let (steady, rest) = (landscape.steady.clone(), vec![0.0; model.velocity_count()]);
    notes.extend(tied::notes(&landscape));
    let balanced = place.is_balanced();
    let (residual_acceleration, stability) = match landscape.ties.is_some() {
        true => {
            let examined = tied::examine(&mut landscape, &place)?;
            notes.extend(tied::prestress_note(&landscape));
            examined
        }
        false => {
            let system = landscape.system();
            let acceleration = held_acceleration(system, &place, &free)?;
            let classify = || classify(system, &place.q, &free, &place.scales.stiffness, conservative);
            (acceleration, balanced.then(classify).transpose()?)
        }
    };
    let system = landscape.system();
    let rows = system.constraints();
    let (carried, redundant) = rows.map_or((Vec::new(), Vec::new()), |rows| (rows.by_element(), rows.redundant()));
    let multipliers = system.constraints().map_or(Vec::new(), |rows| rows.independent_multipliers());
    system.share_multipliers(&place.q, &steady)?;
    let loops = system.loop_reactions();
    let mut residual = rest.clone();
    system.residual(&place.q, &steady, &rest, &mut residual)?;
    let (mut poses, mut reactions) = (Vec::new(), Vec::new());
    system.poses(&mut poses);
    system.reactions(&mut reactions);
    let drive_forces = system.constraints().map_or(Vec::new(), |rows| rows.drive_forces(model, &rest).collect());
    let holding: Vec<(String, f64)> =
        (0..rest.len()).filter(|i| model.coordinates[*i].lock).map(|i| (model.label(i), residual[i])).collect();
    notes.extend(balanced.then(|| round_off_note(&place)).flatten());
    let verdict = stability.as_ref().map(|s| s.verdict);
    if verdict == Some(Verdict::Unstable) && settings.want == Want::Stable {
        notes.push("only an unstable equilibrium was found; `want = \"any\"` would accept it".to_owned());
    }
    let kind = settings.want == Want::Any || verdict != Some(Verdict::Unstable);
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
        residual_force: place.force.iter().fold(0.0, |m, f| m.max(f.abs())),
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
        multipliers,
        carried,
        redundant,
        loops,
        unknowns: Vec::new(),
        notes,
        multiplier_reactions: by_body(model, &effort.reactions),
        history,
    })
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
    system.accelerations(&place.q, &rest, &mut a)?;
    if free.len() == rest.len() {
        return Ok(a.iter().fold(0.0, |m, a| m.max(a.abs())));
    }
    let mass = system.linearize(&place.q, &rest, &rest)?.mass;
    let held = faer::Mat::from_fn(free.len(), free.len(), |i, j| mass[(free[i], free[j])]);
    let a = super::linear::General::of(&held, &[]).solve(&place.force);
    Ok(a.iter().fold(0.0, |m, a| m.max(a.abs())))
}
