//! All instances of the process, by handle, and their logs.

use crate::{Code, Handle, LogMessage, Status};
use std::collections::BTreeMap;
use std::ffi::{CString, c_void};
use std::fmt::Display;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use stillpoint::fmu::{FmuError, Instance, Situation};
use stillpoint::foreign;

/// Where an importer hears of things.
pub(crate) struct Log {
    /// The importer's own pointer, which it gets back.
    environment: usize,
    callback: Option<LogMessage>,
    /// Whether events are told of.
    pub(crate) events: AtomicBool,
}

impl Log {
    pub(crate) fn new(environment: *mut c_void, callback: Option<LogMessage>, events: bool) -> Self {
        Self { environment: environment.expose_provenance(), callback, events: AtomicBool::new(events) }
    }

    fn tell(&self, status: Status, category: &str, message: &str) {
        let Some(callback) = self.callback else { return };
        let text = |text: &str| CString::new(text.replace('\0', " ")).unwrap_or_default();
        let (category, message) = (text(category), text(message));
        let environment = std::ptr::with_exposed_provenance_mut(self.environment);
        // SAFETY: the importer gave this function with its environment, for as long as the instance lives; both texts end with a
        // zero and live until it returns.
        unsafe { callback(environment, status as Code, category.as_ptr(), message.as_ptr()) };
    }

    /// Says why a call failed.
    pub(crate) fn error(&self, status: Status, function: &str, why: &dyn Display) {
        self.tell(status, "logStatusError", &format!("{function}: {why}"));
    }

    /// Says what happened in the scene, if that is wanted.
    pub(crate) fn event(&self, time: f64, what: &str) {
        if self.events.load(Ordering::Relaxed) {
            self.tell(Status::Ok, "logEvents", &format!("{time} s: {what}"));
        }
    }
}

/// An instance with its states.
pub(crate) struct InstanceWithStates {
    pub(crate) instance: Instance,
    /// By handle.
    pub(crate) states: BTreeMap<usize, Situation>,
    /// A panic may have left it half changed.
    broken: bool,
}

struct Slot {
    held: Mutex<InstanceWithStates>,
    log: Log,
}

static SLOTS: Mutex<BTreeMap<usize, Arc<Slot>>> = Mutex::new(BTreeMap::new());

fn slots() -> MutexGuard<'static, BTreeMap<usize, Arc<Slot>>> {
    SLOTS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A number that was never used before, of an instance or of a state.
pub(crate) fn fresh() -> usize {
    static NEXT: AtomicUsize = AtomicUsize::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// The handle of a number.
pub(crate) fn handle(number: usize) -> Handle {
    std::ptr::without_provenance_mut(number)
}

/// Makes an instance, or tells `log` why there is none.
pub(crate) fn make(function: &str, log: Log, make: impl FnOnce() -> Result<Instance, FmuError>) -> Handle {
    let made = foreign::caught(make);
    let instance = match made {
        Ok(Ok(instance)) => instance,
        Ok(Err(error)) => {
            log.error(Status::Error, function, &error);
            return std::ptr::null_mut();
        }
        Err(panic) => {
            log.error(Status::Fatal, function, &panic);
            return std::ptr::null_mut();
        }
    };
    let held = Mutex::new(InstanceWithStates { instance, states: BTreeMap::new(), broken: false });
    let number = fresh();
    slots().insert(number, Arc::new(Slot { held, log }));
    handle(number)
}

/// Ends an instance; nothing happens to a handle of none.
pub(crate) fn free(instance: Handle) {
    let slot = slots().remove(&instance.addr());
    drop(slot);
}

/// Does something with an instance. Why it fails goes to the log, after the instance is free for other calls.
pub(crate) fn call<T>(
    function: &str,
    instance: Handle,
    work: impl FnOnce(&mut InstanceWithStates, &Log) -> Result<T, FmuError>,
) -> Result<T, Code> {
    let Some(slot) = slots().get(&instance.addr()).cloned() else { return Err(Status::Error as Code) };
    let answer = match slot.held.try_lock() {
        Err(TryLockError::WouldBlock) => Err((Status::Error, "another call of this instance is not over".to_owned())),
        Err(TryLockError::Poisoned(_)) => Err((Status::Fatal, "an earlier call failed within".to_owned())),
        Ok(held) if held.broken => Err((Status::Fatal, "an earlier call failed within".to_owned())),
        Ok(mut held) => match foreign::caught(|| work(&mut held, &slot.log)) {
            Ok(answer) => answer.map_err(|error| (Status::Error, error.to_string())),
            Err(panic) => {
                held.broken = true;
                Err((Status::Fatal, format!("this is a fault of stillpoint: {panic}")))
            }
        },
    };
    answer.map_err(|(status, why)| {
        slot.log.error(status, function, &why);
        status as Code
    })
}

/// The code of what has no other answer.
pub(crate) fn code(answer: Result<(), Code>) -> Code {
    answer.err().unwrap_or(Status::Ok as Code)
}
