//! Bodies guided along curves: against their poses, against differences, against closed forms.

use crate::common::{Options, Random, build, random_scene, relative_difference};
use crate::derivatives::difference;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;
use stillpoint::dynamics::{Coefficients, System, TangentSolver};
use stillpoint::model::Model;
use stillpoint::model::description::{
    AlongTurn, BodyDescription, Description, GuideCurve, HingeDescription, HingeKind, Point,
};
use stillpoint::model::stop::{LimitDescription, StopLaw};
use stillpoint::record::Fanout;
use stillpoint::scenario;
use stillpoint::simulate::{self, Settings, State, Summary};
use stillpoint::spatial::Pose;
use stillpoint::statics::{self, Equilibrium, equilibrium};

mod gaps;

fn curve(random: &mut Random) -> GuideCurve {
    match random.below(4) {
        0 => GuideCurve::Straight { length: random.between(2.0, 3.0) },
        1 => {
            let mut at = random.vector(0.3);
            let mut next = |random: &mut Random| {
                at += Vector3::new(random.between(0.3, 0.9), random.between(-0.4, 0.4), random.between(-0.4, 0.4));
                at
            };
            let count = 5 + random.below(6);
            GuideCurve::Points { points: (0..count).map(|_| next(random)).collect() }
        }
        2 => GuideCurve::Helix {
            radius: random.between(0.2, 1.0),
            pitch: random.between(-0.5, 0.5),
            turns: random.between(1.5, 3.0),
        },
        _ => {
            let [a, b, c] = [0; 3].map(|_| random.between(-1.0, 1.0));
            let place = [format!("v + {a}*sin(v)/2"), format!("{b}*v**2 + exp(-v)"), format!("{c}*cos(2*v)")];
            GuideCurve::Formulas { parameter: "v".to_owned(), place, range: [0.0, random.between(2.0, 3.0)] }
        }
    }
}

fn turn(random: &mut Random) -> AlongTurn {
    [AlongTurn::Follows, AlongTurn::Held, AlongTurn::Free][random.below(3)]
}

/// A random scene in which about every second hinge goes along a curve, and at least one.
fn scene(seed: u64, options: &Options) -> Description {
    let mut description = random_scene(seed + 70_000, options);
    let mut random = Random::new(seed + 71_000);
    for (index, body) in description.bodies.iter_mut().enumerate() {
        if index > 0 && random.below(2) == 0 {
            continue;
        }
        let mut hinge = HingeDescription::along(curve(&mut random), turn(&mut random));
        hinge.parent.clone_from(&body.hinge.parent);
        (hinge.at, hinge.frame) = (Point::At(random.vector(0.5)), random.turn());
        let n = hinge.kind.counts().1;
        hinge.position = vec![random.between(0.4, 1.2), random.between(-1.0, 1.0)][..n].to_vec();
        hinge.velocity = random.list(n, -2.0, 2.0);
        hinge.force = random.list(n, -1.0, 1.0);
        if options.springs {
            hinge.stiffness = random.list(n, 0.0, 5.0);
            hinge.damping = random.list(n, 0.0, 1.0);
            hinge.armature = random.list(n, 0.0, 0.5);
            hinge.rest = random.list(n, -1.0, 1.0);
        }
        body.hinge = hinge;
    }
    description
}

fn scenes() -> impl Iterator<Item = (u64, Description)> {
    let options =
        |seed: u64| Options { bodies: 1 + (seed as usize * 7) % 11, springs: !seed.is_multiple_of(3), welds: true };
    (0..90).map(move |seed| (seed, scene(seed, &options(seed))))
}

/// Accelerations, independently: with nothing but the poses of all bodies, differentiated numerically, the principle of
/// d'Alembert holds for every coordinate. Differences of fourth order leave some 1e-8.
#[test]
fn accelerations_agree_with_the_poses_alone() {
    for seed in 0..60 {
        let options = Options { bodies: 1 + (seed as usize * 5) % 8, springs: false, welds: true };
        let mut description = scene(seed, &options);
        description.forces.clear();
        let model = build(&description);
        let (q, v, n) = (&model.start_position, &model.start_velocity, model.velocity_count());
        let mut a = vec![0.0; n];
        let mut system = System::new(&model);
        system.at(0.0, q, v).accelerations(&mut a).unwrap();
        let mut poses = |step: &dyn Fn(usize) -> f64| -> Vec<Pose> {
            let by: Vec<f64> = (0..n).map(step).collect();
            let (mut moved, mut poses) = (q.clone(), Vec::new());
            System::displace(&model, &mut moved, &by);
            system.at(0.0, &moved, &vec![0.0; n]).poses(&mut poses);
            poses
        };
        let h = 1e-3;
        let times = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|k| k * h);
        let along = times.map(|t| poses(&|i| v[i] * t + 0.5 * a[i] * t * t));
        let by_coordinate: Vec<[Vec<Pose>; 5]> =
            (0..n).map(|j| times.map(|t| poses(&|i| if i == j { t } else { 0.0 }))).collect();
        for j in 0..n {
            let (mut sum, mut size) = (0.0, 1.0);
            for (index, body) in model.bodies.iter().enumerate() {
                let (m, c) = (body.mass.mass, body.mass.center);
                let place =
                    |all: &[Vec<Pose>; 5], k: usize| all[k][index].rotation * c + all[k][index].translation.vector;
                let turn = |all: &[Vec<Pose>; 5], k: usize| *all[k][index].rotation.to_rotation_matrix().matrix();
                let now = turn(&along, 2);
                let axial = |x: Matrix3<f64>| {
                    let s = x * now.transpose();
                    0.5 * Vector3::new(s.m32 - s.m23, s.m13 - s.m31, s.m21 - s.m12)
                };
                let way = first(&|k| place(&by_coordinate[j], k), h);
                let spin = axial(first(&|k| turn(&by_coordinate[j], k), h));
                let acceleration = second(&|k| place(&along, k), h);
                let angular = axial(second(&|k| turn(&along, k), h));
                let w = axial(first(&|k| turn(&along, k), h));
                let inertia = now * body.mass.inertia * now.transpose();
                let force = m * (acceleration - model.gravity);
                let moment = inertia * angular + w.cross(&(inertia * w));
                sum += force.dot(&way) + moment.dot(&spin);
                size += force.norm() * way.norm() + moment.norm() * spin.norm();
            }
            let expected = model.coordinates[j].force;
            assert!((sum - expected).abs() < 1e-6 * size, "seed {seed} {}: {sum} {expected} {size}", model.label(j));
        }
    }
}

fn first<T: std::ops::Sub<Output = T> + std::ops::Mul<f64, Output = T>>(of: &dyn Fn(usize) -> T, h: f64) -> T {
    ((of(3) - of(1)) * 8.0 - (of(4) - of(0))) * (1.0 / (12.0 * h))
}

fn second<T>(of: &dyn Fn(usize) -> T, h: f64) -> T
where
    T: std::ops::Sub<Output = T> + std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>,
{
    ((of(3) + of(1)) * 16.0 - (of(4) + of(0)) - of(2) * 30.0) * (1.0 / (12.0 * h * h))
}

/// Stiffness, damping, the Jacobians of accelerations: those of differences, at accelerations and velocities of any size.
#[test]
fn derivatives_are_those_of_differences() {
    for (seed, description) in scenes() {
        let model = build(&description);
        let n = model.velocity_count();
        let a = Random::new(seed + 1000).list(n, -3.0, 3.0);
        let mut system = System::new(&model);
        let (q, v) = (&model.start_position, &model.start_velocity);
        let found = system.at(0.0, q, v).linearize(&a).unwrap();
        let (by_position, by_velocity) = system.at(0.0, q, v).acceleration_jacobians().unwrap();
        for (of_position, matrix, jacobian) in
            [(true, &found.stiffness, &by_position), (false, &found.damping, &by_velocity)]
        {
            let (mut columns, mut differences) = ([Vec::new(), Vec::new()], [Vec::new(), Vec::new()]);
            for j in 0..n {
                columns[0].extend((0..n).map(|i| matrix[(i, j)]));
                columns[1].extend((0..n).map(|i| jacobian[(i, j)]));
                differences[0].extend(difference(&model, of_position, j, |q, v| {
                    let mut residual = vec![0.0; n];
                    system.at(0.0, q, v).residual(&a, &mut residual).unwrap();
                    residual
                }));
                differences[1].extend(difference(&model, of_position, j, |q, v| {
                    let mut a = vec![0.0; n];
                    system.at(0.0, q, v).accelerations(&mut a).unwrap();
                    a
                }));
            }
            for (found, expected) in columns.iter().zip(&differences) {
                // Where nothing depends on it, round-off over the step is left.
                let size = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
                let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(apart < 1e-6 * size, "seed {seed} position {of_position}: {apart} of {size}");
            }
        }
    }
}

/// The tangent that sweeps solve is the dense one, at rest, with the mass matrix and in motion.
#[test]
fn the_tangent_sweep_solves_the_dense_tangent() {
    use faer::linalg::solvers::Solve;
    for (seed, description) in scenes() {
        let model = build(&description);
        let n = model.velocity_count();
        let mut random = Random::new(seed + 2000);
        let (a, rhs, zero) = (random.list(n, -3.0, 3.0), random.list(n, -1.0, 1.0), vec![0.0; n]);
        let mut system = System::new(&model);
        let mut solver = TangentSolver::new(&model);
        let (q, v) = (&model.start_position, &model.start_velocity);
        let cases = [(&zero, &zero, 0.0, 0.0, 5.0), (&zero, &zero, 0.0, 7.0, 0.0), (v, &a, 20.0, 400.0, 0.0)];
        for (v, a, c1, c2, shift) in cases {
            let dense = system.at(0.0, q, v).linearize(a).unwrap();
            let mut matrix = &dense.stiffness + &dense.damping * c1 + &dense.mass * c2;
            (0..n).for_each(|i| matrix[(i, i)] += shift);
            let b = faer::Mat::from_fn(n, 1, |i, _| rhs[i]);
            let solved = matrix.partial_piv_lu().solve(&b);
            let expected: Vec<f64> = (0..n).map(|i| solved[(i, 0)]).collect();
            let shift = vec![shift; n];
            let with = Coefficients { c1, c2, shift: &shift, ..Coefficients::default() };
            assert!(system.at(0.0, q, v).factorize_tangent(&mut solver, a, &with).unwrap(), "seed {seed}");
            let mut x = rhs.clone();
            solver.solve(&mut x);
            let error = relative_difference(&x, &expected);
            // Elimination without pivoting in an indefinite matrix loses digits, as for other hinges.
            assert!(error < 1e-6, "seed {seed} c1 {c1} c2 {c2}: {error}");
        }
    }
}

fn bead(curve: GuideCurve) -> BodyDescription {
    BodyDescription::new("bead", HingeDescription::along(curve, AlongTurn::Held)).mass(0.3)
}

fn heavy(bead: BodyDescription) -> Description {
    Description::new("bead").gravity([0.0, 0.0, -9.81]).body(bead)
}

fn formulas(x: &str, y: &str, z: &str, range: [f64; 2]) -> GuideCurve {
    GuideCurve::Formulas { parameter: "u".to_owned(), place: [x, y, z].map(str::to_owned), range }
}

fn run(model: &Arc<Model>, duration: f64, state: &State) -> Result<Summary, String> {
    let settings = Settings { duration, tolerance: 1e-11, absolute_tolerance: 1e-13, ..Settings::default() };
    simulate::run(model, &settings, 1.0, state, &mut Fanout::new(), &mut |_, _| true).map_err(|error| error.to_string())
}

/// On a cycloid the arc length oscillates harmonically, however far: `s̈ = −g/(4a) s`, the tautochrone of Huygens.
#[test]
fn a_bead_on_a_cycloid_swings_harmonically() {
    for seed in 0..20 {
        let random = &mut Random::new(seed);
        let a = random.between(0.1, 2.0);
        let description =
            heavy(bead(formulas(&format!("{a}*(u + sin(u))"), "0", &format!("{a}*(1 - cos(u))"), [-3.0, 3.0])));
        let model = build(&description);
        let (s, pace) = (4.0 * a * random.between(-0.95, 0.95), (9.81 / (4.0 * a)).sqrt());
        let time = random.between(3.0, 20.0) / pace;
        let found = run(&model, time, &State { position: vec![s], velocity: vec![0.0] }).unwrap();
        let apart = (found.state.position[0] - s * (pace * time).cos()).abs();
        assert!(apart < 1e-9 * a, "seed {seed}: {apart}");
    }
}

/// On a parabola `z = x²/(2p)` the first integral gives the speed at the bottom, and the frequency of small swings is
/// `√(g/p)/2π`.
#[test]
fn a_bead_on_a_parabola_keeps_its_first_integral() {
    for seed in 0..20 {
        let random = &mut Random::new(seed);
        let p = random.between(0.2, 3.0);
        let description = heavy(bead(formulas("u", "0", &format!("u^2/(2*{p})"), [-4.0, 4.0])));
        let model = build(&description);
        // Arc length of x: ½ (x √(1 + x²/p²) + p asinh(x/p)).
        let length = |x: f64| 0.5 * (x * (1.0 + (x / p).powi(2)).sqrt() + p * (x / p).asinh());
        let x = random.between(0.3, 3.0);
        let start = State { position: vec![length(x)], velocity: vec![0.0] };
        let found = run(&model, random.between(1.0, 5.0), &start).unwrap();
        let (q, v) = (found.state.position[0], found.state.velocity[0]);
        let mut poses = Vec::new();
        System::new(&model).at(0.0, &[q], &[v]).poses(&mut poses);
        let at = poses[0].translation.vector;
        assert!((at.z - at.x * at.x / (2.0 * p)).abs() < 1e-13 && (length(at.x) - q).abs() < 1e-12, "seed {seed}");
        let energy = 0.5 * v * v + 9.81 * at.z;
        assert!((energy - 9.81 * x * x / (2.0 * p)).abs() < 1e-9 * energy, "seed {seed}: {energy}");
        let rest = equilibrium(&model, &statics::Settings::default(), &[0.3]).unwrap();
        assert!(rest.converged && rest.position[0].abs() < 1e-9, "seed {seed}: {:?}", rest.position);
        let frequency = rest.stability.unwrap().modes[0].frequency_hz;
        let expected = (9.81 / p).sqrt() / std::f64::consts::TAU;
        assert!((frequency - expected).abs() < 1e-9 * expected, "seed {seed}: {frequency} {expected}");
    }
}

/// The train of the scenario: however many cars, the mean of their arc lengths, by mass, swings as one bead.
#[test]
fn a_train_swings_as_a_bead() {
    let (scenario, model) = crate::scenarios::shipped("train_in_a_valley", &[]);
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let found = simulate::run(&model, &scenario.simulate, 1.0, &start, &mut Fanout::new(), &mut |_, _| true).unwrap();
    let mean = |q: &[f64]| {
        let masses = model.bodies.iter().map(|body| body.mass.mass);
        masses.clone().zip(q).map(|(m, s)| m * s).sum::<f64>() / masses.sum::<f64>()
    };
    let pace = (9.80665 / 80.0_f64).sqrt();
    let expected = mean(&start.position) * (pace * scenario.simulate.duration).cos();
    let apart = (mean(&found.state.position) - expected).abs();
    assert!(apart < 1e-7 * expected.abs(), "{apart} of {expected}");
    let rest = equilibrium(&model, &scenario.statics, &start.position).unwrap();
    assert!(rest.converged && mean(&rest.position).abs() < 1e-8, "{:?}", rest.position);
    let frequency = rest.stability.unwrap().modes[0].frequency_hz;
    let expected = pace / std::f64::consts::TAU;
    assert!((frequency - expected).abs() < 1e-8 * expected, "{frequency} {expected}");
}

/// Without damping and loads energy stays; with them the ledger has it all.
#[test]
fn energy_stays_in_random_scenes() {
    for seed in 0..24 {
        let options = Options { bodies: 1 + (seed as usize) % 5, springs: true, welds: false };
        let mut description = scene(seed, &options);
        for body in &mut description.bodies {
            let limits = |range: [f64; 2]| LimitDescription {
                coordinate: 0,
                low: range[0],
                high: range[1],
                law: StopLaw::Compliant { stiffness: 300.0, damping: 0.5 },
            };
            if matches!(body.hinge.kind, HingeKind::Along { .. }) {
                body.hinge.limits.push(limits([0.3, 1.3]));
            }
        }
        let model = build(&description);
        let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
        let settings = Settings { duration: 0.5, tolerance: 1e-10, ..Settings::default() };
        let found = simulate::run(&model, &settings, 1.0, &start, &mut Fanout::new(), &mut |_, _| true);
        let found = match found {
            Ok(found) => found,
            // A compliant stop near the end of a curve may be too soft.
            Err(error) if error.to_string().contains("leaves its curve") => continue,
            Err(error) => panic!("seed {seed}: {error}"),
        };
        let size = found.energy_start.abs() + found.work.abs() + found.dissipated.abs() + 1.0;
        assert!(found.energy_drift < 1e-7 * size, "seed {seed}: {} of {size}", found.energy_drift);
    }
}

/// At the end of a straight curve on a slope: the time is that of the fall, and nothing goes on from there.
#[test]
fn the_end_of_a_curve_ends_the_run_by_name_and_time() {
    for seed in 0..20 {
        let random = &mut Random::new(seed);
        let (length, slope) = (random.between(0.1, 5.0), random.between(0.1, 1.5));
        let mut bead = bead(GuideCurve::Straight { length });
        bead.hinge.frame = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::y_axis(), slope);
        let model = build(&heavy(bead.clone()));
        let start = State { position: vec![0.0], velocity: vec![0.0] };
        let fall = 9.81 * slope.sin();
        let time = (2.0 * length / fall).sqrt();
        let error = run(&model, 2.0 * time, &start).expect_err("the end is reached");
        let said: f64 = error.strip_prefix("at t = ").and_then(|rest| rest.split(' ').next()).unwrap().parse().unwrap();
        assert!(error.contains("open = [\"bead\"]") && error.contains("[[stage]]"), "{error}");
        assert!(error.contains("`bead` leaves its curve") && (said - time).abs() < 1e-5 * time, "{error} {time}");
        assert!(run(&model, 0.999 * time, &start).is_ok());
        // A rigid stop there turns it round.
        let law = StopLaw::Rigid { restitution: 0.5 };
        bead.hinge.limits.push(LimitDescription { coordinate: 0, low: 0.0, high: length, law });
        let found = run(&build(&heavy(bead)), 1.5 * time, &start).unwrap();
        let back = 0.5 * fall * time * 0.5 * time - 0.5 * fall * 0.25 * time * time;
        assert!((found.state.position[0] - (length - back)).abs() < 1e-8 * length, "{:?}", found.state);
    }
}

/// A body that rests nowhere on its curve is no equilibrium.
#[test]
fn statics_does_not_leave_a_curve() {
    let model = build(&heavy(bead(formulas("u", "0", "-u^2", [-1.0, 1.0]))));
    let found = equilibrium(&model, &statics::Settings::default(), &[0.2]).unwrap();
    let says = |found: &Equilibrium| found.notes.iter().any(|note| note.contains("`bead` rests nowhere on its curve"));
    assert!(!found.converged && says(&found), "{found:?}");
    assert!(!found.notes.iter().any(|note| note.contains("falls without end")), "{found:?}");
    // A load in space that the straight way beyond the end would balance, but the curve does not.
    let mut pulled = bead(formulas("u", "0", "u^2", [-1.0, 1.0]));
    pulled.hinge.stiffness = vec![1.0];
    pulled.hinge.rest = vec![60.0];
    let found = equilibrium(&build(&heavy(pulled)), &statics::Settings::default(), &[0.2]).unwrap();
    assert!(!found.converged && says(&found), "{found:?}");
}

/// A body on a helix with `turn = "free"` and one that follows: turns about the tangent are free in the one alone.
#[test]
fn a_free_turn_is_a_coordinate_of_its_own() {
    let helix = GuideCurve::Helix { radius: 0.5, pitch: 0.2, turns: 2.0 };
    let [follows, free] = [AlongTurn::Follows, AlongTurn::Free].map(|turn| {
        let body =
            BodyDescription::new("ball", HingeDescription::along(helix.clone(), turn)).mass(1.0).inertia([0.1; 3]);
        build(&heavy(body))
    });
    for s in [0.3, 1.7, 4.0] {
        let pose = |model: &Arc<Model>, q: &[f64]| {
            let mut poses = Vec::new();
            System::new(model).at(0.0, q, &vec![0.0; q.len()]).poses(&mut poses);
            poses[0]
        };
        let (one, other) = (pose(&follows, &[s]), pose(&free, &[s, 0.7]));
        assert!((one.translation.vector - other.translation.vector).norm() < 1e-14);
        let turn = (one.rotation.inverse() * other.rotation).scaled_axis();
        assert!((turn - Vector3::new(0.7, 0.0, 0.0)).norm() < 1e-12, "{turn}");
    }
}

fn said(hinge: &str) -> String {
    let text = format!("[[body]]\nname = \"bead\"\nmass = 1.0\nhinge = {{ type = \"along\", {hinge} }}\n");
    match scenario::parse("scene.toml", &text, &[]) {
        Ok(_) => "nothing".to_owned(),
        Err(diagnostics) => diagnostics.to_string(),
    }
}

/// What is wrong with a curve is shown where it is written.
#[test]
fn bad_curves_are_shown_where_they_are_written() {
    let all = [
        "curve = { parameter = \"u\", x = \"u\", z = \"abs(u)\", range = [-1.0, 1.3] }",
        "curve = { helix = [0.3, 0.0, 2.0] }",
        "curve = { straight = 1.0, helix = [0.3, 0.1, 2.0] }",
        "curve = { parameter = \"u\", x = \"u + w\", range = [0.0, 1.0] }",
        "curve = { straight = 1.0 }, position = 1.5",
        "turn = \"follows\"",
    ];
    insta::assert_snapshot!(all.map(said).join("\n"), @r#"
    error: the curve of the hinge of `bead` is not smooth near parameter 0, or bends there within less than the shortest piece, 2e-9
     --> scene.toml:4:85
      |
    4 | hinge = { type = "along", curve = { parameter = "u", x = "u", z = "abs(u)", range = [-1.0, 1.3] } }
      |                                                                                     ^^^^^^^^^^^
      |
      = help: the tangent and its derivative must be continuous, and the parameter must never stand still; waves that are as fine as these pieces look like kinks

    scene.toml: 1 error
    error: the curve of the hinge of `bead` has no pitch and 2 turns: it closes on itself
     --> scene.toml:4:45
      |
    4 | hinge = { type = "along", curve = { helix = [0.3, 0.0, 2.0] } }
      |                                             ^^^^^^^^^^^^^^^
      |
      = help: a curve has two ends that differ: leave a gap, or let it go on beyond its beginning

    scene.toml: 1 error
    error: curve of the hinge of `bead`: more than one of `straight`, `points`, `helix`, `parameter`
     --> scene.toml:4:37
      |
    4 | hinge = { type = "along", curve = { straight = 1.0, helix = [0.3, 0.1, 2.0] } }
      |                                     ^^^^^^^^
      |
      = help: keep exactly one of them

    scene.toml: 1 error
    error: the curve of the hinge of `bead` has no x: unknown name `w` at character 5 of the formula `u + w`
     --> scene.toml:4:58
      |
    4 | hinge = { type = "along", curve = { parameter = "u", x = "u + w", range = [0.0, 1.0] } }
      |                                                          ^^^^^^^
      |
      = help: a formula of its parameter

    scene.toml: 1 error
    error: `bead` is at an arc length of 1.5 m, beyond its curve
     --> scene.toml:4:66
      |
    4 | hinge = { type = "along", curve = { straight = 1.0 }, position = 1.5 }
      |                                                                  ^^^
      |
      = help: the curve goes from 0 m to 1 m

    scene.toml: 1 error
    error: hinge of body `bead`: `curve` is missing
     --> scene.toml:4:9
      |
    4 | hinge = { type = "along", turn = "follows" }
      |         ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
      |
      = help: for example `curve = { helix = [0.3, 0.1, 2.0] }`

    scene.toml: 1 error
    "#);
}
