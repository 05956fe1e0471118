//! From a search to a diagnosis: findings with aliases, the gap before and after, what the repair does to each parameter.

use super::arena::Arena;
use super::look::Look;
use super::noise::{NoiseFrom, Weighted};
use super::search::{Found, Rival};
use super::separate::Separation;
use super::{Candidate, Diagnosis, Gap, NoiseFloor, Step, Unexplained, Verdict};
use super::{ambiguity, holdout, places, separate};
use crate::campaign::{Campaign, Kind};
use crate::error::Result;
use crate::fit::{self, Fit};

/// An effect that explains what the same readings show.
#[derive(Debug, Clone, PartialEq)]
pub struct Alias {
    /// Its regressor.
    pub regressor: String,
    /// Its name.
    pub name: String,
    /// Is it the same column exactly, or does it only fit not significantly worse?
    pub exact: bool,
    /// How much worse it fits, in noise variances.
    pub excess: f64,
    /// Is its term zero at these positions but for rounding?
    pub rounding: bool,
    /// Is it small at every reading against what its inputs could make of it, or mostly in the model already?
    pub vanishing: bool,
    /// Share of its column's weighted norm that the model leaves.
    pub visible: f64,
    /// Its largest value here over what its inputs could make of it.
    pub size: f64,
    /// A second effect that must then stand in the place of another finding.
    pub together_with: Option<String>,
}

/// A missing effect.
#[derive(Debug, Clone)]
pub struct Finding {
    /// The effect.
    pub effect: Candidate,
    /// Its coefficient in the repaired model; for a known parameter the change; `None` where it is not estimable.
    pub value: Option<f64>,
    /// Standard uncertainty.
    pub u: Option<f64>,
    /// Unit of the coefficient; empty where the model line does not tell.
    pub unit: String,
    /// Student's t (z where the noise is stated) given the other effects.
    pub t: f64,
    /// Family-wise probability of evidence as strong by chance.
    pub p: f64,
    /// Share of the gap's sum of squares that it takes off, the others given.
    pub explains: f64,
    /// What else it could be.
    pub aliases: Vec<Alias>,
    /// Positions that would tell the aliases apart.
    pub separation: Separation,
}

/// An estimated parameter before and after the repair.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Its name.
    pub id: String,
    /// Is it a tilt (radians)?
    pub is_angle: bool,
    /// Its unit.
    pub unit: String,
    /// Value and standard uncertainty before.
    pub before: (Option<f64>, Option<f64>),
    /// Value and standard uncertainty after, if the effects are the ones named.
    pub after: (Option<f64>, Option<f64>),
    /// How far the value would move at most if an alias were the effect: the half-width of a rectangular distribution.
    pub alias_half_width: f64,
}

impl Change {
    /// Standard uncertainty after, not knowing which alias it is: `sqrt(u^2 + half-width^2 / 3)`.
    pub fn u_with_aliases(&self) -> Option<f64> {
        self.after.1.map(|u| u.hypot(self.alias_half_width / 3f64.sqrt()))
    }
}

pub(super) fn conclude(
    campaign: &Campaign,
    before: Fit,
    look: Look,
    repaired: Option<(Campaign, Fit)>,
    steps: Vec<Step>,
) -> Result<Diagnosis> {
    let Look { candidates, arena, weighted, design, found } = look;
    let set: &[usize] = match &found {
        Found::Set { set, .. } => set,
        _ => &[],
    };
    let scale = row_scale(&weighted);
    let gap_before = gap(&before, &scale, &arena, &[]);
    let gap_after = match &repaired {
        Some((_, after)) => gap(after, &scale, &arena, set),
        None => gap_before.clone(),
    };
    let (verdict, effects, unexplained) = match &found {
        _ if weighted.estimate.dof == 0 => (Verdict::NotDiagnosable, Vec::new(), None),
        Found::Nothing => (Verdict::NothingMissing, Vec::new(), None),
        Found::Set { set, rivals } => {
            let after = repaired.as_ref();
            let effects = findings(campaign, &candidates, &arena, &design, set, rivals, after);
            (Verdict::EffectsFound, effects, None)
        }
        Found::Unexplained { nearest, .. } => {
            let cells = places::cells(campaign, &design, &weighted);
            let explains = if arena.rss > 0.0 { 1.0 - arena.rss_of(nearest) / arena.rss } else { 0.0 };
            let nearest: Vec<Candidate> = nearest.iter().filter_map(|j| candidates.get(*j).cloned()).collect();
            let pattern = places::pattern(campaign, &design, &weighted, &cells);
            let unexplained = Unexplained { pattern, cells, nearest, nearest_explains: explains };
            (Verdict::Unexplained, Vec::new(), Some(unexplained))
        }
    };
    let widths = match &found {
        Found::Set { set, rivals } => ambiguity::half_widths(&candidates, &arena, &weighted, set, rivals),
        _ => Vec::new(),
    };
    let changes = repaired.as_ref().map(|(_, after)| changes(&before, after, &widths)).unwrap_or_default();
    let holdout = holdout::holdout(campaign, &before, repaired.as_ref().map(|(_, fit)| fit), &scale);
    let would_help =
        if verdict == Verdict::NotDiagnosable { separate::redundancy(campaign, &before) } else { Vec::new() };
    let sd = noise_sd(&weighted, repaired.as_ref().map_or(&before, |(_, after)| after));
    Ok(Diagnosis {
        verdict,
        effects,
        places: places::places(campaign, &design, &weighted),
        noise: NoiseFloor { sd, from: weighted.from },
        gap_before,
        gap_after,
        unexplained,
        holdout,
        steps,
        candidates: (candidates.len(), arena.tests),
        changes,
        would_help,
        row_sd: scale,
        grouping: None,
        constraints: Vec::new(),
        repaired: None,
        after: repaired.map(|(_, after)| after),
        before,
    })
}

/// Standard uncertainty of each row by the noise floor.
fn row_scale(weighted: &Weighted) -> Vec<f64> {
    weighted.weight.iter().map(|w| 1.0 / w).collect()
}

fn noise_sd(weighted: &Weighted, finished: &Fit) -> Option<f64> {
    let readings = finished.design.rows.len();
    if weighted.from == NoiseFrom::Residuals {
        // of the finished model: the scale of the first group, for a reading of one sample
        return finished.estimate.group_scale.first().copied().flatten();
    }
    let first = |i: &usize| finished.design.rows.get(*i).is_some_and(|origin| origin.sensor == 0);
    let rows: Vec<usize> = (0..readings).filter(first).collect();
    let square: f64 = rows.iter().filter_map(|i| weighted.weight.get(*i)).map(|w| 1.0 / (w * w)).sum();
    (!rows.is_empty()).then(|| (square / rows.len() as f64).sqrt())
}

fn gap(fit: &Fit, scale: &[f64], arena: &Arena, set: &[usize]) -> Gap {
    let readings = fit.design.rows.len();
    let residuals: Vec<f64> = fit.estimate.residuals.iter().take(readings).copied().collect();
    let dof = fit.estimate.dof;
    let square: f64 = residuals.iter().map(|v| v * v).sum();
    let max = residuals.iter().fold(0.0_f64, |max, v| max.max(v.abs()));
    let chi_square = fit.estimate.residuals.iter().zip(scale).map(|(v, u)| (v / u) * (v / u)).sum();
    let p = arena.given(set).and_then(|given| arena.global(&given));
    Gap { rms: (dof > 0).then(|| (square / dof as f64).sqrt()), max, chi_square, dof, p, residuals }
}

fn findings(
    campaign: &Campaign,
    candidates: &[Candidate],
    arena: &Arena,
    design: &crate::design::DesignMatrix,
    set: &[usize],
    rivals: &[Rival],
    repaired: Option<&(Campaign, Fit)>,
) -> Vec<Finding> {
    let rss = arena.rss_of(set);
    let mut findings = Vec::with_capacity(set.len());
    for (place, member) in set.iter().enumerate() {
        let Some(effect) = candidates.get(*member) else { continue };
        let others: Vec<usize> = set.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, j)| *j).collect();
        let Some(without) = arena.given(&others) else { continue };
        let (t, dof) = arena.t(&without, *member);
        let own = arena.cosines.col_as_slice(*member);
        let mut aliases: Vec<(u32, f64, usize, Alias)> = rivals
            .iter()
            .filter(|rival| rival.place == place)
            .filter_map(|rival| {
                let other = candidates.get(rival.candidate)?;
                let cosine = own.get(rival.candidate).map_or(0.0, |g| g.abs());
                let alias = Alias {
                    regressor: other.regressor.clone(),
                    name: other.name.clone(),
                    exact: 1.0 - cosine < 1e-6,
                    excess: rival.excess.max(0.0),
                    rounding: other.rounding,
                    vanishing: other.vanishing,
                    visible: other.visible,
                    size: other.size,
                    together_with: rival.together.and_then(|j| candidates.get(j)).map(|c| c.regressor.clone()),
                };
                let order = u32::from(other.rank) + if other.rounding { 1000 } else { 0 };
                let order = order + if other.vanishing { 300 } else { 0 };
                let order = order + if alias.exact { 0 } else { 100 };
                Some((order, alias.excess, rival.candidate, alias))
            })
            .collect();
        aliases.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let columns: Vec<&Candidate> = aliases.iter().filter_map(|(_, _, j, _)| candidates.get(*j)).collect();
        let separation = separate::positions(campaign, design, effect, &columns);
        let (value, u, unit) = repaired
            .map_or((None, None, String::new()), |(repaired, after)| coefficient(campaign, repaired, after, effect));
        findings.push(Finding {
            effect: effect.clone(),
            value,
            u,
            unit,
            t,
            p: arena.family_wise(t, dof),
            explains: if arena.rss > 0.0 { (without.rss - rss) / arena.rss } else { 0.0 },
            aliases: aliases.into_iter().map(|(_, _, _, alias)| alias).collect(),
            separation,
        });
    }
    findings.sort_by(|a, b| b.t.abs().total_cmp(&a.t.abs()));
    findings
}

fn coefficient(
    campaign: &Campaign,
    repaired: &Campaign,
    after: &Fit,
    effect: &Candidate,
) -> (Option<f64>, Option<f64>, String) {
    let Some(result) = after.parameters.iter().find(|p| p.id == effect.coefficient) else {
        return (None, None, String::new());
    };
    let stated = campaign.parameter_index(&effect.coefficient).and_then(|k| campaign.parameters.get(k));
    let stated = stated.map_or(0.0, crate::campaign::Parameter::reference);
    let unit = if result.kind == Kind::Tilt {
        "rad".to_string()
    } else if result.unit.is_empty() {
        let told = crate::campaign::coefficient_unit(&repaired.bench, &repaired.readings.columns, &effect.coefficient);
        told.unwrap_or_default()
    } else {
        result.unit.clone()
    };
    (result.value.map(|v| v - stated), result.uncertainty.as_ref().map(|c| c.u), unit)
}

fn changes(before: &Fit, after: &Fit, widths: &[f64]) -> Vec<Change> {
    let unknown = |id: &str| before.campaign.estimated().iter().position(|own| own.id == id);
    let of = |p: &fit::ParameterResult| (p.value, p.uncertainty.as_ref().map(|c| c.u));
    before
        .parameters
        .iter()
        .filter_map(|own| {
            let then = after.parameters.iter().find(|p| p.id == own.id)?;
            Some(Change {
                id: own.id.clone(),
                is_angle: own.kind == Kind::Tilt,
                unit: own.unit.clone(),
                before: of(own),
                after: of(then),
                alias_half_width: unknown(&own.id).and_then(|j| widths.get(j)).copied().unwrap_or_default(),
            })
        })
        .collect()
}
