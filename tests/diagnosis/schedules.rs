//! The schedules of the seeded campaigns, and what is hidden in them.

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64Mcg;
use tumble::campaign::Campaign;
use tumble::diagnosis::Candidate;
use tumble::fit::{self, Fit, fit};
use tumble::wire::{self, Source};

/// Patterns outside the catalogue: of the settings, and of time.
pub const OUTSIDE: [&str; 4] =
    ["sin(7*beta)", "sign(sin(5*beta+0.4))", "gamma_deg_s*sin(5*alpha+1.3*beta)", "sign(sin(7*time_s/1000))"];

pub fn random(generator: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    Uniform::new(low, high).unwrap().sample(generator)
}

pub fn normal(generator: &mut Pcg64Mcg) -> f64 {
    StandardNormal.sample(generator)
}

/// Positions (alpha, beta), rates, repeats.
type GyroPlan = (Vec<(i32, i32)>, Vec<i32>, usize);

/// A schedule with times and temperatures, one of its tilts not estimated if asked for; returns the noise that belongs to its sensor.
pub fn schedule(name: &str, without: Option<&str>, generator: &mut Pcg64Mcg) -> (Campaign, f64) {
    let mut readings = Vec::new();
    let (mut time, mut temperature) = (random(generator, 60.0, 140.0), 22.0);
    let mut push = |position: usize, joints: String, generator: &mut Pcg64Mcg| {
        readings.push(format!(
            "{{ \"position\": \"{position}\", {joints}, \"time_s\": {time:.1}, \"temperature_c\": {temperature:.3} }}"
        ));
        time += random(generator, 60.0, 140.0);
        temperature += 0.12 * normal(generator);
    };
    let below = |generator: &mut Pcg64Mcg, most: usize| random(generator, 0.0, most as f64) as usize;
    let mut repeats_of: Vec<usize> = Vec::new();
    let gyro: Option<GyroPlan> = match name {
        // 6 to 24 positions of dividing heads, one to three rates, some positions twice
        "drawn-gyro" => {
            let step = [90, 45, 30][below(generator, 3)];
            let count = 6 + below(generator, 19);
            let mut positions: Vec<(i32, i32)> = Vec::new();
            while positions.len() < count.min((360 / step * 360 / step) as usize) {
                let heads = 360 / step as usize;
                let own = (step * below(generator, heads) as i32, step * below(generator, heads) as i32);
                if !positions.contains(&own) {
                    positions.push(own);
                }
            }
            let speeds = [10, 15, 20, 30, 40, 50, 60];
            let (first, many) = (below(generator, 7), 1 + below(generator, 3));
            let rates = (0..many).flat_map(|k| [1, -1].map(|sign| sign * speeds[(first + 2 * k) % 7])).collect();
            repeats_of = positions.iter().map(|_| 1 + below(generator, 3) / 2).collect();
            Some((positions, rates, 1))
        }
        "G5" => Some((vec![(0, 0), (0, 180), (180, 180), (90, 180), (0, 90)], vec![20, -20, 30, -30, 40, -40], 2)),
        "G16" => {
            let angles = [0, 90, 180, 270];
            Some((angles.iter().flat_map(|a| angles.map(|b| (*a, b))).collect(), vec![15, -15, 40, -40], 2))
        }
        "G16x45" => {
            let betas = [0, 135];
            let alphas = (0..8).map(|k| 45 * k);
            Some((alphas.flat_map(|a| betas.map(|b| (a, b))).collect(), vec![20, -20, 50, -50], 1))
        }
        _ => None,
    };
    let text = match gyro {
        Some((positions, rates, repeats)) => {
            for (k, (alpha, beta)) in positions.iter().enumerate() {
                for _ in 0..repeats * repeats_of.get(k).copied().unwrap_or(1) {
                    for rate in &rates {
                        let joints = format!("\"alpha_deg\": {alpha}, \"beta_deg\": {beta}, \"gamma_deg_s\": {rate}");
                        push(k + 1, joints, generator);
                    }
                }
            }
            format!(
                "{{ \"bench\": \"gyro-turntable\", \"known\": {{ \"kI\": {{ \"value\": -2.9222, \"u\": 0 }} }}, \"estimate\": {{ \"V0\": {{}}, \
                 \"dtheta_x0\": {{}}, \"dtheta_y0\": {{}}, \"dtheta_y1\": {{}}, \"dtheta_y2\": {{}}, \"dtheta_z2\": {{}} }}, \"readings\": [{}] }}",
                readings.join(", ")
            )
        }
        None => {
            // 10 to 40 heads, one to three rounds, begun anywhere
            let (heads, rounds, first) = match name {
                "drawn-accelerometer" => {
                    let heads = 10 + below(generator, 31);
                    (heads, 1 + below(generator, 3), [0.0, 0.0, 5.0][below(generator, 3)])
                }
                _ => (24, 3, 0.0),
            };
            for _ in 0..rounds {
                for k in 0..heads {
                    let angle = first + 360.0 * k as f64 / heads as f64;
                    push(15 * k, format!("\"beta_deg\": {}", (1e6 * angle).round() / 1e6), generator);
                }
            }
            format!(
                "{{ \"bench\": \"accelerometer-plumb-plane\", \"known\": {{ \"kI\": {{ \"value\": 1.299, \"u\": 0 }} }}, \
                 \"estimate\": {{ \"V0\": {{}}, \"dtheta_y2\": {{}}, \"dtheta_z2\": {{}} }}, \"readings\": [{}] }}",
                readings.join(", ")
            )
        }
    };
    let text = without.map_or(text.clone(), |tilt| {
        text.replace(&format!("\"{tilt}\": {{}}, "), "").replace(&format!(", \"{tilt}\": {{}}"), "")
    });
    let source = Source { name: name.into(), text };
    let campaign = wire::read_campaign(&source, &mut |_| unreachable!("built-in benches need no file")).unwrap();
    (campaign, if name == "A24" || name == "drawn-accelerometer" { 3e-6 } else { 1e-4 })
}

/// One of the catalogue that the positions show: families that stand for readings, steps, positions and time constants count once each, like
/// any other effect.
pub fn draw<'a>(visible: &'a [(Candidate, f64)], generator: &mut Pcg64Mcg) -> &'a (Candidate, f64) {
    let family = |c: &Candidate| {
        ["reading:", "position:", "step(", "exp("].iter().position(|prefix| c.regressor.starts_with(prefix))
    };
    let single: Vec<&(Candidate, f64)> = visible.iter().filter(|(c, _)| family(c).is_none()).collect();
    let present: Vec<usize> = (0..4).filter(|k| visible.iter().any(|(c, _)| family(c) == Some(*k))).collect();
    let pick = random(generator, 0.0, (single.len() + present.len()) as f64) as usize;
    if let Some(own) = single.get(pick) {
        return own;
    }
    let wanted = present.get(pick - single.len()).copied();
    let members: Vec<&(Candidate, f64)> = visible.iter().filter(|(c, _)| family(c) == wanted).collect();
    members[random(generator, 0.0, members.len() as f64) as usize % members.len()]
}

/// The linear model of a campaign at its exact fit.
pub fn fitted(campaign: &Campaign) -> Fit {
    fit(campaign, &fit::Settings::default()).unwrap()
}

/// What the model leaves of columns, `(1 - Q Q') c`, twice for rounding; nothing of those of which it leaves less than 1e-6.
fn outside(model: &Fit, columns: faer::Mat<f64>) -> faer::Mat<f64> {
    let q = model.estimate.factor.thin_q();
    let once = |columns: &faer::Mat<f64>| columns - q * (q.transpose() * columns);
    let mut left = once(&once(&columns));
    for (left, own) in left.col_iter_mut().zip(columns.col_iter()) {
        if !(left.norm_l2() > 1e-6 * own.norm_l2()) {
            left.iter_mut().for_each(|v| *v = 0.0);
        }
    }
    left
}

/// Cosines between columns outside the model.
pub fn cosines(model: &Fit, columns: &[&Vec<f64>]) -> faer::Mat<f64> {
    let rows = model.estimate.residuals.len();
    let matrix = faer::Mat::from_fn(rows, columns.len(), |i, j| columns[j].get(i).copied().unwrap_or(0.0));
    let mut left = outside(model, matrix);
    for column in left.col_iter_mut() {
        let norm = column.norm_l2();
        column.iter_mut().for_each(|v| *v /= if norm > 0.0 { norm } else { 1.0 });
    }
    left.transpose() * &left
}

/// Norm of a column outside the model for coefficient one, over the square root of the rows: what the model leaves of it, rms.
pub fn left_of(model: &Fit, column: &[f64]) -> f64 {
    let matrix = faer::Mat::from_fn(column.len(), 1, |i, _| column[i]);
    outside(model, matrix).norm_l2() / (column.len() as f64).sqrt()
}

/// A pattern that no one knows, of unit rms, and what it is: of time, of an angle, of positions, each times the rate or not.
pub fn unknown_pattern(campaign: &Campaign, generator: &mut Pcg64Mcg) -> (Vec<f64>, String) {
    let rows = &campaign.readings.rows;
    let n = rows.len();
    let time: Vec<f64> = (0..n).map(|k| k as f64 / (n.max(2) - 1) as f64).collect();
    let joints = rows.first().map_or(0, |row| row.joints.len());
    let of_joint = |k: usize| -> Vec<f64> {
        rows.iter().map(|row| row.joints.get(k).and_then(|s| s.keys().0).unwrap_or(0.0).to_radians()).collect()
    };
    let turning: Vec<usize> = (0..joints)
        .filter(|k| {
            let own = of_joint(*k);
            own.iter().any(|a| (a - own[0]).abs() > 1e-9)
        })
        .collect();
    let place = random(generator, 0.0, turning.len().max(1) as f64) as usize;
    let angle = of_joint(turning.get(place).copied().unwrap_or(0));
    let one = |generator: &mut Pcg64Mcg, low: f64, high: f64| random(generator, low, high);
    let kinds = ["course", "walk", "bump", "square", "lobe", "positions", "smooth", "halves", "cells", "saw"];
    let kind = kinds[random(generator, 0.0, kinds.len() as f64) as usize];
    let mut pattern: Vec<f64> = match kind {
        "course" => {
            let waves: Vec<(f64, f64)> =
                (0..3 + random(generator, 0.0, 4.0) as usize).map(|_| (normal(generator), normal(generator))).collect();
            let of = |t: f64| {
                let each = waves.iter().enumerate().map(|(k, (a, b))| {
                    let (s, c) = (std::f64::consts::TAU * (k as f64 + 0.5) * t).sin_cos();
                    a * c + b * s
                });
                each.sum()
            };
            time.iter().map(|t| of(*t)).collect()
        }
        "walk" => time
            .iter()
            .scan(0.0, |sum, _| {
                *sum += normal(generator);
                Some(*sum)
            })
            .collect(),
        "bump" => {
            let (at, width) = (one(generator, 0.0, 1.0), one(generator, 0.04, 0.15));
            time.iter().map(|t| (-0.5 * ((t - at) / width).powi(2)).exp()).collect()
        }
        "square" => {
            let (waves, phase) = (one(generator, 2.5, 7.0), one(generator, 0.0, 1.0));
            time.iter().map(|t| if (waves * t + phase).fract() < 0.5 { 1.0 } else { -1.0 }).collect()
        }
        "saw" => {
            let (waves, phase) = (one(generator, 2.5, 7.0), one(generator, 0.0, 1.0));
            time.iter().map(|t| (waves * t + phase).fract() - 0.5).collect()
        }
        "lobe" => {
            let (at, narrow) = (one(generator, 0.0, std::f64::consts::TAU), one(generator, 2.0, 8.0));
            angle.iter().map(|a| (narrow * ((a - at).cos() - 1.0)).exp()).collect()
        }
        "positions" => {
            let mut seen = std::collections::HashMap::new();
            rows.iter().map(|row| *seen.entry(row.position.clone()).or_insert_with(|| normal(generator))).collect()
        }
        "cells" => {
            let mut seen = std::collections::HashMap::new();
            rows.iter()
                .map(|row| *seen.entry(format!("{:?}", row.joints)).or_insert_with(|| normal(generator)))
                .collect()
        }
        "smooth" => {
            let waves: Vec<(f64, f64)> = (0..9)
                .map(|k| (normal(generator) / (1.0 + 0.5 * k as f64), normal(generator) / (1.0 + 0.5 * k as f64)))
                .collect();
            let of = |x: f64| {
                waves
                    .iter()
                    .enumerate()
                    .map(|(k, (a, b))| a * ((k + 1) as f64 * x).cos() + b * ((k + 1) as f64 * x).sin())
                    .sum()
            };
            angle.iter().map(|a| of(*a)).collect()
        }
        _ => {
            let (waves, phase) = (one(generator, 1.3, 6.7), one(generator, 0.0, 6.0));
            angle.iter().map(|a| if (waves * a + phase).sin() > 0.0 { 1.0 } else { -1.0 }).collect()
        }
    };
    let rate: Vec<f64> = rows.iter().map(|row| row.joints.iter().map(|s| s.rate_deg_s()).sum()).collect();
    let fastest = rate.iter().fold(0.0_f64, |most, own| most.max(own.abs()));
    let times_rate = fastest > 0.0 && random(generator, 0.0, 1.0) < 0.3;
    if times_rate {
        pattern.iter_mut().zip(&rate).for_each(|(own, rate)| *own *= rate / fastest);
    }
    let rms = (pattern.iter().map(|v| v * v).sum::<f64>() / n as f64).sqrt();
    pattern.iter_mut().for_each(|v| *v /= rms.max(f64::MIN_POSITIVE));
    (pattern, format!("{kind}{}", if times_rate { "*rate" } else { "" }))
}
