//! A random walk that the mission does not state: angle random walk of the gyros, velocity random walk of the accelerometers, and walks of their
//! biases (rate random walk, acceleration random walk; IEEE Std 952, 1293), of one axis or the same on each.
//!
//! With a walk of density `q` the innovations `e` of the residuals of some causes (see `whiten.rs`) have the likelihood
//!
//! ```text
//! -2 ln L(q) = sum e^2 + sum ln(h P h^T + u^2)          (the causes fitted anew for each q)
//! ```
//!
//! Long records are judged in fewer rows ([`shortened`](super::shortened)). A walk is named where it is far likelier than none and than every set of other
//! causes, and where its innovations are white: of unit variance in each channel, without correlation from row to row. Another pattern does not pass: one
//! density has to fit the sizes of seven channels.

use super::case::Case;
use super::cause::{Cause, Change};
use super::errors::{ErrorSource, Instrument};
use super::measured::CHANNELS;
use super::products::Products;
use super::random_walk::{UnstatedWalk, with};
use super::refine::{Search, State};
use super::search::Ordinary;
use super::shortened::Shortened;
use super::signatures::{Instant, instants, motion, times};
use super::whiten::{Walks, whiten};
use crate::diagnosis::NoiseFrom;
use crate::linear::dot;
use crate::uncertainty::quantiles::chi_square_survival;

/// Densities that are tried first: their range, and the factor between them. White noise in rad/sqrt(s) or (m/s)/sqrt(s) alike,
const RANGE: (f64, f64) = (1e-9, 1e-2);
/// walks of biases in (rad/s)/sqrt(s) and in (m/s^2)/sqrt(s).
const GYRO_RANGE: (f64, f64) = (1e-13, 1e-6);
const ACCELEROMETER_RANGE: (f64, f64) = (1e-10, 1e-3);
const FACTOR: f64 = 4.0;

/// The rows in which walks are searched for.
#[derive(Clone, Copy)]
struct Rows<'a> {
    short: &'a Shortened,
    /// Values that are left out.
    out: &'a [usize],
    /// Covariance of the walks that the mission states, and of one of the walks tried at a density of one.
    stated: &'a [Vec<Instant>],
    unit: &'a [Vec<Instant>],
    /// Columns of the given causes; the last is the observations that they explain.
    columns: &'a [Vec<f64>],
}

/// Does a walk of a bias move this one of the six?
fn moves(cause: &Cause, place: usize) -> bool {
    let Cause::BiasWalk(instrument, axis) = cause else { return false };
    let of_place = if place < 3 { Instrument::Gyro } else { Instrument::Accelerometer };
    of_place == *instrument && axis.is_none_or(|axis| axis == place % 3)
}

impl<'a> Search<'a> {
    /// The random walk, if any, that may explain the residuals of a state, or replace its causes that change in time.
    pub fn unstated_walk(&mut self, state: &State) -> Option<UnstatedWalk> {
        let fixed = self.is_complete(state) && state.set.iter().all(Cause::is_constant);
        if fixed || self.case.from != NoiseFrom::Stated {
            return None;
        }
        // given all ordinary causes
        let ordinary = self.ordinary.clone().or_else(|| self.ordinary(&state.out));
        let state = ordinary.unwrap_or_else(|| state.clone());
        let along = self.unstated_walk_along(&state);
        // a large error rotates the frame in which a walk propagates: along the errors of the state it may be likelier
        let case = self.case.clone();
        let errors = self.case.with(&state.set, &state.values);
        let Some(moved) = self.case.around(&errors, self.u) else { return along };
        self.case = moved;
        let turned = self.unstated_walk_along(&state);
        self.case = case;
        let alike = self.case.settings.indistinguishable;
        match (along, turned) {
            (Some(along), Some(turned)) => Some(if turned.deviance + alike < along.deviance { turned } else { along }),
            (along, turned) => along.or(turned),
        }
    }

    /// All ordinary causes together.
    fn ordinary(&mut self, out: &[usize]) -> Option<State> {
        let empty = self.refine(&[], &[], out)?;
        let far = self.is_far(&empty);
        [Ordinary::WithStart, Ordinary::Biases].into_iter().find_map(|which| self.begin(which, out, far))
    }

    /// The same, with the question's columns around the state.
    fn unstated_walk_along(&self, state: &State) -> Option<UnstatedWalk> {
        let observed = self.case.observed(&state.flown, &state.values);
        let weighed = self.weighed(&state.out);
        let short = &weighed.short;
        let columns: Vec<Vec<f64>> =
            state.flown.jacobian.iter().chain([&observed]).map(|column| short.column(column)).collect();
        let (out, stated) = (weighed.out(), &weighed.made.walks.instants);
        let carrying = |instrument| short.instants(&self.case.columns.carrying(&self.unit(instrument)));
        let none = Rows { short, out: &out, stated, unit: &[], columns: &columns };
        let gyro = Instrument::Gyro;
        let both = [gyro, Instrument::Accelerometer];
        let mut walks: Vec<UnstatedWalk> = Vec::new();
        for instrument in both {
            let unit = carrying(Some(instrument));
            walks.extend(self.likeliest(Cause::RandomWalk(instrument), RANGE, &Rows { unit: &unit, ..none }));
        }
        let unit = carrying(None);
        let rows = Rows { unit: &unit, ..none };
        for instrument in both {
            let range = if instrument == gyro { GYRO_RANGE } else { ACCELEROMETER_RANGE };
            for axis in [None, Some(0), Some(1), Some(2)] {
                let cause = Cause::BiasWalk(instrument, axis);
                walks.extend(self.likeliest(cause, range, &rows));
            }
        }
        walks.sort_by(|a, b| a.deviance.total_cmp(&b.deviance));
        let mut walks = walks.into_iter();
        let mut best = walks.next()?;
        let alike = self.case.settings.indistinguishable;
        // a walk follows any slow course, and is named only where it is clearly likelier than a wave, which counts its amplitude, its phase and its rate
        let price = 3.0 * (self.case.measured.count() as f64).max(1.0).ln();
        let biases = ErrorSource::biases();
        let is_moved = |cause: &Cause| {
            let place = biases.iter().position(|bias| *cause == Cause::Changing(*bias, Change::Ramp));
            place.is_some_and(|place| moves(&best.cause, place))
        };
        if matches!(best.cause, Cause::BiasWalk(..)) && self.gain_of_wave(state, is_moved) > best.gain + price - alike {
            return None;
        }
        let others = walks.map(|other| (other.cause, other.density, other.deviance - best.deviance));
        best.others = others.filter(|(_, _, excess)| *excess <= alike).collect();
        Some(best)
    }

    /// The density at which a walk is likeliest, if it is far likelier than none and leaves white innovations.
    fn likeliest(&self, cause: Cause, range: (f64, f64), rows: &Rows<'_>) -> Option<UnstatedWalk> {
        let fit = |density: f64| self.deviance(&cause, density, rows).map(|(deviance, _)| deviance);
        let none = fit(0.0)?;
        let mut best = (none, 0.0);
        let mut density = range.0;
        while density < range.1 {
            if let Some(deviance) = fit(density).filter(|deviance| *deviance < best.0) {
                best = (deviance, density);
            }
            density *= FACTOR;
        }
        if best.1 == 0.0 || none - best.0 < 0.5 * self.penalty {
            return None;
        }
        // golden section on the logarithm
        let share = 0.5 * (5f64.sqrt() - 1.0);
        let (mut low, mut high) = ((best.1 / FACTOR).ln(), (best.1 * FACTOR).ln());
        let inner = |low: f64, high: f64| (high - share * (high - low), low + share * (high - low));
        let (a, b) = inner(low, high);
        let (mut at_a, mut at_b) = (fit(a.exp())?, fit(b.exp())?);
        for _ in 0..18 {
            let (a, b) = inner(low, high);
            // one of the next two points is one of these
            if at_a < at_b {
                high = b;
                (at_a, at_b) = (fit(inner(low, high).0.exp())?, at_a);
            } else {
                low = a;
                (at_a, at_b) = (at_b, fit(inner(low, high).1.exp())?);
            }
        }
        let density = (0.5 * (low + high)).exp();
        let (deviance, white) = self.deviance(&cause, density, rows)?;
        // curvature of the deviance in the density's logarithm
        let step = 0.1_f64;
        let bend = (fit(density * step.exp())? - 2.0 * deviance + fit(density * (-step).exp())?) / (step * step);
        let u = if bend > 0.0 { density * (2.0 / bend).sqrt() } else { density };
        let unstated = UnstatedWalk { cause, density, u, deviance, gain: none - deviance, others: Vec::new() };
        (unstated.gain > self.penalty && self.is_white(&white, rows) && self.is_flat(&white, rows)).then_some(unstated)
    }

    /// The score of a state with all that its random walk costs.
    pub fn score_of_all(&self, state: &State) -> f64 {
        let rank_penalty = self.case.settings.rank_penalty;
        let walk = self.unstated.as_ref().map_or(0.0, |unstated| self.penalty + rank_penalty * unstated.cause.rank());
        self.case.spread(self.u, &state.out) + walk - 2.0 * state.value
    }

    /// Covariance of white noise of one instrument alone at the measured rows, for a density of one; or of none.
    fn unit(&self, instrument: Option<Instrument>) -> Vec<Vec<Instant>> {
        let case = &self.case;
        let mut mission = case.mission.clone();
        mission.errors = mission.errors.noiseless();
        mission.errors = instrument.map_or(mission.errors, |instrument| with(&mission.errors, instrument, 1.0));
        let runs = case.measured.runs.iter().zip(times(case.measured));
        runs.map(|(run, times)| instants(&mission, motion(&mission, run.motion), &times)).collect()
    }

    /// A walk of this density added to those of the mission.
    fn walks(&self, cause: &Cause, density: f64, unit: &[Vec<Instant>], stated: &[Vec<Instant>]) -> Walks {
        let square = density * density;
        let mut instants = unit.to_vec();
        instants.iter_mut().flatten().flat_map(|instant| instant.walk.iter_mut().flatten()).for_each(|v| *v *= square);
        for (instant, more) in instants.iter_mut().flatten().zip(stated.iter().flatten()) {
            let pairs = instant.walk.iter_mut().flatten().zip(more.walk.iter().flatten());
            pairs.for_each(|(v, more)| *v += more);
        }
        let mut biases = self.case.columns.walks.biases;
        let moved = biases.iter_mut().enumerate().filter(|(place, _)| moves(cause, *place));
        moved.for_each(|(_, q)| *q += square);
        Walks { instants, biases }
    }

    /// The question with a walk of a bias that no mission states.
    pub fn with_walk(&self, case: &Case<'a>, unstated: &UnstatedWalk) -> Case<'a> {
        case.with_walks(self.walks(
            &unstated.cause,
            unstated.density,
            &self.unit(None),
            &self.case.columns.walks.instants,
        ))
    }

    /// `-2 ln L` with a walk of this density added to those of the mission, and the innovations of the residuals.
    fn deviance(&self, cause: &Cause, density: f64, rows: &Rows<'_>) -> Option<(f64, Vec<f64>)> {
        let walks = self.walks(cause, density, rows.unit, rows.stated);
        let mut columns = rows.columns.to_vec();
        let size = whiten(&rows.short.measured, &walks, &rows.short.u, &mut columns);
        let residual = columns.pop()?;
        let (products, _) = Products::normalised(columns, &residual);
        let all: Vec<usize> = (0..products.columns().len()).collect();
        let solved = products.damped(&all, 1e-9)?;
        let mut innovations = residual;
        for (column, value) in products.columns().iter().zip(&solved.values) {
            innovations.iter_mut().zip(column.iter()).for_each(|(y, c)| *y -= c * value);
        }
        let deviance = dot(&innovations, &innovations) + size;
        deviance.is_finite().then_some((deviance, innovations))
    }

    /// Are innovations of unit size in each channel of each run, in both its halves, and without memory?
    fn is_white(&self, white: &[f64], rows: &Rows<'_>) -> bool {
        let measured = &rows.short.measured;
        let mut groups: Vec<Vec<f64>> = vec![Vec::new(); measured.runs.len() * CHANNELS];
        for (at, (cell, value)) in measured.cells().zip(white).enumerate() {
            if !rows.out.contains(&at) {
                groups.get_mut(cell.run * CHANNELS + cell.channel).into_iter().for_each(|group| group.push(*value));
            }
        }
        let most = self.case.settings.white;
        let sized = |values: &[f64]| {
            let n = values.len() as f64;
            ((dot(values, values) - n) / (2.0 * n).sqrt()).abs() < most
        };
        groups.iter().filter(|group| group.len() >= 8).all(|group| {
            let (first, second) = group.split_at(group.len() / 2);
            let memory: f64 = group.iter().zip(group.iter().skip(1)).map(|(a, b)| a * b).sum();
            sized(first) && sized(second) && (memory / (group.len() as f64).sqrt()).abs() < most
        })
    }

    /// Is the spectrum of innovations flat? Walks follow any slow course so well that innovations keep their size; what they cannot follow is a line
    /// or a band of their spectrum, summed over the channels: `2 |sum e_j exp(-i w j)|^2 / n` is chi-square with two degrees of freedom each.
    fn is_flat(&self, white: &[f64], rows: &Rows<'_>) -> bool {
        let measured = &rows.short.measured;
        let cells: Vec<_> = measured.cells().enumerate().filter(|(at, _)| !rows.out.contains(at)).collect();
        let (mut worst, mut tests) = (1.0_f64, 0.0);
        for run in 0..measured.runs.len() {
            let series = |channel: usize| -> Vec<f64> {
                let of_channel = cells.iter().filter(|(_, cell)| cell.run == run && cell.channel == channel);
                of_channel.filter_map(|(at, _)| white.get(*at).copied()).collect()
            };
            let all: Vec<Vec<f64>> = (0..CHANNELS).map(series).collect();
            // a value that is left out shifts the others by one row: as good as nothing; a channel that was measured seldom is left out
            let longest = all.iter().map(Vec::len).max().unwrap_or_default(); // no channel, no spectrum
            let all: Vec<&Vec<f64>> =
                all.iter().filter(|values| 10 * values.len() > 9 * longest && values.len() >= 16).collect();
            let power = |k: usize| -> f64 {
                let one = |values: &&Vec<f64>| {
                    let n = values.len() as f64;
                    let (mut re, mut im) = (0.0, 0.0);
                    for (j, e) in values.iter().enumerate() {
                        let (sine, cosine) = (std::f64::consts::TAU * k as f64 * j as f64 / n).sin_cos();
                        (re, im) = (re + e * cosine, im + e * sine);
                    }
                    2.0 * (re * re + im * im) / n
                };
                all.iter().map(one).sum()
            };
            let powers: Vec<f64> = (1..longest / 2).map(power).collect();
            let lines = 2.0 * all.len() as f64;
            let mut look = |sum: f64, count: usize, both: bool| {
                // a failed test decides nothing
                let p = chi_square_survival(sum, lines * count as f64).unwrap_or(1.0);
                worst = worst.min(if both { 2.0 * p.min(1.0 - p) } else { p });
                tests += 1.0;
            };
            if all.is_empty() {
                continue;
            }
            powers.iter().for_each(|p| look(*p, 1, false));
            let mut last = 0;
            let mut next = 2;
            while last < powers.len() {
                let band = powers.iter().take(next).skip(last);
                look(band.clone().sum(), band.count(), true);
                (last, next) = (next, 2 * next);
            }
        }
        worst * f64::max(tests, 1.0) > self.case.settings.serial()
    }
}
