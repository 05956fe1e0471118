//! The catalogue of effects (`effects.json`): what may be missing from a model, as data.

use super::{Source, locate, parse};
use crate::algebra::Expression;
use crate::diagnosis::{self, Applies, Effect};
use crate::error::{Fault, Malformed, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// A catalogue of effects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EffectsFile {
    /// The effects.
    pub effects: Vec<EffectFile>,
}

/// One effect, or a family of them: placeholders in its texts are replaced by names of the campaign.
///
/// `{i}` and `{j}` two axes of the sensor, `{joint}` a joint, `{turning}` a joint that turns, `{column}` a column of the readings that the sensor's line uses, `{k}` 1 to 4 (to 12 where the schedule carries it), `{tilt}` a tilt assumed zero,
/// `{known}` a known parameter, `{position}` a label, `{reading}` a number from 1, `{tau}` a time constant, `{break}` a time between readings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EffectFile {
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
    #[serde(default)]
    pub sensors: AppliesFile,
    /// Columns without which the effect cannot be looked for; a campaign that lacks one passes it over.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub needs: Vec<String>,
    /// Why it happens.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub why: String,
    /// How to confirm it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub confirm: String,
}

fn middling() -> u8 {
    3
}

/// Which sensors an effect applies to, told by the inputs of their model lines.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum AppliesFile {
    /// Every sensor.
    #[default]
    Any,
    /// Sensors whose model line has a rate.
    Gyro,
    /// Sensors whose model line has specific forces but no rate.
    Accelerometer,
}

/// Read a catalogue.
///
/// Errors: unknown keys; a term that does not parse, with a caret under the character; a term that is there twice.
pub fn read_effects(source: &Source) -> Result<Vec<Effect>> {
    let file: EffectsFile = parse(source)?;
    let mut effects = Vec::with_capacity(file.effects.len());
    let mut seen: HashMap<String, Vec<(Applies, String)>> = HashMap::new();
    for (k, own) in file.effects.into_iter().enumerate() {
        let path = format!("effects[{k}]");
        if own.term.trim().is_empty() || own.name.trim().is_empty() {
            let key = if own.term.trim().is_empty() { "term" } else { "name" };
            return Err(locate(
                Malformed::new(Fault::Value, format!("the effect has no {key}"))
                    .expected("some text")
                    .at_path(format!("{path}.{key}")),
                source,
            ));
        }
        let effect = Effect {
            term: own.term,
            name: own.name,
            coefficient: own.coefficient,
            rank: own.rank,
            one_of_many: own.one_of_many,
            applies: match own.sensors {
                AppliesFile::Any => Applies::Any,
                AppliesFile::Gyro => Applies::Gyro,
                AppliesFile::Accelerometer => Applies::Accelerometer,
            },
            needs: own.needs,
            why: own.why,
            confirm: own.confirm,
            place: path.clone(),
        };
        effect.check().map_err(|error| locate(error.at_path(format!("{path}.term")), source))?;
        let places = seen.entry(canonical(&effect)).or_default();
        if let Some((_, first)) = places.iter().find(|(applies, _)| meet(*applies, effect.applies)) {
            return Err(locate(
                Malformed::new(Fault::NameClash, format!("the effect '{}' is there twice", effect.term))
                    .expected(format!("each term once for a sensor ({first} has it already)"))
                    .found(format!("'{}' again", effect.term))
                    .at_path(format!("{path}.term")),
                source,
            ));
        }
        places.push((effect.applies, effect.place.clone()));
        effects.push(effect);
    }
    Ok(effects)
}

/// The term that an effect appends, in the form that equal terms share.
fn canonical(effect: &Effect) -> String {
    match Expression::parse(&effect.term) {
        Ok(line) => line.canonical(),
        // placeholders, and what is no term: as it is written
        Err(_) => effect.term.split_whitespace().collect(),
    }
}

/// Can one sensor have both?
fn meet(one: Applies, other: Applies) -> bool {
    one == other || one == Applies::Any || other == Applies::Any
}

/// The catalogue that ships with the program.
///
/// ```
/// assert!(tumble::wire::built_in_effects()?.iter().any(|effect| effect.term == "a_{i}"));
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn built_in_effects() -> Result<Vec<Effect>> {
    read_effects(&Source { name: "data/effects.json".into(), text: diagnosis::BUILT_IN.into() })
}
