//! What changes in time: the times of steps and warm-ups, refined between the points of the grid of candidates, and a bias or a channel of the reference that
//! oscillates, as under a temperature that is held between two limits.
//!
//! ```text
//! x sin(2 pi t / T + phase) = a cos(2 pi t / T) + b sin(2 pi t / T),      x^2 = a^2 + b^2,  tan(phase) = a / b
//! ```
//!
//! At a period `T` it is linear in `a` and `b`. Every bias and every channel is tried with every whole number of half waves in the run, given a set and
//! given nothing; the period is refined about the best. The waves that reduce the sum of squares most are candidates.
//!
//! What is switched between `x` and `-x` with a period is a square wave. Its first wave is the largest one wherever it is switched, and has its middle in a crest; so
//! each such wave is tried as one, and its two edges and its period are refined. Where that reduces the sum of squares more, it is a candidate, too.

use super::cause::{Cause, Change};
use super::changing::{Columns, Course};
use super::products::INDEPENDENT;
use super::refine::{Search, State};
use super::shortened::Shortened;
use super::weighed::{CourseFit, Given, Waves, Weighed};
use crate::elements::Elements;
use crate::linear::dot;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::rc::Rc;

/// Half waves in a run that are tried: fewer are a ramp or a warm-up,
const LEAST: usize = 2;
/// and no more than this, which bounds the work: up to one half wave between two rows they are periods that the rows tell apart (H. Nyquist).
const MOST: usize = 160;
/// Waves that are candidates: those that reduce the sum of squares most, of each bias and channel one. They bound the work; a second wave of a set is a
/// candidate given the first.
const CANDIDATES: usize = 4;

/// Shares of a period that are tried at first: that many less one, equally apart.
const SHARES: i32 = 16;

/// Trials on each side of a time, on each of so many levels.
const PARTS: i32 = 8;
const LEVELS: i32 = 5;

/// Rounds of refining the edges and the period of a square wave in turn, at most,
const ROUNDS: usize = 24;
/// and of one that stands for a wave of a set.
const ROUNDS_OF_WAVE: usize = 6;
/// A refinement that reduces the sum of squares by less, in variances of the noise, is none.
const SHARPER: f64 = 0.5;

/// How a time is varied: by how much at first.
#[derive(Clone, Copy)]
enum By {
    /// A step's time, s.
    Shift(f64),
    /// A warm-up's, in its logarithm.
    Factor(f64),
    /// A wave's period, by one half wave more or less in a time as long as this, s.
    HalfWave(f64),
}

impl By {
    /// The time near `start` at which `try_at` is least, on ever finer grids, with its value there; `None` where it has none at the start.
    fn finest<T>(self, start: f64, try_at: impl Fn(f64) -> Option<(f64, T)>) -> Option<(f64, T)> {
        let (mut best, mut time, mut width) = (try_at(start)?, start, 1.0);
        for _ in 0..LEVELS {
            let middle = time;
            for part in (-PARTS..=PARTS).filter(|part| *part != 0) {
                let trial = self.moved(middle, width * f64::from(part) / f64::from(PARTS));
                if !(trial > 0.0 && trial.is_finite()) {
                    continue;
                }
                if let Some(better) = try_at(trial).filter(|(least, _)| *least < best.0) {
                    (best, time) = (better, trial);
                }
            }
            width *= 1.5 / f64::from(PARTS);
        }
        Some(best)
    }

    fn moved(self, time: f64, share: f64) -> f64 {
        match self {
            By::Shift(most) => time + share * most,
            By::Factor(most) => time * (share * most).exp(),
            // what is longer than the run is no wave that it shows
            By::HalfWave(last) => (1.0 / (1.0 / time + share * 0.5 / last).max(f64::MIN_POSITIVE)).min(last),
        }
    }
}

/// By how much a column of unit norm reduces the sum of squares given others; `None` where it depends on them.
fn gain(column: &[f64], (basis, residual): &Given) -> Option<f64> {
    let outside = 1.0 - basis.iter().map(|b| dot(b, column).powi(2)).sum::<f64>();
    (outside > INDEPENDENT).then(|| dot(column, residual).powi(2) / outside)
}

impl Weighed {
    /// Cosine and sine of a wave of this period of a bias or a channel, weighed; `None` for what does not wave.
    fn both(&self, of: &Cause, period: f64) -> Option<[Vec<f64>; 2]> {
        of.with_change(Change::Ramp).map(|_| self.along(of, &courses(period)))
    }

    /// The weighed columns of a bias or a channel that goes so.
    fn along(&self, of: &Cause, courses: &[Course; 2]) -> [Vec<f64>; 2] {
        let mut columns = courses.each_ref().map(|course| self.made.changing(of, course));
        self.weigh(&mut columns);
        columns
    }

    /// The best phase of a wave; `None` for what does not wave, or is not independent.
    pub(super) fn wave(&self, of: &Cause, period: f64, given: &Given) -> Option<CourseFit> {
        phased(of, period, &self.both(of, period)?, given)
    }

    /// The wave of the best period near this one, in a run that is so long.
    pub(super) fn finest_wave(&self, of: &Cause, near: f64, given: &Given, last: f64) -> Option<CourseFit> {
        let at = |period: f64| self.wave(of, period, given).map(|fit| (-fit.gain, fit));
        By::HalfWave(last).finest(near, at).map(|(_, fit)| fit)
    }

    /// A square wave with the edges and the period that explain most, near some, after so many rounds at most; in a run that is so long.
    pub(super) fn square(&self, near: &Cause, given: &Given, last: f64, rounds: usize) -> Option<CourseFit> {
        let Some(Change::Square { period, middle, share }) = near.change() else { return None };
        let (mut period, mut edges) = (period, [middle - 0.5 * share * period, middle + 0.5 * share * period]);
        let at = |period: f64, [rise, fall]: [f64; 2]| {
            let (middle, share) = (0.5 * (rise + fall), (fall - rise) / period);
            let change = near.with_change(Change::Square { period, middle, share })?;
            let fit = self.fit(change, given).filter(|_| share > 0.0 && share < 1.0)?;
            Some((-fit.gain, (fit, period, [rise, fall])))
        };
        let turns =
            |time: f64, edges: [f64; 2], period: f64| ((time - 0.5 * edges.iter().sum::<f64>()) / period).round();
        let (mut least, (mut best, ..)) = at(period, edges)?;
        for _ in 0..rounds {
            let before = least;
            // the edges of the middle of the run by themselves, then the period about its middle, its beginning and its end: several edges
            // move at once where no single one explains more
            for k in 0..5 {
                let middle = turns(0.5 * last, edges, period);
                edges = edges.map(|edge| edge + middle * period);
                let found = match edges.get(k) {
                    Some(edge) => By::Shift(0.25 * period).finest(*edge, |edge| {
                        let mut moved = edges;
                        moved.iter_mut().skip(k).take(1).for_each(|slot| *slot = edge);
                        at(period, moved)
                    }),
                    None => {
                        let held = turns([0.5_f64, 0.0, 1.0].at(k - 2) * last, edges, period);
                        let moved = |to: f64| at(to, edges.map(|edge| edge - held * (to - period)));
                        By::HalfWave(last).finest(period, moved)
                    }
                };
                if let Some((value, found)) = found {
                    (least, (best, period, edges)) = (value, found);
                }
            }
            if before - least < SHARPER {
                break;
            }
        }
        Some(best)
    }

    /// The square wave near the one of which this is the first wave that explains more; its edges are refined further in a set.
    fn switched(&self, wave: &CourseFit, given: &Given, last: f64, rounds: usize) -> Option<CourseFit> {
        let Some(Change::Wave { period, phase }) = wave.cause.change() else { return None };
        let middle = period * (0.25 - phase / TAU);
        let shares = (1..SHARES).map(|k| f64::from(k) / f64::from(SHARES));
        let of = |share| self.fit(wave.cause.with_change(Change::Square { period, middle, share })?, given);
        let near = shares.filter_map(of).max_by(|a, b| a.gain.total_cmp(&b.gain))?;
        // the work is bounded: a round each where many are tried, and where that can be expected to explain more
        let is_tried = rounds > 1 || near.gain > wave.gain;
        let square = is_tried.then(|| self.square(&near.cause, given, last, rounds)).flatten();
        square.filter(|square| square.gain > wave.gain)
    }
}

/// Cosine and sine of a period.
fn courses(period: f64) -> [Course; 2] {
    [FRAC_PI_2, 0.0].map(|phase| Course::of(Change::Wave { period, phase }))
}

fn phased(of: &Cause, period: f64, [cosine, sine]: &[Vec<f64>; 2], (basis, residual): &Given) -> Option<CourseFit> {
    let (c, s) = (dot(cosine, cosine), dot(sine, sine));
    let (mut cc, mut cs, mut ss) = (c, dot(cosine, sine), s);
    for direction in basis {
        let (along_c, along_s) = (dot(direction, cosine), dot(direction, sine));
        (cc, cs, ss) = (cc - along_c * along_c, cs - along_c * along_s, ss - along_s * along_s);
    }
    let determinant = cc * ss - cs * cs;
    if !(cc > INDEPENDENT * c && ss > INDEPENDENT * s && determinant > INDEPENDENT * cc * ss) {
        return None;
    }
    let (along_c, along_s) = (dot(cosine, residual), dot(sine, residual));
    let a = (ss * along_c - cs * along_s) / determinant;
    let b = (cc * along_s - cs * along_c) / determinant;
    let cause = of.with_change(Change::Wave { period, phase: a.atan2(b) })?;
    Some(CourseFit { cause, size: a.hypot(b), gain: a * along_c + b * along_s })
}

/// The largest gain of some waves, and its period.
fn largest<'a>(
    cause: &Cause,
    waves: impl IntoIterator<Item = &'a (f64, [Vec<f64>; 2])>,
    given: &Given,
) -> Option<(f64, f64)> {
    let fits =
        waves.into_iter().filter_map(|(period, both)| Some((phased(cause, *period, both, given)?.gain, *period)));
    fits.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// What may grow may oscillate: one cause of each bias and each channel.
fn grows(cause: &Cause) -> bool {
    cause.change() == Some(Change::Ramp)
}

impl Search<'_> {
    /// The time of the last row, s, above zero.
    pub(super) fn last(&self) -> f64 {
        self.case.measured.last_time().max(f64::MIN_POSITIVE)
    }

    /// What changes in time and reduces the sum of squares most, its times and periods refined: given a state's set, given nothing, given its constants and
    /// all biases, and given all of it but one cause, which another time or period may have brought in.
    pub(super) fn likeliest(&self, state: &State) -> Vec<Cause> {
        let rows = self.weighed(&state.out);
        let (columns, observed) = self.linearised(state, &rows);
        let with = |keep: &dyn Fn(usize) -> bool| {
            let kept = columns.iter().enumerate().filter(|(k, _)| keep(*k)).map(|(_, column)| column.clone());
            rows.given(kept, observed.clone())
        };
        let is_constant = |k: usize| state.set.get(k).is_some_and(Cause::is_constant);
        let mut conditions = vec![(with(&|_| true), CANDIDATES)];
        if !state.set.is_empty() {
            conditions.push((with(&|_| false), CANDIDATES));
        }
        // what changes may change around any value: beside the constants of the set, those of all biases
        let biases =
            self.case.causes.iter().zip(&rows.unit).filter(|(cause, (_, norm))| cause.is_bias() && *norm > 0.0);
        let biases = biases.map(|(_, (column, _))| column.as_ref().clone());
        let constants = columns.iter().enumerate().filter(|(k, _)| is_constant(*k)).map(|(_, column)| column.clone());
        conditions.push((rows.given(constants.chain(biases), observed.clone()), CANDIDATES));
        if columns.len() > 1 {
            conditions.extend((0..columns.len()).map(|omitted| (with(&|k| k != omitted), 1)));
        }
        let last = self.last();
        let mut found = self.timed(&rows, &conditions);
        let mut coarse: Vec<Vec<(f64, f64, Cause)>> = vec![Vec::new(); conditions.len()];
        for (cause, waves) in self.waves(&rows) {
            for ((given, _), all) in conditions.iter().zip(&mut coarse) {
                all.extend(largest(cause, waves, given).map(|(gain, period)| (gain, period, *cause)));
            }
        }
        // what the integrals of a bias leave of its edges is little: the wave of a set may be a square wave that explains more once it is refined
        let square = |(place, member): (usize, &Cause)| {
            let Some(Change::Wave { period, .. }) = member.change() else { return None };
            let given = with(&|k| k != place);
            let square = rows.switched(&rows.wave(member, period, &given)?, &given, last, ROUNDS_OF_WAVE)?;
            Some(square.cause).filter(|cause| !self.case.is_absurd(cause, square.size))
        };
        found.extend(state.set.iter().enumerate().filter_map(square));
        for ((given, count), mut all) in conditions.iter().zip(coarse) {
            all.sort_by(|a, b| b.0.total_cmp(&a.0));
            let finest = |(_, period, cause): &(f64, f64, Cause)| rows.finest_wave(cause, *period, given, last);
            let fits: Vec<CourseFit> = all.iter().take(*count).filter_map(finest).collect();
            // the work is bounded: beside the set, nothing and constants
            let first = fits.first().filter(|_| *count == CANDIDATES);
            let square = first.and_then(|first| rows.switched(first, given, last, 1));
            let fits = square.into_iter().chain(fits).filter(|fit| !self.case.is_absurd(&fit.cause, fit.size));
            found.extend(fits.map(|fit| fit.cause));
        }
        found
    }

    /// By how much the likeliest wave, or square wave, of some biases reduces the sum of squares beside a state's set.
    pub(super) fn gain_of_wave(&self, state: &State, rows: &Weighed, is_of: impl Fn(&Cause) -> bool) -> f64 {
        let (columns, observed) = self.linearised(state, rows);
        let (given, last) = (rows.given(columns, observed), self.last());
        let gain = |(cause, waves): &(Cause, Vec<(f64, [Vec<f64>; 2])>)| {
            let (_, period) = largest(cause, waves, &given)?;
            let wave = rows.finest_wave(cause, period, &given, last)?;
            Some(rows.switched(&wave, &given, last, 1).map_or(wave.gain, |square| square.gain))
        };
        self.waves_of(is_of, rows).iter().filter_map(gain).fold(0.0, f64::max)
    }

    /// Waves of each bias and channel.
    fn waves<'b>(&self, rows: &'b Weighed) -> &'b Waves {
        rows.waves.get_or_init(|| self.waves_of(|_| true, rows))
    }

    /// Waves of some biases and channels with every whole number of half waves in the run.
    fn waves_of(&self, is_of: impl Fn(&Cause) -> bool, rows: &Weighed) -> Waves {
        let (last, most) = (self.last(), rows.short.measured.longest_run().saturating_sub(1).clamp(LEAST, MOST));
        let waving = self.case.causes.iter().filter(|cause| grows(cause) && is_of(cause));
        let mut found: Waves = waving.map(|cause| (*cause, Vec::new())).collect();
        for period in (LEAST..=most).map(|half_waves| 2.0 * last / half_waves as f64) {
            let courses = courses(period);
            found.iter_mut().for_each(|(cause, waves)| waves.push((period, rows.along(cause, &courses))));
        }
        found
    }

    /// What could stand in the place of each wave of a state's set: the likeliest waves of the other biases and channels, and of its own at another period; square
    /// waves of the others at its period.
    pub(super) fn alike(&self, state: &State) -> Vec<Cause> {
        let rows = self.weighed(&state.out);
        let (columns, observed) = self.linearised(state, &rows);
        let mut causes = Vec::new();
        for (place, member) in state.set.iter().enumerate() {
            let Some(change @ (Change::Wave { .. } | Change::Square { .. })) = member.change() else { continue };
            let others = columns.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, column)| column.clone());
            let given = rows.given(others, observed.clone());
            let last = self.last();
            for (cause, waves) in self.waves(&rows) {
                let is_own = member.with_change(Change::Ramp) == Some(*cause);
                // a half wave more in the run is another one
                let is_other = |other: f64| match change {
                    Change::Wave { period, .. } => !is_own || (2.0 * last / other - 2.0 * last / period).abs() > 1.0,
                    _ => !is_own,
                };
                let best = || largest(cause, waves.iter().filter(|(period, _)| is_other(*period)), &given);
                let finest = |(_, period)| Some(rows.finest_wave(cause, period, &given, last)?.cause);
                let is_apart =
                    |found: &Cause| matches!(found.change(), Some(Change::Wave { period, .. }) if is_other(period));
                causes.extend(match change {
                    Change::Wave { .. } => best().and_then(finest).filter(is_apart),
                    _ if is_own => None,
                    _ => cause.with_change(change),
                });
            }
        }
        causes
    }

    /// The steps and warm-ups that reduce the sum of squares most under each condition, as many as it asks for and of each bias and channel one, with their
    /// times refined: those of the grid are too far apart for what the data say of them.
    fn timed(&self, rows: &Weighed, conditions: &[(Given, usize)]) -> Vec<Cause> {
        let shortest = self.last() / rows.short.measured.longest_run().max(1) as f64;
        let mut found = Vec::new();
        for (given, count) in conditions {
            let mut best: Vec<(f64, Cause)> = Vec::new();
            for (cause, (column, norm)) in self.case.causes.iter().zip(&rows.unit) {
                if !matches!(cause.change(), Some(Change::Step(_) | Change::WarmUp(_))) || *norm == 0.0 {
                    continue;
                }
                let Some(gain) = gain(column, given) else { continue };
                match best.iter_mut().find(|(_, other)| other.family() == cause.family()) {
                    Some(other) if other.0 < gain => *other = (gain, *cause),
                    Some(_) => {}
                    None => best.push((gain, *cause)),
                }
            }
            best.sort_by(|a, b| b.0.total_cmp(&a.0));
            let finest = |(_, cause): &(f64, Cause)| self.finest(rows, cause, given, shortest);
            let fits = best.iter().take(*count).filter_map(finest);
            found.extend(fits.filter(|fit| !self.case.is_absurd(&fit.cause, fit.size)).map(|fit| fit.cause));
        }
        found
    }

    /// What the times, periods and phases of some causes can do: columns along the derivatives by them, of these columns' rows.
    pub(super) fn moves(&self, set: &[Cause], columns: &Columns) -> Vec<Vec<f64>> {
        let of = |cause: &Cause| {
            let beside = cause.change().map_or(Vec::new(), |change| change.beside(self.last()));
            let column = |change| cause.with_change(change).map(|cause| columns.of(&cause));
            let moved = beside.into_iter().filter_map(move |[a, b]| Some((column(a)?, column(b)?)));
            moved.map(|(a, b)| a.iter().zip(b).map(|(a, b)| b - a).collect::<Vec<f64>>()).collect::<Vec<_>>()
        };
        set.iter().flat_map(of).collect()
    }

    /// The best time near that of a step or a warm-up; `None` for what is neither.
    fn finest(&self, rows: &Weighed, cause: &Cause, given: &Given, shortest: f64) -> Option<CourseFit> {
        let at = |change: Change| {
            // a change that is over between two rows is not visible in them
            let is_seen = !matches!(change, Change::WarmUp(time) if time < shortest);
            let fit = rows.fit(cause.with_change(change).filter(|_| is_seen)?, given)?;
            Some((-fit.gain, fit))
        };
        let found = match cause.change()? {
            Change::Step(time) => By::Shift(self.spacing()).finest(time, |time| at(Change::Step(time))),
            Change::WarmUp(time) => By::Factor(3f64.ln()).finest(time.max(shortest), |time| at(Change::WarmUp(time))),
            _ => None,
        };
        found.map(|(_, fit)| fit)
    }

    /// Time between the steps of the grid, s.
    fn spacing(&self) -> f64 {
        let steps = self.case.causes.iter().filter_map(|cause| match cause {
            Cause::Changing(_, Change::Step(time)) => Some(*time),
            _ => None,
        });
        steps.fold(f64::INFINITY, f64::min)
    }

    /// The time of a step, a warm-up or a wave is one of a coarse grid: the best one near it, on the linear model, finer and finer. Was any moved?
    pub(super) fn sharpen(&self, state: &State, set: &mut [Cause], values: &mut [f64]) -> bool {
        let last = self.last();
        if !set.iter().any(Cause::is_course) {
            return false;
        }
        // in all rows: a time is known better than a row of fewer is long
        let mut rows = self.weighed(&state.out);
        if rows.short.is_short() {
            let whole = Shortened::whole(self.case.measured, &self.case.without(self.u, &state.out));
            rows = Rc::new(Weighed::of_rows(&self.case, whole, &state.out));
        }
        let shortest = last / rows.short.measured.longest_run().max(1) as f64;
        let (columns, observed) = self.linearised(state, &rows);
        let member = |cause: &Cause| state.set.iter().position(|other| other == cause);
        let column = |cause: &Cause| {
            let kept = member(cause).and_then(|k| columns.get(k));
            kept.cloned().unwrap_or_else(|| rows.of(&self.case, cause))
        };
        let mut moved = false;
        for k in 0..set.len() {
            let Some(&kind) = set.get(k) else { continue };
            // what the others leave
            let fixed = set.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, cause)| column(cause));
            let others = rows.given(fixed, observed.clone());
            let found = match kind.change() {
                Some(Change::Square { .. }) => rows.square(&kind, &others, last, ROUNDS),
                Some(Change::Wave { period, .. }) => rows.finest_wave(&kind, period, &others, last),
                Some(_) => self.finest(&rows, &kind, &others, shortest),
                None => continue,
            };
            let before = rows.fit(kind, &others).map(|fit| fit.gain);
            if let Some((fit, before)) = found.zip(before)
                && fit.gain - before > SHARPER
                && let (Some(cause), Some(size)) = (set.get_mut(k), values.get_mut(k))
            {
                (*cause, *size, moved) = (fit.cause, fit.size, true);
            }
        }
        moved
    }
}
