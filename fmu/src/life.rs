//! From instantiation to the end.

use crate::arrays::{read, text};
use crate::instances::{self, Log, call, code};
use crate::{Boolean, Code, Handle, LogMessage};
use std::ffi::{c_char, c_void};
use std::path::Path;
use std::sync::atomic::Ordering;
use stillpoint::fmu::{FmuError, Instance};

/// The categories of messages, as the model description has them.
const ERRORS: &str = "logStatusError";
const EVENTS: &str = "logEvents";

/// An instance for co-simulation; null if there is none, and the log says why.
///
/// # Safety
/// Texts end with a zero; `logMessage` may be called with `environment` while the instance lives.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _instanceName: *const c_char,
    instantiationToken: *const c_char,
    resourcePath: *const c_char,
    _visible: Boolean,
    loggingOn: Boolean,
    eventModeUsed: Boolean,
    _earlyReturnAllowed: Boolean,
    _requiredIntermediateVariables: *const u32,
    nRequiredIntermediateVariables: usize,
    instanceEnvironment: *mut c_void,
    logMessage: Option<LogMessage>,
    _intermediateUpdate: *const c_void,
) -> Handle {
    let log = Log::new(instanceEnvironment, logMessage, loggingOn != 0);
    instances::make("fmi3InstantiateCoSimulation", log, || {
        // SAFETY: the caller promises that both texts end with a zero.
        let (token, resources) =
            unsafe { (text("instantiationToken", instantiationToken)?, text("resourcePath", resourcePath)?) };
        if eventModeUsed != 0 {
            return Err(FmuError::Argument("event mode is not supported (`hasEventMode` is false)".to_owned()));
        }
        if nRequiredIntermediateVariables > 0 {
            return Err(FmuError::Argument("intermediate updates are not supported".to_owned()));
        }
        Instance::new(Path::new(&resources), &token)
    })
}

/// Ends an instance.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3FreeInstance(instance: Handle) {
    instances::free(instance);
}

/// Chooses what is told; reasons of failures always are.
///
/// # Safety
/// `categories` points to as many texts, each of which ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: Handle,
    loggingOn: Boolean,
    nCategories: usize,
    categories: *const *const c_char,
) -> Code {
    code(call("fmi3SetDebugLogging", instance, |_, log| {
        // SAFETY: the caller promises as many texts.
        let list = unsafe { read("categories", categories, nCategories) }?;
        let mut events = list.is_empty();
        for category in list {
            // SAFETY: the caller promises that each ends with a zero.
            let category = unsafe { text("categories", *category) }?;
            match category.as_str() {
                EVENTS => events = true,
                ERRORS => {}
                other => {
                    let message = format!("there is no log category `{other}`; allowed: `{ERRORS}`, `{EVENTS}`");
                    return Err(FmuError::Argument(message));
                }
            }
        }
        if events {
            log.events.store(loggingOn != 0, Ordering::Relaxed);
        }
        Ok(())
    }))
}

/// Begins initialization.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3EnterInitializationMode(
    instance: Handle,
    toleranceDefined: Boolean,
    tolerance: f64,
    startTime: f64,
    stopTimeDefined: Boolean,
    stopTime: f64,
) -> Code {
    let tolerance = (toleranceDefined != 0).then_some(tolerance);
    let stop = (stopTimeDefined != 0).then_some(stopTime);
    code(call("fmi3EnterInitializationMode", instance, |held, _| {
        held.instance.enter_initialization(tolerance, startTime, stop)
    }))
}

/// Finds the equilibrium, and goes to step mode.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3ExitInitializationMode(instance: Handle) -> Code {
    code(call("fmi3ExitInitializationMode", instance, |held, _| held.instance.exit_initialization()))
}

/// Ends the experiment.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3Terminate(instance: Handle) -> Code {
    code(call("fmi3Terminate", instance, |held, _| held.instance.terminate()))
}

/// Back to where it was after instantiation.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3Reset(instance: Handle) -> Code {
    code(call("fmi3Reset", instance, |held, _| {
        held.instance.reset();
        Ok(())
    }))
}
