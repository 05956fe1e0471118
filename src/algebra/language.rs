//! A model line as an expression of a programming language.

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
    /// A base to a whole exponent (of at most 64), evaluated by repeated multiplication as tumble does.
    pub whole_power: fn(&str, i32) -> String,
    /// A base to any other exponent.
    pub power: fn(&str, &str) -> String,
}

impl Expression {
    /// The line in a language, every operation in parentheses, so that it is evaluated in the same order; `name` gives each name's text.
    ///
    /// ```
    /// use tumble::algebra::{Expression, Language};
    /// let c = Language {
    ///     number: |x| format!("{x:?}"),
    ///     pi: "M_PI",
    ///     call: |function, x| format!("{}({x})", function.name()),
    ///     whole_power: |x, n| format!("ipow({x}, {n})"),
    ///     power: |x, y| format!("pow({x}, {y})"),
    /// };
    /// let line = Expression::parse("V0 - k*w_I^2")?;
    /// assert_eq!(line.in_language(&c, &|name| name.to_string()), "(V0 - (k * ipow(w_I, 2)))");
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    pub fn in_language(&self, language: &Language, name: &dyn Fn(&str) -> String) -> String {
        let (text, _) = self.fold(|node: Node<'_, (String, Option<f64>)>| match node {
            Node::Number(value) => ((language.number)(value), Some(value)),
            Node::Pi => (language.pi.to_string(), None),
            Node::Name(own) => (name(own), None),
            Node::Negate((x, value)) => (format!("(-{x})"), value.map(|v| -v)),
            Node::Call(function, (x, _)) => ((language.call)(function, &x), None),
            Node::Binary(Operator::Power, (x, _), (y, exponent)) => match exponent.and_then(small_integer) {
                Some(whole) => ((language.whole_power)(&x, whole), None),
                None => ((language.power)(&x, &y), None),
            },
            Node::Binary(operator, (x, _), (y, _)) => (format!("({x} {} {y})", operator.symbol()), None),
        });
        text
    }
}
