//! How far forces that meet given equations can be inside of their cones.

use super::Cone;
use super::solver::Program;

/// `max δ` with `E f = right` and every force inside of its cone by δ: `f ≥ δ` of a ray, `μ f_n − |f_t| ≥ δ` of Coulomb's; and the
/// forces. `equations` is E by rows. `None` if no answer was found, or the build has no solver.
///
/// # Panics
/// If the equations are not as long as the cones are together.
pub fn slack(equations: &[Vec<f64>], right: &[f64], cones: &[Cone]) -> Option<(f64, Vec<f64>)> {
    let count: usize = cones.iter().map(Cone::size).sum();
    assert!(equations.iter().all(|row| row.len() == count), "one column for each number of a cone");
    let mut columns: Vec<Vec<(usize, f64)>> = (0..count)
        .map(|j| equations.iter().enumerate().filter(|(_, row)| row[j] != 0.0).map(|(i, row)| (i, row[j])).collect())
        .collect();
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
    Some((answer.x[count], answer.x[..count].to_vec()))
}
