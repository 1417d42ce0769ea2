//! The Newton matrix of an implicit stage beside contacts that move.
//!
//! With `a_c` the accelerations that closed contacts allow, loops and drives too, the residual of a stage is `r = a − a_c(t, q, v)`. Friction of what
//! slips makes the rows of contacts unsymmetric, and their forces turn with the places of contact; all of that is in differences of
//! `a_c`, one for each velocity coordinate:
//!
//! ```text
//! (1)  N = c₂ 1 − c₁ ∂a_c/∂v − ∂a_c/∂q
//! (2)  N e_j ≈ c₂ e_j − [a_c(q ⊞ ε e_j, v + c₁ ε e_j) − a_c(q, v)] / ε
//! ```
//!
//! Its error, a part in 10⁷, only costs that part of the convergence of Newton's method: what is solved is `r = 0`. The friction of a slip that
//! turns, `−μ f_n u/|u|`, changes within `|u|`: a displacement that is larger does not see how.

use crate::dynamics::Dense;

/// Size of the differences, in scales of coordinates.
const DIFFERENCE: f64 = 1e-7;

/// A factorized matrix (1), and room to make it.
pub(in crate::simulate) struct Differenced {
    matrix: Dense,
    /// `a_c` at the point, and displaced.
    base: Vec<f64>,
    moved: Vec<f64>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    by: Vec<f64>,
    /// Of the velocities.
    sizes: Vec<f64>,
}

/// One displacement of (2).
pub(in crate::simulate) struct Displaced<'a> {
    /// Where from (velocity coordinates).
    pub(in crate::simulate) by: &'a [f64],
    pub(in crate::simulate) position: &'a mut [f64],
    pub(in crate::simulate) velocity: &'a [f64],
    /// Where accelerations go.
    pub(in crate::simulate) a: &'a mut [f64],
}

impl Differenced {
    /// Room for so many positions and velocities.
    pub(in crate::simulate) fn new(positions: usize, velocities: usize) -> Self {
        let room = || vec![0.0; velocities];
        let (matrix, position) = (Dense::new(velocities), vec![0.0; positions]);
        Self { matrix, base: room(), moved: room(), position, velocity: room(), by: room(), sizes: room() }
    }

    /// Begins a matrix about a velocity `v` whose coordinates have `scales`: where `a_c` of the point goes, and the sizes of differences over
    /// velocities, which may be lowered.
    pub(in crate::simulate) fn begin(&mut self, v: &[f64], scales: &[f64]) -> (&mut [f64], &mut [f64]) {
        let size = |(scale, v): (&f64, &f64)| DIFFERENCE * scale.max(v.abs());
        self.sizes.iter_mut().zip(scales.iter().zip(v)).for_each(|(to, of)| *to = size(of));
        (&mut self.base, &mut self.sizes)
    }

    /// Factorizes (1) about the point of [`Differenced::begin`] and its velocity `v`, whose coordinates have `scales`, those of positions divided
    /// by the scene's `time` (s). `accelerations` has `a_c` of a displacement. `Ok(false)` where the matrix is singular.
    ///
    /// # Errors
    /// Those of `accelerations`.
    pub(in crate::simulate) fn factorize<E>(
        &mut self,
        v: &[f64],
        [c1, c2]: [f64; 2],
        (scales, time): (&[f64], f64),
        mut accelerations: impl FnMut(Displaced<'_>) -> Result<(), E>,
    ) -> Result<bool, E> {
        let Self { matrix, base, moved, position, velocity, by, sizes } = self;
        by.fill(0.0);
        velocity.copy_from_slice(v);
        for j in 0..v.len() {
            // The velocity moves with the position as within a stage, but never by more than its size.
            let size = (DIFFERENCE * scales[j] * time).min(sizes[j] / c1.max(f64::MIN_POSITIVE));
            by[j] = size;
            velocity[j] = v[j] + c1 * size;
            accelerations(Displaced { by, position, velocity, a: moved })?;
            for i in 0..v.len() {
                *matrix.entry(i, j) = f64::from(u8::from(i == j)) * c2 - (moved[i] - base[i]) / size;
            }
            (by[j], velocity[j]) = (0.0, v[j]);
        }
        Ok(matrix.eliminate())
    }

    /// `rhs ← N⁻¹ rhs`.
    pub(in crate::simulate) fn solve(&mut self, rhs: &mut [f64]) {
        self.matrix.solve(rhs);
    }
}
