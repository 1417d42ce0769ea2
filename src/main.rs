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
    if let Some(missing) = missing() {
        eprintln!("error: this program was built for processors with AVX2 and FMA, and this one has no {missing}");
        eprintln!("  help: build it here with RUSTFLAGS=\"-C target-cpu=x86-64\" cargo build --release");
        return ExitCode::from(2);
    }
    stillpoint::cli::main(memory)
}

/// What the program was built for and this processor lacks: asked of the processor itself, for the standard library takes
/// for granted what the compiler was told.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
fn missing() -> Option<&'static str> {
    use std::arch::x86_64::{__cpuid, __cpuid_count};
    let has = |register: u32, bit: u32| register >> bit & 1 == 1;
    let most = __cpuid(0).eax;
    let extended = if most >= 7 { __cpuid_count(7, 0).ebx } else { 0 };
    let features = [(has(extended, 5), "AVX2"), (has(__cpuid(1).ecx, 12), "FMA"), (has(extended, 8), "BMI2")];
    features.iter().find(|(there, _)| !there).map(|(_, name)| *name)
}

#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma")))]
fn missing() -> Option<&'static str> {
    None
}
