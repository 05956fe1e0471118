//! Rows of a schedule made independent of each other: as they are judged, and as pools, checks and comparisons of positions are adjusted from.
//!
//! Deviations that link positions: one for the whole campaign, or for each day, operator, instrument. Positions that share one are not
//! independent, so their information is not additive. With the deviation as one more unknown that has the prior value `0` with its standard
//! deviation, it is:
//!
//! ```text
//! [A Z; 0 1/s] in the unknowns (x, d):     (M^-1)_xx = (A' (R + s^2 Z Z')^-1 A)^-1       (C. R. Henderson, Biometrics 31 (1975) 423)
//! ```
//!
//! Criteria are functions of the parameters alone, not of the deviations.
#![allow(
    clippy::indexing_slicing,
    reason = "a design has one row of its derivatives for each of its readings, and priors follow; `with_priors` and `whitened` make every row as long as the unknowns and the terms, and columns as long as the rows"
)]

use super::effort::{Noise, mountings};
use crate::campaign::{Campaign, Per, Reading, Readings};
use crate::design::{self, DesignMatrix, Model};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{self, Estimate, Felt, Pattern, ScatterLine, System, Whitening, product_by_rows};
use crate::fit;
use crate::simulate::{self, Regressor};
use faer::Mat;
use std::collections::{HashMap, HashSet};

/// Rows of readings and priors, whitened: no column for any deviation, whatever their number.
pub(crate) struct Independent {
    /// The rows; of unit variance where anything scatters.
    pub system: System,
    /// Standard deviation of each row's independent noise.
    pub u: Vec<f64>,
    whitening: Option<Whitening>,
}

impl Independent {
    /// The rows of a design.
    pub fn new(campaign: &Campaign, design: &DesignMatrix, noise: &Noise) -> Self {
        let n = campaign.unknowns();
        let (m, priors) = (design.rows.len(), campaign.priors().collect::<Vec<_>>());
        let (mut u, lines, variance) = parts(campaign, design, noise);
        u.extend(priors.iter().map(|(.., u)| *u));
        let total = m + priors.len();
        let mut rows = Mat::zeros(total, n);
        for j in 0..n {
            rows.col_as_slice_mut(j)[..m].copy_from_slice(&design.jacobian.col_as_slice(j)[..m]);
        }
        for (p, (k, ..)) in priors.iter().enumerate() {
            rows[(m + p, *k)] = 1.0;
        }
        let felt = lines.iter().any(|line| !line.felt.is_empty());
        let whitening = felt.then(|| Whitening::new(&Pattern::new(total, &lines), &u, &lines, &variance));
        let system = match &whitening {
            Some(whitening) => unobserved(whitening.whiten_columns(&rows), vec![1.0; total]),
            None => unobserved(rows, u.clone()),
        };
        Independent { system, u, whitening }
    }

    /// The adjustment, meeting the campaign's equations.
    pub fn adjust(&self, campaign: &Campaign, design: &DesignMatrix) -> Result<Estimate> {
        fit::adjust_meeting_equations(campaign, &design.point, &self.system, &UNREFINED)
    }

    /// The rows of a campaign's positions at a point, and their adjustment.
    pub fn at(campaign: &Campaign, point: &[f64], noise: &Noise) -> Result<(DesignMatrix, Self, Estimate)> {
        let design = design::assemble(campaign, &Model::new(campaign)?, point)?;
        let rows = Independent::new(campaign, &design, noise);
        let estimate = rows.adjust(campaign, &design)?;
        Ok((design, rows, estimate))
    }

    /// A column of the readings (as long as all rows) as the adjusted rows have it.
    pub fn column(&self, column: Vec<f64>) -> Vec<f64> {
        match &self.whitening {
            Some(whitening) => whitening.whiten(&column),
            None => column,
        }
    }

    /// A column of the readings (a shorter one: zero beyond) as independent values of unit variance.
    pub fn white(&self, column: &[f64]) -> Vec<f64> {
        let mut column = column.to_vec();
        column.resize(self.u.len(), 0.0);
        let column = self.column(column);
        column.iter().zip(&self.system.u).map(|(v, u)| v / u).collect()
    }

    /// Are the rows independent as they are read?
    pub fn is_apart(&self) -> bool {
        self.whitening.is_none()
    }

    /// `d x / d y` by the rows as they are read.
    pub fn sensitivities(&self, estimate: &Estimate) -> Mat<f64> {
        let Some(whitening) = &self.whitening else { return estimate.factor.sensitivities() };
        let (q, directions) = (estimate.factor.thin_q(), estimate.factor.whitened_directions());
        let mut back = Mat::zeros(q.nrows(), q.ncols());
        for k in 0..q.ncols() {
            let column: Vec<f64> = q.col(k).iter().copied().collect();
            back.col_as_slice_mut(k).copy_from_slice(&whitening.carry_back(&column));
        }
        product_by_rows(directions.as_ref(), back.as_ref())
    }

    /// Redundancy number of each row, with deviations as unknowns that have one row each.
    pub fn redundancies(&self, estimate: &Estimate) -> Vec<f64> {
        match &self.whitening {
            Some(whitening) => whitening.redundancies(estimate.factor.thin_q()),
            None => estimate.redundancy.clone(),
        }
    }
}

/// An effect that the model may lack: one more unknown, its coefficient.
#[derive(Debug, Clone, PartialEq)]
pub struct Term {
    /// The sensor that may have it; `None` for all.
    pub sensor: Option<usize>,
    /// What goes with the coefficient, for example `a_S`.
    pub regressor: Regressor,
}

/// The unknowns of the augmented model after the estimated parameters: first deviations that link positions, then effects that the model may lack.
#[derive(Debug, Clone, Default)]
pub(super) struct Augmentation {
    /// Deviations, each with the prior value zero and its standard deviation.
    pub deviations: Vec<Deviation>,
    /// Effects, without prior.
    pub terms: Vec<Term>,
}

/// A deviation that positions share.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Deviation {
    /// The campaign's line, by index.
    line: usize,
    /// Its level.
    level: String,
    /// Standard deviation.
    sd: f64,
}

impl Augmentation {
    /// The deviations that all these readings share, in order of occurrence, and effects. A line without variance has none.
    pub fn new(campaign: &Campaign, noise: &Noise, terms: &[Term], sets: &[&Readings]) -> Self {
        let mut deviations: Vec<Deviation> = Vec::new();
        for (k, line) in campaign.scatter.iter().enumerate().filter(|(k, _)| links(campaign, *k)) {
            let Some(sd) = noise.lines.get(k).map(|variance| variance.sqrt()).filter(|sd| *sd > 0.0) else { continue };
            let mut seen: HashSet<String> = HashSet::new();
            for level in sets.iter().flat_map(|set| set.rows.iter().filter_map(|row| line.per.level_name(set, row))) {
                if seen.insert(level.to_string()) {
                    deviations.push(Deviation { line: k, level: level.into_owned(), sd });
                }
            }
        }
        Augmentation { deviations, terms: terms.to_vec() }
    }

    /// Parameters and deviations: what a fit of the rows estimates.
    pub fn fitted(&self, campaign: &Campaign) -> usize {
        campaign.unknowns() + self.deviations.len()
    }

    /// All columns of a row.
    pub fn columns(&self, campaign: &Campaign) -> usize {
        self.fitted(campaign) + self.terms.len()
    }

    /// Derivative of each row of a design with respect to each deviation; `lines` are the campaign's at that design.
    fn felt(&self, campaign: &Campaign, design: &DesignMatrix, lines: &[ScatterLine]) -> Vec<Vec<f64>> {
        let readings = &campaign.readings;
        let mut columns = vec![vec![0.0; design.rows.len()]; self.deviations.len()];
        let place: HashMap<(usize, &str), usize> =
            self.deviations.iter().enumerate().map(|(at, d)| ((d.line, d.level.as_str()), at)).collect();
        for (k, (s, line)) in campaign.scatter.iter().zip(lines).enumerate().filter(|(k, _)| links(campaign, *k)) {
            for felt in &line.felt {
                let reading = design.rows.get(felt.row).and_then(|origin| readings.rows.get(origin.reading));
                let level = reading.and_then(|reading| s.per.level_name(readings, reading));
                let column = level.and_then(|level| place.get(&(k, &*level)).copied());
                if let Some(slot) = column.and_then(|at| columns.get_mut(at)?.get_mut(felt.row)) {
                    *slot += felt.by;
                }
            }
        }
        columns
    }
}

/// Rows of positions that are kept, then those of the priors of parameters and deviations; terms have no prior.
pub(super) fn with_priors(
    campaign: &Campaign,
    kept: &Readings,
    noise: &Noise,
    augmentation: &Augmentation,
) -> Result<Vec<Vec<f64>>> {
    let (n, parameters) = (augmentation.columns(campaign), campaign.unknowns());
    let mut rows = whitened(campaign, kept, noise, augmentation, false)?;
    rows.extend(campaign.priors().map(|(k, _, u)| single(n, k, 1.0 / u)));
    rows.extend(augmentation.deviations.iter().enumerate().map(|(k, d)| single(n, parameters + k, 1.0 / d.sd)));
    Ok(rows)
}

/// A row with one element.
pub(super) fn single(n: usize, k: usize, value: f64) -> Vec<f64> {
    (0..n).map(|j| if j == k { value } else { 0.0 }).collect()
}

/// Portions one after the other without their values, each a separate mounting.
pub(super) fn mounted_apart(portions: &[Vec<Reading>], columns: &Readings) -> Readings {
    let rows = portions
        .iter()
        .enumerate()
        .flat_map(|(p, portion)| portion.iter().map(move |r| Reading { position: p.to_string().into(), ..r.unread() }))
        .collect();
    Readings { columns: columns.columns.clone(), rows }
}

/// The first `n` columns of whitened rows, adjusted with the campaign's equations: nothing is observed, all is in the covariance and the factor.
pub(super) fn adjusted(campaign: &Campaign, rows: &[Vec<f64>], n: usize) -> Result<Estimate> {
    let system = unobserved(Mat::from_fn(rows.len(), n, |i, j| rows[i][j]), vec![1.0; rows.len()]);
    fit::adjust_meeting_equations(campaign, &campaign.reference_point(), &system, &UNREFINED)
}

/// Rows without values.
fn unobserved(rows: Mat<f64>, u: Vec<f64>) -> System {
    System::known(rows, vec![0.0; u.len()], u)
}

/// Nothing is observed, so there is no solution to refine.
const UNREFINED: estimate::Settings = estimate::Settings { rank_tolerance: None, refinements: 0, group_iterations: 0 };

/// Rows made independent of each other, mounting by mounting, in the order of the readings; after the columns of the parameters those of the
/// deviations that link positions, then those of terms.
///
/// `further`: positions that are still to be taken. Where no reading has a value, every sensor is read at each.
pub(super) fn whitened(
    campaign: &Campaign,
    readings: &Readings,
    noise: &Noise,
    augmentation: &Augmentation,
    further: bool,
) -> Result<Vec<Vec<f64>>> {
    if readings.rows.is_empty() {
        return Ok(Vec::new());
    }
    let schedule = campaign.with_readings(readings.clone());
    let model = Model::new(&schedule)?;
    let point = schedule.reference_point();
    let design = design::assemble(&schedule, &model, &point)?;
    let n = campaign.unknowns();
    let columns = term_columns(&schedule, &model, &design, &augmentation.terms, further)?;
    if let Some(line) = schedule.scatter.iter().find(|line| line.over.is_some()) {
        return Err(Malformed::new(
            Fault::Value,
            format!("positions cannot be chosen where {} links them by the time between them", line.name(&schedule)),
        )
        .expected("lines of \"scatter\" without \"over\"; with \"over\", a schedule with its times can be evaluated, not improved")
        .at_path(line.place.clone()));
    }
    let (u, lines, variance) = parts(&schedule, &design, noise);
    let deviations = augmentation.felt(&schedule, &design, &lines);
    // lines that link positions have columns instead
    let within = lines.into_iter().zip(variance).enumerate().filter(|(k, _)| !links(&schedule, *k));
    let (lines, variance): (Vec<ScatterLine>, Vec<f64>) = within.map(|(_, pair)| pair).unzip();
    let whitening = Whitening::new(&Pattern::new(u.len(), &lines), &u, &lines, &variance);
    let white: Vec<Vec<f64>> = (0..n)
        .map(|j| whitening.whiten(design.jacobian.col_as_slice(j)))
        .chain(deviations.iter().chain(&columns).map(|column| whitening.whiten(column)))
        .collect();
    Ok((0..u.len()).map(|i| white.iter().map(|column| column[i]).collect()).collect())
}

/// The part of each row's noise that is independent of other rows; random effects, with their variances: the campaign's lines, and the scatter of every
/// remounting.
fn parts(campaign: &Campaign, design: &DesignMatrix, noise: &Noise) -> (Vec<f64>, Vec<ScatterLine>, Vec<f64>) {
    let rows = &campaign.readings.rows;
    let of = |origin: &design::RowOrigin| rows.get(origin.reading).map_or(1.0, |r| noise.u(r, origin.sensor));
    let u: Vec<f64> = design.rows.iter().map(of).collect();
    let mut lines = fit::scatter_lines(campaign, design, &u);
    let mut variance = noise.lines.clone();
    variance.resize(lines.len(), 0.0);
    let mounting_of = mountings(rows);
    for (k, sd) in &noise.remount {
        let felt = design.rows.iter().enumerate().map(|(row, origin)| Felt {
            row,
            level: mounting_of.at(origin.reading),
            by: design.jacobian[(row, *k)],
        });
        lines.push(ScatterLine { felt: felt.collect(), variance: Some(sd * sd), memory: None });
        variance.push(sd * sd);
    }
    (fit::own_noise(campaign, design, &u), lines, variance)
}

/// Columns of effects at the rows of a schedule. At further positions, effects of readings already taken (one bad reading, a remounting,
/// the approach) are zero.
fn term_columns(
    schedule: &Campaign,
    model: &Model,
    design: &DesignMatrix,
    terms: &[Term],
    further: bool,
) -> Result<Vec<Vec<f64>>> {
    let tilts = model.tilts_of(&design.point);
    let wanted: Vec<(&Regressor, Option<usize>)> = terms.iter().map(|term| (&term.regressor, term.sensor)).collect();
    let mut columns = simulate::columns(schedule, &design.rows, &tilts, &design.point, &wanted)?;
    for (column, term) in columns.iter_mut().zip(terms) {
        match &term.regressor {
            Regressor::Tilt(k) | Regressor::Known(k) if *k < design.jacobian.ncols() => {
                column.iter_mut().zip(design.jacobian.col(*k).iter()).for_each(|(slot, v)| *slot = *v);
            }
            Regressor::Term(_) => {}
            _ if further => column.fill(0.0),
            _ => {}
        }
    }
    Ok(columns)
}

/// Does a line of scatter have deviations that positions share?
pub(super) fn links(campaign: &Campaign, line: usize) -> bool {
    campaign.scatter.get(line).is_some_and(|line| !matches!(line.per, Per::Reading | Per::Position))
}

/// The levels of a reading in the columns by which positions share deviations: another day is another mounting. Empty without such columns.
pub(super) fn level_of(campaign: &Campaign, readings: &Readings, reading: &Reading) -> String {
    let by_column = campaign.scatter.iter().filter(|line| matches!(line.per, Per::Column(_)));
    let names: Vec<String> = by_column
        .map(|line| line.per.level_name(readings, reading).map_or(String::new(), |name| name.into_owned()))
        .collect();
    names.join("\n")
}
