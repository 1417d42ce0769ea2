//! All integration tests in one binary: one link, many modules.

mod common;
mod derivatives;
mod diagnostics;
mod integrators;
mod record;
mod reference;
mod scenario;
