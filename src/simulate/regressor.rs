//! What an effect is proportional to: a term of the model line, or a property of a reading that is no input.

use super::is_tilt;
use crate::algebra::Expression;
use crate::bench::Sensor;
use crate::campaign::{Campaign, Role, coefficient_unit};
use crate::design::SensorModel;
use crate::error::{Fault, Malformed, Result};

/// The factor by which the coefficient of an effect is multiplied.
#[derive(Debug, Clone, PartialEq)]
pub enum Regressor {
    /// A term of inputs: `a_S`, `gamma_deg_s*cos(2*beta)`, `step(time_s-1200)`.
    Term(Expression),
    /// A tilt of the chain, by parameter index; common to all sensors.
    Tilt(usize),
    /// The error of a known parameter, by its index.
    Known(usize),
    /// 1 at the readings of one position: remounting.
    Position(String),
    /// 1 at one reading, by index from 0.
    Reading(usize),
    /// +1 where a joint was last moved forward, -1 where backward, by joint index.
    Approach(usize),
    /// The values of two readings exchanged, by index: +1 at the first, -1 at the second.
    Exchange(usize, usize),
    /// How fast a column changes with time (`sense` false), or whether it rises or falls (+1, -1), by column index.
    Change {
        /// Index of the column.
        column: usize,
        /// Only its sign.
        sense: bool,
    },
    /// The error of a prior, by parameter index. Only a diagnosis has it.
    Prior(usize),
    /// What a constraint forbids, by its index. Only a diagnosis has it.
    Constraint(usize),
    /// Positions that scatter: no column. Only a diagnosis has it.
    Scatter,
}

impl Regressor {
    /// The unit of its coefficient: radians for a tilt, else the unit that follows from the sensor's line with the term, where the coefficient has this
    /// name; `None` where that is open.
    pub(crate) fn unit(&self, campaign: &Campaign, sensor: Option<usize>, coefficient: &str) -> Option<String> {
        let sensor = sensor.and_then(|k| campaign.bench.sensors.get(k));
        match self {
            Regressor::Tilt(k) | Regressor::Known(k) | Regressor::Prior(k) => {
                campaign.parameters.get(*k).map(|p| p.unit.clone())
            }
            Regressor::Term(line) => {
                let model = Expression::parse(coefficient).ok()?.times(line);
                let mut bench = campaign.bench.clone();
                bench.sensors = vec![Sensor { model, ..sensor.or(campaign.bench.sensors.first())?.clone() }];
                coefficient_unit(&bench, &campaign.readings.columns, coefficient)
            }
            _ => sensor.map(|s| s.unit.clone()),
        }
    }

    /// Read a regressor as reports write it: a term, or `tilt:ID`, `known:ID`, `position:LABEL`, `reading:N` (from 1),
    /// `exchange:N:M`, `approach:JOINT`, `rate:COLUMN` (per second, or per reading without time_s), `sense:COLUMN`.
    ///
    /// A term is bound to `sensor`, or to every sensor of the bench. Errors: a term that does not parse (with its span), unknown names.
    pub fn parse(campaign: &Campaign, sensor: Option<usize>, text: &str) -> Result<Self> {
        let unknown = |what: &str, name: &str, list: Vec<&str>| {
            Malformed::unknown(format!("there is no {what} '{name}'"), name, list)
        };
        match text.split_once(':') {
            None => {
                let line = Expression::parse(text)?;
                for (k, entry) in campaign.bench.sensors.iter().enumerate() {
                    if sensor.is_none_or(|wanted| wanted == k) {
                        SensorModel::bind(campaign, entry, &line)?;
                    }
                }
                Ok(Regressor::Term(line))
            }
            Some(("tilt", id)) => match campaign.parameter_index(id).filter(|k| is_tilt(campaign, *k)) {
                Some(k) => Ok(Regressor::Tilt(k)),
                None => Err(unknown("tilt", id, campaign.bench.tilts().collect())),
            },
            Some(("known", id)) => match campaign.parameter_index(id) {
                Some(k) if campaign.parameters.get(k).is_some_and(|p| matches!(p.role, Role::Known(_))) => {
                    Ok(Regressor::Known(k))
                }
                _ => {
                    let known = campaign.parameters.iter().filter(|p| matches!(p.role, Role::Known(_)));
                    Err(unknown("known parameter", id, known.map(|p| p.id.as_str()).collect()))
                }
            },
            Some(("position", label)) => {
                if campaign.readings.rows.iter().any(|reading| reading.position == label) {
                    return Ok(Regressor::Position(label.to_string()));
                }
                Err(Malformed::new(Fault::UnknownName, format!("no reading has the position '{label}'"))
                    .expected("a label that readings have"))
            }
            Some(("reading", number)) => match number.trim().parse::<usize>() {
                Ok(n) if (1..=campaign.readings.rows.len()).contains(&n) => Ok(Regressor::Reading(n - 1)),
                _ => Err(Malformed::new(Fault::Value, format!("there is no reading '{number}'"))
                    .expected(format!("a number from 1 to {}", campaign.readings.rows.len()))),
            },
            Some(("exchange", pair)) => {
                let rows = campaign.readings.rows.len();
                let number = |text: &str| text.trim().parse::<usize>().ok().filter(|n| (1..=rows).contains(n));
                match pair.split_once(':').and_then(|(a, b)| Some((number(a)?, number(b)?))).filter(|(a, b)| a != b) {
                    Some((a, b)) => Ok(Regressor::Exchange(a - 1, b - 1)),
                    None => Err(Malformed::new(Fault::Value, format!("there are no two readings '{pair}'"))
                        .expected(format!("two numbers from 1 to {rows}, as in exchange:3:7"))),
                }
            }
            Some((kind @ ("rate" | "sense"), name)) => {
                match campaign.readings.columns.iter().position(|column| column == name) {
                    Some(column) => Ok(Regressor::Change { column, sense: kind == "sense" }),
                    None => {
                        let columns = campaign.readings.columns.iter().map(String::as_str).collect();
                        Err(unknown("column", name, columns))
                    }
                }
            }
            Some(("approach", joint)) => match campaign.bench.joints().position(|name| name == joint) {
                Some(k) => Ok(Regressor::Approach(k)),
                None => Err(unknown("joint", joint, campaign.bench.joints().collect())),
            },
            Some((kind, _)) => Err(Malformed::new(Fault::Value, format!("'{kind}:' is not a kind of effect"))
                .expected(
                    "a term of inputs, or tilt:, known:, position:, reading:, exchange:, approach:, rate:, sense:",
                )
                .found(format!("'{text}'"))),
        }
    }
}
