//! Two halves of a tree, each on a thread of its own where there are two.

/// Both, at once where there is a second thread. What they give does not depend on that.
#[inline]
pub(crate) fn at_once<A: Send, B: Send>(one: impl FnOnce() -> A + Send, other: impl FnOnce() -> B + Send) -> (A, B) {
    match rayon::current_num_threads() {
        1 => (one(), other()),
        _ => rayon::join(one, other),
    }
}
