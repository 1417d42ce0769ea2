//! Can these supports hold these loads? Limit analysis by conic programs.
//!
//! Supports push on a system in `n` velocity coordinates with forces `f` through the columns `G` (`n × m`); loads, everything
//! else at rest, are `w`. Each group of forces `f_i` has a cone `K_i`:
//!
//! ```text
//! (1)  G f + w = 0,    f_i ∈ K_i                                                       balance
//! (2)  free      any                                    multipliers of loops, drives, gears, locks
//!      ray       f ≥ 0                                  stops that press, contacts without friction
//!      Coulomb   |f_t| ≤ μ f_n,  f = (f_n, f_t1, f_t2)   contacts
//!      ball      |f| ≤ b                                dry friction of a hinge
//! (P)  τ* = min τ    G f + w = 0,  f_i + τ e_i ∈ K_i     e_i: μ f_n, f and b grow by F
//! (D)       max w·ν − Σ b z_i,   u = Gᵀν,  z_i = what e_i works on,  Σ F z_i = 1
//! (L)  α* = max α    G f + w + α w₁ = 0,   f_i ∈ K_i
//! (M)  s* = min s    G f + w = 0,   |f_t| ≤ s μ f_n,  |f| ≤ s b
//! (U)       min |f|²  G f + w = 0,   f_i ∈ K_i
//! (W)       max Σ f_n  G f = 0,   f_i ∈ K_i,  f_n ≤ 1,  ball f = 0
//! ```
//!
//! `F` is the size of the loads. (P) always has an answer: `τ* < 0` stands, with `τ* F` to spare; `τ* > 0` falls, and `ν` is the
//! motion along which it falls first: `u_n > 0` opens, `u_t ≠ 0` slides, a hinge with `ν ≠ 0` gives way, and the loads do
//! the work `w·ν = τ*`. For friction the existence of such forces is necessary (*weak stability*: Pang, Trinkle, "Stability
//! characterizations of rigid body contact problems with Coulomb friction", ZAMM 80, 2000).
//!
//! (W) finds forces that balance each other inside the cones. If friction that only such a squeeze can load is what holds
//! the scene, it is **wedged**: it stands only if it has been squeezed.
//!
//! A rim is as many contacts as it has points: programs begin with some and get those that they turn out to need (`exchange`).
//!
//! An interior point method (`solver`) proposes; what is claimed is computed here from its forces and motion: how far the
//! balance is missed, how far forces lie outside of their cones, and the gap between the bounds of (P) and (D).

mod exchange;
mod programs;
mod slack;
mod solver;

pub use exchange::RimSupport;
pub use programs::BALANCED;
pub use slack::slack;
use std::ops::Range;

/// What the forces of one support may be; eq. (2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cone {
    /// One number, any.
    Free,
    /// One number, ≥ 0 (N or N m).
    Ray,
    /// `(f_n, f_t1, f_t2)` with this coefficient of friction, > 0.
    Coulomb {
        /// μ; infinite where nothing slides.
        friction: f64,
    },
    /// Numbers whose root of the sum of squares is bounded (N or N m).
    Ball {
        /// b, ≥ 0.
        bound: f64,
        /// How many: 1 for a hinge coordinate, 3 for a spherical hinge.
        size: usize,
    },
}

impl Cone {
    /// How many numbers it bounds.
    pub fn size(&self) -> usize {
        match self {
            Self::Free | Self::Ray => 1,
            Self::Coulomb { .. } => 3,
            Self::Ball { size, .. } => *size,
        }
    }

    /// How far forces lie outside: the least growth (N or N m) along `e` of (P) that takes them in; negative inside, and
    /// −∞ if nothing bounds them.
    fn outside(&self, f: &[f64]) -> f64 {
        match self {
            Self::Free => f64::NEG_INFINITY,
            Self::Ray => -f[0],
            Self::Coulomb { friction } if friction.is_infinite() => -f[0],
            Self::Coulomb { friction } => f[1].hypot(f[2]) - friction * f[0],
            Self::Ball { bound, .. } => norm(f) - bound,
        }
    }

    /// Part of the cone that forces use: 0 … 1 inside; `None` if nothing bounds them by friction.
    pub fn share(&self, f: &[f64]) -> Option<f64> {
        let part = |of: f64, whole: f64| if of == 0.0 { 0.0 } else { of / whole };
        match self {
            Self::Free | Self::Ray => None,
            Self::Coulomb { friction } => Some(part(f[1].hypot(f[2]), friction * f[0])),
            Self::Ball { bound, .. } => Some(part(norm(f), *bound)),
        }
    }

    /// This cone with its friction times a factor.
    fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Coulomb { friction } => Self::Coulomb { friction: friction * factor },
            Self::Ball { bound, size } => Self::Ball { bound: if bound > 0.0 { bound * factor } else { 0.0 }, size },
            other => other,
        }
    }
}

/// Supports: their cones and columns.
#[derive(Debug, Clone, Default)]
pub struct Supports {
    /// Number of velocity coordinates.
    rows: usize,
    cones: Vec<Cone>,
    /// First column of each cone.
    starts: Vec<usize>,
    /// `G` by columns: (row, entry).
    columns: Vec<Vec<(usize, f64)>>,
    /// What a force has to be multiplied with to be compared with the balance of a velocity coordinate: 1 for slides, a
    /// length (m) for turns.
    units: Vec<f64>,
    /// What the forces of each support are multiplied with to be compared with each other, likewise.
    levers: Vec<f64>,
    /// Sizes of the terms that the loads of the velocity coordinates are sums of (N, N m); empty if they are not known.
    terms: Vec<f64>,
    rims: Vec<RimSupport>,
    /// Points of rims that were added: see [`Supports::added`].
    added: Vec<(usize, f64)>,
}

impl Supports {
    /// None yet, for velocity coordinates with these units: 1 for slides, the scene's length (m) for turns.
    pub fn new(units: Vec<f64>) -> Self {
        Self { rows: units.len(), units, ..Self::default() }
    }

    /// With the sizes of the terms that loads are sums of (N, N m): what nearly cancels is no light body.
    pub fn with_terms(self, terms: Vec<f64>) -> Self {
        Self { terms, ..self }
    }

    /// Adds one with its columns of `G`; `lever` is 1 if it pushes with forces, the scene's length (m) if with moments.
    ///
    /// # Panics
    /// If the columns are not as many as the cone has numbers.
    pub fn add(&mut self, cone: Cone, lever: f64, columns: impl IntoIterator<Item = Vec<(usize, f64)>>) {
        self.starts.push(self.columns.len());
        self.columns.extend(columns);
        let start = *self.starts.last().expect("one was pushed");
        assert_eq!(self.columns.len() - start, cone.size(), "one column for each number of a cone");
        self.cones.push(cone);
        self.levers.push(lever);
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.cones.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.cones.is_empty()
    }

    /// The cones in the order in which they were added.
    pub fn cones(&self) -> &[Cone] {
        &self.cones
    }

    /// Which of all forces are those of a support.
    pub fn range(&self, support: usize) -> Range<usize> {
        let start = self.starts[support];
        start..start + self.cones[support].size()
    }

    /// What a force has to be multiplied with to be compared with the balance of a velocity coordinate: see
    /// [`Supports::new`].
    pub fn unit(&self, row: usize) -> f64 {
        self.units[row]
    }

    /// The columns of a support for forces and balances in newtons: (row, entry).
    pub fn scaled_columns(&self, support: usize) -> impl Iterator<Item = Vec<(usize, f64)>> {
        let lever = self.levers[support];
        let scale = move |(row, entry): &(usize, f64)| (*row, entry * lever / self.units[*row]);
        self.range(support).map(move |column| self.columns[column].iter().map(scale).collect())
    }

    /// Gᵀν: the rates of all columns along a motion.
    pub fn rates(&self, motion: &[f64]) -> Vec<f64> {
        self.columns.iter().map(|column| column.iter().map(|(row, entry)| entry * motion[*row]).sum()).collect()
    }

    /// The size of loads (N): the largest, moments by the unit of their coordinate.
    fn size(&self, load: &[f64]) -> f64 {
        load.iter().zip(&self.units).fold(0.0, |most, (load, unit)| f64::max(most, (load / unit).abs()))
    }
}

/// What supports do with loads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Forces inside the cones balance the loads.
    Stands,
    /// They do only if supports are squeezed against each other beforehand.
    Wedged,
    /// No forces in the cones balance the loads.
    Falls,
}

impl Verdict {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stands => "stands",
            Self::Wedged => "wedged",
            Self::Falls => "falls",
        }
    }
}

/// The answer to (P), with what proves it.
#[derive(Debug, Clone)]
pub struct Standing {
    /// What it says.
    pub verdict: Verdict,
    /// `−τ*`: what there is to spare (stands) or lacks (negative: falls), in parts of the loads.
    pub slack: f64,
    /// Forces of all columns: of (U) if it stands, else of (P).
    pub forces: Vec<f64>,
    /// Forces of (P): as far inside of all cones as they can be.
    pub inner: Vec<f64>,
    /// `ν` of (D), scaled to a largest rate of 1 (m/s; rad/s times the unit): the motion along which it gives way first.
    pub motion: Vec<f64>,
    /// Of supports that carry something, the dimension of forces that balance each other.
    pub self_stresses: usize,
    /// Whether it stands without any friction.
    pub without_friction: bool,
    /// `dτ*/d ln s`: how the missing part changes with the size of all friction.
    pub slope: f64,
    /// What was computed from the answer.
    pub certificate: Certificate,
}

/// How well an answer fits, recomputed; all in parts of the loads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certificate {
    /// Largest missing part of the balance of the forces.
    pub unbalanced: f64,
    /// How far forces lie outside of their cones, ≥ 0.
    pub outside: f64,
    /// Between the upper bound by forces and the lower one by the motion.
    pub gap: f64,
}

/// The end of friction (M).
#[derive(Debug, Clone)]
pub struct Least {
    /// The smallest part of all friction at which a load is held; 0 if none is needed.
    pub part: f64,
    /// The motion along which it gives way first there, scaled as [`Standing::motion`]; empty if no friction is needed.
    pub motion: Vec<f64>,
}

/// The end of a load parameter (L).
#[derive(Debug, Clone)]
pub struct Limit {
    /// α*; infinite if nothing ends it.
    pub value: f64,
    /// The motion along which it gives way there; empty if nothing ends it.
    pub motion: Vec<f64>,
}

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Undecided {
    /// The build has no solver.
    #[error("friction and contact at rest need the feature `friction`, which this build does not have")]
    NoSolver,
    /// Loads that are too small beside others to be judged with them.
    #[error(
        "the smallest load is {ratio:.1e} of the largest: what is lighter by more than 1e7 cannot be judged in the same scene; judge \
         it in a scene of its own or, if it is what a hinge in its springs lacks to its balance, let the scene settle"
    )]
    Uneven {
        /// Smallest by largest.
        ratio: f64,
    },
    /// The solver has none that is good enough.
    #[error(
        "the conic program of {rows} balances and {supports} supports is not decided: forces miss the balance by {unbalanced:.1e} and the bounds are {gap:.1e} apart, in parts of the loads"
    )]
    Inexact {
        /// Velocity coordinates.
        rows: usize,
        /// Supports.
        supports: usize,
        /// As in [`Certificate`].
        unbalanced: f64,
        /// As in [`Certificate`].
        gap: f64,
    },
}

fn norm(f: &[f64]) -> f64 {
    f.iter().fold(0.0, |sum: f64, f| sum.hypot(*f))
}
