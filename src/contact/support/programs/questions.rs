//! What is asked of supports: whether they hold a load, how little friction does, what squeeze is needed.

use super::super::exchange::{MOST_EXCHANGES, RimSupport};
use super::super::{Certificate, Cone, Least, Standing, Supports, Undecided, Verdict};
use super::{AMPLE, AT_THE_LIMIT, BALANCED, Extra, Grown, Scaled, UNEVEN};
use crate::round_off::SUPPORT_LOAD;

/// Below this part of it friction is not what holds.
const NONE: f64 = 1e-9;
/// What does not stand with so many times its friction is not held by friction.
const MOST_FRICTION: f64 = 1e6;
/// Points of rims that a motion goes against by no more than this part of τ* do not turn its sign. More of them share what slides at
/// many: τ* itself has no limit then.
const SIGN: f64 = 1e-4;
/// Programs that (M) takes at most.
const MOST_PROGRAMS: usize = 100;

/// What is asked of (P) about points of rims that a program does not have.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Asked {
    /// Whether a load is held: forces that hold it at some points do so whatever others could bear.
    Verdict,
    /// By how much.
    Distance,
}

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
    pub fn standing(&mut self, load: &[f64]) -> Result<Standing, Undecided> {
        if self.rows == 0 || self.size(load) == 0.0 {
            return Ok(self.idle());
        }
        // What is nearly balanced by itself weighs as much as the terms that cancel in it.
        let weighs = |(row, scaled): (usize, &f64)| {
            let terms = self.terms.get(row).map_or(1.0, |terms| (terms / load[row]).abs().max(1.0));
            (scaled.abs(), scaled.abs() * terms)
        };
        let scaled = Scaled::new(self, load, 1.0);
        let least = scaled
            .load
            .iter()
            .enumerate()
            .map(weighs)
            .filter(|(load, _)| *load > SUPPORT_LOAD.of(1.0))
            .fold(1.0, |least: f64, (_, weight)| least.min(weight));
        if least < UNEVEN {
            return Err(Undecided::Uneven { ratio: least });
        }
        let mut grown = self.grow(load, 1.0, Asked::Distance)?;
        let stands = grown.upper <= AT_THE_LIMIT && grown.certificate.unbalanced <= BALANCED;
        if !stands && !(grown.lower > 0.0) {
            let Certificate { unbalanced, gap, .. } = grown.certificate;
            return Err(Undecided::Inexact { rows: self.rows, supports: self.len(), unbalanced, gap });
        }
        let without_friction = stands && self.stands_without_friction(load);
        // What needs no friction needs no squeeze that loads it.
        let wedged = stands && !without_friction && self.needs_squeeze(load)?;
        let scaled = Scaled::new(self, load, 1.0);
        grown.forces.resize(self.columns.len(), 0.0);
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
            without_friction,
            certificate: grown.certificate,
        })
    }

    /// Whether they hold a load without friction; what is not decided so is not.
    fn stands_without_friction(&mut self, load: &[f64]) -> bool {
        let found = self.grow(load, 0.0, Asked::Verdict);
        found.is_ok_and(|none| none.upper <= AT_THE_LIMIT && none.certificate.unbalanced <= BALANCED)
    }

    /// (P) with all friction times a factor, and as many points of rims as its answer depends on.
    fn grow(&mut self, load: &[f64], part: f64, asked: Asked) -> Result<Grown, Undecided> {
        self.exchanged(part, asked, |supports| match part > 0.0 {
            true => Scaled::new(supports, load, part).grow(),
            false => Scaled::new(supports, load, 1.0).without_friction(0..supports.len()).grow(),
        })
    }

    /// Whether friction that only a squeeze can load is what holds: (W), then (P) with that friction left out.
    fn needs_squeeze(&mut self, load: &[f64]) -> Result<bool, Undecided> {
        if Scaled::new(self, load, 1.0).squeezed()?.is_empty() {
            return Ok(false);
        }
        let left = self.exchanged(1.0, Asked::Verdict, |supports| {
            let scaled = Scaled::new(supports, load, 1.0);
            scaled.without_friction(scaled.squeezed()?.into_iter()).grow()
        });
        Ok(left?.lower > 0.0)
    }

    /// These supports without friction where forces inside all cones can press on each other: (W); `None` if they can nowhere.
    ///
    /// # Errors
    /// [`Undecided`] in a build without the solver, or if that has no answer.
    pub fn unsqueezed(&self, load: &[f64]) -> Result<Option<Self>, Undecided> {
        let squeezed = Scaled::new(self, load, 1.0).squeezed()?;
        if squeezed.is_empty() {
            return Ok(None);
        }
        let mut left = self.clone();
        for support in squeezed {
            let own = self.range(support);
            left.columns[own.start + 1..own.end].iter_mut().for_each(Vec::clear);
            let of = |rim: &&mut RimSupport| rim.known.iter().any(|(_, known)| *known == support);
            left.rims.iter_mut().filter(of).for_each(|rim| rim.friction = 0.0);
        }
        Ok(Some(left))
    }

    /// The answer to a program of (P), solved anew as long as its motion goes against points of rims that it did not have.
    fn exchanged(
        &mut self,
        part: f64,
        asked: Asked,
        program: impl Fn(&Self) -> Result<Grown, Undecided>,
    ) -> Result<Grown, Undecided> {
        let mut miss = [f64::INFINITY; 2];
        for round in 1..=MOST_EXCHANGES {
            let mut grown = program(self)?;
            let Certificate { unbalanced, gap, .. } = grown.certificate;
            miss = [unbalanced, gap];
            // What no support feels, and what holds any load, is so with any points.
            let is_known = grown.upper <= -0.99 * AMPLE || unbalanced > BALANCED && grown.lower == grown.upper;
            let holds = grown.upper <= AT_THE_LIMIT && unbalanced <= BALANCED;
            let is_decided = holds && (asked == Asked::Verdict || round == MOST_EXCHANGES);
            let motion = self.motion(&grown.motion);
            if is_known || is_decided || !self.exchange(&motion, &grown.forces, part, SIGN * grown.upper.abs()) {
                grown.forces.resize(self.columns.len(), 0.0);
                return Ok(grown);
            }
        }
        let [unbalanced, gap] = miss;
        Err(Undecided::Inexact { rows: self.rows, supports: self.len(), unbalanced, gap })
    }

    /// Scaled rates in velocity coordinates.
    pub(super) fn motion(&self, scaled: &[f64]) -> Vec<f64> {
        scaled.iter().zip(&self.units).map(|(rate, unit)| rate / unit).collect()
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
            without_friction: true,
            certificate,
        }
    }

    /// The smallest part of all friction at which a load is held (M), from the answer at the whole of it; `None` if no friction, however
    /// large, holds it, or if any does (wedged).
    ///
    /// # Errors
    /// As [`Supports::standing`].
    pub fn friction_margin(&mut self, load: &[f64], whole: &Standing) -> Result<Option<Least>, Undecided> {
        let none = || Some(Least { part: 0.0, motion: Vec::new() });
        if whole.verdict == Verdict::Wedged {
            return Ok(None);
        }
        if whole.without_friction {
            return Ok(none());
        }
        let Certificate { gap, .. } = whole.certificate;
        // What holds any load has no lower bound: it is that of the program.
        let (upper, lower) = (-whole.slack, (-whole.slack - gap).max(-AMPLE));
        let mut at = Friction { part: 1.0, tau: 0.5 * (upper + lower), slope: whole.slope, gap };
        let mut motion = whole.motion.clone();
        // If that is not decided, larger and larger parts decide.
        if at.tau > AT_THE_LIMIT
            && self.grow(load, f64::INFINITY, Asked::Verdict).is_ok_and(|endless| endless.lower > 0.0)
        {
            return Ok(None);
        }
        if at.tau.abs() <= AT_THE_LIMIT {
            return Ok(Some(Least { part: 1.0, motion }));
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
            let grown = self.grow(load, next, Asked::Distance)?;
            let scaled = Scaled::new(self, load, next);
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
