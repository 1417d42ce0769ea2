//! Modal bodies in the sweeps. The link of the frame has the coordinates, the interfaces are its children; what these carry is seen
//! by the coordinates before it is passed on to the frame as from a rigid body.
//!
//! ```text
//! (1) at an interface   ρ += Zᵀ (e + S γ),   P += Zᵀ S Z,   N += Xᵀ S Z;   S and e go on to the frame
//! (2) at the frame      S += M(q),   e += b,   N += [C; G],   P += Pᵣ,   ρ += b_q − τ
//! (3)                   D = P,   S' = S − N D⁻¹ Nᵀ,   e' = e − N D⁻¹ ρ,   q̈ = −D⁻¹ (ρ + Nᵀ a)
//! ```
//!
//! (2) are the equations of [`crate::element::modal`]. `Z` of an interface are the twists of its link for unit rates of the coordinates
//! while the frame stays.

use super::eliminate_own;
use crate::element::modal::{Modal, ModalMotion};
use crate::element::pivot::Pivot;
use crate::spatial::Wrench;
use crate::transfer::LinkAcceleration;
use crate::transfer::element::Reduced;
use nalgebra::Vector3;

/// A modal body, eliminated: with the factors `D = L Lᵀ` it is `G = N L⁻ᵀ` and `y = L⁻¹ u`.
#[derive(Debug, Clone)]
pub(in crate::transfer) struct ModalPivot {
    pivot: Pivot,
    /// `N`, then `G`.
    columns: Vec<Wrench>,
    /// `−ρ`, then `y`.
    load: Vec<f64>,
    /// The diagonal of `D`.
    inertia: Vec<f64>,
    /// What the interfaces have brought: P, by rows, `N`, `−ρ`; zero between two sweeps.
    brought: Brought,
}

#[derive(Debug, Clone)]
struct Brought {
    matrix: Vec<f64>,
    columns: Vec<Wrench>,
    load: Vec<f64>,
    /// Scratch: `S Z`.
    reach: Vec<Wrench>,
}

impl Brought {
    fn clear(&mut self) {
        self.matrix.fill(0.0);
        self.columns.fill(Wrench::ZERO);
        self.load.fill(0.0);
    }
}

impl ModalPivot {
    /// Room for a body.
    pub(in crate::transfer) fn new(modal: &Modal) -> Self {
        let m = modal.count();
        let brought = Brought {
            matrix: vec![0.0; m * m],
            columns: vec![Wrench::ZERO; m],
            load: vec![0.0; m],
            reach: vec![Wrench::ZERO; m],
        };
        Self {
            pivot: Pivot::new(m),
            columns: vec![Wrench::ZERO; m],
            load: vec![0.0; m],
            inertia: vec![0.0; m],
            brought,
        }
    }

    /// The diagonal of `D`: the inertia that each coordinate sees while everything outboard moves freely.
    pub(in crate::transfer) fn inertia(&self) -> &[f64] {
        &self.inertia
    }

    /// Forgets what interfaces brought to a sweep that broke off.
    pub(in crate::transfer) fn forget(&mut self) {
        self.brought.clear();
    }

    /// Eq. (1): `S` and `e` of the interface's link, `γ` and the arm from the frame.
    #[inline(never)]
    pub(in crate::transfer) fn interface(
        &mut self,
        at: &ModalMotion,
        tip: usize,
        (S, e): (&Reduced, &Wrench),
        (bias, arm): (&LinkAcceleration, Vector3<f64>),
    ) {
        let (tip, m) = (&at.tips[tip], at.q.len());
        let whole = *e + S.times(bias);
        tip.rows(&whole).for_each(|(i, row)| self.brought.load[i] -= row);
        for (k, (shift, spin)) in tip.columns.iter().enumerate() {
            let reach = S.times(&LinkAcceleration { linear: *shift, angular: *spin });
            self.brought.columns[tip.moved_by[k]] += reach.shifted(arm);
            self.brought.reach[k] = reach;
        }
        for (k, j) in tip.moved_by.iter().enumerate() {
            for (i, row) in tip.rows(&self.brought.reach[k]) {
                self.brought.matrix[i * m + j] += row;
            }
        }
    }

    /// Eqs. (2) and (3): `S` and `e` of the link of the frame in, what it passes on out, at its root marker.
    ///
    /// # Errors
    /// The pivot that is not positive.
    #[inline(never)]
    pub(in crate::transfer) fn eliminate(
        &mut self,
        (modal, at): (&Modal, &ModalMotion),
        gravity: &Vector3<f64>,
        tau: &[f64],
        (mut S, mut e): (Reduced, Wrench),
    ) -> Result<(Reduced, Wrench), f64> {
        let m = modal.count();
        S.add_body(modal.mass, &(at.first / modal.mass), &at.inertia);
        let fall = LinkAcceleration { linear: -gravity, angular: Vector3::zeros() };
        e += at.bias + Wrench { force: modal.mass * fall.linear, moment: at.first.cross(&fall.linear) };
        for i in 0..m {
            self.columns[i] = at.columns[i] + self.brought.columns[i];
            let weight = at.columns[i].force.dot(gravity);
            self.load[i] = tau[i] + weight - at.row_bias[i] + self.brought.load[i];
            for j in 0..=i {
                *self.pivot.entry(i, j) = modal.mass_matrix[i * m + j] + self.brought.matrix[i * m + j];
            }
            self.inertia[i] = *self.pivot.entry(i, i);
        }
        self.brought.clear();
        eliminate_own(&mut self.pivot, &mut self.load, &mut self.columns, (&mut S, &mut e))?;
        Ok((S, e))
    }

    /// Eq. (1) for a load without velocity terms on an interface's link.
    pub(in crate::transfer) fn load_interface(&mut self, at: &ModalMotion, tip: usize, e: &Wrench) {
        at.tips[tip].rows(e).for_each(|(i, row)| self.brought.load[i] -= row);
    }

    /// Eq. (3) for such a load: what the frame passes on more than `e`.
    pub(in crate::transfer) fn load(&mut self, tau: &[f64]) -> Wrench {
        for (i, load) in self.load.iter_mut().enumerate() {
            *load = tau[i] + self.brought.load[i];
        }
        self.brought.load.fill(0.0);
        self.pivot.forward(&mut self.load, |y, factor, other| *y += factor * other, |y, factor| *y *= factor);
        self.given(&self.load)
    }

    fn given(&self, y: &[f64]) -> Wrench {
        self.columns.iter().zip(y).fold(Wrench::ZERO, |mut sum, (g, y)| {
            sum.add_times(*y, g);
            sum
        })
    }

    /// Eq. (3) for loads on interfaces, nothing of it kept: `y = L⁻¹ u` in place of `u`, and what the frame passes on more.
    pub(in crate::transfer) fn pass(&self, y: &mut [f64]) -> Wrench {
        self.pivot.forward(y, |y, factor, other| *y += factor * other, |y, factor| *y *= factor);
        self.given(y)
    }

    /// Eq. (3): `q̈` from the acceleration of the frame.
    #[inline(never)]
    pub(in crate::transfer) fn solve(&self, frame: &LinkAcceleration, second: &mut [f64]) {
        for (i, out) in second.iter_mut().enumerate() {
            let n = &self.columns[i];
            *out = self.load[i] - n.force.dot(&frame.linear) - n.moment.dot(&frame.angular);
        }
        self.pivot.backward(second);
    }

    /// `uᵀ D⁻¹ u` of the last solution.
    pub(in crate::transfer) fn resisted(&self) -> f64 {
        self.load.iter().map(|y| y * y).sum()
    }
}
