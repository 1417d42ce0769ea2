//! Cylinders at rest and in motion: rolling, a disc on its rim, what tips and what lies, against closed forms.

use crate::common::answered;
use crate::contact_in_motion::{FLOOR, go, read};
use nalgebra::{UnitQuaternion, Vector3};
use stillpoint::integrate::Method;
use stillpoint::scenario::parse;
use stillpoint::simulate::State;
use stillpoint::statics::standing::StandingReport;

const G: f64 = 9.80665;

fn standing(text: &str) -> StandingReport {
    let scenario = parse("scene.toml", text, &[]).unwrap_or_else(|problem| panic!("{}\n{text}", problem.render(false)));
    *answered(&scenario, read(text)).unwrap().found.standing.expect("there is contact")
}

/// A solid cylinder of 1 kg that is free: radius, length, place, turn, velocity, and angular velocity in its own axes.
fn cylinder(name: &str, size: [f64; 2], at: [f64; 3], turn: UnitQuaternion<f64>, speed: [Vector3<f64>; 2]) -> String {
    let [r, l] = size;
    let across = r * r / 4.0 + l * l / 12.0;
    let (v, w) = (speed[0], speed[1]);
    format!(
        "[[body]]\nname = \"{name}\"\nmass = 1.0\ninertia = [{across:?}, {across:?}, {:?}]\nshape = {{ cylinder = [{r:?}, {l:?}] }}\n\
         hinge = {{ type = \"free\", position = {:?}, velocity = {:?} }}\n",
        0.5 * r * r,
        [at[0], at[1], at[2], turn.w, turn.i, turn.j, turn.k],
        [v.x, v.y, v.z, w.x, w.y, w.z]
    )
}

fn contact(friction: f64) -> String {
    format!("[[contact]]\nbetween = [\"*\", \"*\"]\nfriction = {friction:?}\n")
}

/// On its side, along y.
fn lying() -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2)
}

const STILL: [Vector3<f64>; 2] = [Vector3::new(0.0, 0.0, 0.0), Vector3::new(0.0, 0.0, 0.0)];

/// A log rolls down a slope with 2/3 g sin φ, by explicit and by implicit methods, and without slip.
#[test]
fn a_log_rolls_down_a_slope() {
    let (radius, slope) = (0.15, 0.3_f64);
    let text = format!("gravity = [{:?}, 0.0, {:?}]\n", G * slope.sin(), -G * slope.cos())
        + FLOOR
        + &cylinder("log", [radius, 0.8], [0.0, 0.0, radius], lying(), STILL)
        + &contact(0.4);
    for method in [Method::Dopri5, Method::Dop853, Method::Radau5, Method::Radau9, Method::Sdirk4] {
        let summary = go(&read(&text), 1.0, 1e-9, method);
        let far = G * slope.sin() / 3.0;
        let State { position, velocity } = &summary.state;
        assert!((position[0] - far).abs() < 1e-8, "{method:?}: {} {far}", position[0]);
        // Its own axes: y of the scene is −z of the log.
        let spin = velocity[3..6].iter().map(|w| w * w).sum::<f64>().sqrt();
        assert!((velocity[0] - radius * spin).abs() < 1e-8, "{method:?}: {velocity:?}");
        assert!(summary.energy_drift < 1e-8 && summary.capture_steps == 0, "{method:?}: {}", summary.energy_drift);
    }
}

/// A disc of finite thickness rolls on its rim while its middle stays where it is: the balance of moments about that,
///
/// ```text
/// Ω² sin α (I_t cos α − I_a (l/r) sin α) = m g (r cos α − l sin α),    l half its thickness,
/// ```
///
/// has the rate Ω at which the point of contact goes round.
#[test]
fn a_disc_rolls_on_its_rim() {
    let (r, l, tilt) = (0.075, 0.004, 0.35_f64);
    let (sin, cos) = tilt.sin_cos();
    let (across, along) = (r * r / 4.0 + l * l / 3.0, 0.5 * r * r);
    let rate = (G * (r * cos - l * sin) / (sin * (across * cos - along * (l / r) * sin))).sqrt();
    // The axis is tilted about y, so that the lowest point is at −x of the disc or +x.
    let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), tilt);
    let axis = turn * Vector3::z();
    let lowest = -(Vector3::z() - axis * axis.z).normalize();
    let spin = (lowest - axis * (l / r)) * (-rate * sin);
    let height = r * sin + l * cos;
    let speed = [Vector3::zeros(), turn.inverse() * spin];
    let text = FLOOR.to_owned() + &cylinder("disc", [r, 2.0 * l], [0.0, 0.0, height], turn, speed) + &contact(0.3);
    for (method, tolerance) in [(Method::Dop853, 1e-10), (Method::Radau9, 1e-9)] {
        let summary = go(&read(&text), 0.5, tolerance, method);
        let q = &summary.state.position;
        assert!((Vector3::new(q[0], q[1], q[2]) - Vector3::z() * height).norm() < 1e-7, "{method:?}: {q:?}");
        let end = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q[3], q[4], q[5], q[6])) * Vector3::z();
        assert!((end.z - cos).abs() < 1e-6, "{method:?}: {end:?}");
        // The axis has gone round by Ω t.
        let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), rate * 0.5) * axis;
        assert!((end - turned).norm() < 1e-5, "{method:?}: {end:?} {turned:?}");
        assert!(summary.energy_drift < 1e-8 && summary.events.is_empty(), "{method:?}: {:?}", summary.events);
    }
}

/// A drum slides or tips over its rim: at tan φ = 2 r/h, to every side of the axes; a drum that lies rolls at once.
#[test]
fn a_drum_tips_over_its_rim() {
    let tilts = "[statics]\nmargin = [\"tilt\", \"friction\"]\n";
    let turn = UnitQuaternion::identity();
    let scene = |turn, height, friction| {
        tilts.to_owned() + FLOOR + &cylinder("drum", [0.2, 0.5], [0.0, 0.0, height], turn, STILL) + &contact(friction)
    };
    let found = standing(&scene(turn, 0.25, 0.9));
    let tilt = |found: &StandingReport, towards: &str| {
        let margin = found.margins.tilt.iter().find(|(name, ..)| name == towards);
        margin.map_or_else(|| panic!("{:?}", found.margins.tilt), |(_, tilt, _)| *tilt)
    };
    for towards in ["+x", "-x", "+y", "-y"] {
        assert!((tilt(&found, towards) - 0.8).abs() < 1e-8, "{towards}: {}", tilt(&found, towards));
    }
    let slides = standing(&scene(turn, 0.25, 0.5));
    assert!((tilt(&slides, "+x") - 0.5).abs() < 1e-8);
    let lies = standing(&scene(lying(), 0.2, 0.9));
    assert!(tilt(&lies, "+x").abs() < 1e-8 && (tilt(&lies, "+y") - 0.9).abs() < 1e-8, "{:?}", lies.margins.tilt);
}

/// Three logs in a pile need friction of tan 15° between them, and a third of it on the ground.
#[test]
fn three_logs_need_friction() {
    let (r, l) = (0.1, 0.6);
    let log = |name: &str, x: f64, z: f64| cylinder(name, [r, l], [x, 0.0, z], lying(), STILL);
    let text = "[statics]\nmargin = [\"friction\"]\n".to_owned()
        + FLOOR
        + &log("left", -r, r)
        + &log("right", r, r)
        + &log("top", 0.0, r * (1.0 + 3.0_f64.sqrt()))
        + &contact(0.4);
    let found = standing(&text);
    let needs = (std::f64::consts::PI / 12.0).tan();
    assert!((found.friction_margin.unwrap() - needs / 0.4).abs() < 1e-6, "{:?}", found.friction_margin);
}

/// A coin that is tossed loses what its impacts take and nothing else: it comes to lie, or wobbles low on its rim, which nothing brakes. How long that
/// takes depends on the last digit of the toss.
#[test]
fn a_tossed_coin_comes_to_lie_or_wobbles_low() {
    let turn = UnitQuaternion::from_euler_angles(0.4, 0.3, 0.0);
    let speed = [Vector3::new(0.2, 0.1, 0.0), Vector3::new(3.0, -2.0, 1.0)];
    let text = FLOOR.to_owned() + &cylinder("coin", [0.05, 0.012], [0.0, 0.0, 0.1], turn, speed) + &contact(0.4);
    for tolerance in [1e-6, 1e-7, 1e-8] {
        let summary = go(&read(&text), 3.0, tolerance, Method::Dop853);
        let q = &summary.state.position;
        let axis = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q[3], q[4], q[5], q[6])) * Vector3::z();
        // From 28 degrees at the start to 3 at most, on its rim.
        let tilt = axis.z.abs().min(1.0).acos();
        let height = 0.006 * tilt.cos() + 0.05 * tilt.sin();
        assert!(tilt < 0.05 && (q[2] - height).abs() < 1e-5, "{tolerance}: {tilt} {q:?}");
        assert!(summary.energy_end < 0.1 * summary.energy_start, "{tolerance}: {}", summary.energy_end);
        assert!(summary.energy_drift < 2e-3 * summary.energy_start, "{tolerance}: {}", summary.energy_drift);
    }
}
