//! Inputs that cannot be answered: refused early, at their place, and by their own name.

use super::{Bench, shipped};

/// An arm with this in its hinge.
fn arm(hinge: &str) -> String {
    format!(
        "[[body]]\nname = \"arm\"\nmass = 1.0\ncenter = [0.0, 0.0, -0.5]\ninertia = [0.1, 0.1, 0.1]\n\
         hinge = {{ type = \"revolute\", axis = [0.0, 1.0, 0.0], position = 0.1, {hinge} }}\n"
    )
}

#[cfg(feature = "friction")]
#[test]
fn friction_takes_quantities_wherever_it_stands() {
    let bench = Bench::new();
    let share = |hinge: &str| {
        bench.write("arm.toml", arm(hinge));
        let answer = bench.call(&["statics", "arm.toml", "--json"]).code(0).json();
        answer["standing"]["hinges"][0]["use"].as_f64().expect("a share")
    };
    let plain = share("friction = { stick = 4.0, slide = 3.0 }");
    // m g a sin 0.1 of 4 N m.
    assert!((plain - 9.80665 * 0.5 * 0.1_f64.sin() / 4.0).abs() < 1e-6, "{plain}");
    for written in [
        "friction = { stick = \"4000 N mm\", slide = \"3 N m\" }",
        "friction = [{ stick = \"4000 N mm\", slide = 3.0 }]",
        "friction = \"4000 N mm\"",
        "friction = [\"4 N m\"]",
    ] {
        assert_eq!(share(written), plain, "{written}");
    }
    for (written, said) in [
        ("friction = { stick = \"4 N\", slide = 3.0 }", "it is measured in N m"),
        ("friction = [{ stick = 4.0, slide = \"3 m\" }]", "it is measured in N m"),
        ("friction = 1e300", "allowed: ≥ 0, up to 1e154"),
    ] {
        bench.write("arm.toml", arm(written));
        let refused = bench.call(&["check", "arm.toml"]).code(2).err;
        assert!(refused.contains(said) && !refused.contains("N or N m"), "{written}: {refused}");
    }
    // Between bodies it is a coefficient.
    bench.write(
        "arm.toml",
        arm("") + "[[contact]]\nbetween = [\"arm\", \"*\"]\nfriction = { stick = \"4 N\", slide = 0.1 }\n",
    );
    assert!(bench.call(&["check", "arm.toml"]).code(2).err.contains("a pure number has no unit"));
}

#[test]
fn what_is_wrong_with_a_beam_is_said_alone() {
    let bench = Bench::new();
    let beam = "[[beam]]\nname = \"b\"\nlength = 1.0\nhinge = { type = \"fixed\" }\nsection = { circle = 0.01 }\n\
                material = { young = 1e9, poisson = 0.3, density = 1000.0 }\n";
    bench.write("b.toml", beam);
    bench.call(&["check", "b.toml"]).code(0);
    for (right, wrong, said) in [
        ("length = 1.0", "lenght = 1.0", "did you mean `length`?"),
        ("young = 1e9", "young = nan", "`young` is nan, which is not a finite number"),
        ("density = 1000.0", "density = inf", "`density` is inf, which is not a finite number"),
        ("circle = 0.01", "circle = nan", "`circle` is nan, which is not a finite number"),
        ("circle = 0.01", "cirle = 0.01", "did you mean `circle`?"),
    ] {
        bench.write("b.toml", beam.replace(right, wrong));
        let refused = bench.call(&["check", "b.toml"]).code(2).err;
        assert!(refused.contains(said), "{wrong}: {refused}");
        assert!(!refused.contains("no bodies") && !refused.contains("no material"), "{wrong}: {refused}");
    }
}

#[test]
fn a_controller_that_acts_without_end_is_refused_at_its_period() {
    let bench = Bench::new();
    let scene = |period: &str| {
        arm("stiffness = 5.0")
            + "[[motor]]\nname = \"m\"\nhinge = \"arm\"\ntype = \"input\"\n[[output]]\nname = \"a\"\ntype = \"coordinate\"\nof = \"arm\"\n"
            + &format!(
                "[[controller]]\nname = \"c\"\ntype = \"gain\"\nperiod = {period}\nsenses = [\"a\"]\ndrives = [\"m\"]\nmatrix = [[-1.0]]\n"
            )
    };
    for (period, code) in [("0.01", 0), ("1e-300", 2), ("5e-324", 2), ("\"1e-15 s\"", 2), ("1e-6", 0)] {
        bench.write("c.toml", scene(period));
        let said = bench.call(&["check", "c.toml"]).code(code).err;
        assert!(
            code == 0 || said.contains("too many instants") && said.contains("controller `c` acts every"),
            "{period}: {said}"
        );
    }
}

#[test]
fn a_state_to_go_on_from_keeps_its_loops_closed() {
    let bench = Bench::new();
    let scene = shipped("four_bar");
    bench.call(&["run", &scene, "--set", "simulate.duration=0.1", "--out", "a.mcap", "--save-end", "end.toml"]).code(0);
    let text = std::fs::read_to_string(bench.path().join("end.toml")).expect("a start file");
    let goes_on = |text: &str| {
        bench.write("x.toml", text);
        bench.call(&["run", &scene, "--set", "simulate.duration=0.1", "--out", "b.mcap", "--start", "x.toml"])
    };
    goes_on(&text).code(0);
    // Every number of every table, one at a time, off by a hundredth.
    let (mut refused, mut table) = (0, "");
    for (at, line) in text.lines().enumerate() {
        table = if line.starts_with('[') { line } else { table };
        let Some((key, number)) = line.split_once(" = ") else { continue };
        let Ok(number) = number.trim_matches(['[', ']']).parse::<f64>() else { continue };
        if table != "[positions]" {
            continue;
        }
        let changed = format!("{key} = [{:?}]", number + 0.01);
        let lines = text.lines().enumerate().map(|(other, line)| if other == at { changed.as_str() } else { line });
        let answer = goes_on(&lines.collect::<Vec<_>>().join("\n")).code(2);
        assert!(answer.err.contains("loop `") && answer.err.contains("is open by"), "{changed}: {answer:#?}");
        refused += 1;
    }
    assert_eq!(refused, 3, "{text}");
}

#[test]
fn a_thread_far_lighter_than_its_load_is_told_what_it_needs() {
    let bench = Bench::new();
    bench.write(
        "thread.toml",
        "[[body]]\nname = \"thread\"\nmass = 1e-16\ncenter = [0.0, 0.0, -0.5]\ninertia = [1e-16, 1e-16, 1e-20]\n\
         markers = { tip = [0.0, 0.0, -1.0] }\nhinge = { type = \"spherical\" }\n[[body]]\nname = \"bob\"\nmass = 1.0\n\
         center = [0.1, 0.0, -0.5]\ninertia = [0.1, 0.1, 0.1]\n\
         hinge = { type = \"spherical\", parent = \"thread\", at = \"tip\", position = [0.6, 0.8, 0.0, 0.0] }\n",
    );
    let refused = bench.call(&["statics", "thread.toml"]).code(2).err;
    assert!(refused.contains("the hinge of `thread`") && refused.contains("far lighter than its load"), "{refused}");
    assert!(refused.contains("pivot 1.0e-20"), "{refused}");
}
