//! What cannot be built is refused with the names of what is in the way.

use super::FOUR_BAR;
use stillpoint::scenario;

/// A parallelogram, upright.
const PARALLEL: &str = r#"
[[body]]
name = "crank"
mass = 1.0
center = [0.0, 0.0, 0.25]
inertia = [0.02, 0.02, 0.001]
markers = { pin = [0.0, 0.0, 0.5] }
hinge = { type = "revolute", axis = [0.0, 1.0, 0.0] }

[[body]]
name = "coupler"
mass = 1.0
center = [0.4, 0.0, 0.0]
inertia = [0.001, 0.05, 0.05]
markers = { pin = [0.8, 0.0, 0.0] }
hinge = { type = "revolute", parent = "crank", at = "pin", axis = [0.0, 1.0, 0.0] }

[[body]]
name = "rocker"
mass = 1.0
center = [0.0, 0.0, 0.25]
inertia = [0.02, 0.02, 0.001]
markers = { pin = [0.0, 0.0, 0.5] }
hinge = { type = "revolute", at = [0.8, 0.0, 0.0], axis = [0.0, 1.0, 0.0] }

[[loop]]
name = "coupler-rocker"
type = "revolute"
between = ["coupler.pin", "rocker.pin"]
axis = [0.0, 1.0, 0.0]
"#;

#[track_caller]
pub(super) fn refused(text: &str, parts: &[&str]) {
    let said = scenario::parse("scene.toml", text, &[]).expect_err("a refusal").to_string();
    for part in parts {
        assert!(said.contains(part), "no `{part}` in\n{said}");
    }
}

fn with(more: &str) -> String {
    format!("{FOUR_BAR}{more}")
}

#[test]
fn loops_that_cannot_close() {
    let far = FOUR_BAR.replace("at = [0.4, 0.0, 0.0]", "at = [1.4, 0.0, 0.0]");
    refused(&far, &["loop `coupler-rocker` cannot be closed: a gap of", "--> scene.toml", "between"]);
    let locked =
        FOUR_BAR.replace("position = 1.1", "position = 1.1, lock = true").replace("velocity = 14.0", "lock = true");
    refused(&locked, &["cannot be closed", "or the lock of `crank`, `coupler` does not fit"]);
    let askew = FOUR_BAR
        .replace("at = [0.4, 0.0, 0.0], axis = [0.0, 1.0, 0.0]", "at = [0.4, 0.0, 0.0], axis = [0.001, 1.0, 0.0]");
    refused(&askew, &["loop `coupler-rocker` cannot be closed", "a place or an axis does not fit"]);
    let same = with("[[loop]]\ntype = \"spherical\"\nbetween = [\"crank.pin\", \"crank\"]\n");
    refused(&same, &["both ends of `loop[1]` are on `crank`"]);
}

#[test]
fn gears_that_leave_nothing_to_move() {
    let geared = with("[[gear]]\nname = \"belt\"\ntype = \"ratio\"\nratio = 2.0\nbetween = [\"rocker\", \"crank\"]\n");
    refused(&geared, &["lock the mechanism", "gear `belt`"]);
    let ring = "[[body]]\nname = \"a\"\nmass = 1\ninertia = [1, 1, 1]\nhinge = { type = \"revolute\", axis = [0, 0, 1] }\n\
                [[body]]\nname = \"b\"\nmass = 1\ninertia = [1, 1, 1]\nhinge = { type = \"revolute\", axis = [0, 0, 1] }\n\
                [[body]]\nname = \"c\"\nmass = 1\ninertia = [1, 1, 1]\nhinge = { type = \"revolute\", axis = [0, 0, 1] }\n\
                [[gear]]\nname = \"ab\"\ntype = \"ratio\"\nratio = 2\nbetween = [\"a\", \"b\"]\n\
                [[gear]]\nname = \"bc\"\ntype = \"ratio\"\nratio = 2\nbetween = [\"b\", \"c\"]\n\
                [[gear]]\nname = \"ca\"\ntype = \"ratio\"\nratio = 2\nbetween = [\"c\", \"a\"]\n";
    refused(ring, &["gear `ab`, gear `bc`, gear `ca` lock the mechanism", "`a`, `b`, `c`"]);
}

#[test]
fn drives_that_contradict() {
    let drive = |name: &str, hinge: &str| {
        format!("[[drive]]\nname = \"{name}\"\nhinge = \"{hinge}\"\ntype = \"rate\"\nrate = 1.0\n")
    };
    let locked = FOUR_BAR.replace("velocity = 14.0", "lock = true") + &drive("motor", "crank");
    refused(&locked, &["`motor` drives `crank`, which is locked"]);
    let twice = with(&(drive("motor", "crank") + &drive("second", "crank")));
    refused(&twice, &["`motor` and `second` both drive `crank`"]);
    let both = PARALLEL.to_owned() + &drive("motor", "crank") + &drive("second", "rocker");
    refused(&both, &["drive `second` has nothing left to move: drive `motor` and the loops prescribe it"]);
    let apart = with(&(drive("motor", "crank") + &drive("second", "rocker")));
    refused(&apart, &["loop `coupler-rocker` cannot be closed", "or the drive `motor`, `second` does not fit"]);
    refused(&with(&drive("motor", "crnk")), &["there is no body `crnk`", "did you mean `crank`?"]);
    let ball =
        "[[body]]\nname = \"bob\"\nmass = 1\nhinge = { type = \"spherical\", at = [0, 0, 1] }\ncenter = [0, 0, -1]\ninertia = [1, 1, 1]\n"
            .to_owned();
    refused(&(ball + &drive("motor", "bob")), &["the spherical hinge of `bob` has no coordinate 0"]);
    let formula = with("[[drive]]\nhinge = \"crank\"\ntype = \"expression\"\nexpression = \"sin(omega*t)\"\n");
    refused(&formula, &["drive `drive[0]`: unknown name `omega`", "Known here: `t`"]);
    let table = with("[[drive]]\nhinge = \"crank\"\ntype = \"table\"\ntimes = [0, 1, 1]\nvalues = [0, 1, 2]\n");
    refused(&table, &["times must increase, but 1 s comes after 1 s"]);
}

#[test]
fn gears_that_contradict() {
    let gear = |name: &str, ratio: f64| {
        format!("[[gear]]\nname = \"{name}\"\ntype = \"ratio\"\nratio = {ratio:?}\nbetween = [\"crank\", \"rocker\"]\n")
    };
    refused(
        &with(&(gear("one", 2.0) + &gear("two", 3.0))),
        &["`two` gives `crank` and `rocker` the ratio 3, the gear `one` gives them a different one"],
    );
    // Around a loop: one that goes with it is redundant, others lock it.
    for contradicts in [gear("belt", -1.0), gear("belt", 1.0) + "offset = 0.3\n"] {
        refused(&(PARALLEL.to_owned() + &contradicts), &["lock the mechanism", "loop `coupler-rocker`", "gear `belt`"]);
    }
    assert_eq!(super::read(&(PARALLEL.to_owned() + &gear("belt", 1.0))).1.degrees_of_freedom(), 1);
    refused(&with(&gear("none", 0.0)), &["`ratio` of `none` is 0"]);
    let mixed = with("[[gear]]\nname = \"rack\"\ntype = \"rack\"\nradius = 0.1\nbetween = [\"crank\", \"rocker\"]\n");
    refused(&mixed, &["couples an angle with an angle"]);
}
