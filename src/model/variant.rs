//! Models that differ from another one in what a question holds or adds. None is changed once it is made; each costs a copy of the
//! lists of the model, no compilation.

use super::{Force, Model};
use std::sync::Arc;

impl Model {
    /// The model that starts at `position`.
    pub(crate) fn starting_at(self: Arc<Self>, position: &[f64]) -> Arc<Self> {
        if self.start_position == position {
            return self;
        }
        let mut model = Arc::unwrap_or_clone(self);
        model.start_position.copy_from_slice(position);
        Arc::new(model)
    }

    /// The model in which statics holds these velocity coordinates, too.
    pub(crate) fn locking(self: Arc<Self>, velocities: impl IntoIterator<Item = usize>) -> Arc<Self> {
        let mut model = Arc::unwrap_or_clone(self);
        velocities.into_iter().for_each(|velocity| model.coordinates[velocity].lock = true);
        Arc::new(model)
    }

    /// The model with these force elements instead of its own.
    pub(crate) fn with_forces(&self, forces: Vec<Force>) -> Arc<Self> {
        Arc::new(Self { forces: forces.into(), ..self.clone() })
    }

    /// The model whose locked coordinates have more armature, by one number per velocity coordinate (kg, kg m²).
    pub(crate) fn with_heavier_locks(&self, armatures: &[f64]) -> Arc<Self> {
        let mut model = self.clone();
        for (coordinate, armature) in model.coordinates.iter_mut().zip(armatures).filter(|(at, _)| at.lock) {
            coordinate.armature += armature;
        }
        Arc::new(model)
    }
}
