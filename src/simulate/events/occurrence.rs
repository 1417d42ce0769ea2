//! What happens in a run, as it is told.

use crate::model::problem::number;
use std::fmt;

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A coordinate hit a rigid stop and came back.
    Impact,
    /// A coordinate came to rest on a rigid stop.
    Rest,
    /// A coordinate left a rigid stop it rested on.
    Release,
    /// A coordinate ran onto a compliant stop.
    Contact,
    /// A compliant stop no longer pushes.
    Separation,
    /// What dry friction held begins to slide.
    Slip,
    /// What slid comes to rest by dry friction.
    Stick,
    /// Bodies struck each other.
    Strikes,
    /// Bodies that touched do no longer.
    Lifts,
    /// A body goes on beyond the end of another one, carried by others that are level with it.
    GoesOn,
    /// What slid on another body rolls.
    Rolls,
    /// A crossing the user asked for.
    Crossing,
    /// A force element switched; what it calls that.
    Force(&'static str),
    /// A change of structure.
    Stage,
    /// Another integrator took over.
    Switch,
}

impl Kind {
    /// In JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Impact => "impact",
            Self::Rest => "rest",
            Self::Release => "release",
            Self::Contact => "contact",
            Self::Separation => "separation",
            Self::Slip => "slips",
            Self::Stick => "sticks",
            Self::Strikes => "strikes",
            Self::Lifts => "lifts",
            Self::GoesOn => "goes on",
            Self::Rolls => "rolls",
            Self::Crossing => "crossing",
            Self::Force(name) => name,
            Self::Stage => "stage",
            Self::Switch => "switch",
        }
    }
}

/// Something that happened in a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Occurrence {
    /// When (s).
    pub time: f64,
    /// What.
    pub kind: Kind,
    /// The name of the event or force, the body whose hinge it is, or the integrator that took over.
    pub name: String,
    /// The value that was crossed, of a rope the length of its path, of dry friction the coordinate (0 for a spherical hinge); of a
    /// switch the step that led there; of a stage the energy that goes out of motion, gravity and springs with it.
    pub value: f64,
    /// What the value is measured in; `1` is a pure number.
    pub unit: String,
    /// How fast the number changed before (`unit` per second); of a switch nothing; of bodies that strike each other the speed at which
    /// they approach (m/s).
    pub speed: f64,
    /// The names of two bodies that touch, if it is about them.
    pub between: Option<[String; 2]>,
}

impl Occurrence {
    /// What happened, without the time; `shown` writes its numbers.
    pub fn in_words(&self, shown: impl Fn(f64) -> String) -> String {
        let Self { kind, name, speed, between, .. } = self;
        if let Some([one, other]) = between {
            return match kind {
                Kind::Strikes => format!("`{other}` strikes `{one}` at {} m/s", shown(*speed)),
                Kind::Lifts => format!("`{other}` lifts off `{one}`"),
                Kind::GoesOn => format!("`{other}` goes on beyond `{one}`"),
                _ => format!("`{other}` {} on `{one}`", kind.name()),
            };
        }
        let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
        let value = format!("{}{unit}", shown(self.value));
        match kind {
            Kind::Stage if self.value == 0.0 => format!("stage `{name}`"),
            Kind::Stage if self.value < 0.0 => format!("stage `{name}`, which puts in {} J", shown(-self.value)),
            Kind::Stage => format!("stage `{name}`, which takes out {value}"),
            Kind::Switch => format!("`{name}` takes over after a step of {value}"),
            Kind::Slip | Kind::Stick => format!("`{name}` {} at {value}", kind.name()),
            // How fast some outputs change is not known.
            _ if speed.is_nan() => format!("{} of `{name}` at {value}", kind.name()),
            _ => format!("{} of `{name}` at {value}, speed {} {}/s", kind.name(), shown(*speed), self.unit),
        }
    }
}

impl fmt::Display for Occurrence {
    /// Without the time; numbers as in messages.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.in_words(number))
    }
}
