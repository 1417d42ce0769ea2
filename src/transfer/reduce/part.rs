//! The two sweeps over some links that follow each other: all of them, or a half of a large tree on a thread of its own.

use super::ball::{self, Ball, Pivot};
use super::carried::{Carried, Left};
use super::{Load, Lost, One, Singular, three, translate};
use crate::model::{Link, Model};
use crate::motion::{LinkMotion, Motion};
use crate::spatial::Wrench;
use crate::spatial::fused::{dot, dot_add, scale_add, times_add};
use crate::transfer::element::moment_in_link_axes;
use crate::transfer::flexible::{ModalPivot, RodPivot, accelerate};
use crate::transfer::plan::{Kind, Place, To};
use crate::transfer::{self, LinkAcceleration, inboard};
use nalgebra::Vector3;
use std::ops::Range;

/// What a sweep is about.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scene<'a> {
    pub(super) model: &'a Model,
    pub(super) motion: &'a Motion,
    pub(super) plan: &'a [Place],
}

/// Of all links, joins and balls the first of a part.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct First {
    pub(super) link: usize,
    pub(super) join: usize,
    pub(super) ball: usize,
}

/// What the sweep to the root leaves of some links; each list begins with the first of the part.
#[derive(Debug)]
pub(super) struct Part<'a> {
    pub(super) first: First,
    pub(super) hinges: &'a mut [One],
    pub(super) balls: &'a mut [Ball],
    /// Models with halves have none.
    pub(super) rods: &'a mut [RodPivot],
    pub(super) modals: &'a mut [ModalPivot],
    pub(super) joins: &'a mut [Carried],
}

/// What a half passes to the link outside that carries it: from the child right after that link, and from all others; and
/// what any part says of itself.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Passed {
    pub(super) first: Carried,
    pub(super) others: Carried,
    /// What happened to digits in it.
    pub(super) lost: Lost,
}

impl<'a> Part<'a> {
    /// Cut into what comes before `at`, and from there on.
    pub(super) fn split(self, at: First) -> (Self, Self) {
        let (hinges, more_hinges) = self.hinges.split_at_mut(at.link - self.first.link);
        let (balls, more_balls) = self.balls.split_at_mut(at.ball - self.first.ball);
        let (joins, more_joins) = self.joins.split_at_mut(at.join - self.first.join);
        let before = Part { first: self.first, hinges, balls, rods: self.rods, modals: self.modals, joins };
        (
            before,
            Part {
                first: at,
                hinges: more_hinges,
                balls: more_balls,
                rods: &mut [],
                modals: &mut [],
                joins: more_joins,
            },
        )
    }

    /// Tips → root: eqs. (5) to (7). `S` and `e` go from link to link in registers, `carried` into the last; only where
    /// branches meet they are summed in memory.
    #[inline(always)]
    pub(super) fn inward(
        &mut self,
        scene: &Scene<'_>,
        load: &Load<'_>,
        range: Range<usize>,
        mut carried: Carried,
    ) -> Result<Passed, Singular> {
        let Scene { model, motion, plan } = *scene;
        let (first, joins, balls, rods) = (self.first, &mut *self.joins, &mut *self.balls, &mut *self.rods);
        let modals = &mut *self.modals;
        let hinges = &mut self.hinges[range.start - first.link..range.end - first.link];
        let (mut others, mut lost) = (Carried::default(), Lost::None);
        let mut meet = |to: To, joins: &mut [Carried], carried: &Carried| {
            if let To::Join(join) = to {
                match joins.get_mut((join as usize).wrapping_sub(first.join)) {
                    Some(sum) => sum.add(carried),
                    None => others.add(carried),
                }
            }
        };
        let links = model.links[range.clone()].iter().zip(&motion.links[range.clone()]).zip(&plan[range.clone()]);
        for ((((link, at), place), left), index) in links.zip(hinges).zip(range).rev() {
            if place.is_leaf {
                carried = Carried::default();
            } else if let Some(join) = place.join {
                carried.add(&std::mem::take(&mut joins[join as usize - first.join]));
            }
            let applied = load.applied.get(index);
            if place.translates {
                carried = translate(model, (link, at), place.is_massless, applied, &carried, load.tau, left)
                    .map_err(|pivot| Singular { link: index, pivot })?;
                lost = lost.max(left.lost(place.least));
                meet(place.to, joins, &carried);
                continue;
            }
            let mut here = if place.is_massless { carried } else { carried.with_body(place.mass, at, &model.gravity) };
            if let Some(applied) = applied {
                here = here.loaded(applied);
            }
            let failed = |pivot| Singular { link: index, pivot };
            let (to_ground, velocity) = (matches!(place.to, To::Ground), place.velocity as usize);
            carried = match place.kind {
                Kind::None => here,
                Kind::Turn | Kind::Slide | Kind::Screw => {
                    let given = (model, applied, load.tau[velocity]);
                    let one = eliminate_one(given, (link, at), place, &mut here, &mut lost).map_err(failed)?;
                    *left = one.one();
                    lost = lost.max(left.lost(place.least));
                    if to_ground {
                        continue;
                    }
                    here.without(&one).shifted(at)
                }
                Kind::Ball => {
                    let ball = &mut balls[place.ball as usize - first.ball];
                    let pivot = if place.is_leaf { Pivot::OfBody } else { Pivot::OfTree };
                    let (eliminated, across) =
                        ball::eliminate(model, (link, at), &here.matrix(), (pivot, place.least), &mut lost)
                            .map_err(failed)?;
                    *ball = eliminated;
                    let applied = applied.map_or(Vector3::zeros(), |wrench| wrench.moment);
                    let own = || moment_in_link_axes(link, &model.gravity, at) - at.turn.tr_mul(&applied);
                    let passed = ball.load(at, &three(load.tau, velocity), &here.vector(), own);
                    if to_ground {
                        continue;
                    }
                    Carried::of(&across, &passed).shifted(at)
                }
                Kind::Flex => flexible(scene, place, load.tau, &here, rods).map_err(failed)?,
                Kind::Interface => {
                    interface(scene, link, at, &here, modals);
                    here.shifted(at)
                }
                Kind::Modal => {
                    let passed = modal(scene, place, load.tau, &here, modals).map_err(failed)?;
                    if to_ground {
                        continue;
                    }
                    passed.shifted(at)
                }
            };
            meet(place.to, joins, &carried);
        }
        Ok(Passed { first: carried, others, lost })
    }
}

/// Eqs. (5) and (6) for a turn, slide or screw, by the variant that keeps the digits of its pivot; `here` is what hangs on it. On
/// failure the pivot.
#[inline(always)]
fn eliminate_one(
    (model, applied, tau): (&Model, Option<&Wrench>, f64),
    (link, at): (&Link, &LinkMotion),
    place: &Place,
    here: &mut Carried,
    lost: &mut Lost,
) -> Result<Left, f64> {
    let armature = place.armature;
    match place.kind {
        Kind::Turn | Kind::Screw if place.is_delicate && !place.is_slender => {
            here.delicate(&at.axis, link.joint.pitch(), armature, tau, lost)
        }
        Kind::Turn | Kind::Screw if place.is_delicate => {
            let given = applied.map_or(0.0, |wrench| dot(&at.axis, &wrench.moment));
            let axial = moment_in_link_axes(link, &model.gravity, at).z - given;
            let (straight, one) = here.slender(link, at, armature, (tau, axial));
            *here = straight;
            one
        }
        Kind::Turn => here.turn(&at.axis, armature, tau),
        Kind::Screw => here.screw(&at.axis, link.joint.pitch(), armature, tau),
        _ => here.slide(&at.axis, armature, tau),
    }
}

/// What an interface of a modal body brings to the coordinates of the body.
#[inline(never)]
fn interface(scene: &Scene<'_>, link: &Link, at: &LinkMotion, here: &Carried, modals: &mut [ModalPivot]) {
    let Some((modal, tip)) = link.joint.interface() else { return };
    let carried = (&here.matrix(), &here.vector());
    modals[modal].interface(&scene.motion.modals[modal], tip, carried, (&at.velocity_terms(), at.arm));
}

/// Eqs. (5) and (6) for the coordinates of a modal body; on failure the pivot.
#[inline(never)]
fn modal(
    scene: &Scene<'_>,
    place: &Place,
    tau: &[f64],
    here: &Carried,
    modals: &mut [ModalPivot],
) -> Result<Carried, f64> {
    let modal = place.ball as usize;
    let given = (&*scene.model.modals[modal].modal, &scene.motion.modals[modal]);
    let (tau, carried) = (&tau[place.velocity as usize..], (here.matrix(), here.vector()));
    let (S, e) = modals[modal].eliminate(given, &scene.model.gravity, tau, carried)?;
    Ok(Carried::of(&S, &e))
}

/// Eqs. (5) to (7) across a flexible element; on failure the pivot.
fn flexible(
    scene: &Scene<'_>,
    place: &Place,
    tau: &[f64],
    here: &Carried,
    rods: &mut [RodPivot],
) -> Result<Carried, f64> {
    let rod = place.ball as usize;
    let given = (&scene.model.rods[rod], &scene.motion.rods[rod]);
    let (tau, tip) = (&tau[place.velocity as usize..], (here.matrix(), here.vector()));
    let (S, e) = rods[rod].eliminate(given, &scene.model.gravity, (place.armature, tau), tip)?;
    Ok(Carried::of(&S, &e))
}

/// What the sweep to the root left, and where that to the tips writes: `a` begins with link `base`, `hinge` with velocity
/// `velocity`. Parents before `base` are the one link that accelerates by `outside`.
#[derive(Debug)]
pub(super) struct Outward<'a> {
    pub(super) hinges: &'a [One],
    pub(super) balls: &'a [Ball],
    pub(super) rods: &'a [RodPivot],
    pub(super) modals: &'a [ModalPivot],
    pub(super) base: usize,
    pub(super) outside: LinkAcceleration,
    pub(super) a: &'a mut [LinkAcceleration],
    pub(super) velocity: usize,
    pub(super) hinge: &'a mut [f64],
}

impl Outward<'_> {
    /// Root → tips: eq. (8).
    #[inline(always)]
    pub(super) fn sweep<const BIAS: bool>(self, scene: &Scene<'_>, range: Range<usize>) {
        let Scene { model, motion, plan } = *scene;
        let Self { hinges, balls, rods, modals, base, outside, a: found, velocity, hinge } = self;
        let mut before = outside;
        let links = plan[range.clone()].iter().zip(&motion.links[range.clone()]).zip(&hinges[range.clone()]);
        for (((place, at), left), index) in links.zip(range) {
            // Along a chain the parent's acceleration is still in registers.
            let parent = match place.parent as usize {
                parent if parent + 1 == index => before,
                parent if parent >= base => found[parent - base],
                _ => outside,
            };
            let first = place.velocity as usize - velocity;
            let mut a = inboard(at, &parent, BIAS);
            match place.kind {
                Kind::None => {}
                Kind::Turn | Kind::Slide | Kind::Screw => {
                    let free = dot_add(&-left.SH.moment, &a.angular, left.u);
                    let relative = left.inverse * dot_add(&-left.SH.force, &a.linear, free);
                    hinge[first] = relative;
                    match place.kind {
                        Kind::Turn => a.angular = scale_add(relative, &at.axis, &a.angular),
                        Kind::Slide => a.linear = scale_add(relative, &at.axis, &a.linear),
                        _ => {
                            let pitch = model.links[index].joint.pitch();
                            a.angular = scale_add(relative, &at.axis, &a.angular);
                            a.linear = scale_add(pitch * relative, &at.axis, &a.linear);
                        }
                    }
                }
                Kind::Ball => {
                    let relative = balls[place.ball as usize].solve(at, &a);
                    hinge[first..first + 3].copy_from_slice(relative.as_slice());
                    a.angular = times_add(&at.turn, &relative, &a.angular);
                }
                Kind::Flex => {
                    let rod = place.ball as usize;
                    let second = &mut hinge[first..first + motion.rods[rod].tip.len()];
                    rods[rod].solve(&parent, second);
                    accelerate(&motion.rods[rod], second, &mut a);
                }
                Kind::Modal => {
                    let modal = place.ball as usize;
                    let count = model.modals[modal].modal.count();
                    modals[modal].solve(&a, &mut hinge[first..first + count]);
                }
                Kind::Interface => transfer::accelerate(&model.links[index], at, motion, hinge, &mut a),
            }
            found[index - base] = a;
            before = a;
        }
    }
}
