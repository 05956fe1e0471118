//! A tape at four places at once: the operations of `tape.rs`, each on four numbers side by side.
//!
//! The loop stands apart, as one over a type parameter would be compiled for single numbers without their shortcuts (a step is one instruction
//! there, four lanes here), and both must agree to the last bit, which a test asks.
#![allow(
    clippy::indexing_slicing,
    reason = "`run` sizes registers and bars to inputs, constants and steps, and a compiled tape refers to these only; a lane has four numbers"
)]

use super::function::{Operator, integer_power};
use super::tape::{Lane, Scratch, Step, Tape};

#[inline(always)]
fn zip(a: Lane, b: Lane, of: impl Fn(f64, f64) -> f64) -> Lane {
    std::array::from_fn(|l| of(a[l], b[l]))
}

/// `to += part` where the bar is not zero, as a single place skips a step there.
#[inline(always)]
fn add(to: &mut Lane, bar: Lane, part: Lane) {
    for ((to, bar), part) in to.iter_mut().zip(bar).zip(part) {
        *to += if bar == 0.0 { 0.0 } else { part };
    }
}

impl Tape {
    /// [`Tape::gradient`] at four places: the values come back, the derivatives with respect to every name go to `gradient` (overwritten).
    #[inline(always)]
    pub(crate) fn gradient_of_four(&self, inputs: &[Lane], scratch: &mut Scratch, gradient: &mut [Lane]) -> Lane {
        let [registers, bars] = &mut scratch.of_four;
        self.forward_of_four(inputs, registers);
        bars.clear();
        bars.resize(registers.len(), [0.0; 4]);
        bars[self.result] = [1.0; 4];
        let first_step = self.slots.len() + self.constants.len();
        for (index, step) in self.steps.iter().enumerate().rev() {
            let here = first_step + index;
            let (bar, value) = (bars[here], registers[here]);
            if bar == [0.0; 4] {
                continue;
            }
            match *step {
                Step::Negate(x) => add(&mut bars[x], bar, bar.map(|bar| -bar)),
                Step::Call(function, x) => {
                    let slope = zip(registers[x], value, |x, value| function.derivative(x, value));
                    add(&mut bars[x], bar, zip(bar, slope, |a, b| a * b));
                }
                Step::Power(x, 2) => add(&mut bars[x], bar, zip(bar, registers[x], |bar, x| 2.0 * bar * x)),
                Step::Power(_, 0) => {}
                Step::Power(x, k) => {
                    let part = zip(bar, registers[x], |bar, x| bar * f64::from(k) * integer_power(x, k - 1));
                    add(&mut bars[x], bar, part);
                }
                Step::Binary(Operator::Add, left, right) => {
                    add(&mut bars[left], bar, bar);
                    add(&mut bars[right], bar, bar);
                }
                Step::Binary(Operator::Subtract, left, right) => {
                    add(&mut bars[left], bar, bar);
                    add(&mut bars[right], bar, bar.map(|bar| -bar));
                }
                Step::Binary(Operator::Multiply, left, right) => {
                    add(&mut bars[left], bar, zip(bar, registers[right], |a, b| a * b));
                    add(&mut bars[right], bar, zip(bar, registers[left], |a, b| a * b));
                }
                Step::Binary(Operator::Divide, left, right) => {
                    add(&mut bars[left], bar, zip(bar, registers[right], |a, b| a / b));
                    let part = zip(bar, value, |a, b| a * b);
                    add(&mut bars[right], bar, zip(part, registers[right], |a, b| -(a / b)));
                }
                Step::Binary(Operator::Atan2, left, right) => {
                    let (y, x) = (registers[left], registers[right]);
                    let size = zip(x, y, f64::hypot);
                    let share = |side: Lane| std::array::from_fn(|l| bar[l] * (side[l] / size[l]) / size[l]);
                    add(&mut bars[left], bar, share(x));
                    add(&mut bars[right], bar, share(y).map(|part| -part));
                }
                Step::Binary(Operator::Power, left, right) => {
                    let (base, exponent) = (registers[left], registers[right]);
                    let of_base = |l: usize| {
                        let own: f64 = exponent[l];
                        if own == 0.0 { 0.0 } else { bar[l] * own * Operator::Power.value(base[l], own - 1.0) }
                    };
                    // The limit of x^y ln x at x = 0 for y > 0.
                    let of_exponent = |l: usize| if value[l] == 0.0 { 0.0 } else { bar[l] * value[l] * base[l].ln() };
                    add(&mut bars[left], bar, std::array::from_fn(of_base));
                    add(&mut bars[right], bar, std::array::from_fn(of_exponent));
                }
            }
        }
        gradient.fill([0.0; 4]);
        for (slot, bar) in self.slots.iter().zip(bars.iter()) {
            if let Some(derivative) = gradient.get_mut(*slot) {
                *derivative = *bar;
            }
        }
        registers[self.result]
    }

    #[inline(always)]
    fn forward_of_four(&self, inputs: &[Lane], registers: &mut Vec<Lane>) {
        let first_step = self.slots.len() + self.constants.len();
        registers.resize(first_step + self.steps.len(), [0.0; 4]);
        for (register, slot) in registers.iter_mut().zip(&self.slots) {
            // an input that is not given is not a number, and so is what depends on it
            *register = inputs.get(*slot).copied().unwrap_or([f64::NAN; 4]);
        }
        for (register, constant) in registers.iter_mut().skip(self.slots.len()).zip(&self.constants) {
            *register = [*constant; 4];
        }
        for (index, step) in self.steps.iter().enumerate() {
            registers[first_step + index] = match *step {
                Step::Negate(x) => registers[x].map(|x| -x),
                Step::Call(function, x) => registers[x].map(|x| function.value(x)),
                Step::Power(x, 2) => registers[x].map(|x| x * x),
                Step::Power(x, exponent) => registers[x].map(|x| integer_power(x, exponent)),
                Step::Binary(Operator::Add, x, y) => zip(registers[x], registers[y], |a, b| a + b),
                Step::Binary(Operator::Subtract, x, y) => zip(registers[x], registers[y], |a, b| a - b),
                Step::Binary(Operator::Multiply, x, y) => zip(registers[x], registers[y], |a, b| a * b),
                Step::Binary(operator, x, y) => zip(registers[x], registers[y], |a, b| operator.value(a, b)),
            };
        }
    }
}
