//! What compliant stops and dry friction of hinges push with in the phase of a run.
//!
//! ```text
//! (1)  pushing     τ_i −= s · (k d + c ḋ),   d the depth beyond a limit;   until it would pull
//! (2)  sliding     τ −= f_slide u,   u = v / |v|;   P = f_slide |v|
//! (3)  slowly      u = v / v₀ + (1 − |v| / v₀) u₀   below a speed v₀ of spherical hinges,   u₀ the direction at the end of the last step
//! ```
//!
//! Which stops push and which friction slides is discrete: a [`Phase`] has it, and changes at events alone, so that (1) and (2) are
//! smooth within a step. They are evaluated with every other hinge force, at the place of the evaluation. In (2) `v` is one
//! coordinate, whose sign is kept within a step, or the angular velocity of a spherical hinge. Its direction turns at a rate that
//! grows without bound as it comes to rest or lets go: below a speed `v₀` that is a matter of the tolerance (3) holds, which is
//! equal to (2) as long as the direction stays.

use crate::model::contact::HingeFriction;
use crate::model::{Model, StopSide};
use nalgebra::Vector3;

/// What dry friction of a hinge does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rubbing {
    /// It holds what is at rest.
    Sticks,
    /// It opposes motion in this direction, of unit length; a revolute or prismatic hinge has ±1 as the first component.
    Slides(Vector3<f64>),
    /// Its coordinate rests because others to which it is tied are held: it pushes with this (N or N m).
    Dependent(f64),
}

/// Which compliant stops push and what dry friction does. At first no stop pushes and all friction sticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Phase {
    /// Compliant stops that push.
    pub pushing: Vec<StopSide>,
    /// What dry friction does, per hinge coordinate that has it, in the order of [`Model::hinge_friction`].
    pub rubbing: Vec<Rubbing>,
    /// `v₀` of (3) (rad/s); 0 for none.
    pub slow: f64,
}

/// The rate that dry friction opposes, of all velocities of a model: that of a coordinate as the first component, or the angular
/// velocity of a spherical hinge (m/s or rad/s).
pub fn rate_of(friction: &HingeFriction, v: &[f64]) -> Vector3<f64> {
    let mut rate = Vector3::zeros();
    rate.iter_mut().zip(&v[friction.velocity..friction.velocity + friction.count]).for_each(|(to, from)| *to = *from);
    rate
}

impl Phase {
    /// Room for the stops and the dry friction of a model.
    pub fn new(model: &Model) -> Self {
        let pushing = Vec::with_capacity(model.stops.iter().flat_map(|stop| stop.sides()).count());
        Self { pushing, rubbing: vec![Rubbing::Sticks; model.hinge_friction.len()], slow: 0.0 }
    }

    /// Whether a compliant stop pushes.
    pub fn pushes(&self, side: StopSide) -> bool {
        self.pushing.contains(&side)
    }

    /// A compliant stop pushes from now on, or no longer.
    pub fn push(&mut self, side: StopSide, pushes: bool) {
        self.pushing.retain(|other| *other != side);
        if pushes {
            self.pushing.push(side);
        }
    }

    /// Adds (1) and (2) to the hinge forces `tau`, one per velocity (N or N m).
    pub fn apply(&self, model: &Model, q: &[f64], v: &[f64], tau: &mut [f64]) {
        for side in &self.pushing {
            let stop = &model.stops[side.stop];
            tau[stop.velocity] -= side.at.sign() * stop.push(side.at, q, v);
        }
        for (friction, rubbing) in model.hinge_friction.iter().zip(&self.rubbing) {
            match *rubbing {
                Rubbing::Sticks => {}
                Rubbing::Dependent(force) => tau[friction.velocity] += force,
                Rubbing::Slides(direction) => {
                    let direction = match friction.count {
                        1 => direction,
                        _ => self.direction(&rate_of(friction, v), &direction),
                    };
                    for k in 0..friction.count {
                        tau[friction.velocity + k] -= friction.friction.slide * direction[k];
                    }
                }
            }
        }
    }

    /// `u` of (2) and (3).
    fn direction(&self, rate: &Vector3<f64>, last: &Vector3<f64>) -> Vector3<f64> {
        let speed = rate.norm();
        match speed < self.slow {
            true => rate / self.slow + (1.0 - speed / self.slow) * last,
            false => rate.try_normalize(f64::MIN_POSITIVE).unwrap_or(*last),
        }
    }

    /// The power that (2) takes out (W), ≥ 0.
    pub fn rubbed(&self, model: &Model, v: &[f64]) -> f64 {
        let of_friction = |(friction, rubbing): (&HingeFriction, &Rubbing)| match rubbing {
            Rubbing::Slides(_) => friction.friction.slide * rate_of(friction, v).norm(),
            Rubbing::Sticks | Rubbing::Dependent(_) => 0.0,
        };
        model.hinge_friction.iter().zip(&self.rubbing).map(of_friction).sum()
    }
}
