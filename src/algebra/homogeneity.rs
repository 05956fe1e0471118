//! What the units of a line's names must satisfy: sums of equal units, products of powers, functions of pure numbers or radians.
//!
//! ```text
//! V0 + kI*w_I   =>   the line has the unit of V0;   [kI] [w_I] / [V0] = 1
//! ```
//!
//! Their logarithms are linear equations; which names have a unit already is not known here.

use super::expression::{Expression, Node, Part};
use super::function::{Function, Operator};
use std::collections::BTreeMap;

/// A product of powers of the units of names, and of the radian.
#[derive(Debug, Clone, PartialEq)]
pub struct Powers<'a> {
    /// Name and power.
    pub names: BTreeMap<&'a str, f64>,
    /// Power of the radian, which functions of angles take and give.
    pub radian: f64,
    /// The product of the numerical factors: with a radian they may convert an angle, as in `atan(x)*180/pi`.
    pub factor: f64,
    /// Is `pi` among those numbers?
    pub pi: bool,
}

/// Why a product of powers is a pure number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reason {
    /// Two terms of a sum.
    Terms,
    /// What a function or an exponent takes: a pure number, or radians.
    Argument,
    /// It is added to one, as in `1 + eps` and `1 - 2*face`; other numbers (`t - 20`) give no relation: they may have a unit.
    One,
}

/// A product of powers that must be a pure number.
#[derive(Debug, Clone, PartialEq)]
pub struct Relation<'a> {
    /// The product.
    pub powers: Powers<'a>,
    /// Why.
    pub reason: Reason,
}

/// The unit of a line, and what its names' units must satisfy.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Homogeneity<'a> {
    /// Unit of the line; `None` where it is a number only.
    pub unit: Option<Powers<'a>>,
    /// Relations between the units inside the line.
    pub relations: Vec<Relation<'a>>,
}

impl Default for Powers<'_> {
    fn default() -> Self {
        Powers { names: BTreeMap::new(), radian: 0.0, factor: 1.0, pi: false }
    }
}

impl<'a> Powers<'a> {
    fn times(mut self, other: &Powers<'a>, power: f64) -> Powers<'a> {
        for (name, theirs) in &other.names {
            *self.names.entry(name).or_default() += power * theirs;
        }
        self.names.retain(|_, power| *power != 0.0);
        self.radian += power * other.radian;
        if other.factor != 1.0 {
            self.factor *= other.factor.abs().powf(power);
        }
        self.pi |= other.pi;
        self
    }

    /// As the unit of a sum, where the factors of one term are no factors of the whole unless they convert an angle.
    fn of_sum(self) -> Self {
        if self.radian == 0.0 { Powers { factor: 1.0, pi: false, ..self } } else { self }
    }
}

impl Expression {
    /// The unit of the line in those of its names, and the relations between them.
    pub(crate) fn homogeneity(&self) -> Homogeneity<'_> {
        let mut relations = Vec::new();
        let mut is_number = false;
        let powers = self.fold_parts(|node, here| {
            // the whole line is the last
            is_number = here.number.is_some();
            rule(node, here.number, &mut relations)
        });
        Homogeneity { unit: (!is_number).then_some(powers), relations }
    }
}

fn rule<'a>(node: Node<'a, Part<Powers<'a>>>, number: Option<f64>, relations: &mut Vec<Relation<'a>>) -> Powers<'a> {
    let mut require = |powers: Powers<'a>, reason: Reason| {
        if !powers.names.is_empty() {
            relations.push(Relation { powers, reason });
        }
    };
    let radian = || Powers { radian: 1.0, ..Powers::default() };
    let mut powers = match node {
        Node::Number(_) => Powers::default(),
        Node::Pi => Powers { pi: true, ..Powers::default() },
        Node::Name(name) => Powers { names: BTreeMap::from([(name, 1.0)]), ..Powers::default() },
        Node::Negate(x) => x.value,
        Node::Call(function, x) => match function {
            Function::Abs => x.value,
            Function::Sqrt => Powers::default().times(&x.value, 0.5),
            Function::Sign | Function::Step => Powers::default(),
            Function::Sin | Function::Cos | Function::Tan => {
                require(x.value.times(&radian(), -1.0), Reason::Argument);
                Powers::default()
            }
            Function::Exp => {
                require(x.value, Reason::Argument);
                Powers::default()
            }
            Function::Asin | Function::Acos | Function::Atan => {
                require(x.value, Reason::Argument);
                radian()
            }
        },
        Node::Binary(node_operator @ (Operator::Add | Operator::Subtract), left, right) => {
            match (left.number, right.number) {
                (Some(_), Some(_)) => Powers::default(),
                (Some(_), None) | (None, Some(_)) => {
                    let one = left.number == Some(1.0)
                        || (right.number == Some(1.0) && matches!(node_operator, Operator::Add));
                    let kept = if left.number.is_some() { right.value } else { left.value };
                    if one {
                        require(kept.clone(), Reason::One);
                    }
                    kept.of_sum()
                }
                (None, None) => {
                    require(left.value.clone().times(&right.value, -1.0), Reason::Terms);
                    // a factor pi may convert an angle: the unit of the other term is certain
                    if left.value.pi { right.value.of_sum() } else { left.value.of_sum() }
                }
            }
        }
        Node::Binary(Operator::Atan2, y, x) => {
            require(y.value.times(&x.value, -1.0), Reason::Terms);
            radian()
        }
        Node::Binary(Operator::Multiply, left, right) => left.value.times(&right.value, 1.0),
        Node::Binary(Operator::Divide, left, right) => left.value.times(&right.value, -1.0),
        Node::Binary(Operator::Power, left, right) => match right.number {
            Some(power) => Powers::default().times(&left.value, power),
            None => {
                require(left.value, Reason::Argument);
                require(right.value, Reason::Argument);
                Powers::default()
            }
        },
    };
    if let Some(number) = number {
        powers.factor = number.abs();
    }
    powers
}
