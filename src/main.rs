//! The program.

use std::process::ExitCode;
use stillpoint::cli::Memory;

/// Programs that solve case after case on every core ask for memory often: the system's allocator is slower at that (docs/decisions/build.md).
#[cfg(not(feature = "count-allocations"))]
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// An allocator that counts for each thread what it has asked for: `bench` tells what a scene needs. No thread waits for another.
#[cfg(feature = "count-allocations")]
#[expect(
    unsafe_code,
    reason = "the trait of allocators is unsafe: every call goes on to one that keeps its promises, as it came"
)]
mod counting {
    use super::Memory;
    use mimalloc::MiMalloc;
    use std::alloc::{GlobalAlloc, Layout};
    use std::cell::Cell;

    thread_local! {
        static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
        /// Allocated here less freed here, whoever allocated it: wraps around.
        static BYTES: Cell<usize> = const { Cell::new(0) };
    }

    struct Counting;

    #[global_allocator]
    static ALLOCATOR: Counting = Counting;

    impl Counting {
        fn count(allocations: usize, more: usize, less: usize) {
            ALLOCATIONS.set(ALLOCATIONS.get() + allocations);
            BYTES.set(BYTES.get().wrapping_add(more).wrapping_sub(less));
        }
    }

    // SAFETY: what is promised to or by the allocator is so to or by the one that it hands every call on to; counting allocates nothing.
    unsafe impl GlobalAlloc for Counting {
        unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
            Self::count(1, layout.size(), 0);
            // SAFETY: the caller's.
            unsafe { MiMalloc.alloc(layout) }
        }

        unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
            Self::count(1, layout.size(), 0);
            // SAFETY: the caller's.
            unsafe { MiMalloc.alloc_zeroed(layout) }
        }

        unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
            Self::count(0, 0, layout.size());
            // SAFETY: the caller's.
            unsafe { MiMalloc.dealloc(memory, layout) }
        }

        unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
            Self::count(1, size, layout.size());
            // SAFETY: the caller's.
            unsafe { MiMalloc.realloc(memory, layout, size) }
        }
    }

    /// Of this thread.
    pub(super) fn memory() -> Memory {
        Memory { allocations: ALLOCATIONS.get(), bytes: BYTES.get() }
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
