//! The motions of a mission file: at rest, swinging, in legs.

use super::imu_errors_file::is_default;
use crate::error::{Fault, Malformed, Result};
use crate::navigate::motion::{Attitude, Leg, Legs, Motion, Oscillation, Path};
use schemars::JsonSchema;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A motion of the vehicle: one of these. The body axes are x right, y forward, z up; pitch is about x, roll about y, and the heading is counted clockwise from
/// north to y.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum MotionFile {
    /// At rest.
    Static(StaticFile),
    /// Swinging about a fixed place.
    Swing(SwingFile),
    /// Legs along a heading, with turns and a swing where they are given.
    Legs(LegsFile),
}

impl<'de> Deserialize<'de> for MotionFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        struct OneOf;
        impl<'de> Visitor<'de> for OneOf {
            type Value = MotionFile;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a motion, for example { \"static\": {} }")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<MotionFile, A::Error> {
                const KINDS: &[&str] = &["static", "swing", "legs"];
                let mut found: Option<(String, MotionFile)> = None;
                while let Some(kind) = map.next_key::<String>()? {
                    if let Some((first, _)) = &found {
                        return Err(A::Error::custom(format!(
                            "a motion of two kinds, '{first}' and '{kind}', expected one of static, swing and legs (legs \
                             with a swing under way have a key 'swing' inside)"
                        )));
                    }
                    let motion = match kind.as_str() {
                        "static" => MotionFile::Static(map.next_value()?),
                        "swing" => MotionFile::Swing(map.next_value()?),
                        "legs" => MotionFile::Legs(map.next_value()?),
                        other => return Err(A::Error::unknown_variant(other, KINDS)),
                    };
                    found = Some((kind, motion));
                }
                let missing = "a motion of no kind, expected one of static, swing and legs";
                found.map(|(_, motion)| motion).ok_or_else(|| A::Error::custom(missing))
            }
        }
        deserializer.deserialize_map(OneOf)
    }
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
    /// Clockwise, as every heading: from north, under way from the course.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heading: Option<OscillationFile>,
    /// The same counter-clockwise, instead of `heading`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw: Option<OscillationFile>,
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

/// Legs along a heading, which turns only where a leg says so.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LegsFile {
    /// At the start, clockwise from north, degrees.
    #[serde(default)]
    pub heading_deg: f64,
    /// Speed at the start, m/s.
    #[serde(default)]
    pub speed_m_s: f64,
    /// One leg after another.
    pub legs: Vec<LegFile>,
    /// A swing under way, about the course.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub swing: Option<SwingFile>,
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
    /// Rate of the heading, deg/s clockwise: a flat turn, without bank.
    #[serde(default, skip_serializing_if = "is_default")]
    pub turn_deg_s: f64,
}

impl MotionFile {
    /// The file of a motion.
    pub fn of(motion: &Motion) -> MotionFile {
        let Attitude { pitch, roll, yaw } = motion.attitude;
        if let Path::Legs(of) = &motion.path {
            let legs = of.legs.iter().map(|leg| LegFile {
                duration_h: None,
                duration_s: Some(leg.duration).filter(|duration| duration.is_finite()),
                acceleration_m_s2: leg.acceleration,
                turn_deg_s: degrees(leg.turn),
            });
            let legs = legs.collect();
            let level = Motion::legs(of.clone()).attitude;
            let about_course = Oscillation { mean: yaw.mean + of.heading, ..yaw };
            let swing = (motion.attitude != level).then(|| SwingFile::of(pitch, roll, about_course));
            return MotionFile::Legs(LegsFile { heading_deg: degrees(of.heading), speed_m_s: of.speed, legs, swing });
        }
        if [pitch, roll, yaw].iter().all(|angle| angle.amplitude == 0.0) {
            let [pitch_deg, roll_deg, heading_deg] = [pitch.mean, roll.mean, -yaw.mean].map(degrees);
            return MotionFile::Static(StaticFile { pitch_deg, roll_deg, heading_deg });
        }
        MotionFile::Swing(SwingFile::of(pitch, roll, yaw))
    }

    /// The motion in one line.
    pub(crate) fn in_words(&self) -> String {
        match self {
            MotionFile::Static(still) => {
                let mut text = format!("static, heading {} deg", still.heading_deg);
                for (name, angle) in [("pitch", still.pitch_deg), ("roll", still.roll_deg)] {
                    if angle != 0.0 {
                        text.push_str(&format!(", {name} {angle} deg"));
                    }
                }
                text
            }
            MotionFile::Swing(swing) => format!("swing, {}", swing.in_words()),
            MotionFile::Legs(of) => {
                let leg = |leg: &LegFile| {
                    let time = leg.duration_s.or(leg.duration_h.map(|hours| 3600.0 * hours));
                    let time = time.map_or("then".to_string(), |seconds| format!("{seconds} s"));
                    let turn = match leg.turn_deg_s {
                        0.0 => String::new(),
                        rate => format!(", turning {rate} deg/s"),
                    };
                    format!("{time} at {} m/s^2{turn}", leg.acceleration_m_s2)
                };
                let legs: Vec<String> = of.legs.iter().map(leg).collect();
                let swing = of.swing.as_ref().map_or(String::new(), |swing| format!("; swing {}", swing.in_words()));
                format!("legs, heading {} deg: {}{swing}", of.heading_deg, legs.join(", "))
            }
        }
    }

    pub(super) fn motion(&self) -> Result<Motion> {
        match self {
            MotionFile::Static(file) => {
                let angles = [file.pitch_deg, file.roll_deg];
                if let Some(bad) = angles.iter().find(|angle| !angle.is_finite() || angle.abs() > 360.0) {
                    return Err(Malformed::new(Fault::Value, "not an attitude")
                        .at_path("static")
                        .expected("angles from -360 to 360 degrees")
                        .found(format!("{bad}")));
                }
                let [pitch, roll] = angles.map(f64::to_radians);
                Ok(Motion::at_rest(pitch, roll, -course(file.heading_deg).map_err(|e| e.under("static"))?))
            }
            MotionFile::Swing(file) => Motion::swing(file.attitude()?),
            MotionFile::Legs(file) => {
                let legs = file.legs.iter().enumerate().map(|(i, leg)| leg.leg(i)).collect::<Result<Vec<Leg>>>()?;
                let heading = course(file.heading_deg).map_err(|e| e.under("legs"))?;
                let legs = Legs { heading, speed: file.speed_m_s, legs };
                match &file.swing {
                    Some(swing) => {
                        let attitude = swing.attitude().map_err(|e| e.under("legs"))?;
                        Motion::swinging_legs(legs, attitude).map_err(|e| e.under("legs"))
                    }
                    None => Ok(Motion::legs(legs)),
                }
            }
        }
    }
}

/// Angles as people write them: what radians cost in the last digits is rounded off.
fn degrees(rad: f64) -> f64 {
    (rad.to_degrees() * 1e9).round() / 1e9 + 0.0
}

/// A heading in degrees as one within a turn, rad.
fn course(heading_deg: f64) -> Result<f64> {
    if !heading_deg.is_finite() {
        return Err(Malformed::new(Fault::Value, "not a heading")
            .at_path("heading_deg")
            .expected("a finite number of degrees, clockwise from north")
            .found(heading_deg.to_string()));
    }
    let within = heading_deg % 360.0;
    Ok(if within == heading_deg || within.abs() <= 180.0 { within } else { within - 360.0_f64.copysign(within) }
        .to_radians())
}

impl SwingFile {
    fn of(pitch: Oscillation, roll: Oscillation, yaw: Oscillation) -> SwingFile {
        // only what swings is said, and that has a period: `oscillation` asks for it
        let angle = |oscillation: Oscillation| OscillationFile {
            amplitude_deg: degrees(oscillation.amplitude),
            period_s: (oscillation.amplitude != 0.0).then_some(oscillation.period),
            phase_deg: degrees(oscillation.phase),
            mean_deg: degrees(oscillation.mean),
        };
        // clockwise is the other way round; an amplitude is written as a positive number, half a period later
        let mut heading = angle(Oscillation { mean: -yaw.mean, amplitude: -yaw.amplitude, ..yaw });
        if heading.amplitude_deg < 0.0 {
            heading.amplitude_deg = -heading.amplitude_deg;
            heading.phase_deg += if heading.phase_deg > 0.0 { -180.0 } else { 180.0 };
        }
        SwingFile { pitch: angle(pitch), roll: angle(roll), heading: Some(heading), yaw: None }
    }

    fn attitude(&self) -> Result<Attitude> {
        let yaw = match (&self.heading, &self.yaw) {
            (Some(_), Some(_)) => {
                return Err(Malformed::new(Fault::NameClash, "the swing has a heading and a yaw")
                    .at_path("swing.yaw")
                    .expected("'heading' (clockwise) or 'yaw' (counter-clockwise)"));
            }
            (Some(heading), None) => {
                let heading = heading.oscillation("heading")?;
                Oscillation { mean: -heading.mean, amplitude: -heading.amplitude, ..heading }
            }
            (None, yaw) => yaw.clone().unwrap_or_default().oscillation("yaw")?,
        };
        Ok(Attitude { pitch: self.pitch.oscillation("pitch")?, roll: self.roll.oscillation("roll")?, yaw })
    }

    fn in_words(&self) -> String {
        let still = OscillationFile::default();
        let angle = |o: &OscillationFile| format!("{} deg in {} s", o.amplitude_deg, o.period_s.unwrap_or_default());
        let angles = [
            ("pitch", &self.pitch),
            ("roll", &self.roll),
            ("heading", self.heading.as_ref().unwrap_or(&still)),
            ("yaw", self.yaw.as_ref().unwrap_or(&still)),
        ];
        let moving = angles.iter().filter(|(_, angle)| angle.amplitude_deg != 0.0);
        let parts: Vec<String> = moving.map(|(name, oscillation)| format!("{name} {}", angle(oscillation))).collect();
        parts.join(", ")
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
        Ok(Leg { duration, acceleration: self.acceleration_m_s2, turn: self.turn_deg_s.to_radians() })
    }
}
