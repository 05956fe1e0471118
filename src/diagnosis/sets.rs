//! Sets of candidates by what they leave of the sum of squares: alone, in pairs, in larger sets; and what could stand in the place of a member.

use super::evidence::{DISTINCT, Evidence};
use super::noise::NoiseFrom;
use crate::elements::Elements;

/// Pairs that are extended to larger sets.
const SEEDS: usize = 12;
/// Candidates that are paired with one another: the strongest by themselves.
const PAIRED: usize = 900;
/// Distinct candidates of which all triples are tried: the strongest by themselves.
const IN_TRIPLES: usize = 300;
/// With more degrees of freedom than this only a third of them.
const SHORT: usize = 600;

/// Another set that fits not significantly worse: `with` replaces `instead` of the found set.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rival {
    /// Member of the found set, by place.
    pub place: usize,
    /// The candidate that could stand there.
    pub candidate: usize,
    /// Places of further members that it replaces.
    pub instead: Vec<usize>,
    /// Candidates that must then stand too, in their places or beside it.
    pub with: Vec<usize>,
    /// How much larger the sum of squares is than the best, in units of the noise variance; with the price of every effect more.
    pub excess: f64,
}

impl Rival {
    /// The set with the rival in it.
    pub fn replaced(&self, set: &[usize]) -> Vec<usize> {
        let kept = set.iter().enumerate().filter(|(k, _)| *k != self.place && !self.instead.contains(k));
        kept.map(|(_, j)| *j).chain([self.candidate]).chain(self.with.iter().copied()).collect()
    }

    /// Is this the place at which a rival of several members counts?
    pub fn is_first(&self) -> bool {
        self.instead.iter().all(|other| self.place < *other)
    }
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
        let own = score.at(a);
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

/// The best triples of all, best first, one candidate for each direction: that with the least plausibility penalty.
///
/// `drop = s_a^2 + (u_j^2 + u_k^2 - 2 g u_j u_k) / (1 - g^2)` with scores and cosines outside `a`.
pub(super) fn triples(
    evidence: &Evidence,
    indistinguishable: f64,
    plausibility_penalty: &[f64],
) -> Vec<(f64, Vec<usize>)> {
    let score = |j: usize| evidence.pool.scores().at(j);
    let mut order: Vec<usize> =
        (0..evidence.pool.len()).filter(|j| evidence.pool.visible().get(*j).is_some_and(|v| *v > 0.0)).collect();
    order.sort_by(|a, b| score(*b).abs().total_cmp(&score(*a).abs()));
    let cost = |j: usize| plausibility_penalty.at(j);
    let mut own: Vec<usize> = Vec::new();
    for j in order {
        // columns of one direction have scores of one size, and stand next to each other
        let near = |a: &&mut usize| (score(**a).abs() - score(j).abs()).abs() <= 1e-9 * score(j).abs();
        let same = |a: &&mut usize| evidence.cosines(**a).get(j).is_some_and(|g| 1.0 - g.abs() < 1e-9);
        match own.iter_mut().rev().take_while(near).find(same) {
            Some(known) if cost(j) < cost(*known) => *known = j,
            Some(_) => {}
            None => own.push(j),
        }
    }
    own.truncate(IN_TRIPLES);
    let n = own.len();
    let cosine: Vec<Vec<f64>> = own.iter().map(|a| own.iter().map(|b| evidence.cosines(*a).at(*b)).collect()).collect();
    let mut best = 0.0_f64;
    let mut drops: Vec<(f64, [usize; 3])> = Vec::new();
    let free = evidence.dof.saturating_sub(3).max(1) as f64;
    let slack = |best: f64| match evidence.from {
        NoiseFrom::Stated => indistinguishable,
        _ => indistinguishable * (evidence.rss - best).max(0.0) / free,
    };
    let (mut unit, mut left) = (vec![0.0; n], vec![0.0; n]);
    for (a, with_a) in cosine.iter().enumerate() {
        let first = own.get(a).map_or(0.0, |j| score(*j));
        for (((u, l), g), j) in unit.iter_mut().zip(&mut left).zip(with_a).zip(&own) {
            let sine = 1.0 - g * g;
            *l = if sine > DISTINCT { 1.0 / sine.sqrt() } else { 0.0 };
            *u = (score(*j) - g * first) * *l;
        }
        for (b, with_b) in cosine.iter().enumerate().skip(a + 1) {
            let (Some(&u), Some(&l), Some(&g)) = (unit.get(b), left.get(b), with_a.get(b)) else { continue };
            if l == 0.0 {
                continue;
            }
            let rest = unit.iter().zip(&left).zip(with_a).zip(with_b).enumerate().skip(b + 1);
            for (c, (((v, k), h), f)) in rest {
                let own = (f - g * h) * l * k;
                let sine = 1.0 - own * own;
                if *k == 0.0 || sine <= DISTINCT {
                    continue;
                }
                let drop = first * first + (u * u + v * v - 2.0 * own * u * v) / sine;
                if drop >= best - slack(best) {
                    best = best.max(drop);
                    drops.push((drop, [a, b, c]));
                }
            }
            if drops.len() > 200_000 {
                drops.retain(|(drop, _)| *drop >= best - slack(best));
            }
        }
    }
    drops.sort_by(|x, y| y.0.total_cmp(&x.0));
    drops.truncate(4000);
    let named = |set: [usize; 3]| set.iter().filter_map(|k| own.get(*k)).copied().collect();
    drops.into_iter().map(|(drop, set)| (evidence.rss - drop, named(set))).collect()
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
                rivals.push(Rival { place, candidate, instead: Vec::new(), with: Vec::new(), excess });
            }
        }
    }
    for (rss, near) in sets.iter().take_while(|(rss, _)| rss - best <= indistinguishable * variance) {
        add(evidence, set, near, (rss - best) / variance, &mut rivals);
    }
    rivals.sort_by(|a, b| a.place.cmp(&b.place).then(a.excess.total_cmp(&b.excess)));
    rivals
}

/// Another set as a rival of those members that it does not have, each against the candidate that resembles it most.
pub(super) fn add(evidence: &Evidence, set: &[usize], other: &[usize], excess: f64, rivals: &mut Vec<Rival>) {
    let out: Vec<usize> = (0..set.len()).filter(|k| set.get(*k).is_some_and(|j| !other.contains(j))).collect();
    let new: Vec<usize> = other.iter().copied().filter(|j| !set.contains(j)).collect();
    // one against one is found member by member; three against three share too little
    if out.is_empty() || out.len() > 2 || new.len() < 2 || new.len() > 3 {
        return;
    }
    let cosine =
        |place: usize, j: usize| set.get(place).and_then(|own| evidence.cosines(*own).get(j)).map_or(0.0, |g| g.abs());
    for candidate in &new {
        let nearest = out.iter().copied().max_by(|a, b| cosine(*a, *candidate).total_cmp(&cosine(*b, *candidate)));
        let mut places: Vec<usize> = nearest.into_iter().collect();
        // no member is left without: the two of a pair are told apart by what they resemble more together
        if let (&[p, q], &[c, d]) = (out.as_slice(), new.as_slice()) {
            let crossed = cosine(p, c) + cosine(q, d) < cosine(p, d) + cosine(q, c);
            places = vec![if (*candidate == c) != crossed { p } else { q }];
        }
        for place in places {
            if rivals.iter().any(|own| own.place == place && own.candidate == *candidate) {
                continue;
            }
            rivals.push(Rival {
                place,
                candidate: *candidate,
                instead: out.iter().copied().filter(|other| *other != place).collect(),
                with: new.iter().copied().filter(|other| other != candidate).collect(),
                excess,
            });
        }
    }
}
