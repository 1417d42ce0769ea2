//! A body guided along a curve: one coordinate, the arc length `s`, and a motion subspace that depends on it.
//!
//! With the tangent `t` of the curve, primes for derivatives by `s`, and `F` from the axes of the guided body to those of the
//! hinge frame (eqs. 61 and 62 of the paper have the kinematics; `Z` takes the part of the relative velocities there):
//!
//! ```text
//! (9)  s(u) = ∫ |dp/du| du,   t = p',   t' … t''' by the chain rule from four derivatives of p(u)
//! (10) held      F = 1,                 Z = [t; 0],        Z' = [t'; 0],          Z'' = [t''; 0]
//!      follows   F x = t, ω = t × t'    Z = [x; Fᵀ ω],     Z' = [0; Fᵀ ω'],       Z'' = [0; Fᵀ (ω'' − ω × ω')]
//! (11) Ż = Z' ṡ,   Z̈ = Z'' ṡ² + Z' s̈,   Γ = Z'ᵀ f
//! ```
//!
//! A frame that follows turns with the tangent and not about it: it exists on every smooth curve, also where that is straight.
//! On a piece of the curve it is the shortest turn from the tangent at its beginning, and a turn about the tangent,
//!
//! ```text
//! (12) F = exp(φ t) T(t₀ → t) F₀,   φ = ∫ t₀·(t × dt)/(1 + t₀·t)
//! ```
//!
//! On every piece the tangents, too, lead from one end to the other, `∫ p' du = Δp`: a curve with a gap, or with a steep part between two looks,
//! does not.
//!
//! Beyond its ends the curve goes on straight, for trial steps alone: no run and no equilibrium is accepted there.

mod curve;
mod outline;
mod spline;

pub use curve::{GuideCurve, GuideFlaw};

use super::exponential::joined;
use super::quadrature::GAUSS;
use crate::round_off::{ONE_PLACE, PARAMETER};
use curve::{CLOSED, GAP, Line};
use nalgebra::{Matrix3, UnitQuaternion, Vector3, Vector6};

/// The tangent turns by no more than this within a piece (rad).
const MOST_TURN: f64 = 0.3;
/// A piece is resolved if halving it changes its length by no more than this part.
const LENGTH: f64 = 1e-13;
/// … and if the derivative of the tangent integrates to its change within this.
const TANGENT: f64 = 1e-11;
/// Below this part of the whole parameter no piece is halved: the curve is not smooth there.
const SHORTEST: f64 = 1e-9;
/// A curve with more pieces than this asks for more than it can have.
const MOST_PIECES: usize = 200_000;

/// A curve by its arc length.
#[derive(Debug, Clone, PartialEq)]
pub struct Guide {
    line: Line,
    follows: bool,
    /// Where its pieces begin, and where the last one ends.
    knots: Vec<Knot>,
}

/// The end of a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Knot {
    s: f64,
    u: f64,
    speed: f64,
    tangent: Vector3<f64>,
    frame: Matrix3<f64>,
}

/// A place on a curve with the derivatives of its tangent by arc length.
#[derive(Debug, Clone, Copy)]
struct Along {
    speed: f64,
    place: Vector3<f64>,
    /// `t`, `t'`, `t''`, `t'''`.
    tangent: [Vector3<f64>; 4],
}

/// What eq. (10) says at one place: turn and shift from the hinge frame, and `Z`, `Z'`, `Z''`.
#[derive(Debug, Clone, Copy)]
pub struct Guided {
    /// `F`.
    pub turn: Matrix3<f64>,
    /// From the origin of the hinge frame (m).
    pub place: Vector3<f64>,
    /// By the arc length.
    pub subspaces: [Vector6<f64>; 3],
}

impl Guide {
    /// Compiles a curve; a body that `follows` turns with the tangent.
    ///
    /// # Errors
    /// What is wrong with the curve, and at which key.
    pub fn new(curve: &GuideCurve, follows: bool) -> Result<Self, GuideFlaw> {
        let (line, mut breaks) = Line::new(curve)?;
        let (first, last) = (breaks[0], breaks[breaks.len() - 1]);
        // Arc length counts from parameter 0 if the curve has it, else from the beginning.
        let origin = if first < 0.0 && 0.0 < last { 0.0 } else { first };
        if origin != first && !breaks.contains(&0.0) {
            breaks.push(0.0);
            breaks.sort_by(f64::total_cmp);
        }
        let extent = line.extent([first, last]);
        let mut guide = Self { line, follows, knots: Vec::new() };
        let mut ends = vec![first];
        for pair in breaks.windows(2) {
            guide.split(curve, [pair[0], pair[1]], (SHORTEST * (last - first), extent), &mut ends)?;
        }
        guide.measure(&ends, origin);
        let [from, to] = guide.range();
        let [begin, end] = [from, to].map(|s| guide.at(s).place);
        if (end - begin).norm() <= 1e-9 * (to - from) {
            return Err(GuideFlaw::new(curve.key(), "closes on itself".to_owned(), CLOSED));
        }
        Ok(guide)
    }

    /// The arc length at both ends (m).
    pub fn range(&self) -> [f64; 2] {
        [self.knots[0].s, self.knots[self.knots.len() - 1].s]
    }

    /// How far it is from an arc length to the end of the next piece, forward or backward (m); infinite on lines and helices, which are alike
    /// everywhere, and beyond the ends.
    pub fn stretch(&self, s: f64, forward: bool) -> f64 {
        let [from, to] = self.range();
        if !(matches!(self.line, Line::Points(_) | Line::Formulas(_)) && s >= from && s <= to) {
            return f64::INFINITY;
        }
        let (last, k) = (self.knots.len() - 1, self.piece(s));
        let end = if forward { (k + 2).min(last) } else { k.saturating_sub(1) };
        let way = (self.knots[end].s - s).abs();
        // Beyond an end nothing is.
        if way > 0.0 { way } else { f64::INFINITY }
    }

    /// The piece of an arc length on it.
    fn piece(&self, s: f64) -> usize {
        self.knots[1..self.knots.len() - 1].partition_point(|knot| knot.s <= s)
    }

    /// Whether a body on it turns with the tangent.
    pub fn follows(&self) -> bool {
        self.follows
    }

    /// Eq. (10).
    pub fn at(&self, s: f64) -> Guided {
        // A tube or a rail that is straight is the most frequent one, and alike everywhere.
        if matches!(self.line, Line::Straight) {
            let along = joined(&Vector3::x(), &Vector3::zeros());
            let subspaces = [along, Vector6::zeros(), Vector6::zeros()];
            return Guided { turn: Matrix3::identity(), place: s * Vector3::x(), subspaces };
        }
        let (k, u) = self.parameter(s);
        let knot = &self.knots[k];
        let [from, to] = self.range();
        let beyond = s - s.clamp(from, to);
        let mut along = self.along(u);
        along.place += beyond * along.tangent[0];
        // What a loop leaves open when it closes onto an end is as if on the curve.
        if beyond.abs() > ONE_PLACE.of(to - from) {
            along.tangent[1..].fill(Vector3::zeros());
        }
        let [t, t1, t2, t3] = along.tangent;
        let none = Vector3::zeros();
        if !self.follows {
            return Guided {
                turn: Matrix3::identity(),
                place: along.place,
                subspaces: [t, t1, t2].map(|x| joined(&x, &none)),
            };
        }
        let turn = self.frame(knot, u, &t);
        let (w, w1, w2) = (t.cross(&t1), t.cross(&t2), t1.cross(&t2) + t.cross(&t3));
        let second = w2 - w.cross(&w1);
        let own = |x: &Vector3<f64>| turn.tr_mul(x);
        Guided {
            turn,
            place: along.place,
            subspaces: [joined(&Vector3::x(), &own(&w)), joined(&none, &own(&w1)), joined(&none, &own(&second))],
        }
    }

    /// Where the curve is at this parameter: eq. (9).
    fn along(&self, u: f64) -> Along {
        let [place, p1, p2, p3, p4] = self.line.at(u);
        let v = p1.norm();
        let v1 = p1.dot(&p2) / v;
        let v2 = (p2.dot(&p2) + p1.dot(&p3) - v1 * v1) / v;
        let v3 = (3.0 * p2.dot(&p3) + p1.dot(&p4) - 3.0 * v1 * v2) / v;
        // By the parameter,
        let t = p1 / v;
        let by1 = (p2 - v1 * t) / v;
        let by2 = (p3 - v2 * t - 2.0 * v1 * by1) / v;
        let by3 = (p4 - v3 * t - 3.0 * v2 * by1 - 3.0 * v1 * by2) / v;
        // and by the arc length.
        let t1 = by1 / v;
        let t2 = (by2 - v1 * t1) / (v * v);
        let t3 = (by3 - 3.0 * v1 / v * by2 + (3.0 * v1 * v1 / v - v2) * t1) / v.powi(3);
        Along { speed: v, place, tangent: [t, t1, t2, t3] }
    }

    /// The piece of an arc length and the parameter there; beyond the ends that of the end.
    fn parameter(&self, s: f64) -> (usize, f64) {
        let [from, to] = self.range();
        let s = s.clamp(from, to);
        let k = self.piece(s);
        let (a, b) = (&self.knots[k], &self.knots[k + 1]);
        let (way, x) = (b.s - a.s, (s - a.s) / (b.s - a.s));
        if !matches!(self.line, Line::Points(_) | Line::Formulas(_)) {
            return (k, a.u + x * (b.u - a.u));
        }
        // The cubic through both ends, then Newton.
        let chord = b.u - a.u;
        let (begin, end) = (way / a.speed - chord, way / b.speed - chord);
        let mut u = a.u + x * chord + x * (1.0 - x) * ((1.0 - x) * begin - x * end);
        for _ in 0..MOST_CORRECTIONS {
            let step = (self.length(a.u, u) - (s - a.s)) / self.line.at(u)[1].norm();
            u = (u - step).clamp(a.u, b.u);
            if step.abs() <= 2.0 * f64::EPSILON * a.u.abs().max(b.u.abs()) {
                break;
            }
        }
        (k, u)
    }

    /// The arc length between two parameters of one piece.
    fn length(&self, from: f64, to: f64) -> f64 {
        integral(from, to, |u| self.line.at(u)[1].norm())
    }

    /// Eq. (12).
    fn frame(&self, knot: &Knot, u: f64, tangent: &Vector3<f64>) -> Matrix3<f64> {
        let first = &knot.tangent;
        let spin = |u: f64| {
            let [_, p1, p2, ..] = self.line.at(u);
            first.dot(&p1.cross(&p2)) / (p1.norm_squared() + first.dot(&p1) * p1.norm())
        };
        let roll = integral(knot.u, u, spin);
        let about = UnitQuaternion::from_scaled_axis(roll * tangent);
        about.to_rotation_matrix() * shortest(first, tangent) * knot.frame
    }

    /// Halves until every piece is resolved, of a curve of an extent (m) down to pieces that are the shortest; the ends of the pieces but
    /// for the first.
    fn split(
        &self,
        curve: &GuideCurve,
        whole: [f64; 2],
        (shortest, extent): (f64, f64),
        ends: &mut Vec<f64>,
    ) -> Result<(), GuideFlaw> {
        let mut open = vec![whole];
        while let Some([a, b]) = open.pop() {
            for u in [a, b] {
                let along = self.along(u);
                if !along.place.iter().chain(along.tangent.iter().flatten()).all(|x| x.is_finite()) {
                    let message = format!("has no tangent at parameter {u}");
                    return Err(GuideFlaw::new(curve.key(), message, SMOOTH));
                }
            }
            let middle = 0.5 * (a + b);
            if self.is_resolved(a, b) && self.missed(a, b) <= ONE_PLACE.of(extent) {
                ends.push(b);
            } else if ends.len() > MOST_PIECES {
                let message = format!(
                    "needs more than {MOST_PIECES} pieces: between parameter {} and {} its tangent turns by {MOST_TURN} rad too often",
                    ends[0],
                    rounded(b, shortest)
                );
                return Err(GuideFlaw::new(curve.key(), message, FINE));
            } else if b - a < shortest {
                let near = rounded(middle, shortest);
                // A kink misses no more than its tangents go within the piece.
                let slopes: f64 = [a, b].iter().map(|u| self.line.at(*u)[1].norm()).sum();
                if !(self.missed(a, b) <= slopes * (b - a) + ONE_PLACE.of(extent)) {
                    let message = format!("has a gap near parameter {near}, or is steeper there than can be looked at");
                    return Err(GuideFlaw::new(curve.key(), message, GAP));
                }
                let message = format!(
                    "is not smooth near parameter {near}, or bends there within less than the shortest piece, {shortest:.0e}"
                );
                return Err(GuideFlaw::new(curve.key(), message, KINK));
            } else {
                open.extend([[middle, b], [a, middle]]);
            }
        }
        Ok(())
    }

    /// How far the end of a piece is from where its tangents lead from its beginning (m): something is within it that no look has met.
    fn missed(&self, a: f64, b: f64) -> f64 {
        let gone: Vector3<f64> = integral(a, b, |u| self.line.at(u)[1]);
        let [begin, end] = [a, b].map(|u| self.line.at(u)[0]);
        (end - begin - gone).norm()
    }

    fn is_resolved(&self, a: f64, b: f64) -> bool {
        let middle = 0.5 * (a + b);
        let [first, last] = [a, b].map(|u| self.along(u).tangent[0]);
        let (whole, halves) = (self.length(a, b), self.length(a, middle) + self.length(middle, b));
        let turned: Vector3<f64> = integral(a, b, |u| {
            let along = self.along(u);
            along.tangent[1] * along.speed
        });
        let [by_speed, by_turn] = self.rounding([a, middle, b]);
        first.dot(&last) > MOST_TURN.cos()
            && (whole - halves).abs() <= (LENGTH + by_speed) * halves
            && (last - first - turned).norm() <= TANGENT + by_turn
    }

    /// What the rounding of the parameter leaves of the speed, as part of it, and of the tangent: where a curve is steep, that is more than
    /// a piece could be resolved to.
    fn rounding(&self, looks: [f64; 3]) -> [f64; 2] {
        let mut most = [0.0_f64; 2];
        for u in looks {
            let [_, p1, p2, ..] = self.line.at(u);
            let along = self.along(u);
            let change = [p1.dot(&p2).abs() / p1.norm_squared(), along.tangent[1].norm() * along.speed];
            most = std::array::from_fn(|i| most[i].max(PARAMETER.of(u.abs()) * change[i]));
        }
        most
    }

    /// Arc lengths and frames at the ends of the pieces: from the origin, where the frame is the hinge's turned to the
    /// tangent.
    fn measure(&mut self, ends: &[f64], origin: f64) {
        let zero = ends.iter().position(|u| *u == origin).unwrap_or(0);
        let knot = |u: f64, s: f64| {
            let along = self.along(u);
            Knot { s, u, speed: along.speed, tangent: along.tangent[0], frame: Matrix3::identity() }
        };
        let mut knots: Vec<Knot> = ends.iter().map(|u| knot(*u, 0.0)).collect();
        knots[zero].frame = from_x(&knots[zero].tangent);
        let upwards = (zero + 1..knots.len()).map(|k| (k - 1, k));
        for (known, next) in upwards.chain((0..zero).rev().map(|k| (k + 1, k))) {
            knots[next].s = knots[known].s + self.length(knots[known].u, knots[next].u);
            let tangent = knots[next].tangent;
            knots[next].frame = squared(&self.frame(&knots[known], knots[next].u, &tangent), &tangent);
        }
        self.knots = knots;
    }
}

/// Of Newton's method for the parameter.
const MOST_CORRECTIONS: usize = 8;

/// What a curve with too many pieces is told.
const FINE: &str =
    "a piece is as long as the tangent turns by 0.3 rad: a shorter range, or one without what is so fine";
/// What a curve with a kink is told, or with waves that look like one.
const KINK: &str = "the tangent and its derivative must be continuous, and the parameter must never stand still; waves that are \
                    as fine as these pieces look like kinks";
/// What a curve without a tangent somewhere is told.
const SMOOTH: &str = "the tangent and its derivative must be continuous, and the parameter must never stand still";

/// A parameter with as many digits as the search for pieces has beside what is steep there.
fn rounded(u: f64, shortest: f64) -> f64 {
    let digits = 10.0_f64.powf(4.0 - (shortest / SHORTEST).log10().floor());
    (u * digits).round() / digits + 0.0
}

/// A frame without the rounding of the frames before it: its x axis is the tangent.
fn squared(frame: &Matrix3<f64>, tangent: &Vector3<f64>) -> Matrix3<f64> {
    let y: Vector3<f64> = frame.column(1).into();
    let y = (y - tangent * tangent.dot(&y)).normalize();
    Matrix3::from_columns(&[*tangent, y, tangent.cross(&y)])
}

/// By quadrature of six points.
fn integral<T: std::iter::Sum + std::ops::Mul<f64, Output = T>>(a: f64, b: f64, of: impl Fn(f64) -> T) -> T {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    GAUSS.into_iter().map(|(t, w)| of(middle + half * t) * (half * w)).sum()
}

/// The shortest turn from one unit vector to another that does not point against it. Without angles: those of small turns are
/// not known to all digits.
fn shortest(from: &Vector3<f64>, to: &Vector3<f64>) -> Matrix3<f64> {
    let cross = from.cross(to).cross_matrix();
    Matrix3::identity() + cross + cross * cross / (1.0 + from.dot(to))
}

/// A turn from x to a tangent: the shortest, or half a turn about z and the shortest from −x.
fn from_x(tangent: &Vector3<f64>) -> Matrix3<f64> {
    if tangent.x > -0.5 {
        return shortest(&Vector3::x(), tangent);
    }
    shortest(&-Vector3::x(), tangent) * Matrix3::from_diagonal(&Vector3::new(-1.0, -1.0, 1.0))
}

impl Guided {
    /// Columns of `Z`, `Ż` and `Z̈`: eq. (11) at a rate and a second rate.
    pub(super) fn moving(&self, rate: f64, second: f64) -> [Vector6<f64>; 3] {
        let [z, by_s, by_ss] = self.subspaces;
        [z, by_s * rate, by_ss * (rate * rate) + by_s * second]
    }
}

#[cfg(test)]
mod tests;
