//! The last digits of a balance.

use crate::dynamics::Fault;
use crate::statics::effort::Iteration;
use crate::statics::problem::Landscape;
use crate::statics::problem::place::{BALANCED, Place, SHIFT};

/// Newton steps while they still halve the residual: from balanced to the last digits. The best place is kept. What is
/// above [`BALANCED`] is not taken for round-off before no step halves it.
pub(in crate::statics) fn polish(
    landscape: &mut Landscape<'_>,
    mut place: Place,
    history: &mut Vec<Iteration>,
) -> Result<Place, Fault> {
    // Zero-stiffness motions make the stiffness singular: a shift far below the stiffness of all others keeps the
    // step finite, and delays the residual by as little as it is smaller.
    let mut part = 0.0;
    for _ in 0..10 {
        // Loops may hide a small force behind the large ones that they hold: it is taken down to their round-off.
        let done = if landscape.ties.is_some() { place.is_round_off() } else { place.is_exact() };
        if done && place.residual().0 <= BALANCED {
            break;
        }
        landscape.look(&place.q)?;
        let shift = landscape.shift(&place, part);
        let better = match landscape.newton_shifted(&place.force, &shift) {
            Some(step) => improved(landscape, &place, &step)?.map(|next| (next, step)),
            None => None,
        };
        match better {
            Some((next, step)) => {
                place = next;
                let (residual, step) = (place.residual().0, landscape.size(&step));
                history.push(Iteration { stage: "polish", residual, step, shift: 0.0 });
            }
            None if part == 0.0 => part = SHIFT,
            None => break,
        }
    }
    Ok(place)
}

/// The place after a step, where that at least halves the residual. What balances up to round-off is not left for less in
/// one coordinate and more than round-off in another.
fn improved(landscape: &mut Landscape<'_>, place: &Place, step: &[f64]) -> Result<Option<Place>, Fault> {
    let q = landscape.moved(&place.q, step);
    let kept = |next: &Place| next.is_balanced() || !place.is_balanced();
    Ok(Place::at(landscape, q).ok().filter(|next| next.residual().0 <= 0.5 * place.residual().0 && kept(next)))
}
