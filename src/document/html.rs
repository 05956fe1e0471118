//! A document as one self-contained HTML file, for the screen and for print: no network, no script. Every text is escaped. Terms in headings and
//! columns lead to their definitions at the end of the page.

use super::escape::{bar, escape, inline};
use super::glossary::Terms;
use super::wrap::columns;
use super::{Align, Cell, Content, Document, Figure, Row, Table, Tone, plot};
use crate::error::Result;
use crate::language::Language;

const STYLE: &str = include_str!("../../data/templates/page.css");

/// Pages of more sections than this have links to them: fewer are seen at once. Nothing else depends on it.
const LINKED: usize = 3;

/// A document as one HTML file.
///
/// Errors: none that a page can cause; a chart that cannot be drawn is reported as `Value`.
///
/// ```
/// use tumble::document::{Document, Section, html::render};
/// let page = Document::new("A <b> page").section(Section::new("Result").prose("`V0` is 3 < 4"));
/// let html = render(&page)?;
/// assert!(html.contains("A &lt;b&gt; page") && html.contains(">V0</code> is 3 &lt; 4"));
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn render(document: &Document) -> Result<String> {
    let lang = document.language;
    let title = escape(&document.title);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"{}\">\n<head>\n<meta charset=\"utf-8\">\n\
        <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
        <meta name=\"color-scheme\" content=\"light dark\">\n<meta name=\"generator\" content=\"tumble\">\n\
        <title>{title}</title>\n<style>\n{STYLE}\n</style>\n</head>\n<body>\n<header>\n<h1>{}</h1>\n",
        lang.tag(),
        inline(&document.title)
    );
    if !document.subtitle.is_empty() {
        page.push_str(&format!("<p class=\"subtitle\">{}</p>\n", inline(&document.subtitle)));
    }
    page.push_str(&format!("{}</header>\n", facts(&document.facts)));
    if document.sections.len() > LINKED {
        let link = |s: &super::Section| format!("<a href=\"#{}\">{}</a>\n", escape(&s.anchor), inline(&s.heading));
        page.push_str(&format!("<nav>\n{}</nav>\n", document.sections.iter().map(link).collect::<String>()));
    }
    page.push_str("<main>\n");
    let mut terms = Terms::new(lang);
    for section in &document.sections {
        let heading = terms.title(&section.heading);
        page.push_str(&format!("<section id=\"{}\">\n<h2>{heading}</h2>\n", escape(&section.anchor)));
        for block in &section.blocks {
            page.push_str(&content(&block.content, &mut terms, lang)?);
        }
        page.push_str("</section>\n");
    }
    page.push_str("</main>\n");
    page.push_str(&terms.definitions());
    if !document.colophon.is_empty() {
        page.push_str(&format!("<footer>\n{}</footer>\n", facts(&document.colophon)));
    }
    page.push_str("</body>\n</html>\n");
    Ok(page)
}

fn content(content: &Content, terms: &mut Terms, lang: Language) -> Result<String> {
    Ok(match content {
        Content::Prose(text) => format!("<p>{}</p>\n", inline(text)),
        Content::Verdict { tone, text } => {
            let word = escape(&lang.sentence(tone.word(lang)));
            format!("<p class=\"verdict {}\" data-word=\"{word}\">{}</p>\n", class(*tone), inline(text))
        }
        Content::List(points) => {
            let points: String = points.iter().map(|point| format!("<li>{}</li>\n", inline(point))).collect();
            format!("<ul>\n{points}</ul>\n")
        }
        Content::Formula(lines) => formula(lines.iter().map(|line| escape(line))),
        Content::Marked(lines) => formula(lines.iter().map(|line| match line.added.as_str() {
            "" => escape(&line.kept),
            added => format!("{}<mark>{}</mark>", escape(&line.kept), escape(added)),
        })),
        Content::Facts(list) => facts(list),
        Content::Card { heading, tone, facts: list } => {
            format!("<div class=\"card {}\">\n<h3>{}</h3>\n{}</div>\n", class(*tone), inline(heading), facts(list))
        }
        Content::Table(t) => table(t, terms),
        Content::Figures(figures) => {
            let figures = figures.iter().map(|f| figure(f, lang)).collect::<Result<String>>()?;
            format!("<div class=\"figures\">\n{figures}</div>\n")
        }
    })
}

fn class(tone: Tone) -> &'static str {
    match tone {
        Tone::Plain => "plain",
        Tone::Good => "good",
        Tone::Caution => "caution",
        Tone::Bad => "bad",
    }
}

fn formula(lines: impl Iterator<Item = String>) -> String {
    format!("<pre class=\"formula\">{}</pre>\n", lines.map(|line| line + "\n").collect::<String>())
}

fn facts(list: &[(String, String)]) -> String {
    let fact =
        |(name, value): &(String, String)| format!("<div><dt>{}</dt><dd>{}</dd></div>\n", inline(name), inline(value));
    if list.is_empty() { String::new() } else { format!("<dl>\n{}</dl>\n", list.iter().map(fact).collect::<String>()) }
}

fn figure(figure: &Figure, lang: Language) -> Result<String> {
    let wide = if figure.wide { " class=\"wide\"" } else { "" };
    let (description, drawn) = (escape(&figure.description), plot::draw(&figure.chart, lang)?);
    let caption = inline(&figure.caption);
    Ok(format!(
        "<figure{wide}>\n<div role=\"img\" aria-label=\"{description}\">{drawn}</div>\n<figcaption>{caption}</figcaption>\n</figure>\n"
    ))
}

fn table(table: &Table, terms: &mut Terms) -> String {
    let mut table = table.clone();
    table.typeset();
    let align = |align: Align| match align {
        Align::Left => "left",
        Align::Right => "right",
        Align::Decimal => "decimal",
        Align::Bar => "bar",
    };
    // a cell wider than so many letters may be broken on a narrow screen
    let long = 28;
    let cell = |row: &Row, k: usize, column: Align| {
        // cells that were typeset are texts
        let text = row.cells.get(k).map(Cell::text).unwrap_or_default();
        let words = if columns(&text) > long { " words" } else { "" };
        let inner = match column {
            Align::Bar => bar(&text),
            _ if k == 0 && !row.link.is_empty() => {
                format!("<a href=\"{}\">{}</a>", escape(&row.link), inline(&text))
            }
            _ => inline(&text),
        };
        format!("<td class=\"{}{words}\">{inner}</td>", align(column))
    };
    let row = |row: &Row| {
        let cells: String = table.columns.iter().enumerate().map(|(k, column)| cell(row, k, column.align)).collect();
        format!("<tr class=\"{}{}\">{cells}</tr>\n", class(row.tone), if row.rule { " rule" } else { "" })
    };
    let small = if table.small { " class=\"small\"" } else { "" };
    let mut text = format!("<div class=\"scroll\">\n<table{small}>\n");
    if !table.caption.is_empty() {
        text.push_str(&format!("<caption>{}</caption>\n", inline(&table.caption)));
    }
    let title = |column: &super::Column| {
        format!("<th scope=\"col\" class=\"{}\">{}</th>\n", align(column.align), terms.title(&column.title))
    };
    let titles: String = table.columns.iter().map(title).collect();
    let rows: String = table.rows.iter().map(row).collect();
    text.push_str(&format!("<thead><tr>\n{titles}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n</div>\n"));
    if !table.note.is_empty() {
        text.push_str(&format!("<p class=\"note\">{}</p>\n", inline(&table.note)));
    }
    text
}
