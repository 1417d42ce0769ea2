//! Eq. (1) of the module: accelerations with the rows of closed contacts, and states kept on them.

use super::blocks::Inverses;
use super::{Closed, ContactState, Contacts};
use crate::contact::frame::{Frame, along};
use crate::contact::support::{Cone, slack};
use crate::dynamics::{Factorized, Fault, System};
use crate::round_off::{CONTACT_GAP, CONTACT_SPEED};
use crate::spatial::Wrench;
use nalgebra::{DMatrix, DVector, Vector3};
use std::cell::OnceCell;

/// Singular values below this part of the largest are those of linearly dependent rows.
const RANK: f64 = 1e-9;
/// Rows that answer to what they push with by less than this part of those that answer the most do so by rounding, beside loops and drives.
const IMMOVABLE: f64 = 1e-13;
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
    /// The direction in which a contact slips.
    fn direction(&self, closed: &Closed) -> Vector3<f64> {
        let ContactState::Slip(held) = closed.state else { return Vector3::zeros() };
        let (slip, speed) = (closed.slip, closed.slip.norm());
        let n = closed.meeting.normal;
        let flat = (held - n * n.dot(&held)).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        if held == Vector3::zeros() || closed.straight || slip.dot(&flat) <= 0.0 {
            return flat;
        }
        if speed >= self.kept { slip / speed } else { flat }
    }

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
        let (matrix, rates) = (self.matrix(&rows, &answers), DVector::from_iterator(rows.len(), rates));
        let forces = self.solve(&matrix, &rates);
        self.last = (matrix, rates);
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

    /// What unit forces of rows accelerate along every slip that friction brakes: none if no row depends on others, as forces are unique.
    fn along_slips(&self, rows: &[Row], answers: &[Vec<f64>]) -> Vec<DVector<f64>> {
        if self.independent.len() == rows.len() {
            return Vec::new();
        }
        let slips = |row: &&Row| row.pushes.x != 0.0 && row.pushes.yz() != nalgebra::Vector2::zeros();
        let along = |row: &Row| {
            let slip =
                Row { of: row.of, measures: Vector3::new(0.0, row.pushes.y, row.pushes.z), pushes: Vector3::zeros() };
            DVector::from_iterator(answers.len(), answers.iter().map(|answer| self.measured(&slip, answer)))
        };
        rows.iter().filter(slips).map(along).collect()
    }

    /// Hands the forces to the system, so that reactions and powers have them.
    fn press(&self, mass: &mut Factorized<'_>) {
        for (frame, closed) in self.frames.iter().zip(&self.closed) {
            press(mass, frame.links, &frame.meeting.point, &closed.force);
        }
    }

    /// Decides which rows of closed contacts are linearly independent, by pivots of `R M⁻¹ Rᵀ`, the largest first; frames are those of
    /// the place.
    pub(super) fn choose(&mut self, mass: &mut Factorized<'_>) {
        let rows = self.kept_rows();
        let answers = self.answers(mass, &rows);
        self.independent = pivots(&self.matrix(&rows, &answers)).rows;
    }

    /// Decides it again behind a step if points of contact have moved to where others are the better choice ([`WORN`]); frames are those of the
    /// place.
    fn choose_again(&mut self, mass: &mut Factorized<'_>, rows: &[Row]) {
        if self.independent.len() == rows.len() {
            return;
        }
        let answers = self.answers(mass, rows);
        let (matrix, kept) = (self.matrix(rows, &answers), &self.independent);
        let own = DMatrix::from_fn(kept.len(), kept.len(), |i, j| matrix[(kept[i], kept[j])]);
        let (own, best) = (pivots(&own), pivots(&matrix));
        if best.rows.len() == kept.len() && (own.rows.len() < kept.len() || own.least < WORN * best.least) {
            self.independent = best.rows;
        }
    }

    /// Closed contacts of which a row depends on others.
    pub(super) fn dropped(&self) -> Vec<usize> {
        let rows = self.rows().into_iter().enumerate();
        rows.filter(|(row, _)| !self.independent.contains(row)).map(|(_, row)| row.of).collect()
    }

    /// The solution of least norm, each row in units of its own entry: in the span of the independent rows.
    fn solve(&self, matrix: &DMatrix<f64>, rates: &DVector<f64>) -> DVector<f64> {
        let (n, kept) = (rates.len(), &self.independent);
        if n == 1 {
            return if matrix[(0, 0)] == 0.0 { DVector::zeros(1) } else { rates / matrix[(0, 0)] };
        }
        least_norm(matrix, rates, kept)
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
    fn matrix(&self, rows: &[Row], answers: &[Vec<f64>]) -> DMatrix<f64> {
        DMatrix::from_fn(rows.len(), rows.len(), |i, j| self.measured(&rows[i], &answers[j]))
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
            let change = self.solve(&self.matrix(&rows, &answers), &rates);
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
        let found = shortest(&self.matrix(&rows, &answers), &ways);
        let mut by = vec![0.0; self.model.velocity_count()];
        for (answer, f) in answers.iter().zip(found.iter()) {
            by.iter_mut().zip(answer).for_each(|(by, x)| *by += f * x);
        }
        by
    }
}

impl Contacts {
    /// The largest slack of forces with the accelerations of the last place, see [`slack`], in parts of the scale, and these forces of all closed
    /// contacts (N, inertial axes); `None` if forces are unique or that is not known. Forces that meet the rows accelerate what slips by as much as theirs: how hard it is
    /// pressed is what brakes it.
    pub(super) fn best(&self) -> Option<(f64, Vec<Vector3<f64>>)> {
        let rows = self.rows();
        let (matrix, rates) = &self.last;
        if self.independent.len() == rows.len() || matrix.nrows() != rows.len() {
            return None;
        }
        let kept = &self.independent;
        let Across { units, q, x } = Across::new(matrix, rates, kept)?;
        // Forces in parts of the scale, slips straight on as free numbers: Qᵀ λ = x.
        // What nothing can move along pushes nothing, either.
        let in_units = |entry: f64, unit: f64| if unit > 0.0 { entry / unit } else { 0.0 };
        let equation = |k: usize| -> Vec<f64> { (0..rows.len()).map(|j| in_units(q[(j, k)], units[j])).collect() };
        let mut equations: Vec<Vec<f64>> = (0..kept.len()).map(equation).collect();
        let mut right: Vec<f64> = x.iter().map(|x| x / self.scale).collect();
        // Forces of least norm are in the span of the rows: across it, what slips is accelerated by zero.
        let mut known = q;
        for along in &self.along_slips {
            let along = along.component_mul(&DVector::from_column_slice(&units));
            let (size, mut left) = (along.norm(), along);
            for _ in 0..2 {
                left -= &known * known.tr_mul(&left);
            }
            if left.norm() > RANK.sqrt() * size {
                let left = left.normalize();
                equations.push((0..rows.len()).map(|j| in_units(left[j], units[j])).collect());
                right.push(0.0);
                let at = known.ncols();
                known = known.insert_column(at, 0.0);
                known.set_column(at, &left);
            }
        }
        let mut cones = Vec::new();
        for row in &rows {
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
        let (slack, parts) = slack(&equations, &right, &cones)?;
        let mut forces = vec![Vector3::zeros(); self.closed.len()];
        for (row, part) in rows.iter().zip(parts) {
            forces[row.of] += self.frames[row.of].basis * (row.pushes * (part * self.scale));
        }
        Some((slack, forces))
    }
}

/// Rows of a matrix that are linearly independent, in order.
struct Pivots {
    rows: Vec<usize>,
    /// The last pivot: how independent of the others the least of them is, 1 if it is across all of them.
    least: f64,
}

/// Rows of a symmetric positive semidefinite matrix that are linearly independent (Cholesky's factorization with complete pivoting).
fn pivots(matrix: &DMatrix<f64>) -> Pivots {
    let (n, units) = (matrix.nrows(), units(matrix));
    let mut left = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] * units[i] * units[j]);
    let mut found = Pivots { rows: Vec::new(), least: 0.0 };
    for _ in 0..n {
        let others = (0..n).filter(|i| !found.rows.contains(i));
        let largest = others.max_by(|a, b| left[(*a, *a)].total_cmp(&left[(*b, *b)]));
        let Some(at) = largest.filter(|at| left[(*at, *at)] > RANK) else { break };
        found.least = left[(at, at)];
        let column = left.column(at) / found.least.sqrt();
        left -= &column * column.transpose();
        found.rows.push(at);
    }
    found.rows.sort_unstable();
    found
}

/// A force on the second of two links at a point, and its opposite on the first.
pub(super) fn press(mass: &mut Factorized<'_>, links: [usize; 2], point: &Vector3<f64>, force: &Vector3<f64>) {
    for (link, sign) in links.into_iter().zip([-1.0, 1.0]) {
        let (at, force) = (mass.motion().links[link].position, force * sign);
        mass.press(link, Wrench { force, moment: (point - at).cross(&force) });
    }
}

/// What makes the rows of a matrix comparable: its diagonal is 1 with them; 0 for rows along which hinges, loops and drives let nothing
/// move.
fn units(matrix: &DMatrix<f64>) -> Vec<f64> {
    let entries = matrix.diagonal();
    let least = IMMOVABLE * entries.amax();
    let unit = |entry: &f64| if entry.abs() > least { entry.abs().sqrt().recip() } else { 0.0 };
    entries.iter().map(unit).collect()
}

/// The solution of least norm of rows of which these are linearly independent, each in units of its own entry.
fn least_norm(matrix: &DMatrix<f64>, rates: &DVector<f64>, kept: &[usize]) -> DVector<f64> {
    let n = rates.len();
    let Some(Across { units, q, x }) = Across::new(matrix, rates, kept) else {
        return DVector::from_element(n, f64::NAN);
    };
    let mut found = q * x;
    found.iter_mut().zip(&units).for_each(|(x, unit)| *x *= unit);
    found
}

/// Equations of independent rows with orthonormal coefficients, `Qᵀ λ = x`, forces in units of their rows: `Bᵢᵀ = Q R`, `x = R⁻ᵀ rᵢ`.
struct Across {
    units: Vec<f64>,
    q: DMatrix<f64>,
    x: DVector<f64>,
}

impl Across {
    fn new(matrix: &DMatrix<f64>, rates: &DVector<f64>, kept: &[usize]) -> Option<Self> {
        let units = units(matrix);
        let across = DMatrix::from_fn(rates.len(), kept.len(), |j, i| matrix[(kept[i], j)] * units[kept[i]] * units[j]);
        let factors = across.qr();
        let mut x = DVector::from_iterator(kept.len(), kept.iter().map(|i| rates[*i] * units[*i]));
        factors.r().tr_solve_upper_triangular_mut(&mut x).then(|| Self { units, q: factors.q(), x })
    }
}

/// The solution of least norm of symmetric rows that may be linearly dependent.
fn shortest(matrix: &DMatrix<f64>, rates: &DVector<f64>) -> DVector<f64> {
    match rates.len() {
        0 => DVector::zeros(0),
        1 if matrix[(0, 0)] == 0.0 => DVector::zeros(1),
        1 => rates / matrix[(0, 0)],
        _ => least_norm(matrix, rates, &pivots(matrix).rows),
    }
}
