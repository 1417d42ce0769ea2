//! How a scene gives way, by names.

use super::closed::Scene;
use super::supports::{Bearers, Bears};
use crate::model::Model;
use crate::motion::Motion;
use nalgebra::Vector3;
use std::collections::HashSet;
use std::fmt;

/// Rates below this part of the largest are none.
const STILL: f64 = 1e-6;

/// Something that opens or slides.
#[derive(Debug, Clone, PartialEq)]
pub struct Giving {
    /// Two bodies, or the hinge whose friction gives way.
    pub names: Vec<String>,
    /// Its largest rate (m/s, rad/s; the mechanism is scaled to a largest rate of 1).
    pub rate: f64,
}

/// A motion along which supports give way.
#[derive(Debug, Clone, PartialEq)]
pub struct Mechanism {
    /// Pairs of bodies that part.
    pub opens: Vec<Giving>,
    /// Pairs of bodies that slide on each other, and hinges that slip.
    pub slides: Vec<Giving>,
    /// Velocity and angular velocity of the root marker of every body that moves, inertial axes (m/s, rad/s).
    pub bodies: Vec<(String, Vector3<f64>, Vector3<f64>)>,
    /// Hinge velocities.
    pub motion: Vec<f64>,
}

/// What slides and what opens, at most three of each.
impl fmt::Display for Mechanism {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let said = |list: &[Giving], verb: &str, hinge: &str, skip: &HashSet<&[String]>| -> Vec<String> {
            let one = |one: &Giving| match &one.names[..] {
                [name] => format!("`{name}` {hinge}"),
                [a, b] => format!("`{b}` {verb} `{a}`"),
                _ => String::new(),
            };
            list.iter().filter(|one| !skip.contains(&one.names[..])).take(3).map(one).collect()
        };
        let slides = said(&self.slides, "slides on", "slips", &HashSet::new());
        // Sliding dilates in this program: what slides is not said to open as well.
        let sliding: HashSet<&[String]> = self.slides.iter().map(|one| &one.names[..]).collect();
        let opens = said(&self.opens, "lifts off", "leaves its stop", &sliding);
        let all: Vec<String> = slides.into_iter().chain(opens).collect();
        if all.is_empty() { self.write_unfelt(f) } else { f.write_str(&all.join(", ")) }
    }
}

impl Mechanism {
    /// What moves in a motion that no support feels, at most three, fastest first; the parts of a beam are one.
    fn write_unfelt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut moving: Vec<(&str, f64)> = Vec::new();
        for (name, velocity, turning) in &self.bodies {
            let (name, rate) = (name.split('/').next().unwrap_or(name), velocity.amax().max(turning.amax()));
            match moving.iter_mut().find(|(known, _)| *known == name) {
                Some((_, known)) => *known = rate.max(*known),
                None => moving.push((name, rate)),
            }
        }
        moving.sort_by(|a, b| b.1.total_cmp(&a.1));
        let names: Vec<String> = moving.iter().take(3).map(|(name, _)| format!("`{name}`")).collect();
        match names.len() {
            0 => f.write_str("no body moves"),
            1 => write!(f, "{} moves, which no support feels", names[0]),
            _ => write!(f, "{} move, which no support feels", names.join(", ")),
        }
    }
}

pub(super) fn mechanism(model: &Model, pose: &[f64], scene: &Scene, bearers: &Bearers, motion: &[f64]) -> Mechanism {
    let rates = bearers.supports.rates(motion);
    let (mut opens, mut slides) = (Vec::new(), Vec::new());
    for (i, bears) in bearers.list.iter().enumerate() {
        let u = &rates[bearers.supports.range(i)];
        match bears {
            Bears::Contact(k) => {
                let mut bodies = scene.contacts[*k].bodies;
                // What gives way is named second, what stands on the ground first.
                bodies.sort_by_key(|body| model.bodies[*body].link != 0);
                let names: Vec<String> = bodies.iter().map(|body| model.bodies[*body].name.clone()).collect();
                note(&mut opens, &names, u[0]);
                if let [_, x, y] = u {
                    note(&mut slides, &names, x.hypot(*y));
                }
            }
            Bears::Friction { velocity } => {
                let rate = u.iter().fold(0.0_f64, |sum, u| sum.hypot(*u));
                note(&mut slides, &[model.label(*velocity).replace('`', "")], rate);
            }
            Bears::Stop { velocity, .. } => note(&mut opens, &[model.label(*velocity).replace('`', "")], u[0]),
            Bears::Other => {}
        }
    }
    let mut moved = Motion::new(model);
    moved.update(model, pose, motion);
    let of_body = |body: &crate::model::Body| {
        let link = &moved.links[body.link];
        let arm = link.turn * body.link_from_body.translation.vector;
        (body.name.clone(), link.velocity + link.angular_velocity.cross(&arm), link.angular_velocity)
    };
    let moves = |(_, v, w): &(String, Vector3<f64>, Vector3<f64>)| v.amax().max(w.amax()) > STILL;
    let bodies = model.bodies.iter().map(of_body).filter(moves).collect();
    Mechanism { opens, slides, bodies, motion: motion.to_vec() }
}

/// Notes the largest rate of something, once for all of its points.
fn note(list: &mut Vec<Giving>, names: &[String], rate: f64) {
    if rate <= STILL {
        return;
    }
    match list.iter_mut().find(|one| one.names == names) {
        Some(one) => one.rate = one.rate.max(rate),
        None => list.push(Giving { names: names.to_vec(), rate }),
    }
}
