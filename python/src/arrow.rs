//! Tables for programs that speak Arrow (polars, pandas, pyarrow, DuckDB): the PyCapsule interface, `__arrow_c_stream__`.
//!
//! Numbers of read-only arrays are handed over where they lie, never copied; the consumer keeps the arrays alive.

use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{
    ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, RecordBatchIterator, RecordBatchReader, StringArray,
};
use arrow_buffer::{BooleanBuffer, Buffer, NullBuffer, ScalarBuffer};
use arrow_schema::{ArrowError, DataType, Field, Schema};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyCapsule, PyList};
use std::collections::HashMap;
use std::panic::AssertUnwindSafe;
use std::ptr::NonNull;
use std::sync::Arc;

/// A column: heading, SI unit (empty for none), numbers.
pub(crate) struct Column<'py> {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) values: Bound<'py, PyAny>,
}

fn wrong(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// The stream of a table in one piece. With `empty` numbers that are no numbers are cells without a value.
pub(crate) fn stream<'py>(py: Python<'py>, columns: Vec<Column<'py>>, empty: bool) -> PyResult<Bound<'py, PyCapsule>> {
    let (mut fields, mut arrays) = (Vec::new(), Vec::new());
    for column in columns {
        let array = array(&column.values, empty)?;
        let mut field = Field::new(column.name, array.data_type().clone(), true);
        if !column.unit.is_empty() {
            field = field.with_metadata(HashMap::from([("unit".to_owned(), column.unit)]));
        }
        fields.push(field);
        arrays.push(array);
    }
    let schema = Arc::new(Schema::new(fields));
    let batch = RecordBatch::try_new(Arc::clone(&schema), arrays).map_err(wrong)?;
    let batches = RecordBatchIterator::new([Ok::<_, ArrowError>(batch)], schema);
    let reader: Box<dyn RecordBatchReader + Send> = Box::new(batches);
    PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(reader), c"arrow_array_stream")
}

/// A column of numbers, whole numbers, words or flags, as Arrow has it.
fn array(values: &Bound<'_, PyAny>, empty: bool) -> PyResult<ArrayRef> {
    if let Ok(numbers) = values.cast::<PyArray1<f64>>() {
        let buffer = shared(numbers)?;
        let nulls = empty.then(|| NullBuffer::new(BooleanBuffer::collect_bool(buffer.len(), |i| !buffer[i].is_nan())));
        return Ok(Arc::new(Float64Array::new(buffer, nulls)));
    }
    let list = values.cast::<PyList>().map_err(|_| PyTypeError::new_err("a column is an array or a list"))?;
    let first = list.iter().find(|value| !value.is_none());
    fn all<'py, T: for<'a> FromPyObject<'a, 'py>>(list: &Bound<'py, PyList>) -> PyResult<Vec<Option<T>>> {
        list.iter()
            .map(|value| match value.is_none() {
                true => Ok(None),
                false => value.extract::<T>().map(Some).map_err(|_| PyTypeError::new_err("a column of mixed types")),
            })
            .collect()
    }
    Ok(match first {
        Some(first) if first.is_instance_of::<PyBool>() => Arc::new(BooleanArray::from(all::<bool>(list)?)),
        Some(first) if first.extract::<i64>().is_ok() => Arc::new(Int64Array::from(all::<i64>(list)?)),
        Some(first) if first.extract::<f64>().is_ok() => Arc::new(Float64Array::from(all::<f64>(list)?)),
        Some(_) => Arc::new(StringArray::from(all::<String>(list)?)),
        None => arrow_array::new_null_array(&DataType::Utf8, list.len()),
    })
}

/// The numbers of an array where they lie, if nobody can change them; else a copy.
fn shared(array: &Bound<'_, PyArray1<f64>>) -> PyResult<ScalarBuffer<f64>> {
    let readonly: PyReadonlyArray1<'_, f64> = array.readonly();
    let Ok(slice) = readonly.as_slice() else {
        return Ok(readonly.as_array().iter().copied().collect::<Vec<f64>>().into());
    };
    let is_fixed = !array.getattr("flags")?.getattr("writeable")?.extract::<bool>()?;
    let Some(start) = NonNull::new(slice.as_ptr().cast_mut().cast::<u8>()).filter(|_| is_fixed && array.len() > 0)
    else {
        return Ok(slice.to_vec().into());
    };
    let owner = Arc::new(AssertUnwindSafe(array.clone().unbind()));
    // SAFETY: the memory belongs to an array that nobody can write to and that the buffer keeps alive; its length in bytes is that of
    // the slice.
    #[allow(unsafe_code)]
    let buffer = unsafe { Buffer::from_custom_allocation(start, std::mem::size_of_val(slice), owner) };
    Ok(ScalarBuffer::new(buffer, 0, slice.len()))
}

/// The stream of columns by their headings: what `__arrow_c_stream__` of a table returns. Arrays are of numbers, `nan` where there is
/// none; lists of whole numbers, words or flags, `None` where there is none.
#[pyfunction]
pub(crate) fn arrow_stream<'py>(
    py: Python<'py>,
    columns: Vec<(String, Bound<'py, PyAny>)>,
) -> PyResult<Bound<'py, PyCapsule>> {
    let columns = columns.into_iter().map(|(name, values)| Column { name, unit: String::new(), values });
    stream(py, columns.collect(), true)
}
