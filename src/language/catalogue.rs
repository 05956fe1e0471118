//! The catalogues: Fluent files, whose messages are read as they are asked for.

use super::{Argument, Each, Language};
use fluent_bundle::concurrent::FluentBundle;
use fluent_bundle::{FluentArgs, FluentResource};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, OnceLock, PoisonError};

static READ: Each<Catalogue> = Each::new();

/// The messages of one language.
pub(super) struct Catalogue {
    language: Language,
    entries: BTreeMap<&'static str, Entry>,
    /// Those that were asked for.
    bundle: Mutex<FluentBundle<FluentResource>>,
}

/// A message as the file has it.
struct Entry {
    text: &'static str,
    /// What it says, if it has no arguments.
    word: OnceLock<Option<String>>,
}

impl Catalogue {
    fn read(language: Language) -> Self {
        let mut bundle = FluentBundle::new_concurrent(language.tag().parse().into_iter().collect());
        // names and numbers without marks of direction
        bundle.set_use_isolating(false);
        let entry = |(key, text)| (key, Entry { text, word: OnceLock::new() });
        let entries = entries(language.parts().sentences).map(entry).collect();
        Catalogue { language, entries, bundle: Mutex::new(bundle) }
    }

    /// A message without arguments.
    pub(super) fn word(&self, key: &str) -> Option<&str> {
        let entry = self.entries.get(key).filter(|entry| !entry.text.contains('$'))?;
        entry.word.get_or_init(|| self.message(key, &[])).as_deref()
    }

    pub(super) fn message(&self, key: &str, arguments: &[(&'static str, Argument)]) -> Option<String> {
        let entry = self.entries.get(key)?;
        // before the lock: sentences among the arguments read further messages
        let mut values = FluentArgs::with_capacity(arguments.len());
        for (name, argument) in arguments {
            values.set(*name, argument.value(self.language));
        }
        let mut bundle = self.bundle.lock().unwrap_or_else(PoisonError::into_inner);
        if !bundle.has_message(key) {
            // messages with faults are left out; a test reads the files strictly
            let resource = FluentResource::try_new(entry.text.to_string()).unwrap_or_else(|(resource, _)| resource);
            bundle.add_resource_overriding(resource);
        }
        let pattern = bundle.get_message(key)?.value()?;
        let mut faults = Vec::new();
        Some(bundle.format_pattern(pattern, Some(&values), &mut faults).into_owned())
    }
}

/// The messages of a file: each key, and the lines from it to the next key or remark.
fn entries(text: &'static str) -> impl Iterator<Item = (&'static str, &'static str)> {
    let mut tail = text;
    std::iter::from_fn(move || {
        loop {
            let line = tail.lines().next()?;
            let length = |text: &'static str| {
                let more = text.split_inclusive('\n').skip(1);
                let within = more.take_while(|line| !line.starts_with(|c: char| c.is_ascii_lowercase() || c == '#'));
                text.split_inclusive('\n').next().map_or(0, str::len) + within.map(str::len).sum::<usize>()
            };
            let (entry, after) = tail.split_at(length(tail));
            tail = after;
            if let Some((key, _)) = line.split_once('=').filter(|_| line.starts_with(|c: char| c.is_ascii_lowercase()))
            {
                return Some((key.trim_end(), entry));
            }
        }
    })
}

/// The catalogue of a language.
pub(super) fn of(language: Language) -> &'static Catalogue {
    READ.of(language, Catalogue::read)
}

/// Every key of a language's catalogue with the names of its arguments, and whatever of the file is not valid Fluent.
pub fn keys(language: Language) -> (BTreeMap<String, BTreeSet<String>>, Vec<String>) {
    let text = language.parts().sentences;
    let mut faults: Vec<String> = match FluentResource::try_new(text.to_string()) {
        Ok(_) => Vec::new(),
        Err((_, faults)) => faults.iter().map(ToString::to_string).collect(),
    };
    // messages are read one by one
    let refers = |text: &str| {
        text.split('{').skip(1).any(|part| part.trim_start().starts_with(|c: char| c.is_ascii_lowercase() || c == '-'))
    };
    faults.extend(
        entries(text).filter(|(_, text)| refers(text)).map(|(key, _)| format!("{key} refers to another message")),
    );
    let arguments = |text: &str| -> BTreeSet<String> {
        let name = |part: &str| part.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
        text.split('$').skip(1).map(name).collect()
    };
    (entries(text).map(|(key, text)| (key.to_string(), arguments(text))).collect(), faults)
}
