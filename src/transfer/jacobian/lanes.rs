//! Several columns side by side: every operation is done for all of them before the next.

use super::cause::Cause;
use super::place::ColumnKind;
use super::{LANES, Lanes, Row};
use crate::spatial::Wrench;
use nalgebra::Vector3;

/// `a` and `w` of a link, for each column.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Field {
    linear: [Lanes; 3],
    angular: [Lanes; 3],
    rate: [Lanes; 3],
}

/// `e` on its way to the root, for each column.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Load {
    force: [Lanes; 3],
    moment: [Lanes; 3],
}

#[inline(always)]
fn dot(n: &Vector3<f64>, v: &[Lanes; 3], lane: usize) -> f64 {
    n.x * v[0][lane] + n.y * v[1][lane] + n.z * v[2][lane]
}

/// `sum += n s`
#[inline(always)]
fn add(sum: &mut [Lanes; 3], n: &Vector3<f64>, s: &Lanes) {
    for lane in 0..LANES {
        sum[0][lane] += n.x * s[lane];
        sum[1][lane] += n.y * s[lane];
        sum[2][lane] += n.z * s[lane];
    }
}

/// `u ← −n · v`
#[inline(always)]
fn resist(n: &Vector3<f64>, v: &[Lanes; 3], u: &mut Lanes) {
    for lane in 0..LANES {
        u[lane] = -dot(n, v, lane);
    }
}

impl Field {
    /// One column begins: the subtree moves as one body.
    pub(super) fn begin(&mut self, lane: usize, cause: &Cause) {
        for i in 0..3 {
            self.linear[i][lane] += cause.alpha.linear[i];
            self.angular[i][lane] += cause.alpha.angular[i];
            self.rate[i][lane] = cause.rate[i];
        }
    }

    /// Eq. (J4) across one coordinate: from its parent to its link, and `x ← q̈` from `x = D⁻¹ u`.
    #[inline(always)]
    pub(super) fn cross(&mut self, kind: ColumnKind, row: &Row, x: &mut Lanes) {
        match kind {
            ColumnKind::Turn => {
                self.shift(&row.arm);
                self.solve(row, x);
                add(&mut self.angular, &row.axis, x);
            }
            ColumnKind::Slide => {
                self.shift(&row.arm);
                self.solve(row, x);
                add(&mut self.linear, &row.axis, x);
            }
            ColumnKind::Screw { pitch } => {
                self.shift(&row.arm);
                self.solve(row, x);
                add(&mut self.angular, &row.axis, x);
                add(&mut self.linear, &(pitch * row.axis), x);
            }
            ColumnKind::Further => {
                self.solve(row, x);
                add(&mut self.angular, &row.axis, x);
            }
        }
    }

    #[inline(always)]
    fn shift(&mut self, d: &Vector3<f64>) {
        for lane in 0..LANES {
            let (x, y, z) = (self.angular[0][lane], self.angular[1][lane], self.angular[2][lane]);
            self.linear[0][lane] += y * d.z - z * d.y;
            self.linear[1][lane] += z * d.x - x * d.z;
            self.linear[2][lane] += x * d.y - y * d.x;
        }
    }

    #[inline(always)]
    fn solve(&self, row: &Row, x: &mut Lanes) {
        for lane in 0..LANES {
            x[lane] -= dot(&row.gain.force, &self.linear, lane)
                + dot(&row.gain.moment, &self.angular, lane)
                + dot(&row.rate, &self.rate, lane);
        }
    }
}

impl Load {
    /// One column begins.
    pub(super) fn set(&mut self, lane: usize, e: &Wrench) {
        for i in 0..3 {
            self.force[i][lane] = e.force[i];
            self.moment[i][lane] = e.moment[i];
        }
    }

    /// Eqs. (6) and (7) across the hinge of one link, for the columns where `mask` is one; `x ← D⁻¹ u`.
    #[inline(always)]
    pub(super) fn pass<const MASKED: bool>(&mut self, kind: ColumnKind, rows: &[Row], mask: &Lanes, x: &mut [Lanes]) {
        for (row, x) in rows.iter().zip(x).rev() {
            let mut u = [0.0; LANES];
            match kind {
                ColumnKind::Slide => resist(&row.axis, &self.force, &mut u),
                ColumnKind::Turn | ColumnKind::Further => resist(&row.axis, &self.moment, &mut u),
                ColumnKind::Screw { pitch } => {
                    let mut along = [0.0; LANES];
                    resist(&row.axis, &self.moment, &mut u);
                    resist(&(pitch * row.axis), &self.force, &mut along);
                    (0..LANES).for_each(|lane| u[lane] += along[lane]);
                }
            }
            for lane in 0..LANES {
                u[lane] *= if MASKED { mask[lane] } else { 1.0 };
                // What is there are the column's own springs.
                x[lane] += row.inverse * u[lane];
            }
            add(&mut self.force, &row.gain.force, &u);
            add(&mut self.moment, &row.gain.moment, &u);
        }
        let d = &rows[0].arm;
        for lane in 0..LANES {
            let s = if MASKED { mask[lane] } else { 1.0 };
            let (x, y, z) = (s * self.force[0][lane], s * self.force[1][lane], s * self.force[2][lane]);
            self.moment[0][lane] += d.y * z - d.z * y;
            self.moment[1][lane] += d.z * x - d.x * z;
            self.moment[2][lane] += d.x * y - d.y * x;
        }
    }
}
