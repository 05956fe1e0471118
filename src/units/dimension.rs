//! Dimensions of units, their sizes, and the way from one to another.

use crate::number;
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

/// Powers of the base quantities: angle, time, length, mass, electric current, temperature, count; and of units that only a bench names.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Dimension {
    pub(super) base: [f64; BASES],
    /// Powers of units that only this bench names: each is a base quantity.
    pub(super) named: BTreeMap<String, f64>,
}

/// Powers closer than this are equal: they come from products of short decimal fractions.
pub(super) const SAME: f64 = 1e-9;

impl Dimension {
    /// The powers of a product: `self * other^power`.
    pub(super) fn times(&self, other: &Dimension, power: f64) -> Dimension {
        let mut product = self.clone();
        for (sum, theirs) in product.base.iter_mut().zip(other.base) {
            *sum += power * theirs;
        }
        for (name, theirs) in &other.named {
            *product.named.entry(name.clone()).or_default() += power * theirs;
        }
        product.named.retain(|_, power| power.abs() > SAME);
        product
    }

    /// Is it a pure number or a power of an angle?
    pub(crate) fn is_angle_or_number(&self) -> bool {
        self.named.is_empty() && self.base.iter().enumerate().all(|(k, power)| k == ANGLE || power.abs() <= SAME)
    }

    /// Is it a pure number?
    pub(crate) fn is_number(&self) -> bool {
        self.named.is_empty() && self.base.iter().all(|power| power.abs() <= SAME)
    }

    /// Is it a plane angle?
    pub fn is_angle(&self) -> bool {
        self.is_angle_or_number() && self.base.first().is_some_and(|power| (power - 1.0).abs() <= SAME)
    }

    /// Are all powers equal?
    pub(super) fn is(&self, other: &Dimension) -> bool {
        let same = |a: f64, b: f64| (a - b).abs() <= SAME;
        self.base.iter().zip(other.base).all(|(a, b)| same(*a, b))
            && self.named.len() == other.named.len()
            && self.named.iter().zip(&other.named).all(|(a, b)| a.0 == b.0 && same(*a.1, *b.1))
    }
}

/// Standard gravity, in metres per second squared for each g (CGPM 1901).
pub const STANDARD_GRAVITY_M_S2: f64 = 9.80665;

/// `10^ten * 60^sixty * (pi/180)^degree * 9.80665^gravity * other` of the SI unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    pub ten: f64,
    pub sixty: f64,
    pub degree: f64,
    pub gravity: f64,
    pub other: f64,
}

pub(super) const ONE: Scale = Scale { ten: 0.0, sixty: 0.0, degree: 0.0, gravity: 0.0, other: 1.0 };

impl Scale {
    /// The scale of `self * other^power`.
    pub(super) fn times(self, by: Scale, power: f64) -> Scale {
        Scale {
            ten: self.ten + power * by.ten,
            sixty: self.sixty + power * by.sixty,
            degree: self.degree + power * by.degree,
            gravity: self.gravity + power * by.gravity,
            other: self.other * if by.other == 1.0 { 1.0 } else { by.other.powf(power) },
        }
    }

    /// One of this unit in the other's.
    pub(super) fn over(self, unit: Scale) -> Conversion {
        let ratio = self.times(unit, -1.0);
        let mut conversion = Conversion::NONE;
        conversion.multiply(ratio.other, 1.0);
        conversion.multiply(std::f64::consts::PI / 180.0, ratio.degree);
        conversion.multiply(STANDARD_GRAVITY_M_S2, ratio.gravity);
        conversion.multiply(60.0, ratio.sixty);
        conversion.multiply(10.0, ratio.ten);
        conversion
    }
}

/// From one unit to another: `value * numerator / denominator + offset`, each exact where the factors are whole. Only temperatures have an offset.
///
/// ```
/// use tumble::units::Unit;
/// let to = Unit::parse("mV/g")?.conversion(&Unit::parse("V/g")?).unwrap();
/// assert_eq!(to.apply(1299.0), 1.299);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conversion {
    pub(super) numerator: f64,
    pub(super) denominator: f64,
    pub(super) offset: f64,
}

impl Conversion {
    /// The conversion that changes nothing.
    pub(crate) const NONE: Conversion = Conversion { numerator: 1.0, denominator: 1.0, offset: 0.0 };

    /// The same between scales whose zeros differ.
    pub(super) fn shifted(self, offset: f64) -> Conversion {
        Conversion { offset, ..self }
    }

    /// The conversion of a difference of two values, such as a standard uncertainty.
    pub(crate) fn of_differences(self) -> Conversion {
        Conversion { offset: 0.0, ..self }
    }

    pub(super) fn multiply(&mut self, factor: f64, power: f64) {
        let raised = |power: f64| match power.round() {
            whole if (power - whole).abs() < 1e-9 && whole.abs() < 300.0 => factor.powi(number::whole(whole)),
            _ => factor.powf(power),
        };
        if power > 0.0 {
            self.numerator *= raised(power);
        } else if power < 0.0 {
            self.denominator *= raised(-power);
        }
    }

    /// A value in the other unit.
    pub fn apply(self, value: f64) -> f64 {
        value * self.numerator / self.denominator + self.offset
    }

    /// The factor, of differences.
    pub fn factor(self) -> f64 {
        self.numerator / self.denominator
    }

    /// Are both units of one size, but for rounding?
    pub fn is_none(self) -> bool {
        (self.factor() - 1.0).abs() < 1e-12 && self.offset == 0.0
    }
}
