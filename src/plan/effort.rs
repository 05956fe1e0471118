//! What a reading costs in uncertainty and in work: noise of each sensor, scatter of each remounting, costs.

use crate::campaign::{Campaign, Deviating, Kind, Observation, Reading, Readings, Scatter, Size};
use crate::elements::numbered;
use crate::error::{Fault, Malformed, Result};
use crate::fit;
use crate::vocabulary::vocabulary;

vocabulary! {
    /// Where the noise comes from.
    NoiseSource {
        /// The user gave it.
        Given = "given",
        /// The readings' stated uncertainties.
        Stated = "stated",
        /// The residuals of these readings.
        Residuals = "residuals",
    }
}

/// Noise of one sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorNoise {
    /// Standard deviation of one sample (of a reading with `n` = 1), in the sensor's unit.
    pub sd: f64,
    /// Where it comes from.
    pub from: NoiseSource,
}

/// Noise of every sensor, and what every remounting scatters.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    /// One for each sensor of the bench.
    pub sensors: Vec<SensorNoise>,
    /// Parameter (index) that takes a new value at each mounting, and the standard deviation of that value.
    pub remount: Vec<(usize, f64)>,
    /// Variance of each line of the campaign's scatter: stated, or estimated from its readings.
    pub lines: Vec<f64>,
    /// Expected size (standard deviation, radians) of estimated tilts without a start or prior: known inputs act through the tilts, and before
    /// anyone measures only the user knows how large they may be. `None`: not stated, and so not counted.
    pub tilts: Option<f64>,
}

impl Noise {
    /// Noise as given (`V = 9e-4`), else from stated uncertainties, else from the residuals of a measured campaign.
    ///
    /// A line of the campaign's scatter is given under its name, in its unit (`beta per position = 5`). `remount` names parameters (tilts in radians) that
    /// scatter from mounting to mounting. Errors: a sensor, line or parameter that the bench does not have, a standard deviation that is not positive, a
    /// schedule without noise.
    pub fn new(campaign: &Campaign, given: &[(String, f64)], remount: &[(String, f64)]) -> Result<Self> {
        Noise::with_fit(campaign, given, remount, None)
    }

    /// The same with a fit of the campaign that was made already.
    pub fn with_fit(
        campaign: &Campaign,
        given: &[(String, f64)],
        remount: &[(String, f64)],
        fitted: Option<&fit::Fit>,
    ) -> Result<Self> {
        let ids: Vec<&str> = campaign.bench.sensors.iter().map(|s| s.id.as_str()).collect();
        // lines of scatter with one standard deviation, by the names that budgets and truth files have for them
        let sized =
            |line: &&Scatter| !matches!((&line.of, &line.size), (Deviating::Correlated(..), _) | (_, Size::Column(_)));
        let names = campaign.scatter.iter().filter(sized).map(|line| line.name(campaign));
        let names: Vec<String> = ids.iter().map(|id| (*id).to_string()).chain(names).collect();
        for (id, sd) in given {
            if !names.contains(id) {
                let what = format!("noise is given for '{id}', which is neither a sensor nor a line of scatter here");
                return Err(Malformed::unknown(what, id, &names));
            }
            positive(*sd, &format!("the noise of {id}"))?;
        }
        let root_mean_square = |u: &[f64]| (u.iter().map(|u| u * u).sum::<f64>() / u.len() as f64).sqrt();
        // one fit for all that only the readings tell
        let own = std::cell::OnceCell::new();
        let residuals = || -> Result<Option<&fit::Fit>> {
            if fitted.is_none() && own.get().is_none() && campaign.is_measured() {
                let made = fit::fit(campaign, &fit::Settings::default())?;
                own.get_or_init(|| made);
            }
            Ok(fitted.or(own.get()))
        };
        let mut sensors = Vec::with_capacity(ids.len());
        for (k, id) in ids.iter().enumerate() {
            if let Some((_, sd)) = given.iter().find(|(name, _)| name == id) {
                sensors.push(SensorNoise { sd: *sd, from: NoiseSource::Given });
                continue;
            }
            let stated: Vec<f64> =
                campaign.readings.rows.iter().filter_map(|r| Some(r.stated_u(k)? * r.samples.sqrt())).collect();
            if !stated.is_empty() {
                sensors.push(SensorNoise { sd: root_mean_square(&stated), from: NoiseSource::Stated });
                continue;
            }
            let rows = residuals()?.into_iter().flat_map(|fit| {
                let of_sensor = fit.design.rows.iter().zip(fit.quality()).filter(|(origin, _)| origin.sensor == k);
                of_sensor.filter_map(|(origin, q)| {
                    let samples = campaign.readings.rows.get(origin.reading).map_or(1.0, |r| r.samples);
                    q.u.map(|u| u * samples.sqrt())
                })
            });
            let estimated: Vec<f64> = rows.filter(|u| *u > 0.0).collect();
            if estimated.is_empty() {
                return Err(Malformed::new(Fault::Missing, format!("the noise of {id} is not known"))
                    .expected(format!("the standard deviation of one sample, or {id}_u in the schedule"))
                    .argument("noise", format!("{id}=SD"))
                    .found("a schedule that states none"));
            }
            sensors.push(SensorNoise { sd: root_mean_square(&estimated), from: NoiseSource::Residuals });
        }
        let mut lines = fit::stated_variances(campaign);
        for (k, line) in campaign.scatter.iter().enumerate() {
            if line.over.as_ref().is_some_and(|over| over.tau.is_none()) {
                let what = format!("the correlation time of {} is not known", line.of_name(campaign));
                return Err(Malformed::new(Fault::Missing, what)
                    .expected("a correlation time as its \"tau\": a plan does not estimate it")
                    .found("\"estimate\"")
                    .at_path(line.place.clone()));
            }
            let name = line.name(campaign);
            if let Some(((_, sd), slot)) =
                given.iter().find(|(given_name, _)| *given_name == name).zip(lines.get_mut(k))
            {
                *slot = (sd / line.shown).powi(2);
                continue;
            }
            if line.size != Size::Estimated {
                continue;
            }
            let source = residuals()?.and_then(|fit| fit.noise.sources.iter().find(|source| source.line == Some(k)));
            let (Some(source), Some(slot)) = (source, lines.get_mut(k)) else {
                return Err(Malformed::new(
                    Fault::Missing,
                    format!(
                        "the standard deviation of {} is not known: a schedule has no readings to estimate it from",
                        line.of_name(campaign)
                    ),
                )
                .expected(match line.unit.as_str() {
                    "" => "the standard deviation that it will have".into(),
                    unit => format!("the standard deviation that it will have, in {unit}"),
                })
                .argument("noise", format!("\"{name}=SD\""))
                .found("\"u\": \"estimate\"")
                .at_path(line.place.clone()));
            };
            *slot = source.variance;
        }
        let mut scatter = Vec::new();
        for (id, sd) in remount {
            let Some(k) = campaign.parameter_index(id) else {
                let tilts: Vec<&str> =
                    campaign.parameters.iter().filter(|p| p.kind == Kind::Tilt).map(|p| p.id.as_str()).collect();
                return Err(Malformed::new(
                    Fault::UnknownName,
                    format!("'{id}' cannot scatter: it is not a parameter of this bench"),
                )
                .expected(format!("a tilt that remounting changes: {}", tilts.join(", ")))
                .found(format!("'{id}'")));
            };
            positive(*sd, &format!("the remounting scatter of {id}"))?;
            scatter.push((k, *sd));
        }
        Ok(Noise { sensors, remount: scatter, lines, tilts: None })
    }

    /// Standard uncertainty of one sensor's value at a reading: as the reading states it, unless noise was given; a mean of `n` samples has the
    /// standard deviation over the root of n.
    pub fn u(&self, reading: &Reading, sensor: usize) -> f64 {
        let Some(noise) = self.sensors.get(sensor) else { return 1.0 };
        match (noise.from, reading.stated_u(sensor)) {
            (NoiseSource::Stated, Some(u)) => u,
            _ => noise.sd / reading.samples.sqrt(),
        }
    }
}

fn positive(sd: f64, what: &str) -> Result<()> {
    if sd > 0.0 && sd.is_finite() {
        return Ok(());
    }
    Err(Malformed::new(Fault::Value, format!("{what} is not positive"))
        .expected("a positive standard deviation")
        .found(sd.to_string()))
}

/// Costs of work, in any unit, for example minutes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Costs {
    /// Taking one reading.
    pub reading: f64,
    /// Changing a rate without remounting.
    pub rate_change: f64,
    /// Remounting, or indexing to another angle.
    pub mounting: f64,
    /// Moving joints at rest from one mounting to the next, for each degree of the one that moves furthest: they move together, the shorter way.
    pub index: f64,
}

impl Default for Costs {
    fn default() -> Self {
        Costs { reading: 1.0, rate_change: 1.0, mounting: 10.0, index: 0.0 }
    }
}

/// Work of a schedule.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "WorkReport")]
pub struct Work {
    /// Readings.
    pub readings: usize,
    /// Mountings.
    pub mountings: usize,
    /// Rate changes within mountings.
    pub rate_changes: usize,
    /// Cost of it all, in the unit of the costs that were given (readings, where none were).
    pub cost: f64,
}

impl Costs {
    /// The work of readings in this order.
    pub fn work(&self, readings: &[Reading]) -> Work {
        let (mut mountings, mut rate_changes) = (0, 0);
        let mut before: Option<&Reading> = None;
        for reading in readings {
            match before.replace(reading).filter(|last| same_mounting(last, reading)) {
                Some(last) => rate_changes += usize::from(last.joints != reading.joints),
                None => mountings += 1,
            }
        }
        let cost = self.reading * readings.len() as f64
            + self.rate_change * rate_changes as f64
            + self.mounting * mountings as f64
            + self.of_way(readings);
        Work { readings: readings.len(), mountings, rate_changes, cost }
    }

    /// What moving the joints between readings costs, in this order.
    pub(super) fn of_way(&self, readings: &[Reading]) -> f64 {
        let steps = readings.iter().zip(readings.iter().skip(1));
        self.index * steps.map(|(a, b)| furthest(a, b)).sum::<f64>()
    }

    /// Negative or infinite costs are no costs. Errors: `Value`, with the name of the cost.
    pub(crate) fn check(&self) -> Result<()> {
        for (name, cost) in
            [("reading", self.reading), ("rate", self.rate_change), ("mounting", self.mounting), ("degree", self.index)]
        {
            if !(cost >= 0.0 && cost.is_finite()) {
                return Err(Malformed::new(Fault::Value, format!("the cost of a {name} is not valid"))
                    .expected("zero or a positive number")
                    .found(cost.to_string()));
            }
        }
        Ok(())
    }
}

/// The candidates, and what they cost.
#[derive(Debug, Clone)]
pub struct Offer {
    /// Positions that stay whatever is chosen; may be none.
    pub kept: Readings,
    /// Positions that may be chosen.
    pub candidates: Readings,
    /// Noise and scatter.
    pub noise: Noise,
    /// Costs.
    pub costs: Costs,
}

/// Positions without their values.
pub fn positions_only(readings: &Readings) -> Readings {
    let rows = readings.rows.iter().map(Reading::unread).collect();
    Readings { columns: readings.columns.clone(), rows }
}

/// Readings as a plan counts them: in a campaign that is half done, positions without a value are still to be read, by every sensor. Their values
/// play no part, and neither do those of the others.
pub fn planned(campaign: &Campaign, readings: &Readings) -> Readings {
    let mut planned = readings.clone();
    if readings.rows.iter().any(|row| !row.observations.is_empty()) {
        for row in planned.rows.iter_mut().filter(|row| row.observations.is_empty()) {
            row.observations = (0..campaign.bench.sensors.len())
                .map(|sensor| Observation { sensor, value: 0.0, u: row.stated_u(sensor), samples: row.samples })
                .collect();
        }
    }
    planned
}

/// Were two readings taken without moving a joint at rest?
pub fn same_mounting(a: &Reading, b: &Reading) -> bool {
    a.position == b.position && mounting(a) == mounting(b)
}

/// The angles of the joints at rest; `None` for those that turn.
pub fn mounting(reading: &Reading) -> Vec<Option<f64>> {
    reading.joints.iter().map(|state| (state.rate_deg_s() == 0.0).then(|| state.keys().0).flatten()).collect()
}

/// Degrees by which each joint that is at rest in both readings is moved from one to the other, the shorter way.
pub(super) fn moved_deg(a: &Reading, b: &Reading) -> Vec<f64> {
    let turn = |(a, b): (Option<f64>, Option<f64>)| match (a, b) {
        (Some(a), Some(b)) => ((a - b + 180.0).rem_euclid(360.0) - 180.0).abs(),
        _ => 0.0,
    };
    mounting(a).into_iter().zip(mounting(b)).map(turn).collect()
}

/// Degrees by which the joint moves that moves furthest.
pub(super) fn furthest(a: &Reading, b: &Reading) -> f64 {
    moved_deg(a, b).into_iter().fold(0.0, f64::max)
}

/// Lists of what has the same key, in the order in which the keys first occur.
pub(crate) fn grouped<T, K: std::hash::Hash + Eq>(keyed: impl IntoIterator<Item = (T, K)>) -> Vec<Vec<T>> {
    let mut groups: Vec<Vec<T>> = Vec::new();
    let mut known: std::collections::HashMap<K, usize> = std::collections::HashMap::new();
    for (item, key) in keyed {
        let place = *known.entry(key).or_insert(groups.len());
        match groups.get_mut(place) {
            Some(group) => group.push(item),
            None => groups.push(vec![item]),
        }
    }
    groups
}

/// The mounting of each reading, counted from 0. The same label again later is the same mounting, as the file format says; without labels only
/// neighbours are.
pub fn mountings(readings: &[Reading]) -> Vec<usize> {
    let (mut run, mut before): (usize, Option<&Reading>) = (0, None);
    let key = |reading| {
        run += usize::from(!before.replace(reading).is_some_and(|last| same_mounting(last, reading)));
        let unlabelled = if reading.position.is_empty() { run } else { 0 };
        (reading.position.as_str(), format!("{:?}", mounting(reading)), unlabelled)
    };
    numbered(readings.iter().map(key)).0
}

/// The time of every reading in units of work, at its end; by number where work costs nothing.
pub(super) fn times<'a>(rows: impl Iterator<Item = &'a Reading>, costs: &Costs) -> Vec<f64> {
    let mut now = 0.0;
    let mut before: Option<&Reading> = None;
    let times: Vec<f64> = rows
        .map(|reading| {
            now += spent(before.replace(reading), reading, costs);
            now
        })
        .collect();
    if now > 0.0 { times } else { (0..times.len()).map(|k| k as f64).collect() }
}

/// What one reading costs after another.
pub(super) fn spent(before: Option<&Reading>, reading: &Reading, costs: &Costs) -> f64 {
    costs.reading
        + match before {
            Some(last) if same_mounting(last, reading) => costs.rate_change * f64::from(last.joints != reading.joints),
            Some(last) => costs.mounting + costs.index * furthest(last, reading),
            None => costs.mounting,
        }
}
