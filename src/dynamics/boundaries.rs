//! Where laws are not smooth: what a run needs to end its steps there.

use super::{Boundary, System};
use crate::force::Switch;

impl System {
    /// Keeps all laws in the smooth parts to which a state belongs, whatever the states are that follow.
    pub fn keep_laws(&mut self, q: &[f64], v: &[f64]) {
        self.motion.update(&self.model, q, v);
        self.laws.keep(&self.motion, q, v);
    }

    /// The boundaries next to the parts in which laws are kept.
    pub fn boundaries(&self) -> impl Iterator<Item = Boundary> {
        self.laws.boundaries()
    }

    /// The function whose change of sign is the crossing of a boundary, at a state.
    pub fn switch(&mut self, boundary: Boundary, q: &[f64], v: &[f64]) -> Switch {
        self.motion.update(&self.model, q, v);
        self.laws.switch(boundary, &self.motion, q, v)
    }

    /// The size with which a boundary's function is compared: the scene's length or speed, 1 rad or that by its time.
    pub fn switch_scale(&self, boundary: Boundary, is_speed: bool) -> f64 {
        let curve = boundary.element.checked_sub(self.laws.forces.len()).map(|index| &self.laws.curves[index]);
        let turns = curve.is_some_and(|curve| !curve.coordinate.slides);
        let scale = if turns { 1.0 } else { self.model.length_scale() };
        if is_speed { scale / self.model.time_scale() } else { scale }
    }

    /// Whether a law is kept on the positive side of a boundary.
    pub fn side(&self, boundary: Boundary) -> bool {
        self.laws.side(boundary)
    }

    /// Keeps a law on the other side of a boundary from now on.
    pub fn cross(&mut self, boundary: Boundary) {
        self.laws.cross(boundary);
    }
}
