//! The catalogue: effects as data, and what its placeholders stand for in one campaign.

use crate::algebra::Expression;
use crate::bench::Sensor;
use crate::campaign::{Campaign, Kind, Role};
use crate::error::Result;
use crate::vocabulary::vocabulary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The text of the catalogue that ships with the program.
pub(crate) const BUILT_IN: &str = include_str!("../../data/effects.json");

/// Harmonics of joint angles that are tried at least, and at most.
const HARMONICS: (usize, usize) = (4, 12);
/// Leading digits of the time constants that are tried, in every decade.
const TIME_CONSTANTS: [f64; 13] = [1.0, 1.2, 1.5, 1.8, 2.0, 2.4, 3.0, 3.6, 4.5, 5.0, 6.0, 7.5, 9.0];

/// One effect, or a family of them: placeholders in its texts are replaced by names of the campaign.
///
/// `{i}` and `{j}` two axes of one frame of the sensor (its own, or the body axes that its line uses), `{covariate}` a column of the readings that no line uses, `{joint}` a joint, `{turning}` a joint that turns, `{column}` a column of the readings that the sensor's line uses, `{k}` 1 to 4 (to 12 where the schedule carries it), `{tilt}` a tilt assumed zero,
/// `{known}` a known parameter, `{position}` a label, `{reading}` a number from 1, `{tau}` a time constant, `{break}` a time between readings (or, without times, a place in their order).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "EffectFile")]
pub struct Effect {
    /// The term to append to the model line, without its coefficient; or `tilt:`, `known:`, `position:`, `reading:`, `exchange:`, `approach:`, `rate:`, `sense:` and a name.
    pub term: String,
    /// Its name in the field's words.
    pub name: String,
    /// Name of the coefficient in the repaired model line; made from the term unless given.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub coefficient: String,
    /// Order among effects that the readings cannot distinguish: 0 the most plausible; 3 unless given.
    #[serde(default = "middling")]
    pub rank: u8,
    /// One thing that happens at any of many places, such as a bad reading: all members together are as probable as another effect.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub one_of_many: bool,
    /// Which sensors can have it.
    #[serde(default, rename = "sensors")]
    pub applies: Applies,
    /// Columns without which the effect cannot be looked for; a campaign that lacks one passes it over.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub needs: Vec<String>,
    /// Why it happens.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub why: String,
    /// How to confirm it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub confirm: String,
    /// Where the catalogue has it, for messages.
    #[serde(skip)]
    pub place: String,
}

fn middling() -> u8 {
    3
}

vocabulary! {
    /// Which sensors an effect applies to, told by the inputs of their model lines.
    #[derive(Default)]
    #[schemars(rename = "AppliesFile")]
    Applies {
        /// Every sensor.
        #[default]
        Any = "any",
        /// Sensors whose model line has a rate.
        Gyro = "gyro",
        /// Sensors whose model line has specific forces but no rate.
        Accelerometer = "accelerometer",
    }
}

impl Applies {
    /// Can this sensor have it?
    pub fn to(self, sensor: &Sensor) -> bool {
        let has = |prefix: &str| sensor.model.names().iter().any(|name| name.starts_with(prefix));
        match self {
            Applies::Any => true,
            Applies::Gyro => has("w_"),
            Applies::Accelerometer => has("a_") && !has("w_"),
        }
    }
}

/// One member of a family: the value of each placeholder.
pub(super) type Filling = Vec<(&'static str, String)>;

impl Effect {
    /// Does the term parse, whatever its placeholders will stand for?
    pub(crate) fn check(&self) -> Result<()> {
        if self.term.contains(':') {
            return Ok(());
        }
        // as long as the placeholder itself, so that the caret is under the right character
        let mut text = self.term.clone();
        for (placeholder, stand_in) in [
            ("{i}", "_x_"),
            ("{j}", "_y_"),
            ("{k}", "001"),
            ("{joint}", "joint__"),
            ("{turning}", "turning__"),
            ("{column}", "column__"),
            ("{covariate}", "covariate__"),
            ("{tau}", "00001"),
            ("{break}", "0000001"),
        ] {
            text = text.replace(placeholder, stand_in);
        }
        Expression::parse(&text).map(|_| ())
    }

    /// Every way to fill the placeholders for one sensor, except those that are scanned or stand for readings.
    pub(super) fn fillings(&self, campaign: &Campaign, sensor: &Sensor) -> Vec<Filling> {
        let mut fillings: Vec<Filling> = vec![Vec::new()];
        let mut each = |placeholder: &'static str, options: Vec<String>| {
            if self.term.contains(placeholder) {
                fillings = fillings
                    .iter()
                    .flat_map(|before| {
                        options.iter().map(|option| {
                            let mut next = before.clone();
                            next.push((placeholder, option.clone()));
                            next
                        })
                    })
                    .collect();
            }
        };
        let used = sensor.model.names();
        let mut axes: Vec<String> = sensor.axes.iter().map(|(axis, _)| axis.clone()).collect();
        let own = axes.len();
        let body = ["x", "y", "z"].map(str::to_string);
        let is_used =
            |axis: &String| used.iter().any(|name| name.strip_prefix("a_").or(name.strip_prefix("w_")) == Some(axis));
        // those of the last frame: of a sensor that has no others, or whose line uses them
        if own == 0 || body.iter().any(is_used) {
            let further: Vec<String> = body.into_iter().filter(|axis| !axes.contains(axis)).collect();
            axes.extend(further);
        }
        each("{i}", axes.clone());
        each("{j}", axes.clone());
        // equal steps of n angles carry harmonics up to n / 2; those above are the same columns again
        let most =
            campaign.bench.joints().enumerate().map(|(place, joint)| (joint.to_string(), carried(campaign, place)));
        let most: Vec<(String, usize)> = most.collect();
        let highest = most.iter().map(|(_, n)| *n).max().unwrap_or(HARMONICS.0);
        each("{k}", (1..=highest).map(|k| k.to_string()).collect());
        each("{joint}", campaign.bench.joints().map(str::to_string).collect());
        each("{turning}", turning(campaign));
        // without joints every input is the same in all readings, and its product with a column is that column
        let turned = campaign.bench.joints().next().is_some();
        let columns = campaign.readings.columns.iter().filter(|column| turned && used.contains(&column.as_str()));
        each("{column}", columns.cloned().collect());
        each("{covariate}", covariates(campaign).0);
        each("{tilt}", parameters(campaign, |role, kind| *role == Role::AssumedZero && kind == Kind::Tilt));
        each("{known}", parameters(campaign, |role, kind| matches!(role, Role::Known(_)) && kind != Kind::Input));
        each("{tau}", time_constants(campaign));
        let place = |filling: &Filling, key: &str| {
            stands_for(filling, key).and_then(|text| axes.iter().position(|axis| axis == text))
        };
        fillings.retain(|filling| {
            let joint = stands_for(filling, "{joint}");
            let highest = joint.and_then(|joint| most.iter().find(|(name, _)| name == joint)).map(|(_, n)| *n);
            order(filling).zip(highest).is_none_or(|(k, highest)| k <= highest)
        });
        fillings.retain(|filling| match (place(filling, "{i}"), place(filling, "{j}")) {
            // of one frame
            (Some(i), Some(j)) => i < j && (i < own) == (j < own),
            _ => true,
        });
        fillings
    }
}

/// What a placeholder stands for.
fn stands_for<'a>(filling: &'a Filling, key: &str) -> Option<&'a str> {
    filling.iter().find(|(placeholder, _)| *placeholder == key).map(|(_, text)| text.as_str())
}

/// The order of a harmonic.
pub(super) fn order(filling: &Filling) -> Option<usize> {
    stands_for(filling, "{k}").and_then(|k| k.parse().ok())
}

/// The column that counts the readings, from 1, while a campaign without times is diagnosed.
pub(super) const ORDER: &str = "order";

/// The column that says when readings were taken: their time, or their number.
pub(super) fn clock(campaign: &Campaign) -> &'static str {
    if campaign.readings.columns.iter().any(|column| column == "time_s") { "time_s" } else { ORDER }
}

/// Does anything of a campaign have this name?
pub(super) fn has(campaign: &Campaign, name: &str) -> bool {
    let bench = &campaign.bench;
    campaign.parameter_index(name).is_some()
        || campaign.readings.columns.iter().any(|column| column == name)
        || bench.chain.iter().any(|link| link.name() == name)
        || bench.sensors.iter().any(|sensor| sensor.id == name)
}

/// The campaign with the number of each reading where it has no time, so that what drifts can be named; as it is where something else has that name.
pub(super) fn with_order(campaign: &Campaign) -> Cow<'_, Campaign> {
    if clock(campaign) != ORDER || has(campaign, ORDER) {
        return Cow::Borrowed(campaign);
    }
    let mut readings = campaign.readings.clone();
    readings.columns.push(ORDER.into());
    for (k, reading) in readings.rows.iter_mut().enumerate() {
        reading.columns = reading.columns.iter().copied().chain([Some((k + 1) as f64)]).collect();
    }
    Cow::Owned(campaign.with_readings(readings))
}

/// The repaired campaign without the numbers of its readings, where none were given and no line uses them.
pub(super) fn without_order(repaired: Campaign, given: &Campaign) -> Campaign {
    let place = repaired.readings.columns.iter().position(|column| column == ORDER);
    let is_used = repaired.bench.sensors.iter().any(|sensor| sensor.model.names().contains(&ORDER));
    let Some(place) = place.filter(|_| !is_used && given.readings.columns.iter().all(|column| column != ORDER)) else {
        return repaired;
    };
    let mut readings = repaired.readings.clone();
    readings.columns.remove(place);
    for reading in &mut readings.rows {
        reading.columns =
            reading.columns.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, value)| *value).collect();
    }
    repaired.with_readings(readings)
}

/// Columns that no model line uses and whose values differ: those that a line can name, and those whose titles are no names, which are not tried.
pub(crate) fn covariates(campaign: &Campaign) -> (Vec<String>, Vec<String>) {
    let bench = &campaign.bench;
    let is_used = |column: &str| bench.sensors.iter().any(|sensor| sensor.model.names().contains(&column));
    let columns = campaign.readings.columns.iter().filter(|c| !is_used(c) && !bench.is_of_joint(c));
    let differ = |column: &&String| {
        let values = column_values(campaign, column);
        values.iter().any(|value| Some(value) != values.first())
    };
    columns.filter(differ).cloned().partition(|column| crate::bench::identifier(column).is_ok())
}

/// A text with its placeholders filled.
pub(super) fn fill(text: &str, filling: &Filling) -> String {
    filling.iter().fold(text.to_string(), |text, (placeholder, value)| text.replace(placeholder, value))
}

/// The highest harmonic of a joint that its angles can tell: half of their number.
pub(super) fn carried(campaign: &Campaign, place: usize) -> usize {
    let held = campaign.readings.rows.iter().filter_map(|row| row.joints.get(place)?.held_deg());
    let angles: std::collections::HashSet<u64> = held.map(|deg| (deg.rem_euclid(360.0) + 0.0).to_bits()).collect();
    (angles.len() / 2).clamp(HARMONICS.0, HARMONICS.1)
}

fn turning(campaign: &Campaign) -> Vec<String> {
    let has_rate = |joint: &str| campaign.readings.columns.iter().any(|c| c.strip_prefix(joint) == Some("_deg_s"));
    campaign.bench.joints().filter(|joint| has_rate(joint)).map(str::to_string).collect()
}

fn parameters(campaign: &Campaign, wanted: impl Fn(&Role, Kind) -> bool) -> Vec<String> {
    campaign.parameters.iter().filter(|p| wanted(&p.role, p.kind)).map(|p| p.id.clone()).collect()
}

/// Values of a column, one for each reading that has it.
pub(super) fn column_values(campaign: &Campaign, name: &str) -> Vec<f64> {
    match campaign.readings.columns.iter().position(|column| column == name) {
        Some(k) => campaign.readings.rows.iter().filter_map(|row| row.columns.get(k).copied().flatten()).collect(),
        None => Vec::new(),
    }
}

/// Round time constants, from twice the usual spacing of the readings to the length of the campaign.
fn time_constants(campaign: &Campaign) -> Vec<String> {
    let mut times = column_values(campaign, clock(campaign));
    times.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (times.first().copied(), times.last().copied()) else { return Vec::new() };
    let span = last - first;
    if !(span > 0.0 && span.is_finite()) {
        return Vec::new();
    }
    let shortest = 2.0 * span / times.len() as f64;
    let mut decade = 10f64.powf(shortest.log10().floor());
    let mut constants = Vec::new();
    while decade <= span && constants.len() < 200 {
        let inside = TIME_CONSTANTS.iter().map(|digit| digit * decade).filter(|tau| (shortest..=span).contains(tau));
        constants.extend(inside.map(|tau| format!("{}", (tau * 1e6).round() / 1e6)));
        decade *= 10.0;
    }
    constants
}

/// The times between readings, as text and number: midpoints, with as many decimals as the times have (at least one).
pub(super) fn breaks(campaign: &Campaign) -> Vec<(String, f64)> {
    let mut times = column_values(campaign, clock(campaign));
    times.sort_by(f64::total_cmp);
    times.dedup();
    let decimals = times.iter().map(|t| format!("{t}").split_once('.').map_or(0, |(_, tail)| tail.len())).max();
    // whole numbers only
    let decimals = decimals.unwrap_or(0).clamp(1, 12);
    let mut breaks = Vec::new();
    for pair in times.windows(2) {
        if let [before, after] = pair {
            let middle = 0.5 * (before + after);
            breaks.push((format!("{middle:.decimals$}"), middle));
        }
    }
    breaks
}
