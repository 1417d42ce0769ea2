//! A scene as a family: one of its numbers moves.

mod record;

use crate::dynamics::{Fault, System};
use crate::model::description::Description;
use crate::model::structure::Structure;
use crate::model::{Model, Parameter, Side, Stop};
use crate::statics::certify::bearing::{self, Set};
use crate::statics::certify::closed;
use crate::statics::certify::growing::Along;
use crate::statics::certify::motion::LinearMotion;
use crate::statics::certify::sides::Sides;
use crate::statics::certify::weak::{self, Around};
use crate::statics::problem::assembled::Assembled;
use crate::statics::problem::place::{Place, SHIFT};
use crate::statics::problem::sizes::{NEUTRAL, comparable, count_by_stiffness, relative};
use crate::statics::problem::{Branch, Landscape, apart, slides};
use crate::statics::search::curve::{Family, Look, Metric};
use faer::Mat;
use std::borrow::Cow;
use std::sync::Arc;

/// Half the distance over which `f_λ` is taken, as a part of the range: most numbers enter affinely, and the others bend
/// little over it.
const DIFFERENCE: f64 = 1e-4;

/// The scene at every value of its parameter.
pub(super) struct Moving<'a> {
    description: Description,
    parameters: &'a [Parameter],
    /// The scene as it was built last, and the value of the parameter there.
    built: Option<(f64, Arc<Model>)>,
    /// What the assembly of the loops at the start has decided.
    assembled: Assembled,
    /// Motions along the loops where the last solution was looked at.
    branch: Option<Branch>,
    /// The model at the start, with the stops that bear: its tree is that of all others.
    model: Arc<Model>,
    /// The stops of the scene, and which of them bear.
    stops: Vec<Stop>,
    set: Set,
    metric: Metric,
    /// Shift of the stiffness, as a part of the largest curvature: zero-stiffness motions make it singular.
    shift: f64,
}

/// Directions at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Count {
    /// That run away.
    pub unstable: usize,
    /// Of zero stiffness.
    pub neutral: usize,
    /// In which the stiffness is negative: the same where loads have a potential.
    pub negative: usize,
    /// Of those that run away the ones off stops that bear nothing, or on another side of a kink.
    pub sided: usize,
}

impl<'a> Moving<'a> {
    /// The family around an equilibrium at parameter `start`.
    ///
    /// # Errors
    /// If the scene cannot be built or evaluated there.
    pub(super) fn new(
        description: &Description,
        assembled: Assembled,
        parameters: &'a [Parameter],
        start: f64,
        range: f64,
        (q, set): (&[f64], Set),
    ) -> Result<Self, String> {
        let mut description = description.clone();
        let model = build(&mut description, parameters, start)?;
        let model = assembled.apply(model, &mut q.to_vec())?;
        let all = model.stops.clone();
        let (model, _) = resting(model, &set, q)?;
        let (inertia, reach) = {
            let mut system = System::new(&model);
            let landscape = Landscape::new(&mut system, q).map_err(|fault| fault.to_string())?;
            // Stops may leave nothing to move.
            let reach = if landscape.free.is_empty() { 1.0 } else { landscape.reach() };
            (landscape.metric, reach)
        };
        let metric = Metric { inertia, reach, range };
        let built = None;
        Ok(Self { description, parameters, built, assembled, branch: None, model, stops: all, set, metric, shift: 0.0 })
    }

    pub(super) fn metric(&self) -> &Metric {
        &self.metric
    }

    /// Which stops bear.
    pub(super) fn set(&self) -> &Set {
        &self.set
    }

    pub(super) fn stop(&self, index: usize) -> Stop {
        self.stops[index]
    }

    /// Whether a velocity coordinate is a distance.
    pub(super) fn slides(&self, velocity: usize) -> bool {
        slides(&self.model)[velocity]
    }

    pub(super) fn length(&self) -> f64 {
        self.model.length_scale()
    }

    /// What holds a coordinate (N or N m), and how large the forces are that act there.
    pub(super) fn held(&mut self, q: &[f64], parameter: f64, velocity: usize) -> Result<[f64; 2], String> {
        self.all_held(q, parameter).map(|all| all[velocity])
    }

    /// [`Moving::held`] of every coordinate.
    fn all_held(&mut self, q: &[f64], parameter: f64) -> Result<Vec<[f64; 2]>, String> {
        self.with(q, parameter, |landscape, q| {
            // With loops: the multipliers there.
            landscape.force(&q)?;
            let steady = landscape.steady.clone();
            let rest = vec![0.0; steady.len()];
            let mut residual = rest.clone();
            let system = landscape.system();
            let magnitudes = system.at(0.0, &q, &steady).residual(&rest, &mut residual)?.magnitudes();
            Ok(residual.iter().zip(&magnitudes.force).map(|(held, size)| [*held, *size]).collect())
        })
    }

    pub(super) fn model(&self) -> &Model {
        &self.model
    }

    /// Says that motions have zero stiffness all along the curve.
    pub(super) fn set_neutral(&mut self) {
        self.shift = SHIFT;
    }

    /// Calls `of` with the landscape at a value of the parameter, and with `q`: locked and driven hinges where that puts
    /// them, loops closed.
    fn with<T>(
        &mut self,
        q: &[f64],
        parameter: f64,
        of: impl FnOnce(&mut Landscape<'_>, Vec<f64>) -> Result<T, Fault>,
    ) -> Result<T, String> {
        let (model, q) = self.scene(q, parameter)?;
        let (model, q) = resting(model, &self.set, &q)?;
        let mut system = System::new(&model);
        let mut landscape = Landscape::new(&mut system, &q).map_err(|fault| fault.to_string())?;
        landscape.metric.clone_from(&self.metric.inertia);
        landscape.set_branch(self.branch.take());
        let result = of(&mut landscape, q).map_err(|fault| fault.to_string());
        self.branch = landscape.branch();
        result
    }

    /// The scene at a value of the parameter, its stops in it, and `q` there.
    fn scene(&mut self, q: &[f64], parameter: f64) -> Result<(Arc<Model>, Vec<f64>), String> {
        let is_built = |at: f64| self.parameters.is_empty() || at.to_bits() == parameter.to_bits();
        let model = match &self.built {
            Some((at, built)) if is_built(*at) => Arc::clone(built),
            _ => build(&mut self.description, self.parameters, parameter)?,
        };
        self.built = Some((parameter, Arc::clone(&model)));
        if model.position_count() != q.len() {
            return Err(format!(
                "at {parameter} the scene has {} coordinates, not {}: markers and sections of a beam cut it into another number of elements \
                 there; let them move with it by `[parameters]`",
                model.position_count(),
                q.len()
            ));
        }
        let mut q = q.to_vec();
        for body in model.bodies.iter().filter(|body| body.hinge.lock) {
            let range = body.hinge.position..body.hinge.position + body.hinge.kind.counts().0;
            q[range.clone()].copy_from_slice(&model.start_position[range]);
        }
        let model = self.assembled.apply(model, &mut q)?;
        Ok((model, q))
    }

    /// Takes other numbers of the scene as the ones that move; those before them get `value` again.
    pub(super) fn vary_by(&mut self, parameters: &'a [Parameter], value: f64) -> Result<(), String> {
        self.parameters.iter().try_for_each(|one| one.set(&mut self.description, value))?;
        (self.parameters, self.built) = (parameters, None);
        Ok(())
    }

    /// Directions that span the motions, each over the free coordinates, of unit size and perpendicular to each other in the metric;
    /// of a tree its free coordinates themselves. The scene is at `q`.
    pub(super) fn motions(&mut self, q: &[f64], parameter: f64) -> Result<Vec<Vec<f64>>, String> {
        let inertia = self.metric.inertia.clone();
        self.with(q, parameter, |landscape, q| {
            let n = inertia.len();
            if landscape.ties.is_none() {
                let one = |k: usize| (0..n).map(|i| if i == k { 1.0 / inertia[k].sqrt() } else { 0.0 }).collect();
                return Ok((0..n).map(one).collect());
            }
            let z = landscape.tangent(&q)?;
            Ok((0..z.ncols()).map(|k| (0..n).map(|i| z[(i, k)]).collect()).collect())
        })
    }

    /// Forces at `q`, loops closed at this value of the parameter, followed by what closing them has moved.
    pub(super) fn felt(&mut self, q: &[f64], parameter: f64) -> Result<Vec<f64>, String> {
        let (force, closed) = self.with(q, parameter, |landscape, q| Ok((landscape.force(&q)?, q)))?;
        let moved = if self.model.is_constrained() { self.apart(q, &closed) } else { vec![0.0; force.len()] };
        Ok([force, moved].concat())
    }

    /// How forces and closed positions change with the parameter: `∂f/∂λ`, and what loops that change with it move.
    pub(super) fn change(&mut self, q: &[f64], parameter: f64) -> Result<(Vec<f64>, Vec<f64>), String> {
        let half = DIFFERENCE * self.metric.range;
        // At the end of what a model accepts there is one side only.
        let (after, before) = (self.felt(q, parameter + half), self.felt(q, parameter - half));
        let (after, before, distance) = match (after, before) {
            (Ok(after), Ok(before)) => (after, before, 2.0 * half),
            (Ok(after), Err(_)) => (after, self.felt(q, parameter)?, half),
            (Err(_), Ok(before)) => (self.felt(q, parameter)?, before, half),
            (Err(reason), Err(_)) => return Err(reason),
        };
        let mut change: Vec<f64> =
            after.iter().zip(&before).map(|(after, before)| (after - before) / distance).collect();
        let moved = change.split_off(change.len() / 2);
        Ok((change, moved))
    }

    /// Whether the parameter is felt: at `q`, or beside it where symmetry hides it.
    pub(super) fn is_felt(&mut self, q: &[f64], parameter: f64) -> Result<bool, String> {
        let beside: Vec<f64> =
            (0..self.metric.inertia.len()).map(|i| 0.1 + 0.05 * (i as f64 * 1.618_033_988_75).fract()).collect();
        for q in [q.to_vec(), self.moved(q, &beside)] {
            let place = self.with(&q, parameter, Place::at)?;
            let (change, moved) = self.change(&q, parameter)?;
            let felt = |(change, noise): (&f64, &f64)| change.abs() * self.metric.range > 1e2 * noise;
            let moves = |x: &f64| x.abs() * self.metric.range > 1e-9;
            if change.iter().zip(&place.scales.noise).any(felt) || moved.iter().any(moves) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    pub(super) fn place(&mut self, q: &[f64], parameter: f64) -> Result<Place, String> {
        self.with(q, parameter, Place::at)
    }

    /// Counts directions at a solution.
    pub(super) fn count(&mut self, place: &Place, parameter: f64) -> Result<Count, String> {
        let count = self.count_on_stops(place, parameter)?;
        if count.unstable > 0 {
            return Ok(count);
        }
        Ok(match self.around(&place.q, parameter)?.map(|around| around.sides) {
            Some(Sides::Leave(leaving)) if leaving.falls => Count { unstable: 1, sided: 1, ..count },
            Some(Sides::Leave(_)) => Count { neutral: count.neutral + 1, ..count },
            _ => count,
        })
    }

    /// What is on all sides of a solution, if it has any.
    pub(super) fn around(&mut self, q: &[f64], parameter: f64) -> Result<Option<Around>, String> {
        let held = match self.set.iter().any(Option::is_some) {
            true => self.all_held(q, parameter)?,
            false => Vec::new(),
        };
        let (model, q) = self.scene(q, parameter)?;
        let load = |index: usize, side: Side| {
            let [held, size] = held[model.stops[index].velocity];
            [-side.sign() * held, size]
        };
        weak::around(&model, &self.set, &q, &load).map_err(|fault| fault.to_string())
    }

    /// Counts directions along the stops of the branch.
    fn count_on_stops(&mut self, place: &Place, parameter: f64) -> Result<Count, String> {
        let sided = 0;
        if self.metric.inertia.is_empty() {
            return Ok(Count { unstable: 0, neutral: 0, negative: 0, sided });
        }
        let magnitude = &place.scales.stiffness;
        self.with(&place.q, parameter, |landscape, q| {
            // Coriolis forces may hold what stiffness does not.
            if !landscape.conservative || landscape.steady.iter().any(|v| *v != 0.0) {
                let Along { linear, sizes: magnitude, .. } = Along::at(landscape, &q, magnitude)?;
                let (unstable, neutral) = LinearMotion::new(&linear, &magnitude).count();
                let negative = negative_real(&linear.stiffness, &magnitude);
                return Ok(Count { unstable, neutral, negative, sided });
            }
            landscape.look(&q)?;
            let shifted = |part: f64| comparable(magnitude).iter().map(|k| part * k).collect::<Vec<f64>>();
            let by_pivots = landscape
                .negatives(&shifted(NEUTRAL))
                .and_then(|unstable| Some((unstable, landscape.negatives(&shifted(-NEUTRAL))?)));
            let (unstable, neutral) = match by_pivots {
                Some((unstable, with_neutral)) => (unstable, with_neutral.saturating_sub(unstable)),
                None if landscape.ties.is_some() => {
                    let (z, h) = landscape.stiffness_along(&q)?;
                    closed::count(&z, &h, magnitude)
                }
                None => count_by_stiffness(&landscape.dense_stiffness(&q)?, magnitude),
            };
            Ok(Count { unstable, neutral, negative: unstable, sided })
        })
    }

    /// The direction that costs least at a place, of unit size, by inverse iteration from `first`.
    pub(super) fn softest(&mut self, q: &[f64], parameter: f64, first: Vec<f64>) -> Option<Vec<f64>> {
        let inertia = self.metric.inertia.clone();
        self.with(q, parameter, |landscape, q| {
            landscape.look(&q)?;
            let mut x = first;
            for _ in 0..4 {
                let rhs: Vec<f64> = x.iter().zip(&inertia).map(|(x, b)| b * x).collect();
                let Some(image) = landscape.solved_nearby(&q, &rhs)? else { return Ok(None) };
                let size = landscape.size(&image);
                x = image.iter().map(|x| x / size).collect();
            }
            Ok(Some(x))
        })
        .ok()?
        .filter(|x| x.iter().all(|x| x.is_finite()))
    }

    /// The stiffness seen along `b` where everything else gives way, `1 / bᵀBK⁻¹Bb`: near a place where one direction
    /// has zero stiffness, the stiffness of that direction.
    pub(super) fn stiffness_along(&mut self, q: &[f64], parameter: f64, b: &[f64]) -> Option<f64> {
        let rhs: Vec<f64> = b.iter().zip(&self.metric.inertia).map(|(b, m)| b * m).collect();
        let shift = self.shift;
        self.with(q, parameter, |landscape, q| {
            landscape.look(&q)?;
            let place = Place::at(landscape, q)?;
            Ok(landscape.newton_shifted(&rhs, &landscape.shift(&place, shift)))
        })
        .ok()?
        .map(|image| 1.0 / image.iter().zip(&rhs).map(|(x, b)| x * b).sum::<f64>())
    }

    /// What the coordinates answer to a change of the forces, `K x = change` along the loops; with `neutral` motions of zero
    /// stiffness stay where they are.
    pub(super) fn answer(
        &mut self,
        q: &[f64],
        parameter: f64,
        change: &[f64],
        neutral: bool,
    ) -> Result<Vec<f64>, String> {
        let solved = self.with(q, parameter, |landscape, q| {
            landscape.look(&q)?;
            if !neutral {
                return Ok(landscape.newton(change));
            }
            let place = Place::at(landscape, q)?;
            let [once, twice] = [SHIFT, 2.0 * SHIFT].map(|part| {
                let shift = landscape.shift(&place, part);
                landscape.newton_shifted(change, &shift)
            });
            // Extrapolated to no shift.
            Ok(once.zip(twice).map(|(once, twice)| once.iter().zip(&twice).map(|(a, b)| 2.0 * a - b).collect()))
        })?;
        solved.ok_or_else(|| "the stiffness is singular here".to_owned())
    }

    /// [`answer`](Self::answer) to each of several changes, where nothing has zero stiffness.
    pub(super) fn answers(&mut self, q: &[f64], parameter: f64, changes: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, String> {
        let solved = self.with(q, parameter, |landscape, q| {
            landscape.look(&q)?;
            Ok(changes.iter().map(|change| landscape.newton(change)).collect::<Option<Vec<_>>>())
        })?;
        solved.ok_or_else(|| "the stiffness is singular here".to_owned())
    }

    /// How two positions differ, in free velocity coordinates.
    pub(super) fn apart(&self, from: &[f64], to: &[f64]) -> Vec<f64> {
        let all = apart(&self.model, from, to);
        all.into_iter().zip(&self.model.coordinates).filter(|(_, at)| !at.lock).map(|(x, _)| x).collect()
    }
}

impl Family for Moving<'_> {
    fn look(&mut self, q: &[f64], parameter: f64) -> Result<Look, String> {
        let (change, moves) = self.change(q, parameter)?;
        let shift = self.shift;
        self.with(q, parameter, |landscape, q| {
            let place = Place::at(landscape, q)?;
            landscape.look(&place.q)?;
            let mut newton = landscape.newton_shifted(&place.force, &landscape.shift(&place, shift));
            if newton.is_none() && shift == 0.0 {
                newton = landscape.newton_shifted(&place.force, &landscape.shift(&place, SHIFT));
            }
            let newton = newton.unwrap_or_else(|| vec![f64::NAN; change.len()]);
            let mut slope = landscape.solve(&change);
            slope.iter_mut().zip(&moves).for_each(|(slope, moves)| *slope += moves);
            Ok(Look { place, newton, slope })
        })
    }

    fn moved(&mut self, q: &[f64], x: &[f64]) -> Vec<f64> {
        let mut full = vec![0.0; self.model.velocity_count()];
        let free = (0..full.len()).filter(|i| !self.model.coordinates[*i].lock).collect::<Vec<_>>();
        for (i, x) in free.into_iter().zip(x) {
            full[i] = *x;
        }
        let mut moved = q.to_vec();
        System::displace(&self.model, &mut moved, &full);
        moved
    }
}

/// The model while these stops bear, and the position on them.
fn resting(model: Arc<Model>, set: &Set, q: &[f64]) -> Result<(Arc<Model>, Vec<f64>), String> {
    if set.iter().all(Option::is_none) {
        return Ok((model, q.to_vec()));
    }
    bearing::with(&model, set, q).ok_or_else(|| "the loops have no position on the stops that bear".to_owned())
}

/// The model before the first stage: what the others make of the scene is not asked here, and each would be a model of its own.
fn build(description: &mut Description, parameters: &[Parameter], value: f64) -> Result<Arc<Model>, String> {
    parameters.iter().try_for_each(|one| one.set(description, value))?;
    let first = match description.stages.is_empty() {
        true => Cow::Borrowed(&*description),
        false => Cow::Owned(Structure::first(description).describe(description)),
    };
    Model::build(&first)
        .map_err(|problems| problems.first().map_or_else(String::new, |problem| problem.message.clone()))
}

/// Real eigenvalues of a stiffness without a potential that are negative: one changes its sign where the balance turns
/// singular.
fn negative_real(stiffness: &Mat<f64>, magnitude: &[f64]) -> usize {
    let values: Vec<faer::c64> = relative(stiffness, magnitude).eigenvalues().unwrap_or_default();
    values.iter().filter(|x| x.re < -NEUTRAL && x.im.abs() <= NEUTRAL * x.re.abs()).count()
}
