//! Steady motion in maximal coordinates: some hinges keep a rate, and all links have the inertia forces of that.
//!
//! Velocities and accelerations go from the ground outward, `n` the axis and `q̇` the rate of a hinge, `d` from the
//! parent's root marker to the link's:
//!
//! ```text
//! turn   ω = ω_P + n q̇     α = α_P + ω_P × n q̇     a = a_P + α_P × d + ω_P × (ω_P × d)
//! slide  ω = ω_P           α = α_P                 a = … + 2 ω_P × n q̇
//! force  −m (a + α×c + ω×(ω×c)),     moment  −(c × m(…) at the root marker: c × m a + J α + ω × J ω)
//! ```
//!
//! How these vary is taken as differences: their error, some parts in 10⁹, only costs that part of the convergence.

use super::balance::coordinate;
use super::entries::Entries;
use super::gradient::Part;
use super::poses::Poses;
use crate::model::Model;
use crate::spatial::Wrench;
use nalgebra::{Rotation3, Vector3};

/// Turn (rad), and part of the scene's length, over which is differenced.
const DIFFERENCE: f64 = 1e-6;

#[derive(Clone, Copy, Default)]
struct Moving {
    turning: Vector3<f64>,
    turning_faster: Vector3<f64>,
    acceleration: Vector3<f64>,
}

/// Inertia forces at the root markers.
pub(super) fn inertia(model: &Model, poses: &Poses, rates: &[f64]) -> Vec<Wrench> {
    let mut moving = vec![Moving::default(); model.links.len()];
    let mut wrenches = vec![Wrench::ZERO; model.links.len()];
    for (index, link) in model.links.iter().enumerate().skip(1) {
        let (own, parent) = (&poses.motion.links[index], &poses.motion.links[link.parent]);
        let before = moving[link.parent];
        let (w, d) = (before.turning, own.position - parent.position);
        let mut now = before;
        now.acceleration += before.turning_faster.cross(&d) + w.cross(&w.cross(&d));
        if link.joint.is_scalar() {
            let (gradient, rate) = (coordinate(poses, index, link), rates[link.velocity]);
            let spin = rate * gradient.on_link;
            now.turning += spin;
            now.turning_faster += w.cross(&spin);
            now.acceleration += 2.0 * rate * w.cross(&gradient.force);
        }
        moving[index] = now;
        let (w, faster, c) = (now.turning, now.turning_faster, own.center);
        let inertia = link.inertia.turned(&own.turn);
        let force = link.mass * (now.acceleration + faster.cross(&c) + w.cross(&w.cross(&c)));
        let moment = link.mass * c.cross(&now.acceleration) + inertia * faster + w.cross(&(inertia * w));
        wrenches[index] = Wrench { force: -force, moment: -moment };
    }
    wrenches
}

/// Adds how they vary with the poses: of a link and of what hangs on it.
pub(super) fn vary(model: &Model, poses: &Poses, rates: &[f64], entries: &mut Entries) {
    let mut moved = poses.clone();
    for (j, link) in model.links.iter().enumerate().skip(1) {
        let kept = poses.motion.links[j];
        for (part, axis) in [Part::Place, Part::Turn].into_iter().flat_map(|part| (0..3).map(move |axis| (part, axis)))
        {
            let size = if part == Part::Place { DIFFERENCE * model.length_scale() } else { DIFFERENCE };
            let mut side = |sign: f64| {
                let at = &mut moved.motion.links[j];
                let by = sign * size * Vector3::ith(axis, 1.0);
                match part {
                    Part::Place => at.position += by,
                    Part::Turn => {
                        at.turn = Rotation3::new(by).matrix() * kept.turn;
                        at.center = at.turn * link.center;
                    }
                }
                let wrenches = inertia(model, &moved, rates);
                moved.motion.links[j] = kept;
                wrenches
            };
            let (after, before) = (side(1.0), side(-1.0));
            for i in j..link.subtree_end {
                let change = after[i] + (Wrench::ZERO - before[i]);
                let per = 0.5 / size;
                let change = Wrench { force: per * change.force, moment: per * change.moment };
                entries.add_wrench(i, (j, part), axis, &change);
            }
        }
    }
}
