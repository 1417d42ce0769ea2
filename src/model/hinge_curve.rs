//! Springs and dampers by tables in hinge coordinates.

use super::couple::Scalar;
use super::description::{BodyDescription, Description};
use super::problem::{Element, Problem};
use super::{Body, Link, Model, StopLaw};
use crate::force::Switch;
use crate::force::table::{Interpolation, Table};
use std::sync::Arc;

/// A spring or damper of a hinge by a table of points: what opposes the distance from rest, or the speed.
#[derive(Debug, Clone, PartialEq)]
pub struct HingeCurveDescription {
    /// Which of the hinge's coordinates, from 0; not one of a quaternion.
    pub coordinate: usize,
    /// What the table is over.
    pub over: CurveOver,
    /// Points `[x, f]`, x increasing: m or rad from rest, or their rate, and N or N m.
    pub points: Vec<[f64; 2]>,
    /// Between the points.
    pub interpolation: Interpolation,
}

/// What the table of a hinge is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CurveOver {
    /// `q − rest`: a spring.
    Position,
    /// `q̇`: a damper.
    Velocity,
}

impl CurveOver {
    /// The key in scenario files.
    pub fn key(self) -> &'static str {
        match self {
            Self::Position => "spring",
            Self::Velocity => "damper",
        }
    }
}

/// A spring or damper of a hinge by a table, compiled.
#[derive(Debug, Clone, PartialEq)]
pub struct HingeCurve {
    /// The coordinate.
    pub coordinate: Scalar,
    /// What the table is over.
    pub over: CurveOver,
    /// The table of what opposes.
    pub table: Table,
    /// Where a spring's table is at zero (m or rad).
    pub rest: f64,
    /// What a damper's table pulls with at rest (N or N m).
    pub at_rest: f64,
}

impl HingeCurve {
    /// The number over which the table is, at a state.
    pub fn argument(&self, q: &[f64], v: &[f64]) -> f64 {
        match self.over {
            CurveOver::Position => q[self.coordinate.position] - self.rest,
            CurveOver::Velocity => v[self.coordinate.velocity],
        }
    }

    /// The function whose change of sign is the crossing of the kink at a point.
    pub fn switch(&self, point: usize, q: &[f64], v: &[f64]) -> Switch {
        let (far, speed) = (q[self.coordinate.position] - self.rest, v[self.coordinate.velocity]);
        let is_speed = self.over == CurveOver::Velocity;
        let value = self.argument(q, v) - self.table.kink(point);
        Switch { value, rate: if is_speed { 0.0 } else { speed }, is_speed, at: far, speed, size: None }
    }
}

/// The problems of all curves in hinges.
pub(super) fn check(description: &Description) -> Vec<Problem> {
    let bodies = description.bodies.iter().enumerate();
    let curves = bodies.flat_map(|(index, body)| body.hinge.curves.iter().map(move |curve| (index, body, curve)));
    curves.filter_map(|(index, body, curve)| problem(index, body, curve)).collect()
}

fn problem(index: usize, body: &BodyDescription, curve: &HingeCurveDescription) -> Option<Problem> {
    let (kind, name) = (&body.hinge.kind, &body.name);
    let (key, coordinate) = (curve.over.key(), curve.coordinate);
    let at = |field: String, message: String, help: &str| {
        Some(Problem { element: Element::Body(index), field, message, help: Some(help.to_owned()) })
    };
    if coordinate >= kind.plain_coordinates() {
        let kind = kind.name();
        let message = format!("the {kind} hinge of `{name}` has no coordinate {coordinate} for a {key} by a curve");
        let help = "angles and distances have; the numbers of a quaternion do not";
        return at(format!("hinge.{key}"), message, help);
    }
    let bad = Table::check(&curve.points)?;
    let point = bad.index.map_or(String::new(), |index| format!("[{index}]"));
    let message = format!("the curve of the {key} of the hinge of `{name}` {}", bad.message);
    at(format!("hinge.{key}.curve{point}"), message, bad.help)
}

/// The curves of a scene without problems.
pub(super) fn compile(description: &Description, bodies: &[Body], links: &[Link]) -> Arc<[HingeCurve]> {
    let of_body = |(written, built): (&BodyDescription, &Body)| {
        let (position, velocity) = (built.hinge.position, built.hinge.velocity);
        let rest = written.hinge.rest.clone();
        let curve = move |curve: &HingeCurveDescription| {
            let table = Table::new(&curve.points, curve.interpolation);
            let [at_rest, _] = table.value(0.0);
            let (position, velocity) = (position + curve.coordinate, velocity + curve.coordinate);
            let of_link = |link: &Link| link.velocity == velocity && link.joint.counts() == (1, 1);
            let link = links.iter().position(of_link)?;
            let slides = links[link].joint.is_distance();
            Some(HingeCurve {
                coordinate: Scalar { link, position, velocity, slides },
                over: curve.over,
                at_rest: if curve.over == CurveOver::Velocity { at_rest } else { 0.0 },
                rest: rest.get(curve.coordinate).copied().unwrap_or(0.0),
                table,
            })
        };
        written.hinge.curves.iter().filter_map(curve).collect::<Vec<_>>()
    };
    description.bodies.iter().zip(bodies).flat_map(of_body).collect()
}

impl Model {
    /// This model with springs by curves in place of its compliant stops: they push alike at rest.
    pub(crate) fn with_stops_as_springs(&self) -> Self {
        let mut model = self.clone();
        let mut curves = self.curves.to_vec();
        for stop in &self.stops {
            let StopLaw::Compliant { stiffness, .. } = stop.law else { continue };
            let Some(link) =
                self.links.iter().position(|link| link.velocity == stop.velocity && link.joint.is_scalar())
            else {
                continue;
            };
            let slides = self.links[link].joint.is_distance();
            let coordinate = Scalar { link, position: stop.position, velocity: stop.velocity, slides };
            let Some(points) = points(stop.range, stiffness) else { continue };
            let table = Table::new(&points, Interpolation::Linear);
            curves.push(HingeCurve { coordinate, over: CurveOver::Position, table, rest: 0.0, at_rest: 0.0 });
        }
        model.stops.retain(|stop| matches!(stop.law, StopLaw::Rigid { .. }));
        model.curves = curves.into();
        model
    }
}

/// Nothing within a range and this stiffness beyond it; `None` if it has no end.
fn points([low, high]: [f64; 2], stiffness: f64) -> Option<Vec<[f64; 2]>> {
    let (below, above) = ([low - 1.0, -stiffness], [high + 1.0, stiffness]);
    match (low.is_finite(), high.is_finite()) {
        (true, true) if low < high => Some(vec![below, [low, 0.0], [high, 0.0], above]),
        (true, true) => Some(vec![below, [low, 0.0], above]),
        (true, false) => Some(vec![below, [low, 0.0], [low + 1.0, 0.0]]),
        (false, true) => Some(vec![[high - 1.0, 0.0], [high, 0.0], above]),
        (false, false) => None,
    }
}
