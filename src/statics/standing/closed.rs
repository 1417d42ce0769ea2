//! Which contacts of a pose are closed.

use crate::contact::geometry::{RimArcs, tangents, touch};
use crate::contact::pairs::{Couple, Pairs, Untouchable};
use crate::model::contact::DryFriction;
use crate::model::{Model, StopLaw};
use crate::motion::Motion;
use nalgebra::Vector3;

/// A point at which two bodies press on each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// Indices of the bodies, as the rule names them.
    pub bodies: [usize; 2],
    /// Inertial axes (m).
    pub point: Vector3<f64>,
    /// From the first body to the second, inertial axes.
    pub normal: Vector3<f64>,
    /// (m)
    pub gap: f64,
    /// Coefficients of friction.
    pub friction: DryFriction,
}

impl Contact {
    /// Normal and tangents: the directions of a force's three numbers.
    pub(super) fn frame(&self) -> [Vector3<f64>; 3] {
        let [first, second] = tangents(&self.normal);
        [self.normal, first, second]
    }

    /// The force on the second body of one number, or of three (N).
    pub(super) fn force(&self, f: &[f64]) -> Vector3<f64> {
        self.frame().iter().zip(f).map(|(along, f)| along * *f).sum()
    }
}

/// A scene with its solids in place.
pub(super) struct Scene {
    pub(super) motion: Motion,
    pub(super) contacts: Vec<Contact>,
    /// Rims on which discs press, each with a contact on it and the angles (rad) of all of those.
    pub(super) rims: Vec<(RimArcs, Contact, Vec<f64>)>,
}

impl Scene {
    /// Finds all contacts that are closed to `gap` times the size of the smaller shape.
    pub(super) fn new(model: &Model, pose: &[f64], gap: f64) -> Result<Self, Untouchable> {
        let mut motion = Motion::new(model);
        motion.update(model, pose, &vec![0.0; model.velocity_count()]);
        let mut scene = Self { motion, contacts: Vec::new(), rims: Vec::new() };
        if model.contacts.is_empty() {
            return Ok(scene);
        }
        let mut pairs = Pairs::new(model)?;
        pairs.place(&scene.motion);
        // The slack of two shapes is that of the smaller one.
        let margins: Vec<f64> =
            pairs.pieces.iter().map(|piece| 0.5 * gap * piece.size.min(model.length_scale())).collect();
        for couple in pairs.near(&margins) {
            scene.meet(model, &pairs, couple, gap)?;
        }
        Ok(scene)
    }

    fn meet(&mut self, model: &Model, pairs: &Pairs, couple: usize, gap: f64) -> Result<(), Untouchable> {
        let Couple { pieces, rule, size } = pairs.couples[couple];
        let (slack, bodies) = (gap * size, pieces.map(|piece| pairs.pieces[piece].body));
        let between = || bodies.map(|body| model.bodies[body].name.clone());
        let [one, other] = pieces.map(|piece| pairs.placed(piece));
        let found = touch(&one, &other, slack).map_err(|_| Untouchable::NoNormal { between: between() })?;
        let Some(found) = found else { return Ok(()) };
        let compliant = matches!(model.contacts[rule].law, StopLaw::Compliant { .. });
        if found.gap < -slack && !compliant {
            let at = found.points.first().map_or([0.0; 3], |point| (*point).into());
            return Err(Untouchable::Overlap { between: between(), depth: -found.gap, at, allowed: slack });
        }
        let friction = model.contacts[rule].friction;
        let (normal, gap) = (found.normal, found.gap);
        let at = |point: &Vector3<f64>| Contact { bodies, point: *point, normal, gap, friction };
        self.contacts.extend(found.points.iter().map(at));
        for rim in found.rims {
            let corners = rim.corners();
            self.rims.push((rim, at(&found.points[0]), corners));
        }
        Ok(())
    }

    /// Takes in points of rims that a program has added.
    pub(super) fn extend(&mut self, added: &[(usize, f64)]) {
        for (rim, angle) in added {
            let (rim, contact, _) = &self.rims[*rim];
            self.contacts.push(Contact { point: rim.at(*angle), ..contact.clone() });
        }
    }
}
