//! Closed forms as data: symbols for readings, formulas, the table as printed.
//!
//! A symbol is a mean over the readings that match its criteria: of one sensor's value, or of any line of algebra in the sensors, the
//! joints (rad) and the numeric columns (`"mean_of": "A*cos(2*theta)"`, a Fourier sum). A criterion compares a key with a number, with a
//! sign (`"+"`, `"-"`), or asks that the key is not there (`"none"`).

use crate::algebra::Expression;
use crate::campaign::{Campaign, Reading};
use crate::error::{Fault, Malformed, Result};
use crate::units::Unit;
use crate::wire::{self, Named, Source};
use serde::Deserialize;

/// The published closed forms of one bench.
#[derive(Debug, Clone)]
pub struct ClosedForms {
    /// Paper and equations.
    pub source: String,
    /// The sensor of symbols that name none; the printed table is of its readings.
    pub sensor: String,
    /// How readings fall into groups that are solved apart; `None` where all are solved together.
    pub group: Option<Group>,
    /// Is least squares beside them the exact estimator rather than the linear one? For formulas that solve a product of unknowns exactly.
    pub exact: bool,
    /// Do the formulas take Earth rate into account (as `earth_up`, `earth_north`)? Then they are compared with least squares as it is.
    pub with_earth_rate: bool,
    /// Symbols, and what picks their readings.
    pub(super) symbols: Vec<Symbol>,
    /// Quantity and formula; a formula may use quantities before it.
    pub formulas: Vec<(String, Expression)>,
    printed: Vec<Printed>,
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
#[derive(Debug, Clone)]
pub(super) struct Symbol {
    pub name: String,
    /// What is averaged.
    pub mean_of: Expression,
    /// Which readings.
    pub criteria: Vec<(String, Criterion)>,
}

/// What a key of a reading must be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Criterion {
    Positive,
    Negative,
    Absent,
    Equal(f64),
}

/// A table as printed.
#[derive(Debug, Clone)]
pub struct Printed {
    /// Title of the table.
    pub title: String,
    /// One unit of the last printed digit, in internal units.
    pub last_digit: f64,
    /// Values of each group, in internal units.
    groups: Vec<(f64, Vec<(String, f64)>)>,
    /// Printed means.
    pub means: Vec<(String, f64)>,
    /// Coefficients of a row as printed.
    pub row: Vec<(String, Expression)>,
    /// The readings that the table belongs to.
    values: Vec<f64>,
}

impl Printed {
    /// The printed value of a quantity for a group, in internal units (radians).
    pub(crate) fn of(&self, group: f64, id: &str) -> Option<f64> {
        let (_, values) = self.groups.iter().find(|(of, _)| *of == group)?;
        values.iter().find(|(of, _)| of == id).map(|(_, value)| *value)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    bench: String,
    source: String,
    sensor: String,
    #[serde(default)]
    group: Option<Group>,
    #[serde(default)]
    exact: bool,
    #[serde(default)]
    earth_rate: EarthRateFile,
    readings: Named<Named<CriterionFile>>,
    formulas: Named<String>,
    #[serde(default)]
    printed: Vec<PrintedFile>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "lowercase")]
enum EarthRateFile {
    #[default]
    Ignored,
    Included,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum CriterionFile {
    Number(f64),
    Text(String),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PrintedFile {
    of: String,
    title: String,
    unit: String,
    last_digit: f64,
    groups: Named<Named<f64>>,
    means: Named<f64>,
    #[serde(default)]
    row: Named<String>,
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
    let file: File = wire::parse(&Source { name: format!("closed forms of {id}"), text: (*text).into() })?;
    debug_assert_eq!(file.bench, *id);
    let symbols =
        file.readings.0.into_iter().map(|(name, keys)| symbol(name, &file.sensor, keys)).collect::<Result<_>>()?;
    Ok(ClosedForms {
        source: file.source,
        sensor: file.sensor,
        group: file.group,
        exact: file.exact,
        with_earth_rate: matches!(file.earth_rate, EarthRateFile::Included),
        symbols,
        formulas: expressions(file.formulas)?,
        printed: file.printed.into_iter().map(printed).collect::<Result<_>>()?,
    })
}

fn symbol(name: String, sensor: &str, keys: Named<CriterionFile>) -> Result<Symbol> {
    let mut mean_of = Expression::parse(sensor)?;
    let mut criteria = Vec::new();
    for (key, value) in keys.0 {
        let criterion = match value {
            CriterionFile::Number(value) => Criterion::Equal(value),
            CriterionFile::Text(line) if key == "mean_of" => {
                mean_of = Expression::parse(&line)?;
                continue;
            }
            CriterionFile::Text(sign) if sign == "+" => Criterion::Positive,
            CriterionFile::Text(sign) if sign == "-" => Criterion::Negative,
            CriterionFile::Text(word) if word == "none" => Criterion::Absent,
            CriterionFile::Text(other) => {
                return Err(Malformed::new(Fault::Value, format!("the symbol {name} asks for an unknown {key}"))
                    .expected("a number, \"+\", \"-\" or \"none\"")
                    .found(format!("'{other}'")));
            }
        };
        criteria.push((key, criterion));
    }
    Ok(Symbol { name, mean_of, criteria })
}

fn expressions(named: Named<String>) -> Result<Vec<(String, Expression)>> {
    named.0.into_iter().map(|(id, text)| Ok((id, Expression::parse(&text)?))).collect()
}

fn printed(file: PrintedFile) -> Result<Printed> {
    let (unit, radian) = (Unit::parse(&file.unit)?, Unit::parse("rad")?);
    let unit = unit.conversion(&radian).map_or(1.0, |to| to.factor());
    let scaled = |named: Named<f64>| named.0.into_iter().map(|(id, value)| (id, value * unit)).collect::<Vec<_>>();
    let mut values = Vec::new();
    if let Some((name, text)) = CAMPAIGNS.iter().find(|(name, _)| *name == file.of) {
        let source = Source { name: (*name).into(), text: (*text).into() };
        let campaign = wire::read_campaign(&source, &mut |other| {
            Err(Malformed::new(Fault::File, format!("a published campaign refers to the file '{other}'")))
        })?;
        values = sorted_values(&campaign, 0);
    }
    Ok(Printed {
        title: file.title,
        last_digit: file.last_digit * unit,
        groups: file
            .groups
            .0
            .into_iter()
            .filter_map(|(group, values)| Some((group.parse().ok()?, scaled(values))))
            .collect(),
        means: scaled(file.means),
        row: expressions(file.row)?,
        values,
    })
}

/// A numeric column at a reading; the rate of a joint is one while it turns (at rest a table may say zero or nothing).
pub(super) fn column(campaign: &Campaign, reading: &Reading, key: &str) -> Option<f64> {
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
