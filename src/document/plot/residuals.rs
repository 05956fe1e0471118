//! Residuals: in the order of the readings, each with its own band; before and after a repair, on one axis, before the noise; against normal quantiles.

use super::axes::Frame;
use super::{
    Area, BLUE, Drawn, HALF, INK, SKY, SMALL, SOFT, TEXT, TINT, VERMILLION, WIDE, fitted, scale, style, svg, text_width,
};
use crate::document::chart::{GapPanel, GapPoint, Residual};
use crate::elements::Parts;
use crate::error::Result;
use crate::language::{Language, say};
use crate::number;
use crate::uncertainty::quantiles::normal_quantile;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Left end of the axes: room for the numbers.
const LEFT: i32 = 150;
/// Right end of the axes.
const RIGHT: i32 = WIDE as i32 - 24;
/// Height of the residuals in their order.
const PLOT: i32 = 330;

/// Residuals in order, each before its own band; `what` and `unit` title the axis.
pub(super) fn residuals(area: &Area<'_>, rows: &[Residual], what: &str, unit: &str, lang: Language) -> Drawn {
    let exponent = scale::exponent(rows.iter().flat_map(|r| [r.value, r.band.unwrap_or(0.0)]));
    let at = |v: f64| scale::scaled(v, exponent);
    let reach = rows.iter().flat_map(|r| [at(r.value).abs(), at(r.band.unwrap_or(0.0))]).fold(0.0, f64::max);
    let (low, high) = if reach > 0.0 { (-1.12 * reach, 1.12 * reach) } else { (-1.0, 1.0) };
    let frame = Frame { left: LEFT, right: RIGHT, top: 0, bottom: PLOT };
    let step = f64::from(RIGHT - LEFT) / rows.len().max(1) as f64;
    let x = |k: f64| LEFT + number::whole((step * k).round());
    let y = frame.y((low, high));
    let groups = runs(rows, |a, b| a.group == b.group);
    stripes(area, frame, &groups, x)?;
    frame.level(area, scale::ticks(low, high, 5), y)?;
    let width = (step * 0.36).clamp(1.0, 22.0);
    for (k, row) in rows.iter().enumerate() {
        let middle = k as f64 + 0.5;
        if let Some(band) = row.band.map(at).filter(|b| *b > 0.0) {
            let half = width / step;
            let corners = [(x(middle - half), y(band)), (x(middle + half), y(-band))];
            area.draw(&Rectangle::new(corners, SKY.mix(0.30).filled()))?;
        }
    }
    area.draw(&PathElement::new([(LEFT, y(0.0)), (RIGHT, y(0.0))], SOFT.stroke_width(2)))?;
    let size = number::whole((step * 0.22).clamp(3.0, 7.0));
    for (k, row) in rows.iter().enumerate() {
        let point = (x(k as f64 + 0.5), y(at(row.value)));
        if row.far {
            // a diamond, so that it does not need its colour
            let s = size + 4;
            let corners = [(0, -s), (s, 0), (0, s), (-s, 0)].map(|(dx, dy)| (point.0 + dx, point.1 + dy));
            area.draw(&Polygon::new(corners, VERMILLION.filled()))?;
            let below = row.value < 0.0;
            let place = (point.0, point.1 + if below { s + 4 } else { -s - 4 });
            let vertical = if below { VPos::Top } else { VPos::Bottom };
            area.draw(&Text::new(row.number.to_string(), place, style(SMALL, &VERMILLION, HPos::Center, vertical)))?;
        } else {
            area.draw(&Circle::new(point, size, BLUE.filled()))?;
        }
    }
    frame.at_side(area, scale::title(what, unit, exponent), &SOFT)?;
    numbers(area, frame, rows, &groups, &x, lang)
}

/// Labels of positions where they fit, else numbers of readings.
fn numbers(
    area: &Area<'_>,
    frame: Frame,
    rows: &[Residual],
    groups: &[(usize, usize)],
    x: &dyn Fn(f64) -> i32,
    lang: Language,
) -> Drawn {
    let label = |first: usize| rows.get(first).map_or("", |row| row.group.as_str());
    let named = groups.len() > 1 && groups.iter().all(|(first, _)| !label(*first).is_empty());
    let room = |first: usize, end: usize| x(end as f64) - x(first as f64);
    let fits = named && groups.iter().all(|(first, end)| text_width(label(*first), SMALL) <= room(*first, *end) - 4);
    let place = |middle: f64| (x(middle), PLOT + 10);
    let small = style(SMALL, &INK, HPos::Center, VPos::Top);
    if fits {
        for (first, end) in groups {
            let label = fitted(label(*first), SMALL, room(*first, *end));
            area.draw(&Text::new(label, place((*first + *end) as f64 / 2.0), small.clone()))?;
        }
    } else {
        let every = rows.len().div_ceil(24).max(1);
        for (k, row) in rows.iter().enumerate().filter(|(k, _)| k % every == 0) {
            area.draw(&Text::new(row.number.to_string(), place(k as f64 + 0.5), small.clone()))?;
        }
    }
    let what = if fits { say!(lang, "position") } else { say!(lang, "reading") };
    frame.below(area, what, 50, &SOFT)
}

const LEGEND: i32 = 52;
const LABELS: i32 = 44;
/// More points than this are drawn without the line from before to after.
const LINKED: usize = 150;

/// One panel for each sensor, one above the other; `factor` names what the readings are grouped by.
pub(super) fn gap(panels: &[GapPanel], factor: &str, lang: Language) -> Result<String> {
    let height = panel_height(panels.len());
    let total = LEGEND + number::signed(panels.len()) * (height + LABELS) + 40;
    svg(WIDE, total.unsigned_abs(), |area| {
        legend(area, panels, lang)?;
        for (k, panel) in panels.iter().enumerate() {
            draw_gap(area, panel, LEGEND + number::signed(k) * (height + LABELS), height)?;
        }
        let title = if factor.is_empty() {
            say!(lang, "readings-in-their-order").into()
        } else {
            say!(lang, "grouped-by", what = say!(lang, "readings").to_lowercase(), by = lang.name(factor))
        };
        let place = ((LEFT + RIGHT) / 2, total - 44);
        area.draw(&Text::new(title, place, style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
        Ok(())
    })
}

fn panel_height(panels: usize) -> i32 {
    match panels {
        0 | 1 => 460,
        2 => 330,
        3 => 250,
        _ => 190,
    }
}

fn legend(area: &Area<'_>, panels: &[GapPanel], lang: Language) -> Drawn {
    let points = || panels.iter().flat_map(|panel| &panel.points);
    let repaired = points().any(|p| p.after.is_some());
    let mut x = LEFT;
    let mut entry = |label: &str, draw: &dyn Fn(i32) -> Drawn| -> Drawn {
        draw(x + 14)?;
        area.draw(&Text::new(label.to_string(), (x + 40, 14), style(TEXT, &INK, HPos::Left, VPos::Center)))?;
        x += 90 + text_width(label, TEXT);
        Ok(())
    };
    let (first, after) = if repaired { (say!(lang, "before"), true) } else { (say!(lang, "residual"), false) };
    entry(first, &|x| Ok(area.draw(&Circle::new((x, 14), 7, VERMILLION.stroke_width(3)))?))?;
    if after {
        entry(say!(lang, "after"), &|x| Ok(area.draw(&Circle::new((x, 14), 7, BLUE.filled()))?))?;
    }
    if points().any(|p| p.band.is_some()) {
        let block = |x: i32| Rectangle::new([(x - 14, 2), (x + 16, 26)], SKY.mix(0.30).filled());
        entry(say!(lang, "noise-standard-deviations"), &|x| Ok(area.draw(&block(x))?))?;
    }
    Ok(())
}

fn draw_gap(area: &Area<'_>, panel: &GapPanel, top: i32, height: i32) -> Drawn {
    let points = &panel.points;
    let values = || points.iter().flat_map(|p| [p.before, p.after.unwrap_or(0.0)]);
    let exponent = scale::exponent(values().chain(points.iter().filter_map(|p| p.band)));
    let at = |v: f64| scale::scaled(v, exponent);
    let reach = values().map(|v| at(v).abs()).fold(0.0, f64::max);
    // the band may be wide where the noise is not known well: it must not squeeze the points
    let band = points.iter().filter_map(|p| p.band).map(|b| at(b).abs()).fold(0.0, f64::max);
    let reach = reach.max(band.min(2.0 * reach));
    let (low, high) = if reach > 0.0 { (-1.1 * reach, 1.1 * reach) } else { (-1.0, 1.0) };
    let frame = Frame { left: LEFT, right: RIGHT, top, bottom: top + height };
    let step = f64::from(RIGHT - LEFT) / points.len().max(1) as f64;
    let x = |k: f64| LEFT + number::whole((step * k).round());
    let level = frame.y((low, high));
    let y = |v: f64| level(v.clamp(low, high));
    let groups = runs(points, |a, b| a.group == b.group);
    stripes(area, frame, &groups, x)?;
    for (first, end) in runs(points, |a, b| a.band == b.band) {
        if let Some(half) = points.get(first).and_then(|p| p.band).map(at) {
            let corners = [(x(first as f64), y(half)), (x(end as f64), y(-half))];
            area.draw(&Rectangle::new(corners, SKY.mix(0.30).filled()))?;
        }
    }
    let ticks = scale::ticks(low, high, if height > 300 { 6 } else { 3 });
    frame.level(area, ticks, y)?;
    area.draw(&PathElement::new([(LEFT, y(0.0)), (RIGHT, y(0.0))], SOFT.stroke_width(2)))?;
    let size = number::whole((step * 0.3).clamp(2.0, 8.0));
    let place = |k: usize, v: f64| (x(k as f64 + 0.5), y(at(v)));
    if points.len() <= LINKED {
        for (k, point) in points.iter().enumerate() {
            if let Some(after) = point.after {
                let ends = [place(k, point.before), place(k, after)];
                area.draw(&PathElement::new(ends, SOFT.mix(0.5).stroke_width(1)))?;
            }
        }
    }
    for (k, point) in points.iter().enumerate() {
        let spot = place(k, point.before);
        if size > 3 {
            area.draw(&Circle::new(spot, size, VERMILLION.stroke_width(3)))?;
        } else {
            area.draw(&Circle::new(spot, size, VERMILLION.filled()))?;
        }
    }
    for (k, point) in points.iter().enumerate() {
        if let Some(after) = point.after {
            area.draw(&Circle::new(place(k, after), size, BLUE.filled()))?;
        }
    }
    for (first, end) in groups.iter().filter(|_| groups.len() > 1) {
        // the mean of a group before: what the eye should see among many points
        let part = points.part(*first..*end);
        let mean = part.iter().map(|p| at(p.before)).sum::<f64>() / part.len().max(1) as f64;
        if part.len() > 2 && mean.is_finite() {
            let ends = [(x(*first as f64) + 4, y(mean)), (x(*end as f64) - 4, y(mean))];
            area.draw(&PathElement::new(ends, VERMILLION.stroke_width(4)))?;
        }
    }
    let title = scale::title(&panel.title, &panel.unit, exponent);
    frame.at_side(area, fitted(&title, SMALL, height + LABELS), &SOFT)?;
    labels(area, points, &groups, &x, top + height + 10)
}

/// Every other of several groups on a stripe of its own.
fn stripes(area: &Area<'_>, frame: Frame, groups: &[(usize, usize)], x: impl Fn(f64) -> i32) -> Drawn {
    for (first, end) in groups.iter().step_by(2).filter(|_| groups.len() > 1) {
        let corners = [(x(*first as f64), frame.top), (x(*end as f64), frame.bottom)];
        area.draw(&Rectangle::new(corners, TINT.filled()))?;
    }
    Ok(())
}

/// Runs of neighbours that are alike: first, one past the last.
fn runs<T>(points: &[T], alike: impl Fn(&T, &T) -> bool) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (k, point) in points.iter().enumerate() {
        match runs.last_mut() {
            Some((first, end)) if points.get(*first).is_some_and(|before| alike(before, point)) => *end = k + 1,
            _ => runs.push((k, k + 1)),
        }
    }
    runs
}

/// Labels of groups, cut to the room that they have; those without room for two letters are left out.
fn labels(area: &Area<'_>, points: &[GapPoint], groups: &[(usize, usize)], x: &dyn Fn(f64) -> i32, top: i32) -> Drawn {
    for (first, end) in groups {
        let room = x(*end as f64) - x(*first as f64);
        let Some(point) = points.get(*first) else { continue };
        let label = fitted(&point.group, SMALL, room - 4);
        if room > 30 && !label.is_empty() {
            let place = (x((*first + *end) as f64 / 2.0), top);
            area.draw(&Text::new(label, place, style(SMALL, &INK, HPos::Center, VPos::Top)))?;
        }
    }
    Ok(())
}

/// More points than this are thinned evenly; their order keeps the shape.
const MOST: usize = 1000;

/// Sorted residuals over the normal quantiles at Blom's positions `(i - 3/8)/(n + 1/4)`, the line of the standard normal and its pointwise
/// 95 % band, `z +- 1.96 sqrt(p (1 - p)/n)/phi(z)`.
pub(super) fn normal(studentized: &[f64], lang: Language) -> Result<String> {
    let mut sorted: Vec<f64> = studentized.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let every = sorted.len().div_ceil(MOST).max(1);
    let points: Vec<[f64; 3]> = sorted
        .iter()
        .enumerate()
        .filter(|(k, _)| k % every == 0 || k + 1 == sorted.len())
        .filter_map(|(k, value)| {
            let p = (k as f64 + 0.625) / (n + 0.25);
            let z = normal_quantile(p)?;
            let density = (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
            Some([z, value.clamp(-1e6, 1e6), 1.96 * (p * (1.0 - p) / n).sqrt() / density])
        })
        .collect();
    let frame = Frame { left: 120, right: HALF as i32 - 24, top: 0, bottom: 560 };
    let (left_z, right_z) = scale::range(points.iter().map(|[z, ..]| *z).chain([-1.0, 1.0]), 0.06);
    let ends = points.iter().flat_map(|[z, value, band]| [*value, z - band, z + band]);
    let (low, high) = scale::range(ends.chain([-1.0, 1.0]), 0.06);
    let (x, y) = (frame.x((left_z, right_z)), frame.y((low, high)));
    svg(HALF, 644, |area| {
        frame.upright(area, scale::ticks(left_z, right_z, 7), x)?;
        frame.level(area, scale::ticks(low, high, 7), y)?;
        let upper = points.iter().map(|[z, _, band]| (x(*z), y(z + band)));
        let lower = points.iter().rev().map(|[z, _, band]| (x(*z), y(z - band)));
        let outline: Vec<(i32, i32)> = upper.chain(lower).collect();
        if outline.len() > 3 {
            area.draw(&Polygon::new(outline, SKY.mix(0.22).filled()))?;
        }
        let (from, to) = (left_z.max(low), right_z.min(high));
        area.draw(&PathElement::new([(x(from), y(from)), (x(to), y(to))], SOFT.stroke_width(2)))?;
        area.draw(&Rectangle::new([(frame.left, 0), (frame.right, frame.bottom)], SOFT.stroke_width(2)))?;
        for [z, value, _] in &points {
            area.draw(&Circle::new((x(*z), y(*value)), 6, BLUE.filled()))?;
        }
        frame.below(area, say!(lang, "normal-quantile"), 46, &SOFT)?;
        frame.at_side(area, say!(lang, "studentized-residual"), &SOFT)
    })
}
