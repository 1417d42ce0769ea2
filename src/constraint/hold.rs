//! Coordinates that rest on a stop: rows that come and go while a scene moves, beside those of its loops, drives and gears.

use super::mode::{Held, scalars};
use super::row::Placed;
use super::rows;
use super::{Constraints, Owner};
use crate::model::Model;
use crate::model::prescribed::Instant;
use crate::motion::Motion;

impl Constraints {
    /// Holds these velocity coordinates from now on, each where and at the rate that it is told, and lets go of those
    /// held before. Says which of them have a row that counts: the others move as loops, drives, gears and those before
    /// them have it.
    ///
    /// The motion is at `q`.
    pub(crate) fn hold(
        &mut self,
        model: &Model,
        motion: &Motion,
        q: &[f64],
        targets: &[(usize, Instant)],
    ) -> Vec<bool> {
        let (elements, rows) = (self.own, self.independent.len());
        self.elements.truncate(elements);
        self.ways.truncate(elements);
        self.rules.truncate(rows);
        self.weights.truncate(rows);
        self.reaches.truncate(rows);
        self.placed.truncate(rows);
        self.multipliers.truncate(rows);
        self.not_unique.truncate(rows);
        self.is_shared = false;
        let of = |(velocity, at): &(usize, Instant)| {
            let coordinate = scalars(model).find(|scalar| scalar.velocity == *velocity)?;
            Some(Held::Coordinate { coordinate, at: *at })
        };
        let held: Vec<Held> = targets.iter().filter_map(of).collect();
        rows::hold(model, &held, &mut self.elements, &mut self.rules);
        self.ways.extend(self.elements[elements..].iter().map(|element| rows::way(model, element)));
        let length = model.length_scale();
        self.weights.extend(self.rules[rows..].iter().map(|rule| if rule.turns() { length } else { 1.0 }));
        self.reaches.resize(self.rules.len(), length);
        self.placed.resize(self.rules.len(), Placed::default());
        self.multipliers.resize(self.rules.len(), 0.0);
        self.not_unique.resize(self.rules.len(), false);
        let own = self.independent.clone();
        self.keep(|row| row >= rows || own[row]);
        if held.is_empty() {
            return Vec::new();
        }
        self.place(model, motion, q, false);
        let counts = self.independent_now(model, motion)[rows..].to_vec();
        if counts.contains(&false) {
            // Without a row nothing asks whether they are where they are held.
            let counted: Vec<(usize, Instant)> =
                targets.iter().zip(&counts).filter(|(_, counts)| **counts).map(|(target, _)| *target).collect();
            self.hold(model, motion, q, &counted);
        }
        counts
    }

    /// The force of the row that holds a velocity coordinate, at the last solution (N or N m).
    pub(crate) fn held_force(&self, velocity: usize) -> f64 {
        let held = self.elements[self.own..].iter().find(|element| element.owner == Owner::Held(velocity));
        held.map_or(0.0, |element| self.multipliers[element.rows.start])
    }
}
