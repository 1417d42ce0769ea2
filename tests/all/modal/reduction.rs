//! The reduction against closed forms and against the finite elements themselves.

use super::{Strip, lattice};
use nalgebra::{DMatrix, SymmetricEigen, Vector3};
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::fem::ModalDamping;
use stillpoint::model::Model;
use stillpoint::model::description::{BodyDescription, Description, HingeDescription};

/// A modal body on a hinge.
pub(super) fn scene(hinge: HingeDescription, modal: stillpoint::element::modal::Modal) -> Arc<Model> {
    let description = Description::new("Modal").body(BodyDescription::new("arm", hinge)).modal("arm", modal);
    Model::build(&description).expect("a sound scene")
}

/// ω of `K x = ω² M x` of a scene at a place and a velocity, ascending; of some coordinates.
pub(super) fn frequencies(model: &Arc<Model>, q: &[f64], v: &[f64], of: &[usize]) -> Vec<f64> {
    let mut system = System::new(model);
    let linear = system.at(0.0, q, v).linearize(&vec![0.0; v.len()]).expect("finite");
    let part = |matrix: &dyn Fn(usize, usize) -> f64| DMatrix::from_fn(of.len(), of.len(), |i, j| matrix(of[i], of[j]));
    let (k, m) = (part(&|i, j| linear.stiffness[(i, j)]), part(&|i, j| linear.mass[(i, j)]));
    let lower = m.cholesky().expect("definite").l();
    let half = lower.solve_lower_triangular(&k).expect("regular");
    let whole = lower.solve_lower_triangular(&half.transpose()).expect("regular");
    let mut squares: Vec<f64> =
        SymmetricEigen::new(0.5 * (&whole + whole.transpose())).eigenvalues.iter().copied().collect();
    squares.sort_by(f64::total_cmp);
    squares.into_iter().map(|x| x.signum() * x.abs().sqrt()).collect()
}

/// The lowest frequency of a cantilever of 20 elements whose tip is an interface, with 0 … 3 inner modes in each plane, against
/// the root of cos x cosh x = −1: the errors of a Craig–Bampton basis computed by dense matrices (SciPy) are 4.8e-3, 3.5e-4, 5.8e-5
/// and 1.6e-5.
#[test]
fn inner_modes_bring_a_cantilever_to_its_frequency() {
    let exact = 3.516_015_268_5;
    let model = Strip::unit(20).model(&[0, 20], false);
    for (modes, expected) in [4.8e-3, 3.5e-4, 5.8e-5, 1.6e-5].into_iter().enumerate() {
        let modal = model.reduce(2 * modes, ModalDamping::None).expect("sound");
        let scene = scene(HingeDescription::fixed(), modal);
        let n = scene.velocity_count();
        assert_eq!(n, 6 + 2 * modes);
        let all: Vec<usize> = (0..n).collect();
        let error = frequencies(&scene, &vec![0.0; n], &vec![0.0; n], &all)[0] / exact - 1.0;
        // Two digits are known.
        assert!((error / expected - 1.0).abs() < 0.03, "{modes} modes: {error:.2e}, expected {expected:.1e}");
    }
}

/// With every inner mode nothing is left out: the frequencies are those of the finite elements, lowest and highest.
#[test]
fn with_all_modes_the_frequencies_are_those_of_the_elements() {
    let strip = Strip { stiffness: [50.0, 10.0, 1.0, 3.0], polar: 0.05, ..Strip::unit(4) };
    let model = strip.model(&[0, 2, 4], false);
    let modal = model.reduce(12, ModalDamping::None).expect("sound");
    let scene = scene(HingeDescription::fixed(), modal);
    let all: Vec<usize> = (0..24).collect();
    let found = frequencies(&scene, &[0.0; 24], &[0.0; 24], &all);
    let dense = |matrix: &stillpoint::fem::Symmetric| {
        let mut full = DMatrix::zeros(30, 30);
        for (i, j, x) in matrix.entries() {
            (full[(i, j)], full[(j, i)]) = (x, x);
        }
        full.view((6, 6), (24, 24)).into_owned()
    };
    let (k, m) = (dense(&model.stiffness), dense(&model.mass));
    let squares = (m.try_inverse().expect("regular") * k).complex_eigenvalues();
    let mut expected: Vec<f64> = squares.iter().map(|x| x.re.sqrt()).collect();
    expected.sort_by(f64::total_cmp);
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found / expected - 1.0).abs() < 1e-8, "{found} {expected}");
    }
}

/// Mass, centre and inertia of a body at rest in its file are those of its nodes.
#[test]
fn a_stiff_lattice_is_the_rigid_body_of_its_masses() {
    let masses = [0.4, 0.5, 0.3, 0.7, 0.2, 0.6, 0.9, 0.4, 0.5];
    let model = lattice(&masses);
    let modal = model.reduce(0, ModalDamping::None).expect("sound");
    let total: f64 = masses.iter().sum();
    let root = model.interfaces[0].point;
    let first: Vector3<f64> = model.nodes.iter().zip(masses).map(|(at, m)| m * (at - root)).sum();
    let moment = |axis: Vector3<f64>| -> f64 {
        model.nodes.iter().zip(masses).map(|(at, m)| m * axis.cross(&(at - root)).norm_squared()).sum()
    };
    assert!((modal.mass - total).abs() < 1e-14 && (modal.first.0 - first).norm() < 1e-14);
    for axis in [Vector3::x(), Vector3::y(), Vector3::new(0.6, 0.0, 0.8)] {
        assert!((axis.dot(&(modal.inertia.0 * axis)) - moment(axis)).abs() < 1e-14);
    }
}

/// The kinetic energy of a body that bends, turns and flies is the sum over its point masses, whose velocities are differences of
/// their places.
#[test]
fn the_kinetic_energy_is_that_of_the_masses() {
    let masses = [0.4, 0.5, 0.3, 0.7, 0.2, 0.6, 0.9, 0.4, 0.5];
    let model = lattice(&masses);
    let modal = model.reduce(3, ModalDamping::None).expect("sound");
    // With three modes and no more than nine coordinates every mass moves as its own column of the basis says.
    let shapes = shapes(&model, 3);
    let scene = scene(HingeDescription::free(), modal);
    let mut random = crate::common::Random::new(5);
    let n = scene.velocity_count();
    for _ in 0..20 {
        let by: Vec<f64> =
            (0..n).map(|i| if i < 6 { random.between(-1.0, 1.0) } else { random.between(-0.05, 0.05) }).collect();
        let v = random.list(n, -1.0, 1.0);
        let mut q = scene.start_position.clone();
        System::displace(&scene, &mut q, &by);
        let mut system = System::new(&scene);
        let mut places = |t: f64| -> Vec<Vector3<f64>> {
            let mut moved = q.clone();
            let step: Vec<f64> = v.iter().map(|v| t * v).collect();
            System::displace(&scene, &mut moved, &step);
            let at = system.at(0.0, &moved, &v);
            let frame = &at.motion().links[scene.modals[0].link];
            let root = model.interfaces[0].point;
            let coordinates = &moved[scene.links[scene.modals[0].link].position..];
            let place = |(node, at): (usize, &Vector3<f64>)| {
                let bent: Vector3<f64> = (0..9).map(|i| coordinates[i] * shapes[i][node]).sum();
                frame.position + frame.turn * (at - root + bent)
            };
            model.nodes.iter().enumerate().map(place).collect()
        };
        let h = 1e-3;
        let [a, b, c, d] = [-2.0 * h, -h, h, 2.0 * h].map(&mut places);
        let velocity = |node: usize| (8.0 * (c[node] - b[node]) - (d[node] - a[node])) / (12.0 * h);
        let expected: f64 = (0..masses.len()).map(|node| 0.5 * masses[node] * velocity(node).norm_squared()).sum();
        let found = system.at(0.0, &q, &v).energies().kinetic;
        // Differences of fourth order with steps of 1e-3.
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }
}

/// Displacements of the nodes for a unit of each coordinate: statics of the lattice by dense matrices for the interface, the
/// modes by the eigenvectors of those.
fn shapes(model: &stillpoint::fem::FiniteElements, modes: usize) -> Vec<Vec<Vector3<f64>>> {
    let (n, inner) = (27, 9..18);
    let mut k = DMatrix::zeros(n, n);
    for (i, j, x) in model.stiffness.entries() {
        (k[(i, j)], k[(j, i)]) = (x, x);
    }
    let mut m = DMatrix::zeros(n, n);
    model.mass.entries().for_each(|(i, j, x)| m[(i, j)] = x);
    let part = |matrix: &DMatrix<f64>| matrix.view((inner.start, inner.start), (9, 9)).into_owned();
    let point = model.interfaces[1].point;
    let mut columns = Vec::new();
    for motion in 0..6 {
        let mut u = nalgebra::DVector::zeros(n);
        for node in 6..9 {
            let unit = Vector3::ith(motion % 3, 1.0);
            let shift = if motion < 3 { unit } else { unit.cross(&(model.nodes[node] - point)) };
            (0..3).for_each(|axis| u[3 * node + axis] = shift[axis]);
        }
        let force = &k * &u;
        let follows = part(&k).lu().solve(&(-force.rows(9, 9).into_owned())).expect("regular");
        u.rows_mut(9, 9).copy_from(&follows);
        columns.push(u);
    }
    let root = part(&m).map(|x| if x > 0.0 { 1.0 / x.sqrt() } else { 0.0 });
    let eigen = SymmetricEigen::new(&root * part(&k) * &root);
    let mut order: Vec<usize> = (0..9).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    for mode in order.into_iter().take(modes) {
        let mut u = nalgebra::DVector::zeros(n);
        let shape = &root * eigen.eigenvectors.column(mode);
        let largest = shape.iter().fold(0.0_f64, |most, x| if x.abs() > most.abs() { *x } else { most });
        u.rows_mut(9, 9).copy_from(&(shape / largest));
        columns.push(u);
    }
    let nodes = |u: &nalgebra::DVector<f64>| {
        (0..9).map(|node| Vector3::new(u[3 * node], u[3 * node + 1], u[3 * node + 2])).collect()
    };
    columns.iter().map(nodes).collect()
}

/// Every mode of the body has the given part of its critical damping: with its root held, `ẍ + 2 ζ ω ẋ + ω² x` in each.
#[test]
fn a_ratio_damps_every_mode_alike() {
    let model = Strip::unit(8).model(&[0, 8], false);
    let modal = model.reduce(4, ModalDamping::Ratio(0.03)).expect("sound");
    let m = modal.count();
    let matrix = |list: &[f64]| DMatrix::from_fn(m, m, |i, j| list[i * m + j]);
    let (p, k, d) = (matrix(&modal.mass_matrix), matrix(&modal.stiffness), matrix(&modal.damping));
    // Of D = 2 ζ P √(P⁻¹K) the product D P⁻¹ D is 4 ζ² K.
    let product = &d * p.try_inverse().expect("regular") * &d;
    assert!((&product - 4.0 * 0.03 * 0.03 * &k).amax() < 1e-9 * k.amax());
}
