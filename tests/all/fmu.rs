//! FMUs: what their instances do beside runs, and what is refused. `fmu/tests` has them in FMPy's hands.

use crate::common::Random;
use crate::scenarios::file;
use assert_cmd::Command;
use std::fs;
use std::path::Path;
use stillpoint::fmu::{FmuError, Instance, MANIFEST, Manifest, Role};
use stillpoint::record::Fanout;
use stillpoint::scenario::parse;
use stillpoint::simulate::{self, State};
use stillpoint::simulator::Simulator;

/// A chain with springs and inputs; `b` holds the last one with an unknown torque if asked for.
fn chain(random: &mut Random, start: &str) -> String {
    let mut text = format!(
        "[parameters]\nm = {:?}\n[simulate]\nstart = \"{start}\"\nduration = 1.0\ntolerance = 1e-11\nintegrator = \"dop853\"\n",
        random.between(0.5, 2.0)
    );
    let count = 1 + random.below(4);
    for i in 0..count {
        let parent = if i == 0 { "ground".to_owned() } else { format!("b{}", i - 1) };
        let (kind, axis) =
            [("revolute", "[0, 1, 0]"), ("prismatic", "[1, 0, 0]"), ("revolute", "[1, 0, 0]")][random.below(3)];
        text += &format!(
            "[[body]]\nname = \"b{i}\"\nmass = \"{{m}} * {:?}\"\ncenter = [0.1, 0.02, -0.3]\ninertia = [0.1, 0.12, 0.05]\n\
             hinge = {{ type = \"{kind}\", parent = \"{parent}\", axis = {axis}, at = [0.0, 0.05, -0.4], stiffness = {:?}, \
             damping = {:?} }}\n[[motor]]\nname = \"u{i}\"\ntype = \"input\"\nhinge = \"b{i}\"\nforce = {:?}\n\
             [[output]]\nname = \"p{i}\"\ntype = \"position\"\nof = {{ body = \"b{i}\", at = [0, 0, -0.2] }}\n\
             [[output]]\nname = \"energy{i}\"\ntype = \"energy\"\nof = \"{}\"\n",
            random.between(0.5, 1.5),
            random.between(30.0, 90.0),
            random.between(0.1, 1.0),
            random.between(-1.0, 1.0),
            ["kinetic", "input", "dissipated"][random.below(3)],
        );
    }
    text
}

fn resources(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), text).unwrap();
    let manifest = Manifest {
        token: "t".into(),
        scenario: "scene.toml".into(),
        set: Vec::new(),
        parameters: vec!["gravity[2]".into()],
    };
    fs::write(folder.path().join(MANIFEST), manifest.to_json()).unwrap();
    folder
}

fn instance(folder: &tempfile::TempDir) -> Instance {
    Instance::new(folder.path(), "t").unwrap()
}

fn started(folder: &tempfile::TempDir) -> Instance {
    let mut instance = instance(folder);
    instance.enter_initialization(None, 0.0, None).unwrap();
    instance.exit_initialization().unwrap();
    instance
}

/// References of variables of one kind.
fn of(instance: &Instance, is: fn(&Role) -> bool) -> Vec<u32> {
    (0..).zip(&instance.variables().list).filter(|(_, one)| is(&one.role)).map(|(at, _)| at).collect()
}

fn all(instance: &mut Instance) -> Vec<f64> {
    let count = u32::try_from(instance.variables().list.len()).unwrap();
    (0..count).map(|reference| instance.value(reference).unwrap()).collect()
}

/// Steps of random lengths lead where one run does, to what the tolerance allows.
#[test]
fn steps_add_up_to_a_run() {
    for seed in 0..12 {
        let mut random = Random::new(seed);
        let text = chain(&mut random, "given");
        let folder = resources(&text);
        let mut instance = started(&folder);
        while instance.value(0).unwrap() < 0.8 {
            let now = instance.value(0).unwrap();
            let step = random.between(0.01, 0.2);
            assert_eq!(instance.step(now, step).unwrap().time, now + step);
        }
        let scenario = parse("scene.toml", &text, &[]).unwrap();
        let model = stillpoint::model::Model::build(&scenario.description).unwrap();
        let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
        let settings = simulate::Settings { duration: instance.value(0).unwrap(), ..scenario.simulate };
        let end = simulate::run(&model, &settings, 10.0, &start, &mut Fanout::new(), &mut |_, _| true).unwrap();
        let states = of(&instance, |role| matches!(role, Role::Position(_) | Role::Velocity(_)));
        for (reference, expected) in states.into_iter().zip(end.state.position.iter().chain(&end.state.velocity)) {
            let found = instance.value(reference).unwrap();
            assert!((found - expected).abs() < 1e-8 * (1.0 + expected.abs()), "{seed}: {found} {expected}");
        }
        let outputs = of(&instance, |role| matches!(role, Role::Output(_)));
        for reference in outputs {
            let Role::Output(place) = instance.variables().list[reference as usize].role else { continue };
            let found = instance.value(reference).unwrap();
            assert!((found - end.outputs[place]).abs() < 1e-7, "{seed}: {found} {}", end.outputs[place]);
        }
        // What counts from the start of a run is none of its variables.
        let counting = model.outputs.iter().filter(|output| {
            use stillpoint::model::output::EnergyKind;
            matches!(output.quantity, stillpoint::model::Quantity::Energy(EnergyKind::Input | EnergyKind::Dissipated))
        });
        assert_eq!(instance.variables().left_out, counting.map(|output| output.name.clone()).collect::<Vec<_>>());
    }
}

/// Whatever is called, and with whatever arguments: an error leaves everything as it was, and nothing panics.
#[test]
fn random_calls_are_done_or_refused() {
    let mut refused = 0;
    for seed in 0..40 {
        let mut random = Random::new(900 + seed);
        let start = ["given", "equilibrium"][random.below(2)];
        let folder = resources(&chain(&mut random, start));
        let mut instance = instance(&folder);
        let count = instance.variables().list.len() + 2;
        let mut kept = instance.situation().clone();
        for _ in 0..60 {
            let odd = [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300, 5e-324];
            let mut number = |likely: f64| if random.below(5) == 0 { odd[random.below(6)] } else { likely };
            let (one, other) = (number(0.1), number(0.0));
            let references: Vec<u32> = (0..random.below(3)).map(|_| random.below(count) as u32).collect();
            let before = instance.to_bytes(instance.situation());
            let reached = instance.value(0).unwrap();
            let answer = match random.below(10) {
                0 => instance.enter_initialization((one < 0.0).then_some(one), other, None),
                1 => instance.exit_initialization(),
                2 => instance.terminate(),
                3 => instance.set(&references, &references.iter().map(|_| one).collect::<Vec<_>>()),
                4 => references.iter().try_for_each(|reference| instance.value(*reference).map(|_| ())),
                5 => instance.directional_derivative(&references, &references, &[one, other]).map(|_| ()),
                6 => {
                    kept = instance.situation().clone();
                    Ok(())
                }
                7 => {
                    instance.restore(&kept);
                    Ok(())
                }
                // Steps that are no more than a second.
                _ if one > 1.0 && one.is_finite() => Ok(()),
                _ => instance.step(reached + other, one).map(|_| ()),
            };
            if answer.is_err() {
                refused += 1;
                // What an output asked for may have put the scene at its start: nothing that is seen.
                let same =
                    |bytes: &[u8]| String::from_utf8_lossy(bytes).split("\"snapshot\"").next().map(str::to_owned);
                assert_eq!(same(&instance.to_bytes(instance.situation())), same(&before), "{seed}: {answer:?}");
                assert_eq!(instance.value(0).unwrap(), reached);
            }
        }
    }
    assert!(refused > 400, "{refused}");
}

#[test]
fn damaged_states_are_refused() {
    let mut random = Random::new(77);
    let folder = resources(&chain(&mut random, "given"));
    let mut instance = started(&folder);
    instance.step(0.0, 0.1).unwrap();
    let bytes = instance.to_bytes(instance.situation());
    let expected = all(&mut instance);
    let again = instance.of_bytes(&bytes).unwrap();
    instance.restore(&again);
    assert_eq!(all(&mut instance), expected);
    for _ in 0..200 {
        let mut damaged = bytes.clone();
        let at = random.below(damaged.len());
        damaged[at] = random.below(256) as u8;
        damaged.truncate(random.below(2) * at + (1 - random.below(2)) * damaged.len());
        // A digit may have become another one: that is a state, too.
        if let Err(error) = instance.of_bytes(&damaged) {
            assert!(matches!(error, FmuError::State(_) | FmuError::Scene(_) | FmuError::Fixed { .. }), "{error:?}");
        }
    }
    assert_eq!(all(&mut instance), expected);
}

/// An input that statics finds: it starts with what holds the scene, and cannot be something else before.
#[test]
fn inputs_that_statics_finds_are_set_later() {
    let text = "[statics]\nunknown = [\"hold.force\"]\n[[body]]\nname = \"arm\"\nmass = 2.0\ncenter = [0.5, 0.0, 0.0]\n\
                inertia = [0.1, 0.1, 0.1]\nhinge = { type = \"revolute\", axis = [0, 1, 0] }\n\
                [[motor]]\nname = \"hold\"\ntype = \"input\"\nhinge = \"arm\"\n";
    let folder = resources(text);
    let mut instance = started(&folder);
    let hold = of(&instance, |role| matches!(role, Role::Input(_)))[0];
    let torque = instance.value(hold).unwrap();
    assert!((torque.abs() - 9.80665).abs() < 1e-9, "{torque}");
    instance.step(0.0, 0.5).unwrap();
    let angle = of(&instance, |role| matches!(role, Role::Position(_)))[0];
    assert!(instance.value(angle).unwrap().abs() < 1e-9);
    instance.set(&[hold], &[0.0]).unwrap();
    instance.step(0.5, 0.5).unwrap();
    assert!(instance.value(angle).unwrap().abs() > 0.1);
    instance.reset();
    instance.set(&[hold], &[1.0]).unwrap();
    instance.enter_initialization(None, 0.0, None).unwrap();
    assert!(matches!(instance.exit_initialization(), Err(FmuError::Fixed { .. })));
    instance.set(&[hold], &[torque]).unwrap();
    instance.exit_initialization().unwrap();
}

/// The outputs of a scene that leans on a stop are those of a run there, at once and after a step.
#[test]
fn outputs_at_a_stop_have_what_it_pushes_with() {
    let scenario = stillpoint::scenario::load(&file("arm_on_stop")).unwrap();
    let text = format!(
        "{}\n[[output]]\nname = \"borne\"\ntype = \"reaction\"\nof = \"{}\"\n",
        scenario.text, scenario.description.bodies[0].name
    );
    let scene = stillpoint::fmu::Scene::read("scene.toml", &text, &[]).unwrap();
    let (model, state) = stillpoint::fmu::at_start(&scene).unwrap();
    let mut simulator = Simulator::new(model, scene.scenario.simulate, state);
    let first = simulator.outputs().unwrap().to_vec();
    simulator.advance(0.1, &|| true).unwrap();
    let later = simulator.outputs().unwrap();
    assert!(first.iter().any(|x| x.abs() > 1.0), "{first:?}");
    for (first, later) in first.iter().zip(later) {
        assert!((first - later).abs() < 1e-6 * (1.0 + later.abs()), "{first} {later}");
    }
}

#[test]
fn names_that_clash_and_addresses_of_nothing_are_said() {
    let text = "[simulate]\nstart = \"given\"\n[[body]]\nname = \"arm\"\nmass = 1.0\ninertia = [1, 1, 1]\n\
                hinge = { type = \"revolute\", axis = [0, 1, 0] }\n[[output]]\nname = \"arm.mass\"\ntype = \"coordinate\"\nof = \"arm\"\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    fs::write(&path, text).unwrap();
    let call = |arguments: &[&str]| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_stillpoint"));
        let answer =
            program.current_dir(folder.path()).arg("fmu").arg(&path).arg("--describe").args(arguments).output();
        let answer = answer.unwrap();
        (answer.status.code(), String::from_utf8(answer.stderr).unwrap(), String::from_utf8(answer.stdout).unwrap())
    };
    let (code, error, _) = call(&["--parameter", "arm.mass"]);
    assert!(code == Some(2) && error.contains("`arm.mass` is a parameter and an output"), "{error}");
    fs::write(&path, text.replace("\"arm.mass\"", "\"a < b & c\"")).unwrap();
    let (code, _, description) = call(&["--parameter", "arm.mass"]);
    assert!(code == Some(0) && description.contains("name=\"a &lt; b &amp; c\""), "{description}");
    assert!(description.contains("name=\"arm.mass\" valueReference=\"1\" causality=\"parameter\""), "{description}");
    let (code, error, _) = call(&["--parameter", "arm.maas"]);
    assert!(code == Some(2) && error.contains("arm.maas"), "{error}");
    let (code, error, _) = call(&["--parameter", "gravity"]);
    assert!(code == Some(2) && error.contains("stands for 3 numbers: `gravity[0]`"), "{error}");
    assert!(fs::read_dir(Path::new(folder.path())).unwrap().count() == 1);
}

/// A random scene in motion, with inputs, that asks for all that is passed on and for energies and powers: an arm on springs, a four-bar linkage
/// whose rows share redundantly, or a drive that turns an arm with another one on it.
fn passing_on(random: &mut Random, kind: usize) -> String {
    let mut number = |from: f64, to: f64| random.between(from, to);
    let body = |name: &str, mass: f64, along: f64, hinge: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = {mass:?}\ncenter = [0, 0, {:?}]\ninertia = [0.01, 0.012, 0.003]\n\
             markers = {{ pin = [0, 0, {along:?}] }}\nhinge = {{ type = \"revolute\", axis = [0, 1, 0], {hinge} }}\n",
            0.5 * along
        )
    };
    let mut text =
        "[simulate]\nstart = \"given\"\nduration = 1.0\ntolerance = 1e-10\nintegrator = \"dop853\"\n".to_owned();
    let motor = |hinge: &str, force: f64| {
        format!("[[motor]]\nname = \"u {hinge}\"\ntype = \"input\"\nhinge = \"{hinge}\"\nforce = {force:?}\n")
    };
    let damped = format!("stiffness = {:?}, damping = {:?}", number(5.0, 30.0), number(0.1, 1.0));
    let mut forces = vec![("spring", "spring")];
    let [upper, lower] = [number(0.2, 0.5), number(0.2, 0.5)];
    match kind {
        0 | 2 => {
            let first = if kind == 0 {
                format!("velocity = {:?}, {damped}", number(-2.0, 2.0))
            } else {
                "at = [0, 0, 0]".to_owned()
            };
            text += &body("a", number(0.5, 2.0), upper, &first);
            text += &body(
                "b",
                number(0.5, 2.0),
                lower,
                &format!(
                    "parent = \"a\", at = \"pin\", position = {:?}, velocity = {:?}, {damped}",
                    number(-1.0, 1.0),
                    number(-3.0, 3.0)
                ),
            );
            text += &motor("b", number(-1.0, 1.0));
            if kind == 0 {
                text += &motor("a", number(-1.0, 1.0));
            } else {
                text += &format!(
                    "[[drive]]\nname = \"turn\"\nhinge = \"a\"\ntype = \"rate\"\nrate = {:?}\n",
                    number(0.5, 2.0)
                );
                forces.push(("drive", "turn"));
            }
        }
        _ => {
            text += &body("a", number(0.5, 2.0), 0.1, &format!("velocity = {:?}, {damped}", number(4.0, 10.0)));
            text += &body("b", number(0.5, 2.0), 0.35, "parent = \"a\", at = \"pin\", position = 1.1");
            text += &body("c", number(0.5, 2.0), 0.3, "at = [0.4, 0, 0], position = -0.2");
            text +=
                "[[loop]]\nname = \"joint\"\ntype = \"revolute\"\nbetween = [\"b.pin\", \"c.pin\"]\naxis = [0, 1, 0]\n";
            text += &motor("a", number(-1.0, 1.0));
            text += &motor("c", number(-1.0, 1.0));
            forces.push(("loop", "joint"));
        }
    }
    text += &format!(
        "[[force]]\nname = \"spring\"\ntype = \"spring\"\nbetween = [\"b.pin\", {{ body = \"ground\", at = [0.3, 0.1, 0.7] }}]\n\
         stiffness = {:?}\nlength = 0.2\ndamping = {:?}\n",
        number(10.0, 60.0),
        number(0.1, 2.0)
    );
    let mut output = |name: &str, kind: &str, of: &str| {
        text += &format!("[[output]]\nname = \"{name}\"\ntype = \"{kind}\"\nof = \"{of}\"\n");
    };
    for (kind, of) in [("energy", "kinetic"), ("energy", "potential"), ("power", "input"), ("power", "dissipated")] {
        output(&format!("{of} {kind}"), kind, of);
    }
    for (what, of) in forces {
        output(&format!("of {what}"), "force", of);
    }
    ["a", "b"].iter().for_each(|body| output(&format!("passed to {body}"), "reaction", body));
    text + "[[output]]\nname = \"formula\"\ntype = \"expression\"\nexpression = \"{passed to a[0]} * {input power} + {kinetic energy}\"\nunit = \"N W\"\n"
}

/// Derivatives of reactions, forces of loops and drives, energies and powers are what outputs do that are asked for at other inputs: all but the
/// formula are affine in them, so that the difference is exact whatever its distance.
#[test]
fn derivatives_of_what_is_passed_on_are_differences() {
    let mut felt = std::collections::BTreeSet::new();
    for seed in 0..18 {
        let mut random = Random::new(5000 + seed);
        let folder = resources(&passing_on(&mut random, seed as usize % 3));
        let mut instance = started(&folder);
        instance.step(0.0, 0.05 + 0.01 * seed as f64).unwrap();
        let (inputs, outputs) = (
            of(&instance, |role| matches!(role, Role::Input(_))),
            of(&instance, |role| matches!(role, Role::Output(_))),
        );
        let along: Vec<f64> = inputs.iter().map(|_| random.between(-2.0, 2.0)).collect();
        let found = instance.directional_derivative(&outputs, &inputs, &along).unwrap();
        let before: Vec<f64> = inputs.iter().map(|input| instance.value(*input).unwrap()).collect();
        let mut at = |h: f64| -> Vec<f64> {
            let moved: Vec<f64> = before.iter().zip(&along).map(|(before, by)| before + h * by).collect();
            instance.set(&inputs, &moved).unwrap();
            outputs.iter().map(|output| instance.value(*output).unwrap()).collect()
        };
        // Central differences are exact for the product of two affine numbers, too.
        let [there, back] = [at(1.0), at(-1.0)];
        for (k, output) in outputs.iter().enumerate() {
            let (difference, size) = (0.5 * (there[k] - back[k]), there[k].abs().max(back[k].abs()));
            let name = &instance.variables().list[*output as usize].name;
            // Round-off of numbers of that size: forces of redundant rows are solved for.
            assert!((found[k] - difference).abs() < 1e-9 * (1.0 + size), "{seed} {name}: {} {difference}", found[k]);
            if difference.abs() > 1e-6 {
                felt.insert(name.split('[').next().unwrap_or_default().to_owned());
            }
        }
    }
    for name in ["input power", "of drive", "of loop", "passed to a", "passed to b", "formula"] {
        assert!(felt.contains(name), "{name}: {felt:?}");
    }
    // What positions and velocities alone decide does not answer at once.
    assert!(
        !felt.iter().any(|name| name.contains("energy") || name == "dissipated power" || name == "of spring"),
        "{felt:?}"
    );
}
