//! Dry friction of hinges and compliant stops beside contact: by events where nothing of their tree touches, in captured steps where it does.

use crate::common::{Random, build};
use crate::contact_in_motion::{FLOOR, go, read};
use stillpoint::integrate::Method;
use stillpoint::record::Fanout;
use stillpoint::scenario::parse;
use stillpoint::simulate::events::Kind;
use stillpoint::simulate::verify::verify;
use stillpoint::simulate::{Settings, State, Summary, run};

/// A slider whose foot glides along the floor without friction: captured steps follow its hinge's dry friction.
fn glides(hinge: &str) -> String {
    format!(
        "{FLOOR}[[body]]\nname = \"slider\"\nmass = 0.9\ninertia = [0.01, 0.01, 0.01]\n\
         hinge = {{ type = \"prismatic\", axis = [1, 0, 0], at = [0, 0, 0.5], {hinge} }}\n\
         [[body]]\nname = \"foot\"\nmass = 0.1\ninertia = [0.01, 0.01, 0.01]\nshape = {{ sphere = 0.05 }}\n\
         hinge = {{ type = \"prismatic\", parent = \"slider\", axis = [0, 0, 1], position = -0.45, friction = 1e-9 }}\n\
         [[contact]]\nbetween = [\"floor\", \"foot\"]\nfriction = 0.0\n"
    )
}

/// The same slider with its foot above the floor.
fn flies(hinge: &str) -> String {
    glides(hinge).replace(
        "type = \"prismatic\", parent = \"slider\", axis = [0, 0, 1], position = -0.45, friction = 1e-9",
        "type = \"fixed\", parent = \"slider\"",
    )
}

fn at(summary: &Summary) -> [f64; 2] {
    [summary.state.position[0], summary.state.velocity[0]]
}

/// 1 kg that a force F turns back against dry friction f < F: it stops after v / (F + f), and goes back with F − f.
#[test]
fn what_turns_back_against_its_friction_comes_as_far_as_it_should() {
    let mut random = Random::new(0x7a2);
    for case in 0..12 {
        let (speed, friction) = (random.between(0.5, 2.0), random.between(0.1, 1.0));
        let (pull, duration) = (friction * random.between(1.2, 5.0), 3.0);
        let hinge = format!("velocity = {speed:?}, force = {:?}, friction = {friction:?}", -pull);
        let turn = speed / (pull + friction);
        let expected = match turn < duration {
            true => speed * turn / 2.0 - 0.5 * (pull - friction) * (duration - turn).powi(2),
            false => speed * duration - 0.5 * (pull + friction) * duration * duration,
        };
        let scale = speed * turn.min(duration) + 0.5 * (pull - friction) * duration * duration;
        let exact = go(&read(&flies(&hinge)), duration, 1e-8, Method::Dop853);
        assert_eq!(exact.capture_steps, 0, "case {case}: {hinge}");
        assert!((at(&exact)[0] - expected).abs() < 1e-9 * scale, "case {case}: {:?} {expected} {hinge}", at(&exact));
        // Steps of order 1 keep half the digits of the tolerance: at a turn velocities, in parts of the scene's speed, and it is seconds ago.
        for (tolerance, allowed) in [(1e-6, 2e-2), (1e-8, 2e-3)] {
            let captured = go(&read(&glides(&hinge)), duration, tolerance, Method::Dop853);
            assert!(captured.capture_steps > 0, "case {case}: {hinge}");
            let off = (at(&captured)[0] - expected).abs();
            assert!(off < allowed * scale, "case {case}: off by {off} of {scale} at {tolerance}: {hinge}");
        }
    }
}

/// 1 kg on a spring slides with friction f to its turn, where it stays if the spring pulls with less than its friction at rest, and slides
/// back if with more.
#[test]
fn what_turns_rests_if_its_friction_at_rest_holds_it() {
    let mut random = Random::new(0x5e1);
    let (mut rests, mut goes_on) = (0, 0);
    for case in 0..40 {
        let (stiffness, slide, far) =
            (random.between(50.0, 200.0), random.between(1.0, 4.0), random.between(0.05, 0.3));
        let stick = slide * random.between(1.2, 3.0);
        let mut expected = far;
        if stiffness * far <= 1.05 * stick {
            continue;
        }
        // From turn to turn about ± f / k, until the spring is held.
        let mut near_limit = false;
        while stiffness * expected.abs() > stick {
            expected = -expected + expected.signum() * 2.0 * slide / stiffness;
            near_limit |= (stiffness * expected.abs() / stick - 1.0).abs() < 0.05;
        }
        if near_limit {
            continue;
        }
        let hinge = format!(
            "position = {far:?}, stiffness = {stiffness:?}, friction = {{ stick = {stick:?}, slide = {slide:?} }}"
        );
        let half = std::f64::consts::PI / stiffness.sqrt();
        let turns = ((far - expected.abs()) / (2.0 * slide / stiffness)).round();
        let duration = half * (turns + 2.0);
        // Ten times the tolerance, and half its digits in parts of the scene's speed for some swings.
        for (text, allowed) in [(flies(&hinge), 1e-7), (glides(&hinge), 2e-3)] {
            let summary = go(&read(&text), duration, 1e-8, Method::Dop853);
            let off = (at(&summary)[0] - expected).abs();
            assert!(off < allowed * far, "case {case}: {:?} {expected}\n{text}", at(&summary));
        }
        if turns > 1.0 { goes_on += 1 } else { rests += 1 }
    }
    assert!(rests > 3 && goes_on > 10, "{rests} {goes_on}");
}

/// A slider that runs into a damped compliant stop and bounces back: captured steps come to what events do, and book what its damper takes.
#[test]
fn compliant_stops_push_in_captured_steps_as_they_do_between_events() {
    let mut random = Random::new(0xc51);
    for case in 0..12 {
        let (speed, stiffness) = (random.between(1.0, 3.0), random.between(200.0, 2000.0));
        let damping = if case % 3 == 0 { 0.0 } else { random.between(1.0, 20.0) };
        let hinge = format!(
            "velocity = {speed:?}, limits = [{{ high = 0.5, stiffness = {stiffness:?}, damping = {damping:?} }}]"
        );
        let duration = 1.5 / speed;
        let exact = go(&read(&flies(&hinge)), duration, 1e-10, Method::Dop853);
        let captured = go(&read(&glides(&hinge)), duration, 1e-8, Method::Dop853);
        assert!(captured.capture_steps > 0 && exact.capture_steps == 0, "case {case}");
        let ([q, v], [x, u]) = (at(&exact), at(&captured));
        // Half the digits of the tolerance, in parts of the scene's speed and length, for what the spring makes of it.
        assert!((q - x).abs() < 1e-3 && (v - u).abs() < 1e-3 * speed, "case {case}: {q} {v}, {x} {u}: {hinge}");
        let energy = 0.5 * speed * speed;
        let taken = [exact.dissipated, captured.dissipated];
        assert!((taken[0] - taken[1]).abs() < 2e-3 * energy, "case {case}: {taken:?} of {energy} J: {hinge}");
    }
}

/// A compliant stop that is touched in the first captured step is told, as it is by events: what is foreseen of forces there does not touch it.
#[test]
fn a_stop_that_is_touched_at_once_is_told() {
    for gap in [1e-9, 1e-7, 1e-6, 1e-5] {
        let hinge = format!("velocity = 1.0, limits = [{{ high = {gap:?}, stiffness = 500.0 }}]");
        for scene in [flies(&hinge), glides(&hinge)] {
            let found = go(&read(&scene), 0.05, 1e-8, Method::Dop853);
            let told = found.events.iter().filter(|one| one.kind == Kind::Contact).count();
            assert_eq!(told, 1, "{gap}, {} captured steps: {:?}", found.capture_steps, found.events);
        }
    }
}

/// A block that slides without friction on a floor carries a pendulum whose hinge rubs: nothing strikes, and captured steps have order 2 there. The horizontal
/// momentum stays zero; x and q are those of Lagrange's equations (two coordinates, by DOP853 of SciPy at 1e-12 with the turns as events). What `verify`
/// says of the error is about as large as it is.
#[test]
fn captured_steps_follow_what_presses_on_them_and_their_error_is_told() {
    let text = format!(
        "[simulate]\nstart = \"given\"\nduration = 2.0\n{FLOOR}[[body]]\nname = \"block\"\nmass = 2.0\ninertia = [0.1, 0.1, 0.1]\nshape = {{ box = [1.0, 1.0, \
         0.2] }}\nhinge = {{ type = \"free\", position = [0, 0, 0.1, 1, 0, 0, 0] }}\n[[body]]\nname = \"bob\"\nmass = 1.0\ncenter = [0, 0, \
         -0.5]\ninertia = [0.02, 0.02, 0.02]\nhinge = {{ type = \"revolute\", parent = \"block\", at = [0, 0, 0.1], axis = [0, 1, 0], position = 1.2, \
         friction = 0.3 }}\n[[contact]]\nbetween = [\"floor\", \"block\"]\nfriction = 0.0\n"
    );
    let scenario = parse("block.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    let model = build(&scenario.description);
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let expected = [-0.25652669, -0.65243246, -0.25197789, -1.90265487];
    let mut last = f64::INFINITY;
    for (tolerance, allowed) in [(1e-4, 2e-2), (1e-7, 1e-3), (1e-10, 1e-4)] {
        let settings = Settings { tolerance, absolute_tolerance: tolerance, ..scenario.simulate.clone() };
        let summary = run(&model, &settings, 1.0, &start, &mut Fanout::new(), &mut |_, _| true).unwrap();
        assert!(summary.capture_steps > 0);
        let (q, v) = (&summary.state.position, &summary.state.velocity);
        let found = [q[0], q[7], v[0], v[6]];
        let off = found.iter().zip(expected).map(|(found, expected)| (found - expected).abs()).fold(0.0, f64::max);
        assert!(off < allowed && off < last, "{tolerance:e}: {found:?} off by {off}");
        let momentum = 3.0 * v[0] - 0.5 * q[7].cos() * v[6];
        assert!(momentum.abs() < allowed, "{tolerance:e}: {momentum}");
        let verified = verify(&model, &settings, &start, &summary, &mut |_| true).unwrap().unwrap();
        let told = verified.length.max(verified.angle).max(verified.speed).max(verified.rate);
        assert!(verified.captured && told > 0.5 * off && told < 2.0 * off, "{tolerance:e}: {told} told of {off}");
        last = off;
    }
}
