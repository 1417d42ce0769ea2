//! Directional derivatives.

use crate::arrays::{read, write};
use crate::instances::{call, code};
use crate::{Code, Handle};

/// How outputs answer at once to inputs that move along `seed`.
///
/// # Safety
/// Each array has as many elements as the number beside it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetDirectionalDerivative(
    instance: Handle,
    unknowns: *const u32,
    nUnknowns: usize,
    knowns: *const u32,
    nKnowns: usize,
    seed: *const f64,
    nSeed: usize,
    sensitivity: *mut f64,
    nSensitivity: usize,
) -> Code {
    code(call("fmi3GetDirectionalDerivative", instance, |held, _| {
        // SAFETY: the caller promises that the arrays are as long as it says.
        let (unknowns, knowns, seed) = unsafe {
            (read("unknowns", unknowns, nUnknowns)?, read("knowns", knowns, nKnowns)?, read("seed", seed, nSeed)?)
        };
        let answer = held.instance.directional_derivative(unknowns, knowns, seed)?;
        // SAFETY: the caller promises room for as many as it says.
        unsafe { write("sensitivity", sensitivity, nSensitivity, &answer) }
    }))
}
