//! From a JSON path to a line and a column.

use super::Source;
use crate::elements::Parts;
use crate::error::Malformed;
use serde_json::value::RawValue;
use std::{borrow::Cow, collections::HashMap};

/// Give an error its file, line, column and caret from its JSON path, unless it stands in another file already.
///
/// An error without path and span is about none of the file's places and comes back as it is.
/// A span that the error brings counts from the start of the string value at the path (a model line, say).
pub fn locate(error: Malformed, source: &Source) -> Malformed {
    if !error.place().file.is_empty() {
        return error;
    }
    if let Some((kind, number, file, column)) = row_of(&error.place().path) {
        let (file, path) = (file.to_string(), column.to_string());
        return match (kind, number.parse(), column) {
            ("line", Ok(line), _) => error.at_line(line, 0).in_file(file).moved_to(path),
            (_, _, "") => {
                let row = format!("{kind} {number}");
                error.in_file(file).moved_to(row)
            }
            _ => {
                let path = format!("{kind} {number}, column '{column}'");
                error.in_file(file).moved_to(path)
            }
        };
    }
    if error.place().path.is_empty() && error.place().span.is_none() {
        return error; // not about any place of the file: an option, say
    }
    let named = error.in_file(&source.name);
    let place = named.place().clone();
    let Some((start, text)) = find(&source.text, &place.path) else { return named };
    let (offset, len) = match place.span {
        // inside a string value: past the quote, as long as no escape shifts it
        Some((inner, len)) if text.starts_with('"') => (start + 1 + escaped_offset(text, inner), len),
        _ => (start, text.split(['\n', '\r']).next().unwrap_or(text).len()),
    };
    let (line, column) = line_and_column(&source.text, offset);
    named.at_span(offset, len).at_line(line, column)
}

/// The same for errors of reading a file: what has no place in it still has the file.
pub(super) fn in_source(error: Malformed, source: &Source) -> Malformed {
    let located = locate(error, source);
    if located.place().file.is_empty() { located.in_file(&source.name) } else { located }
}

/// What the place of a row and a column's name behind it say: `line` or `row`, its number, the file, the column.
fn row_of(path: &str) -> Option<(&str, &str, &str, &str)> {
    let (row, place) = path.split_once(" of ")?;
    let (kind, number) = row.split_once(' ').filter(|(kind, _)| matches!(*kind, "line" | "row"))?;
    let (file, column) = place.rsplit_once('|')?;
    let column = column.trim_start_matches('.');
    number.bytes().all(|b| b.is_ascii_digit()).then_some((kind, number, file, column))
}

/// Offset in the raw JSON string of the `inner`-th byte of its unescaped content.
fn escaped_offset(raw: &str, inner: usize) -> usize {
    let body = raw.part(1..);
    let (mut at, mut plain) = (0, 0);
    let bytes = body.as_bytes();
    while plain < inner && at < bytes.len() {
        at += match (bytes.get(at), bytes.get(at + 1)) {
            (Some(b'\\'), Some(b'u')) => 6,
            (Some(b'\\'), _) => 2,
            _ => 1,
        };
        plain += 1;
    }
    at
}

/// Line and column (characters), both from 1, of a byte offset.
pub(crate) fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let mut end = offset.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let before = text.part(..end);
    let line_start = before.rfind('\n').map_or(0, |k| k + 1);
    let line = 1 + before.bytes().filter(|b| *b == b'\n').count();
    (line, 1 + before.part(line_start..).chars().count())
}

/// Byte offset of a line and a byte column, both from 1.
pub(super) fn offset_of(text: &str, line: usize, column: usize) -> Option<usize> {
    let mut start = 0;
    for _ in 1..line {
        start += text.get(start..)?.find('\n')? + 1;
    }
    Some((start + column.saturating_sub(1)).min(text.len()))
}

/// Start and length of the word, number or quoted text whose last byte is at `offset`; else that byte alone.
pub(super) fn token_ending_at(text: &str, offset: usize) -> (usize, usize) {
    let mut last = offset.min(text.len());
    while !text.is_char_boundary(last) {
        last -= 1;
    }
    let before = text.part(..last);
    let is_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '+' | '.');
    let start = match text.get(last..).and_then(|tail| tail.chars().next()) {
        Some('"') => before.rfind('"').filter(|open| !before[*open..].contains('\n')),
        Some(c) if is_word(c) => Some(before.trim_end_matches(is_word).len()),
        _ => None,
    };
    let end = text.get(last..).and_then(|tail| tail.chars().next()).map_or(last + 1, |c| last + c.len_utf8());
    // one number alone is where it begins and ends
    let start = start.unwrap_or(last);
    (start, end - start)
}

/// Start and text of the value at a path, or of the deepest value on the way that exists.
fn find<'a>(text: &'a str, path: &str) -> Option<(usize, &'a str)> {
    let mut here: &'a RawValue = serde_json::from_str(text).ok()?;
    // a key, and the indices behind it
    for (place, step) in path.split('.').flat_map(|part| part.split('[').enumerate()) {
        let next = match (place, step.trim_end_matches(']').parse::<usize>()) {
            (0, _) if step.is_empty() => continue,
            (0, _) => {
                let keys = serde_json::from_str::<HashMap<Cow<'a, str>, &'a RawValue>>(here.get());
                keys.ok().and_then(|keys| keys.get(step).copied())
            }
            (_, Ok(k)) => {
                serde_json::from_str::<Vec<&'a RawValue>>(here.get()).ok().and_then(|list| list.get(k).copied())
            }
            (_, Err(_)) => continue,
        };
        match next {
            Some(value) => here = value,
            None => break,
        }
    }
    let start = (here.get().as_ptr() as usize).checked_sub(text.as_ptr() as usize)?;
    Some((start, here.get()))
}
