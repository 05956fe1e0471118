//! The tree as text: one spelling for terms that are the same product or sum in another order, and what was written with as few parentheses as the
//! grammar allows.

use super::expression::{Expression, Node};
use super::function::{ATAN2, Operator, integer_power, small_integer};
use std::collections::BTreeMap;
use std::fmt;

/// Passes until a line with sums in parentheses is the same when it is read again; two or three do.
const SETTLING: usize = 8;

/// What is raised to a power inside a term; plain names sort before everything else.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Base {
    Name(String),
    /// A function or a sum in parentheses.
    Operand(String),
    /// A power that no integer exponent describes.
    Power(String),
}

/// The factors of a term with their exponents, none of them 0; no factors is the number 1.
type Factors = BTreeMap<Base, i32>;

/// A sum of terms, each its factors times a number that is not 0; no terms is the number 0.
#[derive(Debug, Default)]
struct Sum(BTreeMap<Factors, f64>);

impl Expression {
    /// The expression with sorted factors and terms: the same for `a_S*a_I` and `a_I*a_S`.
    ///
    /// Numbers are multiplied out, equal factors become powers, equal terms are added; a product of sums is not expanded,
    /// but a sum times a number is.
    /// Names come before functions in a product, and a plain number is a sum's last term.
    ///
    /// ```
    /// use tumble::algebra::Expression;
    /// assert_eq!(Expression::parse("a_S*a_I")?.canonical(), "a_I*a_S");
    /// assert_eq!(Expression::parse("cos(beta*2) * gamma_deg_s")?.canonical(), "gamma_deg_s*cos(2*beta)");
    /// assert_eq!(Expression::parse("(-a-b)*c")?.canonical(), Expression::parse("-(a+b)*c")?.canonical());
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    pub fn canonical(&self) -> String {
        let mut text = self.sorted();
        // a number before a sum in parentheses is multiplied into it when the line is read again: until nothing changes
        for _ in 0..SETTLING {
            if !text.contains('(') {
                break;
            }
            match Expression::parse(&text).map(|line| line.sorted()) {
                Ok(next) if next != text => text = next,
                _ => break,
            }
        }
        text
    }

    fn sorted(&self) -> String {
        let mut finite = true;
        let sum = self.fold(|node| {
            let sum = sum_of(node);
            finite &= sum.0.values().all(|number| number.is_finite());
            sum
        });
        // a line whose numbers overflow is left unchanged
        if finite { sum.text() } else { self.to_string() }
    }
}

fn sum_of(node: Node<'_, Sum>) -> Sum {
    match node {
        Node::Number(number) => Sum::term(Factors::new(), number),
        Node::Pi => Sum::factor(Base::Name("pi".to_string()), 1),
        Node::Name(name) => Sum::factor(Base::Name(name.to_string()), 1),
        Node::Negate(x) => x.scaled(-1.0),
        Node::Call(function, x) => Sum::factor(Base::Operand(format!("{}({})", function.name(), x.text())), 1),
        Node::Binary(Operator::Add, left, right) => left.added(right),
        Node::Binary(Operator::Subtract, left, right) => left.added(right.scaled(-1.0)),
        Node::Binary(Operator::Multiply, left, right) => left.multiplied(right),
        Node::Binary(Operator::Divide, left, right) => left.multiplied(right.raised(-1)),
        Node::Binary(Operator::Atan2, y, x) => {
            Sum::factor(Base::Operand(format!("{ATAN2}({},{})", y.text(), x.text())), 1)
        }
        Node::Binary(Operator::Power, left, right) => match right.number().and_then(small_integer) {
            Some(exponent) => left.raised(exponent),
            None => Sum::factor(Base::Power(format!("{}^{}", left.operand(), right.operand())), 1),
        },
    }
}

impl Sum {
    fn term(factors: Factors, number: f64) -> Sum {
        Sum(BTreeMap::from([(factors, number)]).into_iter().filter(|(_, number)| *number != 0.0).collect())
    }

    fn factor(base: Base, exponent: i32) -> Sum {
        Sum::term(Factors::from([(base, exponent)]), 1.0)
    }

    /// The number that the sum is, if it is one.
    fn number(&self) -> Option<f64> {
        match (self.0.len(), self.0.first_key_value()) {
            (0, _) => Some(0.0),
            (1, Some((factors, number))) if factors.is_empty() => Some(*number),
            _ => None,
        }
    }

    fn scaled(mut self, by: f64) -> Sum {
        self.0.values_mut().for_each(|number| *number *= by);
        self.0.retain(|_, number| *number != 0.0);
        self
    }

    fn added(mut self, other: Sum) -> Sum {
        for (factors, number) in other.0 {
            *self.0.entry(factors).or_default() += number;
        }
        self.0.retain(|_, number| *number != 0.0);
        self
    }

    /// The sum as one term: a sum of several becomes a factor in parentheses, its first name with a plus, so that `(-a-b)*c` is `-(a+b)*c`.
    fn into_term(mut self) -> (Factors, f64) {
        if self.0.len() > 1 {
            let first = self.0.iter().find(|(factors, _)| !factors.is_empty());
            let sign = if first.is_some_and(|(_, number)| *number < 0.0) { -1.0 } else { 1.0 };
            return (Factors::from([(Base::Operand(format!("({})", self.scaled(sign).text())), 1)]), sign);
        }
        // a sum of no terms is the empty product times zero
        self.0.pop_first().unwrap_or_default()
    }

    fn multiplied(self, other: Sum) -> Sum {
        match (self.number(), other.number()) {
            (Some(number), _) => return other.scaled(number),
            (_, Some(number)) => return self.scaled(number),
            _ => {}
        }
        let (mut factors, number) = self.into_term();
        let (more, other_number) = other.into_term();
        for (base, exponent) in more {
            let power = factors.entry(base).or_default();
            *power = power.saturating_add(exponent);
        }
        factors.retain(|_, power| *power != 0);
        Sum::term(factors, number * other_number)
    }

    fn raised(self, exponent: i32) -> Sum {
        if exponent == 1 {
            return self;
        }
        let (mut factors, number) = self.into_term();
        factors.values_mut().for_each(|power| *power = power.saturating_mul(exponent));
        factors.retain(|_, power| *power != 0);
        Sum::term(factors, integer_power(number, exponent))
    }

    fn text(&self) -> String {
        let (numbers, terms): (Vec<_>, Vec<_>) = self.0.iter().partition(|(factors, _)| factors.is_empty());
        let mut text = String::new();
        for (factors, number) in terms.into_iter().chain(numbers) {
            if *number < 0.0 {
                text.push('-');
            } else if !text.is_empty() {
                text.push('+');
            }
            text.push_str(&term_text(factors, number.abs()));
        }
        if text.is_empty() { "0".to_string() } else { text }
    }

    /// The text as an operand of a power.
    fn operand(&self) -> String {
        let text = self.text();
        let single = text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '.');
        if single { text } else { format!("({text})") }
    }
}

fn term_text(factors: &Factors, size: f64) -> String {
    let above: Vec<String> = factors.iter().filter(|(_, e)| **e > 0).map(|(base, e)| power_text(base, *e)).collect();
    let mut text = match (size == 1.0, above.is_empty()) {
        (true, false) => above.join("*"),
        (_, true) => number(size),
        (false, false) => format!("{}*{}", number(size), above.join("*")),
    };
    for (base, exponent) in factors.iter().filter(|(_, exponent)| **exponent < 0) {
        text.push('/');
        text.push_str(&power_text(base, exponent.saturating_neg()));
    }
    text
}

fn power_text(base: &Base, exponent: i32) -> String {
    match (base, exponent) {
        (Base::Name(text) | Base::Operand(text) | Base::Power(text), 1) => text.clone(),
        (Base::Name(text) | Base::Operand(text), _) => format!("{text}^{exponent}"),
        (Base::Power(text), _) => format!("({text})^{exponent}"),
    }
}

/// Precedence of a piece of text, from a sum to a single operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) enum Binding {
    #[default]
    Sum,
    Product,
    Minus,
    Power,
    Operand,
}

/// A piece of text and its precedence.
#[derive(Debug, Default)]
struct Piece {
    text: String,
    binding: Binding,
}

impl Piece {
    /// The text, in parentheses where its precedence is lower than `binding`.
    fn at_least(self, binding: Binding) -> String {
        if self.binding < binding { format!("({})", self.text) } else { self.text }
    }
}

impl fmt::Display for Expression {
    /// Prints the tree; parsing what is printed gives an equal tree.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.fold(piece).text)
    }
}

fn piece(node: Node<'_, Piece>) -> Piece {
    let (text, binding) = match node {
        Node::Number(value) => (number(value), Binding::Operand),
        Node::Pi => ("pi".to_string(), Binding::Operand),
        Node::Name(name) => (name.to_string(), Binding::Operand),
        Node::Negate(x) => (format!("-{}", x.at_least(Binding::Minus)), Binding::Minus),
        Node::Call(function, x) => (format!("{}({})", function.name(), x.text), Binding::Operand),
        Node::Binary(Operator::Atan2, y, x) => (format!("{ATAN2}({}, {})", y.text, x.text), Binding::Operand),
        Node::Binary(operator, left, right) => {
            let (binding, least_left, least_right) = match operator {
                Operator::Add | Operator::Subtract => (Binding::Sum, Binding::Sum, Binding::Product),
                Operator::Multiply | Operator::Divide => (Binding::Product, Binding::Product, Binding::Minus),
                Operator::Power | Operator::Atan2 => (Binding::Power, Binding::Operand, Binding::Minus),
            };
            let space = if binding == Binding::Sum { " " } else { "" };
            let mut text = left.at_least(least_left);
            text.push_str(&format!("{space}{}{space}{}", operator.symbol(), right.at_least(least_right)));
            (text, binding)
        }
    };
    Piece { text, binding }
}

/// The shortest text that reads back as the same number.
pub(super) fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-5..1e15).contains(&size) { format!("{value}") } else { format!("{value:e}") }
}
