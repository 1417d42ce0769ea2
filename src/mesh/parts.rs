//! The convex parts of a mesh, for contact.

use super::{Mesh, NotSolid, Triangles, hull};
use nalgebra::Vector3;
use std::collections::HashMap;

/// A convex part: its corners (m) and triangles, counter-clockwise as seen from outside.
pub type Part = (Vec<Vector3<f64>>, Triangles);

/// Why a mesh cannot touch as it is.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotConvex {
    /// It has a border, or no volume.
    #[error(transparent)]
    Open(#[from] NotSolid),
    /// A part of it is not convex.
    #[error("it is not made of convex parts: it encloses {:.4} % of their convex hulls", 100.0 * filled)]
    Dented {
        /// Volume of the mesh over that of the hulls of its parts.
        filled: f64,
    },
    /// All corners lie in a plane.
    #[error("its corners lie in a plane")]
    Flat,
}

/// A mesh fills the hulls of its convex parts up to this part of their volume: single precision of files.
const FILLED: f64 = 1e-4;

impl Mesh {
    /// The convex hulls of its parts that do not hang together, once its axes are scaled; if `whole`, the hull of all of it, whatever it
    /// is.
    ///
    /// # Errors
    /// [`NotConvex`], unless `whole`; [`NotConvex::Flat`] in any case.
    pub fn convex_parts(&self, scale: Vector3<f64>, whole: bool) -> Result<Vec<Part>, NotConvex> {
        let corner = |index: u32| Vector3::from(self.vertices[index as usize]).cast::<f64>().component_mul(&scale);
        if whole {
            let all: Vec<Vector3<f64>> = self.triangles.iter().flatten().map(|index| corner(*index)).collect();
            return Ok(vec![hulled(&all).ok_or(NotConvex::Flat)?]);
        }
        let volume = self.solid(scale)?.volume;
        let mut parts = Vec::new();
        for part in self.islands() {
            let points: Vec<Vector3<f64>> = part.iter().flatten().map(|index| corner(*index)).collect();
            parts.push(hulled(&points).ok_or(NotConvex::Flat)?);
        }
        let filled = volume / parts.iter().map(enclosed).sum::<f64>();
        if (filled - 1.0).abs() > FILLED {
            return Err(NotConvex::Dented { filled });
        }
        Ok(parts)
    }

    /// Triangles that hang together by corners at one place.
    fn islands(&self) -> Vec<Vec<[u32; 3]>> {
        let mut places: HashMap<[u32; 3], usize> = HashMap::new();
        // Zero has two signs.
        let place = |index: u32| self.vertices[index as usize].map(|x| (x + 0.0).to_bits());
        let mut root: Vec<usize> = Vec::new();
        let mut of = |index: u32, root: &mut Vec<usize>| {
            *places.entry(place(index)).or_insert_with(|| {
                root.push(root.len());
                root.len() - 1
            })
        };
        let corners: Vec<[usize; 3]> =
            self.triangles.iter().map(|triangle| triangle.map(|index| of(index, &mut root))).collect();
        fn top(root: &mut [usize], mut at: usize) -> usize {
            while root[at] != at {
                root[at] = root[root[at]];
                at = root[at];
            }
            at
        }
        for [a, b, c] in &corners {
            let first = top(&mut root, *a);
            for other in [b, c] {
                let other = top(&mut root, *other);
                root[other] = first;
            }
        }
        let mut islands: HashMap<usize, Vec<[u32; 3]>> = HashMap::new();
        let mut order = Vec::new();
        for (triangle, corners) in self.triangles.iter().zip(&corners) {
            let island = top(&mut root, corners[0]);
            islands.entry(island).or_insert_with(|| {
                order.push(island);
                Vec::new()
            });
            islands.entry(island).and_modify(|own| own.push(*triangle));
        }
        order.iter().filter_map(|island| islands.remove(island)).collect()
    }
}

/// The hull of points with the corners that it has.
fn hulled(points: &[Vector3<f64>]) -> Option<Part> {
    let triangles = hull(points)?;
    let mut kept: HashMap<usize, usize> = HashMap::new();
    let mut corners = Vec::new();
    let triangles = triangles
        .into_iter()
        .map(|triangle| {
            triangle.map(|index| {
                *kept.entry(index).or_insert_with(|| {
                    corners.push(points[index]);
                    corners.len() - 1
                })
            })
        })
        .collect();
    Some((corners, triangles))
}

fn enclosed((corners, triangles): &Part) -> f64 {
    let from = corners[0];
    let part =
        |[a, b, c]: &[usize; 3]| (corners[*a] - from).dot(&(corners[*b] - from).cross(&(corners[*c] - from))) / 6.0;
    triangles.iter().map(part).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box from `low` to `high`, added to a mesh.
    fn add_box(mesh: &mut Mesh, low: [f32; 3], high: [f32; 3]) {
        let first = mesh.vertices.len() as u32;
        for i in 0..8_usize {
            mesh.vertices.push([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] }));
        }
        for [a, b, c, d] in
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] as [[u32; 4]; 6]
        {
            mesh.triangles.push([first + a, first + b, first + c]);
            mesh.triangles.push([first + a, first + c, first + d]);
        }
    }

    #[test]
    fn a_table_of_boxes_has_its_boxes_as_parts() {
        let mut mesh = Mesh::default();
        add_box(&mut mesh, [0.0, 0.0, 1.0], [1.0, 1.0, 1.1]);
        add_box(&mut mesh, [0.0, 0.0, 0.0], [0.1, 0.1, 0.9]);
        let parts = mesh.convex_parts(Vector3::new(1.0, 1.0, -2.0), false).unwrap();
        assert_eq!(parts.iter().map(|(corners, _)| corners.len()).collect::<Vec<_>>(), [8, 8]);
        assert!((parts.iter().map(enclosed).sum::<f64>() - 2.0 * (0.1 + 0.009)).abs() < 1e-7);
        assert_eq!(mesh.convex_parts(Vector3::repeat(1.0), true).unwrap().len(), 1);
    }

    #[test]
    fn a_dented_mesh_says_how_much_of_its_hull_it_fills() {
        // A box whose top has a pit: one face's four corners and a point below their middle.
        let mut mesh = Mesh::default();
        add_box(&mut mesh, [0.0; 3], [1.0; 3]);
        mesh.triangles.truncate(10);
        mesh.vertices.push([0.5, 0.5, 0.5]);
        for [a, b] in [[4, 5], [5, 7], [7, 6], [6, 4]] {
            mesh.triangles.push([a, b, 8]);
        }
        let Err(NotConvex::Dented { filled }) = mesh.convex_parts(Vector3::repeat(1.0), false) else {
            panic!("convex")
        };
        assert!((filled - (1.0 - 1.0 / 6.0)).abs() < 1e-6, "{filled}");
        mesh.triangles.pop();
        assert!(matches!(mesh.convex_parts(Vector3::repeat(1.0), false), Err(NotConvex::Open(_))));
    }
}
