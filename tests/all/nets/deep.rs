//! Deep trees with elements between distant links: the links' motions are unknowns beside the coordinates.

use super::is_sparse;
use crate::common::{Random, build, relative_difference};
use faer::Mat;
use faer::linalg::solvers::Solve;
use stillpoint::dynamics::{Coefficients, System, TangentSolver};
use stillpoint::model::couplings::{Closure, LoopDescription};
use stillpoint::model::description::*;

/// A chain of hinges of every kind with springs between any two of its links, and rods, of which the longest ways around are as long
/// as the chain.
fn chain(seed: u64, links: usize, springs: usize, rods: usize) -> Description {
    let mut random = Random::new(seed + 81_000);
    let mut scene = Description::new("");
    // Where the links are in the positions given, all of them zero.
    let mut places = vec![nalgebra::Vector3::zeros()];
    for index in 0..links {
        let axis = random.vector(1.0).normalize();
        let hinge = match random.below(6) {
            0 => HingeDescription::prismatic(axis).stiffness([random.between(50.0, 500.0)]),
            1 => HingeDescription::spherical().stiffness([0; 3].map(|_| random.between(1.0, 10.0))),
            2 => HingeDescription::screw(axis, random.between(-0.2, 0.2)).stiffness([random.between(1.0, 10.0)]),
            3 => HingeDescription::fixed(),
            _ => HingeDescription::revolute(axis).stiffness([random.between(1.0, 10.0)]),
        };
        let hinge = match index {
            0 => hinge,
            _ => {
                let at = nalgebra::Vector3::new(0.1, random.between(-0.1, 0.1), random.between(-0.1, 0.1));
                places.push(places[index - 1] + at);
                hinge.on(&format!("link{}", index - 1), [at.x, at.y, at.z])
            }
        };
        let body = BodyDescription::new(&format!("link{index}"), hinge).mass(random.between(0.01, 0.1));
        scene = scene.body(body.center(random.vector(0.05)).inertia([1e-4; 3]));
    }
    let end = |index: usize, point| Attachment { body: format!("link{index}"), point: Point::At(point) };
    for index in 0..springs + rods {
        let a = random.below(links);
        let b = (a + 1 + random.below(links - 1)) % links;
        let points = [random.vector(0.05), random.vector(0.05)];
        let between = [end(a, points[0]), end(b, points[1])];
        let length = (places[b] + points[1] - places[a] - points[0]).norm();
        if index < springs {
            let (stiffness, damping) = (random.between(1.0, 50.0), 0.0);
            let length = random.between(0.5, 1.5) * length;
            let kind = Spring { between, stiffness, length, damping }.into();
            scene = scene.force(ForceDescription { name: format!("far{index}"), kind });
        } else {
            let closure = Closure::Rod { length };
            let (frame, second_frame) = (nalgebra::UnitQuaternion::identity(), None);
            scene =
                scene.closure(LoopDescription { name: format!("rod{index}"), closure, between, frame, second_frame });
        }
    }
    scene
}

/// Where it is definite the solution is that of the dense matrix, with coordinates that are held, too.
#[test]
fn twists_solve_the_dense_tangent_of_deep_trees() {
    for seed in 0..6 {
        let model = build(&chain(seed, 200, 90, 0));
        assert!(is_sparse(&model), "seed {seed}");
        let n = model.velocity_count();
        let mut random = Random::new(seed + 82_000);
        let (zero, rhs) = (vec![0.0; n], random.list(n, -1.0, 1.0));
        let (mut system, mut solver) = (System::new(&model), TangentSolver::new(&model));
        let q = &model.start_position;
        for c2 in [0.0, 30.0] {
            let dense = system.at(0.0, q, &zero).linearize(&zero).unwrap();
            let whole = &dense.stiffness + &dense.mass * c2;
            let mut shift = vec![0.0; n];
            for link in (1..model.links.len()).filter(|_| random.below(9) == 0) {
                let (first, count) = (model.links[link].velocity, model.links[link].joint.counts().1);
                shift[first..first + count].fill(f64::INFINITY);
            }
            let free: Vec<usize> = (0..n).filter(|i| shift[*i] == 0.0).collect();
            let lowest = {
                let entry = |i: usize, j: usize| 0.5 * (whole[(free[i], free[j])] + whole[(free[j], free[i])]);
                let matrix = Mat::from_fn(free.len(), free.len(), entry);
                matrix.self_adjoint_eigenvalues(faer::Side::Lower).unwrap()[0]
            };
            for above in [-1.0, 1.0] {
                // By more than hinges give.
                free.iter().for_each(|i| shift[*i] = 0.1 * above * (lowest.abs() + 10.0) - lowest);
                let with =
                    Coefficients { c2, shift: &shift, symmetric: true, definite: true, ..Coefficients::default() };
                let definite = system.at(0.0, q, &zero).factorize_tangent(&mut solver, &zero, &with).unwrap();
                assert_eq!(definite, above > 0.0, "seed {seed} c2 {c2}");
                if !definite {
                    continue;
                }
                assert!(solver.is_by_twists() && solver.negatives() == Some(0), "seed {seed} c2 {c2}");
                let entry = |i: usize, j: usize| {
                    let (a, b) = (free[i], free[j]);
                    0.5 * (whole[(a, b)] + whole[(b, a)]) + if i == j { shift[a] } else { 0.0 }
                };
                let matrix = Mat::from_fn(free.len(), free.len(), entry);
                let b = Mat::from_fn(free.len(), 1, |i, _| rhs[free[i]]);
                let expected = matrix.partial_piv_lu().solve(&b);
                let mut x = rhs.clone();
                solver.solve(&mut x);
                let mut sought = zero.clone();
                free.iter().enumerate().for_each(|(row, i)| sought[*i] = expected[(row, 0)]);
                let error = relative_difference(&x, &sought);
                // Both lose the digits of the condition, up to 10⁸ of a chain of 200 links; a wrong block is off by parts of one.
                assert!(error < 1e-7, "seed {seed} c2 {c2}: {error}");
            }
        }
    }
}

/// Beside rows, given twice over: on what they leave, the solution is that of the dense matrix with one of each.
#[test]
fn twists_hold_rows_that_depend() {
    for seed in 0..6 {
        let model = build(&chain(seed + 50, 150, 60, 12));
        let n = model.velocity_count();
        let mut random = Random::new(seed + 83_000);
        let (zero, rhs) = (vec![0.0; n], random.list(n, -1.0, 1.0));
        let (mut system, mut solver) = (System::new(&model), TangentSolver::new(&model));
        let q = &model.start_position;
        let (rows, pulls) = {
            let mut here = system.at(0.0, q, &zero);
            here.residual(&zero, &mut zero.clone()).unwrap();
            here.constraint_rows_and_pulls()
        };
        assert_eq!((rows.len(), pulls.len()), (12, 12));
        let dense = system.at(0.0, q, &zero).linearize(&zero).unwrap().stiffness;
        let symmetric = Mat::from_fn(n, n, |i, j| 0.5 * (dense[(i, j)] + dense[(j, i)]));
        let lowest = symmetric.self_adjoint_eigenvalues(faer::Side::Lower).unwrap()[0];
        let shift = vec![0.1 * (lowest.abs() + 10.0) - lowest; n];
        let entry = |i: usize, j: usize| symmetric[(i, j)] + if i == j { shift[i] } else { 0.0 };
        let mut whole = Mat::<f64>::zeros(n + rows.len(), n + rows.len());
        (0..n).for_each(|i| (0..n).for_each(|j| whole[(i, j)] = entry(i, j)));
        for row in 0..rows.len() {
            rows.row(row).for_each(|(j, value)| (whole[(n + row, j)], whole[(j, n + row)]) = (value, value));
        }
        let b = Mat::from_fn(n + rows.len(), 1, |i, _| rhs.get(i).copied().unwrap_or(0.0));
        let expected = whole.partial_piv_lu().solve(&b);
        // Each of them twice.
        let mut twice = rows.clone();
        for row in 0..rows.len() {
            twice.columns.extend(rows.row(row).map(|entry| entry.0));
            twice.values.extend(rows.row(row).map(|entry| entry.1));
            twice.starts.push(twice.columns.len());
        }
        let pulls = [pulls.clone(), pulls].concat();
        solver.set_rows(&twice, &pulls);
        let with = Coefficients { shift: &shift, symmetric: true, definite: true, ..Coefficients::default() };
        assert!(system.at(0.0, q, &zero).factorize_tangent(&mut solver, &zero, &with).unwrap(), "seed {seed}");
        assert!(solver.is_by_twists(), "seed {seed}");
        let mut x = rhs.clone();
        solver.solve(&mut x);
        let sought: Vec<f64> = (0..n).map(|i| expected[(i, 0)]).collect();
        let error = relative_difference(&x, &sought);
        // As above.
        assert!(error < 1e-7, "seed {seed}: {error}");
    }
}
