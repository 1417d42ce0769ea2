//! Elements that turn by more than their steps are made for.

use super::Beam;
use crate::model::Model;
use crate::model::problem::rounded;

/// An element that turns by more than this is worth another one (rad): the error of its steps grows with the fifth power.
pub(crate) const MUCH_TURN: f64 = 1.5;

/// So many elements are named; of others it is said how many there are.
const MOST_NAMES: usize = 3;

/// A beam with elements that turn by more than 1.5 rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Wound {
    /// Its name.
    pub beam: String,
    /// Which elements: 1 is the one at the root.
    pub elements: Vec<usize>,
    /// The most that one of them turns by (rad).
    pub turn: f64,
    /// Elements of one length that turn by no more than 1.5 rad each where it is bent most, if its shape stays what it is: at least
    /// so many are needed.
    pub needed: usize,
}

impl Wound {
    /// What is told of it.
    pub fn note(&self) -> String {
        let Self { beam, elements, turn, needed } = self;
        let name = |element: &usize| format!("`{beam}/{element}`");
        let mut names: Vec<String> = elements.iter().take(MOST_NAMES).map(name).collect();
        if let more @ 1.. = elements.len().saturating_sub(MOST_NAMES) {
            names.push(format!("{more} more of `{beam}`"));
        }
        let last = names.pop().unwrap_or_default();
        let names = if names.is_empty() { last } else { format!("{} and {last}", names.join(", ")) };
        let (turns, by) = if elements.len() == 1 { ("turns", "") } else { ("turn", "up to ") };
        format!(
            "{names} {turns} by {by}{} rad: elements are exact enough up to {MUCH_TURN} rad each, at least {needed} elements are needed",
            rounded(*turn)
        )
    }
}

impl Model {
    /// The beams with elements that turn by more than 1.5 rad in a position.
    pub fn wound(&self, q: &[f64]) -> Vec<Wound> {
        self.beams.iter().filter_map(|beam| beam.wound(self, q)).collect()
    }
}

impl Beam {
    /// How far each of its elements turns along itself (rad).
    pub(crate) fn windings<'m>(&'m self, model: &'m Model, q: &'m [f64]) -> impl Iterator<Item = f64> + 'm {
        self.elements.iter().map(|element| {
            let (rod, at) = (&model.rods[element.rod], model.links[element.link].position);
            rod.winding(&q[at..at + rod.count()])
        })
    }

    fn wound(&self, model: &Model, q: &[f64]) -> Option<Wound> {
        let (mut elements, mut turn, mut rate) = (Vec::new(), 0.0_f64, 0.0_f64);
        for (index, winding) in self.windings(model, q).enumerate().filter(|(_, winding)| *winding > MUCH_TURN) {
            elements.push(index + 1);
            turn = turn.max(winding);
            rate = rate.max(winding / model.rods[self.elements[index].rod].length);
        }
        let needed = (rate * self.length / MUCH_TURN).ceil() as usize;
        (!elements.is_empty()).then(|| Wound { beam: self.name.clone(), elements, turn, needed })
    }
}
