//! Dimensions: powers of the base quantities.

use std::collections::BTreeMap;

/// Base quantities, in the order of [`Dimension`]'s powers.
pub(super) const ANGLE: usize = 0;
pub(super) const TIME: usize = 1;
pub(super) const LENGTH: usize = 2;
pub(super) const MASS: usize = 3;
pub(super) const CURRENT: usize = 4;
pub(super) const TEMPERATURE: usize = 5;
pub(super) const COUNT: usize = 6;
/// How many there are.
pub(super) const BASES: usize = 7;

/// Powers of the base quantities: angle, time, length, mass, electric current, temperature, count; and of what a bench names itself.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Dimension {
    pub(super) base: [f64; BASES],
    /// Units that only this bench knows are base quantities of their own.
    pub(super) own: BTreeMap<String, f64>,
}

/// Powers closer than this are equal: they come from products of short decimal fractions.
pub(super) const SAME: f64 = 1e-9;

impl Dimension {
    /// The powers of a product: `self * other^power`.
    pub(super) fn times(&self, other: &Dimension, power: f64) -> Dimension {
        let mut product = self.clone();
        for (own, theirs) in product.base.iter_mut().zip(other.base) {
            *own += power * theirs;
        }
        for (name, theirs) in &other.own {
            *product.own.entry(name.clone()).or_default() += power * theirs;
        }
        product.own.retain(|_, power| power.abs() > SAME);
        product
    }

    /// Is it a pure number or a power of an angle?
    pub fn is_angle_or_number(&self) -> bool {
        self.own.is_empty() && self.base.iter().enumerate().all(|(k, power)| k == ANGLE || power.abs() <= SAME)
    }

    /// Is it a pure number?
    pub fn is_number(&self) -> bool {
        self.own.is_empty() && self.base.iter().all(|power| power.abs() <= SAME)
    }

    /// Is it a plane angle?
    pub fn is_angle(&self) -> bool {
        self.is_angle_or_number() && self.base.first().is_some_and(|power| (power - 1.0).abs() <= SAME)
    }

    /// Are all powers equal?
    pub(super) fn is(&self, other: &Dimension) -> bool {
        let same = |a: f64, b: f64| (a - b).abs() <= SAME;
        self.base.iter().zip(other.base).all(|(a, b)| same(*a, b))
            && self.own.len() == other.own.len()
            && self.own.iter().zip(&other.own).all(|(a, b)| a.0 == b.0 && same(*a.1, *b.1))
    }
}
