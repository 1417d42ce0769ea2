//! Loops of one scene with other numbers: what its assembly has decided stays, whatever moves.

use crate::constraint::{Closer, assemble};
use crate::model::Model;
use nalgebra::Matrix3;

/// What assembly has decided: frames of loops and offsets of gears that follow from the given positions, and which rows
/// are independent.
#[derive(Debug, Clone)]
pub(super) struct Assembled {
    frames: Vec<Option<Matrix3<f64>>>,
    offsets: Vec<f64>,
    independent: Option<Vec<bool>>,
}

impl Assembled {
    /// Assembles a model, and keeps what that decides.
    ///
    /// # Errors
    /// What cannot be assembled.
    pub(super) fn of(model: &mut Model) -> Result<Self, String> {
        assemble(model).map_err(|problems| {
            problems.first().map_or_else(|| "the loops cannot be closed".to_owned(), |problem| problem.message.clone())
        })?;
        Ok(Self {
            frames: model.loops.iter().map(|one| one.second_frame).collect(),
            offsets: model.gears.iter().map(|gear| gear.offset).collect(),
            independent: model.independent_rows.clone(),
        })
    }

    /// Gives it to another model of the scene, and brings `q` onto the loops of that: locks and drives where they are.
    ///
    /// # Errors
    /// Where that is not possible.
    pub(super) fn give(&self, model: &mut Model, q: &mut [f64]) -> Result<(), String> {
        if !model.is_constrained() {
            return Ok(());
        }
        for (one, frame) in model.loops.iter_mut().zip(&self.frames) {
            one.second_frame = *frame;
        }
        for (gear, offset) in model.gears.iter_mut().zip(&self.offsets) {
            gear.offset = *offset;
        }
        model.independent_rows.clone_from(&self.independent);
        if !Closer::new(model).close(q) {
            return Err("the loops cannot be closed there".to_owned());
        }
        model.start_position.copy_from_slice(q);
        Ok(())
    }
}
