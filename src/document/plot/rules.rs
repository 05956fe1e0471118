//! Rules across a chart at the ticks of its axes, each with its number.

use super::{Area, Drawn, RULE, SMALL, SOFT, scale, style};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Level rules from `left` to `right`, their numbers before them; `ticks` with their decimals, as `scale::ticks` gives them.
pub(super) fn level(
    area: &Area<'_>,
    (ticks, decimals): (Vec<f64>, usize),
    (left, right): (i32, i32),
    y: impl Fn(f64) -> i32,
) -> Drawn {
    for tick in ticks {
        area.draw(&PathElement::new([(left, y(tick)), (right, y(tick))], RULE.stroke_width(1)))?;
        let place = (left - 12, y(tick));
        area.draw(&Text::new(scale::label(tick, decimals), place, style(SMALL, &SOFT, HPos::Right, VPos::Center)))?;
    }
    Ok(())
}

/// Upright rules from the top to `bottom`, their numbers below them.
pub(super) fn upright(
    area: &Area<'_>,
    (ticks, decimals): (Vec<f64>, usize),
    bottom: i32,
    x: impl Fn(f64) -> i32,
) -> Drawn {
    for tick in ticks {
        area.draw(&PathElement::new([(x(tick), 0), (x(tick), bottom)], RULE.stroke_width(1)))?;
        let place = (x(tick), bottom + 10);
        area.draw(&Text::new(scale::label(tick, decimals), place, style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
    }
    Ok(())
}

/// The axis at the bottom of a chart, from `left` to `right`, with a mark and a number at each tick.
pub(super) fn axis(
    area: &Area<'_>,
    (ticks, decimals): (Vec<f64>, usize),
    (left, right, bottom): (i32, i32, i32),
    x: impl Fn(f64) -> i32,
) -> Drawn {
    for tick in ticks {
        area.draw(&PathElement::new([(x(tick), bottom), (x(tick), bottom + 6)], SOFT.stroke_width(1)))?;
        let place = (x(tick), bottom + 12);
        area.draw(&Text::new(scale::label(tick, decimals), place, style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
    }
    area.draw(&PathElement::new([(left, bottom), (right, bottom)], SOFT.stroke_width(1)))?;
    Ok(())
}
