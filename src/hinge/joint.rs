//! The elementary joints that hinges consist of.

use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};

/// The elementary joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Joint {
    /// The ground's.
    None,
    /// A turn about the z axis of the link: links that turn have their axes chosen so. One angle (rad).
    Turn,
    /// A slide along a unit axis of the hinge frame. One distance (m).
    Slide {
        /// Unit axis.
        axis: Vector3<f64>,
    },
    /// A turn about the z axis of the link that slides along it by `pitch` per radian. One angle (rad).
    Screw {
        /// Distance along the axis for a turn by 1 rad (m/rad), not zero; negative for a left-hand thread.
        pitch: f64,
    },
    /// Any turn. Four numbers (unit quaternion w, x, y, z: `hinge_from_link`), three velocities (relative angular
    /// velocity, link axes).
    Ball {
        /// Where its torsion spring is relaxed.
        rest: UnitQuaternion<f64>,
    },
    /// Along a curve: an element ([`Joint::rod`]) of one coordinate, an arc length (m).
    Along {
        /// Index of the element.
        rod: usize,
    },
    /// A modal body: its link's frame is that of the body's root interface, and it has the body's own coordinates, which move the
    /// interfaces and not this link.
    Modal {
        /// Index of the modal body.
        modal: usize,
        /// Number of its coordinates.
        count: usize,
    },
    /// An interface of a modal body, whose link is the parent: without coordinates of its own.
    Interface {
        /// Index of the modal body.
        modal: usize,
        /// Index of the interface, the root not counted.
        tip: usize,
    },
    /// A flexible element: its link's root marker is the element's tip. As many coordinates as velocities, lengths (m) and
    /// angles (rad) over the element.
    Flex {
        /// Index of the element.
        rod: usize,
        /// Number of its coordinates.
        count: usize,
    },
}

impl Joint {
    /// Number of coordinates and of velocities.
    #[inline]
    pub fn counts(&self) -> (usize, usize) {
        match self {
            Self::None | Self::Interface { .. } => (0, 0),
            Self::Turn | Self::Slide { .. } | Self::Screw { .. } | Self::Along { .. } => (1, 1),
            Self::Ball { .. } => (4, 3),
            Self::Flex { count, .. } | Self::Modal { count, .. } => (*count, *count),
        }
    }

    /// Whether it turns about an axis and does nothing else: a full turn leads back.
    #[inline]
    pub fn is_turn(&self) -> bool {
        matches!(self, Self::Turn)
    }

    /// Whether its coordinate is an angle.
    #[inline]
    pub fn is_angle(&self) -> bool {
        matches!(self, Self::Turn | Self::Screw { .. })
    }

    /// Whether it slides along an axis.
    #[inline]
    pub fn is_slide(&self) -> bool {
        matches!(self, Self::Slide { .. })
    }

    /// Whether its coordinate is a distance: along an axis or along a curve.
    #[inline]
    pub fn is_distance(&self) -> bool {
        matches!(self, Self::Slide { .. } | Self::Along { .. })
    }

    /// The axis of a slide (unit vector, hinge frame).
    #[inline]
    pub fn slide_axis(&self) -> Option<&Vector3<f64>> {
        if let Self::Slide { axis } = self { Some(axis) } else { None }
    }

    /// How far it slides along its axis for a turn by 1 rad (m/rad); 0 for all but screws.
    #[inline]
    pub fn pitch(&self) -> f64 {
        if let Self::Screw { pitch } = self { *pitch } else { 0.0 }
    }

    /// Whether its coordinates are a quaternion.
    #[inline]
    pub fn is_ball(&self) -> bool {
        matches!(self, Self::Ball { .. })
    }

    /// Whether it lets the link turn.
    #[inline]
    pub fn turns(&self) -> bool {
        self.is_angle()
            || self.is_ball()
            || self.is_flex()
            || matches!(self, Self::Along { .. } | Self::Interface { .. })
    }

    /// Whether its coordinates are those of a flexible element or of a modal body.
    #[inline]
    pub fn is_flex(&self) -> bool {
        matches!(self, Self::Flex { .. } | Self::Modal { .. })
    }

    /// The index of its modal body, if its coordinates are those of one.
    #[inline]
    pub fn modal(&self) -> Option<usize> {
        if let Self::Modal { modal, .. } = self { Some(*modal) } else { None }
    }

    /// The indices of a modal body and of its interface that the link is.
    #[inline]
    pub fn interface(&self) -> Option<(usize, usize)> {
        if let Self::Interface { modal, tip } = self { Some((*modal, *tip)) } else { None }
    }

    /// The index of its element, if it is flexible or goes along a curve: its motion subspace depends on its coordinates.
    #[inline]
    pub fn rod(&self) -> Option<usize> {
        if let Self::Flex { rod, .. } | Self::Along { rod } = self { Some(*rod) } else { None }
    }

    /// Where the torsion spring of a ball is relaxed; `None` for others, whose springs belong to their coordinate.
    #[inline]
    pub fn rest(&self) -> Option<&UnitQuaternion<f64>> {
        if let Self::Ball { rest } = self { Some(rest) } else { None }
    }

    /// Whether it has one coordinate, an angle or a distance.
    #[inline]
    pub fn is_scalar(&self) -> bool {
        matches!(self, Self::Turn | Self::Slide { .. } | Self::Screw { .. } | Self::Along { .. })
    }

    /// The size of a displacement that counts as one: `length` (m) for a distance, 1 rad for angles.
    #[inline]
    pub fn unit(&self, length: f64) -> f64 {
        if self.is_distance() { length } else { 1.0 }
    }

    /// The link in its hinge frame, at its coordinates; `None` of an element, which its own numbers place.
    pub fn pose(&self, q: &[f64]) -> Option<Isometry3<f64>> {
        let about_z = |angle: f64| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
        let shifted = |by: Vector3<f64>, turn| Isometry3::from_parts(by.into(), turn);
        match self {
            Self::None => Some(Isometry3::identity()),
            Self::Turn => Some(shifted(Vector3::zeros(), about_z(q[0]))),
            Self::Slide { axis } => Some(shifted(q[0] * axis, UnitQuaternion::identity())),
            Self::Screw { pitch } => Some(shifted(pitch * q[0] * Vector3::z(), about_z(q[0]))),
            Self::Ball { .. } => Some(shifted(Vector3::zeros(), quaternion(q))),
            Self::Flex { .. } | Self::Along { .. } | Self::Modal { .. } | Self::Interface { .. } => None,
        }
    }

    /// A turn about an axis of the hinge frame, with the axes of its link.
    pub(super) fn turn(axis: &Vector3<f64>) -> (Self, UnitQuaternion<f64>) {
        (Self::Turn, axes_about(&axis.normalize()))
    }

    /// A slide along an axis of the hinge frame, with the axes of its link.
    pub(super) fn slide(axis: &Vector3<f64>) -> (Self, UnitQuaternion<f64>) {
        (Self::Slide { axis: axis.normalize() }, UnitQuaternion::identity())
    }

    /// A turn about an axis of the hinge frame that slides along it by `pitch` (m/rad), with the axes of its link.
    pub(super) fn screw(axis: &Vector3<f64>, pitch: f64) -> (Self, UnitQuaternion<f64>) {
        (Self::Screw { pitch }, axes_about(&axis.normalize()))
    }

    /// Any turn, relaxed at a quaternion or at none, with the axes of its link.
    pub(super) fn ball(rest: &[f64]) -> (Self, UnitQuaternion<f64>) {
        (Self::Ball { rest: quaternion(rest) }, UnitQuaternion::identity())
    }
}

/// The unit quaternion of four numbers w, x, y, z; the identity of none.
pub(crate) fn quaternion(list: &[f64]) -> UnitQuaternion<f64> {
    match list {
        [w, x, y, z] => UnitQuaternion::from_quaternion(Quaternion::new(*w, *x, *y, *z)),
        _ => UnitQuaternion::identity(),
    }
}

/// Axes whose z is the given unit axis: `hinge_from_link`. For an axis of the hinge frame itself nothing is rounded.
fn axes_about(axis: &Vector3<f64>) -> UnitQuaternion<f64> {
    let half = |i, j, k| UnitQuaternion::from_quaternion(Quaternion::new(0.5, 0.5 * i, 0.5 * j, 0.5 * k));
    match <[f64; 3]>::from(*axis) {
        [1.0, 0.0, 0.0] => half(1.0, 1.0, 1.0),
        [-1.0, 0.0, 0.0] => half(1.0, -1.0, -1.0),
        [0.0, 1.0, 0.0] => half(-1.0, -1.0, -1.0),
        [0.0, -1.0, 0.0] => half(1.0, -1.0, 1.0),
        // From z, or from −z after a half turn about x: half the way there, whichever is nearer.
        [x, y, z] if z >= 0.0 => UnitQuaternion::from_quaternion(Quaternion::new(1.0 + z, -y, x, 0.0)),
        [x, y, z] => {
            let half_turn = UnitQuaternion::from_quaternion(Quaternion::new(0.0, 1.0, 0.0, 0.0));
            UnitQuaternion::from_quaternion(Quaternion::new(1.0 - z, y, -x, 0.0)) * half_turn
        }
    }
}
