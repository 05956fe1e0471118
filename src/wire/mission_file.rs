//! The mission file (`*.mission.json`): where and how a strapdown navigator moves, and what is wrong with its unit.

use super::{ErrorsFile, Named, Source, parse};
use crate::error::{Fault, Malformed, Result};
use crate::navigate::mission::{Mission, Site};
use crate::navigate::motion::{Attitude, Leg, Legs, Motion, Oscillation, Path};
use crate::navigate::study::Separation;
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
    /// The motion.
    pub motion: MotionFile,
    /// Other motions to compare with it: ratios are theirs over its; plots draw it dashed and these solid.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beside: Vec<MotionFile>,
    /// Errors of the unit.
    #[serde(default)]
    pub errors: ErrorsFile,
    /// Which errors fly together.
    #[serde(default)]
    pub scenarios: ScenariosFile,
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

/// A motion of the vehicle.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum MotionFile {
    /// At rest.
    Static(StaticFile),
    /// Swinging about a fixed place.
    Swing(SwingFile),
    /// Legs along a constant heading.
    Legs(LegsFile),
}

/// Attitude at rest.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StaticFile {
    /// Nose up, degrees.
    #[serde(default)]
    pub pitch_deg: f64,
    /// Right side down, degrees.
    #[serde(default)]
    pub roll_deg: f64,
    /// Clockwise from north, degrees.
    #[serde(default)]
    pub heading_deg: f64,
}

/// A swing: `mean + amplitude sin(2 pi t / period + phase)` in each angle.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SwingFile {
    /// Nose up.
    #[serde(default)]
    pub pitch: OscillationFile,
    /// Right side down.
    #[serde(default)]
    pub roll: OscillationFile,
    /// Counter-clockwise from north.
    #[serde(default)]
    pub yaw: OscillationFile,
}

/// One angle of a swing.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OscillationFile {
    /// Amplitude, degrees.
    #[serde(default)]
    pub amplitude_deg: f64,
    /// Period, s; needed where there is an amplitude.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period_s: Option<f64>,
    /// Phase at the start, degrees.
    #[serde(default)]
    pub phase_deg: f64,
    /// Mean, degrees.
    #[serde(default)]
    pub mean_deg: f64,
}

/// Legs along a constant heading.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LegsFile {
    /// Clockwise from north, degrees.
    #[serde(default)]
    pub heading_deg: f64,
    /// Speed at the start, m/s.
    #[serde(default)]
    pub speed_m_s: f64,
    /// One leg after another.
    pub legs: Vec<LegFile>,
}

/// One leg; the last may have no duration and ends with the mission.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LegFile {
    /// Duration, h.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duration_h: Option<f64>,
    /// Duration, s, instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duration_s: Option<f64>,
    /// Acceleration along the heading, m/s^2; 0 cruises (or rests).
    #[serde(default)]
    pub acceleration_m_s2: f64,
}

/// Which errors fly together.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ScenariosFile {
    /// All together in one scenario.
    Together,
    /// All together, and each group (gyro bias, gyro scale factor, ...) alone.
    #[default]
    Groups,
    /// All together, each group, and each single error alone.
    Components,
}

/// A calibration whose covariance is carried on.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CalibrationFile {
    /// Path of a fit report (`tumble fit --json`).
    pub report: String,
    /// For each error source, its combination of the report's parameters: source unit per parameter unit.
    pub carry: Named<Named<f64>>,
    /// Draws of the Monte Carlo run beside the linear covariance; 0 for none.
    #[serde(default = "draws")]
    pub monte_carlo: usize,
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

fn draws() -> usize {
    200
}

impl MissionFile {
    /// Check the mission and turn it into the domain's. Errors: [`Malformed`] with the JSON path.
    pub fn mission(&self) -> Result<Mission> {
        let site = Site {
            latitude: self.site.latitude_deg.to_radians(),
            longitude: self.site.longitude_deg.to_radians(),
            altitude: self.site.altitude_m,
        };
        let motion = self.motion.motion().map_err(|e| e.under("motion"))?;
        let mut mission = Mission::new(site, self.step_s, self.duration_h * 3600.0, self.output_every_s, motion)?;
        for (i, file) in self.beside.iter().enumerate() {
            mission = mission.beside(file.motion().map_err(|e| e.under(&format!("beside[{i}]")))?)?;
        }
        mission.errors = self.errors.errors().map_err(|e| e.under("errors"))?;
        mission.title = self.title.clone();
        mission.seed = self.seed;
        Ok(mission)
    }
}

impl ScenariosFile {
    /// The domain's word for it.
    pub fn separation(self) -> Separation {
        match self {
            ScenariosFile::Together => Separation::Together,
            ScenariosFile::Groups => Separation::Groups,
            ScenariosFile::Components => Separation::Components,
        }
    }
}

impl CalibrationFile {
    /// What each error source is made of.
    pub fn factors(&self) -> Vec<(String, Vec<(String, f64)>)> {
        self.carry.0.iter().map(|(id, parts)| (id.clone(), parts.0.clone())).collect()
    }
}

/// The part of a fit report that is carried on; its other keys are left alone.
#[derive(Debug, Clone, Deserialize)]
pub struct CovarianceFile {
    /// Names of the rows and columns.
    pub order: Vec<String>,
    /// The matrix, row by row; null for what is not estimable.
    pub matrix: Vec<Vec<Option<f64>>>,
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
            .expected("a fit report (tumble fit --json) with \"covariance\": { \"order\": ..., \"matrix\": ... }")
            .in_file(&source.name)
    })
}

impl MotionFile {
    /// The file of a motion.
    pub fn of(motion: &Motion) -> MotionFile {
        // angles as people write them: what radians cost in the last digits is rounded off
        let degrees = |rad: f64| (rad.to_degrees() * 1e9).round() / 1e9 + 0.0;
        let Attitude { pitch, roll, yaw } = motion.attitude;
        if let Path::Legs(own) = &motion.path {
            let legs = own.legs.iter().map(|leg| LegFile {
                duration_h: None,
                duration_s: Some(leg.duration).filter(|duration| duration.is_finite()),
                acceleration_m_s2: leg.acceleration,
            });
            let legs = legs.collect();
            return MotionFile::Legs(LegsFile { heading_deg: degrees(own.heading), speed_m_s: own.speed, legs });
        }
        if [pitch, roll, yaw].iter().all(|angle| angle.amplitude == 0.0) {
            let [pitch_deg, roll_deg, heading_deg] = [pitch.mean, roll.mean, -yaw.mean].map(degrees);
            return MotionFile::Static(StaticFile { pitch_deg, roll_deg, heading_deg });
        }
        let angle = |own: Oscillation| OscillationFile {
            amplitude_deg: degrees(own.amplitude),
            period_s: (own.amplitude != 0.0).then_some(own.period),
            phase_deg: degrees(own.phase),
            mean_deg: degrees(own.mean),
        };
        MotionFile::Swing(SwingFile { pitch: angle(pitch), roll: angle(roll), yaw: angle(yaw) })
    }

    /// The motion in one line.
    pub fn in_words(&self) -> String {
        match self {
            MotionFile::Static(own) => {
                let mut text = format!("static, heading {} deg", own.heading_deg);
                for (name, angle) in [("pitch", own.pitch_deg), ("roll", own.roll_deg)] {
                    if angle != 0.0 {
                        text.push_str(&format!(", {name} {angle} deg"));
                    }
                }
                text
            }
            MotionFile::Swing(own) => {
                let angle = |own: &OscillationFile| {
                    format!("{} deg in {} s", own.amplitude_deg, own.period_s.unwrap_or_default())
                };
                let angles = [("pitch", &own.pitch), ("roll", &own.roll), ("yaw", &own.yaw)];
                let moving = angles.iter().filter(|(_, angle)| angle.amplitude_deg != 0.0);
                let parts: Vec<String> = moving.map(|(name, own)| format!("{name} {}", angle(own))).collect();
                format!("swing, {}", parts.join(", "))
            }
            MotionFile::Legs(own) => {
                let leg = |leg: &LegFile| {
                    let time = leg.duration_s.or(leg.duration_h.map(|hours| 3600.0 * hours));
                    let time = time.map_or("then".to_string(), |seconds| format!("{seconds} s"));
                    format!("{time} at {} m/s^2", leg.acceleration_m_s2)
                };
                let legs: Vec<String> = own.legs.iter().map(leg).collect();
                format!("legs, heading {} deg: {}", own.heading_deg, legs.join(", "))
            }
        }
    }

    fn motion(&self) -> Result<Motion> {
        match self {
            MotionFile::Static(file) => {
                let angles = [file.pitch_deg, file.roll_deg, file.heading_deg];
                if let Some(bad) = angles.iter().find(|angle| !angle.is_finite() || angle.abs() > 360.0) {
                    return Err(Malformed::new(Fault::Value, "not an attitude")
                        .at_path("static")
                        .expected("angles from -360 to 360 degrees")
                        .found(format!("{bad}")));
                }
                let [pitch, roll, heading] = angles.map(f64::to_radians);
                Ok(Motion::at_rest(pitch, roll, -heading))
            }
            MotionFile::Swing(file) => Motion::swing(Attitude {
                pitch: file.pitch.oscillation("pitch")?,
                roll: file.roll.oscillation("roll")?,
                yaw: file.yaw.oscillation("yaw")?,
            }),
            MotionFile::Legs(file) => {
                let legs = file.legs.iter().enumerate().map(|(i, leg)| leg.leg(i)).collect::<Result<Vec<Leg>>>()?;
                Ok(Motion::legs(Legs { heading: file.heading_deg.to_radians(), speed: file.speed_m_s, legs }))
            }
        }
    }
}

impl OscillationFile {
    fn oscillation(&self, name: &str) -> Result<Oscillation> {
        let period = match self.period_s {
            Some(period) => period,
            None if self.amplitude_deg == 0.0 => 1.0,
            None => {
                return Err(Malformed::new(Fault::Missing, format!("the swing in {name} has no period"))
                    .at_path(format!("swing.{name}"))
                    .expected("a key 'period_s'"));
            }
        };
        Ok(Oscillation {
            mean: self.mean_deg.to_radians(),
            amplitude: self.amplitude_deg.to_radians(),
            period,
            phase: self.phase_deg.to_radians(),
        })
    }
}

impl LegFile {
    fn leg(&self, index: usize) -> Result<Leg> {
        let duration = match (self.duration_h, self.duration_s) {
            (Some(_), Some(_)) => {
                return Err(Malformed::new(Fault::NameClash, "the leg has two durations")
                    .at_path(format!("legs.legs[{index}]"))
                    .expected("either 'duration_h' or 'duration_s'"));
            }
            (Some(hours), None) => hours * 3600.0,
            (None, Some(seconds)) => seconds,
            (None, None) => f64::INFINITY,
        };
        Ok(Leg { duration, acceleration: self.acceleration_m_s2 })
    }
}
