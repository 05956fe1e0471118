//! The level that a single column must pass in a diagnosis, before anyone has measured.
//!
//! Nothing is counted here: readings are pretended, with the noise of the plan and no pattern, and the tests are those that a diagnosis of them
//! makes.

use super::catalogue::Effect;
use super::pass::Pass;
use super::{Settings, assumptions, fit_exactly};
use crate::campaign::{Campaign, Observation, Reading, Readings};
use crate::design::{self, Model};
use crate::elements::Elements;
use crate::error::Result;
use std::collections::HashMap;

/// At which level each column's own test is made.
#[derive(Debug, Clone)]
pub(super) struct SingleLevels {
    /// Distinct directions that are tested together.
    pub tests: usize,
    /// Level of one of so many tests.
    pub usual: f64,
    of: HashMap<(String, Option<usize>), f64>,
}

impl SingleLevels {
    /// The level of a regressor of a sensor (`None` for what is common to all).
    pub fn of(&self, regressor: &str, sensor: Option<usize>) -> f64 {
        // those without a level of their own
        self.of.get(&(regressor.to_string(), sensor)).copied().unwrap_or(self.usual)
    }
}

/// The levels of a diagnosis at this significance, of readings at these rows and with these standard uncertainties of
/// the rows' own noise.
///
/// Errors: those of [`super::diagnose`].
pub(super) fn single_levels(
    schedule: &Campaign,
    catalogue: &[Effect],
    u: &[f64],
    significance: f64,
) -> Result<SingleLevels> {
    let measured = pretended(schedule, u)?;
    let assumed = assumptions::hold(&measured)?;
    let fit = fit_exactly(&assumed.campaign)?;
    let levels = Settings::at(significance);
    let mut pass = Pass::new(&assumed.campaign, &assumed.asked, catalogue, levels, fit.design.point.clone())?;
    let (tests, of) = pass.tests()?;
    let usual = alone(levels.names(), tests as f64);
    let of = of.into_iter().map(|(name, sensor, tests)| ((name, sensor), alone(levels.names(), tests))).collect();
    Ok(SingleLevels { tests, usual, of })
}

/// The level at which each of so many tests is made (Sidak).
fn alone(level: f64, tests: f64) -> f64 {
    -f64::exp_m1(f64::ln_1p(-level) / tests.max(1.0))
}

/// The schedule with values about the reference point that follow no pattern.
fn pretended(schedule: &Campaign, u: &[f64]) -> Result<Campaign> {
    let plain = Campaign { scatter: Vec::new(), ..schedule.clone() };
    let design = design::assemble(&plain, &Model::new(&plain)?, &plain.reference_point())?;
    let mut rows: Vec<Reading> = plain.readings.rows.iter().map(Reading::unread).collect();
    for (i, (origin, predicted)) in design.rows.iter().zip(&design.predicted).enumerate() {
        let u = u.at(i);
        // angles that never repeat, twice: near enough to normal, and no sequence of positions has it
        let x = i as f64 + 1.0;
        let off = (2.4 * x * x.sqrt()).sin() + (1.7 * x * x).cos();
        let value = predicted + u * off;
        if let Some(row) = rows.get_mut(origin.reading) {
            row.observations.push(Observation { sensor: origin.sensor, value, u: Some(u), samples: 1.0 });
        }
    }
    Ok(plain.with_readings(Readings { columns: plain.readings.columns.clone(), rows }))
}
