//! All integration tests in one binary: one link, many modules.

mod accelerations;
mod architecture;
mod building;
mod cli;
mod closed_forms;
mod common;
mod derivatives;
mod diagnostics;
mod faults;
mod identities;
mod integrators;
mod loops;
mod no_allocation;
mod oracle;
mod precision;
mod record;
mod reference;
mod rest;
mod scenario;
mod scenarios;
mod statics;
mod statics_cascade;
mod statics_inverse;
mod statics_methods;
mod statics_path;
mod statics_start;
