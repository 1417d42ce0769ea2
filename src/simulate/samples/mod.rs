//! What is told of a run, sample after sample: when and what in `sampler`, energies in `ledger` (how far drives turn meanwhile in `driven`), pushes
//! in `couplings`, outputs in `outputs`, and once what does not change in `scene`, curves and racks of it in `guides`.

pub(super) mod couplings;
mod driven;
mod guides;
pub(super) mod ledger;
pub mod outputs;
pub(super) mod sampler;
pub(super) mod scene;
