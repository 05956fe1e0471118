//! What a fit report says of the Monte Carlo beside the first order.

use crate::document::number::{percent, significant};
use crate::fit::{Drawn, Fit, Joint};
use crate::language::{Sentence, sentence};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Monte Carlo compared with the first order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct MonteCarloReport {
    /// Trials that gave finite values.
    pub trials: usize,
    /// Trials asked for.
    pub asked: usize,
    /// Seed.
    pub seed: u64,
    /// Each output.
    pub outputs: Vec<DrawnReport>,
    /// Several outputs together (GUM Supplement 2): the derived quantities, or the parameters where fewer than two are derived.
    pub joint: Option<Joint>,
    /// In words.
    pub verdict: Vec<Sentence>,
}

/// One output of the Monte Carlo.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct DrawnReport {
    /// Name of the parameter or derived quantity.
    pub id: String,
    /// Mean of the trials, in the quantity's unit.
    pub mean: f64,
    /// Standard deviation of the trials, in the quantity's unit.
    pub u: f64,
    /// Probabilistically symmetric coverage interval, in the quantity's unit.
    pub interval: [f64; 2],
    /// Shortest coverage interval, in the quantity's unit.
    pub shortest: [f64; 2],
    /// First-order interval, in the quantity's unit.
    pub first_order: Option<[f64; 2]>,
    /// Is the first order good to two digits of the uncertainty?
    pub first_order_agrees: Option<bool>,
}

/// Monte Carlo results of a fit for the report.
pub fn monte_carlo_report(drawn: &Drawn, fit: &Fit) -> MonteCarloReport {
    let pair = |(a, b): (f64, f64)| [a, b];
    let mut verdict = Vec::new();
    let outputs = drawn
        .names
        .iter()
        .zip(&drawn.trials.outputs)
        .zip(drawn.first_order.iter().zip(&drawn.agrees))
        .map(|((id, law), (first, agrees))| {
            if let (Some(false), Some((low, high))) = (agrees, first) {
                let off = (low - law.symmetric.0).abs().max((high - law.symmetric.1).abs());
                verdict.push(sentence!(
                    "the-first-order-does-not-describe-its",
                    id,
                    level = percent(fit.settings.level),
                    sd = significant(off / law.sd, 2)
                ));
            }
            DrawnReport {
                id: id.clone(),
                mean: law.mean,
                u: law.sd,
                interval: pair(law.symmetric),
                shortest: pair(law.shortest),
                first_order: first.map(pair),
                first_order_agrees: *agrees,
            }
        })
        .collect();
    let errors: Vec<String> = fit.scale_factor_errors().into_iter().map(|error| error.id).collect();
    if !errors.is_empty() {
        verdict.push(sentence!("scale-factor-errors-are-not-drawn", errors = errors.join(", ")));
    }
    MonteCarloReport {
        trials: drawn.trials.trials,
        asked: drawn.trials.asked,
        seed: drawn.trials.seed,
        outputs,
        joint: drawn.joint.clone(),
        verdict,
    }
}
