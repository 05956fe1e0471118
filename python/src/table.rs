//! Tables of Python as columns: through Arrow's C interface, from buffers (numpy, array, memoryview) and from sequences.

use arrow_array::cast::AsArray;
use arrow_array::ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader};
use arrow_array::types::*;
use arrow_array::{Array, ArrayRef, RecordBatchReader};
use arrow_schema::{DataType, TimeUnit};
use pyo3::buffer::{ElementType, PyUntypedBuffer};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyCapsule, PyDict, PyString};
use tumble::record::{Cells, Held};

/// Columns with their titles.
pub type Columns = Vec<(String, Cells)>;

/// The columns of a table: an object with `__arrow_c_stream__`, or a dict of columns.
pub fn columns(table: &Bound<'_, PyAny>) -> PyResult<Columns> {
    if table.hasattr("__arrow_c_stream__")? {
        return of_stream(table);
    }
    let dict = table.cast::<PyDict>().map_err(|_| {
        PyTypeError::new_err(format!("{} is no table: expected a dict of columns or an Arrow stream", table.get_type()))
    })?;
    let mut found = Vec::with_capacity(dict.len());
    for (name, cells) in dict.iter() {
        let name: String = name.str()?.to_string();
        let cells = column(&cells).map_err(|error| {
            PyValueError::new_err(format!("the column '{name}' cannot be read: {}", error.value(table.py())))
        })?;
        found.push((name, cells));
    }
    Ok(found)
}

/// How many cells.
pub fn length(cells: &Cells) -> usize {
    match cells {
        Cells::Numbers(own) => own.len(),
        Cells::Texts(own) => own.len(),
    }
}

/// A table in memory as the library reads it.
pub fn held(name: &str, columns: Columns) -> tumble::Result<Held> {
    Held::of(name, columns)
}

/// A numeric array of any number of dimensions, row by row, and its shape.
pub fn array(object: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, Vec<usize>)> {
    let buffer = PyUntypedBuffer::get(object)?;
    let shape = buffer.shape().to_vec();
    match numbers(object.py(), &buffer)? {
        Some(values) => Ok((values, shape)),
        None => Err(PyTypeError::new_err("expected an array of float64, float32 or integers")),
    }
}

/// What a buffer holds, row by row; `None` where that is no number.
fn numbers(py: Python<'_>, buffer: &PyUntypedBuffer) -> PyResult<Option<Vec<f64>>> {
    macro_rules! wide {
        ($kind:ty) => {
            Ok(Some(buffer.as_typed::<$kind>()?.to_vec(py)?.into_iter().map(|v| v as f64).collect()))
        };
    }
    match ElementType::from_format(buffer.format()) {
        ElementType::Float { bytes: 8 } => Ok(Some(buffer.as_typed::<f64>()?.to_vec(py)?)),
        ElementType::Float { bytes: 4 } => wide!(f32),
        ElementType::SignedInteger { bytes: 8 } => wide!(i64),
        ElementType::SignedInteger { bytes: 4 } => wide!(i32),
        ElementType::SignedInteger { bytes: 2 } => wide!(i16),
        ElementType::SignedInteger { bytes: 1 } => wide!(i8),
        ElementType::UnsignedInteger { bytes: 8 } => wide!(u64),
        ElementType::UnsignedInteger { bytes: 4 } => wide!(u32),
        ElementType::UnsignedInteger { bytes: 2 } => wide!(u16),
        ElementType::UnsignedInteger { bytes: 1 } => wide!(u8),
        _ => Ok(None),
    }
}

/// One column.
fn column(object: &Bound<'_, PyAny>) -> PyResult<Cells> {
    if !object.is_instance_of::<PyString>()
        && let Ok(buffer) = PyUntypedBuffer::get(object)
    {
        if buffer.dimensions() != 1 {
            return Err(PyValueError::new_err(format!("expected one dimension, found {}", buffer.dimensions())));
        }
        if let Some(values) = numbers(object.py(), &buffer)? {
            return Ok(Cells::Numbers(values));
        }
    }
    let list = if object.hasattr("tolist")? { object.call_method0("tolist")? } else { object.clone() };
    let mut gathered = Gathered::default();
    for cell in list.try_iter()? {
        gathered.push(&cell?)?;
    }
    Ok(gathered.cells())
}

/// A column in the making: numbers until a text comes.
#[derive(Default)]
struct Gathered {
    numbers: Vec<f64>,
    texts: Option<Vec<String>>,
}

impl Gathered {
    fn push(&mut self, cell: &Bound<'_, PyAny>) -> PyResult<()> {
        if cell.is_none() {
            return self.put(f64::NAN, "");
        }
        if let Ok(text) = cell.cast::<PyString>() {
            let text = text.to_string();
            if self.texts.is_none() {
                self.texts = Some(self.numbers.iter().map(|v| written(*v)).collect());
            }
            return self.put(f64::NAN, &text);
        }
        let number = match cell.cast::<PyBool>() {
            Ok(truth) => Some(f64::from(u8::from(truth.is_true()))),
            Err(_) => cell.extract::<f64>().ok(),
        };
        match number {
            Some(number) => self.put(number, &written(number)),
            // a date, an identifier
            None => {
                let text = match cell.call_method0("isoformat") {
                    Ok(text) => text.to_string(),
                    Err(_) => cell.str()?.to_string(),
                };
                self.push(PyString::new(cell.py(), &text).as_any())
            }
        }
    }

    fn put(&mut self, number: f64, text: &str) -> PyResult<()> {
        match &mut self.texts {
            Some(texts) => texts.push(text.to_string()),
            None => self.numbers.push(number),
        }
        Ok(())
    }

    fn cells(self) -> Cells {
        self.texts.map_or(Cells::Numbers(self.numbers), Cells::Texts)
    }
}

fn written(number: f64) -> String {
    if number.is_nan() { String::new() } else { number.to_string() }
}

/// The columns of a stream of Arrow's PyCapsule interface; what the producer holds is read where it is.
fn of_stream(table: &Bound<'_, PyAny>) -> PyResult<Columns> {
    let capsule = table.call_method0("__arrow_c_stream__")?;
    let pointer = capsule.cast::<PyCapsule>()?.pointer_checked(Some(c"arrow_array_stream"))?;
    // SAFETY: the name of the capsule says what it points at; `from_raw` moves it out and leaves a released stream behind
    let reader = unsafe { RecordBatchStreamReader::from_raw(pointer.cast::<FFI_ArrowArrayStream>().as_ptr()) };
    let reader = reader.map_err(unread)?;
    let schema = reader.schema();
    let mut found: Columns = Vec::new();
    for field in schema.fields() {
        let cells = if is_text(field.data_type()) { Cells::Texts(Vec::new()) } else { Cells::Numbers(Vec::new()) };
        found.push((field.name().clone(), cells));
    }
    for batch in reader {
        let batch = batch.map_err(unread)?;
        for ((name, cells), array) in found.iter_mut().zip(batch.columns()) {
            let read = match cells {
                Cells::Numbers(to) => push_numbers(array, to),
                Cells::Texts(to) => push_texts(array, to),
            };
            if !read {
                return Err(PyTypeError::new_err(format!(
                    "the column '{name}' is of type {}: expected numbers or texts",
                    array.data_type()
                )));
            }
        }
    }
    Ok(found)
}

fn unread(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(format!("the table cannot be read: {error}"))
}

fn is_text(kind: &DataType) -> bool {
    match kind {
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View | DataType::Date32 => true,
        DataType::Dictionary(_, values) => is_text(values),
        _ => false,
    }
}

/// Numbers of an array behind others; false where it has none. Times become seconds.
fn push_numbers(array: &ArrayRef, to: &mut Vec<f64>) -> bool {
    macro_rules! push {
        ($kind:ty, $per:expr) => {{
            let own = array.as_primitive::<$kind>();
            match own.null_count() {
                0 => to.extend(own.values().iter().map(|v| *v as f64 / $per)),
                _ => to.extend(own.iter().map(|v| v.map_or(f64::NAN, |v| v as f64 / $per))),
            }
        }};
    }
    match array.data_type() {
        DataType::Float64 => push!(Float64Type, 1.0),
        DataType::Float32 => push!(Float32Type, 1.0),
        DataType::Int64 => push!(Int64Type, 1.0),
        DataType::Int32 => push!(Int32Type, 1.0),
        DataType::Int16 => push!(Int16Type, 1.0),
        DataType::Int8 => push!(Int8Type, 1.0),
        DataType::UInt64 => push!(UInt64Type, 1.0),
        DataType::UInt32 => push!(UInt32Type, 1.0),
        DataType::UInt16 => push!(UInt16Type, 1.0),
        DataType::UInt8 => push!(UInt8Type, 1.0),
        DataType::Timestamp(TimeUnit::Second, _) => push!(TimestampSecondType, 1.0),
        DataType::Timestamp(TimeUnit::Millisecond, _) => push!(TimestampMillisecondType, 1e3),
        DataType::Timestamp(TimeUnit::Microsecond, _) => push!(TimestampMicrosecondType, 1e6),
        DataType::Timestamp(TimeUnit::Nanosecond, _) => push!(TimestampNanosecondType, 1e9),
        DataType::Boolean => {
            to.extend(array.as_boolean().iter().map(|v| v.map_or(f64::NAN, |v| f64::from(u8::from(v)))));
        }
        DataType::Null => to.extend(std::iter::repeat_n(f64::NAN, array.len())),
        _ => return false,
    }
    true
}

fn push_texts(array: &ArrayRef, to: &mut Vec<String>) -> bool {
    fn push<'a>(texts: impl Iterator<Item = Option<&'a str>>, to: &mut Vec<String>) {
        to.extend(texts.map(|text| text.unwrap_or_default().to_string()));
    }
    match array.data_type() {
        DataType::Utf8 => push(array.as_string::<i32>().iter(), to),
        DataType::LargeUtf8 => push(array.as_string::<i64>().iter(), to),
        DataType::Utf8View => push(array.as_string_view().iter(), to),
        DataType::Date32 => {
            let own = array.as_primitive::<Date32Type>();
            let day = |k: usize| own.value_as_date(k).filter(|_| own.is_valid(k)).map(|day| day.to_string());
            to.extend((0..own.len()).map(|k| day(k).unwrap_or_default()));
        }
        DataType::Dictionary(..) => {
            let Some(own) = array.as_any_dictionary_opt() else { return false };
            let mut texts = Vec::new();
            if !push_texts(own.values(), &mut texts) {
                return false;
            }
            if texts.is_empty() {
                to.extend(std::iter::repeat_n(String::new(), array.len()));
                return true;
            }
            let text = |k: usize, key: usize| own.is_valid(k).then(|| texts.get(key)).flatten().cloned();
            to.extend(own.normalized_keys().into_iter().enumerate().map(|(k, key)| text(k, key).unwrap_or_default()));
        }
        _ => return false,
    }
    true
}
