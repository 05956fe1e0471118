//! A record in blocks of columns, from or to Parquet: numbers that stay are doubles (times in seconds), texts are texts.

use super::text::{cell, unwritten};
use super::{Correction, Counts, Plan, Stream, plan, titles};
use crate::cli::log;
use crate::elements::{Elements, Parts};
use crate::error::{Fault, Malformed, Result};
use crate::number;
use crate::record::{As, Block, Record, UNREADABLE};
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

/// An open record and how its columns feed the correction.
struct Source {
    record: Record,
    titles: Vec<String>,
    plan: Plan,
    /// Is each column that stays a text?
    texts: Vec<bool>,
}

impl Source {
    fn open(correction: &Correction<'_>) -> Result<Self> {
        let path = &correction.arguments.log;
        if path == Path::new("-") {
            return Err(Malformed::new(Fault::Value, "a stream of text cannot be written as Parquet")
                .expected("a record in a file, or --out with a name that ends in .csv"));
        }
        let mut record = log::open(path)?;
        let titles: Vec<String> = record.columns().iter().map(|column| column.title.clone()).collect();
        let columns = record.columns().to_vec();
        let plan = plan(correction.arguments, correction.calibration, &columns)
            .map_err(|error| error.at_line(1, 1).in_file(record.name()))?;
        let texts = texts(path, &plan.kept)?;
        let given = plan.given.iter().flatten().map(|(column, _)| (*column, As::Number));
        let mut wanted: Vec<(usize, As)> =
            plan.sensors.iter().map(|column| (*column, As::Number)).chain(given).collect();
        wanted.extend(plan.kept.iter().zip(&texts).map(|(k, text)| (*k, if *text { As::Label } else { As::Number })));
        record.select(&wanted);
        Ok(Source { record, titles, plan, texts })
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
        mut take: impl FnMut(&[Vec<f64>], &[Vec<f64>], &[String]) -> Result<()>,
    ) -> Result<Counts> {
        let plan = &self.plan;
        let mut counts = Counts { rows: 0, failed: 0, given: plan.given.iter().map(Option::is_some).collect() };
        let (mut readings, mut given) = (vec![0.0; plan.sensors.len()], correction.corrector.fallbacks());
        let mut corrected: Vec<Vec<f64>> = titles(correction).iter().map(|_| Vec::new()).collect();
        let mut block = Block::default();
        while self.record.next(&mut block)? {
            corrected.iter_mut().for_each(Vec::clear);
            let sensors = block.columns.part(..readings.len());
            let rest = block.columns.part(readings.len()..);
            // the record was opened with these columns: none is missing
            let (inputs, kept) = rest.split_at_checked(plan.given.iter().flatten().count()).unwrap_or((rest, &[]));
            for row in 0..block.rows() {
                let at = |column: &Vec<f64>| column.at(row);
                for ((to, column), conversion) in readings.iter_mut().zip(sensors).zip(&self.plan.conversions) {
                    *to = conversion.map_or(at(column), |conversion| conversion.apply(at(column)));
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
            take(kept, &corrected, self.record.labels())?;
        }
        Ok(counts)
    }
}

/// Which of these columns hold texts, by their first rows.
fn texts(path: &Path, kept: &[usize]) -> Result<Vec<bool>> {
    if kept.is_empty() {
        return Ok(Vec::new());
    }
    let mut texts = Vec::with_capacity(kept.len());
    match log::open(path)? {
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
pub(super) fn to_text(correction: &Correction<'_>, output: impl Write) -> Result<Counts> {
    let mut source = Source::open(correction)?;
    let texts = source.texts.clone();
    let mut writer = csv::Writer::from_writer(std::io::BufWriter::with_capacity(1 << 16, output));
    writer.write_record(source.header(correction).iter().map(|(title, _)| title)).map_err(|e| unwritten(&e))?;
    let counts = source.each(correction, |kept, corrected, labels| {
        for row in 0..corrected.first().map_or(0, Vec::len) {
            let at = |column: &Vec<f64>| column.at(row);
            for (column, text) in kept.iter().zip(&texts) {
                let own = at(column);
                match text {
                    true => writer.write_field(label(labels, own)),
                    false => writer.write_field(cell(own)),
                }
                .map_err(|e| unwritten(&e))?;
            }
            for column in corrected {
                writer.write_field(cell(at(column))).map_err(|e| unwritten(&e))?;
            }
            writer.write_record(None::<&[u8]>).map_err(|e| unwritten(&e))?;
        }
        Ok(())
    })?;
    writer.flush().map_err(|e| unwritten(&e))?;
    Ok(counts)
}

/// A record as Parquet, a row group for each block.
pub(super) fn to_columns(correction: &Correction<'_>, stream: Stream) -> Result<(Counts, Stream)> {
    let mut source = Source::open(correction)?;
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
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = SerializedFileWriter::new(stream, Arc::new(schema), Arc::new(properties)).map_err(failed)?;
    let texts = source.texts.clone();
    let counts = source.each(correction, |kept, corrected, labels| {
        group(&mut writer, &texts, kept, corrected, labels).map_err(failed)
    })?;
    Ok((counts, writer.into_inner().map_err(failed)?))
}

fn group(
    writer: &mut SerializedFileWriter<Stream>,
    texts: &[bool],
    kept: &[Vec<f64>],
    corrected: &[Vec<f64>],
    labels: &[String],
) -> std::result::Result<(), ParquetError> {
    let mut group = writer.next_row_group()?;
    for (k, column) in kept.iter().chain(corrected).enumerate() {
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
