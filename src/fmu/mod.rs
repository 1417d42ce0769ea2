//! Co-simulation by the Functional Mock-up Interface, FMI 3.0: what an FMU of a scenario holds, and what an instance of it does.
//!
//! ```text
//! name.fmu ─┬─ modelDescription.xml                 Variables ─► describe
//!           ├─ resources ─┬─ manifest.json          Manifest: which scenario, what is set in it, which numbers are parameters
//!           │             └─ the scenario and the files that it takes, as they lie beside each other
//!           └─ binaries/<platform>/name.so          the C functions of the workspace's member `fmu`, each a call of Instance
//! ```
//!
//! Every instance reads the scenario anew: the FMU holds no other form of the scene. Parameters are set as `--set` sets them, before
//! initialization; initialization is the equilibrium; a communication step is one step of a
//! [`Simulator`](crate::simulator::Simulator).

mod derivative;
mod describe;
mod instance;
mod manifest;
mod scene;
mod state;
mod variables;

pub use describe::describe;
pub use instance::{Instance, Stepped};
pub use manifest::{MANIFEST, Manifest};
pub use scene::{Scene, at_start};
pub use state::Situation;
pub use variables::{Role, Variable, Variables};

use crate::simulate::RunError;

/// What the library within FMUs holds, for the program to know it by: both have to be of one version.
pub const MARK: &str = concat!("stillpoint ", env!("CARGO_PKG_VERSION"), ", functions of FMI 3.0");

/// Why a call is refused, or failed. The instance is then as it was before the call.
#[derive(Debug, thiserror::Error)]
pub enum FmuError {
    /// A call out of order.
    #[error("it is not allowed {state}; allowed: {allowed}")]
    Order {
        /// What the instance is in.
        state: &'static str,
        /// When it may be called.
        allowed: &'static str,
    },
    /// A value reference without a variable.
    #[error("there is no variable with value reference {reference}; allowed: 0 to {last}")]
    NoVariable {
        /// As called.
        reference: u32,
        /// The largest one.
        last: u32,
    },
    /// A variable that cannot be set, or not now.
    #[error("`{name}` cannot be set: {why}")]
    Fixed {
        /// The variable.
        name: String,
        /// Why.
        why: String,
    },
    /// A value that is not a finite number.
    #[error("`{name}` is {value}, allowed: finite numbers")]
    NotFinite {
        /// The variable or argument.
        name: String,
        /// As called.
        value: f64,
    },
    /// An argument that makes no sense, or asks for what is not supported.
    #[error("{0}")]
    Argument(String),
    /// As many values as variables are wanted.
    #[error("{given} values for {wanted} variables")]
    Count {
        /// As called.
        given: usize,
        /// As many as there are variables.
        wanted: usize,
    },
    /// A time that does not fit.
    #[error("{0}")]
    Time(String),
    /// The resources are not those of an FMU of this program.
    #[error("{0}")]
    Resources(String),
    /// The scenario is wrong, maybe by the values of its parameters.
    #[error("{0}")]
    Scene(String),
    /// Initialization has no answer.
    #[error("{0}")]
    NoEquilibrium(String),
    /// A step cannot be made, or outputs cannot be evaluated.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A derivative that is not known.
    #[error("{0}")]
    Derivative(String),
    /// Bytes that are no state of this FMU.
    #[error("these bytes are no state of this FMU: {0}")]
    State(String),
}
