//! What the columns of a table are on a bench: by their names, else by the only unit that fits, else as a person says.

use super::answers::{Answers, pair};
use crate::bench::Bench;
use crate::campaign::is_axis_input;
use crate::cli::show_error;
use crate::error::{Fault, Malformed, Result};
use crate::record::{Column, find, listed, times_of};
use crate::units::{self, Unit};
use crate::wire::{Cell, ReadingFile, key_unit};
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

const TEMPERATURE: &str = "temperature_c";

/// Every key that a reading on this bench may have and a model line can use.
fn keys(bench: &Bench) -> Vec<String> {
    let mut keys: Vec<String> = vec!["position".into(), "n".into(), "time_s".into()];
    keys.extend(bench.joints().flat_map(|joint| ["_deg", "_deg_s", "_turns", "_u"].map(|end| format!("{joint}{end}"))));
    for sensor in &bench.sensors {
        keys.extend([sensor.id.clone(), format!("{}_u", sensor.id)]);
        let names = sensor.model.names().into_iter();
        let names = names.filter(|name| !is_axis_input(bench, name) && bench.joints().all(|joint| joint != *name));
        keys.extend(names.map(str::to_string));
    }
    // no model line need have it for `diagnose` to find what goes with it
    if !keys.iter().any(|key| key == TEMPERATURE) {
        keys.push(TEMPERATURE.into());
    }
    keys
}

/// Is it a name that any column may have (`day`, `pressure_hpa`), and no state of a joint that the bench has not?
fn is_other(key: &str) -> bool {
    let is_name = key.starts_with(char::is_alphabetic) && key.chars().all(|c| c.is_alphanumeric() || c == '_');
    is_name && !["_deg", "_deg_s", "_turns", "_u"].iter().any(|end| key.ends_with(end))
}

/// Is it the state of a joint, or the u of a sensor?
fn is_state(bench: &Bench, key: &str) -> bool {
    bench.is_of_joint(key)
        || key.strip_suffix("_u").is_some_and(|name| bench.sensors.iter().any(|sensor| sensor.id == name))
}

/// The key that each column is thought to be, without asking.
pub(super) fn proposed(bench: &Bench, columns: &[Column]) -> Vec<Option<String>> {
    let keys = keys(bench);
    let alike = |a: &str, b: &str| a.eq_ignore_ascii_case(b);
    let converts = |column: &Column, unit: &str| {
        let said = |wanted: &Unit| column.unit_for(Some(wanted)).is_some_and(|unit| wanted.is_said_by(&unit));
        Unit::parse(unit).is_ok_and(|wanted| said(&wanted))
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
    // the column that a record would take for its clock
    if !found.iter().flatten().any(|key| key == "time_s")
        && let Some(k) = times_of(columns)
        && let Some(slot @ None) = found.get_mut(k)
    {
        *slot = Some("time_s".into());
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

/// A key that readings on this bench may have.
///
/// Errors: any other text.
fn key(bench: &Bench, text: &str) -> Result<String> {
    let keys = keys(bench);
    // any other column that readings are to have
    match keys.iter().any(|key| key == text) || is_other(text) {
        true => Ok(text.to_string()),
        false => Err(Malformed::new(Fault::UnknownName, format!("readings on this bench have no '{text}'"))
            .expected(format!("one of {}", keys.join(", ")))),
    }
}

/// What each column is, of those that are not `taken` otherwise; `whole` says whether the table must have all that a reading needs.
///
/// Errors: a title that the table has not, a key that the bench has not or that two columns have; what a reading lacks.
pub(super) fn mapped(
    bench: &Bench,
    (table, columns): (&Path, &[Column]),
    given: &[String],
    answers: &Answers,
    (taken, whole): (&str, bool),
) -> Result<Mapped> {
    let mut found = proposed(bench, columns);
    let mut said: Vec<usize> = find(columns, taken).into_iter().collect();
    // what it says is no input then
    said.iter().for_each(|k| give(&mut found, *k, None));
    for text in given {
        let (name, title) = pair(text)?;
        let (name, at) = (key(bench, &name)?, column(columns, &title)?);
        if said.iter().any(|k| found.get(*k).is_some_and(|slot| slot.as_deref() == Some(&name))) {
            return Err(clash(&name));
        }
        said.push(at);
        give(&mut found, at, Some(name));
    }
    let known = keys(bench).join(", ");
    let open: Vec<usize> = (0..columns.len()).filter(|k| !said.contains(k)).collect();
    loop {
        let mut answered = said.clone();
        for (k, column) in columns.iter().enumerate().filter(|(k, _)| answers.asks && open.contains(k)) {
            let question = format!("column '{}' is one of {known}; empty: as proposed, -: none", column.title);
            let proposal = found.get(k).cloned().flatten();
            let said =
                answers.one(None, ("--columns", &question), Some(proposal.as_deref().unwrap_or("-")), |text| {
                    if text == "-" {
                        return Ok(None);
                    }
                    let name = key(bench, text)?;
                    let is_given = |k: &usize| found.get(*k).is_some_and(|slot| slot.as_deref() == Some(&name));
                    if answered.iter().any(is_given) { Err(clash(&name)) } else { Ok(Some(name)) }
                })?;
            answered.push(k);
            give(&mut found, k, said);
        }
        let keys: Vec<String> = found.iter().flatten().cloned().collect();
        let lacks = if whole { complete(bench, &keys, &[], table, columns) } else { Ok(()) };
        match lacks {
            // a person may answer once more
            Err(error) if answers.asks && !open.is_empty() => show_error::show(&error),
            Err(error) => return Err(error),
            Ok(()) => break,
        }
    }
    let of = |(column, key): (&Column, &Option<String>)| Some((key.clone()?, column.title.clone()));
    let pairs: Vec<(String, String)> = columns.iter().zip(&found).filter_map(of).collect();
    let keys: Vec<String> = pairs.iter().map(|(key, _)| key.clone()).collect();
    let renamed = pairs.into_iter().filter(|(key, title)| key != title).collect();
    Ok(Mapped { keys, renamed, used: found.iter().map(Option::is_some).collect() })
}

/// `KEY=TITLE` as they were given between commas: what has no '=' belongs to the title before it, in which there is a comma.
pub(super) fn whole_titles(given: &[String]) -> Vec<String> {
    let mut whole: Vec<String> = Vec::new();
    for part in given {
        match whole.last_mut().filter(|_| !part.contains('=')) {
            Some(last) => *last = format!("{last},{part}"),
            None => whole.push(part.clone()),
        }
    }
    whole
}

/// Columns whose titles do not say in which unit they are, with the unit that is taken.
pub(super) fn unsaid_units(bench: &Bench, keyed: &[(&str, &Column)]) -> Vec<String> {
    let unsaid = |(key, column): &(&str, &Column)| {
        let unit = key_unit(bench, key)?;
        let says = Unit::parse(&unit).is_ok_and(|wanted| column.unit_for(Some(&wanted)).is_some());
        (*key != column.title && !says).then(|| format!("'{}' is taken in {unit}", column.title))
    };
    keyed.iter().filter_map(unsaid).collect()
}

/// The place of a column.
///
/// Errors: a title that the table has not.
pub(super) fn column(columns: &[Column], title: &str) -> Result<usize> {
    find(columns, title).ok_or_else(|| {
        Malformed::new(Fault::UnknownName, format!("the table has no column '{title}'"))
            .expected(format!("one of {}", listed(columns)))
    })
}

/// A column is this key, and no other is.
fn give(found: &mut [Option<String>], at: usize, key: Option<String>) {
    found.iter_mut().filter(|slot| key.is_some() && **slot == key).for_each(|slot| *slot = None);
    found.get_mut(at).into_iter().for_each(|slot| slot.clone_from(&key));
}

fn clash(key: &str) -> Malformed {
    Malformed::new(Fault::NameClash, format!("two columns are '{key}'"))
        .expected("one column for each key: --columns KEY=TITLE")
}

/// Positions of a record, with the keys that the table lacks.
///
/// Errors: a key that the bench has not, a value that is no number; what a reading lacks.
pub(super) fn positions(
    bench: &Bench,
    given: &[String],
    answers: &Answers,
    complete: impl Fn(&[ReadingFile]) -> Result<()>,
) -> Result<Vec<ReadingFile>> {
    let question = "positions in the order taken, or one for all, as KEY=VALUE,KEY=VALUE";
    let read = |text: &str| {
        let cells = text.split(',').map(|part| {
            let (name, value) = pair(part)?;
            let name = key(bench, &name)?;
            let cell = match value.parse() {
                _ if name == "position" => Cell::Text(value),
                Ok(number) => Cell::Number(number),
                Err(_) => {
                    return Err(Malformed::new(Fault::Value, format!("{name} is not a number"))
                        .expected("a number with a decimal point")
                        .found(format!("'{value}'")));
                }
            };
            Ok((name, cell))
        });
        Ok(crate::wire::Named(cells.collect::<Result<Vec<_>>>()?))
    };
    loop {
        let positions = answers.several(given, question, read)?;
        match complete(&positions) {
            Err(error) if answers.asks && given.is_empty() => show_error::show(&error),
            done => return done.map(|()| positions),
        }
    }
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
    // of two thermometers no one is taken unasked
    for key in bench.sensors.iter().flat_map(|sensor| sensor.model.names()).filter(|key| !has(key)) {
        let Some(wanted) = units::of_column(key).and_then(|unit| Unit::parse(&unit).ok()) else { continue };
        let could_be = |column: &&Column| column.unit.as_deref().is_some_and(|unit| wanted.is_said_by(unit));
        if columns.iter().filter(could_be).count() > 1 {
            return missing(
                format!("'{key}' of a model line, for which several columns are possible"),
                format!("--columns {key}=TITLE"),
            );
        }
    }
    if !bench.sensors.iter().any(|sensor| has(&sensor.id)) {
        let ids: Vec<String> = bench.sensors.iter().map(|sensor| format!("{}=TITLE", sensor.id)).collect();
        return missing("a sensor of this bench".into(), format!("--columns {}", ids.join(",")));
    }
    Ok(())
}
