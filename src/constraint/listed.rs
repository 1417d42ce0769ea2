//! Rows and their multipliers apart from the tree: for reports, files, and equations in other coordinates.

use super::component::between_ends;
use super::{Constraints, RowGroup, Rule, plan};
use crate::model::{End, Model};

/// An independent row apart from the tree: for equations in other coordinates.
pub(crate) struct IndependentRow {
    /// Its condition.
    pub(crate) rule: Rule,
    /// Both ends, of a loop.
    pub(crate) ends: Option<[End; 2]>,
    /// What a sum of coordinates has to be.
    pub(crate) target: f64,
}

impl Constraints {
    /// The rows that are solved for, in their order, drives where they are now.
    pub(crate) fn independent_rows(&self, model: &Model) -> Vec<IndependentRow> {
        let of_group = |group: &plan::Group| {
            let element = &self.elements[group.element];
            let target = element.target(model, self.time).position;
            let row = |row: &usize| IndependentRow { rule: self.rules[*row], ends: element.ends, target };
            group.rows.iter().map(row).collect::<Vec<_>>()
        };
        self.plan.groups.iter().flat_map(of_group).collect()
    }

    /// Units in which the rows solved for and the coordinates between their ends are of one size, whatever else is in the
    /// scene: the lever of their component (m), 1 for turns. For each row in their order; for each velocity coordinate, 0 where
    /// it stands in no row.
    pub(crate) fn units(&self, model: &Model) -> (Vec<f64>, Vec<f64>) {
        let (mut of_velocity, mut slides) = (vec![0.0; model.velocity_count()], vec![false; model.velocity_count()]);
        model.lengths().for_each(|velocity| slides[velocity] = true);
        for (element, lengths) in self.elements.iter().zip(&self.lengths) {
            for link in between_ends(model, element).into_iter().map(|link| &model.links[link]) {
                for i in link.velocity..link.velocity + link.joint.counts().1 {
                    of_velocity[i] = if slides[i] { lengths.lever } else { 1.0 };
                }
            }
        }
        let mut of_row = Vec::with_capacity(self.rank());
        for group in &self.plan.groups {
            let lever = self.lengths.get(group.element).map_or(1.0, |lengths| lengths.lever);
            of_row.extend(group.rows.iter().map(|row| if self.rules[*row].turns() { 1.0 } else { lever }));
        }
        (of_row, of_velocity)
    }

    /// The multipliers of the rows that are solved for, in their order, as if no other row pushed.
    pub(crate) fn independent_multipliers(&self) -> Vec<f64> {
        self.plan.rows().map(|row| self.alone()[row]).collect()
    }

    /// The multipliers before they were shared.
    fn alone(&self) -> &[f64] {
        if self.is_shared { &self.unshared } else { &self.multipliers }
    }

    /// Adds the multipliers of the rows that are solved for, in their order, times a weight.
    pub(crate) fn add_multipliers(&self, weight: f64, sum: &mut [f64]) {
        self.plan.rows().zip(sum).for_each(|(row, sum)| *sum += weight * self.multipliers[row]);
    }

    /// What every loop, drive and gear pushes with at the last solution, row by row: ``loop `coupler-ground` `` and its
    /// multipliers. Rows that others stand for push nothing.
    pub fn by_element(&self) -> Vec<(String, Vec<f64>)> {
        let kept = self.kept();
        let of_row = |row: usize| if kept[row] { self.alone()[row] } else { 0.0 };
        self.elements.iter().map(|element| (element.name.clone(), element.rows.clone().map(of_row).collect())).collect()
    }

    /// Loops and gears with rows that others stand for: name, how many, of how many. Their reactions are not unique.
    pub fn redundant(&self) -> Vec<(String, usize, usize)> {
        let kept = self.kept();
        let left_out = |element: &RowGroup| element.rows.clone().filter(|row| !kept[*row]).count();
        let all = self.elements.iter().map(|element| (element.name.clone(), left_out(element), element.rows.len()));
        all.filter(|(_, left_out, _)| *left_out > 0).collect()
    }

    /// Which rows are solved for.
    fn kept(&self) -> Vec<bool> {
        let mut kept = vec![false; self.rules.len()];
        self.plan.rows().for_each(|row| kept[row] = true);
        kept
    }

    /// The drives and what each pushes at the last solution (N or N m), with the accelerations that belong to it.
    pub fn drive_forces(&self, model: &Model, accelerations: &[f64]) -> impl Iterator<Item = (String, f64)> {
        model.drives.iter().map(|drive| drive.name.clone()).zip(self.drive_pushes(model, accelerations))
    }
}
