//! Loads whose effect is wanted in few places: passed over the way to the root only.

use super::{Load, Reduction, Singular, along};
use crate::element::MOST_COORDINATES;
use crate::element::modal::MOST_MODAL_COORDINATES;
use crate::model::{Joint, Link, Model};
use crate::motion::Motion;
use crate::spatial::Wrench;
use crate::transfer::LinkAcceleration;
use nalgebra::Vector3;

/// In how many parts of three coordinates [`Reduction::pass`] gives what it does at a link: one, but for flexible elements.
pub fn parts(link: &Link) -> usize {
    if link.joint.is_flex() { link.joint.counts().1.div_ceil(3) } else { 1 }
}

impl Reduction {
    /// The factorization alone, for [`Reduction::solve`] and [`Reduction::pass`]; `tau` is any number per velocity.
    ///
    /// # Errors
    /// A hinge that nothing with inertia resists, or a number that is not finite.
    #[inline(never)]
    pub fn prepare(&mut self, model: &Model, motion: &Motion, tau: &[f64]) -> Result<(), Singular> {
        self.factorize(model, motion, &Load { applied: &[], tau }).map(|_| ())
    }

    /// Eq. (6) at one hinge for a load without velocity terms: takes `e` across it and puts `u` and `D⁻¹ u`, three numbers a
    /// [part](parts) of its coordinates, zero for those it does not have. `tau` is the hinge force on a single coordinate. Of an
    /// element both are `L⁻¹ u` with `D = L Lᵀ`; of a modal body too, whose interfaces have the loads `passed` by link.
    ///
    /// Over the ways from loaded links to the root these are the only ones that are not zero, and for any two loads
    /// `b`, `c` it is `bᵀ M⁻¹ c = Σ uᵦ · D⁻¹ u꜀`: small systems of loads need no outward sweep.
    #[inline]
    pub fn pass(
        &self,
        (model, motion): (&Model, &Motion),
        (index, passed): (usize, &[Wrench]),
        tau: f64,
        e: &mut Wrench,
        mut put: impl FnMut([Vector3<f64>; 2]),
    ) {
        let (link, at) = (&model.links[index], &motion.links[index]);
        match link.joint {
            Joint::None | Joint::Interface { .. } => put([Vector3::zeros(); 2]),
            Joint::Modal { modal, count } => {
                let (body, mut y) = (&model.modals[modal], [0.0; MOST_MODAL_COORDINATES]);
                motion.modals[modal].pull(body.links.iter().map(|link| &passed[*link]), &mut y);
                y.iter_mut().for_each(|y| *y = -*y);
                *e += self.modals[modal].pass(&mut y[..count]);
                y.chunks_exact(3).take(parts(link)).for_each(|y| put([Vector3::from_column_slice(y); 2]));
            }
            Joint::Ball { .. } => {
                let (u, step, passed) = self.balls[self.plan[index].ball as usize].pass(at, e);
                *e = passed;
                put([u, step]);
            }
            Joint::Flex { rod, .. } | Joint::Along { rod } => {
                let mut y = [0.0; MOST_COORDINATES];
                let tau = if link.joint.is_scalar() { tau } else { 0.0 };
                *e = self.rods[rod].pass((&motion.rods[rod], &at.arm), tau, e, &mut y[..link.joint.counts().1]);
                y.chunks_exact(3).take(parts(link)).for_each(|y| put([Vector3::from_column_slice(y); 2]));
            }
            Joint::Turn | Joint::Slide { .. } | Joint::Screw { .. } => {
                let left = &self.hinges[index];
                let u = tau - along(&link.joint, &at.axis, e);
                let step = left.inverse * u;
                *e += left.SH.times(step);
                put([Vector3::new(u, 0.0, 0.0), Vector3::new(step, 0.0, 0.0)]);
            }
        }
    }

    /// Accelerations of the links' root markers in the last solution.
    pub fn links(&self) -> &[LinkAcceleration] {
        &self.a
    }
}
