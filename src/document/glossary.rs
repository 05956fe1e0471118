//! The terms of a page: the guide's glossary is their one source, in both languages.

use super::escape::inline;
use crate::language::{Each, Language, say};

/// A row of the glossary: the names of a term, as headings and columns have them, and its meaning.
struct Term {
    names: Vec<&'static str>,
    meaning: &'static str,
}

static READ: Each<Vec<Term>> = Each::new();

/// The rows of the page's table, without its head.
fn read(page: &'static str) -> Vec<Term> {
    let row = |line: &'static str| {
        let (names, meaning) = line.strip_prefix("| ")?.strip_suffix(" |")?.split_once(" | ")?;
        Some(Term { names: names.split([',', '\u{3001}']).map(str::trim).collect(), meaning })
    };
    page.lines().filter_map(row).skip(1).collect()
}

/// The terms that a page has used so far.
pub(super) struct Terms {
    language: Language,
    all: &'static [Term],
    /// Places of the used ones in the glossary.
    used: Vec<usize>,
}

impl Terms {
    pub(super) fn new(language: Language) -> Self {
        let all = READ.of(language, |language| read(language.glossary()));
        Terms { language, all, used: Vec::new() }
    }

    /// A heading, or the title of a column, as HTML. A term that occurs for the first time is a link to its definition.
    pub(super) fn title(&mut self, text: &str) -> String {
        // a column may end in a unit or a level: `residual sd, V`, `U (95 %)`
        let end = text.find([',', '(', '\u{ff0c}', '\u{ff08}']).unwrap_or(text.len());
        let name = text.get(..end).unwrap_or(text).trim_end();
        // single letters are symbols: u is not U
        let is = |term: &&str| *term == name || term.chars().count() > 1 && term.to_lowercase() == name.to_lowercase();
        match self.all.iter().position(|term| term.names.iter().any(&is)) {
            Some(place) if !self.used.contains(&place) => {
                self.used.push(place);
                format!("<a class=\"term\" href=\"#term-{place}\">{}</a>", inline(text))
            }
            _ => inline(text),
        }
    }

    /// The definitions of the terms that were used, in the order of the glossary; nothing for none.
    pub(super) fn definitions(mut self) -> String {
        self.used.sort_unstable();
        let definition = |place: &usize| {
            let term = self.all.get(*place)?;
            let names = term.names.join(self.language.comma());
            Some(format!(
                "<div><dt id=\"term-{place}\">{}</dt><dd>{}</dd></div>\n",
                inline(&names),
                inline(term.meaning)
            ))
        };
        let list: String = self.used.iter().filter_map(definition).collect();
        let heading = say!(self.language, "terms");
        match list.is_empty() {
            true => String::new(),
            false => format!("<aside id=\"terms\">\n<h3>{heading}</h3>\n<dl>\n{list}</dl>\n</aside>\n"),
        }
    }
}
