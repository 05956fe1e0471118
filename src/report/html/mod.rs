//! Reports as pages: one self-contained HTML file, or the same page as markdown (`report::markdown`).
//!
//! ```text
//! report value (serde) -> page (title, verdict, sections of blocks) -> html::render or markdown::render
//! ```
//!
//! A page is data. [`Page`] holds a title, facts and a list of [`Section`]s; a section holds [`PageBlock`]s: prose, a verdict, a list, formula
//! lines, facts, a table, figures. One template (`data/templates/page.html`) lays out every page, for the screen and for print; it needs no
//! network and no script. Every text is escaped; a pair of backticks sets a name in code type. A figure is inline SVG from `report::plot`.
//!
//! To add a page: a file beside this one with `pub fn <kind>_page(&<Kind>Report, ..) -> Page`, built from sections, and a `pub use` line below;
//! `cli` then calls [`render`] and `markdown::render`. Numbers are formatted by `report::table` (`rounded`, `significant`) before they enter
//! a cell; a column of [`Align::Decimal`] aligns them at the decimal point.
//!
//! | file | subject |
//! |---|---|
//! | `page.rs` | what a page consists of |
//! | `escape.rs`, `cells.rs` | text and numbers as they enter a page |
//! | `fit_page.rs` | the page of a fit, section by section: |
//! | `fit_answer.rs` | the verdicts, and the fit in a few sentences |
//! | `fit_estimates.rs` | the estimates, what is not estimable, the budgets |
//! | `scatter_page.rs` | what scatters |
//! | `fit_correction.rs` | the correction to apply, and the mounting |
//! | `checks_page.rs` | what was checked: readings, constraints, Monte Carlo |
//! | `fit_readings.rs` | what was assumed, and the readings one by one |
//! | `fit_figures.rs` | its charts |
//! | `batch_page.rs` | many devices |
//! | `changes_page.rs` | two calibrations of one unit, the history of many |
//! | `compare_page.rs` | published closed forms beside least squares |
//! | `diagnose_page.rs`, `diagnose_figure.rs` | a diagnosis, and its gap as a chart |
//! | `plan_page.rs` | a schedule judged or chosen |
//! | `reduction_page.rs` | from samples to readings |
//! | `noise_page.rs` | the noise of a record |
//! | `navigate.rs`, `navigate_diagnose.rs` | a mission, and a diagnosis of its errors |
//!
//! Deliberately absent: computation (a page shows what a report value says), colours (the template and `report::plot` have them), clocks
//! (the same report always gives the same bytes).

mod batch_page;
mod cells;
mod changes_page;
mod checks_page;
mod colophon;
mod compare_page;
mod conformity_page;
mod diagnose_figure;
mod diagnose_page;
mod escape;
mod fit_answer;
mod fit_correction;
mod fit_estimates;
mod fit_figures;
mod fit_page;
mod fit_readings;
#[cfg(feature = "navigate")]
mod navigate;
#[cfg(feature = "navigate")]
mod navigate_diagnose;
mod noise_page;
mod page;
mod plan_page;
mod reduction_page;
mod scatter_page;

pub use batch_page::batch_page;
pub use changes_page::{changes_page, history_page};
pub use compare_page::compare_page;
pub use diagnose_figure::diagnose_svg;
pub use diagnose_page::diagnose_page;
pub use fit_page::fit_page;
#[cfg(feature = "navigate")]
pub use navigate::navigate_page;
#[cfg(feature = "navigate")]
pub use navigate_diagnose::{navigate_diagnose_page, navigate_diagnose_svg};
pub use noise_page::noise_page;
pub use page::{Align, Column, Figure, MarkedLine, Page, PageBlock, Row, Section, Table, Tone};
pub use plan_page::plan_page;
pub use reduction_page::reduce_page;

use crate::error::{Fault, Malformed, Result};
use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior, Value, context};
use std::collections::BTreeMap;

/// Studentized residuals beyond this are marked.
const FAR: f64 = 3.0;

const TEMPLATE: &str = include_str!("../../../data/templates/page.html");
const STYLE: &str = include_str!("../../../data/templates/page.css");

/// A page as one HTML file.
///
/// Errors: none that a page can cause; a fault in the template is reported as `Value`.
///
/// ```
/// use tumble::report::html::{PageBlock, Page, Section, render};
/// let page = Page::new("A <b> page").section(Section::new("Result").prose("`V0` is 3 < 4"));
/// let html = render(&page)?;
/// assert!(html.contains("A &lt;b&gt; page") && html.contains(">V0</code> is 3 &lt; 4"));
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn render(page: &Page) -> Result<String> {
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
    let language = page.language;
    let tones = [("plain", Tone::Plain), ("good", Tone::Good), ("caution", Tone::Caution), ("bad", Tone::Bad)];
    let words: BTreeMap<&str, String> =
        tones.into_iter().map(|(name, tone)| (name, language.sentence(tone.word(language)))).collect();
    let page = Serde(page.clone().aligned());
    template
        .render(
            context! { page, words, language => language.tag(), style => Value::from_safe_string(STYLE.to_string()) },
        )
        .map_err(fault)
}
