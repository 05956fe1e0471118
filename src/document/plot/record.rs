//! A whole record: one panel for each channel, segments shaded.

use super::{Area, BLUE, Drawn, INK, RULE, SMALL, SOFT, TINT, WIDE, scale, style, svg};
use crate::document::chart::RecordChart;
use crate::error::Result;
use crate::language::{Language, say};
use crate::number;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

const LEFT: i32 = 190;
const PANEL: i32 = 190;
const BOTTOM: i32 = 80;

/// All channels of a record against time, segments shaded.
pub(super) fn record(own: &RecordChart, lang: Language) -> Result<String> {
    let height = PANEL * number::signed(own.channels.len().max(1)) + BOTTOM;
    svg(WIDE, height.unsigned_abs(), |area| draw(area, own, lang))
}

fn draw(area: &Area<'_>, own: &RecordChart, lang: Language) -> Drawn {
    let (left, right) = (LEFT, WIDE as i32 - 20);
    let end = own.end;
    let x = |t: f64| left + number::whole((t / end * f64::from(right - left)).round());
    let bottom = PANEL * number::signed(own.channels.len());
    for (from, to) in &own.segments {
        let (from, to) = (x(*from), x(*to).max(x(*from) + 1));
        area.draw(&Rectangle::new([(from, 4), (to, bottom - 6)], TINT.filled()))?;
        area.draw(&PathElement::new([(from, 4), (from, bottom - 6)], RULE.stroke_width(1)))?;
        area.draw(&PathElement::new([(to, 4), (to, bottom - 6)], RULE.stroke_width(1)))?;
    }
    for (k, (title, course)) in own.channels.iter().enumerate() {
        let top = PANEL * number::signed(k) + 8;
        let low_y = top + PANEL - 24;
        let (low, high) = scale::range(course.iter().map(|(_, v)| *v), 0.05);
        let y = |v: f64| low_y - number::whole(((v - low) / (high - low) * f64::from(low_y - top)).round());
        let (ticks, decimals) = scale::ticks(low, high, 3);
        for tick in ticks {
            let label = scale::label(tick, decimals);
            area.draw(&Text::new(label, (left - 10, y(tick)), style(SMALL, &SOFT, HPos::Right, VPos::Center)))?;
        }
        let path: Vec<(i32, i32)> = course.iter().map(|(t, v)| (x(*t), y(*v))).collect();
        area.draw(&PathElement::new(path, BLUE.stroke_width(2)))?;
        area.draw(&PathElement::new([(left, low_y + 8), (right, low_y + 8)], RULE.stroke_width(1)))?;
        let name: String = title.chars().filter(|c| !c.is_control()).collect();
        area.draw(&Text::new(name, (8, top), style(SMALL, &INK, HPos::Left, VPos::Top)))?;
    }
    let (ticks, decimals) = scale::ticks(0.0, end, 8);
    for tick in ticks {
        let place = (x(tick), bottom + 4);
        area.draw(&Text::new(scale::label(tick, decimals), place, style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
    }
    let place = ((left + right) / 2, bottom + 38);
    area.draw(&Text::new(
        say!(lang, "time-since-the-first-sample-s"),
        place,
        style(SMALL, &INK, HPos::Center, VPos::Top),
    ))?;
    Ok(())
}
