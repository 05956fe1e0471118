//! A bench as a drawing: each joint a ring about its axis, the unit as a box in the middle, gravity and the Earth rate beside it.

use super::{Area, BLUE, Drawn, GREEN, HALF, INK, RULE, SKY, SMALL, SOFT, TEXT, TINT, VERMILLION, style, text_width};
use crate::document::chart::{Ring, Scene};
use crate::language::{Language, say};
use crate::number;
use nalgebra::{Matrix3, Vector3};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

pub(super) const HEIGHT: u32 = 700;
/// Middle of the bench, and pixels for a length of 1.
const CENTRE: (f64, f64, f64) = (520.0, 345.0, 285.0);
/// Half edges of the unit's box.
const BOX: [f64; 3] = [0.26, 0.20, 0.13];
/// The eye: turned about the vertical, and raised, in degrees.
const EYE: [f64; 2] = [-30.0, 24.0];
/// Pixels between the end of a line and its label.
const GAP: i32 = 14;
/// Points of a ring.
const POINTS: i32 = 96;

/// From the room (east, north, up) to the picture, and the depth.
struct Eye(Matrix3<f64>);

impl Eye {
    fn new() -> Self {
        let [(sa, ca), (se, ce)] = EYE.map(|angle: f64| angle.to_radians().sin_cos());
        let right = Vector3::new(ca, sa, 0.0);
        let into = Vector3::new(-sa * ce, ca * ce, -se);
        let up = right.cross(&into);
        Eye(Matrix3::from_rows(&[right.transpose(), up.transpose(), into.transpose()]))
    }

    fn at(&self, point: &Vector3<f64>) -> (i32, i32) {
        let seen = self.0 * point;
        (number::whole((CENTRE.0 + CENTRE.2 * seen.x).round()), number::whole((CENTRE.1 - CENTRE.2 * seen.y).round()))
    }

    fn is_behind(&self, point: &Vector3<f64>) -> bool {
        (self.0 * point).z > 0.0
    }
}

#[cfg(feature = "cli")]
/// A point of the room (east, north, up) as the picture has it: to the right, up, away.
pub(crate) fn seen(point: &Vector3<f64>) -> Vector3<f64> {
    Eye::new().0 * point
}

#[cfg(feature = "cli")]
/// The point of the room that the picture has there.
pub(crate) fn unseen(point: &Vector3<f64>) -> Vector3<f64> {
    Eye::new().0.transpose() * point
}

pub(super) fn scene(area: &Area<'_>, scene: &Scene, lang: Language) -> Drawn {
    let eye = Eye::new();
    for (k, ring) in scene.rings.iter().enumerate() {
        draw_ring(area, &eye, ring, radius(k, scene.rings.len()))?;
    }
    unit(area, &eye, &scene.unit)?;
    let middle = Vector3::zeros();
    for (name, direction) in &scene.inputs {
        named_arrow(area, &eye, [middle, scene.unit * direction * 0.62], name, &VERMILLION, 5)?;
    }
    for (name, k) in [("x", 0), ("y", 1), ("z", 2)] {
        let axis: Vector3<f64> = scene.unit.column(k).into();
        // an input along it stands for it
        if !scene.inputs.iter().any(|(_, along)| (scene.unit * along - axis).norm() < 0.05) {
            arrow(area, &eye, &middle, &(axis * 0.46), &INK, 3)?;
            label(area, &eye, [&middle, &(axis * 0.49)], name, &INK)?;
        }
    }
    // the room, beside the bench: a corner of its own
    let corner = eye.0.transpose() * Vector3::new(-1.42, -0.98, 0.0);
    for (name, direction) in [
        (say!(lang, "east-axis"), Vector3::x()),
        (say!(lang, "north-axis"), Vector3::y()),
        (say!(lang, "up-axis"), Vector3::z()),
    ] {
        named_arrow(area, &eye, [corner, corner + direction * 0.3], name, &SOFT, 3)?;
    }
    let side = eye.0.transpose() * Vector3::new(-1.2, 0.7, 0.0);
    named_arrow(area, &eye, [side, side - Vector3::z() * 0.42], say!(lang, "gravity-arrow"), &GREEN, 5)?;
    if let Some(direction) = scene.earth_rate {
        named_arrow(area, &eye, [side, side + direction * 0.42], say!(lang, "earth-rate-arrow"), &BLUE, 5)?;
    }
    Ok(())
}

/// Radii from the outermost joint to the innermost.
pub(crate) fn radius(k: usize, of: usize) -> f64 {
    let step = if of > 1 { (0.42 / (of - 1) as f64).min(0.16) } else { 0.0 };
    1.0 - step * k as f64
}

/// A ring about the axis of a joint: solid before the unit and faint behind it, a spoke at the joint's angle, an arrow where it turns.
fn draw_ring(area: &Area<'_>, eye: &Eye, ring: &Ring, radius: f64) -> Drawn {
    let (first, second) = (ring.zero, ring.axis.cross(&ring.zero));
    let at = |angle: f64| (first * angle.cos() + second * angle.sin()) * radius;
    let step = std::f64::consts::TAU / f64::from(POINTS);
    for k in 0..POINTS {
        let (from, to) = (at(f64::from(k) * step), at(f64::from(k + 1) * step));
        let behind = eye.is_behind(&((from + to) * 0.5));
        let colour = if behind { RULE } else { SOFT };
        area.draw(&PathElement::new([eye.at(&from), eye.at(&to)], colour.stroke_width(if behind { 3 } else { 5 })))?;
    }
    for sign in [-1.0, 1.0] {
        let ends = [ring.axis * sign * radius, ring.axis * sign * (radius + 0.10)];
        area.draw(&PathElement::new(ends.map(|end| eye.at(&end)), SOFT.stroke_width(5)))?;
    }
    let angle = ring.angle_deg.to_radians();
    match ring.rate_deg_s {
        0.0 => {
            let mark = at(angle);
            area.draw(&PathElement::new([eye.at(&(mark * 0.86)), eye.at(&mark)], BLUE.stroke_width(5)))?;
            area.draw(&Circle::new(eye.at(&mark), 7, BLUE.filled()))?;
        }
        rate => {
            // a third of a turn in its sense, beginning at the angle
            let sweep = rate.signum() * std::f64::consts::TAU / 3.0;
            let path: Vec<(i32, i32)> = (0..=24).map(|k| eye.at(&at(angle + sweep * f64::from(k) / 24.0))).collect();
            area.draw(&PathElement::new(path, VERMILLION.stroke_width(6)))?;
            let (before, end) = (at(angle + sweep * 0.92), at(angle + sweep));
            arrow(area, eye, &before, &end, &VERMILLION, 6)?;
        }
    }
    label(area, eye, [&Vector3::zeros(), &(ring.axis * (radius + 0.10))], &ring.label, &INK)
}

/// The box of the unit; faces turned away are not seen.
fn unit(area: &Area<'_>, eye: &Eye, turned: &Matrix3<f64>) -> Drawn {
    for (k, half) in BOX.iter().enumerate() {
        let [next, last] = [(k + 1) % 3, (k + 2) % 3];
        for sign in [-1.0, 1.0] {
            let normal: Vector3<f64> = turned.column(k) * sign;
            if eye.is_behind(&normal) {
                continue;
            }
            let edge = |axis: usize| turned.column(axis) * BOX.get(axis).copied().unwrap_or(0.0);
            let (a, b): (Vector3<f64>, Vector3<f64>) = (edge(next), edge(last));
            let middle = normal * *half;
            let corners = [middle + a + b, middle + a - b, middle - a - b, middle - a + b].map(|point| eye.at(&point));
            let colour = if sign > 0.0 { SKY.mix(0.55) } else { TINT.mix(1.0) };
            area.draw(&Polygon::new(corners, colour.filled()))?;
            let [first, ..] = corners;
            area.draw(&PathElement::new(corners.into_iter().chain([first]).collect::<Vec<_>>(), SOFT.stroke_width(2)))?;
        }
    }
    Ok(())
}

fn named_arrow(
    area: &Area<'_>,
    eye: &Eye,
    [from, to]: [Vector3<f64>; 2],
    name: &str,
    colour: &RGBColor,
    width: u32,
) -> Drawn {
    arrow(area, eye, &from, &to, colour, width)?;
    label(area, eye, [&from, &to], name, colour)
}

fn arrow(area: &Area<'_>, eye: &Eye, from: &Vector3<f64>, to: &Vector3<f64>, colour: &RGBColor, width: u32) -> Drawn {
    let (start, end) = (eye.at(from), eye.at(to));
    area.draw(&PathElement::new([start, end], colour.stroke_width(width)))?;
    let (dx, dy) = (f64::from(end.0 - start.0), f64::from(end.1 - start.1));
    let length = dx.hypot(dy);
    if length < 4.0 {
        // towards the eye or away from it
        area.draw(&Circle::new(end, 6, colour.filled()))?;
        return Ok(());
    }
    let (ux, uy) = (dx / length, dy / length);
    let back = |along: f64, across: f64| {
        let x = f64::from(end.0) - along * ux - across * uy;
        let y = f64::from(end.1) - along * uy + across * ux;
        (number::whole(x.round()), number::whole(y.round()))
    };
    area.draw(&Polygon::new([end, back(20.0, 8.0), back(20.0, -8.0)], colour.filled()))?;
    Ok(())
}

/// A label at the end of a line: to its right, or to its left where the line points there.
fn label(area: &Area<'_>, eye: &Eye, [from, at]: [&Vector3<f64>; 2], text: &str, colour: &RGBColor) -> Drawn {
    let (x, y) = eye.at(at);
    let left = x < eye.at(from).0 - GAP;
    let wide = text_width(text, SMALL);
    let x = if left { (x - GAP).max(wide) } else { (x + GAP).min(HALF as i32 - wide) };
    let anchor = if left { HPos::Right } else { HPos::Left };
    let place = (x, y.clamp(TEXT / 2, HEIGHT as i32 - TEXT / 2));
    area.draw(&Text::new(text.to_string(), place, style(SMALL, colour, anchor, VPos::Center)))?;
    Ok(())
}
