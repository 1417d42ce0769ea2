//! What rests on a stop or by dry friction: rows that come and go while a scene moves, beside those of its loops, drives and gears.

use super::row::{Placed, Rule};
use super::rows;
use super::selection::HeldRow;
use super::{Constraints, Owner};
use crate::model::Model;
use crate::motion::Motion;

impl Constraints {
    /// Holds these coordinates and balls from now on, each where and at the rate that it is told, and lets go of those
    /// held before. Says which of them have a row that counts: the others move as loops, drives, gears and those before
    /// them have it.
    ///
    /// The motion is at `q`.
    pub(crate) fn hold(&mut self, model: &Model, motion: &Motion, q: &[f64], held: &[HeldRow]) -> Vec<bool> {
        self.clear_shares();
        let (elements, rows) = (self.own, self.independent.len());
        self.elements.truncate(elements);
        self.ways.truncate(elements);
        self.rules.truncate(rows);
        self.weights.truncate(rows);
        self.levers.truncate(rows);
        self.reaches.truncate(rows);
        self.placed.truncate(rows);
        self.multipliers.truncate(rows);
        self.not_unique.truncate(rows);
        rows::hold(model, held, motion, &mut self.elements, &mut self.rules);
        self.ways.extend(self.elements[elements..].iter().map(|element| rows::way(model, element)));
        let length = model.length_scale();
        let lever = |rule: &Rule| if rule.turns() { length } else { 1.0 };
        self.weights.extend(self.rules[rows..].iter().map(lever));
        self.levers.extend_from_slice(&self.weights[rows..]);
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
        let independent = self.independent_now(model, motion);
        let element_counts = |element: &rows::RowGroup| element.rows.clone().any(|row| independent[row]);
        let counts: Vec<bool> = self.elements[elements..].iter().map(element_counts).collect();
        if counts.contains(&false) {
            // Without a row nothing asks whether they are where they are held.
            let counted: Vec<HeldRow> =
                held.iter().zip(&counts).filter(|(_, counts)| **counts).map(|(held, _)| *held).collect();
            self.hold(model, motion, q, &counted);
        } else if independent[rows..].contains(&false) {
            // Of a ball that loops leave some of its turns.
            self.keep(|row| if row < rows { own[row] } else { independent[row] });
        }
        counts
    }

    /// The forces of the rows that hold a coordinate or a ball, at the last solution (N or N m).
    pub(crate) fn held_force(&self, velocity: usize) -> &[f64] {
        let held = self.elements[self.own..].iter().find(|element| element.owner == Owner::Held(velocity));
        held.map_or(&[], |element| &self.multipliers[element.rows.clone()])
    }
}
