//! Text into HTML.

use super::xml;

/// Code up to this length stays on one line.
const SHORT: usize = 30;

/// Escape a text and set what stands between a pair of backticks in code type.
pub(super) fn inline(text: &str) -> String {
    let parts: Vec<&str> = text.split('`').collect();
    let mut html = String::with_capacity(text.len() + 16);
    for (k, part) in parts.iter().enumerate() {
        let escaped = escape(part);
        // an odd part is code, unless its closing backtick is missing
        match (k % 2 == 1, k + 1 < parts.len()) {
            // short code is not broken, so that an option keeps its dashes
            (true, true) if part.chars().count() <= SHORT => {
                html.push_str(&format!("<code class=\"short\">{escaped}</code>"));
            }
            (true, true) => html.push_str(&format!("<code>{escaped}</code>")),
            (true, false) => html.push_str(&format!("`{escaped}")),
            _ => html.push_str(&escaped),
        }
    }
    html
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
