//! The row of one device of a common schedule, from the products and sums of the eight that it is one of.

use super::common::{Common, Found, Scratch};
use super::inputs::Input;
use super::replicates::{runs_of, runs_p};
use super::row::{Solved, Verdict, chi_square_words, remarks};
use super::{Device, Row};
use crate::algebra::Scratch as TapeScratch;
use crate::campaign::Limited;
use crate::fit::{self, resolution};
use crate::quality::{self, Whitened};
use crate::uncertainty::{Combined, effective_dof, quantiles};
use faer::Mat;

/// Share of a threshold within which the exact probability decides.
const SLACK: f64 = 1e-6;

impl Common {
    pub(super) fn row(
        &self,
        device: &Device,
        map: Option<&[usize]>,
        (dx, v): (&[f64], &[f64]),
        found: &Found,
        work: &mut Scratch,
    ) -> Option<Row> {
        let Common { estimate, settings, campaign, .. } = self;
        let (dof, level, squares) = (estimate.dof, settings.level, found.squares);
        if found.sizes.most > fit::MOST || found.sizes.least < fit::LEAST {
            return None;
        }
        if !(squares.is_finite() && dx.iter().all(|x| x.is_finite())) {
            return None;
        }
        let variance = match self.scaled {
            true if dof > 0 => {
                let own = squares / dof as f64;
                Some(own.max(self.least(device, map, own, found.sizes.weighed)))
            }
            true => None,
            false => Some(1.0),
        };
        let mut point = self.reference.clone();
        point.iter_mut().zip(dx).for_each(|(x, dx)| *x += dx);
        let known: Vec<Vec<f64>> = self.known.iter().map(|input| input.sensitivity(dx)).collect();
        let n = dx.len();
        let count = n + self.derived.len();
        let [mut value, mut u, mut expanded, mut type_a] = [(); 4].map(|()| Vec::with_capacity(count));
        let mut results: Vec<Option<Combined>> = Vec::with_capacity(if campaign.limits.is_empty() { 0 } else { count });
        let mut say = |found: Option<f64>, own: Option<Combined>| {
            value.push(found.unwrap_or(f64::NAN));
            u.push(own.map_or(f64::NAN, |c| c.u));
            expanded.push(own.map_or(f64::NAN, |c| c.expanded));
            type_a.push(own.map_or(f64::NAN, |c| c.type_a));
            if !campaign.limits.is_empty() {
                results.push(own);
            }
        };
        for (j, x) in point.iter().take(n).enumerate() {
            let through = |k: usize| known.get(k).and_then(|c| c.get(j)).copied().unwrap_or_default();
            say(Some(*x), self.combine([estimate.cofactor[(j, j)], self.share[(j, j)]], variance, through, work));
        }
        for tape in &self.derived {
            let mut gradient = vec![0.0; point.len()];
            let own = tape.gradient(&point, &mut TapeScratch::default(), &mut gradient);
            if !(own.is_finite() && gradient.iter().all(|c| c.is_finite())) {
                say(None, None);
                continue;
            }
            let along = gradient.get(..n).unwrap_or_default();
            let form = |of: &Mat<f64>| -> f64 {
                let terms = || along.iter().enumerate().filter(|(_, c)| **c != 0.0);
                terms().map(|(i, a)| terms().map(|(j, b)| a * b * of[(i, j)]).sum::<f64>()).sum::<f64>().max(0.0)
            };
            let through = |k: usize| {
                let own = self.known.get(k).and_then(|input| gradient.get(input.index)).copied().unwrap_or_default();
                own + known.get(k).map_or(0.0, |c| along.iter().zip(c).map(|(a, c)| a * c).sum())
            };
            say(Some(own), self.combine([form(&estimate.cofactor), form(&self.share)], variance, through, work));
        }
        let limits: Vec<(&str, fit::Conformity)> = campaign
            .limits
            .iter()
            .filter_map(|limit| {
                let (id, k) = match limit.of {
                    Limited::Parameter(k) => (campaign.parameters.get(k)?.id.as_str(), k),
                    Limited::Derived(k) => (campaign.derived.get(k)?.id.as_str(), n + k),
                };
                let found = value.get(k).copied().filter(|x| !x.is_nan());
                let own = results.get(k).copied().flatten();
                Some((id, fit::judge(campaign.decision, limit, found, own.as_ref(), level).0))
            })
            .collect();
        let chi_square_p = match self.scaled {
            false if dof > 0 => quantiles::chi_square_survival(squares, dof as f64),
            _ => None,
        };
        let rejected = chi_square_p.is_some_and(|p| p < 1.0 - level);
        let lack_of_fit_p = self.cells.lack_of_fit(v, &mut work.cell_sums);
        let suspects = self.suspects(v, found, map);
        let mut why = Vec::new();
        if let Some(p) = chi_square_p.filter(|_| rejected) {
            why.push(chi_square_words(p));
        }
        remarks(&mut why, &suspects, lack_of_fit_p.filter(|p| *p < 1.0 - level), &limits);
        Some(Row {
            label: device.label.clone(),
            lot: String::new(),
            verdict: if rejected { Verdict::Rejected } else { Verdict::Accepted },
            conformity: limits.iter().map(|(_, own)| *own).max(),
            why: why.join("; "),
            readings: self.places.len(),
            rank: estimate.rank,
            dof,
            residual_sd: if dof > 0 { (squares / dof as f64).sqrt() } else { f64::NAN },
            chi_square_p: chi_square_p.unwrap_or(f64::NAN),
            lack_of_fit_p: lack_of_fit_p.unwrap_or(f64::NAN),
            runs_p: match found.runs {
                Some((positive, runs)) => runs_of(positive, self.gain.len() - positive, runs),
                None => self.runs(v, map),
            },
            normality_p: found.normality.unwrap_or_else(|| self.normality(v, work)),
            suspects,
            solved: Solved::Together,
            value,
            u,
            expanded,
            type_a,
        })
    }

    /// Combined uncertainty of a quantity with this cofactor (and the readings' share of it), as a budget of readings, priors and known inputs says.
    fn combine(
        &self,
        [cofactor, share]: [f64; 2],
        variance: Option<f64>,
        through: impl Fn(usize) -> f64,
        work: &mut Scratch,
    ) -> Option<Combined> {
        let readings = match variance {
            Some(variance) => (share * variance).sqrt(),
            // the scatter of the readings has a part in it, and is not known
            None if cofactor > 0.0 => return None,
            None => 0.0,
        };
        let own_dof = if self.scaled {
            self.estimate.group_redundancy.first().copied().unwrap_or_default()
        } else {
            f64::INFINITY
        };
        let part = |k: usize, input: &Input| (through(k).abs() * input.known.u, input.known.dof);
        let inputs = || self.known.iter().enumerate().map(|(k, input)| part(k, input));
        // priors stand beside readings of stated uncertainty only, so that no scale multiplies them
        let type_b = inputs().map(|(u, _)| u * u).sum::<f64>() + (cofactor - share).max(0.0);
        let u = (readings * readings + type_b).sqrt();
        let dof = if type_b > 0.0 || !(u > 0.0) {
            effective_dof(u, std::iter::once((readings, own_dof)).chain(inputs()))
        } else if own_dof.is_finite() {
            own_dof
        } else {
            f64::INFINITY
        };
        let bits = dof.to_bits();
        let coverage_factor = match work.factors.iter().find(|(own, _)| *own == bits) {
            Some((_, factor)) => *factor,
            None => {
                let factor = quantiles::coverage_factor(self.settings.level, dof);
                if work.factors.len() < 8 {
                    work.factors.push((bits, factor));
                }
                factor
            }
        }?;
        Some(Combined {
            u,
            type_a: readings,
            type_b: type_b.sqrt(),
            dof,
            coverage_factor,
            expanded: coverage_factor * u,
        })
    }

    /// The square of the scale that the rounding of the readings alone would have, where that can matter.
    fn least(&self, device: &Device, map: Option<&[usize]>, variance: f64, weighed: f64) -> f64 {
        let values = || {
            self.places.iter().map(|(row, slot)| {
                let row = map.and_then(|map| map.get(*row)).unwrap_or(row);
                device.values.get(row * self.sensors + slot).copied().unwrap_or_default()
            })
        };
        let arithmetic = (2.0 * f64::EPSILON * weighed).powi(2);
        // a last place this coarse would matter; all readings are whole numbers of it, or it is none
        let coarse = variance.sqrt() * 12f64.sqrt() * self.largest_u;
        let places = coarse.log10().ceil();
        let unit = if places <= 0.0 { 10f64.powf(-places) } else { 0.0 };
        let whole = |y: f64| {
            let count = y * unit;
            (count - count.round()).abs() <= 1e-6 * count.abs().max(1.0)
        };
        if !(coarse > 0.0) || (unit > 0.0 && places > -14.0 && values().all(whole)) {
            let step = resolution(values()).unwrap_or(0.0);
            return arithmetic.max((step / 12f64.sqrt() / self.largest_u).powi(2));
        }
        arithmetic
    }

    /// Suspicious readings, counted from 1 among the device's rows.
    fn suspects(&self, v: &[f64], found: &Found, map: Option<&[usize]>) -> Vec<usize> {
        let Some(threshold) = self.threshold else { return Vec::new() };
        let (squares, best) = (found.squares, found.gain);
        let statistic = if self.scaled {
            let rest = (squares - best).max(0.0) / (self.estimate.dof as f64 - 1.0);
            if rest > 0.0 { best / rest } else { f64::INFINITY }
        } else {
            best
        };
        if statistic < threshold * (1.0 - SLACK) || best == 0.0 {
            return Vec::new();
        }
        let factor = &self.estimate.factor;
        let whitened = Whitened::independent(factor.thin_q(), factor.weight(), v, self.estimate.dof, !self.scaled);
        let found = quality::snoop(&whitened, self.places.len(), self.settings.level);
        let reading = |row: usize| {
            let (row, _) = self.places.get(row)?;
            Some(map.and_then(|map| map.get(*row)).unwrap_or(row) + 1)
        };
        found.iter().flat_map(|found| &found.suspects).filter_map(|suspect| reading(suspect.row)).collect()
    }

    /// The smallest probability of the runs tests of the sensors, in the device's own order of rows.
    fn runs(&self, v: &[f64], map: Option<&[usize]>) -> f64 {
        let mut least = f64::NAN;
        for sensor in 0..self.campaign.bench.sensors.len() {
            let own = || self.sensor.iter().zip(v).enumerate().filter(|(_, (s, _))| **s == sensor);
            let p = match map {
                None => runs_p(own().map(|(_, (_, v))| *v)),
                Some(map) => {
                    let mut sorted: Vec<(usize, f64)> = own()
                        .map(|(i, (_, v))| {
                            (self.places.get(i).and_then(|(row, _)| map.get(*row)).copied().unwrap_or(i), *v)
                        })
                        .collect();
                    sorted.sort_by_key(|(row, _)| *row);
                    runs_p(sorted.into_iter().map(|(_, v)| v))
                }
            };
            least = least.min(p);
        }
        least
    }

    fn normality(&self, v: &[f64], work: &mut Scratch) -> f64 {
        let Some(scores) = &self.scores else { return f64::NAN };
        work.ordered.clear();
        work.ordered.extend(self.studentizing.iter().filter_map(|(i, factor)| v.get(*i).map(|v| v * factor)));
        scores.test(&mut work.ordered).map_or(f64::NAN, |test| test.p)
    }
}
