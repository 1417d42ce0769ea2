//! URDF: links and joints of a robot.
//!
//! | URDF | scenario |
//! |---|---|
//! | link | body; its axes are the link's |
//! | joint | the hinge of the child: `origin` is `at` and `rpy`, `axis` is `axis` |
//! | revolute, continuous | `revolute`, with `limits` |
//! | prismatic | `prismatic`, with `limits` |
//! | fixed | `fixed` |
//! | floating | `free` |
//! | planar | `planar`; where the axis is not z between two welds that turn z there |
//! | mimic | gear with an `offset` |
//! | dynamics damping, friction | `damping`, `friction` |
//! | inertial | `mass`, `center`, `inertia`, turned into the link's axes |
//! | visual, else collision | `shape` |
//!
//! The root hangs on the ground. Everything else of the file becomes a note.

mod joint;
mod link;
mod pose;
mod shape;
mod tree;

use super::Options;
use super::draft::{Draft, Entry};
use super::log::{Problem, Taken};
use super::xml::Element;
use std::path::Path;
use tree::Tree;

/// Reads a `<robot>`; `None` if too little of it makes sense.
pub(super) fn read(root: &Element<'_>, path: &Path, options: &Options) -> Option<Draft> {
    if is_macro(root) {
        return None;
    }
    let mut tree = Tree::read(root, options)?;
    if options.weld_massless {
        joint::weld_massless(&mut tree);
    }
    let looks = shape::Looks::read(root, path, options);
    let mut draft = Draft::new();
    let name = root.text("name").unwrap_or("robot");
    let file = path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned());
    draft.set("title", &format!("Imported from {file}."), name, root.attribute("name").map(|name| name.place()));
    let mut touching = 0;
    let mut movers = vec![String::new(); tree.joints.len()];
    for &index in &tree.order {
        let link = &tree.links[index];
        let mut body = Entry::new(Some(link.element.place()));
        match link.joint {
            Some(joint) => {
                movers[joint] = joint::write(&tree.joints[joint], &tree, &mut body, &mut draft, options);
                draft.joint(tree.joints[joint].name, &movers[joint]);
            }
            None => joint::root(link, &mut body, options),
        }
        link::write(&link.element, &mut body);
        touching += looks.write(&link.element, &mut body);
        draft.add("body", body);
    }
    joint::gears(&tree, &movers, &mut draft, options);
    root.text("version");
    if touching > 0 {
        let shapes = if touching == 1 { "shape that collides touches" } else { "shapes that collide touch" };
        let what =
            format!("{touching} {shapes} what a `[[contact]]` names together with their bodies, and with its friction");
        root.note(Taken::Used, what);
    }
    root.sweep(reason);
    Some(draft)
}

/// Whether this is a program that writes a URDF; that is said.
fn is_macro(root: &Element<'_>) -> bool {
    let Some(found) = root.of_namespace("xacro") else { return false };
    let message = format!("<{}> is a macro of xacro", found.name());
    let help = "expand it first, as in `xacro robot.urdf.xacro > robot.urdf`";
    root.refuse(Problem::at(found.place(), message).help(help));
    true
}

/// Why an element is left alone, by its tag.
fn reason(tag: &str) -> Option<&'static str> {
    Some(match tag {
        "transmission" => "actuators and their gears are not imported: describe them with `[[motor]]` and `[[gear]]`",
        "gazebo" => "meant for Gazebo",
        "ros2_control" | "ros_control" => "controllers are not imported: describe them with `[[controller]]`",
        "sensor" => "sensors are not imported: describe what they measure with `[[output]]`",
        "mujoco" | "drake" => "meant for another simulator",
        "safety_controller" => "controllers are not imported: describe them with `[[controller]]`",
        "calibration" => "reference positions of real joints are not used",
        "contact" | "contact_coefficients" => {
            "a URDF has no law of contact: `[[contact]]` says what touches what, with `[model] contact = true`"
        }
        "texture" => "textures are not drawn",
        _ => return None,
    })
}
