//! Why an address stands for no number, and what to do about it.

use super::{Element, Field, UnknownAddress, entries, numbers};
use crate::model::address::split_component;
use crate::model::description::Description;
use crate::suggest::closest;

/// What stands at an address whose element is not known.
pub(super) fn unknown_element(description: &Description, address: &str) -> UnknownAddress {
    if let Some(other) = of_others(description, address) {
        return other;
    }
    let target = address.rsplit_once('.').map_or(split_component(address).0, |(target, _)| target);
    let known = entries(description).map(|entry| entry.name).chain(["gravity", "hinge", "parameters"]);
    let help = match closest(target, known) {
        Some(near) => format!("did you mean `{near}`?"),
        None => "a number is addressed as `body.force`, `spring.length` or `gravity[2]`".to_owned(),
    };
    UnknownAddress { message: format!("nothing is called `{target}`"), help: Some(help) }
}

/// What has a name, and numbers that `--set` reaches, but none that may be unknown or that an equilibrium has a derivative by.
fn of_others(description: &Description, address: &str) -> Option<UnknownAddress> {
    let (name, _) = address.rsplit_once('.')?;
    let kinds = [
        ("gear", description.gears.iter().map(|one| &one.name).collect::<Vec<_>>()),
        ("output", description.outputs.iter().map(|one| &one.name).collect()),
        ("event", description.events.iter().map(|one| &one.name).collect()),
        ("contact", description.contacts.iter().map(|one| &one.name).collect()),
        ("controller", description.controllers.iter().map(|one| &one.name).collect()),
        ("stage", description.stages.iter().map(|one| &one.name).collect()),
    ];
    let (kind, _) = kinds.into_iter().find(|(_, names)| names.iter().any(|one| one.as_str() == name))?;
    let article = if matches!(kind, "output" | "event") { "an" } else { "a" };
    let help = format!(
        "numbers of a {kind} can be set (`--set`), or follow from `[parameters]`: give such a number a name there, and take `parameters.name`"
    );
    Some(UnknownAddress {
        message: format!("`{address}`: `{name}` is {article} {kind}, whose numbers have no address here"),
        help: Some(help),
    })
}

/// What is said of an element without such a number.
pub(super) fn unknown_key(description: &Description, elements: &[Element], key: &str, address: &str) -> UnknownAddress {
    let element = elements.iter().copied().find(|element| match element {
        Element::Body(body) => !description.bodies[*body].hinge.kind.velocities().is_empty(),
        _ => true,
    });
    let element = element.or(elements.first().copied()).unwrap_or(Element::Scene);
    let has = Field::ALL.into_iter().filter(|field| !numbers(description, element, field.name()).is_empty());
    let names: Vec<&str> = has.map(Field::name).collect();
    if of_file(element, key) {
        return UnknownAddress {
            message: format!("`{address}`: `{key}` is no number that can be addressed here"),
            help: Some(format!(
                "such a number can be set (`--set`), or follow from `[parameters]`: give it a name there, and take \
                 `parameters.name`; addressed here are `{}`",
                names.join("`, `")
            )),
        };
    }
    let help = match closest(key, names.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("its numbers that statics feels are `{}`", names.join("`, `")),
    };
    UnknownAddress { message: format!("`{address}`: it has no number `{key}`"), help: Some(help) }
}

/// Whether an element of this kind may have numbers under a key in scenario files, for which there is no [`Field`].
fn of_file(element: Element, key: &str) -> bool {
    let first = key.split(['.', '[']).next().unwrap_or_default();
    let keys: &[&str] = match element {
        Element::Body(_) => &[
            "armature",
            "at",
            "axes",
            "axis",
            "burn",
            "center",
            "curve",
            "damping",
            "density",
            "friction",
            "inertia",
            "limits",
            "markers",
            "modal_damping",
            "next",
            "pitch",
            "ratio",
            "rpy",
            "shape",
            "velocity",
        ],
        Element::Beam(_) => &["curve", "damping", "load", "markers", "mass_per_length", "material", "section", "twist"],
        Element::Force(_) => &["between", "damping", "extension", "on", "over_time", "rate", "rpy", "through"],
        Element::Loop(_) => &["axes", "axis", "between", "rpy", "rpy_second"],
        Element::Drive(_) => {
            &["amplitude", "begin", "duration", "frequency", "offset", "phase", "times", "to", "values"]
        }
        Element::Motor(_) => &["at", "damping", "forces", "limit", "target"],
        _ => &[],
    };
    keys.contains(&first)
}
