//! stillpoint from Python. Scenes are immutable and shared, results are arrays that nothing else writes to, and everything
//! that takes time lets other Python threads run and heeds Ctrl-C.

mod arrow;
mod batch;
mod control;
mod dynamics;
mod equilibrium;
mod fit;
mod interrupt;
mod linear;
mod path;
mod recorder;
mod run;
mod scene;
mod simulator;
mod start;

use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use std::ffi::OsString;
use std::process::ExitCode;

create_exception!(
    stillpoint,
    SceneError,
    PyValueError,
    "A scene with problems: its text has them with line and caret."
);
create_exception!(stillpoint, RunError, PyRuntimeError, "A run that ended before its time.");
create_exception!(
    stillpoint,
    NoEquilibrium,
    PyRuntimeError,
    "Statics found no equilibrium; `answer` has what it found."
);

/// Runs the program with these arguments; gives its exit code.
#[pyfunction]
fn program(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    let code = py.detach(|| stillpoint::cli::main_with(arguments, None));
    [0, 1, 2, 130].into_iter().find(|known| code == ExitCode::from(*known)).unwrap_or(1)
}

#[pymodule]
fn _stillpoint(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("SceneError", py.get_type::<SceneError>())?;
    module.add("RunError", py.get_type::<RunError>())?;
    module.add("NoEquilibrium", py.get_type::<NoEquilibrium>())?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<equilibrium::Equilibrium>()?;
    module.add_class::<equilibrium::Mode>()?;
    module.add_class::<linear::Linear>()?;
    module.add_class::<run::Run>()?;
    module.add_class::<simulator::Simulator>()?;
    module.add_class::<path::Path>()?;
    module.add_class::<path::Branch>()?;
    module.add_class::<dynamics::Dynamics>()?;
    module.add_function(wrap_pyfunction!(scene::load, module)?)?;
    module.add_function(wrap_pyfunction!(scene::parse, module)?)?;
    module.add_function(wrap_pyfunction!(run::open, module)?)?;
    module.add_function(wrap_pyfunction!(arrow::arrow_stream, module)?)?;
    module.add_function(wrap_pyfunction!(program, module)?)
}
