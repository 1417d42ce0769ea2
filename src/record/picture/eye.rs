//! Where a picture is seen from, and what of the scene is in its frame.

use super::super::drawing::Drawing;
use super::super::drawing::bounds::Bounds;
use super::super::drawing::ground::{Ground, back};
use crate::spatial::Pose;
use nalgebra::{Point3, Vector3};

/// Empty part of the picture at each side.
const MARGIN: f64 = 0.08;
/// Height of the line of the scale bar (pixels).
pub(super) const FOOT: f64 = 44.0;

/// The direction that a scene is seen from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Eye {
    /// A little from above, across the direction in which the scene is thinnest.
    Auto,
    /// Azimuth from the x axis towards y, and elevation above the horizon (rad).
    At {
        /// Azimuth (rad).
        azimuth: f64,
        /// Elevation (rad).
        elevation: f64,
    },
}

impl Eye {
    /// `front` (against y), `back`, `left` (along x), `right`, `top`, `iso`, or azimuth and elevation in degrees: `30,20`.
    ///
    /// # Errors
    /// What is allowed, of any other text.
    pub fn parse(text: &str) -> Result<Self, String> {
        let at = |azimuth: f64, elevation: f64| {
            Ok(Self::At { azimuth: azimuth.to_radians(), elevation: elevation.to_radians() })
        };
        match text {
            "auto" => Ok(Self::Auto),
            "front" => at(-90.0, 0.0),
            "back" => at(90.0, 0.0),
            "left" => at(180.0, 0.0),
            "right" => at(0.0, 0.0),
            "top" => at(-90.0, 90.0),
            "iso" => at(-45.0, 35.264),
            _ => {
                let angles =
                    text.split_once(',').and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
                match angles {
                    Some((azimuth, elevation)) if f64::abs(azimuth) <= 360.0 && f64::abs(elevation) <= 90.0 => {
                        at(azimuth, elevation)
                    }
                    _ => Err(format!(
                        "`{text}` is no camera: auto, front, back, left, right, top, iso, or azimuth (−360 … 360) and elevation \
                         (−90 … 90) in degrees as `30,20`"
                    )),
                }
            }
        }
    }
}

/// A parallel projection onto a picture of some size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Where axes of the eye begin, inertial axes (m): amid what is seen, so that far away no digits are lost.
    origin: Vector3<f64>,
    pub(super) right: Vector3<f64>,
    pub(super) up: Vector3<f64>,
    /// Towards the eye.
    pub(super) back: Vector3<f64>,
    /// Middle of the picture, in axes of the eye (m).
    middle: [f64; 2],
    /// Width and height of what is framed (m).
    extent: [f64; 2],
    /// Pixels in a metre.
    pub(super) scale: f64,
    /// Width and height (pixels).
    pub(super) size: [u32; 2],
    pub(super) ground: Ground,
    /// Corners of the floor that is drawn: least and greatest x and y (m); `None` where there is none.
    pub(super) floor: Option<[[f64; 2]; 2]>,
}

impl Frame {
    /// Shows the whole drawing in all of these poses.
    pub fn new<'p>(
        drawing: &Drawing,
        poses: impl IntoIterator<Item = &'p [Pose]> + Clone,
        eye: Eye,
        size: [u32; 2],
    ) -> Self {
        let bounds = drawing.bounds(poses.clone());
        let back = match eye {
            Eye::Auto => back(&bounds),
            Eye::At { azimuth, elevation } => {
                Vector3::new(elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin())
            }
        };
        // From straight above, up is what lies ahead.
        let (azimuth, flat) = match eye {
            Eye::At { azimuth, elevation } => (azimuth, elevation.cos().abs() < 1e-6),
            Eye::Auto => (0.0, false),
        };
        let right = match flat {
            true => Vector3::new(-azimuth.sin(), azimuth.cos(), 0.0),
            false => Vector3::z().cross(&back).normalize(),
        };
        let up = back.cross(&right);
        let ground = Ground::under(&bounds);
        let floor = drawing.has_ground().then(|| floor(&bounds, ground.spacing));
        let origin = bounds.center();
        let mut frame =
            Self { origin, right, up, back, middle: [0.0; 2], extent: [0.0; 2], scale: 1.0, size, ground, floor };
        let mut seen = Bounds::default();
        for ([i, j], floor) in [[0, 0], [0, 1], [1, 0], [1, 1]].into_iter().zip(floor.iter().cycle()) {
            let corner = Vector3::new(floor[i][0], floor[j][1], ground.floor);
            seen.include(&frame.turned(&corner), 0.0);
        }
        for poses in poses {
            drawing.each_corner(poses, |corner| seen.include(&frame.turned(&corner), 0.0));
        }
        let (center, extent) = (seen.center(), seen.size());
        let room = [0, 1].map(|k| f64::from(size[k]) * (1.0 - 2.0 * MARGIN) - if k == 1 { FOOT } else { 0.0 });
        frame.middle = [center.x, center.y];
        frame.extent = [extent.x, extent.y];
        frame.scale = (room[0].max(1.0) / extent.x.max(1e-9)).min(room[1].max(1.0) / extent.y.max(1e-9));
        frame
    }

    /// What a viewer that moves needs: azimuth and elevation (rad), the middle of the picture (m), width and height of what is framed (m), the
    /// length of the room that all poses take (m), the floor or null.
    pub fn look(&self, drawing: &Drawing, poses: &[&[Pose]]) -> serde_json::Value {
        let middle = self.origin + self.middle[0] * self.right + self.middle[1] * self.up;
        serde_json::json!({
            "azimuth": self.back.y.atan2(self.back.x),
            "elevation": self.back.z.clamp(-1.0, 1.0).asin(),
            "center": [middle.x, middle.y, middle.z],
            "framed": self.extent,
            "margin": MARGIN,
            "extent": drawing.length(poses),
            "floor": self.floor,
            "height": self.ground.floor,
            "spacing": self.ground.spacing,
        })
    }

    /// A point in axes of the eye (m).
    pub(super) fn turned(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.direction(&(point - self.origin))
    }

    /// A direction in axes of the eye.
    pub(super) fn direction(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(self.right.dot(vector), self.up.dot(vector), self.back.dot(vector))
    }

    /// Whether a polygon in axes of the eye may be seen: not all of it is beyond one edge of the picture.
    pub(super) fn shows(&self, points: &[Vector3<f64>]) -> bool {
        let places: Vec<[f64; 2]> = points.iter().map(|point| self.place(point)).collect();
        let beyond = |k: usize, size: f64| places.iter().all(|at| at[k] < 0.0) || places.iter().all(|at| at[k] > size);
        !(beyond(0, f64::from(self.size[0])) || beyond(1, f64::from(self.size[1])))
    }

    /// Place in the picture of a point in axes of the eye (pixels, from the upper left corner).
    pub(super) fn place(&self, turned: &Vector3<f64>) -> [f64; 2] {
        let [width, height] = self.size.map(f64::from);
        let [x, y] = self.middle;
        [0.5 * width + self.scale * (turned.x - x), 0.5 * (height - FOOT) - self.scale * (turned.y - y)]
    }
}

/// Whole squares of the grid around what stands on it.
fn floor(bounds: &Bounds, spacing: f64) -> [[f64; 2]; 2] {
    let (low, high) = (bounds.center() - 0.5 * bounds.size(), bounds.center() + 0.5 * bounds.size());
    let squares = |at: f64, round: fn(f64) -> f64, more: f64| (round(at / spacing) + more) * spacing;
    let ends = |k: usize| (squares(low[k], f64::floor, -1.0), squares(high[k], f64::ceil, 1.0));
    let (x, y) = (ends(0), ends(1));
    [[x.0, y.0], [x.1, y.1]]
}

impl Drawing {
    /// The room that all takes in these poses.
    fn room(&self, poses: &[&[Pose]]) -> Bounds {
        let mut bounds = Bounds::default();
        poses.iter().for_each(|poses| self.each_corner(poses, |corner| bounds.include(&corner, 0.0)));
        bounds
    }

    /// How long the room is that all takes in these poses (m).
    pub fn length(&self, poses: &[&[Pose]]) -> f64 {
        self.room(poses).size().norm()
    }

    /// Corners of boxes around all parts, in inertial axes.
    fn each_corner(&self, poses: &[Pose], mut take: impl FnMut(Vector3<f64>)) {
        for part in self.parts.iter().filter(|part| !part.unbounded) {
            let placement = part.place(poses);
            let mut bounds = Bounds::default();
            part.shape(poses).triangles.positions.iter().for_each(|at| bounds.include(&Vector3::from(*at).cast(), 0.0));
            for corner in bounds.corners() {
                let at = placement.pose * Point3::from(corner.component_mul(&Vector3::from(placement.scale)));
                take(at.coords);
            }
        }
    }
}
