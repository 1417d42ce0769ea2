//! Rows with two sides, the cones that they divide motions into, and what is known of the motions on them.

use crate::round_off::EIGENVECTOR;

/// Compliant stops and kinks up to which all cones are looked at; of more those in which all are on one side, or one alone is not.
const MOST_SWITCHES: usize = 8;

/// What happens on the positive side of a row.
#[derive(Debug, Clone, Copy)]
pub(in crate::statics) enum Beyond {
    /// No motion leads there: a rigid stop.
    Nothing,
    /// The stiffness is another one by these numbers on the negative and the positive side (N/m, N m/rad).
    Stiffness([f64; 2]),
}

/// A row with two sides.
#[derive(Debug, Clone)]
pub(in crate::statics) struct Sided {
    /// Its entries by their velocity coordinates.
    pub row: Vec<(usize, f64)>,
    pub beyond: Beyond,
    /// Whether it is a kink of a force, not a stop.
    pub is_kink: bool,
    /// Whose it is.
    pub name: String,
}

/// A motion that leaves the balance.
#[derive(Debug, Clone)]
pub(in crate::statics) struct Leaving {
    /// Whether it runs away; else nothing brings it back.
    pub falls: bool,
    /// The stops that it leaves and the kinks that it crosses.
    pub names: Vec<String>,
    /// Whether it leaves no stop.
    pub kinks_alone: bool,
    /// The velocity coordinates of those.
    pub coordinates: Vec<usize>,
    /// Over all velocity coordinates.
    pub direction: Vec<f64>,
}

/// What is known of the motions on all sides.
#[derive(Debug, Clone)]
pub(in crate::statics) enum Sides {
    /// All come back.
    Hold,
    Leave(Leaving),
    /// Nothing leaves for ever, but something swings and grows off stops that it strikes.
    Swing,
    /// There is too much of it to be looked at.
    Unknown,
}

/// On which side of each row a cone is: `true` on the positive one.
pub(super) fn cones(sided: &[Sided]) -> Vec<Vec<bool>> {
    let switches: Vec<usize> = (0..sided.len()).filter(|k| matches!(sided[*k].beyond, Beyond::Stiffness(_))).collect();
    let with = |on: &dyn Fn(usize) -> bool| {
        let mut sides = vec![false; sided.len()];
        switches.iter().enumerate().for_each(|(bit, k)| sides[*k] = on(bit));
        sides
    };
    if switches.len() <= MOST_SWITCHES {
        return (0..1_usize << switches.len()).map(|set| with(&|bit| set >> bit & 1 == 1)).collect();
    }
    let ends = [false, true];
    let alone = (0..switches.len()).flat_map(|one| ends.map(|side| with(&|bit| (bit == one) == side)));
    ends.into_iter().map(|side| with(&|_| side)).chain(alone).collect()
}

impl Leaving {
    /// Along a motion that changes the rows by `along`.
    pub(super) fn new(sided: &[Sided], along: &[f64], direction: Vec<f64>, falls: bool) -> Self {
        let most = along.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let moved = |k: &usize| along[*k].abs() > EIGENVECTOR.of(most);
        let mut names: Vec<String> = (0..sided.len()).filter(moved).map(|k| sided[k].name.clone()).collect();
        names.dedup();
        let kinks_alone = (0..sided.len()).filter(moved).all(|k| sided[k].is_kink);
        let of = |k: usize| sided[k].row.iter().map(|(i, _)| *i);
        let coordinates = (0..sided.len()).filter(moved).flat_map(of).collect();
        Self { falls, names, kinks_alone, coordinates, direction }
    }
}
