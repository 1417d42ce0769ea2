//! What solids are made of.

use nalgebra::{Isometry3, Vector3};

/// A convex core in the axes of its shape.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Core {
    /// Corners (m): one is a point, two are a segment.
    pub vertices: Vec<Vector3<f64>>,
    /// Three corners each, counter-clockwise as seen from outside; none for points and segments.
    pub triangles: Vec<[usize; 3]>,
    /// Outward unit normals of the faces, each once.
    normals: Vec<Vector3<f64>>,
    /// Unit directions of the edges between faces, each once but for its sign.
    edges: Vec<Vector3<f64>>,
    /// Radius of a disc about every corner, across the segment (m): that of a cylinder, else 0.
    pub(super) rim: f64,
}

/// A solid in the axes of its shape.
#[derive(Debug, Clone, PartialEq)]
pub enum Solid {
    /// All points behind a plane through the origin with this outward unit normal.
    Plane(Vector3<f64>),
    /// All points within a radius (m) of a core.
    Round(Core, f64),
}

/// A mesh that is not what it encloses when taken as convex.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotConvex {
    /// A corner lies outside of the plane of a triangle.
    #[error("the mesh is not convex: a corner stands {above:.3e} m out of the plane of a triangle")]
    Dent {
        /// (m)
        above: f64,
    },
    /// No volume.
    #[error("the mesh encloses nothing: it is flat or open")]
    Flat,
}

/// Normals and edges that turn by less than this are one (rad).
const PARALLEL: f64 = 1e-9;

impl Core {
    /// A point at the origin.
    pub fn point() -> Self {
        Self { vertices: vec![Vector3::zeros()], ..Self::default() }
    }

    /// A segment along z about the origin (m).
    pub fn segment(length: f64) -> Self {
        let end = Vector3::z() * (0.5 * length);
        Self { vertices: vec![-end, end], edges: vec![Vector3::z()], ..Self::default() }
    }

    /// A cylinder along z about the origin (m).
    pub fn cylinder(radius: f64, length: f64) -> Self {
        let normals = vec![-Vector3::z(), Vector3::z()];
        Self { normals, rim: radius, ..Self::segment(length) }
    }

    /// A box about the origin with these edge lengths (m).
    pub fn cuboid(edges: &Vector3<f64>) -> Self {
        let corner = |i: usize| {
            let side = |bit: usize| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
            Vector3::new(side(0), side(1), side(2)).component_mul(edges)
        };
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let normals = (0..6).map(|i| Vector3::ith(i / 2, if i % 2 == 0 { -1.0 } else { 1.0 })).collect();
        Self {
            vertices: (0..8).map(corner).collect(),
            triangles: quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect(),
            normals,
            edges: (0..3).map(|i| Vector3::ith(i, 1.0)).collect(),
            rim: 0.0,
        }
    }

    /// A closed convex mesh, its triangles counter-clockwise as seen from outside.
    ///
    /// # Errors
    /// If it is dented by more than 1e-6 of its size, or flat.
    pub fn mesh(vertices: Vec<Vector3<f64>>, triangles: Vec<[usize; 3]>) -> Result<Self, NotConvex> {
        let center = vertices.iter().sum::<Vector3<f64>>() / vertices.len().max(1) as f64;
        let size = vertices.iter().map(|v| (v - center).norm()).fold(0.0, f64::max);
        let (mut normals, mut edges) = (Vec::<Vector3<f64>>::new(), Vec::<Vector3<f64>>::new());
        let mut at_edges = std::collections::BTreeMap::<(usize, usize), Vec<Vector3<f64>>>::new();
        for [a, b, c] in &triangles {
            let normal = (vertices[*b] - vertices[*a]).cross(&(vertices[*c] - vertices[*a]));
            let Some(normal) = normal.try_normalize(1e-12 * size * size) else { continue };
            let above = vertices.iter().map(|v| normal.dot(&(v - vertices[*a]))).fold(0.0, f64::max);
            if above > 1e-6 * size {
                return Err(NotConvex::Dent { above });
            }
            if !normals.iter().any(|known| known.cross(&normal).norm() < PARALLEL && known.dot(&normal) > 0.0) {
                normals.push(normal);
            }
            for (from, to) in [(a, b), (b, c), (c, a)] {
                at_edges.entry((*from.min(to), *from.max(to))).or_default().push(normal);
            }
        }
        if normals.len() < 4 {
            return Err(NotConvex::Flat);
        }
        for ((from, to), beside) in at_edges {
            let flat = beside.len() == 2 && beside[0].cross(&beside[1]).norm() < PARALLEL;
            let along = (vertices[to] - vertices[from]).normalize();
            if !flat && !edges.iter().any(|known| known.cross(&along).norm() < PARALLEL) {
                edges.push(along);
            }
        }
        Ok(Self { vertices, triangles, normals, edges, rim: 0.0 })
    }

    /// Radius of a cylinder about its segment (m); 0 of another core.
    pub fn rim(&self) -> f64 {
        self.rim
    }
}

impl Solid {
    /// A length that it can be compared with (m): the smallest extent of its corners about their middle, its radius if that
    /// is all; infinite for a plane.
    pub fn size(&self) -> f64 {
        let Self::Round(core, radius) = self else { return f64::INFINITY };
        let extent = |axis: usize| {
            let along = core.vertices.iter().map(|v| v[axis]);
            along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
        };
        let across = |axis: usize| if axis == 2 { 0.0 } else { 2.0 * core.rim };
        let extents = (0..3).map(|axis| extent(axis) + across(axis) + 2.0 * radius).filter(|extent| *extent > 0.0);
        extents.fold(f64::INFINITY, f64::min)
    }

    /// Radius of a ball about the origin of its shape that holds it (m); infinite for a plane.
    pub fn reach(&self) -> f64 {
        let Self::Round(core, radius) = self else { return f64::INFINITY };
        core.vertices.iter().map(|vertex| vertex.norm().hypot(core.rim)).fold(0.0, f64::max) + radius
    }

    /// The solid where its shape stands.
    pub fn placed(&self, pose: &Isometry3<f64>) -> Placed {
        match self {
            Self::Plane(normal) => {
                let normal = pose.rotation * normal;
                Placed { plane: Some(normal), vertices: vec![pose.translation.vector], ..Placed::default() }
            }
            Self::Round(core, radius) => Placed {
                plane: None,
                vertices: core.vertices.iter().map(|v| pose.translation.vector + pose.rotation * v).collect(),
                triangles: core.triangles.clone(),
                normals: core.normals.iter().map(|n| pose.rotation * n).collect(),
                edges: core.edges.iter().map(|e| pose.rotation * e).collect(),
                radius: *radius,
                rim: core.rim,
            },
        }
    }
}

/// A solid in inertial axes.
#[derive(Debug, Clone, Default)]
pub struct Placed {
    /// The outward normal of a plane, which stands at the only vertex.
    pub(super) plane: Option<Vector3<f64>>,
    pub(super) vertices: Vec<Vector3<f64>>,
    pub(super) triangles: Vec<[usize; 3]>,
    pub(super) normals: Vec<Vector3<f64>>,
    pub(super) edges: Vec<Vector3<f64>>,
    pub(super) radius: f64,
    /// Of a cylinder, across its only edge (m); else 0.
    pub(super) rim: f64,
}

impl Placed {
    /// The largest `n·x` of the core.
    pub(super) fn support(&self, n: &Vector3<f64>) -> f64 {
        let corners = self.vertices.iter().map(|v| n.dot(v)).fold(f64::NEG_INFINITY, f64::max);
        if self.rim > 0.0 { corners + self.rim * self.edges[0].cross(n).norm() } else { corners }
    }
}

/// How far two cores are apart along a unit vector from the first to the second (m).
pub(super) fn apart(a: &Placed, b: &Placed, n: &Vector3<f64>) -> f64 {
    -b.support(&-n) - a.support(n)
}
