//! The convex hull of points, by the quickhull of Barber, Dobkin and Huhdanpaa (ACM Trans. Math. Softw. 22, 1996).
//!
//! A tetrahedron of points grows: the point farthest outside of a face becomes a corner, all faces that it sees go, and the
//! edge around them (the horizon) is joined with it. Faces in whose plane the point lies go too: a face between it and the
//! horizon then never is a sliver.

use nalgebra::Vector3;
use std::collections::HashMap;

/// Distances to a plane below this part of the extent are round-off of a few products.
const FLAT: f64 = 1e-13;

/// Triangles by the places of their corners, counter-clockwise as seen from outside.
pub type Triangles = Vec<[usize; 3]>;

struct Face {
    corners: [usize; 3],
    normal: Vector3<f64>,
    /// Points in front of it that no other face has.
    outside: Vec<usize>,
    /// No longer part of the hull.
    gone: bool,
}

struct Growing<'p> {
    points: &'p [Vector3<f64>],
    faces: Vec<Face>,
    /// The face that passes an edge in this direction.
    of_edge: HashMap<(usize, usize), usize>,
    flat: f64,
}

/// The convex hull of points, in their units: triangles whose corners are places in the list. `None` if all points lie in
/// a plane.
pub fn hull(points: &[Vector3<f64>]) -> Option<Triangles> {
    let first = *points.first()?;
    let extent = points.iter().map(|at| (at - first).amax()).fold(0.0, f64::max);
    let mut hull = Growing { points, faces: Vec::new(), of_edge: HashMap::new(), flat: FLAT * extent };
    hull.begin()?;
    let mut next = 0;
    while next < hull.faces.len() {
        match hull.farthest(next) {
            Some(point) => hull.grow(next, point),
            None => next += 1,
        }
    }
    Some(hull.faces.into_iter().filter(|face| !face.gone).map(|face| face.corners).collect())
}

impl Growing<'_> {
    /// A tetrahedron of points that are far apart, and every other point in front of a face of it.
    fn begin(&mut self) -> Option<()> {
        let points = self.points;
        let most = |size: &dyn Fn(&Vector3<f64>) -> f64| {
            (0..points.len()).max_by(|a, b| size(&points[*a]).total_cmp(&size(&points[*b])))
        };
        let a = most(&|at| -at.x)?;
        let b = most(&|at| (at - points[a]).norm_squared())?;
        let along = (points[b] - points[a]).try_normalize(self.flat)?;
        let c = most(&|at| (at - points[a]).cross(&along).norm_squared())?;
        let normal = along.cross(&(points[c] - points[a])).try_normalize(self.flat)?;
        let d = most(&|at| (at - points[a]).dot(&normal).abs())?;
        let height = (points[d] - points[a]).dot(&normal);
        if !(height.abs() > self.flat) {
            return None;
        }
        let (b, c) = if height > 0.0 { (c, b) } else { (b, c) };
        for corners in [[a, b, c], [a, d, b], [b, d, c], [c, d, a]] {
            self.add(corners);
        }
        let all = (0..points.len()).collect();
        self.share(all, 0);
        Some(())
    }

    fn add(&mut self, corners: [usize; 3]) {
        let [a, b, c] = corners.map(|corner| self.points[corner]);
        let normal = (b - a).cross(&(c - a)).normalize();
        for at in 0..3 {
            self.of_edge.insert((corners[at], corners[(at + 1) % 3]), self.faces.len());
        }
        self.faces.push(Face { corners, normal, outside: Vec::new(), gone: false });
    }

    fn height(&self, face: usize, point: usize) -> f64 {
        let face = &self.faces[face];
        (self.points[point] - self.points[face.corners[0]]).dot(&face.normal)
    }

    /// Gives every point to the first face, from `first` on, that it is in front of.
    fn share(&mut self, points: Vec<usize>, first: usize) {
        for point in points {
            if let Some(face) = (first..self.faces.len()).find(|face| self.height(*face, point) > self.flat) {
                self.faces[face].outside.push(point);
            }
        }
    }

    /// The point farthest in front of a face.
    fn farthest(&self, face: usize) -> Option<usize> {
        let list = &self.faces[face].outside;
        list.iter().copied().max_by(|a, b| self.height(face, *a).total_cmp(&self.height(face, *b)))
    }

    /// Makes a point that a face sees a corner.
    fn grow(&mut self, face: usize, point: usize) {
        let (mut seen, mut horizon, mut left) = (vec![face], Vec::new(), Vec::new());
        self.faces[face].gone = true;
        while let Some(face) = seen.pop() {
            left.append(&mut self.faces[face].outside);
            let [a, b, c] = self.faces[face].corners;
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let beyond = self.of_edge[&(to, from)];
                if self.faces[beyond].gone {
                    continue;
                }
                if self.height(beyond, point) > -self.flat {
                    self.faces[beyond].gone = true;
                    seen.push(beyond);
                } else {
                    horizon.push((from, to));
                }
            }
        }
        let first = self.faces.len();
        for (from, to) in horizon {
            self.add([from, to, point]);
        }
        left.retain(|other| *other != point);
        self.share(left, first);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(points: &[Vector3<f64>], triangles: &Triangles) -> f64 {
        triangles.iter().map(|corners| corners.map(|at| points[at])).map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum()
    }

    /// Points of a grid: faces, edges and corners full of points that lie in one plane.
    #[test]
    fn the_hull_of_a_grid_is_a_box() {
        let axis = |count: usize| (0..count).map(move |at| at as f64 * 0.1 - 0.7);
        let points: Vec<Vector3<f64>> = axis(5)
            .flat_map(|x| axis(4).flat_map(move |y| axis(7).map(move |z| Vector3::new(x, 2.0 * y, 3.0 * z))))
            .collect();
        let triangles = hull(&points).expect("a hull");
        // Round-off of a sum of a few dozen products.
        assert!((volume(&points, &triangles) - 0.4 * 0.6 * 1.8).abs() < 1e-14);
    }

    /// No point is in front of a face, every edge is passed once each way (Euler: F = 2 V − 4).
    #[test]
    fn nothing_is_outside_of_the_hull_of_a_ball_of_points() {
        let spiral = |at: usize| {
            let (z, angle) = (1.0 - 2.0 * (at as f64 + 0.5) / 500.0, at as f64 * 2.399_963);
            let radius = (1.0 - z * z).sqrt();
            Vector3::new(radius * angle.cos(), radius * angle.sin(), z)
        };
        let mut points: Vec<Vector3<f64>> = (0..500).map(spiral).collect();
        points.extend((0..500).map(|at| spiral(at) * 0.9));
        let triangles = hull(&points).expect("a hull");
        assert_eq!(triangles.len(), 2 * 500 - 4);
        for corners in &triangles {
            let [a, b, c] = corners.map(|at| points[at]);
            let normal = (b - a).cross(&(c - a)).normalize();
            assert!(points.iter().all(|at| (at - a).dot(&normal) < 1e-12));
        }
    }

    #[test]
    fn points_in_a_plane_have_no_hull() {
        let points: Vec<Vector3<f64>> =
            (0..20).map(|at| Vector3::new(at as f64, (at * at) as f64, at as f64 * 2.0 - 1.0)).collect();
        assert!(hull(&points).is_none() && hull(&[]).is_none());
    }
}
