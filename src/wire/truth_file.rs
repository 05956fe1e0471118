//! The truth file (`*.truth.json`) of a simulation: what the readings are made from, kept apart from the campaign.

use super::locate::in_source;
use super::{Named, Source, parse};
use crate::campaign::Campaign;
use crate::error::{Fault, Malformed, Result};
use crate::simulate::{DrawnNoise, Hidden, TrueScatter, Truth};
use crate::units::Conversion;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the readings are made from.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TruthFile {
    /// True values of tilts and coefficients; a known one of the campaign that is not listed is as the campaign says, any other is zero.
    #[serde(default)]
    pub values: Named<TrueValueFile>,
    /// Noise of each sensor.
    #[serde(default)]
    pub noise: Named<NoiseFile>,
    /// Effects that the campaign's model does not have: drift, steps, bad readings, anything that `diagnose` could name.
    #[serde(default)]
    pub effects: Vec<HiddenFile>,
    /// What scatters in truth, by the name of the campaign's line (`beta per position`, `V over time_s`): needed where the campaign estimates it.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub scatter: Named<TrueScatterFile>,
}

/// True size of a line of scatter.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrueScatterFile {
    /// Standard deviation, in the unit of the campaign's line.
    pub sd: f64,
    /// Correlation time, where the line is correlated over a time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tau: Option<f64>,
}

/// A true value.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrueValueFile {
    /// The value, in `unit`.
    pub value: f64,
    /// Unit; without one a tilt is in radians, a coefficient in the unit that follows from the model line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

/// Noise of a sensor, Gaussian and independent from reading to reading.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NoiseFile {
    /// Standard deviation of one sample, in `unit`; a reading with `n` samples averaged has it over the root of n.
    pub sd: f64,
    /// Unit; that of the sensor unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Write it into the campaign as the readings' standard uncertainty; true unless said otherwise.
    #[serde(default = "yes")]
    pub stated: bool,
    /// Round readings to so many decimals; all digits of a double unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decimals: Option<u32>,
}

fn yes() -> bool {
    true
}

/// A hidden effect.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HiddenFile {
    /// A term without its coefficient (`a_S`, `step(time_s-1200)`), or `tilt:ID`, `known:ID`, `position:LABEL`, `reading:N`, `approach:JOINT`.
    pub regressor: String,
    /// Its coefficient, in `unit`.
    pub value: f64,
    /// Unit; unless given the sensor's for each unit of the regressor (a tilt in radians).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// The sensor that has it; needed only where the bench has several and the effect is in one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor: Option<String>,
}

/// Read a truth for this campaign.
///
/// Errors: unknown keys, parameters, sensors or regressors; numbers that are not finite; all with their place in the file.
pub fn read_truth(source: &Source, campaign: &Campaign) -> Result<Truth> {
    let file: TruthFile = parse(source)?;
    file.into_truth(campaign).map_err(|error| in_source(error, source))
}

impl TruthFile {
    fn into_truth(self, campaign: &Campaign) -> Result<Truth> {
        let mut point = campaign.reference_point();
        for (parameter, value) in campaign.parameters.iter().zip(&mut point) {
            if !matches!(parameter.role, crate::campaign::Role::Known(_)) {
                *value = 0.0;
            }
        }
        for (id, stated) in &self.values.0 {
            let path = format!("values.{id}");
            let Some(k) = campaign.parameter_index(id) else {
                let known = campaign.parameters.iter().map(|p| &p.id);
                return Err(Malformed::unknown(format!("the bench has no parameter '{id}'"), id, known).at_path(path));
            };
            let value = match stated.unit.as_deref() {
                Some(unit) => {
                    let to = campaign.parameter_conversion(k, unit).map_err(|e| e.at_path(format!("{path}.unit")))?;
                    to.apply(stated.value)
                }
                None => stated.value,
            };
            if let Some(slot) = point.get_mut(k) {
                *slot = value;
            }
        }
        let mut noise = vec![DrawnNoise::default(); campaign.bench.sensors.len()];
        for (id, n) in &self.noise.0 {
            let path = format!("noise.{id}");
            let slot = sensor_index(campaign, id, &path)?;
            if !(n.sd >= 0.0 && n.sd.is_finite()) {
                return Err(Malformed::new(Fault::Value, "no standard deviation")
                    .expected("zero or a positive number")
                    .found(n.sd.to_string())
                    .at_path(format!("{path}.sd")));
            }
            if let Some(noise) = noise.get_mut(slot) {
                let to = n.unit.as_deref().map_or(Ok(Conversion::NONE), |unit| {
                    let to = campaign.conversion(unit, campaign.sensor_unit(slot), &format!("sensor '{id}'"));
                    to.map_err(|e| e.at_path(format!("{path}.unit")))
                })?;
                *noise = DrawnNoise { sd: to.of_differences().apply(n.sd), stated: n.stated, decimals: n.decimals };
            }
        }
        let mut effects = Vec::with_capacity(self.effects.len());
        for (k, effect) in self.effects.iter().enumerate() {
            let path = format!("effects[{k}]");
            if !effect.value.is_finite() {
                return Err(Malformed::new(Fault::Value, "not a finite number").at_path(format!("{path}.value")));
            }
            let sensor = effect.sensor.as_ref().map(|id| sensor_index(campaign, id, &format!("{path}.sensor")));
            let sensor = sensor.transpose()?;
            let mut hidden = Hidden::new(campaign, &effect.regressor, effect.value, sensor)
                .map_err(|error| error.at_path(format!("{path}.regressor")))?;
            if let Some(unit) = &effect.unit {
                let to = hidden.unit(campaign).unwrap_or_default();
                let to = campaign.conversion(unit, &to, &format!("the effect '{}'", effect.regressor));
                hidden.value =
                    to.map_err(|error| error.at_path(format!("{path}.unit")))?.of_differences().apply(effect.value);
            }
            effects.push(hidden);
        }
        let mut scatter = Vec::with_capacity(self.scatter.0.len());
        for (name, n) in &self.scatter.0 {
            let path = format!("scatter.{name}");
            let Some(line) = campaign.scatter.iter().position(|line| line.name(campaign) == *name) else {
                let names: Vec<String> = campaign.scatter.iter().map(|line| line.name(campaign)).collect();
                let error = Malformed::unknown(format!("the campaign has no line of scatter '{name}'"), name, &names);
                let error = if names.is_empty() { error.expected("none: it has no lines") } else { error };
                return Err(error.at_path("scatter"));
            };
            let usable = n.sd >= 0.0 && n.sd.is_finite() && n.tau.is_none_or(|tau| tau > 0.0 && tau.is_finite());
            if !usable {
                return Err(Malformed::new(Fault::Value, "the size of the deviations cannot be used")
                    .expected("sd zero or positive, tau positive")
                    .at_path(path));
            }
            let shown = campaign.scatter.get(line).map_or(1.0, |line| line.shown);
            scatter.push(TrueScatter { line, sd: n.sd / shown, tau: n.tau });
        }
        Ok(Truth { point, noise, effects, scatter })
    }
}

fn sensor_index(campaign: &Campaign, id: &str, path: &str) -> Result<usize> {
    campaign.bench.sensors.iter().position(|sensor| sensor.id == id).ok_or_else(|| {
        let known = campaign.bench.sensors.iter().map(|s| &s.id);
        Malformed::unknown(format!("the bench has no sensor '{id}'"), id, known).at_path(path)
    })
}
