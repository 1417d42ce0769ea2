//! Start files: what is written is read back bit for bit, and what does not fit the scene is refused where it stands.

use crate::common::{Options, Random, build, random_scene};
use std::sync::Arc;
use stillpoint::model::Model;
use stillpoint::model::description::Description;
use stillpoint::scenario::start::{parse_start, text};

fn scene() -> Description {
    // Seed 3 has every kind of hinge; the tests below would not compile their names otherwise.
    random_scene(3, &Options { bodies: 14, springs: true, welds: true })
}

fn bits(list: &[f64]) -> Vec<u64> {
    list.iter().map(|x| x.to_bits()).collect()
}

#[test]
fn a_start_is_read_back_bit_for_bit() {
    for seed in 0..20 {
        let description = random_scene(seed, &Options { bodies: 12, springs: true, welds: true });
        let mut model = build(&description);
        let mut random = Random::new(seed);
        // Turned a few times, so that quaternions carry round-off of their own.
        for _ in 0..5 {
            let turn = random.list(model.velocity_count(), -1.0, 1.0);
            let mut q = model.start_position.clone();
            stillpoint::dynamics::System::displace(&model, &mut q, &turn);
            Arc::make_mut(&mut model).start_position = q;
        }
        Arc::make_mut(&mut model).start_velocity = random.list(model.velocity_count(), -3.0, 3.0);
        let input = description.bodies.iter().find(|body| body.hinge.force.len() == 1).map(|body| &body.name);
        let inputs: Vec<(String, f64)> = input.map(|name| (format!("{name}.force"), 0.1 + 0.2)).into_iter().collect();
        let written = text(&model, &model.start_position, &model.start_velocity, &inputs, &[]);
        let read = parse_start("start.toml", &written, &description).unwrap_or_else(|bad| panic!("{bad}\n{written}"));
        assert_eq!(bits(&read.model.start_position), bits(&model.start_position), "seed {seed}");
        assert_eq!(bits(&read.model.start_velocity), bits(&model.start_velocity), "seed {seed}");
        for (address, value) in inputs {
            assert_eq!((&read.changes[0].0, read.changes[0].2), (&address, value));
            let body = address.trim_end_matches(".force");
            let body = read.description.bodies.iter().find(|one| one.name == body).expect("the body");
            assert_eq!(body.hinge.force, [value]);
        }
    }
}

#[test]
fn velocities_that_are_left_out_are_zero() {
    let description = scene();
    let model = build(&description);
    let written = text(&model, &model.start_position, &model.start_velocity, &[], &[]);
    let (before, _) = written.split_once("[velocities]").expect("the table");
    let read = parse_start("start.toml", before, &description).expect("a start");
    assert!(model.start_velocity.iter().any(|v| *v != 0.0) && read.model.start_velocity.iter().all(|v| *v == 0.0));
}

#[test]
fn names_are_quoted_so_that_they_come_back() {
    let mut description = scene();
    description.forces.clear();
    description.bodies.truncate(1);
    "a \"b\".c\\d\n[0]".clone_into(&mut description.bodies[0].name);
    let model = build(&description);
    let written = text(&model, &model.start_position, &model.start_velocity, &[], &[]);
    parse_start("start.toml", &written, &description).unwrap_or_else(|bad| panic!("{bad}\n{written}"));
}

/// The message of the only problem, and its line.
fn refused(description: &Description, text: &str) -> (String, usize) {
    let problems = parse_start("start.toml", text, description).expect_err("a problem");
    assert_eq!(problems.len(), 1, "{problems}");
    let problem = problems.iter().next().expect("one");
    (problem.message.clone(), problem.place.as_ref().map_or(0, |place| place.line))
}

#[test]
fn what_does_not_fit_the_scene_is_refused_where_it_stands() {
    let mut description = scene();
    description.forces.clear();
    description.bodies.truncate(2);
    let [arm, ball] = &mut description.bodies[..] else { panic!("two bodies") };
    for (body, kind) in [
        (arm, stillpoint::model::description::HingeKind::Revolute { axis: nalgebra::Vector3::y() }),
        (ball, stillpoint::model::description::HingeKind::Spherical),
    ] {
        let mut hinge = stillpoint::model::description::HingeDescription::new(kind);
        std::mem::swap(&mut body.hinge.at, &mut hinge.at);
        body.hinge = hinge;
    }
    "arm".clone_into(&mut description.bodies[0].name);
    "ball".clone_into(&mut description.bodies[1].name);
    let fine = "[positions]\narm = [0.3]\nball = [1, 0, 0, 0]\n";
    parse_start("start.toml", fine, &description).expect("a start");
    let bad = [
        ("[positions]\narm = [0.3]\nball = [1, 0, 0, 0]\nbal = [0]\n", "no body `bal`", 4),
        ("[positions]\narm = [0.3, 1]\nball = [1, 0, 0, 0]\n", "has 2 numbers, 1 is needed", 2),
        ("[positions]\narm = [0.3]\nball = [1, 0, 0.1, 0]\n", "norm 1.004", 3),
        ("[positions]\narm = [nan]\nball = [1, 0, 0, 0]\n", "is nan", 2),
        ("[positions]\narm = [0.3]\n", "position of `ball` is missing", 1),
        ("[velocities]\narm = [0.3]\n", "needs `[positions]`", 0),
        ("[position]\narm = [0.3]\n", "unknown key `position`", 1),
    ];
    for (text, expected, line) in bad {
        let problems = parse_start("start.toml", text, &description).expect_err(text);
        let found = problems.iter().find(|problem| problem.message.contains(expected));
        let found = found.unwrap_or_else(|| panic!("`{expected}` is not in {problems}"));
        assert_eq!(found.place.as_ref().map_or(0, |place| place.line), line, "{problems}");
    }
    for (input, expected) in [
        ("\"arm.length\" = 1", "no number `length`"),
        ("\"ball.force\" = 1", "stands for 3 numbers"),
        ("\"leg.force\" = 1", "nothing is called `leg`"),
        ("\"arm.position\" = 1", "is a coordinate, not an input"),
        ("\"arm.mass\" = -1", "the mass of `arm` is -1"),
        ("\"arm.force\" = [1]", "must be a number"),
    ] {
        let (message, line) = refused(&description, &format!("{fine}[inputs]\n{input}\n"));
        assert!(message.contains(expected), "{message}");
        assert_eq!(line, 5, "{message}");
    }
}

/// Two arms with a gear `b = 2 a + 0.1`, both drawn at 0.3 rad: it is open by 0.4 rad, and no loop is there.
#[test]
fn a_gear_that_the_guess_leaves_open_is_named_with_its_angle() {
    let arm = |name: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = 1\ncenter = [0, 0, -0.5]\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], position = 0.3, stiffness = 3 }}\n"
        )
    };
    let text = arm("a")
        + &arm("b")
        + "[[gear]]\nname = \"g\"\ntype = \"ratio\"\nratio = 2.0\noffset = 0.1\nbetween = [\"a\", \"b\"]\n";
    let scenario = stillpoint::scenario::parse("gear.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    let (_, assembly) = stillpoint::constraint::assemble(Model::build(&scenario.description).unwrap()).unwrap();
    let note = assembly.notes.iter().find(|note| note.contains("guess")).expect("a note");
    assert!(note.contains("gear `g` open by 0.4 rad") && !note.contains("loops"), "{note}");
    let unknown = text + "[statics]\nunknown = [\"g.ratio\"]\n";
    let refused = stillpoint::scenario::parse("gear.toml", &unknown, &[]).expect_err("no such unknown").to_string();
    assert!(refused.contains("`g` is a gear") && refused.contains("[parameters]"), "{refused}");
}

#[test]
fn a_spring_whose_ends_are_in_one_place_says_so() {
    let text = "[[body]]\nname = \"a\"\nmass = 1\nhinge = { type = \"prismatic\", axis = [0, 0, 1], stiffness = 20 }\n\
                [[force]]\nname = \"s\"\ntype = \"spring\"\nbetween = [\"a\", { body = \"ground\" }]\nstiffness = 10\nlength = 0.1\n";
    let scenario =
        stillpoint::scenario::parse("spring.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    let model = Model::build(&scenario.description).unwrap();
    let fault = stillpoint::statics::equilibrium(&model, &scenario.statics, &model.start_position).unwrap_err();
    assert!(fault.to_string().contains("both ends of `s` are in one place"), "{fault}");
}
