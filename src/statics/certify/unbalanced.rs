//! What is not balanced, named: hinge, body, force and direction.

use crate::dynamics::Fault;
use crate::force::Act;
use crate::model::problem::rounded;
use crate::statics::problem::place::Place;
use crate::statics::problem::{Landscape, slides};
use nalgebra::Vector3;
use std::sync::Arc;

/// Points this near to each other are in one place: part of the scene's length.
const ONE_PLACE: f64 = 1e-5;

/// Names what is not balanced: hinge, body, force and direction.
///
/// # Errors
/// The element whose numbers are not finite.
pub(in crate::statics) fn unbalanced(landscape: &mut Landscape<'_>, place: &Place) -> Result<String, Fault> {
    let largest = place.most_unbalanced(|free| landscape.unit(free));
    if let (Some(taut), Some(largest)) = (landscape.taut(place)?, largest) {
        let worst = taut.worst.unwrap_or(largest);
        let names = taut.names.join(", ");
        return Ok(format!(
            "nothing balances {}: it acts across {names}, which are taut there and bear no finite force that way: rows that are \
             linearly dependent hold such a motion to second order only. Let them sag or slope, brace across them, or put a spring in \
             the place of one",
            describe(landscape, place, worst)
        ));
    }
    if let (Some(name), Some(largest)) = (pulled_together(landscape, place), largest) {
        return Ok(format!(
            "nothing balances {}: `{name}` has pulled two of its points into one place, where its direction is not determined. Make it longer, or stop \
             what it pulls before it gets there",
            describe(landscape, place, largest)
        ));
    }
    let Some(worst) = unresisted(landscape, place).or(largest) else { return Ok("no residual".to_owned()) };
    Ok(format!(
        "nothing balances {}: a spring, a load or a lock is missing, or the guess is too far away",
        describe(landscape, place, worst)
    ))
}

/// A spring or rope whose points are in one place, but for what a search leaves.
fn pulled_together(landscape: &mut Landscape<'_>, place: &Place) -> Option<String> {
    let (within, steady) = (ONE_PLACE * landscape.model().length_scale(), landscape.steady.clone());
    let at = landscape.system().at(0.0, &place.q, &steady);
    let links = &at.motion().links;
    let pulled = at.system().forces().iter().find(|force| force.law.in_one_place(links, within));
    pulled.map(|force| force.name.clone())
}

/// An unbalanced force with its hinge, direction and size.
pub(in crate::statics) fn describe(landscape: &mut Landscape<'_>, place: &Place, worst: usize) -> String {
    let relative = place.force[worst].abs() / place.scales.force[worst];
    let share = match relative {
        relative if !relative.is_finite() => "no other force is there".to_owned(),
        relative if relative >= 0.01 => format!("{:.0} % of the forces there", 100.0 * relative),
        relative => format!("{relative:.1e} of the forces there"),
    };
    let (model, coordinate) = (&Arc::clone(landscape.model()), landscape.free[worst]);
    let size = rounded(place.force[worst]);
    let unit = if slides(model)[coordinate] { "N" } else { "N m" };
    let direction = direction(landscape, place, coordinate);
    let towards = direction.map_or(String::new(), |d| format!(" along [{:.3}, {:.3}, {:.3}]", d.x, d.y, d.z));
    format!("{size} {unit} in {}{towards} ({share})", model.label(coordinate))
}

/// The coordinate whose force nothing resists: a shifted solve leaves it to the shift, `σ B x` with `(K + σB) x = f`,
/// while it hands every other force to the stiffness. `None` if the stiffness resists them all.
fn unresisted(landscape: &mut Landscape<'_>, place: &Place) -> Option<usize> {
    landscape.look(&place.q).ok()?;
    let curvatures = place.scales.stiffness.iter().zip(&landscape.metric).map(|(k, b)| k / b);
    let sigma = 1e-8 * curvatures.fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let shift: Vec<f64> = landscape.metric.iter().map(|b| sigma * b).collect();
    let x = landscape.newton_shifted(&place.force, &shift)?;
    let left = |i: usize| (shift[i] * x[i]).abs() / place.scales.force[i].max(f64::MIN_POSITIVE);
    let largest = (0..x.len()).map(left).fold(0.0, f64::max);
    // Of several that nothing resists a force says more than its moment.
    let slides = slides(landscape.model());
    let equals = (0..x.len()).filter(|i| left(*i) >= 0.99 * largest);
    (largest > 1e-3).then(|| equals.min_by_key(|i| !slides[landscape.free[*i]]))?
}

/// The axis of a single coordinate in inertial axes; one of the link's axes for a ball; none for strains of a beam.
fn direction(landscape: &mut Landscape<'_>, place: &Place, coordinate: usize) -> Option<Vector3<f64>> {
    let model = &Arc::clone(landscape.model());
    let (index, link) = model.links.iter().enumerate().skip(1).find(|(_, link)| {
        let (_, count) = link.joint.counts();
        !link.joint.is_flex() && (link.velocity..link.velocity + count).contains(&coordinate)
    })?;
    let steady = landscape.steady.clone();
    let at = landscape.system().at(0.0, &place.q, &steady);
    let motion = &at.motion().links[index];
    let (_, count) = link.joint.counts();
    Some(if count == 1 { motion.axis } else { motion.turn.column(coordinate - link.velocity).into_owned() })
}
