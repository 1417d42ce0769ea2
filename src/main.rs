//! The program.

use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};
use std::alloc::System;
use std::process::ExitCode;
use stillpoint::cli::Memory;

/// The system's allocator, counting: `bench` tells what a scene needs.
#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

fn memory() -> Memory {
    let stats = ALLOCATOR.stats();
    Memory {
        allocations: stats.allocations + stats.reallocations,
        bytes: stats.bytes_allocated.saturating_sub(stats.bytes_deallocated),
    }
}

fn main() -> ExitCode {
    stillpoint::cli::main(memory)
}
