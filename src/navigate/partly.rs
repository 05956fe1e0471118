//! Causes that stand beside something which nothing explains.
//!
//! Where no set of causes leaves noise, the posterior of sets of causes beside what none explains ([`judged`](super::judged)) is asked on the linear
//! model. What is probable is refined on the full simulation and asked again from there, until the names settle. Causes that change in time can
//! build any course of time: beside an unexplained rest they are candidates that others must beat, but are not named.

use super::cause::Cause;
use super::judged::Among;
use super::refine::{State, Walk};
use crate::diagnosis::NoiseFrom;

/// Rounds of naming and refining, at most.
const ROUNDS: usize = 6;
/// Standard uncertainties from which a value is different from zero, at 95 %.
const DIFFERENT: f64 = 1.96;

/// A cause that stands beside others and what nothing explains.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stands {
    /// That the cause, or one that cannot be told from it, is there.
    pub probability: f64,
    /// Standard uncertainty, SI, with all that may deviate.
    pub u: f64,
}

/// What stands, and what comes nearest to the rest.
pub(super) struct Partly {
    pub state: State,
    /// For each cause of the state.
    pub stands: Vec<Stands>,
    /// What is suspected beside it.
    pub nearest: Vec<Cause>,
    /// The share of what is left that they would take off.
    pub nearest_share: f64,
}

impl Walk<'_> {
    /// The causes that stand where a walk has ended without explaining all; `None` where none does, or the noise is not stated.
    pub fn partly(&mut self, best: &State) -> Option<Partly> {
        if self.case.from != NoiseFrom::Stated {
            return None;
        }
        // from the constants among what came nearest, or from nothing
        let constant: Vec<(Cause, f64)> =
            best.set.iter().zip(&best.values).filter(|(cause, _)| cause.is_constant()).map(|(c, v)| (*c, *v)).collect();
        let starts = if constant.is_empty() { vec![constant] } else { vec![constant, Vec::new()] };
        starts.into_iter().find_map(|start| {
            let (set, values): (Vec<Cause>, Vec<f64>) = start.into_iter().unzip();
            let state = self.refine(&set, &values, &[])?;
            self.name(state)
        })
    }

    /// Naming and refining in turn, from a state.
    fn name(&mut self, mut state: State) -> Option<Partly> {
        let settings = self.case.settings.common;
        let out = self.standing_out(&state);
        if out != state.out {
            state = self.refine(&state.set.clone(), &state.values.clone(), &out)?;
        }
        self.relinearise(&state);
        let mut before: Vec<Vec<Cause>> = Vec::new();
        // what is no longer different from zero once its uncertainty has all that deviates
        let mut untold: Vec<Cause> = Vec::new();
        for _ in 0..ROUNDS {
            let linear = self.linear(&state, &self.likeliest_waves(&state));
            let mut judged = self.judge(&linear, &state, Among::Remainders);
            // causes that change in time build any course of time
            let is_course = |j: usize| linear.causes.get(j).is_none_or(Cause::is_course);
            let mut likely = judged.likely(settings.suspected);
            likely.sort_by_key(|(j, _)| *j);
            let is_untold = |j: usize| linear.causes.get(j).is_some_and(|cause| untold.contains(cause));
            let is_named = |(j, p): &(usize, f64)| *p >= settings.probability && !is_course(*j) && !is_untold(*j);
            let (named, nearest): (Vec<(usize, f64)>, Vec<(usize, f64)>) = likely.into_iter().partition(is_named);
            let set: Vec<usize> = named.iter().map(|(j, _)| *j).collect();
            let causes: Vec<Cause> = set.iter().filter_map(|j| linear.causes.get(*j).copied()).collect();
            if causes.is_empty() {
                return None;
            }
            let same = causes.len() == state.set.len() && causes.iter().all(|cause| state.set.contains(cause));
            if same {
                let beyond = judged.beyond_noise(&set);
                let stands = state.set.iter().zip(&state.u).filter_map(|(cause, u)| {
                    let place = causes.iter().position(|own| own == cause)?;
                    let (j, probability) = *named.get(place)?;
                    let beyond = beyond.get(place)?.sqrt() / linear.norms.get(j)?;
                    Some(Stands { probability, u: u.hypot(beyond) })
                });
                let stands: Vec<Stands> = stands.collect();
                let each = state.set.iter().zip(&state.values).zip(&stands);
                let lost: Vec<Cause> =
                    each.filter(|((_, x), own)| x.abs() < DIFFERENT * own.u).map(|((cause, _), _)| *cause).collect();
                if !lost.is_empty() {
                    untold.extend(lost);
                    continue;
                }
                let nearest: Vec<usize> = nearest.iter().map(|(j, _)| *j).collect();
                let with: Vec<usize> = set.iter().chain(&nearest).copied().collect();
                let rss = |set: &[usize]| linear.products.solve(set).map(|solved| solved.rss);
                let left = rss(&with).zip(rss(&set)).map(|(with, set)| with / set.max(f64::MIN_POSITIVE));
                // what depends on what is named takes off nothing
                let nearest_share = 1.0 - left.unwrap_or(1.0);
                let nearest = nearest.iter().filter_map(|j| linear.causes.get(*j).copied()).collect();
                let all = stands.len() == state.set.len();
                return all.then_some(Partly { state, stands, nearest, nearest_share });
            }
            // names that come round again do not settle
            if before.contains(&causes) {
                return None;
            }
            before.push(causes.clone());
            let solved = linear.products.solve(&set)?;
            let sized = |(j, x): (&usize, &f64)| linear.norms.get(*j).map_or(0.0, |norm| x / norm);
            let values: Vec<f64> = set.iter().zip(&solved.values).map(sized).collect();
            self.tell(before.len(), &causes);
            state = self.refine(&causes, &values, &state.out)?;
            self.relinearise(&state);
            let out = self.standing_out(&state);
            if out != state.out {
                state = self.refine(&state.set.clone(), &state.values.clone(), &out)?;
            }
        }
        None
    }
}
