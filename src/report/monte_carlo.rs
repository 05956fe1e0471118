//! What a fit report says of the Monte Carlo beside the first order.

use crate::document::number::{percent, significant};
use crate::fit::{Drawn, Fit};
use crate::language::{Sentence, sentence};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Monte Carlo compared with the first order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct MonteCarloReport {
    /// What was drawn.
    #[serde(flatten)]
    pub drawn: Drawn,
    /// In words.
    pub verdict: Vec<Sentence>,
}

/// Monte Carlo results of a fit for the report.
pub fn monte_carlo_report(drawn: Drawn, fit: &Fit) -> MonteCarloReport {
    let mut verdict = Vec::new();
    for output in drawn.outputs.iter().filter(|output| output.first_order_agrees == Some(false)) {
        let Some([low, high]) = output.first_order else { continue };
        let off = (low - output.interval[0]).abs().max((high - output.interval[1]).abs());
        verdict.push(sentence!(
            "the-first-order-does-not-describe-its",
            id = output.id,
            level = percent(fit.settings.level),
            sd = significant(off / output.u, 2)
        ));
    }
    if drawn.held {
        verdict.push(sentence!("bounds-held-trials-back"));
    }
    let errors: Vec<String> = fit.scale_factor_errors().into_iter().map(|error| error.id).collect();
    if !errors.is_empty() {
        verdict.push(sentence!("scale-factor-errors-are-not-drawn", errors = errors.join(", ")));
    }
    MonteCarloReport { drawn, verdict }
}
