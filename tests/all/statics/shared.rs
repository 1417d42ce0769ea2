//! Rods that share what they bear with stops: of such forces none is unique, of all others each is.

use crate::common::{Random, build};
use stillpoint::constraint::assemble;
use stillpoint::scenario;
use stillpoint::statics::{Equilibrium, equilibrium};

fn solved(text: &str) -> Equilibrium {
    let scenario = scenario::parse("shared.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
    let (model, _) = assemble(build(&scenario.description)).expect("rods that fit");
    equilibrium(&model, &scenario.statics, &model.start_position).expect("numbers")
}

/// A bar that lies on a stop of its hinge and hangs on a rod, beside a weight that hangs on one alone. `held` by the stop, or else above it.
fn bars(random: &mut Random, held: bool) -> String {
    let (mass, length, up) = (random.between(0.2, 5.0), random.between(0.3, 2.0), random.between(0.5, 2.0));
    let (aside, other) = (random.between(-0.2, 0.2), random.between(0.2, 5.0));
    let limits = if held { "[-1.0, 0.0]" } else { "[-1.0, 0.5]" };
    let rod = aside.hypot(up);
    // A turn about y takes x down.
    format!(
        "[statics]\nwant = \"any\"\n\
         [[body]]\nname = \"bar\"\nmass = {mass:?}\ncenter = [{:?}, 0, 0]\ninertia = [0.1, 0.1, 0.1]\nmarkers = {{ tip = [{length:?}, 0, 0] }}\n\
         hinge = {{ type = \"revolute\", axis = [0, 1, 0], limits = {limits} }}\n\
         [[loop]]\nname = \"rod\"\ntype = \"rod\"\nbetween = [{{ body = \"ground\", at = [{:?}, 0, {up:?}] }}, \"bar.tip\"]\nlength = {rod:?}\n\
         [[body]]\nname = \"px\"\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0], at = [-3, 0, 0] }}\n\
         [[body]]\nname = \"p\"\nmass = {other:?}\nhinge = {{ type = \"prismatic\", parent = \"px\", axis = [0, 0, 1] }}\n\
         [[loop]]\nname = \"string\"\ntype = \"rod\"\nbetween = [{{ body = \"ground\", at = [-3, 0, {up:?}] }}, \"p\"]\nlength = {up:?}\n",
        0.5 * length,
        length + aside
    )
}

#[test]
fn what_a_rod_and_a_stop_bear_together_is_not_unique() {
    for seed in 0..40 {
        let random = &mut Random::new(seed);
        let held = seed % 2 == 0;
        let text = bars(random, held);
        let found = solved(&text);
        assert!(found.balanced, "{:?}\n{text}", found.notes);
        let unique = |name: &str| found.loops.iter().find(|one| one.name == name).expect("a loop").unique;
        let bears = found.stops.iter().any(|stop| stop.hinge.contains("bar"));
        assert_eq!((unique("rod"), unique("string")), (!bears, true), "{:?}\n{text}", found.notes);
        let says = |what: &str| found.notes.iter().any(|note| note.contains(what));
        assert_eq!(says("share what they bear"), bears, "{:?}\n{text}", found.notes);
        assert!(!says("singular position"), "{:?}\n{text}", found.notes);
        assert!(held || !bears, "{text}");
    }
}
