//! What is said of one device.

use super::Device;
use crate::campaign::Limited;
use crate::error::Malformed;
use crate::fit::{Conformity, Fit};
use crate::quality::{self, Repeated};
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
        /// Every unknown is determined, the global test (where there is one) is passed, and nothing shows beyond doubt that the model does not fit.
        Accepted = "accepted",
        /// A rank defect, a stuck channel, a failed global test, lack of fit beyond doubt, no convergence.
        Rejected = "rejected",
        /// The device's readings are no readings of this campaign.
        Malformed = "malformed",
    }
}

vocabulary! {
    /// What is wrong with a device, or suspicious.
    Reason {
        /// Its readings are no readings of this campaign.
        Malformed = "malformed",
        /// Unknowns that its readings do not determine.
        NotEstimable = "not-estimable",
        /// A channel whose readings are all the same, whatever the inputs were.
        Stuck = "stuck-channel",
        /// The global test failed.
        GlobalTest = "global-test",
        /// The iterations did not settle.
        NoConvergence = "no-convergence",
        /// Constraints that contradict the readings or each other.
        Constraints = "constraints",
        /// The model leaves more than replicates, or the readings of a position, scatter.
        LackOfFit = "lack-of-fit",
        /// Readings that do not agree with the others.
        SuspiciousReadings = "suspicious-readings",
        /// Every row stands there several times.
        RepeatedRows = "repeated-rows",
        /// A quantity outside its limits.
        OutsideLimits = "outside-limits",
        /// A quantity whose uncertainty leaves its limits open.
        Undecided = "undecided",
    }
}

/// Suspicious readings that are told in words.
const SUSPECTS: usize = 5;

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
    /// The same by kind, each once.
    pub reasons: Vec<Reason>,
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
    /// Probability of the test for lack of fit, by replicates, else by positions; NaN where neither says anything.
    pub lack_of_fit_p: f64,
    /// Smallest probability of the runs tests; NaN where there is none.
    pub runs_p: f64,
    /// Probability of the test of normality; NaN where there is none.
    pub normality_p: f64,
    /// Suspicious readings, counted from 1 among the device's rows, the most significant first.
    pub suspects: Vec<usize>,
    /// Probability of the most significant of them among this device's readings if none were bad; NaN where there is none.
    pub suspect_p: f64,
    /// How it was fitted.
    pub solved: Solved,
}

impl Row {
    /// A row without an answer, for `quantities` parameters and derived quantities.
    pub(super) fn without(label: &str, quantities: usize, error: &Malformed) -> Self {
        let mut why = error.what().to_string();
        let place = error.place();
        let path = place.path_said();
        let line = (place.line > 0 && !place.file.is_empty()).then(|| format!("line {} of {}", place.line, place.file));
        let file = line.or((!place.file.is_empty()).then(|| place.file.clone()));
        let places: Vec<&str> =
            file.as_deref().into_iter().chain((!path.is_empty()).then_some(path.as_str())).collect();
        if !places.is_empty() {
            why += &format!(" ({})", places.join(", "));
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
            reasons: vec![Reason::Malformed],
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
            suspect_p: f64::NAN,
            solved: Solved::Not,
        }
    }

    /// The row of an ordinary fit of a device.
    pub fn of(device: &Device, fit: &Fit) -> Self {
        let judged = fit.judged();
        let results = || {
            let parameters = fit.parameters.iter().map(|p| (p.value, p.uncertainty));
            let derived = fit.derived.iter().map(|d| (d.value, d.uncertainty));
            let errors = judged.iter().filter(|limit| matches!(limit.limit.of, Limited::ScaleFactor(_)));
            parameters.chain(derived).chain(errors.map(|limit| (limit.value, limit.uncertainty)))
        };
        let of = |get: &dyn Fn(Option<f64>, Option<Combined>) -> Option<f64>| -> Vec<f64> {
            results().map(|(value, uncertainty)| get(value, uncertainty).unwrap_or(f64::NAN)).collect()
        };
        let limits: Vec<(&str, Conformity)> = judged.iter().map(|limit| (limit.id.as_str(), limit.outcome)).collect();
        let found = || fit.checks.snooping.iter().flat_map(|found| &found.suspects);
        let suspects: Vec<usize> =
            found().filter_map(|suspect| fit.design.rows.get(suspect.row).map(|origin| origin.reading + 1)).collect();
        let free = fit.parameters.iter().filter(|p| p.value.is_none() && !fit.not_estimable.is_empty());
        let free: Vec<&str> = free.map(|p| p.id.as_str()).collect();
        let mut remarks =
            Remarks::begun(fit.global_test.filter(|test| test.rejected).map(|test| test.p), &free, &fit.stuck());
        if fit.convergence.as_ref().is_some_and(|c| !c.converged) || !fit.settled {
            remarks.say(Reason::NoConvergence, "no convergence".to_string());
        }
        if fit.is_rejected() && remarks.0.is_empty() {
            remarks.say(Reason::Constraints, "constraints against the readings".to_string());
        }
        let test = fit.checks.lack_of_fit.as_ref().or(fit.checks.between_positions.as_ref());
        let lack_of_fit_p = test.map_or(f64::NAN, |test| test.p);
        let misfit = remarks.lack_of_fit(lack_of_fit_p, fit.settings.level);
        remarks.of_device(device, &suspects);
        remarks.limits(&limits);
        Row {
            label: device.label.clone(),
            lot: String::new(),
            verdict: if fit.is_rejected() || misfit { Verdict::Rejected } else { Verdict::Accepted },
            conformity: limits.iter().map(|(_, outcome)| *outcome).max(),
            why: remarks.words(),
            reasons: remarks.reasons(),
            readings: fit.design.rows.len(),
            rank: fit.estimate.unknowns.rank,
            dof: fit.estimate.dof,
            value: of(&|value, _| value),
            u: of(&|_, combined| combined.map(|c| c.u)),
            expanded: of(&|_, combined| combined.map(|c| c.expanded)),
            type_a: of(&|_, combined| combined.map(|c| c.type_a)),
            residual_sd: fit.residual_sd().unwrap_or(f64::NAN),
            chi_square_p: fit.global_test.map_or(f64::NAN, |test| test.p),
            lack_of_fit_p,
            runs_p: fit.checks.runs.iter().map(|(_, test)| test.p).fold(f64::NAN, f64::min),
            normality_p: fit.checks.normality.map_or(f64::NAN, |test| test.p),
            suspects,
            suspect_p: found().map(|suspect| suspect.p).fold(f64::NAN, f64::min),
            solved: Solved::Alone,
        }
    }
}

/// What is wrong with a device, or a person should look at, in words.
#[derive(Debug, Default)]
pub(super) struct Remarks(Vec<(Reason, String)>);

impl Remarks {
    fn say(&mut self, reason: Reason, words: String) {
        self.0.push((reason, words));
    }

    /// A global test that rejects, unknowns that are not determined, channels that are stuck with their values.
    pub(super) fn begun(global_test: Option<f64>, not_estimable: &[&str], stuck: &[(&str, f64)]) -> Self {
        let mut remarks = Remarks::default();
        if let Some(p) = global_test {
            remarks.say(Reason::GlobalTest, format!("global test p {p:.1e}"));
        }
        if !not_estimable.is_empty() {
            remarks.say(Reason::NotEstimable, format!("not estimable: {}", not_estimable.join(" ")));
        }
        for (sensor, value) in stuck {
            remarks.say(Reason::Stuck, format!("stuck: every reading of {sensor} is {value}"));
        }
        remarks
    }

    /// Lack of fit at the level; is it beyond doubt?
    pub(super) fn lack_of_fit(&mut self, p: f64, level: f64) -> bool {
        if p < 1.0 - level {
            self.say(Reason::LackOfFit, format!("lack of fit p {p:.1e}"));
        }
        p < quality::ALPHA
    }

    /// Suspicious readings with their places, and rows that stand several times.
    pub(super) fn of_device(&mut self, device: &Device, suspects: &[usize]) {
        if !suspects.is_empty() {
            let told = || suspects.iter().take(SUSPECTS);
            let list: Vec<String> = told().map(ToString::to_string).collect();
            // counted from 1
            let places: Vec<String> = told().filter_map(|reading| device.place(reading.checked_sub(1)?)).collect();
            let several = if suspects.len() > 1 { "s" } else { "" };
            let more = if suspects.len() > SUSPECTS { " ..." } else { "" };
            let mut words = format!("suspicious reading{several} {}{more}", list.join(" "));
            if !places.is_empty() {
                words += &format!(" ({})", places.join(", "));
            }
            self.say(Reason::SuspiciousReadings, words);
        }
        match device.repeated() {
            Some(Repeated::All(times)) => self.say(Reason::RepeatedRows, format!("every row occurs {times} times")),
            Some(Repeated::Block { first, again, rows }) => {
                let [again, first] = [again, first].map(|from| format!("{} to {}", from + 1, from + rows));
                self.say(Reason::RepeatedRows, format!("readings {again} repeat readings {first} digit for digit"));
            }
            None => {}
        }
    }

    pub(super) fn limits(&mut self, limits: &[(&str, Conformity)]) {
        for (outcome, reason, words) in [
            (Conformity::Fail, Reason::OutsideLimits, "outside limits:"),
            (Conformity::Undecided, Reason::Undecided, "undecided:"),
        ] {
            let names: Vec<&str> = limits.iter().filter(|(_, judged)| *judged == outcome).map(|(id, _)| *id).collect();
            if !names.is_empty() {
                self.say(reason, format!("{words} {}", names.join(" ")));
            }
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn words(&self) -> String {
        self.0.iter().map(|(_, words)| words.as_str()).collect::<Vec<_>>().join("; ")
    }

    pub(super) fn reasons(&self) -> Vec<Reason> {
        let mut reasons: Vec<Reason> = self.0.iter().map(|(reason, _)| *reason).collect();
        reasons.dedup();
        reasons
    }
}
