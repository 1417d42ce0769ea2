//! Stops of hinge coordinates: what the description says, what is compiled of it, and the mechanics of a stop.
//!
//! ```text
//! (1)  depth       d = side · (q − limit)            beyond the limit of a side, −1 the low one, 1 the high one
//! (2)  compliant   push = k d + c ḋ,   V = ½ k max(0, d)²
//! (3)  rigid       d ≤ 0;   u⁺ = −e u⁻
//! ```

/// A hinge coordinate that cannot go on for ever.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitDescription {
    /// Which of the hinge's coordinates, from 0; not one of a quaternion.
    pub coordinate: usize,
    /// Lowest value (m or rad); −∞ for none.
    pub low: f64,
    /// Highest value (m or rad); ∞ for none.
    pub high: f64,
    /// What happens there.
    pub law: StopLaw,
}

/// What a stop does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StopLaw {
    /// Turns the speed around at once and leaves this part of it, 0…1; holds what comes to rest on it.
    Rigid {
        /// Coefficient of restitution.
        restitution: f64,
    },
    /// Pushes back: stiffness times depth plus damping times speed, never pulling.
    Compliant {
        /// (N/m, N m/rad), > 0.
        stiffness: f64,
        /// (N s/m, N m s/rad), ≥ 0.
        damping: f64,
    },
}

impl StopLaw {
    /// Whether the coordinate never goes beyond the limit.
    pub fn is_rigid(&self) -> bool {
        matches!(self, Self::Rigid { .. })
    }

    /// The part of a speed that an impact gives back, 0…1: `e` of (3); 0 for a compliant stop, which has no impacts.
    pub fn restitution(&self) -> f64 {
        match *self {
            Self::Rigid { restitution } => restitution,
            Self::Compliant { .. } => 0.0,
        }
    }
}

/// A stop, compiled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Index of the body whose hinge it is.
    pub body: usize,
    /// Index into the position vector.
    pub position: usize,
    /// Index into the velocity vector.
    pub velocity: usize,
    /// Lowest and highest value (m or rad); infinite for none.
    pub range: [f64; 2],
    /// What happens there.
    pub law: StopLaw,
}

/// Which end of a stop's range: −1 the low one, 1 the high one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// Index into the model's stops.
    pub stop: usize,
    /// −1 or 1.
    pub sign: f64,
}

impl Stop {
    /// Whether the coordinate never goes beyond the limits.
    pub fn is_rigid(&self) -> bool {
        self.law.is_rigid()
    }

    /// The limit on the side of a sign, −1 or 1 (m or rad); infinite if there is none.
    pub fn limit(&self, sign: f64) -> f64 {
        self.range[usize::from(sign > 0.0)]
    }

    /// Eq. (1) on the side of a sign (m or rad); negative inside the range.
    pub fn depth(&self, sign: f64, q: &[f64]) -> f64 {
        sign * (q[self.position] - self.limit(sign))
    }

    /// `push` of (2) on the side of a sign, whatever its own sign (N or N m); zero for a rigid stop.
    pub fn push(&self, sign: f64, q: &[f64], v: &[f64]) -> f64 {
        match self.law {
            StopLaw::Rigid { .. } => 0.0,
            StopLaw::Compliant { stiffness, damping } => {
                stiffness * self.depth(sign, q) + damping * sign * v[self.velocity]
            }
        }
    }

    /// `V` of (2) on the side of a sign (J); zero for a rigid stop.
    pub fn potential(&self, sign: f64, q: &[f64]) -> f64 {
        match self.law {
            StopLaw::Rigid { .. } => 0.0,
            StopLaw::Compliant { stiffness, .. } => 0.5 * stiffness * self.depth(sign, q).max(0.0).powi(2),
        }
    }

    /// The stiffness of a compliant stop (N/m, N m/rad) and how far its coordinate is beyond the limit that it has passed (m or rad),
    /// negative beyond the low one. `None` for a rigid stop, and within the range.
    pub fn pressed(&self, q: &[f64]) -> Option<[f64; 2]> {
        let StopLaw::Compliant { stiffness, .. } = self.law else { return None };
        let value = q[self.position];
        let depth = (value - self.range[1]).max(0.0) + (value - self.range[0]).min(0.0);
        (depth != 0.0).then_some([stiffness, depth])
    }

    /// The sides on which there is a limit: −1, 1 or both.
    pub fn signs(&self) -> impl Iterator<Item = f64> + use<> {
        let range = self.range;
        [-1.0, 1.0].into_iter().filter(move |sign| range[usize::from(*sign > 0.0)].is_finite())
    }
}

/// The sides of all stops.
pub fn sides(stops: &[Stop]) -> impl Iterator<Item = Side> {
    stops.iter().enumerate().flat_map(|(index, stop)| stop.signs().map(move |sign| Side { stop: index, sign }))
}
