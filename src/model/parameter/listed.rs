//! By which address a number is listed where elements share a name: by the one that leads to this number and no other.
//!
//! The name of a body and of a motor may be one. An address that begins with it leads to the kind that stands first in scenario
//! files and has the key at all, as `--set` reads it, whatever the type of the element. Numbers of the others are listed by the place
//! of their element: `motor[0].stiffness`.

use super::super::description::{BodyDescription, Description};
use super::super::problem::Element;
use super::{Field, entries};
use std::collections::HashSet;

/// What the address of this number of an element begins with; `None` if no address leads to it.
pub(super) fn beginning(description: &Description, element: Element, field: Field) -> Option<String> {
    let entry = entries(description).find(|entry| entry.element == element)?;
    let Some((list, index)) = entry.place.filter(|_| !matches!(element, Element::Body(_) | Element::Beam(_))) else {
        // Nothing stands before bodies and beams, and all of these have names of their own.
        return Some(entry.name.to_owned());
    };
    let is_before = |other: Element| rank(other) < rank(element) && declares(other, field);
    if !entry.name.is_empty() && !called(description, entry.name).any(is_before) {
        return Some(entry.name.to_owned());
    }
    let place = format!("{list}[{index}]");
    let is_free = called(description, &place).all(|other| other == element);
    is_free.then_some(place)
}

/// Everything of this name; a template stands for its copies.
fn called<'d>(description: &'d Description, name: &'d str) -> impl Iterator<Item = Element> + 'd {
    let contacts = description.contacts.iter().enumerate().filter(move |(_, one)| one.name == name);
    let named = entries(description).filter(move |entry| entry.name == name).map(|entry| entry.element);
    named.chain(contacts.map(|(index, _)| Element::Contact(index))).chain(copies(description, name))
}

/// The copies of the template of this name.
fn copies<'d>(description: &'d Description, name: &'d str) -> impl Iterator<Item = Element> + 'd {
    let bodies = description.bodies.iter().enumerate();
    bodies.filter(move |(_, body)| template(&body.name) == Some(name)).map(|(index, _)| Element::Body(index))
}

/// `link` of its copy `link[2]`.
fn template(name: &str) -> Option<&str> {
    Some(name.strip_suffix(']')?.rsplit_once('[')?.0)
}

/// The copies of the template that a path begins with, of the one with the longest name, and the rest of the path.
pub(super) fn of_template<'p>(description: &Description, path: &'p str) -> Option<(Vec<Element>, &'p str)> {
    let rest = |body: &BodyDescription| path.strip_prefix(template(&body.name)?)?.strip_prefix('.');
    let shortest = description.bodies.iter().filter_map(rest).min_by_key(|rest| rest.len())?;
    let is_copy = |body: &BodyDescription| rest(body).is_some_and(|rest| rest.len() == shortest.len());
    let copies = description.bodies.iter().enumerate().filter(|(_, body)| is_copy(body));
    Some((copies.map(|(index, _)| Element::Body(index)).collect(), shortest))
}

/// The names that several elements have, and that of those without one.
pub(super) fn shared(description: &Description) -> HashSet<&str> {
    let contacts = description.contacts.iter().map(|contact| contact.name.as_str());
    let templates: HashSet<&str> = description.bodies.iter().filter_map(|body| template(&body.name)).collect();
    let mut seen = HashSet::new();
    let names = entries(description).map(|entry| entry.name);
    names.chain(contacts).chain(templates).filter(|name| !seen.insert(*name) || name.is_empty()).collect()
}

/// The place of a kind in scenario files: addresses lead to the first of one name.
fn rank(element: Element) -> usize {
    match element {
        Element::Body(_) => 0,
        Element::Beam(_) => 1,
        Element::Force(_) => 2,
        Element::Contact(_) => 3,
        Element::Loop(_) => 4,
        Element::Drive(_) => 5,
        Element::Motor(_) => 6,
        _ => 7,
    }
}

/// Whether elements of a kind have a key at all, be it only some of its types.
fn declares(kind: Element, field: Field) -> bool {
    let keys: &[Field] = match kind {
        Element::Body(_) => &[Field::Mass, Field::Position, Field::Rest, Field::Stiffness, Field::Force],
        Element::Beam(_) => &[Field::Length, Field::Young, Field::Pretension],
        Element::Force(_) => &[Field::Stiffness, Field::Length, Field::Force, Field::Torque, Field::Preload],
        Element::Contact(_) => &[Field::Stiffness],
        Element::Loop(_) => &[Field::Length],
        Element::Drive(_) => &[Field::Rate],
        Element::Motor(_) => &[Field::Force, Field::Stiffness],
        _ => &[],
    };
    keys.contains(&field)
}
