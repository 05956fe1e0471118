//! From text to a unit.

use super::unit::Unit;
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};

/// Bytes in the longest unit that is read, and parentheses inside each other at most.
const LONGEST: usize = 200;
const DEEPEST: usize = 20;

impl Unit {
    /// Read a unit: names of the table, `1`, `*`, `/` (from the left), `^`, `sqrt( )` and parentheses.
    ///
    /// Errors: `UnknownName` or `Syntax` with the span in bytes of `text`.
    ///
    /// ```
    /// use tumble::units::Unit;
    /// assert!(Unit::parse("deg/h/g")?.conversion(&Unit::parse("arcsec/(s*g)")?).unwrap().is_none());
    /// assert_eq!(Unit::parse("V/furlong").unwrap_err().place().span, Some((2, 7)));
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    pub fn parse(text: &str) -> Result<Unit> {
        Unit::parse_with(text, &[])
    }

    /// The same, with further names, each a base unit.
    pub(crate) fn parse_with(text: &str, names: &[String]) -> Result<Unit> {
        unit(text, Some(names)).map(|(unit, _)| unit)
    }

    /// A unit with any names: those that the table does not have are returned with it, each a base unit.
    pub fn parse_any(text: &str) -> Result<(Unit, Vec<String>)> {
        unit(text, None)
    }
}

/// Read a unit, with the names in it that the table does not have: base units are those that are listed, and where there is no list any.
fn unit(text: &str, unlisted: Option<&[String]>) -> Result<(Unit, Vec<String>)> {
    if text.len() > LONGEST {
        return Err(Malformed::new(Fault::Syntax, "the unit is too long")
            .expected(format!("at most {LONGEST} bytes"))
            .found(format!("{} bytes", text.len()))
            .at_span(0, 1));
    }
    let mut reader = Reader { text, at: 0, unlisted, named: Vec::new(), depth: 0 };
    let unit = reader.product()?;
    match reader.peek() {
        None => Ok((unit.written(text.trim()), reader.named)),
        Some(_) => Err(reader.refused("'*', '/', '^' or the end of the unit")),
    }
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
    unlisted: Option<&'a [String]>,
    named: Vec<String>,
    depth: usize,
}

impl Reader<'_> {
    fn tail(&self) -> &str {
        self.text.part(self.at..)
    }

    fn peek(&mut self) -> Option<char> {
        let blank = self.tail().len() - self.tail().trim_start().len();
        self.at += blank;
        self.tail().chars().next()
    }

    fn take(&mut self, wanted: &[char]) -> Option<char> {
        let c = self.peek().filter(|c| wanted.contains(c))?;
        self.at += c.len_utf8();
        Some(c)
    }

    fn refused(&self, expected: &str) -> Malformed {
        let length = self.tail().chars().next().map_or(1, char::len_utf8);
        let token = match self.tail().chars().next() {
            Some(c) => format!("'{}'", c.escape_debug()),
            None => "the end of the unit".into(),
        };
        Malformed::new(Fault::Syntax, "the unit does not parse")
            .expected(expected)
            .found(token)
            .at_span(self.at, length)
    }

    fn product(&mut self) -> Result<Unit> {
        let mut unit = self.power()?;
        loop {
            let sign = self.take(&['*', '/', '.', '\u{b7}', '\u{22c5}']);
            // the full stop of an abbreviation
            if sign == Some('.') && self.peek().is_none() {
                return Ok(unit);
            }
            // a blank is a product as well: `rad s^-1`
            let blank = self.text.part(..self.at).ends_with(' ') && self.peek().is_some_and(is_letter);
            if sign.is_none() && !blank {
                return Ok(unit);
            }
            let per = sign.is_none() && self.tail().starts_with("per ");
            self.at += if per { "per ".len() } else { 0 };
            let factor = self.power()?;
            // degrees of a scale of temperature: `deg C`
            if unit.is_degree() && factor.is_degree_of_temperature() && !per && sign != Some('/') && sign != Some('*') {
                unit = factor;
                continue;
            }
            unit = unit.times(&factor, if per || sign == Some('/') { -1.0 } else { 1.0 });
        }
    }

    fn power(&mut self) -> Result<Unit> {
        let base = self.base()?;
        if let Some(power) = self.superscript() {
            return Ok(Unit::one().times(&base, power));
        }
        // `s-2`, as the conventions of meteorology write it
        let mut behind = self.tail().chars();
        let is_signed = matches!(behind.next(), Some('-' | '+')) && behind.next().is_some_and(|c| c.is_ascii_digit());
        if !is_signed && self.take(&['^']).is_none() {
            return Ok(base);
        }
        let power = self.exponent()?;
        Ok(Unit::one().times(&base, power))
    }

    fn superscript(&mut self) -> Option<f64> {
        const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
        let raised: String = self.tail().chars().take_while(|c| *c == '⁻' || DIGITS.contains(c)).collect();
        let plain = raised.chars().filter_map(|c| match DIGITS.iter().position(|digit| *digit == c) {
            Some(digit) => char::from_digit(u32::try_from(digit).ok()?, 10),
            None => Some('-'),
        });
        let power = plain.collect::<String>().parse().ok().filter(|power: &f64| power.abs() <= 20.0)?;
        self.at += raised.len();
        Some(power)
    }

    fn exponent(&mut self) -> Result<f64> {
        if self.take(&['(']).is_some() {
            let mut power = self.number()?;
            if self.take(&['/']).is_some() {
                power /= self.number()?;
            }
            return match self.take(&[')']) {
                Some(_) if power.is_finite() && power.abs() <= 20.0 => Ok(power),
                Some(_) => Err(self.refused("an exponent between -20 and 20")),
                None => Err(self.refused("')'")),
            };
        }
        self.number()
    }

    fn number(&mut self) -> Result<f64> {
        self.peek();
        let tail = self.tail();
        let signed = tail.strip_prefix(['-', '+']).unwrap_or(tail);
        let digits = signed.len() - signed.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.').len();
        let length = tail.len() - signed.len() + digits;
        match tail.part(..length).parse::<f64>() {
            Ok(power) if power.abs() <= 20.0 => {
                self.at += length;
                Ok(power)
            }
            _ => Err(self.refused("an exponent between -20 and 20")),
        }
    }

    fn base(&mut self) -> Result<Unit> {
        const OPERAND: &str = "the name of a unit, 1 or '('";
        let start = self.at;
        match self.peek() {
            Some('(') => {
                self.at += 1;
                self.inside(start)
            }
            Some('1')
                if !self
                    .tail()
                    .get(1..)
                    .is_some_and(|tail| tail.starts_with(|c: char| c.is_ascii_digit() || c == '.')) =>
            {
                self.at += 1;
                Ok(Unit::one())
            }
            Some(c) if c.is_ascii_digit() => Err(self.refused("the name of a unit: a number belongs to the value")),
            Some(c) if is_letter(c) => {
                let letters = || self.tail().chars().take_while(|c| is_letter(*c) || c.is_ascii_digit()).collect();
                let name: String = super::table::slashed(self.tail()).map_or_else(letters, str::to_string);
                let start = self.at;
                self.at += name.len();
                if name == "sqrt" && self.take(&['(']).is_some() {
                    let inner = self.inside(start)?;
                    return Ok(Unit::one().times(&inner, 0.5));
                }
                self.named(&name, start)
            }
            _ => Err(self.refused(OPERAND)),
        }
    }

    fn inside(&mut self, start: usize) -> Result<Unit> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Malformed::new(Fault::Syntax, "the unit is nested too deeply")
                .expected(format!("at most {DEEPEST} parentheses inside each other"))
                .at_span(start, 1));
        }
        let unit = self.product()?;
        self.depth -= 1;
        match self.take(&[')']) {
            Some(_) => Ok(unit),
            None => Err(self.refused("'*', '/', '^' or ')'")),
        }
    }

    fn named(&mut self, name: &str, start: usize) -> Result<Unit> {
        let is_allowed = self.unlisted.is_none_or(|names| names.iter().any(|other| other == name));
        // digits at the end of a name are its power: `m/s2`; alone, `V1` is the name of a channel
        let bare = name.trim_end_matches(|c: char| c.is_ascii_digit());
        if start > 0
            && super::table::find(name).is_none()
            && let (Some(unit), Ok(power)) = (Unit::of_name(bare, false), name.part(bare.len()..).parse::<f64>())
            && power <= 20.0
        {
            return Ok(Unit::one().times(&unit, power));
        }
        let unit = Unit::of_name(name, is_allowed).ok_or_else(|| {
            Malformed::new(Fault::UnknownName, format!("no unit is called '{name}'"))
                .expected(super::names())
                .found(format!("'{name}'"))
                .at_span(start, name.len())
        })?;
        if super::table::find(name).is_none() && !self.named.iter().any(|other| other == name) {
            self.named.push(name.into());
        }
        Ok(unit)
    }
}

fn is_letter(c: char) -> bool {
    c.is_alphabetic()
        || matches!(c, '%' | '_' | '\u{b0}' | '\u{2da}' | '\u{2032}' | '\u{2033}' | '\u{b5}' | '\u{2103}' | '\u{2109}')
}
