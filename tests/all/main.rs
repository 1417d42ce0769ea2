//! All integration tests in one binary: one link, many modules.

mod accelerations;
mod building;
mod closed_forms;
mod common;
mod derivatives;
mod diagnostics;
mod faults;
mod identities;
mod integrators;
mod no_allocation;
mod oracle;
mod record;
mod scenario;
