//! The tree of a model line, kept in postfix order, and how trees are put together.

use super::function::{Function, Item, Operator};
use crate::error::{Fault, Malformed, Result};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A model line: its tree and its text. Two are equal when their trees are.
///
/// ```
/// use tumble::algebra::Expression;
/// let model = Expression::parse("V0 + kI*w_I")?;
/// assert_eq!(model.names(), ["V0", "kI", "w_I"]);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Expression {
    /// Operands before their operator: `a + b*c` is `a b c * +`.
    postfix: Vec<Item>,
    text: String,
}

/// One node of the tree with the values of its operands.
#[derive(Debug, Clone, Copy)]
pub(super) enum Node<'a, T> {
    Number(f64),
    Pi,
    Name(&'a str),
    Negate(T),
    Call(Function, T),
    Binary(Operator, T, T),
}

impl<'a, T> Node<'a, T> {
    /// The same node with something else for its operands.
    fn map<U>(self, mut of: impl FnMut(T) -> U) -> Node<'a, U> {
        match self {
            Node::Number(number) => Node::Number(number),
            Node::Pi => Node::Pi,
            Node::Name(name) => Node::Name(name),
            Node::Negate(x) => Node::Negate(of(x)),
            Node::Call(function, x) => Node::Call(function, of(x)),
            Node::Binary(operator, left, right) => {
                let left = of(left);
                Node::Binary(operator, left, of(right))
            }
        }
    }
}

/// A part of the tree, and its value.
#[derive(Debug, Clone, Default)]
pub(super) struct Part<T> {
    pub value: T,
    /// The number that it is, if no name occurs in it.
    pub number: Option<f64>,
    /// Its items in the postfix order.
    range: Range<usize>,
}

impl TryFrom<String> for Expression {
    type Error = String;
    fn try_from(text: String) -> std::result::Result<Self, String> {
        let said = |error: Malformed| format!("{}, expected {}", error.what(), error.expectation().unwrap_or_default());
        Expression::parse(&text).map_err(said)
    }
}

impl From<Expression> for String {
    fn from(of: Expression) -> String {
        of.to_string()
    }
}

impl PartialEq for Expression {
    fn eq(&self, other: &Self) -> bool {
        self.postfix == other.postfix
    }
}

impl Expression {
    /// Reads a model line.
    ///
    /// Errors are [`Fault::Syntax`], with the span in bytes of `text`, what was expected and what was found.
    ///
    /// ```
    /// use tumble::algebra::Expression;
    /// let error = Expression::parse("V0 + * w_I").unwrap_err();
    /// assert_eq!(error.place().span, Some((5, 1)));
    /// assert_eq!(error.expectation(), Some("a number, a name, a function or '('"));
    /// assert_eq!(error.finding(), Some("'*'"));
    /// ```
    pub fn parse(text: &str) -> Result<Expression> {
        Ok(Expression { postfix: super::parse::postfix(text)?, text: text.to_string() })
    }

    /// The expression that is one number; an error where it is not finite.
    pub(crate) fn number(value: f64) -> Result<Expression> {
        if !value.is_finite() {
            return Err(Malformed::new(Fault::Value, "a model line can only hold finite numbers")
                .expected("a finite number")
                .found(value.to_string()));
        }
        let mut postfix = vec![Item::Number(value.abs())];
        if value.is_sign_negative() {
            postfix.push(Item::Negate);
        }
        Ok(Expression::of(postfix))
    }

    /// The text that was parsed, or, for an expression put together from others, its printed form.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The distinct names in order of first appearance; functions and `pi` are not names.
    pub fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for item in &self.postfix {
            if let Item::Name(name) = item
                && !names.contains(&name.as_str())
            {
                names.push(name);
            }
        }
        names
    }

    /// Where a name first occurs in [`Expression::text`]: its first byte and its length.
    pub(crate) fn span_of(&self, name: &str) -> Option<(usize, usize)> {
        // a point too: the "e3" of 1.e3 is no name
        let in_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
        self.text.match_indices(name).map(|(start, _)| start).find_map(|start| {
            let before = self.text.get(..start)?.chars().next_back();
            let after = self.text.get(start + name.len()..)?.chars().next();
            let whole = !before.is_some_and(in_word) && !after.is_some_and(in_word);
            whole.then_some((start, name.len()))
        })
    }

    /// Is it an expression less one, as the relative error `K/1.299 - 1`? Its divisor then has the unit of its dividend.
    pub(crate) fn is_less_one(&self) -> bool {
        matches!(self.postfix.as_slice(), [.., Item::Number(1.0), Item::Binary(Operator::Subtract)])
    }

    /// `self + other`.
    pub(crate) fn plus(&self, other: &Expression) -> Expression {
        self.with(other, Operator::Add)
    }

    /// `self * other`.
    pub(crate) fn times(&self, other: &Expression) -> Expression {
        self.with(other, Operator::Multiply)
    }

    /// Every `name` replaced by `value`.
    pub(crate) fn substitute(&self, name: &str, value: &Expression) -> Expression {
        let mut postfix = Vec::with_capacity(self.postfix.len());
        for item in &self.postfix {
            match item {
                Item::Name(n) if n == name => postfix.extend_from_slice(&value.postfix),
                kept => postfix.push(kept.clone()),
            }
        }
        Expression::of(postfix)
    }

    /// The smallest part that has no finite value though its operands have; `None` where the whole has one.
    pub(crate) fn without_value(&self, value_of: &dyn Fn(&str) -> f64) -> Option<Expression> {
        let mut first = None;
        self.fold_parts(|node: Node<'_, Part<f64>>, here| {
            let value = match node.map(|x| x.value) {
                Node::Number(number) => number,
                Node::Pi => std::f64::consts::PI,
                Node::Name(name) => value_of(name),
                Node::Negate(x) => -x,
                Node::Call(function, x) => function.value(x),
                Node::Binary(operator, left, right) => operator.value(left, right),
            };
            if !value.is_finite() && first.is_none() {
                first = Some(here.range.clone());
            }
            value
        });
        self.items(&first?)
    }

    /// Is it an azimuth, `c*atan2(y, x)` with a constant c? Then c, y and x.
    pub(crate) fn as_azimuth(&self) -> Option<(f64, Expression, Expression)> {
        // a factor times the azimuth of two parts
        type Azimuth = Option<(f64, Range<usize>, Range<usize>)>;
        let (factor, y, x) = self.fold_parts(|node: Node<'_, Part<Azimuth>>, _| match node {
            Node::Negate(x) => x.value.map(|(factor, y, x)| (-factor, y, x)),
            Node::Binary(Operator::Atan2, y, x) if y.number.zip(x.number).is_none() => Some((1.0, y.range, x.range)),
            Node::Binary(Operator::Multiply, azimuth, by) | Node::Binary(Operator::Multiply, by, azimuth)
                if azimuth.value.is_some() =>
            {
                azimuth.value.zip(by.number).map(|((factor, y, x), c)| (factor * c, y, x))
            }
            Node::Binary(Operator::Divide, azimuth, by) => {
                azimuth.value.zip(by.number).map(|((factor, y, x), c)| (factor / c, y, x))
            }
            _ => None,
        })?;
        Some((factor, self.items(&y)?, self.items(&x)?))
    }

    /// Is it the length of a vector, `sqrt(x^2 + y^2 + ...)`? Then its components.
    pub(crate) fn as_norm(&self) -> Option<Vec<Expression>> {
        // the components of a sum of squares, and of the root of one
        type Squares = (bool, Option<Vec<Expression>>);
        let (root, components) = self.fold_parts(|node: Node<'_, Part<Squares>>, _| match node {
            Node::Binary(Operator::Power, base, two) if two.number == Some(2.0) => {
                (false, self.items(&base.range).map(|component| vec![component]))
            }
            Node::Binary(Operator::Add, left, right) => match (left.value, right.value) {
                ((false, Some(left)), (false, Some(right))) => (false, Some([left, right].concat())),
                _ => (false, None),
            },
            Node::Call(Function::Sqrt, Part { value: (false, inner), .. }) => (true, inner),
            _ => (false, None),
        });
        components.filter(|_| root)
    }

    /// A part of the postfix order by itself.
    fn items(&self, range: &Range<usize>) -> Option<Expression> {
        Some(Expression::of(self.postfix.get(range.clone())?.to_vec()))
    }

    fn with(&self, other: &Expression, operator: Operator) -> Expression {
        let mut postfix = self.postfix.clone();
        postfix.extend_from_slice(&other.postfix);
        postfix.push(Item::Binary(operator));
        Expression::of(postfix)
    }

    fn of(postfix: Vec<Item>) -> Expression {
        let mut expression = Expression { postfix, text: String::new() };
        expression.text = expression.to_string();
        expression
    }

    /// Works through the tree from its leaves: `rule` gets each node with the results of its operands.
    pub(super) fn fold<'a, T: Default>(&'a self, mut rule: impl FnMut(Node<'a, T>) -> T) -> T {
        self.fold_parts(|node, _| rule(node.map(|x| x.value)))
    }

    /// The same with the parts of the tree for the operands and the node.
    ///
    /// A postfix order always contains the operands of its operators, so the default of a part is not used.
    pub(super) fn fold_parts<'a, T: Default>(&'a self, mut rule: impl FnMut(Node<'a, Part<T>>, &Part<()>) -> T) -> T {
        let mut parts: Vec<Part<T>> = Vec::new();
        for (end, item) in self.postfix.iter().enumerate() {
            let mut operand = || parts.pop().unwrap_or_default();
            let (node, number, start) = match item {
                Item::Number(number) => (Node::Number(*number), Some(*number), end),
                Item::Pi => (Node::Pi, Some(std::f64::consts::PI), end),
                Item::Name(name) => (Node::Name(name), None, end),
                Item::Negate => {
                    let x = operand();
                    let (number, start) = (x.number.map(|x| -x), x.range.start);
                    (Node::Negate(x), number, start)
                }
                Item::Call(function) => {
                    let x = operand();
                    let (number, start) = (x.number.map(|x| function.value(x)), x.range.start);
                    (Node::Call(*function, x), number, start)
                }
                Item::Binary(operator) => {
                    let (right, left) = (operand(), operand());
                    let number = left.number.zip(right.number).map(|(left, right)| operator.value(left, right));
                    let start = left.range.start;
                    (Node::Binary(*operator, left, right), number, start)
                }
            };
            let here = Part { value: (), number, range: start..end + 1 };
            let value = rule(node, &here);
            parts.push(Part { value, number, range: here.range });
        }
        parts.pop().unwrap_or_default().value
    }
}
