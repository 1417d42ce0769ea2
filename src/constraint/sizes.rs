//! How large the terms are that the entries of `Gᵀ λ` are sums of: times the machine precision, what they are known to.
//!
//! For each row the gradient's own way to the root with absolute values; rows err independently of each other. Where both ends of a loop meet their forces cancel exactly and
//! their moments to the round-off of the arms in between, which goes on to the root undiminished.

use super::Constraints;
use super::row::Rule;
use crate::model::Model;
use crate::motion::Motion;
use nalgebra::Vector3;

impl Constraints {
    /// What each loop, drive and gear puts into a sum over the rows solved for, given by row and term, ascending: terms of its
    /// own cancel first.
    pub(crate) fn sum_of_elements(&self, terms: impl Iterator<Item = (usize, f64)>) -> f64 {
        let (mut sum, mut own, mut last) = (0.0, 0.0_f64, 0);
        for (row, term) in terms {
            let element = self.plan.groups.partition_point(|group| group.first <= row);
            if element != last {
                sum += own.abs();
                (own, last) = (0.0, element);
            }
            own += term;
        }
        sum + own.abs()
    }

    /// Adds, for every velocity coordinate, the squares of what the rows solved for contribute with their last multipliers
    /// (N or N m), as placed last.
    pub(crate) fn add_squares(&self, model: &Model, motion: &Motion, squares: &mut [f64]) {
        let mut passed = vec![(Vector3::zeros(), 0.0); model.links.len()];
        for group in &self.plan.groups {
            let (element, way) = (&self.elements[group.element], &self.ways[group.element]);
            let Some(ends) = &element.ends else {
                for row in &group.rows {
                    let Rule::Motion { parts } = &self.rules[*row] else { continue };
                    let size = |factor: f64| (factor * self.multipliers[*row]).powi(2);
                    parts.iter().for_each(|(scalar, factor)| squares[scalar.velocity] += size(*factor));
                }
                continue;
            };
            let arms = [0, 1].map(|end: usize| ends[end].point.norm());
            let between = element.branches.iter().flatten().map(|link| motion.links[*link].arm.norm());
            // What the vector from end to end is the sum of, and what the ends' wrenches are.
            let reach = between.sum::<f64>() + arms[0] + arms[1];
            for row in &group.rows {
                let multiplier = self.multipliers[*row];
                let [forces, turns] = match &self.rules[*row] {
                    Rule::Along { .. } => [[1.0, 1.0], [reach, arms[1]]],
                    Rule::Thread { pitch, .. } => [[1.0, 1.0], [reach + pitch.abs(), arms[1] + pitch.abs()]],
                    // The direction is known to the round-off of both ends' places over their distance.
                    Rule::Distance { length } => {
                        let force = 1.0 + reach / length;
                        [[force; 2], arms.map(|arm| force * arm)]
                    }
                    Rule::Aligned { .. } => [[0.0; 2], [1.0; 2]],
                    Rule::Motion { .. } => continue,
                };
                way.iter().for_each(|link| passed[*link] = (Vector3::zeros(), 0.0));
                for (k, (end, wrench)) in ends.iter().zip(self.placed[*row].wrenches).enumerate() {
                    let at = &mut passed[end.link];
                    at.0 += multiplier * forces[k] * wrench.force;
                    at.1 += (multiplier * turns[k]).abs();
                }
                for link in way {
                    let (given, at) = (&model.links[*link], &motion.links[*link]);
                    let (force, moment) = passed[*link];
                    let (_, count) = given.joint.counts();
                    let along = force.norm();
                    let size = match (given.joint.is_slide(), given.joint.is_flex()) {
                        (true, _) => along,
                        // Stretch and shear feel the force; bending and twist have at most the element's length as their lever.
                        (_, true) => along.max(moment + at.arm.norm() * along),
                        _ => moment + given.joint.pitch().abs() * along,
                    };
                    squares[given.velocity..given.velocity + count].iter_mut().for_each(|sum| *sum += size * size);
                    let parent = &mut passed[given.parent];
                    parent.0 += force;
                    parent.1 += moment + force.norm() * at.arm.norm();
                }
            }
        }
    }
}
