//! The effects of the catalogue on a schedule, as a report and its document have them.

use super::ARCSEC;
use crate::campaign::Campaign;
use crate::diagnosis::{Fate, Foresight, Near, PassedOver, Prospect, Rule, is_angle};
use crate::document::number::significant;
use crate::document::{Cell, Detail, Rows, Section};
use crate::language::{Language, code, say};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What a diagnosis could find on a schedule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ForesightReport {
    /// The rule behind every smallest size.
    pub rule: Rule,
    /// Every effect of the catalogue that this bench and these columns allow.
    pub effects: Vec<ProspectReport>,
    /// Effects that this schedule cannot distinguish, the most plausible first; most groups have one member.
    pub groups: Vec<AlikeReport>,
    /// Families of effects that were passed over, with the columns that the schedule lacks for them.
    pub passed_over: Vec<PassedOver>,
}

/// One effect on a schedule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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
pub struct MovesReport {
    /// The parameter.
    pub parameter: String,
    /// Size of the shift in standard uncertainties of the parameter.
    pub in_u: f64,
}

/// Effects that cannot be distinguished.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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
pub struct NearReport {
    /// First regressor of the other group.
    pub regressor: String,
    /// The group and how near it is.
    #[serde(flatten)]
    pub of: Near,
}

pub(super) fn foresight_report(campaign: &Campaign, foresight: &Foresight) -> ForesightReport {
    let id = |k: &usize| campaign.parameter_id(*k).to_string();
    // groups and aliases hold places of prospects
    let label = |j: &usize| foresight.prospects.get(*j).map(|p| labelled(campaign, p)).unwrap_or_default();
    let first = |g: usize| foresight.groups.get(g).and_then(|g| g.members.first()).map(label).unwrap_or_default();
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
    let near = |other: &Near| NearReport { regressor: first(other.group), of: *other };
    ForesightReport {
        rule: foresight.rule,
        effects: foresight.prospects.iter().map(effect).collect(),
        groups: foresight
            .groups
            .iter()
            .map(|group| AlikeReport {
                members: group.members.iter().map(label).collect(),
                // a group has a member at least: it is made round one
                first: group.members.first().copied().unwrap_or_default(),
                near: group.near.iter().map(near).collect(),
            })
            .collect(),
        passed_over: foresight.passed_over.clone(),
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

/// A regressor with its sensor, as reports have it (`a_S of gyro`), in a language.
fn label(text: &str, lang: Language) -> String {
    match text.split_once(" of ") {
        Some((regressor, sensor)) => say!(lang, "regressor-of-sensor", regressor, sensor),
        None => text.to_string(),
    }
}

/// Absorbed effects by the parameters that hide them: `dtheta_y0 and V0` with the regressors.
fn hidden(report: &ForesightReport, lang: Language) -> Vec<(String, Vec<String>)> {
    let mut places: Vec<(String, Vec<String>)> = Vec::new();
    for effect in report.effects.iter().filter(|e| e.fate == Fate::Absorbed) {
        let place = effect.hides_in.join(", ");
        let text = match &effect.sensor {
            Some(sensor) if report.effects.iter().any(|e| e.sensor.as_ref().is_some_and(|s| s != sensor)) => {
                label(&format!("{} of {sensor}", effect.regressor), lang)
            }
            _ => effect.regressor.clone(),
        };
        match places.iter_mut().find(|(known, _)| *known == place) {
            Some((_, list)) => list.push(text),
            None => places.push((place, vec![text])),
        }
    }
    places
}

fn rule_text(report: &ForesightReport, lang: Language) -> String {
    let rule = &report.rule;
    if report.groups.is_empty() {
        return say!(lang, "none-would-show-the-estimated-parameters-take").into();
    }
    let number = |v: f64| significant(v, 3);
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

/// Groups of effects, and combinations that absorb some, that a terminal lists.
const LISTED: usize = 12;

pub(super) fn section(report: &ForesightReport, lang: Language) -> Section {
    let named = |names: &mut dyn Iterator<Item = String>| -> Vec<String> { names.map(|name| code(&name)).collect() };
    let scale = |prospect: &ProspectReport| if prospect.minimal_arcsec.is_some() { ARCSEC } else { 1.0 };
    // an effect of a group is detectable, and then has its smallest size
    let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
    let near = |alike: &NearReport, scale: f64| {
        let (regressor, cosine) = (label(&alike.regressor, lang), format!("{:+.3}", alike.of.cosine));
        say!(lang, "apart-from", regressor, cosine, apart = significant(alike.of.apart_from * scale, 2))
    };
    let nearly = |alike: &NearReport| {
        let (regressor, cosine) = (label(&alike.regressor, lang), format!("{:+.2}", alike.of.cosine));
        say!(lang, "foresight-nearly", regressor, cosine)
    };
    let alike = |group: &AlikeReport| {
        let others = named(&mut group.members.iter().skip(1).map(|member| label(member, lang)));
        match group.near.first() {
            Some(nearest) if others.is_empty() => nearly(nearest),
            _ => lang.first_of(&others, 4, lang.comma()),
        }
    };
    let rows = report
        .groups
        .iter()
        .filter_map(|group| Some((group, group.members.first()?, report.effects.get(group.first)?)));
    let table = Rows::of(rows)
        .name(lang.title(say!(lang, "effect")), |(_, first, _)| label(first, lang))
        .left(say!(lang, "meaning"), |(.., p)| lang.name(&p.name))
        .at(Detail::Full)
        .decimal(say!(lang, "shows-from"), |(.., p)| Cell::Digits(number(p.minimal_arcsec.or(p.minimal)), 3))
        .left(say!(lang, "unit"), |(.., p)| if p.minimal_arcsec.is_some() { "arcsec" } else { &p.unit })
        .decimal(say!(lang, "then-at-a-reading-in-its-u"), |(.., p)| Cell::Digits(number(p.at_a_reading_in_u), 2))
        .left(say!(lang, "and-shifts"), |(.., p)| {
            let moves = p.moves.as_ref().map(|m| format!("{} {} u", m.parameter, significant(m.in_u, 2)));
            moves.unwrap_or_default()
        })
        .left(say!(lang, "cannot-be-distinguished-from"), |(group, ..)| alike(group))
        .left(say!(lang, "nearly-alike"), |(group, _, prospect)| {
            let near: Vec<String> = group.near.iter().map(|n| near(n, scale(prospect))).collect();
            lang.first_of(&near, 4, lang.comma())
        })
        .at(Detail::Full)
        .small()
        .most(LISTED)
        .caption(say!(lang, "effects-that-would-show"))
        .note(say!(lang, "nearly-alike-cosine-beside-the-model-and"));
    let places = hidden(report, lang);
    let never = Rows::of(&places)
        .left(say!(lang, "effect"), |(_, list)| named(&mut list.iter().cloned()).join(", "))
        .left(say!(lang, "taken-up-by"), |(place, _)| place)
        .small()
        .most(LISTED)
        .caption(say!(lang, "effects-that-never-show-estimated-parameters-take"));
    let zero = report.effects.iter().filter(|e| e.fate == Fate::NotExercised).map(|e| e.regressor.clone());
    let mut zero: Vec<String> = zero.collect();
    zero.dedup();
    let zero = named(&mut zero.into_iter()).join(", ");
    let mut notes = Vec::new();
    notes.extend((!zero.is_empty()).then(|| say!(lang, "zero-at-every-position", effects = zero)));
    let mut columns: BTreeMap<&str, usize> = BTreeMap::new();
    for column in report.passed_over.iter().flat_map(|p| &p.needs) {
        *columns.entry(column).or_default() += 1;
    }
    let without = columns.into_iter();
    notes.extend(
        without
            .map(|(column, n)| say!(lang, "not-tried-without-a-column-kinds-of-2", column, families = n.to_string())),
    );
    let [tried, distinct] = [report.effects.len(), report.rule.tests].map(|n| n.to_string());
    Section::new(say!(lang, "what-a-diagnosis-could-find"))
        .prose(say!(lang, "effects-of-the-catalogue-were-tried-in", tried, distinct))
        .prose(lang.sentence(&rule_text(report, lang)))
        .table(table)
        .table(never)
        .list(notes)
}
