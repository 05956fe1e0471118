//! Reduced readings put into the schedule that they were taken for.

use super::readings_file::{self, Cell, ReadingFile};
use super::{BenchRef, CampaignFile, Fetch, ReadingsRef, Source, kind, locate, parse};
use crate::algebra::{Scratch, Tape};
use crate::bench::Bench;
use crate::error::{Fault, Malformed, Result};

/// A reading as a reduction gives it.
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedReading {
    /// The segment's label.
    pub position: String,
    /// Time of its middle, s.
    pub time_s: f64,
    /// Column, mean and standard uncertainty.
    pub values: Vec<(String, f64, f64)>,
}

/// A schedule with its lists expanded, and the bench that it is for.
#[derive(Debug, Clone)]
pub struct Schedule {
    file: CampaignFile,
    bench: Bench,
    rows: Vec<ReadingFile>,
}

/// Read a schedule for reduced readings.
///
/// Errors as [`super::read_campaign`]; readings that stand in a file of their own.
pub fn read_schedule(source: &Source, fetch: Fetch<'_>) -> Result<Schedule> {
    let file: CampaignFile = parse(source).map_err(|error| kind::no_campaign(source).unwrap_or(error))?;
    let located = |error: Malformed| locate::in_source(error, source);
    let bench = match &file.bench {
        BenchRef::Inline(bench) => bench.as_ref().clone().into_bench().map_err(|e| located(e.under("bench")))?,
        BenchRef::Named(name) => super::campaign_file::named_bench(name, fetch).map_err(located)?,
    };
    let ReadingsRef::Inline(list) = &file.readings else {
        return Err(located(
            Malformed::new(Fault::Value, "the schedule's readings stand in another file")
                .expected("the positions in the schedule itself")
                .at_path("readings"),
        ));
    };
    let mut rows = Vec::new();
    for (k, row) in list.iter().enumerate() {
        readings_file::expand(&bench, row.clone(), &format!("readings[{k}]"), &mut rows).map_err(located)?;
    }
    Ok(Schedule { bench, rows: rows.into_iter().map(|(_, row)| row).collect(), file })
}

impl Schedule {
    /// The names that the bench reads from a reading: sensors, and what stands in their model lines.
    pub fn wanted(&self) -> Vec<String> {
        let sensors = self.bench.sensors.iter().map(|s| s.id.clone());
        let names = self.bench.sensors.iter().flat_map(|s| s.model.names().into_iter().map(str::to_string));
        sensors.chain(names).collect()
    }

    /// For each segment, the place of its row: by label where every label is a position, else in order, or one row for all.
    ///
    /// Errors: another number of segments than of rows, none of which is a pattern for all.
    pub fn pair(&self, labels: &[String]) -> Result<Vec<usize>> {
        let text = |cell: &Cell| match cell {
            Cell::Text(text) => text.clone(),
            Cell::Number(number) => number.to_string(),
            _ => String::new(),
        };
        let place = |label: &String| {
            self.rows.iter().position(|row| row.get("position").is_some_and(|cell| text(cell) == *label))
        };
        if self.rows.len() > 1
            && let Some(places) = labels.iter().map(place).collect::<Option<Vec<usize>>>()
            && places.len() <= self.rows.len()
        {
            return Ok(places);
        }
        match self.rows.len() {
            1 => Ok(vec![0; labels.len()]),
            n if n == labels.len() => Ok((0..n).collect()),
            n => Err(Malformed::new(Fault::Value, format!("the schedule has {n} positions, the record {} segments", labels.len()))
                .expected("as many segments as positions, in the same order; or segments labelled as the positions are; or one row that stands for all")
                .found(format!("segments {}", labels.join(", ")))),
        }
    }

    /// Duration of a turn of the joint that turns in a row, s.
    pub fn turn_s(&self, place: usize) -> Option<f64> {
        let row = self.rows.get(place)?;
        self.bench.joints().find_map(|joint| match row.get(&format!("{joint}_deg_s")) {
            Some(Cell::Number(rate)) if *rate != 0.0 => Some(360.0 / rate.abs()),
            _ => None,
        })
    }

    /// The campaign: each reading in the row it belongs to.
    ///
    /// A sensor whose value the schedule states and whose model line holds reduced columns (the norm of the specific force) gets the uncertainty that those
    /// columns bring, to first order at the schedule's start values.
    pub fn with(mut self, readings: &[ReducedReading], places: &[usize]) -> CampaignFile {
        let mut rows = Vec::new();
        for (reading, place) in readings.iter().zip(places) {
            let Some(mut row) = self.rows.get(*place).cloned() else { continue };
            let mut set = |key: &str, cell: Cell| match row.0.iter_mut().find(|(own, _)| own == key) {
                Some((_, old)) => *old = cell,
                None => row.0.push((key.to_string(), cell)),
            };
            if self.rows.len() == 1 || self.rows.get(*place).is_some_and(|row| row.get("position").is_none()) {
                set("position", Cell::Text(reading.position.clone()));
            }
            for (name, mean, u) in &reading.values {
                set(name, Cell::Number(*mean));
                if *u > 0.0 {
                    set(&format!("{name}_u"), Cell::Number(*u));
                }
            }
            set("time_s", Cell::Number(reading.time_s));
            for sensor in &self.bench.sensors {
                let stated = matches!(row.get(&sensor.id), Some(Cell::Number(_)));
                let reduced = reading.values.iter().any(|(name, ..)| *name == sensor.id);
                if stated
                    && !reduced
                    && let Some(u) = self.brought(&sensor.model, reading)
                {
                    row.0.push((format!("{}_u", sensor.id), Cell::Number(u)));
                }
            }
            rows.push(row);
        }
        self.file.readings = ReadingsRef::Inline(rows);
        self.file
    }

    /// What the uncertainties of reduced columns bring to a model line.
    fn brought(&self, model: &crate::algebra::Expression, reading: &ReducedReading) -> Option<f64> {
        let names = model.names();
        let of_reading = |name: &str| reading.values.iter().find(|(own, ..)| own == name);
        let inputs: Vec<f64> = names
            .iter()
            .map(|name| {
                let start = || self.file.estimate.get(name).and_then(|e| e.start.or(e.prior));
                let known = || self.file.known.get(name).map(|k| k.value);
                let asked = self.file.estimate.get(name).map(|_| 0.0);
                of_reading(name).map(|(_, mean, _)| *mean).or_else(known).or_else(start).or(asked)
            })
            .collect::<Option<_>>()?;
        let tape = Tape::compile(model, &names).ok()?;
        let mut gradient = vec![0.0; names.len()];
        tape.gradient(&inputs, &mut Scratch::default(), &mut gradient);
        let square: f64 =
            names.iter().zip(gradient).filter_map(|(name, g)| Some((g * of_reading(name)?.2).powi(2))).sum();
        Some(square.sqrt()).filter(|u| *u > 0.0 && u.is_finite())
    }
}
