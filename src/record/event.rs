//! What happens at one instant of a run.

/// Something to be marked in a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Simulated time (s).
    pub time: f64,
    /// What it happened to: a body, an event of the scenario, or `integrator`.
    pub name: String,
    /// What happened, for people.
    pub text: String,
}
