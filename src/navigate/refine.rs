//! Causes of a gap, walked to: a set refined on the full simulation, then improved on its linear model, in turn until both agree.

use super::case::{Case, Flown};
use super::cause::{Cause, Change};
use super::errors::{Instrument, Kind};
use super::measured::CHANNELS;
use super::search::{self, Products, dot};
use crate::diagnosis::NoiseFrom;
use crate::uncertainty::quantiles::normal_quantile;

/// Gauss-Newton steps of one refinement, at most.
const STEPS: usize = 25;
/// A refinement has settled when no cause moves by more than this share of its standard uncertainty.
const SETTLED: f64 = 0.02;
/// Rounds of improving and refining, at most.
const ROUNDS: usize = 24;
/// Causes at most: constants of the unit and the start, and what changes in time or is the reference's.
const MOST: usize = 16;
const MOST_CHANGING: usize = 3;
/// Share of the rows that single wrong values may make up.
const SINGLE: f64 = 0.05;
/// Cost of rank: what decides among causes that fit alike, in variances of the noise.
pub(super) const RANK: f64 = 2.0;

/// A set of causes, refined.
#[derive(Clone)]
pub(super) struct State {
    pub set: Vec<Cause>,
    pub values: Vec<f64>,
    pub u: Vec<f64>,
    pub flown: Flown,
    /// Single values that are left out.
    pub out: Vec<usize>,
    pub rss: f64,
    pub settled: bool,
}

/// One look of the walk, for the record.
pub(super) struct Seen {
    pub set: Vec<Cause>,
    pub strongest: Option<(Cause, f64)>,
    pub p: Option<f64>,
}

/// A walk through sets of causes.
pub(super) struct Walk<'a> {
    pub case: &'a Case<'a>,
    pub u: &'a [f64],
    /// Penalty of each cause, and how many are distinct.
    pub penalty: f64,
    pub distinct: usize,
    pub seen: Vec<Seen>,
    pub flights: usize,
    pub progress: &'a mut dyn FnMut(&str),
}

/// The linear model of all causes at a state.
pub(super) struct Linear {
    pub causes: Vec<Cause>,
    pub products: Products,
    pub norms: Vec<f64>,
}

impl Walk<'_> {
    /// The best explanation: from nothing, and, where that is not simple and complete, from the biases that every unit has.
    pub fn run(&mut self) -> Option<State> {
        let empty = self.refine(&[], &[], &[])?;
        let mut best = self.walk(empty)?;
        if self.is_complete(&best) && best.set.len() <= 1 {
            return Some(best);
        }
        let biases: Vec<Cause> = self.visible(|kind, instrument| kind == Kind::Bias && instrument != Instrument::Start);
        let starts: Vec<Cause> = self.visible(|kind, _| kind == Kind::Attitude);
        let both: Vec<Cause> = biases.iter().chain(&starts).copied().collect();
        for start in [biases, both] {
            let out = best.out.clone();
            let Some(state) = self.refine(&start, &vec![0.0; start.len()], &out) else { continue };
            let Some(state) = self.walk(state) else { continue };
            let order = |state: &State| (!self.is_complete(state), self.score(state));
            let ((a, x), (b, y)) = (order(&state), order(&best));
            if (a, x).partial_cmp(&(b, y)).is_some_and(std::cmp::Ordering::is_lt) {
                best = state;
            }
            if self.is_complete(&best) && best.set.iter().all(is_bias) {
                break;
            }
        }
        Some(best)
    }

    /// Constants of some kinds that these data show.
    fn visible(&self, keep: impl Fn(Kind, Instrument) -> bool) -> Vec<Cause> {
        let of = |cause: &&Cause| cause.constant().is_some_and(|source| keep(source.kind, source.instrument));
        let shown = |cause: &&Cause| {
            let mut column = [self.case.raw_of(cause)];
            self.case.weigh(self.u, &[], &mut column);
            !self.case.is_invisible(cause, dot(&column[0], &column[0]).sqrt())
        };
        self.case.causes.iter().filter(of).filter(shown).copied().collect()
    }

    /// Is nothing left but noise?
    pub fn is_complete(&self, state: &State) -> bool {
        let left = self.case.left(&state.flown.predicted);
        let gap = self.case.gap(&left, self.u, &state.out, state.set.len());
        let changing = state.set.iter().filter(|cause| !cause.is_constant()).count();
        state.settled && changing <= MOST_CHANGING && gap.p.is_none_or(|p| p > 0.2 * self.case.settings.significance)
    }

    fn score(&self, state: &State) -> f64 {
        let cost = |cause: &Cause| self.penalty + RANK * cause.rank();
        state.rss + state.set.iter().map(cost).sum::<f64>() + (self.penalty + 4.0) * state.out.len() as f64
    }

    /// Gauss-Newton on the full simulation, with step halving; `None` where the set is not independent or cannot be flown.
    pub fn refine(&mut self, set: &[Cause], start: &[f64], out: &[usize]) -> Option<State> {
        let mut values = start.to_vec();
        let mut flown = self.case.fly(set, &values, self.u)?;
        self.flights += 1;
        let mut settled = false;
        let mut u = vec![f64::INFINITY; set.len()];
        let mut rss = self.rss(&flown, out);
        for _ in 0..STEPS {
            let mut columns = flown.jacobian.clone();
            columns.push(self.case.left(&flown.predicted));
            self.case.weigh(self.u, out, &mut columns);
            let residual = columns.pop()?;
            let norms: Vec<f64> = columns.iter_mut().map(|column| normalise(column)).collect();
            let products = Products::new(columns, &residual, vec![0.0; set.len()], 0.0);
            let all: Vec<usize> = (0..set.len()).collect();
            let solved = products.solve(&all)?;
            let step: Vec<f64> = solved.values.iter().zip(&norms).map(|(x, norm)| x / norm).collect();
            u = solved.inverse.iter().enumerate().map(|(k, row)| row[k].max(0.0).sqrt() / norms[k]).collect();
            // where the noise is what is left, its size counts, not one
            let size = if self.case.from == NoiseFrom::Residuals {
                (rss / residual.len().max(1) as f64).sqrt().max(1e-3)
            } else {
                1.0
            };
            settled = step.iter().zip(&u).all(|(dx, u)| dx.abs() <= SETTLED * u * size);
            if settled {
                break;
            }
            let mut share = 1.0;
            let next = loop {
                let trial: Vec<f64> = values.iter().zip(&step).map(|(x, dx)| x + share * dx).collect();
                self.flights += 1;
                let better = self.case.fly(set, &trial, self.u).map(|flown| (self.rss(&flown, out), flown));
                match better {
                    Some((after, flown)) if after <= rss * (1.0 + 1e-9) => break Some((trial, after, flown)),
                    _ if share < 1e-2 => break None,
                    _ => share *= 0.5,
                }
            };
            let Some((trial, after, next)) = next else { break };
            (values, rss, flown) = (trial, after, next);
        }
        Some(State { set: set.to_vec(), values, u, flown, out: out.to_vec(), rss, settled })
    }

    fn rss(&self, flown: &Flown, out: &[usize]) -> f64 {
        let mut left = [self.case.left(&flown.predicted)];
        self.case.weigh(self.u, out, &mut left);
        dot(&left[0], &left[0])
    }

    /// The linear model at a state: all causes, those of the set by their own derivatives.
    pub fn linear(&self, state: &State) -> Linear {
        let mut causes = self.case.causes.clone();
        causes.extend(state.set.iter().filter(|own| !self.case.causes.contains(own)));
        let mut laid = self.case.left(&state.flown.predicted);
        let mut columns: Vec<Vec<f64>> = Vec::with_capacity(causes.len() + 1);
        for (j, cause) in causes.iter().enumerate() {
            let member = state.set.iter().position(|own| own == cause);
            columns.push(match member.and_then(|k| state.flown.jacobian.get(k)) {
                Some(own) => own.clone(),
                None => self.case.raw.get(j).cloned().unwrap_or_default(),
            });
        }
        for (column, value) in state.flown.jacobian.iter().zip(&state.values) {
            laid.iter_mut().zip(column).for_each(|(y, c)| *y += c * value);
        }
        columns.push(laid);
        self.case.weigh(self.u, &state.out, &mut columns);
        let residual = columns.pop().unwrap_or_default();
        let mut handicap = Vec::with_capacity(causes.len());
        let mut norms = Vec::with_capacity(causes.len());
        for (cause, column) in causes.iter().zip(&mut columns) {
            let norm = normalise(column);
            let seen = norm > 0.0 && !self.case.is_invisible(cause, norm);
            if !seen {
                column.fill(0.0);
            }
            let alone = if seen { dot(column, &residual) / norm } else { 0.0 };
            let absurd = if self.case.is_absurd(cause, alone) { 5.0 } else { 0.0 };
            handicap.push(if seen { RANK * cause.rank() + absurd } else { f64::INFINITY });
            norms.push(norm);
        }
        let products = Products::new(columns, &residual, handicap, self.penalty);
        Linear { causes, products, norms }
    }

    /// Improve and refine in turn.
    fn walk(&mut self, mut state: State) -> Option<State> {
        for _ in 0..ROUNDS {
            let out = self.single(&state);
            if out != state.out {
                state = self.refine(&state.set.clone(), &state.values.clone(), &out)?;
            }
            let (mut set, mut values) = (state.set.clone(), state.values.clone());
            if self.sharpen(&state, &mut set, &mut values)
                && let Some(sharper) = self.refine(&set, &values, &[])
            {
                state = sharper;
                let out = self.single(&state);
                if out != state.out {
                    state = self.refine(&state.set.clone(), &state.values.clone(), &out)?;
                }
            }
            let linear = self.linear(&state);
            let now: Vec<usize> =
                state.set.iter().filter_map(|cause| linear.causes.iter().position(|own| own == cause)).collect();
            // one more at a time: what is far off may look like many
            let better = linear.products.improve(now.clone(), (now.len() + 1).min(MOST));
            self.record(&state, &linear, &now);
            let mut set: Vec<Cause> = better.iter().filter_map(|j| linear.causes.get(*j).copied()).collect();
            let Some(solved) = linear.products.solve(&better) else { break };
            let mut values: Vec<f64> = better.iter().zip(&solved.values).map(|(j, x)| x / linear.norms[*j]).collect();
            if better.len() == now.len() && better.iter().all(|j| now.contains(j)) {
                break;
            }
            self.sharpen(&state, &mut set, &mut values);
            let names: Vec<String> = set.iter().map(Cause::id).collect();
            (self.progress)(&names.join(" + "));
            let refined = self.refine(&set, &values, &state.out).or_else(|| {
                // too far for the linear model: from where the walk stands
                let from =
                    |cause: &Cause| state.set.iter().position(|own| own == cause).map_or(0.0, |k| state.values[k]);
                let values: Vec<f64> = set.iter().map(from).collect();
                self.refine(&set, &values, &state.out)
            });
            let Some(refined) = refined else { break };
            // a change that is none on the full simulation ends the walk
            if self.score(&refined) >= self.score(&state) && refined.set.len() >= state.set.len() {
                break;
            }
            state = refined;
        }
        Some(state)
    }

    /// The time of a step or a warm-up is one of a coarse grid: the best one near it, on the linear model, finer and finer. Was any moved?
    fn sharpen(&self, state: &State, set: &mut [Cause], values: &mut [f64]) -> bool {
        const PARTS: i32 = 8;
        const LEVELS: i32 = 5;
        let steps = self.case.causes.iter().filter_map(|own| match own {
            Cause::Changing(_, Change::Step(time)) => Some(*time),
            _ => None,
        });
        let spacing = steps.fold(f64::INFINITY, f64::min);
        let member = |cause: &Cause| state.set.iter().position(|own| own == cause);
        let column = |cause: &Cause| {
            let own = member(cause).and_then(|k| state.flown.jacobian.get(k));
            own.cloned().unwrap_or_else(|| self.case.raw_of(cause))
        };
        let mut laid = self.case.left(&state.flown.predicted);
        for (column, value) in state.flown.jacobian.iter().zip(&state.values) {
            laid.iter_mut().zip(column).for_each(|(y, c)| *y += c * value);
        }
        let mut moved = false;
        for k in 0..set.len() {
            let Some(&own) = set.get(k) else { continue };
            let (start, warm) = match own {
                Cause::Changing(_, Change::Step(time)) | Cause::Reference(_, Some(Change::Step(time))) => (time, false),
                Cause::Changing(_, Change::WarmUp(time)) => (time, true),
                _ => continue,
            };
            let make = |time: f64| match own {
                Cause::Changing(source, Change::WarmUp(_)) => Cause::Changing(source, Change::WarmUp(time)),
                Cause::Changing(source, _) => Cause::Changing(source, Change::Step(time)),
                Cause::Reference(channel, _) => Cause::Reference(channel, Some(Change::Step(time))),
                other => other,
            };
            // with the others weighed once
            let mut fixed: Vec<Vec<f64>> =
                set.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, cause)| column(cause)).collect();
            fixed.push(laid.clone());
            self.case.weigh(self.u, &[], &mut fixed);
            let Some(residual) = fixed.pop() else { continue };
            let try_at = |time: f64| -> Option<(f64, f64)> {
                let mut candidate = [self.case.columns.of(&make(time))];
                self.case.weigh(self.u, &[], &mut candidate);
                let mut columns = fixed.clone();
                columns.extend(candidate);
                let norms: Vec<f64> = columns.iter_mut().map(|column| normalise(column)).collect();
                let count = columns.len();
                let products = Products::new(columns, &residual, vec![0.0; count], 0.0);
                let solved = products.solve(&(0..count).collect::<Vec<usize>>())?;
                Some((solved.rss, solved.values.last()? / norms.last()?))
            };
            let Some((mut rss, mut value)) = try_at(start) else { continue };
            let (before, mut time) = (rss, start);
            let mut width = if warm { 3f64.ln() } else { spacing };
            for _ in 0..LEVELS {
                let middle = time;
                for part in -PARTS..=PARTS {
                    let shift = width * f64::from(part) / f64::from(PARTS);
                    let trial = if warm { middle * shift.exp() } else { middle + shift };
                    if !(trial > 0.0 && shift.is_finite()) || part == 0 {
                        continue;
                    }
                    if let Some((own, at)) = try_at(trial).filter(|(own, _)| *own < rss) {
                        (rss, value, time) = (own, at, trial);
                    }
                }
                width *= 1.5 / f64::from(PARTS);
            }
            if before - rss > 0.5 {
                (set[k], values[k], moved) = (make(time), value, true);
            }
        }
        moved
    }

    fn record(&mut self, state: &State, linear: &Linear, now: &[usize]) {
        let strongest = linear.products.solve(now).and_then(|solved| {
            let gains = linear.products.gains(now, &solved);
            let best = gains.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
            Some((*linear.causes.get(best.0)?, best.1.sqrt()))
        });
        let left = self.case.left(&state.flown.predicted);
        let p = self.case.gap(&left, self.u, &state.out, state.set.len()).p;
        self.seen.push(Seen { set: state.set.clone(), strongest, p });
    }

    /// Single values far from what the state predicts and from their neighbours in time; none where they are more than a few.
    ///
    /// While something is still missing a value is compared with the values of its channel before and after it, in units of how they usually
    /// differ; where noise alone is left, with its own standard uncertainty.
    fn single(&self, state: &State) -> Vec<usize> {
        if self.case.from != NoiseFrom::Stated {
            return Vec::new();
        }
        let mut white = [self.case.left(&state.flown.predicted)];
        self.case.weigh(self.u, &[], &mut white);
        let [white] = white;
        let rows: usize = self.case.measured.runs.iter().map(|run| run.rows.len()).sum();
        let most = ((SINGLE * rows as f64).floor() as usize).max(1);
        let level = 0.1 * self.case.settings.significance / white.len().max(1) as f64;
        let far = normal_quantile(1.0 - 0.5 * level).unwrap_or(6.0);
        let beyond: Vec<usize> = (0..white.len()).filter(|i| white[*i].abs() > far).collect();
        if beyond.len() <= most {
            return beyond;
        }
        let mut found: Vec<(usize, f64)> = Vec::new();
        for (run, _) in self.case.measured.runs.iter().enumerate() {
            for channel in 0..CHANNELS {
                let cells = self.case.measured.cells().enumerate();
                let own: Vec<usize> =
                    cells.filter(|(_, c)| c.run == run && c.channel == channel).map(|(i, _)| i).collect();
                if own.len() < 8 {
                    continue;
                }
                let at = |k: usize| own.get(k).map_or(0.0, |i| white[*i]);
                let bend = |k: usize| match k {
                    0 => at(0) - 2.0 * at(1) + at(2),
                    k if k + 1 == own.len() => at(k) - 2.0 * at(k - 1) + at(k - 2),
                    k => at(k) - 0.5 * (at(k - 1) + at(k + 1)),
                };
                let bends: Vec<f64> = (0..own.len()).map(bend).collect();
                let mut sizes: Vec<f64> = bends.iter().map(|b| b.abs()).collect();
                sizes.sort_by(f64::total_cmp);
                // 1.4826 median is the standard deviation of normal values; that of a bend of noise alone is 1.22
                let scale = (1.4826 * sizes[sizes.len() / 2]).max(1.5_f64.sqrt());
                for (k, bend) in bends.iter().enumerate() {
                    let around = bends[k.saturating_sub(1)..(k + 2).min(bends.len())].iter();
                    let largest = around.fold(0.0_f64, |most, b| most.max(b.abs()));
                    let edge = if k == 0 || k + 1 == own.len() { 2.0 } else { 1.0 };
                    if bend.abs() > 8.0 * scale * edge && bend.abs() >= largest {
                        found.push((own[k], bend.abs()));
                    }
                }
            }
        }
        if found.len() > most {
            return Vec::new();
        }
        let mut out: Vec<usize> = found.into_iter().map(|(i, _)| i).collect();
        out.sort_unstable();
        out
    }
}

fn is_bias(cause: &Cause) -> bool {
    cause.constant().is_some_and(|source| source.kind == Kind::Bias)
}

/// Divide a column by its norm, which comes back; a column of nothing stays.
fn normalise(column: &mut [f64]) -> f64 {
    let norm = dot(column, column).sqrt();
    if norm > 0.0 {
        column.iter_mut().for_each(|v| *v /= norm);
    }
    norm
}

/// Penalty and number of distinct causes of a question. Steps count one by one: no two times are the same.
pub(super) fn penalty(case: &Case<'_>, u: &[f64]) -> (f64, usize) {
    let is_step = |cause: &Cause| {
        matches!(cause, Cause::Changing(_, Change::Step(_)) | Cause::Reference(_, Some(Change::Step(_))))
    };
    let steps = case.causes.iter().filter(|cause| is_step(cause)).count();
    let (causes, mut columns): (Vec<&Cause>, Vec<Vec<f64>>) =
        case.causes.iter().zip(case.raw.iter().cloned()).filter(|(cause, _)| !is_step(cause)).unzip();
    case.weigh(u, &[], &mut columns);
    let norms: Vec<f64> = columns.iter_mut().map(|column| normalise(column)).collect();
    let seen = |j: usize| norms[j] > 0.0 && !case.is_invisible(causes[j], norms[j]);
    let is_new = |i: usize| seen(i) && (0..i).all(|j| !seen(j) || dot(&columns[i], &columns[j]).abs() < 1.0 - 1e-6);
    let distinct = steps + (0..causes.len()).filter(|i| is_new(*i)).count();
    (search::penalty(case.settings.significance, distinct), distinct)
}
