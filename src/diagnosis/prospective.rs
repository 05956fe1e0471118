//! Columns of the catalogue at positions where nobody has measured yet: at the schedule, at general positions, at small tilts.

use super::candidates;
use super::candidates::Candidate;
use super::catalogue::Effect;
use super::pool::Pool;
use crate::campaign::{Campaign, JointState, Kind, Reading, Role};
use crate::design::{self, DesignMatrix, Model};
use crate::error::Result;
use crate::estimate;
use crate::plan::{Independent, Noise};
use crate::simulate::Regressor;
use faer::Mat;
use std::collections::HashMap;

/// General positions that are considered in addition to the schedule.
const GENERAL: usize = 24;
/// Small tilts, radians: 100 arcsec.
const SMALL: f64 = 5e-4;

/// Every candidate with its column at the reference point and its size at small tilts; and how many directions a diagnosis would try.
///
/// What vanishes at zero tilts only is tried by a diagnosis all the same, because the fitted tilts are not zero.
pub(super) fn effects(
    campaign: &Campaign,
    catalogue: &[Effect],
    model: &Model,
    design: &DesignMatrix,
    noise: &Noise,
) -> Result<(Vec<(Candidate, f64)>, usize)> {
    let mut point = design.point.clone();
    for (k, (parameter, value)) in campaign.parameters.iter().zip(&mut point).enumerate() {
        if parameter.kind == Kind::Tilt && matches!(parameter.role, Role::Estimated { .. }) {
            *value += SMALL * (1.0 + 0.618_034 * k as f64).sin();
        }
    }
    let tilted = design::assemble(campaign, model, &point)?;
    let independent = Independent::new(campaign, &tilted, noise);
    let estimate = estimate::adjust(&independent.system, &estimate::Settings::default())?;
    let all = columns(campaign, catalogue, model, &tilted)?;
    let rows = independent.u.len();
    let mut matrix = Mat::zeros(rows, all.len());
    for (j, (effect, _)) in all.iter().enumerate() {
        matrix.col_as_slice_mut(j).copy_from_slice(&independent.white(&effect.column));
    }
    // distinct by their scores against numbers of no pattern
    let patternless: Vec<f64> = (0..rows).map(|i| (1.0 + 1.7 * i as f64).sin() + (0.3 * i as f64).cos()).collect();
    let tests = Pool::new(matrix, estimate.factor.thin_q(), &patternless).distinct();
    let mut here: HashMap<(String, Option<usize>), Vec<f64>> = columns(campaign, catalogue, model, design)?
        .into_iter()
        .map(|(effect, _)| ((effect.regressor, effect.sensor), effect.column))
        .collect();
    let effects = all.into_iter().map(|(mut effect, size)| {
        let none = vec![0.0; effect.column.len()];
        // what no reading shows has a column of zeros
        effect.column = here.remove(&(effect.regressor.clone(), effect.sensor)).unwrap_or(none);
        (effect, size)
    });
    Ok((effects.collect(), tests))
}

/// Every candidate with its column at the rows of the design, and its largest value there and at general positions.
fn columns(
    campaign: &Campaign,
    catalogue: &[Effect],
    model: &Model,
    design: &DesignMatrix,
) -> Result<Vec<(Candidate, f64)>> {
    let mut rows: Vec<Reading> = campaign.readings.rows.iter().map(Reading::unread).collect();
    rows.extend(general(campaign));
    let sensors = campaign.bench.sensors.len();
    let wide = campaign.with_readings(crate::campaign::Readings { columns: campaign.readings.columns.clone(), rows });
    let all = design::assemble(&wide, model, &design.point)?;
    let built = candidates::build(
        &wide,
        catalogue,
        model,
        &all,
        all.rows.len(),
        &super::screen::chosen(&wide),
        &mut candidates::Kept::new(),
    )?;
    let keep = |mut candidate: Candidate| {
        let size = candidate.column.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let at = |origin: &design::RowOrigin| candidate.column.get(origin.reading * sensors + origin.sensor);
        // columns were made for every sensor of every reading
        candidate.column = design.rows.iter().map(|o| at(o).copied().unwrap_or_default()).collect();
        (candidate, size)
    };
    // one bad reading has its detectable bias; a wrong prior or constraint is no effect of a position
    // a coefficient that is estimated hides nothing but itself
    let estimated = |c: &Candidate| {
        let of = |sensor: usize| {
            candidates::coefficient(campaign, sensor, &c.kind, |role| matches!(role, Role::Estimated { .. }))
        };
        match c.sensor {
            Some(sensor) => of(sensor).is_some(),
            None => (0..sensors).all(|sensor| of(sensor).is_some()),
        }
    };
    let other = |c: &Candidate| {
        let of_readings = matches!(c.kind, Regressor::Reading(_) | Regressor::Exchange(..));
        let assumed = matches!(c.kind, Regressor::Prior(_) | Regressor::Constraint(_));
        !of_readings && !assumed && is_carried(campaign, c) && !estimated(c)
    };
    Ok(built.into_iter().filter(other).map(keep).collect())
}

/// Is this a harmonic that the angles of the schedule can discriminate, or none at all?
fn is_carried(campaign: &Campaign, candidate: &Candidate) -> bool {
    candidate.harmonic == 0
        || campaign.bench.joints().enumerate().any(|(place, joint)| {
            candidate.regressor.contains(&format!("{joint})"))
                && candidate.harmonic <= super::catalogue::carried(campaign, place)
        })
}

/// Positions at no special angles, with the rates of the schedule: a term that is zero there too is zero everywhere.
fn general(campaign: &Campaign) -> Vec<Reading> {
    let names: Vec<&str> = campaign.bench.joints().collect();
    let rows = &campaign.readings.rows;
    let states: Vec<Vec<JointState>> = (0..names.len())
        .map(|joint| {
            let mut seen: Vec<JointState> = Vec::new();
            for state in rows.iter().filter_map(|r| r.joints.get(joint)) {
                let held = matches!(state, JointState::Held { .. });
                if !seen.iter().any(|s| s == state || (held && matches!(s, JointState::Held { .. }))) {
                    seen.push(*state);
                }
            }
            seen
        })
        .collect();
    if names.is_empty() || rows.is_empty() {
        return Vec::new();
    }
    let mut general = Vec::with_capacity(GENERAL);
    for k in 0..GENERAL {
        let state = |(joint, options): (usize, &Vec<JointState>)| {
            // golden-ratio angles never repeat; the states of each joint are visited in order
            let angle_deg = 360.0 * ((k + 1) as f64 * 0.618_034 * (joint + 1) as f64 + 0.113).fract();
            match options.get((k / (joint + 1)) % options.len().max(1)) {
                None | Some(JointState::Held { .. }) => JointState::Held { angle_deg },
                Some(other) => *other,
            }
        };
        let joints: Vec<JointState> = states.iter().enumerate().map(state).collect();
        let Some(like) = rows.get(k % rows.len()) else { continue };
        let reading = campaign.readings.position(&names, like, joints);
        if reading.check_turning(&names).is_ok() {
            general.push(reading);
        }
    }
    general
}
