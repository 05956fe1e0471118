//! Families of candidates: what their members share of the tests, and which of them can build any pattern.

use super::candidate::Candidate;
use super::catalogue::breaks;
use super::evidence::Evidence;
use super::settings::Settings;
use crate::campaign::Campaign;
use std::collections::{HashMap, HashSet};

/// Placeholders of families whose members stand for readings, positions, times: each family counts as one effect.
const SCANNED: [&str; 5] = ["{other}", "{reading}", "{position}", "{break}", "{tau}"];

fn scanned(candidate: &Candidate) -> Option<&'static str> {
    SCANNED.into_iter().find(|placeholder| candidate.family.contains(placeholder))
}

/// How many tests each candidate's probability accounts for: all distinct effects, times the members of its family.
pub(super) fn multiplicity(campaign: &Campaign, candidates: &[Candidate], evidence: &Evidence) -> Vec<f64> {
    let visible = |j: usize| evidence.pool.visible().get(j).is_some_and(|v| *v > 0.0);
    let score = |j: usize| evidence.pool.scores().get(j).map_or(0.0, |s| s.abs());
    let mut single: Vec<f64> = Vec::new();
    let mut families: HashMap<(&str, Option<usize>), usize> = HashMap::new();
    for (j, candidate) in candidates.iter().enumerate().filter(|(j, _)| visible(*j)) {
        match scanned(candidate) {
            None => single.push(score(j)),
            Some(_) => *families.entry((&candidate.family, candidate.sensor)).or_insert(0) += 1,
        }
    }
    single.sort_by(f64::total_cmp);
    // columns of one direction have one score, and chance does not repeat nine digits
    single.dedup_by(|a, b| (*a - *b).abs() <= 1e-9 * a.abs().max(b.abs()));
    let effects = (single.len() + families.len()).max(1) as f64;
    let rows = campaign.readings.rows.len();
    let labels: HashSet<&str> = campaign.readings.rows.iter().map(|r| r.position.as_str()).collect();
    let times = if families.keys().any(|(term, _)| term.contains("{break}")) { breaks(campaign).len() } else { 0 };
    let members = |candidate: &Candidate| {
        // its own column at least
        let with_column = families.get(&(candidate.family.as_str(), candidate.sensor)).copied().unwrap_or(1);
        let possible = match scanned(candidate) {
            Some("{other}") => rows * rows.saturating_sub(1) / 2,
            Some("{reading}") => rows,
            Some("{position}") => labels.len(),
            Some("{break}") => times,
            _ => 1,
        };
        with_column.max(possible) as f64
    };
    candidates.iter().map(|c| if scanned(c).is_some() { effects * members(c) } else { effects }).collect()
}

/// Is this set rather the expansion of an unknown pattern: high harmonics of several orders, many positions, readings or steps?
pub(super) fn is_pattern(campaign: &Campaign, candidates: &[Candidate], set: &[usize], settings: &Settings) -> bool {
    let members = || set.iter().filter_map(|j| candidates.get(*j));
    let high: HashSet<usize> = members().map(|c| c.harmonic).filter(|k| *k > settings.own_harmonics).collect();
    let harmonics = members().filter(|c| c.harmonic > 0).count();
    if high.len() > settings.high_orders || (!high.is_empty() && harmonics > settings.high_orders) {
        return true;
    }
    let count = |placeholder: &str| members().filter(|c| scanned(c) == Some(placeholder)).count();
    let rows = campaign.readings.rows.len() as f64;
    let labels: HashSet<&str> = campaign.readings.rows.iter().map(|r| r.position.as_str()).collect();
    count("{reading}") as f64 > (settings.singles * rows).max(2.0)
        || count("{position}") as f64 > (settings.singles * labels.len() as f64).max(2.0)
        || count("{break}") > settings.steps
}

/// The other phase of a high harmonic: the cosine of a sine, and the other way round.
pub(super) fn other_phase(candidates: &[Candidate], index: usize, settings: &Settings) -> Option<usize> {
    let own = candidates.get(index).filter(|own| needs_all(own, settings))?;
    let wanted = if own.regressor.contains("sin(") {
        own.regressor.replace("sin(", "cos(")
    } else {
        own.regressor.replace("cos(", "sin(")
    };
    candidates.iter().position(|other| other.sensor == own.sensor && other.regressor == wanted)
}

/// All harmonics of the angle of a harmonic, with the same factor and in the same sensor.
pub(super) fn harmonics_of(candidates: &[Candidate], index: usize) -> Vec<usize> {
    // `gamma_deg_s*sin(5*alpha)`: the factor, and the angle without its order
    let key = |candidate: &Candidate| {
        let (factor, angle) = candidate.regressor.split_once("sin(").or(candidate.regressor.split_once("cos("))?;
        let angle = angle.trim_start_matches(|c: char| c.is_ascii_digit() || c == '*').to_string();
        (candidate.harmonic > 0).then(|| (candidate.sensor, factor.to_string(), angle))
    };
    let Some(own) = candidates.get(index).and_then(key) else { return Vec::new() };
    let same = candidates.iter().enumerate().filter(|(_, other)| key(other).as_ref() == Some(&own));
    same.map(|(j, _)| j).collect()
}

/// A high harmonic is named only where nothing else is left: it may be one of many that build a pattern.
pub(super) fn needs_all(candidate: &Candidate, settings: &Settings) -> bool {
    candidate.harmonic > settings.own_harmonics
}
