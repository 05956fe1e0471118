//! Residuals of one sensor in the order of the readings, each with its own band.

use super::{
    Area, BLUE, Drawn, INK, SKY, SMALL, SOFT, TINT, VERMILLION, WIDE, fitted, rules, scale, style, svg, text_width,
};
use crate::document::chart::Residual;
use crate::error::Result;
use crate::language::{Language, say};
use crate::number;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

const LEFT: i32 = 150;
const PLOT: i32 = 330;

/// Residuals in order, each before its own band; `what` and `unit` title the axis.
pub(super) fn residuals(rows: &[Residual], what: &str, unit: &str, lang: Language) -> Result<String> {
    svg(WIDE, (PLOT + 100) as u32, |area| draw(area, rows, what, unit, lang))
}

fn draw(area: &Area<'_>, rows: &[Residual], what: &str, unit: &str, lang: Language) -> Drawn {
    let exponent = scale::exponent(rows.iter().flat_map(|r| [r.value, r.band.unwrap_or(0.0)]));
    let at = |v: f64| scale::scaled(v, exponent);
    let reach = rows.iter().flat_map(|r| [at(r.value).abs(), at(r.band.unwrap_or(0.0))]).fold(0.0, f64::max);
    let (low, high) = if reach > 0.0 { (-1.12 * reach, 1.12 * reach) } else { (-1.0, 1.0) };
    let right = WIDE as i32 - 24;
    let step = f64::from(right - LEFT) / rows.len().max(1) as f64;
    let x = |k: f64| LEFT + number::whole((step * k).round());
    let y = |v: f64| number::whole(((high - v) / (high - low) * f64::from(PLOT)).round());
    let groups = groups(rows);
    for (k, (first, last, _)) in groups.iter().enumerate() {
        if k % 2 == 0 && groups.len() > 1 {
            let corners = [(x(*first as f64), 0), (x(*last as f64), PLOT)];
            area.draw(&Rectangle::new(corners, TINT.filled()))?;
        }
    }
    rules::level(area, scale::ticks(low, high, 5), (LEFT, right), y)?;
    let width = (step * 0.36).clamp(1.0, 22.0);
    for (k, row) in rows.iter().enumerate() {
        let middle = k as f64 + 0.5;
        if let Some(band) = row.band.map(at).filter(|b| *b > 0.0) {
            let half = width / step;
            let corners = [(x(middle - half), y(band)), (x(middle + half), y(-band))];
            area.draw(&Rectangle::new(corners, SKY.mix(0.30).filled()))?;
        }
    }
    area.draw(&PathElement::new([(LEFT, y(0.0)), (right, y(0.0))], SOFT.stroke_width(2)))?;
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
    let title = style(SMALL, &SOFT, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
    area.draw(&Text::new(scale::title(what, unit, exponent), (8, PLOT / 2), title))?;
    labels(area, rows, &groups, &x, lang)
}

/// Runs of neighbours with one label: first, one past the last, label.
fn groups(rows: &[Residual]) -> Vec<(usize, usize, &str)> {
    let mut groups: Vec<(usize, usize, &str)> = Vec::new();
    for (k, row) in rows.iter().enumerate() {
        match groups.last_mut() {
            Some((_, end, label)) if *label == row.group => *end = k + 1,
            _ => groups.push((k, k + 1, &row.group)),
        }
    }
    groups
}

/// Labels of positions where they fit, else numbers of readings.
fn labels(
    area: &Area<'_>,
    rows: &[Residual],
    groups: &[(usize, usize, &str)],
    x: &dyn Fn(f64) -> i32,
    lang: Language,
) -> Drawn {
    let named = groups.len() > 1 && groups.iter().all(|(_, _, label)| !label.is_empty());
    let room = |first: usize, end: usize| x(end as f64) - x(first as f64);
    let fits = named && groups.iter().all(|(first, end, label)| text_width(label, SMALL) <= room(*first, *end) - 4);
    let place = |middle: f64| (x(middle), PLOT + 10);
    let small = style(SMALL, &INK, HPos::Center, VPos::Top);
    if fits {
        for (first, end, label) in groups {
            let label = fitted(label, SMALL, room(*first, *end));
            area.draw(&Text::new(label, place((*first + *end) as f64 / 2.0), small.clone()))?;
        }
    } else {
        let every = rows.len().div_ceil(24).max(1);
        for (k, row) in rows.iter().enumerate().filter(|(k, _)| k % every == 0) {
            area.draw(&Text::new(row.number.to_string(), place(k as f64 + 0.5), small.clone()))?;
        }
    }
    let what = if fits { say!(lang, "position") } else { say!(lang, "reading") };
    let middle = (LEFT + WIDE as i32 - 24) / 2;
    area.draw(&Text::new(what, (middle, PLOT + 50), style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
    Ok(())
}
