//! Arrays and texts of the importer.

use std::ffi::{CStr, c_char};
use stillpoint::fmu::FmuError;

fn null(what: &str) -> FmuError {
    FmuError::Argument(format!("`{what}` is a null pointer"))
}

/// An array to be read; a null pointer is one without elements.
///
/// # Safety
/// Unless it is null, `first` points to `count` elements that nobody changes while the slice lives.
pub(crate) unsafe fn read<'a, T>(what: &str, first: *const T, count: usize) -> Result<&'a [T], FmuError> {
    match (first.is_null(), count) {
        (_, 0) => Ok(&[]),
        (true, _) => Err(null(what)),
        // SAFETY: as the caller promises; `count` elements are there.
        (false, _) => Ok(unsafe { std::slice::from_raw_parts(first, count) }),
    }
}

/// Writes numbers into an array that has room for `count`.
///
/// # Safety
/// Unless it is null, `first` points to room for `count` elements.
pub(crate) unsafe fn write<T: Copy>(what: &str, first: *mut T, count: usize, all: &[T]) -> Result<(), FmuError> {
    if count != all.len() {
        return Err(FmuError::Count { given: count, wanted: all.len() });
    }
    if all.is_empty() {
        return Ok(());
    }
    if first.is_null() {
        return Err(null(what));
    }
    // SAFETY: there is room for as many as there are, and what is the importer's own does not overlap with ours.
    unsafe { std::ptr::copy_nonoverlapping(all.as_ptr(), first, count) };
    Ok(())
}

/// Writes one value if anybody wants it.
///
/// # Safety
/// Unless it is null, `place` points to room for a value.
pub(crate) unsafe fn put<T>(place: *mut T, value: T) {
    if !place.is_null() {
        // SAFETY: as the caller promises.
        unsafe { place.write(value) };
    }
}

/// A text.
///
/// # Safety
/// Unless it is null, `text` ends with a zero, and nobody changes it meanwhile.
pub(crate) unsafe fn text(what: &str, text: *const c_char) -> Result<String, FmuError> {
    if text.is_null() {
        return Err(null(what));
    }
    // SAFETY: as the caller promises.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map(str::to_owned).map_err(|_| FmuError::Argument(format!("`{what}` is no UTF-8")))
}
