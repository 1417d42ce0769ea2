//! The search for an equilibrium from a guess.
//!
//! | want | loads have a potential | first stage |
//! |---|---|---|
//! | stable | yes | Newton within a trust region, down the potential; saddles are left |
//! | stable | no | Newton with line search; what runs away is left with the motion itself |
//! | any | either | Newton with line search: the nearest equilibrium, whatever it is |
//!
//! Where that fails, later stages of the [`cascade`] take over: continuation in the load, then dynamic relaxation.

mod bounded;
mod cascade;
pub(super) mod curve;
mod free;
mod newton;
mod polish;
mod release;
mod saddle;
mod trust_region;
mod turns;

use super::certify::equilibrium::{Equilibrium, certify};
use super::certify::falling::falling;
use super::certify::{bearing, weak};
use super::effort::Effort;
use super::problem::Landscape;
use super::problem::place::Place;
use super::settings::{Method, Settings};
use super::watch::Watch;
use crate::dynamics::{Fault, System};
use crate::model::Model;
use free::search_free;
use std::sync::Arc;

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
    let mut found = turns::search(model, settings, start, watch, searched, trail.as_mut())?;
    weak::examine_weak(model, settings, &mut found)?;
    Ok((found, trail.unwrap_or_default()))
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
    let (model, position) = &bearing::bearing(model, position);
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
