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
    pub effects: Vec<Effect>,
}

/// Read a catalogue.
///
/// Errors: unknown keys; a term that does not parse, with a caret under the character; a term that is there twice.
pub fn read_effects(source: &Source) -> Result<Vec<Effect>> {
    let file: EffectsFile = parse(source)?;
    checked(file).map_err(|error| locate(error, source))
}

fn checked(file: EffectsFile) -> Result<Vec<Effect>> {
    let mut effects = Vec::with_capacity(file.effects.len());
    let mut seen: HashMap<String, Vec<(Applies, String)>> = HashMap::new();
    for (k, mut effect) in file.effects.into_iter().enumerate() {
        let path = format!("effects[{k}]");
        if effect.term.trim().is_empty() || effect.name.trim().is_empty() {
            let key = if effect.term.trim().is_empty() { "term" } else { "name" };
            return Err(Malformed::new(Fault::Value, format!("the effect has no {key}"))
                .expected("some text")
                .at_path(format!("{path}.{key}")));
        }
        effect.place.clone_from(&path);
        effect.check().map_err(|error| error.at_path(format!("{path}.term")))?;
        let places = seen.entry(canonical(&effect)).or_default();
        if let Some((_, first)) = places.iter().find(|(applies, _)| meet(*applies, effect.applies)) {
            return Err(Malformed::new(Fault::NameClash, format!("the effect '{}' is there twice", effect.term))
                .expected(format!("each term once for a sensor ({first} has it already)"))
                .found(format!("'{}' again", effect.term))
                .at_path(format!("{path}.term")));
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
