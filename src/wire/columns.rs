//! Columns of a table under names of its own: which key each one is, and in which unit.
//!
//! A campaign's `"columns": { "theta_deg": "Winkel (rad)" }` says which column a key is found in. Where the title of a column ends in a unit
//! that the key's converts from, its numbers are converted; without a map, `V (mV)` is the sensor `V` as well.

use super::Named;
use crate::bench::Bench;
use crate::error::{Fault, Malformed, Result};
use crate::record::title;
use crate::units::{Conversion, Unit};

/// A column as the readings have it.
pub(super) struct Column {
    /// The key of a reading.
    pub key: String,
    /// From the column's unit to the key's.
    pub conversion: Option<Conversion>,
}

/// What each title of a table stands for.
///
/// Errors: a column that the map names and the table has not, a title that stands for two keys, two columns for one key, a unit that does not convert.
pub(super) fn columns(bench: &Bench, titles: &[&str], map: &Named<String>, file: &str) -> Result<Vec<Column>> {
    let fault = |fault, what: String| Malformed::new(fault, what).at_line(1, 1).in_file(file);
    let stands_for = |wanted: &str, found: &str| found == wanted || title(found).0 == wanted;
    for (key, wanted) in &map.0 {
        let found = titles.iter().filter(|found| stands_for(wanted, found)).count();
        if found != 1 {
            let what = match found {
                0 => format!("there is no column '{wanted}', which \"columns\" gives for '{key}'"),
                _ => format!("several columns are called '{wanted}', which \"columns\" gives for '{key}'"),
            };
            return Err(fault(Fault::Missing, what)
                .expected("one of the titles in the file's first line")
                .found(titles.iter().map(|found| format!("'{found}'")).collect::<Vec<_>>().join(", ")));
        }
    }
    let mut columns: Vec<Column> = Vec::with_capacity(titles.len());
    for found in titles {
        let mut keys = map.0.iter().filter(|(_, wanted)| stands_for(wanted, found)).map(|(key, _)| key);
        let (name, unit) = title(found);
        let key = match (keys.next(), keys.next()) {
            (Some(first), Some(second)) => {
                return Err(fault(Fault::NameClash, format!("the column '{found}' stands for two keys"))
                    .expected("a column of its own for each key of \"columns\"")
                    .found(format!("'{first}' and '{second}'")));
            }
            (Some(key), None) => key.clone(),
            (None, _) if unit.is_some() && key_unit(bench, &name).is_some() => name,
            (None, _) => found.to_string(),
        };
        let conversion = match (unit, key_unit(bench, &key)) {
            (Some(from), Some(to)) => {
                from_title(&format!("the column '{found}'"), &from, &to).map_err(|e| e.at_line(1, 1).in_file(file))?
            }
            _ => None,
        };
        if columns.iter().any(|other| other.key == key) {
            return Err(fault(Fault::NameClash, format!("two columns are '{key}'"))
                .expected("one column for each key; \"columns\" of the campaign says which")
                .found(format!("'{found}' is the second")));
        }
        columns.push(Column { key, conversion });
    }
    Ok(columns)
}

/// From the unit in a title to the one that is wanted; `None` where the numbers stay as they are. Words in brackets that are no unit (`V (channel 1)`)
/// are a remark.
///
/// Errors: a unit that is not known, one of another dimension.
pub(crate) fn from_title(what: &str, from: &str, to: &str) -> Result<Option<Conversion>> {
    if from == to || from.is_empty() || from.contains(char::is_whitespace) && Unit::parse(from).is_err() {
        return Ok(None);
    }
    let unknown = |unit: &str| {
        Malformed::new(Fault::Value, format!("{what} ends in '{from}', and '{unit}' is no unit that is known"))
            .expected(format!("a unit that converts to {to}, or a title without one where the numbers are in {to}"))
            .found(format!("'{from}'"))
    };
    let own = Unit::parse(from).map_err(|_| unknown(from))?;
    let wanted = Unit::parse(to).map_err(|_| unknown(to))?;
    Ok(Some(own.conversion_for(&wanted, what)?).filter(|conversion| !conversion.is_none()))
}

/// The unit that a key of a reading has; `None` where it says nothing of one.
pub(super) fn key_unit(bench: &Bench, key: &str) -> Option<String> {
    let joint = |suffix: &str| key.strip_suffix(suffix).is_some_and(|name| bench.joints().any(|joint| joint == name));
    let sensor = |id: &str| bench.sensors.iter().find(|sensor| sensor.id == id).map(|sensor| sensor.unit.clone());
    let text = if joint("_deg_s") {
        "deg/s".to_string()
    } else if joint("_deg") {
        "deg".to_string()
    } else {
        sensor(key).or_else(|| key.strip_suffix("_u").and_then(sensor))?
    };
    Some(text).filter(|text| !text.is_empty())
}
