//! A six-degree spring and damper between two frames A and B.
//!
//! ```text
//! F_A, F_B: bushing axes carried by either link;   x = x_b − x_a
//! u = F_Aᵀ x,  u̇ = F_Aᵀ (v_b − v_a − ω_A × x),     φ = log(F_Aᵀ F_B)
//! force on B at b:  f = F_A (p − K u − C u̇);          on A the opposite, on the same line: at b
//! torque on B:      t = F_B G(φ)ᵀ (p_φ − K_φ φ) − F_A C_φ F_Aᵀ (ω_B − ω_A);   on A the opposite
//! potential ½ uᵀ K u + ½ φᵀ K_φ φ − pᵀ u − p_φᵀ φ   (p, p_φ: preload, G: crate::spatial::rotation)
//! ```

use super::Magnitude;
use crate::model::{End, Law};
use crate::motion::Motion;
use crate::motion::point::Point;
use crate::motion::variation::LinkVariation;
use crate::spatial::Wrench;
use crate::spatial::rotation::{rotation_vector, torsion_spring};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

pub(super) struct Bushing {
    ends: [End; 2],
    points: [Point; 2],
    axes: [Matrix3<f64>; 2],
    relative: UnitQuaternion<f64>,
    stiffness: Vector3<f64>,
    turn_stiffness: Vector3<f64>,
    damping: Vector3<f64>,
    turn_damping: Vector3<f64>,
    preload: Vector3<f64>,
    turn_preload: Vector3<f64>,
    /// x, and v_b − v_a − ω_A × x
    between: Vector3<f64>,
    slip: Vector3<f64>,
    /// ω_B − ω_A
    spin: Vector3<f64>,
    carrier_spin: Vector3<f64>,
}

impl Bushing {
    pub(super) fn at(law: &Law, motion: &Motion) -> Self {
        let Law::Bushing { ends, frames, stiffness, turn_stiffness, damping, turn_damping, preload, turn_preload } =
            law
        else {
            unreachable!("called for bushings only");
        };
        let points = [Point::of(&ends[0], motion), Point::of(&ends[1], motion)];
        let links = [&motion.links[ends[0].link], &motion.links[ends[1].link]];
        let axes = [0, 1].map(|i| links[i].turn * frames[i].to_rotation_matrix().matrix());
        let between = points[1].position - points[0].position;
        let carrier_spin = links[0].angular_velocity;
        Self {
            ends: *ends,
            points,
            axes,
            relative: UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(
                axes[0].transpose() * axes[1],
            )),
            stiffness: *stiffness,
            turn_stiffness: *turn_stiffness,
            damping: *damping,
            turn_damping: *turn_damping,
            preload: *preload,
            turn_preload: *turn_preload,
            between,
            slip: points[1].velocity - points[0].velocity - carrier_spin.cross(&between),
            spin: links[1].angular_velocity - carrier_spin,
            carrier_spin,
        }
    }

    /// `F_A diag F_Aᵀ v`.
    fn in_axes(&self, diagonal: &Vector3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
        self.axes[0] * diagonal.component_mul(&self.axes[0].tr_mul(v))
    }

    /// Force on B.
    fn force(&self) -> Vector3<f64> {
        self.axes[0] * self.preload
            - self.in_axes(&self.stiffness, &self.between)
            - self.in_axes(&self.damping, &self.slip)
    }

    pub(super) fn wrenches(&self) -> [Wrench; 2] {
        let force = self.force();
        let (spring, _) = torsion_spring(&self.relative, self.turn_stiffness, self.turn_preload);
        let torque = self.axes[1] * spring - self.in_axes(&self.turn_damping, &self.spin);
        self.pair(force, torque, Vector3::zeros(), Vector3::zeros())
    }

    /// A wrench on B at b and its opposite on A, with what the varied arms add to the moments.
    fn pair(&self, force: Vector3<f64>, torque: Vector3<f64>, on_a: Vector3<f64>, on_b: Vector3<f64>) -> [Wrench; 2] {
        let [a, b] = &self.points;
        let from_a = Wrench::at_arm(-force, a.arm + self.between);
        let from_b = Wrench::at_arm(force, b.arm);
        [
            Wrench { force: from_a.force, moment: from_a.moment - torque + on_a },
            Wrench { force: from_b.force, moment: from_b.moment + torque + on_b },
        ]
    }

    pub(super) fn vary(&self, motion: &Motion, by: &[LinkVariation]) -> [Wrench; 2] {
        let links = [self.ends[0].link, self.ends[1].link];
        let [a, b] = [0, 1].map(|i| self.points[i].vary(&motion.links[links[i]], &by[links[i]]));
        let (turn_a, turn_b) = (by[links[0]].turn, by[links[1]].turn);
        let between = b.position - a.position;
        let slip = b.velocity
            - a.velocity
            - by[links[0]].angular_velocity.cross(&self.between)
            - self.carrier_spin.cross(&between);
        let spin = by[links[1]].angular_velocity - by[links[0]].angular_velocity;
        // In axes that turn with A: δ(F diag Fᵀ y) = δθ × (F diag Fᵀ y) + F diag Fᵀ (δy − δθ × y)
        let seen = |y: &Vector3<f64>, delta: &Vector3<f64>| delta - turn_a.cross(y);
        let total = self.force();
        let force = turn_a.cross(&total)
            - self.in_axes(&self.stiffness, &seen(&self.between, &between))
            - self.in_axes(&self.damping, &seen(&self.slip, &slip));
        let (spring, tangent) = torsion_spring(&self.relative, self.turn_stiffness, self.turn_preload);
        let elastic = self.axes[1] * spring;
        let damper = -self.in_axes(&self.turn_damping, &self.spin);
        let torque = turn_b.cross(&elastic)
            + self.axes[1] * (tangent * self.axes[1].tr_mul(&(turn_b - turn_a)))
            + turn_a.cross(&damper)
            - self.in_axes(&self.turn_damping, &seen(&self.spin, &spin));
        self.pair(force, torque, -(a.arm + between).cross(&total), b.arm.cross(&total))
    }

    pub(super) fn magnitude(&self) -> Magnitude {
        let reach = self.points[0].position.norm() + self.points[1].position.norm();
        Magnitude {
            force: self.force().norm(),
            noise: self.stiffness.max() * reach,
            moment: self.turn_stiffness.max() * rotation_vector(&self.relative).norm() + self.turn_preload.norm(),
            stiffness: self.stiffness.max(),
            turn_stiffness: self.turn_stiffness.max(),
        }
    }

    pub(super) fn potential(&self) -> f64 {
        let u = self.axes[0].tr_mul(&self.between);
        let phi = rotation_vector(&self.relative);
        0.5 * (u.component_mul(&u).dot(&self.stiffness) + phi.component_mul(&phi).dot(&self.turn_stiffness))
            - self.preload.dot(&u)
            - self.turn_preload.dot(&phi)
    }

    pub(super) fn dissipated(&self) -> f64 {
        self.in_axes(&self.damping, &self.slip).dot(&self.slip)
            + self.in_axes(&self.turn_damping, &self.spin).dot(&self.spin)
    }
}
