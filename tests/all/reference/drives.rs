//! Prescribed motions: Kapitza's pendulum, the car axis; and statics of closed chains.

use super::case::case;
use super::loops::{bricard, four_bars};
use super::scene::{Scene, frequencies, head};

#[test]
pub(super) fn c14_kapitza() {
    let case = case("C14_kapitza");
    let (l, a, omega) = (case.parameter("l"), case.parameter("a"), case.parameter("Omega"));
    let text = head([0.0, -case.parameter("g"), 0.0], "dop853", 1e-13)
        + &format!(
            "[[body]]\nname = \"pivot\"\nmass = 1.0\ninertia = [1, 1, 1]\nhinge = {{ type = \"prismatic\", axis = [0, 1, 0] }}\n\
             [[body]]\nname = \"rod\"\nmass = {:?}\ncenter = [0, {l:?}, 0]\ninertia = [0, 0, 0]\n\
             hinge = {{ type = \"revolute\", parent = \"pivot\", axis = [0, 0, -1], position = {:?} }}\n\
             [[drive]]\nhinge = \"pivot\"\ntype = \"sine\"\namplitude = {a:?}\nfrequency = {:?}\n",
            case.parameter("m"),
            case.initial("theta"),
            omega / std::f64::consts::TAU,
        );
    let scene = Scene::read(&text);
    for (time, state) in case.states() {
        let mut run = scene.run();
        run.until(time);
        state.at("theta").check(run.coordinate("rod"), case.tolerance("abs"));
        state.at("thetadot").check(run.speed("rod"), 10.0 * case.tolerance("abs"));
    }
}

/// The axle turns about the left wheel so that the right wheel follows the road; the left mass slides across it, the
/// right one hangs on the left by a rigid rod.
#[test]
pub(super) fn a07_car_axis() {
    let case = case("A07_car_axis");
    let p = |key: &str| case.parameter(key);
    let start = |key: &str| case.initial(key);
    let (m, l) = (p("mass_each"), p("L"));
    let angle = format!("asin({:?}/{l:?}*sin({:?}*t))", p("r"), p("omega"));
    let turn = -start("vxl") / start("yl");
    for (integrator, tolerance, error) in [("dop853", 1e-12, 1e-9), ("radau9", 1e-10, 1e-7)] {
        let text = head([0.0, -p("g"), 0.0], integrator, tolerance)
            + &format!(
                "[[body]]\nname = \"axle\"\nmass = 1.0\ninertia = [1, 1, 1]\nmarkers = {{ right = [{l:?}, 0, 0] }}\n\
                 hinge = {{ type = \"revolute\", axis = [0, 0, 1] }}\n\
                 [[body]]\nname = \"left\"\nmass = {m:?}\ninertia = [0, 0, 0]\n\
                 hinge = {{ type = \"prismatic\", parent = \"axle\", axis = [0, 1, 0], position = {:?} }}\n\
                 [[body]]\nname = \"right\"\nmass = {m:?}\ninertia = [0, 0, 0]\n\
                 hinge = {{ type = \"planar\", position = [{:?}, {:?}, 0], velocity = [{:?}, {:?}, 0], armature = [0, 0, 1] }}\n\
                 [[loop]]\ntype = \"rod\"\nlength = {l:?}\nbetween = [\"left\", \"right\"]\n\
                 [[force]]\nname = \"first\"\ntype = \"spring\"\nbetween = [\"ground\", \"left\"]\nstiffness = {k:?}\nlength = {rest:?}\n\
                 [[force]]\nname = \"second\"\ntype = \"spring\"\nbetween = [\"axle.right\", \"right\"]\nstiffness = {k:?}\nlength = {rest:?}\n\
                 [[drive]]\nhinge = \"axle\"\ntype = \"expression\"\nexpression = \"{angle}\"\n",
                start("yl"),
                start("xr"),
                start("yr"),
                start("vxr"),
                start("vyr"),
                k = p("spring_k"),
                rest = p("L0"),
            );
        let scene = Scene::read(&text);
        // What the drive gives the left mass at the start is what the case gives it.
        assert!((turn - p("r") * p("omega") / l).abs() < 1e-15);
        for (time, state) in case.states() {
            let mut run = scene.run();
            run.until(time);
            for (body, x, y) in [("left", "xl", "yl"), ("right", "xr", "yr")] {
                let at = run.point(body, [0.0; 3]);
                state.at(x).check(at.x, error);
                state.at(y).check(at.y, error);
            }
            state.at("vxr").check(run.velocities("right")[0], 1e3 * error);
            state.at("vyr").check(run.velocities("right")[1], 1e3 * error);
            assert!(run.gap < 1e-12, "{:e}", run.gap);
        }
    }
}

#[test]
fn a04_bricard_rests_at_a_right_angle() {
    let case = case("A04_bricard");
    let expected = case.at("reference").at("static_equilibrium");
    let scene = Scene::read(&bricard("equilibrium", 0.0));
    let found = scene.rest();
    expected.at("joint0_angle_y").check(scene.position("bar0", &found.position)[0], 1e-10);
    expected.at("small_oscillation_omega").check(frequencies(&found)[0], 1e-9);
}

/// The stable equilibrium is exactly the change point, where the loop's rows are linearly dependent.
#[test]
fn b16_parallelogram_rests_at_its_change_point() {
    let case = case("B16_parallelogram_singular_equilibrium");
    let guess = 0.3;
    let text = four_bars(1, 0.0, 1e-9)
        .replacen(
            "velocity = 0.0",
            &format!(
                "position = {guess}, stiffness = {:?}, rest = {:?}",
                case.parameter("k"),
                case.parameter("theta0")
            ),
            1,
        )
        .replacen("velocity = 0.0", &format!("position = {guess}"), 1)
        .replace(
            "parent = \"rod0\", at = \"tip\", axis = [0, 0, -1]",
            &format!("parent = \"rod0\", at = \"tip\", axis = [0, 0, -1], position = -{guess}"),
        );
    let scene = Scene::read(&text);
    let found = scene.rest();
    for rod in ["rod0", "rod1"] {
        case.at("reference").at("theta").check(scene.position(rod, &found.position)[0], case.tolerance("abs"));
    }
    case.at("reference").at("omega").check(frequencies(&found)[0], 1e-6);
    assert!(found.notes.iter().any(|note| note.contains("singular position")), "{:?}", found.notes);
}

/// Chains between two supports hang as the discrete catenary says, even nearly taut.
#[test]
fn b03_hanging_chain() {
    let case = case("B03_hanging_chain");
    for key in case.at("reference").keys().into_iter().filter(|key| key.starts_with("n=") && key.contains("rise")) {
        let numbers: Vec<f64> = key
            .split(',')
            .map(|part| part.split('=').next_back().expect("a value").parse().expect("a number"))
            .collect();
        let (count, span, rise) = (numbers[0] as usize, numbers[1], numbers[2]);
        // Dense matrices: a thousand links take ten seconds.
        if count > 10 && cfg!(debug_assertions) {
            continue;
        }
        let length = case.parameter("total_length") / count as f64;
        let mass = case.parameter("total_mass") / count as f64;
        let inertia = mass * length * length / 12.0;
        // The guess is an arc of about that chord, found by halving: chord over length is sin φ/φ.
        let chord = span.hypot(rise);
        let (mut low, mut high) = (0.0_f64, 3.0_f64);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if middle.sin() / middle > chord { low = middle } else { high = middle }
        }
        let turn = 2.0 * low / count as f64;
        let first = rise.atan2(span) - low + 0.5 * turn;
        let positions: Vec<f64> = (0..count).map(|i| if i == 0 { first } else { turn }).collect();
        let text = head([0.0, -case.parameter("g"), 0.0], "dop853", 1e-9)
            + &format!(
                "[[body]]\nname = \"link\"\nrepeat = {count}\nmass = {mass:?}\ncenter = [{:?}, 0, 0]\n\
                 inertia = [0, {inertia:?}, {inertia:?}]\nmarkers = {{ tip = [{length:?}, 0, 0] }}\nnext = \"tip\"\n\
                 hinge = {{ type = \"revolute\", axis = [0, 0, 1], position = {positions:?} }}\n\
                 [[loop]]\ntype = \"revolute\"\naxis = [0, 0, 1]\n\
                 between = [\"link[{}].tip\", {{ body = \"ground\", at = [{span:?}, {rise:?}, 0] }}]\n",
                0.5 * length,
                count - 1
            );
        let scene = Scene::read(&text);
        let found = scene.rest();
        let expected = case.at("reference").at(&key);
        println!("{key}");
        // Nearly taut: the angles follow from lengths that differ by a millionth.
        let tolerance = if span > 0.9999 { 1e-7 } else { 1e-9 };
        expected.at("theta_first").check(found.position[0], tolerance);
        expected.at("theta_last").check(found.position.iter().sum(), tolerance);
        expected.at("horizontal_tension").check_relative(-found.reactions[0].force.x, 1e-6);
        expected.at("V_left_on_chain").check_relative(found.reactions[0].force.y, 1e-6);
    }
}
