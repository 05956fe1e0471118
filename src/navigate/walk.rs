//! Causes of a gap, walked to: a set refined on the full simulation, then improved on its linear model, in turn until both agree.

use super::case::Case;
use super::cause::{Cause, Change};
use super::errors::{Instrument, Kind};
use super::refine::{Seen, State, Walk};
use super::search::{self, Products};
use super::weighed::Weighed;
use crate::linear::{dot, normalise};
use std::rc::Rc;

/// Rounds of improving and refining, at most.
const ROUNDS: usize = 24;
/// A gap of so many standard uncertainties (root mean square) may be far from linear.
const FAR: f64 = 50.0;
/// Columns are made anew where they miss more standard deviations, and more of what the errors do, than this;
const BENT: (f64, f64) = (5.0, 0.02);
/// so often at most.
const MOST_MOVED: usize = 6;

/// The linear model of all causes at a state.
pub(super) struct Linear {
    pub causes: Vec<Cause>,
    pub products: Products,
    pub norms: Vec<f64>,
}

impl<'a> Walk<'a> {
    /// The best explanation: one cause; else all biases that a unit has, together, less those that nothing needs; else a walk from nothing; else
    /// with a bias that goes up and down.
    pub fn run(&mut self) -> Option<State> {
        let empty = self.refine(&[], &[], &[])?;
        let far = empty.rss > FAR * FAR * self.u.len() as f64;
        let original = self.case.clone();
        let (start, end) = self.part;
        let part = |from: f64, to: f64| (start + from * (end - start), start + to * (end - start));
        self.part = part(0.0, 0.1);
        let first = self.walk(empty, 1)?;
        if self.is_finished(&first) {
            return Some(first);
        }
        let mut best = (first.clone(), self.case.clone());
        let biases: Vec<Cause> = self.visible(|kind, instrument| kind == Kind::Bias && instrument != Instrument::Start);
        let starts: Vec<Cause> = self.visible(|kind, _| kind == Kind::Attitude);
        let both: Vec<Cause> = biases.iter().chain(&starts).copied().collect();
        for (start, share) in [(biases, 0.1), (both, 0.4)] {
            self.part = part(share, share + 0.3);
            self.case = original.clone();
            let state = self.begin(&start, &first.out, far);
            self.ordinary = state.clone().or(self.ordinary.take());
            let state = state.and_then(|state| self.walk(state, self.case.settings.causes));
            self.keep(&mut best, state);
            self.case = best.1.clone();
            if self.is_finished(&best.0) && best.0.set.iter().all(is_bias) {
                break;
            }
        }
        // fewer causes of another kind may do
        self.case = best.1.clone();
        let complete = self.is_finished(&best.0);
        if !(complete && far && best.0.set.iter().all(is_bias)) {
            self.case = original;
            self.part = part(0.7, 0.9);
            let most = if complete { best.0.set.len() } else { self.case.settings.causes };
            let state = self.walk(first.clone(), most);
            self.keep(&mut best, state);
        }
        // errors of the start, and some of them together, come near to a bias that goes up and down
        let ordinary = |state: &State| state.set.iter().all(is_bias);
        if !(self.is_finished(&best.0) && ordinary(&best.0)) {
            self.part = part(0.9, 1.0);
            for state in self.ordinary.clone().into_iter().chain([first]) {
                self.go_up_and_down(&mut best, &state);
            }
        }
        let (state, case) = best;
        self.case = case;
        Some(state)
    }

    /// Keep a state, with the columns around it, if it explains more.
    pub(super) fn keep(&self, best: &mut (State, Case<'a>), state: Option<State>) {
        let Some(state) = state else { return };
        let order = |state: &State| (!self.is_complete(state), self.score(state));
        if order(&state).partial_cmp(&order(&best.0)).is_some_and(std::cmp::Ordering::is_lt) {
            *best = (state, self.case.clone());
        }
    }

    /// A set refined from nothing; where the gap is far from linear, from what its first rows say too.
    fn begin(&mut self, set: &[Cause], out: &[usize], far: bool) -> Option<State> {
        self.tell(0, set);
        let straight = if far { None } else { self.refine(set, &vec![0.0; set.len()], out) };
        if straight.as_ref().is_some_and(|state| state.settled) {
            return straight;
        }
        let values = self.approach(set, out);
        let round = self.refine_or_damp(set, &values, out);
        let enough = |state: &State| state.settled && state.rss < 4.0 * self.u.len() as f64;
        if round.as_ref().is_some_and(enough) {
            return round;
        }
        let straight = straight.or_else(|| self.refine_or_damp(set, &vec![0.0; set.len()], out));
        [straight, round]
            .into_iter()
            .flatten()
            // a sum of squares that is not a number is no better
            .min_by(|a, b| (!a.settled, a.rss).partial_cmp(&(!b.settled, b.rss)).unwrap_or(std::cmp::Ordering::Equal))
    }

    /// Columns are the derivatives around the mission's errors; where a state is far from these, around the state.
    pub(super) fn relinearise(&mut self, state: &State) {
        if self.moved >= MOST_MOVED {
            return;
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
        }
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
        let settings = &self.case.settings;
        state.settled && changing <= settings.changing && gap.p.is_none_or(|p| p > settings.whole())
    }

    /// Is a state complete, and no further cause beyond chance?
    pub(super) fn is_finished(&self, state: &State) -> bool {
        let further = || {
            let linear = self.linear(state);
            let of = |cause: &Cause| linear.causes.iter().position(|own| own == cause);
            linear.products.best_addition(&state.set.iter().filter_map(of).collect::<Vec<usize>>())
        };
        self.is_complete(state) && further().is_none()
    }

    pub fn score(&self, state: &State) -> f64 {
        let settings = &self.case.settings;
        let cost = |cause: &Cause| self.penalty + settings.rank_penalty * cause.rank();
        state.rss
            + state.set.iter().map(cost).sum::<f64>()
            + (self.penalty + settings.single_penalty) * state.out.len() as f64
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

    /// The linear model at a state: all causes, those of the set by their own derivatives.
    pub fn linear(&self, state: &State) -> Linear {
        let mut causes = self.case.causes.clone();
        causes.extend(state.set.iter().filter(|own| !self.case.causes.contains(own)));
        let weighed = self.weighed(&state.out);
        let (mut own, residual) = self.laid(state, &weighed);
        let settings = &self.case.settings;
        let mut columns: Vec<Rc<Vec<f64>>> = Vec::with_capacity(causes.len());
        let mut plausibility_penalty = Vec::with_capacity(causes.len());
        let mut norms = Vec::with_capacity(causes.len());
        for (j, cause) in causes.iter().enumerate() {
            let member = state.set.iter().position(|own| own == cause).and_then(|k| own.get_mut(k));
            let (column, norm) = match (member, weighed.unit.get(j)) {
                (Some(own), _) => {
                    let norm = normalise(own);
                    (Rc::new(std::mem::take(own)), norm)
                }
                (None, Some(own)) => own.clone(),
                // each cause of the question has a column, each further one is a member
                (None, None) => (Rc::new(vec![0.0; residual.len()]), 0.0),
            };
            let seen = norm > 0.0 && !self.case.is_invisible(cause, norm);
            let column = if seen { column } else { Rc::new(vec![0.0; residual.len()]) };
            let alone = if seen { dot(&column, &residual) / norm } else { 0.0 };
            let absurd = if self.case.is_absurd(cause, alone) { settings.absurd_penalty } else { 0.0 };
            plausibility_penalty.push(if seen { settings.rank_penalty * cause.rank() + absurd } else { f64::INFINITY });
            columns.push(column);
            norms.push(norm);
        }
        let products = Products::new(columns, &residual, plausibility_penalty, self.penalty);
        Linear { causes, products, norms }
    }

    /// Columns of a state's set, and what they and the noise are to explain, weighed in fewer rows.
    pub(super) fn laid(&self, state: &State, rows: &Weighed) -> (Vec<Vec<f64>>, Vec<f64>) {
        let mut laid = self.case.left(&state.flown.predicted);
        for (column, value) in state.flown.jacobian.iter().zip(&state.values) {
            laid.iter_mut().zip(column).for_each(|(y, c)| *y += c * value);
        }
        let mut own = rows.rows(state.flown.jacobian.iter().chain([&laid]));
        // it is the last
        let residual = own.pop().unwrap_or_default();
        (own, residual)
    }

    /// Improve and refine in turn; a set grows to so many causes at most.
    pub(super) fn walk(&mut self, mut state: State, most: usize) -> Option<State> {
        for round in 0..ROUNDS {
            // such a set can build any pattern: it is none that will be accepted
            if state.set.iter().filter(|cause| !cause.is_constant()).count() > 2 * self.case.settings.changing {
                break;
            }
            self.relinearise(&state);
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
            let better = linear.products.improve(now.clone(), (now.len() + 1).min(most));
            self.record(&state, &linear, &now);
            let mut set: Vec<Cause> = better.iter().filter_map(|j| linear.causes.get(*j).copied()).collect();
            let Some(solved) = linear.products.solve(&better) else { break };
            let mut values: Vec<f64> = (better.iter().zip(&solved.values))
                .map(|(j, x)| linear.norms.get(*j).map_or(0.0, |norm| x / norm))
                .collect();
            if better.len() == now.len() && better.iter().all(|j| now.contains(j)) {
                break;
            }
            self.sharpen(&state, &mut set, &mut values);
            self.tell(round, &set);
            let refined = self.refine(&set, &values, &state.out).or_else(|| {
                // too far for the linear model: from where the walk stands
                let from = |cause: &Cause| {
                    state.set.iter().zip(&state.values).find(|(own, _)| *own == cause).map_or(0.0, |(_, x)| *x)
                };
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
}

fn is_bias(cause: &Cause) -> bool {
    cause.constant().is_some_and(|source| source.kind == Kind::Bias)
}

/// Penalty and number of distinct causes of a question. Steps count one by one: no two times are the same.
pub(super) fn penalty(case: &Case<'_>, u: &[f64]) -> (f64, usize) {
    let is_step = |cause: &Cause| {
        matches!(cause, Cause::Changing(_, Change::Step(_)) | Cause::Reference(_, Some(Change::Step(_))))
    };
    let steps = case.causes.iter().filter(|cause| is_step(cause)).count();
    let weighed = Weighed::new(case, u, &[]);
    let shown = case
        .causes
        .iter()
        .zip(&weighed.unit)
        .filter(|(cause, (_, norm))| !is_step(cause) && *norm > 0.0 && !case.is_invisible(cause, *norm));
    let seen: Vec<&Rc<Vec<f64>>> = shown.map(|(_, (column, _))| column).collect();
    let is_new =
        |(i, own): &(usize, &&Rc<Vec<f64>>)| seen.iter().take(*i).all(|other| dot(own, other).abs() < 1.0 - 1e-6);
    let distinct = steps + seen.iter().enumerate().filter(is_new).count();
    (search::penalty(case.settings.common.significance, distinct), distinct)
}
