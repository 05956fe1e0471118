//! Conformity of a value with its limits (JCGM 106:2012, ISO/IEC 17025 7.8.6).

use super::Fit;
use crate::campaign::{Decision, Kind, Limit, Limited};
use crate::uncertainty::Combined;
use crate::uncertainty::quantiles::student_t_cdf;
use crate::vocabulary::vocabulary;

vocabulary! {
    /// What a decision rule says.
    Conformity {
        /// The limits are kept.
        Pass = "pass",
        /// The value's uncertainty leaves it open.
        Undecided = "undecided",
        /// The limits are not kept.
        Fail = "fail",
    }
}

/// A limited quantity as a fit found it.
#[derive(Debug, Clone)]
pub struct Judged {
    /// Its name.
    pub id: String,
    /// Its unit; of an angle that of its numbers is the radian.
    pub unit: String,
    /// Is it an angle?
    pub is_angle: bool,
    /// Its limits.
    pub limit: Limit,
    /// Estimate; `None` where the readings do not give it.
    pub value: Option<f64>,
    /// Combined uncertainty.
    pub uncertainty: Option<Combined>,
    /// What the decision rule says.
    pub outcome: Conformity,
    /// Probability of conformity; `None` where no uncertainty is known.
    pub probability: Option<f64>,
}

impl Fit {
    /// Every limited quantity of the campaign, judged.
    pub(crate) fn judged(&self) -> Vec<Judged> {
        let campaign = &self.campaign;
        let mut limited = campaign.limited_errors().into_iter();
        let errors = if limited.len() == 0 { Vec::new() } else { self.scale_factor_errors() };
        let one = |limit: &Limit| {
            let (id, unit, is_angle, value, uncertainty) = match limit.of {
                Limited::Parameter(k) => {
                    let own = self.parameters.get(k)?;
                    (own.id.clone(), own.unit.clone(), own.kind == Kind::Tilt, own.value, own.uncertainty)
                }
                Limited::Derived(k) => {
                    let (own, unit) = (self.derived.get(k)?, campaign.derived.get(k)?.unit.clone());
                    (own.id.clone(), unit, own.is_angle, own.value, own.uncertainty)
                }
                Limited::ScaleFactor(_) => {
                    let id = limited.next()?;
                    let own = errors.iter().find(|own| own.id == id);
                    (id, "ppm".into(), false, own.map(|own| own.value), own.and_then(|own| own.uncertainty))
                }
            };
            let level = self.settings.level;
            let (outcome, probability) = judge(campaign.decision, limit, value, uncertainty.as_ref(), level);
            Some(Judged { id, unit, is_angle, limit: *limit, value, uncertainty, outcome, probability })
        };
        campaign.limits.iter().filter_map(one).collect()
    }
}

/// Judge a value by its limits: the decision, and the probability of conformity; `None` where no uncertainty is known.
///
/// ```
/// use tumble::campaign::{Decision, Limit, Limited};
/// use tumble::fit::{Conformity, judge};
/// let limit = Limit { of: Limited::Parameter(0), lower: -1.0, upper: 1.0 };
/// assert_eq!(judge(Decision::Simple, &limit, Some(0.9), None, 0.95), (Conformity::Pass, None));
/// assert_eq!(judge(Decision::GuardU, &limit, Some(0.9), None, 0.95), (Conformity::Undecided, None));
/// ```
pub fn judge(
    decision: Decision,
    limit: &Limit,
    value: Option<f64>,
    uncertainty: Option<&Combined>,
    level: f64,
) -> (Conformity, Option<f64>) {
    let probability = value.zip(uncertainty).and_then(|(v, c)| probability(v, c, limit.lower, limit.upper));
    let Some(value) = value else { return (Conformity::Undecided, None) };
    let inside = |by: f64| limit.lower + by <= value && value <= limit.upper - by;
    let (is_kept, is_broken) = match (decision, uncertainty, probability) {
        (Decision::Simple, ..) => (inside(0.0), true),
        (Decision::GuardU, Some(combined), _) => (inside(combined.expanded), !inside(-combined.expanded)),
        (Decision::Risk, _, Some(p)) => (p >= level, p <= 1.0 - level),
        _ => (false, false),
    };
    let outcome = match (is_kept, is_broken) {
        (true, _) => Conformity::Pass,
        (false, true) => Conformity::Fail,
        (false, false) => Conformity::Undecided,
    };
    (outcome, probability)
}

/// `P(lower <= Y <= upper)` for `Y = value + u t`, t with the effective degrees of freedom (JCGM 106, 7.3).
fn probability(value: f64, combined: &Combined, lower: f64, upper: f64) -> Option<f64> {
    if !(combined.u > 0.0) {
        return Some(f64::from(u8::from(lower <= value && value <= upper)));
    }
    let below = |bound: f64| match bound {
        f64::INFINITY => Some(1.0),
        f64::NEG_INFINITY => Some(0.0),
        bound => student_t_cdf((bound - value) / combined.u, combined.dof),
    };
    Some((below(upper)? - below(lower)?).clamp(0.0, 1.0))
}
