//! Stops and dry friction of hinges in a run: what they hold between events is `nonsmooth`, what follows at an instant `instant`, what rests
//! then `holding`, by the problem of rows with bounds in `complementarity`.

pub(super) mod complementarity;
pub(super) mod holding;
pub(super) mod instant;
pub(super) mod nonsmooth;
