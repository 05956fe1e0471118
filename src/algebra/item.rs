//! Items of a line in postfix order: what the parser writes and the tree is read from.

use super::function::{Function, Operator};

/// One item of the postfix order.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Item {
    /// Finite and not negative: a minus sign is always an item of its own.
    Number(f64),
    Pi,
    Name(String),
    Negate,
    Call(Function),
    Binary(Operator),
}
