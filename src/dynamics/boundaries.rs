//! Where laws are not smooth: what a run needs to end its steps there.

use super::{Boundary, Evaluated, System};
use crate::force::Switch;

impl System {
    /// The boundaries next to the parts in which laws are kept.
    pub fn boundaries(&self) -> impl Iterator<Item = Boundary> {
        self.laws.boundaries()
    }

    /// The size with which a boundary's function is compared: its own, the scene's length or speed, 1 rad or that by its time.
    pub fn switch_scale(&self, boundary: Boundary, switch: &Switch) -> f64 {
        if let Some(size) = switch.size {
            return size;
        }
        let curve = boundary.element.checked_sub(self.laws.forces.len()).map(|index| &self.laws.curves[index]);
        let turns = curve.is_some_and(|curve| !curve.coordinate.slides);
        let scale = if turns { 1.0 } else { self.model.length_scale() };
        if switch.is_speed { scale / self.model.time_scale() } else { scale }
    }

    /// Whether a law is kept on the positive side of a boundary.
    pub fn side(&self, boundary: Boundary) -> bool {
        self.laws.side(boundary)
    }

    /// Keeps a law on the other side of a boundary from now on.
    pub fn cross(&mut self, boundary: Boundary) {
        self.laws.cross(boundary);
    }

    /// The motor whose formula has a boundary; `None` if it is of a force or a table.
    pub fn motor_of(&self, boundary: Boundary) -> Option<usize> {
        self.laws.motor(boundary)
    }

    /// Follows the formula of a motor across its boundaries from now on.
    pub fn follow_across(&mut self, motor: usize) {
        self.laws.follow_across(motor);
    }
}

impl Evaluated<'_> {
    /// Keeps all laws in the smooth parts to which this place belongs, whatever the places are that follow.
    pub fn keep_laws(&mut self) {
        let System { laws, motion, model, time, .. } = &mut *self.system;
        laws.keep(model, *time, motion, self.q, self.v);
    }

    /// The function whose change of sign is the crossing of a boundary.
    pub fn switch(&self, boundary: Boundary) -> Switch {
        let System { laws, motion, model, time, .. } = &*self.system;
        laws.switch(boundary, model, *time, motion, [self.q, self.v])
    }
}
