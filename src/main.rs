//! The program.

use std::process::ExitCode;
use stillpoint::cli::Memory;

/// The system's allocator, counting: `bench` tells what a scene needs.
#[cfg(feature = "count-allocations")]
mod counting {
    use super::Memory;
    use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};
    use std::alloc::System;

    #[global_allocator]
    static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

    pub(super) fn memory() -> Memory {
        let stats = ALLOCATOR.stats();
        Memory {
            allocations: stats.allocations + stats.reallocations,
            bytes: stats.bytes_allocated.saturating_sub(stats.bytes_deallocated),
        }
    }
}

#[cfg(feature = "count-allocations")]
const MEMORY: Option<fn() -> Memory> = Some(counting::memory);
#[cfg(not(feature = "count-allocations"))]
const MEMORY: Option<fn() -> Memory> = None;

fn main() -> ExitCode {
    if !is_able() {
        std::process::exit(2);
    }
    stillpoint::cli::main(MEMORY)
}

/// Whether this processor has what the program was built for; what it lacks is said. The processor itself is asked, for
/// the standard library takes for granted what the compiler was told.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
fn is_able() -> bool {
    use std::arch::x86_64::{__cpuid, __cpuid_count};
    const AVX2: u32 = 1 << 5;
    const BMI2: u32 = 1 << 8;
    const FMA: u32 = 1 << 12;
    /// The operating system keeps the registers of AVX.
    const OSXSAVE: u32 = 1 << 27;
    let first = __cpuid(1).ecx;
    let extended = if __cpuid(0).eax >= 7 { __cpuid_count(7, 0).ebx } else { 0 };
    let able = has(extended & AVX2, b"AVX2")
        & has(extended & BMI2, b"BMI2")
        & has(first & FMA, b"FMA")
        & has(first & OSXSAVE, b"OSXSAVE (leave of the operating system to use AVX)");
    if !able {
        say(b"  help: build it here with RUSTFLAGS=\"-C target-cpu=x86-64\" cargo build --release\n");
    }
    able
}

#[cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
fn has(bit: u32, name: &'static [u8]) -> bool {
    if bit == 0 {
        say(b"error: this program was built for processors with AVX2, FMA and BMI2; this one lacks ");
        say(name);
        say(b"\n");
    }
    bit != 0
}

/// Bytes to a function that was compiled with the standard library: whatever is compiled here, formatting or so much as
/// moving a text, may use what is missing. A failure to write changes nothing.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]
#[inline(never)]
fn say(bytes: &'static [u8]) {
    use std::io::Write;
    drop(std::io::stderr().write_all(bytes));
}

#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma")))]
fn is_able() -> bool {
    true
}
