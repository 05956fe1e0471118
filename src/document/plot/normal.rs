//! The normal plot of studentized residuals.

use super::{Area, BLUE, Drawn, HALF, SKY, SMALL, SOFT, rules, scale, style, svg};
use crate::error::Result;
use crate::language::{Language, say};
use crate::number;
use crate::uncertainty::quantiles::normal_quantile;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

const LEFT: i32 = 120;
const PLOT: i32 = 560;
/// More points than this are thinned evenly; their order keeps the shape.
const MOST: usize = 1000;

/// Sorted residuals over the normal quantiles at Blom's positions `(i - 3/8)/(n + 1/4)`, the line of the standard normal and its pointwise
/// 95 % band, `z +- 1.96 sqrt(p (1 - p)/n)/phi(z)`.
pub(super) fn normal(studentized: &[f64], lang: Language) -> Result<String> {
    let mut sorted: Vec<f64> = studentized.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let every = sorted.len().div_ceil(MOST).max(1);
    let points: Vec<Point> = sorted
        .iter()
        .enumerate()
        .filter(|(k, _)| k % every == 0 || k + 1 == sorted.len())
        .filter_map(|(k, value)| {
            let p = (k as f64 + 0.625) / (n + 0.25);
            let z = normal_quantile(p)?;
            let density = (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
            Some(Point { z, value: value.clamp(-1e6, 1e6), band: 1.96 * (p * (1.0 - p) / n).sqrt() / density })
        })
        .collect();
    svg(HALF, (PLOT + 84) as u32, |area| draw(area, &points, lang))
}

struct Point {
    z: f64,
    value: f64,
    band: f64,
}

fn draw(area: &Area<'_>, points: &[Point], lang: Language) -> Drawn {
    let right = HALF as i32 - 24;
    let (left_z, right_z) = scale::range(points.iter().map(|p| p.z).chain([-1.0, 1.0]), 0.06);
    let ends = points.iter().flat_map(|p| [p.value, p.z - p.band, p.z + p.band]);
    let (low, high) = scale::range(ends.chain([-1.0, 1.0]), 0.06);
    let x = |z: f64| LEFT + number::whole(((z - left_z) / (right_z - left_z) * f64::from(right - LEFT)).round());
    let y = |v: f64| number::whole(((high - v) / (high - low) * f64::from(PLOT)).round());
    rules::upright(area, scale::ticks(left_z, right_z, 7), PLOT, x)?;
    rules::level(area, scale::ticks(low, high, 7), (LEFT, right), y)?;
    let upper = points.iter().map(|p| (x(p.z), y(p.z + p.band)));
    let lower = points.iter().rev().map(|p| (x(p.z), y(p.z - p.band)));
    let outline: Vec<(i32, i32)> = upper.chain(lower).collect();
    if outline.len() > 3 {
        area.draw(&Polygon::new(outline, SKY.mix(0.22).filled()))?;
    }
    let (from, to) = (left_z.max(low), right_z.min(high));
    area.draw(&PathElement::new([(x(from), y(from)), (x(to), y(to))], SOFT.stroke_width(2)))?;
    area.draw(&Rectangle::new([(LEFT, 0), (right, PLOT)], SOFT.stroke_width(2)))?;
    for point in points {
        area.draw(&Circle::new((x(point.z), y(point.value)), 6, BLUE.filled()))?;
    }
    let small = style(SMALL, &SOFT, HPos::Center, VPos::Top);
    area.draw(&Text::new(say!(lang, "normal-quantile"), ((LEFT + right) / 2, PLOT + 46), small.clone()))?;
    let turned = small.transform(FontTransform::Rotate270);
    area.draw(&Text::new(say!(lang, "studentized-residual"), (8, PLOT / 2), turned))?;
    Ok(())
}
