//! Curves of solutions: predictor and corrector with pseudo-arclength (Keller 1977), in O(n) sweeps.
//!
//! A family of balances `f(q, λ) = 0` has curves of solutions. With the tangent `(t, τ)` at one point the next one is
//! sought in the plane across it,
//!
//! ```text
//! K δq − f_λ δλ = f,      tᵀB δq / R² + τ δλ / Λ² = 0                                        (1)
//! K x = f,  K y = f_λ,    δλ = −(tᵀB x) / (tᵀB y + τ R²/Λ²),   δq = x + y δλ                 (2)
//! ```
//!
//! which stays regular where the curve turns back (K singular, λ at a fold). `B` is the inertia that the hinges see, `R`
//! a radian or a length of every coordinate at once, `Λ` the range of the parameter: arclength has no unit. The new
//! tangent is `(y, 1)` of unit length, turned forward.

use super::illinois::illinois;
use crate::statics::problem::place::Place;

/// Corrector iterations of one step.
const MOST_ITERATIONS: usize = 9;
/// How far a guess next to a solution may be corrected.
const NEAR: f64 = 1e-4;
/// Tangents of neighbouring points differ by less than this angle (cosine: 18 degrees).
const STRAIGHT: f64 = 0.95;

/// One-parameter family of static problems.
pub(in crate::statics) trait Family {
    /// Forces at a position and a parameter, and the two solutions of (2).
    ///
    /// # Errors
    /// Why there are none.
    fn look(&mut self, q: &[f64], parameter: f64) -> Result<Look, String>;

    /// `q ⊞ x`.
    fn moved(&mut self, q: &[f64], x: &[f64]) -> Vec<f64>;
}

/// What a family is at one place.
pub(in crate::statics) struct Look {
    /// The position, locked hinges where the parameter puts them, and its forces.
    pub place: Place,
    /// `x = K⁻¹ f`.
    pub newton: Vec<f64>,
    /// `y = K⁻¹ f_λ`.
    pub slope: Vec<f64>,
}

/// A direction in positions and parameter.
#[derive(Debug, Clone)]
pub(in crate::statics) struct Direction {
    pub x: Vec<f64>,
    pub parameter: f64,
}

/// A solution and where the curve goes from there.
#[derive(Debug, Clone)]
pub(in crate::statics) struct Point {
    pub place: Place,
    pub parameter: f64,
    /// Unit tangent.
    pub ahead: Direction,
    /// Corrector iterations that it took.
    pub iterations: usize,
}

/// The metric of a curve.
#[derive(Debug, Clone)]
pub(in crate::statics) struct Metric {
    /// `B`, free coordinates (kg, kg m²).
    pub inertia: Vec<f64>,
    /// `R` (m √kg).
    pub reach: f64,
    /// `Λ`, in units of the parameter.
    pub range: f64,
}

impl Metric {
    pub(in crate::statics) fn dot(&self, a: &Direction, b: &Direction) -> f64 {
        let positions: f64 = self.inertia.iter().zip(a.x.iter().zip(&b.x)).map(|(m, (a, b))| m * a * b).sum();
        positions / (self.reach * self.reach) + a.parameter * b.parameter / (self.range * self.range)
    }

    /// Square of the distance from the origin to the segment between two points.
    pub(in crate::statics) fn square_to_segment(&self, a: &Direction, b: &Direction) -> f64 {
        let x = a.x.iter().zip(&b.x).map(|(a, b)| b - a).collect();
        let along = Direction { x, parameter: b.parameter - a.parameter };
        let (square, length) = (self.dot(a, a), self.dot(&along, &along));
        let part = if length > 0.0 { (-self.dot(a, &along) / length).clamp(0.0, 1.0) } else { 0.0 };
        square + part * (2.0 * self.dot(a, &along) + part * length)
    }

    /// The direction of unit length; `None` if it has none.
    pub(in crate::statics) fn unit(&self, direction: &Direction) -> Option<Direction> {
        let size = self.dot(direction, direction).sqrt();
        let x = direction.x.iter().map(|x| x / size).collect();
        (size > 0.0 && size.is_finite()).then(|| Direction { x, parameter: direction.parameter / size })
    }
}

/// A family with its metric.
pub(in crate::statics) struct Curve<'f> {
    pub family: &'f mut dyn Family,
    pub metric: Metric,
    /// Why the last correction failed.
    pub reason: String,
    /// Whether corrections go on until nothing is gained: what is located asks for the last digits.
    sharp: bool,
}

impl<'f> Curve<'f> {
    pub(in crate::statics) fn new(family: &'f mut dyn Family, metric: Metric) -> Self {
        Self { family, metric, reason: String::new(), sharp: false }
    }

    /// The solution nearest to a guess within the plane across `normal`, no further than `within` from the guess (arclength
    /// of all corrections together): from further away the corrector may end on any other branch.
    pub(in crate::statics) fn correct(
        &mut self,
        q: Vec<f64>,
        parameter: f64,
        normal: &Direction,
        within: f64,
    ) -> Option<Point> {
        let (mut q, mut parameter, mut travelled) = (q, parameter, 0.0);
        let mut before = f64::INFINITY;
        for iterations in 0..MOST_ITERATIONS {
            let look = match self.family.look(&q, parameter) {
                Ok(look) => look,
                Err(reason) => {
                    self.reason = reason;
                    return None;
                }
            };
            let (residual, _) = look.place.residual();
            let better = residual < 0.5 * before;
            let done = if self.sharp { residual < 0.5 * f64::EPSILON } else { look.place.is_round_off() };
            if done || (look.place.is_balanced() && !better) {
                let along = Direction { x: look.slope, parameter: 1.0 };
                let mut ahead = self.metric.unit(&along)?;
                if self.metric.dot(&ahead, normal) < 0.0 {
                    ahead = Direction { x: ahead.x.iter().map(|x| -x).collect(), parameter: -ahead.parameter };
                }
                return Some(Point { place: look.place, parameter, ahead, iterations });
            }
            if residual > 10.0 * before || residual.is_nan() {
                break;
            }
            before = residual;
            let slope = Direction { x: look.slope, parameter: 1.0 };
            let newton = Direction { x: look.newton, parameter: 0.0 };
            let by = -self.metric.dot(normal, &newton) / self.metric.dot(normal, &slope);
            let step: Vec<f64> = newton.x.iter().zip(&slope.x).map(|(x, y)| x + y * by).collect();
            if !(by.is_finite() && step.iter().all(|x| x.is_finite())) {
                break;
            }
            q = self.family.moved(&look.place.q, &step);
            parameter += by;
            let correction = Direction { x: step, parameter: by };
            travelled += self.metric.dot(&correction, &correction).sqrt();
            if !(travelled <= within) {
                "the corrector leaves the neighbourhood of its guess".clone_into(&mut self.reason);
                return None;
            }
        }
        "the corrector does not converge".clone_into(&mut self.reason);
        None
    }

    /// The solution at arclength `s` from a point, along its tangent.
    pub(in crate::statics) fn ahead(&mut self, from: &Point, s: f64) -> Option<Point> {
        let x: Vec<f64> = from.ahead.x.iter().map(|x| s * x).collect();
        let q = self.family.moved(&from.place.q, &x);
        self.correct(q, from.parameter + s * from.ahead.parameter, &from.ahead, s.abs().max(NEAR))
    }

    /// The solution at arclength `s` from a point, if the tangents show that it belongs to the same curve.
    pub(in crate::statics) fn step(&mut self, from: &Point, s: f64) -> Option<Point> {
        let next = self.ahead(from, s)?;
        let straight = self.metric.dot(&next.ahead, &from.ahead) > STRAIGHT;
        if !straight {
            "the curve bends too much".clone_into(&mut self.reason);
        }
        straight.then_some(next)
    }

    /// Where `of` passes zero between two arclengths from a point, by the Illinois rule; with its arclength. `ends` are
    /// both arclengths with their values, of different signs.
    pub(in crate::statics) fn root(
        &mut self,
        from: &Point,
        ends: [(f64, f64); 2],
        small: f64,
        of: &mut dyn FnMut(&mut Self, &Point) -> Option<f64>,
    ) -> Option<(f64, Point)> {
        self.sharp = true;
        illinois(ends, small, |s| {
            let point = self.ahead(from, s)?;
            let value = of(self, &point)?;
            Some((value, point))
        })
    }
}
