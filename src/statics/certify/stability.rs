//! What kind of equilibrium it is: how many directions leave it, how many have zero stiffness, and how fast it swings.
//!
//! At an equilibrium with a potential the stiffness matrix `K` is its Hessian. Directions are counted on
//! `N^(-1/2) K N^(-1/2)`, `N` being the magnitude of the terms that make up `K`: an eigenvalue within [`NEUTRAL`] of
//! zero may be round-off, and is looked at more closely (see `known`). Without a potential the eigenvalues of the linearized motion
//! decide.

use super::damped::{self, DampedMode};
use super::modes::{NaturalMode, momentum, rates_of, scaled, shares};
use super::motion::LinearMotion;
use crate::dynamics::{Fault, Linearization, Matrices, System, TangentSolver};
use crate::model::Model;
use crate::statics::problem::sizes::{count_by_stiffness, symmetric};
use crate::statics::problem::{Across, DENSE, Looked, MOST_MODES, by_sweeps};
use faer::{Mat, Side};
use std::sync::Arc;

/// Largest damped problem solved densely: damped modes are exact in the space of all undamped ones.
pub(in crate::statics) const MOST_DENSE: usize = 200;

/// Whether all modes of a scene are computed, by matrices.
pub(in crate::statics) fn by_matrices(model: &Model, free: usize) -> bool {
    free <= if model.has_damping() { MOST_DENSE } else { MOST_MODES }
}

/// How many modes of a scene are told in tables: all where a scene has few coordinates, else the lowest ones.
pub fn most_modes(model: &Model) -> usize {
    let count = model.velocity_count();
    if by_matrices(model, count) { count } else { MOST_MODES }
}

/// The verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StabilityVerdict {
    /// Every small push comes back.
    Stable,
    /// Some push runs away.
    Unstable,
    /// None runs away, and some motion has zero stiffness.
    Neutral,
}

impl StabilityVerdict {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Unstable => "unstable",
            Self::Neutral => "neutral",
        }
    }
}

/// Verdict and modes.
#[derive(Debug, Clone)]
pub struct Stability {
    /// The verdict.
    pub verdict: StabilityVerdict,
    /// What a stable verdict supposes; `None` if nothing.
    pub supposes: Option<&'static str>,
    /// Number of directions that run away.
    pub unstable_directions: usize,
    /// Number of zero-stiffness directions.
    pub neutral_directions: usize,
    /// All modes, of a large system the lowest (`MOST_MODES`): running away first, then neutral, then by frequency.
    pub modes: Vec<NaturalMode>,
    /// Modes of the damped motion, where something damps; of a large system those within the space of its lowest
    /// undamped ones.
    pub damped: Vec<DampedMode>,
}

impl Stability {
    /// The verdict on so many directions that run away, and of zero stiffness.
    pub(in crate::statics) fn of(
        unstable: usize,
        neutral: usize,
        modes: Vec<NaturalMode>,
        damped: Vec<DampedMode>,
    ) -> Self {
        let verdict = match (unstable, neutral) {
            (0, 0) => StabilityVerdict::Stable,
            (0, _) => StabilityVerdict::Neutral,
            _ => StabilityVerdict::Unstable,
        };
        Self { verdict, supposes: None, unstable_directions: unstable, neutral_directions: neutral, modes, damped }
    }

    /// What feeds an equilibrium of loads without a potential that flutters, if nothing damps it.
    pub(in crate::statics) fn flutter_note(&self, model: &Model) -> Option<String> {
        let flutters = |mode: &NaturalMode| mode.growth_rate > 0.0 && mode.frequency_hz > 0.0;
        let fed = !model.is_conservative_at_rest() && !model.has_damping();
        (fed && self.modes.iter().any(flutters)).then(|| {
            "loads without a potential feed motions that swing (flutter), and nothing in the scene damps them: with damping they \
             may be still"
                .to_owned()
        })
    }

    /// The modes that swing, or stay, without damping: by frequency.
    pub fn swinging(&self) -> Vec<&NaturalMode> {
        let mut found: Vec<&NaturalMode> = self.modes.iter().filter(|mode| mode.swings).collect();
        found.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        found
    }

    /// Natural frequencies of the undamped motion (Hz), ascending: of the modes that do not run away without damping.
    pub fn frequencies(&self) -> impl Iterator<Item = f64> {
        self.swinging().into_iter().map(|mode| mode.frequency_hz)
    }
}

/// Classifies the equilibrium `q`. `free` are the coordinates that may move, `magnitude` the sizes of the stiffness
/// terms there. `counted` are the directions that run away and those of zero stiffness, where a closer look has told them. `looked`
/// may have the sparse solver of a search.
///
/// # Errors
/// The element whose numbers are not finite.
pub(in crate::statics) fn classify(
    system: &mut System,
    q: &[f64],
    free: &[usize],
    magnitude: &[f64],
    conservative: bool,
    counted: Option<(usize, usize)>,
    looked: Option<Looked>,
) -> Result<Stability, Fault> {
    let model = &Arc::clone(system.model());
    let sweeps = || TangentSolver::covers(model) || (!model.is_constrained() && by_sweeps(model, free, &[]));
    if !by_matrices(model, free.len()) && conservative && sweeps() {
        return classify_by_sweeps(system, q, free, magnitude, Across::Full(Vec::new()), looked);
    }
    Matrices::Dense(DENSE).check(model)?;
    let rest = vec![0.0; model.velocity_count()];
    let full = system.at(0.0, q, &rest).linearize(&rest)?;
    let pick = |m: &Mat<f64>| Mat::from_fn(free.len(), free.len(), |i, j| m[(free[i], free[j])]);
    let linear =
        Linearization { stiffness: pick(&full.stiffness), damping: pick(&full.damping), mass: pick(&full.mass) };
    if free.is_empty() {
        return Ok(Stability::of(0, 0, Vec::new(), Vec::new()));
    }
    // Without damping loads with a potential need their stiffness alone.
    let motion = (!conservative || model.has_damping()).then(|| LinearMotion::new(&linear, magnitude));
    let (unstable, neutral) = counted.unwrap_or_else(|| match &motion {
        Some(motion) if !conservative => motion.count(),
        _ => count_by_stiffness(&symmetric(&linear.stiffness), magnitude),
    });
    let mut modes = match &motion {
        Some(motion) if !conservative => damped::natural(model, free, motion, &linear.mass, &|part| part),
        _ => undamped_modes(model, free, &linear, unstable, neutral),
    };
    if conservative && unstable + neutral == 0 && free.len() == rest.len() {
        sharpen(&mut modes, system, q, &symmetric(&linear.stiffness))?;
    }
    let damped = motion.filter(|_| model.has_damping());
    let damped = damped.map_or(Vec::new(), |motion| damped::modes(model, free, &motion, &linear.mass, &|part| part));
    match conservative {
        _ if damped.is_empty() => {}
        true => damped::grow(&mut modes, &damped, unstable),
        false => damped::label(&mut modes, &damped),
    }
    Ok(Stability::of(damped::runaway(&damped, unstable), neutral, modes, damped))
}

/// A large system: counts and lowest modes by sweeps, across `rows` that are held.
pub(in crate::statics) fn classify_by_sweeps(
    system: &mut System,
    q: &[f64],
    free: &[usize],
    magnitude: &[f64],
    rows: Across,
    looked: Option<Looked>,
) -> Result<Stability, Fault> {
    let model = &Arc::clone(system.model());
    let found = super::subspace::lowest(system, q, free, magnitude, rows, looked)?;
    let (unstable, neutral) = (found.unstable, found.neutral);
    let damped = match model.has_damping() {
        true => damped::within(system, q, free, &found.modes, &found.momenta),
        false => Vec::new(),
    };
    let modes = found.modes.into_iter().zip(&found.momenta).enumerate();
    let modes = modes.map(|(i, ((value, shape), momentum))| {
        let (frequency_hz, growth_rate) = rates_of(value, i, unstable, found.neutral_modes);
        let shares = shares(model, free, momentum, &shape);
        NaturalMode { frequency_hz, growth_rate, swings: growth_rate == 0.0, shape: scaled(&shape), shares }
    });
    let mut modes: Vec<NaturalMode> = modes.collect();
    if !damped.is_empty() {
        damped::grow(&mut modes, &damped, unstable);
    }
    Ok(Stability::of(damped::runaway(&damped, unstable), neutral, modes, damped))
}

/// Undamped modes `K x = λ M x`. Small eigenvalues are taken from the inverse problem where that is more accurate:
/// relative errors are `ε λ_max/λ` one way and `ε λ/λ_min` the other.
fn undamped_modes(
    model: &Model,
    free: &[usize],
    linear: &Linearization,
    unstable: usize,
    neutral: usize,
) -> Vec<NaturalMode> {
    let Some((mut values, vectors)) = generalized(&symmetric(&linear.stiffness), &symmetric(&linear.mass)) else {
        return Vec::new();
    };
    let n = values.len();
    if unstable + neutral == 0
        && let Some((inverse, _)) = generalized(&symmetric(&linear.mass), &symmetric(&linear.stiffness))
    {
        let (low, high) = (1.0 / inverse[n - 1], values[n - 1]);
        for (i, value) in values.iter_mut().enumerate() {
            let other = 1.0 / inverse[n - 1 - i];
            if other < (low * high).sqrt() {
                *value = other;
            }
        }
    }
    (0..n)
        .map(|i| {
            let shape: Vec<f64> = (0..n).map(|row| vectors[(row, i)]).collect();
            let momentum = momentum(&linear.mass, &shape);
            let shares = shares(model, free, &momentum, &shape);
            let (frequency_hz, growth_rate) = rates_of(values[i], i, unstable, neutral);
            NaturalMode { frequency_hz, growth_rate, swings: growth_rate == 0.0, shape: scaled(&shape), shares }
        })
        .collect()
}

/// High frequencies from the reduction, which keeps light bodies beside heavy ones that a mass matrix in hinge
/// coordinates loses: the eigenvalues of `Lᵀ M⁻¹ L` with `K = L Lᵀ`, whose errors are `ε λ_max`.
fn sharpen(modes: &mut [NaturalMode], system: &mut System, q: &[f64], stiffness: &Mat<f64>) -> Result<(), Fault> {
    let n = stiffness.nrows();
    let Ok(factor) = stiffness.llt(Side::Lower) else { return Ok(()) };
    let lower = factor.L();
    let (mut column, mut unit, rest) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut at = system.at(0.0, q, &rest);
    let mut mass = at.accelerations(&mut column)?;
    let mut inverse = Mat::zeros(n, n);
    for j in 0..n {
        unit[j] = 1.0;
        mass.solve_mass(&unit, &mut column);
        unit[j] = 0.0;
        (0..n).for_each(|i| inverse[(i, j)] = column[i]);
    }
    let product = symmetric(&(lower.transpose() * inverse * lower));
    let Ok(values) = product.self_adjoint_eigenvalues(Side::Lower) else { return Ok(()) };
    let lowest = modes.first().map_or(0.0, |mode| std::f64::consts::TAU * mode.frequency_hz);
    let middle = lowest * values[n - 1].max(0.0).sqrt();
    for (mode, value) in modes.iter_mut().zip(values).filter(|(_, value)| *value > middle) {
        mode.frequency_hz = value.sqrt() / std::f64::consts::TAU;
    }
    Ok(())
}

/// Eigenvalues, ascending, and vectors of `A x = λ B x` with `B` positive definite.
pub(in crate::statics) fn generalized(a: &Mat<f64>, b: &Mat<f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    let n = a.nrows();
    let factor = b.llt(Side::Lower).ok()?;
    let lower = factor.L().to_owned();
    let mut left = a.to_owned();
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(lower.as_ref(), left.as_mut(), faer::Par::Seq);
    let mut both = left.transpose().to_owned();
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(lower.as_ref(), both.as_mut(), faer::Par::Seq);
    let eigen = symmetric(&both).self_adjoint_eigen(Side::Lower).ok()?;
    let values: Vec<f64> = (0..n).map(|i| eigen.S()[i]).collect();
    let mut vectors = eigen.U().to_owned();
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(
        lower.transpose(),
        vectors.as_mut(),
        faer::Par::Seq,
    );
    values.iter().all(|x| x.is_finite()).then_some((values, vectors))
}
