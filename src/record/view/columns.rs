//! Samples on their way to the viewer, as columns of single-precision numbers.

use super::beams::Bent;
use super::crowd::Moves;
use super::curves::curves;
use super::entity::{TIMELINE, body_path, center_path, point, quaternion};
use super::forces::{
    changing_loads, contact_arrows, contacts_path, load_arrows, load_paths, load_points, points, reaction_arrows,
    reactions_path, spring_color, spring_path, strip, tension,
};
use super::mounts::Strained;
use super::picture::Picture;
use super::sdk::{Arrows3D, Color, LineStrips3D, Points3D, Scalars, TimeColumn, Transform3D};
use super::sent::Sent;
use super::stream::Stream;
use super::survey::center_of_mass;
use crate::record::{ContactPush, Sample};

/// The points of a line.
type Strip = Vec<[f32; 3]>;

/// A stretch of samples: their numbers, and the poses of those that are drawn.
#[derive(Debug, Clone, Default)]
pub(super) struct Columns {
    times: Vec<f64>,
    curves: Vec<Vec<f64>>,
    drawn: Vec<f64>,
    bodies: Vec<(Vec<[f32; 3]>, Vec<super::sdk::Quaternion>)>,
    crowd: Moves,
    beams: Vec<Bent>,
    mounts: Vec<Strained>,
    springs: Vec<(Vec<Strip>, Vec<Color>)>,
    loads: Vec<Vec<[f32; 3]>>,
    /// Arrows of the loads that change over time.
    changing: Vec<Vec<[f32; 3]>>,
    reactions: Vec<([f32; 3], [f32; 3])>,
    contacts: Contacts,
    center: Vec<[f32; 3]>,
}

/// Arrows of contacts, whose number changes from sample to sample.
#[derive(Debug, Clone, Default)]
struct Contacts {
    times: Vec<f64>,
    lengths: Vec<usize>,
    arrows: Vec<([f32; 3], [f32; 3], Color)>,
}

impl Contacts {
    fn send(self, stream: &Stream) -> Sent {
        if self.times.is_empty() {
            return Ok(());
        }
        let times = TimeColumn::new_duration_secs(TIMELINE, self.times);
        let (origins, vectors): (Vec<_>, Vec<_>) = self.arrows.iter().map(|(at, along, _)| (*at, *along)).unzip();
        let colors = self.arrows.iter().map(|(.., color)| *color);
        let arrows = Arrows3D::update_fields().with_origins(origins).with_vectors(vectors).with_colors(colors);
        stream.send_columns(contacts_path(), times, arrows.columns(self.lengths)?)
    }
}

impl Columns {
    /// None yet.
    pub(super) fn new(picture: &Picture) -> Self {
        Self {
            curves: vec![Vec::new(); curves(&picture.plots).count()],
            bodies: vec![Default::default(); picture.scene.bodies.len()],
            beams: vec![Bent::default(); picture.beams.count()],
            mounts: vec![Strained::default(); picture.mounts.count()],
            springs: vec![Default::default(); picture.scene.lines.len()],
            loads: vec![Vec::new(); load_paths(&picture.scene).count()],
            changing: vec![Vec::new(); changing_loads(&picture.scene).count()],
            ..Self::default()
        }
    }

    /// Number of samples.
    pub(super) fn len(&self) -> usize {
        self.times.len()
    }

    /// Adds the numbers of a sample whose arrays fit the scene.
    pub(super) fn push(&mut self, sample: &Sample, picture: &Picture) {
        self.times.push(sample.time);
        for (column, curve) in self.curves.iter_mut().zip(curves(&picture.plots)) {
            column.push(curve.value(sample, &picture.scene));
        }
    }

    /// Adds where everything is.
    pub(super) fn push_poses(&mut self, sample: &Sample, picture: &Picture) {
        let (scene, scales, poses) = (&picture.scene, &picture.scales, sample.bodies);
        self.drawn.push(sample.time);
        for (index, (at, turn)) in self.bodies.iter_mut().enumerate() {
            if !picture.alone(index) {
                continue;
            }
            at.push(point(&poses[index].translation.vector));
            turn.push(quaternion(&poses[index].rotation));
        }
        if let Some(crowd) = &picture.crowd {
            crowd.push(poses, &mut self.crowd);
        }
        picture.beams.push(sample, &mut self.beams);
        picture.mounts.push(poses, &mut self.mounts);
        for (((strips, colors), line), radius) in self.springs.iter_mut().zip(&scene.lines).zip(&picture.coils) {
            strips.push(strip(&points(line, poses), *radius, line.is_damper));
            if line.spring.is_some() {
                colors.push(spring_color(tension(line, poses), scales.tension));
            }
        }
        self.loads.iter_mut().zip(load_points(scene, poses)).for_each(|(column, at)| column.push(at));
        for (column, (load, _)) in self.changing.iter_mut().zip(changing_loads(scene)) {
            column.extend(load_arrows(scene, load, sample.time, scales));
        }
        if scales.reaction > 0.0 {
            self.reactions.extend(reaction_arrows(poses, sample.reactions, scales));
        }
        self.center.extend(center_of_mass(scene, poses).map(|at| point(&at)));
    }

    /// Adds what contacts push with at a time (s).
    pub(super) fn push_contacts(&mut self, time: f64, pushes: &[ContactPush], picture: &Picture) {
        let arrows = contact_arrows(pushes, &picture.still, &picture.scales);
        self.contacts.times.push(time);
        self.contacts.lengths.push(arrows.len());
        self.contacts.arrows.extend(arrows);
    }

    /// Sends everything.
    pub(super) fn send(self, stream: &Stream, picture: &Picture) -> Sent {
        let scene = &picture.scene;
        let times = TimeColumn::new_duration_secs(TIMELINE, self.times);
        for (values, curve) in self.curves.into_iter().zip(curves(&picture.plots)) {
            let scalars = Scalars::new(values).columns_of_unit_batches()?;
            stream.send_columns(curve.path.clone(), times.clone(), scalars)?;
        }
        let drawn = self.drawn.len();
        if drawn == 0 {
            return Ok(());
        }
        let times = TimeColumn::new_duration_secs(TIMELINE, self.drawn);
        for ((at, turn), body) in self.bodies.into_iter().zip(&scene.bodies).filter(|((at, _), _)| !at.is_empty()) {
            let poses = Transform3D::update_fields().with_many_translation(at).with_many_quaternion(turn);
            stream.send_columns(body_path(&body.name), times.clone(), poses.columns_of_unit_batches()?)?;
        }
        if let Some(crowd) = &picture.crowd {
            for (path, columns) in crowd.columns(self.crowd, drawn)? {
                stream.send_columns(path, times.clone(), columns)?;
            }
        }
        picture.beams.send_columns(stream, &times, self.beams, drawn)?;
        picture.mounts.send_columns(stream, &times, self.mounts, drawn)?;
        for ((strips, colors), line) in self.springs.into_iter().zip(&scene.lines) {
            let strips = LineStrips3D::update_fields().with_strips(strips);
            let strips = if colors.is_empty() { strips } else { strips.with_colors(colors) };
            stream.send_columns(spring_path(&line.name), times.clone(), strips.columns_of_unit_batches()?)?;
        }
        for (at, path) in self.loads.into_iter().zip(load_paths(scene)) {
            let arrows = Arrows3D::update_fields().with_origins(at).columns_of_unit_batches()?;
            stream.send_columns(path, times.clone(), arrows)?;
        }
        for (vectors, (_, path)) in
            self.changing.into_iter().zip(changing_loads(scene)).filter(|(all, _)| !all.is_empty())
        {
            let lengths = std::iter::repeat_n(vectors.len() / drawn, drawn);
            let arrows = Arrows3D::update_fields().with_vectors(vectors).columns(lengths)?;
            stream.send_columns(path, times.clone(), arrows)?;
        }
        self.contacts.send(stream)?;
        if !self.reactions.is_empty() {
            let lengths = std::iter::repeat_n(self.reactions.len() / drawn, drawn);
            let (origins, vectors): (Vec<_>, Vec<_>) = self.reactions.into_iter().unzip();
            let arrows = Arrows3D::update_fields().with_origins(origins).with_vectors(vectors);
            stream.send_columns(reactions_path(), times.clone(), arrows.columns(lengths)?)?;
        }
        if !self.center.is_empty() {
            let center = Points3D::update_fields().with_positions(self.center).columns_of_unit_batches()?;
            stream.send_columns(center_path(), times, center)?;
        }
        Ok(())
    }
}
