//! Which shapes of a model may touch, and how they stand to each other in a place.

use crate::contact::geometry::feature::{Boundary, Feature, Meeting, Standing, meeting, pairs};
use crate::contact::geometry::{Solid, touch};
use crate::model::{Model, StopLaw};
use crate::motion::{LinkMotion, Motion};
use crate::spatial::Pose;
use crate::statics::standing::{Untouchable, rule_of, solid_of};
use nalgebra::{Isometry3, Vector3};

/// A shape that may touch.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    pub(super) body: usize,
    pub(super) link: usize,
    boundary: Boundary,
    solid: Solid,
    /// `link_from_shape`.
    place: Pose,
    /// Radius of a ball about the shape's origin that holds it (m); infinite for a plane.
    pub(super) reach: f64,
    /// What sizes are compared with (m).
    size: f64,
    pub(super) radius: f64,
}

/// Two shapes that a rule lets touch, in its order.
#[derive(Debug, Clone)]
pub(super) struct Couple {
    pub(super) pieces: [usize; 2],
    /// Index into the model's contacts.
    pub(super) rule: usize,
    /// The smaller of both sizes (m).
    pub(super) size: f64,
}

/// All of them.
#[derive(Debug, Clone)]
pub(super) struct Pairs {
    pub(super) pieces: Vec<Piece>,
    pub(super) couples: Vec<Couple>,
    /// Where the shapes stand.
    poses: Vec<Isometry3<f64>>,
}

/// Two features of one couple: what keeps its identity while a scene moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Key {
    pub(super) couple: usize,
    pub(super) features: [Feature; 2],
}

impl Pairs {
    /// # Errors
    /// A shape that nothing can touch.
    pub(super) fn new(model: &Model) -> Result<Self, Untouchable> {
        let mut involved = vec![false; model.bodies.len()];
        model.contacts.iter().flat_map(|rule| rule.bodies.iter().flatten()).for_each(|body| involved[*body] = true);
        let mut pieces = Vec::new();
        for (index, body) in model.bodies.iter().enumerate().filter(|(index, _)| involved[*index]) {
            for shape in body.shapes.iter().filter(|shape| shape.collides) {
                let solid = solid_of(shape).map_err(|why| Untouchable::Shape { body: body.name.clone(), why })?;
                pieces.push(Piece {
                    body: index,
                    link: body.link,
                    boundary: Boundary::new(&solid),
                    place: body.link_from_body * shape.pose,
                    reach: solid.reach(),
                    size: solid.size(),
                    radius: solid.radius(),
                    solid,
                });
            }
        }
        let mut all = Self { poses: vec![Isometry3::identity(); pieces.len()], pieces, couples: Vec::new() };
        for i in 0..all.pieces.len() {
            for j in i + 1..all.pieces.len() {
                all.couples.extend(all.couple(model, i, j));
            }
        }
        Ok(all)
    }

    /// Two pieces as the last rule that names their bodies has them.
    fn couple(&self, model: &Model, i: usize, j: usize) -> Option<Couple> {
        let (one, other) = (&self.pieces[i], &self.pieces[j]);
        if one.link == other.link {
            return None;
        }
        let (rule, swap) = rule_of(model, one.body, other.body)?;
        let pieces = if swap { [j, i] } else { [i, j] };
        let size = one.size.min(other.size);
        let size = if size.is_finite() { size } else { model.length_scale() };
        let planes = [one, other].iter().all(|piece| piece.reach.is_infinite());
        (!planes).then_some(Couple { pieces, rule, size })
    }

    /// Takes all shapes to where the links are.
    pub(super) fn place(&mut self, motion: &Motion) {
        self.place_at(&motion.links);
    }

    /// The same for these links.
    pub(super) fn place_at(&mut self, links: &[LinkMotion]) {
        for (piece, pose) in self.pieces.iter().zip(&mut self.poses) {
            *pose = links[piece.link].pose() * piece.place;
        }
    }

    pub(super) fn middle(&self, piece: usize) -> Vector3<f64> {
        self.poses[piece].translation.vector
    }

    /// The largest relative speed of two shapes (m/s).
    pub(super) fn fastest(&self, couple: usize, motion: &Motion) -> f64 {
        let speed = |piece: usize| {
            let (piece, at) = (&self.pieces[piece], &motion.links[self.pieces[piece].link]);
            let middle = self.middle_of(piece, at);
            let turning = if piece.reach.is_finite() { piece.reach } else { 0.0 };
            (at.velocity + at.angular_velocity.cross(&(middle - at.position)), at.angular_velocity.norm() * turning)
        };
        let [a, b] = self.couples[couple].pieces.map(speed);
        (a.0 - b.0).norm() + a.1 + b.1
    }

    fn middle_of(&self, piece: &Piece, at: &LinkMotion) -> Vector3<f64> {
        (at.pose() * piece.place).translation.vector
    }

    fn standing(&self, piece: usize) -> Standing<'_> {
        self.pieces[piece].boundary.standing(&self.poses[piece])
    }

    /// How far the balls around both shapes are apart (m).
    pub(super) fn apart(&self, couple: usize) -> f64 {
        let [a, b] = self.couples[couple].pieces;
        let reaches = self.pieces[a].reach + self.pieces[b].reach;
        if reaches.is_finite() { (self.middle(a) - self.middle(b)).norm() - reaches } else { f64::NEG_INFINITY }
    }

    /// All pairs of features of a couple that count to `loose` (m) and whose gap is below `far` (m).
    pub(super) fn meetings(&self, couple: usize, loose: f64, far: f64, mut put: impl FnMut(Meeting)) {
        let Couple { pieces: [a, b], .. } = &self.couples[couple];
        let (a, b) = (self.standing(*a), self.standing(*b));
        for features in pairs(&a, &b) {
            if let Some(found) = meeting(&a, &b, features).filter(|found| found.inside >= -loose && found.gap < far) {
                put(found);
            }
        }
    }

    /// How far two shapes overlap (m); 0 if they do not.
    pub(super) fn depth(&self, couple: usize) -> f64 {
        let [a, b] = self.couples[couple].pieces.map(|piece| self.pieces[piece].solid.placed(&self.poses[piece]));
        touch(&a, &b, 0.0).ok().flatten().map_or(0.0, |found| (-found.gap).max(0.0))
    }

    /// One pair of features.
    pub(super) fn meeting(&self, key: &Key) -> Option<Meeting> {
        let [a, b] = self.couples[key.couple].pieces;
        meeting(&self.standing(a), &self.standing(b), key.features)
    }
}

/// The part of a speed that a blow gives back.
pub(super) fn restitution(law: StopLaw) -> f64 {
    match law {
        StopLaw::Rigid { restitution } => restitution,
        StopLaw::Compliant { .. } => 0.0,
    }
}
