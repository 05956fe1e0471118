//! The remainder that no cause explains: covariance kernels independent of the catalogue. One channel, all channels, or the rate or specific force along
//! an axis, which drives the navigator, follows a course of time; or the noise of a channel is larger than stated.

use super::cause::{Cause, Change};
use super::errors::ErrorSource;
use super::measured::{CHANNELS, Cell};
use super::weighed::Weighed;
use crate::diagnosis::{Kernel, LENGTHS, share_of_wave};
use faer::Mat;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Waves of what drives the navigator (fast courses have almost no effect), and of all channels together: they bound the work. What a course lacks is taken
/// for noise of all channels; those of three channels of two hundred rows are complete, and of more the largest are kept.
const DRIVING: usize = 24;
const TOGETHER: usize = 640;
/// The same of channels without remainder: there is no course to follow, and the seven channels of a record then add 238 columns, about the rows of its
/// means.
const QUIET: usize = 34;
/// Standard deviations of its mean square by which the residuals of a channel exceed noise.
const MORE: f64 = 3.0;

/// Columns as a matrix.
pub(super) fn matrix(rows: usize, columns: &[impl AsRef<Vec<f64>>]) -> Mat<f64> {
    // each has a value for each row
    Mat::from_fn(rows, columns.len(), |i, j| {
        columns.get(j).and_then(|column| column.as_ref().get(i)).copied().unwrap_or_default()
    })
}

/// The kernels for the residuals of a state.
pub(super) fn bank(rows: &Weighed, residual: &[f64]) -> Vec<Kernel> {
    let mut kernels = of_channels(rows, residual);
    kernels.extend(driven(rows));
    kernels
}

/// Those in which channels deviate by themselves.
pub(super) fn of_channels(rows: &Weighed, residual: &[f64]) -> Vec<Kernel> {
    let waves = Waves::new(rows);
    let of = |channel: usize| waves.cells.iter().filter(move |(_, cell)| cell.channel == channel).map(|(at, _)| *at);
    // mean square of the residuals of each channel that was measured
    let square = |channel: usize| {
        let count = of(channel).count() as f64;
        let sum: f64 = of(channel).filter_map(|at| residual.get(at)).map(|v| v * v).sum();
        (count > 0.0).then(|| (channel, sum / count, 1.0 + MORE * (2.0 / count).sqrt()))
    };
    let measured: Vec<(usize, f64, f64)> = (0..CHANNELS).filter_map(square).collect();
    // with the standard deviation of the excess over noise
    let louder: Vec<(usize, f64)> =
        measured.iter().filter(|(_, mean, most)| mean > most).map(|(c, mean, _)| (*c, (mean - 1.0).sqrt())).collect();
    let mut kernels = Vec::new();
    let mut add = |columns: Vec<Vec<f64>>| kernels.extend(kernel(&columns, residual.len()));
    let largest = |mut waves: Vec<(&Wave, f64)>, length: (bool, f64)| -> Vec<Vec<f64>> {
        let size = |(wave, by): &(&Wave, f64)| by * share_of_wave(wave.order, length);
        waves.sort_by(|a, b| size(b).total_cmp(&size(a)));
        waves.into_iter().take(TOGETHER).map(|(wave, by)| wave.scaled(length, by)).collect()
    };
    let quiet: Vec<Vec<Wave>> = measured.iter().map(|(channel, ..)| waves.of_channel(*channel, QUIET)).collect();
    let loud: Vec<(Vec<Wave>, f64)> = louder.iter().map(|(c, by)| (waves.of_channel(*c, TOGETHER), *by)).collect();
    for length in LENGTHS {
        // of kernels that hardly differ the first is kept: all channels that deviate before the one that does so most
        add(largest(loud.iter().flat_map(|(courses, by)| courses.iter().map(|wave| (wave, *by))).collect(), length));
        for (courses, _) in &loud {
            add(courses.iter().map(|wave| wave.scaled(length, 1.0)).collect());
        }
        add(quiet.iter().flatten().map(|wave| wave.scaled(length, 1.0)).collect());
    }
    let unit = |at: usize, by: f64| {
        let mut column = vec![0.0; residual.len()];
        column.iter_mut().skip(at).take(1).for_each(|slot| *slot = by);
        column
    };
    add(louder.iter().flat_map(|(channel, by)| of(*channel).map(|at| unit(at, *by))).collect());
    for (channel, _) in &louder {
        add(of(*channel).map(|at| unit(at, 1.0)).collect());
    }
    kernels
}

/// Those in which what drives the navigator deviates: slow against the run, as a random walk, and white as the noise of an instrument, which makes an error walk.
fn driven(rows: &Weighed) -> Vec<Kernel> {
    let waves = Waves::new(rows);
    let courses: Vec<Vec<Wave>> = ErrorSource::biases().iter().map(|source| waves.driven_by(source)).collect();
    let [_, slow, walk, _, white] = LENGTHS;
    let mut kernels = Vec::new();
    for length in [slow, walk, white] {
        let mut all = Vec::new();
        for courses in &courses {
            let columns: Vec<Vec<f64>> = courses.iter().map(|wave| wave.scaled(length, 1.0)).collect();
            let trace: f64 = columns.iter().flatten().map(|v| v * v).sum();
            if trace > 0.0 {
                all.extend(columns.iter().map(|column| column.iter().map(|v| v / trace.sqrt()).collect::<Vec<f64>>()));
            }
            kernels.extend(kernel(&columns, rows.short.u.len()));
        }
        kernels.extend(kernel(&all, rows.short.u.len()));
    }
    kernels
}

/// The kernel of these columns, of mean variance one; none of nothing.
fn kernel(columns: &[Vec<f64>], rows: usize) -> Option<Kernel> {
    let mut factor = matrix(rows, columns);
    let trace: f64 = (0..factor.ncols()).map(|j| factor.col(j).squared_norm_l2()).sum();
    if !(trace > 0.0) {
        return None;
    }
    // the trace of `F F'` is the sum of its variances
    factor *= faer::Scale((rows as f64 / trace).sqrt());
    Some(Kernel { follows: None, per_mounting: false, one_of: 1, factor: factor.into(), sensor: None })
}

/// A wave of one run: so many half waves in the run.
struct Wave {
    order: f64,
    column: Vec<f64>,
}

impl Wave {
    /// Its column by what a kernel of a length has of it.
    fn scaled(&self, length: (bool, f64), by: f64) -> Vec<f64> {
        let share = by * share_of_wave(self.order, length);
        self.column.iter().map(|v| share * v).collect()
    }
}

/// What makes them: the values that are not left out.
struct Waves<'a> {
    rows: &'a Weighed,
    cells: Vec<(usize, Cell)>,
}

impl<'a> Waves<'a> {
    fn new(rows: &'a Weighed) -> Self {
        let out = rows.out();
        let cells = rows.short.measured.cells().enumerate().filter(|(at, _)| !out.contains(at)).collect();
        Waves { rows, cells }
    }

    fn weighed(&self, made: Vec<(usize, Vec<f64>)>) -> Vec<Wave> {
        let (orders, mut columns): (Vec<usize>, Vec<Vec<f64>>) = made.into_iter().unzip();
        self.rows.weigh(&mut columns);
        orders.into_iter().zip(columns).map(|(order, column)| Wave { order: order as f64, column }).collect()
    }

    /// Waves of one channel from row to row, `cos(pi h (k + 1/2) / n)`: orthogonal, and complete where there are as many waves as rows. At most so many in
    /// all runs; of each the slowest.
    fn of_channel(&self, channel: usize, most: usize) -> Vec<Wave> {
        let runs = self.rows.short.measured.runs.len();
        let in_run = |run: usize| self.cells.iter().filter(move |(_, cell)| cell.run == run && cell.channel == channel);
        let mut made = Vec::new();
        for run in 0..runs {
            let count = in_run(run).count();
            for h in 0..count.min(most.div_ceil(runs)) {
                let mut column = vec![0.0; self.rows.short.u.len()];
                for (k, (at, _)) in in_run(run).enumerate() {
                    // a constant has twice the square of a wave
                    let by =
                        if h == 0 { FRAC_1_SQRT_2 } else { (PI * h as f64 * (k as f64 + 0.5) / count as f64).cos() };
                    let u = self.rows.short.u.get(*at);
                    column.get_mut(*at).zip(u).into_iter().for_each(|(slot, u)| *slot = u * by);
                }
                made.push((h, column));
            }
        }
        self.weighed(made)
    }

    /// The effect of a bias that is a wave from the start of a run on; a constant one is a cause.
    fn driven_by(&self, source: &ErrorSource) -> Vec<Wave> {
        let measured = &self.rows.short.measured;
        let mut made = Vec::new();
        for (run, rows) in measured.runs.iter().enumerate() {
            let Some(last) = rows.rows.last() else { continue };
            for h in 1..=DRIVING.div_ceil(measured.runs.len()) {
                let change = Change::Wave { period: 2.0 * last.time / h as f64, phase: 0.5 * PI };
                let column = self.rows.made.of(&Cause::Changing(*source, change));
                let of_run = |(cell, v): (Cell, f64)| if cell.run == run { v } else { 0.0 };
                made.push((h, measured.cells().zip(column).map(of_run).collect()));
            }
        }
        self.weighed(made)
    }
}
