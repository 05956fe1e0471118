//! What is asked of a record, and one pass over it: rows of the design, sensor by sensor.

use super::octaves::Noise;
use super::{Block, Observed, Rows};
use crate::campaign::{Campaign, Deviating, Per, Reading, Scatter, Size};
use crate::design::{self, DesignMatrix, Model, Together, Workspace};
use crate::elements::{Elements, OrNan, Parts};
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{Fold, Sequential, TimeNoise, backwards};
use crate::fit::system::{independent, stated_here_and_there};
use crate::fit::{Remount, Settings, Weighting};
use faer::Mat;
use std::borrow::Cow;

/// Rows whose design is made and folded at a time: what is worked on stays in a cache.
const PART: usize = 256;
/// Of a part: standard deviations that are all the same, times where none matter, a column without numbers.
const ONES: &[f64] = &[1.0; PART];
const ZEROS: &[f64] = &[0.0; PART];
const NONE: &[f64] = &[f64::NAN; PART];

/// A fit of a record.
pub(super) struct Question {
    /// The campaign, without readings but while lines follow a bench.
    campaign: Campaign,
    model: Model,
    /// The columns that the sensors' lines follow, where they follow columns alone; a bench is followed reading by reading.
    followed: Option<Vec<Vec<usize>>>,
    work: (Workspace, Together),
    /// Is every model line linear in the unknowns?
    pub is_linear: bool,
    pub settings: Settings,
    pub unknowns: usize,
    /// Columns of the design that are carried along: known inputs with an uncertainty, by parameter.
    pub carried: Vec<usize>,
    /// Their uncertainties, and the triangle of their correlations.
    inputs: (Vec<f64>, Vec<Vec<f64>>),
    /// Unknown, prior value and its standard uncertainty.
    pub priors: Vec<(usize, f64, f64)>,
    /// What is asked of each sensor.
    pub sensors: Vec<Sensor>,
    /// The least variance factor of each sensor's white noise: that of the rounding of its values in the sample.
    pub floor: Vec<f64>,
    /// Passes so far.
    pub passes: usize,
}

/// A sensor of the record.
#[derive(Debug, Clone)]
pub(super) struct Sensor {
    /// Its line of scatter, by index in the campaign, and the column of its times.
    pub line: Option<(usize, usize)>,
    /// Are the standard uncertainties of its values stated? `None` for a sensor that is not read.
    pub stated: Option<bool>,
}

/// Rows of one sensor from a block of the record.
pub(super) struct Chunk<'a> {
    /// Number of each row in the record, from 1.
    pub numbers: &'a [u64],
    /// Time of each, where noise is correlated over it.
    pub time: &'a [f64],
    /// Standard deviation of each row's white noise, relative.
    pub relative: &'a [f64],
    /// Value of each.
    pub values: &'a [f64],
    /// Unknowns, carried columns, observed minus predicted.
    pub rows: &'a Mat<f64>,
    /// The further inputs that were asked for, one list each.
    pub inputs: &'a [Cow<'a, [f64]>],
}

impl Chunk<'_> {
    /// Observed minus predicted.
    pub(super) fn observed(&self) -> &[f64] {
        self.rows.col_as_slice(self.rows.ncols() - 1)
    }

    /// The rows in some directions of the unknowns, a step away.
    pub(super) fn turned(&self, directions: &Mat<f64>, step: &[f64]) -> Mat<f64> {
        crate::linear::turned(self.rows, self.observed(), directions, step)
    }
}

/// A sensor's rows, folded with some noise.
#[derive(Debug, Clone)]
pub(super) struct Part {
    pub fold: Fold,
    /// The variance factor of the white noise that they were folded with.
    pub white: f64,
    pub log_determinant: f64,
    pub rows: u64,
}

/// Errors: what needs all readings at hand, and why.
pub(super) fn check(campaign: &Campaign, settings: &Settings) -> Result<()> {
    let refuse = |what: String, why: &str, path: &str| {
        Err(Malformed::new(Fault::Value, format!("{what}, which is not available for streamed rows: {why}"))
            .expected("the record's path as \"readings\" (its rows are then held), its means (\"samples\" without \"as\"), or a campaign without this")
            .at_path(path))
    };
    let (robust, remount) = (settings.robust.is_some(), settings.remount != Remount::No);
    for (is_asked, what, why, path) in [
        (
            robust,
            "a robust estimate is asked for",
            "its weights belong to single rows, and change in each step",
            "readings",
        ),
        (remount, "a scatter of remounting is asked for", "rows of a position are not brought together", "readings"),
        (
            !campaign.constraints.is_empty(),
            "the campaign has constraints",
            "what they cost is found with all rows",
            "constraints",
        ),
    ] {
        if is_asked {
            return refuse(what.into(), why, path);
        }
    }
    if let Some(sensor) = campaign.bench.sensors.iter().find(|sensor| sensor.turn.is_some()) {
        return refuse(
            format!("{} is a closed circle", sensor.id),
            "its whole turns are decided with all rows",
            "bench",
        );
    }
    let mut seen: Vec<usize> = Vec::new();
    for line in &campaign.scatter {
        let name = line.name(campaign);
        let Some((sensor, _)) = over(line) else {
            let why = "here the noise of a sensor may be correlated over a column of times (\"of\": a sensor, \"over\", \"tau\", \"u\")";
            return refuse(format!("the campaign says that {name} scatters"), why, &line.place);
        };
        if seen.contains(&sensor) {
            let why = "one line over time for each sensor";
            return refuse(format!("{name} is the second line of its sensor"), why, &line.place);
        }
        seen.push(sensor);
    }
    Ok(())
}

/// The sensor and the column of a line that is correlated over time; `None` for all others.
fn over(line: &Scatter) -> Option<(usize, &str)> {
    match (&line.of, &line.over, &line.per, &line.size) {
        (Deviating::Sensor(s), Some(over), Per::Campaign, Size::Stated { .. } | Size::Estimated) => {
            Some((*s, over.column.as_str()))
        }
        _ => None,
    }
}

impl Noise {
    /// In variances.
    pub(super) fn variances(self) -> TimeNoise {
        TimeNoise { white: self.white * self.white, deviation: self.deviation * self.deviation, tau: self.tau }
    }
}

impl Question {
    pub(super) fn new(campaign: &Campaign, settings: &Settings, columns: &[String]) -> Result<Self> {
        let sensors = (0..campaign.bench.sensors.len())
            .map(|s| {
                let own =
                    campaign.scatter.iter().enumerate().find_map(|(k, line)| {
                        over(line).filter(|(sensor, _)| *sensor == s).map(|(_, column)| (k, column))
                    });
                let line = own.and_then(|(k, column)| Some((k, columns.iter().position(|c| c == column)?)));
                let read = campaign.readings.rows.iter().flat_map(|r| &r.observations).find(|o| o.sensor == s);
                Sensor { line, stated: read.map(|o| o.u.is_some()) }
            })
            .collect();
        let model = Model::new(campaign)?;
        let (carried, u): (Vec<usize>, Vec<f64>) = campaign.uncertain().map(|(k, known)| (k, known.u)).unzip();
        Ok(Question {
            inputs: (u, campaign.correlation_root(&carried)),
            followed: (0..campaign.bench.sensors.len()).map(|s| model.columns_alone(s)).collect(),
            work: (model.workspace(), Together::default()),
            is_linear: campaign.is_linear(),
            model,
            campaign: campaign.without_readings(columns),
            settings: *settings,
            unknowns: campaign.unknowns(),
            carried,
            priors: campaign.priors().collect(),
            floor: vec![0.0; campaign.bench.sensors.len()],
            sensors,
            passes: 0,
        })
    }

    /// Rows of unknowns and carried columns with the known inputs in independent parts of unit variance ([`crate::estimate::System::with_inputs`]).
    pub(super) fn extended(&self, rows: &Mat<f64>) -> Mat<f64> {
        let n = self.unknowns;
        let (u, root) = &self.inputs;
        let carried = (n..n + self.carried.len()).map(|j| rows.col_as_slice(j));
        let inputs = independent(carried, u, root);
        Mat::from_fn(rows.nrows(), rows.ncols(), |i, j| match j.checked_sub(n) {
            Some(k) if k < inputs.ncols() => inputs[(i, k)],
            _ => rows[(i, j)],
        })
    }

    /// Is a sensor's white noise estimated?
    pub(super) fn is_white_free(&self, s: usize) -> bool {
        // a sensor that is not read has no rows that could say so
        let stated = self.sensors.get(s).and_then(|own| own.stated).unwrap_or(false);
        !stated || self.settings.weighting == Weighting::Relative
    }

    /// Is a sensor read in the record?
    pub(super) fn is_read(&self, s: usize) -> bool {
        self.sensors.get(s).is_some_and(|own| own.stated.is_some())
    }

    /// One pass: the rows of the design at a point, sensor by sensor, with further numeric columns.
    pub(super) fn walk(
        &mut self,
        rows: &mut dyn Rows,
        point: &[f64],
        further: &[usize],
        each: &mut dyn FnMut(usize, &Chunk<'_>) -> Result<()>,
    ) -> Result<()> {
        rows.rewind()?;
        self.passes += 1;
        let (mut before, mut block) = (0_u64, Block::default());
        while rows.next(&mut block)? {
            self.chunks((&*rows, &block), point, further, before, each)?;
            before += block.rows as u64;
        }
        Ok(())
    }

    /// The rows of a block, `before` of them were given already.
    pub(super) fn chunks(
        &mut self,
        (rows, block): (&dyn Rows, &Block),
        point: &[f64],
        further: &[usize],
        before: u64,
        each: &mut dyn FnMut(usize, &Chunk<'_>) -> Result<()>,
    ) -> Result<()> {
        let assembled = if self.followed.is_none() { Some(self.assembled(rows, block, point)?) } else { None };
        for s in 0..self.sensors.len() {
            let Some(observed) = block.sensors.get(s) else { continue };
            let read = observed.values.iter().enumerate().filter(|(_, value)| !value.is_nan());
            let own: Vec<usize> = read.map(|(k, _)| k).collect();
            let Some(first) = own.first() else { continue };
            self.look((rows, block), observed, s, &own)?;
            // rows of the design are in the order of the readings
            let of = |design: &DesignMatrix| -> Vec<usize> {
                design.rows.iter().enumerate().filter(|(_, origin)| origin.sensor == s).map(|(i, _)| i).collect()
            };
            let places = assembled.as_ref().map(of).unwrap_or_default();
            let whole = own.len() == block.rows;
            for start in (0..own.len()).step_by(PART) {
                let part = own.part(start..own.len().min(start + PART));
                // most records have every value in every row
                fn pick<'l>(list: &'l [f64], whole: bool, start: usize, part: &[usize]) -> Cow<'l, [f64]> {
                    match whole {
                        true => Cow::Borrowed(list.part(start..start + part.len())),
                        false => part.iter().map(|k| list.at(*k)).collect(),
                    }
                }
                let pick = |list| pick(list, whole, start, part);
                let values = pick(&observed.values);
                let relative = match (observed.u.get(*first).filter(|u| !u.is_nan()), observed.samples.is_empty()) {
                    (Some(_), _) => pick(&observed.u),
                    (None, false) => pick(&observed.samples).iter().map(|samples| 1.0 / samples.sqrt()).collect(),
                    (None, true) => Cow::Borrowed(ONES.part(0..part.len())),
                };
                let list = |column: usize| block.columns.get(column).filter(|list| !list.is_empty());
                let of_column =
                    |column: usize| list(column).map_or(Cow::Borrowed(NONE.part(0..part.len())), |list| pick(list));
                let time = match self.sensors.get(s).and_then(|own| own.line) {
                    Some((_, column)) => of_column(column),
                    None => Cow::Borrowed(ZEROS.part(0..part.len())),
                };
                let mut design = Mat::zeros(part.len(), self.unknowns + self.carried.len() + 1);
                match &assembled {
                    Some(all) => self.copied(all, places.part(start..start + part.len()), &mut design),
                    None => self.evaluated(s, point, &of_column, &mut design),
                }
                let last = design.ncols() - 1;
                design.col_as_slice_mut(last).iter_mut().zip(values.iter()).for_each(|(to, value)| *to = value - *to);
                let numbers: Vec<u64> = part.iter().map(|k| before + *k as u64 + 1).collect();
                let inputs: Vec<Cow<'_, [f64]>> = further.iter().map(|column| of_column(*column)).collect();
                let chunk = Chunk {
                    numbers: &numbers,
                    time: &time,
                    relative: &relative,
                    values: &values,
                    rows: &design,
                    inputs: &inputs,
                };
                each(s, &chunk).map_err(|error| {
                    let numbers = numbers.first().zip(numbers.last());
                    match numbers.filter(|_| error.place().path.starts_with("rows[")) {
                        Some((first, last)) => error.at_path(format!("readings.rows, rows {first} to {last}")),
                        None => error,
                    }
                })?;
            }
        }
        Ok(())
    }

    /// What a sensor's rows must have: an uncertainty in all or in none, the times and the columns that its line follows.
    fn look(&mut self, (rows, block): (&dyn Rows, &Block), observed: &Observed, s: usize, own: &[usize]) -> Result<()> {
        let missing = |column: usize| {
            let list = block.columns.get(column).map_or(&[][..], Vec::as_slice);
            own.iter().copied().find(|k| list.or_nan(*k).is_nan())
        };
        let name = |column: usize| self.campaign.readings.columns.get(column).map_or("", String::as_str);
        let Some(sensor) = self.sensors.get_mut(s) else { return Ok(()) };
        let is_stated = |k: usize| !observed.u.or_nan(k).is_nan();
        let stated = sensor.stated.unwrap_or(own.first().is_some_and(|k| is_stated(*k)));
        sensor.stated = Some(stated);
        if let Some(k) = own.iter().find(|k| is_stated(**k) != stated) {
            return Err(stated_here_and_there(self.campaign.sensor_id(s)).at_path(rows.place(*k)));
        }
        if let Some((_, column)) = sensor.line {
            if let Some(k) = missing(column) {
                let name = name(column);
                return Err(Malformed::new(
                    Fault::Missing,
                    format!("a reading has no {name}, and noise is correlated over it"),
                )
                .expected(format!("{name} in every reading"))
                .at_path(rows.place(k)));
            }
            let time = |k: usize| block.columns.get(column).map_or(f64::NAN, |list| list.at(k));
            let mut steps = own.iter().zip(own.iter().skip(1));
            if let Some((before, k)) = steps.find(|(before, k)| time(**k) < time(**before)) {
                return Err(backwards(time(*k), time(*before)).at_path(rows.place(*k)));
            }
        }
        for column in self.followed.as_ref().and_then(|followed| followed.get(s)).into_iter().flatten() {
            if let Some(k) = missing(*column) {
                return Err(design::missing_column(name(*column)).at_path(rows.place(k)));
            }
        }
        Ok(())
    }

    /// The block as readings, and their design.
    fn assembled(&mut self, rows: &dyn Rows, block: &Block, point: &[f64]) -> Result<DesignMatrix> {
        let readings = &mut self.campaign.readings.rows;
        readings.resize_with(block.rows, Reading::default);
        for (k, reading) in readings.iter_mut().enumerate() {
            rows.reading(block, k, reading)?;
        }
        design::assemble(&self.campaign, &self.model, point).or_else(|_| {
            // once more, to say where
            let readings = &mut self.campaign.readings.rows;
            readings.iter_mut().enumerate().for_each(|(k, reading)| reading.place = rows.place(k));
            design::assemble(&self.campaign, &self.model, point)
        })
    }

    /// Rows of a design that was assembled: unknowns, carried columns, predictions.
    fn copied(&self, from: &DesignMatrix, places: &[usize], to: &mut Mat<f64>) {
        let columns = (0..self.unknowns).chain(self.carried.iter().copied());
        for (j, column) in columns.enumerate() {
            let column = from.jacobian.col_as_slice(column);
            to.col_as_slice_mut(j).iter_mut().zip(places).for_each(|(to, i)| *to = column.at(*i));
        }
        let last = to.ncols() - 1;
        to.col_as_slice_mut(last).iter_mut().zip(places).for_each(|(to, i)| *to = from.predicted.at(*i));
    }

    /// The same of a line that follows columns.
    fn evaluated<'b>(
        &mut self,
        s: usize,
        point: &[f64],
        of_column: &dyn Fn(usize) -> Cow<'b, [f64]>,
        to: &mut Mat<f64>,
    ) {
        let Some(followed) = self.followed.as_ref().and_then(|followed| followed.get(s)) else { return };
        let lists: Vec<(usize, Cow<'_, [f64]>)> = followed.iter().map(|column| (*column, of_column(*column))).collect();
        let lists: Vec<(usize, &[f64])> = lists.iter().map(|(column, list)| (*column, &**list)).collect();
        let parameters: Vec<usize> = (0..self.unknowns).chain(self.carried.iter().copied()).collect();
        let ((work, room), places, last) = (&mut self.work, to.nrows(), to.ncols() - 1);
        self.model.predict_lists(
            &self.campaign.bench,
            s,
            (&lists, places),
            point,
            (work, room),
            |start, values, slopes| {
                let mut set = |j: usize, list: &[f64]| {
                    to.col_as_slice_mut(j).iter_mut().skip(start).zip(list).for_each(|(to, value)| *to = *value);
                };
                parameters
                    .iter()
                    .enumerate()
                    .for_each(|(j, k)| slopes.get(*k).into_iter().for_each(|list| set(j, list)));
                set(last, values);
            },
        );
    }

    /// One pass: every sensor's rows folded with its noise; nothing of a sensor that is not read.
    pub(super) fn fold(
        &mut self,
        rows: &mut dyn Rows,
        point: &[f64],
        noise: &[Noise],
        look: &mut dyn FnMut(usize, &Chunk<'_>),
    ) -> Result<Vec<Option<Part>>> {
        let (n, carried) = (self.unknowns, self.carried.len());
        let mut folding: Vec<Folding> = noise.iter().map(|own| Folding::new(n, carried, *own)).collect();
        self.walk(rows, point, &[], &mut |s, chunk| {
            look(s, chunk);
            folding.get_mut(s).map_or(Ok(()), |own| own.push(chunk.rows, chunk.time, chunk.relative).map(drop))
        })?;
        Ok(self.parts(folding))
    }

    /// What was folded of the sensors that are read.
    pub(super) fn parts(&self, folding: Vec<Folding>) -> Vec<Option<Part>> {
        folding.into_iter().enumerate().map(|(s, own)| self.is_read(s).then(|| own.part())).collect()
    }
}

/// A sensor's rows on their way into a triangle.
pub(super) struct Folding {
    filter: Sequential,
    fold: Fold,
    white: f64,
    columns: usize,
    ones: Vec<f64>,
    sd: Vec<f64>,
}

impl Folding {
    pub(super) fn new(unknowns: usize, carried: usize, noise: Noise) -> Self {
        let columns = unknowns + carried;
        Folding {
            filter: Sequential::new(columns + 1, noise.deviation * noise.deviation, noise.tau),
            fold: Fold::carrying(unknowns, carried),
            white: noise.white,
            columns,
            ones: Vec::new(),
            sd: Vec::new(),
        }
    }

    /// Takes a block of rows, the observations in the last column, and gives it back made independent; rows that are so already are not copied.
    pub(super) fn push<'a>(&mut self, rows: &'a Mat<f64>, time: &[f64], relative: &[f64]) -> Result<Cow<'a, Mat<f64>>> {
        self.sd.clear();
        self.sd.extend(relative.iter().map(|own| own * self.white));
        let rows = self.filter.whitened(rows, time, &self.sd)?;
        self.ones.resize(rows.nrows(), 1.0);
        self.fold.push(rows.subcols(0, self.columns), rows.col_as_slice(self.columns), &self.ones)?;
        Ok(rows)
    }

    /// What makes the rows independent.
    pub(super) fn filter(&self) -> &Sequential {
        &self.filter
    }

    pub(super) fn part(self) -> Part {
        let white = self.white * self.white;
        Part { log_determinant: self.filter.log_determinant(), rows: self.fold.rows() as u64, fold: self.fold, white }
    }
}
