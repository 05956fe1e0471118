//! Score and exact fit in turn until the set stands still.
use crate::bank::bank;
use crate::score::{Posterior, Problem, Score, Settings};
use std::collections::HashMap;
use tumble::campaign::Campaign;
use tumble::diagnosis::lab::{self, At};
use tumble::diagnosis::{Candidate, Effect};
use tumble::fit::Fit;

pub struct Named { pub effect: Candidate, pub aliases: Vec<(Candidate, f64)>, pub probability: f64 }
pub struct Answer { pub named: Vec<Named>, pub nothing: f64, pub outside: f64, pub kernels: Vec<(String, f64)>, pub after: Option<Fit>, pub passes: usize, pub top: Vec<(f64, Vec<String>)> }

fn scanned(family: &str) -> bool { ["{reading}", "{position}", "{break}", "{tau}", "{other}"].iter().any(|p| family.contains(p)) }

pub fn priors(candidates: &[Candidate], settings: &Settings) -> Vec<f64> {
    let mut members: HashMap<(&str, Option<usize>), f64> = HashMap::new();
    for c in candidates { *members.entry((c.family.as_str(), c.sensor)).or_insert(0.0) += 1.0; }
    candidates.iter().map(|c| {
        let n: f64 = if scanned(&c.family) { members[&(c.family.as_str(), c.sensor)] } else { 1.0 };
        settings.odds.ln() - n.ln() + c.size.min(1.0).max(1e-12).ln()
    }).collect()
}

type Key = Vec<(String, Option<usize>)>;
fn key(at: &At, set: &[u16]) -> Key {
    let mut k: Key = set.iter().map(|j| { let c = &at.candidates[*j as usize]; (c.regressor.clone(), c.sensor) }).collect();
    k.sort();
    k
}

pub struct Seen { pub at: At, pub post: Posterior, pub scale: f64, pub kernels: Vec<String>, pub asked: Option<f64> }

pub fn see(campaign: &Campaign, asked: &[usize], catalogue: &[Effect], point: &[f64], start: &Key, settings: &Settings) -> Option<Seen> {
    let at = lab::at(campaign, asked, catalogue, point).ok()?;
    let prior = priors(&at.candidates, settings);
    let kernels = bank(campaign, &at);
    let problem = Problem { residual: &at.residual, basis: at.basis.as_ref(), columns: at.columns.as_ref(), prior: &prior, known: at.known, kernels: &kernels };
    let mut score = Score::new(&problem, *settings);
    let place = |(name, sensor): &(String, Option<usize>)| at.candidates.iter().position(|c| c.regressor == *name && c.sensor == *sensor).map(|j| j as u16);
    let set: Option<Vec<u16>> = start.iter().map(place).collect();
    score.search(&set.clone().into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>());
    let nu = (at.residual.len() - at.basis.ncols()) as f64;
    let scale = if at.known { 0.0 } else { nu * at.weight.iter().map(|w| w.ln()).sum::<f64>() / at.weight.len() as f64 };
    let asked = set.map(|s| score.of(&s) + scale);
    let post = score.posterior();
    let names = score.names.clone();
    drop(score);
    Some(Seen { post, scale, kernels: names, asked, at })
}

pub fn diagnose(campaign: &Campaign, catalogue: &[Effect], settings: &Settings) -> Option<Answer> {
    let (campaign, asked, point) = lab::start(campaign).ok()?;
    let first = see(&campaign, &asked, catalogue, &point, &vec![], settings)?;
    let mut passes = 1;
    let mut tried: HashMap<Key, (f64, Vec<f64>)> = HashMap::new();
    // other places to stand: tilts and known values that the best set does not have
    let moving = |at: &At, j: u16| matches!(at.candidates[j as usize].kind, tumble::simulate::Regressor::Tilt(_) | tumble::simulate::Regressor::Known(_));
    let mut wanted: Vec<Key> = first.post.sets.first().map(|(_, s)| key(&first.at, s)).into_iter().collect();
    let mut tilts: Vec<u16> = vec![];
    for (p, set) in &first.post.sets {
        if wanted.len() > 4 || *p < 1e-7 { break; }
        for j in set { if moving(&first.at, *j) && !tilts.contains(j) { tilts.push(*j); wanted.push(key(&first.at, set)); } }
    }
    // a tilt by itself
    for (p, set) in &first.post.sets { if let [j] = set[..] && moving(&first.at, j) && *p > 0.0 { wanted.push(key(&first.at, set)); } }
    wanted.dedup();
    let mut best: Option<(f64, Vec<f64>, Key)> = None;
    let mut best_seen: Option<Seen> = None;
    for start in wanted.into_iter().take(6) {
        let mut want = start;
        let mut seen: Option<Seen> = None;
        let mut here = point.clone();
        for _ in 0..5 {
            if tried.contains_key(&want) { break; }
            let from = seen.as_ref().unwrap_or(&first);
            let members: Option<Vec<&Candidate>> = want.iter().map(|(n, s)| from.at.candidates.iter().find(|c| c.regressor == *n && c.sensor == *s)).collect();
            let Some(effects) = members else { break };
            here = if effects.is_empty() { point.clone() } else { let Ok((_, p)) = lab::exact(&campaign, &effects, &here) else { break }; p };
            let Some(next) = see(&campaign, &asked, catalogue, &here, &want, settings) else { break };
            passes += 1;
            let value = next.asked.unwrap_or(f64::NEG_INFINITY);
            tried.insert(want.clone(), (value, here.clone()));
            let top = next.post.sets.first().map(|(p, s)| (*p, key(&next.at, s)));
            let own = next.post.sets.iter().find(|(_, s)| key(&next.at, s) == want).map_or(0.0, |(p, _)| *p);
            let stands = top.as_ref().is_some_and(|(p, k)| *k == want || own > 0.9 * p);
            if best.as_ref().is_none_or(|(v, _, _)| value > *v) {
                best = Some((value, here.clone(), want.clone()));
                best_seen = Some(see(&campaign, &asked, catalogue, &here, &want, settings)?);
            }
            if stands { break; }
            let Some((_, k)) = top else { break };
            want = k;
            seen = Some(next);
        }
    }
    let seen = best_seen.unwrap_or(first);
    let here = best.map_or(point.clone(), |b| b.1);
    let named: Vec<Named> = seen.post.classes.iter().filter(|c| c.probability >= settings.suspected).map(|c| Named {
        effect: seen.at.candidates[c.member].clone(),
        aliases: c.aliases.iter().map(|(j, p)| (seen.at.candidates[*j].clone(), *p)).collect(),
        probability: c.probability,
    }).collect();
    let effects: Vec<&Candidate> = named.iter().filter(|n| n.probability >= settings.named).map(|n| &n.effect).collect();
    let after = if effects.is_empty() { None } else { lab::exact(&campaign, &effects, &here).ok().map(|f| f.0) };
    let mut kernels: Vec<(String, f64)> = seen.kernels.iter().cloned().zip(seen.post.kernels.iter().copied()).collect();
    kernels.sort_by(|a, b| b.1.total_cmp(&a.1));
    kernels.truncate(3);
    let top = seen.post.sets.iter().take(5).map(|(p, s)| (*p, s.iter().map(|j| seen.at.candidates[*j as usize].regressor.clone()).collect())).collect();
    Some(Answer { named, nothing: seen.post.nothing, outside: seen.post.outside, kernels, after, passes, top })
}
