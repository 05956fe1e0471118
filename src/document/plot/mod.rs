//! Charts as inline SVG: text is text, colours are told apart without colour vision and in print, nothing needs a font or the network.
//!
//! Sizes are in half points of the page (a figure as wide as the page is `WIDE`), so that whole pixels are fine enough. Data are scaled by a power
//! of a thousand before they are drawn; axis titles say which. The drawing itself is plotters' with its SVG backend only.
//!
//! | file | subject |
//! |---|---|
//! | `rows.rs` | estimates with their expanded uncertainties; budgets: variances in their parts |
//! | `residuals.rs` | residuals in the order of the readings, before and after a repair, and against normal quantiles |
//! | `lines.rs` | quantities against time, over calibrations, lots and devices |
//! | `maps.rs` | a correlation matrix, positions as spots, Allan deviations, a whole record with its segments |
//! | `scene.rs` | a bench in one position |
//! | `scale.rs`, `axes.rs` | powers of a thousand, ticks and their numbers; the frame of a chart, the rules at the ticks |
//!
//! Deliberately absent: computation; a chart gets the numbers that it shows.

mod axes;
mod lines;
mod maps;
mod residuals;
mod rows;
mod scale;
mod scene;

use super::chart::Chart;
use super::xml;
use crate::error::{Fault, Malformed, Result};
use crate::language::Language;
use crate::number;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
#[cfg(feature = "cli")]
pub(crate) use scene::{radius, seen, unseen};

/// Width of a figure as wide as the page.
const WIDE: u32 = 1856;
/// Width of a figure that shares the page with another.
const HALF: u32 = 900;
/// Size of the text; the SVG backend writes it divided by 1.24.
const TEXT: i32 = 31;
/// Room above a chart, for half of its highest label.
const TOP: u32 = 16;
const SMALL: i32 = 27;

const INK: RGBColor = RGBColor(0x1b, 0x1f, 0x24);
const SOFT: RGBColor = RGBColor(0x57, 0x60, 0x6a);
const RULE: RGBColor = RGBColor(0xd0, 0xd7, 0xde);
const TINT: RGBColor = RGBColor(0xf3, 0xf5, 0xf7);
/// Okabe and Ito's colours, apart for every kind of colour vision.
const BLUE: RGBColor = RGBColor(0x00, 0x72, 0xb2);
const VERMILLION: RGBColor = RGBColor(0xd5, 0x5e, 0x00);
const SKY: RGBColor = RGBColor(0x56, 0xb4, 0xe9);
const ORANGE: RGBColor = RGBColor(0xe6, 0x9f, 0x00);
const GREEN: RGBColor = RGBColor(0x00, 0x9e, 0x73);
const PURPLE: RGBColor = RGBColor(0xcc, 0x79, 0xa7);
const YELLOW: RGBColor = RGBColor(0xf0, 0xe4, 0x42);

/// A chart as inline SVG.
///
/// Errors: none that numbers or names can cause.
pub fn draw(chart: &Chart, lang: Language) -> Result<String> {
    match chart {
        Chart::Values(rows, unit) => rows::values(rows, unit, lang),
        Chart::Bars(rows, what, unit, wide) => rows::bars(rows, (what, unit), if *wide { WIDE } else { HALF }, lang),
        Chart::Residuals(rows, what, unit) => svg(WIDE, 430, |a| residuals::residuals(a, rows, what, unit, lang)),
        Chart::Normal(studentized) => residuals::normal(studentized, lang),
        Chart::Correlation(names, matrix) => maps::correlation(names, matrix),
        Chart::Gap(panels, factor) => residuals::gap(panels, factor, lang),
        Chart::Curves(curves, titles) => svg(HALF, 420, |area| lines::curves(area, curves, titles)),
        Chart::History(history) => svg(HALF, 380, |area| lines::history(area, history, lang)),
        Chart::Control(control) => svg(HALF, 380, |area| lines::control(area, control)),
        Chart::Distribution(chart) => svg(HALF, 400, |area| lines::distribution(area, chart, lang)),
        Chart::Deviations(points, title) => svg(WIDE, 730, |area| maps::deviations(area, points, title, lang)),
        Chart::Record(chart) => maps::record(chart, lang),
        Chart::Positions(spots, axes) => svg(HALF, 760, |area| maps::positions(area, spots, axes, lang)),
        Chart::Scene(scene) => svg(HALF, scene::HEIGHT, |area| scene::scene(area, scene, lang)),
    }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = std::result::Result<(), Box<dyn std::error::Error>>;

fn svg(width: u32, height: u32, draw: impl FnOnce(&Area<'_>) -> Drawn) -> Result<String> {
    let mut text = String::new();
    let drawn = {
        let area = SVGBackend::with_string(&mut text, (width, height + TOP)).into_drawing_area();
        draw(&area.margin(TOP, 0, 0, 0)).and_then(|()| Ok(area.present()?))
    };
    match drawn {
        Ok(()) => Ok(xml::printable(&text)),
        Err(error) => Err(Malformed::new(Fault::Value, format!("the chart cannot be drawn: {error}"))),
    }
}

/// Text of a size and colour, anchored where its point is.
fn style<'a>(size: i32, colour: &RGBColor, horizontal: HPos, vertical: VPos) -> TextStyle<'a> {
    ("sans-serif", size).into_font().color(colour).pos(Pos::new(horizontal, vertical))
}

/// Width that a text will have, near enough for margins and for leaving labels out.
fn text_width(text: &str, size: i32) -> i32 {
    let letters: f64 = text.chars().map(letter_width).sum();
    number::whole((letters * f64::from(size)).ceil())
}

/// Width of a character for text of size 1; a Chinese one is as wide as the text is high.
fn letter_width(c: char) -> f64 {
    if c >= '\u{2e80}' { 0.81 } else { 0.46 }
}

/// A label that fits into so much room: cut with an ellipsis if need be, control characters gone.
fn fitted(text: &str, size: i32, room: i32) -> String {
    let clean: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text_width(&clean, size) <= room {
        return clean;
    }
    let mut left = f64::from(room) / f64::from(size) - letter_width('\u{2026}');
    let mut cut = String::new();
    for c in clean.chars() {
        left -= letter_width(c);
        if left < 0.0 {
            break;
        }
        cut.push(c);
    }
    cut.push('\u{2026}');
    cut
}
