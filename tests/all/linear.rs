//! The linear equations about a place: against differences, against the damped modes, against equations by hand.

mod energies;

use crate::common::{Options, Random, build, random_scene};
use crate::scenarios::file;
use assert_cmd::Command;
use nalgebra::Point3;
use serde_json::Value;
use std::sync::Arc;
use stillpoint::constraint::assemble;
use stillpoint::dynamics::System;
use stillpoint::linear::{Input, Mat, Place, Signal, StateSpace, hold, linearize};
use stillpoint::model::Model;
use stillpoint::model::couplings::*;
use stillpoint::model::description::*;
use stillpoint::scenario::load;
use stillpoint::simulate::outputs::at_start;
use stillpoint::statics;

/// A random tree at rest with rods, a gear and a drive that fit its start, and outputs.
pub(crate) fn scene(seed: u64, tied: bool) -> Description {
    let options = Options { bodies: 3 + (seed as usize) % 5, springs: true, welds: false };
    let mut scene = random_scene(seed + 3000, &options);
    let mut random = Random::new(seed + 9);
    if tied {
        scene.bodies.iter_mut().for_each(|body| body.hinge.velocity.clear());
        let model = build(&scene);
        let mut poses = Vec::new();
        System::new(&model).at(0.0, &model.start_position, &model.start_velocity).poses(&mut poses);
        for index in 0..1 + seed as usize % 2 {
            let (a, at) = (random.below(options.bodies), [random.vector(0.3), random.vector(1.0)]);
            let points = [poses[a] * Point3::from(at[0]), Point3::from(at[1])];
            let length = (points[1] - points[0]).norm();
            scene = scene.closure(LoopDescription {
                name: format!("rod {index}"),
                closure: Closure::Rod { length },
                between: [
                    Attachment { body: format!("b{a}"), point: Point::At(at[0]) },
                    Attachment { body: GROUND.to_owned(), point: Point::At(at[1]) },
                ],
                frame: nalgebra::UnitQuaternion::identity(),
                second_frame: None,
            });
        }
        let scalars: Vec<String> = (scene.bodies.iter())
            .filter(|body| matches!(body.hinge.kind, HingeKind::Revolute { .. } | HingeKind::Prismatic { .. }))
            .map(|body| body.name.clone())
            .collect();
        if let Some(name) = scalars.first().filter(|_| seed.is_multiple_of(3)) {
            let coordinate = CoordinateName { body: name.clone(), index: 0 };
            scene = scene.drive(DriveDescription { name: "held".into(), coordinate, motion: MotionDescription::Hold });
        }
    }
    let tip = |body: &str| Attachment { body: body.to_owned(), point: Point::Marker("tip".to_owned()) };
    for (name, order) in [("x", Order::Position), ("v", Order::Velocity), ("a", Order::Acceleration)] {
        let of = QuantityDescription::Point { order, on: tip("b1"), axis: None, axes: Axes::Inertial };
        scene.outputs.push(OutputDescription::new(name, of));
    }
    let between = [tip("b0"), Attachment { body: GROUND.to_owned(), point: Point::At(random.vector(2.0)) }];
    scene.outputs.push(OutputDescription::new("d", QuantityDescription::Distance { between }));
    let first = scene.forces[0].name.clone();
    let of = QuantityDescription::Force { of: first, component: None };
    scene.outputs.push(OutputDescription::new("f", of));
    let text = "d * {v[1]} + {x[0]}^2".to_owned();
    scene.outputs.push(OutputDescription::new("e", QuantityDescription::Expression { text, unit: "m".into() }));
    // What is passed on.
    for (name, body, axes) in [("r", "b0", Axes::Inertial), ("s", "b1", Axes::Body)] {
        let of = QuantityDescription::Reaction { body: body.to_owned(), component: None, axes };
        scene.outputs.push(OutputDescription::new(name, of));
    }
    let rows: Vec<String> = (scene.loops.iter().map(|one| one.name.clone()))
        .chain(scene.drives.iter().map(|one| one.name.clone()))
        .collect();
    for of in rows {
        let name = format!("of {of}");
        scene.outputs.push(OutputDescription::new(&name, QuantityDescription::Force { of, component: None }));
    }
    let text = "{r[0]} * {s[4]} + {x[0]}".to_owned();
    scene.outputs.push(OutputDescription::new("p", QuantityDescription::Expression { text, unit: "N2".into() }));
    scene
}

/// The start of a model, as it stands.
fn start(model: &Model) -> Place {
    Place {
        time: 0.0,
        position: model.start_position.clone(),
        velocity: model.start_velocity.clone(),
        multipliers: None,
        held: Vec::new(),
        pressed: Vec::new(),
    }
}

/// Accelerations of the independent coordinates, and the outputs.
type Answer = (Vec<f64>, Vec<f64>);

/// The answer at a state given by independent steps.
fn answer(model: &Arc<Model>, found: &StateSpace, x: &[f64]) -> Answer {
    let count = x.len() / 2;
    let independent: Vec<usize> = (0..model.velocity_count())
        .filter(|at| found.states[..count].iter().any(|state| state.name == label(model, *at)))
        .collect();
    let (mut step, mut rate) = (vec![0.0; model.velocity_count()], model.start_velocity.clone());
    for (k, at) in independent.iter().enumerate() {
        (step[*at], rate[*at]) = (x[k], rate[*at] + x[count + k]);
    }
    let mut moved = model.clone();
    {
        let model = Arc::make_mut(&mut moved);
        let mut wanted = model.start_position.clone();
        System::displace(model, &mut wanted, &step);
        let mut system = System::new(&Arc::new(model.clone()));
        let (mut q, mut v) = (wanted.clone(), rate.clone());
        let is_given = |link: &&stillpoint::model::Link| {
            (0..link.joint.counts().1).any(|i| independent.contains(&(link.velocity + i)))
        };
        for _ in 0..8 {
            system.settle(0.0, &mut q, &mut v).unwrap();
            // What the independent coordinates have moved by, taken back along the closed positions.
            let mut back = vec![0.0; model.velocity_count()];
            for link in model.links.iter().filter(|link| is_given(link)) {
                let own = link.velocity..link.velocity + link.joint.counts().1;
                stillpoint::motion::relative(link, &q, &wanted, &mut back[own]);
            }
            follow(&mut system, &q, &independent, &mut back);
            System::displace(model, &mut q, &back);
            independent.iter().for_each(|at| v[*at] = rate[*at]);
            follow(&mut system, &q, &independent, &mut v);
        }
        (model.start_position, model.start_velocity) = (q, v);
    }
    let mut a = vec![0.0; model.velocity_count()];
    let mut system = System::new(&moved);
    system.at(0.0, &moved.start_position, &moved.start_velocity).accelerations(&mut a).unwrap();
    (independent.iter().map(|at| a[*at]).collect(), at_start(&moved, 0.0).unwrap())
}

/// Sets the dependent rates to those that the rows ask for beside the independent ones.
fn follow(system: &mut System, q: &[f64], independent: &[usize], rates: &mut [f64]) {
    let rows = system.at(0.0, q, &vec![0.0; rates.len()]).constraint_matrix();
    let dependent: Vec<usize> = (0..rates.len()).filter(|at| !independent.contains(at)).collect();
    assert_eq!(rows.nrows(), dependent.len());
    if dependent.is_empty() {
        return;
    }
    let matrix = nalgebra::DMatrix::from_fn(rows.nrows(), dependent.len(), |i, j| rows[(i, dependent[j])]);
    let felt = |i: usize| independent.iter().map(|at| rows[(i, *at)] * rates[*at]).sum::<f64>();
    let rhs = nalgebra::DVector::from_fn(rows.nrows(), |i, _| -felt(i));
    if let Some(answer) = matrix.lu().solve(&rhs) {
        dependent.iter().zip(answer.iter()).for_each(|(at, x)| rates[*at] = *x);
    }
}

fn label(model: &Model, velocity: usize) -> String {
    let body = &model.bodies[model.coordinates[velocity].body];
    let (index, plain) = (velocity - body.hinge.velocity, body.hinge.kind.plain_coordinates());
    match body.hinge.kind.positions().get(index).filter(|_| index < plain) {
        Some((name, _)) => format!("{}.{name}", body.name),
        None => format!("{}.turn[{}]", body.name, index - plain),
    }
}

/// `A` and `C` against central differences of order four on random scenes: moving trees, and rods, springs and drives at
/// rest. Steps of 5e-4 leave step⁴ times the fifth derivative, and 1e-12 of round-off.
#[test]
fn equations_are_those_of_differences() {
    let (mut scenes, mut worst): (usize, f64) = (0, 0.0);
    for (seed, tied) in (0..25).map(|seed| (seed, false)).chain((0..40).map(|seed| (seed, true))) {
        // Rods may hold what a drive should move: no such scene is made.
        let Ok((model, _)) = assemble(Model::build(&energies::with_energies(scene(seed, tied))).unwrap()) else {
            continue;
        };
        let found = match linearize(&model, &start(&model), &[], None) {
            Ok(found) => found,
            Err(error) => panic!("{seed} {tied}: {error}"),
        };
        let (n, count) = (found.a.nrows(), found.a.nrows() / 2);
        let rows: Vec<usize> = found
            .outputs
            .iter()
            .map(|signal| {
                model.outputs.iter().flat_map(|one| one.labels()).position(|name| name == signal.name).unwrap()
            })
            .collect();
        scenes += 1;
        for j in 0..n {
            let at = |h: f64| {
                let mut x = vec![0.0; n];
                x[j] = h;
                answer(&model, &found, &x)
            };
            const H: f64 = 5e-4;
            let [far_back, back, on, far_on] = [-2.0, -1.0, 1.0, 2.0].map(|k| at(k * H));
            let rate = |of: fn(&Answer) -> &Vec<f64>, i: usize| {
                let of = |pair| of(pair)[i];
                (8.0 * (of(&on) - of(&back)) - (of(&far_on) - of(&far_back))) / (12.0 * H)
            };
            let size = (0..count).map(|i| found.a[(count + i, j)].abs()).fold(10.0, f64::max);
            for i in 0..count {
                let error = (found.a[(count + i, j)] - rate(|pair| &pair.0, i)).abs() / size;
                assert!(
                    error < 1e-7,
                    "{seed} {tied}: A[{i}, {j}] {} for {}",
                    found.a[(count + i, j)],
                    rate(|p| &p.0, i)
                );
                worst = worst.max(error);
            }
            for (i, row) in rows.iter().enumerate() {
                let expected = rate(|pair| &pair.1, *row);
                let error = (found.c[(i, j)] - expected).abs() / size.max(expected.abs());
                assert!(
                    error < 1e-7,
                    "{seed} {tied}: C of {} by {}: {} for {expected}",
                    found.outputs[i].name,
                    found.states[j].name,
                    found.c[(i, j)]
                );
                worst = worst.max(error);
            }
        }
    }
    assert!(scenes >= 60, "{scenes}");
    println!("{scenes} scenes, worst {worst:.1e}");
}

/// `B` and `D` against what another force makes of accelerations and outputs: both are linear in it.
#[test]
fn inputs_are_felt_as_forces_are() {
    let mut checked = 0;
    for (seed, tied) in (0..20).flat_map(|seed| [(seed, false), (seed, true)]) {
        let mut description = energies::with_energies(scene(seed, tied));
        let on = Attachment { body: "b1".into(), point: Point::Marker("tip".into()) };
        let zero = nalgebra::Vector3::zeros();
        let axes = if seed % 2 == 0 { LoadAxes::Inertial } else { LoadAxes::Body };
        let load = Load { on, force: zero, torque: zero, axes, over_time: None };
        description.forces.push(ForceDescription { name: "push".into(), kind: load.into() });
        // The one is not felt, the other a product.
        description.outputs.retain(|output| !["f", "p"].contains(&output.name.as_str()));
        let model = build(&description);
        let velocities = description.bodies[0].hinge.kind.counts().1;
        let names = ["push.force", "push.torque", "b0.force"];
        let mut inputs = Vec::new();
        for name in names {
            inputs.extend(Input::find(&description, &model, name).unwrap());
        }
        assert_eq!(inputs.len(), 6 + velocities);
        let found = linearize(&model, &start(&model), &inputs, None).unwrap();
        energies::inputs_do_work(&found, &format!("{seed} {tied}"));
        let count = found.a.nrows() / 2;
        let x = vec![0.0; 2 * count];
        let (a, y) = answer(&model, &found, &x);
        for (j, input) in inputs.iter().enumerate() {
            let mut changed = description.clone();
            let parameter = stillpoint::model::Parameter::find(&changed, input.name()).unwrap().remove(0);
            let before = parameter.value(&changed);
            parameter.set(&mut changed, before + 1.0).unwrap();
            let (b, z) = answer(&build(&changed), &found, &x);
            let size = b.iter().zip(&a).map(|(b, a)| (b - a).abs()).fold(1e-3, f64::max);
            for i in 0..count {
                assert!(
                    (found.b[(count + i, j)] - (b[i] - a[i])).abs() < 1e-9 * size.max(a[i].abs()),
                    "{seed}: {}",
                    input.name()
                );
                assert_eq!(found.b[(i, j)], 0.0);
            }
            let of_scene = |signal: &&stillpoint::linear::Signal| !energies::counts_as_work(&signal.name);
            for (i, signal) in found.outputs.iter().enumerate().filter(|(_, signal)| of_scene(signal)) {
                let row =
                    model.outputs.iter().flat_map(|one| one.labels()).position(|name| name == signal.name).unwrap();
                let change = z[row] - y[row];
                assert!(
                    (found.d[(i, j)] - change).abs() < 1e-8 * (1.0 + change.abs() + z[row].abs()),
                    "{seed}: {} by {}",
                    signal.name,
                    input.name()
                );
                checked += 1;
            }
        }
    }
    assert!(checked > 1000, "{checked}");
}

fn of_equilibrium(model: &Model, found: &statics::Equilibrium) -> Place {
    Place {
        position: found.position.clone(),
        velocity: found.velocity.clone(),
        multipliers: Some(found.multipliers.clone()),
        held: (0..model.velocity_count()).filter(|at| model.coordinates[*at].lock).collect(),
        ..start(model)
    }
}

/// Every damped mode of the certificate is a pair of eigenvalues.
#[test]
fn eigenvalues_are_the_damped_modes() {
    let mut modes = 0;
    let mut check = |model: &Arc<Model>, settings: &statics::Settings, what: &str| {
        let Ok(found) = statics::equilibrium(model, settings, &model.start_position) else { return };
        let Some(stability) = found.stability.as_ref().filter(|_| found.converged && found.stops.is_empty()) else {
            return;
        };
        if found.velocity.iter().any(|v| *v != 0.0) || stability.damped.is_empty() || stability.neutral_directions > 0 {
            return;
        }
        let linear = linearize(model, &of_equilibrium(model, &found), &[], Some(&[]))
            .unwrap_or_else(|error| panic!("{what}: {error}"));
        let values = linear.eigenvalues();
        let largest = values.iter().map(|[re, im]| re.hypot(*im)).fold(0.0, f64::max);
        let least = stability.damped.len();
        assert!(values.len() <= 2 * least && values.len() >= least, "{what}: {} for {least}", values.len());
        for mode in &stability.damped {
            let root = [-mode.decay_rate, std::f64::consts::TAU * mode.frequency_hz];
            let apart = values.iter().map(|[re, im]| (re - root[0]).hypot(im - root[1])).fold(f64::INFINITY, f64::min);
            assert!(apart < 1e-9 * largest, "{what}: {root:?} is {apart:e} away from {values:?}");
            modes += 1;
        }
    };
    for (seed, tied) in (0..30).flat_map(|seed| [(seed, false), (seed, true)]) {
        let mut description = scene(seed, tied);
        description.bodies.iter_mut().for_each(|body| body.hinge.velocity.clear());
        check(&build(&description), &statics::Settings::default(), &format!("{seed} {tied}"));
    }
    for name in ["pendulum", "double_wishbone", "rope_over_pulleys", "spring_arm", "quarter_car", "stiff_chain"] {
        let scenario = load(&file(name)).unwrap();
        let (model, _) = assemble(Model::build(&scenario.description).unwrap()).unwrap();
        check(&model, &scenario.statics, name);
    }
    assert!(modes > 60, "{modes}");
}

/// A mass on a spring and damper whose other end is driven: `ẍ = −(k/m)(x − u) − (c/m)(ẋ − u̇)`, `ü` being the input.
#[test]
fn a_driven_base_is_felt_through_its_spring() {
    let text = r#"
        gravity = [0.0, 0.0, 0.0]
        [[body]]
        name = "base"
        mass = 5.0
        hinge = { type = "prismatic", axis = [1.0, 0.0, 0.0] }
        [[body]]
        name = "mass"
        mass = 2.0
        hinge = { type = "prismatic", axis = [1.0, 0.0, 0.0], position = 1.0 }
        [[force]]
        type = "spring"
        name = "spring"
        between = ["base", "mass"]
        stiffness = 50.0
        length = 1.0
        damping = 3.0
        [[drive]]
        name = "shake"
        hinge = "base"
        type = "hold"
        [[motor]]
        name = "hand"
        hinge = "mass"
        type = "input"
        [[output]]
        name = "pull"
        type = "force"
        of = "spring"
        [[output]]
        name = "shaken"
        type = "acceleration"
        of = "base"
        axis = [1.0, 0.0, 0.0]
        [[output]]
        name = "carried"
        type = "reaction"
        of = "mass"
        [[output]]
        name = "own"
        type = "force"
        of = "hand"
        [[output]]
        name = "tripled"
        type = "expression"
        expression = "3*pull"
        [[output]]
        name = "both"
        type = "expression"
        expression = "pull + own"
        [[output]]
        name = "foot"
        type = "reaction"
        of = "base"
        component = "fx"
        [[output]]
        name = "shaker"
        type = "force"
        of = "shake"
        [[output]]
        name = "spent"
        type = "power"
        of = "input"
        [[output]]
        name = "added"
        type = "energy"
        of = "input"
    "#;
    let scenario = stillpoint::scenario::parse("s.toml", text, &[]).unwrap();
    let model = build(&scenario.description);
    let find = |name| Input::find(&scenario.description, &model, name).unwrap().remove(0);
    let found = linearize(&model, &start(&model), &[find("shake"), find("hand")], None).unwrap();
    let names: Vec<&str> = found.states.iter().map(|state| state.name.as_str()).collect();
    assert_eq!(names, ["mass.distance", "shake.target", "d(mass.distance)/dt", "d(shake.target)/dt"]);
    assert_eq!(
        (found.dependent.as_slice(), found.left_out.as_slice()),
        (&["base.distance".to_owned()][..], &["own", "both", "added"].map(str::to_owned)[..])
    );
    let (k, c) = (50.0 / 2.0, 3.0 / 2.0);
    let a = [[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [-k, k, -c, c], [0.0; 4]];
    let b = [[0.0, 0.0], [0.0, 0.0], [0.0, 0.5], [1.0, 0.0]];
    // At rest without any force no power is of first order.
    // The hinge of the mass passes on what the motor in it pushes with; that of the base the spring and the inertia, as the drive does.
    let passed = [-50.0, 50.0, -3.0, 3.0];
    let carried = [[0.0; 4]; 6];
    let c_rows =
        [&[[50.0, -50.0, 3.0, -3.0], [0.0; 4]][..], &carried, &[[150.0, -150.0, 9.0, -9.0], passed, passed, [0.0; 4]]]
            .concat();
    let none = [0.0; 2];
    let d = [&[none, [1.0, 0.0], [0.0, 1.0]][..], &[none; 6], &[[5.0, 0.0]; 2], &[none]].concat();
    let near = |m: &Mat<f64>, rows: &[&[f64]]| {
        (0..m.nrows()).all(|i| (0..m.ncols()).all(|j| (m[(i, j)] - rows[i][j]).abs() < 1e-11))
    };
    assert!(near(&found.a, &a.each_ref().map(|row| &row[..])), "{:?}", found.a);
    assert!(near(&found.b, &b.each_ref().map(|row| &row[..])), "{:?}", found.b);
    assert!(near(&found.c, &c_rows.iter().map(|row| &row[..]).collect::<Vec<_>>()), "{:?}", found.c);
    assert!(near(&found.d, &d.iter().map(|row| &row[..]).collect::<Vec<_>>()), "{:?}", found.d);
    let asked = ["added".to_owned()];
    let error = linearize(&model, &start(&model), &[], Some(&asked)).expect_err("not known").to_string();
    assert!(error.contains("`added`"), "{error}");
    // The response to a swinging force, by the formula of the oscillator.
    let omega = 3.0;
    let response = found.response(omega)[(0, 1)];
    let (re, im) = (k - omega * omega, c * omega);
    let (size, scale) = (response.re.hypot(response.im), (50.0_f64.hypot(3.0 * omega)) * 0.5 / re.hypot(im));
    assert!((size - scale).abs() < 1e-12, "{size} for {scale}");
}

/// Held over a step: an undamped oscillator turns in its phase plane, a force bends it to `(1 − cos ωh)/ω²`.
#[test]
fn equations_from_step_to_step_are_exact() {
    let w = 7.0;
    let a = Mat::from_fn(2, 2, |i, j| [[0.0, 1.0], [-w * w, 0.0]][i][j]);
    let b = Mat::from_fn(2, 1, |i, _| [0.0, 1.0][i]);
    for h in [1e-4, 0.1, 3.0] {
        let (ad, bd) = hold(&a, &b, h);
        let (s, c) = (w * h).sin_cos();
        let expected = [[c, s / w], [-w * s, c]];
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            assert!((ad[(i, j)] - expected[i][j]).abs() < 1e-12 * w, "{h}");
        }
        assert!((bd[(0, 0)] - (1.0 - c) / (w * w)).abs() < 1e-13 && (bd[(1, 0)] - s / w).abs() < 1e-13, "{h}");
    }
}

#[test]
fn the_program_writes_what_it_finds() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = file("double_wishbone").display().to_string();
    let call = |arguments: &[&str]| {
        let answer =
            Command::new(env!("CARGO_BIN_EXE_stillpoint")).current_dir(folder.path()).args(arguments).output().unwrap();
        (answer.status.code(), String::from_utf8(answer.stdout).unwrap(), String::from_utf8(answer.stderr).unwrap())
    };
    let given = ["linearize", &scenario, "--input", "bump", "--output", "camber", "--output", "travel"];
    let (code, out, told) =
        call(&[&given[..], &["--json", "--out", "x.npz", "--bode", "x.svg", "--discretize", "0.01"]].concat());
    assert_eq!(code, Some(0), "{told}");
    let found: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((found["outputs"].as_array().unwrap().len(), found["inputs"][0].as_str()), (2, Some("bump")));
    let states = found["states"].as_array().unwrap().len();
    assert_eq!(found["A"].as_array().unwrap().len(), states);
    assert_eq!(found["C"][0].as_array().unwrap().len(), states);
    assert_eq!(found["units"]["outputs"][0], "rad");
    assert!(found["eigenvalues"].as_array().unwrap().len() == states && found["discrete"]["A"].is_array());
    let archive = std::fs::read(folder.path().join("x.npz")).unwrap();
    assert!(archive.starts_with(b"PK\x03\x04") && archive.windows(6).any(|part| part == b"\x93NUMPY"));
    let svg = std::fs::read_to_string(folder.path().join("x.svg")).unwrap();
    assert!(svg.contains("<svg") && svg.contains("size (units differ: see the names)"), "{svg}");
    assert_eq!(call(&[&given[..], &["--out", "x.mat", "--quiet"]].concat()).0, Some(0));
    let level_4 = std::fs::read(folder.path().join("x.mat")).unwrap();
    let word = |k: usize| u32::from_le_bytes(level_4[4 * k..4 * k + 4].try_into().unwrap()) as usize;
    assert_eq!([word(0), word(1), word(2), word(3), word(4)], [0, states, states, 0, 2]);
    for (arguments, message) in [
        (&["--input", "bumb"][..], "did you mean `bump`?"),
        (&["--output", "cambre"][..], "did you mean `camber`?"),
        (&["--out", "x.txt"][..], ".json, .npz or .mat"),
        (&["--output", "tyre", "--bode", "x.svg"][..], "needs an input and an output"),
        (&["--discretize", "-1"][..], "> 0"),
    ] {
        let (code, _, told) = call(&[&["linearize", &scenario], arguments].concat());
        assert!(code == Some(2) && told.contains(message), "{arguments:?}: {told}");
    }
    let (code, _, told) = call(&["linearize", &file("flyball_governor").display().to_string()]);
    assert!(code != Some(0) && told.contains("moves"), "{told}");
}

/// More curves than a plot shows are refused before the matrices are written.
#[test]
fn too_many_curves_leave_no_file_behind() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = "[[body]]\nname = \"m\"\nmass = 1.0\n\
        hinge = { type = \"prismatic\", axis = [1, 0, 0], stiffness = 10.0 }\n\
        [[motor]]\nname = \"push\"\nhinge = \"m\"\ntype = \"input\"\n"
        .to_owned();
    for k in 0..25 {
        text += &format!("[[output]]\nname = \"x{k}\"\ntype = \"position\"\nof = \"m\"\naxis = [1, 0, 0]\n");
    }
    std::fs::write(folder.path().join("scene.toml"), text).unwrap();
    let answer = Command::new(env!("CARGO_BIN_EXE_stillpoint"))
        .current_dir(folder.path())
        .args(["linearize", "scene.toml", "--out", "x.json", "--bode", "x.svg"])
        .output()
        .unwrap();
    let said = String::from_utf8(answer.stderr).unwrap();
    assert!(answer.status.code() == Some(2) && said.contains("24 curves at most, and these are 25"), "{said}");
    assert!(!folder.path().join("x.json").exists() && !folder.path().join("x.svg").exists());
}

/// What `linearize` says of a scene: exit code, answer, and what it notes.
fn told(text: &str, arguments: &[&str]) -> (Option<i32>, Value, String) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.toml"), text).unwrap();
    let answer = Command::new(env!("CARGO_BIN_EXE_stillpoint"))
        .current_dir(folder.path())
        .args(["linearize", "scene.toml", "--json"])
        .args(arguments)
        .output()
        .unwrap();
    let value = serde_json::from_slice(&answer.stdout).unwrap_or_default();
    (answer.status.code(), value, String::from_utf8(answer.stderr).unwrap())
}

const PENDULUM: &str = "[[body]]\nname = \"a\"\nmass = 1.0\ncenter = [0, 0, -1]\ninertia = [0.1, 0.1, 0.1]\nmarkers = { t = [0, 0, -1] }\n\
                        hinge = { type = \"revolute\", axis = [0, 1, 0], HINGE }\n";

/// An input that is asked for and that nothing feels is an error; of those that are taken without being asked for it is noted.
#[test]
fn inputs_that_nothing_feels_are_told() {
    let free = PENDULUM.replace(", HINGE", "");
    let locked = "[[body]]\nname = \"b\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
                  hinge = { type = \"revolute\", axis = [0, 1, 0], lock = true }\n\
                  [[motor]]\nname = \"u\"\ntype = \"input\"\nhinge = \"b\"\n";
    let (code, _, said) = told(&format!("{free}{locked}"), &["--input", "u"]);
    assert!(code == Some(2) && said.contains("nothing feels the input `u`"), "{said}");
    let (code, found, _) = told(&format!("{free}{locked}"), &[]);
    let notes = found["notes"].to_string();
    assert!(code == Some(0) && notes.contains("nothing feels the inputs `u`"), "{notes}");
    // Across the only motion there is.
    let load = "[[force]]\nname = \"l\"\ntype = \"load\"\non = \"a.t\"\nforce = [0, 1, 0]\n";
    let (code, _, said) = told(&format!("{free}{load}"), &["--input", "l.force[1]"]);
    assert!(code == Some(2) && said.contains("nothing feels the input `l.force[1]`"), "{said}");
    assert_eq!(told(&format!("{free}{load}"), &["--input", "l.force[0]"]).0, Some(0));
}

/// Where forces have a kink the equations are those of one side, and say so; next to it, and where forces are smooth, they do not.
#[test]
fn a_kink_is_told() {
    let free = PENDULUM.replace(", HINGE", "");
    let rope = |length: f64| {
        format!(
            "{free}[[force]]\ntype = \"rope\"\nthrough = [\"a.t\", {{ body = \"ground\", at = [1, 0, -1] }}]\nstiffness = 100.0\nlength = \
             {length}\n"
        )
    };
    let damper =
        PENDULUM.replace("HINGE", "damper = { curve = [[-1, -1], [0, 0], [1, SLOPE]], interpolation = \"linear\" }");
    let spring = PENDULUM.replace("HINGE", "stiffness = 1e7");
    for (text, kinks) in [
        (rope(1.0), true),
        (rope(1.001), false),
        (rope(0.9), false),
        (damper.replace("SLOPE", "3"), true),
        (damper.replace("SLOPE", "1"), false),
        (free.clone(), false),
        (spring, false),
    ] {
        let (code, found, said) = told(&text, &[]);
        assert_eq!(code, Some(0), "{said}");
        let notes = found["notes"].to_string();
        assert_eq!(notes.contains("forces have a kink here, which `a."), kinks, "{text}\n{notes}");
    }
    let stopped = PENDULUM.replace("HINGE", "limits = [0.0, 1.0]");
    let (_, found, _) = told(&stopped, &[]);
    assert!(found["notes"].to_string().contains("touches and bears next to nothing"), "{found}");
}

/// `linearize --response`: how far a mass on a spring and damper moves by one of its base, `(k + i c ω) / (k − m ω² + i c ω)`.
#[test]
fn responses_by_drives_are_transmissibilities() {
    let text = r#"
        gravity = [0.0, 0.0, 0.0]
        [[body]]
        name = "base"
        mass = 5.0
        hinge = { type = "prismatic", axis = [1.0, 0.0, 0.0] }
        [[body]]
        name = "mass"
        mass = 2.0
        hinge = { type = "prismatic", axis = [1.0, 0.0, 0.0], position = 1.0 }
        [[force]]
        type = "spring"
        name = "spring"
        between = ["base", "mass"]
        stiffness = 50.0
        length = 1.0
        damping = 3.0
        [[drive]]
        name = "shake"
        hinge = "base"
        type = "hold"
        [[output]]
        name = "place"
        type = "position"
        of = "mass"
        axis = [1.0, 0.0, 0.0]
    "#;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shaker.toml");
    std::fs::write(&path, text).unwrap();
    let call = |more: &[&str]| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_stillpoint"));
        let answer = program.arg("linearize").arg(&path).args(["--input", "shake"]).args(more).output().unwrap();
        (answer.status.success(), String::from_utf8_lossy(&answer.stdout).into_owned())
    };
    let (_, json) = call(&["--response", "0,0.5,3", "--json"]);
    let told: Value = serde_json::from_str(&json).unwrap();
    for (k, hz) in [0.0, 0.5, 3.0].into_iter().enumerate() {
        let one = &told["response"][k];
        let omega = std::f64::consts::TAU * hz;
        let (top, bottom) = ([50.0, 3.0 * omega], [50.0 - 2.0 * omega * omega, 3.0 * omega]);
        let size = f64::hypot(top[0], top[1]) / f64::hypot(bottom[0], bottom[1]);
        let phase = (top[1].atan2(top[0]) - bottom[1].atan2(bottom[0])).to_degrees();
        assert_eq!((&one["input"], &one["output"], &one["unit"]), (&"shake".into(), &"place".into(), &"1".into()));
        // At 0 Hz the target of the drive, a double integrator, cancels: the mass moves as far as the base.
        let amplitude = one["amplitude"].as_f64().expect("finite");
        assert!((amplitude - size).abs() < 1e-9 * size, "{hz} Hz: {amplitude} for {size}");
        assert!((one["phase_deg"].as_f64().unwrap() - phase).abs() < 1e-7, "{hz} Hz: {one}");
    }
    let (fine, text) = call(&["--response", "0.5"]);
    assert!(fine && text.contains("0.5 Hz  place by shake"), "{text}");
    assert!(!call(&["--response", "-2"]).0 && !call(&["--response", "1", "--output", "none"]).0);
}

/// At 0 Hz what follows the free cart grows without bound, and what does not has the limit of low frequencies: the cart cancels there.
#[test]
fn poles_and_zeros_cancel_at_no_frequency() {
    let answer = Command::new(env!("CARGO_BIN_EXE_stillpoint"))
        .args(["linearize", &file("balanced_cart").display().to_string(), "--json", "--response", "0,0.00001"])
        .output()
        .unwrap();
    let told: Value = serde_json::from_slice(&answer.stdout).unwrap();
    let all = told["response"].as_array().unwrap();
    let of =
        |output: &str, hz: f64| all.iter().find(|one| one["output"] == output && one["frequency_hz"] == hz).unwrap();
    for output in ["x", "speed"] {
        let one = of(output, 0.0);
        assert!(one["amplitude"].is_null() && one["note"] == "nothing holds it back", "{one}");
    }
    let (limit, low) =
        (of("angle", 0.0)["amplitude"].as_f64().unwrap(), of("angle", 1e-5)["amplitude"].as_f64().unwrap());
    // It changes with the square of the frequency over those of the pole, some 4 1/s: by 2e-10.
    assert!((limit / low - 1.0).abs() < 1e-9, "{limit} for {low}");
    assert_eq!(of("rate", 0.0)["amplitude"], 0.0);
}

/// Equations of one input, and outputs with unit coefficients of the states.
fn equations(a: &[&[f64]], b: &[f64], c: &[&[f64]]) -> StateSpace {
    let matrix = |rows: &[&[f64]]| Mat::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
    let signals = |count: usize| (0..count).map(|k| Signal { name: format!("{k}"), unit: "N".to_owned() }).collect();
    StateSpace {
        a: matrix(a),
        b: Mat::from_fn(b.len(), 1, |i, _| b[i]),
        c: matrix(c),
        d: Mat::zeros(c.len(), 1),
        states: signals(b.len()),
        inputs: signals(1),
        outputs: signals(c.len()),
        dependent: Vec::new(),
        left_out: Vec::new(),
        idle: Vec::new(),
        notes: Vec::new(),
    }
}

/// At the very frequency of an undamped oscillator what it moves is infinite, what it does not move is not, and nothing is NaN.
#[test]
fn a_resonance_is_infinite_and_no_nan() {
    let oscillator: [&[f64]; 3] = [&[0.0, 1.0, 0.0], &[-4.0, 0.0, 0.0], &[0.0, 0.0, -2.0]];
    let found = equations(&oscillator, &[0.0, 1.0, 1.0], &[&[1.0, 0.0, 0.0], &[0.0, 0.0, 1.0]]).response(2.0);
    let (swings, decays) = (found[(0, 0)], found[(1, 0)]);
    assert!(swings.norm() == f64::INFINITY && !swings.re.is_nan() && !swings.im.is_nan(), "{swings}");
    // 1/(2i + 2)
    assert!((decays.re - 0.25).abs() < 1e-14 && (decays.im + 0.25).abs() < 1e-14, "{decays}");
}

/// Two bodies on a stiff spring, free together: pushed steadily they run away, and the spring is `f m₂/(m₁ + m₂)/k` shorter.
#[test]
fn what_drifts_as_a_whole_has_finite_strains() {
    let (k, m) = (1e8, [2.0, 3.0]);
    let a: [&[f64]; 4] = [
        &[0.0, 0.0, 1.0, 0.0],
        &[0.0, 0.0, 0.0, 1.0],
        &[-k / m[0], k / m[0], 0.0, 0.0],
        &[k / m[1], -k / m[1], 0.0, 0.0],
    ];
    let found =
        equations(&a, &[0.0, 0.0, 1.0 / m[0], 0.0], &[&[1.0, -1.0, 0.0, 0.0], &[1.0, 0.0, 0.0, 0.0]]).response(0.0);
    let expected = m[1] / (m[0] + m[1]) / k;
    // The null space is found to some units in the last place, of states that differ by a thousand in size.
    assert!((found[(0, 0)].re / expected - 1.0).abs() < 1e-9, "{} for {expected}", found[(0, 0)]);
    // 1/s² is negative along the imaginary axis.
    assert_eq!(found[(1, 0)].re, f64::NEG_INFINITY);
}

/// A step over which the equations overflow is refused with the step and what grows.
#[test]
fn a_step_that_overflows_is_refused() {
    let answer = Command::new(env!("CARGO_BIN_EXE_stillpoint"))
        .args(["linearize", &file("balanced_cart").display().to_string(), "--json", "--discretize", "1000"])
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&answer.stderr).into_owned();
    assert!(!answer.status.success() && answer.stdout.is_empty(), "{error}");
    assert!(error.contains("over a step of 1000 s") && error.contains("fastest growing eigenvalue is 4.1"), "{error}");
}

/// `drive[0]` is the first drive, whatever it is called.
#[test]
fn inputs_are_found_by_place() {
    let scenario = load(&file("double_wishbone")).unwrap();
    let model = Model::build(&scenario.description).unwrap();
    let find = |name| Input::find(&scenario.description, &model, name);
    assert_eq!(find("drive[0]").unwrap(), find("bump").unwrap());
    let error = find("drive[7]").unwrap_err().to_string();
    assert!(error.contains("`drive[7]`: the scene has 1 drive"), "{error}");
}
/// The stress near the root of a cantilever with all strains that is bent, twisted and pulled, on a stiff spring or a soft one: the corner of the
/// section that has most of it changes within what it is bent by. Against equilibria under other loads.
#[test]
fn stresses_of_beams_follow_their_loads() {
    let scene = |young: f64, free: &str, push: f64| {
        let text = format!(
            "[[beam]]\nname = \"b\"\nlength = 1.0\nelements = 2\nsection = {{ rectangle = [0.03, 0.01] }}\nmaterial = {{ young = {young:?}, poisson = 0.3, \
             density = 2700.0 }}\nfree = {free}\nhinge = {{ type = \"revolute\", axis = [0, 1, 0], stiffness = 60.0 }}\n[[force]]\ntype = \
             \"load\"\nname = \"l\"\non = \"b\"\nforce = [0.3, 0.2, {push:?}]\n[[output]]\nname = \"stress\"\ntype = \"section\"\nof = \"b\"\ns = 0.1\ncomponent \
             = \"stress\"\n"
        );
        let scenario =
            stillpoint::scenario::parse("beam.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
        let model = build(&scenario.description);
        let rest = statics::equilibrium(&model, &scenario.statics, &model.start_position).expect("statics");
        assert!(rest.converged, "{:?}", rest.notes);
        (scenario.description, model, rest.position)
    };
    for young in [70e9, 70e6] {
        for free in ["[\"bend\"]", "[\"bend\", \"stretch\"]", "[\"bend\", \"twist\", \"stretch\", \"shear\"]"] {
            let (description, model, q) = scene(young, free, -0.5);
            let place = Place { position: q, ..start(&model) };
            let input = Input::find(&description, &model, "l.force[2]").unwrap().remove(0);
            let found = linearize(&model, &place, &[input], None).unwrap();
            assert!(found.left_out.is_empty(), "{young:e} {free}: {:?}", found.notes);
            let n = found.a.nrows();
            let a = nalgebra::DMatrix::from_fn(n, n, |i, j| found.a[(i, j)]);
            let x = a.lu().solve(&nalgebra::DVector::from_fn(n, |i, _| found.b[(i, 0)])).expect("a state at rest");
            let gain = found.d[(0, 0)] - (0..n).map(|j| found.c[(0, j)] * x[j]).sum::<f64>();
            let stress = |by: f64| {
                let (_, model, q) = scene(young, free, -0.5 + by);
                let there = Model { start_position: q, ..Model::clone(&model) };
                at_start(&Arc::new(there), 0.0).expect("numbers")[0]
            };
            let expected = (stress(1e-5) - stress(-1e-5)) / 2e-5;
            assert!((gain / expected - 1.0).abs() < 1e-6, "{young:e} {free}: {gain} {expected}");
        }
    }
}

/// Where a formula has a kink or a jump it has no slope; beside it, and where it only bends, it has.
#[test]
fn formulas_have_no_slope_at_their_kinks() {
    for (formula, at, slope) in [
        ("abs(x)", 0.0, None),
        ("max(x, 0)", 0.0, None),
        ("floor(x)", 1.0, None),
        ("sqrt(x*x)", 0.0, None),
        ("abs(x - 1) + 1000", 1.0, None),
        ("abs(x)", 0.3, Some(1.0)),
        ("x^2", 0.0, Some(0.0)),
        ("abs(x)^3", 0.0, Some(0.0)),
        ("if(abs(x) > 0.1, x, 0)", 0.0, Some(0.0)),
        ("exp(5*x) + 1000", 0.0, Some(5.0)),
    ] {
        let text = format!(
            "gravity = [0, 0, 0]\n[[body]]\nname = \"a\"\nmass = 1.0\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0], position = {at:?} }}\n[[output]]\nname =              \"x\"\ntype = \"coordinate\"\nof = \"a\"\n[[output]]\nname = \"y\"\ntype = \"expression\"\nexpression = \"{formula}\"\n[[output]]\nname =              \"z\"\ntype = \"expression\"\nexpression = \"2*y\"\n"
        );
        let scenario =
            stillpoint::scenario::parse("kink.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
        let model = build(&scenario.description);
        let found = linearize(&model, &start(&model), &[], None).unwrap();
        let left_out: Vec<&str> = found.left_out.iter().map(String::as_str).collect();
        match slope {
            None => assert_eq!(left_out, ["y", "z"], "{formula} at {at}"),
            Some(slope) => {
                assert!(left_out.is_empty(), "{formula} at {at}: {left_out:?}");
                assert!((found.c[(1, 0)] - slope).abs() < 1e-12 && (found.c[(2, 0)] - 2.0 * slope).abs() < 1e-12);
            }
        }
    }
}
