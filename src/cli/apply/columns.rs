//! A record corrected in blocks of columns, to CSV or Parquet. Cells of a table of text that stay are copied as they stand; whole numbers of 64 bits in Parquet keep their type and
//! all digits, other numbers are doubles (times in seconds), texts are texts.

use super::{BEYOND, Correction, Counts, Plan, Stream, plan, titles};
use crate::cli::rows::{Column, Columnar, Kind, numbers};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::number;
use crate::record::{As, Block, Record, UNREADABLE, Written, WrittenTimes, decimal};
use crate::units::Conversion;
use parquet::basic::{Compression, LogicalType, Repetition};
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use std::borrow::Cow;
use std::io::Write;

type Whole = Option<(i32, Option<LogicalType>)>;

/// An open record and how its columns feed the correction.
struct Source {
    record: Record,
    titles: Vec<String>,
    plan: Plan,
    /// What each column that stays is read as, and its decimal places and type where it has whole numbers of 64 bits.
    kept: Vec<(As, Whole)>,
    /// The columns that are read, each once.
    read: Vec<usize>,
    /// For each given input, how its column says times, as in the readings of a campaign.
    times: Vec<Times>,
}

/// How a column says times: since the first of them, where they are written or instants.
enum Times {
    /// As any number.
    Numbers,
    Instants(Option<f64>),
    Written(WrittenTimes),
}

impl Source {
    /// What is kept of a table of text is `written`, or else numbers and texts.
    fn open(correction: &Correction<'_>, open: &mut dyn FnMut() -> Result<Record>, written: bool) -> Result<Self> {
        let mut record = open()?;
        let titles: Vec<String> = record.columns().iter().map(|column| column.title.clone()).collect();
        let plan = plan(correction.arguments, correction.calibration, record.columns())
            .map_err(|error| error.at_line(record.title_line(), 0).in_file(record.name()))?;
        let of_times = |from: &Option<(usize, Conversion)>| match from {
            Some((k, _)) if record.is_text(*k) => Times::Written(WrittenTimes::default()),
            Some((k, _)) if record.is_of_times(*k) => Times::Instants(None),
            _ => Times::Numbers,
        };
        let times = plan.given.iter().map(of_times).collect();
        // texts are read as what is kept of them
        let given = plan.given.iter().flatten().map(|(column, _)| *column).filter(|k| !record.is_text(*k));
        let numbers = plan.sensors.iter().copied().chain(given);
        let mut wanted: Vec<(usize, As)> = Vec::new();
        for column in numbers {
            if !wanted.iter().any(|(other, _)| *other == column) {
                wanted.push((column, As::Number));
            }
        }
        let others: Vec<usize> =
            plan.kept.iter().copied().filter(|k| !wanted.iter().any(|(other, _)| other == k)).collect();
        let of_others = match written && record.is_of_text() {
            true => vec![As::Written; others.len()],
            false => kinds(&record, open, &others)?,
        };
        wanted.extend(others.into_iter().zip(of_others));
        let kind = |k: &usize| wanted.iter().find(|(other, _)| other == k).map_or(As::Number, |(_, kind)| *kind);
        let kept = |k: &usize| (kind(k), record.whole(*k).filter(|_| kind(k) == As::Written));
        let kept = plan.kept.iter().map(kept).collect();
        record.select(&wanted);
        let read = wanted.into_iter().map(|(column, _)| column).collect();
        Ok(Source { record, titles, plan, kept, read, times })
    }

    /// Titles of all columns that are written.
    fn header(&self, correction: &Correction<'_>) -> Vec<(String, (As, Whole))> {
        let kept = self.plan.kept.iter().filter_map(|k| self.titles.get(*k).cloned());
        let kept = kept.zip(self.kept.iter().cloned());
        kept.chain(titles(correction).into_iter().map(|title| (title, (As::Number, None)))).collect()
    }

    /// Correct block after block: the columns that stay, then the corrected ones.
    fn each(
        &mut self,
        correction: &Correction<'_>,
        counts: &mut Counts,
        mut take: impl FnMut(&[&[f64]], &[Vec<f64>], &Texts<'_>) -> Result<()>,
    ) -> Result<()> {
        let plan = &self.plan;
        counts.given = plan.given.iter().map(Option::is_some).collect();
        let calibration = correction.calibration;
        let ranges: Vec<f64> = calibration.solved().map(|input| BEYOND * calibration.range_of(input)).collect();
        counts.beyond.resize(ranges.len(), (0, 0.0));
        let (mut readings, mut given) = (vec![0.0; plan.sensors.len()], correction.corrector.fallbacks());
        let mut corrected: Vec<Vec<f64>> = titles(correction).iter().map(|_| Vec::new()).collect();
        let mut block = Block::default();
        while self.record.next(&mut block)? {
            corrected.iter_mut().for_each(Vec::clear);
            // every column of the plan is among those read
            let column =
                |k: usize| block.columns.at(self.read.iter().position(|other| *other == k).unwrap_or(usize::MAX));
            let sensors: Vec<&[f64]> = plan.sensors.iter().map(|k| column(*k)).collect();
            let kept: Vec<&[f64]> = plan.kept.iter().map(|k| column(*k)).collect();
            let texts = Texts { labels: self.record.labels(), written: &block.written };
            let mut inputs: Vec<Option<(Cow<'_, [f64]>, Conversion)>> = Vec::with_capacity(plan.given.len());
            for (from, times) in plan.given.iter().zip(&mut self.times) {
                let Some((k, conversion)) = *from else {
                    inputs.push(None);
                    continue;
                };
                let values = match times {
                    Times::Numbers => Cow::Borrowed(column(k)),
                    Times::Instants(first) => {
                        *first = first.or_else(|| column(k).iter().copied().find(|time| !time.is_nan()));
                        let first = first.unwrap_or(f64::NAN); // no time at all so far
                        Cow::Owned(column(k).iter().map(|time| time - first).collect())
                    }
                    Times::Written(clock) => {
                        let kind =
                            plan.kept.iter().zip(&self.kept).find(|(other, _)| **other == k).map(|(_, kind)| kind);
                        let seconds = |(row, number): (usize, &f64)| {
                            let text = kind.map_or(Cow::default(), |kind| texts.cell(kind, *number));
                            let text = String::from_utf8_lossy(&text);
                            match clock.since_first(&text) {
                                _ if text.trim().is_empty() => Ok(f64::NAN),
                                Some(time) => Ok(time),
                                None => Err(Malformed::new(
                                    Fault::Value,
                                    format!(
                                        "'{}' is neither a number nor a time",
                                        self.titles.get(k).map_or("", String::as_str)
                                    ),
                                )
                                .expected("a number, or a time such as 2026-11-20T09:14:03.25")
                                .found(format!("'{text}' in row {}", counts.rows + row as u64 + 1))
                                .in_file(self.record.name())),
                            }
                        };
                        Cow::Owned(column(k).iter().enumerate().map(seconds).collect::<Result<_>>()?)
                    }
                };
                inputs.push(Some((values, conversion)));
            }
            for row in 0..block.rows() {
                for ((to, column), conversion) in readings.iter_mut().zip(&sensors).zip(&plan.conversions) {
                    *to = conversion.map_or(column.at(row), |conversion| conversion.apply(column.at(row)));
                }
                for (value, from) in given.iter_mut().zip(&inputs) {
                    *value = from.as_ref().map_or(*value, |(column, conversion)| conversion.apply(column.at(row)));
                }
                let (values, converged) = correction.row(&readings, &given);
                counts.rows += 1;
                counts.failed += u64::from(!converged);
                for ((beyond, range), value) in counts.beyond.iter_mut().zip(&ranges).zip(&values) {
                    if value.abs() > *range {
                        *beyond = (beyond.0 + 1, if value.abs() > beyond.1.abs() { *value } else { beyond.1 });
                    }
                }
                corrected.iter_mut().zip(&values).for_each(|(to, value)| to.push(*value));
            }
            take(&kept, &corrected, &texts)?;
            self.record.forget_labels();
        }
        Ok(())
    }
}

/// What these columns hold: numbers, whole numbers of 64 bits, or texts, of a table of text by all of its rows.
fn kinds(record: &Record, open: &mut dyn FnMut() -> Result<Record>, columns: &[usize]) -> Result<Vec<As>> {
    // written times are texts, though they may be read as numbers
    let mut texts: Vec<bool> = columns.iter().map(|k| record.is_text(*k)).collect();
    if !columns.is_empty() && record.is_of_text() {
        let mut record = open()?;
        record.select(&columns.iter().map(|k| (*k, As::Cell)).collect::<Vec<_>>());
        let mut block = Block::default();
        while record.next(&mut block)? {
            for (text, column) in texts.iter_mut().zip(&block.columns) {
                *text |= column.iter().any(|v| v.to_bits() == UNREADABLE.to_bits());
            }
        }
    }
    let kind = |(k, text): (&usize, bool)| match record.whole(*k) {
        Some(_) => As::Written,
        None if text => As::Label,
        None => As::Number,
    };
    Ok(columns.iter().zip(texts).map(kind).collect())
}

/// The texts of a block.
struct Texts<'a> {
    labels: &'a [String],
    written: &'a Written,
}

impl Texts<'_> {
    /// A label by its number.
    fn label(&self, number: f64) -> &str {
        let place = number.is_finite().then_some(number::count(number));
        place.and_then(|k| self.labels.get(k)).map_or("", String::as_str)
    }

    /// What a cell that is kept is written as.
    fn cell(&self, (kind, whole): &(As, Whole), number: f64) -> Cow<'_, [u8]> {
        match (kind, whole) {
            (As::Written, _) if number.is_nan() => Cow::default(),
            (As::Written, Some((places, _))) if *places > 0 => Cow::Owned(self.pointed(number, *places)),
            (As::Written, _) => Cow::Borrowed(self.written.cell(number)),
            (As::Label, _) => Cow::Borrowed(self.label(number).as_bytes()),
            _ => Cow::Owned(cell(number)),
        }
    }

    /// Digits of a whole number.
    fn digits(&self, number: f64) -> &str {
        std::str::from_utf8(self.written.cell(number)).unwrap_or_default()
    }

    /// A whole number of the last decimal place, in the unit.
    fn pointed(&self, number: f64, places: i32) -> Vec<u8> {
        let text = self.digits(number).parse().ok().and_then(|value| decimal(value, places)).unwrap_or_default();
        text.trim_end_matches('0').trim_end_matches('.').as_bytes().to_vec()
    }

    /// A whole number as its 64 bits.
    fn bits(&self, number: f64) -> i64 {
        let digits = self.digits(number);
        digits.parse().or_else(|_| digits.parse().map(u64::cast_signed)).unwrap_or_default() // digits of one of both
    }
}

/// A number, or an empty cell where there is none.
fn cell(value: f64) -> Vec<u8> {
    if value.is_finite() { value.to_string().into_bytes() } else { Vec::new() }
}

/// The same with an exponent always, as no other program writes it: a file that ends in such numbers may be written anew.
fn marked(value: f64) -> Vec<u8> {
    if value.is_finite() { format!("{value:e}").into_bytes() } else { Vec::new() }
}

fn unwritten(error: &dyn std::fmt::Display) -> Malformed {
    Malformed::new(Fault::File, format!("the corrected record cannot be written: {error}")).expected("room to write to")
}

/// A record as CSV.
pub(super) fn to_text(
    correction: &Correction<'_>,
    record: Record,
    counts: &mut Counts,
    output: impl Write,
) -> Result<()> {
    let mut record = Some(record);
    let once = || Malformed::new(Fault::File, "the record can be read once only");
    let mut source = Source::open(correction, &mut || record.take().ok_or_else(once), true)?;
    let kinds = source.kept.clone();
    let titles: Vec<String> = source.header(correction).into_iter().map(|(title, _)| title).collect();
    let mut writer = csv::Writer::from_writer(std::io::BufWriter::with_capacity(1 << 16, output));
    // the titles go before the first row, or before the end, so that a fault in the first row finds nothing written
    let mut titles = Some(titles);
    source.each(correction, counts, |kept, corrected, texts| {
        titles.take().map_or(Ok(()), |titles| writer.write_record(titles)).map_err(|error| unwritten(&error))?;
        for row in 0..corrected.first().map_or(0, Vec::len) {
            let kept = kept.iter().zip(&kinds).map(|(column, kind)| texts.cell(kind, column.at(row)));
            let corrected = corrected.iter().map(|column| Cow::Owned(marked(column.at(row))));
            writer.write_record(kept.chain(corrected)).map_err(|error| unwritten(&error))?;
        }
        Ok(())
    })?;
    titles.map_or(Ok(()), |titles| writer.write_record(titles)).map_err(|error| unwritten(&error))?;
    writer.flush().map_err(|error| unwritten(&error))
}

/// A record as Parquet, a row group for each block.
pub(super) fn to_columns(
    correction: &Correction<'_>,
    open: &mut dyn FnMut() -> Result<Record>,
    counts: &mut Counts,
    stream: Stream,
) -> Result<Stream> {
    let mut source = Source::open(correction, open, false)?;
    let field = |(title, (kind, whole)): (String, (As, Whole))| {
        let logical = whole.and_then(|(_, logical)| logical);
        let kind = match kind {
            As::Label => Kind::Text,
            As::Written => Kind::Count,
            _ => Kind::Number,
        };
        (title, kind, Repetition::OPTIONAL, logical)
    };
    let failed = |error: ParquetError| unwritten(&error);
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY);
    let header = source.header(correction);
    let mut file = Columnar::begin(stream, "record", header.into_iter().map(field), properties).map_err(failed)?;
    let kinds = source.kept.clone();
    source.each(correction, counts, |kept, corrected, texts| {
        let columns = kept.iter().copied().chain(corrected.iter().map(Vec::as_slice)).enumerate();
        let columns = columns.map(|(k, column)| {
            let (cells, levels) = numbers(column.iter().copied());
            let cells = match (cells, kinds.get(k).map(|(kind, _)| kind)) {
                (Column::Numbers(labels), Some(As::Label)) => {
                    Column::Texts(labels.into_iter().map(|number| ByteArray::from(texts.label(number))).collect())
                }
                (Column::Numbers(places), Some(As::Written)) => {
                    Column::Counts(places.into_iter().map(|number| texts.bits(number)).collect())
                }
                (cells, _) => cells,
            };
            (cells, levels)
        });
        file.group(columns).map_err(failed)
    })?;
    file.finish().map_err(failed)
}
