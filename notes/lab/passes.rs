//! Score and exact fit in turn until the set stands still.
use crate::bank::bank;
use crate::score::{Posterior, Problem, Score, Settings};
use std::collections::HashMap;
use tumble::campaign::Campaign;
use tumble::diagnosis::lab::{self, At};
use tumble::diagnosis::{Candidate, Effect};
use tumble::fit::Fit;

pub struct Named { pub effect: Candidate, pub aliases: Vec<(Candidate, f64)>, pub probability: f64 }
pub struct Answer { pub named: Vec<Named>, pub nothing: f64, pub outside: f64, pub kernels: Vec<(String, f64)>, pub after: Option<Fit>, pub changes: Vec<(String, Option<f64>, Option<f64>)>, pub passes: usize, pub top: Vec<(f64, Vec<String>)> }

fn scanned(family: &str) -> bool { ["{reading}", "{position}", "{break}", "{tau}", "{other}"].iter().any(|p| family.contains(p)) }

pub fn priors(candidates: &[Candidate], settings: &Settings) -> Vec<f64> {
    let mut members: HashMap<(&str, Option<usize>), f64> = HashMap::new();
    for c in candidates { *members.entry((c.family.as_str(), c.sensor)).or_insert(0.0) += 1.0; }
    candidates.iter().map(|c| {
        let n: f64 = if scanned(&c.family) { members[&(c.family.as_str(), c.sensor)] } else { 1.0 };
        settings.odds.ln() - n.ln() + c.size.clamp(settings.vanishing, 1.0).ln()
    }).collect()
}

type Key = Vec<(String, Option<usize>)>;
fn key(at: &At, set: &[u16]) -> Key {
    let mut k: Key = set.iter().map(|j| { let c = &at.candidates[*j as usize]; (c.regressor.clone(), c.sensor) }).collect();
    k.sort();
    k
}

pub struct Seen { pub at: At, pub post: Posterior, pub scale: f64, pub kernels: Vec<String>, pub asked: Option<f64>, pub alike: Vec<Vec<u16>> }

pub fn see(campaign: &Campaign, asked: &[usize], catalogue: &[Effect], point: &[f64], start: &Key, settings: &Settings) -> Option<Seen> {
    let clock = std::time::Instant::now();
    let at = lab::at(campaign, asked, catalogue, point, None).ok()?;
    let t0 = clock.elapsed();
    let prior = priors(&at.candidates, settings);
    let kernels = bank(campaign, &at);
    let problem = Problem { residual: &at.residual, basis: at.basis.as_ref(), columns: at.columns.as_ref(), prior: &prior, known: at.known, kernels: &kernels };
    let t1 = clock.elapsed();
    let mut score = Score::new(&problem, *settings);
    let t2 = clock.elapsed();
    let place = |(name, sensor): &(String, Option<usize>)| at.candidates.iter().position(|c| c.regressor == *name && c.sensor == *sensor).map(|j| score.alike.iter().position(|a| a.contains(&(j as u16))).unwrap_or(j) as u16);
    let set: Option<Vec<u16>> = start.iter().map(place).collect();
    let set = set.map(|mut s| { s.sort_unstable(); s.dedup(); s });
    score.search(&set.clone().into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>());
    if std::env::var("LAB_TIME").is_ok() { eprintln!("at {:?} bank {:?} new {:?} search {:?} k {} kernels {}", t0, t1 - t0, t2 - t1, clock.elapsed() - t2, at.candidates.len(), score.names.len()); }
    let nu = (at.residual.len() - at.basis.ncols()) as f64;
    let scale = if at.known { 0.0 } else { nu * at.weight.iter().map(|w| w.ln()).sum::<f64>() / at.weight.len() as f64 };
    let asked = set.map(|s| score.of(&s) + scale);
    let post = score.posterior();
    let names = score.names.clone();
    let alike = std::mem::take(&mut score.alike);
    drop(score);
    Some(Seen { alike, post, scale, kernels: names, asked, at })
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
        for (place, j) in set.iter().enumerate() {
            for i in &first.alike[*j as usize] {
                if moving(&first.at, *i) && !tilts.contains(i) {
                    tilts.push(*i);
                    let mut with = set.clone();
                    with[place] = *i;
                    wanted.push(key(&first.at, &with));
                }
            }
        }
    }
    wanted.dedup();
    let mut best: Option<(f64, Vec<f64>, Key)> = None;
    let mut best_seen: Option<std::sync::Arc<Seen>> = None;
    for start in wanted.into_iter().take(6) {
        let mut want = start;
        let mut seen: Option<std::sync::Arc<Seen>> = None;
        let mut here = point.clone();
        for _ in 0..5 {
            if tried.contains_key(&want) { break; }
            let from: &Seen = seen.as_deref().unwrap_or(&first);
            let members: Option<Vec<&Candidate>> = want.iter().map(|(n, s)| from.at.candidates.iter().find(|c| c.regressor == *n && c.sensor == *s)).collect();
            let Some(effects) = members else { break };
            here = if effects.is_empty() { point.clone() } else { let Ok((_, p)) = lab::exact(&campaign, &effects, &here) else { break }; p };
            let Some(next) = see(&campaign, &asked, catalogue, &here, &want, settings).map(std::sync::Arc::new) else { break };
            passes += 1;
            let value = next.asked.unwrap_or(f64::NEG_INFINITY);
            tried.insert(want.clone(), (value, here.clone()));
            let top = next.post.sets.first().map(|(p, s)| (*p, key(&next.at, s)));
            let index = |(n, s): &(String, Option<usize>)| next.at.candidates.iter().position(|c| c.regressor == *n && c.sensor == *s).map_or(u16::MAX, |j| next.alike.iter().position(|a| a.contains(&(j as u16))).unwrap_or(j) as u16);
            let mut here_set: Vec<u16> = want.iter().map(index).collect();
            here_set.sort_unstable();
            let own = next.post.sets.iter().find(|(_, s)| *s == here_set).map_or(0.0, |(p, _)| *p);
            let stands = top.as_ref().is_some_and(|(p, _)| own > 0.9 * p);
            if best.as_ref().is_none_or(|(v, _, _)| value > *v) {
                best = Some((value, here.clone(), want.clone()));
                best_seen = Some(next.clone());
            }
            if stands { break; }
            let Some((_, k)) = top else { break };
            want = k;
            seen = Some(next);
        }
    }
    let seen = best_seen.unwrap_or_else(|| std::sync::Arc::new(first));
    let here = best.as_ref().map_or(point.clone(), |b| b.1.clone());
    let stood: Key = best.as_ref().map_or(vec![], |b| b.2.clone());
    let front = |c: &crate::score::Class| {
        let own = |j: &usize| stood.contains(&(seen.at.candidates[*j].regressor.clone(), seen.at.candidates[*j].sensor));
        seen.alike[c.member].iter().map(|j| *j as usize).find(own).unwrap_or(c.member)
    };
    let named: Vec<Named> = seen.post.classes.iter().filter(|c| c.probability >= settings.suspected).map(|c| Named {
        effect: seen.at.candidates[front(c)].clone(),
        aliases: c.aliases.iter().map(|(j, p)| (*j, *p)).chain([(c.member, 0.0)]).filter(|(j, _)| *j != front(c)).map(|(j, p)| (seen.at.candidates[j].clone(), p)).collect(),
        probability: c.probability,
    }).collect();
    let effects: Vec<&Candidate> = named.iter().filter(|n| n.probability >= settings.named).map(|n| &n.effect).collect();
    let after = if effects.is_empty() { None } else { lab::exact(&campaign, &effects, &here).ok().map(|f| f.0) };
    let mut kernels: Vec<(String, f64)> = seen.kernels.iter().cloned().zip(seen.post.kernels.iter().copied()).collect();
    kernels.sort_by(|a, b| b.1.total_cmp(&a.1));
    kernels.truncate(3);
    let top = seen.post.sets.iter().take(5).map(|(p, s)| (*p, s.iter().map(|j| seen.at.candidates[*j as usize].regressor.clone()).collect())).collect();
    Some(Answer { named, nothing: seen.post.nothing, outside: seen.post.outside, kernels, after, changes: vec![], passes, top })
}
