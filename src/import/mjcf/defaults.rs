//! Default classes, and attributes as they stand with them.

use super::super::log::Problem;
use super::super::xml::{Attribute, Element};
use super::settings::choice;
use super::tree::Tree;
use std::collections::HashMap;

/// The classes of `<default>`.
#[derive(Default)]
pub(super) struct Defaults<'a> {
    classes: Vec<Class<'a>>,
    names: HashMap<&'a str, usize>,
}

struct Class<'a> {
    /// And how many of its elements stood there when this class was declared: later ones are not inherited.
    parent: Option<(usize, usize)>,
    elements: Vec<Element<'a>>,
}

/// The class of elements outside of all classes.
const MAIN: usize = 0;

/// Elements that set defaults for each other: the short forms of an actuator.
pub(super) const ACTUATORS: [&str; 14] = [
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "pid",
    "orientation",
    "plugin",
    "actuator",
];

impl<'a> Defaults<'a> {
    pub(super) fn read(tree: &Tree<'a>) -> Self {
        let mut defaults = Self::default();
        defaults.classes.push(Class { parent: None, elements: Vec::new() });
        for element in tree.all(&tree.root, "default") {
            defaults.names.insert(element.text("class").unwrap_or("main"), MAIN);
            defaults.fill(tree, &element, MAIN);
        }
        defaults
    }

    fn fill(&mut self, tree: &Tree<'a>, element: &Element<'a>, class: usize) {
        // Classes in an element inherit all of it, also what follows them; not what further elements of the same class say.
        let is_class = |child: &Element<'a>| child.name() == "default";
        for child in tree.children(element).into_iter().filter(|child| !is_class(child)) {
            child.see();
            self.classes[class].elements.push(child);
        }
        for child in tree.children(element).into_iter().filter(is_class) {
            child.see();
            let Some(name) = child.required("class") else { continue };
            let index = self.classes.len();
            if self.names.insert(name.value, index).is_some() {
                child.refuse(name.wrong(&format!("is \"{}\", and so is another class", name.value)));
            }
            let inherited = self.classes[class].elements.len();
            self.classes.push(Class { parent: Some((class, inherited)), elements: Vec::new() });
            self.fill(tree, &child, index);
        }
    }

    /// The class of this name, as an attribute says it.
    pub(super) fn class(&self, attribute: &Attribute<'a>) -> Option<usize> {
        let found = self.names.get(attribute.value).copied();
        if found.is_none() && attribute.value != "main" {
            let near = attribute.element.log.near(attribute.value, self.names.keys().copied());
            let help = near.map_or_else(
                || "classes are declared in <default>".to_owned(),
                |near| format!("did you mean `{near}`?"),
            );
            let problem = attribute.wrong(&format!("is \"{}\": there is no such class", attribute.value));
            attribute.element.refuse(problem.help(help));
        }
        found.or(Some(MAIN))
    }

    /// An element with its class, or with the one of the bodies around it.
    pub(super) fn of(&self, element: &Element<'a>, around: Option<usize>) -> Settled<'a> {
        self.under(element, element.name(), around)
    }

    /// As [`of`](Self::of), of an element whose defaults stand under another name: `equality`, `tendon`.
    pub(super) fn under(&self, element: &Element<'a>, tag: &str, around: Option<usize>) -> Settled<'a> {
        element.see();
        let own = element.attribute("class").and_then(|class| self.class(&class));
        let (mut behind, mut counts) = (Vec::new(), Vec::new());
        let mut class = own.or(around).or((!self.classes.is_empty()).then_some(MAIN)).map(|class| (class, usize::MAX));
        while let Some((index, inherited)) = class {
            let alike = |other: &&Element<'a>| {
                other.name() == tag || ACTUATORS.contains(&tag) && ACTUATORS.contains(&other.name())
            };
            let elements = &self.classes[index].elements;
            let there = &elements[..inherited.min(elements.len())];
            behind.extend(there.iter().rev().filter(alike).copied());
            counts.push(behind.len());
            class = self.classes[index].parent;
        }
        Settled { element: *element, behind, counts }
    }
}

/// An element with what its classes say, the nearest first.
#[derive(Clone)]
pub(super) struct Settled<'a> {
    pub(super) element: Element<'a>,
    behind: Vec<Element<'a>>,
    /// How many of these the classes have, each counted with the nearer ones.
    counts: Vec<usize>,
}

impl<'a> Settled<'a> {
    /// What each class says itself, the outermost class first, its elements in the order of the text.
    pub(super) fn classes(&self) -> impl Iterator<Item = impl Iterator<Item = &Element<'a>>> {
        let starts = [0].into_iter().chain(self.counts.iter().copied());
        let spans: Vec<(usize, usize)> = starts.zip(self.counts.iter().copied()).collect();
        spans.into_iter().rev().map(|(start, end)| self.behind[start..end].iter().rev())
    }

    /// The element and what stands behind it, the farthest first: each says more than the one before.
    fn layers(&self) -> impl Iterator<Item = &Element<'a>> {
        self.behind.iter().rev().chain([&self.element])
    }

    /// An element that has no classes.
    pub(super) fn bare(element: &Element<'a>) -> Self {
        element.see();
        Self { element: *element, behind: Vec::new(), counts: Vec::new() }
    }

    /// An attribute, from the element or from the nearest class that has it.
    pub(super) fn attribute(&self, key: &str) -> Option<Attribute<'a>> {
        let own = self.element.attribute(key);
        // All are read, also those that others hide.
        let behind = self.behind.iter().map(|element| element.attribute(key)).fold(None, Option::or);
        own.or(behind)
    }

    /// Marks attributes as read that are of no further interest.
    pub(super) fn skip(&self, keys: &[&str]) {
        for key in keys {
            self.attribute(key);
        }
    }

    pub(super) fn text(&self, key: &str) -> Option<&'a str> {
        self.attribute(key).map(|attribute| attribute.value)
    }

    pub(super) fn number(&self, key: &str) -> Option<f64> {
        self.attribute(key)?.number()
    }

    pub(super) fn vector<const N: usize>(&self, key: &str) -> Option<[f64; N]> {
        self.attribute(key)?.vector()
    }

    /// Up to `most` numbers. A shorter list sets the first ones, and the others stay as the classes have them.
    pub(super) fn numbers(&self, key: &str, most: usize) -> Option<Vec<f64>> {
        let mut list: Option<Vec<f64>> = None;
        for element in self.layers() {
            let Some(attribute) = element.attribute(key) else { continue };
            let numbers = attribute.numbers()?;
            if numbers.is_empty() || numbers.len() > most {
                let found = numbers.len();
                element.refuse(attribute.wrong(&format!("must be 1 to {most} numbers, found {found}")));
                return None;
            }
            let behind = list.take().unwrap_or_default();
            let rest = behind.into_iter().skip(numbers.len());
            list = Some(numbers.iter().copied().chain(rest).collect());
        }
        list
    }

    /// A number that must not be negative.
    pub(super) fn not_negative(&self, key: &str) -> Option<f64> {
        let number = self.number(key)?;
        if number < 0.0 {
            let attribute = self.attribute(key)?;
            attribute.element.refuse(attribute.wrong(&format!("must be ≥ 0, found {number}")));
            return None;
        }
        Some(number)
    }

    pub(super) fn flag(&self, key: &str) -> Option<bool> {
        self.attribute(key).and_then(|at| choice(&at, &["false", "true"])).map(|word| word == 1)
    }

    /// Whether a range counts: `limited` says so, or with `autolimits` a range other than from 0 to 0.
    pub(super) fn limited(&self, key: &str, range: &str, autolimits: bool) -> bool {
        match self.attribute(key).and_then(|at| choice(&at, &["false", "true", "auto"])) {
            Some(0) => false,
            Some(1) => true,
            _ => {
                let ends = |text: &str| text.split_whitespace().any(|end| end.parse() != Ok(0.0));
                autolimits && self.attribute(range).is_some_and(|at| ends(at.value))
            }
        }
    }

    /// Says that something is wrong with the element.
    pub(super) fn refuse(&self, what: &str, help: &str) {
        let problem = Problem::at(self.element.place(), format!("{}: {what}", self.element.label()));
        self.element.refuse(problem.maybe_help((!help.is_empty()).then(|| help.to_owned())));
    }
}
