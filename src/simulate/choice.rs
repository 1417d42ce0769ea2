//! Which method steps, where the user leaves that to the program.
//!
//! | | tolerance above | below |
//! |---|---|---|
//! | explicit | `dopri5` | `dop853` from 10⁻⁴ on; `adams` where steps go on undisturbed, to 10⁻¹² |
//! | implicit | `sdirk4` | `radau9` from 10⁻⁵ on; `radau5` beside contact, where it took a tenth of the steps of slips that begin and end |
//!
//! A method that lives on its past is no choice for a scene with stops or dry friction, which begins anew at each event, as it does where a
//! table or a ramp begins another piece, nor with loops,
//! onto which every one of its many short steps would be projected.
//!
//! A run from an equilibrium without contact starts with the implicit method: what rests has only its fastest vibrations left, and a
//! method that need not follow them takes long steps. A run from a given state starts with the explicit one.
//!
//! **From explicit to implicit** where the step is held by stability (`integrate/method/explicit.rs`), and the fastest rate bears that out:
//! `h ρ > `[`HELD`]. (`adams` tells by its low order, and rounding lowers it too.)
//!
//! **Back** where the implicit method takes steps so short that the explicit one would be stable with the same: every
//! [`REVIEW`] steps the fastest rate `ρ` of the system is looked up (`stiffness.rs`), and `h ρ < 1` decides. A scene
//! that switches more often than [`MOST_SWITCHES`] times stays implicit.

use crate::integrate::{Method, Stepper};
use crate::model::Model;
use crate::model::problem::number;
use crate::simulate::problem::Equations;
use crate::simulate::settings::{Integrator, Settings, Start};
use crate::simulate::stiffness::fastest;

/// Steps between two looks at the fastest rate: its cost, two dozen accelerations, is then below one per step.
const REVIEW: u64 = 64;
/// Less, and the step is not held by stability: of the explicit methods `adams` reaches least, 0.3 and more at the low orders it
/// falls to there.
const HELD: f64 = 0.1;
const MOST_SWITCHES: usize = 8;
/// From this tolerance on the method of higher order is the faster one (`stillpoint precision` on the five-link pendulum, the
/// heavy top and the stiff chain).
const HIGH_ORDER: f64 = 1e-4;
const HIGH_ORDER_STIFF: f64 = 1e-5;
/// Below, differences of past accelerations are round-off where masses differ by 10⁶ (reference case C01), and `adams` creeps.
const LIVES_ON_ITS_PAST: f64 = 1e-12;

/// The method at work and how it came to that.
#[derive(Debug)]
pub(super) struct Choice {
    auto: bool,
    explicit: Method,
    implicit: Method,
    pub(super) method: Method,
    switches: usize,
    reviewed: u64,
    /// Steps from there to the next look: twice as many after each that left things as they are.
    wait: u64,
    said: String,
}

impl Choice {
    /// `steady`: no motion or motor changes its rule on the way.
    pub(super) fn new(settings: &Settings, model: &Model, steady: bool) -> Self {
        let touches = !model.contacts.is_empty();
        let smooth = model.stops.is_empty() && model.hinge_friction.is_empty() && !touches;
        let undisturbed = steady && smooth && !model.is_constrained();
        let explicit = match settings.tolerance <= HIGH_ORDER {
            _ if undisturbed && settings.tolerance > LIVES_ON_ITS_PAST => Method::Adams,
            true => Method::Dop853,
            false => Method::Dopri5,
        };
        let implicit = match settings.tolerance <= HIGH_ORDER_STIFF {
            true if touches => Method::Radau5,
            true => Method::Radau9,
            false => Method::Sdirk4,
        };
        let (method, said) = match (settings.integrator, settings.start) {
            (Integrator::Method(method), _) => (method, String::new()),
            (Integrator::Auto, Start::Equilibrium) if !touches => {
                (implicit, format!("{}, the run starts at rest", implicit.name()))
            }
            (Integrator::Auto, _) => (explicit, format!("{}, no stiffness was met", explicit.name())),
        };
        let auto = settings.integrator == Integrator::Auto;
        let before = settings
            .resume
            .as_ref()
            .map(|resume| resume.method)
            .filter(|was| auto && (*was == explicit || *was == implicit));
        let (method, said) = match before {
            Some(method) => (method, format!("{}, as before", method.name())),
            None => (method, said),
        };
        Self { auto, explicit, implicit, method, switches: 0, reviewed: 0, wait: 0, said }
    }

    /// A new stepper begins, and counts from 0.
    pub(super) fn restart(&mut self) {
        (self.reviewed, self.wait) = (0, 0);
    }

    /// What was chosen and why; `None` if the user did.
    pub(super) fn said(&self) -> Option<String> {
        self.auto.then(|| format!("auto: {}", self.said))
    }

    /// Looks at the last step; true where another method goes on from here.
    pub(super) fn review(&mut self, motion: &mut Equations, stepper: &dyn Stepper<Equations>) -> bool {
        // Captured steps are those of no method.
        if !self.auto || motion.is_captured() {
            return false;
        }
        let time = stepper.time();
        let steps = stepper.statistics().steps;
        let explicit = self.method == self.explicit;
        let due = match explicit {
            true => stepper.stability_limited() && steps >= self.reviewed + self.wait,
            false => self.switches < MOST_SWITCHES && steps >= self.reviewed + REVIEW,
        };
        if !due {
            return false;
        }
        self.reviewed = steps;
        let step = time - stepper.previous_time();
        let reach = fastest(motion, time, stepper.position(), stepper.velocity()).map(|fastest| step * fastest.rate);
        let why = match explicit {
            true if reach.is_none_or(|reach| reach > HELD) => {
                format!("was held by stability at t = {} s", number(time))
            }
            false if reach.is_some_and(|reach| reach < 1.0) => {
                format!("took steps at t = {} s that an explicit method can take", number(time))
            }
            true => {
                self.wait = REVIEW.max(self.wait.saturating_mul(2));
                return false;
            }
            false => return false,
        };
        let from = self.method.name();
        let before = if self.switches == 0 { String::new() } else { format!("{}; ", self.said) };
        self.method = if self.method == self.explicit { self.implicit } else { self.explicit };
        self.said = format!("{before}{from} {why}, {} from there", self.method.name());
        self.switches += 1;
        true
    }
}
