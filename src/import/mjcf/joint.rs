//! `<joint>` and `<freejoint>`.

use super::super::log::Taken;
use super::defaults::Settled;
use super::scene::{Acting, Joint, Kind};
use super::settings::{Settings, choice};
use nalgebra::{Isometry3, Vector3};

/// Reads a joint of a body; `frame` stands between the body and the joint.
pub(super) fn joint<'a>(
    settled: &Settled<'a>,
    settings: &Settings,
    frame: &Isometry3<f64>,
    name: String,
    body: usize,
) -> Joint<'a> {
    let element = settled.element;
    let kind = if element.name() == "freejoint" { Kind::Free } else { kind(settled) };
    let mut joint = Joint {
        element,
        name,
        body,
        kind,
        aligned: false,
        anchor: Vector3::zeros(),
        axis: Vector3::z(),
        reference: 0.0,
        relaxed: 0.0,
        range: None,
        motor_range: None,
        parts: Vec::new(),
        spring_damper: None,
        acting: Acting { force: vec![0.0; kind.counts().1], ..Acting::default() },
        start: Vec::new(),
        velocity: vec![0.0; kind.counts().1],
    };
    if element.name() == "freejoint" {
        return joint;
    }
    if kind != Kind::Free {
        let at = settled.vector("pos").map_or_else(Vector3::zeros, Vector3::from);
        joint.anchor = (frame * nalgebra::Point3::from(at)).coords;
    }
    if kind.is_scalar() {
        joint.axis = frame.rotation * axis(settled);
    }
    joint.acts(settled, settings);
    joint
}

fn kind(settled: &Settled<'_>) -> Kind {
    let words = ["hinge", "slide", "ball", "free"];
    let found = settled.attribute("type").and_then(|at| choice(&at, &words)).unwrap_or(0);
    [Kind::Hinge, Kind::Slide, Kind::Ball, Kind::Free][found]
}

fn axis(settled: &Settled<'_>) -> Vector3<f64> {
    let Some(axis) = settled.vector("axis").map(Vector3::from) else { return Vector3::z() };
    // As in MuJoCo.
    if axis.norm() > 1e-14 && axis.norm().is_finite() {
        return axis.normalize();
    }
    if let Some(attribute) = settled.attribute("axis") {
        let problem = attribute.wrong(&format!("is \"{}\", which has no direction", attribute.value));
        attribute.element.refuse(problem.help("for example axis=\"0 1 0\""));
    }
    Vector3::z()
}

impl Joint<'_> {
    /// References, springs, dampers, limits.
    fn acts(&mut self, settled: &Settled<'_>, settings: &Settings) {
        let angle = if matches!(self.kind, Kind::Hinge | Kind::Ball) { settings.angle } else { 1.0 };
        if self.kind.is_scalar() {
            self.reference = settled.number("ref").unwrap_or(0.0) * angle;
            // The default is a value of qpos, not of the displacement.
            self.relaxed = settled.number("springref").unwrap_or(0.0) * angle - self.reference;
        }
        self.acting.armature = settled.not_negative("armature").unwrap_or(0.0);
        if let Some(stiffness) = self.linear(settled, "stiffness").filter(|_| settings.springs) {
            self.acting.spring(stiffness, self.relaxed);
        }
        if let Some(damping) = self.linear(settled, "damping").filter(|_| settings.dampers) {
            self.acting.damping = damping;
        }
        self.spring_damper = settled.vector("springdamper").filter(|[time, ratio]| *time > 0.0 && *ratio > 0.0);
        if self.spring_damper.is_some() {
            // It stands for both.
            (self.acting.stiffness, self.acting.pull, self.acting.damping) = (0.0, 0.0, 0.0);
        }
        if settled.number("springyield").is_some_and(|limit| limit > 0.0) {
            self.element.note(Taken::Ignored, "`springyield`: the spring stays elastic");
        }
        self.friction(settled, settings);
        self.limits(settled, settings, angle);
        self.motor_range(settled, settings);
    }

    /// `frictionloss`: in MuJoCo a bound for each velocity; of a ball the torque as a whole is bounded here.
    fn friction(&mut self, settled: &Settled<'_>, settings: &Settings) {
        let Some(friction) = settled.not_negative("frictionloss").filter(|friction| *friction != 0.0) else { return };
        if !settings.friction {
            self.element.note(Taken::Ignored, format!("`frictionloss = {friction}`: left out, as asked for"));
            return;
        }
        if matches!(self.kind, Kind::Ball | Kind::Free) {
            let what = "it bounds the size of the torque, not each of its components";
            self.element.note(Taken::Approximated, format!("`frictionloss = {friction}`: {what}"));
        }
        self.acting.friction = friction;
    }

    /// `actuatorfrcrange`: bounds of what all actuators do together in this joint.
    fn motor_range(&mut self, settled: &Settled<'_>, settings: &Settings) {
        let range = settled.vector::<2>("actuatorfrcrange");
        let limited = settled.limited("actuatorfrclimited", "actuatorfrcrange", settings.autolimits);
        let Some([low, high]) = range.filter(|range| limited && self.kind.is_scalar() && *range != [0.0; 2]) else {
            return;
        };
        if low < high {
            self.motor_range = Some([low, high]);
        } else if let Some(attribute) = settled.attribute("actuatorfrcrange") {
            let problem = attribute.wrong(&format!("is \"{}\", from high to low", attribute.value));
            attribute.element.refuse(problem.help("the lower end comes first"));
        }
    }

    fn limits(&mut self, settled: &Settled<'_>, settings: &Settings, angle: f64) {
        let range = settled.vector::<2>("range");
        if matches!(self.kind, Kind::Ball | Kind::Free) {
            let limited = settled.limited("limited", "range", settings.autolimits) && settings.limits;
            if limited && range.is_some_and(|range| range != [0.0; 2]) {
                let what = if self.kind == Kind::Ball {
                    "`range`: the angle of a ball has no stop here"
                } else {
                    "`range`: free joints have no limits"
                };
                self.element.note(Taken::Ignored, what);
            }
            return;
        }
        if !settled.limited("limited", "range", settings.autolimits) || !settings.limits {
            if range.is_some() && settings.limits {
                self.element.note(Taken::Ignored, "`range`: its joint is not limited, as the file says");
            }
            return;
        }
        let Some([low, high]) = range.map(|range| range.map(|end| end * angle)) else {
            settled.refuse("it is limited and has no `range`", "give `range`, or `limited=\"false\"`");
            return;
        };
        match self.kind {
            Kind::Hinge | Kind::Slide if low < high => self.range = Some([low - self.reference, high - self.reference]),
            Kind::Hinge | Kind::Slide => {
                if let Some(attribute) = settled.attribute("range") {
                    let problem = attribute.wrong(&format!("is \"{}\", from high to low", attribute.value));
                    attribute.element.refuse(problem.help("the lower end comes first"));
                }
            }
            Kind::Ball | Kind::Free => {}
        }
    }

    /// The first coefficient of a polynomial law, and a note where there are more.
    fn linear(&self, settled: &Settled<'_>, key: &str) -> Option<f64> {
        let numbers = settled.numbers(key, 3)?;
        if numbers.iter().skip(1).any(|number| *number != 0.0) {
            self.element.note(Taken::Approximated, format!("`{key}`: only its linear part {} is taken", numbers[0]));
        }
        if numbers[0] < 0.0 && key == "damping" {
            let attribute = settled.attribute(key)?;
            attribute.element.refuse(attribute.wrong(&format!("must be ≥ 0, found {}", numbers[0])));
            return None;
        }
        Some(numbers[0])
    }
}
