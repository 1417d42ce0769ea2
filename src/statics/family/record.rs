//! What is recorded of a place: poses, reactions, potential, outputs, frequencies.

use super::Moving;
use crate::dynamics::{Fault, Powers};
use crate::model::{Model, Side, Stop, StopLaw};
use crate::output::{Given, Outputs};
use crate::spatial::{Pose, Wrench};
use crate::statics::certify::bearing::{self, Set};
use crate::statics::problem::Landscape;
use faer::Mat;

/// What is recorded of a place.
pub(in crate::statics) struct Record {
    pub poses: Vec<Pose>,
    pub reactions: Vec<Wrench>,
    pub potential: f64,
    pub outputs: Vec<f64>,
    /// The output that is not a finite number, if there is one.
    pub fault: Option<Fault>,
    /// Unbalanced forces of the free coordinates.
    pub force: Vec<f64>,
    /// Of each shape that was asked for.
    pub curvatures: Vec<f64>,
}

impl Moving<'_> {
    /// What is recorded of a place; with it [`curvatures`] of these shapes in velocity coordinates.
    pub(in crate::statics) fn record(
        &mut self,
        q: &[f64],
        parameter: f64,
        shapes: &[&[f64]],
    ) -> Result<Record, String> {
        let (stops, set) = (self.stops.clone(), self.set.clone());
        self.with(q, parameter, |landscape, q| {
            let (potential, steady) = (landscape.potential(&q), landscape.steady.clone());
            let rest = vec![0.0; steady.len()];
            let (mut poses, mut reactions, mut residual) = (Vec::new(), Vec::new(), rest.clone());
            let (mut asked, mut powers) = (Outputs::new(landscape.model()), Powers::default());
            if Outputs::asks_power(landscape.model()) {
                powers = landscape.system().at(0.0, &q, &steady).powers();
            }
            // With loops: the multipliers there.
            let force = landscape.force(&q)?;
            let curvatures = curvatures(landscape, &q, shapes)?;
            let mut at = landscape.system().at(0.0, &q, &steady);
            at.share_multipliers()?;
            let mut energies = at.energies();
            energies.potential += joined(at.system().model(), &stops, &set);
            let balanced = at.residual(&rest, &mut residual)?;
            balanced.reactions(&mut reactions);
            let pushes = bearing::pushes(&stops, &set, &q, &residual);
            let (accelerations, account) = (&rest[..], [0.0; 2]);
            let given = Given {
                accelerations,
                reactions: &reactions,
                stops: &pushes,
                contacts: &[],
                energies,
                account,
                powers,
            };
            let outputs = asked.as_mut().map_or_else(Vec::new, |asked| asked.numbers(&balanced, &given).to_vec());
            let fault = asked.and_then(|asked| asked.check(balanced.system().model()).err());
            at.poses(&mut poses);
            Ok(Record { poses, reactions, potential, outputs, fault, force, curvatures })
        })
    }
}

/// `ω²` of motions that nothing damps, by Rayleigh's quotients of shapes in velocity coordinates brought onto the rows. The forces at `q`
/// have been asked for.
fn curvatures(landscape: &mut Landscape<'_>, q: &[f64], shapes: &[&[f64]]) -> Result<Vec<f64>, Fault> {
    if shapes.is_empty() {
        return Ok(Vec::new());
    }
    let (free, metric, steady) = (landscape.free.clone(), landscape.metric.clone(), landscape.steady.clone());
    let mut moves = Mat::zeros(free.len(), shapes.len());
    for (column, shape) in shapes.iter().enumerate() {
        let momentum: Vec<f64> = free.iter().zip(&metric).map(|(i, b)| b * shape[*i]).collect();
        let along = landscape.along_rows(q, &momentum)?;
        along.iter().zip(&metric).enumerate().for_each(|(row, (x, b))| moves[(row, column)] = x / b);
    }
    if landscape.ties.is_some() {
        landscape.share_prestress(q, &moves)?;
    }
    let mut full = Mat::zeros(steady.len(), shapes.len());
    for column in 0..shapes.len() {
        free.iter().enumerate().for_each(|(row, i)| full[(*i, column)] = moves[(row, column)]);
    }
    let pushed = landscape.system().at(0.0, q, &steady).stiffness_times(&full)?;
    let mut quotient = |column: usize| {
        let rates: Vec<f64> = (0..full.nrows()).map(|i| full[(i, column)]).collect();
        let work: f64 = rates.iter().enumerate().map(|(i, x)| x * pushed[(i, column)]).sum();
        work / (2.0 * landscape.system().at(0.0, q, &rates).energies().kinetic)
    };
    Ok((0..shapes.len()).map(&mut quotient).collect())
}

/// What the springs of hinges and of the compliant stops that bear on them hold more than the one spring that stands for both
/// (J): (1) of `bearing`.
fn joined(model: &Model, stops: &[Stop], set: &Set) -> f64 {
    let of = |(stop, side): (&Stop, &Option<Side>)| {
        let (Some(side), StopLaw::Compliant { stiffness, .. }) = (*side, stop.law) else { return 0.0 };
        let both = &model.coordinates[stop.velocity];
        let own = both.stiffness - stiffness;
        // `k (rest − limit) = k' (rest' − limit)`
        let preload = both.stiffness * (both.rest - stop.limit(side));
        if own <= 0.0 { 0.0 } else { 0.5 * preload * preload * stiffness / (own * both.stiffness) }
    };
    stops.iter().zip(set).map(of).sum()
}
