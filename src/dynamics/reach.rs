//! Which elements reach further than from a link to its parent, and what follows: by which matrices the tangent is solved, and how
//! much memory these take.

use super::Fault;
use super::border::PER_LINK;
use crate::force::Act;
use crate::model::{End, Joint, Model};
use crate::transfer::tangent::{Pair, TangentMatrix};

/// Up to so many coordinates the border or a dense matrix is the simplest.
const SMALL: usize = 64;
/// Operations of a solution of the sweep for each coordinate and right side, of the border's elimination and eigenvalues for
/// the cube of its size, and of writing down an entry of the sparse matrix; its factorization takes about the square of its
/// entries over its size.
const PER_SOLUTION: f64 = 50.0;
const PER_BORDER: f64 = 100.0;
const PER_ENTRY: f64 = 60.0;
/// A gigabyte for pattern and values.
const MOST_ENTRIES: usize = 20_000_000;

/// Bytes of a number; of an entry of a sparse matrix with its places, without its factor; numbers for each entry of the border's
/// small system, twice as large where its eigenvalues are counted.
const NUMBER: usize = 8;
const OF_ENTRY: usize = 60;
const OF_BORDER: usize = 10;

/// The links that an element acts on.
#[derive(Debug, Clone)]
pub(super) struct Reach {
    /// Each once, ascending, without the ground.
    pub(super) links: Vec<usize>,
    /// Of each end its place among them; none for the ground.
    pub(super) places: Vec<Option<usize>>,
    /// Of an element that reaches further than from a link to its parent its index in the border; with a sparse matrix of
    /// every element between links the index of its first pair. Elements that act on the same links share it.
    pub(super) far: Option<usize>,
}

/// Whether a link is the frame or an interface of a modal body.
fn is_of_modal(joint: &Joint) -> bool {
    joint.modal().is_some() || joint.interface().is_some()
}

impl Reach {
    fn of(ends: &[End]) -> Self {
        let mut links = Vec::new();
        for end in ends {
            if end.link != 0 && !links.contains(&end.link) {
                links.push(end.link);
            }
        }
        links.sort_unstable();
        let places = ends.iter().map(|end| links.iter().position(|link| *link == end.link)).collect();
        Self { links, places, far: None }
    }

    /// Whether it acts on the ground, on one link, or on a link and its parent.
    pub(super) fn is_near(&self, model: &Model) -> bool {
        are_near(&self.links, model)
    }

    /// The pairs of its links: of the one that moves first, of the ones that feel it in their order.
    pub(super) fn pairs(&self) -> impl Iterator<Item = Pair> {
        pairs(&self.links)
    }
}

/// Whether links are one, or a link and its parent.
fn are_near(links: &[usize], model: &Model) -> bool {
    let parent = |link: usize| model.links[link].parent;
    match links[..] {
        [] | [_] => true,
        // The tip of an element is coupled to its root through stations.
        [a, b] if [a, b].iter().any(|link| model.links[*link].joint.rod().is_some()) => false,
        // An interface is coupled to the frame through coordinates that other interfaces share.
        [a, b] if [a, b].iter().any(|link| is_of_modal(&model.links[*link].joint)) => false,
        [a, b] => parent(a) == b || parent(b) == a,
        _ => false,
    }
}

fn pairs(links: &[usize]) -> impl Iterator<Item = Pair> {
    let feel = |moves: usize| links.iter().filter(move |feels| **feels != moves).map(move |feels| (*feels, moves));
    links.iter().flat_map(move |moves| feel(*moves)).map(|(feels, moves)| Pair { feels, moves })
}

/// Which matrices a scene takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Matrices {
    /// Matrices of the tangent: none for the sweep alone, a small one for far elements that border it, a sparse one.
    OfTangent,
    /// Dense ones, about so many at once.
    Dense(usize),
}

impl Matrices {
    /// Refuses a scene whose matrices would take more memory than `MATRIX_BYTES`, before any of it
    /// is asked for.
    ///
    /// # Errors
    /// The estimate.
    pub fn check(self, model: &Model) -> Result<(), Fault> {
        let coordinates = model.velocity_count();
        let (bytes, kind) = match self {
            Self::Dense(count) => (coordinates.saturating_mul(coordinates).saturating_mul(count * NUMBER), "dense"),
            Self::OfTangent => memory(model),
        };
        let allowed = crate::budget::MATRIX_BYTES;
        if bytes <= allowed {
            return Ok(());
        }
        let [gigabytes, allowed] = [bytes, allowed].map(|bytes| bytes as f64 / 1e9);
        Err(Fault::Memory { coordinates, kind, gigabytes, allowed })
    }
}

/// Whether the sweep alone covers every force of a model.
pub(super) fn covers(model: &Model) -> bool {
    !model.is_constrained() && covers_forces(model)
}

/// Whether the tangent is a sparse matrix: by the estimated number of operations.
pub(super) fn is_sparse(model: &Model) -> bool {
    !covers_forces(model) && by_matrix(model, &Groups::of(model))
}

/// [`is_sparse`] of a model in which something reaches far.
fn by_matrix(model: &Model, groups: &Groups) -> bool {
    let (n, sides) = (model.velocity_count(), groups.sides(model));
    if n <= SMALL || sides == 0 || !model.rods.is_empty() || !model.modals.is_empty() {
        return false;
    }
    let entries = groups.entries(model);
    let (n, sides, size) = (n as f64, sides as f64, entries as f64);
    let border = PER_SOLUTION * n * sides + PER_BORDER * sides.powi(3);
    let matrix = PER_ENTRY * size + size * size / n;
    entries <= MOST_ENTRIES && matrix < border
}

/// Right sides that elements which reach far take at each factorization.
pub(super) fn further_sides(model: &Model) -> usize {
    if covers_forces(model) {
        return 0;
    }
    let groups = Groups::of(model);
    if by_matrix(model, &groups) { 0 } else { groups.sides(model) }
}

/// Estimated memory of the tangent of a model (bytes), and what takes it: of the sweep alone nothing that counts.
fn memory(model: &Model) -> (usize, &'static str) {
    const BORDER: &str = "what far springs and loops add to the sweep of the tree";
    if covers_forces(model) {
        return (0, BORDER);
    }
    let (n, groups) = (model.velocity_count(), Groups::of(model));
    if by_matrix(model, &groups) {
        // A planar net fills by about the logarithm of its size (George 1973).
        let fill = (n.max(2) as f64).log2().ceil() as usize;
        return (groups.entries(model).saturating_mul(OF_ENTRY + NUMBER * fill), "sparse");
    }
    let sides = groups.sides(model);
    let small = sides.saturating_mul(sides).saturating_mul(OF_BORDER * NUMBER);
    (small.saturating_add(sides.saturating_mul(n).saturating_mul(NUMBER)), BORDER)
}

/// Whether no force and no loop reaches further than from a link to its parent.
fn covers_forces(model: &Model) -> bool {
    reaches(model).all(|element| element.is_near(model))
}

/// The links that elements act on together, each group once: a million springs between two bodies are one.
struct Groups(Vec<Vec<usize>>);

impl Groups {
    fn of(model: &Model) -> Self {
        let mut groups: Vec<Vec<usize>> = reaches(model).map(|element| element.links).collect();
        groups.sort_unstable();
        groups.dedup();
        Self(groups)
    }

    /// Unknowns of a border for the elements that reach far.
    fn sides(&self, model: &Model) -> usize {
        PER_LINK * self.0.iter().filter(|links| !are_near(links, model)).map(Vec::len).sum::<usize>()
    }

    /// Entries of a sparse matrix, at most.
    fn entries(&self, model: &Model) -> usize {
        let pairs: Vec<Pair> = self.0.iter().flat_map(|links| pairs(links)).collect();
        TangentMatrix::most_entries(model, &pairs)
    }
}

/// What every element that pushes on links acts on: forces, then loops.
pub(super) fn reaches(model: &Model) -> impl Iterator<Item = Reach> {
    let forces = model.forces.iter().map(|force| force.law.ends());
    forces.chain(model.loops.iter().map(|closed| &closed.ends[..])).map(Reach::of)
}
