//! The structure that several models share, and the numbers that each has of its own.

use crate::model::{Joint, Link, Model};
use crate::spatial::Sym3;
use crate::spatial::lanes::{LaneMatrix, LaneSymmetric, LaneVector, Lanes, WIDTH, all, each, each_matrix, each_vector};
use crate::transfer::plan::{self, Kind, To};
use std::sync::Arc;

/// Models side by side, as the sweeps read them.
#[derive(Debug, Clone)]
pub struct Tree {
    pub(super) places: Vec<Place>,
    pub(super) numbers: Vec<Numbers>,
    pub(super) gravity: LaneVector,
    /// Sums of links with several children.
    pub(super) joins: usize,
    pub(super) velocities: usize,
    /// Whether positions and velocities of root markers are asked for.
    pub(super) placed: bool,
}

/// One link in the sweeps of all models.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) kind: Kind,
    pub(super) parent: usize,
    pub(super) position: usize,
    pub(super) velocity: usize,
    pub(super) is_leaf: bool,
    pub(super) join: Option<usize>,
    pub(super) to: To,
    /// Its axes are its parent's while its coordinates are zero.
    pub(super) straight: bool,
    pub(super) is_massless: bool,
    /// Its body has three different moments of inertia.
    pub(super) is_triaxial: bool,
    /// It slides, and so does everything that it hangs on.
    pub(super) translates: bool,
    /// Of some model digits may be lost in its pivot, as [`crate::transfer::plan`] says.
    pub(super) is_delicate: bool,
    pub(super) is_slender: bool,
    /// Rotors turn with it.
    pub(super) is_geared: bool,
    /// Whether `least` is anything.
    pub(super) is_light: bool,
}

/// The numbers of one link in each model.
#[derive(Debug, Clone, Copy)]
pub(super) struct Numbers {
    /// From the parent's root marker to the hinge (m), and the link's axes there.
    pub(super) offset: LaneVector,
    pub(super) turn: LaneMatrix,
    /// Of a slide.
    pub(super) axis: LaneVector,
    /// Of a screw (m/rad).
    pub(super) pitch: Lanes,
    /// Of the body: mass (kg), centre (m), and its inertia about the root marker (kg m²) as [`crate::spatial::Principal`] has it.
    pub(super) mass: Lanes,
    pub(super) center: LaneVector,
    pub(super) middle: Lanes,
    pub(super) excess: [Lanes; 2],
    pub(super) axes: [LaneVector; 2],
    /// The inertia, link axes.
    pub(super) inertia: LaneSymmetric,
    /// Of each coordinate of its hinge (kg, kg m²).
    pub(super) armature: [Lanes; 3],
    /// A pivot below this has lost digits; 0 where none can.
    pub(super) least: Lanes,
}

impl Tree {
    /// Models of one structure; `None` if theirs differ or have more than rigid bodies on elementary hinges. Loops, drives, gears
    /// and what acts on the bodies are not looked at.
    pub fn new(models: &[Arc<Model>; WIDTH], placed: bool) -> Option<Self> {
        let first = &models[0];
        let count = first.links.len();
        let rigid = |link: &Link| link.joint.rod().is_none();
        let alike = |model: &Arc<Model>| {
            model.links.len() == count && model.links.iter().zip(&first.links).all(|(one, other)| is_alike(one, other))
        };
        if !first.links.iter().all(rigid) || !models.iter().all(alike) {
            return None;
        }
        let plans = models.each_ref().map(|model| plan::plan(model));
        let joins = plans[0].1;
        let place = |index: usize| {
            let (link, own) = (&first.links[index], &plans[0].0[index]);
            let any = |of: &dyn Fn(usize) -> bool| (0..WIDTH).any(of);
            let coordinates = link.velocity..link.velocity + link.joint.counts().1;
            Place {
                kind: own.kind,
                parent: link.parent,
                position: link.position,
                velocity: link.velocity,
                is_leaf: own.is_leaf,
                join: own.join.map(|join| join as usize),
                to: own.to,
                straight: !any(&|lane| !models[lane].links[index].straight),
                is_massless: !any(&|lane| !models[lane].links[index].is_massless()),
                is_triaxial: any(&|lane| models[lane].links[index].principal.parts().1[1] != 0.0),
                translates: own.translates,
                is_delicate: any(&|lane| plans[lane].0[index].is_delicate),
                is_slender: any(&|lane| plans[lane].0[index].is_slender),
                is_geared: any(&|lane| {
                    models[lane].coordinates[coordinates.clone()].iter().any(|coordinate| coordinate.armature != 0.0)
                }),
                is_light: any(&|lane| plans[lane].0[index].least > 0.0),
            }
        };
        let numbers = |index: usize| {
            let least = each(|lane| plans[lane].0[index].least);
            Numbers::of(models, index, least)
        };
        Some(Self {
            places: (0..count).map(place).collect(),
            numbers: (0..count).map(numbers).collect(),
            gravity: each_vector(|lane| models[lane].gravity),
            joins,
            velocities: first.velocity_count(),
            placed,
        })
    }
}

/// Whether links of two models differ in numbers alone.
fn is_alike(one: &Link, other: &Link) -> bool {
    let same = std::mem::discriminant(&one.joint) == std::mem::discriminant(&other.joint);
    let places = |link: &Link| (link.parent, link.position, link.velocity, link.subtree_end, link.body);
    same && places(one) == places(other)
}

impl Numbers {
    fn of(models: &[Arc<Model>; WIDTH], index: usize, least: Lanes) -> Self {
        let link = |lane: usize| &models[lane].links[index];
        let parts = |lane: usize| link(lane).principal.parts();
        let entries = |inertia: &Sym3| [inertia.xx, inertia.xy, inertia.xz, inertia.yy, inertia.yz, inertia.zz];
        let (velocity, count) = (link(0).velocity, link(0).joint.counts().1);
        let armature = |i: usize| match i < count {
            true => each(|lane| models[lane].coordinates[velocity + i].armature),
            false => all(0.0),
        };
        let axis = |lane: usize| if let Joint::Slide { axis } = link(lane).joint { axis } else { nalgebra::zero() };
        Self {
            offset: each_vector(|lane| link(lane).offset),
            turn: each_matrix(|lane| link(lane).turn),
            axis: each_vector(axis),
            pitch: each(|lane| link(lane).joint.pitch()),
            mass: each(|lane| link(lane).mass),
            center: each_vector(|lane| link(lane).center),
            middle: each(|lane| parts(lane).0),
            excess: [0, 1].map(|i| each(|lane| parts(lane).1[i])),
            axes: [0, 1].map(|i| each_vector(|lane| parts(lane).2[i])),
            inertia: std::array::from_fn(|i| each(|lane| entries(&link(lane).inertia)[i])),
            armature: std::array::from_fn(armature),
            least,
        }
    }
}
