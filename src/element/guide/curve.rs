//! The curves that a body can be guided along, and their derivatives by a parameter.

use super::spline::Spline;
use crate::formula::Formula;
use crate::round_off::ONE_PLACE;
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// A curve as it is given, in the axes of the hinge frame.
#[derive(Debug, Clone, PartialEq)]
pub enum GuideCurve {
    /// From the origin along x.
    Straight {
        /// (m)
        length: f64,
    },
    /// The spline of degree 5 through points.
    Points {
        /// At least two (m).
        points: Vec<Vector3<f64>>,
    },
    /// About z, from [radius, 0, 0].
    Helix {
        /// (m)
        radius: f64,
        /// Rise per turn (m).
        pitch: f64,
        /// Number of turns.
        turns: f64,
    },
    /// By formulas of a parameter.
    Formulas {
        /// The name of the parameter.
        parameter: String,
        /// x, y and z (m).
        place: [String; 3],
        /// Where the parameter begins and ends.
        range: [f64; 2],
    },
}

/// What is wrong with a curve: the key below `curve`, and in words.
#[derive(Debug, Clone, PartialEq)]
pub struct GuideFlaw {
    /// `points`, `x`, …
    pub key: &'static str,
    /// What is wrong.
    pub message: String,
    /// What is allowed.
    pub help: &'static str,
}

impl GuideFlaw {
    pub(super) fn new(key: &'static str, message: String, help: &'static str) -> Self {
        Self { key, message, help }
    }
}

impl GuideCurve {
    /// The key in scenario files.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Straight { .. } => "straight",
            Self::Points { .. } => "points",
            Self::Helix { .. } => "helix",
            Self::Formulas { .. } => "range",
        }
    }
}

/// Looks over a curve of formulas, and the part of a tangent that changes between two of them where something is narrow.
const LOOKS: usize = 1000;
const OFF: f64 = 0.381_966_011_250_105;
const CHANGED: f64 = 0.05;

/// A curve, compiled: its place as a function of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Line {
    Straight,
    Points(Spline),
    /// By the angle; rise per radian.
    Helix {
        radius: f64,
        rise: f64,
    },
    Formulas(Box<[Formula; 3]>),
}

impl Line {
    /// With the values of the parameter between which it is one smooth piece.
    pub(super) fn new(curve: &GuideCurve) -> Result<(Self, Vec<f64>), GuideFlaw> {
        let flaw = |message: String, help| Err(GuideFlaw::new(curve.key(), message, help));
        match curve {
            GuideCurve::Straight { length } if *length > 0.0 && length.is_finite() => {
                Ok((Self::Straight, vec![0.0, *length]))
            }
            GuideCurve::Straight { length } => flaw(format!("is {length} m long"), "allowed: a length > 0 m"),
            GuideCurve::Points { points } => {
                if points.len() < 2 {
                    return flaw(format!("goes through {} point", points.len()), "give at least two points");
                }
                if let Some(bad) = points.iter().position(|point| !point.iter().all(|x| x.is_finite())) {
                    return flaw(format!("has a point [{bad}] that is not finite"), "give finite m");
                }
                if let Some(i) = points.windows(2).position(|pair| pair[0] == pair[1]) {
                    let message = format!("has its points [{i}] and [{}] at one place", i + 1);
                    return flaw(message, "points in succession must differ");
                }
                let spline = Spline::through(points);
                let knots = spline.knots.clone();
                Ok((Self::Points(spline), knots))
            }
            GuideCurve::Helix { radius, pitch, turns } => {
                let finite = [radius, pitch, turns].iter().all(|x| x.is_finite());
                if !finite || *radius <= 0.0 || *turns <= 0.0 {
                    let message = format!("has radius {radius} m, pitch {pitch} m and {turns} turns");
                    return flaw(message, "allowed: radius > 0 m, turns > 0, any finite pitch");
                }
                if *pitch == 0.0 && *turns >= 1.0 {
                    return flaw(format!("has no pitch and {turns} turns: it closes on itself"), CLOSED);
                }
                Ok((Self::Helix { radius: *radius, rise: pitch / TAU }, vec![0.0, TAU * turns]))
            }
            GuideCurve::Formulas { parameter, place, range } => {
                let [from, to] = *range;
                if !(from < to && from.is_finite() && to.is_finite()) {
                    return flaw(format!("goes from {parameter} = {from} to {to}"), "the range goes upwards");
                }
                let mut compiled = Vec::new();
                for (key, text) in ["x", "y", "z"].into_iter().zip(place) {
                    let formula = Formula::parse(text, &[parameter]);
                    compiled.push(formula.map_err(|error| {
                        GuideFlaw::new(
                            key,
                            format!("has no {key}: {}", error.in_words(text)),
                            "a formula of its parameter",
                        )
                    })?);
                }
                match <[Formula; 3]>::try_from(compiled) {
                    Ok(all) => {
                        let mut instants: Vec<f64> = all.iter().flat_map(|one| one.instants(0, *range)).collect();
                        instants.sort_by(f64::total_cmp);
                        let line = Self::Formulas(Box::new(all));
                        if let Some(at) = line.gap_among(&instants, line.extent(*range)) {
                            // Zero, if it is the last number beside it.
                            let at = if at + (to - from) == to - from { 0.0 } else { at };
                            return flaw(format!("has a gap at parameter {at:?}"), GAP);
                        }
                        let breaks = line.looked_over(from, to, &instants);
                        Ok((line, breaks))
                    }
                    Err(_) => flaw("has not three coordinates".to_owned(), "give x, y and z"),
                }
            }
        }
    }

    /// How far the curve goes from its first place that is a number, in a thousand looks (m).
    pub(super) fn extent(&self, [from, to]: [f64; 2]) -> f64 {
        let look = |k: usize| self.at(from + (to - from) * k as f64 / LOOKS as f64)[0];
        let mut places = (0..=LOOKS).map(look).filter(|place| place.iter().all(|x| x.is_finite()));
        let Some(first) = places.next() else { return 0.0 };
        places.map(|place| (place - first).norm()).fold(0.0, f64::max)
    }

    /// The first of the values of the parameter at which formulas begin to follow another rule and the place is another one than just
    /// before.
    fn gap_among(&self, instants: &[f64], extent: f64) -> Option<f64> {
        let jump = |at: &&f64| (self.at(**at)[0] - self.at(at.next_down())[0]).norm() > ONE_PLACE.of(extent);
        // The last value before the new rule is the one that people have written.
        instants.iter().find(jump).map(|at| at.next_down())
    }

    /// The ends of a range, and the places in it where the tangent changes by more than a twentieth from one of a thousand looks to the
    /// next, or where formulas do something within a short stretch, as their `instants` say: what is narrow there is not passed over.
    fn looked_over(&self, from: f64, to: f64, instants: &[f64]) -> Vec<f64> {
        // Off the places that people choose: a kink does not become the border of two pieces that are smooth.
        let place = |k: usize| from + (to - from) * (k as f64 + OFF) / (LOOKS as f64 + 1.0);
        let tangents: Vec<Vector3<f64>> = (0..=LOOKS).map(|k| self.at(place(k))[1]).collect();
        let mut breaks = vec![from];
        for (k, pair) in tangents.windows(2).enumerate() {
            if (pair[1] - pair[0]).norm() > CHANGED * pair[0].norm().max(pair[1].norm()) {
                breaks.extend([k, k + 1].map(place).into_iter().filter(|u| *u > from && *u < to));
            }
        }
        breaks.extend(instants.windows(2).map(|pair| pair[0] + OFF * (pair[1] - pair[0])));
        breaks.push(to);
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        breaks
    }

    /// The place and its first four derivatives by the parameter.
    pub(super) fn at(&self, u: f64) -> [Vector3<f64>; 5] {
        match self {
            Self::Straight => {
                let none = Vector3::zeros();
                [u * Vector3::x(), Vector3::x(), none, none, none]
            }
            Self::Points(spline) => spline.at(u),
            Self::Helix { radius, rise } => {
                let (s, c) = u.sin_cos();
                let (x, y) = (Vector3::new(radius * c, radius * s, 0.0), Vector3::new(-radius * s, radius * c, 0.0));
                [x + rise * u * Vector3::z(), y + *rise * Vector3::z(), -x, -y, x]
            }
            Self::Formulas(place) => {
                let [x, y, z] = [0, 1, 2].map(|i| place[i].derivatives(u));
                std::array::from_fn(|k| Vector3::new(x[k], y[k], z[k]))
            }
        }
    }
}

/// What a curve with a gap is told.
pub(super) const GAP: &str = "a curve goes on from where it has come to: formulas with `if`, `floor`, `sign` may change their rule where both \
                              rules have the same place and tangent";
/// What a curve that closes on itself is told.
pub(super) const CLOSED: &str = "a curve has two ends that differ: leave a gap, or let it go on beyond its beginning";
