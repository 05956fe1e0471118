//! What a fit says for correcting readings.

use super::bound::direction_of;
use super::calibration::{CalibratedLine, Calibration, Mounting, Parameters, Quantity, Span};
use super::choose::choose;
use super::solve::Corrector;
use super::triad::Triad;
use crate::algebra::Expression;
use crate::bench::{Bench, Link, Sensor};
use crate::campaign::{Campaign, Role};
use crate::elements::{Elements, Parts};
use crate::fit::{Fit, State};
use crate::language::sentence;
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Unit};
use std::collections::BTreeMap;

impl Calibration {
    /// What a fit says for correcting readings.
    ///
    /// ```
    /// use tumble::{correction::{Calibration, Corrector}, fit, wire};
    /// let text = r#"{ "bench": { "id": "b", "chain": [ {"joint": "t", "about": "x"} ],
    ///       "sensors": { "V": { "axes": {"I": "z"}, "model": "V0 + k*a_I + q*a_I^2" } } },
    ///     "known": { "q": { "value": 0.125 } }, "estimate": { "V0": {}, "k": {} },
    ///     "readings": [ {"t_deg": 0, "V": 2.625}, {"t_deg": 90, "V": 0.5}, {"t_deg": 180, "V": -1.375} ] }"#;
    /// let source = wire::Source { name: "b".into(), text: text.into() };
    /// let campaign = wire::read_campaign(&source, &mut |_| unreachable!())?;
    /// let calibration = Calibration::of(&fit::fit(&campaign, &fit::Settings::default())?);
    /// // V0 = 0.5 and k = 2: a reading of 2.625 is 1 g, by the exact line
    /// let corrected = Corrector::new(&calibration)?.correct(&[2.625], &[]);
    /// assert!((corrected.inputs[0] - 1.0).abs() < 1e-14);
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    pub fn of(fit: &Fit) -> Self {
        let campaign = &fit.campaign;
        let bench = &campaign.bench;
        let (mut lines, mut left_out) = (Vec::new(), Vec::new());
        let (mut norms, mut kept) = (Vec::new(), Vec::new());
        for sensor in &bench.sensors {
            let not_estimable: Vec<&str> = sensor
                .model
                .names()
                .into_iter()
                .filter(|name| fit.parameters.iter().any(|p| p.id == *name && p.state == State::NotEstimable))
                .collect();
            if !not_estimable.is_empty() {
                left_out
                    .push((sensor.id.clone(), sentence!("left-out-not-estimable", names = not_estimable.join(", "))));
                continue;
            }
            kept.extend(sensor.model.names());
            let in_use = |model: Expression, (column, line): &(String, Expression)| model.substitute(column, line);
            let line = CalibratedLine {
                sensor: sensor.id.clone(),
                unit: sensor.unit.clone(),
                axes: sensor.axes.iter().map(|(axis, d)| (axis.clone(), [d.x, d.y, d.z])).collect(),
                model: bench.in_use.iter().fold(sensor.model.clone(), in_use),
            };
            let follows = line.model.names().iter().any(|name| direction_of(&line, name).is_some());
            match line.model.as_norm() {
                Some(_) if !follows => norms.push(sensor),
                _ => lines.push(line),
            }
        }
        let used: Vec<usize> = (0..campaign.parameters.len())
            .filter(|k| campaign.parameters.get(*k).is_some_and(|p| kept.contains(&p.id.as_str())))
            .collect();
        let mounting = mounting(fit, &used);
        let mut calibration = Calibration {
            rate_unit: bench.units.rate,
            force_unit: bench.units.force,
            lines,
            left_out,
            inputs: Vec::new(),
            parameters: Parameters {
                order: used.iter().filter_map(|k| campaign.parameters.get(*k)).map(|p| p.id.clone()).collect(),
                values: used.iter().map(|k| fit.point.at(*k)).collect(),
                covariance: covariance(fit, &used, &used),
            },
            mounting,
            span: span(campaign),
            titles: BTreeMap::new(),
        };
        let measured = !norms.is_empty() || !bench.in_use.is_empty();
        of_norms(&mut calibration, bench, &norms);
        choose(&mut calibration, campaign);
        if measured {
            calibration.span = covered(&calibration, campaign).unwrap_or(calibration.span);
        }
        let given = calibration.inputs.iter().filter(|input| !input.solved).map(|input| &input.name);
        let read = calibration.lines.iter().map(|line| &line.sensor).chain(given);
        let titles = read.filter_map(|name| Some((name.clone(), campaign.titles.get(name)?.clone())));
        calibration.titles = titles.collect();
        calibration
    }
}

/// Is the covariance of the estimated ones of these parameters known?
fn is_known<'a>(fit: &Fit, mut used: impl Iterator<Item = &'a usize>) -> bool {
    let without = |k: &usize| fit.parameters.get(*k).is_some_and(|p| p.uncertainty.is_none());
    fit.noise.determined && (fit.noise.absorbed.is_empty() || !used.any(without))
}

/// Triads that are known by their norms: lines of their readings, and the parameters of these in the place of the norm's.
fn of_norms(calibration: &mut Calibration, bench: &Bench, norms: &[&Sensor]) {
    if norms.is_empty() {
        return;
    }
    let (parameters, values) = (calibration.parameters.order.clone(), calibration.parameters.values.clone());
    let lines = calibration.lines.clone();
    let stay: Vec<usize> = (0..parameters.len())
        .filter(|k| {
            parameters.get(*k).is_some_and(|p| lines.iter().any(|line| line.model.names().contains(&p.as_str())))
        })
        .collect();
    let mut slopes: Vec<Vec<f64>> =
        stay.iter().map(|k| (0..parameters.len()).map(|j| if j == *k { 1.0 } else { 0.0 }).collect()).collect();
    calibration.parameters.order = stay.iter().filter_map(|k| parameters.get(*k).cloned()).collect();
    calibration.parameters.values = stay.iter().map(|k| values.at(*k)).collect();
    for sensor in norms {
        let Some(triad) = Triad::of(sensor, bench, &parameters, &values) else {
            calibration.left_out.push((sensor.id.clone(), sentence!("its-norm-is-of-no-triad")));
            continue;
        };
        calibration.lines.extend(triad.lines);
        calibration.parameters.order.extend(triad.names);
        calibration.parameters.values.extend(triad.values);
        slopes.extend(triad.slopes.row_iter().map(|row| row.iter().copied().collect()));
    }
    let n = parameters.len();
    let slopes = DMatrix::from_fn(slopes.len(), n, |i, j| slopes.at(i).at(j));
    if !calibration.parameters.covariance.is_empty() {
        let covariance = DMatrix::from_fn(n, n, |i, j| calibration.parameters.covariance.as_slice().at(i).at(j));
        let covariance = &slopes * covariance * slopes.transpose();
        calibration.parameters.covariance = covariance.row_iter().map(|row| row.iter().copied().collect()).collect();
    }
    for row in calibration.mounting.iter_mut().flat_map(|mounting| &mut mounting.covariance) {
        let with_parameters = &slopes * DVector::from_fn(n, |j, _| row.as_slice().at(j));
        row.splice(..n, with_parameters.iter().copied());
    }
}

/// The largest rate and force among the calibration's own readings, corrected; `None` where nothing is corrected.
fn covered(calibration: &Calibration, campaign: &Campaign) -> Option<Span> {
    let corrector = Corrector::new(calibration).ok()?;
    let mut span = Span { rate: 0.0, force: 0.0 };
    for row in &campaign.readings.rows {
        let column = |name: &str| {
            let k = campaign.readings.columns.iter().position(|column| column == name)?;
            row.columns.get(k).copied().flatten()
        };
        let reading = |line: &CalibratedLine| {
            let sensor = campaign.bench.sensors.iter().position(|sensor| sensor.id == line.sensor);
            let read = sensor.and_then(|k| {
                row.observations.iter().find(|observation| observation.sensor == k).map(|observation| observation.value)
            });
            read.or_else(|| column(&line.sensor)).unwrap_or(f64::NAN)
        };
        let readings: Vec<f64> = calibration.lines.iter().map(reading).collect();
        let given = calibration.inputs.iter().filter(|input| !input.solved);
        let given: Vec<f64> = given.map(|input| column(&input.name).unwrap_or(input.fallback())).collect();
        let found = corrector.correct(&readings, &given).inputs;
        let size = |quantity: Quantity| {
            let of_quantity = calibration.solved().zip(&found).filter(|(input, _)| input.quantity == quantity);
            of_quantity.map(|(_, value)| value * value).sum::<f64>().sqrt()
        };
        // rows that cannot be corrected do not count: a maximum with not-a-number is the other one
        span = Span { rate: span.rate.max(size(Quantity::Rate)), force: span.force.max(size(Quantity::Force)) };
    }
    Some(span)
}

/// Covariance of the parameters with these indices: estimated ones, known ones with their uncertainty, and both together; empty where it is not known.
///
/// `cov(x, p) = (dx/dq) cov(q, p)` over the known inputs q.
fn covariance(fit: &Fit, rows: &[usize], columns: &[usize]) -> Vec<Vec<f64>> {
    if !is_known(fit, rows.iter().chain(columns)) {
        return Vec::new();
    }
    let unknowns = fit.campaign.unknowns();
    let known_of = |k: usize| fit.known_sensitivities.iter().find(|(parameter, ..)| *parameter == k);
    let covariance_of = |i: usize, j: usize| match (known_of(i), known_of(j)) {
        (Some((_, one, _)), Some((_, other, _))) => fit.campaign.correlation(i, j) * one.u * other.u,
        _ => 0.0,
    };
    let through = |k: usize, j: usize| -> f64 {
        fit.known_sensitivities.iter().map(|(m, _, c)| c.at(j) * covariance_of(*m, k)).sum()
    };
    let element = |i: usize, j: usize| match (i < unknowns, j < unknowns) {
        (true, true) if i < fit.covariance.nrows() && j < fit.covariance.ncols() => fit.covariance[(i, j)],
        (true, false) => through(j, i),
        (false, true) => through(i, j),
        (false, false) => covariance_of(i, j),
        _ => 0.0,
    };
    rows.iter().map(|i| columns.iter().map(|j| element(*i, *j)).collect()).collect()
}

/// The tilts after the last joint as a rotation, with their covariance beside the parameters `used`; `None` where none of them is known or estimated.
/// A tilt that follows a joint's angle belongs to that joint and is none of them.
///
/// With `a_k = R_1 ... R_(k-1) u_k`, the axis of tilt k on the mounting face: `dR/dt_k = [a_k]x R`.
fn mounting(fit: &Fit, used: &[usize]) -> Option<Mounting> {
    let campaign = &fit.campaign;
    let chain = &campaign.bench.chain;
    let after = chain.iter().rposition(|link| matches!(link, Link::Joint { .. })).map_or(0, |k| k + 1);
    let last = chain.part(after..);
    let mut rotation_ms = Rotation3::identity();
    let (mut tilts, mut missing) = (Vec::new(), Vec::new());
    let (mut places, mut axes) = (Vec::new(), Vec::new());
    for link in last {
        let Link::Tilt { name, about, times: None, .. } = link else { continue };
        let index = campaign.parameter_index(name)?;
        if campaign.parameters.get(index).is_none_or(|p| p.role == Role::AssumedZero) {
            continue;
        }
        tilts.push(name.clone());
        if fit.parameters.get(index).is_some_and(|p| p.state == State::NotEstimable) {
            missing.push(name.clone());
        }
        let angle = fit.point.at(index);
        places.push(index);
        axes.push(rotation_ms * about.unit());
        rotation_ms *= Rotation3::from_axis_angle(&Unit::new_unchecked(about.unit()), angle);
    }
    let rotation = *rotation_ms.matrix();
    let rows = |matrix: &Matrix3<f64>| [0, 1, 2].map(|i| [0, 1, 2].map(|j| matrix[(i, j)]));
    // zeros without a sign
    let by_tilt = axes.iter().map(|axis| rows(&(axis.cross_matrix() * rotation).map(|x| x + 0.0))).collect();
    let columns = [used, &places].concat();
    let covariance = covariance(fit, &places, &columns);
    (!tilts.is_empty()).then_some(Mounting { tilts, missing, rotation: rows(&rotation), by_tilt, covariance })
}

fn span(campaign: &Campaign) -> Span {
    let bench = &campaign.bench;
    let turning = |reading: &crate::campaign::Reading| reading.joints.iter().map(|j| j.rate_deg_s().abs()).sum::<f64>();
    let fastest = campaign.readings.rows.iter().map(turning).fold(0.0, f64::max);
    Span {
        rate: fastest * bench.units.rate.per_deg_s() + bench.earth_rate().norm(),
        force: bench.specific_force().norm(),
    }
}
