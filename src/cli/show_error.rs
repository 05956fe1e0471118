//! An error as a person reads it: the sentence, the place with the line and a caret, what was expected and what was found.

use crate::error::Malformed;
use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report, Severity};
use std::io::IsTerminal;
use std::path::Path;

/// Longest text that is quoted around the caret; a file beyond it gets its place in words only.
const LARGEST_QUOTED: u64 = 8 * 1024 * 1024;

/// Print an error to stderr.
pub(super) fn show(error: &Malformed) {
    eprintln!("{}", render(error, std::io::stderr().is_terminal()));
}

fn render(error: &Malformed, colour: bool) -> String {
    let place = error.place();
    let mut help = String::new();
    if let Some(expected) = error.expectation() {
        help.push_str(&format!("expected {expected}"));
    }
    if let Some(found) = error.finding() {
        let start = if help.is_empty() { "" } else { "\n" };
        help.push_str(&format!("{start}found {found}"));
    }
    let mut message = format!("error: {}", error.what());
    if !place.file.is_empty() {
        message.push_str(&format!("\n  in {}", place.file));
        if place.line > 0 {
            message.push_str(&format!(", line {}, column {}", place.line, place.column));
        }
    }
    if !place.path.is_empty() {
        message.push_str(&format!("\n  at {}", place.path));
    }
    let mut diagnostic = MietteDiagnostic::new(message).with_severity(Severity::Error);
    if !help.is_empty() {
        diagnostic = diagnostic.with_help(help);
    }
    let text = quoted(&place.file);
    let label = place
        .span
        .filter(|(start, len)| text.as_ref().is_some_and(|t| start + len <= t.len() && t.is_char_boundary(*start)));
    let report = match (text, label) {
        (Some(text), Some((start, len))) => {
            let diagnostic = diagnostic.with_label(LabeledSpan::underline((start, len)));
            Report::new(diagnostic).with_source_code(NamedSource::new(&place.file, text))
        }
        _ => Report::new(diagnostic),
    };
    let theme = if colour { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
    let mut out = String::new();
    let handler = GraphicalReportHandler::new_themed(theme).with_context_lines(1).with_width(110);
    match handler.render_report(&mut out, report.as_ref()) {
        Ok(()) => out,
        Err(_) => format!("error: {error}"),
    }
}

/// The text of the file that the error stands in, if it is small enough to be quoted.
fn quoted(file: &str) -> Option<String> {
    let path = Path::new(file);
    let size = std::fs::metadata(path).ok()?.len();
    if file.is_empty() || size > LARGEST_QUOTED {
        return None;
    }
    let text = String::from_utf8(std::fs::read(path).ok()?).ok()?;
    Some(text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text))
}
