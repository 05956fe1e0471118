//! One linear step for devices whose readings come in any order, in parts, or to several machines: the rows of a position once, a state that
//! merges, and a device's row from it.
//!
//! ```text
//! positions -> lines (a row of the design each) ;  lines + values -> Part ;  Part + Part -> Part ;  Part -> Row
//! ```
//!
//! A part is the triangle of a [`Fold`], whose size does not depend on the readings. What needs the readings themselves (robust weights,
//! constraints, scatter, closed circles, several scales to estimate, suspicious readings, lack of fit, runs) is not to be had from it.

use super::answer::{Answer, Asked, Carried, Coverage, Input, Question};
use super::common::alone;
use super::{Row, Solved};
use crate::campaign::{Campaign, Observation, Readings};
use crate::design::{self, Model};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{Block, Compressed, Factor, Fold, NO_REDUNDANCY, ScaleHints, Scaled};
use crate::fit::{self, Estimator, Settings, Weighting};
use faer::{Mat, MatRef};

/// The linear step of a campaign, for readings that are not all at hand.
#[derive(Debug, Clone)]
pub struct Parts {
    asked: Asked,
    model: Model,
    carried: Vec<Carried>,
    /// Unknown, prior less its reference, standard uncertainty.
    priors: Vec<(usize, f64, f64)>,
}

/// A row of the design: what a sensor's value at some position says about the unknowns.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignRow {
    /// Which of the readings it belongs to.
    pub reading: usize,
    /// Index of the sensor in the bench.
    pub sensor: usize,
    /// The model at the reference point.
    pub predicted: f64,
    /// Derivatives by the unknowns, then what is carried along.
    pub columns: Vec<f64>,
}

/// What is known of a device from some of its readings.
#[derive(Debug, Clone)]
pub struct Part {
    fold: Fold,
    /// For each sensor, whether values with and without a stated uncertainty were met.
    met: Vec<[bool; 2]>,
    /// Largest size of a value.
    largest: f64,
    /// Largest size of a value in units of its uncertainty.
    weighed: f64,
    largest_u: f64,
    /// The last decimal place of all values; `None` before the first, NaN where they have the digits of a computation.
    step: Option<f64>,
}

impl Parts {
    /// The step of a campaign; its readings are not looked at, but their numeric columns are.
    ///
    /// Errors: what a step without the readings cannot do, and what does it.
    pub fn new(template: &Campaign, settings: &Settings) -> Result<Self> {
        let refuse = |what: &str, path: &str| {
            Err(Malformed::new(Fault::Value, format!("{what}: that needs all readings of a device in memory"))
                .expected("the ordinary fit of each device (tumble fit CAMPAIGN --by COLUMN)")
                .at_path(path))
        };
        fit::check_level(settings.level)?;
        if let Err((what, path)) = alone(template, settings) {
            return refuse(&what, path);
        }
        if !template.is_linear() {
            if settings.estimator == Estimator::Exact {
                return Err(Malformed::new(
                    Fault::Value,
                    "the model is not linear in its unknowns, and one linear step is not its fit",
                )
                .expected(
                    "the linear estimator (one step from the start values), or tumble fit CAMPAIGN --by COLUMN, which iterates",
                )
                .at_path("estimate"));
            }
            if template.uncertain().next().is_some() {
                return refuse(
                    "the model is not linear in its unknowns, and an input is known with an uncertainty",
                    "known",
                );
            }
        }
        if template.unknowns() == 0 {
            // refused in the words of a fit
            fit::askable(template)?;
        }
        let asked = Asked::new(template, settings)?;
        let priors = template.priors().map(|(k, value, u)| (k, value - asked.reference.at(k), u)).collect();
        Ok(Parts { model: Model::new(template)?, carried: Carried::of(template), asked, priors })
    }

    /// The campaign, without readings.
    pub fn campaign(&self) -> &Campaign {
        &self.asked.campaign
    }

    /// The lines of some readings, one for each value.
    ///
    /// Errors: readings that no fit takes; a model line without a value there.
    pub fn lines(&self, readings: Readings) -> Result<Vec<DesignRow>> {
        let campaign = self.asked.campaign.with_readings(readings);
        fit::askable(&campaign)?;
        let design = design::assemble(&campaign, &self.model, &self.asked.reference)?;
        fit::check_rows(&campaign, &self.model, &design)?;
        let n = campaign.unknowns();
        let carried = Carried::columns(&self.carried, &campaign, &self.model, &design)?;
        let columns = |i: usize| -> Vec<f64> {
            (0..n).map(|j| design.jacobian[(i, j)]).chain(carried.iter().map(|column| column.at(i))).collect()
        };
        let line = |(i, (origin, predicted)): (usize, (&design::RowOrigin, &f64))| DesignRow {
            reading: origin.reading,
            sensor: origin.sensor,
            predicted: *predicted,
            columns: columns(i),
        };
        Ok(design.rows.iter().zip(&design.predicted).enumerate().map(line).collect())
    }

    /// A part without readings.
    pub fn nothing(&self) -> Part {
        Part {
            fold: Fold::carrying(self.asked.campaign.unknowns(), self.carried.len()),
            met: vec![[false; 2]; self.asked.campaign.bench.sensors.len()],
            largest: 0.0,
            weighed: 0.0,
            largest_u: 0.0,
            step: None,
        }
    }

    /// Values read, each with its line.
    ///
    /// Errors: lines of another campaign; values and uncertainties that no fit takes.
    pub fn push(&self, part: &mut Part, values: &[(&DesignRow, Observation)]) -> Result<()> {
        let (k, n) = (values.len(), self.asked.campaign.unknowns() + self.carried.len());
        let u = |value: &Observation| value.u.unwrap_or(1.0 / value.samples.sqrt());
        let rows = Mat::from_fn(k, n, |i, j| {
            // a line of another campaign: refused as not finite
            values.get(i).and_then(|(line, _)| line.columns.get(j)).copied().unwrap_or(f64::NAN)
        });
        let observed: Vec<f64> = values.iter().map(|(line, value)| value.value - line.predicted).collect();
        let us: Vec<f64> = values.iter().map(|(_, value)| u(value)).collect();
        part.fold.push(rows.as_ref(), &observed, &us)?;
        for (_, value) in values {
            if let Some([stated, open]) = part.met.get_mut(value.sensor) {
                *(if value.u.is_none() { open } else { stated }) = true;
            }
            part.largest = part.largest.max(value.value.abs());
            if value.u.is_none() || self.asked.settings.weighting == Weighting::Relative {
                part.weighed = part.weighed.max(value.value.abs() / u(value));
                part.largest_u = part.largest_u.max(u(value));
                if !self.asked.campaign.bench.sensors.get(value.sensor).is_some_and(crate::bench::Sensor::is_reference)
                {
                    part.step = Some(finer(part.step, value.value));
                }
            }
        }
        Ok(())
    }

    /// The part of a device that was packed. Errors: numbers that are no part of this campaign.
    pub fn unpack(&self, packed: &[f64]) -> Result<Part> {
        let mut part = self.nothing();
        let [largest, weighed, largest_u, step, rest @ ..] = packed else {
            return Err(Malformed::new(Fault::Value, "these numbers are no part of a device"));
        };
        // too short: refused by `unpack`
        let (met, fold) = rest.split_at_checked(part.met.len()).unwrap_or_default();
        part.fold = Fold::unpack(self.asked.campaign.unknowns(), self.carried.len(), fold)?;
        part.met = met.iter().map(|code| [code % 2.0 >= 1.0, *code >= 2.0]).collect();
        (part.largest, part.weighed, part.largest_u) = (*largest, *weighed, *largest_u);
        part.step = if *step == f64::NEG_INFINITY { None } else { Some(*step) };
        Ok(part)
    }
}

impl Part {
    /// Values taken so far.
    pub fn readings(&self) -> usize {
        self.fold.rows()
    }

    /// Joins what another part of the same device says. Errors: a part of another campaign.
    pub fn merge(&mut self, other: &Part) -> Result<()> {
        self.fold.merge(&other.fold)?;
        for (sensor, met) in self.met.iter_mut().zip(&other.met) {
            *sensor = [sensor[0] || met[0], sensor[1] || met[1]];
        }
        self.largest = self.largest.max(other.largest);
        self.weighed = self.weighed.max(other.weighed);
        self.largest_u = self.largest_u.max(other.largest_u);
        self.step = match (self.step, other.step) {
            (Some(a), Some(b)) => Some(if a.is_nan() || b.is_nan() { f64::NAN } else { a.min(b) }),
            (this, other) => this.or(other),
        };
        Ok(())
    }

    /// The part as numbers, for [`Parts::unpack`].
    pub fn pack(&self) -> Vec<f64> {
        // packed as what no step is
        let mut numbers = vec![self.largest, self.weighed, self.largest_u, self.step.unwrap_or(f64::NEG_INFINITY)];
        numbers.extend(self.met.iter().map(|[with, without]| f64::from(u8::from(*with) + 2 * u8::from(*without))));
        numbers.extend(self.fold.pack());
        numbers
    }

    /// The scale that the rounding of the readings alone would have.
    fn least(&self) -> f64 {
        // numbers of full precision have no step
        let step = self.step.filter(|step| !step.is_nan());
        fit::rounding_of(step, (self.weighed, self.largest_u))
    }
}

/// The last decimal place of values so far and of one more.
fn finer(so_far: Option<f64>, value: f64) -> f64 {
    match so_far {
        Some(step) if step.is_nan() => step,
        Some(step) => {
            let scale = (1.0 / step).round();
            let count = (value * scale).round();
            // a number of at most 14 digits that is written with as many places
            if count.abs() < 1e14 && count / scale == value {
                return step;
            }
            fit::resolution(std::iter::once(value)).map_or(f64::NAN, |q| q.min(step))
        }
        // not decimal: nothing later makes it so
        None => fit::resolution(std::iter::once(value)).unwrap_or(f64::NAN),
    }
}

impl Parts {
    /// A device's answer: estimates, uncertainties, rank and global test as its own fit says them.
    pub fn finish(&self, label: &str, part: &Part, coverage: &mut Coverage) -> Row {
        let quantities = self.asked.campaign.unknowns() + self.asked.derived.len();
        self.row(label, part, coverage).unwrap_or_else(|error| Row::without(label, quantities, &error))
    }

    /// Is the scatter of the readings estimated from them?
    fn is_scaled(&self, part: &Part) -> Result<bool> {
        let sensors = || self.asked.campaign.bench.sensors.iter().zip(&part.met);
        if let Some((sensor, _)) = sensors().find(|(_, met)| **met == [true, true]) {
            return Err(fit::stated_here_and_there(&sensor.id));
        }
        let relative = self.asked.settings.weighting == Weighting::Relative;
        let read: Vec<bool> =
            sensors().filter(|(_, met)| **met != [false, false]).map(|(_, met)| relative || met[1]).collect();
        match read.as_slice() {
            [] => {
                let ids: Vec<&str> = self.asked.campaign.bench.sensors.iter().map(|s| s.id.as_str()).collect();
                Err(Malformed::new(Fault::Missing, "no reading has a sensor value")
                    .expected(format!("readings with a value for {}", ids.join(" or "))))
            }
            [true] if self.priors.is_empty() => Ok(true),
            list if !list.contains(&true) => Ok(false),
            _ => Err(Malformed::new(
                Fault::Missing,
                "the scatter of several sensors (or with priors) is to be estimated, which needs all readings in memory",
            )
            .expected("stated uncertainties of the readings, or the ordinary fit of each device")),
        }
    }

    fn row(&self, label: &str, part: &Part, coverage: &mut Coverage) -> Result<Row> {
        let Asked { campaign, settings, reference, .. } = &self.asked;
        let n = campaign.unknowns();
        let scaled = self.is_scaled(part)?;
        if part.largest > 0.0 && part.largest < fit::LEAST {
            return Err(Malformed::new(
                Fault::Value,
                "the largest reading is beyond the numbers that a fit can square",
            )
            .expected("units in which it lies between 1e-70 and 1e70")
            .found(format!("{:e}", part.largest)));
        }
        // observations and priors about one point
        let about = |j: usize| part.fold.about().get(j).copied().unwrap_or(0.0);
        let priors: Vec<(usize, f64, f64)> =
            self.priors.iter().map(|(k, difference, u)| (*k, difference - about(*k), *u)).collect();
        let blocks = vec![Block::folded(&part.fold), Block::stated(n + self.carried.len(), &priors)];
        let rows = Compressed::of(blocks, n, 0);
        let Scaled { mut unknowns, sum_of_squares: squares, factor, .. } =
            rows.adjust(&ScaleHints::default(), &settings.adjust)?;
        unknowns.solution.iter_mut().enumerate().for_each(|(j, x)| *x += about(j));
        let (solution, cofactor) = (&unknowns.solution, &unknowns.cofactor);
        let dof = (part.fold.rows() + priors.len()).saturating_sub(unknowns.rank);
        let readings = if priors.is_empty() { None } else { Some(of_readings(cofactor, part.fold.triangle())) };
        let known = self.known(&rows, &factor, solution)?;
        let least = part.least();
        let extended = self.extended(&rows, solution, scaled.then_some(least))?;
        let scale = extended.as_ref().filter(|_| scaled && dof > 0).and_then(|solved| solved.scale.first().copied());
        let question = Question {
            asked: &self.asked,
            reference,
            known: &known,
            scaled,
            rank: unknowns.rank,
            dof,
            scale_dof: match (&extended, scale) {
                (Some(solved), Some(_)) => solved.redundancy.first().map_or(0.0, |r| r.max(NO_REDUNDANCY)),
                _ if scaled => dof as f64,
                _ => f64::INFINITY,
            },
        };
        let answer = Answer {
            label,
            device: None,
            unknowns: Some(&unknowns),
            dx: solution,
            cofactor,
            share: readings.as_ref().unwrap_or(cofactor),
            variance: scale.map(|scale| scale * scale).or_else(|| question.variance(squares, || least)),
            squares,
            tested: extended.map_or(squares, |solved| solved.sum_of_squares),
            readings: part.fold.rows(),
            largest: 0.0,
            lack_of_fit_p: None,
            runs_p: f64::NAN,
            normality_p: f64::NAN,
            suspects: Vec::new(),
            suspect_p: f64::NAN,
            stuck: Vec::new(),
            solved: Solved::Alone,
        };
        Ok(question.row(answer, coverage))
    }

    /// The rows beside the known inputs that have an uncertainty ([`crate::estimate::System::with_inputs`]), from which scale and tests come; `None` where there are none.
    fn extended(&self, rows: &Compressed, solution: &[f64], least: Option<f64>) -> Result<Option<Scaled>> {
        let n = self.asked.campaign.unknowns();
        let mut inputs: Vec<usize> = self.carried.iter().map(|carried| carried.parameter).collect();
        inputs.dedup();
        if inputs.is_empty() {
            return Ok(None);
        }
        let k = inputs.len();
        let extended = |block: &Block| {
            let mut own = Mat::zeros(block.rows.nrows(), n + k);
            own.subcols_mut(0, n).copy_from(block.rows.subcols(0, n));
            for (place, carried) in self.carried.iter().enumerate() {
                let Some(j) = inputs.iter().position(|own| *own == carried.parameter) else { continue };
                let share = carried.known.u * carried.by.map_or(1.0, |j| solution.at(j));
                let from = block.rows.col_as_slice(n + place);
                own.col_as_slice_mut(n + j).iter_mut().zip(from).for_each(|(to, c)| *to += share * c);
            }
            Block { rows: own, ..block.clone() }
        };
        let stated: Vec<(usize, f64, f64)> = (n..n + k).map(|j| (j, 0.0, 1.0)).collect();
        let blocks = rows.blocks.iter().map(extended).chain([Block::stated(n + k, &stated)]).collect();
        let least: Vec<f64> = least.into_iter().collect();
        let rows = Compressed::of(blocks, n + k, least.len());
        Ok(Some(rows.adjust(&ScaleHints { least: &least, ..ScaleHints::default() }, &self.asked.settings.adjust)?))
    }

    /// How the unknowns follow each known input that has an uncertainty: `-(dx/dy) df/dp` at the solution.
    fn known(&self, rows: &Compressed, factor: &Factor, solution: &[f64]) -> Result<Vec<Input>> {
        let mut found: Vec<Input> = Vec::new();
        for (place, carried) in self.carried.iter().enumerate() {
            let share = carried.by.map_or(1.0, |j| solution.at(j));
            let follow = rows.follow(factor, place)?;
            let Carried { parameter, known, .. } = *carried;
            if found.last().is_none_or(|last| last.index != parameter) {
                found.push(Input { index: parameter, known, base: vec![0.0; follow.len()], slope: Vec::new() });
            }
            // there is one: pushed above
            let base = found.last_mut().map(|last| last.base.as_mut_slice()).unwrap_or_default();
            base.iter_mut().zip(&follow).for_each(|(c, f)| *c -= share * f);
        }
        Ok(found)
    }
}

/// The part of the cofactor matrix that comes from the readings, whose triangle this is: `C R' R C`.
fn of_readings(cofactor: &Mat<f64>, triangle: MatRef<'_, f64>) -> Mat<f64> {
    let n = cofactor.nrows();
    let moved = triangle.subrows(0, n).subcols(0, n) * cofactor;
    moved.transpose() * &moved
}
