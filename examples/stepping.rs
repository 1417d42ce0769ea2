//! An integrator stepped by hand, with reactions read on the way: `cargo run --example stepping`

#![allow(clippy::print_stdout, clippy::unwrap_used)]

use stillpoint::integrate::{Method, Options, Start};
use stillpoint::model::Model;
use stillpoint::model::description::{BodyDescription, Description, HingeDescription};
use stillpoint::simulate::problem::Equations;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let axis = [0.0, 1.0, 0.0];
    let link = |name: &str, hinge: HingeDescription| {
        BodyDescription::new(name, hinge).mass(1.0).center([0.0, 0.0, -0.5]).inertia([0.083, 0.083, 0.001])
    };
    let scene = Description::new("Double pendulum")
        .body(link("upper", HingeDescription::revolute(axis).position([1.5])))
        .body(link("lower", HingeDescription::revolute(axis).on("upper", [0.0, 0.0, -1.0])));
    let model = Model::build(&scene).map_err(|problems| format!("{problems:?}"))?;

    let mut motion = Equations::new(&model);
    let start = Start { time: 0.0, position: &model.start_position, velocity: &model.start_velocity, end: 2.0 };
    let options = Options { relative: 1e-9, absolute: 1e-11, ..Options::default() };
    let mut stepper = Method::Dop853.start(&mut motion, &options, start)?;
    let (mut a, mut unbalanced, mut reactions) = (vec![0.0; 2], vec![0.0; 2], Vec::new());
    let mut largest: f64 = 0.0;
    while !stepper.finished() {
        stepper.step(&mut motion)?;
        let (q, v) = (stepper.position().to_vec(), stepper.velocity().to_vec());
        let mut at = motion.at(stepper.time(), &q, &v);
        at.accelerations(&mut a)?;
        at.residual(&a, &mut unbalanced)?.reactions(&mut reactions);
        largest = largest.max(reactions[0].force.norm());
    }
    println!("{} steps to {} s", stepper.statistics().steps, stepper.time());
    println!("the upper hinge bears up to {largest:.2} N");
    Ok(())
}
