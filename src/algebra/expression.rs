//! The tree of a model line, kept in postfix order, and how trees are put together.

use super::function::{Function, Operator};
use super::item::Item;
use crate::error::{Fault, Malformed, Result};

/// A model line: its tree and its text. Two are equal when their trees are.
///
/// ```
/// use tumble::algebra::Expression;
/// let model = Expression::parse("V0 + kI*w_I")?;
/// assert_eq!(model.names(), ["V0", "kI", "w_I"]);
/// assert_eq!(model.plus(&Expression::parse("D_S*a_S")?).to_string(), "V0 + kI*w_I + D_S*a_S");
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
#[derive(Debug, Clone)]
pub struct Expression {
    /// Operands before their operator: `a + b*c` is `a b c * +`.
    postfix: Vec<Item>,
    text: String,
}

/// One node of the tree with what was found for its operands.
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
    /// The same node seen through one part of what was found for its operands.
    pub(super) fn of<U>(&self, part: impl Fn(&T) -> U) -> Node<'a, U> {
        match self {
            Node::Number(number) => Node::Number(*number),
            Node::Pi => Node::Pi,
            Node::Name(name) => Node::Name(name),
            Node::Negate(x) => Node::Negate(part(x)),
            Node::Call(function, x) => Node::Call(*function, part(x)),
            Node::Binary(operator, left, right) => Node::Binary(*operator, part(left), part(right)),
        }
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
    pub fn number(value: f64) -> Result<Expression> {
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

    /// Where a name first stands in [`Expression::text`]: its first byte and its length.
    pub fn span_of(&self, name: &str) -> Option<(usize, usize)> {
        // a point too: the "e3" of 1.e3 is no name
        let in_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
        self.text.match_indices(name).map(|(start, _)| start).find_map(|start| {
            let before = self.text.get(..start)?.chars().next_back();
            let after = self.text.get(start + name.len()..)?.chars().next();
            let whole = !before.is_some_and(in_word) && !after.is_some_and(in_word);
            whole.then_some((start, name.len()))
        })
    }

    /// Is it something less one, as the relative error `K/1.299 - 1`? The number beside the one then has the unit of what it divides.
    pub fn is_less_one(&self) -> bool {
        matches!(self.postfix.as_slice(), [.., Item::Number(1.0), Item::Binary(Operator::Subtract)])
    }

    /// `self + other`.
    pub fn plus(&self, other: &Expression) -> Expression {
        self.with(other, Operator::Add)
    }

    /// `self * other`.
    pub fn times(&self, other: &Expression) -> Expression {
        self.with(other, Operator::Multiply)
    }

    /// Every `name` replaced by `value`.
    ///
    /// ```
    /// use tumble::algebra::Expression;
    /// let squared = Expression::parse("x^2")?.substitute("x", &Expression::parse("a + b")?);
    /// assert_eq!(squared.to_string(), "(a + b)^2");
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    pub fn substitute(&self, name: &str, value: &Expression) -> Expression {
        let mut postfix = Vec::with_capacity(self.postfix.len());
        for item in &self.postfix {
            match item {
                Item::Name(found) if found == name => postfix.extend_from_slice(&value.postfix),
                kept => postfix.push(kept.clone()),
            }
        }
        Expression::of(postfix)
    }

    /// The smallest part that has no finite value though its operands have; `None` where the whole has one.
    ///
    /// ```
    /// use tumble::algebra::Expression;
    /// let line = Expression::parse("b0 + b1/x")?;
    /// let part = line.without_value(&|name| if name == "x" { 0.0 } else { 1.0 });
    /// assert_eq!(part.map(|part| part.to_string()).as_deref(), Some("b1/x"));
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    pub fn without_value(&self, value_of: &dyn Fn(&str) -> f64) -> Option<Expression> {
        // where each operand begins in the postfix order, and its value
        let mut stack: Vec<(usize, f64)> = Vec::new();
        for (end, item) in self.postfix.iter().enumerate() {
            let (begin, value) = match item {
                Item::Number(number) => (end, *number),
                Item::Pi => (end, std::f64::consts::PI),
                Item::Name(name) => (end, value_of(name)),
                Item::Negate => stack.pop().map(|(begin, x)| (begin, -x))?,
                Item::Call(function) => stack.pop().map(|(begin, x)| (begin, function.value(x)))?,
                Item::Binary(operator) => {
                    let (_, right) = stack.pop()?;
                    let (begin, left) = stack.pop()?;
                    (begin, operator.value(left, right))
                }
            };
            if !value.is_finite() {
                return Some(Expression::of(self.postfix.get(begin..=end)?.to_vec()));
            }
            stack.push((begin, value));
        }
        None
    }

    /// Is it an azimuth, `c*atan2(y, x)` with a constant c? Then c, y and x.
    ///
    /// ```
    /// use tumble::algebra::Expression;
    /// let (scale, y, x) = Expression::parse("atan2(a + b, c)*180/pi")?.as_azimuth().unwrap();
    /// assert_eq!((scale, y.to_string(), x.to_string()), (180.0 / std::f64::consts::PI, "a + b".into(), "c".into()));
    /// assert!(Expression::parse("atan2(a, b) + c")?.as_azimuth().is_none());
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    pub fn as_azimuth(&self) -> Option<(f64, Expression, Expression)> {
        /// What an operand is: a constant, or a factor times the azimuth of two parts of the postfix order.
        #[derive(Clone)]
        enum Part {
            Constant(f64),
            Azimuth(f64, std::ops::Range<usize>, std::ops::Range<usize>),
            Other,
        }
        let mut stack: Vec<(usize, Part)> = Vec::new();
        for (end, item) in self.postfix.iter().enumerate() {
            let entry = match item {
                Item::Number(number) => (end, Part::Constant(*number)),
                Item::Pi => (end, Part::Constant(std::f64::consts::PI)),
                Item::Name(_) => (end, Part::Other),
                Item::Negate => match stack.pop()? {
                    (begin, Part::Constant(x)) => (begin, Part::Constant(-x)),
                    (begin, Part::Azimuth(factor, y, x)) => (begin, Part::Azimuth(-factor, y, x)),
                    (begin, Part::Other) => (begin, Part::Other),
                },
                Item::Call(function) => match stack.pop()? {
                    (begin, Part::Constant(x)) => (begin, Part::Constant(function.value(x))),
                    (begin, _) => (begin, Part::Other),
                },
                Item::Binary(operator) => {
                    let (middle, right) = stack.pop()?;
                    let (begin, left) = stack.pop()?;
                    let part = match (operator, left, right) {
                        (_, Part::Constant(a), Part::Constant(b)) => Part::Constant(operator.value(a, b)),
                        (Operator::Atan2, ..) => Part::Azimuth(1.0, begin..middle, middle..end),
                        (Operator::Multiply, Part::Azimuth(factor, y, x), Part::Constant(c))
                        | (Operator::Multiply, Part::Constant(c), Part::Azimuth(factor, y, x)) => {
                            Part::Azimuth(factor * c, y, x)
                        }
                        (Operator::Divide, Part::Azimuth(factor, y, x), Part::Constant(c)) => {
                            Part::Azimuth(factor / c, y, x)
                        }
                        _ => Part::Other,
                    };
                    (begin, part)
                }
            };
            stack.push(entry);
        }
        let (_, Part::Azimuth(factor, y, x)) = stack.pop()? else { return None };
        let part = |range| Some(Expression::of(self.postfix.get::<std::ops::Range<usize>>(range)?.to_vec()));
        Some((factor, part(y)?, part(x)?))
    }

    /// Is it the length of a vector, `sqrt(x^2 + y^2 + ...)`? Then its components.
    ///
    /// ```
    /// use tumble::algebra::Expression;
    /// let norm = Expression::parse("sqrt((a - b)^2 + c^2)")?.as_norm().unwrap();
    /// assert_eq!(norm.iter().map(|own| own.to_string()).collect::<Vec<_>>(), ["a - b", "c"]);
    /// assert!(Expression::parse("sqrt(a^2 + b)")?.as_norm().is_none());
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    pub fn as_norm(&self) -> Option<Vec<Expression>> {
        let (Item::Call(Function::Sqrt), inner) = self.postfix.split_last()? else { return None };
        // where each operand begins, and its components where it is a sum of squares
        let mut stack: Vec<(usize, Option<Vec<Expression>>)> = Vec::new();
        for (end, item) in inner.iter().enumerate() {
            let entry = match item {
                Item::Number(_) | Item::Pi | Item::Name(_) => (end, None),
                Item::Negate | Item::Call(_) => (stack.pop()?.0, None),
                Item::Binary(operator) => {
                    let (middle, right) = stack.pop()?;
                    let (begin, left) = stack.pop()?;
                    let components = match (operator, inner.get(middle..end)?) {
                        (Operator::Power, [Item::Number(2.0)]) => {
                            Some(vec![Expression::of(inner.get(begin..middle)?.to_vec())])
                        }
                        (Operator::Add, _) => left.zip(right).map(|(left, right)| [left, right].concat()),
                        _ => None,
                    };
                    (begin, components)
                }
            };
            stack.push(entry);
        }
        stack.pop()?.1
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
    ///
    /// A postfix order always holds the operands of its operators, so the default of `T` is never met.
    pub(super) fn fold<'a, T: Default>(&'a self, mut rule: impl FnMut(Node<'a, T>) -> T) -> T {
        let mut results: Vec<T> = Vec::new();
        for item in &self.postfix {
            let mut operand = || results.pop().unwrap_or_default();
            let node = match item {
                Item::Number(number) => Node::Number(*number),
                Item::Pi => Node::Pi,
                Item::Name(name) => Node::Name(name),
                Item::Negate => Node::Negate(operand()),
                Item::Call(function) => Node::Call(*function, operand()),
                Item::Binary(operator) => {
                    let right = operand();
                    Node::Binary(*operator, operand(), right)
                }
            };
            results.push(rule(node));
        }
        results.pop().unwrap_or_default()
    }
}

/// The value of a node whose operands are all numbers; `None` where one of them is a name.
pub(super) fn number_of(node: &Node<'_, Option<f64>>) -> Option<f64> {
    match *node {
        Node::Number(number) => Some(number),
        Node::Pi => Some(std::f64::consts::PI),
        Node::Name(_) => None,
        Node::Negate(x) => x.map(|x| -x),
        Node::Call(function, x) => x.map(|x| function.value(x)),
        Node::Binary(operator, left, right) => Some(operator.value(left?, right?)),
    }
}
