//! A moment of inertia in principal axes: what turning it costs least in.

use super::Sym3;
use super::quad::{Columns, Quad};
use crate::round_off::PRINCIPAL_MOMENT;
use nalgebra::Vector3;

/// `J = middle 1 + Σ excess u uᵀ` over the axes of the least and the largest moment: turning it turns two axes instead
/// of a matrix, and only one for a body with two equal moments.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Principal {
    /// The moment in the middle (kg m²).
    middle: f64,
    /// What the others have beyond it (kg m²): the larger deviation first.
    excess: [f64; 2],
    axes: [Vector3<f64>; 2],
}

impl Principal {
    /// Decomposes a tensor; the result equals it to a few units in the last place of its largest moment.
    pub fn of(inertia: &Sym3) -> Self {
        let eigen = inertia.matrix().symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_by(|i, j| eigen.eigenvalues[*i].total_cmp(&eigen.eigenvalues[*j]));
        let middle = eigen.eigenvalues[order[1]];
        let part = |i: usize| {
            let excess = eigen.eigenvalues[i] - middle;
            // Round-off of the eigenvalues: the two moments are one.
            let equal = PRINCIPAL_MOMENT.hides(excess, eigen.eigenvalues[order[2]].abs());
            (if equal { 0.0 } else { excess }, eigen.eigenvectors.column(i).into_owned())
        };
        let (mut first, mut second) = (part(order[0]), part(order[2]));
        if second.0.abs() > first.0.abs() {
            std::mem::swap(&mut first, &mut second);
        }
        Self { middle, excess: [first.0, second.0], axes: [first.1, second.1] }
    }

    /// The moment in the middle, what the others have beyond it (kg m²), and the axes of those.
    pub(crate) fn parts(&self) -> (f64, [f64; 2], [Vector3<f64>; 2]) {
        (self.middle, self.excess, self.axes)
    }

    /// `R J Rᵀ`.
    #[inline(always)]
    pub fn turned(&self, turn: &Columns) -> Sym3 {
        let u = turn.times(&self.axes[0]);
        let (squares, products) = u.squares();
        let excess = Quad::all(self.excess[0]);
        let (mut diagonal, mut others) = (excess.times_add(squares, Quad::all(self.middle)), excess * products);
        if self.excess[1] != 0.0 {
            let (squares, products) = turn.times(&self.axes[1]).squares();
            let excess = Quad::all(self.excess[1]);
            (diagonal, others) = (excess.times_add(squares, diagonal), excess.times_add(products, others));
        }
        let (on, off) = (diagonal.vector(), others.vector());
        Sym3 { xx: on.x, yy: on.y, zz: on.z, xy: off.x, xz: off.y, yz: off.z }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    /// A tensor turned through its principal axes is the tensor turned entry by entry.
    #[test]
    fn turning_is_the_congruence() {
        let turn = *Rotation3::from_euler_angles(0.3, -1.1, 2.0).matrix();
        for moments in [[1.0, 2.0, 2.5], [2.0, 2.0, 1e-6], [0.0, 3.0, 3.0], [1.5, 1.5, 1.5], [0.0, 0.0, 0.0]] {
            let inertia = Sym3::diagonal(Vector3::from(moments)).turned(&turn.transpose());
            let (fast, slow) = (Principal::of(&inertia).turned(&Columns::of(&turn)), inertia.turned(&turn));
            let largest = moments.iter().fold(0.0_f64, |m, x| m.max(*x));
            // A dozen products of numbers up to the largest moment.
            assert!((fast.matrix() - slow.matrix()).amax() <= 12.0 * f64::EPSILON * largest, "{moments:?}");
        }
    }
}
