//! Gaps, normals and points of contact against closed forms and against sampling.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use stillpoint::contact::geometry::{Core, Placed, Solid, Touch, touch};

const SLACK: f64 = 1e-7;

fn at(x: f64, y: f64, z: f64) -> Isometry3<f64> {
    Isometry3::translation(x, y, z)
}

fn sphere(radius: f64) -> Solid {
    Solid::Round(Core::point(), radius)
}

fn cuboid(x: f64, y: f64, z: f64) -> Solid {
    Solid::Round(Core::cuboid(&Vector3::new(x, y, z)), 0.0)
}

fn capsule(radius: f64, length: f64) -> Solid {
    Solid::Round(Core::segment(length), radius)
}

fn touching(a: &Solid, pa: &Isometry3<f64>, b: &Solid, pb: &Isometry3<f64>) -> Touch {
    touch(&a.placed(pa), &b.placed(pb), SLACK).unwrap().expect("they touch")
}

struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.within(-1.0, 1.0))
    }

    fn turn(&mut self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(self.vector() * 3.0)
    }

    fn solid(&mut self) -> Solid {
        let size = |random: &mut Self| random.within(0.2, 1.0);
        match (self.next() * 3.0) as usize {
            0 => sphere(size(self)),
            1 => capsule(size(self), size(self)),
            _ => cuboid(size(self), size(self), size(self)),
        }
    }
}

#[test]
fn a_box_on_a_plane_stands_on_four_corners_wherever_the_plane_is() {
    let mut random = Random(7);
    for _ in 0..200 {
        let world = Isometry3::from_parts(Translation3::from(random.vector()), random.turn());
        let plane = Solid::Plane(Vector3::z());
        let standing = world * at(random.within(-5.0, 5.0), 0.3, 0.15);
        let found = touching(&plane, &world, &cuboid(0.4, 0.2, 0.3), &standing);
        assert_eq!(found.points.len(), 4);
        assert!(found.gap.abs() < 1e-12 && (found.normal - world.rotation * Vector3::z()).norm() < 1e-12);
        let other = touching(&cuboid(0.4, 0.2, 0.3), &standing, &plane, &world);
        assert!((found.normal + other.normal).norm() < 1e-12);
    }
}

#[test]
fn balls_and_capsules_touch_in_one_point_or_along_a_line() {
    let found = touching(&sphere(0.3), &at(0.0, 0.0, 0.0), &sphere(0.2), &at(0.3, 0.4, 0.0));
    assert!(found.gap.abs() < 1e-15 && (found.points[0] - Vector3::new(0.18, 0.24, 0.0)).norm() < 1e-15);
    assert!((found.normal - Vector3::new(0.6, 0.8, 0.0)).norm() < 1e-15);
    // A capsule lying on a box, and one standing on it.
    let lying = at(0.0, 0.0, 0.6) * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.5 * std::f64::consts::PI);
    let found = touching(&cuboid(1.0, 1.0, 1.0), &at(0.0, 0.0, 0.0), &capsule(0.1, 0.5), &lying);
    assert_eq!(found.points.len(), 2);
    assert!((found.points[0] - found.points[1]).norm() - 0.5 < 1e-12);
    let found = touching(&cuboid(1.0, 1.0, 1.0), &at(0.0, 0.0, 0.0), &capsule(0.1, 0.5), &at(0.0, 0.0, 0.85));
    assert_eq!(found.points.len(), 1);
}

#[test]
fn boxes_share_the_polygon_in_which_their_faces_overlap() {
    let one = cuboid(1.0, 1.0, 1.0);
    let found = touching(&one, &at(0.0, 0.0, 0.0), &one, &at(0.5, 0.0, 1.0));
    let mut xs: Vec<f64> = found.points.iter().map(|p| p.x).collect();
    xs.sort_by(f64::total_cmp);
    assert_eq!(found.points.len(), 4);
    assert!((xs[0] - 0.0).abs() < 1e-6 && (xs[3] - 0.5).abs() < 1e-6 && found.normal == Vector3::z());
    // Turned by 45°: an octagon.
    let turned = at(0.0, 0.0, 1.0) * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.25 * std::f64::consts::PI);
    assert_eq!(touching(&one, &at(0.0, 0.0, 0.0), &one, &turned).points.len(), 8);
    // On an edge: two points; on a corner: one; edges across each other: one.
    let tilt = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.25 * std::f64::consts::PI);
    let on_edge = at(0.0, 0.0, 0.5 + 0.5_f64.sqrt()) * tilt;
    assert_eq!(touching(&one, &at(0.0, 0.0, 0.0), &one, &on_edge).points.len(), 2);
    let across = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.25 * std::f64::consts::PI);
    let found = touching(&one, &(at(0.0, 0.0, 0.0) * across), &one, &(at(0.0, 0.0, 2.0_f64.sqrt()) * tilt));
    assert_eq!(found.points.len(), 1);
    assert!((found.points[0] - Vector3::new(0.0, 0.0, 0.5_f64.sqrt())).norm() < 1e-12, "{found:?}");
}

/// Pairs in random poses, pushed together along the line between them until their gap is zero: there they touch, the
/// normal separates them, and a hair further in they overlap.
#[test]
fn pairs_that_are_brought_together_touch_where_a_plane_separates_them() {
    let mut random = Random(11);
    let mut tried = 0;
    for _ in 0..600 {
        let (a, b) = (random.solid(), random.solid());
        let (turn_a, turn_b, along) = (random.turn(), random.turn(), random.vector().normalize());
        let pose_a = Isometry3::from_parts(Translation3::identity(), turn_a);
        let pose_b = |far: f64| Isometry3::from_parts(Translation3::from(along * far), turn_b);
        // Bisection on whether they touch at all.
        let near = |far: f64| !matches!(touch(&a.placed(&pose_a), &b.placed(&pose_b(far)), 1e-9), Ok(None));
        let (mut low, mut high) = (0.0, 10.0);
        assert!(near(low) && !near(high));
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if near(middle) { low = middle } else { high = middle }
        }
        let (one, other) = (a.placed(&pose_a), b.placed(&pose_b(low)));
        let found = touch(&one, &other, 1e-8).unwrap().expect("they touch");
        assert!(found.gap.abs() < 2e-8, "{found:?}");
        // A separating plane: nothing of the first is beyond it, nothing of the second before it.
        let level = |solid: &Placed, sign: f64| support(solid, &(found.normal * sign));
        assert!(level(&one, 1.0) <= -level(&other, -1.0) + 2e-8);
        for point in &found.points {
            let height = found.normal.dot(point);
            assert!((height - level(&one, 1.0)).abs() < 3e-8 && (height + level(&other, -1.0)).abs() < 3e-8);
        }
        tried += 1;
    }
    assert_eq!(tried, 600);
}

fn support(solid: &Placed, n: &Vector3<f64>) -> f64 {
    // The gap to a plane that the solid is pushed against says how far it reaches.
    let far = 100.0;
    let plane = Solid::Plane(-n).placed(&Isometry3::translation(n.x * far, n.y * far, n.z * far));
    far - touch(&plane, solid, 1e9).unwrap().expect("all within slack").gap
}

#[test]
fn a_dented_mesh_is_refused_and_a_convex_one_is_as_the_box_that_it_is() {
    let like = Core::cuboid(&Vector3::new(0.4, 0.2, 0.3));
    let mesh = Core::mesh(like.vertices.clone(), like.triangles.clone()).unwrap();
    let (mesh, like) = (Solid::Round(mesh, 0.0), Solid::Round(like, 0.0));
    let mut random = Random(5);
    for _ in 0..100 {
        let pose = Isometry3::from_parts(Translation3::new(0.0, 0.0, random.within(0.1, 0.4)), random.turn());
        let (one, other) = (mesh.placed(&at(0.0, 0.0, 0.0)), like.placed(&at(0.0, 0.0, 0.0)));
        let ball = sphere(0.2).placed(&pose);
        let gaps = [&one, &other].map(|solid| touch(solid, &ball, 10.0).unwrap().unwrap().gap);
        assert!((gaps[0] - gaps[1]).abs() < 1e-12);
    }
    let mut dented = Core::cuboid(&Vector3::new(1.0, 1.0, 1.0));
    let (mut vertices, mut triangles) = (dented.vertices.clone(), std::mem::take(&mut dented.triangles));
    vertices.push(Vector3::new(0.0, 0.0, 0.3));
    triangles.retain(|t| t.iter().any(|i| dented.vertices[*i].z < 0.0));
    for [a, b] in [[1, 5], [5, 7], [7, 3], [3, 1]] {
        triangles.push([a, b, 8]);
    }
    assert!(Core::mesh(vertices, triangles).is_err());
}
