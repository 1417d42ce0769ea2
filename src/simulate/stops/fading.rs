//! Rebounds that only dampers end.
//!
//! A stop that gives back all of a speed is struck for ever. Dampers of the hinge, or of what moves with it, take a part of the energy in each
//! flight between two impacts, and less of it the shorter that is:
//!
//! ```text
//! (1)  t = 2 u / a,   E⁺ = E⁻ (1 − t D / 3 T)
//! ```
//!
//! with `D` what dampers take from the motion of a rebound and `T` its energy; the square of a speed is a third of that at the start in the mean.
//! Rises fade as `exp(−D t / 3 T)`, and impacts become ever more within the same time: a million of them until a rise is that of rounding. A
//! place is known to the tolerance of the run, and a rise that is below it and gets lower is none.

use super::instant::{Instant, Of};

impl Instant<'_> {
    /// Which part of the energy of a rebound dampers take in a second, `changes` being how velocities answer to a unit push off each stop.
    pub(super) fn fade(&mut self, changes: &[Vec<f64>]) {
        self.fading = vec![0.0; self.rows.len()];
        if !self.motion.model().has_damping() {
            return;
        }
        for (row, change) in changes.iter().enumerate().take(self.sides().count()) {
            if self.restitution(row) == 0.0 {
                continue;
            }
            let mut at = self.motion.system.at(self.time, &self.state.position, change);
            let (taken, energy) = (at.powers().dissipated, at.energies().kinetic);
            self.fading[row] = if energy > 0.0 { taken / energy } else { 0.0 };
        }
    }

    /// Whether what would come back from a stop with a speed rises by less than a place is known to, with dampers that take more of it than
    /// the stop does.
    pub(super) fn fades(&self, row: usize, speed: f64) -> bool {
        let Of::Stop(side) = self.rows[row] else { return false };
        let (fading, inward) = (self.fading[row], self.inward(row));
        // Of the speed: half of what (1) takes of the energy.
        let lost = fading * speed / (3.0 * inward);
        // Less than the tolerance in the scene's own time is no damping that a run could tell from none.
        let is_damped = fading * self.motion.model().time_scale() > self.tolerance;
        let rise = 0.5 * speed * speed / inward;
        is_damped && lost >= 1.0 - self.restitution(row) && rise <= self.tolerance * self.motion.size(side)
    }
}
