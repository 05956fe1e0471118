//! A control chart: the mean of each lot or date against the mean of all, with what devices within a lot scatter.

use super::{Area, BLUE, Drawn, HALF, INK, SMALL, SOFT, VERMILLION, rules, scale, style, svg};
use crate::document::chart::Control;
use crate::error::Result;
use crate::number;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

const LEFT: i32 = 120;
const TOP: i32 = 20;
const BOTTOM: i32 = 320;

/// A control chart.
pub(super) fn control(control: &Control) -> Result<String> {
    svg(HALF, (BOTTOM + 60) as u32, |area| draw(area, control))
}

fn draw(area: &Area<'_>, own: &Control) -> Drawn {
    let ends = || {
        let lots = own.lots.iter().flat_map(|(_, mean, _)| [*mean]);
        let bounds = own.lots.iter().flat_map(|(_, _, by)| [own.mean - by, own.mean + by]);
        lots.chain(bounds).filter(|v| v.is_finite())
    };
    let exponent = scale::readable_exponent(ends());
    let at = |v: f64| scale::scaled(v, exponent);
    let (low, high) = scale::range(ends().map(at), 0.08);
    let (left, right) = (LEFT, HALF as i32 - 20);
    let step = f64::from(right - left) / own.lots.len().max(1) as f64;
    let x = |k: f64| left + number::whole(((k + 0.5) * step).round());
    let level = |tick: f64| TOP + number::whole(((high - tick) / (high - low) * f64::from(BOTTOM - TOP)).round());
    let y = |v: f64| level(at(v));
    rules::level(area, scale::ticks(low, high, 5), (left, right), level)?;
    area.draw(&PathElement::new([(left, y(own.mean)), (right, y(own.mean))], SOFT.stroke_width(2)))?;
    for side in [-1.0, 1.0] {
        let line: Vec<(i32, i32)> = own
            .lots
            .iter()
            .enumerate()
            .filter(|(_, (_, _, by))| by.is_finite())
            .flat_map(|(k, (_, _, by))| [k as f64 - 0.5, k as f64 + 0.5].map(|k| (x(k), y(own.mean + side * by))))
            .collect();
        area.draw(&plotters::element::DashedPathElement::new(line, 12, 8, VERMILLION.stroke_width(2)))?;
    }
    let points: Vec<(i32, i32)> =
        own.lots.iter().enumerate().map(|(k, (_, mean, _))| (x(k as f64), y(*mean))).collect();
    area.draw(&PathElement::new(points.clone(), BLUE.stroke_width(1)))?;
    let radius = if own.lots.len() > 60 { 3 } else { 6 };
    for (place, (_, mean, by)) in points.iter().zip(&own.lots) {
        let inside = (mean - own.mean).abs() <= *by || !by.is_finite();
        match inside {
            true => area.draw(&Circle::new(*place, radius, BLUE.filled()))?,
            // a mark that does not need colour
            false => area.draw(&TriangleMarker::new(*place, radius + 5, VERMILLION.filled()))?,
        }
    }
    // as many names as there is room for
    let longest = own.lots.iter().map(|(name, ..)| name.chars().count()).max().unwrap_or(1).max(3) as f64;
    let every = number::count(((longest + 1.5) * 15.0 / step).ceil().max(1.0));
    for (k, (name, ..)) in own.lots.iter().enumerate().step_by(every) {
        let place = (x(k as f64), BOTTOM + 10);
        area.draw(&Text::new(name.clone(), place, style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
    }
    let title = scale::title(&own.label, &own.unit, exponent);
    area.draw(&Text::new(title, (left + 6, TOP - 16), style(SMALL, &INK, HPos::Left, VPos::Top)))?;
    Ok(())
}
