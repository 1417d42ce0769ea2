//! All integration tests in one binary: one link, many modules.

mod cli;
mod common;
mod derivatives;
mod diagnostics;
mod integrators;
mod record;
mod rest;
mod scenario;
mod scenarios;
