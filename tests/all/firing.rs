//! Loads over time and masses that burn away: closed forms, and Newton's and Euler's equations by a method of its own.

use crate::common::{Random, build};
use crate::scenarios::shipped;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;
use stillpoint::model::Model;
use stillpoint::model::burn::BurnDescription;
use stillpoint::model::description::{
    Attachment, BodyDescription, Description, ForceDescription, HingeDescription, Load, LoadAxes, MassProperties,
    OverTime, Point, Timeline,
};
use stillpoint::record::Fanout;
use stillpoint::scenario;
use stillpoint::simulate::{self, Integrator, Settings, State, Summary};

fn run(model: &Arc<Model>, duration: f64, integrator: Integrator) -> Summary {
    let settings =
        Settings { duration, integrator, tolerance: 1e-11, absolute_tolerance: 1e-12, ..Settings::default() };
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    simulate::run(model, &settings, 1.0, &start, &mut Fanout::new(), &mut |_, _| true).unwrap()
}

/// A body with a table of its mass properties.
fn burning(name: &str, hinge: HingeDescription, times: &[f64], rows: Vec<MassProperties>) -> Description {
    let burn = BurnDescription { body: name.to_owned(), timeline: Timeline { times: times.to_vec() }, rows };
    let body = BodyDescription { mass: burn.at(0.0), ..BodyDescription::new(name, hinge) };
    Description { burns: vec![burn], ..Description::new("burning").gravity([0.0; 3]).body(body) }
}

fn load(on: &str, force: Vector3<f64>, axes: LoadAxes, over_time: Option<OverTime>) -> ForceDescription {
    let on = Attachment { body: on.to_owned(), point: Point::At(Vector3::zeros()) };
    let kind = Load { on, force, torque: Vector3::zeros(), axes, over_time };
    ForceDescription { name: "thrust".to_owned(), kind: kind.into() }
}

fn methods(seed: u64) -> Integrator {
    use stillpoint::integrate::Method;
    let all = [Method::Dopri5, Method::Dop853, Method::Radau9, Method::Gauss];
    Integrator::Method(all[seed as usize % all.len()])
}

/// Tsiolkovsky: `Δv = (T/ṁ) ln(m₀/m₁)`, and the way `∫ v` beside it, to 1e-9; the thrust ends with a jump, and energy is
/// accounted for: what leaves takes its own along.
#[test]
fn a_rocket_gains_what_tsiolkovsky_says() {
    for seed in 0..60 {
        let random = &mut Random::new(seed);
        let (m0, m1) = (random.between(2.0, 50.0), random.between(0.1, 1.9));
        let (burns, thrust, after) = (random.between(0.1, 5.0), random.between(1.0, 1e4), random.between(0.1, 2.0));
        let row = |mass: f64| {
            let center = random.vector(0.0) + Vector3::new(0.2 * mass, 0.0, 0.0);
            MassProperties { mass, center, inertia: Matrix3::from_diagonal_element(0.1 * mass) }
        };
        let rows = [m0, m1].map(row).to_vec();
        let over_time = OverTime { timeline: Timeline { times: vec![0.0, burns, burns] }, values: vec![1.0, 1.0, 0.0] };
        let description = burning("rocket", HingeDescription::free(), &[0.0, burns], rows).force(load(
            "rocket",
            Vector3::new(thrust, 0.0, 0.0),
            LoadAxes::Body,
            Some(over_time),
        ));
        let found = run(&build(&description), burns + after, methods(seed));
        let flow = (m0 - m1) / burns;
        let gained = thrust / flow * (m0 / m1).ln();
        let way = thrust / flow * (burns - m1 / flow * (m0 / m1).ln()) + gained * after;
        let (x, v) = (found.state.position[0], found.state.velocity[0]);
        assert!((v - gained).abs() < 1e-9 * gained, "seed {seed}: {v} {gained}");
        assert!((x - way).abs() < 1e-9 * way, "seed {seed}: {x} {way}");
        assert!(found.energy_drift < 1e-8 * found.work.abs().max(0.5 * m0 * gained * gained), "seed {seed}: {found:?}");
    }
}

/// The shipped rocket.
#[test]
fn the_rocket_of_the_scenario_gains_its_speed() {
    let (scenario, model) = shipped("rocket", &[]);
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let found = simulate::run(&model, &scenario.simulate, 1.0, &start, &mut Fanout::new(), &mut |_, _| true).unwrap();
    let gained = 2000.0 * 3.0_f64.ln();
    assert!((found.state.velocity[0] - gained).abs() < 1e-9 * gained, "{:?}", found.state);
}

/// The recoil of the gun: an oscillator under a constant force, then its decay up to where it turns.
#[test]
fn the_gun_recoils_as_far_as_its_closed_form() {
    let (scenario, model) = shipped("gun", &[]);
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let found = simulate::run(&model, &scenario.simulate, 1.0, &start, &mut Fanout::new(), &mut |_, _| true).unwrap();
    let (force, mass, k, c, fires) = (60_000.0_f64, 120.0_f64, 12_000.0_f64, 800.0_f64, 0.008_f64);
    let (w, z) = ((k / mass).sqrt(), 0.5 * c / (k * mass).sqrt());
    let wd = w * (1.0 - z * z).sqrt();
    let decayed = (-z * w * fires).exp();
    let x = force / k * (1.0 - decayed * ((wd * fires).cos() + z * w / wd * (wd * fires).sin()));
    let v = force / k * decayed * w * w / wd * (wd * fires).sin();
    let turns = v.atan2((z * w * v + w * w * x) / wd) / wd;
    let recoil = (-z * w * turns).exp() * (x * (wd * turns).cos() + (v + z * w * x) / wd * (wd * turns).sin());
    let event = found.events.iter().find(|event| event.name == "recoil").expect("it turns back");
    assert!((event.time - fires - turns).abs() < 1e-8, "{} {}", event.time, fires + turns);
    let settings = Settings { duration: event.time, ..scenario.simulate };
    let found = simulate::run(&model, &settings, 1.0, &start, &mut Fanout::new(), &mut |_, _| true).unwrap();
    assert!((found.state.position[0] - recoil).abs() < 1e-9 * recoil, "{:?} {recoil}", found.state);
}

/// A table of masses with moving centres and tensors that are not parallel.
fn rows(random: &mut Random, count: usize) -> Vec<MassProperties> {
    let mut mass = random.between(5.0, 10.0);
    let mut all = Vec::new();
    for _ in 0..count {
        mass *= random.between(0.4, 0.9);
        let spread: Matrix3<f64> = Matrix3::from_fn(|_, _| random.between(-0.3, 0.3));
        let scatter: Matrix3<f64> = spread * spread.transpose() + 0.05 * Matrix3::identity();
        let inertia = mass * (scatter.trace() * Matrix3::identity() - scatter);
        all.push(MassProperties { mass, center: random.vector(0.3), inertia });
    }
    all
}

/// `y' = f(t, y)` by the classical method of fourth order between the points of a table.
fn integrated<const N: usize>(
    times: &[f64],
    mut y: [f64; N],
    f: impl Fn(usize, f64, &[f64; N]) -> [f64; N],
) -> [f64; N] {
    const STEPS: usize = 4000;
    for (piece, ends) in times.windows(2).enumerate() {
        let h = (ends[1] - ends[0]) / STEPS as f64;
        let add = |y: &[f64; N], by: f64, k: &[f64; N]| std::array::from_fn(|i| y[i] + by * k[i]);
        for step in 0..STEPS {
            let t = ends[0] + h * step as f64;
            let k1 = f(piece, t, &y);
            let k2 = f(piece, t + 0.5 * h, &add(&y, 0.5 * h, &k1));
            let k3 = f(piece, t + 0.5 * h, &add(&y, 0.5 * h, &k2));
            let k4 = f(piece, t + h, &add(&y, h, &k3));
            y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        }
    }
    y
}

/// What the table has in a piece of it.
fn between(rows: &[MassProperties], times: &[f64], piece: usize, t: f64) -> MassProperties {
    let x = (t - times[piece]) / (times[piece + 1] - times[piece]);
    let (a, b) = (&rows[piece], &rows[piece + 1]);
    MassProperties {
        mass: (1.0 - x) * a.mass + x * b.mass,
        center: (1.0 - x) * a.center + x * b.center,
        inertia: (1.0 - x) * a.inertia + x * b.inertia,
    }
}

/// A body that turns freely about a point and burns, under its weight, against Euler's equations about that point:
/// `J ω̇ = −ω × J ω + c × m g` with what is there at the time, whatever left. The ledger closes.
#[test]
fn a_burning_top_follows_eulers_equations() {
    for seed in 0..24 {
        let random = &mut Random::new(seed);
        let times = [0.0, random.between(0.1, 0.4), random.between(0.5, 0.9)];
        let (rows, gravity) = (rows(random, 3), random.vector(10.0));
        let (turn, spin) = (random.turn(), random.vector(4.0));
        let hinge = HingeDescription::spherical().position([turn.w, turn.i, turn.j, turn.k]);
        let hinge = hinge.velocity(spin.as_slice().to_vec());
        let description = Description { gravity, ..burning("top", hinge, &times, rows.clone()) };
        let found = run(&build(&description), times[2], methods(seed));
        let start = [turn.w, turn.i, turn.j, turn.k, spin.x, spin.y, spin.z];
        let expected = integrated(&times, start, |piece, t, y| {
            let now = between(&rows, &times, piece, t);
            let q = nalgebra::Quaternion::new(y[0], y[1], y[2], y[3]);
            let down = nalgebra::UnitQuaternion::from_quaternion(q).inverse() * gravity;
            let (w, c, m) = (Vector3::new(y[4], y[5], y[6]), now.center, now.mass);
            let about = now.inertia + m * (Matrix3::from_diagonal_element(c.norm_squared()) - c * c.transpose());
            let faster = about.try_inverse().unwrap() * (c.cross(&(m * down)) - w.cross(&(about * w)));
            let turns = 0.5 * q * nalgebra::Quaternion::from_imag(w);
            [turns.w, turns.i, turns.j, turns.k, faster.x, faster.y, faster.z]
        });
        for (i, expected) in expected.iter().enumerate() {
            let value = if i < 4 { found.state.position[i] } else { found.state.velocity[i - 4] };
            assert!((value - expected).abs() < 1e-8 * spin.norm().max(10.0), "seed {seed} {i}: {value} {expected}");
        }
        let size = found.energy_start.abs() + found.work.abs() + 1.0;
        assert!(found.energy_drift < 1e-8 * size, "seed {seed}: {} of {size}", found.energy_drift);
    }
}

/// The integral of a table is what a mass gains, with jumps and corners, by methods of every kind.
#[test]
fn a_load_over_time_gives_its_impulse() {
    for seed in 0..60 {
        let random = &mut Random::new(seed);
        let mut times = vec![random.between(0.0, 0.3)];
        let mut values = vec![random.between(-1.0, 1.0)];
        for _ in 0..random.below(6) + 1 {
            let jumps = random.below(3) == 0 && (times.len() < 2 || times[times.len() - 2] != times[times.len() - 1]);
            times.push(times[times.len() - 1] + if jumps { 0.0 } else { random.between(0.05, 0.5) });
            values.push(random.between(-1.0, 1.0));
        }
        let (mass, force, end) = (random.between(0.1, 10.0), random.vector(50.0), times[times.len() - 1] + 0.2);
        let mut impulse = values[0] * times[0] + values[values.len() - 1] * 0.2;
        for i in 1..times.len() {
            impulse += 0.5 * (values[i] + values[i - 1]) * (times[i] - times[i - 1]);
        }
        let axes = if seed % 2 == 0 { LoadAxes::Body } else { LoadAxes::Inertial };
        let body = BodyDescription::new("block", HingeDescription::free()).mass(mass).inertia([0.1; 3]);
        let over_time = OverTime { timeline: Timeline { times }, values };
        let description =
            Description::new("push").gravity([0.0; 3]).body(body).force(load("block", force, axes, Some(over_time)));
        let found = run(&build(&description), end, methods(seed));
        for i in 0..3 {
            let (gained, expected) = (found.state.velocity[i], force[i] * impulse / mass);
            let size = force.norm() * end / mass;
            assert!((gained - expected).abs() < 1e-10 * size, "seed {seed}: {gained} {expected}");
        }
        let size = 0.5 * mass * (force.norm() * end / mass).powi(2);
        assert!(found.energy_drift < 1e-9 * size, "seed {seed}: {} of {size}", found.energy_drift);
    }
}

fn said(body: &str, force: &str) -> String {
    let text = format!(
        "[[body]]\nname = \"rocket\"\n{body}\nhinge = {{ type = \"free\" }}\n\n[[force]]\ntype = \"load\"\non = \"rocket\"\nforce = [1.0, 0.0, 0.0]\n{force}\n"
    );
    match scenario::parse("scene.toml", &text, &[]) {
        Ok(_) => "nothing".to_owned(),
        Err(diagnostics) => diagnostics.to_string(),
    }
}

/// An inertia that no body can have is said once, however many rows of the table have it.
#[test]
fn an_impossible_inertia_of_a_burn_is_said_once() {
    let rows = "burn = { times = [0.0, 1.0], mass = [2.0, 1.0], inertia = [[1.0, 1.0, 9.0], [1.0, 1.0, 9.0]] }";
    let text = said(rows, "");
    assert!(
        text.matches("no body can have").count() == 1 && text.contains("1 error") && !text.contains("copy"),
        "{text}"
    );
}

/// What is wrong with a table is shown where it is written.
#[test]
fn bad_tables_are_shown_where_they_are_written() {
    let all = [
        ("burn = { times = [0.0, 1.0], mass = [2.0, -1.0] }", ""),
        ("burn = { times = [0.0, 1.0, 0.5], mass = [2.0, 1.5, 1.0] }", ""),
        ("burn = { times = [0.0, 1.0], mass = [2.0, 1.0] }\nmass = 2.0", ""),
        ("burn = { times = [0.0, 1.0], mass = [2.0, 1.0], center = [[0.0, 0.0, 0.0]] }", ""),
        ("burn = { times = [0.0, 1.0], mass = [2.0, 1.0], inertia = [[1.0, 1.0, 1.0], [1.0, 1.0, 9.0]] }", ""),
        ("burn = { times = [0.0, 1.0, 2.0], mass = [2.0, 1.0, 1.5] }", ""),
        ("mass = 1.0", "over_time = { times = [0.0, 1.0], values = [1.0] }"),
    ];
    insta::assert_snapshot!(all.map(|(body, force)| said(body, force)).join("\n"), @r#"
    error: burn of body `rocket`: `mass[1]` is -1.0, allowed: > 0 kg
     --> scene.toml:3:43
      |
    3 | burn = { times = [0.0, 1.0], mass = [2.0, -1.0] }
      |                                           ^^^^

    scene.toml: 1 error
    error: the burn of `rocket` goes back from 1 s to 0.5 s
     --> scene.toml:3:18
      |
    3 | burn = { times = [0.0, 1.0, 0.5], mass = [2.0, 1.5, 1.0] }
      |                  ^^^^^^^^^^^^^^^
      |
      = help: times must not decrease; given twice, the numbers jump there

    scene.toml: 1 error
    error: body `rocket`: `mass` beside `burn`
     --> scene.toml:4:1
      |
    4 | mass = 2.0
      | ^^^^
      |
      = help: a body that burns has `mass`, `center` and `inertia` in its table, and is one

    scene.toml: 1 error
    error: body `rocket`: `burn` has 2 masses and 1 row of `center`
     --> scene.toml:3:58
      |
    3 | burn = { times = [0.0, 1.0], mass = [2.0, 1.0], center = [[0.0, 0.0, 0.0]] }
      |                                                          ^^^^^^^^^^^^^^^^^

    scene.toml: 1 error
    error: no body can have the inertia of `rocket`: the sum of its two smaller principal moments falls short of the largest by 77.778 % (principal moments 1, 1, 9 kg m²)
     --> scene.toml:3:59
      |
    3 | burn = { times = [0.0, 1.0], mass = [2.0, 1.0], inertia = [[1.0, 1.0, 1.0], [1.0, 1.0, 9.0]] }
      |                                                           ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
      |
      = help: inertia is about the centre of mass, in body axes; a flat body sits exactly on the limit

    scene.toml: 1 error
    error: the mass of `rocket` grows from 1 kg at t = 1 s to 1.5 kg at t = 2 s
     --> scene.toml:3:53
      |
    3 | burn = { times = [0.0, 1.0, 2.0], mass = [2.0, 1.0, 1.5] }
      |                                                     ^^^
      |
      = help: what burns becomes less: masses must not grow. What a body takes up has a velocity of its own: let another body join it by a `[[stage]]` with `close`

    scene.toml: 1 error
    error: `over_time` of `force[0]` has 2 times and 1 value
      --> scene.toml:10:13
       |
    10 | over_time = { times = [0.0, 1.0], values = [1.0] }
       |             ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
       |
       = help: times must not decrease, and each has a value; given twice, the value jumps there

    scene.toml: 1 error
    "#);
}

/// A stage that is dropped has half of the mass and of the energy: the account of the run says where that went.
#[test]
fn mass_that_goes_at_once_takes_its_energy_along() {
    let text = "gravity = [0, 0, 0]\n[[body]]\nname = \"rocket\"\n\
                burn = { times = [0.0, 0.5, 0.5, 1.0], mass = [4.0, 4.0, 2.0, 2.0] }\n\
                hinge = { type = \"prismatic\", axis = [1, 0, 0], velocity = 3.0 }\n";
    let summary = crate::contact_in_motion::go(
        &crate::contact_in_motion::read(text),
        1.0,
        1e-9,
        stillpoint::integrate::Method::Dop853,
    );
    assert!((summary.state.velocity[0] - 3.0).abs() < 1e-12, "{:?}", summary.state);
    assert!(summary.energy_drift < 1e-12, "{}", summary.energy_drift);
}
