//! Hinges, and their values per coordinate, per velocity and per copy.

use super::check::article;
use super::findings::Finding;
use super::formulas::put_into;
use super::quantities::Parameters;
use super::reader::{Reader, number, numbers, only, rows};
use crate::hinge::Keys;
use crate::model::description::{
    DryFriction, GROUND, GuideCurve, HingeDescription, HingeKind, LimitDescription, Point, StopLaw,
};
use nalgebra::Vector3;
use toml::de::DeValue;

/// A hinge as it is written once, for one body or for all copies of a repeat.
#[derive(Debug)]
pub(super) struct Hinge {
    pub(super) description: HingeDescription,
    /// Where on a copy the following one hangs.
    pub(super) next: Option<Point>,
    /// Values that differ from copy to copy.
    pub(super) each: Vec<(Field, Vec<Vec<f64>>)>,
}

/// A list of a hinge description.
pub(super) type Field = fn(&mut HingeDescription) -> &mut Vec<f64>;

pub(super) fn hinge(body: &Reader<'_>, owner: &str, repeat: Option<usize>, parameters: &Parameters) -> Hinge {
    let Some(table) = body.table("hinge") else {
        return Hinge { description: HingeDescription::new(HingeKind::Fixed), next: None, each: Vec::new() };
    };
    let kind = kind(&table);
    let mut description = HingeDescription::new(kind.unwrap_or(HingeKind::Fixed));
    description.curve = guide(&table, owner, kind, parameters);
    description.parent = table.text("parent").unwrap_or(GROUND).to_owned();
    description.at = point(&table, "at").unwrap_or(description.at);
    description.frame = table.turn("rpy");
    description.lock = table.flag("lock").unwrap_or(false);
    let mut each = Vec::new();
    if let Some(kind) = kind {
        let (positions, velocities) = kind.counts();
        for (key, count, widen, field) in [
            ("position", positions, false, (|h| &mut h.position) as Field),
            ("velocity", velocities, false, |h| &mut h.velocity),
            ("stiffness", velocities, true, |h| &mut h.stiffness),
            ("damping", velocities, true, |h| &mut h.damping),
            ("rest", positions, false, |h| &mut h.rest),
            ("armature", velocities, true, |h| &mut h.armature),
            ("force", velocities, false, |h| &mut h.force),
        ] {
            match (Values { table: &table, owner, kind, key, count, widen, repeat }.read()) {
                Some(PerCopy::Same(list)) => *field(&mut description) = list,
                Some(PerCopy::Each(lists)) => each.push((field, lists)),
                None => {}
            }
        }
    }
    if let Some(kind) = kind {
        description.friction = friction(&table, owner, kind);
    }
    description.limits = limits(&table, owner);
    description.curves = super::curve::in_hinge(&table, owner);
    Hinge { description, next: next(body, &table, owner, repeat), each }
}

pub(super) fn kind(table: &Reader<'_>) -> Option<HingeKind> {
    HingeKind::read(table.text("type")?, table)
}

/// An axis that could not be read has been said already; any other one will do to look at the rest.
impl Keys for Reader<'_> {
    fn axis(&self) -> Vector3<f64> {
        self.vector("axis").unwrap_or_else(Vector3::z)
    }

    fn axes(&self) -> [Vector3<f64>; 2] {
        axes(self).unwrap_or([Vector3::x(), Vector3::y()])
    }

    fn pitch(&self) -> f64 {
        self.number("pitch").unwrap_or(1.0)
    }

    fn turn(&self) -> Option<&str> {
        self.text("turn")
    }
}

/// The curve of a hinge. One that could not be read has been said already; any other one will do to look at the rest.
fn guide(table: &Reader<'_>, owner: &str, kind: Option<HingeKind>, parameters: &Parameters) -> Option<GuideCurve> {
    matches!(kind, Some(HingeKind::Along { .. })).then(|| {
        let read = table.table("curve").and_then(|curve| read_guide(&curve, owner, parameters));
        read.unwrap_or(GuideCurve::Straight { length: 1.0 })
    })
}

fn read_guide(curve: &Reader<'_>, owner: &str, parameters: &Parameters) -> Option<GuideCurve> {
    let what = format!("curve of the hinge of `{owner}`");
    let key = only(curve, &what, &["straight", "points", "helix", "parameter"])?;
    let of_formulas = ["x", "y", "z", "range"];
    if key != "parameter"
        && let Some(other) = of_formulas.iter().find(|other| curve.has(other))
    {
        let message = format!("{what}: `{other}` beside `{key}`");
        let help = "`x`, `y`, `z` and `range` belong to a curve by formulas of its `parameter`";
        curve.findings.push(Finding::error(curve.key_span(other), message).help(help));
        return None;
    }
    match key {
        "straight" => Some(GuideCurve::Straight { length: curve.number("straight")? }),
        "points" => {
            let points = rows(curve.value("points")?.get_ref())?;
            Some(GuideCurve::Points { points: points.iter().map(|point| Vector3::from_column_slice(point)).collect() })
        }
        "helix" => match curve.numbers("helix")?[..] {
            [radius, pitch, turns] => Some(GuideCurve::Helix { radius, pitch, turns }),
            _ => None,
        },
        _ => {
            let parameter = curve.text("parameter")?;
            let place = ["x", "y", "z"].map(|key| {
                let text = curve.text(key).unwrap_or("0");
                // What is no formula is said where the curve is built.
                match parameters.names().is_empty() {
                    true => text.to_owned(),
                    false => put_into(curve, (key, text), &what, &[parameter], parameters),
                }
            });
            let Some(range) = curve.numbers("range").and_then(|range| <[f64; 2]>::try_from(range).ok()) else {
                if !curve.has("range") {
                    let message = format!("{what} has no `range`");
                    let help = "where its parameter begins and ends: `range = [0.0, 1.0]`";
                    curve.findings.push(Finding::error(curve.key_span("parameter"), message).help(help));
                }
                return None;
            };
            Some(GuideCurve::Formulas { parameter: parameter.to_owned(), place, range })
        }
    }
}

pub(super) fn axes(table: &Reader<'_>) -> Option<[Vector3<f64>; 2]> {
    match rows(table.value("axes")?.get_ref())?.as_slice() {
        [first, second] => Some([Vector3::from_column_slice(first), Vector3::from_column_slice(second)]),
        _ => None,
    }
}

/// Coordinates or a marker's name.
pub(super) fn point(table: &Reader<'_>, key: &str) -> Option<Point> {
    table.text(key).map(|marker| Point::Marker(marker.to_owned())).or_else(|| table.vector(key).map(Point::At))
}

/// `next`, written in the hinge or beside `repeat`.
fn next(body: &Reader<'_>, hinge: &Reader<'_>, owner: &str, repeat: Option<usize>) -> Option<Point> {
    if body.has("next") && hinge.has("next") {
        let message = format!("body `{owner}`: `next` is given twice");
        let help = "keep it in the hinge or beside `repeat`";
        body.findings.push(Finding::error(body.key_span("next"), message).help(help));
    }
    let table = if hinge.has("next") { hinge } else { body };
    if table.has("next") && repeat.is_none() && !body.has("repeat") {
        let message = format!("body `{owner}`: `next` without `repeat`");
        let help = "`next` says where on a copy the following one hangs";
        body.findings.push(Finding::error(table.key_span("next"), message).help(help));
    }
    point(table, "next")
}

/// Dry friction per velocity: one value for all, or a list.
fn friction(table: &Reader<'_>, owner: &str, kind: HingeKind) -> Vec<DryFriction> {
    let Some(value) = table.value("friction") else { return Vec::new() };
    let velocities = kind.counts().1;
    let Some(items) = value.get_ref().as_array() else {
        return super::contact::friction(table, value).map_or_else(Vec::new, |one| vec![one; velocities]);
    };
    if items.len() != velocities {
        let name = kind.name();
        let message = format!(
            "hinge of body `{owner}`: `friction` of a {name} hinge is one value or a list of {velocities}; found a list of {}",
            items.len()
        );
        table.findings.push_value(Finding::error(value.span(), message));
    }
    items.iter().filter_map(|item| super::contact::friction(table, item)).collect()
}

/// Stops: a pair, a pair per coordinate, one in full, or a list of those.
fn limits(table: &Reader<'_>, owner: &str) -> Vec<LimitDescription> {
    let Some(value) = table.value("limits") else { return Vec::new() };
    if let Some(inner) = table.open(value) {
        return limit(&inner, owner).into_iter().collect();
    }
    let in_full = value.get_ref().as_array().filter(|items| items.iter().all(|item| item.get_ref().is_table()));
    if let Some(items) = in_full {
        return items.iter().filter_map(|item| limit(&table.open(item)?, owner)).collect();
    }
    let pairs = rows(value.get_ref()).or_else(|| numbers(value.get_ref()).map(|pair| vec![pair])).unwrap_or_default();
    let mut limits = Vec::new();
    for (coordinate, pair) in pairs.iter().enumerate() {
        let [low, high] = pair[..] else { continue };
        if low >= high {
            let message = format!("hinge of body `{owner}`: `limits` from {low} to {high} leave no room");
            table.findings.push_value(Finding::error(value.span(), message).label("the lower limit comes first"));
            return Vec::new();
        }
        limits.push(LimitDescription { coordinate, low, high, law: StopLaw::Rigid { restitution: 0.0 } });
    }
    limits
}

fn limit(table: &Reader<'_>, owner: &str) -> Option<LimitDescription> {
    if !table.has("low") && !table.has("high") {
        let message = format!("hinge of body `{owner}`: `limits` without `low` and `high` limit nothing");
        table.findings.push(Finding::error(table.span.clone(), message));
    }
    let law = super::contact::law(table, &format!("hinge of body `{owner}`"), "a stop");
    let coordinate = table.count("coordinate").unwrap_or(0);
    let (low, high) = (table.number("low"), table.number("high"));
    (low.is_some() || high.is_some()).then(|| LimitDescription {
        coordinate,
        low: low.unwrap_or(f64::NEG_INFINITY),
        high: high.unwrap_or(f64::INFINITY),
        law,
    })
}

/// A value for all copies or one for each.
#[derive(Debug, PartialEq)]
enum PerCopy {
    Same(Vec<f64>),
    Each(Vec<Vec<f64>>),
}

/// A key that holds one number per coordinate or velocity.
struct Values<'v> {
    table: &'v Reader<'v>,
    owner: &'v str,
    kind: HingeKind,
    key: &'static str,
    count: usize,
    /// One number stands for all.
    widen: bool,
    repeat: Option<usize>,
}

impl Values<'_> {
    fn read(&self) -> Option<PerCopy> {
        let value = self.table.value(self.key)?.get_ref();
        if self.count == 0 {
            return None;
        }
        let read = match number(value) {
            Some(number) if self.count == 1 || self.widen => Some(PerCopy::Same(vec![number; self.count])),
            Some(_) => None,
            None => match numbers(value) {
                Some(list) => self.list(list),
                None => rows(value).and_then(|rows| self.rows(rows)),
            },
        };
        if read.is_none() {
            self.refuse(value);
        }
        read
    }

    fn list(&self, list: Vec<f64>) -> Option<PerCopy> {
        match self.repeat {
            _ if list.len() == self.count => Some(PerCopy::Same(list)),
            Some(copies) if self.count == 1 && list.len() == copies => {
                Some(PerCopy::Each(list.into_iter().map(|number| vec![number]).collect()))
            }
            _ => None,
        }
    }

    fn rows(&self, rows: Vec<Vec<f64>>) -> Option<PerCopy> {
        let fits = self.repeat == Some(rows.len()) && rows.iter().all(|row| row.len() == self.count);
        fits.then_some(PerCopy::Each(rows))
    }

    fn refuse(&self, value: &DeValue<'_>) {
        let one = match (self.count, self.widen) {
            (1, _) => "one number".to_owned(),
            (count, true) => format!("one number or a list of {count}"),
            (count, false) => format!("a list of {count} numbers"),
        };
        let many = match (self.repeat, self.count) {
            (None, _) => String::new(),
            (Some(copies), 1) => format!(", or a list of {copies}, one per copy"),
            (Some(copies), count) => format!(", or a list of {copies} lists of {count}, one per copy"),
        };
        let found = match value.as_array().map(|items| &items[..]) {
            None => "one number".to_owned(),
            Some(items) if items.iter().all(|item| item.get_ref().is_array()) => {
                let lengths = items.iter().filter_map(|item| item.get_ref().as_array()).map(|row| row.len());
                match lengths.clone().find(|length| *length != self.count) {
                    Some(length) => format!("a list of {} lists, one of them of {length}", items.len()),
                    None => format!("a list of {} lists", items.len()),
                }
            }
            Some(items) => format!("a list of {}", items.len()),
        };
        let message = format!(
            "hinge of body `{}`: `{}` of {} {} hinge must be {one}{many}; found {found}",
            self.owner,
            self.key,
            article(self.kind.name()),
            self.kind.name()
        );
        let order = self.order().map(|order| format!("in this order: {order}"));
        self.table.findings.push_value(Finding::error(self.table.span_of(self.key), message).maybe_help(order));
    }

    fn order(&self) -> Option<&'static str> {
        let [coordinates, velocities] = self.kind.order()?;
        Some(if matches!(self.key, "position" | "rest") { coordinates } else { velocities })
    }
}
