//! Closed forms as data: symbols for readings, formulas, the table as printed.

use crate::algebra::Expression;
use crate::campaign::{AngleUnit, Campaign, Reading};
use crate::error::{Fault, Malformed, Result};
use crate::wire::{self, Named, Source};
use serde::Deserialize;

/// The published closed forms of one bench.
#[derive(Debug, Clone)]
pub struct ClosedForms {
    /// Paper and equations.
    pub source: String,
    /// The sensor that they use.
    pub sensor: String,
    /// The reading key that groups the readings.
    pub group_by: String,
    /// Group by magnitude (both senses of a rate together)?
    group_by_magnitude: bool,
    /// The group's value in the formulas.
    pub group_symbol: String,
    /// What the groups are, for a person.
    pub group_title: String,
    /// Symbol of a reading, and what picks it.
    pub(super) readings: Vec<(String, Vec<(String, Criterion)>)>,
    /// Quantity and formula; a formula may use quantities before it.
    pub formulas: Vec<(String, Expression)>,
    printed: Vec<Printed>,
}

/// What a key of a reading must be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Criterion {
    Positive,
    Negative,
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
    pub fn of(&self, group: f64, id: &str) -> Option<f64> {
        let (_, values) = self.groups.iter().find(|(own, _)| *own == group)?;
        values.iter().find(|(own, _)| own == id).map(|(_, value)| *value)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    bench: String,
    source: String,
    sensor: String,
    group: GroupFile,
    readings: Named<Named<CriterionFile>>,
    formulas: Named<String>,
    #[serde(default)]
    printed: Vec<PrintedFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GroupFile {
    by: String,
    magnitude: bool,
    symbol: String,
    title: String,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum CriterionFile {
    Number(f64),
    Sign(String),
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
            .expected(format!("a campaign on one of {}; `tumble fit` needs none", ids.join(", ")))
            .found(format!("'{bench}'")));
    };
    let file: File = wire::parse(&Source { name: format!("closed forms of {id}"), text: (*text).into() })?;
    debug_assert_eq!(file.bench, *id);
    let readings = file
        .readings
        .0
        .into_iter()
        .map(|(symbol, criteria)| {
            let criteria = criteria.0.into_iter().map(|(key, criterion)| {
                let criterion = match criterion {
                    CriterionFile::Number(value) => Criterion::Equal(value),
                    CriterionFile::Sign(sign) if sign == "-" => Criterion::Negative,
                    CriterionFile::Sign(_) => Criterion::Positive,
                };
                (key, criterion)
            });
            (symbol, criteria.collect())
        })
        .collect();
    Ok(ClosedForms {
        source: file.source,
        sensor: file.sensor,
        group_by: file.group.by,
        group_by_magnitude: file.group.magnitude,
        group_symbol: file.group.symbol,
        group_title: file.group.title,
        readings,
        formulas: expressions(file.formulas)?,
        printed: file.printed.into_iter().map(printed).collect::<Result<_>>()?,
    })
}

fn expressions(named: Named<String>) -> Result<Vec<(String, Expression)>> {
    named.0.into_iter().map(|(id, text)| Ok((id, Expression::parse(&text)?))).collect()
}

fn printed(file: PrintedFile) -> Result<Printed> {
    let unit = AngleUnit::named(&file.unit).map_or(1.0, AngleUnit::radians);
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

impl ClosedForms {
    /// The group that a reading belongs to.
    pub(super) fn group_of(&self, campaign: &Campaign, reading: &Reading) -> Option<f64> {
        let column = campaign.readings.columns.iter().position(|c| *c == self.group_by)?;
        let value = reading.columns.get(column).copied().flatten()?;
        Some(if self.group_by_magnitude { value.abs() } else { value })
    }

    /// The printed table whose readings these are, if any.
    pub(super) fn printed_for(&self, campaign: &Campaign, sensor: usize) -> Option<Printed> {
        let values = sorted_values(campaign, sensor);
        self.printed.iter().find(|printed| printed.values == values).cloned()
    }
}
