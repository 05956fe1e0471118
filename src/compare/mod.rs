//! The published closed forms beside least squares: per rate or run, their mean, and the printed table.
//!
//! Papers choose just enough positions to solve by hand; per group of readings their formulas are the square special case of the
//! estimator, and equal it to rounding as long as both use the same physics. Closed forms are data (`data/closed_forms`): symbols for
//! readings, one line of algebra for each angle, and the table as printed.

mod closed_forms;
mod misprints;

pub use closed_forms::{ClosedForms, Printed, closed_forms};
pub use misprints::Misprint;

use crate::algebra::{Scratch, Tape};
use crate::bench::Site;
use crate::campaign::{Campaign, Reading, Readings, Role};
use crate::error::{Fault, Malformed, Result};
use crate::fit::{self, Fit, Settings};
use closed_forms::Criterion;

/// A campaign's angles by the published closed forms and by least squares.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// Where the closed forms come from.
    pub source: String,
    /// What the groups are, for example `rate, deg/s`.
    pub group_title: String,
    /// The quantities, in the order of the formulas.
    pub quantities: Vec<String>,
    /// One entry for each rate or run.
    pub groups: Vec<GroupComparison>,
    /// Means of the closed forms over the groups.
    pub mean: Vec<Option<f64>>,
    /// Least squares on all readings at once.
    pub all: Fit,
    /// The table as printed, if this campaign is the published one.
    pub printed: Option<Printed>,
    /// Where print and computation disagree.
    pub misprints: Vec<Misprint>,
}

/// One rate or run.
#[derive(Debug, Clone)]
pub struct GroupComparison {
    /// The rate or run.
    pub group: f64,
    /// Readings in it.
    pub readings: usize,
    /// By the closed forms; `None` where a position that the formula needs was not read.
    pub closed_form: Vec<Option<f64>>,
    /// By least squares without Earth rate, which the closed forms ignore: the like-for-like comparison.
    pub like_for_like: Vec<Option<f64>>,
    /// By least squares with the site's Earth rate.
    pub least_squares: Vec<Option<f64>>,
    /// What was printed.
    pub printed: Vec<Option<f64>>,
}

/// Compare a campaign with the closed forms of its bench.
///
/// Errors: no closed forms for this bench, a reading without the column that groups them, or anything that [`fit::fit`] refuses.
pub fn compare(campaign: &Campaign, forms: &ClosedForms, settings: &Settings) -> Result<Comparison> {
    let sensor = campaign.bench.sensors.iter().position(|s| s.id == forms.sensor);
    let Some(sensor) = sensor else {
        return Err(Malformed::new(
            Fault::UnknownName,
            format!("the closed forms are for a sensor '{}'", forms.sensor),
        )
        .expected("a bench with this sensor"));
    };
    let all = fit::fit(campaign, settings)?;
    let without_earth = without_earth_rate(campaign);
    let quantities: Vec<String> = forms.formulas.iter().map(|(id, _)| id.clone()).collect();
    let printed = forms.printed_for(campaign, sensor);
    let mut groups = Vec::new();
    for group in group_values(campaign, forms)? {
        let inside: Vec<Reading> =
            campaign.readings.rows.iter().filter(|r| forms.group_of(campaign, r) == Some(group)).cloned().collect();
        let readings = inside.len();
        let subset = Readings { columns: campaign.readings.columns.clone(), rows: inside };
        let closed_form = by_formulas(campaign, forms, sensor, group, &subset)?;
        let by_fit = |campaign: &Campaign| -> Result<Vec<Option<f64>>> {
            let fit = fit::fit(&campaign.with_readings(subset.clone()), settings)?;
            Ok(quantities.iter().map(|id| value_of(&fit, id)).collect())
        };
        groups.push(GroupComparison {
            group,
            readings,
            closed_form,
            like_for_like: by_fit(&without_earth)?,
            least_squares: by_fit(campaign)?,
            printed: quantities.iter().map(|id| printed.as_ref().and_then(|p| p.of(group, id))).collect(),
        });
    }
    let mean: Vec<Option<f64>> = (0..quantities.len())
        .map(|k| {
            let values: Option<Vec<f64>> = groups.iter().map(|g| g.closed_form.get(k).copied().flatten()).collect();
            values.filter(|v| !v.is_empty()).map(|v| v.iter().sum::<f64>() / v.len() as f64)
        })
        .collect();
    let misprints = match &printed {
        Some(printed) => misprints::find(campaign, &all, printed, &quantities, &groups, &mean),
        None => Vec::new(),
    };
    Ok(Comparison {
        source: forms.source.clone(),
        group_title: forms.group_title.clone(),
        quantities,
        groups,
        mean,
        all,
        printed,
        misprints,
    })
}

/// The value of a parameter or derived quantity in a fit.
pub fn value_of(fit: &Fit, id: &str) -> Option<f64> {
    let parameter = fit.parameters.iter().find(|p| p.id == id).and_then(|p| p.value);
    parameter.or_else(|| fit.derived.iter().find(|d| d.id == id).and_then(|d| d.value))
}

fn without_earth_rate(campaign: &Campaign) -> Campaign {
    let mut other = campaign.clone();
    other.bench.site = campaign.bench.site.map(|site| Site { earth_rate_deg_h: 0.0, ..site });
    other
}

/// The groups that the readings fall into, ascending.
fn group_values(campaign: &Campaign, forms: &ClosedForms) -> Result<Vec<f64>> {
    let mut values = Vec::new();
    for reading in &campaign.readings.rows {
        let Some(value) = forms.group_of(campaign, reading) else {
            return Err(Malformed::new(
                Fault::Missing,
                format!("the closed forms go by {}, and a reading lacks it", forms.group_by),
            )
            .expected(format!("{} in every reading", forms.group_by))
            .at_path(reading.place.clone()));
        };
        if !values.contains(&value) {
            values.push(value);
        }
    }
    values.sort_by(f64::total_cmp);
    Ok(values)
}

/// The closed forms on one group: each symbol is the mean of the readings that match it.
fn by_formulas(
    campaign: &Campaign,
    forms: &ClosedForms,
    sensor: usize,
    group: f64,
    subset: &Readings,
) -> Result<Vec<Option<f64>>> {
    let mut names: Vec<String> = vec![forms.group_symbol.clone()];
    let mut values: Vec<Option<f64>> = vec![Some(group)];
    for (symbol, criteria) in &forms.readings {
        let matching: Vec<f64> = subset
            .rows
            .iter()
            .filter(|reading| criteria.iter().all(|(key, criterion)| matches(campaign, reading, key, *criterion)))
            .filter_map(|reading| reading.observations.iter().find(|o| o.sensor == sensor).map(|o| o.value))
            .collect();
        names.push(symbol.clone());
        values.push((!matching.is_empty()).then(|| matching.iter().sum::<f64>() / matching.len() as f64));
    }
    for parameter in &campaign.parameters {
        if let Role::Known(known) = parameter.role {
            names.push(parameter.id.clone());
            values.push(Some(known.value));
        }
    }
    let mut results = Vec::new();
    for (id, formula) in &forms.formulas {
        let borrowed: Vec<&str> = names.iter().map(String::as_str).collect();
        let usable = formula
            .names()
            .iter()
            .all(|name| names.iter().position(|n| n == name).and_then(|k| values.get(k)).is_some_and(Option::is_some));
        let value = if usable {
            let inputs: Vec<f64> = values.iter().map(|v| v.unwrap_or_default()).collect();
            let value = Tape::compile(formula, &borrowed)?.value(&inputs, &mut Scratch::default());
            value.is_finite().then_some(value)
        } else {
            None
        };
        results.push(value);
        names.push(id.clone());
        values.push(value);
    }
    Ok(results)
}

fn matches(campaign: &Campaign, reading: &Reading, key: &str, criterion: Criterion) -> bool {
    let Some(value) =
        campaign.readings.columns.iter().position(|c| c == key).and_then(|k| reading.columns.get(k)).copied().flatten()
    else {
        return false;
    };
    match criterion {
        Criterion::Positive => value > 0.0,
        Criterion::Negative => value < 0.0,
        Criterion::Equal(wanted) => {
            let difference = value - wanted;
            let turn = if key.ends_with("_deg") { (difference / 360.0).round() * 360.0 } else { 0.0 };
            (difference - turn).abs() < 1e-9
        }
    }
}
