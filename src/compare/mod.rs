//! The published closed forms beside least squares: per rate or run, their mean, and the printed table.
//!
//! Papers choose just enough positions to solve by hand; per group of readings their formulas are the square special case of the
//! estimator, and equal it to rounding as long as both use the same physics. Closed forms are data (`data/closed_forms`): symbols for
//! readings, one line of algebra for each angle, and the table as printed.

pub mod calibrations;
mod closed_forms;
mod misprints;

use closed_forms::EarthRate;
pub(crate) use closed_forms::{ClosedForms, Printed};
pub use closed_forms::{Group, closed_forms, evaluate};
pub(crate) use misprints::Misprint;

use crate::bench::Site;
use crate::campaign::{Campaign, Kind, Reading, Readings};
use crate::error::{Fault, Malformed, Result};
use crate::fit::{self, Estimator, Fit, Remount, Settings};
use crate::units::ARCSEC;

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
    /// The rate or run; `None` where all readings are solved together.
    pub group: Option<f64>,
    /// Readings in it.
    pub readings: usize,
    /// By the closed forms; `None` where a position that the formula needs was not read.
    pub closed_form: Vec<Option<f64>>,
    /// By least squares without Earth rate, where the closed forms ignore it: the like-for-like comparison.
    pub like_for_like: Vec<Option<f64>>,
    /// By least squares with the site's Earth rate.
    pub least_squares: Vec<Option<f64>>,
    /// What was printed.
    pub printed: Vec<Option<f64>>,
}

/// Compare a campaign with the closed forms of its bench, by the linear estimator: its square special case is what the formulas are. Where
/// they solve a product of unknowns exactly, by the exact one.
///
/// Errors: no closed forms for this bench, a reading without the column that groups them, or anything that [`fit::fit`] refuses.
pub fn compare(campaign: &Campaign, forms: &ClosedForms, settings: &Settings) -> Result<Comparison> {
    compared(campaign, forms, settings, None)
}

/// The same of a fit. Errors: those of [`compare`].
pub(crate) fn compare_fit(fit: &Fit, forms: &ClosedForms) -> Result<Comparison> {
    compared(&fit.campaign, forms, &fit.settings, Some(fit))
}

fn compared(campaign: &Campaign, forms: &ClosedForms, settings: &Settings, fitted: Option<&Fit>) -> Result<Comparison> {
    let sensor = campaign.bench.sensors.iter().position(|s| s.id == forms.sensor);
    let Some(sensor) = sensor else {
        return Err(Malformed::new(
            Fault::UnknownName,
            format!("the closed forms are for a sensor '{}'", forms.sensor),
        )
        .expected("a bench with this sensor"));
    };
    let estimator = if forms.exact { Estimator::Exact } else { Estimator::Linear };
    let settings = &Settings { estimator, ..*settings };
    let all = match fitted.filter(|fit| fit.settings.estimator == estimator) {
        Some(fit) => fit.clone(),
        None => fit::fit(campaign, settings)?,
    };
    // the formulas know nothing of what scatters beyond the readings, and one group hardly shows its variance
    let alone = &Settings { remount: Remount::No, ..*settings };
    let mut without_earth = campaign.clone();
    without_earth.bench.site = campaign.bench.site.map(|site| Site { earth_rate_deg_h: 0.0, ..site });
    let quantities: Vec<String> = forms.formulas.iter().map(|(id, _)| id.clone()).collect();
    let printed = forms.printed_for(campaign, sensor);
    let mut groups = Vec::new();
    for group in group_values(campaign, forms)? {
        let inside = |row: &&Reading| forms.group.as_ref().is_none_or(|by| by.of(campaign, row) == group);
        let inside: Vec<Reading> = campaign.readings.rows.iter().filter(inside).cloned().collect();
        let readings = inside.len();
        let subset = Readings { columns: campaign.readings.columns.clone(), rows: inside };
        let closed_form = evaluate(campaign, forms, group, &subset)?;
        let by_fit = |campaign: &Campaign| -> Result<Vec<Option<f64>>> {
            let group = Campaign { scatter: Vec::new(), ..campaign.with_readings(subset.clone()) };
            let fit = fit::fit(&group, alone)?;
            Ok(quantities.iter().map(|id| value_of(&fit, id)).collect())
        };
        groups.push(GroupComparison {
            group,
            readings,
            closed_form,
            like_for_like: match forms.earth_rate == EarthRate::Included || campaign.bench.site.is_none() {
                true => vec![None; quantities.len()],
                false => by_fit(&without_earth)?,
            },
            least_squares: by_fit(campaign)?,
            printed: quantities.iter().map(|id| printed.as_ref().and_then(|p| p.of(group?, id))).collect(),
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
        group_title: forms.group.as_ref().map_or("readings".to_string(), |g| g.title.clone()),
        quantities,
        groups,
        mean,
        all,
        printed,
        misprints,
    })
}

/// Factor to the unit in which a person reads a quantity of a fit, and that unit.
pub(crate) fn shown_in(fit: &Fit, id: &str) -> (f64, String) {
    let parameter = fit.parameters.iter().find(|p| p.id == id);
    let angle = parameter.is_some_and(|p| p.kind == Kind::Tilt) || fit.derived.iter().any(|d| d.id == id && d.is_angle);
    if angle { (ARCSEC, "arcsec".into()) } else { (1.0, parameter.map(|p| p.unit.clone()).unwrap_or_default()) }
}

/// The value of a parameter or derived quantity in a fit.
pub(crate) fn value_of(fit: &Fit, id: &str) -> Option<f64> {
    let parameter = fit.parameters.iter().find(|p| p.id == id).and_then(|p| p.value);
    parameter.or_else(|| fit.derived.iter().find(|d| d.id == id).and_then(|d| d.value))
}

/// The groups that the readings fall into, ascending; one without a value where all are solved together.
fn group_values(campaign: &Campaign, forms: &ClosedForms) -> Result<Vec<Option<f64>>> {
    let Some(group) = &forms.group else { return Ok(vec![None]) };
    let mut values = Vec::new();
    for reading in &campaign.readings.rows {
        let Some(value) = group.of(campaign, reading) else {
            return Err(Malformed::new(
                Fault::Missing,
                format!("the closed forms go by {}, and a reading lacks it", group.by),
            )
            .expected(format!("{} in every reading", group.by))
            .at_path(&reading.place));
        };
        if !values.contains(&value) {
            values.push(value);
        }
    }
    values.sort_by(f64::total_cmp);
    Ok(values.into_iter().map(Some).collect())
}
