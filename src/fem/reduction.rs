//! The reduction of Craig and Bampton (1968): with the root interface held,
//!
//! ```text
//! u = Φ q,   Φ = [ T_b; −K_ii⁻¹ K_ib T_b ] of the six motions of every other interface,   [ 0; φ ] of modes with all held
//! P = Φᵀ M Φ,   K = Φᵀ K Φ,   K_ii φ = ω² M_ii φ
//! ```
//!
//! `T_b` are the motions of an interface as a rigid body. Modes are scaled so that the largest displacement of a node is one, or its turn times the
//! reach of the body from its root.

use super::invariants::invariants;
use super::modes::{Basis, dot, lowest};
use super::{FiniteElements, Flaw, Freedom, ModalDamping};
use crate::element::modal::{MOST_MODAL_COORDINATES, Modal, ModalTip};
use crate::sparse::Cholesky;
use nalgebra::{DMatrix, Vector3};

impl FiniteElements {
    /// The modal body with this many modes beside the motions of its interfaces.
    ///
    /// # Errors
    /// What is wrong with the model, or more coordinates than a modal body may have.
    pub fn reduce(&self, modes: usize, damping: ModalDamping) -> Result<Modal, Flaw> {
        let rigid = self.check()?;
        let tips = self.interfaces.len() - 1;
        let m = 6 * tips + modes;
        if m == 0 || m > MOST_MODAL_COORDINATES {
            let message =
                format!("{m} coordinates: six for each of {tips} interfaces beside the root, and {modes} modes");
            return Err(Flaw::new(message).help(format!("allowed: 1 … {MOST_MODAL_COORDINATES}")));
        }
        let basis = self.basis(modes)?;
        let form = |matrix: &super::Symmetric| {
            let images: Vec<Vec<f64>> = basis.columns.iter().map(|x| matrix.times(x)).collect();
            let full = DMatrix::from_fn(m, m, |i, j| dot(&basis.columns[i], &images[j]));
            0.5 * (&full + full.transpose())
        };
        let (mass, stiffness) = (form(&self.mass), form(&self.stiffness));
        let scale = mass.diagonal().map(|x| if x > 0.0 { 1.0 / x.sqrt() } else { 0.0 });
        let scaled = DMatrix::from_fn(m, m, |i, j| scale[i] * mass[(i, j)] * scale[j]);
        if scaled.cholesky().is_none() {
            let message = "a motion of the interfaces has no mass";
            return Err(Flaw::new(message)
                .help("mass matrices need rotary inertia where an interface is a single node of them"));
        }
        let by_rows = |matrix: &DMatrix<f64>| (0..m * m).map(|at| matrix[(at / m, at % m)]).collect::<Vec<f64>>();
        let geometric: Vec<_> = self.geometric.iter().map(|(load, matrix)| (*load, by_rows(&form(matrix)))).collect();
        let invariants = invariants(self, &basis, &rigid, &geometric);
        let tips = (0..tips).map(|tip| self.tip(tip, m, &geometric)).collect();
        Ok(Modal {
            mass: rigid.mass,
            first: (rigid.first, invariants.first, invariants.second),
            inertia: (invariants.inertia, invariants.slopes, invariants.curvatures),
            turning: (invariants.moments, invariants.turning),
            mass_matrix: by_rows(&mass),
            stiffness: by_rows(&stiffness),
            damping: damping.matrix(&mass, &stiffness)?,
            tips,
            coordinates: self.names(modes),
            stiffens: !self.geometric.is_empty(),
        })
    }

    fn names(&self, modes: usize) -> Vec<(String, bool)> {
        const MOTIONS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];
        let of_tip = |name: &str| {
            let name = name.to_owned();
            MOTIONS.into_iter().enumerate().map(move |(i, motion)| (format!("{name}_{motion}"), i < 3))
        };
        let tips = self.interfaces.iter().skip(1).flat_map(|tip| of_tip(&tip.name));
        tips.chain((1..=modes).map(|mode| (format!("mode_{mode}"), true))).collect()
    }

    fn tip(&self, tip: usize, m: usize, geometric: &[(super::UnitLoad, Vec<f64>)]) -> ModalTip {
        let interface = &self.interfaces[tip + 1];
        let own = |i: usize| (6 * tip..6 * tip + 6).contains(&i).then(|| i - 6 * tip);
        let shift = |i| own(i).filter(|i| *i < 3).map_or_else(Vector3::zeros, |i| Vector3::ith(i, 1.0));
        let spin = |i| own(i).filter(|i| *i >= 3).map_or_else(Vector3::zeros, |i| Vector3::ith(i - 3, 1.0));
        let forces = geometric.iter().filter_map(|(load, matrix)| match load {
            super::UnitLoad::Force(at, axis) if *at == tip + 1 => Some((*axis, matrix)),
            _ => None,
        });
        let mut second = Vec::new();
        for (axis, matrix) in forces {
            second.resize(m * m, Vector3::zeros());
            second.iter_mut().zip(matrix).for_each(|(second, entry): (&mut Vector3<f64>, _)| second[axis] -= entry);
        }
        let moved_by = if second.is_empty() { (6 * tip..6 * tip + 6).collect() } else { (0..m).collect() };
        ModalTip {
            name: interface.name.clone(),
            place: interface.point - self.interfaces[0].point,
            shift: (0..m).map(shift).collect(),
            spin: (0..m).map(spin).collect(),
            second,
            moved_by,
        }
    }

    /// Of every freedom the interface that holds it.
    fn holders(&self) -> Vec<Option<usize>> {
        let mut of_node = vec![None; self.nodes.len()];
        for (index, interface) in self.interfaces.iter().enumerate() {
            interface.nodes.iter().for_each(|node| of_node[*node] = Some(index));
        }
        self.freedoms.iter().map(|freedom| of_node[freedom.node]).collect()
    }

    /// # Errors
    /// A part that hangs on nothing, or modes that do not settle.
    fn basis(&self, modes: usize) -> Result<Basis, Flaw> {
        let (n, holders) = (self.freedoms.len(), self.holders());
        let mut inner = Vec::new();
        let place: Vec<Option<usize>> = (0..n)
            .map(|row| {
                let at = holders[row].is_none().then_some(inner.len());
                inner.extend(at.map(|_| row));
                at
            })
            .collect();
        let (stiffness, mass) = (self.stiffness.part(&place, inner.len()), self.mass.part(&place, inner.len()));
        let mut factors = Cholesky::new(stiffness.pattern());
        if !inner.is_empty() && !factors.llt(stiffness.pattern(), stiffness.values()) {
            let message =
                "the stiffness with all interfaces held is not positive definite: something moves without resistance";
            return Err(Flaw::new(message).help("export one piece without mechanisms and unused freedoms; elements of reduced integration (C3D20R) may have such motions"));
        }
        let mut columns = Vec::with_capacity(6 * self.interfaces.len() + modes);
        for tip in 1..self.interfaces.len() {
            for motion in 0..6 {
                let mut column = vec![0.0; n];
                for (row, freedom) in self.freedoms.iter().enumerate().filter(|(row, _)| holders[*row] == Some(tip)) {
                    column[row] = self.rigid(*freedom, motion, &self.interfaces[tip].point);
                }
                let force = self.stiffness.times(&column);
                let mut follows: Vec<f64> = inner.iter().map(|row| -force[*row]).collect();
                if !inner.is_empty() {
                    factors.solve(&mut follows);
                }
                inner.iter().zip(follows).for_each(|(row, x)| column[*row] = x);
                columns.push(column);
            }
        }
        let root = self.interfaces[0].point;
        let reach = self.nodes.iter().map(|node| (node - root).norm()).fold(0.0, f64::max);
        for mode in lowest(&stiffness, &mass, &mut factors, modes)? {
            let mut column = vec![0.0; n];
            inner.iter().zip(mode).for_each(|(row, x)| column[*row] = x);
            let size = |(freedom, x): (&Freedom, &f64)| if freedom.direction < 3 { x.abs() } else { reach * x.abs() };
            let largest = self.freedoms.iter().zip(&column).map(size).fold(0.0, f64::max);
            column.iter_mut().for_each(|x| *x /= largest);
            columns.push(column);
        }
        Ok(Basis { columns })
    }
}
