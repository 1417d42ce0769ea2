//! What rebounds from a stop while something that rests on it presses it there: sequences of impacts end where their rise is rounding.

use super::{go, of};
use crate::common::{Random, build};
use stillpoint::simulate::events::Kind;

/// How far the light link falls to its stop (rad).
const FALL: f64 = 1e-3;

/// A light link with a heavy one that rests on it. The load that presses this one on is up to 10⁵ times a weight, and not felt by the
/// light link as nothing holds.
fn scene(random: &mut Random) -> (String, f64, f64) {
    let method = ["auto", "adams", "dop853", "radau9"][random.below(4)];
    let power = |random: &mut Random, low: f64, high: f64| 10_f64.powf(random.between(low, high));
    let (light, heavy, load) = (power(random, -2.0, 0.0), power(random, -1.0, 1.0), power(random, 3.0, 6.0));
    let (limit, restitution) = (power(random, -1.0, 1.5), random.between(0.3, 0.9));
    let inertia = |moment: f64| format!("inertia = [{moment}, {moment}, {moment}]");
    let text = format!(
        "simulate = {{ start = \"given\", duration = 0.2, integrator = \"{method}\", tolerance = 1e-10 }}\n\
         [[body]]\nname = \"light\"\nmass = {light}\ncenter = [0.1, 0, 0]\n{}\nmarkers.tip = [0.2, 0, 0]\n\
         hinge = {{ type = \"revolute\", axis = [0, 1, 0], position = {}, \
         limits = {{ low = -100, high = {limit}, restitution = {restitution} }} }}\n\
         [[body]]\nname = \"heavy\"\nmass = {heavy}\ncenter = [0.2, 0, 0]\n{}\n\
         hinge = {{ type = \"revolute\", axis = [0, 1, 0], parent = \"light\", at = \"tip\", limits = {{ low = -1, high = 0 }} }}\n\
         [[force]]\nname = \"load\"\ntype = \"load\"\non = {{ body = \"heavy\", at = [0.25, 0, 0] }}\naxes = \"body\"\n\
         force = [0, 0, {}]\n",
        inertia(1e-3 * light),
        limit - FALL,
        inertia(1e-2 * heavy),
        -load
    );
    (text, limit, restitution)
}

/// Each impact leaves the part e² of the rise before, whatever presses: from the fall down to one rounding of the coordinate there are
/// ln(fall / rounding) / (2 ln 1/e) of them.
#[test]
fn impacts_end_where_they_rise_by_rounding_whatever_rests_on_what_strikes() {
    for seed in 0..24 {
        let (text, limit, restitution) = scene(&mut Random::new(seed));
        let scenario =
            stillpoint::scenario::parse("scene.toml", &text, &[]).unwrap_or_else(|found| panic!("{found:?}"));
        let model = build(&scenario.description);
        let (summary, _) = go(&scenario, &model).unwrap_or_else(|error| panic!("seed {seed}: {error}\n{text}"));
        let impacts = of(&summary, "light").iter().filter(|event| event.kind == Kind::Impact).count();
        let rounding = f64::EPSILON * limit.max(1.0);
        let most = (FALL / rounding).ln() / (-2.0 * restitution.ln());
        assert!(impacts as f64 <= most.ceil(), "seed {seed}: {impacts} impacts, {most}\n{text}");
        assert_eq!((summary.state.position[0], summary.state.velocity[0]), (limit, 0.0), "seed {seed}\n{text}");
    }
}
