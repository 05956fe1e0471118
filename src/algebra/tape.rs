//! A model line compiled against a list of names: its value and exact gradient without allocation.
//!
//! The registers of a tape are the inputs that it uses, its constants, and one result per step. The gradient is one sweep
//! back over the steps (reverse mode): `bar(operand) += bar(result) * d result / d operand`.

use super::expression::{Expression, Node};
use super::function::{Function, Operator, integer_power, small_integer};
use crate::error::{Fault, Malformed, Result};
use std::f64::consts::PI;

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
    steps: Vec<Step>,
    /// Register of the expression's value.
    result: usize,
}

/// Room to work in, reused between evaluations of any tapes.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    registers: Vec<f64>,
    bars: Vec<f64>,
}

/// One operation on earlier registers.
#[derive(Debug, Clone, Copy)]
enum Step {
    Negate(usize),
    Call(Function, usize),
    Power(usize, i32),
    Binary(Operator, usize, usize),
}

/// Where a node's value is, while registers are not numbered yet.
#[derive(Debug, Clone, Copy)]
enum Source {
    Constant(f64),
    Input(usize),
    Step(usize),
}

impl Default for Source {
    fn default() -> Self {
        Source::Constant(0.0)
    }
}

/// A step whose operands are not numbered yet.
type Draft = (Source, Source, Kind);

/// What a drafted step does.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Negate,
    Call(Function),
    Power(i32),
    Binary(Operator),
}

impl Tape {
    /// Compile an expression; `names` are its slots, in this order.
    ///
    /// Errors: `UnknownName`, with the span in the expression's text, for a name that is not among them.
    pub fn compile(expression: &Expression, names: &[&str]) -> Result<Tape> {
        if let Some(unknown) = expression.names().into_iter().find(|name| !names.contains(name)) {
            let error = Malformed::new(Fault::UnknownName, format!("'{unknown}' is not known here"))
                .expected(format!("one of {}", names.join(", ")))
                .found(format!("'{unknown}'"));
            return Err(match expression.span_of(unknown) {
                Some((start, len)) => error.at_span(start, len),
                None => error,
            });
        }
        let mut slots: Vec<usize> = Vec::new();
        let mut drafts: Vec<Draft> = Vec::new();
        let result = expression.fold(|node: Node<'_, Source>| {
            let (kind, left, right) = match node {
                Node::Number(number) => return Source::Constant(number),
                Node::Pi => return Source::Constant(PI),
                Node::Name(name) => {
                    let slot = names.iter().position(|own| *own == name).unwrap_or_default();
                    let register = slots.iter().position(|own| *own == slot).unwrap_or_else(|| {
                        slots.push(slot);
                        slots.len() - 1
                    });
                    return Source::Input(register);
                }
                Node::Negate(Source::Constant(x)) => return Source::Constant(-x),
                Node::Negate(x) => (Kind::Negate, x, x),
                Node::Call(function, Source::Constant(x)) => return Source::Constant(function.value(x)),
                Node::Call(function, x) => (Kind::Call(function), x, x),
                Node::Binary(operator, Source::Constant(x), Source::Constant(y)) => {
                    return Source::Constant(operator.value(x, y));
                }
                Node::Binary(Operator::Power, x, Source::Constant(y)) if small_integer(y).is_some() => {
                    (Kind::Power(small_integer(y).unwrap_or_default()), x, x)
                }
                Node::Binary(operator, x, y) => (Kind::Binary(operator), x, y),
            };
            drafts.push((left, right, kind));
            Source::Step(drafts.len() - 1)
        });
        // constants stand between inputs and steps, so they are numbered once all inputs are known
        let mut constants: Vec<f64> = Vec::new();
        let inputs = slots.len();
        let constant_of = |x: f64, constants: &mut Vec<f64>| {
            let at = constants.iter().position(|own| own.to_bits() == x.to_bits()).unwrap_or_else(|| {
                constants.push(x);
                constants.len() - 1
            });
            inputs + at
        };
        for (left, right, _) in &drafts {
            for source in [left, right] {
                if let Source::Constant(x) = source {
                    constant_of(*x, &mut constants);
                }
            }
        }
        if let Source::Constant(x) = result {
            constant_of(x, &mut constants);
        }
        let first_step = inputs + constants.len();
        let mut register = |source: &Source| match source {
            Source::Constant(x) => constant_of(*x, &mut constants),
            Source::Input(k) => *k,
            Source::Step(k) => first_step + k,
        };
        let steps = drafts.iter().map(|(left, right, kind)| numbered(register(left), register(right), *kind)).collect();
        let result = register(&result);
        Ok(Tape { slots, constants, steps, result })
    }

    /// Forward sweep: every register's value.
    fn forward(&self, inputs: &[f64], registers: &mut Vec<f64>) {
        registers.clear();
        registers.extend(self.slots.iter().map(|slot| inputs.get(*slot).copied().unwrap_or_default()));
        registers.extend_from_slice(&self.constants);
        for step in &self.steps {
            let value = match *step {
                Step::Negate(x) => -registers[x],
                Step::Call(function, x) => function.value(registers[x]),
                Step::Power(x, exponent) => integer_power(registers[x], exponent),
                Step::Binary(operator, x, y) => operator.value(registers[x], registers[y]),
            };
            registers.push(value);
        }
    }

    /// The value at `inputs` (one for each name of [`Tape::compile`]).
    pub fn value(&self, inputs: &[f64], scratch: &mut Scratch) -> f64 {
        self.forward(inputs, &mut scratch.registers);
        scratch.registers[self.result]
    }

    /// The value, and in `gradient` (overwritten) its derivative with respect to every name; names that do not occur get zero.
    pub fn gradient(&self, inputs: &[f64], scratch: &mut Scratch, gradient: &mut [f64]) -> f64 {
        self.forward(inputs, &mut scratch.registers);
        let Scratch { registers, bars } = scratch;
        bars.clear();
        bars.resize(registers.len(), 0.0);
        bars[self.result] = 1.0;
        let first_step = self.slots.len() + self.constants.len();
        for (k, step) in self.steps.iter().enumerate().rev() {
            let here = first_step + k;
            let (bar, value) = (bars[here], registers[here]);
            if bar == 0.0 {
                continue; // also keeps a slope that is infinite at a point nobody asks for out of the others
            }
            match *step {
                Step::Negate(x) => bars[x] -= bar,
                Step::Call(function, x) => bars[x] += bar * function.derivative(registers[x], value),
                Step::Power(_, 0) => {}
                Step::Power(x, exponent) => {
                    bars[x] += bar * f64::from(exponent) * integer_power(registers[x], exponent - 1);
                }
                Step::Binary(Operator::Add, x, y) => {
                    bars[x] += bar;
                    bars[y] += bar;
                }
                Step::Binary(Operator::Subtract, x, y) => {
                    bars[x] += bar;
                    bars[y] -= bar;
                }
                Step::Binary(Operator::Multiply, x, y) => {
                    bars[x] += bar * registers[y];
                    bars[y] += bar * registers[x];
                }
                Step::Binary(Operator::Divide, x, y) => {
                    bars[x] += bar / registers[y];
                    bars[y] -= bar * value / registers[y];
                }
                Step::Binary(Operator::Power, x, y) => {
                    let (base, exponent) = (registers[x], registers[y]);
                    bars[x] += bar * exponent * base.powf(exponent - 1.0);
                    bars[y] += bar * if base == 0.0 { 0.0 } else { value * base.ln() };
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
}

/// A drafted step with its operands' registers.
fn numbered(left: usize, right: usize, kind: Kind) -> Step {
    match kind {
        Kind::Negate => Step::Negate(left),
        Kind::Call(function) => Step::Call(function, left),
        Kind::Power(exponent) => Step::Power(left, exponent),
        Kind::Binary(operator) => Step::Binary(operator, left, right),
    }
}
