//! What sending ends in, and how long it may take.

use std::time::Duration;

/// Why something was not sent.
pub(super) type Failure = Box<dyn std::error::Error + Send + Sync>;
/// What sending ends in.
pub(super) type Sent<T = ()> = Result<T, Failure>;

/// How long one job may take. A viewer that takes in nothing for so long is given up.
pub(super) const PATIENCE: Duration = Duration::from_secs(10);

/// What is said of a viewer that is given up.
pub(super) fn stuck() -> String {
    format!("it took in nothing for {} s", PATIENCE.as_secs())
}
