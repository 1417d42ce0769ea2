//! What a mesh weighs, by the rules of MuJoCo's compiler.
//!
//! With the corners a, b, c of a triangle, its vector of area A = ½ (b − a) × (c − a), its middle m = (a + b + c)/3, and the
//! middle M of the whole surface, each triangle weighed with |A|:
//!
//! ```text
//! V  = (m − M)·A / 3                        a pyramid from M                          (1)
//! C  = Σ V (¾ m + ¼ M) / Σ V                centre of mass                            (2)
//! V' = (m − C)·A / 3                        a pyramid from C                          (3)
//! P  = Σ V'/20 (aaᵀ + bbᵀ + ccᵀ + ssᵀ)      about C, s = a + b + c                    (4)
//! ```
//!
//! The volume is Σ V', the inertia tr(P) 1 − P. For a closed surface whose triangles all look outwards this is the body that it
//! encloses, whatever the points from which the pyramids stand. For others the rules differ (`inertia` of a mesh):
//!
//! * `exact`: V and V' with their signs; triangles that share an edge and look different ways are refused;
//! * `legacy`, the default: their absolute values, so that hollows count as if they were filled;
//! * `convex`: of the convex hull;
//! * `shell`: of the surface: |A| stands for V and V', and 1/12 for 1/20.

use crate::mesh;
use crate::model::description::MassProperties;
use nalgebra::{Matrix3, Vector3};
use std::collections::HashSet;

/// Smaller volumes (m³) and areas (m²) are none, to MuJoCo (`mjMINVAL`).
const SMALLEST: f64 = 1e-15;

/// A volume that differs by more than this part from the one enclosed is worth a word: far above the round-off of sums over
/// triangles.
const ALIKE: f64 = 1e-9;

/// How a mesh weighs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rule {
    /// The hull.
    Convex,
    /// Pyramids with their signs.
    Exact,
    /// Pyramids without signs.
    Legacy,
    /// The surface.
    Shell,
}

/// A surface of triangles.
#[derive(Debug, Clone, Default)]
pub(super) struct Surface {
    pub(super) corners: Vec<Vector3<f64>>,
    /// Counter-clockwise as seen from outside; none: the hull of the corners.
    pub(super) triangles: Vec<[usize; 3]>,
}

/// What a mesh weighs with a density of 1 kg/m³ (a shell: 1 kg/m²), in the axes of the geom.
#[derive(Debug, Clone)]
pub(super) struct Weight {
    pub(super) unit: MassProperties,
    /// What is to be known about it.
    pub(super) remark: Option<String>,
}

impl Surface {
    /// Mass properties by a rule. `closed` says why the file's mesh encloses nothing, or what it encloses.
    ///
    /// # Errors
    /// Where MuJoCo refuses the mesh, or there is no hull: why.
    pub(super) fn weigh(mut self, rule: Rule, closed: &Result<f64, mesh::NotSolid>) -> Result<Weight, String> {
        let mut rule = rule;
        if rule == Rule::Convex || self.triangles.is_empty() {
            self.triangles = mesh::hull(&self.corners).ok_or("it has no convex hull: its corners lie in a plane")?;
        }
        if rule == Rule::Convex {
            rule = Rule::Exact;
        } else if rule == Rule::Exact {
            self.check_orientation()?;
        }
        let unit = self.mass_properties(rule)?;
        let what = if rule == Rule::Shell { None } else { remark(unit.mass, closed, rule) };
        Ok(Weight { unit, remark: what })
    }

    /// Equations (1) to (4).
    fn mass_properties(&self, rule: Rule) -> Result<MassProperties, String> {
        let faces = || self.triangles.iter().map(|triangle| triangle.map(|corner| self.corners[corner]));
        let areas = || faces().map(|[a, b, c]| (0.5 * (b - a).cross(&(c - a)), (a + b + c) / 3.0));
        let surface: f64 = areas().map(|(area, _)| area.norm()).sum();
        if !(surface >= SMALLEST) {
            return Err(format!("its surface is {surface:e} m², which is too small"));
        }
        let middle = areas().map(|(area, at)| at * area.norm()).sum::<Vector3<f64>>() / surface;
        let pyramid = |area: &Vector3<f64>, from_apex: &Vector3<f64>| match rule {
            Rule::Shell => area.norm(),
            Rule::Legacy => (from_apex.dot(area) / 3.0).abs(),
            Rule::Exact | Rule::Convex => from_apex.dot(area) / 3.0,
        };
        let (mut whole, mut center) = (0.0, Vector3::zeros());
        for (area, at) in areas() {
            let part = pyramid(&area, &(at - middle));
            whole += part;
            center += (0.75 * at + 0.25 * middle) * part;
        }
        if !(whole >= SMALLEST) {
            return Err(match whole < 0.0 {
                true => "its volume is negative: its triangles look inwards".to_owned(),
                false => format!("its volume is {whole:e} m³, which is too small"),
            });
        }
        center /= whole;
        let parts = if rule == Rule::Shell { 12.0 } else { 20.0 };
        let (mut mass, mut second) = (0.0, Matrix3::zeros());
        for corners in faces() {
            let [a, b, c] = corners.map(|corner| corner - center);
            let sum = a + b + c;
            let part = pyramid(&(0.5 * (b - a).cross(&(c - a))), &(sum / 3.0));
            mass += part;
            second +=
                (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose()) * (part / parts);
        }
        let inertia = Matrix3::identity() * second.trace() - second;
        if !(mass >= SMALLEST) || !inertia.iter().all(|moment| moment.is_finite()) {
            return Err(format!("its volume about its centre of mass is {mass:e} m³"));
        }
        Ok(MassProperties { mass, center, inertia })
    }

    /// Two triangles may not pass an edge the same way.
    fn check_orientation(&self) -> Result<(), String> {
        let mut passed = HashSet::new();
        for &[a, b, c] in &self.triangles {
            let [at, bt, ct] = [a, b, c].map(|corner| self.corners[corner]);
            // Slivers are left out, as in MuJoCo.
            if 0.5 * (bt - at).cross(&(ct - at)).norm() <= SMALLEST.sqrt() {
                continue;
            }
            let key = |corner: usize| self.corners[corner].map(|x| (x + 0.0).to_bits());
            for [from, to] in [[a, b], [b, c], [c, a]] {
                if !passed.insert([key(from), key(to)]) {
                    let shown = |corner: usize| self.corners[corner].map(|x| x.to_string()).as_slice().join(", ");
                    return Err(format!(
                        "two triangles at the edge from [{}] to [{}] look different ways, which `inertia=\"exact\"` does not allow",
                        shown(from),
                        shown(to)
                    ));
                }
            }
        }
        Ok(())
    }
}

/// What is said where the volume is not the one that the mesh encloses.
fn remark(volume: f64, closed: &Result<f64, mesh::NotSolid>, rule: Rule) -> Option<String> {
    let counted = match rule {
        Rule::Legacy => "MuJoCo's `inertia=\"legacy\"`, the default, adds up pyramids without their signs",
        _ => "MuJoCo adds up pyramids",
    };
    match closed {
        Err(why) => Some(format!("its mesh has no volume of its own: {why}; {counted}: {volume} m³")),
        Ok(enclosed) if (volume - enclosed).abs() > ALIKE * enclosed => {
            Some(format!("its mesh encloses {enclosed} m³ and weighs {volume} m³: {counted}"))
        }
        Ok(_) => None,
    }
}
