//! The frame that the data of a chart fill, and the rules across it at the ticks of its axes, each with its number.

use super::{Area, Drawn, RULE, SMALL, SOFT, scale, style};
use crate::number;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

/// The rectangle that the data of a chart fill.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub left: i32,
    pub right: i32,
    pub top: i32,
    pub bottom: i32,
}

impl Frame {
    /// Where a value of the level axis is, whose ends are these.
    pub(super) fn x(self, (low, high): (f64, f64)) -> impl Fn(f64) -> i32 + Copy {
        let room = f64::from(self.right - self.left);
        move |v| self.left + number::whole(((v - low) / (high - low) * room).round())
    }

    /// Where a value of the upright axis is, whose ends are these.
    pub(super) fn y(self, (low, high): (f64, f64)) -> impl Fn(f64) -> i32 + Copy {
        let room = f64::from(self.bottom - self.top);
        move |v| self.top + number::whole(((high - v) / (high - low) * room).round())
    }

    /// Level rules at these heights, and their numbers so far before them.
    pub(super) fn across(self, area: &Area<'_>, marks: impl Iterator<Item = (i32, String)>, by: i32) -> Drawn {
        for (y, number) in marks {
            area.draw(&PathElement::new([(self.left, y), (self.right, y)], RULE.stroke_width(1)))?;
            area.draw(&Text::new(number, (self.left - by, y), style(SMALL, &SOFT, HPos::Right, VPos::Center)))?;
        }
        Ok(())
    }

    /// Upright rules at these places, their numbers below them.
    pub(super) fn along(self, area: &Area<'_>, marks: impl Iterator<Item = (i32, String)>) -> Drawn {
        for (x, number) in marks {
            area.draw(&PathElement::new([(x, self.top), (x, self.bottom)], RULE.stroke_width(1)))?;
            area.draw(&Text::new(number, (x, self.bottom + 10), style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
        }
        Ok(())
    }

    /// Level rules at ticks, which come with their decimals, and the numbers before them.
    pub(super) fn level(self, area: &Area<'_>, (ticks, decimals): (Vec<f64>, usize), y: impl Fn(f64) -> i32) -> Drawn {
        self.across(area, ticks.into_iter().map(|tick| (y(tick), scale::label(tick, decimals))), 12)
    }

    /// Upright rules at ticks, their numbers below them.
    pub(super) fn upright(
        self,
        area: &Area<'_>,
        (ticks, decimals): (Vec<f64>, usize),
        x: impl Fn(f64) -> i32,
    ) -> Drawn {
        self.along(area, ticks.into_iter().map(|tick| (x(tick), scale::label(tick, decimals))))
    }

    /// The axis at the bottom, with a mark and a number at each tick.
    pub(super) fn axis(self, area: &Area<'_>, (ticks, decimals): (Vec<f64>, usize), x: impl Fn(f64) -> i32) -> Drawn {
        let Frame { left, right, bottom, .. } = self;
        for tick in ticks {
            area.draw(&PathElement::new([(x(tick), bottom), (x(tick), bottom + 6)], SOFT.stroke_width(1)))?;
            let place = (x(tick), bottom + 12);
            area.draw(&Text::new(scale::label(tick, decimals), place, style(SMALL, &SOFT, HPos::Center, VPos::Top)))?;
        }
        area.draw(&PathElement::new([(left, bottom), (right, bottom)], SOFT.stroke_width(1)))?;
        Ok(())
    }

    /// The title of the level axis, so far below the frame.
    pub(super) fn below(self, area: &Area<'_>, title: impl Into<String>, by: i32, colour: &RGBColor) -> Drawn {
        let place = ((self.left + self.right) / 2, self.bottom + by);
        area.draw(&Text::new(title.into(), place, style(SMALL, colour, HPos::Center, VPos::Top)))?;
        Ok(())
    }

    /// The title of the upright axis, turned, at the left end.
    pub(super) fn at_side(self, area: &Area<'_>, title: impl Into<String>, colour: &RGBColor) -> Drawn {
        let turned = style(SMALL, colour, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
        area.draw(&Text::new(title.into(), (8, (self.top + self.bottom) / 2), turned))?;
        Ok(())
    }
}
