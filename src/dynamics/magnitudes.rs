//! How large the terms of the static balance are: the same sweep with absolute values. Tells a residual that is
//! round-off from one that is not.

use super::Balanced;
use crate::force::Act;
use crate::model::Link;
use std::cell::LazyCell;

/// Magnitudes per velocity coordinate.
#[derive(Debug, Clone)]
pub struct Magnitudes {
    /// Sum of the sizes of the forces that must cancel (N, N m).
    pub force: Vec<f64>,
    /// Sum of these sizes with every spring counted as its stiffness times its lengths: times the machine precision, the
    /// round-off level of the balance (N, N m).
    pub noise: Vec<f64>,
    /// Sum of the squares of the terms of `noise`: their errors are independent of each other (N², N² m²).
    pub squares: Vec<f64>,
    /// Size of the springs' contributions to the stiffness (N/m, N m/rad).
    pub stiffness: Vec<f64>,
}

/// Force, moment, and what a linear spring to the ground would add, at one link.
#[derive(Clone, Copy, Default)]
struct Size {
    force: f64,
    moment: f64,
    noise: f64,
    noise_moment: f64,
    square: f64,
    square_moment: f64,
    stiffness: f64,
    turn_stiffness: f64,
}

impl Size {
    /// A force and a moment that are no difference of larger ones: their round-off is that of their own size.
    fn add(&mut self, force: f64, moment: f64) {
        self.force += force;
        self.moment += moment;
        self.noise += force;
        self.noise_moment += moment;
        self.square += force * force;
        self.square_moment += moment * moment;
    }
}

impl Balanced<'_> {
    /// Sizes of the terms of the balance, at rest or where drives keep their velocity.
    pub fn magnitudes(&self) -> Magnitudes {
        let q = self.q;
        let model = &*self.system.model;
        let mut sizes = vec![Size::default(); model.links.len()];
        for (index, link) in model.links.iter().enumerate() {
            let (at, moves) = (&self.system.motion.links[index], &self.system.balance.accelerations[index]);
            let turns = moves.angular.norm() + at.angular_velocity.norm_squared();
            let weight = link.mass * (model.gravity.norm() + moves.linear.norm() + turns * at.center.norm());
            let moment = weight * at.center.norm() + turns * at.inertia.trace();
            sizes[index].add(weight, moment);
        }
        for force in self.system.laws.forces.iter() {
            let part = force.law.magnitude(&self.system.motion.links);
            for end in force.law.ends() {
                let size = &mut sizes[end.link];
                let arm = (self.system.motion.links[end.link].turn * end.point).norm();
                size.force += part.force;
                size.moment += part.force * arm + part.moment;
                size.noise += part.noise;
                size.noise_moment += part.noise * arm + part.noise_moment;
                size.square += part.noise * part.noise;
                size.square_moment += (part.noise * arm + part.noise_moment).powi(2);
                size.stiffness += part.stiffness;
                size.turn_stiffness += part.stiffness * arm * arm + part.turn_stiffness;
            }
        }
        let (none, length) = (vec![0.0; model.velocity_count()], LazyCell::new(|| model.length_scale()));
        let mut out = Magnitudes { force: none.clone(), noise: none.clone(), squares: none.clone(), stiffness: none };
        for index in (1..model.links.len()).rev() {
            let link = &model.links[index];
            if let Some(rod) = link.joint.rod() {
                self.size_of_rod(link, rod, &mut sizes[index], &mut out);
            }
            if let Some(modal) = link.joint.modal() {
                self.size_of_modal(index, modal, &mut sizes, &mut out);
            }
            let size = sizes[index];
            let (slide, pitch) = (link.joint.is_slide(), link.joint.pitch().abs());
            // Of a coordinate of this link: along a slide, about the axis of a turn, or both.
            let pick = |along: f64, about: f64, pitch: f64| if slide { along } else { about + pitch * along };
            let (_, count) = link.joint.counts();
            let is_flexible = link.joint.rod().is_some() || link.joint.modal().is_some();
            let rigid = if is_flexible { 0 } else { count };
            for i in link.velocity..link.velocity + rigid {
                let coordinate = &model.coordinates[i];
                // Less than the machine precision of a radian, or of the scene's length, is no position.
                let least = f64::EPSILON * if slide { *length } else { 1.0 };
                let extent = if count == 1 { (q[link.position].abs() + coordinate.rest.abs()).max(least) } else { 1.0 };
                let spring = coordinate.stiffness.abs() * extent + coordinate.force.abs();
                out.force[i] = spring + pick(size.force, size.moment, pitch);
                out.noise[i] = spring + pick(size.noise, size.noise_moment, pitch);
                out.squares[i] = spring * spring + pick(size.square, size.square_moment, pitch * pitch);
                out.stiffness[i] =
                    coordinate.stiffness.abs() + pick(size.stiffness, size.turn_stiffness, pitch * pitch);
            }
            let arm = self.system.motion.links[index].arm.norm();
            let parent = &mut sizes[link.parent];
            parent.force += size.force;
            parent.moment += size.moment + arm * size.force;
            parent.noise += size.noise;
            parent.noise_moment += size.noise_moment + arm * size.noise;
            parent.square += size.square;
            parent.square_moment += size.square_moment + (arm * size.noise).powi(2);
            parent.stiffness += size.stiffness;
            parent.turn_stiffness += size.turn_stiffness + arm * arm * size.stiffness;
        }
        for (coordinate, push) in model.pushed().zip(&self.system.pushes) {
            let (i, at) = (coordinate.velocity, coordinate.position);
            let size = push.force.abs() + (push.by_position * q[at]).abs();
            out.force[i] += size;
            out.noise[i] += size;
            out.squares[i] += size * size;
            out.stiffness[i] += push.by_position.abs();
        }
        out
    }

    /// Of a modal body: its own coordinates, and what its mass adds to the link of its frame.
    fn size_of_modal(&self, index: usize, modal: usize, sizes: &mut [Size], out: &mut Magnitudes) {
        let (model, motion) = (&self.system.model, &self.system.motion);
        let (body, at, link) = (&model.modals[modal], &motion.modals[modal], &model.links[index]);
        let (given, moves) = (&*body.modal, &self.system.balance.accelerations[index]);
        let spin = motion.links[index].angular_velocity.norm_squared();
        let (linear, turns) = (model.gravity.norm() + moves.linear.norm(), moves.angular.norm() + spin);
        for (j, column) in at.columns.iter().enumerate() {
            let i = link.velocity + j;
            let row = given.stiffness_row(j);
            let elastic: f64 = row.iter().zip(&at.q).map(|(k, q)| (k * q).abs()).sum();
            let own = elastic + column.force.norm() * linear + column.moment.norm() * turns;
            (out.force[i], out.noise[i], out.squares[i]) = (own, own, own * own);
            out.stiffness[i] = row[j];
        }
        for (tip, of) in at.tips.iter().zip(&body.links) {
            let size = sizes[*of];
            for (j, (shift, spin)) in tip.moved_by.iter().zip(&tip.columns) {
                let (i, along, about) = (link.velocity + j, shift.norm(), spin.norm());
                out.force[i] += along * size.force + about * size.moment;
                out.noise[i] += along * size.noise + about * size.noise_moment;
                out.squares[i] += along * along * size.square + about * about * size.square_moment;
                out.stiffness[i] += along * along * size.stiffness + about * about * size.turn_stiffness;
            }
        }
        let size = &mut sizes[index];
        let force = given.mass * linear + turns * at.first.norm();
        let moment = at.first.norm() * linear + turns * at.inertia.trace();
        size.add(force, moment);
    }

    /// Of a flexible element: its own coordinates, and what its slices add to the link of its tip.
    fn size_of_rod(&self, link: &Link, rod: usize, size: &mut Size, out: &mut Magnitudes) {
        let (given, at) = (&self.system.model.rods[rod], &self.system.motion.rods[rod]);
        let (gravity, felt) = (self.system.model.gravity.norm(), &self.system.balance.rods[rod]);
        for k in 1..given.steps() {
            let (slice, a) = (&given.slices[k], &felt.accelerations[k]);
            let force = slice.mass * (gravity + a.linear.norm()) + slice.length * given.load.norm();
            let moment = force * (given.length - slice.at) + slice.inertia.trace() * a.angular.norm();
            size.add(force, moment);
        }
        for (j, tip) in at.tip.iter().enumerate() {
            let i = link.velocity + j;
            let (along, about) = (tip.fixed_rows::<3>(0).norm(), tip.fixed_rows::<3>(3).norm());
            // Terms that cancel within the element do not show at its tip.
            let turns = given.strain_of(j) >= 3;
            let (within, about) = if turns { (along, about.max(1.0)) } else { (along.max(1.0), about) };
            let row = given.stiffness_row(j);
            let coordinate = &self.system.model.coordinates[i];
            let spring = coordinate.stiffness.abs() * (at.q[j].abs() + coordinate.rest.abs()) + coordinate.force.abs();
            let elastic = spring + row.iter().zip(&at.q).map(|(k, q)| (k * q).abs()).sum::<f64>();
            out.force[i] = elastic + within * size.force + about * size.moment;
            out.noise[i] = elastic + within * size.noise + about * size.noise_moment;
            out.squares[i] = elastic * elastic + within * within * size.square + about * about * size.square_moment;
            let geometric = match given.guide() {
                // What acts on a body along a curve turns with respect to the tangent.
                Some(guide) => {
                    let bends = guide.at(at.q[j]).subspaces[1];
                    bends.fixed_rows::<3>(0).norm() * size.force + bends.fixed_rows::<3>(3).norm() * size.moment
                }
                None => about * about * (size.moment + given.length * size.force),
            };
            let springs = along * along * size.stiffness + about * about * size.turn_stiffness;
            out.stiffness[i] = row[j] + coordinate.stiffness.abs() + geometric + springs;
        }
    }
}
