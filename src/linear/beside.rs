//! How outputs vary that no chain rule here knows: what hinges, rows, stops and sections pass on, lengths of beams, energies and powers.
//!
//! Along a direction of the states and inputs the multipliers vary, too. With the residual's exact derivatives, λ of the rows and μ
//! of what holds a coordinate:
//!
//! ```text
//! (1)  Gᵀ δλ + E δμ = M δq̈ + D δq̇ + K δq − F δu          by the dependent coordinates; the others prove it
//! (2)  y(h) at q ⊕ h δq, q̇ + h δq̇, q̈ + h δq̈, u + h δu, λ + h δλ, μ + h δμ
//! (3)  δy = dy/dh at h = 0                                by extrapolated differences (`crate::extrapolate`)
//! (4)  δP = δu f·q̇                                        of an input that pushes with f: it has no potential, it does work
//! ```
//!
//! Energies and powers of what moves freely do not depend on how rows share a load; they are known where the rest is not.

use super::{Basis, Input, Mat, Place, kinks, push};
use crate::dynamics::{Fault, Linearization, System};
use crate::extrapolate::derivative;
use crate::force::Law;
use crate::model::output::{EnergyKind, ForceQuantity, PowerKind, Source};
use crate::model::{Model, Output, Quantity, StopLaw};
use crate::output::{AtStops, Outputs};
use crate::round_off::LOAD;
use faer::linalg::solvers::{PartialPivLu, Solve};
use nalgebra::Vector3;
use std::sync::Arc;

/// The largest distance of a difference, in parts of what is usual of a direction: a radian, the scene's length, these by its time, its
/// largest force.
const FIRST: f64 = 1e-2;
/// Parts of it that are tried where derivatives are not known with more: stresses of beams are those of another corner of the section a small
/// part of what strains usually are away. Over short distances round-off hides kinks of so many times its size.
const NEARER: [f64; 3] = [1.0, 1e-3, 1e-5];
const UNSEEN: f64 = 30.0;
/// A size of derivatives below which they count as small, in parts of what is usual.
const SMALL: f64 = 1e-3;
/// A derivative whose error is larger than this part of it, or of [`SMALL`], is not known.
const KNOWN: f64 = 1e-6;
/// A derivative below this part of what is usual is round-off: zero.
const ZERO: f64 = 1e-11;
/// Forces that (1) leaves unbalanced, in parts of the terms that cancel.
const BALANCED: f64 = 1e-9;

/// One direction of the states and inputs.
pub(super) struct Along<'a> {
    pub(super) position: &'a [f64],
    pub(super) velocity: &'a [f64],
    pub(super) acceleration: &'a [f64],
    /// The input that varies, if one does.
    pub(super) input: Option<&'a Input>,
}

/// A place whose outputs are looked at beside it.
pub(super) struct Beside<'a> {
    place: &'a Place,
    accelerations: &'a [f64],
    basis: &'a Basis,
    linear: &'a Linearization,
    rows: &'a Mat<f64>,
    /// Of the dependent coordinates' columns of `[Gᵀ E]`; `None` if nothing is tied.
    tied: Option<PartialPivLu<f64>>,
    multipliers: &'a [f64],
    /// What holds each velocity coordinate (N or N m).
    held: Vec<f64>,
    /// The numbers looked for, and their values at the place.
    numbers: Vec<usize>,
    center: Vec<f64>,
    /// What is usual of them.
    sizes: Vec<f64>,
    /// The scene's largest force (N).
    force: f64,
}

/// Whether an output is one of those, taken by themselves. Contacts and ledgers are none of the equations.
fn is_sought(quantity: &Quantity) -> bool {
    match quantity {
        Quantity::Force(ForceQuantity { source, .. }) => !matches!(source, Source::Contact(_)),
        Quantity::Energy(kind) => matches!(kind, EnergyKind::Kinetic | EnergyKind::Potential),
        Quantity::Reaction(_) | Quantity::Section(_) | Quantity::Length(_) | Quantity::Power(_) => true,
        _ => false,
    }
}

/// Whether an output depends on which row bears how much.
pub(super) fn is_shared(model: &Model, quantity: &Quantity) -> bool {
    match quantity {
        Quantity::Energy(_) | Quantity::Length(_) | Quantity::Power(PowerKind::Dissipated) => false,
        Quantity::Power(PowerKind::Input) => !model.drives.is_empty(),
        _ => true,
    }
}

/// What (1) solves for.
struct Shares {
    multipliers: Vec<f64>,
    /// By velocity coordinate.
    held: Vec<f64>,
}

impl<'a> Beside<'a> {
    /// The place, if outputs have numbers that are not known; with the multipliers of the rows solved for. `all` has the variations of all numbers, column by column.
    ///
    /// # Errors
    /// A place that cannot be evaluated.
    pub(super) fn new(
        system: &mut System,
        outputs: &mut Outputs,
        (place, accelerations): (&'a Place, &'a [f64]),
        (basis, linear, rows): (&'a Basis, &'a Linearization, &'a Mat<f64>),
        multipliers: &'a [f64],
        all: &[Vec<f64>],
    ) -> Result<Option<Self>, Fault> {
        let model = Arc::clone(system.model());
        let count = rows.nrows() + place.held.len();
        // Of what is tied more than once shares are not unique.
        let are_unique = basis.dependent.len() >= count;
        let sought = model
            .outputs
            .iter()
            .filter(|output| is_sought(&output.quantity) && (are_unique || !is_shared(&model, &output.quantity)));
        let unknown = |number: &usize| all.iter().any(|column| !column[*number].is_finite());
        let numbers: Vec<usize> = sought.flat_map(Output::range).filter(unknown).collect();
        if numbers.is_empty() {
            return Ok(None);
        }
        let tied = (count > 0 && are_unique).then(|| {
            let entry = |i: usize, j: usize| match j.checked_sub(rows.nrows()) {
                None => rows[(j, basis.dependent[i])],
                Some(held) => f64::from(u8::from(place.held[held] == basis.dependent[i])),
            };
            Mat::from_fn(count, count, entry).partial_piv_lu()
        });
        let mut held = vec![0.0; accelerations.len()];
        let mut residual = held.clone();
        system.set_multipliers(multipliers);
        let mut at = system.at(place.time, &place.position, &place.velocity);
        let terms = at.residual(accelerations, &mut residual)?.magnitudes().force;
        place.held.iter().for_each(|i| held[*i] = residual[*i]);
        let levers = levers(&model);
        let force = terms.iter().zip(&levers).map(|(term, lever)| term / lever).fold(0.0, f64::max);
        let force = if force > 0.0 { force } else { inertial(&model, linear) };
        let mut beside = Self {
            place,
            accelerations,
            basis,
            linear,
            rows,
            tied,
            multipliers,
            held,
            numbers,
            center: Vec::new(),
            sizes: Vec::new(),
            force,
        };
        let rest = vec![0.0; accelerations.len()];
        let here = Along { position: &rest, velocity: &rest, acceleration: &rest, input: None };
        beside.center = beside.at(system, outputs, &here, &Shares::none(&beside), 0.0)?;
        let units: Vec<&str> =
            model.outputs.iter().flat_map(|output| output.units.iter().map(String::as_str)).collect();
        let usual = |(number, value): (&usize, &f64)| usual(&model, units[*number], force).max(value.abs());
        beside.sizes = beside.numbers.iter().zip(&beside.center).map(usual).collect();
        Ok(Some(beside))
    }

    /// (3) of all numbers of the model: not a number where it is not known.
    ///
    /// # Errors
    /// A place that cannot be evaluated.
    pub(super) fn vary(
        &self,
        system: &mut System,
        outputs: &mut Outputs,
        along: &Along<'_>,
        count: usize,
    ) -> Result<Vec<f64>, Fault> {
        let model = Arc::clone(system.model());
        let mut all = vec![f64::NAN; count];
        let shares = self.shares(&model, along);
        let are_balanced = shares.is_some();
        let shares = shares.unwrap_or_else(|| Shares::none(self));
        let unit = self.unit(&model, along);
        let sizes: Vec<f64> = self.sizes.iter().map(|size| SMALL * size / unit).collect();
        let noise: Vec<f64> = self.sizes.iter().map(|size| LOAD.of(*size)).collect();
        let mut fault = None;
        let mut of = |h: f64| {
            self.at(system, outputs, along, &shares, h).map_err(|error| {
                let text = error.to_string();
                fault = Some(error);
                text
            })
        };
        for part in NEARER {
            let Ok(found) = derivative(&mut of, &self.center, part * FIRST * unit, (&sizes, &noise)) else {
                return fault.map_or(Ok(all), Err);
            };
            let unseen = |i: usize| if part < 1.0 { UNSEEN * noise[i] / (part * FIRST * unit) } else { 0.0 };
            for (i, number) in self.numbers.iter().enumerate() {
                let error = found.error[i].max(unseen(i));
                let (x, zero) = (found.value[i], ZERO * self.sizes[i] / unit);
                let is_unknown = found.kinks[i] || error > KNOWN * x.abs().max(sizes[i]);
                if is_unknown || !all[*number].is_nan() {
                    continue;
                }
                all[*number] = if x.abs() <= zero.max(error) { 0.0 } else { x };
            }
            if self.numbers.iter().all(|number| !all[*number].is_nan()) {
                break;
            }
        }
        let shared = |output: &&Output| !are_balanced && is_shared(&model, &output.quantity);
        model.outputs.iter().filter(shared).for_each(|output| all[output.range()].fill(f64::NAN));
        if let Some(input) = along.input {
            self.work(&model, input, &mut all);
        }
        Ok(all)
    }

    /// (4), and the energies and losses that do not vary with it.
    fn work(&self, model: &Model, input: &Input, all: &mut [f64]) {
        for output in &model.outputs {
            match output.quantity {
                Quantity::Energy(EnergyKind::Kinetic | EnergyKind::Potential)
                | Quantity::Power(PowerKind::Dissipated) => all[output.first] = 0.0,
                Quantity::Power(PowerKind::Input) => {
                    let pushed = push(model, self.place, input);
                    all[output.first] = pushed.iter().zip(&self.place.velocity).map(|(push, v)| push * v).sum();
                }
                _ => {}
            }
        }
    }

    /// (1); `None` if forces stay unbalanced.
    fn shares(&self, model: &Arc<Model>, along: &Along<'_>) -> Option<Shares> {
        let n = self.accelerations.len();
        let mut shares = Shares::none(self);
        let Some(tied) = &self.tied else { return Some(shares) };
        // The sum of each row, and of the sizes of its terms.
        let mut sums = vec![[0.0; 2]; n];
        let parts = [
            (&self.linear.stiffness, along.position),
            (&self.linear.damping, along.velocity),
            (&self.linear.mass, along.acceleration),
        ];
        fn add(sum: &mut [f64; 2], term: f64) {
            *sum = [sum[0] + term, sum[1] + term.abs()];
        }
        for (matrix, by) in parts {
            (0..n).for_each(|i| (0..n).for_each(|j| add(&mut sums[i], matrix[(i, j)] * by[j])));
        }
        if let Some(input) = along.input {
            push(model, self.place, input).into_iter().zip(&mut sums).for_each(|(push, sum)| add(sum, -push));
        }
        let dependent = &self.basis.dependent;
        let solved = tied.solve(Mat::from_fn(dependent.len(), 1, |i, _| sums[dependent[i]][0]));
        for row in 0..self.rows.nrows() {
            shares.multipliers[row] = solved[(row, 0)];
            (0..n).for_each(|i| add(&mut sums[i], -self.rows[(row, i)] * solved[(row, 0)]));
        }
        for (k, at) in self.place.held.iter().enumerate() {
            shares.held[*at] = solved[(self.rows.nrows() + k, 0)];
            add(&mut sums[*at], -shares.held[*at]);
        }
        let levers = levers(model);
        let most = sums.iter().zip(&levers).map(|([_, terms], lever)| terms / lever).fold(0.0, f64::max);
        sums.iter().zip(&levers).all(|([left, _], lever)| left.abs() <= BALANCED * most * lever).then_some(shares)
    }

    /// (2).
    fn at(
        &self,
        system: &mut System,
        outputs: &mut Outputs,
        along: &Along<'_>,
        shares: &Shares,
        h: f64,
    ) -> Result<Vec<f64>, Fault> {
        let model = Arc::clone(system.model());
        let moved = |from: &[f64], by: &[f64]| from.iter().zip(by).map(|(x, by)| x + h * by).collect::<Vec<f64>>();
        let mut q = self.place.position.clone();
        crate::motion::displace(&model, &mut q, &along.position.iter().map(|x| h * x).collect::<Vec<f64>>());
        let v = moved(&self.place.velocity, along.velocity);
        let a = moved(self.accelerations, along.acceleration);
        let stops = self.stopped(&model, [&q, &v], moved(&self.held, &shares.held));
        system.set_multipliers(&moved(self.multipliers, &shares.multipliers));
        let before = self.load(system, along, h);
        let told = outputs.look(system.at(self.place.time, &q, &v), &a, &stops, &[]);
        if let Some((element, law)) = before {
            system.set_force(element, law);
        }
        let all = told?.values;
        Ok(self.numbers.iter().map(|number| all[*number]).collect())
    }

    /// What stops do at a state, those that hold with these forces (N or N m).
    fn stopped(&self, model: &Model, [q, v]: [&[f64]; 2], held: Vec<f64>) -> AtStops {
        let mut all = AtStops { pushes: held, ..AtStops::default() };
        for stop in self.place.pressed.iter().map(|index| &model.stops[*index]) {
            if let Some(side) = stop.reached(self.place.position[stop.position], 0.0) {
                all.pushes[stop.velocity] -= side.sign() * stop.push(side, q, v);
                all.stored += stop.potential(side, q);
            }
            if let StopLaw::Compliant { damping, .. } = stop.law {
                all.dissipated += damping * v[stop.velocity].powi(2);
            }
        }
        all
    }

    /// What stops do at the place.
    pub(super) fn stopped_here(&self, model: &Model) -> AtStops {
        self.stopped(model, [&self.place.position, &self.place.velocity], self.held.clone())
    }

    /// Adds to a load that is the input; what it was before.
    fn load(&self, system: &mut System, along: &Along<'_>, h: f64) -> Option<(usize, Law)> {
        let Some(input @ &Input::Load { element, component, .. }) = along.input else { return None };
        let before = system.forces()[element].law.clone();
        let Law::Load(load) = &before else { return None };
        let mut both = [Vector3::zeros(); 2];
        both[component / 3] = h * input.own_axes(system.model()).column(component % 3);
        let more = load.with(both);
        system.set_force(element, Law::Load(more));
        Some((element, before))
    }

    /// What is usual along a direction, in its own unit.
    fn unit(&self, model: &Model, along: &Along<'_>) -> f64 {
        let (length, time) = (model.length_scale(), model.time_scale());
        let moves = |by: &[f64]| by.iter().any(|x| *x != 0.0);
        match along.input {
            Some(input) => match input.unit(model) {
                "N" => self.force,
                "N m" => self.force * length,
                "m/s²" => length / (time * time),
                _ => 1.0 / (time * time),
            },
            None if moves(along.position) => kinks::reach(model, along.position),
            None => kinks::reach(model, along.velocity) / time,
        }
    }
}

impl Shares {
    fn none(of: &Beside<'_>) -> Self {
        Self { multipliers: vec![0.0; of.multipliers.len()], held: vec![0.0; of.held.len()] }
    }
}

/// By what a force in each velocity coordinate is divided to be one in newtons (m, or 1).
fn levers(model: &Model) -> Vec<f64> {
    let mut levers = vec![model.length_scale(); model.velocity_count()];
    model.lengths().for_each(|i| levers[i] = 1.0);
    levers
}

/// A force (N) of a scene in which none acts: the largest that moves a coordinate by a radian, or by the scene's length, in its time.
fn inertial(model: &Model, linear: &Linearization) -> f64 {
    let (length, time) = (model.length_scale(), model.time_scale());
    let force = |(i, lever): (usize, &f64)| linear.mass[(i, i)] * (length / lever).powi(2) / (length * time * time);
    let largest = levers(model).iter().enumerate().map(force).fold(0.0, f64::max);
    if largest > 0.0 { largest } else { 1.0 }
}

/// What is usual of a number with a unit; 0 where nothing is known of it.
fn usual(model: &Model, unit: &str, force: f64) -> f64 {
    match unit {
        "N" => force,
        "N m" | "J" => force * model.length_scale(),
        "W" => force * model.length_scale() / model.time_scale(),
        "m" => model.length_scale(),
        _ => 0.0,
    }
}
