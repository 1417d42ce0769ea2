//! The surface of a beam: outlines of its cross sections along it, closed at both ends.

use super::Triangles;
use crate::element::section::Section;
use crate::record::tubes::Tube;
use crate::spatial::Pose;
use nalgebra::{Point3, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Sides of a round section.
const SIDES: usize = 16;

/// A surface of which the poses of the cross sections are still open.
#[derive(Debug, Clone)]
pub(in crate::record) struct Sweep {
    /// Index of the first cross section among the poses.
    pub(in crate::record) first: usize,
    /// Bodies at both ends.
    pub(in crate::record) ends: [usize; 2],
    /// For each cross section corners and unit normals, in its y and z; as many in all.
    outlines: Vec<Vec<[[f64; 2]; 2]>>,
    /// Three corners each: along the surface, then the two ends.
    pub(in crate::record) corners: Arc<Vec<[u32; 3]>>,
}

impl Sweep {
    /// Of a beam; sections thinner than a radius (m) are drawn as thick as that.
    pub(in crate::record) fn new(tube: &Tube, least: f64) -> Self {
        let outlines: Vec<_> = tube.sections.iter().map(|section| outline(section, tube.wire, least)).collect();
        let per = outlines[0].len();
        let mut corners = Vec::new();
        // Corners of a rectangle are there twice, with the normals of both sides.
        let is_side = |k: usize| outlines[0][k][0] != outlines[0][k + 1][0];
        for ring in 0..outlines.len() - 1 {
            let at = |ring: usize, k: usize| (ring * per + k) as u32;
            for k in (0..per - 1).filter(|k| is_side(*k)) {
                let ([a, b], [c, d]) = ([at(ring, k), at(ring, k + 1)], [at(ring + 1, k), at(ring + 1, k + 1)]);
                corners.extend([[a, b, d], [a, d, c]]);
            }
        }
        // Ends: the outline again with normals along the beam, as a fan.
        let base = outlines.len() * per;
        for k in (1..per - 1).filter(|k| is_side(*k)) {
            let at = |end: usize, k: usize| (base + end * per + k) as u32;
            corners.push([at(0, 0), at(0, k + 1), at(0, k)]);
            corners.push([at(1, 0), at(1, k), at(1, k + 1)]);
        }
        Self { first: tube.first, ends: [tube.begin, tube.tip()], outlines, corners: Arc::new(corners) }
    }

    /// Number of cross sections.
    pub(in crate::record) fn rings(&self) -> usize {
        self.outlines.len()
    }

    /// The poses of its cross sections; `None` if they are not in the list, or no numbers.
    pub(in crate::record) fn poses<'p>(&self, poses: &'p [Pose]) -> Option<&'p [Pose]> {
        let own = poses.get(self.first..self.first + self.rings())?;
        own.iter().all(|pose| pose.translation.vector.iter().all(|x| x.is_finite())).then_some(own)
    }

    /// The cross section that a corner of the surface belongs to.
    pub(in crate::record) fn ring_of(&self, corner: usize) -> usize {
        let per = self.outlines[0].len();
        match corner / per {
            ring if ring < self.rings() => ring,
            ring if ring == self.rings() => 0,
            _ => self.rings() - 1,
        }
    }

    /// The surface in inertial axes moved to a point (m): single precision has the digits there. Empty if the cross sections are nowhere.
    pub(in crate::record) fn triangles(&self, poses: &[Pose], origin: &Vector3<f64>) -> Triangles {
        let Some(poses) = self.poses(poses) else { return Triangles::default() };
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        let mut corner = |pose: &Pose, at: [f64; 2], normal: Vector3<f64>| {
            let place = pose * Point3::new(0.0, at[0], at[1]);
            positions.push((place.coords - origin).cast::<f32>().into());
            normals.push((pose.rotation * normal).cast::<f32>().into());
        };
        for (outline, pose) in self.outlines.iter().zip(poses) {
            outline.iter().for_each(|[at, normal]| corner(pose, *at, Vector3::new(0.0, normal[0], normal[1])));
        }
        let last = self.rings() - 1;
        for (end, normal) in [(0, -Vector3::x()), (last, Vector3::x())] {
            self.outlines[end].iter().for_each(|[at, _]| corner(&poses[end], *at, normal));
        }
        Triangles { positions, normals, corners: self.corners.to_vec(), closed: true, rings: 0 }
    }
}

/// Corners and normals around a section, the first one again at the end.
fn outline(section: &Section, wire: f64, least: f64) -> Vec<[[f64; 2]; 2]> {
    let round = |radius: f64| {
        let corner = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / SIDES as f64).sin_cos();
            [[radius * cos, radius * sin], [cos, sin]]
        };
        (0..=SIDES).map(corner).collect()
    };
    match *section {
        Section::Circle { radius } | Section::Tube { outer: radius, .. } => round(radius.max(least)),
        Section::Rectangle { width, height } => {
            // Both edges by one factor.
            let half = 0.5 * width.max(height);
            let grown = 0.5 * (least / half).max(1.0);
            let (y, z) = (grown * width, grown * height);
            let sides = [([y, -z], [y, z], [1.0, 0.0]), ([y, z], [-y, z], [0.0, 1.0])];
            let others = [([-y, z], [-y, -z], [-1.0, 0.0]), ([-y, -z], [y, -z], [0.0, -1.0])];
            sides.into_iter().chain(others).flat_map(|(a, b, normal)| [[a, normal], [b, normal]]).collect()
        }
        Section::Stiffness(_) => round(wire.max(least)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::drawing::triangles::volume;
    use crate::record::scene::{BodyPicture, Channel};
    use crate::record::tubes::Tubes;
    use crate::record::{Scene, beam};

    fn body(name: &str) -> BodyPicture {
        BodyPicture {
            name: name.into(),
            parent: None,
            mass: 1.0,
            center: [0.0; 3],
            inertia: [0.0; 6],
            markers: Vec::new(),
            shapes: Vec::new(),
            hinge: "fixed".into(),
            hinge_axes: Vec::new(),
            hinge_at: [0.0; 3],
            own_axes: Vec::new(),
        }
    }

    /// A rectangle of 2 × 1 m bent to a quarter of a circle of 10 m: the theorem of Pappus has its volume; all its corners are where
    /// a circle has them.
    #[test]
    fn a_bent_bar_has_the_volume_of_pappus() {
        let element = beam::ElementPicture {
            body: 1,
            from: 0.0,
            length: 5.0 * std::f64::consts::PI,
            degree: 0,
            free: vec![5],
            reference: vec![[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]],
        };
        let section = beam::SectionPicture { at: 0.0, kind: "rectangle".into(), size: vec![2.0, 1.0] };
        let scene = Scene {
            bodies: vec![body("bar"), body("bar/1")],
            positions: vec![Channel { body: "bar/1".into(), name: "bend_z_0".into(), unit: "rad".into() }],
            beams: vec![beam::BeamPicture {
                name: "bar".into(),
                begin: 0,
                elements: vec![element],
                sections: vec![section],
            }],
            ..Scene::default()
        };
        let tubes = Tubes::new(&scene);
        let mut poses = vec![Pose::identity(), Pose::identity()];
        tubes.extend(&[std::f64::consts::FRAC_PI_2], &mut poses);
        assert_eq!(poses.len(), 2 + 11);
        // Centre line of the circle, exactly: the element has constant strain.
        for pose in &poses[2..] {
            let off = (pose.translation.vector - Vector3::new(0.0, 10.0, 0.0)).norm() - 10.0;
            assert!(off.abs() < 1e-12, "{off}");
        }
        let sweep = Sweep::new(&tubes.beams[0], 0.0);
        let found = volume(&sweep.triangles(&poses, &Vector3::zeros())) / (2.0 * 5.0 * std::f64::consts::PI);
        // Ten chords in place of the arc: 1 − (π/20)²/6.
        assert!((found - 1.0 + (std::f64::consts::PI / 20.0).powi(2) / 6.0).abs() < 1e-4, "{found}");
    }
}
