//! What a description must satisfy element by element. Names and the tree are checked where they are resolved.

use super::burn;
use super::description::{
    AlongTurn, BodyDescription, Description, ForceDescription, GROUND, HingeKind, MassProperties, Point,
};
use super::problem::{Element, Problem, counted, number};
use crate::budget::LARGEST;
use crate::element::guide::Guide;
use crate::force::{Describe, Report};
use crate::round_off::WRITTEN;
use nalgebra::{SymmetricEigen, UnitQuaternion, Vector3};

/// How far a quaternion's norm may be from one: files carry at least six digits.
const QUATERNION_SLACK: f64 = 1e-6;

/// All problems of single elements.
pub(super) fn check(description: &Description) -> Vec<Problem> {
    let mut found = Findings { problems: Vec::new() };
    if description.bodies.is_empty() && description.beams.is_empty() {
        found.add(Element::Scene, "body", "the scene has no bodies".to_owned(), "add at least one [[body]]");
    }
    if !finite(&description.gravity) {
        found.add(Element::Scene, "gravity", format!("gravity is {}", list(&description.gravity)), "give finite m/s²");
    }
    for (index, body) in description.bodies.iter().enumerate() {
        check_body(&mut found, index, body);
        // What burns is checked row by row of its table.
        if !description.burns.iter().any(|burn| burn.body == body.name) {
            let unphysical = description.unphysical.contains(&body.name);
            check_mass(&mut found, Element::Body(index), &body.name, &body.mass, unphysical);
        }
    }
    for (index, force) in description.forces.iter().enumerate() {
        check_force(&mut found, index, force);
    }
    let mut rows = Findings { problems: Vec::new() };
    found.problems.extend(burn::check(description, &mut |index, row| {
        let (body, given) = (&description.bodies[index].name, rows.problems.len());
        let unphysical = description.unphysical.contains(body);
        check_mass(&mut rows, Element::Body(index), body, row, unphysical);
        for problem in rows.problems.split_off(given) {
            let (element, field) = (problem.element, format!("burn.{}", problem.field));
            // The first row that is wrong stands for all.
            if !rows.problems.iter().any(|other| (other.element, &other.field) == (element, &field)) {
                rows.problems.push(Problem { field, ..problem });
            }
        }
    }));
    found.problems.extend(rows.problems);
    found.problems
}

struct Findings {
    problems: Vec<Problem>,
}

impl Findings {
    fn add(&mut self, element: Element, field: &str, message: String, help: &str) {
        let help = (!help.is_empty()).then(|| help.to_owned());
        self.problems.push(Problem { element, field: field.to_owned(), message, help });
    }
}

fn check_body(found: &mut Findings, index: usize, body: &BodyDescription) {
    let element = Element::Body(index);
    let name = &body.name;
    if name.is_empty() {
        found.add(element, "name", "a body's name is empty".to_owned(), "");
    } else if name == GROUND {
        let help = "that is the inertial frame; a model that is read can be given a `prefix`";
        found.add(element, "name", format!("a body cannot be called `{GROUND}`"), help);
    }
    for (marker, at) in &body.markers {
        if !finite(at) {
            let message = format!("marker `{marker}` of `{name}` is {}", list(at));
            found.add(element, &format!("markers.{marker}"), message, "give finite coordinates in m");
        }
    }
    check_hinge(found, element, body);
}

fn check_mass(found: &mut Findings, element: Element, name: &str, mass: &MassProperties, unphysical: bool) {
    if !within(mass.mass) || mass.mass < 0.0 {
        let help = format!("allowed: ≥ 0 kg, up to {LARGEST:e}");
        found.add(element, "mass", format!("the mass of `{name}` is {}", mass.mass), &help);
        return;
    }
    if !finite(&mass.center) {
        let message = format!("the centre of mass of `{name}` is {}", list(&mass.center));
        found.add(element, "center", message, "give finite coordinates in m");
    }
    if !mass.inertia.iter().all(|x| within(*x)) {
        let help = format!("give kg m² up to {LARGEST:e}");
        found.add(element, "inertia", format!("the inertia of `{name}` is not finite, or too large"), &help);
        return;
    }
    if (mass.inertia - mass.inertia.transpose()).amax() > WRITTEN.of(mass.inertia.amax()) {
        found.add(element, "inertia", format!("the inertia of `{name}` is not symmetric"), "xy = yx, xz = zx, yz = zy");
        return;
    }
    let mut moments: Vec<f64> = SymmetricEigen::new(mass.inertia).eigenvalues.iter().copied().collect();
    moments.sort_by(f64::total_cmp);
    let (small, middle, large) = (moments[0], moments[1], moments[2]);
    let shown = || format!("principal moments {}, {}, {} kg m²", number(small), number(middle), number(large));
    if !unphysical && small < -WRITTEN.of(large.abs().max(f64::MIN_POSITIVE)) {
        let message = format!("the inertia of `{name}` has a negative principal moment: {}", shown());
        found.add(element, "inertia", message, "");
    } else if !unphysical && large > WRITTEN.above(small + middle) {
        let short = 100.0 * (large - small - middle) / large;
        let message = format!(
            "no body can have the inertia of `{name}`: the sum of its two smaller principal moments falls short of the largest by \
             {short:.3} % ({})",
            shown()
        );
        let help = "inertia is about the centre of mass, in body axes; a flat body sits exactly on the limit";
        found.add(element, "inertia", message, help);
    }
    if !unphysical && mass.mass == 0.0 && large > 0.0 {
        let message = format!("`{name}` has inertia but no mass");
        found.add(element, "mass", message, "for a rotor's inertia in a hinge use `armature`");
    }
}

fn check_hinge(found: &mut Findings, element: Element, body: &BodyDescription) {
    let (name, hinge) = (&body.name, &body.hinge);
    let (positions, velocities) = hinge.kind.counts();
    hinge.kind.check(&format!("hinge of `{name}`"), &mut |key, message, help| {
        found.add(element, &format!("hinge.{key}"), message, help);
    });
    match (&hinge.curve, hinge.kind) {
        (Some(curve), HingeKind::Along { turn }) => {
            let at = hinge.position.first().copied().unwrap_or(0.0);
            match Guide::new(curve, turn != AlongTurn::Held).map(|guide| guide.range()) {
                Err(flaw) => {
                    let message = format!("the curve of the hinge of `{name}` {}", flaw.message);
                    found.add(element, &format!("hinge.curve.{}", flaw.key), message, flaw.help);
                }
                Ok([from, to]) if at < from || at > to => {
                    let message = format!("`{name}` is at an arc length of {at} m, beyond its curve");
                    let help = format!("the curve goes from {from} m to {to} m");
                    found.add(element, "hinge.position", message, &help);
                }
                Ok(_) => {}
            }
        }
        (None, HingeKind::Along { .. }) => {
            found.add(element, "hinge", format!("the hinge of `{name}` has no curve"), "give `curve`");
        }
        (Some(_), kind) => {
            let message = format!("the {} hinge of `{name}` has a curve", kind.name());
            found.add(element, "hinge", message, "only `along` has one");
        }
        (None, _) => {}
    }
    if let Point::At(at) = &hinge.at
        && !finite(at)
    {
        found.add(element, "hinge.at", format!("the hinge of `{name}` is at {}", list(at)), "give finite m");
    }
    if !is_turn(&hinge.frame) {
        found.add(element, "hinge.rpy", format!("the hinge frame of `{name}` is not a turn"), "give finite angles");
    }
    let lists: [(&str, &[f64], usize, f64); 7] = [
        ("position", &hinge.position, positions, f64::NEG_INFINITY),
        ("velocity", &hinge.velocity, velocities, f64::NEG_INFINITY),
        ("stiffness", &hinge.stiffness, velocities, f64::NEG_INFINITY),
        ("damping", &hinge.damping, velocities, 0.0),
        ("rest", &hinge.rest, positions, f64::NEG_INFINITY),
        ("armature", &hinge.armature, velocities, 0.0),
        ("force", &hinge.force, velocities, f64::NEG_INFINITY),
    ];
    for (field, values, count, least) in lists {
        let path = format!("hinge.{field}");
        if !values.is_empty() && values.len() != count {
            let message = format!(
                "`{field}` of the {} hinge of `{name}` has {}, {}",
                hinge.kind.name(),
                counted(values.len(), "number", "numbers"),
                counted(count, "is needed", "are needed")
            );
            found.add(element, &path, message, "");
        } else if let Some(bad) = values.iter().find(|x| !within(**x) || **x < least) {
            let allowed = if least == 0.0 { "finite numbers ≥ 0" } else { "finite numbers" };
            let help = format!("allowed: {allowed}, up to {LARGEST:e} in size");
            found.add(element, &path, format!("`{field}` of the hinge of `{name}` is {bad}"), &help);
        } else if matches!(field, "position" | "rest") {
            check_quaternion(found, element, name, &path, &hinge.kind, values);
        }
    }
}

fn check_quaternion(found: &mut Findings, element: Element, name: &str, path: &str, kind: &HingeKind, values: &[f64]) {
    let plain = kind.plain_coordinates();
    let Some(quaternion @ [_, ..]) = values.get(plain..) else { return };
    let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    if (norm - 1.0).abs() > QUATERNION_SLACK {
        let message = format!("the quaternion of the hinge of `{name}` has norm {norm}");
        found.add(element, path, message, "a unit quaternion w, x, y, z is needed; no turn is 1, 0, 0, 0");
    }
}

fn check_force(found: &mut Findings, index: usize, force: &ForceDescription) {
    let mut report = Report { name: &force.name, found: Vec::new() };
    force.kind.check(&mut report);
    found.problems.extend(report.found.into_iter().map(|flaw| Problem::of_force(index, flaw)));
}

fn is_turn(frame: &UnitQuaternion<f64>) -> bool {
    (frame.norm() - 1.0).abs() <= QUATERNION_SLACK
}

fn finite(v: &Vector3<f64>) -> bool {
    v.iter().all(|x| within(*x))
}

/// Whether the square of a number stays finite.
fn within(x: f64) -> bool {
    x.abs() <= LARGEST
}

fn list(v: &Vector3<f64>) -> String {
    format!("[{}, {}, {}]", v.x, v.y, v.z)
}
