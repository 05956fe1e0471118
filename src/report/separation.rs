//! Rank defects in reports: what is free, along which direction, what is determined instead, and where to measure next.

use crate::campaign::{Campaign, JointState, joint_keys};
use crate::fit::{NamedCombination, RankDefect};
use crate::language::{Language, Sentence, say, sentence};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A rank defect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NotEstimableReport {
    /// The combination that the readings leave free.
    pub combination: BTreeMap<String, f64>,
    /// The same as a line of text.
    pub text: String,
    /// Along which direction it is free: parameters may move in these proportions and no reading changes.
    pub direction: BTreeMap<String, f64>,
    /// Which parameter hides in which others, where they are more than one.
    pub hides: Option<Sentence>,
    /// What is determined instead.
    pub estimable: Vec<CombinationReport>,
    /// The further position that would separate it, as reading keys; null if no position of this bench would.
    pub separate_by: Option<PositionReport>,
    /// The sensor to be read there, where it is one that no reading has now.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub separate_sensor: Option<String>,
    /// Do readings respond to it, but only in the second order, or through a factor that they do not distinguish from zero? Then nothing is known of
    /// other positions.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub weak: bool,
}

impl NotEstimableReport {
    /// The further reading that would separate it, in a sentence.
    pub(super) fn further(&self, lang: Language) -> Option<String> {
        let keys = |position: &PositionReport| position.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        let keys: Vec<String> = self.separate_by.as_ref().map(keys)?;
        let what = match (&self.separate_sensor, keys.is_empty()) {
            (None, _) => "position",
            (Some(_), true) => "sensor",
            (Some(_), false) => "both",
        };
        let (sensor, keys) = (self.separate_sensor.as_deref().unwrap_or_default(), keys.join(lang.comma()));
        Some(say!(lang, "a-reading-would-separate", what, sensor, keys))
    }

    /// What is determined instead, if anything is.
    pub(super) fn instead(&self, lang: Language) -> Option<String> {
        let names = || lang.names(self.estimable.iter().map(|c| &c.text));
        (!self.estimable.is_empty()).then(|| format!("{}{}{}", say!(lang, "determined-instead"), lang.colon(), names()))
    }

    /// What is said where no position is named that would separate it.
    pub(super) fn nowhere(&self) -> Sentence {
        if self.weak {
            sentence!("beyond-this-point-readings-respond-to-it")
        } else {
            sentence!("no-position-of-this-bench-would-separate-2")
        }
    }
}

/// A position as reading keys, for example `{ "alpha_deg": 270, "gamma_deg_s": 20 }`.
pub type PositionReport = BTreeMap<String, f64>;

/// A combination of parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CombinationReport {
    /// Coefficient of each parameter.
    pub combination: BTreeMap<String, f64>,
    /// The same as a line of text.
    pub text: String,
}

/// A rank defect, and which position would end it.
pub(super) fn not_estimable(campaign: &Campaign, separation: &RankDefect) -> NotEstimableReport {
    let direction = &separation.direction.terms;
    let hides = match direction.split_last() {
        Some(((last, _), [others @ .., (before, _)])) if !others.is_empty() => {
            let names: Vec<&str> = others.iter().map(|(id, _)| id.as_str()).collect();
            Some(sentence!("hides-in-and", last, join = names.join(", "), before))
        }
        _ => None,
    };
    NotEstimableReport {
        combination: separation.free.terms.iter().cloned().collect(),
        text: separation.free.text.clone(),
        direction: direction.iter().cloned().collect(),
        hides,
        estimable: separation.estimable.iter().map(combination).collect(),
        separate_by: separation.separate_by.as_ref().map(|joints| {
            let mut keys = position_keys(campaign, joints);
            keys.extend(separation.columns.iter().cloned());
            keys
        }),
        separate_sensor: separation.sensor.map(|k| campaign.sensor_id(k).to_string()),
        weak: separation.is_weak,
    }
}

/// Joint states as the keys that a reading would have.
pub fn position_keys(campaign: &Campaign, joints: &[JointState]) -> PositionReport {
    joint_keys(campaign.bench.joints(), joints).collect()
}

fn combination(named: &NamedCombination) -> CombinationReport {
    CombinationReport { combination: named.terms.iter().cloned().collect(), text: named.text.clone() }
}
