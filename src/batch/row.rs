//! What is said of one device.

use crate::campaign::Limited;
use crate::error::Malformed;
use crate::fit::{Conformity, Fit};
use crate::uncertainty::Combined;
use crate::vocabulary::vocabulary;

vocabulary! {
    /// How a device was fitted.
    Solved {
        /// By the factorisation that all devices of its schedule share.
        Together = "common",
        /// By a fit of its own.
        Alone = "own",
        /// Not at all.
        Not = "none",
    }
}

vocabulary! {
    /// Is the answer usable?
    Verdict {
        /// Every unknown is determined, and the global test (where there is one) is passed.
        Accepted = "accepted",
        /// A rank defect, a failed global test, no convergence: what the fit of a single campaign ends with exit code 2 for.
        Rejected = "rejected",
        /// The device's readings are no readings of this campaign.
        Malformed = "malformed",
    }
}

/// One device's answer: estimated parameters first, then derived quantities, in the campaign's order.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The device.
    pub label: String,
    /// Its date or lot, where one was asked for.
    pub lot: String,
    /// Is the answer usable?
    pub verdict: Verdict,
    /// The worst outcome of its limits; `None` where the campaign has none.
    pub conformity: Option<Conformity>,
    /// What is wrong, or suspicious, in words; empty where nothing is.
    pub why: String,
    /// Values read.
    pub readings: usize,
    /// Independent unknowns.
    pub rank: usize,
    /// Degrees of freedom.
    pub dof: usize,
    /// Estimates, each in its internal unit (tilts in radians); NaN where there is none.
    pub value: Vec<f64>,
    /// Standard uncertainties; NaN where none is known.
    pub u: Vec<f64>,
    /// Expanded uncertainties; NaN where none is known.
    pub expanded: Vec<f64>,
    /// The part of each standard uncertainty that comes from the device's own readings (Type A); NaN where none is known.
    pub type_a: Vec<f64>,
    /// `sqrt(sum (v/u)^2 / dof)`: the residual standard deviation where no uncertainty is stated. NaN without degrees of freedom.
    pub residual_sd: f64,
    /// Probability of the global test; NaN where there is none.
    pub chi_square_p: f64,
    /// Probability of the test for lack of fit; NaN where nothing is replicated.
    pub lack_of_fit_p: f64,
    /// Smallest probability of the runs tests; NaN where there is none.
    pub runs_p: f64,
    /// Probability of the test of normality; NaN where there is none.
    pub normality_p: f64,
    /// Suspicious readings, counted from 1 among the device's rows, the most significant first.
    pub suspects: Vec<usize>,
    /// How it was fitted.
    pub solved: Solved,
}

impl Row {
    /// A row without an answer, for `quantities` parameters and derived quantities.
    pub(super) fn without(label: &str, quantities: usize, error: &Malformed) -> Self {
        let mut why = error.what().to_string();
        let path = &error.place().path;
        if !path.is_empty() {
            why += &format!(" ({path})");
        }
        if let Some(expected) = error.expectation() {
            why += &format!("; expected: {expected}");
        }
        if let Some(found) = error.finding() {
            why += &format!("; found: {found}");
        }
        Row {
            label: label.into(),
            lot: String::new(),
            verdict: Verdict::Malformed,
            conformity: None,
            why,
            readings: 0,
            rank: 0,
            dof: 0,
            value: vec![f64::NAN; quantities],
            u: vec![f64::NAN; quantities],
            expanded: vec![f64::NAN; quantities],
            type_a: vec![f64::NAN; quantities],
            residual_sd: f64::NAN,
            chi_square_p: f64::NAN,
            lack_of_fit_p: f64::NAN,
            runs_p: f64::NAN,
            normality_p: f64::NAN,
            suspects: Vec::new(),
            solved: Solved::Not,
        }
    }

    /// The row of an ordinary fit.
    pub fn of(label: &str, fit: &Fit) -> Self {
        let judged = fit.judged();
        let results = || {
            let parameters = fit.parameters.iter().map(|p| (p.value, p.uncertainty));
            let derived = fit.derived.iter().map(|d| (d.value, d.uncertainty));
            let errors = judged.iter().filter(|own| matches!(own.limit.of, Limited::ScaleFactor(_)));
            parameters.chain(derived).chain(errors.map(|own| (own.value, own.uncertainty)))
        };
        let of = |get: &dyn Fn(Option<f64>, Option<Combined>) -> Option<f64>| -> Vec<f64> {
            results().map(|(value, own)| get(value, own).unwrap_or(f64::NAN)).collect()
        };
        let limits: Vec<(&str, Conformity)> = judged.iter().map(|own| (own.id.as_str(), own.outcome)).collect();
        let suspects: Vec<usize> = fit
            .checks
            .snooping
            .iter()
            .flat_map(|found| &found.suspects)
            .filter_map(|suspect| fit.design.rows.get(suspect.row).map(|origin| origin.reading + 1))
            .collect();
        let mut why = Vec::new();
        if let Some(test) = fit.global_test.filter(|test| test.rejected) {
            why.push(chi_square_words(test.p));
        }
        if !fit.not_estimable.is_empty() {
            let names: Vec<&str> = fit.parameters.iter().filter(|p| p.value.is_none()).map(|p| p.id.as_str()).collect();
            why.push(format!("not estimable: {}", names.join(" ")));
        }
        if fit.convergence.as_ref().is_some_and(|c| !c.converged) || !fit.settled {
            why.push("no convergence".to_string());
        }
        if fit.is_rejected() && why.is_empty() {
            why.push("constraints against the readings".to_string());
        }
        let lack_of_fit_p = fit.checks.lack_of_fit.map_or(f64::NAN, |test| test.p);
        remarks(
            &mut why,
            &suspects,
            fit.checks.lack_of_fit.is_some_and(|t| t.rejected).then_some(lack_of_fit_p),
            &limits,
        );
        Row {
            label: label.into(),
            lot: String::new(),
            verdict: if fit.is_rejected() { Verdict::Rejected } else { Verdict::Accepted },
            conformity: limits.iter().map(|(_, own)| *own).max(),
            why: why.join("; "),
            readings: fit.design.rows.len(),
            rank: fit.estimate.unknowns.rank,
            dof: fit.estimate.dof,
            value: of(&|value, _| value),
            u: of(&|_, own| own.map(|c| c.u)),
            expanded: of(&|_, own| own.map(|c| c.expanded)),
            type_a: of(&|_, own| own.map(|c| c.type_a)),
            residual_sd: fit.residual_sd().unwrap_or(f64::NAN),
            chi_square_p: fit.global_test.map_or(f64::NAN, |test| test.p),
            lack_of_fit_p,
            runs_p: fit.checks.runs.iter().map(|(_, test)| test.p).fold(f64::NAN, f64::min),
            normality_p: fit.checks.normality.map_or(f64::NAN, |test| test.p),
            suspects,
            solved: Solved::Alone,
        }
    }
}

/// The global test in words.
pub(super) fn chi_square_words(p: f64) -> String {
    format!("global test p {p:.1e}")
}

/// What a person should look at.
pub(super) fn remarks(
    why: &mut Vec<String>,
    suspects: &[usize],
    lack_of_fit: Option<f64>,
    limits: &[(&str, Conformity)],
) {
    if let Some(p) = lack_of_fit {
        why.push(format!("lack of fit p {p:.1e}"));
    }
    match suspects {
        [] => {}
        [one] => why.push(format!("suspicious reading {one}")),
        several => {
            let list: Vec<String> = several.iter().take(5).map(ToString::to_string).collect();
            let more = if several.len() > 5 { " ..." } else { "" };
            why.push(format!("suspicious readings {}{more}", list.join(" ")));
        }
    }
    for outcome in [Conformity::Fail, Conformity::Undecided] {
        let names: Vec<&str> = limits.iter().filter(|(_, own)| *own == outcome).map(|(id, _)| *id).collect();
        if !names.is_empty() {
            why.push(format!(
                "{} {}",
                if outcome == Conformity::Fail { "outside limits:" } else { "undecided:" },
                names.join(" ")
            ));
        }
    }
}
