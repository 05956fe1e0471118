//! Random walks that the mission does not state: angle random walk of the gyros, velocity random walk of the accelerometers, and walks of their
//! biases (rate random walk, acceleration random walk; IEEE Std 952, 1293), of one axis or the same on each.
//!
//! With walks of densities `q` the innovations `e` of the residuals of some causes (see `whiten.rs`) have the restricted likelihood
//!
//! ```text
//! -2 ln L(q) = sum e^2 + sum ln(h P h^T + u^2) + ln|C^T C|      (C: innovations of the causes' columns, which are fitted anew for each q)
//! ```
//!
//! It is minimised by scoring in `ln q`, with the information that the innovations have about it (N. K. Gupta and R. K. Mehra, IEEE Trans. Automatic
//! Control 19, 1974): `J_kl = sum (f_k f_l / 2 + d_k d_l)`, `f = d ln F / d ln q`, `d = dv / d ln q / F^(1/2)`, of innovations `v` with variance `F`.
//! The walks are searched for one by one: another one is added, one is removed or one stands in the place of another as long as that is likelier by more than
//! a walk costs. Of long records some rows are used ([`Shortened::picked`]).
//!
//! Walks are named where they are far likelier than none and than every set of other causes, and more probable than what channels do by themselves (the kernels
//! of `bank.rs`, given the same causes in the same rows), and where their innovations are white: of unit variance in each channel, without correlation from row
//! to row.

use super::bank::{matrix, of_channels};
use super::case::Case;
use super::cause::{Cause, Change};
use super::errors::{ErrorSource, Instrument};
use super::judged::largest;
use super::measured::{CHANNELS, Measured};
use super::products::INDEPENDENT;
use super::refine::{Search, State, UnstatedWalk};
use super::search::Ordinary;
use super::shortened::Shortened;
use super::signatures::{Instant, instants, motion, times};
use super::weighed::Weighed;
use super::whiten::{Walks, whiten};
use crate::diagnosis::{NoiseFrom, Priors, Problem, Score};
use crate::elements::Elements;
use crate::linear::{Triangle, dot, orthonormal};
use crate::uncertainty::quantiles::chi_square_survival;
use faer::Mat;
use std::cell::RefCell;

/// Densities that are tried first: their range, and the factor between them, from the best of which scoring goes on by steps no larger. White noise in rad/sqrt(s) or (m/s)/sqrt(s) alike,
const RANGE: (f64, f64) = (1e-9, 1e-2);
/// walks of biases in (rad/s)/sqrt(s) and in (m/s^2)/sqrt(s).
const GYRO_RANGE: (f64, f64) = (1e-13, 1e-6);
const ACCELEROMETER_RANGE: (f64, f64) = (1e-10, 1e-3);
const FACTOR: f64 = 10.0;
/// Step of a difference in `ln q`: its error, of the order of the step, is far below the statistical one.
const STEP: f64 = 1e-3;
/// Steps of one scoring, and of halving one of them, at most: they bound the work.
const SCORINGS: usize = 12;
const HALVINGS: usize = 6;
/// `-2 ln L` has settled where it falls by less than this: a seventh of a standard uncertainty.
const FLAT: f64 = 0.02;
/// Walks at once, at most: more of them follow any course of time, as causes that change do.
const MOST: usize = 3;

/// The rows in which walks are searched for.
struct Rows {
    short: Shortened,
    /// Values that are left out.
    out: Vec<usize>,
    /// Walks that the mission states, and covariance of the white noise of each instrument at a density of one.
    stated: Vec<Vec<Instant>>,
    units: [Vec<Vec<Instant>>; 2],
    /// Columns of the given causes, orthonormal where only noise is; the last is what these leave.
    columns: Vec<Vec<f64>>,
    /// The walks of a trial: its covariances are overwritten.
    walks: RefCell<Walks>,
}

/// What some densities leave.
struct Trial {
    deviance: f64,
    /// `ln|C^T C|` in it, which is left out where sets of causes differ.
    volume: f64,
    innovations: Vec<f64>,
    /// Logarithms of their variances.
    logs: Vec<f64>,
}

/// Walks with their likeliest densities.
#[derive(Clone)]
struct Fit {
    walks: Vec<Cause>,
    densities: Vec<f64>,
    u: Vec<f64>,
    deviance: f64,
    volume: f64,
}

/// Does a walk of a bias move this one of the six?
fn moves(cause: &Cause, place: usize) -> bool {
    let Cause::BiasWalk(instrument, axis) = cause else { return false };
    let of_place = if place < 3 { Instrument::Gyro } else { Instrument::Accelerometer };
    of_place == *instrument && axis.is_none_or(|axis| axis == place % 3)
}

/// The walks of these densities in addition to those that the mission states; `units` as in [`Rows`].
fn add(walks: &mut Walks, added: &[(Cause, f64)], units: &[Vec<Vec<Instant>>; 2], stated: &[Vec<Instant>]) {
    walks.biases = std::array::from_fn(|place| {
        added.iter().filter(|(cause, _)| moves(cause, place)).map(|(_, density)| density * density).sum()
    });
    let white = |instrument| {
        let of = |(cause, _): &&(Cause, f64)| *cause == Cause::RandomWalk(instrument);
        added.iter().filter(of).map(|(_, density)| density * density).sum::<f64>()
    };
    let squares = [white(Instrument::Gyro), white(Instrument::Accelerometer)];
    for (run, instants) in walks.instants.iter_mut().enumerate() {
        for (row, instant) in instants.iter_mut().enumerate() {
            let of = |all: &[Vec<Instant>]| all.get(run).and_then(|all| all.get(row)).map(|instant| instant.walk);
            instant.walk = of(stated).unwrap_or_default();
            for (unit, square) in units.iter().zip(squares).filter(|(_, square)| *square > 0.0) {
                let more = of(unit).unwrap_or_default();
                let pairs = instant.walk.iter_mut().flatten().zip(more.iter().flatten());
                pairs.for_each(|(v, more)| *v += square * more);
            }
        }
    }
}

/// The walks that are tried, with the range of their densities.
fn candidates() -> Vec<(Cause, (f64, f64))> {
    let of = |(instrument, range)| {
        let of_biases = [None, Some(0), Some(1), Some(2)].map(|axis| (Cause::BiasWalk(instrument, axis), range));
        [(Cause::RandomWalk(instrument), RANGE)].into_iter().chain(of_biases)
    };
    [(Instrument::Gyro, GYRO_RANGE), (Instrument::Accelerometer, ACCELEROMETER_RANGE)]
        .into_iter()
        .flat_map(of)
        .collect()
}

impl<'a> Search<'a> {
    /// The random walks, if any, that may explain the residuals of a state, or replace its causes.
    pub fn unstated_walks(&mut self, state: &State) -> Vec<UnstatedWalk> {
        // noise alone costs nothing, and a walk no less than this
        let is_cheap = self.is_complete(state)
            && -2.0 * state.value < state.rss + self.price(&Cause::RandomWalk(Instrument::Gyro));
        if is_cheap || self.case.from != NoiseFrom::Stated {
            return Vec::new();
        }
        // given all ordinary causes
        let ordinary = self.ordinary.clone().or_else(|| self.ordinary(&state.out));
        let state = ordinary.unwrap_or_else(|| state.clone());
        let along = self.unstated_walks_along(&state);
        // a large error rotates the frame in which a walk propagates: along the errors of the state it may be likelier
        let case = self.case.clone();
        let errors = self.case.with(&state.set, &state.values);
        let turned = self.case.around(&errors, self.u).and_then(|moved| {
            self.case = moved;
            self.unstated_walks_along(&state)
        });
        self.case = case;
        let alike = self.case.settings.indistinguishable;
        // `alike` is a difference of -2 ln L, the odds are ln: half of it
        let better =
            |turned: &(f64, Vec<UnstatedWalk>)| along.as_ref().is_none_or(|along| turned.0 > along.0 + 0.5 * alike);
        // what channels do by themselves follows any course, too: of the two walks have the posterior p where their odds are p/(1 - p) times as large
        let certain = self.case.settings.common.probability;
        let is_named =
            |(odds, _): &(f64, Vec<UnstatedWalk>)| odds - self.remainder(&state) >= (certain / (1.0 - certain)).ln();
        turned.filter(better).or(along).filter(is_named).map(|(_, walks)| walks).unwrap_or_default()
    }

    /// All ordinary causes together.
    fn ordinary(&mut self, out: &[usize]) -> Option<State> {
        let empty = self.refine(&[], &[], out)?;
        let from = (!self.is_far(&empty)).then_some(&empty);
        [Ordinary::WithStart, Ordinary::Biases].into_iter().find_map(|which| self.begin(which, out, from))
    }

    /// The same, with the question's columns around the state; with ln of their odds against none.
    fn unstated_walks_along(&self, state: &State) -> Option<(f64, Vec<UnstatedWalk>)> {
        let rows = self.rows_of_walks(state, None, Shortened::picked);
        let all = candidates();
        let none = rows.fit(&[], &[])?;
        let alone: Vec<Fit> = all.iter().filter_map(|(cause, range)| rows.with(&[], *cause, *range)).collect();
        let cost = |fit: &Fit| fit.deviance + fit.walks.iter().map(|cause| self.price(cause)).sum::<f64>();
        let likelier = |a: &Fit, b: &Fit| cost(a).total_cmp(&cost(b));
        let mut best = none.clone();
        loop {
            let near = rows.near(&best, &none, &alone);
            match near.into_iter().min_by(likelier).filter(|fit| cost(fit) < cost(&best) - FLAT) {
                Some(better) => best = better,
                None => break,
            }
        }
        if best.walks.is_empty() || self.is_wave(state, &best, none.deviance - best.deviance) {
            return None;
        }
        // of few rows innovations may be white that are not in all
        let whole = self.rows_of_walks(state, None, Shortened::whole);
        let logs: Vec<f64> = best.densities.iter().map(|density| density.ln()).collect();
        let innovations = whole.trial(&best.walks, &logs)?.innovations;
        if !self.is_white(&innovations, &whole) || !self.is_flat(&innovations, &whole) {
            return None;
        }
        let near = rows.near(&best, &none, &alone);
        let alike = self.case.settings.indistinguishable;
        let one = |(place, cause): (usize, &Cause)| {
            let others: Vec<Cause> = best.walks.iter().copied().filter(|other| other != cause).collect();
            let keeps = |fit: &&Fit| others.iter().all(|other| fit.walks.contains(other)) && !fit.walks.contains(cause);
            let excess = |fit: &Fit| fit.deviance - best.deviance;
            let without = near.iter().filter(keeps).find(|fit| fit.walks.len() == others.len());
            let other = |fit: &Fit| {
                let at = fit.walks.iter().position(|other| !others.contains(other))?;
                Some((*fit.walks.get(at)?, *fit.densities.get(at)?, excess(fit)))
            };
            let replaced = near.iter().filter(keeps).filter(|fit| excess(fit) <= alike);
            let mut others: Vec<_> = replaced.filter_map(other).collect();
            others.sort_by(|a, b| a.2.total_cmp(&b.2));
            let gain = without.map_or(0.0, excess);
            UnstatedWalk { cause: *cause, density: best.densities.at(place), u: best.u.at(place), gain, others }
        };
        Some((0.5 * (none.deviance - cost(&best)), best.walks.iter().enumerate().map(one).collect()))
    }

    /// Rows for the residuals of a state; without one of its causes.
    fn rows_of_walks(&self, state: &State, without: Option<usize>, rows: fn(&Measured, &[f64]) -> Shortened) -> Rows {
        let mut residual = self.case.residual(&state.flown.predicted);
        let mut columns: Vec<&Vec<f64>> = state.flown.jacobian.iter().collect();
        if let Some(place) = without.filter(|place| *place < columns.len()) {
            let (column, value) = (columns.remove(place), state.values.at(place));
            residual.iter_mut().zip(column).for_each(|(y, c)| *y += value * c);
        }
        let short = rows(self.case.measured, &self.case.without(self.u, &state.out));
        let over_u = |column: &Vec<f64>| short.column(column).iter().zip(&short.u).map(|(v, u)| v / u).collect();
        // causes of which only a sum is observable are as good as one
        let given = orthonormal(columns.into_iter().map(over_u), INDEPENDENT);
        let times_u = |column: Vec<f64>| column.iter().zip(&short.u).map(|(v, u)| v * u).collect();
        let mut columns: Vec<Vec<f64>> = given.into_iter().map(times_u).collect();
        columns.push(short.column(&residual));
        let carrying = |instants: &[Vec<Instant>]| short.instants(&self.case.columns.carrying(instants));
        let units = self.units().each_ref().map(|unit| carrying(unit));
        Rows {
            out: short.out(&state.out),
            stated: carrying(&self.stated.instants),
            walks: RefCell::new(Walks { instants: units[0].clone(), biases: Default::default() }),
            units,
            columns,
            short,
        }
    }

    /// Walks that fit as well in the place of a cause of a state: of a bias that changes, its walk; beside walks that are added any, since what a second one
    /// has done so far may look like a constant.
    pub fn walks_instead(&self, state: &State, place: usize) -> Vec<(Cause, f64, f64)> {
        let (now, densities): (Vec<Cause>, Vec<f64>) =
            self.unstated.iter().map(|walk| (walk.cause, walk.density)).unzip();
        let own = match state.set.get(place) {
            Some(Cause::Changing(source, _)) => ErrorSource::biases().iter().position(|bias| bias == source),
            _ => None,
        };
        if now.len() >= MOST || (now.is_empty() && own.is_none()) || self.case.from != NoiseFrom::Stated {
            return Vec::new();
        }
        let Some(with) = self.rows_of_walks(state, None, Shortened::picked).fit(&now, &densities) else {
            return Vec::new();
        };
        let rows = self.rows_of_walks(state, Some(place), Shortened::picked);
        let beside: Vec<(Cause, f64)> = now.iter().copied().zip(densities).collect();
        let one = |(cause, range): (Cause, (f64, f64))| {
            let fit = rows.with(&beside, cause, range)?;
            Some((cause, *fit.densities.last()?, fit.deviance - fit.volume - (with.deviance - with.volume)))
        };
        let could = |cause: &Cause| !now.contains(cause) && own.map_or(!now.is_empty(), |own| moves(cause, own));
        let others = candidates().into_iter().filter(|(cause, _)| could(cause)).filter_map(one);
        others.filter(|(_, _, excess)| *excess <= self.case.settings.indistinguishable).collect()
    }

    /// The question in rows that stand for stretches of time.
    fn picked_rows(&self, state: &State) -> Weighed {
        let short = Shortened::picked(self.case.measured, &self.case.without(self.u, &state.out));
        Weighed::of_rows(&self.case, short, &state.out)
    }

    /// ln of the odds of what channels do by themselves against noise alone, given the causes of a state.
    fn remainder(&self, state: &State) -> f64 {
        let rows = self.picked_rows(state);
        let basis = orthonormal(rows.rows(state.flown.jacobian.iter()), INDEPENDENT);
        let mut residual = rows.rows([&self.case.residual(&state.flown.predicted)].into_iter());
        let residual = residual.pop().unwrap_or_default();
        let (basis, none) = (matrix(residual.len(), &basis), Mat::zeros(residual.len(), 0));
        let problem = Problem {
            residual: &residual,
            basis: basis.as_ref(),
            columns: none.as_ref(),
            prior: &[],
            plain: &[],
            fixed: &[],
            kinds: &[],
            known: true,
            kernels: &of_channels(&rows, &residual),
            sharing: None,
        };
        Score::new(
            &problem,
            Priors { largest: largest(&residual), ..Priors::at(self.case.settings.common.significance) },
        )
        .remainder(&[])
    }

    /// Is a wave of a bias that walks more likely than its walk? A walk follows any slow course, and is named only where it is clearly likelier than a
    /// wave, which counts its amplitude, its phase and its rate.
    fn is_wave(&self, state: &State, fit: &Fit, gain: f64) -> bool {
        let price = 3.0 * (self.case.measured.count() as f64).max(1.0).ln();
        let biases = ErrorSource::biases();
        let is_moved = |cause: &Cause| {
            let place = biases.iter().position(|bias| *cause == Cause::Changing(*bias, Change::Ramp));
            place.is_some_and(|place| fit.walks.iter().any(|walk| moves(walk, place)))
        };
        let rows = self.picked_rows(state);
        self.gain_of_wave(state, &rows, is_moved) > gain + price - self.case.settings.indistinguishable
    }

    /// What a walk costs, in variances of the noise: as a cause of its rank does.
    fn price(&self, cause: &Cause) -> f64 {
        self.penalty + self.case.settings.rank_penalty * cause.rank()
    }

    /// The score of a state with all that its random walks cost.
    pub fn score_of_all(&self, state: &State) -> f64 {
        let walks: f64 = self.unstated.iter().map(|walk| self.price(&walk.cause)).sum();
        self.case.spread(self.u, &state.out) + walks - 2.0 * state.value
    }

    /// Covariance of white noise of the gyros, and of the accelerometers, at the measured rows, for a density of one.
    fn units(&self) -> &[Vec<Vec<Instant>>; 2] {
        self.units.get_or_init(|| {
            [Instrument::Gyro, Instrument::Accelerometer].map(|instrument| {
                let mut mission = self.case.mission.clone();
                mission.errors = mission.errors.noiseless().walking(instrument, 1.0);
                let runs = self.case.measured.runs.iter().zip(times(self.case.measured));
                runs.map(|(run, times)| instants(&mission, motion(&mission, run.motion), &times)).collect()
            })
        })
    }

    /// The question with walks in addition to those that the mission states.
    pub fn with_walks(&self, case: &Case<'a>, stated: &Walks, added: &[UnstatedWalk]) -> Case<'a> {
        let added: Vec<(Cause, f64)> = added.iter().map(|walk| (walk.cause, walk.density)).collect();
        let units = self.units().each_ref().map(|unit| case.columns.carrying(unit));
        let mut walks = Walks { instants: units[0].clone(), biases: Default::default() };
        add(&mut walks, &added, &units, &case.columns.carrying(&stated.instants));
        case.with_walks(walks)
    }

    /// Are innovations of unit size in each channel of each run, in both its halves, and without memory?
    fn is_white(&self, white: &[f64], rows: &Rows) -> bool {
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
    fn is_flat(&self, white: &[f64], rows: &Rows) -> bool {
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
                    // a step of the phase is a rotation
                    let (sin_step, cos_step) = (std::f64::consts::TAU * k as f64 / n).sin_cos();
                    let (mut sine, mut cosine) = (0.0, 1.0);
                    for e in values.iter() {
                        (re, im) = (re + e * cosine, im + e * sine);
                        (sine, cosine) = (sine * cos_step + cosine * sin_step, cosine * cos_step - sine * sin_step);
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

impl Rows {
    /// Fits with one walk more, one less, or another one in the place of one.
    fn near(&self, best: &Fit, none: &Fit, alone: &[Fit]) -> Vec<Fit> {
        if best.walks.is_empty() {
            return alone.to_vec();
        }
        let mut near = Vec::new();
        let now: Vec<(Cause, f64)> = best.walks.iter().copied().zip(best.densities.iter().copied()).collect();
        let mut add = |walks: &[(Cause, f64)]| {
            let known = match walks {
                [] => Some(none.clone()),
                [(cause, _)] => alone.iter().find(|fit| fit.walks.contains(cause)).cloned(),
                _ => {
                    let (causes, densities): (Vec<Cause>, Vec<f64>) = walks.iter().copied().unzip();
                    self.fit(&causes, &densities)
                }
            };
            near.extend(known);
        };
        for place in 0..now.len() {
            let mut fewer = now.clone();
            fewer.remove(place);
            add(&fewer);
        }
        for fit in alone {
            let Some(other) = fit.walks.first().copied().zip(fit.densities.first().copied()) else { continue };
            if best.walks.contains(&other.0) {
                continue;
            }
            for place in 0..now.len() {
                let mut instead = now.clone();
                instead.get_mut(place).into_iter().for_each(|slot| *slot = other);
                add(&instead);
            }
            if now.len() < MOST {
                let more: Vec<(Cause, f64)> = now.iter().copied().chain([other]).collect();
                add(&more);
            }
        }
        near
    }

    /// One walk more, beside others at densities near these.
    fn with(&self, beside: &[(Cause, f64)], cause: Cause, range: (f64, f64)) -> Option<Fit> {
        let (mut walks, mut densities): (Vec<Cause>, Vec<f64>) = beside.iter().copied().unzip();
        walks.push(cause);
        let mut best: Option<(f64, f64)> = None;
        let mut density = range.0;
        while density < range.1 * FACTOR {
            let logs: Vec<f64> = densities.iter().chain([&density]).map(|density| density.ln()).collect();
            let trial = self.trial(&walks, &logs).filter(|trial| best.is_none_or(|best| trial.deviance < best.0));
            best = trial.map(|trial| (trial.deviance, density)).or(best);
            density *= FACTOR;
        }
        densities.push(best?.1);
        self.fit(&walks, &densities)
    }

    /// Walks at their likeliest densities, from some; `None` where the data show nothing of one of them.
    fn fit(&self, walks: &[Cause], start: &[f64]) -> Option<Fit> {
        let mut logs: Vec<f64> = start.iter().map(|density| density.ln()).collect();
        let mut now = self.trial(walks, &logs)?;
        let mut u = Vec::new();
        for _ in 0..SCORINGS {
            // of each walk its gradient, and what it does to the logarithms of the variances and to the innovations
            let mut slopes = Vec::with_capacity(walks.len());
            for k in 0..walks.len() {
                let mut moved = logs.clone();
                moved.get_mut(k).into_iter().for_each(|slot| *slot += STEP);
                let moved = self.trial(walks, &moved)?;
                let spread: Vec<f64> = moved.logs.iter().zip(&now.logs).map(|(a, b)| (a - b) / STEP).collect();
                let pairs = moved.innovations.iter().zip(&now.innovations).zip(&spread);
                let shift: Vec<f64> = pairs.map(|((a, b), f)| (a - b) / STEP + 0.5 * b * f).collect();
                slopes.push(((moved.deviance - now.deviance) / STEP, spread, shift));
            }
            let entry = |k: usize, l: usize| match (slopes.get(k), slopes.get(l)) {
                (Some(a), Some(b)) => 0.5 * dot(&a.1, &b.1) + dot(&a.2, &b.2),
                // both are below `walks.len()`
                _ => f64::NAN,
            };
            let information = Triangle::of(walks.len(), entry, |_| 0.0)?;
            let gradient: Vec<f64> = slopes.iter().map(|slope| -0.5 * slope.0).collect();
            let step = information.solve(&gradient);
            let inverse = information.inverse();
            u = inverse.iter().enumerate().filter_map(|(k, row)| Some(row.get(k)?.sqrt())).collect();
            // no further at once than from one of the densities tried first to the next
            let largest = step.iter().fold(FACTOR.ln(), |most, v| most.max(v.abs()));
            let trials = (0..HALVINGS).find_map(|halving| {
                let share = FACTOR.ln() / largest * 0.5_f64.powi(i32::try_from(halving).unwrap_or_default());
                let moved: Vec<f64> = logs.iter().zip(&step).map(|(a, b)| a + share * b).collect();
                let trial = self.trial(walks, &moved).filter(|trial| trial.deviance <= now.deviance)?;
                Some((moved, trial))
            });
            let Some((moved, trial)) = trials else { break };
            let fall = now.deviance - trial.deviance;
            (logs, now) = (moved, trial);
            if fall < FLAT {
                break;
            }
        }
        let densities: Vec<f64> = logs.iter().map(|log| log.exp()).collect();
        let u = densities.iter().zip(&u).map(|(density, u)| density * u).collect();
        Some(Fit { walks: walks.to_vec(), densities, u, deviance: now.deviance, volume: now.volume })
    }

    /// `-2 ln L` with walks of these densities, given by their logarithms, added to those of the mission, and the innovations of the residuals.
    fn trial(&self, walks: &[Cause], logs: &[f64]) -> Option<Trial> {
        let added: Vec<(Cause, f64)> = walks.iter().copied().zip(logs.iter().map(|log| log.exp())).collect();
        let mut walks = self.walks.borrow_mut();
        add(&mut walks, &added, &self.units, &self.stated);
        let mut columns = self.columns.to_vec();
        let logs = whiten(&self.short.measured, &walks, &self.short.u, &mut columns);
        let mut innovations = columns.pop()?;
        let gram = |i: usize, j: usize| columns.get(i).zip(columns.get(j)).map_or(f64::NAN, |(a, b)| dot(a, b));
        let triangle = Triangle::of(columns.len(), gram, |_| 0.0)?;
        let along: Vec<f64> = columns.iter().map(|column| dot(column, &innovations)).collect();
        for (column, by) in columns.iter().zip(triangle.solve(&along)) {
            innovations.iter_mut().zip(column).for_each(|(e, c)| *e -= by * c);
        }
        let volume = triangle.log_determinant();
        let deviance = dot(&innovations, &innovations) + logs.iter().sum::<f64>() + volume;
        deviance.is_finite().then_some(Trial { deviance, volume, innovations, logs })
    }
}
