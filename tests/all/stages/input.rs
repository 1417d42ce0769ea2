//! Stages that cannot be: told with their line, or at their instant.

use stillpoint::model::Model;
use stillpoint::record::Fanout;
use stillpoint::scenario::parse;
use stillpoint::simulate::{self, State};

const ARM: &str = "[simulate]\nstart = \"given\"\nduration = 1.0\n[[body]]\nname = \"arm\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
    center = [0.5, 0, 0]\nhinge = { type = \"revolute\", axis = [0, 1, 0] }\n[[body]]\nname = \"bob\"\nmass = 0.5\ninertia = [0.1, 0.1, 0.1]\n\
    hinge = { parent = \"arm\", type = \"spherical\" }\n";

/// What is said of a scene with these stages, and the line at which it is said.
fn said(stages: &str) -> String {
    let problem = parse("scene.toml", &format!("{ARM}{stages}"), &[]).expect_err("a scene that cannot be");
    problem.render(false)
}

#[test]
fn stages_that_cannot_be_are_told_with_their_line() {
    let stage = |rest: &str| format!("[[stage]]\nname = \"s\"\n{rest}\n");
    let named = |name: &str, when: &str, verb: &str| {
        format!("[[stage]]\nname = \"{name}\"\nwhen = {when}\n{verb} = [\"arm\"]\n")
    };
    let locked = |verb: &str| {
        let hinge = "hinge = { type = \"prismatic\", axis = [0, 0, 1], lock = true }";
        let pin = format!("[[body]]\nname = \"pin\"\nmass = 1.0\n{hinge}\n");
        pin + &stage(&format!("when = {{ time = 0.5 }}\n{verb} = [\"pin\"]"))
    };
    let cases = [
        (stage("when = { time = 0.5 }\nopen = [\"amr\"]"), "did you mean `arm`?", "| open = [\"amr\"]"),
        (stage("when = { time = -0.5 }\nopen = [\"arm\"]"), "time", "| when"),
        (stage("when = { event = \"never\" }\nopen = [\"arm\"]"), "there is no event `never`", "| when"),
        (stage("when = { }\nopen = [\"arm\"]"), "exactly one of `time` and `event`", "| when"),
        (stage("when = { time = 1, event = \"x\" }\nopen = [\"arm\"]"), "exactly one of `time` and `event`", "| when"),
        (stage("when = { time = 0.5 }"), "changes nothing", "| [[stage]]"),
        (stage("open = [\"arm\"]"), "when", "| [[stage]]"),
        (stage("when = { time = 0.5 }\nopen = [\"arm\"]\nlock = [\"arm\"]"), "in `open` and in `lock`", "| lock"),
        (stage("when = { time = 0.5 }\nclose = [\"arm\"]"), "cannot close", "| close"),
        (stage("when = { time = 0.5 }\nlock = [\"bob\"]"), "no coordinates that a lock holds", "| lock"),
        (
            stage("when = { time = 0.5 }\nopen = [\"arm\"]") + "[[stage]]\nwhen = { time = 0.6 }\nlock = [\"arm\"]\n",
            "comes at t = 0.6 s: `arm` has opened at t = 0.5 s already",
            "| lock",
        ),
        (
            stage("when = { time = 0.5 }\nopen = [\"arm\"]") + &stage("when = { time = 0.6 }\nlock = [\"bob\"]"),
            "two stages are called `s`",
            "| name",
        ),
        (
            named("a", "{ time = 0.3 }", "lock") + &named("b", "{ time = 0.1 }", "release"),
            "stage `b`: `arm` is not locked at t = 0.1 s",
            "| release",
        ),
        (
            named("a", "{ time = 0.3 }", "lock") + &named("b", "{ time = 0.3 }", "release"),
            "in `lock` at the same instant, t = 0.3 s",
            "| release",
        ),
        (
            named("a", "{ time = 0.3 }", "lock") + &named("b", "{ time = 0.3 }", "open"),
            "in `lock` at the same instant, t = 0.3 s",
            "| open",
        ),
        (
            named("a", "{ time = 0.3 }", "open") + &named("b", "{ time = 0.3 }", "lock"),
            "in `open` at the same instant, t = 0.3 s",
            "| lock",
        ),
        // A point mass that would turn about itself.
        (
            "[[body]]\nname = \"dot\"\nmass = 1.0\nhinge = { type = \"prismatic\", axis = [0, 0, 1] }\n".to_owned()
                + &stage("when = { time = 0.5 }\nopen = [\"dot\"]"),
            "after stage `s`: `dot` has no inertia",
            "| [[stage]]",
        ),
        (
            "[[event]]\nname = \"low\"\nhinge = \"arm\"\nvalue = 1.0\naction = \"stop\"\n".to_owned()
                + &stage("when = { event = \"low\" }\nopen = [\"arm\"]"),
            "never comes: the run ends at its event `low`",
            "| when",
        ),
        (locked("release"), "the hinge of `pin` has `lock = true`, which holds in all stages", "| release"),
        (locked("lock"), "the hinge of `pin` has `lock = true`, which holds in all stages", "| lock = [\"pin\"]"),
    ];
    for (stages, words, place) in cases {
        let text = said(&stages);
        assert!(text.contains(words) && text.contains(place), "{words} at {place}:\n{text}");
    }
}

/// Stages come at their times, in whatever order the file has them.
#[test]
fn stages_that_agree_in_time_are_fine() {
    let stage = |name: &str, when: &str, verb: &str| {
        format!("[[stage]]\nname = \"{name}\"\nwhen = {{ {when} }}\n{verb} = [\"arm\"]\n")
    };
    let fine = [
        stage("a", "time = 0.1", "release") + &stage("b", "time = 0.3", "lock"),
        stage("a", "time = 0.3", "lock") + &stage("b", "time = 0.5", "release"),
        // When an event comes is known in a run alone.
        "[[event]]\nname = \"low\"\nhinge = \"arm\"\nvalue = 0.1\n".to_owned()
            + &stage("a", "event = \"low\"", "lock")
            + &stage("b", "time = 0.1", "release"),
    ];
    for stages in fine {
        let found = parse("scene.toml", &format!("{ARM}{stages}"), &[]);
        found.unwrap_or_else(|problem| panic!("{}", problem.render(false)));
    }
}

/// What closes while it is open by more than rounding ends the run, with time, stage and gap.
#[test]
fn a_loop_that_does_not_meet_is_told_at_its_instant() {
    let text = ARM.to_owned()
        + "[[loop]]\nname = \"hook\"\ntype = \"spherical\"\nbetween = [{ body = \"arm\", at = [1, 0, 0] }, \"ground\"]\n\
           [[stage]]\nname = \"catch\"\nwhen = { time = 0.25 }\nclose = [\"hook\"]\n";
    let scenario = parse("scene.toml", &text, &[]).unwrap_or_else(|problem| panic!("{}", problem.render(false)));
    let model = Model::build(&scenario.description).expect("a sound scene");
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let failed = simulate::run(&model, &scenario.simulate, 1.0, &start, &mut Fanout::new(), &mut |_, _| true);
    let words = failed.expect_err("a hook that hangs in the air").to_string();
    assert!(
        words.contains("at t = 0.25 s stage `catch` cannot come") && words.contains("let the parts meet"),
        "{words}"
    );
}

/// A contact that closes while its bodies are deep in each other ends the run with time, stage and depth.
#[test]
fn a_contact_that_closes_too_late_is_told_at_its_instant() {
    let text = "[simulate]\nstart = \"given\"\nduration = 1.0\n[[body]]\nname = \"ball\"\nmass = 1.0\n\
        inertia = [0.004, 0.004, 0.004]\nshape = { sphere = 0.1 }\nhinge = { type = \"free\", position = [0, 0, 0.1, 1, 0, 0, 0] }\n\
        [[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n\
        [[contact]]\nname = \"c\"\nbetween = [\"ball\", \"floor\"]\nfriction = 0.2\n\
        [[stage]]\nname = \"trap\"\nwhen = { time = 0.6 }\nclose = [\"c\"]\n";
    let scenario = parse("scene.toml", text, &[]).unwrap_or_else(|problem| panic!("{}", problem.render(false)));
    let model = Model::build(&scenario.description).expect("a sound scene");
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let failed = simulate::run(&model, &scenario.simulate, 1.0, &start, &mut Fanout::new(), &mut |_, _| true);
    let words = failed.expect_err("a ball under the floor").to_string();
    // g t²/2 after 0.6 s.
    assert!(words.contains("at t = 0.6 s stage `trap` cannot come: `ball` and `floor` overlap by 1.7652 m"), "{words}");
    assert!(!words.contains("settle"), "{words}");
}

/// The force of a drive that a stage opens: the message says that, and not that there is no such drive.
#[test]
fn forces_of_what_opens_are_no_outputs() {
    let text = said(
        "[[drive]]\nname = \"hold\"\ntype = \"hold\"\nhinge = \"arm\"\n\
         [[output]]\nname = \"held\"\ntype = \"force\"\nof = \"hold\"\n\
         [[stage]]\nname = \"go\"\nwhen = { time = 0.5 }\nopen = [\"hold\"]\n",
    );
    assert!(text.contains("output `held` asks for the force of `hold`, which stage `go` opens"), "{text}");
}

/// What closes a hinge instead depends on its type: no loop leads along a curve.
#[test]
fn what_closes_in_the_place_of_a_hinge_is_there() {
    let closes = "[[stage]]\nname = \"s\"\nwhen = { time = 0.5 }\nclose = [";
    let revolute = said(&format!("{closes}\"arm\"]\n"));
    assert!(revolute.contains("close a `[[loop]]` of this type"), "{revolute}");
    let bead = "[[body]]\nname = \"bead\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
                hinge = { type = \"along\", curve = { straight = 1.0 }, position = 0.4 }\n";
    let along = said(&format!("{bead}{closes}\"bead\"]\n"));
    assert!(along.contains("no `[[loop]]` is of the type `along`") && !along.contains("of this type"), "{along}");
}
