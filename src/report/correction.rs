//! The correction for a person: the first order as lines of algebra, where it holds, and what must be given.

use crate::correction::LineInput;
use crate::document::number::{at_most, significant};
use crate::fit::sum;
use crate::language::{Language, say};
use crate::wire::CorrectionFile;

/// Digits of the coefficients in printed lines; the JSON report holds all.
const DIGITS: i32 = 9;

/// The first-order correction, one line for each input: `w_x = 0.4998*(gx - 0.125) + 0.0021*(gy - 0.5)`.
pub(super) fn correction_lines(correction: &CorrectionFile) -> Vec<String> {
    let solved = correction.inputs.iter().filter(|input| input.solved);
    solved
        .zip(&correction.matrix)
        .map(|(input, row)| {
            let largest = row.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
            // cross terms below the last digit of the largest do not show
            let shown = row
                .iter()
                .zip(&correction.sensors)
                .zip(&correction.bias)
                .filter(|((c, _), _)| c.abs() > 1e-12 * largest);
            let terms = shown.map(|((c, sensor), bias)| {
                (*c < 0.0, format!("{}*{}", number(c.abs()), difference(&sensor.sensor, *bias)))
            });
            format!("{} = {}", input.name, sum(terms)).trim_end().to_string()
        })
        .collect()
}

fn difference(sensor: &str, bias: f64) -> String {
    if bias == 0.0 {
        return sensor.to_string();
    }
    let sign = if bias < 0.0 { '+' } else { '-' };
    format!("({sensor} {sign} {})", number(bias.abs()))
}

fn number(value: f64) -> String {
    at_most(value, DIGITS)
}

/// Where the first order holds, in one sentence for each kind of answer.
pub(super) fn validity_sentence(correction: &CorrectionFile, lang: Language) -> String {
    let validity = &correction.validity;
    let solved: Vec<&LineInput> = correction.inputs.iter().filter(|input| input.solved).collect();
    let within: Vec<String> = solved
        .iter()
        .zip(&validity.range)
        .map(|(input, range)| format!("|{}| <= {} {}", input.name, significant(*range, 4), input.unit))
        .collect();
    let size = |(input, error): (&&LineInput, &f64)| {
        say!(lang, "correction-error-in", error = significant(*error, 2), unit = input.unit, id = input.name)
    };
    let rounding = |(error, range): (&f64, &f64)| *error <= 1e-12 * range;
    if validity.linear_error.iter().zip(&validity.range).all(rounding) {
        return say!(lang, "the-lines-are-linear-in-the-inputs").into();
    }
    let errors: Vec<String> = solved.iter().zip(&validity.linear_error).map(size).collect();
    let mut text = say!(
        lang,
        "within-the-range-of-the-calibration-it",
        within = within.join(lang.comma()),
        errors = errors.join(lang.comma())
    );
    match (validity.linear_share, &validity.u) {
        (Some(share), Some(_)) if share >= 1.0 => {
            text.push_str(say!(lang, "below-the-standard-uncertainty-of-the-calibration"))
        }
        (Some(share), Some(_)) => text.push_str(&say!(
            lang,
            "within-of-that-range-it-stays-below",
            part = if share > 0.0 { format!("{} %", significant(100.0 * share, 2)) } else { say!(lang, "none").into() }
        )),
        _ => text = lang.sentence(&text),
    }
    text
}

/// The inputs that must be given with the readings, and the value that is used where one is not.
fn given(correction: &CorrectionFile) -> impl Iterator<Item = (&str, String)> {
    let given = correction.inputs.iter().filter(|input| !input.solved);
    given.map(|input| {
        let unit = if input.unit.is_empty() { String::new() } else { format!(" {}", input.unit) };
        (input.name.as_str(), format!("{}{unit}", significant(input.otherwise.unwrap_or_default(), 6)))
    })
}

/// Where bias and matrix are those of the linear form, as far as further inputs decide.
pub(super) fn given_at(correction: &CorrectionFile, lang: Language) -> Option<String> {
    let at: Vec<String> = given(correction).map(|(id, value)| format!("{id} = {value}")).collect();
    (!at.is_empty()).then(|| say!(lang, "correction-is-for", at = at.join(lang.comma())))
}

/// What must be given with the readings, and the value that is used if it is not.
pub(super) fn given_sentence(correction: &CorrectionFile, lang: Language) -> Option<String> {
    let given: Vec<String> =
        given(correction).map(|(id, otherwise)| say!(lang, "correction-otherwise", id, otherwise)).collect();
    (!given.is_empty()).then(|| say!(lang, "these-sensors-do-not-determine-give-it", given = given.join(lang.comma())))
}
