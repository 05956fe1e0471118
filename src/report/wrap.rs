//! Lines for a terminal.

/// Columns of a terminal that a line should not exceed.
pub const WIDTH: usize = 80;

/// Wrap a line at spaces, with so many spaces before every further one; a word that is longer than a line stays whole.
pub fn hanging(line: &str, indent: usize) -> String {
    within(line, indent, WIDTH)
}

/// The same within so many columns.
pub fn narrow(line: &str, indent: usize, width: usize) -> String {
    within(line, indent, width)
}

/// Every line of a text that is too long is wrapped below its own beginning; lines that fit stay as they are. Spaces that were
/// not to break (U+00A0) become ordinary ones.
pub fn lines(text: &str) -> String {
    let mut wrapped = String::with_capacity(text.len() + 64);
    for line in text.split_inclusive('\n') {
        let body = line.trim_end_matches('\n');
        if body.chars().count() <= WIDTH {
            wrapped.push_str(line);
        } else {
            let lead = body.chars().take_while(|c| *c == ' ').count();
            wrapped.push_str(&hanging(body, lead + 2));
            wrapped.push_str(line.get(body.len()..).unwrap_or_default());
        }
    }
    if wrapped.contains('\u{a0}') { wrapped.replace('\u{a0}', " ") } else { wrapped }
}

fn within(line: &str, indent: usize, width: usize) -> String {
    let mut text = String::with_capacity(line.len() + 16);
    let mut column = 0;
    // leading spaces belong to the line
    let lead = line.len() - line.trim_start_matches(' ').len();
    text.push_str(line.get(..lead).unwrap_or_default());
    column += lead;
    for (k, word) in line.get(lead..).unwrap_or_default().split(' ').enumerate() {
        let size = word.chars().count();
        if k > 0 && column + 1 + size > width && column > indent {
            text.push('\n');
            text.push_str(&" ".repeat(indent));
            column = indent;
        } else if k > 0 {
            text.push(' ');
            column += 1;
        }
        text.push_str(word);
        column += size;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_hang_below_their_beginning() {
        assert_eq!(within("  one: two three four", 4, 12), "  one: two\n    three\n    four");
        assert_eq!(within("a-word-that-is-too-long b", 2, 8), "a-word-that-is-too-long\n  b");
        assert_eq!(within("short", 2, 8), "short");
        let text = format!("short\n  {}\n", "word ".repeat(40).trim());
        assert!(lines(&text).lines().all(|line| line.chars().count() <= WIDTH));
        assert!(lines(&text).starts_with("short\n  word") && lines(&text).contains("\n    word"));
    }
}
