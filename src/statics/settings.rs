//! What a user asks of statics.

/// The `(statics)` table.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Settings {
    /// Which equilibrium.
    pub want: Want,
    /// How it is found.
    pub method: Method,
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
