//! Eq. (1) of the module: accelerations with the rows of closed contacts, and states kept on them.

use super::blocks::Inverses;
use super::coupling::{Across, Component, Coupling, RANK};
use super::{Closed, ContactState, Contacts};
use crate::contact::frame::{Frame, along};
use crate::contact::support::{Cone, slack};
use crate::dynamics::{Factorized, Fault, System};
use crate::round_off::{CONTACT_GAP, CONTACT_SPEED};
use crate::spatial::Wrench;
use nalgebra::{DVector, Vector3};
use std::cell::OnceCell;

/// Rows are chosen anew once the least independent of those that are kept is so by less than this part of what it would be of others: a point that
/// moves along a line of contact comes to the end of it, where another one is.
const WORN: f64 = 0.1;
/// Rounds of a projection of positions.
const MOST_ROUNDS: usize = 6;

/// One row of `R` and `P`.
struct Row {
    /// Index of the contact.
    of: usize,
    /// What it measures, and what it pushes, in the basis of the contact.
    measures: Vector3<f64>,
    pushes: Vector3<f64>,
}

impl Contacts {
    fn rows(&self) -> Vec<Row> {
        let mut rows = Vec::new();
        for (of, (closed, frame)) in self.closed.iter().zip(&self.frames).enumerate() {
            let mut add = |measures: Vector3<f64>, pushes: Vector3<f64>| rows.push(Row { of, measures, pushes });
            let rigid = self.is_rigid(closed.key.couple);
            match closed.state {
                ContactState::Spare => {}
                // Its spring presses.
                _ if !rigid => {}
                ContactState::Stick => [Vector3::x(), Vector3::y(), Vector3::z()].into_iter().for_each(|e| add(e, e)),
                ContactState::Slip(_) => {
                    let friction = self.law(closed.key.couple).friction.slide;
                    let d = frame.flat(&self.direction(closed));
                    add(Vector3::x(), Vector3::new(1.0, -friction * d.x, -friction * d.y));
                    if closed.straight {
                        let across = Vector3::new(0.0, -d.y, d.x);
                        add(across, across);
                    }
                }
            }
        }
        rows
    }

    /// Adds to accelerations of the system without contact what closed contacts push; keeps their forces.
    pub(in crate::simulate) fn correct(&mut self, mass: &mut Factorized<'_>, a: &mut [f64]) {
        if self.follows_steps() {
            self.carry(mass, a);
            return;
        }
        self.stand(mass.motion());
        let rows = self.rows();
        self.reserve.take();
        self.gaps.iter_mut().for_each(|gap| *gap = OnceCell::new());
        self.closed.iter_mut().for_each(|closed| (closed.force, closed.across) = (Vector3::zeros(), 0.0));
        self.press_springs(mass, a);
        if rows.is_empty() {
            if self.is_at_rest() {
                a.fill(0.0);
            }
            self.press(mass);
            return;
        }
        let answers = self.answers(mass, &rows);
        let rates = rows.iter().map(|row| {
            let frame = &self.frames[row.of];
            -(frame.rates(a) + frame.bias).dot(&row.measures)
        });
        let (coupling, rates) = (self.coupling(&rows, &answers), DVector::from_iterator(rows.len(), rates));
        let forces = coupling.solve(&rates, &self.independent);
        self.last = (coupling, rates);
        self.along_slips = self.along_slips(&rows, &answers);
        for ((row, answer), force) in rows.iter().zip(&answers).zip(forces.iter()) {
            a.iter_mut().zip(answer).for_each(|(a, x)| *a += force * x);
            let closed = &mut self.closed[row.of];
            closed.force += self.frames[row.of].basis * (row.pushes * *force);
            if closed.straight && row.measures.x == 0.0 {
                closed.across = *force;
            }
        }
        if self.is_at_rest() {
            a.fill(0.0);
        }
        self.press(mass);
    }

    /// What unit forces of rows accelerate along every slip that friction brakes, with the row that pushes there: none if no row depends on
    /// others, as forces are unique.
    fn along_slips(&self, rows: &[Row], answers: &[Vec<f64>]) -> Vec<(usize, DVector<f64>)> {
        if self.independent.len() == rows.len() {
            return Vec::new();
        }
        let slips = |(_, row): &(usize, &Row)| row.pushes.x != 0.0 && row.pushes.yz() != nalgebra::Vector2::zeros();
        let along = |(at, row): (usize, &Row)| {
            let slip =
                Row { of: row.of, measures: Vector3::new(0.0, row.pushes.y, row.pushes.z), pushes: Vector3::zeros() };
            (at, DVector::from_iterator(answers.len(), answers.iter().map(|answer| self.measured(&slip, answer))))
        };
        rows.iter().enumerate().filter(slips).map(along).collect()
    }

    /// Hands the forces to the system, so that reactions and powers have them.
    pub(super) fn press(&self, mass: &mut Factorized<'_>) {
        for (frame, closed) in self.frames.iter().zip(&self.closed) {
            press(mass, frame.links, &frame.meeting.point, &closed.force);
        }
    }

    /// Decides which rows of closed contacts are linearly independent, by pivots of `R M⁻¹ Rᵀ`, the largest first; frames are those of
    /// the place.
    pub(super) fn choose(&mut self, mass: &mut Factorized<'_>) {
        let rows = self.kept_rows();
        let answers = self.answers(mass, &rows);
        let coupling = self.coupling(&rows, &answers);
        self.independent = coupling.components.iter().flat_map(|own| coupling.pivots(own).rows).collect();
        self.independent.sort_unstable();
    }

    /// Decides it again behind a step if points of contact have moved to where others are the better choice ([`WORN`]); frames are those of the
    /// place.
    fn choose_again(&mut self, mass: &mut Factorized<'_>, rows: &[Row]) {
        if self.independent.len() == rows.len() {
            return;
        }
        let answers = self.answers(mass, rows);
        let coupling = self.coupling(rows, &answers);
        let choice = |component: &Component| {
            let kept = component.own(&self.independent);
            let (own, best) = (coupling.pivots_among(component, &kept), coupling.pivots(component));
            let worn = own.rows.len() < kept.len() || own.least < WORN * best.least;
            if best.rows.len() == kept.len() && worn {
                best.rows
            } else {
                kept.iter().map(|at| component.rows[*at]).collect()
            }
        };
        self.independent = coupling.components.iter().flat_map(choice).collect();
        self.independent.sort_unstable();
    }

    /// Closed contacts of which a row depends on others.
    pub(super) fn dropped(&self) -> Vec<usize> {
        let rows = self.rows().into_iter().enumerate();
        rows.filter(|(row, _)| !self.independent.contains(row)).map(|(_, row)| row.of).collect()
    }

    /// `M⁻¹ Pᵀ`.
    fn answers(&self, mass: &mut Factorized<'_>, rows: &[Row]) -> Vec<Vec<f64>> {
        let pushed = |row: &Row, impulse: &mut [f64]| self.frames[row.of].push(&row.pushes, impulse);
        let n = self.model.velocity_count();
        let mut impulse = vec![0.0; n];
        if self.trees.largest < rows.len() {
            // M⁻¹ by trees takes fewer solutions than rows.
            let inverse = Inverses::new(mass, &self.trees);
            let answer = |row| {
                impulse.fill(0.0);
                pushed(row, &mut impulse);
                inverse.times(&impulse, self.frames[row.of].columns.iter().flatten().map(|(i, _)| *i))
            };
            return rows.iter().map(answer).collect();
        }
        let answer = |row| {
            impulse.fill(0.0);
            pushed(row, &mut impulse);
            let mut change = vec![0.0; n];
            mass.answer_impulse(&impulse, &mut change);
            change
        };
        rows.iter().map(answer).collect()
    }

    /// `R M⁻¹ Pᵀ`.
    fn coupling(&self, rows: &[Row], answers: &[Vec<f64>]) -> Coupling {
        let trees: Vec<Vec<usize>> = rows.iter().map(|row| self.trees.beside(&self.frames[row.of].columns)).collect();
        Coupling::new(&trees, |i, j| self.measured(&rows[i], &answers[j]))
    }

    fn measured(&self, row: &Row, x: &[f64]) -> f64 {
        let frame = &self.frames[row.of];
        (0..3).filter(|k| row.measures[*k] != 0.0).map(|k| row.measures[k] * along(&frame.columns[k], x)).sum()
    }

    /// Brings a state back onto closed contacts after a step; whether that changed it. The system has been evaluated there.
    ///
    /// # Errors
    /// A system that cannot be evaluated.
    pub(in crate::simulate) fn project(
        &mut self,
        system: &mut System,
        time: f64,
        q: &mut [f64],
        v: &mut [f64],
    ) -> Result<bool, Fault> {
        if self.closed.is_empty() || self.is_at_rest() {
            return Ok(false);
        }
        let mut scratch = vec![0.0; v.len()];
        let (mut moved, mut rounds) = (false, 0);
        loop {
            let mut mass = self.refresh(system, time, q, v, &mut scratch)?;
            let off = |(closed, frame): (&Closed, &Frame)| match closed.state {
                ContactState::Spare => 0.0,
                _ if !self.is_rigid(closed.key.couple) => 0.0,
                _ => frame.meeting.gap - closed.gap,
            };
            let off: Vec<f64> = self.closed.iter().zip(&self.frames).map(off).collect();
            let size = self.model.length_scale();
            if rounds == MOST_ROUNDS || !off.iter().any(|off| off.abs() > CONTACT_GAP.of(size)) {
                break;
            }
            (moved, rounds) = (true, rounds + 1);
            let by = self.lifted(&mut mass, &off);
            System::displace(&self.model, q, &by);
        }
        let rows = self.kept_rows();
        self.choose_again(&mut system.factorized_beside(q, v), &rows);
        let speeds: Vec<f64> = rows.iter().map(|row| self.frames[row.of].speed.dot(&row.measures)).collect();
        let tolerance = CONTACT_SPEED.of(v.iter().fold(0.0, |most: f64, v| most.max(v.abs())));
        if !rows.is_empty() && speeds.iter().any(|u| u.abs() > tolerance) {
            let answers = self.answers(&mut system.factorized_beside(q, v), &rows);
            let rates = DVector::from_iterator(rows.len(), speeds.iter().map(|u| -u));
            let change = self.coupling(&rows, &answers).solve(&rates, &self.independent);
            for (answer, f) in answers.iter().zip(change.iter()) {
                v.iter_mut().zip(answer).for_each(|(v, x)| *v += f * x);
            }
            moved = true;
        }
        Ok(moved)
    }

    /// Frames and a factorization at a state.
    pub(super) fn refresh<'a>(
        &mut self,
        system: &'a mut System,
        time: f64,
        q: &'a [f64],
        v: &'a [f64],
        a: &mut [f64],
    ) -> Result<Factorized<'a>, Fault> {
        let mass = system.at_without_contact(time, q, v).into_accelerations(a)?;
        self.stand(mass.motion());
        Ok(mass)
    }

    /// Rows that velocities have to meet: symmetric ones.
    fn kept_rows(&self) -> Vec<Row> {
        let mut rows = self.rows();
        rows.iter_mut().for_each(|row| row.pushes = row.measures);
        rows
    }

    /// The shortest displacement, in the metric of the inertia, that takes these gaps away.
    pub(super) fn lifted(&self, mass: &mut Factorized<'_>, gaps: &[f64]) -> Vec<f64> {
        let e = Vector3::x();
        let rigid = |of: &usize| self.is_rigid(self.frames[*of].key.couple);
        let rows: Vec<Row> = (0..gaps.len()).filter(rigid).map(|of| Row { of, measures: e, pushes: e }).collect();
        let answers = self.answers(mass, &rows);
        let ways = DVector::from_iterator(rows.len(), rows.iter().map(|row| -gaps[row.of]));
        let found = self.coupling(&rows, &answers).shortest(&ways);
        let mut by = vec![0.0; self.model.velocity_count()];
        for (answer, f) in answers.iter().zip(found.iter()) {
            by.iter_mut().zip(answer).for_each(|(by, x)| *by += f * x);
        }
        by
    }
}

impl Contacts {
    /// The largest slack of forces with the accelerations of the last place, see [`slack`], in parts of the scale, and these forces of all closed
    /// contacts (N, inertial axes); `None` if forces are unique or that is not known. Where those of least norm are none a component has others.
    pub(super) fn best(&self) -> Option<(f64, Vec<Vector3<f64>>)> {
        let rows = self.rows();
        let (coupling, _) = &self.last;
        if self.independent.len() == rows.len() || coupling.count != rows.len() {
            return None;
        }
        let mut forces: Vec<Vector3<f64>> = self.closed.iter().map(|closed| closed.force).collect();
        let within = |of: usize| self.inward(&self.closed[of], &self.closed[of].force) / self.scale;
        let mut least = f64::INFINITY;
        let mut alone = vec![true; self.closed.len()];
        for component in &coupling.components {
            component.rows.iter().for_each(|row| alone[rows[*row].of] = false);
            let own = component.rows.iter().map(|row| within(rows[*row].of)).fold(f64::INFINITY, f64::min);
            let better = if own < 0.0 { self.best_of(component, &rows) } else { None };
            let Some((slack, parts)) = better.filter(|(slack, _)| *slack > own) else {
                least = least.min(own);
                continue;
            };
            least = least.min(slack);
            component.rows.iter().for_each(|row| forces[rows[*row].of] = Vector3::zeros());
            for (row, part) in component.rows.iter().map(|row| &rows[*row]).zip(parts) {
                forces[row.of] += self.frames[row.of].basis * (row.pushes * (part * self.scale));
            }
        }
        let others = (0..alone.len()).filter(|of| alone[*of] && self.closed[*of].may_push());
        Some((others.map(within).fold(least, f64::min), forces))
    }

    /// The largest slack in a component and the parts of the scale that its rows push with; `None` if forces are unique there or that is not
    /// known. Forces that meet the rows accelerate what slips by as much as theirs: how hard it is pressed is what brakes it.
    fn best_of(&self, component: &Component, rows: &[Row]) -> Option<(f64, Vec<f64>)> {
        let (coupling, rates) = &self.last;
        let (own, kept) = (&component.rows, component.own(&self.independent));
        if kept.len() == own.len() {
            return None;
        }
        let Across { units, q, x } = coupling.across(component, rates, &kept)?;
        // Forces in parts of the scale, slips straight on as free numbers: Qᵀ λ = x.
        // What nothing can move along pushes nothing, either.
        let in_units = |entry: f64, unit: f64| if unit > 0.0 { entry / unit } else { 0.0 };
        let equation = |k: usize| -> Vec<f64> { (0..own.len()).map(|j| in_units(q[(j, k)], units[j])).collect() };
        let mut equations: Vec<Vec<f64>> = (0..kept.len()).map(equation).collect();
        let mut right: Vec<f64> = x.iter().map(|x| x / self.scale).collect();
        // Forces of least norm are in the span of the rows: across it, what slips is accelerated by zero.
        let mut known = q;
        for (_, along) in self.along_slips.iter().filter(|(row, _)| own.contains(row)) {
            let along = DVector::from_iterator(own.len(), own.iter().zip(&units).map(|(row, unit)| along[*row] * unit));
            let (size, mut left) = (along.norm(), along);
            for _ in 0..2 {
                left -= &known * known.tr_mul(&left);
            }
            if left.norm() > RANK.sqrt() * size {
                let left = left.normalize();
                equations.push((0..own.len()).map(|j| in_units(left[j], units[j])).collect());
                right.push(0.0);
                let at = known.ncols();
                known = known.insert_column(at, 0.0);
                known.set_column(at, &left);
            }
        }
        let mut cones = Vec::new();
        for row in own.iter().map(|row| &rows[*row]) {
            let closed = &self.closed[row.of];
            match closed.state {
                ContactState::Stick if row.measures.x != 0.0 => {
                    cones.push(Cone::Coulomb { friction: self.law(closed.key.couple).friction.stick });
                }
                ContactState::Stick | ContactState::Spare => {}
                ContactState::Slip(_) if row.measures.x == 0.0 => cones.push(Cone::Free),
                ContactState::Slip(_) => cones.push(Cone::Ray),
            }
        }
        slack(&equations, &right, &cones)
    }
}

/// A force on the second of two links at a point, and its opposite on the first.
pub(super) fn press(mass: &mut Factorized<'_>, links: [usize; 2], point: &Vector3<f64>, force: &Vector3<f64>) {
    for (link, sign) in links.into_iter().zip([-1.0, 1.0]) {
        let (at, force) = (mass.motion().links[link].position, force * sign);
        mass.press(link, Wrench { force, moment: (point - at).cross(&force) });
    }
}
