//! The catalogues: Fluent files, read once.

use super::{Argument, Each, Language};
use fluent_bundle::concurrent::FluentBundle;
use fluent_bundle::{FluentArgs, FluentResource};
use std::collections::{BTreeMap, BTreeSet};

static READ: Each<Catalogue> = Each::new();

/// The messages of one language.
pub(super) struct Catalogue {
    language: Language,
    bundle: FluentBundle<FluentResource>,
    /// Those without arguments.
    pub(super) words: BTreeMap<String, String>,
}

impl Catalogue {
    fn read(language: Language) -> Self {
        let text = language.parts().sentences;
        let mut bundle = FluentBundle::new_concurrent(language.tag().parse().into_iter().collect());
        // names and numbers stand as they are, without marks of direction
        bundle.set_use_isolating(false);
        // what cannot be read is left out; a test reads the files strictly
        let resource = FluentResource::try_new(text.to_string()).unwrap_or_else(|(resource, _)| resource);
        bundle.add_resource_overriding(resource);
        let mut catalogue = Catalogue { language, bundle, words: BTreeMap::new() };
        for (key, arguments) in messages(text) {
            if arguments.is_empty()
                && let Some(text) = catalogue.message(&key, &[])
            {
                catalogue.words.insert(key, text);
            }
        }
        catalogue
    }

    pub(super) fn message(&self, key: &str, arguments: &[(&'static str, Argument)]) -> Option<String> {
        let pattern = self.bundle.get_message(key)?.value()?;
        let mut values = FluentArgs::with_capacity(arguments.len());
        for (name, argument) in arguments {
            values.set(*name, argument.value(self.language));
        }
        let mut faults = Vec::new();
        Some(self.bundle.format_pattern(pattern, Some(&values), &mut faults).into_owned())
    }
}

/// The catalogue of a language.
pub(super) fn of(language: Language) -> &'static Catalogue {
    READ.of(language, Catalogue::read)
}

/// Every message of a file with the names of its arguments.
fn messages(text: &str) -> BTreeMap<String, BTreeSet<String>> {
    let mut found = BTreeMap::new();
    let mut current: Option<String> = None;
    for line in text.lines() {
        match line.split_once('=') {
            Some((key, _)) if line.starts_with(|c: char| c.is_ascii_lowercase()) => {
                current = Some(key.trim_end().to_string());
            }
            _ if line.starts_with([' ', '}']) => {}
            _ => current = None,
        }
        if let Some(key) = &current {
            let arguments: &mut BTreeSet<String> = found.entry(key.clone()).or_default();
            for part in line.split('$').skip(1) {
                arguments.insert(part.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect());
            }
        }
    }
    found
}

/// Every key of a language's catalogue with the names of its arguments, and whatever of the file is not valid Fluent.
pub fn keys(language: Language) -> (BTreeMap<String, BTreeSet<String>>, Vec<String>) {
    let text = language.parts().sentences;
    let faults = match FluentResource::try_new(text.to_string()) {
        Ok(_) => Vec::new(),
        Err((_, faults)) => faults.iter().map(ToString::to_string).collect(),
    };
    (messages(text), faults)
}
