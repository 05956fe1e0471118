//! What is asked of a record, and one pass over it: rows of the design, sensor by sensor.

use super::Rows;
use super::octaves::Noise;
use crate::campaign::{Campaign, Deviating, Per, Role, Scatter, Size};
use crate::design::{self, Model};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{Fold, Sequential};
use crate::fit::{Remount, Settings, Weighting};
use faer::Mat;

/// A fit of a record.
pub(super) struct Question {
    /// The campaign; its readings are the block at hand.
    campaign: Campaign,
    model: Model,
    pub settings: Settings,
    pub unknowns: usize,
    /// Columns of the design that are carried along: known inputs with an uncertainty, by parameter.
    pub carried: Vec<usize>,
    /// Unknown, prior value and its standard uncertainty.
    pub priors: Vec<(usize, f64, f64)>,
    /// What is asked of each sensor.
    pub sensors: Vec<Sensor>,
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
    pub inputs: &'a [Vec<f64>],
}

/// A sensor's rows, folded with some noise.
#[derive(Debug, Clone)]
pub(super) struct Part {
    pub fold: Fold,
    pub log_determinant: f64,
    pub rows: u64,
}

/// Errors: what needs all readings at hand, and why.
pub(super) fn check(campaign: &Campaign, settings: &Settings) -> Result<()> {
    let refuse = |what: String, why: &str, path: &str| {
        Err(Malformed::new(Fault::Value, format!("{what}, which is not to be had from rows that are streamed: {why}"))
            .expected("the record's path as \"readings\" (its rows are then held), its means (\"samples\" without \"as\"), or a campaign without this")
            .at_path(path))
    };
    if settings.robust.is_some() {
        return refuse(
            "a robust estimate is asked for".into(),
            "its weights belong to single rows, and change in each step",
            "readings",
        );
    }
    if settings.remount != Remount::No {
        return refuse(
            "a scatter of remounting is asked for".into(),
            "rows of a position are not brought together",
            "readings",
        );
    }
    if !campaign.constraints.is_empty() {
        return refuse("the campaign has constraints".into(), "what they cost is found with all rows", "constraints");
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

impl Question {
    pub(super) fn new(campaign: &Campaign, settings: &Settings, columns: &[String]) -> Result<Self> {
        let estimated = campaign.estimated();
        let prior = |(k, p): (usize, &crate::campaign::Parameter)| match &p.role {
            Role::Estimated { prior: Some(prior), .. } => Some((k, prior.value, prior.u)),
            _ => None,
        };
        let known = campaign.parameters.iter().enumerate();
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
        Ok(Question {
            model: Model::new(campaign)?,
            campaign: campaign.without_readings(columns),
            settings: *settings,
            unknowns: campaign.unknowns(),
            carried: known
                .filter(|(_, p)| matches!(p.role, Role::Known(known) if known.u != 0.0))
                .map(|(k, _)| k)
                .collect(),
            priors: estimated.iter().enumerate().filter_map(prior).collect(),
            sensors,
            passes: 0,
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
        let mut before = 0_u64;
        let mut block = std::mem::take(&mut self.campaign.readings.rows);
        while rows.next(&mut block)? {
            self.campaign.readings.rows = std::mem::take(&mut block);
            self.chunks(point, further, before, each)?;
            block = std::mem::take(&mut self.campaign.readings.rows);
            before += block.len() as u64;
        }
        Ok(())
    }

    fn chunks(
        &mut self,
        point: &[f64],
        further: &[usize],
        before: u64,
        each: &mut dyn FnMut(usize, &Chunk<'_>) -> Result<()>,
    ) -> Result<()> {
        let design = design::assemble(&self.campaign, &self.model, point)?;
        let readings = &self.campaign.readings.rows;
        for (s, sensor) in self.sensors.iter_mut().enumerate() {
            let own: Vec<usize> =
                design.rows.iter().enumerate().filter(|(_, origin)| origin.sensor == s).map(|(i, _)| i).collect();
            if own.is_empty() {
                continue;
            }
            let (mut numbers, mut time, mut relative, mut values) = (
                Vec::with_capacity(own.len()),
                Vec::with_capacity(own.len()),
                Vec::with_capacity(own.len()),
                Vec::with_capacity(own.len()),
            );
            let mut inputs = vec![Vec::with_capacity(own.len()); further.len()];
            for origin in own.iter().filter_map(|i| design.rows.get(*i)) {
                let Some(reading) = readings.get(origin.reading) else { continue };
                let Some(value) = reading.observations.iter().find(|o| o.sensor == s) else { continue };
                let is_stated = value.u.is_some();
                if sensor.stated.is_some_and(|stated| stated != is_stated) {
                    let id = self.campaign.bench.sensors.get(s).map_or("", |own| own.id.as_str());
                    return Err(Malformed::new(
                        Fault::Missing,
                        format!("some readings of {id} have a stated uncertainty and some have none"),
                    )
                    .expected(format!(
                        "{id}_u in every reading of {id}, or in none (then it is estimated from the residuals)"
                    ))
                    .at_path(reading.place.clone()));
                }
                sensor.stated = Some(is_stated);
                let number = |column: usize| reading.columns.get(column).copied().flatten();
                let at = match sensor.line {
                    Some((_, column)) => number(column).ok_or_else(|| {
                        let name = self.campaign.readings.columns.get(column).map_or("", String::as_str);
                        Malformed::new(
                            Fault::Missing,
                            format!("a reading has no {name}, and noise is correlated over it"),
                        )
                        .expected(format!("{name} in every reading"))
                        .at_path(reading.place.clone())
                    })?,
                    None => 0.0,
                };
                if let Some(last) = time.last().filter(|last| sensor.line.is_some() && at < **last) {
                    return Err(backwards(at, *last).at_path(reading.place.clone()));
                }
                numbers.push(before + origin.reading as u64 + 1);
                time.push(at);
                relative.push(value.u.unwrap_or(1.0 / value.samples.sqrt()));
                values.push(value.value);
                for (list, column) in inputs.iter_mut().zip(further) {
                    list.push(number(*column).unwrap_or(f64::NAN));
                }
            }
            let (n, carried) = (self.unknowns, self.carried.len());
            let mut rows = Mat::zeros(own.len(), n + carried + 1);
            for j in 0..=n + carried {
                let to = rows.col_as_slice_mut(j);
                let from = match j.checked_sub(n) {
                    None => Some(j),
                    Some(k) => self.carried.get(k).copied(),
                };
                match from {
                    Some(from) => {
                        let from = design.jacobian.col_as_slice(from);
                        to.iter_mut().zip(&own).for_each(|(to, i)| *to = from.at(*i));
                    }
                    None => to.iter_mut().zip(&own).zip(&values).for_each(|((to, i), value)| {
                        *to = value - design.predicted.at(*i);
                    }),
                }
            }
            let chunk = Chunk {
                numbers: &numbers,
                time: &time,
                relative: &relative,
                values: &values,
                rows: &rows,
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
        Ok(())
    }

    /// One pass: every sensor's rows folded with each of its noises.
    pub(super) fn fold(
        &mut self,
        rows: &mut dyn Rows,
        point: &[f64],
        noises: &[Vec<Noise>],
        look: &mut dyn FnMut(usize, &Chunk<'_>),
    ) -> Result<Vec<Vec<Part>>> {
        let (n, carried) = (self.unknowns, self.carried.len());
        let mut folding: Vec<Vec<Folding>> =
            noises.iter().map(|list| list.iter().map(|noise| Folding::new(n, carried, *noise)).collect()).collect();
        self.walk(rows, point, &[], &mut |s, chunk| {
            look(s, chunk);
            for own in folding.get_mut(s).into_iter().flatten() {
                own.push(chunk.rows.clone(), chunk.time, chunk.relative)?;
            }
            Ok(())
        })?;
        Ok(folding.into_iter().map(|list| list.into_iter().map(Folding::part).collect()).collect())
    }
}

fn backwards(at: f64, last: f64) -> Malformed {
    Malformed::new(Fault::Value, "the times of the rows do not rise")
        .expected("rows in the order of time, for noise that is correlated over it")
        .found(format!("{at} after {last}"))
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

    /// Takes a block of rows, the observations in the last column, and gives it back made independent.
    pub(super) fn push(&mut self, mut rows: Mat<f64>, time: &[f64], relative: &[f64]) -> Result<Mat<f64>> {
        self.sd.clear();
        self.sd.extend(relative.iter().map(|own| own * self.white));
        self.filter.whiten(&mut rows, time, &self.sd)?;
        self.ones.resize(rows.nrows(), 1.0);
        let observed = rows.col_as_slice(self.columns).to_vec();
        self.fold.push(rows.subcols(0, self.columns), &observed, &self.ones)?;
        Ok(rows)
    }

    pub(super) fn part(self) -> Part {
        Part { log_determinant: self.filter.log_determinant(), rows: self.filter.rows(), fold: self.fold }
    }
}
