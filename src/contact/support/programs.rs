//! The programs of the module's header, in forces divided by the size of the loads, and what is recomputed from their
//! answers.

mod balance;
mod limit;
mod questions;

use super::solver::{Answer, BUILT, Program};
use super::{Certificate, Cone, Supports, Undecided, norm};
use crate::sparse::{SparseRows, rank};

/// `−τ*` is not looked for beyond this many times the loads.
const AMPLE: f64 = 100.0;
/// Loads that are this near to a limit, in parts of themselves, are at the limit: what interior points resolve on
/// degenerate programs (a harmonic stack at its largest overhang comes out within 3e-9).
const AT_THE_LIMIT: f64 = 1e-8;
/// Loads below this part of the largest, and above round-off, cannot be told from it: a program with both may be ill-conditioned.
const UNEVEN: f64 = 1e-7;
/// A balance that misses more than this part of the loads is none.
pub const BALANCED: f64 = 1e-9;
/// Entries of a column below this part of its largest are none in a program: what they push is within what a balance may miss. Bodies that
/// lie on each other, each tilted by its rounding, would have to be held by forces as many times their weight.
const FAINT: f64 = 0.3 * BALANCED;
/// Supports feel a motion by less than this part of it if they do not feel it: round-off of least squares.
const FELT: f64 = 1e-7;
/// Forces of (W), at most 1, above this are a squeeze.
const SQUEEZE: f64 = 1e-6;
/// Forces of (U) above this part of the largest carry: interior points find them to that; and what counts as at the end of a cone.
const CARRIES: f64 = 1e-6;
/// A balance of (U) that is found by least squares.
const EXACT: f64 = 1e-12;
/// A load factor beyond this many times the loads has no end.
const ENDLESS: f64 = 1e4;

/// Supports and loads in parts of the loads' size.
struct Scaled<'a> {
    supports: &'a Supports,
    columns: Vec<Vec<(usize, f64)>>,
    cones: Vec<Cone>,
    load: Vec<f64>,
    size: f64,
}

/// The unknown beside the forces.
enum Extra<'a> {
    None,
    /// τ of (P).
    Growth,
    /// α of (L), with w₁ in parts of the loads' size; towards larger (1) or smaller (−1) values.
    Along(&'a [f64], f64),
}

impl<'a> Scaled<'a> {
    fn new(supports: &'a Supports, load: &[f64], friction: f64) -> Self {
        let size = Some(supports.size(load)).filter(|size| *size > 0.0).unwrap_or(1.0);
        let (mut columns, mut cones) = (Vec::new(), Vec::new());
        for (i, cone) in supports.cones.iter().enumerate() {
            let lever = supports.levers[i];
            columns.extend(supports.scaled_columns(i));
            // What cannot slide at all bears sideways without end at many points of one rim.
            if friction.is_infinite() && supports.follows(i) {
                let own = supports.range(i);
                columns[own.start + 1..own.end].iter_mut().for_each(Vec::clear);
            }
            cones.push(match cone.scaled(friction) {
                Cone::Ball { bound, size: count } => Cone::Ball { bound: bound / (size * lever), size: count },
                other => other,
            });
        }
        let load = load.iter().zip(&supports.units).map(|(load, unit)| load / (unit * size)).collect();
        Self { supports, columns, cones, load, size }
    }

    /// Rows of all cones after the balance, with the unknown behind the forces.
    fn program(&self, extra: &Extra<'_>) -> Program {
        let rows = self.load.len();
        let mut columns: Vec<_> = self.columns.iter().map(|column| without_faint(column)).collect();
        let mut right: Vec<f64> = self.load.iter().map(|load| -load).collect();
        let mut cones = Vec::new();
        let mut unknown = Vec::new();
        for (i, cone) in self.cones.iter().enumerate() {
            let Some(shape) = cone.rows() else { continue };
            let (at, f) = (right.len(), self.supports.range(i));
            // Slacks right − A x are in the cone: A has the negative of what has to be there.
            match *cone {
                Cone::Free => {}
                Cone::Ray => {
                    columns[f.start].push((at, -1.0));
                    right.push(0.0);
                }
                Cone::Coulomb { friction } if friction.is_infinite() => {
                    columns[f.start].push((at, -1.0));
                    right.push(0.0);
                }
                Cone::Coulomb { friction } => {
                    columns[f.start].push((at, -friction));
                    columns[f.start + 1].push((at + 1, -1.0));
                    columns[f.start + 2].push((at + 2, -1.0));
                    right.extend([0.0; 3]);
                }
                Cone::Ball { bound, size } => {
                    (0..size).for_each(|k| columns[f.start + k].push((at + 1 + k, -1.0)));
                    right.push(bound);
                    right.extend(std::iter::repeat_n(0.0, size));
                }
            }
            unknown.push((at, -1.0));
            cones.push(shape);
        }
        let mut linear = vec![0.0; columns.len()];
        match extra {
            Extra::None => {}
            Extra::Growth => {
                // τ ≥ −AMPLE
                unknown.push((right.len(), -1.0));
                right.push(AMPLE);
                cones.push((false, 1));
                columns.push(unknown);
                linear.push(1.0);
            }
            Extra::Along(direction, sense) => {
                let mut column: Vec<(usize, f64)> =
                    direction.iter().copied().enumerate().filter(|(_, entry)| *entry != 0.0).collect();
                column.push((right.len(), *sense));
                right.push(ENDLESS);
                cones.push((false, 1));
                columns.push(column);
                linear.push(-sense);
            }
        }
        Program { quadratic: vec![0.0; columns.len()], linear, columns, right, equations: rows, cones }
    }

    /// What the balance lacks with these forces.
    fn rest(&self, forces: &[f64]) -> Vec<f64> {
        let mut rest = self.load.clone();
        for (column, f) in self.columns.iter().zip(forces) {
            column.iter().for_each(|(row, entry)| rest[*row] += entry * f);
        }
        rest
    }

    fn rates(&self, motion: &[f64]) -> Vec<f64> {
        self.columns.iter().map(|column| column.iter().map(|(row, entry)| entry * motion[*row]).sum()).collect()
    }

    /// The largest distance outside of a cone.
    fn outside(&self, forces: &[f64]) -> f64 {
        let each = self.cones.iter().enumerate().map(|(i, cone)| cone.outside(&forces[self.supports.range(i)]));
        each.fold(-AMPLE, f64::max)
    }

    fn unbalanced(&self, forces: &[f64]) -> f64 {
        // A maximum passes over what is not a number.
        let size = |rest: &f64| if rest.is_nan() { f64::INFINITY } else { rest.abs() };
        self.rest(forces).iter().map(size).fold(0.0, f64::max)
    }

    /// (D) for a motion: a lower bound of `τ*`.
    fn bound(&self, motion: &[f64], forces: &[f64]) -> f64 {
        let [surplus, growth] = self.surplus(motion, forces);
        if growth > 0.0 { surplus / growth } else { f64::NEG_INFINITY }
    }

    /// The numerator of (D) for a motion, less what its rates lie outside of the dual cones times the forces, and its denominator.
    fn surplus(&self, motion: &[f64], forces: &[f64]) -> [f64; 2] {
        let rates = self.rates(motion);
        let (mut work, mut growth, mut wrong) = (dot(motion, &self.load), 0.0, 0.0);
        for (i, cone) in self.cones.iter().enumerate() {
            let range = self.supports.range(i);
            let (u, f) = (&rates[range.clone()], &forces[range]);
            let off = match cone {
                Cone::Free => u[0].abs(),
                Cone::Ray => {
                    growth += u[0].max(0.0);
                    (-u[0]).max(0.0)
                }
                Cone::Coulomb { friction } if friction.is_infinite() => {
                    growth += u[0].max(0.0);
                    (-u[0]).max(0.0) + u[1].hypot(u[2])
                }
                Cone::Ball { bound, .. } if bound.is_infinite() => norm(u),
                Cone::Coulomb { friction } => {
                    growth += (u[0] / friction).max(0.0);
                    (u[1].hypot(u[2]) - u[0] / friction).max(0.0)
                }
                Cone::Ball { bound, .. } => {
                    growth += norm(u);
                    work -= bound * norm(u);
                    0.0
                }
            };
            wrong += off * norm(f);
        }
        [work - wrong, growth]
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A column without its [`FAINT`] entries.
fn without_faint(column: &[(usize, f64)]) -> Vec<(usize, f64)> {
    let largest = column.iter().fold(0.0_f64, |most, (_, entry)| most.max(entry.abs()));
    column.iter().filter(|(_, entry)| entry.abs() >= FAINT * largest).copied().collect()
}

/// The answer to (P), scaled.
struct Grown {
    forces: Vec<f64>,
    motion: Vec<f64>,
    upper: f64,
    lower: f64,
    certificate: Certificate,
}

impl Scaled<'_> {
    fn answer(&self, program: &Program) -> Result<Answer, Undecided> {
        if !BUILT {
            return Err(Undecided::NoSolver);
        }
        program.solve().ok_or(Undecided::Inexact {
            rows: self.load.len(),
            supports: self.cones.len(),
            unbalanced: f64::NAN,
            gap: f64::NAN,
        })
    }

    fn grow(&self) -> Result<Grown, Undecided> {
        let (rows, columns) = (self.load.len(), self.columns.len());
        if rows == 0 {
            let certificate = Certificate { unbalanced: 0.0, outside: 0.0, gap: 0.0 };
            let (forces, motion) = (vec![0.0; columns], Vec::new());
            return Ok(Grown { forces, motion, upper: -AMPLE, lower: f64::NEG_INFINITY, certificate });
        }
        if !BUILT {
            return Err(Undecided::NoSolver);
        }
        let answer = if columns == 0 { None } else { self.program(&Extra::Growth).solve() };
        let mut forces = answer.as_ref().map_or_else(|| vec![0.0; columns], |answer| answer.x[..columns].to_vec());
        self.polish(&mut forces);
        let mut unbalanced = self.unbalanced(&forces);
        if !(unbalanced <= BALANCED) {
            // Of what nothing balances an interior point says forces without end, whose rounding hides what they lack.
            let mut nearest = vec![0.0; columns];
            self.polish(&mut nearest);
            let left = self.unbalanced(&nearest);
            if !(unbalanced <= left) {
                (forces, unbalanced) = (nearest, left);
            }
        }
        let undecided = |gap: f64| Undecided::Inexact { rows, supports: self.cones.len(), unbalanced, gap };
        if unbalanced > BALANCED {
            // Loads that no forces balance, whatever their cones: what is left in least squares is a motion that no support feels.
            let motion = self.rest(&forces);
            let felt = self.rates(&motion).iter().fold(0.0, |most, rate| f64::max(most, rate.abs()));
            if felt <= FELT * unbalanced {
                let certificate = Certificate { unbalanced, outside: 0.0, gap: 0.0 };
                return Ok(Grown { forces, motion, upper: unbalanced, lower: unbalanced, certificate });
            }
        }
        let motion = match &answer {
            Some(answer) => answer.multipliers[..rows].to_vec(),
            // Nothing to bear, and nothing that could.
            None if columns == 0 => vec![0.0; rows],
            None => return Err(undecided(f64::NAN)),
        };
        let (upper, lower) = (self.outside(&forces), self.bound(&motion, &forces));
        let gap = if upper <= -0.99 * AMPLE { 0.0 } else { upper - lower };
        // Of forces that are large beside the loads the balance may be missed, and a motion proves all the same that they fall.
        if unbalanced > BALANCED && !(lower > 0.0) {
            return Err(undecided(gap));
        }
        let certificate = Certificate { unbalanced, outside: upper.max(0.0), gap };
        Ok(Grown { forces, motion, upper, lower, certificate })
    }

    /// dτ*/d ln s of friction times s: `−Σ z f_n μ` of contacts, `−Σ z b` of hinges, by Σ z = 1.
    fn slope(&self, motion: &[f64], forces: &[f64]) -> f64 {
        let rates = self.rates(motion);
        let (mut sum, mut growth) = (0.0, 0.0);
        for (i, cone) in self.cones.iter().enumerate() {
            let range = self.supports.range(i);
            let u = &rates[range.clone()];
            match cone {
                Cone::Free => {}
                Cone::Ray => growth += u[0],
                Cone::Coulomb { friction } => {
                    growth += u[0] / friction;
                    sum += u[0] * forces[range.start];
                }
                Cone::Ball { bound, .. } => {
                    growth += norm(u);
                    sum += norm(u) * bound;
                }
            }
        }
        -sum / growth
    }

    /// (U).
    fn least(&self) -> Option<Vec<f64>> {
        let mut program = self.program(&Extra::None);
        program.quadratic.fill(1.0);
        let mut forces = program.solve()?.x;
        self.polish(&mut forces);
        let is_answer = self.unbalanced(&forces) <= BALANCED && self.outside(&forces) <= AT_THE_LIMIT;
        is_answer.then(|| self.least_of_carriers(&forces).unwrap_or(forces))
    }

    /// (U) to the last digits where no cone but those of nothing is at its end: of the supports that carry, the shortest forces that balance.
    fn least_of_carriers(&self, near: &[f64]) -> Option<Vec<f64>> {
        let largest = near.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
        let mut columns = self.columns.clone();
        for (i, cone) in self.cones.iter().enumerate() {
            let own = self.supports.range(i);
            let f = &near[own.clone()];
            match cone {
                _ if norm(f) <= CARRIES * largest => columns[own].iter_mut().for_each(Vec::clear),
                _ if cone.share(f).is_some_and(|share| share >= 1.0 - CARRIES) => return None,
                _ => {}
            }
        }
        let (cones, load) = (self.cones.clone(), self.load.clone());
        let carriers = Scaled { supports: self.supports, columns, cones, load, size: self.size };
        let mut forces = vec![0.0; near.len()];
        carriers.polish(&mut forces);
        let is_shorter = norm(&forces) <= norm(near) * (1.0 + CARRIES);
        let is_answer = carriers.unbalanced(&forces) <= EXACT && self.outside(&forces) <= 0.0 && is_shorter;
        is_answer.then_some(forces)
    }

    /// These supports with the friction of some left out: tangential forces that push on nothing leave `f_n ≥ 0`.
    fn without_friction(&self, supports: impl Iterator<Item = usize>) -> Self {
        let (mut columns, cones, load) = (self.columns.clone(), self.cones.clone(), self.load.clone());
        for i in supports {
            let range = self.supports.range(i);
            match self.cones[i] {
                Cone::Coulomb { .. } => columns[range.start + 1..range.end].iter_mut().for_each(Vec::clear),
                Cone::Ball { .. } => columns[range].iter_mut().for_each(Vec::clear),
                Cone::Free | Cone::Ray => {}
            }
        }
        Scaled { supports: self.supports, columns, cones, load, size: self.size }
    }

    /// The contacts that forces inside all cones can press on each other: (W).
    fn squeezed(&self) -> Result<Vec<usize>, Undecided> {
        let normal = |i: &usize| matches!(self.cones[*i], Cone::Coulomb { .. });
        let contacts: Vec<usize> = (0..self.cones.len()).filter(normal).collect();
        if contacts.is_empty() {
            return Ok(contacts);
        }
        let mut program = self.program(&Extra::None);
        program.right[..self.load.len()].fill(0.0);
        let mut at = self.load.len();
        for cone in &self.cones {
            if let Cone::Ball { .. } = cone {
                program.right[at] = 0.0;
            }
            at += cone.rows().map_or(0, |(_, rows)| rows);
        }
        for i in &contacts {
            let column = self.supports.starts[*i];
            program.linear[column] = -1.0;
            program.columns[column].push((program.right.len(), 1.0));
            program.right.push(1.0);
            program.cones.push((false, 1));
        }
        let answer = self.answer(&program)?;
        Ok(contacts.into_iter().filter(|i| answer.x[self.supports.starts[*i]] > SQUEEZE).collect())
    }

    /// Forces of those that carry, less the rank of their columns.
    fn self_stresses(&self, forces: &[f64]) -> usize {
        let carries = |i: usize| match self.cones[i] {
            Cone::Free => true,
            Cone::Ray | Cone::Coulomb { .. } => forces[self.supports.starts[i]] > AT_THE_LIMIT,
            // Friction of a hinge is bounded: no squeeze can load it.
            Cone::Ball { .. } => false,
        };
        let kept: Vec<usize> =
            (0..self.cones.len()).filter(|i| carries(*i)).flat_map(|i| self.supports.range(i)).collect();
        let mut entries = vec![Vec::new(); self.load.len()];
        for (at, column) in kept.iter().enumerate() {
            self.columns[*column].iter().for_each(|(row, entry)| entries[*row].push((at, *entry)));
        }
        kept.len() - rank(&SparseRows::of(entries), kept.len())
    }

    fn unscaled(&self, forces: &[f64]) -> Vec<f64> {
        let mut out = forces.to_vec();
        for i in 0..self.cones.len() {
            out[self.supports.range(i)].iter_mut().for_each(|f| *f *= self.size * self.supports.levers[i]);
        }
        out
    }

    /// A motion of scaled coordinates in those of the scene, its largest rate 1 (by units).
    fn rates_of_coordinates(&self, motion: &[f64]) -> Vec<f64> {
        let most = motion.iter().fold(0.0, |most, rate| f64::max(most, rate.abs()));
        let scale = if most > 0.0 { 1.0 / most } else { 0.0 };
        motion.iter().zip(&self.supports.units).map(|(rate, unit)| rate * scale / unit).collect()
    }
}
