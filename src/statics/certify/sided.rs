//! Balances at which forces are one-sided: stops that are touched and bear nothing, and kinks of springs and motors.
//!
//! The rows `a` of all of them, `a·x > 0` leading into a stop or beyond a kink, divide the motions `x` of the balance, those along
//! loops, drives and gears, into cones. Within a rigid stop there are none; in each of the others the stiffness is one matrix:
//!
//! ```text
//! (1)  Kₚ = K + Σ κ a aᵀ,     κ: what a compliant stop or a kink adds on the side of it that the cone p is on
//! (2)  X = (K + μN)⁻¹ Aᵀ C⁻¹,   C = A (K + μN)⁻¹ Aᵀ          the lowest motions with A X = 1; A has rows that are independent
//! (3)  S = Xᵀ K X,   Sₚ = S + Σ κ t tᵀ,   a = Aᵀ t             what is seen of (1) where everything else gives way
//! (4)  v = R α, α ≥ 0 with the rays R of the cone p (see `rays`):   Rᵀ Sₚ R copositive on every cone
//! ```
//!
//! Loads with a potential are at a minimum only if (4) holds, given that the motions along all rows, `A x = 0`, are. `N` are the sizes
//! of the terms of `K`; motions without stiffness make it singular, and `μN` regular again: what falls with `X` falls, whatever `μ` is.
//! Other loads are judged by their motion, see `growing`.

use super::copositive;
use super::growing::{self, Along};
use super::motion::{LinearMotion, is_fed};
use super::rays::rays;
use super::sides::{Beyond, Leaving, Sided, Sides, cones};
use super::stability::MOST_DENSE;
use crate::dynamics::{Fault, Linearization, System};
use crate::model::Model;
use crate::round_off::EIGENVECTOR;
use crate::statics::problem::Landscape;
use crate::statics::problem::place::Place;
use crate::statics::problem::sizes::{NEUTRAL, comparable, count_by_stiffness, symmetric};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use std::sync::Arc;

/// `μ` of (2): with the largest that leaves a fall what leaves a row and what follows it are of one size. `S` errs by the square of it, and
/// by the round-off over it, since the inverse of `C` keeps no more digits beside motions without stiffness: both are below [`NEUTRAL`] with the last.
const SLACKS: [f64; 2] = [1e-3, 1e-6];
/// A row is linearly dependent on others if no more than this part of its square is across them: a coordinate that moves by 10⁻⁶ of
/// what the others do follows from how exactly loops are closed.
const DEPENDENT: f64 = 1e-12;

/// Looks at the motions on all sides of the rows at a balance of a model without stops, all other motions coming back.
///
/// # Errors
/// The element whose numbers are not finite.
pub(in crate::statics) fn look(model: &Arc<Model>, q: &[f64], sided: &[Sided]) -> Result<Sides, Fault> {
    let mut system = System::new(model);
    let mut landscape = Landscape::new(&mut system, q)?;
    let place = Place::at(&mut landscape, q.to_vec())?;
    let all = spread(&landscape, sided);
    let Some(rows) = Rows::of(&mut landscape, q, &all)? else { return Ok(Sides::Hold) };
    let sided: Vec<Sided> = rows.kept.iter().map(|index| sided[*index].clone()).collect();
    if landscape.conservative && landscape.steady.iter().all(|v| *v == 0.0) {
        return fall(&mut landscape, &place, &rows, &sided);
    }
    if landscape.free.len() > MOST_DENSE {
        return Ok(Sides::Unknown);
    }
    growing::look(&mut landscape, &place, (&rows.all, &rows.sizes), &sided)
}

/// How many motions along all rows run away and how many have no stiffness, at a balance of a model without stops; `None` if it is too
/// large to be looked at, or if something feeds a motion about a balance of loads that have a potential: [`look`] goes by that alone.
///
/// # Errors
/// The element whose numbers are not finite.
pub(in crate::statics) fn along_all(
    model: &Arc<Model>,
    q: &[f64],
    sided: &[Sided],
) -> Result<Option<(usize, usize)>, Fault> {
    let mut system = System::new(model);
    let mut landscape = Landscape::new(&mut system, q)?;
    if landscape.free.len() > MOST_DENSE {
        return Ok(None);
    }
    let place = Place::at(&mut landscape, q.to_vec())?;
    let moving = Along::at(&mut landscape, q, &place.scales.stiffness)?;
    let by_potential = landscape.conservative && landscape.steady.iter().all(|v| *v == 0.0);
    if by_potential && is_fed(&moving.linear) {
        return Ok(None);
    }
    let root: Vec<f64> = comparable(&moving.sizes).iter().map(|size| size.sqrt()).collect();
    let n = root.len();
    // In coordinates in which the sizes are one, rows of unit length.
    let scaled = |full: &Vec<f64>| {
        let row: Vec<f64> = moving.row(full).iter().zip(&root).map(|(a, root)| a / root).collect();
        let length = row.iter().map(|a| a * a).sum::<f64>().sqrt();
        (length > 0.0).then(|| row.iter().map(|a| a / length).collect::<Vec<f64>>())
    };
    let rows: Vec<Vec<f64>> = spread(&landscape, sided).iter().filter_map(scaled).collect();
    let squares = Mat::from_fn(n, n, |i, j| rows.iter().map(|row| row[i] * row[j]).sum::<f64>());
    let Ok(eigen) = squares.self_adjoint_eigen(Side::Lower) else { return Ok(None) };
    let left: Vec<usize> = (0..n).filter(|k| eigen.S()[*k] <= EIGENVECTOR.of(rows.len() as f64)).collect();
    if left.is_empty() {
        return Ok(Some((0, 0)));
    }
    let basis = Mat::from_fn(n, left.len(), |i, j| eigen.U()[(i, left[j])] / root[i]);
    let along = |m: &Mat<f64>| basis.transpose() * m * &basis;
    let Linearization { stiffness, damping, mass } = &moving.linear;
    let stiffness = along(stiffness);
    Ok(Some(match by_potential {
        true => count_by_stiffness(&symmetric(&stiffness), &vec![1.0; left.len()]),
        false => LinearMotion::open(&Linearization { stiffness, damping: along(damping), mass: along(mass) }).count(),
    }))
}

/// The rows over free coordinates.
fn spread(landscape: &Landscape<'_>, sided: &[Sided]) -> Vec<Vec<f64>> {
    let mut at = vec![usize::MAX; landscape.steady.len()];
    landscape.free.iter().enumerate().for_each(|(row, i)| at[*i] = row);
    let one = |one: &Sided| {
        let mut full = vec![0.0; landscape.free.len()];
        one.row.iter().filter(|(i, _)| at[*i] != usize::MAX).for_each(|(i, value)| full[at[*i]] = *value);
        full
    };
    sided.iter().map(one).collect()
}

/// Rows that some motion changes, each of the size of one in the metric, and which of them are linearly independent.
struct Rows {
    /// Over free coordinates.
    all: Vec<Vec<f64>>,
    /// The size that each had.
    sizes: Vec<f64>,
    /// Their indices.
    kept: Vec<usize>,
    /// Of those that are kept the linearly independent ones: `A`.
    basis: Vec<usize>,
    /// `t` of (3) for each that is kept.
    by_basis: Vec<Vec<f64>>,
}

impl Rows {
    /// `None` if no motion changes any.
    fn of(landscape: &mut Landscape<'_>, q: &[f64], given: &[Vec<f64>]) -> Result<Option<Self>, Fault> {
        let metric = landscape.metric.clone();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (mut all, mut motions, mut sizes, mut kept) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (index, row) in given.iter().enumerate() {
            let square: f64 = row.iter().zip(&metric).map(|(a, b)| a * a / b).sum();
            let motion: Vec<f64> =
                landscape.along_rows(q, row)?.iter().zip(&metric).map(|(force, b)| force / b).collect();
            let along = dot(row, &motion);
            if along > DEPENDENT * square {
                let size = along.sqrt();
                all.push(row.iter().map(|a| a / size).collect::<Vec<f64>>());
                motions.push(motion.iter().map(|x| x / size).collect::<Vec<f64>>());
                sizes.push(size);
                kept.push(index);
            }
        }
        let gram = Mat::from_fn(all.len(), all.len(), |i, j| dot(&all[i], &motions[j]));
        let basis = independent(&gram);
        let inner = Mat::from_fn(basis.len(), basis.len(), |i, j| gram[(basis[i], basis[j])]);
        let outer = Mat::from_fn(basis.len(), all.len(), |i, j| gram[(basis[i], j)]);
        let by_basis = inner.partial_piv_lu().solve(&outer);
        let by_basis = (0..all.len()).map(|j| (0..basis.len()).map(|i| by_basis[(i, j)]).collect()).collect();
        Ok((!all.is_empty()).then_some(Self { all, sizes, kept, basis, by_basis }))
    }

    /// The two stiffnesses of a row of this size.
    fn stiffness(&self, k: usize, one: &Sided) -> Option<[f64; 2]> {
        match one.beyond {
            Beyond::Nothing => None,
            Beyond::Stiffness(both) => Some(both.map(|stiffness| stiffness * self.sizes[k].powi(2))),
        }
    }
}

/// Rows of a Gram matrix that are linearly independent, the clearest first.
fn independent(gram: &Mat<f64>) -> Vec<usize> {
    let n = gram.nrows();
    let (mut left, mut basis) = (gram.clone(), Vec::new());
    while let Some(best) = (0..n).max_by(|a, b| left[(*a, *a)].total_cmp(&left[(*b, *b)])) {
        let pivot = left[(best, best)];
        if !(pivot > DEPENDENT) {
            break;
        }
        basis.push(best);
        left = Mat::from_fn(n, n, |i, j| left[(i, j)] - left[(i, best)] * left[(best, j)] / pivot);
        (0..n).for_each(|i| (left[(i, best)], left[(best, i)]) = (0.0, 0.0));
    }
    basis
}

/// What (4) says: a motion that leaves is one that falls, or else one that stays as it is.
fn fall(landscape: &mut Landscape<'_>, place: &Place, rows: &Rows, sided: &[Sided]) -> Result<Sides, Fault> {
    landscape.look(&place.q)?;
    // Where nothing has any stiffness all sizes are as good.
    let sizes = match place.scales.stiffness.iter().all(|size| *size == 0.0) {
        true => landscape.metric.clone(),
        false => comparable(&place.scales.stiffness),
    };
    let mut all = Vec::new();
    for slack in SLACKS {
        let Some(seen) = Seen::of(landscape, rows, &sizes, slack) else { continue };
        if let Some(v) = seen.violation(rows, sided, NEUTRAL) {
            return Ok(Sides::Leave(seen.leaving(landscape, rows, sided, &v, true)));
        }
        all.push(seen);
    }
    let stays = |seen: &Seen| {
        let v = seen.violation(rows, sided, -NEUTRAL)?;
        Some(seen.leaving(landscape, rows, sided, &v, false))
    };
    // Nothing is seen through a stiffness that is singular with both.
    let otherwise = if all.is_empty() { Sides::Unknown } else { Sides::Hold };
    Ok(all.iter().find_map(stays).map_or(otherwise, Sides::Leave))
}

/// (2) and (3).
struct Seen {
    /// The columns of `X`.
    responses: Vec<Vec<f64>>,
    /// `S`
    stiffness: Mat<f64>,
    /// `Xᵀ N X`
    sizes: Mat<f64>,
}

impl Seen {
    fn of(landscape: &mut Landscape<'_>, rows: &Rows, sizes: &[f64], slack: f64) -> Option<Self> {
        let rank = rows.basis.len();
        let shift: Vec<f64> = sizes.iter().map(|size| slack * size).collect();
        landscape.newton_shifted(&vec![0.0; sizes.len()], &shift)?;
        let solved: Vec<Vec<f64>> = rows.basis.iter().map(|k| landscape.solve(&rows.all[*k])).collect();
        let entry = |i: usize, j: usize| rows.all[rows.basis[i]].iter().zip(&solved[j]).map(|(a, x)| a * x).sum();
        let compliance = symmetric(&Mat::from_fn(rank, rank, entry));
        let inverse = symmetric(&compliance.partial_piv_lu().solve(Mat::<f64>::identity(rank, rank)));
        let combined = |j: usize| {
            let mut x = vec![0.0; sizes.len()];
            (0..rank).for_each(|i| x.iter_mut().zip(&solved[i]).for_each(|(x, y)| *x += inverse[(i, j)] * y));
            x
        };
        let responses: Vec<Vec<f64>> = (0..rank).map(combined).collect();
        let size = |i: usize, j: usize| {
            let both = responses[i].iter().zip(&responses[j]);
            both.zip(sizes).map(|((x, y), size)| x * y * size).sum::<f64>()
        };
        let sizes = Mat::from_fn(rank, rank, size);
        let stiffness = &inverse - &sizes * slack;
        let finite = |m: &Mat<f64>| (0..rank).all(|i| (0..rank).all(|j| m[(i, j)].is_finite()));
        (finite(&stiffness) && finite(&sizes)).then_some(Self { responses, stiffness, sizes })
    }

    /// `v` of (4) with a form below `−least` of its terms.
    fn violation(&self, rows: &Rows, sided: &[Sided], least: f64) -> Option<Vec<f64>> {
        cones(sided).into_iter().find_map(|sides| self.violated(rows, sided, &sides, least))
    }

    fn violated(&self, rows: &Rows, sided: &[Sided], sides: &[bool], least: f64) -> Option<Vec<f64>> {
        let rank = rows.basis.len();
        let (mut form, mut sizes) = (self.stiffness.clone(), self.sizes.clone());
        for (k, one) in sided.iter().enumerate() {
            let Some(both) = rows.stiffness(k, one) else { continue };
            let (stiffness, t) = (both[usize::from(sides[k])], &rows.by_basis[k]);
            form = Mat::from_fn(rank, rank, |i, j| form[(i, j)] + stiffness * t[i] * t[j]);
            sizes = Mat::from_fn(rank, rank, |i, j| sizes[(i, j)] + stiffness.abs() * t[i] * t[j]);
        }
        let signed = |k: &usize| {
            let sign = if sides[*k] { -1.0 } else { 1.0 };
            rows.by_basis[*k].iter().map(|t| sign * t).collect::<Vec<f64>>()
        };
        let others = (0..sided.len()).filter(|k| !rows.basis.contains(k)).collect::<Vec<usize>>();
        let cone: Vec<Vec<f64>> = rows.basis.iter().chain(&others).map(signed).collect();
        // A cone without a ray is a point.
        let rays = rays(&cone, rank).filter(|rays| !rays.is_empty())?;
        let product = |m: &Mat<f64>, a: &[f64], b: &[f64]| -> f64 {
            (0..rank).map(|i| a[i] * (0..rank).map(|j| m[(i, j)] * b[j]).sum::<f64>()).sum()
        };
        let roots: Vec<f64> = rays.iter().map(|ray| product(&sizes, ray, ray).sqrt()).collect();
        let entry = |i: usize, j: usize| product(&form, &rays[i], &rays[j]) / roots[i] / roots[j];
        let alpha = copositive::violation(&symmetric(&Mat::from_fn(rays.len(), rays.len(), entry)), least)?;
        let along = |i: usize| rays.iter().zip(&alpha).zip(&roots).map(|((ray, a), root)| a * ray[i] / root).sum();
        Some((0..rank).map(along).collect())
    }

    fn leaving(&self, landscape: &Landscape<'_>, rows: &Rows, sided: &[Sided], v: &[f64], falls: bool) -> Leaving {
        let mut direction = vec![0.0; landscape.steady.len()];
        for (response, v) in self.responses.iter().zip(v) {
            landscape.free.iter().zip(response).for_each(|(i, x)| direction[*i] += v * x);
        }
        let along: Vec<f64> = rows.by_basis.iter().map(|t| t.iter().zip(v).map(|(t, v)| t * v).sum::<f64>()).collect();
        Leaving::new(sided, &along, direction, falls)
    }
}
