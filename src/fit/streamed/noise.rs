//! From a start to the solution, and to what is free of the sensors' noise.
//!
//! Passes of Gauss-Newton with white noise, or with what is stated; then, where noise is correlated over time, Newton's steps to the top of the restricted likelihood
//! (`estimate/scatter/restricted.rs`). For each of them a pass along time brings the sums of the rows with their derivatives (`estimate/scatter/chain.rs`).
#![allow(
    clippy::indexing_slicing,
    reason = "every list here has one entry for each sensor, and places of parameters are those that the model of the noise was made with"
)]

use super::Rows;
use super::octaves::{self, Noise, Octaves, Stated};
use super::question::{Chunk, Part, Question};
use crate::campaign::{Campaign, Size};
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate::{
    Block, Chain, Compressed, Likelihood, NEWTON_STEPS, Node, NoiseModel, NoisePart, PartNoise, ScaleHints, Scaled,
    Slot, TimeNoise, deviation_range, time_range, white_range,
};
use crate::fit::Estimator;
use crate::fit::gauss_newton::{Convergence, Iteration, Stop};
use faer::Mat;
use faer::linalg::solvers::Solve;

/// A step of Gauss-Newton is negligible where it moves no weighted prediction by more than this share of the weighted residuals' norm.
const NEGLIGIBLE: f64 = 1e-9;

/// Steps of time of which the middling one is that of the record: 32 kB, and as many as a clock learns its step from.
const STEPS: usize = 4096;

/// What is free of a sensor's noise: the white part, the deviation, its correlation time.
pub(super) type Free = [bool; 3];

/// Where the search ended.
pub(super) struct Found {
    pub noise: Vec<Noise>,
    pub free: Vec<Free>,
    pub convergence: Option<Convergence>,
    /// Did the noise settle?
    pub settled: bool,
    /// Sensors whose deviation over time was estimated as zero.
    pub at_zero: Vec<bool>,
    /// White noise that was estimated as zero beside a deviation.
    pub white_at_zero: Vec<bool>,
    /// Directions of the unknowns in which the rows were summed, where noise was looked for.
    pub directions: Option<Mat<f64>>,
    /// Directions of the unknowns, and of the known inputs that have an uncertainty, in which the rows are nearly orthonormal.
    pub tested: Mat<f64>,
}

impl Question {
    /// The stated numbers of a sensor's line; `None` without one.
    pub(super) fn stated(&self, s: usize, campaign: &Campaign) -> Option<Stated> {
        let (line, _) = self.sensors.get(s)?.line?;
        let own = campaign.scatter.get(line)?;
        let deviation = if let Size::Stated { sd, .. } = own.size { Some(sd) } else { None };
        let white = (!self.is_white_free(s)).then_some(1.0);
        Some(Stated { white, deviation, tau: own.over.as_ref().and_then(|over| over.tau) })
    }

    /// What is free of a sensor's noise.
    fn free(&self, s: usize, stated: Option<Stated>) -> Free {
        let of = |value: fn(Stated) -> Option<f64>| stated.is_some_and(|own| value(own).is_none());
        [self.is_white_free(s), of(|own| own.deviation), of(|own| own.tau)].map(|free| free && self.is_read(s))
    }

    /// Directions of the unknowns and of the known inputs' independent parts, for rows that have the inputs in their own units.
    pub(super) fn in_own_units(&self, tested: &Mat<f64>) -> Mat<f64> {
        let columns = self.unknowns + self.carried.len();
        self.extended(&Mat::identity(columns, columns)).submatrix(0, 0, columns, tested.nrows()) * tested
    }

    /// One pass along time: the sums of each sensor's rows, those of its white noise with the factor 1, in some directions of the unknowns and known
    /// inputs, and last what is stated of these.
    fn along(
        &mut self,
        rows: &mut dyn Rows,
        point: &[f64],
        tested: &Mat<f64>,
        noises: &[TimeNoise],
    ) -> Result<Vec<NoisePart>> {
        let directions = &self.in_own_units(tested);
        let mut of = noises.iter();
        let mut chains: Vec<Option<Chain>> = (0..self.sensors.len())
            .map(|s| {
                let noise = if self.is_read(s) { of.next() } else { None };
                noise.map(|noise| Chain::new(directions.ncols() + 1, *noise, true))
            })
            .collect();
        self.walk(rows, point, &[], &mut |s, chunk| match &mut chains[s] {
            Some(chain) => chain.push(chunk.turned(directions, &[]).as_ref(), chunk.time, chunk.relative),
            None => Ok(()),
        })?;
        let parts = chains.into_iter().flatten().map(Chain::part);
        let stated = self.extended_blocks(&[self.prior_block(point)]);
        Ok(parts.chain(stated.iter().map(|block| block.part(tested, &[]))).collect())
    }
}

/// A sensor's residuals as a pass of Gauss-Newton sees them.
#[derive(Debug, Clone, Default)]
struct Seen {
    octaves: Octaves,
    rows: f64,
    /// Sum of the reciprocal squares of the relative standard deviations.
    weight: f64,
    /// Steps of time at the beginning.
    steps: Vec<f64>,
    first: Option<f64>,
    last: f64,
}

impl Seen {
    fn take(&mut self, chunk: &Chunk<'_>) {
        for ((y, relative), time) in chunk.observed().iter().zip(chunk.relative).zip(chunk.time) {
            self.octaves.push(y / relative);
            self.rows += 1.0;
            self.weight += 1.0 / (relative * relative);
            if self.first.is_some() && self.steps.len() < STEPS {
                self.steps.push(time - self.last);
            }
            self.first.get_or_insert(*time);
            self.last = *time;
        }
    }
}

/// The solution and the noise; `point` is where it begins and ends, `first` what was folded there already.
pub(super) fn search(
    question: &mut Question,
    rows: &mut dyn Rows,
    point: &mut [f64],
    lines: &[Option<Stated>],
    mut first: Option<Vec<Option<Part>>>,
) -> Result<Found> {
    let sensors = question.sensors.len();
    let n = question.unknowns;
    let linear_only = question.settings.estimator == Estimator::Linear;
    // the noise of the first passes: what is stated, white where something is to be estimated
    let mut noise: Vec<Noise> = vec![Noise::WHITE; sensors];
    for (own, stated) in noise.iter_mut().zip(lines) {
        if let Some(Stated { deviation: Some(deviation), tau: Some(tau), white: Some(_) }) = stated {
            *own = Noise { white: 1.0, deviation: *deviation, tau: *tau };
        }
    }
    let open_at_first: Vec<bool> = (0..sensors).map(|s| noise[s].deviation == 0.0).collect();
    let mut iterations: Vec<Iteration> = Vec::new();
    let mut seen = vec![Seen::default(); sensors];
    let mut stop = Stop::Limit;
    let mut before: Option<(f64, Vec<f64>, Vec<f64>, f64)> = None;
    let (mut directions, mut tested) = (Mat::new(), Mat::new());
    for _ in 0..question.settings.iterations.max(1) {
        seen.fill(Seen::default());
        let parts = match first.take() {
            Some(parts) => parts,
            None => question.fold(rows, point, &noise, &mut |s, chunk| seen[s].take(chunk))?,
        };
        let open: Vec<bool> = (0..sensors).map(|s| question.is_white_free(s) && open_at_first[s]).collect();
        let found = together(question, &parts, &open, point)?;
        let change = found.found.unknowns.solution.clone();
        let (norm, length) = found.rows.norms(&found.found.factor, &change);
        let here = norm * norm;
        if let Some((merit_before, from, step, share)) = before.take()
            && here > merit_before * (1.0 + 1e-9)
            && share > 1e-6
            && iterations.len() > 1
        {
            // too far: half of the step from where it came
            let share = 0.5 * share;
            for ((x, from), dx) in point.iter_mut().zip(&from).zip(&step) {
                *x = from + share * dx;
            }
            if let Some(last) = iterations.last_mut() {
                last.share = share;
            }
            before = Some((merit_before, from, step, share));
            continue;
        }
        iterations.push(Iteration { sum_of_squares: here, step: length, share: 1.0 });
        for (s, own) in noise.iter_mut().enumerate().filter(|(s, _)| open[*s]) {
            own.white = found.scale[s].sqrt();
        }
        directions = found.found.factor.whitened_directions();
        let beside = found.extended.as_ref().map(|(own, _)| own.factor.whitened_directions());
        tested = beside.unwrap_or_else(|| directions.clone());
        let rest = found.found.sum_of_squares.sqrt();
        if linear_only || length <= NEGLIGIBLE * rest || length <= 1e-13 * (norm + size(point)) {
            stop = Stop::Settled;
            break;
        }
        before = Some((here, point.to_vec(), change.clone(), 1.0));
        point.iter_mut().zip(&change).for_each(|(x, dx)| *x += dx);
        if question.is_linear {
            // the step is the whole way
            stop = Stop::Settled;
            break;
        }
    }
    let mut found = Found {
        noise,
        free: (0..sensors).map(|s| question.free(s, lines[s])).collect(),
        convergence: None,
        settled: true,
        at_zero: vec![false; sensors],
        white_at_zero: vec![false; sensors],
        directions: None,
        tested,
    };
    if lines.iter().zip(&found.free).any(|(line, free)| line.is_some() && free.contains(&true)) {
        found.along_time((question, rows), point, lines, &seen)?;
    }
    if lines.iter().any(Option::is_some) {
        found.directions = Some(directions);
    }
    found.convergence = (!linear_only).then(|| Convergence {
        converged: stop == Stop::Settled,
        stop,
        iterations,
        linear: point.iter().copied().take(n).collect(),
        held: Vec::new(),
        moved: Vec::new(),
    });
    Ok(found)
}

/// The step of the `n` unknowns where the known inputs behind them are as stated, and its length in its standard uncertainties. Solution and covariance of
/// the likelihood are in the directions.
fn as_stated(directions: &Mat<f64>, found: &Likelihood, n: usize) -> Result<(Vec<f64>, f64)> {
    let covariance = directions * &found.covariance * directions.transpose();
    let solution = directions * Mat::from_fn(directions.ncols(), 1, |k, _| found.solution[k]);
    let whole = Node { weight: 1.0, shift: solution.col_as_slice(0).to_vec(), covariance };
    let Node { shift, covariance, .. } = whole.given(n)?;
    let step = Mat::from_fn(n, 1, |j, _| shift[j]);
    // what the readings do not determine has no direction, and no step
    let weighed = covariance.llt(faer::Side::Lower).map(|own| own.solve(&step));
    let length = weighed.map_or(0.0, |own| (step.transpose() * own)[(0, 0)].max(0.0).sqrt());
    Ok((shift, length))
}

fn size(point: &[f64]) -> f64 {
    point.iter().map(|x| x * x).sum::<f64>().sqrt() * f64::EPSILON
}

impl Found {
    /// The top of the likelihood of what is free of the noise, and the solution there.
    fn along_time(
        &mut self,
        (question, rows): (&mut Question, &mut dyn Rows),
        point: &mut [f64],
        lines: &[Option<Stated>],
        seen: &[Seen],
    ) -> Result<()> {
        let tested = self.tested.clone();
        let mut model = NoiseModel { parts: Vec::new(), range: Vec::new(), columns: tested.ncols() };
        let mut at = Vec::new();
        let mut slot = |free: bool, stated: f64, range: (f64, f64), model: &mut NoiseModel| {
            if !free {
                return Slot::Stated(stated);
            }
            model.range.push(range);
            at.push(stated.max(f64::MIN_POSITIVE).ln());
            Slot::Free(at.len() - 1)
        };
        let read: Vec<usize> = (0..self.noise.len()).filter(|s| question.is_read(*s)).collect();
        for s in &read {
            let (own, [free_white, free_size, free_tau]) = (&seen[*s], self.free[*s]);
            // the variance factor of the white noise as if nothing else scattered, and the variance of relative noise
            let (factor, natural) = (self.noise[*s].white.powi(2), own.rows / own.weight);
            let length = own.last - own.first.unwrap_or(own.last);
            let mut steps: Vec<f64> = own.steps.iter().copied().filter(|step| *step > 0.0).collect();
            // all at one time: any correlation time will do
            let step = crate::number::median(&mut steps).unwrap_or(1.0);
            let mut begin = self.noise[*s];
            if let Some(stated) = lines[*s] {
                // in units of the relative noise
                let deviation = stated.deviation.map(|sd| sd / natural.sqrt());
                begin = octaves::start(&own.octaves, step, length, Stated { deviation, ..stated });
                begin.deviation *= natural.sqrt();
            }
            let white = slot(free_white, begin.white.powi(2), white_range(factor, question.floor.at(*s)), &mut model);
            let deviation = lines[*s].is_some().then(|| {
                let size = begin.deviation.powi(2);
                let size = slot(free_size, size, deviation_range(factor * natural), &mut model);
                (size, slot(free_tau, begin.tau, time_range(step, length), &mut model))
            });
            model.parts.push(PartNoise { white, deviation });
        }
        // the priors
        model.parts.push(PartNoise { white: Slot::Stated(1.0), deviation: None });
        let linear_only = question.settings.estimator == Estimator::Linear;
        let mut at_end = vec![false; at.len()];
        for _ in 0..question.settings.iterations.max(1) {
            let mut gather = |noises: &[TimeNoise]| question.along(rows, point, &tested, noises);
            let top = model.top(&at, NEWTON_STEPS, &mut gather)?;
            (at, at_end, self.settled) = (top.at, top.at_end, top.converged);
            if linear_only {
                break;
            }
            let (change, length) = as_stated(&tested, &top.found, question.unknowns)?;
            point.iter_mut().zip(&change).for_each(|(x, dx)| *x += dx);
            // without them the squares of the rows are as many as their degrees of freedom
            let rest = seen.iter().map(|own| own.rows).sum::<f64>().sqrt();
            if question.is_linear || length <= NEGLIGIBLE * rest {
                break;
            }
        }
        for (s, part) in read.iter().zip(&model.parts) {
            let TimeNoise { white, deviation, tau } = part.at(&at);
            let at_low = |slot: Slot| matches!(slot, Slot::Free(k) if at_end[k] && at[k] < model.range[k].1);
            let zero = part.deviation.is_some_and(|(size, _)| at_low(size));
            if part.deviation.is_some() && at_low(part.white) {
                self.white_at_zero[*s] = true;
                self.free[*s][0] = false;
            }
            self.at_zero[*s] = zero;
            self.noise[*s] = Noise { white: white.sqrt(), deviation: if zero { 0.0 } else { deviation.sqrt() }, tau };
            if zero {
                self.free[*s][1..].fill(false);
            }
        }
        Ok(())
    }
}

/// An adjustment of all sensors at some noise.
pub(super) struct Together {
    pub found: Scaled,
    pub rows: Compressed,
    /// The same beside the known inputs that have an uncertainty, where there are such: what scales and tests come from. Their rows are behind the priors.
    pub extended: Option<(Scaled, Compressed)>,
    /// The sensor of each block of the rows; the priors are behind them.
    pub order: Vec<usize>,
    /// Variance factor of each sensor, 1 where it is not open.
    pub scale: Vec<f64>,
    /// Its redundancy.
    pub redundancy: Vec<f64>,
}

/// Adjust `parts`, one for each sensor that is read; `open` says whose scale is estimated.
pub(super) fn together(question: &Question, parts: &[Option<Part>], open: &[bool], point: &[f64]) -> Result<Together> {
    let of = |is_open: bool| (0..parts.len()).filter(move |s| parts[*s].is_some() && open[*s] == is_open);
    let order: Vec<usize> = of(true).chain(of(false)).collect();
    let n = question.unknowns;
    let blocks = order.iter().filter_map(|s| Some(parts[*s].as_ref()?.block())).chain([question.prior_block(point)]);
    let rows = Compressed::of(blocks.collect(), n, of(true).count());
    let white = |s: usize| parts[s].as_ref().map_or(1.0, |part| part.white);
    let least: Vec<f64> = of(true).map(|s| (question.floor.at(s) / white(s)).sqrt()).collect();
    let hints = ScaleHints { start: &[], least: &least, given: &[] };
    let settings = &question.settings.adjust;
    let extended = match question.carried.is_empty() {
        true => None,
        false => {
            let own = Compressed::of(question.extended_blocks(&rows.blocks), n + question.carried.len(), rows.groups);
            Some((own.adjust(&hints, settings)?, own))
        }
    };
    let told = extended.as_ref().map(|(own, _)| own);
    let given: Vec<Option<f64>> = told.iter().flat_map(|own| &own.scale).map(|scale| Some(*scale)).collect();
    let found = rows.adjust(&ScaleHints { given: &given, ..hints }, settings)?;
    let told = told.unwrap_or(&found);
    let (mut scale, mut redundancy) = (vec![1.0; parts.len()], vec![0.0; parts.len()]);
    for (k, s) in order.iter().enumerate() {
        scale[*s] = told.scale.get(k).map_or(1.0, |scale| scale * scale);
        redundancy[*s] = told.redundancy[k];
    }
    Ok(Together { found, rows, extended, order, scale, redundancy })
}

impl Together {
    /// `chi^2` of the residuals.
    pub(super) fn sum_of_squares(&self) -> f64 {
        self.extended.as_ref().map_or(self.found.sum_of_squares, |(own, _)| own.sum_of_squares)
    }
}

impl Part {
    /// The rows of the triangle, observations at the point of the design.
    pub(super) fn block(&self) -> Block {
        let mut block = Block { log_determinant: self.log_determinant, ..Block::folded(&self.fold) };
        // they are taken about another
        let away: Vec<f64> = self.fold.about().iter().map(|a| -a).collect();
        crate::linear::subtract(&mut block.observed, &block.rows, &away);
        block
    }
}

impl Question {
    /// Blocks beside the known inputs, the last with what is stated of these.
    pub(super) fn extended_blocks(&self, blocks: &[Block]) -> Vec<Block> {
        let (n, k) = (self.unknowns, self.carried.len());
        let mut all: Vec<Block> =
            blocks.iter().map(|own| Block { rows: self.extended(&own.rows), ..own.clone() }).collect();
        if let Some(last) = all.last_mut() {
            let before = last.rows.nrows();
            last.rows.resize_with(before + k, n + k, |i, j| f64::from(u8::from(i - before + n == j)));
            last.observed.resize(before + k, 0.0);
            last.size += k;
        }
        all
    }

    /// The priors as rows.
    pub(super) fn prior_block(&self, point: &[f64]) -> Block {
        let left: Vec<(usize, f64, f64)> =
            self.priors.iter().map(|(k, value, u)| (*k, value - point.at(*k), *u)).collect();
        Block::stated(self.unknowns + self.carried.len(), &left)
    }
}
