//! Contact of bodies and dry friction of hinges: what the description says, its checks, and what is compiled of it.

use super::Body;
use super::description::{BodyDescription, Description};
use super::problem::{Element, Problem, counted};
use crate::suggest;

/// Dry friction by Coulomb's law: what holds at rest, and what opposes motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DryFriction {
    /// Largest friction at rest: a coefficient between bodies; N or N m in a hinge.
    pub stick: f64,
    /// Friction in motion, 0 … `stick`.
    pub slide: f64,
}

impl DryFriction {
    /// Friction that is as large in motion as at rest.
    pub fn new(friction: f64) -> Self {
        Self { stick: friction, slide: friction }
    }
}

/// Bodies that cannot pass through each other.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactDescription {
    /// Unique name.
    pub name: String,
    /// Two names of bodies, or patterns in which `*` stands for any text.
    pub between: [String; 2],
    /// Coefficients of friction, ≥ 0.
    pub friction: DryFriction,
    /// What happens when they strike each other.
    pub law: super::StopLaw,
}

/// Dry friction of a hinge, compiled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HingeFriction {
    /// Index of the body whose hinge it is.
    pub body: usize,
    /// First index into the velocity vector.
    pub velocity: usize,
    /// Velocity coordinates that it bounds together: 3 for the angular velocity of a spherical hinge, else 1.
    pub count: usize,
    /// Friction (N or N m).
    pub friction: DryFriction,
}

/// What may touch what, compiled: the last rule that names a pair counts.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactRule {
    /// Name.
    pub name: String,
    /// Indices of the bodies on both sides, ascending.
    pub bodies: [Vec<usize>; 2],
    /// Whether both sides are names, not patterns: only then a body touches the one that it hangs on.
    pub named: bool,
    /// Coefficients of friction.
    pub friction: DryFriction,
    /// What happens when they strike each other.
    pub law: super::StopLaw,
}

/// Whether a name fits a pattern in which `*` stands for any text.
pub fn fits(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or_default();
    let Some(mut rest) = name.strip_prefix(first) else { return false };
    let mut last = None;
    for part in parts {
        last = Some(part);
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    match last {
        None => rest.is_empty(),
        // The last part has to end the name, wherever it was found first.
        Some(last) => name[first.len()..].ends_with(last),
    }
}

/// The problems of all contacts and of friction in hinges.
pub(super) fn check(description: &Description) -> Vec<Problem> {
    let mut problems = Vec::new();
    for (index, body) in description.bodies.iter().enumerate() {
        problems.extend(body.hinge.friction.iter().find_map(|friction| {
            let (message, help) = wrong(friction, &format!("the friction of the hinge of `{}`", body.name))?;
            let (element, field) = (Element::Body(index), "hinge.friction".to_owned());
            Some(Problem { element, field, message, help: Some(help) })
        }));
    }
    problems.extend(description.bodies.iter().enumerate().filter_map(|(index, body)| {
        let (found, most) = (body.hinge.friction.len(), body.hinge.kind.counts().1);
        let message = format!(
            "the hinge of `{}` has {} and {} of friction",
            body.name,
            counted(most, "velocity", "velocities"),
            counted(found, "value", "values")
        );
        let (element, field) = (Element::Body(index), "hinge.friction".to_owned());
        (found > most).then_some(Problem { element, field, message, help: None })
    }));
    for (index, contact) in description.contacts.iter().enumerate() {
        let mut add = |field: &str, message: String, help: Option<String>| {
            let (element, field) = (Element::Contact(index), field.to_owned());
            problems.push(Problem { element, field, message, help });
        };
        if description.contacts[..index].iter().any(|other| other.name == contact.name) {
            let message = format!("two contacts are called `{}`", contact.name);
            add("name", message, Some("names must be unique".to_owned()));
        }
        if let Some((message, help)) = wrong(&contact.friction, &format!("the friction of contact `{}`", contact.name))
        {
            add("friction", message, Some(help));
        }
        let compliant = matches!(contact.law, super::StopLaw::Compliant { .. });
        if compliant && contact.friction.stick > 0.0 {
            let message = format!("contact `{}` is compliant, and has friction", contact.name);
            let help = "compliant contact has no friction yet: leave out `friction` or `stiffness`";
            add("friction", message, Some(help.to_owned()));
        }
        for (side, pattern) in contact.between.iter().enumerate() {
            let field = format!("between[{side}]");
            let fitting: Vec<&BodyDescription> =
                description.bodies.iter().filter(|body| fits(pattern, &body.name)).collect();
            if fitting.is_empty() {
                let known = description.bodies.iter().map(|body| body.name.as_str());
                let near = suggest::closest_of_many(index, pattern, known);
                let message = format!("no body is called `{pattern}`");
                let help = near.map_or_else(
                    || "a name of a body, or a pattern in which `*` stands for any text".to_owned(),
                    |near| format!("did you mean `{near}`?"),
                );
                add(&field, message, Some(help));
            } else if !fitting.iter().any(|body| body.shapes.iter().any(|shape| shape.collides)) {
                let message = format!("no body that fits `{pattern}` has a shape that can touch anything");
                add(&field, message, Some("give it a `shape`, without `contact = false`".to_owned()));
            }
        }
        if let [one, other] = &contact.between
            && one == other
            && !one.contains('*')
        {
            let message = format!("contact `{}` is between `{one}` and itself", contact.name);
            add("between", message, Some("name two bodies, or a pattern that fits several".to_owned()));
        }
    }
    problems
}

/// What is wrong with two coefficients, and what is allowed.
fn wrong(friction: &DryFriction, of: &str) -> Option<(String, String)> {
    let DryFriction { stick, slide } = *friction;
    let fine = stick >= 0.0 && stick.is_finite() && slide >= 0.0 && slide <= stick;
    let help = "allowed: 0 ≤ `slide` ≤ `stick`, finite".to_owned();
    (!fine).then(|| (format!("{of} is {stick} at rest and {slide} in motion"), help))
}

/// The hinges with dry friction of a scene without problems.
pub(super) fn hinge_friction(description: &Description, bodies: &[Body]) -> Vec<HingeFriction> {
    let of_body = |(body, (written, built)): (usize, (&BodyDescription, &Body))| {
        let kind = written.hinge.kind;
        let (scalars, velocities) = (kind.plain_coordinates(), kind.counts().1);
        let of_coordinate = move |(i, friction): (usize, &DryFriction)| {
            let count = if i < scalars { 1 } else { velocities - scalars };
            HingeFriction { body, velocity: built.hinge.velocity + i, count, friction: *friction }
        };
        // The angular velocity of a ball has one bound: its first.
        let list = &written.hinge.friction[..written.hinge.friction.len().min(scalars + 1)];
        list.iter().enumerate().map(of_coordinate).filter(|one| one.friction.stick > 0.0).collect::<Vec<_>>()
    };
    description.bodies.iter().zip(bodies).enumerate().flat_map(of_body).collect()
}

/// The contacts of a scene without problems.
pub(super) fn rules(description: &Description) -> Vec<ContactRule> {
    let rule = |contact: &ContactDescription| ContactRule {
        name: contact.name.clone(),
        bodies: [0, 1].map(|side| {
            let fitting = description.bodies.iter().enumerate();
            fitting.filter(|(_, body)| fits(&contact.between[side], &body.name)).map(|(index, _)| index).collect()
        }),
        named: contact.between.iter().all(|pattern| !pattern.contains('*')),
        friction: contact.friction,
        law: contact.law,
    };
    description.contacts.iter().map(rule).collect()
}

#[cfg(test)]
mod tests {
    use super::fits;

    #[test]
    fn stars_stand_for_any_text() {
        for (pattern, name) in [
            ("*", "floor"),
            ("crate[*]", "crate[12]"),
            ("a*c*", "abc"),
            ("floor", "floor"),
            ("*[1]", "x[1][1]"),
            ("", ""),
        ] {
            assert!(fits(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in [("crate[*]", "crate"), ("floor", "floors"), ("*a", "ab"), ("a*a", "a"), ("", "x")] {
            assert!(!fits(pattern, name), "{pattern} {name}");
        }
    }
}
