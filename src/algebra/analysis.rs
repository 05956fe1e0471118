//! What kind of function a model line is in some of its names: affine, trigonometric, smooth, of what degree in angles, a sum of which products.

use super::expression::{Expression, Node, Part};
use super::function::{Function, Operator};
use crate::number;

/// What a name is while one joint turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NameDegree {
    /// Does not change with the angle: a coefficient, another joint, a column.
    Constant,
    /// A trigonometric polynomial of degree 1 in the angle: a component of rate or specific force.
    Harmonic,
    /// The angle of the turning joint itself.
    Angle,
}

/// Highest degree that is determined: no mean over a turn is taken with more nodes.
const HIGHEST: usize = 10_000;

/// How a node depends on a set of names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
enum Dependence {
    #[default]
    None,
    Affine,
    Other,
}

/// A node as a function of the turning angle t.
#[derive(Debug, Clone, Copy, Default)]
struct Harmonics {
    /// Degree as a trigonometric polynomial in t.
    degree: Option<usize>,
    /// k, where the node is k*t + constant.
    turns: Option<f64>,
}

impl Expression {
    /// Whether the expression is affine in these names jointly: each at most once in a product, none inside a function.
    pub(crate) fn linear_in(&self, names: &[&str]) -> bool {
        let dependence = self.fold_parts(|node: Node<'_, Part<Dependence>>, _| match node {
            Node::Number(_) | Node::Pi => Dependence::None,
            Node::Name(name) if names.contains(&name) => Dependence::Affine,
            Node::Name(_) => Dependence::None,
            Node::Negate(x) => x.value,
            Node::Call(_, x) if x.value == Dependence::None => Dependence::None,
            Node::Call(..) => Dependence::Other,
            Node::Binary(operator, left, Part { value: right, number: exponent, .. }) => match (operator, left.value) {
                (Operator::Add | Operator::Subtract, left) => left.max(right),
                (Operator::Multiply, left) if left == Dependence::None || right == Dependence::None => left.max(right),
                (Operator::Divide, left) if right == Dependence::None => left,
                (Operator::Power, _) if exponent == Some(0.0) => Dependence::None,
                (Operator::Power, left) if exponent == Some(1.0) => left,
                (Operator::Power | Operator::Atan2, left) if left.max(right) == Dependence::None => Dependence::None,
                _ => Dependence::Other,
            },
        });
        dependence < Dependence::Other
    }

    /// Degree as a trigonometric polynomial in one turning angle; `None` where it is not one.
    ///
    /// The mean over whole turns is then exact with more equally spaced nodes than the degree. A function of the angle is a
    /// polynomial's part only as `sin` or `cos` of a whole multiple of it plus a constant.
    pub(crate) fn trig_degree(&self, of: &dyn Fn(&str) -> NameDegree) -> Option<usize> {
        self.fold_parts(|node, _| harmonics(node, of)).degree
    }

    /// Whether the expression has every derivative, everywhere, in the names for which `depends` holds.
    ///
    /// `abs`, `sign`, `step`, `sqrt`, `tan`, `asin`, `acos`, division and powers other than whole ones break it.
    pub(crate) fn is_smooth_in(&self, depends: &dyn Fn(&str) -> bool) -> bool {
        self.fold_parts(|node, _| smoothness(node, depends)).is_some()
    }

    /// Degree of the result in units of angle, by homogeneity; `None` where it is not defined.
    ///
    /// `degree` gives the degree of each name: 1 for an angle, 0 for a pure number, `None` where unknown.
    pub(crate) fn angle_degree(&self, degree: &dyn Fn(&str) -> Option<f64>) -> Option<f64> {
        self.fold_parts(|node, _| angle_degree(node, degree))
    }
}

fn harmonics(node: Node<'_, Part<Harmonics>>, of: &dyn Fn(&str) -> NameDegree) -> Harmonics {
    let (degree, turns) = match node {
        Node::Number(_) | Node::Pi => (Some(0), Some(0.0)),
        Node::Name(name) => match of(name) {
            NameDegree::Constant => (Some(0), Some(0.0)),
            NameDegree::Harmonic => (Some(1), None),
            NameDegree::Angle => (None, Some(1.0)),
        },
        Node::Negate(x) => (x.value.degree, x.value.turns.map(|k| -k)),
        Node::Call(_, x) if x.value.degree == Some(0) => (Some(0), Some(0.0)),
        Node::Call(Function::Sin | Function::Cos, x) => (x.value.turns.and_then(whole), None),
        Node::Call(..) => (None, None),
        Node::Binary(operator, left, right) => binary_harmonics(operator, left, right),
    };
    // What does not turn is a constant, and a constant does not turn.
    match (degree, turns) {
        (Some(0), _) | (_, Some(0.0)) => Harmonics { degree: Some(0), turns: Some(0.0) },
        _ => Harmonics { degree: degree.filter(|degree| *degree <= HIGHEST), turns },
    }
}

fn binary_harmonics(operator: Operator, left: Part<Harmonics>, right: Part<Harmonics>) -> (Option<usize>, Option<f64>) {
    let (left_number, left, right_number, right) = (left.number, left.value, right.number, right.value);
    let both = |f: fn(usize, usize) -> usize| Some(f(left.degree?, right.degree?));
    let turning = |f: fn(f64, f64) -> f64| Some(f(left.turns?, right.turns?));
    match operator {
        Operator::Add => (both(usize::max), turning(|a, b| a + b)),
        Operator::Subtract => (both(usize::max), turning(|a, b| a - b)),
        Operator::Multiply => {
            let scaled = |x: Harmonics, by: Option<f64>| Some(x.turns? * by?);
            (both(usize::saturating_add), scaled(left, right_number).or_else(|| scaled(right, left_number)))
        }
        Operator::Divide if right.degree == Some(0) => (left.degree, left.turns.zip(right_number).map(|(k, c)| k / c)),
        Operator::Power => match right_number {
            _ if left.degree == Some(0) && right.degree == Some(0) => (Some(0), Some(0.0)),
            Some(1.0) => (left.degree, left.turns),
            Some(exponent) => {
                (left.degree.zip(whole(exponent)).filter(|_| exponent >= 0.0).map(|(d, k)| d.saturating_mul(k)), None)
            }
            None => (None, None),
        },
        Operator::Atan2 if left.degree == Some(0) && right.degree == Some(0) => (Some(0), Some(0.0)),
        Operator::Divide | Operator::Atan2 => (None, None),
    }
}

/// The size of a number that is whole, and not too large.
fn whole(number: f64) -> Option<usize> {
    (number == number.trunc() && number.abs() <= HIGHEST as f64).then_some(number::count(number.abs()))
}

/// Whether a smooth node depends on the names; `None` where it is not smooth in them.
fn smoothness(node: Node<'_, Part<Option<bool>>>, depends: &dyn Fn(&str) -> bool) -> Option<bool> {
    match node {
        Node::Number(_) | Node::Pi => Some(false),
        Node::Name(name) => Some(depends(name)),
        Node::Negate(x) => x.value,
        Node::Call(Function::Sin | Function::Cos | Function::Atan | Function::Exp, x) => x.value,
        Node::Call(_, x) => x.value.filter(|depends| !depends),
        Node::Binary(operator, base, exponent) => {
            let (left, right) = (base.value?, exponent.value?);
            let (base, exponent) = (base.number, exponent.number);
            let smooth = match operator {
                Operator::Add | Operator::Subtract | Operator::Multiply => true,
                Operator::Divide => !right,
                Operator::Atan2 => !left && !right,
                Operator::Power if right => !left && base.is_some_and(|base| base > 0.0),
                Operator::Power => !left || exponent.is_some_and(|exponent| exponent >= 0.0 && exponent.fract() == 0.0),
            };
            smooth.then_some(left || right)
        }
    }
}

fn angle_degree(node: Node<'_, Part<Option<f64>>>, degree: &dyn Fn(&str) -> Option<f64>) -> Option<f64> {
    match node {
        Node::Number(_) | Node::Pi => Some(0.0),
        Node::Name(name) => degree(name),
        Node::Negate(x) => x.value,
        Node::Call(function, x) => {
            let x = x.value?;
            match function {
                Function::Sqrt => Some(x / 2.0),
                Function::Abs => Some(x),
                Function::Sign | Function::Step => Some(0.0),
                Function::Asin | Function::Acos | Function::Atan => (x == 0.0).then_some(1.0),
                Function::Sin | Function::Cos | Function::Tan => (x == 0.0 || x == 1.0).then_some(0.0),
                Function::Exp => (x == 0.0).then_some(0.0),
            }
        }
        Node::Binary(operator, left, Part { value: right, number: exponent, .. }) => {
            let (left, right) = (left.value?, right?);
            match operator {
                Operator::Add | Operator::Subtract => (left == right).then_some(left),
                Operator::Multiply => Some(left + right),
                Operator::Divide => Some(left - right),
                Operator::Atan2 => (left == right).then_some(1.0),
                Operator::Power => match exponent {
                    Some(exponent) => Some(left * exponent),
                    None => (left == 0.0 && right == 0.0).then_some(0.0),
                },
            }
        }
    }
}

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
