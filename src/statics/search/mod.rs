//! The search for an equilibrium from a guess.
//!
//! | want | loads have a potential | first stage |
//! |---|---|---|
//! | stable | yes | Newton within a trust region, down the potential; saddles are left |
//! | stable | no | Newton with line search; what runs away is left with the motion itself |
//! | any | either | Newton with line search: the nearest equilibrium, whatever it is |
//!
//! Where that fails, later stages of the [`cascade`] take over: the [`release`] of the guess, then dynamic relaxation.

mod active;
mod bounded;
mod cascade;
pub(super) mod curve;
mod floating;
mod free;
pub(super) mod illinois;
mod krylov;
mod leave;
mod newton;
mod polish;
mod progress;
mod release;
mod saddle;
mod trust_region;
mod turns;

use super::certify::bearing;
use super::certify::equilibrium::{Equilibrium, certify};
use super::certify::falling::falling;
use super::effort::Effort;
use super::problem::Landscape;
use super::problem::place::Place;
use super::settings::{Method, Settings};
use super::watch::Watch;
use crate::constraint::Constraints;
use crate::dynamics::{Fault, System};
use crate::model::Model;
use crate::model::problem::number;
use std::sync::Arc;

/// Finds the equilibrium from the guess `start`.
///
/// ```
/// use stillpoint::model::Model;
/// use stillpoint::model::description::{BodyDescription, Description, HingeDescription};
/// use stillpoint::statics::{Settings, StabilityVerdict, equilibrium};
///
/// // A weight on a slide with a spring: it sinks by m g / k.
/// let slide = HingeDescription::prismatic([0.0, 0.0, 1.0]).stiffness([100.0]);
/// let scene = Description::new("Scale").body(BodyDescription::new("pan", slide).mass(2.0));
/// let model = Model::build(&scene).expect("a sound scene");
/// let found = equilibrium(&model, &Settings::default(), &model.start_position)?;
/// assert!(found.converged && found.residual_force < 1e-9);
/// assert!((found.position[0] + 2.0 * 9.80665 / 100.0).abs() < 1e-12);
/// assert_eq!(found.stability.expect("an equilibrium").verdict, StabilityVerdict::Stable);
/// # Ok::<(), stillpoint::dynamics::Fault>(())
/// ```
///
/// # Errors
/// If the system cannot be evaluated at the guess: a singular hinge, a number that is not finite.
pub fn equilibrium(model: &Arc<Model>, settings: &Settings, start: &[f64]) -> Result<Equilibrium, Fault> {
    equilibrium_observed(model, settings, start, Observers::default())
}

/// What looks at a search while it goes on; [`Observers::default`] has nothing that does.
#[derive(Default)]
pub struct Observers<'o> {
    /// Whether the search goes on, asked once for every step. After the first `false` the answer is what was found until then, not
    /// converged unless it is balanced.
    pub go_on: Option<&'o dyn Fn() -> bool>,
    /// Called between the search and the certificate, for whoever holds a clock.
    pub searched: Option<&'o mut dyn FnMut()>,
    /// Receives every pose whose forces the search has looked at, the guess first.
    pub trail: Option<&'o mut Vec<Vec<f64>>>,
}

/// Finds the equilibrium from the guess `start`, as [`equilibrium`], while `observers` look on.
///
/// # Errors
/// As [`equilibrium`].
pub fn equilibrium_observed(
    model: &Arc<Model>,
    settings: &Settings,
    start: &[f64],
    observers: Observers<'_>,
) -> Result<Equilibrium, Fault> {
    let Observers { go_on, searched, trail } = observers;
    let watch = Watch::new(settings.time_limit, go_on.unwrap_or(&|| true));
    let mut unobserved = || {};
    let searched = searched.unwrap_or(&mut unobserved);
    search(Search { model, settings, start, watch: &watch, searched, trail })
}

/// One search: what is asked, and what looks on.
struct Search<'s> {
    model: &'s Arc<Model>,
    settings: &'s Settings,
    /// The guess.
    start: &'s [f64],
    watch: &'s Watch<'s>,
    /// Called between the search and the certificate.
    searched: &'s mut dyn FnMut(),
    /// Receives the poses of the search.
    trail: Option<&'s mut Vec<Vec<f64>>>,
}

impl Search<'_> {
    /// This search, to be used again after it.
    fn again(&mut self) -> Search<'_> {
        self.of(self.model, self.start)
    }

    /// This search of another model and from another guess.
    fn of<'s>(&'s mut self, model: &'s Arc<Model>, start: &'s [f64]) -> Search<'s> {
        let trail = self.trail.as_deref_mut();
        Search { model, settings: self.settings, start, watch: self.watch, searched: &mut *self.searched, trail }
    }

    /// Records the poses that a landscape has looked at.
    fn record(self, landscape: &mut Landscape<'_>) {
        if let (Some(trail), Some(way)) = (self.trail, landscape.trail.take()) {
            trail.extend(way);
        }
    }
}

fn search(mut search: Search<'_>) -> Result<Equilibrium, Fault> {
    let (model, settings, start) = (search.model, search.settings, search.start);
    if let Some(found) = unresting(model, settings, start)? {
        (search.searched)();
        search.trail.iter_mut().for_each(|trail| trail.push(start.to_vec()));
        return Ok(found);
    }
    Ok(on_curves(model, leave::search(search)?))
}

/// What is found must be on the curves that bodies are guided along.
fn on_curves(model: &Model, found: Equilibrium) -> Equilibrium {
    let Some(note) = beyond_curve(model, &found.position) else { return found };
    let notes = [note].into_iter().chain(found.notes).collect();
    Equilibrium { converged: false, balanced: false, stability: None, notes, ..found }
}

/// What is said of a search that has left the curve that a body is guided along.
fn beyond_curve(model: &Model, position: &[f64]) -> Option<String> {
    let end = model.beyond_curve(position)?;
    let ends = model.curve_ends.iter().filter(|other| other.position == end.position).map(|end| end.at);
    let [from, to] = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[from, to], at| [from.min(at), to.max(at)]);
    let body = &model.bodies[end.body].name;
    Some(format!(
        "`{body}` rests nowhere on its curve, which goes from {} m to {} m: the search leaves it at {} m; give the hinge `limits`, or \
         another `position` to start from",
        number(from),
        number(to),
        number(end.at)
    ))
}

/// What is told at once of a scene that falls for ever wherever it is: the cascade would follow it without end. `None` for
/// others.
fn unresting(model: &Arc<Model>, settings: &Settings, start: &[f64]) -> Result<Option<Equilibrium>, Fault> {
    let mut system = System::new(model);
    let rest = vec![0.0; model.velocity_count()];
    let falls = || falling(model, system.at(0.0, start, &rest).motion()).filter(|fall| fall.everywhere);
    let Some(fall) = (settings.method == Method::Auto).then(falls).flatten() else { return Ok(None) };
    let mut landscape = Landscape::new(&mut system, start)?;
    let place = Place::at(&mut landscape, start.to_vec())?;
    let notes = vec![fall.note()];
    certify(landscape, settings, place, Effort { stage: "start", ..Effort::default() }, Vec::new(), notes).map(Some)
}

/// The residual of a state that does not hold itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Residual {
    /// Largest unbalanced force, relative to the forces that cancel there.
    pub relative: f64,
    /// That force (N or N m).
    pub force: f64,
    /// Its coordinate, as in [`Model::label`].
    pub hinge: String,
}

/// What a state at rest is held by.
#[derive(Debug, Clone, PartialEq)]
pub struct Balance {
    /// If it does not hold itself.
    pub residual: Option<Residual>,
    /// What loops, drives and gears push with, row by row (N or N m), beside stops and locks that hold.
    pub pushes: Vec<(String, Vec<f64>)>,
}

/// How a state is balanced; `None` for one that moves otherwise than its drives.
///
/// # Errors
/// If the system cannot be evaluated there.
pub fn balance(model: &Arc<Model>, position: &[f64], velocity: &[f64]) -> Result<Option<Balance>, Fault> {
    let (model, position) = &bearing::bearing(model, position);
    let mut system = System::new(model);
    let mut landscape = Landscape::new(&mut system, position)?;
    let size = velocity.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if landscape.steady.iter().zip(velocity).any(|(steady, v)| (steady - v).abs() > 1e-9 * size) {
        return Ok(None);
    }
    let place = Place::at(&mut landscape, position.clone())?;
    let (relative, worst) = place.residual();
    let residual = worst.filter(|_| !place.is_balanced()).map(|worst| Residual {
        relative,
        force: place.force[worst],
        hinge: model.label(landscape.free[worst]),
    });
    let pushes = landscape.system().constraints().map_or(Vec::new(), Constraints::by_element);
    Ok(Some(Balance { residual, pushes }))
}
