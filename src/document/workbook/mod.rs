//! A document as a workbook (.xlsx): one sheet a section, numbers as numbers with the digits that their uncertainty carries, figures as charts
//! of the workbook over their data.
//!
//! The bytes depend on the document alone. A defined name holds a digest of all cells, by which `is_untouched` tells a workbook that nobody
//! has changed since from one with somebody's work in it.

mod panel;

use super::chart::Chart;
use super::table::{Align, Cell, Row, Table};
use super::wrap::columns;
use super::{Content, Document, Figure, Section, Tone};
use crate::error::{Fault, Malformed, Result};
use crate::language::bare;
use crate::report::VERSION;
use panel::Panel;
use rust_xlsxwriter::{
    Color, ConditionalFormat3ColorScale, ConditionalFormatDataBar, ConditionalFormatType, DocProperties, ExcelDateTime,
    Format, FormatAlign, FormatBorder, Workbook, Worksheet, XlsxError,
};
use sha2::{Digest, Sha256};
use std::path::Path;

/// Columns over which a sentence runs.
const SENTENCE: u16 = 8;
/// Last column that is printed, where no table has more: those of a sentence, and of the widest chart.
const PRINTED: u16 = 10;
/// Widths of columns, in characters.
const WIDTHS: (f64, f64) = (11.0, 44.0);
/// Rows that a chart covers.
const CHART_ROWS: u32 = 20;
/// Columns that are seen of a sheet: those of the usual width, 64 pixels, fill a screen of 1920.
const SEEN: u16 = 30;
/// Letters of a sheet's name, by the format.
const NAME: usize = 31;
/// Characters that a cell holds, by the format.
const CELL: usize = 32_767;
/// Characters of an alternative text, by the format.
const ALT: usize = 255;
const MARK: &str = "tumble_digest";

/// A document as the bytes of a workbook.
///
/// Errors: a table with more rows than a sheet has (1,048,576).
///
/// ```
/// use tumble::document::{Cell, Document, Rows, Section, workbook};
/// let table = Rows::of(["V0"]).name("parameter", |id| id).decimal("estimate", |_| Cell::Value(1.58203, Some(0.0114)));
/// let bytes = workbook::render(&Document::new("A fit").section(Section::new("Result").table(table)))?;
/// assert!(bytes.starts_with(b"PK"));
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn render(document: &Document) -> Result<Vec<u8>> {
    write(document).map_err(|error| {
        Malformed::new(Fault::Value, format!("the workbook cannot be written: {error}"))
            .expected("tables that a workbook can hold")
    })
}

fn write(document: &Document) -> std::result::Result<Vec<u8>, XlsxError> {
    let mut workbook = Workbook::new();
    let day = ExcelDateTime::from_ymd(2000, 1, 1)?;
    let program = format!("tumble {VERSION}");
    let properties = DocProperties::new().set_title(&document.title).set_author(&program).set_creation_datetime(&day);
    workbook.set_properties(&properties);
    let (mut names, mut cells) = (Vec::new(), Vec::new());
    let last = document.sections.len().saturating_sub(1);
    for (k, section) in document.sections.iter().enumerate() {
        let name = sheet_name(&section.heading, k, &names);
        let mut sheet = Sheet::new(workbook.add_worksheet(), name.clone(), data_from(section))?;
        if k == 0 {
            sheet.line(&document.title, &Format::new().set_bold().set_font_size(16))?;
            sheet.line(&document.subtitle, &Format::new().set_italic())?;
            sheet.facts(&document.facts)?;
        }
        sheet.line(&section.heading, &Format::new().set_bold().set_font_size(13))?;
        for block in &section.blocks {
            sheet.block(&block.content, document)?;
        }
        if k == last {
            sheet.facts(&document.colophon)?;
        }
        sheet.widths()?;
        cells.append(&mut sheet.cells);
        names.push(name);
    }
    if names.is_empty() {
        workbook.add_worksheet();
    }
    workbook.define_name(MARK, &format!("=\"{}\"", digest(cells)))?;
    workbook.save_to_buffer()
}

/// Has nobody changed a cell of a workbook since this program wrote it?
pub(crate) fn is_untouched(path: &Path) -> bool {
    use calamine::{Data, Reader, Xlsx, open_workbook};
    let Ok(mut workbook) = open_workbook::<Xlsx<_>, _>(path) else { return false };
    let mark = workbook.defined_names().iter().find(|(name, _)| name == MARK).map(|(_, value)| value.clone());
    let Some(mark) = mark else { return false };
    let mut cells = Vec::new();
    for name in workbook.sheet_names() {
        let Ok(range) = workbook.worksheet_range(&name) else { return false };
        let (top, left) = range.start().unwrap_or_default();
        for (row, column, value) in range.used_cells() {
            let text = match value {
                Data::Float(value) => number_text(*value),
                Data::String(text) => text.clone(),
                other => other.to_string(),
            };
            cells.push(cell_text(&name, u64::from(top) + row as u64, u64::from(left) + column as u64, &text));
        }
    }
    mark.trim_matches(['=', '"']) == digest(cells)
}

fn number_text(value: f64) -> String {
    format!("{:016x}", value.to_bits())
}

fn cell_text(sheet: &str, row: u64, column: u64, text: &str) -> String {
    format!("{sheet}\u{1f}{row}\u{1f}{column}\u{1f}{text}")
}

fn digest(mut cells: Vec<String>) -> String {
    cells.sort_unstable();
    let mut sum = Sha256::new();
    for cell in cells {
        sum.update(cell.as_bytes());
        sum.update([0x1e]);
    }
    sum.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A heading as the name of a sheet: what the format allows, and no name twice.
fn sheet_name(heading: &str, number: usize, taken: &[String]) -> String {
    let allowed = |c: char| if matches!(c, '[' | ']' | ':' | '*' | '?' | '/' | '\\' | '\'') { ' ' } else { c };
    let plain: String = heading.chars().map(allowed).filter(|c| !c.is_control()).collect();
    let cut = |text: &str, most: usize| text.chars().take(most).collect::<String>().trim().to_string();
    let name = cut(&plain, NAME);
    let is_taken = |name: &str| taken.iter().any(|other| other.to_lowercase() == name.to_lowercase());
    // the format keeps "History" for itself
    match name.is_empty() || is_taken(&name) || name.eq_ignore_ascii_case("history") {
        true => format!("{} {}", cut(&plain, NAME - 6), number + 1),
        false => name,
    }
}

/// First column of the data of charts: beside all tables of a section, and beside what is seen of a sheet.
fn data_from(section: &Section) -> u16 {
    let wide = |content: &Content| match content {
        Content::Table(table) => table.columns.len(),
        Content::Figures(figures) => figures
            .iter()
            .map(|figure| match &figure.chart {
                Chart::Correlation(names, _) => names.len() + 1,
                _ => 0,
            })
            .max()
            .unwrap_or(0),
        _ => 0,
    };
    let widest = section.blocks.iter().map(|block| wide(&block.content)).max().unwrap_or(0);
    u16::try_from(widest + 1).unwrap_or(u16::MAX).max(SEEN)
}

struct Sheet<'a> {
    sheet: &'a mut Worksheet,
    name: String,
    row: u32,
    /// Width that the cells of each column ask for.
    wide: Vec<f64>,
    /// What was written, for the digest.
    cells: Vec<String>,
    /// Column from which the data of charts stand, beside what is read.
    data: u16,
}

impl<'a> Sheet<'a> {
    fn new(sheet: &'a mut Worksheet, name: String, data: u16) -> std::result::Result<Self, XlsxError> {
        sheet.set_name(&name)?.set_landscape().set_paper_size(9).set_print_fit_to_pages(1, 0);
        Ok(Sheet { sheet, name, row: 0, wide: Vec::new(), cells: Vec::new(), data })
    }

    fn text(&mut self, row: u32, column: u16, text: &str, format: &Format) -> std::result::Result<(), XlsxError> {
        let plain: String = bare(text).chars().take(CELL).collect();
        if plain.is_empty() {
            self.sheet.write_blank(row, column, format)?;
            return Ok(());
        }
        self.cells.push(cell_text(&self.name, row.into(), column.into(), &plain));
        self.sheet.write_string_with_format(row, column, plain, format)?;
        Ok(())
    }

    fn number(&mut self, row: u32, column: u16, value: f64, format: &Format) -> std::result::Result<(), XlsxError> {
        if !value.is_finite() {
            return self.text(row, column, &value.to_string(), format);
        }
        self.cells.push(cell_text(&self.name, row.into(), column.into(), &number_text(value)));
        self.sheet.write_number_with_format(row, column, value, format)?;
        Ok(())
    }

    /// A column is as wide as the longest text that stands in it.
    fn ask(&mut self, column: u16, text: &str) {
        let column = usize::from(column);
        if self.wide.len() <= column {
            self.wide.resize(column + 1, WIDTHS.0);
        }
        let wide = columns(text) as f64 + 2.0;
        self.wide.iter_mut().skip(column).take(1).for_each(|width| *width = width.max(wide).min(WIDTHS.1));
    }

    fn widths(&mut self) -> std::result::Result<(), XlsxError> {
        let mut last = PRINTED;
        for (column, wide) in (0..).zip(&self.wide) {
            self.sheet.set_column_width(column, *wide)?;
            last = last.max(column);
        }
        // the data of charts stand beside what is printed
        self.sheet.set_print_area(0, 0, self.row, last)?;
        Ok(())
    }

    /// A sentence over several columns, in as many lines as it takes.
    fn line(&mut self, text: &str, format: &Format) -> std::result::Result<(), XlsxError> {
        if text.is_empty() {
            return Ok(());
        }
        let format = format.clone().set_text_wrap().set_align(FormatAlign::Top);
        let lines = (columns(text) as f64 / (f64::from(SENTENCE) * 10.0)).ceil().max(1.0);
        self.sheet.merge_range(self.row, 0, self.row, SENTENCE - 1, "", &format)?;
        self.text(self.row, 0, text, &format)?;
        self.sheet.set_row_height(self.row, 20.0 * lines)?;
        self.row += 1;
        Ok(())
    }

    fn facts(&mut self, facts: &[(String, String)]) -> std::result::Result<(), XlsxError> {
        for (name, value) in facts {
            self.text(self.row, 0, name, &Format::new().set_font_color(Color::RGB(0x57_60_6a)))?;
            self.ask(0, name);
            self.text(self.row, 1, value, &Format::new())?;
            self.row += 1;
        }
        self.row += u32::from(!facts.is_empty());
        Ok(())
    }

    fn block(&mut self, content: &Content, document: &Document) -> std::result::Result<(), XlsxError> {
        let plain = Format::new();
        let algebra = Format::new().set_font_name("Consolas");
        match content {
            Content::Prose(text) => self.line(text, &plain),
            Content::Verdict { tone, text } => {
                let word = tone.word(document.language);
                let said = if word.is_empty() { text.clone() } else { document.language.sentence(word) + " " + text };
                self.line(&said, &toned(&plain.set_bold(), *tone))
            }
            Content::List(points) => points.iter().try_for_each(|point| self.line(&format!("- {point}"), &plain)),
            Content::Formula(lines) => lines.iter().try_for_each(|line| self.line(line, &algebra)),
            Content::Marked(lines) => {
                lines.iter().try_for_each(|line| self.line(&format!("{}{}", line.kept, line.added), &algebra))
            }
            Content::Facts(facts) => self.facts(facts),
            Content::Card { heading, tone, facts } => {
                self.line(heading, &toned(&plain.set_bold(), *tone))?;
                self.facts(facts)
            }
            Content::Table(table) => self.table(table),
            Content::Figures(figures) => figures.iter().try_for_each(|figure| self.figure(figure, document)),
        }
    }

    fn table(&mut self, table: &Table) -> std::result::Result<(), XlsxError> {
        self.row += 1;
        self.line(&table.caption, &Format::new().set_bold())?;
        let head = Format::new().set_bold().set_border_bottom(FormatBorder::Thin).set_text_wrap();
        for (column, kind) in (0..).zip(&table.columns) {
            let head =
                if kind.align == Align::Left { head.clone() } else { head.clone().set_align(FormatAlign::Right) };
            self.text(self.row, column, &kind.title, &head)?;
            self.ask(column, &kind.title);
        }
        self.row += 1;
        let first = self.row;
        for row in &table.rows {
            self.table_row(table, row)?;
        }
        for (column, kind) in (0..).zip(&table.columns) {
            if kind.align == Align::Bar && self.row > first {
                let bar = ConditionalFormatDataBar::new();
                self.sheet.add_conditional_format(first, column, self.row - 1, column, &bar)?;
            }
        }
        self.line(&table.note, &Format::new().set_italic())?;
        self.row += 1;
        Ok(())
    }

    fn table_row(&mut self, table: &Table, row: &Row) -> std::result::Result<(), XlsxError> {
        for ((column, kind), cell) in (0..).zip(&table.columns).zip(&row.cells) {
            let mut format = toned(&Format::new(), row.tone);
            if row.rule {
                format = format.set_border_top(FormatBorder::Hair);
            }
            let text = cell.text();
            self.ask(column, &text);
            match value(cell, kind.align) {
                Some((value, digits)) => {
                    let format = format.set_num_format(digits).set_align(FormatAlign::Right);
                    self.number(self.row, column, value, &format)?;
                }
                None if kind.align == Align::Left => self.text(self.row, column, &text, &format)?,
                None => self.text(self.row, column, &text, &format.set_align(FormatAlign::Right))?,
            }
        }
        self.row += 1;
        Ok(())
    }

    fn figure(&mut self, figure: &Figure, document: &Document) -> std::result::Result<(), XlsxError> {
        if let Chart::Correlation(names, matrix) = &figure.chart {
            self.matrix(names, matrix)?;
        }
        for panel in Panel::of(&figure.chart, document.language) {
            let chart = self.panel(&panel)?;
            if let Some(mut chart) = chart {
                chart.set_width(if figure.wide { 1000 } else { 560 }).set_height(CHART_ROWS * 18);
                chart.set_alt_text(figure.description.chars().take(ALT).collect::<String>());
                self.sheet.insert_chart(self.row, 0, &chart)?;
                self.row += CHART_ROWS;
            }
        }
        self.line(&figure.caption, &Format::new().set_italic())?;
        self.row += 1;
        Ok(())
    }
}

impl Sheet<'_> {
    /// A matrix of correlations, coloured from -1 to 1.
    fn matrix(&mut self, names: &[String], matrix: &[Vec<Option<f64>>]) -> std::result::Result<(), XlsxError> {
        let (head, digits) = (Format::new().set_bold(), Format::new().set_num_format("0.00"));
        for (column, name) in (1..).zip(names) {
            self.text(self.row, column, name, &head)?;
        }
        let first = self.row + 1;
        for (name, row) in names.iter().zip(matrix) {
            self.row += 1;
            self.text(self.row, 0, name, &head)?;
            self.ask(0, name);
            for (column, value) in (1..).zip(row) {
                match value {
                    Some(value) => self.number(self.row, column, *value, &digits)?,
                    None => self.text(self.row, column, "-", &digits)?,
                }
            }
        }
        let columns = u16::try_from(names.len()).unwrap_or(u16::MAX);
        if self.row >= first && columns > 0 {
            let number = ConditionalFormatType::Number;
            let colours = ConditionalFormat3ColorScale::new()
                .set_minimum(number, -1.0)
                .set_midpoint(number, 0.0)
                .set_maximum(number, 1.0)
                .set_minimum_color(Color::RGB(0xe6_9f_00))
                .set_midpoint_color(Color::White)
                .set_maximum_color(Color::RGB(0x00_72_b2));
            self.sheet.add_conditional_format(first, 1, self.row, columns, &colours)?;
        }
        self.row += 2;
        Ok(())
    }
}

/// A cell as a number and its format; `None` for words.
fn value(cell: &Cell, align: Align) -> Option<(f64, String)> {
    let value = match cell {
        Cell::Value(value, _) | Cell::Digits(value, _) | Cell::Decimals(value, _) | Cell::Probability(value) => *value,
        Cell::Dof(value) | Cell::Share(value) => *value,
        Cell::Text(text) if align != Align::Left => text.trim().parse().ok()?,
        Cell::Text(_) | Cell::Absent => return None,
    };
    let text = cell.text();
    if !value.is_finite() || !text.contains(|c: char| c.is_ascii_digit()) || text.contains("inf") {
        return None;
    }
    let mantissa = text.split('e').next().unwrap_or_default();
    let decimals = mantissa.split_once('.').map_or(0, |(_, digits)| digits.trim_end_matches([' ', '%']).len());
    let zeros = "0".repeat(decimals);
    let point = if decimals > 0 { "." } else { "" };
    let tail = match cell {
        Cell::Share(_) => "%".into(),
        _ if text.contains('e') => "E+00".into(),
        _ => String::new(),
    };
    Some((value, format!("0{point}{zeros}{tail}")))
}

fn toned(format: &Format, tone: Tone) -> Format {
    let colour = match tone {
        Tone::Plain => return format.clone(),
        Tone::Good => 0xdd_f4_e4,
        Tone::Caution => 0xff_f3_cd,
        Tone::Bad => 0xfb_e0_dd,
    };
    format.clone().set_background_color(Color::RGB(colour))
}
