//! What a user asks of statics.

use crate::model::Parameter;

/// The `[statics]` table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Which equilibrium.
    pub want: Want,
    /// How it is found.
    pub method: Method,
    /// How long the search may take (s, > 0; infinite for no limit). A search that it ends says what was found until then.
    pub time_limit: f64,
    /// Contacts are closed to this part of the smaller shape, > 0.
    pub gap: f64,
    /// Whether a scene with contact that does not stand as it is given is moved until it does.
    pub settle: bool,
}

/// What may move while a pose with friction or contact stands.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Margin {
    /// Numbers of the scene.
    pub numbers: Vec<Parameter>,
    /// Whether the scene is tilted.
    pub tilt: bool,
}

/// A number that an output shall have at the equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct Aim {
    /// The output, or one number of it: `camber`, `tip[2]`.
    pub output: String,
    /// In its SI unit.
    pub value: f64,
}

/// Numbers of the scene that are found: so that they hold the pose as it is given, or, with an aim, so that the equilibrium has
/// these outputs.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sought<'a> {
    /// The numbers; none if the scene has all of its numbers.
    pub unknown: &'a [Parameter],
    /// What outputs shall be.
    pub aim: &'a [Aim],
}

impl Settings {
    /// The time limit of a scene that gives none (s).
    pub const TIME_LIMIT: f64 = 60.0;
    /// The gap of a scene that gives none.
    pub const GAP: f64 = 1e-6;
}

impl Default for Settings {
    fn default() -> Self {
        let (want, method) = (Want::default(), Method::default());
        Self { want, method, time_limit: Self::TIME_LIMIT, gap: Self::GAP, settle: false }
    }
}

/// Which equilibrium is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Want {
    /// A stable one: a saddle is left, and said so.
    #[default]
    Stable,
    /// The nearest one, whatever it is.
    Any,
}

/// How the equilibrium is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// The cascade.
    #[default]
    Auto,
    /// Newton on the differentiated transfer equations alone.
    Newton,
    /// Dynamic relaxation: an explicit motion with kinetic damping.
    Relaxation,
    /// Lagrange's equations of the first kind in maximal coordinates.
    Lagrange,
}

impl Method {
    /// All methods, the cascade first.
    pub const ALL: [Self; 4] = [Self::Auto, Self::Newton, Self::Relaxation, Self::Lagrange];

    /// The name in scenario files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Newton => "newton",
            Self::Relaxation => "relaxation",
            Self::Lagrange => "lagrange",
        }
    }
}
