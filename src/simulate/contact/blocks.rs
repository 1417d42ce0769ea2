//! `J M⁻¹ Jᵀ` of many contacts: `M⁻¹` is made of the blocks of the trees on the ground, all of them in as many solutions as the
//! largest has coordinates.

use super::Contacts;
use crate::contact::frame::{self, Column};
use crate::contact::hinges::Support;
use crate::dynamics::Factorized;
use nalgebra::{DMatrix, Matrix3, Vector3};

/// Trees with more coordinates than this are answered row by row.
const LARGE: usize = 30;

/// The part of `J` and of `M⁻¹ Jᵀ` of a contact in one tree.
struct Part {
    tree: usize,
    rows: DMatrix<f64>,
    answers: DMatrix<f64>,
}

/// `J` and `M⁻¹ Jᵀ`, by contacts and trees.
pub(super) struct Blocks {
    /// Velocity coordinates of every tree.
    trees: Vec<Vec<usize>>,
    parts: Vec<Vec<Part>>,
    /// Contacts of every tree.
    contacts: Vec<Vec<usize>>,
}

impl Blocks {
    pub(super) fn new(contacts: &Contacts, mass: &mut Factorized<'_>, supports: &[Support]) -> Self {
        let trees = &contacts.trees;
        let mut parts: Vec<Vec<Part>> = supports.iter().map(|support| split(&support.columns, trees)).collect();
        if trees.largest <= LARGE {
            let inverse = Inverses::new(mass, trees);
            for part in parts.iter_mut().flatten() {
                part.answers = &inverse.of[part.tree] * part.rows.transpose();
            }
        } else {
            let full = frame::responses_to(mass, supports.iter().map(|support| &support.columns));
            for (parts, full) in parts.iter_mut().zip(&full) {
                for part in parts {
                    let own = &trees.all[part.tree];
                    part.answers = DMatrix::from_fn(own.len(), 3, |i, j| full[j][own[i]]);
                }
            }
        }
        let mut touching = vec![Vec::new(); trees.all.len()];
        parts.iter().enumerate().for_each(|(i, own)| own.iter().for_each(|part| touching[part.tree].push(i)));
        Self { trees: trees.all.clone(), parts, contacts: touching }
    }

    pub(super) fn matrix(&self) -> Vec<Vec<(usize, Matrix3<f64>)>> {
        let mut all: Vec<Vec<(usize, Matrix3<f64>)>> = vec![Vec::new(); self.parts.len()];
        for (i, parts) in self.parts.iter().enumerate() {
            for part in parts {
                for j in &self.contacts[part.tree] {
                    let Some(other) = self.parts[*j].iter().find(|other| other.tree == part.tree) else { continue };
                    let block = part.rows.fixed_rows::<3>(0) * other.answers.fixed_columns::<3>(0);
                    match all[i].iter_mut().find(|(k, _)| k == j) {
                        Some((_, sum)) => *sum += block,
                        None => all[i].push((*j, block)),
                    }
                }
            }
        }
        all
    }

    /// Adds `M⁻¹ Jᵀ λ`.
    pub(super) fn push(&self, forces: &[Vector3<f64>], v: &mut [f64]) {
        for (parts, force) in self.parts.iter().zip(forces) {
            for part in parts {
                for (k, i) in self.trees[part.tree].iter().enumerate() {
                    v[*i] += (0..3).map(|j| part.answers[(k, j)] * force[j]).sum::<f64>();
                }
            }
        }
    }
}

fn split(columns: &[Column; 3], trees: &Trees) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    for (row, column) in columns.iter().enumerate() {
        for (i, value) in column {
            let (tree, k) = trees.of[*i];
            let at = parts.iter().position(|part| part.tree == tree).unwrap_or_else(|| {
                let rows = DMatrix::zeros(3, trees.all[tree].len());
                parts.push(Part { tree, rows, answers: DMatrix::zeros(0, 0) });
                parts.len() - 1
            });
            parts[at].rows[(row, k)] = *value;
        }
    }
    parts
}

/// `M⁻¹` of every tree.
pub(super) struct Inverses<'a> {
    trees: &'a Trees,
    of: Vec<DMatrix<f64>>,
}

impl<'a> Inverses<'a> {
    /// From unit forces on one coordinate of all trees at once.
    pub(super) fn new(mass: &mut Factorized<'_>, trees: &'a Trees) -> Self {
        let mut of: Vec<DMatrix<f64>> = trees.all.iter().map(|own| DMatrix::zeros(own.len(), own.len())).collect();
        let n = mass.system().model().velocity_count();
        let (mut impulse, mut change) = (vec![0.0; n], vec![0.0; n]);
        for k in 0..trees.largest {
            impulse.fill(0.0);
            trees.all.iter().filter_map(|own| own.get(k)).for_each(|i| impulse[*i] = 1.0);
            mass.answer_impulse(&impulse, &mut change);
            for (own, inverse) in trees.all.iter().zip(&mut of).filter(|(own, _)| own.len() > k) {
                own.iter().enumerate().for_each(|(row, i)| inverse[(row, k)] = change[*i]);
            }
        }
        Self { trees, of }
    }

    /// `M⁻¹ x`, x being zero but in the trees of these coordinates.
    pub(super) fn times(&self, x: &[f64], coordinates: impl Iterator<Item = usize>) -> Vec<f64> {
        let mut product = vec![0.0; x.len()];
        // Two bodies are in two trees at most.
        let mut done = [usize::MAX; 2];
        for i in coordinates {
            let (tree, _) = self.trees.of[i];
            if done.contains(&tree) {
                continue;
            }
            done = [done[1], tree];
            let own = &self.trees.all[tree];
            for (column, from) in own.iter().enumerate().filter(|(_, from)| x[**from] != 0.0) {
                own.iter().enumerate().for_each(|(row, to)| product[*to] += self.of[tree][(row, column)] * x[*from]);
            }
        }
        product
    }
}

/// Velocity coordinates of the trees that stand on the ground; all in one if loops, drives or gears tie them.
#[derive(Debug)]
pub(super) struct Trees {
    pub(super) all: Vec<Vec<usize>>,
    /// Of each velocity coordinate its tree and its place there.
    of: Vec<(usize, usize)>,
    /// Coordinates of the largest.
    pub(super) largest: usize,
}

impl Trees {
    pub(super) fn new(model: &crate::model::Model) -> Self {
        let all = trees(model);
        let mut of = vec![(0, 0); model.velocity_count()];
        all.iter().enumerate().for_each(|(tree, own)| own.iter().enumerate().for_each(|(k, i)| of[*i] = (tree, k)));
        let largest = all.iter().map(Vec::len).max().unwrap_or(0);
        Self { all, of, largest }
    }

    /// The trees that columns are of.
    pub(super) fn beside(&self, columns: &[Column; 3]) -> Vec<usize> {
        let mut found: Vec<usize> = columns.iter().flatten().map(|(i, _)| self.of[*i].0).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Whether two velocity coordinates are of one tree.
    pub(super) fn hang_together(&self, one: usize, other: usize) -> bool {
        self.of[one].0 == self.of[other].0
    }
}

fn trees(model: &crate::model::Model) -> Vec<Vec<usize>> {
    let mut of = vec![0; model.links.len()];
    let mut trees: Vec<Vec<usize>> = Vec::new();
    for (index, link) in model.links.iter().enumerate().skip(1) {
        let begins = link.parent == 0 && (trees.is_empty() || !model.is_constrained());
        if begins {
            trees.push(Vec::new());
        }
        of[index] = if begins || link.parent == 0 { trees.len() - 1 } else { of[link.parent] };
        let tree = of[index];
        trees[tree].extend(link.velocity..link.velocity + link.joint.counts().1);
    }
    trees
}
