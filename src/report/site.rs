//! The site as reports say it: latitude, Earth rate, gravity and where it comes from; a warning where gravity matters and was not said.

use crate::bench::{Bench, ForceUnit, GravityFrom, NORMAL_GRAVITY_FORMULA, STANDARD_GRAVITY_M_S2};
use crate::language::{Language, Sentence, say, sentence};
use crate::vocabulary::vocabulary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

vocabulary! {
    /// Where the value of gravity comes from.
    GravityBasis {
        /// Stated by the bench or the campaign.
        Stated = "stated",
        /// Normal gravity, from latitude and altitude.
        Normal = "normal",
        /// Standard gravity: nothing was stated.
        Assumed = "assumed",
    }
}

/// What the inputs of the model lines rest on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SiteReport {
    /// Geodetic latitude, degrees; null where the bench has no site.
    pub latitude_deg: Option<f64>,
    /// Its standard uncertainty, degrees.
    pub latitude_u_deg: f64,
    /// Earth rate, deg/h.
    pub earth_rate_deg_h: f64,
    /// Local gravity.
    pub gravity: GravityReport,
    /// Relative standard uncertainties of the rates of turning joints, ppm.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub rate_u_ppm: BTreeMap<String, f64>,
    /// Warnings, as sentences.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<Sentence>,
}

/// Local gravity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GravityReport {
    /// Value, in `unit`.
    pub value: f64,
    /// Standard uncertainty, in `unit`; 0 where none was given.
    pub u: f64,
    /// `m/s^2`.
    pub unit: String,
    /// `stated`, `normal` (from latitude and altitude) or `assumed` (standard gravity).
    pub from: GravityBasis,
    /// The formula, for normal gravity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub formula: Option<String>,
    /// Altitude above the ellipsoid in metres, for normal gravity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub altitude_m: Option<f64>,
}

pub(super) fn site(bench: &Bench) -> SiteReport {
    let site = bench.site;
    let (from, formula, altitude_m) = match site.map(|site| site.gravity_from).unwrap_or_default() {
        GravityFrom::Assumed => (GravityBasis::Assumed, None, None),
        GravityFrom::Stated => (GravityBasis::Stated, None, None),
        GravityFrom::Normal { altitude_m } => {
            (GravityBasis::Normal, Some(NORMAL_GRAVITY_FORMULA.to_string()), Some(altitude_m))
        }
    };
    let gravity = GravityReport {
        value: site.map_or(1.0, |site| site.gravity_g) * STANDARD_GRAVITY_M_S2,
        u: site.map_or(0.0, |site| site.gravity_u_g) * STANDARD_GRAVITY_M_S2,
        unit: "m/s^2".into(),
        from,
        formula,
        altitude_m,
    };
    let mut warnings = Vec::new();
    if from == GravityBasis::Assumed && bench.units.force == ForceUnit::MetresPerSecondSquared && sees_force(bench) {
        warnings.push(sentence!("gravity-is-not-stated-and-taken-as", standard_gravity_m_s2 = STANDARD_GRAVITY_M_S2));
    }
    SiteReport {
        latitude_deg: site.map(|site| site.latitude_deg),
        latitude_u_deg: site.map_or(0.0, |site| site.latitude_u_deg),
        earth_rate_deg_h: site.map_or(0.0, |site| site.earth_rate_deg_h),
        gravity,
        rate_u_ppm: bench.rate_u.iter().map(|(joint, u)| (joint.clone(), u * 1e6)).collect(),
        warnings,
    }
}

fn sees_force(bench: &Bench) -> bool {
    let is_force = |name: &&str| name.starts_with("a_") && crate::campaign::is_axis_input(bench, name);
    bench.sensors.iter().any(|sensor| sensor.model.names().iter().any(is_force))
}

pub(super) fn gravity_text(report: &SiteReport, lang: Language) -> String {
    let gravity = &report.gravity;
    let u = if gravity.u > 0.0 { format!(" (u {:.1e})", gravity.u) } else { String::new() };
    let from = match (&gravity.formula, gravity.altitude_m) {
        (Some(formula), Some(altitude)) => {
            let at = say!(lang, "altitude-of", altitude);
            format!("{}{}{}{at}", lang.clause(), lang.name(formula), lang.clause())
        }
        _ if gravity.from == GravityBasis::Assumed => String::new(),
        _ => format!("{}{}", lang.clause(), lang.term("stated")),
    };
    say!(lang, "site-gravity", gravity = format!("{:.6}", gravity.value), unit = gravity.unit, u, from)
}
