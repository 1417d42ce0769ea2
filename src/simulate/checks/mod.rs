//! Whether a run is right, and gets anywhere: held against another run in `verify`, against the equilibrium from which it began in `rest`, all
//! methods against each other in `precision`; numbers that are not finite in `finite`, runs that creep in `pace`.

pub(super) mod finite;
pub(super) mod pace;
pub mod precision;
pub mod rest;
pub mod verify;
