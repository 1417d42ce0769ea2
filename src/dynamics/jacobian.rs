//! The Jacobians of the accelerations: by the sweeps of [`crate::transfer::jacobian`], or where force elements act, by
//! columns of the dense derivatives.

use super::applied;
use super::linearize::Of;
use super::{Dense, Evaluated, Fault, System};
use crate::model::Model;
use crate::transfer::jacobian::{Jacobian, TOGETHER};
use faer::Mat;

/// ∂q̈/∂q and ∂q̈/∂q̇, and the memory to find them in.
#[derive(Debug, Clone)]
pub struct AccelerationJacobians {
    /// ∂q̈/∂q, n×n, one row and one column per velocity; the columns are small steps as [`System::displace`] takes them,
    /// turns of balls in link axes (m/s² or rad/s² of the row for each m or rad of the column).
    pub by_position: Mat<f64>,
    /// ∂q̈/∂q̇, n×n (m/s² or rad/s² of the row for each m/s or rad/s of the column).
    pub by_velocity: Mat<f64>,
    sweep: Jacobian,
    accelerations: Vec<f64>,
    residual: Vec<f64>,
}

impl AccelerationJacobians {
    /// Room for a model; all zero.
    pub fn new(model: &Model) -> Self {
        let n = model.velocity_count();
        Self {
            by_position: Mat::zeros(n, n),
            by_velocity: Mat::zeros(n, n),
            sweep: Jacobian::new(model),
            accelerations: vec![0.0; n],
            residual: vec![0.0; n],
        }
    }
}

impl Evaluated<'_> {
    /// Jacobians of the hinge accelerations: `(∂q̈/∂q, ∂q̈/∂q̇)`, each n×n. What calls for them often keeps their memory:
    /// [`Evaluated::acceleration_jacobians_into`].
    ///
    /// ```
    /// # use stillpoint::model::{description::*, Model};
    /// # use stillpoint::dynamics::System;
    /// // A pendulum of length 2 m that hangs and is let go: θ̈ = −g/l sin θ, of which the derivative is −g/l.
    /// let hinge = HingeDescription::revolute([0.0, 1.0, 0.0]).damping([0.4]);
    /// let bob = BodyDescription::new("bob", hinge).mass(1.0).center([0.0, 0.0, -2.0]);
    /// let model = Model::build(&Description::new("").gravity([0.0, 0.0, -9.81]).body(bob)).unwrap();
    /// let (by_position, by_velocity) = System::new(&model).at(0.0, &[0.0], &[0.0]).acceleration_jacobians().unwrap();
    /// assert!((by_position[(0, 0)] + 9.81 / 2.0).abs() < 1e-14);
    /// // The damper: −c/(m l²).
    /// assert!((by_velocity[(0, 0)] + 0.4 / 4.0).abs() < 1e-14);
    /// ```
    ///
    /// # Errors
    /// A singular hinge, or the element whose numbers are not finite.
    pub fn acceleration_jacobians(&mut self) -> Result<(Mat<f64>, Mat<f64>), Fault> {
        let mut jacobians = AccelerationJacobians::new(&self.system.model);
        self.acceleration_jacobians_into(&mut jacobians)?;
        Ok((jacobians.by_position, jacobians.by_velocity))
    }

    /// Writes [`Evaluated::acceleration_jacobians`] into memory that was made before. If nothing but hinge springs, dampers, motors and armatures acts,
    /// it asks for no more memory and goes through all columns side by side; with force elements it takes a tangent
    /// sweep and a solution for each column, which is O(n²) too, but an order of magnitude slower. With loops, drives or
    /// gears the columns are those of the accelerations that the rows allow, also along steps that leave the loops: along
    /// steps that keep them closed they are the mechanism's own.
    ///
    /// # Errors
    /// As [`Evaluated::acceleration_jacobians`]; then the matrices are not to be used.
    pub fn acceleration_jacobians_into(&mut self, out: &mut AccelerationJacobians) -> Result<(), Fault> {
        self.accelerations(&mut out.accelerations)?;
        self.residual(&out.accelerations, &mut out.residual)?;
        if self.system.constraints.is_some() {
            return self.jacobians_with_rows(out);
        }
        let model = &self.system.model;
        match model.forces.is_empty()
            && self.system.pushes.is_empty()
            && model.rods.is_empty()
            && model.modals.is_empty()
        {
            true => self.jacobians_by_sweeps(out),
            false => {
                self.jacobians_by_columns(out);
                Ok(())
            }
        }
    }

    fn jacobians_by_sweeps(&self, out: &mut AccelerationJacobians) -> Result<(), Fault> {
        let model = &*self.system.model;
        let spring = |link: &_| applied::hinge::ball_tangent(model, link, self.q);
        out.sweep
            .update(model, &self.system.motion, &self.system.balance, spring)
            .map_err(|singular| self.system.singular(&singular, self.q, self.v))?;
        let n = model.velocity_count();
        for first in (0..n).step_by(TOGETHER) {
            let (touched, rows) = out.sweep.columns(first);
            for k in 0..TOGETHER.min(n - first) {
                for (lane, matrix) in [(k, &mut out.by_position), (TOGETHER + k, &mut out.by_velocity)] {
                    let column = matrix.col_as_slice_mut(first + k);
                    column[..touched.start].fill(0.0);
                    column[touched.end..].fill(0.0);
                    for (entry, row) in column[touched.clone()].iter_mut().zip(rows) {
                        *entry = row[lane];
                    }
                }
            }
        }
        Ok(())
    }

    fn jacobians_by_columns(&mut self, out: &mut AccelerationJacobians) {
        for (of, matrix) in [(Of::Position, &mut out.by_position), (Of::Velocity, &mut out.by_velocity)] {
            *matrix = self.columns(&out.accelerations, of);
            for j in 0..matrix.ncols() {
                let column = matrix.col_as_slice_mut(j);
                column.iter_mut().for_each(|x| *x = -*x);
                self.factorized().solve_mass(column, &mut out.residual);
                column.copy_from_slice(&out.residual);
            }
        }
    }

    /// `M a − Gᵀ λ = f`, `G a + bias = 0` differentiated: the columns of the free tree at fixed multipliers, then the
    /// multipliers' variation, which takes the rows' variation away.
    fn jacobians_with_rows(&mut self, out: &mut AccelerationJacobians) -> Result<(), Fault> {
        let (m, n) = (self.system.constraint_rank(), self.v.len());
        let mut gradient = vec![0.0; m * n];
        self.constraint_gradient(&mut gradient);
        let mut responses = gradient.clone();
        for (row, response) in gradient.chunks_exact(n).zip(responses.chunks_exact_mut(n)) {
            self.factorized().solve_mass(row, response);
        }
        let product = |row: &[f64], x: &[f64]| row.iter().zip(x).map(|(g, x)| g * x).sum::<f64>();
        let mut small = Dense::new(m);
        for (i, row) in gradient.chunks_exact(n).enumerate() {
            responses.chunks_exact(n).enumerate().for_each(|(j, y)| *small.entry(i, j) = product(row, y));
        }
        if !small.eliminate() {
            let element = self.system.constraints().and_then(|rows| rows.elements().first()).map(|e| e.name.clone());
            return Err(Fault::NotFinite { what: "the tangent", element: element.unwrap_or_default() });
        }
        self.jacobians_by_columns(out);
        for (of, matrix) in [(Of::Position, &mut out.by_position), (Of::Velocity, &mut out.by_velocity)] {
            for j in 0..n {
                let column = matrix.col_as_slice_mut(j);
                let mut rates = self.row_derivative(&out.accelerations, of, j)?;
                for (rate, row) in rates.iter_mut().zip(gradient.chunks_exact(n)) {
                    *rate = -*rate - product(row, column);
                }
                small.solve(&mut rates);
                for (by, response) in rates.iter().zip(responses.chunks_exact(n)) {
                    column.iter_mut().zip(response).for_each(|(x, response)| *x += by * response);
                }
            }
        }
        Ok(())
    }

    /// How `G a + bias` varies with one coordinate or velocity at fixed accelerations: a difference of fourth order.
    fn row_derivative(&mut self, a: &[f64], of: Of, j: usize) -> Result<Vec<f64>, Fault> {
        const STEP: f64 = 1e-3;
        let (m, q, v) = (self.system.constraint_rank(), self.q, self.v);
        let time = self.system.time;
        let (mut sum, mut rates) = (vec![0.0; m], vec![0.0; m]);
        let (mut near, mut by) = (q.to_vec(), vec![0.0; v.len()]);
        for (times, weight) in [(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)] {
            by[j] = times * STEP;
            let faster: Vec<f64> = match of {
                Of::Velocity => v.iter().zip(&by).map(|(v, by)| v + by).collect(),
                Of::Position | Of::Acceleration => v.to_vec(),
            };
            near.copy_from_slice(q);
            if matches!(of, Of::Position) {
                System::displace(&self.system.model, &mut near, &by);
            }
            self.system.at(time, &near, &faster).constraint_rates(a, &mut rates)?;
            sum.iter_mut().zip(&rates).for_each(|(sum, rate)| *sum += weight / STEP * rate);
        }
        Ok(sum)
    }
}
