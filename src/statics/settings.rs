//! What a user asks of statics.

/// The `(statics)` table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Which equilibrium.
    pub want: Want,
    /// How it is found.
    pub method: Method,
    /// How long the search may take (s, > 0; infinite for no limit). A search that it ends says what was found until then.
    pub time_limit: f64,
}

impl Settings {
    /// The time limit of a scene that gives none (s).
    pub const TIME_LIMIT: f64 = 60.0;
}

impl Default for Settings {
    fn default() -> Self {
        Self { want: Want::default(), method: Method::default(), time_limit: Self::TIME_LIMIT }
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
