//! Deviations against averaging time, on logarithmic axes.

use super::{Area, BLUE, Drawn, INK, RULE, SMALL, SOFT, VERMILLION, WIDE, style, svg};
use crate::document::chart::DeviationPoint;
use crate::error::Result;
use crate::language::{Language, say};
use crate::number;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

const LEFT: i32 = 190;
const TOP: i32 = 20;
const BOTTOM: i32 = 640;

/// Deviations with their intervals, and the fitted line.
pub(super) fn deviations(points: &[DeviationPoint], title: &str, lang: Language) -> Result<String> {
    svg(WIDE, (BOTTOM + 90) as u32, |area| draw(area, points, title, lang))
}

/// Whole powers of ten that hold all values.
fn decades(values: impl Iterator<Item = f64>) -> (i32, i32) {
    let (mut low, mut high) = (i32::MAX, i32::MIN);
    for value in values.filter(|v| v.is_finite() && *v > 1e-290) {
        low = low.min(number::whole(value.log10().floor()));
        high = high.max(number::whole((value.log10() - 1e-9).ceil()));
    }
    if low > high { (0, 1) } else { (low, high.max(low + 1)) }
}

fn power(exponent: i32) -> String {
    match exponent {
        -3..=4 => format!("{}", 10f64.powi(exponent)),
        _ => format!("1e{exponent}"),
    }
}

fn draw(area: &Area<'_>, points: &[DeviationPoint], title: &str, lang: Language) -> Drawn {
    let (left, right) = (LEFT, WIDE as i32 - 30);
    let (first, last) = decades(points.iter().map(|p| p.tau));
    let (low, high) = decades(points.iter().flat_map(|p| [Some(p.value), p.fitted].into_iter().flatten()));
    let x = |v: f64| {
        left + number::whole((v.log10() - f64::from(first)) / f64::from(last - first) * f64::from(right - left))
    };
    let y = |v: f64| {
        let at = (f64::from(high) - v.max(1e-300).log10()) / f64::from(high - low);
        TOP + number::whole(at.clamp(-0.02, 1.02) * f64::from(BOTTOM - TOP))
    };
    let step = number::unsigned((last - first) / 12 + 1);
    for exponent in (first..=last).step_by(step) {
        let at = x(10f64.powi(exponent));
        area.draw(&PathElement::new([(at, TOP), (at, BOTTOM)], RULE.stroke_width(1)))?;
        area.draw(&Text::new(power(exponent), (at, BOTTOM + 10), style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
    }
    let step = number::unsigned((high - low) / 12 + 1);
    for exponent in (low..=high).step_by(step) {
        let at = y(10f64.powi(exponent));
        area.draw(&PathElement::new([(left, at), (right, at)], RULE.stroke_width(1)))?;
        area.draw(&Text::new(power(exponent), (left - 10, at), style(SMALL, &SOFT, HPos::Right, VPos::Center)))?;
    }
    let line: Vec<(i32, i32)> = points.iter().filter_map(|p| Some((x(p.tau), y(p.fitted?)))).collect();
    if line.len() > 1 {
        area.draw(&PathElement::new(line, VERMILLION.stroke_width(3)))?;
    }
    for p in points.iter().filter(|p| p.tau > 0.0 && p.value > 0.0 && p.value.is_finite()) {
        let at = x(p.tau);
        if let Some((from, to)) = p.interval {
            area.draw(&PathElement::new([(at, y(from)), (at, y(to))], BLUE.stroke_width(3)))?;
        }
        area.draw(&Circle::new((at, y(p.value)), 6, BLUE.filled()))?;
    }
    let turned = style(SMALL, &INK, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
    let clean: String = title.chars().filter(|c| !c.is_control()).collect();
    area.draw(&Text::new(clean, (8, (TOP + BOTTOM) / 2), turned))?;
    let place = ((left + right) / 2, BOTTOM + 52);
    area.draw(&Text::new(say!(lang, "averaging-time-s"), place, style(SMALL, &INK, HPos::Center, VPos::Top)))?;
    Ok(())
}
