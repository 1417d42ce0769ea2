//! Inverse statics: the pose is given, the inputs that hold it are found.
//!
//! The forces left in the free coordinates are affine in hinge forces, free lengths, stiffnesses, loads and masses `u`:
//!
//! ```text
//! f(u) = f(u₀) + A (u − u₀) = 0,      least |S⁻¹(u − u₀)|                                     (1)
//! ```
//!
//! `S` holds the scene's own units (its weight, its length, and what follows from them), so newtons and metres compare;
//! rows are divided by the forces that cancel in them. The columns of `A` are differences of two balances, exact up to
//! round-off. What follows from a named number need not be affine in it: then (1) is a step of Newton's method, with columns of
//! its own at every step. With loops, drives and gears `f` is what their rows leave of the forces: multipliers are unknowns too, and
//! have no cost. The singular values of the scaled matrix tell how many unknowns the pose determines; what it leaves open
//! is filled by the least change from the values of the scenario. The answer is checked by the balance of a scene that
//! is built with it, not by (1).
//!
//! **Stops** that the pose touches bear the residual of their hinges, as multipliers do; one that would
//! have to pull is let go, and its hinge has to be balanced too. A pose beyond a rigid stop is refused.

use super::certify::bearing::{self, Set};
use super::certify::equilibrium::{self, Equilibrium};
use super::problem::Landscape;
use super::problem::assembled::Assembled;
use super::problem::place::Place;
use super::settings::Settings;
use crate::dynamics::{Fault, System};
use crate::model::description::Description;
use crate::model::parameter::{Field, Quantity};
use crate::model::problem::number;
use crate::model::{Model, Parameter};
use faer::Mat;
use std::sync::Arc;

/// Singular values below this part of the largest one are round-off: the balance knows its forces to some 1e-16 of
/// what cancels in it, and the columns are differences of two of them.
const RANK: f64 = 1e-11;
/// A value below this part of those in the scenario, in units `S`, may be round-off of them: (1) is solved to some units in the last
/// place of its terms, times what the singular values differ by.
const VANISHES: f64 = 1e-12;
/// Solutions that are refined from the balance of the scene they give.
const MOST_ROUNDS: usize = 4;
/// Newton steps where `f` is not affine, which converge by [`BENT`] each: none needs more that comes to an end.
const MOST_STEPS: usize = 30;
/// Over this part of their units `f` bends little: differences of named numbers, whose columns follow them.
const BENT: f64 = 1e-4;

/// Inputs, and the equilibrium that they make of the pose.
#[derive(Debug, Clone)]
pub struct InverseAnswer {
    /// The scene with the inputs that were found; as it was where they are not allowed.
    pub description: Description,
    /// Its model, standing in the pose.
    pub model: Arc<Model>,
    /// The certificate of the pose, with [`Equilibrium::unknowns`].
    pub found: Equilibrium,
}

/// The scaled problem (1) at one pose.
struct Problem<'a> {
    unknown: &'a [Parameter],
    /// `S`.
    units: Vec<f64>,
    columns: Mat<f64>,
    rows: Vec<f64>,
}

/// Finds the values of `unknown` that hold `pose`, all other numbers as in the description.
///
/// # Errors
/// If the system cannot be evaluated in this pose.
///
/// # Panics
/// If the description is not one that [`Model::build`] accepts.
pub fn hold(
    description: &Description,
    unknown: &[Parameter],
    pose: &[f64],
    settings: &Settings,
) -> Result<InverseAnswer, Fault> {
    let built = Model::build(description).expect("a description that was built before");
    let (given, assembled) = Assembled::of(built).expect("loops that were closed before");
    let given = given.starting_at(pose);
    let beyond = bearing::passed(&given, pose);
    if !beyond.is_empty() {
        return refused_by_stops(description, unknown, pose, given, &beyond, settings);
    }
    let mut search = Search { description, unknown, pose, settings, assembled: &assembled, let_go: Vec::new() };
    let mut set = bearing::touching(&given, pose);
    loop {
        let (best, bearing, found) = search.balance(&given, &set)?;
        let model = search.built(&best).unwrap_or_else(|| given.clone());
        match bearing::pulling(&model, &set, &bearing, &found)?.filter(|_| found.balanced) {
            Some(index) => {
                search.let_go.push(model.label(model.stops[index].velocity));
                set[index] = None;
            }
            None => {
                let found = bearing::finish(&model, &set, &bearing, found)?;
                return Ok(InverseAnswer { description: best, model, found });
            }
        }
    }
}

/// What is given, and which stops of the pose were let go because they would have to pull.
struct Search<'a> {
    description: &'a Description,
    unknown: &'a [Parameter],
    pose: &'a [f64],
    settings: &'a Settings,
    assembled: &'a Assembled,
    let_go: Vec<String>,
}

impl Search<'_> {
    /// The model of a description, standing in the pose; `None` if there is none.
    fn built(&self, description: &Description) -> Option<Arc<Model>> {
        let model = self.assembled.apply(Model::build(description).ok()?, &mut self.pose.to_vec()).ok()?;
        Some(model.starting_at(self.pose))
    }

    /// The model of a description with these stops active: what they bear is free, as what holds a lock.
    fn bearing(&self, description: &Description, set: &Set) -> Option<Arc<Model>> {
        let built = self.built(description)?;
        let (model, _) = bearing::with(&built, set, self.pose)?;
        Some(model.starting_at(self.pose))
    }

    /// The scene whose inputs hold the pose while these stops bear, its model with them, and its certificate.
    fn balance(&self, given: &Arc<Model>, set: &Set) -> Result<(Description, Arc<Model>, Equilibrium), Fault> {
        let Self { description, unknown, pose, settings, .. } = *self;
        let given = bearing::with(given, set, pose).map_or_else(|| given.clone(), |(model, _)| model);
        let build = |description: &Description| self.bearing(description, set);
        // One metric for all: what loops leave of a force is measured in it.
        let metric = metric(&given, pose)?;
        let place = |model: &Arc<Model>| place(model, pose, &metric);
        let first = place(&given)?;
        let bent = unknown.iter().any(|one| one.field == Field::Named);
        let mut problem = Problem::new(description, unknown, (&given, &first), &build, &place)?;
        // What only a stop feels is no mistake.
        let mut notes = if set.iter().any(Option::is_some) { Vec::new() } else { problem.useless() };
        let influential = notes.is_empty();
        let sizes = first.scales.force.clone();
        let (mut best, mut model, mut place_now) = (description.clone(), given, first);
        let mut rank = 0;
        for _ in 0..if bent { MOST_STEPS } else { MOST_ROUNDS } {
            if place_now.is_exact() {
                break;
            }
            let (change, independent) = problem.solve(&place_now.force);
            rank = independent;
            let mut next = best.clone();
            let set = |(one, change): (&Parameter, &f64)| one.set(&mut next, one.value(&best) + change);
            let allowed = unknown.iter().zip(&change).try_for_each(set);
            if let Some((zero, built, placed)) = problem.vanishing([description, &next], &build, &place)? {
                (best, model, place_now) = (zero, built, placed);
                break;
            }
            let Some(built) = allowed.ok().and_then(|()| build(&next)) else {
                notes.push(refused(&next, unknown));
                break;
            };
            let placed = place(&built)?;
            // By what cancels in (1): next to an answer of zero the forces of the answer are round-off themselves.
            if placed.residual_beside(&sizes) >= place_now.residual_beside(&sizes) {
                break;
            }
            (best, model, place_now) = (next, built, placed);
            if bent {
                problem = Problem::new(&best, unknown, (&model, &place_now), &build, &place)?;
            }
        }
        let open = unknown.len().saturating_sub(rank);
        if place_now.is_balanced() && rank > 0 && open > 0 && influential {
            notes.push(format!(
                "the pose determines {rank} of {} unknowns: of all answers this one changes the scenario's values least",
                unknown.len()
            ));
        }
        if !place_now.is_balanced() && !self.let_go.is_empty() {
            notes.push(format!("the stop of {} would have to pull to hold the pose", self.let_go.join(", ")));
        }
        if let (false, Some(name)) = (place_now.is_balanced(), flexible(&model)) {
            notes.push(format!(
                "the pose that is held is that of every part of `{name}`, too, which bends and stretches otherwise as its forces change: with \
                 `[statics] aim` say what is to stay where it is, such as outputs of positions or angles"
            ));
        }
        let model = model.starting_at(pose);
        let mut found = equilibrium::examine(&model, settings, pose, ("inverse", 0.0), notes)?;
        found.converged = found.balanced && influential;
        found.unknowns = unknown.iter().map(|one| (one.address.clone(), one.value(&best))).collect();
        Ok((best, model, found))
    }
}

/// A beam, cable or modal body of a model, if it has one.
fn flexible(model: &Model) -> Option<&str> {
    let first = model.beams.first().map(|beam| beam.name.as_str());
    first.or_else(|| model.modals.first().map(|modal| modal.name.as_str()))
}

/// A scene, its model and its balance.
type Balanced = (Description, Arc<Model>, Place);

/// A pose that cannot be taken: it stands beyond rigid stops.
fn refused_by_stops(
    description: &Description,
    unknown: &[Parameter],
    pose: &[f64],
    given: Arc<Model>,
    beyond: &[(String, f64, f64)],
    settings: &Settings,
) -> Result<InverseAnswer, Fault> {
    let passed = |(hinge, limit, value): &(String, f64, f64)| {
        format!("the pose is beyond the limit {} of {hinge}, which stands at {}", number(*limit), number(*value))
    };
    let notes = beyond.iter().map(passed).collect();
    let mut found = equilibrium::examine(&given, settings, pose, ("inverse", 0.0), notes)?;
    (found.converged, found.balanced, found.stability) = (false, false, None);
    found.unknowns = unknown.iter().map(|one| (one.address.clone(), one.value(description))).collect();
    Ok(InverseAnswer { description: description.clone(), model: given, found })
}

fn metric(model: &Arc<Model>, pose: &[f64]) -> Result<Vec<f64>, Fault> {
    let mut system = System::new(model);
    Ok(Landscape::new(&mut system, pose)?.metric)
}

fn place(model: &Arc<Model>, pose: &[f64], metric: &[f64]) -> Result<Place, Fault> {
    let mut system = System::new(model);
    let mut landscape = Landscape::new(&mut system, pose)?;
    landscape.metric.copy_from_slice(metric);
    Place::at(&mut landscape, pose.to_vec())
}

impl<'a> Problem<'a> {
    fn new(
        description: &Description,
        unknown: &'a [Parameter],
        (model, first): (&Model, &Place),
        build: &dyn Fn(&Description) -> Option<Arc<Model>>,
        place: &dyn Fn(&Arc<Model>) -> Result<Place, Fault>,
    ) -> Result<Self, Fault> {
        let largest = first.scales.force.iter().fold(0.0_f64, |m, f| m.max(*f));
        let rows: Vec<f64> = first
            .scales
            .force
            .iter()
            .map(|size| if *size > 0.0 { *size } else { largest })
            .map(|size| if size > 0.0 { size } else { 1.0 })
            .collect();
        let size = |one: &Parameter| unit(one.quantity, one.value(description), model, largest);
        let units: Vec<f64> = unknown.iter().map(size).collect();
        let mut columns = Mat::zeros(rows.len(), unknown.len());
        for (j, one) in unknown.iter().enumerate() {
            let mut moved = description.clone();
            // More of anything is allowed: lengths, masses and stiffnesses are bounded from below.
            let part = if one.field == Field::Named { BENT } else { 1.0 };
            let set = one.set(&mut moved, one.value(description) + part * units[j]);
            let Some(model) = set.ok().and_then(|()| build(&moved)) else { continue };
            let force = place(&model)?.force;
            for i in 0..rows.len() {
                let change = force[i] - first.force[i];
                // A change within the round-off of what it is the difference of is none.
                let noise = 4.0 * first.scales.noise[i];
                columns[(i, j)] = if change.abs() > noise { change / (part * rows[i]) } else { 0.0 };
            }
        }
        Ok(Self { unknown, units, columns, rows })
    }

    /// Unknowns that no free coordinate feels.
    fn useless(&self) -> Vec<String> {
        let none = |j: &usize| (0..self.rows.len()).all(|i| self.columns[(i, *j)] == 0.0);
        let names: Vec<String> =
            (0..self.unknown.len()).filter(none).map(|j| format!("`{}`", self.unknown[j].address)).collect();
        match names.len() {
            0 => Vec::new(),
            1 => vec![format!(
                "the unknown {} cannot influence the pose: no free hinge feels it, so that any value would do",
                names[0]
            )],
            _ => vec![format!(
                "the unknowns {} cannot influence the pose: no free hinge feels them, so that any values would do",
                names.join(", ")
            )],
        }
    }

    /// Answers of zero: the difference of two values leaves their round-off, beside which nothing can be balanced. The scene in
    /// which all unknowns vanish that are round-off of the values of the scenario, if it is balanced to the last digits.
    fn vanishing(
        &self,
        [before, found]: [&Description; 2],
        build: &dyn Fn(&Description) -> Option<Arc<Model>>,
        place: &dyn Fn(&Arc<Model>) -> Result<Place, Fault>,
    ) -> Result<Option<Balanced>, Fault> {
        let scaled = |(one, unit): (&Parameter, &f64), of: &Description| one.value(of).abs() / unit;
        let largest = self.unknown.iter().zip(&self.units).map(|one| scaled(one, before)).fold(0.0, f64::max);
        let all = self.unknown.iter().zip(&self.units);
        let vanish: Vec<&Parameter> =
            all.filter(|one| scaled(*one, found) <= VANISHES * largest).map(|(one, _)| one).collect();
        let mut zero = found.clone();
        let allowed = vanish.iter().try_for_each(|one| one.set(&mut zero, 0.0)).is_ok();
        let Some(model) = build(&zero).filter(|_| allowed && !vanish.is_empty()) else { return Ok(None) };
        let placed = place(&model)?;
        Ok(placed.is_exact().then_some((zero, model, placed)))
    }

    /// The change of least norm that solves (1) best, and the rank.
    fn solve(&self, force: &[f64]) -> (Vec<f64>, usize) {
        let Ok(svd) = self.columns.thin_svd() else { return (vec![0.0; self.units.len()], 0) };
        let (u, s, v) = (svd.U(), svd.S(), svd.V());
        let values: Vec<f64> = (0..s.dim()).map(|k| s[k]).collect();
        let rank = values.iter().filter(|x| **x > RANK * values[0]).count();
        let mut change = vec![0.0; self.units.len()];
        for k in 0..rank {
            let part: f64 = (0..force.len()).map(|i| u[(i, k)] * force[i] / self.rows[i]).sum();
            for (j, change) in change.iter_mut().enumerate() {
                *change -= self.units[j] * v[(j, k)] * part / values[k];
            }
        }
        (change, rank)
    }
}

/// The scene's own size of a quantity, of a stress or a plain number its `value`; `largest` is the largest force in the balance,
/// for scenes without weight.
pub(super) fn unit(quantity: Quantity, value: f64, model: &Model, largest: f64) -> f64 {
    let or_one = |x: f64| if x > 0.0 { x } else { 1.0 };
    let (gravity, length) = (model.gravity.norm(), model.length_scale());
    let weight = model.total_mass() * gravity;
    let force = if weight > 0.0 { weight } else { or_one(largest / length) };
    match quantity {
        Quantity::Force => force,
        Quantity::Torque | Quantity::TurnStiffness => force * length,
        Quantity::Length => length,
        Quantity::Angle => 1.0,
        Quantity::Stiffness => force / length,
        Quantity::Mass => or_one(model.total_mass()),
        Quantity::Acceleration => or_one(gravity),
        Quantity::Speed => length / model.time_scale(),
        Quantity::TurnRate => 1.0 / model.time_scale(),
        // How stiff a material is says nothing of the scene's own sizes.
        Quantity::Stress | Quantity::Plain => or_one(value.abs()),
    }
}

/// The values that balance needs and no model accepts.
fn refused(needed: &Description, unknown: &[Parameter]) -> String {
    let problems = Model::build(needed).err().unwrap_or_default();
    let values: Vec<String> = unknown
        .iter()
        .filter(|one| problems.iter().any(|problem| problem.element == one.element))
        .map(|one| format!("`{}` = {} {}", one.address, number(one.value(needed)), one.quantity.unit()))
        .collect();
    let why: Vec<String> = problems.iter().map(ToString::to_string).collect();
    format!("balance with the least change needs {}, which cannot be: {}", values.join(", "), why.join("; "))
}
