//! What two paths set both.
//!
//! A path stands for one entry of a scenario or for many: a key of every hinge, of all copies of a body, all components of a list, a
//! table with all of its keys. Where two paths share an entry the one that is set last stands, and the other is lost.

use super::super::fields::Table;
use super::super::format::{BODY, HINGE, SCENARIO};
use super::super::{Scenario, document};
use super::{Override, component, element, entries, first_key, full_path, holds_table, split_component, walk, within};
use crate::model::address::Target;
use std::fmt::Write;
use toml::de::{DeTable, DeValue};

/// Shared entries that are named.
const MOST_NAMED: usize = 3;
/// The parts of a bushing's six numbers, which may be set by one key as well: where they begin.
const PARTS_OF_SIX: [(&str, usize); 2] = [(".translation", 0), (".rotation", 3)];

impl Scenario {
    /// The first two of several paths that set one entry both: their places, and the entries, in words. `set` are changes with which the
    /// scenario has been read.
    pub fn overlap(&self, set: &[Override], paths: &[&str]) -> Option<(usize, usize, String)> {
        // Reading again is spared where there is nothing to compare.
        if paths.len() < 2 {
            return None;
        }
        self.in_document(set, |document| {
            let of: Vec<Vec<Spot>> = paths.iter().map(|path| spots(path, document)).collect();
            (1..of.len()).find_map(|later| {
                (0..later).find_map(|first| {
                    let both = shared(&of[first], &of[later]);
                    (!both.is_empty()).then(|| (first, later, words(&both)))
                })
            })
        })
    }

    /// The first change that changes nothing because all that it sets is set by these paths after it: its place, those of the paths, and
    /// the entries, in words. A change of more than that is none: the rest of it stands.
    pub fn lost(&self, set: &[Override], paths: &[&str]) -> Option<(usize, Vec<usize>, String)> {
        if paths.is_empty() || set.is_empty() {
            return None;
        }
        self.in_document(set, |document| {
            let of: Vec<Vec<Spot>> = paths.iter().map(|path| spots(path, document)).collect();
            set.iter().enumerate().find_map(|(place, change)| {
                let own = spots(change.path(), document);
                let is_lost = !own.is_empty() && own.iter().all(|spot| spot.is_covered(&of));
                let by = (0..of.len()).filter(|path| !shared(&own, &of[*path]).is_empty());
                is_lost.then(|| (place, by.collect(), words(&own)))
            })
        })
    }

    pub(super) fn in_document<T>(&self, set: &[Override], then: impl FnOnce(&DeTable<'_>) -> Option<T>) -> Option<T> {
        let changes: Vec<&Override> = set.iter().collect();
        document(&self.name, &self.text, &changes, |document, _, _, _| then(document)).0.flatten()
    }
}

/// An entry, or all entries of some copies, components or keys.
#[derive(Debug, Clone)]
struct Spot {
    /// The list of the file and the place in it; `None` for a key of the file itself.
    element: Option<(&'static str, usize)>,
    /// What the element is called.
    name: String,
    copies: usize,
    /// `None`: all copies.
    copy: Option<usize>,
    /// As in the file.
    key: String,
    /// Components of the value; 0 if that is not known.
    count: usize,
    /// `None`: all components.
    component: Option<usize>,
}

impl Spot {
    /// The key with the component, as the keys of what is within this begin.
    fn entry(&self) -> String {
        self.component.map_or_else(|| self.key.clone(), |component| format!("{}[{component}]", self.key))
    }

    /// Whether all of this is within another key, or within the component of it that is meant.
    fn is_inside(&self, outer: &Self) -> bool {
        self.key == outer.key || is_within(&self.key, &outer.entry())
    }

    /// What both stand for.
    fn shared(&self, other: &Self) -> Option<Self> {
        if self.element != other.element {
            return None;
        }
        let inner = [(self, other), (other, self)].into_iter().find(|(inner, outer)| inner.is_inside(outer));
        let (inner, outer) = inner?;
        let copy = common(inner.copy, outer.copy)?;
        let component = match inner.key == outer.key {
            true => common(inner.component, outer.component)?,
            false => inner.component,
        };
        Some(Self { copy, component, ..inner.clone() })
    }

    fn covers(&self, other: &Self) -> bool {
        let has = |own: Option<usize>, other: Option<usize>| own.is_none() || own == other;
        self.element == other.element
            && other.is_inside(self)
            && has(self.copy, other.copy)
            && (self.key != other.key || has(self.component, other.component))
    }

    /// Whether paths set all of it, by themselves or together.
    fn is_covered(&self, paths: &[Vec<Self>]) -> bool {
        let each_copy = |copy: usize| Self { copy: Some(copy), ..self.clone() }.is_covered(paths);
        let each_component = |index: usize| Self { component: Some(index), ..self.clone() }.is_covered(paths);
        paths.iter().flatten().any(|spot| spot.covers(self))
            || self.copy.is_none() && self.copies > 0 && (0..self.copies).all(each_copy)
            || self.component.is_none() && self.count > 0 && (0..self.count).all(each_component)
    }

    /// As after `--set`.
    fn address(&self) -> String {
        let mut address = self.name.clone();
        if let Some(copy) = self.copy {
            let _ = write!(address, "[{copy}]");
        }
        let is_body = self.element.is_some_and(|(list, _)| list == BODY.name);
        let short = self.key.strip_prefix("hinge.").filter(|key| is_body && !declares(&BODY, first_key(key)));
        let dot = if self.element.is_some() { "." } else { "" };
        address += &format!("{dot}{}", short.unwrap_or(&self.key));
        if let Some(component) = self.component {
            let _ = write!(address, "[{component}]");
        }
        address
    }

    /// One entry under one name: of a hinge with one coordinate there is a component for each copy, if for anything.
    fn settled(mut self, table: &DeTable<'_>) -> Self {
        let is_body = self.element.is_some_and(|(list, _)| list == BODY.name);
        if !is_body || component::count(table, &self.key) != Some(1) {
            return self;
        }
        let written = walk(table, &self.key, true).and_then(|value| value.get_ref().as_array());
        let is_list = written.is_some_and(|items| items.iter().all(|item| !item.get_ref().is_array()));
        if self.copy.is_none() && self.copies > 0 && is_list {
            self.copy = self.component.take();
        }
        self.component = self.component.filter(|index| *index > 0);
        self.count = 0;
        self
    }

    /// Part of six numbers by its components, as it may be set, too.
    fn in_six(self) -> Vec<Self> {
        let part =
            PARTS_OF_SIX.into_iter().find_map(|(end, from)| Some((self.key.strip_suffix(end)?.to_owned(), from)));
        match part.filter(|_| self.element.is_some_and(|(list, _)| list == "force")) {
            None => vec![self],
            Some((key, from)) => {
                let indices = self.component.map_or(0..3, |index| index..index + 1);
                let one = |index| Self { key: key.clone(), component: Some(from + index), count: 6, ..self.clone() };
                indices.map(one).collect()
            }
        }
    }
}

fn declares(table: &Table, key: &str) -> bool {
    table.declarations(key).next().is_some()
}

/// The one of both that is chosen, if they do not choose differently.
fn common(one: Option<usize>, other: Option<usize>) -> Option<Option<usize>> {
    match (one, other) {
        (Some(one), Some(other)) if one != other => None,
        _ => Some(one.or(other)),
    }
}

/// Whether a key is another, or one of the table that the other is; names of markers may hold dots.
fn is_within(inner: &str, outer: &str) -> bool {
    let rest = inner.strip_prefix(outer);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']) && !outer.starts_with("markers."))
}

fn shared(some: &[Spot], others: &[Spot]) -> Vec<Spot> {
    some.iter().flat_map(|one| others.iter().filter_map(|other| one.shared(other))).collect()
}

/// The first entries by their addresses.
fn words(spots: &[Spot]) -> String {
    let named: Vec<String> = spots.iter().take(MOST_NAMED).map(|spot| format!("`{}`", spot.address())).collect();
    match spots.len() - named.len() {
        0 => named.join(", "),
        more => format!("{} and {more} more", named.join(", ")),
    }
}

/// What a path stands for, as a change of it is applied; nothing where that is refused.
fn spots(path: &str, document: &DeTable<'_>) -> Vec<Spot> {
    let first = first_key(path);
    let is_setting = SCENARIO
        .declarations(first)
        .next()
        .is_some_and(|key| holds_table(&key.kind) || split_component(path).0 == first && key.kind.elements().is_none());
    if is_setting {
        return vec![spot(None, (document, &SCENARIO), None, path)];
    }
    if let Some(Target { element: (list, index), copy, rest }) = element(path, document) {
        let Some(key) = full_path(list, rest) else { return Vec::new() };
        let Some(table) = table_of(document, list.name, index) else { return Vec::new() };
        let mut spot = spot(Some((list.name, index)), (table, list), copy, &key);
        if let Some(entry) =
            entries(document).find(|entry| entry.element.0.name == list.name && entry.element.1 == index)
        {
            spot.name = match entry.name {
                "" => format!("{}[{index}]", list.name),
                name => name.to_owned(),
            };
            spot.copies = entry.copies.unwrap_or(0);
        }
        return spot.settled(table).in_six();
    }
    path.strip_prefix("hinge.").map_or_else(Vec::new, |key| every_hinge(document, key))
}

fn spot(
    element: Option<(&'static str, usize)>,
    (table, declared): (&DeTable<'_>, &'static Table),
    copy: Option<usize>,
    path: &str,
) -> Spot {
    if within::is_within_a_list(table, path) {
        let path = within::plainly(path);
        let (key, component) = split_component(&path);
        let written = within::value(table, key).and_then(|value| value.get_ref().as_array());
        let count = written.map_or(0, |items| items.len());
        return Spot { element, name: String::new(), copies: 0, copy, key: key.to_owned(), count, component };
    }
    let (plain, component) = split_component(path);
    // Names of markers and parameters may end like a component.
    let (key, component) = match component.filter(|_| copy.is_some() || walk(table, path, true).is_none()) {
        Some(index) => (plain, Some(index)),
        None => (path, None),
    };
    let length = |value: &DeValue<'_>| value.as_array().map(|items| items.len());
    let written = || length(walk(table, key, true)?.get_ref());
    let default = || declared.declarations(key).find_map(|key| length(DeValue::parse(key.default).ok()?.get_ref()));
    let of_body = || component::count(table, key).filter(|_| element.is_some_and(|(list, _)| list == BODY.name));
    let count = of_body().or_else(written).or_else(default).unwrap_or(0);
    Spot { element, name: String::new(), copies: 0, copy, key: key.to_owned(), count, component }
}

/// The hinges that have a key.
fn every_hinge(document: &DeTable<'_>, key: &str) -> Vec<Spot> {
    let (plain, index) = split_component(key);
    let of = |entry: crate::model::address::Entry<'_, (&'static Table, usize)>| {
        let (list, place) = entry.element;
        let body = table_of(document, list.name, place).filter(|_| list.name == BODY.name)?;
        let hinge = body.get("hinge")?.get_ref().as_table()?;
        let of_type = hinge.get("type").and_then(|of_type| of_type.get_ref().as_str()).unwrap_or_default();
        let has_component = index.is_none_or(|index| component::count(body, plain).is_some_and(|count| index < count));
        if !has_component || !HINGE.declarations(first_key(key)).any(|key| key.belongs_to(of_type)) {
            return None;
        }
        let spot = spot(Some((list.name, place)), (body, list), None, &format!("hinge.{key}"));
        Some(Spot { name: entry.name.to_owned(), copies: entry.copies.unwrap_or(0), ..spot }.settled(body))
    };
    entries(document).filter_map(of).collect()
}

fn table_of<'t, 'a>(document: &'t DeTable<'a>, list: &str, index: usize) -> Option<&'t DeTable<'a>> {
    document.get(list)?.get_ref().as_array()?.get(index)?.get_ref().as_table()
}

#[cfg(test)]
mod tests {
    use super::super::super::parse;

    const SCENE: &str = r#"
        [parameters]
        k = 5.0
        [[body]]
        name = "a"
        mass = 1.0
        inertia = [0.1, 0.1, 0.1]
        hinge = { type = "revolute", axis = [0, 1, 0], stiffness = "{k}" }
        [[body]]
        name = "link"
        mass = [1.0, 2.0, 3.0]
        inertia = [0.1, 0.1, 0.1]
        repeat = 3
        hinge = { type = "planar", parent = "a", at = [0, 0, -1] }
        [[force]]
        name = "mount"
        type = "bushing"
        between = [{ body = "a", at = [0, 0, 0] }, { body = "ground", at = [0, 0, 0] }]
        stiffness = { translation = 5.0, rotation = 1.0 }
    "#;

    #[test]
    fn paths_overlap_where_they_share_an_entry() {
        let scene = parse("scene.toml", SCENE, &[]).expect("a scene");
        let both = |one: &str, other: &str| scene.overlap(&[], &[one, other]).map(|(_, _, words)| words);
        for (one, other, shared) in [
            ("gravity", "gravity[2]", "`gravity[2]`"),
            ("gravity[02]", "gravity[2]", "`gravity[2]`"),
            ("hinge.stiffness", "a.stiffness", "`a.stiffness`"),
            ("hinge.stiffness[0]", "a.hinge.stiffness", "`a.stiffness`"),
            ("hinge.damping", "link[1].damping[2]", "`link[1].damping[2]`"),
            ("link.damping[2]", "link[1].damping", "`link[1].damping[2]`"),
            ("link.mass[1]", "link[1].mass", "`link[1].mass`"),
            ("a.hinge", "a.rest", "`a.rest`"),
            ("mount.between[0]", "mount.between[00].at[2]", "`mount.between[0].at[2]`"),
            ("force[0].between[0].at", "mount.between[0].at[2]", "`mount.between[0].at[2]`"),
            ("mount.between", "mount.between[1].at[0]", "`mount.between[1].at[0]`"),
            ("force[0].stiffness", "mount.stiffness.rotation[1]", "`mount.stiffness[4]`"),
            ("hinge.damping", "hinge.damping", "`a.damping`, `link.damping`"),
        ] {
            let expected = Some(shared.to_owned());
            assert_eq!(both(one, other), expected, "{one} {other}");
            assert_eq!(both(other, one), expected, "{other} {one}");
        }
        for (one, other) in [
            ("gravity[1]", "gravity[2]"),
            ("mount.between[0]", "mount.between[1].at[2]"),
            ("mount.between[1].at[0]", "mount.between[1].at[2]"),
            ("mount.between[0].at", "mount.between[1].at"),
            ("hinge.stiffness[1]", "a.stiffness"),
            ("hinge.stiffness", "hinge.damping"),
            ("hinge.stiffness", "mount.stiffness"),
            ("link[0].damping", "link[1].damping[2]"),
            ("link.mass[1]", "link[2].mass"),
            ("mount.stiffness[1]", "mount.stiffness.rotation"),
            ("parameters.k", "a.mass"),
            ("simulate.duration", "simulate.start"),
        ] {
            assert_eq!(both(one, other), None, "{one} {other}");
        }
    }
}
