//! The correlation map.

use super::{Area, BLUE, Drawn, HALF, INK, RULE, SMALL, SOFT, TINT, VERMILLION, WIDE, fitted, style, svg, text_width};
use crate::error::Result;
use crate::number;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

/// Correlations as a map of cells: blue for positive, orange for negative, in hundredths where there is room.
///
/// A cell without a number is crossed out. Above 14 names the map is as wide as the page.
pub(super) fn correlation(names: &[String], matrix: &[Vec<Option<f64>>]) -> Result<String> {
    let wide = names.len() > 14;
    let left = names.iter().map(|n| text_width(n, SMALL)).max().unwrap_or(0).clamp(60, 220) + 20;
    let width = if wide { WIDE } else { HALF } as i32;
    let cells = number::signed(names.len().max(1));
    let cell = ((width - left - 24) / cells, ((width - left - 24) / cells).min(64).max(if wide { 34 } else { 0 }));
    let height = cell.1 * cells + left + 24;
    svg(width.unsigned_abs(), height.max(1).unsigned_abs(), |area| draw(area, names, matrix, left, cell))
}

fn draw(area: &Area<'_>, names: &[String], matrix: &[Vec<Option<f64>>], left: i32, cell: (i32, i32)) -> Drawn {
    let n = number::signed(names.len());
    for (i, name) in names.iter().enumerate() {
        let name = fitted(name, SMALL, left - 16);
        let i = number::signed(i);
        let row = (left - 12, cell.1 * i + cell.1 / 2);
        area.draw(&Text::new(name.clone(), row, style(SMALL, &INK, HPos::Right, VPos::Center)))?;
        let turned = style(SMALL, &INK, HPos::Right, VPos::Center).transform(FontTransform::Rotate270);
        area.draw(&Text::new(name, (left + cell.0 * i + cell.0 / 2, cell.1 * n + 12), turned))?;
    }
    for (i, row) in matrix.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            let (x, y) = (left + cell.0 * number::signed(j), cell.1 * number::signed(i));
            let corners = [(x, y), (x + cell.0, y + cell.1)];
            let middle = (x + cell.0 / 2, y + cell.1 / 2);
            match value.filter(|v| v.is_finite()).map(|v| v.clamp(-1.0, 1.0)) {
                Some(r) => {
                    let colour = if r < 0.0 { VERMILLION } else { BLUE };
                    // the diagonal is always one: grey, so that the eye goes elsewhere
                    let fill = if i == j { RULE.filled() } else { colour.mix(0.9 * r.abs()).filled() };
                    area.draw(&Rectangle::new(corners, fill))?;
                    let digits = (100.0 * r).round();
                    if i != j && cell.0 >= 44 {
                        let ink = if r.abs() > 0.6 {
                            WHITE
                        } else if digits == 0.0 {
                            SOFT
                        } else {
                            INK
                        };
                        let text = super::scale::label(digits, 0);
                        area.draw(&Text::new(text, middle, style(SMALL - 4, &ink, HPos::Center, VPos::Center)))?;
                    }
                }
                None => {
                    area.draw(&Rectangle::new(corners, TINT.filled()))?;
                    area.draw(&Text::new("\u{d7}", middle, style(SMALL, &SOFT, HPos::Center, VPos::Center)))?;
                }
            }
            area.draw(&Rectangle::new(corners, RULE.stroke_width(1)))?;
        }
    }
    Ok(())
}
