//! The search: the smallest set of effects after which nothing but noise is left.
//!
//! One effect that explains everything beats two, two beat three. Sets of one and two are tried exhaustively, larger ones by forward
//! selection, exchange and backward elimination. A set is accepted only if it is complete: each member significant given the others, no
//! candidate significant given the set, and the global test passed where the noise is known. Without a complete set nothing is named.

use super::arena::{Arena, DISTINCT};
use super::noise::NoiseFrom;
use super::support::Support;

/// How the significance level is spent: on the names, and on the global test.
#[derive(Debug, Clone, Copy)]
pub(super) struct Levels {
    pub names: f64,
    pub global: f64,
}

impl Levels {
    /// Most of the level goes to the names; the global test, which sees what no name explains, needs little.
    pub fn of(level: f64) -> Self {
        Levels { names: 0.7 * level, global: 0.2 * level }
    }
}

/// What the search found.
#[derive(Debug, Clone)]
pub(super) enum Found {
    /// Nothing is missing.
    Nothing,
    /// A complete set, and each set of the same size that fits not significantly worse.
    Set { set: Vec<usize>, rivals: Vec<Rival> },
    /// Something is missing and no set of candidates explains it; the best ones, which were not accepted.
    /// `approximate` are the best of one and of two.
    Unexplained { nearest: Vec<usize>, approximate: Vec<Vec<usize>> },
}

/// Another set that fits not significantly worse: `with` replaces `instead` of the found set.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rival {
    /// Member of the found set, by place.
    pub place: usize,
    /// The candidate that could stand there.
    pub candidate: usize,
    /// A second candidate that must replace the other member too.
    pub together: Option<usize>,
    /// How much larger the sum of squares is than the best, in units of the noise variance.
    pub excess: f64,
}

/// Sets whose sum of squares is this much larger (in noise variances) cannot honestly be told apart: three standard deviations.
pub(super) const INDISTINGUISHABLE: f64 = 9.0;
/// Most effects where the noise is known, and where only residuals tell it.
const MOST_KNOWN: usize = 3;
const MOST_RESIDUALS: usize = 6;
/// In a set of three or more every effect must be plain: three weak ones approximate almost any pattern.
const PLAIN: f64 = 8.0;
/// Share of the gap that one effect must take off where nothing can tell whether it is complete.
const MOST_OF_THE_GAP: f64 = 0.8;
/// A further effect must be so many times less likely by chance: the simpler explanation has the first claim.
const FURTHER: f64 = 0.1;
/// A handicap from here on says that only small tilts or rounding leave anything of the term.
pub(super) const IMPLAUSIBLE: f64 = 5.0;
/// Pairs that are extended to larger sets.
const SEEDS: usize = 12;

/// Search one arena. `handicap` of each candidate (in noise variances) decides among sets that fit alike.
pub(super) fn search(
    arena: &mut Arena,
    levels: Levels,
    handicap: &[f64],
    support: &Support<'_>,
    steps: &mut Vec<Step>,
) -> Found {
    let Some(nothing) = arena.given(&[]) else { return Found::Nothing };
    let strongest = arena.strongest(&nothing).map(|s| arena.most_plausible(&nothing, s, handicap));
    let global = arena.global(&nothing);
    let p = strongest.map_or(1.0, |s| s.p);
    steps.push(Step { set: Vec::new(), strongest: strongest.map(|s| (s.index, s.t, s.p)), global });
    let significant = p <= levels.names;
    if !significant && global.is_none_or(|p| p > levels.global) {
        return Found::Nothing;
    }
    arena.prepare();
    let most = if arena.from == NoiseFrom::Residuals { MOST_RESIDUALS } else { MOST_KNOWN };
    let mut sets: Vec<(f64, Vec<usize>)> = Vec::new();
    let mut approximate: Vec<Vec<usize>> = Vec::new();
    let mut last_resort: Option<Found> = None;
    for size in 1..=most.min(arena.dof.saturating_sub(1)) {
        sets = match size {
            1 => singles(arena),
            2 => pairs(arena),
            _ => larger(arena, &sets, size),
        };
        let Some(best) = sets.first().map(|(rss, _)| *rss) else { break };
        if size <= 2 {
            approximate.extend(sets.first().map(|(_, set)| set.clone()));
        }
        let Some(variance) = sets.first().and_then(|(_, set)| arena.given(set)).map(|g| arena.variance(&g)) else {
            break;
        };
        let burden = |set: &[usize]| set.iter().map(|j| handicap.get(*j).copied().unwrap_or_default()).sum::<f64>();
        let mut near: Vec<(f64, &Vec<usize>)> = sets
            .iter()
            .take_while(|(rss, _)| rss - best <= INDISTINGUISHABLE * variance)
            .map(|(rss, set)| ((rss - best) / variance + burden(set), set))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let implausible = |set: &[usize]| set.iter().any(|j| handicap.get(*j).is_some_and(|h| *h >= IMPLAUSIBLE));
        for (_, set) in near.iter().take(40) {
            if is_complete(arena, set, levels, handicap, steps) && (size == 1 || support.is_enough(arena, set)) {
                let set = (*set).clone();
                let doubtful = implausible(&set);
                let rivals = rivals(arena, &set, &sets, best, variance);
                let found = Found::Set { set, rivals };
                if !doubtful {
                    return found;
                }
                // two plausible effects stand before one that would need an absurd coefficient
                last_resort = last_resort.or(Some(found));
                break;
            }
        }
        if size == 2 && last_resort.is_some() {
            break;
        }
    }
    if let Some(found) = last_resort {
        return found;
    }
    if let Some(found) = main_effect(arena, levels, handicap) {
        return found;
    }
    let nearest = sets.first().map(|(_, set)| set.clone()).unwrap_or_default();
    Found::Unexplained { nearest, approximate }
}

/// One look at the evidence, for the record.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Step {
    pub set: Vec<usize>,
    /// Strongest further candidate: index, t, family-wise p.
    pub strongest: Option<(usize, f64, f64)>,
    pub global: Option<f64>,
}

fn is_complete(arena: &Arena, set: &[usize], levels: Levels, handicap: &[f64], steps: &mut Vec<Step>) -> bool {
    let Some(given) = arena.given(set) else { return false };
    for (place, member) in set.iter().enumerate() {
        let others: Vec<usize> = set.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, j)| *j).collect();
        let Some(without) = arena.given(&others) else { return false };
        let (t, dof) = arena.t(&without, *member);
        let needed = if set.len() > 1 { FURTHER * levels.names } else { levels.names };
        if arena.family_wise(t, dof) > needed || (set.len() > 2 && t.abs() < PLAIN) {
            return false;
        }
    }
    let strongest = arena.strongest(&given).map(|s| arena.most_plausible(&given, s, handicap));
    let global = arena.global(&given);
    let step = Step { set: set.to_vec(), strongest: strongest.map(|s| (s.index, s.t, s.p)), global };
    if !steps.contains(&step) && steps.len() < 64 {
        steps.push(step);
    }
    strongest.is_none_or(|s| s.p > FURTHER * levels.names) && global.is_none_or(|p| p > levels.global)
}

/// Where only the residuals tell the noise and no set is complete: the one effect that takes off most of the gap by itself, if one does.
fn main_effect(arena: &Arena, levels: Levels, handicap: &[f64]) -> Option<Found> {
    if arena.from != NoiseFrom::Residuals {
        return None;
    }
    let sets = singles(arena);
    let (best, leader) = sets.first().map(|(rss, set)| (*rss, set.clone()))?;
    let variance = arena.given(&leader).map(|given| arena.variance(&given))?;
    let burden = |set: &[usize]| set.first().and_then(|j| handicap.get(*j)).copied().unwrap_or_default();
    let near = sets.iter().take_while(|(rss, _)| rss - best <= INDISTINGUISHABLE * variance);
    let (_, set) = near
        .min_by(|a, b| ((a.0 - best) / variance + burden(&a.1)).total_cmp(&((b.0 - best) / variance + burden(&b.1))))?;
    let member = *set.first()?;
    let (t, dof) = arena.t(&arena.given(&[])?, member);
    if arena.family_wise(t, dof) > levels.names || arena.rss_of(set) > (1.0 - MOST_OF_THE_GAP) * arena.rss {
        return None;
    }
    Some(Found::Set { set: set.clone(), rivals: rivals(arena, set, &sets, best, variance) })
}

/// Every candidate by itself, best first.
fn singles(arena: &Arena) -> Vec<(f64, Vec<usize>)> {
    let visible = arena.pool.visible().iter().zip(arena.pool.scores()).enumerate().filter(|(_, (v, _))| **v > 0.0);
    let mut sets: Vec<(f64, Vec<usize>)> = visible.map(|(j, (_, s))| (arena.rss - s * s, vec![j])).collect();
    sets.sort_by(|a, b| a.0.total_cmp(&b.0));
    sets
}

/// The best pairs of all, best first: `drop = (s_a^2 + s_b^2 - 2 g s_a s_b) / (1 - g^2)`.
fn pairs(arena: &Arena) -> Vec<(f64, Vec<usize>)> {
    let score = arena.pool.scores();
    let visible: Vec<usize> =
        (0..arena.pool.len()).filter(|j| arena.pool.visible().get(*j).is_some_and(|v| *v > 0.0)).collect();
    let mut drops: Vec<(f64, usize, usize)> = Vec::new();
    let mut best = 0.0_f64;
    // far from the best no pair can be a rival; the margin holds for any variance up to that of the rest
    let margin =
        |best: f64| INDISTINGUISHABLE * (arena.rss - best).max(0.0) / arena.dof.saturating_sub(2).max(1) as f64;
    let slack = |best: f64| if arena.from == NoiseFrom::Stated { INDISTINGUISHABLE } else { margin(best).max(0.0) };
    for (n, &a) in visible.iter().enumerate() {
        let cosines = arena.cosines.col_as_slice(a);
        let own = score.get(a).copied().unwrap_or_default();
        for &b in visible.iter().skip(n + 1) {
            let (Some(g), Some(other)) = (cosines.get(b), score.get(b)) else { continue };
            let sine = 1.0 - g * g;
            if sine <= DISTINCT {
                continue;
            }
            let drop = (own * own + other * other - 2.0 * g * own * other) / sine;
            if drop >= best - slack(best) {
                best = best.max(drop);
                drops.push((drop, a, b));
            }
        }
        if drops.len() > 200_000 {
            drops.retain(|(drop, _, _)| *drop >= best - slack(best));
        }
    }
    drops.sort_by(|x, y| y.0.total_cmp(&x.0));
    drops.truncate(4000);
    drops.into_iter().map(|(drop, a, b)| (arena.rss - drop, vec![a, b])).collect()
}

/// Larger sets: the best smaller ones, each extended by what explains most of the rest, then improved by exchange.
fn larger(arena: &Arena, smaller: &[(f64, Vec<usize>)], size: usize) -> Vec<(f64, Vec<usize>)> {
    let mut sets: Vec<(f64, Vec<usize>)> = Vec::new();
    for (_, seed) in smaller.iter().take(SEEDS) {
        let Some(mut set) = extended(arena, seed) else { continue };
        for _ in 0..4 {
            let before = arena.rss_of(&set);
            for place in 0..size {
                let others: Vec<usize> = set.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, j)| *j).collect();
                if let Some(better) =
                    extended(arena, &others).filter(|better| arena.rss_of(better) < arena.rss_of(&set))
                {
                    set = better;
                }
            }
            if arena.rss_of(&set) >= before * (1.0 - 1e-12) {
                break;
            }
        }
        set.sort_unstable();
        if !sets.iter().any(|(_, own)| *own == set) {
            sets.push((arena.rss_of(&set), set));
        }
    }
    sets.sort_by(|a, b| a.0.total_cmp(&b.0));
    sets
}

fn extended(arena: &Arena, set: &[usize]) -> Option<Vec<usize>> {
    let given = arena.given(set)?;
    let size = |j: usize| given.score.get(j).map_or(0.0, |s| s.abs());
    let best = (0..arena.pool.len()).max_by(|a, b| size(*a).total_cmp(&size(*b)))?;
    (size(best) > 0.0).then(|| set.iter().copied().chain([best]).collect())
}

/// What could stand in the place of each member, and pairs that could stand in the place of both.
fn rivals(arena: &Arena, set: &[usize], sets: &[(f64, Vec<usize>)], best: f64, variance: f64) -> Vec<Rival> {
    let mut rivals = Vec::new();
    for (place, member) in set.iter().enumerate() {
        let others: Vec<usize> = set.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, j)| *j).collect();
        let Some(given) = arena.given(&others) else { continue };
        for (candidate, (score, left)) in given.score.iter().zip(&given.left).enumerate() {
            let excess = (given.rss - score * score - best) / variance;
            if candidate != *member && *left > DISTINCT && excess <= INDISTINGUISHABLE && !others.contains(&candidate) {
                rivals.push(Rival { place, candidate, together: None, excess });
            }
        }
    }
    if let [a, b] = *set {
        for (rss, pair) in sets.iter().take_while(|(rss, _)| rss - best <= INDISTINGUISHABLE * variance) {
            let [c, d] = *pair.as_slice() else { continue };
            if [c, d].iter().any(|j| *j == a || *j == b) {
                continue;
            }
            let cosine = |x: usize, y: usize| arena.cosines.col_as_slice(x).get(y).map_or(0.0, |g| g.abs());
            let crossed = cosine(a, c) + cosine(b, d) < cosine(a, d) + cosine(b, c);
            let (c, d) = if crossed { (d, c) } else { (c, d) };
            let excess = (rss - best) / variance;
            for (place, candidate, together) in [(0, c, d), (1, d, c)] {
                if !rivals.iter().any(|rival| rival.place == place && rival.candidate == candidate) {
                    rivals.push(Rival { place, candidate, together: Some(together), excess });
                }
            }
        }
    }
    rivals.sort_by(|a, b| a.place.cmp(&b.place).then(a.excess.total_cmp(&b.excess)));
    rivals
}
