//! Do the readings agree with the model? Replicates, order and shape of the residuals, suspicious readings, reliability.

use super::Fit;
use super::step::Step;
use crate::campaign::Campaign;
use crate::design::{DesignMatrix, RowOrigin};
use crate::elements::{Elements, OrNan};
use crate::estimate::Group;
use crate::mix::Mix;
use crate::quality::{self, LackOfFit, NormalityTest, RunsTest, Signs, Snooping, Whitened};
use crate::uncertainty::quantiles;
use std::collections::HashMap;
use std::hash::BuildHasherDefault;

/// Results of the checks; each is `None` where the readings do not allow it.
#[derive(Debug, Clone, Default)]
pub struct Checks {
    /// Lack of fit against the scatter of replicates.
    pub lack_of_fit: Option<LackOfFit>,
    /// Lack of fit between positions against the scatter of the readings of one position; where nothing is replicated.
    pub between_positions: Option<LackOfFit>,
    /// Order of the signs of the residuals, for each sensor (by its index).
    pub runs: Vec<(usize, RunsTest)>,
    /// Columns that the residuals follow, for each sensor the most significant.
    pub follows: Vec<Follows>,
    /// Shape of the residuals' distribution.
    pub normality: Option<NormalityTest>,
    /// Below this probability each of the tests above rejects: one minus the level over their number, so that one of them does for at most that share of right models (C. E. Bonferroni 1936).
    pub significance: f64,
    /// Priors that contradict the readings: the parameter (by its index), the difference from what the readings say in its standard uncertainties, and the probability of as much.
    pub priors: Vec<(usize, f64, f64)>,
    /// Suspicious readings; not searched in a robust fit, whose weights say the same.
    pub snooping: Option<Snooping>,
    /// For each row, the smallest fault that a test at 0.1 % finds with 80 % power, in the sensor's unit.
    pub detectable: Vec<Option<f64>>,
    /// For each estimated parameter, how it would change without the suspicious readings; empty where there are none.
    pub without_suspects: Vec<f64>,
}

/// Residuals that have too few runs of one sign in the order of a column: the model lacks something that goes with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Follows {
    /// The sensor, by its index.
    pub sensor: usize,
    /// The column.
    pub column: String,
    /// The runs; `p` is the probability of so few in any of the orders that were tried.
    pub test: RunsTest,
}

/// All checks of a step.
pub(super) fn checks(campaign: &Campaign, design: &DesignMatrix, step: &Step, level: f64) -> Checks {
    let (system, estimate, scattered) = step.tested();
    let readings = design.rows.len();
    let u = estimate.row_u(system);
    let mut checks = Checks::default();
    let value = |i: usize| design.predicted.get(i).zip(system.observed.get(i)).map_or(0.0, |(f, y)| (f + y).abs());
    let largest = (0..readings).map(|i| value(i) / u.at(i)).fold(0.0, f64::max);
    let squares = estimate.residuals.iter().zip(&u).map(|(v, u)| (v / u).powi(2)).sum();
    let silent = quality::is_rounding(squares, readings, largest);
    // readings that share a deviation lie on one side of the fit together: their order says nothing of drift
    let independent = 0..if scattered.is_none() && !silent { campaign.bench.sensors.len() } else { 0 };
    for s in independent {
        let of_sensor = design.rows.iter().zip(&estimate.residuals).filter(|(origin, _)| origin.sensor == s);
        let (rows, own): (Vec<usize>, Vec<f64>) = of_sensor.map(|(origin, v)| (origin.reading, *v)).unzip();
        checks.runs.extend(quality::runs(&own).map(|test| (s, test)));
        checks.follows.extend(follows(campaign, s, &rows, &own));
    }
    let studentized: Vec<f64> = (0..readings)
        .filter_map(|i| {
            // deviations that are shared are taken out of the residuals
            let (v, r) = match scattered {
                Some(found) => {
                    let (place, sd) = found.alone.get(i)?;
                    (found.standardized.get(*place)? * sd.signum(), found.redundancy.get(*place)?)
                }
                None => (estimate.residuals.get(i)? / u.at(i), estimate.redundancy.get(i)?),
            };
            (*r > 1e-6).then(|| v / r.sqrt())
        })
        .collect();
    checks.normality = quality::normality(&studentized).filter(|_| !silent);
    // one more for the lack of fit
    let tests = checks.runs.len() + checks.follows.len() + usize::from(checks.normality.is_some()) + 1;
    checks.significance = (1.0 - level) / tests as f64;
    let each = 1.0 - checks.significance;
    checks.follows.retain(|found| found.test.is_rejected(each));
    let parts = parts(campaign, design, step);
    if step.own.robust.is_none() && !silent && scattered.is_none() {
        let (cells, _) = cells(design, system.observed.len());
        let tests = parts.iter().filter_map(|part| {
            let [v, u] = [&estimate.residuals, &u].map(|of| part.of(of));
            part.named(quality::lack_of_fit(&v, &u, &part.of(&cells), part.dof, each))
        });
        checks.lack_of_fit = LackOfFit::smallest(tests.collect(), each);
    }
    if step.own.robust.is_some() {
        // residuals are not those of least squares here
        return checks;
    }
    if scattered.is_none() {
        checks.priors = contradicted(campaign, design, step);
    }
    // what scatters between positions is no lack of fit
    if scattered.is_none() && !silent && checks.lack_of_fit.is_none() {
        let (factor, positions) = (&estimate.factor, positions(campaign, design, system.observed.len()));
        let tests = parts.iter().filter_map(|part| {
            let weight: Vec<f64> = part.masked(factor.weight(), 0.0);
            let offsets = quality::Offsets::new(&weight, factor.thin_q(), &part.masked(&positions, None), part.dof)?;
            part.named(offsets.test(&estimate.residuals, each))
        });
        checks.between_positions = LackOfFit::smallest(tests.collect(), each);
    }
    // one group alone: its scale comes after the adjustment, so the whitened rows do not have it
    let alone = system.is_of_one_scale() && scattered.is_none();
    let common = Some(estimate.scale_or_one(0)).filter(|scale| alone && *scale > 0.0).unwrap_or(1.0);
    let whitened = match scattered {
        Some(found) => Whitened {
            sd: found.alone.iter().map(|(_, sd)| *sd).collect(),
            place: found.alone.iter().map(|(place, _)| *place).collect(),
            redundancy: found.alone.iter().map(|(place, _)| found.redundancy.at(*place)).collect(),
            residuals: found.standardized.clone(),
            largest,
            remainder: Box::new(|row| {
                // a row that there is not has no place, and no error
                let place = found.alone.get(row).map_or(usize::MAX, |(place, _)| *place);
                found.whitening.remainder(place, found.estimate.factor.thin_q())
            }),
            dof: estimate.dof,
            variance_known: true,
        },
        None => Whitened::independent(
            estimate.factor.thin_q(),
            estimate.factor.weight(),
            &estimate.residuals,
            largest * common,
            estimate.dof,
            system.group.iter().all(|g| *g == Group::Known),
        ),
    };
    checks.snooping = quality::snoop(&whitened, readings, level);
    if !step.own.noise.determined {
        return checks;
    }
    checks.detectable = whitened.detectable(common);
    let unknowns = campaign.unknowns();
    let sensitivity = |j: usize, i: usize| step.sensitivities()[(j, i)];
    if let Some(found) = checks.snooping.as_ref().filter(|found| !found.suspects.is_empty()) {
        checks.without_suspects = (0..unknowns)
            .map(|j| -found.suspects.iter().map(|s| sensitivity(j, s.row) * s.shift).sum::<f64>())
            .collect();
    }
    checks
}

/// Priors against the readings: `w = v/(u sqrt(r))` as for a reading (W. Baarda 1968), at his level of a single one.
fn contradicted(campaign: &Campaign, design: &DesignMatrix, step: &Step) -> Vec<(usize, f64, f64)> {
    let judged = campaign.priors().zip(design.rows.len()..).filter_map(|((k, ..), row)| {
        let (v, r) = (step.own.estimate.residuals.get(row)?, step.own.estimate.redundancy.get(row)?);
        let w = v / (step.system.u.at(row) * r.sqrt());
        let p = 2.0 * quantiles::normal_survival(w.abs())?;
        (*r > 1e-6 && p < quality::ALPHA).then_some((k, w, p))
    });
    judged.collect()
}

/// The column in whose order residuals (of a sensor, in these readings) have fewest runs for what is expected: readings are in the order of the column, those of one value in that of the others. Columns that
/// give the order of another, or that of the readings, and columns of two values, are not tried.
fn follows(campaign: &Campaign, sensor: usize, rows: &[usize], residuals: &[f64]) -> Option<Follows> {
    let value = |row: &usize, column: usize| {
        let reading = campaign.readings.rows.get(*row);
        reading.and_then(|own| own.columns.get(column).copied().flatten()).unwrap_or(f64::NAN)
    };
    let names = &campaign.readings.columns;
    let of = |column: usize| -> Vec<f64> { rows.iter().map(|row| value(row, column)).collect() };
    let columns: Vec<Vec<f64>> = (0..names.len()).map(of).collect();
    let mut orders: Vec<Vec<u32>> = vec![(0..).zip(rows).map(|(place, _)| place).collect()];
    let mut found: Vec<(usize, RunsTest)> = Vec::new();
    for (first, own) in columns.iter().enumerate() {
        let mut values: Vec<f64> = Vec::new();
        let is_new = |value: &f64| {
            let new = value.is_finite() && !values.contains(value);
            values.extend(new.then_some(value));
            values.len() > 2
        };
        if !own.iter().any(is_new) {
            continue;
        }
        let others = |a: u32, b: u32| {
            let differ = |key: &Vec<f64>| key.at(a as usize).total_cmp(&key.at(b as usize));
            columns.iter().map(differ).find(|order| order.is_ne()).unwrap_or(a.cmp(&b))
        };
        // the order of `total_cmp` as one of whole numbers, which sort without branches; then those of one value
        let key = |x: &f64| {
            let bits = x.to_bits().cast_signed();
            bits ^ ((bits >> 63).cast_unsigned() >> 1).cast_signed()
        };
        let mut keyed: Vec<(i64, u32)> = own.iter().map(key).zip(0..).collect();
        keyed.sort_unstable_by_key(|(key, _)| *key);
        let alike = keyed.chunk_by_mut(|(a, _), (b, _)| a == b);
        alike.for_each(|rows| rows.sort_unstable_by(|(_, a), (_, b)| others(*a, *b)));
        let order: Vec<u32> = keyed.iter().map(|(_, place)| *place).collect();
        if orders.contains(&order) {
            continue;
        }
        let mut signs = Signs::default();
        order.iter().filter_map(|place| residuals.get(*place as usize)).for_each(|v| signs.take(*v));
        found.extend(signs.test().map(|test| (first, test)));
        orders.push(order);
    }
    let tried = found.len() as f64;
    let few = found.into_iter().filter(|(_, test)| (test.runs as f64) < test.expected);
    let (column, test) = few.min_by(|a, b| a.1.p.total_cmp(&b.1.p))?;
    let test = RunsTest { p: (test.p * tried).min(1.0), ..test };
    Some(Follows { sensor, column: names.get(column)?.clone(), test })
}

/// The position of each of so many rows, apart for each sensor; none where a reading has no label, or for a prior.
pub(crate) fn positions(campaign: &Campaign, design: &DesignMatrix, rows: usize) -> Vec<Option<usize>> {
    let mut numbers: HashMap<(usize, &str), usize, BuildHasherDefault<Mix>> = HashMap::default();
    let of = |origin: &RowOrigin| campaign.readings.rows.get(origin.reading).map(|reading| reading.position.as_str());
    let labels = design.rows.iter().map(|origin| Some((origin.sensor, of(origin).filter(|label| !label.is_empty())?)));
    let number = |label: Option<(usize, _)>| {
        let next = numbers.len();
        label.map(|label| *numbers.entry(label).or_insert(next))
    };
    let mut positions: Vec<Option<usize>> = labels.map(number).collect();
    positions.resize(rows, None);
    positions
}

/// Rows that are tested for lack of fit by themselves.
struct Part {
    /// The sensor, where this is not all rows.
    sensor: Option<String>,
    rows: Vec<bool>,
    /// Degrees of freedom of their residuals.
    dof: usize,
}

impl Part {
    fn of<T: Copy>(&self, values: &[T]) -> Vec<T> {
        values.iter().zip(&self.rows).filter(|(_, is_in)| **is_in).map(|(value, _)| *value).collect()
    }

    fn masked<T: Copy>(&self, values: &[T], without: T) -> Vec<T> {
        values.iter().zip(&self.rows).map(|(value, is_in)| if *is_in { *value } else { without }).collect()
    }

    fn named(&self, test: Option<LackOfFit>) -> Option<LackOfFit> {
        Some(LackOfFit { sensor: self.sensor.clone(), ..test? })
    }
}

/// All rows; of several sensors whose scales are estimated those of each, since a scale that comes from residuals has the sensor's own lack of fit in it, and would hide
/// it among the others.
fn parts(campaign: &Campaign, design: &DesignMatrix, step: &Step) -> Vec<Part> {
    let (system, estimate, _) = step.tested();
    let count = design.rows.len();
    let mut groups: Vec<(Group, usize)> = Vec::new();
    for (origin, group) in design.rows.iter().zip(&system.group) {
        if groups.iter().all(|(known, _)| known != group) {
            groups.push((*group, origin.sensor));
        }
    }
    if let [] | [_] = groups.as_slice() {
        return vec![Part { sensor: None, rows: vec![true; system.observed.len()], dof: estimate.dof }];
    }
    let part = |(group, sensor): (Group, usize)| {
        let rows: Vec<bool> = system.group.iter().enumerate().map(|(i, own)| i < count && *own == group).collect();
        let redundancy = estimate.redundancy.iter().zip(&rows).filter(|(_, is_in)| **is_in).map(|(r, _)| r);
        // a whole number but for unknowns that sensors share
        let dof = crate::number::count(redundancy.sum::<f64>().round());
        Part { sensor: Some(campaign.sensor_id(sensor).to_string()), rows, dof }
    };
    groups.into_iter().map(part).collect()
}

/// The cell of each of so many rows (those of one cell predict the same), and how many cells there are; a prior is alone.
pub(crate) fn cells(design: &DesignMatrix, rows: usize) -> (Vec<usize>, usize) {
    let (mut cells, mut count) = (Vec::with_capacity(rows), 0);
    for row in 0..rows {
        let first = design.alike.get(row).and_then(|first| cells.get(*first)).copied();
        cells.push(first.unwrap_or(count));
        count += usize::from(first.is_none());
    }
    (cells, count)
}

/// The value that all of a sensor's readings have, in these rows of a design, where the fit leaves nothing of it though they cannot all be the same; `at` has the columns
/// of the unknowns, and behind them the prediction.
pub(crate) fn stuck(
    rows: &[usize],
    (value, residual): (impl Fn(usize) -> f64, impl Fn(usize) -> f64),
    unknowns: usize,
    at: impl Fn(usize, usize) -> f64,
) -> Option<f64> {
    let own = same(rows.iter().map(|row| value(*row)))?;
    (is_all(own, rows.iter().map(|row| residual(*row))) && changes(rows, unknowns, at)).then_some(own)
}

/// Do readings in these rows say more than one thing: are they more than the unknowns that they have a part in, and not all alike?
pub(crate) fn changes(rows: &[usize], unknowns: usize, at: impl Fn(usize, usize) -> f64) -> bool {
    let Some((first, others)) = rows.split_first() else { return false };
    let touched = (0..unknowns).filter(|j| rows.iter().any(|i| at(*i, *j) != 0.0)).count();
    rows.len() > touched && (0..=unknowns).any(|j| others.iter().any(|i| at(*i, j) != at(*first, j)))
}

/// The value that all of several have.
pub(crate) fn same(mut values: impl Iterator<Item = f64>) -> Option<f64> {
    let first = values.next()?;
    values.all(|value| value == first).then_some(first)
}

/// Are these residuals of readings of one value no more than rounding? A value that is stated as a reference (the norm of gravity) leaves the
/// noise of what is compared with it; a channel that is stuck has none.
pub(crate) fn is_all(value: f64, residuals: impl Iterator<Item = f64>) -> bool {
    let (squares, count) = residuals.fold((0.0, 0), |(sum, count), v| (sum + v * v, count + 1));
    // of readings of zero a solution of other rows leaves the rounding of its rounding
    quality::is_rounding(squares, count, value.abs().max(f64::EPSILON))
}

impl Fit {
    /// Sensors (with the value) whose readings are all the same to the last digit and are met to rounding, though their line is not the same for all: a
    /// channel that is stuck, or a resolution that shows nothing.
    pub fn stuck(&self) -> Vec<(&str, f64)> {
        let Fit { campaign, design, estimate, .. } = self;
        let value = |row: usize| {
            let origin = design.rows.get(row)?;
            let reading = campaign.readings.rows.get(origin.reading)?;
            reading.observations.iter().find(|own| own.sensor == origin.sensor).map(|own| own.value)
        };
        let (value, residual) = (|row| value(row).unwrap_or(f64::NAN), |row| estimate.residuals.or_nan(row));
        let n = campaign.unknowns();
        let at = |i: usize, j: usize| if j < n { design.jacobian[(i, j)] } else { design.predicted.at(i) };
        let of = |sensor: usize| {
            let rows = design.rows.iter().enumerate().filter(|(_, own)| own.sensor == sensor);
            let rows: Vec<usize> = rows.map(|(row, _)| row).collect();
            Some((campaign.sensor_id(sensor), stuck(&rows, (value, residual), n, at)?))
        };
        (0..campaign.bench.sensors.len()).filter_map(of).collect()
    }
}
