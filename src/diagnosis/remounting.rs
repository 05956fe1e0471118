//! Positions that scatter: a remounting shifts all readings of a position together, and no column of the catalogue is that.
//!
//! ```text
//! P(source) ~ p(y | S, K) p(K),    K: each kernel of the bank, none, and one for each source, a deviation at each mounting through its column
//! ```
//!
//! given the effects named. Where settings were not mounted more than once, a scatter of positions and an unknown pattern of the settings are one, and neither is named.

use super::augmented::{Seen, State};
use super::finding::of_all;
use super::score::{ALIAS, Deviation, Kernel, Priors, Problem, Score};
use super::{Candidate, Diagnosis, Effect, Finding, NoiseFrom, Separation, Settings, Verdict, finding};
use crate::bench::Link;
use crate::campaign::{Campaign, Deviating, JointState, Per, Scatter, Size};
use crate::elements::Elements;
use crate::error::Result;
use crate::fit::{self, Fit};
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

/// One that may deviate at each mounting, as the readings show it.
struct Deviates {
    source: Source,
    probability: f64,
    /// Twice what it adds to the logarithm of the restricted likelihood.
    gain: f64,
    /// Its size in words.
    size: String,
}

/// What deviates anew at each mounting, given the effects named.
pub(super) struct Scattering {
    /// The most probable first.
    each: Vec<Deviates>,
    /// That any of them does.
    probability: f64,
    /// Were settings mounted more than once? Else nothing but the sources and none is compared.
    is_separate: bool,
}

/// `None` where a scatter of positions is in the model, or positions are too few.
pub(super) fn scattering(campaign: &Campaign, seen: &Seen, settings: &Settings) -> Option<Scattering> {
    if seen.weighted.estimate.dof == 0 || campaign.scatter.iter().any(|line| line.per == Per::Position) {
        return None;
    }
    let (positions, mountings) = mountings(campaign);
    // where the noise is stated a position needs no second reading
    let is_stated = seen.weighted.from == NoiseFrom::Stated;
    if positions < FEWEST || (!is_stated && campaign.readings.rows.len() < positions + FEWEST) {
        return None;
    }
    let is_separate = mountings >= FEWEST;
    if !is_separate && seen.state == State::Nothing {
        return None;
    }
    let mut sources = sources(campaign);
    // kernels of the bank that have no probability given the named effects are left out
    let probable = |k: usize| seen.deviations.each.iter().any(|deviation| deviation.kernel == Some(k));
    let is_first = |kernel: &Kernel| kernel.per_mounting && kernel.sensor.is_none();
    let among = seen.deviations.kernels.iter().enumerate();
    let among = among.filter(|(k, kernel)| is_separate && probable(*k) && !is_first(kernel));
    let mut kernels: Vec<Kernel> = among.map(|(_, kernel)| kernel.clone()).collect();
    let (of_bank, count) = (kernels.len(), sources.len());
    let mut scales: Vec<Vec<f64>> = Vec::new();
    sources.retain(|source| {
        let (factor, scale) = factor(campaign, seen, source);
        let is_felt = factor.ncols() > 0;
        // offsets are one kind, as in the bank, joints and tilts another
        let one_of = if kernels.len() == of_bank { 1 } else { count - 1 };
        if is_felt {
            kernels.push(Kernel { follows: None, per_mounting: true, one_of, factor: factor.into(), sensor: None });
            scales.push(scale);
        }
        is_felt
    });
    let members: Vec<&Candidate> = seen.named.iter().filter_map(|(j, _)| seen.candidates.get(*j)).collect();
    let columns = seen.weighted.columns(members.iter().map(|c| &c.column));
    let problem = Problem {
        residual: &seen.weighted.residual,
        basis: seen.weighted.estimate.factor.thin_q(),
        columns: columns.as_ref(),
        prior: &vec![0.0; members.len()],
        plain: &vec![f64::INFINITY; members.len()],
        fixed: &members.iter().map(|c| c.fixed).collect::<Vec<_>>(),
        kinds: &[],
        known: seen.weighted.from == NoiseFrom::Stated,
        kernels: &kernels,
        sharing: is_separate.then(|| 1.0 + seen.deviations.kernels.iter().map(Kernel::share).sum::<f64>()),
    };
    let score = Score::new(&problem, Priors { all_kernels: true, ..Priors::at(settings.significance) });
    let mut set: Vec<u16> = (0..members.len()).filter_map(|j| score.standing(j)).collect();
    set.sort_unstable();
    set.dedup();
    let deviations = score.deviations(&set);
    let mut each: Vec<Deviates> = Vec::new();
    for (k, (source, scales)) in sources.into_iter().zip(scales).enumerate() {
        // an offset of one sensor alone is one of all
        let is_offset = |j: usize| k == 0 && j < of_bank && kernels.get(j).is_some_and(|kernel| kernel.per_mounting);
        let is_own = |d: &&Deviation| d.kernel.is_some_and(|j| j == of_bank + k || is_offset(j));
        let own = || deviations.iter().filter(is_own);
        let probability: f64 = own().map(|d| d.probability).sum();
        let variance: f64 = own().map(|d| d.probability * d.ratio * d.variance).sum::<f64>() / probability;
        let mut places: Vec<usize> = own().filter_map(|d| d.kernel).collect();
        places.dedup();
        let gain = places.into_iter().map(|place| score.gain(place, &set)).fold(0.0, f64::max);
        let size =
            |(line, scale): (&Scatter, &f64)| format!("sd {:.2e} {}", variance.sqrt() * scale * line.shown, line.unit);
        let size = source.lines.iter().zip(&scales).map(size).collect::<Vec<_>>().join(", ");
        if probability > 0.0 {
            each.push(Deviates { source, probability, gain, size });
        }
    }
    each.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let probability = each.iter().map(|one| one.probability).sum();
    Some(Scattering { each, probability, is_separate })
}

/// The kernel of a source: of each of its lines the deviations, weighted, with one for the mean of their variances in the readings that feel them; and the
/// standard deviations of each line that this is.
fn factor(campaign: &Campaign, seen: &Seen, source: &Source) -> (Mat<f64>, Vec<f64>) {
    let mut with = campaign.clone();
    with.scatter.clone_from(&source.lines);
    let u: Vec<f64> = seen.weighted.own_weight.iter().map(|w| 1.0 / w).collect();
    let (mut columns, mut scales): (Vec<Vec<f64>>, Vec<f64>) = (Vec::new(), Vec::new());
    for line in fit::scatter_lines(&with, &seen.design, &u) {
        let levels = line.felt.iter().map(|felt| felt.level + 1).max().unwrap_or(0);
        let mut own = vec![vec![0.0; u.len()]; levels];
        for felt in &line.felt {
            own.iter_mut().skip(felt.level).take(1).for_each(|column| {
                column.iter_mut().skip(felt.row).take(1).for_each(|slot| *slot = felt.by);
            });
        }
        own.iter_mut().for_each(|column| *column = seen.weighted.whiten(column));
        let trace: f64 = own.iter().flatten().map(|v| v * v).sum();
        let scale = if trace > 0.0 { (line.felt.len() as f64 / trace).sqrt() } else { 0.0 };
        own.iter_mut().flatten().for_each(|v| *v *= scale);
        scales.push(scale);
        columns.extend(own.into_iter().filter(|_| scale > 0.0));
    }
    (Mat::from_fn(u.len(), columns.len(), |i, j| columns.at(j).at(i)), scales)
}

/// The diagnosis with positions that scatter, if they do and that leaves nothing unexplained; else as it is.
pub(super) fn diagnose(
    campaign: &Campaign,
    catalogue: &[Effect],
    settings: &Settings,
    (mut first, scattering): (Diagnosis, Option<Scattering>),
) -> Result<Diagnosis> {
    let probable = scattering.filter(|scattering| scattering.probability >= settings.probability);
    let Some(Scattering { each, probability, is_separate }) = probable else { return Ok(first) };
    let Some((best, others)) = each.split_first() else { return Ok(first) };
    if !is_separate {
        let left = matches!(first.verdict, Verdict::Unexplained | Verdict::PartlyExplained);
        if let (true, Some(unexplained)) = (left, &mut first.unexplained) {
            let (name, size) = (&best.source.name, &best.size);
            unexplained.pattern.push_str(&format!(
                "; a random effect of position ({name}, {size}) cannot be distinguished from it: repeat some mountings to separate them"
            ));
        }
        return Ok(first);
    }
    let source = &best.source;
    let mut with = campaign.clone();
    for line in &source.lines {
        with.add_scatter(line.clone())?;
    }
    let (mut second, _) = super::given(&with, catalogue, settings)?;
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
    let least = best.probability * (-ALIAS).exp();
    let aliases: Vec<&Deviates> = others.iter().filter(|other| other.probability > least).collect();
    let found = (best, p(best.gain, each.len()), probability.min(1.0));
    let finding = of(campaign, &after, found, &aliases, &first.before);
    if second.after.is_none() {
        second.changes = finding::changes(&first.before, &after, &[]);
        second.repaired = Some(after.campaign.clone());
    }
    second.verdict = Verdict::EffectsFound;
    second.gap_before = first.gap_before;
    second.before = first.before;
    second.after = Some(after);
    second.effects.insert(0, finding);
    second.candidates = (second.candidates.0.max(first.candidates.0) + each.len(), second.candidates.1 + 1);
    Ok(second)
}

/// Twice the one-sided probability at the boundary is that of chi-square; over all that might deviate (Sidak).
fn p(gain: f64, tried: usize) -> f64 {
    // a gain that is not finite is none
    let alone = 0.5 * chi_square_survival(gain.max(0.0), 1.0).unwrap_or(1.0);
    of_all(alone, tried.max(1) as f64)
}

/// Labelled positions, and how many mountings there are beyond the first of each setting of the angles.
fn mountings(campaign: &Campaign) -> (usize, usize) {
    let held = |state: &JointState| state.held_deg().map(|deg| (deg + 0.0).to_bits());
    let mut labels: HashMap<&str, Vec<Option<u64>>> = HashMap::new();
    for reading in campaign.readings.rows.iter().filter(|r| !r.position.is_empty()) {
        labels.entry(&reading.position).or_insert_with(|| reading.joints.iter().map(held).collect());
    }
    let settings: std::collections::HashSet<&Vec<Option<u64>>> = labels.values().collect();
    (labels.len(), labels.len() - settings.len())
}

/// Offsets of the sensors, each joint, each tilt, and the tilts of each face together, new at every position.
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
    let offset = |s: &usize| line(Deviating::Sensor(*s), 1.0, campaign.sensor_unit(*s));
    let offsets: Vec<Scatter> = sensors.iter().map(offset).collect();
    let name = sensors.iter().map(|s| campaign.sensor_id(*s)).collect::<Vec<_>>().join(", ");
    let mut sources = vec![Source { name, lines: offsets }];
    for (k, joint) in campaign.bench.joints().enumerate() {
        if campaign.readings.rows.iter().any(|row| row.joints.get(k).and_then(JointState::held_deg).is_some()) {
            let lines = vec![line(Deviating::Joint(k), arcsec, "arcsec")];
            sources.push(Source { name: joint.to_string(), lines });
        }
    }
    // the tilts between two joints are those of one face, which is seated anew about both of its axes
    let is_tilt = |link: &&Link| matches!(link, Link::Tilt { .. });
    for face in campaign.bench.chain.chunk_by(|a, b| is_tilt(&a) == is_tilt(&b)) {
        let tilts = || face.iter().filter(is_tilt).filter_map(|link| campaign.parameter_index(link.name()));
        let line = |k: usize| line(Deviating::Parameter(k), arcsec, "arcsec");
        let name = |k: usize| campaign.parameter_id(k).to_string();
        sources.extend(tilts().map(|k| Source { name: name(k), lines: vec![line(k)] }));
        if tilts().count() > 1 {
            let names: Vec<String> = tilts().map(name).collect();
            sources.push(Source { name: names.join(", "), lines: tilts().map(line).collect() });
        }
    }
    sources
}

/// The finding.
fn of(
    campaign: &Campaign,
    after: &Fit,
    (best, p, probability): (&Deviates, f64, f64),
    aliases: &[&Deviates],
    before: &Fit,
) -> Finding {
    let Deviates { source, gain, .. } = best;
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
    let own_sd = after.system.scaled_u(|g| after.estimate.scale_or_one(g));
    let total: f64 = before.estimate.residuals.iter().zip(own_sd).map(|(v, sd)| (v / sd) * (v / sd)).sum();
    let explains = if total > 0.0 { (1.0 - before.estimate.dof as f64 / total).clamp(0.0, 1.0) } else { 0.0 };
    let sensor = match source.lines.as_slice() {
        [Scatter { of: Deviating::Sensor(s), .. }] if campaign.bench.sensors.len() > 1 => Some(*s),
        _ => None,
    };
    let alias = |other: &&Deviates| {
        let (name, size) = (&other.source.name, &other.size);
        let excess = 2.0 * (best.probability / other.probability).ln();
        super::Alias {
            regressor: format!("scatter:position:{name}"),
            name: format!("{name} varies from position to position, {size}"),
            exact: excess < 1e-6,
            excess,
            probability: other.probability,
            vanishing: false,
            visible: 1.0,
            size: 1.0,
            together_with: None,
        }
    };
    let effect = Candidate {
        regressor: "scatter:position".into(),
        name: format!("positions scatter: {} varies from mounting to mounting", source.name),
        coefficient: format!("sd of {} per position", source.name),
        sensor,
        family: "scatter:position".into(),
        rank: 2,
        why: "the unit, fixture or joint is not repositioned exactly when it is remounted".into(),
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
        probability,
        aliases: aliases.iter().map(alias).collect(),
        separation: Separation::default(),
        also: Vec::new(),
    }
}
