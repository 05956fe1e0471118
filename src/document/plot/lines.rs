//! A quantity over something: curves over time, a quantity over calendar time, over lots, over devices.

use super::axes::Frame;
use super::{
    Area, BLUE, Drawn, GREEN, HALF, INK, ORANGE, PURPLE, SKY, SMALL, SOFT, VERMILLION, scale, style, text_width,
};
use crate::document::chart::{Control, Curve, Distribution, History};
use crate::language::{Language, say};
use crate::number;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Left end of the axes: room for the numbers.
const LEFT: i32 = 120;

/// Curves on one axis; `what` and `unit` title it, `along` titles the axis of time.
pub(super) fn curves(area: &Area<'_>, curves: &[Curve], [what, unit, along]: &[String; 3]) -> Drawn {
    let finite = || curves.iter().flat_map(|c| &c.points).filter(|(x, y)| x.is_finite() && y.is_finite());
    let exponent = scale::readable_exponent(finite().map(|(_, y)| *y));
    let at = |y: f64| scale::scaled(y, exponent);
    let frame = Frame { left: LEFT, right: HALF as i32 - 20, top: 40, bottom: 340 };
    let (first, last) = scale::range(finite().map(|(x, _)| *x), 0.0);
    let (low, high) = scale::range(finite().map(|(_, y)| at(*y)).chain([0.0]), 0.05);
    let (x, y) = (frame.x((first, last)), frame.y((low, high)));
    frame.level(area, scale::ticks(low, high, 5), y)?;
    frame.axis(area, scale::ticks(first, last, 6), x)?;
    let colours = [SOFT, VERMILLION, BLUE, GREEN, ORANGE, PURPLE];
    let mut legend = LEFT + 4;
    let mut dashed = Vec::new();
    for (curve, colour) in curves.iter().zip(colours.iter().cycle()) {
        let finite = curve.points.iter().filter(|(x, y)| x.is_finite() && y.is_finite());
        let path: Vec<(i32, i32)> = finite.map(|(px, py)| (x(*px), y(at(*py)))).collect();
        let sample = vec![(legend, 16), (legend + 50, 16)];
        for path in [path, sample].into_iter().filter(|path| path.len() > 1) {
            if curve.dashed {
                dashed.push((path, colour));
            } else {
                area.draw(&PathElement::new(path, colour.stroke_width(3)))?;
            }
        }
        let place = (legend + 58, 16);
        area.draw(&Text::new(curve.label.clone(), place, style(SMALL, &SOFT, HPos::Left, VPos::Center)))?;
        legend += 90 + text_width(&curve.label, SMALL);
    }
    // over the solid ones, which show through its gaps
    for (path, colour) in dashed {
        area.draw(&DashedPathElement::new(path, 12, 8, colour.stroke_width(3)))?;
    }
    frame.at_side(area, scale::title(what, unit, exponent), &SOFT)?;
    frame.below(area, along.as_str(), 46, &SOFT)
}

/// A quantity over time.
pub(super) fn history(area: &Area<'_>, history: &History, lang: Language) -> Drawn {
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
    let frame = Frame { left: LEFT, right: HALF as i32 - 20, top: 20, bottom: 300 };
    let (x, level) = (frame.x((first, last)), frame.y((low, high)));
    let y = |v: f64| level(at(v));
    frame.level(area, scale::ticks(low, high, 5), level)?;
    frame.axis(area, scale::ticks(first, last, 5), x)?;
    for limit in history.limits.iter().flatten().filter(|limit| limit.is_finite()) {
        let line = vec![(frame.left, y(*limit)), (frame.right, y(*limit))];
        area.draw(&DashedPathElement::new(line, 12, 8, VERMILLION.stroke_width(2)))?;
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
    frame.at_side(area, scale::title(&history.label, &history.unit, exponent), &SOFT)?;
    frame.below(area, say!(lang, "year"), 46, &SOFT)
}

pub(super) fn control(area: &Area<'_>, chart: &Control) -> Drawn {
    let ends = || {
        let lots = chart.lots.iter().flat_map(|(_, mean, _)| [*mean]);
        let bounds = chart.lots.iter().flat_map(|(_, _, by)| [chart.mean - by, chart.mean + by]);
        lots.chain(bounds).filter(|v| v.is_finite())
    };
    let exponent = scale::readable_exponent(ends());
    let at = |v: f64| scale::scaled(v, exponent);
    let (low, high) = scale::range(ends().map(at), 0.08);
    let frame = Frame { left: LEFT, right: HALF as i32 - 20, top: 20, bottom: 320 };
    let Frame { left, right, top, bottom } = frame;
    let step = f64::from(right - left) / chart.lots.len().max(1) as f64;
    let x = |k: f64| left + number::whole(((k + 0.5) * step).round());
    let level = frame.y((low, high));
    let y = |v: f64| level(at(v));
    frame.level(area, scale::ticks(low, high, 5), level)?;
    area.draw(&PathElement::new([(left, y(chart.mean)), (right, y(chart.mean))], SOFT.stroke_width(2)))?;
    for side in [-1.0, 1.0] {
        let line: Vec<(i32, i32)> = chart
            .lots
            .iter()
            .enumerate()
            .filter(|(_, (_, _, by))| by.is_finite())
            .flat_map(|(k, (_, _, by))| [k as f64 - 0.5, k as f64 + 0.5].map(|k| (x(k), y(chart.mean + side * by))))
            .collect();
        area.draw(&DashedPathElement::new(line, 12, 8, VERMILLION.stroke_width(2)))?;
    }
    let points: Vec<(i32, i32)> =
        chart.lots.iter().enumerate().map(|(k, (_, mean, _))| (x(k as f64), y(*mean))).collect();
    area.draw(&PathElement::new(points.clone(), BLUE.stroke_width(1)))?;
    let radius = if chart.lots.len() > 60 { 3 } else { 6 };
    for (place, (_, mean, by)) in points.iter().zip(&chart.lots) {
        let inside = (mean - chart.mean).abs() <= *by || !by.is_finite();
        match inside {
            true => area.draw(&Circle::new(*place, radius, BLUE.filled()))?,
            // a mark that does not need colour
            false => area.draw(&TriangleMarker::new(*place, radius + 5, VERMILLION.filled()))?,
        }
    }
    // as many names as there is room for
    let longest = chart.lots.iter().map(|(name, ..)| name.chars().count()).max().unwrap_or(1).max(3) as f64;
    let every = number::count(((longest + 1.5) * 15.0 / step).ceil().max(1.0));
    for (k, (name, ..)) in chart.lots.iter().enumerate().step_by(every) {
        let place = (x(k as f64), bottom + 10);
        area.draw(&Text::new(name.clone(), place, style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
    }
    let title = scale::title(&chart.label, &chart.unit, exponent);
    area.draw(&Text::new(title, (left + 6, top - 16), style(SMALL, &INK, HPos::Left, VPos::Top)))?;
    Ok(())
}

/// Values farther than so many interquartile ranges from the quartiles are counted in the last bars.
const FAR: f64 = 3.0;

pub(super) fn distribution(area: &Area<'_>, chart: &Distribution, lang: Language) -> Drawn {
    let mut sorted: Vec<f64> = chart.values.iter().copied().filter(|x| x.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| sorted.get(number::count((share * (sorted.len().max(1) - 1) as f64).round())).copied();
    let (Some(least), Some(most), Some(q1), Some(q3)) = (at(0.0), at(1.0), at(0.25), at(0.75)) else { return Ok(()) };
    let reach = FAR * (q3 - q1).max(1e-12 * (least.abs() + most.abs()));
    let (mut low, mut high) = (least.max(q1 - reach), most.min(q3 + reach));
    // limits that are near are seen, far ones are told in the text
    for limit in chart.limits.iter().flatten().filter(|x| x.is_finite()) {
        if *limit > low - reach && *limit < high + reach {
            (low, high) = (low.min(*limit), high.max(*limit));
        }
    }
    let (low, high) = scale::range([low, high].into_iter(), 0.04);
    let bins = number::count((sorted.len() as f64).sqrt().ceil()).clamp(6, 60);
    let mut counts = vec![0_usize; bins];
    for x in &sorted {
        let k = number::count(((x - low) / (high - low) * bins as f64).floor().clamp(0.0, bins as f64 - 1.0));
        counts.iter_mut().skip(k).take(1).for_each(|n| *n += 1);
    }
    let width = (high - low) / bins as f64;
    let curve = |x: f64| {
        let [mean, sd] = chart.alone?;
        let z = (x - mean) / sd;
        Some(sorted.len() as f64 * width / sd / std::f64::consts::TAU.sqrt() * (-0.5 * z * z).exp())
            .filter(|y| y.is_finite())
    };
    let highest = counts.iter().copied().max().unwrap_or(1).max(1) as f64;
    let exponent = scale::readable_exponent([low, high].into_iter());
    let frame = Frame { left: 90, right: HALF as i32 - 20, top: 20, bottom: 320 };
    let Frame { left, top, bottom, .. } = frame;
    let x = frame.x((low, high));
    let y = |n: f64| bottom - number::whole((n / (1.05 * highest) * f64::from(bottom - top)).round());
    let (ticks, decimals) = scale::ticks(0.0, highest, 4);
    // devices are whole
    if decimals == 0 {
        frame.level(area, (ticks, decimals), y)?;
    }
    for (k, n) in counts.iter().enumerate().filter(|(_, n)| **n > 0) {
        let (from, to) = (x(low + width * k as f64) + 1, x(low + width * (k + 1) as f64) - 1);
        area.draw(&Rectangle::new([(from, y(*n as f64)), (to.max(from + 1), bottom)], SKY.filled()))?;
    }
    let points: Vec<(i32, i32)> = (0..=200)
        .filter_map(|k| {
            let v = low + (high - low) * f64::from(k) / 200.0;
            // a curve that is much narrower than the histogram is cut at its top
            curve(v).map(|n| (x(v), y(n.min(1.05 * highest))))
        })
        .collect();
    if !points.is_empty() {
        area.draw(&PathElement::new(points, BLUE.stroke_width(3)))?;
    }
    let [first, last] = [low, high].map(|end| scale::scaled(end, exponent));
    frame.axis(area, scale::ticks(first, last, 4), frame.x((first, last)))?;
    for limit in chart.limits.iter().flatten().filter(|v| v.is_finite() && **v >= low && **v <= high) {
        let line = vec![(x(*limit), top), (x(*limit), bottom)];
        area.draw(&DashedPathElement::new(line, 12, 8, VERMILLION.stroke_width(3)))?;
    }
    let small = style(SMALL, &SOFT, HPos::Left, VPos::Top);
    area.draw(&Text::new(say!(lang, "devices"), (left + 6, top), small))?;
    frame.below(area, scale::title(&chart.label, &chart.unit, exponent), 46, &INK)
}
