//! What the parts of a device say of it: estimates, uncertainties, rank and global test from the triangle.

use super::Row;
use super::parts::{Part, Parts};
use super::row::{Remarks, Solved, Verdict};
use crate::algebra::Scratch;
use crate::campaign::{Known, Limited};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{Fold, Folded, Group};
use crate::fit::{self, Conformity, Weighting};
use crate::uncertainty::{Combined, effective_dof, quantiles};
use faer::Mat;

/// A quantity does not change along a free direction where its terms cancel to this share.
const SAME: f64 = 1e-8;

/// Coverage factors that return.
#[derive(Debug, Clone, Default)]
pub struct Coverage(Vec<(u64, Option<f64>)>);

impl Parts {
    /// A device's answer: estimates, uncertainties, rank and global test as its own fit says them.
    pub fn finish(&self, label: &str, part: &Part, coverage: &mut Coverage) -> Row {
        let quantities = self.template.unknowns() + self.derived.len();
        self.row(label, part, coverage).unwrap_or_else(|error| Row::without(label, quantities, &error))
    }

    /// Is the scatter of the readings estimated from them?
    fn is_scaled(&self, part: &Part) -> Result<bool> {
        let sensors = || self.template.bench.sensors.iter().zip(&part.met);
        if let Some((sensor, _)) = sensors().find(|(_, met)| **met == [true, true]) {
            let id = &sensor.id;
            return Err(Malformed::new(
                Fault::Missing,
                format!("some readings of {id} have a stated uncertainty and some have none"),
            )
            .expected(format!(
                "{id}_u in every reading of {id}, or in none (then it is estimated from the residuals)"
            )));
        }
        let relative = self.settings.weighting == Weighting::Relative;
        let read: Vec<bool> =
            sensors().filter(|(_, met)| **met != [false, false]).map(|(_, met)| relative || met[1]).collect();
        match read.as_slice() {
            [] => {
                let ids: Vec<&str> = self.template.bench.sensors.iter().map(|s| s.id.as_str()).collect();
                Err(Malformed::new(Fault::Missing, "no reading has a sensor value")
                    .expected(format!("readings with a value for {}", ids.join(" or "))))
            }
            [true] if self.priors.is_empty() => Ok(true),
            list if !list.contains(&true) => Ok(false),
            _ => Err(Malformed::new(
                Fault::Missing,
                "the scatter of several sensors (or with priors) is to be estimated, which needs all readings in memory",
            )
            .expected("stated uncertainties of the readings, or the ordinary fit of each device")),
        }
    }

    fn row(&self, label: &str, part: &Part, coverage: &mut Coverage) -> Result<Row> {
        let (template, settings) = (&self.template, &self.settings);
        let n = template.unknowns();
        let scaled = self.is_scaled(part)?;
        if part.largest > 0.0 && part.largest < fit::LEAST {
            return Err(Malformed::new(
                Fault::Value,
                "the largest reading is beyond the numbers that a fit can square",
            )
            .expected("units in which it lies between 1e-70 and 1e70")
            .found(format!("{:e}", part.largest)));
        }
        let joined;
        let fold = if self.priors.is_empty() {
            &part.fold
        } else {
            let mut fold = part.fold.clone();
            for (k, difference, u) in &self.priors {
                let row = Mat::from_fn(1, n + self.carried.len(), |_, j| f64::from(u8::from(j == *k)));
                fold.push(row.as_ref(), &[*difference], &[*u])?;
            }
            joined = fold;
            &joined
        };
        let group = if scaled { Group::Estimated(0) } else { Group::Known };
        let folded = fold.finish(group, &settings.adjust)?;
        let (dof, squares) = (folded.dof, folded.sum_of_squares);
        let variance = match scaled {
            true if dof > 0 => Some((squares / dof as f64).max(part.least())),
            true => None,
            false => Some(1.0),
        };
        let mut point = self.reference.clone();
        point.iter_mut().zip(&folded.unknowns.solution).for_each(|(x, dx)| *x += dx);
        let budget_inputs = BudgetInputs {
            known: self.known(fold, &folded)?,
            own: self.priors.is_empty().then_some(&folded.unknowns.cofactor),
            readings: part.fold.triangle(),
            folded: &folded,
            variance,
            dof: if scaled { dof as f64 } else { f64::INFINITY },
            level: settings.level,
        };
        let mut results: Vec<(Option<f64>, Option<Combined>)> = Vec::with_capacity(n + self.derived.len());
        for (j, x) in point.iter().enumerate().take(n) {
            if folded.unknowns.estimable.get(j) == Some(&true) {
                results.push((Some(*x), budget_inputs.combine(&[(j, 1.0)], |_| 0.0, coverage)));
            } else {
                results.push((None, None));
            }
        }
        for tape in &self.derived {
            let mut gradient = vec![0.0; point.len()];
            let value = tape.gradient(&point, &mut Scratch::default(), &mut gradient);
            let finite = value.is_finite() && gradient.iter().all(|c| c.is_finite());
            let along: Vec<(usize, f64)> =
                gradient.iter().copied().enumerate().take(n).filter(|(_, c)| *c != 0.0).collect();
            if finite && determines(&folded, &gradient) {
                let own = |k: usize| gradient.at(k);
                results.push((Some(value), budget_inputs.combine(&along, own, coverage)));
            } else {
                results.push((None, None));
            }
        }
        let limits: Vec<(&str, Conformity)> = template
            .limits
            .iter()
            .filter_map(|limit| {
                let (id, k) = match limit.of {
                    Limited::Parameter(k) => (template.parameters.get(k)?.id.as_str(), k),
                    Limited::Derived(k) => (template.derived.get(k)?.id.as_str(), n + k),
                    // such limits need the ordinary fit
                    Limited::ScaleFactor(_) => return None,
                };
                let (value, own) = *results.get(k)?;
                Some((id, fit::judge(template.decision, limit, value, own.as_ref(), settings.level).0))
            })
            .collect();
        let chi_square_p = if scaled || dof == 0 { None } else { quantiles::chi_square_survival(squares, dof as f64) };
        let mut remarks = Remarks::default();
        if let Some(p) = chi_square_p.filter(|p| *p < 1.0 - settings.level) {
            remarks.global_test(p);
        }
        if !folded.unknowns.not_estimable.is_empty() {
            let names =
                template.estimated().iter().zip(&folded.unknowns.estimable).filter(|(_, estimable)| !**estimable);
            let names: Vec<&str> = names.map(|(p, _)| p.id.as_str()).collect();
            remarks.not_estimable(&names);
        }
        let verdict = if remarks.is_empty() { Verdict::Accepted } else { Verdict::Rejected };
        remarks.limits(&limits);
        let of = |get: &dyn Fn(&Combined) -> f64| -> Vec<f64> {
            results.iter().map(|(_, own)| own.as_ref().map_or(f64::NAN, get)).collect()
        };
        Ok(Row {
            label: label.into(),
            lot: String::new(),
            verdict,
            conformity: limits.iter().map(|(_, own)| *own).max(),
            why: remarks.words(),
            reasons: remarks.reasons(),
            readings: part.fold.rows(),
            rank: folded.unknowns.rank,
            dof,
            value: results.iter().map(|(value, _)| value.unwrap_or(f64::NAN)).collect(),
            u: of(&|own| own.u),
            expanded: of(&|own| own.expanded),
            type_a: of(&|own| own.type_a),
            residual_sd: if dof > 0 { (squares / dof as f64).sqrt() } else { f64::NAN },
            chi_square_p: chi_square_p.unwrap_or(f64::NAN),
            lack_of_fit_p: f64::NAN,
            runs_p: f64::NAN,
            normality_p: f64::NAN,
            suspects: Vec::new(),
            suspect_p: f64::NAN,
            solved: Solved::Alone,
        })
    }

    /// How the unknowns follow each known input that has an uncertainty: `-(dx/dy) df/dp` at the solution.
    fn known(&self, fold: &Fold, folded: &Folded) -> Result<Vec<(usize, Known, Vec<f64>)>> {
        let mut found: Vec<(usize, Known, Vec<f64>)> = Vec::new();
        for (place, carried) in self.carried.iter().enumerate() {
            let share = carried.by.map_or(1.0, |j| folded.unknowns.solution.at(j));
            let Some(follow) = fold.follow(place, &self.settings.adjust)? else { continue };
            if found.last().is_none_or(|(parameter, ..)| *parameter != carried.parameter) {
                found.push((carried.parameter, carried.known, vec![0.0; follow.len()]));
            }
            // there is one: pushed above
            let own = found.last_mut().map(|(.., own)| own.as_mut_slice()).unwrap_or_default();
            own.iter_mut().zip(&follow).for_each(|(c, f)| *c -= share * f);
        }
        Ok(found)
    }
}

/// Do the readings determine a quantity with this gradient?
fn determines(folded: &Folded, gradient: &[f64]) -> bool {
    folded.unknowns.free_directions.iter().all(|direction| {
        let terms = || direction.terms.iter().map(|(k, e)| gradient.at(*k) * e);
        terms().sum::<f64>().abs() <= SAME * terms().map(f64::abs).sum::<f64>()
    })
}

/// What every uncertainty of a device needs.
struct BudgetInputs<'a> {
    known: Vec<(usize, Known, Vec<f64>)>,
    /// The cofactor, where all of it comes from readings.
    own: Option<&'a Mat<f64>>,
    readings: faer::MatRef<'a, f64>,
    folded: &'a Folded,
    variance: Option<f64>,
    dof: f64,
    level: f64,
}

impl BudgetInputs<'_> {
    /// Combined uncertainty of `c . x`, on which a known input acts by itself (`own`) too.
    fn combine(&self, along: &[(usize, f64)], own: impl Fn(usize) -> f64, coverage: &mut Coverage) -> Option<Combined> {
        let of = &self.folded.unknowns.cofactor;
        let cofactor: f64 =
            along.iter().flat_map(|(i, a)| along.iter().map(move |(j, b)| a * b * of[(*i, *j)])).sum::<f64>().max(0.0);
        let share = match self.own {
            Some(_) => cofactor,
            // the readings' rows alone: |R_r C c|^2
            None => {
                let n = of.ncols();
                let t: Vec<f64> = (0..n).map(|i| along.iter().map(|(j, c)| c * of[(i, *j)]).sum()).collect();
                let row =
                    |i: usize| -> f64 { t.iter().enumerate().skip(i).map(|(k, t)| self.readings[(i, k)] * t).sum() };
                (0..n).map(|i| row(i).powi(2)).sum()
            }
        };
        let readings = match self.variance {
            Some(variance) => (share * variance).sqrt(),
            None if cofactor > 0.0 => return None,
            None => 0.0,
        };
        let part = |(parameter, known, c): &(usize, Known, Vec<f64>)| {
            let through: f64 = along.iter().map(|(j, a)| a * c.at(*j)).sum();
            ((own(*parameter) + through).abs() * known.u, known.dof)
        };
        let type_b = self.known.iter().map(|known| part(known).0.powi(2)).sum::<f64>() + (cofactor - share).max(0.0);
        let u = (readings * readings + type_b).sqrt();
        let dof = if type_b > 0.0 || !(u > 0.0) {
            effective_dof(u, std::iter::once((readings, self.dof)).chain(self.known.iter().map(part)))
        } else {
            self.dof
        };
        let coverage_factor = coverage.factor(self.level, dof)?;
        let expanded = coverage_factor * u;
        Some(Combined { u, type_a: readings, type_b: type_b.sqrt(), dof, coverage_factor, expanded })
    }
}

impl Coverage {
    fn factor(&mut self, level: f64, dof: f64) -> Option<f64> {
        if let Some((_, factor)) = self.0.iter().find(|(bits, _)| *bits == dof.to_bits()) {
            return *factor;
        }
        let factor = quantiles::coverage_factor(level, dof);
        if self.0.len() < 16 {
            self.0.push((dof.to_bits(), factor));
        }
        factor
    }
}
