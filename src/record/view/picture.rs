//! What does not change while the picture moves: solids, hinge axes, the looks of springs and curves.

use super::bounds::Outline;
use super::columns::quaternion;
use super::curves::Plot;
use crate::record::Scene;
use crate::record::solids::{Form, Solid, palette};
use nalgebra::{Isometry3, Translation3, Vector3};
use rerun::{
    Arrows3D, Asset3D, Boxes3D, Capsules3D, Color, Cylinders3D, Ellipsoids3D, EntityPath, EntityPathPart, FillMode,
    InstancePoses3D, LineStrips3D, MediaType, Radius, RecordingStream, RecordingStreamResult, SeriesLines,
    ViewCoordinates,
};

/// Everything still, ready to be sent.
pub(super) struct Picture {
    pub(super) scene: Scene,
    pub(super) plots: Vec<Vec<Plot>>,
    pub(super) solids: Vec<Vec<Solid>>,
    pub(super) outlines: Vec<Outline>,
}

impl Picture {
    /// Sends it as static data.
    pub(super) fn send(&self, stream: &RecordingStream) -> RecordingStreamResult<()> {
        stream.log_static("/", &ViewCoordinates::RIGHT_HAND_Z_UP())?;
        for (body, solids) in self.scene.bodies.iter().zip(&self.solids) {
            for (index, solid) in solids.iter().enumerate() {
                let path = path(&["world", &body.name, &format!("solid_{index}")]);
                send_solid(stream, path, solid)?;
            }
        }
        self.send_hinges(stream)?;
        for line in &self.scene.lines {
            let looks = LineStrips3D::update_fields().with_colors([SPRING]).with_radii([Radius::new_ui_points(1.5)]);
            stream.log_static(spring_path(&line.name), &looks)?;
        }
        for plot in self.plots.iter().flatten() {
            for (index, curve) in plot.curves.iter().enumerate() {
                let looks = SeriesLines::new()
                    .with_names([curve.name.clone()])
                    .with_colors([color(palette(index))])
                    .with_widths([1.5]);
                stream.log_static(curve.path.clone(), &looks)?;
            }
        }
        Ok(())
    }

    /// Hinge axes as short arrows, together for each parent, in whose axes they stay.
    fn send_hinges(&self, stream: &RecordingStream) -> RecordingStreamResult<()> {
        let length = 0.25 * self.body_size();
        let parents = (0..self.scene.bodies.len()).map(Some).chain([None]);
        for parent in parents {
            let mut origins = Vec::new();
            let mut vectors = Vec::new();
            for body in self.scene.bodies.iter().filter(|body| body.parent == parent) {
                for axis in &body.hinge_axes {
                    let Some(axis) = Vector3::from(*axis).try_normalize(0.0) else { continue };
                    let start = Vector3::from(body.hinge_at) - 0.5 * length * axis;
                    origins.push(point(&start));
                    vectors.push(point(&(length * axis)));
                }
            }
            if vectors.is_empty() {
                continue;
            }
            let arrows = Arrows3D::from_vectors(vectors)
                .with_origins(origins)
                .with_radii([(0.05 * length) as f32])
                .with_colors([HINGE]);
            let owner = parent.map_or("ground", |parent| &self.scene.bodies[parent].name);
            stream.log_static(path(&["world", owner, "hinge axes"]), &arrows)?;
        }
        Ok(())
    }

    /// A typical length of a body (m).
    fn body_size(&self) -> f64 {
        let reaches: Vec<f64> = self.outlines.iter().map(Outline::reach).filter(|reach| *reach > 0.0).collect();
        if reaches.is_empty() { 1.0 } else { reaches.iter().sum::<f64>() / reaches.len() as f64 }
    }
}

const SPRING: Color = Color(rerun::Rgba32::from_rgb(196, 190, 160));
const HINGE: Color = Color(rerun::Rgba32::from_rgb(236, 214, 140));

fn send_solid(stream: &RecordingStream, path: EntityPath, solid: &Solid) -> RecordingStreamResult<()> {
    let colors = [color(solid.color)];
    let fill = FillMode::Solid;
    let at = |pose: &Isometry3<f64>| ([point(&pose.translation.vector)], [quaternion(&pose.rotation)]);
    let (center, turn) = at(&solid.pose);
    match &solid.form {
        Form::Box(edges) => {
            let half = edges.map(|edge| 0.5 * edge as f32);
            let boxes = Boxes3D::from_centers_and_half_sizes(center, [half]).with_quaternions(turn);
            stream.log_static(path, &boxes.with_fill_mode(fill).with_colors(colors))
        }
        Form::Ball(radius) => {
            let balls = Ellipsoids3D::from_centers_and_radii(center, [*radius as f32]);
            stream.log_static(path, &balls.with_fill_mode(fill).with_colors(colors))
        }
        Form::Cylinder { radius, length } => {
            let cylinders = Cylinders3D::from_lengths_and_radii([*length as f32], [*radius as f32]);
            let cylinders = cylinders.with_centers(center).with_quaternions(turn);
            stream.log_static(path, &cylinders.with_fill_mode(fill).with_colors(colors))
        }
        Form::Capsule { radius, length } => {
            // The viewer's capsules start at their origin.
            let (start, turn) = at(&(solid.pose * Translation3::new(0.0, 0.0, -0.5 * length)));
            let capsules = Capsules3D::from_lengths_and_radii([*length as f32], [*radius as f32]);
            let capsules = capsules.with_translations(start).with_quaternions(turn);
            stream.log_static(path, &capsules.with_fill_mode(fill).with_colors(colors))
        }
        Form::Mesh { contents, media_type, scale } => {
            let mut asset = Asset3D::new(contents.clone()).with_media_type(MediaType::from(*media_type));
            if solid.own_color || *media_type == "model/stl" {
                asset = asset.with_albedo_factor(rerun::AlbedoFactor(color(solid.color).0));
            }
            let pose = InstancePoses3D::new().with_translations(center).with_quaternions(turn);
            stream.log_static(path.clone(), &pose.with_scales([scale.map(|x| x as f32)]))?;
            stream.log_static(path, &asset)
        }
    }
}

/// A path of names that may hold any character.
pub(super) fn path(parts: &[&str]) -> EntityPath {
    EntityPath::from(parts.iter().map(|part| EntityPathPart::new(*part)).collect::<Vec<_>>())
}

pub(super) fn body_path(name: &str) -> EntityPath {
    path(&["world", name])
}

pub(super) fn spring_path(name: &str) -> EntityPath {
    path(&["springs", name])
}

fn point(vector: &Vector3<f64>) -> [f32; 3] {
    vector.cast::<f32>().into()
}

fn color(rgba: [f64; 4]) -> Color {
    let [r, g, b, a] = rgba.map(|part| (255.0 * part.clamp(0.0, 1.0)).round() as u8);
    Color::from_unmultiplied_rgba(r, g, b, a)
}
