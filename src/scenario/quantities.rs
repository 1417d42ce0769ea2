//! Texts in the place of numbers: quantities with units (`"45 deg"`) and formulas of `[parameters]` (`"2*{a}"`).
//!
//! They are turned into numbers before the file is checked, so that nothing else knows of them. What a text measures must
//! be what its key is declared to hold; where that depends on a hinge (`m or rad`) the hinge's type decides, of each of
//! its coordinates. Parameters keep what they measure, and formulas of them combine it.

mod hinges;
mod parameters;

pub(super) use parameters::{PARAMETERS, Parameters};

use super::fields::{Key, Kind};
use super::findings::{Finding, Findings};
use super::format::{BUSHING_VALUES, CURVE_VALUES, FORCE, FRICTION, HINGE_CURVE, SCENARIO};
use super::naming::{Element, written};
use crate::formula::{Formula, FormulaError};
use crate::hinge::{HingeKind, Names};
use crate::model::parameter::NamedNumber;
use crate::model::{Description, Parameter};
use crate::quantity::measure::Measure;
use crate::quantity::{Dimension, Quantity};
use hinges::{Hinges, Motion, of_velocities};
use std::collections::HashMap;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What texts stand for, by where they are written.
#[derive(Debug, Default)]
pub(super) struct Numbers {
    /// As a file would have them, in SI units.
    texts: HashMap<(usize, usize), String>,
    /// Of quantities where the format does not say what they measure.
    open: HashMap<(usize, usize), Measure>,
    /// The numbers of `[parameters]`.
    pub(super) parameters: Vec<NamedNumber>,
}

/// Whether a value holds a text that may stand for a number; most files have none.
fn has_texts(value: &DeValue<'_>) -> bool {
    match value {
        DeValue::String(text) => text.contains('{') || Quantity::is_meant(text),
        DeValue::Array(items) => items.iter().any(|item| has_texts(item.get_ref())),
        DeValue::Table(table) => table.values().any(|item| has_texts(item.get_ref())),
        _ => false,
    }
}

/// The quantity that a text is, in one of these units: none for pure numbers, `None` if any will do. What is wrong with it
/// is in `findings`.
fn quantity(
    subject: &str,
    value: &Spanned<DeValue<'_>>,
    units: Option<&[&str]>,
    findings: &Findings,
) -> Option<Quantity> {
    let text = value.get_ref().as_str()?;
    let refuse = |part: Range<usize>, message: String, help: Option<String>| {
        let finding = Finding::error(value.span(), format!("{subject}: {message}")).within(part);
        findings.push_value(finding.maybe_help(help));
    };
    let quantity = match Quantity::parse(text) {
        Ok(quantity) => quantity,
        Err(error) => {
            refuse(error.span, error.message, error.help);
            return None;
        }
    };
    let (plain, unit) = text.split_at(quantity.unit_start);
    if unit.is_empty() {
        let (plain, of_toml) = (plain.trim(), of_toml(plain.trim()));
        // On a command line there are no quotes around what TOML does not take for a number.
        let (message, quotes) = match plain == of_toml {
            true => (format!("the text {} has no unit", written(value.get_ref())), " without quotes"),
            false => (format!("`{plain}` needs a digit on both sides of its point"), ""),
        };
        let help = match units {
            Some([]) | None => format!("write `{of_toml}`{quotes}"),
            Some([unit, ..]) => format!("write `{of_toml}`{quotes}, or `\"{of_toml} {unit}\"`"),
        };
        refuse(0..text.len(), message, Some(help));
        return None;
    }
    match misfit(quantity.dimension.into(), unit, units) {
        None => Some(quantity),
        Some((message, help)) => {
            refuse(quantity.unit_start..text.len(), message, help);
            None
        }
    }
}

/// A number with digits on both sides of its point, as TOML wants them: `.5` is `0.5`, `5.` is `5.0`.
fn of_toml(number: &str) -> String {
    let Some((before, after)) = number.split_once('.') else { return number.to_owned() };
    let is_digit = |c: char| c.is_ascii_digit();
    let [first, last] = [before.ends_with(is_digit), after.starts_with(is_digit)].map(|has| if has { "" } else { "0" });
    format!("{before}{first}.{last}{after}")
}

/// Why a number that measures this, written in `unit`, cannot stand where one of `units` is asked for: none for pure numbers,
/// `None` if any will do.
fn misfit(measure: Measure, unit: &str, units: Option<&[&str]>) -> Option<(String, Option<String>)> {
    let fits = |unit: &&str| Dimension::of(unit).is_ok_and(|dimension| measure.fits(dimension));
    match units {
        _ if measure == Measure::Plain => None,
        None => None,
        Some(units) if units.iter().any(fits) => None,
        Some([]) if measure.fits(Dimension::default()) => None,
        Some([]) => Some((format!("a pure number has no unit, and not `{unit}`"), None)),
        Some([MIXED]) => Some((format!("`{unit}` is no unit of it"), Some(format!("here stands {MIXED}")))),
        Some(units) => {
            let other = Dimension::of(unit).ok().and_then(Dimension::name);
            let other = other.map_or_else(String::new, |name| format!("; `{unit}` measures {name}"));
            let help = format!("it is measured in {}{other}", units.join(" or "));
            Some((format!("`{unit}` is no unit of it"), Some(help)))
        }
    }
}

/// As [`evaluate`], of a start file: numbers of hinges by the names of their bodies, inputs by their addresses.
pub(super) fn evaluate_start(document: &DeTable<'_>, scene: &Description, findings: &Findings) -> Numbers {
    let mut numbers = Numbers::default();
    let mut take = |subject: &str, value: &Spanned<DeValue<'_>>, unit: &str| {
        if value.get_ref().as_str().is_none_or(|text| !Quantity::is_meant(text)) {
            return;
        }
        let units = match unit {
            "" => None,
            "1" => Some(&[][..]),
            _ => Some(&[unit][..]),
        };
        if let Some(quantity) = quantity(subject, value, units, findings) {
            numbers.insert(&value.span(), quantity.value);
        }
    };
    let entries = |list: &str| {
        let table = document.get(list).and_then(|list| list.get_ref().as_table());
        table.into_iter().flat_map(|table| table.iter())
    };
    type NamesOf = fn(&HingeKind) -> Names;
    let lists: [(_, NamesOf); 2] = [("positions", HingeKind::positions), ("velocities", HingeKind::velocities)];
    for (list, names) in lists {
        for (name, value) in entries(list) {
            let name: &str = name.get_ref();
            let Some(body) = scene.bodies.iter().find(|body| body.name == name) else { continue };
            let items = value.get_ref().as_array().into_iter().flat_map(|items| items.iter());
            for (item, (_, unit)) in items.zip(names(&body.hinge.kind)) {
                take(&format!("{list} of `{name}`"), item, unit);
            }
        }
    }
    for (address, value) in entries("inputs") {
        let address: &str = address.get_ref();
        let Ok(found) = Parameter::find(scene, address) else { continue };
        take(&format!("`{address}`"), value, found.first().map_or("1", |one| one.quantity.unit()));
    }
    numbers
}

/// Evaluates all texts that stand for numbers; what is wrong with them is in `findings`. `before` are the parameters before any
/// changes.
pub(super) fn evaluate(document: &DeTable<'_>, before: &Parameters, findings: &Findings) -> Numbers {
    let parameters = Parameters::read_after(document, before);
    let numbers = Numbers { parameters: parameters.list(), ..Numbers::default() };
    if !document.values().any(|value| has_texts(value.get_ref())) {
        return numbers;
    }
    let mut pass = Pass { findings, hinges: Some(Hinges::new(document)), parameters, numbers };
    let whole = Element { table: &SCENARIO, name: None, index: None, within: None };
    pass.table(&whole, document, None);
    pass.numbers
}

/// As [`evaluate`], of a table that is read before the bodies are known: what quantities measure is checked later.
pub(super) fn evaluate_alone(
    document: &DeTable<'_>,
    whole: &DeTable<'_>,
    before: &Parameters,
    findings: &Findings,
) -> Numbers {
    let parameters = Parameters::read_after(whole, before);
    let mut pass = Pass { findings, hinges: None, parameters, numbers: Numbers::default() };
    let element = Element { table: &SCENARIO, name: None, index: None, within: None };
    pass.table(&element, document, None);
    pass.numbers
}

impl Numbers {
    /// The document with the numbers in the places of the texts.
    pub(super) fn put_into<'n>(&'n self, mut document: DeTable<'n>) -> DeTable<'n> {
        self.put(&mut document);
        document
    }

    /// Puts the numbers into the places of the texts.
    pub(super) fn put<'n>(&'n self, table: &mut DeTable<'n>) {
        if self.texts.is_empty() {
            return;
        }
        for (_, value) in table.iter_mut() {
            self.replace(value);
        }
    }

    fn replace<'n>(&'n self, value: &mut Spanned<DeValue<'n>>) {
        let span = value.span();
        match value.get_mut() {
            DeValue::Table(table) => self.put(table),
            DeValue::Array(items) => items.iter_mut().for_each(|item| self.replace(item)),
            DeValue::String(_) => {
                let number = self.texts.get(&(span.start, span.end)).and_then(|text| DeValue::parse(text).ok());
                if let Some(number) = number {
                    *value.get_mut() = number.into_inner();
                }
            }
            _ => {}
        }
    }

    /// Whether the number here is written as a text: with a unit, or as a formula.
    pub(super) fn is_text(&self, span: &Range<usize>) -> bool {
        self.texts.contains_key(&(span.start, span.end))
    }

    /// What the quantity or formula that is written here measures, if the format leaves that open.
    pub(super) fn measure(&self, span: &Range<usize>) -> Option<Measure> {
        self.open.get(&(span.start, span.end)).copied()
    }

    fn insert(&mut self, span: &Range<usize>, value: f64) {
        self.texts.insert((span.start, span.end), format!("{value:?}"));
    }
}

/// Whether more than one unit will do.
fn is_open(units: Option<&[&str]>) -> bool {
    units.is_none_or(|units| units.len() > 1)
}

/// In place of a unit: one number stands for coordinates that are measured in different units.
const MIXED: &str = "a list, one number for each coordinate";

struct Pass<'p> {
    findings: &'p Findings,
    /// `None` while the bodies are not known.
    hinges: Option<Hinges>,
    parameters: Parameters,
    numbers: Numbers,
}

/// The unit of the first number of a point of a curve, whose key has that of the second.
fn abscissa(place: &Place<'_>, at: &[usize]) -> Option<&'static str> {
    let [_, 0] = at else { return None };
    match (place.element.table.name, place.key.name) {
        (name, "force") if name == FORCE.name => Some("m"),
        (name, "extension") if name == CURVE_VALUES.name => Some("m"),
        (name, "rate") if name == CURVE_VALUES.name => Some("m/s"),
        (name, "curve") if name == HINGE_CURVE.name && place.outer == Some("damper") => Some("m/s or rad/s"),
        (name, "curve") if name == HINGE_CURVE.name => Some("m or rad"),
        _ => None,
    }
}

/// Where a number stands.
struct Place<'p> {
    element: &'p Element<'p>,
    key: &'static Key,
    /// The coordinates that the numbers of the element belong to, in order.
    motions: Option<&'p [Motion]>,
    /// The key that holds the table.
    outer: Option<&'p str>,
    /// Whether the table is looked up by the time.
    over_time: bool,
}

impl Pass<'_> {
    fn table(&mut self, element: &Element<'_>, table: &DeTable<'_>, outer: Option<(&str, Option<&[Motion]>)>) {
        let of_type = table.get("type").and_then(|of_type| of_type.get_ref().as_str());
        let around = outer.and_then(|(_, motions)| motions);
        let motions = self.hinges.as_ref().and_then(|hinges| hinges.of(element.table, table, around));
        let over_time = table.get("over").is_some_and(|over| over.get_ref().as_str() == Some("time"));
        for (name, value) in table {
            let mut declared = element.table.declarations(name.get_ref());
            let Some(key) = declared.find(|key| of_type.is_none_or(|t| key.belongs_to(t))) else { continue };
            let motions = motions.as_deref();
            let place = Place { element, key, motions, outer: outer.map(|(key, _)| key), over_time };
            self.value(&key.kind, &place, value, &[]);
        }
    }

    /// Looks for texts in a value; `at` are the indices that lead to it in lists.
    fn value(&mut self, kind: &'static Kind, place: &Place<'_>, value: &Spanned<DeValue<'_>>, at: &[usize]) {
        match (kind, value.get_ref()) {
            (Kind::Number(_), DeValue::String(text)) => self.text(place, value, text, at),
            (Kind::Either(kinds), DeValue::String(_)) => {
                let is_text = kinds.iter().any(|kind| matches!(kind, Kind::Text | Kind::Choice(_)));
                let numbers = kinds.iter().find(|kind| matches!(kind, Kind::Number(_)));
                numbers.filter(|_| !is_text).into_iter().for_each(|kind| self.value(kind, place, value, at));
            }
            (Kind::Either(kinds), DeValue::Array(items)) => {
                let nested = items.first().is_some_and(|item| item.get_ref().is_array());
                let tables = items.first().is_some_and(|item| item.get_ref().is_table());
                let fits = |kind: &&Kind| match kind {
                    Kind::List(Kind::Table(_), _) => tables,
                    Kind::List(Kind::Either(_), _) => !nested,
                    Kind::List(Kind::List(..), _) => nested,
                    Kind::List(..) => !nested && !tables,
                    _ => false,
                };
                kinds.iter().find(fits).into_iter().for_each(|kind| self.value(kind, place, value, at));
            }
            (Kind::Either(kinds), DeValue::Table(_)) => {
                let tables = kinds.iter().find(|kind| matches!(kind, Kind::Table(_) | Kind::Map(_)));
                tables.into_iter().for_each(|kind| self.value(kind, place, value, at));
            }
            (Kind::List(of, _), DeValue::Array(items)) => {
                let texts = |item: &Spanned<DeValue<'_>>| {
                    matches!(item.get_ref(), DeValue::String(_) | DeValue::Array(_) | DeValue::Table(_))
                };
                for (index, item) in items.iter().enumerate().filter(|(_, item)| texts(item)) {
                    let deeper: Vec<usize> = at.iter().copied().chain([index]).collect();
                    self.value(of, place, item, &deeper);
                }
            }
            (Kind::Table(declared), DeValue::Table(inner)) => {
                let name = inner.get("name").and_then(|name| name.get_ref().as_str());
                let index = at.last().copied();
                let element = Element { table: declared, name, index, within: Some(place.element) };
                self.table(&element, inner, Some((place.key.name, place.motions)));
            }
            (Kind::Map(of), DeValue::Table(inner)) => {
                inner.values().for_each(|value| self.value(of, place, value, at));
            }
            _ => {}
        }
    }

    fn text(&mut self, place: &Place<'_>, value: &Spanned<DeValue<'_>>, text: &str, at: &[usize]) {
        if text.contains('{') {
            return self.formula(place, value, text, at);
        }
        if !Quantity::is_meant(text) {
            return;
        }
        let subject = format!("{}`{}`", place.element.prefix(), place.key.name);
        let units = self.units(place, at);
        if let Some(quantity) = quantity(&subject, value, units.as_deref(), self.findings) {
            let span = value.span();
            if is_open(units.as_deref()) {
                self.numbers.open.insert((span.start, span.end), quantity.dimension.into());
            }
            self.numbers.insert(&span, quantity.value);
        }
    }

    /// The units that a number may have here: none for pure numbers, `None` if that is found out later.
    fn units(&self, place: &Place<'_>, at: &[usize]) -> Option<Vec<&'static str>> {
        if place.key.unit == super::fields::ANY_UNIT {
            return None;
        }
        // Friction at rest and in motion has the unit of the key that holds both: none between bodies.
        let outer = place.element.within.filter(|_| place.element.table.name == FRICTION.name);
        let (unit, at) = match outer.and_then(|outer| outer.table.declarations(place.outer?).next()) {
            Some(key) => (key.unit, place.element.index.as_slice()),
            None => (abscissa(place, at).unwrap_or(place.key.unit), at),
        };
        let all: Vec<&'static str> = unit.split(" or ").filter(|unit| !unit.is_empty()).collect();
        if let [both] = all[..]
            && let Some((along, about)) = both.split_once(" and ")
        {
            return Some(vec![if at.last().is_some_and(|index| *index >= 3) { about } else { along }]);
        }
        if place.element.table.name == BUSHING_VALUES.name {
            return Some(vec![all[usize::from(place.outer == Some("damping"))]]);
        }
        let (slide, turn) = match all[..] {
            [slide, turn] => (slide, turn),
            [time, ..] if place.over_time => return Some(vec![time]),
            [_, slide, turn] => (slide, turn),
            _ => return Some(all),
        };
        let of = |motion: &Motion| match motion {
            Motion::Slide => vec![slide],
            Motion::Turn => vec![turn],
            Motion::Quaternion => Vec::new(),
        };
        let Some(coordinates) = place.motions else {
            return if self.hinges.is_some() { Some(all) } else { None };
        };
        let motions = match place.key.name {
            "position" | "rest" | "limits" => coordinates.to_vec(),
            _ => of_velocities(coordinates),
        };
        // Pairs of limits are by coordinate, numbers of copies by place in their own list.
        let index = match (place.key.name, at) {
            ("limits", [coordinate, _]) => *coordinate,
            ("limits", _) => 0,
            (_, []) if motions.iter().any(|one| *one != motions[0]) => return Some(vec![MIXED]),
            (_, []) => 0,
            (_, [.., last]) => *last,
        };
        Some(motions.get(if motions.len() == 1 { 0 } else { index }).map_or(all, of))
    }

    /// A formula of parameters, in SI units.
    fn formula(&mut self, place: &Place<'_>, value: &Spanned<DeValue<'_>>, text: &str, at: &[usize]) {
        let subject = format!("{}`{}`", place.element.prefix(), place.key.name);
        let refuse = |error: FormulaError| {
            let finding = Finding::error(value.span(), format!("{subject}: {}", error.message)).within(error.span);
            self.findings.push_value(finding.maybe_help(error.help));
        };
        let formula = match Formula::parse(text, &self.parameters.names()) {
            Ok(formula) => formula,
            Err(error) => return refuse(error),
        };
        let measure = match formula.measure(&self.parameters.numbers) {
            Ok(measure) => measure,
            Err(error) => return refuse(error),
        };
        let units = self.units(place, at);
        if let Some((message, help)) = misfit(measure, &measure.to_string(), units.as_deref()) {
            const PLAIN: &str = "in a product a number without a unit is a pure number";
            let help = help.map_or_else(|| PLAIN.to_owned(), |help| format!("{help}; {PLAIN}"));
            let span = 0..text.len();
            return refuse(FormulaError { span, message: format!("this formula: {message}"), help: Some(help) });
        }
        let found = formula.value(&self.parameters.values());
        if !found.is_finite() {
            let message = format!("{subject}: this formula gives {found}, which is not a finite number");
            return self.findings.push_value(Finding::error(value.span(), message));
        }
        let span = value.span();
        if is_open(units.as_deref()) {
            self.numbers.open.insert((span.start, span.end), measure);
        }
        self.numbers.insert(&span, found);
    }
}
