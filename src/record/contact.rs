//! What contacts push with at one instant of a run.

/// One contact that bears.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPush {
    /// Names of both bodies.
    pub between: [String; 2],
    /// Where, inertial axes (m).
    pub point: [f64; 3],
    /// From the first body to the second, inertial axes.
    pub normal: [f64; 3],
    /// On the second body, inertial axes (N).
    pub force: [f64; 3],
    /// Whether what touches slips there; else it sticks or rolls.
    pub slips: bool,
}
