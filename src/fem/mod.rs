//! Finite element models of other programs: nodes, sparse mass and stiffness matrices, interfaces; checked, and reduced to modal
//! bodies.
//!
//! What a file must hold is in [`npz`] and in the guide (docs/guide/modal_bodies.md). The reduction is that of Craig and Bampton
//! (`reduction`): the displacements of the interfaces and modes with all interfaces held.

mod check;
mod damping;
mod invariants;
mod matrix;
mod modes;
#[cfg(feature = "import")]
pub mod npz;
mod reduction;

pub use damping::ModalDamping;
pub use matrix::Symmetric;

use nalgebra::Vector3;

/// What a model of finite elements lacks, or what is wrong with it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct Flaw {
    /// What is wrong, with names and values.
    pub message: String,
    /// What is allowed, or what to do.
    pub help: Option<String>,
}

impl Flaw {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), help: None }
    }

    pub(crate) fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }
}

/// A displacement of one node: along x, y, z (0, 1, 2) or a turn about them (3, 4, 5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Freedom {
    /// Index of the node.
    pub node: usize,
    /// 0 … 5.
    pub direction: usize,
}

/// A place where other bodies are attached: its nodes move as one rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct Interface {
    /// Name.
    pub name: String,
    /// The point that stands for it (m), in the axes of the nodes.
    pub point: Vector3<f64>,
    /// Indices of its nodes.
    pub nodes: Vec<usize>,
}

/// What a geometric stiffness belongs to: the body, held at its root, bears this load.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum UnitLoad {
    /// The inertia of an acceleration of the root by 1 m/s² along an axis.
    Acceleration(usize),
    /// The inertia of an angular acceleration by 1 rad/s² about an axis.
    AngularAcceleration(usize),
    /// The centrifugal forces for `ω_a ω_b = 1` of these axes, `a ≤ b`.
    Centrifugal(usize, usize),
    /// A force of 1 N on an interface along an axis; the root is interface 0.
    Force(usize, usize),
}

impl UnitLoad {
    const CENTRIFUGAL: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

    /// By its number in files: 0 … 2 accelerations, 3 … 5 angular ones, 6 … 11 centrifugal (xx, yy, zz, xy, xz, yz), from 12 on
    /// three forces for every interface but the root. `None` for other numbers.
    pub fn of_number(number: usize, interfaces: usize) -> Option<Self> {
        match number {
            0..3 => Some(Self::Acceleration(number)),
            3..6 => Some(Self::AngularAcceleration(number - 3)),
            6..12 => Some(Self::Centrifugal(Self::CENTRIFUGAL[number - 6].0, Self::CENTRIFUGAL[number - 6].1)),
            _ => {
                let (interface, axis) = (1 + (number - 12) / 3, (number - 12) % 3);
                (interface < interfaces).then_some(Self::Force(interface, axis))
            }
        }
    }
}

/// What another program says of the body, to be compared with the matrices.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Declared {
    /// Mass (kg).
    pub mass: Option<f64>,
    /// Centre of mass in the axes of the nodes (m).
    pub center: Option<Vector3<f64>>,
    /// Principal or not: xx, yy, zz about the centre of mass (kg m²).
    pub inertia: Option<Vector3<f64>>,
}

/// A model of finite elements without constraints. All numbers are SI and in the axes of the nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct FiniteElements {
    /// Places of the nodes (m).
    pub nodes: Vec<Vector3<f64>>,
    /// What each row of the matrices is.
    pub freedoms: Vec<Freedom>,
    /// Mass (kg, kg m, kg m²).
    pub mass: Symmetric,
    /// Stiffness (N/m, N, N m).
    pub stiffness: Symmetric,
    /// The interfaces; the first is the root, whose point is the origin of the body.
    pub interfaces: Vec<Interface>,
    /// Geometric stiffness for unit loads; none without.
    pub geometric: Vec<(UnitLoad, Symmetric)>,
    /// What to compare with.
    pub declared: Declared,
}

impl FiniteElements {
    /// The displacement of a freedom for a small motion of a rigid body: `motion` is 0 … 2 for shifts, 3 … 5 for turns about a
    /// point.
    pub(crate) fn rigid(&self, freedom: Freedom, motion: usize, about: &Vector3<f64>) -> f64 {
        let Freedom { node, direction } = freedom;
        match (direction < 3, motion < 3) {
            (true, true) | (false, false) => f64::from(u8::from(direction == motion)),
            (false, true) => 0.0,
            (true, false) => Vector3::ith(motion - 3, 1.0).cross(&(self.nodes[node] - about))[direction],
        }
    }

    /// All freedoms for one rigid motion about a point.
    pub(crate) fn rigid_motion(&self, motion: usize, about: &Vector3<f64>) -> Vec<f64> {
        self.freedoms.iter().map(|freedom| self.rigid(*freedom, motion, about)).collect()
    }

    /// A freedom for people.
    pub(crate) fn label(&self, row: usize) -> String {
        let Freedom { node, direction } = self.freedoms[row];
        format!("node {node} {}", ["x", "y", "z", "about x", "about y", "about z"][direction])
    }
}

/// `3 rows`, `1 row`.
fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}
