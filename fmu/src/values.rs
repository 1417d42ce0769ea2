//! Values of variables. All are numbers of type `Float64`: of every other type there is none.

use crate::arrays::{read, write};
use crate::instances::{call, code};
use crate::{Code, Handle};
use std::ffi::c_void;
use stillpoint::fmu::FmuError;

/// Values of variables.
///
/// # Safety
/// Each array has as many elements as the number beside it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: Handle,
    valueReferences: *const u32,
    nValueReferences: usize,
    values: *mut f64,
    nValues: usize,
) -> Code {
    code(call("fmi3GetFloat64", instance, |held, _| {
        // SAFETY: the caller promises that the array is as long as it says.
        let references = unsafe { read("valueReferences", valueReferences, nValueReferences) }?;
        let each = references.iter().map(|reference| held.instance.value(*reference));
        let all: Vec<f64> = each.collect::<Result<_, _>>()?;
        // SAFETY: the caller promises room for as many as it says.
        unsafe { write("values", values, nValues, &all) }
    }))
}

/// Sets variables: all of them, or none and an error.
///
/// # Safety
/// Each array has as many elements as the number beside it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: Handle,
    valueReferences: *const u32,
    nValueReferences: usize,
    values: *const f64,
    nValues: usize,
) -> Code {
    code(call("fmi3SetFloat64", instance, |held, _| {
        // SAFETY: the caller promises that the arrays are as long as it says.
        let (references, values) =
            unsafe { (read("valueReferences", valueReferences, nValueReferences)?, read("values", values, nValues)?) };
        held.instance.set(references, values)
    }))
}

/// Variables of a type of which there are none.
fn none_of(function: &str, instance: Handle, count: usize) -> Code {
    code(call(function, instance, |_, _| match count {
        0 => Ok(()),
        _ => Err(FmuError::Argument("there is no variable of this type: all are `Float64`".to_owned())),
    }))
}

macro_rules! no_variables {
    ($($get:ident $set:ident ($($more:ident: $type:ty),*);)*) => {$(
        /// No variable is of this type.
        #[unsafe(no_mangle)]
        pub extern "C" fn $get(
            instance: Handle,
            _valueReferences: *const u32,
            nValueReferences: usize,
            $($more: $type),*
        ) -> Code {
            none_of(stringify!($get), instance, nValueReferences)
        }

        /// No variable is of this type.
        #[unsafe(no_mangle)]
        pub extern "C" fn $set(
            instance: Handle,
            _valueReferences: *const u32,
            nValueReferences: usize,
            $($more: $type),*
        ) -> Code {
            none_of(stringify!($set), instance, nValueReferences)
        }
    )*};
}

no_variables! {
    fmi3GetFloat32 fmi3SetFloat32(_values: *const c_void, _nValues: usize);
    fmi3GetInt8 fmi3SetInt8(_values: *const c_void, _nValues: usize);
    fmi3GetUInt8 fmi3SetUInt8(_values: *const c_void, _nValues: usize);
    fmi3GetInt16 fmi3SetInt16(_values: *const c_void, _nValues: usize);
    fmi3GetUInt16 fmi3SetUInt16(_values: *const c_void, _nValues: usize);
    fmi3GetInt32 fmi3SetInt32(_values: *const c_void, _nValues: usize);
    fmi3GetUInt32 fmi3SetUInt32(_values: *const c_void, _nValues: usize);
    fmi3GetInt64 fmi3SetInt64(_values: *const c_void, _nValues: usize);
    fmi3GetUInt64 fmi3SetUInt64(_values: *const c_void, _nValues: usize);
    fmi3GetBoolean fmi3SetBoolean(_values: *const c_void, _nValues: usize);
    fmi3GetString fmi3SetString(_values: *const c_void, _nValues: usize);
    fmi3GetBinary fmi3SetBinary(_valueSizes: *const c_void, _values: *const c_void, _nValues: usize);
    fmi3GetClock fmi3SetClock(_values: *const c_void);
}
