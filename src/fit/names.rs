//! Combinations of parameters in the user's own words: "V0 - kI*dtheta_y0" rather than "V0 - 1.299*dtheta_y0".

use crate::campaign::{Campaign, Kind, Role};
use crate::estimate::Combination;
use crate::number;

/// A combination of estimated parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedCombination {
    /// Parameter and coefficient, in campaign order; the first coefficient is 1.
    pub terms: Vec<(String, f64)>,
    /// The combination as a person writes it, with known coefficients named where they are recognised.
    pub text: String,
}

/// Name a combination's parameters, and its coefficients where they equal a known parameter (to the digits that are printed).
pub fn describe(campaign: &Campaign, combination: &Combination) -> NamedCombination {
    let id = |k: usize| campaign.parameters.get(k).map_or(String::new(), |p| p.id.clone());
    let terms: Vec<(String, f64)> = combination.terms.iter().map(|(k, c)| (id(*k), *c)).collect();
    let text = sum(terms.iter().map(|(name, coefficient)| {
        let known = known_as(campaign, *coefficient);
        // a negative known coefficient named by itself takes the sign with it
        let negative = (*coefficient < 0.0) != known.is_some_and(|(_, negative)| negative);
        let factor = match known {
            Some((known, _)) => format!("{known}*"),
            None if (coefficient.abs() - 1.0).abs() < 1e-9 => String::new(),
            None => format!("{}*", six_digits(coefficient.abs())),
        };
        (negative, factor + name)
    }));
    NamedCombination { terms, text }
}

/// Terms as a sum, each with whether it is taken away: `a - 2*b`.
pub(crate) fn sum(terms: impl IntoIterator<Item = (bool, String)>) -> String {
    let mut text = String::new();
    for (negative, term) in terms {
        text.push_str(match (text.is_empty(), negative) {
            (true, true) => "-",
            (true, false) => "",
            (false, true) => " - ",
            (false, false) => " + ",
        });
        text.push_str(&term);
    }
    text
}

/// A coefficient is called by a known parameter's name where it differs from it by less than the six printed digits show: away from the
/// reference point the exact derivative is, for example, `kI` times the cosine of a tilt.
const SAME: f64 = 5e-6;

/// A known parameter whose size is the coefficient's, and whether its own value is negative.
fn known_as(campaign: &Campaign, coefficient: f64) -> Option<(&str, bool)> {
    campaign.parameters.iter().find_map(|parameter| match &parameter.role {
        Role::Known(known)
            if parameter.kind != Kind::Input
                && known.value.abs() != 1.0
                && known.value != 0.0
                && (known.value.abs() - coefficient.abs()).abs() <= SAME * known.value.abs() =>
        {
            Some((parameter.id.as_str(), known.value < 0.0))
        }
        _ => None,
    })
}

/// A positive number with six significant digits and no idle zeros.
fn six_digits(size: f64) -> String {
    let exponent = size.log10().floor();
    if !(-4.0..6.0).contains(&exponent) {
        return format!("{size:.5e}");
    }
    let digits = number::count((5.0 - exponent).max(0.0));
    let number = format!("{size:.digits$}");
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.').to_string() } else { number }
}
