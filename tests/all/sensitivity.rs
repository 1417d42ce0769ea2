//! Sensitivities of equilibria: against differences of equilibria that are found again, against closed forms, and what has none.

use crate::linear::scene;
use crate::scenarios::file;
use assert_cmd::Command;
use serde_json::Value;
use std::sync::Arc;
use stillpoint::constraint::assemble;
use stillpoint::model::description::*;
use stillpoint::model::{Model, Parameter};
use stillpoint::scenario::parse;
use stillpoint::statics::{self, Equilibrium, SensitivityError, influences, sensitivities};

/// What is asked of every scene.
fn asked(found: &Equilibrium, model: &Model) -> Vec<String> {
    let mut names: Vec<String> = model.outputs.iter().map(|output| output.name.clone()).collect();
    let modes = found.stability.iter().flat_map(|of| of.frequencies()).collect::<Vec<f64>>();
    let alone = |i: usize| modes.iter().enumerate().all(|(j, f)| i == j || (f / modes[i] - 1.0).abs() > 1e-3);
    let smooth = model.is_conservative() && found.velocity.iter().all(|v| *v == 0.0);
    names.extend((0..modes.len()).filter(|i| smooth && alone(*i)).map(|i| format!("frequency[{i}]")));
    names
}

/// A model, loops closed, and its equilibrium next to the start.
fn solved(description: &Description) -> Option<(Arc<Model>, Equilibrium)> {
    let model = assemble(Model::build(description).ok()?).ok()?.0;
    let settings = statics::Settings { want: statics::Want::Any, ..Default::default() };
    let found = statics::equilibrium(&model, &settings, &model.start_position).ok()?;
    found.balanced.then_some((model, found))
}

/// Outputs and frequencies of the equilibrium next to a position with another value of a number.
fn again(description: &Description, one: &Parameter, value: f64, near: &[f64]) -> Option<Vec<f64>> {
    let mut moved = description.clone();
    // Loops are closed from there.
    for (body, built) in moved.bodies.iter_mut().zip(&Model::build(description).ok()?.bodies) {
        body.hinge.position = near[built.hinge.position..][..built.hinge.kind.counts().0].to_vec();
    }
    one.set(&mut moved, value).ok()?;
    let (model, found) = solved(&moved)?;
    let apart = found.position.iter().zip(near).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    if apart > 0.2 {
        return None;
    }
    let mut all = statics::outputs(&model, &found).ok()?;
    all.extend(found.stability.iter().flat_map(|of| of.frequencies()));
    Some(all)
}

/// Derivatives of these by differences of equilibria over `h` and `h / 2`, extrapolated; and how far the two are apart.
fn by_solving(description: &Description, one: &Parameter, h: f64, near: &[f64]) -> Option<Vec<[f64; 2]>> {
    let value = one.value(description);
    let difference = |h: f64| -> Option<Vec<f64>> {
        let [after, before] = [value + h, value - h].map(|value| again(description, one, value, near));
        let (after, before) = (after?, before?);
        (after.len() == before.len()).then(|| after.iter().zip(&before).map(|(a, b)| (a - b) / (2.0 * h)).collect())
    };
    let [whole, half, quarter] = [difference(h)?, difference(0.5 * h)?, difference(0.25 * h)?];
    let of = |i: usize| {
        let [first, second] = [[whole[i], half[i]], [half[i], quarter[i]]].map(|[a, b]| b + (b - a) / 3.0);
        let best = second + (second - first) / 15.0;
        [best, (best - second).abs()]
    };
    Some((0..whole.len()).map(of).collect())
}

/// How far equilibria are found again, as a part of a number.
const REACH: f64 = 1.6e-2;
/// A search ends at 1e-13 of the forces: what it leaves open of an output, over a quarter of the distance and with some stiffness to
/// spare.
const LEFT: f64 = 1e-11;

/// Compares some columns of a scene, to 1e-7 of what differences can tell; how many these are, and the largest error.
fn compare(name: &str, description: &Description, every: usize, skip: usize) -> (usize, f64) {
    let Some((model, found)) = solved(description) else { return (0, 0.0) };
    if found.stability.as_ref().is_none_or(|of| of.neutral_directions > 0) {
        return (0, 0.0);
    }
    let names = asked(&found, &model);
    let numbers: Vec<Parameter> = influences(description).into_iter().skip(skip % every).step_by(every).collect();
    let table = match sensitivities(description, &model, &found, &names, Some(numbers.clone()), &|| true) {
        Ok(table) => table,
        Err(error) => panic!("{name}: {error}"),
    };
    let places = model.outputs.iter().flat_map(|output| output.range()).chain(names.iter().filter_map(|name| {
        let index: usize = name.strip_prefix("frequency[")?.strip_suffix(']')?.parse().ok()?;
        Some(model.outputs.last().map_or(0, |last| last.range().end) + index)
    }));
    let places: Vec<usize> = places.collect();
    let (mut count, mut worst) = (0, 0.0_f64);
    for (column, one) in numbers.iter().enumerate() {
        let h = REACH * one.value(description).abs().max(1.0);
        let Some(other) = by_solving(description, one, h, &found.position) else { continue };
        for (row, place) in places.iter().enumerate() {
            let [expected, unsure] = other[*place];
            let (of, by, value) = (&table.outputs[row].name, &one.address, table.outputs[row].value);
            let Some(derivative) = table.derivatives[row][column] else {
                panic!("{name}: no derivative of `{of}` by `{by}`: {:?}", table.notes)
            };
            // What a search that ends at a balance leaves open, over the shortest distance.
            let noise = (LEFT * value.abs().max(1.0) / h).max(unsure);
            let error = (derivative - expected).abs();
            let message =
                format!("{name}: `{of}` by `{by}`: {derivative:e}, by solving again {expected:e} ± {noise:e}");
            assert!(error < 1e-7 * expected.abs() + 5.0 * noise, "{message}");
            if noise < 2e-8 * expected.abs() {
                assert!(error < 1e-7 * expected.abs(), "{message}");
                (count, worst) = (count + 1, worst.max(error / expected.abs()));
            }
        }
    }
    (count, worst)
}

/// More outputs: what follows from the balance.
fn with_loads(mut scene: Description) -> Description {
    let tip = scene.bodies[1].name.clone();
    let reaction = QuantityDescription::Reaction { body: "b0".into(), component: None, axes: Axes::Body };
    scene.outputs.push(OutputDescription::new("passed on", reaction));
    scene.outputs.push(OutputDescription::new("o", QuantityDescription::Orientation { body: tip }));
    scene.outputs.push(OutputDescription::new("V", QuantityDescription::Energy(EnergyKind::Potential)));
    for closed in scene.loops.clone() {
        let push = QuantityDescription::Force { of: closed.name.clone(), component: None };
        scene.outputs.push(OutputDescription::new(&format!("push of {}", closed.name), push));
    }
    // Something holds every hinge, or an equilibrium is an accident.
    for body in &mut scene.bodies {
        let count = body.hinge.kind.counts().1;
        body.hinge.stiffness = (0..count).map(|i| 30.0 + 10.0 * i as f64).collect();
    }
    scene
}

#[test]
fn derivatives_are_those_of_equilibria_found_again() {
    for tied in [false, true] {
        let (mut scenes, mut count, mut worst) = (0, 0, 0.0_f64);
        for seed in 0..40 {
            let mut random = with_loads(scene(seed, tied));
            if seed % 5 == 4 {
                random.bodies[2].hinge.lock = true;
            }
            let (some, error) = compare(&format!("seed {seed}, loops: {tied}"), &random, 7, seed as usize);
            scenes += usize::from(some > 0);
            (count, worst) = (count + some, worst.max(error));
        }
        println!("loops: {tied}: {scenes} scenes, {count} derivatives, largest error {worst:.1e}");
        assert!(scenes >= 30, "{scenes}");
    }
}

/// Asked for all numbers at once the adjoint equations answer, asked for one the direct ones: two ways, one answer.
#[test]
fn numbers_asked_for_together_answer_as_alone() {
    for (name, every) in [("double_wishbone", 4), ("machine_on_mounts", 5), ("spring_arm", 6)] {
        let description = stillpoint::scenario::load(&file(name)).unwrap().description;
        let (model, found) = solved(&description).unwrap();
        let names = asked(&found, &model);
        let all = sensitivities(&description, &model, &found, &names, None, &|| true).unwrap();
        let numbers = influences(&description);
        let motions = found.stability.as_ref().map_or(0, |of| of.modes.len());
        assert!(numbers.len() > motions && motions > 0, "{name}: {} {motions}", numbers.len());
        for (column, one) in numbers.iter().enumerate().step_by(every) {
            let alone = sensitivities(&description, &model, &found, &names, Some(vec![one.clone()]), &|| true).unwrap();
            for (row, output) in all.outputs.iter().enumerate() {
                let (together, alone) = (all.derivatives[row][column], alone.derivatives[row][0]);
                assert_eq!(together.is_some(), alone.is_some(), "{name}: `{}` by `{}`", output.name, one.address);
                let Some((together, alone)) = together.zip(alone) else { continue };
                // Both are known to 1e-9 of themselves, or to round-off of the output over the number.
                let size = output.value.abs().max(1.0) / one.value(&description).abs().max(1.0);
                let error = (together - alone).abs();
                assert!(
                    error <= 1e-8 * alone.abs() + 1e-10 * size,
                    "{name}: `{}` by `{}`: {together:e} {alone:e}",
                    output.name,
                    one.address
                );
            }
        }
    }
}

/// Loads that follow their bodies have no potential, and the stiffness no symmetry: all numbers at once answer as alone.
#[test]
fn numbers_asked_for_together_answer_as_alone_beside_a_load_that_follows() {
    let link = |name: &str, parent: &str, k: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = 1.5\ncenter = [0.5, 0, 0]\nmarkers = {{ tip = [1, 0, 0] }}\n\
             hinge = {{ type = \"revolute\", parent = \"{parent}\", at = [{}, 0, 0], axis = [0, 1, 0], stiffness = {k} }}\n",
            if parent == "ground" { 0.0 } else { 1.0 }
        )
    };
    let text = [
        link("a", "ground", 60.0),
        link("b", "a", 40.0),
        link("c", "b", 30.0),
        "[[force]]\nname = \"jet\"\ntype = \"load\"\non = \"c.tip\"\nforce = [-3, 0, 4]\naxes = \"body\"\n".to_owned(),
        "[[output]]\nname = \"tip\"\ntype = \"position\"\nof = \"c.tip\"\n".to_owned(),
    ];
    let description = parse("jet.toml", &text.concat(), &[]).unwrap().description;
    let (model, found) = solved(&description).unwrap();
    assert!(!model.is_conservative_at_rest());
    let all = sensitivities(&description, &model, &found, &["tip".to_owned()], None, &|| true).unwrap();
    for (column, one) in influences(&description).iter().enumerate() {
        let numbers = Some(vec![one.clone()]);
        let alone = sensitivities(&description, &model, &found, &["tip".to_owned()], numbers, &|| true).unwrap();
        for row in 0..3 {
            let (together, alone) = (all.derivatives[row][column].unwrap(), alone.derivatives[row][0].unwrap());
            let error = (together - alone).abs();
            assert!(error <= 1e-8 * alone.abs() + 1e-10, "{} {}: {together:e} {alone:e}", row, one.address);
        }
    }
}

/// A scene of many stages, loads that follow, guides and 299 numbers: each costs a differentiated residual of the structure before the first stage,
/// and that far less than the equilibrium does.
#[test]
fn all_numbers_of_a_large_scene_are_soon_there() {
    let launcher = file("launcher");
    let took = |more: &[&str]| {
        let begun = std::time::Instant::now();
        let mut command = Command::new(env!("CARGO_BIN_EXE_stillpoint"));
        let output = command.arg("statics").arg(&launcher).args(more).args(["--json", "--quiet"]).output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        (begun.elapsed().as_secs_f64(), serde_json::from_slice::<Value>(&output.stdout).unwrap())
    };
    let (alone, _) = took(&[]);
    let (all, answer) = took(&["--sensitivity", "elevation"]);
    let numbers = answer["sensitivities"]["elevation"].as_object().unwrap();
    assert_eq!(numbers.values().filter(|one| one.is_null()).count(), 12, "rockets whose masses burn");
    let count = numbers.len() as f64;
    assert!(count > 250.0 && all < 0.25 * count * alone, "{count} numbers: {all} s beside {alone} s");
}

/// A weight on a spring, and a rope that is slack, taut, or just so.
fn scale(extra: &str) -> String {
    format!(
        "[[body]]\nname = \"pan\"\nmass = 2.0\nhinge = {{ type = \"prismatic\", axis = [0, 0, 1], stiffness = 100.0 }}\n\
         [[output]]\nname = \"z\"\ntype = \"coordinate\"\nof = \"pan\"\n\
         [[output]]\nname = \"V\"\ntype = \"energy\"\nof = \"potential\"\n{extra}"
    )
}

fn answers(text: &str, asked: &[&str]) -> Result<stillpoint::statics::Sensitivities, SensitivityError> {
    let scenario = parse("scene.toml", text, &[]).unwrap();
    let model = assemble(Model::build(&scenario.description).unwrap()).unwrap().0;
    let found = statics::equilibrium(&model, &scenario.statics, &model.start_position).unwrap();
    let asked: Vec<String> = asked.iter().map(|name| (*name).to_owned()).collect();
    sensitivities(&scenario.description, &model, &found, &asked, None, &|| true)
}

fn derivative(table: &stillpoint::statics::Sensitivities, output: usize, address: &str) -> Option<f64> {
    let column = table.parameters.iter().position(|one| one.address == address);
    table.derivatives[output][column.unwrap_or_else(|| panic!("no {address}"))]
}

/// `z = −m g / k`, `V = m g z + k z²/2 = −(m g)²/2k`, `f = √(k/m)/2π`.
#[test]
fn a_weight_on_a_spring_answers_as_in_closed_form() {
    let table = answers(&scale(""), &["z", "V", "frequency[0]"]).unwrap();
    let (m, g, k) = (2.0, 9.80665, 100.0_f64);
    let f = (k / m).sqrt() / std::f64::consts::TAU;
    for (output, address, expected) in [
        (0, "pan.mass", -g / k),
        (0, "gravity[2]", m / k),
        (0, "gravity[0]", 0.0),
        (0, "pan.stiffness", m * g / (k * k)),
        (0, "pan.rest", 1.0),
        (0, "pan.force", 1.0 / k),
        (1, "pan.mass", -m * g * g / k),
        (1, "pan.stiffness", (m * g / k).powi(2) / 2.0),
        (2, "pan.stiffness", 0.5 * f / k),
        (2, "pan.mass", -0.5 * f / m),
        (2, "pan.rest", 0.0),
    ] {
        let found = derivative(&table, output, address).unwrap();
        assert!((found - expected).abs() <= 1e-10 * expected.abs(), "{output} by {address}: {found} for {expected}");
    }
    assert!(table.parameters.iter().all(|one| one.address != "pan.position"), "a guess moves nothing");
}

/// What a compliant stop bears follows from the springs of both: `z = (k_s l − m g)/(k + k_s)`.
#[test]
fn stops_that_bear_take_part() {
    let stop = "limits = { low = -0.1, high = 1.0, stiffness = 300.0 }";
    let text = scale("").replace("stiffness = 100.0", &format!("stiffness = 100.0, rest = 0.02, {stop}"));
    let table = answers(&text, &["z", "V"]).unwrap();
    let (m, g, k, s, l, r) = (2.0, 9.80665, 100.0_f64, 300.0, -0.1, 0.02);
    let z = (k * r + s * l - m * g) / (k + s);
    for (output, address, expected) in [
        (0, "pan.mass", -g / (k + s)),
        (0, "pan.stiffness", (r - z) / (k + s)),
        (1, "pan.mass", g * z),
        (1, "pan.stiffness", (z - r) * (z - r) / 2.0),
        (1, "pan.rest", k * (r - z)),
    ] {
        let found = derivative(&table, output, address).unwrap();
        assert!((found - expected).abs() <= 1e-9 * expected.abs(), "{output} by {address}: {found} for {expected}");
    }
    assert!(table.notes.iter().any(|note| note.contains("as long as the stops of `pan` bear")), "{:?}", table.notes);
    let rigid = scale("").replace("stiffness = 100.0", "stiffness = 100.0, limits = [-0.1, 1.0]");
    let table = answers(&rigid, &["z", "V"]).unwrap();
    assert_eq!(derivative(&table, 0, "pan.mass"), Some(0.0));
    assert!((derivative(&table, 1, "pan.mass").unwrap() + 9.80665 * 0.1).abs() < 1e-10);
}

/// What is stiff beside what is soft (an elastic cable that bends easily, on an arm that a loop holds) has derivatives, too: those of differences
/// of equilibria.
#[test]
fn a_cable_on_a_held_arm_answers_as_when_found_again() {
    let text = |rod: f64, cable: f64| {
        format!(
            "[[body]]\nname = \"arm\"\nmass = 2.0\ninertia = [0.02, 0.2, 0.2]\ncenter = [0.5, 0, 0]\nmarkers = {{ tip = [1, 0, 0] }}\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0] }}\n\
             [[body]]\nname = \"bar\"\nmass = 0.5\ninertia = [0.01, 0.05, 0.05]\ncenter = [0.2, 0, 0]\nmarkers = {{ end = [0.4, 0, 0] }}\n\
             hinge = {{ type = \"revolute\", parent = \"arm\", at = \"tip\", axis = [0, 1, 0], stiffness = 20.0 }}\n\
             [[loop]]\nname = \"rod\"\ntype = \"rod\"\nbetween = [\"arm.tip\", {{ body = \"ground\", at = [1, 0, 1] }}]\nlength = {rod}\n\
             [[cable]]\nname = \"c\"\nbetween = [\"bar.end\", {{ body = \"ground\", at = [2, 0, 0] }}]\nlength = {cable}\n\
             section = {{ circle = 0.002 }}\nmaterial = {{ young = 5e9, density = 2000.0 }}\nbending = 0.0005\nelements = 6\n\
             [[output]]\nname = \"x\"\ntype = \"position\"\nof = \"bar.end\"\naxis = [0, 0, 1]\n"
        )
    };
    let place = |rod: f64, cable: f64| {
        let scenario = parse("arm.toml", &text(rod, cable), &[]).unwrap_or_else(|why| panic!("{why}"));
        let (model, found) = solved(&scenario.description).expect("an equilibrium");
        statics::outputs(&model, &found).expect("numbers")[0]
    };
    let table = answers(&text(1.0, 0.6), &["x"]).unwrap_or_else(|why| panic!("{why}"));
    for (address, by) in [("rod.length", [1.0, 0.0]), ("c.length", [0.0, 1.0])] {
        let difference =
            |h: f64| (place(1.0 + h * by[0], 0.6 + h * by[1]) - place(1.0 - h * by[0], 0.6 - h * by[1])) / (2.0 * h);
        let expected = (4.0 * difference(5e-5) - difference(1e-4)) / 3.0;
        let found = derivative(&table, 0, address).unwrap_or_else(|| panic!("none by {address}: {:?}", table.notes));
        assert!((found / expected - 1.0).abs() < 1e-5, "{address}: {found} {expected}");
    }
}

/// Which end of a cable comes first is a matter of the drawing.
#[test]
fn stays_answer_whichever_end_comes_first() {
    let path = format!("{}/scenarios/stayed_mast.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("a shipped scenario");
    let mut turned = text.clone();
    for at in ["[8.0, 0.0, 0.0]", "[-4.0, 7.0, 0.0]", "[-4.0, -7.0, 0.0]"] {
        let [ground, top] = [format!("{{ body = \"ground\", at = {at} }}"), "\"mast.top\"".to_owned()];
        let [one, other] = [format!("[{ground}, {top}]"), format!("[{top}, {ground}]")];
        let (from, to) = if turned.contains(&one) { (&one, &other) } else { (&other, &one) };
        assert!(turned.contains(from), "{at}");
        turned = turned.replace(from, to);
    }
    let of = |text: &str| {
        let table = answers(text, &["length"]).unwrap_or_else(|why| panic!("{why}"));
        derivative(&table, 0, "fore.pretension").unwrap_or_else(|| panic!("{:?}", table.notes))
    };
    let (one, other) = (of(&text), of(&turned));
    // A pretension is that of the first end, which the weight of the cable makes another one at the top.
    assert!((one / other - 1.0).abs() < 0.03, "{one} {other}");
}

#[test]
fn what_is_at_a_switch_has_no_derivative_and_says_so() {
    let rope = |length: f64| {
        let ends = "through = [\"pan\", { body = \"ground\", at = [0, 0, 1] }]";
        scale(&format!("[[force]]\nname = \"rope\"\ntype = \"rope\"\n{ends}\nstiffness = 50.0\nlength = {length:?}\n"))
    };
    let sag = 2.0 * 9.80665 / 100.0;
    for (length, expected) in [(1.5, Some(-9.80665 / 100.0)), (1.0, Some(-9.80665 / 150.0)), (1.0 + sag, None)] {
        let table = answers(&rope(length), &["z"]).unwrap();
        let found = derivative(&table, 0, "pan.mass");
        assert_eq!(found.is_some(), expected.is_some(), "{length}: {found:?} {:?}", table.notes);
        if let (Some(found), Some(expected)) = (found, expected) {
            assert!((found - expected).abs() < 1e-10, "{length}: {found}");
        } else {
            assert!(table.notes.iter().any(|note| note.contains("`pan.mass`") && note.contains("kink")));
        }
    }
}

/// Nothing weighs and nothing pushes: the derivatives by forces are there, one output that has none leaves the others alone, and outputs with a kink
/// have none, whatever number it is by.
#[test]
fn what_has_a_kink_has_no_derivative_by_any_number() {
    let output = |name: &str, of: &str| format!("[[output]]\nname = \"{name}\"\n{of}\n");
    let expression = |name: &str, of: &str| output(name, &format!("type = \"expression\"\nexpression = \"{of}\""));
    let directions = "of = { body = \"shaft\", axis = [0, 0, 1] }\nagainst = { body = \"ground\", axis = [0, 0, 1] }";
    let text = [
        "gravity = [0.0, 0.0, 0.0]\n[[body]]\nname = \"pan\"\nmass = 2.0\n".to_owned(),
        "hinge = { type = \"prismatic\", axis = [0, 0, 1], stiffness = 300.0 }\n".to_owned(),
        "[[body]]\nname = \"shaft\"\nmass = 2.0\ninertia = [0.1, 0.1, 0.1]\n".to_owned(),
        "hinge = { type = \"universal\", axes = [[1, 0, 0], [0, 1, 0]], stiffness = [300.0, 300.0] }\n".to_owned(),
        output("z", "type = \"coordinate\"\nof = \"pan\""),
        output("far", "type = \"distance\"\nbetween = [\"pan\", \"ground\"]"),
        output("tilt", &format!("type = \"angle\"\n{directions}")),
        expression("size", "abs(z)"),
        expression("above", "max(z, 0)"),
        expression("root", "sqrt(z)"),
        expression("square", "z^2"),
    ];
    let names = ["z", "far", "tilt", "size", "above", "root", "square"];
    let table = answers(&text.concat(), &names).unwrap();
    // Forces over the stiffness; weights, by the acceleration.
    for (number, expected) in [("pan.force", 1.0 / 300.0), ("pan.rest", 1.0), ("gravity[2]", 2.0 / 300.0)] {
        let found = derivative(&table, 0, number).unwrap_or(f64::NAN);
        assert!((found - expected).abs() < 1e-9, "{number}: {found} for {expected}");
        for output in [1, 3, 4, 5] {
            assert_eq!(derivative(&table, output, number), None, "{} by {number}", names[output]);
        }
        assert_eq!(derivative(&table, 6, number), Some(0.0));
        let said = format!("no derivative of `size` by `{number}`: it has a kink here");
        assert!(table.notes.contains(&said), "{:?}", table.notes);
    }
    for number in ["shaft.force[0]", "shaft.rest[1]"] {
        assert_eq!(derivative(&table, 2, number), None, "tilt by {number}");
        assert_eq!(derivative(&table, 0, number), Some(0.0));
    }
}

/// Components that are zero but for rounding stay so: the size of an output is that of all its components.
#[test]
fn components_of_nothing_but_rounding_have_derivative_zero() {
    let text = "[[body]]\nname = \"b\"\nmass = 1.0\ncenter = [0, 0.3, 0.1]\nmarkers = { m = [0, 0, 0.3] }\n\
                hinge = { type = \"revolute\", axis = [1, 0, 0], stiffness = 40.0, rest = -0.063 }\n\
                [[body]]\nname = \"c\"\nmass = 0.4\ncenter = [0, 0.1, 0.2]\n\
                hinge = { type = \"revolute\", parent = \"b\", at = \"m\", rpy = [-0.7380, 0.781, -0.557], axis = [0.6, 0, 0.8], stiffness = 20.0 }\n\
                [[body]]\nname = \"d\"\nmass = 0.4\ncenter = [0, 0.1, 0.2]\n\
                hinge = { type = \"revolute\", parent = \"b\", rpy = [0.3, 0, 0], axis = [1, 0, 0], stiffness = 20.0 }\n\
                [[output]]\nname = \"o\"\ntype = \"orientation\"\nof = \"d\"\n";
    let table = answers(text, &["o"]).unwrap();
    for number in &table.parameters {
        for component in [2, 3] {
            assert!(table.outputs[component].value.abs() < 1e-15);
            let found = derivative(&table, component, &number.address);
            assert_eq!(found, Some(0.0), "o[{component}] by {}: {:?}", number.address, table.notes);
        }
    }
}

/// After a stage scenes lack some of their elements: `[parameters]` still move what is left.
#[test]
fn parameters_move_what_a_stage_leaves() {
    let text = "[parameters]\nm = 2.0\n\
                [[body]]\nname = \"pan\"\nmass = \"{m}\"\nhinge = { type = \"prismatic\", axis = [0, 0, 1], stiffness = 100.0 }\n\
                [[motor]]\nname = \"up\"\ntype = \"constant\"\nhinge = \"pan\"\nforce = 5.0\n\
                [[stage]]\nname = \"cut\"\nwhen = { time = 1.0 }\nopen = [\"up\"]\n\
                [[output]]\nname = \"z\"\ntype = \"coordinate\"\nof = \"pan\"\n";
    let whole = parse("scene.toml", text, &[]).unwrap().description;
    let (left, _) = stillpoint::simulate::at_stage(&whole, "cut", None).unwrap();
    let (model, found) = solved(&left).unwrap();
    let numbers = Parameter::find(&left, "parameters.m").unwrap();
    let table = sensitivities(&left, &model, &found, &["z".to_owned()], Some(numbers), &|| true).unwrap();
    let by = table.derivatives[0][0].unwrap_or_else(|| panic!("{:?}", table.notes));
    assert!((by + 9.80665 / 100.0).abs() < 1e-9, "{by}");
}

/// What has a name and no number that an equilibrium is differentiated by says what it is, and the way round.
#[test]
fn numbers_of_controllers_are_reached_by_parameters() {
    let text = "[[body]]\nname = \"x\"\nmass = 1.0\nhinge = { type = \"prismatic\", axis = [0, 0, 1], stiffness = 100.0 }\n\
                [[motor]]\nname = \"u\"\ntype = \"input\"\nhinge = \"x\"\n\
                [[controller]]\nname = \"c\"\ntype = \"pid\"\nperiod = 0.01\nsenses = \"q\"\ndrives = \"u\"\nproportional = 10.0\nbias = 3.0\nsetpoint = 0.1\n\
                [[output]]\nname = \"q\"\ntype = \"coordinate\"\nof = \"x\"\n";
    let scene = parse("scene.toml", text, &[]).unwrap().description;
    let refused = Parameter::find(&scene, "c.bias").unwrap_err();
    assert!(refused.message.contains("`c` is a controller"), "{refused:?}");
    assert!(refused.help.is_some_and(|help| help.contains("[parameters]")));
}

/// Frequencies that are near to each other have derivatives of their own as far as rounding leaves their shapes apart; then they are not called
/// equal if they are printed as two numbers.
#[test]
fn near_frequencies_are_told_from_equal_ones() {
    let pan = |name: &str, y: f64, stiffness: f64| {
        let hinge =
            format!("{{ type = \"prismatic\", at = [0, {y:?}, 0], axis = [1, 0, 0], stiffness = {stiffness:?} }}");
        format!("[[body]]\nname = \"{name}\"\nmass = 1.0\nhinge = {hinge}\n")
    };
    let of = |stiffness: f64| {
        let text = format!("{}{}", pan("a", 0.0, 100.0), pan("b", 2.0, stiffness));
        answers(&text, &["frequency[0]"]).unwrap()
    };
    // 2π f = √(k / m).
    let expected = 0.5 / 100.0 * 10.0 / std::f64::consts::TAU;
    let table = of(100.0001);
    let by = derivative(&table, 0, "a.stiffness").unwrap_or_else(|| panic!("{:?}", table.notes));
    assert!((by - expected).abs() < 1e-8 * expected, "{by} for {expected}");
    let [near, equal] = [100.0 + 1e-10, 100.0].map(|stiffness| of(stiffness).notes.join("\n"));
    assert!(near.contains("so near to `frequency[1]`") && !near.contains("equals"), "{near}");
    assert!(equal.contains("it equals `frequency[1]`"), "{equal}");
}

#[test]
fn motions_without_stiffness_stay_or_have_no_equilibrium_beside() {
    // A turn about the vertical costs nothing, and nothing but a torque about it pushes that way.
    let arm = "[[body]]\nname = \"post\"\nmass = 1.0\ninertia = [1, 1, 1]\nhinge = { type = \"revolute\", axis = [0, 0, 1] }\n\
               [[body]]\nname = \"arm\"\nmass = 1.0\ncenter = [0.5, 0, 0]\ninertia = [0.1, 0.1, 0.1]\n\
               hinge = { type = \"revolute\", parent = \"post\", axis = [0, 1, 0], stiffness = 20.0 }\n\
               [[output]]\nname = \"a\"\ntype = \"coordinate\"\nof = \"arm\"\n";
    let table = answers(arm, &["a"]).unwrap();
    let value = table.outputs[0].value;
    // k a = m g l cos a
    let (w, k) = (9.80665 * 0.5, 20.0);
    let expected = w * value.cos() / (k + w * value.sin());
    let found = derivative(&table, 0, "arm.mass").unwrap();
    assert!((found - expected).abs() < 1e-7 * expected, "{found} for {expected}");
    assert_eq!(derivative(&table, 0, "post.force"), None);
    assert!(table.notes.iter().any(|note| note.contains("zero-stiffness direction")), "{:?}", table.notes);
}

#[test]
fn names_that_are_not_known_are_refused() {
    let unknown = answers(&scale(""), &["frequncy[0]"]).unwrap_err();
    assert!(unknown.to_string().contains("no output `frequncy[0]`; did you mean `frequency[0]`?"), "{unknown}");
    let beyond = answers(&scale(""), &["frequency[3]"]).unwrap_err();
    assert!(beyond.to_string().contains("one frequency, `frequency[0]`"), "{beyond}");
    let twice = "[[body]]\nname = \"b\"\nrepeat = 1\nmass = 1.0\ncenter = [0, 0, -1]\n\
                 hinge = { type = \"universal\", axes = [[1, 0, 0], [0, 1, 0]] }\n";
    let table = answers(twice, &["frequency[0]"]).unwrap();
    assert!(!table.parameters.is_empty() && table.derivatives[0].iter().all(Option::is_none), "{table:?}");
}

/// A frequency without derivatives has none, and a note; the others of the call have theirs.
#[test]
fn a_frequency_that_is_repeated_does_not_keep_the_others() {
    let text = "[[body]]\nname = \"b\"\nmass = 1.0\ncenter = [0, 0, -1]\n\
                hinge = { type = \"universal\", axes = [[1, 0, 0], [0, 1, 0]] }\n\
                [[body]]\nname = \"pan\"\nmass = 2.0\nhinge = { type = \"prismatic\", axis = [0, 0, 1], stiffness = 100.0 }\n\
                [[output]]\nname = \"z\"\ntype = \"coordinate\"\nof = \"pan\"\n";
    let table = answers(text, &["frequency[0]", "frequency[2]", "z"]).unwrap();
    assert!(table.outputs[0].value > 0.0 && table.derivatives[0].iter().all(Option::is_none), "{table:?}");
    let note = "no derivatives of `frequency[0]`: the frequency is repeated, so it has no derivative: it equals `frequency[1]`";
    assert!(table.notes.iter().any(|one| one.starts_with(note)), "{:?}", table.notes);
    // ω² = k / m, z = −m g / k.
    let by = derivative(&table, 1, "pan.stiffness").unwrap();
    let expected = 0.5 * (50.0_f64).sqrt() / 100.0 / std::f64::consts::TAU;
    assert!((by - expected).abs() < 1e-9 * expected, "{by} for {expected}");
    assert!((derivative(&table, 2, "pan.mass").unwrap() + 9.80665 / 100.0).abs() < 1e-9);
}

/// Every scenario that rests: by numbers of its own, against equilibria found again.
#[test]
fn the_scenarios_answer_as_when_found_again() {
    let (mut scenes, mut count, mut worst) = (0, 0, 0.0_f64);
    for name in ["double_wishbone", "four_bar", "quarter_car", "machine_on_mounts", "spring_arm", "five_links"] {
        let scenario = stillpoint::scenario::load(&file(name)).unwrap();
        let (some, error) = compare(name, &scenario.description, 3, 1);
        scenes += usize::from(some > 0);
        (count, worst) = (count + some, worst.max(error));
    }
    println!("{scenes} scenarios, {count} derivatives, largest error {worst:.1e}");
    assert!(scenes >= 5, "{scenes}");
}

#[test]
fn the_program_prints_and_gives_json() {
    let wishbone = file("double_wishbone");
    let run = |more: &[&str]| {
        let mut command = Command::cargo_bin("stillpoint").unwrap();
        command.arg("statics").arg(&wishbone).arg("--sensitivity").args(["camber", "frequency[0]"]).args(more);
        command.output().unwrap()
    };
    let json: Value = serde_json::from_slice(&run(&["--json"]).stdout).unwrap();
    let by = &json["sensitivities"]["camber"];
    assert!(by["strut.length"].as_f64().unwrap() != 0.0 && by["tie rod.length"].is_number(), "{by}");
    let few = run(&["--json", "--parameter", "strut.length", "gravity[2]"]);
    let few: Value = serde_json::from_slice(&few.stdout).unwrap();
    assert_eq!(few["sensitivities"]["camber"].as_object().unwrap().len(), 2);
    // Few numbers go the direct way, many the adjoint one: the same to round-off.
    let [few, all] = [&few["sensitivities"]["camber"], by].map(|of| of["strut.length"].as_f64().unwrap());
    assert!((few / all - 1.0).abs() < 1e-12, "{few} {all}");
    let text = String::from_utf8(run(&[]).stdout).unwrap();
    assert!(text.contains("sensitivity  camber = ") && text.contains("strut.length"), "{text}");
    let unknown = run(&["--parameter", "strut.lenght"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(String::from_utf8(unknown.stderr).unwrap().contains("did you mean `length`?"));
}

/// Derivatives by numbers of elements that share a name stand under the addresses that reach these numbers.
#[test]
fn namesakes_have_derivatives_of_their_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = "[[body]]\nname = \"arm\"\nmass = 1.0\ncenter = [0.3, 0, 0]\ninertia = [0.1, 0.1, 0.1]\n\
        hinge = { type = \"revolute\", axis = [0, 1, 0], position = 0.3, stiffness = 3.0, force = 0.5 }\n\
        [[motor]]\nname = \"arm\"\ntype = \"pd\"\nhinge = \"arm\"\ntarget = -0.4\nstiffness = 8.0\nforce = 0.2\n\
        [[output]]\nname = \"q\"\ntype = \"coordinate\"\nof = \"arm\"\n";
    let path = folder.path().join("arm.toml");
    std::fs::write(&path, scene).expect("a file");
    let call = |more: &[&str]| -> Value {
        let mut command = Command::new(env!("CARGO_BIN_EXE_stillpoint"));
        let output = command.arg("statics").arg(&path).arg("--json").args(more).output().expect("the program starts");
        serde_json::from_slice(&output.stdout).expect("JSON")
    };
    let listed = call(&["--sensitivity", "q"])["sensitivities"]["q"].clone();
    for (address, value) in
        [("arm.stiffness", 3.0), ("motor[0].stiffness", 8.0), ("arm.force", 0.5), ("motor[0].force", 0.2)]
    {
        let at =
            |value: f64| call(&["--set", &format!("{address}={value}")])["outputs"]["q"].as_f64().expect("an output");
        let difference = (at(value + 1e-3) - at(value - 1e-3)) / 2e-3;
        let found = listed[address].as_f64().unwrap_or_else(|| panic!("{address} is not in {listed}"));
        assert!((found / difference - 1.0).abs() < 1e-4, "{address}: {found} {difference}");
    }
}
