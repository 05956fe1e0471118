//! Where a printed table disagrees with what its own readings and formulas give.

use super::{GroupComparison, Printed, shown_in};
use crate::algebra::{Expression, Scratch, Tape};
use crate::campaign::Campaign;
use crate::fit::Fit;
use crate::language::{Sentence, sentence};

/// A disagreement between print and computation.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "MisprintReport")]
pub struct Misprint {
    /// What is misprinted.
    pub what: Sentence,
    /// As printed (arcsec for angles).
    pub printed: Option<f64>,
    /// As computed, in the unit of `printed`.
    pub computed: Option<f64>,
    /// What seems to have happened.
    pub explanation: Sentence,
}

/// Compare a printed table with the closed forms, its means with the means, and its printed row with the exact derivatives.
pub(super) fn find(
    campaign: &Campaign,
    fit: &Fit,
    printed: &Printed,
    quantities: &[String],
    groups: &[GroupComparison],
    mean: &[Option<f64>],
) -> Vec<Misprint> {
    // half a unit of the last digit, and the rounding of the comparison itself
    let half = printed.last_digit * (0.5 + 1e-6);
    let mut misprints = Vec::new();
    for group in groups {
        for ((id, computed), print) in quantities.iter().zip(&group.closed_form).zip(&group.printed) {
            if let (Some(computed), Some(print)) = (computed, print)
                && (computed - print).abs() > half
            {
                let what = match group.group {
                    Some(value) => sentence!("quantity-at", id, value),
                    None => Sentence::text(id.clone()),
                };
                let explanation = sentence!("the-tables-own-readings-give-another-value");
                let [printed, computed] = [print, computed].map(|value| Some(value * shown_in(fit, id).0));
                misprints.push(Misprint { what, printed, computed, explanation });
            }
        }
    }
    for (k, id) in quantities.iter().enumerate() {
        let (Some(computed), Some((_, print))) =
            (mean.get(k).copied().flatten(), printed.means.iter().find(|(of, _)| of == id))
        else {
            continue;
        };
        // a mean may have been formed from the rounded entries, and may be printed with fewer digits
        let entries: Vec<f64> = groups.iter().filter_map(|g| g.printed.get(k).copied().flatten()).collect();
        let of_entries = entries.iter().sum::<f64>() / entries.len().max(1) as f64;
        let slack = if whole(*print, printed.last_digit) { half * 10.0 } else { half };
        let agrees = |value: f64| (value - print).abs() <= slack;
        if agrees(computed) || agrees(of_entries) {
            continue;
        }
        let same_as = groups.iter().find(|g| g.printed.get(k).copied().flatten() == Some(*print));
        let explanation = if agrees(-computed) || agrees(-of_entries) {
            sentence!("printed-with-the-opposite-sign", off = false)
        } else if [computed, of_entries].iter().any(|value| (value + print).abs() <= 2.0 * slack) {
            sentence!("printed-with-the-opposite-sign", off = true)
        } else if let Some(value) = same_as.and_then(|g| g.group) {
            sentence!("this-is-the-value-of-group-not", value)
        } else {
            sentence!("not-the-mean-of-the-table")
        };
        let [printed, computed] = [*print, computed].map(|value| Some(value * shown_in(fit, id).0));
        let what = sentence!("mean-of", id);
        misprints.push(Misprint { what, printed, computed, explanation });
    }
    misprints.extend(printed.row.iter().filter_map(|(id, line)| row_misprint(campaign, fit, id, line)));
    misprints
}

/// Is a printed value a whole number of ten last digits (printed without its decimal)?
fn whole(value: f64, last_digit: f64) -> bool {
    let tens = value / (10.0 * last_digit);
    (tens - tens.round()).abs() < 1e-6
}

/// A printed coefficient of the row against the exact derivative at the first reading.
fn row_misprint(campaign: &Campaign, fit: &Fit, id: &str, line: &str) -> Option<Misprint> {
    let Some(column) = campaign.parameter_index(id) else {
        return Some(Misprint {
            what: sentence!("in-the-printed-equation", id),
            printed: None,
            computed: None,
            explanation: sentence!("the-printed-equation-has-the-printed-chain", id),
        });
    };
    let ids: Vec<&str> = campaign.parameters.iter().map(|p| p.id.as_str()).collect();
    let print = Tape::compile(&Expression::parse(line).ok()?, &ids).ok()?.value(&fit.point, &mut Scratch::default());
    let exact = if fit.design.rows.is_empty() { return None } else { fit.design.jacobian[(0, column)] };
    if (exact - print).abs() <= 1e-6 * print.abs() {
        return None;
    }
    let opposite = (exact + print).abs() <= 1e-6 * print.abs();
    Some(Misprint {
        what: sentence!("coefficient-of-in-the-printed-equation", id),
        printed: Some(print),
        computed: Some(exact),
        explanation: if opposite {
            sentence!("the-chain-of-rotations-gives-the-opposite")
        } else {
            sentence!("the-chain-of-rotations-gives-another-value")
        },
    })
}
