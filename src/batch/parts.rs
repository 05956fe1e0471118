//! One linear step for devices whose readings come in any order, in parts, or to several machines: the rows of a position once, a state that
//! merges, and a device's row from it.
//!
//! ```text
//! positions -> lines (a row of the design each) ;  lines + values -> Part ;  Part + Part -> Part ;  Part -> Row
//! ```
//!
//! A part is the triangle of a [`Fold`], whose size does not depend on the readings. What needs the readings themselves (robust weights,
//! constraints, scatter, closed circles, several scales to estimate, suspicious readings, lack of fit, runs) is not to be had from it.

use super::answer::{Answer, Coverage, Input, Question};
use super::common::{alone, is_linear, is_uncertain};
use super::{Row, Solved};
use crate::algebra::Tape;
use crate::campaign::{Campaign, Kind, Known, Observation, Readings, Role};
use crate::design::{self, Model};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{Block, Compressed, Fold, Folded, Group, NO_REDUNDANCY, ScaleHints, Scaled, Unknowns};
use crate::fit::{self, Estimator, Settings, Weighting};
use faer::{Mat, MatRef};

/// The linear step of a campaign, for readings that are not all at hand.
#[derive(Debug, Clone)]
pub struct Parts {
    template: Campaign,
    settings: Settings,
    model: Model,
    reference: Vec<f64>,
    carried: Vec<PropagatedCalibration>,
    derived: Vec<Tape>,
    /// Unknown, prior less its reference, standard uncertainty.
    priors: Vec<(usize, f64, f64)>,
}

/// A column that is carried along for the budget of a known input: `df/dp`, or how much it changes with an unknown.
#[derive(Debug, Clone, Copy)]
struct PropagatedCalibration {
    parameter: usize,
    known: Known,
    by: Option<usize>,
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
    /// Two epsilons of the largest value in units of its uncertainty.
    arithmetic: f64,
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
        if !(settings.level > 0.0 && settings.level < 1.0) {
            return Err(Malformed::new(Fault::Value, "the level is not a probability")
                .expected("a number between 0 and 1, for example 0.95")
                .found(settings.level.to_string()));
        }
        if let Err((what, path)) = alone(template, settings) {
            return refuse(&what, path);
        }
        if !is_linear(template) {
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
            if is_uncertain(template) {
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
        let ids: Vec<&str> = template.parameters.iter().map(|p| p.id.as_str()).collect();
        let derived = template.derived.iter().map(|d| Tape::compile(&d.line, &ids)).collect::<Result<_>>()?;
        let reference = template.reference_point();
        let priors = template
            .estimated()
            .iter()
            .zip(&reference)
            .enumerate()
            .filter_map(|(k, (parameter, reference))| match &parameter.role {
                Role::Estimated { prior: Some(prior), .. } => Some((k, prior.value - reference, prior.u)),
                _ => None,
            })
            .collect();
        Ok(Parts {
            model: Model::new(template)?,
            template: template.with_readings(Readings { columns: template.readings.columns.clone(), rows: Vec::new() }),
            settings: *settings,
            carried: carried(template),
            derived,
            reference,
            priors,
        })
    }

    /// The campaign, without readings.
    pub fn campaign(&self) -> &Campaign {
        &self.template
    }

    /// The lines of some readings, one for each value.
    ///
    /// Errors: readings that no fit takes; a model line without a value there.
    pub fn lines(&self, readings: Readings) -> Result<Vec<DesignRow>> {
        let campaign = self.template.with_readings(readings);
        fit::askable(&campaign)?;
        let design = design::assemble(&campaign, &self.model, &self.reference)?;
        fit::check_rows(&campaign, &self.model, &design)?;
        let n = campaign.unknowns();
        let mut moved = Vec::new();
        for carried in &self.carried {
            let mut point = self.reference.clone();
            if let Some(x) = carried.by.and_then(|j| point.get_mut(j)) {
                *x += 1.0;
                moved.push(Some(design::assemble(&campaign, &self.model, &point)?));
            } else {
                moved.push(None);
            }
        }
        let columns = |i: usize| -> Vec<f64> {
            let derivatives = (0..n).map(|j| design.jacobian[(i, j)]);
            let further = self.carried.iter().zip(&moved).map(|(carried, moved)| {
                let here = design.jacobian[(i, carried.parameter)];
                moved.as_ref().map_or(here, |moved| moved.jacobian[(i, carried.parameter)] - here)
            });
            derivatives.chain(further).collect()
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
            fold: Fold::carrying(self.template.unknowns(), self.carried.len()),
            met: vec![[false; 2]; self.template.bench.sensors.len()],
            largest: 0.0,
            arithmetic: 0.0,
            largest_u: 0.0,
            step: None,
        }
    }

    /// Values read, each with its line.
    ///
    /// Errors: lines of another campaign; values and uncertainties that no fit takes.
    pub fn push(&self, part: &mut Part, values: &[(&DesignRow, Observation)]) -> Result<()> {
        let (k, n) = (values.len(), self.template.unknowns() + self.carried.len());
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
            if value.u.is_none() || self.settings.weighting == Weighting::Relative {
                part.arithmetic = part.arithmetic.max(2.0 * f64::EPSILON * value.value.abs() / u(value));
                part.largest_u = part.largest_u.max(u(value));
                if !self.template.bench.sensors.get(value.sensor).is_some_and(crate::bench::Sensor::is_reference) {
                    part.step = Some(finer(part.step, value.value));
                }
            }
        }
        Ok(())
    }

    /// The part of a device that was packed. Errors: numbers that are no part of this campaign.
    pub fn unpack(&self, packed: &[f64]) -> Result<Part> {
        let mut part = self.nothing();
        let [largest, arithmetic, largest_u, step, rest @ ..] = packed else {
            return Err(Malformed::new(Fault::Value, "these numbers are no part of a device"));
        };
        // too short: refused by `unpack`
        let (met, fold) = rest.split_at_checked(part.met.len()).unwrap_or_default();
        part.fold = Fold::unpack(self.template.unknowns(), self.carried.len(), fold)?;
        part.met = met.iter().map(|code| [code % 2.0 >= 1.0, *code >= 2.0]).collect();
        (part.largest, part.arithmetic, part.largest_u) = (*largest, *arithmetic, *largest_u);
        part.step = if *step == f64::NEG_INFINITY { None } else { Some(*step) };
        Ok(part)
    }
}

/// What is carried along: `df/dp` of every known input with an uncertainty, and its derivative by each unknown that it depends on.
fn carried(campaign: &Campaign) -> Vec<PropagatedCalibration> {
    let mut list = Vec::new();
    for (parameter, input) in campaign.parameters.iter().enumerate() {
        let Role::Known(known) = input.role else { continue };
        if known.u == 0.0 {
            continue;
        }
        list.push(PropagatedCalibration { parameter, known, by: None });
        for (j, unknown) in campaign.estimated().iter().enumerate() {
            let both = [input.id.as_str(), unknown.id.as_str()];
            let apart = input.kind == Kind::Coefficient
                && campaign.bench.sensors.iter().all(|sensor| sensor.model.linear_in(&both));
            if !apart {
                list.push(PropagatedCalibration { parameter, known, by: Some(j) });
            }
        }
    }
    list
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
        self.arithmetic = self.arithmetic.max(other.arithmetic);
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
        let mut numbers = vec![self.largest, self.arithmetic, self.largest_u, self.step.unwrap_or(f64::NEG_INFINITY)];
        numbers.extend(self.met.iter().map(|[with, without]| f64::from(u8::from(*with) + 2 * u8::from(*without))));
        numbers.extend(self.fold.pack());
        numbers
    }

    /// The square of the scale that the rounding of the readings alone would have.
    fn least(&self) -> f64 {
        // numbers of full precision have no step
        let step = self.step.filter(|step| !step.is_nan()).unwrap_or(0.0);
        self.arithmetic.powi(2).max((step / 12f64.sqrt() / self.largest_u).powi(2))
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
        let quantities = self.template.unknowns() + self.derived.len();
        self.row(label, part, coverage).unwrap_or_else(|error| Row::without(label, quantities, &error))
    }

    /// Is the scatter of the readings estimated from them?
    fn is_scaled(&self, part: &Part) -> Result<bool> {
        let sensors = || self.template.bench.sensors.iter().zip(&part.met);
        if let Some((sensor, _)) = sensors().find(|(_, met)| **met == [true, true]) {
            let id = &sensor.id;
            return Err(Malformed::new(
                Fault::Missing,
                format!("some readings of {id} have a stated uncertainty and some have none"),
            )
            .expected(format!(
                "{id}_u in every reading of {id}, or in none (then it is estimated from the residuals)"
            )));
        }
        let relative = self.settings.weighting == Weighting::Relative;
        let read: Vec<bool> =
            sensors().filter(|(_, met)| **met != [false, false]).map(|(_, met)| relative || met[1]).collect();
        match read.as_slice() {
            [] => {
                let ids: Vec<&str> = self.template.bench.sensors.iter().map(|s| s.id.as_str()).collect();
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
        let (template, settings) = (&self.template, &self.settings);
        let n = template.unknowns();
        let scaled = self.is_scaled(part)?;
        if part.largest > 0.0 && part.largest < fit::LEAST {
            return Err(Malformed::new(
                Fault::Value,
                "the largest reading is beyond the numbers that a fit can square",
            )
            .expected("units in which it lies between 1e-70 and 1e70")
            .found(format!("{:e}", part.largest)));
        }
        let joined;
        let fold = if self.priors.is_empty() {
            &part.fold
        } else {
            let mut fold = part.fold.clone();
            for (k, difference, u) in &self.priors {
                let row = Mat::from_fn(1, n + self.carried.len(), |_, j| f64::from(u8::from(j == *k)));
                fold.push(row.as_ref(), &[*difference], &[*u])?;
            }
            joined = fold;
            &joined
        };
        let group = if scaled { Group::Estimated(0) } else { Group::Known };
        let folded = fold.finish(group, &settings.adjust)?;
        let (dof, squares) = (folded.dof, folded.sum_of_squares);
        let Unknowns { solution, cofactor, .. } = &folded.unknowns;
        let readings = if self.priors.is_empty() { None } else { Some(of_readings(cofactor, part.fold.triangle())) };
        let known = self.known(fold, &folded)?;
        let least = part.least();
        let extended = self.extended(fold, solution, scaled.then_some(least))?;
        let scale = extended.as_ref().filter(|_| scaled && dof > 0).and_then(|solved| solved.scale.first().copied());
        let question = Question {
            campaign: template,
            settings,
            derived: &self.derived,
            reference: &self.reference,
            known: &known,
            scaled,
            rank: folded.unknowns.rank,
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
            unknowns: Some(&folded.unknowns),
            dx: solution,
            cofactor,
            share: readings.as_ref().unwrap_or(cofactor),
            variance: scale.map(|scale| scale * scale).or_else(|| question.variance(squares, |_| least)),
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
    fn extended(&self, fold: &Fold, solution: &[f64], least: Option<f64>) -> Result<Option<Scaled>> {
        let (n, triangle) = (self.template.unknowns(), fold.triangle());
        let last = triangle.ncols() - 1;
        let mut inputs: Vec<(usize, Vec<f64>)> = Vec::new();
        for (place, carried) in self.carried.iter().enumerate() {
            let share = carried.known.u * carried.by.map_or(1.0, |j| solution.at(j));
            let added = triangle.col(n + place).iter().map(|c| share * c);
            match inputs.last_mut().filter(|(parameter, _)| *parameter == carried.parameter) {
                Some((_, whole)) => whole.iter_mut().zip(added).for_each(|(to, c)| *to += c),
                None => inputs.push((carried.parameter, added.collect())),
            }
        }
        if inputs.is_empty() {
            return Ok(None);
        }
        let k = inputs.len();
        let of = |i: usize, j: usize| inputs.get(j).and_then(|(_, column)| column.get(i)).copied().unwrap_or(0.0);
        let readings = Block {
            rows: Mat::from_fn(last + 1, n + k, |i, j| j.checked_sub(n).map_or(triangle[(i, j)], |j| of(i, j))),
            observed: triangle.col(last).iter().copied().collect(),
            size: fold.rows(),
            own: None,
            magnitude: 0.0,
            log_determinant: 0.0,
        };
        let stated = Block {
            rows: Mat::from_fn(k, n + k, |i, j| f64::from(u8::from(i + n == j))),
            observed: vec![0.0; k],
            size: k,
            ..readings.clone()
        };
        let least: Vec<f64> = least.iter().map(|variance| variance.sqrt()).collect();
        let rows = Compressed::of(vec![readings, stated], n + k, least.len());
        Ok(Some(rows.adjust(&ScaleHints { least: &least, ..ScaleHints::default() }, &self.settings.adjust)?))
    }

    /// How the unknowns follow each known input that has an uncertainty: `-(dx/dy) df/dp` at the solution.
    fn known(&self, fold: &Fold, folded: &Folded) -> Result<Vec<Input>> {
        let mut found: Vec<Input> = Vec::new();
        for (place, carried) in self.carried.iter().enumerate() {
            let share = carried.by.map_or(1.0, |j| folded.unknowns.solution.at(j));
            let Some(follow) = fold.follow(place, &self.settings.adjust)? else { continue };
            let PropagatedCalibration { parameter, known, .. } = *carried;
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
