//! What a page is made of.

use crate::language::{Language, say};
use serde::Serialize;

/// A page: what it is about, and its sections.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Page {
    /// Heading of the page and title of the document.
    pub title: String,
    /// One line under the title.
    pub subtitle: String,
    /// What the page is about, as names and values, beside the title.
    pub facts: Vec<(String, String)>,
    /// The sections, in order.
    pub sections: Vec<Section>,
    /// The language of its texts.
    #[serde(skip)]
    pub language: Language,
    /// Version, inputs and their digests, at the end.
    pub colophon: Vec<(String, String)>,
}

/// A heading and what stands under it.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Section {
    /// Heading.
    pub heading: String,
    /// Anchor, made from the heading.
    pub anchor: String,
    /// Blocks, in order.
    pub blocks: Vec<PageBlock>,
}

/// One block of a section. In every text a pair of backticks sets a name in code type.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", content = "is", rename_all = "lowercase")]
pub enum PageBlock {
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
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct MarkedLine {
    /// What stood there.
    pub kept: String,
    /// What was added; may be empty.
    pub added: String,
}

/// How a verdict or a row sounds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Tone {
    /// Neither good nor bad.
    #[default]
    Plain,
    /// In order.
    Good,
    /// Worth a look.
    Caution,
    /// Rejected, or missing.
    Bad,
}

impl Tone {
    /// The word that goes before a verdict, so that it needs no colour.
    pub fn word(self, lang: Language) -> &'static str {
        match self {
            Tone::Plain => say!(lang, "tone-plain"),
            Tone::Good => say!(lang, "tone-good"),
            Tone::Caution => say!(lang, "tone-caution"),
            Tone::Bad => say!(lang, "tone-bad"),
        }
    }
}

/// A table.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Table {
    /// What it shows; may be empty.
    pub caption: String,
    /// Columns.
    pub columns: Vec<Column>,
    /// Rows; a row shorter than the columns ends in empty cells.
    pub rows: Vec<Row>,
    /// A remark under it; may be empty.
    pub note: String,
    /// Set small: for long tables.
    pub small: bool,
}

/// A column.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Column {
    /// Title.
    pub title: String,
    /// Alignment.
    pub align: Align,
}

/// Alignment of a column.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Align {
    /// Words, to the left.
    #[default]
    Left,
    /// To the right.
    Right,
    /// Numbers, at the decimal point.
    Decimal,
    /// Numbers from -1 to 1 as bars about a middle line.
    Bar,
}

/// A row.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Row {
    /// Cells.
    pub cells: Vec<String>,
    /// How it sounds.
    pub tone: Tone,
    /// Set off from the rows before it by a rule.
    pub rule: bool,
    /// Where its first cell leads; empty for nowhere.
    pub link: String,
}

/// A figure.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Figure {
    /// What it shows, and how to read it.
    pub caption: String,
    /// The same for those who cannot see it: what is in it, in words.
    pub description: String,
    /// Inline SVG from `report::plot`. The only text that is not escaped.
    pub svg: String,
    /// As wide as the page (else half of it).
    pub wide: bool,
}

impl Page {
    /// An empty page.
    pub fn new(title: impl Into<String>) -> Self {
        Page { title: title.into(), ..Page::default() }
    }

    /// Add a section, unless it is empty.
    pub fn section(mut self, mut section: Section) -> Self {
        if section.blocks.is_empty() {
            return self;
        }
        let taken = |anchor: &str| self.sections.iter().any(|s| s.anchor == anchor);
        if taken(&section.anchor) {
            section.anchor = format!("{}-{}", section.anchor, self.sections.len() + 1);
        }
        self.sections.push(section);
        self
    }

    /// The page with its columns of numbers padded to stand point under point.
    pub(super) fn aligned(mut self) -> Self {
        for section in &mut self.sections {
            for block in &mut section.blocks {
                if let PageBlock::Table(table) = block {
                    table.align_numbers();
                }
            }
        }
        self
    }
}

impl Section {
    /// Beside a verdict that is bad, nothing is called good.
    pub(super) fn without_praise(&mut self) {
        let tones = || {
            self.blocks.iter().filter_map(|block| match block {
                PageBlock::Verdict { tone, .. } => Some(*tone),
                _ => None,
            })
        };
        if tones().all(|tone| tone != Tone::Bad) {
            return;
        }
        for block in &mut self.blocks {
            if let PageBlock::Verdict { tone, .. } = block
                && *tone == Tone::Good
            {
                *tone = Tone::Plain;
            }
        }
    }

    /// A section without blocks; a page leaves such a section out.
    pub fn new(heading: impl Into<String>) -> Self {
        let heading = heading.into();
        let letters = heading.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' });
        let anchor = letters.collect::<String>().trim_matches('-').to_string();
        Section { heading, anchor, blocks: Vec::new() }
    }

    /// Add a block.
    pub fn block(mut self, block: PageBlock) -> Self {
        self.blocks.push(block);
        self
    }

    /// Add a paragraph, unless it is empty.
    pub fn prose(self, text: impl Into<String>) -> Self {
        let text = text.into();
        if text.is_empty() { self } else { self.block(PageBlock::Prose(text)) }
    }

    /// Add a verdict.
    pub fn verdict(self, tone: Tone, text: impl Into<String>) -> Self {
        self.block(PageBlock::Verdict { tone, text: text.into() })
    }

    /// Add points, unless there are none.
    pub fn list(self, points: Vec<String>) -> Self {
        if points.is_empty() { self } else { self.block(PageBlock::List(points)) }
    }

    /// Add a table, unless it has no rows.
    pub fn table(self, table: Table) -> Self {
        if table.rows.is_empty() { self } else { self.block(PageBlock::Table(table)) }
    }

    /// Add figures, unless there are none.
    pub fn figures(self, figures: Vec<Figure>) -> Self {
        if figures.is_empty() { self } else { self.block(PageBlock::Figures(figures)) }
    }
}

impl Table {
    /// A table of columns and no rows yet: titles, each with its alignment.
    pub fn new(columns: &[(&str, Align)]) -> Self {
        let columns = columns.iter().map(|(title, align)| Column { title: (*title).to_string(), align: *align });
        Table { columns: columns.collect(), ..Table::default() }
    }

    /// Add a row.
    pub fn row(&mut self, cells: Vec<String>) -> &mut Self {
        self.rows.push(Row { cells, ..Row::default() });
        self
    }

    /// The first cell of the last row leads to a page, where there is one.
    pub fn link(&mut self, to: Option<&String>) -> &mut Self {
        if let (Some(row), Some(to)) = (self.rows.last_mut(), to) {
            row.link.clone_from(to);
        }
        self
    }

    /// True minus signs in columns of numbers; decimal ones are padded with figure spaces, so that they stand point under point.
    fn align_numbers(&mut self) {
        const FIGURE_SPACE: char = '\u{2007}';
        const POINT_SPACE: char = '\u{2008}';
        for (k, column) in self.columns.iter().enumerate() {
            if matches!(column.align, Align::Left | Align::Bar) {
                continue;
            }
            let decimals = |cell: &str| cell.split_once('.').map_or(0, |(_, digits)| digits.chars().count());
            let deepest = self.rows.iter().filter_map(|row| row.cells.get(k)).map(|c| decimals(c)).max().unwrap_or(0);
            for cell in self.rows.iter_mut().filter_map(|row| row.cells.get_mut(k)) {
                if !cell.contains(|c: char| c.is_ascii_digit()) {
                    continue;
                }
                if let Some(size) = cell.strip_prefix('-').filter(|size| !size.is_empty()) {
                    *cell = format!("\u{2212}{size}");
                }
                if column.align == Align::Right {
                    continue;
                }
                let own = decimals(cell);
                if own == 0 && deepest > 0 {
                    cell.push(POINT_SPACE);
                }
                cell.extend(std::iter::repeat_n(FIGURE_SPACE, deepest - own));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_point_under_point() {
        let mut table = Table::new(&[("u", Align::Decimal)]);
        table.row(vec!["-1.25".into()]).row(vec!["30".into()]).row(vec!["-".into()]).row(vec![]);
        table.align_numbers();
        let cell = |k: usize| table.rows[k].cells[0].as_str();
        assert_eq!((cell(0), cell(1)), ("\u{2212}1.25", "30\u{2008}\u{2007}\u{2007}"));
        assert_eq!(cell(2), "-");
    }

    #[test]
    fn anchors_are_plain_and_distinct() {
        let page = Page::new("p")
            .section(Section::new("A & b").prose("x"))
            .section(Section::new("A & b").prose("y"))
            .section(Section::new("empty"));
        let anchors: Vec<&str> = page.sections.iter().map(|s| s.anchor.as_str()).collect();
        assert_eq!(anchors, ["a---b", "a---b-2"]);
    }
}
