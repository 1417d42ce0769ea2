//! All integration tests in one binary: one link, many modules.

// Outside of functions that are marked as tests, too.
#![allow(clippy::print_stderr, clippy::print_stdout, clippy::too_many_lines, clippy::unwrap_used)]

mod accelerations;
mod addresses;
mod architecture;
mod beams;
mod building;
mod cli;
mod closed_forms;
mod common;
mod compliant_contact;
mod contact_beside_stops;
mod contact_in_motion;
mod contact_reference;
mod control;
mod creep;
mod cylinders;
mod derivatives;
mod diagnostics;
mod documents;
mod ensembles;
mod events;
mod examples;
mod faults;
mod firing;
mod fits;
mod fmu;
mod formulas;
mod friction;
mod guides;
mod halves;
mod hinges;
mod identities;
mod import;
mod instructions;
mod integrators;
mod ledger;
mod light;
mod linear;
mod lint;
mod loops;
mod measures;
mod mesh_contact;
mod mjcf;
mod modal;
mod named;
mod nets;
mod no_allocation;
mod oracle;
mod outputs;
mod plain;
mod precision;
mod quantities;
mod record;
mod reference;
mod rest;
#[cfg(feature = "friction")]
mod resting;
mod resume;
mod robust;
mod ropes;
mod round_bodies;
mod scenario;
mod scenarios;
mod screws;
mod sensitivity;
mod settle;
mod stages;
mod statics;
#[cfg(feature = "friction")]
mod support;
mod touch;
mod undetermined;
mod units;
mod verify;
