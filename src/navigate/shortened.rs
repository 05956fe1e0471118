//! A long record in fewer rows, in which causes are looked for: what is found is fitted to all of them.

use super::instant::Instant;
use super::measured::{CHANNELS, Measured, MeasuredRow};

/// Values of a question at most, about: they bound the work. Of seven channels these are two hundred rows; what goes with time, and is neither noise nor a
/// single value, does so over more than a hundredth of the run.
const VALUES: usize = 1500;

/// Means over consecutive rows of a run, weighted by their uncertainties, each at the row in the middle.
pub(super) struct Shortened {
    pub measured: Measured,
    pub u: Vec<f64>,
    /// For each value those that it is the mean of.
    cells: Vec<Vec<usize>>,
    /// Weights of all values.
    weights: Vec<f64>,
    every: usize,
}

impl Shortened {
    /// `u` holds the standard uncertainty of each value, of those that are left out one beside which all others are nothing.
    pub fn new(measured: &Measured, u: &[f64]) -> Shortened {
        let every = measured.count().div_ceil(VALUES).max(1);
        let mut own = Shortened {
            measured: Measured { runs: Vec::new(), left_out: measured.left_out },
            u: Vec::new(),
            cells: Vec::new(),
            weights: u.iter().map(|u| 1.0 / (u * u)).collect(),
            every,
        };
        let mut at = 0..;
        for run in &measured.runs {
            let mut rows = Vec::new();
            for chunk in run.rows.chunks(every) {
                let mut cells: [Vec<usize>; CHANNELS] = Default::default();
                for row in chunk {
                    let present = cells.iter_mut().zip(&row.value).filter(|(_, value)| value.is_some());
                    present.for_each(|(cells, _)| cells.extend(at.next()));
                }
                let Some(middle) = chunk.get(chunk.len() / 2) else { continue };
                let mean = |cells: &Vec<usize>| (!cells.is_empty()).then(|| own.weight(cells).sqrt().recip());
                let u: [Option<f64>; CHANNELS] = std::array::from_fn(|c| cells.get(c).and_then(mean));
                // the values themselves are among the columns
                rows.push(MeasuredRow { time: middle.time, value: u.map(|u| u.map(|_| 0.0)), u });
                own.u.extend(u.iter().flatten());
                own.cells.extend(cells.into_iter().filter(|cells| !cells.is_empty()));
            }
            own.measured.runs.push(super::measured::Run { motion: run.motion, rows });
        }
        own
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

    /// Of what was made for each row of a run, that of the rows in the middle.
    pub fn middle<T: Clone>(&self, all: &[T]) -> Vec<T> {
        all.chunks(self.every).filter_map(|chunk| chunk.get(chunk.len() / 2).cloned()).collect()
    }

    /// The same of all runs.
    pub fn instants(&self, all: &[Vec<Instant>]) -> Vec<Vec<Instant>> {
        all.iter().map(|run| self.middle(run)).collect()
    }

    /// Values of which nothing but what is left out is the mean.
    pub fn out(&self, out: &[usize]) -> Vec<usize> {
        let is_out = |cells: &Vec<usize>| cells.iter().all(|at| out.contains(at));
        self.cells.iter().enumerate().filter(|(_, cells)| is_out(cells)).map(|(k, _)| k).collect()
    }
}
