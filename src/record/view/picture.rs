//! What does not change while the picture moves: solids, hinge axes, text, the looks of what moves.

use super::beams::Beams;
use super::crowd::Crowd;
use super::curves::Plot;
use super::entity::{CAPTION, STATICS, center_path, color, path, point, quaternion};
use super::forces::{self, Scales};
use super::mounts::Mounts;
use super::sdk::{
    Arrows3D, Asset3D, Boxes3D, Capsules3D, Color, Cylinders3D, Ellipsoids3D, EntityPath, FillMode, InstancePoses3D,
    LineStrips3D, MediaType, Points3D, Radius, SeriesLines, TextDocument, ViewCoordinates,
};
use super::sent::Sent;
use super::stream::Stream;
use crate::record::Scene;
use crate::record::contact::still;
use crate::record::drawing::bounds::Outline;
use crate::record::drawing::lines::coil_radii;
use crate::record::scene::CurvePicture;
use crate::record::solids::{Form, Solid, drop_of_beams, palette, solids};
use nalgebra::{Isometry3, Point3, Translation3, Vector3};
use std::collections::HashSet;

/// Everything still, ready to be sent.
pub(super) struct Picture {
    pub(super) scene: Scene,
    pub(super) plots: Vec<Vec<Plot>>,
    /// Of the bodies that are things of their own; empty for those of the crowd.
    pub(super) solids: Vec<Vec<Solid>>,
    pub(super) outlines: Vec<Outline>,
    pub(super) crowd: Option<Crowd>,
    pub(super) beams: Beams,
    pub(super) mounts: Mounts,
    pub(super) scales: Scales,
    /// Radius of each line's coils, or of its cylinder.
    pub(super) coils: Vec<Option<f64>>,
    /// Names of the bodies that are fixed to the ground.
    pub(super) still: HashSet<String>,
    /// The statics result.
    pub(super) statics: Option<String>,
    /// What is shown from when on.
    pub(super) captions: Vec<(f64, String)>,
}

impl Picture {
    /// Of a scene; the scales are those of what is known of its motion.
    pub(super) fn new(scene: &Scene, plots: Vec<Vec<Plot>>, scales: Scales) -> Self {
        let mut solids = solids(scene);
        let outlines: Vec<Outline> = solids.iter().map(|solids| Outline::new(solids)).collect();
        drop_of_beams(scene, &mut solids);
        let beams = Beams::new(scene, scales.size, scales.borne);
        let mounts = Mounts::new(scene, &outlines, scales.size);
        let crowd = Crowd::take(scene, &mut solids);
        let coils = coil_radii(scene, scales.size);
        let (scene, still) = (scene.clone(), still(scene));
        let (statics, captions) = (None, Vec::new());
        Self { scene, plots, solids, outlines, crowd, beams, mounts, scales, coils, still, statics, captions }
    }

    /// Whether the body is a thing of its own.
    pub(super) fn alone(&self, index: usize) -> bool {
        self.crowd.is_none()
            || !self.solids[index].is_empty()
            || self.scene.loads.iter().any(|load| load.body == index && load.turns)
            || self.scene.curves.iter().any(|curve| curve.body == Some(index))
    }

    /// How many poses a sample takes.
    pub(super) fn poses(&self) -> usize {
        match &self.crowd {
            Some(crowd) => crowd.members(),
            None => self.scene.bodies.len(),
        }
    }

    /// Sends it as static data.
    pub(super) fn send(&self, stream: &Stream) -> Sent {
        stream.log("/", &ViewCoordinates::RIGHT_HAND_Z_UP())?;
        for (body, solids) in self.scene.bodies.iter().zip(&self.solids) {
            for (index, solid) in solids.iter().enumerate() {
                let name = format!("solid_{index}");
                send_core(stream, path(&["world", &body.name, &name, "core"]), solid)?;
                send_solid(stream, path(&["world", &body.name, &name]), solid)?;
            }
        }
        match &self.crowd {
            Some(crowd) => crowd.send(stream)?,
            None => self.send_hinges(stream)?,
        }
        self.send_curves(stream)?;
        self.beams.send(stream)?;
        self.mounts.send(stream)?;
        forces::send(stream, &self.scene, &self.scales)?;
        let arrows = Arrows3D::update_fields().with_radii([Radius::new_ui_points(1.5)]);
        stream.log(forces::contacts_path(), &arrows)?;
        stream.log(forces::reactions_path(), &arrows.with_colors([forces::REACTION]))?;
        let center = Points3D::update_fields().with_radii([Radius::new_ui_points(4.0)]).with_colors([CENTER]);
        stream.log(center_path(), &center)?;
        self.send_text(stream)?;
        for plot in self.plots.iter().flatten() {
            for (index, curve) in plot.curves.iter().enumerate() {
                let looks = SeriesLines::new()
                    .with_names([curve.name.clone()])
                    .with_colors([color(palette(index))])
                    .with_widths([1.5]);
                stream.log(curve.path.clone(), &looks)?;
            }
        }
        Ok(())
    }

    /// The statics result, and captions at their times.
    fn send_text(&self, stream: &Stream) -> Sent {
        if let Some(text) = &self.statics {
            stream.log(STATICS, &TextDocument::from_markdown(text.as_str()))?;
        }
        for (time, text) in &self.captions {
            stream.log_at(CAPTION, *time, &TextDocument::from_markdown(text.as_str()))?;
        }
        Ok(())
    }

    /// The way of the centre of mass so far.
    pub(super) fn send_trace(stream: &Stream, points: Vec<[f32; 3]>) -> Sent {
        let line = LineStrips3D::new([points]).with_radii([Radius::new_ui_points(0.8)]).with_colors([CENTER]);
        stream.log(path(&["center of mass", "way"]), &line)
    }

    /// Hinge axes as short arrows, together for each parent, in whose axes they stay.
    fn send_hinges(&self, stream: &Stream) -> Sent {
        let length = 0.2 * self.body_size();
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
            stream.log(path(&["world", owner, "hinge axes"]), &arrows)?;
        }
        Ok(())
    }

    /// Curves that bodies are guided along, together for each body that has some, in whose axes they stay.
    fn send_curves(&self, stream: &Stream) -> Sent {
        for owner in (0..self.scene.bodies.len()).map(Some).chain([None]) {
            let of_owner = self.scene.curves.iter().filter(|curve| curve.body == owner);
            let strip = |curve: &CurvePicture| curve.points.iter().map(|at| point(&(*at).into())).collect::<Vec<_>>();
            let strips: Vec<Vec<[f32; 3]>> = of_owner.map(strip).collect();
            if strips.is_empty() {
                continue;
            }
            let lines = LineStrips3D::new(strips).with_radii([Radius::new_ui_points(1.2)]).with_colors([CURVE]);
            let owner = owner.map_or("ground", |owner| &self.scene.bodies[owner].name);
            stream.log(path(&["world", owner, "curves"]), &lines)?;
        }
        Ok(())
    }

    /// A typical length of a body (m).
    fn body_size(&self) -> f64 {
        let reaches: Vec<f64> = self.outlines.iter().map(Outline::reach).filter(|reach| *reach > 0.0).collect();
        if reaches.is_empty() { 1.0 } else { reaches.iter().sum::<f64>() / reaches.len() as f64 }
    }
}

/// Length over radius from which a rod is thin.
const THIN: f64 = 40.0;
const CENTER: Color = Color(super::sdk::Rgba32::from_rgb(176, 48, 128));
const CURVE: Color = Color(super::sdk::Rgba32::from_rgb(132, 138, 148));
const HINGE: Color = Color(super::sdk::Rgba32::from_rgb(214, 160, 48));

/// A rod many times longer than thick is also drawn as a line of fixed width: from afar nothing else is left of a wire.
fn send_core(stream: &Stream, path: EntityPath, solid: &Solid) -> Sent {
    match &solid.form {
        Form::Cylinder { radius, length } | Form::Capsule { radius, length } if *length > THIN * radius => {
            let end = |side: f64| (solid.pose * Point3::new(0.0, 0.0, 0.5 * side * length)).coords;
            let line = LineStrips3D::new([[point(&end(-1.0)), point(&end(1.0))]]);
            let looks = line.with_radii([Radius::new_ui_points(0.75)]).with_colors([color(solid.color)]);
            stream.log(path, &looks)
        }
        _ => Ok(()),
    }
}

fn send_solid(stream: &Stream, path: EntityPath, solid: &Solid) -> Sent {
    let colors = [color(solid.color)];
    let fill = FillMode::Solid;
    let at = |pose: &Isometry3<f64>| ([point(&pose.translation.vector)], [quaternion(&pose.rotation)]);
    let (center, turn) = at(&solid.pose);
    match &solid.form {
        Form::Box(edges) => {
            let half = edges.map(|edge| 0.5 * edge as f32);
            let boxes = Boxes3D::from_centers_and_half_sizes(center, [half]).with_quaternions(turn);
            stream.log(path, &boxes.with_fill_mode(fill).with_colors(colors))
        }
        Form::Ball(radius) => {
            let balls = Ellipsoids3D::from_centers_and_radii(center, [*radius as f32]);
            stream.log(path, &balls.with_fill_mode(fill).with_colors(colors))
        }
        Form::Cylinder { radius, length } => {
            let cylinders = Cylinders3D::from_lengths_and_radii([*length as f32], [*radius as f32]);
            let cylinders = cylinders.with_centers(center).with_quaternions(turn);
            stream.log(path, &cylinders.with_fill_mode(fill).with_colors(colors))
        }
        Form::Capsule { radius, length } => {
            // The viewer's capsules start at their origin.
            let (start, turn) = at(&(solid.pose * Translation3::new(0.0, 0.0, -0.5 * length)));
            let capsules = Capsules3D::from_lengths_and_radii([*length as f32], [*radius as f32]);
            let capsules = capsules.with_translations(start).with_quaternions(turn);
            stream.log(path, &capsules.with_fill_mode(fill).with_colors(colors))
        }
        Form::Mesh { contents, media_type, scale, .. } => {
            let mut asset = Asset3D::new(contents.clone()).with_media_type(MediaType::from(*media_type));
            if solid.own_color || *media_type == "model/stl" {
                asset = asset.with_albedo_factor(super::sdk::AlbedoFactor(color(solid.color).0));
            }
            let pose = InstancePoses3D::new().with_translations(center).with_quaternions(turn);
            stream.log(path.clone(), &pose.with_scales([scale.map(|x| x as f32)]))?;
            stream.log(path, &asset)
        }
    }
}
