//! Samples of all structures in one set of columns.
//!
//! A body whose hinge opens at one time or other is told as a free one from beginning to end: its pose, its velocities. What
//! loops and drives push has its column at all times, and is 0 while they are open.

use super::of_structure;
use crate::dynamics::System;
use crate::hinge::HingeKind;
use crate::model::Model;
use crate::model::description::Description;
use crate::model::structure::Structure;
use crate::record::scene::{Channel, Scene};
use crate::record::{ContactPush, Event, Outcome, RecordError, Recorder, Sample};
use crate::simulate::samples::couplings::channels;
use crate::simulate::samples::scene::extent;
use crate::spatial::Pose;
use nalgebra::Vector3;
use std::ops::Range;
use std::sync::Arc;

/// Where the numbers of a body's hinge are, and those of the flexible element that ends at it.
#[derive(Debug, Clone)]
pub(super) struct Segment {
    pub(super) position: Range<usize>,
    pub(super) velocity: Range<usize>,
}

/// The numbers of every body, in the order of the bodies.
pub(super) fn segments(model: &Model) -> Vec<Segment> {
    let order = in_order(model);
    let mut segments = vec![Segment { position: 0..0, velocity: 0..0 }; model.bodies.len()];
    for (place, body) in order.iter().enumerate() {
        let next = order.get(place + 1).map(|next| &model.bodies[*next].hinge);
        let [position, velocity] = match next {
            Some(next) => [next.position, next.velocity],
            None => [model.position_count(), model.velocity_count()],
        };
        let hinge = &model.bodies[*body].hinge;
        segments[*body] = Segment { position: hinge.position..position, velocity: hinge.velocity..velocity };
    }
    segments
}

/// The bodies in the order of their coordinates.
fn in_order(model: &Model) -> Vec<usize> {
    let mut order: Vec<usize> = (0..model.bodies.len()).collect();
    order.sort_by_key(|body| {
        let hinge = &model.bodies[*body].hinge;
        (hinge.position, hinge.kind.counts().0)
    });
    order
}

/// The coordinates of a free hinge against the ground.
pub(super) fn free_position(pose: &Pose) -> [f64; 7] {
    let (at, turn) = (pose.translation.vector, pose.rotation);
    [at.x, at.y, at.z, turn.w, turn.i, turn.j, turn.k]
}

/// Velocities, or accelerations, of a free hinge from those of its body in inertial axes.
pub(super) fn free_rates(pose: &Pose, linear: &Vector3<f64>, angular: &Vector3<f64>) -> [f64; 6] {
    let angular = pose.rotation.inverse() * angular;
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

/// The model with everything that is ever there, for names of columns; the first one if there is none such.
fn full(whole: &Description, first: &Arc<Model>) -> Arc<Model> {
    let built = |structure: Structure| Model::build(&structure.describe(whole));
    let model = built(Structure::everything(whole)).or_else(|_| built(Structure::everything_but_welds(whole)));
    model.unwrap_or_else(|_| Arc::clone(first))
}

/// The still part of a recording.
pub(crate) fn scene(whole: &Description, first: &Arc<Model>) -> Scene {
    let full = full(whole, first);
    let freed = Structure::ever_freed(whole);
    let mut scene = of_structure(&full);
    let segments = segments(&full);
    let channels = |old: &[Channel], names: crate::hinge::Names, range: fn(&Segment) -> Range<usize>| -> Vec<Channel> {
        let of_body = |body: usize| match freed.contains(&body) {
            false => old[range(&segments[body])].to_vec(),
            true => {
                let channel = |(name, unit): &(&str, &str)| Channel {
                    body: full.bodies[body].name.clone(),
                    name: (*name).to_owned(),
                    unit: (*unit).to_owned(),
                };
                names.iter().map(channel).collect()
            }
        };
        in_order(&full).into_iter().flat_map(of_body).collect()
    };
    scene.positions = channels(&scene.positions, HingeKind::Free.positions(), |segment| segment.position.clone());
    scene.velocities = channels(&scene.velocities, HingeKind::Free.velocities(), |segment| segment.velocity.clone());
    scene.watched = true;
    // Of the structure that the run begins with.
    scene.extent = Some(extent(first));
    scene
}

/// The columns of a recording.
pub(super) struct Layout {
    order: Vec<usize>,
    /// Of every body, whether it is told as a free one.
    freed: Vec<bool>,
    couplings: Vec<Channel>,
}

impl Layout {
    pub(super) fn new(whole: &Description, first: &Arc<Model>) -> Self {
        let full = full(whole, first);
        let ever = Structure::ever_freed(whole);
        Self {
            order: in_order(&full),
            freed: (0..full.bodies.len()).map(|body| ever.contains(&body)).collect(),
            couplings: channels(&full),
        }
    }
}

/// Hands samples of one structure on in the columns of all.
pub(super) struct Relay<'a> {
    layout: &'a Layout,
    to: &'a mut dyn Recorder,
    model: Arc<Model>,
    system: System,
    segments: Vec<Segment>,
    /// For every column of couplings, the one of this structure.
    couplings: Vec<Option<usize>>,
    residual: Vec<f64>,
    columns: [Vec<f64>; 4],
}

impl<'a> Relay<'a> {
    pub(super) fn new(layout: &'a Layout, model: &Arc<Model>, to: &'a mut dyn Recorder) -> Self {
        let mine = channels(model);
        let place = |channel: &Channel| mine.iter().position(|one| one == channel);
        Self {
            layout,
            to,
            model: Arc::clone(model),
            system: System::new(model),
            segments: segments(model),
            couplings: layout.couplings.iter().map(place).collect(),
            residual: vec![0.0; model.velocity_count()],
            columns: std::array::from_fn(|_| Vec::new()),
        }
    }
}

impl Recorder for Relay<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), RecordError> {
        let Self { layout, model, system, segments, couplings, residual, columns, .. } = self;
        let [q, v, a, pushes] = columns;
        [&mut *q, &mut *v, &mut *a, &mut *pushes].into_iter().for_each(Vec::clear);
        let mut at = system.at(sample.time, sample.positions, sample.velocities);
        // Where forces cannot be evaluated the run has said so before it hands on the sample.
        let balanced = at.residual(sample.accelerations, residual).ok();
        for body in &layout.order {
            let segment = &segments[*body];
            let (true, Some(balanced)) = (layout.freed[*body], &balanced) else {
                q.extend_from_slice(&sample.positions[segment.position.clone()]);
                v.extend_from_slice(&sample.velocities[segment.velocity.clone()]);
                a.extend_from_slice(&sample.accelerations[segment.velocity.clone()]);
                continue;
            };
            let (body, pose) = (&model.bodies[*body], &sample.bodies[*body]);
            let link = &balanced.motion().links[body.link];
            let by = &balanced.link_accelerations()[body.link];
            let (arm, turning) = (link.turn * body.link_from_body.translation.vector, &link.angular_velocity);
            let velocity = link.velocity + turning.cross(&arm);
            let linear = by.linear + by.angular.cross(&arm) + turning.cross(&turning.cross(&arm));
            q.extend(free_position(pose));
            v.extend(free_rates(pose, &velocity, turning));
            a.extend(free_rates(pose, &linear, &by.angular));
        }
        pushes.extend(couplings.iter().map(|place| place.map_or(0.0, |place| sample.couplings[place])));
        let told = Sample { positions: q, velocities: v, accelerations: a, couplings: pushes, ..*sample };
        self.to.sample(&told)
    }

    fn event(&mut self, event: &Event) -> Result<(), RecordError> {
        self.to.event(event)
    }

    fn contacts(&mut self, time: f64, contacts: &[ContactPush]) -> Result<(), RecordError> {
        self.to.contacts(time, contacts)
    }

    fn pause(&mut self) -> Result<(), RecordError> {
        self.to.pause()
    }

    fn finish(&mut self, outcome: &Outcome) -> Result<(), RecordError> {
        self.to.finish(outcome)
    }
}
