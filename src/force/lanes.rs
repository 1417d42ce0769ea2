//! Springs and loads of several systems side by side: the laws of [`super::spring`] and [`super::load`], each system with its numbers.

use super::End;
use super::load::LoadLaw;
use super::spring::SpringLaw;
use crate::spatial::lanes::{
    LaneVector, LaneWrench, Lanes, LinkLanes, WIDTH, all, cross, cross_add, difference, dot, each, each_vector, fma,
    scale_add, scaled, sum, times,
};

/// A point on a link.
#[derive(Debug, Clone, Copy)]
struct Point {
    link: usize,
    /// From its root marker, link axes (m).
    at: LaneVector,
}

impl Point {
    fn of(ends: [&End; WIDTH]) -> Option<Self> {
        let link = ends[0].link;
        ends.iter().all(|end| end.link == link).then(|| Self { link, at: each_vector(|lane| ends[lane].point) })
    }

    /// From the link's root marker, inertial axes (m).
    #[inline(always)]
    fn arm(&self, links: &[LinkLanes]) -> LaneVector {
        times(&links[self.link].turn, &self.at)
    }
}

/// A spring and damper between two points.
#[derive(Debug, Clone)]
pub struct SpringLanes {
    ends: [Point; 2],
    stiffness: Lanes,
    length: Lanes,
    damping: Lanes,
}

impl SpringLanes {
    /// One spring of every system; `None` if they are between different links.
    pub fn of(laws: [&SpringLaw; WIDTH]) -> Option<Self> {
        let numbers = laws.map(SpringLaw::numbers);
        let end = |i: usize| Point::of(numbers.each_ref().map(|(ends, _)| &ends[i]));
        let number = |i: usize| each(|lane| numbers[lane].1[i]);
        Some(Self { ends: [end(0)?, end(1)?], stiffness: number(0), length: number(1), damping: number(2) })
    }

    /// Adds what it does to its links, at their root markers.
    #[inline(never)]
    pub fn apply(&self, links: &[LinkLanes], applied: &mut [LaneWrench]) {
        let arms = [0, 1].map(|i| self.ends[i].arm(links));
        let [a, b] = [0, 1].map(|i| &links[self.ends[i].link]);
        let between = difference(&sum(&b.position, &arms[1]), &sum(&a.position, &arms[0]));
        let distance = dot(&between, &between).sqrt();
        let velocity = difference(
            &cross_add(&b.angular_velocity, &arms[1], &b.velocity),
            &cross_add(&a.angular_velocity, &arms[0], &a.velocity),
        );
        // A spring without length has no direction where its points lie on each other, and pulls nowhere.
        let touching = distance.simd_eq(all(0.0)) & self.length.simd_eq(all(0.0));
        let direction = between.map(|x| touching.select(all(0.0), x / distance));
        let rate = dot(&direction, &velocity);
        let along = fma(self.damping, rate, -(self.stiffness * self.length));
        let force = scale_add(self.stiffness, &between, &scaled(along, &direction));
        for (i, sign) in [(0, all(1.0)), (1, all(-1.0))] {
            let on = &mut applied[self.ends[i].link];
            let force = scaled(sign, &force);
            on.force = sum(&on.force, &force);
            on.moment = cross_add(&arms[i], &force, &on.moment);
        }
    }
}

/// A force and a torque that stay the same in inertial axes or in those of their link.
#[derive(Debug, Clone)]
pub struct LoadLanes {
    on: Point,
    force: LaneVector,
    torque: LaneVector,
    follows: bool,
}

impl LoadLanes {
    /// One load of every system; `None` if they are on different links, in different axes or follow a table over time.
    pub fn of(laws: [&LoadLaw; WIDTH]) -> Option<Self> {
        let numbers = laws.map(LoadLaw::numbers);
        let numbers = numbers.into_iter().collect::<Option<Vec<_>>>()?;
        let follows = numbers[0].2;
        let on = Point::of(std::array::from_fn(|lane| &numbers[lane].0))?;
        let part = |i: usize| each_vector(|lane| numbers[lane].1[i]);
        numbers.iter().all(|one| one.2 == follows).then(|| Self { on, force: part(0), torque: part(1), follows })
    }

    /// Adds what it does to its link, at the root marker.
    #[inline(never)]
    pub fn apply(&self, links: &[LinkLanes], applied: &mut [LaneWrench]) {
        let (turn, arm) = (&links[self.on.link].turn, self.on.arm(links));
        let (force, torque) = match self.follows {
            true => (times(turn, &self.force), times(turn, &self.torque)),
            false => (self.force, self.torque),
        };
        let on = &mut applied[self.on.link];
        on.force = sum(&on.force, &force);
        on.moment = sum(&on.moment, &sum(&torque, &cross(&arm, &force)));
    }
}
