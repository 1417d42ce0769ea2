//! Dry friction and contact at rest: does the scene stand as it is put, by how much, and how would it fall?
//!
//! With friction the equilibria of a scene are a set, not a point. The pose is kept as given and asked whether forces in
//! the cones of its supports balance what pushes it there ([`crate::contact::support`]): contacts that are closed, hinges with
//! dry friction, stops that are touched; loops, drives, gears and locks bear whatever they have to.
//!
//! ```text
//! (1)  f(q) + Gᵀλ + Jᵀ c + τ = 0,    c ∈ K_contact,   |τ| ≤ stick,   λ free,  stops that press
//! ```
//!
//! `f` is what the balance of the hinges lacks at rest. The size of the loads is that of the largest part of `f`, moments by
//! the scene's length. What stands is the pose, bit for bit.
//!
//! | file | its one job |
//! |---|---|
//! | `answer` | what is said of a pose |
//! | `closed` | which contacts are closed in it |
//! | `supports` | (1): what bears in it, and the load |
//! | `margins` | how far numbers of the scene may go, and how far it may be tilted |
//! | `mechanism`, `rolling` | how it gives way, and the motions that contacts leave free without sliding |
//! | `certificate`, `pushed` | its certificate, and contacts as loads |
//! | `settle` | from a guess that does not stand to a pose that does |

pub(super) mod answer;
mod certificate;
mod closed;
mod following;
mod margins;
mod mechanism;
mod pushed;
mod rolling;
mod settle;
mod supports;

pub use crate::contact::pairs::Untouchable;
pub use answer::{ContactForce, FrictionForce, Interval, Margins, StandingReport};
pub use closed::Contact;
pub use mechanism::{Giving, Mechanism};
pub use pushed::{by_rule, with_contacts};

use self::closed::Scene;
use self::supports::{Bearers, Bears};
use super::certify::equilibrium::Equilibrium;
use super::inverse::InverseAnswer;
use super::search::{Observers, equilibrium_observed};
use super::settings::{Margin, Settings};
use crate::contact::support::Undecided;
pub use crate::contact::support::Verdict;
use crate::dynamics::Fault;
use crate::model::problem::{rounded, significant};
use crate::model::{Description, Link, Model, Parameter, StopLaw};
use std::sync::Arc;

/// Why the question has no answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unanswered {
    /// The system cannot be evaluated.
    #[error(transparent)]
    Fault(#[from] Fault),
    /// Shapes that cannot touch, or overlap.
    #[error(transparent)]
    Untouchable(#[from] Untouchable),
    /// The conic program.
    #[error(transparent)]
    Undecided(#[from] Undecided),
    /// A number whose margin is asked for and that cannot be another one.
    #[error("the margin of `{address}`: {why}")]
    Fixed {
        /// Its address.
        address: String,
        /// Why not.
        why: String,
    },
    /// Loops that cannot be closed in the pose.
    #[error("{0}")]
    Open(String),
    /// A margin beyond a value at which what follows the load finds no balance.
    #[error("what bends or hangs finds no balance nearby beyond {} of it", significant(*value, 4))]
    Unbalanced {
        /// What was added to the number there.
        value: f64,
    },
    /// A scene that was to settle.
    #[error("the scene does not settle: {0}")]
    Unsettled(String),
}

/// A friction margin below this is round-off of the conic solver.
const NOT_NEEDED: f64 = 1e-9;

/// Whether a scene has dry friction or contact.
pub fn is_for(model: &Model) -> bool {
    !(model.hinge_friction.is_empty() && model.contacts.is_empty())
}

/// The equilibrium of a scene with dry friction or contact: the pose as given if it stands. A scene without contacts whose pose
/// friction does not hold is searched as if it had none; with contacts the pose is the answer, as one that does not stand.
///
/// # Errors
/// [`Unanswered`].
pub(super) fn equilibrium(
    description: &Description,
    model: &Arc<Model>,
    settings: &Settings,
    asked: &Margin,
    search: &dyn Fn() -> Result<Equilibrium, Fault>,
    go_on: &dyn Fn() -> bool,
) -> Result<Equilibrium, Unanswered> {
    let pose = &bent(model, settings, go_on)?;
    let given = match standing(description, model, settings, asked, pose) {
        Ok(given) if given.verdict != Verdict::Falls => given,
        Ok(_) | Err(Unanswered::Untouchable(Untouchable::Overlap { .. }))
            if settings.settle && !model.contacts.is_empty() =>
        {
            return settled(description, model, settings, asked, go_on);
        }
        other => other?,
    };
    let needs_friction = given.friction_margin.is_some_and(|part| part > NOT_NEEDED);
    if given.verdict == Verdict::Stands && model.contacts.is_empty() && !needs_friction {
        // An equilibrium without friction, too: it has its modes.
        let mut found = search()?;
        if found.converged && found.position == *pose {
            found.notes.extend_from_slice(&given.margins.notes);
            return Ok(Equilibrium { standing: Some(Box::new(given)), ..found });
        }
    }
    if given.verdict == Verdict::Stands || !model.contacts.is_empty() {
        let mut found = certificate::certificate(description, model, settings, pose, &given)?;
        if given.verdict == Verdict::Falls {
            found.notes.push(
                "it is judged where it is given: `[statics] contact = \"settle\"` looks for where it comes to stand"
                    .to_owned(),
            );
        }
        return Ok(Equilibrium { standing: Some(Box::new(given)), ..found });
    }
    let mut found = search()?;
    found.notes.push("dry friction does not hold the given pose: this is an equilibrium without it".to_owned());
    Ok(Equilibrium { standing: Some(Box::new(given)), ..found })
}

/// The start position; beams, which are given without what they bear, bent by it while every hinge stays where it is given,
/// but for those that cables swing on.
fn bent(model: &Arc<Model>, settings: &Settings, go_on: &dyn Fn() -> bool) -> Result<Vec<f64>, Unanswered> {
    let pose = &model.start_position;
    if model.beams.is_empty() {
        return Ok(pose.clone());
    }
    let swings = |link: &Link| model.beams.iter().any(|beam| beam.is_cable && beam.root == link.body);
    let hinges = model.links.iter().filter(|link| !link.joint.is_flex() && !swings(link));
    let hinges = hinges.flat_map(|link| link.velocity..link.velocity + link.joint.counts().1);
    let held = Arc::clone(model).locking(hinges);
    if model.contacts.is_empty() {
        let observers = Observers { go_on: Some(go_on), ..Observers::default() };
        return Ok(equilibrium_observed(&held, settings, pose, observers)?.position);
    }
    let settled = settle::settle(&held, settings, pose, go_on)?.pose;
    balanced(&held, settings, settled, go_on)
}

/// Where a search has settled, what no support pushes is this near to its balance: part of the scene's length.
const NEAR: f64 = 1e-6;

/// A pose where a scene has settled, with coordinates that no support pushes at their balance to the last digit, all others held: what these
/// lack is no load that others could bear.
fn balanced(
    model: &Arc<Model>,
    settings: &Settings,
    pose: Vec<f64>,
    go_on: &dyn Fn() -> bool,
) -> Result<Vec<f64>, Unanswered> {
    // What overlaps is told where the pose is judged.
    let Ok(scene) = Scene::new(model, &pose, settings.gap) else { return Ok(pose) };
    let pushed = Bearers::new(model, &pose, &scene)?.pushed;
    if pushed.iter().all(|pushed| *pushed) {
        return Ok(pose);
    }
    let held = Arc::clone(model).locking((0..pushed.len()).filter(|i| pushed[*i]));
    let observers = Observers { go_on: Some(go_on), ..Observers::default() };
    let found = equilibrium_observed(&held, settings, &pose, observers)?;
    let (moved, _) = settle::way(model, &pose, &found.position);
    Ok(if found.balanced && moved <= NEAR * model.length_scale() { found.position } else { pose })
}

/// Where a scene settles from its start position, as one that stands.
fn settled(
    description: &Description,
    model: &Arc<Model>,
    settings: &Settings,
    asked: &Margin,
    go_on: &dyn Fn() -> bool,
) -> Result<Equilibrium, Unanswered> {
    let mut end = settle::settle(model, settings, &model.start_position, go_on)?;
    end.pose = balanced(model, settings, end.pose, go_on)?;
    let there = standing(description, model, settings, asked, &end.pose).map_err(|why| match why {
        Unanswered::Untouchable(Untouchable::Overlap { between: [one, other], depth, allowed, .. }) => {
            Unanswered::Unsettled(format!(
                "where nothing goes down any more `{one}` and `{other}` overlap by {} m, and {} m count as closed: \
                 begin from another pose, or raise `[statics] gap`",
                rounded(depth),
                significant(allowed, 2)
            ))
        }
        why => why,
    })?;
    let mut found = certificate::certificate(description, model, settings, &end.pose, &there)?;
    (found.stage, found.iterations) = ("settled", end.steps);
    found.notes.push(format!(
        "settled from the given pose in {} steps: `{}` moved by {} m, more than any other body",
        end.steps,
        model.bodies[end.body].name,
        rounded(end.moved)
    ));
    Ok(Equilibrium { standing: Some(Box::new(there)), ..found })
}

/// Whether a pose stands, and the margins that are `asked` for. `description` is the scene's, for the numbers that they move.
///
/// # Errors
/// [`Unanswered`].
pub fn standing(
    description: &Description,
    model: &Arc<Model>,
    settings: &Settings,
    asked: &Margin,
    pose: &[f64],
) -> Result<StandingReport, Unanswered> {
    if let Some(drive) = model.drives.iter().find(|drive| drive.motion.at(0.0).velocity != 0.0) {
        let why = format!("drive `{}` moves at t = 0: whether a scene stands is asked of scenes at rest", drive.name);
        return Err(Unanswered::Open(why));
    }
    if let Some(rule) = model.contacts.iter().find(|rule| matches!(rule.law, StopLaw::Compliant { .. })) {
        let why = format!(
            "contact `{}` is compliant, and statics knows rigid contact alone: leave out its `stiffness`, or let a run with `start = \"given\"` find \
             where the scene comes to rest",
            rule.name
        );
        return Err(Unanswered::Open(why));
    }
    let mut scene = Scene::new(model, pose, settings.gap)?;
    let mut bearers = Bearers::new(model, pose, &scene)?;
    let found = bearers.judge(&mut scene)?;
    let wedged = found.verdict == Verdict::Wedged;
    let least = bearers.supports.friction_margin(&bearers.load, &found)?;
    let squeeze = wedged.then(|| bearers.supports.least_squeeze(&bearers.load)).transpose()?;
    let margins = match found.verdict {
        Verdict::Stands => {
            margins::margins(margins::Standing { description, model, settings, pose }, asked, &mut bearers)?
        }
        Verdict::Wedged | Verdict::Falls => Margins::default(),
    };
    let friction_margin = least.as_ref().map(|least| least.part);
    let motion = match (found.verdict, least) {
        (Verdict::Falls, _) => Some(found.motion.clone()),
        // At its margin, not here: here nothing moves.
        (Verdict::Stands, Some(least)) if least.part > 0.0 => Some(least.motion),
        _ => None,
    };
    let mechanism = motion.map(|motion| mechanism::mechanism(model, pose, &scene, &bearers, &motion));
    let Forces { contacts, friction, stops: stop_forces } = forces(model, &scene, &bearers, &found.forces);
    let stability = match found.verdict {
        Verdict::Stands if !scene.contacts.is_empty() => {
            Some(rolling::stability(model, pose, settings.gap, &bearers, &found.inner)?)
        }
        _ => None,
    };
    Ok(StandingReport {
        stability,
        verdict: found.verdict,
        slack: found.slack,
        contacts,
        friction,
        self_stresses: found.self_stresses,
        friction_margin,
        margins,
        squeeze,
        mechanism,
        certificate: found.certificate,
        stop_forces,
    })
}

/// What contacts, dry friction and stops bear, of the forces of all supports.
struct Forces {
    contacts: Vec<ContactForce>,
    friction: Vec<FrictionForce>,
    stops: Vec<(usize, f64)>,
}

fn forces(model: &Model, scene: &Scene, bearers: &Bearers, all: &[f64]) -> Forces {
    let (mut contacts, mut friction, mut stops) = (Vec::new(), Vec::new(), Vec::new());
    let largest = all.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
    for (i, bears) in bearers.list.iter().enumerate() {
        let f = &all[bearers.supports.range(i)];
        // Of forces that are round-off no share can be said.
        let bears_none = f.iter().all(|f| f.abs() <= 1e-9 * largest);
        let share = if bears_none { 0.0 } else { bearers.supports.cones()[i].share(f).unwrap_or(0.0) };
        match bears {
            Bears::Contact(k) => {
                let contact = scene.contacts[*k].clone();
                contacts.push(ContactForce { force: contact.force(f), contact, share });
            }
            Bears::Friction { velocity } => {
                friction.push(FrictionForce {
                    hinge: model.label(*velocity),
                    velocity: *velocity,
                    force: f.to_vec(),
                    share,
                });
            }
            Bears::Stop { velocity, side } => stops.push((*velocity, -side.sign() * f[0])),
            Bears::Other => {}
        }
    }
    Forces { contacts, friction, stops }
}

/// What contacts bear in a pose, and nothing else of [`StandingReport`].
#[derive(Debug, Clone)]
pub struct BearingContacts {
    /// The verdict.
    pub verdict: Verdict,
    /// Of closed contacts, as in [`StandingReport::contacts`].
    pub contacts: Vec<ContactForce>,
    /// How it gives way if it falls.
    pub mechanism: Mechanism,
}

/// Whether a pose stands and what its contacts bear; those are closed whose gap is at most `gap` times the size of the
/// smaller shape.
///
/// # Errors
/// [`Unanswered`].
pub fn bearing(model: &Arc<Model>, gap: f64, pose: &[f64]) -> Result<BearingContacts, Unanswered> {
    let mut scene = Scene::new(model, pose, gap)?;
    let mut bearers = Bearers::new(model, pose, &scene)?;
    let found = bearers.judge(&mut scene)?;
    let mechanism = mechanism::mechanism(model, pose, &scene, &bearers, &found.motion);
    let contacts = forces(model, &scene, &bearers, &found.forces).contacts;
    Ok(BearingContacts { verdict: found.verdict, contacts, mechanism })
}

/// Whether shapes overlap in a pose by more than `gap` times the size of the smaller one.
///
/// # Errors
/// [`Unanswered::Untouchable`] if they do, or cannot touch.
pub fn overlap(model: &Model, gap: f64, pose: &[f64]) -> Result<(), Unanswered> {
    Scene::new(model, pose, gap)?;
    Ok(())
}

/// The inputs that hold a pose without friction, and with it the range of each, the others being free. Where these values are not
/// within the ranges, as contacts do not pull, or where there are none, the scene's own values clamped into them.
pub(super) fn inputs(
    description: &Description,
    mut held: InverseAnswer,
    model: &Arc<Model>,
    unknown: &[Parameter],
    settings: &Settings,
    asked: &Margin,
) -> Result<InverseAnswer, Unanswered> {
    if !is_for(model) {
        return Ok(held);
    }
    let pose = &model.start_position;
    let ranges = margins::inputs(&held.description, &held.model, settings, pose, unknown)?;
    let is_within = |one: &Parameter| {
        let value = one.value(&held.description);
        ranges.iter().any(|range| range.name == one.address && (range.range[0]..=range.range[1]).contains(&value))
    };
    if !unknown.iter().all(is_within)
        && let Some(clamped) = margins::clamped(description, &held.model, settings, pose, unknown)?
    {
        (held.description, held.model) = clamped;
        held.found.unknowns = unknown.iter().map(|one| (one.address.clone(), one.value(&held.description))).collect();
    }
    let mut given = standing(&held.description, &held.model, settings, asked, pose)?;
    given.margins.inputs = ranges;
    let mut found = match given.verdict {
        Verdict::Stands => certificate::certificate(&held.description, &held.model, settings, pose, &given)?,
        _ => held.found.clone(),
    };
    found.unknowns.clone_from(&held.found.unknowns);
    found.method = "inverse";
    found.standing = Some(Box::new(given));
    Ok(InverseAnswer { found, ..held })
}
