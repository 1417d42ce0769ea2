//! What a beam must satisfy.

use super::{BeamDescription, BeamShape, MUCH_TURN, Material, Section};
use crate::budget::LARGEST;
use crate::model::description::{Description, ForceKind, GROUND, Slider};
use crate::model::problem::{Element, Problem, counted, number};
use crate::suggest;
use std::collections::HashSet;
use std::f64::consts::PI;

/// Elements of one beam, at most.
const MOST_ELEMENTS: usize = 10_000;

/// A step must not turn by more: there the expansion of eq. (3) of [`crate::element`] has no limit (Moan 2008: π).
const MOST_TURN: f64 = PI;

struct Findings<'a> {
    problems: &'a mut Vec<Problem>,
    element: Element,
}

impl Findings<'_> {
    fn add(&mut self, field: &str, message: String, help: &str) {
        let help = (!help.is_empty()).then(|| help.to_owned());
        self.problems.push(Problem { element: self.element, field: field.to_owned(), message, help });
    }

    /// Whether a number is positive and finite; else it is a problem.
    fn positive(&mut self, field: &str, what: &str, value: f64, unit: &str) -> bool {
        let sound = value > 0.0 && value <= LARGEST;
        if !sound {
            let help = format!("allowed: > 0 {unit}, up to {LARGEST:e}");
            self.add(field, format!("{what} is {}", number(value)), &help);
        }
        sound
    }
}

/// Problems of all beams by themselves.
pub(in crate::model) fn check(description: &Description) -> Vec<Problem> {
    let mut problems = Vec::new();
    let mut names: HashSet<&str> = description.bodies.iter().map(|body| body.name.as_str()).collect();
    for (index, beam) in description.beams.iter().enumerate() {
        let mut found = Findings { problems: &mut problems, element: Element::Beam(index) };
        check_name(&mut found, &mut names, &beam.name);
        if check_shape(&mut found, beam) && check_elements(&mut found, beam) && check_sections(&mut found, beam) {
            check_turn(&mut found, beam);
            check_start(&mut found, beam);
        }
        check_mass(&mut found, beam);
        check_rest(&mut found, beam);
    }
    check_sliders(description, &mut problems);
    problems
}

/// What slides along a beam names one.
fn check_sliders(description: &Description, problems: &mut Vec<Problem>) {
    for (index, force) in description.forces.iter().enumerate() {
        let ForceKind::Slider(Slider { along, .. }) = &force.kind else { continue };
        let names = || description.beams.iter().map(|beam| beam.name.as_str());
        if !names().any(|name| name == along) {
            let near = suggest::closest_of_many(problems.len(), along, names());
            problems.push(Problem {
                element: Element::Force(index),
                field: "along".to_owned(),
                message: format!("there is no beam or cable `{along}`"),
                help: Some(near.map_or_else(
                    || "what is guided along a rigid body has a hinge of type `along`".to_owned(),
                    |near| format!("did you mean `{near}`?"),
                )),
            });
        }
    }
}

fn check_start(found: &mut Findings<'_>, beam: &BeamDescription) {
    for (field, list) in [("strains", &beam.strains), ("strain_rates", &beam.strain_rates)] {
        if list.is_empty() {
            continue;
        }
        let (name, what) = (&beam.name, field.replace('_', " "));
        let count = beam.strain_count();
        if list.len() != count {
            let message = format!("`{name}` has {count} coordinates of strains, not {}", list.len());
            found.add(field, message, "as many as its elements have, from the root to the tip");
        } else if let Some(wrong) = list.iter().find(|x| !(x.abs() <= LARGEST)) {
            found.add(field, format!("the {what} of `{name}` have {}", number(*wrong)), "give finite numbers");
        }
    }
}

/// `taken`: the names of bodies, and of the beams before.
fn check_name<'d>(found: &mut Findings<'_>, taken: &mut HashSet<&'d str>, name: &'d str) {
    if name.is_empty() || name == GROUND || name.contains('/') {
        found.add("name", format!("a beam cannot be called `{name}`"), "any other name without `/`");
    }
    if !taken.insert(name) {
        found.add("name", format!("two bodies or beams are called `{name}`"), "names must be unique");
    }
}

fn check_shape(found: &mut Findings<'_>, beam: &BeamDescription) -> bool {
    let name = &beam.name;
    let positive = match beam.shape {
        BeamShape::Points(_) => true,
        BeamShape::Straight { length } => found.positive("length", &format!("the length of `{name}`"), length, "m"),
        BeamShape::Arc { radius, angle } => {
            let sound = found.positive("curve.arc", &format!("the radius of the arc of `{name}`"), radius, "m");
            if !(angle != 0.0 && angle.is_finite()) {
                found.add("curve.arc", format!("the angle of the arc of `{name}` is {angle}"), "give rad, not zero");
            }
            sound && angle != 0.0 && angle.is_finite()
        }
        BeamShape::Helix { radius, pitch, turns } => {
            let what = |part: &str| format!("the {part} of the helix of `{name}`");
            let sound = found.positive("curve.helix", &what("radius"), radius, "m")
                & found.positive("curve.helix", &what("number of turns"), turns, "");
            if !pitch.is_finite() {
                found.add("curve.helix", format!("{} is {pitch}", what("pitch")), "give finite m");
            }
            sound && pitch.is_finite()
        }
    };
    if !beam.twist.is_finite() {
        found.add("twist", format!("the twist of `{name}` is {}", beam.twist), "give finite rad");
    }
    positive && beam.twist.is_finite()
}

fn check_elements(found: &mut Findings<'_>, beam: &BeamDescription) -> bool {
    let name = &beam.name;
    if beam.elements == 0 || beam.elements > MOST_ELEMENTS {
        let message = format!("`{name}` has {}", counted(beam.elements, "element", "elements"));
        found.add("elements", message, &format!("allowed: 1 … {MOST_ELEMENTS}"));
        return false;
    }
    if beam.degree > 2 {
        found.add("degree", format!("the degree of the strains of `{name}` is {}", beam.degree), "allowed: 0, 1, 2");
        return false;
    }
    if beam.free.indices().is_empty() {
        let help = "give at least one of \"bend\", \"twist\", \"stretch\", \"shear\"; a rigid bar is a [[body]]";
        found.add("free", format!("`{name}` has no free strain"), help);
        return false;
    }
    true
}

fn check_sections(found: &mut Findings<'_>, beam: &BeamDescription) -> bool {
    let (name, before) = (&beam.name, found.problems.len());
    if beam.sections.is_empty() {
        let help = "give `section` = { circle = r }, { tube = [outer, inner] }, { rectangle = [width, height] } or { stiffness = […] }";
        found.add("section", format!("`{name}` has no section"), help);
    }
    for (_, section) in &beam.sections {
        check_section(found, beam, section);
    }
    if beam.sections.windows(2).any(|pair| !(pair[0].0 < pair[1].0)) {
        found.add("section", format!("the sections of `{name}` are not in the order of their `s`"), "ascending, in m");
    }
    let length = known_length(beam);
    if let Some((s, _)) = beam.sections.iter().find(|(s, _)| !(0.0..=length * (1.0 + 1e-9)).contains(s)) {
        found.add(
            "section",
            format!("a section of `{name}` is at s = {s}"),
            &format!("allowed: 0 … {} m", number(length)),
        );
    }
    if beam.sections.windows(2).any(|pair| pair[0].1.between(&pair[1].1, 0.5).is_none()) {
        let message = format!("the sections of `{name}` are of several kinds");
        found.add("section", message, "give all as one kind: between two kinds there is nothing to interpolate");
    }
    found.problems.len() == before
}

fn check_section(found: &mut Findings<'_>, beam: &BeamDescription, section: &Section) {
    let name = &beam.name;
    match *section {
        Section::Circle { radius } => {
            found.positive("section.circle", &format!("the radius of the section of `{name}`"), radius, "m");
        }
        Section::Tube { outer, inner } => {
            let sound = found.positive("section.tube", &format!("the outer radius of `{name}`"), outer, "m");
            if sound && !(inner >= 0.0 && inner < outer) {
                let message = format!("the inner radius of `{name}` is {}", number(inner));
                found.add(
                    "section.tube",
                    message,
                    &format!("allowed: 0 … less than the outer one, {} m", number(outer)),
                );
            }
        }
        Section::Rectangle { width, height } => {
            for (what, size) in [("width", width), ("height", height)] {
                found.positive("section.rectangle", &format!("the {what} of the section of `{name}`"), size, "m");
            }
        }
        Section::Stiffness(stiffness) => {
            if !stiffness.iter().all(|x| x.abs() <= LARGEST) {
                let message = format!("a stiffness of `{name}` is not finite, or too large");
                found.add("section.stiffness", message, &format!("up to {LARGEST:e}"));
            } else if (stiffness - stiffness.transpose()).amax() > 1e-9 * stiffness.amax() {
                found.add("section.stiffness", format!("the stiffness of `{name}` is not symmetric"), "");
            } else if stiffness.cholesky().is_none() {
                let eigen = stiffness.symmetric_eigenvalues();
                let message = format!(
                    "the stiffness of `{name}` is not positive definite: least eigenvalue {}",
                    number(eigen.min())
                );
                found.add("section.stiffness", message, "[EA, GA_y, GA_z, GJ, EI_y, EI_z], all > 0");
            }
        }
    }
}

fn check_mass(found: &mut Findings<'_>, beam: &BeamDescription) {
    let name = &beam.name;
    if let Some(Material { young, poisson, density }) = beam.material {
        found.positive("material.young", &format!("Young's modulus of `{name}`"), young, "Pa");
        found.positive("material.density", &format!("the density of `{name}`"), density, "kg/m³");
        if !(poisson > -1.0 && poisson <= 0.5) {
            let message = format!("Poisson's ratio of `{name}` is {}", number(poisson));
            found.add("material.poisson", message, "allowed: above −1 (where no shear is resisted) up to 0.5");
        }
    }
    if let Some(mass) = beam.mass_per_length {
        found.positive("mass_per_length", &format!("the mass per length of `{name}`"), mass, "kg/m");
    }
    if let Some(rotary) = beam.rotary
        && !rotary.iter().all(|x| *x >= 0.0 && *x <= LARGEST)
    {
        found.add("rotary", format!("the rotary inertia of `{name}` is {:?}", rotary.as_slice()), "allowed: ≥ 0 kg m");
    }
    let sized = beam.sections.iter().any(|(_, section)| !matches!(section, Section::Stiffness(_)));
    if sized && beam.material.is_none() {
        let help = "give `material` = { young, poisson, density }, or `section` = { stiffness = […] }";
        found.add("material", format!("the section of `{name}` has a size but no material"), help);
    } else if !sized && !beam.sections.is_empty() && beam.mass_per_length.is_none() {
        let help = "a stiffness says nothing of mass: give `mass_per_length` in kg/m";
        found.add("mass_per_length", format!("`{name}` has no mass"), help);
    }
}

/// Its length (m); without limit as long as a cable has still to get one from its tension.
fn known_length(beam: &BeamDescription) -> f64 {
    let is_open = beam.far.as_ref().is_some_and(|far| far.pretension.is_some());
    if is_open { f64::INFINITY } else { beam.shape.length() }
}

fn check_rest(found: &mut Findings<'_>, beam: &BeamDescription) {
    let (name, length) = (&beam.name, known_length(beam));
    if let Some(bending) = beam.bending
        && !(0.0..=LARGEST).contains(&bending)
    {
        found.add("bending", format!("the bending stiffness of `{name}` is {}", number(bending)), "allowed: ≥ 0 N m²");
    }
    if let Some(tension) = beam.far.as_ref().and_then(|far| far.pretension) {
        found.positive("pretension", &format!("the pretension of `{name}`"), tension, "N");
    }
    if !(beam.damping >= 0.0 && beam.damping <= LARGEST) {
        found.add("damping", format!("the damping of `{name}` is {}", number(beam.damping)), "allowed: ≥ 0 s");
    }
    for (marker, at) in &beam.markers {
        let field = format!("markers.{marker}");
        if matches!(marker.as_str(), "tip" | "root") {
            found.add(&field, format!("a marker of `{name}` is called `{marker}`"), "every beam has one of that name");
        } else if !(*at > 0.0 && *at <= length * (1.0 + 1e-9)) {
            let message = format!("marker `{marker}` of `{name}` is at s = {}", number(*at));
            found.add(&field, message, &format!("allowed: above 0 … {} m, along the unstrained beam", number(length)));
        }
    }
    if let Some(load) = &beam.load
        && !load.force.iter().all(|x| x.abs() <= LARGEST)
    {
        found.add("load.force", format!("the load of `{name}` is {:?}", load.force.as_slice()), "give finite N/m");
    }
}

fn check_turn(found: &mut Findings<'_>, beam: &BeamDescription) {
    let per_element = beam.most_turn();
    if per_element > MOST_TURN {
        let needed = (per_element * beam.elements as f64 / MUCH_TURN).ceil();
        let message = format!("`{}` turns by {} rad in an element", beam.name, number(per_element));
        found.add("elements", message, &format!("allowed: up to π, advised: {MUCH_TURN}; {needed} elements give that"));
        return;
    }
    let (strays, length) = (beam.strays(), beam.shape.length());
    if strays > BeamDescription::MOST_STRAY * length {
        let message = format!("the elements of `{}` stray from its points by {} m", beam.name, number(strays));
        found.add("curve.points", message, "more elements, or points without such bends");
    }
}
