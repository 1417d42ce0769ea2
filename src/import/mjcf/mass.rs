//! Mass properties: `<inertial>`, or the geoms filled with their densities.

use super::defaults::Settled;
use super::pose;
use super::scene::Scene;
use super::settings::{FromGeoms, Settings};
use crate::model::description::MassProperties;
use crate::model::shape::combined;
use nalgebra::{Isometry3, Matrix3, SymmetricEigen, Vector3};

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

/// `<inertial>`, body axes.
pub(super) fn inertial(settled: &Settled<'_>, settings: &Settings, frame: &Isometry3<f64>) -> Option<MassProperties> {
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
    Some(placed(&MassProperties { mass, center: Vector3::zeros(), inertia }, &(frame * pose)))
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
