//! `/robot_description` and `/joint_states`: the same scene as ROS 2 messages, by which programs that know nothing of
//! Foxglove's scene updates draw the bodies and plot the hinges. Nothing of ours reads them back.
//!
//! The description is a URDF in which every body hangs on the inertial frame: where it is then says `/tf`. Both are left
//! out of large scenes, whose recordings they would swell.

use super::frames::inertial_frame;
use crate::markup::escape;
use crate::record::scene::BodyPicture;
use crate::record::solids::{Form, Solid, solids};
use crate::record::{Sample, Scene};
use nalgebra::{Isometry3, Translation3, Vector3};
use re_cdr::{CdrWriter, LittleEndian};
use std::fmt::Write;

/// More bodies are not described.
const MOST_BODIES: usize = 1000;
/// More hinges are not told.
const MOST_HINGES: usize = 64;

pub(super) const STRING: &str = "std_msgs/msg/String";
pub(super) const STRING_SCHEMA: &str = "string data\n";
pub(super) const JOINTS: &str = "sensor_msgs/msg/JointState";
pub(super) const JOINTS_SCHEMA: &str = "\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

/// What comes before every message: plain CDR, little endian.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// The message with the description; `None` of a large scene, or one without bodies.
pub(super) fn description(scene: &Scene) -> Option<Vec<u8>> {
    if scene.bodies.is_empty() || scene.bodies.len() > MOST_BODIES {
        return None;
    }
    let mut message = ENCAPSULATION.to_vec();
    let mut body = Vec::new();
    CdrWriter::<LittleEndian>::new(&mut body).write_string(&urdf(scene));
    message.append(&mut body);
    Some(message)
}

/// The scene as a URDF. Capsules are put together of what URDF has; meshes are named by their file.
fn urdf(scene: &Scene) -> String {
    let world = inertial_frame(scene);
    let mut text = format!("<robot name=\"scene\">\n  <link name=\"{world}\"/>\n");
    // Writing to a `String` cannot fail.
    for (body, solids) in scene.bodies.iter().zip(solids(scene)) {
        let name = escape(&body.name);
        let _ = writeln!(text, "  <link name=\"{name}\">");
        for (index, solid) in solids.iter().enumerate() {
            visual(&mut text, &format!("{name} {index}"), solid);
        }
        let _ = writeln!(text, "  </link>\n  <joint name=\"{name} place\" type=\"floating\">");
        let _ = writeln!(text, "    <parent link=\"{world}\"/><child link=\"{name}\"/>\n  </joint>");
    }
    text + "</robot>\n"
}

fn visual(text: &mut String, name: &str, solid: &Solid) {
    let Isometry3 { rotation, .. } = solid.pose;
    let at =
        |along: f64| Isometry3::from_parts((solid.pose * Translation3::new(0.0, 0.0, along)).translation, rotation);
    let parts: Vec<(String, Isometry3<f64>)> = match &solid.form {
        Form::Box([x, y, z]) => vec![(format!("<box size=\"{x} {y} {z}\"/>"), at(0.0))],
        Form::Ball(radius) => vec![(format!("<sphere radius=\"{radius}\"/>"), at(0.0))],
        Form::Cylinder { radius, length } => vec![(cylinder(*radius, *length), at(0.0))],
        Form::Capsule { radius, length } => vec![
            (cylinder(*radius, *length), at(0.0)),
            (format!("<sphere radius=\"{radius}\"/>"), at(-0.5 * length)),
            (format!("<sphere radius=\"{radius}\"/>"), at(0.5 * length)),
        ],
        Form::Mesh { file, scale: [x, y, z], .. } => {
            vec![(format!("<mesh filename=\"{}\" scale=\"{x} {y} {z}\"/>", escape(file)), at(0.0))]
        }
    };
    let [r, g, b, a] = solid.color;
    for (geometry, pose) in parts {
        let (p, (roll, pitch, yaw)) = (pose.translation.vector, pose.rotation.euler_angles());
        let _ = writeln!(
            text,
            "    <visual><origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/><geometry>{geometry}</geometry>\
             <material name=\"{name}\"><color rgba=\"{r} {g} {b} {a}\"/></material></visual>",
            p.x, p.y, p.z
        );
    }
}

fn cylinder(radius: f64, length: f64) -> String {
    format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>")
}

/// The hinges with one coordinate: what a joint of ROS can be.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Joints {
    joints: Vec<Joint>,
}

#[derive(Debug, Clone, PartialEq)]
struct Joint {
    name: String,
    body: usize,
    parent: Option<usize>,
    axis: Vector3<f64>,
    slides: bool,
    position: usize,
    velocity: usize,
}

impl Joints {
    /// Of a scene; `None` if there are none or many.
    pub(super) fn new(scene: &Scene) -> Option<Self> {
        let joint = |(index, body): (usize, &BodyPicture)| {
            let slides = body.hinge == "prismatic";
            let axis = *body.hinge_axes.first().filter(|_| slides || body.hinge == "revolute")?;
            Some(Joint {
                name: body.name.clone(),
                body: index,
                parent: body.parent,
                axis: Vector3::from(axis),
                slides,
                position: scene.positions.iter().position(|channel| channel.body == body.name)?,
                velocity: scene.velocities.iter().position(|channel| channel.body == body.name)?,
            })
        };
        // Before looking them up: that takes a time proportional to the square of their number.
        let single = scene.bodies.iter().filter(|body| matches!(body.hinge.as_str(), "revolute" | "prismatic")).count();
        if single == 0 || single > MOST_HINGES {
            return None;
        }
        Some(Self { joints: scene.bodies.iter().enumerate().filter_map(joint).collect() })
    }

    /// Appends the message of a sample: positions, velocities, and what the hinge's springs, dampers and motors push
    /// along its axis (N or N m).
    pub(super) fn put(&self, sample: &Sample, nanoseconds: u64, buffer: &mut Vec<u8>) {
        buffer.extend(ENCAPSULATION);
        let mut out = CdrWriter::<LittleEndian>::new(buffer);
        out.write_i32(i32::try_from(nanoseconds / 1_000_000_000).unwrap_or(i32::MAX));
        out.write_u32((nanoseconds % 1_000_000_000) as u32);
        out.write_string("");
        out.write_sequence_length(self.joints.len());
        self.joints.iter().for_each(|joint| out.write_string(&joint.name));
        let values: [&dyn Fn(&Joint) -> f64; 3] =
            [&|joint| sample.positions[joint.position], &|joint| sample.velocities[joint.velocity], &|joint| {
                joint.effort(sample)
            }];
        for value in values {
            out.write_sequence_length(self.joints.len());
            self.joints.iter().for_each(|joint| out.write_f64(value(joint)));
        }
    }
}

impl Joint {
    fn effort(&self, sample: &Sample) -> f64 {
        let turn = self.parent.map_or_else(Default::default, |parent| sample.bodies[parent].rotation);
        let (axis, reaction) = (turn * self.axis, &sample.reactions[self.body]);
        if self.slides { axis.dot(&reaction.force) } else { axis.dot(&reaction.moment) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::scene::{Channel, ShapePicture};
    use crate::record::{Energy, OwnedSample};
    use crate::spatial::{Pose, Wrench};
    use re_cdr::CdrReader;

    fn scene() -> Scene {
        let shape = ShapePicture {
            kind: "capsule".into(),
            size: vec![0.1, 1.0],
            file: None,
            position: [0.0, 0.0, -0.5],
            quaternion: [1.0, 0.0, 0.0, 0.0],
            color: Some([1.0, 0.5, 0.0, 1.0]),
        };
        let arm = BodyPicture {
            name: "arm <1>".into(),
            parent: None,
            mass: 1.0,
            center: [0.0; 3],
            inertia: [0.0; 6],
            markers: Vec::new(),
            shapes: vec![shape],
            hinge: "revolute".into(),
            hinge_axes: vec![[0.0, 1.0, 0.0]],
            hinge_at: [0.0; 3],
            own_axes: Vec::new(),
        };
        let channel = |unit: &str| Channel { body: "arm <1>".into(), name: "angle".into(), unit: unit.into() };
        Scene {
            bodies: vec![arm],
            positions: vec![channel("rad")],
            velocities: vec![channel("rad/s")],
            ..Scene::default()
        }
    }

    #[test]
    fn the_description_has_every_solid_in_its_body() {
        let text = urdf(&scene());
        assert_eq!(text.matches("<visual>").count(), 3, "a capsule is a cylinder and two balls: {text}");
        assert!(text.contains("<link name=\"arm &lt;1&gt;\">") && text.contains("xyz=\"0 0 -1\""), "{text}");
        assert!(text.contains("<parent link=\"world\"/><child link=\"arm &lt;1&gt;\"/>"), "{text}");
        let message = description(&scene()).expect("a small scene");
        let mut reader = CdrReader::<LittleEndian>::new(&message[4..]);
        assert_eq!(reader.read_string().expect("a string"), text);
        let many = Scene { bodies: vec![scene().bodies.remove(0); MOST_BODIES + 1], ..Scene::default() };
        assert_eq!(description(&many), None);
    }

    #[test]
    fn the_effort_is_what_the_hinge_pushes_along_its_axis() {
        let moment = Vector3::new(1.0, 7.0, 3.0);
        let sample = OwnedSample {
            time: 1.5,
            positions: vec![0.25],
            velocities: vec![-2.0],
            accelerations: vec![0.0],
            bodies: vec![Pose::identity()],
            reactions: vec![Wrench { force: Vector3::zeros(), moment }],
            couplings: Vec::new(),
            outputs: Vec::new(),
            energy: Energy::default(),
        };
        let mut message = Vec::new();
        Joints::new(&scene()).expect("a joint").put(&sample.borrow(), 1_500_000_000, &mut message);
        let mut reader = CdrReader::<LittleEndian>::new(&message[4..]);
        assert_eq!((reader.read_i32().expect("s"), reader.read_u32().expect("ns")), (1, 500_000_000));
        assert_eq!(reader.read_string().expect("frame"), "");
        assert_eq!(reader.read_u32().expect("one name"), 1);
        assert_eq!(reader.read_string().expect("name"), "arm <1>");
        for expected in [0.25, -2.0, 7.0] {
            assert_eq!(reader.read_u32().expect("one number"), 1);
            assert_eq!(reader.read_f64().expect("a number"), expected);
        }
    }
}
