//! A row for each name: values with error bars, and stacked bars that say where an uncertainty comes from.

use super::axes::Frame;
use super::{
    Area, BLUE, Drawn, GREEN, HALF, INK, ORANGE, PURPLE, SKY, SMALL, SOFT, TEXT, TINT, VERMILLION, YELLOW, fitted,
    scale, style, svg, text_width,
};
use crate::document::chart::{Bar, Interval};
use crate::error::Result;
use crate::language::{Language, say};
use crate::number;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

const ROW: i32 = 48;

impl Interval {
    fn ends(&self) -> [f64; 2] {
        self.at_bound.unwrap_or([self.value - self.expanded, self.value + self.expanded])
    }
}

/// The frame of a picture of so wide and so high rows, beside their names.
fn beside<'a>(names: impl Iterator<Item = &'a String>, (width, height): (i32, i32)) -> Frame {
    let left = names.map(|name| text_width(name, TEXT)).max().unwrap_or(0).clamp(80, 300) + 24;
    Frame { left, right: width - 24, top: 0, bottom: height - 84 }
}

/// The name of a row whose middle is at this height.
fn name(area: &Area<'_>, frame: Frame, label: &str, y: i32) -> Drawn {
    let label = fitted(label, TEXT, frame.left - 20);
    Ok(area.draw(&Text::new(label, (frame.left - 16, y), style(TEXT, &INK, HPos::Right, VPos::Center)))?)
}

/// Values with error bars on a common axis that holds zero.
pub(super) fn values(rows: &[Interval], unit: &str, lang: Language) -> Result<String> {
    let height = ROW * number::signed(rows.len()) + 96;
    let exponent = scale::readable_exponent(rows.iter().flat_map(|r| [r.value, r.expanded]));
    let at = |v: f64| scale::scaled(v, exponent);
    let ends = rows.iter().flat_map(|r| r.ends().map(at).into_iter().chain([at(r.value)]));
    let (low, high) = scale::range(ends.chain([0.0]), 0.04);
    let frame = beside(rows.iter().map(|row| &row.label), (HALF as i32, height));
    let Frame { left, right, bottom, .. } = frame;
    let x = frame.x((low, high));
    svg(HALF, height.unsigned_abs(), |area| {
        for (k, _) in rows.iter().enumerate().filter(|(k, _)| k % 2 == 0) {
            let top = ROW * number::signed(k);
            area.draw(&Rectangle::new([(left, top), (right, top + ROW)], TINT.filled()))?;
        }
        frame.upright(area, scale::ticks(low, high, 5), x)?;
        area.draw(&PathElement::new([(x(0.0), 0), (x(0.0), bottom)], SOFT.stroke_width(2)))?;
        area.draw(&PathElement::new([(left, bottom), (right, bottom)], SOFT.stroke_width(2)))?;
        let title = scale::title(say!(lang, "estimate-and-expanded-uncertainty"), unit, exponent);
        frame.below(area, title, 46, &SOFT)?;
        for (k, row) in rows.iter().enumerate() {
            let y = ROW * number::signed(k) + ROW / 2;
            name(area, frame, &row.label, y)?;
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
    })
}

const TYPE_A: [RGBColor; 3] = [BLUE, SKY, GREEN];
const TYPE_B: [RGBColor; 4] = [VERMILLION, ORANGE, YELLOW, PURPLE];

/// A source, its colour, and whether it is of Type B.
type Source<'a> = (&'a str, bool, RGBAColor);

/// Stacked bars on a common axis from zero, with a legend of sources; `what` and `unit` title the axis.
pub(super) fn bars(rows: &[Bar], (what, unit): (&str, &str), width: u32, lang: Language) -> Result<String> {
    let sources = sources(rows);
    let places = legend_places(&sources, width as i32, lang);
    let (height, legend) = (ROW * number::signed(rows.len()) + 96, places.last().map_or(0, |(_, row)| row + 1));
    let total = |row: &Bar| row.parts.iter().map(|p| p.size.max(0.0)).filter(|s| s.is_finite()).sum::<f64>();
    let exponent = scale::readable_exponent(rows.iter().map(total));
    let at = |v: f64| scale::scaled(v.max(0.0), exponent);
    let high = rows.iter().map(|r| at(total(r))).fold(0.0, f64::max);
    let high = if high > 0.0 { 1.03 * high } else { 1.0 };
    let frame = beside(rows.iter().map(|row| &row.label), (width as i32, height));
    let Frame { left, right, bottom, .. } = frame;
    let x = frame.x((0.0, high));
    svg(width, (height + 36 * legend).unsigned_abs(), |area| {
        frame.upright(area, scale::ticks(0.0, high, if width > 1000 { 10 } else { 5 }), x)?;
        area.draw(&PathElement::new([(left, bottom), (right, bottom)], SOFT.stroke_width(2)))?;
        frame.below(area, scale::title(what, unit, exponent), 46, &SOFT)?;
        for (k, row) in rows.iter().enumerate() {
            let y = ROW * number::signed(k);
            name(area, frame, &row.label, y + ROW / 2)?;
            let mut from = 0.0;
            for part in &row.parts {
                let to = from + at(part.size);
                let source = sources.iter().find(|(name, ..)| *name == part.source);
                let colour = source.map_or(SOFT.to_rgba(), |(.., colour)| *colour);
                if x(to) > x(from) {
                    area.draw(&Rectangle::new([(x(from), y + 9), (x(to), y + ROW - 9)], colour.filled()))?;
                    area.draw(&PathElement::new([(x(to), y + 9), (x(to), y + ROW - 9)], WHITE.stroke_width(2)))?;
                }
                from = to;
            }
        }
        area.draw(&PathElement::new([(left, 0), (left, bottom)], SOFT.stroke_width(2)))?;
        for (source, (column, row)) in sources.iter().zip(places) {
            let y = height + 36 * row + 14;
            area.draw(&Rectangle::new([(column + 12, y - 10), (column + 34, y + 10)], source.2.filled()))?;
            area.draw(&Text::new(entry(source, lang), (column + 44, y), style(SMALL, &INK, HPos::Left, VPos::Center)))?;
        }
        Ok(())
    })
}

/// Distinct sources in order of first appearance; those beyond a palette have its colours again, each time half as strong.
fn sources(rows: &[Bar]) -> Vec<Source<'_>> {
    let mut sources: Vec<Source<'_>> = Vec::new();
    for part in rows.iter().flat_map(|row| &row.parts) {
        if !sources.iter().any(|(name, ..)| *name == part.source) {
            let before = sources.iter().filter(|(_, type_b, _)| *type_b == part.type_b).count();
            let palette: &[RGBColor] = if part.type_b { &TYPE_B } else { &TYPE_A };
            let strength = 0.5_f64.powi(number::signed(before / palette.len()));
            let colour = palette.get(before % palette.len()).copied().unwrap_or(SOFT);
            sources.push((&part.source, part.type_b, colour.mix(strength)));
        }
    }
    sources
}

fn entry((name, type_b, _): &Source<'_>, lang: Language) -> String {
    fitted(&say!(lang, "bars-type", name, type_b = if *type_b { "B" } else { "A" }), SMALL, 420)
}

/// Where each entry of the legend stands: column offset and row.
fn legend_places(sources: &[Source<'_>], width: i32, lang: Language) -> Vec<(i32, i32)> {
    let (mut x, mut row) = (0, 0);
    let mut places = Vec::new();
    for source in sources {
        let room = text_width(&entry(source, lang), SMALL) + 64;
        if x > 0 && x + room > width - 24 {
            x = 0;
            row += 1;
        }
        places.push((x, row));
        x += room;
    }
    places
}
