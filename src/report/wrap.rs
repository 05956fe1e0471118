//! Lines for a terminal.

/// Columns of a terminal that a line should not exceed.
pub const WIDTH: usize = 80;

/// Wrap a line at spaces, with so many spaces before every further one; a word that is longer than a line stays whole.
pub fn hanging(line: &str, indent: usize) -> String {
    within(line, indent, WIDTH)
}

pub(super) fn within(line: &str, indent: usize, width: usize) -> String {
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

/// Wrap every line of prose that is too long; lines of tables (with gaps between their columns) stay whole.
///
/// ```
/// let text = format!("  {}\n", "word ".repeat(30).trim());
/// assert!(tumble::report::wrap::page(&text).lines().all(|line| line.len() <= 80 && line.starts_with("  ")));
/// ```
pub fn page(text: &str) -> String {
    let mut page = String::with_capacity(text.len() + 64);
    let mut lines = text.split_inclusive('\n').peekable();
    while let Some(line) = lines.next() {
        let prose = !line.trim().contains("  ");
        if line.trim_end().chars().count() <= WIDTH || !prose {
            page.push_str(line);
            continue;
        }
        let lead = line.len() - line.trim_start_matches(' ').len();
        match lines.next_if(|next| is_marks(next)) {
            Some(marks) => page.push_str(&marked(line.trim_end(), marks, lead + 2)),
            None => page.push_str(&hanging(line.trim_end(), lead + 2)),
        }
        page.push('\n');
    }
    page
}

/// Is this a line of carets under the line before?
fn is_marks(line: &str) -> bool {
    line.contains('^') && line.chars().all(|c| matches!(c, ' ' | '^' | '\n'))
}

/// Wrap a line together with the carets that stand under it.
fn marked(line: &str, marks: &str, indent: usize) -> String {
    let marks: Vec<char> = marks.trim_end().chars().collect();
    let mut text: Vec<(String, String)> = vec![(String::new(), String::new())];
    let mut at = 0;
    for (k, word) in line.split(' ').enumerate() {
        let column = text.last().map_or(0, |(own, _)| own.chars().count());
        if k > 0 && column + 1 + word.chars().count() > WIDTH && column > indent {
            text.push((" ".repeat(indent), " ".repeat(indent)));
        } else if k > 0
            && let Some((own, under)) = text.last_mut()
        {
            own.push(' ');
            under.push(' ');
        }
        let Some((own, under)) = text.last_mut() else { break };
        own.push_str(word);
        under.extend((at..at + word.chars().count()).map(|k| marks.get(k).copied().unwrap_or(' ')));
        at += word.chars().count() + 1;
    }
    let lines = text.into_iter().flat_map(|(own, under)| {
        let under = under.trim_end().to_string();
        std::iter::once(own).chain((!under.is_empty()).then_some(under))
    });
    lines.collect::<Vec<_>>().join("\n")
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
        let line = format!("y = {}last", "one + ".repeat(14));
        let marks = format!("{}^^^^\n", " ".repeat(line.len() - 4));
        let wrapped = page(&format!("{line}\n{marks}"));
        let lines: Vec<&str> = wrapped.lines().collect();
        assert!(lines.len() == 3 && lines[2].find('^') == lines[1].find("last"), "{wrapped}");
        let table = format!("id  what\n{}\na   {}\n", "-".repeat(200), "word ".repeat(40).trim());
        let wrapped = last_column(&table, "what");
        assert!(wrapped.lines().all(|line| line.chars().count() <= WIDTH));
        assert!(wrapped.lines().skip(3).all(|line| line.starts_with("    word")));
    }
}
