//! Flexible beams: as described, checked, and taken apart into bodies.
//!
//! A beam of N elements becomes N + 1 bodies: one on the beam's own hinge, then one at the tip of every element. The first
//! keeps the beam's name, the others are numbered; a point given on the beam's name alone is one of its tip.

mod cable;
mod check;
mod expand;
#[cfg(feature = "scenario")]
mod locked;
mod wound;

pub(in crate::model) use cable::{Laid, lay, lay_once};
pub(super) use check::check;
pub(super) use expand::{Bodies, Expanded, expand};

use super::description::{Attachment, HingeDescription};
use crate::element::guide::{Guide, GuideCurve, GuideFlaw};
pub use crate::element::section::{Material, Section};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use std::sync::Arc;
pub(crate) use wound::MUCH_TURN;
pub use wound::Wound;

/// A flexible beam on a hinge: it runs along the x axis of its root.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamDescription {
    /// Unique among bodies and beams.
    pub name: String,
    /// The hinge at its root.
    pub hinge: HingeDescription,
    /// Its unstrained centre line.
    pub shape: BeamShape,
    /// How far its sections turn about the centre line over its length (rad).
    pub twist: f64,
    /// Number of elements, at least one between any two markers.
    pub elements: usize,
    /// Degree of the strains in an element: 0, 1 or 2.
    pub degree: usize,
    /// One section, or several at distances from the root in ascending order (m) with others between them.
    pub sections: Vec<(f64, Section)>,
    /// Needed by sections that have a size.
    pub material: Option<Material>,
    /// In place of the material's (kg/m).
    pub mass_per_length: Option<f64>,
    /// In place of the material's: rotary inertia about x, y and z (kg m).
    pub rotary: Option<Vector3<f64>>,
    /// Which strains are free.
    pub free: FreeStrains,
    /// Kelvin–Voigt damping: stress by rate of strain over stress by strain (s).
    pub damping: f64,
    /// Named points, by their distance from the root along the unstrained centre line (m).
    pub markers: Vec<(String, f64)>,
    /// Force per length beside gravity.
    pub load: Option<LineLoad>,
    /// In place of the section's bending stiffness (N m²).
    pub bending: Option<f64>,
    /// Of a cable, where it ends.
    pub far: Option<FarEnd>,
    /// The coordinates of its elements at the start, from the root to the tip (rad for bends and twists, m for the others);
    /// none where it begins unstrained, or in the shape of a cable.
    pub strains: Vec<f64>,
    /// Their rates.
    pub strain_rates: Vec<f64>,
}

/// Where a cable ends, and how. Its root hinge says on which body it begins and where; its kind and its frame follow from the
/// given positions: the beam's x axis points along the cable.
#[derive(Debug, Clone, PartialEq)]
pub struct FarEnd {
    /// Where.
    pub at: Attachment,
    /// Whether the start and the end are clamped along the chord of the given positions; otherwise they are free to swing.
    pub clamped: [bool; 2],
    /// The tension at its start in the given positions, from which the unstretched length follows (N).
    pub pretension: Option<f64>,
    /// The shape in which it begins, if its hinge, its length and what closes it have followed from other positions than those of the scene
    /// that it is in: of a scene that a stage leaves.
    pub(in crate::model) laid: Option<Laid>,
}

/// The centre line of a beam without strain.
#[derive(Debug, Clone, PartialEq)]
pub enum BeamShape {
    /// Along x.
    Straight {
        /// Length (m).
        length: f64,
    },
    /// Towards y.
    Arc {
        /// Radius (m).
        radius: f64,
        /// Angle (rad).
        angle: f64,
    },
    /// Right-handed; x is the first tangent, y points to its axis.
    Helix {
        /// Radius (m).
        radius: f64,
        /// Rise per turn (m).
        pitch: f64,
        /// Number of turns.
        turns: f64,
    },
    /// Through points in the axes of its root, see [`BeamShape::through`].
    Points(Arc<Guide>),
}

/// Which strains of a beam are free; the others keep what they have without load.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FreeStrains {
    /// About y and z.
    pub bend: bool,
    /// About the centre line.
    pub twist: bool,
    /// Along it.
    pub stretch: bool,
    /// Across it.
    pub shear: bool,
}

/// Force per length of a beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineLoad {
    /// Force per length (N/m).
    pub force: Vector3<f64>,
    /// In section axes, with which it turns; else in inertial ones.
    pub follows: bool,
}

/// A compiled beam.
#[derive(Debug, Clone, PartialEq)]
pub struct Beam {
    /// Name.
    pub name: String,
    /// The body on its root hinge.
    pub root: usize,
    /// The body where its first element begins: that one, or one that is welded to it.
    pub begin: usize,
    /// Its elements from the root to the tip.
    pub elements: Vec<BeamElement>,
    /// Unstrained (m).
    pub length: f64,
    /// Whether it is a cable, closed at its far end: it begins in a shape that it is given.
    pub is_cable: bool,
    /// Degree of the strains in an element.
    pub degree: usize,
    /// As in [`BeamDescription::sections`].
    pub sections: Vec<(f64, Section)>,
}

/// An element of a compiled beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamElement {
    /// Distance of its root from the beam's (m).
    pub from: f64,
    /// Index of the element among [`Model::rods`](super::Model::rods).
    pub rod: usize,
    /// The link of its tip.
    pub link: usize,
    /// The body of its tip.
    pub body: usize,
}

impl Default for FreeStrains {
    /// Bending and twist: neither stretch nor shear.
    fn default() -> Self {
        Self { bend: true, twist: true, stretch: false, shear: false }
    }
}

impl FreeStrains {
    /// By the numbers of [`crate::element::Rod::new`].
    pub(super) fn indices(self) -> Vec<usize> {
        let all = [self.stretch, self.shear, self.shear, self.twist, self.bend, self.bend];
        (0..6).filter(|i| all[*i]).collect()
    }
}

impl BeamShape {
    /// The spline of degree 5 through points in the axes of the root (m); sections turn with the tangent and not about it,
    /// from the shortest turn of the root's axes on.
    ///
    /// # Errors
    /// What is wrong with the points: fewer than two, two in succession at one place, ends that meet, corners.
    pub fn through(points: Vec<Vector3<f64>>) -> Result<Self, GuideFlaw> {
        Ok(Self::Points(Arc::new(Guide::new(&GuideCurve::Points { points }, true)?)))
    }

    /// Length of the centre line (m).
    pub fn length(&self) -> f64 {
        match self {
            Self::Straight { length } => *length,
            Self::Arc { radius, angle } => radius * angle.abs(),
            Self::Helix { radius, pitch, turns } => {
                let round = std::f64::consts::TAU * radius;
                turns * round.hypot(*pitch)
            }
            Self::Points(guide) => {
                let [from, to] = guide.range();
                to - from
            }
        }
    }

    /// Where it begins in the axes of the root: turn and place.
    pub(super) fn begin(&self) -> (Matrix3<f64>, Vector3<f64>) {
        match self {
            Self::Points(guide) => {
                let at = guide.at(guide.range()[0]);
                (at.turn, at.place)
            }
            _ => (Matrix3::identity(), Vector3::zeros()),
        }
    }

    /// Curvature and torsion as a strain, at a distance from the root (m).
    pub(super) fn strain(&self, s: f64, twist_rate: f64) -> Vector6<f64> {
        let (torsion, [about_y, about_z]) = match self {
            Self::Straight { .. } => (0.0, [0.0; 2]),
            Self::Arc { radius, angle } => (0.0, [0.0, angle.signum() / radius]),
            Self::Helix { radius, pitch, .. } => {
                let rise = pitch / std::f64::consts::TAU;
                let square = radius * radius + rise * rise;
                (rise / square, [0.0, radius / square])
            }
            Self::Points(guide) => {
                let bent = guide.at(guide.range()[0] + s).subspaces[0];
                (0.0, [bent[4], bent[5]])
            }
        };
        // The centre line stays what it is; sections that are twisted see its curvature in their axes.
        let (sin, cos) = (twist_rate * s).sin_cos();
        let (y, z) = (cos * about_y + sin * about_z, cos * about_z - sin * about_y);
        Vector6::new(1.0, 0.0, 0.0, torsion + twist_rate, y, z)
    }

    /// Its polynomials over an element: Legendre coefficients, as [`crate::element::Rod::new`] takes them.
    pub(super) fn reference(&self, [from, to]: [f64; 2], twist_rate: f64) -> Vec<Vector6<f64>> {
        let is_even = match self {
            Self::Straight { .. } => true,
            Self::Arc { .. } | Self::Helix { .. } => twist_rate == 0.0,
            Self::Points(_) => false,
        };
        if is_even {
            return vec![self.strain(from, twist_rate)];
        }
        let mut coefficients = vec![Vector6::zeros(); 3];
        for (t, w) in crate::element::quadrature() {
            let (x, strain) = (2.0 * t - 1.0, self.strain(from + t * (to - from), twist_rate));
            for (degree, p) in [1.0, x, 0.5 * (3.0 * x * x - 1.0)].into_iter().enumerate() {
                coefficients[degree] += w * (2 * degree + 1) as f64 * p * strain;
            }
        }
        coefficients
    }

    /// How far the beam turns between two distances from the root (rad).
    pub(super) fn turn(&self, [from, to]: [f64; 2], twist_rate: f64) -> f64 {
        let rate = |s: f64| self.strain(s, twist_rate).fixed_rows::<3>(3).norm();
        crate::element::quadrature().map(|(t, w)| w * (to - from) * rate(from + t * (to - from))).sum()
    }
}

impl BeamDescription {
    /// Elements whose ends are further from a centre line through points than this part of its length are not that line.
    pub(crate) const MOST_STRAY: f64 = 0.02;

    /// A straight beam of 1 m with eight elements of degree 1, whose section has still to be given.
    pub fn new(name: &str, hinge: HingeDescription) -> Self {
        Self {
            name: name.to_owned(),
            hinge,
            shape: BeamShape::Straight { length: 1.0 },
            twist: 0.0,
            elements: 8,
            degree: 1,
            sections: Vec::new(),
            material: None,
            mass_per_length: None,
            rotary: None,
            free: FreeStrains::default(),
            damping: 0.0,
            markers: Vec::new(),
            load: None,
            bending: None,
            far: None,
            strains: Vec::new(),
            strain_rates: Vec::new(),
        }
    }

    /// A cable between two points, free to swing at both, that bends and stretches.
    pub fn cable(name: &str, from: impl Into<Attachment>, to: impl Into<Attachment>) -> Self {
        let from = from.into();
        let far = FarEnd { at: to.into(), clamped: [false; 2], pretension: None, laid: None };
        let free = FreeStrains { bend: true, twist: false, stretch: true, shear: false };
        Self { far: Some(far), free, ..Self::new(name, HingeDescription::fixed().on(&from.body, from.point)) }
    }

    /// Sets a straight centre line (m).
    pub fn length(self, length: f64) -> Self {
        self.shape(BeamShape::Straight { length })
    }

    /// Sets the centre line.
    pub fn shape(self, shape: BeamShape) -> Self {
        Self { shape, ..self }
    }

    /// Sets the number of elements.
    pub fn elements(self, elements: usize) -> Self {
        Self { elements, ..self }
    }

    /// Sets the degree of the strains: 0, 1 or 2.
    pub fn degree(self, degree: usize) -> Self {
        Self { degree, ..self }
    }

    /// Sets one section for the whole length.
    pub fn section(self, section: Section) -> Self {
        Self { sections: vec![(0.0, section)], ..self }
    }

    /// Sets stretch, shear y and z (N); twist, bending about y and z (N m²).
    pub fn stiffness(self, stiffness: [f64; 6]) -> Self {
        self.section(Section::Stiffness(Matrix6::from_diagonal(&Vector6::from(stiffness))))
    }

    /// Sets the material.
    pub fn material(self, young: f64, poisson: f64, density: f64) -> Self {
        Self { material: Some(Material { young, poisson, density }), ..self }
    }

    /// Sets the mass per length (kg/m).
    pub fn mass_per_length(self, mass: f64) -> Self {
        Self { mass_per_length: Some(mass), ..self }
    }

    /// Sets the rotary inertia about x, y and z (kg m).
    pub fn rotary(self, rotary: impl Into<Vector3<f64>>) -> Self {
        Self { rotary: Some(rotary.into()), ..self }
    }

    /// Sets which strains are free.
    pub fn free(self, free: FreeStrains) -> Self {
        Self { free, ..self }
    }

    /// Sets the Kelvin–Voigt damping (s).
    pub fn damping(self, damping: f64) -> Self {
        Self { damping, ..self }
    }

    /// Adds a named point at a distance from the root (m).
    pub fn marker(mut self, name: &str, at: f64) -> Self {
        self.markers.push((name.to_owned(), at));
        self
    }

    /// Sets a force per length (N/m).
    pub fn load(self, force: impl Into<Vector3<f64>>, follows: bool) -> Self {
        Self { load: Some(LineLoad { force: force.into(), follows }), ..self }
    }

    /// The most that one of its elements turns by without strain, if all are of one length (rad).
    pub(crate) fn most_turn(&self) -> f64 {
        let (length, count) = (self.shape.length(), self.elements.max(1));
        let end = |i: usize| length * i as f64 / count as f64;
        let turns = (0..count).map(|i| self.shape.turn([end(i), end(i + 1)], self.twist / length));
        turns.fold(0.0, f64::max)
    }

    /// The section at a distance from the root (m).
    pub(super) fn section_at(&self, s: f64) -> Section {
        section_at(&self.sections, s)
    }

    /// What the section has per length at a distance from the root (m). Without a rotary inertia, sections that twist
    /// or shear have that of a homogeneous one with this stiffness: with none at all their acceleration would be undetermined.
    pub(super) fn section_per_length(&self, s: f64) -> crate::element::RodSection {
        let mut of = self.section_at(s).of(self.material.as_ref());
        if let Some(mass) = self.mass_per_length {
            let scale = if of.mass > 0.0 { mass / of.mass } else { 0.0 };
            (of.mass, of.rotary) = (mass, scale * of.rotary);
        }
        if let Some(bending) = self.bending {
            (of.stiffness[(4, 4)], of.stiffness[(5, 5)]) = (bending, bending);
        }
        if let Some(rotary) = self.rotary {
            of.rotary = rotary;
        } else if of.rotary == Vector3::zeros() {
            let c = &of.stiffness;
            let (y, z) = (of.mass * c[(4, 4)] / c[(0, 0)], of.mass * c[(5, 5)] / c[(0, 0)]);
            let [twist, shear] = [self.free.twist, self.free.shear].map(|free| f64::from(u8::from(free)));
            of.rotary = Vector3::new(twist * (y + z), shear * y, shear * z);
        }
        of
    }
}

impl Beam {
    /// The section at a distance from the root (m).
    pub fn section_at(&self, s: f64) -> Section {
        section_at(&self.sections, s)
    }
}

/// The section at a distance from the root (m): between two that are given one of sizes between theirs, beyond them the nearest.
fn section_at(sections: &[(f64, Section)], s: f64) -> Section {
    let after = sections.partition_point(|(at, _)| *at <= s);
    match (sections.get(after.wrapping_sub(1)), sections.get(after)) {
        (Some((from, one)), Some((to, other))) => one.between(other, (s - from) / (to - from)).unwrap_or(*one),
        (Some((_, only)), None) | (None, Some((_, only))) => *only,
        (None, None) => Section::Stiffness(Matrix6::zeros()),
    }
}
