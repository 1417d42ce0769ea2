//! All integration tests: one binary.

mod diagnostics;
