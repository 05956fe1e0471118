//! Lines of `"scatter"` in a campaign file: what scatters, how often, how much.

use crate::campaign::{Campaign, Deviating, Per, Scatter, ScatterRequest, Size};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What scatters beyond the readings' own noise: `of` something, `per` something, or correlated `over` a time.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScatterFile {
    /// A sensor, joint, tilt or coefficient; or several, each with deviations of its own.
    pub of: OneOrSeveral,
    /// `reading`, `position`, `campaign` or a column of the readings: how often it takes a new value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub per: Option<String>,
    /// Standard deviation in `unit`, or `estimate`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<NumberOrEstimate>,
    /// Degrees of freedom of a stated `u`; infinite unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dof: Option<f64>,
    /// Unit of `u`; an angle needs one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// The column that holds the time, where deviations are correlated as `exp(-|dt|/tau)`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over: Option<String>,
    /// Correlation time in the unit of that column, or `estimate`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tau: Option<NumberOrEstimate>,
    /// Correlation between the sensors of one reading.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correlation: Option<f64>,
}

/// One name or several.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a name, or a list of names")]
pub enum OneOrSeveral {
    /// One.
    One(String),
    /// Several.
    Several(Vec<String>),
}

impl Default for OneOrSeveral {
    fn default() -> Self {
        OneOrSeveral::Several(Vec::new())
    }
}

/// A number, or the word `estimate`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a number, or \"estimate\"")]
pub enum NumberOrEstimate {
    /// Stated.
    Number(f64),
    /// To be estimated from the readings.
    Estimate(EstimateWord),
}

/// The word `estimate`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum EstimateWord {
    /// From the readings.
    Estimate,
}

impl NumberOrEstimate {
    fn number(self) -> Option<f64> {
        if let NumberOrEstimate::Number(value) = self { Some(value) } else { None }
    }
}

impl ScatterFile {
    /// Does one of the lines read a column?
    pub fn use_key(lines: &[ScatterFile], key: &str) -> bool {
        lines.iter().any(|line| [&line.over, &line.per].into_iter().any(|own| own.as_deref() == Some(key)))
    }

    pub(super) fn into_request(self) -> ScatterRequest {
        let is_word = |value: Option<NumberOrEstimate>| matches!(value, Some(NumberOrEstimate::Estimate(_)));
        ScatterRequest {
            of: match self.of {
                OneOrSeveral::One(name) => vec![name],
                OneOrSeveral::Several(names) => names,
            },
            per: self.per,
            u: self.u.and_then(NumberOrEstimate::number),
            estimate: is_word(self.u),
            dof: self.dof,
            unit: self.unit,
            over: self.over,
            tau: self.tau.and_then(NumberOrEstimate::number),
            estimate_tau: is_word(self.tau),
            correlation: self.correlation,
        }
    }

    /// The line as a file; `None` for one that the readings' own columns say.
    pub(super) fn of(campaign: &Campaign, line: &Scatter) -> Option<ScatterFile> {
        let estimate = NumberOrEstimate::Estimate(EstimateWord::Estimate);
        let per = |line: &Scatter| Some(line.per.name().to_string());
        if let Deviating::Correlated(sensors, correlation) = &line.of {
            let names = sensors.iter().filter_map(|k| campaign.bench.sensors.get(*k)).map(|s| s.id.clone());
            let of = OneOrSeveral::Several(names.collect());
            return Some(ScatterFile { of, per: per(line), correlation: Some(*correlation), ..ScatterFile::default() });
        }
        let (u, dof) = match line.size {
            Size::Stated { sd, dof } => (NumberOrEstimate::Number(sd * line.shown), dof.is_finite().then_some(dof)),
            Size::Estimated => (estimate, None),
            Size::Column(_) => return None,
        };
        Some(ScatterFile {
            of: OneOrSeveral::One(line.of_name(campaign)),
            per: if line.over.is_some() && line.per == Per::Campaign { None } else { per(line) },
            u: Some(u),
            dof,
            unit: (!line.unit.is_empty()).then(|| line.unit.clone()),
            over: line.over.as_ref().map(|over| over.column.clone()),
            tau: line.over.as_ref().map(|over| over.tau.map_or(estimate, NumberOrEstimate::Number)),
            correlation: None,
        })
    }
}
