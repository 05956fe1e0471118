//! What the parts of a device say of it: estimates, uncertainties, rank and global test from the triangle.

use super::Row;
use super::answer::{Answer, Coverage, Question};
use super::inputs::Input;
use super::parts::{Part, Parts, PropagatedCalibration};
use super::row::Solved;
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{Fold, Folded, Group, Unknowns};
use crate::fit::{self, Weighting};
use faer::{Mat, MatRef};

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
        let Unknowns { solution, cofactor, .. } = &folded.unknowns;
        let readings = if self.priors.is_empty() { None } else { Some(of_readings(cofactor, part.fold.triangle())) };
        let question = Question {
            campaign: template,
            settings,
            derived: &self.derived,
            reference: &self.reference,
            known: &self.known(fold, &folded)?,
            scaled,
            rank: folded.unknowns.rank,
            dof,
            own_dof: if scaled { dof as f64 } else { f64::INFINITY },
        };
        let answer = Answer {
            label,
            device: None,
            unknowns: Some(&folded.unknowns),
            dx: solution,
            cofactor,
            share: readings.as_ref().unwrap_or(cofactor),
            variance: question.variance(squares, |_| part.least()),
            squares,
            readings: part.fold.rows(),
            largest: 0.0,
            lack_of_fit_p: None,
            runs_p: f64::NAN,
            normality_p: f64::NAN,
            suspects: Vec::new(),
            suspect_p: f64::NAN,
            stuck: Vec::new(),
            solved: Solved::Alone,
        };
        Ok(question.row(answer, coverage))
    }

    /// How the unknowns follow each known input that has an uncertainty: `-(dx/dy) df/dp` at the solution.
    fn known(&self, fold: &Fold, folded: &Folded) -> Result<Vec<Input>> {
        let mut found: Vec<Input> = Vec::new();
        for (place, carried) in self.carried.iter().enumerate() {
            let share = carried.by.map_or(1.0, |j| folded.unknowns.solution.at(j));
            let Some(follow) = fold.follow(place, &self.settings.adjust)? else { continue };
            let PropagatedCalibration { parameter, known, .. } = *carried;
            if found.last().is_none_or(|own| own.index != parameter) {
                found.push(Input { index: parameter, known, base: vec![0.0; follow.len()], slope: Vec::new() });
            }
            // there is one: pushed above
            let own = found.last_mut().map(|own| own.base.as_mut_slice()).unwrap_or_default();
            own.iter_mut().zip(&follow).for_each(|(c, f)| *c -= share * f);
        }
        Ok(found)
    }
}

/// The part of the cofactor matrix that comes from the readings, whose triangle this is: `C R' R C`.
fn of_readings(cofactor: &Mat<f64>, triangle: MatRef<'_, f64>) -> Mat<f64> {
    let n = cofactor.nrows();
    let moved = triangle.subrows(0, n).subcols(0, n) * cofactor;
    moved.transpose() * &moved
}
