//! When a number is only noise. Everything by which this program takes a computed number for zero, or two for one, because
//! arithmetic cannot tell them apart, is on this page.
//!
//! A number that ought to be zero comes out as what the terms that cancel in it leave. It counts as zero if
//!
//! ```text
//! (1)  |x| ≤ part · scale
//! ```
//!
//! **The scale** is the size of the terms, never that of `x`, and whoever asks has it: the time of a run, the length of the scene, the
//! largest entry of a matrix, the forces that cancel in a coordinate ([`crate::dynamics::Magnitudes`]).
//!
//! **The part** is a [`RoundOff`]. How `x` was computed decides how large it is:
//!
//! | computed by | part |
//! |---|---|
//! | a few operations on exact numbers: times, norms, pivots, sums of forces | 1 to 64 units in the last place |
//! | an iteration that goes on until nothing changes: closed loops, supports, sums over whole trees | 10⁻¹⁴ … 10⁻¹² |
//! | an elimination or an eigenvalue problem: entries of vectors | 10⁻⁹ |
//! | the root of one of these: double roots | 10⁻⁷ |
//!
//! What is the same quantity has one constant. Constants that are equal and stand apart are of different quantities.
//!
//! Not on this page are tolerances that are no matter of arithmetic, though small: how exactly a *method* answers (its own constants,
//! beside it), which rows or columns count as linearly *dependent* (`RANK`, `DEPENDENT`: with the reasons in `constraint/choose.rs`,
//! `sparse/rank.rs`, `statics/inverse.rs`), when forces *balance* (`BALANCED` in `statics/problem/place.rs`), what *touches*
//! (`contact/pairs.rs`). [`crate::integrate`] imports nothing of ours: the rounding of a state in its own norm is in
//! `integrate/step/norm.rs`.

/// Round-off, as a part of the scale of what it is the round-off of.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct RoundOff(f64);

impl RoundOff {
    /// So many units in the last place of a number just above one.
    const fn units(count: f64) -> Self {
        Self(count * f64::EPSILON)
    }

    /// The round-off of numbers of a size, in its unit.
    #[inline]
    #[must_use]
    pub const fn of(self, scale: f64) -> f64 {
        self.0 * scale
    }

    /// Test (1): whether a number is no more than the round-off of terms of a size.
    #[inline]
    #[must_use]
    pub fn hides(self, x: f64, scale: f64) -> bool {
        x.abs() <= self.of(scale)
    }

    /// The largest number ≥ 0 that is `x` but for round-off.
    #[inline]
    #[must_use]
    pub fn above(self, x: f64) -> f64 {
        x * (1.0 + self.0)
    }

    /// The smallest number ≥ 0 that is `x` but for round-off.
    #[inline]
    #[must_use]
    pub fn below(self, x: f64) -> f64 {
        x * (1.0 - self.0)
    }
}

// Times of a run.

/// Instants of a run that are one: a time is the sum of a few, or a multiple of a period.
pub const TIME: RoundOff = RoundOff::units(4.0);
/// How exactly an event is located if it is late in a run: a root is bracketed by times that are rounded themselves.
pub const EVENT_TIME: RoundOff = RoundOff::units(8.0);
/// Times that were meant to be one: written with a dozen digits in different places of a file, or counted from different origins.
pub const MEANT_TIME: RoundOff = RoundOff(1e-12);

/// Whether an instant has come at a time (s).
#[inline]
#[must_use]
pub fn has_come(instant: f64, time: f64) -> bool {
    instant <= TIME.above(time)
}

// Positions and speeds.

/// Norm of a quaternion that is one: the rounding of four numbers. What is this near is left as it is, so that a state stays the same
/// bits whoever takes it up.
pub const UNIT_NORM: RoundOff = RoundOff::units(8.0);
/// A coordinate at a limit of its hinge, beside the limit or the scene's length (1 rad): what projections onto limits leave.
pub const ON_A_LIMIT: RoundOff = RoundOff(1e-12);
/// A coordinate at an end of its curve, as part of the curve's length: that of integrals along it.
pub const ON_A_CURVE: RoundOff = RoundOff(1e-12);
/// Two places of a curve that are one, as part of the curve's extent: formulas lose digits in what cancels in them.
pub const ONE_PLACE: RoundOff = RoundOff(1e-9);
/// The parameter of a curve in its formulas, as part of itself: rounded, and again in each factor and sum on its way.
pub const PARAMETER: RoundOff = RoundOff::units(8.0);
/// Gap of a closed loop, as part of its component's reach, and of a contact that settles: there Newton's method comes to a standstill.
/// Speeds that are projected onto loops reach it as well, as part of the largest.
pub const CLOSED: RoundOff = RoundOff(1e-14);
/// Stiffness at closed positions, as part of its terms: positions are known to this part of the scene's length only.
pub const CLOSED_STIFFNESS: RoundOff = RoundOff(1e-12);
/// Gap between bodies in contact after a projection, as part of the scene's length.
pub const CONTACT_GAP: RoundOff = RoundOff(1e-13);
/// Speed along contacts after a projection, as part of the largest.
pub const CONTACT_SPEED: RoundOff = RoundOff(1e-13);
/// Speeds and accelerations, beside those of the scene or the largest: they come from a factorization of the whole tree.
pub const SPEED: RoundOff = RoundOff(1e-12);
/// Rise of a rebound from a stop, as part of the scene's length (1 rad): some roundings of a coordinate. A fall from there is as fast.
pub const REBOUND: RoundOff = RoundOff::units(8.0);
/// Rise of a rebound from a stop beside loops and gears, on which positions are settled to [`CLOSED`] only.
pub const REBOUND_BESIDE_LOOPS: RoundOff = RoundOff(32e-14);
/// Rise of a rebound between bodies: their gap is a difference of places, and has the roundings of both.
pub const REBOUND_OF_BODIES: RoundOff = RoundOff::units(64.0);
/// A watched value that is where it was, as part of itself: it has been added up from a few numbers.
pub const WATCHED: RoundOff = RoundOff::units(4.0);
/// That beside loops, drives and gears, on which states are settled to [`CLOSED`] only, step after step: what they hold strays by a few of these.
pub const WATCHED_BESIDE_LOOPS: RoundOff = RoundOff(1e-13);
/// What a formula gives twice: masses that do not grow, velocities that go on. Functions of the time lose digits in their arguments.
pub const FORMULA: RoundOff = RoundOff(1e-12);

// Forces and energies.

/// A sum of force terms, as part of the sum of their sizes; and what each coordinate adds to a stiffness.
pub const FORCE: RoundOff = RoundOff::units(16.0);
/// A sum of force terms, beside the root of the sum of their squares: that is the error to expect. Of scissors of 3 to 40 stages the
/// residual was a quarter of this.
pub const EXPECTED_FORCE: RoundOff = RoundOff::units(4.0);
/// Stiffness that rounding of a position leaves of forces that cancel, beside the stiffest.
pub const STIFFNESS: RoundOff = RoundOff::units(4.0);
/// What forces lack to a balance, as part of those that cancel in it: poses are settled to a dozen digits.
pub const LOAD: RoundOff = RoundOff(1e-12);
/// What supports have to bear, likewise: of 160 capsules and cylinders that settled in funnels one lacked 3e-12.
pub const BORNE: RoundOff = RoundOff(1e-11);
/// Loads of supports beside the largest of them: the conic program cannot tell smaller ones from zero.
pub const SUPPORT_LOAD: RoundOff = RoundOff(1e-13);
/// What beams bear, beside the weight or the largest load of the scene: all their elements pass it on. A straight column under a thrust of 1 N
/// was bent by 2e-12 N m.
pub const BEAM_LOAD: RoundOff = RoundOff(1e-10);
/// The second difference of a formula, as part of its values: what may cancel in it is not known.
pub const FORMULA_BEND: RoundOff = RoundOff(1e-11);
/// A change of energy, as part of the energies that it is the difference of: sums over all bodies.
pub const ENERGY: RoundOff = RoundOff(1e-13);

// Matrices.

/// Pivot of a hinge in the sweep, as part of the inertia that the hinge could see: the sums it is the difference of. A body with less
/// about an axis has no inertia about it.
pub const PIVOT: RoundOff = RoundOff::units(4.0);
/// Pivot of a hinge in the sweep of `∂q̈/∂q`, likewise: lower, as that sweep is of places that have accelerations.
pub const COLUMNS_PIVOT: RoundOff = RoundOff::units(1.0);
/// Pivot of a flexible element's block, as part of its diagonal entry.
pub const BLOCK_PIVOT: RoundOff = RoundOff::units(16.0);
/// Pivot of the sparse tangent, as part of what hinges pass on: within that of zero it does not say what is definite.
pub const SPARSE_PIVOT: RoundOff = RoundOff::units(64.0);
/// Pivot of a row of loops, drives and gears beside the row's own entry: at it the row is linearly dependent on those before it.
pub const ROW_PIVOT: RoundOff = RoundOff(1e-14);
/// Gap of a drive or gear, as part of the terms it is the sum of.
pub const ROW_GAP: RoundOff = RoundOff::units(1.0);
/// Difference of two principal moments beside the largest: as many as a 3×3 eigenvalue problem leaves.
pub const PRINCIPAL_MOMENT: RoundOff = RoundOff::units(4.0);
/// Eigenvalue of a matrix `AᵀA` of unit columns, for each column, beside the largest.
pub const NORMAL_EIGENVALUE: RoundOff = RoundOff::units(16.0);
/// Eigenvalue of the matrix of a Krylov space, beside the largest.
pub const KRYLOV_EIGENVALUE: RoundOff = RoundOff(1e-14);
/// Entry of an eigenvector, beside its largest: eigenvalues that are nearly equal mix their vectors.
pub const EIGENVECTOR: RoundOff = RoundOff(1e-9);
/// Eigenvalue of a motion, or its real or imaginary part, beside the largest: a double root splits by the square root of a unit in the
/// last place.
pub const DOUBLE_ROOT: RoundOff = RoundOff(1e-7);
/// Singular value of a matrix beside the largest, for each of its rows, and entries of products and solutions beside their terms: the
/// matrix is wrong by a few roundings of its own.
pub const SINGULAR_VALUE: RoundOff = RoundOff::units(8.0);

/// Power of forces that go with speeds, beside the largest such force: Coriolis forces are sums over the whole tree, and what they
/// leave of power, which they have none of, is their round-off.
pub const POWER: RoundOff = RoundOff(1e-12);

// What is read and what is shown.

/// Numbers of a file that ought to agree, as inertias and correlations: programs write ten digits or more.
pub const WRITTEN: RoundOff = RoundOff(1e-9);
/// Ratios of gears that say one thing twice: products of a few.
pub const RATIO: RoundOff = RoundOff(1e-12);
/// An output at an equilibrium, in its unit: no step brings it nearer to what it should be.
pub const OUTPUT: RoundOff = RoundOff(1e-14);
/// An equilibrium, as part of any number it follows from.
pub const EQUILIBRIUM: RoundOff = RoundOff(1e-12);
/// Numbers that are shown, beside the scene's length, weight or energy: below it they are shown as 0.
pub const SHOWN: RoundOff = RoundOff(1e-12);
/// Corners of faces that planes have cut, beside the largest coordinate: within it a point is in a plane, or pieces would be cut again
/// by the planes that they were cut by.
pub const CORNER: RoundOff = RoundOff::units(16.0);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_measured_by_what_cancels_not_by_what_remains() {
        let (left, terms) = (0.1 + 0.2 - 0.3, 0.6);
        assert!(left != 0.0 && TIME.hides(left, terms) && !TIME.hides(left, left));
        assert!(!TIME.hides(f64::NAN, terms), "a number that is none is not small");
    }

    #[test]
    fn an_instant_that_rounding_puts_behind_a_time_has_come() {
        let sum: f64 = (0..10).map(|_| 0.1).sum();
        assert!(sum < 1.0 && has_come(1.0, sum) && !has_come(1.0 + 1e-12, sum));
        assert!(TIME.below(1.0) < sum);
    }
}
