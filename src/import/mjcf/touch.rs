//! How geoms touch: `contype`, `conaffinity`, `condim`, `friction`, `priority`, and what `<contact>` says of pairs and bodies.

use super::super::log::Taken;
use super::defaults::{Defaults, Settled};
use super::scene::{Scene, WORLD, find};
use super::tree::Tree;

/// How a geom touches others.
#[derive(Debug, Clone)]
pub(super) struct Touch {
    /// As written.
    pub(super) name: Option<String>,
    /// Two geoms may touch if one has a type that the other is willing to touch.
    pub(super) types: u32,
    pub(super) affinities: u32,
    law: Law,
    /// Of two geoms the law of the one with the higher priority counts.
    priority: f64,
}

/// Friction of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Law {
    /// 1: without friction.
    dimension: u8,
    /// Coefficient of sliding.
    friction: f64,
}

impl Law {
    /// The coefficient that acts.
    fn coefficient(self) -> f64 {
        if self.dimension == 1 { 0.0 } else { self.friction }
    }
}

/// Two geoms that touch whatever else is said, by their places in the list of geoms.
#[derive(Debug, Clone)]
pub(super) struct Pair {
    pub(super) geoms: [usize; 2],
    pub(super) name: Option<String>,
    /// The coefficient that acts; that of the geoms has no part in it.
    pub(super) friction: f64,
}

impl Touch {
    /// Reads what a geom says of it; `None` if it was refused.
    pub(super) fn read(settled: &Settled<'_>, name: Option<String>) -> Option<Self> {
        let mask = |key: &str| Some(settled.attribute(key).map(|at| at.number()).unwrap_or(Some(1.0))? as i64 as u32);
        let friction = match settled.attribute("friction") {
            Some(_) => settled.numbers("friction", 3)?.first().copied().unwrap_or_default(),
            None => 1.0,
        };
        let law = Law { dimension: dimension(settled)?.unwrap_or(3), friction };
        refuse_negative(settled, friction)?;
        let priority = settled.number("priority").unwrap_or(0.0);
        Some(Self { name, types: mask("contype")?, affinities: mask("conaffinity")?, law, priority })
    }

    /// Whether its masks let it touch anything.
    pub(super) fn is_willing(&self) -> bool {
        self.types != 0 || self.affinities != 0
    }

    /// Whether it touches in the same way as another.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let way = |it: &Self| (it.types, it.affinities, it.law, it.priority);
        way(self) == way(other)
    }

    /// Whether the masks of both let them touch.
    pub(super) fn meets(&self, other: &Self) -> bool {
        self.types & other.affinities != 0 || other.types & self.affinities != 0
    }

    fn law_with(&self, other: &Self) -> Law {
        match self.priority.partial_cmp(&other.priority) {
            Some(std::cmp::Ordering::Greater) => self.law,
            Some(std::cmp::Ordering::Less) => other.law,
            _ => Law {
                dimension: self.law.dimension.max(other.law.dimension),
                friction: self.law.friction.max(other.law.friction),
            },
        }
    }

    /// The coefficient of friction between both.
    pub(super) fn friction_with(&self, other: &Self) -> f64 {
        self.law_with(other).coefficient()
    }
}

/// `condim`; `None` if it was refused.
fn dimension(settled: &Settled<'_>) -> Option<Option<u8>> {
    let Some(attribute) = settled.attribute("condim") else { return Some(None) };
    match attribute.number()? {
        1.0 => Some(Some(1)),
        3.0 => Some(Some(3)),
        more @ (4.0 | 6.0) => {
            let what = "there is friction against sliding only, none against spinning or rolling";
            settled.element.note(Taken::Approximated, format!("`condim = \"{more}\"`: {what}"));
            Some(Some(3))
        }
        other => {
            attribute.element.refuse(attribute.wrong(&format!("must be 1, 3, 4 or 6, found {other}")));
            None
        }
    }
}

fn refuse_negative(settled: &Settled<'_>, friction: f64) -> Option<()> {
    if friction >= 0.0 {
        return Some(());
    }
    let attribute = settled.attribute("friction")?;
    attribute.element.refuse(attribute.wrong(&format!("must not be negative, found {friction}")));
    None
}

/// Reads what `<contact>` says in an instance of a model.
pub(super) fn read<'a>(tree: &Tree<'a>, defaults: &Defaults<'a>, scene: &mut Scene<'a>) {
    for element in tree.section("contact") {
        match element.name() {
            "exclude" => {
                let settled = Settled::bare(&element);
                element.text("name");
                let body = |key| find(&settled.element.required(key)?, "body", &scene.names.bodies, scene);
                if let (Some(one), Some(other)) = (body("body1"), body("body2")) {
                    scene.excluded.push([one, other]);
                }
            }
            "pair" => {
                let settled = defaults.of(&element, None);
                let read = pair(&settled, scene);
                scene.pairs.extend(read);
            }
            _ => {}
        }
    }
}

fn pair(settled: &Settled<'_>, scene: &Scene<'_>) -> Option<Pair> {
    let element = settled.element;
    let name = element.text("name").map(str::to_owned);
    let geom = |key| find(&element.required(key)?, "geom", &scene.names.geoms, scene);
    let geoms = [geom("geom1")?, geom("geom2")?];
    let dimension = dimension(settled)?.unwrap_or(3);
    let mut along = [1.0; 2];
    if settled.attribute("friction").is_some() {
        let numbers = settled.numbers("friction", 5)?;
        along.iter_mut().zip(&numbers).for_each(|(own, given)| *own = *given);
    }
    let friction = along[0].min(along[1]);
    refuse_negative(settled, friction)?;
    if along[0] != along[1] && dimension > 1 {
        let what = "its friction depends on the direction: the smaller coefficient counts in all of them";
        element.note(Taken::Approximated, what);
    }
    for geom in geoms {
        let (body, shape) = scene.geoms[geom];
        let touches = shape.is_some_and(|shape| scene.bodies[body].shapes[shape].touch.is_some());
        if !touches {
            element.note(Taken::Ignored, "one of its geoms touches nothing here");
            return None;
        }
    }
    let carrier = |geom: usize| {
        let mut body = scene.geoms[geom].0;
        while body != WORLD && scene.bodies[body].joints.is_empty() {
            body = scene.bodies[body].parent;
        }
        body
    };
    if carrier(geoms[0]) == carrier(geoms[1]) {
        element.note(Taken::Ignored, "its geoms do not move against each other");
        return None;
    }
    Some(Pair { geoms, name, friction: Law { dimension, friction }.coefficient() })
}
