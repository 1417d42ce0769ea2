//! What a link passes on to its parent, in every model: `S` and `e` of eq. (4). One stage a function.

use super::tree::{Numbers, Place};
use crate::spatial::lanes::{
    AT, LaneMatrix, LaneSymmetric, LaneVector, LaneWrench, Lanes, LinkLanes, all, cross, cross_add, difference, dot,
    dot_add, fma, less, scale_add, scaled, sum, symmetric_times, symmetric_times_add, times, times_add, trace,
    transposed_times,
};
use crate::transfer::plan::Kind;
use crate::transfer::reduce::{LOST, LOST_BY_BALL, SINGULAR};

/// `S` and `e`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Carried {
    ff: LaneSymmetric,
    fm: LaneMatrix,
    mm: LaneSymmetric,
    force: LaneVector,
    moment: LaneVector,
}

/// A coordinate, eliminated: `S H`, `D⁻¹` and `u`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct One {
    pub(super) force: LaneVector,
    pub(super) moment: LaneVector,
    pub(super) inverse: Lanes,
    pub(super) u: Lanes,
}

/// What happened to the digits of every model: masks, all bits of a lane where it is so.
#[derive(Debug, Clone, Copy)]
pub(super) struct Digits {
    /// Every pivot is one, and has kept its digits.
    pub(super) sound: Lanes,
    /// Some may be lost: the accelerations tell.
    pub(super) doubtful: Lanes,
}

impl Digits {
    pub(super) fn new() -> Self {
        Self { sound: all(0.0).simd_eq(all(0.0)), doubtful: all(0.0) }
    }
}

impl Carried {
    /// What branches carry, summed.
    #[inline(never)]
    pub(super) fn add(&mut self, other: &Self) {
        for i in 0..6 {
            self.ff[i] += other.ff[i];
            self.mm[i] += other.mm[i];
        }
        for i in 0..3 {
            self.fm[i] = sum(&self.fm[i], &other.fm[i]);
        }
        self.force = sum(&self.force, &other.force);
        self.moment = sum(&self.moment, &other.moment);
    }

    /// Eq. (1): `M`, and `b` with the weight.
    #[inline(never)]
    pub(super) fn with_body(&mut self, place: &Place, numbers: &Numbers, at: &LinkLanes, gravity: &LaneVector) {
        let (w, mass) = (&at.angular_velocity, numbers.mass);
        let c = times(&at.turn, &numbers.center);
        let mc = scaled(mass, &c);
        let swing = difference(&cross(w, &cross(w, &c)), gravity);
        self.force = scale_add(mass, &swing, &self.force);
        let mut spin = scaled(numbers.middle, w);
        for i in 0..if place.is_triaxial { 2 } else { 1 } {
            let axis = times(&at.turn, &numbers.axes[i]);
            let stretched = scaled(numbers.excess[i], &axis);
            spin = scale_add(dot(&axis, w), &stretched, &spin);
            for row in 0..3 {
                for column in row..3 {
                    let entry = &mut self.mm[AT[row][column]];
                    *entry = fma(stretched[row], axis[column], *entry);
                }
            }
        }
        self.moment = cross_add(w, &spin, &cross_add(gravity, &mc, &self.moment));
        for i in [0, 3, 5] {
            self.ff[i] += mass;
            self.mm[i] += numbers.middle;
        }
        // fm −= [m c]×
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            self.fm[j][k] -= mc[i];
            self.fm[k][j] += mc[i];
        }
    }

    /// Less what acts on the link.
    #[inline(always)]
    pub(super) fn loaded(&mut self, applied: &LaneWrench) {
        self.force = difference(&self.force, &applied.force);
        self.moment = difference(&self.moment, &applied.moment);
    }

    /// Eqs. (5) and (6) for a turn, slide or screw: its factors. What it may have lost is noted.
    #[inline(never)]
    pub(super) fn factors(
        &self,
        place: &Place,
        numbers: &Numbers,
        axis: &LaneVector,
        tau: Lanes,
        digits: &mut Digits,
    ) -> One {
        let (n, p) = (axis, numbers.pitch);
        let turned = || (times(&self.fm, n), symmetric_times(&self.mm, n));
        let slid = || (symmetric_times(&self.ff, n), transposed_times(&self.fm, n));
        let (force, moment, along, e, seen) = match place.kind {
            Kind::Slide => {
                let (force, moment) = slid();
                (force, moment, dot(n, &force), dot(n, &self.force), trace(&self.ff))
            }
            Kind::Screw => {
                let ((force, moment), (more_force, more)) = (turned(), slid());
                let (force, moment) = (scale_add(p, &more_force, &force), scale_add(p, &more, &moment));
                let seen = fma(p * p, trace(&self.ff), trace(&self.mm));
                let along = |force: &LaneVector, moment: &LaneVector| fma(p, dot(n, force), dot(n, moment));
                (force, moment, along(&force, &moment), along(&self.force, &self.moment), seen)
            }
            _ => {
                let (force, moment) = turned();
                (force, moment, dot(n, &moment), dot(n, &self.moment), trace(&self.mm))
            }
        };
        let pivot = along + numbers.armature[0];
        digits.sound &= pivot.simd_gt(all(SINGULAR) * seen);
        if place.is_delicate && !place.is_slender && place.kind != Kind::Slide {
            let small = pivot.simd_lt(all(LOST) * trace(&self.mm));
            digits.doubtful |= small & (pivot * pivot).simd_lt(all(LOST) * dot(&moment, &moment));
        }
        One::of(place, numbers, (force, moment, pivot, tau - e), digits)
    }

    /// Eqs. (5) and (6) for a slide below which nothing turns.
    #[inline(never)]
    pub(super) fn translation(
        &mut self,
        place: &Place,
        numbers: &Numbers,
        axis: &LaneVector,
        tau: Lanes,
        digits: &mut Digits,
    ) -> One {
        let force = symmetric_times(&self.ff, axis);
        let pivot = dot_add(axis, &force, numbers.armature[0]);
        digits.sound &= pivot.simd_gt(all(SINGULAR) * trace(&self.ff));
        let one = One::of(place, numbers, (force, [all(0.0); 3], pivot, tau - dot(axis, &self.force)), digits);
        let part = scaled(-one.inverse, &force);
        for row in 0..3 {
            for column in row..3 {
                let entry = &mut self.ff[AT[row][column]];
                *entry = fma(part[row], force[column], *entry);
            }
        }
        self.force = scale_add(one.inverse * one.u, &force, &self.force);
        one
    }

    /// Eqs. (5) and (6) for a turn or screw with a last link that is slender, by its numbers in its own axes, as the scalar sweep
    /// has them; also `S` and `e` that agree with them.
    #[inline(never)]
    pub(super) fn slender(
        &mut self,
        place: &Place,
        numbers: &Numbers,
        (at, gravity, applied): (&LinkLanes, &LaneVector, Option<&LaneWrench>),
        tau: Lanes,
        digits: &mut Digits,
    ) -> One {
        let (n, J, c) = (&at.axis, &numbers.inertia, scaled(numbers.mass, &numbers.center));
        let force = times(&at.turn, &[-c[1], c[0], all(0.0)]);
        let moment = times(&at.turn, &[J[2], J[4], J[5]]);
        let more_force = difference(&force, &times(&self.fm, n));
        let more = difference(&moment, &symmetric_times(&self.mm, n));
        let half = difference(&more, &scaled(all(0.5) * dot(n, &more), n));
        for row in 0..3 {
            for column in 0..3 {
                self.fm[column][row] = fma(more_force[row], n[column], self.fm[column][row]);
            }
            for column in row..3 {
                let entry = &mut self.mm[AT[row][column]];
                *entry = fma(half[row], n[column], fma(n[row], half[column], *entry));
            }
        }
        let given = applied.map_or(all(0.0), |wrench| dot(n, &wrench.moment));
        let axial = axial_moment(numbers, at, gravity) - given;
        self.moment = scale_add(axial - dot(n, &self.moment), n, &self.moment);
        // What a screw adds.
        let p = numbers.pitch;
        let (slid, turned) = (symmetric_times(&self.ff, n), transposed_times(&self.fm, n));
        let (force, moment) = (scale_add(p, &slid, &force), scale_add(p, &turned, &moment));
        let resisting = p * p * numbers.mass;
        let pivot = J[5] + resisting + numbers.armature[0];
        digits.sound &= pivot.simd_gt(all(SINGULAR) * fma(all(3.0), resisting, trace(J)));
        One::of(place, numbers, (force, moment, pivot, tau - axial - p * dot(n, &self.force)), digits)
    }

    /// `S'` and `e'` without the velocity terms, eqs. (5) and (6).
    #[inline(never)]
    pub(super) fn without(&mut self, one: &One) {
        let (f, m) = (&one.force, &one.moment);
        let (pf, pm, step) = (scaled(-one.inverse, f), scaled(-one.inverse, m), one.inverse * one.u);
        for row in 0..3 {
            for column in row..3 {
                let at = AT[row][column];
                self.ff[at] = fma(pf[row], f[column], self.ff[at]);
                self.mm[at] = fma(pm[row], m[column], self.mm[at]);
            }
            for column in 0..3 {
                self.fm[column][row] = fma(pf[row], m[column], self.fm[column][row]);
            }
        }
        self.force = scale_add(step, f, &self.force);
        self.moment = scale_add(step, m, &self.moment);
    }

    /// Eqs. (5) and (6) for a ball: three turns about the link's axes.
    #[inline(never)]
    pub(super) fn without_ball(
        &mut self,
        place: &Place,
        numbers: &Numbers,
        at: &LinkLanes,
        tau: &[Lanes],
        digits: &mut Digits,
        found: &mut [One],
    ) {
        let seen = numbers.armature.iter().fold(trace(&self.mm), |sum, armature| sum + *armature);
        for i in 0..3 {
            let n = &at.turn[i];
            let (force, moment) = (times(&self.fm, n), symmetric_times(&self.mm, n));
            let pivot = dot_add(n, &moment, numbers.armature[i]);
            digits.sound &= pivot.simd_gt(all(LOST_BY_BALL) * seen);
            found[i] = One::of(place, numbers, (force, moment, pivot, tau[i] - dot(n, &self.moment)), digits);
            self.without(&found[i]);
        }
        if !place.is_geared {
            // Without rotors S' H = 0 holds identically.
            (self.fm, self.mm) = (LaneMatrix::default(), LaneSymmetric::default());
            self.moment = times(&at.turn, &[tau[0], tau[1], tau[2]]);
        }
    }

    /// Eq. (7), after `S' γ` of eq. (6): what the parent gets.
    #[inline(never)]
    pub(super) fn shift(&mut self, at: &LinkLanes) {
        let (d, linear, angular) = (&at.arm, &at.bias, &at.angular_bias);
        let force = times_add(&self.fm, angular, &symmetric_times_add(&self.ff, linear, &self.force));
        let turned = sum(&symmetric_times_add(&self.mm, angular, &self.moment), &transposed_times(&self.fm, linear));
        (self.force, self.moment) = (force, cross_add(d, &force, &turned));
        // mm' = mm + ([d]× fm)ᵀ + [d]× fm',  fm' = fm − ff [d]×: row by row fm + d × ff
        for row in 0..3 {
            for column in row..3 {
                let (j, k) = ((column + 1) % 3, (column + 2) % 3);
                let entry = &mut self.mm[AT[row][column]];
                *entry = less(d[k], self.fm[row][j], fma(d[j], self.fm[row][k], *entry));
            }
        }
        for row in 0..3 {
            let (resisted, before) = (AT[row].map(|at| self.ff[at]), [0, 1, 2].map(|column| self.fm[column][row]));
            let shifted = cross_add(d, &resisted, &before);
            (0..3).for_each(|column| self.fm[column][row] = shifted[column]);
        }
        for row in 0..3 {
            let (j, k) = ((row + 1) % 3, (row + 2) % 3);
            for column in row..3 {
                let entry = &mut self.mm[AT[row][column]];
                *entry = less(d[k], self.fm[column][j], fma(d[j], self.fm[column][k], *entry));
            }
        }
    }
}

impl One {
    #[inline(always)]
    fn of(
        place: &Place,
        numbers: &Numbers,
        (force, moment, pivot, u): (LaneVector, LaneVector, Lanes, Lanes),
        digits: &mut Digits,
    ) -> Self {
        if place.is_light {
            digits.sound &= pivot.simd_ge(numbers.least);
        }
        Self { force, moment, inverse: all(1.0) / pivot, u }
    }
}

/// The moment about its axis that a body's velocities and weight ask for, by its numbers in its own axes.
#[inline(always)]
fn axial_moment(numbers: &Numbers, at: &LinkLanes, gravity: &LaneVector) -> Lanes {
    let [xx, xy, xz, yy, yz, _] = numbers.inertia;
    let (w, g) = (transposed_times(&at.turn, &at.angular_velocity), transposed_times(&at.turn, gravity));
    let (c, mass) = (&numbers.center, numbers.mass);
    let gyroscopic = (yy - xx) * w[0] * w[1] + xy * (w[0] * w[0] - w[1] * w[1]) + w[2] * (yz * w[0] - xz * w[1]);
    gyroscopic - mass * (c[0] * g[1] - c[1] * g[0])
}
