//! Which column of a record has its times: one that is called so; else one whose name or unit speaks of time and whose values rise; else the first whose values rise in
//! even steps. Of a column that has no name of a time it is said why it was taken.

use super::clock::{Clock, behind, seconds, speaks_of_time};
use super::{Column, Record, listed};
use crate::error::{Fault, Malformed, Result};
use crate::number;

/// Names under which a column of times is found, in this order and in either case, alone and with a unit behind: `time_ms`.
const TIMES: [&str; 13] = [
    "time",
    "t",
    "timestamp",
    "zeit",
    "datetime",
    "date time",
    "date_time",
    "date/time",
    "elapsed time",
    "elapsed",
    "seconds",
    "stamp",
    "时间",
];

/// So many of the first values are looked at. A choice: several times the steps that show a clock, and few to read.
pub(crate) const FIRST: usize = 64;
/// Steps that show that values rise evenly: of values in any order as many rise with a probability of 1/11! = 3e-8.
const ENOUGH: usize = 10;

/// The column that has the name of a time, where no one says which it is.
pub(crate) fn times_of(columns: &[Column]) -> Option<usize> {
    let rank = |column: &Column| {
        let bare = behind(&column.name).and_then(|unit| column.name.strip_suffix(unit)?.strip_suffix('_'));
        let name = bare.unwrap_or(&column.name);
        // T is a temperature
        let alike = |known: &&str| *known == name || (known.chars().count() > 1 && *known == name.to_lowercase());
        let place = TIMES.iter().position(&alike)?;
        // one that says its unit comes first
        Some((place, bare.is_none() && column.unit.is_none()))
    };
    let ranked = columns.iter().enumerate().filter_map(|(k, column)| Some((rank(column)?, k)));
    ranked.min().map(|(_, k)| k)
}

/// Steps between the first values: forward ones, those that stay, those back; what is absent is none.
fn steps(values: &[f64]) -> Option<(Vec<f64>, usize, usize)> {
    let all: Vec<f64> = values.iter().zip(values.iter().skip(1)).map(|(a, b)| b - a).collect();
    let of = |sign: fn(&f64) -> bool| all.iter().filter(|step| sign(step)).count();
    let (equal, back) = (of(|step| *step == 0.0), of(|step| *step < 0.0));
    all.iter().all(|step| step.is_finite()).then(|| {
        let forward = all.iter().copied().filter(|step| *step > 0.0).collect();
        (forward, equal, back)
    })
}

/// Do values rise, one clock that is set back and rows that share a time aside?
fn rises(values: &[f64]) -> bool {
    steps(values).is_some_and(|(forward, equal, back)| forward.len() > equal && back <= 1)
}

/// The step of values that rise evenly, gaps now and again aside; `None` for others.
pub(crate) fn even(values: &[f64]) -> Option<f64> {
    let (forward, equal, back) = steps(values)?;
    let step = number::median(&mut forward.clone()).filter(|_| equal + back == 0 && forward.len() >= ENOUGH)?;
    // a quarter either way, as of times that are rounded or late, and of ten steps nine: choices that let a gap now and again be
    let alike = forward.iter().filter(|own| (**own - step).abs() <= 0.25 * step).count();
    (10 * alike >= 9 * forward.len()).then_some(step)
}

/// The column of times of a record in which none is called so, and why it is that.
fn likely(record: &Record) -> Option<(usize, String)> {
    let columns = || record.columns().iter().enumerate();
    let is_time = |column: &Column| column.unit.as_deref().and_then(seconds).is_some();
    let speaks = |column: &Column| is_time(column) || speaks_of_time(&column.name);
    let of_no_other = |column: &Column| column.unit.is_none() || is_time(column);
    // of texts those are in seconds that are written times
    let is_written = |k: usize, column: &Column| record.is_text(k) && column.unit.as_deref() == Some("s");
    let named = columns().find(|(k, column)| {
        let fits = speaks(column) && of_no_other(column);
        fits && (is_written(*k, column) || (!record.is_text(*k) && rises(&record.first_values(*k))))
    });
    if let Some((k, column)) = named {
        let how = if is_written(k, column) { "its cells are times" } else { "its values rise" };
        return Some((k, format!("'{}' is taken as the column of times: {how}", column.title)));
    }
    // numbers of rows may stand before them
    let is_count = |k: usize| {
        steps(&record.first_values(k))
            .is_some_and(|(own, equal, back)| equal + back == 0 && own.iter().all(|step| *step == 1.0))
    };
    let (k, column) = columns().find(|(k, _)| !is_count(*k))?;
    let has_unit = column.unit.is_some() || crate::units::of_column(&column.name).is_some();
    let step = if has_unit || record.is_text(k) { None } else { even(&record.first_values(k)) }?;
    Some((k, format!("'{}' is taken as the column of times: its values rise in even steps of {step:.6}", column.title)))
}

/// The column of times, where no one says which it is; and why, where its name does not say it.
fn found(record: &Record) -> Option<(usize, Option<String>)> {
    let named = times_of(record.columns()).map(|column| (column, None));
    named.or_else(|| likely(record).map(|(column, why)| (column, Some(why))))
}

/// Where the times of samples come from.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ClockFrom {
    /// The column of times; by default one that is called `time_s`, `time`, `t` or `timestamp`, or whose values rise as times do.
    pub time: Option<String>,
    /// Samples a second, where there is none.
    pub rate: Option<f64>,
}

impl ClockFrom {
    /// The column of times, if there is one.
    ///
    /// Errors: `UnknownName` where the record has not the one that is named.
    pub fn column(&self, record: &Record) -> Result<Option<usize>> {
        match (&self.time, self.rate) {
            (Some(name), _) => record.find(name).map(Some),
            (None, Some(_)) => Ok(None),
            (None, None) => Ok(found(record).map(|(column, _)| column)),
        }
    }

    /// The column that would be that of times, where the clock does not use it: it is no sensor.
    pub(crate) fn unused(&self, record: &Record) -> Option<usize> {
        self.rate.and_then(|_| found(record)).map(|(column, _)| column)
    }

    /// Why the column is taken as that of times, where it has no name of one.
    pub(crate) fn taken(&self, record: &Record) -> Option<String> {
        if self.time.is_none() && self.rate.is_none() { found(record)?.1 } else { None }
    }

    /// The clock itself; `column` as [`ClockFrom::column`] gives it.
    ///
    /// Errors: neither a column nor a rate, a unit that is none of time.
    pub fn ticks(&self, record: &Record, column: Option<usize>) -> Result<Clock> {
        match (column.and_then(|k| record.columns().get(k)), self.rate) {
            (Some(column), _) => Ok(Clock::column(column, record.name())?.with_notes(self.taken(record))),
            (None, Some(rate)) => {
                let column = self.unused(record).and_then(|k| record.columns().get(k));
                Clock::rate(rate, column.map_or("", |column| &column.name), record.name())
            }
            (None, None) => Err(Malformed::new(Fault::Missing, "the record has no column of times")
                .expected("a sampling rate (--rate HZ, \"rate_hz\"), or the column's name (--time COLUMN, \"time\")")
                .found(format!("columns {}", listed(record.columns())))
                .in_file(record.name())),
        }
    }
}
