//! Lines for a terminal.

/// Columns of a terminal that a line should not exceed.
const WIDTH: usize = 110;

/// Wrap a line at spaces, with so many spaces before every further one; a word that is longer than a line stays whole.
pub fn hanging(line: &str, indent: usize) -> String {
    within(line, indent, WIDTH)
}

/// The same within so many columns.
pub fn narrow(line: &str, indent: usize, width: usize) -> String {
    within(line, indent, width)
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

/// Wrap the last column of a plain table (header, rule, rows), which begins where its title stands.
pub fn last_column(table: &str, title: &str) -> String {
    let header = table.lines().next().unwrap_or_default();
    let Some(at) = header.rfind(title) else { return table.to_string() };
    let indent = header.get(..at).unwrap_or_default().chars().count();
    let mut text = String::with_capacity(table.len() + 64);
    for (k, line) in table.lines().enumerate() {
        if k == 1 {
            text.extend(line.chars().take(WIDTH));
        } else {
            text.push_str(&hanging(line, indent));
        }
        text.push('\n');
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
        let table = format!("id  what\n{}\na   {}\n", "-".repeat(200), "word ".repeat(40).trim());
        let wrapped = last_column(&table, "what");
        assert!(wrapped.lines().all(|line| line.chars().count() <= WIDTH));
        assert!(wrapped.lines().skip(3).all(|line| line.starts_with("    word")));
    }
}
