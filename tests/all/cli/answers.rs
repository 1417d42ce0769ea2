//! Exit codes and what is said with them.

use super::{BRICK, Bench, shipped};

#[test]
fn what_goes_well_ends_with_0() {
    let bench = Bench::new();
    let pendulum = shipped("pendulum");
    for command in ["run", "statics", "rest", "inspect", "check"] {
        let answer = bench.call(&[command, &pendulum]).code(0);
        assert!(answer.err.is_empty() && !answer.out.is_empty(), "{command}: {answer:#?}");
    }
    let help = bench.call(&["--help"]).code(0);
    for command in ["run", "statics", "rest", "precision", "inspect", "view", "check", "schema"] {
        assert!(help.out.contains(&format!("\n  {command} ")), "{command} is not in the help");
        assert!(bench.call(&[command, "--help"]).code(0).out.contains("Usage:"));
    }
    assert!(bench.call(&["--version"]).code(0).out.contains(env!("CARGO_PKG_VERSION")));
    let schema: serde_json::Value = serde_json::from_str(&bench.call(&["schema"]).code(0).out).expect("JSON");
    assert!(schema["properties"]["body"].is_object());
}

#[test]
fn wrong_calls_end_with_2() {
    let bench = Bench::new();
    let pencil = shipped("pencil");
    for (arguments, said) in [
        (&["run"][..], "<SCENARIO>"),
        (&[], "Usage:"),
        (&["fly", &pencil], "fly"),
        (&["run", &pencil, "--fast"], "--fast"),
        (&["run", &pencil, "--set", "nonsense"], "write a path and a value"),
        (&["run", &pencil, "--set", "pencil.mas=3"], "did you mean `mass`?"),
        (&["run", &pencil, "--set", "pen.mass=3"], "pencil"),
        (&["run", "nothing.toml"], "no scenario `nothing.toml`"),
        (&["statics", "."], "is a folder"),
        (&["view", "nothing.mcap"], if cfg!(feature = "view") { "nothing.mcap" } else { "without the `view` feature" }),
    ] {
        let answer = bench.call(arguments).code(2);
        assert!(answer.out.is_empty() && answer.err.contains(said), "{arguments:?}: {answer:#?}");
        assert_eq!(answer.err.matches("error:").count().min(1), usize::from(!arguments.is_empty()), "{answer:#?}");
    }
    assert!(bench.names().is_empty(), "{:?}", bench.names());
}

#[test]
fn a_body_without_support_is_named_with_the_direction_it_falls_in() {
    let bench = Bench::new();
    bench.write("brick.toml", BRICK);
    let answer = bench.call(&["run", "brick.toml"]).code(1);
    assert!(answer.out.contains("no equilibrium"), "{answer:#?}");
    assert!(answer.out.contains("nothing holds `brick` against gravity along [0.000, 0.000, -1.000]"), "{answer:#?}");
    assert!(answer.err.contains("nothing was simulated"), "{answer:#?}");
    assert_eq!(bench.names(), ["brick.toml"], "no recording of a run that did not start");
    for command in ["statics", "rest", "run"] {
        let answer = bench.call(&[command, "brick.toml", "--json"]).code(1);
        assert!(answer.json().to_string().contains("falls for ever"), "{answer:#?}");
    }
}

#[test]
fn an_unstable_equilibrium_is_taken_left_or_refused_as_wanted() {
    let bench = Bench::new();
    let pencil = shipped("pencil");
    let statics = |changes: &[&str]| {
        let set: Vec<&str> = changes.iter().flat_map(|change| ["--set", change]).collect();
        bench.call(&[&["statics", &pencil, "--json"], &set[..]].concat())
    };
    let any = statics(&[]).code(0).json();
    assert_eq!(
        (&any["stability"], &any["unstable_directions"], &any["converged"]),
        (&"unstable".into(), &1.into(), &true.into())
    );
    let stable = statics(&["statics.want=stable"]).code(0).json();
    assert_eq!(stable["stability"], "stable");
    assert!(stable["notes"].to_string().contains("left an unstable equilibrium"), "{stable}");
    let refused = statics(&["statics.want=stable", "statics.method=newton"]).code(1).json();
    assert_eq!((&refused["stability"], &refused["converged"]), (&"unstable".into(), &false.into()));
    let rest = bench.call(&["rest", &pencil]).code(1);
    assert!(rest.out.contains("not at rest") && rest.out.contains("predicted 9.168"), "{rest:#?}");
    let run = bench.call(&["run", &pencil]).code(0);
    assert!(run.err.contains("unstable"), "a run that starts there says so: {run:#?}");
}

#[test]
fn check_counts_what_is_wrong_in_every_file() {
    let bench = Bench::new();
    bench.write("good.toml", BRICK);
    bench.write("bad.toml", BRICK.replace("mass", "mas"));
    let answer = bench.call(&["check", "good.toml", "bad.toml", "--json"]).code(2);
    let said = answer.json();
    assert_eq!(said["valid"], false);
    assert_eq!(said["scenarios"][0]["valid"], true);
    assert_eq!(said["scenarios"][1]["valid"], false);
    assert!(answer.err.contains("bad.toml:3:1") && !answer.err.contains("good.toml"), "{answer:#?}");
    assert_eq!(bench.call(&["check", "good.toml"]).code(0).out, "good.toml: fine\n");
}

/// Where only an unstable equilibrium is found, that is what is printed, and the answer is no.
#[test]
fn an_unstable_answer_to_the_wish_for_a_stable_one_is_no() {
    let bench = Bench::new();
    let pencil = shipped("pencil");
    let call = ["statics", &pencil, "--method", "newton", "--set", "statics.want=\"stable\""];
    let answer = bench.call(&call).code(1);
    assert!(
        answer.out.contains("unstable equilibrium") && answer.out.contains("pose         pencil"),
        "{}",
        answer.out
    );
    assert!(answer.out.contains("only an unstable equilibrium was found"), "{}", answer.out);
    let json = bench.call(&[&call[..], &["--json"]].concat()).code(1).json();
    assert_eq!((json["converged"].as_bool(), json["balanced"].as_bool()), (Some(false), Some(true)));
}

#[test]
fn a_path_over_a_number_that_is_not_there_is_a_wrong_call() {
    let bench = Bench::new();
    let change = "statics.path.parameter=\"engin.rate\"";
    let answer = bench.call(&["statics", &shipped("governor_rise"), "--set", change]).code(2);
    assert!(
        answer.err.contains("nothing is called `engin`") && answer.err.contains("did you mean `engine`"),
        "{}",
        answer.err
    );
}

/// A lock where the loops cannot follow, and a lock on what is driven: refused before anything runs.
#[test]
fn locks_that_contradict_are_wrong_calls() {
    let bench = Bench::new();
    let four_bar = shipped("four_bar");
    let lock = |body: &str| format!("{body}.hinge.lock=true");
    let both = ["--set", &lock("crank"), "--set", &lock("rocker"), "--set", "rocker.hinge.position=1.4"];
    let answer = bench.call(&[&["statics", &four_bar], &both[..]].concat()).code(2);
    assert!(answer.err.contains("cannot be closed") && answer.err.contains("lock"), "{}", answer.err);
    let driven = bench.call(&["statics", &shipped("excavator"), "--set", &lock("boom piston")]).code(2);
    assert!(driven.err.contains("drives `boom piston`, which is locked"), "{}", driven.err);
}

#[test]
fn an_unknown_that_nothing_feels_is_answered_with_no() {
    let bench = Bench::new();
    // A door: no weight along its hinge turns it.
    bench.write(
        "door.toml",
        "[statics]\nunknown = [\"door.force\", \"gravity[2]\"]\n[[body]]\nname = \"door\"\nmass = 1\ninertia = [1, 1, 1]\n\
         center = [0.5, 0, 0]\nhinge = { type = \"revolute\", axis = [0, 0, 1], stiffness = 2.0, position = 0.3 }\n",
    );
    let answer = bench.call(&["statics", "door.toml"]).code(1);
    assert!(answer.out.contains("the unknown `gravity[2]` cannot influence the pose"), "{}", answer.out);
}

/// Panels on a hub in space, springs as far from rest as they are put: where nothing pulls any more there is no force to be small beside.
#[test]
fn relaxed_springs_in_space_are_an_equilibrium() {
    let bench = Bench::new();
    for (position, stiffness) in [(-1.5, 2.0), (0.3, 1e6), (1e-9, 1e-3)] {
        let panel = |name: &str, side: f64| {
            format!(
                "[[body]]\nname = \"{name}\"\nmass = 12\ncenter = [0, {side:?}, 0]\ninertia = [4.0, 0.4, 4.4]\n\
                 hinge = {{ parent = \"hub\", at = [0, {:?}, 0], type = \"revolute\", axis = [{side:?}, 0, 0], \
                 stiffness = {stiffness:?}, position = {position:?} }}\n",
                0.6 * side
            )
        };
        bench.write(
            "space.toml",
            "gravity = [0, 0, 0]\n[[body]]\nname = \"hub\"\nmass = 200\ninertia = [60, 70, 80]\nhinge = { type = \"free\" }\n".to_owned()
                + &panel("left", 1.0)
                + &panel("right", -1.0)
                + "[[drive]]\nname = \"hold\"\nhinge = \"right\"\ntype = \"hold\"\n",
        );
        let found = bench.call(&["statics", "space.toml", "--json"]).code(0).json();
        let left = found["positions"]["left"][0].as_f64().expect("an angle");
        assert!(left.abs() < 1e-15 && found["iterations"].as_f64() < Some(10.0), "{left}: {found}");
        assert!(found["relative_residual"].as_f64() < Some(1e-10), "{found}");
    }
}

/// What opens keeps the velocity that it has on what carried it, when a stage is looked at by itself.
#[test]
fn a_stage_is_inspected_with_the_velocities_of_what_has_opened() {
    let bench = Bench::new();
    bench.write(
        "open.toml",
        "gravity = [0, 0, 0]\n[[body]]\nname = \"bar\"\nmass = 1\ninertia = [0.1, 0.1, 0.1]\n\
         hinge = { type = \"revolute\", axis = [0, 1, 0], velocity = 1.0 }\n\
         [[body]]\nname = \"tip\"\nmass = 1\ninertia = [0.1, 0.1, 0.1]\n\
         hinge = { parent = \"bar\", at = [0.5, 0, 0], type = \"revolute\", axis = [0, 1, 0] }\n\
         [[stage]]\nname = \"off\"\nwhen = { time = 0.0 }\nopen = [\"tip\"]\n",
    );
    let seen = bench.call(&["inspect", "open.toml", "--stage", "off", "--json"]).code(0).json();
    assert_eq!(seen["velocities"]["tip"], serde_json::json!([0.0, 0.0, -0.5, 0.0, 1.0, 0.0]), "{seen}");
    // 0.05 J of the bar, 0.125 + 0.05 J of what has left it.
    assert!((seen["kinetic_energy"].as_f64().expect("a number") - 0.225).abs() < 1e-15, "{seen}");
}

/// A pose that three rods hold to second order only, and if they are rigid.
const INFINITESIMAL: &str = "
gravity = [0.0, 0.0, -9.81]
statics = {want = \"any\"}
[[body]]
name = \"p\"
mass = 2.0
inertia = [0.14, 0.14, 0.14]
hinge = {type = \"planar\", rpy = [1.5707963267948966, 0.0, 0.0]}
[[loop]]
type = \"rod\"
between = [{body = \"ground\", at = [-0.07586410887125675, 0.0, -0.7384938757700088]}, {body = \"p\", at = [-0.24938549639535737, 0.05945260930081053, 0.0]}]
length = 0.8165955332752957
[[loop]]
type = \"rod\"
between = [{body = \"ground\", at = [-0.04811330262775715, 0.0, -0.998797171005017]}, {body = \"p\", at = [-0.6432751136745556, 0.09670875075074054, 0.0]}]
length = 1.2467360610531952
[[loop]]
type = \"rod\"
between = [{body = \"ground\", at = [0.05344844734912603, 0.0, -0.11230576342897536]}, {body = \"p\", at = [0.0941523674949819, 0.6302504125725852, 0.0]}]
length = 0.7436709511829145
";

#[test]
fn a_verdict_that_supposes_something_says_so_beside_it() {
    let bench = Bench::new();
    bench.write("rods.toml", INFINITESIMAL);
    let answer = bench.call(&["statics", "rods.toml", "--json"]).code(0).json();
    assert_eq!(answer["stability"], "stable");
    assert_eq!(answer["stability_supposes"], "rows that are linearly dependent are rigid");
    let pendulum = bench.call(&["statics", &shipped("pendulum"), "--json"]).code(0).json();
    assert!(pendulum["stability_supposes"].is_null());
}

/// A bar that hangs straight down between two springs alike leans by round-off at most: nothing moves that by per cents of itself.
#[test]
fn what_is_round_off_has_no_relative_influence() {
    let bench = Bench::new();
    let spring = |name: &str, x: f64| {
        format!(
            "[[force]]\nname = \"{name}\"\ntype = \"spring\"\nstiffness = 30.0\nlength = 0.7\n\
             between = [\"bar.end\", {{ body = \"ground\", at = [{x:?}, 0.0, -1.9] }}]\n"
        )
    };
    for seed in 1..8 {
        let start = 0.07 * f64::from(seed);
        let text = format!(
            "[[body]]\nname = \"bar\"\nmass = 2.0\ncenter = [0, 0, -1]\ninertia = [0.1, 0.1, 0.1]\nmarkers = {{ end = [0, 0, -2] }}\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], position = {start:?} }}\n{}{}\
             [[output]]\nname = \"lean\"\ntype = \"position\"\nof = \"bar.end\"\naxis = [1, 0, 0]\n",
            spring("left", -1.3),
            spring("right", 1.3)
        );
        bench.write("bar.toml", &text);
        let answer = bench.call(&["statics", "bar.toml", "--sensitivity", "lean"]).code(0);
        let rows = answer.out.lines().skip_while(|line| !line.contains("sensitivity")).skip(1);
        let shares: Vec<f64> = rows.filter_map(|row| row.split_whitespace().next()?.parse().ok()).collect();
        assert!(shares.is_empty(), "{shares:?}\n{}", answer.out);
    }
}
