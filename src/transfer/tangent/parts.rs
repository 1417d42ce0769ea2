//! The parts of a marker's varied state, and the matrix that goes with them, in registers of four lanes.

use super::applied::{Applied, Column};
use crate::model::Link;
use crate::motion::LinkMotion;
use crate::spatial::Wrench;
use crate::spatial::quad::{Columns, Quad};
use nalgebra::Vector3;

/// `δ'r̈` and `δ'ω̇`: everywhere but at rest.
pub(super) const ACCELERATIONS: u8 = 1;
/// `δ'ω`: where something moves.
pub(super) const RATES: u8 = 2;
/// `δθ`, `δr` and, with rates, `δv`: where force elements depend on them.
pub(super) const PLACES: u8 = 4;

/// Whether `part` is among the `parts`.
const fn has(parts: u8, part: u8) -> bool {
    parts & part == part
}

/// A varied state `z`, or a row of as many numbers.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Varied {
    /// Of `δ'r̈`.
    pub(super) linear: Quad,
    /// Of `δ'ω̇ − δ'ω × ω`.
    pub(super) angular: Quad,
    /// Of `δ'ω`.
    pub(super) rate: Quad,
    /// Of `δθ`.
    pub(super) turn: Quad,
    /// Of `δr`.
    pub(super) place: Quad,
    /// Of `δv`.
    pub(super) speed: Quad,
}

impl Varied {
    /// `self += s other`.
    #[inline(always)]
    pub(super) fn add_times<const PARTS: u8>(&mut self, s: f64, other: &Self) {
        let s = Quad::all(s);
        if has(PARTS, ACCELERATIONS) {
            self.linear = s.times_add(other.linear, self.linear);
            self.angular = s.times_add(other.angular, self.angular);
        }
        if has(PARTS, RATES) {
            self.rate = s.times_add(other.rate, self.rate);
        }
        if has(PARTS, PLACES) {
            self.turn = s.times_add(other.turn, self.turn);
            self.place = s.times_add(other.place, self.place);
        }
        if has(PARTS, PLACES | RATES) {
            self.speed = s.times_add(other.speed, self.speed);
        }
    }

    /// A row `ρ T` of eq. (2): on the parent's state, `d` away; `s = ω_P × d + slip`.
    #[inline]
    pub(super) fn compose(&mut self, d: &Vector3<f64>, s: &Vector3<f64>) {
        let (d, s) = (Quad::of(d), Quad::of(s));
        // −ρ [d]× = d × ρ
        self.rate = d.cross_add(self.speed, (s + s).cross_add(self.linear, self.rate));
        self.angular = d.cross_add(self.linear, self.angular);
        self.turn = s.cross_add(self.speed, d.cross_add(self.place, self.turn));
    }

    /// `self · other`.
    #[inline(always)]
    pub(super) fn dot<const PARTS: u8>(&self, other: &Self) -> f64 {
        let mut sum = Quad::default();
        if has(PARTS, ACCELERATIONS) {
            sum = self.angular.times_add(other.angular, self.linear * other.linear);
        }
        if has(PARTS, RATES) {
            sum = self.rate.times_add(other.rate, sum);
        }
        if has(PARTS, PLACES) {
            sum = self.place.times_add(other.place, self.turn.times_add(other.turn, sum));
        }
        if has(PARTS, PLACES | RATES) {
            sum = self.speed.times_add(other.speed, sum);
        }
        sum.sum()
    }
}

/// Force and moment from one part of `z`: 6×3.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Block {
    pub(super) force: Columns,
    pub(super) moment: Columns,
}

impl Block {
    #[inline(always)]
    fn of(column: &Column) -> Self {
        Self { force: Columns::of(&column.force), moment: Columns::of(&column.moment) }
    }

    /// `self −= other [d]×`.
    #[inline(always)]
    pub(super) fn minus_cross(&mut self, other: &Self, d: &Vector3<f64>) {
        self.force = self.force.minus_cross(&other.force, d);
        self.moment = self.moment.minus_cross(&other.moment, d);
    }

    /// `sum + self a`.
    #[inline(always)]
    fn times(&self, a: Quad, (force, moment): (Quad, Quad)) -> (Quad, Quad) {
        let a = a.vector();
        (self.force.times_add(&a, force), self.moment.times_add(&a, moment))
    }

    #[inline(always)]
    fn add(&mut self, other: &Self) {
        self.force += other.force;
        self.moment += other.moment;
    }

    #[inline(always)]
    fn take(&mut self, other: &Self) {
        self.force = self.force - other.force;
        self.moment = self.moment - other.moment;
    }
}

/// `S`: the varied wrench of a root marker from its varied state, and what links pass on.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Carried {
    pub(super) linear: Block,
    pub(super) angular: Block,
    pub(super) rate: Block,
    pub(super) turn: Block,
    pub(super) place: Block,
    pub(super) speed: Block,
}

impl Carried {
    /// The blocks of a force element.
    pub(super) fn of(applied: &Applied) -> Self {
        let [turn, place, rate, speed] = applied.map(|column| Block::of(&column));
        Self { turn, place, rate, speed, ..Self::default() }
    }

    /// Changes every block that takes part.
    #[inline(always)]
    pub(super) fn each<const PARTS: u8>(&mut self, mut change: impl FnMut(&mut Block)) {
        if has(PARTS, ACCELERATIONS) {
            change(&mut self.linear);
            change(&mut self.angular);
        }
        if has(PARTS, RATES) {
            change(&mut self.rate);
        }
        if has(PARTS, PLACES) {
            change(&mut self.turn);
            change(&mut self.place);
        }
        if has(PARTS, PLACES | RATES) {
            change(&mut self.speed);
        }
    }

    /// Changes every block that takes part, with its partner in `other`.
    #[inline(always)]
    pub(super) fn each_with<const PARTS: u8>(&mut self, other: &Self, mut change: impl FnMut(&mut Block, &Block)) {
        if has(PARTS, ACCELERATIONS) {
            change(&mut self.linear, &other.linear);
            change(&mut self.angular, &other.angular);
        }
        if has(PARTS, RATES) {
            change(&mut self.rate, &other.rate);
        }
        if has(PARTS, PLACES) {
            change(&mut self.turn, &other.turn);
            change(&mut self.place, &other.place);
        }
        if has(PARTS, PLACES | RATES) {
            change(&mut self.speed, &other.speed);
        }
    }

    /// `self += other`.
    #[inline(always)]
    pub(super) fn add<const PARTS: u8>(&mut self, other: &Self) {
        self.each_with::<PARTS>(other, Block::add);
    }

    /// `self −= other`.
    #[inline(always)]
    pub(super) fn take<const PARTS: u8>(&mut self, other: &Self) {
        self.each_with::<PARTS>(other, Block::take);
    }

    /// Eq. (1): adds the body, whose root marker accelerates by `b` against free fall.
    #[inline(always)]
    pub(super) fn add_body<const PARTS: u8>(&mut self, link: &Link, at: &LinkMotion, b: Quad) {
        let mass = Quad::all(link.mass);
        let mc = mass * Quad::of(&at.center);
        if has(PARTS, ACCELERATIONS) {
            self.linear.force = self.linear.force.plus_scalar(mass);
            self.linear.moment = self.linear.moment.minus_cross_of(-mc);
            self.angular.force = self.angular.force.minus_cross_of(mc);
            self.angular.moment += Columns::symmetric(&at.inertia);
        } else {
            self.turn.force = self.turn.force.minus_cross_of(-(mass * b));
            // [c]× [b]× = b cᵀ − (c·b) 1
            let across = self.turn.moment.minus_dyad(-b, mc);
            self.turn.moment = across.plus_scalar(Quad::all(-mc.dot(b)));
        }
        if has(PARTS, RATES) {
            let (w, J) = (Quad::of(&at.angular_velocity), Columns::symmetric(&at.inertia));
            self.rate.force = self.rate.force.minus_cross_of(w.cross(mc + mc));
            let spread = (J + J).plus_scalar(-Quad::all(at.inertia.trace()));
            self.rate.moment = self.rate.moment.plus_cross(&at.angular_velocity, &spread);
        }
    }

    /// Adds a slice of a rod with its centre of mass at the marker.
    pub(super) fn add_slice<const PARTS: u8>(&mut self, mass: f64, at: &LinkMotion, b: Quad) {
        let link = Link { mass, ..Link::ground() };
        self.add_body::<PARTS>(&link, at, b);
    }

    /// Takes off what force elements add to a link, on which they push with `wrench`.
    pub(super) fn take_applied<const PARTS: u8>(&mut self, applied: &Applied) {
        let [turn, place, rate, speed] = applied;
        if has(PARTS, RATES) {
            self.rate.take(&Block::of(rate));
        }
        if has(PARTS, PLACES) {
            self.turn.take(&Block::of(turn));
            self.place.take(&Block::of(place));
        }
        if has(PARTS, PLACES | RATES) {
            self.speed.take(&Block::of(speed));
        }
    }

    /// `δ'f = δf − δθ × f` of what pushes on a link.
    pub(super) fn take_turned(&mut self, wrench: &Wrench) {
        self.turn.force = self.turn.force.minus_cross_of(Quad::of(&wrench.force));
        self.turn.moment = self.turn.moment.minus_cross_of(Quad::of(&wrench.moment));
    }

    /// `S z`: force and moment.
    #[inline(always)]
    pub(super) fn times<const PARTS: u8>(&self, z: &Varied) -> (Quad, Quad) {
        let mut sum = (Quad::default(), Quad::default());
        if has(PARTS, ACCELERATIONS) {
            sum = self.angular.times(z.angular, self.linear.times(z.linear, sum));
        }
        if has(PARTS, RATES) {
            sum = self.rate.times(z.rate, sum);
        }
        if has(PARTS, PLACES) {
            sum = self.place.times(z.place, self.turn.times(z.turn, sum));
        }
        if has(PARTS, PLACES | RATES) {
            sum = self.speed.times(z.speed, sum);
        }
        sum
    }

    /// The row `nᵀ S` of the forces or of the moments.
    #[inline(always)]
    pub(super) fn row<const PARTS: u8>(&self, n: Quad, of_force: bool) -> Varied {
        let n = n.vector();
        let row = |block: &Block| match of_force {
            true => block.force.transposed().times(&n),
            false => block.moment.transposed().times(&n),
        };
        let mut out = Varied::default();
        if has(PARTS, ACCELERATIONS) {
            (out.linear, out.angular) = (row(&self.linear), row(&self.angular));
        }
        if has(PARTS, RATES) {
            out.rate = row(&self.rate);
        }
        if has(PARTS, PLACES) {
            (out.turn, out.place) = (row(&self.turn), row(&self.place));
        }
        if has(PARTS, PLACES | RATES) {
            out.speed = row(&self.speed);
        }
        out
    }

    /// `S −= w row / D`.
    #[inline(always)]
    pub(super) fn downdate<const PARTS: u8>(&mut self, (force, moment): (Quad, Quad), inverse: f64, row: &Varied) {
        let inverse = Quad::all(inverse);
        let (force, moment) = (inverse * force, inverse * moment);
        let take = |block: &mut Block, row: Quad| {
            block.force = block.force.minus_dyad(force, row);
            block.moment = block.moment.minus_dyad(moment, row);
        };
        if has(PARTS, ACCELERATIONS) {
            take(&mut self.linear, row.linear);
            take(&mut self.angular, row.angular);
        }
        if has(PARTS, RATES) {
            take(&mut self.rate, row.rate);
        }
        if has(PARTS, PLACES) {
            take(&mut self.turn, row.turn);
            take(&mut self.place, row.place);
        }
        if has(PARTS, PLACES | RATES) {
            take(&mut self.speed, row.speed);
        }
    }

    /// `S T` of eq. (2): from the parent's state, `d` away; `s = ω_P × d + slip`.
    #[inline(always)]
    pub(super) fn compose<const PARTS: u8>(&mut self, d: &Vector3<f64>, s: &Vector3<f64>) {
        if has(PARTS, ACCELERATIONS | RATES) {
            self.rate.minus_cross(&self.linear.clone(), &(s + s));
        }
        if has(PARTS, ACCELERATIONS) {
            self.angular.minus_cross(&self.linear.clone(), d);
        }
        if has(PARTS, PLACES) {
            self.turn.minus_cross(&self.place.clone(), d);
        }
        if has(PARTS, PLACES | RATES) {
            self.turn.minus_cross(&self.speed.clone(), s);
            self.rate.minus_cross(&self.speed.clone(), d);
        }
    }

    /// `Xᵀ S`: the moments gain `d × force`.
    #[inline(always)]
    pub(super) fn shift<const PARTS: u8>(&mut self, d: &Vector3<f64>) {
        self.each::<PARTS>(|block| block.moment = block.moment.plus_cross(d, &block.force));
    }
}
