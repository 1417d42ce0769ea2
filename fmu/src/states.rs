//! States of instances: kept, gone back to, and as bytes.

use crate::arrays::{put, read, write};
use crate::instances::{call, code, fresh, handle};
use crate::{Code, Handle};
use std::collections::BTreeMap;
use stillpoint::fmu::{FmuError, Situation};

fn state(states: &BTreeMap<usize, Situation>, of: Handle) -> Result<&Situation, FmuError> {
    states.get(&of.addr()).ok_or_else(|| FmuError::State("no state of this instance has that address".to_owned()))
}

/// The handle at a place.
///
/// # Safety
/// `place` is null or points to a handle.
unsafe fn at(place: *mut Handle) -> Result<Handle, FmuError> {
    match place.is_null() {
        true => Err(FmuError::State("`FMUState` is a null pointer".to_owned())),
        // SAFETY: as the caller promises.
        false => Ok(unsafe { place.read() }),
    }
}

/// Keeps the state of an instance, in the place of the one that `FMUState` holds if it holds one.
///
/// # Safety
/// `FMUState` points to a handle or to null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(instance: Handle, FMUState: *mut Handle) -> Code {
    code(call("fmi3GetFMUState", instance, |held, _| {
        // SAFETY: the caller promises a handle there.
        let there = unsafe { at(FMUState) }?;
        let kept = held.instance.situation().clone();
        let number = if there.is_null() { fresh() } else { there.addr() };
        if !there.is_null() {
            state(&held.states, there)?;
        }
        held.states.insert(number, kept);
        // SAFETY: it is not null.
        unsafe { put(FMUState, handle(number)) };
        Ok(())
    }))
}

/// Goes back to a state.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3SetFMUState(instance: Handle, FMUState: Handle) -> Code {
    code(call("fmi3SetFMUState", instance, |held, _| {
        let kept = state(&held.states, FMUState)?;
        held.instance.restore(kept);
        Ok(())
    }))
}

/// Forgets a state; null is none.
///
/// # Safety
/// `FMUState` is null or points to a handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(instance: Handle, FMUState: *mut Handle) -> Code {
    code(call("fmi3FreeFMUState", instance, |held, _| {
        if FMUState.is_null() {
            return Ok(());
        }
        // SAFETY: the caller promises a handle there.
        let there = unsafe { at(FMUState) }?;
        if !there.is_null() {
            state(&held.states, there)?;
            held.states.remove(&there.addr());
        }
        // SAFETY: it is not null.
        unsafe { put(FMUState, std::ptr::null_mut()) };
        Ok(())
    }))
}

/// How many bytes a state has.
///
/// # Safety
/// `size` is null or points to room for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(instance: Handle, FMUState: Handle, size: *mut usize) -> Code {
    code(call("fmi3SerializedFMUStateSize", instance, |held, _| {
        let bytes = held.instance.to_bytes(state(&held.states, FMUState)?);
        // SAFETY: the caller promises room where the pointer is not null.
        unsafe { put(size, bytes.len()) };
        Ok(())
    }))
}

/// The bytes of a state.
///
/// # Safety
/// `serializedState` has room for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(
    instance: Handle,
    FMUState: Handle,
    serializedState: *mut u8,
    size: usize,
) -> Code {
    code(call("fmi3SerializeFMUState", instance, |held, _| {
        let bytes = held.instance.to_bytes(state(&held.states, FMUState)?);
        // SAFETY: the caller promises room for `size` bytes.
        unsafe { write("serializedState", serializedState, size, &bytes) }
    }))
}

/// A state from its bytes, of this instance or of another one of the same FMU.
///
/// # Safety
/// `serializedState` has `size` bytes; `FMUState` points to a handle or to null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: Handle,
    serializedState: *const u8,
    size: usize,
    FMUState: *mut Handle,
) -> Code {
    code(call("fmi3DeserializeFMUState", instance, |held, _| {
        // SAFETY: the caller promises as many bytes, and a handle.
        let (bytes, there) = unsafe { (read("serializedState", serializedState, size)?, at(FMUState)?) };
        let number = if there.is_null() { fresh() } else { there.addr() };
        if !there.is_null() {
            state(&held.states, there)?;
        }
        let kept = held.instance.of_bytes(bytes)?;
        held.states.insert(number, kept);
        // SAFETY: it is not null.
        unsafe { put(FMUState, handle(number)) };
        Ok(())
    }))
}
