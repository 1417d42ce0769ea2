//! How much room a motion takes of which only the start is known.

use crate::record::Scene;
use crate::record::drawing::bounds::{Bounds, Outline};
use crate::record::scene::BodyPicture;
use crate::spatial::Pose;
use nalgebra::{Point3, Vector3};

/// A guess at the room of a motion of which only the start is known: the start, and about every first hinge of a
/// tree a ball as wide as its tree can stretch, or a disc where the whole tree turns about parallel axes. Trees that
/// can leave (`free` and sliding hinges) get room to do so.
pub(super) fn expected(scene: &Scene, outlines: &[Outline], poses: &[Pose]) -> Bounds {
    let mut bounds = Bounds::default();
    bounds.include_bodies(outlines, poses);
    bounds.include_ends(scene.ends(), poses);
    scene.curves.iter().for_each(|curve| bounds.include_curve(curve, poses));
    let order = outward(scene);
    let reach = tree_reaches(scene, outlines, &order);
    let normals = plane_normals(scene, poses, &order);
    let mut still = vec![false; scene.bodies.len()];
    for &index in &order {
        let body = &scene.bodies[index];
        if !body.parent.is_none_or(|parent| still[parent]) {
            continue;
        }
        still[index] = body.hinge == "fixed";
        let ground = body.parent.map_or_else(Pose::identity, |parent| poses[parent]);
        let pivot = (ground * Point3::from(body.hinge_at)).coords;
        match (body.hinge.as_str(), normals[index]) {
            ("revolute", Some(normal)) => {
                let half = normal.map(|part| reach[index] * (1.0 - part * part).max(0.0).sqrt());
                bounds.include(&(pivot - half), 0.0);
                bounds.include(&(pivot + half), 0.0);
            }
            ("revolute" | "universal" | "spherical", _) => bounds.include(&pivot, reach[index]),
            ("fixed", _) => {}
            _ => bounds.include(&poses[index].translation.vector, 1.5 * reach[index]),
        }
    }
    bounds
}

/// The bodies, every parent before its children.
fn outward(scene: &Scene) -> Vec<usize> {
    let mut children = vec![Vec::new(); scene.bodies.len()];
    let mut order = Vec::new();
    for (index, body) in scene.bodies.iter().enumerate() {
        match body.parent {
            Some(parent) => children[parent].push(index),
            None => order.push(index),
        }
    }
    let mut next = 0;
    while next < order.len() {
        order.extend(&children[order[next]]);
        next += 1;
    }
    order
}

/// How far from its root marker each body's subtree can stretch.
fn tree_reaches(scene: &Scene, outlines: &[Outline], order: &[usize]) -> Vec<f64> {
    let mut reach: Vec<f64> = outlines.iter().map(Outline::reach).collect();
    for &index in order.iter().rev() {
        if let Some(parent) = scene.bodies[index].parent {
            let through = Vector3::from(scene.bodies[index].hinge_at).norm() + reach[index];
            reach[parent] = reach[parent].max(through);
        }
    }
    reach
}

/// For each body the direction, inertial axes, about which its whole subtree and its own hinge turn; `None` if
/// there is no such one. Parallel axes of turning hinges stay parallel.
fn plane_normals(scene: &Scene, poses: &[Pose], order: &[usize]) -> Vec<Option<Vector3<f64>>> {
    let own = |body: &BodyPicture| {
        let parent = body.parent.map_or_else(Pose::identity, |parent| poses[parent]);
        match (body.hinge.as_str(), body.hinge_axes.as_slice()) {
            ("revolute", [axis]) => (parent.rotation * Vector3::from(*axis)).try_normalize(0.0),
            _ => None,
        }
    };
    let mut normals: Vec<_> = scene.bodies.iter().map(own).collect();
    for &index in order.iter().rev() {
        let Some(parent) = scene.bodies[index].parent else { continue };
        let parallel = |a: Vector3<f64>, b: Vector3<f64>| a.cross(&b).norm() < 1e-3;
        let same = |a, b| if parallel(a, b) { Some(a) } else { None };
        if scene.bodies[index].hinge != "fixed" {
            normals[parent] = normals[parent].zip(normals[index]).and_then(|(a, b)| same(a, b));
        }
    }
    normals
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::solids::{Form, Solid};

    fn link(parent: Option<usize>, at: f64, axis: [f64; 3]) -> BodyPicture {
        BodyPicture {
            name: String::new(),
            parent,
            mass: 1.0,
            center: [0.0; 3],
            inertia: [0.0; 6],
            markers: Vec::new(),
            shapes: Vec::new(),
            hinge: "revolute".into(),
            hinge_axes: vec![axis],
            hinge_at: [0.0, 0.0, at],
            own_axes: Vec::new(),
        }
    }

    #[test]
    fn a_plane_pendulum_gets_a_disc_and_any_other_a_ball() {
        let ball = Solid {
            form: Form::Ball(0.5),
            pose: Pose::translation(0.0, 0.0, -1.0),
            color: [1.0; 4],
            own_color: false,
            unbounded: false,
        };
        let outlines = vec![Outline::new(&[ball]); 2];
        let poses = [Pose::translation(0.0, 0.0, 3.0), Pose::translation(0.0, 0.0, 2.0)];
        let room = |second: [f64; 3]| {
            let bodies = vec![link(None, 3.0, [0.0, 1.0, 0.0]), link(Some(0), -1.0, second)];
            expected(&Scene { bodies, ..Scene::default() }, &outlines, &poses)
        };
        // One metre to the second link, one to its ball, half a metre of ball.
        assert_eq!(room([0.0, 1.0, 0.0]).size(), Vector3::new(5.0, 1.0, 5.0));
        assert_eq!(room([1.0, 0.0, 0.0]).size(), Vector3::new(5.0, 5.0, 5.0));
    }
}
