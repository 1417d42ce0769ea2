//! The door to parsers of other people: one that panics is an error of its input, with the parser's name.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};

thread_local! {
    static INSIDE: Cell<bool> = const { Cell::new(false) };
}

/// Runs a foreign parser. What it was given is lost if it panics, so that nothing half-changed is seen.
///
/// ```
/// use stillpoint::foreign::parse;
/// assert_eq!(parse("a parser", || 3), Ok(3));
/// let broken = parse("a parser", || -> u8 { panic!("index out of bounds") });
/// assert_eq!(broken.unwrap_err(), "a parser cannot cope with it (index out of bounds)");
/// ```
///
/// # Errors
/// If it panics: the parser's name and its message. A stack that overflows and memory that ends are not caught; what is
/// parsed has to be bounded before (see [`budget`](crate::budget)).
pub fn parse<T>(parser: &str, work: impl FnOnce() -> T) -> Result<T, String> {
    caught(work).map_err(|message| {
        // What unwrapping says of itself is of no use to a person.
        let said = message.strip_prefix("called `").and_then(|rest| Some(rest.split_once("value: ")?.1));
        format!("{parser} cannot cope with it ({})", said.unwrap_or(&message))
    })
}

/// Runs work of which a panic is one failure among many answers, and not the end of all.
///
/// # Errors
/// The message of the panic.
pub fn caught<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    let outer = INSIDE.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    INSIDE.set(outer);
    result.map_err(|payload| {
        let text = payload.downcast_ref::<&str>().copied();
        let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
        text.unwrap_or("it panicked").to_owned()
    })
}

/// Whether this thread runs such work now: a panic is no news then, and a hook need not print it.
pub fn is_parsing() -> bool {
    INSIDE.get()
}
