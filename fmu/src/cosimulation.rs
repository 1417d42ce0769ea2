//! Communication steps.

use crate::arrays::put;
use crate::instances::{call, code};
use crate::{Boolean, Code, Handle};

/// One communication step. It returns early only at an event that ends the run, and asks for the end of the simulation then.
///
/// # Safety
/// Each pointer is null or points to room for a value.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: Handle,
    currentCommunicationPoint: f64,
    communicationStepSize: f64,
    _noSetFMUStatePriorToCurrentPoint: Boolean,
    eventHandlingNeeded: *mut Boolean,
    terminateSimulation: *mut Boolean,
    earlyReturn: *mut Boolean,
    lastSuccessfulTime: *mut f64,
) -> Code {
    code(call("fmi3DoStep", instance, |held, log| {
        let stepped = held.instance.step(currentCommunicationPoint, communicationStepSize)?;
        for (time, what) in &stepped.events {
            log.event(*time, what);
        }
        let ended = Boolean::from(stepped.stopped_by.is_some());
        // SAFETY: the caller promises room where the pointers are not null.
        unsafe {
            put(eventHandlingNeeded, 0);
            put(terminateSimulation, ended);
            put(earlyReturn, ended);
            put(lastSuccessfulTime, stepped.time);
        }
        Ok(())
    }))
}
