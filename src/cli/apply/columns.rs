//! A record in blocks of columns, from or to Parquet: numbers that stay are doubles (times in seconds), texts are texts.

use super::text::{Table, cell, unwritten};
use super::{Correction, Counts, Plan, Stream, plan, titles};
use crate::elements::Elements;
use crate::error::Result;
use crate::number;
use crate::record::{As, Block, Record, UNREADABLE};
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::io::Write;
use std::sync::Arc;

/// An open record and how its columns feed the correction.
struct Source {
    record: Record,
    titles: Vec<String>,
    plan: Plan,
    /// Is each column that stays a text?
    texts: Vec<bool>,
    /// The columns that are read, each once.
    read: Vec<usize>,
}

impl Source {
    fn open(correction: &Correction<'_>, open: &dyn Fn() -> Result<Record>) -> Result<Self> {
        let mut record = open()?;
        let titles: Vec<String> = record.columns().iter().map(|column| column.title.clone()).collect();
        let columns = record.columns().to_vec();
        let plan = plan(correction.arguments, correction.calibration, &columns)
            .map_err(|error| error.at_line(1, 1).in_file(record.name()))?;
        let numbers = plan.sensors.iter().copied().chain(plan.given.iter().flatten().map(|(column, _)| *column));
        let mut wanted: Vec<(usize, As)> = Vec::new();
        for column in numbers {
            if !wanted.iter().any(|(own, _)| *own == column) {
                wanted.push((column, As::Number));
            }
        }
        let others: Vec<usize> =
            plan.kept.iter().copied().filter(|k| !wanted.iter().any(|(own, _)| own == k)).collect();
        let of_others = texts(open, &others)?;
        wanted.extend(others.iter().zip(&of_others).map(|(k, text)| (*k, if *text { As::Label } else { As::Number })));
        let is_text = |k: &usize| others.iter().zip(&of_others).any(|(own, text)| own == k && *text);
        let texts = plan.kept.iter().map(is_text).collect();
        record.select(&wanted);
        Ok(Source { record, titles, plan, texts, read: wanted.into_iter().map(|(column, _)| column).collect() })
    }

    /// Titles of all columns that are written.
    fn header(&self, correction: &Correction<'_>) -> Vec<(String, bool)> {
        let kept = self.plan.kept.iter().filter_map(|k| self.titles.get(*k).cloned());
        let kept = kept.zip(self.texts.iter().copied());
        kept.chain(titles(correction).into_iter().map(|title| (title, false))).collect()
    }

    /// Correct block after block: the columns that stay, then the corrected ones.
    fn each(
        &mut self,
        correction: &Correction<'_>,
        counts: &mut Counts,
        mut take: impl FnMut(&[&[f64]], &[Vec<f64>], &[String]) -> Result<()>,
    ) -> Result<()> {
        let plan = &self.plan;
        counts.given = plan.given.iter().map(Option::is_some).collect();
        let (mut readings, mut given) = (vec![0.0; plan.sensors.len()], correction.corrector.fallbacks());
        let mut corrected: Vec<Vec<f64>> = titles(correction).iter().map(|_| Vec::new()).collect();
        let mut block = Block::default();
        while self.record.next(&mut block)? {
            corrected.iter_mut().for_each(Vec::clear);
            // every column of the plan is among those read
            let column = |k: usize| block.columns.at(self.read.iter().position(|own| *own == k).unwrap_or(usize::MAX));
            let sensors: Vec<&[f64]> = plan.sensors.iter().map(|k| column(*k)).collect();
            let inputs: Vec<Option<(&[f64], f64)>> =
                plan.given.iter().map(|from| from.map(|(k, factor)| (column(k), factor))).collect();
            let kept: Vec<&[f64]> = plan.kept.iter().map(|k| column(*k)).collect();
            for row in 0..block.rows() {
                for ((to, column), conversion) in readings.iter_mut().zip(&sensors).zip(&plan.conversions) {
                    *to = conversion.map_or(column.at(row), |conversion| conversion.apply(column.at(row)));
                }
                let mut columns = inputs.iter();
                for (value, (_, conversion)) in
                    given.iter_mut().zip(&plan.given).filter_map(|(v, from)| Some((v, from.as_ref()?)))
                {
                    *value = conversion.apply(columns.next().map_or(f64::NAN, at));
                }
                let (values, converged) = correction.row(&readings, &given);
                counts.rows += 1;
                counts.failed += u64::from(!converged);
                corrected.iter_mut().zip(&values).for_each(|(to, value)| to.push(*value));
            }
            take(&kept, &corrected, self.record.labels())?;
        }
        Ok(())
    }
}

/// Which of these columns hold texts, by their first rows.
fn texts(open: &dyn Fn() -> Result<Record>, kept: &[usize]) -> Result<Vec<bool>> {
    if kept.is_empty() {
        return Ok(Vec::new());
    }
    let mut texts = Vec::with_capacity(kept.len());
    match open()? {
        Record::Columnar(table) => {
            texts.extend(kept.iter().map(|k| table.is_text(*k)));
        }
        Record::Held(_) => texts.resize(kept.len(), false),
        mut record @ Record::Delimited(_) => {
            record.select(&kept.iter().map(|k| (*k, As::Cell)).collect::<Vec<_>>());
            let mut block = Block::default();
            texts.resize(kept.len(), false);
            while record.next(&mut block)? {
                for (text, column) in texts.iter_mut().zip(&block.columns) {
                    *text |= column.iter().any(|v| v.to_bits() == UNREADABLE.to_bits());
                }
            }
        }
    }
    Ok(texts)
}

/// A label by its number.
fn label(labels: &[String], number: f64) -> &str {
    let place = number.is_finite().then_some(number::count(number));
    place.and_then(|k| labels.get(k)).map_or("", String::as_str)
}

/// A record as CSV.
pub(super) fn to_text(
    correction: &Correction<'_>,
    open: &dyn Fn() -> Result<Record>,
    counts: &mut Counts,
    output: impl Write,
) -> Result<()> {
    let mut source = Source::open(correction, open)?;
    let texts = source.texts.clone();
    let titles: Vec<String> = source.header(correction).into_iter().map(|(title, _)| title).collect();
    let mut writer = Table::new(titles, output);
    source.each(correction, counts, |kept, corrected, labels| {
        for row in 0..corrected.first().map_or(0, Vec::len) {
            let kept = kept.iter().zip(&texts).map(|(column, text)| match text {
                true => label(labels, column.at(row)).to_string(),
                false => cell(column.at(row)),
            });
            writer.row(kept.chain(corrected.iter().map(|column| cell(column.at(row)))))?;
        }
        Ok(())
    })?;
    writer.finish()
}

/// A record as Parquet, a row group for each block.
pub(super) fn to_columns(
    correction: &Correction<'_>,
    open: &dyn Fn() -> Result<Record>,
    counts: &mut Counts,
    stream: Stream,
) -> Result<Stream> {
    let mut source = Source::open(correction, open)?;
    let header = source.header(correction);
    let failed = |error: ParquetError| unwritten(&error);
    let fields = header
        .iter()
        .map(|(title, text)| {
            let physical = if *text { Physical::BYTE_ARRAY } else { Physical::DOUBLE };
            let builder = Type::primitive_type_builder(title, physical).with_repetition(Repetition::OPTIONAL);
            let builder = if *text { builder.with_logical_type(Some(LogicalType::String)) } else { builder };
            builder.build().map(Arc::new)
        })
        .collect::<std::result::Result<_, _>>()
        .map_err(failed)?;
    let schema = Type::group_type_builder("record").with_fields(fields).build().map_err(failed)?;
    let written_by = format!("tumble {}", crate::report::VERSION);
    let properties =
        WriterProperties::builder().set_compression(Compression::SNAPPY).set_created_by(written_by).build();
    let mut writer = SerializedFileWriter::new(stream, Arc::new(schema), Arc::new(properties)).map_err(failed)?;
    let texts = source.texts.clone();
    source.each(correction, counts, |kept, corrected, labels| {
        group(&mut writer, &texts, kept, corrected, labels).map_err(failed)
    })?;
    writer.into_inner().map_err(failed)
}

fn group(
    writer: &mut SerializedFileWriter<Stream>,
    texts: &[bool],
    kept: &[&[f64]],
    corrected: &[Vec<f64>],
    labels: &[String],
) -> std::result::Result<(), ParquetError> {
    let mut group = writer.next_row_group()?;
    for (k, column) in kept.iter().copied().chain(corrected.iter().map(Vec::as_slice)).enumerate() {
        let Some(mut to) = group.next_column()? else { break };
        let levels: Vec<i16> = column.iter().map(|v| i16::from(!v.is_nan())).collect();
        let values = column.iter().filter(|v| !v.is_nan());
        if texts.get(k).copied().unwrap_or(false) {
            let values: Vec<ByteArray> = values.map(|v| ByteArray::from(label(labels, *v))).collect();
            to.typed::<ByteArrayType>().write_batch(&values, Some(&levels), None)?;
        } else {
            let values: Vec<f64> = values.copied().collect();
            to.typed::<DoubleType>().write_batch(&values, Some(&levels), None)?;
        }
        to.close()?;
    }
    group.close()?;
    Ok(())
}
