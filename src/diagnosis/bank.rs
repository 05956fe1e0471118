//! Kernels that know nothing of the catalogue.
#![allow(
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    reason = "a dense kernel: every list is as long as the design's rows; an angle in billionths of a radian fits"
)]

use super::common::{LENGTHS, NoiseFrom, share_of_wave};
use super::factor::{Factor, MANY};
use super::noise::{Weighted, positions};
use super::score::Kernel;
use crate::campaign::{Campaign, JointState};
use crate::design::{DesignMatrix, RowOrigin};
use crate::elements::numbered;
use crate::plan::Independent;
use faer::Mat;
use std::cell::LazyCell;

/// Most periods that are tried, those of one sensor alone included: they bound the work.
const PERIODS: usize = 60;
/// Harmonics of what repeats in time, `1/k` of each: the fewest with more directions than an effect in all but name has (`least_rank`). They have 0.90 of the power of a
/// square wave and 0.83 of a sawtooth's; two readings for a wave of the third make six a period.
const HARMONICS: usize = 3;
/// Waves whose share of the largest is smaller than this are left out: the score drops directions below 1e-7 of the largest eigenvalue, and the square of this is a thousandth of that.
const FADED: f64 = 1e-5;

/// The rows of a bank: their weights, a column of them as independent values of unit variance, and whether the noise is stated.
pub(super) struct Rows<'a> {
    weight: Vec<f64>,
    white: Box<dyn Fn(&[f64]) -> Vec<f64> + 'a>,
    /// Are the rows independent as they are?
    apart: bool,
    stated: bool,
}

impl<'a> From<&'a Weighted> for Rows<'a> {
    fn from(at: &'a Weighted) -> Self {
        let white = Box::new(|column: &[f64]| at.whiten(column));
        Rows { weight: at.weight.clone(), white, apart: at.floor.is_none(), stated: at.from == NoiseFrom::Stated }
    }
}

impl<'a> From<&'a Independent> for Rows<'a> {
    fn from(at: &'a Independent) -> Self {
        let weight = at.u.iter().map(|u| 1.0 / u).collect();
        Rows { weight, white: Box::new(|column: &[f64]| at.white(column)), apart: at.is_apart(), stated: true }
    }
}

pub(super) fn bank<'a>(campaign: &Campaign, design: &DesignMatrix, at: impl Into<Rows<'a>>) -> Vec<Kernel> {
    bank_of(campaign, design, at, |_, _| true)
}

/// Some kernels of the bank, by their places in it and the sensors that deviate alone.
pub(super) fn bank_of<'a>(
    campaign: &Campaign,
    design: &DesignMatrix,
    at: impl Into<Rows<'a>>,
    wanted: impl Fn(usize, Option<usize>) -> bool,
) -> Vec<Kernel> {
    let at = at.into();
    let n = at.weight.len();
    let rows = &design.rows;
    let m = rows.len();
    let sensors = rows.iter().map(|r| r.sensor).max().map_or(1, |s| s + 1);
    // rms of noise by sensor: a deviation is alike in all readings of a sensor
    let mut scale = vec![(0.0, 0.0); sensors];
    for (r, w) in rows.iter().zip(&at.weight) {
        scale[r.sensor].0 += w * w;
        scale[r.sensor].1 += 1.0;
    }
    let unit: Vec<f64> = rows.iter().map(|r| 1.0 / (scale[r.sensor].0 / scale[r.sensor].1 as f64).sqrt()).collect();
    let states = |r: &RowOrigin| campaign.readings.rows.get(r.reading).map(|x| x.joints.clone()).unwrap_or_default();
    let mut kernels: Vec<Kernel> = vec![];
    let of_sensor = |s: usize| rows.iter().filter(|r| r.sensor == s).count();
    let read: Vec<usize> = (0..sensors).filter(|s| of_sensor(*s) > 0).collect();
    // random effects of all sensors, independent between sensors, and of one of several alone
    let felt_by: Vec<Option<usize>> =
        std::iter::once(None).chain(read.iter().filter(|_| read.len() > 1).map(|s| Some(*s))).collect();
    let mut place = 0;
    let mut add = |(follows, per_mounting, one_of): (Option<String>, bool, usize),
                   deviates: &dyn Fn(usize) -> bool,
                   make: &dyn Fn() -> Factor| {
        let factor = LazyCell::new(make);
        for sensor in &felt_by {
            let felt = |i: usize| sensor.is_none_or(|s| s == rows[i].sensor);
            let among: Vec<usize> = (0..m).filter(|i| felt(*i)).collect();
            if !among.iter().any(|i| deviates(*i)) {
                continue;
            }
            place += 1;
            if !wanted(place - 1, *sensor) {
                continue;
            }
            // whitened, mean diagonal one; rows of priors have none
            let scaled = |trace: f64| if trace > 0.0 { (among.len() as f64 / trace).sqrt() } else { 0.0 };
            let factor = match &*factor {
                Factor::Apart(all) => {
                    let weighted = |(i, v): &(usize, f64)| felt(*i).then(|| (*i, v * unit[*i] * at.weight[*i]));
                    let columns = all.iter().map(|column| column.iter().filter_map(weighted).collect());
                    let mut columns: Vec<Vec<(usize, f64)>> = columns.filter(|c: &Vec<_>| !c.is_empty()).collect();
                    let scale = scaled(columns.iter().flatten().map(|(_, v)| v * v).sum());
                    columns.iter_mut().flatten().for_each(|(_, v)| *v *= scale);
                    Factor::Apart(columns)
                }
                Factor::Dense(all) => {
                    let columns: Vec<usize> =
                        (0..all.ncols()).filter(|j| among.iter().any(|i| all[(*i, *j)] != 0.0)).collect();
                    let mut f = Mat::<f64>::zeros(n, columns.len());
                    for (to, from) in columns.into_iter().enumerate() {
                        let mut col = vec![0.0; n];
                        among.iter().for_each(|i| col[*i] = all[(*i, from)] * unit[*i]);
                        f.col_as_slice_mut(to).copy_from_slice(&(at.white)(&col));
                    }
                    let trace: f64 = (0..f.ncols()).map(|j| f.col(j).squared_norm_l2()).sum();
                    f *= faer::Scale(scaled(trace));
                    Factor::Dense(f)
                }
            };
            let alone = |what: &String| match sensor {
                Some(s) => format!("{what}, of {} alone", campaign.sensor_id(*s)),
                None => what.clone(),
            };
            let follows = follows.as_ref().map(alone);
            kernels.push(Kernel { follows, per_mounting, one_of, factor, sensor: *sensor });
        }
    };
    // of many groups each has few rows
    let indicator = |g: &(Vec<usize>, usize), x: &dyn Fn(usize) -> f64| {
        let mut columns: Vec<Vec<(usize, f64)>> = vec![vec![]; g.1];
        (0..m).filter(|i| x(*i) != 0.0).for_each(|i| columns[g.0[i]].push((i, x(i))));
        columns.retain(|column| !column.is_empty());
        let factor = Factor::Apart(columns);
        if at.apart && g.1 > MANY { factor } else { Factor::Dense(factor.dense(m)) }
    };
    // so many columns of each sensor, from the row and the number of the column
    let of_each = |count: usize, value: &dyn Fn(usize, usize) -> f64| {
        let at = |i: usize, j: usize| if j / count == rows[i].sensor { value(i, j % count) } else { 0.0 };
        Factor::Dense(Mat::from_fn(m, sensors * count, at))
    };
    let one = |_: usize| 1.0;
    let named = |what: &str, by_rate: bool| {
        (Some(if by_rate { format!("{what}, in proportion to the rate") } else { what.to_string() }), false, 1)
    };
    // the turning rate of a reading over the largest
    let rate: Vec<f64> = rows.iter().map(|r| states(r).iter().map(|s| s.rate_deg_s()).sum::<f64>()).collect();
    let fastest = rate.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let times_rate = |i: usize| if fastest > 0.0 { rate[i] / fastest } else { 0.0 };
    let (always, turns) = (|_: usize| true, |i: usize| rate[i] != 0.0);
    let rates = numbered(rate.iter().map(|r| r.to_bits())).1;
    let setting = numbered(rows.iter().map(|r| (r.sensor, states(r).iter().map(JointState::bits).collect::<Vec<_>>())));
    let still = |s: &JointState| {
        if s.rate_deg_s() == 0.0 { s.bits() } else { [0; 3] }
    };
    let place = numbered(rows.iter().map(|r| (r.sensor, states(r).iter().map(still).collect::<Vec<_>>())));
    let labels = positions(campaign, design, n);
    let label = numbered(rows.iter().enumerate().map(|(i, r)| (r.sensor, labels[i])));
    if setting.1 < m {
        add(named("the setting", false), &always, &|| indicator(&setting, &one));
    }
    if place.1 > 1 && place.0 != setting.0 {
        add(named("the angles", false), &always, &|| indicator(&place, &one));
    }
    if label.1 > 1 && label.0 != place.0 && label.0 != setting.0 && label.1 < m {
        add((named("the position", false).0, true, 1), &always, &|| indicator(&label, &one));
    }
    if rates > 1 {
        if place.1 > 1 {
            add(named("the angles", true), &turns, &|| indicator(&place, &times_rate));
        }
        let by_rate = numbered(rows.iter().enumerate().map(|(i, r)| (r.sensor, rate[i].to_bits())));
        if by_rate.1 > 2 && by_rate.0 != setting.0 {
            add(named("the rate", false), &always, &|| indicator(&by_rate, &one));
        }
    }
    for (k, joint) in campaign.bench.joints().enumerate() {
        let held = |r: &RowOrigin| states(r).get(k).and_then(JointState::held_deg);
        let angle: Vec<Option<f64>> = rows.iter().map(|r| held(r).map(f64::to_radians)).collect();
        let (_, distinct) =
            numbered(angle.iter().flatten().map(|a| (a.rem_euclid(std::f64::consts::TAU) * 1e9).round() as i64));
        if distinct < 3 {
            continue;
        }
        // beyond half the distinct angles harmonics repeat; of order 24 the smooth kernels have nothing left, and the rough one 2 %
        let most = (distinct / 2).min(24);
        let harmonics = LazyCell::new(|| {
            Mat::from_fn(m, 2 * most, |i, h| match ((h / 2 + 1) as f64, angle[i]) {
                (order, Some(a)) if h % 2 == 0 => (order * a).cos(),
                (order, Some(a)) => (order * a).sin(),
                _ => 0.0,
            })
        });
        // radians: a lobe as wide as a quarter turn, and one of a third of that
        for (is_smooth, length) in [(true, 1.0), (false, 0.3)] {
            for by_rate in [false, true] {
                if by_rate && rates < 2 {
                    continue;
                }
                let share = |order: f64| match is_smooth {
                    true => (-0.25 * order * order * length * length).exp(),
                    false => (1.0 / (1.0 + (order * length).powi(2))).sqrt(),
                };
                let mut shares: Vec<f64> = (0..2 * most).map(|h| share((h / 2 + 1) as f64)).collect();
                shares.retain(|share| *share > FADED);
                let kept = shares.len();
                // a mean is in the model, its product with the rate only where the scale factor is estimated
                shares.extend(by_rate.then_some(1.0));
                let waves = shares.len();
                let value = |i: usize, h: usize| {
                    if angle[i].is_none() {
                        return 0.0;
                    }
                    let v = if h < kept { shares[h] * harmonics[(i, h)] } else { 1.0 };
                    if by_rate { v * times_rate(i) } else { v }
                };
                let deviates = |i: usize| angle[i].is_some() && (!by_rate || turns(i));
                add(named(joint, by_rate), &deviates, &|| of_each(waves, &value));
            }
        }
    }
    // time, or order
    let column = campaign.readings.columns.iter().position(|c| c == "time_s");
    let time: Vec<f64> = rows
        .iter()
        .map(|r| {
            let t = column.and_then(|c| campaign.readings.rows.get(r.reading)?.columns.get(c).copied().flatten());
            t.unwrap_or(r.reading as f64)
        })
        .collect();
    let (a, b) = time.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(*t), b.max(*t)));
    if b > a && m > 4 {
        // 64 waves bound the work, 240 that of all sensors together
        let most = (m / sensors.max(1)).saturating_sub(1).min(64).min(240 / sensors.max(1)).max(1);
        let what = if column.is_some() { "time" } else { "the order of the readings" };
        let phase = |i: usize| std::f64::consts::PI * (time[i] - a) / (b - a);
        let courses = LazyCell::new(|| Mat::from_fn(m, most + 1, |i, h| (h as f64 * phase(i)).cos()));
        let by_rate = LENGTHS.iter().filter(|_| rates > 1).map(|length| (*length, true));
        for (length, by_rate) in LENGTHS.iter().map(|length| (*length, false)).chain(by_rate) {
            // from the mean on where it is a factor of the rate
            let first = usize::from(!by_rate);
            let mut shares: Vec<f64> = (first..=most).map(|h| share_of_wave(h as f64, length)).collect();
            let top = shares.first().copied().unwrap_or_default();
            shares.retain(|share| *share > FADED * top);
            let waves = shares.len();
            let value = |i: usize, h: usize| {
                let course = shares[h] * courses[(i, h + first)];
                if by_rate { course * times_rate(i) } else { course }
            };
            add(named(what, by_rate), if by_rate { &turns } else { &always }, &|| of_each(waves, &value));
        }
        // what repeats in time: periods of six readings and more, with three harmonics; half a wave more in the record each
        let readings = m / sensors.max(1);
        let periods: Vec<f64> = (4..=readings / 3).map(|halves| 2.0 * (b - a) / halves as f64).collect();
        let apart = periods.len().div_ceil(PERIODS / felt_by.len().max(1)).max(1);
        let (follows, ..) = named(what, false);
        let tried: Vec<f64> = periods.into_iter().step_by(apart).collect();
        for period in &tried {
            let value = |i: usize, h: usize| {
                let order = (h / 2 + 1) as f64;
                let phase = std::f64::consts::TAU * order * (time[i] - a) / period;
                (if h.is_multiple_of(2) { phase.cos() } else { phase.sin() }) / order
            };
            add((follows.clone(), false, tried.len()), &always, &|| of_each(2 * HARMONICS, &value));
        }
    }
    // a dense factor: 400 rows bound the work
    if at.stated && m <= 400 {
        let own = |i: usize, j: usize| if i == j { 1.0 / (at.weight[i] * unit[i]) } else { 0.0 };
        add((None, false, 1), &always, &|| Mat::from_fn(m, m, own).into());
    }
    kernels
}
