//! The elimination of an element: eqs. (1) to (3).

use super::{eliminate_own, velocity_terms};
use crate::element::pivot::Pivot;
use crate::element::{Rod, RodMotion, halves, joined, row};
use crate::spatial::Wrench;
use crate::transfer::LinkAcceleration;
use crate::transfer::element::Reduced;
use nalgebra::{Vector3, Vector6};

/// An element, eliminated: with the factors `D = L Lᵀ` it is `G = N L⁻ᵀ` and `y = L⁻¹ u`.
#[derive(Debug, Clone)]
pub(in crate::transfer) struct RodPivot {
    pivot: Pivot,
    /// `N`, then `G`: one column per coordinate.
    columns: Vec<Wrench>,
    /// `ρ`, then `y`.
    load: Vec<f64>,
    /// The diagonal of `D`.
    inertia: Vec<f64>,
}

fn twist_of(a: &LinkAcceleration) -> Vector6<f64> {
    joined(&a.linear, &a.angular)
}

fn acceleration_of(twist: &Vector6<f64>) -> LinkAcceleration {
    let (linear, angular) = halves(twist);
    LinkAcceleration { linear, angular }
}

impl RodPivot {
    /// Room for an element.
    pub(in crate::transfer) fn new(rod: &Rod) -> Self {
        let m = rod.count();
        Self { pivot: Pivot::new(m), columns: vec![Wrench::ZERO; m], load: vec![0.0; m], inertia: vec![0.0; m] }
    }

    /// The diagonal of `D`: the inertia that each coordinate sees while everything outboard moves freely.
    pub(in crate::transfer) fn inertia(&self) -> &[f64] {
        &self.inertia
    }

    /// `S` and `e` of the tip's link in, those of the parent link at its root marker out; every coordinate has the armature.
    ///
    /// # Errors
    /// The pivot that is not positive.
    #[inline(never)]
    pub(in crate::transfer) fn eliminate(
        &mut self,
        (rod, at): (&Rod, &RodMotion),
        gravity: &Vector3<f64>,
        (armature, tau): (f64, &[f64]),
        (mut S, mut e): (Reduced, Wrench),
    ) -> Result<(Reduced, Wrench), f64> {
        let (m, last) = (rod.count(), rod.steps());
        self.pivot.clear();
        self.columns.fill(Wrench::ZERO);
        self.load.iter_mut().zip(tau).for_each(|(load, tau)| *load = -tau);
        for k in (0..=last).rev() {
            let link = &at.stations[k].link;
            if k > 0 && k < last {
                S.add_body(rod.slices[k].mass, &Vector3::zeros(), &link.inertia);
                e += velocity_terms(rod, at, k, gravity);
            }
            if at.moves || link.bias != Vector3::zeros() {
                let bias = link.velocity_terms();
                let twist = twist_of(&bias);
                e += S.times(&bias);
                self.load.iter_mut().zip(&self.columns).for_each(|(load, n)| *load += row(&twist, n));
            }
            if k > 0 {
                self.step(m, at.subspace(k), &S, &e);
            }
            self.columns.iter_mut().for_each(|n| *n = n.shifted(link.arm));
            (S, e) = (S.shifted(&link.arm), e.shifted(link.arm));
        }
        for (i, inertia) in self.inertia.iter_mut().enumerate() {
            *self.pivot.entry(i, i) += armature;
            *inertia = *self.pivot.entry(i, i);
        }
        self.load.iter_mut().for_each(|load| *load = -*load);
        eliminate_own(&mut self.pivot, &mut self.load, &mut self.columns, (&mut S, &mut e))?;
        Ok((S, e))
    }

    /// Eq. (2).
    fn step(&mut self, m: usize, subspace: &[Vector6<f64>], S: &Reduced, e: &Wrench) {
        for j in 0..m {
            let reach = S.times(&acceleration_of(&subspace[j]));
            self.load[j] += row(&subspace[j], e);
            let both = self.columns[j] + reach;
            for i in j..m {
                // N of rows from j on is still that of the station: symmetric in i and j.
                *self.pivot.entry(i, j) += row(&subspace[i], &both) + row(&subspace[j], &self.columns[i]);
            }
            self.columns[j] = both;
        }
    }

    /// Eqs. (3) for a load without velocity terms on the tip alone: `e` there in, what the parent gets more than that out, as
    /// seen at its root marker.
    pub(in crate::transfer) fn load(&mut self, at: &RodMotion, tau: &[f64], e: &Wrench) -> Wrench {
        for (i, load) in self.load.iter_mut().enumerate() {
            *load = tau[i] - at.project(i, e);
        }
        self.pivot.forward(&mut self.load, |y, factor, other| *y += factor * other, |y, factor| *y *= factor);
        self.columns.iter().zip(&self.load).fold(Wrench::ZERO, |mut sum, (g, y)| {
            sum.add_times(*y, g);
            sum
        })
    }

    /// Eqs. (3) for a load on the tip and one on every coordinate, nothing of it kept: `y = L⁻¹ u`, so that `uᵀ D⁻¹ u = yᵀ y`, and what the tip's link
    /// passes on, as seen at the tip.
    pub(in crate::transfer) fn pass(
        &self,
        (at, arm): (&RodMotion, &Vector3<f64>),
        tau: f64,
        e: &Wrench,
        y: &mut [f64],
    ) -> Wrench {
        y.iter_mut().enumerate().for_each(|(i, y)| *y = tau - at.project(i, e));
        self.pivot.forward(y, |y, factor, other| *y += factor * other, |y, factor| *y *= factor);
        let more = self.columns.iter().zip(&*y).fold(Wrench::ZERO, |mut sum, (g, y)| {
            sum.add_times(*y, g);
            sum
        });
        *e + more.shifted(-arm)
    }

    /// Eq. (3): `q̈` from the acceleration of the parent link.
    #[inline(never)]
    pub(in crate::transfer) fn solve(&self, parent: &LinkAcceleration, second: &mut [f64]) {
        let twist = twist_of(parent);
        for (i, out) in second.iter_mut().enumerate() {
            *out = self.load[i] - row(&twist, &self.columns[i]);
        }
        self.pivot.backward(second);
    }

    /// `uᵀ D⁻¹ u` of the last solution.
    pub(in crate::transfer) fn resisted(&self) -> f64 {
        self.load.iter().map(|y| y * y).sum()
    }
}
