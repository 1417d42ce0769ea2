//! Statics seen as a landscape: generalized forces, stiffness and potential as functions of the free coordinates.

use crate::dynamics::{Fault, System};
use crate::model::{Joint, Model};
use faer::Mat;

/// The static problem of a model with its locked hinges held.
pub struct Landscape<'s, 'm> {
    system: &'s mut System<'m>,
    /// Indices of the velocity coordinates that may move.
    pub free: Vec<usize>,
    /// `B`: the inertia each free coordinate sees (kg, kg m²); makes radians and metres comparable.
    pub metric: Vec<f64>,
    /// Whether loads have a potential: then the stiffness is a Hessian and equilibria are its stationary points.
    pub conservative: bool,
    /// Work counters.
    pub residuals: usize,
    /// Stiffness matrices assembled.
    pub stiffnesses: usize,
    rest: Vec<f64>,
    full: Vec<f64>,
}

/// How large the terms are that must cancel in each free coordinate.
#[derive(Debug, Clone)]
pub struct Scales {
    /// Sum of the magnitudes of the forces in the balance (N, N m).
    pub force: Vec<f64>,
    /// Round-off level of the balance (N, N m).
    pub noise: Vec<f64>,
    /// Magnitude of the stiffness terms (N/m, N m/rad).
    pub stiffness: Vec<f64>,
}

impl<'s, 'm> Landscape<'s, 'm> {
    /// The landscape around `q`.
    ///
    /// # Errors
    /// A singular hinge, or the element whose numbers are not finite.
    pub fn new(system: &'s mut System<'m>, q: &[f64]) -> Result<Self, Fault> {
        let model = system.model();
        let n = model.velocity_count();
        let rest = vec![0.0; n];
        let mut full = vec![0.0; n];
        system.accelerations(q, &rest, &mut full)?;
        system.articulated_inertia(&mut full);
        let free: Vec<usize> = (0..n).filter(|i| !model.coordinates[*i].lock).collect();
        let metric = free.iter().map(|i| full[*i]).collect();
        let conservative = model.is_conservative();
        Ok(Self { system, free, metric, conservative, residuals: 0, stiffnesses: 0, rest, full })
    }

    /// The model.
    pub fn model(&self) -> &'m Model {
        self.system.model()
    }

    /// The system, for what comes after the search.
    pub fn system(&mut self) -> &mut System<'m> {
        self.system
    }

    /// The unbalanced force in each free coordinate: `−∂V/∂q` where there is a potential.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub fn force(&mut self, q: &[f64]) -> Result<Vec<f64>, Fault> {
        self.residuals += 1;
        self.system.residual(q, &self.rest, &self.rest, &mut self.full)?;
        Ok(self.free.iter().map(|i| -self.full[*i]).collect())
    }

    /// The stiffness matrix of the free coordinates; symmetric where loads have a potential.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub fn stiffness(&mut self, q: &[f64]) -> Result<Mat<f64>, Fault> {
        self.stiffnesses += 1;
        let full = self.system.static_stiffness(q)?;
        let (free, n) = (&self.free, self.free.len());
        Ok(if self.conservative {
            // Off equilibrium the coordinates of a ball have a connection term: the Hessian is the symmetric part.
            Mat::from_fn(n, n, |i, j| 0.5 * (full[(free[i], free[j])] + full[(free[j], free[i])]))
        } else {
            Mat::from_fn(n, n, |i, j| full[(free[i], free[j])])
        })
    }

    /// Potential energy (J).
    pub fn potential(&mut self, q: &[f64]) -> f64 {
        self.system.energies(q, &self.rest).potential
    }

    /// `q ⊞ x` with `x` in free coordinates.
    pub fn moved(&mut self, q: &[f64], x: &[f64]) -> Vec<f64> {
        self.full.fill(0.0);
        for (i, x) in self.free.iter().zip(x) {
            self.full[*i] = *x;
        }
        let mut moved = q.to_vec();
        System::displace(self.system.model(), &mut moved, &self.full);
        moved
    }

    /// `√(xᵀ B x)`.
    pub fn size(&self, x: &[f64]) -> f64 {
        x.iter().zip(&self.metric).map(|(x, b)| b * x * x).sum::<f64>().sqrt()
    }

    /// Magnitudes of the terms of the balance at `q`: a sweep of absolute values.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub fn scales(&mut self, q: &[f64]) -> Result<Scales, Fault> {
        self.force(q)?;
        let magnitudes = self.system.balance_magnitudes(q);
        let model = self.system.model();
        let length = model.length_scale();
        let pick = |of: &dyn Fn(usize) -> f64| self.free.iter().map(|i| of(*i)).collect::<Vec<f64>>();
        let slides = slides(model);
        let stiffness = |i: usize| {
            let per = if slides[i] { length } else { 1.0 };
            magnitudes.force[i] / per + magnitudes.stiffness[i]
        };
        Ok(Scales {
            force: pick(&|i| magnitudes.force[i]),
            noise: pick(&|i| f64::EPSILON * magnitudes.noise[i]),
            stiffness: pick(&stiffness),
        })
    }
}

/// Which velocity coordinates are distances.
pub(super) fn slides(model: &Model) -> Vec<bool> {
    let mut slides = vec![false; model.velocity_count()];
    for link in &model.links {
        if matches!(link.joint, Joint::Slide { .. }) {
            slides[link.velocity] = true;
        }
    }
    slides
}
