//! One document for every answer: a tree of what a person reads, and renderers that know nothing of what it is about.
//!
//! ```text
//! answer (report value) -> one function of `report` -> Document -> terminal::render | markdown::render | html::render | workbook::render
//! ```
//!
//! A [`Document`] has a title, facts (names and values) and [`Section`]s; a section has [`Block`]s: prose, verdicts, points, formulas, facts, cards,
//! tables of typed [`Cell`]s, figures. Every block, and every column of a table, says at which [`Detail`] it appears: `Brief` on a terminal and
//! on a page, `Full` on a page and at a terminal with `-v`. A section without blocks is left out, and so is one that has none at the detail
//! that is rendered.
//!
//! To write the document of an answer: one function `<answer>_document(&Report, .., Language) -> Document` in `report`, from sections:
//!
//! ```
//! use tumble::document::{Cell, Detail, Document, Rows, Section, Tone, terminal};
//! let table = Rows::of([("V0", 1.58203, 0.0114)])
//!     .name("parameter", |(id, ..)| id)
//!     .decimal("estimate", |(_, value, u)| Cell::Value(value, Some(u)))
//!     .decimal("u", |(.., u)| Cell::Value(u, Some(u)));
//! let result = Section::new("Result").verdict(Tone::Good, "The readings agree.").table(table).full().prose("More.");
//! let document = Document::new("A fit").section(result);
//! let text = terminal::render(&document, Detail::Brief);
//! assert!(text.contains("OK: The readings agree.") && text.contains("V0            1.582  0.011") && !text.contains("More."));
//! ```
//!
//! * Numbers enter a table as numbers: [`Cell::value`] with the uncertainty that rounds them (U where it stands beside them, else u), `Cell::digits`, [`Cell::dof`], [`Cell::p`];
//!   what does not exist is [`Cell::Absent`]. In sentences `number::{rounded, significant, level}` write them by the same rules.
//! * Sentences come from the catalogues (`say!`), one for all outputs. In every text a pair of backticks sets a name in code type.
//! * A section puts its verdicts in order itself: what is not in order stands before what is, and beside a bad one nothing is praised.
//! * A [`Figure`] holds the specification of a chart ([`chart::Chart`]), not a drawing, with its caption and its words.
//! * [`Section::full`] and `Section::brief` say the detail of the blocks that follow; [`Rows::at`] that of a column ([`Detail::Roomy`]: left out
//!   at a terminal where the line is too short).
//!
//! | file | subject |
//! |---|---|
//! | `table.rs` | tables and their typed cells |
//! | `number.rs` | digits of numbers, levels, degrees of freedom |
//! | `chart.rs`, `plot/` | charts as data, and how they are drawn |
//! | `terminal.rs`, `wrap.rs` | a document for a terminal of 80 columns |
//! | `markdown.rs` | a document as Markdown |
//! | `html.rs`, `escape.rs`, `xml.rs` | a document as one HTML file |
//! | `glossary.rs` | the terms that a page uses, with their definitions from the guide |
//! | `workbook/` | a document as a workbook |
//!
//! Deliberately absent: anything that depends on which answer it is; colours (the style sheet and `plot` have them); clocks (the same answer
//! always gives the same bytes).

pub(crate) mod chart;
#[cfg(feature = "html")]
mod escape;
#[cfg(feature = "html")]
mod glossary;
#[cfg(feature = "html")]
pub mod html;
pub mod markdown;
pub mod number;
#[cfg(feature = "html")]
pub mod plot;
mod table;
pub mod terminal;
#[cfg(all(feature = "cli", feature = "excel"))]
pub mod workbook;
pub(crate) mod wrap;
#[cfg(any(feature = "html", feature = "dcc"))]
pub(crate) mod xml;

pub use chart::{Bar, Chart, GapPanel, GapPoint, Interval, Part, Residual};
pub(crate) use table::Align;
pub use table::{Cell, Column, Row, Rows, Table};

use crate::language::{Language, say};
use std::collections::HashSet;

/// How much a person sees.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Detail {
    /// What a terminal shows.
    #[default]
    Brief,
    /// A column that a terminal shows where the line is long enough.
    Roomy,
    /// What a page shows, and a terminal with `-v`.
    Full,
}

/// A document: what it is about, and its sections.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Document {
    /// Heading.
    pub title: String,
    /// One line under the title.
    pub subtitle: String,
    /// What it is about, as names and values, below the title.
    pub facts: Vec<(String, String)>,
    /// The sections, in order.
    pub sections: Vec<Section>,
    /// The language of its texts.
    pub language: Language,
    /// Version, inputs and their digests, at the end of a page.
    pub colophon: Vec<(String, String)>,
    /// Anchors of the sections: a record may have a hundred thousand of them.
    anchors: HashSet<String>,
}

/// A heading and its content.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Section {
    /// Heading.
    pub heading: String,
    /// Anchor, made from the heading.
    pub anchor: String,
    /// Blocks, in order.
    pub blocks: Vec<Block>,
    /// Detail of the blocks that are added next.
    detail: Detail,
}

/// One block of a section, and the detail at which it appears.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// At which detail it appears.
    pub detail: Detail,
    /// What it is.
    pub content: Content,
}

/// What a block is. In every text a pair of backticks sets a name in code type.
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    /// A paragraph.
    Prose(String),
    /// The answer, or a warning: set apart, with a mark that does not need colour.
    Verdict {
        /// How it sounds.
        tone: Tone,
        /// The sentence.
        text: String,
    },
    /// Points.
    List(Vec<String>),
    /// Lines of algebra, as they are.
    Formula(Vec<String>),
    /// Lines of algebra with what was added to them marked.
    Marked(Vec<MarkedLine>),
    /// Names and values.
    Facts(Vec<(String, String)>),
    /// One thing by itself: its name, and names and values about it.
    Card {
        /// Its name.
        heading: String,
        /// How it sounds.
        tone: Tone,
        /// Names and values.
        facts: Vec<(String, String)>,
    },
    /// A table.
    Table(Table),
    /// Figures; several stand side by side where there is room.
    Figures(Vec<Figure>),
}

/// A line of algebra: what stood there, and what was added.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MarkedLine {
    /// What stood there.
    pub kept: String,
    /// What was added; may be empty.
    pub added: String,
}

/// How a verdict or a row sounds; what is not in order weighs most.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Tone {
    /// In order.
    Good,
    /// Neither good nor bad.
    #[default]
    Plain,
    /// Worth a look.
    Caution,
    /// Rejected, or missing.
    Bad,
}

impl Tone {
    /// The word that goes before a verdict, so that it needs no colour.
    pub(crate) fn word(self, lang: Language) -> &'static str {
        match self {
            Tone::Plain => say!(lang, "note"),
            Tone::Good => say!(lang, "tone-good"),
            Tone::Caution => say!(lang, "tone-caution"),
            Tone::Bad => say!(lang, "tone-bad"),
        }
    }
}

/// A figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// What it shows, and how to read it.
    pub caption: String,
    /// The same for those who cannot see it: what is in it, in words.
    pub description: String,
    /// Its chart.
    pub chart: Chart,
    /// As wide as the page (else half of it).
    pub wide: bool,
}

impl Figure {
    /// A figure whose caption says in words what it shows.
    pub(crate) fn new(caption: impl Into<String>, chart: Chart, wide: bool) -> Self {
        let caption = caption.into();
        Figure { description: caption.clone(), caption, chart, wide }
    }

    /// The same with words of their own for those who cannot see it.
    pub(crate) fn described(self, description: String) -> Self {
        Figure { description, ..self }
    }
}

impl Document {
    /// An empty document.
    pub fn new(title: impl Into<String>) -> Self {
        Document { title: title.into(), ..Document::default() }
    }

    /// Add a fact.
    pub(crate) fn fact(mut self, name: impl Into<String>, value: impl Into<String>) -> Self {
        self.facts.push((name.into(), value.into()));
        self
    }

    /// Add facts.
    pub fn facts(mut self, facts: impl IntoIterator<Item = (String, String)>) -> Self {
        self.facts.extend(facts);
        self
    }

    /// Add a section, unless it is empty.
    pub fn section(mut self, mut section: Section) -> Self {
        if section.blocks.is_empty() {
            return self;
        }
        if !self.anchors.insert(section.anchor.clone()) {
            section.anchor = format!("{}-{}", section.anchor, self.sections.len() + 1);
            self.anchors.insert(section.anchor.clone());
        }
        section.settle();
        self.sections.push(section);
        self
    }
}

impl Section {
    /// Verdicts that are not in order come before the others; with a bad verdict, no other is called good. A column in which no row has anything is
    /// left out.
    fn settle(&mut self) {
        let tone = |block: &Block| match &block.content {
            Content::Verdict { tone, .. } => Some(*tone),
            _ => None,
        };
        let bad = self.blocks.iter().any(|block| tone(block) == Some(Tone::Bad));
        for run in self.blocks.chunk_by_mut(|a, b| tone(a).is_some() && tone(b).is_some()) {
            run.sort_by_key(|block| std::cmp::Reverse(tone(block)));
        }
        for block in &mut self.blocks {
            match &mut block.content {
                Content::Verdict { tone, .. } if bad && *tone == Tone::Good => *tone = Tone::Plain,
                Content::Table(table) => table.settle(),
                _ => {}
            }
        }
    }

    /// A section without blocks; a document leaves such a section out.
    pub fn new(heading: impl Into<String>) -> Self {
        let heading = heading.into();
        let letters = heading.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' });
        let anchor = letters.collect::<String>().trim_matches('-').to_string();
        Section { heading, anchor, blocks: Vec::new(), detail: Detail::Brief }
    }

    /// Add a block.
    pub(crate) fn block(mut self, content: Content) -> Self {
        self.blocks.push(Block { detail: self.detail, content });
        self
    }

    /// The blocks that follow appear on a page, and at a terminal with `-v`.
    pub fn full(mut self) -> Self {
        self.detail = Detail::Full;
        self
    }

    /// The blocks that follow appear everywhere.
    pub fn brief(mut self) -> Self {
        self.detail = Detail::Brief;
        self
    }

    /// The same, unless a reader asked for them.
    pub(crate) fn full_unless(self, asked: bool) -> Self {
        if asked { self } else { self.full() }
    }

    /// Add a paragraph, unless it is empty.
    pub fn prose(self, text: impl Into<String>) -> Self {
        let text = text.into();
        if text.is_empty() { self } else { self.block(Content::Prose(text)) }
    }

    /// Add each paragraph.
    pub(crate) fn proses(self, texts: impl IntoIterator<Item = String>) -> Self {
        texts.into_iter().fold(self, Section::prose)
    }

    /// Add a verdict.
    pub fn verdict(self, tone: Tone, text: impl Into<String>) -> Self {
        self.block(Content::Verdict { tone, text: text.into() })
    }

    /// Add each verdict.
    pub(crate) fn verdicts(self, all: impl IntoIterator<Item = (Tone, String)>) -> Self {
        all.into_iter().fold(self, |section, (tone, text)| section.verdict(tone, text))
    }

    /// Add points, unless there are none.
    pub fn list(self, points: impl IntoIterator<Item = String>) -> Self {
        let points: Vec<String> = points.into_iter().collect();
        if points.is_empty() { self } else { self.block(Content::List(points)) }
    }

    /// Add names and values, unless there are none.
    pub fn facts(self, facts: Vec<(String, String)>) -> Self {
        if facts.is_empty() { self } else { self.block(Content::Facts(facts)) }
    }

    /// Add a table, unless it has no rows.
    pub fn table(self, table: impl Into<Table>) -> Self {
        let table = table.into();
        if table.rows.is_empty() { self } else { self.block(Content::Table(table)) }
    }

    /// Add figures, unless there are none.
    pub fn figures(self, figures: impl IntoIterator<Item = Figure>) -> Self {
        let figures: Vec<Figure> = figures.into_iter().collect();
        if figures.is_empty() { self } else { self.block(Content::Figures(figures)) }
    }
}
