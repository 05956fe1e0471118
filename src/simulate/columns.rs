//! Regressors as columns: one value for each row, averaged over turns like the model line itself.

use super::Regressor;
use crate::campaign::{Campaign, JointState, Reading};
use crate::design::{Context, Kinematics, Node, RowOrigin, SensorModel, Smoothness, Workspace, kinematics, nodes};
use crate::elements::{Elements, numbered};
use crate::error::{Fault, Malformed, Result};

/// Nodes of one turn for terms with kinks or jumps: a column needs no more than four digits.
const ROUGH: Smoothness = Smoothness::Trigonometric(63);

/// Kinematics at the instants of every reading, computed once for each distinct state of the joints.
#[derive(Debug)]
pub struct Table<'a> {
    campaign: &'a Campaign,
    tilts: &'a [f64],
    point: &'a [f64],
    /// Index of the distinct state of each reading.
    state: Vec<usize>,
    /// A reading that has the state, and the instants computed so far.
    states: Vec<(&'a Reading, Vec<Instants>)>,
    /// Where the chain was last: most rotations stay from one instant to the next.
    at: Kinematics,
    work: Workspace,
}

/// The instants that one smoothness needs.
type Instants = (Smoothness, Vec<(Node, Kinematics)>);

impl<'a> Table<'a> {
    /// Prepare the readings of a campaign; tilts in chain order, `point` in parameter order.
    pub fn new(campaign: &'a Campaign, tilts: &'a [f64], point: &'a [f64]) -> Self {
        let rows = &campaign.readings.rows;
        let (state, _) = numbered(rows.iter().map(|row| row.joints.iter().map(JointState::bits).collect::<Vec<_>>()));
        let mut states: Vec<(&Reading, Vec<Instants>)> = Vec::new();
        for (reading, number) in rows.iter().zip(&state) {
            states.extend((*number == states.len()).then(|| (reading, Vec::new())));
        }
        Table { campaign, tilts, point, state, states, at: Kinematics::default(), work: Workspace::default() }
    }

    /// A term's column for one sensor: its mean at each row of that sensor, zero at the others. `None` where a reading lacks a column.
    pub fn term(
        &mut self,
        sensor: usize,
        line: &crate::algebra::Expression,
        rows: &[RowOrigin],
    ) -> Result<Option<Vec<f64>>> {
        let Some(entry) = self.campaign.bench.sensors.get(sensor) else { return Ok(None) };
        let bound = SensorModel::bind(self.campaign, entry, line)?;
        let names = line.names();
        let readings = &self.campaign.readings;
        let used: Vec<usize> = (0..readings.columns.len())
            .filter(|k| readings.columns.get(*k).is_some_and(|c| names.contains(&c.as_str())))
            .collect();
        let of_joint = |column: &String| self.campaign.bench.is_of_joint(column);
        let by_state = used.iter().all(|k| readings.columns.get(*k).is_some_and(of_joint));
        let mut known: Vec<Option<f64>> = vec![None; self.states.len()];
        let mut column = Vec::with_capacity(rows.len());
        for origin in rows {
            let (Some(reading), Some(&state)) = (readings.rows.get(origin.reading), self.state.get(origin.reading))
            else {
                return Ok(None);
            };
            if origin.sensor != sensor {
                column.push(0.0);
                continue;
            }
            if used.iter().any(|k| reading.columns.get(*k).copied().flatten().is_none()) {
                return Ok(None);
            }
            if let Some(value) = known.get(state).copied().flatten().filter(|_| by_state) {
                column.push(value);
                continue;
            }
            let smoothness = match bound.smoothness_for(&reading.joints) {
                Smoothness::Trigonometric(degree) => Smoothness::Trigonometric(degree),
                _ => ROUGH,
            };
            let value = self.mean(state, smoothness, reading, &bound);
            if let Some(slot) = known.get_mut(state) {
                *slot = Some(value);
            }
            column.push(value);
        }
        Ok(Some(column))
    }

    fn mean(&mut self, state: usize, smoothness: Smoothness, reading: &Reading, bound: &SensorModel) -> f64 {
        let Some((like, computed)) = self.states.get_mut(state) else { return 0.0 };
        if !computed.iter().any(|(known, _)| *known == smoothness) {
            let mut instants = Vec::new();
            for node in nodes(like, smoothness) {
                kinematics(&self.campaign.bench, self.tilts, &node.instant, &mut self.at);
                let inputs = self.at.inputs();
                instants.push((node, inputs));
            }
            computed.push((smoothness, instants));
        }
        let Some((_, instants)) = computed.iter().find(|(known, _)| *known == smoothness) else { return 0.0 };
        let mut mean = 0.0;
        for (node, kinematics) in instants {
            let context = Context { kinematics, instant: &node.instant, columns: &reading.columns, point: self.point };
            mean += node.weight * bound.value_at(&context, &mut self.work);
        }
        mean
    }
}

/// The columns of several regressors, `rows` long each; `Tilt` and `Known` have none here (they are derivatives of the model) and give zeros.
///
/// Errors: a term that uses a column which a reading lacks.
pub fn columns(
    campaign: &Campaign,
    rows: &[RowOrigin],
    tilts: &[f64],
    point: &[f64],
    wanted: &[(&Regressor, Option<usize>)],
) -> Result<Vec<Vec<f64>>> {
    let mut table = Table::new(campaign, tilts, point);
    wanted
        .iter()
        .map(|(regressor, sensor)| {
            let mut sum = vec![0.0; rows.len()];
            for k in 0..campaign.bench.sensors.len() {
                if sensor.is_some_and(|wanted| wanted != k) {
                    continue;
                }
                let column = match regressor {
                    Regressor::Term(line) => table.term(k, line, rows)?.ok_or_else(|| {
                        Malformed::new(
                            Fault::Missing,
                            format!("the effect '{line}' uses a column that a reading lacks"),
                        )
                        .expected("that column in every reading")
                    })?,
                    other => indicator(campaign, rows, other, k),
                };
                sum.iter_mut().zip(column).for_each(|(sum, value)| *sum += value);
            }
            Ok(sum)
        })
        .collect()
}

/// The column of a regressor that is no function of inputs, for one sensor.
pub(crate) fn indicator(campaign: &Campaign, rows: &[RowOrigin], regressor: &Regressor, sensor: usize) -> Vec<f64> {
    let value: Box<dyn Fn(usize) -> f64> = match regressor {
        Regressor::Position(label) => Box::new(|k: usize| {
            f64::from(campaign.readings.rows.get(k).is_some_and(|reading| reading.position == *label))
        }),
        Regressor::Reading(n) => Box::new(move |k| f64::from(k == *n)),
        Regressor::Exchange(a, b) => Box::new(move |k| f64::from(k == *a) - f64::from(k == *b)),
        Regressor::Change { column, sense } => {
            let slopes = slopes(campaign, *column);
            let of = move |slope: f64| match (sense, slope == 0.0) {
                (true, true) => 0.0,
                (true, false) => slope.signum(),
                _ => slope,
            };
            Box::new(move |k| of(slopes.at(k)))
        }
        Regressor::Approach(joint) => {
            let senses = senses(campaign, *joint);
            Box::new(move |k| senses.at(k))
        }
        Regressor::Term(_)
        | Regressor::Tilt(_)
        | Regressor::Known(_)
        | Regressor::Prior(_)
        | Regressor::Constraint(_)
        | Regressor::Scatter => Box::new(|_| 0.0),
    };
    rows.iter().map(|origin| if origin.sensor == sensor { value(origin.reading) } else { 0.0 }).collect()
}

/// How fast a column changes at each reading: between the readings before and after, per second, or per reading where there is no time; 0
/// where the column or the time is missing, or the time does not change.
fn slopes(campaign: &Campaign, column: usize) -> Vec<f64> {
    let time = campaign.readings.columns.iter().position(|name| name == "time_s");
    let rows = &campaign.readings.rows;
    let value = |k: usize| rows.get(k).and_then(|row| row.columns.get(column).copied().flatten());
    let at = |k: usize| match time {
        Some(time) => rows.get(k).and_then(|row| row.columns.get(time).copied().flatten()),
        None => Some(k as f64),
    };
    let last = rows.len().saturating_sub(1);
    let slope = |k: usize| {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(last));
        let slope = (value(after)? - value(before)?) / (at(after)? - at(before)?);
        slope.is_finite().then_some(slope)
    };
    // a neighbour without value or time: no slope is known, and the effect is zero there
    (0..rows.len()).map(|k| slope(k).unwrap_or(0.0)).collect()
}

/// For each reading, the sense in which a held joint was last moved (the shorter way round); 0 before its first move.
fn senses(campaign: &Campaign, joint: usize) -> Vec<f64> {
    let (mut before, mut sense) = (None, 0.0);
    let angle = |reading: &Reading| reading.joints.get(joint)?.held_deg();
    campaign
        .readings
        .rows
        .iter()
        .map(|reading| {
            let here = angle(reading);
            if let (Some(from), Some(to)) = (before, here) {
                let turn: f64 = to - from;
                let short = turn - 360.0 * (turn / 360.0).round();
                if turn != 0.0 && short != 0.0 {
                    sense = if short.abs() == 180.0 { turn.signum() } else { short.signum() };
                }
            }
            before = here.or(before);
            sense
        })
        .collect()
}
