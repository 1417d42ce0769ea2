//! Motions that are given: position, velocity and acceleration of a coordinate as functions of time.

use super::couplings::MotionDescription;
use crate::formula::{Formula, Jet};
use crate::model::problem::counted;
use crate::round_off::FORMULA;
use std::borrow::Cow;
use std::f64::consts::TAU;

/// A motion, compiled.
#[derive(Debug, Clone)]
pub enum Prescribed {
    /// `start + rate t`.
    Line {
        /// At t = 0.
        start: f64,
        /// Per second.
        rate: f64,
    },
    /// From one position to another by the polynomial of degree 5 whose velocity and acceleration vanish at both ends.
    Ramp {
        /// Before.
        from: f64,
        /// After.
        to: f64,
        /// When it begins and ends (s).
        ends: [f64; 2],
    },
    /// `offset + amplitude sin(pace t + phase)`.
    Sine {
        /// Mean.
        offset: f64,
        /// Amplitude.
        amplitude: f64,
        /// Angular frequency (rad/s).
        pace: f64,
        /// Phase (rad).
        phase: f64,
    },
    /// Cubic spline.
    Spline(Spline),
    /// A formula in [`VARIABLES`].
    Formula(Box<Formula>),
}

/// What a formula of a motion may use: the time (s).
pub const VARIABLES: [&str; 1] = ["t"];

/// Position, velocity and acceleration of a prescribed coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Instant {
    /// Position (m or rad).
    pub position: f64,
    /// Velocity (m/s or rad/s).
    pub velocity: f64,
    /// Acceleration (m/s² or rad/s²).
    pub acceleration: f64,
}

impl Instant {
    /// Whether all three are finite numbers.
    pub fn is_finite(&self) -> bool {
        [self.position, self.velocity, self.acceleration].iter().all(|x| x.is_finite())
    }
}

impl Prescribed {
    /// Compiles a motion; `given` is the coordinate's position as given.
    ///
    /// # Errors
    /// What is wrong with a formula or a number of it, for people.
    pub fn compile(motion: &MotionDescription, given: f64) -> Result<Self, String> {
        let compiled = match motion {
            MotionDescription::Hold => Self::Line { start: given, rate: 0.0 },
            MotionDescription::Rate { rate } => Self::Line { start: given, rate: *rate },
            MotionDescription::Ramp { to, begin, duration } => {
                Self::Ramp { from: given, to: *to, ends: [*begin, begin + duration] }
            }
            MotionDescription::Sine { offset, amplitude, frequency, phase } => Self::Sine {
                offset: offset.unwrap_or(given),
                amplitude: *amplitude,
                pace: TAU * frequency,
                phase: *phase,
            },
            MotionDescription::Table { times, values } => Self::Spline(Spline::new(times, values)?),
            MotionDescription::Expression { text } => {
                Self::Formula(Box::new(Formula::parse(text, &VARIABLES).map_err(|error| error.in_words(text))?))
            }
        };
        if compiled.at(0.0).is_finite() {
            Ok(compiled)
        } else {
            Err("at t = 0 its position, velocity or acceleration is not a finite number".to_owned())
        }
    }

    /// The motion at `time` (s).
    pub fn at(&self, time: f64) -> Instant {
        match self {
            Self::Line { start, rate } => Instant { position: start + rate * time, velocity: *rate, acceleration: 0.0 },
            Self::Ramp { from, to, ends } => {
                let duration = ends[1] - ends[0];
                let x = ((time - ends[0]) / duration).clamp(0.0, 1.0);
                let way = to - from;
                Instant {
                    position: from + way * x * x * x * (10.0 + x * (6.0 * x - 15.0)),
                    velocity: way * 30.0 * x * x * (x - 1.0) * (x - 1.0) / duration,
                    acceleration: way * 60.0 * x * (x - 1.0) * (2.0 * x - 1.0) / (duration * duration),
                }
            }
            Self::Sine { offset, amplitude, pace, phase } => {
                let (sin, cos) = (pace * time + phase).sin_cos();
                Instant {
                    position: offset + amplitude * sin,
                    velocity: amplitude * pace * cos,
                    acceleration: -amplitude * pace * pace * sin,
                }
            }
            Self::Spline(spline) => spline.at(time),
            Self::Formula(formula) => {
                let Jet { value, first, second } = formula.jet(&[Jet::variable(time)]);
                Instant { position: value, velocity: first, acceleration: second }
            }
        }
    }

    /// Whether it stays where it is from `time` (s) on.
    pub fn holds_from(&self, time: f64) -> bool {
        match self {
            Self::Line { rate, .. } => *rate == 0.0,
            Self::Ramp { from, to, ends } => ends[1] <= time || from == to,
            Self::Sine { .. } | Self::Spline(_) | Self::Formula(_) => false,
        }
    }

    /// The formula that it follows, as written.
    pub fn formula(&self) -> Option<&str> {
        match self {
            Self::Formula(formula) => Some(formula.text()),
            _ => None,
        }
    }

    /// Whether the velocity never changes.
    pub fn is_steady(&self) -> bool {
        matches!(self, Self::Line { .. })
    }

    /// The times at which it begins to follow another rule (s): ends of a ramp, points of a table, of a formula those within a run
    /// ([`Formula::instants_of_motion`]).
    pub fn breaks(&self, run: [f64; 2]) -> Cow<'_, [f64]> {
        match self {
            Self::Ramp { ends, .. } => Cow::Borrowed(ends),
            Self::Spline(spline) => Cow::Borrowed(&spline.times),
            Self::Formula(formula) => Cow::Owned(formula.instants_of_motion(run)),
            Self::Line { .. } | Self::Sine { .. } => Cow::Borrowed(&[]),
        }
    }

    /// Whether it is a formula, which may do anything between two breaks.
    pub fn is_formula(&self) -> bool {
        matches!(self, Self::Formula(_))
    }

    /// Whether its velocity is another one just before a time and at it, between which `before` and `at` lie (s): no ramp and no table
    /// jumps.
    pub fn jumps(&self, before: f64, at: f64) -> bool {
        let Self::Formula(_) = self else { return false };
        let [old, new] = [before, at].map(|time| self.at(time));
        let drift = (at - before) * (old.acceleration.abs() + new.acceleration.abs());
        (new.velocity - old.velocity).abs() > FORMULA.of(old.velocity.abs() + new.velocity.abs()) + drift
    }

    /// What no step should be longer than (s), where steps could miss what it does: a quarter of a sine, a hundredth of a
    /// run for a formula, which may do anything.
    pub fn longest_step(&self, run: f64) -> f64 {
        match self {
            Self::Sine { pace, .. } => 0.25 * TAU / pace.abs(),
            Self::Formula(_) => 0.01 * run,
            Self::Line { .. } | Self::Ramp { .. } | Self::Spline(_) => f64::INFINITY,
        }
    }

    /// How long it goes on as at t = 0, with that velocity; at most until `end` (s). What is shorter than a
    /// four-thousandth of that time is not seen.
    pub fn steady_until(&self, end: f64) -> f64 {
        const SAMPLES: usize = 4096;
        let first = self.at(0.0);
        let leaves = |time: f64| {
            let expected = first.position + first.velocity * time;
            // Round-off of what is compared.
            let allowed = 1e-12 * first.position.abs().max(expected.abs()).max(1e-3);
            !((self.at(time).position - expected).abs() <= allowed)
        };
        let sample = |i: usize| end * i as f64 / SAMPLES as f64;
        let Some(left) = (1..=SAMPLES).find(|i| leaves(sample(*i))).filter(|_| !self.is_steady()) else {
            return end;
        };
        let (mut with, mut without) = (sample(left - 1), sample(left));
        while without - with > 1e-9 * end {
            let middle = 0.5 * (with + without);
            *(if leaves(middle) { &mut without } else { &mut with }) = middle;
        }
        with
    }
}

/// A cubic spline with continuous second derivative inside and no slope at its ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    times: Vec<f64>,
    values: Vec<f64>,
    /// Second derivatives at the points.
    curvatures: Vec<f64>,
}

impl Spline {
    /// Through the points `(times, values)`; `times` must increase.
    ///
    /// # Errors
    /// What is wrong with the points, for people.
    pub fn new(times: &[f64], values: &[f64]) -> Result<Self, String> {
        if times.len() != values.len() {
            return Err(format!(
                "{} and {}: there must be as many",
                counted(times.len(), "time", "times"),
                counted(values.len(), "value", "values")
            ));
        }
        if times.len() < 2 {
            return Err("a table needs at least two points".to_owned());
        }
        if let Some(bad) = times.iter().chain(values).find(|x| !x.is_finite()) {
            return Err(format!("a table holds {bad}: all its numbers must be finite"));
        }
        if let Some(at) = times.windows(2).position(|pair| pair[1] <= pair[0]) {
            return Err(format!("times must increase, but {} s comes after {} s", times[at + 1], times[at]));
        }
        // Clamped spline: continuity of the first derivative, a tridiagonal system for the second derivatives.
        let n = times.len();
        let slope = |i: usize| (values[i + 1] - values[i]) / (times[i + 1] - times[i]);
        let (mut diagonal, mut rhs) = (vec![0.0; n], vec![0.0; n]);
        for i in 0..n {
            let before = if i > 0 { times[i] - times[i - 1] } else { 0.0 };
            let after = if i + 1 < n { times[i + 1] - times[i] } else { 0.0 };
            diagonal[i] = (before + after) / 3.0;
            rhs[i] = if i + 1 < n { slope(i) } else { 0.0 } - if i > 0 { slope(i - 1) } else { 0.0 };
        }
        for i in 1..n {
            let across = (times[i] - times[i - 1]) / 6.0;
            let factor = across / diagonal[i - 1];
            diagonal[i] -= factor * across;
            rhs[i] -= factor * rhs[i - 1];
        }
        let mut curvatures = vec![0.0; n];
        curvatures[n - 1] = rhs[n - 1] / diagonal[n - 1];
        for i in (0..n - 1).rev() {
            let across = (times[i + 1] - times[i]) / 6.0;
            curvatures[i] = (rhs[i] - across * curvatures[i + 1]) / diagonal[i];
        }
        Ok(Self { times: times.to_vec(), values: values.to_vec(), curvatures })
    }

    /// The spline at `time`; outside its points it rests.
    pub fn at(&self, time: f64) -> Instant {
        let last = self.times.len() - 1;
        let rest = |position: f64| Instant { position, velocity: 0.0, acceleration: 0.0 };
        if time < self.times[0] {
            return rest(self.values[0]);
        }
        // At a point the piece after it counts: what begins anew there does not see the one before.
        if time >= self.times[last] {
            return rest(self.values[last]);
        }
        let i = self.times.partition_point(|t| *t <= time).clamp(1, last) - 1;
        let h = self.times[i + 1] - self.times[i];
        let (a, b) = ((self.times[i + 1] - time) / h, (time - self.times[i]) / h);
        let (ca, cb) = (self.curvatures[i], self.curvatures[i + 1]);
        let slope = (self.values[i + 1] - self.values[i]) / h;
        Instant {
            position: a * self.values[i]
                + b * self.values[i + 1]
                + ((a * a * a - a) * ca + (b * b * b - b) * cb) * h * h / 6.0,
            velocity: slope + ((3.0 * b * b - 1.0) * cb - (3.0 * a * a - 1.0) * ca) * h / 6.0,
            acceleration: a * ca + b * cb,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motions() -> Vec<Prescribed> {
        let table = MotionDescription::Table { times: vec![0.0, 0.5, 1.5, 2.0], values: vec![0.1, 0.7, -0.2, 0.0] };
        let ramp = MotionDescription::Ramp { to: 2.0, begin: 0.25, duration: 1.5 };
        let sine = MotionDescription::Sine { offset: None, amplitude: 0.3, frequency: 0.8, phase: 0.2 };
        let formula = MotionDescription::Expression { text: "asin(0.1*sin(10*t)) + 0.2*t^2".to_owned() };
        [table, ramp, sine, formula].iter().map(|motion| Prescribed::compile(motion, 0.4).unwrap()).collect()
    }

    /// Velocity and acceleration are the derivatives of the position.
    #[test]
    fn rates_are_derivatives() {
        for motion in motions() {
            for time in [0.3, 0.77, 1.2, 1.9] {
                let (h, now) = (1e-5, motion.at(time));
                let (before, after) = (motion.at(time - h), motion.at(time + h));
                // Central differences: h² times the third derivatives (below 1e3) over six.
                assert!((now.velocity - (after.position - before.position) / (2.0 * h)).abs() < 1e-7, "{motion:?}");
                assert!((now.acceleration - (after.velocity - before.velocity) / (2.0 * h)).abs() < 1e-6, "{motion:?}");
            }
        }
    }

    #[test]
    fn a_table_passes_through_its_points_and_rests_at_its_ends() {
        let Prescribed::Spline(spline) = &motions()[0] else { panic!() };
        for (time, value) in spline.times.iter().zip(&spline.values) {
            assert!((spline.at(*time).position - value).abs() < 1e-15);
        }
        assert!(spline.at(0.0).velocity.abs() < 1e-15 && spline.at(2.0).velocity.abs() < 1e-14);
    }

    /// Formulas have their breaks within a run; their velocities jump at kinks, and nowhere else.
    #[test]
    fn formulas_break_where_their_velocity_jumps() {
        let motion =
            |text: &str| Prescribed::compile(&MotionDescription::Expression { text: text.to_owned() }, 0.0).unwrap();
        let kink = motion("min(t, 1)");
        let at = 1.0_f64.next_up();
        assert_eq!(*kink.breaks([0.0, 2.0]), [at]);
        assert!(kink.jumps(at.next_down(), at) && !kink.jumps(0.5, 0.5_f64.next_up()));
        let smooth = motion("max(0, t-1)^2 + sin(3*t)");
        assert_eq!(*smooth.breaks([0.0, 2.0]), [at]);
        assert!(!smooth.jumps(1.0, at));
        for motion in motions() {
            assert!(motion.breaks([0.0, 5.0]).iter().all(|at| !motion.jumps(at.next_down(), *at)), "{motion:?}");
        }
    }

    #[test]
    fn formulas_say_what_is_wrong() {
        let wrong = |text: &str| {
            Prescribed::compile(&MotionDescription::Expression { text: text.to_owned() }, 0.0).unwrap_err()
        };
        assert_eq!(wrong("0.1*sin(omega*t)"), "unknown name `omega` at character 9 of the formula `0.1*sin(omega*t)`");
        assert!(wrong("log(t)").contains("not a finite number"), "{}", wrong("log(t)"));
    }
}
