//! A tape at many places at once: the operations of `tape.rs`, each on a whole list of numbers, so that reading the tape costs nothing.
//!
//! Lists stand one after the other, `places` numbers each. The results are those of single places, to the last bit. The loop stands apart from that of
//! `tape.rs`: there the step is the inner loop and a register a number, here places are the inner loop and a register is a list.
#![allow(
    clippy::indexing_slicing,
    reason = "`compile` gives every operand a register among inputs, constants and earlier steps; `gradient_of_many` sizes registers and bars to all of them at `places` numbers each, after comparing the inputs with the tape"
)]

use super::function::{Operator, integer_power};
use super::tape::{Step, Tape};

/// Room to work in.
#[derive(Debug, Clone, Default)]
pub(crate) struct Lists {
    registers: Vec<f64>,
    bars: Vec<f64>,
}

impl Tape {
    /// The places among the names of [`Tape::compile`] that the tape reads; of them alone [`Tape::gradient_of_many`] takes inputs and gives derivatives.
    pub(crate) fn reads(&self) -> &[usize] {
        &self.slots
    }

    /// [`Tape::gradient`] at many places: `inputs` has a list for each of [`Tape::reads`], and `gradient` gets one for each; `values` is one list.
    #[inline(always)]
    pub(crate) fn gradient_of_many(
        &self,
        places: usize,
        inputs: &[f64],
        lists: &mut Lists,
        values: &mut [f64],
        gradient: &mut [f64],
    ) {
        let Lists { registers, bars } = lists;
        let first_step = self.slots.len() + self.constants.len();
        let size = (first_step + self.steps.len()) * places;
        if places == 0 || inputs.len() < self.slots.len() * places {
            return;
        }
        registers.resize(size, 0.0);
        let read = self.slots.len() * places;
        registers[..read].copy_from_slice(&inputs[..read]);
        for (register, constant) in registers[read..].chunks_exact_mut(places).zip(&self.constants) {
            register.fill(*constant);
        }
        for (index, step) in self.steps.iter().enumerate() {
            let (before, from) = registers.split_at_mut((first_step + index) * places);
            let out = &mut from[..places];
            let of = |x: usize| &before[x * places..(x + 1) * places];
            match *step {
                Step::Negate(x) => one(out, of(x), |x| -x),
                Step::Call(function, x) => one(out, of(x), |x| function.value(x)),
                Step::Power(x, 2) => one(out, of(x), |x| x * x),
                Step::Power(x, exponent) => one(out, of(x), |x| integer_power(x, exponent)),
                Step::Binary(Operator::Add, x, y) => two(out, of(x), of(y), |a, b| a + b),
                Step::Binary(Operator::Subtract, x, y) => two(out, of(x), of(y), |a, b| a - b),
                Step::Binary(Operator::Multiply, x, y) => two(out, of(x), of(y), |a, b| a * b),
                Step::Binary(Operator::Divide, x, y) => two(out, of(x), of(y), |a, b| a / b),
                Step::Binary(operator, x, y) => two(out, of(x), of(y), |a, b| operator.value(a, b)),
            }
        }
        let found = &registers[self.result * places..(self.result + 1) * places];
        values.iter_mut().zip(found).for_each(|(to, value)| *to = *value);
        bars.clear();
        bars.resize(size, 0.0);
        bars[self.result * places..(self.result + 1) * places].fill(1.0);
        for (index, step) in self.steps.iter().enumerate().rev() {
            let here = (first_step + index) * places;
            let (before, from) = bars.split_at_mut(here);
            let bar = &from[..places];
            let value = &registers[here..here + places];
            let of = |x: usize| &registers[x * places..(x + 1) * places];
            let to = |before: &mut [f64], x: usize, part: &dyn Fn(usize) -> f64| {
                let to = &mut before[x * places..(x + 1) * places];
                to.iter_mut().zip(bar).enumerate().for_each(|(l, (to, bar))| {
                    if *bar != 0.0 {
                        *to += part(l);
                    }
                });
            };
            match *step {
                Step::Negate(x) => less(slot(before, x, places), bar),
                Step::Call(function, x) => {
                    let own = of(x);
                    to(before, x, &|l| bar[l] * function.derivative(own[l], value[l]));
                }
                Step::Power(x, 2) => plus(slot(before, x, places), bar, of(x), |bar, x| 2.0 * bar * x),
                Step::Power(_, 0) => {}
                Step::Power(x, k) => {
                    plus(slot(before, x, places), bar, of(x), |bar, x| bar * f64::from(k) * integer_power(x, k - 1));
                }
                Step::Binary(Operator::Add, left, right) => {
                    more(slot(before, left, places), bar);
                    more(slot(before, right, places), bar);
                }
                Step::Binary(Operator::Subtract, left, right) => {
                    more(slot(before, left, places), bar);
                    less(slot(before, right, places), bar);
                }
                Step::Binary(Operator::Multiply, left, right) => {
                    plus(slot(before, left, places), bar, of(right), |bar, other| bar * other);
                    plus(slot(before, right, places), bar, of(left), |bar, other| bar * other);
                }
                Step::Binary(Operator::Divide, left, right) => {
                    let own = of(right);
                    plus(slot(before, left, places), bar, own, |bar, other| bar / other);
                    to(before, right, &|l| -(bar[l] * value[l] / own[l]));
                }
                Step::Binary(Operator::Atan2, left, right) => {
                    let (y, x) = (of(left), of(right));
                    to(before, left, &|l| bar[l] * (x[l] / x[l].hypot(y[l])) / x[l].hypot(y[l]));
                    to(before, right, &|l| -(bar[l] * (y[l] / x[l].hypot(y[l])) / x[l].hypot(y[l])));
                }
                Step::Binary(Operator::Power, left, right) => {
                    let (base, exponent) = (of(left), of(right));
                    to(before, left, &|l| {
                        let own = exponent[l];
                        if own == 0.0 { 0.0 } else { bar[l] * own * Operator::Power.value(base[l], own - 1.0) }
                    });
                    // The limit of x^y ln x at x = 0 for y > 0.
                    to(before, right, &|l| if value[l] == 0.0 { 0.0 } else { bar[l] * value[l] * base[l].ln() });
                }
            }
        }
        gradient[..read].copy_from_slice(&bars[..read]);
    }
}

#[inline(always)]
fn slot(lists: &mut [f64], k: usize, places: usize) -> &mut [f64] {
    &mut lists[k * places..(k + 1) * places]
}

#[inline(always)]
fn one(out: &mut [f64], x: &[f64], of: impl Fn(f64) -> f64) {
    out.iter_mut().zip(x).for_each(|(out, x)| *out = of(*x));
}

#[inline(always)]
fn two(out: &mut [f64], x: &[f64], y: &[f64], of: impl Fn(f64, f64) -> f64) {
    out.iter_mut().zip(x.iter().zip(y)).for_each(|(out, (x, y))| *out = of(*x, *y));
}

/// `to += bar`; a bar of zero adds nothing, whatever the sign.
#[inline(always)]
fn more(to: &mut [f64], bar: &[f64]) {
    to.iter_mut().zip(bar).for_each(|(to, bar)| *to += bar);
}

#[inline(always)]
fn less(to: &mut [f64], bar: &[f64]) {
    to.iter_mut().zip(bar).for_each(|(to, bar)| *to -= bar);
}

/// `to += part` where the bar is not zero, as a single place skips a step there.
#[inline(always)]
fn plus(to: &mut [f64], bar: &[f64], other: &[f64], part: impl Fn(f64, f64) -> f64) {
    for ((to, bar), other) in to.iter_mut().zip(bar).zip(other) {
        let own = part(*bar, *other);
        *to += if *bar == 0.0 { 0.0 } else { own };
    }
}
