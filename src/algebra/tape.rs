//! A model line compiled against a list of names: its value and exact gradient without allocation.
//!
//! The registers of a tape are the inputs that it uses, its constants, and one result per step. The gradient is one sweep
//! back over the steps (reverse mode): `bar(operand) += bar(result) * d result / d operand`.
#![allow(
    clippy::indexing_slicing,
    reason = "`compile` gives every operand a register among inputs, constants and earlier steps, and `forward` sizes registers and bars to all of them"
)]

use super::expression::{Expression, Node};
use super::function::{Function, Operator, integer_power, small_integer};
use crate::elements::OrNan;
use crate::error::{Fault, Malformed, Result};
use std::f64::consts::PI;

/// One number at each of four places (`four.rs`).
pub(crate) type Lane = [f64; 4];

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
    pub(super) slots: Vec<usize>,
    pub(super) constants: Vec<f64>,
    pub(super) steps: Vec<Step<usize>>,
    /// Register of the expression's value.
    pub(super) result: usize,
}

/// Room to work in, reused between evaluations of any tapes.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    registers: Vec<f64>,
    bars: Vec<f64>,
    pub(super) of_four: [Vec<Lane>; 2],
}

/// One operation on operands `R`: sources while compiling, registers afterwards.
#[derive(Debug, Clone, Copy)]
pub(super) enum Step<R> {
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
        let own = expression.names();
        let mut slots = Vec::with_capacity(own.len());
        for name in &own {
            let slot = names.iter().position(|slot| slot == name);
            slots.push(slot.ok_or_else(|| unknown_name(expression, name, names))?);
        }

        let mut steps: Vec<Step<Source>> = Vec::new();
        let result = expression.fold(|node| {
            let step = match node {
                Node::Number(number) => return Source::Constant(number),
                Node::Pi => return Source::Constant(PI),
                // `own` lists every name of the line
                Node::Name(name) => return Source::Input(own.iter().position(|own| *own == name).unwrap_or_default()),
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
        self.forward(inputs, &mut scratch.registers);
        scratch.registers[self.result]
    }

    /// The value, and in `gradient` (overwritten) its derivative with respect to every name; names that do not occur get zero.
    ///
    /// The derivatives of `sign` and `step`, and of `abs` at 0, are taken as 0. The derivative with respect to the exponent
    /// of a negative number does not exist: it is not a number.
    pub fn gradient(&self, inputs: &[f64], scratch: &mut Scratch, gradient: &mut [f64]) -> f64 {
        self.forward(inputs, &mut scratch.registers);
        let Scratch { registers, bars, .. } = scratch;
        bars.clear();
        bars.resize(registers.len(), 0.0);
        bars[self.result] = 1.0;
        let first_step = self.slots.len() + self.constants.len();
        for (index, step) in self.steps.iter().enumerate().rev() {
            let here = first_step + index;
            let (bar, value) = (bars[here], registers[here]);
            if bar == 0.0 {
                continue; // also keeps a slope that is infinite at a point nobody asks for out of the others
            }
            match *step {
                Step::Negate(x) => bars[x] -= bar,
                Step::Call(function, x) => bars[x] += bar * function.derivative(registers[x], value),
                Step::Power(x, 2) => bars[x] += 2.0 * bar * registers[x],
                Step::Power(_, 0) => {}
                Step::Power(x, k) => bars[x] += bar * f64::from(k) * integer_power(registers[x], k - 1),
                Step::Binary(Operator::Add, left, right) => {
                    bars[left] += bar;
                    bars[right] += bar;
                }
                Step::Binary(Operator::Subtract, left, right) => {
                    bars[left] += bar;
                    bars[right] -= bar;
                }
                Step::Binary(Operator::Multiply, left, right) => {
                    bars[left] += bar * registers[right];
                    bars[right] += bar * registers[left];
                }
                Step::Binary(Operator::Divide, left, right) => {
                    bars[left] += bar / registers[right];
                    bars[right] -= bar * value / registers[right];
                }
                Step::Binary(Operator::Atan2, left, right) => {
                    let (y, x) = (registers[left], registers[right]);
                    let size = x.hypot(y);
                    bars[left] += bar * (x / size) / size;
                    bars[right] -= bar * (y / size) / size;
                }
                Step::Binary(Operator::Power, left, right) => {
                    let (base, exponent) = (registers[left], registers[right]);
                    if exponent != 0.0 {
                        bars[left] += bar * exponent * Operator::Power.value(base, exponent - 1.0);
                    }
                    // The limit of x^y ln x at x = 0 for y > 0.
                    if value != 0.0 {
                        bars[right] += bar * value * base.ln();
                    }
                }
            }
        }
        gradient.fill(0.0);
        for (slot, bar) in self.slots.iter().zip(bars.iter()) {
            if let Some(derivative) = gradient.get_mut(*slot) {
                *derivative = *bar;
            }
        }
        registers[self.result]
    }

    /// Forward sweep: every register's value.
    fn forward(&self, inputs: &[f64], registers: &mut Vec<f64>) {
        let first_step = self.slots.len() + self.constants.len();
        registers.resize(first_step + self.steps.len(), 0.0);
        for (register, slot) in registers.iter_mut().zip(&self.slots) {
            *register = inputs.or_nan(*slot);
        }
        registers[self.slots.len()..first_step].copy_from_slice(&self.constants);
        for (index, step) in self.steps.iter().enumerate() {
            registers[first_step + index] = match *step {
                Step::Negate(x) => -registers[x],
                Step::Call(function, x) => function.value(registers[x]),
                Step::Power(x, exponent) => integer_power(registers[x], exponent),
                Step::Binary(operator, x, y) => operator.value(registers[x], registers[y]),
            };
        }
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
