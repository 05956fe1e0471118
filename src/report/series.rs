//! Time series of a mission as CSV or Parquet, row by row: memory does not grow with the mission.

use super::ARCSEC;
use crate::navigate::measured::CHANNEL_NAMES;
use crate::navigate::run::{NavigationError, Row, Scenario};
use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::io::Write;
use std::sync::Arc;

/// Names of the columns of numbers; `motion` and `scenario` stand before them.
pub const COLUMNS: [&str; 8] = {
    let [phi_e, phi_n, phi_u, v_e, v_n, p_e, p_n] = CHANNEL_NAMES;
    ["time_s", phi_e, phi_n, phi_u, v_e, v_n, p_e, p_n]
};

/// With its version, what a Parquet file names as the program that wrote it.
pub(crate) const WRITER: &str = "tumble ";

/// Rows of a Parquet row group.
const GROUP: usize = 1 << 16;

/// A time series in one of its two formats.
pub enum Series<W: Write + Send> {
    /// Text.
    Csv(Box<csv::Writer<W>>),
    /// Columns, compressed by their own encodings only.
    Parquet(Box<Columns<W>>),
}

/// A Parquet file in the making.
pub struct Columns<W: Write + Send> {
    file: SerializedFileWriter<W>,
    names: [Vec<ByteArray>; 2],
    numbers: [Vec<f64>; 8],
}

impl<W: Write + Send> Series<W> {
    /// A CSV file with its header.
    pub fn csv(to: W) -> std::io::Result<Self> {
        let mut writer = csv::Writer::from_writer(to);
        writer.write_record(["motion", "scenario"].iter().chain(&COLUMNS)).map_err(std::io::Error::other)?;
        Ok(Series::Csv(Box::new(writer)))
    }

    /// A Parquet file.
    pub fn parquet(to: W) -> std::io::Result<Self> {
        let name = |name: &str| {
            Type::primitive_type_builder(name, Physical::BYTE_ARRAY)
                .with_repetition(Repetition::REQUIRED)
                .with_converted_type(ConvertedType::UTF8)
                .build()
        };
        let number = |name: &str| {
            Type::primitive_type_builder(name, Physical::DOUBLE).with_repetition(Repetition::REQUIRED).build()
        };
        let build = || -> Result<_, ParquetError> {
            let mut fields = vec![Arc::new(name("motion")?), Arc::new(name("scenario")?)];
            for column in COLUMNS {
                fields.push(Arc::new(number(column)?));
            }
            let schema = Type::group_type_builder("navigation_errors").with_fields(fields).build()?;
            let properties = WriterProperties::builder().set_created_by(format!("{WRITER}{}", super::VERSION)).build();
            SerializedFileWriter::new(to, Arc::new(schema), Arc::new(properties))
        };
        let file = build().map_err(std::io::Error::other)?;
        Ok(Series::Parquet(Box::new(Columns { file, names: Default::default(), numbers: Default::default() })))
    }

    /// One instant of all scenarios.
    pub fn push(&mut self, motion: &str, scenarios: &[Scenario], row: &Row<'_>) -> std::io::Result<()> {
        for (scenario, error) in scenarios.iter().zip(row.errors) {
            let values = values(row.truth.time, error);
            match self {
                Series::Csv(writer) => {
                    let names = [motion.to_string(), scenario.id.clone()];
                    let numbers = values.iter().map(|value| format!("{value:.9e}"));
                    writer.write_record(names.into_iter().chain(numbers)).map_err(std::io::Error::other)?;
                }
                Series::Parquet(columns) => columns.push(motion, &scenario.id, values)?,
            }
        }
        Ok(())
    }

    /// Write what is left and give the file back.
    pub fn finish(self) -> std::io::Result<W> {
        match self {
            Series::Csv(writer) => writer.into_inner().map_err(|error| std::io::Error::other(error.to_string())),
            Series::Parquet(mut columns) => {
                columns.flush()?;
                columns.file.into_inner().map_err(std::io::Error::other)
            }
        }
    }
}

impl<W: Write + Send> Columns<W> {
    fn push(&mut self, motion: &str, scenario: &str, values: [f64; 8]) -> std::io::Result<()> {
        for (column, name) in self.names.iter_mut().zip([motion, scenario]) {
            column.push(ByteArray::from(name));
        }
        for (column, value) in self.numbers.iter_mut().zip(values) {
            column.push(value);
        }
        if self.names[0].len() < GROUP {
            return Ok(());
        }
        self.flush()
    }

    fn flush(&mut self) -> std::io::Result<()> {
        if self.names[0].is_empty() {
            return Ok(());
        }
        let mut write = || -> Result<(), ParquetError> {
            let mut group = self.file.next_row_group()?;
            for column in &self.names {
                if let Some(mut writer) = group.next_column()? {
                    writer.typed::<ByteArrayType>().write_batch(column, None, None)?;
                    writer.close()?;
                }
            }
            for column in &self.numbers {
                if let Some(mut writer) = group.next_column()? {
                    writer.typed::<DoubleType>().write_batch(column, None, None)?;
                    writer.close()?;
                }
            }
            group.close().map(|_| ())
        };
        write().map_err(std::io::Error::other)?;
        self.names.iter_mut().for_each(Vec::clear);
        self.numbers.iter_mut().for_each(Vec::clear);
        Ok(())
    }
}

fn values(time: f64, error: &NavigationError) -> [f64; 8] {
    let [e, n, u] = error.attitude.map(|phi| phi * ARCSEC);
    [time, e, n, u, error.velocity[0], error.velocity[1], error.position[0], error.position[1]]
}
