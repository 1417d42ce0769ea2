//! Motors with laws: their part in the tangent, and what is said where they cannot be.

use super::bad_input::refused;
use super::{coordinate, read, run};
use stillpoint::dynamics::{Coefficients, System, TangentSolver};
use stillpoint::integrate::Method;
use stillpoint::simulate::{Integrator, Settings};

const ARM: &str = r#"
[[body]]
name = "upper"
mass = 2.0
center = [0.0, 0.0, -0.3]
inertia = [0.06, 0.06, 0.004]
markers = { tip = [0.0, 0.0, -0.6] }
hinge = { type = "revolute", axis = [0.0, 1.0, 0.0], position = 0.4, velocity = 0.7 }
[[body]]
name = "lower"
mass = 1.0
center = [0.0, 0.0, -0.2]
inertia = [0.02, 0.02, 0.001]
hinge = { type = "cylindrical", parent = "upper", at = "tip", axis = [0.3, 1.0, 0.0], position = [0.1, 0.2], velocity = [0.2, -0.4] }
"#;

fn with(motors: &str) -> String {
    format!("{ARM}{motors}")
}

const LAWS: &str = r#"
[[motor]]
hinge = "upper"
type = "pd"
target = { type = "sine", amplitude = 0.3, frequency = 0.5 }
stiffness = 30.0
damping = 4.0
limit = 25.0
[[motor]]
hinge = "lower"
type = "expression"
expression = "-40*q^3 - 2*v + sin(t)"
[[motor]]
hinge = "lower"
coordinate = 1
type = "table"
over = "speed"
at = [-1.0, 1.0]
forces = [3.0, -2.0]
"#;

/// `c₂ M + c₁ C + K` by the sweep is what differences of the force balance say, at a time at which targets move.
#[test]
fn motors_are_in_the_tangent() {
    let (_, model) = read(&with(LAWS));
    let (q, v) = (&model.start_position, &model.start_velocity);
    let n = v.len();
    let (c1, c2, h) = (20.0, 400.0, 1e-6);
    let mut system = System::new(&model);
    let mut a = vec![0.0; n];
    system.at(0.3, q, v).accelerations(&mut a).expect("accelerations");
    let mut solver = TangentSolver::new(&model);
    let with = Coefficients { c1, c2, ..Coefficients::default() };
    assert!(system.at(0.3, q, v).factorize_tangent(&mut solver, &a, &with).expect("a tangent"));
    for j in 0..n {
        let mut residual = |sign: f64| {
            let moved = |list: &[f64], by: f64| {
                let mut list = list.to_vec();
                list[j] += sign * by;
                list
            };
            let mut r = vec![0.0; n];
            system.at(0.3, &moved(q, h), &moved(v, c1 * h)).residual(&moved(&a, c2 * h), &mut r).expect("a residual");
            r
        };
        let (ahead, behind) = (residual(1.0), residual(-1.0));
        let mut column: Vec<f64> = ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * h)).collect();
        solver.solve(&mut column);
        for (i, x) in column.iter().enumerate() {
            let unit = if i == j { 1.0 } else { 0.0 };
            // Differences of numbers of size 1e3 over 2e-6.
            assert!((x - unit).abs() < 1e-7, "column {j}: {column:?}");
        }
    }
}

#[test]
fn motors_that_cannot_be() {
    let motor = |keys: &str| with(&format!("[[motor]]\nname = \"servo\"\nhinge = \"upper\"\n{keys}\n"));
    refused(&motor("type = \"pd\"\nstiffness = -3.0"), &["`stiffness`", "-3"]);
    refused(&motor("type = \"constant\"\nforce = 1.0\nlimit = 0.0"), &["`limit`"]);
    refused(
        &motor("type = \"expression\"\nexpression = \"-k*q\""),
        &["motor `servo`: unknown name `k`", "Known here: `t`, `q`, `v`"],
    );
    refused(
        &motor("type = \"table\"\nover = \"time\"\nat = [0.0, 1.0]\nforces = [1.0]"),
        &["2 points and 1 force: there must be as many"],
    );
    refused(
        &motor("type = \"table\"\nover = \"time\"\nat = [1.0, 1.0]\nforces = [1.0, 2.0]"),
        &["points must increase, but 1 comes after 1"],
    );
    let driven = motor("type = \"pd\"") + "[[drive]]\nname = \"turn\"\nhinge = \"upper\"\ntype = \"hold\"\n";
    refused(&driven, &["`servo` pushes on `upper`, whose motion `turn` prescribes"]);
    refused(&motor("type = \"constant\"\nforce = 1.0\ncoordinate = 1"), &["has no coordinate 1"]);
}

/// A push of 1 N s within twenty milliseconds, in the middle of ten seconds at rest: no method steps over it, and those that
/// know cubic polynomials meet both ends of every straight piece of the force.
#[test]
fn a_short_push_in_a_long_rest_is_not_missed() {
    let slide = r#"
[[body]]
name = "block"
mass = 1.0
inertia = [1.0, 1.0, 1.0]
hinge = { type = "prismatic", axis = [1.0, 0.0, 0.0] }
[[motor]]
hinge = "block"
type = "table"
over = "time"
at = [5.0, 5.01, 5.02]
forces = [0.0, 100.0, 0.0]
"#;
    let (_, model) = read(slide);
    for method in Method::ALL {
        let settings = Settings {
            duration: 10.0,
            integrator: Integrator::Method(method),
            tolerance: 1e-6,
            absolute_tolerance: 1e-6,
            step: method.needs_step().then_some(0.1),
            ..Settings::default()
        };
        let end = run(&model, &settings);
        // 1 m/s from 5.01 s on, the middle of the push.
        let error = (coordinate(&model, &end.state.position, "block") - 4.99).abs();
        let allowed = if method == Method::GeneralizedAlpha { 1e-4 } else { 1e-9 };
        assert!(error < allowed, "{}: {error:e} m", method.name());
        assert!(end.energy_drift < 10.0 * allowed, "{}: {:e} J", method.name(), end.energy_drift);
        let most = if method == Method::GeneralizedAlpha { 2000 } else { 400 };
        assert!(end.statistics.steps < most, "{}: {} steps", method.name(), end.statistics.steps);
    }
}

/// A road that begins to rise and ends with jumps of acceleration, under a mass on a stiff spring: every method gets over.
#[test]
fn a_table_may_end_with_a_jump() {
    let bump = r#"
[[body]]
name = "road"
mass = 1.0
inertia = [1.0, 1.0, 1.0]
hinge = { type = "prismatic", axis = [0.0, 0.0, 1.0] }
[[body]]
name = "wheel"
mass = 20.0
inertia = [1.0, 1.0, 1.0]
hinge = { type = "prismatic", parent = "road", axis = [0.0, 0.0, 1.0], stiffness = 5e4, damping = 400.0, rest = 3.92266e-3 }
[[drive]]
hinge = "road"
type = "table"
times = [0.5, 0.6, 0.7, 0.8, 0.9]
values = [0.0, 0.025, 0.05, 0.025, 0.0]
"#;
    let (_, model) = read(bump);
    let ends = Method::ALL.map(|method| {
        let settings = Settings {
            duration: 1.0,
            integrator: Integrator::Method(method),
            tolerance: 1e-6,
            absolute_tolerance: 1e-6,
            step: method.needs_step().then_some(1e-3),
            ..Settings::default()
        };
        (method, coordinate(&model, &run(&model, &settings).state.position, "wheel"))
    });
    let (_, exact) = ends[2];
    for (method, end) in ends {
        // Tens of steps of a part in 10⁶ each, of a motion of centimetres; the second-order method makes thousands.
        assert!((end - exact).abs() < 2e-6, "{}: {:e}", method.name(), end - exact);
        assert!(end.abs() > 1e-5, "the wheel still swings");
    }
}

/// A law is judged at the given rate, not at rest: constant power, `v v̇ = P / m`.
#[test]
fn a_formula_is_judged_where_the_scene_starts() {
    let cart = |velocity: f64| {
        format!(
            "simulate = {{ start = \"given\", duration = 1.0 }}\n[[body]]\nname = \"cart\"\nmass = 2.0\n\
             hinge = {{ type = \"prismatic\", axis = [1, 0, 0], velocity = {velocity} }}\n\
             [[motor]]\nname = \"engine\"\nhinge = \"cart\"\ntype = \"expression\"\nexpression = \"6/v\"\n"
        )
    };
    for velocity in [0.5, 2.0, -3.0] {
        let (scenario, model) = read(&cart(velocity));
        let summary = run(&model, &scenario.simulate);
        let expected = f64::sqrt(velocity * velocity + 6.0).copysign(velocity);
        assert!((summary.state.velocity[0] - expected).abs() < 1e-7, "{velocity}: {:?}", summary.state);
        assert!((summary.work - 6.0).abs() < 1e-7, "{velocity}: {}", summary.work);
    }
    refused(&cart(0.0), &["`engine`", "at t = 0, q = 0 and v = 0 as given", "not a finite number", "6/v"]);
}
