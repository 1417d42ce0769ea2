//! The cascade: one stage after the other until one of them ends in balance. None has anything to tune.
//!
//! | stage | goes | needs |
//! |---|---|---|
//! | `trust region` | down the potential, out of saddles | a stable equilibrium is wanted, loads have a potential |
//! | `newton` | to the nearest balance | else |
//! | `release` | from the guess, held by forces, along the curve on which these are let go | the first one failed |
//! | `trust region` | down the potential after all | the nearest one was wanted, loads have a potential, that failed |
//! | `relaxation` | with the motion itself, kinetic damping, then Newton's steps | those failed too |
//!
//! A search down the potential that fell without end says that there is nothing downhill; it is not followed by others.

use super::polish::polish;
use super::{newton, release, trust_region};
use crate::dynamics::Fault;
use crate::model::Model;
use crate::model::problem::number;
use crate::statics::baseline::{lagrange, relaxation};
use crate::statics::certify::closed;
use crate::statics::certify::falling::Fall;
use crate::statics::certify::stability::{MOST_DENSE, StabilityVerdict, classify};
use crate::statics::effort::{Effort, Iteration, Stage};
use crate::statics::problem::Landscape;
use crate::statics::problem::place::Place;
use crate::statics::settings::{Method, Settings, Want};

/// Saddles that are left after Newton's last steps.
const MOST_SADDLES: usize = 20;

/// Time steps that the last stage may take, and sweeps over one link: a large scene that fails says so in some tens of
/// seconds. Hanging chains need 60 steps per link.
const RELAXATION_STEPS: usize = 30_000;

const RELAXATION_SWEEPS: usize = 30_000_000;

/// Time steps, and sweeps over one link, that an unstable equilibrium of loads without a potential may take to be left for a stable
/// one: there may be none, and what flutters never comes to rest.
pub(super) const LEAVING_STEPS: usize = 10_000;

pub(super) const LEAVING_SWEEPS: usize = 300_000;

/// Where a search ended.
pub(in crate::statics) struct Found {
    pub place: Place,
    pub notes: Vec<String>,
    pub effort: Effort,
}

/// Runs the method that is asked for.
pub(in crate::statics) fn search(
    landscape: &mut Landscape<'_>,
    settings: &Settings,
    first: Place,
    history: &mut Vec<Iteration>,
) -> Result<Found, Fault> {
    match settings.method {
        Method::Relaxation => {
            let outcome = relaxation::run(landscape, first, relaxation::MOST_STEPS, history)?;
            let (steps, accelerations) = (Some(outcome.steps), outcome.accelerations);
            let effort = Effort { stage: "relaxation", steps, accelerations, ..Effort::default() };
            Ok(Found { place: outcome.place, notes: outcome.note.map(str::to_owned).into_iter().collect(), effort })
        }
        Method::Lagrange => {
            let outcome = lagrange::run(landscape, first, history)?;
            let notes = outcome.note.map(str::to_owned).into_iter().collect();
            let lagrange::Outcome { place, stage, reactions, force_evaluations: forces, factorizations, .. } = outcome;
            Ok(Found { place, notes, effort: Effort { stage, forces, factorizations, reactions, ..Effort::default() } })
        }
        Method::Newton => {
            if first.is_exact() {
                return Ok(Found::at_once(first));
            }
            let place = newton::run(landscape, first, history)?;
            let place = polish(landscape, place, history)?;
            Ok(Found { place, notes: Vec::new(), effort: Effort { stage: "newton", ..Effort::default() } })
        }
        Method::Auto => {
            if landscape.taut(&first)?.is_some_and(|taut| taut.rigid) {
                return Ok(Found::at_once(first));
            }
            let mut cascade = Cascade::new(landscape, history, &first);
            let descends = settings.want == Want::Stable && cascade.landscape.conservative;
            let found = if descends { cascade.descend(first)? } else { cascade.nearest(first)? };
            match descends || settings.want == Want::Any {
                true => Ok(found),
                false => cascade.leave_unstable(found),
            }
        }
    }
}

/// A minimum of the potential within limits that the landscape heeds: the first stage alone heeds them.
pub(in crate::statics) fn within_limits(
    landscape: &mut Landscape<'_>,
    first: Place,
    history: &mut Vec<Iteration>,
) -> Result<Found, Fault> {
    let mut cascade = Cascade::new(landscape, history, &first);
    let (place, fell) = cascade.trust_region(first)?;
    Ok(cascade.found(place, fell))
}

impl Found {
    fn at_once(place: Place) -> Self {
        Self { place, notes: Vec::new(), effort: Effort { stage: "start", ..Effort::default() } }
    }
}

struct Cascade<'c, 's> {
    landscape: &'c mut Landscape<'s>,
    history: &'c mut Vec<Iteration>,
    guess: Place,
    stages: Vec<Stage>,
    accelerations: usize,
    notes: Vec<String>,
    /// Counters where the running stage began: balances, factorizations, steps.
    before: (usize, usize, usize),
}

impl<'c, 's> Cascade<'c, 's> {
    fn new(landscape: &'c mut Landscape<'s>, history: &'c mut Vec<Iteration>, guess: &Place) -> Self {
        let before = (landscape.residuals, landscape.factorizations, history.len());
        let (guess, stages, notes) = (guess.clone(), Vec::new(), Vec::new());
        Self { landscape, history, guess, stages, accelerations: 0, notes, before }
    }

    /// Ends a stage that has taken this many steps, or as many as are in the history.
    fn ended(&mut self, name: &'static str, place: &Place, steps: Option<usize>) {
        let now = (self.landscape.residuals, self.landscape.factorizations, self.history.len());
        self.stages.push(Stage {
            name,
            iterations: steps.unwrap_or(now.2 - self.before.2),
            force_evaluations: now.0 - self.before.0,
            factorizations: now.1 - self.before.1,
            relative_residual: place.residual().0,
            balanced: place.is_balanced(),
        });
        self.before = now;
    }

    /// The end of the search. The stage that won is the last one.
    fn found(&mut self, place: Place, fell: bool) -> Found {
        let stages = std::mem::take(&mut self.stages);
        let stage = stages.last().map_or("start", |stage| stage.name);
        let steps = Some(stages.iter().map(|stage| stage.iterations).sum());
        let effort = Effort { stage, stages, steps, accelerations: self.accelerations, fell, ..Effort::default() };
        Found { place, notes: std::mem::take(&mut self.notes), effort }
    }

    /// A stable equilibrium of loads with a potential.
    fn descend(&mut self, first: Place) -> Result<Found, Fault> {
        let (place, fell) = self.trust_region(first)?;
        // No other way leads where rows push across a load.
        if place.is_balanced() || fell || self.landscape.taut(&place)?.is_some() {
            return Ok(self.found(place, fell));
        }
        for later in [Self::release, Self::relax] {
            if !self.landscape.goes_on() {
                break;
            }
            let place = later(self)?;
            if place.is_balanced() {
                // Balance may be a saddle: from there it goes on downhill.
                let (place, fell) = self.trust_region(place)?;
                return Ok(self.found(place, fell));
            }
        }
        Ok(self.found(place, false))
    }

    /// The nearest equilibrium.
    fn nearest(&mut self, first: Place) -> Result<Found, Fault> {
        if first.is_exact() {
            return Ok(Found::at_once(first));
        }
        let place = newton::run(self.landscape, first, self.history)?;
        let place = polish(self.landscape, place, self.history)?;
        self.ended("newton", &place, None);
        if place.is_balanced() {
            return Ok(self.found(place, false));
        }
        if !self.landscape.goes_on() {
            return Ok(self.found(place, false));
        }
        let released = self.release()?;
        if released.is_balanced() {
            return Ok(self.found(released, false));
        }
        // Downhill there is one, wherever it is.
        if self.landscape.conservative && self.landscape.goes_on() {
            let (down, fell) = self.trust_region(self.guess.clone())?;
            if down.is_balanced() || fell {
                return Ok(self.found(down, fell));
            }
        }
        if !self.landscape.goes_on() {
            return Ok(self.found(place, false));
        }
        let relaxed = self.relax()?;
        if relaxed.is_balanced() {
            return Ok(self.found(relaxed, false));
        }
        // Newton's place is the best that is left.
        Ok(self.found(place, false))
    }

    /// Where loads have no potential there is no downhill: an unstable equilibrium is left with the motion itself.
    fn leave_unstable(&mut self, found: Found) -> Result<Found, Fault> {
        let unstable = |landscape: &mut Landscape<'_>, place: &Place| -> Result<Option<Vec<f64>>, Fault> {
            let free = landscape.free.clone();
            if !place.is_balanced() || free.len() > MOST_DENSE {
                return Ok(None);
            }
            let stability = match landscape.ties.is_some() {
                true => closed::examine(landscape, place)?.1,
                false => {
                    Some(classify(landscape.system(), &place.q, &free, &place.scales.stiffness, false, None, None)?)
                }
            };
            let Some(stability) = stability else { return Ok(None) };
            let leaves = stability.verdict == StabilityVerdict::Unstable;
            let fastest = stability.modes.into_iter().max_by(|a, b| a.growth_rate.total_cmp(&b.growth_rate));
            Ok(fastest.filter(|_| leaves).map(|mode| mode.shape))
        };
        let Some(shape) = unstable(self.landscape, &found.place)? else { return Ok(found) };
        let mut found = found;
        self.stages.clone_from(&found.effort.stages);
        let part = 1e-2 * self.landscape.reach() / self.landscape.size(&shape);
        let beside: Vec<f64> = shape.iter().map(|x| part * x).collect();
        let q = self.landscape.moved(&found.place.q, &beside);
        let place = Place::at(self.landscape, q)?;
        let steps = LEAVING_STEPS.min(LEAVING_SWEEPS / self.landscape.model().links.len());
        let place = self.relax_from(place, steps)?;
        let still = place.is_balanced() && unstable(self.landscape, &place)?.is_none();
        if !still {
            let steps = self.stages.last().map_or(0, |stage| stage.iterations);
            let ended = match (self.landscape.goes_on(), place.is_balanced()) {
                (false, _) => "it was ended after",
                (true, true) => "another unstable one was met after",
                (true, false) => "none was reached in",
            };
            found.notes.push(format!(
                "loads without a potential have no downhill: a stable equilibrium was looked for with the motion that leaves the unstable \
                 one, and {ended} {steps} steps of it"
            ));
            found.notes.extend(self.landscape.watch.and_then(|watch| watch.note("relaxation", place.residual().0)));
            // The stage that won is the one before; what the other one worked is told.
            found.effort.steps = Some(self.stages.iter().map(|stage| stage.iterations).sum());
            found.effort.stages = std::mem::take(&mut self.stages);
            found.effort.accelerations += self.accelerations;
            return Ok(found);
        }
        self.notes.push("left an unstable equilibrium with the motion itself".to_owned());
        Ok(self.found(place, false))
    }

    /// Down the potential, and to the last digits. Newton's last steps may end in another balance where the potential is
    /// flat: from a saddle among those it goes on downhill.
    fn trust_region(&mut self, first: Place) -> Result<(Place, bool), Fault> {
        let (exact, start, potential) = (first.is_exact(), first.q.clone(), self.landscape.potential(&first.q));
        let before = self.history.len();
        let mut outcome = trust_region::run(self.landscape, first, self.history)?;
        let mut shifted = outcome.shifted;
        // Where the potential no longer tells anything, the forces do.
        if !outcome.place.is_balanced() && !outcome.fell && self.landscape.goes_on() {
            outcome.place = polish(self.landscape, outcome.place, self.history)?;
        }
        self.note_saddles(&outcome.left);
        if exact && self.history.len() == before {
            return Ok((outcome.place, false));
        }
        for _ in 0..MOST_SADDLES {
            if !outcome.place.is_balanced() {
                break;
            }
            let unwound = unwind(self.landscape.model(), &start, outcome.place.q);
            outcome.place = Place::at(self.landscape, unwound)?;
            outcome.place = polish(self.landscape, outcome.place, self.history)?;
            let next = trust_region::run(self.landscape, outcome.place.clone(), self.history)?;
            if next.left.is_empty() {
                break;
            }
            self.note_saddles(&next.left);
            (outcome, shifted) = (next, true);
        }
        if outcome.fell {
            let drop = number(potential - self.landscape.potential(&outcome.place.q));
            let known = super::beyond_curve(self.landscape.model(), &outcome.place.q);
            let known = known.or_else(|| outcome.fall.as_ref().map(Fall::note));
            self.notes.push(known.unwrap_or_else(|| {
                format!(
                    "the potential falls without end: the search gave up {drop} J below the guess, there is no equilibrium \
                     downhill of it"
                )
            }));
        }
        self.ended(if shifted { "trust region" } else { "newton" }, &outcome.place, None);
        Ok((outcome.place, outcome.fell))
    }

    fn note_saddles(&mut self, left: &[Vec<usize>]) {
        for coordinates in left {
            let names: Vec<String> = coordinates.iter().take(3).map(|i| self.landscape.model().label(*i)).collect();
            let more = if coordinates.len() > 3 { ", …" } else { "" };
            self.notes.push(format!("left an unstable equilibrium along {}{more}", names.join(", ")));
        }
    }

    fn release(&mut self) -> Result<Place, Fault> {
        let place = release::run(self.landscape, &self.guess, self.history)?;
        let place = polish(self.landscape, place, self.history)?;
        self.ended("release", &place, None);
        Ok(place)
    }

    fn relax(&mut self) -> Result<Place, Fault> {
        let steps = RELAXATION_STEPS.min(RELAXATION_SWEEPS / self.landscape.model().links.len());
        self.relax_from(self.guess.clone(), steps)
    }

    fn relax_from(&mut self, place: Place, steps: usize) -> Result<Place, Fault> {
        let outcome = relaxation::run(self.landscape, place, steps, self.history)?;
        self.accelerations += outcome.accelerations;
        let place = polish(self.landscape, outcome.place, self.history)?;
        self.ended("relaxation", &place, Some(outcome.steps));
        Ok(place)
    }
}

/// Takes off the full turns that the search made in hinges without springs, drives, gears and limits: the same pose, nearest to
/// the guess.
fn unwind(model: &Model, start: &[f64], mut q: Vec<f64>) -> Vec<f64> {
    use std::f64::consts::TAU;
    let tied: Vec<usize> = (model.drives.iter().map(|drive| drive.coordinate.velocity))
        .chain(model.gears.iter().flat_map(|gear| gear.coordinates.map(|coordinate| coordinate.velocity)))
        .chain(model.pushed().map(|coordinate| coordinate.velocity))
        .chain(model.stops.iter().map(|stop| stop.velocity))
        .collect();
    for link in &model.links {
        let spring = |at: usize| model.coordinates[at].stiffness != 0.0 || model.coordinates[at].force != 0.0;
        let counts = |at: usize| spring(at) || tied.contains(&at);
        if link.joint.is_turn() && !counts(link.velocity) {
            let turns = ((q[link.position] - start[link.position]) / TAU).round();
            if turns != 0.0 {
                q[link.position] -= turns * TAU;
            }
        }
    }
    q
}
