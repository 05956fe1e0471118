//! Value, standard uncertainty, budget and expanded uncertainty of every estimated parameter and derived quantity; parameters by name, angles in arcseconds.

use super::Fit;
use super::azimuth::{Sector, sector};
use super::names::{NamedCombination, describe};
use super::noise::ScatterSources;
use super::rules::{self, Constraints};
use crate::algebra::{Expression, Scratch, Tape};
use crate::campaign::{Campaign, Derived, Kind, Known, Parameter};
use crate::design::DesignMatrix;
use crate::elements::{Elements, Parts};
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{Combination, Estimate};
use crate::uncertainty::{Combined, Contribution, Evaluation, combine_groups};
use crate::units::ARCSEC;
use crate::vocabulary::vocabulary;
use faer::Mat;

vocabulary! {
    /// What the fit can say about a parameter.
    State {
        /// Determined by the readings.
        Free = "free",
        /// On a bound.
        AtBound = "at-bound",
        /// Given by equations.
        Fixed = "fixed",
        /// Only a combination with others is determined.
        NotEstimable = "not-estimable",
    }
}

/// An estimated parameter.
#[derive(Debug, Clone)]
pub struct ParameterResult {
    /// Its name.
    pub id: String,
    /// Tilt or coefficient.
    pub kind: Kind,
    /// Unit of value and uncertainty (`rad` for tilts).
    pub unit: String,
    /// What it means, for a person.
    pub meaning: String,
    /// Estimate; `None` where it is not estimable.
    pub value: Option<f64>,
    /// Combined uncertainty; `None` where it cannot be known (not estimable, or no degree of freedom to estimate the scatter).
    pub uncertainty: Option<Combined>,
    /// Coverage interval at the level asked: about the estimate that only equations restrict, cut to the values that the other
    /// constraints allow; `None` where no uncertainty is known, or where nothing of it is allowed.
    pub interval: Option<(f64, f64)>,
    /// Where the uncertainty comes from.
    pub budget: Vec<Contribution>,
    /// Free, given, at a bound, or not estimable.
    pub state: State,
}

/// A derived quantity.
#[derive(Debug, Clone)]
pub struct DerivedResult {
    /// Its name.
    pub id: String,
    /// The line of algebra.
    pub line: String,
    /// Is it an angle (so that a person wants arcseconds)?
    pub is_angle: bool,
    /// Value; `None` where it needs a parameter that is not estimable, or is no finite number.
    pub value: Option<f64>,
    /// First-order combined uncertainty; of an azimuth that may be any, that of the whole circle.
    pub uncertainty: Option<Combined>,
    /// Coverage interval, as that of a parameter, in first order.
    pub interval: Option<(f64, f64)>,
    /// The directions that an azimuth may have, in the unit of the value; `None` for what is no azimuth.
    pub sector: Option<Sector>,
    /// Where the uncertainty comes from.
    pub budget: Vec<Contribution>,
}

/// A combination of parameters that is estimable where they alone are not.
#[derive(Debug, Clone)]
pub struct CombinationResult {
    /// The parameters and their coefficients.
    pub combination: NamedCombination,
    /// Unit of the value: that of the first parameter, whose coefficient is 1.
    pub unit: String,
    /// Is it an angle (so that a person wants arcseconds)?
    pub is_angle: bool,
    /// Value.
    pub value: f64,
    /// Combined uncertainty; `None` where no scatter can be estimated.
    pub uncertainty: Option<Combined>,
    /// Where the uncertainty comes from.
    pub budget: Vec<Contribution>,
}

/// A quantity does not change along a free direction where its terms cancel to this share,
pub(crate) const SAME: f64 = 1e-8;
/// or to this one along a direction that the exact model ends beyond the first order.
const NEARLY_SAME: f64 = 1e-2;

/// How far beside the estimate slopes are looked at again, as a share of one and of the parameter. A slope that vanishes at the estimate alone is in proportion to this step, and so is the
/// sum of its terms: what is compared does not depend on it. It is far above rounding, and its square small beside an angle.
const BESIDE: f64 = 1e-3;

/// The change of a quantity along a direction, and the sum of its terms.
pub(crate) fn moved(terms: &[(usize, f64)], along: &[f64]) -> (f64, f64) {
    let terms = || terms.iter().map(|(k, e)| along.at(*k) * e);
    (terms().sum::<f64>().abs(), terms().map(f64::abs).sum())
}

/// Known parameters with an uncertainty, and how the solution follows each: `d x / d p = -(dx/dy) df/dp`, priors untouched.
///
/// `df/dp` is that of the exact model at the *solution*: at a reference point with zero tilts a scale factor would seem to have no part in
/// tilts that it multiplies.
pub(super) fn known_inputs(
    campaign: &Campaign,
    at_solution: &DesignMatrix,
    noise: &ScatterSources,
) -> Vec<(usize, Known, Vec<f64>)> {
    let mut inputs = Vec::new();
    for (k, known) in campaign.uncertain() {
        let mut sensitivity = vec![0.0; campaign.unknowns()];
        for (j, c) in sensitivity.iter_mut().enumerate().take(noise.sensitivities.nrows()) {
            *c = -(0..at_solution.rows.len())
                .map(|i| noise.sensitivities[(j, i)] * at_solution.jacobian[(i, k)])
                .sum::<f64>();
        }
        inputs.push((k, known, sensitivity));
    }
    inputs
}

/// What budgets tell.
pub(super) struct Told {
    pub parameters: Vec<ParameterResult>,
    pub covariance: Mat<f64>,
    pub derived: Vec<DerivedResult>,
    pub combinations: Vec<CombinationResult>,
    /// How the estimated parameters follow each known input that has an uncertainty.
    pub known: Vec<(usize, Known, Vec<f64>)>,
}

/// Coverage interval of a quantity of this value that follows the parameters like this, from its expanded uncertainty.
type Interval<'a> = dyn Fn(f64, &[f64], f64) -> Option<(f64, f64)> + 'a;

/// What every budget of a fit needs.
pub(super) struct BudgetInputs<'a> {
    pub campaign: &'a Campaign,
    pub estimate: &'a Estimate,
    pub noise: &'a ScatterSources,
    /// How the solution follows each known input.
    pub known: Vec<(usize, Known, Vec<f64>)>,
    pub level: f64,
    pub weak: &'a [usize],
    pub judged_at: Option<&'a [f64]>,
}

impl BudgetInputs<'_> {
    /// Everything at a point, `free` being the estimate that only equations restrict.
    pub(super) fn told(&self, point: &[f64], free: &[f64], constraints: &Constraints) -> Result<Told> {
        let at_bound = rules::at_bound(self.campaign, constraints);
        let bounded = matches!(constraints, Constraints::Met { .. });
        let fixed = if bounded { rules::fixed(self.campaign, point) } else { Vec::new() };
        let interval = |value: f64, along: &[f64], expanded: f64| {
            let to = |x: &[f64]| along.iter().zip(x.iter().zip(point)).map(|(c, (x, at))| c * (x - at)).sum::<f64>();
            let zero = vec![0.0; along.len()];
            let (low, high) = match bounded {
                true => rules::allowed(self.campaign, along),
                false => (f64::NEG_INFINITY, f64::INFINITY),
            };
            let (centre, origin) = (value + to(free), value + to(&zero));
            let (a, b) = ((centre - expanded).max(origin + low), (centre + expanded).min(origin + high));
            (a <= b).then_some((a, b))
        };
        Ok(Told {
            parameters: self.parameters(point, (&at_bound, &fixed), &interval),
            covariance: self.covariance(),
            derived: self.derived(point, &interval)?,
            combinations: self.combinations(point),
            known: self.known.clone(),
        })
    }

    /// Full covariance of the estimated parameters: readings and known inputs.
    fn covariance(&self) -> Mat<f64> {
        let mut covariance = self.noise.covariance.clone();
        for (_, input, c) in &self.known {
            for (i, a) in c.iter().enumerate().take(covariance.nrows()) {
                for (j, b) in c.iter().enumerate().take(covariance.ncols()) {
                    covariance[(i, j)] += a * b * input.u * input.u;
                }
            }
        }
        for (_, [(_, one, a), (_, other, b)], r) in self.correlated() {
            for i in 0..covariance.nrows() {
                for j in 0..covariance.ncols() {
                    covariance[(i, j)] += r * one.u * other.u * (a.at(i) * b.at(j) + a.at(j) * b.at(i));
                }
            }
        }
        covariance
    }

    /// Pairs of correlated known inputs: their names, how the solution follows each, and the coefficient.
    fn correlated(&self) -> impl Iterator<Item = ([&str; 2], [&(usize, Known, Vec<f64>); 2], f64)> {
        let of = |name: &str| self.known.iter().find(|(k, ..)| self.campaign.parameter_id(*k) == name);
        self.campaign.correlations.iter().filter_map(move |(a, b, r)| Some(([a.as_str(), b], [of(a)?, of(b)?], *r)))
    }

    /// Budget of `c . x`, a known input acting also by itself (`own`), and what it combines to.
    fn budget(&self, along: &[f64], own: impl Fn(usize) -> f64) -> (Vec<Contribution>, Option<Combined>) {
        let (mut budget, type_a_dof) = self.noise.contributions(along);
        let from_readings = budget.len();
        let sensitivity = |k: usize, c: &[f64]| own(k) + along.iter().zip(c).map(|(a, c)| a * c).sum::<f64>();
        for (k, input, c) in &self.known {
            budget.push(known_contribution(self.campaign.parameter_id(*k), input, sensitivity(*k, c)));
        }
        let (mut together, mut correlated_dof) = (Vec::new(), f64::INFINITY);
        for ([a, b], [(i, one, c), (j, other, d)], r) in self.correlated() {
            let covariance = 2.0 * r * sensitivity(*i, c) * one.u * sensitivity(*j, d) * other.u;
            budget.push(correlated_contribution([a, b], covariance));
            together.extend([a.to_string(), b.to_string(), pair_name([a, b])]);
            correlated_dof = correlated_dof.min(one.dof).min(other.dof);
        }
        if !self.noise.determined && from_readings > 0 {
            return (budget, None);
        }
        if !self.noise.tells(along) {
            // shares of an unknown whole
            return (Vec::new(), None);
        }
        // those of the readings were estimated together, and so were those of a calibration that several known inputs come from
        let of_readings =
            |c: &Contribution| type_a_dof.is_some() && c.evaluation == Evaluation::TypeA && c.dof.is_finite();
        let group = |c: &Contribution| match together.contains(&c.source) && c.evaluation == Evaluation::TypeB {
            true => Some(1),
            false => of_readings(c).then_some(0),
        };
        let dofs = [type_a_dof.unwrap_or(f64::INFINITY), correlated_dof];
        let combined = combine_groups(&budget, &group, &dofs, self.level);
        (budget, combined)
    }

    /// The same of what follows all parameters, known ones also by themselves, like this.
    fn budget_along(&self, slopes: &[f64]) -> (Vec<Contribution>, Option<Combined>) {
        // a source that the line does not depend on
        let own = |k: usize| slopes.get(k).copied().unwrap_or_default();
        self.budget(slopes.part(..self.campaign.unknowns()), own)
    }

    /// Results of all estimated parameters.
    fn parameters(
        &self,
        point: &[f64],
        (at_bound, fixed): (&[usize], &[usize]),
        interval: &Interval<'_>,
    ) -> Vec<ParameterResult> {
        let result = |(k, parameter): (usize, &Parameter)| {
            let estimable = self.estimate.unknowns.is_estimable(k);
            let mut along = vec![0.0; self.campaign.unknowns()];
            if let Some(one) = along.get_mut(k) {
                *one = 1.0;
            }
            let (budget, uncertainty) = if estimable { self.budget(&along, |_| 0.0) } else { (Vec::new(), None) };
            let interval = uncertainty.and_then(|combined| interval(point.at(k), &along, combined.expanded));
            let state = match estimable {
                false => State::NotEstimable,
                true if fixed.contains(&k) => State::Fixed,
                true if at_bound.contains(&k) => State::AtBound,
                true => State::Free,
            };
            ParameterResult {
                id: parameter.id.clone(),
                kind: parameter.kind,
                unit: parameter.unit.clone(),
                meaning: parameter.meaning.clone(),
                value: if estimable { point.get(k).copied() } else { None },
                uncertainty,
                interval,
                budget,
                state,
            }
        };
        self.campaign.estimated().iter().enumerate().map(result).collect()
    }

    /// Do the readings determine a quantity: is it the same wherever they leave the parameters free?
    ///
    /// `along` are its sensitivities at the estimate, `judged` those at the point where the rank was decided, if that was another: a free
    /// direction is straight there, and at the estimate to first order in the small angles only.
    fn determines(&self, along: &[f64], judged: Option<&[f64]>) -> bool {
        let small = |k: usize| self.campaign.parameters.get(k).is_some_and(|p| p.kind == Kind::Tilt || p.unit == "1");
        let sensitive = along.iter().enumerate().filter(|(k, _)| small(*k));
        let largest = sensitive.fold(0.0_f64, |most, (_, c)| most.max(c.abs()));
        self.estimate.unknowns.free_directions.iter().all(|direction| {
            let (change, terms) = moved(&direction.terms, along);
            let held = direction.terms.iter().any(|(k, _)| self.weak.contains(k));
            if change <= if held { NEARLY_SAME } else { SAME } * terms {
                return true;
            }
            let Some((there, of)) = judged.map(|own| moved(&direction.terms, own)) else { return false };
            let far: f64 = direction.terms.iter().map(|(_, e)| e.abs()).sum();
            direction.terms.iter().all(|(k, _)| small(*k))
                && there <= SAME * of
                && change <= NEARLY_SAME * largest * far
        })
    }

    /// Points beside the estimate, one along each direction that the readings leave free: a slope that vanishes at the estimate alone, as that of a root of a sum of squares of which
    /// one is not determined, makes nothing determined.
    fn besides(&self, point: &[f64]) -> Vec<Vec<f64>> {
        let beside = |direction: &Combination| {
            let reach = direction.terms.iter().map(|(k, e)| (1.0 + point.at(*k).abs()) / e.abs());
            let step = BESIDE * reach.fold(f64::INFINITY, f64::min);
            let mut beside = point.to_vec();
            for (k, e) in &direction.terms {
                beside.iter_mut().skip(*k).take(1).for_each(|x| *x += step * e);
            }
            beside
        };
        self.estimate.unknowns.free_directions.iter().map(beside).collect()
    }

    /// What the readings determine of parameters that are not estimable alone.
    fn combinations(&self, point: &[f64]) -> Vec<CombinationResult> {
        let result = |combination: &Combination| {
            let mut along = vec![0.0; self.campaign.unknowns()];
            for (k, c) in &combination.terms {
                if let Some(slot) = along.get_mut(*k) {
                    *slot = *c;
                }
            }
            let (budget, uncertainty) = self.budget(&along, |_| 0.0);
            let parameter = |k: &usize| self.campaign.parameters.get(*k);
            let unit_of = |(k, _): &(usize, f64)| parameter(k).map_or("", |own| own.unit.as_str());
            let unit = combination.terms.first().map_or("", unit_of);
            let is_angle =
                combination.terms.iter().all(|(k, _)| parameter(k).is_some_and(|own| own.kind == Kind::Tilt));
            CombinationResult {
                combination: describe(self.campaign, combination),
                unit: unit.to_string(),
                is_angle,
                value: combination.value(point),
                uncertainty,
                budget,
            }
        };
        self.estimate.unknowns.estimable_combinations.iter().map(result).collect()
    }

    /// Results of the derived quantities: first order, `c = d quantity / d parameters` at the estimate.
    ///
    /// A known parameter acts twice, through the line itself and through the estimates: its sensitivity is the sum of both.
    fn derived(&self, point: &[f64], interval: &Interval<'_>) -> Result<Vec<DerivedResult>> {
        let campaign = self.campaign;
        let ids: Vec<&str> = campaign.parameters.iter().map(|p| p.id.as_str()).collect();
        let finite = |(value, slopes): &(f64, Vec<f64>)| value.is_finite() && slopes.iter().all(|c| c.is_finite());
        let result = |quantity: &Derived| {
            let there = self.judged_at.filter(|_| !self.estimate.unknowns.free_directions.is_empty());
            let there = there.map(|at| slopes(&quantity.line, &ids, at)).transpose()?.filter(finite);
            let here = slopes(&quantity.line, &ids, point)?;
            let (value, along) = (here.0, here.1.part(..campaign.unknowns()));
            let judged = there.as_ref().map(|own| own.1.as_slice());
            let usable = finite(&here)
                && self.determines(along, judged)
                && self.besides(point).iter().map(|beside| slopes(&quantity.line, &ids, beside)).try_fold(
                    true,
                    |all, beside| {
                        let beside = beside?;
                        Ok(all && finite(&beside) && self.determines(beside.1.part(..campaign.unknowns()), judged))
                    },
                )?;
            let (budget, uncertainty) = if usable { self.budget_along(&here.1) } else { (Vec::new(), None) };
            let angle = |name: &str| {
                let parameter = campaign.parameter_index(name).and_then(|k| campaign.parameters.get(k))?;
                Some(if parameter.kind == Kind::Tilt { 1.0 } else { return None })
            };
            let (uncertainty, sector, budget) = match self.azimuth(quantity, &ids, point, uncertainty)? {
                Some((scale, Sector::Circle)) => (Some(any_direction(scale)), Some(Sector::Circle), Vec::new()),
                Some((_, sector)) => (uncertainty, Some(sector), budget),
                None => (uncertainty, None, budget),
            };
            Ok(DerivedResult {
                id: quantity.id.clone(),
                line: quantity.line.to_string(),
                is_angle: matches!(quantity.unit.as_str(), "" | "rad")
                    && quantity.line.angle_degree(&angle) == Some(1.0),
                value: usable.then_some(value),
                uncertainty,
                interval: uncertainty.and_then(|combined| interval(value, along, combined.expanded)),
                sector,
                budget,
            })
        };
        campaign.derived.iter().map(result).collect()
    }

    /// The sector of a derived line `c*atan2(y, x)` in the unit of its value, with c; `None` for other lines, and without uncertainty.
    ///
    /// Variances of x, y and x + y give their covariance.
    fn azimuth(
        &self,
        quantity: &Derived,
        ids: &[&str],
        point: &[f64],
        uncertainty: Option<Combined>,
    ) -> Result<Option<(f64, Sector)>> {
        let (Some((scale, y, x)), Some(combined)) = (quantity.line.as_azimuth(), uncertainty) else { return Ok(None) };
        let one = |line: &Expression| -> Result<(f64, Option<f64>)> {
            let (value, along) = slopes(line, ids, point)?;
            Ok((value, self.budget_along(&along).1.map(|c| c.u * c.u)))
        };
        let ((y_value, yy), (x_value, xx), (_, both)) = (one(&y)?, one(&x)?, one(&x.plus(&y))?);
        let found = xx.zip(yy).zip(both).and_then(|((xx, yy), both)| {
            let covariance = [xx, 0.5 * (both - xx - yy), yy];
            sector((x_value, y_value), covariance, combined.dof, self.level)
        });
        Ok(found.map(|sector| match sector {
            Sector::Circle => (scale, Sector::Circle),
            Sector::Between(low, high) if scale < 0.0 => (scale, Sector::Between(scale * high, scale * low)),
            Sector::Between(low, high) => (scale, Sector::Between(scale * low, scale * high)),
        }))
    }
}

/// Value of a line of algebra, and its slopes by all parameters.
fn slopes(line: &Expression, ids: &[&str], at: &[f64]) -> Result<(f64, Vec<f64>)> {
    let mut slopes = vec![0.0; ids.len()];
    let value = Tape::compile(line, ids)?.gradient(at, &mut Scratch::default(), &mut slopes);
    Ok((value, slopes))
}

/// The uncertainty of an angle of which nothing is known: rectangular over the circle (GUM 4.3.7), `u = pi/sqrt 3`, U half of it.
fn any_direction(scale: f64) -> Combined {
    let u = scale.abs() * std::f64::consts::PI / 3f64.sqrt();
    Combined {
        u,
        type_a: u,
        type_b: 0.0,
        dof: f64::INFINITY,
        coverage_factor: 3f64.sqrt(),
        expanded: scale.abs() * std::f64::consts::PI,
    }
}

fn pair_name([a, b]: [&str; 2]) -> String {
    format!("r({a}, {b})")
}

/// The covariance of two correlated inputs, `2 c_i c_j u_i u_j r` of GUM eq. 13, as the budget has it.
fn correlated_contribution(names: [&str; 2], covariance: f64) -> Contribution {
    let u = covariance.abs().sqrt().copysign(covariance);
    Contribution::of_many(pair_name(names), Evaluation::TypeB, u, f64::INFINITY)
}

fn known_contribution(id: &str, input: &Known, sensitivity: f64) -> Contribution {
    Contribution {
        source: id.to_string(),
        evaluation: Evaluation::TypeB,
        distribution: input.distribution.into(),
        estimate: Some(input.value),
        source_u: Some(input.u),
        sensitivity: Some(sensitivity),
        u: sensitivity.abs() * input.u,
        dof: input.dof,
    }
}

/// An estimated angle: a tilt, or a derived angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angle {
    value: Option<f64>,
    u: Option<f64>,
    expanded: Option<f64>,
}

impl Angle {
    /// The estimate in arcseconds; `None` where it is not estimable.
    pub fn arcsec(&self) -> Option<f64> {
        self.value.map(|value| value * ARCSEC)
    }

    /// Its standard uncertainty in arcseconds; `None` where it cannot be known.
    pub fn u_arcsec(&self) -> Option<f64> {
        self.u.map(|u| u * ARCSEC)
    }
}

impl Fit {
    /// The result of an estimated parameter. Errors: a name that is not estimated.
    pub fn parameter(&self, id: &str) -> Result<&ParameterResult> {
        self.parameters.iter().find(|own| own.id == id).ok_or_else(|| self.unknown(id, "parameter"))
    }

    /// An estimated tilt or a derived angle.
    ///
    /// ```
    /// let text = include_str!("../../data/campaigns/li2012-table1.campaign.json");
    /// let fit = tumble::fit(&tumble::Campaign::from_json(text)?, &Default::default())?;
    /// // Li, Ren, Zhao 2012, table 1: -162.2, -162.2 and -162.0 arcsec at the three rates
    /// assert!((fit.angle("dtheta_y2")?.arcsec().unwrap() + 162.1).abs() < 0.15);
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    ///
    /// Errors: a name that is no estimated angle.
    pub fn angle(&self, id: &str) -> Result<Angle> {
        let tilt = self.parameters.iter().find(|own| own.id == id && own.kind == Kind::Tilt);
        let derived = || self.derived.iter().find(|own| own.id == id && own.is_angle);
        let (value, uncertainty) = tilt
            .map(|own| (own.value, own.uncertainty))
            .or_else(|| derived().map(|own| (own.value, own.uncertainty)))
            .ok_or_else(|| self.unknown(id, "angle"))?;
        Ok(Angle { value, u: uncertainty.map(|own| own.u), expanded: uncertainty.map(|own| own.expanded) })
    }

    fn unknown(&self, id: &str, what: &str) -> Malformed {
        let names: Vec<&str> = self.parameters.iter().map(|own| own.id.as_str()).collect();
        Malformed::new(Fault::UnknownName, format!("no estimated {what} is called '{id}'")).expected(names.join(", "))
    }
}
