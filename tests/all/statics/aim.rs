//! Aimed equilibria: outputs are given, the numbers that make them so are found, or it is said that none can.

use crate::common::{Random, answered};
use stillpoint::model::{Model, Parameter};
use stillpoint::scenario::{self, Scenario};
use stillpoint::statics::{Aim, Held, outputs};

fn read(text: &str) -> Scenario {
    scenario::parse("aim.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}"))
}

fn refused(text: &str) -> String {
    match scenario::parse("aim.toml", text, &[]) {
        Ok(_) => panic!("this is refused:\n{text}"),
        Err(problems) => problems.to_string(),
    }
}

fn aimed(scenario: &Scenario) -> Held {
    let model = Model::build(&scenario.description).expect("a model");
    let (model, _) = stillpoint::constraint::assemble(model).expect("loops that close");
    answered(scenario, model).expect("numbers")
}

/// An arm of 1 m and 2 kg (10 N at its end) that a strut from 1.5 m above the pin holds; the strut of 1 kN/m.
fn arm(statics: &str) -> String {
    format!(
        "gravity = [0, 0, -10]\n[[body]]\nname = \"arm\"\nmass = 2\ncenter = [0.5, 0, 0]\ninertia = [0.01, 0.2, 0.2]\n\
         markers = {{ end = [1, 0, 0] }}\nhinge = {{ type = \"revolute\", axis = [0, 1, 0] }}\n\
         [[force]]\nname = \"strut\"\ntype = \"spring\"\nstiffness = 1000\nlength = 1.7\n\
         between = [\"arm.end\", {{ body = \"ground\", at = [0, 0, 1.5] }}]\n\
         [[output]]\nname = \"dip\"\ntype = \"coordinate\"\nof = \"arm\"\n\
         [[output]]\nname = \"end\"\ntype = \"position\"\nof = \"arm.end\"\n{statics}"
    )
}

/// Moments about the pin: a pull `F` along the strut, of lever `1.5 cos θ / d`, bears 10 N m cos θ: `F = d/0.15`, so the free
/// length is `d − F/k`, `d² = 1 + 1.5² + 3 sin θ`, whatever the sag of the guess.
#[test]
fn the_strut_is_cut_to_the_angle_that_is_wanted() {
    for degrees in [-50.0_f64, -20.0, 0.0, 15.0, 40.0] {
        let scenario =
            read(&arm(&format!("[statics]\nunknown = [\"strut.length\"]\naim = {{ dip = \"{degrees:?} deg\" }}\n")));
        let held = aimed(&scenario);
        assert!(held.found.converged, "{degrees}: {:?}", held.found.notes);
        let d = (3.25 + 3.0 * degrees.to_radians().sin()).sqrt();
        let expected = d - 10.0 * d / 1.5 / 1000.0;
        let (address, value) = &held.found.unknowns[0];
        assert!(address == "strut.length" && (value - expected).abs() < 1e-9, "{degrees}: {value} for {expected}");
        assert!((held.found.position[0] - degrees.to_radians()).abs() < 1e-10, "{:?}", held.found.position);
        assert_eq!(held.found.aimed[0].0, "dip");
        // The scene has the number: another search ends there.
        assert!(
            (Parameter::find(&held.description, "strut.length").unwrap()[0].value(&held.description) - value) == 0.0
        );
    }
}

/// Chains of links with springs in their hinges: the end is brought to where it hangs for other rest angles, by two of them.
#[test]
fn ends_of_random_chains_are_brought_to_where_they_can_be() {
    let mut most = 0.0_f64;
    for seed in 0..30 {
        let random = &mut Random::new(seed);
        let count = 2 + random.below(4);
        let mut text = String::from("gravity = [0, 0, -10]\n");
        let mut rests = Vec::new();
        for i in 0..count {
            let length = random.between(0.3, 1.0);
            let parent = if i == 0 { String::new() } else { format!("parent = \"l{}\", at = \"end\", ", i - 1) };
            rests.push(random.between(-0.6, 0.6));
            text += &format!(
                "[[body]]\nname = \"l{i}\"\nmass = {}\ncenter = [{}, 0, 0]\ninertia = [0.01, 0.1, 0.1]\n\
                 markers = {{ end = [{length}, 0, 0] }}\nhinge = {{ {parent}type = \"revolute\", axis = [0, 1, 0], \
                 stiffness = {}, rest = {} }}\n",
                random.between(0.2, 2.0),
                length / 2.0,
                random.between(100.0, 400.0),
                rests[i]
            );
        }
        text += &format!("[[output]]\nname = \"end\"\ntype = \"position\"\nof = \"l{}.end\"\n", count - 1);
        let mut scenario = read(&text);
        let [first, last] = [0, count - 1].map(|i| format!("l{i}.rest"));
        let unknown: Vec<Parameter> =
            [&first, &last].into_iter().flat_map(|one| Parameter::find(&scenario.description, one).unwrap()).collect();
        // Where it hangs with other numbers.
        let mut other = scenario.clone();
        let wanted: Vec<f64> =
            unknown.iter().map(|one| one.value(&scenario.description) + random.between(-0.3, 0.3)).collect();
        unknown.iter().zip(&wanted).for_each(|(one, value)| one.set(&mut other.description, *value).unwrap());
        let rest = aimed(&other);
        let there = outputs(&rest.model, &rest.found).unwrap();
        scenario.unknown = unknown;
        scenario.aim = [0, 2].map(|i| Aim { output: format!("end[{i}]"), value: there[i] }).to_vec();
        let held = aimed(&scenario);
        assert!(held.found.converged, "seed {seed}: {:?}", held.found.notes);
        let here = outputs(&held.model, &held.found).unwrap();
        most = most.max([0, 2].map(|i| (here[i] - there[i]).abs()).into_iter().fold(0.0, f64::max));
    }
    assert!(most < 1e-9, "{most:e}");
}

#[test]
fn of_many_answers_the_least_change_is_taken_and_others_are_left() {
    let two = "[[force]]\nname = \"twin\"\ntype = \"spring\"\nstiffness = 1000\nlength = 1.7\n\
               between = [\"arm.end\", { body = \"ground\", at = [0, 0, 1.5] }]\n";
    let text = arm("[statics]\nunknown = [\"strut.length\", \"twin.length\"]\naim = { \"end[2]\" = 0.25 }\n") + two;
    let held = aimed(&read(&text));
    assert!(held.found.converged, "{:?}", held.found.notes);
    let [(_, one), (_, other)] = &held.found.unknowns[..] else { panic!("{:?}", held.found.unknowns) };
    assert!((one - other).abs() < 1e-12 && (one - 1.7).abs() > 0.01, "{one} {other}");
    assert!((held.found.position[0].sin() + 0.25).abs() < 1e-9);
}

#[test]
fn what_cannot_be_brought_there_is_said_and_nothing_is_claimed() {
    let far = aimed(&read(&arm("[statics]\nunknown = [\"strut.length\"]\naim = { \"end[0]\" = 1.5 }\n")));
    assert!(!far.found.converged, "an arm of 1 m does not reach 1.5 m");
    assert!(
        far.found.notes[0].contains("`end[0]` is") && far.found.notes[0].contains("and not 1.5"),
        "{:?}",
        far.found.notes
    );
    let idle = aimed(&read(&arm("[statics]\nunknown = [\"strut.length\"]\naim = { \"end[1]\" = 0.5 }\n")));
    assert!(!idle.found.converged);
    assert!(idle.found.notes[0].contains("no unknown moves `end[1]`"), "{:?}", idle.found.notes);
}

#[test]
fn aims_that_make_no_sense_are_refused_at_their_place() {
    let alone = refused(&arm("[statics]\naim = { dip = 0.1 }\n"));
    assert!(alone.contains("`aim` needs `unknown`"), "{alone}");
    let many = refused(&arm("[statics]\nunknown = [\"strut.length\"]\naim = { dip = 0.1, \"end[0]\" = 1.0 }\n"));
    assert!(many.contains("2 outputs are aimed at with 1 unknown"), "{many}");
    let misspelt = refused(&arm("[statics]\nunknown = [\"strut.length\"]\naim = { dop = 0.1 }\n"));
    assert!(misspelt.contains("no output `dop`") && misspelt.contains("did you mean `dip`?"), "{misspelt}");
    let several = refused(&arm("[statics]\nunknown = [\"strut.length\"]\naim = { end = 0.1 }\n"));
    assert!(several.contains("`end` has several numbers") && several.contains("end[0]"), "{several}");
    let metres = refused(&arm("[statics]\nunknown = [\"strut.length\"]\naim = { dip = \"10 mm\" }\n"));
    assert!(metres.contains("`dip` is measured in rad"), "{metres}");
    let guess = refused(&arm("[statics]\nunknown = [\"arm.position\"]\naim = { dip = 0.1 }\n"));
    assert!(guess.contains("`arm.position` is a guess"), "{guess}");
}
