//! Two or more calibrations of one unit: what changed, by more than the uncertainties allow, and how fast.
//!
//! ```text
//! d = b - a,   C_d = C_a + C_b - sum_kl (c_ak c_bl' + c_bl c_ak') u_k u_l r_kl        k, l: inputs that both calibrations share, r_kk = 1
//! E_n = d / U(d),   U(d) = k u(d), k from the effective degrees of freedom           (ISO 13528:2022, 9.7; GUM F.1.2.3 for the shared part)
//! all changes together: d' C_d^-1 d, chi-square or, where the scatter was estimated, F
//! combined: x = (a/u_a^2 + b/u_b^2) / (1/u_a^2 + 1/u_b^2), Birge ratio sqrt(chi^2 / (n - 1))       (R. T. Birge, Phys. Rev. 40 (1932) 207)
//! ```
//!
//! Shared are the known inputs of Type B that both budgets name alike, with the same estimate and the same standard uncertainty: they moved both results
//! together and do not count twice. Deliberately absent: which of two calibrations is right.

use crate::plan::grouped;
use crate::uncertainty::quantiles::{chi_square_survival, coverage_factor, fisher_f_survival, student_t_two_sided};
use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One calibration's results, as a report holds them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Determination {
    /// The file that it came from.
    pub name: String,
    /// Day of the calibration, counted from 1970-01-01; `None` where the report has no date.
    pub day: Option<f64>,
    /// Estimated parameters and derived quantities with a value.
    pub quantities: Vec<Quantity>,
    /// Covariances of the quantities, in their order; NaN where not known.
    pub covariance: DMatrix<f64>,
    /// Pairs of known inputs that are correlated, and their coefficients.
    pub correlations: Vec<(String, String, f64)>,
}

/// A parameter or derived quantity of one calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Its name.
    pub id: String,
    /// Unit of the numbers.
    pub unit: String,
    /// Estimate.
    pub value: f64,
    /// Standard uncertainty, all inputs together; `None` where none is known.
    pub u: Option<f64>,
    /// Effective degrees of freedom.
    pub dof: f64,
    /// What known inputs of Type B contribute.
    pub inputs: Vec<InputShare>,
}

/// A known input's part in a quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct InputShare {
    /// Its name.
    pub id: String,
    /// Its estimate.
    pub estimate: f64,
    /// Its standard uncertainty.
    pub u: f64,
    /// How the quantity follows it.
    pub c: f64,
}

/// How one quantity changed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "ChangeOfReport")]
#[non_exhaustive]
pub struct Change {
    /// Its name.
    pub id: String,
    /// Unit of all numbers but ratios.
    pub unit: String,
    /// Estimate before, in `unit`.
    pub before: f64,
    /// Its standard uncertainty, in `unit`.
    pub u_before: Option<f64>,
    /// Estimate after, in `unit`.
    pub after: f64,
    /// Its standard uncertainty, in `unit`.
    pub u_after: Option<f64>,
    /// After minus before, in `unit`.
    pub difference: f64,
    /// Standard uncertainty of the difference, shared inputs taken out, in `unit`.
    pub u: Option<f64>,
    /// Its effective degrees of freedom; null for infinite.
    pub dof: Option<f64>,
    /// Its expanded uncertainty, in `unit`.
    #[serde(rename = "U")]
    pub expanded: Option<f64>,
    /// `difference / U`, a pure number.
    pub e_n: Option<f64>,
    /// Probability of a larger difference by chance.
    pub p: Option<f64>,
    /// Is the change significant, all quantities tested together (Holm)?
    pub significant: Option<bool>,
    /// Difference, in `unit` per day.
    pub per_day: Option<f64>,
    /// Weighted mean of both, in `unit`.
    pub combined: Option<f64>,
    /// Standard uncertainty of the mean, as it is where both agree, in `unit`.
    pub u_combined: Option<f64>,
    /// Birge ratio: well above 1 the two do not agree, and the mean's uncertainty is too small by it.
    pub birge: Option<f64>,
}

/// The test of all changes together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "TogetherReport")]
#[non_exhaustive]
pub struct Together {
    /// `d' C^-1 d` of the differences, a pure number.
    pub statistic: f64,
    /// Degrees of freedom: how many quantities.
    pub dof: usize,
    /// Degrees of freedom of the scatter; null where it is known (chi-square, else F).
    pub scatter_dof: Option<f64>,
    /// Probability of a larger one by chance.
    pub p: f64,
    /// Is it below one minus the level?
    pub significant: bool,
}

/// All changes between two calibrations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct Changes {
    /// Coverage probability of expanded uncertainties.
    pub level: f64,
    /// Each quantity that both have (angles in arcsec).
    pub changes: Vec<Change>,
    /// Known inputs that both share: they moved both results alike and do not count twice.
    pub shared: Vec<String>,
    /// All changes of parameters together.
    pub together: Option<Together>,
    /// Quantities that only the earlier one has.
    pub only_before: Vec<String>,
    /// Quantities that only the later one has.
    pub only_after: Vec<String>,
}

/// Compare two calibrations of one unit; with `shared` false every input counts as independent.
///
/// ```
/// use tumble::compare::calibrations::{Determination, InputShare, Quantity, changes};
/// use nalgebra::DMatrix;
/// // one scale factor, twice, on the same standard (u = 3 through it) and with a scatter of 4 each
/// let of = |value: f64| Determination {
///     quantities: vec![Quantity { id: "k".into(), unit: "ppm".into(), value, u: Some(5.0), dof: f64::INFINITY,
///         inputs: vec![InputShare { id: "standard".into(), estimate: 1.0, u: 3.0, c: 1.0 }] }],
///     covariance: DMatrix::from_element(1, 1, 25.0), ..Determination::default() };
/// let found = changes(&of(10.0), &of(20.0), 0.95, true);
/// // u^2 = 25 + 25 - 2*9 = 32
/// assert!((found.changes[0].u.unwrap() - 32f64.sqrt()).abs() < 1e-12);
/// ```
pub fn changes(a: &Determination, b: &Determination, level: f64, shared: bool) -> Changes {
    let mut pairs: Vec<Pair<'_>> = Vec::new();
    for p in a.quantities.iter().enumerate() {
        let same = |(_, q): &(usize, &Quantity)| q.id == p.1.id && q.unit == p.1.unit;
        pairs.extend(b.quantities.iter().enumerate().find(same).map(|q| (p, q)));
    }
    let mut names: Vec<String> = Vec::new();
    let mut changes = Vec::with_capacity(pairs.len());
    for ((_, before), (_, after)) in pairs.iter().copied() {
        for (input, _) in shared_inputs(before, after).filter(|_| shared) {
            if !names.contains(&input.id) {
                names.push(input.id.clone());
            }
        }
        let common = if shared { common(before, after, a, b) } else { 0.0 };
        let difference = after.value - before.value;
        let days = a.day.zip(b.day).map(|(a, b)| b - a).filter(|days| *days != 0.0);
        let plain = Change {
            id: before.id.clone(),
            unit: before.unit.clone(),
            before: before.value,
            u_before: before.u,
            after: after.value,
            u_after: after.u,
            difference,
            per_day: days.map(|days| difference / days),
            ..Change::default()
        };
        changes.push(judged(&plain, (before.dof, after.dof), common, level).unwrap_or(plain));
    }
    holm(&mut changes, 1.0 - level);
    let only = |one: &Determination, used: &dyn Fn(usize) -> bool| {
        one.quantities.iter().enumerate().filter(|(k, _)| !used(*k)).map(|(_, q)| q.id.clone()).collect()
    };
    Changes {
        level,
        changes,
        shared: names,
        together: together(a, b, &pairs, shared, level),
        only_before: only(a, &|k| pairs.iter().any(|((i, _), _)| *i == k)),
        only_after: only(b, &|k| pairs.iter().any(|(_, (j, _))| *j == k)),
    }
}

/// A quantity of one calibration, with its place there, and the same one of the other.
type Pair<'a> = ((usize, &'a Quantity), (usize, &'a Quantity));

/// Inputs that both quantities follow and that are one and the same.
fn shared_inputs<'a>(a: &'a Quantity, b: &'a Quantity) -> impl Iterator<Item = (&'a InputShare, &'a InputShare)> {
    a.inputs.iter().filter_map(|i| {
        let other = b.inputs.iter().find(|other| other.id == i.id && other.estimate == i.estimate && other.u == i.u)?;
        Some((i, other))
    })
}

/// Covariance of a quantity of one calibration and one of the other through the inputs that they share; a correlation counts where both state it.
fn common(p: &Quantity, q: &Quantity, a: &Determination, b: &Determination) -> f64 {
    let inputs: Vec<_> = shared_inputs(p, q).collect();
    let same = |x: &(String, String, f64), y: &(String, String, f64)| {
        x.2 == y.2 && ((x.0 == y.0 && x.1 == y.1) || (x.0 == y.1 && x.1 == y.0))
    };
    let alone: f64 = inputs.iter().map(|(s, t)| s.c * t.c * s.u * s.u).sum();
    let pairs = a.correlations.iter().filter(|pair| b.correlations.iter().any(|other| same(pair, other)));
    let of = |id: &str| inputs.iter().find(|(input, _)| input.id == id);
    let both = pairs.filter_map(|(x, y, r)| {
        let ((sx, tx), (sy, ty)) = (of(x)?, of(y)?);
        Some(r * sx.u * sy.u * (sx.c * ty.c + sy.c * tx.c))
    });
    alone + both.sum::<f64>()
}

/// A change with the uncertainty of its difference; `None` where one is missing, or where nothing but shared inputs is uncertain.
fn judged(change: &Change, (dof_a, dof_b): (f64, f64), common: f64, level: f64) -> Option<Change> {
    let (ua, ub) = (change.u_before?, change.u_after?);
    let square = ua * ua + ub * ub - 2.0 * common;
    // what is left of equal parts by rounding is no uncertainty
    if !(square > 1e-12 * (ua * ua + ub * ub)) {
        return None;
    }
    let u = square.sqrt();
    // Welch and Satterthwaite: the sum of u_i^4/nu_i over the parts of a result is its u^4/nu, whatever is shared
    let term = |u: f64, dof: f64| if dof.is_finite() && dof > 0.0 { u.powi(4) / dof } else { 0.0 };
    let below = term(ua, dof_a) + term(ub, dof_b);
    let dof = if below > 0.0 { square * square / below } else { f64::INFINITY };
    let expanded = coverage_factor(level, dof)? * u;
    let difference = change.difference;
    // least squares of two correlated values: weights from C^-1 (1, 1)'
    let (wa, wb) = (ub * ub - common, ua * ua - common);
    let finite = |x: f64| x.is_finite().then_some(x);
    Some(Change {
        u: Some(u),
        dof: finite(dof),
        expanded: Some(expanded),
        e_n: finite(difference / expanded),
        p: Some(student_t_two_sided(difference / u, dof)?),
        significant: Some(false),
        combined: finite((wa * change.before + wb * change.after) / (wa + wb)),
        u_combined: finite(((ua * ua * ub * ub - common * common) / square).max(0.0).sqrt()),
        birge: Some(difference.abs() / u),
        ..change.clone()
    })
}

/// Mark what is significant with all tested together: S. Holm, Scand. J. Statist. 6 (1979) 65.
fn holm(changes: &mut [Change], alpha: f64) {
    let mut order: Vec<(usize, f64)> = changes.iter().enumerate().filter_map(|(k, c)| Some((k, c.p?))).collect();
    order.sort_by(|x, y| x.1.total_cmp(&y.1));
    let count = order.len();
    for (rank, (k, p)) in order.into_iter().enumerate() {
        if !(p <= alpha / (count - rank) as f64) {
            return;
        }
        if let Some(change) = changes.get_mut(k) {
            change.significant = Some(true);
        }
    }
}

fn together(a: &Determination, b: &Determination, pairs: &[Pair<'_>], shared: bool, level: f64) -> Option<Together> {
    // derived quantities depend on the parameters: only those whose covariance is known take part
    let known = |d: &Determination, k: usize| d.covariance.get((k, k)).is_some_and(|variance| variance.is_finite());
    let known = |((i, _), (j, _)): &Pair<'_>| known(a, *i) && known(b, *j);
    let pairs: Vec<Pair<'_>> = pairs.iter().copied().filter(known).collect();
    let n = pairs.len();
    if n == 0 {
        return None;
    }
    let covariance = |x: usize, y: usize| {
        let (((i, before), (j, after)), ((k, before_too), (l, after_too))) = (*pairs.get(x)?, *pairs.get(y)?);
        let independent = a.covariance.get((i, k))? + b.covariance.get((j, l))?;
        let common = || common(before, after_too, a, b) + common(before_too, after, a, b);
        Some(if shared { independent - common() } else { independent })
    };
    // not a number, and so no test, where a covariance is none
    let c = DMatrix::from_fn(n, n, |x, y| covariance(x, y).unwrap_or(f64::NAN));
    let d: Vec<f64> = pairs.iter().map(|((_, before), (_, after))| after.value - before.value).collect();
    let scale: Vec<f64> = c.diagonal().iter().map(|c| c.sqrt()).collect();
    if scale.iter().any(|s| !(*s > 0.0)) {
        return None;
    }
    let scales = DVector::from_column_slice(&scale);
    let r = c.component_div(&(&scales * scales.transpose()));
    let z = DVector::from_iterator(n, d.iter().zip(&scale).map(|(d, scale)| d / scale));
    let statistic = z.dot(&r.cholesky()?.solve(&z));
    let dofs: Vec<f64> =
        pairs.iter().flat_map(|((_, a), (_, b))| [a.dof, b.dof]).filter(|dof| dof.is_finite() && *dof > 0.0).collect();
    // the scatter behind the difference has at least the degrees of freedom of the poorer half
    let scatter_dof = dofs.iter().copied().fold(f64::INFINITY, f64::min);
    let p = if scatter_dof.is_finite() {
        fisher_f_survival(statistic / n as f64, n as f64, scatter_dof)?
    } else {
        chi_square_survival(statistic, n as f64)?
    };
    let known = scatter_dof.is_finite().then_some(scatter_dof);
    Some(Together { statistic, dof: n, scatter_dof: known, p, significant: p < 1.0 - level })
}

/// A quantity over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "TrendReport")]
pub struct Trend {
    /// Its name.
    pub id: String,
    /// Unit of values.
    pub unit: String,
    /// Each calibration's day (from 1970-01-01), value and standard uncertainty.
    pub points: Vec<(f64, f64, Option<f64>)>,
    /// Slope per day of a straight line, in `unit` per day; null with fewer than three days.
    pub per_day: Option<f64>,
    /// Its standard uncertainty, in `unit` per day.
    pub u_per_day: Option<f64>,
    /// Is the slope significant?
    pub significant: Option<bool>,
    /// Birge ratio of the points about the line.
    pub birge: Option<f64>,
    /// Limits, where the last calibration states them.
    pub limits: Option<[f64; 2]>,
    /// Day on which the line leaves its limits, in days from 1970-01-01; before the last calibration where it has left them. Null where it does
    /// not, or where no slope is significant.
    pub leaves: Option<f64>,
}

impl Trend {
    /// Did the line leave its limits before the last calibration?
    pub fn has_left(&self) -> bool {
        self.leaves.zip(self.points.last()).is_some_and(|(day, last)| day < last.0)
    }
}

/// A straight line against time.
#[derive(Debug, Clone, Copy)]
struct TrendLine {
    /// The mean day.
    day: f64,
    /// Value there.
    value: f64,
    /// Slope per day.
    slope: f64,
    /// Its standard uncertainty.
    slope_u: f64,
    /// Birge ratio of the points about the line; the slope's uncertainty is multiplied by it where it is above 1.
    birge: f64,
    /// Is the slope significant at the level?
    significant: bool,
}

impl TrendLine {
    /// The day on which the line leaves these limits, also one that is past; `None` where the slope is not significant.
    fn leaves(&self, [low, high]: [f64; 2]) -> Option<f64> {
        let limit = if self.slope > 0.0 { high } else { low };
        let day = self.day + (limit - self.value) / self.slope;
        Some(day).filter(|day| self.significant && day.is_finite())
    }
}

/// The trends of all quantities of several calibrations.
///
/// Weights are `1/u^2` where every point has a standard uncertainty, else equal; equal weights take the scatter about the line. Inputs shared by all
/// calibrations move the line as a whole and are not taken out of `u`: the slope's uncertainty is then too large rather than too small.
/// `limits` gives each quantity's, if any.
pub fn trends(determinations: &[Determination], level: f64, limits: &dyn Fn(&str) -> Option<[f64; 2]>) -> Vec<Trend> {
    let all = determinations.iter().flat_map(|d| d.quantities.iter().map(|q| (d.day, q)));
    let trend = |alike: Vec<(Option<f64>, &Quantity)>| {
        let (_, Quantity { id, unit, .. }) = alike.first()?;
        let points = alike.iter().filter_map(|(day, q)| Some(((*day)?, q.value, q.u)));
        let mut points: Vec<(f64, f64, Option<f64>)> = points.collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (line, limits) = (straight(&points, level), limits(id));
        Some(Trend {
            id: id.clone(),
            unit: unit.clone(),
            points,
            per_day: line.map(|l| l.slope),
            u_per_day: line.map(|l| l.slope_u),
            significant: line.map(|l| l.significant),
            birge: line.map(|l| l.birge),
            limits,
            leaves: line.zip(limits).and_then(|(line, limits)| line.leaves(limits)),
        })
    };
    grouped(all.map(|(day, q)| ((day, q), (&q.id, &q.unit)))).into_iter().filter_map(trend).collect()
}

fn straight(points: &[(f64, f64, Option<f64>)], level: f64) -> Option<TrendLine> {
    let n = points.len();
    let stated = points.iter().all(|(_, _, u)| u.is_some_and(|u| u > 0.0));
    let weight = |u: Option<f64>| if stated { u.map_or(0.0, |u| 1.0 / (u * u)) } else { 1.0 };
    let total: f64 = points.iter().map(|p| weight(p.2)).sum();
    let mean =
        |f: &dyn Fn(&(f64, f64, Option<f64>)) -> f64| points.iter().map(|p| weight(p.2) * f(p)).sum::<f64>() / total;
    let (day, value) = (mean(&|p| p.0), mean(&|p| p.1));
    let spread: f64 = points.iter().map(|p| weight(p.2) * (p.0 - day).powi(2)).sum();
    if n < 3 || !(spread > 0.0) {
        return None;
    }
    let slope = points.iter().map(|p| weight(p.2) * (p.0 - day) * (p.1 - value)).sum::<f64>() / spread;
    let dof = (n - 2) as f64;
    let square: f64 = points.iter().map(|p| weight(p.2) * (p.1 - value - slope * (p.0 - day)).powi(2)).sum();
    let birge = (square / dof).sqrt();
    let factor = if stated { birge.max(1.0) } else { birge };
    let slope_u = factor / spread.sqrt();
    // where the stated uncertainties hold they are known; where the scatter had to widen them it was estimated
    let judged_dof = if stated && birge <= 1.0 { f64::INFINITY } else { dof };
    let k = coverage_factor(level, judged_dof)?;
    let significant = slope.abs() > k * slope_u && slope_u > 0.0;
    Some(TrendLine { day, value, slope, slope_u, birge: if stated { birge } else { 1.0 }, significant })
}

/// Days from 1970-01-01 to a date `YYYY-MM-DD` (proleptic Gregorian calendar); `None` for what is no such date.
///
/// ```
/// use tumble::compare::calibrations::day_number;
/// assert_eq!(day_number("2000-03-01"), Some(11017.0));
/// assert_eq!(day_number("2026-02-30"), None);
/// ```
pub fn day_number(date: &str) -> Option<f64> {
    let day: jiff::civil::Date = date.get(..10)?.parse().ok()?;
    Some(f64::from(jiff::civil::date(1970, 1, 1).until(day).ok()?.get_days()))
}
