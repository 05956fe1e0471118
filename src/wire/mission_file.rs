//! The mission file (`*.mission.json`): where and how a strapdown navigator moves, and what is wrong with its unit.

use super::{CovarianceFile, ErrorsFile, MotionFile, Named, Source, parse};
use crate::error::{Fault, Malformed, Result};
use crate::navigate::mission::{Mission, Site};
use crate::navigate::study::FlownTogether;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A mission of a strapdown navigator.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MissionFile {
    /// A person's name for it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub title: String,
    /// Where it starts.
    pub site: MissionSiteFile,
    /// Time between two samples of the unit, s.
    #[serde(default = "hundredth")]
    pub step_s: f64,
    /// Duration, h.
    pub duration_h: f64,
    /// Time between two rows of output, s.
    #[serde(default = "minute")]
    pub output_every_s: f64,
    /// The motion: of the body axes x right, y forward, z up against east, north, up.
    pub motion: MotionFile,
    /// Other motions to compare with it: ratios are theirs over its; plots draw it dashed and these solid.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beside: Vec<MotionFile>,
    /// Errors of the unit, along the body axes x right, y forward, z up.
    #[serde(default)]
    pub errors: ErrorsFile,
    /// Which errors fly together.
    #[serde(default)]
    pub scenarios: FlownTogether,
    /// A calibration whose covariance is carried to navigation errors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<CalibrationFile>,
    /// Seed of all noise and draws.
    #[serde(default = "one")]
    pub seed: u64,
}

/// Where a mission starts.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MissionSiteFile {
    /// Geodetic latitude, degrees, -89 to 89.
    pub latitude_deg: f64,
    /// Longitude, degrees.
    #[serde(default)]
    pub longitude_deg: f64,
    /// Altitude above the ellipsoid, m; the vertical channel is held there.
    #[serde(default)]
    pub altitude_m: f64,
}

/// A calibration whose covariance is carried on.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CalibrationFile {
    /// Path of a fit report (`tumble fit --json`).
    pub report: String,
    /// For each error source, its combination of the report's parameters: source unit per parameter unit.
    pub carry: Named<Named<f64>>,
    /// Draws of the Monte Carlo run in addition to the linear covariance; 0 for none.
    #[serde(default = "draws")]
    pub monte_carlo: u64,
}

fn hundredth() -> f64 {
    0.01
}

fn minute() -> f64 {
    60.0
}

fn one() -> u64 {
    1
}

fn draws() -> u64 {
    200
}

/// Each draw is a navigator of its own: some 2 kB, and a lane of the full simulation.
const MOST_DRAWS: u64 = 100_000;

impl MissionFile {
    /// Check the mission and turn it into the domain's. Errors: [`Malformed`] with the JSON path.
    pub fn mission(&self) -> Result<Mission> {
        let site = Site {
            latitude_rad: self.site.latitude_deg.to_radians(),
            longitude_rad: self.site.longitude_deg.to_radians(),
            altitude_m: self.site.altitude_m,
        };
        let motion = self.motion.motion().map_err(|e| e.under("motion"))?;
        let mut mission = Mission::new(site, self.step_s, self.duration_h * 3600.0, self.output_every_s, motion)?;
        for (i, file) in self.beside.iter().enumerate() {
            mission = mission.beside(file.motion().map_err(|e| e.under(&format!("beside[{i}]")))?)?;
        }
        if let Some(draws) =
            self.calibration.as_ref().map(|calibration| calibration.monte_carlo).filter(|draws| *draws > MOST_DRAWS)
        {
            return Err(Malformed::new(Fault::Value, "the Monte Carlo run has too many draws")
                .at_path("calibration.monte_carlo")
                .expected(format!(
                    "at most {MOST_DRAWS}, each a separate flight (this number gives a standard deviation to 0.2 %)"
                ))
                .found(draws.to_string()));
        }
        mission.errors = self.errors.errors().map_err(|e| e.under("errors"))?;
        mission.title = self.title.clone();
        mission.seed = self.seed;
        Ok(mission)
    }
}

impl CalibrationFile {
    /// What each error source is made of.
    pub(crate) fn factors(&self) -> Vec<(String, Vec<(String, f64)>)> {
        self.carry.0.iter().map(|(id, parts)| (id.clone(), parts.0.clone())).collect()
    }
}

/// The covariance in a fit report. Errors: no JSON, or a report without `covariance`.
pub fn read_covariance(source: &Source) -> Result<CovarianceFile> {
    #[derive(Deserialize)]
    struct Report {
        covariance: Option<CovarianceFile>,
    }
    let report: Report = parse(source)?;
    report.covariance.ok_or_else(|| {
        Malformed::new(Fault::Missing, "the report has no covariance")
            .at_path("covariance")
            .expected("the JSON report of a fit with \"covariance\": { \"order\": ..., \"matrix\": ... }")
            .in_file(&source.name)
    })
}
