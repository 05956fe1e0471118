//! Columns of a table under names of its own: which key each one is, and in which unit.
//!
//! A campaign's `"columns": { "theta_deg": "Winkel (rad)" }` says which column a key is found in. Where the title of a column ends in a unit
//! that the key's converts from, its numbers are converted; without a map, `V (mV)` is the sensor `V` as well. Of a column that the map names, the unit
//! may stand without brackets (`U_mV`, `Rate rpm`).

use super::Named;
use crate::bench::Bench;
use crate::error::{Fault, Malformed, Result};
use crate::record;
use crate::units::{self, Conversion, Unit};
use std::collections::HashSet;

/// A column as the readings have it: the key of a reading, and from the column's unit to the key's.
pub(super) type Column = (String, Option<Conversion>);

/// What each title of a table stands for; `others` are keys that are read beside sensors, joints and names of model lines.
///
/// Errors: a column that the map names and the table has not, a title that stands for two keys, two columns for one key, a unit that does not convert.
pub(super) fn columns(
    bench: &Bench,
    titles: &[record::Column],
    map: &Named<String>,
    others: &dyn Fn(&str) -> bool,
    file: &str,
) -> Result<Vec<Column>> {
    let fault = |fault, what: String| Malformed::new(fault, what).in_file(file);
    let stands_for = |wanted: &str, found: &record::Column| found.title == wanted || found.name == wanted;
    for (key, wanted) in &map.0 {
        let found = titles.iter().filter(|found| stands_for(wanted, found)).count();
        if found != 1 {
            let what = match found {
                0 => format!("there is no column '{wanted}', which \"columns\" gives for '{key}'"),
                _ => format!("several columns are called '{wanted}', which \"columns\" gives for '{key}'"),
            };
            return Err(fault(Fault::Missing, what)
                .expected("one of the titles of the table")
                .found(titles.iter().map(|found| format!("'{}'", found.title)).collect::<Vec<_>>().join(", ")));
        }
    }
    let used: HashSet<&str> = bench.sensors.iter().flat_map(|sensor| sensor.model.names()).collect();
    let is_read = |key: &str| {
        let kind = meaning(bench, key);
        used.contains(key)
            || matches!(kind, Meaning::Sensor(_) | Meaning::SensorU(_) | Meaning::Angle(_) | Meaning::Rate(_))
    };
    let wanted = |to: &str, unit: &str| Unit::parse(to).is_ok_and(|to| to.is_said_by(unit));
    let mut columns: Vec<Column> = Vec::with_capacity(titles.len());
    let mut seen: HashSet<String> = HashSet::new();
    for column in titles {
        let (found, name) = (column.title.as_str(), column.name.clone());
        let mut keys = map.0.iter().filter(|(_, wanted)| stands_for(wanted, column)).map(|(key, _)| key);
        let key = match (keys.next(), keys.next()) {
            (Some(first), Some(second)) => {
                return Err(fault(Fault::NameClash, format!("the column '{found}' is given for two keys"))
                    .expected("a different column for each key of \"columns\"")
                    .found(format!("'{first}' and '{second}'")));
            }
            (Some(key), None) => key.clone(),
            (None, _) if column.unit.is_some() && key_unit(bench, &name).is_some() => name,
            (None, _) => match column.quotient() {
                Some((symbol, unit)) if key_unit(bench, symbol).is_some_and(|to| wanted(&to, unit)) => symbol.into(),
                _ => found.to_string(),
            },
        };
        let conversion = match key_unit(bench, &key).map_or(Ok(None), |to| of_title(column, &key, &to)) {
            Ok(conversion) => conversion,
            // what nothing reads may be in any unit
            Err(_) if !is_read(&key) && !others(&key) && map.get(&key).is_none() => None,
            Err(error) => return Err(error.in_file(file)),
        };
        if !seen.insert(key.clone()) {
            return Err(fault(Fault::NameClash, format!("two columns are '{key}'"))
                .expected("one column for each key; \"columns\" of the campaign says which")
                .found(format!("'{found}' is the second")));
        }
        columns.push((key, conversion));
    }
    Ok(columns)
}

/// From the unit that the title of a column says to that of the key it is read as, wherever a record or a table is read; `None` where the numbers stay as they are.
///
/// Errors: those of [`from_title`].
pub(crate) fn of_title(column: &record::Column, key: &str, to: &str) -> Result<Option<Conversion>> {
    let unit = match Unit::parse(to) {
        // a title that is the key says no other unit than the key's
        Ok(wanted) if column.title != key => column.unit_for(Some(&wanted)),
        _ => column.unit.clone(),
    };
    let found = from_title(&format!("the column '{}'", column.title), unit.as_deref().unwrap_or_default(), to)?;
    // a difference of temperatures has no zero
    Ok(if key.ends_with("_u") { found.map(Conversion::of_differences) } else { found })
}

/// From the unit in a title to the one that is wanted; `None` where the numbers stay as they are: where one of the two is not said, too. Words in brackets that are no unit (`V (channel 1)`)
/// are a remark, unless one of them is a unit that would convert (`V (in mV)`): what is meant by it is not guessed.
///
/// Errors: a unit that is not known, one of another dimension.
pub(super) fn from_title(what: &str, from: &str, to: &str) -> Result<Option<Conversion>> {
    if from == to || from.is_empty() || to.is_empty() {
        return Ok(None);
    }
    let converts = |word: &str| match (Unit::parse(word), Unit::parse(to)) {
        (Ok(unit), Ok(wanted)) if !unit.dimension().is_number() => {
            unit.conversion_for(&wanted, what).is_ok_and(|unit| !unit.is_none())
        }
        _ => false,
    };
    if from.contains(char::is_whitespace) && Unit::parse(from).is_err() && !from.split_whitespace().any(converts) {
        return Ok(None);
    }
    let unknown = |unit: &str| {
        Malformed::new(Fault::Value, format!("{what} ends in '{from}', and '{unit}' is not a known unit"))
            .expected(format!(
                "a unit that converts to {to}, or a title without one where the numbers are in {to} (known are {})",
                units::names()
            ))
            .found(format!("'{from}'"))
    };
    let unit = Unit::parse(from).map_err(|_| unknown(from))?;
    let wanted = Unit::parse(to).map_err(|_| unknown(to))?;
    Ok(Some(unit.conversion_for(&wanted, what)?).filter(|conversion| !conversion.is_none()))
}

/// What a key of a reading means on this bench.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Meaning {
    Position,
    Samples,
    Sensor(usize),
    SensorU(usize),
    Angle(usize),
    Rate(usize),
    Turns(usize),
    Column,
}

impl Meaning {
    /// Is a number under it an input of that name?
    pub fn is_input(self) -> bool {
        matches!(self, Meaning::Column | Meaning::Angle(_) | Meaning::Rate(_) | Meaning::Turns(_))
    }
}

/// The meaning of a key of a reading.
pub(super) fn meaning(bench: &Bench, key: &str) -> Meaning {
    match key {
        "position" => return Meaning::Position,
        "n" => return Meaning::Samples,
        _ => {}
    }
    for (k, sensor) in bench.sensors.iter().enumerate() {
        match key.strip_prefix(sensor.id.as_str()) {
            Some("") => return Meaning::Sensor(k),
            Some("_u") => return Meaning::SensorU(k),
            _ => {}
        }
    }
    for (k, joint) in bench.joints().enumerate() {
        match key.strip_prefix(joint) {
            Some("_deg") => return Meaning::Angle(k),
            Some("_deg_s") => return Meaning::Rate(k),
            Some("_turns") => return Meaning::Turns(k),
            _ => {}
        }
    }
    Meaning::Column
}

/// The unit that a key of a reading has; `None` where it says nothing of one.
pub(crate) fn key_unit(bench: &Bench, key: &str) -> Option<String> {
    let unit = match meaning(bench, key) {
        Meaning::Angle(_) => Some("deg".to_string()),
        Meaning::Rate(_) => Some("deg/s".to_string()),
        Meaning::Sensor(k) | Meaning::SensorU(k) => bench.sensors.get(k).map(|sensor| sensor.unit.clone()),
        _ => units::of_column(key),
    };
    unit.filter(|unit| !unit.is_empty())
}
