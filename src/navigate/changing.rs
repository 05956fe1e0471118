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
use super::measured::{self, CHANNELS, Channels, Measured};
use super::mission::Mission;
use super::shortened::Shortened;
use super::signatures::{instants, motion, predicted_together, times};
use super::whiten::{Instant, Matrix, SIZE, Walks, carried as carried_walks, scaled};
use crate::elements::Elements;
use crate::number;
use nalgebra::SVector;
use std::cell::OnceCell;

type Vector = SVector<f64, CHANNELS>;

/// Times at which integrals are taken, at least.
const GRID: f64 = 1000.0;

/// What the causes' columns are made of.
#[derive(Clone)]
pub(super) struct Columns {
    runs: Vec<Run>,
    /// Random walks of the mission at the measured rows.
    pub walks: Walks,
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

/// How something changes: what the columns of all causes that change so are made of.
pub(super) struct Course {
    change: Change,
    /// Of each run, once a bias changes so.
    means: OnceCell<Vec<Means>>,
}

/// Means of a change in one run.
struct Means {
    /// Over each step of the grid.
    steps: Vec<f64>,
    /// For each row how many times of the grid are not after it, and the mean from the last of them to the row.
    to_rows: Vec<(usize, f64)>,
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

    fn means(&self, change: Change) -> Means {
        let mean = |pair: &[f64]| change.mean(pair.at(0), pair.at(1));
        let to_row = |time: f64| {
            let before = self.grid.partition_point(|at| *at <= time);
            let last = before.checked_sub(1).and_then(|k| self.grid.get(k)).copied();
            (before, last.filter(|last| time > *last).map_or(0.0, |last| change.mean(last, time)))
        };
        Means {
            steps: self.grid.windows(2).map(mean).collect(),
            to_rows: self.rows.iter().map(|(time, _)| to_row(*time)).collect(),
        }
    }
}

impl Course {
    pub fn of(change: Change) -> Self {
        Course { change, means: OnceCell::new() }
    }
}

impl Columns {
    pub fn new(mission: &Mission, measured: &Measured) -> Columns {
        let (mut runs, mut walks) = (Vec::new(), Walks::default());
        for (run, row_times) in measured.runs.iter().zip(times(measured)) {
            let at = |times: &[f64]| instants(mission, motion(mission, run.motion), times);
            let made = Run::new(mission, run, &row_times, at);
            if mission.errors.is_noisy() {
                walks.instants.push(made.at_rows.clone());
            }
            runs.push(made);
        }
        Columns { runs, walks }
    }

    /// The same around other errors than none: differences of the full simulation by a step of each source.
    pub fn around(&self, mission: &Mission, measured: &Measured, errors: &ImuErrors, steps: &[f64]) -> Columns {
        let mut flights = vec![*errors];
        for (source, step) in ErrorSource::catalogue().iter().zip(steps) {
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
        let mut columns = Columns { runs, walks: Walks::default() };
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
        Columns { runs, walks }
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
        let mut column = match cause.change() {
            Some(change) => self.changing(cause, &Course::of(change)),
            None => self.column(|run, _| match cause {
                Cause::Constant(source) => {
                    let j = ErrorSource::catalogue().iter().position(|other| other == source).unwrap_or(usize::MAX);
                    run.at_rows.iter().map(|instant| instant.signatures.at(j)).collect()
                }
                Cause::Reference(channel, _) => run.rows.iter().map(|_| alone(*channel, 1.0)).collect(),
                // a random walk has no column: it is of the noise
                _ => vec![[0.0; CHANNELS]; run.rows.len()],
            }),
        };
        if let Cause::Reading { at, .. } = cause {
            column.get_mut(*at).into_iter().for_each(|slot| *slot = 1.0);
        }
        column
    }

    /// The same of a bias or a channel that changes so, whatever its own change.
    pub fn changing(&self, cause: &Cause, course: &Course) -> Vec<f64> {
        let means = || self.runs.iter().map(|run| run.means(course.change)).collect();
        self.column(|run, k| match cause {
            Cause::Changing(source, _) => course
                .means
                .get_or_init(means)
                .get(k)
                .map_or(Vec::new(), |means| Columns::integrated(run, source, means)),
            Cause::Reference(channel, _) => {
                run.rows.iter().map(|(time, _)| alone(*channel, course.change.at(*time))).collect()
            }
            _ => vec![[0.0; CHANNELS]; run.rows.len()],
        })
    }

    /// The measured values of the channels in each run, which comes with its place.
    fn column(&self, values: impl Fn(&Run, usize) -> Vec<Channels>) -> Vec<f64> {
        let mut column = Vec::new();
        for (k, run) in self.runs.iter().enumerate() {
            for ((_, measured), value) in run.rows.iter().zip(values(run, k)) {
                column.extend(value.iter().zip(measured).filter(|(_, measured)| **measured).map(|(value, _)| *value));
            }
        }
        column
    }

    /// A bias that changes.
    fn integrated(run: &Run, source: &ErrorSource, means: &Means) -> Vec<Channels> {
        let place = ErrorSource::biases().iter().position(|bias| bias == source);
        let Some((carried, to_rows)) = place.and_then(|k| run.carried.get(k).zip(run.carried_to_rows.get(k))) else {
            return vec![[0.0; CHANNELS]; run.rows.len()];
        };
        // the integral up to the last time of the grid before each row, and on to the row
        let mut steps = carried.iter().zip(carried.iter().skip(1)).zip(&means.steps);
        let (mut integral, mut done) = (Vector::zeros(), 1);
        let mut values = Vec::with_capacity(run.rows.len());
        for ((before, mean), (psi, to_row)) in means.to_rows.iter().zip(run.psi.iter().zip(to_rows)) {
            for ((old, new), mean) in steps.by_ref().take(before.saturating_sub(done)) {
                integral += (new - old) * *mean;
            }
            done = done.max(*before);
            let last = before.checked_sub(1).and_then(|k| carried.get(k));
            let last_part = last.map_or(Vector::zeros(), |old| (to_row - old) * *mean);
            let all = psi * (integral + last_part);
            values.push(std::array::from_fn(|i| SIZE[i] * all[i]));
        }
        values
    }
}

/// One channel alone.
fn alone(channel: usize, value: f64) -> Channels {
    std::array::from_fn(|c| if c == channel { value } else { 0.0 })
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
