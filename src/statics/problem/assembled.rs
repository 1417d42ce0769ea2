//! Loops of one scene with other numbers: what its assembly has decided stays, whatever moves.

use crate::constraint::{Closer, assemble};
use crate::model::Model;
use nalgebra::Matrix3;
use std::sync::Arc;

/// What assembly has decided: frames of loops and offsets of gears that follow from the given positions, and which rows
/// are independent.
#[derive(Debug, Clone)]
pub(in crate::statics) struct Assembled {
    frames: Vec<Option<Matrix3<f64>>>,
    offsets: Vec<f64>,
    independent: Option<Vec<bool>>,
}

impl Assembled {
    /// Assembles a model, and keeps what that decides.
    ///
    /// # Errors
    /// What cannot be assembled.
    pub(in crate::statics) fn of(model: Arc<Model>) -> Result<(Arc<Model>, Self), String> {
        let (model, _) = assemble(model).map_err(|problems| {
            problems.first().map_or_else(|| "the loops cannot be closed".to_owned(), |problem| problem.message.clone())
        })?;
        let assembled = Self {
            frames: model.loops.iter().map(|one| one.second_frame).collect(),
            offsets: model.gears.iter().map(|gear| gear.offset).collect(),
            independent: model.independent_rows.clone(),
        };
        Ok((model, assembled))
    }

    /// Another model of the scene with these decisions; `q` is brought onto its loops, locks and drives where they are,
    /// and is where it starts.
    ///
    /// # Errors
    /// If the loops cannot be closed there.
    pub(in crate::statics) fn apply(&self, model: Arc<Model>, q: &mut [f64]) -> Result<Arc<Model>, String> {
        if !model.is_constrained() {
            return Ok(model);
        }
        let mut model = Arc::unwrap_or_clone(model);
        for (one, frame) in model.loops.iter_mut().zip(&self.frames) {
            one.second_frame = *frame;
        }
        for (gear, offset) in model.gears.iter_mut().zip(&self.offsets) {
            gear.offset = *offset;
        }
        model.independent_rows.clone_from(&self.independent);
        if !Closer::new(&model).close(&model, q) {
            return Err("the loops cannot be closed there".to_owned());
        }
        model.start_position.copy_from_slice(q);
        Ok(Arc::new(model))
    }
}
