//! Which face hides which: faces in an order in which each may be painted over those before it.
//!
//! A binary space partition (Fuchs, Kedem, Naylor, 1980). A plane divides the faces into those on the eye's side and those beyond; faces
//! that cross it are cut. What is beyond is painted first, then what lies in the plane, then the rest, each ordered in the same way. Large
//! sets are divided at the median of their widest direction, small ones by the plane of one of their faces.
//!
//! Every division comes to its end, whatever rounding does: both parts have fewer faces than the whole, as the face whose plane divides is
//! in neither of them, and a median is taken only if each side has faces of its own. Planes are reckoned from corners of their faces: far
//! from the origin no digits are lost.

use crate::round_off::CORNER;
use nalgebra::Vector3;

/// Larger sets are halved at a median.
const SMALL: usize = 48;
/// Faces whose planes are tried.
const TRIED: usize = 6;
/// A plane convex polygon in axes of the eye: x right, y up, z towards it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Face {
    /// Three or more corners.
    pub(super) points: Vec<Vector3<f64>>,
    /// Red, green, blue, 0…255.
    pub(super) color: [u8; 3],
    /// 0…1.
    pub(super) opacity: f64,
}

/// `normal · (x − base) = 0`, with the normal towards the eye.
#[derive(Debug, Clone, Copy)]
struct Plane {
    normal: Vector3<f64>,
    base: Vector3<f64>,
}

impl Plane {
    fn of(face: &Face) -> Option<Self> {
        // Newell's sum, from the first corner: the normal of a polygon that is plane but for rounding.
        let base = face.points[0];
        let sum: Vector3<f64> = face.points[1..].windows(2).map(|pair| (pair[0] - base).cross(&(pair[1] - base))).sum();
        let normal = sum.try_normalize(0.0)?;
        let normal = if normal.z < 0.0 { -normal } else { normal };
        Some(Self { normal, base })
    }

    fn height(&self, point: &Vector3<f64>) -> f64 {
        self.normal.dot(&(point - self.base))
    }
}

/// Where a face is by a plane.
enum Side {
    Beyond(Face),
    Within(Face),
    Before(Face),
    Cut(Face, Face),
}

/// What is still to be done, the next last.
enum Task {
    Order(Vec<Face>),
    Paint(Vec<Face>),
}

/// From the farthest to the nearest. Points nearer to a plane than `tolerance` (m) are in it.
pub(super) fn back_to_front(faces: Vec<Face>, tolerance: f64) -> Vec<Face> {
    let largest = faces.iter().flat_map(|face| &face.points).map(Vector3::amax).fold(0.0, f64::max);
    let tolerance = tolerance.max(CORNER.of(largest));
    let mut painted = Vec::with_capacity(faces.len());
    let mut tasks = vec![Task::Order(faces)];
    while let Some(task) = tasks.pop() {
        match task {
            Task::Paint(faces) => painted.extend(faces),
            Task::Order(faces) if faces.len() < 2 => painted.extend(faces),
            Task::Order(faces) => {
                let [beyond, within, before] = divide(faces, tolerance);
                tasks.extend([Task::Order(before), Task::Paint(within), Task::Order(beyond)]);
            }
        }
    }
    painted
}

/// Faces beyond a plane, in it, and on the eye's side.
fn divide(mut faces: Vec<Face>, tolerance: f64) -> [Vec<Face>; 3] {
    if faces.len() > SMALL
        && let Some(plane) = median(&faces)
    {
        let is_on = |sign: f64, face: &Face| face.points.iter().all(|point| sign * plane.height(point) > tolerance);
        let count = |sign: f64| faces.iter().filter(|face| is_on(sign, face)).count();
        // Halves that are hardly smaller than the whole are no progress.
        if count(1.0).min(count(-1.0)) * 8 > faces.len() {
            return by(&plane, faces, tolerance);
        }
    }
    let step = faces.len().div_ceil(TRIED);
    let tried = faces.iter().enumerate().step_by(step).filter_map(|(index, face)| Some((index, Plane::of(face)?)));
    let cuts = |(_, plane): &(usize, Plane)| {
        let crosses = |face: &&Face| {
            let heights = || face.points.iter().map(|point| plane.height(point));
            heights().any(|height| height > tolerance) && heights().any(|height| height < -tolerance)
        };
        faces.iter().filter(crosses).count()
    };
    let any = || faces.iter().enumerate().find_map(|(index, face)| Some((index, Plane::of(face)?)));
    match tried.min_by_key(cuts).or_else(any) {
        Some((index, plane)) => {
            let own = faces.swap_remove(index);
            let [beyond, mut within, before] = by(&plane, faces, tolerance);
            within.push(own);
            [beyond, within, before]
        }
        // Faces without an area hide nothing.
        None => [Vec::new(), faces, Vec::new()],
    }
}

/// Across the widest direction of the faces' first corners, through their median.
fn median(faces: &[Face]) -> Option<Plane> {
    let points = || faces.iter().map(|face| face.points[0]);
    let low = points().reduce(|a, b| a.inf(&b))?;
    let high = points().reduce(|a, b| a.sup(&b))?;
    let axis = (high - low).imax();
    let mut places: Vec<f64> = points().map(|point| point[axis]).collect();
    let middle = places.len() / 2;
    let (_, offset, _) = places.select_nth_unstable_by(middle, f64::total_cmp);
    let (mut normal, mut base) = (Vector3::zeros(), Vector3::zeros());
    (normal[axis], base[axis]) = (1.0, *offset);
    Some(Plane { normal, base })
}

fn by(plane: &Plane, faces: Vec<Face>, tolerance: f64) -> [Vec<Face>; 3] {
    let [mut beyond, mut within, mut before] = [Vec::new(), Vec::new(), Vec::new()];
    for face in faces {
        match side(plane, face, tolerance) {
            Side::Beyond(face) => beyond.push(face),
            Side::Within(face) => within.push(face),
            Side::Before(face) => before.push(face),
            Side::Cut(far, near) => {
                beyond.push(far);
                before.push(near);
            }
        }
    }
    [beyond, within, before]
}

fn side(plane: &Plane, face: Face, tolerance: f64) -> Side {
    let heights: Vec<f64> = face.points.iter().map(|point| plane.height(point)).collect();
    let (above, below) = (heights.iter().any(|h| *h > tolerance), heights.iter().any(|h| *h < -tolerance));
    match (above, below) {
        (false, false) => Side::Within(face),
        (true, false) => Side::Before(face),
        (false, true) => Side::Beyond(face),
        (true, true) => {
            let [far, near] = [-1.0, 1.0].map(|sign| {
                let points = clipped(&face.points, &heights, sign);
                Face { points, ..face }
            });
            Side::Cut(far, near)
        }
    }
}

/// The part of a convex polygon on one side of a plane (Sutherland, Hodgman, 1974).
fn clipped(points: &[Vector3<f64>], heights: &[f64], sign: f64) -> Vec<Vector3<f64>> {
    let mut kept = Vec::with_capacity(points.len() + 1);
    for (k, (a, height)) in points.iter().zip(heights).enumerate() {
        let next = (k + 1) % points.len();
        let (b, next) = (&points[next], heights[next]);
        if sign * height >= 0.0 {
            kept.push(*a);
        }
        if height * next < 0.0 {
            kept.push(a + (b - a) * (height / (height - next)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A generator of numbers between 0 and 1 (Steele, Lea, Flood, 2014).
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        }

        fn point(&mut self) -> Vector3<f64> {
            Vector3::from_fn(|_, _| self.next())
        }
    }

    /// Depth of a triangle's plane under a point of the picture, if the point is inside.
    fn depth(points: &[Vector3<f64>], x: f64, y: f64) -> Option<f64> {
        let [a, b, c] = [points[0], points[1], points[2]];
        let cross = |p: &Vector3<f64>, q: &Vector3<f64>| (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
        let parts = [cross(&b, &c), cross(&c, &a), cross(&a, &b)];
        let sum: f64 = parts.iter().sum();
        let inside = parts.iter().all(|part| *part > 0.0) || parts.iter().all(|part| *part < 0.0);
        inside.then(|| (parts[0] * a.z + parts[1] * b.z + parts[2] * c.z) / sum)
    }

    fn contains(points: &[Vector3<f64>], x: f64, y: f64) -> bool {
        (1..points.len() - 1).any(|k| depth(&[points[0], points[k], points[k + 1]], x, y).is_some())
    }

    /// Random triangles, each of another colour.
    fn scene(seed: u64) -> (Random, Vec<Face>) {
        let mut random = Random(seed);
        let count = [3, 12, 40, 150][seed as usize % 4];
        let size = [1.0, 0.6, 0.4, 0.2][seed as usize % 4];
        let triangle = |k: usize| {
            let center = random.point();
            let points = (0..3).map(|_| center + size * random.point()).collect();
            Face { points, color: [(k % 256) as u8, (k / 256) as u8, 0], opacity: 1.0 }
        };
        let triangles = (0..count).map(triangle).collect();
        (random, triangles)
    }

    /// At random places of the picture, the face that is painted last is the nearest of the triangles that cover the place.
    #[test]
    fn what_is_painted_last_is_what_is_nearest() {
        let mut checked = 0;
        for seed in 0..60 {
            let (mut random, triangles) = scene(seed);
            let painted = back_to_front(triangles.clone(), 1e-9);
            for _ in 0..500 {
                let (x, y) = (1.5 * random.next(), 1.5 * random.next());
                let mut depths: Vec<(f64, [u8; 3])> = triangles
                    .iter()
                    .filter_map(|face| depth(&face.points, x, y).map(|depth| (depth, face.color)))
                    .collect();
                depths.sort_by(|a, b| b.0.total_cmp(&a.0));
                let last = painted.iter().rev().find(|face| contains(&face.points, x, y)).map(|face| face.color);
                match depths[..] {
                    [] => assert_eq!(last, None),
                    [(_, color)] => assert_eq!(last, Some(color)),
                    // Two faces at one depth may be painted either way.
                    [(first, color), (second, _), ..] if first - second > 1e-6 => assert_eq!(last, Some(color)),
                    _ => continue,
                }
                checked += usize::from(!depths.is_empty());
            }
        }
        assert!(checked > 3000, "{checked}");
    }

    /// Corners at 1e6 m have steps of 1e-10 m: a plane across a triangle of 0.1 m is known to some 1e-9 m, below the tolerance.
    #[test]
    fn far_from_the_origin_the_picture_is_the_one_at_the_origin() {
        for seed in 0..40 {
            let (mut random, triangles) = scene(seed);
            let places: Vec<[f64; 2]> = (0..100).map(|_| [1.5 * random.next(), 1.5 * random.next()]).collect();
            let seen = |far: f64| {
                let away = far * Vector3::new(1.0, -0.7, 0.4);
                let moved = |face: &Face, by: Vector3<f64>| {
                    let points = face.points.iter().map(|point| point + by).collect();
                    Face { points, ..*face }
                };
                let painted = back_to_front(triangles.iter().map(|face| moved(face, away)).collect(), 1e-6);
                let back: Vec<Face> = painted.iter().map(|face| moved(face, -away)).collect();
                let last = |[x, y]: &[f64; 2]| {
                    back.iter().rev().find(|face| contains(&face.points, *x, *y)).map(|face| face.color)
                };
                places.iter().map(last).collect::<Vec<_>>()
            };
            let here = seen(0.0);
            assert!(seen(1e3) == here && seen(1e6) == here, "seed {seed}");
        }
    }

    /// Also where rounding is as large as the faces, so that they cross their own planes.
    #[test]
    fn every_scene_is_ordered_in_the_end() {
        for seed in 0..8 {
            let (_, triangles) = scene(seed);
            for far in [1e12, 1e15, 1e17, 1e300] {
                let moved = triangles.iter().map(|face| {
                    let points = face.points.iter().map(|point| point.add_scalar(far)).collect();
                    Face { points, ..*face }
                });
                assert!(back_to_front(moved.collect(), 1e-9).len() >= triangles.len());
            }
        }
    }
}
