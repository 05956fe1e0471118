//! An error as a person reads it: the sentence, the place with the line and a caret, what was expected and what was found.

use crate::elements::TextPart;
use crate::error::Malformed;
use crate::language::say;
use miette::{
    GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, MietteError, MietteSpanContents, Report,
    Severity, SourceCode, SourceSpan, SpanContents,
};
use std::path::Path;

/// Longest file that is read again to be quoted; beyond it a fault gets its place in words only.
const LARGEST_QUOTED: u64 = 256 * 1024 * 1024;
/// Characters of a line that are quoted whole; of a longer one so many before the fault, and from it on.
const WHOLE: usize = 70;
const BEFORE: usize = 40;
const AFTER: usize = 30;
/// Longest word of a message; of a longer one both ends are shown.
const LONGEST_WORD: usize = 120;

/// Print an error to stderr.
pub(super) fn show(error: &Malformed) {
    super::note_as_it_is(&render(error, super::colours()));
}

/// An error as the program shows it, without colours: the sentence, the place with its line and a caret, what was expected and what was found.
///
/// `text` is what the error is about, where that is no file.
pub fn explain(error: &Malformed, text: Option<&str>) -> String {
    rendered(error, false, text)
}

fn render(error: &Malformed, colour: bool) -> String {
    rendered(error, colour, None)
}

fn rendered(error: &Malformed, colour: bool, text: Option<&str>) -> String {
    let (place, lang) = (error.place(), super::session::language());
    let mut help = String::new();
    if let Some(expected) = error.expectation() {
        help.push_str(&say!(lang, "error-expected", text = readable(&lang.name(expected))));
    }
    if let Some((argument, example)) = error.remedy() {
        // an argument of the library is an option of the program
        let start = if help.is_empty() { "" } else { "\n" };
        let option = format!("--{argument} {}", readable(example));
        help.push_str(&format!("{start}{}", say!(lang, "error-option", text = option.trim_end())));
    }
    if let Some(found) = error.finding() {
        let start = if help.is_empty() { "" } else { "\n" };
        help.push_str(&format!("{start}{}", say!(lang, "error-found", text = readable(&lang.name(found)))));
    }
    let mut message = say!(lang, "error-what", text = readable(&lang.name(error.what())));
    if !place.file.is_empty() {
        message.push_str(&format!("\n  {}", say!(lang, "error-in", file = readable(&place.file))));
        if place.line > 0 {
            let [line, column] = [place.line, place.column].map(|n| n.to_string());
            message.push_str(&say!(lang, "error-line", line, column));
        }
    }
    if !place.path.is_empty() {
        message.push_str(&format!("\n  {}", say!(lang, "error-at", path = readable(&place.path))));
    }
    let mut diagnostic = MietteDiagnostic::new(message).with_severity(Severity::Error);
    if !help.is_empty() {
        diagnostic = diagnostic.with_help(help);
    }
    let excerpt = || {
        if place.span.is_none() && place.line == 0 {
            return None;
        }
        let read = if text.is_none() { quoted(&place.file) } else { None };
        let text = text.or(read.as_deref())?;
        // a row of a table has its line alone
        let of_line = || {
            let before: usize = text.split_inclusive('\n').take(place.line.checked_sub(1)?).map(str::len).sum();
            let line = text.get(before..)?.lines().next()?;
            (!line.is_empty()).then_some((before, line.len()))
        };
        let (start, len) = place.span.or_else(of_line)?;
        Excerpt::around(text, &place.file, start, len)
    };
    let excerpt = excerpt();
    let report = match excerpt {
        Some(excerpt) => {
            let diagnostic = diagnostic.with_label(LabeledSpan::underline(excerpt.span));
            Report::new(diagnostic).with_source_code(excerpt)
        }
        None => Report::new(diagnostic),
    };
    let theme = match colour {
        true => GraphicalTheme::unicode(),
        false if super::is_dumb() => GraphicalTheme::none(),
        false => GraphicalTheme::unicode_nocolor(),
    };
    let mut out = String::new();
    let handler = GraphicalReportHandler::new_themed(theme).with_context_lines(1).with_width(80);
    match handler.render_report(&mut out, report.as_ref()) {
        Ok(()) => out,
        Err(_) => format!("error: {error}"),
    }
}

/// A sentence without what steers a terminal, its overlong words (a key of thousands of characters) cut in their middles.
fn readable(sentence: &str) -> String {
    let words = super::visible(sentence);
    let cut = |word: &str| {
        let letters: Vec<char> = word.chars().collect();
        if letters.len() <= LONGEST_WORD {
            return word.to_string();
        }
        let (first, last) = (letters.get(..LONGEST_WORD / 2), letters.get(letters.len() - LONGEST_WORD / 4..));
        let ends = [first, last].map(|end| end.unwrap_or_default().iter().collect::<String>());
        format!("{}\u{2026}{}", ends[0], ends[1])
    };
    words.split(' ').map(cut).collect::<Vec<_>>().join(" ")
}

/// Is this a file of ours, JSON or a table, that may be quoted? (A campaign can name any file that its reader may read.)
fn may_be_quoted(text: &str) -> bool {
    let is_name = |name: &str| {
        let name = name.trim().trim_matches('"');
        name.len() <= 60 && name.chars().all(|c| c.is_alphanumeric() || " _-+.()[]/%\u{b0}".contains(c))
    };
    let first = text.lines().find(|line| !line.starts_with('#') && !line.trim().is_empty()).unwrap_or_default();
    let mut names = first.split([',', ';', '\t']);
    text.trim_start().starts_with(['{', '[']) || (names.clone().count() > 1 && names.all(is_name))
}

/// The text of the file that has the error, if it is small enough to be quoted.
fn quoted(file: &str) -> Option<String> {
    let path = Path::new(file);
    let there = std::fs::metadata(path).ok()?;
    // a pipe gives its text once only
    if !there.is_file() || there.len() > LARGEST_QUOTED {
        return None;
    }
    let text = String::from_utf8(std::fs::read(path).ok()?).ok()?;
    let text = text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text);
    may_be_quoted(&text).then_some(text)
}

/// The line of a fault and its neighbours, each cut to what fits a terminal, with the number of its first line.
#[derive(Debug)]
struct Excerpt {
    file: String,
    text: String,
    /// Lines of the file before the excerpt.
    lines_before: usize,
    /// What is underlined, in bytes of the excerpt.
    span: (usize, usize),
}

impl Excerpt {
    /// `None` where the span is not inside the text (the file has changed since it was read).
    fn around(text: &str, file: &str, start: usize, len: usize) -> Option<Self> {
        let (before, rest) = (text.get(..start)?, text.get(start..)?);
        let line_start = before.rfind('\n').map_or(0, |k| k + 1);
        let previous = before.get(..line_start.saturating_sub(1)).filter(|_| line_start > 0);
        let previous = previous.map(|lines| lines.rsplit('\n').next().unwrap_or(lines));
        let mut following = rest.split('\n');
        let right = following.next().unwrap_or_default().trim_end_matches('\r');
        let left = before.part(line_start..);
        let whole = left.chars().count() + right.chars().count() <= WHOLE;
        let after = clipped(right, if whole { WHOLE } else { AFTER });
        let skipped = if whole { 0 } else { left.chars().count().saturating_sub(BEFORE) };
        let left: String =
            if skipped > 0 { "…".chars().chain(left.chars().skip(skipped)).collect() } else { left.into() };
        let mut excerpt = previous.map_or(String::new(), |line| clipped(line.trim_end_matches('\r'), WHOLE) + "\n");
        excerpt.push_str(&left);
        let span = (excerpt.len(), len.min(after.len()));
        excerpt.push_str(&after);
        if let Some(next) = following.next() {
            excerpt.push('\n');
            excerpt.push_str(&clipped(next.trim_end_matches('\r'), WHOLE));
        }
        let excerpt = super::visible(&excerpt).into_owned();
        let line = before.bytes().filter(|b| *b == b'\n').count();
        Some(Excerpt { file: file.into(), text: excerpt, lines_before: line - usize::from(previous.is_some()), span })
    }
}

/// The first characters of a line, and a mark where it goes on.
fn clipped(line: &str, most: usize) -> String {
    match line.char_indices().nth(most) {
        Some((end, _)) => format!("{}…", line.part(..end)),
        None => line.to_string(),
    }
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let inner = self.text.read_span(span, lines_before, lines_after)?;
        Ok(Box::new(MietteSpanContents::new_named(
            self.file.clone(),
            inner.data(),
            *inner.span(),
            self.lines_before + inner.line(),
            inner.column(),
            inner.line_count(),
        )))
    }
}
