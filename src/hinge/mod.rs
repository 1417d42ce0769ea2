//! The kinds of hinge: one file each, named once in the list below.
//!
//! A kind answers [`Freedom`]: its coordinates and velocities with their units, the elementary joints ([`Joint`]) that the
//! sweeps of the tree know, the conditions under which it closes a loop, its axes and their check, and how files write it.
//! [`HingeKind`] holds one of any kind and passes each question on.

mod axes;
mod declared;
pub mod joint;
pub mod question;

pub use along::AlongTurn;
pub use axes::Say;
pub use declared::{Declared, Which, count, names};
pub use joint::Joint;
pub use question::{Condition, Freedom, Keys, Names};

use nalgebra::{UnitQuaternion, Vector3};

macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident $({ $($(#[$of:meta])* $field:ident: $type:ty),+ })? in $module:ident),+ $(,)?) => {
        $(pub mod $module;)+

        /// The motions a hinge can leave free. Axes are in the hinge frame and need not be unit length.
        ///
        /// | kind | coordinates | velocities |
        /// |---|---|---|
        /// | fixed | – | – |
        /// | revolute | angle | rate |
        /// | prismatic | distance | rate |
        /// | screw | angle; the distance along the axis is `pitch` times it | rate |
        /// | along | arc length; if it turns freely about the tangent, that angle | rates |
        /// | cylindrical | distance, angle | rates |
        /// | universal | angle about the first axis, angle about the second (carried by the first) | rates |
        /// | planar | x, y in the hinge frame, angle about its z | rates |
        /// | spherical | quaternion w, x, y, z (`hinge_from_body`) | relative angular velocity, body axes |
        /// | free | x, y, z in the hinge frame, quaternion | rates in the hinge frame, relative angular velocity in body axes |
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum HingeKind {
            $($(#[$doc])* $kind $({ $($(#[$of])* $field: $type),+ })?,)+
        }

        $(impl From<$module::$kind> for HingeKind {
            fn from(kind: $module::$kind) -> Self {
                let $module::$kind $({ $($field),+ })? = kind;
                Self::$kind $({ $($field),+ })?
            }
        })+

        /// What files say of each kind.
        pub const DECLARED: &[Declared] = &[$(Declared::of::<$module::$kind>()),+];

        impl HingeKind {
            /// The kind of a name in scenario files.
            pub fn read(name: &str, keys: &dyn Keys) -> Option<Self> {
                $(if name == $module::$kind::NAME {
                    return Some($module::$kind::read(keys).into());
                })+
                None
            }

            /// Name in scenario files.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$kind { .. } => $module::$kind::NAME,)+ }
            }

            /// Names and units of its coordinates.
            pub fn positions(&self) -> Names {
                match *self { $(Self::$kind $({ $($field),+ })? => $module::$kind $({ $($field),+ })?.positions(),)+ }
            }

            /// Names and units of its velocities.
            pub fn velocities(&self) -> Names {
                match *self { $(Self::$kind $({ $($field),+ })? => $module::$kind $({ $($field),+ })?.velocities(),)+ }
            }

            /// The order of its coordinates and of its velocities, for messages; `None` if it has one or none.
            pub fn order(&self) -> Option<[&'static str; 2]> {
                match *self { $(Self::$kind $({ $($field),+ })? => $module::$kind $({ $($field),+ })?.order(),)+ }
            }

            /// See [`Freedom::check`].
            pub fn check(&self, owner: &str, say: Say<'_>) {
                match *self {
                    $(Self::$kind $({ $($field),+ })? => $module::$kind $({ $($field),+ })?.check(owner, say),)+
                }
            }

            /// See [`Freedom::axes`].
            pub fn axes(&self) -> Vec<Vector3<f64>> {
                match *self { $(Self::$kind $({ $($field),+ })? => $module::$kind $({ $($field),+ })?.axes(),)+ }
            }

            /// See [`Freedom::elementary`].
            pub fn elementary(&self, rest: &[f64]) -> Vec<(Joint, UnitQuaternion<f64>)> {
                match *self {
                    $(Self::$kind $({ $($field),+ })? => $module::$kind $({ $($field),+ })?.elementary(rest),)+
                }
            }

            /// See [`Freedom::conditions`].
            pub fn conditions(&self) -> Vec<Condition> {
                match *self { $(Self::$kind $({ $($field),+ })? => $module::$kind $({ $($field),+ })?.conditions(),)+ }
            }

            /// See [`Freedom::shared`].
            pub fn shared(&self) -> Vec<Vector3<f64>> {
                match *self { $(Self::$kind $({ $($field),+ })? => $module::$kind $({ $($field),+ })?.shared(),)+ }
            }
        }
    };
}

kinds! {
    /// Welded.
    Fixed in fixed,
    /// Turns about one axis.
    Revolute {
        /// Axis, hinge frame.
        axis: Vector3<f64>
    } in revolute,
    /// Slides along one axis.
    Prismatic {
        /// Axis, hinge frame.
        axis: Vector3<f64>
    } in prismatic,
    /// Turns about one axis and slides along it by `pitch` per radian.
    Screw {
        /// Axis, hinge frame.
        axis: Vector3<f64>,
        /// (m/rad), not zero.
        pitch: f64
    } in screw,
    /// Slides along the curve of its description.
    Along {
        /// About and with the curve.
        turn: AlongTurn
    } in along,
    /// Slides along and turns about one axis.
    Cylindrical {
        /// Axis, hinge frame.
        axis: Vector3<f64>
    } in cylindrical,
    /// Turns about a first axis, then about a second one carried by the first.
    Universal {
        /// Axes, hinge frame (both angles zero).
        axes: [Vector3<f64>; 2]
    } in universal,
    /// Slides in the xy plane of the hinge frame and turns about its z.
    Planar in planar,
    /// Turns freely.
    Spherical in spherical,
    /// Moves freely.
    Free in free,
}

impl HingeKind {
    /// Number of coordinates and of velocities.
    pub fn counts(&self) -> (usize, usize) {
        (self.positions().len(), self.velocities().len())
    }

    /// Number of leading coordinates that are angles or distances and have a velocity of the same place; after them comes
    /// a quaternion or nothing.
    pub fn plain_coordinates(&self) -> usize {
        self.positions().iter().take_while(|(_, unit)| *unit != "1").count()
    }
}
