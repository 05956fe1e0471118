//! Values with error bars, one row each.

use super::{
    Area, BLUE, Drawn, HALF, INK, SMALL, SOFT, TEXT, TINT, VERMILLION, fitted, rules, scale, style, svg, text_width,
};
use crate::document::chart::Interval;
use crate::error::Result;
use crate::language::{Language, say};
use crate::number;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

impl Interval {
    fn ends(&self) -> [f64; 2] {
        self.at_bound.unwrap_or([self.value - self.expanded, self.value + self.expanded])
    }
}

const ROW: i32 = 48;

/// Values with error bars on a common axis that holds zero.
pub(super) fn values(rows: &[Interval], unit: &str, lang: Language) -> Result<String> {
    let height = ROW * number::signed(rows.len()) + 96;
    svg(HALF, height.unsigned_abs(), |area| draw(area, rows, unit, height, lang))
}

fn draw(area: &Area<'_>, rows: &[Interval], unit: &str, height: i32, lang: Language) -> Drawn {
    let exponent = scale::readable_exponent(rows.iter().flat_map(|r| [r.value, r.expanded]));
    let at = |v: f64| scale::scaled(v, exponent);
    let ends = rows.iter().flat_map(|r| r.ends().map(at).into_iter().chain([at(r.value)]));
    let (low, high) = scale::range(ends.chain([0.0]), 0.04);
    let left = rows.iter().map(|r| text_width(&r.label, TEXT)).max().unwrap_or(0).clamp(80, 300) + 24;
    let (right, bottom) = (HALF as i32 - 24, height - 84);
    let x = |v: f64| left + number::whole(((v - low) / (high - low) * f64::from(right - left)).round());
    for (k, _) in rows.iter().enumerate().filter(|(k, _)| k % 2 == 0) {
        let top = ROW * number::signed(k);
        area.draw(&Rectangle::new([(left, top), (right, top + ROW)], TINT.filled()))?;
    }
    rules::upright(area, scale::ticks(low, high, 5), bottom, x)?;
    area.draw(&PathElement::new([(x(0.0), 0), (x(0.0), bottom)], SOFT.stroke_width(2)))?;
    area.draw(&PathElement::new([(left, bottom), (right, bottom)], SOFT.stroke_width(2)))?;
    let title = scale::title(say!(lang, "estimate-and-expanded-uncertainty"), unit, exponent);
    area.draw(&Text::new(title, ((left + right) / 2, bottom + 46), style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
    for (k, row) in rows.iter().enumerate() {
        let y = ROW * number::signed(k) + ROW / 2;
        let label = fitted(&row.label, TEXT, left - 20);
        area.draw(&Text::new(label, (left - 16, y), style(TEXT, &INK, HPos::Right, VPos::Center)))?;
        let [from, to] = row.ends().map(|end| x(at(end)));
        area.draw(&PathElement::new([(from, y), (to, y)], BLUE.stroke_width(4)))?;
        for end in [from, to] {
            area.draw(&PathElement::new([(end, y - 14), (end, y + 14)], BLUE.stroke_width(3)))?;
        }
        if row.at_bound.is_some() {
            let bound = x(at(row.value));
            area.draw(&PathElement::new([(bound, y - 22), (bound, y + 22)], VERMILLION.stroke_width(5)))?;
        }
        area.draw(&Circle::new((x(at(row.value)), y), 6, BLUE.filled()))?;
    }
    Ok(())
}
