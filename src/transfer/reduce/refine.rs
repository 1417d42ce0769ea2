//! Accelerations of trees in which digits were lost: refined by what they leave unbalanced.
//!
//! An articulated inertia about an axis that everything outboard hardly resists (a point mass on two axes that nearly meet
//! in a plane with it, a rod about itself) is the difference of numbers as large as the others. The factorization is good
//! for the digits that are left of it, and so is what it solves; its own residual, taken without that difference, has all
//! of them. A round gains as many digits as the factorization has.
//!
//! No pivot need be tiny for that: four of a hundredth of what they are the difference of, one after the other, make 10⁻⁸.
//! So such pivots only ask for a look at what has come out: motions that hardly anything resists are the ones that the
//! lost digits are in. The pivot of a light link that carries a body 10⁵ times heavier, in a position in which that body does not
//! resist the link's motion, is the difference of inertias of the heavy one: its digits are lost whatever moves.
//!
//! Without it: forces at the centres of mass, where a fast turn about a line through a mass cancels before it is multiplied,
//! and moments in the axes in which bodies are given, where it meets the small moment of inertia alone.

use super::{Load, Lost, Reduction, Singular};
use crate::model::{Body, Joint, Model};
use crate::motion::{LinkMotion, Motion};
use crate::spatial::{Sym3, Wrench};
use crate::transfer::element::gyroscopic;
use crate::transfer::flexible::RodBalance;
use crate::transfer::{LinkAcceleration, accelerate, along, inboard, lever};
use nalgebra::{Matrix3, Point3, Vector3};

/// Accelerations are wrong by about a third of a unit in the last place over this part, and by no more than 10⁻¹¹ of
/// themselves above it: what the links resist of their accelerations, of what those would be resisted if they were about any axis.
pub(in crate::transfer) const SOFT: f64 = 1e-5;

/// The rounds end when the next correction would be below this part of the accelerations, if it is as much smaller than this one as
/// this one than the one before; also when one is no smaller than half the one before, which is round-off.
const SMALL: f64 = 1e-12;

/// Of a hinge with a pivot just above round-off few digits are right: a round may gain no more than one or two.
const MOST_ROUNDS: usize = 8;

/// If the last correction is above this part of the accelerations, there may be one that nothing determines: a pivot that is
/// nothing but round-off leaves its row as unbalanced as it was in every round. (So does round-off where nothing accelerates.)
const DOUBTFUL: f64 = 1e-6;

/// Accelerations of a trial, in those of the scene.
const FAR: f64 = 1e6;

/// Scratch of [`Reduction::refine`].
#[derive(Debug, Clone, Default)]
pub(super) struct Refinement {
    /// The bodies in the order of their links.
    bodies: Vec<usize>,
    /// Residual hinge forces, and what they accelerate; one per velocity.
    left: Vec<f64>,
    step: Vec<f64>,
    /// Forces of a trial (N, N m).
    force: Vec<f64>,
    /// Of flexible elements.
    rods: Vec<RodBalance>,
}

/// A named body on its link: several may be welded to one.
struct Rigid {
    mass: f64,
    /// From the link's root marker, link axes (m).
    center: Vector3<f64>,
    /// About the centre of mass, body axes (kg m²).
    inertia: Sym3,
    link_from_body: Matrix3<f64>,
}

impl Refinement {
    pub(super) fn new(model: &Model) -> Self {
        let mut bodies: Vec<usize> = (0..model.bodies.len()).filter(|body| model.bodies[*body].link != 0).collect();
        bodies.sort_by_key(|body| model.bodies[*body].link);
        let count = model.velocity_count();
        let rods = model.rods.iter().map(RodBalance::new).collect();
        Self { bodies, left: vec![0.0; count], step: vec![0.0; count], force: vec![0.0; count], rods }
    }
}

impl Rigid {
    fn of(body: &Body) -> Self {
        Self {
            mass: body.mass.mass,
            center: (body.link_from_body * Point3::from(body.mass.center)).coords,
            inertia: Sym3::symmetric_part(&body.mass.inertia),
            link_from_body: *body.link_from_body.rotation.to_rotation_matrix().matrix(),
        }
    }

    /// `M a + b` with the weight: the force in inertial axes, the moment about the link's root marker in link axes.
    fn needs(&self, gravity: &Vector3<f64>, at: &LinkMotion, a: &LinkAcceleration) -> Wrench {
        let (w, c) = (at.angular_velocity, at.turn * self.center);
        let swing = w.cross(&w.cross(&c)) - gravity;
        let force = self.mass * (a.linear + a.angular.cross(&c) + swing);
        let in_body_axes = |v: &Vector3<f64>| self.link_from_body.tr_mul(&at.turn.tr_mul(v));
        let turning = self.inertia * in_body_axes(&a.angular) + gyroscopic(&self.inertia, &in_body_axes(&w));
        let moment = self.link_from_body * turning + self.center.cross(&at.turn.tr_mul(&force));
        Wrench { force, moment }
    }
}

impl Reduction {
    /// Corrects the accelerations of the last factorization by what they leave unbalanced.
    ///
    /// # Errors
    /// A hinge whose pivot is round-off: nothing determines its acceleration.
    #[cold]
    #[inline(never)]
    pub(super) fn refine(
        &mut self,
        model: &Model,
        motion: &Motion,
        load: &Load<'_>,
        hinge: &mut [f64],
        lost: Lost,
    ) -> Result<(), Singular> {
        if lost == Lost::Perhaps && !self.is_soft(model) {
            return Ok(());
        }
        let mut refinement = std::mem::take(&mut self.refinement);
        let largest = |list: &[f64]| list.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        let mut before = largest(hinge);
        for _ in 0..MOST_ROUNDS {
            self.unbalanced(model, motion, load, hinge, &mut refinement);
            let Refinement { left, step, .. } = &mut refinement;
            self.solve(model, motion, &Load { applied: &[], tau: left }, step);
            hinge.iter_mut().zip(&*step).for_each(|(hinge, step)| *hinge += step);
            let now = largest(step);
            let goes_on = now * now > SMALL * before * largest(hinge) && now < 0.5 * before;
            before = now;
            if !goes_on {
                break;
            }
        }
        let outcome = match before > DOUBTFUL * largest(hinge) {
            true => self.determined(model, motion, &mut refinement),
            false => Ok(()),
        };
        self.follow(model, motion, hinge);
        self.refinement = refinement;
        outcome
    }

    /// Whether the coordinate that the last correction moved most has a pivot that is more than round-off: what the pivot says that
    /// a force on it alone accelerates needs that force, and not another.
    fn determined(&mut self, model: &Model, motion: &Motion, refinement: &mut Refinement) -> Result<(), Singular> {
        let moved = |k: &usize| refinement.step[*k].abs();
        let Some(at) = (0..refinement.step.len()).max_by(|a, b| moved(a).total_cmp(&moved(b))) else { return Ok(()) };
        let Some(link) = model.links.iter().position(|link| {
            let own = link.velocity..link.velocity + link.joint.counts().1;
            own.contains(&at)
        }) else {
            return Ok(());
        };
        let pivot = match model.links[link].joint {
            Joint::Turn | Joint::Slide { .. } | Joint::Screw { .. } => 1.0 / self.hinges[link].inverse,
            Joint::Ball { .. } => self.balls[self.plan[link].ball as usize].least_pivot(),
            Joint::None | Joint::Flex { .. } | Joint::Along { .. } | Joint::Modal { .. } | Joint::Interface { .. } => {
                return Ok(());
            }
        };
        // Far beyond what weight and turns do, whose round-off is then none beside it.
        let turning = motion.links.iter().fold(0.0_f64, |most, at| most.max(at.angular_velocity.norm_squared()));
        let force = FAR * pivot * (model.time_scale().powi(-2) + turning);
        let (mut tau, mut hinge) = (std::mem::take(&mut refinement.force), std::mem::take(&mut refinement.step));
        tau.fill(0.0);
        hinge.fill(0.0);
        self.unbalanced(model, motion, &Load { applied: &[], tau: &tau }, &hinge, refinement);
        let rest = refinement.left[at];
        tau[at] = force;
        self.solve(model, motion, &Load { applied: &[], tau: &tau }, &mut hinge);
        self.unbalanced(model, motion, &Load { applied: &[], tau: &tau }, &hinge, refinement);
        let wrong = refinement.left[at] - rest;
        (refinement.force, refinement.step) = (tau, hinge);
        if wrong.abs() < 0.5 * force { Ok(()) } else { Err(Singular { link, pivot }) }
    }

    /// Whether the last solution moves links in a way that hardly anything resists: `q̈ᵀ M q̈`, but for velocities the sum of
    /// `uᵀ D⁻¹ u`, compared with that of links that resist every turn as they do that about their worst axis.
    fn is_soft(&self, model: &Model) -> bool {
        let (mut resisted, mut seen) = (0.0, 0.0);
        for (index, link) in model.links.iter().enumerate().skip(1) {
            resisted += match link.joint {
                Joint::None => 0.0,
                Joint::Ball { .. } => self.balls[self.plan[index].ball as usize].resisted(),
                Joint::Flex { rod, .. } | Joint::Along { rod } => self.rods[rod].resisted(),
                Joint::Interface { .. } => 0.0,
                Joint::Modal { modal, .. } => self.modals[modal].resisted(),
                _ => self.hinges[index].u.powi(2) * self.hinges[index].inverse,
            };
            seen += link.inertia.trace() * self.a[index].angular.norm_squared();
        }
        resisted < SOFT * seen
    }

    /// Eq. (2) for given accelerations of the hinges.
    fn follow(&mut self, model: &Model, motion: &Motion, hinge: &[f64]) {
        for (index, (link, at)) in model.links.iter().zip(&motion.links).enumerate().skip(1) {
            let mut a = inboard(at, &self.a[link.parent], true);
            accelerate(link, at, motion, hinge, &mut a);
            self.a[index] = a;
        }
    }

    /// `τ − A q̈ − Hᵀ f` by eqs. (1) to (3).
    fn unbalanced(
        &mut self,
        model: &Model,
        motion: &Motion,
        load: &Load<'_>,
        hinge: &[f64],
        refinement: &mut Refinement,
    ) {
        self.follow(model, motion, hinge);
        let Self { e, a, .. } = self;
        match load.applied.is_empty() {
            true => e.fill(Wrench::ZERO),
            false => e.iter_mut().zip(load.applied).for_each(|(e, applied)| *e = Wrench::ZERO - *applied),
        }
        let Refinement { bodies, left, rods, .. } = refinement;
        let mut bodies = bodies.iter().rev().peekable();
        for index in (1..model.links.len()).rev() {
            let (link, at) = (&model.links[index], &motion.links[index]);
            let mut own = Wrench::ZERO;
            while let Some(body) = bodies.next_if(|body| model.bodies[**body].link == index) {
                own += Rigid::of(&model.bodies[*body]).needs(&model.gravity, at, &a[index]);
            }
            let mut passed = e[index];
            let (to, tau) = (link.velocity, load.tau);
            let rotor = |i: usize| tau[i] - model.coordinates[i].armature * hinge[i];
            match link.joint {
                Joint::None => {}
                // The axis of a turn or screw is the link's z.
                Joint::Turn => left[to] = rotor(to) - (along(&link.joint, &at.axis, &passed) + own.moment.z),
                Joint::Slide { .. } => {
                    left[to] = rotor(to) - along(&link.joint, &at.axis, &passed) - at.axis.dot(&own.force);
                }
                Joint::Screw { pitch } => {
                    let own = own.moment.z + pitch * at.axis.dot(&own.force);
                    left[to] = rotor(to) - (along(&link.joint, &at.axis, &passed) + own);
                }
                Joint::Ball { .. } => {
                    let moment = at.turn.tr_mul(&passed.moment) + own.moment;
                    (0..3).for_each(|i| left[to + i] = rotor(to + i) - moment[i]);
                }
                Joint::Flex { .. } | Joint::Along { .. } => {}
                // For the coordinates of the frame, which come later.
                Joint::Interface { .. } => e[index] += Wrench { force: own.force, moment: at.turn * own.moment },
                Joint::Modal { modal, count } => {
                    let (body, here, range) = (&model.modals[modal], &motion.modals[modal], to..to + count);
                    let (rows, second) = (&mut left[range.clone()], &hinge[range.clone()]);
                    here.rows(&body.modal, Some(&model.gravity), &a[index], second, rows);
                    here.pull(body.links.iter().map(|link| &e[*link]), rows);
                    rows.iter_mut().zip(range).for_each(|(row, i)| *row = rotor(i) - *row);
                    passed += here.wrench(&body.modal, Some(&model.gravity), &a[index], second);
                }
            }
            if let Some(rod) = link.joint.rod() {
                let range = to..to + link.joint.counts().1;
                let (given, second) = ((&model.rods[rod], &motion.rods[rod]), &hinge[range.clone()]);
                let tip = passed + Wrench { force: own.force, moment: at.turn * own.moment };
                let rows = &mut left[range.clone()];
                passed = rods[rod].inward(given, &model.gravity, &a[link.parent], second, &tip, rows);
                rows.iter_mut().zip(range).for_each(|(row, i)| *row = rotor(i) - *row);
                e[link.parent] += passed;
                continue;
            }
            let whole = passed + Wrench { force: own.force, moment: at.turn * own.moment };
            let lever = lever(&at.arm, &whole.force);
            e[link.parent] += Wrench { force: whole.force, moment: whole.moment + lever };
        }
    }
}
