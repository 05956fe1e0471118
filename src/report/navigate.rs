//! The navigation report (`tumble navigate --json`).

use super::{ARCSEC, VERSION, finite};
use crate::language::{Language, say};
use crate::navigate::earth::EARTH_RATE;
use crate::navigate::errors::{ErrorSource, ImuErrors};
use crate::navigate::linear;
use crate::navigate::mission::Mission;
use crate::navigate::propagation::NavigationUncertainty;
use crate::navigate::run::{NavigationError, Scenario, Summary};
use crate::navigate::study::{self, Flown, PropagatedCalibration};
use crate::report::ReportKind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// What `tumble navigate --json` writes. Numbers of a navigator that ran over a pole are null.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct NavigateReport {
    /// Version of the program that wrote it.
    pub tumble: String,
    /// Always `navigate`.
    #[schemars(extend("const" = "navigate"))]
    pub report: ReportKind,
    /// The mission's title.
    pub title: String,
    /// Duration, h.
    pub duration_h: f64,
    /// Step, s.
    pub step_s: f64,
    /// What the attitude errors are.
    pub convention: String,
    /// What is held and not navigated.
    pub vertical_channel: String,
    /// Motions beyond what the navigator's step resolves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// The periods of the error equations at rest; null where their eigenvalues cannot be found.
    pub periods: Option<PeriodsReport>,
    /// The scenarios' errors, in the unit of each.
    pub scenarios: Vec<ScenarioReport>,
    /// Each scenario in each motion.
    pub results: Vec<ResultReport>,
    /// Root mean square errors of each motion over those of the first one.
    pub ratios: Vec<RatioReport>,
    /// A calibration's covariance, carried to navigation errors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub carried: Vec<CarriedReport>,
}

/// Periods of the error equations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct PeriodsReport {
    /// Schuler's oscillation, min.
    pub schuler_min: f64,
    /// The Earth's rotation, h.
    pub earth_h: f64,
    /// The Foucault rotation of Schuler's oscillation, `2 pi / (W sin L)`, h; null at the equator, where there is none.
    pub foucault_h: Option<f64>,
}

impl PeriodsReport {
    /// In one line.
    pub(super) fn in_words(&self, lang: Language) -> String {
        let foucault =
            self.foucault_h.map_or(say!(lang, "none-at-the-equator").to_string(), |hours| format!("{hours:.2} h"));
        let [schuler, earth] = [format!("{:.2}", self.schuler_min), format!("{:.3}", self.earth_h)];
        say!(lang, "schuler-earth-foucault", schuler, earth, foucault)
    }
}

/// A scenario.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ScenarioReport {
    /// Its name.
    pub id: String,
    /// What is not zero.
    pub errors: BTreeMap<String, QuantityWithUnit>,
}

/// A value with its unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct QuantityWithUnit {
    /// Value, in `unit`.
    pub value: f64,
    /// Unit.
    pub unit: String,
}

/// One scenario in one motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ResultReport {
    /// The motion.
    pub motion: String,
    /// The scenario.
    pub scenario: String,
    /// Time of the last row, h.
    pub time_h: f64,
    /// Tilt, arcsec.
    pub tilt_arcsec: SummaryReport,
    /// Azimuth error, arcsec.
    pub azimuth_arcsec: SummaryReport,
    /// Horizontal velocity error, m/s.
    pub velocity_m_s: SummaryReport,
    /// Horizontal position error, m.
    pub position_m: SummaryReport,
    /// The last row.
    pub last: ErrorReport,
}

/// A quantity over all rows of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct SummaryReport {
    /// At the last row, in the unit of its key.
    pub last: Option<f64>,
    /// Largest, in the unit of its key.
    pub max: Option<f64>,
    /// Root mean square, in the unit of its key.
    pub rms: Option<f64>,
}

/// A navigation error, or the standard uncertainty of one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct ErrorReport {
    /// `phi` about east, north, up, arcsec.
    pub phi_arcsec: [Option<f64>; 3],
    /// East, north, m/s.
    pub velocity_m_s: [Option<f64>; 2],
    /// East, north, m.
    pub position_m: [Option<f64>; 2],
}

/// Ratios of one scenario; null where the first motion has no such error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct RatioReport {
    /// The scenario.
    pub scenario: String,
    /// The motion compared.
    pub motion: String,
    /// The motion that it is compared with.
    pub against: String,
    /// Tilt, a ratio.
    pub tilt: Option<f64>,
    /// Azimuth, a ratio.
    pub azimuth: Option<f64>,
    /// Velocity, a ratio.
    pub velocity: Option<f64>,
    /// Position, a ratio.
    pub position: Option<f64>,
}

/// A covariance carried along one motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct CarriedReport {
    /// The motion.
    pub motion: String,
    /// Standard uncertainties at the last row, linear covariance.
    pub linear: Option<ErrorReport>,
    /// Draws of the Monte Carlo run.
    pub draws: usize,
    /// Standard deviation of the draws about zero at the last row.
    pub monte_carlo: Option<ErrorReport>,
    /// Times, h.
    pub time_h: Vec<f64>,
    /// Standard uncertainty of position (east and north together), m, at these times.
    pub position_u_m: Vec<f64>,
}

/// The report of a study.
pub fn navigate_report(
    mission: &Mission,
    scenarios: &[Scenario],
    flown: &[Flown],
    carried: &[PropagatedCalibration],
) -> NavigateReport {
    let against = flown.first().map(|f| f.motion.clone()).unwrap_or_default();
    NavigateReport {
        tumble: VERSION.into(),
        report: ReportKind::Navigate,
        title: mission.title.clone(),
        duration_h: mission.duration() / 3600.0,
        step_s: mission.step_s,
        convention: "phi angle: C' = (I - phi x) C, C from body to east-north-up; errors are computed minus true"
            .into(),
        vertical_channel: "held at the site's altitude, no vertical velocity".into(),
        warnings: study::unresolved(mission, flown).iter().map(|own| warning(mission, own)).collect(),
        periods: linear::frequencies(mission.site).map(|[earth, slow, fast]| PeriodsReport {
            schuler_min: TAU / (0.5 * (slow + fast)) / 60.0,
            earth_h: TAU / earth / 3600.0,
            foucault_h: Some(TAU / (EARTH_RATE * mission.site.latitude_rad.sin().abs()) / 3600.0).filter(|h| *h < 1e4),
        }),
        scenarios: scenarios.iter().map(scenario).collect(),
        results: flown.iter().flat_map(results).collect(),
        ratios: study::ratios(mission, flown)
            .into_iter()
            .map(|r| RatioReport {
                scenario: r.scenario,
                motion: r.motion,
                against: against.clone(),
                tilt: r.tilt,
                azimuth: r.azimuth,
                velocity: r.velocity,
                position: r.position,
            })
            .collect(),
        carried: carried.iter().map(propagated).collect(),
    }
}

fn warning(mission: &Mission, own: &study::Unresolved) -> String {
    let [tilt, azimuth, velocity, position] = own.own;
    let digits = |value: f64| crate::document::number::significant(value, 3);
    let mut text = format!(
        "in {} a perfect unit is wrong by {} arcsec of tilt, {} arcsec of azimuth, {} m/s and {} m: the error of the navigator",
        own.motion,
        digits(tilt * ARCSEC),
        digits(azimuth * ARCSEC),
        digits(velocity),
        digits(position)
    );
    if own.period.is_finite() {
        text.push_str(&format!(
            "; its step of {} s does not resolve a motion of {} s (a step of {} s would)",
            mission.step_s,
            own.period,
            digits(own.period / 25.0)
        ));
    }
    text
}

fn scenario(scenario: &Scenario) -> ScenarioReport {
    ScenarioReport { id: scenario.id.clone(), errors: error_quantities(&scenario.errors) }
}

/// What is not zero of a set of errors.
pub(super) fn error_quantities(own: &ImuErrors) -> BTreeMap<String, QuantityWithUnit> {
    let value = |value: f64, unit: &str| QuantityWithUnit { value, unit: unit.into() };
    let mut errors: BTreeMap<String, QuantityWithUnit> =
        own.present().iter().map(|s: &ErrorSource| (s.id(), value(s.of(own) / s.si_per_unit(), s.unit()))).collect();
    if own.gyro.random_walk > 0.0 {
        let walk = own.gyro.random_walk.to_degrees() * 60.0;
        errors.insert("angle_random_walk".into(), value(walk, "deg/sqrt(h)"));
    }
    if own.accelerometer.random_walk > 0.0 {
        let walk = own.accelerometer.random_walk * 60.0;
        errors.insert("velocity_random_walk".into(), value(walk, "(m/s)/sqrt(h)"));
    }
    errors
}

fn results(flown: &Flown) -> impl Iterator<Item = ResultReport> {
    flown.flight.outcomes.iter().map(|outcome| ResultReport {
        motion: flown.motion.clone(),
        scenario: outcome.id.clone(),
        time_h: flown.flight.time / 3600.0,
        tilt_arcsec: summary(&outcome.tilt, ARCSEC),
        azimuth_arcsec: summary(&outcome.azimuth, ARCSEC),
        velocity_m_s: summary(&outcome.velocity, 1.0),
        position_m: summary(&outcome.position, 1.0),
        last: error(&outcome.last),
    })
}

fn propagated(carried: &PropagatedCalibration) -> CarriedReport {
    CarriedReport {
        motion: carried.motion.clone(),
        linear: carried.linear.last().map(uncertainty),
        draws: carried.draws,
        monte_carlo: carried.monte_carlo.as_ref().map(uncertainty),
        time_h: carried.times.iter().map(|time| time / 3600.0).collect(),
        position_u_m: carried.linear.iter().map(|u| u.position[0].hypot(u.position[1])).collect(),
    }
}

fn summary(summary: &Summary, unit: f64) -> SummaryReport {
    SummaryReport {
        last: finite(summary.last * unit),
        max: finite(summary.max * unit),
        rms: finite(summary.rms * unit),
    }
}

fn error(error: &NavigationError) -> ErrorReport {
    ErrorReport {
        phi_arcsec: error.attitude.map(|phi| finite(phi * ARCSEC)),
        velocity_m_s: error.velocity.map(finite),
        position_m: error.position.map(finite),
    }
}

fn uncertainty(u: &NavigationUncertainty) -> ErrorReport {
    error(&NavigationError { attitude: u.attitude, velocity: u.velocity, position: u.position })
}
