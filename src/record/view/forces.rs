//! Springs, loads and reactions: what pushes, drawn.

use super::entity::{color, path, point};
use super::sdk::{Arrows3D, Color, EntityPath, LineStrips3D, Radius};
use super::sent::Sent;
use super::stream::Stream;
use crate::record::scene::{LinePicture, LoadPicture};
use crate::record::{ContactPush, Scene};
use crate::spatial::{Pose, Wrench};
use nalgebra::{Point3, Vector3};
use std::collections::HashSet;

/// A push, a torque, a reaction.
const FORCE: Color = Color(super::sdk::Rgba32::from_rgb(200, 60, 40));
const TORQUE: Color = Color(super::sdk::Rgba32::from_rgb(130, 70, 170));
pub(super) const REACTION: Color = Color(super::sdk::Rgba32::from_rgb(40, 110, 60));
const STICK: Color = Color(super::sdk::Rgba32::from_rgb(46, 158, 69));
const SLIP: Color = Color(super::sdk::Rgba32::from_rgb(237, 125, 26));
/// The longest arrow against the scene.
const ARROW: f64 = 0.25;
/// The shortest against the longest.
const SHORTEST: f64 = 0.2;

/// Turns of a coil and points in a turn.
const TURNS: usize = 7;
const POINTS_PER_TURN: usize = 8;
/// Part of a spring on both ends that is straight.
const STRAIGHT: f64 = 0.12;

/// The looks that depend on the whole scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scales {
    /// Extent of the scene (m).
    pub(super) size: f64,
    /// The pull at which a spring has its full colour (N).
    pub(super) tension: f64,
    /// The reaction that is drawn longest (N); zero where none are drawn.
    pub(super) reaction: f64,
    /// The weight of the scene on earth (N).
    pub(super) weight: f64,
    /// What beams bear at most (Pa, or N m if one has no size).
    pub(super) borne: f64,
}

/// Where the points of a line are.
pub(super) fn points(line: &LinePicture, poses: &[Pose]) -> Vec<Vector3<f64>> {
    let place = |(body, at): &(Option<usize>, [f64; 3])| {
        let pose = body.and_then(|body| poses.get(body)).copied().unwrap_or_default();
        (pose * Point3::from(*at)).coords
    };
    line.ends.iter().map(place).collect()
}

/// What a spring or rope pulls with, without its damper (N); `None` for other lines.
pub(super) fn tension(line: &LinePicture, poses: &[Pose]) -> Option<f64> {
    let [stiffness, length] = line.spring?;
    let path: f64 = points(line, poses).windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    let pull = stiffness * (path - length);
    Some(if line.pulls_only { pull.max(0.0) } else { pull })
}

/// From blue (pushes) over grey to red (pulls).
pub(super) fn spring_color(tension: Option<f64>, full: f64) -> Color {
    const RELAXED: [f64; 3] = [0.38, 0.41, 0.36];
    const PULLED: [f64; 3] = [0.83, 0.18, 0.12];
    const PUSHED: [f64; 3] = [0.12, 0.35, 0.80];
    let part = tension.map_or(0.0, |tension| (tension / full).clamp(-1.0, 1.0));
    let part = if part.is_finite() { part } else { 0.0 };
    let goal = if part > 0.0 { PULLED } else { PUSHED };
    let mix = |k: usize| RELAXED[k] + part.abs() * (goal[k] - RELAXED[k]);
    color([mix(0), mix(1), mix(2), 1.0])
}

/// A line through points; between two of them with a radius as a coil, or as a damper.
pub(super) fn strip(points: &[Vector3<f64>], radius: Option<f64>, is_damper: bool) -> Vec<[f32; 3]> {
    let (&[a, b], Some(radius)) = (points, radius) else { return points.iter().map(point).collect() };
    let along = b - a;
    let Some(axis) = along.try_normalize(1e-12) else { return vec![point(&a), point(&b)] };
    let side = if axis.x.abs() < 0.8 { Vector3::x() } else { Vector3::y() };
    let first = axis.cross(&side).normalize();
    let second = axis.cross(&first);
    if is_damper {
        // A cup, and a piston within it, without lifting the pen.
        let trace = [(0.0, 0.0), (0.3, 0.0), (0.3, 1.0), (0.75, 1.0), (0.3, 1.0), (0.3, -1.0), (0.75, -1.0)];
        let piston = [(0.3, -1.0), (0.3, 0.0), (0.55, 0.0), (0.55, 0.8), (0.55, -0.8), (0.55, 0.0), (1.0, 0.0)];
        let place = |(part, aside): (f64, f64)| a + part * along + aside * radius * first;
        return trace.into_iter().chain(piston).map(|at| point(&place(at))).collect();
    }
    let count = TURNS * POINTS_PER_TURN;
    let coil = (0..=count).map(|k| {
        let part = k as f64 / count as f64;
        let (sin, cos) = (std::f64::consts::TAU * TURNS as f64 * part).sin_cos();
        a + (STRAIGHT + part * (1.0 - 2.0 * STRAIGHT)) * along + radius * (cos * first + sin * second)
    });
    let on_axis = [STRAIGHT, 1.0 - STRAIGHT].map(|part| a + part * along);
    let begin = [a, on_axis[0]].into_iter();
    begin.chain(coil).chain([on_axis[1], b]).map(|at| point(&at)).collect()
}

pub(super) fn spring_path(name: &str) -> EntityPath {
    path(&["springs", name])
}

fn load_path(name: &str) -> EntityPath {
    path(&["loads", name])
}

pub(super) fn contacts_path() -> EntityPath {
    path(&["contacts"])
}

pub(super) fn reactions_path() -> EntityPath {
    path(&["reactions"])
}

/// Where the arrows of loads start that keep their direction in space, in the order of the scene's loads.
pub(super) fn load_points(scene: &Scene, poses: &[Pose]) -> Vec<[f32; 3]> {
    let at = |load: &LoadPicture| {
        let pose = poses.get(load.body).copied().unwrap_or_default();
        point(&(pose * Point3::from(load.at)).coords)
    };
    scene.loads.iter().filter(|load| !load.turns).map(at).collect()
}

/// The paths that these points belong to.
pub(super) fn load_paths(scene: &Scene) -> impl Iterator<Item = EntityPath> {
    scene.loads.iter().filter(|load| !load.turns).map(|load| load_path(&load.name))
}

/// Sends what does not change: looks of springs, arrows of loads.
pub(super) fn send(stream: &Stream, scene: &Scene, scales: &Scales) -> Sent {
    for line in &scene.lines {
        let looks = LineStrips3D::update_fields().with_radii([Radius::new_ui_points(1.6)]);
        // What is sent once for all hides what is sent with a time: the colour of springs is.
        let looks = if line.spring.is_some() { looks } else { looks.with_colors([spring_color(None, 1.0)]) };
        stream.log(spring_path(&line.name), &looks)?;
    }
    let largest = scene.largest_loads();
    for load in &scene.loads {
        let (mut vectors, mut colors) = (Vec::new(), Vec::new());
        for ((of, full), color) in parts(load, largest).zip([FORCE, TORQUE]) {
            if let Some(arrow) = arrow(&of, full, scales.size) {
                vectors.push(point(&arrow));
                colors.push(color);
            }
        }
        if vectors.is_empty() {
            continue;
        }
        let looks = Arrows3D::update_fields().with_colors(colors).with_radii([Radius::new_ui_points(2.5)]);
        // What is sent once for all hides what is sent with a time: arrows of loads that change are.
        let looks = if load.over_time.is_some() { looks } else { looks.with_vectors(vectors) };
        let looks = if load.turns { looks.with_origins([point(&Vector3::from(load.at))]) } else { looks };
        stream.log(arrows_path(scene, load), &looks)?;
    }
    Ok(())
}

/// Force and torque of a load at their full size, each with the largest of all loads.
fn parts(load: &LoadPicture, [force, torque]: [f64; 2]) -> impl Iterator<Item = (Vector3<f64>, f64)> {
    [(load.force.into(), force), (load.torque.into(), torque)].into_iter()
}

/// Where the arrows of a load are in the viewer.
fn arrows_path(scene: &Scene, load: &LoadPicture) -> EntityPath {
    match load.turns {
        true => path(&["world", &scene.bodies[load.body].name, &load.name]),
        false => load_path(&load.name),
    }
}

/// The loads that change over time, each with the path of its arrows.
pub(super) fn changing_loads(scene: &Scene) -> impl Iterator<Item = (&LoadPicture, EntityPath)> {
    scene.loads.iter().filter(|load| load.over_time.is_some()).map(|load| (load, arrows_path(scene, load)))
}

/// The arrows of a load at a time (s): as many at all times.
pub(super) fn load_arrows(scene: &Scene, load: &LoadPicture, time: f64, scales: &Scales) -> Vec<[f32; 3]> {
    let factor = load.factor(time);
    let is_there = |(of, full): &(Vector3<f64>, f64)| arrow(of, *full, scales.size).is_some();
    let drawn = |(of, full)| arrow(&(factor * of), full, scales.size).unwrap_or_default();
    parts(load, scene.largest_loads()).filter(is_there).map(|part| point(&drawn(part))).collect()
}

/// A vector as long as it is drawn; `None` for zero.
fn arrow(vector: &Vector3<f64>, full: f64, size: f64) -> Option<Vector3<f64>> {
    let length = vector.norm();
    let direction = vector.try_normalize(0.0).filter(|_| full > 0.0)?;
    Some(direction * (ARROW * size * (length / full).clamp(SHORTEST, 1.0)))
}

/// What contacts push with as arrows, full length for the weight of the scene: origins, vectors and colours.
pub(super) fn contact_arrows(
    pushes: &[ContactPush],
    still: &HashSet<String>,
    scales: &Scales,
) -> Vec<([f32; 3], [f32; 3], Color)> {
    let one = |push: &ContactPush| {
        let drawn = arrow(&Vector3::from(push.drawn(still)), scales.weight, scales.size)?;
        Some((point(&Vector3::from(push.point)), point(&drawn), if push.slips { SLIP } else { STICK }))
    };
    pushes.iter().filter_map(one).collect()
}

/// Reactions as arrows at the root markers: origins and vectors.
pub(super) fn reaction_arrows(poses: &[Pose], reactions: &[Wrench], scales: &Scales) -> Vec<([f32; 3], [f32; 3])> {
    let scale = ARROW * scales.size / scales.reaction;
    let one = |(pose, reaction): (&Pose, &Wrench)| (point(&pose.translation.vector), point(&(scale * reaction.force)));
    poses.iter().zip(reactions).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spring(stiffness: f64, length: f64) -> LinePicture {
        LinePicture {
            name: String::new(),
            ends: vec![(None, [0.0; 3]), (Some(0), [0.0, 0.0, 1.0])],
            spring: Some([stiffness, length]),
            ..LinePicture::default()
        }
    }

    #[test]
    fn a_spring_pulls_by_its_law_and_turns_red_with_it() {
        let poses = [Pose::translation(0.0, 3.0, 3.0)];
        // Its ends are five metres apart.
        assert_eq!(tension(&spring(10.0, 2.0), &poses), Some(30.0));
        // A rope of six metres is slack there, one through a third point is not.
        let rope = LinePicture { pulls_only: true, ..spring(10.0, 6.0) };
        assert_eq!(tension(&rope, &poses), Some(0.0));
        let mut longer = rope.clone();
        longer.ends.insert(1, (None, [0.0, -3.0, 0.0]));
        assert_eq!(tension(&longer, &poses), Some(10.0 * (3.0 + 52.0_f64.sqrt() - 6.0)));
        assert_eq!(tension(&LinePicture { spring: None, ..spring(1.0, 1.0) }, &poses), None);
        let red = |part: f64| spring_color(Some(part), 1.0).0.to_array()[0];
        let blue = |part: f64| spring_color(Some(part), 1.0).0.to_array()[2];
        assert!(red(1.0) > red(0.5) && red(0.5) > red(0.0));
        assert!(blue(-1.0) > blue(-0.5) && blue(-0.5) > blue(0.0));
        assert_eq!(spring_color(Some(f64::NAN), 1.0), spring_color(None, 1.0));
    }

    #[test]
    fn a_coil_meets_both_ends_and_stays_within_its_radius() {
        let (a, b) = (Vector3::new(1.0, 0.0, 0.0), Vector3::new(1.0, 2.0, 0.0));
        let coil = strip(&[a, b], Some(0.1), false);
        assert_eq!((coil.first(), coil.last()), (Some(&[1.0, 0.0, 0.0]), Some(&[1.0, 2.0, 0.0])));
        let off = |at: &[f32; 3]| ((at[0] - 1.0).powi(2) + at[2].powi(2)).sqrt();
        let widest = coil.iter().map(off).fold(0.0, f32::max);
        assert!((widest - 0.1).abs() < 1e-6, "{widest}");
        assert_eq!(strip(&[a, a], Some(0.1), false).len(), 2, "a spring without length is no coil");
    }
}
