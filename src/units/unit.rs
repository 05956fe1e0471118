//! A unit: what a person writes, its dimension (powers of the base quantities), and its size factor by factor, so that what cancels cancels exactly.

use super::dimension::{ANGLE, COUNT, Conversion, Dimension, ONE, SAME, Scale, TEMPERATURE};
use super::table;
use crate::error::{Fault, Malformed, Result};

/// A unit of measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    symbol: String,
    dimension: Dimension,
    scale: Scale,
    /// The power of Hz in it: a number of pulses each second is shown in Hz too.
    hertz: f64,
    /// The names in it with their powers, in the order in which they are written.
    factors: Vec<(String, f64)>,
}

impl Unit {
    /// Does a text say a unit that converts to this one?
    pub(crate) fn is_said_by(&self, text: &str) -> bool {
        Unit::parse(text).is_ok_and(|unit| unit.conversion(self).is_some())
    }

    /// The pure number 1.
    pub(crate) fn one() -> Unit {
        Unit { symbol: "1".into(), dimension: Dimension::default(), scale: ONE, hertz: 0.0, factors: Vec::new() }
    }

    pub(super) fn of_name(name: &str, is_named: bool) -> Option<Unit> {
        let mut unit = Unit { symbol: name.into(), factors: vec![(name.into(), 1.0)], ..Unit::one() };
        if let Some(entry) = table::find(name) {
            (unit.dimension.base, unit.scale) = (entry.base, entry.scale);
            unit.hertz = if entry.hertz { 1.0 } else { 0.0 };
        } else if is_named {
            unit.dimension.named.insert(name.into(), 1.0);
        } else {
            return None;
        }
        Some(unit)
    }

    /// The same unit, written otherwise.
    pub(crate) fn written(self, symbol: impl Into<String>) -> Unit {
        Unit { symbol: symbol.into(), ..self }
    }

    /// `self * other^power`, without a symbol that a person would write.
    pub(crate) fn times(&self, other: &Unit, power: f64) -> Unit {
        let mut factors = self.factors.clone();
        for (name, exponent) in &other.factors {
            match factors.iter_mut().find(|(known, _)| known == name) {
                Some((_, sum)) => *sum += power * exponent,
                None => factors.push((name.clone(), power * exponent)),
            }
        }
        factors.retain(|(_, power)| power.abs() > SAME);
        Unit {
            factors,
            symbol: String::new(),
            dimension: self.dimension.times(&other.dimension, power),
            scale: self.scale.times(other.scale, power),
            hertz: self.hertz + power * other.hertz,
        }
    }

    /// The product of powers of units, written as people do: `V/(deg/s)^2`, `V/(g*degC)`, `deg/h/g`; `1` where all cancel.
    pub(crate) fn product(powers: &[(Unit, f64)]) -> Unit {
        let unit = powers.iter().fold(Unit::one(), |unit, (factor, power)| unit.times(factor, *power));
        let written =
            powers.iter().map(|(unit, power)| (unit.symbol.clone(), *power)).filter(|(symbol, _)| symbol != "1");
        unit.written(symbol_of(&written.collect::<Vec<_>>()))
    }

    /// The same where names above and below the line cancel: `pulse/s/g` over `pulse/s/(deg/h)` is `deg/(g*h)`.
    pub(crate) fn reduced(powers: &[(Unit, f64)]) -> Unit {
        let product = Unit::product(powers);
        let names = |unit: &Unit| -> f64 { unit.factors.iter().map(|(_, power)| power.abs()).sum() };
        let apart: f64 = powers.iter().map(|(unit, power)| names(unit) * power.abs()).sum();
        if names(&product) + SAME >= apart {
            return product;
        }
        let mut factors = product.factors.clone();
        factors.sort_by(|a, b| a.0.cmp(&b.0));
        let symbol = symbol_of(&factors);
        product.written(symbol)
    }

    /// Are dimension and size the same, however it is written?
    pub(crate) fn is_same(&self, other: &Unit) -> bool {
        self.dimension.is(&other.dimension)
            && (self.hertz - other.hertz).abs() <= SAME
            && self.scale.over(other.scale).is_none()
    }

    /// Is it the number 1, or a power of the radian?
    pub(crate) fn is_one(&self) -> bool {
        self.conversion(&Unit::one()).is_some_and(Conversion::is_none)
    }

    /// Is it the degree of an angle? Before a scale of temperature it is that of the scale.
    pub(super) fn is_degree(&self) -> bool {
        matches!(self.factors.as_slice(), [(name, power)] if *power == 1.0 && table::plain(name) == "deg")
            && self.dimension.base.get(ANGLE) == Some(&1.0)
    }

    /// Is it a scale of temperature, alone?
    pub(super) fn is_degree_of_temperature(&self) -> bool {
        self.zero().is_some()
    }

    /// Zero of a scale of temperature, K; `None` for other units.
    fn zero(&self) -> Option<f64> {
        match self.factors.as_slice() {
            [(name, power)] if *power == 1.0 && self.dimension.base.get(TEMPERATURE) == Some(&1.0) => {
                Some(table::zero(name))
            }
            _ => None,
        }
    }

    /// As a person writes it.
    pub fn symbol(&self) -> &str {
        &self.symbol
    }

    /// The names in it with their powers.
    #[cfg(feature = "dcc")]
    pub(crate) fn factors(&self) -> &[(String, f64)] {
        &self.factors
    }

    /// Its dimension.
    pub fn dimension(&self) -> &Dimension {
        &self.dimension
    }

    /// From this unit to another; `None` where they differ in dimension.
    ///
    /// Pulses or counts each second are Hz; pure numbers and (powers of) angles convert to each other, the radian being 1.
    ///
    /// ```
    /// use tumble::units::Unit;
    /// let of = |from: &str, to: &str| Ok(Unit::parse(from)?.conversion(&Unit::parse(to)?).map(|c| c.apply(1.0)));
    /// assert_eq!(of("V/(rad/s)", "V/g")?, None);
    /// assert_eq!(of("g", "m/s^2")?, Some(9.80665));
    /// assert_eq!(of("ppm", "urad")?, Some(1.0));
    /// assert_eq!(of("V*s", "V/(deg/s)")?, None);
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    pub fn conversion(&self, to: &Unit) -> Option<Conversion> {
        let counted = |unit: &Unit| {
            let mut dimension = unit.dimension.clone();
            dimension.base.get_mut(COUNT).into_iter().for_each(|power| *power += unit.hertz);
            dimension
        };
        let fits = self.dimension.is(&to.dimension)
            || counted(self).is(&counted(to))
            || (self.dimension.is_angle_or_number() && to.dimension.is_angle_or_number());
        fits.then(|| self.scale.over(to.scale))
    }

    /// The conversion to another unit. Errors: another dimension, with the unit that was expected.
    ///
    /// Between scales of temperature a value is shifted (by 273.15 from `degC` to `K`); `Conversion::of_differences` is without the shift.
    pub(crate) fn conversion_for(&self, to: &Unit, what: &str) -> Result<Conversion> {
        let shifted = |plain: Conversion| match (self.zero(), to.zero()) {
            (Some(from_zero), Some(zero)) => plain.shifted(from_zero * plain.factor() - zero),
            _ => plain,
        };
        self.conversion(to).map(shifted).ok_or_else(|| {
            let mut dimension = self.dimension.clone();
            let angle = to.dimension.base.get(ANGLE).copied().unwrap_or(0.0);
            dimension.base.get_mut(ANGLE).into_iter().for_each(|power| *power += angle);
            let lacks_angle = if angle != 0.0 && dimension.is(&to.dimension) {
                " (turns or radians must be stated: rev/min, rad/s)"
            } else {
                ""
            };
            Malformed::new(Fault::Value, format!("the unit of {what} has another dimension"))
                .expected(format!("{}, or a unit that converts to it{lacks_angle}", to.symbol))
                .found(format!("'{}'", self.symbol))
        })
    }
}

/// Names with powers, those above the line first.
fn symbol_of(factors: &[(String, f64)]) -> String {
    let part = |above: bool| -> Vec<String> {
        factors
            .iter()
            .filter(|(_, power)| (*power > SAME) == above && power.abs() > SAME)
            .map(|(symbol, power)| raised(symbol, power.abs()))
            .collect()
    };
    let (above, below) = (part(true), part(false));
    let above = match above.as_slice() {
        [] => "1".to_string(),
        [one] => one.clone(),
        many => many.iter().map(|one| bracketed(one, &['/'])).collect::<Vec<_>>().join("*"),
    };
    match below.as_slice() {
        [] => above,
        [one] => format!("{above}/{}", bracketed(one, &['/', '*'])),
        many => {
            format!("{above}/({})", many.iter().map(|one| bracketed(one, &['/'])).collect::<Vec<_>>().join("*"))
        }
    }
}

fn raised(symbol: &str, power: f64) -> String {
    if (power - 1.0).abs() <= SAME {
        return symbol.to_string();
    }
    let rounded = (power * 1e6).round() / 1e6;
    format!("{}^{rounded}", bracketed(symbol, &['/', '^', '*']))
}

fn bracketed(symbol: &str, signs: &[char]) -> String {
    let mut depth = 0_i32;
    let outside = symbol.chars().any(|c| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        depth == 0 && signs.contains(&c)
    });
    if outside { format!("({symbol})") } else { symbol.to_string() }
}
