//! How far a load may go: (L), and what proves its answer.
//!
//! Along `w + α w₁` the number `τ*` of (P) is convex in α, and the motion of any answer bounds it from below by what is affine in α:
//!
//! ```text
//! (1)  τ*(α) Σ F z_i  ≥  ν·(w + α w₁) − Σ b z_i        ν from (L), or from (P) at any α
//! (2)  α_end:  ν·(w + α_end w₁) = Σ b z_i             nothing holds beyond it if ν·w₁ > 0
//! ```
//!
//! Where an answer to (L) and its bound (2) are apart, as interior points may stop early where forces have no largest (wedged scenes),
//! the end is found from outside by (P): each of its motions gives the next, smaller α (Newton's method on a convex function).

use super::super::exchange::MOST_EXCHANGES;
use super::super::{Limit, Supports, Undecided};
use super::{AT_THE_LIMIT, BALANCED, ENDLESS, Extra, Grown, Scaled, dot};

/// A load factor that points of rims, or other forces, could change by no more than this part of it has settled.
const SETTLED: f64 = 1e-8;
/// Programs of (P) between an answer to (L) and its bound.
const MOST_CUTS: usize = 60;

/// The answer to (L), scaled.
struct Loaded {
    limit: Limit,
    motion: Vec<f64>,
    forces: Vec<f64>,
    /// α.
    factor: f64,
}

/// A load along a direction, in parts of the loads' size.
struct Ray<'a> {
    scaled: Scaled<'a>,
    along: Vec<f64>,
    /// 1 upwards, −1 downwards.
    sense: f64,
}

impl<'a> Ray<'a> {
    fn at(&self, alpha: f64) -> Scaled<'a> {
        let load = self.scaled.load.iter().zip(&self.along).map(|(load, along)| load + alpha * along).collect();
        let (columns, cones) = (self.scaled.columns.clone(), self.scaled.cones.clone());
        Scaled { supports: self.scaled.supports, columns, cones, load, size: self.scaled.size }
    }

    /// (2) of a motion whose answer is that at `alpha`; infinite if the motion ends nothing.
    fn end(&self, at: &Scaled<'_>, alpha: f64, motion: &[f64], forces: &[f64]) -> f64 {
        let along = self.sense * dot(motion, &self.along);
        if along > 0.0 {
            alpha - self.sense * at.surplus(motion, forces)[0] / along
        } else {
            self.sense * f64::INFINITY
        }
    }

    /// The end between `low`, which is held, and `high`, which may be; its motion and forces.
    fn found_from_outside(&self, mut low: f64, mut high: f64) -> Result<(f64, Grown), Undecided> {
        let mut miss = [f64::NAN; 2];
        let mut width = 1.0 + low.abs();
        for _ in 0..MOST_CUTS {
            if !(high.abs() < ENDLESS) {
                width *= 4.0;
                high = self.sense * ENDLESS.min((low + self.sense * width).abs());
            }
            let at = self.at(high);
            let grown = at.grow()?;
            miss = [grown.certificate.unbalanced, grown.certificate.gap];
            let most = 1.0 + high.abs();
            if grown.upper <= AT_THE_LIMIT * most && grown.certificate.unbalanced <= BALANCED * most {
                let is_end = high.abs() >= 0.9 * ENDLESS || (high - low).abs() <= SETTLED * most;
                low = high;
                // What (2) has come down to is held: that is the end.
                if is_end || self.is_cut(&at, high, &grown) {
                    return Ok((high, grown));
                }
                high = self.sense * f64::INFINITY;
                continue;
            }
            let next = self.end(&at, high, &grown.motion, &grown.forces);
            let shrinks = (high - next) * self.sense > 0.0;
            high = if shrinks && (next - low) * self.sense > 0.0 { next } else { 0.5 * (low + high) };
            if (high - low).abs() <= 1e-3 * SETTLED * most {
                return Ok((low, grown));
            }
        }
        let [unbalanced, gap] = miss;
        let (rows, supports) = (self.scaled.load.len(), self.scaled.cones.len());
        Err(Undecided::Inexact { rows, supports, unbalanced, gap })
    }

    /// Whether the motion of an answer that is held proves that nothing beyond it is.
    fn is_cut(&self, at: &Scaled<'_>, alpha: f64, grown: &Grown) -> bool {
        let end = self.end(at, alpha, &grown.motion, &grown.forces);
        (end - alpha).abs() <= SETTLED * (1.0 + alpha.abs())
    }
}

impl Supports {
    /// The end of `w + α w₁`, `α` growing (`upwards`) or falling from 0, by (L).
    ///
    /// # Errors
    /// [`Undecided`] if the answer misses the balance, or is not proved to be the end.
    pub fn limit(&mut self, load: &[f64], direction: &[f64], upwards: bool) -> Result<Limit, Undecided> {
        for _ in 0..MOST_EXCHANGES {
            let Loaded { limit, motion, forces, factor } = self.limit_of_known(load, direction, upwards)?;
            let enough = SETTLED * factor.abs().max(1.0);
            if limit.motion.is_empty() || !self.exchange(&self.motion(&motion), &forces, 1.0, enough) {
                return Ok(limit);
            }
        }
        Err(Undecided::Inexact { rows: self.rows, supports: self.len(), unbalanced: 0.0, gap: SETTLED })
    }

    /// (L) with the points of rims that are known.
    fn limit_of_known(&self, load: &[f64], direction: &[f64], upwards: bool) -> Result<Loaded, Undecided> {
        let scaled = Scaled::new(self, load, 1.0);
        // α counts in what makes w₁ as large as w.
        let unit = scaled.size / Some(self.size(direction)).filter(|size| *size > 0.0).unwrap_or(1.0);
        let along: Vec<f64> =
            direction.iter().zip(&self.units).map(|(of, row)| of * unit / (row * scaled.size)).collect();
        let sense = if upwards { 1.0 } else { -1.0 };
        let answer = scaled.answer(&scaled.program(&Extra::Along(&along, sense)))?;
        let mut alpha = answer.x[self.columns.len()];
        let ray = Ray { scaled, along, sense };
        let endless = |alpha: f64| {
            let limit = Limit { value: alpha.signum() * f64::INFINITY, motion: Vec::new() };
            Loaded { limit, motion: Vec::new(), forces: Vec::new(), factor: alpha }
        };
        if alpha.abs() > 0.9 * ENDLESS {
            return Ok(endless(alpha));
        }
        let at = ray.at(alpha);
        let mut forces = answer.x[..self.columns.len()].to_vec();
        at.polish(&mut forces);
        let (unbalanced, outside) = (at.unbalanced(&forces), at.outside(&forces));
        let most = 1.0 + alpha.abs();
        let mut motion = answer.multipliers[..self.rows].to_vec();
        let holds = unbalanced <= BALANCED * most && outside <= AT_THE_LIMIT * most;
        let end = ray.end(&at, alpha, &motion, &forces);
        if !(holds && (end - alpha).abs() <= SETTLED * most) {
            let (value, grown) = ray.found_from_outside(if holds { alpha } else { 0.0 }, end)?;
            if value.abs() > 0.9 * ENDLESS {
                return Ok(endless(value));
            }
            (alpha, motion, forces) = (value, grown.motion, grown.forces);
        }
        let limit = Limit { value: alpha * unit, motion: at.rates_of_coordinates(&motion) };
        Ok(Loaded { limit, motion, forces, factor: alpha })
    }
}
