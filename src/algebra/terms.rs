//! A model line as a sum of products: the names of each term and their powers.

use super::expression::{Expression, Node, Part};
use super::function::{Function, Operator};
use crate::number;

/// One term of a sum: names and their powers; numbers, and functions of anything, are left out.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Term {
    /// Name and power, in order of first appearance.
    pub powers: Vec<(String, f64)>,
}

/// More terms than this are not listed.
const MOST: usize = 256;

impl Expression {
    /// The terms of the expanded sum; `None` where it is not one of products of names (a quotient by a sum, say).
    ///
    /// `abs` keeps its argument's term and `sqrt` halves it; other functions count as pure numbers.
    pub(crate) fn terms(&self) -> Option<Vec<Term>> {
        self.fold_parts(|node: Node<'_, Part<Option<Vec<Term>>>>, _| match node {
            Node::Number(_) | Node::Pi => Some(vec![Term::default()]),
            Node::Name(name) => Some(vec![Term { powers: vec![(name.to_string(), 1.0)] }]),
            Node::Negate(x) => x.value,
            Node::Call(Function::Abs, x) => x.value.filter(|terms| terms.len() == 1),
            Node::Call(Function::Sqrt, x) => x.value.and_then(|terms| power(&terms, 0.5)),
            Node::Call(..) => Some(vec![Term::default()]),
            Node::Binary(operator, Part { value: left, .. }, Part { value: right, number, .. }) => match operator {
                Operator::Add | Operator::Subtract => sum(left, right),
                Operator::Atan2 => Some(vec![Term::default()]),
                Operator::Multiply => product(left, right),
                Operator::Divide => product(left, right.and_then(|terms| power(&terms, -1.0))),
                Operator::Power => number.and_then(|exponent| left.and_then(|terms| power(&terms, exponent))),
            },
        })
    }
}

fn sum(left: Option<Vec<Term>>, right: Option<Vec<Term>>) -> Option<Vec<Term>> {
    let (mut left, right) = (left?, right?);
    left.extend(right);
    (left.len() <= MOST).then_some(left)
}

fn product(left: Option<Vec<Term>>, right: Option<Vec<Term>>) -> Option<Vec<Term>> {
    let (left, right) = (left?, right?);
    if left.len() * right.len() > MOST {
        return None;
    }
    let pairs = left.iter().flat_map(|a| right.iter().map(move |b| (a, b)));
    Some(pairs.map(|(a, b)| times(a, b)).collect())
}

fn times(a: &Term, b: &Term) -> Term {
    let mut powers = a.powers.clone();
    for (name, power) in &b.powers {
        match powers.iter_mut().find(|(other, _)| other == name) {
            Some((_, sum)) => *sum += power,
            None => powers.push((name.clone(), *power)),
        }
    }
    powers.retain(|(_, power)| *power != 0.0);
    Term { powers }
}

/// A single term to a power; a sum to a small whole power is expanded.
fn power(terms: &[Term], exponent: f64) -> Option<Vec<Term>> {
    if let [term] = terms {
        let powers = term.powers.iter().map(|(name, power)| (name.clone(), power * exponent)).collect();
        return Some(vec![Term { powers }]);
    }
    if exponent.fract() != 0.0 || !(1.0..=4.0).contains(&exponent) {
        return None;
    }
    (1..number::count(exponent)).try_fold(terms.to_vec(), |so_far, _| product(Some(so_far), Some(terms.to_vec())))
}
