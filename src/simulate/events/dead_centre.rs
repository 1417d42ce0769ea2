//! Dead centres of drives: positions in which the loops leave a driven hinge no way on, however hard it is pushed.
//!
//! There the rows are linearly dependent, and without the drive they are not. A run that fails next to one says which drive it
//! is: steps that shrink, or loops that cannot be closed, only tell what follows from it.

use crate::dynamics::{RowSelection, System};
use crate::model::Model;
use crate::simulate::RunError;
use crate::simulate::state::State;
use std::sync::Arc;

/// A drive next to a dead centre leaves this part of the clearance that the rows have without it.
const NEXT_TO: f64 = 0.1;

/// The error of a step from `time`, or of steps that creep, with the drives that are next to a dead centre there.
pub(in crate::simulate) fn beside(error: RunError, model: &Arc<Model>, time: f64, state: &State) -> RunError {
    if !matches!(error, RunError::Step(_) | RunError::Creep { .. }) {
        return error;
    }
    let found: Vec<String> = (0..model.drives.len())
        .filter(|index| is_held_up(model, *index, time, state))
        .map(|index| {
            let drive = &model.drives[index];
            let hinge = model.label(drive.coordinate.velocity);
            format!("; drive `{}` stands next to a dead centre: the loops let {hinge} move no further", drive.name)
        })
        .collect();
    if found.is_empty() { error } else { RunError::Step(error.to_string() + &found.concat()) }
}

fn is_held_up(model: &Arc<Model>, drive: usize, time: f64, state: &State) -> bool {
    let without = System::with_rows(model, &RowSelection::without_drive(drive), time, &state.position);
    clearance(System::new(model), time, state) < NEXT_TO * clearance(without, time, state)
}

/// The clearance of the rows next to a state; 0 where it cannot be settled.
fn clearance(mut system: System, time: f64, state: &State) -> f64 {
    let (mut q, mut v) = (state.position.clone(), state.velocity.clone());
    system.settle(time, &mut q, &mut v).map_or(0.0, |settled| settled.clearance)
}
