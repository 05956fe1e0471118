//! What no cause explains: weighted values in a bounded number of rows, and covariance kernels that know nothing of the catalogue. A channel goes with
//! time, or all channels, or the rate or the specific force along an axis does and drives the navigator; or the noise of a channel is larger than
//! stated.

use super::case::Case;
use super::cause::{Cause, Change};
use super::errors::{ErrorSource, Kind};
use super::measured::{CHANNELS, Cell, Measured};
use crate::diagnosis::{Kernel, LENGTHS, share_of_wave};
use crate::elements::Elements;
use faer::Mat;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Rows of a question at most, about: what follows time slower than a hundredth of a run keeps its shape.
const ROWS: usize = 1000;
/// Waves of what one channel does in all runs, of what drives the navigator (fast courses do next to nothing), and of all channels together: they bound the work.
const WAVES: usize = 48;
const DRIVING: usize = 24;
const TOGETHER: usize = 240;
/// Standard deviations of its mean square by which a channel has more than noise left.
const MORE: f64 = 3.0;
/// Share of the noise variance that a channel with nothing left deviates by, where each is as large as what is left in it.
const LEAST: f64 = 0.01;

/// Weighted values, as means over consecutive rows of a channel: orthogonal combinations of values, so that what is white and of unit size stays so.
pub(super) struct Condensed {
    groups: Vec<Group>,
    /// Times of the first and the last row of each run.
    spans: Vec<(f64, f64)>,
}

struct Group {
    channel: usize,
    cells: Vec<usize>,
}

impl Condensed {
    pub fn new(measured: &Measured, out: &[usize]) -> Condensed {
        let mut places: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
        let mut spans: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
        let mut count = 0;
        for (at, cell) in measured.cells().enumerate().filter(|(at, _)| !out.contains(at)) {
            places.entry((cell.run, cell.channel)).or_default().push(at);
            let span = spans.entry(cell.run).or_insert((cell.time, cell.time));
            *span = (span.0.min(cell.time), span.1.max(cell.time));
            count += 1;
        }
        let together = usize::div_ceil(count, ROWS).max(1);
        let group = |((_, channel), cells): (&(usize, usize), &Vec<usize>)| -> Vec<Group> {
            let one = |cells: &[usize]| Group { channel: *channel, cells: cells.to_vec() };
            cells.chunks(together).map(one).collect()
        };
        Condensed { groups: places.iter().flat_map(group).collect(), spans: spans.into_values().collect() }
    }

    pub fn len(&self) -> usize {
        self.groups.len()
    }

    pub fn of(&self, column: &[f64]) -> Vec<f64> {
        let one = |own: &Group| {
            let sum: f64 = own.cells.iter().filter_map(|at| column.get(*at)).sum();
            sum / (own.cells.len() as f64).sqrt()
        };
        self.groups.iter().map(one).collect()
    }

    pub fn matrix<'b>(&self, columns: impl Iterator<Item = &'b [f64]>) -> Mat<f64> {
        let columns: Vec<Vec<f64>> = columns.map(|column| self.of(column)).collect();
        matrix(self.len(), &columns)
    }
}

fn matrix(rows: usize, columns: &[Vec<f64>]) -> Mat<f64> {
    // each has a value for each row
    Mat::from_fn(rows, columns.len(), |i, j| columns.get(j).and_then(|own| own.get(i)).copied().unwrap_or_default())
}

/// The kernels beside a state that leaves `left` (weighted, condensed).
pub(super) fn bank(case: &Case<'_>, u: &[f64], out: &[usize], rows: &Condensed, left: &[f64]) -> Vec<Kernel> {
    let own = |channel: usize| rows.groups.iter().zip(left).filter(move |(group, _)| group.channel == channel);
    let counts: [f64; CHANNELS] = std::array::from_fn(|channel| own(channel).count() as f64);
    let squares: [f64; CHANNELS] =
        std::array::from_fn(|channel| own(channel).map(|(_, v)| v * v).sum::<f64>() / counts.at(channel).max(1.0));
    let is_left = |channel: usize| {
        counts.at(channel) > 0.0 && squares.at(channel) > 1.0 + MORE * (2.0 / counts.at(channel)).sqrt()
    };
    // standard deviation of what is more than noise
    let beyond = |channel: usize| (squares.at(channel) - 1.0).max(LEAST).sqrt();
    let waves = Waves { case, u, out, rows };
    let mut found = Vec::new();
    let mut add = |columns: Vec<Vec<f64>>| {
        let mut factor = matrix(rows.len(), &columns);
        let trace: f64 = (0..factor.ncols()).map(|j| factor.col(j).squared_norm_l2()).sum();
        if trace > 0.0 {
            // of mean variance one
            factor *= faer::Scale((rows.len() as f64 / trace).sqrt());
            found.push(Kernel { follows: None, factor });
        }
    };
    let scaled = |own: &Wave, length: (bool, f64), by: f64| -> Vec<f64> {
        let share = by * share_of_wave(own.order, length);
        own.column.iter().map(|v| share * v).collect()
    };
    let channels: Vec<(usize, Vec<Wave>)> =
        (0..CHANNELS).filter(|c| counts.at(*c) > 0.0).map(|channel| (channel, waves.of_channel(channel))).collect();
    let most = (TOGETHER / channels.len().max(1)).max(1);
    for length in LENGTHS {
        for (_, own) in channels.iter().filter(|(channel, _)| is_left(*channel)) {
            add(own.iter().map(|wave| scaled(wave, length, 1.0)).collect());
        }
        for alike in [true, false] {
            let by = |channel: usize| if alike { 1.0 } else { beyond(channel) };
            let own = channels
                .iter()
                .flat_map(|(channel, own)| own.iter().take(most).map(move |wave| scaled(wave, length, by(*channel))));
            add(own.collect());
        }
    }
    let unit = |(place, group): (usize, &Group), by: f64| {
        is_left(group.channel).then(|| {
            let mut column = vec![0.0; rows.len()];
            column.iter_mut().skip(place).take(1).for_each(|slot| *slot = by);
            column
        })
    };
    for channel in (0..CHANNELS).filter(|channel| is_left(*channel)) {
        let own = rows.groups.iter().enumerate().filter(|(_, group)| group.channel == channel);
        add(own.filter_map(|own| unit(own, 1.0)).collect());
    }
    if (0..CHANNELS).filter(|channel| is_left(*channel)).count() > 1 {
        add(rows.groups.iter().enumerate().filter_map(|own| unit(own, beyond(own.1.channel))).collect());
    }
    // what is slow beside the run, and what walks
    let driven: Vec<Vec<Wave>> = ErrorSource::first_order()
        .into_iter()
        .filter(|source| source.kind == Kind::Bias)
        .map(|source| waves.driven_by(&source))
        .collect();
    let [_, slow, walk, ..] = LENGTHS;
    for length in [slow, walk] {
        let each: Vec<Vec<Vec<f64>>> =
            driven.iter().map(|own| own.iter().map(|wave| scaled(wave, length, 1.0)).collect()).collect();
        let mut all = Vec::new();
        for own in each {
            let trace: f64 = own.iter().flatten().map(|v| v * v).sum();
            if trace > 0.0 {
                all.extend(own.iter().map(|column| column.iter().map(|v| v / trace.sqrt()).collect::<Vec<f64>>()));
            }
            add(own);
        }
        add(all);
    }
    found
}

/// A wave of one run: `cos(pi h t / T)`, `T` the length of the run, in what deviates.
struct Wave {
    order: f64,
    column: Vec<f64>,
}

/// What makes them.
struct Waves<'a> {
    case: &'a Case<'a>,
    u: &'a [f64],
    out: &'a [usize],
    rows: &'a Condensed,
}

impl Waves<'_> {
    fn each(
        &self,
        orders: std::ops::RangeInclusive<usize>,
        column: impl Fn(f64, (usize, f64, f64)) -> Vec<f64>,
    ) -> Vec<Wave> {
        let most = (orders.end() / self.rows.spans.len().max(1)).max(1);
        let runs = self.rows.spans.iter().enumerate().filter(|(_, (first, last))| last > first);
        let mut found = Vec::new();
        for h in *orders.start()..=most {
            for (run, (first, last)) in runs.clone() {
                let order = h as f64;
                let mut columns = [column(order, (run, *first, *last))];
                self.case.weigh(self.u, self.out, &mut columns);
                let [column] = columns;
                // a constant has twice the square of a wave
                let by = if h == 0 { std::f64::consts::FRAC_1_SQRT_2 } else { 1.0 };
                let column = self.rows.of(&column).into_iter().map(|v| by * v).collect();
                found.push(Wave { order, column });
            }
        }
        found
    }

    fn of_channel(&self, channel: usize) -> Vec<Wave> {
        let own = self.rows.groups.iter().filter(|group| group.channel == channel).count();
        // what forgets has a mean, too
        self.each(0..=WAVES.min(own.saturating_sub(1)), |order, (run, first, last)| {
            let one = |(cell, u): (Cell, &f64)| match cell.channel == channel && cell.run == run {
                true => u * (PI * order * (cell.time - first) / (last - first)).cos(),
                false => 0.0,
            };
            self.case.measured.cells().zip(self.u).map(one).collect()
        })
    }

    fn driven_by(&self, source: &ErrorSource) -> Vec<Wave> {
        // a constant one is a cause
        self.each(1..=DRIVING, |order, (run, _, last)| {
            // from the start of the run, where nothing has happened yet
            let change = Change::Wave { period: 2.0 * last / order, phase: 0.5 * PI };
            let column = self.case.columns.of(&Cause::Changing(*source, change));
            let own = |(cell, v): (Cell, f64)| if cell.run == run { v } else { 0.0 };
            self.case.measured.cells().zip(column).map(own).collect()
        })
    }
}
