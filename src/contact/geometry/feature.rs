//! Pairs of features of two convex solids: the gap between a vertex, edge or face of one and one of the other, as smooth functions
//! of their poses as long as the pair is the nearest.
//!
//! ```text
//! (1)  gap = n·(x_b − x_a) − r_a − r_b,   x_a, x_b the points of the cores that are nearest to each other
//! (2)  vertex, face    n the normal of the face                  edge, edge      n = ± e_a × e_b / |e_a × e_b|
//!      vertex, edge    n = (x_b − x_a) / |x_b − x_a|             vertex, vertex  the same
//! ```
//!
//! A pair counts where the foot of the perpendicular is inside its face or edge, and where no other vertex of a solid is
//! further along the normal than its feature: [`Meeting::inside`] says by how much (m).

use super::solid::{Core, Solid};
use nalgebra::{Isometry3, Vector3};

/// A part of a core's boundary, by its index there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Feature {
    /// A face; the only one of a plane.
    Face(u16),
    /// An edge.
    Edge(u16),
    /// A vertex.
    Vertex(u16),
}

/// Vertices, edges and faces of a core, in the axes of its shape.
#[derive(Debug, Clone, Default)]
pub struct Boundary {
    vertices: Vec<Vector3<f64>>,
    pub(super) edges: Vec<[usize; 2]>,
    faces: Vec<Face>,
    /// Half space with this normal through the origin.
    pub(super) plane: Option<Vector3<f64>>,
    pub(super) radius: f64,
    /// Radius of a cylinder, along whose z its only edge is (m); else 0.
    pub(super) rim: f64,
}

/// A face: its outward normal, and its corners counter-clockwise as seen from outside.
#[derive(Debug, Clone)]
struct Face {
    normal: Vector3<f64>,
    corners: Vec<usize>,
}

/// A boundary where its shape stands.
#[derive(Debug, Clone)]
pub struct PlacedBoundary<'a> {
    pub(super) of: &'a Boundary,
    pub(super) vertices: Vec<Vector3<f64>>,
    pub(super) pose: Isometry3<f64>,
}

/// A point on the rim of a cylinder.
#[derive(Debug, Clone, Copy)]
pub struct Rim {
    /// From the axis to the point (m).
    pub(super) arm: Vector3<f64>,
    /// Unit vector along the rim.
    pub(super) tangent: Vector3<f64>,
    /// Sine of the angle between the axis and the normal; 0 if it meets no face.
    pub(super) tilt: f64,
}

/// Two features and how they stand to each other.
#[derive(Debug, Clone, Copy)]
pub struct Meeting {
    /// Of the first solid and of the second.
    pub features: [Feature; 2],
    /// Eq. (1) (m).
    pub gap: f64,
    /// From the first to the second, inertial axes.
    pub normal: Vector3<f64>,
    /// Nearest points of the cores (m).
    pub cores: [Vector3<f64>; 2],
    /// Radii of the surfaces about them (m).
    pub radii: [f64; 2],
    /// Of points that move along the rim of a cylinder.
    pub rims: [Option<Rim>; 2],
    /// Directions of the edges, unit vectors; zero for other features.
    pub edges: [Vector3<f64>; 2],
    /// How far the pair is inside of where it counts (m), negative outside.
    pub inside: f64,
    /// How far points that are fixed to a rim are inside of where they count, which they do only while its disc lies flat (m); infinite
    /// for others.
    pub flat: f64,
    /// Halfway between both surfaces (m).
    pub point: Vector3<f64>,
}

/// Edges that cross at a smaller angle have no normal of their own: their ends and faces do.
pub(super) const PARALLEL: f64 = 1e-6;
/// A vertex of a solid that is turned by no more may be the next to touch a face (rad).
pub(super) const TILTED: f64 = 0.1;
/// Triangles whose normals differ by less belong to one face.
const FLAT: f64 = 1e-9;

impl Boundary {
    /// The boundary of a solid.
    pub fn new(solid: &Solid) -> Self {
        match solid {
            Solid::Plane(normal) => Self { plane: Some(*normal), ..Self::default() },
            Solid::Round(core, radius) => Self::of_core(core, *radius),
        }
    }

    fn of_core(core: &Core, radius: f64) -> Self {
        let at = |i: usize| core.vertices[i];
        let mut groups: Vec<(Vector3<f64>, Vec<[usize; 3]>)> = Vec::new();
        for triangle in &core.triangles {
            let [a, b, c] = triangle.map(at);
            let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else { continue };
            match groups.iter_mut().find(|(known, _)| (known - normal).norm() < FLAT) {
                Some((_, triangles)) => triangles.push(*triangle),
                None => groups.push((normal, vec![*triangle])),
            }
        }
        let faces: Vec<Face> =
            groups.into_iter().map(|(normal, triangles)| Face { normal, corners: rim(&triangles) }).collect();
        let mut edges: Vec<[usize; 2]> = Vec::new();
        if core.vertices.len() == 2 {
            edges.push([0, 1]);
        }
        for face in &faces {
            for (i, from) in face.corners.iter().enumerate() {
                let to = face.corners[(i + 1) % face.corners.len()];
                let edge = [*from.min(&to), *from.max(&to)];
                if !edges.contains(&edge) {
                    edges.push(edge);
                }
            }
        }
        Self { vertices: core.vertices.clone(), edges, faces, plane: None, radius, rim: core.rim }
    }

    /// The boundary where its shape stands.
    pub fn standing(&self, pose: &Isometry3<f64>) -> PlacedBoundary<'_> {
        let vertices = self.vertices.iter().map(|v| pose.translation.vector + pose.rotation * v).collect();
        PlacedBoundary { of: self, vertices, pose: *pose }
    }
}

/// The corners around triangles of one plane: the directed edges that have no opposite, one after the other.
fn rim(triangles: &[[usize; 3]]) -> Vec<usize> {
    let mut open: Vec<[usize; 2]> = Vec::new();
    for [a, b, c] in triangles {
        for [from, to] in [[*a, *b], [*b, *c], [*c, *a]] {
            match open.iter().position(|edge| *edge == [to, from]) {
                Some(opposite) => {
                    open.swap_remove(opposite);
                }
                None => open.push([from, to]),
            }
        }
    }
    let Some(first) = open.first().copied() else { return Vec::new() };
    let mut corners = vec![first[0]];
    let mut at = first[1];
    while at != first[0] && corners.len() <= open.len() {
        corners.push(at);
        let Some(next) = open.iter().find(|edge| edge[0] == at) else { break };
        at = next[1];
    }
    corners
}

impl PlacedBoundary<'_> {
    pub(super) fn ends(&self, edge: u16) -> [Vector3<f64>; 2] {
        self.of.edges[usize::from(edge)].map(|i| self.vertices[i])
    }

    /// The largest `n·x` of the solid, which is no plane (m).
    pub fn support(&self, n: &Vector3<f64>) -> f64 {
        let corners = self.vertices.iter().map(|v| n.dot(v)).fold(f64::NEG_INFINITY, f64::max);
        let across = if self.of.rim > 0.0 { (self.pose.rotation * Vector3::z()).cross(n).norm() } else { 0.0 };
        corners + self.of.radius + self.of.rim * across
    }

    /// How far a point is before the plane of a face (m).
    pub(super) fn above(&self, face: u16, point: &Vector3<f64>) -> f64 {
        let (normal, on) = self.plane_of(face);
        normal.dot(&(point - on))
    }

    /// The outward normal of a face, and a point of it.
    fn plane_of(&self, face: u16) -> (Vector3<f64>, Vector3<f64>) {
        match &self.of.plane {
            Some(normal) => (self.pose.rotation * normal, self.pose.translation.vector),
            None => {
                let face = &self.of.faces[usize::from(face)];
                (self.pose.rotation * face.normal, self.vertices[face.corners[0]])
            }
        }
    }

    /// How far a point is inside a face, seen along its normal (m).
    pub(super) fn inside(&self, face: u16, point: &Vector3<f64>) -> f64 {
        let face = &self.of.faces[usize::from(face)];
        let normal = self.pose.rotation * face.normal;
        let corners = face.corners.iter().enumerate().map(|(i, from)| {
            let (from, to) = (self.vertices[*from], self.vertices[face.corners[(i + 1) % face.corners.len()]]);
            normal.cross(&(to - from)).normalize().dot(&(point - from))
        });
        corners.fold(f64::INFINITY, f64::min)
    }

    /// How far below `at` along `n` all vertices are that are not among `own` (m); infinite if there are no others.
    pub(super) fn below(&self, n: &Vector3<f64>, at: &Vector3<f64>, own: &[usize]) -> f64 {
        let others = self.vertices.iter().enumerate().filter(|(i, _)| !own.contains(i));
        others.map(|(_, v)| n.dot(&(at - v))).fold(f64::INFINITY, f64::min)
    }

    /// How far all other vertices are before a face with this normal that a vertex touches, or turned behind it by less than
    /// [`TILTED`] (m).
    pub(super) fn before(&self, n: &Vector3<f64>, vertex: u16) -> f64 {
        let at = self.vertices[usize::from(vertex)];
        let others = self.vertices.iter().enumerate().filter(|(i, _)| *i != usize::from(vertex));
        others.map(|(_, v)| n.dot(&(v - at)) + TILTED * (v - at).norm()).fold(f64::INFINITY, f64::min)
    }

    pub(super) fn vertex_list(&self) -> impl Iterator<Item = Feature> + use<> {
        (0..self.vertices.len() as u16).map(Feature::Vertex)
    }

    pub(super) fn edge_list(&self) -> impl Iterator<Item = Feature> + use<> {
        (0..self.of.edges.len() as u16).map(Feature::Edge)
    }

    pub(super) fn face_list(&self) -> impl Iterator<Item = Feature> + use<> {
        let faces = if self.of.plane.is_some() { 1 } else { self.of.faces.len() };
        (0..faces as u16).map(Feature::Face)
    }
}

/// Which pairs of features are asked for: those that are inside of where they count by at least so much, and whose gap is within bounds
/// (m). Pairs beyond them are left out early where that is cheap, and may be given where it is not.
#[derive(Debug, Clone, Copy)]
pub struct Near {
    /// Least of [`Meeting::inside`].
    pub inside: f64,
    /// Upper bound of [`Meeting::gap`].
    pub gap: f64,
    /// Upper bound of how deep features are behind each other.
    pub depth: f64,
}

impl Near {
    /// All pairs.
    pub const ALL: Self = Self { inside: f64::NEG_INFINITY, gap: f64::INFINITY, depth: f64::INFINITY };
}

/// Two edges, with radii about them.
pub(super) fn crossing(
    a: &PlacedBoundary<'_>,
    b: &PlacedBoundary<'_>,
    [one, other]: [u16; 2],
    radii: [f64; 2],
    near: &Near,
) -> Option<Meeting> {
    let ([p, q], [r, s]) = (a.ends(one), b.ends(other));
    let (u, v) = ((q - p).normalize(), (s - r).normalize());
    let crossed = u.cross(&v);
    let normal = crossed.try_normalize(PARALLEL)?;
    // Parameters of the common perpendicular (m).
    let (between, square) = (r - p, crossed.norm_squared());
    let x = between.cross(&v).dot(&crossed) / square;
    let y = between.cross(&u).dot(&crossed) / square;
    let (at, to) = (p + u * x, r + v * y);
    let along = x.min((q - p).norm() - x).min(y).min((s - r).norm() - y);
    // Before the solids say which normal is theirs, the features may as well be this far apart as behind each other.
    let (far, round) = (normal.dot(&between).abs(), radii[0] + radii[1]);
    if along < near.inside || far - round >= near.gap && far + round > near.depth {
        return None;
    }
    let side = |normal: Vector3<f64>| {
        let [mine, other] = [a.of.edges[usize::from(one)], b.of.edges[usize::from(other)]];
        a.below(&normal, &at, &mine).min(b.below(&-normal, &to, &other))
    };
    // Of both normals the one that has both solids behind it; segments without a body lie on either side.
    let (ahead, behind) = (side(normal), side(-normal));
    let flip = if ahead == behind { normal.dot(&(to - at)) < 0.0 } else { behind > ahead };
    let (normal, outside) = if flip { (-normal, behind) } else { (normal, ahead) };
    let features = [Feature::Edge(one), Feature::Edge(other)];
    Some(Meeting::new(features, normal, [at, to], [u, v], radii, along.min(outside)))
}

impl Meeting {
    /// Of two points of cores (m) with radii about them (m), a unit normal between them, and directions of edges.
    pub(super) fn new(
        features: [Feature; 2],
        normal: Vector3<f64>,
        cores: [Vector3<f64>; 2],
        edges: [Vector3<f64>; 2],
        radii: [f64; 2],
        inside: f64,
    ) -> Self {
        let gap = normal.dot(&(cores[1] - cores[0])) - radii[0] - radii[1];
        let point = cores[0] + normal * (radii[0] + 0.5 * gap);
        Self { features, gap, normal, cores, radii, rims: [None; 2], edges, inside, flat: f64::INFINITY, point }
    }

    /// Whether it is the lowest point of a rim, which moves along that.
    pub fn tips(&self) -> bool {
        self.rims.iter().flatten().any(|rim| rim.tilt > 0.0)
    }
}

/// Normal of a face, the foot of a point on it, and how far that is inside.
pub(super) fn on_face(of: &PlacedBoundary<'_>, face: u16, point: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>, f64) {
    let (normal, on) = of.plane_of(face);
    let foot = point - normal * normal.dot(&(point - on));
    let inside = if of.of.plane.is_some() { f64::INFINITY } else { of.inside(face, &foot) };
    (normal, foot, inside)
}

/// The foot of a point on an edge, the direction of the edge, and how far that is between its ends.
pub(super) fn on_edge([p, q]: [Vector3<f64>; 2], point: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>, f64) {
    let length = (q - p).norm();
    let u = (q - p) / length;
    let along = u.dot(&(point - p));
    (p + u * along, u, along.min(length - along))
}
