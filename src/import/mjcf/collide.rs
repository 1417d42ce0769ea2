//! Which bodies touch, as contacts of a scenario.
//!
//! A contact of a scenario holds for all shapes of two bodies. Geoms of one body that touch in different ways become shapes
//! of bodies that are welded to it: a [`Collider`] is a body or such a part of one.

use super::super::draft::{Draft, Entry};
use super::super::log::{Problem, Taken};
use super::pose::{clean, roll_pitch_yaw};
use super::scene::{Drawn, Scene, Solid, WORLD};
use super::touch::{Pair, Touch};
use crate::budget::CONTACTS;
use nalgebra::Vector3;
use std::collections::{BTreeMap, HashMap, HashSet};
use toml_edit::Array;

/// A pattern for all bodies saves so many contacts at least.
const WORTH: usize = 3;

/// Geoms of one body that touch in one way.
#[derive(Debug)]
pub(super) struct Collider {
    pub(super) body: usize,
    /// Places in the list of the body's shapes.
    pub(super) shapes: Vec<usize>,
    /// How its geoms touch.
    touch: Touch,
    /// Whether it is the body itself; the other ones are welded to it.
    pub(super) own: bool,
    pub(super) name: String,
}

/// What touches what.
#[derive(Debug, Default)]
pub(super) struct Colliders {
    pub(super) list: Vec<Collider>,
    /// The contacts of a scenario, in order.
    pub(super) contacts: Vec<Entry>,
}

/// How two colliders touch.
#[derive(Debug, Clone, Copy)]
struct Wanted<'p> {
    friction: f64,
    pair: Option<&'p Pair>,
}

impl Colliders {
    /// Finds what touches. `called` says what a body is called, and whether other bodies can hang on it; `unique` finds names
    /// for parts of bodies; `all` is the pattern that fits every body of the model.
    pub(super) fn new(
        scene: &Scene<'_>,
        called: impl Fn(usize) -> (String, bool),
        mut unique: impl FnMut(String) -> String,
        all: &str,
    ) -> Self {
        if !scene.settings.contacts {
            return Self::default();
        }
        let mut list = Vec::new();
        let paired: HashSet<(usize, Option<usize>)> =
            scene.pairs.iter().flat_map(|pair| pair.geoms.map(|geom| scene.geoms[geom])).collect();
        for (body, of) in scene.bodies.iter().enumerate() {
            let first = list.len();
            for (at, shape) in of.shapes.iter().enumerate() {
                let Some(touch) = &shape.touch else { continue };
                let alone = paired.contains(&(body, Some(at)));
                if !alone && !touch.is_willing() {
                    continue;
                }
                let alike = |other: &&mut Collider| {
                    touch.is_like(&other.touch) && !alone && !paired.contains(&(body, Some(other.shapes[0])))
                };
                match list[first..].iter_mut().find(alike) {
                    Some(other) => other.shapes.push(at),
                    None => {
                        let (name, own) = (called(body).0, list.len() == first);
                        list.push(Collider { body, shapes: vec![at], touch: touch.clone(), own, name });
                    }
                }
            }
        }
        for collider in list.iter_mut().filter(|collider| !collider.own) {
            let part = collider.touch.name.as_deref().unwrap_or("contact");
            collider.name = unique(format!("{}/{part}", collider.name));
        }
        list.retain(|collider| {
            let starred = collider.name.contains('*');
            if starred {
                let what = "its name has a `*`, which stands for any text in a contact: it touches nothing";
                scene.bodies[collider.body].element.note(Taken::Ignored, what);
            }
            !starred
        });
        let contacts = Finder::new(scene, &list, called).contacts(all);
        Self { list, contacts }
    }
}

impl Colliders {
    /// Writes the shapes of a body: those that touch, and those that are only drawn.
    pub(super) fn shapes(&self, entry: &mut Entry, scene: &Scene<'_>, body: usize) {
        let elsewhere = |at: usize| self.of(body).any(|it| !it.own && it.shapes.contains(&at));
        let touches = |at: usize| self.of(body).any(|it| it.own && it.shapes.contains(&at));
        let here = scene.bodies[body].shapes.iter().enumerate().filter(|(at, _)| !elsewhere(*at));
        let shape = |(at, drawn): (usize, &Drawn)| {
            let touches = scene.settings.contacts.then(|| touches(at));
            (drawn.visible || touches == Some(true)).then(|| shape(drawn, scene.origin(body), touches))
        };
        entry.lines("shape", here.filter_map(shape).collect());
    }

    /// Adds the parts of a body that touch in another way than the body itself.
    pub(super) fn parts(&self, scene: &Scene<'_>, body: usize, called: &str, draft: &mut Draft) {
        for part in self.of(body).filter(|it| !it.own) {
            let mut entry = Entry::new(Some(scene.bodies[body].shapes[part.shapes[0]].place.clone()));
            entry.comment(&format!("Touches in another way than other geoms of `{called}`"));
            entry.set("name", part.name.as_str(), None);
            let drawn = part.shapes.iter().map(|at| &scene.bodies[body].shapes[*at]);
            entry.lines("shape", drawn.map(|drawn| shape(drawn, scene.origin(body), Some(true))).collect());
            let mut hinge = Entry::new(None);
            hinge.set("type", "fixed", None);
            hinge.set("parent", called, None);
            entry.inline("hinge", hinge);
            draft.add("body", entry);
        }
    }

    fn of(&self, body: usize) -> impl Iterator<Item = &Collider> {
        self.list.iter().filter(move |collider| collider.body == body)
    }
}

/// A shape of a body whose root marker stands at `origin` in the body's own frame.
fn shape(drawn: &Drawn, origin: Vector3<f64>, touches: Option<bool>) -> Entry {
    let mut shape = Entry::new(Some(drawn.place.clone()));
    match &drawn.solid {
        Solid::Numbers(key, numbers) => match numbers[..] {
            [number] => shape.set(key, number, None),
            _ => shape.numbers(key, numbers, None),
        },
        Solid::Mesh(file, scale) => {
            shape.set("mesh", file.as_str(), None);
            if *scale != [1.0; 3] {
                shape.numbers("scale", scale, None);
            }
            if touches == Some(true) {
                shape.set("hull", true, None);
            }
        }
    }
    for (key, vector) in [("at", drawn.pose.translation.vector - origin), ("rpy", roll_pitch_yaw(&drawn.pose.rotation))]
    {
        let numbers = clean(vector);
        if numbers != [0.0; 3] {
            shape.numbers(key, &numbers, None);
        }
    }
    if let Some(color) = drawn.color {
        let parts = if color[3] == 1.0 { &color[..3] } else { &color[..] };
        shape.numbers("color", parts, None);
    }
    if touches == Some(false) {
        shape.set("contact", false, None);
    }
    if !drawn.visible {
        shape.set("visible", false, None);
    }
    shape
}

struct Finder<'s, 'a> {
    scene: &'s Scene<'a>,
    list: &'s [Collider],
    /// Of every body the one that it is welded to, directly or not: itself if it moves.
    weld: Vec<usize>,
    excluded: HashSet<[usize; 2]>,
    /// By places in the list of colliders, the smaller first.
    pairs: HashMap<[usize; 2], &'s Pair>,
    /// Of every collider the one on which its body hangs by a single hinge.
    above: Vec<Option<usize>>,
}

fn sorted(one: usize, other: usize) -> [usize; 2] {
    [one.min(other), one.max(other)]
}

impl<'s, 'a> Finder<'s, 'a> {
    fn new(scene: &'s Scene<'a>, list: &'s [Collider], called: impl Fn(usize) -> (String, bool)) -> Self {
        let mut weld: Vec<usize> = Vec::with_capacity(scene.bodies.len());
        for (index, body) in scene.bodies.iter().enumerate() {
            weld.push(if index != WORLD && body.joints.is_empty() { weld[body.parent] } else { index });
        }
        let own: HashMap<usize, usize> =
            list.iter().enumerate().filter(|(_, collider)| collider.own).map(|(at, it)| (it.body, at)).collect();
        let above = list.iter().map(|collider| {
            let body = &scene.bodies[collider.body];
            let hangs = collider.own && collider.body != WORLD && body.joints.len() <= 1 && called(body.parent).1;
            if hangs { own.get(&body.parent).copied() } else { None }
        });
        let place = |geom: usize| {
            let (body, shape) = scene.geoms[geom];
            list.iter().position(|it| it.body == body && shape.is_some_and(|shape| it.shapes.contains(&shape)))
        };
        let ends = |pair: &'s Pair| Some((sorted(place(pair.geoms[0])?, place(pair.geoms[1])?), pair));
        Self {
            excluded: scene.excluded.iter().map(|[one, other]| sorted(*one, *other)).collect(),
            pairs: scene.pairs.iter().filter_map(ends).collect(),
            above: above.collect(),
            scene,
            list,
            weld,
        }
    }

    /// How MuJoCo lets two colliders touch.
    fn wanted(&self, i: usize, j: usize) -> Option<Wanted<'s>> {
        let (one, other) = (&self.list[i], &self.list[j]);
        let welds = [self.weld[one.body], self.weld[other.body]];
        if welds[0] == welds[1] {
            return None;
        }
        if let Some(pair) = self.pairs.get(&sorted(i, j)) {
            return Some(Wanted { friction: pair.friction, pair: Some(pair) });
        }
        let above = |weld: usize| self.weld[self.scene.bodies[weld].parent];
        let moving = welds[0] != WORLD && welds[1] != WORLD;
        let neighbours = moving && (above(welds[0]) == welds[1] || above(welds[1]) == welds[0]);
        if neighbours && self.scene.settings.filter_parent
            || self.excluded.contains(&sorted(one.body, other.body))
            || !one.touch.meets(&other.touch)
        {
            return None;
        }
        Some(Wanted { friction: one.touch.friction_with(&other.touch), pair: None })
    }

    /// Whether a pattern that fits both lets a scenario's bodies touch.
    fn eligible(&self, i: usize, j: usize) -> bool {
        let welded = self.weld[self.list[i].body] == self.weld[self.list[j].body];
        !welded && self.above[i] != Some(j) && self.above[j] != Some(i)
    }

    /// The coefficient that a collider has with most others if it touches all that a pattern would let it touch, otherwise
    /// `None`. `covered` says what earlier contacts give a pair.
    fn row(&self, i: usize, covered: impl Fn(usize) -> Option<f64>) -> Option<f64> {
        let mut count: BTreeMap<u64, usize> = BTreeMap::new();
        for j in (0..self.list.len()).filter(|j| *j != i && self.eligible(i, *j)) {
            let wanted = self.wanted(i, j)?;
            if covered(j) != Some(wanted.friction) {
                *count.entry(wanted.friction.to_bits()).or_default() += 1;
            }
        }
        let (bits, most) = count.into_iter().max_by_key(|(_, count)| *count)?;
        (most >= WORTH).then(|| f64::from_bits(bits))
    }

    fn contacts(&self, all: &str) -> Vec<Entry> {
        let count = self.list.len();
        let mut entries = Vec::new();
        let every = |i: usize| (0..i).filter(move |j| self.eligible(i, *j)).map(move |j| self.wanted(i, j));
        let mut of_all: BTreeMap<u64, usize> = BTreeMap::new();
        let whole = (0..count)
            .flat_map(every)
            .all(|wanted| wanted.inspect(|it| *of_all.entry(it.friction.to_bits()).or_default() += 1).is_some());
        let of_all = of_all.into_iter().max_by_key(|(_, count)| *count).filter(|(_, most)| whole && *most >= WORTH);
        let of_all = of_all.map(|(bits, _)| f64::from_bits(bits));
        entries.extend(of_all.map(|friction| contact([all, all], friction, None)));
        let mut rows: Vec<Option<f64>> = vec![None; count];
        for i in 0..count {
            let covered = |j: usize| rows[j].filter(|_| j < i).or(of_all);
            rows[i] = self.row(i, covered);
            entries.extend(rows[i].map(|friction| contact([&self.list[i].name, all], friction, None)));
        }
        for i in 0..count {
            for j in i + 1..count {
                let covered = rows[j].or(rows[i]).or(of_all).filter(|_| self.eligible(i, j));
                let Some(wanted) = self.wanted(i, j) else { continue };
                if covered == Some(wanted.friction) && wanted.pair.is_none() {
                    continue;
                }
                if entries.len() == CONTACTS {
                    self.refuse();
                    return entries;
                }
                let names = [&self.list[i].name, &self.list[j].name].map(String::as_str);
                entries.push(contact(names, wanted.friction, wanted.pair.and_then(|pair| pair.name.as_deref())));
            }
        }
        entries
    }

    fn refuse(&self) {
        let root = self.scene.bodies[WORLD].element;
        let message = format!("its {} colliding bodies touch in more than {CONTACTS} pairs", self.list.len());
        let help = "write them in the scenario as patterns, with `[[contact]]`, and leave out `contact = true`";
        root.refuse(Problem::at(root.place(), message).help(help));
    }
}

fn contact(between: [&str; 2], friction: f64, name: Option<&str>) -> Entry {
    let mut entry = Entry::new(None);
    if let Some(name) = name {
        entry.set("name", name, None);
    }
    entry.set("between", between.into_iter().collect::<Array>(), None);
    if friction > 0.0 {
        entry.set("friction", friction, None);
    }
    entry
}
