//! The effects of the catalogue on a schedule, as a report has them.

use super::ARCSEC;
use crate::campaign::Campaign;
use crate::diagnosis::{Fate, Foresight, Prospect, is_angle};
use crate::language::{Language, say};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What a diagnosis could find on a schedule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ForesightReport {
    /// The rule behind every smallest size.
    pub rule: RuleReport,
    /// Every effect of the catalogue that this bench and these columns allow.
    pub effects: Vec<ProspectReport>,
    /// Effects that this schedule cannot distinguish, the most plausible first; most groups have one member.
    pub groups: Vec<AlikeReport>,
    /// Families of effects that were passed over, with the columns that the schedule lacks for them.
    pub passed_over: Vec<PassedOverReport>,
}

/// The rule behind every smallest size: `minimal = noncentrality u`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct RuleReport {
    /// Probability of naming anything when nothing is missing, over all tests.
    pub significance: f64,
    /// Probability of seeing an effect of the smallest size.
    pub power: f64,
    /// Distinct directions: tests that are made.
    pub tests: usize,
    /// `z(1 - a/2) + z(power)` with `a` the level of one test (Sidak), a pure number; the noise is known.
    pub noncentrality: f64,
    /// The same if the noise is known from the residuals only; null with too few degrees of freedom.
    pub with_residuals: Option<f64>,
}

/// One effect on a schedule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ProspectReport {
    /// The term without its coefficient.
    pub regressor: String,
    /// Name in the field's words.
    pub name: String,
    /// Sensor that would have it; null for what is common to all.
    pub sensor: Option<String>,
    /// `detectable`, `absorbed` (the estimated parameters take it up) or `not-exercised` (zero at every position).
    pub fate: Fate,
    /// Share of its column that the model leaves, 0 to 1.
    pub left: f64,
    /// Unit of the coefficient; may be empty.
    pub unit: String,
    /// Standard uncertainty of the coefficient estimated together with the others, in `unit`; null unless detectable.
    pub u: Option<f64>,
    /// Smallest size that shows, in `unit`.
    pub minimal: Option<f64>,
    /// The same in arcseconds, for angles.
    pub minimal_arcsec: Option<f64>,
    /// The most that an effect of this size changes a value, in the sensor's unit.
    pub at_a_reading: Option<f64>,
    /// The same in standard uncertainties of the value.
    pub at_a_reading_in_u: Option<f64>,
    /// The estimated parameter that it shifts most against its u while it is not in the model.
    pub moves: Option<MovesReport>,
    /// Shift of each estimated parameter for coefficient 1, in the parameter's unit (rad for tilts).
    pub shifts: BTreeMap<String, f64>,
    /// Parameters that take part in hiding an absorbed effect, the strongest first.
    pub hides_in: Vec<String>,
    /// Its group, from 0; null unless detectable.
    pub group: Option<usize>,
}

/// The parameter that an effect of the smallest size shifts most.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct MovesReport {
    /// The parameter.
    pub parameter: String,
    /// Size of the shift in standard uncertainties of the parameter.
    pub in_u: f64,
}

/// Effects that cannot be distinguished.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct AlikeReport {
    /// Regressors, the plainest first.
    pub members: Vec<String>,
    /// The plainest, as an index into `effects`, from 0.
    pub first: usize,
    /// Groups for which an effect of the smallest size could be taken.
    pub near: Vec<NearReport>,
}

/// A group that is nearly alike.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct NearReport {
    /// First regressor of the other group.
    pub regressor: String,
    /// The other group, from 0.
    pub group: usize,
    /// Cosine of the angle between the two after projection on the model, -1 to 1.
    pub cosine: f64,
    /// Size of the first effect of this group from which it is not taken for the other, in its coefficient's unit.
    pub apart_from: f64,
}

/// A family of effects that was passed over.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct PassedOverReport {
    /// Its name.
    pub name: String,
    /// Columns that the schedule lacks.
    pub needs: Vec<String>,
}

/// The report of a foresight.
pub fn foresight_report(campaign: &Campaign, foresight: &Foresight) -> ForesightReport {
    let id = |k: &usize| campaign.parameter_id(*k).to_string();
    // groups and aliases hold places of prospects
    let label = |j: &usize| foresight.prospects.get(*j).map(|p| labelled(campaign, p)).unwrap_or_default();
    let first = |g: usize| foresight.groups.get(g).and_then(|own| own.members.first()).map(label).unwrap_or_default();
    let effect = |p: &Prospect| ProspectReport {
        regressor: p.effect.regressor.clone(),
        name: p.effect.name.clone(),
        sensor: p.effect.sensor.and_then(|k| campaign.bench.sensors.get(k)).map(|s| s.id.clone()),
        fate: p.fate,
        left: p.left,
        unit: p.unit.clone(),
        u: p.u,
        minimal: p.minimal,
        minimal_arcsec: p.minimal.filter(|_| is_angle(campaign, &p.effect)).map(|m| m * ARCSEC),
        at_a_reading: p.at_a_reading.map(|(value, _)| value),
        at_a_reading_in_u: p.at_a_reading.map(|(_, ratio)| ratio),
        moves: p.moves.map(|(k, in_u)| MovesReport { parameter: id(&k), in_u }),
        shifts: p.shifts.iter().enumerate().map(|(k, s)| (id(&k), *s)).collect(),
        hides_in: p.hides_in.iter().map(id).collect(),
        group: p.group,
    };
    ForesightReport {
        rule: RuleReport {
            significance: foresight.rule.significance,
            power: foresight.rule.power,
            tests: foresight.rule.tests,
            noncentrality: foresight.rule.noncentrality,
            with_residuals: foresight.rule.with_residuals,
        },
        effects: foresight.prospects.iter().map(effect).collect(),
        groups: foresight
            .groups
            .iter()
            .map(|group| AlikeReport {
                members: group.members.iter().map(label).collect(),
                // a group has a member at least: it is made round one
                first: group.members.first().copied().unwrap_or_default(),
                near: group
                    .near
                    .iter()
                    .map(|n| NearReport {
                        regressor: first(n.group),
                        group: n.group,
                        cosine: n.cosine,
                        apart_from: n.apart_from,
                    })
                    .collect(),
            })
            .collect(),
        passed_over: foresight
            .passed_over
            .iter()
            .map(|(name, needs)| PassedOverReport { name: name.clone(), needs: needs.clone() })
            .collect(),
    }
}

/// The regressor, with its sensor where the bench has several.
fn labelled(campaign: &Campaign, prospect: &Prospect) -> String {
    let sensor = prospect.effect.sensor.and_then(|k| campaign.bench.sensors.get(k));
    match sensor.filter(|_| campaign.bench.sensors.len() > 1) {
        Some(sensor) => format!("{} of {}", prospect.effect.regressor, sensor.id),
        None => prospect.effect.regressor.clone(),
    }
}

/// One line of the table of groups: what a terminal and a page show.
#[derive(Debug, Clone)]
#[cfg_attr(not(feature = "html"), allow(dead_code))] // the page shows all of it
pub(super) struct GroupLine {
    /// First member and its name.
    pub effect: String,
    pub name: String,
    /// Smallest size and its unit; arcsec for angles.
    pub minimal: f64,
    pub unit: String,
    /// Largest change of a value, in its u.
    pub at_a_reading: f64,
    /// `0.3 u of V0`.
    pub moves: String,
    /// Other members, then near groups with their cosines.
    pub alike: Vec<String>,
    pub near: Vec<String>,
    /// The nearest group, in few words.
    pub nearest: Option<String>,
}

/// A regressor with its sensor, as reports have it (`a_S of gyro`), in a language.
fn label(text: &str, lang: Language) -> String {
    match text.split_once(" of ") {
        Some((regressor, sensor)) => say!(lang, "regressor-of-sensor", regressor, sensor),
        None => text.to_string(),
    }
}

/// Groups as lines, in their order.
pub(super) fn group_lines(report: &ForesightReport, lang: Language) -> Vec<GroupLine> {
    let mut lines = Vec::with_capacity(report.groups.len());
    for group in &report.groups {
        let (Some(label), Some(own)) = (group.members.first(), report.effects.get(group.first)) else { continue };
        let (minimal, unit) = match own.minimal_arcsec {
            Some(arcsec) => (arcsec, "arcsec".to_string()),
            // an effect of a group is detectable, and then has both
            None => (own.minimal.unwrap_or(f64::NAN), own.unit.clone()),
        };
        let scale = if own.minimal_arcsec.is_some() { ARCSEC } else { 1.0 };
        lines.push(GroupLine {
            effect: self::label(label, lang),
            name: lang.name(&own.name).into_owned(),
            minimal,
            unit,
            at_a_reading: own.at_a_reading_in_u.unwrap_or(f64::NAN),
            moves: own.moves.as_ref().map_or(String::new(), |m| {
                format!("{} {} u", m.parameter, crate::document::number::significant(m.in_u, 2))
            }),
            alike: group.members.iter().skip(1).map(|member| self::label(member, lang)).collect(),
            nearest: group.near.first().map(|n| {
                say!(
                    lang,
                    "foresight-nearly",
                    regressor = self::label(&n.regressor, lang),
                    cosine = format!("{:+.2}", n.cosine)
                )
            }),
            near: group
                .near
                .iter()
                .map(|n| {
                    let apart = crate::document::number::significant(n.apart_from * scale, 2);
                    say!(
                        lang,
                        "apart-from",
                        regressor = self::label(&n.regressor, lang),
                        cosine = format!("{:+.3}", n.cosine),
                        apart
                    )
                })
                .collect(),
        });
    }
    lines
}

/// Absorbed effects by the parameters that hide them: `dtheta_y0 and V0` with the regressors.
pub(super) fn hidden(report: &ForesightReport, lang: Language) -> Vec<(String, Vec<String>)> {
    let mut places: Vec<(String, Vec<String>)> = Vec::new();
    for effect in report.effects.iter().filter(|e| e.fate == Fate::Absorbed) {
        let place = effect.hides_in.join(", ");
        let text = match &effect.sensor {
            Some(sensor) if report.effects.iter().any(|e| e.sensor.as_ref().is_some_and(|s| s != sensor)) => {
                label(&format!("{} of {sensor}", effect.regressor), lang)
            }
            _ => effect.regressor.clone(),
        };
        match places.iter_mut().find(|(own, _)| *own == place) {
            Some((_, list)) => list.push(text),
            None => places.push((place, vec![text])),
        }
    }
    places
}

/// Regressors that are zero at every position.
pub(super) fn not_exercised(report: &ForesightReport) -> Vec<String> {
    let mut list: Vec<String> =
        report.effects.iter().filter(|e| e.fate == Fate::NotExercised).map(|e| e.regressor.clone()).collect();
    list.dedup();
    list
}

/// What the rule says, in one sentence.
pub(super) fn rule_text(report: &ForesightReport, lang: Language) -> String {
    let rule = &report.rule;
    if report.groups.is_empty() {
        return say!(lang, "none-would-show-the-estimated-parameters-take").into();
    }
    let number = |v: f64| crate::document::number::significant(v, 3);
    let with_residuals = rule.with_residuals.map_or(say!(lang, "none").into(), |size| format!("{} u", number(size)));
    say!(
        lang,
        "smallest-size-that-shows-u-significance-for",
        size = number(rule.noncentrality),
        significance = rule.significance.to_string(),
        power = rule.power.to_string(),
        with_residuals
    )
}

/// Columns that are lacking, with how many families need each.
pub(super) fn lacking(report: &ForesightReport) -> Vec<(String, usize)> {
    let mut columns: BTreeMap<String, usize> = BTreeMap::new();
    for column in report.passed_over.iter().flat_map(|p| &p.needs) {
        *columns.entry(column.clone()).or_default() += 1;
    }
    columns.into_iter().collect()
}
