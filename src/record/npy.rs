//! Arrays of NumPy (`.npy`), of numbers: one or two dimensions, or fields with names. The layout is that of NEP 1.

use super::held::{Array, Held, tables};
use super::matlab::numbers;
use crate::error::{Fault, Malformed, Result};

/// Type, unit, size in bytes and byte order of a value.
struct Kind<'a> {
    /// As types of MATLAB's elements.
    number: u32,
    unit: Option<&'a str>,
    size: usize,
    big: bool,
}

/// Read the array.
///
/// Errors: a file that was cut off, values that are no numbers, more than two dimensions.
pub(super) fn open(name: &str, bytes: &[u8]) -> Result<Held> {
    let cut = || {
        Malformed::new(Fault::File, format!("'{name}' is a NumPy array that was cut off, or is damaged"))
            .expected("a head, and values up to the file's end")
            .in_file(name)
    };
    // version 1 has two bytes of length, the others four
    let (at, length) = match (bytes.get(6), bytes.get(8..12)) {
        (Some(1), Some([low, high, ..])) => (10, usize::from(u16::from_le_bytes([*low, *high]))),
        (Some(_), Some([a, b, c, d])) => (12, u32::from_le_bytes([*a, *b, *c, *d]) as usize),
        _ => return Err(cut()),
    };
    let head = bytes.get(at..).and_then(|rest| rest.get(..length)).ok_or_else(cut)?;
    let head = std::str::from_utf8(head).map_err(|_| cut())?;
    let data = bytes.get(at + length..).unwrap_or_default(); // the head ends within the file
    let unread = || {
        Malformed::new(Fault::Value, format!("'{name}' is a NumPy array that is not read"))
            .expected("numbers in one or two dimensions, or in fields of one dimension; or the array as CSV or Parquet")
            .found(head.trim().to_string())
            .in_file(name)
    };
    let after = |key: &str| head.split_once(&format!("'{key}':")).map(|(_, rest)| rest.trim_start());
    let shape = after("shape").and_then(|rest| rest.strip_prefix('(')?.split_once(')')).ok_or_else(unread)?.0;
    let sides = shape.split(',').map(str::trim).filter(|side| !side.is_empty()).map(|side| side.parse::<usize>());
    let sides: Vec<usize> = sides.collect::<std::result::Result<_, _>>().map_err(|_| unread())?;
    let by_columns = after("fortran_order").is_some_and(|rest| rest.starts_with("True"));
    let kinds = after("descr").and_then(fields).ok_or_else(unread)?;
    let (rows, width) = match (sides.as_slice(), kinds.as_slice()) {
        ([rows], _) => (*rows, 1),
        ([rows, width], [_]) => (*rows, *width),
        _ => return Err(unread()),
    };
    let stride: usize = kinds.iter().map(|(_, kind)| kind.size).sum();
    let size = rows.checked_mul(width).and_then(|count| count.checked_mul(stride)).ok_or_else(cut)?;
    let data = data.get(..size).ok_or_else(|| cut().found(format!("{} bytes of {size}", data.len())))?;
    let (mut arrays, mut from) = (Vec::new(), 0);
    for (field, kind) in kinds {
        let own: Vec<u8> = data
            .chunks_exact(stride.max(1))
            .filter_map(|row| row.get(from..from + kind.size))
            .flatten()
            .copied()
            .collect();
        from += kind.size;
        let mut values = numbers(kind.number, &own, kind.big).ok_or_else(unread)?;
        if kind.unit.is_some() {
            // not a time
            values.iter_mut().filter(|value| **value == i64::MIN as f64).for_each(|value| *value = f64::NAN);
        }
        if width > 1 && !by_columns {
            values =
                (0..width).flat_map(|k| values.iter().skip(k).step_by(width).copied().collect::<Vec<_>>()).collect();
        }
        arrays.push(Array {
            name: field,
            unit: kind.unit.map(str::to_string),
            shape: (rows, width),
            values,
            ..Array::default()
        });
    }
    Held::choose(name, "array", tables(arrays), None)
}

/// Names and types of `'<f8'` or `[('t', '<f8'), ('V', '<f4')]`; `None` for others.
fn fields(descr: &str) -> Option<Vec<(String, Kind<'_>)>> {
    let Some(list) = descr.strip_prefix('[') else {
        return Some(vec![("c".into(), kind(descr.strip_prefix('\'')?.split_once('\'')?.0)?)]);
    };
    let (mut found, mut rest) = (Vec::new(), list.split_once(']')?.0);
    while let Some((_, field)) = rest.split_once('(') {
        let (own, behind) = field.split_once(')')?;
        let parts: Vec<&str> = own.split('\'').collect();
        let [_, name, _, code, end] = parts.as_slice() else { return None };
        // a third entry is a shape
        if !end.trim().is_empty() {
            return None;
        }
        found.push(((*name).to_string(), kind(code)?));
        rest = behind;
    }
    Some(found)
}

/// A type such as `<f8`, `|i1` or `<M8[ns]`; `None` for what is no number.
fn kind(code: &str) -> Option<Kind<'_>> {
    let (order, code) = code.split_at_checked(1)?;
    let (code, unit) = code.split_once('[').map_or((code, None), |(code, unit)| (code, unit.strip_suffix(']')));
    let (number, size) = match code {
        "i1" => (1, 1),
        "u1" | "b1" => (2, 1),
        "i2" => (3, 2),
        "u2" => (4, 2),
        "i4" => (5, 4),
        "u4" => (6, 4),
        "f4" => (7, 4),
        "f8" => (9, 8),
        "i8" | "M8" | "m8" => (12, 8),
        "u8" => (13, 8),
        _ => return None,
    };
    Some(Kind { number, unit, size, big: order == ">" })
}
