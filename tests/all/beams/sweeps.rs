//! The sweeps with flexible elements against each other and against differences, on random trees of beams and bodies.

use crate::common::Random;
use nalgebra::{DMatrix, DVector, Matrix6, Vector3};
use std::sync::Arc;
use stillpoint::dynamics::{Coefficients, MassAction, System, TangentSolver};
use stillpoint::force::Act;
use stillpoint::linear::{Place, linearize};
use stillpoint::model::Model;
use stillpoint::model::description::{
    BeamDescription, BeamShape, BodyDescription, Description, ForceDescription, FreeStrains, GROUND, HingeDescription,
    Section,
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

fn section(random: &mut Random) -> Section {
    match random.below(3) {
        0 => Section::Rectangle { width: 0.04, height: 0.02 },
        1 => Section::Tube { outer: 0.02, inner: 0.012 },
        _ => {
            let coupling = Matrix6::from_fn(|_, _| random.between(-1.0, 1.0));
            let diagonal = Matrix6::from_diagonal(&nalgebra::Vector6::new(900.0, 400.0, 500.0, 2.0, 3.0, 4.0));
            let root = diagonal.map(f64::sqrt);
            Section::Stiffness(diagonal + 0.1 * root * (coupling + coupling.transpose()) * root)
        }
    }
}

fn shape(random: &mut Random) -> BeamShape {
    match random.below(4) {
        0 => BeamShape::Straight { length: 0.9 },
        1 => BeamShape::Arc { radius: 0.8, angle: 1.1 },
        2 => {
            let points = (0..4).map(|i| Vector3::x() * (0.2 * f64::from(i)) + random.vector(0.02)).collect();
            BeamShape::through(points).expect("four points in a row")
        }
        _ => BeamShape::Helix { radius: 0.4, pitch: 0.3, turns: 0.25 },
    }
}

/// A beam of one to three elements, with anything that beams can have.
fn beam(random: &mut Random, name: &str, hinge: HingeDescription) -> BeamDescription {
    let mut beam = BeamDescription::new(name, hinge)
        .shape(shape(random))
        .elements(1 + random.below(3))
        .degree(random.below(3))
        .section(section(random))
        .material(2e7, 0.3, 1200.0)
        .free(FreeStrains {
            bend: true,
            twist: random.below(2) == 0,
            stretch: random.below(2) == 0,
            shear: random.below(3) == 0,
        })
        .damping(0.01)
        .marker("mid", 0.3);
    beam.twist = random.between(-1.0, 1.0);
    if matches!(beam.sections[0].1, Section::Stiffness(_)) {
        beam = beam.mass_per_length(0.8);
        if random.below(2) == 0 {
            beam = beam.rotary([6e-4, 3e-4, 4e-4]);
        }
    }
    match random.below(3) {
        0 => beam.load(random.vector(1.0), false),
        1 => beam.load(random.vector(1.0), true),
        _ => beam,
    }
}

/// Beams on bodies on beams.
fn scene(random: &mut Random, conservative: bool) -> Arc<Model> {
    Model::build(&description(random, conservative)).expect("a sound scene")
}

/// Its bodies, the last of which is on a turn.
pub(super) fn description(random: &mut Random, conservative: bool) -> Description {
    let root = hinge(random);
    let body = HingeDescription::revolute(random.vector(1.0)).on("one", "tip");
    let first = beam(random, "one", root);
    let on_first = hinge(random).on("one", "mid");
    let second = beam(random, "two", on_first);
    let mut description = Description::new("Beams")
        .gravity(random.vector(1.0) * 9.0)
        .beam(first)
        .beam(second)
        .body(BodyDescription::new("bob", body).mass(0.4).center([0.1, 0.02, 0.05]).inertia([4e-3, 5e-3, 3e-3]));
    description = description.force(ForceDescription::load("dead", ("two", "tip"), random.vector(1.0)));
    if random.below(2) == 0 {
        let ends = (("two", "tip"), (GROUND, [0.4, 0.5, -0.3]));
        description = description.force(ForceDescription::spring("stay", ends.0, ends.1, 4.0, 0.3, 0.2));
    }
    if conservative {
        description.beams.iter_mut().filter_map(|beam| beam.load.as_mut()).for_each(|load| load.follows = false);
    }
    description
}

/// A scene in a state, in every other case with points that slide along its beams there: one of the ground, one of a body.
fn placed(random: &mut Random, seed: u64, conservative: bool) -> (Arc<Model>, [Vec<f64>; 3]) {
    let described = description(random, conservative);
    let model = Model::build(&described).expect("a sound scene");
    let state = state(random, &model);
    if seed.is_multiple_of(2) {
        return (model, state);
    }
    let mut system = System::new(&model);
    let at = system.at(0.0, &state[0], &state[1]);
    let links = &at.motion().links;
    let bob = &links[model.bodies[described.bodies.iter().position(|body| body.name == "bob").expect("it")].link];
    // Where the axis is bent much the middle of a chord is far from it, and other elements are as near.
    let mut beside = |beam: usize| {
        let elements = &model.beams[beam].elements;
        let link = elements[random.below(elements.len())].link;
        let [from, to] = [model.links[link].parent, link].map(|link| &links[link]);
        let chord = to.position - from.position;
        let bow = (from.turn.column(0) - to.turn.column(0)) * (chord.norm() / 8.0);
        from.position + 0.5 * chord + bow + random.vector(0.01)
    };
    // Where an element is bent by much its points may be nearest to others.
    for _ in 0..20 {
        let (on_ground, on_bob) = (beside(0), bob.turn.transpose() * (beside(1) - bob.position));
        let slid = described
            .clone()
            .force(ForceDescription::slider("of the ground", (GROUND, on_ground), "one", 40.0, 0.3))
            .force(ForceDescription::slider("of the bob", ("bob", on_bob), "two", 25.0, 0.2));
        let model = Model::build(&slid).expect("a sound scene");
        if model.forces.iter().filter(|force| force.name.starts_with("of the")).all(|force| force.law.pull(links) > 0.0)
        {
            return (model, state);
        }
    }
    (model, state)
}

/// Positions, velocities and accelerations in which elements turn and stretch by tenths.
pub(super) fn state(random: &mut Random, model: &Model) -> [Vec<f64>; 3] {
    let n = model.velocity_count();
    let mut by = vec![0.0; n];
    by.iter_mut().for_each(|x| *x = 0.3 * random.between(-1.0, 1.0));
    for link in model.links.iter().filter(|link| link.joint.is_flex()) {
        by[link.velocity..link.velocity + link.joint.counts().1].iter_mut().for_each(|x| *x *= 0.4);
    }
    let mut q = model.start_position.clone();
    System::displace(model, &mut q, &by);
    let mut some = |size: f64| (0..n).map(|_| size * random.between(-1.0, 1.0)).collect::<Vec<f64>>();
    [q, some(2.0), some(5.0)]
}

fn largest(list: impl IntoIterator<Item = f64>) -> f64 {
    list.into_iter().fold(0.0, |most, x| f64::max(most, x.abs()))
}

const CASES: u64 = 60;

/// Forward dynamics, then inverse dynamics: nothing is unbalanced. And M from inverse dynamics is symmetric, positive
/// definite, and what the mass action multiplies with; the kinetic energy is ½ vᵀ M v.
#[test]
fn accelerations_balance_and_the_mass_matrix_is_one() {
    for seed in 0..CASES {
        let mut random = Random::new(seed);
        let model = scene(&mut random, false);
        let [q, v, _] = state(&mut random, &model);
        let n = v.len();
        let mut system = System::new(&model);
        let (mut a, mut left, mut none) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        system.at(0.0, &q, &v).accelerations(&mut a).expect("no singular hinge");
        system.at(0.0, &q, &v).residual(&a, &mut left).expect("finite");
        system.at(0.0, &q, &v).residual(&vec![0.0; n], &mut none).expect("finite");
        let mut mass = DMatrix::zeros(n, n);
        for j in 0..n {
            let mut unit = vec![0.0; n];
            unit[j] = 1.0;
            let mut row = vec![0.0; n];
            system.at(0.0, &q, &v).residual(&unit, &mut row).expect("finite");
            (0..n).for_each(|i| mass[(i, j)] = row[i] - none[i]);
        }
        let scale = DVector::from_fn(n, |i, _| 1.0 / mass[(i, i)].sqrt());
        let scaled = DMatrix::from_fn(n, n, |i, j| scale[i] * mass[(i, j)] * scale[j]);
        assert!((&scaled - scaled.transpose()).amax() < 1e-6, "seed {seed}: M is not symmetric");
        assert!(((&scaled + scaled.transpose()) * 0.5).cholesky().is_some(), "seed {seed}: M is not definite");
        let work = |f: &[f64]| largest(f.iter().zip(&scale).map(|(f, s)| f * s));
        assert!(work(&left) < 1e-8 * (1.0 + work(&none)), "seed {seed}: {} of {}", work(&left), work(&none));
        let mut product = vec![0.0; n];
        let mut action = MassAction::new(&model);
        system.at(0.0, &q, &v).mass_times(&mut action, &v, &mut product);
        let dense = &mass * DVector::from_column_slice(&v);
        let off = largest(product.iter().zip(dense.iter()).zip(&scale).map(|((a, b), s)| (a - b) * s));
        assert!(off < 1e-6 * (1.0 + work(&none)), "seed {seed}: M v is off by {off}");
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
        let (model, [q, mut v, mut a]) = placed(&mut random, seed, false);
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
                let mut row = vec![0.0; n];
                system.at(0.0, &moved, &faster).residual(&sooner, &mut row).expect("finite");
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

/// At rest the balance is the gradient of the potential.
#[test]
fn the_balance_at_rest_is_the_gradient_of_the_potential() {
    for seed in 0..CASES {
        let mut random = Random::new(2000 + seed);
        let (model, [q, ..]) = placed(&mut random, seed, true);
        let n = model.velocity_count();
        let rest = vec![0.0; n];
        let mut system = System::new(&model);
        let mut force = vec![0.0; n];
        system.at(0.0, &q, &rest).residual(&rest, &mut force).expect("finite");
        let h = 1e-3;
        let scale = largest(force.iter().copied());
        for j in 0..n {
            let mut slope = 0.0;
            for (times, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
                let mut by = vec![0.0; n];
                by[j] = times * h;
                let mut moved = q.clone();
                System::displace(&model, &mut moved, &by);
                slope += weight / (12.0 * h) * system.at(0.0, &moved, &rest).energies().potential;
            }
            assert!((slope - force[j]).abs() < 1e-7 * scale, "seed {seed}, {j}: {slope} {}", force[j]);
        }
    }
}

/// Directions through the mid marker: a point of a beam is where its elements say.
#[test]
fn markers_are_on_the_centre_line() {
    let beam = BeamDescription::new("arc", HingeDescription::fixed())
        .shape(BeamShape::Arc { radius: 2.0, angle: 1.2 })
        .stiffness([1.0; 6])
        .mass_per_length(1.0)
        .marker("mid", 1.1);
    let model = Model::build(&Description::new("Arc").beam(beam)).expect("sound");
    let mut system = System::new(&model);
    let rest = vec![0.0; model.velocity_count()];
    let at = system.at(0.0, &model.start_position, &rest);
    let beam = &model.beams[0];
    for element in &beam.elements {
        let rod = &model.rods[element.rod];
        let angle = (element.from + rod.length) / 2.0;
        let expected = 2.0 * Vector3::new(angle.sin(), 1.0 - angle.cos(), 0.0);
        assert!((at.motion().links[element.link].position - expected).norm() < 1e-14);
    }
    assert!(beam.elements.iter().any(|element| (element.from - 1.1).abs() < 1e-12));
}

/// The linear equations about any state against differences of the accelerations; strains are states like hinge coordinates.
#[test]
fn linear_equations_match_differences_of_the_accelerations() {
    let mut compared = 0;
    for seed in 0..CASES {
        let mut random = Random::new(900 + seed);
        let model = scene(&mut random, false);
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
            system.at(0.0, &moved, &v).accelerations(&mut a).is_ok().then_some(a)
        };
        let step = 1e-5;
        let [none, by] = [vec![0.0; n], random.list(n, -step, step)];
        // A beam that ends in nothing may have a motion without inertia.
        if at(&none, &none).is_none_or(|a| largest(a) > 1e10) {
            continue;
        }
        let mut at = |by: &[f64], rate: &[f64]| at(by, rate).expect("no singular hinge");
        compared += 1;
        let found = linearize(&model, &place, &[], None).expect("the linear equations");
        assert_eq!((found.a.nrows(), found.states.len()), (2 * n, 2 * n), "seed {seed}");
        let back: Vec<f64> = by.iter().map(|x| -x).collect();
        for (first, [ahead, behind]) in
            [(0, [at(&by, &none), at(&back, &none)]), (n, [at(&none, &by), at(&none, &back)])]
        {
            let told = |i: usize| (0..n).map(|j| found.a[(n + i, first + j)] * by[j]).sum::<f64>();
            let size = largest((0..n).map(told));
            let apart = largest((0..n).map(|i| told(i) - 0.5 * (ahead[i] - behind[i])));
            assert!(apart < 1e-6 * size, "seed {seed}, {first}: {apart:e} of {size:e}");
        }
    }
    assert!(compared > 50, "{compared} scenes");
}

/// What a start file says of beams is what they start with, bit for bit.
#[test]
fn start_files_hold_strains_and_their_rates() {
    for seed in 0..CASES {
        let mut random = Random::new(2000 + seed);
        let description = description(&mut random, false);
        let model = Model::build(&description).expect("a sound scene");
        let [q, v, _] = state(&mut random, &model);
        let text = start::text(&model, &q, &v, &[], &[]);
        let started =
            start::parse_start("start.toml", &text, &description).unwrap_or_else(|why| panic!("{why}\n{text}"));
        assert_eq!((&started.model.start_position, &started.model.start_velocity), (&q, &v), "seed {seed}\n{text}");
        let short = text.replacen("[strains]\n\"one\" = [", "[strains]\n\"one\" = [0.5, ", 1);
        let refused = start::parse_start("start.toml", &short, &description).expect_err("a number too many");
        assert!(refused.to_string().contains("coordinates of strains, not"), "{refused}");
    }
}
