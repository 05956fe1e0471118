//! What may stand in XML, and so in SVG.

/// A text with a replacement character for each that may not stand in an XML document: U+FFFE and U+FFFF, and most control characters.
///
/// Source: XML 1.0, production 2 (`Char`), without the control characters that it discourages.
pub(crate) fn printable(text: &str) -> String {
    let is_allowed =
        |c: char| matches!(c, '\t' | '\n' | '\r' | '\u{20}'..='\u{7e}' | '\u{a0}'..='\u{fffd}' | '\u{10000}'..);
    text.chars().map(|c| if is_allowed(c) { c } else { '\u{fffd}' }).collect()
}
