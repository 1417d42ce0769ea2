//! Single numbers of a description by address: what a path moves, what inverse statics finds, what a start file sets.
//!
//! | address | number |
//! |---|---|
//! | `gravity[2]` | a component of gravity |
//! | `upper.mass` | a body's mass |
//! | `upper.force`, `upper.stiffness`, `upper.rest`, `upper.position` | what acts in its hinge, and where that stands |
//! | `strut.length`, `strut.stiffness` | a spring's or rope's free length and stiffness; of a curve its length |
//! | `mount.stiffness[3]`, `mount.preload[2]` | one stiffness of a bushing, one part of what it is preloaded with |
//! | `tip.force[2]`, `tip.torque[0]` | a component of a load |
//! | `blade.length`, `blade.young`, `stay.pretension` | a straight beam's or cable's length, Young's modulus (`blade.material.young`, too), a cable's tension as given |
//! | `left link.length`, `engine.rate` | a rod's length, the rate of a drive |
//! | `servo.force`, `servo.stiffness` | the force of a motor, its gain |
//! | `force[2].length`, `drive[0].rate` | of what stands there in the file, whatever its name |
//! | `hinge.force` | every hinge |
//! | `parameters.m` | of `[parameters]`: moves all that follows from it |
//!
//! Without `[i]` an address stands for all components of its number, and the name of a repeated body for all copies. Where elements
//! share a name, a number is listed by an address that leads to it alone, as `motor[0].stiffness`.

mod listed;
mod measured;
mod named;
mod unknown;
mod value;

pub use named::{NamedNumber, NamedNumbers};

use super::address::{Entry, resolve, split_component};
use super::description::Description;
use super::problem::Element;
use measured::quantities;
use unknown::{unknown_element, unknown_key};

/// What a parameter measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Force (N).
    Force,
    /// Torque (N m).
    Torque,
    /// Length (m).
    Length,
    /// Angle (rad).
    Angle,
    /// Stiffness (N/m).
    Stiffness,
    /// Rotational stiffness (N m/rad).
    TurnStiffness,
    /// Mass (kg).
    Mass,
    /// Acceleration (m/s²).
    Acceleration,
    /// Speed (m/s).
    Speed,
    /// Angular rate (rad/s).
    TurnRate,
    /// Stress, or a modulus of elasticity (Pa).
    Stress,
    /// In SI units, which of them is not said: a named number without a unit, or with one of another kind.
    Plain,
}

impl Quantity {
    /// The quantities with a unit.
    pub const ALL: [Self; 11] = [
        Self::Force,
        Self::Torque,
        Self::Length,
        Self::Angle,
        Self::Stiffness,
        Self::TurnStiffness,
        Self::Mass,
        Self::Acceleration,
        Self::Speed,
        Self::TurnRate,
        Self::Stress,
    ];

    /// The quantity with this SI unit.
    pub fn of_unit(unit: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quantity| quantity.unit() == unit)
    }

    /// SI unit; empty for [`Plain`](Self::Plain).
    pub fn unit(self) -> &'static str {
        match self {
            Self::Force => "N",
            Self::Torque => "N m",
            Self::Length => "m",
            Self::Angle => "rad",
            Self::Stiffness => "N/m",
            Self::TurnStiffness => "N m/rad",
            Self::Mass => "kg",
            Self::Acceleration => "m/s²",
            Self::Speed => "m/s",
            Self::TurnRate => "rad/s",
            Self::Stress => "Pa",
            Self::Plain => "",
        }
    }
}

/// Which number of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Field {
    /// Gravity of the scene.
    Gravity,
    /// Mass of a body.
    Mass,
    /// Coordinate of a hinge.
    Position,
    /// Coordinate at which a hinge's spring is relaxed.
    Rest,
    /// Stiffness of a hinge's spring, of a spring, a rope or a bushing.
    Stiffness,
    /// Motor force of a hinge, force of a load.
    Force,
    /// Torque of a load.
    Torque,
    /// Young's modulus of a beam.
    Young,
    /// Free length of a spring, rope or curve, length of a rod or a straight beam.
    Length,
    /// Tension of a cable in the given positions.
    Pretension,
    /// What a bushing pushes with where its frames coincide.
    Preload,
    /// Rate of a drive.
    Rate,
    /// A number with a name.
    Named,
}

impl Field {
    /// The fields of elements.
    const ALL: [Self; 12] = [
        Self::Gravity,
        Self::Mass,
        Self::Young,
        Self::Position,
        Self::Rest,
        Self::Stiffness,
        Self::Force,
        Self::Torque,
        Self::Length,
        Self::Pretension,
        Self::Preload,
        Self::Rate,
    ];

    /// The field of elements with this key.
    fn of(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|field| field.name() == key)
    }

    /// The key in scenario files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gravity => "gravity",
            Self::Mass => "mass",
            Self::Young => "young",
            Self::Position => "position",
            Self::Rest => "rest",
            Self::Stiffness => "stiffness",
            Self::Force => "force",
            Self::Torque => "torque",
            Self::Length => "length",
            Self::Pretension => "pretension",
            Self::Preload => "preload",
            Self::Rate => "rate",
            Self::Named => "parameters",
        }
    }
}

/// One number of a description.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parameter {
    /// The address that stands for it alone.
    pub address: String,
    /// What it measures.
    pub quantity: Quantity,
    /// Whose number.
    pub element: Element,
    /// Which of its numbers.
    pub field: Field,
    index: usize,
}

/// Why an address stands for no number.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct UnknownAddress {
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

impl Parameter {
    /// All numbers that an address stands for, element by element.
    ///
    /// # Errors
    /// Where nothing of that name has a number of that kind.
    pub fn find(description: &Description, address: &str) -> Result<Vec<Self>, UnknownAddress> {
        if let Some(name) = address.strip_prefix(named::PREFIX) {
            return named::find(description, name).map(|one| vec![one]);
        }
        let (path, component) = split_component(address);
        if path == Field::Gravity.name() {
            let one = |index: usize| Self {
                address: format!("gravity[{index}]"),
                quantity: Quantity::Acceleration,
                element: Element::Scene,
                field: Field::Gravity,
                index,
            };
            return chosen((0..3).map(one).collect(), component, address);
        }
        let Some((elements, key)) = elements(description, path) else {
            return Err(unknown_element(description, address));
        };
        let key = key_of(key);
        let every = path.starts_with("hinge.") && elements.len() > 1;
        let mut found = Vec::new();
        for element in &elements {
            let all = numbers(description, *element, key);
            match component {
                Some(index) if every && all.len() <= index => {}
                _ if all.is_empty() => {}
                _ => found.extend(chosen(all, component, address)?),
            }
        }
        if found.is_empty() {
            return Err(unknown_key(description, &elements, key, address));
        }
        Ok(found)
    }

    /// Every single number that has an address, named ones first, by the address that leads to it alone.
    pub fn all(description: &Description) -> Vec<Self> {
        let names = description.named.list().iter().filter_map(|one| named::find(description, &one.name).ok());
        let gravity = Self::find(description, Field::Gravity.name()).unwrap_or_default();
        let shared = listed::shared(description);
        let of = |entry: Entry<'_, Element>| {
            let (element, name, is_shared) = (entry.element, entry.name.to_owned(), shared.contains(entry.name));
            Field::ALL.into_iter().flat_map(move |field| {
                let own = quantities(description, element, field);
                let beginning = match is_shared && !own.is_empty() {
                    true => listed::beginning(description, element, field),
                    false => Some(name.clone()),
                };
                beginning.map_or_else(Vec::new, |beginning| called(&beginning, element, field, &own))
            })
        };
        names.chain(gravity).chain(entries(description).flat_map(of)).collect()
    }

    /// Its component: which of the numbers of its element and field.
    pub fn component(&self) -> usize {
        self.index
    }
}

fn chosen(all: Vec<Parameter>, component: Option<usize>, address: &str) -> Result<Vec<Parameter>, UnknownAddress> {
    let Some(index) = component else { return Ok(all) };
    let count = all.len();
    match all.into_iter().nth(index) {
        Some(one) => Ok(vec![one]),
        None => Err(UnknownAddress {
            message: format!("`{address}`: there is no component {index}"),
            help: Some(match count {
                1 => "it is one number, without a component".to_owned(),
                _ => format!("its components are 0 to {}", count - 1),
            }),
        }),
    }
}

/// Everything that has a name.
fn entries(description: &Description) -> impl Iterator<Item = Entry<'_, Element>> + Clone {
    fn of<'d, T>(
        list: &'d [T],
        key: Option<&'static str>,
        element: fn(usize) -> Element,
        name: fn(&T) -> &String,
    ) -> impl Iterator<Item = Entry<'d, Element>> + Clone {
        let entry = move |(i, one): (usize, &'d T)| Entry {
            element: element(i),
            name: name(one),
            place: key.map(|key| (key, i)),
            copies: None,
        };
        list.iter().enumerate().map(entry)
    }
    // Copies of a template are bodies of their own here: no body has a place in the file that is known.
    of(&description.bodies, None, Element::Body, |body| &body.name)
        .chain(of(&description.beams, Some("beam"), Element::Beam, |beam| &beam.name))
        .chain(of(&description.forces, Some("force"), Element::Force, |force| &force.name))
        .chain(of(&description.loops, Some("loop"), Element::Loop, |one| &one.name))
        .chain(of(&description.drives, Some("drive"), Element::Drive, |drive| &drive.name))
        .chain(of(&description.motors, Some("motor"), Element::Motor, |motor| &motor.name))
}

/// The elements that a path starts with, and the rest of it.
fn elements<'p>(description: &Description, path: &'p str) -> Option<(Vec<Element>, &'p str)> {
    let has = |element: Element, rest: &str| has(description, element, key_of(rest));
    let found = resolve(path, entries(description), has);
    let of_copies = listed::of_template(description, path);
    // Bodies stand before whatever else has the name of their template.
    let is_template = found.as_ref().zip(of_copies.as_ref()).is_none_or(|(target, (copies, key))| {
        let stands_behind = !matches!(target.element, Element::Body(_) | Element::Beam(_));
        key.len() < target.rest.len() || key.len() == target.rest.len() && stands_behind && has(copies[0], key)
    });
    match (found, of_copies) {
        (_, Some(of_copies)) if is_template => return Some(of_copies),
        (Some(target), _) => return Some((vec![target.element], target.rest)),
        _ => {}
    }
    let key = path.strip_prefix("hinge.")?;
    Some(((0..description.bodies.len()).map(Element::Body).collect(), key))
}

/// The keys of a hinge may be written with and without `hinge.`, those of a material with and without `material.`.
fn key_of(rest: &str) -> &str {
    let of_material = rest.strip_prefix("material.").filter(|key| *key == Field::Young.name());
    of_material.or_else(|| rest.strip_prefix("hinge.")).unwrap_or(rest)
}

/// The numbers of an element under a key, by the addresses that lead to them; none if it has no such key.
fn numbers(description: &Description, element: Element, key: &str) -> Vec<Parameter> {
    let Some(field) = Field::of(key) else { return Vec::new() };
    let own = quantities(description, element, field);
    if own.is_empty() {
        return Vec::new();
    }
    let beginning =
        listed::beginning(description, element, field).unwrap_or_else(|| name(description, element).to_owned());
    called(&beginning, element, field, &own)
}

/// The numbers of an element, of which these are the quantities, by addresses with this beginning.
fn called(beginning: &str, element: Element, field: Field, quantities: &[Quantity]) -> Vec<Parameter> {
    let key = field.name();
    let address = |index: usize| match quantities.len() {
        1 => format!("{beginning}.{key}"),
        _ => format!("{beginning}.{key}[{index}]"),
    };
    let one = |(index, quantity): (usize, &Quantity)| Parameter {
        address: address(index),
        quantity: *quantity,
        element,
        field,
        index,
    };
    quantities.iter().enumerate().map(one).collect()
}

/// Whether an element has numbers under a key.
fn has(description: &Description, element: Element, key: &str) -> bool {
    Field::of(key).is_some_and(|field| !quantities(description, element, field).is_empty())
}

/// The name of an element that has numbers.
fn name(description: &Description, element: Element) -> &str {
    match element {
        Element::Motor(index) => &description.motors[index].name,
        Element::Loop(index) => &description.loops[index].name,
        Element::Drive(index) => &description.drives[index].name,
        Element::Body(index) => &description.bodies[index].name,
        Element::Beam(index) => &description.beams[index].name,
        Element::Force(index) => &description.forces[index].name,
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::super::description::*;
    use super::*;
    use nalgebra::Vector3;

    fn scene() -> Description {
        let body = |name: &str, kind: HingeKind| BodyDescription {
            name: name.to_owned(),
            mass: MassProperties { mass: 1.0, center: Vector3::zeros(), inertia: nalgebra::Matrix3::identity() },
            markers: Vec::new(),
            shapes: Vec::new(),
            hinge: HingeDescription::new(kind),
        };
        let end = |body: &str| Attachment { body: body.to_owned(), point: Point::At(Vector3::zeros()) };
        let turn = HingeKind::Revolute { axis: Vector3::x() };
        let forces = vec![
            ForceDescription {
                name: "a.b".to_owned(),
                kind: ForceKind::Load(Load {
                    on: end("a"),
                    force: Vector3::new(1.0, 2.0, 3.0),
                    torque: Vector3::zeros(),
                    axes: LoadAxes::Inertial,
                    over_time: None,
                }),
            },
            ForceDescription {
                name: "strut".to_owned(),
                kind: Spring { between: [end("a"), end(GROUND)], stiffness: 5.0, length: 0.5, damping: 0.0 }.into(),
            },
        ];
        let bodies = vec![
            body("a", turn),
            body("link[0]", turn),
            body("link[1]", HingeKind::Planar),
            body("float", HingeKind::Free),
        ];
        Description { bodies, forces, ..Description::default() }
    }

    fn addresses(text: &str) -> Vec<String> {
        Parameter::find(&scene(), text).map_or_else(
            |error| vec![error.message],
            |found| found.into_iter().map(|parameter| parameter.address).collect(),
        )
    }

    #[test]
    fn an_address_stands_for_the_numbers_of_the_longest_name() {
        assert_eq!(addresses("a.force"), ["a.force"]);
        assert_eq!(addresses("a.b.force[2]"), ["a.b.force[2]"]);
        assert_eq!(addresses("a.hinge.stiffness"), ["a.stiffness"]);
        assert_eq!(addresses("gravity[1]"), ["gravity[1]"]);
        assert_eq!(addresses("float.position").len(), 3, "the quaternion stays");
        assert_eq!(addresses("link.rest"), ["link[0].rest", "link[1].rest[0]", "link[1].rest[1]", "link[1].rest[2]"]);
        assert_eq!(addresses("hinge.force").len(), 1 + 1 + 3 + 6);
        assert_eq!(addresses("b.force"), ["nothing is called `b`"]);
        assert_eq!(addresses("strut.mass"), ["`strut.mass`: it has no number `mass`"]);
        assert_eq!(addresses("a.force[1]"), ["`a.force[1]`: there is no component 1"]);
    }

    #[test]
    fn a_number_that_is_set_is_the_number_that_is_read() {
        for text in ["gravity[0]", "a.mass", "link[1].rest[2]", "float.position[1]", "a.b.torque[0]", "strut.length"] {
            let mut scene = scene();
            let found = Parameter::find(&scene, text).expect("an address");
            found[0].set(&mut scene, 0.25).expect(text);
            assert_eq!(found[0].value(&scene), 0.25, "{text}");
            super::super::Model::build(&scene).expect(text);
        }
    }
}
