//! The launcher: aimed at rest, and every rocket told as it leaves.

use super::Kind;
use crate::common::{answered, build};
use stillpoint::record::Fanout;
use stillpoint::scenario::{Override, load_with};
use stillpoint::simulate::{self, State, Summary};
use stillpoint::statics::{InverseAnswer, outputs};

/// A salvo with an interval between its shots (s).
fn salvo(interval: f64) -> Summary {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/launcher.toml");
    let change = Override::parse(&format!("parameters.interval={interval}")).expect("a change");
    let scenario = load_with(path.as_ref(), &[change]).unwrap_or_else(|error| panic!("{error}"));
    let model = build(&scenario.description);
    let InverseAnswer { model, found, .. } = answered(&scenario, model).expect("an equilibrium");
    assert!(found.converged && found.stability.as_ref().is_some_and(|stability| stability.modes[0].frequency_hz > 1.0));
    let values = outputs(&model, &found).expect("outputs");
    for (name, wanted) in [("elevation", 45.0_f64), ("azimuth", 20.0)] {
        let at = model.outputs.iter().position(|output| output.name == name).expect("the output");
        assert!((values[at] - wanted.to_radians()).abs() < 1e-9, "{name} is aimed at {} rad", values[at]);
    }
    let start = State { position: found.position.clone(), velocity: found.velocity.clone() };
    simulate::run(&model, &scenario.simulate, 1.0, &start, &mut Fanout::new(), &mut |_, _| true)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// The rates with which the rockets leave (rad/s).
fn rates(found: &Summary) -> Vec<f64> {
    let told = found.told.iter().filter(|(_, label, _)| label == "pitch_rate");
    told.map(|(.., rate)| *rate).collect()
}

fn scatter(rates: &[f64]) -> f64 {
    let mean = rates.iter().sum::<f64>() / rates.len() as f64;
    (rates.iter().map(|rate| (rate - mean).powi(2)).sum::<f64>() / rates.len() as f64).sqrt()
}

/// Twelve rockets leave one after the other, each with the speed of its thrust along the tube; energy is accounted for to 1e-9 of what the
/// motors put in; and the interval between shots decides how they scatter.
#[test]
fn twelve_rockets_leave_and_scatter_by_the_interval() {
    let found = salvo(0.5);
    let stages: Vec<_> = found.events.iter().filter(|event| event.kind == Kind::Stage).collect();
    assert_eq!(stages.len(), 24);
    for shot in 0..12 {
        let [fire, exit] = [stages[2 * shot], stages[2 * shot + 1]];
        assert_eq!(
            (fire.name.clone(), exit.name.clone()),
            (format!("fire_{}", shot + 1), format!("exit_{}", shot + 1))
        );
        assert!((fire.time - 1.0 - 0.5 * shot as f64).abs() < 1e-12, "{fire}");
        // 3 m from rest under 27 kN, which take 0.01 s to come, less weight and friction, on 66 kg that lose 12 kg/s.
        let acceleration = 27_000.0 / 65.2 - 9.80665 * 0.5_f64.sqrt() - 30.0 * 24.0 / 65.2;
        let time = (2.0 * 3.0 / acceleration).sqrt() + 0.005;
        assert!((exit.time - fire.time - time).abs() < 0.01 * time, "{} {time}", exit.time - fire.time);
        assert!(found.events.iter().any(|event| event.kind == Kind::Crossing && event.time == exit.time));
    }
    assert!(found.energy_drift < 1e-9 * found.work, "{:e} of {:e} J", found.energy_drift, found.work);
    assert_eq!(rates(&found).len(), 12);
    let [good, bad] = [scatter(&rates(&found)), scatter(&rates(&salvo(0.62)))];
    assert!(good < 0.5 * bad, "{good} {bad} rad/s");
}
