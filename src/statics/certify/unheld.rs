//! Scenes that cannot rest, whatever their position: a constant force in a direction that nothing feels.
//!
//! The trees of links that stand on the ground, joined by force elements and loops, fall into components. A component that nothing
//! joins to the ground is moved by its first slides, and every force between two of its links cancels in their sum:
//!
//! ```text
//! ∂V/∂d = −F·d,   F = Σ m g + Σ dead loads,   d ∈ ∩ᵢ span(axes of the first slides of tree i)     (1)
//! P d = 0,   P = Σᵢ (1 − Qᵢ Qᵢᵀ)          Qᵢ: orthonormal basis of the span                       (2)
//! ```
//!
//! `F` does not depend on the position. With a part along such a `d` there is no equilibrium anywhere, and no search is needed
//! to say so. What is not known to leave `d` alone (springs, stops, motors, drives and locks of these slides, loads that follow
//! a link, driven coordinates) counts as joined to the ground: the certificate is sufficient, not necessary.

use crate::force::Act;
use crate::model::Model;
use crate::statics::problem::place::BALANCED;
use nalgebra::{Matrix3, Vector3};

/// An eigenvalue of `P`, eq. (2), below this per tree is zero: what unit axes leave by round-off.
const FEELS_NOTHING: f64 = 16.0 * f64::EPSILON;

/// A component that nothing holds.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::statics) struct Unheld {
    /// The first body of it.
    pub body: String,
    /// The part of its constant force that nothing balances, inertial axes (N).
    pub force: Vector3<f64>,
}

/// Such a component of a model; `None` when there is none.
pub(in crate::statics) fn unheld(model: &Model) -> Option<Unheld> {
    let joined = Joined::of(model);
    let still = still(model);
    joined.components().into_iter().find_map(|trees| {
        let (mut feels, mut force, mut size) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
        for root in &trees {
            feels += across(&axes(model, *root, &still, &joined.attached));
            for link in &model.links[*root..model.links[*root].subtree_end] {
                force += link.mass * model.gravity;
                size += link.mass * model.gravity.norm();
            }
        }
        for load in dead_loads(model).filter(|(link, _)| trees.contains(&joined.tree[*link])) {
            force += load.1;
            size += load.1.norm();
        }
        let free = nothing_feels(&feels, trees.len()) * force;
        let body = model.bodies[model.links[*trees.first()?].body].name.clone();
        (free.norm() > BALANCED * size).then_some(Unheld { body, force: free })
    })
}

/// Which trees on the ground belong together.
struct Joined {
    /// Per link the first link of its tree; 0 for the ground.
    tree: Vec<usize>,
    /// Per link another one of its component; the ground's is 0.
    of: Vec<usize>,
    /// Per link whether a force element or a loop ends there.
    attached: Vec<bool>,
}

impl Joined {
    fn of(model: &Model) -> Self {
        let count = model.links.len();
        let mut tree = vec![0; count];
        for index in 1..count {
            let parent = model.links[index].parent;
            tree[index] = if parent == 0 { index } else { tree[parent] };
        }
        let mut joined = Self { tree, of: (0..count).collect(), attached: vec![false; count] };
        for force in model.forces.iter() {
            let ends = force.law.ends().iter().map(|end| end.link);
            // What pushes on one link alone, and not always the same, counts as joined to the ground.
            let alone = force.law.ends().len() == 1 && force.law.dead().is_none();
            joined.join(ends.chain(alone.then_some(0)));
        }
        for closed in &model.loops {
            joined.join(closed.ends.iter().map(|end| end.link));
        }
        for drive in &model.drives {
            joined.join([drive.coordinate.link, 0].into_iter());
        }
        joined
    }

    fn join(&mut self, links: impl Iterator<Item = usize>) {
        let mut first = None;
        for link in links {
            self.attached[link] = true;
            let other = self.first_of(self.tree[link]);
            let one = *first.get_or_insert(other);
            let (low, high) = (one.min(other), one.max(other));
            self.of[high] = low;
            first = Some(low);
        }
    }

    fn first_of(&self, mut tree: usize) -> usize {
        while self.of[tree] != tree {
            tree = self.of[tree];
        }
        tree
    }

    /// The trees of each component that is not joined to the ground.
    fn components(&self) -> Vec<Vec<usize>> {
        let mut components: Vec<Vec<usize>> = vec![Vec::new(); self.tree.len()];
        let trees = (1..self.tree.len()).filter(|link| self.tree[*link] == *link);
        trees.for_each(|tree| components[self.first_of(tree)].push(tree));
        components.into_iter().skip(1).filter(|trees| !trees.is_empty()).collect()
    }
}

/// Which velocity coordinates something holds or pushes.
fn still(model: &Model) -> Vec<bool> {
    let mut still: Vec<bool> =
        model.coordinates.iter().map(|c| c.lock || c.stiffness != 0.0 || c.force != 0.0).collect();
    let stops = model.stops.iter().map(|stop| stop.velocity);
    let drives = model.drives.iter().map(|drive| drive.coordinate.velocity);
    let gears = model.gears.iter().flat_map(|gear| gear.coordinates.map(|coordinate| coordinate.velocity));
    let pushed = model.pushed().map(|coordinate| coordinate.velocity);
    stops.chain(drives).chain(gears).chain(pushed).for_each(|velocity| still[velocity] = true);
    still
}

/// Axes of the slides that move a tree as a whole and that nothing holds, inertial axes.
fn axes(model: &Model, root: usize, still: &[bool], attached: &[bool]) -> Vec<Vector3<f64>> {
    let (mut axes, mut at, mut turn) = (Vec::new(), root, Matrix3::identity());
    while let Some(link) = model.links.get(at)
        && let Some(axis) = link.joint.slide_axis()
    {
        turn *= link.turn;
        if !still[link.velocity] {
            axes.push(turn * axis);
        }
        let next = at + 1;
        let is_inner = link.is_massless() && !attached[at] && link.subtree_end > next;
        // A second child would stay behind when the first one slides.
        if !is_inner || model.links[next].subtree_end != link.subtree_end {
            break;
        }
        at = next;
    }
    axes
}

/// `1 − Q Qᵀ` of the span of some axes.
fn across(axes: &[Vector3<f64>]) -> Matrix3<f64> {
    let mut basis: Vec<Vector3<f64>> = Vec::with_capacity(3);
    for axis in axes {
        let rest = basis.iter().fold(*axis, |rest, one| rest - one * one.dot(&rest));
        // Two axes that are nearly parallel span what the first one does.
        basis.extend(rest.try_normalize(1e-6));
    }
    basis.iter().fold(Matrix3::identity(), |across, one| across - one * one.transpose())
}

/// The projection onto the null space of `P`, eq. (2).
fn nothing_feels(feels: &Matrix3<f64>, trees: usize) -> Matrix3<f64> {
    let eigen = feels.symmetric_eigen();
    let least = FEELS_NOTHING * trees as f64;
    let null =
        (0..3).filter(|k| eigen.eigenvalues[*k].abs() < least).map(|k| eigen.eigenvectors.column(k).into_owned());
    null.fold(Matrix3::zeros(), |sum, one| sum + one * one.transpose())
}

/// Forces that keep their direction in space: the link and the force (N).
fn dead_loads(model: &Model) -> impl Iterator<Item = (usize, Vector3<f64>)> {
    model.forces.iter().filter_map(|force| force.law.dead())
}
