//! A system of bodies seen as a problem of time stepping: the only place where mechanics and integrators meet.

use super::bordered::Bordered;
use crate::dynamics::{Coefficients, Fault, System, TangentSolver};
use crate::integrate::{Failure, ImplicitProblem, Point, Problem};
use crate::model::{Joint, Model};
use faer::Mat;
use faer::linalg::solvers::{PartialPivLu, Solve};

/// [`System`] with what integrators ask for.
pub struct Motion<'m> {
    system: System<'m>,
    position_scales: Vec<f64>,
    velocity_scales: Vec<f64>,
    tangent: Tangent,
    /// Where a run stands with respect to singular positions; `None` without loops.
    passage: Option<Passage>,
}

/// How a run passes singular positions of its loops.
///
/// A state that is off the loops by `e` gets accelerations that are off by `e / c`, `c` being the clearance, and stages of
/// explicit methods are off by more than their steps' errors. So where the clearance is small the accelerations are
/// taken from the settled state: that is the same system on the loops, and as smooth beside them as the motion itself.
struct Passage {
    /// Steps may be asked for again, shorter: they are adaptive.
    retries: bool,
    /// How far from a singular position the last step ended.
    clearance: f64,
    /// The farthest that one has ended.
    widest: f64,
    /// A state to settle.
    position: Vec<f64>,
    velocity: Vec<f64>,
}

impl Passage {
    /// Nearer than this part of the farthest is near.
    const NEAR: f64 = 0.4;
    /// A step that starts with at least the first clearance is not ended within the second part of it: what is left to
    /// round-off there would be amplified most. The next step passes it.
    const SKIP: [f64; 2] = [1e-3, 0.2];

    fn is_near(&self) -> bool {
        self.clearance < Self::NEAR * self.widest
    }
}

/// The factorized tangents of an implicit step, one per slot.
enum Tangent {
    /// In O(n), by sweeps.
    Sweep(Vec<TangentSolver>),
    /// Dense: where a force between two bodies couples what the tree does not.
    Dense(Vec<Option<PartialPivLu<f64>>>),
    /// Dense and bordered: with loops, drives or gears.
    Bordered(Vec<Option<Bordered>>),
}

impl From<Fault> for Failure {
    fn from(fault: Fault) -> Self {
        Self { message: fault.to_string() }
    }
}

impl<'m> Motion<'m> {
    /// Scratch memory for a model.
    pub fn new(model: &'m Model) -> Self {
        let (length, time) = (model.length_scale(), model.time_scale());
        let mut position_scales = vec![1.0; model.position_count()];
        let mut velocity_scales = vec![1.0 / time; model.velocity_count()];
        for link in &model.links {
            if matches!(link.joint, Joint::Slide { .. }) {
                position_scales[link.position] = length;
                velocity_scales[link.velocity] = length / time;
            }
        }
        let passage = model.is_constrained().then(|| Passage {
            retries: false,
            clearance: 0.0,
            widest: f64::MIN_POSITIVE,
            position: model.start_position.clone(),
            velocity: model.start_velocity.clone(),
        });
        let tangent = match (model.is_constrained(), TangentSolver::covers(model)) {
            (true, _) => Tangent::Bordered(Vec::new()),
            (false, true) => Tangent::Sweep(Vec::new()),
            (false, false) => Tangent::Dense(Vec::new()),
        };
        Self { system: System::new(model), position_scales, velocity_scales, tangent, passage }
    }

    /// The system at a time (s), for what is recorded between steps.
    pub fn at(&mut self, time: f64) -> &mut System<'m> {
        at_time(&mut self.system, time)
    }

    /// Whether steps can be asked for again, shorter.
    pub fn set_retries(&mut self, retries: bool) {
        if let Some(passage) = &mut self.passage {
            passage.retries = retries;
        }
    }

    /// The model.
    pub fn model(&self) -> &'m Model {
        self.system.model()
    }
}

/// The one way from a time to the system.
fn at_time<'a, 'm>(system: &'a mut System<'m>, time: f64) -> &'a mut System<'m> {
    system.set_time(time);
    system
}

/// `½ p ∘ (0, ω)`: the rate of a quaternion from the angular velocity in the axes it leads from.
fn half_product(p: &[f64], w: &[f64]) -> [f64; 4] {
    [
        0.5 * (-p[1] * w[0] - p[2] * w[1] - p[3] * w[2]),
        0.5 * (p[0] * w[0] + p[2] * w[2] - p[3] * w[1]),
        0.5 * (p[0] * w[1] + p[3] * w[0] - p[1] * w[2]),
        0.5 * (p[0] * w[2] + p[1] * w[1] - p[2] * w[0]),
    ]
}

impl Problem for Motion<'_> {
    fn position_count(&self) -> usize {
        self.system.model().position_count()
    }

    fn velocity_count(&self) -> usize {
        self.system.model().velocity_count()
    }

    fn acceleration(&mut self, time: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<(), Failure> {
        match &mut self.passage {
            Some(passage) if passage.is_near() => {
                let Passage { position, velocity, .. } = passage;
                position.copy_from_slice(q);
                velocity.copy_from_slice(v);
                let system = at_time(&mut self.system, time);
                system.settle(position, velocity)?;
                Ok(system.accelerations(position, velocity, a)?)
            }
            _ => Ok(self.at(time).accelerations(q, v, a)?),
        }
    }

    fn position_rate(&self, q: &[f64], v: &[f64], rate: &mut [f64]) {
        for link in &self.system.model().links {
            let (at, from) = (link.position, link.velocity);
            match link.joint {
                Joint::None => {}
                Joint::Turn | Joint::Slide { .. } => rate[at] = v[from],
                Joint::Ball { .. } => {
                    rate[at..at + 4].copy_from_slice(&half_product(&q[at..at + 4], &v[from..from + 3]));
                }
            }
        }
    }

    fn normalize(&self, q: &mut [f64]) {
        for link in &self.system.model().links {
            if matches!(link.joint, Joint::Ball { .. }) {
                let p = &mut q[link.position..link.position + 4];
                let norm = p.iter().map(|x| x * x).sum::<f64>().sqrt();
                p.iter_mut().for_each(|x| *x /= norm);
            }
        }
    }

    fn project(&mut self, time: f64, q: &mut [f64], v: &mut [f64]) -> Result<bool, Failure> {
        let settled = self.at(time).settle(q, v)?;
        if let Some(passage) = &mut self.passage {
            let [far, part] = Passage::SKIP;
            if passage.retries && passage.clearance > far && settled.clearance < part * passage.clearance {
                return Err(Failure {
                    message: "the step ends too near to a singular position of the loops".to_owned(),
                });
            }
            passage.clearance = settled.clearance;
            passage.widest = passage.widest.max(settled.clearance);
        }
        Ok(settled.moved)
    }

    fn scales(&self) -> (&[f64], &[f64]) {
        (&self.position_scales, &self.velocity_scales)
    }
}

impl ImplicitProblem for Motion<'_> {
    fn implicit_position(&self, start: &[f64], step: f64, v: &[f64], q: &mut [f64]) {
        for link in &self.system.model().links {
            let (at, from) = (link.position, link.velocity);
            match link.joint {
                Joint::None => {}
                Joint::Turn | Joint::Slide { .. } => q[at] = start[at] + step * v[from],
                Joint::Ball { .. } => {
                    // (1 − ½ h Ω) p = p*, with Ω skew and Ω² = −|ω|²: p = (p* + ½ h Ω p*) / (1 + ¼ h² |ω|²)
                    let (p, w) = (&start[at..at + 4], &v[from..from + 3]);
                    let turned = half_product(p, w);
                    let scale = 1.0 + 0.25 * step * step * w.iter().map(|w| w * w).sum::<f64>();
                    for i in 0..4 {
                        q[at + i] = (p[i] + step * turned[i]) / scale;
                    }
                }
            }
        }
    }

    fn displace(&self, from: &[f64], by: &[f64], q: &mut [f64]) {
        q.copy_from_slice(from);
        System::displace(self.system.model(), q, by);
    }

    fn residual(&mut self, time: f64, q: &[f64], v: &[f64], a: &[f64], r: &mut [f64]) -> Result<(), Failure> {
        let system = self.at(time);
        if system.constraints().is_some() {
            // The multipliers of this state, see `bordered`.
            system.accelerations(q, v, r)?;
        }
        Ok(system.residual(q, v, a, r)?)
    }

    fn reserve(&mut self, slots: usize) {
        let model = self.system.model();
        match &mut self.tangent {
            Tangent::Sweep(solvers) if solvers.len() < slots => {
                solvers.resize_with(slots, || TangentSolver::new(model))
            }
            Tangent::Dense(factors) if factors.len() < slots => factors.resize_with(slots, || None),
            Tangent::Bordered(factors) if factors.len() < slots => factors.resize_with(slots, || None),
            Tangent::Sweep(_) | Tangent::Dense(_) | Tangent::Bordered(_) => {}
        }
    }

    fn factorize(&mut self, slot: usize, at: Point<'_>, c1: f64, c2: f64) -> Result<(), Failure> {
        let Point { time, q, v, a } = at;
        let system = at_time(&mut self.system, time);
        match &mut self.tangent {
            Tangent::Sweep(solvers) => {
                let with = Coefficients { c1, c2, ..Coefficients::default() };
                if !system.factorize_tangent(&mut solvers[slot], q, v, a, &with)? {
                    return Err(Failure { message: "the tangent of the implicit step is singular".to_owned() });
                }
            }
            Tangent::Dense(factors) => {
                let linear = system.linearize(q, v, a)?;
                let n = a.len();
                let tangent = Mat::from_fn(n, n, |i, j| {
                    linear.stiffness[(i, j)] + c1 * linear.damping[(i, j)] + c2 * linear.mass[(i, j)]
                });
                factors[slot] = Some(tangent.partial_piv_lu());
            }
            Tangent::Bordered(factors) => factors[slot] = Some(Bordered::of(system, q, v, a, c1, c2)?),
        }
        Ok(())
    }

    fn solve(&mut self, slot: usize, rhs: &mut [f64]) {
        match &mut self.tangent {
            Tangent::Sweep(solvers) => solvers[slot].solve(self.system.model(), rhs),
            Tangent::Dense(factors) => {
                let Some(factor) = &factors[slot] else { return rhs.fill(f64::NAN) };
                let mut x = Mat::from_fn(rhs.len(), 1, |i, _| rhs[i]);
                factor.solve_in_place(&mut x);
                for (i, value) in rhs.iter_mut().enumerate() {
                    *value = x[(i, 0)];
                }
            }
            Tangent::Bordered(factors) => match &factors[slot] {
                Some(factor) => factor.solve(rhs),
                None => rhs.fill(f64::NAN),
            },
        }
    }
}
