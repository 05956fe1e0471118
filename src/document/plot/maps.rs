//! A correlation matrix, the positions of a schedule over two joint angles, Allan deviations over averaging time, a whole record.

use super::axes::Frame;
use super::{
    Area, BLUE, Drawn, HALF, INK, RULE, SMALL, SOFT, TINT, VERMILLION, WIDE, fitted, scale, style, svg, text_width,
};
use crate::document::chart::{DeviationPoint, RecordChart, Spot};
use crate::error::Result;
use crate::language::{Language, say};
use crate::number;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

/// Correlations as a map of cells: blue for positive, orange for negative, in hundredths where there is room.
///
/// A cell without a number is crossed out. Above 14 names the map is as wide as the page.
pub(super) fn correlation(names: &[String], matrix: &[Vec<Option<f64>>]) -> Result<String> {
    let wide = names.len() > 14;
    let left = names.iter().map(|n| text_width(n, SMALL)).max().unwrap_or(0).clamp(60, 220) + 20;
    let width = if wide { WIDE } else { HALF } as i32;
    let cells = number::signed(names.len().max(1));
    let cell = ((width - left - 24) / cells, ((width - left - 24) / cells).min(64).max(if wide { 34 } else { 0 }));
    let height = cell.1 * cells + left + 24;
    let n = number::signed(names.len());
    svg(width.unsigned_abs(), height.max(1).unsigned_abs(), |area| {
        for (i, name) in names.iter().enumerate() {
            let name = fitted(name, SMALL, left - 16);
            let i = number::signed(i);
            let row = (left - 12, cell.1 * i + cell.1 / 2);
            area.draw(&Text::new(name.clone(), row, style(SMALL, &INK, HPos::Right, VPos::Center)))?;
            let turned = style(SMALL, &INK, HPos::Right, VPos::Center).transform(FontTransform::Rotate270);
            area.draw(&Text::new(name, (left + cell.0 * i + cell.0 / 2, cell.1 * n + 12), turned))?;
        }
        for (i, row) in matrix.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                let (x, y) = (left + cell.0 * number::signed(j), cell.1 * number::signed(i));
                let corners = [(x, y), (x + cell.0, y + cell.1)];
                let middle = (x + cell.0 / 2, y + cell.1 / 2);
                match value.filter(|v| v.is_finite()).map(|v| v.clamp(-1.0, 1.0)) {
                    Some(r) => {
                        let colour = if r < 0.0 { VERMILLION } else { BLUE };
                        // the diagonal is always one: grey, so that the eye goes elsewhere
                        let fill = if i == j { RULE.filled() } else { colour.mix(0.9 * r.abs()).filled() };
                        area.draw(&Rectangle::new(corners, fill))?;
                        let digits = (100.0 * r).round();
                        if i != j && cell.0 >= 44 {
                            let ink = if r.abs() > 0.6 {
                                WHITE
                            } else if digits == 0.0 {
                                SOFT
                            } else {
                                INK
                            };
                            let text = scale::label(digits, 0);
                            area.draw(&Text::new(text, middle, style(SMALL - 4, &ink, HPos::Center, VPos::Center)))?;
                        }
                    }
                    None => {
                        area.draw(&Rectangle::new(corners, TINT.filled()))?;
                        area.draw(&Text::new("\u{d7}", middle, style(SMALL, &SOFT, HPos::Center, VPos::Center)))?;
                    }
                }
                area.draw(&Rectangle::new(corners, RULE.stroke_width(1)))?;
            }
        }
        Ok(())
    })
}

/// Candidates as dots, the given schedule as squares, the better one as discs with the number of readings beside them.
pub(super) fn positions(area: &Area<'_>, spots: &[Vec<Spot>; 3], axes: &[String; 2], lang: Language) -> Drawn {
    let [candidates, given, better] = spots;
    let all = || spots.iter().flatten();
    let (x_low, x_high) = scale::range(all().map(|s| s.x), 0.08);
    let (y_low, y_high) = scale::range(all().map(|s| s.y), 0.08);
    let frame = Frame { left: 110, right: HALF as i32 - 24, top: 10, bottom: 664 };
    let x = frame.x((x_low, x_high));
    // from the bottom, as halves of a pixel are rounded there
    let (bottom, room) = (frame.bottom, f64::from(frame.bottom - frame.top));
    let y = |v: f64| bottom - number::whole(((v - y_low) / (y_high - y_low) * room).round());
    let quarters = |low: f64, high: f64| {
        let step = if high - low > 500.0 { 180 } else { 90 };
        (-8..=8).map(move |k| f64::from(k * step)).filter(move |v| (low..=high).contains(v))
    };
    frame.along(area, quarters(x_low, x_high).map(|tick| (x(tick), format!("{tick:.0}"))))?;
    frame.across(area, quarters(y_low, y_high).map(|tick| (y(tick), format!("{tick:.0}"))), 12)?;
    let title = match axes.each_ref().map(String::as_str) {
        [across, ""] => format!("{across} (deg)"),
        [across, up] => say!(lang, "deg-across-deg-up", across, up),
    };
    frame.below(area, title, 50, &SOFT)?;
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

/// Deviations with their intervals, and the fitted line.
pub(super) fn deviations(area: &Area<'_>, points: &[DeviationPoint], title: &str, lang: Language) -> Drawn {
    let frame = Frame { left: 190, right: WIDE as i32 - 30, top: 20, bottom: 640 };
    let Frame { left, right, top, bottom } = frame;
    let (first, last) = decades(points.iter().map(|p| p.tau));
    let (low, high) = decades(points.iter().flat_map(|p| [Some(p.value), p.fitted].into_iter().flatten()));
    let x = |v: f64| {
        left + number::whole((v.log10() - f64::from(first)) / f64::from(last - first) * f64::from(right - left))
    };
    let y = |v: f64| {
        let at = (f64::from(high) - v.max(1e-300).log10()) / f64::from(high - low);
        top + number::whole(at.clamp(-0.02, 1.02) * f64::from(bottom - top))
    };
    let powers = |low: i32, high: i32| (low..=high).step_by(number::unsigned((high - low) / 12 + 1));
    frame.along(area, powers(first, last).map(|exponent| (x(10f64.powi(exponent)), power(exponent))))?;
    frame.across(area, powers(low, high).map(|exponent| (y(10f64.powi(exponent)), power(exponent))), 10)?;
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
    frame.at_side(area, title.replace(|c: char| c.is_control(), ""), &INK)?;
    frame.below(area, say!(lang, "averaging-time-s"), 52, &INK)
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

const PANEL: i32 = 190;

/// All channels of a record against time, segments shaded.
pub(super) fn record(chart: &RecordChart, lang: Language) -> Result<String> {
    let height = PANEL * number::signed(chart.channels.len().max(1)) + 80;
    svg(WIDE, height.unsigned_abs(), |area| {
        let (left, right) = (190, WIDE as i32 - 20);
        let end = chart.end;
        let x = |t: f64| left + number::whole((t / end * f64::from(right - left)).round());
        let bottom = PANEL * number::signed(chart.channels.len());
        for (from, to) in &chart.segments {
            let (from, to) = (x(*from), x(*to).max(x(*from) + 1));
            area.draw(&Rectangle::new([(from, 4), (to, bottom - 6)], TINT.filled()))?;
            area.draw(&PathElement::new([(from, 4), (from, bottom - 6)], RULE.stroke_width(1)))?;
            area.draw(&PathElement::new([(to, 4), (to, bottom - 6)], RULE.stroke_width(1)))?;
        }
        for (k, (title, course)) in chart.channels.iter().enumerate() {
            let top = PANEL * number::signed(k) + 8;
            let low_y = top + PANEL - 24;
            let (low, high) = scale::range(course.iter().map(|(_, v)| *v), 0.05);
            let y = |v: f64| low_y - number::whole(((v - low) / (high - low) * f64::from(low_y - top)).round());
            let (ticks, decimals) = scale::ticks(low, high, 3);
            for tick in ticks {
                let label = scale::label(tick, decimals);
                area.draw(&Text::new(label, (left - 10, y(tick)), style(SMALL, &SOFT, HPos::Right, VPos::Center)))?;
            }
            let path: Vec<(i32, i32)> = course.iter().map(|(t, v)| (x(*t), y(*v))).collect();
            area.draw(&PathElement::new(path, BLUE.stroke_width(2)))?;
            area.draw(&PathElement::new([(left, low_y + 8), (right, low_y + 8)], RULE.stroke_width(1)))?;
            let name: String = title.chars().filter(|c| !c.is_control()).collect();
            area.draw(&Text::new(name, (8, top), style(SMALL, &INK, HPos::Left, VPos::Top)))?;
        }
        let (ticks, decimals) = scale::ticks(0.0, end, 8);
        for tick in ticks {
            let place = (x(tick), bottom + 4);
            area.draw(&Text::new(scale::label(tick, decimals), place, style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
        }
        let frame = Frame { left, right, top: 0, bottom };
        frame.below(area, say!(lang, "time-since-the-first-sample-s"), 38, &INK)
    })
}
