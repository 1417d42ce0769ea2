//! Ropes and curves: in random scenes against their laws, and in scenes with answers in closed form.

use crate::accelerations::compare;
use crate::common::{Options, Random, build, random_scene, relative_difference};
use crate::derivatives::difference;
use faer::linalg::solvers::Solve;
use stillpoint::dynamics::{Coefficients, Fault, System, TangentSolver};
use stillpoint::model::Model;
use stillpoint::model::description::*;
use stillpoint::motion::Motion;
use stillpoint::record::{Memory, Opening};
use stillpoint::simulate::events::Kind;
use stillpoint::simulate::{State, Summary, run};

/// Random trees with ropes through two to six points and curves, some of each slack or flat; without springs, bushings and
/// loads where `alone`.
fn scenes(alone: bool) -> impl Iterator<Item = (u64, Description)> {
    (0..80).map(move |seed| {
        let options = Options { bodies: 1 + (seed as usize * 7) % 13, springs: !alone && seed % 3 != 0, welds: true };
        let mut description = random_scene(seed, &options);
        let mut random = Random::new(seed + 700);
        for index in 0..3 {
            let rope = rope(&mut random, &description.bodies);
            description.forces.push(ForceDescription { name: format!("rope{index}"), kind: rope });
            let curve = curve(&mut random, &description.bodies);
            description.forces.push(ForceDescription { name: format!("curve{index}"), kind: curve });
        }
        in_hinges(&mut random, &mut description);
        (seed, description)
    })
}

fn point(random: &mut Random, bodies: &[BodyDescription]) -> Attachment {
    let body = match random.below(bodies.len() + 1) {
        0 => GROUND.to_owned(),
        other => bodies[other - 1].name.clone(),
    };
    Attachment { body, point: Point::At(random.vector(0.6)) }
}

fn rope(random: &mut Random, bodies: &[BodyDescription]) -> ForceKind {
    let mut through: Vec<Attachment> = (0..2 + random.below(5)).map(|_| point(random, bodies)).collect();
    // On one body it would do nothing.
    through[0].body = GROUND.to_owned();
    through[1].body.clone_from(&bodies[random.below(bodies.len())].name);
    let (stiffness, damping) = (random.between(1.0, 50.0), random.between(0.0, 1.0));
    Rope { through, stiffness, length: random.between(0.1, 3.0), damping }.into()
}

fn curve(random: &mut Random, bodies: &[BodyDescription]) -> ForceKind {
    let mut between = [point(random, bodies), point(random, bodies)];
    between[0].body = GROUND.to_owned();
    between[1].body.clone_from(&bodies[random.below(bodies.len())].name);
    let mut table = |from: f64| {
        let mut x = from;
        let next = |_| {
            x += random.between(0.2, 1.0);
            [x, random.between(-5.0, 5.0)]
        };
        (0..4).map(next).collect::<Vec<_>>()
    };
    let (extension, rate) = (table(-1.0), table(-2.0));
    let rate = if random.below(2) == 0 { rate } else { Vec::new() };
    let interpolation = if random.below(2) == 0 { Interpolation::Smooth } else { Interpolation::Linear };
    Curve { between, extension, rate, interpolation, length: random.between(0.0, 1.0) }.into()
}

/// A spring and a damper by smooth tables in every first plain coordinate.
fn in_hinges(random: &mut Random, description: &mut Description) {
    for body in &mut description.bodies {
        if body.hinge.kind.plain_coordinates() == 0 || random.below(2) == 0 {
            continue;
        }
        for over in [CurveOver::Position, CurveOver::Velocity] {
            let points = vec![[-1.0, -random.between(0.5, 4.0)], [0.1, 0.3], [1.5, random.between(0.5, 4.0)]];
            let interpolation = Interpolation::Smooth;
            body.hinge.curves.push(HingeCurveDescription { coordinate: 0, over, points, interpolation });
        }
    }
}

fn without_hinge_curves(mut description: Description) -> Description {
    description.bodies.iter_mut().for_each(|body| body.hinge.curves.clear());
    description
}

fn slack(model: &Model, motion: &Motion) -> usize {
    use stillpoint::force::Act;
    let slack = |index: &usize| model.forces[*index].law.switch(0, &motion.links).value <= 0.0;
    model.switching().filter(slack).count()
}

/// Accelerations and reactions against the equations of every single body, with the laws written down a second time.
#[test]
fn ropes_and_curves_pull_by_their_laws() {
    for (seed, description) in scenes(false) {
        let mut description = without_hinge_curves(description);
        // The second writing knows straight tables.
        for force in &mut description.forces {
            if let ForceKind::Curve(Curve { interpolation, .. }) = &mut force.kind {
                *interpolation = Interpolation::Linear;
            }
        }
        let found = compare(&description);
        let worst = found.acceleration.max(found.reaction);
        assert!(worst < 1e-12, "seed {seed}: {:.1e}, {:.1e}", found.acceleration, found.reaction);
    }
}

/// At rest the force is minus the slope of the potential: differences of step 1e-5 err by 1e-9 of the largest.
#[test]
fn potentials_are_integrals_of_the_forces() {
    let (mut ropes, mut loose) = (0, 0);
    for (seed, mut description) in scenes(true) {
        for body in &mut description.bodies {
            body.hinge.force.clear();
        }
        let model = build(&description);
        assert!(model.is_conservative());
        let n = model.velocity_count();
        let (q, rest) = (&model.start_position, vec![0.0; n]);
        let mut system = System::new(&model);
        let mut residual = rest.clone();
        let mut at = system.at(0.0, q, &rest);
        at.residual(&rest, &mut residual).unwrap();
        ropes += model.switching().count();
        loose += slack(&model, at.motion());
        let slopes: Vec<f64> = (0..n)
            .map(|j| difference(&model, true, j, |q, _| vec![system.at(0.0, q, &rest).energies().potential])[0])
            .collect();
        let error = relative_difference(&residual, &slopes);
        assert!(error < 1e-6, "seed {seed}: {error:e}");
    }
    assert!(loose > 20 && ropes - loose > 20, "{loose} of {ropes} ropes are slack");
}

/// Stiffness and damping matrices against central differences, as for springs and bushings.
#[test]
fn derivatives_match_central_differences() {
    for (seed, description) in scenes(false) {
        let model = build(&description);
        let n = model.velocity_count();
        let a = Random::new(seed + 1000).list(n, -3.0, 3.0);
        let mut system = System::new(&model);
        let (q, v) = (&model.start_position, &model.start_velocity);
        let found = system.at(0.0, q, v).linearize(&a).unwrap();
        let scale = found.stiffness.norm_max().max(found.damping.norm_max());
        for j in 0..n {
            for (of_position, matrix) in [(true, &found.stiffness), (false, &found.damping)] {
                let expected = difference(&model, of_position, j, |q, v| {
                    let mut residual = vec![0.0; n];
                    system.at(0.0, q, v).residual(&a, &mut residual).unwrap();
                    residual
                });
                for i in 0..n {
                    let error = (matrix[(i, j)] - expected[i]).abs() / scale;
                    assert!(error < 1e-6, "seed {seed} ({i}, {j}) position {of_position}: {error}");
                }
            }
        }
    }
}

/// The sweep with its border of elements of up to six links solves with the dense matrix, and counts its negative
/// eigenvalues.
#[test]
fn tangent_sweep_couples_all_points_of_a_rope() {
    let mut far = 0;
    for (seed, description) in scenes(false) {
        let model = build(&description);
        let n = model.velocity_count();
        far += usize::from(TangentSolver::further_sides(&model) > 2 * 6);
        let mut random = Random::new(seed + 2000);
        let (a, rhs) = (random.list(n, -3.0, 3.0), random.list(n, -1.0, 1.0));
        let (mut system, mut solver) = (System::new(&model), TangentSolver::new(&model));
        let zero = vec![0.0; n];
        let (q, v) = (&model.start_position, &model.start_velocity);
        for (v, a, c1, c2, shift) in [(&zero, &zero, 0.0, 7.0, 0.0), (v, &a, 20.0, 400.0, 0.0), (v, &a, 0.0, 0.0, 9.0)]
        {
            let dense = system.at(0.0, q, v).linearize(a).unwrap();
            let mut matrix = &dense.stiffness + &dense.damping * c1 + &dense.mass * c2;
            (0..n).for_each(|i| matrix[(i, i)] += shift);
            let b = faer::Mat::from_fn(n, 1, |i, _| rhs[i]);
            let solution = matrix.partial_piv_lu().solve(&b);
            let expected: Vec<f64> = (0..n).map(|i| solution[(i, 0)]).collect();
            let shift = vec![shift; n];
            let with = Coefficients { c1, c2, shift: &shift, ..Coefficients::default() };
            assert!(system.at(0.0, q, v).factorize_tangent(&mut solver, a, &with).unwrap(), "seed {seed}");
            let mut x = rhs.clone();
            solver.solve(&mut x);
            let error = relative_difference(&x, &expected);
            // Elimination without pivoting in an indefinite matrix of up to some sixty rows loses digits.
            assert!(error < 1e-6, "seed {seed} c1 {c1} c2 {c2}: {error}");
        }
    }
    assert!(far > 20, "only {far} scenes with ropes over three links and more");
}

#[test]
fn negative_eigenvalues_are_counted_with_ropes() {
    for (seed, mut description) in scenes(true) {
        description.bodies.iter_mut().for_each(|body| body.hinge.force.clear());
        let model = build(&description);
        let n = model.velocity_count();
        let (q, zero) = (&model.start_position, vec![0.0; n]);
        let (mut system, mut solver) = (System::new(&model), TangentSolver::new(&model));
        let full = system.at(0.0, q, &zero).stiffness().unwrap();
        let shift = Random::new(seed + 3000).list(n, -10.0, 10.0);
        let symmetric =
            faer::Mat::from_fn(n, n, |i, j| 0.5 * (full[(i, j)] + full[(j, i)]) + if i == j { shift[i] } else { 0.0 });
        let values = symmetric.self_adjoint_eigenvalues(faer::Side::Lower).unwrap();
        let negative = values.iter().filter(|x| **x < 0.0).count();
        let with = Coefficients { shift: &shift, symmetric: true, ..Coefficients::default() };
        assert!(system.at(0.0, q, &zero).factorize_tangent(&mut solver, &zero, &with).unwrap());
        assert_eq!(solver.negatives(), Some(negative), "seed {seed}");
    }
}

/// Two points of a rope, one after the other, in the same place: the element is named, slack or not.
#[test]
fn a_segment_without_length_is_named() {
    for length in [0.5, 50.0] {
        let slide = HingeDescription::prismatic([0.0, 0.0, 1.0]);
        let bead = BodyDescription::new("bead", slide).mass(1.0);
        let through: Vec<Attachment> =
            vec![(GROUND, [1.0, 0.0, 0.0]).into(), (GROUND, [0.0; 3]).into(), ("bead", [0.0; 3]).into()];
        let scene = Description::new("").body(bead).force(ForceDescription::rope("line", through, 10.0, length, 0.0));
        let model = build(&scene);
        let fault = System::new(&model).at(0.0, &[0.0], &[0.0]).accelerations(&mut [0.0]).unwrap_err();
        let Fault::OnePlace { what, element } = fault else { panic!("{fault:?}") };
        assert_eq!(element, "line");
        assert!(what.contains("points"), "{what}");
    }
}

fn said(text: &str) -> String {
    match stillpoint::scenario::parse("scene.toml", text, &[]) {
        Ok(scenario) => {
            Model::build(&scenario.description).map_or_else(|found| format!("{found:?}"), |_| String::new())
        }
        Err(diagnostics) => diagnostics.to_string(),
    }
}

const BOB: &str = "[[body]]\nname = \"bob\"\nmass = 1.0\nhinge = { type = \"prismatic\", axis = [0, 0, 1] }\n";

/// Every bad rope, curve and limit is refused with its line, and the caret on what is bad.
#[test]
fn bad_ropes_curves_and_limits_are_shown_where_they_are() {
    let rope = |through: &str, length: &str| {
        format!(
            "{BOB}[[force]]\nname = \"line\"\ntype = \"rope\"\nthrough = {through}\nstiffness = 10.0\nlength = {length}\n"
        )
    };
    let curve = |force: &str| {
        format!(
            "{BOB}[[force]]\nname = \"line\"\ntype = \"curve\"\nbetween = [\"ground\", \"bob\"]\nlength = 1.0\nforce = {force}\n"
        )
    };
    let limits = |list: &str| BOB.replace("axis", &format!("limits = {list}, axis"));
    let spring = |points: &str| BOB.replace("axis", &format!("spring = {{ curve = {points} }}, axis"));
    let two = "[\"ground\", \"bob\"]";
    for (text, message, place) in [
        (rope("[\"bob\"]", "1.0"), "goes through 1 point", "8:11"),
        (rope("[\"bob\", \"bob\", \"ground\"]", "1.0"), "the same point twice in a row", "8:19"),
        (rope("[\"bob\", { body = \"bob\", at = [0, 0, 1] }]", "1.0"), "all points of `line` are on `bob`", "8:11"),
        (rope(two, "0.0"), "allowed: > 0 m", "10:10"),
        (rope(two, "-1.0"), "allowed: > 0 m", "10:10"),
        (rope("[\"ground\", \"bod\"]", "1.0"), "there is no body `bod`", "8:22"),
        (rope("[\"ground\", 3.0]", "1.0"), "through[1]", "8:22"),
        (curve("[[0.0, 0.0]]"), "has only one point", "10:9"),
        (curve("[[0.0, 0.0], [1.0, 1.0], [0.5, 2.0]]"), "has 0.5 after 1", "10:34"),
        (curve("{ rate = [[0.0, 0.0], [0.0, 2.0]] }"), "has 0 after 0", "10:31"),
        (curve("[[0.0, nan], [1.0, 1.0]]"), "not a finite number", "10:16"),
        (curve("{ }"), "neither `extension` nor `rate`", "10:9"),
        (spring("[[0.0, 0.0], [-1.0, 1.0]]"), "has -1 after 0", "4:63"),
        (limits("[{ low = 0.0 }, { low = 1.0 }]"), "second rigid stop on its low side", "4:56"),
        (limits("[{ low = 1.0 }, { high = 0.5 }]"), "its low rigid stop at 1 and its high one at 0.5", "4:56"),
    ] {
        let found = said(&text);
        assert!(found.contains(message) && found.contains(&format!("scene.toml:{place}")), "{text}\n{found}");
    }
    for text in [
        limits("[{ low = 0.0 }, { low = -1.0, stiffness = 10.0 }, { low = -0.5, stiffness = 10.0 }, { high = 1.0 }]"),
        limits("[[-1.0, 1.0]]"),
        limits("[-1.0, 1.0]"),
    ] {
        assert_eq!(said(&text), "", "{text}");
    }
}

/// Two pads below a hammer, one above the other: each gives way by its own law.
#[test]
fn compliant_limits_add_where_they_overlap() {
    use stillpoint::statics::{Settings, equilibrium};
    let text = BOB.replace(
        "axis",
        "limits = [{ low = 0.0, stiffness = 100.0 }, { low = -0.02, stiffness = 300.0 }, { high = 1.0 }], axis",
    );
    let scenario = stillpoint::scenario::parse("scene.toml", &text, &[]).expect("a scene");
    let model = build(&scenario.description);
    let found = equilibrium(&model, &Settings::default(), &[0.1]).expect("statics");
    assert!(found.converged, "{:?}", found.notes);
    // 100 d + 300 (d − 0.02) = m g
    let depth = (9.80665 + 6.0) / 400.0;
    assert!((found.position[0] + depth).abs() < 1e-9, "{}", found.position[0]);
}

/// Pads on either side, some rigid, in one table or in several, of a slide on a spring under a force: it rests where force, spring and pads
/// balance.
#[test]
fn a_coordinate_rests_on_any_of_its_tables() {
    use stillpoint::statics::{Settings, equilibrium};
    let mut random = Random::new(77);
    for case in 0..200 {
        let (spring, force) =
            (if case % 3 == 0 { 0.0 } else { random.between(1.0, 50.0) }, random.between(-40.0, 40.0));
        let pads: Vec<(f64, f64, bool)> = (0..1 + random.below(4))
            .map(|_| {
                let is_high = random.below(2) == 0;
                let at = random.between(0.05, 0.5) * if is_high { 1.0 } else { -1.0 };
                (at, if random.below(4) == 0 { f64::INFINITY } else { random.between(100.0, 2000.0) }, is_high)
            })
            .collect();
        // Of two rigid ones on a side only one is met, and a table may have only one.
        let rigid = |high: bool| pads.iter().filter(|(_, k, side)| k.is_infinite() && *side == high).count();
        let ends = |high: bool| pads.iter().any(|(.., side)| *side == high);
        if rigid(true) > 1 || rigid(false) > 1 || spring == 0.0 && !ends(force > 0.0) {
            continue;
        }
        let table = |(at, stiffness, is_high): &(f64, f64, bool)| {
            let side = if *is_high { "high" } else { "low" };
            let law = if stiffness.is_finite() { format!(", stiffness = {stiffness}") } else { String::new() };
            format!("{{ {side} = {at}{law} }}")
        };
        let tables: Vec<String> = pads.iter().map(table).collect();
        let text = BOB
            .replace("axis", &format!("stiffness = {spring}, force = {force}, limits = [{}], axis", tables.join(", ")));
        let text = format!("gravity = [0, 0, 0]\n{text}");
        let scenario = stillpoint::scenario::parse("scene.toml", &text, &[]).unwrap_or_else(|why| panic!("{why}"));
        let model = build(&scenario.description);
        let found = equilibrium(&model, &Settings::default(), &[0.0])
            .unwrap_or_else(|why| panic!("case {case}: {why}\n{text}"));
        assert!(found.converged, "case {case}: {:?}\n{text}", found.notes);
        let pull = |x: f64| {
            let pad = |(at, k, is_high): &(f64, f64, bool)| {
                let depth = if *is_high { (x - at).max(0.0) } else { (x - at).min(0.0) };
                if k.is_infinite() { 1e12 * depth } else { k * depth }
            };
            force - spring * x - pads.iter().map(pad).sum::<f64>()
        };
        let (mut low, mut high) = (-1e3, 1e3);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if pull(middle) > 0.0 { low = middle } else { high = middle }
        }
        assert!((found.position[0] - low).abs() < 1e-8, "case {case}: {} {low}\n{text}", found.position[0]);
    }
}

/// A stone on a slack rope falls freely, stops at the end of half an oscillation, and comes up again: events and their
/// times in closed form, with several integrators.
#[test]
fn a_falling_stone_makes_its_rope_taut_and_slack_at_the_times_of_the_closed_form() {
    let text = format!(
        "{BOB}[[force]]\nname = \"rope\"\ntype = \"rope\"\nthrough = [{{ body = \"ground\", at = [0, 0, 1] }}, \"bob\"]\n\
         stiffness = 400.0\nlength = 2.0\n[simulate]\nduration = 1.0\nstart = \"given\"\ntolerance = 1e-10\n"
    );
    let (g, w) = (9.80665_f64, 20.0_f64);
    let fall = (2.0 / g).sqrt();
    // e = a (1 − cos wτ) + (v/w) sin wτ with a = g/w²: zero again after half a turn and twice atan(wv/g).
    let speed = g * fall;
    let slack = fall + 2.0 * (std::f64::consts::PI - (w * speed / g).atan()).abs() / w;
    for method in ["dop853", "dopri5", "radau9", "sdirk4"] {
        let summary = ran(&text, &[&format!("simulate.integrator={method}")]);
        let kinds: Vec<Kind> = summary.events.iter().map(|event| event.kind).collect();
        assert_eq!(kinds, [Kind::Force("taut"), Kind::Force("slack")], "{method}: {:?}", summary.events);
        assert!((summary.events[0].time - fall).abs() < 1e-10, "{method}: {} {fall}", summary.events[0].time);
        // The error of a step is within the tolerance, and there are some hundred steps.
        assert!((summary.events[1].time - slack).abs() < 1e-8, "{method}: {} {slack}", summary.events[1].time);
        assert!((summary.events[1].speed + speed).abs() < 1e-7, "{method}: {}", summary.events[1].speed);
    }
}

/// A scene run from where it is given.
fn ran(text: &str, changes: &[&str]) -> Summary {
    let change = |text: &&str| stillpoint::scenario::Override::parse(text).expect("a change");
    let changes: Vec<_> = changes.iter().map(change).collect();
    let scenario = stillpoint::scenario::parse("scene.toml", text, &changes).expect("a scene");
    let model = build(&scenario.description);
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let still = stillpoint::simulate::scene(&model);
    let mut memory = Memory::new(&Opening { scene: &still, scenario: &scenario.text, statics: None });
    run(&model, &scenario.simulate, 10.0, &start, &mut memory, &mut |_, _| true).expect("a run")
}

/// A stone of 1 kg on a damped rope as a second program: extension and its rate by closed forms from one event to the next.
struct Stone {
    stiffness: f64,
    damping: f64,
}

impl Stone {
    fn pull(&self, [e, rate]: [f64; 2]) -> f64 {
        self.stiffness * e + self.damping * rate
    }

    /// After a time in which the rope stays as it is; underdamped.
    fn flow(&self, taut: bool, [e, rate]: [f64; 2], t: f64) -> [f64; 2] {
        let g = 9.80665;
        if !taut {
            return [e + rate * t + 0.5 * g * t * t, rate + g * t];
        }
        let (decay, rest) = (0.5 * self.damping, g / self.stiffness);
        let w = (self.stiffness - decay * decay).sqrt();
        let (a, b) = (e - rest, (rate + decay * (e - rest)) / w);
        let ((sin, cos), shrink) = ((w * t).sin_cos(), (-decay * t).exp());
        [rest + shrink * (a * cos + b * sin), shrink * ((b * w - decay * a) * cos - (a * w + decay * b) * sin)]
    }

    /// The times at which it goes taut (`true`) and slack within a duration.
    fn events(&self, mut state: [f64; 2], duration: f64) -> Vec<(f64, bool)> {
        let (mut time, mut taut, mut found) = (0.0, self.pull(state) > 0.0, Vec::new());
        let look = 1e-4;
        while time < duration {
            let beyond = |t: f64| (self.pull(self.flow(taut, state, t)) > 0.0) != taut;
            // The first look is behind the event before.
            let steps = ((duration - time) / look) as u32;
            let Some(k) = (2..=steps).find(|k| beyond(f64::from(*k) * look)) else { break };
            let (mut left, mut right) = (f64::from(k - 1) * look, f64::from(k) * look);
            for _ in 0..60 {
                let middle = 0.5 * (left + right);
                if beyond(middle) { right = middle } else { left = middle }
            }
            state = self.flow(taut, state, right);
            (time, taut) = (time + right, !taut);
            found.push((time, taut));
        }
        found
    }
}

/// Stones fall into damped ropes and bounce: all events at the times of the second program, and an account of energy without
/// loss, with an explicit and an implicit method of high order.
#[test]
fn damped_ropes_switch_at_the_times_of_a_second_program() {
    let mut random = Random::new(21);
    let (mut events, mut worst, mut drift) = (0, 0.0_f64, 0.0_f64);
    for case in 0..25 {
        let stone = Stone { stiffness: random.between(100.0, 2000.0), damping: random.between(0.1, 8.0) };
        let (above, speed) = (random.between(0.05, 1.0), random.between(-2.0, 2.0));
        let expected = stone.events([-above, speed], 2.0);
        let text = format!(
            "{}[[force]]\nname = \"rope\"\ntype = \"rope\"\nthrough = [{{ body = \"ground\", at = [0, 0, 5] }}, \"bob\"]\n\
             stiffness = {}\ndamping = {}\nlength = {}\n[simulate]\nduration = 2.0\nstart = \"given\"\ntolerance = 1e-11\n\
             absolute_tolerance = 1e-12\n",
            BOB.replace("axis", &format!("velocity = {}, axis", -speed)),
            stone.stiffness,
            stone.damping,
            5.0 + above
        );
        for method in ["dop853", "radau9"] {
            let summary = ran(&text, &[&format!("simulate.integrator={method}")]);
            let found: Vec<(f64, bool)> =
                summary.events.iter().map(|event| (event.time, event.kind == Kind::Force("taut"))).collect();
            let same = found.iter().zip(&expected).all(|(found, expected)| found.1 == expected.1);
            assert!(same && found.len() == expected.len(), "case {case} {method}: {found:?}\n{expected:?}");
            for (found, expected) in found.iter().zip(&expected) {
                worst = worst.max((found.0 - expected.0).abs());
            }
            events += found.len();
            drift = drift.max(summary.energy_drift);
        }
    }
    eprintln!("{events} events, times within {worst:.1e} s, drift {drift:.1e} J");
    assert!(events > 200, "{events} events");
    // Some hundred steps of a tolerance of 1e-11 relative to energies of up to 20 J.
    assert!(worst < 1e-10 && drift < 1e-9, "{worst:e} s, {drift:e} J");
}

/// Straight tables, of springs and dampers between points and in hinges: two methods without a common step agree, and no
/// energy is lost at their kinks.
#[test]
fn steps_end_at_the_kinks_of_straight_tables() {
    let mut random = Random::new(22);
    let (mut apart, mut drift) = (0.0_f64, 0.0_f64);
    for _ in 0..20 {
        let mut table = |rise: f64| {
            let (mut x, mut f) = (random.between(-0.6, -0.4), random.between(-30.0, -10.0));
            let point = |_| {
                let point = format!("[{x}, {f}]");
                (x, f) = (x + random.between(0.05, 0.4), f + rise * random.between(1.0, 20.0));
                point
            };
            (0..5).map(point).collect::<Vec<_>>().join(", ")
        };
        let (spring, extension, damper, rate) = (table(1.0), table(1.0), table(0.2), table(0.2));
        let text = format!(
            "[[body]]\nname = \"bob\"\nmass = 1.0\nhinge = {{ type = \"prismatic\", axis = [0, 0, 1], position = 0.4, \
             spring = {{ curve = [{spring}], interpolation = \"linear\" }}, \
             damper = {{ curve = [{damper}], interpolation = \"linear\" }} }}\n\
             [[force]]\nname = \"strut\"\ntype = \"curve\"\nbetween = [{{ body = \"ground\", at = [0, 0, -3] }}, \"bob\"]\n\
             length = 3.0\ninterpolation = \"linear\"\nforce = {{ extension = [{extension}], rate = [{rate}] }}\n\
             [simulate]\nduration = 2.0\nstart = \"given\"\ntolerance = 1e-11\nabsolute_tolerance = 1e-12\n"
        );
        let [explicit, implicit] =
            ["dop853", "radau9"].map(|method| ran(&text, &[&format!("simulate.integrator={method}")]));
        apart = apart.max((explicit.state.position[0] - implicit.state.position[0]).abs());
        drift = drift.max(explicit.energy_drift).max(implicit.energy_drift);
    }
    eprintln!("two methods {apart:.1e} m apart, drift {drift:.1e} J");
    // Quadrature of powers to the tolerance; steps across kinks lose some ten times as much.
    assert!(apart < 1e-12 && drift < 2e-10, "{apart:e} m, {drift:e} J");
}

/// Where a rope is slack at first statics still finds where it carries: random weights in random bights, with the angle in
/// closed form.
#[test]
fn statics_finds_bights_from_slack_guesses() {
    use stillpoint::statics::equilibrium;
    let mut random = Random::new(11);
    for case in 0..40 {
        let (load, span, stiffness) = (random.between(1.0, 50.0), random.between(0.5, 3.0), random.between(1e3, 1e5));
        let length = 2.0 * span * random.between(1.05, 2.0);
        let guess = random.between(-0.02, 0.02);
        let text = format!(
            "[[body]]\nname = \"bead\"\nmass = {load}\nhinge = {{ type = \"planar\", rpy = [1.5707963267948966, 0, 0], \
             position = [{}, {guess}, 0], stiffness = [0, 0, 1] }}\ninertia = [1, 1, 1]\n[[force]]\nname = \"rope\"\n\
             type = \"rope\"\nthrough = [{{ body = \"ground\", at = [-{span}, 0, 0] }}, \"bead\", {{ body = \"ground\", at = [{span}, 0, 0] }}]\n\
             stiffness = {stiffness}\nlength = {length}\n",
            random.between(-0.3, 0.3)
        );
        let scenario = stillpoint::scenario::parse("scene.toml", &text, &[]).expect("a scene");
        let model = build(&scenario.description);
        let found = equilibrium(&model, &scenario.statics, &model.start_position).expect("statics");
        assert!(found.converged, "case {case}: {:?}\n{text}", found.notes);
        // Half the load by half the rope: k (2 √(s² + h²) − L) · h / √(s² + h²) = m g / 2.
        let depth = -found.position[1];
        let half = span.hypot(depth);
        let pull = stiffness * (2.0 * half - length) * depth / half;
        assert!((pull / (0.5 * load * 9.80665) - 1.0).abs() < 1e-8, "case {case}: {pull}");
        assert!(found.position[0].abs() < 1e-6, "case {case}: {:?}", found.position);
    }
}

/// A rope whose way between two eyelets is longer than it is pulls what hangs on its end onto the first of them, against any spring: that is said by its name.
#[test]
fn a_rope_that_has_pulled_its_end_into_an_eyelet_is_named() {
    let text = "[statics]\ntime_limit = 5.0\n[[body]]\nname = \"a\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\nhinge = { type = \"free\", at = [0.3, -0.1, 0.2], stiffness = 50.0 }\n\
                [[force]]\nname = \"winch\"\ntype = \"rope\"\nthrough = [\"a\", { body = \"ground\", at = [0, 0, 1] }, { body = \"ground\", at = [0, 0, 3] }]\n\
                stiffness = 500.0\nlength = 1.0\n";
    let scenario =
        stillpoint::scenario::parse("eyelet.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    let model = build(&scenario.description);
    let found = stillpoint::statics::equilibrium(&model, &scenario.statics, &model.start_position);
    let told = found.map_or_else(|fault| fault.to_string(), |found| found.notes.join("; "));
    assert!(told.contains("`winch`") && told.contains("in one place") || told.contains("into one place"), "{told}");
}
