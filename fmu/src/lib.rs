//! The C functions of FMI 3.0 for co-simulation, over [`stillpoint::fmu::Instance`]: the library within every FMU that
//! `stillpoint fmu` writes.
//!
//! What an importer holds of an instance, or of a state of one, is a number and no address: it is looked up, never followed. A call
//! with one that is not there, with null pointers, out of order or while another call of the instance runs is an error, and no
//! panic leaves a function. Every refusal has its reason in the log of the importer.
//!
//! Unsafe code reads and writes the arrays and texts of the importer (`arrays`), and calls its log (`instances`).
#![allow(non_snake_case, reason = "the functions are called as the standard calls them")]

mod arrays;
mod cosimulation;
mod derivatives;
mod instances;
mod life;
mod states;
mod unsupported;
mod values;

use std::ffi::{c_char, c_int, c_void};

/// What an importer holds of an instance; null for none.
type Handle = *mut c_void;

/// `bool` of C, of which an importer may pass any value.
type Boolean = u8;

/// How a call ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
enum Status {
    /// Done.
    Ok = 0,
    /// Refused, or failed: nothing has changed.
    Error = 3,
    /// The instance can only be freed.
    Fatal = 4,
}

/// `fmi3Status`.
type Code = c_int;

/// `fmi3LogMessageCallback`: environment, status, category, message.
type LogMessage = unsafe extern "C" fn(*mut c_void, Code, *const c_char, *const c_char);

/// For the program to know the library by.
#[used]
static MARK: &str = stillpoint::fmu::MARK;

/// The version of the interface.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}
