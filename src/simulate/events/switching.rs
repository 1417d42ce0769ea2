//! Laws that are smooth in parts: which part holds is, like what stops do, a matter of the run and changes at events alone.
//!
//! Within a step every law is kept on its side of its boundaries (`dynamics::Boundary`), and is smooth beyond them, too. The
//! search for events finds where one is crossed; the step ends there. An impact changes speeds, and so may put a state on the
//! other side of a boundary at once.

use super::{Kind, Occurrence};
use crate::dynamics::Boundary;
use crate::force::{Act, Switch};
use crate::simulate::problem::Equations;
use crate::simulate::state::State;

impl Equations {
    /// Where a law stands with respect to one of its boundaries.
    pub(in crate::simulate) fn switch(&mut self, time: f64, boundary: Boundary, state: &State) -> Switch {
        self.at(time, &state.position, &state.velocity).switch(boundary)
    }

    /// A state on the other side of a boundary by less than this is on it: a position or speed is known to the tolerance.
    pub(in crate::simulate) fn level(&mut self, boundary: Boundary, switch: &Switch, tolerance: f64) -> f64 {
        tolerance * self.system.switch_scale(boundary, switch)
    }

    /// What is told of a boundary that is crossed; `None` if nothing is.
    pub(in crate::simulate) fn occurrence(
        &mut self,
        time: f64,
        boundary: Boundary,
        positive: bool,
        state: &State,
    ) -> Option<Occurrence> {
        let force = self.model().forces.get(boundary.element).filter(|_| boundary.index == 0)?;
        let (kind, name) = (Kind::Force(force.law.switches()?[usize::from(positive)]), force.name.clone());
        let Switch { at, speed, .. } = self.switch(time, boundary, state);
        Some(Occurrence { time, kind, name, value: at, unit: "m".to_owned(), speed, between: None })
    }

    /// Keeps laws where an impact has put the state; what is told of that.
    pub(in crate::simulate) fn switch_laws(&mut self, time: f64, state: &State, tolerance: f64) -> Vec<Occurrence> {
        let mut told = Vec::new();
        while let Some(boundary) = self.passed(time, state, tolerance) {
            let positive = !self.system.side(boundary);
            self.system.cross(boundary);
            told.extend(self.occurrence(time, boundary, positive, state));
        }
        told
    }

    /// A boundary on whose other side a state is. Each is crossed one way only, so that there is an end.
    fn passed(&mut self, time: f64, state: &State, tolerance: f64) -> Option<Boundary> {
        let boundaries: Vec<Boundary> = self.system.boundaries().collect();
        boundaries.into_iter().find(|boundary| {
            let switch = self.switch(time, *boundary, state);
            let beyond = if self.system.side(*boundary) { -switch.value } else { switch.value };
            beyond > self.level(*boundary, &switch, tolerance)
        })
    }
}
