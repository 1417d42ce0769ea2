//! One-sided balances of loads without a potential, and of steady motions: whether a motion leaves for ever on some side.
//!
//! ```text
//! (1)  (s² M + s C + Kₚ) x = −Aᵀ λ,   0 ≤ λ ⊥ A x ≤ 0,   s > 0 real
//! ```
//!
//! `x e^(st)` is a motion of the scene: it leaves the stops `A x < 0`, slides along those with `A x = 0`, which press with `λ e^(st)`,
//! and never comes back (a complementarity eigenvalue, Pinto da Costa et al. 2004). Which stops it slides along is tried, set by
//! set, on each side of what has another stiffness there. If the motion grows that all stops of a set hold and the others leave free,
//! but swings, it strikes the stops that it comes back to, and what impacts leave of it is not known here.

use super::copositive::MOST_ENUMERATED;
use super::motion::{LinearMotion, Root};
use super::sides::{Beyond, Leaving, Sided, Sides, cones};
use crate::dynamics::{Fault, Linearization};
use crate::round_off::EIGENVECTOR;
use crate::statics::problem::Landscape;
use crate::statics::problem::place::Place;
use crate::statics::problem::sizes::sizes;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// Operations that eigenvalue problems of all sets may take together: some seconds. Beyond, only sets that hold all stops but one, or
/// none, are tried.
const MOST_WORK: usize = 2_000_000_000;
/// Operations of an eigenvalue problem in the third power of its rows.
const EIGEN: usize = 25;

/// Mass, damping and stiffness of the motions, and what they are along.
pub(in crate::statics) struct Along {
    pub linear: Linearization,
    /// Columns over the free coordinates; `None` if motions are the free coordinates themselves.
    pub along: Option<Mat<f64>>,
    /// Sizes of the stiffness terms.
    pub sizes: Vec<f64>,
}

impl Along {
    /// Of the free coordinates, with loops of the motions that they leave; `magnitude` are the sizes of their stiffness terms.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub(in crate::statics) fn at(landscape: &mut Landscape<'_>, q: &[f64], magnitude: &[f64]) -> Result<Self, Fault> {
        let (free, steady) = (landscape.free.clone(), landscape.steady.clone());
        let along = if landscape.ties.is_some() { Some(landscape.tangent(q)?) } else { None };
        if let Some(z) = &along {
            landscape.share_prestress(q, z)?;
        }
        let full = landscape.system().at(0.0, q, &steady).linearize(&vec![0.0; steady.len()])?;
        let pick = |m: &Mat<f64>| {
            let part = Mat::from_fn(free.len(), free.len(), |i, j| m[(free[i], free[j])]);
            along.as_ref().map_or_else(|| part.clone(), |z| z.transpose() * &part * z)
        };
        let linear =
            Linearization { stiffness: pick(&full.stiffness), damping: pick(&full.damping), mass: pick(&full.mass) };
        Ok(Self { linear, sizes: sizes(along.as_ref(), magnitude), along })
    }

    pub(super) fn row(&self, free: &[f64]) -> Vec<f64> {
        let Some(z) = &self.along else { return free.to_vec() };
        (0..z.ncols()).map(|j| free.iter().enumerate().map(|(i, a)| z[(i, j)] * a).sum()).collect()
    }

    fn spread(&self, x: &[f64]) -> Vec<f64> {
        let Some(z) = &self.along else { return x.to_vec() };
        (0..z.nrows()).map(|i| x.iter().enumerate().map(|(j, x)| z[(i, j)] * x).sum()).collect()
    }
}

/// What leaves by its motion; `rows` are those of `sided` over the free coordinates, divided by these sizes.
pub(super) fn look(
    landscape: &mut Landscape<'_>,
    place: &Place,
    (rows, row_sizes): (&[Vec<f64>], &[f64]),
    sided: &[Sided],
) -> Result<Sides, Fault> {
    let moving = Along::at(landscape, &place.q, &place.scales.stiffness)?;
    let rows: Vec<Vec<f64>> = rows.iter().map(|row| moving.row(row)).collect();
    let stops: Vec<usize> = (0..sided.len()).filter(|k| matches!(sided[*k].beyond, Beyond::Nothing)).collect();
    let (mut stays, mut swings) = (None, false);
    let cones = cones(sided);
    for sides in &cones {
        let stiffness = beside(&moving.linear.stiffness, &rows, row_sizes, sided, sides);
        let linear = Linearization { stiffness, ..moving.linear.clone() };
        for held in sets(&stops, rows[0].len(), cones.len()) {
            let of = Piece { linear: &linear, rows: &rows, sides, held: &held };
            match of.motion() {
                Motion::Leaves { x, falls } => {
                    let along: Vec<f64> = rows.iter().map(|row| dot(row, &x)).collect();
                    let mut direction = vec![0.0; landscape.steady.len()];
                    landscape.free.iter().zip(moving.spread(&x)).for_each(|(i, x)| direction[*i] = x);
                    let leaving = Leaving::new(sided, &along, direction, falls);
                    if falls {
                        return Ok(Sides::Leave(leaving));
                    }
                    stays.get_or_insert(leaving);
                }
                Motion::Swings => swings = true,
                Motion::ComesBack => {}
            }
        }
    }
    Ok(match (stays, swings) {
        (_, true) => Sides::Swing,
        (Some(leaving), false) => Sides::Leave(leaving),
        (None, false) => Sides::Hold,
    })
}

/// `Kₚ`
fn beside(stiffness: &Mat<f64>, rows: &[Vec<f64>], row_sizes: &[f64], sided: &[Sided], sides: &[bool]) -> Mat<f64> {
    let mut sum = stiffness.clone();
    for (k, one) in sided.iter().enumerate() {
        let Beyond::Stiffness(both) = one.beyond else { continue };
        let (by, row) = (both[usize::from(sides[k])] * row_sizes[k].powi(2), &rows[k]);
        sum = Mat::from_fn(sum.nrows(), sum.ncols(), |i, j| sum[(i, j)] + by * row[i] * row[j]);
    }
    sum
}

/// Sets of stops that may hold; few of many. Along all of them motions are known to come back, but where there are several cones.
fn sets(stops: &[usize], motions: usize, cones: usize) -> Vec<Vec<usize>> {
    let count = stops.len();
    if count == 0 {
        return vec![Vec::new()];
    }
    let each = EIGEN * (2 * motions).pow(3);
    if count <= MOST_ENUMERATED && (cones << count).saturating_mul(each) <= MOST_WORK {
        let of =
            |set: usize| stops.iter().enumerate().filter(|(bit, _)| set >> bit & 1 == 1).map(|(_, k)| *k).collect();
        return (0..(1_usize << count) - usize::from(cones == 1)).map(of).collect();
    }
    let but = |one: &usize| stops.iter().copied().filter(|k| k != one).collect();
    let all = (cones > 1).then(|| stops.to_vec());
    std::iter::once(Vec::new()).chain(stops.iter().map(but)).chain(all).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// What the motions of one piece do.
enum Motion {
    Leaves { x: Vec<f64>, falls: bool },
    Swings,
    ComesBack,
}

/// The motions on one side of everything, along the stops that hold.
struct Piece<'a> {
    linear: &'a Linearization,
    rows: &'a [Vec<f64>],
    sides: &'a [bool],
    held: &'a [usize],
}

impl Piece<'_> {
    fn motion(&self) -> Motion {
        let Some(basis) = self.along_held() else { return Motion::ComesBack };
        let reduced = |m: &Mat<f64>| basis.transpose() * m * &basis;
        let Linearization { stiffness, damping, mass } = self.linear;
        let linear = Linearization { stiffness: reduced(stiffness), damping: reduced(damping), mass: reduced(mass) };
        let (mut swings, mut stays) = (false, None);
        for Root { value: root, parts: [real, _] } in LinearMotion::open(&linear).roots() {
            let size = root.re.hypot(root.im);
            let grows = root.re > 0.0;
            if root.im != 0.0 {
                swings |= grows;
                continue;
            }
            if size > 0.0 && !grows {
                continue;
            }
            let x: Vec<f64> =
                (0..basis.nrows()).map(|i| real.iter().enumerate().map(|(j, x)| basis[(i, j)] * x).sum()).collect();
            for sign in [1.0, -1.0] {
                let x: Vec<f64> = x.iter().map(|x| sign * x).collect();
                if !self.admits(&x, root.re) {
                    continue;
                }
                if grows {
                    return Motion::Leaves { x, falls: true };
                }
                stays.get_or_insert(x);
            }
        }
        match (swings, stays) {
            (true, _) => Motion::Swings,
            (false, Some(x)) => Motion::Leaves { x, falls: false },
            (false, None) => Motion::ComesBack,
        }
    }

    /// Motions along the stops that hold; `None` if there are none.
    fn along_held(&self) -> Option<Mat<f64>> {
        let n = self.linear.mass.nrows();
        let squares =
            Mat::from_fn(n, n, |i, j| self.held.iter().map(|k| self.rows[*k][i] * self.rows[*k][j]).sum::<f64>());
        let eigen = squares.self_adjoint_eigen(Side::Lower).ok()?;
        let largest = (0..n).map(|k| eigen.S()[k]).fold(0.0, f64::max);
        let free: Vec<usize> = (0..n).filter(|k| eigen.S()[*k] <= EIGENVECTOR.of(largest)).collect();
        (!free.is_empty()).then(|| Mat::from_fn(n, free.len(), |i, j| eigen.U()[(i, free[j])]))
    }

    /// Whether a motion that grows with a rate stays on the sides, leaves the stops that do not hold, and is pressed upon by the
    /// others.
    fn admits(&self, x: &[f64], rate: f64) -> bool {
        let along: Vec<f64> = self.rows.iter().map(|row| dot(row, x)).collect();
        let sizes = self.rows.iter().map(|row| dot(row, row).sqrt() * dot(x, x).sqrt());
        let small: Vec<f64> = sizes.map(|size| EIGENVECTOR.of(size)).collect();
        let leaves = |k: usize| match self.sides[k] {
            true => along[k] >= -small[k],
            false => along[k] <= small[k],
        };
        let moves = (0..along.len()).any(|k| along[k].abs() > small[k]);
        moves && (0..along.len()).filter(|k| !self.held.contains(k)).all(leaves) && self.presses(x, rate)
    }

    /// Whether what holds (1) is no pull.
    fn presses(&self, x: &[f64], rate: f64) -> bool {
        let held = self.held.len();
        if held == 0 {
            return true;
        }
        let Linearization { stiffness, damping, mass } = self.linear;
        let n = x.len();
        let entry = |i: usize, j: usize| rate * rate * mass[(i, j)] + rate * damping[(i, j)] + stiffness[(i, j)];
        let force: Vec<f64> = (0..n).map(|i| (0..n).map(|j| entry(i, j) * x[j]).sum()).collect();
        let gram = Mat::from_fn(held, held, |i, j| dot(&self.rows[self.held[i]], &self.rows[self.held[j]]));
        let rhs = Mat::from_fn(held, 1, |i, _| -dot(&self.rows[self.held[i]], &force));
        let loads = gram.partial_piv_lu().solve(rhs);
        let size = |i: usize| (0..n).map(|j| (entry(i, j) * x[j]).abs()).sum::<f64>();
        let terms: f64 = (0..n).map(size).sum();
        // Of rows that are linearly dependent others say the same.
        (0..held).all(|k| {
            loads[(k, 0)] * dot(&self.rows[self.held[k]], &self.rows[self.held[k]]).sqrt() >= -EIGENVECTOR.of(terms)
        })
    }
}
