//! The critical cone of a balance on stops that bear nothing: such a stop keeps its coordinate from one side only.
//!
//! A stop that presses holds its coordinate to second order; one with `λ = 0` (weakly active) allows `s v ≤ 0`, `s` being its
//! side. With `I` the free coordinates and `W` those of the weakly active stops the balance is a minimum only if
//!
//! ```text
//! dᵀ K d ≥ 0  for all d_I and all d_W = −s v, v ≥ 0                                             (1)
//! S = K_WW − K_WI K_II⁻¹ K_IW:   K_II ≥ 0 and s S s copositive                                  (2)
//! d_I = −K_II⁻¹ K_IW d_W                                            the lowest for given d_W     (3)
//! K_II + μN in its place, N the sizes of its terms: what falls with μ falls without it            (4)
//! ```
//!
//! Motions without stiffness make `K_II` singular, and `μN` regular again.

use super::copositive;
use crate::dynamics::Fault;
use crate::statics::problem::place::Place;
use crate::statics::problem::sizes::{NEUTRAL, comparable, symmetric};
use crate::statics::problem::{Landscape, Weak};
use faer::Mat;

/// `μ` of (4). A motion that nothing but the coordinate of a stop stiffens makes a fall however small `v` is compared with it: with the
/// largest `μ` that leaves a fall both are of one size.
const SLACKS: [f64; 3] = [1e-3, 1e-6, NEUTRAL];

/// A direction off stops that bear nothing along which the potential falls or, to second order, stays as it is.
#[derive(Debug, Clone)]
pub(in crate::statics) struct Descent {
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
pub(in crate::statics) fn descent(landscape: &mut Landscape<'_>, place: &Place) -> Result<Option<Descent>, Fault> {
    Ok(weakest(landscape, place)?.filter(|found| found.falls))
}

/// As [`descent`]; if the potential falls in no direction, one in which it stays as it is: (2) is copositive, not strictly so.
///
/// # Errors
/// The element whose numbers are not finite.
pub(in crate::statics) fn weakest(landscape: &mut Landscape<'_>, place: &Place) -> Result<Option<Descent>, Fault> {
    let weak = landscape.weakly_active();
    if weak.is_empty() {
        return Ok(None);
    }
    let sizes: Vec<f64> = place.scales.stiffness.iter().copied().chain(weak.iter().map(|one| one.stiffness)).collect();
    let cone = Cone { columns: columns(landscape, place, &weak)?, sizes: comparable(&sizes), weak };
    landscape.look(&place.q)?;
    let mut last = None;
    for slack in SLACKS {
        let Some(responses) = cone.responses(landscape, slack) else { continue };
        let stiffness = cone.stiffness(&landscape.free, &responses);
        if let Some(v) = copositive::violation(&stiffness, NEUTRAL) {
            return Ok(Some(cone.descent(&landscape.free, &responses, &v, true)));
        }
        last = Some((stiffness, responses));
    }
    let Some((stiffness, responses)) = last else { return Ok(None) };
    let v = copositive::violation(&stiffness, -NEUTRAL);
    Ok(v.map(|v| cone.descent(&landscape.free, &responses, &v, false)))
}

/// `K e` for the coordinate of each stop.
fn columns(landscape: &mut Landscape<'_>, place: &Place, weak: &[Weak]) -> Result<Vec<Vec<f64>>, Fault> {
    let n = landscape.steady.len();
    let rest = landscape.steady.clone();
    let unit = Mat::from_fn(n, weak.len(), |i, j| f64::from(u8::from(weak[j].velocity == i)));
    let product = landscape.system().at(0.0, &place.q, &rest).stiffness_times(&unit)?;
    Ok((0..weak.len()).map(|j| (0..n).map(|i| product[(i, j)]).collect()).collect())
}

/// What (1) is about.
struct Cone {
    weak: Vec<Weak>,
    /// `K e` for the coordinate of each stop.
    columns: Vec<Vec<f64>>,
    /// Sizes of the stiffness terms of the free coordinates, then of those of the stops.
    sizes: Vec<f64>,
}

impl Cone {
    /// `−(K_II + μN)⁻¹ K_IW`, one list over the free coordinates for each stop; `None` if that is singular.
    fn responses(&self, landscape: &mut Landscape<'_>, slack: f64) -> Option<Vec<Vec<f64>>> {
        let free = landscape.free.clone();
        if free.is_empty() {
            return Some(vec![Vec::new(); self.weak.len()]);
        }
        let slack: Vec<f64> = self.sizes[..free.len()].iter().map(|size| slack * size).collect();
        landscape.newton_shifted(&vec![0.0; free.len()], &slack)?;
        let rhs = |column: &Vec<f64>| free.iter().map(|i| -column[*i]).collect::<Vec<f64>>();
        Some(self.columns.iter().map(|column| landscape.solve(&rhs(column))).collect())
    }

    /// Root of the size of the stiffness of each stop's coordinate.
    fn root(&self, k: usize) -> f64 {
        self.sizes[self.sizes.len() - self.weak.len() + k].sqrt()
    }

    /// `s S s` of (2), each row of the size of its own stiffness.
    fn stiffness(&self, free: &[usize], responses: &[Vec<f64>]) -> Mat<f64> {
        let Self { weak, columns, .. } = self;
        let entry = |a: usize, b: usize| {
            let through: f64 = free.iter().zip(&responses[b]).map(|(i, y)| columns[a][*i] * y).sum();
            let sides = weak[a].side.sign() * weak[b].side.sign();
            sides * (columns[b][weak[a].velocity] + through) / self.root(a) / self.root(b)
        };
        symmetric(&Mat::from_fn(weak.len(), weak.len(), entry))
    }

    /// The direction of `v`, with the free coordinates by (3).
    fn descent(&self, free: &[usize], responses: &[Vec<f64>], v: &[f64], falls: bool) -> Descent {
        let mut direction = vec![0.0; self.columns[0].len()];
        for (k, one) in self.weak.iter().enumerate() {
            let by = -one.side.sign() * v[k] / self.root(k);
            direction[one.velocity] += by;
            free.iter().zip(&responses[k]).for_each(|(i, y)| direction[*i] += by * y);
        }
        let leaving = self.weak.iter().zip(v).filter(|(_, v)| **v > 0.0).map(|(one, _)| one.velocity).collect();
        Descent { falls, leaving, direction }
    }
}
