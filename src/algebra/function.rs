//! What a model line is made of; the names, values and derivatives of its operators and functions.

use crate::number;
use crate::vocabulary::vocabulary;

vocabulary! {
    /// A function of one argument that a model line may call, in the order in which messages list them.
    Function {
        /// Sine, of radians.
        Sin = "sin",
        /// Cosine, of radians.
        Cos = "cos",
        /// Tangent, of radians.
        Tan = "tan",
        /// Inverse sine, in radians.
        Asin = "asin",
        /// Inverse cosine, in radians.
        Acos = "acos",
        /// Inverse tangent, in radians.
        Atan = "atan",
        /// Square root.
        Sqrt = "sqrt",
        /// Absolute value; its derivative at 0 is taken as 0.
        Abs = "abs",
        /// -1, 0 or 1; its derivative is taken as 0 everywhere.
        Sign = "sign",
        /// Exponential.
        Exp = "exp",
        /// 1 where the argument is at least 0, else 0; its derivative is taken as 0 everywhere.
        Step = "step",
    }
}

impl Function {
    /// The function of that name, if there is one.
    pub fn from_name(name: &str) -> Option<Function> {
        Function::ALL.into_iter().find(|function| function.name() == name)
    }

    pub(super) fn value(self, x: f64) -> f64 {
        match self {
            Function::Sin => x.sin(),
            Function::Cos => x.cos(),
            Function::Tan => x.tan(),
            Function::Asin => x.asin(),
            Function::Acos => x.acos(),
            Function::Atan => x.atan(),
            Function::Sqrt => x.sqrt(),
            Function::Abs => x.abs(),
            Function::Sign if x == 0.0 => 0.0,
            Function::Sign => x.signum(),
            Function::Exp => x.exp(),
            Function::Step if x.is_nan() => x,
            Function::Step => f64::from(u8::from(x >= 0.0)),
        }
    }

    /// Derivative at `x`, where the function is `value`.
    pub(super) fn derivative(self, x: f64, value: f64) -> f64 {
        match self {
            Function::Sin => x.cos(),
            Function::Cos => -x.sin(),
            Function::Tan => 1.0 + value * value,
            Function::Asin => 1.0 / ((1.0 - x) * (1.0 + x)).sqrt(),
            Function::Acos => -1.0 / ((1.0 - x) * (1.0 + x)).sqrt(),
            Function::Atan => 1.0 / (1.0 + x * x),
            Function::Sqrt => 0.5 / value,
            Function::Abs => Function::Sign.value(x),
            Function::Exp => value,
            Function::Sign | Function::Step => 0.0,
        }
    }
}

/// An operator between two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    /// `atan2(y, x)`, the angle of the point (x, y), in radians from -pi to pi.
    Atan2,
}

/// The function of two arguments, written as a call.
pub(super) const ATAN2: &str = "atan2";

impl Operator {
    pub(super) fn symbol(self) -> char {
        match self {
            Operator::Add => '+',
            Operator::Subtract => '-',
            Operator::Multiply => '*',
            Operator::Divide => '/',
            Operator::Power => '^',
            Operator::Atan2 => ',',
        }
    }

    pub(super) fn value(self, left: f64, right: f64) -> f64 {
        match self {
            Operator::Add => left + right,
            Operator::Subtract => left - right,
            Operator::Multiply => left * right,
            Operator::Divide => left / right,
            Operator::Atan2 => left.atan2(right),
            Operator::Power => match small_integer(right) {
                Some(exponent) => integer_power(left, exponent),
                None => left.powf(right),
            },
        }
    }
}

/// One item of a line in postfix order: what the parser writes and the tree is read from.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Item {
    /// Finite and not negative: a minus sign is a separate item.
    Number(f64),
    Pi,
    Name(String),
    Negate,
    Call(Function),
    Binary(Operator),
}

/// The number as an exponent for repeated multiplication: an integer of at most 64 in size.
pub(super) fn small_integer(number: f64) -> Option<i32> {
    (number.abs() <= 64.0 && number == number.trunc()).then_some(number::whole(number))
}

/// `x^exponent` by repeated multiplication; `x^0` is 1.
pub(super) fn integer_power(x: f64, exponent: i32) -> f64 {
    if exponent == 2 {
        return x * x;
    }
    let mut power = 1.0;
    for _ in 0..exponent.unsigned_abs() {
        power *= x;
    }
    if exponent < 0 { 1.0 / power } else { power }
}
