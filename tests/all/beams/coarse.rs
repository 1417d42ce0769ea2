//! Beams whose elements turn by more than they are made for.

use super::statics::solve;
use crate::common::Random;
use stillpoint::constraint::assemble;
use stillpoint::model::Model;
use stillpoint::model::description::{
    BeamDescription, Description, ForceDescription, HingeDescription, Load, LoadAxes, Section,
};
use stillpoint::record::{Memory, Opening};
use stillpoint::simulate::{Settings, State, run, scene};
use stillpoint::statics::beams;

/// A cantilever of 100 m that hangs from its root, out of which the bending stiffness holds it over a length of `√(EI/w L)`.
fn floppy(young: f64, elements: usize) -> Description {
    let beam = BeamDescription::new("b", HingeDescription::fixed()).length(100.0).elements(elements);
    Description::new("Floppy").beam(beam.section(Section::Circle { radius: 0.005 }).material(young, 0.3, 1000.0))
}

/// What balances within elements that are wound up like springs is no equilibrium of the beam, and it says so with the elements and their
/// least number.
#[test]
fn elements_that_are_wound_up_are_no_beam() {
    let mut random = Random::new(1);
    for elements in [8, 16] {
        let (_, found) = solve(&floppy(10f64.powf(random.between(6.7, 7.5)), elements));
        assert!(!found.converged && !found.balanced && found.stability.is_none(), "{elements}: {:?}", found.notes);
        let said = found.notes.join("\n");
        assert!(said.contains("no equilibrium of the beam") && said.contains("`b/1`"), "{elements}: {said}");
        let needed = said.split("at least ").nth(1).and_then(|rest| rest.split(' ').next());
        let needed: usize = needed.and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("{said}"));
        assert!(needed > elements, "{needed} of {elements}");
    }
}

/// A hanging beam that its elements resolve is an equilibrium, and how many have an error of 1e-3 is known; with fewer the number that is
/// told is one that is not enough.
#[test]
fn the_number_of_elements_is_known_where_errors_fall_as_they_should() {
    let soft = |elements: usize| {
        let (model, found) = solve(&floppy(1e11, elements));
        (found.converged, beams(&model, &found).expect("finite").remove(0).error)
    };
    let (converged, resolved) = soft(400);
    assert!(converged && resolved.is_asymptotic(), "{resolved:?}");
    let (_, coarse) = soft(8);
    assert!(!coarse.is_asymptotic(), "{coarse:?}");
    let (_, advised) = soft(coarse.elements_for(1e-3) - 1);
    assert!(advised.forces > 1e-3, "{coarse:?} says {}: {advised:?}", coarse.elements_for(1e-3));
}

/// An arc of two elements that a couple closes to a circle of two halves: within 1.5 rad nothing is said, beyond it the elements are.
#[test]
fn turns_of_elements_are_told_beyond_one_and_a_half() {
    let bent = |turn: f64| {
        let rod = BeamDescription::new("rod", HingeDescription::fixed())
            .stiffness([1e4, 1e4, 1e4, 1.0, 1.0, 1.0])
            .mass_per_length(1.0)
            .elements(2);
        let couple = Load {
            on: ("rod", "tip").into(),
            force: [0.0; 3].into(),
            torque: [0.0, 0.0, 2.0 * turn].into(),
            axes: LoadAxes::Inertial,
            over_time: None,
        };
        let couple = ForceDescription { name: "couple".into(), kind: couple.into() };
        let (_, found) = solve(&Description::new("Arc").gravity([0.0; 3]).beam(rod).force(couple));
        assert!(found.balanced, "{:?}", found.notes);
        found.notes.join("\n")
    };
    assert!(!bent(1.4).contains("rad"), "{}", bent(1.4));
    let said = bent(1.6);
    assert!(said.contains("`rod/1` and `rod/2` turn by up to 1.6 rad") && said.contains("at least 3 "), "{said}");
}

/// A run says when the elements turned most.
#[test]
fn a_run_says_when_elements_turned_most() {
    let rod = BeamDescription::new("rod", HingeDescription::fixed())
        .stiffness([1e4, 1e4, 1e4, 1e-3, 1e-3, 1e-3])
        .mass_per_length(1.0)
        .elements(1);
    let model = Model::build(&Description::new("Falls").beam(rod)).expect("a sound scene");
    let (model, _) = assemble(model).expect("no loops");
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let settings = Settings { duration: 2.0, ..Settings::default() };
    let mut memory = Memory::new(&Opening { scene: &scene(&model), scenario: "", statics: None });
    let summary = run(&model, &settings, 100.0, &start, &mut memory, &mut |_, _| true).expect("it runs");
    let [(time, wound)] = &summary.wound[..] else { panic!("{:?}", summary.wound) };
    assert!(wound.turn > 1.5 && wound.elements == [1] && wound.needed > 1, "{wound:?} at {time}");
    assert!(*time > 0.0 && *time <= summary.end_time);
}
