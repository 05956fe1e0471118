//! Readings from a truth: exact rotations, means over turns, hidden effects, seeded noise.
//!
//! ```text
//! reading_i = f(inputs_i; true values) + sum_e c_e g_e,i + sum_k d_k,l(i) df/d_k + sd / sqrt(n_i) * z_i,   z_i ~ N(0, 1), seeded
//! ```
//!
//! `f` is the bench's model line at the true tilts, `g_e` the regressor of a hidden effect at the same instants. The truth stays apart
//! from the campaign that comes out; `d_k` are the deviations of the campaign's lines of scatter. Deliberately absent: quantisation other than
//! rounding to decimals.

mod columns;
mod deviations;
mod regressor;

pub use columns::Table;
pub(crate) use columns::{columns, indicator};
pub(crate) use deviations::TrueScatter;
pub use regressor::Regressor;

use crate::campaign::{Campaign, Kind, Observation, Shared, is_axis_input};
use crate::design::{self, Model};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

/// What readings are made from.
#[derive(Debug, Clone)]
pub struct Truth {
    /// True value of every parameter, in the campaign's order; radians for tilts.
    pub point: Vec<f64>,
    /// Noise of each sensor, in the bench's order.
    pub noise: Vec<DrawnNoise>,
    /// Effects that the model line does not have.
    pub effects: Vec<Hidden>,
    /// Sizes of the campaign's lines of scatter where they are not those that it states.
    pub scatter: Vec<TrueScatter>,
}

/// Noise of one sensor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DrawnNoise {
    /// Standard deviation of one sample, in the sensor's unit: a reading that averages `n` has `sd / sqrt(n)`.
    pub sd: f64,
    /// Is it written into the campaign as the readings' standard uncertainty?
    pub stated: bool,
    /// Decimals that readings are rounded to, if any.
    pub decimals: Option<u32>,
}

/// A hidden effect: `coefficient * regressor`.
#[derive(Debug, Clone)]
pub struct Hidden {
    /// The factor of the coefficient.
    pub regressor: Regressor,
    /// Coefficient, in the sensor's unit for each unit of the regressor; radians for a tilt.
    pub value: f64,
    /// The sensor that has it; `None` for all.
    pub sensor: Option<usize>,
}

impl Hidden {
    /// Check a hidden effect against a campaign.
    ///
    /// Errors: a term that does not parse, or a name that this bench and these readings do not have.
    pub fn new(campaign: &Campaign, regressor: &str, value: f64, sensor: Option<usize>) -> Result<Self> {
        Ok(Hidden { regressor: Regressor::parse(campaign, sensor, regressor)?, value, sensor })
    }

    /// The unit of its coefficient; `None` where that is open.
    pub(crate) fn unit(&self, campaign: &Campaign) -> Option<String> {
        let sensor = self.sensor.or((campaign.bench.sensors.len() == 1).then_some(0));
        self.regressor.unit(campaign, sensor, "its_coefficient")
    }
}

/// Fill a schedule with readings. Values that it has are replaced.
///
/// Errors: a model line or effect that uses a column which a reading lacks; readings that leave the range of a double.
///
/// ```
/// use tumble::{simulate, wire};
/// let text = r#"{ "bench": "accelerometer-plumb-plane", "known": { "kI": { "value": 1.299 } },
///     "estimate": { "V0": {} }, "readings": [ { "beta_deg": [0, 90] } ] }"#;
/// let schedule = wire::read_campaign(&wire::Source { name: "s".into(), text: text.into() }, &mut |_| unreachable!())?;
/// let truth = r#"{ "values": { "V0": { "value": 0.002 } }, "effects": [ { "regressor": "a_O", "value": 0.5 } ] }"#;
/// let truth = wire::read_truth(&wire::Source { name: "t".into(), text: truth.into() }, &schedule)?;
/// let campaign = simulate::simulate(&schedule, &truth, 1)?;
/// assert!((campaign.readings.rows[0].observations[0].value - 0.502).abs() < 1e-15);
/// assert!((campaign.readings.rows[1].observations[0].value - 0.002).abs() < 1e-15);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn simulate(schedule: &Campaign, truth: &Truth, seed: u64) -> Result<Campaign> {
    let mut point = truth.point.clone();
    for hidden in &truth.effects {
        if let Regressor::Tilt(k) | Regressor::Known(k) = hidden.regressor
            && let Some(value) = point.get_mut(k)
        {
            *value += hidden.value;
        }
    }
    let mut campaign = schedule.clone();
    for reading in &mut campaign.readings.rows {
        *reading = reading.unread();
    }
    // the campaign has the stated values of its inputs, the world the true ones
    let mut world = campaign.clone();
    for (parameter, value) in schedule.parameters.iter().zip(&point).filter(|(p, _)| p.kind == Kind::Input) {
        world.shift_input(&parameter.id, value - parameter.reference());
    }
    let model = Model::new(&campaign)?;
    let rows = design::rows(&campaign);
    let tilts = model.tilts_of(&point);
    let apart: Vec<&Hidden> = truth
        .effects
        .iter()
        .filter(|hidden| !matches!(hidden.regressor, Regressor::Tilt(_) | Regressor::Known(_)))
        .collect();
    let wanted: Vec<(&Regressor, Option<usize>)> = apart.iter().map(|h| (&h.regressor, h.sensor)).collect();
    let effects = columns(&world, &rows, &tilts, &point, &wanted)?;
    // a sensor without an entry in the truth has no noise
    let noise_of = |sensor: usize| truth.noise.get(sensor).copied().unwrap_or_default();
    let sd: Vec<f64> = rows
        .iter()
        .map(|origin| {
            let samples = campaign.readings.rows.get(origin.reading).map_or(1.0, |reading| reading.samples);
            noise_of(origin.sensor).sd / samples.sqrt()
        })
        .collect();
    // where deviations are drawn by themselves, the noise is what remains of the standard deviation
    let (added, noise_sd) = if campaign.scatter.is_empty() {
        (vec![0.0; rows.len()], sd.clone())
    } else {
        let design = design::assemble(&campaign, &model, &point)?;
        deviations::deviations(&campaign, &design, truth, &sd, seed)?
    };
    let mut generator = Pcg64Mcg::seed_from_u64(seed);
    let mut gradient = vec![0.0; campaign.parameters.len()];
    let mut work = model.workspace();
    for (i, origin) in rows.iter().enumerate() {
        let mut value = model.predict(&world, origin.reading, origin.sensor, &point, &mut gradient, &mut work)?;
        value += apart.iter().zip(&effects).map(|(h, column)| h.value * column.at(i)).sum::<f64>();
        let noise = noise_of(origin.sensor);
        let z: f64 = StandardNormal.sample(&mut generator);
        let samples = campaign.readings.rows.get(origin.reading).map_or(1.0, |reading| reading.samples);
        value += added.at(i) + noise_sd.at(i) * z;
        if let Some(decimals) = noise.decimals {
            let scale = 10f64.powi(decimals.min(300) as i32);
            let rounded = (value * scale).round() / scale;
            value = if rounded.is_finite() { rounded } else { value };
        }
        let Some(reading) = campaign.readings.rows.get_mut(origin.reading) else { continue };
        if !value.is_finite() {
            return Err(Malformed::new(Fault::Value, "the simulated reading is not a finite number")
                .expected("true values and effects within the range of a double")
                .at_path(&reading.place));
        }
        // the uncertainty that the schedule states, where the truth states none
        let u = if noise.stated && noise.sd > 0.0 { Some(sd.at(i)) } else { reading.stated_u(origin.sensor) };
        reading.observations.push(Observation { sensor: origin.sensor, value, u, samples });
    }
    for reading in &mut campaign.readings.rows {
        reading.planned_u = Shared::default();
    }
    Ok(campaign)
}

/// How large each input of a model line could be: gravity along an axis, the fastest rate, any angle, the largest value of a column.
pub(crate) fn largest_inputs(campaign: &Campaign) -> impl Fn(&str) -> f64 {
    let (bench, readings) = (&campaign.bench, &campaign.readings);
    let rates = readings.rows.iter().flat_map(|row| row.joints.iter().map(|s| s.rate_deg_s().abs()));
    let rate = rates.map(|rate| rate * bench.units.rate.per_deg_s()).fold(bench.earth_rate().norm(), f64::max);
    move |name| match name {
        axis if is_axis_input(bench, axis) && axis.starts_with("w_") => rate,
        axis if is_axis_input(bench, axis) => bench.specific_force().norm(),
        joint if bench.joints().any(|id| id == joint) => 0.7, // radians: no low harmonic is small there
        column => {
            let at = readings.columns.iter().position(|id| id == column);
            let values = readings.rows.iter().filter_map(|row| row.columns.get(at?).copied().flatten());
            values.fold(0.0, |most, v| v.abs().max(most))
        }
    }
}

/// Is this parameter a tilt?
fn is_tilt(campaign: &Campaign, k: usize) -> bool {
    campaign.parameters.get(k).is_some_and(|p| p.kind == Kind::Tilt)
}
