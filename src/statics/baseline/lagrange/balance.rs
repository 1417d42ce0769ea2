//! Forces on every link in maximal coordinates, and how they vary with the poses.

use super::constraints::{Constraint, axial};
use super::entries::Entries;
use super::gradient::{Gradient, Part};
use super::poses::Poses;
use crate::dynamics::applied;
use crate::force::Act;
use crate::model::motor::Push;
use crate::model::{Joint, Link, Model};
use crate::motion::variation::LinkVariation;
use crate::spatial::Wrench;
use crate::transfer::element::Reduced;
use nalgebra::{Matrix3, Vector3};

/// What acts on every link without its hinge: weight and force elements, at the root markers.
pub(super) fn on_links(model: &Model, poses: &Poses) -> Vec<Wrench> {
    let mut wrenches = vec![Wrench::ZERO; model.links.len()];
    applied::apply(&applied::Laws::new(model), &poses.motion, &mut wrenches);
    for (index, link) in model.links.iter().enumerate().skip(1) {
        wrenches[index] += Wrench::at_arm(link.mass * model.gravity, poses.motion.links[index].center);
    }
    wrenches
}

/// Springs and motors in the hinges, and what drives and gears `push` there: what each hinge's own force does to its
/// link and, opposite, to the parent.
pub(super) fn hinges(model: &Model, poses: &Poses, push: &[f64]) -> Vec<[Wrench; 2]> {
    let rest = vec![0.0; model.velocity_count()];
    let mut tau = rest.clone();
    applied::hinge::apply(model, &poses.q, &rest, &mut tau);
    applied::motor::apply(model, &motors(model, poses), &mut tau);
    tau.iter_mut().zip(push).for_each(|(tau, push)| *tau += push);
    let of_link = |(index, link): (usize, &Link)| match link.joint {
        Joint::None | Joint::Modal { .. } | Joint::Interface { .. } => [Wrench::ZERO; 2],
        Joint::Ball { .. } => {
            let moment = poses.motion.links[index].turn * Vector3::from_column_slice(&tau[link.velocity..][..3]);
            [moment, -moment].map(|moment| Wrench { force: Vector3::zeros(), moment })
        }
        _ => {
            let gradient = coordinate(poses, index, link);
            [gradient.on_link(tau[link.velocity]), gradient.on_parent(tau[link.velocity])]
        }
    };
    model.links.iter().enumerate().map(of_link).collect()
}

/// What motors and curves push with at rest.
fn motors(model: &Model, poses: &Poses) -> Vec<Push> {
    let (rest, mut pushes) = (vec![0.0; model.velocity_count()], vec![Push::default(); model.pushed().count()]);
    applied::motor::pushes(model, &applied::Laws::new(model), 0.0, &poses.q, &rest, &mut pushes);
    pushes
}

/// What the constraints pass to each link and to its parent.
pub(super) fn reactions(
    constraints: &[Constraint],
    poses: &Poses,
    multipliers: &[f64],
    links: usize,
) -> Vec<[Wrench; 2]> {
    let mut out = vec![[Wrench::ZERO; 2]; links];
    for constraint in constraints {
        for (i, (_, gradient)) in constraint.at(&poses.motion).iter().take(constraint.count()).enumerate() {
            let size = multipliers[constraint.row + i];
            out[constraint.link][0] += gradient.on_link(size);
            out[constraint.link][1] += gradient.on_parent(size);
        }
    }
    out
}

/// Adds what the constraints push to every link.
pub(super) fn add_reactions(constraints: &[Constraint], poses: &Poses, multipliers: &[f64], sum: &mut [Wrench]) {
    for constraint in constraints {
        for (i, (_, gradient)) in constraint.at(&poses.motion).iter().take(constraint.count()).enumerate() {
            let size = multipliers[constraint.row + i];
            sum[constraint.link] += gradient.on_link(size);
            sum[constraint.parent] += gradient.on_parent(size);
        }
    }
}

/// The gradient of the one coordinate of a turn, slide or screw; of a screw it is that of the angle, its distance goes with
/// the thread.
pub(super) fn coordinate(poses: &Poses, index: usize, link: &Link) -> Gradient {
    let (own, parent) = (&poses.motion.links[index], &poses.motion.links[link.parent]);
    let zero = Vector3::zeros();
    match link.joint {
        Joint::Turn | Joint::Screw { .. } => {
            let n = own.turn.column(2).into_owned();
            Gradient { force: zero, on_link: n, on_parent: -n }
        }
        Joint::Slide { axis } => {
            let n = parent.turn * (link.turn * axis);
            Gradient { force: n, on_link: zero, on_parent: n.cross(&(own.position - parent.position)) }
        }
        Joint::None
        | Joint::Ball { .. }
        | Joint::Flex { .. }
        | Joint::Along { .. }
        | Joint::Modal { .. }
        | Joint::Interface { .. } => Gradient { force: zero, on_link: zero, on_parent: zero },
    }
}

/// `∂(forces)/∂(poses) − σ M` with fixed multipliers; `pushed` are the coordinates of drives and gears.
pub(super) fn vary(model: &Model, poses: &Poses, (push, pushed): (&[f64], &[bool]), shift: f64, entries: &mut Entries) {
    weights(model, poses, shift, entries);
    elements(model, poses, entries);
    let own = hinges(model, poses, push);
    for index in 1..model.links.len() {
        hinge(model, poses, index, (&own[index][0], pushed), shift, entries);
    }
}

fn weights(model: &Model, poses: &Poses, shift: f64, entries: &mut Entries) {
    for (index, link) in model.links.iter().enumerate().skip(1) {
        let at = &poses.motion.links[index];
        let mut mass = Reduced::default();
        mass.add_body(link.mass, &at.center, &link.inertia.turned(&at.turn));
        let weight = link.mass * model.gravity.cross_matrix() * at.center.cross_matrix();
        entries.add((index, Part::Place), (index, Part::Place), &(-shift * mass.ff.matrix()));
        entries.add((index, Part::Place), (index, Part::Turn), &(-shift * mass.fm));
        entries.add((index, Part::Turn), (index, Part::Place), &(-shift * mass.fm.transpose()));
        entries.add((index, Part::Turn), (index, Part::Turn), &(weight - shift * mass.mm.matrix()));
    }
}

/// Every element by unit variations of the links it acts on.
fn elements(model: &Model, poses: &Poses, entries: &mut Entries) {
    let mut by = vec![LinkVariation::default(); model.links.len()];
    for force in model.forces.iter() {
        let ends = force.law.ends();
        for (at, end) in ends.iter().enumerate() {
            if end.link == 0 || ends[..at].iter().any(|before| before.link == end.link) {
                continue;
            }
            for (part, axis) in [Part::Place, Part::Turn].into_iter().flat_map(|part| (0..3).map(move |i| (part, i))) {
                let unit = Vector3::ith(axis, 1.0);
                match part {
                    Part::Place => by[end.link].position = unit,
                    Part::Turn => by[end.link].turn = unit,
                }
                force.law.vary(&poses.motion.links, &by, &mut |row, wrench| {
                    entries.add_wrench(ends[row].link, (end.link, part), axis, &wrench);
                });
                by[end.link] = LinkVariation::default();
            }
        }
    }
}

/// The hinge's own force `acting` turns with its axes and changes with its coordinates.
fn hinge(
    model: &Model,
    poses: &Poses,
    index: usize,
    (acting, pushed): (&Wrench, &[bool]),
    shift: f64,
    entries: &mut Entries,
) {
    let link = &model.links[index];
    let parent = link.parent;
    let of = |i: usize| &model.coordinates[link.velocity + i];
    let by_motors: f64 = (model.pushed().zip(motors(model, poses)))
        .filter(|(coordinate, _)| coordinate.link == index)
        .map(|(_, push)| push.by_position)
        .sum();
    let motor = model.pushed().any(|coordinate| coordinate.link == index);
    let active = |i: usize| {
        let own = of(i).stiffness != 0.0 || of(i).force != 0.0 || of(i).armature != 0.0;
        own || motor || pushed[link.velocity + i]
    };
    match link.joint {
        Joint::None | Joint::Flex { .. } | Joint::Along { .. } | Joint::Modal { .. } | Joint::Interface { .. } => {}
        Joint::Turn | Joint::Slide { .. } | Joint::Screw { .. } if !active(0) => {}
        Joint::Turn | Joint::Screw { .. } => {
            let gradient = coordinate(poses, index, link);
            let moment = acting.moment.cross_matrix();
            entries.add((index, Part::Turn), (index, Part::Turn), &-moment);
            entries.add((parent, Part::Turn), (index, Part::Turn), &moment);
            entries.add_outer(&gradient, index, parent, by_motors - of(0).stiffness - shift * of(0).armature);
        }
        Joint::Slide { .. } => {
            let gradient = coordinate(poses, index, link);
            let size = gradient.force.dot(&acting.force);
            axial(&poses.motion, (index, parent), gradient.force, size, entries);
            entries.add_outer(&gradient, index, parent, by_motors - of(0).stiffness - shift * of(0).armature);
        }
        Joint::Ball { .. } if !(0..3).any(active) => {}
        Joint::Ball { .. } => {
            let turn = poses.motion.links[index].turn;
            let rotor = Matrix3::from_diagonal(&Vector3::from_fn(|i, _| of(i).armature));
            let tangent = applied::hinge::ball_tangent(model, link, &poses.q).unwrap_or_default();
            let moment = acting.moment.cross_matrix();
            let by_relative = turn * (tangent - shift * rotor) * turn.transpose();
            entries.add((index, Part::Turn), (index, Part::Turn), &(by_relative - moment));
            entries.add((index, Part::Turn), (parent, Part::Turn), &-by_relative);
            entries.add((parent, Part::Turn), (index, Part::Turn), &(moment - by_relative));
            entries.add((parent, Part::Turn), (parent, Part::Turn), &by_relative);
        }
    }
}
