//! What the columns of a table are on a bench: by their names, else by the only unit that fits, else as a person says.

use super::answers::{Answers, pair};
use crate::bench::Bench;
use crate::campaign::is_axis_input;
use crate::error::{Fault, Malformed, Result};
use crate::record::{Column, find, listed};
use crate::units::{self, Unit};
use crate::wire::{Cell, ReadingFile};
use std::path::Path;

/// Which keys the table has.
pub(super) struct Mapped {
    /// The key of each column that has one.
    pub keys: Vec<String>,
    /// Keys with titles, where the title is not the key.
    pub renamed: Vec<(String, String)>,
    /// Is each column of the table one of these?
    pub used: Vec<bool>,
}

/// Every key that a reading on this bench may have and a model line can use.
fn keys(bench: &Bench) -> Vec<String> {
    let mut keys: Vec<String> = vec!["position".into(), "n".into(), "time_s".into()];
    keys.extend(bench.joints().flat_map(|joint| ["_deg", "_deg_s", "_turns"].map(|end| format!("{joint}{end}"))));
    for sensor in &bench.sensors {
        keys.extend([sensor.id.clone(), format!("{}_u", sensor.id)]);
        let names = sensor.model.names().into_iter();
        let names = names.filter(|name| !is_axis_input(bench, name) && bench.joints().all(|joint| joint != *name));
        keys.extend(names.map(str::to_string));
    }
    keys
}

/// Is it the state of a joint, or the u of a sensor?
fn is_state(bench: &Bench, key: &str) -> bool {
    let joint = |end: &str| key.strip_suffix(end).is_some_and(|name| bench.joints().any(|joint| joint == name));
    ["_deg", "_deg_s", "_turns"].into_iter().any(joint)
        || key.strip_suffix("_u").is_some_and(|name| bench.sensors.iter().any(|sensor| sensor.id == name))
}

/// The key that each column is thought to be, without asking.
pub(super) fn proposed(bench: &Bench, columns: &[Column]) -> Vec<Option<String>> {
    let keys = keys(bench);
    let alike = |a: &str, b: &str| a.eq_ignore_ascii_case(b);
    let converts = |column: &Column, unit: &str| {
        Unit::parse(unit).is_ok_and(|wanted| {
            let unit = column.unit_for(&wanted).and_then(|unit| Unit::parse(&unit).ok());
            unit.is_some_and(|unit| unit.conversion(&wanted).is_some())
        })
    };
    let state = |joint: &str, column: &Column| {
        [("deg/s", "_deg_s"), ("deg", "_deg")]
            .into_iter()
            .find(|(unit, _)| converts(column, unit))
            .map(|(_, end)| format!("{joint}{end}"))
    };
    let mut found: Vec<Option<String>> = columns
        .iter()
        .map(|column| {
            let same = |key: &&String| **key == column.title || **key == column.name;
            let named = keys.iter().find(same).or_else(|| keys.iter().find(|key| alike(key, &column.name))).cloned();
            named.or_else(|| bench.joints().find(|joint| alike(joint, &column.name)).and_then(|j| state(j, column)))
        })
        .collect();
    // one that is alone in its dimension, on both sides
    let joints: Vec<&str> = bench.joints().collect();
    let states = match joints.as_slice() {
        [joint] => vec![(format!("{joint}_deg_s"), "deg/s"), (format!("{joint}_deg"), "deg")],
        _ => Vec::new(),
    };
    let sensors = bench.sensors.iter().map(|sensor| (sensor.id.clone(), sensor.unit.clone()));
    let states = states.into_iter().map(|(key, unit)| (key, unit.to_string()));
    // what a model line reads beside them, and whose name has a unit (`temperature_c`)
    let is_sensor = |key: &str| bench.sensors.iter().any(|sensor| sensor.id == key);
    let read = keys.iter().filter(|key| key.as_str() != "time_s" && !is_sensor(key) && !is_state(bench, key));
    let read = read.filter_map(|key| Some((key.clone(), units::of_column(key)?)));
    let wanted: Vec<(String, String)> = states.chain(sensors).chain(read).collect();
    for (key, unit) in wanted.iter().filter(|(_, unit)| !unit.is_empty()) {
        let open =
            found.iter().zip(columns).enumerate().filter(|(_, (key, column))| key.is_none() && converts(column, unit));
        let fits: Vec<usize> = open.map(|(k, _)| k).collect();
        let rivals = wanted.iter().filter(|(other, its)| other != key && its == unit).count();
        if let ([k], 0, false) = (fits.as_slice(), rivals, found.iter().flatten().any(|other| other == key))
            && let Some(place) = found.get_mut(*k)
        {
            *place = Some(key.clone());
        }
    }
    // what two columns could be is neither
    let all: Vec<String> = found.iter().flatten().cloned().collect();
    for key_found in &mut found {
        if key_found.as_ref().is_some_and(|key| all.iter().filter(|other| *other == key).count() > 1) {
            *key_found = None;
        }
    }
    found
}

/// What each column is.
///
/// Errors: a title that the table has not, a key for two columns.
pub(super) fn mapped(bench: &Bench, columns: &[Column], given: &[String], answers: &Answers) -> Result<Mapped> {
    let mut found = proposed(bench, columns);
    let mut said = Vec::new();
    for text in given {
        let (key, title) = pair(text)?;
        let at = find(columns, &title).ok_or_else(|| {
            Malformed::new(Fault::UnknownName, format!("the table has no column '{title}'"))
                .expected(format!("one of {}", listed(columns)))
        })?;
        said.push(at);
        found.iter_mut().filter(|slot| slot.as_deref() == Some(&key)).for_each(|slot| *slot = None);
        found.get_mut(at).into_iter().for_each(|slot| *slot = Some(key.clone()));
    }
    let known = keys(bench).join(", ");
    for (k, (column, slot)) in columns.iter().zip(&mut found).enumerate() {
        if answers.asks && !said.contains(&k) {
            let question = format!("column '{}' is one of {known}; empty: as proposed, -: none", column.title);
            let said = answers.one(None, ("--columns", &question), Some(slot.as_deref().unwrap_or("-")), |text| {
                Ok(Some(text.to_string()).filter(|text| text != "-"))
            })?;
            *slot = said;
        }
    }
    let of = |(column, key): (&Column, &Option<String>)| Some((key.clone()?, column.title.clone()));
    let pairs: Vec<(String, String)> = columns.iter().zip(&found).filter_map(of).collect();
    let keys: Vec<String> = pairs.iter().map(|(key, _)| key.clone()).collect();
    if let Some(key) = keys.iter().find(|key| keys.iter().filter(|other| other == key).count() > 1) {
        return Err(Malformed::new(Fault::NameClash, format!("two columns are '{key}'"))
            .expected("one column for each key: --columns KEY=TITLE"));
    }
    let renamed = pairs.into_iter().filter(|(key, title)| key != title).collect();
    Ok(Mapped { keys, renamed, used: found.iter().map(Option::is_some).collect() })
}

pub(super) fn positions(given: &[String], answers: &Answers) -> Result<Vec<ReadingFile>> {
    let question = ("--position", "positions in the order taken, or one for all, as KEY=VALUE,KEY=VALUE");
    answers.several(given, question, |text| {
        let cells = text.split(',').map(|part| {
            let (key, value) = pair(part)?;
            let number = value.parse().ok().filter(|_| key != "position");
            Ok((key, number.map_or(Cell::Text(value), Cell::Number)))
        });
        Ok(crate::wire::Named(cells.collect::<Result<Vec<_>>>()?))
    })
}

/// Has every reading a value, and every joint a state?
///
/// Errors: what is missing, with the option that says where it is.
pub(super) fn complete(
    bench: &Bench,
    keys: &[String],
    positions: &[ReadingFile],
    table: &Path,
    columns: &[Column],
) -> Result<()> {
    let has = |key: &str| {
        keys.iter().any(|other| other == key)
            || (!positions.is_empty() && positions.iter().all(|row| row.get(key).is_some()))
    };
    let missing = |what: String, options: String| {
        Err(Malformed::new(Fault::Missing, format!("no column of '{}' is {what}", table.display()))
            .expected(options)
            .found(listed(columns)))
    };
    if let Some(joint) = bench.joints().find(|joint| !has(&format!("{joint}_deg")) && !has(&format!("{joint}_deg_s"))) {
        let expected = format!("--columns {joint}_deg=TITLE, or {joint}_deg_s=TITLE where it turns");
        return missing(format!("the angle or the rate of the joint '{joint}'"), expected);
    }
    if !bench.sensors.iter().any(|sensor| has(&sensor.id)) {
        let ids: Vec<String> = bench.sensors.iter().map(|sensor| format!("{}=TITLE", sensor.id)).collect();
        return missing("a sensor of this bench".into(), format!("--columns {}", ids.join(",")));
    }
    Ok(())
}
