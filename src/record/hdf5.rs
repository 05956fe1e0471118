//! HDF5 files, and MATLAB files of level 7.3, which are HDF5: numeric datasets, also of compounds, in groups.

use super::guard::guarded;
use super::held::{Array, Held, tables};
use crate::error::{Fault, Malformed, Result};
use hdf5_pure::{DType, Dataset, Error, File, Group};
use std::path::Path;

/// Bytes that deflate makes of one at most (zlib: 1032), and what is let pass of any file: nothing larger is read.
const MOST_PACKED: u64 = 1100;
const SLACK: u64 = 1 << 20;
/// Groups inside each other.
const DEEPEST: usize = 32;

/// Read the table that is meant.
///
/// Errors: a file that was cut off or is none, and those of choosing a table.
pub(super) fn open(name: &str, path: &Path, table: Option<&str>) -> Result<Held> {
    let broken = |error: &dyn std::fmt::Display| {
        Malformed::new(Fault::File, format!("'{name}' cannot be read as HDF5"))
            .expected("a whole file; this one may have been cut off, or is still being written")
            .found(error.to_string())
            .in_file(name)
    };
    let read = || -> std::result::Result<Vec<Array>, Error> {
        let file = File::open_streaming(path)?;
        let mut arrays = Vec::new();
        group(&file.root(), "", 0, std::fs::metadata(path).map_or(0, |there| there.len()), &mut arrays)?;
        Ok(arrays)
    };
    let gave_up = || broken(&"its structure is damaged");
    let arrays = guarded(read).ok_or_else(gave_up)?.map_err(|error: Error| broken(&error))?;
    Held::choose(name, "dataset or group", tables(arrays), table)
}

fn group(
    from: &Group,
    path: &str,
    depth: usize,
    bytes: u64,
    arrays: &mut Vec<Array>,
) -> std::result::Result<(), Error> {
    for name in from.datasets()? {
        dataset(&from.dataset(&name)?, path, &name, bytes, arrays)?;
    }
    // MATLAB keeps the contents of cells in a group of this name
    for name in from.groups()?.into_iter().filter(|name| name != "#refs#" && depth < DEEPEST) {
        let inside = if path.is_empty() { name.clone() } else { format!("{path}/{name}") };
        group(&from.group(&name)?, &inside, depth + 1, bytes, arrays)?;
    }
    Ok(())
}

fn dataset(
    from: &Dataset,
    path: &str,
    name: &str,
    bytes: u64,
    arrays: &mut Vec<Array>,
) -> std::result::Result<(), Error> {
    let shape = from.shape()?;
    let sides: Vec<usize> = shape.iter().filter_map(|side| usize::try_from(*side).ok()).collect();
    let attributes = from.attrs()?;
    let text = |key: &str| {
        let named = attributes.iter().find(|(name, _)| name.eq_ignore_ascii_case(key));
        named.and_then(|(_, value)| value.as_str()).map(str::to_string)
    };
    // characters are numbers there, too
    if text("MATLAB_class").is_some_and(|class| class == "char" || class == "cell") {
        return Ok(());
    }
    let claims = |shape: &[u64]| shape.iter().fold(8_u64, |all, side| all.saturating_mul(*side));
    let claimed = claims(&shape).max(claims(&from.chunk_shape()?.unwrap_or_default()));
    if claimed > bytes.saturating_mul(MOST_PACKED).saturating_add(SLACK) {
        return Err(Error::Shape(format!(
            "the dataset '{name}' says that it has {claimed} bytes, more than the file can hold"
        )));
    }
    // a list of pieces that cannot be listed is followed by their reader, piece by piece
    let pieces = if from.is_chunked() { from.chunks().unwrap_or_default() } else { Vec::new() };
    if pieces.iter().any(|piece| piece.address.saturating_add(piece.storage_size) > bytes) {
        return Err(Error::Shape(format!("a piece of the dataset '{name}' reaches beyond the end of the file")));
    }
    let unit = text("units").or_else(|| text("unit"));
    let kind = from.dtype()?;
    if let DType::Compound(members) = &kind {
        return match sides.as_slice() {
            [rows] => compound(from, members, *rows, path, name, arrays),
            _ => Ok(()),
        };
    }
    let numeric = decoder(&kind, false).is_some();
    let (rows, count) = match sides.as_slice() {
        [rows] => (*rows, 1),
        [rows, count] => (*rows, *count),
        _ => return Ok(()),
    };
    if !numeric || rows * count == 0 {
        return Ok(());
    }
    // stored row by row, which is column by column of the transposed array
    let mut values = from.read_f64()?;
    unpack(&mut values, |key| {
        let value = attributes.get(key)?;
        value.as_f64().or_else(|| value.as_i64().map(|whole| whole as f64))
    });
    arrays.push(Array { group: path.into(), name: name.into(), unit, shape: (count, rows), values });
    Ok(())
}

/// Numbers that are packed after the conventions of netCDF (CF 1.11, sections 2.5.1 and 8.1): what is not there has a value of its own, and the others are `packed * scale_factor + add_offset`.
fn unpack(values: &mut [f64], attribute: impl Fn(&str) -> Option<f64>) {
    let absent: Vec<f64> = ["_FillValue", "missing_value"].into_iter().filter_map(&attribute).collect();
    let (scale, offset) = (attribute("scale_factor").unwrap_or(1.0), attribute("add_offset").unwrap_or(0.0));
    if absent.is_empty() && scale == 1.0 && offset == 0.0 {
        return;
    }
    for value in values {
        *value = if absent.contains(value) { f64::NAN } else { *value * scale + offset };
    }
}

/// A dataset of records: a separate table, with a column for each numeric member.
fn compound(
    from: &Dataset,
    members: &[(String, DType)],
    rows: usize,
    path: &str,
    name: &str,
    arrays: &mut Vec<Array>,
) -> std::result::Result<(), Error> {
    use hdf5_pure::{Datatype, DatatypeByteOrder};
    let Datatype::Compound { size, members: places } = from.datatype()? else { return Ok(()) };
    let (size, raw) = (size as usize, from.read_raw()?);
    let group = if path.is_empty() { name.to_string() } else { format!("{path}/{name}") };
    for place in &places {
        let Some((_, kind)) = members.iter().find(|(member, _)| *member == place.name) else { continue };
        let big = match &place.datatype {
            Datatype::FixedPoint { byte_order, .. } | Datatype::FloatingPoint { byte_order, .. } => {
                matches!(byte_order, DatatypeByteOrder::BigEndian)
            }
            _ => continue,
        };
        let Some(decode) = decoder(kind, big) else { continue };
        let offset = crate::number::index(place.byte_offset);
        let values: Vec<f64> =
            raw.chunks_exact(size.max(1)).map(|row| row.get(offset..).and_then(&decode).unwrap_or(f64::NAN)).collect();
        if values.len() == rows {
            let (name, unit) = (place.name.clone(), None);
            arrays.push(Array { group: group.clone(), name, unit, shape: (rows, 1), values });
        }
    }
    Ok(())
}

/// A number at the start of some bytes.
fn decoder(kind: &DType, big: bool) -> Option<Box<dyn Fn(&[u8]) -> Option<f64>>> {
    macro_rules! of {
        ($type:ty) => {
            Box::new(move |bytes: &[u8]| {
                let word = bytes.get(..size_of::<$type>())?.try_into().ok()?;
                Some((if big { <$type>::from_be_bytes(word) } else { <$type>::from_le_bytes(word) }) as f64)
            })
        };
    }
    Some(match kind {
        DType::F32 => of!(f32),
        DType::F64 => of!(f64),
        DType::I8 => of!(i8),
        DType::I16 => of!(i16),
        DType::I32 => of!(i32),
        DType::I64 => of!(i64),
        DType::U8 => of!(u8),
        DType::U16 => of!(u16),
        DType::U32 => of!(u32),
        DType::U64 => of!(u64),
        _ => return None,
    })
}
