//! What a model of finite elements must be before anything is made of it.

use super::{FiniteElements, Flaw};
use crate::fem::counted;
use nalgebra::{Matrix3, Matrix6, SymmetricEigen, Vector3, Vector6};
use std::collections::HashSet;

/// Forces that a rigid motion leaves, against the sum of the sizes of their terms: text files have six digits or more.
const FREE: f64 = 1e-5;

/// Masses along different axes, and what is declared beside what the matrices have, may differ by this part.
const SAME: f64 = 1e-4;

/// Mass properties that follow from the matrices, about the root.
#[derive(Debug, Clone, Copy)]
pub(super) struct RigidBody {
    pub(super) mass: f64,
    /// First moment of mass (kg m).
    pub(super) first: Vector3<f64>,
    /// About the root (kg m²).
    pub(super) inertia: Matrix3<f64>,
}

const MOTIONS: [&str; 6] =
    ["a shift along x", "a shift along y", "a shift along z", "a turn about x", "a turn about y", "a turn about z"];

impl FiniteElements {
    /// # Errors
    /// The first thing that is wrong.
    pub(super) fn check(&self) -> Result<RigidBody, Flaw> {
        self.check_names()?;
        for interface in 0..self.interfaces.len() {
            self.check_interface(interface)?;
        }
        self.check_freedom()?;
        self.check_mass()
    }

    fn check_names(&self) -> Result<(), Flaw> {
        let (nodes, n) = (self.nodes.len(), self.freedoms.len());
        if let Some(node) = self.nodes.iter().position(|at| at.iter().any(|x| !x.is_finite())) {
            return Err(Flaw::new(format!("node {node} has a place that is not finite")));
        }
        let mut seen = HashSet::new();
        for (row, freedom) in self.freedoms.iter().enumerate() {
            if freedom.node >= nodes || freedom.direction > 5 {
                let message = format!("row {row} is direction {} of node {}", freedom.direction, freedom.node);
                return Err(
                    Flaw::new(message).help(format!("allowed: nodes 0 … {}, directions 0 … 5", nodes.max(1) - 1))
                );
            }
            if !seen.insert(*freedom) {
                return Err(Flaw::new(format!("row {row}: {} is a row already", self.label(row))));
            }
        }
        for (name, matrix) in [("mass", &self.mass), ("stiffness", &self.stiffness)] {
            if matrix.len() != n {
                return Err(Flaw::new(format!(
                    "{name} has {}, and there are {n} `dofs`",
                    counted(matrix.len(), "row", "rows")
                )));
            }
        }
        if self.interfaces.is_empty() {
            return Err(
                Flaw::new("no interface").help("the first interface is the root, which the body's frame is fixed to")
            );
        }
        let mut owners = vec![None; nodes];
        for (index, interface) in self.interfaces.iter().enumerate() {
            let name = &interface.name;
            if self.interfaces[..index].iter().any(|other| other.name == *name) {
                return Err(Flaw::new(format!("two interfaces are called `{name}`")));
            }
            if name.is_empty() || name == "modes" || name == "root" && index > 0 {
                return Err(Flaw::new(format!("an interface may not be called `{name}`")));
            }
            for node in &interface.nodes {
                let Some(owner) = owners.get_mut(*node) else {
                    return Err(Flaw::new(format!("interface `{name}` has node {node} of {nodes}")));
                };
                if let Some(other) = owner.replace(index) {
                    let other = &self.interfaces[other].name;
                    return Err(Flaw::new(format!("node {node} belongs to the interfaces `{other}` and `{name}`")));
                }
            }
        }
        Ok(())
    }

    /// The nodes of an interface must know its turns.
    fn check_interface(&self, index: usize) -> Result<(), Flaw> {
        let interface = &self.interfaces[index];
        let mut gram = Matrix6::zeros();
        let mut size = 0.0_f64;
        for freedom in self.freedoms.iter().filter(|freedom| interface.nodes.contains(&freedom.node)) {
            let row = Vector6::from_fn(|motion, _| self.rigid(*freedom, motion, &interface.point));
            size = size.max((self.nodes[freedom.node] - interface.point).norm());
            gram += row * row.transpose();
        }
        let unit = if size > 0.0 { size } else { 1.0 };
        let scale = Vector6::new(1.0, 1.0, 1.0, 1.0 / unit, 1.0 / unit, 1.0 / unit);
        let scaled = Matrix6::from_fn(|i, j| scale[i] * gram[(i, j)] * scale[j]);
        let eigen = SymmetricEigen::new(scaled);
        let lowest = eigen.eigenvalues.imin();
        if eigen.eigenvalues[lowest] > 1e-8 * eigen.eigenvalues.max() {
            return Ok(());
        }
        let loose = MOTIONS[eigen.eigenvectors.column(lowest).iamax()];
        let message =
            format!("interface `{}`: {loose} is not one of its {} nodes", interface.name, interface.nodes.len());
        Err(Flaw::new(message)
            .help("an interface is a node with six freedoms, or three nodes and more that are not in a line"))
    }

    /// Six motions that nothing resists.
    fn check_freedom(&self) -> Result<(), Flaw> {
        let root = self.interfaces[0].point;
        for (motion, name) in MOTIONS.iter().enumerate() {
            let rigid = self.rigid_motion(motion, &root);
            let (force, sizes) = (self.stiffness.times(&rigid), self.stiffness.sizes(&rigid));
            let largest = sizes.iter().fold(0.0_f64, |most, size| most.max(*size));
            let part = |row: usize| force[row].abs() / (sizes[row] + 1e-6 * largest);
            let worst = (0..force.len()).max_by(|a, b| part(*a).total_cmp(&part(*b)));
            if let Some(row) = worst.filter(|row| part(*row) > FREE) {
                let message = format!(
                    "the stiffness resists {name}: {:.3e} of {:.3e} at {}",
                    force[row],
                    sizes[row],
                    self.label(row)
                );
                let help = "a free body has six such motions without force: export it without supports, and check that places \
                            and matrices have the same units and axes";
                return Err(Flaw::new(message).help(help));
            }
        }
        Ok(())
    }

    fn check_mass(&self) -> Result<RigidBody, Flaw> {
        let root = self.interfaces[0].point;
        let motions: Vec<Vec<f64>> = (0..6).map(|motion| self.rigid_motion(motion, &root)).collect();
        let held: Vec<Vec<f64>> = motions.iter().map(|motion| self.mass.times(motion)).collect();
        let whole = Matrix6::from_fn(|i, j| motions[i].iter().zip(&held[j]).map(|(a, b)| a * b).sum());
        let along = [0, 1, 2].map(|i| whole[(i, i)]);
        let mass = along.iter().sum::<f64>() / 3.0;
        let off = (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).filter(|(i, j)| i != j);
        let mixed = off.map(|at| whole[at].abs()).fold(0.0, f64::max);
        if !(mass > 0.0) || along.iter().any(|m| (m - mass).abs() > SAME * mass) || mixed > SAME * mass {
            let message =
                format!("the mass is {:.6e} kg along x, {:.6e} along y, {:.6e} along z", along[0], along[1], along[2]);
            return Err(Flaw::new(message).help("it must be positive and the same along all three"));
        }
        let block = whole.fixed_view::<3, 3>(0, 3).into_owned();
        let first = 0.5
            * Vector3::new(block[(1, 2)] - block[(2, 1)], block[(2, 0)] - block[(0, 2)], block[(0, 1)] - block[(1, 0)]);
        let inertia = whole.fixed_view::<3, 3>(3, 3).into_owned();
        let skew = block + first.cross_matrix();
        let size = (mass * inertia.trace()).sqrt();
        if skew.amax() > SAME * size {
            let message = format!("the mass matrix has no centre of mass: {:.3e} kg m beside {size:.3e}", skew.amax());
            return Err(Flaw::new(message).help("places of nodes and rows of the matrices do not belong together"));
        }
        let center = first / mass;
        let central = inertia - mass * (center.norm_squared() * Matrix3::identity() - center * center.transpose());
        let moments = central.symmetric_eigenvalues();
        let largest = moments.max();
        if moments.min() < -SAME * largest || 2.0 * largest - moments.sum() > SAME * largest {
            let message = format!(
                "no body has the moments of inertia {:.4e}, {:.4e}, {:.4e} kg m²",
                moments[0], moments[1], moments[2]
            );
            return Err(Flaw::new(message).help("places of nodes and rows of the matrices do not belong together"));
        }
        self.compare(mass, &(center + root), &central)?;
        Ok(RigidBody { mass, first, inertia })
    }

    /// With what the file declares.
    fn compare(&self, mass: f64, center: &Vector3<f64>, inertia: &Matrix3<f64>) -> Result<(), Flaw> {
        let declared = &self.declared;
        let help = "mass, centre and inertia that the file declares must be those of its matrices and nodes";
        if let Some(given) = declared.mass.filter(|given| !((given - mass).abs() <= SAME * mass)) {
            return Err(Flaw::new(format!("the mass is {mass:.6e} kg, declared are {given:.6e}")).help(help));
        }
        let length = (inertia.trace() / mass).sqrt();
        if let Some(given) = declared.center.filter(|given| !((given - center).norm() <= SAME * length)) {
            let list = |v: &Vector3<f64>| format!("({:.6e}, {:.6e}, {:.6e}) m", v.x, v.y, v.z);
            return Err(
                Flaw::new(format!("the centre of mass is {}, declared is {}", list(center), list(&given))).help(help)
            );
        }
        let moments = inertia.diagonal();
        if let Some(given) = declared.inertia.filter(|given| !((given - moments).amax() <= SAME * moments.amax())) {
            let list = |v: &Vector3<f64>| format!("({:.6e}, {:.6e}, {:.6e}) kg m²", v.x, v.y, v.z);
            let message = format!("the moments of inertia are {}, declared are {}", list(&moments), list(&given));
            return Err(Flaw::new(message).help(help));
        }
        Ok(())
    }
}
