//! Sets of candidates by what they leave of the sum of squares: alone, in pairs, in larger sets; and what could stand in the place of a member.

use super::evidence::{DISTINCT, Evidence};
use super::noise::NoiseFrom;

/// Pairs that are extended to larger sets.
const SEEDS: usize = 12;
/// Candidates that are paired with one another: the strongest by themselves.
const PAIRED: usize = 900;
/// With more degrees of freedom than this only a third of them.
const SHORT: usize = 600;

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

/// Every candidate by itself, best first.
pub(super) fn singles(evidence: &Evidence) -> Vec<(f64, Vec<usize>)> {
    let visible =
        evidence.pool.visible().iter().zip(evidence.pool.scores()).enumerate().filter(|(_, (v, _))| **v > 0.0);
    let mut sets: Vec<(f64, Vec<usize>)> = visible.map(|(j, (_, s))| (evidence.rss - s * s, vec![j])).collect();
    sets.sort_by(|a, b| a.0.total_cmp(&b.0));
    sets
}

/// The best pairs of all, best first: `drop = (s_a^2 + s_b^2 - 2 g s_a s_b) / (1 - g^2)`.
pub(super) fn pairs(evidence: &Evidence, indistinguishable: f64) -> Vec<(f64, Vec<usize>)> {
    let score = evidence.pool.scores();
    let mut visible: Vec<usize> =
        (0..evidence.pool.len()).filter(|j| evidence.pool.visible().get(*j).is_some_and(|v| *v > 0.0)).collect();
    let most = if evidence.dof > SHORT { PAIRED / 3 } else { PAIRED };
    if visible.len() > most {
        let size = |j: &usize| score.get(*j).map_or(0.0, |s| s.abs());
        visible.sort_by(|a, b| size(b).total_cmp(&size(a)));
        visible.truncate(most);
    }
    let mut drops: Vec<(f64, usize, usize)> = Vec::new();
    let mut best = 0.0_f64;
    // far from the best no pair can be a rival; the margin holds for any variance up to that of the rest
    let margin =
        |best: f64| indistinguishable * (evidence.rss - best).max(0.0) / evidence.dof.saturating_sub(2).max(1) as f64;
    let slack = |best: f64| if evidence.from == NoiseFrom::Stated { indistinguishable } else { margin(best).max(0.0) };
    for (n, &a) in visible.iter().enumerate() {
        let cosines = evidence.cosines(a);
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
    drops.into_iter().map(|(drop, a, b)| (evidence.rss - drop, vec![a, b])).collect()
}

/// Larger sets: the best smaller ones, each extended by what explains most of the rest, then improved by exchange.
pub(super) fn larger(evidence: &Evidence, smaller: &[(f64, Vec<usize>)], size: usize) -> Vec<(f64, Vec<usize>)> {
    let mut sets: Vec<(f64, Vec<usize>)> = Vec::new();
    for (_, seed) in smaller.iter().take(SEEDS) {
        let Some(mut set) = extended(evidence, seed) else { continue };
        for _ in 0..4 {
            let before = evidence.rss_of(&set);
            for place in 0..size {
                let others: Vec<usize> = set.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, j)| *j).collect();
                if let Some(better) =
                    extended(evidence, &others).filter(|better| evidence.rss_of(better) < evidence.rss_of(&set))
                {
                    set = better;
                }
            }
            if evidence.rss_of(&set) >= before * (1.0 - 1e-12) {
                break;
            }
        }
        set.sort_unstable();
        if !sets.iter().any(|(_, own)| *own == set) {
            sets.push((evidence.rss_of(&set), set));
        }
    }
    sets.sort_by(|a, b| a.0.total_cmp(&b.0));
    sets
}

pub(super) fn extended(evidence: &Evidence, set: &[usize]) -> Option<Vec<usize>> {
    let given = evidence.given(set)?;
    let size = |j: usize| given.score.get(j).map_or(0.0, |s| s.abs());
    let best = (0..evidence.pool.len()).max_by(|a, b| size(*a).total_cmp(&size(*b)))?;
    (size(best) > 0.0).then(|| set.iter().copied().chain([best]).collect())
}

/// What could stand in the place of each member, and pairs that could stand in the place of both.
///
/// `best` is the sum of squares that counts as the best, `variance` the unit of `excess`.
pub(super) fn rivals(
    evidence: &Evidence,
    set: &[usize],
    sets: &[(f64, Vec<usize>)],
    best: f64,
    variance: f64,
    indistinguishable: f64,
) -> Vec<Rival> {
    let mut rivals = Vec::new();
    for (place, member) in set.iter().enumerate() {
        let others: Vec<usize> = set.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, j)| *j).collect();
        let Some(given) = evidence.given(&others) else { continue };
        for (candidate, (score, left)) in given.score.iter().zip(&given.left).enumerate() {
            let excess = (given.rss - score * score - best) / variance;
            if candidate != *member && *left > DISTINCT && excess <= indistinguishable && !others.contains(&candidate) {
                rivals.push(Rival { place, candidate, together: None, excess });
            }
        }
    }
    if let [a, b] = *set {
        for (rss, pair) in sets.iter().take_while(|(rss, _)| rss - best <= indistinguishable * variance) {
            let [c, d] = *pair.as_slice() else { continue };
            if [c, d].iter().any(|j| *j == a || *j == b) {
                continue;
            }
            let cosine = |x: usize, y: usize| evidence.cosines(x).get(y).map_or(0.0, |g| g.abs());
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
