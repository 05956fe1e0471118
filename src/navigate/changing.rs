//! Columns of all causes: constants from the linear error equations, errors that change in time from the same signatures, faults of the
//! reference from themselves.
//!
//! A bias `x f(t)` is a constant one that starts anew at each moment:
//!
//! ```text
//! c(t) = Psi(t) int_0^t f(s) dg(s),      g(s) = Psi(s)^-1 S(s)
//! ```
//!
//! with `S` the signature of the constant bias and `Psi` the signatures of the start, which propagate an error (Duhamel). `g` is as slow as a
//! Schuler oscillation and is taken straight between the times of a grid, over which the mean of `f` is exact: a fast `f` costs no accuracy.
#![allow(
    clippy::indexing_slicing,
    reason = "channels are arrays of `CHANNELS` numbers, indexed by `from_fn` over that length"
)]

use super::cause::{Cause, Change};
use super::errors::{ErrorSource, ImuErrors};
use super::instant::{Instant, Matrix, SIZE, scaled};
use super::measured::{self, CHANNELS, Channels, Measured};
use super::mission::Mission;
use super::shortened::Shortened;
use super::signatures::{instants, motion, predicted_together, times};
use super::whiten::{Walks, carried as carried_walks};
use crate::elements::Elements;
use crate::number;
use nalgebra::SVector;

type Vector = SVector<f64, CHANNELS>;

/// Times at which integrals are taken, at least.
const GRID: f64 = 1000.0;

/// What the causes' columns are made of.
#[derive(Clone)]
pub(super) struct Columns {
    runs: Vec<Run>,
    /// Random walks of the mission at the measured rows.
    pub walks: Walks,
    sources: Vec<ErrorSource>,
}

/// One run.
#[derive(Clone)]
struct Run {
    /// Times of the rows, and which channels were measured there.
    rows: Vec<(f64, [bool; CHANNELS])>,
    /// At each row.
    at_rows: Vec<Instant>,
    /// Times of the grid, and for each bias `Psi^-1 S`, scaled, there.
    grid: Vec<f64>,
    carried: Vec<Vec<Vector>>,
    /// `Psi`, scaled, at each row, and for each bias `Psi^-1 S` there.
    psi: Vec<Matrix>,
    carried_to_rows: Vec<Vec<Vector>>,
}

impl Run {
    fn new(
        mission: &Mission,
        run: &measured::Run,
        row_times: &[f64],
        instants: impl Fn(&[f64]) -> Vec<Instant>,
    ) -> Run {
        // a run without rows ends where it starts
        let end = row_times.last().copied().unwrap_or_default();
        let step = (mission.duration() / GRID).max(2.0 * mission.step_s);
        let count = number::count((end / step).ceil().max(1.0));
        let grid: Vec<f64> = (0..=count).map(|k| (k as f64 * step).min(end)).collect();
        // both lists are in rising order; one pass serves both
        let mut union: Vec<(f64, bool)> =
            row_times.iter().map(|time| (*time, true)).chain(grid.iter().map(|time| (*time, false))).collect();
        union.sort_by(|a, b| a.0.total_cmp(&b.0));
        let all: Vec<f64> = union.iter().map(|(time, _)| *time).collect();
        let (mut at_rows, mut on_grid) = (Vec::new(), Vec::new());
        for ((_, is_row), instant) in union.iter().zip(instants(&all)) {
            if *is_row { at_rows.push(instant) } else { on_grid.push(instant) }
        }
        let of_biases = |instants: &[Instant]| -> Vec<Vec<Vector>> {
            let of = |j: usize| instants.iter().map(|instant| carried(instant, j)).collect();
            ErrorSource::bias_indices().into_iter().map(of).collect()
        };
        let (carried, carried_to_rows) = (of_biases(&on_grid), of_biases(&at_rows));
        let psi = at_rows.iter().map(|instant| scaled(&instant.start())).collect();
        Run { rows: measured_at(run), at_rows, grid, carried, psi, carried_to_rows }
    }
}

impl Columns {
    pub fn new(mission: &Mission, measured: &Measured) -> Columns {
        let sources = ErrorSource::catalogue();
        let (mut runs, mut walks) = (Vec::new(), Walks::default());
        for (run, row_times) in measured.runs.iter().zip(times(measured)) {
            let at = |times: &[f64]| instants(mission, motion(mission, run.motion), times);
            let made = Run::new(mission, run, &row_times, at);
            if mission.errors.is_noisy() {
                walks.instants.push(made.at_rows.clone());
            }
            runs.push(made);
        }
        Columns { runs, walks, sources }
    }

    /// The same around other errors than none: differences of the full simulation by a step of each source.
    pub fn around(&self, mission: &Mission, measured: &Measured, errors: &ImuErrors, steps: &[f64]) -> Columns {
        let mut flights = vec![*errors];
        for (source, step) in self.sources.iter().zip(steps) {
            let mut moved = *errors;
            source.set(&mut moved, source.of(errors) + step);
            flights.push(moved);
        }
        let mut runs = Vec::new();
        for (run, row_times) in measured.runs.iter().zip(times(measured)) {
            runs.push(Run::new(mission, run, &row_times, |all| {
                let flown = predicted_together(mission, motion(mission, run.motion), &flights, all);
                let Some((base, others)) = flown.split_first() else { return Vec::new() };
                let derivative = |row: usize, base: &Channels| -> Vec<Channels> {
                    let one = |(moved, step): (&Vec<Channels>, &f64)| {
                        // as many rows as the base has: flown together
                        let moved = moved.get(row).copied().unwrap_or(*base);
                        std::array::from_fn(|c| (moved[c] - base[c]) / step)
                    };
                    others.iter().zip(steps).map(one).collect()
                };
                let one =
                    |(row, base)| Instant { signatures: derivative(row, base), walk: [[0.0; CHANNELS]; CHANNELS] };
                base.iter().enumerate().map(one).collect()
            }));
        }
        let mut columns = Columns { runs, walks: Walks::default(), sources: self.sources.clone() };
        columns.walks = Walks { instants: columns.carrying(&self.walks.instants), biases: self.walks.biases };
        columns
    }

    /// The same of a record in fewer rows.
    pub(super) fn shortened(&self, short: &Shortened) -> Columns {
        let mean = |vectors: &[Vector]| vectors.iter().sum::<Vector>() / vectors.len() as f64;
        let run = |(k, (whole, measured)): (usize, (&Run, &measured::Run))| Run {
            rows: measured_at(measured),
            at_rows: short.means(k, &whole.at_rows, Instant::mean),
            grid: whole.grid.clone(),
            carried: whole.carried.clone(),
            psi: short.means(k, &whole.psi, |all| all.iter().sum::<Matrix>() / all.len() as f64),
            carried_to_rows: whole.carried_to_rows.iter().map(|vectors| short.means(k, vectors, mean)).collect(),
        };
        let runs = self.runs.iter().zip(&short.measured.runs).enumerate().map(run).collect();
        let walks = Walks { instants: short.instants(&self.walks.instants), biases: self.walks.biases };
        Columns { runs, walks, sources: self.sources.clone() }
    }

    /// Random walks as they propagate along the errors that these columns are around.
    pub fn carrying(&self, instants: &[Vec<Instant>]) -> Vec<Vec<Instant>> {
        instants.iter().zip(&self.runs).map(|(old, run)| carried_walks(old, &run.at_rows)).collect()
    }

    /// The same with other random walks.
    pub fn walking(&self, walks: Walks) -> Columns {
        Columns { walks, ..self.clone() }
    }

    /// The column of a cause: SI of the channel per SI of the cause, all runs after one another.
    pub fn of(&self, cause: &Cause) -> Vec<f64> {
        let mut column = Vec::new();
        for run in &self.runs {
            let values: Vec<Channels> = match cause {
                Cause::Constant(source) => {
                    let j = self.sources.iter().position(|other| other == source).unwrap_or(usize::MAX);
                    run.at_rows.iter().map(|instant| instant.signatures.at(j)).collect()
                }
                Cause::Changing(source, change) => self.course(run, source, *change),
                Cause::Reference(channel, change) => {
                    let value = |time: f64| change.map_or(1.0, |change| change.at(time));
                    let one = |time: f64| std::array::from_fn(|c| if c == *channel { value(time) } else { 0.0 });
                    run.rows.iter().map(|(time, _)| one(*time)).collect()
                }
                // a random walk has no column: it is of the noise
                Cause::RandomWalk(_) | Cause::BiasWalk(..) | Cause::Reading { .. } => {
                    vec![[0.0; CHANNELS]; run.rows.len()]
                }
            };
            for ((_, measured), value) in run.rows.iter().zip(values) {
                column.extend(value.iter().zip(measured).filter(|(_, measured)| **measured).map(|(value, _)| *value));
            }
        }
        if let Cause::Reading { at, .. } = cause {
            column.get_mut(*at).into_iter().for_each(|slot| *slot = 1.0);
        }
        column
    }

    /// A bias that changes.
    fn course(&self, run: &Run, source: &ErrorSource, change: Change) -> Vec<Channels> {
        let Some(j) = self.sources.iter().position(|other| other == source) else { return Vec::new() };
        let place = ErrorSource::bias_indices().iter().position(|index| *index == j);
        let Some((carried, to_rows)) = place.and_then(|k| run.carried.get(k).zip(run.carried_to_rows.get(k))) else {
            return vec![[0.0; CHANNELS]; run.rows.len()];
        };
        // the integral up to the last time of the grid before each row, and on to the row
        let mut integral = Vector::zeros();
        let mut next = 0;
        let mut before: Option<(f64, Vector)> = None;
        let mut values = Vec::with_capacity(run.rows.len());
        for ((time, _), (psi, to_row)) in run.rows.iter().zip(run.psi.iter().zip(to_rows)) {
            while let (Some(at), Some(g)) = (run.grid.get(next), carried.get(next)) {
                if *at > *time {
                    break;
                }
                if let Some((last, old)) = before {
                    integral += (g - old) * change.mean(last, *at);
                }
                before = Some((*at, *g));
                next += 1;
            }
            let last_part = before
                .filter(|(last, _)| time > last)
                .map_or(Vector::zeros(), |(last, old)| (to_row - old) * change.mean(last, *time));
            let all = psi * (integral + last_part);
            values.push(std::array::from_fn(|i| SIZE[i] * all[i]));
        }
        values
    }
}

/// Times of the rows of a run, and which channels were measured there.
fn measured_at(run: &measured::Run) -> Vec<(f64, [bool; CHANNELS])> {
    run.rows.iter().map(|row| (row.time, row.value.map(|v| v.is_some()))).collect()
}

/// `Psi^-1 S` of one source, scaled.
fn carried(instant: &Instant, j: usize) -> Vector {
    let signature = instant.signatures.at(j);
    let signature = Vector::from_fn(|i, _| signature[i] / SIZE[i]);
    // at the start itself nothing has moved: singular, and nothing is carried
    scaled(&instant.start()).lu().solve(&signature).unwrap_or_else(Vector::zeros)
}
