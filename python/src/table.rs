//! Tables of Python as columns: through Arrow's C interface, from buffers (numpy, array, memoryview) and from sequences.
//!
//! A column is numbers, or texts where one of its cells is no number that a double keeps: a time (as ISO 8601 writes it, in UTC), a whole number of more
//! than 53 bits, a value of a type that is not read. What is absent is NaN, or an empty text.

use arrow_array::cast::AsArray;
use arrow_array::ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader};
use arrow_array::types::*;
use arrow_array::{Array, RecordBatchReader, downcast_integer_array, downcast_temporal_array};
use arrow_schema::{DataType, TimeUnit};
use pyo3::buffer::{ElementType, PyUntypedBuffer};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyCapsule, PyDict, PyFloat, PyInt, PyString};
use tumble::record::{Cells, Held};

/// Up to here every whole number is a double.
const WHOLE: u128 = 1 << 53;

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

/// Is a cell empty?
pub fn is_empty(cells: &Cells, row: usize) -> bool {
    match cells {
        Cells::Numbers(own) => own.get(row).is_none_or(|number| number.is_nan()),
        Cells::Texts(own) => own.get(row).is_none_or(|text| text.trim().is_empty()),
    }
}

/// Put a cell in the place of another one.
pub fn copy(cells: &mut Cells, from: usize, to: usize) {
    fn copy<T: Clone>(own: &mut [T], from: usize, to: usize) {
        if let (Some(cell), Some(place)) = (own.get(from).cloned(), own.get_mut(to)) {
            *place = cell;
        }
    }
    match cells {
        Cells::Numbers(own) => copy(own, from, to),
        Cells::Texts(own) => copy(own, from, to),
    }
}

/// A table in memory as the library reads it.
pub fn held(name: &str, columns: Columns) -> tumble::Result<Held> {
    Held::of(name, columns)
}

/// An array of doubles of any number of dimensions, row by row, and its shape.
pub fn array(object: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, Vec<usize>)> {
    let buffer = PyUntypedBuffer::get(object)?;
    Ok((buffer.as_typed::<f64>()?.to_vec(object.py())?, buffer.shape().to_vec()))
}

/// The cells of a buffer; `None` where it holds no numbers.
fn of_buffer(py: Python<'_>, buffer: &PyUntypedBuffer) -> PyResult<Option<Cells>> {
    macro_rules! whole {
        ($kind:ty) => {{
            let mut gathered = Gathered::default();
            buffer.as_typed::<$kind>()?.to_vec(py)?.into_iter().for_each(|value| gathered.whole(value.into()));
            gathered.cells()
        }};
    }
    Ok(Some(match ElementType::from_format(buffer.format()) {
        ElementType::Float { bytes: 8 } => Cells::Numbers(buffer.as_typed::<f64>()?.to_vec(py)?),
        ElementType::Float { bytes: 4 } => {
            Cells::Numbers(buffer.as_typed::<f32>()?.to_vec(py)?.into_iter().map(f64::from).collect())
        }
        ElementType::SignedInteger { bytes: 8 } => whole!(i64),
        ElementType::SignedInteger { bytes: 4 } => whole!(i32),
        ElementType::SignedInteger { bytes: 2 } => whole!(i16),
        ElementType::SignedInteger { bytes: 1 } => whole!(i8),
        ElementType::UnsignedInteger { bytes: 8 } => whole!(u64),
        ElementType::UnsignedInteger { bytes: 4 } => whole!(u32),
        ElementType::UnsignedInteger { bytes: 2 } => whole!(u16),
        ElementType::UnsignedInteger { bytes: 1 } => whole!(u8),
        _ => return Ok(None),
    }))
}

/// One column.
fn column(object: &Bound<'_, PyAny>) -> PyResult<Cells> {
    if !object.is_instance_of::<PyString>()
        && let Ok(buffer) = PyUntypedBuffer::get(object)
    {
        if buffer.dimensions() != 1 {
            return Err(PyValueError::new_err(format!("expected one dimension, found {}", buffer.dimensions())));
        }
        if let Some(cells) = of_buffer(object.py(), &buffer)? {
            return Ok(cells);
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
    fn number(&mut self, number: f64) {
        match &mut self.texts {
            Some(texts) => texts.push(written(number)),
            None => self.numbers.push(number),
        }
    }

    fn whole(&mut self, value: i128) {
        match value.unsigned_abs() > WHOLE {
            true => self.text(&value.to_string()),
            false => self.number(value as f64),
        }
    }

    fn text(&mut self, text: &str) {
        let numbers = std::mem::take(&mut self.numbers);
        let texts = self.texts.get_or_insert_with(|| numbers.into_iter().map(written).collect());
        texts.push(text.to_string());
    }

    /// A time as ISO 8601 writes it, without zeros behind the last decimal.
    fn time(&mut self, text: &str) {
        let fraction = text.rsplit_once('.').filter(|(_, digits)| digits.bytes().all(|b| b.is_ascii_digit()));
        self.text(fraction.map_or(text, |_| text.trim_end_matches('0').trim_end_matches('.')));
    }

    /// A cell of Python.
    fn push(&mut self, cell: &Bound<'_, PyAny>) -> PyResult<()> {
        if let Ok(number) = cell.cast::<PyFloat>() {
            self.number(number.value());
        } else if let Ok(text) = cell.cast::<PyString>() {
            self.text(&text.to_string());
        } else if let Ok(truth) = cell.cast::<PyBool>() {
            self.number(f64::from(u8::from(truth.is_true())));
        } else if cell.is_none() || is_absent(cell) {
            self.number(f64::NAN);
        } else if let Ok(value) = cell.extract::<i64>() {
            self.whole(value.into());
        } else if cell.is_instance_of::<PyInt>() {
            self.text(&cell.str()?.to_string());
        } else if let Ok(number) = cell.extract::<f64>() {
            self.number(number);
        } else if let Ok(seconds) = cell.call_method0("total_seconds").and_then(|own| own.extract::<f64>()) {
            self.number(seconds);
        } else if let Ok(time) = cell.call_method0("isoformat") {
            self.time(&time.to_string());
        } else {
            self.text(&cell.str()?.to_string());
        }
        Ok(())
    }

    /// Cells of Arrow.
    fn array(&mut self, array: &dyn Array) {
        macro_rules! each {
            ($own:expr, $value:ident => $put:expr) => {
                for cell in $own.iter() {
                    match cell {
                        Some($value) => $put,
                        None => self.number(f64::NAN),
                    }
                }
            };
        }
        macro_rules! of {
            ($kind:ty, $value:ident => $put:expr) => {
                each!(array.as_primitive::<$kind>(), $value => $put)
            };
        }
        macro_rules! decimals {
            ($kind:ty) => {{
                let own = array.as_primitive::<$kind>();
                // one that no double reads is no number
                let number = |k: usize| own.is_valid(k).then(|| own.value_as_string(k).parse().ok()).flatten();
                (0..own.len()).for_each(|k| self.number(number(k).unwrap_or(f64::NAN)));
            }};
        }
        downcast_integer_array!(array => each!(array, value => self.whole(value.into())), kind => match kind {
            DataType::Float64 => of!(Float64Type, value => self.number(value)),
            DataType::Float32 => of!(Float32Type, value => self.number(value.into())),
            DataType::Float16 => of!(Float16Type, value => self.number(value.into())),
            DataType::Boolean => each!(array.as_boolean(), value => self.number(f64::from(u8::from(value)))),
            DataType::Utf8 => each!(array.as_string::<i32>(), text => self.text(text)),
            DataType::LargeUtf8 => each!(array.as_string::<i64>(), text => self.text(text)),
            DataType::Utf8View => each!(array.as_string_view(), text => self.text(text)),
            DataType::Decimal128(..) => decimals!(Decimal128Type),
            DataType::Decimal256(..) => decimals!(Decimal256Type),
            DataType::Duration(TimeUnit::Second) => of!(DurationSecondType, v => self.number(v as f64)),
            DataType::Duration(TimeUnit::Millisecond) => of!(DurationMillisecondType, v => self.number(v as f64 / 1e3)),
            DataType::Duration(TimeUnit::Microsecond) => of!(DurationMicrosecondType, v => self.number(v as f64 / 1e6)),
            DataType::Duration(TimeUnit::Nanosecond) => of!(DurationNanosecondType, v => self.number(v as f64 / 1e9)),
            DataType::Dictionary(..) => self.dictionary(array),
            kind => downcast_temporal_array!(array => for k in 0..array.len() {
                let time = match kind {
                    DataType::Date32 | DataType::Date64 => array.value_as_date(k).map(|day| format!("{day:?}")),
                    DataType::Time32(_) | DataType::Time64(_) => array.value_as_time(k).map(|time| format!("{time:?}")),
                    _ => array.value_as_datetime(k).map(|time| format!("{time:?}")),
                };
                self.time(&time.filter(|_| array.is_valid(k)).unwrap_or_default());
            },
            other => {
                // a column that nothing uses is no fault
                let named = format!("a value of the type {other}");
                (0..array.len()).for_each(|k| self.text(if array.is_valid(k) { &named } else { "" }));
            }),
        });
    }

    fn dictionary(&mut self, array: &dyn Array) {
        let Some(own) = array.as_any_dictionary_opt() else { return };
        let mut entries = Gathered::default();
        entries.array(own.values());
        // a dictionary without entries has no keys either
        let keys = if own.values().is_empty() { vec![0; array.len()] } else { own.normalized_keys() };
        let entries = entries.cells();
        for (k, key) in keys.into_iter().enumerate() {
            match &entries {
                _ if own.is_null(k) => self.number(f64::NAN),
                Cells::Numbers(all) => self.number(all.get(key).copied().unwrap_or(f64::NAN)),
                Cells::Texts(all) => self.text(all.get(key).map_or("", String::as_str)),
            }
        }
    }

    fn cells(self) -> Cells {
        self.texts.map_or(Cells::Numbers(self.numbers), Cells::Texts)
    }
}

/// Is it what pandas and numpy have for an absent value? Such a thing is not equal to itself, or does not know whether it is.
fn is_absent(cell: &Bound<'_, PyAny>) -> bool {
    !cell.eq(cell).unwrap_or_else(|_| cell.hasattr("__len__").unwrap_or(false))
}

fn written(number: f64) -> String {
    if number.is_nan() { String::new() } else { number.to_string() }
}

/// The columns of a stream of Arrow's PyCapsule interface.
fn of_stream(table: &Bound<'_, PyAny>) -> PyResult<Columns> {
    let capsule = table.call_method0("__arrow_c_stream__")?;
    let pointer = capsule.cast::<PyCapsule>()?.pointer_checked(Some(c"arrow_array_stream"))?;
    // SAFETY: the name of the capsule says what it points at; `from_raw` moves it out and leaves a released stream behind
    let reader = unsafe { RecordBatchStreamReader::from_raw(pointer.cast::<FFI_ArrowArrayStream>().as_ptr()) };
    let reader = reader.map_err(unread)?;
    let schema = reader.schema();
    let mut found: Vec<Gathered> = schema.fields().iter().map(|_| Gathered::default()).collect();
    for batch in reader {
        let batch = batch.map_err(unread)?;
        found.iter_mut().zip(batch.columns()).for_each(|(gathered, array)| gathered.array(array));
    }
    let titles = schema.fields().iter().map(|field| field.name().clone());
    Ok(titles.zip(found.into_iter().map(Gathered::cells)).collect())
}

fn unread(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(format!("the table cannot be read: {error}"))
}
