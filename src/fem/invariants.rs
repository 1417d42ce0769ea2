//! The coefficients of the inertia of a modal body: eq. (1) of [`crate::element::modal`] from the mass matrix of the finite elements.
//!
//! With `T` the displacements of the nodes for a rigid motion, and `e × φ` those for a turn of a displaced node:
//!
//! ```text
//! C₀ᵢ = T_vᵀ M φᵢ,   G₀ᵢ = T_ωᵀ M φᵢ,   J₀ = T_ωᵀ M T_ω
//! J₁ᵢ = Aᵢ + Aᵢᵀ,  Aᵢ = Σ_k φᵢₖ × (M T_ω)ₖ,   J₂ᵢⱼ = sym Σ_k φᵢₖ × (M (e × φⱼ))ₖ,   G₁ⱼᵢ = skew Σ_k φⱼₖ × (M φᵢ)ₖ
//! ```
//!
//! For nodes with displacements alone this is exact, with consistent mass matrices too: Zwölfer and Gerstmayr, "A concise
//! nodal-based derivation of the floating frame of reference formulation for displacement-based solid finite elements" (2020).
//! `∫ φⱼ × φᵢ` changes its sign with the order; what a mass matrix of beams or shells leaves of its symmetric part is left out.

use super::check::RigidBody;
use super::modes::{Basis, dot};
use super::{FiniteElements, UnitLoad};
use crate::spatial::Sym3;
use nalgebra::{Matrix3, Vector3};

/// What [`invariants`] finds; names as in [`crate::element::modal::Modal`].
pub(super) struct Invariants {
    pub(super) first: Vec<Vector3<f64>>,
    pub(super) second: Vec<Vector3<f64>>,
    pub(super) inertia: Sym3,
    pub(super) slopes: Vec<Sym3>,
    pub(super) curvatures: Vec<Sym3>,
    pub(super) moments: Vec<Vector3<f64>>,
    pub(super) turning: Vec<Vector3<f64>>,
}

/// The displacements of the nodes among numbers by freedom.
fn shifts(model: &FiniteElements, x: &[f64]) -> Vec<Vector3<f64>> {
    let mut all = vec![Vector3::zeros(); model.nodes.len()];
    for (freedom, x) in model.freedoms.iter().zip(x).filter(|(freedom, _)| freedom.direction < 3) {
        all[freedom.node][freedom.direction] = *x;
    }
    all
}

/// The displacements `e × φ` for a turn of displaced nodes about an axis.
fn swept(model: &FiniteElements, shifts: &[Vector3<f64>], axis: usize) -> Vec<f64> {
    let unit = Vector3::ith(axis, 1.0);
    let of = |freedom: &super::Freedom| match freedom.direction {
        direction @ 0..3 => unit.cross(&shifts[freedom.node])[direction],
        _ => 0.0,
    };
    model.freedoms.iter().map(of).collect()
}

fn crossed(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> Vector3<f64> {
    a.iter().zip(b).map(|(a, b)| a.cross(b)).sum()
}

/// Of a basis; `geometric` are the geometric stiffnesses in its coordinates.
pub(super) fn invariants(
    model: &FiniteElements,
    basis: &Basis,
    rigid: &RigidBody,
    geometric: &[(UnitLoad, Vec<f64>)],
) -> Invariants {
    let (m, root) = (basis.columns.len(), model.interfaces[0].point);
    let carried: Vec<Vec<f64>> = (0..6).map(|motion| model.mass.times(&model.rigid_motion(motion, &root))).collect();
    let turned: Vec<Vec<Vector3<f64>>> = (3..6).map(|motion| shifts(model, &carried[motion])).collect();
    let nodes: Vec<Vec<Vector3<f64>>> = basis.columns.iter().map(|x| shifts(model, x)).collect();
    let along = |x: &[f64], from: usize| Vector3::from_fn(|axis, _| dot(&carried[from + axis], x));
    let columns = |all: [Vector3<f64>; 3]| Matrix3::from_columns(&all);
    let mut found = Invariants {
        first: basis.columns.iter().map(|x| along(x, 0)).collect(),
        second: Vec::new(),
        inertia: Sym3::symmetric_part(&rigid.inertia),
        slopes: Vec::with_capacity(m),
        curvatures: vec![Sym3::ZERO; m * m],
        moments: basis.columns.iter().map(|x| along(x, 3)).collect(),
        turning: vec![Vector3::zeros(); m * m],
    };
    for i in 0..m {
        let slope = columns([0, 1, 2].map(|axis| crossed(&nodes[i], &turned[axis])));
        found.slopes.push(Sym3::symmetric_part(&(slope + slope.transpose())));
    }
    for j in 0..m {
        let momentum = shifts(model, &model.mass.times(&basis.columns[j]));
        let sweeps = [0, 1, 2].map(|axis| shifts(model, &model.mass.times(&swept(model, &nodes[j], axis))));
        for i in 0..m {
            let curvature = columns([0, 1, 2].map(|axis| crossed(&nodes[i], &sweeps[axis])));
            found.curvatures[i * m + j] = Sym3::symmetric_part(&curvature);
            // φᵢ × M φⱼ is entry (i, j); its mirror has the other sign.
            let turning = 0.5 * crossed(&nodes[i], &momentum);
            found.turning[i * m + j] += turning;
            found.turning[j * m + i] -= turning;
        }
    }
    for i in 0..m {
        for j in 0..i {
            // Symmetric to the last bit.
            found.curvatures[i * m + j] = found.curvatures[j * m + i];
        }
    }
    geometric.iter().for_each(|(load, matrix)| stiffen(&mut found, *load, matrix));
    found
}

/// Adds the terms of second order of one unit load.
fn stiffen(found: &mut Invariants, load: UnitLoad, matrix: &[f64]) {
    match load {
        UnitLoad::Acceleration(axis) => {
            found.second.resize(matrix.len(), Vector3::zeros());
            found.second.iter_mut().zip(matrix).for_each(|(second, entry)| second[axis] += entry);
        }
        UnitLoad::AngularAcceleration(axis) => {
            found.turning.iter_mut().zip(matrix).for_each(|(turning, entry)| turning[axis] += entry);
        }
        UnitLoad::Centrifugal(a, b) => {
            for (curvature, entry) in found.curvatures.iter_mut().zip(matrix) {
                match (a, b) {
                    (0, 0) => curvature.xx -= entry,
                    (1, 1) => curvature.yy -= entry,
                    (2, 2) => curvature.zz -= entry,
                    (0, 1) => curvature.xy -= 0.5 * entry,
                    (0, 2) => curvature.xz -= 0.5 * entry,
                    _ => curvature.yz -= 0.5 * entry,
                }
            }
        }
        // Of the interface: see `FiniteElements::tip`.
        UnitLoad::Force(..) => {}
    }
}
