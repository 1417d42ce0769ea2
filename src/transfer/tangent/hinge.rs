//! One hinge at the point of the tangent, and the factors of its elimination.

use super::At;
use super::parts::{ACCELERATIONS, Block, Carried, PLACES, RATES, Varied};
use super::pivots::Pivots;
use crate::motion::LinkMotion;
use crate::spatial::quad::{Columns, Quad};
use crate::transfer::LinkAcceleration;
use crate::transfer::plan::Kind;
use nalgebra::{Matrix3, Vector3};

/// What the sweeps of the tangent keep of a hinge; of a ball the rest is in [`Three`].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Left {
    pub(super) axis: Quad,
    /// From the parent's root marker.
    pub(super) arm: Vector3<f64>,
    /// How fast the arm changes: `s = ω_P × d + slip`.
    pub(super) swing: Vector3<f64>,
    /// `w`: force and moment.
    pub(super) w: (Quad, Quad),
    /// `D⁻¹`.
    pub(super) inverse: f64,
    pub(super) u: f64,
    pub(super) h: Varied,
    pub(super) row: Varied,
}

/// Which way a hinge of one coordinate goes: `H = [n; 0]` of a slide, else `[p n; n]`, with `p = 0` for a turn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    pub(super) slides: bool,
    /// `p` (m/rad).
    pub(super) pitch: f64,
}

impl Way {
    /// Of a link; `pitches` has one number per link if there are screws.
    #[inline(always)]
    pub(super) fn of(kind: Kind, pitches: &[f64], link: usize) -> Self {
        Self { slides: kind == Kind::Slide, pitch: if kind == Kind::Screw { pitches[link] } else { 0.0 } }
    }

    /// `Hᵀ f`.
    #[inline(always)]
    pub(super) fn project(self, n: Quad, force: Quad, moment: Quad) -> f64 {
        let about = n.dot(if self.slides { force } else { moment });
        if self.pitch == 0.0 { about } else { about + self.pitch * n.dot(force) }
    }
}

/// The factors of an eliminated ball, inertial axes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Three {
    /// `inertial_from_link`.
    pub(super) turn: Matrix3<f64>,
    /// `D`, factorized; `None` for a ball that is held.
    pub(super) pivots: Option<Pivots>,
    /// Of `w` the force part, times `Q U⁻¹`.
    pub(super) force: Columns,
    /// `D` less the moment part of `w`, times `Q U⁻¹`.
    pub(super) kept: Columns,
    /// `L⁻¹ P u`.
    pub(super) u: Quad,
    /// `h` of `δ'r̈`, `δ'ω̇` and `δ'ω`.
    pub(super) h: [Columns; 3],
    /// Of each part of `z` the moments of `S`, times `L⁻¹ P`.
    pub(super) row: Carried,
}

/// What the columns `h` of eq. (2) are made of: velocities and accelerations on both sides of a hinge.
pub(super) struct Around {
    /// `ω_P`, `ω̇_P`.
    w: Quad,
    dw: Quad,
    /// `ω`.
    own: Quad,
    /// `r̈ − g`.
    pub(super) b: Quad,
    c1: f64,
    c2: f64,
}

impl Around {
    #[inline(always)]
    pub(super) fn new(
        at: &At<'_>,
        (link, own): (&LinkAcceleration, &LinkMotion),
        parent: usize,
        gravity: &Vector3<f64>,
    ) -> Self {
        Self {
            w: Quad::of(&at.motion.links[parent].angular_velocity),
            dw: Quad::of(&at.balance.accelerations[parent].angular),
            own: Quad::of(&own.angular_velocity),
            b: Quad::of(&link.linear) - Quad::of(gravity),
            c1: at.c1,
            c2: at.c2,
        }
    }

    /// `s = ω_P × d + slip`.
    #[inline(always)]
    pub(super) fn swing(&self, own: &LinkMotion, way: Way) -> Vector3<f64> {
        let swing = self.w.cross(Quad::of(&own.arm));
        if way.slides {
            (swing + Quad::of(&own.relative)).vector()
        } else if way.pitch != 0.0 {
            Quad::all(way.pitch).times_add(Quad::of(&own.relative), swing).vector()
        } else {
            swing.vector()
        }
    }

    /// `h` of a turn about, or a slide along, `n`, or of both.
    #[inline(always)]
    pub(super) fn one<const PARTS: u8>(&self, n: Quad, way: Way) -> Varied {
        let (c1, c2) = (Quad::all(self.c1), Quad::all(self.c2));
        // c₂ n + 2 c₁ ω_P×n + ω̇_P×n + ω_P×(ω_P×n)
        let mut h = Varied::default();
        let accelerated = |swept: Quad| self.w.cross_add(swept, self.dw.cross_add(n, c2 * n)) + (c1 + c1) * swept;
        let still = || self.dw.cross_add(n, c2 * n);
        let swept = if PARTS & RATES != 0 { self.w.cross(n) } else { Quad::default() };
        let accelerated = if PARTS & RATES != 0 { accelerated(swept) } else { still() };
        if way.slides {
            h.linear = accelerated;
            (h.place, h.speed) = (n, c1.times_add(n, swept));
        } else {
            h.linear = self.b.cross(n);
            h.angular = accelerated;
            h.rate = c1.times_add(n, swept);
            h.turn = n;
            if way.pitch != 0.0 {
                let p = Quad::all(way.pitch);
                h.linear = p.times_add(accelerated, h.linear);
                (h.place, h.speed) = (p * n, p * h.rate);
            }
        }
        h
    }

    /// `h` of a ball, inertial axes: of `δ'r̈`, `δ'ω̇` and `δ'ω`.
    pub(super) fn three(&self) -> [Columns; 3] {
        let none = Columns::default();
        let c1 = Quad::all(self.c1);
        // c₂ 1 + [ω̇_P + c₁ (ω_P + ω)]× + ω_P ω_Pᵀ − |ω_P|² 1
        let turning = none.minus_cross_of(-(self.dw + c1 * (self.w + self.own))).minus_dyad(-self.w, self.w);
        [
            none.minus_cross_of(-self.b),
            turning.plus_scalar(Quad::all(self.c2 - self.w.dot(self.w))),
            none.minus_cross_of(-self.w).plus_scalar(c1),
        ]
    }
}

impl Left {
    /// `T z_P` of eq. (2).
    #[inline(always)]
    pub(super) fn carry<const PARTS: u8>(&self, p: &Varied) -> Varied {
        let (d, mut z) = (Quad::of(&self.arm), *p);
        z.linear = p.angular.cross_add(d, p.linear);
        if PARTS & PLACES != 0 {
            z.place = p.turn.cross_add(d, p.place);
        }
        if PARTS & RATES != 0 {
            let s = Quad::of(&self.swing);
            z.linear = p.rate.cross_add(s + s, z.linear);
            if PARTS & PLACES != 0 {
                z.speed = p.rate.cross_add(d, p.turn.cross_add(s, p.speed));
            }
        }
        z
    }
}

impl Three {
    /// `z += h φ`.
    #[inline]
    pub(super) fn turn_by(&self, z: &mut Varied, phi: Quad) {
        let [linear, angular, rate] = &self.h;
        let by = phi.vector();
        z.linear = linear.times_add(&by, z.linear);
        z.angular = angular.times_add(&by, z.angular);
        z.rate = rate.times_add(&by, z.rate);
        z.turn += phi;
    }

    /// `L⁻¹ P row z`.
    #[inline]
    pub(super) fn seen<const PARTS: u8>(&self, z: &Varied) -> Quad {
        self.row.times::<PARTS>(z).1
    }

    /// `S h`.
    #[inline]
    pub(super) fn reach<const PARTS: u8>(&self, S: &Carried) -> Block {
        let [linear, angular, rate] = &self.h;
        let mut reach = if PARTS & PLACES != 0 { S.turn } else { Block::default() };
        let mut add = |part: &Block, h: &Columns| {
            reach.force += part.force.by(h);
            reach.moment += part.moment.by(h);
        };
        if PARTS & ACCELERATIONS != 0 {
            add(&S.linear, linear);
            add(&S.angular, angular);
        }
        if PARTS & RATES != 0 {
            add(&S.rate, rate);
        }
        reach
    }
}
