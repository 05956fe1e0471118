//! Errors of the scale factor of a sensor whose rate is stepped about its input axis (IEEE Std 528, IEEE Std 1431), in ppm.
//!
//! ```text
//! Y_j  mean reading at rate x_j;   a + b x  straight line by least squares, one point for each rate;   F = |b| max|x|  full-scale output
//! nonlinearity    max |Y_j - a - b x_j| / F
//! asymmetry       2 (b_+ - b_-) / (b_+ + b_-),  b_+ and b_- the slopes of the rates of either sense
//! hysteresis      max |Y_j from below - Y_j from above| / F,  by the rate before
//! repeatability   standard deviation of the slopes of runs over their mean; a run is complete when it has every rate
//! ```
//!
//! What the model line knows of curvature or sense plays no part; the variance of the readings is that of the fit. The first order describes a
//! largest deviation where it is larger than the others by more than noise. Elsewhere the other deviations may be the largest ones, and of `n` of
//! them all lie within the quantile at `level^(1/n)` with at least that level (Sidak 1967): that is the coverage factor then.

use super::Fit;
use super::scatter::{own_noise, scatter_lines};
use crate::bench::Sensor;
use crate::campaign::{Campaign, JointState, ScaleFactor};
use crate::design::{Instant, Kinematics, kinematics, used_by};
use crate::elements::{Elements, OrNan};
use crate::language::{Sentence, sentence};
use crate::mix::Mix;
use crate::uncertainty::{Combined, Contribution, Evaluation, combine_groups, quantiles};
use nalgebra::Vector3;
use std::collections::{BTreeMap, HashMap};
use std::hash::BuildHasherDefault;

/// An error of a sensor's scale factor.
#[derive(Debug, Clone)]
pub struct ScaleFactorError {
    /// `SENSOR_nonlinearity_COLUMN`, the column that of the rate.
    pub id: String,
    /// What it is, in the symbols of this module.
    pub line: String,
    /// Value, ppm.
    pub value: f64,
    /// Combined uncertainty, ppm; `None` where the scatter of the readings cannot be known.
    pub uncertainty: Option<Combined>,
    /// Where the uncertainty comes from.
    pub budget: Vec<Contribution>,
    /// What the value is made of.
    pub from: ScaleFactorFrom,
}

/// What the error of a scale factor is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScaleFactorFrom {
    /// The slopes of both senses.
    Senses,
    /// The largest of `of` deviations, of which so many, it included, noise does not tell from the largest.
    Largest {
        /// Deviations that may be the largest.
        alike: usize,
        /// All of them.
        of: usize,
    },
    /// The slopes of so many runs.
    Runs(usize),
}

const PPM: f64 = 1e6;

/// Readings of one sensor between which only the rate of one joint changes.
struct Series {
    column: String,
    rows: Vec<usize>,
    points: Vec<Point>,
    /// Share of the rate that the input axis sees.
    share: f64,
}

/// A reading, and the weight that a robust estimate gives it; 1 elsewhere.
#[derive(Clone, Copy)]
struct Point {
    /// Rate about the input axis, deg/s.
    rate: f64,
    reading: f64,
    weight: f64,
}

/// Weighted mean of the readings at one rate.
struct Step {
    rate: f64,
    /// Which readings, and the share that each has in the mean.
    of: Vec<(usize, f64)>,
    mean: f64,
}

/// Straight line through steps.
struct Line {
    centre: (f64, f64),
    slope: f64,
    squares: f64,
    steps: usize,
}

impl Line {
    fn through<'a>(steps: impl Iterator<Item = &'a Step> + Clone) -> Option<Line> {
        let count = steps.clone().count();
        let mean = |of: &dyn Fn(&Step) -> f64| steps.clone().map(of).sum::<f64>() / count as f64;
        let centre = (mean(&|own| own.rate), mean(&|own| own.mean));
        let squares: f64 = steps.clone().map(|own| (own.rate - centre.0).powi(2)).sum();
        let slope = steps.map(|own| (own.rate - centre.0) * (own.mean - centre.1)).sum::<f64>() / squares;
        (count >= 2 && slope.is_finite() && slope != 0.0).then_some(Line { centre, slope, squares, steps: count })
    }

    fn deviation(&self, step: &Step) -> f64 {
        step.mean - self.centre.1 - self.slope * (step.rate - self.centre.0)
    }

    /// The slope by the mean of a step.
    fn by(&self, step: &Step) -> f64 {
        (step.rate - self.centre.0) / self.squares
    }
}

/// Set the number at a place that the list has.
fn put(list: &mut [f64], k: usize, value: f64) {
    list.get_mut(k).into_iter().for_each(|slot| *slot = value);
}

/// One step for each rate at which readings have weight.
fn steps(points: &[Point], of: impl Iterator<Item = usize>) -> Vec<Step> {
    let mut found: BTreeMap<u64, Step> = BTreeMap::new();
    for k in of {
        let Some(Point { rate, reading, weight }) = points.get(k).copied().filter(|own| own.weight > 0.0) else {
            continue;
        };
        let step = found.entry(rate.to_bits()).or_insert(Step { rate, of: Vec::new(), mean: 0.0 });
        step.of.push((k, weight));
        step.mean += weight * reading;
    }
    let mut steps: Vec<Step> = found.into_values().collect();
    for step in &mut steps {
        let sum: f64 = step.of.iter().map(|(_, weight)| weight).sum();
        step.mean /= sum;
        step.of.iter_mut().for_each(|(_, weight)| *weight /= sum);
    }
    steps.sort_by(|a, b| a.rate.total_cmp(&b.rate));
    steps
}

impl Fit {
    /// Errors of the scale factors of all sensors that have an input axis, where the readings step the rate about it; none where they are a
    /// sample of a record that was streamed.
    pub fn scale_factor_errors(&self) -> Vec<ScaleFactorError> {
        if self.streamed.is_none() { self.errors_of_readings() } else { Vec::new() }
    }

    /// What a person should know of errors that are not told: those of a record that is not held, those that have limits.
    pub(super) fn untold_errors(&self) -> Vec<Sentence> {
        let found = self.errors_of_readings();
        let streamed = self.streamed.is_some();
        let record = (streamed && !found.is_empty()).then(|| sentence!("scale-factor-errors-need-readings"));
        let limited = self.campaign.limited_errors().into_iter();
        let without = limited.filter(|id| !streamed && found.iter().all(|own| own.id != *id));
        record.into_iter().chain(without.map(|id| sentence!("scale-factor-error-has-limits", id))).collect()
    }

    fn errors_of_readings(&self) -> Vec<ScaleFactorError> {
        let mut found = Vec::new();
        for (s, sensor) in self.campaign.bench.sensors.iter().enumerate() {
            let Some(series) = series(self, s, sensor) else { continue };
            let steps = steps(&series.points, 0..series.points.len());
            let Some(line) = Line::through(steps.iter()) else { continue };
            let of = Of { fit: self, sensor: (s, &sensor.id), series: &series, steps: &steps, line: &line };
            let all = [of.nonlinearity(), of.asymmetry(), of.hysteresis(), of.repeatability()];
            found.extend(all.into_iter().flatten().filter(|own| own.value.is_finite()));
        }
        found.retain(|own| self.campaign.derived.iter().all(|other| other.id != own.id));
        found
    }
}

/// The series of a sensor with the widest range about its input axis, which lies nearer to the joint's axis than across it.
fn series(fit: &Fit, s: usize, sensor: &Sensor) -> Option<Series> {
    let Fit { campaign, design, robust, .. } = fit;
    let weights = robust.as_ref().map(|own| &own.weights);
    let axis = sensor.input()?;
    let names: Vec<&str> = campaign.bench.joints().collect();
    // of rows that are alike one is looked at
    let mut known: HashMap<usize, usize, BuildHasherDefault<Mix>> = HashMap::default();
    let mut numbers: HashMap<Vec<u64>, usize> = HashMap::new();
    let mut all: Vec<Series> = Vec::new();
    let used = used_by(campaign, s);
    for (row, origin) in design.rows.iter().enumerate().filter(|(_, origin)| origin.sensor == s) {
        let Some(reading) = campaign.readings.rows.get(origin.reading) else { continue };
        let Some(observed) = reading.observations.iter().find(|own| own.sensor == s) else { continue };
        let mut turning = reading.joints.iter().enumerate().filter_map(|(k, own)| Some((k, own.keys().1?)));
        let (Some((joint, rate)), None) = (turning.next(), turning.next()) else { continue };
        let Some(name) = names.get(joint) else { continue };
        let first = design.alike.at(row);
        let next = known.get(&first).copied().unwrap_or_else(|| {
            let mut key = vec![joint as u64];
            for state in &reading.joints {
                key.extend(state.at_rate(1.0).unwrap_or(*state).bits());
            }
            // the joint's own columns say what its state says
            let others = used.iter().filter(|k| {
                let column = campaign.readings.columns.get(**k).and_then(|own| own.strip_prefix(name));
                !column.is_some_and(|rest| rest.starts_with('_'))
            });
            key.extend(others.map(|k| reading.columns.get(*k).copied().flatten().unwrap_or(f64::NAN).to_bits()));
            *numbers.entry(key).or_insert(all.len())
        });
        known.insert(first, next);
        if next == all.len() {
            let share = seen(campaign, &reading.joints, joint, axis);
            all.push(Series { column: format!("{name}_deg_s"), rows: Vec::new(), points: Vec::new(), share });
        }
        let Some(own) = all.get_mut(next) else { continue };
        own.rows.push(row);
        let weight = weights.map_or(1.0, |weights| weights.or_nan(row));
        own.points.push(Point { rate: rate * own.share.signum(), reading: observed.value, weight });
    }
    let range =
        |own: &Series| own.share.abs() * own.points.iter().fold(0.0_f64, |most, point| most.max(point.rate.abs()));
    let about = all
        .into_iter()
        .filter(|own| 2.0 * own.share * own.share > 1.0 && steps(&own.points, 0..own.points.len()).len() >= 3);
    // of series that differ by rounding alone, the first
    about.reduce(|best, own| if range(&own) > range(&best) * (1.0 + 1e-9) { own } else { best })
}

/// The share of a joint's rate along an axis of the sensor, the chain as it is drawn.
fn seen(campaign: &Campaign, joints: &[JointState], joint: usize, axis: Vector3<f64>) -> f64 {
    let angle_deg = joints.iter().map(|state| state.keys().0.unwrap_or_default()).collect();
    let mut instant = Instant { angle_deg, rate_deg_s: vec![0.0; joints.len()] };
    let mut found = Kinematics::default();
    let mut along = |instant: &Instant| {
        kinematics(&campaign.bench, &[], instant, &mut found);
        found.rate.dot(&axis)
    };
    let still = along(&instant);
    put(&mut instant.rate_deg_s, joint, 1.0 / campaign.bench.units.rate.per_deg_s());
    along(&instant) - still
}

/// What the errors of one sensor are made of.
struct Of<'a> {
    fit: &'a Fit,
    sensor: (usize, &'a str),
    series: &'a Series,
    steps: &'a [Step],
    line: &'a Line,
}

impl Of<'_> {
    fn full_scale(&self) -> f64 {
        self.line.slope.abs() * self.steps.iter().fold(0.0_f64, |most, own| most.max(own.rate.abs()))
    }

    fn result(
        &self,
        what: ScaleFactor,
        line: String,
        value: f64,
        by: &[f64],
        from: ScaleFactorFrom,
    ) -> ScaleFactorError {
        let (budget, uncertainty) = self.uncertainty(by);
        let id = what.of(self.sensor.1, &self.series.column);
        ScaleFactorError { id, line, value, uncertainty, budget, from }
    }

    /// `max |deviation| / full scale`: the deviations, and how one follows the readings.
    fn largest(
        &self,
        what: ScaleFactor,
        line: &str,
        deviations: &[f64],
        by: impl Fn(usize) -> Vec<f64>,
    ) -> Option<ScaleFactorError> {
        let largest =
            (0..deviations.len()).reduce(|a, b| if deviations.at(b).abs() > deviations.at(a).abs() { b } else { a })?;
        let (deviation, scale) = (deviations.at(largest), PPM / self.full_scale());
        let value = deviation.abs() * scale;
        let mut along = by(largest);
        along.iter_mut().for_each(|own| *own *= deviation.signum() * scale);
        for step in self.steps {
            for (k, share) in &step.of {
                if let Some(own) = along.get_mut(*k) {
                    *own -= value / self.line.slope * self.line.by(step) * share;
                }
            }
        }
        let of = deviations.len();
        let mut found = self.result(what, line.into(), value, &along, ScaleFactorFrom::Largest { alike: 1, of });
        if let Some(combined) = &mut found.uncertainty {
            let factor =
                |n: usize| quantiles::coverage_factor(self.fit.settings.level.powf(1.0 / n as f64), combined.dof);
            let within = 2.0 * factor(of)? * combined.u;
            let alike = deviations.iter().filter(|own| own.abs() * scale >= value - within).count();
            combined.coverage_factor = factor(alike)?;
            combined.expanded = combined.coverage_factor * combined.u;
            found.from = ScaleFactorFrom::Largest { alike, of };
        }
        Some(found)
    }

    fn nonlinearity(&self) -> Option<ScaleFactorError> {
        let deviations: Vec<f64> = self.steps.iter().map(|step| self.line.deviation(step)).collect();
        let by = |largest: usize| {
            let mut along = vec![0.0; self.series.points.len()];
            let rate = self.steps.get(largest).map_or(0.0, |own| own.rate);
            for (j, step) in self.steps.iter().enumerate() {
                let own = f64::from(u8::from(j == largest))
                    - 1.0 / self.line.steps as f64
                    - self.line.by(step) * (rate - self.line.centre.0);
                for (k, share) in &step.of {
                    put(&mut along, *k, own * share);
                }
            }
            along
        };
        self.largest(ScaleFactor::Nonlinearity, "‖Y - a - b x‖∞ / (|b| ‖x‖∞)", &deviations, by)
    }

    fn asymmetry(&self) -> Option<ScaleFactorError> {
        let positive = |own: &&Step| own.rate > 0.0;
        let negative = |own: &&Step| own.rate < 0.0;
        let (up, down) =
            (Line::through(self.steps.iter().filter(positive))?, Line::through(self.steps.iter().filter(negative))?);
        let sum = up.slope + down.slope;
        let share = 2.0 * (up.slope - down.slope) / sum;
        let mut along = vec![0.0; self.series.points.len()];
        for step in self.steps.iter().filter(|own| own.rate != 0.0) {
            let by = if step.rate > 0.0 { (2.0 - share) * up.by(step) } else { -(2.0 + share) * down.by(step) };
            for (k, share) in &step.of {
                put(&mut along, *k, PPM * by / sum * share);
            }
        }
        let line = "2 (b₊ - b₋) / (b₊ + b₋)".to_string();
        Some(self.result(ScaleFactor::Asymmetry, line, PPM * share, &along, ScaleFactorFrom::Senses))
    }

    fn hysteresis(&self) -> Option<ScaleFactorError> {
        let mut from_below = vec![None; self.series.points.len()];
        let mut before: Option<(f64, Option<bool>)> = None;
        for (Point { rate, .. }, slot) in self.series.points.iter().zip(&mut from_below) {
            let sense = match before {
                Some((last, _)) if last != *rate => Some(*rate > last),
                Some((_, sense)) => sense,
                None => None,
            };
            (*slot, before) = (sense, Some((*rate, sense)));
        }
        let of = |step: &Step, below: bool| -> Option<Step> {
            let of = step.of.iter().map(|(k, _)| *k);
            steps(&self.series.points, of.filter(|k| from_below.get(*k).copied().flatten() == Some(below))).pop()
        };
        let both: Vec<(Step, Step)> =
            self.steps.iter().filter_map(|step| Some((of(step, true)?, of(step, false)?))).collect();
        let deviations: Vec<f64> = both.iter().map(|(below, above)| below.mean - above.mean).collect();
        let by = |largest: usize| {
            let mut along = vec![0.0; self.series.points.len()];
            let (below, above) = both.get(largest).map_or((&[][..], &[][..]), |(below, above)| (&below.of, &above.of));
            below.iter().for_each(|(k, share)| put(&mut along, *k, *share));
            above.iter().for_each(|(k, share)| put(&mut along, *k, -share));
            along
        };
        self.largest(ScaleFactor::Hysteresis, "‖Y↑ - Y↓‖∞ / (|b| ‖x‖∞)", &deviations, by)
    }

    /// Of normal slopes, `nu s^2/sigma^2` is chi-square: `u = s sqrt(1 - c4^2)`, and U is what holds sigma at the level.
    fn repeatability(&self) -> Option<ScaleFactorError> {
        let (mut runs, mut run): (Vec<Vec<usize>>, Vec<usize>) = (Vec::new(), Vec::new());
        let mut rates = std::collections::HashSet::new();
        // readings at one rate in a row: of a run that is complete, as many as at its other rates at least
        let (mut last, mut visit, mut shortest) = (f64::NAN, 0, usize::MAX);
        for (k, Point { rate, .. }) in self.series.points.iter().enumerate() {
            if rates.len() == self.steps.len() && (*rate != last || visit >= shortest) {
                runs.push(std::mem::take(&mut run));
                rates.clear();
                (visit, shortest) = (0, usize::MAX);
            } else if *rate != last && visit > 0 {
                (visit, shortest) = (0, shortest.min(visit));
            }
            visit += 1;
            rates.insert(rate.to_bits());
            run.push(k);
            last = *rate;
        }
        if rates.len() == self.steps.len() {
            runs.push(run);
        }
        let slope =
            |run: &Vec<usize>| Some(Line::through(steps(&self.series.points, run.iter().copied()).iter())?.slope);
        let slopes: Vec<f64> = runs.iter().filter_map(slope).collect();
        let (count, dof) = (slopes.len(), slopes.len() as f64 - 1.0);
        if count < 2 {
            return None;
        }
        let mean = slopes.iter().sum::<f64>() / count as f64;
        let value = PPM * (slopes.iter().map(|own| (own - mean).powi(2)).sum::<f64>() / dof).sqrt() / mean.abs();
        let (share, half) = ((1.0 - c4(count).powi(2)).sqrt(), half_width(self.fit.settings.level, dof)?);
        let source = Contribution::of_many("slopes of runs".into(), Evaluation::TypeA, share * value, dof);
        let uncertainty = Combined {
            u: source.u,
            type_a: source.u,
            type_b: 0.0,
            dof,
            coverage_factor: half / share,
            expanded: half * value,
        };
        Some(ScaleFactorError {
            id: ScaleFactor::Repeatability.of(self.sensor.1, &self.series.column),
            line: "s(b) / |b|".into(),
            value,
            uncertainty: Some(uncertainty),
            budget: vec![source],
            from: ScaleFactorFrom::Runs(count),
        })
    }

    /// Uncertainty of what follows the readings of the series like this.
    fn uncertainty(&self, by: &[f64]) -> (Vec<Contribution>, Option<Combined>) {
        let Fit { campaign, design, system, noise, settings, .. } = self.fit;
        let mut along = vec![0.0; design.rows.len()];
        self.series.rows.iter().zip(by).for_each(|(row, own)| put(&mut along, *row, *own));
        let u = own_noise(campaign, design, &system.u);
        let of_rows: f64 = along.iter().zip(&u).map(|(c, u)| (c * u).powi(2)).sum();
        let lines = scatter_lines(campaign, design, &system.u);
        let of_line = |k: usize, tau: Option<f64>| lines.get(k).map_or(0.0, |line| line.variance_of(&along, tau));
        let (budget, type_a_dof) = noise.of_one(self.sensor.0, of_rows, &of_line).contributions(&[1.0]);
        if !noise.determined || noise.absorbed.iter().any(|(k, _)| of_line(*k, None) > 0.0) {
            return (budget, None);
        }
        let group = |c: &Contribution| {
            (type_a_dof.is_some() && c.evaluation == Evaluation::TypeA && c.dof.is_finite()).then_some(0)
        };
        let combined = combine_groups(&budget, &group, &[type_a_dof.unwrap_or(f64::INFINITY)], settings.level);
        (budget, combined)
    }
}

/// `E[s]/sigma` of n normal values: `sqrt(2/(n - 1)) Gamma(n/2)/Gamma((n - 1)/2)`.
fn c4(n: usize) -> f64 {
    // Gamma((k + 1)/2)/Gamma(k/2) from k = 1
    let ratio = (2..n).fold(std::f64::consts::PI.sqrt().recip(), |ratio, k| 0.5 * (k as f64 - 1.0) / ratio);
    (2.0 / (n as f64 - 1.0)).sqrt() * ratio
}

/// The `a` for which `s (1 - a)` to `s (1 + a)` holds sigma with this probability.
fn half_width(level: f64, dof: f64) -> Option<f64> {
    let holds = |a: f64| -> Option<f64> {
        let above = if a < 1.0 { quantiles::chi_square_cdf(dof / (1.0 - a).powi(2), dof)? } else { 1.0 };
        Some(above - quantiles::chi_square_cdf(dof / (1.0 + a).powi(2), dof)?)
    };
    if holds(1.0)? <= level {
        return Some((dof / quantiles::chi_square_quantile(1.0 - level, dof)?).sqrt() - 1.0);
    }
    let (mut low, mut high) = (0.0, 1.0);
    // each halves the range: below rounding after these
    for _ in 0..f64::MANTISSA_DIGITS {
        let middle = 0.5 * (low + high);
        if holds(middle)? < level { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}
