//! What is asked of supports: whether they hold a load, how far it may go, how little friction does, what squeeze is needed.

use super::super::{Certificate, Cone, Least, Limit, Standing, Supports, Undecided, Verdict};
use super::{AMPLE, AT_THE_LIMIT, BALANCED, ENDLESS, Extra, Grown, ROUND_OFF, Scaled, UNEVEN};

/// Below this part of it friction is not what holds.
const NONE: f64 = 1e-9;
/// What does not stand with so many times its friction is not held by friction.
const MOST_FRICTION: f64 = 1e6;
/// Programs that (M) takes at most.
const MOST_PROGRAMS: usize = 100;

/// (P) at a part of all friction.
struct Friction {
    part: f64,
    /// τ*, between its bounds.
    tau: f64,
    /// dτ*/d ln s.
    slope: f64,
    /// How far the bounds are apart.
    gap: f64,
}

impl Friction {
    fn of(scaled: &Scaled<'_>, grown: &Grown, part: f64) -> Self {
        let tau = 0.5 * (grown.upper + grown.lower.max(-AMPLE));
        Self { part, tau, slope: scaled.slope(&grown.motion, &grown.forces), gap: grown.certificate.gap }
    }

    /// Where τ* would be zero if it went on as it does here.
    fn newton(&self) -> f64 {
        self.part * (1.0 - self.tau / self.slope)
    }
}

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
        let slope = scaled.slope(&grown.motion, &grown.forces);
        let forces = least.unwrap_or(grown.forces);
        Ok(Standing {
            verdict,
            slack: -grown.upper,
            self_stresses: scaled.self_stresses(&forces),
            forces: scaled.unscaled(&forces),
            inner,
            motion: scaled.rates_of_coordinates(&grown.motion),
            slope,
            certificate: grown.certificate,
        })
    }

    /// Nothing loads anything, or nothing can move: it stands without forces.
    fn idle(&self) -> Standing {
        let certificate = Certificate { unbalanced: 0.0, outside: 0.0, gap: 0.0 };
        let none = vec![0.0; self.columns.len()];
        let (forces, inner, motion) = (none.clone(), none, vec![0.0; self.rows]);
        Standing {
            verdict: Verdict::Stands,
            slack: AMPLE,
            forces,
            inner,
            motion,
            self_stresses: 0,
            slope: 0.0,
            certificate,
        }
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

    /// The smallest part of all friction at which a load is held (M), from the answer at the whole of it; `None` if no friction, however
    /// large, holds it, or if any does (wedged).
    ///
    /// # Errors
    /// As [`Supports::standing`].
    pub fn friction_margin(&self, load: &[f64], whole: &Standing) -> Result<Option<Least>, Undecided> {
        let none = || Some(Least { part: 0.0, motion: Vec::new() });
        if whole.verdict == Verdict::Wedged {
            return Ok(None);
        }
        if self.rows == 0 || self.size(load) == 0.0 {
            return Ok(none());
        }
        let Certificate { gap, .. } = whole.certificate;
        // What holds any load has no lower bound: it is that of the program.
        let (upper, lower) = (-whole.slack, (-whole.slack - gap).max(-AMPLE));
        let mut at = Friction { part: 1.0, tau: 0.5 * (upper + lower), slope: whole.slope, gap };
        let mut motion = whole.motion.clone();
        if at.tau > AT_THE_LIMIT && Scaled::new(self, load, f64::INFINITY).grow()?.lower > 0.0 {
            return Ok(None);
        }
        if at.tau <= AT_THE_LIMIT && (at.tau >= -AT_THE_LIMIT || at.newton() < 0.1) {
            // Little friction may be none.
            let without = Scaled::new(self, load, 1.0).without_friction(0..self.cones.len()).grow();
            // What is not decided without friction is asked with some.
            if without.is_ok_and(|none| none.upper <= AT_THE_LIMIT && none.certificate.unbalanced <= BALANCED) {
                return Ok(none());
            }
            if at.tau >= -AT_THE_LIMIT {
                return Ok(Some(Least { part: 1.0, motion }));
            }
        }
        let (mut low, mut high) = (0.0, f64::INFINITY);
        for _ in 0..MOST_PROGRAMS {
            let held = at.tau <= 0.0;
            *(if held { &mut high } else { &mut low }) = at.part;
            let newton = at.newton();
            let next = match at.slope < 0.0 && newton > low && newton < high {
                // Slopes at much friction say little of where there is hardly any.
                true => newton.max(0.1 * at.part),
                false if high.is_finite() => 0.5 * (low + high),
                false => 4.0 * at.part,
            };
            // Where the bounds of the program enclose zero, no other part is known to be nearer to the end.
            if (next - at.part).abs() <= 1e-13 * at.part
                || (at.tau.abs() <= 0.5 * at.gap.min(AT_THE_LIMIT) && next == newton)
            {
                return Ok(Some(Least { part: next, motion }));
            }
            if next > MOST_FRICTION {
                return Ok(None);
            }
            if next < NONE {
                return Ok(none());
            }
            let scaled = Scaled::new(self, load, next);
            let grown = scaled.grow()?;
            at = Friction::of(&scaled, &grown, next);
            motion = scaled.rates_of_coordinates(&grown.motion);
        }
        Ok(Some(Least { part: at.part, motion }))
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
