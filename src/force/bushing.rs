//! A six-degree spring and damper between two frames A and B.
//!
//! ```text
//! F_A, F_B: bushing axes carried by either link;   x = x_b − x_a
//! u = F_Aᵀ x,  u̇ = F_Aᵀ (v_b − v_a − ω_A × x),     φ = log(F_Aᵀ F_B)
//! force on B at b:  f = F_A (p − K u − C u̇);          on A the opposite, on the same line: at b
//! torque on B:      t = F_B G(φ)ᵀ (p_φ − K_φ φ) − F_A C_φ F_Aᵀ (ω_B − ω_A);   on A the opposite
//! potential ½ uᵀ K u + ½ φᵀ K_φ φ − pᵀ u − p_φᵀ φ   (p, p_φ: preload, G: crate::spatial::rotation)
//! ```

use super::end::Anchor;
use super::{Act, Attachment, Carrier, Describe, End, ForceDescription, Magnitude, Picture, Report};
use crate::spatial::Wrench;
use crate::spatial::link::{LinkMotion, LinkVariation};
use crate::spatial::rotation::{rotation_vector, torsion_spring};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// How far a quaternion's norm may be from one: files carry at least six digits.
const QUATERNION_SLACK: f64 = 1e-6;

/// Six-degree spring and damper, without a preload relaxed where both points coincide and both bodies' axes are parallel.
#[derive(Debug, Clone, PartialEq)]
pub struct Bushing {
    /// The two ends; the bushing's axes are carried by the first.
    pub between: [Attachment; 2],
    /// Turn of the bushing's axes in the first body: `body_from_bushing`.
    pub frame: UnitQuaternion<f64>,
    /// Along x, y, z (N/m), then about x, y, z (N m/rad), bushing axes.
    pub stiffness: [f64; 6],
    /// Along (N s/m), then about (N m s/rad).
    pub damping: [f64; 6],
    /// What it pushes the second body with where both points coincide and both axes are parallel: along (N), then about (N m), bushing axes.
    pub preload: [f64; 6],
}

/// A bushing, compiled.
#[derive(Debug, Clone)]
pub struct BushingLaw {
    ends: [End; 2],
    /// The bushing's axes in both links: `link_from_bushing`.
    frames: [Matrix3<f64>; 2],
    /// Along (N/m).
    stiffness: Vector3<f64>,
    /// About (N m/rad).
    turn_stiffness: Vector3<f64>,
    /// Along (N s/m).
    damping: Vector3<f64>,
    /// About (N m s/rad).
    turn_damping: Vector3<f64>,
    /// On the second body where the frames coincide (N).
    preload: Vector3<f64>,
    /// Moment on the second body where the frames coincide (N m).
    turn_preload: Vector3<f64>,
}

impl ForceDescription {
    /// A spring in six directions, its axes those of the first body: stiffness along x, y, z (N/m) and about them
    /// (N m/rad), damping likewise (N s/m, N m s/rad).
    pub fn bushing(
        name: &str,
        from: impl Into<Attachment>,
        to: impl Into<Attachment>,
        stiffness: [f64; 6],
        damping: [f64; 6],
    ) -> Self {
        let (between, frame) = ([from.into(), to.into()], UnitQuaternion::identity());
        let kind = Bushing { between, frame, stiffness, damping, preload: [0.0; 6] };
        Self { name: name.to_owned(), kind: kind.into() }
    }
}

impl Describe for Bushing {
    type Law = BushingLaw;

    fn attachments(&self) -> Vec<(String, &Attachment)> {
        (0..2).map(|i| (format!("between[{i}]"), &self.between[i])).collect()
    }

    fn check(&self, report: &mut Report<'_>) {
        let name = report.name;
        self.stiffness.iter().for_each(|k| report.not_negative("stiffness", *k, "N/m or N m/rad"));
        self.damping.iter().for_each(|c| report.not_negative("damping", *c, "N s/m or N m s/rad"));
        report.apart(&self.between, "a bushing");
        if let Some(p) = self.preload.iter().find(|p| !p.is_finite()) {
            report.add("preload", format!("`preload` of `{name}` is {p}"), "give finite N, N m");
        }
        let off = (self.frame.norm() - 1.0).abs();
        if off > QUATERNION_SLACK || off.is_nan() {
            report.add("rpy", format!("the axes of `{name}` are not a turn"), "give finite angles");
        }
    }

    fn compile(&self, carriers: &[Carrier]) -> BushingLaw {
        let along = |six: &[f64; 6]| Vector3::new(six[0], six[1], six[2]);
        let about = |six: &[f64; 6]| Vector3::new(six[3], six[4], six[5]);
        let frame = |carrier: &Carrier| *(carrier.turn * self.frame).to_rotation_matrix().matrix();
        BushingLaw {
            ends: [carriers[0].end, carriers[1].end],
            frames: [frame(&carriers[0]), frame(&carriers[1])],
            stiffness: along(&self.stiffness),
            turn_stiffness: about(&self.stiffness),
            damping: along(&self.damping),
            turn_damping: about(&self.damping),
            preload: along(&self.preload),
            turn_preload: about(&self.preload),
        }
    }

    fn numbers(&self, key: &str) -> Vec<(f64, &'static str)> {
        let six = |list: &[f64; 6], along, about| {
            list.iter().enumerate().map(|(i, x)| (*x, if i < 3 { along } else { about })).collect()
        };
        match key {
            "stiffness" => six(&self.stiffness, "N/m", "N m/rad"),
            "preload" => six(&self.preload, "N", "N m"),
            _ => Vec::new(),
        }
    }

    fn set(&mut self, key: &str, index: usize, value: f64) {
        match key {
            "stiffness" => self.stiffness[index] = value,
            _ => self.preload[index] = value,
        }
    }
}

impl Act for BushingLaw {
    fn ends(&self) -> &[End] {
        &self.ends
    }

    #[inline]
    fn wrenches(&self, links: &[LinkMotion], give: &mut impl FnMut(usize, Wrench)) {
        let [on_a, on_b] = State::of(self, links).wrenches();
        give(0, on_a);
        give(1, on_b);
    }

    fn vary(&self, links: &[LinkMotion], by: &[LinkVariation], give: &mut impl FnMut(usize, Wrench)) {
        let state = State::of(self, links);
        let [on_a, on_b] = state.vary(&state.elastic(), links, by);
        give(0, on_a);
        give(1, on_b);
    }

    fn vary_each(
        &self,
        links: &[LinkMotion],
        by: &mut [LinkVariation],
        (link, variations): (usize, &[LinkVariation]),
        give: &mut impl FnMut(usize, usize, Wrench),
    ) {
        let state = State::of(self, links);
        let elastic = state.elastic();
        for (index, variation) in variations.iter().enumerate() {
            by[link] = *variation;
            let [on_a, on_b] = state.vary(&elastic, links, by);
            give(index, 0, on_a);
            give(index, 1, on_b);
        }
        by[link] = LinkVariation::default();
    }

    fn potential(&self, links: &[LinkMotion]) -> f64 {
        State::of(self, links).potential()
    }

    fn dissipated(&self, links: &[LinkMotion]) -> f64 {
        State::of(self, links).dissipated()
    }

    fn has_damping(&self) -> bool {
        self.damping != Vector3::zeros() || self.turn_damping != Vector3::zeros()
    }

    fn magnitude(&self, links: &[LinkMotion]) -> Magnitude {
        State::of(self, links).magnitude()
    }

    fn picture(&self) -> Picture<'_> {
        Picture::Block { ends: &self.ends, frames: &self.frames, stiffness: &self.stiffness }
    }
}

/// Its force on B, the torque of its torsion spring there, and the tangent of that spring in the axes of B.
struct Elastic {
    force: Vector3<f64>,
    torque: Vector3<f64>,
    tangent: Matrix3<f64>,
}

/// A bushing at one instant.
struct State<'a> {
    law: &'a BushingLaw,
    points: [Anchor; 2],
    axes: [Matrix3<f64>; 2],
    relative: UnitQuaternion<f64>,
    /// x, and v_b − v_a − ω_A × x
    between: Vector3<f64>,
    slip: Vector3<f64>,
    /// ω_B − ω_A
    spin: Vector3<f64>,
    carrier_spin: Vector3<f64>,
}

impl<'a> State<'a> {
    #[inline]
    fn of(law: &'a BushingLaw, links: &[LinkMotion]) -> Self {
        let ends = &law.ends;
        let points = [Anchor::of(&ends[0], links), Anchor::of(&ends[1], links)];
        let links = [&links[ends[0].link], &links[ends[1].link]];
        let axes = [links[0].turn * law.frames[0], links[1].turn * law.frames[1]];
        let between = points[1].position - points[0].position;
        let carrier_spin = links[0].angular_velocity;
        Self {
            law,
            points,
            axes,
            relative: UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(
                axes[0].transpose() * axes[1],
            )),
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
        self.axes[0] * self.law.preload
            - self.in_axes(&self.law.stiffness, &self.between)
            - self.in_axes(&self.law.damping, &self.slip)
    }

    fn wrenches(&self) -> [Wrench; 2] {
        let force = self.force();
        let (spring, _) = torsion_spring(&self.relative, self.law.turn_stiffness, self.law.turn_preload);
        let torque = self.axes[1] * spring - self.in_axes(&self.law.turn_damping, &self.spin);
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

    /// What every variation needs of it.
    fn elastic(&self) -> Elastic {
        let (spring, tangent) = torsion_spring(&self.relative, self.law.turn_stiffness, self.law.turn_preload);
        Elastic { force: self.force(), torque: self.axes[1] * spring, tangent }
    }

    fn vary(&self, elastic: &Elastic, links: &[LinkMotion], by: &[LinkVariation]) -> [Wrench; 2] {
        let ends = [self.law.ends[0].link, self.law.ends[1].link];
        let a = self.points[0].vary(&links[ends[0]], &by[ends[0]]);
        let b = self.points[1].vary(&links[ends[1]], &by[ends[1]]);
        let (turn_a, turn_b) = (by[ends[0]].turn, by[ends[1]].turn);
        let between = b.position - a.position;
        let slip = b.velocity
            - a.velocity
            - by[ends[0]].angular_velocity.cross(&self.between)
            - self.carrier_spin.cross(&between);
        let spin = by[ends[1]].angular_velocity - by[ends[0]].angular_velocity;
        // In axes that turn with A: δ(F diag Fᵀ y) = δθ × (F diag Fᵀ y) + F diag Fᵀ (δy − δθ × y)
        let seen = |y: &Vector3<f64>, delta: &Vector3<f64>| delta - turn_a.cross(y);
        let Elastic { force: total, torque: spring, tangent } = elastic;
        let force = turn_a.cross(total)
            - self.in_axes(&self.law.stiffness, &seen(&self.between, &between))
            - self.in_axes(&self.law.damping, &seen(&self.slip, &slip));
        let damper = -self.in_axes(&self.law.turn_damping, &self.spin);
        let torque = turn_b.cross(spring)
            + self.axes[1] * (tangent * self.axes[1].tr_mul(&(turn_b - turn_a)))
            + turn_a.cross(&damper)
            - self.in_axes(&self.law.turn_damping, &seen(&self.spin, &spin));
        self.pair(force, torque, -(a.arm + between).cross(total), b.arm.cross(total))
    }

    fn magnitude(&self) -> Magnitude {
        let reach = self.points[0].position.norm() + self.points[1].position.norm();
        let (force, lever) = (self.force().norm(), self.between.norm());
        let noise = self.law.stiffness.max() * reach + self.law.preload.norm();
        let turning =
            self.law.turn_stiffness.max() * rotation_vector(&self.relative).norm() + self.law.turn_preload.norm();
        Magnitude {
            force,
            noise,
            // On A the force acts at b, and the lever is a difference of positions.
            moment: force * lever + turning,
            noise_moment: noise * lever + force * reach + turning,
            stiffness: self.law.stiffness.max(),
            turn_stiffness: self.law.turn_stiffness.max(),
        }
    }

    fn potential(&self) -> f64 {
        let u = self.axes[0].tr_mul(&self.between);
        let phi = rotation_vector(&self.relative);
        0.5 * (u.component_mul(&u).dot(&self.law.stiffness) + phi.component_mul(&phi).dot(&self.law.turn_stiffness))
            - self.law.preload.dot(&u)
            - self.law.turn_preload.dot(&phi)
    }

    fn dissipated(&self) -> f64 {
        self.in_axes(&self.law.damping, &self.slip).dot(&self.slip)
            + self.in_axes(&self.law.turn_damping, &self.spin).dot(&self.spin)
    }
}
