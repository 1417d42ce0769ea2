//! Leaving an equilibrium that runs away on one side of what is one-sided there: stops that bear nothing, kinks of forces.
//!
//! Its stiffness on the stops that are touched, and on one side of kinks, does not show it, and no search that goes by the stiffness
//! leaves it. The certificate finds the motion that does (`certify::sided`): down the potential along it, or if there is none with
//! the motion itself, and from there the search begins again.

use super::active::gates;
use super::cascade::{LEAVING_STEPS, LEAVING_SWEEPS};
use super::free::search_free;
use super::saddle::downhill;
use super::{Search, turns};
use crate::dynamics::{Fault, System};
use crate::model::Model;
use crate::statics::baseline::relaxation;
use crate::statics::certify::bearing::{self, Set};
use crate::statics::certify::equilibrium::Equilibrium;
use crate::statics::certify::sides::Leaving;
use crate::statics::certify::weak;
use crate::statics::problem::Landscape;
use crate::statics::problem::place::Place;
use crate::statics::settings::{Method, Want};
use std::sync::Arc;

/// How many equilibria a search leaves: each is lower than the one before, and a scene has few of them on its edges.
const MOST: usize = 20;
/// The first part of a motion without a potential (part of a radian, or of the scene's length, of every coordinate): the motion that is
/// followed grows from there.
const FIRST: f64 = 1e-2;

/// The equilibrium with the stops heeded, and one that no motion leaves on any side if there is a way to it.
pub(super) fn search(mut search: Search<'_>) -> Result<Equilibrium, Fault> {
    let Search { model, settings, watch, .. } = search;
    let of = |search: Search<'_>| match search.model.stops.is_empty() {
        true => search_free(search),
        false => turns::search(search),
    };
    let mut found = of(search.again())?;
    let mut left: Vec<String> = Vec::new();
    let end = |mut found: Equilibrium, left: Vec<String>| {
        found.notes.splice(0..0, left);
        found
    };
    loop {
        let Some((leaving, pressed)) = weak::examine(model, settings, &mut found)? else {
            return Ok(end(found, left));
        };
        let leaves = settings.want == Want::Stable && settings.method == Method::Auto;
        if !leaves || left.len() == MOST || !watch.goes_on() {
            return Ok(end(found, left));
        }
        let Some(start) = beside(model, &pressed, &found, &leaving)? else { return Ok(end(found, left)) };
        let next = of(search.of(model, &start))?;
        if !next.balanced {
            return Ok(end(found, left));
        }
        left.push(format!("left an unstable equilibrium along {}", leaving.names.join(", ")));
        found = turns::after(&found, next);
    }
}

/// A place on the way of a motion that leaves an equilibrium; `None` if there is none.
fn beside(
    model: &Arc<Model>,
    pressed: &Set,
    found: &Equilibrium,
    leaving: &Leaving,
) -> Result<Option<Vec<f64>>, Fault> {
    let Some((freed, q)) = bearing::with(model, pressed, &found.position) else { return Ok(None) };
    let mut system = System::new(&freed);
    let mut landscape = Landscape::new(&mut system, &q)?;
    let place = Place::at(&mut landscape, q)?;
    let direction: Vec<f64> = landscape.free.iter().map(|i| leaving.direction[*i]).collect();
    let radius = landscape.reach();
    if landscape.conservative {
        landscape.fence(gates(model, pressed));
        let potential = landscape.potential(&place.q);
        let way = downhill(&mut landscape, &place, &direction, potential, radius);
        return Ok(way.map(|way| landscape.moved(&place.q, &way.step)));
    }
    let part = FIRST * radius / landscape.size(&direction);
    let step: Vec<f64> = direction.iter().map(|x| part * x).collect();
    let q = landscape.moved(&place.q, &step);
    if q.iter().any(|x| !x.is_finite()) {
        return Ok(None);
    }
    let place = Place::at(&mut landscape, q)?;
    let steps = LEAVING_STEPS.min(LEAVING_SWEEPS / model.links.len());
    let place = relaxation::run(&mut landscape, place, steps, &mut Vec::new())?.place;
    Ok(place.q.iter().all(|x| x.is_finite()).then_some(place.q))
}
