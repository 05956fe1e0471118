//! A document as one self-contained HTML file, for the screen and for print: no network, no script. Every text is escaped.

use super::{Content, Document, Tone, escape, plot};
use crate::error::{Fault, Malformed, Result};
use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior, Value, context};
use std::collections::BTreeMap;

const TEMPLATE: &str = include_str!("../../data/templates/page.html");
const STYLE: &str = include_str!("../../data/templates/page.css");

/// A document as one HTML file.
///
/// Errors: none that a page can cause; a fault in the template is reported as `Value`.
///
/// ```
/// use tumble::document::{Document, Section, html::render};
/// let page = Document::new("A <b> page").section(Section::new("Result").prose("`V0` is 3 < 4"));
/// let html = render(&page)?;
/// assert!(html.contains("A &lt;b&gt; page") && html.contains(">V0</code> is 3 &lt; 4"));
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn render(document: &Document) -> Result<String> {
    let fault = |error: minijinja::Error| {
        Malformed::new(Fault::Value, format!("the page cannot be laid out: {error:#}")).expected("a sound template")
    };
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build().map_err(fault)?);
    environment.add_filter("inline", |text: &str| Value::from_safe_string(escape::inline(text)));
    environment.add_filter("plain", |text: &str| Value::from_safe_string(escape::escape(text)));
    environment.add_filter("bar", |text: &str| Value::from_safe_string(escape::bar(text)));
    environment.add_template("page.html", TEMPLATE).map_err(fault)?;
    let template = environment.get_template("page.html").map_err(fault)?;
    let language = document.language;
    let tones = [("plain", Tone::Plain), ("good", Tone::Good), ("caution", Tone::Caution), ("bad", Tone::Bad)];
    let words: BTreeMap<&str, String> =
        tones.into_iter().map(|(name, tone)| (name, language.sentence(tone.word(language)))).collect();
    let mut page = document.clone();
    let mut drawn = Vec::new();
    for block in page.sections.iter_mut().flat_map(|section| &mut section.blocks) {
        match &mut block.content {
            Content::Table(table) => table.typeset(),
            Content::Figures(figures) => {
                for figure in figures {
                    drawn.push(plot::draw(&figure.chart, language)?);
                }
            }
            _ => {}
        }
    }
    let page = Serde(page);
    template
        .render(
            context! { page, drawn, words, language => language.tag(), style => Value::from_safe_string(STYLE.to_string()) },
        )
        .map_err(fault)
}
