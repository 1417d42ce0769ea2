//! The constrained problem at one position: tangent motions, multipliers, what is left unbalanced.

use crate::constraint::Closer;
use crate::dynamics::{Fault, System};
use crate::model::{Joint, Model};
use crate::statics::landscape::{Scales, slides};
use crate::statics::search::Place;
use faer::Mat;

/// A singular value below this part of the largest belongs to a row that hangs on the others.
const DEPENDENT: f64 = 1e-10;
/// Below this part of what it was elsewhere a row is left to the branch that the search came along.
const NEARLY: f64 = 1e-2;

/// The static problem of a model with loops, drives or gears.
pub(super) struct Tied<'m> {
    pub(super) system: System<'m>,
    closer: Closer<'m>,
    /// Locked velocity coordinates.
    pub(super) locked: Vec<usize>,
    /// `B`: the inertia each velocity coordinate sees.
    pub(super) metric: Vec<f64>,
    /// Velocities of a steady motion: those of drives where the rest can stay at rest beside them, else zero.
    pub(super) steady: Vec<f64>,
    /// Drives whose velocity cannot be kept.
    pub(super) frozen: Vec<String>,
    pub(super) residuals: usize,
    pub(super) stiffnesses: usize,
    none: Vec<f64>,
    length: f64,
}

/// The problem at one position.
#[derive(Debug, Clone)]
pub(super) struct View {
    /// Position, what is left of the forces there, and the sizes of what cancels.
    pub(super) place: Place,
    /// `Z`, one column per motion.
    pub(super) tangent: Mat<f64>,
    /// `Zᵀ r`.
    pub(super) gradient: Vec<f64>,
    /// `λ`: independent rows, then locked coordinates.
    pub(super) multipliers: Vec<f64>,
    /// Potential less the kinetic energy of the steady motion (J).
    pub(super) potential: f64,
    /// Sizes of the terms in it (J).
    pub(super) energy_scale: f64,
    /// The largest curvature that the terms of the stiffness can make.
    pub(super) stiffest: f64,
    /// Rows hang on each other here that do not elsewhere.
    pub(super) singular: bool,
    /// The largest of the smallest singular values met.
    regular: f64,
}

impl<'m> Tied<'m> {
    pub(super) fn new(model: &'m Model, start: &[f64]) -> Result<Self, Fault> {
        let mut system = System::new(model);
        let n = model.velocity_count();
        let none = vec![0.0; n];
        let mut metric = vec![0.0; n];
        system.accelerations(start, &none, &mut metric)?;
        system.articulated_inertia(&mut metric);
        let locked: Vec<usize> = (0..n).filter(|i| model.coordinates[*i].lock).collect();
        let (steady, frozen) = steady(&mut system, start);
        Ok(Self {
            system,
            closer: Closer::new(model),
            locked,
            metric,
            steady,
            frozen,
            residuals: 0,
            stiffnesses: 0,
            none,
            length: model.length_scale(),
        })
    }

    pub(super) fn model(&self) -> &'m Model {
        self.system.model()
    }

    /// The problem at a closed position; `before` is where the search comes from.
    pub(super) fn view(&mut self, q: &[f64], before: Option<&View>) -> Result<View, Fault> {
        let n = self.none.len();
        let rows = self.system.constraints().map_or(0, |rows| rows.rank());
        self.residuals += 1;
        self.system.set_multipliers(&vec![0.0; rows]);
        let mut force = vec![0.0; n];
        self.system.residual(q, &self.steady, &self.none, &mut force)?;
        let magnitudes = self.system.balance_magnitudes(q);
        let of_rows = self.system.constraint_matrix(q);
        let all = Mat::from_fn(rows + self.locked.len(), n, |i, j| match i.checked_sub(rows) {
            None => of_rows[(i, j)],
            Some(lock) => f64::from(u8::from(self.locked[lock] == j)),
        });
        let root: Vec<f64> = self.metric.iter().map(|b| b.sqrt()).collect();
        // Rows of one size: a turn's beside a slide's.
        let size = |i: usize| (0..n).map(|j| (all[(i, j)] / root[j]).powi(2)).sum::<f64>().sqrt();
        let sizes: Vec<f64> = (0..all.nrows()).map(|i| size(i).max(f64::MIN_POSITIVE)).collect();
        let largest = sizes.iter().fold(0.0_f64, |m, s| m.max(*s));
        let weigh = |i: usize| if sizes[i] > NEARLY * largest { sizes[i] } else { largest };
        let scaled = Mat::from_fn(all.nrows(), n, |i, j| all[(i, j)] / (root[j] * weigh(i)));
        let parts = Parts::of(&scaled);
        let smallest = parts.values.iter().copied().filter(|s| *s > DEPENDENT).fold(f64::INFINITY, f64::min);
        let regular = before.map_or(smallest, |before| before.regular.max(smallest));
        let limit = if before.is_some() { NEARLY * regular } else { DEPENDENT };
        let singular = parts.values.iter().any(|s| *s < NEARLY * regular);
        let rank = parts.values.iter().filter(|s| **s > limit).count();
        let mut null = Mat::from_fn(n, n - rank, |i, j| parts.right[(i, rank + j)]);
        if let Some(before) = before
            && before.tangent.ncols() < null.ncols()
        {
            null = nearest(&null, &before.tangent, &root);
        }
        let tangent = Mat::from_fn(n, null.ncols(), |i, j| null[(i, j)] / root[i]);
        let gradient: Vec<f64> = (0..null.ncols()).map(|j| (0..n).map(|i| tangent[(i, j)] * force[i]).sum()).collect();
        let left: Vec<f64> =
            (0..n).map(|i| root[i] * (0..gradient.len()).map(|j| null[(i, j)] * gradient[j]).sum::<f64>()).collect();
        let multipliers: Vec<f64> = parts
            .solve(rank, &(0..n).map(|i| force[i] / root[i]).collect::<Vec<_>>())
            .iter()
            .enumerate()
            .map(|(i, x)| x / weigh(i))
            .collect();
        let held = |i: usize| (0..all.nrows()).map(|row| (all[(row, i)] * multipliers[row]).abs()).sum::<f64>();
        let per = slides(self.model());
        // A coordinate in which next to nothing acts still feels the round-off of the loops around it.
        let unit = |i: usize| if per[i] { 1.0 } else { self.length };
        let per_move = |i: usize| if per[i] { self.length } else { 1.0 };
        let strongest = (0..n).map(|i| (magnitudes.force[i] + held(i)) / unit(i)).fold(0.0, f64::max);
        let stiffness = |i: usize| (magnitudes.force[i] + held(i)) / per_move(i) + magnitudes.stiffness[i];
        // Where rows nearly hang on each other, closed positions are known to the round-off of a gap over their angle.
        let slightest = sizes.iter().map(|size| size / largest).filter(|part| *part > DEPENDENT).fold(1.0, f64::min);
        let least = parts.values.get(rank.wrapping_sub(1)).map_or(1.0, |least| *least);
        let unsure = f64::EPSILON / (least * slightest);
        let scales = Scales {
            force: (0..n).map(|i| magnitudes.force[i] + held(i)).collect(),
            noise: (0..n)
                .map(|i| {
                    let terms = magnitudes.noise[i] + held(i) + strongest * unit(i);
                    f64::EPSILON * terms + unsure * stiffness(i) * per_move(i)
                })
                .collect(),
            stiffness: (0..n).map(stiffness).collect(),
        };
        let at_rest = self.system.potential_at_rest(q, &self.steady);
        let energies = self.system.energies(q, &self.steady);
        let stiffest = (0..n).map(|i| scales.stiffness[i] / self.metric[i]).fold(0.0, f64::max);
        let energy_scale = (0..n).map(|i| scales.force[i] * if per[i] { self.length } else { 1.0 }).fold(0.0, f64::max);
        self.system.set_multipliers(&multipliers[..rows]);
        Ok(View {
            place: Place { q: q.to_vec(), force: left.iter().map(|r| -r).collect(), scales },
            tangent,
            gradient,
            multipliers,
            potential: at_rest - energies.kinetic,
            energy_scale,
            stiffest,
            singular,
            regular,
        })
    }

    /// The view after a step `y` along the tangent, closed again; `None` where it cannot be closed or evaluated.
    pub(super) fn moved(&mut self, view: &View, y: &[f64]) -> Result<Option<View>, Fault> {
        let n = self.none.len();
        let step: Vec<f64> = (0..n).map(|i| (0..y.len()).map(|j| view.tangent[(i, j)] * y[j]).sum()).collect();
        let mut q = view.place.q.clone();
        System::displace(self.model(), &mut q, &step);
        if !self.closer.close(&mut q) {
            return Ok(None);
        }
        Ok(self.view(&q, Some(view)).ok())
    }

    /// `H` of eq. (3), in the metric.
    pub(super) fn stiffness(&mut self, view: &View) -> Result<Mat<f64>, Fault> {
        self.stiffnesses += 1;
        let rows = view.multipliers.len() - self.locked.len();
        self.system.set_multipliers(&view.multipliers[..rows]);
        let linear = self.system.linearize(&view.place.q, &self.steady, &self.none)?;
        Ok(view.tangent.transpose() * &linear.stiffness * &view.tangent)
    }

    /// Eigenvalues of the symmetric part of `H`, ascending, and their directions.
    pub(super) fn curvatures(&mut self, view: &View) -> Result<(Vec<f64>, Mat<f64>), Fault> {
        let n = view.gradient.len();
        if n == 0 {
            return Ok((Vec::new(), Mat::zeros(0, 0)));
        }
        let h = self.stiffness(view)?;
        let symmetric = Mat::from_fn(n, n, |i, j| 0.5 * (h[(i, j)] + h[(j, i)]));
        Ok(match symmetric.self_adjoint_eigen(faer::Side::Lower) {
            Ok(eigen) => ((0..n).map(|i| eigen.S()[i]).collect(), eigen.U().to_owned()),
            Err(_) => (vec![f64::NAN; n], Mat::identity(n, n)),
        })
    }

    /// `−H⁻¹ Zᵀ r`; motions that cost nothing are left alone. `None` where that is not finite.
    pub(super) fn newton(&mut self, view: &View) -> Result<Option<Vec<f64>>, Fault> {
        let n = view.gradient.len();
        if n == 0 {
            return Ok(None);
        }
        let h = self.stiffness(view)?;
        let Ok(svd) = h.svd() else { return Ok(None) };
        let largest = svd.S()[0];
        let mut y = vec![0.0; n];
        for k in 0..n {
            let value = svd.S()[k];
            if value > 1e-12 * largest {
                let part: f64 = (0..n).map(|i| svd.U()[(i, k)] * view.gradient[i]).sum();
                (0..n).for_each(|i| y[i] -= svd.V()[(i, k)] * part / value);
            }
        }
        Ok((y.iter().all(|y| y.is_finite())).then_some(y))
    }

    /// How long a step may be (in the metric) for no coordinate to change by more than `most` (rad, part of the scene's
    /// length), whatever its direction.
    pub(super) fn longest(&self, view: &View, most: f64) -> f64 {
        let mut longest = f64::INFINITY;
        for link in &self.model().links {
            let allowed = if matches!(link.joint, Joint::Slide { .. }) { most * self.length } else { most };
            for i in link.velocity..link.velocity + link.joint.counts().1 {
                let most_changed = (0..view.tangent.ncols()).map(|j| view.tangent[(i, j)].powi(2)).sum::<f64>().sqrt();
                longest = longest.min(allowed / most_changed.max(f64::MIN_POSITIVE));
            }
        }
        longest
    }

    /// The coordinates that move most along a direction.
    pub(super) fn names(&self, view: &View, y: &[f64]) -> String {
        let n = self.none.len();
        let moved: Vec<f64> = (0..n).map(|i| (0..y.len()).map(|j| view.tangent[(i, j)] * y[j]).sum()).collect();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|a, b| moved[*b].abs().total_cmp(&moved[*a].abs()));
        order.iter().take(2).map(|i| self.model().label(*i)).collect::<Vec<_>>().join(", ")
    }
}

/// Singular values and vectors of a wide matrix.
struct Parts {
    left: Mat<f64>,
    values: Vec<f64>,
    right: Mat<f64>,
}

impl Parts {
    fn of(matrix: &Mat<f64>) -> Self {
        let (m, n) = (matrix.nrows(), matrix.ncols());
        match matrix.svd() {
            Ok(svd) => {
                let values = (0..m.min(n)).map(|i| svd.S()[i]).collect();
                Self { left: svd.U().to_owned(), values, right: svd.V().to_owned() }
            }
            Err(_) => Self { left: Mat::identity(m, m), values: vec![0.0; m.min(n)], right: Mat::identity(n, n) },
        }
    }

    /// `U S⁻¹ Vᵀ x` with the first `rank` values.
    fn solve(&self, rank: usize, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.left.nrows()];
        for k in 0..rank {
            let part: f64 = (0..x.len()).map(|i| self.right[(i, k)] * x[i]).sum::<f64>() / self.values[k];
            for (i, out) in out.iter_mut().enumerate() {
                *out += self.left[(i, k)] * part;
            }
        }
        out
    }
}

/// Within a null space that has become larger, the part nearest to the motions there were before, orthonormal.
fn nearest(null: &Mat<f64>, before: &Mat<f64>, root: &[f64]) -> Mat<f64> {
    let old = Mat::from_fn(before.nrows(), before.ncols(), |i, j| before[(i, j)] * root[i]);
    let inside = null * (null.transpose() * &old);
    match inside.thin_svd() {
        Ok(svd) => svd.U() * svd.V().transpose(),
        Err(_) => inside,
    }
}

/// Velocities of the drives where they leave the rest at rest, and the drives that cannot be kept moving.
fn steady(system: &mut System<'_>, start: &[f64]) -> (Vec<f64>, Vec<String>) {
    let model = system.model();
    let mut velocity = vec![0.0; model.velocity_count()];
    let mut moving = Vec::new();
    for drive in &model.drives {
        let now = drive.motion.at(0.0);
        if now.velocity != 0.0 {
            velocity[drive.coordinate.velocity] = now.velocity;
            moving.push(format!("`{}`", drive.name));
        }
    }
    if moving.is_empty() {
        return (velocity, Vec::new());
    }
    let mut settled = (start.to_vec(), velocity.clone());
    let size = velocity.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let kept = system.settle(&mut settled.0, &mut settled.1).is_ok()
        && settled.1.iter().zip(&velocity).all(|(a, b)| (a - b).abs() <= 1e-9 * size)
        && model.drives.iter().all(|drive| drive.motion.is_steady());
    if kept { (velocity, Vec::new()) } else { (vec![0.0; model.velocity_count()], moving) }
}
