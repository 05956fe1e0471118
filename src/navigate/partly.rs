//! Causes that are significant although something is unexplained.
//!
//! Where no set of causes leaves noise alone, sets of causes are judged jointly with a remainder ([`judged`](super::judged)) on the linear model. What is
//! probable is refined on the full simulation and judged again from there, until the names settle. Causes that change in time can build any course of
//! time: next to a remainder they are candidates that others must exceed, but are not named.

use super::cause::Cause;
use super::judged::Among;
use super::refine::{Search, State};
use crate::diagnosis::{DIFFERENT, NoiseFrom};

/// Rounds of naming and refining, at most.
const ROUNDS: usize = 6;

/// A cause that is significant given the others and the remainder.
#[derive(Debug, Clone, Copy)]
pub(super) struct Member {
    /// Probability that the cause, or one that cannot be distinguished from it, is present.
    pub probability: f64,
    /// Standard uncertainty, SI, including the remainder.
    pub u: f64,
}

/// The significant causes, and those that come nearest to the remainder.
pub(super) struct Partly {
    pub state: State,
    /// For each cause of the state.
    pub members: Vec<Member>,
    /// Further causes that are suspected.
    pub nearest: Vec<Cause>,
    /// The share of the residual sum of squares that they would explain.
    pub nearest_share: f64,
}

impl Search<'_> {
    /// The significant causes where a search has ended without explaining everything; `None` where none is, or the noise is not stated. With causes that
    /// are suspected.
    pub fn partly(&mut self, best: &State) -> (Option<Partly>, Vec<(Cause, f64)>) {
        let mut suspected = best.suspected.clone();
        if self.case.from != NoiseFrom::Stated {
            return (None, suspected);
        }
        // from the constants among what came nearest, or from nothing
        let constant: Vec<(Cause, f64)> =
            best.set.iter().zip(&best.values).filter(|(cause, _)| cause.is_constant()).map(|(c, v)| (*c, *v)).collect();
        let starts = if constant.is_empty() { vec![constant] } else { vec![constant, Vec::new()] };
        let partly = starts.into_iter().find_map(|start| {
            let (set, values): (Vec<Cause>, Vec<f64>) = start.into_iter().unzip();
            let state = self.refine(&set, &values, &[])?;
            self.name(state, &mut suspected)
        });
        (partly, suspected)
    }

    /// Naming and refining in turn, from a state; with what is suspected in the last round.
    fn name(&mut self, mut state: State, suspected: &mut Vec<(Cause, f64)>) -> Option<Partly> {
        let settings = self.case.settings.common;
        let out = self.standing_out(&state);
        state = self.leaving_out(state, &out)?;
        self.relinearise(&state);
        let mut before: Vec<Vec<Cause>> = Vec::new();
        // not different from zero once the uncertainty includes the remainder
        let mut insignificant: Vec<Cause> = Vec::new();
        for _ in 0..ROUNDS {
            let linear = self.linear(&state, &self.likeliest(&state));
            let mut judged = self.judge(&linear, &state, Among::Remainders);
            // causes that change in time build any course of time
            let is_course = |j: usize| linear.causes.get(j).is_none_or(Cause::is_course);
            let mut likely = judged.likely(settings.suspected, &[]);
            likely.sort_by_key(|(j, _)| *j);
            let is_insignificant = |j: usize| linear.causes.get(j).is_some_and(|cause| insignificant.contains(cause));
            let is_named =
                |(j, p): &(usize, f64)| *p >= settings.probability && !is_course(*j) && !is_insignificant(*j);
            let (named, nearest): (Vec<(usize, f64)>, Vec<(usize, f64)>) = likely.into_iter().partition(is_named);
            let cause = |(j, p): &(usize, f64)| Some((*linear.causes.get(*j)?, *p));
            *suspected = nearest.iter().filter(|(j, _)| !is_course(*j)).filter_map(cause).collect();
            let set: Vec<usize> = named.iter().map(|(j, _)| *j).collect();
            let causes: Vec<Cause> = set.iter().filter_map(|j| linear.causes.get(*j).copied()).collect();
            if causes.is_empty() {
                return None;
            }
            let same = causes.len() == state.set.len() && causes.iter().all(|cause| state.set.contains(cause));
            if same {
                let beyond = judged.beyond_noise(&set);
                let members = state.set.iter().zip(&state.u).filter_map(|(cause, u)| {
                    let place = causes.iter().position(|other| other == cause)?;
                    let (j, probability) = *named.get(place)?;
                    let beyond = beyond.get(place)?.sqrt() / linear.norms.get(j)?;
                    Some(Member { probability, u: u.hypot(beyond) })
                });
                let members: Vec<Member> = members.collect();
                let each = state.set.iter().zip(&state.values).zip(&members);
                let lost: Vec<Cause> = each
                    .filter(|((_, x), member)| x.abs() < DIFFERENT * member.u)
                    .map(|((cause, _), _)| *cause)
                    .collect();
                if !lost.is_empty() {
                    insignificant.extend(lost);
                    continue;
                }
                let nearest: Vec<usize> = nearest.iter().map(|(j, _)| *j).collect();
                let nearest_share = linear.share_of(&set, &nearest);
                let nearest = nearest.iter().filter_map(|j| linear.causes.get(*j).copied()).collect();
                let all = members.len() == state.set.len();
                return all.then_some(Partly { state, members, nearest, nearest_share });
            }
            // the names cycle and do not settle
            if before.contains(&causes) {
                return None;
            }
            before.push(causes.clone());
            let values = linear.values(&set, &linear.products.solve(&set)?);
            self.report(before.len(), &causes);
            state = self.refine(&causes, &values, &state.out)?;
            self.relinearise(&state);
            let out = self.standing_out(&state);
            state = self.leaving_out(state, &out)?;
        }
        None
    }
}
