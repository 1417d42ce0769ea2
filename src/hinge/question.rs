//! What a kind of hinge answers.

use super::axes::{Say, check_axis, frame};
use super::joint::Joint;
use nalgebra::{UnitQuaternion, Vector3};

/// Names and units of coordinates or velocities, in their order.
pub type Names = &'static [(&'static str, &'static str)];

/// The motion that a kind of hinge leaves free. Axes are in the hinge frame and need not be unit length.
pub trait Freedom: Sized {
    /// Name in scenario files.
    const NAME: &'static str;
    /// What it does, for the reference of scenario files.
    const DOC: &'static str;
    /// What it does in a loop that it closes, for the reference; `None` if it closes nothing.
    const CLOSES: Option<&'static str>;
    /// How many axes files give: one by `axis`, two by `axes`.
    const AXES: usize = 0;
    /// Coordinates: angles (rad) and distances (m), then the four numbers of a quaternion (unit 1) if there is one.
    const POSITIONS: Names;
    /// Velocities: as many as angles and distances, then three (rad/s) if there is a quaternion.
    const VELOCITIES: Names;
    /// The order of coordinates and of velocities, for messages; `None` for hinges with one or none.
    const ORDER: Option<[&'static str; 2]> = None;

    /// From the keys of a file.
    fn read(keys: &dyn Keys) -> Self;

    /// Its coordinates: [`Freedom::POSITIONS`], if its numbers do not give it more.
    fn positions(&self) -> Names {
        Self::POSITIONS
    }

    /// Its velocities: [`Freedom::VELOCITIES`], if its numbers do not give it more.
    fn velocities(&self) -> Names {
        Self::VELOCITIES
    }

    /// [`Freedom::ORDER`], if its numbers do not give it more coordinates.
    fn order(&self) -> Option<[&'static str; 2]> {
        Self::ORDER
    }

    /// Says what is wrong with its numbers; `owner` is "hinge of …" or "loop …". Every axis must have a direction.
    fn check(&self, owner: &str, say: Say<'_>) {
        self.axes().iter().for_each(|axis| check_axis(axis, owner, say));
    }

    /// The axes along which it slides or about which it turns, of any length; none if no direction is special.
    fn axes(&self) -> Vec<Vector3<f64>> {
        Vec::new()
    }

    /// Its elementary joints in outboard order, each with the axes of its link: `hinge_from_link`. `rest` holds the
    /// coordinates at which its spring is relaxed, or nothing.
    fn elementary(&self, rest: &[f64]) -> Vec<(Joint, UnitQuaternion<f64>)>;

    /// The conditions under which two frames stand to each other as this hinge lets them: what it forbids in a closed loop.
    fn conditions(&self) -> Vec<Condition>;

    /// Directions that both frames share whatever the hinge does. Its conditions alone let them point against each other.
    fn shared(&self) -> Vec<Vector3<f64>> {
        self.axes()
    }
}

/// The keys of a hinge that only some kinds have. What could not be read has been said already, and a value that is
/// allowed stands in for it.
pub trait Keys {
    /// `axis`.
    fn axis(&self) -> Vector3<f64>;
    /// `axes`.
    fn axes(&self) -> [Vector3<f64>; 2];
    /// `pitch` (m/rad).
    fn pitch(&self) -> f64;
    /// `turn` of a curve.
    fn turn(&self) -> Option<&str>;
}

/// One condition on two frames, `a` on the first body and `b` on the second, between the origins of which `d` lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Condition {
    /// No distance along an axis of the first frame: `axis·d = 0`.
    Along(Vector3<f64>),
    /// A fixed angle between a unit vector of the first frame and one of the second: `first·second = cosine`.
    Aligned {
        /// Unit vector in the first frame.
        first: Vector3<f64>,
        /// Unit vector in the second frame.
        second: Vector3<f64>,
        /// Cosine of the angle between them.
        cosine: f64,
    },
    /// A distance along an axis that goes with the angle about it, up to full turns: `axis·d = pitch φ`, see [`Twist`].
    ///
    /// [`Twist`]: crate::spatial::twist::Twist
    Thread {
        /// Unit vector of the axis, in both frames.
        axis: Vector3<f64>,
        /// A unit vector across it, in both frames: the angle is measured between the two.
        across: Vector3<f64>,
        /// (m/rad)
        pitch: f64,
    },
}

impl Condition {
    /// The two unit vectors stay perpendicular.
    pub fn perpendicular(first: Vector3<f64>, second: Vector3<f64>) -> Self {
        Self::Aligned { first, second, cosine: 0.0 }
    }

    /// Both origins coincide.
    pub(super) fn together() -> [Self; 3] {
        frame().map(Self::Along)
    }

    /// The second origin is on an axis of the first frame; of [`around`](super::axes::around) the axis.
    pub(super) fn on_line([t, u, _]: [Vector3<f64>; 3]) -> [Self; 2] {
        [t, u].map(Self::Along)
    }

    /// Both frames share an axis.
    pub(super) fn upright([t, u, n]: [Vector3<f64>; 3]) -> [Self; 2] {
        [Self::perpendicular(t, n), Self::perpendicular(u, n)]
    }

    /// Both frames share all axes.
    pub(super) fn parallel([t, u, n]: [Vector3<f64>; 3]) -> [Self; 3] {
        [(t, u), (u, n), (n, t)].map(|(a, b)| Self::perpendicular(a, b))
    }
}
