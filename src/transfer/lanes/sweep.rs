//! Both sweeps over trees side by side.

use super::carried::{Carried, Digits, One};
use super::tree::Tree;
use crate::spatial::lanes::{
    LaneVector, LaneWrench, Lanes, LinkLanes, WIDTH, all, cross_add, dot, dot_add, fma, scale_add, sum, trace,
};
use crate::transfer::plan::{Kind, To};
use crate::transfer::reduce::SOFT;

/// Scratch of the sweeps, and what the last ones found.
#[derive(Debug, Clone)]
pub struct Sweep {
    links: Vec<LinkLanes>,
    /// The factors of every coordinate.
    ones: Vec<One>,
    joins: Vec<Carried>,
    /// Linear and angular accelerations of the root markers.
    a: Vec<[LaneVector; 2]>,
}

impl Sweep {
    /// Room for the links of a tree.
    pub fn new(tree: &Tree) -> Self {
        let count = tree.places.len();
        Self {
            links: vec![LinkLanes::default(); count],
            ones: vec![One::default(); tree.velocities],
            joins: vec![Carried::default(); tree.joins],
            a: vec![Default::default(); count],
        }
    }

    /// Where the links are and how fast they move at coordinates `q` and velocities `v`, one number of every model each.
    #[inline]
    pub fn place(&mut self, tree: &Tree, q: &[[f64; WIDTH]], v: &[[f64; WIDTH]]) -> &[LinkLanes] {
        tree.place(q, v, &mut self.links);
        &self.links
    }

    /// `q̈` at the last place, eqs. (5) to (8). `applied` has what acts on each link at its root marker, or is empty; `tau` the hinge
    /// forces, one per velocity. Says of every model whether its numbers are good: a pivot that is none, and digits that are lost,
    /// are for [`crate::transfer::Reduction`].
    pub fn accelerations(
        &mut self,
        tree: &Tree,
        applied: &[LaneWrench],
        tau: &[Lanes],
        hinge: &mut [[f64; WIDTH]],
    ) -> [bool; WIDTH] {
        let digits = self.inward(tree, applied, tau);
        self.outward(tree, hinge);
        let mut good = digits.sound.to_bitmask();
        if digits.doubtful.any() {
            good &= !(digits.doubtful & self.softness(tree)).to_bitmask();
        }
        std::array::from_fn(|lane| good & (1 << lane) != 0)
    }

    /// Tips → root.
    fn inward(&mut self, tree: &Tree, applied: &[LaneWrench], tau: &[Lanes]) -> Digits {
        let Self { links, ones, joins, .. } = self;
        let (mut digits, mut carried) = (Digits::new(), Carried::default());
        for (index, (place, numbers)) in tree.places.iter().zip(&tree.numbers).enumerate().skip(1).rev() {
            let (at, velocity) = (&links[index], place.velocity);
            if place.is_leaf {
                carried = Carried::default();
            } else if let Some(join) = place.join {
                carried.add(&joins[join]);
                joins[join] = Carried::default();
            }
            if !place.is_massless {
                carried.with_body(place, numbers, at, &tree.gravity);
            }
            let load = applied.get(index);
            if let Some(load) = load {
                carried.loaded(load);
            }
            let (to_ground, digits) = (matches!(place.to, To::Ground), &mut digits);
            match place.kind {
                Kind::None | Kind::Flex => {}
                Kind::Ball => {
                    let range = velocity..velocity + 3;
                    carried.without_ball(place, numbers, at, &tau[range.clone()], digits, &mut ones[range]);
                }
                _ if place.translates => {
                    ones[velocity] = carried.translation(place, numbers, &at.axis, tau[velocity], digits);
                }
                _ => {
                    let one = match place.is_slender {
                        true => carried.slender(place, numbers, (at, &tree.gravity, load), tau[velocity], digits),
                        false => carried.factors(place, numbers, &at.axis, tau[velocity], digits),
                    };
                    if !to_ground {
                        carried.without(&one);
                    }
                    ones[velocity] = one;
                }
            }
            if !to_ground && !place.translates {
                carried.shift(at);
            }
            if let To::Join(join) = place.to {
                joins[join as usize].add(&carried);
            }
        }
        digits
    }

    /// Root → tips: eq. (8).
    fn outward(&mut self, tree: &Tree, hinge: &mut [[f64; WIDTH]]) {
        let Self { links, ones, a, .. } = self;
        for (index, (place, numbers)) in tree.places.iter().zip(&tree.numbers).enumerate().skip(1) {
            let (before, from_here) = a.split_at_mut(index);
            let (parent, at, own) = (&before[place.parent], &links[index], &mut from_here[0]);
            let velocity = place.velocity;
            inboard(parent, at, own);
            match place.kind {
                Kind::None | Kind::Flex => {}
                Kind::Ball => {
                    for i in (0..3).rev() {
                        let second = ones[velocity + i].accelerate(own);
                        own[1] = scale_add(second, &at.turn[i], &own[1]);
                        hinge[velocity + i] = second.to_array();
                    }
                }
                kind => {
                    let second = ones[velocity].accelerate(own);
                    hinge[velocity] = second.to_array();
                    match kind {
                        Kind::Slide => own[0] = scale_add(second, &at.axis, &own[0]),
                        Kind::Screw => {
                            own[0] = scale_add(numbers.pitch * second, &at.axis, &own[0]);
                            own[1] = scale_add(second, &at.axis, &own[1]);
                        }
                        _ => own[1] = scale_add(second, &at.axis, &own[1]),
                    }
                }
            }
        }
    }

    /// The models in which the last solution moves links in a way that hardly anything resists: a mask.
    #[cold]
    #[inline(never)]
    fn softness(&self, tree: &Tree) -> Lanes {
        let resisted = self.ones.iter().fold(all(0.0), |sum, one| fma(one.u * one.u, one.inverse, sum));
        let seen = tree
            .numbers
            .iter()
            .zip(&self.a)
            .fold(all(0.0), |sum, (numbers, a)| fma(trace(&numbers.inertia), dot(&a[1], &a[1]), sum));
        resisted.simd_lt(all(SOFT) * seen)
    }
}

/// `X(d) a_P + γ`
#[inline(always)]
fn inboard(parent: &[LaneVector; 2], at: &LinkLanes, own: &mut [LaneVector; 2]) {
    own[0] = cross_add(&parent[1], &at.arm, &sum(&parent[0], &at.bias));
    own[1] = sum(&parent[1], &at.angular_bias);
}

impl One {
    /// Eq. (8) for this coordinate.
    #[inline(always)]
    fn accelerate(&self, a: &[LaneVector; 2]) -> Lanes {
        self.inverse * (self.u - dot_add(&self.force, &a[0], dot(&self.moment, &a[1])))
    }
}
