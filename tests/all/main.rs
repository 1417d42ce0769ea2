//! All integration tests in one binary: one link, many modules.

mod common;
mod derivatives;
mod oracle;
