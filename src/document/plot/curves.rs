//! Curves against time: a reference dashed, others solid, on one axis.

use super::{
    Area, BLUE, Drawn, GREEN, HALF, ORANGE, PURPLE, SMALL, SOFT, VERMILLION, rules, scale, style, svg, text_width,
};
use crate::document::chart::Curve;
use crate::error::Result;
use crate::number;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

const LEFT: i32 = 120;
const TOP: i32 = 40;
const BOTTOM: i32 = 340;

/// Curves on one axis; `what` and `unit` title it, `along` titles the axis of time.
pub(super) fn curves(curves: &[Curve], what: &str, unit: &str, along: &str) -> Result<String> {
    svg(HALF, (BOTTOM + 80) as u32, |area| draw(area, curves, what, unit, along))
}

fn draw(area: &Area<'_>, curves: &[Curve], what: &str, unit: &str, along: &str) -> Drawn {
    let finite = || curves.iter().flat_map(|c| &c.points).filter(|(x, y)| x.is_finite() && y.is_finite());
    let exponent = scale::readable_exponent(finite().map(|(_, y)| *y));
    let at = |y: f64| scale::scaled(y, exponent);
    let (left, right) = (LEFT, HALF as i32 - 20);
    let (first, last) = scale::range(finite().map(|(x, _)| *x), 0.0);
    let (low, high) = scale::range(finite().map(|(_, y)| at(*y)).chain([0.0]), 0.05);
    let x = |v: f64| left + number::whole(((v - first) / (last - first) * f64::from(right - left)).round());
    let y = |v: f64| TOP + number::whole(((high - v) / (high - low) * f64::from(BOTTOM - TOP)).round());

    rules::level(area, scale::ticks(low, high, 5), (left, right), y)?;
    rules::axis(area, scale::ticks(first, last, 6), (left, right, BOTTOM), x)?;

    let colours = [SOFT, VERMILLION, BLUE, GREEN, ORANGE, PURPLE];
    let mut legend = left + 4;
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
        area.draw(&plotters::element::DashedPathElement::new(path, 12, 8, colour.stroke_width(3)))?;
    }
    let title = style(SMALL, &SOFT, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
    area.draw(&Text::new(scale::title(what, unit, exponent), (8, (TOP + BOTTOM) / 2), title))?;
    let place = ((left + right) / 2, BOTTOM + 46);
    area.draw(&Text::new(along.to_string(), place, style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
    Ok(())
}
