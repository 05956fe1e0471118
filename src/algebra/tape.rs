//! A model line compiled against a list of names: its value and exact gradient without allocation.
//!
//! The registers of a tape are the inputs that it uses, its constants, and one result per step. The gradient is one sweep
//! back over the steps (reverse mode): `bar(operand) += bar(result) * d result / d operand`. A register holds one number, or the numbers of several
//! places side by side; those of several places are the numbers of each alone, to the last bit.
#![allow(
    clippy::indexing_slicing,
    reason = "`compile` gives every operand a register among inputs, constants and earlier steps, and `forward` sizes registers and bars to all of them"
)]

use super::expression::{Expression, Node};
use super::function::{Function, Operator, integer_power, small_integer};
use crate::elements::OrNan;
use crate::error::{Fault, Malformed, Result};
use std::f64::consts::PI;

/// One number at each of several places.
pub(crate) type Lane<const L: usize> = [f64; L];

/// The numbers of each place. A loop, since `std::array` builds lists of so many by calls.
#[inline(always)]
pub(crate) fn lanes<const L: usize>(part: impl Fn(usize) -> f64) -> Lane<L> {
    let mut all = [0.0; L];
    set(&mut all, part);
    all
}

/// A compiled model line; its inputs are the names given to [`Tape::compile`], in that order.
///
/// ```
/// use tumble::algebra::{Expression, Scratch, Tape};
/// let model = Expression::parse("V0 + kI*w_I")?;
/// let tape = Tape::compile(&model, &["w_I", "V0", "kI"])?;
/// let mut gradient = [0.0; 3];
/// let value = tape.gradient(&[20.0, 0.5, -3.0], &mut Scratch::default(), &mut gradient);
/// assert_eq!(value, -59.5);
/// assert_eq!(gradient, [-3.0, 1.0, 20.0]);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
#[derive(Debug, Clone)]
pub struct Tape {
    /// Slot of each input register.
    slots: Vec<usize>,
    constants: Vec<f64>,
    steps: Vec<Step<usize>>,
    /// Register of the expression's value.
    result: usize,
}

/// Working memory, reused between evaluations of any tapes.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    registers: Vec<f64>,
    bars: Vec<f64>,
}

/// One operation on operands `R`: sources while compiling, registers afterwards.
#[derive(Debug, Clone, Copy)]
enum Step<R> {
    Negate(R),
    Call(Function, R),
    Power(R, i32),
    Binary(Operator, R, R),
}

/// Where a node's value comes from, while registers have no numbers yet.
#[derive(Debug, Clone, Copy)]
enum Source {
    Input(usize),
    Constant(f64),
    Step(usize),
}

impl Default for Source {
    fn default() -> Self {
        Source::Constant(f64::NAN)
    }
}

impl Tape {
    /// Compile an expression; `names` are its slots, in this order.
    ///
    /// Errors: `UnknownName`, with the span in the expression's text, for a name that is not among them.
    pub fn compile(expression: &Expression, names: &[&str]) -> Result<Tape> {
        let used = expression.names();
        let mut slots = Vec::with_capacity(used.len());
        for name in &used {
            let slot = names.iter().position(|slot| slot == name);
            slots.push(slot.ok_or_else(|| unknown_name(expression, name, names))?);
        }

        let mut steps: Vec<Step<Source>> = Vec::new();
        let result = expression.fold(|node| {
            let step = match node {
                Node::Number(number) => return Source::Constant(number),
                Node::Pi => return Source::Constant(PI),
                // `used` lists every name of the line
                Node::Name(name) => return Source::Input(used.iter().position(|n| *n == name).unwrap_or_default()),
                Node::Negate(Source::Constant(x)) => return Source::Constant(-x),
                Node::Negate(x) => Step::Negate(x),
                Node::Call(function, Source::Constant(x)) => return Source::Constant(function.value(x)),
                Node::Call(function, x) => Step::Call(function, x),
                Node::Binary(operator, Source::Constant(left), Source::Constant(right)) => {
                    return Source::Constant(operator.value(left, right));
                }
                Node::Binary(Operator::Power, base, Source::Constant(exponent)) => match small_integer(exponent) {
                    Some(exponent) => Step::Power(base, exponent),
                    None => Step::Binary(Operator::Power, base, Source::Constant(exponent)),
                },
                Node::Binary(operator, left, right) => Step::Binary(operator, left, right),
            };
            steps.push(step);
            Source::Step(steps.len() - 1)
        });

        let mut constants = Vec::new();
        let mut keep = |source: &Source| {
            if let Source::Constant(number) = source
                && !constants.iter().any(|kept: &f64| kept.to_bits() == number.to_bits())
            {
                constants.push(*number);
            }
        };
        steps.iter().for_each(|step| step.operands().into_iter().flatten().for_each(&mut keep));
        keep(&result);
        let register = |source: Source| match source {
            Source::Input(input) => input,
            Source::Constant(number) => {
                let place = constants.iter().position(|kept| kept.to_bits() == number.to_bits());
                // `keep` has seen every constant that a step or the result uses
                slots.len() + place.unwrap_or_default()
            }
            Source::Step(step) => slots.len() + constants.len() + step,
        };
        let steps = steps.iter().map(|step| step.over(register)).collect();
        let result = register(result);
        Ok(Tape { slots, constants, steps, result })
    }

    /// The value at `inputs` (one for each name of [`Tape::compile`]; one that is absent counts as not a number).
    pub fn value(&self, inputs: &[f64], scratch: &mut Scratch) -> f64 {
        let [value] = self.forward(|k| [inputs.or_nan(self.slots[k])], &mut scratch.registers)[self.result];
        value
    }

    /// The value, and in `gradient` (overwritten) its derivative with respect to every name; names that do not occur get zero.
    ///
    /// The derivatives of `sign` and `step`, and of `abs` at 0, are taken as 0. The derivative with respect to the exponent
    /// of a negative number does not exist: it is not a number.
    pub fn gradient(&self, inputs: &[f64], scratch: &mut Scratch, gradient: &mut [f64]) -> f64 {
        gradient.fill(0.0);
        let [value] = self.gradient_of(
            |k| [inputs.or_nan(self.slots[k])],
            scratch,
            |k, [bar]| gradient.get_mut(self.slots[k]).into_iter().for_each(|to| *to = *bar),
        );
        value
    }

    /// The places among the names of [`Tape::compile`] that the tape reads.
    pub(crate) fn reads(&self) -> &[usize] {
        &self.slots
    }

    /// The values at several places side by side: `input` and `give` have the inputs and the derivatives for each of [`Tape::reads`].
    #[inline(always)]
    pub(crate) fn gradient_of<const L: usize>(
        &self,
        input: impl Fn(usize) -> Lane<L>,
        scratch: &mut Scratch,
        mut give: impl FnMut(usize, &Lane<L>),
    ) -> Lane<L> {
        let Scratch { registers, bars } = scratch;
        let registers = self.forward(input, registers);
        bars.clear();
        bars.resize(registers.len() * L, 0.0);
        let bars = bars.as_chunks_mut::<L>().0;
        bars[self.result] = [1.0; L];
        let first_step = self.slots.len() + self.constants.len();
        for (index, step) in self.steps.iter().enumerate().rev() {
            let here = first_step + index;
            let (before, from) = bars.split_at_mut(here);
            let (bar, value) = (&from[0], &registers[here]);
            if *bar == [0.0; L] {
                continue; // an infinite slope with a zero factor must not reach the others
            }
            match *step {
                Step::Negate(x) => plus(&mut before[x], bar, |l| -bar[l]),
                Step::Call(function, x) => {
                    let argument = &registers[x];
                    plus(&mut before[x], bar, |l| bar[l] * function.derivative(argument[l], value[l]));
                }
                Step::Power(x, 2) => plus(&mut before[x], bar, |l| 2.0 * bar[l] * registers[x][l]),
                Step::Power(_, 0) => {}
                Step::Power(x, k) => {
                    plus(&mut before[x], bar, |l| bar[l] * f64::from(k) * integer_power(registers[x][l], k - 1));
                }
                Step::Binary(Operator::Add, left, right) => {
                    plus(&mut before[left], bar, |l| bar[l]);
                    plus(&mut before[right], bar, |l| bar[l]);
                }
                Step::Binary(Operator::Subtract, left, right) => {
                    plus(&mut before[left], bar, |l| bar[l]);
                    plus(&mut before[right], bar, |l| -bar[l]);
                }
                Step::Binary(Operator::Multiply, left, right) => {
                    plus(&mut before[left], bar, |l| bar[l] * registers[right][l]);
                    plus(&mut before[right], bar, |l| bar[l] * registers[left][l]);
                }
                Step::Binary(Operator::Divide, left, right) => {
                    let divisor = &registers[right];
                    plus(&mut before[left], bar, |l| bar[l] / divisor[l]);
                    plus(&mut before[right], bar, |l| -(bar[l] * value[l] / divisor[l]));
                }
                Step::Binary(Operator::Atan2, left, right) => {
                    let (y, x) = (&registers[left], &registers[right]);
                    plus(&mut before[left], bar, |l| bar[l] * (x[l] / x[l].hypot(y[l])) / x[l].hypot(y[l]));
                    plus(&mut before[right], bar, |l| -(bar[l] * (y[l] / x[l].hypot(y[l])) / x[l].hypot(y[l])));
                }
                Step::Binary(Operator::Power, left, right) => {
                    let (base, exponent) = (&registers[left], &registers[right]);
                    plus(&mut before[left], bar, |l| {
                        let e = exponent[l];
                        if e == 0.0 { 0.0 } else { bar[l] * e * Operator::Power.value(base[l], e - 1.0) }
                    });
                    // The limit of x^y ln x at x = 0 for y > 0.
                    plus(
                        &mut before[right],
                        bar,
                        |l| {
                            if value[l] == 0.0 { 0.0 } else { bar[l] * value[l] * base[l].ln() }
                        },
                    );
                }
            }
        }
        bars.iter().take(self.slots.len()).enumerate().for_each(|(k, bar)| give(k, bar));
        registers[self.result]
    }

    /// Forward sweep: every register's values.
    #[inline(always)]
    fn forward<'a, const L: usize>(
        &self,
        input: impl Fn(usize) -> Lane<L>,
        registers: &'a mut Vec<f64>,
    ) -> &'a mut [Lane<L>] {
        let read = self.slots.len();
        let first_step = read + self.constants.len();
        registers.resize((first_step + self.steps.len()) * L, 0.0);
        let registers = registers.as_chunks_mut::<L>().0;
        registers.iter_mut().take(read).enumerate().for_each(|(k, register)| *register = input(k));
        for (register, constant) in registers[read..].iter_mut().zip(&self.constants) {
            *register = [*constant; L];
        }
        for (index, step) in self.steps.iter().enumerate() {
            let (before, from) = registers.split_at_mut(first_step + index);
            let out = &mut from[0];
            match *step {
                Step::Negate(x) => set(out, |l| -before[x][l]),
                Step::Call(function, x) => set(out, |l| function.value(before[x][l])),
                Step::Power(x, 2) => set(out, |l| before[x][l] * before[x][l]),
                Step::Power(x, exponent) => set(out, |l| integer_power(before[x][l], exponent)),
                Step::Binary(Operator::Add, x, y) => set(out, |l| before[x][l] + before[y][l]),
                Step::Binary(Operator::Subtract, x, y) => set(out, |l| before[x][l] - before[y][l]),
                Step::Binary(Operator::Multiply, x, y) => set(out, |l| before[x][l] * before[y][l]),
                Step::Binary(Operator::Divide, x, y) => set(out, |l| before[x][l] / before[y][l]),
                Step::Binary(operator, x, y) => set(out, |l| operator.value(before[x][l], before[y][l])),
            }
        }
        registers
    }
}

#[inline(always)]
fn set<const L: usize>(out: &mut Lane<L>, of: impl Fn(usize) -> f64) {
    out.iter_mut().enumerate().for_each(|(l, out)| *out = of(l));
}

/// `to += part` at the places where the bar is not zero: there a place alone skips the step.
#[inline(always)]
fn plus<const L: usize>(to: &mut Lane<L>, bar: &Lane<L>, part: impl Fn(usize) -> f64) {
    for l in 0..L {
        let term = part(l);
        to[l] += if bar[l] == 0.0 { 0.0 } else { term };
    }
}

impl<R: Copy> Step<R> {
    fn operands(&self) -> [Option<&R>; 2] {
        match self {
            Step::Negate(x) | Step::Call(_, x) | Step::Power(x, _) => [Some(x), None],
            Step::Binary(_, left, right) => [Some(left), Some(right)],
        }
    }

    fn over<S>(&self, register: impl Fn(R) -> S) -> Step<S> {
        match *self {
            Step::Negate(x) => Step::Negate(register(x)),
            Step::Call(function, x) => Step::Call(function, register(x)),
            Step::Power(x, exponent) => Step::Power(register(x), exponent),
            Step::Binary(operator, left, right) => Step::Binary(operator, register(left), register(right)),
        }
    }
}

fn unknown_name(expression: &Expression, name: &str, names: &[&str]) -> Malformed {
    // a line that was computed, not written, has no place for the caret
    let (start, length) = expression.span_of(name).unwrap_or_default();
    Malformed::new(Fault::UnknownName, format!("'{name}' is not known here"))
        .expected(if names.is_empty() { "no names at all".to_string() } else { format!("one of {}", names.join(", ")) })
        .found(format!("'{name}'"))
        .at_span(start, length)
}
