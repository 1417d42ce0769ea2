//! Paths of equilibria: folds, bifurcations and flutter where closed forms have them, and all equilibria on the way.

use crate::reference::case::case;
use crate::scenarios::shipped;
use std::f64::consts::{FRAC_PI_3, PI};
use stillpoint::scenario::{self, Override, Scenario};
use stillpoint::statics::StabilityVerdict;
use stillpoint::statics::path::{BranchEnd, EventKind, Path, PathBranch, PathPoint, follow};

fn path_of(scenario: &Scenario) -> Path {
    let settings = scenario.path.as_ref().expect("a path");
    follow(&scenario.description, &scenario.statics, settings, &mut |_| true).unwrap_or_else(|error| panic!("{error}"))
}

fn read(text: &str) -> Scenario {
    scenario::parse("path.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}"))
}

fn followed(text: &str) -> Path {
    let path = path_of(&read(text));
    assert!(path.complete, "{:?} {:?}", path.notes, path.start.notes);
    proven(&path);
    path
}

/// Every point of a path is an equilibrium to round-off, whatever else it is.
fn proven(path: &Path) {
    for point in path.branches.iter().flat_map(|branch| &branch.points) {
        assert!(point.relative_residual < 1e-10, "{} {:e}", point.parameter, point.relative_residual);
    }
}

fn events(path: &Path, kind: EventKind) -> Vec<(usize, &PathPoint)> {
    path.events().filter(|(_, point)| point.event.as_ref().is_some_and(|event| event.kind == kind)).collect()
}

fn wanted(branch: &PathBranch) -> impl Iterator<Item = &PathPoint> {
    branch.points.iter().filter(|point| point.wanted)
}

#[track_caller]
fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "found {found}, expected {expected} within {tolerance:e}");
}

/// Limit load and height of the arch, and all three equilibria under half of it.
#[test]
fn snap_through_goes_around_both_folds() {
    let case = case("B04_von_mises_truss");
    let (reference, tolerance) = (case.at("reference"), case.tolerance("abs"));
    let (scenario, _) = shipped("snap_through", &[]);
    let path = path_of(&scenario);
    assert!(path.complete && path.branches.len() == 1, "{:?}", path.notes);
    proven(&path);
    let folds = events(&path, EventKind::Fold);
    assert_eq!((folds.len(), path.events().count()), (2, 2));
    for ((_, fold), sign) in folds.iter().zip([-1.0, 1.0]) {
        near(fold.parameter, sign * reference.at("limit_load").number(), tolerance);
        // The load is quadratic in the height there: a height of ten digits is a load of twenty.
        near(fold.position[0], -sign * reference.at("limit_height").number(), 1e-9);
    }
    let equilibria = reference.at("equilibria").items();
    let under: Vec<&PathPoint> = wanted(&path.branches[0]).collect();
    let kinds: Vec<StabilityVerdict> = under.iter().map(|point| point.verdict).collect();
    assert_eq!(kinds, [StabilityVerdict::Stable, StabilityVerdict::Unstable, StabilityVerdict::Stable]);
    near(under[0].position[0], equilibria[0].at("y").number(), tolerance);
    near(under[2].position[0], equilibria[2].at("y").number(), tolerance);
    // 2 k y (1 − L₀/√(1 + y²)) = −W in between, where no digits are given.
    let height = under[1].position[0];
    let (length, load) = ((1.0 + height * height).sqrt(), under[1].parameter);
    near(2000.0 * height * (1.0 - case.parameter("L0") / length), load, 1e-10);
}

/// Upright on a spring: the pitchfork at `k = m g l`, and its branches at the case's stiffnesses.
#[test]
fn pitchfork_leaves_at_the_critical_stiffness() {
    let case = case("B02_inverted_pendulum_pitchfork");
    let weight = case.parameter("mgl");
    let ratios = [0.9, 0.5];
    let path = followed(&format!(
        "gravity = [0, {:?}, 0]\n[statics]\nwant = \"any\"\n[statics.path]\nparameter = \"arm.stiffness\"\nfrom = {:?}\n\
         to = {:?}\nat = {:?}\n[[body]]\nname = \"arm\"\nmass = {:?}\ncenter = [0, {:?}, 0]\n\
         hinge = {{ type = \"revolute\", axis = [0, 0, 1], stiffness = 1 }}\n",
        -case.parameter("g"),
        1.5 * weight,
        0.2 * weight,
        ratios.map(|ratio| ratio * weight),
        case.parameter("m"),
        case.parameter("l"),
    ));
    assert_eq!(path.branches.len(), 3, "upright, and bent to both sides");
    let [(0, fork)] = events(&path, EventKind::Bifurcation)[..] else { panic!("one bifurcation") };
    near(fork.parameter, weight, 1e-12 * weight);
    assert_eq!((fork.position[0], path.events().count()), (0.0, 1));
    let sides: Vec<f64> = path.branches.iter().map(|branch| branch.points[1].position[0].signum()).collect();
    assert_eq!(sides[1], -sides[2]);
    for (branch, side) in path.branches.iter().zip(sides).skip(1) {
        assert_eq!(branch.parent.map(|(parent, _)| parent), Some(0));
        assert_eq!(wanted(branch).count(), 2);
        for (point, ratio) in wanted(branch).zip(ratios) {
            let key = format!("k_over_mgl={ratio}");
            let expected = case.at("reference").at(&key).at("theta_stable_plus_minus").number();
            near(point.position[0], side * expected, case.tolerance("abs"));
            assert_eq!(point.verdict, StabilityVerdict::Stable);
        }
    }
    assert!(wanted(&path.branches[0]).all(|point| point.verdict == StabilityVerdict::Unstable));
}

/// Loads at which a clamped strut of `n` links buckles: 4 n² sin²((2 m − 1) π / 4 n) EI/L², exact for the links.
#[test]
fn strut_buckles_at_eulers_loads_and_bends_like_the_elastica() {
    // P/P₁ = (2 K(k)/π)² with k = sin(α/2), for a tip angle α of 60 degrees.
    let bent = 1.151_700_585_7;
    let first = 0.25 * PI * PI;
    let at = format!("statics.path.at=[{:?}]", -bent * first);
    let (scenario, model) = shipped("buckling_strut", &[&at]);
    let path = path_of(&scenario);
    assert!(path.complete, "{:?}", path.notes);
    proven(&path);
    let forks = events(&path, EventKind::Bifurcation);
    assert_eq!((forks.len(), path.events().count(), path.branches.len()), (2, 2, 5));
    for ((branch, fork), mode) in forks.iter().zip([1.0, 3.0]) {
        let expected = -400.0 * (mode * PI / 40.0).sin().powi(2);
        near(fork.parameter, expected, 1e-10 * expected.abs());
        assert_eq!(*branch, 0);
    }
    for branch in &path.branches[1..3] {
        let point = wanted(branch).next().expect("a point");
        assert_eq!(point.verdict, StabilityVerdict::Stable);
        let tip: f64 = point.position.iter().sum();
        // Ten links are a strut softer by a part in 490: 4 n² sin²(π/4n) against π²/4. Beside the fork the angle feels
        // that four times over: P/P₁ grows by α²/8.
        near(tip.abs(), FRAC_PI_3, 1e-2);
        assert!(branch.points.iter().all(|point| point.unstable_directions == 0));
    }
    assert!(path.branches[3..].iter().all(|b| b.points.iter().all(|p| p.verdict == StabilityVerdict::Unstable)));
    // Where the run starts: bent, and stable.
    let found = crate::scenarios::found(&scenario, &model);
    let tip: f64 = found.position.iter().sum();
    assert!(tip.abs() > 1.0, "3 N are more than it carries straight: {tip}");
}

/// A push that turns with the link: no fold, no fork, and growing motion from the load of the case on.
#[test]
fn follower_load_flutters() {
    let case = case("A13_ziegler_follower");
    let (length, stiffness) = (case.parameter("l"), case.parameter("k"));
    let link = |name: &str, parent: &str, at: f64, mass: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = {mass:?}\ncenter = [0, {length:?}, 0]\nhinge = {{ type = \"revolute\", \
             parent = \"{parent}\", at = [0, {at:?}, 0], axis = [0, 0, 1], stiffness = {stiffness:?} }}\n"
        )
    };
    let path = followed(&format!(
        "gravity = [0, 0, 0]\n[statics.path]\nparameter = \"push.force[1]\"\nto = -2.5\n{}{}[[force]]\nname = \"push\"\n\
         type = \"load\"\naxes = \"body\"\non = {{ body = \"upper\", at = [0, {length:?}, 0] }}\n",
        link("lower", "ground", 0.0, case.parameter("m1")),
        link("upper", "lower", length, case.parameter("m2")),
    ));
    let [(0, flutter)] = events(&path, EventKind::Flutter)[..] else { panic!("{:?}", path.events().count()) };
    // Growth sets in with the square root of the excess; below 1e-7 of the largest rate it is taken for round-off.
    near(-flutter.parameter, case.at("reference").at("P_flutter_undamped").number(), 1e-9);
    assert_eq!(path.events().count(), 1);
}

/// A chain in a wind that grows: every link along the pull, whatever the number of links, by sweeps alone.
#[test]
fn chain_follows_the_direction_of_gravity() {
    let (scenario, _) =
        shipped("hanging_chain", &["link.repeat=60", "statics.path={ parameter = \"gravity[0]\", to = 9.80665 }"]);
    let path = path_of(&scenario);
    assert!(path.complete && path.events().count() == 0, "{:?}", path.notes);
    proven(&path);
    for point in &path.branches[0].points {
        // Turns about y: downwards is positive.
        near(point.position[0], f64::atan2(9.80665, point.parameter), 1e-12);
        assert_eq!(point.verdict, StabilityVerdict::Stable);
    }
    assert_eq!(
        path.branches[0].points.last().map(|point| point.parameter),
        Some(9.80665),
        "ends where it was asked to"
    );
}

/// Balls that may spin cost nothing all the way: the path goes on, and says neutral.
#[test]
fn motions_that_cost_nothing_do_not_stop_a_path() {
    let mut text = "[statics.path]\nparameter = \"gravity[0]\"\nto = 5\n".to_owned();
    for (index, parent) in ["ground", "b0", "b1"].iter().enumerate() {
        text += &format!(
            "[[body]]\nname = \"b{index}\"\nmass = 1\ncenter = [0, 0, -0.5]\ninertia = [0.1, 0.1, 0.01]\nhinge = {{ type = \
             \"spherical\", parent = \"{parent}\", at = [0, 0, {}] }}\n",
            if index == 0 { 0 } else { -1 }
        );
    }
    let path = followed(&text);
    assert_eq!(path.branches[0].end, BranchEnd::Range);
    for point in &path.branches[0].points {
        assert_eq!((point.verdict, point.event.is_none()), (StabilityVerdict::Neutral, true));
        let down = point.poses[2].rotation * -nalgebra::Vector3::z();
        near(down.x / -down.z, point.parameter / 9.80665, 1e-9);
    }
}

/// A hinge that is held can be moved, and what hangs on it follows.
#[test]
fn a_held_hinge_is_moved_through_its_range() {
    let body = |name: &str, rest: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = 1\ncenter = [0, 0, -0.5]\ninertia = [0.1, 0.1, 0.01]\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], {rest} }}\n"
        )
    };
    let path = followed(
        &("[statics.path]\nparameter = \"crank.position\"\nto = 3\n".to_owned()
            + &body("crank", "lock = true, position = 0.5")
            + &body("bob", "parent = \"crank\", at = [0, 0, -1]")),
    );
    for point in &path.branches[0].points {
        assert_eq!(point.position[0], point.parameter);
        near(point.position[1], -point.parameter, 1e-12);
    }
}

/// A pendulum with a motor: hanging and upright are one curve, and the motor can hold it no further than level.
#[test]
fn a_path_ends_where_it_leaves_its_range_again() {
    let path = followed(
        "[statics.path]\nparameter = \"bob.force\"\nfrom = 0\nto = 20\n[[body]]\nname = \"bob\"\nmass = 1\n\
         center = [0, 0, -1]\nhinge = { type = \"revolute\", axis = [0, 1, 0], position = 0.1 }\n",
    );
    // Up to m g l, where the pendulum stands out horizontally, and back to 0 upright: outside the range beyond.
    let [(0, fold)] = events(&path, EventKind::Fold)[..] else { panic!("one fold") };
    near(fold.parameter, 9.80665, 1e-11);
    near(fold.position[0], 0.5 * PI, 1e-9);
    let last = path.branches[0].points.last().expect("points");
    assert_eq!((path.branches[0].end.clone(), last.parameter), (BranchEnd::Range, 0.0));
    near(last.position[0], PI, 1e-12);
}

#[test]
fn what_a_path_cannot_follow_is_said() {
    let scene = "[[body]]\nname = \"bob\"\nmass = 1\ncenter = [0, 0, -1]\nhinge = { type = \"revolute\", axis = [0, 1, 0] }\n\
                 [[body]]\nname = \"slider\"\nmass = 1\ninertia = [1, 1, 1]\nhinge = { type = \"planar\", lock = true }\n\
                 [[force]]\nname = \"push\"\ntype = \"load\"\non = \"bob\"\n";
    let bad = [
        ("parameter = \"bob.lenght\"\nto = 1", "no number `lenght`", 2),
        ("parameter = \"bab.force\"\nto = 1", "nothing is called `bab`", 2),
        ("parameter = \"bob.position\"\nto = 1", "is a guess", 2),
        ("parameter = \"push.force\"\nto = 1", "has several components", 2),
        ("parameter = \"hinge.force\"\nto = 1", "has several components", 2),
        ("parameter = \"bob.force\"\nto = 0", "there is no way", 3),
        ("parameter = \"bob.mass\"\nto = -2", "the mass of `bob` is -2", 3),
        ("parameter = \"bob.force\"\nto = 1\nat = [2]", "2 is not between 0 and 1", 4),
        ("parameter = \"bob.force\"\nto = 1\ncoordinate = \"bob.mass\"", "is no coordinate", 4),
        ("parameter = \"bob.force\"", "`to` is missing", 1),
    ];
    for (keys, expected, line) in bad {
        let text = format!("[statics.path]\n{keys}\n{scene}");
        let problems = scenario::parse("path.toml", &text, &[]).expect_err(expected);
        let first = problems.iter().next().expect("one");
        assert!(first.message.contains(expected), "{expected}: {problems}");
        assert_eq!(first.place.as_ref().map(|place| place.line), Some(line), "{problems}");
    }
    // Nothing feels how much a body weighs that a lock holds.
    let text = format!("[statics.path]\nparameter = \"slider.mass\"\nto = 3\n{scene}");
    let scenario = read(&text);
    let settings = scenario.path.as_ref().expect("a path");
    let error = follow(&scenario.description, &scenario.statics, settings, &mut |_| true).expect_err("no influence");
    assert!(error.contains("nothing in this equilibrium feels `slider.mass`"), "{error}");
    // Where nothing rests at the start there is no path.
    let text = format!("[statics.path]\nparameter = \"bob.force\"\nfrom = 100\nto = 0\n{scene}");
    let path = path_of(&read(&text));
    assert!(
        !path.complete && path.branches.is_empty() && path.notes[0].contains("`bob.force` = 100"),
        "{:?}",
        path.notes
    );
    let both = Override::parse("statics.unknown=[\"bob.force\"]").expect("a change");
    let text = format!("[statics.path]\nparameter = \"bob.mass\"\nto = 3\n{scene}");
    let problems = scenario::parse("path.toml", &text, &[both]).expect_err("both");
    assert!(problems.to_string().contains("do not go together"), "{problems}");
}

/// Balance at a limit `a` of the boom: `(F − W_boom/2 − W_sign) l cos a = k a`.
#[test]
fn a_barrier_lifts_off_one_stop_and_comes_to_the_other() {
    let path = path_of(&crate::scenarios::shipped("barrier", &[]).0);
    proven(&path);
    let pull = |angle: f64| 9.80665 * (6.0 + 2.0) + 150.0 * angle / (3.0 * angle.cos());
    let [(0, lift)] = events(&path, EventKind::Lift)[..] else { panic!("one lift: {:?}", path.notes) };
    near(lift.parameter, pull(-0.1), 1e-8);
    near(lift.position[0], -0.1, 1e-12);
    let [(1, stop)] = events(&path, EventKind::Stop)[..] else { panic!("one stop: {:?}", path.notes) };
    near(stop.parameter, pull(1.2), 1e-8);
    near(stop.position[0], 1.2, 1e-10);
    assert_eq!(stop.event.as_ref().expect("it").carriers, ["boom"]);
    let [first, second, third] = &path.branches[..] else { panic!("three branches: {:?}", path.notes) };
    assert_eq!((second.parent.map(|(branch, _)| branch), third.parent.map(|(branch, _)| branch)), (Some(0), Some(1)));
    assert!(matches!(&first.end, BranchEnd::Stop { hinge, limit, lifts: true } if hinge == "`boom`" && *limit == -0.1));
    assert!(matches!(&second.end, BranchEnd::Stop { limit, lifts: false, .. } if *limit == 1.2));
    assert_eq!(third.end, BranchEnd::Range);
    // Along the last branch the boom stays where it is, and the sign hangs.
    for point in &third.points {
        near(point.position[0], 1.2, 1e-12);
        near(point.position[0] + point.position[1], 0.0, 1e-9);
    }
    near(third.points.last().expect("points").parameter, 300.0, 1e-9);
    let [between] = wanted(second).collect::<Vec<_>>()[..] else { panic!("one value that was asked for") };
    near(between.parameter, 100.0, 1e-9);
    near(pull(between.position[0]), 100.0, 1e-7);
}

/// One hinge on its stop leaves nothing to move: the path goes on all the same, and snaps back where it lets go.
#[test]
fn a_path_goes_on_where_stops_leave_nothing_to_move() {
    let bob = "[statics.path]\nparameter = \"bob.force\"\nfrom = 0\nto = 20\n[[body]]\nname = \"bob\"\nmass = 1\n\
               center = [0, 0, -1]\nhinge = { type = \"revolute\", axis = [0, 1, 0], limits = [-0.5, 0.3] }\n";
    let path = followed(bob);
    proven(&path);
    // The sine of the angle times m g l, up to the stop.
    let [(0, stop)] = events(&path, EventKind::Stop)[..] else { panic!("one stop: {:?}", path.notes) };
    near(stop.parameter, 9.80665 * 0.3_f64.sin(), 1e-9);
    assert_eq!((path.branches.len(), path.branches[1].end.clone()), (2, BranchEnd::Range));
    near(path.branches[1].points.last().expect("points").position[0], 0.3, 1e-15);
    // Rubber gives way: m g l sin q + k (q − 0.3) = F on its branch.
    let path = followed(&bob.replace("[-0.5, 0.3]", "{ low = -0.5, high = 0.3, stiffness = 40.0, damping = 1.0 }"));
    proven(&path);
    let last = path.branches[1].points.last().expect("points");
    near(9.80665 * last.position[0].sin() + 40.0 * (last.position[0] - 0.3), 20.0, 1e-9);
}

/// What the stop of one rod bears falls to nothing when the motor of the other carries all weights, through the loop.
#[test]
fn a_path_lifts_a_loop_off_its_stop() {
    let (scenario, _) = crate::scenarios::shipped("parallelogram_on_stop", &[]);
    let keys = "[statics.path]\nparameter = \"left.force\"\nfrom = 0\nto = 10\n[simulate]";
    let path = followed(&scenario.text.replacen("[simulate]", keys, 1));
    proven(&path);
    let lever = (2.0 * 0.25 + 2.0 * 0.5) * 9.80665;
    let [(0, lift)] = events(&path, EventKind::Lift)[..] else { panic!("one lift: {:?}", path.notes) };
    near(lift.parameter, lever * 0.2_f64.sin(), 1e-8);
    let last = path.branches[1].points.last().expect("points");
    near(lever * last.position[0].sin(), 10.0, 1e-8);
    near(last.position[2], last.position[0], 1e-10);
}

/// A coordinate is called as reports call it, too.
#[test]
fn coordinates_have_the_names_of_reports() {
    for name in ["joint.position", "joint.distance"] {
        let (scenario, _) = shipped("snap_through", &[&format!("statics.path.coordinate={name:?}")]);
        let found = scenario.path.as_ref().expect("a path").coordinate.as_ref().expect("a coordinate");
        assert_eq!(found.address, "joint.position");
    }
}
