//! The gap in one picture: each reading's residual with the model as given and with what was found, on one axis, before the noise.

use super::{
    Area, BLUE, Drawn, INK, SKY, SMALL, SOFT, TEXT, TINT, VERMILLION, WIDE, fitted, rules, scale, style, svg,
    text_width,
};
use crate::document::chart::{GapPanel, GapPoint};
use crate::elements::Parts;
use crate::error::Result;
use crate::language::{Language, say};
use crate::number;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

const LEFT: i32 = 150;
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
            draw(area, panel, LEGEND + number::signed(k) * (height + LABELS), height)?;
        }
        let title = if factor.is_empty() {
            say!(lang, "readings-in-their-order").into()
        } else {
            say!(lang, "grouped-by", what = say!(lang, "readings").to_lowercase(), by = lang.name(factor))
        };
        let place = ((LEFT + right()) / 2, total - 44);
        area.draw(&Text::new(title, place, style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
        Ok(())
    })
}

fn right() -> i32 {
    WIDE as i32 - 24
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

fn draw(area: &Area<'_>, panel: &GapPanel, top: i32, height: i32) -> Drawn {
    let points = &panel.points;
    let values = || points.iter().flat_map(|p| [p.before, p.after.unwrap_or(0.0)]);
    let exponent = scale::exponent(values().chain(points.iter().filter_map(|p| p.band)));
    let at = |v: f64| scale::scaled(v, exponent);
    let reach = values().map(|v| at(v).abs()).fold(0.0, f64::max);
    // the band may be wide where the noise is not known well: it must not squeeze the points
    let band = points.iter().filter_map(|p| p.band).map(|b| at(b).abs()).fold(0.0, f64::max);
    let reach = reach.max(band.min(2.0 * reach));
    let (low, high) = if reach > 0.0 { (-1.1 * reach, 1.1 * reach) } else { (-1.0, 1.0) };
    let step = f64::from(right() - LEFT) / points.len().max(1) as f64;
    let x = |k: f64| LEFT + number::whole((step * k).round());
    let y = |v: f64| top + number::whole(((high - v.clamp(low, high)) / (high - low) * f64::from(height)).round());
    let groups = runs(points, |a, b| a.group == b.group);
    for (k, (first, end)) in groups.iter().enumerate() {
        if k % 2 == 0 && groups.len() > 1 {
            area.draw(&Rectangle::new([(x(*first as f64), top), (x(*end as f64), top + height)], TINT.filled()))?;
        }
    }
    for (first, end) in runs(points, |a, b| a.band == b.band) {
        if let Some(half) = points.get(first).and_then(|p| p.band).map(at) {
            let corners = [(x(first as f64), y(half)), (x(end as f64), y(-half))];
            area.draw(&Rectangle::new(corners, SKY.mix(0.30).filled()))?;
        }
    }
    let ticks = scale::ticks(low, high, if height > 300 { 6 } else { 3 });
    rules::level(area, ticks, (LEFT, right()), y)?;
    area.draw(&PathElement::new([(LEFT, y(0.0)), (right(), y(0.0))], SOFT.stroke_width(2)))?;
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
        let own = points.part(*first..*end);
        let mean = own.iter().map(|p| at(p.before)).sum::<f64>() / own.len().max(1) as f64;
        if own.len() > 2 && mean.is_finite() {
            let ends = [(x(*first as f64) + 4, y(mean)), (x(*end as f64) - 4, y(mean))];
            area.draw(&PathElement::new(ends, VERMILLION.stroke_width(4)))?;
        }
    }
    let title = style(SMALL, &SOFT, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
    let text = scale::title(&panel.title, &panel.unit, exponent);
    area.draw(&Text::new(fitted(&text, SMALL, height + LABELS), (8, top + height / 2), title))?;
    labels(area, points, &groups, &x, top + height + 10)
}

/// Runs of neighbours that are alike: first, one past the last.
fn runs(points: &[GapPoint], alike: impl Fn(&GapPoint, &GapPoint) -> bool) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (k, point) in points.iter().enumerate() {
        match runs.last_mut() {
            Some((first, end)) if points.get(*first).is_some_and(|own| alike(own, point)) => *end = k + 1,
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
