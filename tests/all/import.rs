//! Models of other programs: what becomes of them, and that they move as they do elsewhere.

mod fixture;
mod massless;
mod mended;
mod meshes;
mod mutations;
mod pinocchio;
mod refused;
mod scenes;
mod urdf;
