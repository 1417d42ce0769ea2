//! Which shapes of a model may touch, and how they stand to each other in a place.

use super::geometry::feature::{Boundary, Feature, Meeting, Near, PlacedBoundary};
use super::geometry::meet::{meeting, pairs};
use super::geometry::{Core, Placed, Solid, touch};
use crate::model::problem::{number, significant};
use crate::model::shape::{Geometry, Hull, Shape};
use crate::model::{ContactRule, Model};
use crate::motion::{LinkMotion, Motion};
use crate::spatial::Pose;
use nalgebra::{Isometry3, Vector3};

/// A closed contact counts until its features are outside of where they are nearest by this part of the size.
pub(crate) const LOOSE: f64 = 1e-7;
/// Of shapes that overlap, features count that do by no more than this many times the overlap itself.
pub(crate) const DEEPER: f64 = 2.0;
/// Overlaps of features below this part of the size need no such proof.
const SHALLOW: f64 = 1e-6;
/// What meets at the rim of a feature, to this part of the size, is looked at once more: see [`Pairs::passes_by`].
const RIM: f64 = 1e-5;
/// It meets only if shapes overlap by this part of how much further it would go, which is so many times as far as it is from the rim.
const MEETS: f64 = 0.5;
const FURTHER: f64 = 10.0;
/// Contacts of a couple that are closer to each other than this part of the size, with one normal, are one.
const ONE_PLACE: f64 = 1e-4;

/// Shapes that cannot be in contact as they are.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Untouchable {
    /// They overlap.
    #[error(
        "`{}` and `{}` overlap by {} m at [{:.4}, {:.4}, {:.4}], more than the {} m that count as closed: move \
         one of them, raise `[statics] gap`, or ask statics to move them apart with `[statics] contact = \"settle\"`", .between[0], .between[1], number(*.depth), .at[0], .at[1], .at[2], significant(*.allowed, 2)
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
    #[error("the shape of `{body}` cannot touch: {why}")]
    Shape {
        /// Body.
        body: String,
        /// What is missing.
        why: String,
    },
}

/// A shape that may touch.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    /// Index of its body.
    pub(crate) body: usize,
    /// Index of its link.
    pub(crate) link: usize,
    boundary: Boundary,
    solid: Solid,
    /// `link_from_shape`.
    place: Pose,
    /// Radius of a ball about the shape's origin that holds it (m); infinite for a plane.
    pub(crate) reach: f64,
    /// What sizes are compared with (m): that of the solid, infinite for a plane or a point.
    pub(crate) size: f64,
}

/// A ball around a piece and its margin (m).
struct Span {
    middle: Vector3<f64>,
    half: f64,
    piece: usize,
}

impl Span {
    /// Where it begins and ends along an axis (m).
    fn ends(&self, axis: usize) -> [f64; 2] {
        [self.middle[axis] - self.half, self.middle[axis] + self.half]
    }
}

/// Two shapes that a rule lets touch, in its order.
#[derive(Debug, Clone)]
pub(crate) struct Couple {
    /// Indices of the shapes.
    pub(crate) pieces: [usize; 2],
    /// Index into the model's contacts.
    pub(crate) rule: usize,
    /// The smaller of both sizes (m).
    pub(crate) size: f64,
}

/// All of them.
#[derive(Debug, Clone)]
pub(crate) struct Pairs {
    /// Shapes that may touch anything.
    pub(crate) pieces: Vec<Piece>,
    /// Pairs of them that may meet.
    pub(crate) couples: Vec<Couple>,
    /// Of every piece, those after it that it may touch and the couples that they are, in order.
    partners: Vec<Vec<(usize, usize)>>,
    /// Where the shapes stand.
    poses: Vec<Isometry3<f64>>,
}

/// Two features of one couple: what keeps its identity while a scene moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Key {
    pub(crate) couple: usize,
    pub(crate) features: [Feature; 2],
}

impl Pairs {
    /// # Errors
    /// A shape that nothing can touch.
    pub(crate) fn new(model: &Model) -> Result<Self, Untouchable> {
        let mut involved = vec![false; model.bodies.len()];
        model.contacts.iter().flat_map(|rule| rule.bodies.iter().flatten()).for_each(|body| involved[*body] = true);
        let mut pieces = Vec::new();
        for (index, body) in model.bodies.iter().enumerate().filter(|(index, _)| involved[*index]) {
            for shape in body.shapes.iter().filter(|shape| shape.collides) {
                let solids = solids_of(shape).map_err(|why| Untouchable::Shape { body: body.name.clone(), why })?;
                pieces.extend(solids.into_iter().map(|solid| Piece {
                    body: index,
                    link: body.link,
                    boundary: Boundary::new(&solid),
                    place: body.link_from_body * shape.pose,
                    reach: solid.reach(),
                    size: solid.size(),
                    solid,
                }));
            }
        }
        let (poses, partners) = (vec![Isometry3::identity(); pieces.len()], vec![Vec::new(); pieces.len()]);
        let mut all = Self { poses, pieces, couples: Vec::new(), partners };
        for i in 0..all.pieces.len() {
            for j in i + 1..all.pieces.len() {
                all.refuse_planes(model, i, j)?;
                let Some(couple) = all.couple(model, i, j) else { continue };
                all.partners[i].push((j, all.couples.len()));
                all.couples.push(couple);
            }
        }
        Ok(all)
    }

    /// Two half spaces that move against each other, of which a rule says that they touch.
    fn refuse_planes(&self, model: &Model, i: usize, j: usize) -> Result<(), Untouchable> {
        let (one, other) = (&self.pieces[i], &self.pieces[j]);
        let planes = [one, other].iter().all(|piece| piece.reach.is_infinite());
        if !planes || one.link == other.link || rule_of(model, one.body, other.body).is_none() {
            return Ok(());
        }
        let [body, other] = [one, other].map(|piece| model.bodies[piece.body].name.clone());
        let why = format!(
            "`{other}` is a half space as well, and two of these overlap wherever they are: give one of them a box"
        );
        Err(Untouchable::Shape { body, why })
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
    pub(crate) fn place(&mut self, motion: &Motion) {
        self.place_at(&motion.links);
    }

    /// Takes all shapes to where these links are.
    pub(crate) fn place_at(&mut self, links: &[LinkMotion]) {
        for (piece, pose) in self.pieces.iter().zip(&mut self.poses) {
            *pose = links[piece.link].pose() * piece.place;
        }
    }

    pub(crate) fn middle(&self, piece: usize) -> Vector3<f64> {
        self.poses[piece].translation.vector
    }

    /// How fast a shape moves: its middle, and what turning adds at most (m/s).
    pub(crate) fn speed(&self, piece: usize, motion: &Motion) -> (Vector3<f64>, f64) {
        let (own, at) = (&self.pieces[piece], &motion.links[self.pieces[piece].link]);
        let turning = if own.reach.is_finite() { own.reach } else { 0.0 };
        let arm = self.middle(piece) - at.position;
        (at.velocity + at.angular_velocity.cross(&arm), at.angular_velocity.norm() * turning)
    }

    /// The couples whose shapes may be within `margins` (m) of each other, in order: swept along the axis over which shapes spread
    /// most (Cohen, Lin, Manocha, Ponamgi, "I-COLLIDE", 1995).
    pub(crate) fn near(&self, margins: &[f64]) -> Vec<usize> {
        let finite: Vec<usize> = (0..self.pieces.len()).filter(|i| self.pieces[*i].reach.is_finite()).collect();
        let spread = |axis: usize| {
            let along = finite.iter().map(|i| self.middle(*i)[axis]);
            along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
        };
        let axis = (0..3).max_by(|a, b| spread(*a).total_cmp(&spread(*b))).unwrap_or(0);
        let half = |i: usize| self.pieces[i].reach + margins[i];
        let mut spans: Vec<Span> =
            finite.iter().map(|i| Span { middle: self.middle(*i), half: half(*i), piece: *i }).collect();
        spans.sort_by(|a, b| a.ends(axis)[0].total_cmp(&b.ends(axis)[0]));
        let mut found = Vec::new();
        for (at, one) in spans.iter().enumerate() {
            let end = one.ends(axis)[1];
            for other in spans[at + 1..].iter().take_while(|other| other.ends(axis)[0] <= end) {
                let within = one.half + other.half;
                if (one.middle - other.middle).norm_squared() <= within * within {
                    found.extend(self.couple_of(one.piece, other.piece));
                }
            }
        }
        for plane in (0..self.pieces.len()).filter(|i| self.pieces[*i].reach.is_infinite()) {
            let near = |i: &&usize| self.above(plane, **i) <= half(**i) + margins[plane];
            found.extend(finite.iter().filter(near).filter_map(|i| self.couple_of(plane, *i)));
        }
        found.sort_unstable();
        found
    }

    /// Two pieces as a couple, if they may touch.
    fn couple_of(&self, i: usize, j: usize) -> Option<usize> {
        let own = &self.partners[i.min(j)];
        own.binary_search_by_key(&i.max(j), |(partner, _)| *partner).ok().map(|at| own[at].1)
    }

    /// How far the middle of a piece is above a plane (m).
    fn above(&self, plane: usize, piece: usize) -> f64 {
        let normal = match &self.pieces[plane].solid {
            Solid::Plane(normal) => self.poses[plane].rotation * normal,
            Solid::Round(..) => Vector3::zeros(),
        };
        normal.dot(&(self.middle(piece) - self.middle(plane)))
    }

    fn standing(&self, piece: usize) -> PlacedBoundary<'_> {
        self.pieces[piece].boundary.standing(&self.poses[piece])
    }

    /// How far the balls around both shapes are apart, or one from a plane (m).
    pub(crate) fn apart(&self, couple: usize) -> f64 {
        let [a, b] = self.couples[couple].pieces;
        match [a, b].map(|piece| self.pieces[piece].reach) {
            [one, other] if one.is_infinite() => self.above(a, b) - other,
            [one, other] if other.is_infinite() => self.above(b, a) - one,
            [one, other] => (self.middle(a) - self.middle(b)).norm() - one - other,
        }
    }

    /// How far two shapes are apart along a unit vector from the first to the second, neither being a plane (m).
    pub(crate) fn apart_along(&self, couple: usize, n: &Vector3<f64>) -> f64 {
        let [a, b] = self.couples[couple].pieces.map(|piece| self.standing(piece));
        -b.support(&-n) - a.support(n)
    }

    /// All pairs of features of a couple that count to `loose` (m) and whose gap is below `far` (m). Of what is `known` it is not asked whether
    /// it passes by: what goes on where something else touched passes nothing by.
    pub(crate) fn meetings(
        &self,
        couple: usize,
        [loose, far]: [f64; 2],
        known: impl Fn(&Meeting) -> bool,
        mut put: impl FnMut(Meeting),
    ) {
        let Couple { pieces: [a, b], size, .. } = &self.couples[couple];
        let (a, b) = (self.standing(*a), self.standing(*b));
        // Nothing is behind another feature by more than the smaller shape is thick.
        let near = Near { inside: -loose, gap: far, depth: *size };
        // Of what is far away it is soon enough to know when it is near.
        let soon = if far.is_finite() { far } else { RIM * size };
        let rim = RIM * size + loose;
        let counts = |found: &Meeting| {
            let at_rim = found.inside < rim && found.gap < soon;
            found.inside >= -loose && found.gap < far && !(at_rim && !known(found) && self.passes_by(couple, found))
        };
        for features in pairs(&a, &b) {
            if let Some(found) = meeting(&a, &b, features, &near).filter(counts) {
                put(found);
            }
        }
    }

    /// Whether shapes would not overlap if two features of theirs met and went on a little along their normal: a corner that slides over the
    /// joint of two level boxes lies in the plane of the second one's side, but it passes over it.
    fn passes_by(&self, couple: usize, found: &Meeting) -> bool {
        let Couple { pieces: [a, b], size, .. } = self.couples[couple];
        let further = FURTHER * (RIM * size).max(found.inside);
        let closer = Isometry3::from(found.normal * -(found.gap + further)) * self.poses[b];
        let touched = touch(&self.placed(a), &self.pieces[b].solid.placed(&closer), 0.0);
        touched.is_ok_and(|touched| touched.is_none_or(|touched| -touched.gap < MEETS * further))
    }

    /// A shape where it stands.
    pub(crate) fn placed(&self, piece: usize) -> Placed {
        self.pieces[piece].solid.placed(&self.poses[piece])
    }

    /// Adds the contacts of a couple that count to `loose` (parts of its size) and whose gap is below `far` (m), each place once.
    pub(crate) fn facing(&self, couple: usize, loose: f64, far: f64, found: &mut Vec<(Key, Meeting)>) {
        let (first, size) = (found.len(), self.couples[couple].size);
        let overlap = std::cell::OnceCell::new();
        self.meetings(
            couple,
            [loose * size, far],
            |_| false,
            |meeting| {
                let depth = || *overlap.get_or_init(|| self.depth(couple));
                let counts = meeting.gap > -SHALLOW * size || meeting.gap >= -DEEPER * depth();
                let double = |(_, other): &(Key, Meeting)| {
                    (other.point - meeting.point).norm() < ONE_PLACE * size && other.normal.dot(&meeting.normal) > 0.99
                };
                if counts && !found[first..].iter().any(double) {
                    found.push((Key { couple, features: meeting.features }, meeting));
                }
            },
        );
    }

    /// How far two shapes overlap (m); 0 if they do not.
    pub(crate) fn depth(&self, couple: usize) -> f64 {
        let [a, b] = self.couples[couple].pieces.map(|piece| self.placed(piece));
        touch(&a, &b, 0.0).ok().flatten().map_or(0.0, |found| (-found.gap).max(0.0))
    }

    /// Whether there is such a couple, with such features.
    pub(crate) fn knows(&self, key: &Key) -> bool {
        self.couples.get(key.couple).is_some_and(|couple| {
            let [a, b] = couple.pieces.map(|piece| self.standing(piece));
            pairs(&a, &b).into_iter().any(|features| features == key.features)
        })
    }

    /// One pair of features.
    pub(crate) fn meeting(&self, key: &Key) -> Option<Meeting> {
        let [a, b] = self.couples[key.couple].pieces;
        meeting(&self.standing(a), &self.standing(b), key.features, &Near::ALL)
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

/// The convex solids of a shape, in the shape's axes.
fn solids_of(shape: &Shape) -> Result<Vec<Solid>, String> {
    Ok(vec![match &shape.geometry {
        Geometry::Plane(normal) => Solid::Plane(normal.normalize()),
        Geometry::Sphere(radius) => Solid::Round(Core::point(), *radius),
        Geometry::Capsule { radius, length } => Solid::Round(Core::segment(*length), *radius),
        Geometry::Box(edges) => Solid::Round(Core::cuboid(edges), 0.0),
        Geometry::Cylinder { radius, length } => Solid::Round(Core::cylinder(*radius, *length), 0.0),
        Geometry::Mesh { parts, .. } if parts.is_empty() => {
            return Err("the convex parts of its mesh are not known".to_owned());
        }
        Geometry::Mesh { parts, .. } => {
            let of = |part: &Hull| {
                Core::mesh(part.corners.clone(), part.triangles.clone()).map(|core| Solid::Round(core, 0.0))
            };
            return parts.iter().map(of).collect::<Result<_, _>>().map_err(|error| error.to_string());
        }
    }])
}
