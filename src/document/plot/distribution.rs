//! How a quantity is distributed over many devices: a histogram with the limits, and what the readings alone would make of it.

use super::{Area, BLUE, Drawn, HALF, INK, SKY, SMALL, SOFT, VERMILLION, rules, scale, style, svg};
use crate::document::chart::Distribution;
use crate::error::Result;
use crate::language::{Language, say};
use crate::number;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

const LEFT: i32 = 90;
const TOP: i32 = 20;
const BOTTOM: i32 = 320;
/// Values farther than so many interquartile ranges from the quartiles are counted in the last bars.
const FAR: f64 = 3.0;

/// A histogram.
pub(super) fn distribution(distribution: &Distribution, lang: Language) -> Result<String> {
    svg(HALF, (BOTTOM + 80) as u32, |area| draw(area, distribution, lang))
}

fn draw(area: &Area<'_>, own: &Distribution, lang: Language) -> Drawn {
    let mut sorted: Vec<f64> = own.values.iter().copied().filter(|x| x.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| sorted.get(number::count((share * (sorted.len().max(1) - 1) as f64).round())).copied();
    let (Some(least), Some(most), Some(q1), Some(q3)) = (at(0.0), at(1.0), at(0.25), at(0.75)) else { return Ok(()) };
    let reach = FAR * (q3 - q1).max(1e-12 * (least.abs() + most.abs()));
    let (mut low, mut high) = (least.max(q1 - reach), most.min(q3 + reach));
    // limits that are near are seen, far ones are told in the text
    for limit in own.limits.iter().flatten().filter(|x| x.is_finite()) {
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
        let [mean, sd] = own.alone?;
        let z = (x - mean) / sd;
        Some(sorted.len() as f64 * width / sd / std::f64::consts::TAU.sqrt() * (-0.5 * z * z).exp())
            .filter(|y| y.is_finite())
    };
    let highest = counts.iter().copied().max().unwrap_or(1).max(1) as f64;
    let exponent = scale::readable_exponent([low, high].into_iter());
    let (left, right) = (LEFT, HALF as i32 - 20);
    let x = |v: f64| left + number::whole(((v - low) / (high - low) * f64::from(right - left)).round());
    let y = |n: f64| BOTTOM - number::whole((n / (1.05 * highest) * f64::from(BOTTOM - TOP)).round());
    let (ticks, decimals) = scale::ticks(0.0, highest, 4);
    // devices are whole
    if decimals == 0 {
        rules::level(area, (ticks, decimals), (left, right), y)?;
    }
    for (k, n) in counts.iter().enumerate().filter(|(_, n)| **n > 0) {
        let (from, to) = (x(low + width * k as f64) + 1, x(low + width * (k + 1) as f64) - 1);
        area.draw(&Rectangle::new([(from, y(*n as f64)), (to.max(from + 1), BOTTOM)], SKY.filled()))?;
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
    let place = |tick: f64| left + number::whole(((tick - first) / (last - first) * f64::from(right - left)).round());
    rules::axis(area, scale::ticks(first, last, 4), (left, right, BOTTOM), place)?;
    for limit in own.limits.iter().flatten().filter(|v| v.is_finite() && **v >= low && **v <= high) {
        let line = vec![(x(*limit), TOP), (x(*limit), BOTTOM)];
        area.draw(&plotters::element::DashedPathElement::new(line, 12, 8, VERMILLION.stroke_width(3)))?;
    }
    area.draw(&Text::new(
        say!(lang, "devices").to_string(),
        (left + 6, TOP),
        style(SMALL, &SOFT, HPos::Left, VPos::Top),
    ))?;
    let place = ((left + right) / 2, BOTTOM + 46);
    let title = scale::title(&own.label, &own.unit, exponent);
    area.draw(&Text::new(title, place, style(SMALL, &INK, HPos::Center, VPos::Top)))?;
    Ok(())
}
