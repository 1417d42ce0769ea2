//! Triangles of the forms that are drawn, each in axes of its own.

use crate::mesh::{Mesh, MeshError};
use crate::record::solids::Form;
use nalgebra::{Point3, Rotation3, Unit, Vector3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;

/// Sides of a round form, and rings from the equator of a ball to its pole.
const FINE: Detail = Detail { sides: 32, rings: 8 };
/// Sides and rings of what is seen small.
const COARSE: Detail = Detail { sides: 12, rings: 3 };
/// Turns of a coil, points in a turn, and sides of its wire.
const TURNS: usize = 8;
const POINTS_PER_TURN: usize = 16;
const WIRE_SIDES: usize = 6;
/// Part of a coil at both ends that is straight.
const STRAIGHT: f64 = 0.1;
/// Thickness of a wire against the radius of its coil.
const WIRE: f64 = 0.16;

/// Triangles with a normal at each corner; single precision, as in files of pictures.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Triangles {
    /// Corners (m).
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, one per corner.
    pub normals: Vec<[f32; 3]>,
    /// Three corners each, counter-clockwise as seen from outside.
    pub corners: Vec<[u32; 3]>,
    /// Whether the inside cannot be seen from outside; of mesh files it is not known.
    pub closed: bool,
    /// Of a wire along a path how many outlines it has, each with as many corners; 0 of anything else.
    pub(in crate::record) rings: usize,
}

/// How finely round forms are cut.
#[derive(Debug, Clone, Copy)]
struct Detail {
    sides: usize,
    rings: usize,
}

impl Triangles {
    /// Of a solid's form, in the axes of the solid; round ones of at least the radius `fine` (m) have more sides.
    ///
    /// # Errors
    /// If a mesh file cannot be read.
    pub(super) fn of(form: &Form, fine: f64) -> Result<Self, MeshError> {
        let mut triangles = Self::empty();
        let detail = |radius: f64| if radius >= fine { FINE } else { COARSE };
        match form {
            Form::Box(edges) => triangles.cuboid(edges, 0.0),
            Form::Ball(radius) => triangles.ball(*radius, 0.0, detail(*radius)),
            Form::Cylinder { radius, length } => {
                let half = 0.5 * length;
                triangles
                    .revolve(&[(0.0, -half), (*radius, -half), (*radius, half), (0.0, half)], detail(*radius).sides);
            }
            Form::Capsule { radius, length } => triangles.ball(*radius, *length, detail(*radius)),
            Form::Mesh { file, scale, .. } => triangles.mesh(&Mesh::read(Path::new(file))?, scale),
        }
        Ok(triangles)
    }

    /// None yet, of a surface without holes.
    pub(super) fn empty() -> Self {
        Self { closed: true, ..Self::default() }
    }

    /// A rod of length and radius one, from the origin along z.
    pub(super) fn rod() -> Self {
        let mut triangles = Self::empty();
        triangles.revolve(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)], COARSE.sides);
        triangles
    }

    /// A damper of length and radius one, from the origin along z: a cylinder, and the rod of its piston.
    pub(super) fn damper() -> Self {
        let mut triangles = Self::empty();
        let outline =
            [(0.0, 0.0), (0.3, 0.0), (0.3, 0.15), (1.0, 0.15), (1.0, 0.6), (0.3, 0.6), (0.3, 1.0), (0.0, 1.0)];
        triangles.revolve(&outline, COARSE.sides);
        triangles
    }

    /// An arrow of length one, from the origin along z.
    pub(super) fn arrow() -> Self {
        let mut triangles = Self::empty();
        triangles.revolve(&[(0.0, 0.0), (0.02, 0.0), (0.02, 0.78), (0.055, 0.78), (0.0, 1.0)], COARSE.sides);
        triangles
    }

    /// A wire of this radius along a path (m), from point to point; `None` of a path without length.
    pub(super) fn wire(path: &[Vector3<f64>], radius: f64) -> Option<Self> {
        let mut path: Vec<Vector3<f64>> = path.iter().filter(|at| at.iter().all(|x| x.is_finite())).copied().collect();
        path.dedup();
        let mut triangles = Self { rings: path.len(), ..Self::empty() };
        triangles.tube(&path, radius);
        (path.len() > 1).then_some(triangles)
    }

    /// A coil of length and radius one, from the origin along z; its wire is round when the coil is stretched to `slenderness` times its
    /// radius.
    pub(super) fn coil(slenderness: f64) -> Self {
        let count = TURNS * POINTS_PER_TURN;
        let spiral = (0..=count).map(|k| {
            let part = k as f64 / count as f64;
            let (sin, cos) = (TAU * TURNS as f64 * part).sin_cos();
            Vector3::new(cos, sin, slenderness * (STRAIGHT + part * (1.0 - 2.0 * STRAIGHT)))
        });
        let on_axis = |part: f64| Vector3::new(0.0, 0.0, slenderness * part);
        let path: Vec<Vector3<f64>> = [on_axis(0.0), on_axis(STRAIGHT)]
            .into_iter()
            .chain(spiral)
            .chain([on_axis(1.0 - STRAIGHT), on_axis(1.0)])
            .collect();
        let mut triangles = Self::empty();
        triangles.tube(&path, WIRE);
        for at in &mut triangles.positions {
            at[2] /= slenderness as f32;
        }
        triangles
    }

    /// Adds a corner and returns its number.
    pub(super) fn corner(&mut self, at: Vector3<f64>, normal: Vector3<f64>) -> u32 {
        self.positions.push(at.cast::<f32>().into());
        self.normals.push(normal.try_normalize(0.0).unwrap_or_else(Vector3::z).cast::<f32>().into());
        (self.positions.len() - 1) as u32
    }

    /// Two triangles between corners of one row and of the next.
    pub(super) fn patch(&mut self, [a, b]: [u32; 2], [c, d]: [u32; 2]) {
        self.corners.extend([[a, b, d], [a, d, c]]);
    }

    /// Adds a box whose middle is at a height above the origin.
    pub(super) fn cuboid(&mut self, edges: &[f64; 3], height: f64) {
        let half = 0.5 * Vector3::from(*edges);
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut normal = Vector3::zeros();
                normal[axis] = side;
                let signs = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
                let [a, b, c, d] = signs.map(|[first, second]| {
                    let mut at = normal;
                    (at[u], at[v]) = (first * side, second);
                    self.corner(at.component_mul(&half) + height * Vector3::z(), normal)
                });
                self.corners.extend([[a, b, c], [a, c, d]]);
            }
        }
    }

    /// A ball about the origin whose halves are `apart` along z, with a cylinder between them.
    fn ball(&mut self, radius: f64, apart: f64, Detail { sides, rings }: Detail) {
        let rows: Vec<(f64, f64)> = (0..=2 * rings + 1)
            .map(|row| {
                let (ring, side) = if row <= rings { (row, -0.5) } else { (row - 1, 0.5) };
                (PI * ring as f64 / (2 * rings) as f64 - FRAC_PI_2, side * apart)
            })
            .collect();
        let mut last: Option<Vec<u32>> = None;
        for (latitude, shift) in rows {
            let ring: Vec<u32> = (0..=sides)
                .map(|side| {
                    let (sin, cos) = (TAU * side as f64 / sides as f64).sin_cos();
                    let normal = Vector3::new(latitude.cos() * cos, latitude.cos() * sin, latitude.sin());
                    self.corner(radius * normal + shift * Vector3::z(), normal)
                })
                .collect();
            if let Some(last) = &last {
                (0..sides).for_each(|k| self.patch([last[k], last[k + 1]], [ring[k], ring[k + 1]]));
            }
            last = Some(ring);
        }
        self.drop_empty();
    }

    /// Turns an outline about z: points (distance from the axis, height), from below; its edges stay sharp.
    fn revolve(&mut self, outline: &[(f64, f64)], sides: usize) {
        for pair in outline.windows(2) {
            let [(r0, z0), (r1, z1)] = [pair[0], pair[1]];
            let rows = [(r0, z0), (r1, z1)].map(|(radius, height)| {
                (0..=sides)
                    .map(|side| {
                        let (sin, cos) = (TAU * side as f64 / sides as f64).sin_cos();
                        let normal = Vector3::new((z1 - z0) * cos, (z1 - z0) * sin, r0 - r1);
                        self.corner(Vector3::new(radius * cos, radius * sin, height), normal)
                    })
                    .collect::<Vec<u32>>()
            });
            let [low, high] = rows;
            (0..sides).for_each(|k| self.patch([low[k], low[k + 1]], [high[k], high[k + 1]]));
        }
        self.drop_empty();
    }

    /// A tube along a path.
    fn tube(&mut self, path: &[Vector3<f64>], radius: f64) {
        let chord = path.windows(2).map(|ends| ends[1] - ends[0]).next().unwrap_or_default();
        let mut side = if chord.x.abs() < 0.9 * chord.norm() { Vector3::x() } else { Vector3::y() };
        let mut last: Option<Vec<u32>> = None;
        for (k, at) in path.iter().enumerate() {
            let (before, after) = (path[k.saturating_sub(1)], path[(k + 1).min(path.len() - 1)]);
            // Where a path turns back on itself it goes on as it comes.
            let along = Unit::try_new(after - before, 0.0).unwrap_or_else(|| Unit::new_normalize(at - before));
            // The side that was, as far as it is across the path here.
            side = (side - along.scale(side.dot(&along))).try_normalize(1e-6).unwrap_or(side);
            let ring: Vec<u32> = (0..=WIRE_SIDES)
                .map(|k| {
                    let turn = Rotation3::from_axis_angle(&along, TAU * k as f64 / WIRE_SIDES as f64);
                    let normal = turn * side;
                    self.corner(at + radius * normal, normal)
                })
                .collect();
            if let Some(last) = &last {
                (0..WIRE_SIDES).for_each(|k| self.patch([last[k], last[k + 1]], [ring[k], ring[k + 1]]));
            }
            last = Some(ring);
        }
    }

    /// A mesh with the normals of its file, or flat triangles.
    fn mesh(&mut self, mesh: &Mesh, scale: &[f64; 3]) {
        self.closed = false;
        let scale = Vector3::from(*scale);
        // A reflection turns the order of corners.
        let mirrored = scale.product() < 0.0;
        let at = |corner: u32| Vector3::from(mesh.vertices[corner as usize]).cast::<f64>().component_mul(&scale);
        for triangle in &mesh.triangles {
            let [a, b, c] = if mirrored { [triangle[0], triangle[2], triangle[1]] } else { *triangle };
            let flat = (at(b) - at(a)).cross(&(at(c) - at(a)));
            if !(flat.norm() > 0.0) {
                continue;
            }
            let normal = |corner: u32| match &mesh.normals {
                Some(normals) => Vector3::from(normals[corner as usize]).cast::<f64>().component_div(&scale),
                None => flat,
            };
            let corners = [a, b, c].map(|corner| self.corner(at(corner), normal(corner)));
            self.corners.push(corners);
        }
    }

    /// Triangles without an area, such as those at a pole.
    fn drop_empty(&mut self) {
        let positions = &self.positions;
        self.corners.retain(|corners| {
            let [a, b, c] = corners.map(|corner| Point3::from(positions[corner as usize]));
            (b - a).cross(&(c - a)).norm() > 1e-6 * (b - a).norm().max((c - a).norm()).powi(2)
        });
    }
}

/// Volume by the divergence theorem: positive if the corners are counter-clockwise as seen from outside.
#[cfg(test)]
pub(super) fn volume(triangles: &Triangles) -> f64 {
    let at = |corner: u32| Vector3::from(triangles.positions[corner as usize]).cast::<f64>();
    triangles.corners.iter().map(|[a, b, c]| at(*a).dot(&at(*b).cross(&at(*c))) / 6.0).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_enclose_their_volumes_and_normals_point_outward() {
        let of = |form: Form| Triangles::of(&form, 0.0).expect("no file");
        // An inscribed prism of n sides has this part of the area of its circle.
        let part = |sides: usize| (TAU / sides as f64).sin() / (TAU / sides as f64);
        for (triangles, exact, least) in [
            (of(Form::Box([1.0, 2.0, 3.0])), 6.0, 1.0 - 1e-6),
            (of(Form::Cylinder { radius: 0.5, length: 2.0 }), 0.5 * PI, part(FINE.sides) - 1e-6),
            (of(Form::Ball(1.0)), 4.0 / 3.0 * PI, 0.97),
            (of(Form::Capsule { radius: 1.0, length: 2.0 }), (4.0 / 3.0 + 2.0) * PI, 0.97),
            (Triangles::rod(), PI, part(COARSE.sides) - 1e-6),
        ] {
            let found = volume(&triangles) / exact;
            assert!(found >= least && found <= 1.0 + 1e-6, "{found} of {exact}");
            for corners in &triangles.corners {
                let [a, b, c] = corners.map(|corner| Vector3::from(triangles.positions[corner as usize]));
                let flat = (b - a).cross(&(c - a)).normalize();
                for corner in corners {
                    assert!(flat.dot(&Vector3::from(triangles.normals[*corner as usize])) > 0.9);
                }
            }
        }
        assert!(volume(&Triangles::arrow()) > 0.0 && volume(&Triangles::coil(8.0)) > 0.0);
    }

    #[test]
    fn a_wire_is_as_thick_whichever_way_it_goes() {
        for way in [
            Vector3::x(),
            -Vector3::x(),
            Vector3::y(),
            Vector3::z(),
            Vector3::new(1.0, 1e-9, 0.0),
            Vector3::new(1.0, 2.0, -1.0),
        ] {
            let wire = Triangles::wire(&[Vector3::zeros(), way], 0.1).expect("two points");
            for at in &wire.positions {
                let away = Vector3::from(*at).cast::<f64>().cross(&way.normalize()).norm();
                assert!((away - 0.1).abs() < 1e-6, "{away} along {way}");
            }
        }
    }

    #[test]
    fn a_coil_has_length_one_and_its_ends_on_the_axis() {
        let coil = Triangles::coil(10.0);
        let heights = || coil.positions.iter().map(|at| at[2]);
        // The wire's ends are flat across the axis.
        assert!(heights().fold(f32::INFINITY, f32::min).abs() < 1e-6);
        assert!((heights().fold(0.0, f32::max) - 1.0).abs() < 1e-6);
    }
}
