//! What a fit report says of the readings: whether they agree with the model, the robust estimator, a record that was streamed, the constraints,
//! the Monte Carlo beside the first order.

use super::ARCSEC;
use crate::campaign::{Campaign, Constraint, Kind};
use crate::document::number::{at_most, percent, significant};
use crate::estimate::Side;
use crate::fit::streamed::{BinnedResiduals, SensorResiduals};
use crate::fit::{self, Constraints, Drawn, Fit, RobustMethod};
use crate::language::{Sentence, sentence};
use crate::quality::{LackOfFit, NormalityTest, RunsTest};
use crate::uncertainty::quantiles;
use crate::vocabulary::vocabulary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Do the readings agree with the model?
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChecksReport {
    /// Replicates against what the model leaves; null where nothing is replicated.
    pub lack_of_fit: Option<LackOfFit>,
    /// What the model leaves between positions against the scatter of the readings of each, where nothing is replicated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lack_of_fit_by_position: Option<LackOfFit>,
    /// Order of the residuals' signs, for each sensor.
    pub runs: BTreeMap<String, RunsTest>,
    /// The column that the residuals of a sensor follow, where they have too few runs of one sign in its order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub follows: Vec<FollowsReport>,
    /// Shapiro-Francia test of normality; null with fewer than eight residuals.
    pub normality: Option<NormalityTest>,
    /// Suspicious readings; null in a robust fit, and without redundancy.
    pub snooping: Option<SnoopingReport>,
    /// For each parameter, the reading whose undetected fault would do most to it.
    pub external: BTreeMap<String, ExternalReport>,
    /// In words, one sentence for each thing found.
    pub verdict: Vec<Sentence>,
}

impl ChecksReport {
    /// The test for lack of fit: by replicates, else by positions.
    pub(crate) fn misfit(&self) -> Option<&LackOfFit> {
        self.lack_of_fit.as_ref().or(self.lack_of_fit_by_position.as_ref())
    }
}

/// Residuals that follow a column.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FollowsReport {
    /// The sensor.
    pub sensor: String,
    /// The column of the readings.
    pub column: String,
    /// Runs of equal sign in its order; readings of one value are in the order of the other columns.
    pub runs: usize,
    /// Mean number of runs to be expected.
    pub expected: f64,
    /// Probability of so few in any of the orders that were tried.
    pub p: f64,
}

/// Data snooping.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SnoopingReport {
    /// Readings tested.
    pub tested: usize,
    /// Significance for a single reading (Sidak), a probability.
    pub single_level: f64,
    /// Suspicious readings.
    pub suspects: Vec<SuspectReport>,
    /// How each parameter would change without them (tilts in arcseconds).
    pub without_suspects: BTreeMap<String, f64>,
}

/// A suspicious reading.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SuspectReport {
    /// Number of the reading, from 1.
    pub index: usize,
    /// Its position label.
    pub position: String,
    /// The sensor.
    pub sensor: String,
    /// Its shift against the other readings, in the sensor's unit.
    pub shift: f64,
    /// Standard uncertainty of the shift, in the sensor's unit.
    pub u: f64,
    /// `shift / u`.
    pub w: f64,
    /// Probability of so large a shift among all readings if none were bad.
    pub p: f64,
}

/// External reliability of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ExternalReport {
    /// Number of the reading, from 1.
    pub index: usize,
    /// What its smallest detectable fault would do to the parameter, undetected (tilts in arcseconds).
    pub effect: f64,
}

/// The robust estimator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RobustReport {
    /// `huber`, `tukey` or `l1`.
    pub method: RobustMethod,
    /// Steps of reweighting.
    pub iterations: usize,
    /// Did it settle?
    pub converged: bool,
    /// Readings with less than half of their weight, by number.
    pub downweighted: Vec<usize>,
}

/// Factor to arcseconds for tilts, 1 for coefficients.
fn shown(fit: &Fit, parameter: usize) -> f64 {
    let tilt = fit.parameters.get(parameter).is_some_and(|p| p.kind == Kind::Tilt);
    if tilt { ARCSEC } else { 1.0 }
}

/// The robust estimator's record, where one was asked for.
pub(super) fn robust(fit: &Fit) -> Option<RobustReport> {
    let record = fit.robust.as_ref()?;
    let low = record.weights.iter().take(fit.design.rows.len()).enumerate().filter(|(_, w)| **w < 0.5);
    Some(RobustReport {
        method: record.method,
        iterations: record.iterations,
        converged: record.converged,
        downweighted: low.filter_map(|(i, _)| fit.design.rows.get(i).map(|origin| origin.reading + 1)).collect(),
    })
}

/// A number for each parameter, in JSON an object with its names as keys. The rows of a report share the names, of which a million readings would else hold
/// millions.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(from = "BTreeMap<String, f64>")]
pub struct EachParameter {
    /// In alphabetical order.
    names: Arc<[String]>,
    values: Box<[f64]>,
}

impl From<BTreeMap<String, f64>> for EachParameter {
    fn from(map: BTreeMap<String, f64>) -> Self {
        let (names, values): (Vec<String>, Vec<f64>) = map.into_iter().unzip();
        EachParameter { names: names.into(), values: values.into() }
    }
}

impl Serialize for EachParameter {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.names.iter().zip(&self.values))
    }
}

/// The names that the rows of a report share.
pub(super) struct Names {
    order: Vec<usize>,
    names: Arc<[String]>,
}

impl Names {
    pub(super) fn of(fit: &Fit) -> Self {
        let mut named: Vec<(usize, String)> = fit.parameters.iter().map(|p| p.id.clone()).enumerate().collect();
        named.sort_by(|(_, a), (_, b)| a.cmp(b));
        let (order, names): (Vec<usize>, Vec<String>) = named.into_iter().unzip();
        Names { order, names: names.into() }
    }
}

/// What an undetected fault of a reading would do to each parameter (tilts in arcseconds).
pub(super) fn external(fit: &Fit, names: &Names, row: usize) -> Option<EachParameter> {
    let values: Option<_> = names.order.iter().map(|k| Some(fit.external(row, *k)? * shown(fit, *k))).collect();
    Some(EachParameter { names: names.names.clone(), values: values? })
}

/// A number of a sensor with its unit.
fn in_unit(fit: &Fit, x: f64, sensor: &str) -> String {
    let own = fit.campaign.bench.sensors.iter().find(|own| own.id == sensor);
    // sensors of a report are those of its bench
    format!("{} {}", significant(x, 3), own.map_or("", |own| own.unit.as_str())).trim_end().to_string()
}

/// Suspicious readings in words; the list has them all.
pub(super) const PRINTED: usize = 5;

/// F, its degrees of freedom, and the sensor that it is of, where there are several.
pub(super) fn f_test(test: &LackOfFit, f: String) -> Sentence {
    let (sensor, is_of) = (test.sensor.clone().unwrap_or_default(), test.sensor.is_some());
    sentence!("f-test", is_of, sensor, f, between_dof = test.between_dof, pure_error_dof = test.pure_error_dof)
}

pub(super) fn checks(fit: &Fit) -> ChecksReport {
    let checks = &fit.checks;
    let level = 1.0 - checks.significance;
    let sensor = |s: usize| fit.campaign.sensor_id(s).to_string();
    let short = |x: f64| significant(x, 3);
    let mut verdict = Vec::new();
    let mut lack_of_fit = |test: &LackOfFit, by_position: bool| {
        let f = test.f.map_or("inf".into(), |f| significant(f, 5));
        let (rejected, below) = (test.rejected, test.is_below_scatter());
        // of what is too small the tail that tells; F has one, since its degrees of freedom are positive
        let lower = || quantiles::fisher_f_cdf(test.f?, test.between_dof as f64, test.pure_error_dof as f64);
        let p = short(if below { lower().unwrap_or(1.0 - test.p) } else { test.p });
        let test = f_test(test, f);
        verdict.push(match (by_position, below) {
            (_, true) => sentence!("less-than-the-scatter", by_position, test, p),
            (false, _) => sentence!("lack-of-fit-by-replicates", rejected, test, p),
            (true, _) => sentence!("lack-of-fit-between-positions", rejected, test, p),
        });
    };
    checks.lack_of_fit.iter().for_each(|test| lack_of_fit(test, false));
    checks.between_positions.iter().for_each(|test| lack_of_fit(test, true));
    for (k, w, p) in &checks.priors {
        let id = fit.parameters.get(*k).map_or("", |own| own.id.as_str());
        verdict.push(sentence!("prior-contradicts-the-readings", id, w = short(w.abs()), p = short(*p)));
    }
    for (s, test) in checks.runs.iter().filter(|(_, test)| test.is_rejected(level)) {
        let few = (test.runs as f64) < test.expected;
        verdict.push(sentence!(
            "residuals-of-have-too-runs-of-one",
            sensor = sensor(*s),
            few,
            runs = test.runs,
            expected = short(test.expected),
            p = short(test.p)
        ));
    }
    let follows = checks.follows.iter().map(|found| {
        let (sensor, column, test) = (sensor(found.sensor), found.column.clone(), found.test);
        FollowsReport { sensor, column, runs: test.runs, expected: test.expected, p: test.p }
    });
    let follows: Vec<FollowsReport> = follows.collect();
    verdict.extend(follows.iter().map(|found| {
        let (runs, expected, p) = (found.runs, short(found.expected), short(found.p));
        sentence!("residuals-follow-a-column", sensor = found.sensor, column = found.column, runs, expected, p)
    }));
    if let Some(test) = checks.normality.filter(|test| test.is_rejected(level)) {
        verdict.push(sentence!("residuals-are-not-normal-shapiro-francia-w", w = short(test.w), p = short(test.p)));
    }
    let row = |k: usize| fit.design.rows.get(k);
    let snooping = checks.snooping.as_ref().map(|found| {
        let suspects: Vec<SuspectReport> = found
            .suspects
            .iter()
            .map(|s| {
                // a suspect is a row of the design; of any other the report would name nothing
                let reading = row(s.row).and_then(|origin| fit.campaign.readings.rows.get(origin.reading));
                SuspectReport {
                    index: row(s.row).map_or(0, |origin| origin.reading + 1),
                    position: reading.map(|r| r.position.to_string()).unwrap_or_default(),
                    sensor: row(s.row).map(|origin| sensor(origin.sensor)).unwrap_or_default(),
                    shift: s.shift,
                    u: s.u,
                    w: s.w,
                    p: s.p,
                }
            })
            .collect();
        for s in suspects.iter().take(PRINTED) {
            verdict.push(sentence!(
                "suspicious-reading-of-is-off-what-the",
                index = s.index,
                sensor = s.sensor,
                shift = in_unit(fit, s.shift, &s.sensor),
                w = short(s.w),
                p = short(s.p),
                tested = found.tested
            ));
        }
        if suspects.len() > PRINTED {
            verdict.push(sentence!("more-suspicious-readings", more = suspects.len() - PRINTED));
        }
        let change = fit.parameters.iter().zip(&checks.without_suspects).enumerate();
        SnoopingReport {
            tested: found.tested,
            single_level: found.single_level,
            suspects,
            without_suspects: change.map(|(k, (p, x))| (p.id.clone(), x * shown(fit, k))).collect(),
        }
    });
    let mut external = BTreeMap::new();
    for (k, parameter) in fit.parameters.iter().enumerate() {
        let worst = (0..fit.checks.detectable.len())
            .filter_map(|i| Some((row(i)?.reading + 1, fit.external(i, k)?)))
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        if let Some((index, effect)) = worst {
            external.insert(parameter.id.clone(), ExternalReport { index, effect: effect * shown(fit, k) });
        }
    }
    verdict.extend(record_verdict(fit));
    ChecksReport {
        lack_of_fit: checks.lack_of_fit.clone(),
        lack_of_fit_by_position: checks.between_positions.clone(),
        runs: checks
            .runs
            .iter()
            .map(|(s, test)| (sensor(*s), RunsTest { rejected: Some(test.is_rejected(level)), ..*test }))
            .collect(),
        follows,
        normality: checks.normality.map(|test| NormalityTest { rejected: Some(test.is_rejected(level)), ..test }),
        snooping,
        external,
        verdict,
    }
}

/// A record whose rows are the readings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RecordReport {
    /// Rows of the record.
    pub rows: u64,
    /// Values that were read.
    pub values: u64,
    /// Passes over the record.
    pub passes: usize,
    /// Rows that the list of readings and the pictures show.
    pub shown: usize,
    /// The residuals of each sensor.
    pub sensors: Vec<SensorResiduals>,
    /// Lack of fit over the ranges of the inputs.
    pub inputs: Vec<BinnedResiduals>,
}

/// Largest residuals that a sentence names.
const NAMED: usize = 3;

/// The record of a fit, if it was streamed.
pub(super) fn record(fit: &Fit) -> Option<RecordReport> {
    let streamed = fit.streamed.as_ref()?;
    Some(RecordReport {
        rows: streamed.rows,
        values: streamed.values,
        passes: streamed.passes,
        shown: streamed.numbers.len(),
        sensors: streamed.sensors.clone(),
        inputs: streamed.bins.clone(),
    })
}

/// What the residuals of a record say, in sentences.
fn record_verdict(fit: &Fit) -> Vec<Sentence> {
    let Some(record) = &fit.streamed else { return Vec::new() };
    let level = 1.0 - fit.settings.level;
    let short = |x: f64| significant(x, 3);
    let mut found = Vec::new();
    for sensor in &record.sensors {
        let all = sensor.means.len().max(1) as f64;
        let worst = sensor
            .means
            .iter()
            .filter(|test| test.p * all < level)
            .max_by(|a, b| a.ratio.ln().abs().total_cmp(&b.ratio.ln().abs()));
        let rejected: Vec<&BinnedResiduals> =
            record.bins.iter().filter(|input| input.rejected && input.sensor == sensor.sensor).collect();
        let is_correlated = worst.is_some_and(|test| test.ratio > 1.0);
        for input in rejected.iter().filter(|_| !is_correlated) {
            found.push(sentence!(
                "lack-of-fit-over-an-input",
                sensor = input.sensor,
                input = input.column,
                chi_square = short(input.chi_square),
                dof = input.dof,
                p = short(input.p)
            ));
        }
        let id = &sensor.sensor;
        if let Some(test) = worst {
            let (rows, ratio, p) = (test.rows.to_string(), short(test.ratio.sqrt()), short(test.p));
            found.push(sentence!("means-of-rows-scatter", much = is_correlated, sensor = id, rows, ratio, p));
        } else if let Some(p) = sensor.lags_p.filter(|p| *p < level) {
            let lag = sensor.lags.iter().max_by(|a, b| a.correlation.abs().total_cmp(&b.correlation.abs()));
            let (correlation, rows) = lag.map(|l| (short(l.correlation), l.rows.to_string())).unwrap_or_default();
            found.push(sentence!("residuals-are-correlated", sensor = id, correlation, rows, p = short(p)));
        }
        if is_correlated && !rejected.is_empty() {
            let inputs: Vec<&str> = rejected.iter().map(|input| input.column.as_str()).collect();
            found.push(sentence!("lack-of-fit-or-correlation", sensor = sensor.sensor, inputs = inputs.join(", ")));
        }
        for far in sensor.largest.iter().filter(|far| far.p < level).take(NAMED) {
            found.push(sentence!(
                "row-is-far-from-the-model",
                sensor = sensor.sensor,
                row = far.number.to_string(),
                residual = in_unit(fit, far.residual, &sensor.sensor),
                w = short(far.w),
                p = short(far.p)
            ));
        }
    }
    found
}

vocabulary! {
    /// What became of a campaign's constraints.
    ConstraintsStatus {
        /// The estimate meets them.
        Met = "met",
        /// No values meet them together; none was applied.
        Contradictory = "contradictory",
        /// None was applied: a rank defect is left, or the solver gave up.
        NotApplied = "not-applied",
    }
}

vocabulary! {
    /// What became of one constraint.
    ConstraintState {
        /// An equation, met exactly.
        Equality = "equality",
        /// Met without it.
        Inactive = "inactive",
        /// An inequality that holds the estimate back.
        Active = "active",
        /// Together with others no values meet it.
        Contradictory = "contradictory",
        /// Not applied: a rank defect is left, or the solver gave up.
        NotApplied = "not-applied",
    }
}

/// The constraints of a campaign and what became of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConstraintsReport {
    /// `met`, `contradictory` (none was applied) or `not-applied` (a rank defect is left, or the solver gave up).
    pub status: ConstraintsStatus,
    /// Each of them.
    pub list: Vec<ConstraintReport>,
    /// By how much the inequalities raise chi-square (the sum of squares over the estimated variance), a pure number.
    pub cost: Option<f64>,
    /// Covariance of the constrained estimate on the active face (from the readings), in the order of `covariance`; null where no
    /// inequality is active. The parameters' own `u` and `interval` do not rely on it.
    pub on_face: Option<Vec<Vec<f64>>>,
    /// Probability of a larger cost if the bounds that are active were true: chi-square, or F where the variance is estimated.
    #[serde(default)]
    pub p: Option<f64>,
    /// Is it below one minus the level?
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rejected: Option<bool>,
    /// What the equations cost; absent where there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub equations: Option<EquationsReport>,
    /// In words.
    pub verdict: Sentence,
}

/// What the equations among the constraints cost together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EquationsReport {
    /// By how much they raise chi-square (the sum of squares over the estimated variance), a pure number.
    pub cost: f64,
    /// Degrees of freedom of the cost: unknowns that they give and the readings would determine.
    pub count: usize,
    /// Probability of a larger cost if they were true: chi-square, or F where the variance is estimated; null where nothing is to be tested.
    pub p: Option<f64>,
    /// Is it below one minus the level?
    pub rejected: Option<bool>,
}

/// One constraint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConstraintReport {
    /// Number in the file, from 1.
    pub index: usize,
    /// The constraint as a line of text.
    pub text: String,
    /// `equality`, `inactive`, `active` or `contradictory`.
    pub state: ConstraintState,
    /// `lower`, `upper` or `norm` where it is active.
    pub side: Option<Side>,
    /// Decrease of chi-square for each unit (radian for tilts) by which an active bound gives way.
    pub multiplier: Option<f64>,
    /// By how much chi-square, a pure number, would be smaller without an active bound.
    pub cost: Option<f64>,
}

pub(super) fn constraints(fit: &Fit) -> Option<ConstraintsReport> {
    let mut contradictory: &[usize] = &[];
    let (mut active, mut cost, mut on_face, mut equations) = (&[][..], None, None, None);
    let status = match &fit.constraints {
        Constraints::None => return None,
        Constraints::Met { active: holding, cost: all, on_face: face, equations: own, .. } => {
            (active, cost, on_face, equations) = (holding, Some(*all), face.as_ref(), own.as_ref());
            ConstraintsStatus::Met
        }
        Constraints::Contradictory(named) => {
            contradictory = named;
            ConstraintsStatus::Contradictory
        }
        Constraints::NotApplied => ConstraintsStatus::NotApplied,
    };
    let list: Vec<ConstraintReport> = fit
        .campaign
        .constraints
        .iter()
        .enumerate()
        .map(|(k, constraint)| {
            let inequality = active.iter().find(|a| a.constraint == k);
            let equality = matches!(constraint, Constraint::Linear { lower, upper, .. } if lower == upper);
            let state = match (inequality, equality) {
                _ if contradictory.contains(&k) => ConstraintState::Contradictory,
                _ if status != ConstraintsStatus::Met => ConstraintState::NotApplied,
                (Some(_), _) => ConstraintState::Active,
                (None, true) => ConstraintState::Equality,
                (None, false) => ConstraintState::Inactive,
            };
            ConstraintReport {
                index: k + 1,
                text: constraint_text(&fit.campaign, constraint),
                state,
                side: inequality.map(|a| a.side),
                multiplier: inequality.map(|a| a.multiplier),
                cost: inequality.map(|a| a.cost),
            }
        })
        .collect();
    let short = |x: f64| significant(x, 3);
    let equations = equations.map(|own| EquationsReport {
        cost: own.chi_square,
        count: own.count,
        p: fit.equations_p(),
        rejected: fit.equations_are_rejected(),
    });
    let verdict = match status {
        ConstraintsStatus::Contradictory => {
            let named: Vec<String> = contradictory.iter().map(|k| (k + 1).to_string()).collect();
            sentence!("no-values-meet-constraints-together-none-was", named = named.join(", "))
        }
        ConstraintsStatus::NotApplied => {
            sentence!("the-constraints-were-not-applied-the-readings")
        }
        ConstraintsStatus::Met => {
            let mut clauses: Vec<Sentence> = list
                .iter()
                .filter_map(|c| {
                    let cost = short(c.cost?);
                    Some(sentence!("constraint-costs-in-chi-square", index = c.index, text = c.text, cost))
                })
                .collect();
            let none_active = clauses.is_empty() && list.iter().any(|c| c.state == ConstraintState::Inactive);
            clauses.extend(equations.as_ref().map(|own| {
                let n = list.iter().filter(|c| c.state == ConstraintState::Equality).count();
                let (cost, p) = (short(own.cost), short(own.p.unwrap_or(1.0)));
                sentence!("equations-cost-in-chi-square", n, cost, tested = own.p.is_some(), p)
            }));
            if none_active {
                clauses.push(sentence!("no-bound-is-active-the-estimate-is", equations = equations.is_some()));
            }
            for (bounds, p, rejected) in [
                (true, fit.bounds_p(), fit.bounds_are_rejected()),
                (false, fit.equations_p(), fit.equations_are_rejected()),
            ] {
                let p = p.filter(|_| rejected == Some(true)).map(short);
                clauses.extend(p.map(|p| sentence!("rejected-the-readings-contradict-the-bounds-p", bounds, p)));
            }
            Sentence::clauses(clauses)
        }
    };
    let matrix = |m: &faer::Mat<f64>| {
        (0..m.nrows()).map(|i| (0..m.ncols()).map(|j| m[(i, j)]).collect()).collect::<Vec<Vec<f64>>>()
    };
    Some(ConstraintsReport {
        status,
        list,
        cost,
        on_face: on_face.map(matrix),
        p: fit.bounds_p(),
        rejected: fit.bounds_are_rejected(),
        equations,
        verdict,
    })
}

/// A constraint as a line of text, angles in arcseconds where all its parameters are tilts.
pub(super) fn constraint_text(campaign: &Campaign, constraint: &Constraint) -> String {
    let id = |k: &usize| campaign.parameters.get(*k).map_or("", |p| p.id.as_str());
    let tilt = |k: &usize| campaign.parameters.get(*k).is_some_and(|p| p.kind == Kind::Tilt);
    let angles = |parameters: &[usize]| parameters.iter().all(tilt);
    // digits enough to tell bounds apart, without those of a change of units
    let number = |x: f64| at_most(x, 12);
    match constraint {
        Constraint::Linear { terms, lower, upper } => {
            let sum = fit::sum(terms.iter().map(|(k, c)| {
                let factor = if c.abs() == 1.0 { String::new() } else { format!("{}*", number(c.abs())) };
                (*c < 0.0, factor + id(k))
            }));
            let tilts = angles(&terms.iter().map(|(k, _)| *k).collect::<Vec<usize>>());
            let (scale, unit) = if tilts { (ARCSEC, " arcsec") } else { (1.0, "") };
            match (lower.is_finite(), upper.is_finite()) {
                _ if lower == upper => format!("{sum} = {}{unit}", number(lower * scale)),
                (true, true) => format!("{} <= {sum} <= {}{unit}", number(lower * scale), number(upper * scale)),
                (true, false) => format!("{sum} >= {}{unit}", number(lower * scale)),
                _ => format!("{sum} <= {}{unit}", number(upper * scale)),
            }
        }
        Constraint::Norm { of, at_most } => {
            let names: Vec<&str> = of.iter().map(id).collect();
            let (scale, unit) = if angles(of) { (ARCSEC, " arcsec") } else { (1.0, "") };
            format!("norm of ({}) <= {}{unit}", names.join(", "), number(at_most * scale))
        }
    }
}

/// Monte Carlo compared with the first order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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
