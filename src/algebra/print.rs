//! The tree as text, with as few parentheses as the grammar allows.

use super::expression::{Expression, Node};
use super::function::{ATAN2, Operator};
use std::fmt;

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
