//! Which contacts of a pose are closed.

use crate::contact::geometry::{Core, Placed, Solid, tangents, touch};
use crate::model::contact::DryFriction;
use crate::model::shape::{Geometry, Shape};
use crate::model::{ContactRule, Model};
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

/// Shapes that cannot be in contact as they are.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Untouchable {
    /// They overlap.
    #[error(
        "`{}` and `{}` overlap by {depth:.3e} m at [{:.4}, {:.4}, {:.4}], more than the {allowed:.1e} m that count as closed: move \
         one of them, raise `[statics] gap` (`contact = \"settle\"`, which would move them, is not there yet)", .between[0], .between[1], .at[0], .at[1], .at[2]
    )]
    Overlap {
        /// Names of the bodies.
        between: [String; 2],
        /// (m)
        depth: f64,
        /// Where (m).
        at: [f64; 3],
        /// (m)
        allowed: f64,
    },
    /// A contact of points or edges without a normal.
    #[error("`{}` and `{}`: a point or an edge without a radius lies on another: their contact has no normal", .between[0], .between[1])]
    NoNormal {
        /// Names of the bodies.
        between: [String; 2],
    },
    /// A shape that nothing can touch yet.
    #[error("the shape of `{body}` cannot touch anything: {why}")]
    Shape {
        /// Body.
        body: String,
        /// What is missing.
        why: String,
    },
}

/// A scene with its solids in place.
pub(super) struct Scene {
    pub(super) motion: Motion,
    pub(super) contacts: Vec<Contact>,
}

/// A solid of a body, in place.
struct Piece {
    body: usize,
    placed: Placed,
    /// Middle of a ball that holds it (m), and its radius, infinite for a plane.
    middle: Vector3<f64>,
    reach: f64,
    size: f64,
}

impl Scene {
    /// Finds all contacts that are closed to `gap` times the size of the smaller shape.
    pub(super) fn new(model: &Model, pose: &[f64], gap: f64) -> Result<Self, Untouchable> {
        let mut motion = Motion::new(model);
        motion.update(model, pose, &vec![0.0; model.velocity_count()]);
        let mut scene = Self { motion, contacts: Vec::new() };
        if model.contacts.is_empty() {
            return Ok(scene);
        }
        let mut pieces = scene.pieces(model)?;
        // Sweep and prune along x (Cohen, Lin, Manocha, Ponamgi, "I-COLLIDE", 1995); planes first: they reach everywhere.
        let start = |piece: &Piece| piece.middle.x - piece.reach;
        pieces.sort_by(|a, b| start(a).total_cmp(&start(b)));
        for (i, one) in pieces.iter().enumerate() {
            // No slack is larger than this part of it.
            let end = one.middle.x + one.reach + gap * one.size.min(model.length_scale());
            for other in pieces[i + 1..].iter().take_while(|other| start(other) <= end) {
                scene.meet(model, one, other, gap)?;
            }
        }
        Ok(scene)
    }

    fn pieces(&self, model: &Model) -> Result<Vec<Piece>, Untouchable> {
        let mut involved = vec![false; model.bodies.len()];
        model.contacts.iter().flat_map(|rule| rule.bodies.iter().flatten()).for_each(|body| involved[*body] = true);
        let mut pieces = Vec::new();
        for (index, body) in model.bodies.iter().enumerate().filter(|(index, _)| involved[*index]) {
            let pose = self.motion.body_pose(body);
            for shape in body.shapes.iter().filter(|shape| shape.collides) {
                let solid = solid_of(shape).map_err(|why| Untouchable::Shape { body: body.name.clone(), why })?;
                let world = pose * shape.pose;
                let placed = solid.placed(&world);
                let (middle, reach, size) = (world.translation.vector, solid.reach(), solid.size());
                pieces.push(Piece { body: index, placed, middle, reach, size });
            }
        }
        Ok(pieces)
    }

    fn meet(&mut self, model: &Model, one: &Piece, other: &Piece, gap: f64) -> Result<(), Untouchable> {
        // Two points, or a point on a plane, have no size of their own.
        let size = one.size.min(other.size);
        let slack = gap * if size.is_finite() { size } else { model.length_scale() };
        let far = (one.middle - other.middle).norm() > one.reach + other.reach + slack;
        let links = [one, other].map(|piece| model.bodies[piece.body].link);
        if far || links[0] == links[1] {
            return Ok(());
        }
        let Some((rule, swap)) = rule_of(model, one.body, other.body) else { return Ok(()) };
        let rule = &model.contacts[rule];
        let (one, other) = if swap { (other, one) } else { (one, other) };
        let between = || [one, other].map(|piece| model.bodies[piece.body].name.clone());
        let found = touch(&one.placed, &other.placed, slack);
        let Some(found) = found.map_err(|_| Untouchable::NoNormal { between: between() })? else { return Ok(()) };
        if found.gap < -slack {
            let at = found.points.first().map_or([0.0; 3], |point| (*point).into());
            return Err(Untouchable::Overlap { between: between(), depth: -found.gap, at, allowed: slack });
        }
        self.contacts.extend(found.points.iter().map(|point| Contact {
            bodies: [one.body, other.body],
            point: *point,
            normal: found.normal,
            gap: found.gap,
            friction: rule.friction,
        }));
        Ok(())
    }
}

/// The last rule that names a pair, by its index, and whether it names the second body first.
pub(crate) fn rule_of(model: &Model, one: usize, other: usize) -> Option<(usize, bool)> {
    let has = |rule: &ContactRule, side: usize, body: usize| rule.bodies[side].binary_search(&body).is_ok();
    let hangs = |body: usize, on: usize| model.bodies[body].parent == Some(on);
    let neighbours = hangs(one, other) || hangs(other, one);
    let fits = |rule: &ContactRule| {
        let swap = if has(rule, 0, one) && has(rule, 1, other) {
            false
        } else if has(rule, 0, other) && has(rule, 1, one) {
            true
        } else {
            return None;
        };
        (rule.named || !neighbours).then_some(swap)
    };
    model.contacts.iter().enumerate().rev().find_map(|(index, rule)| Some((index, fits(rule)?)))
}

/// What there is to do about a shape that cannot touch.
const REFUSED: &str = "cannot yet: give the body boxes, capsules or spheres, and this shape `contact = false`";

/// The solid of a shape, in the shape's axes.
pub(crate) fn solid_of(shape: &Shape) -> Result<Solid, String> {
    Ok(match &shape.geometry {
        Geometry::Plane(normal) => Solid::Plane(normal.normalize()),
        Geometry::Sphere(radius) => Solid::Round(Core::point(), *radius),
        Geometry::Capsule { radius, length } => Solid::Round(Core::segment(*length), *radius),
        Geometry::Box(edges) => Solid::Round(Core::cuboid(edges), 0.0),
        Geometry::Cylinder { .. } => return Err(format!("cylinders {REFUSED}")),
        Geometry::Mesh { .. } => return Err(format!("meshes {REFUSED}")),
    })
}
