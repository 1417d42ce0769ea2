//! Motors that push with the speed of their hinge: they damp, or feed, the motion about an equilibrium.

use crate::common::build;
use stillpoint::statics::{StabilityVerdict, equilibrium};

/// A pendulum, alone, geared to a wheel or closed as a parallelogram, with a motor.
fn scene(motor: &str, around: &str) -> String {
    let bar = |name: &str, parent: &str, hinge: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = 2.0\ncenter = [0, 0, -0.5]\ninertia = [0.2, 0.2, 0.01]\nmarkers = {{ end = [0, 0, -1] }}\nhinge = \
             {{ type = \"revolute\", axis = [0, 1, 0]{parent}{hinge} }}\n"
        )
    };
    let more = match around {
        "gear" => {
            bar("wheel", "", ", at = [2, 0, 0]")
                + "[[gear]]\ntype = \"ratio\"\nbetween = [\"arm\", \"wheel\"]\nratio = 1.0\n"
        }
        "loop" => {
            bar("other", "", ", at = [1, 0, 0]")
                + "[[loop]]\ntype = \"rod\"\nbetween = [\"arm.end\", \"other.end\"]\nlength = 1.0\n"
        }
        _ => String::new(),
    };
    format!("{}{more}[[motor]]\nhinge = \"arm\"\n{motor}\n", bar("arm", "", ""))
}

#[test]
fn what_feeds_a_motion_makes_its_equilibrium_unstable() {
    for around in ["nothing", "gear", "loop"] {
        let laws: [fn(f64) -> String; 3] = [
            |feeds| format!("type = \"expression\"\nexpression = \"({feeds})*v\""),
            |feeds| format!("type = \"table\"\nover = \"speed\"\nat = [-1.0, 1.0]\nforces = [{}, {feeds}]", -feeds),
            |feeds| format!("type = \"pd\"\ntarget = 0.0\nstiffness = 0.0\ndamping = {}", -feeds),
        ];
        for (law, feeds) in [(0, 3.0), (0, -3.0), (1, 2.0), (1, -0.1), (2, -1.5)] {
            let motor = laws[law](feeds);
            let text = scene(&motor, around);
            let scenario = stillpoint::scenario::parse("scene.toml", &text, &[])
                .unwrap_or_else(|found| panic!("{}", found.render(false)));
            let model = build(&scenario.description);
            let found = equilibrium(&model, &scenario.statics, &model.start_position).expect("numbers");
            let stability = found.stability.expect("a verdict");
            // (n I) φ̈ − feeds φ̇ + (n m g l) φ = 0 for n bars that move together.
            let bars: f64 = if around == "nothing" { 1.0 } else { 2.0 };
            let (inertia, stiffness): (f64, f64) = (bars * (0.2 + 2.0 * 0.25), bars * 2.0 * 9.80665 * 0.5);
            let ratio = -feeds / (2.0 * (inertia * stiffness).sqrt());
            assert!((stability.damped[0].damping_ratio - ratio).abs() < 1e-8, "{text}: {:?}", stability.damped);
            let verdict = if feeds > 0.0 { StabilityVerdict::Unstable } else { StabilityVerdict::Stable };
            assert_eq!(stability.verdict, verdict, "{text}");
            assert_eq!(stability.unstable_directions, usize::from(feeds > 0.0), "{text}");
        }
    }
}
