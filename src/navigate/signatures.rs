//! The design matrix of measured navigation errors: one row for each value, one column for each error source; and the full
//! simulation at the same instants.
//!
//! Columns come from [`linear`], which integrates all 46 signatures in one pass. One simulation for each source would differ by
//! terms of second order in the errors, and costs six times as much; predictions, which must be right to second order, are simulated
//! in full ([`run`]). Values between two pairs of steps are interpolated (the pairs are a fiftieth of a second apart at 100 Hz).

use super::errors::{ErrorSource, ImuErrors};
use super::linear::{self, Square, State};
use super::measured::{CHANNELS, Channels, Measured, channels};
use super::mission::Mission;
use super::motion::Motion;
use super::run::{self, Continue, Scenario};
use super::study;
pub(crate) use super::whiten::Instant;
use super::whiten::Walks;
use crate::elements::Elements;
use crate::number;

/// Two steps and how far a time is between them.
#[derive(Debug, Clone, Copy)]
struct Between {
    before: u64,
    after: u64,
    share: f64,
}

impl Between {
    fn new(mission: &Mission, time: f64) -> Between {
        let pairs = (0.5 * time / mission.step_s).clamp(0.0, 0.5 * mission.steps as f64);
        // a time that is a pair's but for rounding needs no other
        let near = pairs.round();
        let exact = (pairs - near).abs() < 1e-6;
        let before = if exact { near } else { pairs.floor() };
        let after = if exact { before } else { before + 1.0 };
        let step = |pair: f64| (2 * number::count_u64(pair)).min(mission.steps);
        Between { before: step(before), after: step(after), share: if exact { 0.0 } else { pairs - before } }
    }
}

/// Values at the steps around some times, in the order of the steps.
struct Stops {
    between: Vec<Between>,
    steps: Vec<u64>,
}

impl Stops {
    fn new(mission: &Mission, times: impl Iterator<Item = f64>) -> Stops {
        let between: Vec<Between> = times.map(|time| Between::new(mission, time)).collect();
        let mut steps: Vec<u64> = between.iter().flat_map(|b| [b.before, b.after]).collect();
        steps.sort_unstable();
        steps.dedup();
        Stops { between, steps }
    }

    /// The first step after one.
    fn next(&self, done: u64) -> u64 {
        // no further row
        self.steps.get(self.steps.partition_point(|step| *step <= done)).copied().unwrap_or(u64::MAX)
    }

    /// Is there a stop at this time, and is it the last?
    fn at(&self, mission: &Mission, time: f64) -> (bool, Continue) {
        let step = number::count_u64((time / mission.step_s).round());
        let last = self.steps.last().is_none_or(|last| step >= *last);
        (self.steps.binary_search(&step).is_ok(), if last { Continue::Stop } else { Continue::Yes })
    }

    /// From values at the stops to values at the times.
    fn interpolate<T: Clone>(&self, at_stops: &[T], mix: impl Fn(&T, &T, f64) -> T) -> Vec<T> {
        let of = |step: u64| self.steps.binary_search(&step).ok().and_then(|k| at_stops.get(k));
        let one = |b: &Between| match (of(b.before), of(b.after)) {
            (Some(before), Some(after)) if b.share > 0.0 => Some(mix(before, after, b.share)),
            (before, _) => before.cloned(),
        };
        self.between.iter().filter_map(one).collect()
    }
}

/// All signatures of one motion at some times, in rising order, s.
pub fn instants(mission: &Mission, motion: &Motion, times: &[f64]) -> Vec<Instant> {
    let stops = Stops::new(mission, times.iter().copied());
    let mut at_stops = Vec::with_capacity(stops.steps.len());
    linear::propagate_to(mission, motion, &mut |done| stops.next(done), &mut |row| {
        let (wanted, next) = stops.at(mission, row.time);
        if wanted {
            let of = |state: &State| channels(&row.error(state));
            at_stops
                .push(Instant { signatures: row.states.iter().map(of).collect(), walk: walk(&row.noise, row.metres) });
        }
        next
    });
    stops.interpolate(&at_stops, |a, b, share| {
        let mut walk = a.walk;
        walk.iter_mut().zip(&b.walk).for_each(|(row, other)| *row = mix(row, other, share));
        Instant { signatures: a.signatures.iter().zip(&b.signatures).map(|(a, b)| mix(a, b, share)).collect(), walk }
    })
}

fn mix(a: &Channels, b: &Channels, share: f64) -> Channels {
    let mut mixed = *a;
    mixed.iter_mut().zip(b).for_each(|(a, b)| *a += share * (b - *a));
    mixed
}

/// A covariance of states as one of channels.
fn walk(noise: &Square, metres: [f64; 2]) -> [Channels; CHANNELS] {
    // states hold latitude before longitude, channels east before north
    const STATE_OF: [usize; CHANNELS] = [0, 1, 2, 3, 4, 6, 5];
    let scale = [1.0, 1.0, 1.0, 1.0, 1.0, metres[0], metres[1]];
    let mut walk = [[0.0; CHANNELS]; CHANNELS];
    for ((row, i), a) in walk.iter_mut().zip(STATE_OF).zip(scale) {
        for ((slot, j), b) in row.iter_mut().zip(STATE_OF).zip(scale) {
            *slot = noise.get(i).and_then(|row| row.get(j)).map_or(0.0, |noise| noise * a * b);
        }
    }
    walk
}

/// The full simulation of one motion without noise, at some times in rising order, s, of several sets of errors flown side by side.
pub(crate) fn predicted_together(
    mission: &Mission,
    motion: &Motion,
    errors: &[ImuErrors],
    times: &[f64],
) -> Vec<Vec<Channels>> {
    let stops = Stops::new(mission, times.iter().copied());
    let mut at_stops: Vec<Vec<Channels>> = vec![Vec::with_capacity(stops.steps.len()); errors.len()];
    let scenario = |errors: &ImuErrors| Scenario { id: String::new(), errors: errors.noiseless() };
    let scenarios: Vec<Scenario> = errors.iter().map(scenario).collect();
    run::fly_to(mission, motion, &scenarios, &mut |done| stops.next(done), &mut |row| {
        let (wanted, next) = stops.at(mission, row.truth.time);
        if wanted {
            at_stops.iter_mut().zip(row.errors).for_each(|(list, error)| list.push(channels(error)));
        }
        next
    });
    at_stops.iter().map(|series| stops.interpolate(series, mix)).collect()
}

/// Times of each run, s.
pub(super) fn times(measured: &Measured) -> Vec<Vec<f64>> {
    measured.runs.iter().map(|run| run.rows.iter().map(|row| row.time).collect()).collect()
}

/// The motion of a run; the first of the mission where there is none of this number.
pub(super) fn motion(mission: &Mission, index: usize) -> &Motion {
    study::motions(mission).get(index).map_or(&mission.motion, |(_, motion)| motion)
}

/// The measured values as one system, a row for each, by run, time and channel: for each of [`ErrorSource::catalogue`] its column, SI of the channel per SI
/// of the source, and what the whitening needs.
pub(super) fn system(mission: &Mission, measured: &Measured) -> (Vec<Vec<f64>>, Walks) {
    let mut columns = vec![Vec::with_capacity(measured.count()); ErrorSource::catalogue().len()];
    let mut walks = Walks::default();
    for (run, times) in measured.runs.iter().zip(times(measured)) {
        let instants = instants(mission, motion(mission, run.motion), &times);
        for (row, instant) in run.rows.iter().zip(&instants) {
            for (channel, _) in row.value.iter().enumerate().filter(|(_, value)| value.is_some()) {
                for (column, signature) in columns.iter_mut().zip(&instant.signatures) {
                    column.push(signature.at(channel));
                }
            }
        }
        if mission.errors.is_noisy() {
            walks.instants.push(instants);
        }
    }
    (columns, walks)
}

/// The full simulation of a set of errors at every measured value.
pub(super) fn prediction(mission: &Mission, measured: &Measured, errors: &ImuErrors) -> Vec<f64> {
    // one set of errors, one prediction
    predictions(mission, measured, std::slice::from_ref(errors)).pop().unwrap_or_default()
}

/// The same of several sets of errors.
pub(super) fn predictions(mission: &Mission, measured: &Measured, errors: &[ImuErrors]) -> Vec<Vec<f64>> {
    let mut values = vec![Vec::with_capacity(measured.count()); errors.len()];
    for (run, times) in measured.runs.iter().zip(times(measured)) {
        let flown = predicted_together(mission, motion(mission, run.motion), errors, &times);
        for (list, series) in values.iter_mut().zip(flown) {
            for (row, channels) in run.rows.iter().zip(&series) {
                list.extend(row.value.iter().zip(channels).filter(|(value, _)| value.is_some()).map(|(_, v)| *v));
            }
        }
    }
    values
}
