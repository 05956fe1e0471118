//! A document for a person at a terminal of 80 columns.

use super::wrap::{self, WIDTH};
use super::{Align, Cell, Content, Detail, Document, MarkedLine, Section, Tone, markdown};
use crate::language::{Language, bare, say};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};

/// A document as the program prints it: what appears at this detail. Of rows that are left out it says which option shows them.
pub fn render(document: &Document, detail: Detail) -> String {
    whole(document, Shown { detail, lang: document.language, has_options: true })
}

/// How a document is shown.
#[derive(Clone, Copy)]
struct Shown {
    detail: Detail,
    lang: Language,
    /// Can the reader ask for more by an option of the program?
    has_options: bool,
}

fn whole(document: &Document, shown: Shown) -> String {
    let Shown { detail, lang, .. } = shown;
    let mut parts = Vec::new();
    let mut head = line(&document.title);
    if detail >= Detail::Full && !document.subtitle.is_empty() {
        head.push_str(&line(&document.subtitle));
    }
    head.push_str(&facts(&document.facts, lang));
    parts.push(head);
    parts.extend(document.sections.iter().filter_map(|section| within(section, shown)));
    parts.join("\n")
}

/// A document in short, for a reader who has no options: a value that is printed in Rust or Python.
pub fn brief(document: &Document) -> String {
    whole(document, Shown { detail: Detail::Brief, lang: document.language, has_options: false })
}

fn within(section: &Section, shown: Shown) -> Option<String> {
    let blocks = section.blocks.iter().filter(|block| block.detail <= shown.detail);
    let texts: Vec<(bool, String)> = blocks
        .map(|block| {
            let is_apart = matches!(block.content, Content::Table(_) | Content::Card { .. });
            (is_apart, content(&block.content, shown))
        })
        .filter(|(_, text)| !text.is_empty())
        .collect();
    if texts.is_empty() {
        return None;
    }
    let mut text = bare(&section.heading).to_uppercase() + "\n";
    let mut before = false;
    for (k, (is_apart, block)) in texts.iter().enumerate() {
        // a table and a card stand by themselves
        if k > 0 && (*is_apart || before) {
            text.push('\n');
        }
        text.push_str(block);
        before = *is_apart;
    }
    Some(text)
}

/// A sentence that goes on below its beginning.
fn line(text: &str) -> String {
    wrap::hanging(&bare(text), 2) + "\n"
}

fn content(content: &Content, shown: Shown) -> String {
    let Shown { detail, lang, .. } = shown;
    match content {
        Content::Prose(text) | Content::Verdict { tone: Tone::Plain, text } => line(text),
        Content::Verdict { tone, text } => line(&format!("{}{}{text}", tone.word(lang), lang.colon())),
        Content::List(points) => points.iter().map(|point| line(&format!("- {point}"))).collect(),
        Content::Formula(lines) => lines.iter().map(|line| wrap::hanging(&format!("  {line}"), 4) + "\n").collect(),
        Content::Marked(lines) => lines.iter().map(marked).collect(),
        Content::Facts(list) => facts(list, lang),
        Content::Card { heading, tone, facts: list } => {
            let mark = mark(*tone);
            format!("{}{mark}\n{}", bare(heading), facts(list, lang))
        }
        Content::Table(t) => table(t, shown),
        Content::Figures(_) if detail < Detail::Full => String::new(),
        Content::Figures(figures) => figures.iter().map(|figure| line(&figure.description)).collect(),
    }
}

/// A line of algebra with carets below what was added, wherever it breaks.
fn marked(line: &MarkedLine) -> String {
    let mut kept = line.kept.chars().filter(|c| !c.is_whitespace()).count();
    let mut text = String::new();
    for row in wrap::hanging(&format!("  {}{}", line.kept, line.added), 4).lines() {
        let mut below = String::new();
        for c in row.chars() {
            let is_added = kept == 0 && !c.is_whitespace();
            kept = kept.saturating_sub(usize::from(!c.is_whitespace()));
            below.push(if is_added { '^' } else { ' ' });
        }
        text.push_str(&format!("{row}\n"));
        if !below.trim_end().is_empty() {
            text.push_str(&format!("{}\n", below.trim_end()));
        }
    }
    text
}

/// Names and values; a value without a name goes on with the one before it.
fn facts(list: &[(String, String)], lang: Language) -> String {
    let fact = |(name, value): &(String, String)| {
        let name = if name.is_empty() { String::new() } else { format!("{name}{}", lang.colon()) };
        wrap::hanging(&bare(&format!("  {name}{value}")), 4) + "\n"
    };
    list.iter().map(fact).collect()
}

/// A table by itself.
pub(crate) fn alone(rows: impl Into<super::Table>, lang: Language) -> String {
    table(&rows.into(), Shown { detail: Detail::Brief, lang, has_options: true })
}

fn table(table: &super::Table, Shown { detail, lang, has_options }: Shown) -> String {
    let most = table.brief_rows.filter(|_| detail < Detail::Full).unwrap_or(usize::MAX);
    let texts = |detail: Detail| -> (Vec<&super::Column>, Vec<Vec<String>>) {
        let shown: Vec<usize> =
            table.columns.iter().enumerate().filter(|(_, column)| column.detail <= detail).map(|(k, _)| k).collect();
        let cell = |row: &super::Row, k: usize| {
            let text = row.cells.get(k).map(Cell::text).unwrap_or_default();
            match table.columns.get(k).map(|column| column.align) {
                Some(Align::Bar) => markdown::bar(&text),
                _ if k == 0 => bare(&text) + mark(row.tone),
                _ => bare(&text),
            }
        };
        let rows = table.rows.iter().take(most).map(|row| shown.iter().map(|k| cell(row, *k)).collect()).collect();
        (shown.iter().filter_map(|k| table.columns.get(*k)).collect(), rows)
    };
    let (mut columns, mut rows) = texts(detail.max(Detail::Roomy));
    let widest = |(k, column): (usize, &&super::Column)| Column::of(k, &bare(&column.title), &rows, false).widest;
    let natural = columns.iter().enumerate().map(widest).sum::<usize>();
    if natural + columns.len().saturating_sub(1) > WIDTH {
        (columns, rows) = texts(detail);
    }
    let titles: Vec<String> = columns.iter().map(|column| bare(&column.title)).collect();
    let right: Vec<bool> = columns.iter().map(|column| !matches!(column.align, Align::Left | Align::Bar)).collect();
    let titles: Vec<&str> = titles.iter().map(String::as_str).collect();
    let mut text = if table.caption.is_empty() { String::new() } else { line(&table.caption) };
    text.push_str(&set(&titles, &rows, &right));
    if table.rows.len() > most {
        let n = table.rows.len() - most;
        let more = say!(lang, "more-rows", n, option = has_options);
        text.push_str(&(more + "\n"));
    }
    if detail >= Detail::Full && !table.note.is_empty() {
        text.push_str(&line(&table.note));
    }
    text
}

/// What marks a row that is not in order.
fn mark(tone: Tone) -> &'static str {
    match tone {
        Tone::Bad | Tone::Caution => " !",
        Tone::Plain | Tone::Good => "",
    }
}

/// Spaces between two columns, and where the table would be too wide.
const GAPS: [usize; 2] = [2, 1];

/// A table without frame: a header, a rule, rows. A table wider than the line stands closer, breaks its columns of text at spaces and, where that does not
/// suffice, continues below, beside the columns that name its rows.
fn set(header: &[&str], rows: &[Vec<String>], right: &[bool]) -> String {
    let right = |k: usize| right.get(k).copied().unwrap_or_default();
    let columns: Vec<Column> =
        header.iter().enumerate().map(|(k, title)| Column::of(k, title, rows, right(k))).collect();
    let all: Vec<usize> = (0..columns.len()).collect();
    for size in [|column: &Column| column.widest, |column: &Column| column.least] {
        let size: usize = columns.iter().map(size).sum();
        let fits = |gap: &usize| size + gap * columns.len().saturating_sub(1) <= WIDTH;
        if let Some(gap) = GAPS.into_iter().find(fits) {
            return framed(&columns, &all, gap, header, rows);
        }
    }
    let blocks = blocks(&columns);
    let part = |(k, block): (usize, &Vec<usize>)| {
        // below the first part a row that has nothing there says nothing
        let says = |row: &&Vec<String>| {
            let has_text = |c: &usize| row.get(*c).is_some_and(|cell| !cell.is_empty());
            k == 0 || block.iter().filter(|c| blocks.first().is_none_or(|first| !first.contains(*c))).any(has_text)
        };
        let rows: Vec<Vec<String>> = rows.iter().filter(says).cloned().collect();
        framed(&columns, block, GAPS[0], header, &rows)
    };
    blocks.iter().enumerate().map(part).collect::<Vec<String>>().join("\n")
}

struct Column {
    numeric: bool,
    /// Characters of its longest cell.
    widest: usize,
    /// The same where its title breaks.
    below_title: usize,
    /// Characters below which it cannot go: its longest word, or the widest number.
    least: usize,
}

impl Column {
    fn of(k: usize, title: &str, rows: &[Vec<String>], numeric: bool) -> Self {
        let cells = || rows.iter().filter_map(move |row| row.get(k)).map(String::as_str);
        let size = wrap::columns;
        let word = |text: &str| wrap::pieces(text).map(size).max().unwrap_or(0);
        let widest = cells().map(size).max().unwrap_or(0).max(size(title));
        // a title breaks too, but a number does not
        let body = cells().map(|cell| if numeric { size(cell) } else { word(cell) }).max().unwrap_or(0);
        let below_title = cells().map(size).max().unwrap_or(0).max(word(title));
        Self { numeric, widest, below_title, least: body.max(word(title)) }
    }
}

/// The columns that stand beside one another; those of text before the first number name the row and stand in every block.
fn blocks(columns: &[Column]) -> Vec<Vec<usize>> {
    let texts = columns.iter().take_while(|column| !column.numeric).count();
    let widths = columns.iter().scan(0, |sum, column| {
        *sum += column.least + GAPS[0];
        Some(*sum)
    });
    let names = widths.take(texts).take_while(|sum| *sum <= WIDTH / 2).count().max(1);
    let width = |block: &[usize]| -> usize {
        block.iter().filter_map(|k| columns.get(*k)).map(|column| column.least + GAPS[0]).sum()
    };
    let mut blocks: Vec<Vec<usize>> = Vec::new();
    for (k, column) in columns.iter().enumerate() {
        match blocks.last_mut() {
            Some(block) if block.len() <= names || width(block) + column.least <= WIDTH => block.push(k),
            Some(_) => blocks.push((0..names).chain([k]).collect()),
            None => blocks.push(vec![k]),
        }
    }
    blocks
}

/// Widths within the line: titles break first, then the widest columns give way until the table fits.
fn widths(columns: &[Column], block: &[usize], gap: usize) -> Vec<usize> {
    let of_block: Vec<&Column> = block.iter().filter_map(|&k| columns.get(k)).collect();
    let mut widths: Vec<usize> = of_block.iter().map(|column| column.widest).collect();
    let room = WIDTH.saturating_sub(gap * block.len().saturating_sub(1));
    for floor in [|column: &Column| column.below_title, |column: &Column| column.least] {
        while widths.iter().sum::<usize>() > room {
            let above = widths.iter_mut().zip(&of_block).filter(|(width, column)| **width > floor(column));
            match above.max_by_key(|(width, _)| **width) {
                Some((width, _)) => *width -= 1,
                None => break,
            }
        }
    }
    widths
}

fn framed(columns: &[Column], block: &[usize], gap: usize, header: &[&str], rows: &[Vec<String>]) -> String {
    let widths = widths(columns, block, gap);
    // a block names columns of this table; a row may be shorter
    let within = |k: usize, cell: &str| wrap::narrow(cell, 0, widths.get(k).copied().unwrap_or(WIDTH));
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(block.iter().enumerate().map(|(k, &c)| within(k, header.get(c).copied().unwrap_or_default())));
    for row in rows {
        table.add_row(block.iter().enumerate().map(|(k, &c)| within(k, row.get(c).map_or("", String::as_str))));
    }
    for (k, column) in table.column_iter_mut().enumerate() {
        column.set_padding((if k == 0 { 0 } else { u16::try_from(gap).unwrap_or(u16::MAX).saturating_sub(1) }, 1));
        if block.get(k).and_then(|&c| columns.get(c)).is_some_and(|column| column.numeric) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let titles = block
        .iter()
        .enumerate()
        .map(|(k, &c)| within(k, header.get(c).copied().unwrap_or_default()).lines().count())
        .max()
        .unwrap_or(1);
    let mut text = String::new();
    for (k, line) in table.to_string().lines().enumerate() {
        text.push_str(line.trim_end());
        text.push('\n');
        if k + 1 == titles {
            let width = table.lines().map(|line| wrap::columns(line.trim_end())).max().unwrap_or(0);
            text.push_str(&"-".repeat(width));
            text.push('\n');
        }
    }
    text
}
