//! A long record in fewer rows, in which causes are searched for: the findings are fitted to all rows.

use super::measured::{CHANNELS, Measured, MeasuredRow};
use super::whiten::Instant;

/// Values of a question at most, about: they bound the work. Of seven channels these are two hundred rows; a course of time that is neither noise nor a
/// single value lasts longer than a hundredth of the run.
const VALUES: usize = 1500;
/// Growth of a random walk between means, as a share of their variance, from which rows stand for their stretches instead. Means of a walk that grows by `g`
/// differ with a variance of `2 g/3` (`int int min(s, t) ds dt / T^2 = T/3`), not `g`: at this share, beside `2 u^2`, a filter takes it for 2 % too large.
const BLURRED: f64 = 0.1;

/// Means over the rows of equal stretches of time, weighted by their uncertainties.
pub(super) struct Shortened {
    pub measured: Measured,
    pub u: Vec<f64>,
    /// For each value those that it is the mean of.
    cells: Vec<Vec<usize>>,
    /// Weights of all values.
    weights: Vec<f64>,
    /// For each run how many of its rows each of these rows is the mean of,
    rows: Vec<Vec<usize>>,
    /// or stands for, being the middle one.
    picks: bool,
}

impl Shortened {
    /// `u` holds the standard uncertainty of each value; for values that are left out it is so large that their weight vanishes.
    pub fn new(measured: &Measured, u: &[f64]) -> Shortened {
        Shortened::of(measured, u, VALUES, false)
    }

    /// Of equal stretches of time one row: what varies between the rows of a stretch, as a random walk does, has no mean at any time.
    pub fn picked(measured: &Measured, u: &[f64]) -> Shortened {
        Shortened::of(measured, u, VALUES, true)
    }

    /// All rows as they are.
    pub fn whole(measured: &Measured, u: &[f64]) -> Shortened {
        Shortened::of(measured, u, usize::MAX, false)
    }

    /// Of no more than so many values, about.
    fn of(measured: &Measured, u: &[f64], most: usize, picks: bool) -> Shortened {
        let share = measured.count().div_ceil(most).max(1) as f64;
        let mut short = Shortened {
            measured: Measured { runs: Vec::new(), left_out: measured.left_out },
            u: Vec::new(),
            cells: Vec::new(),
            weights: u.iter().map(|u| 1.0 / (u * u)).collect(),
            rows: Vec::new(),
            picks,
        };
        let mut at = 0..;
        for run in &measured.runs {
            let ends = run.rows.first().zip(run.rows.last()).map_or((0.0, 0.0), |(a, b)| (a.time, b.time));
            // a stretch that holds `share` rows where they are evenly spaced
            let stretch = share * (ends.1 - ends.0) / (run.rows.len().max(2) - 1) as f64;
            let place = |row: &MeasuredRow| ((row.time - ends.0) / stretch).floor();
            let (mut rows, mut counts) = (Vec::new(), Vec::new());
            for chunk in run.rows.chunk_by(|a, b| share > 1.0 && place(a) == place(b)) {
                let mut cells: [Vec<usize>; CHANNELS] = Default::default();
                let middle = chunk.len() / 2;
                for (k, row) in chunk.iter().enumerate() {
                    let present = cells.iter_mut().zip(&row.value).filter(|(_, value)| value.is_some());
                    present.for_each(|(cells, _)| cells.extend(at.next().filter(|_| !picks || k == middle)));
                }
                let mean = |cells: &Vec<usize>| (!cells.is_empty()).then(|| short.weight(cells).sqrt().recip());
                let u: [Option<f64>; CHANNELS] = std::array::from_fn(|c| cells.get(c).and_then(mean));
                let mean = chunk.iter().map(|row| row.time).sum::<f64>() / chunk.len() as f64;
                let time = chunk.get(middle).filter(|_| picks).map_or(mean, |row| row.time);
                // the values themselves are among the columns
                rows.push(MeasuredRow { time, value: u.map(|u| u.map(|_| 0.0)), u });
                counts.push(chunk.len());
                short.u.extend(u.iter().flatten());
                short.cells.extend(cells.into_iter().filter(|cells| !cells.is_empty()));
            }
            short.measured.runs.push(super::measured::Run { motion: run.motion, rows });
            short.rows.push(counts);
        }
        short
    }

    /// Are there fewer rows than were measured?
    pub fn is_short(&self) -> bool {
        self.rows.iter().flatten().any(|count| *count > 1)
    }

    /// Does a random walk grow within the stretches by more than a tenth of the variance of their means? Then these are not what it was at their times.
    pub fn is_blurred(&self, walks: &[Vec<Instant>]) -> bool {
        let walks = self.instants(walks);
        let mut growth = [(0.0, 0.0); CHANNELS];
        for (run, instants) in self.measured.runs.iter().zip(&walks) {
            for (row, (before, after)) in run.rows.iter().zip(instants.iter().zip(instants.iter().skip(1))) {
                for (c, (u, (sum, count))) in row.u.iter().zip(&mut growth).enumerate() {
                    let size = |instant: &Instant| instant.walk.get(c).and_then(|walk| walk.get(c)).copied();
                    let (Some(u), Some(before), Some(after)) = (u, size(before), size(after)) else { continue };
                    (*sum, *count) = (*sum + (after - before).max(0.0) / (u * u), *count + 1.0);
                }
            }
        }
        self.is_short() && growth.iter().any(|(sum, count)| *sum > BLURRED * count)
    }

    fn weight(&self, cells: &[usize]) -> f64 {
        cells.iter().filter_map(|at| self.weights.get(*at)).sum()
    }

    pub fn column(&self, column: &[f64]) -> Vec<f64> {
        let one = |cells: &Vec<usize>| match cells[..] {
            // as it is, to the last digit
            [at] => column.get(at).copied().unwrap_or(f64::NAN),
            _ => {
                let pairs = cells.iter().filter_map(|at| Some(column.get(*at)? * self.weights.get(*at)?));
                pairs.sum::<f64>() / self.weight(cells)
            }
        };
        self.cells.iter().map(one).collect()
    }

    /// Of what was made for each row of a run, the means.
    pub fn means<T: Clone>(&self, run: usize, all: &[T], mean: impl Fn(&[T]) -> T) -> Vec<T> {
        let mut remaining = all;
        let mut means = Vec::new();
        for count in self.rows.get(run).into_iter().flatten() {
            let Some((chunk, tail)) = remaining.split_at_checked(*count) else { break };
            let one = chunk.get(count / 2).filter(|_| self.picks || *count == 1);
            means.push(one.cloned().unwrap_or_else(|| mean(chunk)));
            remaining = tail;
        }
        means
    }

    /// The same of what all runs do at their rows.
    pub fn instants(&self, all: &[Vec<Instant>]) -> Vec<Vec<Instant>> {
        all.iter().enumerate().map(|(run, instants)| self.means(run, instants, Instant::mean)).collect()
    }

    /// Values of which nothing but what is left out is the mean.
    pub fn out(&self, out: &[usize]) -> Vec<usize> {
        let is_out = |cells: &Vec<usize>| cells.iter().all(|at| out.contains(at));
        self.cells.iter().enumerate().filter(|(_, cells)| is_out(cells)).map(|(k, _)| k).collect()
    }
}
