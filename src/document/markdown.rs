//! A document as Markdown: the same sections, tables with numbers point under point, figures as the words that describe them.

use super::wrap::columns;
use super::{Align, Cell, Content, Document, MarkedLine, Section, Table, Tone};
use crate::language::{Language, runs};
use crate::number;

/// A document as Markdown (CommonMark with tables).
///
/// ```
/// use tumble::document::{Document, Section, markdown};
/// let page = Document::new("A | page").section(Section::new("Result").prose("`V0` is <3"));
/// assert_eq!(markdown::render(&page), "# A \\| page\n\n## Result\n\n`V0` is \\<3\n");
/// ```
pub fn render(page: &Document) -> String {
    let mut parts = vec![format!("# {}", inline(&page.title))];
    if !page.subtitle.is_empty() {
        parts.push(inline(&page.subtitle));
    }
    parts.extend(facts(&page.facts));
    for section in &page.sections {
        parts.extend(self::section(section, page.language));
    }
    if !page.colophon.is_empty() {
        parts.push("---".into());
        parts.extend(facts(&page.colophon));
    }
    parts.join("\n\n") + "\n"
}

fn section(section: &Section, lang: Language) -> Vec<String> {
    let mut parts = vec![format!("## {}", inline(&section.heading))];
    for block in &section.blocks {
        match &block.content {
            Content::Prose(text) => parts.push(inline(text)),
            Content::Verdict { tone: Tone::Plain, text } => parts.push(format!("> {}", inline(text))),
            Content::Verdict { tone, text } => {
                parts.push(format!("> **{}** {}", lang.sentence(tone.word(lang)), inline(text)));
            }
            Content::List(points) => parts.push(joined(points.iter().map(|point| format!("- {}", inline(point))))),
            Content::Formula(lines) => parts.push(joined(lines.iter().map(|line| format!("    {}", one_line(line))))),
            Content::Marked(lines) => {
                parts.push(joined(lines.iter().flat_map(marked).map(|line| format!("    {line}"))));
            }
            Content::Facts(list) => parts.extend(facts(list)),
            Content::Card { heading, facts: list, .. } => {
                parts.push(format!("### {}", inline(heading)));
                parts.extend(facts(list));
            }
            Content::Table(table) => parts.extend(self::table(table)),
            Content::Figures(figures) => {
                parts.extend(figures.iter().filter(|f| !f.description.is_empty()).map(|f| inline(&f.description)));
            }
        }
    }
    parts
}

fn joined(lines: impl Iterator<Item = String>) -> String {
    lines.collect::<Vec<_>>().join("\n")
}

/// A line, and under what was added to it a row of carets.
fn marked(line: &MarkedLine) -> Vec<String> {
    let (kept, added) = (one_line(&line.kept), one_line(&line.added));
    let mut lines = vec![format!("{kept}{added}")];
    if !added.is_empty() {
        lines.push(format!("{}{}", " ".repeat(kept.chars().count()), "^".repeat(added.chars().count())));
    }
    lines
}

/// A bar of at most eight signs, from -1 to 1.
pub(super) fn bar(cell: &str) -> String {
    // a bar's cell is the number of its length; any other has no bar
    let share = cell.parse::<f64>().unwrap_or(0.0).clamp(-1.0, 1.0);
    let sign = if share < 0.0 { "-" } else { "+" };
    sign.repeat(number::count((8.0 * share.abs()).round()))
}

fn facts(list: &[(String, String)]) -> Option<String> {
    let line = |(name, value): &(String, String)| match name.as_str() {
        "" => format!("- {}", inline(value)),
        name => format!("- {}: {}", inline(name), inline(value)),
    };
    let lines: Vec<String> = list.iter().map(line).collect();
    (!lines.is_empty()).then(|| lines.join("\n"))
}

fn table(table: &Table) -> Vec<String> {
    let mut parts = Vec::new();
    if !table.caption.is_empty() {
        parts.push(inline(&table.caption));
    }
    let titles: Vec<String> = table.columns.iter().map(|c| inline(&c.title)).collect();
    let rows: Vec<Vec<String>> = table
        .rows
        .iter()
        .map(|row| {
            let mark = match row.tone {
                Tone::Bad => " \u{2717}",
                Tone::Caution => " \u{25b3}",
                _ => "",
            };
            let is_bar = |k: usize| table.columns.get(k).is_some_and(|c| c.align == Align::Bar);
            let text = |k: usize, cell: &Cell| if is_bar(k) { bar(&cell.text()) } else { inline(&cell.text()) };
            let cell = |k: usize| row.cells.get(k).map(|cell| text(k, cell)).unwrap_or_default();
            let first = match row.link.as_str() {
                "" => cell(0),
                link => format!("[{}]({link})", cell(0)),
            };
            (0..titles.len()).map(|k| if k == 0 { first.clone() + mark } else { cell(k) }).collect()
        })
        .collect();
    let width = |k: usize| {
        let cells = rows.iter().filter_map(|row| row.get(k)).map(|cell| columns(cell));
        cells.chain(titles.get(k).map(|t| columns(t))).max().unwrap_or(0).max(3)
    };
    let room = |k: usize, cell: &str| " ".repeat(width(k).saturating_sub(columns(cell)));
    let line = |cells: &[String]| {
        let padded: Vec<String> = cells
            .iter()
            .enumerate()
            .map(|(k, cell)| match table.columns.get(k).map(|c| c.align) {
                Some(Align::Left | Align::Bar) | None => format!("{cell}{}", room(k, cell)),
                Some(_) => format!("{}{cell}", room(k, cell)),
            })
            .collect();
        format!("| {} |", padded.join(" | "))
    };
    let rules: Vec<String> = (0..titles.len())
        .map(|k| match table.columns.get(k).map(|c| c.align) {
            Some(Align::Left | Align::Bar) | None => "-".repeat(width(k)),
            Some(_) => "-".repeat(width(k) - 1) + ":",
        })
        .collect();
    let mut lines = vec![line(&titles), format!("| {} |", rules.join(" | "))];
    lines.extend(rows.iter().map(|row| line(row)));
    parts.push(lines.join("\n"));
    if !table.note.is_empty() {
        parts.push(inline(&table.note));
    }
    parts
}

/// Escape what markdown would take for markup, outside code; code stands between more backticks than it has.
fn inline(text: &str) -> String {
    let run = |(is_code, run): (bool, String)| match (is_code, run.contains('`')) {
        (false, _) => plain(&run),
        (true, false) => format!("`{}`", run.replace('|', "\\|")),
        (true, true) => format!("``` {} ```", run.replace('|', "\\|")),
    };
    runs(&one_line(text)).into_iter().map(run).collect()
}

fn plain(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let letters: Vec<char> = text.chars().collect();
    for (k, c) in letters.iter().enumerate() {
        let inside_word = |k: usize| letters.get(k).is_some_and(|c| c.is_alphanumeric());
        let markup = match c {
            '\\' | '`' | '*' | '|' | '<' | '[' | ']' => true,
            // an underscore inside a word is no emphasis
            '_' => !(k > 0 && inside_word(k - 1) && inside_word(k + 1)),
            '#' => k == 0,
            _ => false,
        };
        if markup {
            out.push('\\');
        }
        out.push(*c);
    }
    out
}

fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
