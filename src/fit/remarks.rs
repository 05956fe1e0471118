//! What a person should look at though nothing is wrong with the question: angles that may be radians, readings in another unit, rows that stand
//! twice, an absurd condition number.

use super::Fit;
use crate::campaign::{Campaign, JointState, Kind, Reading, Role};
use crate::elements::Elements;
use crate::language::{Sentence, sentence};
use crate::mix::Mix;
use crate::quality::{self, Repeated};
use crate::uncertainty::quantiles::chi_square_survival;
use crate::units::{self, Unit};
use std::f64::consts::TAU;
use std::hash::Hasher;

/// Above this the scaled columns are so nearly dependent that units cannot be the reason.
const ABSURD: f64 = 1e6;
/// A value read as radians is this near (degrees) to a multiple of `STEP` degrees: three decimals of a radian.
const NEAR: f64 = 0.06;
const STEP: f64 = 5.0;

/// A tilt is a small rotation: from one degree on it is none, in radians.
pub(crate) const STEEP: f64 = std::f64::consts::PI / 180.0;

pub(super) fn remarks(fit: &Fit) -> Vec<Sentence> {
    let campaign = &fit.campaign;
    let condition = fit.estimate.unknowns.condition();
    let absurd = condition.filter(|condition| *condition > ABSURD);
    let mut found: Vec<Sentence> = angles(campaign)
        .into_iter()
        .filter_map(|(name, values)| {
            // no unknowns: nothing is near singular
            radians(&values, condition.unwrap_or(1.0)).then(|| sentence!("all-values-of-lie-within-degrees-and", name))
        })
        .collect();
    found.extend(rates(campaign));
    found.extend(steep(fit).or_else(|| thousandfold(fit)));
    found.extend(fit.stuck().into_iter().map(|(sensor, value)| {
        sentence!("every-reading-of-a-channel-is-the-same", sensor = sensor.to_string(), value = value.to_string())
    }));
    found.extend(repeated(campaign));
    found.extend(backwards(campaign));
    let mut unread = campaign.readings.rows.iter().filter(|reading| reading.observations.is_empty());
    if let Some(first) = unread.next() {
        let count = 1 + unread.count();
        found.push(sentence!(
            "positions-without-a-reading",
            count,
            first = first.place.to_string().trim_end_matches('|')
        ));
    }
    if let Some(condition) = absurd {
        found.push(sentence!(
            "condition-the-readings-hardly-tell-some-parameters",
            condition = format!("{condition:.1e}")
        ));
    }
    if fit.noise.is_summed() {
        found.push(sentence!("interval-sums-over-the-likelihood-of-the-variances"));
    }
    found.extend(fit.untold_errors());
    found.extend(campaign.identity.expired().map(|(instrument, valid_to, date)| {
        sentence!("instrument-no-longer-valid", name = instrument.name, valid_to, date)
    }));
    found
}

/// Rates outside what the bench says of its table, or that would be round numbers if they were radians.
fn rates(campaign: &Campaign) -> Vec<Sentence> {
    let rate = |state: &JointState| match state {
        JointState::Held { .. } => None,
        JointState::WholeTurns { rate_deg_s }
        | JointState::PartTurns { rate_deg_s, .. }
        | JointState::Passing { rate_deg_s, .. } => Some(*rate_deg_s),
    };
    let mut found = Vec::new();
    for (k, joint) in campaign.bench.joints().enumerate() {
        let states = campaign.readings.rows.iter().filter_map(|reading| reading.joints.get(k));
        let values: Vec<f64> = states.filter_map(rate).filter(|rate| *rate != 0.0).collect();
        let name = format!("{joint}_deg_s");
        let range = campaign.bench.rate_range.iter().find(|(own, _)| own == joint);
        let outside = range.and_then(|(_, [least, most])| {
            let rate = values.iter().find(|rate| !(*least..=*most).contains(&rate.abs()))?;
            Some((*rate, *least, *most))
        });
        match outside {
            Some((rate, least, most)) => found.push(sentence!(
                "rates-outside-those-of-the-table",
                name,
                rate = rate.to_string(),
                least = least.to_string(),
                most = most.to_string()
            )),
            None if radians(&values, 1.0) => found.push(sentence!("rates-would-be-round-as-radians", name)),
            None => {}
        }
    }
    found
}

/// A tilt that is no small rotation beside a scale factor that is known: a reading a thousand times too large makes one.
fn steep(fit: &Fit) -> Option<Sentence> {
    let campaign = &fit.campaign;
    let largest = |of: &mut dyn Iterator<Item = (f64, String)>| of.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    let tilts = fit.parameters.iter().filter(|own| own.kind == Kind::Tilt);
    // one that may be small by its uncertainty says nothing
    let steep = tilts.filter(|own| {
        own.value.is_some_and(|tilt| tilt.abs() - own.uncertainty.as_ref().map_or(0.0, |own| own.expanded) > STEEP)
    });
    let (tilt, id) = largest(&mut steep.filter_map(|own| Some((own.value?, own.id.clone()))))?;
    let known = campaign.parameters.iter().filter(|own| own.kind == Kind::Coefficient);
    let known = known.filter_map(|own| match &own.role {
        Role::Known(known) if known.value != 0.0 => Some((known.value, own.id.clone())),
        _ => None,
    });
    let (_, factor) = largest(&mut { known })?;
    let sensor = campaign.bench.sensors.iter().find(|own| own.model.names().contains(&factor.as_str()))?;
    (tilt.abs() > STEEP).then(|| {
        sentence!(
            "tilt-is-no-small-rotation",
            id,
            tilt = format!("{:.3}", tilt.to_degrees()),
            factor,
            sensor = sensor.id.clone(),
            unit = sensor.unit.clone()
        )
    })
}

/// A coefficient that carries most of the readings, nearer to a thousand times its stated start (or to a thousandth) than to the start itself.
fn thousandfold(fit: &Fit) -> Option<Sentence> {
    let campaign = &fit.campaign;
    campaign.estimated().iter().zip(&fit.parameters).enumerate().find_map(|(k, (own, found))| {
        let Role::Estimated { start: Some(start), .. } = own.role else { return None };
        let (value, ratio) = (found.value?, (found.value? / start).abs());
        let thousands = (ratio.log10() / 3.0).round();
        if own.kind != Kind::Coefficient || !thousands.is_finite() || thousands == 0.0 {
            return None;
        }
        let (mut carried, mut all, mut sensor) = (0.0, 0.0, None);
        for (row, (origin, observed)) in fit.design.rows.iter().zip(&fit.system.observed).enumerate() {
            let by = fit.design.jacobian[(row, k)];
            if by != 0.0 {
                let read = observed + fit.design.predicted.at(row);
                sensor = sensor.or(campaign.bench.sensors.get(origin.sensor));
                carried += (by * value).powi(2);
                all += read * read;
            }
        }
        let sensor = sensor.filter(|_| carried > 0.5 * all)?;
        Some(sentence!(
            "factor-is-thousands-off-its-start",
            id = own.id.clone(),
            ratio = format!("{ratio:.1e}"),
            sensor = sensor.id.clone(),
            unit = sensor.unit.clone()
        ))
    })
}

/// Times that a model line or a random effect uses and that are in order but for single ones, which were typed wrong. (After a run that begins at zero the times stay below.)
///
/// Of `n` readings in any order `(n - 1)/2` steps go back, with the variance `(n + 1)/12` (L. Carlitz et al., J. Combin. Theory A 13 (1972), 47: nearly normal); they are in
/// order where so few do by chance with a probability below 0.001.
fn backwards(campaign: &Campaign) -> Vec<Sentence> {
    let mut used: Vec<&str> = campaign.bench.sensors.iter().flat_map(|sensor| sensor.model.names()).collect();
    used.extend(campaign.scatter.iter().filter_map(|line| line.over.as_ref()).map(|over| over.column.as_str()));
    let is_time = |name: &str| {
        let unit = units::of_column(name).and_then(|unit| Unit::parse(&unit).ok());
        unit.zip(Unit::parse("s").ok()).is_some_and(|(own, s)| own.conversion_for(&s, name).is_ok())
    };
    let of = |(k, name): (usize, &String)| {
        let rows = campaign.readings.rows.iter().enumerate();
        let times: Vec<(usize, f64)> =
            rows.filter_map(|(row, own)| Some((row, own.columns.get(k).copied()??))).collect();
        let next = times.iter().skip(2).map(|(_, time)| *time).chain([f64::INFINITY]);
        let steps = times.iter().zip(times.iter().skip(1)).zip(next);
        let back: Vec<_> = steps.filter(|((before, after), _)| after.1 < before.1).collect();
        let ((_, (row, time)), _) = back.first()?;
        let is_single = back.iter().all(|((before, _), next)| *next >= before.1);
        let (count, n) = (back.len(), times.len() as f64);
        let below = 0.5 * (n - 1.0) - count as f64;
        let chance = chi_square_survival(below * below * 12.0 / (n + 1.0), 1.0);
        (is_single && below > 0.0 && chance.is_some_and(|p| 0.5 * p < quality::ALPHA)).then(|| {
            let [reading, time] = [(row + 1).to_string(), time.to_string()];
            sentence!("times-go-back", name = name.clone(), count, reading, time)
        })
    };
    let columns = campaign.readings.columns.iter().enumerate();
    columns.filter(|(_, name)| used.contains(&name.as_str()) && is_time(name)).filter_map(of).collect()
}

/// Rows that stand there more than once, value by value to the last digit.
fn repeated(campaign: &Campaign) -> Option<Sentence> {
    let number = |state: &mut Mix, x: Option<f64>| state.write_u64(x.map_or(u64::MAX, |x| (x + 0.0).to_bits()));
    let of = |(k, row): (usize, &Reading)| {
        let (mut set, mut read) = (Mix::default(), Mix::default());
        // a row without a value repeats nothing
        read.write_usize(if row.observations.is_empty() { k + 1 } else { 0 });
        set.write(row.position.as_bytes());
        for (deg, deg_s, turns) in row.joints.iter().map(JointState::keys) {
            [deg, deg_s, turns].into_iter().for_each(|x| number(&mut set, x));
        }
        row.columns.iter().for_each(|x| number(&mut set, *x));
        for seen in &row.observations {
            read.write_usize(seen.sensor);
            number(&mut read, Some(seen.value));
        }
        (set.finish(), read.finish())
    };
    let rows = &campaign.readings.rows;
    let value = |row: usize, sensor: usize| {
        rows.get(row)?.observations.iter().find(|seen| seen.sensor == sensor).map(|seen| seen.value)
    };
    let hashes: Vec<(u64, u64)> = rows.iter().enumerate().map(of).collect();
    match quality::repeated(&hashes, campaign.bench.sensors.len(), value)? {
        Repeated::All(times) => Some(sentence!("every-row-stands-there-several-times", times = times.to_string())),
        Repeated::Block { first, again, rows } => {
            let [again, first] = [again, first].map(|from| format!("{} to {}", from + 1, from + rows));
            Some(sentence!("readings-repeat-others", again, first))
        }
    }
}

/// Each joint's commanded angles and each column in degrees that a model line uses.
fn angles(campaign: &Campaign) -> Vec<(String, Vec<f64>)> {
    let mut found: Vec<(String, Vec<f64>)> = Vec::new();
    for (k, joint) in campaign.bench.joints().enumerate() {
        let angle = |state: &JointState| match state {
            JointState::Held { angle_deg } | JointState::Passing { angle_deg, .. } => Some(*angle_deg),
            _ => None,
        };
        let states = campaign.readings.rows.iter().filter_map(|reading| reading.joints.get(k));
        found.push((format!("{joint}_deg"), states.filter_map(angle).collect()));
    }
    let used: Vec<&str> = campaign.bench.sensors.iter().flat_map(|sensor| sensor.model.names()).collect();
    for (k, column) in campaign.readings.columns.iter().enumerate() {
        if column.ends_with("_deg") && used.contains(&column.as_str()) && found.iter().all(|(name, _)| name != column) {
            let values = campaign.readings.rows.iter().filter_map(|reading| reading.columns.get(k).copied().flatten());
            found.push((column.clone(), values.collect()));
        }
    }
    found
}

/// Would these numbers make more sense as radians: all within a turn of radians, and as such multiples of five degrees, or all round the
/// circle while as degrees they leave the rows nearly dependent?
fn radians(values: &[f64], condition: f64) -> bool {
    let mut distinct: Vec<f64> = values.iter().copied().filter(|x| *x != 0.0).collect();
    distinct.sort_by(f64::total_cmp);
    distinct.dedup();
    let (Some(least), Some(most)) = (distinct.first(), distinct.last()) else { return false };
    if distinct.len() < 3 || distinct.iter().any(|x| x.abs() > TAU + 1e-3) {
        return false;
    }
    let off = |x: f64, step: f64| (x / step - (x / step).round()).abs() * step;
    let multiples = distinct.iter().all(|x| off(x.to_degrees(), STEP) < NEAR);
    let decimal = distinct.iter().all(|x| off(*x, 0.1) < 1e-9);
    (multiples && !decimal) || (most - least > 4.0 && distinct.len() >= 6 && !decimal && condition > 1e3)
}
