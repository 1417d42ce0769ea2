//! Where the links are and how fast they move, as [`crate::motion`] has it: eq. (2) root → tips.

use super::tree::{Numbers, Place, Tree};
use crate::motion::sine_and_cosine;
use crate::spatial::lanes::{
    LaneMatrix, LaneVector, Lanes, LinkLanes, WIDTH, all, cross, difference, scale_add, scaled, sum, times, times_add,
};
use crate::transfer::plan::Kind;

impl Tree {
    /// All links at coordinates `q` and velocities `v`, one number of every model each.
    pub(super) fn place(&self, q: &[[f64; WIDTH]], v: &[[f64; WIDTH]], links: &mut [LinkLanes]) {
        for (index, (place, numbers)) in self.places.iter().zip(&self.numbers).enumerate().skip(1) {
            let (before, from_here) = links.split_at_mut(index);
            let (parent, own) = (&before[place.parent], &mut from_here[0]);
            match place.kind {
                Kind::Turn => turn(self, place, numbers, parent, own, &q[place.position], &v[place.velocity]),
                Kind::Slide => slide(self, place, numbers, parent, own, &q[place.position], &v[place.velocity]),
                Kind::Screw => screw(self, place, numbers, parent, own, &q[place.position], &v[place.velocity]),
                Kind::Ball => {
                    let (q, v) = (&q[place.position..place.position + 4], &v[place.velocity..place.velocity + 3]);
                    ball(self, place, numbers, parent, own, q, v);
                }
                Kind::None | Kind::Flex | Kind::Modal | Kind::Interface => {}
            }
        }
    }
}

/// The axes of the hinge and the arm to it.
#[inline(always)]
fn hinge(place: &Place, numbers: &Numbers, parent: &LinkLanes) -> (LaneMatrix, LaneVector) {
    let axes = match place.straight {
        true => parent.turn,
        false => numbers.turn.map(|column| times(&parent.turn, &column)),
    };
    (axes, times(&parent.turn, &numbers.offset))
}

/// Relative to its parent a link turns with `spin`.
#[inline(always)]
fn turns(parent: &LinkLanes, own: &mut LinkLanes, spin: &LaneVector) {
    own.angular_velocity = sum(&parent.angular_velocity, spin);
    own.angular_bias = cross(&parent.angular_velocity, spin);
}

/// Its root marker is carried by `arm`, along which it slides with `slip`.
#[inline(always)]
fn carried(tree: &Tree, parent: &LinkLanes, own: &mut LinkLanes, arm: LaneVector, slip: Option<&LaneVector>) {
    let w = &parent.angular_velocity;
    let swing = cross(w, &arm);
    let (moved, twice) = match slip {
        None => (swing, swing),
        Some(slip) => {
            let moved = sum(&swing, slip);
            (moved, sum(&moved, slip))
        }
    };
    own.bias = cross(w, &twice);
    own.arm = arm;
    if tree.placed {
        own.position = sum(&parent.position, &arm);
        own.velocity = sum(&parent.velocity, &moved);
    }
}

/// The axes of a link after a turn about z.
#[inline(always)]
fn about_z([x, y, z]: &LaneMatrix, angle: Lanes) -> LaneMatrix {
    let (s, c) = sine_and_cosine(angle);
    [scale_add(s, y, &scaled(c, x)), difference(&scaled(c, y), &scaled(s, x)), *z]
}

#[inline(never)]
fn turn(
    tree: &Tree,
    place: &Place,
    numbers: &Numbers,
    parent: &LinkLanes,
    own: &mut LinkLanes,
    q: &[f64; WIDTH],
    v: &[f64; WIDTH],
) {
    let (axes, arm) = hinge(place, numbers, parent);
    own.axis = axes[2];
    own.turn = about_z(&axes, Lanes::new(*q));
    turns(parent, own, &scaled(Lanes::new(*v), &axes[2]));
    carried(tree, parent, own, arm, None);
}

#[inline(never)]
fn slide(
    tree: &Tree,
    place: &Place,
    numbers: &Numbers,
    parent: &LinkLanes,
    own: &mut LinkLanes,
    q: &[f64; WIDTH],
    v: &[f64; WIDTH],
) {
    let (axes, anchor) = hinge(place, numbers, parent);
    own.axis = times(&axes, &numbers.axis);
    own.turn = axes;
    own.angular_velocity = parent.angular_velocity;
    own.angular_bias = [all(0.0); 3];
    let (arm, slip) = (scale_add(Lanes::new(*q), &own.axis, &anchor), scaled(Lanes::new(*v), &own.axis));
    carried(tree, parent, own, arm, Some(&slip));
}

#[inline(never)]
fn screw(
    tree: &Tree,
    place: &Place,
    numbers: &Numbers,
    parent: &LinkLanes,
    own: &mut LinkLanes,
    q: &[f64; WIDTH],
    v: &[f64; WIDTH],
) {
    let (axes, anchor) = hinge(place, numbers, parent);
    own.axis = axes[2];
    own.turn = about_z(&axes, Lanes::new(*q));
    let spin = scaled(Lanes::new(*v), &axes[2]);
    turns(parent, own, &spin);
    let arm = scale_add(numbers.pitch * Lanes::new(*q), &axes[2], &anchor);
    carried(tree, parent, own, arm, Some(&scaled(numbers.pitch, &spin)));
}

#[inline(never)]
fn ball(
    tree: &Tree,
    place: &Place,
    numbers: &Numbers,
    parent: &LinkLanes,
    own: &mut LinkLanes,
    q: &[[f64; WIDTH]],
    v: &[[f64; WIDTH]],
) {
    let (axes, arm) = hinge(place, numbers, parent);
    own.turn = rotation(q).map(|column| times(&axes, &column));
    let relative = [0, 1, 2].map(|i| Lanes::new(v[i]));
    let spin = times_add(&own.turn, &relative, &[all(0.0); 3]);
    turns(parent, own, &spin);
    carried(tree, parent, own, arm, None);
}

/// The rotations of four numbers w, x, y, z, whatever their norm.
#[inline(always)]
fn rotation(q: &[[f64; WIDTH]]) -> LaneMatrix {
    let [w, x, y, z] = [0, 1, 2, 3].map(|i| Lanes::new(q[i]));
    let (one, two) = (all(1.0), all(2.0));
    let s = two / (w * w + x * x + y * y + z * z);
    let square = |a: Lanes, b: Lanes| one - s * (a * a + b * b);
    [
        [square(y, z), s * (x * y + w * z), s * (x * z - w * y)],
        [s * (x * y - w * z), square(x, z), s * (y * z + w * x)],
        [s * (x * z + w * y), s * (y * z - w * x), square(x, y)],
    ]
}
