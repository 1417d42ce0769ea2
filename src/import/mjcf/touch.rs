//! How geoms touch: `contype`, `conaffinity`, `condim`, `friction`, `priority`.

use super::super::log::Taken;
use super::defaults::Settled;

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

impl Pair {
    /// With the coefficient of sliding of a contact of so many dimensions.
    pub(super) fn new(geoms: [usize; 2], name: Option<String>, dimension: u8, friction: f64) -> Self {
        Self { geoms, name, friction: Law { dimension, friction }.coefficient() }
    }
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
pub(super) fn dimension(settled: &Settled<'_>) -> Option<Option<u8>> {
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

/// `None` if a coefficient is negative: it was refused.
pub(super) fn refuse_negative(settled: &Settled<'_>, friction: f64) -> Option<()> {
    if friction >= 0.0 {
        return Some(());
    }
    let attribute = settled.attribute("friction")?;
    attribute.element.refuse(attribute.wrong(&format!("must not be negative, found {friction}")));
    None
}
