//! A whole record: one panel for each channel, segments shaded.

use super::{Area, BLUE, Drawn, INK, RULE, SMALL, SOFT, TINT, WIDE, scale, style, svg};
use crate::error::Result;
use crate::language::{Language, say};
use crate::number;
use crate::reduce::{Segment, Trace};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

const LEFT: i32 = 190;
const PANEL: i32 = 190;
const BOTTOM: i32 = 80;

/// All channels of a trace against time, segments shaded.
pub fn record(trace: &Trace, segments: &[Segment], lang: Language) -> Result<String> {
    let height = PANEL * number::signed(trace.channels.len().max(1)) + BOTTOM;
    svg(WIDE, height.unsigned_abs(), |area| draw(area, trace, segments, lang))
}

fn draw(area: &Area<'_>, trace: &Trace, segments: &[Segment], lang: Language) -> Drawn {
    let (left, right) = (LEFT, WIDE as i32 - 20);
    let end = trace.time(trace.samples.saturating_sub(1)).max(trace.interval);
    let x = |t: f64| left + number::whole((t / end * f64::from(right - left)).round());
    let bottom = PANEL * number::signed(trace.channels.len());
    for (k, piece) in segments.iter().flat_map(|s| s.pieces.iter().map(|p| p.start..p.end)).enumerate() {
        let (from, to) = (x(trace.time(piece.start)), x(trace.time(piece.end)).max(x(trace.time(piece.start)) + 1));
        area.draw(&Rectangle::new([(from, 4), (to, bottom - 6)], TINT.filled()))?;
        area.draw(&PathElement::new([(from, 4), (from, bottom - 6)], RULE.stroke_width(1)))?;
        area.draw(&PathElement::new([(to, 4), (to, bottom - 6)], RULE.stroke_width(1)))?;
        let _ = k;
    }
    let pixels = number::unsigned(right - left) / 2;
    for (k, channel) in trace.channels.iter().enumerate() {
        let top = PANEL * number::signed(k) + 8;
        let low_y = top + PANEL - 24;
        let (low, high) = scale::range(channel.means.iter().copied(), 0.05);
        let y = |v: f64| low_y - number::whole(((v - low) / (high - low) * f64::from(low_y - top)).round());
        let (ticks, decimals) = scale::ticks(low, high, 3);
        for tick in ticks {
            let label = scale::label(tick, decimals);
            area.draw(&Text::new(label, (left - 10, y(tick)), style(SMALL, &SOFT, HPos::Right, VPos::Center)))?;
        }
        // for each step of the picture the smallest and largest value
        let blocks = channel.means.len();
        let step = (blocks / pixels.max(1)).max(1);
        let mut path: Vec<(i32, i32)> = Vec::new();
        for (j, chunk) in channel.means.chunks(step).enumerate() {
            let at = x(trace.time((j * step * trace.block) as u64));
            let (mut a, mut b) = (f64::INFINITY, f64::NEG_INFINITY);
            chunk.iter().for_each(|v| (a, b) = (a.min(*v), b.max(*v)));
            path.push((at, y(a)));
            if chunk.len() > 1 {
                path.push((at, y(b)));
            }
        }
        area.draw(&PathElement::new(path, BLUE.stroke_width(2)))?;
        area.draw(&PathElement::new([(left, low_y + 8), (right, low_y + 8)], RULE.stroke_width(1)))?;
        let unit = if channel.unit.is_empty() { String::new() } else { format!(", {}", channel.unit) };
        let name: String = format!("{}{unit}", channel.name).chars().filter(|c| !c.is_control()).collect();
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
