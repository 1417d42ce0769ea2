//! What latches by an event of the gap that it closes, and what latches again.

use super::{Kind, given};
use crate::common::{Random, build};
use stillpoint::record::Fanout;
use stillpoint::scenario::parse;
use stillpoint::simulate::{self, Summary};

fn ran(text: &str) -> Summary {
    let scenario = parse("scene.toml", text, &[]).unwrap_or_else(|found| panic!("{found:?}"));
    let model = build(&scenario.description);
    simulate::run(&model, &scenario.simulate, 100.0, &given(&model), &mut Fanout::new(), &mut |_, _| true)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// Two wheels whose gear closes once their gap is gone, and where that is watched: at the gap, or some way beside it.
fn wheels(random: &mut Random, when: Option<f64>) -> (String, f64) {
    let (ratio, gap, rate) = (random.between(0.5, 3.0), random.between(0.3, 1.5), random.between(1.0, 3.0));
    let beside = [0.0, -1e-10, 3e-11][random.below(3)];
    let come =
        when.map_or_else(|| "when = { event = \"mesh\" }".to_owned(), |time| format!("when = {{ time = {time:?} }}"));
    let text = format!(
        "gravity = [0, 0, 0]\n[simulate]\nstart = \"given\"\nduration = 2.0\ntolerance = 1e-11\n\
         [[body]]\nname = \"a\"\nmass = 1.0\ninertia = [0.2, 0.2, 0.3]\n\
         hinge = {{ type = \"revolute\", axis = [0, 0, 1], velocity = {rate:?} }}\n\
         [[body]]\nname = \"b\"\nmass = 1.0\ninertia = [0.2, 0.2, 0.1]\n\
         hinge = {{ type = \"revolute\", axis = [0, 0, 1], at = [1, 0, 0], velocity = {:?} }}\n\
         [[gear]]\nname = \"g\"\ntype = \"ratio\"\nratio = {ratio:?}\nbetween = [\"a\", \"b\"]\noffset = {:?}\n\
         [[motor]]\nhinge = \"b\"\ntype = \"expression\"\nexpression = \"0.3*cos(3*t)-0.1*v\"\n\
         [[output]]\nname = \"qa\"\ntype = \"coordinate\"\nof = \"a\"\n\
         [[output]]\nname = \"qb\"\ntype = \"coordinate\"\nof = \"b\"\n\
         [[output]]\nname = \"gap\"\ntype = \"expression\"\nexpression = \"qa - {ratio:?}*qb + {gap:?}\"\n\
         [[event]]\nname = \"mesh\"\noutput = \"gap\"\nvalue = {beside:?}\n\
         [[stage]]\nname = \"on\"\n{come}\nclose = [\"g\"]\n",
        3.0 * rate / ratio,
        -gap,
    );
    (text, beside)
}

/// The stage at an event holds the number that the event watches, at its value or beside it: it is told once, and the run goes on as if the stage
/// had come by itself at that time.
#[test]
fn a_gear_that_closes_at_its_own_gap_meshes_once() {
    for seed in 0..12 {
        let found = ran(&wheels(&mut Random::new(seed), None).0);
        let [mesh, on] = ["mesh", "on"].map(|name| found.events.iter().filter(|event| event.name == name).count());
        let stage = found.events.iter().find(|event| event.kind == Kind::Stage);
        let Some(stage) = stage.filter(|_| mesh <= 1 && on == 1) else { panic!("seed {seed}: {mesh} {on}") };
        assert!(found.energy_drift < 1e-9, "seed {seed}: {:e}", found.energy_drift);
        let plain = ran(&wheels(&mut Random::new(seed), Some(stage.time)).0);
        let [by_event, by_time] = [&found, &plain].map(|run| run.statistics.acceleration_evaluations);
        assert!(by_event < 3 * by_time, "seed {seed}: {by_event} accelerations by the event, {by_time} by its time");
        assert!((found.state.velocity[0] - plain.state.velocity[0]).abs() < 1e-8, "seed {seed}");
    }
}

/// A tug that docks where it meets the port, whichever way that is watched.
#[test]
fn a_tug_docks_once() {
    let mut random = Random::new(5);
    let watched = ["output = \"rel\"", "output = \"x\"", "on = \"tug.port\"\naxis = [1, 0, 0]"];
    for case in 0..12 {
        let (speed, way) = (random.between(0.1, 2.0), random.between(1.0, 8.0));
        let (heavy, light) = (random.between(10.0, 100.0), random.between(1.0, 10.0));
        let direction = ["up", "both"][case % 2];
        let text = format!(
            "gravity = [0, 0, 0]\n[simulate]\nstart = \"given\"\nduration = {:?}\ntolerance = 1e-11\n\
             [[body]]\nname = \"station\"\nmass = {heavy:?}\ninertia = [9, 30, 30]\nmarkers = {{ port = [-2, 0, 0] }}\n\
             hinge = {{ type = \"free\" }}\n\
             [[body]]\nname = \"tug\"\nmass = {light:?}\ninertia = [0.9, 2, 2]\nmarkers = {{ port = [1.5, 0, 0] }}\n\
             hinge = {{ type = \"free\", position = [{:?}, 0, 0, 1, 0, 0, 0], velocity = [{speed:?}, 0, 0, 0, 0, 0] }}\n\
             [[loop]]\nname = \"latches\"\ntype = \"fixed\"\nbetween = [\"station.port\", \"tug.port\"]\n\
             [[output]]\nname = \"sx\"\ntype = \"position\"\nof = \"station.port\"\naxis = [1, 0, 0]\n\
             [[output]]\nname = \"x\"\ntype = \"position\"\nof = \"tug.port\"\naxis = [1, 0, 0]\n\
             [[output]]\nname = \"rel\"\ntype = \"expression\"\nexpression = \"x - sx\"\n\
             [[event]]\nname = \"touch\"\n{}\nvalue = {:?}\ndirection = \"{direction}\"\n\
             [[stage]]\nname = \"docking\"\nwhen = {{ event = \"touch\" }}\nclose = [\"latches\"]\n",
            2.5 * way / speed,
            -3.5 - way,
            watched[case % 3],
            [0.0, -2.0, -2.0][case % 3],
        );
        let found = ran(&text);
        let touches = found.events.iter().filter(|event| event.kind == Kind::Crossing).count();
        assert!(touches <= 1, "case {case}: {touches} crossings");
        let lost = 0.5 * heavy * light / (heavy + light) * speed * speed;
        assert!((found.dissipated - lost).abs() < 1e-9 * lost, "case {case}: {} J, not {lost} J", found.dissipated);
        assert!(
            found.statistics.acceleration_evaluations < 2000,
            "case {case}: {}",
            found.statistics.acceleration_evaluations
        );
    }
}

/// A pod that was welded to its ship is let go while an engine shakes that, and is welded on again where its bay comes back to it: the momentum
/// is what the engine gave, and the approach is lost, ½ μ v².
#[test]
fn what_was_welded_is_latched_again() {
    let mut random = Random::new(6);
    for case in 0..6 {
        let (ship, pod, push, pace) =
            (random.between(5.0, 20.0), random.between(1.0, 5.0), random.between(10.0, 50.0), random.between(1.0, 3.0));
        let phase = random.between(0.2, 0.5);
        let out = phase / pace;
        let text = format!(
            "gravity = [0, 0, 0]\n[simulate]\nstart = \"given\"\nduration = {:?}\ntolerance = 1e-11\n\
             [[body]]\nname = \"ship\"\nmass = {ship:?}\nmarkers = {{ bay = [1, 0, 0] }}\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0] }}\n\
             [[motor]]\nhinge = \"ship\"\ntype = \"expression\"\nexpression = \"{push:?}*cos({pace:?}*t)\"\n\
             [[body]]\nname = \"pod\"\nmass = {pod:?}\ninertia = [0.1, 0.1, 0.1]\n\
             hinge = {{ type = \"fixed\", parent = \"ship\", at = \"bay\" }}\n\
             [[loop]]\nname = \"again\"\ntype = \"fixed\"\nbetween = [\"ship.bay\", \"pod\"]\n\
             [[output]]\nname = \"bay\"\ntype = \"position\"\nof = \"ship.bay\"\naxis = [1, 0, 0]\n\
             [[output]]\nname = \"at\"\ntype = \"position\"\nof = \"pod\"\naxis = [1, 0, 0]\n\
             [[output]]\nname = \"ahead\"\ntype = \"expression\"\nexpression = \"at - bay\"\n\
             [[event]]\nname = \"meets\"\noutput = \"ahead\"\ndirection = \"up\"\n\
             [[stage]]\nname = \"out\"\nwhen = {{ time = {out:?} }}\nopen = [\"pod\"]\n\
             [[stage]]\nname = \"back\"\nwhen = {{ event = \"meets\" }}\nclose = [\"again\"]\n",
            8.0 / pace
        );
        let found = ran(&text);
        let stages = found.events.iter().filter(|event| event.kind == Kind::Stage);
        let told: Vec<(&str, f64)> = stages.map(|event| (event.name.as_str(), event.time)).collect();
        let [("out", _), ("back", back)] = told[..] else { panic!("case {case}: {told:?}") };
        let speed = push / ship / pace * ((pace * back).sin() - phase.sin());
        let lost = 0.5 * ship * pod / (ship + pod) * speed * speed;
        assert!((found.dissipated - lost).abs() < 1e-7 * lost, "case {case}: {} J, not {lost} J", found.dissipated);
        let momentum = push / pace * 8.0_f64.sin();
        let at_end =
            |body: &str| found.state.velocity[found.model.bodies[found.model.body(body).expect("it")].hinge.velocity];
        for body in ["ship", "pod"] {
            let (velocity, expected) = (at_end(body), momentum / (ship + pod));
            assert!((velocity - expected).abs() < 1e-7, "case {case}, {body}: {velocity} m/s, not {expected} m/s");
        }
        assert!(found.energy_drift < 1e-8 * found.energy_largest, "case {case}: {:e}", found.energy_drift);
    }
}
