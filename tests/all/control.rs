//! Controllers in runs: against discrete-time answers by matrix exponentials, and what a user sees of them.

use crate::scenarios::{file, shipped};
use assert_cmd::Command;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;
use stillpoint::constraint::assemble;
use stillpoint::model::Model;
use stillpoint::record::{RecordError, Recorder, Sample};
use stillpoint::scenario::{Scenario, load, parse};
use stillpoint::simulate::control::{Function, Sensed};
use stillpoint::simulate::{Integrator, RunError, Settings, State, Summary, run, run_controlled};

/// Samples of positions, and what motors push with.
#[derive(Default)]
struct Kept(Vec<(f64, Vec<f64>, Vec<f64>)>);

impl Recorder for Kept {
    fn sample(&mut self, sample: &Sample) -> Result<(), RecordError> {
        self.0.push((sample.time, sample.positions.to_vec(), sample.couplings.to_vec()));
        Ok(())
    }

    fn finish(&mut self, _outcome: &stillpoint::record::Outcome) -> Result<(), RecordError> {
        Ok(())
    }
}

fn scene(text: &str) -> (Scenario, Arc<Model>) {
    let scenario = parse("scene.toml", text, &[]).unwrap_or_else(|problems| panic!("{}", problems.render(false)));
    let model = assemble(Model::build(&scenario.description).unwrap()).unwrap().0;
    (scenario, model)
}

fn start(model: &Model) -> State {
    State { position: model.start_position.clone(), velocity: model.start_velocity.clone() }
}

fn ran(model: &Arc<Model>, settings: &Settings, rate: f64, kept: &mut Kept) -> Result<Summary, RunError> {
    run(model, settings, rate, &start(model), kept, &mut |_, _| true)
}

/// Masses on springs, each with an input.
fn masses(controller: &str) -> String {
    let mut text = "gravity = [0, 0, 0]\n[simulate]\nstart = \"given\"\nduration = 2.0\ntolerance = 1e-12\n".to_owned();
    for (name, parent, k, c, q, v) in [("a", "ground", 40.0, 0.3, 0.2, 0.0), ("b", "a", 25.0, 0.1, -0.1, 0.4)] {
        text += &format!(
            "[[body]]\nname = \"{name}\"\nmass = 1.5\nhinge = {{ type = \"prismatic\", parent = \"{parent}\", axis = [1, 0, 0], \
             stiffness = {k:?}, damping = {c:?}, position = {q:?}, velocity = {v:?} }}\n\
             [[motor]]\nname = \"push {name}\"\ntype = \"input\"\nhinge = \"{name}\"\n\
             [[output]]\nname = \"x{name}\"\ntype = \"coordinate\"\nof = \"{name}\"\n\
             [[output]]\nname = \"v{name}\"\ntype = \"rate\"\nof = \"{name}\"\n"
        );
    }
    text + controller
}

/// `[A B]` of the masses, states xa, xb, va, vb: `M = [[2m, m], [m, m]]`.
fn continuous() -> (DMatrix<f64>, DMatrix<f64>) {
    let m = 1.5;
    let mass = DMatrix::from_row_slice(2, 2, &[2.0 * m, m, m, m]).try_inverse().unwrap();
    let stiffness = &mass * DMatrix::from_diagonal(&DVector::from_vec(vec![40.0, 25.0]));
    let damping = &mass * DMatrix::from_diagonal(&DVector::from_vec(vec![0.3, 0.1]));
    let mut a = DMatrix::zeros(4, 4);
    for i in 0..2 {
        a[(i, 2 + i)] = 1.0;
        for j in 0..2 {
            (a[(2 + i, j)], a[(2 + i, 2 + j)]) = (-stiffness[(i, j)], -damping[(i, j)]);
        }
    }
    let mut b = DMatrix::zeros(4, 2);
    b.view_mut((2, 0), (2, 2)).copy_from(&mass);
    (a, b)
}

/// `x(t + h)` with the inputs held, by the exponential of `[[A, B], [0, 0]] h`.
fn held(x: &DVector<f64>, u: &DVector<f64>, h: f64) -> DVector<f64> {
    let (a, b) = continuous();
    let mut whole = DMatrix::zeros(6, 6);
    whole.view_mut((0, 0), (4, 4)).copy_from(&(a * h));
    whole.view_mut((0, 4), (4, 2)).copy_from(&(b * h));
    let power = whole.exp();
    power.view((0, 0), (4, 4)) * x + power.view((0, 4), (4, 2)) * u
}

fn integrators() -> Vec<Integrator> {
    let names =
        ["auto", "dopri5", "dop853", "adams", "gauss", "radau5", "radau9", "sdirk4", "rk4", "generalized-alpha"];
    names.into_iter().filter_map(Integrator::named).collect()
}

/// Compares a run of the masses with the states that follow from `law(k, y)` by exponentials, at every third of a period.
fn agrees(text: &str, period: f64, law: &mut dyn FnMut(usize, &DVector<f64>) -> DVector<f64>) -> (DVector<f64>, f64) {
    let (scenario, model) = scene(text);
    let mut kept = Kept::default();
    ran(&model, &scenario.simulate, 3.0 / period, &mut kept).unwrap();
    let mut x = DVector::from_vec(vec![0.2, -0.1, 0.0, 0.4]);
    let (mut worst, mut u) = (0.0_f64, DVector::zeros(2));
    for (index, (time, q, pushes)) in kept.0.iter().enumerate() {
        let (k, third) = (index / 3, index % 3);
        if third == 0 {
            assert!((time - k as f64 * period).abs() < 1e-12);
            if k > 0 {
                x = held(&x, &u, period);
            }
            if *time < 2.0 - 1e-9 {
                u = law(k, &x);
            }
        }
        let now = held(&x, &u, third as f64 * period / 3.0);
        worst = worst.max((q[0] - now[0]).abs()).max((q[1] - now[1]).abs());
        for i in 0..2 {
            let error = (pushes[i] - u[i]).abs();
            assert!(error < 1e-6 * u[i].abs().max(1.0), "at {time} s it pushes {} for {}", pushes[i], u[i]);
        }
    }
    (x, worst)
}

const GAIN: &str = "[[controller]]\nname = \"damp\"\ntype = \"gain\"\nperiod = 0.05\nsenses = [\"xa\", \"xb\", \"va\", \"vb\"]\n\
                    drives = [\"push a\", \"push b\"]\nmatrix = [[3.0, -1.0, 4.0, 0.5], [0.2, 2.0, -0.3, 3.0]]\n\
                    setpoint = [0.1, 0.0, 0.0, 0.0]\nbias = [1.0, -0.5]\n";

fn gain(_: usize, x: &DVector<f64>) -> DVector<f64> {
    let k = DMatrix::from_row_slice(2, 4, &[3.0, -1.0, 4.0, 0.5, 0.2, 2.0, -0.3, 3.0]);
    DVector::from_vec(vec![1.0, -0.5]) - k * (x - DVector::from_vec(vec![0.1, 0.0, 0.0, 0.0]))
}

#[test]
fn a_gain_holds_its_inputs_between_instants() {
    let (_, worst) = agrees(&masses(GAIN), 0.05, &mut gain);
    assert!(worst < 1e-10, "{worst:e}");
}

#[test]
fn every_integrator_ends_its_steps_at_the_instants() {
    let (mut x, mut u) = (DVector::from_vec(vec![0.2, -0.1, 0.0, 0.4]), DVector::zeros(2));
    for k in 0..40 {
        u = gain(k, &x);
        x = held(&x, &u, 0.05);
    }
    let (scenario, model) = scene(&masses(GAIN));
    for integrator in integrators() {
        let settings =
            Settings { integrator, tolerance: 1e-10, absolute_tolerance: 1e-10, ..scenario.simulate.clone() };
        let done = ran(&model, &settings, 10.0, &mut Kept::default()).unwrap();
        let found = &done.state;
        let error = (0..2).map(|i| (found.position[i] - x[i]).abs().max((found.velocity[i] - x[2 + i]).abs()));
        let error = error.fold(0.0, f64::max);
        // Fixed steps of a millisecond: the second order of generalized-alpha, the fourth of rk4.
        let allowed = if integrator == Integrator::named("generalized-alpha").unwrap() { 1e-4 } else { 1e-8 };
        assert!(error < allowed, "{integrator:?}: {error:e}");
        assert!(
            (done.inputs[0] - u[0]).abs() < 10.0 * allowed && done.energy_drift < 10.0 * allowed,
            "{integrator:?}: {done:?}"
        );
    }
}

#[test]
fn a_pid_integrates_differs_and_does_not_wind_up() {
    let pid = "[[controller]]\nname = \"place\"\ntype = \"pid\"\nperiod = 0.04\nsenses = \"xb\"\ndrives = \"push b\"\n\
               proportional = 8.0\nintegral = 30.0\nderivative = 1.5\nsetpoint = 0.4\nbias = 0.3\nlimit = 5.0\n";
    let (mut integral, mut before, mut cut, mut free) = (0.0, None, 0, 0);
    let mut law = |_: usize, x: &DVector<f64>| {
        let error = 0.4 - x[1];
        let rate = before.map_or(0.0, |before| (error - before) / 0.04);
        before = Some(error);
        let of = |integral: f64| 0.3 + 8.0 * error + 30.0 * integral + 1.5 * rate;
        let next = integral + 0.04 * error;
        // It is not driven further beyond its limit.
        let winds = of(next).abs() > 5.0 && error * of(next) > 0.0;
        if winds {
            cut += 1;
        } else {
            (integral, free) = (next, free + 1);
        }
        DVector::from_vec(vec![0.0, of(integral).clamp(-5.0, 5.0)])
    };
    let (_, worst) = agrees(&masses(pid), 0.04, &mut law);
    assert!(worst < 1e-10, "{worst:e}");
    assert!(cut > 3 && free > 3, "both happen: {cut} {free}");
}

#[test]
fn formulas_see_outputs_the_time_and_parameters() {
    let text = "[[controller]]\nname = \"push\"\ntype = \"expression\"\nperiod = 0.1\nsenses = [\"xa\", \"vb\"]\n\
                drives = [\"push b\", \"push a\"]\nexpression = [\"-{k}*vb + sin(3*t)\", \"if(xa > 0, -{k}, {k})\"]\n[parameters]\nk = 2.5\n";
    let mut law = |k: usize, x: &DVector<f64>| {
        let t = k as f64 * 0.1;
        DVector::from_vec(vec![if x[0] > 0.0 { -2.5 } else { 2.5 }, -2.5 * x[3] + (3.0 * t).sin()])
    };
    let (_, worst) = agrees(&masses(text), 0.1, &mut law);
    assert!(worst < 1e-10, "{worst:e}");
}

#[test]
fn controllers_of_one_instant_read_the_same() {
    // What the motors push is an output: both see what was pushed before the instant.
    let text = "[[output]]\nname = \"fa\"\ntype = \"force\"\nof = \"push a\"\n[[output]]\nname = \"fb\"\ntype = \"force\"\nof = \"push b\"\n\
                [[controller]]\nname = \"one\"\ntype = \"expression\"\nperiod = 0.1\nsenses = [\"fb\"]\ndrives = [\"push a\"]\nexpression = \"fb + 1\"\n\
                [[controller]]\nname = \"two\"\ntype = \"expression\"\nperiod = 0.2\nsenses = [\"fa\"]\ndrives = [\"push b\"]\nexpression = \"2*fa\"\n";
    let mut u = [0.0, 0.0];
    let mut law = |k: usize, _: &DVector<f64>| {
        u = [u[1] + 1.0, if k.is_multiple_of(2) { 2.0 * u[0] } else { u[1] }];
        DVector::from_vec(u.to_vec())
    };
    let (_, worst) = agrees(&masses(text), 0.1, &mut law);
    assert!(worst < 1e-7, "{worst:e}");
}

#[test]
fn a_function_acts_as_a_controller_does() {
    let (scenario, model) = scene(&masses(GAIN));
    let (_, free) = scene(&masses(""));
    let (mut by_scene, mut by_function) = (Kept::default(), Kept::default());
    ran(&model, &scenario.simulate, 50.0, &mut by_scene).unwrap();
    let mut law = |sensed: Sensed<'_>, inputs: &mut [f64]| {
        assert_eq!(sensed.state.position[0], sensed.outputs[0]);
        // xa, va, xb, vb
        let y = DVector::from_vec([0, 2, 1, 3].map(|i| sensed.outputs[i]).to_vec());
        inputs.copy_from_slice(gain(0, &y).as_slice());
        Ok(())
    };
    let function = Function { period: 0.05, law: &mut law };
    let go_on = &mut |_: f64, _: &State| true;
    run_controlled(&free, &scenario.simulate, 50.0, &start(&free), &mut by_function, go_on, function).unwrap();
    assert_eq!(by_scene.0.len(), by_function.0.len());
    for ((t, q, _), (_, p, _)) in by_scene.0.iter().zip(&by_function.0) {
        assert!((q[0] - p[0]).abs() < 1e-12 && (q[1] - p[1]).abs() < 1e-12, "{t}");
    }
    let mut fails =
        |sensed: Sensed<'_>, _: &mut [f64]| if sensed.time > 0.42 { Err("no idea".to_owned()) } else { Ok(()) };
    let mut kept = Kept::default();
    let function = Function { period: 0.05, law: &mut fails };
    let error = run_controlled(&free, &scenario.simulate, 50.0, &start(&free), &mut kept, go_on, function).unwrap_err();
    assert!(error.to_string().contains("0.45") && error.to_string().contains("no idea"), "{error}");
    assert!((kept.0.last().unwrap().0 - 0.44).abs() < 1e-9, "samples until then are kept");
}

#[test]
fn a_motor_saturates_and_a_number_that_is_none_ends_the_run() {
    let text = masses(GAIN).replace("hinge = \"a\"\n", "hinge = \"a\"\nlimit = 0.7\n");
    let mut law = |k: usize, x: &DVector<f64>| {
        let u = gain(k, x);
        DVector::from_vec(vec![u[0].clamp(-0.7, 0.7), u[1]])
    };
    let (_, worst) = agrees(&text, 0.05, &mut law);
    assert!(worst < 1e-10, "{worst:e}");
    let text = "[[controller]]\nname = \"root\"\ntype = \"expression\"\nperiod = 0.1\nsenses = \"xa\"\ndrives = \"push a\"\nexpression = \"sqrt(0.5 - t)\"\n";
    let (scenario, model) = scene(&masses(text));
    let mut kept = Kept::default();
    let error = ran(&model, &scenario.simulate, 50.0, &mut kept).unwrap_err();
    assert!(
        matches!(&error, RunError::Controller { time, name, .. } if (time - 0.6).abs() < 1e-12 && name == "root"),
        "{error}"
    );
    assert!(kept.0.len() >= 30);
}

/// A run that ends anywhere on its grid goes on with the same bits: inputs, what controllers remember, instants.
#[test]
fn a_run_goes_on_with_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let pid = "[[controller]]\nname = \"place\"\ntype = \"pid\"\nperiod = 0.0625\nsenses = \"xb\"\ndrives = \"push b\"\n\
               proportional = 8.0\nintegral = 30.0\nderivative = 1.5\nsetpoint = 0.4\nlimit = 5.0\n\
               [[controller]]\nname = \"damp\"\ntype = \"gain\"\nperiod = 0.125\nsenses = [\"va\"]\ndrives = [\"push a\"]\nmatrix = [[2.0]]\n";
    let text = masses(pid).replace("tolerance = 1e-12\n", "integrator = \"rk4\"\nstep = 0.00390625\n");
    let scenario = folder.path().join("scene.toml");
    std::fs::write(&scenario, text).unwrap();
    let run = |duration: f64, begin: Option<&str>, end: &str| {
        let mut command = Command::cargo_bin("stillpoint").unwrap();
        command.current_dir(folder.path()).arg("run").arg(&scenario).args(["--quiet", "--save-end", end]);
        command.args(["--out", &format!("{end}.mcap")]);
        command.args(["--set", &format!("simulate.duration={duration}")]);
        if let Some(begin) = begin {
            command.args(["--start", begin]);
        }
        let done = command.output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        std::fs::read_to_string(folder.path().join(end)).unwrap()
    };
    let whole = run(2.0, None, "whole.toml");
    assert!(whole.contains("[controllers]") && whole.contains("\"push b.force\" = "), "{whole}");
    // Within a period, and at an instant of one and of both.
    for first in [0.71875, 0.6875, 0.75] {
        run(first, None, "first.toml");
        assert_eq!(run(2.0 - first, Some("first.toml"), "second.toml"), whole, "{first}");
    }
}

#[test]
fn what_is_wrong_with_a_controller_is_said() {
    let wrong = |controller: &str| match parse("scene.toml", &masses(controller), &[]) {
        Ok(scenario) => {
            Model::build(&scenario.description).map(drop).unwrap_err().iter().map(ToString::to_string).collect()
        }
        Err(problems) => problems.render(false),
    };
    let of = |from: &str, to: &str| {
        assert!(GAIN.contains(from), "{from}");
        wrong(&GAIN.replace(from, to))
    };
    for (text, expected) in [
        (of("\"va\"", "\"vaa\""), "did you mean `va`?"),
        (of("\"push a\"", "\"push c\""), "did you mean `push a`?"),
        (of("\"push a\", \"push b\"", "\"push a\", \"push a\""), "drives `push a`, which `damp` drives"),
        (of("[[3.0, -1.0, 4.0, 0.5], ", "["), "2 of 4 are wanted"),
        (of("4.0, 0.5]", "4.0]"), "2 of 4 are wanted"),
        (of("setpoint = [0.1, ", "setpoint = ["), "`setpoint` of `damp` has 3 numbers: 4 are wanted"),
        (of("period = 0.05", "period = 0.0"), "period"),
        (of("type = \"gain\"", "type = \"lqr\""), "gain"),
        (of("bias = ", "byas = "), "did you mean `bias`?"),
    ] {
        assert!(text.contains(expected), "{text}\n… has no `{expected}`");
    }
    let formula = "[[controller]]\nname = \"f\"\ntype = \"expression\"\nperiod = 0.1\nsenses = \"xa\"\ndrives = \"push a\"\nexpression = \"xa + xb\"\n";
    assert!(wrong(formula).contains("xb"), "{}", wrong(formula));
}

/// The cart stays below its pole: the rest proof runs with the controller.
#[test]
fn a_controlled_equilibrium_stays_and_one_that_is_none_is_refused() {
    let rest = |more: &[&str]| {
        let mut command = Command::cargo_bin("stillpoint").unwrap();
        command
            .arg("rest")
            .arg(file("balanced_cart"))
            .args(["--json", "--out", "/dev/null"])
            .args(more)
            .output()
            .unwrap()
    };
    let done = rest(&[]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let other = rest(&["--set", "controller[0].setpoint=[0.5, 0.0, 0.0, 0.0]"]);
    assert!(!other.status.success());
    let said = String::from_utf8_lossy(&other.stderr).into_owned();
    assert!(said.contains("`balance`") && said.contains("`bias`"), "{said}");
}

/// Closed loop of the scenario, linear, by the exponential: the pole comes back from 1e-5 rad as the gains say.
#[test]
fn the_pole_comes_back_as_discrete_time_says() {
    let scenario = load(&file("balanced_cart")).unwrap();
    let mut model = assemble(Model::build(&scenario.description).unwrap()).unwrap().0;
    let (tip, size) = (1, 1e-5);
    Arc::make_mut(&mut model).start_position[tip] += size;
    let settings = Settings {
        start: stillpoint::simulate::Start::Given,
        duration: 3.0,
        tolerance: 1e-12,
        absolute_tolerance: 1e-14,
        ..scenario.simulate
    };
    let mut kept = Kept::default();
    ran(&model, &settings, 50.0, &mut kept).unwrap();
    // cart M = 1, pole m = 0.2 with its centre at l = 0.5 and J = m l²/3; θ from the upright.
    let (cart, m, l, g) = (1.0, 0.2, 0.5, 9.80665);
    let mass = DMatrix::from_row_slice(2, 2, &[cart + m, m * l, m * l, m * l * l * 4.0 / 3.0]).try_inverse().unwrap();
    let (mut a, mut b) = (DMatrix::zeros(5, 5), DVector::zeros(5));
    for i in 0..2 {
        a[(i, 2 + i)] = 1.0;
        a[(2 + i, 1)] = mass[(i, 1)] * m * g * l;
        a[(2 + i, 4)] = mass[(i, 0)];
        b[2 + i] = mass[(i, 0)];
    }
    let step = (a * 0.02).exp();
    let gains: Vec<f64> = match &scenario.description.controllers[0].law {
        stillpoint::model::description::ControlLawDescription::Gain { matrix, .. } => matrix[0].clone(),
        other => panic!("{other:?}"),
    };
    let mut x = DVector::from_vec(vec![0.0, size, 0.0, 0.0, 0.0]);
    let (mut worst, mut farthest) = (0.0_f64, 0.0_f64);
    for (_, q, _) in &kept.0 {
        worst = worst.max((q[0] - x[0]).abs()).max((q[1] - x[1]).abs());
        farthest = farthest.max(q[0].abs());
        x[4] = -(0..4).map(|i| gains[i] * x[i]).sum::<f64>();
        x = &step * x;
    }
    // The scene is not linear: to the third order of the pole's angle.
    assert!(worst < 1e-3 * size && farthest > 0.1 * size, "{worst:e} of {farthest:e}");
    let last = &kept.0.last().unwrap().1;
    assert!(last[1].abs() < 0.05 * size, "{last:?}");
}

/// Who steps in makes the cabin sink; the integral brings it back, as the recursion of a mass under held forces says.
#[test]
fn the_lift_comes_back_to_its_floor() {
    let (scenario, model) = shipped("lift", &["cabin.mass=380", "record.rate=20"]);
    let mut kept = Kept::default();
    ran(&model, &scenario.simulate, 20.0, &mut kept).unwrap();
    let (t, weight) = (0.05, 380.0 * 9.80665);
    let (mut z, mut v, mut integral, mut before) = (0.0, 0.0, 0.0, 0.0);
    let (mut worst, mut lowest) = (0.0_f64, 0.0_f64);
    for (k, (_, q, _)) in kept.0.iter().enumerate() {
        (worst, lowest) = (worst.max((q[0] - z).abs()), lowest.min(q[0]));
        let error = -z;
        integral += t * error;
        let rate = if k == 0 { 0.0 } else { (error - before) / t };
        before = error;
        let u: f64 = 2941.995 + 3000.0 * error + 1500.0 * integral + 2000.0 * rate;
        assert!(u.abs() < 4500.0, "the motor carries it");
        let a = (u - weight) / 380.0;
        (z, v) = (z + t * v + 0.5 * t * t * a, v + t * a);
    }
    assert!(worst < 1e-9, "{worst:e}");
    assert!(lowest < -0.05 && kept.0.last().unwrap().1[0].abs() < 1e-3, "{lowest}");
}

/// What sticks slips at the instant at which its input says so, and stops are met between instants.
#[test]
fn friction_and_stops_heed_what_controllers_set() {
    let text = "gravity = [0, 0, 0]\n[simulate]\nstart = \"given\"\nduration = 4.0\ntolerance = 1e-10\n\
                [[body]]\nname = \"m\"\nmass = 1.0\nhinge = { type = \"prismatic\", axis = [1, 0, 0], friction = 2.0, \
                limits = { low = -0.3, high = 0.3, restitution = 0.3 } }\n\
                [[motor]]\nname = \"u\"\ntype = \"input\"\nhinge = \"m\"\n[[output]]\nname = \"x\"\ntype = \"coordinate\"\nof = \"m\"\n\
                [[controller]]\nname = \"bang\"\ntype = \"expression\"\nperiod = 0.1\nsenses = \"x\"\ndrives = \"u\"\n\
                expression = \"if(sin(3*t) > 0.2, 3.0, if(sin(3*t) < -0.2, -2.5, 1.0))\"\n";
    let (scenario, model) = scene(text);
    let mut ends = Vec::new();
    for integrator in ["auto", "dopri5", "radau5", "rk4"].into_iter().filter_map(Integrator::named) {
        let settings = Settings { integrator, ..scenario.simulate.clone() };
        let done = ran(&model, &settings, 10.0, &mut Kept::default()).unwrap();
        let first = &done.events[0];
        assert!(first.kind.name() == "slips" && (first.time - 0.1).abs() < 1e-12, "{integrator:?}: {first:?}");
        // From 0.1 s on with 1 m/s² to the stop, at 0.3 m.
        let strikes = done.events.iter().find(|event| event.kind.name() == "impact").unwrap();
        assert!((strikes.time - 0.1 - 0.6_f64.sqrt()).abs() < 1e-9, "{integrator:?}: {strikes:?}");
        assert!(done.energy_drift < 1e-11, "{integrator:?}: {:e}", done.energy_drift);
        ends.push(done.state.position[0]);
    }
    assert!(ends.iter().all(|x| (x - ends[0]).abs() < 1e-10), "{ends:?}");
}

/// A value that is infinite is said to be that.
#[test]
fn an_infinite_input_is_told_as_such() {
    let text = "[simulate]\nstart = \"given\"\nduration = 1.0\n[[body]]\nname = \"m\"\nmass = 1.0\n\
        hinge = { type = \"prismatic\", axis = [1, 0, 0] }\n[[motor]]\nname = \"push\"\nhinge = \"m\"\ntype = \"input\"\n\
        [[output]]\nname = \"x\"\ntype = \"position\"\nof = \"m\"\naxis = [1, 0, 0]\n\
        [[controller]]\nname = \"c\"\ntype = \"expression\"\nsenses = [\"x\"]\ndrives = [\"push\"]\nperiod = 0.25\n\
        expression = [\"1/(t-0.5)\"]\n";
    let (scenario, model) = scene(text);
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let failed = run(&model, &scenario.simulate, 10.0, &start, &mut Kept::default(), &mut |_, _| true);
    let said = failed.expect_err("a pole").to_string();
    assert!(said.contains("sets `push` to an infinite number"), "{said}");
}

/// A robot on two wheels that roll by friction leans, rolls after its fall and comes back: as its equations without slip, sampled alike, say.
#[test]
fn a_robot_balances_on_wheels_that_roll() {
    let mut text = std::fs::read_to_string(file("contact/balancing_robot")).unwrap();
    text = text.replace("[simulate]\n", "[simulate]\nstart = \"given\"\n");
    let lean: f64 = 0.1;
    let turned = format!("[0.0, 0.0, 0.1, {:?}, 0, {:?}, 0]", (0.5 * lean).cos(), (0.5 * lean).sin());
    text = text.replace("[0.0, 0.0, 0.1, 1, 0, 0, 0]", &turned);
    let (scenario, model) = scene(&text);
    let mut kept = Kept::default();
    let summary = ran(&model, &scenario.simulate, 100.0, &mut kept).unwrap();
    assert_eq!(summary.capture_steps, 0);
    let (rolling, radius, mass, above, inertia) = (1.0 + 0.005 / 0.01, 0.1, 4.0, 0.25, 0.08);
    let gains = [-1.3628, -6.2826, -1.4638, -1.1106];
    let rates = |[_, lean, v, w]: [f64; 4], torque: f64| {
        let (sin, cos) = lean.sin_cos();
        let (a, b, c) = (rolling + mass, mass * above * cos, inertia + mass * above * above);
        let (f, g) = (torque / radius + mass * above * sin * w * w, mass * 9.80665 * above * sin - torque);
        let det = a * c - b * b;
        [v, w, (c * f - b * g) / det, (a * g - b * f) / det]
    };
    let mut state = [0.0, lean, 0.0, 0.0];
    let (mut farthest, h) = (0.0_f64, 5e-4);
    for (k, (time, q, _)) in kept.0.iter().enumerate() {
        assert!((time - 0.01 * k as f64).abs() < 1e-12);
        let tilt = 2.0 * q[5].atan2(q[3]);
        assert!((q[0] - state[0]).abs() < 1e-7 && (tilt - state[1]).abs() < 1e-7, "{time}: {} {tilt} {state:?}", q[0]);
        farthest = farthest.max(q[0]);
        let torque = -2.0 * gains.iter().zip(state).map(|(gain, y)| gain * y).sum::<f64>();
        for _ in 0..20 {
            let add = |by: [f64; 4], h: f64| std::array::from_fn::<f64, 4, _>(|i| state[i] + h * by[i]);
            let one = rates(state, torque);
            let two = rates(add(one, 0.5 * h), torque);
            let three = rates(add(two, 0.5 * h), torque);
            let four = rates(add(three, h), torque);
            state = std::array::from_fn(|i| state[i] + h / 6.0 * (one[i] + 2.0 * (two[i] + three[i]) + four[i]));
        }
    }
    assert!(kept.0.len() == 601 && farthest > 0.05 && state[1].abs() < 1e-4, "{farthest} {state:?}");
}
