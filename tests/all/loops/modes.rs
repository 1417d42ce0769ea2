//! Modes: rows that act or do not are those of scenes with or without the elements.

use super::read;
use crate::common::{Random, relative_difference};
use std::fmt::Write;
use std::sync::Arc;
use stillpoint::dynamics::{HeldRow, RowSelection, System};
use stillpoint::model::Model;
use stillpoint::model::prescribed::Instant;

/// Drives that may act, on the first bodies of the chain.
const DRIVES: usize = 3;

/// A chain of five bodies on revolute hinges, the last two geared, and the drives whose bit is set in `acting`.
fn scene(seed: u64, acting: usize) -> String {
    let mut random = Random::new(seed);
    let mut text = String::new();
    let mut number = || random.between(-1.0, 1.0);
    for i in 0..DRIVES + 2 {
        let parent = if i == 0 { String::new() } else { format!("parent = \"b{}\", at = [0.4, 0.1, 0.0], ", i - 1) };
        let (axis, position, velocity) = ([number(), number(), number() + 2.0], number(), number());
        let _ = write!(
            text,
            "[[body]]\nname = \"b{i}\"\nmass = {:?}\ncenter = [0.2, {:?}, 0.05]\ninertia = [0.02, 0.03, 0.04]\n\
             hinge = {{ type = \"revolute\", {parent}axis = {axis:?}, position = {position:?}, velocity = {velocity:?} }}\n",
            2.0 + number(),
            0.1 * number(),
        );
        let acceleration = number();
        if i < DRIVES && acting & (1 << i) != 0 {
            let _ = write!(
                text,
                "[[drive]]\nname = \"d{i}\"\nhinge = \"b{i}\"\ntype = \"expression\"\n\
                 expression = \"({position:?}) + ({velocity:?})*t + ({acceleration:?})*t^2\"\n"
            );
        }
    }
    text + "[[gear]]\nname = \"pair\"\ntype = \"ratio\"\nratio = 2.0\nbetween = [\"b3\", \"b4\"]\n"
}

fn accelerations(mut system: System, q: &[f64], v: &[f64]) -> Vec<f64> {
    let mut a = vec![0.0; v.len()];
    system.at(0.0, q, v).accelerations(&mut a).expect("accelerations");
    a
}

/// What drives ask for at t = 0, of a model that has them all.
fn held(all: &Model, acting: usize) -> Vec<HeldRow> {
    let asked = |index: usize| {
        let drive = &all.drives[index];
        let at: Instant = drive.motion.at(0.0);
        HeldRow::Coordinate { coordinate: drive.coordinate, at }
    };
    (0..DRIVES).filter(|index| acting & (1 << index) != 0).map(asked).collect()
}

/// Of drives let go, and of coordinates held as drives would hold them, in every combination.
#[test]
fn modes_are_scenes_with_other_elements() {
    for seed in 0..60 {
        let of = |acting: usize| -> Arc<Model> { read(&scene(seed, acting)).1 };
        let (all, none) = (of((1 << DRIVES) - 1), of(0));
        let (q, v) = (&all.start_position, &all.start_velocity);
        for acting in 0..1 << DRIVES {
            let expected = accelerations(System::new(&of(acting)), q, v);
            let released = (0..DRIVES).filter(|index| acting & (1 << index) == 0).collect();
            let let_go = System::with_rows(&all, &RowSelection { released, ..RowSelection::default() }, 0.0, q);
            let holding =
                System::with_rows(&none, &RowSelection { held: held(&all, acting), ..RowSelection::default() }, 0.0, q);
            for (name, system) in [("let go", let_go), ("held", holding)] {
                let apart = relative_difference(&accelerations(system, q, v), &expected);
                // Round-off, grown by the condition of a chain of five bodies.
                assert!(apart < 1e-10, "seed {seed}, drives {acting:03b} {name}: {apart:e}");
            }
        }
    }
}
