//! What every kind of force answers: as it is described, and as it is compiled.

use super::end::{Attachment, Carrier, End};
use super::load::OverTime;
use crate::spatial::Wrench;
use crate::spatial::link::{LinkMotion, LinkVariation};
use nalgebra::{Matrix3, Vector3};

/// A kind of force as a user describes it.
pub trait Describe {
    /// What it is compiled into.
    type Law: Act;

    /// The points it acts on, each with its key in scenario files.
    fn attachments(&self) -> Vec<(String, &Attachment)>;

    /// Adds what is wrong with its numbers.
    fn check(&self, report: &mut Report<'_>);

    /// Adds what is wrong with where its points are, each on a body (`None`: the ground) in its axes.
    fn check_places(&self, _places: &[(Option<usize>, Vector3<f64>)], _report: &mut Report<'_>) {}

    /// Compiles what has passed the check; `carriers` has one entry for each of its attachments.
    fn compile(&self, carriers: &[Carrier]) -> Self::Law;

    /// The numbers under a key that an address can name, each with its SI unit; none where there is no such key.
    fn numbers(&self, _key: &str) -> Vec<(f64, &'static str)> {
        Vec::new()
    }

    /// Sets one of these numbers.
    fn set(&mut self, _key: &str, _index: usize, _value: f64) {}
}

/// A kind of force, compiled. `links` and `by` have one entry per link of the model; wrenches are taken at the root markers
/// of the links.
pub trait Act {
    /// The points it acts on.
    fn ends(&self) -> &[End];

    /// Gives the wrench on the link of each end, by the end's index; an end may come several times.
    fn wrenches(&self, links: &[LinkMotion], give: &mut impl FnMut(usize, Wrench));

    /// Gives the variation of these wrenches with the variation of the links.
    fn vary(&self, links: &[LinkMotion], by: &[LinkVariation], give: &mut impl FnMut(usize, Wrench));

    /// Gives the variation of these wrenches with each of some variations of one link, all others being at rest: the index of
    /// the variation, the end, the wrench. `by` has no variation, before and after.
    fn vary_each(
        &self,
        links: &[LinkMotion],
        by: &mut [LinkVariation],
        (link, variations): (usize, &[LinkVariation]),
        give: &mut impl FnMut(usize, usize, Wrench),
    ) {
        for (index, variation) in variations.iter().enumerate() {
            by[link] = *variation;
            self.vary(links, by, &mut |end, wrench| give(index, end, wrench));
        }
        by[link] = LinkVariation::default();
    }

    /// Potential energy (J); zero where it has none.
    fn potential(&self, links: &[LinkMotion]) -> f64;

    /// Power taken out (W), ≥ 0.
    fn dissipated(&self, _links: &[LinkMotion]) -> f64 {
        0.0
    }

    /// Power put in that has no potential (W).
    fn input(&self, _links: &[LinkMotion]) -> f64 {
        0.0
    }

    /// The link it acts on and its force there (N, inertial axes), if that is the same in every state at the time that is set.
    fn dead(&self) -> Option<(usize, Vector3<f64>)> {
        None
    }

    /// Whether its wrenches at rest follow from its potential.
    fn has_potential(&self) -> bool {
        true
    }

    /// What is left of a potential at one time, of what changes over time and has none in motion (J).
    fn potential_at_rest(&self, _links: &[LinkMotion]) -> f64 {
        0.0
    }

    /// Whether its wrenches at rest follow from both potentials at any one time.
    fn has_potential_at_rest(&self) -> bool {
        self.has_potential()
    }

    /// Whether it takes out energy.
    fn has_damping(&self) -> bool {
        false
    }

    /// Sizes of its forces and stiffnesses at rest, the same at each end.
    fn magnitude(&self, links: &[LinkMotion]) -> Magnitude;

    /// What is not a finite number; `None` where all of it is finite.
    fn not_finite(&self, links: &[LinkMotion]) -> Option<&'static str> {
        let mut finite = true;
        self.wrenches(links, &mut |_, wrench| finite &= wrench.is_finite());
        (!finite).then_some("the force")
    }

    /// Whether two points of it that have to be apart are in one place, or no more than this apart (m).
    fn in_one_place(&self, _links: &[LinkMotion], _within: f64) -> bool {
        false
    }

    /// What the events are called when [`Act::switch`] of boundary 0 becomes negative or zero, and positive; `None` for a
    /// kind that has no such events.
    fn switches(&self) -> Option<[&'static str; 2]> {
        None
    }

    /// Whether it has a part of the places that it can be in to itself, beside which it pushes otherwise: steps look there.
    fn is_uneven(&self) -> bool {
        false
    }

    /// The boundaries between smooth parts of its law that are next to the part in which it is kept, by their index.
    fn boundaries(&self) -> [Option<usize>; 4] {
        [None; 4]
    }

    /// A function whose change of sign is the crossing of a boundary.
    fn switch(&self, _boundary: usize, _links: &[LinkMotion]) -> Switch {
        Switch::default()
    }

    /// Keeps the law in the smooth part to which this state belongs, whatever the states are that follow; a law that is not
    /// kept takes the part of each state.
    fn keep(&mut self, _links: &[LinkMotion]) {}

    /// Whether the part in which the law is kept is on the positive side of a boundary.
    fn side(&self, _boundary: usize) -> bool {
        false
    }

    /// Keeps the law on the other side of a boundary from now on.
    fn cross(&mut self, _boundary: usize) {}

    /// Until when it acts as at t = 0 (s).
    fn steady_until(&self) -> f64 {
        f64::INFINITY
    }

    /// The times at which it begins to follow another rule (s); empty for what does not depend on time.
    fn times(&self) -> &[f64] {
        &[]
    }

    /// Acts as at a time (s) from now on.
    fn set_time(&mut self, _time: f64) {}

    /// What recordings and answers call the number of [`Act::pull`] (N); `None` where there is nothing to tell.
    fn pull_name(&self) -> Option<&'static str> {
        None
    }

    /// Whether it pulls its points together along a line or a path, which has a length.
    fn is_line(&self) -> bool {
        false
    }

    /// What it pulls its points together with (N); 0 for what is no line.
    fn pull(&self, _links: &[LinkMotion]) -> f64 {
        0.0
    }

    /// The length of its line or path (m); 0 for what is no line.
    fn length(&self, _links: &[LinkMotion]) -> f64 {
        0.0
    }

    /// The variations of [`Act::length`] (m) and [`Act::pull`] (N) with that of the links.
    fn vary_line(&self, _links: &[LinkMotion], _by: &[LinkVariation]) -> [f64; 2] {
        [0.0; 2]
    }

    /// What it pushes an element of a beam with between its ends, by the link at the element's tip.
    fn within(&self, _tip: usize, _links: &[LinkMotion]) -> Option<Within> {
        None
    }

    /// What is drawn.
    fn picture(&self) -> Picture<'_>;
}

/// How large what one end of an element feels is.
#[derive(Debug, Clone, Copy, Default)]
pub struct Magnitude {
    /// (N)
    pub force: f64,
    /// (N m)
    pub moment: f64,
    /// Stiffness times lengths: the sizes whose difference the force is (N).
    pub noise: f64,
    /// Likewise of the moment (N m).
    pub noise_moment: f64,
    /// (N/m)
    pub stiffness: f64,
    /// (N m/rad)
    pub turn_stiffness: f64,
}

/// A load on an element of a beam between its ends, and what stands for it there.
#[derive(Debug, Clone, Copy)]
pub struct Within {
    /// How far it is from the element's root, along the unstrained element (m).
    pub at: f64,
    /// The link at the element's root.
    pub root: usize,
    /// What is put on the links at its root and at its tip in place of it.
    pub on: [Wrench; 2],
}

/// A function whose change of sign is the crossing of a boundary between two smooth parts of a law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Switch {
    /// Its value (m or rad, per second if it is a speed).
    pub value: f64,
    /// How fast it changes (per second); 0 if that is not known.
    pub rate: f64,
    /// Whether it is a speed.
    pub is_speed: bool,
    /// What it is compared with; `None` if that is a length, an angle or a speed.
    pub size: Option<f64>,
    /// The number that an event says beside its name (m).
    pub at: f64,
    /// How fast that changes (m/s).
    pub speed: f64,
}

/// What pulls along a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LineKind {
    /// A spring.
    Spring {
        /// (N/m)
        stiffness: f64,
        /// Free length (m).
        length: f64,
    },
    /// A spring of which no one stiffness is known.
    Curved {
        /// Free length (m).
        length: f64,
    },
    /// A damper without a spring.
    Damper,
    /// A spring that pulls only and is slack otherwise.
    Rope {
        /// (N/m)
        stiffness: f64,
        /// Free length (m).
        length: f64,
    },
}

/// What a picture shows of a force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Picture<'a> {
    /// A line through points.
    Line {
        /// The points.
        through: &'a [End],
        /// What the line is.
        kind: LineKind,
    },
    /// A block between two frames.
    Block {
        /// The points in which the frames have their origins.
        ends: &'a [End; 2],
        /// The axes of the frames in their links: `link_from_frame`.
        frames: &'a [Matrix3<f64>; 2],
        /// Along these axes (N/m).
        stiffness: &'a Vector3<f64>,
    },
    /// Arrows at a point.
    Arrows {
        /// The point.
        on: &'a End,
        /// (N)
        force: Vector3<f64>,
        /// (N m)
        torque: Vector3<f64>,
        /// Whether both are in the axes of the link and turn with it; else they are in inertial axes.
        turns: bool,
        /// What scales both over time; `None` for what is always the same.
        over_time: Option<&'a OverTime>,
    },
    /// Nothing: both that it acts on are seen.
    Nothing,
}

/// What is wrong with the numbers of a described force.
#[derive(Debug)]
pub struct Report<'a> {
    /// The name of the force.
    pub name: &'a str,
    /// What was found.
    pub found: Vec<Flaw>,
}

/// One thing that is wrong.
#[derive(Debug)]
pub struct Flaw {
    /// Key in scenario files.
    pub key: String,
    /// What is wrong, with the force's name, the value and what is allowed.
    pub message: String,
    /// What to do about it.
    pub help: String,
}

impl Report<'_> {
    /// Adds a flaw.
    pub fn add(&mut self, key: &str, message: String, help: &str) {
        self.found.push(Flaw { key: key.to_owned(), message, help: help.to_owned() });
    }

    /// A number that must be finite and ≥ 0.
    pub fn not_negative(&mut self, key: &str, value: f64, unit: &str) {
        if !value.is_finite() || value < 0.0 {
            let message = format!("`{key}` of `{}` is {value}", self.name);
            self.add(key, message, &format!("allowed: a finite number ≥ 0 {unit}"));
        }
    }

    /// A number that must be finite and > 0.
    pub fn positive(&mut self, key: &str, value: f64, unit: &str) {
        if !value.is_finite() || value <= 0.0 {
            let message = format!("`{key}` of `{}` is {value}", self.name);
            self.add(key, message, &format!("allowed: a finite number > 0 {unit}"));
        }
    }

    /// Two ends that must be on different bodies; `what` acts between them.
    pub fn apart(&mut self, between: &[Attachment; 2], what: &str) {
        if between[0].body == between[1].body {
            let message = format!("both ends of `{}` are on `{}`", self.name, between[0].body);
            self.add("between", message, &format!("{what} within one rigid body does nothing"));
        }
    }
}
