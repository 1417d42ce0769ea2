//! Which pairs of features of two solids there are, and how each pair stands: points, segments and polytopes here, cylinders in `rim`.

use super::feature::{Feature, Meeting, Near, PlacedBoundary, crossing, on_edge, on_face};
use super::rim;
use nalgebra::Vector3;

/// All pairs of features of two solids that may be nearest to each other: faces first, then edges, then vertices.
pub fn pairs(a: &PlacedBoundary<'_>, b: &PlacedBoundary<'_>) -> Vec<[Feature; 2]> {
    if a.of.rim + b.of.rim > 0.0 {
        return rim::pairs(a, b);
    }
    let mut all = Vec::new();
    let cross =
        |one: &mut dyn Iterator<Item = Feature>, other: &dyn Fn() -> Vec<Feature>, all: &mut Vec<[Feature; 2]>| {
            for x in one {
                all.extend(other().into_iter().map(|y| [x, y]));
            }
        };
    cross(&mut a.face_list(), &|| b.vertex_list().collect(), &mut all);
    cross(&mut a.vertex_list(), &|| b.face_list().collect(), &mut all);
    cross(&mut a.edge_list(), &|| b.edge_list().collect(), &mut all);
    if a.of.radius + b.of.radius > 0.0 {
        cross(&mut a.edge_list(), &|| b.vertex_list().collect(), &mut all);
        cross(&mut a.vertex_list(), &|| b.edge_list().collect(), &mut all);
        cross(&mut a.vertex_list(), &|| b.vertex_list().collect(), &mut all);
    }
    all
}

/// How two features stand to each other; `None` if they have no normal, and for pairs that are found not to be `near` early.
pub fn meeting(a: &PlacedBoundary<'_>, b: &PlacedBoundary<'_>, features: [Feature; 2], near: &Near) -> Option<Meeting> {
    if a.of.rim + b.of.rim > 0.0 {
        return rim::meeting(a, b, features, near);
    }
    let none = Vector3::zeros();
    let radii = [a.of.radius, b.of.radius];
    let make = |normal: Vector3<f64>, cores: [Vector3<f64>; 2], edges: [Vector3<f64>; 2], inside: f64| {
        Meeting::new(features, normal, cores, edges, radii, inside)
    };
    match features {
        [Feature::Face(face), Feature::Vertex(vertex)] => {
            if a.above(face, &b.vertices[usize::from(vertex)]) - radii[0] - radii[1] >= near.gap {
                return None;
            }
            let (normal, foot, inside) = on_face(a, face, &b.vertices[usize::from(vertex)]);
            let inside = if a.of.plane.is_some() { inside } else { inside.min(b.before(&normal, vertex)) };
            Some(make(normal, [foot, b.vertices[usize::from(vertex)]], [none; 2], inside))
        }
        [Feature::Vertex(vertex), Feature::Face(face)] => {
            if b.above(face, &a.vertices[usize::from(vertex)]) - radii[0] - radii[1] >= near.gap {
                return None;
            }
            let (normal, foot, inside) = on_face(b, face, &a.vertices[usize::from(vertex)]);
            let inside = if b.of.plane.is_some() { inside } else { inside.min(a.before(&normal, vertex)) };
            Some(make(-normal, [a.vertices[usize::from(vertex)], foot], [none; 2], inside))
        }
        [Feature::Edge(one), Feature::Edge(other)] => crossing(a, b, [one, other], radii, near),
        [Feature::Edge(edge), Feature::Vertex(vertex)] => {
            let (point, own) = (b.vertices[usize::from(vertex)], a.of.edges[usize::from(edge)]);
            let (foot, u, along) = on_edge(a.ends(edge), &point);
            let normal = (point - foot).try_normalize(0.0)?;
            let inside =
                along.min(a.below(&normal, &foot, &own)).min(b.below(&-normal, &point, &[usize::from(vertex)]));
            Some(make(normal, [foot, point], [u, none], inside))
        }
        [Feature::Vertex(vertex), Feature::Edge(edge)] => {
            let (point, own) = (a.vertices[usize::from(vertex)], b.of.edges[usize::from(edge)]);
            let (foot, u, along) = on_edge(b.ends(edge), &point);
            let normal = (foot - point).try_normalize(0.0)?;
            let inside =
                along.min(b.below(&-normal, &foot, &own)).min(a.below(&normal, &point, &[usize::from(vertex)]));
            Some(make(normal, [point, foot], [none, u], inside))
        }
        [Feature::Vertex(one), Feature::Vertex(other)] => {
            let (from, to) = (a.vertices[usize::from(one)], b.vertices[usize::from(other)]);
            let normal = (to - from).try_normalize(0.0)?;
            let inside =
                a.below(&normal, &from, &[usize::from(one)]).min(b.below(&-normal, &to, &[usize::from(other)]));
            Some(make(normal, [from, to], [none; 2], inside))
        }
        [Feature::Face(_), _] | [_, Feature::Face(_)] => None,
    }
}
