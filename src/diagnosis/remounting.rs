//! Positions that scatter: a remounting shifts all readings of a position together, and no column of the catalogue is that.
//!
//! ```text
//! LR = deviance(noise) - deviance(noise + line per position),    P(LR > x) = P(chi2_1 > x) / 2        S. G. Self, K.-Y. Liang, JASA 82 (1987), 605
//! ```
//!
//! Both deviances are of the restricted likelihood given an offset and a scale of the rate for every setting of the angles: only settings that were mounted more than
//! once tell what a mounting does. Where each setting was mounted once, a scatter of positions and an unknown pattern of the settings are one,
//! and neither is named.

use super::{Candidate, Diagnosis, Effect, Finding, Separation, Settings, Verdict, finding};
use crate::campaign::{Campaign, Deviating, JointState, Kind, Per, Scatter, Size};
use crate::design::DesignMatrix;
use crate::elements::Elements;
use crate::error::Result;
use crate::estimate::{self, Group, ScatterLine, System};
use crate::fit::{self, Fit, Weighting};
use crate::simulate::Regressor;
use crate::uncertainty::quantiles::chi_square_survival;
use faer::Mat;
use std::collections::HashMap;

/// Fewest positions, and fewest mountings beyond the first of each setting, from which a scatter of positions is estimated.
const FEWEST: usize = 4;

/// What may deviate anew at each mounting: one or more lines, and a name for them.
struct Source {
    name: String,
    lines: Vec<Scatter>,
}

/// Share of the significance at which positions scatter: the other half is that of the effects.
const SHARE: f64 = 0.5;

/// The diagnosis with positions that scatter, if they do and that leaves nothing unexplained; else as it is.
pub(super) fn diagnose(
    campaign: &Campaign,
    catalogue: &[Effect],
    settings: &Settings,
    mut first: Diagnosis,
) -> Result<Diagnosis> {
    if first.verdict == Verdict::NotDiagnosable || campaign.scatter.iter().any(|line| line.per == Per::Position) {
        return Ok(first);
    }
    let (positions, mountings) = mountings(campaign);
    let repeated = campaign.readings.rows.len() >= positions + FEWEST;
    if positions < FEWEST || !repeated {
        return Ok(first);
    }
    let sources = sources(campaign);
    if mountings < FEWEST {
        let left = matches!(first.verdict, Verdict::Unexplained | Verdict::PartlyExplained);
        if let (true, Some(unexplained)) = (left, &mut first.unexplained) {
            let model = first.after.as_ref().unwrap_or(&first.before);
            let best = gains(&model.campaign, &sources, &model.design, &[])?.into_iter().next();
            if let Some((_, name, sd)) =
                best.filter(|(gain, ..)| p(*gain, sources.len()) <= SHARE * settings.significance)
            {
                unexplained.pattern.push_str(&format!(
                    "; a random effect of position ({name}, {sd}) cannot be distinguished from it: repeat some mountings to separate them"
                ));
            }
        }
        return Ok(first);
    }
    // with the effects in the model, given an offset of every setting: what neither they nor any pattern of the settings explain
    let model = first.after.as_ref().unwrap_or(&first.before);
    let ranking = ranked_beside_settings(&model.campaign, &self::sources(&model.campaign), &model.design)?;
    let Some((gain, best, _)) = ranking.first() else { return Ok(first) };
    let p = p(*gain, sources.len());
    if !(p <= SHARE * settings.significance) {
        return Ok(first);
    }
    let Some(source) = sources.iter().find(|source| source.name == *best) else { return Ok(first) };
    // where something else than the mounting is what most probably deviates, a line per mounting would only follow it
    let is_offset = source.lines.iter().all(|line| matches!(line.of, Deviating::Sensor(_)));
    if is_offset && first.unexplained.as_ref().is_some_and(|unexplained| !unexplained.per_mounting) {
        return Ok(first);
    }
    let mut with = campaign.clone();
    for line in &source.lines {
        with.add_scatter(line.clone())?;
    }
    let mut second = super::given(&with, catalogue, settings)?;
    if !matches!(second.verdict, Verdict::NothingMissing | Verdict::EffectsFound) {
        return Ok(first);
    }
    let after = second.after.clone().unwrap_or_else(|| second.before.clone());
    // what has no size once the effects are in the model is no finding
    let first_line = after.campaign.scatter.len().saturating_sub(source.lines.len());
    let has_size =
        |source: &crate::fit::VarianceSource| source.line.is_some_and(|k| k >= first_line) && source.variance > 0.0;
    if !after.noise.sources.iter().any(has_size) {
        return Ok(first);
    }
    let aliases: Vec<&(f64, String, String)> =
        ranking.iter().skip(1).filter(|(other, ..)| gain - other < settings.scatters_apart).collect();
    let finding = of(campaign, &after, source, *gain, p, &aliases, &first.before);
    if second.after.is_none() {
        second.changes = finding::changes(&first.before, &after, &[]);
        second.repaired = Some(after.campaign.clone());
    }
    second.verdict = Verdict::EffectsFound;
    second.gap_before = first.gap_before;
    second.before = first.before;
    second.after = Some(after);
    second.effects.insert(0, finding);
    second.candidates = (second.candidates.0.max(first.candidates.0) + sources.len(), second.candidates.1 + 1);
    Ok(second)
}

/// Twice the one-sided probability at the boundary is that of chi-square; over all that might deviate (Sidak).
fn p(gain: f64, tried: usize) -> f64 {
    // a gain that is not finite is none
    let alone = 0.5 * chi_square_survival(gain.max(0.0), 1.0).unwrap_or(1.0);
    -f64::exp_m1(tried.max(1) as f64 * f64::ln_1p(-alone))
}

fn held(joints: &[JointState]) -> Vec<u64> {
    let angle = |state: &JointState| match state {
        JointState::Held { angle_deg } => (angle_deg + 0.0).to_bits(),
        _ => u64::MAX,
    };
    joints.iter().map(angle).collect()
}

/// Labelled positions, and how many mountings there are beyond the first of each setting of the angles.
fn mountings(campaign: &Campaign) -> (usize, usize) {
    let mut labels: HashMap<&str, Vec<u64>> = HashMap::new();
    for reading in campaign.readings.rows.iter().filter(|r| !r.position.is_empty()) {
        labels.entry(&reading.position).or_insert_with(|| held(&reading.joints));
    }
    let settings: std::collections::HashSet<&Vec<u64>> = labels.values().collect();
    (labels.len(), labels.len() - settings.len())
}

/// Offsets of the sensors, each joint and each tilt, new at every position.
fn sources(campaign: &Campaign) -> Vec<Source> {
    let line = |of: Deviating, shown: f64, unit: &str| Scatter {
        of,
        per: Per::Position,
        size: Size::Estimated,
        over: None,
        shown,
        unit: unit.to_string(),
        place: "scatter of positions".into(),
    };
    let arcsec = 648_000.0 / std::f64::consts::PI;
    let read = |s: &usize| campaign.readings.rows.iter().any(|r| r.observations.iter().any(|o| o.sensor == *s));
    let sensors: Vec<usize> = (0..campaign.bench.sensors.len()).filter(read).collect();
    let unit = |s: usize| campaign.bench.sensors.get(s).map_or("", |sensor| sensor.unit.as_str());
    let offsets: Vec<Scatter> = sensors.iter().map(|s| line(Deviating::Sensor(*s), 1.0, unit(*s))).collect();
    let id = |s: &usize| campaign.bench.sensors.get(*s).map_or(String::new(), |sensor| sensor.id.clone());
    let name = sensors.iter().map(id).collect::<Vec<_>>().join(", ");
    let mut sources = vec![Source { name, lines: offsets }];
    for (k, joint) in campaign.bench.joints().enumerate() {
        let is_held = |r: &crate::campaign::Reading| matches!(r.joints.get(k), Some(JointState::Held { .. }));
        if campaign.readings.rows.iter().any(is_held) {
            let lines = vec![line(Deviating::Joint(k), arcsec, "arcsec")];
            sources.push(Source { name: joint.to_string(), lines });
        }
    }
    for (k, parameter) in campaign.parameters.iter().enumerate().filter(|(_, p)| p.kind == Kind::Tilt) {
        let lines = vec![line(Deviating::Parameter(k), arcsec, "arcsec")];
        sources.push(Source { name: parameter.id.clone(), lines });
    }
    sources
}

/// How much each source reduces the deviance, given the lines of the campaign and further columns, the most first: name, and its size in words.
fn gains(
    campaign: &Campaign,
    sources: &[Source],
    design: &DesignMatrix,
    further: &[Vec<f64>],
) -> Result<Vec<(f64, String, String)>> {
    let settings = estimate::Settings::default();
    let System { rows, observed, u, group } = fit::weigh(campaign, design, Weighting::AsStated)?;
    let n = rows.ncols();
    let wider = Mat::from_fn(rows.nrows(), n + further.len(), |i, j| match j.checked_sub(n) {
        None => rows[(i, j)],
        Some(k) => further.at(k).at(i),
    });
    let system = &System { rows: wider, observed, u: fit::own_noise(campaign, design, &u), group };
    let given: Vec<ScatterLine> = fit::noise_lines(campaign, design, &u);
    let before = estimate::scattered((system, &given), None, &[], &settings, false)?.deviance;
    let mut all = Vec::new();
    for source in sources {
        let mut with = campaign.clone();
        with.scatter.clone_from(&source.lines);
        let added = fit::scatter_lines(&with, design, &u);
        if added.iter().all(|line| line.felt.is_empty()) {
            continue;
        }
        let lines: Vec<ScatterLine> = given.iter().cloned().chain(added).collect();
        let Ok(scattered) = estimate::scattered((system, &lines), None, &[], &settings, false) else { continue };
        let sizes: Vec<String> = source
            .lines
            .iter()
            .zip(scattered.variance.iter().skip(given.len()))
            .map(|(line, v)| format!("sd {:.2e} {}", v.max(0.0).sqrt() * line.shown, line.unit))
            .collect();
        let positive = scattered.variance.iter().skip(given.len()).any(|v| *v > 0.0);
        // a variance below zero is no scatter
        let gain = if positive { before - scattered.deviance } else { 0.0 };
        if gain.is_finite() && gain > 0.0 {
            all.push((gain, source.name.clone(), sizes.join(", ")));
        }
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    Ok(all)
}

/// The same given an offset and a scale of the rate for each sensor at each setting of the angles: an unknown pattern of the settings, or one in proportion to
/// the rate.
fn ranked_beside_settings(
    campaign: &Campaign,
    sources: &[Source],
    design: &DesignMatrix,
) -> Result<Vec<(f64, String, String)>> {
    let mut groups: HashMap<(usize, Vec<u64>), [Vec<f64>; 2]> = HashMap::new();
    let mut order: Vec<(usize, Vec<u64>)> = Vec::new();
    for (i, origin) in design.rows.iter().enumerate() {
        let joints = campaign.readings.rows.get(origin.reading).map_or(&[][..], |r| r.joints.as_slice());
        let key = (origin.sensor, held(joints));
        let columns = groups.entry(key.clone()).or_insert_with(|| {
            order.push(key);
            [vec![0.0; design.rows.len()], vec![0.0; design.rows.len()]]
        });
        let rate: f64 = joints.iter().map(JointState::rate_deg_s).sum();
        for (column, value) in columns.iter_mut().zip([1.0, rate]) {
            column.get_mut(i).into_iter().for_each(|slot| *slot = value);
        }
    }
    let columns: Vec<Vec<f64>> = order.iter().filter_map(|key| groups.remove(key)).flatten().collect();
    gains(campaign, sources, design, &columns)
}

/// The finding.
fn of(
    campaign: &Campaign,
    after: &Fit,
    source: &Source,
    gain: f64,
    p: f64,
    aliases: &[&(f64, String, String)],
    before: &Fit,
) -> Finding {
    let line = after.campaign.scatter.len().checked_sub(source.lines.len());
    let component = after.noise.sources.iter().find(|s| s.line.is_some() && s.line == line);
    let sd = component.map(|s| s.variance.max(0.0).sqrt());
    let u = component.filter(|s| s.dof > 0.0 && s.dof.is_finite()).zip(sd).map(|(s, sd)| sd / (2.0 * s.dof).sqrt());
    let is_angle = !matches!(source.lines.first().map(|l| &l.of), Some(Deviating::Sensor(_)));
    let unit = match source.lines.first() {
        _ if is_angle => "rad".to_string(),
        Some(line) => line.unit.clone(),
        None => String::new(),
    };
    // of the sum of squares in variances of single readings, what is beyond their number
    let scale = |group: &Group| match group {
        Group::Estimated(g) => after.estimate.scale_or_one(*g),
        Group::Known => 1.0,
    };
    let own_sd = after.system.u.iter().zip(&after.system.group).map(|(u, group)| u * scale(group));
    let total: f64 = before.estimate.residuals.iter().zip(own_sd).map(|(v, sd)| (v / sd) * (v / sd)).sum();
    let explains = if total > 0.0 { (1.0 - before.estimate.dof as f64 / total).clamp(0.0, 1.0) } else { 0.0 };
    let sensor = match source.lines.as_slice() {
        [Scatter { of: Deviating::Sensor(s), .. }] if campaign.bench.sensors.len() > 1 => Some(*s),
        _ => None,
    };
    let spread: f64 = aliases.iter().map(|(other, ..)| (0.5 * (other - gain)).exp()).sum::<f64>() + 1.0;
    let alias = |(other, name, size): &&(f64, String, String)| super::Alias {
        regressor: format!("scatter:position:{name}"),
        name: format!("{name} deviates at each position, {size}"),
        exact: gain - other < 1e-6,
        excess: gain - other,
        probability: (0.5 * (other - gain)).exp() / spread,
        vanishing: false,
        visible: 1.0,
        size: 1.0,
        together_with: None,
    };
    let effect = Candidate {
        regressor: "scatter:position".into(),
        name: format!("positions scatter: {} deviates at each mounting", source.name),
        coefficient: format!("sd of {} per position", source.name),
        sensor,
        family: "scatter:position".into(),
        rank: 2,
        why: "the unit, fixture or joint does not come back to the same place when it is mounted again".into(),
        confirm: "mount one position several times; state the scatter as a line of the campaign".into(),
        ..Candidate::new(Regressor::Scatter, vec![0.0; before.system.observed.len()])
    };
    Finding {
        effect,
        value: sd,
        u,
        unit,
        t: gain.max(0.0).sqrt(),
        p,
        explains,
        probability: 1.0 - p,
        aliases: aliases.iter().map(alias).collect(),
        separation: Separation::default(),
        also: Vec::new(),
    }
}
