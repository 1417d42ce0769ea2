//! The faces of a drawing that the eye sees, with their colours, and the shadow on the floor.

use super::eye::Frame;
use super::order::Face;
use crate::record::drawing::{Drawing, Part};
use crate::spatial::Pose;
use nalgebra::{Point3, Vector3};

/// Light that comes from everywhere.
const AMBIENT: f64 = 0.52;
/// Towards the light, in axes of the eye: over the left shoulder.
const LIGHT: [f64; 3] = [-0.40, 0.62, 0.68];

/// Every triangle that faces the eye: of arrows, or of all else.
pub(super) fn faces(drawing: &Drawing, poses: &[Pose], frame: &Frame, of_arrows: bool) -> Vec<Face> {
    let mut faces = Vec::new();
    for part in drawing.parts.iter().filter(|part| part.is_arrow == of_arrows) {
        add(part, poses, frame, &mut faces);
    }
    faces
}

fn add(part: &Part, poses: &[Pose], frame: &Frame, faces: &mut Vec<Face>) {
    let placement = part.place(poses);
    let scale = Vector3::from(placement.scale);
    if !(scale.product() > 0.0) || !placement.pose.translation.vector.iter().all(|x| x.is_finite()) {
        return;
    }
    let light = Vector3::from(LIGHT).normalize();
    let [r, g, b, opacity] = part.color;
    let shape = part.shape(poses);
    let triangles = &shape.triangles;
    for corners in &triangles.corners {
        let at = |corner: u32| {
            let local = Vector3::from(triangles.positions[corner as usize]).cast::<f64>();
            frame.turned(&(placement.pose * Point3::from(local.component_mul(&scale))).coords)
        };
        let points = corners.map(at);
        let faces_eye = (points[1] - points[0]).cross(&(points[2] - points[0])).z;
        if faces_eye <= 0.0 && triangles.closed || faces_eye == 0.0 {
            continue;
        }
        let normal: Vector3<f64> = corners
            .iter()
            .map(|corner| Vector3::from(triangles.normals[*corner as usize]).cast::<f64>().component_div(&scale))
            .sum();
        let normal = frame.direction(&(placement.pose.rotation * normal)).try_normalize(0.0).unwrap_or_else(Vector3::z);
        // The inside of an open mesh is lit as its outside.
        let lit = if normal.z < 0.0 { -normal.dot(&light) } else { normal.dot(&light) };
        let brightness = AMBIENT + (1.05 - AMBIENT) * lit.max(0.0);
        let own = if shape.tints.is_empty() {
            [r, g, b]
        } else {
            let tint = |k: usize| corners.iter().map(|corner| shape.tints[*corner as usize][k]).sum::<f64>() / 3.0;
            std::array::from_fn(tint)
        };
        let color = own.map(|part| (255.0 * (part * brightness).clamp(0.0, 1.0)).round() as u8);
        faces.push(Face { points: points.into(), color, opacity });
    }
}

/// Outlines of the parts' shadows on the floor under a light from above, in axes of the eye; all turn the same way.
pub(super) fn shadows(drawing: &Drawing, poses: &[Pose], frame: &Frame) -> Vec<Vec<Vector3<f64>>> {
    let height = frame.ground.floor;
    let shadow = |part: &Part| {
        let placement = part.place(poses);
        let scale = Vector3::from(placement.scale);
        let shape = part.shape(poses);
        let on_floor = |at: &[f32; 3]| {
            let point = placement.pose * Point3::from(Vector3::from(*at).cast::<f64>().component_mul(&scale));
            [point.x, point.y]
        };
        let of = |positions: &[[f32; 3]]| {
            let outline = hull(positions.iter().map(on_floor).collect());
            outline.into_iter().map(|[x, y]| frame.turned(&Vector3::new(x, y, height))).collect::<Vec<_>>()
        };
        let positions = &shape.triangles.positions;
        // Beams and wires may be bent: the shadows of their stretches. Beams have outlines at both ends besides.
        let (rings, ends) = part.swept().map_or((shape.triangles.rings, 0), |(sweep, _)| (sweep.rings(), 2));
        let (per, stretches) = match rings {
            0 => (positions.len(), 1),
            rings => (positions.len() / (rings + ends), rings - 1),
        };
        let width = if stretches > 1 { 2 * per } else { positions.len() };
        (0..stretches).map(|k| of(&positions[k * per..k * per + width])).collect::<Vec<_>>()
    };
    let seen = drawing.parts.iter().filter(|part| !part.unbounded && part.place(poses).scale[2] > 0.0);
    seen.flat_map(shadow).filter(|outline| outline.len() > 2).collect()
}

/// The convex hull of points, counter-clockwise (Andrew, 1979).
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.retain(|point| point.iter().all(|x| x.is_finite()));
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let half = |points: &mut dyn Iterator<Item = &[f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && (b[0] - a[0]) * (point[1] - a[1]) <= (b[1] - a[1]) * (point[0] - a[0])
            {
                chain.pop();
            }
            chain.push(*point);
        }
        chain.pop();
        chain
    };
    let mut outline = half(&mut points.iter());
    outline.extend(half(&mut points.iter().rev()));
    outline
}

#[cfg(test)]
mod tests {
    use super::hull;

    #[test]
    fn a_hull_has_the_corners_and_nothing_within() {
        let square = vec![[0.0, 0.0], [1.0, 1.0], [0.5, 0.5], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0]];
        assert_eq!(hull(square), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    }
}
