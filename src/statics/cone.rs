//! The critical cone of a balance on stops that bear nothing: such a stop keeps its coordinate from one side only.
//!
//! A stop that presses holds its coordinate to second order; one with `λ = 0` (weakly active) allows `s v ≤ 0`, `s` being its
//! side. With `I` the free coordinates and `W` those of the weakly active stops the balance is a minimum only if
//!
//! ```text
//! dᵀ K d ≥ 0  for all d_I and all d_W = −s v, v ≥ 0                                             (1)
//! S = K_WW − K_WI K_II⁻¹ K_IW:   K_II ≥ 0 and s S s copositive                                  (2)
//! d_I = −K_II⁻¹ K_IW d_W                                            the lowest for given d_W     (3)
//! ```

use super::copositive;
use super::landscape::{Landscape, Weak};
use super::search::Place;
use super::stability::{NEUTRAL, comparable};
use crate::dynamics::Fault;
use faer::Mat;

/// A direction off stops that bear nothing along which the potential falls or, to second order, stays as it is.
#[derive(Debug, Clone)]
pub(super) struct Descent {
    /// Whether it falls.
    pub falls: bool,
    /// The coordinates that leave their stops.
    pub leaving: Vec<usize>,
    /// Over all velocity coordinates.
    pub direction: Vec<f64>,
}

/// A direction in which the potential falls at a balanced place whose active set was chosen last and whose free coordinates are
/// at a minimum; `None` when there is none.
///
/// # Errors
/// The element whose numbers are not finite.
pub(super) fn descent(landscape: &mut Landscape<'_>, place: &Place) -> Result<Option<Descent>, Fault> {
    Ok(weakest(landscape, place)?.filter(|found| found.falls))
}

/// As [`descent`]; if the potential falls in no direction, one in which it stays as it is: (2) is copositive, not strictly so.
///
/// # Errors
/// The element whose numbers are not finite.
pub(super) fn weakest(landscape: &mut Landscape<'_>, place: &Place) -> Result<Option<Descent>, Fault> {
    let weak = landscape.weakly_active();
    if weak.is_empty() {
        return Ok(None);
    }
    let columns = columns(landscape, place, &weak)?;
    let Some(responses) = responses(landscape, place, &weak, &columns)? else { return Ok(None) };
    // Eq. (2), each row of the size of its own stiffness.
    let size = |k: usize| if weak[k].stiffness > 0.0 { weak[k].stiffness.sqrt() } else { 1.0 };
    let entry = |a: usize, b: usize| {
        let through: f64 = landscape.free.iter().zip(&responses[b]).map(|(i, y)| columns[a][*i] * y).sum();
        weak[a].side * weak[b].side * (columns[b][weak[a].velocity] + through) / (size(a) * size(b))
    };
    let whole = Mat::from_fn(weak.len(), weak.len(), entry);
    let along = Mat::from_fn(weak.len(), weak.len(), |i, j| 0.5 * (whole[(i, j)] + whole[(j, i)]));
    let falling = copositive::violation(&along, NEUTRAL);
    let falls = falling.is_some();
    let Some(v) = falling.or_else(|| copositive::violation(&along, -NEUTRAL)) else { return Ok(None) };
    let mut direction = vec![0.0; columns[0].len()];
    for (k, one) in weak.iter().enumerate() {
        let by = -one.side * v[k] / size(k);
        direction[one.velocity] += by;
        // Eq. (3).
        landscape.free.iter().zip(&responses[k]).for_each(|(i, y)| direction[*i] += by * y);
    }
    let leaving = weak.iter().zip(&v).filter(|(_, v)| **v > 0.0).map(|(one, _)| one.velocity).collect();
    Ok(Some(Descent { falls, leaving, direction }))
}

/// `K e` for the coordinate of each stop.
fn columns(landscape: &mut Landscape<'_>, place: &Place, weak: &[Weak]) -> Result<Vec<Vec<f64>>, Fault> {
    let n = landscape.steady.len();
    let rest = landscape.steady.clone();
    let unit = Mat::from_fn(n, weak.len(), |i, j| f64::from(u8::from(weak[j].velocity == i)));
    let product = landscape.system().stiffness_times(&place.q, &rest, &unit)?;
    Ok((0..weak.len()).map(|j| (0..n).map(|i| product[(i, j)]).collect()).collect())
}

/// `−K_II⁻¹ K_IW`, one list over the free coordinates for each stop. Motions without stiffness make `K_II` singular: what counts
/// as none is added to it.
fn responses(
    landscape: &mut Landscape<'_>,
    place: &Place,
    weak: &[Weak],
    columns: &[Vec<f64>],
) -> Result<Option<Vec<Vec<f64>>>, Fault> {
    let free = landscape.free.clone();
    if free.is_empty() {
        return Ok(Some(vec![Vec::new(); weak.len()]));
    }
    landscape.look(&place.q)?;
    let sizes: Vec<f64> = place.scales.stiffness.iter().copied().chain(weak.iter().map(|one| one.stiffness)).collect();
    let slack: Vec<f64> = comparable(&sizes)[..free.len()].iter().map(|size| NEUTRAL * size).collect();
    if landscape.newton_shifted(&vec![0.0; free.len()], &slack).is_none() {
        return Ok(None);
    }
    let rhs = |column: &Vec<f64>| free.iter().map(|i| -column[*i]).collect::<Vec<f64>>();
    Ok(Some(columns.iter().map(|column| landscape.solve(&rhs(column))).collect()))
}
