//! An error as a person reads it: the sentence, the place with the line and a caret, what was expected and what was found.

use crate::document::wrap;
use crate::elements::Parts;
use crate::error::{Malformed, Place};
use crate::language::say;
use std::path::Path;

/// Longest file that is read again to be quoted; beyond it a fault gets its place in words only.
const LARGEST_QUOTED: u64 = 256 * 1024 * 1024;
/// Characters of a line that are quoted whole; of a longer one so many before the fault, and from it on.
const WHOLE: usize = 70;
const BEFORE: usize = 40;
const AFTER: usize = 30;
/// Longest word of a message; of a longer one both ends are shown.
const LONGEST_WORD: usize = 120;

pub(super) fn show(error: &Malformed) {
    super::note_as_it_is(&rendered(error, super::colours(), None));
}

/// An error as the program shows it, without colours: the sentence, the place with its line and a caret, what was expected and what was found.
///
/// `text` is what the error is about, where that is no file.
pub fn explain(error: &Malformed, text: Option<&str>) -> String {
    rendered(error, false, text)
}

fn rendered(error: &Malformed, colour: bool, text: Option<&str>) -> String {
    let (place, lang) = (error.place(), super::session::language());
    let read = if text.is_none() && (place.span.is_some() || place.line > 0) { quoted(&place.file) } else { None };
    let text = text.or(read.as_deref());
    // of a column of a table the cell in that line
    let (column, width) = match place {
        Place { column: 0, line: 1.., path, .. } if !path.is_empty() => {
            text.and_then(|text| crate::record::cell_of(text, place.line, path)).unwrap_or_default()
        }
        Place { column, width, .. } => (*column, *width),
    };
    let expected = error.expectation().map(|text| say!(lang, "error-expected", text = readable(&lang.name(text))));
    let remedy = error.remedy().map(|(argument, example)| {
        // an argument of the library is an option of the program
        let option = format!("--{argument} {}", readable(example));
        say!(lang, "error-option", text = option.trim_end())
    });
    let found = error.finding().map(|text| say!(lang, "error-found", text = readable(&lang.name(text))));
    let help = [expected, remedy, found].into_iter().flatten().collect::<Vec<_>>().join("\n");
    let mut message = say!(lang, "error-what", text = readable(&lang.name(error.what())));
    if !place.file.is_empty() {
        message.push_str(&format!("\n  {}", say!(lang, "error-in", file = readable(&place.file))));
        if place.line > 0 {
            message.push_str(&say!(lang, "error-line", line = place.line.to_string()));
        }
        if column > 0 {
            message.push_str(&say!(lang, "error-column", column = column.to_string()));
        }
    }
    if !place.path.is_empty() {
        message.push_str(&format!("\n  {}", say!(lang, "error-at", path = readable(&place.path))));
    }
    let ink = Ink::of(colour);
    let excerpt = || {
        let text = text?;
        let of_line = || {
            let before: usize = text.split_inclusive('\n').take(place.line.checked_sub(1)?).map(str::len).sum();
            let line = text.get(before..)?.lines().next()?;
            let place = |character: usize| line.char_indices().nth(character).map_or(line.len(), |(at, _)| at);
            // a row has its line alone
            let (start, end) = match width {
                0 => (0, line.len()),
                _ => (place(column.saturating_sub(1)), place(column.saturating_sub(1) + width)),
            };
            (end > start).then_some((before + start, end - start))
        };
        excerpt(text, &place.file, place.span.or_else(of_line)?, &ink)
    };
    let bar = ink.red(ink.bar);
    let mut out = indented(&message, &format!("  {} ", ink.red(ink.cross)), &format!("  {bar} "));
    out.extend(excerpt());
    if !help.is_empty() {
        out.push_str(&indented(&help, &format!("  {} ", ink.cyan("help:")), "        "));
    }
    out
}

/// Lines of a text, wrapped, the first beside its mark and the others below it.
fn indented(text: &str, first: &str, further: &str) -> String {
    // the marks for further lines are as wide; they have no colour, or letters that are not seen
    let width = wrap::WIDTH - 2 - if further.trim().is_empty() { further.len() } else { 4 };
    let wrapped = text.split('\n').map(|line| wrap::narrow(line, 0, width)).collect::<Vec<_>>().join("\n");
    let mut out = String::new();
    for (k, line) in wrapped.split('\n').enumerate() {
        out.push_str(format!("{}{line}", if k == 0 { first } else { further }).trim_end());
        out.push('\n');
    }
    out
}

/// The strokes of an error, and whether it has colours.
struct Ink {
    cross: &'static str,
    bar: &'static str,
    gap: &'static str,
    /// The corners of the frame, and its line.
    top: &'static str,
    bottom: &'static str,
    line: &'static str,
    under: &'static str,
    colour: bool,
}

impl Ink {
    fn of(colour: bool) -> Self {
        match super::is_dumb() && !colour {
            true => Ink { cross: "x", bar: "|", gap: ":", top: ",", bottom: "`", line: "-", under: "^", colour },
            false => {
                Ink { cross: "×", bar: "│", gap: "·", top: "╭", bottom: "╰", line: "─", under: "─", colour }
            }
        }
    }

    fn styled(&self, code: &str, text: &str) -> String {
        if self.colour { format!("\u{1b}[{code}m{text}\u{1b}[0m") } else { text.into() }
    }

    fn red(&self, text: &str) -> String {
        self.styled("31", text)
    }

    fn cyan(&self, text: &str) -> String {
        self.styled("36", text)
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

/// The line of a fault and its neighbours in a frame, each cut to what fits a terminal, with their numbers, the fault underlined. `None` where the span is not
/// inside the text (the file has changed since it was read).
fn excerpt(text: &str, file: &str, (start, len): (usize, usize), ink: &Ink) -> Option<String> {
    let (before, behind) = (text.get(..start)?, text.get(start..)?);
    let (above, left) = before.rsplit_once('\n').map_or((None, before), |(above, left)| (Some(above), left));
    let mut following = behind.split('\n');
    let right = following.next().unwrap_or_default().trim_end_matches('\r');
    let whole = left.chars().count() + right.chars().count() <= WHOLE;
    let after = clipped(right, if whole { WHOLE } else { AFTER });
    let skipped = if whole { 0 } else { left.chars().count().saturating_sub(BEFORE) };
    // in bytes from 1, as in the sentence
    let column = left.len() + 1;
    let left: String =
        if skipped > 0 { "…".chars().chain(left.chars().skip(skipped)).collect() } else { left.into() };
    let neighbour = |line: &str| clipped(line.trim_end_matches('\r'), WHOLE);
    let previous = above.map(|lines| neighbour(lines.rsplit('\n').next().unwrap_or(lines)));
    let next = following.next().map(neighbour).filter(|line| !line.is_empty());
    let number = before.matches('\n').count() + 1;
    let first = number - usize::from(previous.is_some());
    let wide = (number + usize::from(next.is_some())).to_string().len();
    let margin = " ".repeat(wide + 2);
    let place = ink.styled("36;1;4", &format!("{file}:{number}:{column}"));
    let mut out = format!("{margin}{}{}[{place}]\n", ink.top, ink.line);
    let lines = previous.into_iter().chain([format!("{left}{after}")]).chain(next);
    for (place, line) in (first..).zip(lines) {
        let line = super::visible(&line);
        let shown = ink.styled("2", &format!("{place:>wide$}"));
        out.push_str(format!(" {shown} {} {}", ink.bar, tabs_as_spaces(&line)).trim_end());
        out.push('\n');
        if place == number {
            let upto = |end: usize| {
                let part: String = line.char_indices().take_while(|(at, _)| *at < end).map(|(_, c)| c).collect();
                wrap::columns(&tabs_as_spaces(&part))
            };
            let (from, to) = (upto(left.len()), upto(left.len() + len.min(after.len()).max(1)));
            let mark = ink.styled("35;1", &ink.under.repeat(to.saturating_sub(from).max(1)));
            out.push_str(&format!("{margin}{} {}{mark}\n", ink.gap, " ".repeat(from)));
        }
    }
    Some(out + &format!("{margin}{}{}\n", ink.bottom, ink.line.repeat(4)))
}

/// A line whose tabs are the spaces up to every fourth column.
fn tabs_as_spaces(line: &str) -> String {
    let mut text = String::with_capacity(line.len());
    for part in line.split_inclusive('\t') {
        text.push_str(part.trim_end_matches('\t'));
        if part.ends_with('\t') {
            text.push_str(&" ".repeat(4 - wrap::columns(&text) % 4));
        }
    }
    text
}

/// The first characters of a line, and a mark where it goes on.
fn clipped(line: &str, most: usize) -> String {
    match line.char_indices().nth(most) {
        Some((end, _)) => format!("{}…", line.part(..end)),
        None => line.to_string(),
    }
}
