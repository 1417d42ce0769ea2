//! Loads whose effect is wanted in few places: passed over the way to the root only.

use super::{Load, Reduction, Singular, along};
use crate::model::{Joint, Model};
use crate::motion::Motion;
use crate::spatial::Wrench;
use crate::transfer::LinkAcceleration;
use nalgebra::Vector3;

impl Reduction {
    /// The factorization alone, for [`Reduction::solve`] and [`Reduction::pass`]; `tau` is any number per velocity.
    ///
    /// # Errors
    /// A hinge that nothing with inertia resists, or a number that is not finite.
    #[inline(never)]
    pub fn prepare(&mut self, model: &Model, motion: &Motion, tau: &[f64]) -> Result<(), Singular> {
        self.factorize(model, motion, &Load { applied: &[], tau }).map(|_| ())
    }

    /// Eq. (6) at one hinge for a load without velocity terms: takes `e` across it and gives `u` and `D⁻¹ u` (of a ball
    /// three numbers, else the first). `tau` is the hinge force on a single coordinate.
    ///
    /// Over the ways from loaded links to the root these are the only ones that are not zero, and for any two loads
    /// `b`, `c` it is `bᵀ M⁻¹ c = Σ uᵦ · D⁻¹ u꜀`: small systems of loads need no outward sweep.
    #[inline]
    pub fn pass(
        &self,
        model: &Model,
        motion: &Motion,
        index: usize,
        tau: f64,
        e: &mut Wrench,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let (link, at) = (&model.links[index], &motion.links[index]);
        match link.joint {
            // Models with flexible elements pass loads by [`Reduction::solve`].
            Joint::None | Joint::Flex { .. } => (Vector3::zeros(), Vector3::zeros()),
            Joint::Ball { .. } => {
                let (u, step, passed) = self.balls[self.plan[index].ball as usize].pass(at, e);
                *e = passed;
                (u, step)
            }
            _ => {
                let left = &self.hinges[index];
                let u = tau - along(&link.joint, &at.axis, e);
                let step = left.inverse * u;
                *e += left.SH.times(step);
                (Vector3::new(u, 0.0, 0.0), Vector3::new(step, 0.0, 0.0))
            }
        }
    }

    /// Accelerations of the links' root markers in the last solution.
    pub fn links(&self) -> &[LinkAcceleration] {
        &self.a
    }
}
