//! What is asked of supports: whether they hold a load, how far it may go, how little friction does, what squeeze is needed.

use super::super::{Certificate, Cone, Limit, Standing, Supports, Undecided, Verdict};
use super::{AMPLE, AT_THE_LIMIT, BALANCED, ENDLESS, Extra, ROUND_OFF, Scaled, UNEVEN};

impl Supports {
    /// Whether these supports hold a load `w` (velocity coordinates: N, N m), by (P), (W) and (U).
    ///
    /// # Errors
    /// [`Undecided`] if the recomputed bounds do not decide it.
    pub fn standing(&self, load: &[f64]) -> Result<Standing, Undecided> {
        let scaled = Scaled::new(self, load, 1.0);
        if self.rows == 0 || self.size(load) == 0.0 {
            return Ok(self.idle());
        }
        let least = scaled.load.iter().map(|load| load.abs()).filter(|load| *load > ROUND_OFF).fold(1.0, f64::min);
        if least < UNEVEN {
            return Err(Undecided::Uneven { ratio: least });
        }
        let grown = scaled.grow()?;
        let stands = grown.upper <= AT_THE_LIMIT && grown.certificate.unbalanced <= BALANCED;
        if !stands && !(grown.lower > 0.0) {
            let Certificate { unbalanced, gap, .. } = grown.certificate;
            return Err(Undecided::Inexact { rows: self.rows, supports: self.len(), unbalanced, gap });
        }
        let wedged = stands && scaled.needs_squeeze()?;
        let verdict = match (stands, wedged) {
            (false, _) => Verdict::Falls,
            (true, false) => Verdict::Stands,
            (true, true) => Verdict::Wedged,
        };
        // At the limit itself there is nothing to choose among.
        let least = if stands && grown.upper < -AT_THE_LIMIT { scaled.least() } else { None };
        let inner = scaled.unscaled(&grown.forces);
        let forces = least.unwrap_or(grown.forces);
        Ok(Standing {
            verdict,
            slack: -grown.upper,
            self_stresses: scaled.self_stresses(&forces),
            forces: scaled.unscaled(&forces),
            inner,
            motion: scaled.rates_of_coordinates(&grown.motion),
            certificate: grown.certificate,
        })
    }

    /// Nothing loads anything, or nothing can move: it stands without forces.
    fn idle(&self) -> Standing {
        let certificate = Certificate { unbalanced: 0.0, outside: 0.0, gap: 0.0 };
        let none = vec![0.0; self.columns.len()];
        let (forces, inner, motion) = (none.clone(), none, vec![0.0; self.rows]);
        Standing { verdict: Verdict::Stands, slack: AMPLE, forces, inner, motion, self_stresses: 0, certificate }
    }

    /// The end of `w + α w₁`, `α` growing (`upwards`) or falling from 0, by (L).
    ///
    /// # Errors
    /// [`Undecided`] if the answer misses the balance.
    pub fn limit(&self, load: &[f64], direction: &[f64], upwards: bool) -> Result<Limit, Undecided> {
        let scaled = Scaled::new(self, load, 1.0);
        // α counts in what makes w₁ as large as w.
        let unit = scaled.size / Some(self.size(direction)).filter(|size| *size > 0.0).unwrap_or(1.0);
        let along: Vec<f64> =
            direction.iter().zip(&self.units).map(|(of, row)| of * unit / (row * scaled.size)).collect();
        let answer = scaled.answer(&scaled.program(&Extra::Along(&along, if upwards { 1.0 } else { -1.0 })))?;
        let alpha = answer.x[self.columns.len()];
        if alpha.abs() > 0.9 * ENDLESS {
            return Ok(Limit { value: alpha.signum() * f64::INFINITY, motion: Vec::new() });
        }
        let mut at = Scaled {
            load: scaled.load.clone(),
            columns: scaled.columns.clone(),
            cones: scaled.cones.clone(),
            ..scaled
        };
        at.load.iter_mut().zip(&along).for_each(|(load, along)| *load += alpha * along);
        let mut forces = answer.x[..self.columns.len()].to_vec();
        at.polish(&mut forces);
        let (unbalanced, outside) = (at.unbalanced(&forces), at.outside(&forces));
        let most = 1.0 + alpha.abs();
        if !(unbalanced <= BALANCED * most && outside <= AT_THE_LIMIT * most) {
            return Err(Undecided::Inexact { rows: self.rows, supports: self.len(), unbalanced, gap: outside });
        }
        let motion = at.rates_of_coordinates(&answer.multipliers[..self.rows]);
        Ok(Limit { value: alpha * unit, motion })
    }

    /// The smallest part of all friction at which a load is held (M): 0 if none is needed; `None` if no friction, however
    /// large, holds it, or if any does (wedged).
    ///
    /// # Errors
    /// As [`Supports::standing`].
    pub fn friction_margin(&self, load: &[f64]) -> Result<Option<f64>, Undecided> {
        // Below this part friction is not what holds.
        const NONE: f64 = 1e-9;
        if self.rows == 0 || self.size(load) == 0.0 {
            return Ok(Some(0.0));
        }
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut s = 1.0;
        for _ in 0..100 {
            let scaled = Scaled::new(self, load, s);
            let grown = scaled.grow()?;
            let tau = 0.5 * (grown.upper + grown.lower.max(-AMPLE));
            if s == 1.0 && tau.abs() <= AT_THE_LIMIT {
                // At its limit, or with nothing that friction could do.
                let none = Scaled::new(self, load, NONE).grow()?;
                return Ok(Some(if none.upper <= AT_THE_LIMIT { 0.0 } else { 1.0 }));
            }
            if s == 1.0 && tau > 0.0 && Scaled::new(self, load, f64::INFINITY).grow()?.lower > 0.0 {
                return Ok(None);
            }
            if tau > 0.0 {
                low = s
            } else {
                high = s
            }
            let slope = scaled.slope(&grown.motion, &grown.forces) / s;
            let newton = s - tau / slope;
            let next = match slope < 0.0 && newton > low && newton < high {
                // A step to almost no friction is judged there, not from here.
                true => newton.max(0.1 * s),
                false if high.is_finite() => 0.5 * (low + high),
                false => 4.0 * s,
            };
            if (next - s).abs() <= 1e-13 * s {
                return Ok(Some(next));
            }
            if next > 1e6 {
                return Ok(None);
            }
            if next < NONE {
                return Ok(if self.held_by_squeeze(load)? { None } else { Some(0.0) });
            }
            s = next;
        }
        Ok(Some(s))
    }

    /// The motion along which supports give way first when all friction is scaled by `part`: `ν` of (D) there.
    ///
    /// # Errors
    /// As [`Supports::standing`].
    pub fn motion_at(&self, load: &[f64], part: f64) -> Result<Vec<f64>, Undecided> {
        let scaled = Scaled::new(self, load, part);
        Ok(scaled.rates_of_coordinates(&scaled.grow()?.motion))
    }

    /// Whether only squeezed supports hold a load.
    fn held_by_squeeze(&self, load: &[f64]) -> Result<bool, Undecided> {
        Scaled::new(self, load, 1.0).needs_squeeze()
    }

    /// Of all forces that hold a load, the least sum of normal forces, halved (N): what has to squeeze a wedged scene.
    ///
    /// # Errors
    /// As [`Supports::standing`].
    pub fn least_squeeze(&self, load: &[f64]) -> Result<f64, Undecided> {
        let scaled = Scaled::new(self, load, 1.0);
        let mut program = scaled.program(&Extra::None);
        for (i, cone) in self.cones.iter().enumerate() {
            if matches!(cone, Cone::Coulomb { .. } | Cone::Ray) {
                program.linear[self.starts[i]] = 1.0;
            }
        }
        let answer = scaled.answer(&program)?;
        let mut forces = answer.x;
        scaled.polish(&mut forces);
        let sum: f64 = program.linear.iter().zip(&forces).map(|(counts, f)| counts * f).sum();
        Ok(0.5 * sum * scaled.size)
    }
}
