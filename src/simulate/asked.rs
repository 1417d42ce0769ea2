//! What a run is asked for.

use crate::record::Recorder;
use crate::simulate::control::Function;
use crate::simulate::events::search::Search;
use crate::simulate::settings::Settings;
use crate::simulate::state::State;

/// What a run is asked for, beside its model and the state that it starts from.
pub(super) struct Asked<'a, 'f> {
    /// How, and for how long.
    pub(super) settings: &'a Settings,
    /// Samples per second.
    pub(super) rate: f64,
    /// What takes the samples.
    pub(super) recorder: &'a mut dyn Recorder,
    /// Whether to go on from a time (s) and a state: asked after every step and now and then between samples.
    pub(super) go_on: &'a mut dyn FnMut(f64, &State) -> bool,
    /// How events are looked for.
    pub(super) search: Search,
    /// Sets the inputs at instants of its own.
    pub(super) function: Option<Function<'f>>,
}
