//! The certificate of an equilibrium with loops, drives or gears: motions along the closed positions decide.

use super::damped;
use super::known::{Known, look_closer};
use super::modes::{NaturalMode, momentum, rates_of, scaled, shares};
use super::motion::LinearMotion;
use super::stability::{Stability, StabilityVerdict, by_matrices, classify_by_sweeps, generalized};
use crate::constraint::LoopReaction;
use crate::dynamics::{Fault, Linearization};
use crate::model::Model;
use crate::statics::problem::bordered::Rows;
use crate::statics::problem::place::Place;
use crate::statics::problem::shared::Shared;
use crate::statics::problem::sizes::{count_by_stiffness, sizes, symmetric};
use crate::statics::problem::{Across, Landscape, Prestress};
use faer::Mat;
use std::sync::Arc;

/// Largest hinge acceleration that the unbalanced forces of a place make along the loops, and where it is balanced what
/// kind of equilibrium it is.
pub(in crate::statics) fn examine(
    landscape: &mut Landscape<'_>,
    place: &Place,
) -> Result<(f64, Option<Stability>), Fault> {
    let count = landscape.free.len();
    landscape.take_view(&place.q)?;
    landscape.heed_prestress(&place.q)?;
    if landscape.ties.as_ref().is_some_and(|ties| ties.sweeps) && !by_matrices(landscape.model(), count) {
        return examine_by_sweeps(landscape, place);
    }
    let (model, free, steady) = (&Arc::clone(landscape.model()), landscape.free.clone(), landscape.steady.clone());
    let z = landscape.tangent(&place.q)?;
    let shares = landscape.share_prestress(&place.q, &z)?;
    let rest = vec![0.0; steady.len()];
    let full = landscape.system().at(0.0, &place.q, &steady).linearize(&rest)?;
    let pick = |m: &Mat<f64>| Mat::from_fn(free.len(), free.len(), |i, j| m[(free[i], free[j])]);
    let mass = pick(&full.mass);
    let reduced = |m: &Mat<f64>| z.transpose() * m * &z;
    let linear = Linearization {
        stiffness: reduced(&pick(&full.stiffness)),
        damping: reduced(&pick(&full.damping)),
        mass: reduced(&mass),
    };
    let acceleration = acceleration(&linear, &z, &place.force);
    let spins = steady.iter().any(|v| *v != 0.0);
    let conservative = landscape.conservative && !spins;
    if !place.is_balanced() {
        return Ok((acceleration, None));
    }
    let with = |counted| classify(model, &free, &z, (&mass, &linear), place, conservative, counted);
    let mut stability = with(None);
    if shares {
        prestressed(landscape, place, (&z, &linear.stiffness), &mut stability)?;
    } else if conservative && stability.neutral_directions > 0 && by_matrices(model, count) {
        let Known { unstable, neutral, .. } = look_closer(landscape, place)?;
        if neutral != stability.neutral_directions {
            stability = with(Some((unstable, neutral)));
        }
    }
    Ok((acceleration, Some(stability)))
}

/// Where prestress of dependent rows stiffens motions: an equilibrium that equally stiff rows do not hold is stable if some
/// other share of the load certifies it. Nothing is told of its frequencies then.
fn prestressed(
    landscape: &mut Landscape<'_>,
    place: &Place,
    (z, stiffness): (&Mat<f64>, &Mat<f64>),
    stability: &mut Stability,
) -> Result<(), Fault> {
    let mut found = Prestress::Shared;
    if stability.verdict != StabilityVerdict::Stable
        && landscape.conservative
        && landscape.certified(&place.q, z, stiffness, &sizes(Some(z), &place.scales.stiffness))?.is_some()
    {
        found = Prestress::Certified;
        (stability.verdict, stability.unstable_directions, stability.neutral_directions) =
            (StabilityVerdict::Stable, 0, 0);
        stability.supposes = Some("rows that are linearly dependent are rigid");
        stability.modes.clear();
        stability.damped.clear();
    }
    if let Some(ties) = &mut landscape.ties {
        ties.prestress = found;
    }
    Ok(())
}

/// What a person should know of the prestress at the end of a search.
pub(in crate::statics) fn prestress_note(landscape: &Landscape<'_>) -> Option<String> {
    let text = match landscape.ties.as_ref()?.prestress {
        Prestress::None => return None,
        Prestress::Shared => {
            "rows that are linearly dependent here allow a motion of first order and none of second: rigid rows do not \
             determine how they share the load, nor the frequencies; these are the ones of equally stiff rows, in the limit of \
             large stiffness"
        }
        Prestress::Certified => {
            "rows that are linearly dependent here allow a motion of first order and none of second: rigid rows are stable, \
             equally stiff ones would give way by a distance that vanishes as they become stiffer; no frequencies are determined"
        }
    };
    Some(text.to_owned())
}

/// Examines closed positions by sweeps, which take time in proportion to the size of the scene.
fn examine_by_sweeps(landscape: &mut Landscape<'_>, place: &Place) -> Result<(f64, Option<Stability>), Fault> {
    let free = landscape.free.clone();
    let largest = largest_acceleration(landscape, place)?;
    if !place.is_balanced() {
        return Ok((largest, None));
    }
    // Accelerations have multipliers of their own.
    let rows = landscape.rows_across(&place.q)?;
    let looked = landscape.take_solver(&place.q);
    let stability = classify_by_sweeps(landscape.system(), &place.q, &free, &place.scales.stiffness, rows, looked)?;
    Ok((largest, Some(stability)))
}

/// Of the accelerations that unbalanced forces make along the loops, locked hinges held.
fn largest_acceleration(landscape: &mut Landscape<'_>, place: &Place) -> Result<f64, Fault> {
    let (free, n) = (landscape.free.clone(), landscape.steady.len());
    let largest = |a: &[f64]| a.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
    let (rest, mut force, mut acceleration) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    free.iter().zip(&place.force).for_each(|(i, f)| force[*i] = *f);
    let rows = match landscape.rows_across(&place.q)? {
        // At rest these are the accelerations that the rows allow.
        Across::Sparse(_) if free.len() == n => {
            landscape.system().at(0.0, &place.q, &rest).accelerations_alone(&mut acceleration)?;
            return Ok(largest(&acceleration));
        }
        Across::Sparse(held) => {
            let rows = held.rows();
            let full = |row: usize| {
                let mut full = vec![0.0; free.len()];
                rows.row(row).for_each(|(j, value)| full[j] = value);
                full
            };
            (0..rows.len()).map(full).collect()
        }
        Across::Full(rows) => rows,
    };
    // What the rows hold, and locked coordinates.
    let mut spread: Vec<Vec<f64>> = Vec::with_capacity(rows.len() + n - free.len());
    for row in &rows {
        let mut full = vec![0.0; n];
        free.iter().zip(row).for_each(|(i, x)| full[*i] = *x);
        spread.push(full);
    }
    let mut locked = vec![true; n];
    free.iter().for_each(|i| locked[*i] = false);
    spread.extend((0..n).filter(|i| locked[*i]).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()));
    let mut at = landscape.system().at(0.0, &place.q, &rest);
    let mut mass = at.accelerations(&mut acceleration)?;
    let mut solve = |rhs: &[f64]| {
        let mut x = vec![0.0; n];
        mass.solve_mass(rhs, &mut x);
        x
    };
    let mut across = Rows::new(spread);
    across.factorize(&mut solve);
    let mut acceleration = solve(&force);
    across.correct(&mut acceleration);
    Ok(largest(&acceleration))
}

/// What a person should know of the loops at the end of a search.
pub(in crate::statics) fn notes(landscape: &Landscape<'_>, shared: Option<&Shared>) -> Vec<String> {
    let Some(ties) = &landscape.ties else { return Vec::new() };
    let mut notes = Vec::new();
    if !ties.frozen.is_empty() {
        let frozen = ties.frozen.join(", ");
        notes.push(format!("the rest cannot stay at rest beside {frozen}: they are held where they are at t = 0"));
    }
    // Beside locks and stops that bear rows may be linearly dependent that are not without them.
    let held = shared.is_some_and(|shared| shared.regular && !shared.held.is_empty());
    if !held && ties.view.as_ref().is_some_and(|view| view.singular) {
        notes.push(
            "a singular position of the loops: their reactions are not determined here; the motions that exist only \
             in this position are left out"
                .to_owned(),
        );
    }
    notes
}

/// What a person should know of loops that share what they bear with locks and stops.
pub(in crate::statics) fn shared_note(model: &Model, shared: &Shared, loops: &[LoopReaction]) -> Option<String> {
    let names: Vec<String> = loops.iter().filter(|one| !one.unique).map(|one| format!("`{}`", one.name)).collect();
    let held: Vec<String> = shared.held.iter().map(|i| model.label(*i)).collect();
    (!names.is_empty() && !held.is_empty()).then(|| {
        format!(
            "{} and what holds {} share what they bear: of these forces no single one is unique",
            names.join(", "),
            held.join(", ")
        )
    })
}

fn acceleration(linear: &Linearization, z: &Mat<f64>, force: &[f64]) -> f64 {
    use faer::linalg::solvers::Solve;
    let count = z.ncols();
    if count == 0 {
        return 0.0;
    }
    let rhs = Mat::from_fn(count, 1, |j, _| force.iter().enumerate().map(|(i, f)| z[(i, j)] * f).sum());
    let a = z * linear.mass.partial_piv_lu().solve(&rhs);
    (0..a.nrows()).map(|i| a[(i, 0)].abs()).fold(0.0, f64::max)
}

/// Counts directions along the columns of `z`.
pub(in crate::statics) fn count(z: &Mat<f64>, stiffness: &Mat<f64>, magnitude: &[f64]) -> (usize, usize) {
    match z.ncols() {
        0 => (0, 0),
        _ => count_by_stiffness(&symmetric(stiffness), &sizes(Some(z), magnitude)),
    }
}

/// Verdict and modes of the motions along the loops. `counted` as in `stability::classify`.
fn classify(
    model: &Model,
    free: &[usize],
    z: &Mat<f64>,
    (mass, linear): (&Mat<f64>, &Linearization),
    place: &Place,
    conservative: bool,
    counted: Option<(usize, usize)>,
) -> Stability {
    if z.ncols() == 0 {
        return Stability::of(0, 0, Vec::new(), Vec::new());
    }
    // Without damping loads with a potential need their stiffness alone.
    let motion = (!conservative || model.has_damping())
        .then(|| LinearMotion::new(linear, &sizes(Some(z), &place.scales.stiffness)));
    let (unstable, neutral) = counted.unwrap_or_else(|| match &motion {
        Some(motion) if !conservative => motion.count(),
        _ => count(z, &linear.stiffness, &place.scales.stiffness),
    });
    let along = |y: Vec<f64>| (0..z.nrows()).map(|i| y.iter().enumerate().map(|(j, y)| z[(i, j)] * y).sum()).collect();
    let damped = motion.as_ref().filter(|_| model.has_damping());
    let damped = damped.map_or(Vec::new(), |motion| damped::modes(model, free, motion, mass, &along));
    if let Some(motion) = motion.filter(|_| !conservative) {
        let mut modes = damped::natural(model, free, &motion, mass, &along);
        if !damped.is_empty() {
            damped::label(&mut modes, &damped);
        }
        return Stability::of(damped::runaway(&damped, unstable), neutral, modes, damped);
    }
    let mode = |(k, (value, y)): (usize, (f64, Vec<f64>))| {
        let shape: Vec<f64> = (0..z.nrows()).map(|i| (0..y.len()).map(|j| z[(i, j)] * y[j]).sum()).collect();
        let (frequency_hz, growth_rate) = rates_of(value, k, unstable, neutral);
        let shares = shares(model, free, &momentum(mass, &shape), &shape);
        NaturalMode { frequency_hz, growth_rate, swings: growth_rate == 0.0, shares, shape: scaled(&shape) }
    };
    let found = generalized(&symmetric(&linear.stiffness), &symmetric(&linear.mass));
    let mut modes = found.map_or(Vec::new(), |(values, vectors)| {
        let count = values.len();
        let shapes = (0..count).map(|k| (0..count).map(|i| vectors[(i, k)]).collect::<Vec<f64>>());
        values.into_iter().zip(shapes).enumerate().map(mode).collect()
    });
    if !damped.is_empty() {
        damped::grow(&mut modes, &damped, unstable);
    }
    Stability::of(damped::runaway(&damped, unstable), neutral, modes, damped)
}
