//! Stops and dry friction of hinges in a run: what they hold between events is `nonsmooth`, what follows at an instant `instant`, what rests
//! then `holding`, by the problem of rows with bounds in `complementarity`; rebounds that dampers end are in `fading`.

pub(super) mod complementarity;
mod fading;
pub(super) mod holding;
pub(super) mod instant;
pub(super) mod nonsmooth;
