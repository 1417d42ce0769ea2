//! Stops of hinge coordinates: what the description says, what is compiled of it, and the mechanics of a stop.
//!
//! ```text
//! (1)  depth       d = s (q − limit)                 beyond the limit of a side: s = −1 at the low one, 1 at the high one
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

/// Which end of a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Side {
    /// Where the coordinate is least.
    Low,
    /// Where it is largest.
    High,
}

impl Side {
    /// Both, the low one first.
    pub const ALL: [Self; 2] = [Self::Low, Self::High];

    /// `s` of (1): −1 or 1.
    pub fn sign(self) -> f64 {
        match self {
            Self::Low => -1.0,
            Self::High => 1.0,
        }
    }

    /// Its number of a range.
    pub fn of<T: Copy>(self, [low, high]: [T; 2]) -> T {
        match self {
            Self::Low => low,
            Self::High => high,
        }
    }

    /// As files and messages have it.
    pub fn name(self) -> &'static str {
        self.of(["low", "high"])
    }
}

/// One side of one stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StopSide {
    /// Index into the model's stops.
    pub stop: usize,
    /// Which of its limits.
    pub at: Side,
}

impl Stop {
    /// Whether the coordinate never goes beyond the limits.
    pub fn is_rigid(&self) -> bool {
        self.law.is_rigid()
    }

    /// The limit on a side (m or rad); infinite if there is none.
    pub fn limit(&self, side: Side) -> f64 {
        side.of(self.range)
    }

    /// The side whose limit a value of the coordinate has reached, or is no more than `slack` away from (m or rad).
    pub fn reached(&self, value: f64, slack: f64) -> Option<Side> {
        match value {
            value if value <= self.range[0] + slack => Some(Side::Low),
            value if value >= self.range[1] - slack => Some(Side::High),
            _ => None,
        }
    }

    /// The side whose limit a value of the coordinate has passed by more than `slack` (m or rad).
    pub fn passed(&self, value: f64, slack: f64) -> Option<Side> {
        match value {
            value if value < self.range[0] - slack => Some(Side::Low),
            value if value > self.range[1] + slack => Some(Side::High),
            _ => None,
        }
    }

    /// Eq. (1) on a side (m or rad); negative inside the range.
    pub fn depth(&self, side: Side, q: &[f64]) -> f64 {
        side.sign() * (q[self.position] - self.limit(side))
    }

    /// `push` of (2) on a side, whatever its own sign (N or N m); zero for a rigid stop.
    pub fn push(&self, side: Side, q: &[f64], v: &[f64]) -> f64 {
        match self.law {
            StopLaw::Rigid { .. } => 0.0,
            StopLaw::Compliant { stiffness, damping } => {
                stiffness * self.depth(side, q) + damping * side.sign() * v[self.velocity]
            }
        }
    }

    /// `V` of (2) on a side (J); zero for a rigid stop.
    pub fn potential(&self, side: Side, q: &[f64]) -> f64 {
        match self.law {
            StopLaw::Rigid { .. } => 0.0,
            StopLaw::Compliant { stiffness, .. } => 0.5 * stiffness * self.depth(side, q).max(0.0).powi(2),
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

    /// The sides on which there is a limit.
    pub fn sides(&self) -> impl Iterator<Item = Side> + use<> {
        let range = self.range;
        Side::ALL.into_iter().filter(move |side| side.of(range).is_finite())
    }
}

/// The sides of all stops.
pub fn sides(stops: &[Stop]) -> impl Iterator<Item = StopSide> {
    stops.iter().enumerate().flat_map(|(index, stop)| stop.sides().map(move |at| StopSide { stop: index, at }))
}
