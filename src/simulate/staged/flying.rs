//! What flies after a stage: bodies whose hinges have opened and that nothing but their weight and loads reaches.
//!
//! Nothing holds them, so that the scene has no equilibrium with them in it; they touch nothing either, so that the rest of it has its own
//! without them.

use crate::force::Act;
use crate::model::Model;
use crate::model::structure::Structure;
use std::collections::BTreeSet;

/// Bodies whose hinges have opened, of trees that neither forces, loops, gears nor contacts join to one that hangs on the ground. None
/// without gravity: what nothing pulls is at rest wherever it is.
pub(super) fn bodies(model: &Model, structure: &Structure) -> Vec<usize> {
    if model.gravity.norm() == 0.0 {
        return Vec::new();
    }
    let freed: Vec<(usize, usize)> =
        structure.freed.keys().map(|body| (*body, root(model, model.bodies[*body].link))).collect();
    let flies = |tree: usize| freed.iter().any(|(_, freed)| *freed == tree);
    let trees = (1..model.links.len()).filter(|link| model.links[*link].parent == 0);
    let mut joined: BTreeSet<usize> = trees.filter(|tree| !flies(*tree)).chain([0]).collect();
    let groups = groups(model);
    loop {
        let reached = groups.iter().filter(|group| group.iter().any(|tree| joined.contains(tree)));
        let more: Vec<usize> = reached.flatten().filter(|tree| !joined.contains(tree)).copied().collect();
        if more.is_empty() {
            break;
        }
        joined.extend(more);
    }
    freed.into_iter().filter(|(_, tree)| !joined.contains(tree)).map(|(body, _)| body).collect()
}

/// The link on the ground that a link hangs on, or the ground.
fn root(model: &Model, link: usize) -> usize {
    let mut at = link;
    while at != 0 && model.links[at].parent != 0 {
        at = model.links[at].parent;
    }
    at
}

/// Trees that act on each other, by their roots.
fn groups(model: &Model) -> Vec<Vec<usize>> {
    let forces = model.forces.iter().map(|force| force.law.ends());
    let loops = model.loops.iter().map(|closed| &closed.ends[..]);
    let ends = forces.chain(loops).map(|ends| ends.iter().map(|end| end.link).collect::<Vec<_>>());
    let gears = model.gears.iter().map(|gear| gear.coordinates.iter().map(|scalar| scalar.link).collect());
    let link_of = |body: &usize| model.bodies[*body].link;
    let contacts = model.contacts.iter().map(|rule| rule.bodies.iter().flatten().map(link_of).collect());
    let all = ends.chain(gears).chain(contacts);
    all.map(|links: Vec<usize>| links.into_iter().map(|link| root(model, link)).collect()).collect()
}
