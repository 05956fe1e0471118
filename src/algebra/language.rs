//! A model line, and its slopes, as expressions of a programming language.

use super::expression::{Expression, Node};
use super::function::{Function, Operator, small_integer};

/// How a programming language writes what model lines are made of.
#[derive(Debug, Clone, Copy)]
pub struct Language {
    /// A number, not negative.
    pub number: fn(f64) -> String,
    /// `pi`.
    pub pi: &'static str,
    /// A function of one argument.
    pub call: fn(Function, &str) -> String,
    /// The natural logarithm (in slopes by an exponent).
    pub ln: fn(&str) -> String,
    /// The angle of the point (x, y), from y and x.
    pub atan2: fn(&str, &str) -> String,
    /// A base to a whole exponent (of at most 64), evaluated by repeated multiplication as tumble does.
    pub whole_power: fn(&str, i32) -> String,
    /// A base to any other exponent.
    pub power: fn(&str, &str) -> String,
}

/// A part of a line on its way: its text, its value where it is a number, its slope where it has one.
#[derive(Default)]
struct Written {
    text: String,
    number: Option<f64>,
    slope: Option<String>,
}

impl Expression {
    /// The line in a language, every operation in parentheses, so that it is evaluated in the same order; `name` gives each name's text.
    pub(crate) fn in_language(&self, language: &Language, name: &dyn Fn(&str) -> String) -> String {
        self.written(language, name, "").text
    }

    /// The derivative of the line by one of its names; `None` where it is zero everywhere.
    pub(crate) fn slope_in_language(
        &self,
        language: &Language,
        name: &dyn Fn(&str) -> String,
        by: &str,
    ) -> Option<String> {
        self.written(language, name, by).slope
    }

    fn written(&self, language: &Language, name: &dyn Fn(&str) -> String, by: &str) -> Written {
        let number = language.number;
        let times = |a: String, b: String| if b == number(1.0) { a } else { format!("({a} * {b})") };
        self.fold(|node: Node<'_, Written>| match node {
            Node::Number(value) => Written { text: number(value), number: Some(value), slope: None },
            Node::Pi => Written { text: language.pi.to_string(), ..Written::default() },
            Node::Name(n) => Written { text: name(n), number: None, slope: (n == by).then(|| number(1.0)) },
            Node::Negate(x) => Written {
                text: format!("(-{})", x.text),
                number: x.number.map(|value| -value),
                slope: x.slope.map(|slope| format!("(-{slope})")),
            },
            Node::Call(function, x) => Written {
                text: (language.call)(function, &x.text),
                number: None,
                slope: x.slope.and_then(|slope| Some(times(derivative(language, function, &x.text)?, slope))),
            },
            Node::Binary(operator, x, y) => {
                let whole = y.number.and_then(small_integer).filter(|_| operator == Operator::Power);
                let text = match (operator, whole) {
                    (_, Some(whole)) => (language.whole_power)(&x.text, whole),
                    (Operator::Power, None) => (language.power)(&x.text, &y.text),
                    (Operator::Atan2, _) => (language.atan2)(&x.text, &y.text),
                    _ => format!("({} {} {})", x.text, operator.symbol(), y.text),
                };
                // the slope through each operand
                let (left, right) = (&x.text, &y.text);
                let through_left = x.slope.and_then(|slope| {
                    Some(match (operator, whole) {
                        (_, Some(0)) => return None,
                        (_, Some(k)) => {
                            let sign = if k < 0 { "-" } else { "" };
                            let lower = (language.whole_power)(left, k - 1);
                            times(format!("({sign}{} * {lower})", number(f64::from(k.abs()))), slope)
                        }
                        (Operator::Power, None) => {
                            let lower = (language.power)(left, &format!("({right} - {})", number(1.0)));
                            times(format!("({right} * {lower})"), slope)
                        }
                        (Operator::Multiply, _) => times(right.clone(), slope),
                        (Operator::Divide, _) => format!("({slope} / {right})"),
                        (Operator::Atan2, _) => times(format!("({right} / {})", squares(left, right)), slope),
                        (Operator::Add | Operator::Subtract, _) => slope,
                    })
                });
                let through_right = y.slope.map(|slope| match operator {
                    Operator::Add => slope,
                    Operator::Subtract => format!("(-{slope})"),
                    Operator::Multiply => times(left.clone(), slope),
                    Operator::Divide => times(format!("(-{text} / {right})"), slope),
                    Operator::Power => times(format!("({text} * {})", (language.ln)(left)), slope),
                    Operator::Atan2 => times(format!("(-{left} / {})", squares(left, right)), slope),
                });
                let slope = match (through_left, through_right) {
                    (Some(a), Some(b)) => Some(format!("({a} + {b})")),
                    (one, other) => one.or(other),
                };
                Written { text, number: None, slope }
            }
        })
    }
}

fn squares(y: &str, x: &str) -> String {
    format!("({x} * {x} + {y} * {y})")
}

/// The derivative of a function at `x`; `None` where it is zero.
fn derivative(language: &Language, function: Function, x: &str) -> Option<String> {
    let (number, call) = (language.number, language.call);
    let one = number(1.0);
    let arc =
        |sign: &str| format!("({sign}{one} / {})", call(Function::Sqrt, &format!("(({one} - {x}) * ({one} + {x}))")));
    Some(match function {
        Function::Sin => call(Function::Cos, x),
        Function::Cos => format!("(-{})", call(Function::Sin, x)),
        Function::Tan => format!("({one} + {0} * {0})", call(Function::Tan, x)),
        Function::Asin => arc(""),
        Function::Acos => arc("-"),
        Function::Atan => format!("({one} / ({one} + {x} * {x}))"),
        Function::Sqrt => format!("({} / {})", number(0.5), call(Function::Sqrt, x)),
        Function::Abs => call(Function::Sign, x),
        Function::Exp => call(Function::Exp, x),
        Function::Sign | Function::Step => return None,
    })
}
