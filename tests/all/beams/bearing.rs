//! What beams bear: stress, diagrams, and how far both are from exact, against closed forms.

use super::statics::{case, expected, solve};
use crate::common::build;
use std::f64::consts::PI;
use std::sync::Arc;
use stillpoint::dynamics::{BeamState, SectionForces};
use stillpoint::model::Model;
use stillpoint::model::description::{
    BeamDescription, Description, ForceDescription, HingeDescription, Load, LoadAxes, Section,
};
use stillpoint::scenario;
use stillpoint::statics::{Equilibrium, Settings, Want, beams, diagrams, equilibrium, outputs};

/// A steel cantilever of 1 m.
fn cantilever(section: Section) -> BeamDescription {
    BeamDescription::new("arm", HingeDescription::fixed()).section(section).material(210e9, 0.3, 7850.0)
}

fn weightless(beam: BeamDescription) -> Description {
    Description::new("Arm").gravity([0.0; 3]).beam(beam)
}

fn borne(description: &Description) -> (Arc<Model>, Equilibrium, BeamState) {
    let (model, found) = solve(description);
    assert!(found.converged, "{:?}", found.notes);
    let state = beams(&model, &found).expect("finite").remove(0);
    (model, found, state)
}

/// A rod that is bent and twisted at its end by couples bears √(M² + ¾ T²) r/I in every section (Guest, von Mises).
#[test]
fn couples_stress_a_rod() {
    let couple = Load {
        on: ("arm", "tip").into(),
        force: [0.0; 3].into(),
        torque: [3.0, 0.4, -0.3].into(),
        axes: LoadAxes::Body,
        over_time: None,
    };
    let couple = ForceDescription { name: "couple".into(), kind: couple.into() };
    let description = weightless(cantilever(Section::Circle { radius: 0.01 })).force(couple);
    // Nothing damps what a couple that follows the tip sets in motion: whether it stays there is another question.
    let model = Model::build(&description).expect("a sound scene");
    let settings = Settings { want: Want::Any, ..Settings::default() };
    let found = equilibrium(&model, &settings, &model.start_position).expect("no fault");
    assert!(found.converged, "{:?}", found.notes);
    let state = beams(&model, &found).expect("finite").remove(0);
    let exact = (0.25_f64 + 0.75 * 9.0).sqrt() * 0.01 / (PI / 4.0 * 1e-8);
    let (_, stress) = state.stress.expect("a size");
    // The couple follows the tip; along the rod it is the same vector in axes that bend away from it by M L/EI.
    let bent = 0.5 / (210e9 * PI / 4.0 * 1e-8);
    assert!((stress.von_mises / exact - 1.0).abs() < bent, "{stress:?} and not {exact}");
}

/// The largest stress of a tapered arm under a load at its tip is not at its root: if the radius is that of the tip times 1 + 2 x at x from
/// it, stress goes with x/(1 + 2 x)³ and is largest at x = L/4, whichever elements there are.
#[test]
fn a_tapered_arm_is_stressed_most_within() {
    let (tip, load) = (0.01, 1.0);
    for elements in [7, 8] {
        let mut arm = cantilever(Section::Circle { radius: 0.03 }).elements(elements);
        arm.sections = vec![(0.0, Section::Circle { radius: 0.03 }), (1.0, Section::Circle { radius: tip })];
        let description = weightless(arm).force(ForceDescription::load("weight", ("arm", "tip"), [0.0, 0.0, -load]));
        let (_, _, state) = borne(&description);
        let (s, stress) = state.stress.expect("a size");
        // σ = 4 P x/(π r³)
        let exact = 4.0 * load * 0.25 / (PI * (1.5 * tip).powi(3));
        // Sections a tenth of an element apart: within a twentieth of the place, where the stress is flat.
        assert!((s - 0.75).abs() < 0.05 / elements as f64 + 1e-12, "{elements}: at {s}");
        assert!((stress.von_mises / exact - 1.0).abs() < 1e-3, "{elements}: {} and not {exact}", stress.von_mises);
    }
}

/// A diagram of an arm with its weight and a load at a quarter: shear and moment by hand, with the jump at the load, and by the strains the
/// same at the ends of elements, as far as the elements can.
#[test]
fn a_diagram_is_that_of_the_books() {
    let arm = cantilever(Section::Tube { outer: 0.04, inner: 0.03 }).marker("lug", 0.25);
    let weight = 7850.0 * PI * (0.04_f64.powi(2) - 0.03_f64.powi(2)) * 10.0;
    let load = ForceDescription::load("load", ("arm", "lug"), [0.0, 0.0, -30.0]);
    let description = Description::new("Arm").gravity([0.0, 0.0, -10.0]).beam(arm).force(load);
    let (model, found, state) = borne(&description);
    let points = diagrams(&model, &found, &[0], 4).expect("finite").remove(0);
    assert_eq!(points.len(), 8 * 5);
    for point in &points {
        let SectionForces { s, forces, .. } = point.section;
        let before = if point.element < 2 { 1.0 } else { 0.0 };
        let shear = -weight * (1.0 - s) - 30.0 * before;
        let moment = weight * (1.0 - s).powi(2) / 2.0 + 30.0 * before * (0.25 - s);
        // It sags by half a millimetre.
        assert!((forces[2] - shear).abs() < 1e-5 * weight, "shear {} and not {shear} at {s}", forces[2]);
        assert!((forces[4] - moment).abs() < 1e-5 * weight, "moment {} and not {moment} at {s}", forces[4]);
        // The error is told in parts of the largest force by the length, which is more than the largest moment here.
        let most = 1.001 * state.error.forces * (weight + 30.0);
        let off = (point.by_strains[4] - forces[4]).abs();
        assert!(point.by_strains[2].is_nan() && off <= most, "{off} at {s}, at most {most} told");
    }
}

/// The elastica: both estimates are of the size of what they estimate, and as many elements as are advised bring the section forces as
/// near as was asked.
#[test]
fn the_error_is_as_estimated() {
    let (value, _) = expected(&case("elastica_tip_force"), 2);
    let at = |elements: usize| {
        let rod = BeamDescription::new("rod", HingeDescription::fixed())
            .stiffness([1e4, 1e4, 1e4, 1.0, 1.0, 1.0])
            .mass_per_length(1.0)
            .elements(elements);
        let load = ForceDescription::load("tip", ("rod", "tip"), [0.0, 5.0, 0.0]);
        let (_, _, state) = borne(&weightless(rod).force(load));
        let tip = state.tip.translation.vector;
        (state.error, (tip.y / value[1] - 1.0).abs())
    };
    for elements in [2, 4, 8] {
        let (error, off) = at(elements);
        // Largely bent rods are no longer what the estimate is exact for.
        let ratio = error.deflections / off;
        assert!((0.2..5.0).contains(&ratio), "{elements}: estimated {}, found {off}", error.deflections);
        let (advised, _) = at(error.elements_for(1e-3));
        assert!(
            (0.4e-3..1.2e-3).contains(&advised.forces),
            "{elements}: {} with {advised:?}",
            error.elements_for(1e-3)
        );
    }
}

/// The stress of a section as an output, and that one without a size has none.
#[test]
fn stress_is_an_output() {
    let text = |section: &str| {
        format!(
            "gravity = [0.0, 0.0, 0.0]\n[[beam]]\nname = \"arm\"\nhinge = {{ type = \"fixed\" }}\nlength = 1.0\n{section}\n\
             [[force]]\ntype = \"load\"\non = \"arm.tip\"\nforce = [2.0, 0.0, 0.0]\n\
             [[output]]\nname = \"stress\"\ntype = \"section\"\nof = \"arm\"\ns = 0.3\ncomponent = \"stress\"\n"
        )
    };
    let sized = text("section = { rectangle = [0.02, 0.01] }\nmaterial = { young = 70e9, density = 2700.0 }");
    let scenario = scenario::parse("arm.toml", &sized, &[]).unwrap_or_else(|found| panic!("{found}"));
    let (model, found) = solve(&scenario.description);
    assert_eq!(model.outputs[0].units, ["Pa"]);
    let drawn = outputs(&model, &found).expect("finite")[0];
    assert!((drawn / 1e4 - 1.0).abs() < 1e-9, "{drawn} and not 2 N on 200 mm²");

    let bare = text("section = { stiffness = [1e4, 1e4, 1e4, 1.0, 1.0, 1.0] }\nmass_per_length = 1.0");
    let scenario = scenario::parse("arm.toml", &bare, &[]);
    let told = match scenario {
        Err(found) => found.to_string(),
        Ok(scenario) => format!("{:?}", Model::build(&scenario.description).expect_err("no size")),
    };
    assert!(told.contains("has a stiffness and no size"), "{told}");
    assert!(build(&weightless(cantilever(Section::Circle { radius: 0.1 }))).outputs.is_empty());
}
