//! Reduced readings put into the schedule that they were taken for.

use super::campaign_file::{CampaignFile, KnownEntry, ReadingsRef};
use super::columns::{key_unit, of_title};
use super::readings_file::{self, Cell, ReadingFile, Written};
use super::samples_file::SamplesFile;
use super::{Fetch, Folder, Named, Source, campaign_of, locate};
use crate::algebra::{Expression, Scratch, Tape};
use crate::bench::{Bench, Sensor};
use crate::campaign::{Place, Readings};
use crate::error::{Fault, Malformed, Result};
use crate::fit;
use crate::record::Column;
use crate::units::Conversion;

/// Most segments, and most stretches that are not used, of which is said what is odd in them.
pub(super) const TOLD: usize = 10;

/// Relative change of a solution that counts for none.
const SAME: f64 = 1e-9;

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
    /// Where the readings put what is estimated, by name; empty before they are there.
    solution: Vec<(String, f64)>,
}

/// Read a schedule for reduced readings.
///
/// Errors as [`super::read_campaign`]; readings that stand in a file of their own.
pub fn read_schedule(source: &Source, fetch: Fetch<'_>) -> Result<Schedule> {
    let file = campaign_of(source)?;
    let bench = file.resolved_bench(fetch).map_err(|error| locate::in_source(error, source))?;
    Schedule::new(file, bench, "readings").map_err(|error| locate::in_source(error, source))
}

impl Schedule {
    /// A schedule whose positions stand in the file, for messages at `path`.
    ///
    /// Errors: readings in another file; lists that are no schedule's.
    pub(super) fn new(file: CampaignFile, bench: Bench, path: &str) -> Result<Schedule> {
        let ReadingsRef::Inline(list) = &file.readings else {
            return Err(Malformed::new(Fault::Value, "the schedule's readings are in another file")
                .expected("the positions in the schedule itself")
                .at_path(path));
        };
        let mut rows = Vec::new();
        for (k, row) in list.iter().enumerate() {
            readings_file::expand(&bench, row.clone(), &Place::Path(format!("{path}[{k}]").into()), &mut rows)?;
        }
        Ok(Schedule { bench, rows: rows.into_iter().map(|(_, row)| row).collect(), file, solution: Vec::new() })
    }

    /// The unit that a column of samples is carried in under this name, where the name has one, and how that of its title converts to it.
    ///
    /// Errors: a unit that is not known, one of another dimension.
    pub(super) fn conversion(&self, name: &str, column: &Column) -> Result<Option<(String, Option<Conversion>)>> {
        key_unit(&self.bench, name).map(|to| of_title(column, name, &to).map(|conversion| (to, conversion))).transpose()
    }
}

/// A sensor whose value the schedule states: its model line at the samples of other columns.
#[derive(Debug, Clone)]
pub struct Computed {
    /// The sensor.
    pub name: String,
    /// Its unit.
    pub unit: String,
    tape: Tape,
    /// Where each input comes from: a column, or a value.
    inputs: Vec<std::result::Result<usize, f64>>,
}

impl Computed {
    /// The model line at each row of `columns`.
    pub fn values(&self, columns: &[&[f64]]) -> Vec<f64> {
        let rows = columns.first().map_or(0, |c| c.len());
        let mut scratch = Scratch::default();
        let mut inputs = vec![0.0; self.inputs.len()];
        (0..rows)
            .map(|row| {
                for (slot, from) in inputs.iter_mut().zip(&self.inputs) {
                    *slot = match from {
                        Ok(column) => columns.get(*column).and_then(|c| c.get(row)).copied().unwrap_or(f64::NAN),
                        Err(value) => *value,
                    };
                }
                self.tape.value(&inputs, &mut scratch)
            })
            .collect()
    }
}

impl Schedule {
    /// The sensors that the schedule states a value of, and whose model lines read these columns.
    pub(crate) fn computed(&self, columns: &[String]) -> Vec<Computed> {
        let unread = self.stated().filter(|s| !columns.contains(&s.id));
        unread.filter_map(|s| self.compute(&s.id, s.unit.as_str(), &s.model, columns)).collect()
    }

    /// The sensors whose values all rows state.
    fn stated(&self) -> impl Iterator<Item = &Sensor> {
        let all = |id: &str| self.rows.iter().all(|row| matches!(row.get(id), Some(Cell::Number(_))));
        self.bench.sensors.iter().filter(move |sensor| all(&sensor.id))
    }

    fn compute(&self, id: &str, unit: &str, model: &Expression, columns: &[String]) -> Option<Computed> {
        let names = model.names();
        let inputs: Vec<std::result::Result<usize, f64>> = names
            .iter()
            .map(|name| {
                if let Some(column) = columns.iter().position(|c| c == name) {
                    return Some(Ok(column));
                }
                let start = || self.file.estimate.get(name).map(|e| e.start.or(e.prior).unwrap_or(0.0));
                let solved = self.solution.iter().find(|(id, _)| id == name).map(|(_, value)| *value);
                let estimated = solved.or_else(start);
                let known = match self.file.known.get(name) {
                    Some(KnownEntry::Known(given)) => Some(given.value),
                    _ => None,
                };
                known.or(estimated).map(Err)
            })
            .collect::<Option<_>>()?;
        inputs.iter().any(std::result::Result::is_ok).then_some(())?;
        Some(Computed { name: id.into(), unit: unit.into(), tape: Tape::compile(model, &names).ok()?, inputs })
    }

    /// Go to the solution that reduced readings give, where lines are computed; `false` where that was no way.
    ///
    /// The uncertainty of a norm is that of its model line, whose slopes are the scale factors: at the start these may be any.
    pub(super) fn moves(&mut self, reduced: &[ReducedReading], places: &[usize]) -> bool {
        let first = reduced.first().map(|means| means.values.as_slice()).unwrap_or_default();
        if !self.stated().any(|sensor| first.iter().any(|(name, ..)| *name == sensor.id)) {
            return false;
        }
        let rows = self.filled(reduced, places).into_iter().map(|row| (Place::Nowhere, row));
        let readings = readings_file::from_cells(&self.bench, &Written::new(rows.collect()));
        let file = CampaignFile { readings: ReadingsRef::Inline(Vec::new()), ..self.file.clone() };
        let campaign = readings.and_then(|readings| file.with(self.bench.clone(), readings));
        // what is wrong with the campaign is said where it is asked for
        let Ok(fit) = campaign.and_then(|campaign| fit::fit(&campaign, &fit::Settings::default())) else {
            return false;
        };
        if fit.convergence.as_ref().is_some_and(|convergence| !convergence.converged) {
            return false;
        }
        let found: Vec<(String, f64)> =
            fit.campaign.estimated().iter().zip(&fit.point).map(|(p, value)| (p.id.clone(), *value)).collect();
        let is_near = |((_, a), (_, b)): (&(String, f64), &(String, f64))| (a - b).abs() <= SAME * a.abs().max(b.abs());
        let moved = found.len() != self.solution.len() || !found.iter().zip(&self.solution).all(is_near);
        self.solution = found;
        moved
    }

    /// The names that the bench reads from a reading: sensors, and what stands in their model lines.
    pub(crate) fn wanted(&self) -> Vec<String> {
        let sensors = self.bench.sensors.iter().map(|s| s.id.clone());
        let names = self.bench.sensors.iter().flat_map(|s| s.model.names().into_iter().map(str::to_string));
        sensors.chain(names).collect()
    }

    /// For each segment, the place of its row, see `assigned`: by label, in order, or one row for all.
    ///
    /// Errors: labels of which some are positions and some are not; another number of segments than of positions.
    pub(crate) fn pair(&self, labels: &[String]) -> Result<Vec<usize>> {
        let label = |row: &ReadingFile| row.get("position").map_or(String::new(), Cell::written);
        let positions: Vec<String> = self.rows.iter().map(label).collect();
        assigned(&positions, &|a, b| self.rows.get(a).map(|row| &row.0) == self.rows.get(b).map(|row| &row.0), labels)
    }

    /// Duration of a turn of the joint that turns in a row, s.
    pub(crate) fn turn_s(&self, place: usize) -> Option<f64> {
        let row = self.rows.get(place)?;
        self.bench.joints().find_map(|joint| match row.get(&format!("{joint}_deg_s")) {
            Some(Cell::Number(rate)) if *rate != 0.0 => Some(360.0 / rate.abs()),
            _ => None,
        })
    }

    /// The campaign: each reading in the row it belongs to.
    pub fn with(mut self, readings: &[ReducedReading], places: &[usize]) -> CampaignFile {
        self.file.readings = ReadingsRef::Inline(self.filled(readings, places));
        self.file
    }

    /// Each reading in the row it belongs to.
    ///
    /// A sensor whose value the schedule states (the norm of the specific force) keeps it, and gets the uncertainty of its model line over the segment.
    /// A standard uncertainty that the schedule states stands.
    pub(super) fn filled(&self, readings: &[ReducedReading], places: &[usize]) -> Vec<ReadingFile> {
        let mut rows = Vec::new();
        for (reading, place) in readings.iter().zip(places) {
            let Some(schedule) = self.rows.get(*place) else { continue };
            let states = |key: &str| matches!(schedule.get(key), Some(Cell::Number(_)));
            let mut row = schedule.clone();
            let mut set = |key: &str, cell: Cell| match row.0.iter_mut().find(|(present, _)| present == key) {
                Some((_, old)) => *old = cell,
                None => row.0.push((key.to_string(), cell)),
            };
            if self.rows.len() == 1 || schedule.get("position").is_none() {
                set("position", Cell::Text(reading.position.clone()));
            }
            for (name, mean, u) in &reading.values {
                if !(states(name) && self.bench.sensors.iter().any(|sensor| sensor.id == *name)) {
                    set(name, Cell::Number(*mean));
                }
                let key = format!("{name}_u");
                if *u > 0.0 && !states(&key) {
                    set(&key, Cell::Number(*u));
                }
            }
            set("time_s", Cell::Number(reading.time_s));
            rows.push(row);
        }
        rows
    }
}

/// The positions of a label: the k-th run of the label was taken in the k-th of them. Where they differ in nothing, runs may be fewer, and they may be more
/// unless another label has none.
#[derive(Debug, Clone)]
struct Labelled {
    label: String,
    places: Vec<usize>,
    alike: bool,
    /// How many runs there were so far.
    runs: usize,
}

/// Which position each run of a label was taken in, one after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Runs(Vec<Labelled>);

impl Runs {
    /// Of positions by their labels; one without a label has no runs. `same` says whether two positions differ in nothing.
    pub fn of(positions: &[String], same: &dyn Fn(usize, usize) -> bool) -> Self {
        let mut all: Vec<Labelled> = Vec::new();
        for (place, label) in positions.iter().enumerate().filter(|(_, label)| !label.is_empty()) {
            match all.iter_mut().find(|labelled| labelled.label == *label) {
                Some(labelled) => {
                    labelled.alike &= labelled.places.last().is_some_and(|last| same(*last, place));
                    labelled.places.push(place);
                }
                None => all.push(Labelled { label: label.clone(), places: vec![place], alike: true, runs: 0 }),
            }
        }
        Runs(all)
    }

    /// Is a label one of a position?
    pub fn knows(&self, label: &str) -> bool {
        self.0.iter().any(|labelled| labelled.label == label)
    }

    /// The position of the next run of a label; `None` for a label that is none, and for a run that no position is left for ([`Runs::ended`] says so).
    pub fn next(&mut self, label: &str) -> Option<usize> {
        let labelled = self.0.iter_mut().find(|labelled| labelled.label == label)?;
        let place = if labelled.alike { labelled.runs.min(labelled.places.len() - 1) } else { labelled.runs };
        labelled.runs += 1;
        labelled.places.get(place).copied()
    }

    /// Forget what has been.
    pub fn restart(&mut self) {
        self.0.iter_mut().for_each(|labelled| labelled.runs = 0);
    }

    /// After the last run. Errors: a label that has another number of runs than of positions that differ; `runs` says what they are.
    pub fn ended(&self, runs: &str) -> Result<()> {
        let without = self.0.iter().find(|labelled| labelled.runs == 0);
        let is_wrong = |labelled: &&Labelled| match labelled.alike {
            true => labelled.runs > labelled.places.len() && without.is_some(),
            false => labelled.runs > 0 && labelled.runs != labelled.places.len(),
        };
        let Some(Labelled { label, places, runs: all, .. }) = self.0.iter().find(is_wrong) else { return Ok(()) };
        let what = format!("the schedule has {} of the position '{label}', the record {all} {runs}", places.len());
        let others = without.map_or(String::new(), |labelled| format!("; '{}' has none", labelled.label));
        Err(Malformed::new(Fault::Value, what)
            .expected("as many, in the same order")
            .found(format!("{all} {runs} '{label}'{others}")))
    }
}

/// For each segment, the place of the position that it was taken in: one position for all; by label, as [`Runs`] says; in order where no label is a position, or where
/// segments have none.
///
/// Errors: labels of which some are positions and some are not; another number of segments than of positions.
pub(super) fn assigned(
    positions: &[String],
    same: &dyn Fn(usize, usize) -> bool,
    labels: &[String],
) -> Result<Vec<usize>> {
    if positions.len() == 1 {
        return Ok(vec![0; labels.len()]);
    }
    let mut runs = Runs::of(positions, same);
    if !labels.iter().any(|label| runs.knows(label)) {
        if positions.len() == labels.len() {
            return Ok((0..labels.len()).collect());
        }
        let what = format!("the schedule has {} positions, the record {} segments", positions.len(), labels.len());
        return Err(Malformed::new(Fault::Value, what)
            .expected("as many segments as positions, in the same order; or segments labelled as the positions are; or one row for all")
            .found(match labels.iter().all(String::is_empty) {
                true => format!("{} segments without labels", labels.len()),
                false => format!("segments {}", labels.join(", ")),
            }));
    }
    if labels.iter().any(String::is_empty) {
        return Err(Malformed::new(Fault::Missing, "some segments have a label, and some have none").expected(
            "the label of a position for each segment, or none for all of them, in the order of the positions",
        ));
    }
    if let Some(label) = labels.iter().find(|label| !runs.knows(label)) {
        let without: Vec<&str> = positions.iter().filter(|p| !labels.contains(p)).map(String::as_str).collect();
        let without = if without.is_empty() { positions.iter().map(String::as_str).collect() } else { without };
        return Err(Malformed::new(
            Fault::Value,
            format!("no position of the schedule is called '{label}', as a segment of the record is"),
        )
        .expected(format!("one of the positions, of which these have no segment: {}", without.join(", ")))
        .found(format!("'{label}'")));
    }
    let places = labels.iter().filter_map(|label| runs.next(label)).collect();
    runs.ended("segments")?;
    Ok(places)
}

impl CampaignFile {
    /// The readings that samples are reduced to.
    pub(super) fn reduced(&self, bench: &Bench, samples: SamplesFile, folder: &mut dyn Folder) -> Result<Readings> {
        self.one_device()?;
        if samples.is_rows() {
            return Err(Malformed::new(
                Fault::Value,
                "samples as rows are streamed and never all in memory: only `tumble fit` and `tumble check` take them",
            )
            .expected("the record's path as \"readings\" (all rows are held, up to 2000000), or samples without \"as\": \"rows\" (their means)")
            .at_path("readings.as"));
        }
        let recipe = samples
            .recipe(&self.columns, folder)
            .map_err(|e| if e.place().file.is_empty() { e.under("readings") } else { e })?;
        let mut positions = samples.positions;
        let path = if positions.is_empty() { "readings" } else { "readings.positions" };
        if positions.is_empty() {
            positions.push(Named::default());
        }
        let file = CampaignFile { readings: ReadingsRef::Inline(positions), ..self.clone() };
        let mut schedule = Schedule::new(file, bench.clone(), path)?;
        let mut open = || folder.record(&samples.samples).map_err(|e| e.at_path("readings.samples"));
        let (record, reduced) = recipe
            .reduce_for(&mut open, Some(&mut schedule))
            .map_err(|e| if e.place().path.is_empty() { e.at_path(path) } else { e })?;
        let from = samples.samples;
        if let Some(why) = reduced.nothing {
            return Err(Malformed::new(Fault::Value, format!("'{from}' gives no reading"))
                .expected("segments of the record that become readings")
                .found(why.join("; "))
                .in_file(record.name()));
        }
        reduced.notes.iter().for_each(|note| folder.note(format!("{from}: {note}")));
        let (segments, rejected) = (&reduced.reduction.segments, &reduced.reduction.rejected);
        for segment in segments.iter().filter(|segment| !segment.notes.is_empty()).take(TOLD) {
            folder.note(format!("{from}: segment {}: {}", segment.label, segment.notes.join("; ")));
        }
        for stretch in rejected.iter().take(TOLD) {
            let [start, end] = [stretch.samples.start, stretch.samples.end].map(|sample| reduced.trace.time(sample));
            folder.note(format!("{from}: {start:.3} s to {end:.3} s is not used: {}", stretch.reason));
        }
        let (used, not) = (segments.len(), rejected.len());
        folder.note(format!(
            "{used} reading{} reduced from '{from}', segments by {}{}",
            if used == 1 { "" } else { "s" },
            reduced.by,
            match not {
                0 => String::new(),
                1 => "; one stretch is not used".to_string(),
                n => format!("; {n} stretches are not used"),
            }
        ));
        let rows = schedule.filled(&reduced.readings(), &reduced.places);
        let named = |(row, place): (ReadingFile, &usize)| match path {
            "readings" => (Place::Path("readings".into()), row),
            _ => (Place::Path(format!("{path}[{place}]").into()), row),
        };
        let rows = rows.into_iter().zip(&reduced.places).map(named).collect();
        readings_file::from_cells(bench, &Written::new(rows))
    }
}
