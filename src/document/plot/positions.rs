//! Positions of a schedule over two joint angles.

use super::{Area, BLUE, Drawn, HALF, RULE, SMALL, SOFT, VERMILLION, scale, style, svg};
use crate::document::chart::Spot;
use crate::error::Result;
use crate::language::{Language, say};
use crate::number;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Candidates as dots, the given schedule as squares, the better one as discs with the number of readings beside them.
pub(super) fn positions(
    candidates: &[Spot],
    given: &[Spot],
    better: &[Spot],
    axes: &[String; 2],
    lang: Language,
) -> Result<String> {
    svg(HALF, HEIGHT as u32, |area| draw(area, candidates, given, better, axes, lang))
}

const HEIGHT: i32 = 760;

fn draw(
    area: &Area<'_>,
    candidates: &[Spot],
    given: &[Spot],
    better: &[Spot],
    axes: &[String; 2],
    lang: Language,
) -> Drawn {
    let all = || candidates.iter().chain(given).chain(better);
    let (x_low, x_high) = scale::range(all().map(|s| s.x), 0.08);
    let (y_low, y_high) = scale::range(all().map(|s| s.y), 0.08);
    let (left, right, top, bottom) = (110, HALF as i32 - 24, 10, HEIGHT - 96);
    let x = |v: f64| left + number::whole(((v - x_low) / (x_high - x_low) * f64::from(right - left)).round());
    let y = |v: f64| bottom - number::whole(((v - y_low) / (y_high - y_low) * f64::from(bottom - top)).round());
    let quarters = |low: f64, high: f64| {
        let step = if high - low > 500.0 { 180 } else { 90 };
        (-8..=8).map(move |k| f64::from(k * step)).filter(move |v| (low..=high).contains(v))
    };
    for tick in quarters(x_low, x_high) {
        area.draw(&PathElement::new([(x(tick), top), (x(tick), bottom)], RULE.stroke_width(1)))?;
        let place = (x(tick), bottom + 10);
        area.draw(&Text::new(format!("{tick:.0}"), place, style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
    }
    for tick in quarters(y_low, y_high) {
        area.draw(&PathElement::new([(left, y(tick)), (right, y(tick))], RULE.stroke_width(1)))?;
        let place = (left - 12, y(tick));
        area.draw(&Text::new(format!("{tick:.0}"), place, style(SMALL, &SOFT, HPos::Right, VPos::Center)))?;
    }
    let title = match axes.each_ref().map(String::as_str) {
        [across, ""] => format!("{across} (deg)"),
        [across, up] => say!(lang, "deg-across-deg-up", across, up),
    };
    area.draw(&Text::new(title, ((left + right) / 2, bottom + 50), style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
    for spot in candidates {
        area.draw(&Circle::new((x(spot.x), y(spot.y)), 3, SOFT.mix(0.6).filled()))?;
    }
    for spot in given {
        let (px, py) = (x(spot.x), y(spot.y));
        let corners = [(-18, -18), (18, -18), (18, 18), (-18, 18), (-18, -20)].map(|(dx, dy)| (px + dx, py + dy));
        area.draw(&PathElement::new(corners, VERMILLION.stroke_width(4)))?;
    }
    for spot in better {
        let (px, py) = (x(spot.x), y(spot.y));
        area.draw(&Circle::new((px, py), 12, BLUE.filled()))?;
        let label = spot.readings.to_string();
        area.draw(&Text::new(label, (px + 22, py - 22), style(SMALL, &BLUE, HPos::Left, VPos::Bottom)))?;
    }
    Ok(())
}
