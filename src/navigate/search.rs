//! Causes of a gap: sets are judged on the linear model at a state (`judged.rs`), the most probable one is refined on the full simulation, and all are judged
//! again from there, until the present set is the most probable one.

use super::case::Case;
use super::cause::{Cause, Change};
use super::errors::{Instrument, Kind};
use super::judged::{Among, Judged, Linear};
use super::products::{self, Products};
use super::refine::{Search, State};
use super::weighed::{Weighed, unit};
use crate::diagnosis::{NoiseFrom, Step};
use crate::linear::dot;
use std::rc::Rc;

/// Rounds of judging and refining, at most.
const ROUNDS: usize = 24;
/// A gap of so many standard uncertainties (root mean square) may be far from linear.
const FAR: f64 = 50.0;
/// Columns are made anew where they miss more standard deviations, and more of what the errors do, than this;
const BENT: (f64, f64) = (5.0, 0.02);
/// so often at most.
const MOST_MOVED: usize = 6;
/// A gain (ln) of less than this on the full simulation is none: a tenth in the odds, as rounding and the ends of refinements make; the search would cycle.
const GAIN: f64 = 0.1;

impl<'a> Search<'a> {
    /// The best explanation, from the empty set; where that does not leave noise alone, from all biases of the unit, and from these and the attitude of the start.
    pub fn run(&mut self) -> Option<State> {
        let empty = self.refine(&[], &[], &[])?;
        let far = self.is_far(&empty);
        let original = self.case.clone();
        let (start, end) = self.part;
        let part = |from: f64, to: f64| (start + from * (end - start), start + to * (end - start));
        self.part = part(0.0, 0.3);
        let first = self.settle(empty, far)?;
        let (out, from) = (first.out.clone(), (!self.is_far(&first)).then(|| first.clone()));
        let mut best = (first, self.case.clone());
        for (which, share) in [(Ordinary::Biases, 0.3), (Ordinary::WithStart, 0.6)] {
            // of a gap that is far from linear several causes may look like others
            if self.is_finished(&best.0) && (!far || best.0.set.len() < 2 || share > 0.3) {
                break;
            }
            self.part = part(share, share + 0.3);
            self.case = original.clone();
            let state = self.begin(which, &out, from.as_ref());
            self.ordinary = state.clone().or(self.ordinary.take());
            let state = state.and_then(|state| self.settle(state, far));
            self.keep(&mut best, state);
        }
        let (state, case) = best;
        self.case = case;
        Some(state)
    }

    pub(super) fn is_far(&self, empty: &State) -> bool {
        empty.rss > FAR * FAR * self.u.len() as f64
    }

    /// Keep a state, with the columns around it, if it explains more.
    fn keep(&self, best: &mut (State, Case<'a>), state: Option<State>) {
        let Some(state) = state else { return };
        let order = |state: &State| (!self.is_complete(state), -state.value);
        if order(&state).partial_cmp(&order(&best.0)).is_some_and(std::cmp::Ordering::is_lt) {
            *best = (state, self.case.clone());
        }
    }

    /// A set refined from the values of a state that is not far from the data; without one, from nothing and from what the first rows say.
    pub(super) fn begin(&mut self, which: Ordinary, out: &[usize], from: Option<&State>) -> Option<State> {
        let set = &self.visible(|kind, instrument| match kind {
            Kind::Bias => instrument != Instrument::Start,
            Kind::Attitude => which == Ordinary::WithStart,
            _ => false,
        })[..];
        self.report(0, set);
        let near = from.and_then(|from| self.refine_or_damp(set, &from.values_of(set), out));
        if near.as_ref().is_some_and(|state| state.settled) {
            return near;
        }
        let values = self.approach(set, out);
        let round = self.refine_or_damp(set, &values, out);
        let enough = |state: &State| state.settled && state.rss < 4.0 * self.u.len() as f64;
        if round.as_ref().is_some_and(enough) {
            return round;
        }
        let straight = near.or_else(|| self.refine_or_damp(set, &vec![0.0; set.len()], out));
        [straight, round]
            .into_iter()
            .flatten()
            // a sum of squares that is not a number is no better
            .min_by(|a, b| (!a.settled, a.rss).partial_cmp(&(!b.settled, b.rss)).unwrap_or(std::cmp::Ordering::Equal))
    }

    /// Columns are the derivatives around the mission's errors; where a state is far from these, they are computed anew around the state. Were they?
    pub(super) fn relinearise(&mut self, state: &State) -> bool {
        if self.moved >= MOST_MOVED {
            return false;
        }
        let errors = self.case.with(&state.set, &state.values);
        let mut constant = state.flown.predicted.clone();
        for ((cause, value), column) in state.set.iter().zip(&state.values).zip(&state.flown.jacobian) {
            if !cause.is_constant() {
                constant.iter_mut().zip(column).for_each(|(slot, c)| *slot -= value * c);
            }
        }
        let (missed, share) = self.case.bent(&errors, &constant, self.u);
        if missed > BENT.0
            && share > BENT.1
            && let Some(case) = self.case.around(&errors, self.u)
        {
            self.case = case;
            self.moved += 1;
            return true;
        }
        false
    }

    /// Constants of some kinds that these data show.
    fn visible(&self, keep: impl Fn(Kind, Instrument) -> bool) -> Vec<Cause> {
        let of = |cause: &&Cause| cause.constant().is_some_and(|source| keep(source.kind, source.instrument));
        self.case.causes.iter().filter(of).filter(|cause| self.case.is_visible(cause, self.u)).copied().collect()
    }

    /// Does a state leave nothing but noise?
    pub fn is_complete(&self, state: &State) -> bool {
        let gap = self.gap_of(state);
        let changing = state.set.iter().filter(|cause| !cause.is_constant()).count();
        let settings = &self.case.settings;
        state.settled && !state.outside && changing <= settings.changing && gap.p.is_none_or(|p| p > settings.whole())
    }

    /// Is a state complete, and no set more probable?
    fn is_finished(&self, state: &State) -> bool {
        state.is_best && self.is_complete(state)
    }

    fn record(&mut self, state: &State, linear: &Linear, now: &[usize]) {
        let strongest = linear.products.solve(now).and_then(|solved| {
            let gains = linear.products.gains(now, &solved);
            let best = gains.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
            let t = best.1.sqrt();
            Some((linear.causes.get(best.0)?.id(), t, products::chance(t, self.distinct)))
        });
        self.steps.push(Step::new(state.set.iter().map(Cause::id).collect(), strongest, self.gap_of(state).p));
    }

    /// The linear model at a state: all causes, those of the set by their derivatives there, and some waves.
    pub fn linear(&self, state: &State, waves: &[Cause]) -> Linear {
        let mut causes = self.case.causes.clone();
        for extra in state.set.iter().chain(waves) {
            if !causes.contains(extra) {
                causes.push(*extra);
            }
        }
        let weighed = self.weighed(&state.out);
        let (mut derivatives, residual) = self.linearised(state, &weighed);
        let mut columns: Vec<Rc<Vec<f64>>> = Vec::with_capacity(causes.len());
        let mut norms = Vec::with_capacity(causes.len());
        for (j, cause) in causes.iter().enumerate() {
            let member = state.set.iter().position(|other| other == cause).and_then(|k| derivatives.get_mut(k));
            let (column, norm) = match (member, weighed.unit.get(j)) {
                (Some(column), _) => unit(std::mem::take(column)),
                (None, Some(kept)) => kept.clone(),
                // a wave
                (None, None) => unit(weighed.of(&self.case, cause)),
            };
            let seen = norm > 0.0 && !self.case.is_invisible(cause, norm);
            columns.push(if seen { column } else { Rc::new(vec![0.0; residual.len()]) });
            norms.push(norm);
        }
        Linear { causes, products: Products::new(columns, &residual), norms }
    }

    /// Columns of a state's set, and the observations that they and the noise explain, weighed in fewer rows.
    pub(super) fn linearised(&self, state: &State, rows: &Weighed) -> (Vec<Vec<f64>>, Vec<f64>) {
        let observed = self.case.observed(&state.flown, &state.values);
        let mut columns = rows.rows(state.flown.jacobian.iter().chain([&observed]));
        // it is the last
        let residual = columns.pop().unwrap_or_default();
        (columns, residual)
    }

    /// Judge and refine in turn, from a state. Where it is `careful`, sets grow by one cause at a time: what is far from linear may look like many.
    pub(super) fn settle(&mut self, mut state: State, mut careful: bool) -> Option<State> {
        let most = self.case.settings.causes;
        let mut rejected: Vec<Vec<Cause>> = Vec::new();
        state.value = f64::NEG_INFINITY;
        for round in 0..ROUNDS {
            careful |= self.relinearise(&state);
            let out = self.single(&state);
            state = self.leaving_out(state, &out)?;
            let waves = self.likeliest(&state);
            let linear = self.linear(&state, &waves);
            let now = linear.places(&state.set);
            let grown = if careful { (now.len() + 1).min(most) } else { most };
            let judged = self.judge(&linear, &state, Among::Sets(grown));
            state = self.valued(state);
            self.record(&state, &linear, &now);
            let better = judged.best(&now);
            let mut set: Vec<Cause> = better.iter().filter_map(|j| linear.causes.get(*j).copied()).collect();
            // such a set can build any pattern and will not be accepted
            if set.iter().filter(|cause| !cause.is_constant()).count() > 2 * self.case.settings.changing {
                if careful {
                    break;
                }
                careful = true;
                continue;
            }
            let Some(solved) = linear.products.solve(&better) else { break };
            let mut values = linear.values(&better, &solved);
            let same = better.len() == now.len() && better.iter().all(|j| now.contains(j));
            let sharper = self.sharpen(&state, &mut set, &mut values);
            if (same && !sharper) || rejected.contains(&set) {
                if careful && grown < most && rejected.is_empty() {
                    careful = false;
                    continue;
                }
                state.is_best = true;
                break;
            }
            self.report(round, &set);
            let refined = self.refine(&set, &values, &state.out).or_else(|| {
                // too far for the linear model: from the values of the present state
                self.refine(&set, &state.values_of(&set), &state.out)
            });
            let refined = refined.map(|next| self.valued(next));
            match refined.filter(|next| next.value > state.value + GAIN) {
                Some(next) => state = next,
                // no improvement on the full simulation
                None if careful || same => {
                    state.is_best = true;
                    break;
                }
                None => {
                    rejected.push(set);
                    careful = true;
                }
            }
        }
        Some(if self.is_complete(&state) { self.certain(state) } else { state })
    }

    /// A state with only the causes that are probable enough for a name when a remainder is possible: the least probable member goes first, and the others
    /// are judged again without it. Where it is more probable than not that more is missing than the others and what is suspected, the state leaves more than noise.
    fn certain(&mut self, mut state: State) -> State {
        let mut removed = false;
        loop {
            let linear = self.linear(&state, &self.likeliest(&state));
            let judged = self.judge(&linear, &state, Among::Remainders);
            let set = linear.places(&state.set);
            state.each = set.iter().map(|j| judged.probability(*j)).collect();
            let suspected = judged.likely(self.case.settings.common.suspected, &set).into_iter();
            let suspected = suspected.filter_map(|(j, p)| Some((*linear.causes.get(j)?, p)));
            // a few causes that change in time build any course of noise
            state.suspected = suspected.filter(|(cause, _)| !cause.is_course()).collect();
            // where a cause that the most probable set had is not certain, also another one or a remainder that is neither in the set nor suspected
            let accounted = set.len() + state.suspected.len();
            let further = 1.0 - judged.posterior.alone.iter().take(accounted + 1).sum::<f64>();
            let outside = if removed { further } else { judged.posterior.outside };
            state.outside = outside >= self.case.settings.common.suspected;
            let least = state.each.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
            let place = least.filter(|(_, p)| **p < self.case.settings.common.probability).map(|(place, _)| place);
            let Some(place) = place.filter(|_| !state.outside) else { return state };
            let (mut set, mut values, out) = (state.set.clone(), state.values.clone(), state.out.clone());
            removed |= !set.remove(place).is_course();
            values.remove(place);
            match self.refine(&set, &values, &out) {
                Some(less) => state = State { is_best: state.is_best, ..self.valued(less) },
                None => return state,
            }
        }
    }

    /// A state with its value.
    fn valued(&self, mut state: State) -> State {
        let linear = self.linear(&state, &[]);
        let mut judged = self.judge(&linear, &state, Among::None);
        state.value = self.value(&mut judged, &linear, &state, &linear.places(&state.set));
        state
    }

    /// ln p of a state with its set, in all rows.
    fn value(&self, judged: &mut Judged, linear: &Linear, state: &State, set: &[usize]) -> f64 {
        let value = judged.value(set);
        if self.case.from != NoiseFrom::Stated {
            return value;
        }
        // the residual sum of squares is less in fewer rows
        let rss = linear.products.solve(set).map_or(state.rss, |solved| solved.rss);
        let single = 0.5 * (self.penalty + self.case.settings.single_penalty);
        value + 0.5 * (rss - state.rss) - single * state.out.len() as f64
    }
}

/// Errors that every unit may have.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Ordinary {
    Biases,
    /// and errors of the attitude at the start.
    WithStart,
}

/// Penalty and number of distinct causes of a question. Steps count one by one: no two times are the same.
pub(super) fn penalty(case: &Case<'_>, u: &[f64]) -> (f64, usize) {
    let weighed = Weighed::new(case, u, &[]);
    let (steps, others): (Vec<_>, Vec<_>) =
        case.causes.iter().zip(&weighed.unit).partition(|(cause, _)| matches!(cause.change(), Some(Change::Step(_))));
    let shown = others.into_iter().filter(|(cause, (_, norm))| *norm > 0.0 && !case.is_invisible(cause, *norm));
    let seen: Vec<&Rc<Vec<f64>>> = shown.map(|(_, (column, _))| column).collect();
    let is_new =
        |(i, column): &(usize, &&Rc<Vec<f64>>)| seen.iter().take(*i).all(|other| dot(column, other).abs() < 1.0 - 1e-6);
    let distinct = steps.len() + seen.iter().enumerate().filter(is_new).count();
    (products::penalty(case.settings.common.significance, distinct), distinct)
}
