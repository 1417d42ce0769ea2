//! Hinges as geometric conditions, differentiated twice: a product `u·w` of two vectors that bodies carry, or of such a
//! vector and the distance between two carried points, keeps its value (or changes as the hinge coordinate does).

use super::place::{self, Placed};
use super::{acceleration_of, force_of, moment_of, spin_of};
use nalgebra::Vector3;
use stillpoint::model::description::{Description, HingeKind};

/// A linear expression in the unknowns: column and factor, and a constant.
#[derive(Debug, Clone, Default)]
pub(super) struct Form {
    pub(super) terms: Vec<(usize, f64)>,
    pub(super) rest: f64,
}

impl Form {
    pub(super) fn times(&self, factor: f64) -> Self {
        Self { terms: self.terms.iter().map(|(column, x)| (*column, factor * x)).collect(), rest: factor * self.rest }
    }

    fn plus(mut self, other: Self) -> Self {
        self.terms.extend(other.terms);
        self.rest += other.rest;
        self
    }

    fn plus_constant(mut self, constant: f64) -> Self {
        self.rest += constant;
        self
    }
}

/// A motion that a hinge leaves free.
pub(super) struct Freedom {
    /// q̈ in terms of the accelerations of the two bodies.
    pub(super) acceleration: Form,
    /// The part of the hinge's force or moment that does work on it.
    pub(super) force: Vec<(usize, f64)>,
}

/// The six conditions of a hinge.
pub(super) struct Conditions {
    pub(super) forbidden: Vec<Form>,
    pub(super) free: Vec<Freedom>,
}

/// A body that takes part in a hinge; `index` is `None` for the ground, which does not accelerate.
#[derive(Clone, Copy)]
struct Side {
    index: Option<usize>,
    at: Placed,
}

impl Side {
    /// `along · (second derivative of the material point that is at `point`)`.
    fn point(&self, point: &Vector3<f64>, along: &Vector3<f64>) -> Form {
        let Some(index) = self.index else { return Form::default() };
        let (arm, spin) = (point - self.at.center, self.at.spin);
        let mut terms = dotted(acceleration_of(index), along);
        terms.extend(dotted(spin_of(index), &arm.cross(along)));
        Form { terms, rest: along.dot(&spin.cross(&spin.cross(&arm))) }
    }

    /// `along · (second derivative of a vector that the body carries)`.
    fn arrow(&self, carried: &Vector3<f64>, along: &Vector3<f64>) -> Form {
        let Some(index) = self.index else { return Form::default() };
        let spin = self.at.spin;
        let terms = dotted(spin_of(index), &carried.cross(along));
        Form { terms, rest: along.dot(&spin.cross(&spin.cross(carried))) }
    }
}

/// The two bodies of a hinge and its frame on the first one.
struct Pair {
    parent: Side,
    child: Side,
    origin: Vector3<f64>,
}

impl Pair {
    /// Second derivative of `u·w`, `u` carried by the parent and `w` by the child.
    fn angle(&self, u: &Vector3<f64>, w: &Vector3<f64>) -> Form {
        let rates = self.parent.at.spin.cross(u).dot(&self.child.at.spin.cross(w));
        self.parent.arrow(u, w).plus(self.child.arrow(w, u)).plus_constant(2.0 * rates)
    }

    /// Second derivative of `u·(root marker of the child − hinge point on the parent)`, `u` carried by the parent.
    fn distance(&self, u: &Vector3<f64>) -> Form {
        let between = self.child.at.position - self.origin;
        let rate = self.child.at.velocity - self.parent.at.velocity_at(&self.origin);
        self.child
            .point(&self.child.at.position, u)
            .plus(self.parent.point(&self.origin, u).times(-1.0))
            .plus(self.parent.arrow(u, &between))
            .plus_constant(2.0 * self.parent.at.spin.cross(u).dot(&rate))
    }

    /// `u·(angular acceleration of the child relative to the parent, seen from the parent)`.
    fn turn(&self, u: &Vector3<f64>) -> Form {
        let spin = self.parent.at.spin;
        let mut terms = Vec::new();
        for (side, sign) in [(&self.child, 1.0), (&self.parent, -1.0)] {
            if let Some(index) = side.index {
                terms.extend(dotted(spin_of(index), &(sign * u)));
            }
        }
        Form { terms, rest: -u.dot(&spin.cross(&(self.child.at.spin - spin))) }
    }

    fn slides(&self, u: &Vector3<f64>) -> Freedom {
        let child = self.child.index.expect("a child is a body");
        Freedom { acceleration: self.distance(u), force: dotted(force_of(child), u) }
    }

    /// A turn whose coordinate is the component of the relative angular velocity along `u`, the moment along `n`.
    fn turns(&self, u: &Vector3<f64>, n: &Vector3<f64>) -> Freedom {
        let child = self.child.index.expect("a child is a body");
        Freedom { acceleration: self.turn(u), force: dotted(moment_of(child), n) }
    }
}

fn dotted(column: usize, factors: &Vector3<f64>) -> Vec<(usize, f64)> {
    (0..3).map(|i| (column + i, factors[i])).collect()
}

/// Two unit vectors that span the plane across `n`.
fn across(n: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let least = Vector3::ith(n.iamin(), 1.0);
    let first = n.cross(&least).normalize();
    [first, n.cross(&first)]
}

/// What the hinge of a body forbids and what it leaves free.
pub(super) fn conditions(description: &Description, placed: &[Placed], body: usize) -> Conditions {
    let hinge = &description.bodies[body].hinge;
    let parent = place::named(description, &hinge.parent);
    let parent = Side { index: parent, at: parent.map_or(Placed::GROUND, |index| placed[index]) };
    let (axes, origin) = place::hinge_frame(description, hinge, &parent.at);
    let pair = Pair { parent, child: Side { index: Some(body), at: placed[body] }, origin };
    let [x, y, z] = [0, 1, 2].map(|i| axes.column(i).into_owned());
    let of_child = [0, 1, 2].map(|i| placed[body].turn.column(i).into_owned());
    let in_world = |axis: &Vector3<f64>| (axes * axis).normalize();
    let together = || [x, y, z].iter().map(|u| pair.distance(u)).collect::<Vec<_>>();
    let parallel = || vec![pair.angle(&x, &of_child[1]), pair.angle(&x, &of_child[2]), pair.angle(&y, &of_child[2])];
    // The child's copy of an axis that both bodies carry is where the parent's is.
    let upright = |n: &Vector3<f64>| across(n).iter().map(|u| pair.angle(u, n)).collect::<Vec<_>>();
    let on_line = |n: &Vector3<f64>| across(n).iter().map(|u| pair.distance(u)).collect::<Vec<_>>();
    let (forbidden, free) = match &hinge.kind {
        HingeKind::Fixed => ([together(), parallel()].concat(), vec![]),
        HingeKind::Revolute { axis } => {
            let n = in_world(axis);
            ([together(), upright(&n)].concat(), vec![pair.turns(&n, &n)])
        }
        HingeKind::Prismatic { axis } => {
            let n = in_world(axis);
            ([on_line(&n), parallel()].concat(), vec![pair.slides(&n)])
        }
        HingeKind::Screw { axis, pitch } => {
            let n = in_world(axis);
            let thread = pair.distance(&n).plus(pair.turn(&n).times(-pitch));
            let mut screws = pair.turns(&n, &n);
            screws.force.extend(dotted(force_of(body), &(*pitch * n)));
            ([on_line(&n), upright(&n), vec![thread]].concat(), vec![screws])
        }
        HingeKind::Cylindrical { axis } => {
            let n = in_world(axis);
            ([on_line(&n), upright(&n)].concat(), vec![pair.slides(&n), pair.turns(&n, &n)])
        }
        HingeKind::Universal { axes: [first, second] } => {
            let first = in_world(first);
            // A turn about it leaves it in place in the child, where it is what it was in the hinge frame.
            let second = (placed[body].turn * second).normalize();
            let plane = first.cross(&second);
            let duals = [second.cross(&plane), plane.cross(&first)].map(|dual| dual / plane.norm_squared());
            (
                [together(), vec![pair.angle(&first, &second)]].concat(),
                vec![pair.turns(&duals[0], &first), pair.turns(&duals[1], &second)],
            )
        }
        HingeKind::Along { .. } => unreachable!("`guides` has an oracle of its own"),
        HingeKind::Planar => (
            vec![pair.distance(&z), pair.angle(&x, &z), pair.angle(&y, &z)],
            vec![pair.slides(&x), pair.slides(&y), pair.turns(&z, &z)],
        ),
        HingeKind::Spherical => (together(), of_child.iter().map(|n| pair.turns(n, n)).collect()),
        HingeKind::Free => {
            let turns = of_child.iter().map(|n| pair.turns(n, n));
            (vec![], [x, y, z].iter().map(|n| pair.slides(n)).chain(turns).collect())
        }
    };
    Conditions { forbidden, free }
}
