//! Mass properties: `<inertial>`, or the geoms filled with their densities.

use super::defaults::Settled;
use super::pose;
use super::scene::Scene;
use super::settings::{FromGeoms, Settings};
use crate::model::description::MassProperties;
use crate::model::shape::combined;
use nalgebra::{Isometry3, Matrix3, Quaternion, SymmetricEigen, UnitQuaternion, Vector3};

/// A body that weighs nothing.
pub(super) const NOTHING: MassProperties = MassProperties {
    mass: 0.0,
    center: Vector3::new(0.0, 0.0, 0.0),
    inertia: Matrix3::new(0., 0., 0., 0., 0., 0., 0., 0., 0.),
};

/// Turned and moved into a body's axes.
pub(super) fn placed(mass: &MassProperties, pose: &Isometry3<f64>) -> MassProperties {
    let turn = pose.rotation.to_rotation_matrix();
    MassProperties {
        mass: mass.mass,
        center: (pose * nalgebra::Point3::from(mass.center)).coords,
        inertia: turn * mass.inertia * turn.transpose(),
    }
}

/// `<inertial>`, body axes, and its principal axes as MuJoCo has them.
pub(super) fn inertial(
    settled: &Settled<'_>,
    settings: &Settings,
    frame: &Isometry3<f64>,
) -> Option<(MassProperties, UnitQuaternion<f64>)> {
    for key in ["pos", "mass"] {
        settled.element.required(key)?;
    }
    let mass = settled.not_negative("mass")?;
    let pose = pose::pose(settled, settings);
    let inertia = match (settled.element.attribute("diaginertia"), settled.element.attribute("fullinertia")) {
        (Some(second), Some(_)) => {
            let problem = second.wrong("is written beside `fullinertia`");
            settled.element.refuse(problem.help("one of the two is enough"));
            return None;
        }
        (Some(diagonal), None) => Matrix3::from_diagonal(&Vector3::from(diagonal.vector::<3>()?)),
        (None, Some(full)) => {
            let [xx, yy, zz, xy, xz, yz] = full.vector()?;
            Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
        }
        (None, None) => {
            settled.refuse(
                "`diaginertia` or `fullinertia` is missing",
                "for example diaginertia=\"0.1 0.1 0.01\" [kg m²]",
            );
            return None;
        }
    };
    let pose = frame * pose;
    let full = settled.element.attribute("fullinertia").is_some();
    let axes = if full { pose.rotation * principal(&inertia) } else { pose.rotation };
    Some((placed(&MassProperties { mass, center: Vector3::zeros(), inertia }, &pose), axes))
}

/// What a body weighs: as `<inertial>` says, or as its geoms weigh together.
pub(super) fn of_body(
    inertial: Option<MassProperties>,
    geoms: &[MassProperties],
    settings: &Settings,
) -> MassProperties {
    let heavy: Vec<MassProperties> = geoms.iter().filter(|geom| geom.mass > 0.0).copied().collect();
    let together = || if heavy.is_empty() { NOTHING } else { combined(&heavy) };
    match (settings.inertia_from_geoms, inertial) {
        (FromGeoms::Always, _) if !heavy.is_empty() => together(),
        (FromGeoms::Never, None) => NOTHING,
        (FromGeoms::Auto, None) => together(),
        (_, given) => given.unwrap_or(NOTHING),
    }
}

/// Where MuJoCo puts the principal axes of an inertia, the largest moment first. Axes are only known up to their signs, and
/// these are part of what a keyframe means: so they are found with MuJoCo's own steps, Jacobi's rotations of the largest
/// product of inertia, then quarter turns that sort the moments.
pub(super) fn principal(inertia: &Matrix3<f64>) -> UnitQuaternion<f64> {
    const LEAST: f64 = 1e-12;
    const STEPS: usize = 500;
    let about = |axis: usize, cosine: f64, sine: f64| {
        let mut imaginary = Vector3::zeros();
        imaginary[axis] = sine;
        UnitQuaternion::new_normalize(Quaternion::from_parts(cosine, imaginary))
    };
    let (mut axes, mut moments) = (UnitQuaternion::identity(), inertia.diagonal());
    for _ in 0..STEPS {
        let turn = axes.to_rotation_matrix();
        let seen = turn.transpose() * inertia * turn;
        moments = seen.diagonal();
        let [xy, xz, yz] = [seen[(0, 1)], seen[(0, 2)], seen[(1, 2)]].map(f64::abs);
        let (row, column, axis) = match () {
            () if xy > xz && xy > yz => (0, 1, 2),
            () if xz > yz => (0, 2, 1),
            () => (1, 2, 0),
        };
        let product = seen[(row, column)];
        if product.abs() < LEAST {
            break;
        }
        let tau = (moments[column] - moments[row]) / (2.0 * product);
        let tangent = 1.0 / (tau.abs() + tau.hypot(1.0));
        let cosine = 1.0 / tangent.hypot(1.0);
        // The sine of half the angle, also where the cosine is 1 to round-off.
        let half = tangent * cosine / (2.0 + 2.0 * cosine).sqrt();
        let sine = if (tau >= 0.0) == (axis == 1) { half } else { -half };
        axes *= about(axis, (1.0 - half * half).sqrt(), sine);
    }
    for lead in [0, 1, 0] {
        if moments[lead] + LEAST < moments[lead + 1] {
            moments.swap_rows(lead, lead + 1);
            let half = std::f64::consts::FRAC_1_SQRT_2;
            axes *= about((lead + 2) % 3, half, half);
        }
    }
    axes
}

/// `boundmass`, `boundinertia` and `balanceinertia`: of every body, whether it has geoms or not.
pub(super) fn bounded(mut mass: MassProperties, settings: &Settings) -> MassProperties {
    mass.mass = mass.mass.max(settings.bound_mass);
    if settings.bound_inertia <= 0.0 && !settings.balance_inertia {
        return mass;
    }
    let principal = SymmetricEigen::new(mass.inertia);
    let mut moments = principal.eigenvalues.map(|moment| moment.max(settings.bound_inertia));
    let largest = moments.max();
    if settings.balance_inertia && moments.sum() - largest < largest {
        moments = Vector3::repeat(moments.mean());
    }
    if moments != principal.eigenvalues {
        let turn = principal.eigenvectors;
        mass.inertia = turn * Matrix3::from_diagonal(&moments) * turn.transpose();
    }
    mass
}

/// `settotalmass`: everything in proportion.
pub(super) fn scale(scene: &mut Scene<'_>) {
    let Some(wanted) = scene.settings.total_mass else { return };
    let total: f64 = scene.bodies.iter().map(|body| body.mass.mass).sum();
    if total > 0.0 {
        for body in &mut scene.bodies {
            body.mass.mass *= wanted / total;
            body.mass.inertia *= wanted / total;
        }
    }
}
