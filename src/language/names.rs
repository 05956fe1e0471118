//! Texts that the program has as data (benches, effects, notes of a computation) in another language, by their English text.

use super::{Each, Language};
use std::collections::BTreeMap;

static READ: Each<Names> = Each::new();

/// Texts by their English form; `{name}` is a placeholder for any part, which is translated, too.
struct Names {
    whole: BTreeMap<String, String>,
    /// Those with parts, the most text first.
    patterns: Vec<Pattern>,
}

struct Pattern {
    /// The texts before, between and after the parts.
    pieces: Vec<String>,
    parts: Vec<String>,
    translation: String,
}

/// A text in a language, if it is known there.
pub(super) fn say(language: Language, text: &str) -> Option<String> {
    READ.of(language, |language| Names::read(language.parts().names)).say(text)
}

/// The English texts that have a translation, as the language's file has them.
pub fn names(language: Language) -> impl Iterator<Item = String> {
    // a file of the project, which a test reads
    let names: BTreeMap<String, String> = serde_json::from_str(language.parts().names).unwrap_or_default();
    names.into_keys()
}

impl Names {
    fn read(text: &str) -> Self {
        // a file of the project, which a test reads
        let all: BTreeMap<String, String> = serde_json::from_str(text).unwrap_or_default();
        let (patterns, whole): (Vec<_>, Vec<_>) = all.into_iter().partition(|(english, _)| english.contains('{'));
        let mut patterns: Vec<Pattern> =
            patterns.into_iter().map(|(english, translation)| Pattern::new(&english, translation)).collect();
        patterns.sort_by_key(|pattern| std::cmp::Reverse(pattern.pieces.iter().map(String::len).sum::<usize>()));
        Names { whole: whole.into_iter().collect(), patterns }
    }

    fn say(&self, text: &str) -> Option<String> {
        if let Some(known) = self.whole.get(text) {
            return Some(known.clone());
        }
        self.patterns.iter().find_map(|pattern| {
            let parts = pattern.parts_of(text)?;
            let named = pattern.parts.iter().zip(parts);
            Some(named.fold(pattern.translation.clone(), |said, (name, part)| {
                let part = self.say(part).unwrap_or_else(|| part.to_string());
                said.replace(&format!("{{{name}}}"), &part)
            }))
        })
    }
}

impl Pattern {
    fn new(english: &str, translation: String) -> Self {
        let (mut pieces, mut parts) = (Vec::new(), Vec::new());
        let mut tail = english;
        while let Some((piece, after)) = tail.split_once('{') {
            let (name, after) = after.split_once('}').unwrap_or((after, ""));
            pieces.push(piece.to_string());
            parts.push(name.to_string());
            tail = after;
        }
        pieces.push(tail.to_string());
        Pattern { pieces, parts, translation }
    }

    /// The parts of a text; `None` where it does not match.
    fn parts_of<'a>(&self, text: &'a str) -> Option<Vec<&'a str>> {
        let (first, others) = self.pieces.split_first()?;
        let (last, between) = others.split_last()?;
        let mut text = text.strip_prefix(first.as_str())?.strip_suffix(last.as_str())?;
        let mut parts = Vec::with_capacity(self.parts.len());
        for piece in between {
            let (part, after) = text.split_once(piece.as_str())?;
            parts.push(part);
            text = after;
        }
        parts.push(text);
        parts.iter().all(|part| !part.is_empty()).then_some(parts)
    }
}
