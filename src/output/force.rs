//! What elements push or pull with, and how long springs, curves and ropes are.
//!
//! Of what pulls along a line: the pull, tension > 0. Of motors, drives, gears and stops: what they push their coordinate
//! with, of gears the first one. Of bushings and loads: force and moment on the body of the last point, at that point; of
//! loops on the body of the second end; of contacts the force on the second bodies, summed over all that touches; inertial
//! axes.

use super::question::{At, Measure, Variation};
use crate::force::{Act, Force};
use crate::model::output::{ForceQuantity, LengthQuantity, Source};
use crate::spatial::Wrench;
use nalgebra::Vector3;

impl ForceQuantity {
    fn six(&self, wrench: &Wrench, out: &mut [f64]) {
        let mut all = wrench.force.iter().chain(wrench.moment.iter());
        match self.component {
            Some(index) => out[0] = all.nth(index).copied().unwrap_or(f64::NAN),
            None => out.iter_mut().zip(all).for_each(|(out, x)| *out = *x),
        }
    }
}

/// What a force element applies at its last point.
fn at_last_end(force: &Force, at: &At<'_>) -> Wrench {
    let links = &at.balanced.motion().links;
    let ends = force.law.ends();
    let mut sum = Wrench::ZERO;
    force.law.wrenches(links, &mut |end, wrench| {
        if end + 1 == ends.len() {
            sum += wrench;
        }
    });
    ends.last().map_or(sum, |end| sum.shifted(-(links[end.link].turn * end.point)))
}

/// Its variation.
fn varied_at_last_end(force: &Force, at: &At<'_>, by: &Variation<'_>) -> Wrench {
    let links = &at.balanced.motion().links;
    let ends = force.law.ends();
    let mut sum = Wrench::ZERO;
    force.law.vary(links, by.links, &mut |end, wrench| {
        if end + 1 == ends.len() {
            sum += wrench;
        }
    });
    let Some(end) = ends.last() else { return sum };
    let arm = links[end.link].turn * end.point;
    let mut varied = sum.shifted(-arm);
    varied.moment -= by.links[end.link].turn.cross(&arm).cross(&at_last_end(force, at).force);
    varied
}

impl Measure for ForceQuantity {
    fn value(&self, at: &At<'_>, out: &mut [f64]) {
        let (model, links) = (at.balanced.system().model(), &at.balanced.motion().links);
        let rows = at.balanced.system().constraints();
        match &self.source {
            Source::Line(index) => out[0] = at.balanced.forces()[*index].law.pull(links),
            Source::Element(index) => self.six(&at_last_end(&at.balanced.forces()[*index], at), out),
            Source::Motor(index) => {
                out[0] = at.balanced.pushes()[*index].force;
            }
            Source::Drive(index) => {
                let push = rows.and_then(|rows| rows.drive_pushes(model, at.given.accelerations).nth(*index));
                out[0] = push.unwrap_or(f64::NAN);
            }
            Source::Gear(index) => {
                let push = rows.and_then(|rows| rows.gear_pushes().nth(*index));
                out[0] = push.map_or(f64::NAN, |[push, _]| push);
            }
            Source::Rod(index) => {
                out[0] = at.loops.get(*index).and_then(|reaction| reaction.pull).unwrap_or(f64::NAN);
            }
            Source::Loop(index) => match at.loops.get(*index) {
                Some(reaction) => self.six(&Wrench { force: reaction.force, moment: reaction.moment }, out),
                None => out.fill(f64::NAN),
            },
            Source::Contact(rule) => {
                let force = at.given.contacts.get(*rule).copied().unwrap_or_default();
                self.six(&Wrench { force, moment: Vector3::zeros() }, out);
            }
            Source::Stops(velocities) => {
                let push = |velocity: &usize| at.given.stops.get(*velocity).copied().unwrap_or(0.0);
                out.iter_mut().zip(velocities).for_each(|(out, velocity)| *out = push(velocity));
            }
        }
    }

    fn vary(&self, at: &At<'_>, by: &Variation<'_>, out: &mut [f64]) -> bool {
        let links = &at.balanced.motion().links;
        match &self.source {
            Source::Line(index) => [_, out[0]] = at.balanced.forces()[*index].law.vary_line(links, by.links),
            Source::Element(index) => self.six(&varied_at_last_end(&at.balanced.forces()[*index], at, by), out),
            // How the law of a motor changes with time is not known here.
            Source::Motor(index) if by.by.time == 0.0 => {
                let velocity = at.balanced.system().model().motors[*index].coordinate.velocity;
                let push = at.balanced.pushes()[*index];
                let of = |list: &[f64]| list.get(velocity).copied().unwrap_or(0.0);
                out[0] = push.by_position * of(by.by.position) + push.by_velocity * of(by.by.velocity);
            }
            _ => return false,
        }
        true
    }
}

impl Measure for LengthQuantity {
    fn value(&self, at: &At<'_>, out: &mut [f64]) {
        out[0] = match *self {
            Self::Line(force) => at.balanced.forces()[force].law.length(&at.balanced.motion().links),
            Self::Beam(beam) => at.balanced.beam_length(beam),
        };
    }

    fn vary(&self, at: &At<'_>, by: &Variation<'_>, out: &mut [f64]) -> bool {
        let Self::Line(force) = *self else { return false };
        [out[0], _] = at.balanced.forces()[force].law.vary_line(&at.balanced.motion().links, by.links);
        true
    }
}
