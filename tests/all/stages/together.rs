//! Events at one instant: each of them comes.

use super::{given, settings, stage};
use crate::common::{Random, build};
use stillpoint::integrate::Method;
use stillpoint::model::description::{
    BodyDescription, Description, Direction, EventDescription, HingeDescription, WatchedDescription, When,
};
use stillpoint::record::Fanout;
use stillpoint::simulate::events::Kind;
use stillpoint::simulate::{self, Integrator, Settings, at_stage};

/// How far bodies may be apart that fall together (m): within the rounding of where they are, and of when they are found there.
const APART: [f64; 9] = [0.0, 1e-16, -1e-16, 1e-15, -1e-15, 1e-14, -1e-14, 1e-13, -1e-13];

fn event(body: &str, stops: bool) -> EventDescription {
    let of = WatchedDescription::Hinge { body: body.to_owned(), coordinate: 0 };
    EventDescription { name: format!("{body} is down"), of, value: 0.0, direction: Direction::Both, stops }
}

/// Bodies that fall from 5 m, but for what they are apart, each held by a stage where it is down.
fn falling(apart: &[f64]) -> Description {
    let mut scene = Description::new("falling").gravity([0.0, 0.0, -10.0]);
    for (k, apart) in apart.iter().enumerate() {
        let name = format!("b{k}");
        let hinge = HingeDescription::prismatic([0.0, 0.0, 1.0]).position([5.0 + apart]);
        scene = scene.body(BodyDescription::new(&name, hinge).mass(1.0 + k as f64));
        scene.events.push(event(&name, false));
        let mut hold = stage(0.0);
        hold.name = format!("hold {name}");
        hold.when = When::Event(format!("{name} is down"));
        hold.lock.push(name);
        scene.stages.push(hold);
    }
    scene
}

/// Two or three bodies that fall together come to rest where they are down, whatever the method: none of the events is lost.
#[test]
fn stages_at_one_instant_all_come() {
    let methods = [Method::Dop853, Method::Dopri5, Method::Rk4, Method::Radau5];
    for (case, first) in APART.iter().enumerate() {
        for second in APART {
            let mut random = Random::new(case as u64);
            let apart = [*first, second, 0.0];
            let model = build(&falling(&apart[..2 + random.below(2)]));
            for method in methods {
                let step = (method == Method::Rk4).then_some(1e-3);
                let settings = Settings { integrator: Integrator::Method(method), step, ..settings(2.0) };
                let found = simulate::run(&model, &settings, 1.0, &given(&model), &mut Fanout::new(), &mut |_, _| true)
                    .unwrap_or_else(|error| panic!("{apart:?}, {method:?}: {error}"));
                assert!(found.pending.is_empty(), "{apart:?}, {method:?}: {:?}", found.events);
                // Within 1e-12 s at 10 m/s, where they are held.
                let off = found.state.position.iter().map(|z| z.abs()).fold(0.0, f64::max);
                assert!(off < 1e-9, "{apart:?}, {method:?}: {off}");
                let lost: f64 = (0..model.bodies.len()).map(|k| 50.0 * (1.0 + k as f64)).sum();
                assert!((found.dissipated - lost).abs() < 1e-8 * lost, "{apart:?}, {method:?}: {}", found.dissipated);
                let crossings = found.events.iter().filter(|one| one.kind == Kind::Crossing).count();
                assert_eq!(crossings, model.bodies.len(), "{apart:?}, {method:?}: {:?}", found.events);
            }
        }
    }
}

/// An event that ends the run does so, and the stage at its instant comes before that.
#[test]
fn a_run_ends_at_the_instant_of_a_stage() {
    for apart in APART {
        let mut scene = falling(&[0.0, apart]);
        scene.stages.truncate(1);
        scene.events[1].stops = true;
        let model = build(&scene);
        let found = super::ran(&model, &given(&model), 2.0);
        assert_eq!(found.stopped_by.as_deref(), Some("b1 is down"), "{apart}: {:?}", found.events);
        assert!(found.pending.is_empty() && (found.end_time - 1.0).abs() < 1e-11, "{apart}: {:?}", found.events);
        assert!((found.dissipated - 50.0).abs() < 1e-7, "{apart}: {}", found.dissipated);
        assert!((found.state.velocity[1] + 10.0).abs() < 1e-9, "{apart}: {:?}", found.state.velocity);
    }
}

/// A stage locks its hinge where the scene is when it comes: at the value of the event that it waits for, or where a run begins.
#[test]
fn a_stage_locks_where_it_comes() {
    let mut scene = falling(&[0.25, -0.5]);
    scene.stages[1].when = When::Time(0.3);
    let (left, said) = at_stage(&scene, "hold b1", None).unwrap();
    let held = |left: &Description| {
        let model = build(left);
        left.drives
            .iter()
            .map(|drive| model.drives.iter().find(|one| one.name == drive.name).unwrap().motion.at(0.0).position)
            .collect::<Vec<f64>>()
    };
    assert_eq!(held(&left), [0.0, 4.5], "{said:?}");
    assert_eq!(said, ["stage `hold b0` locks `b0` at 0", "stage `hold b1` locks `b1` at 4.5"]);
    let (left, _) = at_stage(&scene, "hold b1", Some(&[1.0, 2.0])).unwrap();
    assert_eq!(held(&left), [0.0, 2.0]);
}

/// An event that is crossed a few digits before a stage comes at a time, or before the run ends, comes, and its stage with it.
#[test]
fn an_event_just_before_an_instant_comes() {
    for digits in 0..8 {
        for start in [0.0, 0.3, 1.7] {
            // At 1 m/s without gravity.
            let crossed = 0.4_f64;
            let mut after = crossed;
            (0..digits).for_each(|_| after = after.next_up());
            for ends in [false, true] {
                let mut scene = Description::new("sliding").gravity([0.0; 3]);
                for name in ["s", "r", "other"] {
                    let hinge = HingeDescription::prismatic([1.0, 0.0, 0.0]).position([start]).velocity([1.0]);
                    scene = scene.body(BodyDescription::new(name, hinge).mass(2.0).inertia([0.1; 3]));
                }
                let of = WatchedDescription::Hinge { body: "s".to_owned(), coordinate: 0 };
                let value = start + crossed;
                scene.events.push(EventDescription {
                    name: "e".to_owned(),
                    of,
                    value,
                    direction: Direction::Up,
                    stops: false,
                });
                let mut hold = stage(0.0);
                (hold.name, hold.when) = ("by event".to_owned(), When::Event("e".to_owned()));
                hold.lock.push("r".to_owned());
                scene.stages.push(hold);
                if !ends {
                    let mut open = stage(after);
                    open.name = "by time".to_owned();
                    open.open.push("other".to_owned());
                    scene.stages.push(open);
                }
                let model = build(&scene);
                let found = super::ran(&model, &given(&model), if ends { after } else { 1.0 });
                let crossings = found.events.iter().filter(|one| one.kind == Kind::Crossing).count();
                let what = format!("{digits} digits, from {start}, {ends}: {:?}", found.events);
                assert!(found.pending.is_empty() && crossings == 1, "{what}");
                assert!(found.state.velocity[1].abs() < 1e-12, "{what}");
            }
        }
    }
}

/// Both cranks of a parallelogram are locked while it swings: the second lock holds nothing that the first does not, and contradicts nothing. All
/// motion is lost, and it stays where it was caught; beside a crank that is driven on a lock has nothing to hold.
#[test]
fn locks_that_repeat_each_other_hold_together() {
    let scene = |crank: &str, lock: &str| {
        format!(
            "[[body]]\nname = \"crank\"\nmass = 1.0\ncenter = [0, 0, -0.1]\ninertia = [0.004, 0.004, 0.001]\nmarkers = {{ pin = [0, 0, -0.2] }}\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], position = 0.5 }}\n\
             [[body]]\nname = \"coupler\"\nmass = 0.6\ncenter = [0.15, 0, 0]\ninertia = [0.001, 0.006, 0.006]\nmarkers = {{ pin = [0.3, 0, 0] }}\n\
             hinge = {{ type = \"revolute\", parent = \"crank\", at = \"pin\", axis = [0, 1, 0], position = -0.5 }}\n\
             [[body]]\nname = \"rocker\"\nmass = 0.5\ncenter = [0, 0, -0.1]\ninertia = [0.004, 0.004, 0.0001]\nmarkers = {{ pin = [0, 0, -0.2] }}\n\
             hinge = {{ type = \"revolute\", at = [0.3, 0, 0], axis = [0, 1, 0], position = 0.5 }}\n\
             [[loop]]\ntype = \"revolute\"\nbetween = [\"coupler.pin\", \"rocker.pin\"]\naxis = [0, 1, 0]\n{crank}\
             [[stage]]\nname = \"hold\"\nwhen = {{ time = 0.3 }}\nlock = {lock}\n"
        )
    };
    let run = |text: &str, duration: f64| {
        let scenario =
            stillpoint::scenario::parse("cranks.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
        let (model, _) = stillpoint::constraint::assemble(build(&scenario.description)).expect("a parallelogram");
        simulate::run(&model, &settings(duration), 1.0, &given(&model), &mut Fanout::new(), &mut |_, _| true)
    };
    let both = scene("", "[\"crank\", \"rocker\"]");
    let (caught, later) = (run(&both, 0.3).expect("a run"), run(&both, 1.0).expect("a run"));
    assert!(later.state.velocity.iter().all(|v| v.abs() < 1e-12), "{:?}", later.state);
    for (at, was) in later.state.position.iter().zip(&caught.state.position) {
        assert!((at - was).abs() < 1e-12, "{:?} {:?}", later.state, caught.state);
    }
    let one = run(&scene("", "[\"crank\"]"), 1.0).expect("a run");
    assert!(
        one.dissipated > 0.1 && (later.dissipated - one.dissipated).abs() < 1e-9,
        "{} {}",
        later.dissipated,
        one.dissipated
    );
    let driven = scene("[[drive]]\nhinge = \"crank\"\ntype = \"rate\"\nrate = 1.0\n", "[\"rocker\"]");
    let refused = run(&driven, 1.0).map(|_| ()).expect_err("a lock against a drive").to_string();
    assert!(refused.contains("has nothing left to move"), "{refused}");
}
