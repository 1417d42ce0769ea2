//! One link of every system at one instant.

use super::{LaneMatrix, LaneVector, all, matrix_of_lane, of_lane};
use crate::spatial::link::LinkMotion;

/// What [`LinkMotion`] has of one system that sweeps and forces read, inertial axes; the body's inertia is turned where it is needed.
#[derive(Debug, Clone, Copy)]
pub struct LinkLanes {
    /// `world_from_link`.
    pub turn: LaneMatrix,
    /// Angular velocity (rad/s).
    pub angular_velocity: LaneVector,
    /// Axis of a turn, slide or screw.
    pub axis: LaneVector,
    /// From the parent's root marker to this one (m).
    pub arm: LaneVector,
    /// What the velocities add to the linear acceleration of the root marker (m/s²).
    pub bias: LaneVector,
    /// What the velocities add to the angular acceleration (rad/s²).
    pub angular_bias: LaneVector,
    /// Root marker (m). Like its velocity written if something in the scene asks for it.
    pub position: LaneVector,
    /// Of the root marker (m/s).
    pub velocity: LaneVector,
}

impl Default for LinkLanes {
    /// The ground.
    fn default() -> Self {
        let zero = [all(0.0); 3];
        let mut turn = [zero; 3];
        (0..3).for_each(|i| turn[i][i] = all(1.0));
        Self {
            turn,
            angular_velocity: zero,
            axis: zero,
            arm: zero,
            bias: zero,
            angular_bias: zero,
            position: zero,
            velocity: zero,
        }
    }
}

impl LinkLanes {
    /// Where the link of one system is and how fast it moves, for whoever knows one system alone: what force elements read.
    pub fn write(&self, lane: usize, to: &mut LinkMotion) {
        to.turn = matrix_of_lane(&self.turn, lane);
        to.position = of_lane(&self.position, lane);
        to.velocity = of_lane(&self.velocity, lane);
        to.angular_velocity = of_lane(&self.angular_velocity, lane);
    }
}
