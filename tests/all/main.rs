//! The integration tests, one binary.

mod record;
