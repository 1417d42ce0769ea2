//! How far forces that meet given equations can be inside of their cones.

use super::Cone;
use super::solver::Program;
use nalgebra::{DMatrix, DVector};

/// Equations that are missed by more than this part of their right sides are not met.
const MET: f64 = 1e-9;

/// `max δ` with `E f = right` and every force inside of its cone by δ: `f ≥ δ` of a ray, `μ f_n − |f_t| ≥ δ` of Coulomb's; and the
/// forces. `equations` is E by rows, linearly independent ones. `None` if no answer was found that meets them, or the build has no
/// solver. What is claimed is computed from the forces.
///
/// # Panics
/// If the equations are not as long as the cones are together.
pub fn slack(equations: &[Vec<f64>], right: &[f64], cones: &[Cone]) -> Option<(f64, Vec<f64>)> {
    let count: usize = cones.iter().map(Cone::size).sum();
    assert!(equations.iter().all(|row| row.len() == count), "one column for each number of a cone");
    let mut columns: Vec<Vec<(usize, f64)>> = (0..count)
        .map(|j| equations.iter().enumerate().filter(|(_, row)| row[j] != 0.0).map(|(i, row)| (i, row[j])).collect())
        .collect();
    let wanted = right.to_vec();
    let mut right = right.to_vec();
    let (mut depth, mut shapes, mut at) = (Vec::new(), Vec::new(), 0);
    for cone in cones {
        let Some(shape) = cone.rows() else {
            at += cone.size();
            continue;
        };
        let row = right.len();
        match cone {
            Cone::Coulomb { friction } => {
                columns[at].push((row, -friction));
                (1..3).for_each(|k| columns[at + k].push((row + k, -1.0)));
            }
            _ => columns[at].push((row, -1.0)),
        }
        right.extend(std::iter::repeat_n(0.0, shape.1));
        depth.push((row, 1.0));
        shapes.push(shape);
        at += cone.size();
    }
    columns.push(depth);
    let mut linear = vec![0.0; count];
    linear.push(-1.0);
    let program =
        Program { quadratic: vec![0.0; count + 1], linear, columns, right, equations: equations.len(), cones: shapes };
    let answer = program.solve()?;
    let forces = met(equations, &wanted, &answer.x[..count])?;
    let mut at = 0;
    let each = cones.iter().map(|cone| {
        let own = &forces[at..at + cone.size()];
        at += cone.size();
        -cone.outside(own)
    });
    let depth = each.fold(f64::INFINITY, f64::min);
    Some((depth, forces))
}

/// The forces nearest to these that meet equations: `f + Eᵀ (E Eᵀ)⁻¹ (right − E f)`.
fn met(equations: &[Vec<f64>], right: &[f64], forces: &[f64]) -> Option<Vec<f64>> {
    let matrix = DMatrix::from_fn(equations.len(), forces.len(), |i, j| equations[i][j]);
    let right = DVector::from_row_slice(right);
    let mut forces = DVector::from_row_slice(forces);
    if !equations.is_empty() {
        let gram = (&matrix * matrix.transpose()).cholesky()?;
        for _ in 0..2 {
            let multipliers = gram.solve(&(&right - &matrix * &forces));
            forces += matrix.tr_mul(&multipliers);
        }
        let missed = (&matrix * &forces - &right).amax();
        if !(missed <= MET * right.amax().max(f64::MIN_POSITIVE)) {
            return None;
        }
    }
    Some(forces.as_slice().to_vec())
}
