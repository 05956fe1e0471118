//! Why each mounting is in a schedule.

use super::effort::Noise;
use super::whitened::{Beside, adjusted, with_priors};
use crate::campaign::{Campaign, Readings};
use crate::error::Result;

/// Why a mounting is in a schedule: what would be lost without it.
#[derive(Debug, Clone, PartialEq)]
pub struct Reason {
    /// Its label.
    pub position: String,
    /// The estimated parameter (by index) that would lose most.
    pub parameter: usize,
    /// By what factor its uncertainty would grow; `None` where it would not be determined.
    pub grows: Option<f64>,
}

/// With more mountings or readings than this, reasons are not looked for.
const MOST_REASONS: usize = 100;
const MOST_READINGS: usize = 2000;

/// Every mounting after the first `kept` readings, left out in turn.
pub(super) fn reasons(schedule: &Campaign, noise: &Noise, kept: usize) -> Result<Vec<Reason>> {
    let rows = &schedule.readings.rows;
    let mut labels: Vec<&str> = Vec::new();
    for row in rows.iter().skip(kept) {
        if !labels.contains(&row.position.as_str()) {
            labels.push(&row.position);
        }
    }
    if labels.len() > MOST_REASONS || rows.len() > MOST_READINGS {
        return Ok(Vec::new());
    }
    let n = schedule.unknowns();
    let u = |readings: &Readings| -> Result<Vec<Option<f64>>> {
        let beside = Beside::new(schedule, noise, &[], &[readings]);
        let rows = with_priors(schedule, readings, noise, &beside)?;
        let estimate = adjusted(schedule, &rows, beside.columns(schedule))?;
        let known = |k: usize| estimate.unknowns.is_estimable(k);
        Ok((0..n).map(|k| known(k).then(|| estimate.unknowns.covariance[(k, k)].sqrt())).collect())
    };
    let with = u(&schedule.readings)?;
    let mut reasons = Vec::with_capacity(labels.len());
    for label in labels {
        let left =
            rows.iter().enumerate().filter(|(k, row)| *k < kept || row.position != label).map(|(_, row)| row.clone());
        let left = Readings { columns: schedule.readings.columns.clone(), rows: left.collect() };
        let without = if left.rows.is_empty() { vec![None; n] } else { u(&left)? };
        let growth = |k: usize| match (with.get(k).copied().flatten(), without.get(k).copied().flatten()) {
            (Some(with), Some(without)) if with > 0.0 => without / with,
            (Some(_), None) => f64::INFINITY,
            _ => 1.0,
        };
        let most = (0..n).max_by(|a, b| growth(*a).total_cmp(&growth(*b)).then(b.cmp(a)));
        if let Some(parameter) = most {
            let grows = Some(growth(parameter)).filter(|g| g.is_finite());
            reasons.push(Reason { position: label.to_string(), parameter, grows });
        }
    }
    Ok(reasons)
}
