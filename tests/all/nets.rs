//! Scenes of many far springs: the sparse tangent against the dense one.

mod deep;
mod ladder;
mod scenes;

use crate::common::{Options, Random, build, random_scene, relative_difference};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use std::sync::Arc;
use stillpoint::dynamics::{Coefficients, System, TangentSolver};
use stillpoint::model::Model;
use stillpoint::model::couplings::{Closure, LoopDescription};
use stillpoint::model::description::*;

/// A random tree of every kind of hinge with springs and bushings between random bodies, or a body and the ground.
fn tangled(seed: u64, forces: usize) -> Description {
    let mut random = Random::new(seed + 70_000);
    let bodies = 25 + random.below(25);
    let options = Options { bodies, springs: true, welds: seed.is_multiple_of(2) };
    let mut description = random_scene(seed, &options);
    // With `hub` one body has a spring to every other.
    let hub = seed.is_multiple_of(3).then(|| random.below(bodies));
    for index in 0..forces {
        let (a, b) = (hub.unwrap_or_else(|| random.below(bodies)), random.below(bodies + 1));
        let end = |random: &mut Random, index: usize| Attachment {
            body: description.bodies.get(index).map_or(GROUND.to_owned(), |body| body.name.clone()),
            point: Point::At(random.vector(0.4)),
        };
        let between = [end(&mut random, a), end(&mut random, if a == b { bodies } else { b })];
        let kind: ForceKind = match random.below(3) {
            0 => Bushing {
                between,
                frame: random.turn(),
                stiffness: [0; 6].map(|_| random.between(0.5, 5.0)),
                damping: [0; 6].map(|_| random.between(0.0, 0.5)),
                preload: [0; 6].map(|_| random.between(-1.0, 1.0)),
            }
            .into(),
            _ => Spring {
                between,
                stiffness: random.between(1.0, 20.0),
                length: random.between(0.0, 1.0),
                damping: random.between(0.0, 1.0),
            }
            .into(),
        };
        description.forces.push(ForceDescription { name: format!("far{index}"), kind });
    }
    description
}

fn is_sparse(model: &Model) -> bool {
    !TangentSolver::covers(model) && TangentSolver::further_sides(model) == 0
}

/// In both of its uses: static, and of an implicit step with velocities and accelerations.
#[test]
fn sparse_tangent_solves_the_dense_tangent() {
    let mut sparse = 0;
    for seed in 0..20 {
        let model = build(&tangled(seed, 60));
        sparse += usize::from(is_sparse(&model));
        let n = model.velocity_count();
        let mut random = Random::new(seed + 71_000);
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
            let b = Mat::from_fn(n, 1, |i, _| rhs[i]);
            let expected = matrix.partial_piv_lu().solve(&b);
            let shift = vec![shift; n];
            let with = Coefficients { c1, c2, shift: &shift, ..Coefficients::default() };
            assert!(system.at(0.0, q, v).factorize_tangent(&mut solver, a, &with).unwrap(), "seed {seed}");
            let mut x = rhs.clone();
            solver.solve(&mut x);
            let residual = &matrix * Mat::from_fn(n, 1, |i, _| x[i]) - &b;
            let residual = (0..n).map(|i| residual[(i, 0)].abs()).fold(0.0, f64::max);
            let error = relative_difference(&x, &(0..n).map(|i| expected[(i, 0)]).collect::<Vec<_>>());
            // Both eliminate with pivots: the error is that of the condition, the residual round-off.
            assert!(error < 1e-6 && residual < 1e-9, "seed {seed} c1 {c1} c2 {c2}: {error} {residual}");
        }
    }
    assert!(sparse > 15, "only {sparse} of 20");
}

/// Of the symmetric tangent, with shifts of random signs and some coordinates held, the negative eigenvalues; the solution is
/// that of the rest, and zero where it is held.
#[test]
fn sparse_tangent_counts_negative_eigenvalues() {
    for seed in 0..20 {
        let mut description = tangled(seed, 60);
        description.forces.retain(|force| matches!(force.kind, ForceKind::Spring(_)));
        let model = build(&description);
        if !is_sparse(&model) {
            continue;
        }
        let n = model.velocity_count();
        let mut random = Random::new(seed + 72_000);
        let (zero, rhs) = (vec![0.0; n], random.list(n, -1.0, 1.0));
        let mut shift = random.list(n, -10.0, 10.0);
        // A ball is held as a whole.
        let one = |index: usize| model.links[index].joint.counts() == (1, 1);
        for link in (1..model.links.len()).filter(|link| one(*link) && random.below(5) == 0) {
            shift[model.links[link].velocity] = f64::INFINITY;
        }
        let free: Vec<usize> = (0..n).filter(|i| shift[*i].is_finite()).collect();
        let mut system = System::new(&model);
        let mut solver = TangentSolver::new(&model);
        let q = &model.start_position;
        let full = system.at(0.0, q, &zero).stiffness().unwrap();
        let entry = |i: usize, j: usize| {
            let (a, b) = (free[i], free[j]);
            0.5 * (full[(a, b)] + full[(b, a)]) + if i == j { shift[a] } else { 0.0 }
        };
        let symmetric = Mat::from_fn(free.len(), free.len(), entry);
        let values = symmetric.self_adjoint_eigenvalues(Side::Lower).unwrap();
        let negative = values.iter().filter(|x| **x < 0.0).count();
        let with = Coefficients { shift: &shift, symmetric: true, ..Coefficients::default() };
        assert!(system.at(0.0, q, &zero).factorize_tangent(&mut solver, &zero, &with).unwrap());
        assert_eq!(solver.negatives(), Some(negative), "seed {seed}");
        let mut x = rhs.clone();
        solver.solve(&mut x);
        let b = Mat::from_fn(free.len(), 1, |i, _| rhs[free[i]]);
        let expected = symmetric.partial_piv_lu().solve(&b);
        let mut whole = zero.clone();
        free.iter().enumerate().for_each(|(row, i)| whole[*i] = expected[(row, 0)]);
        let error = relative_difference(&x, &whole);
        assert!(error < 1e-6, "seed {seed}: {error}");
        let definite = Coefficients { definite: true, ..with };
        let found = system.factorize_shifted(&mut solver, &zero, &definite).is_ok();
        assert_eq!(found, negative == 0, "seed {seed}");
    }
}

/// A net of n × n points, a unit square, its corners fixed: inner points slide on three axes, springs to their neighbours.
fn net(n: usize) -> Description {
    let a = 1.0 / (n - 1) as f64;
    let is_corner = |i: usize, j: usize| (i == 0 || i == n - 1) && (j == 0 || j == n - 1);
    let mut net = Description::new("net").gravity([0.0, 0.0, -9.81]);
    for (i, j) in (0..n * n).map(|k| (k / n, k % n)).filter(|(i, j)| !is_corner(*i, *j)) {
        let mut parent = GROUND.to_owned();
        for (axis, (name, at)) in [("x", i as f64 * a), ("y", j as f64 * a), ("z", -0.05)].into_iter().enumerate() {
            let mut along = [0.0; 3];
            along[axis] = 1.0;
            let hinge = HingeDescription::prismatic(along).on(&parent, [0.0; 3]).position([at]);
            parent = format!("{name}{i}_{j}");
            let mass = if axis == 2 { 0.05 } else { 0.0 };
            net = net.body(BodyDescription::new(&parent, hinge).mass(mass));
        }
    }
    let end = |i: usize, j: usize| match is_corner(i, j) {
        true => Attachment::from((GROUND, [i as f64 * a, j as f64 * a, 0.0])),
        false => Attachment::from((format!("z{i}_{j}").as_str(), [0.0; 3])),
    };
    for (i, j) in (0..n * n).map(|k| (k / n, k % n)) {
        for (k, l) in [(i + 1, j), (i, j + 1)].into_iter().filter(|(k, l)| *k < n && *l < n) {
            let name = format!("s{i}_{j}_{k}_{l}");
            net = net.force(ForceDescription::spring(&name, end(i, j), end(k, l), 400.0, 0.97 * a, 0.1));
        }
    }
    net
}

/// A net lets down from nearly flat and hangs, stable; its lowest modes are those of the dense matrices.
#[test]
fn a_net_hangs_and_swings_as_the_dense_matrices_say() {
    use stillpoint::statics::{Settings, StabilityVerdict, equilibrium};
    let model: Arc<Model> = build(&net(7));
    assert!(is_sparse(&model));
    let found = equilibrium(&model, &Settings::default(), &model.start_position).unwrap();
    assert!(found.converged, "{:?}", found.notes);
    let stability = found.stability.unwrap();
    assert_eq!(stability.verdict, StabilityVerdict::Stable);
    let n = model.velocity_count();
    let zero = vec![0.0; n];
    let dense = System::new(&model).at(0.0, &found.position, &zero).linearize(&zero).unwrap();
    let root = |x: f64| x.sqrt() / std::f64::consts::TAU;
    let mass = dense.mass[(0, 0)];
    assert!((0..n).all(|i| (0..n).all(|j| (dense.mass[(i, j)] - if i == j { mass } else { 0.0 }).abs() < 1e-15)));
    let values = dense.stiffness.self_adjoint_eigenvalues(Side::Lower).unwrap();
    let lowest: Vec<f64> = values.iter().take(8).map(|x| root(x / mass)).collect();
    let frequencies: Vec<f64> = stability.frequencies().take(8).collect();
    let error = relative_difference(&frequencies, &lowest);
    assert!(error < 1e-10, "{error}: {frequencies:?} {lowest:?}");
}

/// Bars of random lengths that stand on the ground, springs at their tips, and between each two tips two rods with an elbow:
/// loops whose revolute hinges have redundant rows.
fn frame(seed: u64, bars: usize) -> Description {
    let mut random = Random::new(seed + 73_000);
    let axis = [0.0, -1.0, 0.0];
    let rod = |name: &str, hinge: HingeDescription, length: f64| {
        let across = length * length / 12.0;
        let rod = BodyDescription::new(name, hinge).mass(length).center([0.5 * length, 0.0, 0.0]);
        rod.inertia([1e-3, length * across + 1e-3, length * across + 1e-3])
    };
    let mut frame = Description::new("frame").gravity([0.0, 0.0, -9.81]);
    let mut tips = Vec::new();
    for index in 0..bars {
        let (foot, length, angle) = (2.0 * index as f64, random.between(0.7, 1.3), random.between(1.2, 1.9));
        let (name, hinge) = (format!("bar{index}"), HingeDescription::revolute(axis));
        frame = frame.body(rod(&name, hinge.on(GROUND, [foot, 0.0, 0.0]).position([angle]), length));
        let tip = [foot + length * angle.cos(), length * angle.sin()];
        let stiffness = random.between(20.0, 60.0);
        let end = Attachment::from((name.as_str(), [length, 0.0, 0.0]));
        let post = Attachment::from((GROUND, [foot - 1.0, random.between(-0.2, 0.2), 1.2]));
        frame = frame.force(ForceDescription::spring(&format!("spring{index}"), end, post, stiffness, 0.6, 0.0));
        tips.push((tip, length, angle));
    }
    for index in 0..bars - 1 {
        let ((from, length, angle), (to, other, _)) = (tips[index], tips[index + 1]);
        let (dx, dz) = (to[0] - from[0], to[1] - from[1]);
        let distance = dx.hypot(dz);
        // Two rods of the same length that sag.
        let half = 0.5 * distance * random.between(1.05, 1.3);
        let (straight, sag) = (dz.atan2(dx), (0.5 * distance / half).acos());
        let names = [format!("left{index}"), format!("right{index}")];
        let first = HingeDescription::revolute(axis).on(&format!("bar{index}"), [length, 0.0, 0.0]);
        frame = frame.body(rod(&names[0], first.position([straight - sag - angle]), half));
        let second = HingeDescription::revolute(axis).on(&names[0], [half, 0.0, 0.0]);
        frame = frame.body(rod(&names[1], second.position([2.0 * sag]), half));
        let between = [
            Attachment::from((names[1].as_str(), [half, 0.0, 0.0])),
            Attachment::from((format!("bar{}", index + 1).as_str(), [other, 0.0, 0.0])),
        ];
        frame = frame.closure(LoopDescription {
            name: format!("knot{index}"),
            closure: Closure::Hinge(HingeKind::Revolute { axis: [0.0, 1.0, 0.0].into() }),
            between,
            frame: nalgebra::UnitQuaternion::identity(),
            second_frame: None,
        });
    }
    frame
}

/// What the dense matrices say of a closed position with its multipliers: the part of the forces that the rows leave, and the
/// eigenvalues of `K x = λ M x` on the motions, ascending.
fn along_rows(model: &Arc<Model>, q: &[f64], multipliers: &[f64]) -> (f64, Vec<f64>) {
    let (n, zero) = (model.velocity_count(), vec![0.0; model.velocity_count()]);
    let mut system = System::new(model);
    system.set_multipliers(multipliers);
    let mut residual = zero.clone();
    system.at(0.0, q, &zero).residual(&zero, &mut residual).unwrap();
    let dense = system.at(0.0, q, &zero).linearize(&zero).unwrap();
    let rows = system.at(0.0, q, &zero).constraint_matrix();
    let svd = rows.transpose().svd().unwrap();
    let z = svd.U().subcols(rows.nrows(), n - rows.nrows()).to_owned();
    let reduced = |m: &Mat<f64>| z.transpose() * m * &z;
    let (k, m) = (reduced(&dense.stiffness), reduced(&dense.mass));
    let (k, m) = (&k + k.transpose(), &m + m.transpose());
    let lower = m.llt(Side::Lower).unwrap().L().to_owned();
    let inverse = lower.partial_piv_lu().solve(&Mat::<f64>::identity(m.nrows(), m.nrows()));
    let product = &inverse * &k * inverse.transpose();
    let values = (&product + product.transpose()).self_adjoint_eigenvalues(Side::Lower).unwrap();
    let left = z.transpose() * Mat::from_fn(n, 1, |i, _| residual[i]);
    let left = (0..left.nrows()).map(|i| left[(i, 0)].abs()).fold(0.0, f64::max);
    (left, values.into_iter().map(|value| 0.5 * value).collect())
}

/// Frames of many loops come to rest by sparse matrices; residual, verdict and lowest modes are those of dense ones.
#[test]
fn many_loops_rest_and_swing_as_the_dense_matrices_say() {
    use stillpoint::statics::{Settings, StabilityVerdict, equilibrium};
    for seed in 0..6 {
        let model = build(&frame(seed, 30));
        assert!(is_sparse(&model));
        let found = equilibrium(&model, &Settings::default(), &model.start_position).unwrap();
        assert!(found.converged, "seed {seed}: {:?}", found.notes);
        assert!(found.stages.iter().all(|stage| stage.factorizations < 200), "seed {seed}: {:?}", found.stages);
        let (left, values) = along_rows(&model, &found.position, &found.multipliers);
        assert!(left < 1e-8, "seed {seed}: {left}");
        let stability = found.stability.unwrap();
        assert_eq!(stability.verdict, StabilityVerdict::Stable, "seed {seed}");
        assert!(values[0] > 0.0, "seed {seed}: {}", values[0]);
        let lowest: Vec<f64> = values.iter().take(8).map(|value| value.sqrt() / std::f64::consts::TAU).collect();
        let frequencies: Vec<f64> = stability.frequencies().take(8).collect();
        let error = relative_difference(&frequencies, &lowest);
        assert!(error < 1e-8, "seed {seed}: {error}: {frequencies:?} {lowest:?}");
    }
}

/// Without springs a frame that hangs is balanced against gravity upward, too, and unstable in as many directions as the dense
/// matrices have negative eigenvalues: in all of them.
#[test]
fn many_loops_count_their_directions_of_negative_curvature() {
    use stillpoint::statics::{Settings, Want, equilibrium};
    let mut hung = 0;
    for seed in 20..26 {
        let mut description = frame(seed, 30);
        description.forces.clear();
        let model = build(&description);
        assert!(is_sparse(&model));
        let found = equilibrium(&model, &Settings::default(), &model.start_position).unwrap();
        if !found.converged {
            continue;
        }
        hung += 1;
        description.gravity = -description.gravity;
        let upward = build(&description);
        let settings = Settings { want: Want::Any, ..Settings::default() };
        let found = equilibrium(&upward, &settings, &found.position).unwrap();
        assert!(found.balanced, "seed {seed}: {:?}", found.notes);
        let (_, values) = along_rows(&upward, &found.position, &found.multipliers);
        let negative = values.iter().filter(|value| **value < 0.0).count();
        assert_eq!(negative, values.len(), "seed {seed}: {values:?}");
        assert_eq!(found.stability.unwrap().unstable_directions, negative, "seed {seed}");
    }
    assert!(hung >= 3, "{hung}");
}

/// A platform on parallel bars of one length, a parallelogram of loops of which all but one are redundant in the plane, with
/// lengths and masses in other units; its hinges stand `at` along the ground.
fn table(mut scene: Description, seed: u64, at: f64, [length, mass]: [f64; 2]) -> Description {
    let mut random = Random::new(seed + 74_000);
    let (axis, bars, angle) = ([0.0, -1.0, 0.0], 3 + random.below(5), random.between(0.6, 2.4));
    let feet: Vec<f64> = (0..bars).map(|k| length * (k as f64 + random.between(-0.3, 0.3))).collect();
    let rod = |name: &str, hinge: HingeDescription, times: f64| {
        let inertia = mass * times * length * length;
        BodyDescription::new(name, hinge).mass(mass * times).inertia([inertia, 1.1 * inertia, 0.9 * inertia])
    };
    let name = |k: usize| format!("bar{seed}_{k}");
    for (k, foot) in feet.iter().enumerate() {
        let hinge = HingeDescription::revolute(axis).on(GROUND, [at + foot, 0.0, 0.0]).position([angle]);
        scene = scene.body(rod(&name(k), hinge, random.between(0.1, 1.0)));
    }
    let platform = format!("platform{seed}");
    let hinge = HingeDescription::revolute(axis).on(&name(0), [length, 0.0, 0.0]).position([-angle]);
    scene = scene.body(rod(&platform, hinge, random.between(0.1, 1.0)));
    for k in 1..bars {
        let between = [
            Attachment::from((platform.as_str(), [feet[k] - feet[0], 0.0, 0.0])),
            Attachment::from((name(k).as_str(), [length, 0.0, 0.0])),
        ];
        scene = scene.closure(LoopDescription {
            name: format!("knot{seed}_{k}"),
            closure: Closure::Hinge(HingeKind::Revolute { axis: [0.0, 1.0, 0.0].into() }),
            between,
            frame: nalgebra::UnitQuaternion::identity(),
            second_frame: None,
        });
    }
    scene
}

/// Which rows are redundant is a matter of geometry: the same whatever the masses and lengths are, and whatever else is in the
/// scene. A platform on n bars moves in one way.
#[test]
fn redundant_rows_are_the_same_in_all_units() {
    let of = |scales: &[[f64; 2]], first: u64| {
        let mut scene = Description::new("tables").gravity([0.0, 0.0, -9.81]);
        let mut at = 0.0;
        for (k, scale) in scales.iter().enumerate() {
            scene = table(scene, first + k as u64, at, *scale);
            at += 20.0 * scale[0];
        }
        let assembly = stillpoint::constraint::assemble(build(&scene)).expect("an assembly").1;
        assert_eq!(assembly.degrees_of_freedom, scales.len(), "{:?}", assembly.redundant);
        assembly.redundant
    };
    let mut random = Random::new(75_000);
    for seed in (0..60).step_by(3) {
        let alone: Vec<_> = (0..3).flat_map(|k| of(&[[1.0, 1.0]], seed + k)).collect();
        let scales: Vec<[f64; 2]> =
            (0..3).map(|_| [10_f64.powf(random.between(-3.0, 3.0)), 10_f64.powf(random.between(-9.0, 9.0))]).collect();
        assert_eq!(of(&scales, seed), alone, "seed {seed}: {scales:?}");
    }
}

/// Implicit steps beside many loops take their rows in the sparse matrix: a frame that swings for a while ends where an explicit
/// method of high order puts it.
#[test]
fn implicit_steps_beside_many_loops_end_where_explicit_ones_do() {
    use stillpoint::integrate::Method;
    use stillpoint::record::Memory;
    use stillpoint::simulate::{Integrator, Settings, State, run, scene};
    let mut description = frame(3, 24);
    description.forces.clear();
    let model = stillpoint::constraint::assemble(build(&description)).expect("an assembly").0;
    assert!(is_sparse(&model) && model.loops.len() == 23);
    let start = State { position: model.start_position.clone(), velocity: vec![0.0; model.velocity_count()] };
    let end = |method: Method| {
        let integrator = Integrator::Method(method);
        let settings = Settings { duration: 0.15, integrator, tolerance: 1e-9, ..Settings::default() };
        let mut memory =
            Memory::new(&stillpoint::record::Opening { scene: &scene(&model), scenario: "", statics: None });
        run(&model, &settings, 10.0, &start, &mut memory, &mut |_, _| true).expect("a run");
        memory.samples.last().expect("an end").positions.clone()
    };
    let (implicit, explicit) = (end(Method::Radau5), end(Method::Dop853));
    let error = relative_difference(&implicit, &explicit);
    // Both keep to a part in 10⁹ of the motion, which is amplified by the frame's fall.
    assert!(error < 1e-6, "{error}");
    assert!(relative_difference(&implicit, &start.position) > 1e-3);
}

/// A chain of sliding points with springs between points that are far apart.
fn chain(links: usize, springs: usize) -> Description {
    let mut random = Random::new(77_000);
    let mut chain = Description::new("chain").gravity([0.0, 0.0, -9.81]);
    let mut parent = GROUND.to_owned();
    for index in 0..links {
        let hinge = HingeDescription::prismatic([1.0, 0.0, 0.0]).on(&parent, [0.0; 3]).position([0.1]);
        parent = format!("b{index}");
        chain = chain.body(BodyDescription::new(&parent, hinge).mass(1.0));
    }
    for index in 0..springs {
        let ends = [random.below(links / 3), links - 1 - random.below(links / 3)];
        let [a, b] = ends.map(|end| Attachment::from((format!("b{end}").as_str(), [0.0; 3])));
        chain = chain.force(ForceDescription::spring(&format!("s{index}"), a, b, 10.0, 0.1, 0.0));
    }
    chain
}

/// A long chain with far springs all over fills its matrix: it is refused with the estimate, and before any of it is asked for.
#[test]
fn a_scene_too_large_for_the_memory_is_refused_with_its_estimate() {
    use stillpoint::statics::{Settings, equilibrium};
    let model = build(&chain(13_000, 1000));
    let said = equilibrium(&model, &Settings::default(), &model.start_position).expect_err("too large").to_string();
    let bytes = 8.0 * 6.0 * 13_000_f64.powi(2);
    assert!(said.contains(&format!("{:.1} GB", bytes / 1e9)) && said.contains("13000 coordinates"), "{said}");
}

/// Springs between the same two bodies are one block of the tangent, however many there are and in whichever order their ends are
/// given.
#[test]
fn springs_between_the_same_bodies_are_one_block() {
    let mut description = chain(6, 0);
    for index in 0..400 {
        let ends = if index % 2 == 0 { ["b1", "b4"] } else { ["b4", "b1"] };
        let [a, b] = ends.map(|end| Attachment::from((end, [0.0; 3])));
        description = description.force(ForceDescription::spring(&format!("s{index}"), a, b, 0.5, 0.1, 0.0));
    }
    let model = build(&description);
    assert_eq!(TangentSolver::further_sides(&model), 12);
    let n = model.velocity_count();
    let zero = vec![0.0; n];
    let (mut system, mut solver) = (System::new(&model), TangentSolver::new(&model));
    let q = &model.start_position;
    let dense = system.at(0.0, q, &zero).linearize(&zero).unwrap();
    let matrix = &dense.stiffness + &dense.mass * 3.0;
    let with = Coefficients { c2: 3.0, ..Coefficients::default() };
    assert!(system.at(0.0, q, &zero).factorize_tangent(&mut solver, &zero, &with).unwrap());
    let mut x: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
    let rhs = Mat::from_fn(n, 1, |i, _| x[i]);
    solver.solve(&mut x);
    let residual = &matrix * Mat::from_fn(n, 1, |i, _| x[i]) - &rhs;
    // Round-off of 400 springs that add up to 200 N/m.
    assert!((0..n).all(|i| residual[(i, 0)].abs() < 1e-11), "{residual:?}");
}
