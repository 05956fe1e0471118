//! What may stand in XML, and so in SVG.

/// May a character stand in an XML document? (U+FFFE and U+FFFF may not, nor most control characters.)
///
/// Source: XML 1.0, production 2 (`Char`), without the control characters that it discourages.
pub(crate) fn is_allowed(c: char) -> bool {
    matches!(c, '\t' | '\n' | '\r' | '\u{20}'..='\u{7e}' | '\u{a0}'..='\u{fffd}' | '\u{10000}'..)
}
