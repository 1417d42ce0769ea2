//! What force an actuator makes: its element on top of the default of its class.
//!
//! All tags of actuators share one default per class. A shortcut (`position`, `velocity`, …) writes the whole law anew; what it
//! does not say itself it takes over from the nearest default that it can read:
//!
//! ```text
//! the class as it stands ─ the class around it ─ … ─ the outermost class ─ what holds where nothing is said
//! ```
//!
//! It can read what a tag of its own kind has left, and what `general` has, where the gain is of the type that it writes. A
//! `general` takes whatever stands in its class.

use super::super::xml::Element;
use super::defaults::Settled;
use super::settings::choice;

/// `force = gain · input + bias₀ + bias₁ · length + bias₂ · rate`, with the input `ctrl` or an activation.
///
/// A positive `bias₂` of a servo is a damping ratio, as MuJoCo keeps it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Law<'a> {
    /// The tag that was the last to write it.
    tag: &'a str,
    pub(super) gain: [f64; 3],
    pub(super) bias: [f64; 3],
    gain_type: &'a str,
    bias_type: &'a str,
    dynamics: &'a str,
    /// The tag that has written numbers of it, if that one has no equal here.
    foreign: Option<&'a str>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dynamics {
    None,
    /// The activation is the integral of the control.
    Integrator,
    /// The activation follows the control.
    Filter,
}

impl Default for Law<'_> {
    fn default() -> Self {
        Self {
            tag: "general",
            gain: [1.0, 0.0, 0.0],
            bias: [0.0; 3],
            gain_type: "fixed",
            bias_type: "none",
            dynamics: "none",
            foreign: None,
        }
    }
}

impl<'a> Law<'a> {
    /// What the classes and the element say.
    pub(super) fn read(settled: &Settled<'a>) -> Self {
        let mut classes = vec![Self::default()];
        for elements in settled.classes() {
            let mut law = classes[classes.len() - 1];
            for element in elements {
                law = law.then(element, &classes);
            }
            classes.push(law);
        }
        classes[classes.len() - 1].then(&settled.element, &classes)
    }

    /// No force at all.
    pub(super) fn nothing() -> Self {
        Self { gain: [0.0; 3], ..Self::default() }
    }

    /// As this element leaves it; around it are the classes, the outermost first.
    fn then(&self, element: &Element<'a>, around: &[Self]) -> Self {
        let tag = element.name();
        let gain_type = if tag == "damper" { "affine" } else { "fixed" };
        let readable = |law: &&Self| law.tag == tag || law.tag == "general" && law.gain_type == gain_type;
        let from = [self].into_iter().chain(around.iter().rev()).find(readable).copied().unwrap_or_default();
        let fresh = Self { tag, foreign: from.foreign, ..Self::default() };
        let number = |key: &str, otherwise: f64| element.number(key).unwrap_or(otherwise);
        match tag {
            "general" => self.general(element),
            "motor" => Self { foreign: None, ..fresh },
            "position" | "intvelocity" => from.servo(element),
            "velocity" => {
                let kv = number("kv", from.gain[0]);
                Self { gain: [kv, 0.0, 0.0], bias: [0.0, 0.0, -kv], bias_type: "affine", ..fresh }
            }
            "damper" => {
                let inherited = if from.gain_type == "affine" { -from.gain[2] } else { 0.0 };
                Self { gain: [0.0, 0.0, -number("kv", inherited)], gain_type: "affine", ..fresh }
            }
            "cylinder" => {
                let mut bias = from.bias;
                list(element, "bias", &mut bias);
                let area = number("area", from.gain[0]);
                let area = element.number("diameter").map_or(area, |d| std::f64::consts::FRAC_PI_4 * d * d);
                Self { gain: [area, 0.0, 0.0], bias, bias_type: "affine", dynamics: "filter", ..fresh }
            }
            "adhesion" => Self { gain: [number("gain", from.gain[0]), 0.0, 0.0], ..fresh },
            // A muscle has an activation, which is counted.
            "muscle" => Self { gain_type: tag, dynamics: tag, foreign: Some(tag), ..fresh },
            _ => Self { gain_type: tag, foreign: Some(tag), ..fresh },
        }
    }

    fn general(&self, element: &Element<'a>) -> Self {
        let mut law = Self { tag: element.name(), ..*self };
        list(element, "gainprm", &mut law.gain);
        list(element, "biasprm", &mut law.bias);
        let word = |key: &str, words: &[&str], into: &mut &'a str| {
            let attribute = element.attribute(key).filter(|attribute| choice(attribute, words).is_some());
            *into = attribute.map_or(*into, |attribute| attribute.value);
        };
        word("gaintype", &["fixed", "affine", "muscle", "user", "dcmotor", "pid", "so3"], &mut law.gain_type);
        word("biastype", &["none", "affine", "muscle", "user", "dcmotor", "so3"], &mut law.bias_type);
        let dynamics = ["none", "integrator", "filter", "filterexact", "muscle", "user", "dcmotor", "pid"];
        word("dyntype", &dynamics, &mut law.dynamics);
        law
    }

    /// A servo for the position, or for the integral of the control, on top of this.
    fn servo(&self, element: &Element<'a>) -> Self {
        let kp = element.number("kp").unwrap_or(self.gain[0]);
        let damping = element.number("kv").map(|kv| -kv);
        let rate = damping.or_else(|| element.number("dampratio")).unwrap_or(self.bias[2]);
        let time = element.number("timeconst");
        let dynamics = match time {
            _ if element.name() == "intvelocity" => "integrator",
            Some(time) if time > 0.0 => "filterexact",
            None if self.dynamics == "filterexact" => "filterexact",
            _ => "none",
        };
        let (tag, foreign) = (element.name(), self.foreign);
        let law = Self { tag, gain: [kp, 0.0, 0.0], bias: [0.0, -kp, rate], ..Self::default() };
        Self { bias_type: "affine", dynamics, foreign, ..law }
    }

    /// What it is, where it has no equal here.
    pub(super) fn unknown(&self) -> Option<String> {
        let tag = self.foreign.or_else(|| ["cylinder", "adhesion"].into_iter().find(|tag| *tag == self.tag));
        if let Some(tag) = tag {
            return Some(format!("a {tag} has no equal here"));
        }
        let types = [("gaintype", self.gain_type), ("biastype", self.bias_type), ("dyntype", self.dynamics)];
        let known = ["none", "fixed", "affine", "integrator", "filter", "filterexact"];
        let (key, word) = types.into_iter().find(|(_, word)| !known.contains(word))?;
        Some(format!("`{key} = \"{word}\"` has no equal here"))
    }

    /// How the activation follows from the control.
    pub(super) fn dynamics(&self) -> Dynamics {
        match self.dynamics {
            "integrator" => Dynamics::Integrator,
            "filter" | "filterexact" => Dynamics::Filter,
            _ => Dynamics::None,
        }
    }

    /// Whether it has a place among the activations.
    pub(super) fn is_activated(&self) -> bool {
        self.dynamics != "none"
    }

    /// Its coefficients of 1, the length and its rate, at this input.
    pub(super) fn at(&self, input: f64) -> [f64; 3] {
        let bias = if self.bias_type == "affine" { self.bias } else { [0.0; 3] };
        let gain = if self.gain_type == "affine" { self.gain } else { [self.gain[0], 0.0, 0.0] };
        [0, 1, 2].map(|index| gain[index] * input + bias[index])
    }

    /// The damping ratio that stands in place of the bias per rate.
    pub(super) fn damp_ratio(&self) -> Option<f64> {
        let servo = self.bias_type == "affine" && self.gain[0] == -self.bias[1];
        (servo && self.bias[2] > 0.0).then_some(self.bias[2])
    }
}

/// A list of numbers sets the first ones; the others stay.
fn list(element: &Element<'_>, key: &str, list: &mut [f64; 3]) {
    let numbers = element.attribute(key).and_then(|attribute| attribute.numbers());
    numbers.into_iter().flatten().zip(list.iter_mut()).for_each(|(number, into)| *into = number);
}
