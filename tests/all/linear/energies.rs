//! Energies and powers as rows: by differences, and by each other, as power is how energy changes.

use super::*;
use stillpoint::model::output::{EnergyKind, PowerKind};

const KINETIC: &str = "kinetic energy";
const POTENTIAL: &str = "potential energy";
const INPUT: &str = "power put in";
const LOST: &str = "power taken out";

/// Adds the energies and powers that are no sums over a run.
pub(super) fn with_energies(mut scene: Description) -> Description {
    let all = [
        (KINETIC, QuantityDescription::Energy(EnergyKind::Kinetic)),
        (POTENTIAL, QuantityDescription::Energy(EnergyKind::Potential)),
        (INPUT, QuantityDescription::Power(PowerKind::Input)),
        (LOST, QuantityDescription::Power(PowerKind::Dissipated)),
    ];
    scene.outputs.extend(all.map(|(name, of)| OutputDescription::new(name, of)));
    scene
}

/// Whether an output is one of those whose rows do not follow from changed scenes: an input is no part of the scene, and has no potential.
pub(super) fn counts_as_work(name: &str) -> bool {
    [POTENTIAL, INPUT].contains(&name)
}

/// The rows of energy, kinetic and potential, and of power, put in less taken out, by states and by inputs.
fn rows(found: &StateSpace) -> [[Vec<f64>; 2]; 2] {
    let row = |name: &str| {
        let missing = || panic!("no `{name}`: {:?} {:?}", found.left_out, found.notes);
        found.outputs.iter().position(|signal| signal.name == name).unwrap_or_else(missing)
    };
    let sum = |[first, second]: [&str; 2], sign: f64| {
        let (first, second) = (row(first), row(second));
        [&found.c, &found.d].map(|m| (0..m.ncols()).map(|j| m[(first, j)] + sign * m[(second, j)]).collect::<Vec<_>>())
    };
    [sum([KINETIC, POTENTIAL], 1.0), sum([INPUT, LOST], -1.0)]
}

/// `∂E/∂x B = ∂P/∂u` at every place, since `∂E/∂x ẋ = P` is affine in inputs: what an input adds to the accelerations is what it does as work.
pub(super) fn inputs_do_work(found: &StateSpace, what: &str) {
    let [[energy, _], [_, power]] = rows(found);
    for (j, power) in power.iter().enumerate() {
        let terms = || (0..energy.len()).map(|i| energy[i] * found.b[(i, j)]);
        let (sum, size) = (terms().sum::<f64>(), terms().map(f64::abs).sum::<f64>());
        // Differences are right to nine digits of what is usual, here 1 J and 1 W.
        assert!((sum - power).abs() < 1e-8 * (1.0 + size), "{what}: {sum} for {power} by {}", found.inputs[j].name);
    }
}

/// `∂E/∂x A = ∂P/∂x` where nothing accelerates: in loops, with drives as inputs, whose power is what they push with times their speed.
#[test]
fn powers_are_rates_of_energies() {
    let mut checked = 0;
    let mut check = |description: Description, settings: &statics::Settings, what: &str| {
        let description = with_energies(description);
        let Ok((model, _)) = assemble(Model::build(&description).unwrap()) else { return };
        let Ok(found) = statics::equilibrium(&model, settings, &model.start_position) else { return };
        if !found.converged || !found.stops.is_empty() || found.velocity.iter().any(|v| *v != 0.0) {
            return;
        }
        let names =
            description.drives.iter().map(|one| &one.name).chain(description.motors.iter().map(|one| &one.name));
        let inputs: Vec<Input> =
            names.flat_map(|name| Input::find(&description, &model, name).expect("an input")).collect();
        let linear = linearize(&model, &of_equilibrium(&model, &found), &inputs, None)
            .unwrap_or_else(|error| panic!("{what}: {error}"));
        let redundant = linear.notes.iter().any(|note| note.contains("more rows share it"));
        if redundant {
            return;
        }
        inputs_do_work(&linear, what);
        let [[energy, _], [power, _]] = rows(&linear);
        let size = energy.iter().map(|x| x.abs()).fold(1.0, f64::max);
        let most = (0..energy.len()).flat_map(|i| (0..energy.len()).map(move |j| (i, j)));
        let most = most.map(|(i, j)| linear.a[(i, j)].abs()).fold(1.0, f64::max);
        for (j, power) in power.iter().enumerate() {
            let sum: f64 = (0..energy.len()).map(|i| energy[i] * linear.a[(i, j)]).sum();
            // An equilibrium is one to 1e-9 or so of its forces, of which A makes accelerations.
            assert!(
                (sum - power).abs() < 1e-7 * size * most.sqrt(),
                "{what}: {sum} for {power} by {}",
                linear.states[j].name
            );
            checked += usize::from(power.abs() > 1e-3);
        }
    };
    for (seed, tied) in (0..20).flat_map(|seed| [(seed, false), (seed, true)]) {
        let mut description = scene(seed, tied);
        description.bodies.iter_mut().for_each(|body| body.hinge.velocity.clear());
        check(description, &statics::Settings::default(), &format!("{seed} {tied}"));
    }
    for name in ["double_wishbone", "four_bar", "spring_arm", "quarter_car", "rope_over_pulleys"] {
        let scenario = load(&file(name)).unwrap();
        check(scenario.description.clone(), &scenario.statics, name);
    }
    assert!(checked >= 5, "{checked}");
}

const ARM: &str = r#"
    [[body]]
    name = "arm"
    mass = 2.0
    center = [0.5, 0, 0]
    inertia = [0.1, 0.1, 0.1]
    hinge = { type = "revolute", axis = [0, 1, 0], HINGE }
    [[motor]]
    name = "lift"
    type = "input"
    hinge = "arm"
    force = -3.0
    [[output]]
    name = "T"
    type = "energy"
    of = "kinetic"
    [[output]]
    name = "V"
    type = "energy"
    of = "potential"
    [[output]]
    name = "W"
    type = "energy"
    of = "input"
    [[output]]
    name = "P"
    type = "power"
    of = "input"
    [[output]]
    name = "L"
    type = "power"
    of = "dissipated"
    [[output]]
    name = "half"
    type = "expression"
    expression = "0.5 * V + W"
    unit = "J"
    [[output]]
    name = "square"
    type = "expression"
    expression = "V^2 + P"
    unit = "J"
"#;

/// An arm that leans on a compliant stop: its potential includes that of the stop, so that only the motor's torque is left of the
/// gradient, and the power of the motor is that torque times the rate.
#[test]
fn what_stops_store_is_in_the_potential() {
    let text = ARM.replace("HINGE", "limits = { low = -1.0, high = 0.1, stiffness = 400.0, damping = 3.0 }");
    let (code, found, said) = told(&text, &[]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(found["outputs"], serde_json::json!(["T", "V", "P", "L", "square"]), "{found}");
    let entry = |name: &str, matrix: &str, j: usize| {
        let row = found["outputs"].as_array().unwrap().iter().position(|one| one == name).unwrap();
        found[matrix][row][j].as_f64().unwrap()
    };
    for j in 0..2 {
        // At rest nothing is of first order but: V by the angle, and P by the rate.
        let expected = [("T", 0.0), ("V", [-3.0, 0.0][j]), ("P", [0.0, -3.0][j]), ("L", 0.0)];
        for (name, expected) in expected {
            assert!((entry(name, "C", j) - expected).abs() < 1e-7, "{name} by {j}: {found}");
        }
    }
    for name in ["T", "V", "P", "L"] {
        assert_eq!(entry(name, "D", 0), 0.0, "{name}: {found}");
    }
    // V² follows by the chain rule from the potential there, which the program tells, too.
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.toml"), &text).unwrap();
    let mut statics = Command::new(env!("CARGO_BIN_EXE_stillpoint"));
    let answer = statics.current_dir(folder.path()).args(["statics", "scene.toml", "--json"]).output().unwrap();
    let answer: Value = serde_json::from_slice(&answer.stdout).unwrap();
    let potential = answer["outputs"]["V"].as_f64().unwrap();
    assert!((entry("square", "C", 0) - 2.0 * potential * -3.0).abs() < 1e-6 * potential.abs(), "{potential}: {found}");
}

/// What is left out is told with its reason, each reason once; what is asked for by name is refused with it.
#[test]
fn reasons_stand_beside_what_is_left_out() {
    let text = ARM.replace("HINGE", "stiffness = 50.0");
    let force = "[[output]]\nname = \"pushes\"\ntype = \"force\"\nof = \"lift\"\n";
    let (code, found, said) = told(&format!("{text}{force}"), &[]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(found["left_out"], serde_json::json!(["W", "half", "pushes"]));
    let notes = found["notes"].to_string();
    assert!(notes.contains("left out: `W`, `half`: it is added up from the start of a run"), "{notes}");
    assert!(
        notes.contains("left out: `pushes`: it is, or may follow from, the force of the input `lift` itself"),
        "{notes}"
    );
    let (code, _, said) = told(&text, &["--output", "half"]);
    assert!(code == Some(2) && said.contains("`half`") && said.contains("added up from the start of a run"), "{said}");
}
