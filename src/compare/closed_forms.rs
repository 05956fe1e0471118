//! Closed forms as data: symbols for readings, formulas, the table as printed; and their values on the readings of one group.
//!
//! A symbol is a mean over the readings that match its criteria: of one sensor's value, or of any line of algebra in the sensors, the
//! joints (rad) and the numeric columns (`"mean_of": "A*cos(2*theta)"`, a Fourier sum). A criterion compares a key with a number, with a
//! sign (`"+"`, `"-"`), or asks that the key is not there (`"none"`).

use crate::algebra::{Expression, Scratch, Tape};
use crate::campaign::{Campaign, JointState, Reading, Readings, Role};
use crate::error::{Fault, Malformed, Result};
use crate::units::Unit;
use crate::wire::{self, Named, Source};
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;

/// The published closed forms of one bench.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClosedForms {
    bench: String,
    /// Paper and equations.
    pub source: String,
    /// The sensor of symbols that name none; the printed table is of its readings.
    pub sensor: String,
    /// How readings fall into groups that are solved apart; `None` where all are solved together.
    #[serde(default)]
    pub group: Option<Group>,
    /// Is least squares beside them the exact estimator rather than the linear one? For formulas that solve a product of unknowns exactly.
    #[serde(default)]
    pub exact: bool,
    /// Do the formulas take Earth rate into account (as `earth_up`, `earth_north`)? Then they are compared with least squares as it is.
    #[serde(default)]
    pub(super) earth_rate: EarthRate,
    /// Symbols, and what picks their readings.
    readings: Named<Symbol>,
    /// Quantity and formula; a formula may use quantities before it.
    #[serde(deserialize_with = "pairs")]
    pub formulas: Vec<(String, String)>,
    #[serde(default)]
    printed: Vec<Printed>,
}

fn pairs<'de, T: Deserialize<'de>, D: Deserializer<'de>>(from: D) -> std::result::Result<Vec<(String, T)>, D::Error> {
    Named::deserialize(from).map(|named| named.0)
}

#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum EarthRate {
    #[default]
    Ignored,
    Included,
}

/// Readings that are solved together, for example those at one rate.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// The reading key that groups the readings.
    pub by: String,
    /// Both senses of a rate together?
    #[serde(rename = "magnitude")]
    by_magnitude: bool,
    /// The group's value in the formulas.
    pub symbol: String,
    /// What the groups are, for a person.
    pub title: String,
}

/// A symbol of the formulas: a mean over the readings that match.
#[derive(Debug, Clone, Deserialize)]
struct Symbol {
    /// What is averaged; the sensor where nothing is said.
    #[serde(default)]
    mean_of: Option<String>,
    /// Which readings.
    #[serde(flatten)]
    criteria: BTreeMap<String, Criterion>,
}

/// What a key of a reading must be.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged)]
enum Criterion {
    Equal(f64),
    Of(Sign),
}

#[derive(Debug, Clone, Copy, Deserialize)]
enum Sign {
    #[serde(rename = "+")]
    Positive,
    #[serde(rename = "-")]
    Negative,
    #[serde(rename = "none")]
    Absent,
}

/// A table as printed.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Printed {
    of: String,
    /// Title of the table.
    pub title: String,
    unit: String,
    /// One unit of the last printed digit, in internal units.
    pub last_digit: f64,
    /// Values of each group, in internal units.
    groups: Named<Named<f64>>,
    /// Printed means.
    #[serde(deserialize_with = "pairs")]
    pub means: Vec<(String, f64)>,
    /// Coefficients of a row as printed.
    #[serde(default, deserialize_with = "pairs")]
    pub row: Vec<(String, String)>,
    /// The readings that the table belongs to.
    #[serde(skip)]
    values: Vec<f64>,
}

impl Printed {
    /// The printed value of a quantity for a group, in internal units (radians).
    pub(crate) fn of(&self, group: f64, id: &str) -> Option<f64> {
        let (_, values) = self.groups.0.iter().find(|(of, _)| of.parse() == Ok(group))?;
        values.get(id).copied()
    }

    /// From the unit of the table to internal units, with the readings that it belongs to.
    fn resolve(&mut self) -> Result<()> {
        let (unit, radian) = (Unit::parse(&self.unit)?, Unit::parse("rad")?);
        let unit = unit.conversion(&radian).map_or(1.0, |to| to.factor());
        self.last_digit *= unit;
        let values = self.groups.0.iter_mut().flat_map(|(_, values)| &mut values.0);
        values.chain(&mut self.means).for_each(|(_, value)| *value *= unit);
        if let Some((name, text)) = CAMPAIGNS.iter().find(|(name, _)| *name == self.of) {
            let source = Source { name: (*name).into(), text: (*text).into() };
            let campaign = wire::read_campaign(&source, &mut |other| {
                Err(Malformed::new(Fault::File, format!("a published campaign refers to the file '{other}'")))
            })?;
            self.values = sorted_values(&campaign, 0);
        }
        Ok(())
    }
}

/// Closed forms by bench id. A new set is a new file under `data/closed_forms` and a new line here.
const FILES: &[(&str, &str)] = &[
    ("gyro-turntable", include_str!("../../data/closed_forms/gyro-turntable.json")),
    ("accelerometer-plumb-plane", include_str!("../../data/closed_forms/accelerometer-plumb-plane.json")),
    ("accelerometer-dividing-head", include_str!("../../data/closed_forms/accelerometer-dividing-head.json")),
    ("imu-three-axis-table", include_str!("../../data/closed_forms/imu-three-axis-table.json")),
    ("ferraris-accelerometer", include_str!("../../data/closed_forms/ferraris-accelerometer.json")),
    ("ferraris-gyroscope", include_str!("../../data/closed_forms/ferraris-gyroscope.json")),
    ("gyro-skew-triad", include_str!("../../data/closed_forms/gyro-skew-triad.json")),
    ("cube-mirror", include_str!("../../data/closed_forms/cube-mirror.json")),
    ("cube-mirror-right", include_str!("../../data/closed_forms/cube-mirror-right.json")),
];

/// The published campaigns that printed tables belong to.
const CAMPAIGNS: &[(&str, &str)] = &[
    ("li2012-table1", include_str!("../../data/campaigns/li2012-table1.campaign.json")),
    ("li2012-table2", include_str!("../../data/campaigns/li2012-table2.campaign.json")),
];

/// The closed forms of a bench.
///
/// Errors: `UnknownName` where none were published for this bench.
///
/// ```
/// let forms = tumble::compare::closed_forms("gyro-turntable")?;
/// assert_eq!(forms.formulas.len(), 6);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn closed_forms(bench: &str) -> Result<ClosedForms> {
    let Some((id, text)) = FILES.iter().find(|(id, _)| *id == bench) else {
        let ids: Vec<&str> = FILES.iter().map(|(id, _)| *id).collect();
        return Err(Malformed::new(Fault::UnknownName, format!("no closed forms are known for the bench '{bench}'"))
            .expected(format!("a campaign on one of {}; a fit needs none", ids.join(", ")))
            .found(format!("'{bench}'")));
    };
    let source = Source { name: format!("closed forms of {id}"), text: (*text).into() };
    let mut forms: ClosedForms = wire::parse(&source)?;
    debug_assert_eq!(forms.bench, *id);
    forms.printed.iter_mut().try_for_each(Printed::resolve)?;
    Ok(forms)
}

/// A numeric column at a reading; the rate of a joint is one while it turns (at rest a table may say zero or nothing).
fn column(campaign: &Campaign, reading: &Reading, key: &str) -> Option<f64> {
    let joint = key.strip_suffix("_deg_s").and_then(|name| campaign.bench.joints().position(|joint| joint == name));
    if let Some(joint) = joint {
        return reading.joints.get(joint)?.keys().1;
    }
    campaign.readings.columns.iter().position(|c| c == key).and_then(|k| reading.columns.get(k)).copied().flatten()
}

fn sorted_values(campaign: &Campaign, sensor: usize) -> Vec<f64> {
    let mut values: Vec<f64> = campaign
        .readings
        .rows
        .iter()
        .flat_map(|r| r.observations.iter().filter(|o| o.sensor == sensor).map(|o| o.value))
        .collect();
    values.sort_by(f64::total_cmp);
    values
}

impl Group {
    /// The group that a reading belongs to; `None` where it lacks the key.
    pub(super) fn of(&self, campaign: &Campaign, reading: &Reading) -> Option<f64> {
        let value = column(campaign, reading, &self.by)?;
        Some(if self.by_magnitude { value.abs() } else { value })
    }
}

impl ClosedForms {
    /// The printed table whose readings these are, if any.
    pub(super) fn printed_for(&self, campaign: &Campaign, sensor: usize) -> Option<Printed> {
        let values = sorted_values(campaign, sensor);
        self.printed.iter().find(|printed| printed.values == values).cloned()
    }
}

/// Every formula's value on the readings of one group, in the order of the formulas; `None` where a position that it needs was not read.
///
/// Formulas may use the symbols, the group's value, the known parameters, `g` (specific force at rest), `earth_north`,
/// `earth_up` (Earth rate), in the bench's units, and the formulas before them. A quantity that the campaign knows or assumes to be zero is not computed: the formulas after it use that value.
pub fn evaluate(
    campaign: &Campaign,
    forms: &ClosedForms,
    group: Option<f64>,
    subset: &Readings,
) -> Result<Vec<Option<f64>>> {
    let earth = campaign.bench.earth_rate();
    let physics = [("g", campaign.bench.specific_force().norm()), ("earth_north", earth.y), ("earth_up", earth.z)];
    let mut known: Vec<(String, Option<f64>)> = physics.map(|(name, value)| (name.into(), Some(value))).into();
    known.extend(forms.group.as_ref().map(|grouping| (grouping.symbol.clone(), group)));
    for (name, symbol) in &forms.readings.0 {
        known.push((name.clone(), mean(campaign, symbol, &forms.sensor, subset)?));
    }
    let mut given: Vec<&str> = Vec::new();
    for parameter in &campaign.parameters {
        let value = match parameter.role {
            Role::Known(known) => known.value,
            Role::AssumedZero => 0.0,
            Role::Estimated { .. } => continue,
        };
        given.push(&parameter.id);
        known.push((parameter.id.clone(), Some(value)));
    }
    let mut results = Vec::new();
    for (id, formula) in &forms.formulas {
        if given.contains(&id.as_str()) {
            results.push(None);
            continue;
        }
        let formula = Expression::parse(formula)?;
        let value = |name: &str| known.iter().find(|(other, _)| other == name).and_then(|(_, value)| *value);
        let mut result = None;
        if formula.names().into_iter().all(|name| value(name).is_some()) {
            // those that the formula uses have values
            let names: Vec<&str> = known.iter().map(|(name, _)| name.as_str()).collect();
            let inputs: Vec<f64> = known.iter().map(|(_, value)| value.unwrap_or_default()).collect();
            let value = Tape::compile(&formula, &names)?.value(&inputs, &mut Scratch::default());
            result = Some(value).filter(|value| value.is_finite());
        }
        results.push(result);
        known.push((id.clone(), result));
    }
    Ok(results)
}

/// The mean of a symbol's line over the readings that match it; `None` where none does.
fn mean(campaign: &Campaign, symbol: &Symbol, sensor: &str, subset: &Readings) -> Result<Option<f64>> {
    let mean_of = Expression::parse(symbol.mean_of.as_deref().unwrap_or(sensor))?;
    let names = mean_of.names();
    let tape = Tape::compile(&mean_of, &names)?;
    let mut scratch = Scratch::default();
    let (mut sum, mut count) = (0.0, 0.0);
    for reading in &subset.rows {
        if !symbol.criteria.iter().all(|(key, criterion)| matches(campaign, reading, key, *criterion)) {
            continue;
        }
        let inputs: Option<Vec<f64>> = names.iter().map(|name| input(campaign, reading, name)).collect();
        if let Some(inputs) = inputs {
            sum += tape.value(&inputs, &mut scratch);
            count += 1.0;
        }
    }
    Ok((count > 0.0).then(|| sum / count))
}

/// What a name means at a reading: a sensor's value, a held joint's angle in radians, or a numeric column.
fn input(campaign: &Campaign, reading: &Reading, name: &str) -> Option<f64> {
    if let Some(sensor) = campaign.bench.sensors.iter().position(|s| s.id == name) {
        return reading.observations.iter().find(|o| o.sensor == sensor).map(|o| o.value);
    }
    if let Some(joint) = campaign.bench.joints().position(|joint| joint == name) {
        return match reading.joints.get(joint)? {
            JointState::Held { angle_deg } => Some(angle_deg.to_radians()),
            _ => None,
        };
    }
    column(campaign, reading, name)
}

fn matches(campaign: &Campaign, reading: &Reading, key: &str, criterion: Criterion) -> bool {
    match (column(campaign, reading, key), criterion) {
        (value, Criterion::Of(Sign::Absent)) => value.is_none(),
        (None, _) => false,
        (Some(value), Criterion::Of(Sign::Positive)) => value > 0.0,
        (Some(value), Criterion::Of(Sign::Negative)) => value < 0.0,
        (Some(value), Criterion::Equal(wanted)) => {
            let difference = value - wanted;
            let turn = if key.ends_with("_deg") { (difference / 360.0).round() * 360.0 } else { 0.0 };
            (difference - turn).abs() < 1e-9
        }
    }
}
