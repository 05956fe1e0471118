//! A bias or a channel of the reference that oscillates, as under a temperature that is held between two limits.
//!
//! ```text
//! x sin(2 pi t / T + phase) = a cos(2 pi t / T) + b sin(2 pi t / T),      x^2 = a^2 + b^2,  tan(phase) = a / b
//! ```
//!
//! At a period `T` it is linear in `a` and `b`. Every bias and every channel is tried with every whole number of half waves in the run, given a set and
//! given nothing; the period is refined about the best (`sharpen.rs`). The waves that reduce the sum of squares most are candidates.
//!
//! What is switched between `x` and `-x` with a period is a square wave. Its first wave is the largest one wherever it is switched, and has its middle in a crest; so
//! each such wave is tried as one, and its two edges and its period are refined. Where that reduces the sum of squares more, it is a candidate, too.

use super::cause::{Cause, Change};
use super::products::INDEPENDENT;
use super::refine::{Search, State};
use super::sharpen::By;
use super::weighed::Weighed;
use crate::linear::{dot, orthonormal, project};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Half waves in a run that are tried: fewer are a ramp or a warm-up,
const LEAST: usize = 2;
/// more than one in so many rows is no wave that the rows show,
const SEEN: usize = 4;
/// and no more than this.
const MOST: usize = 80;
/// Waves that are candidates: those that reduce the sum of squares most, of each bias and channel one. They bound the work; a second wave of a set is a
/// candidate given the first.
const CANDIDATES: usize = 4;

/// Shares of a period that are tried at first: that many less one, equally apart.
const SHARES: i32 = 16;
/// A refinement that reduces the sum of squares by less, in variances of the noise, is none.
pub(super) const SHARPER: f64 = 0.5;

/// A wave given some causes: by how much it reduces the sum of squares, and its amplitude.
pub(super) struct WaveFit {
    pub cause: Cause,
    pub size: f64,
    pub gain: f64,
}

/// What is given when a wave is fitted: an orthonormal basis of the causes, and the residual orthogonal to it.
pub(super) type Given = (Vec<Vec<f64>>, Vec<f64>);

impl Weighed {
    /// Cosine and sine of a wave of this period of a bias or a channel, weighed; `None` for what does not wave.
    fn both(&self, of: &Cause, period: f64) -> Option<[Vec<f64>; 2]> {
        let column = |phase: f64| Some(self.made.of(&of.with_change(Change::Wave { period, phase })?));
        let mut columns = [column(FRAC_PI_2)?, column(0.0)?];
        self.weigh(&mut columns);
        Some(columns)
    }

    /// The best phase of a wave; `None` for what does not wave, or is not independent.
    pub(super) fn wave(&self, of: &Cause, period: f64, given: &Given) -> Option<WaveFit> {
        phased(of, period, self.both(of, period)?, given)
    }

    /// A cause given others.
    pub(super) fn fit(&self, cause: Cause, (basis, residual): &Given) -> Option<WaveFit> {
        let mut columns = [self.made.of(&cause)];
        self.weigh(&mut columns);
        let [mut column] = columns;
        let whole = dot(&column, &column);
        project(&mut column, basis);
        let (outside, along) = (dot(&column, &column), dot(&column, residual));
        (outside > INDEPENDENT * whole).then(|| WaveFit { cause, size: along / outside, gain: along * along / outside })
    }

    /// A square wave with the edges and the period that explain most, near some; in a run that is so long.
    pub(super) fn square(&self, of: &Cause, near: Change, given: &Given, last: f64) -> Option<WaveFit> {
        let Change::Square { period, middle, share } = near else { return None };
        // about the middle of the run its edges and its period are known by themselves
        let middle = middle + period * ((0.5 * last - middle) / period).round();
        let (mut period, mut edges) = (period, [middle - 0.5 * share * period, middle + 0.5 * share * period]);
        let at = |period: f64, [rise, fall]: [f64; 2]| {
            let (middle, share) = (0.5 * (rise + fall), (fall - rise) / period);
            let change = of.with_change(Change::Square { period, middle, share })?;
            let fit = self.fit(change, given).filter(|_| share > 0.0 && share < 1.0)?;
            Some((-fit.gain, fit))
        };
        let mut best = at(period, edges)?;
        loop {
            let before = best.0;
            for k in 0..3 {
                let found = match k {
                    2 => By::HalfWave(last).finest(period, |period| at(period, edges).map(|(v, f)| (v, (f, period)))),
                    _ => By::Shift(0.25 * period).finest(edges.get(k).copied()?, |edge| {
                        let mut moved = edges;
                        moved.iter_mut().skip(k).take(1).for_each(|slot| *slot = edge);
                        at(period, moved).map(|(v, f)| (v, (f, edge)))
                    }),
                };
                let Some((gain, (fit, place))) = found else { continue };
                best = (gain, fit);
                match k {
                    2 => period = place,
                    _ => edges.iter_mut().skip(k).take(1).for_each(|slot| *slot = place),
                }
            }
            if before - best.0 < SHARPER {
                return Some(best.1);
            }
        }
    }

    /// The square wave of which this is the first wave, if it explains more.
    fn switched(&self, wave: &WaveFit, given: &Given, last: f64) -> Option<Cause> {
        let Some(Change::Wave { period, phase }) = wave.cause.change() else { return None };
        let middle = period * (0.25 - phase / TAU);
        let shares = (1..SHARES).map(|k| f64::from(k) / f64::from(SHARES));
        let of = |share| {
            let change = Change::Square { period, middle, share };
            Some((self.fit(wave.cause.with_change(change)?, given)?.gain, change))
        };
        let (gain, near) = shares.filter_map(of).max_by(|a, b| a.0.total_cmp(&b.0))?;
        if gain <= wave.gain {
            return None;
        }
        let square = self.square(&wave.cause, near, given, last)?;
        (square.gain > wave.gain).then_some(square.cause)
    }

    pub(super) fn given(&self, fixed: impl IntoIterator<Item = Vec<f64>>, mut residual: Vec<f64>) -> Given {
        let basis = orthonormal(fixed, INDEPENDENT);
        project(&mut residual, &basis);
        (basis, residual)
    }
}

fn phased(of: &Cause, period: f64, mut columns: [Vec<f64>; 2], (basis, residual): &Given) -> Option<WaveFit> {
    let [c, s] = columns.each_ref().map(|column| dot(column, column));
    columns.iter_mut().for_each(|column| project(column, basis));
    let [cosine, sine] = &columns;
    let (cc, cs, ss) = (dot(cosine, cosine), dot(cosine, sine), dot(sine, sine));
    let determinant = cc * ss - cs * cs;
    if !(cc > INDEPENDENT * c && ss > INDEPENDENT * s && determinant > INDEPENDENT * cc * ss) {
        return None;
    }
    let (along_c, along_s) = (dot(cosine, residual), dot(sine, residual));
    let a = (ss * along_c - cs * along_s) / determinant;
    let b = (cc * along_s - cs * along_c) / determinant;
    let cause = of.with_change(Change::Wave { period, phase: a.atan2(b) })?;
    Some(WaveFit { cause, size: a.hypot(b), gain: a * along_c + b * along_s })
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

    /// The waves that reduce the sum of squares most: given a state's set, given nothing, given its constants, and given all of it but one cause, which a
    /// wave of another period may have brought in.
    pub(super) fn likeliest_waves(&self, state: &State) -> Vec<Cause> {
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
        if (0..columns.len()).any(|k| !is_constant(k)) {
            conditions.push((with(&is_constant), CANDIDATES));
        }
        if columns.len() > 1 {
            conditions.extend((0..columns.len()).map(|omitted| (with(&|k| k != omitted), 1)));
        }
        let last = self.last();
        let most = (rows.short.measured.longest_run() / SEEN).clamp(LEAST, MOST);
        let mut coarse: Vec<Vec<(f64, f64, Cause)>> = vec![Vec::new(); conditions.len()];
        for cause in self.case.causes.iter().filter(|cause| grows(cause)) {
            let mut best: Vec<Option<(f64, f64, Cause)>> = vec![None; conditions.len()];
            for half_waves in LEAST..=most {
                let period = 2.0 * last / half_waves as f64;
                let Some(columns) = rows.both(cause, period) else { continue };
                for ((given, _), best) in conditions.iter().zip(&mut best) {
                    let gain = phased(cause, period, columns.clone(), given).map_or(0.0, |fit| fit.gain);
                    if best.as_ref().is_none_or(|b| gain > b.0) {
                        *best = Some((gain, period, *cause));
                    }
                }
            }
            coarse.iter_mut().zip(best).for_each(|(all, best)| all.extend(best));
        }
        let mut waves = Vec::new();
        for ((given, count), mut all) in conditions.iter().zip(coarse) {
            all.sort_by(|a, b| b.0.total_cmp(&a.0));
            let finest = |(_, period, cause): &(f64, f64, Cause)| {
                let at = |period: f64| rows.wave(cause, period, given).map(|fit| (-fit.gain, fit));
                By::HalfWave(last).finest(*period, at).map(|(_, fit)| fit)
            };
            let fits: Vec<WaveFit> = all.iter().take(*count).filter_map(finest).collect();
            waves.extend(fits.first().and_then(|first| rows.switched(first, given, last)));
            let fits = fits.into_iter().filter(|fit| !self.case.is_absurd(&fit.cause, fit.size));
            waves.extend(fits.map(|fit| fit.cause));
        }
        waves
    }

    /// Waves of the other biases and channels at the period of each wave of a state's set.
    pub(super) fn alike(&self, state: &State) -> Vec<Cause> {
        let rows = self.weighed(&state.out);
        let (columns, observed) = self.linearised(state, &rows);
        let mut causes = Vec::new();
        for (place, member) in state.set.iter().enumerate() {
            let Some(change @ (Change::Wave { .. } | Change::Square { .. })) = member.change() else { continue };
            let others = columns.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, column)| column.clone());
            let given = rows.given(others, observed.clone());
            let is_other = |cause: &&Cause| grows(cause) && member.with_change(Change::Ramp) != Some(**cause);
            let waves = self.case.causes.iter().filter(is_other);
            let alike = |cause: &Cause| match change {
                Change::Wave { period, .. } => Some(rows.wave(cause, period, &given)?.cause),
                _ => cause.with_change(change),
            };
            causes.extend(waves.filter_map(alike));
        }
        causes
    }
}
