//! Derivatives against central differences, and the two ways of reading the transfer equations against each other.

use crate::common::{Options, Random, build, position_of, preload, random_scene, relative_difference};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;
use stillpoint::dynamics::{AccelerationJacobians, System};
use stillpoint::force::Act;
use stillpoint::model::Model;
use stillpoint::model::description::{
    BodyDescription, Bushing, Description, ForceKind, GROUND, HingeDescription, HingeKind, MassProperties, Point,
    Spring,
};

fn scenes() -> impl Iterator<Item = (u64, Options)> {
    (0..60).map(|seed| (seed, Options { bodies: 1 + (seed as usize * 7) % 13, springs: seed % 3 != 0, welds: true }))
}

/// The accelerations of the reduction satisfy the inverse dynamics.
#[test]
fn accelerations_balance_the_forces() {
    for (seed, options) in scenes() {
        let model = build(&random_scene(seed, &options));
        let (q, v) = (&model.start_position, &model.start_velocity);
        let (mut a, mut residual) = (v.clone(), v.clone());
        let mut system = System::new(&model);
        system.at(0.0, q, v).accelerations(&mut a).unwrap();
        let zero = vec![0.0; a.len()];
        let mut loads = zero.clone();
        system.at(0.0, q, v).residual(&zero, &mut loads).unwrap();
        system.at(0.0, q, v).residual(&a, &mut residual).unwrap();
        // Round-off of two sweeps over at most thirteen bodies, conditioned like their mass matrix.
        let scale = loads.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
        let worst = residual.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        assert!(worst < 1e-10 * scale, "seed {seed}: {worst} of {scale}");
    }
}

/// Central differences of `f(q, v)` along every velocity coordinate; `of_position` picks what is varied.
pub(crate) fn difference(
    model: &Model,
    of_position: bool,
    j: usize,
    mut f: impl FnMut(&[f64], &[f64]) -> Vec<f64>,
) -> Vec<f64> {
    let step = 1e-5;
    let mut at = |sign: f64| {
        let (mut q, mut v) = (model.start_position.clone(), model.start_velocity.clone());
        let mut by = vec![0.0; v.len()];
        by[j] = sign * step;
        if of_position {
            System::displace(model, &mut q, &by);
        } else {
            v[j] += by[j];
        }
        f(&q, &v)
    };
    let (plus, minus) = (at(1.0), at(-1.0));
    plus.iter().zip(&minus).map(|(p, m)| (p - m) / (2.0 * step)).collect()
}

/// Stiffness and damping matrices are the derivatives of the residual. Differences err by step² and round-off/step:
/// both near 1e-9 of the largest entry; 1e-6 leaves room for the worst scene.
#[test]
fn linearization_matches_central_differences() {
    for (seed, options) in scenes() {
        let mut description = random_scene(seed, &options);
        preload(&mut description);
        let model = build(&description);
        let n = model.velocity_count();
        let mut random = Random::new(seed + 1000);
        let a = random.list(n, -3.0, 3.0);
        let mut system = System::new(&model);
        let found = system.at(0.0, &model.start_position, &model.start_velocity).linearize(&a).unwrap();
        let scale = found.stiffness.norm_max().max(found.damping.norm_max());
        for j in 0..n {
            for (of_position, matrix) in [(true, &found.stiffness), (false, &found.damping)] {
                let expected = difference(&model, of_position, j, |q, v| {
                    let mut residual = vec![0.0; n];
                    system.at(0.0, q, v).residual(&a, &mut residual).unwrap();
                    residual
                });
                for i in 0..n {
                    let error = (matrix[(i, j)] - expected[i]).abs() / scale;
                    assert!(error < 1e-6, "seed {seed} ({i}, {j}) position {of_position}: {error}");
                }
            }
        }
    }
}

/// The Jacobians of the accelerations, by differentiated transfer equations, against central differences.
#[test]
fn acceleration_jacobians_match_central_differences() {
    for (seed, options) in scenes() {
        let model = build(&random_scene(seed, &options));
        let n = model.velocity_count();
        let mut system = System::new(&model);
        let (by_position, by_velocity) =
            system.at(0.0, &model.start_position, &model.start_velocity).acceleration_jacobians().unwrap();
        for (of_position, matrix) in [(true, by_position), (false, by_velocity)] {
            let (mut found, mut expected) = (Vec::new(), Vec::new());
            for j in 0..n {
                found.extend((0..n).map(|i| matrix[(i, j)]));
                expected.extend(difference(&model, of_position, j, |q, v| {
                    let mut a = vec![0.0; n];
                    system.at(0.0, q, v).accelerations(&mut a).unwrap();
                    a
                }));
            }
            let error = relative_difference(&found, &expected);
            assert!(error < 1e-6, "seed {seed} position {of_position}: {error}");
        }
    }
}

/// `−M⁻¹ K` and `−M⁻¹ C` from the dense derivatives at the true accelerations.
fn jacobians_by_columns(model: &Arc<Model>, q: &[f64], v: &[f64]) -> [Vec<f64>; 2] {
    let n = model.velocity_count();
    let mut system = System::new(model);
    let mut a = vec![0.0; n];
    let mut at = system.at(0.0, q, v);
    at.accelerations(&mut a).unwrap();
    let dense = at.linearize(&a).unwrap();
    let mut mass = at.accelerations(&mut a).unwrap();
    [dense.stiffness, dense.damping].map(|matrix| {
        let column = |j: usize| {
            let (rhs, mut x) = ((0..n).map(|i| -matrix[(i, j)]).collect::<Vec<_>>(), vec![0.0; n]);
            mass.solve_mass(&rhs, &mut x);
            x
        };
        (0..n).flat_map(column).collect()
    })
}

fn flat(matrix: &faer::Mat<f64>) -> Vec<f64> {
    (0..matrix.ncols()).flat_map(|j| (0..matrix.nrows()).map(move |i| matrix[(i, j)])).collect()
}

/// All columns side by side, in scenes without force elements, against the dense derivatives column by column: with and
/// without hinge springs, dampers and armatures, moving and at rest, from one body to forests of forty.
#[test]
fn jacobians_by_sweeps_are_those_by_columns() {
    for seed in 0..80 {
        let bodies = if seed % 8 == 0 { 40 } else { 1 + (seed as usize * 7) % 13 };
        let mut description = random_scene(seed, &Options { bodies, springs: seed % 3 != 0, welds: true });
        description.forces.clear();
        let model = build(&description);
        let (q, rest) = (&model.start_position, vec![0.0; model.velocity_count()]);
        let mut jacobians = AccelerationJacobians::new(&model);
        for v in [&model.start_velocity, &rest] {
            let expected = jacobians_by_columns(&model, q, v);
            System::new(&model).at(0.0, q, v).acceleration_jacobians_into(&mut jacobians).unwrap();
            for (found, expected) in [&jacobians.by_position, &jacobians.by_velocity].into_iter().zip(expected) {
                let error = relative_difference(&flat(found), &expected);
                // Round-off of both ways, conditioned like the mass matrices of up to some sixty coordinates.
                assert!(error < 1e-10, "seed {seed}: {error}");
            }
        }
    }
}

/// Forty slender bodies on balls: one step of refinement, whose residual comes from the tangent's action and not from a
/// matrix, finds next to nothing to correct.
#[test]
fn jacobians_of_long_chains_keep_their_digits() {
    use stillpoint::motion::variation::Direction;
    use stillpoint::transfer::balance::Balance;
    use stillpoint::transfer::jacobian::{Jacobian, TOGETHER};
    use stillpoint::transfer::reduce::{Load, Reduction};
    use stillpoint::transfer::variation::Variation;
    const SLENDERNESS: f64 = 1e-4;
    let mut random = Random::new(5);
    let mut bodies: Vec<BodyDescription> = Vec::new();
    for index in 0..40 {
        let mut hinge = HingeDescription::new(HingeKind::Spherical);
        hinge.position = position_of(&mut random, &hinge.kind);
        hinge.velocity = random.list(3, -1.0, 1.0);
        if let Some(before) = bodies.last() {
            hinge.parent.clone_from(&before.name);
            hinge.at = Point::At(Vector3::new(0.0, 0.0, -0.2));
        }
        let inertia = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, SLENDERNESS)) / 300.0;
        let mass = MassProperties { mass: 1.0, center: Vector3::new(0.0, 0.0, -0.1), inertia };
        bodies.push(BodyDescription { name: format!("b{index}"), mass, markers: vec![], shapes: vec![], hinge });
    }
    let model = build(&Description { bodies, gravity: Vector3::new(0.0, 0.0, -9.81), ..Description::default() });
    let n = model.velocity_count();
    let (q, v, none) = (&model.start_position, &model.start_velocity, vec![0.0; n]);
    let (mut a, mut residual) = (none.clone(), none.clone());
    let mut motion = stillpoint::motion::Motion::new(&model);
    motion.update(&model, q, v);
    let (mut reduction, mut balance) = (Reduction::new(&model), Balance::new(&model));
    reduction.accelerations(&model, &motion, &Load { applied: &[], tau: &none }, &mut a).unwrap();
    let applied = vec![stillpoint::spatial::Wrench::ZERO; model.links.len()];
    balance.update(&model, &motion, &applied, &none, &a, &mut residual);
    let mut jacobian = Jacobian::new(&model);
    jacobian.update(&model, &motion, &balance, |_| None).unwrap();
    let mut variation = Variation::new(&model);
    for (way, name) in ["position", "velocity"].into_iter().enumerate() {
        let (mut largest, mut worst) = (0.0_f64, 0.0_f64);
        for j in 0..n {
            let first = j - j % TOGETHER;
            let (touched, rows) = jacobian.columns(first);
            assert_eq!(touched, 0..n);
            let x: Vec<f64> = rows.iter().map(|row| row[way * TOGETHER + j - first]).collect();
            let mut unit = none.clone();
            unit[j] = 1.0;
            let by = match way {
                0 => Direction { position: &unit, acceleration: &x, ..Direction::default() },
                _ => Direction { velocity: &unit, acceleration: &x, ..Direction::default() },
            };
            variation.outward(&model, &motion, &balance, &a, &by);
            variation.inward(&model, &motion, &balance, &by, &mut residual);
            let mut correction = none.clone();
            reduction.solve(&model, &motion, &Load { applied: &[], tau: &residual }, &mut correction);
            largest = x.iter().fold(largest, |m, x| m.max(x.abs()));
            worst = correction.iter().fold(worst, |m, x| m.max(x.abs()));
        }
        // The digits that a slender body's smallest moment keeps in inertial axes, less those of sums along the chain.
        assert!(worst < 100.0 * f64::EPSILON / SLENDERNESS * largest, "by {name}: {}", worst / largest);
        assert!(worst > 0.0);
    }
}

/// A scene that flies as a whole has the same Jacobians to the last digits: only relative velocities enter.
#[test]
fn jacobians_do_not_depend_on_a_common_velocity() {
    let mut description = random_scene(3, &Options { bodies: 6, springs: true, welds: false });
    description.forces.clear();
    description.bodies[0].hinge = HingeDescription::new(HingeKind::Free);
    description.bodies[0].hinge.velocity = vec![0.3, -0.2, 0.1, 1.0, -0.5, 0.7];
    for body in &mut description.bodies[1..] {
        if body.hinge.parent == GROUND {
            body.hinge.parent = "b0".to_owned();
        }
    }
    let slow = build(&description);
    for (speed, velocity) in [7e3, -5e3, 2e3].iter().zip(&mut description.bodies[0].hinge.velocity) {
        *velocity += speed;
    }
    let fast = build(&description);
    let jacobians = |model: &Arc<Model>| {
        let found =
            System::new(model).at(0.0, &model.start_position, &model.start_velocity).acceleration_jacobians().unwrap();
        [flat(&found.0), flat(&found.1)]
    };
    for (slow, fast) in jacobians(&slow).iter().zip(&jacobians(&fast)) {
        let error = relative_difference(fast, slow);
        // The relative velocities themselves lose four digits.
        assert!(error < 1e-11, "{error}");
    }
}

/// The tangent sweep solves with the matrix that the dense derivatives make up, in both of its uses: static, and of an
/// implicit step with velocities and accelerations.
#[test]
fn tangent_sweep_solves_the_dense_tangent() {
    use faer::linalg::solvers::Solve;
    use stillpoint::dynamics::{Coefficients, TangentSolver};
    let (mut coupled, mut far) = (0, 0);
    let both = |(seed, options)| [(seed, random_scene(seed, &options)), (seed, neighbourly(seed, &options))];
    for (seed, description) in scenes().flat_map(both) {
        let model = build(&description);
        let between = model.forces.iter().filter(|force| force.law.ends().iter().all(|end| end.link != 0)).count();
        if TangentSolver::covers(&model) {
            coupled += between;
        } else {
            far += between;
        }
        let n = model.velocity_count();
        let mut random = Random::new(seed + 2000);
        let (a, rhs) = (random.list(n, -3.0, 3.0), random.list(n, -1.0, 1.0));
        let mut system = System::new(&model);
        let mut solver = TangentSolver::new(&model);
        let zero = vec![0.0; n];
        let (q, v) = (&model.start_position, &model.start_velocity);
        let cases = [(&zero, &zero, 0.0, 0.0, 5.0), (&zero, &zero, 0.0, 7.0, 0.0), (v, &a, 20.0, 400.0, 0.0)];
        for (v, a, c1, c2, shift) in cases {
            let dense = system.at(0.0, q, v).linearize(a).unwrap();
            let mut matrix = &dense.stiffness + &dense.damping * c1 + &dense.mass * c2;
            (0..n).for_each(|i| matrix[(i, i)] += shift);
            let b = faer::Mat::from_fn(n, 1, |i, _| rhs[i]);
            let expected: Vec<f64> = {
                let x = matrix.partial_piv_lu().solve(&b);
                (0..n).map(|i| x[(i, 0)]).collect()
            };
            let shift = vec![shift; n];
            let with = Coefficients { c1, c2, shift: &shift, ..Coefficients::default() };
            assert!(system.at(0.0, q, v).factorize_tangent(&mut solver, a, &with).unwrap(), "seed {seed}");
            let mut x = rhs.clone();
            solver.solve(&mut x);
            let error = relative_difference(&x, &expected);
            // Elimination without pivoting in an indefinite matrix of up to some sixty rows loses digits.
            assert!(error < 1e-6, "seed {seed} c1 {c1} c2 {c2}: {error}");
        }
    }
    assert!(coupled > 50 && far > 50, "only {coupled} and {far} force elements between bodies");
}

/// A random scene whose forces between bodies are between a body and its parent, some of them two.
fn neighbourly(seed: u64, options: &Options) -> Description {
    let mut description = random_scene(seed, options);
    let parents: Vec<String> = description.bodies.iter().map(|body| body.hinge.parent.clone()).collect();
    let names: Vec<String> = description.bodies.iter().map(|body| body.name.clone()).collect();
    for (index, force) in description.forces.iter_mut().enumerate() {
        if let ForceKind::Spring(Spring { between, .. }) | ForceKind::Bushing(Bushing { between, .. }) = &mut force.kind
        {
            let child = (index / 2) % names.len();
            let order = [index % 2, 1 - index % 2];
            between[order[0]].body.clone_from(&names[child]);
            between[order[1]].body.clone_from(&parents[child]);
            between.iter_mut().filter(|end| end.body == "ground").for_each(|end| end.point = Point::At(Vector3::x()));
        }
    }
    description
}

/// The symmetric tangent of statics is the symmetric part of the stiffness, away from equilibrium too; with it the
/// count of negative pivots is that of negative eigenvalues (Sylvester).
#[test]
fn symmetric_tangent_counts_negative_eigenvalues() {
    use stillpoint::dynamics::{Coefficients, TangentSolver};
    for (seed, options) in scenes() {
        let mut description = neighbourly(seed, &options);
        description.forces.retain(|force| matches!(force.kind, ForceKind::Spring(_)));
        let model = build(&description);
        if !TangentSolver::covers(&model) {
            continue;
        }
        let n = model.velocity_count();
        let zero = vec![0.0; n];
        let mut system = System::new(&model);
        let mut solver = TangentSolver::new(&model);
        let q = &model.start_position;
        let full = system.at(0.0, q, &zero).stiffness().unwrap();
        // A shift of random signs in place of free motions that cost nothing.
        let mut random = Random::new(seed + 3000);
        let shift = random.list(n, -10.0, 10.0);
        let symmetric =
            faer::Mat::from_fn(n, n, |i, j| 0.5 * (full[(i, j)] + full[(j, i)]) + if i == j { shift[i] } else { 0.0 });
        let values = symmetric.self_adjoint_eigenvalues(faer::Side::Lower).unwrap();
        let negative = values.iter().filter(|x| **x < 0.0).count();
        let with = Coefficients { shift: &shift, symmetric: true, ..Coefficients::default() };
        assert!(system.at(0.0, q, &zero).factorize_tangent(&mut solver, &zero, &with).unwrap());
        assert_eq!(solver.negatives(), Some(negative), "seed {seed}");
        // And where it is not definite, the direction that says so is one of negative curvature.
        let with = Coefficients { definite: true, ..with };
        if let Err(breakdown) = system.factorize_shifted(&mut solver, &zero, &with) {
            let mut x = zero.clone();
            solver.negative_direction(&model, breakdown, &mut x);
            let curvature: f64 = (0..n).map(|i| (0..n).map(|j| x[i] * symmetric[(i, j)] * x[j]).sum::<f64>()).sum();
            assert!(curvature < 0.0, "seed {seed}: {curvature}");
        } else {
            assert_eq!(negative, 0, "seed {seed}");
        }
    }
}

/// The action of the mass matrix is that of the dense one, column by column the same tree.
#[test]
fn mass_action_is_that_of_the_dense_matrix() {
    use stillpoint::dynamics::MassAction;
    for (seed, options) in scenes() {
        let model = build(&random_scene(seed, &options));
        let n = model.velocity_count();
        let (x, rest) = (Random::new(seed + 4000).list(n, -1.0, 1.0), vec![0.0; n]);
        let mut system = System::new(&model);
        let mut at = system.at(0.0, &model.start_position, &rest);
        let mass = at.linearize(&rest).unwrap().mass;
        let expected: Vec<f64> = (0..n).map(|i| (0..n).map(|j| mass[(i, j)] * x[j]).sum()).collect();
        let mut product = rest.clone();
        at.mass_times(&mut MassAction::new(&model), &x, &mut product);
        // Round-off of sums over thirteen bodies.
        assert!(relative_difference(&product, &expected) < 1e-13, "seed {seed}");
    }
}
