//! Functions of capabilities that the model description does not claim: each refuses, and says so.

use crate::instances::{Log, call, code, make};
use crate::{Boolean, Code, Handle, LogMessage};
use std::ffi::{c_char, c_void};
use stillpoint::fmu::FmuError;

fn refused() -> FmuError {
    FmuError::Argument("the model description does not claim this capability".to_owned())
}

macro_rules! unsupported {
    ($($function:ident($($name:ident: $type:ty),*);)*) => {$(
        /// Not supported.
        #[unsafe(no_mangle)]
        pub extern "C" fn $function(instance: Handle, $($name: $type),*) -> Code {
            code(call(stringify!($function), instance, |_, _| Err(refused())))
        }
    )*};
}

unsupported! {
    fmi3EnterEventMode();
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
    fmi3EnterStepMode();
    fmi3EnterContinuousTimeMode();
    fmi3EvaluateDiscreteStates();
    fmi3UpdateDiscreteStates(_a: *mut Boolean, _b: *mut Boolean, _c: *mut Boolean, _d: *mut Boolean, _e: *mut Boolean, _f: *mut f64);
    fmi3GetNumberOfVariableDependencies(_reference: u32, _count: *mut usize);
    fmi3GetVariableDependencies(
        _dependent: u32, _elements: *mut usize, _independents: *mut u32, _others: *mut usize, _kinds: *mut i32, _count: usize
    );
    fmi3GetAdjointDerivative(
        _unknowns: *const u32, _nUnknowns: usize, _knowns: *const u32, _nKnowns: usize, _seed: *const f64, _nSeed: usize,
        _sensitivity: *mut f64, _nSensitivity: usize
    );
    fmi3GetIntervalDecimal(_references: *const u32, _count: usize, _intervals: *mut f64, _qualifiers: *mut i32);
    fmi3GetIntervalFraction(
        _references: *const u32, _count: usize, _counters: *mut u64, _resolutions: *mut u64, _qualifiers: *mut i32
    );
    fmi3GetShiftDecimal(_references: *const u32, _count: usize, _shifts: *mut f64);
    fmi3GetShiftFraction(_references: *const u32, _count: usize, _counters: *mut u64, _resolutions: *mut u64);
    fmi3SetIntervalDecimal(_references: *const u32, _count: usize, _intervals: *const f64);
    fmi3SetIntervalFraction(_references: *const u32, _count: usize, _counters: *const u64, _resolutions: *const u64);
    fmi3SetShiftDecimal(_references: *const u32, _count: usize, _shifts: *const f64);
    fmi3SetShiftFraction(_references: *const u32, _count: usize, _counters: *const u64, _resolutions: *const u64);
    fmi3CompletedIntegratorStep(_last: Boolean, _enter: *mut Boolean, _terminate: *mut Boolean);
    fmi3SetTime(_time: f64);
    fmi3SetContinuousStates(_states: *const f64, _count: usize);
    fmi3GetContinuousStateDerivatives(_derivatives: *mut f64, _count: usize);
    fmi3GetEventIndicators(_indicators: *mut f64, _count: usize);
    fmi3GetContinuousStates(_states: *mut f64, _count: usize);
    fmi3GetNominalsOfContinuousStates(_nominals: *mut f64, _count: usize);
    fmi3GetNumberOfEventIndicators(_count: *mut usize);
    fmi3GetNumberOfContinuousStates(_count: *mut usize);
    fmi3GetOutputDerivatives(_references: *const u32, _count: usize, _orders: *const i32, _values: *mut f64, _nValues: usize);
    fmi3ActivateModelPartition(_clock: u32, _time: f64);
}

/// Not supported.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3InstantiateModelExchange(
    _instanceName: *const c_char,
    _instantiationToken: *const c_char,
    _resourcePath: *const c_char,
    _visible: Boolean,
    loggingOn: Boolean,
    instanceEnvironment: *mut c_void,
    logMessage: Option<LogMessage>,
) -> Handle {
    let log = Log::new(instanceEnvironment, logMessage, loggingOn != 0);
    make("fmi3InstantiateModelExchange", log, || Err(refused()))
}

/// Not supported.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3InstantiateScheduledExecution(
    _instanceName: *const c_char,
    _instantiationToken: *const c_char,
    _resourcePath: *const c_char,
    _visible: Boolean,
    loggingOn: Boolean,
    instanceEnvironment: *mut c_void,
    logMessage: Option<LogMessage>,
    _clockUpdate: *const c_void,
    _lockPreemption: *const c_void,
    _unlockPreemption: *const c_void,
) -> Handle {
    let log = Log::new(instanceEnvironment, logMessage, loggingOn != 0);
    make("fmi3InstantiateScheduledExecution", log, || Err(refused()))
}
