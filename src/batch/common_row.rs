//! The row of one device of a common schedule, from the products and sums of the eight that it is one of.

use super::answer::{Answer, Question, least_variance};
use super::common::{Common, Found, Scratch};
use super::replicates::{runs_of, runs_p};
use super::row::Solved;
use super::{Device, Row};
use crate::elements::OrNan;
use crate::fit;
use crate::quality::{self, Whitened};

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
        let (estimate, squares) = (&self.estimate, found.squares);
        if found.sizes.most > fit::MOST || found.sizes.least < fit::LEAST {
            return None;
        }
        if !(squares.is_finite() && dx.iter().all(|x| x.is_finite())) {
            return None;
        }
        let own_dof =
            // no group, no degrees of freedom
            if self.scaled { estimate.group_redundancy.first().copied().unwrap_or_default() } else { f64::INFINITY };
        let question = Question {
            campaign: &self.campaign,
            settings: &self.settings,
            derived: &self.derived,
            reference: &self.reference,
            known: &self.known,
            scaled: self.scaled,
            rank: estimate.unknowns.rank,
            dof: estimate.dof,
            own_dof,
        };
        let values = || {
            self.places.iter().map(|(row, slot)| {
                // without a map the rows are in the schedule's order
                let row = map.and_then(|map| map.get(*row)).unwrap_or(row);
                device.values.or_nan(row * self.sensors + slot)
            })
        };
        let (suspects, suspect_p) = self.suspects(v, found, map);
        let value = |i: usize| {
            let (row, slot) = self.places.get(i)?;
            let row = map.and_then(|map| map.get(*row)).unwrap_or(row);
            device.values.get(row * self.sensors + slot).copied()
        };
        let stuck =
            |own: &fit::Channel| Some((own.sensor, own.stuck(|i| value(i).unwrap_or(f64::NAN), |i| v.or_nan(i))?));
        let least = |own| least_variance(values, (own, found.sizes.weighed, self.largest_u));
        let answer = Answer {
            label: &device.label,
            device: Some(device),
            unknowns: None,
            dx,
            cofactor: &estimate.unknowns.cofactor,
            share: &self.share,
            variance: question.variance(squares, least),
            squares,
            readings: self.places.len(),
            largest: found.sizes.weighed,
            lack_of_fit_p: match &self.offsets {
                Some(offsets) => offsets.test(v, self.settings.level).map(|test| test.p),
                None => self.cells.lack_of_fit(v, &mut work.cell_sums),
            },
            runs_p: match found.runs {
                Some((positive, runs)) => runs_of(positive, self.gain.len() - positive, runs),
                None => self.runs(v, map),
            },
            normality_p: found.normality.unwrap_or_else(|| self.normality(v, work)),
            suspects,
            suspect_p,
            stuck: self.channels.iter().filter_map(stuck).collect(),
            solved: Solved::Together,
        };
        Some(question.row(answer, &mut work.memory))
    }

    /// Suspicious readings, counted from 1 among the device's rows, and the probability of the most significant.
    fn suspects(&self, v: &[f64], found: &Found, map: Option<&[usize]>) -> (Vec<usize>, f64) {
        let none = (Vec::new(), f64::NAN);
        let Some(threshold) = self.threshold else { return none };
        if !may_be_suspicious((found.squares, found.gain), self.estimate.dof, self.scaled, threshold) {
            return none;
        }
        let factor = &self.estimate.factor;
        let whitened = Whitened::independent(
            factor.thin_q(),
            factor.weight(),
            v,
            found.sizes.weighed,
            self.estimate.dof,
            !self.scaled,
        );
        let found = quality::snoop(&whitened, self.places.len(), self.settings.level);
        let reading = |row: usize| {
            let (row, _) = self.places.get(row)?;
            // without a map the rows are in the schedule's order
            Some(map.and_then(|map| map.get(*row)).unwrap_or(row) + 1)
        };
        let suspects = || found.iter().flat_map(|found| &found.suspects);
        let least = suspects().map(|suspect| suspect.p).fold(f64::NAN, f64::min);
        (suspects().filter_map(|suspect| reading(suspect.row)).collect(), least)
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
                            // places are of rows that the map has
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

/// Can the reading with the largest gain be suspicious? Of sums of squares near the threshold the exact probability decides.
pub(super) fn may_be_suspicious((squares, best): (f64, f64), dof: usize, scaled: bool, threshold: f64) -> bool {
    let statistic = if scaled {
        let rest = (squares - best).max(0.0) / (dof as f64 - 1.0);
        if rest > 0.0 { best / rest } else { f64::INFINITY }
    } else {
        best
    };
    !(statistic < threshold * (1.0 - SLACK) || best == 0.0)
}
