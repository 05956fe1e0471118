//! Lines for a terminal.

use crate::elements::Parts;

/// Columns of a terminal that a line should not exceed.
pub(crate) const WIDTH: usize = 80;

/// Wrap a line at spaces, with so many spaces before every further one; a word that is longer than a line stays whole.
pub(crate) fn hanging(line: &str, indent: usize) -> String {
    narrow(line, indent, WIDTH)
}

/// Every line of a text that is too long is wrapped below its own beginning; lines that fit stay as they are. Spaces that were
/// not to break (U+00A0) become ordinary ones.
pub(crate) fn lines(text: &str) -> String {
    let mut wrapped = String::with_capacity(text.len() + 64);
    for line in text.split_inclusive('\n') {
        let body = line.trim_end_matches('\n');
        if columns(body) <= WIDTH {
            wrapped.push_str(line);
        } else {
            let lead = body.chars().take_while(|c| *c == ' ').count();
            wrapped.push_str(&hanging(body, lead + 2));
            wrapped.push_str(line.part(body.len()..));
        }
    }
    if wrapped.contains('\u{a0}') { wrapped.replace('\u{a0}', " ") } else { wrapped }
}

/// The same as `hanging` within so many columns.
pub(crate) fn narrow(line: &str, indent: usize, width: usize) -> String {
    let mut text = String::with_capacity(line.len() + 16);
    let mut column = 0;
    // leading spaces belong to the line
    let lead = line.len() - line.trim_start_matches(' ').len();
    text.push_str(line.part(..lead));
    column += lead;
    for (k, word) in line.part(lead..).split(' ').enumerate() {
        for (n, piece) in unbroken(word).enumerate() {
            let (size, space) = (columns(piece), usize::from(k > 0 && n == 0));
            if k + n > 0 && column + space + size > width && column > indent {
                text.push('\n');
                text.push_str(&" ".repeat(indent));
                column = indent;
            } else if space > 0 {
                text.push(' ');
                column += 1;
            }
            text.push_str(piece);
            column += size;
        }
    }
    text
}

/// Columns of a terminal that a text takes: Chinese characters take two.
pub(crate) fn columns(text: &str) -> usize {
    if text.is_ascii() { text.len() } else { text.chars().map(|c| if is_wide(c) { 2 } else { 1 }).sum() }
}

/// What stays together: words, and single Chinese characters with the punctuation that may not be parted from them.
pub(super) fn pieces(text: &str) -> impl Iterator<Item = &str> {
    text.split(' ').flat_map(unbroken)
}

/// Is it an East Asian wide or fullwidth character?
fn is_wide(c: char) -> bool {
    matches!(c, '\u{1100}'..='\u{115f}' | '\u{2e80}'..='\u{a4cf}' | '\u{ac00}'..='\u{d7a3}' | '\u{f900}'..='\u{faff}' | '\u{fe30}'..='\u{fe6f}'
        | '\u{ff00}'..='\u{ff60}' | '\u{ffe0}'..='\u{ffe6}' | '\u{20000}'..='\u{3fffd}')
}

/// The pieces of a word without spaces between which a line may break.
fn unbroken(word: &str) -> impl Iterator<Item = &str> {
    // what may not begin a line, and what may not end one
    const CLOSING: &str = "\u{ff0c}\u{3002}\u{ff1b}\u{ff1a}\u{3001}\u{ff01}\u{ff1f}\u{ff09}\u{300b}\u{300d}\u{300f}\u{201d}\u{2019}%\u{b0},.;:)]";
    const OPENING: &str = "\u{ff08}\u{300a}\u{300c}\u{300e}\u{201c}\u{2018}([";
    let mut starts = vec![0];
    if !word.is_ascii() {
        let letters = word.char_indices().zip(word.chars().skip(1));
        for ((at, before), after) in letters {
            let part = (is_wide(before) || is_wide(after)) && !CLOSING.contains(after) && !OPENING.contains(before);
            if part {
                starts.push(at + before.len_utf8());
            }
        }
    }
    starts.push(word.len());
    let ends: Vec<usize> = starts.iter().skip(1).copied().collect();
    starts.into_iter().zip(ends).map(|(from, to)| word.part(from..to))
}
