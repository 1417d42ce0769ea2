//! Modal bodies: the reduction of finite elements, and what such bodies do in a scene.

mod reading;
mod reduction;
#[cfg(feature = "import")]
mod scene;
mod spinning;
mod sweeps;

use nalgebra::{DMatrix, Matrix3, Vector3};
use stillpoint::fem::{FiniteElements, Freedom, Interface, Symmetric, UnitLoad};

/// A straight beam along x of finite elements of Euler and Bernoulli (cubic bending, linear stretch and twist, consistent
/// masses).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Strip {
    pub(crate) length: f64,
    pub(crate) elements: usize,
    /// `EA`, `GJ`, `EI_y`, `EI_z`.
    pub(crate) stiffness: [f64; 4],
    pub(crate) mass_per_length: f64,
    /// Polar rotary inertia per length (kg m).
    pub(crate) polar: f64,
}

impl Strip {
    /// Length, mass and bending stiffness 1; stretch and twist much stiffer.
    pub(crate) fn unit(elements: usize) -> Self {
        Self { length: 1.0, elements, stiffness: [1e6, 10.0, 1.0, 1.0], mass_per_length: 1.0, polar: 1e-3 }
    }

    /// Stiffness and mass of one element, freedoms x, y, z, about x, y, z of both nodes.
    fn element(&self) -> [DMatrix<f64>; 2] {
        let h = self.length / self.elements as f64;
        let [ea, gj, iy, iz] = self.stiffness;
        let (mut k, mut m) = (DMatrix::zeros(12, 12), DMatrix::zeros(12, 12));
        for (at, stiff, heavy) in [(0, ea / h, self.mass_per_length * h), (3, gj / h, self.polar * h)] {
            for (i, j, s, c) in [(0, 0, 1.0, 2.0), (0, 6, -1.0, 1.0), (6, 0, -1.0, 1.0), (6, 6, 1.0, 2.0)] {
                k[(at + i, at + j)] += s * stiff;
                m[(at + i, at + j)] += c * heavy / 6.0;
            }
        }
        let bending =
            [[12.0, 6.0, -12.0, 6.0], [6.0, 4.0, -6.0, 2.0], [-12.0, -6.0, 12.0, -6.0], [6.0, 2.0, -6.0, 4.0]];
        let mass = [
            [156.0, 22.0, 54.0, -13.0],
            [22.0, 4.0, 13.0, -3.0],
            [54.0, 13.0, 156.0, -22.0],
            [-13.0, -3.0, -22.0, 4.0],
        ];
        // In the x–y plane the slope is the turn about z; in the x–z plane it is minus that about y.
        for (at, sign, ei) in [([1, 5, 7, 11], 1.0, iz), ([2, 4, 8, 10], -1.0, iy)] {
            for i in 0..4 {
                for j in 0..4 {
                    let size = |i: usize| if i % 2 == 1 { sign * h } else { 1.0 };
                    k[(at[i], at[j])] += ei / h.powi(3) * bending[i][j] * size(i) * size(j);
                    m[(at[i], at[j])] += self.mass_per_length * h / 420.0 * mass[i][j] * size(i) * size(j);
                }
            }
        }
        [k, m]
    }

    /// Geometric stiffness of one element with tension 1.
    fn tension(&self) -> DMatrix<f64> {
        let h = self.length / self.elements as f64;
        let mut k = DMatrix::zeros(12, 12);
        let bending =
            [[36.0, 3.0, -36.0, 3.0], [3.0, 4.0, -3.0, -1.0], [-36.0, -3.0, 36.0, -3.0], [3.0, -1.0, -3.0, 4.0]];
        for (at, sign) in [([1, 5, 7, 11], 1.0), ([2, 4, 8, 10], -1.0)] {
            for i in 0..4 {
                for j in 0..4 {
                    let size = |i: usize| if i % 2 == 1 { sign * h } else { 1.0 };
                    k[(at[i], at[j])] += bending[i][j] * size(i) * size(j) / (30.0 * h);
                }
            }
        }
        k
    }

    fn assembled(&self, n: usize, element: impl Fn(usize) -> DMatrix<f64>) -> Symmetric {
        let mut entries = Vec::new();
        for at in 0..self.elements {
            let of = element(at);
            entries.extend((0..144).map(|k| (6 * at + k / 12, 6 * at + k % 12, of[(k / 12, k % 12)])));
        }
        Symmetric::of("matrix", n, entries, |row| row.to_string()).expect("symmetric")
    }

    /// Interfaces at these nodes; the first is the root, the others are called by their number. With tension under spin, weight and
    /// forces along it, if it `stiffens`.
    pub(crate) fn model(&self, interfaces: &[usize], stiffens: bool) -> FiniteElements {
        let (h, n) = (self.length / self.elements as f64, 6 * (self.elements + 1));
        let [k, m] = self.element();
        let interface = |(index, node): (usize, &usize)| Interface {
            name: if index == 0 { "root".to_owned() } else { format!("p{index}") },
            point: Vector3::x() * (h * *node as f64),
            nodes: vec![*node],
        };
        let root = h * interfaces[0] as f64;
        let end = self.length - root;
        let mut geometric = Vec::new();
        if stiffens {
            // The root is the first node: the tension between two nodes is what pulls on what lies beyond them.
            let loaded = |load: UnitLoad, tension: &dyn Fn(f64) -> f64| {
                let of = |at: usize| self.tension() * tension((at as f64 + 0.5) * h - root);
                (load, self.assembled(n, of))
            };
            let mass = self.mass_per_length;
            geometric.push(loaded(UnitLoad::Acceleration(0), &|x| -mass * (end - x)));
            let spun = |x: f64| 0.5 * mass * (end * end - x * x - h * h / 12.0);
            geometric.push(loaded(UnitLoad::Centrifugal(1, 1), &spun));
            geometric.push(loaded(UnitLoad::Centrifugal(2, 2), &spun));
            for (index, node) in interfaces.iter().enumerate().skip(1) {
                let at = h * *node as f64 - root;
                geometric.push(loaded(UnitLoad::Force(index, 0), &|x| if x < at { 1.0 } else { 0.0 }));
            }
        }
        FiniteElements {
            nodes: (0..=self.elements).map(|node| Vector3::x() * (h * node as f64)).collect(),
            freedoms: (0..n).map(|row| Freedom { node: row / 6, direction: row % 6 }).collect(),
            mass: self.assembled(n, |_| m.clone()),
            stiffness: self.assembled(n, |_| k.clone()),
            interfaces: interfaces.iter().enumerate().map(interface).collect(),
            geometric,
            declared: Default::default(),
        }
    }
}

/// A lattice of point masses on springs, not in a plane: displacements alone, one mass per node.
pub(crate) fn lattice(masses: &[f64]) -> FiniteElements {
    let nodes: Vec<Vector3<f64>> = (0..masses.len())
        .map(|i| {
            let (layer, corner) = ((i / 3) as f64, i % 3);
            let angle = 2.1 * corner as f64 + 0.3 * layer;
            Vector3::new(0.4 * layer, 0.2 * angle.cos(), 0.2 * angle.sin())
        })
        .collect();
    let n = 3 * nodes.len();
    let (mut stiffness, mut mass) = (Vec::new(), Vec::new());
    for (i, a) in nodes.iter().enumerate() {
        mass.extend((0..3).map(|axis| (3 * i + axis, 3 * i + axis, masses[i])));
        for (j, b) in nodes.iter().enumerate().take(i).filter(|(_, b)| (a - *b).norm() < 0.7) {
            let direction = (a - b).normalize();
            let block: Matrix3<f64> = 4000.0 * direction * direction.transpose();
            for row in 0..3 {
                for column in 0..3 {
                    let x = block[(row, column)];
                    stiffness.push((3 * i + row, 3 * i + column, x));
                    stiffness.push((3 * j + row, 3 * j + column, x));
                    stiffness.push((3 * i + row, 3 * j + column, -x));
                    stiffness.push((3 * j + row, 3 * i + column, -x));
                }
            }
        }
    }
    let last = nodes.len() - 3;
    let middle = |first: usize| nodes[first..first + 3].iter().sum::<Vector3<f64>>() / 3.0;
    let interface = |name: &str, first: usize| Interface {
        name: name.to_owned(),
        point: middle(first),
        nodes: (first..first + 3).collect(),
    };
    let symmetric = |entries: Vec<_>| Symmetric::of("matrix", n, entries, |row| row.to_string()).expect("symmetric");
    FiniteElements {
        interfaces: vec![interface("root", 0), interface("p1", last)],
        freedoms: (0..n).map(|row| Freedom { node: row / 3, direction: row % 3 }).collect(),
        mass: symmetric(mass),
        stiffness: symmetric(stiffness),
        nodes,
        geometric: Vec::new(),
        declared: Default::default(),
    }
}
