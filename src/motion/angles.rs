//! Sines and cosines of all angles of turns, four at a time.

use crate::model::{Joint, Model};
use wide::f64x4;

/// Angles beyond this are left to the standard library: the reduction to a quarter turn below is in three parts of π/2,
/// and keeps all digits as long as the number of quarter turns has fewer than 27 bits.
const FAR: f64 = 1e8;

/// Where the angles are, and their sines and cosines.
#[derive(Debug, Clone)]
pub(super) struct Angles {
    /// Position coordinates that are angles of turns, in the order of the links; filled up to fours.
    at: Vec<[u32; 4]>,
    /// Sine and cosine of each.
    of: Vec<[f64; 2]>,
    next: usize,
}

impl Angles {
    pub(super) fn new(model: &Model) -> Self {
        let turns = model.links.iter().filter(|link| matches!(link.joint, Joint::Turn));
        let at: Vec<u32> = turns.map(|link| link.position as u32).collect();
        let four = |some: &[u32]| std::array::from_fn(|i| some[i.min(some.len() - 1)]);
        let at: Vec<[u32; 4]> = at.chunks(4).map(four).collect();
        let of = vec![[0.0, 1.0]; 4 * at.len()];
        Self { at, of, next: 0 }
    }

    /// All of them anew; [`Angles::next`] starts at the first.
    #[inline(always)]
    pub(super) fn update(&mut self, q: &[f64]) {
        self.next = 0;
        for (at, of) in self.at.iter().zip(self.of.chunks_exact_mut(4)) {
            let angles = at.map(|at| q[at as usize]);
            if angles.iter().all(|angle| angle.abs() < FAR) {
                let (sines, cosines) = f64x4::new(angles).sin_cos();
                let (sines, cosines) = (sines.to_array(), cosines.to_array());
                for i in 0..4 {
                    of[i] = [sines[i], cosines[i]];
                }
            } else {
                for i in 0..4 {
                    of[i] = angles[i].sin_cos().into();
                }
            }
        }
    }

    /// Sine and cosine of the next turn.
    #[inline(always)]
    pub(super) fn next(&mut self) -> [f64; 2] {
        let found = self.of[self.next];
        self.next += 1;
        found
    }
}
