//! Numbers with names that others of a description follow from, as `[parameters]` of a file has them.
//!
//! Such a number has no place of its own in a description: to move it the description is made again by whoever made it, and
//! what has been set in the old one since then is set in the new one, too. So it is exact, whatever depends on it and how.

use super::super::description::Description;
use super::super::problem::Element;
use super::{Field, Parameter, Quantity, UnknownAddress, called, quantities};
use crate::suggest::closest;
use std::fmt;
use std::sync::Arc;

/// What their addresses begin with.
pub(super) const PREFIX: &str = "parameters.";

/// A number with a name.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedNumber {
    /// As it is written.
    pub name: String,
    /// In SI units and radians.
    pub value: f64,
    /// What it measures.
    pub quantity: Quantity,
}

/// Makes a description in which these numbers have other values.
type Remake = Arc<dyn Fn(&[(String, f64)]) -> Result<Description, String> + Send + Sync>;

/// The named numbers of a description, and how it follows from them. None for a description that was made in code.
#[derive(Clone, Default)]
pub struct NamedNumbers {
    list: Vec<NamedNumber>,
    /// Numbers that have been set since the description was made first.
    set: Vec<(String, f64)>,
    remake: Option<Remake>,
}

impl NamedNumbers {
    /// `remake` makes the description in which some of them have other values, or says why there is none; its own list holds
    /// their values there, in the same order.
    pub fn new(
        list: Vec<NamedNumber>,
        remake: impl Fn(&[(String, f64)]) -> Result<Description, String> + Send + Sync + 'static,
    ) -> Self {
        Self { list, set: Vec::new(), remake: Some(Arc::new(remake)) }
    }

    /// Numbers that are there to be read.
    pub fn listed(list: Vec<NamedNumber>) -> Self {
        Self { list, ..Self::default() }
    }

    /// Named numbers of what `part` makes of the description.
    #[must_use]
    pub fn then(&self, part: impl Fn(&Description) -> Description + Send + Sync + 'static) -> Self {
        let remake = self.remake.clone().map(|remake| -> Remake { Arc::new(move |set| Ok(part(&remake(set)?))) });
        Self { remake, ..self.clone() }
    }

    /// All of them.
    pub fn list(&self) -> &[NamedNumber] {
        &self.list
    }
}

/// How a description is made again does not count.
impl PartialEq for NamedNumbers {
    fn eq(&self, other: &Self) -> bool {
        self.list == other.list
    }
}

impl fmt::Debug for NamedNumbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.list.fmt(f)
    }
}

/// The number of this name.
pub(super) fn find(description: &Description, name: &str) -> Result<Parameter, UnknownAddress> {
    let list = &description.named.list;
    let Some(index) = list.iter().position(|one| one.name == name) else {
        let help = closest(name, list.iter().map(|one| one.name.as_str()));
        let help = help.map(|near| format!("did you mean `{PREFIX}{near}`?"));
        return Err(UnknownAddress { message: format!("there is no parameter `{name}`"), help });
    };
    Ok(Parameter {
        address: format!("{PREFIX}{name}"),
        quantity: list[index].quantity,
        element: Element::Scene,
        field: Field::Named,
        index,
    })
}

/// The description in which the number at `index` has this value.
pub(super) fn with(description: &Description, index: usize, value: f64) -> Result<Description, String> {
    let named = &description.named;
    let remake = named.remake.as_ref().ok_or("nothing follows from it")?;
    let name = &named.list[index].name;
    let others = named.set.iter().filter(|(other, _)| other != name).cloned();
    let set: Vec<(String, f64)> = others.chain([(name.clone(), value)]).collect();
    let (before, mut now) = (remake(&named.set)?, remake(&set)?);
    carry(description, &before, &mut now)?;
    now.named.set = set;
    now.named.remake = Some(remake.clone());
    Ok(now)
}

/// What differs in `from` from what it was `before` is so in `to`, too.
fn carry(from: &Description, before: &Description, to: &mut Description) -> Result<(), String> {
    if elements(from).ne(elements(to)) {
        return Err("it changes what the scene is made of".to_owned());
    }
    for index in (0..3).filter(|i| from.gravity[*i] != before.gravity[*i]) {
        to.gravity[index] = from.gravity[index];
    }
    for element in elements(from) {
        for field in Field::ALL {
            for number in called("", element, field, &quantities(from, element, field)) {
                let value = number.value(from);
                if value != number.value(before) {
                    number.put(to, value);
                }
            }
        }
    }
    for ((now, was), given) in to.bodies.iter_mut().zip(&from.bodies).zip(&before.bodies) {
        if was.hinge.position != given.hinge.position {
            now.hinge.position.clone_from(&was.hinge.position);
        }
        if was.hinge.velocity != given.hinge.velocity {
            now.hinge.velocity.clone_from(&was.hinge.velocity);
        }
    }
    Ok(())
}

fn elements(description: &Description) -> impl Iterator<Item = Element> {
    let of = |count: usize, element: fn(usize) -> Element| (0..count).map(element);
    of(description.bodies.len(), Element::Body)
        .chain(of(description.forces.len(), Element::Force))
        .chain(of(description.loops.len(), Element::Loop))
        .chain(of(description.drives.len(), Element::Drive))
        .chain(of(description.motors.len(), Element::Motor))
}
