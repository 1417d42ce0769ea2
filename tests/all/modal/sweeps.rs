//! The sweeps with modal bodies against each other and against differences, on random trees of modal bodies, beams and rigid
//! bodies.

use super::{Strip, lattice};
use crate::common::Random;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;
use stillpoint::dynamics::{Coefficients, MassAction, System, TangentSolver};
use stillpoint::element::modal::Modal;
use stillpoint::fem::ModalDamping;
use stillpoint::linear::{Place, linearize};
use stillpoint::model::Model;
use stillpoint::model::description::{
    BeamDescription, BodyDescription, Description, ForceDescription, GROUND, HingeDescription,
};
use stillpoint::scenario::start;

fn hinge(random: &mut Random) -> HingeDescription {
    match random.below(5) {
        0 => HingeDescription::fixed(),
        1 => HingeDescription::revolute(random.vector(1.0)).stiffness([3.0]).rest([0.2]),
        2 => HingeDescription::spherical(),
        3 => HingeDescription::free(),
        _ => HingeDescription::prismatic(random.vector(1.0)).stiffness([20.0]),
    }
}

/// A strip with two or three interfaces, with or without geometric stiffness, or a lattice.
fn modal(random: &mut Random) -> Modal {
    let damping = match random.below(3) {
        0 => ModalDamping::None,
        1 => ModalDamping::Ratio(0.02),
        _ => ModalDamping::Rayleigh { mass: 0.1, stiffness: 1e-3 },
    };
    let strip =
        Strip { length: 0.9, elements: 4, stiffness: [400.0, 8.0, 6.0, 9.0], mass_per_length: 1.3, polar: 0.02 };
    match random.below(4) {
        0 => lattice(&[0.4, 0.5, 0.3, 0.7, 0.2, 0.6, 0.9, 0.4, 0.5]).reduce(random.below(4), damping),
        1 => strip.model(&[0, 4], true).reduce(random.below(4), damping),
        2 => strip.model(&[0, 2, 4], true).reduce(random.below(3), damping),
        _ => strip.model(&[0, 4, 2], false).reduce(random.below(4), damping),
    }
    .expect("a sound model")
}

/// A modal body on a hinge, a rigid body, a second modal body and a beam on its interfaces, and forces between them.
fn description(random: &mut Random) -> Description {
    let (one, two) = (modal(random), modal(random));
    let root = hinge(random);
    let on_first = hinge(random).on("one", "p1");
    let bob = HingeDescription::revolute(random.vector(1.0)).on("two", "p1");
    let inertia = [4e-3, 5e-3, 3e-3];
    let mut scene = Description::new("Modal bodies")
        .gravity(random.vector(1.0) * 9.0)
        .body(BodyDescription::new("bob", bob).mass(0.4).center([0.1, 0.02, 0.05]).inertia(inertia))
        .body(BodyDescription::new("one", root))
        .body(BodyDescription::new("two", on_first))
        .modal("one", one)
        .modal("two", two);
    if scene.modals[0].modal.tips.len() > 1 {
        let welded = HingeDescription::fixed().on("one", "p2");
        scene = scene.body(BodyDescription::new("lump", welded).mass(0.2).center([0.0, 0.05, 0.02]).inertia(inertia));
    }
    if random.below(2) == 0 {
        let own = hinge(random).on("one", random.vector(0.2));
        let beam =
            BeamDescription::new("rod", own).length(0.5).elements(1).stiffness([90.0, 40.0, 40.0, 2.0, 3.0, 4.0]);
        scene = scene.beam(beam.mass_per_length(0.8).rotary([6e-4, 3e-4, 4e-4]));
    }
    if random.below(2) == 0 {
        let ends = (("two", "p1"), (GROUND, [0.4, 0.5, -0.3]));
        scene = scene.force(ForceDescription::spring("stay", ends.0, ends.1, 4.0, 0.3, 0.2));
    }
    if random.below(2) == 0 {
        let ends = (("one", "p1"), ("two", "p1"));
        scene = scene.force(ForceDescription::spring("brace", ends.0, ends.1, 5.0, 0.2, 0.1));
    }
    scene.force(ForceDescription::load("dead", ("two", "p1"), random.vector(1.0)))
}

fn scene(random: &mut Random) -> Arc<Model> {
    Model::build(&description(random)).expect("a sound scene")
}

/// Positions, velocities and accelerations with displacements and turns of interfaces of some hundredths: terms of second order in
/// the inertia are right for small ones.
fn state(random: &mut Random, model: &Model) -> [Vec<f64>; 3] {
    let n = model.velocity_count();
    let mut by = vec![0.0; n];
    by.iter_mut().for_each(|x| *x = 0.3 * random.between(-1.0, 1.0));
    for link in model.links.iter().filter(|link| link.joint.is_flex()) {
        // The frame of a light body that is free to turn lets even less.
        let stiffens = link.joint.modal().is_some_and(|modal| model.modals[modal].modal.stiffens);
        let part = if stiffens { 0.005 } else { 0.1 };
        by[link.velocity..link.velocity + link.joint.counts().1].iter_mut().for_each(|x| *x *= part);
    }
    let mut q = model.start_position.clone();
    System::displace(model, &mut q, &by);
    let mut some = |size: f64| (0..n).map(|_| size * random.between(-1.0, 1.0)).collect::<Vec<f64>>();
    [q, some(2.0), some(5.0)]
}

fn largest(list: impl IntoIterator<Item = f64>) -> f64 {
    list.into_iter().fold(0.0, |most, x| f64::max(most, x.abs()))
}

const CASES: u64 = 12;

/// The residual for given accelerations.
fn residual(system: &mut System, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
    let mut left = vec![0.0; a.len()];
    system.at(0.0, q, v).residual(a, &mut left).expect("finite");
    left
}

/// Forward dynamics, then inverse dynamics: nothing is unbalanced. And M from inverse dynamics is symmetric, positive
/// definite, and what the mass action multiplies with; the kinetic energy is ½ vᵀ M v.
#[test]
fn accelerations_balance_and_the_mass_matrix_is_one() {
    for seed in 0..CASES {
        let mut random = Random::new(seed);
        let model = scene(&mut random);
        let [q, v, _] = state(&mut random, &model);
        let n = v.len();
        let mut system = System::new(&model);
        let mut a = vec![0.0; n];
        system.at(0.0, &q, &v).accelerations(&mut a).expect("no singular hinge");
        let left = residual(&mut system, &q, &v, &a);
        let none = residual(&mut system, &q, &v, &vec![0.0; n]);
        let mut mass = DMatrix::zeros(n, n);
        for j in 0..n {
            let mut unit = vec![0.0; n];
            unit[j] = 1.0;
            let row = residual(&mut system, &q, &v, &unit);
            (0..n).for_each(|i| mass[(i, j)] = row[i] - none[i]);
        }
        let scale = DVector::from_fn(n, |i, _| 1.0 / mass[(i, i)].sqrt());
        let scaled = DMatrix::from_fn(n, n, |i, j| scale[i] * mass[(i, j)] * scale[j]);
        assert!((&scaled - scaled.transpose()).amax() < 1e-9, "seed {seed}: M is not symmetric");
        assert!(((&scaled + scaled.transpose()) * 0.5).cholesky().is_some(), "seed {seed}: M is not definite");
        let work = |f: &[f64]| largest(f.iter().zip(&scale).map(|(f, s)| f * s));
        assert!(work(&left) < 1e-9 * (1.0 + work(&none)), "seed {seed}: {} of {}", work(&left), work(&none));
        let mut product = vec![0.0; n];
        let mut action = MassAction::new(&model);
        system.at(0.0, &q, &v).mass_times(&mut action, &v, &mut product);
        let dense = &mass * DVector::from_column_slice(&v);
        let off = largest(product.iter().zip(dense.iter()).zip(&scale).map(|((a, b), s)| (a - b) * s));
        assert!(off < 1e-9 * (1.0 + work(&none)), "seed {seed}: M v is off by {off}");
        let kinetic = system.at(0.0, &q, &v).energies().kinetic;
        let by_mass = 0.5 * v.iter().zip(&product).map(|(v, p)| v * p).sum::<f64>();
        assert!((kinetic - by_mass).abs() < 1e-11 * kinetic, "seed {seed}: {kinetic} {by_mass}");
    }
}

/// The dense derivatives of the residual against differences of fourth order, and the tangent sweep against them.
#[test]
fn the_tangent_is_the_derivative_of_the_balance() {
    let (mut by_differences, mut by_sweep) = (0.0_f64, 0.0_f64);
    for seed in 0..CASES {
        let mut random = Random::new(1000 + seed);
        let model = scene(&mut random);
        let [q, mut v, mut a] = state(&mut random, &model);
        if seed % 3 == 0 {
            v.fill(0.0);
            a.fill(0.0);
        }
        let n = v.len();
        let (c1, c2) = if seed % 3 == 0 { (0.0, 0.0) } else { (30.0, 900.0) };
        let mut system = System::new(&model);
        let linear = system.at(0.0, &q, &v).linearize(&a).expect("finite");
        let dense = DMatrix::from_fn(n, n, |i, j| {
            linear.stiffness[(i, j)] + c1 * linear.damping[(i, j)] + c2 * linear.mass[(i, j)]
        });
        let mut differences = DMatrix::zeros(n, n);
        let h = 2e-4;
        for j in 0..n {
            for (times, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
                let mut by = vec![0.0; n];
                by[j] = times * h;
                let mut moved = q.clone();
                System::displace(&model, &mut moved, &by);
                let faster: Vec<f64> = v.iter().zip(&by).map(|(v, by)| v + c1 * by).collect();
                let sooner: Vec<f64> = a.iter().zip(&by).map(|(a, by)| a + c2 * by).collect();
                let row = residual(&mut system, &moved, &faster, &sooner);
                (0..n).for_each(|i| differences[(i, j)] += weight / (12.0 * h) * row[i]);
            }
        }
        let off = (&dense - &differences).amax() / dense.amax();
        by_differences = by_differences.max(off);
        assert!(off < 1e-7, "seed {seed}: the dense tangent is off by {off:.1e}");
        let mut solver = TangentSolver::new(&model);
        // A shift, for free motions have no stiffness at rest.
        let shift: Vec<f64> = (0..n).map(|_| random.between(5.0, 10.0)).collect();
        let with = Coefficients { c1, c2, shift: &shift, ..Coefficients::default() };
        let dense = dense + DMatrix::from_diagonal(&DVector::from_column_slice(&shift));
        assert!(system.at(0.0, &q, &v).factorize_tangent(&mut solver, &a, &with).expect("finite"));
        let rhs = DVector::from_fn(n, |_, _| random.between(-1.0, 1.0));
        let mut x = rhs.as_slice().to_vec();
        solver.solve(&mut x);
        let left = &dense * DVector::from_column_slice(&x) - &rhs;
        let terms = dense.abs() * DVector::from_column_slice(&x).abs();
        let off = left.iter().zip(terms.iter()).map(|(left, size)| left.abs() / (size + 1.0)).fold(0.0, f64::max);
        by_sweep = by_sweep.max(off);
        assert!(off < 1e-8, "seed {seed}: the sweep leaves {off:.1e}");
    }
    println!("dense against differences {by_differences:.1e}, sweep {by_sweep:.1e} of the terms");
}

/// At rest the balance is the gradient of the potential; in motion, what the accelerations do with the energy is what the dampers
/// take out. The potential and the kinetic energy know nothing of the sweeps.
#[test]
fn energy_is_balanced() {
    for seed in 0..CASES {
        let mut random = Random::new(2000 + seed);
        let model = scene(&mut random);
        let [q, v, _] = state(&mut random, &model);
        let n = model.velocity_count();
        let rest = vec![0.0; n];
        let mut system = System::new(&model);
        let force = residual(&mut system, &q, &rest, &rest);
        let h = 1e-3;
        let points = [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)];
        let scale = largest(force.iter().copied());
        for j in 0..n {
            let mut slope = 0.0;
            for (times, weight) in points {
                let mut by = vec![0.0; n];
                by[j] = times * h;
                let mut moved = q.clone();
                System::displace(&model, &mut moved, &by);
                slope += weight / (12.0 * h) * system.at(0.0, &moved, &rest).energies().potential;
            }
            assert!((slope - force[j]).abs() < 1e-7 * scale, "seed {seed}, {j}: {slope} {}", force[j]);
        }
        let mut a = vec![0.0; n];
        system.at(0.0, &q, &v).accelerations(&mut a).expect("no singular hinge");
        let (mut rate, mut kinetic, h) = (0.0, 0.0, 2e-4);
        for (times, weight) in points {
            let t = times * h;
            let mut moved = q.clone();
            System::displace(&model, &mut moved, &v.iter().map(|v| t * v).collect::<Vec<_>>());
            let faster: Vec<f64> = v.iter().zip(&a).map(|(v, a)| v + t * a).collect();
            let energies = system.at(0.0, &moved, &faster).energies();
            rate += weight / (12.0 * h) * (energies.kinetic + energies.potential);
            kinetic += weight / (12.0 * h) * energies.kinetic;
        }
        let power = system.at(0.0, &q, &v).powers();
        let expected = power.input - power.dissipated;
        assert!((rate - expected).abs() < 1e-7 * (1.0 + kinetic.abs()), "seed {seed}: {rate} {expected} of {kinetic}");
    }
}

/// The linear equations about any state against differences of the accelerations.
#[test]
fn linear_equations_match_differences_of_the_accelerations() {
    for seed in 0..CASES / 2 {
        let mut random = Random::new(900 + seed);
        let model = scene(&mut random);
        let [q, v, _] = state(&mut random, &model);
        let n = v.len();
        let place = Place {
            time: 0.0,
            position: q.clone(),
            velocity: v.clone(),
            multipliers: None,
            held: Vec::new(),
            pressed: Vec::new(),
        };
        let mut system = System::new(&model);
        let mut at = |by: &[f64], rate: &[f64]| {
            let (mut moved, mut a) = (q.clone(), vec![0.0; n]);
            System::displace(&model, &mut moved, by);
            let v: Vec<f64> = v.iter().zip(rate).map(|(v, by)| v + by).collect();
            system.at(0.0, &moved, &v).accelerations(&mut a).expect("no singular hinge");
            a
        };
        let step = 1e-5;
        let [none, by] = [vec![0.0; n], random.list(n, -step, step)];
        let found = linearize(&model, &place, &[], None).expect("the linear equations");
        assert_eq!((found.a.nrows(), found.states.len()), (2 * n, 2 * n), "seed {seed}");
        let back: Vec<f64> = by.iter().map(|x| -x).collect();
        for (first, [ahead, behind]) in
            [(0, [at(&by, &none), at(&back, &none)]), (n, [at(&none, &by), at(&none, &back)])]
        {
            let told = |i: usize| (0..n).map(|j| found.a[(n + i, first + j)] * by[j]).sum::<f64>();
            let size = largest((0..n).map(told));
            let apart = largest((0..n).map(|i| told(i) - 0.5 * (ahead[i] - behind[i])));
            // Of second order in the step, in inertias that are nearly singular.
            assert!(apart < 1e-5 * size, "seed {seed}, {first}: {apart:e} of {size:e}");
        }
    }
}

/// What a start file says of modal bodies is what they start with, bit for bit.
#[test]
fn start_files_hold_coordinates_and_their_rates() {
    for seed in 0..10 {
        let mut random = Random::new(2000 + seed);
        let description = description(&mut random);
        let model = Model::build(&description).expect("a sound scene");
        let [q, v, _] = state(&mut random, &model);
        let text = start::text(&model, &q, &v, &[], &[]);
        let started =
            start::parse_start("start.toml", &text, &description).unwrap_or_else(|why| panic!("{why}\n{text}"));
        assert_eq!((&started.model.start_position, &started.model.start_velocity), (&q, &v), "seed {seed}\n{text}");
        let short = text.replacen("\"two\" = [", "\"two\" = [0.5, ", 3);
        let refused = start::parse_start("start.toml", &short, &description).expect_err("a number too many");
        assert!(!refused.to_string().is_empty());
    }
}

/// A closed loop between interfaces of one body and of two: the constraint forces of the sweeps against those of dense matrices,
/// by the accelerations that keep the rows.
#[test]
fn loops_between_interfaces_are_kept() {
    use stillpoint::model::couplings::{Closure, LoopDescription};
    let strip =
        Strip { length: 0.9, elements: 4, stiffness: [400.0, 8.0, 6.0, 9.0], mass_per_length: 1.3, polar: 0.02 };
    for stiffens in [false, true] {
        let modal = strip.model(&[0, 2, 4], stiffens).reduce(2, ModalDamping::None).expect("sound");
        let other = strip.model(&[0, 4], stiffens).reduce(1, ModalDamping::None).expect("sound");
        let loop_of = |name: &str, a: (&str, &str), b: (&str, &str)| LoopDescription {
            name: name.to_owned(),
            between: [a.into(), b.into()],
            closure: Closure::Rod { length: 0.45 },
            frame: Default::default(),
            second_frame: None,
        };
        let description = Description::new("Loops")
            .body(BodyDescription::new("arm", HingeDescription::revolute([0.0, 1.0, 0.0])))
            .body(BodyDescription::new(
                "leg",
                HingeDescription::spherical().on(GROUND, [0.0, 0.45, 0.0]).position([1.0, 0.0, 0.0, 0.0]),
            ))
            .modal("arm", modal)
            .modal("leg", other)
            .closure(loop_of("own", ("arm", "p1"), ("arm", "p2")))
            .closure(loop_of("across", ("arm", "p2"), ("leg", "p1")));
        let assembled = stillpoint::constraint::assemble(Model::build(&description).expect("sound")).expect("closed");
        let model = assembled.0;
        let (q, v) = (model.start_position.clone(), model.start_velocity.clone());
        let n = v.len();
        let mut system = System::new(&model);
        let mut a = vec![0.0; n];
        system.at(0.0, &q, &v).accelerations(&mut a).expect("accelerations");
        let length = |system: &mut System, q: &[f64], ends: [&str; 2]| {
            let rest = vec![0.0; n];
            let at = system.at(0.0, q, &rest);
            let place = |name: &str| at.motion().links[model.bodies[model.body(name).expect("known")].link].position;
            (place(ends[0]) - place(ends[1])).norm()
        };
        // From rest the second derivative of the distance is its slope along the accelerations.
        let h = 1e-6 / largest(a.iter().copied());
        for ends in [["arm/p1", "arm/p2"], ["arm/p2", "leg/p1"]] {
            let mut at = |t: f64| {
                let mut moved = q.clone();
                System::displace(&model, &mut moved, &a.iter().map(|a| t * a).collect::<Vec<_>>());
                length(&mut system, &moved, ends)
            };
            let slope = (at(h) - at(-h)) / (2.0 * h);
            assert!((at(0.0) - 0.45).abs() < 1e-9, "{ends:?} are {} apart", at(0.0));
            assert!(
                slope.abs() < 1e-7 * largest(a.iter().copied()),
                "{ends:?}: {slope} of {}",
                largest(a.iter().copied())
            );
        }
    }
}
