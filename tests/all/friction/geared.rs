//! Friction of hinges that gears tie, beside a stop.

use super::{METHODS, go, parse};
use crate::common::Random;

/// A train of one motion presses upon a stop until its load turns about. It moves as soon as the load is more than all of its
/// friction holds at rest, `Σ |rᵢ| stickᵢ`, and then `J v̇ = −(load − Σ |rᵢ| slideᵢ)`, `J = Σ Iᵢ rᵢ²`: in closed form.
#[test]
fn a_geared_train_leaves_its_stop_beyond_what_all_its_friction_holds() {
    for seed in 0..24 {
        let mut random = Random::new(seed);
        let count = 2 + random.below(3);
        let (at_stop, pressing, ramp) = (random.below(count), random.between(0.0, 3.0), random.between(4.0, 9.0));
        let mut text = String::new();
        let (mut gears, mut inertia, mut stick, mut slide) = (String::new(), 0.0, 0.0, 0.0);
        for index in 0..count {
            let side = if random.below(2) == 0 { 1.0 } else { -1.0 };
            let ratio = if index == 0 { 1.0 } else { side * 10_f64.powf(random.between(-0.7, 0.7)) };
            let own = 10_f64.powf(random.between(-2.0, 0.5));
            let sliding = random.between(0.1, 2.0);
            let holding = if random.below(3) == 0 { sliding } else { sliding * random.between(1.0, 1.8) };
            inertia += own * ratio * ratio;
            stick += ratio.abs() * holding;
            slide += ratio.abs() * sliding;
            let limits = match (index == at_stop, ratio > 0.0) {
                (false, _) => "",
                (true, true) => ", limits = { high = 0 }",
                (true, false) => ", limits = { low = 0 }",
            };
            text += &format!(
                "[[body]]\nname = \"b{index}\"\nmass = 1\ninertia = [{own}, {own}, {own}]\nhinge = {{ type = \"revolute\", axis = [0, 0, 1], \
                 friction = {{ stick = {holding}, slide = {sliding} }}{limits} }}\n"
            );
            if index > 0 {
                gears += &format!("[[gear]]\ntype = \"ratio\"\nbetween = [\"b{index}\", \"b0\"]\nratio = {ratio}\n");
            }
        }
        let (starts, still) = ((pressing + stick) / ramp, (pressing + slide) / ramp);
        let end = starts + 0.1;
        let run = format!(
            "gravity = [0, 0, 0]\n[simulate]\nstart = \"given\"\nduration = {end}\ntolerance = 1e-9\nintegrator = \"{}\"\n",
            METHODS[seed as usize % METHODS.len()]
        );
        let motor =
            format!("[[motor]]\nhinge = \"b0\"\ntype = \"expression\"\nexpression = \"{pressing} - {ramp} * t\"\n");
        let summary = go(&parse(&(run + &text + &gears + &motor)));
        let expected = -0.5 * ramp * ((end - still).powi(2) - (starts - still).powi(2)) / inertia;
        let error = (summary.state.velocity[0] - expected).abs();
        // The tolerance, and where the event is found: some 1e-10 of the run.
        assert!(
            error < 1e-6 * expected.abs(),
            "seed {seed}: {} for {expected}: {:?}",
            summary.state.velocity[0],
            summary.events
        );
    }
}
