//! A quantity over calendar time: each calibration with its expanded uncertainty, the trend, the limits.

use super::{Area, BLUE, Drawn, HALF, SMALL, SOFT, VERMILLION, rules, scale, style, svg};
use crate::document::chart::History;
use crate::error::Result;
use crate::language::{Language, say};
use crate::number;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

const LEFT: i32 = 120;
const TOP: i32 = 20;
const BOTTOM: i32 = 300;

/// A quantity over time.
pub(super) fn history(history: &History, lang: Language) -> Result<String> {
    svg(HALF, (BOTTOM + 80) as u32, |area| draw(area, history, lang))
}

fn draw(area: &Area<'_>, history: &History, lang: Language) -> Drawn {
    let ends = || {
        let points = history.points.iter().flat_map(|(_, v, u)| [v - u, v + u]);
        let trend = history.trend.iter().flatten().map(|p| p.1);
        points.chain(trend).chain(history.limits.iter().flatten().copied()).filter(|v| v.is_finite())
    };
    let exponent = scale::readable_exponent(ends());
    let at = |v: f64| scale::scaled(v, exponent);
    let (low, high) = scale::range(ends().map(at), 0.08);
    let years = history.points.iter().map(|p| p.0).chain(history.trend.iter().flatten().map(|p| p.0));
    let (first, last) = scale::range(years, 0.06);
    let (left, right) = (LEFT, HALF as i32 - 20);
    let x = |v: f64| left + number::whole(((v - first) / (last - first) * f64::from(right - left)).round());
    let y = |v: f64| TOP + number::whole(((high - at(v)) / (high - low) * f64::from(BOTTOM - TOP)).round());
    let level = |tick: f64| TOP + number::whole(((high - tick) / (high - low) * f64::from(BOTTOM - TOP)).round());
    rules::level(area, scale::ticks(low, high, 5), (left, right), level)?;
    rules::axis(area, scale::ticks(first, last, 5), (left, right, BOTTOM), x)?;
    for limit in history.limits.iter().flatten().filter(|limit| limit.is_finite()) {
        let line = vec![(left, y(*limit)), (right, y(*limit))];
        area.draw(&plotters::element::DashedPathElement::new(line, 12, 8, VERMILLION.stroke_width(2)))?;
    }
    if let Some([from, to]) = history.trend {
        area.draw(&PathElement::new([(x(from.0), y(from.1)), (x(to.0), y(to.1))], SOFT.stroke_width(2)))?;
    }
    for (year, value, expanded) in &history.points {
        let (px, from, to) = (x(*year), y(value - expanded), y(value + expanded));
        area.draw(&PathElement::new([(px, from), (px, to)], BLUE.stroke_width(3)))?;
        for end in [from, to] {
            area.draw(&PathElement::new([(px - 8, end), (px + 8, end)], BLUE.stroke_width(3)))?;
        }
        area.draw(&Circle::new((px, y(*value)), 6, BLUE.filled()))?;
    }
    let title = style(SMALL, &SOFT, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
    area.draw(&Text::new(scale::title(&history.label, &history.unit, exponent), (8, (TOP + BOTTOM) / 2), title))?;
    let place = ((left + right) / 2, BOTTOM + 46);
    area.draw(&Text::new(say!(lang, "year").to_string(), place, style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
    Ok(())
}
