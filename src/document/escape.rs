//! Text into HTML.

use super::xml;
use crate::language::runs;

/// Code up to this length stays on one line.
const SHORT: usize = 30;

/// Escape a text and set what stands between a pair of backticks in code type.
pub(super) fn inline(text: &str) -> String {
    let run = |(is_code, run): (bool, String)| match is_code {
        false => escape(&run),
        // short code is not broken, so that an option keeps its dashes
        true if run.chars().count() <= SHORT => format!("<code class=\"short\">{}</code>", escape(&run)),
        true => format!("<code>{}</code>", escape(&run)),
    };
    runs(text).into_iter().map(run).collect()
}

/// A number from -1 to 1 as a bar about a middle line; nothing for what is no number.
pub(super) fn bar(text: &str) -> String {
    let Some(share) = text.parse::<f64>().ok().filter(|v| v.is_finite()).map(|v| v.clamp(-1.0, 1.0)) else {
        return String::new();
    };
    let width = 50.0 * share.abs();
    let left = if share < 0.0 { 50.0 - width } else { 50.0 };
    format!("<span class=\"bar\"><i style=\"left:{left:.1}%;width:{width:.1}%\"></i></span>")
}

/// Escape what HTML and XML would take for markup; control characters that neither allows become a replacement character.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in xml::printable(text).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}
