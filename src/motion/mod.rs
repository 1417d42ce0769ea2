//! Where every link is and how fast it moves: the outward sweep that everything else starts from.

mod angles;
mod at_once;
pub mod variation;

use crate::element::modal::ModalMotion;
use crate::element::{Rod, RodMotion, Slice, Station};
use crate::model::{Halves, Joint, Link, ModalBody, Model};
use crate::pages::Pages;
pub use crate::spatial::link::LinkMotion;
use crate::spatial::quad::{Columns, Quad};
use crate::spatial::rotation::rotation_vector;
use crate::spatial::{Pose, Wrench};
use angles::Angles;
pub(crate) use angles::sine_and_cosine;
pub(crate) use at_once::at_once;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use std::ops::Range;

/// Positions and velocities of all links, inertial axes. `links[0]` is the ground.
#[derive(Debug, Clone)]
pub struct Motion {
    /// One per link of the model; written by [`Motion::update`].
    pub links: Pages<LinkMotion>,
    /// One per flexible element of the model.
    pub rods: Vec<RodMotion>,
    /// One per modal body of the model.
    pub modals: Vec<ModalMotion>,
    /// Whether nothing moves.
    pub still: bool,
    /// Of the last positions.
    angles: Angles,
}

impl Motion {
    /// Room for a model's links.
    pub fn new(model: &Model) -> Self {
        Self {
            links: Pages::filled(LinkMotion::GROUND, model.links.len()),
            rods: model.rods.iter().map(RodMotion::new).collect(),
            modals: model.modals.iter().map(|modal| ModalMotion::new(&modal.modal)).collect(),
            still: true,
            angles: Angles::new(model),
        }
    }

    /// Root → tips: positions and velocities from hinge coordinates `q` and velocities `v`.
    #[inline(always)]
    pub fn update(&mut self, model: &Model, q: &[f64], v: &[f64]) {
        self.angles.update(q);
        self.still = v.iter().all(|rate| *rate == 0.0);
        let state = State { model, q, v };
        let (all, rods, angles) = (&mut self.links[..], &mut self.rods[..], self.angles.all());
        let Some(Halves { hub, links: [one, other], turns, .. }) = &model.halves else {
            let elements = (rods, &mut self.modals[..]);
            return sweep(&state, 1..model.links.len(), 0, angles, &LinkMotion::GROUND, (all, elements));
        };
        // Halves have neither flexible elements nor modal bodies.
        sweep(&state, 1..hub + 1, 0, angles, &LinkMotion::GROUND, (all, (&mut [], &mut [])));
        let (low, rest) = all.split_at_mut(one.start);
        let (first, rest) = rest.split_at_mut(one.len());
        let (second, _) = rest.split_at_mut(other.len());
        let hub = &low[*hub];
        let half = |links: &Range<usize>, turns: usize, own: &mut [LinkMotion]| {
            sweep(&state, links.clone(), links.start, &angles[turns..], hub, (own, (&mut [], &mut [])));
        };
        at_once(|| half(one, turns[0], first), || half(other, turns[1], second));
        sweep(
            &state,
            other.end..model.links.len(),
            0,
            &angles[turns[2]..],
            &LinkMotion::GROUND,
            (all, (&mut [], &mut [])),
        );
    }

    /// The pose of a named body's root marker.
    pub fn body_pose(&self, body: &crate::model::Body) -> Pose {
        self.links[body.link].pose() * body.link_from_body
    }

    /// Kinetic energy of the links, armatures left out (J).
    pub fn kinetic_energy(&self, model: &Model) -> f64 {
        let of_link = |(link, motion): (&Link, &LinkMotion)| {
            let (v, w) = (motion.velocity, motion.angular_velocity);
            0.5 * link.mass * v.dot(&v)
                + link.mass * v.dot(&w.cross(&motion.center))
                + 0.5 * w.dot(&(motion.inertia * w))
        };
        let modals = model.modals.iter().zip(&self.modals);
        let of_modal = |(body, at): (&ModalBody, &ModalMotion)| at.kinetic_energy(&body.modal, &self.links[body.link]);
        model.links.iter().zip(&self.links).map(of_link).sum::<f64>()
            + self.kinetic_energy_of_rods(model)
            + modals.map(of_modal).sum::<f64>()
    }

    /// Kinetic energy of the slices inside flexible elements (J).
    fn kinetic_energy_of_rods(&self, model: &Model) -> f64 {
        let of_slice = |(slice, station): (&Slice, &Station)| {
            let (v, w) = (station.link.velocity, station.link.angular_velocity);
            0.5 * slice.mass * v.norm_squared() + 0.5 * w.dot(&(station.link.inertia * w))
        };
        let inner = |(rod, at): (&Rod, &RodMotion)| {
            let slices = rod.slices.iter().zip(&at.stations);
            slices.skip(1).take(rod.steps() - 1).map(of_slice).sum::<f64>()
        };
        model.rods.iter().zip(&self.rods).map(inner).sum()
    }
}

/// What a sweep is about.
struct State<'a> {
    model: &'a Model,
    q: &'a [f64],
    v: &'a [f64],
}

/// Some links that follow each other, from their first one on: `own` begins with link `base`, `angles` with the first turn
/// of `links`. Parents before `base` are the one link `outside`.
#[inline(always)]
fn sweep(
    state: &State<'_>,
    links: Range<usize>,
    base: usize,
    angles: &[[f64; 2]],
    outside: &LinkMotion,
    (own, (rods, modals)): (&mut [LinkMotion], (&mut [RodMotion], &mut [ModalMotion])),
) {
    let mut turn = 0;
    for (link, index) in state.model.links[links.clone()].iter().zip(links) {
        let (before, from_here) = own.split_at_mut(index - base);
        let parent = if link.parent >= base { &before[link.parent - base] } else { outside };
        let angle = match link.joint {
            Joint::Turn | Joint::Screw { .. } => {
                turn += 1;
                angles[turn - 1]
            }
            Joint::Flex { rod, .. } | Joint::Along { rod } => {
                flexible(state, link, rod, parent, (&mut rods[rod], &mut from_here[0]));
                continue;
            }
            Joint::Interface { modal, tip } => {
                interface(state, link, (modal, tip), parent, (&mut modals[modal], &mut from_here[0]));
                continue;
            }
            _ => [0.0, 1.0],
        };
        outboard(link, parent, state.q, state.v, angle, &mut from_here[0]);
        if let Joint::Modal { modal, count } = link.joint {
            let (q, v) = (&state.q[link.position..][..count], &state.v[link.velocity..][..count]);
            modals[modal].update(&state.model.modals[modal].modal, q, v, &from_here[0]);
        }
    }
}

/// From the frame of a modal body to one of its interfaces.
#[inline(never)]
fn interface(
    state: &State<'_>,
    link: &Link,
    (modal, tip): (usize, usize),
    frame: &LinkMotion,
    (at, own): (&mut ModalMotion, &mut LinkMotion),
) {
    let ModalMotion { q, v, tips, .. } = at;
    tips[tip].update(&state.model.modals[modal].modal.tips[tip], q, v, frame, own);
    if !link.is_massless() {
        own.center = own.turn * link.center;
        own.inertia = link.principal.turned(&Columns::of(&own.turn));
    }
}

/// Across a flexible element or along a curve.
#[inline(never)]
fn flexible(state: &State<'_>, link: &Link, rod: usize, parent: &LinkMotion, own: (&mut RodMotion, &mut LinkMotion)) {
    let (count, (at, own)) = (link.joint.counts().1, own);
    let (q, v) = (&state.q[link.position..link.position + count], &state.v[link.velocity..link.velocity + count]);
    at.update(&state.model.rods[rod], (&link.offset, &link.turn), parent, (q, v), own);
    if link.joint.is_scalar() {
        own.axis = at.tip[0].fixed_rows::<3>(0).into();
    }
    if !link.is_massless() {
        own.center = own.turn * link.center;
        own.inertia = link.principal.turned(&Columns::of(&own.turn));
    }
}

/// The relations of section 2 of the method: one hinge and the body outboard of it. `angle` is the sine and the cosine
/// of a turn or screw.
#[inline(always)]
fn outboard(link: &Link, parent: &LinkMotion, q: &[f64], v: &[f64], angle: [f64; 2], own: &mut LinkMotion) {
    let from = Columns::of(&parent.turn);
    let hinge = if link.straight { from } else { from.product(&link.turn) };
    let anchor = from.times(&link.offset);
    let w = Quad::of(&parent.angular_velocity);
    own.angular_bias = Vector3::zeros();
    // Relative to the parent it turns with `spin`,
    let turns = |own: &mut LinkMotion, spin: Quad| {
        own.relative = spin.vector();
        own.angular_velocity = (w + spin).vector();
        own.angular_bias = w.cross(spin).vector();
    };
    // and stays where it is,
    let stays = |own: &mut LinkMotion, arm: Quad| {
        let swing = w.cross(arm);
        own.velocity = (Quad::of(&parent.velocity) + swing).vector();
        own.bias = w.cross(swing).vector();
    };
    // or slides with `slip`.
    let slides = |own: &mut LinkMotion, arm: Quad, slip: Quad| {
        let swing = w.cross(arm);
        own.velocity = (Quad::of(&parent.velocity) + swing + slip).vector();
        own.bias = w.cross(swing + slip + slip).vector();
    };
    let (turn, arm) = match &link.joint {
        Joint::Modal { .. } => {
            own.angular_velocity = parent.angular_velocity;
            own.relative = Vector3::zeros();
            stays(own, anchor);
            (hinge, anchor)
        }
        // Of elements see `flexible`, of interfaces `interface`.
        Joint::None | Joint::Interface { .. } | Joint::Flex { .. } | Joint::Along { .. } => (hinge, anchor),
        Joint::Turn => {
            let z = hinge.0[2];
            own.axis = z.vector();
            turns(own, Quad::all(v[link.velocity]) * z);
            stays(own, anchor);
            (about_z(&hinge, angle), anchor)
        }
        Joint::Screw { pitch } => {
            let (z, pitch) = (hinge.0[2], Quad::all(*pitch));
            let spin = Quad::all(v[link.velocity]) * z;
            let arm = (pitch * Quad::all(q[link.position])).times_add(z, anchor);
            own.axis = z.vector();
            turns(own, spin);
            slides(own, arm, pitch * spin);
            (about_z(&hinge, angle), arm)
        }
        Joint::Slide { axis } => {
            let axis = hinge.times(axis);
            let (arm, slip) = (Quad::all(q[link.position]).times_add(axis, anchor), Quad::all(v[link.velocity]) * axis);
            own.axis = axis.vector();
            own.relative = slip.vector();
            own.angular_velocity = parent.angular_velocity;
            slides(own, arm, slip);
            (hinge, arm)
        }
        Joint::Ball { .. } => {
            let turn = hinge.product(&hinge_from_link(&q[link.position..link.position + 4]));
            turns(own, turn.times(&Vector3::new(v[link.velocity], v[link.velocity + 1], v[link.velocity + 2])));
            stays(own, anchor);
            (turn, anchor)
        }
    };
    own.turn = turn.matrix();
    own.position = (Quad::of(&parent.position) + arm).vector();
    own.arm = arm.vector();
    if !link.is_massless() {
        own.center = turn.times(&link.center).vector();
        own.inertia = link.principal.turned(&turn);
    }
}

/// The axes of a link after a turn about z by an angle of this sine and cosine: the others turn in their plane.
#[inline(always)]
fn about_z(hinge: &Columns, [sine, cosine]: [f64; 2]) -> Columns {
    let ([x, y, z], s, c) = (hinge.0, Quad::all(sine), Quad::all(cosine));
    Columns([s.times_add(y, c * x), s.times_from(x, c * y), z])
}

/// The rotation of four numbers w, x, y, z, whatever their norm: between two steps quaternions drift off one.
#[inline]
pub(crate) fn hinge_from_link(p: &[f64]) -> Matrix3<f64> {
    let (w, x, y, z) = (p[0], p[1], p[2], p[3]);
    let s = 2.0 / (w * w + x * x + y * y + z * z);
    Matrix3::new(
        1.0 - s * (y * y + z * z),
        s * (x * y - w * z),
        s * (x * z + w * y),
        s * (x * y + w * z),
        1.0 - s * (x * x + z * z),
        s * (y * z - w * x),
        s * (x * z - w * y),
        s * (y * z + w * x),
        1.0 - s * (x * x + y * y),
    )
}

/// Four position coordinates as a unit quaternion.
pub(crate) fn unit_quaternion(p: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(p[0], p[1], p[2], p[3]))
}

/// The displacement of one joint that leads from coordinates to others, one number per velocity: the differences of plain
/// coordinates, or a ball's rotation vector in the first link axes. Inverse of [`displace`].
pub fn relative(link: &Link, from: &[f64], to: &[f64], out: &mut [f64]) {
    let at = link.position;
    match link.joint {
        Joint::Ball { .. } => {
            let turn = unit_quaternion(&from[at..at + 4]).inverse() * unit_quaternion(&to[at..at + 4]);
            out.copy_from_slice(rotation_vector(&turn).as_slice());
        }
        _ => out.iter_mut().enumerate().for_each(|(i, out)| *out = to[at + i] - from[at + i]),
    }
}

/// The size of that displacement.
pub fn distance(link: &Link, from: &[f64], to: &[f64]) -> f64 {
    let at = link.position;
    match link.joint {
        Joint::Ball { .. } => {
            let mut turn = [0.0; 3];
            relative(link, from, to, &mut turn);
            Vector3::from(turn).norm()
        }
        _ => (at..at + link.joint.counts().0).map(|i| (to[i] - from[i]).powi(2)).sum::<f64>().sqrt(),
    }
}

/// What a wrench on a link at its root marker does in each velocity of its joint (N or N m), given to `put` with its place.
#[inline]
pub(crate) fn project(motion: &Motion, link: &Link, index: usize, wrench: &Wrench, mut put: impl FnMut(usize, f64)) {
    let at = &motion.links[index];
    match link.joint {
        Joint::Along { rod } => put(link.velocity, motion.rods[rod].project(0, wrench)),
        Joint::Flex { rod, count } => {
            (0..count).for_each(|i| put(link.velocity + i, motion.rods[rod].project(i, wrench)));
        }
        Joint::None | Joint::Modal { .. } => {}
        Joint::Interface { modal, tip } => {
            motion.modals[modal].tips[tip].rows(wrench).for_each(|(i, row)| put(link.velocity + i, row));
        }
        Joint::Turn => put(link.velocity, at.axis.dot(&wrench.moment)),
        Joint::Slide { .. } => put(link.velocity, at.axis.dot(&wrench.force)),
        Joint::Screw { pitch } => {
            put(link.velocity, at.axis.dot(&wrench.moment) + pitch * at.axis.dot(&wrench.force));
        }
        Joint::Ball { .. } => {
            let moment = at.turn.tr_mul(&wrench.moment);
            (0..3).for_each(|i| put(link.velocity + i, moment[i]));
        }
    }
}

/// `q ← q ⊞ step`: plain coordinates add, balls turn by the rotation vector in link axes.
pub fn displace(model: &Model, q: &mut [f64], step: &[f64]) {
    for link in &model.links {
        match link.joint {
            Joint::None | Joint::Interface { .. } => {}
            Joint::Turn | Joint::Slide { .. } | Joint::Screw { .. } | Joint::Along { .. } => {
                q[link.position] += step[link.velocity];
            }
            Joint::Flex { count, .. } | Joint::Modal { count, .. } => {
                let by = &step[link.velocity..link.velocity + count];
                q[link.position..link.position + count].iter_mut().zip(by).for_each(|(q, by)| *q += by);
            }
            Joint::Ball { .. } => {
                let at = &mut q[link.position..link.position + 4];
                let turn = Vector3::new(step[link.velocity], step[link.velocity + 1], step[link.velocity + 2]);
                if turn != Vector3::zeros() {
                    let new = unit_quaternion(at) * UnitQuaternion::from_scaled_axis(turn);
                    at.copy_from_slice(&[new.w, new.i, new.j, new.k]);
                }
            }
        }
    }
}
