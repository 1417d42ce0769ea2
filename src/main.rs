//! The program.

use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};
use std::alloc::System;
use std::io::Write;
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
    if !is_able() {
        // Bytes to a function that was compiled with the standard library: whatever is compiled here, formatting
        // or so much as moving a text, may use what is missing. A failure to write changes nothing.
        drop(std::io::stderr().write_all(UNABLE));
        std::process::exit(2);
    }
    stillpoint::cli::main(memory)
}

const UNABLE: &[u8] =
    b"error: this program was built for processors with AVX2, FMA and BMI2, and this one lacks one of them
  help: build it here with RUSTFLAGS=\"-C target-cpu=x86-64\" cargo build --release
";

/// Whether this processor has what the program was built for: asked of the processor itself, for the standard library
/// takes for granted what the compiler was told.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
fn is_able() -> bool {
    use std::arch::x86_64::{__cpuid, __cpuid_count};
    const AVX2: u32 = 1 << 5;
    const BMI2: u32 = 1 << 8;
    const FMA: u32 = 1 << 12;
    let extended = if __cpuid(0).eax >= 7 { __cpuid_count(7, 0).ebx } else { 0 };
    extended & AVX2 != 0 && extended & BMI2 != 0 && __cpuid(1).ecx & FMA != 0
}

#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma")))]
fn is_able() -> bool {
    true
}
