//! `/scene`: the bodies' solids as a Foxglove scene update.

use super::frames::timestamp;
use crate::record::Scene;
use crate::record::solids::{Form, Solid, solids};
use foxglove::bytes::Bytes;
use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, Duration, ModelPrimitive, Pose, Quaternion, SceneEntity, SceneUpdate,
    SpherePrimitive, Vector3,
};
use nalgebra::{Isometry3, Translation3};

/// Every body as an entity in its own frame, staying for ever.
pub(super) fn scene_update(scene: &Scene) -> SceneUpdate {
    let entity = |(body, solids): (&crate::record::scene::BodyPicture, Vec<Solid>)| {
        let mut entity = SceneEntity {
            timestamp: Some(timestamp(0)),
            frame_id: body.name.clone(),
            id: body.name.clone(),
            lifetime: Some(Duration::new(0, 0)),
            frame_locked: true,
            ..Default::default()
        };
        solids.iter().for_each(|solid| add(&mut entity, solid));
        entity
    };
    SceneUpdate { deletions: Vec::new(), entities: scene.bodies.iter().zip(solids(scene)).map(entity).collect() }
}

fn add(entity: &mut SceneEntity, solid: &Solid) {
    let color = Some(color(solid.color));
    match &solid.form {
        Form::Box(edges) => {
            entity.cubes.push(CubePrimitive { pose: Some(pose(&solid.pose)), size: Some(vector(*edges)), color });
        }
        Form::Ball(radius) => entity.spheres.push(ball(&solid.pose, *radius, color)),
        Form::Cylinder { radius, length } => entity.cylinders.push(cylinder(&solid.pose, *radius, *length, color)),
        Form::Capsule { radius, length } => {
            entity.cylinders.push(cylinder(&solid.pose, *radius, *length, color));
            for end in [-0.5, 0.5] {
                let at = solid.pose * Translation3::new(0.0, 0.0, end * length);
                entity.spheres.push(ball(&at, *radius, color));
            }
        }
        Form::Mesh { contents, media_type, scale, .. } => entity.models.push(ModelPrimitive {
            pose: Some(pose(&solid.pose)),
            scale: Some(vector(*scale)),
            color,
            override_color: solid.own_color,
            media_type: (*media_type).into(),
            data: Bytes::copy_from_slice(contents),
            ..Default::default()
        }),
    }
}

fn ball(at: &Isometry3<f64>, radius: f64, color: Option<Color>) -> SpherePrimitive {
    SpherePrimitive { pose: Some(pose(at)), size: Some(vector([2.0 * radius; 3])), color }
}

fn cylinder(at: &Isometry3<f64>, radius: f64, length: f64, color: Option<Color>) -> CylinderPrimitive {
    let size = Some(vector([2.0 * radius, 2.0 * radius, length]));
    CylinderPrimitive { pose: Some(pose(at)), size, bottom_scale: 1.0, top_scale: 1.0, color }
}

fn pose(pose: &Isometry3<f64>) -> Pose {
    let turn = pose.rotation.quaternion();
    Pose {
        position: Some(vector(pose.translation.vector.into())),
        orientation: Some(Quaternion { x: turn.i, y: turn.j, z: turn.k, w: turn.w }),
    }
}

fn vector([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

fn color([r, g, b, a]: [f64; 4]) -> Color {
    Color { r, g, b, a }
}
