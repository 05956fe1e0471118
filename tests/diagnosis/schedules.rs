//! The schedules of the seeded campaigns, and what is hidden in them.

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64Mcg;
use tumble::campaign::Campaign;
use tumble::diagnosis::{Candidate, Pool};
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
    let gyro: Option<GyroPlan> = match name {
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
                for _ in 0..repeats {
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
            for _ in 0..3 {
                for k in 0..24 {
                    push(15 * k, format!("\"beta_deg\": {}", 15 * k), generator);
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
    (campaign, if name == "A24" { 3e-6 } else { 1e-4 })
}

/// One of the catalogue that the positions show: families that stand for readings, steps, positions and time constants count once each, like
/// any other effect.
pub fn draw<'a>(visible: &'a [(Candidate, f64)], generator: &mut Pcg64Mcg) -> &'a (Candidate, f64) {
    let family = |c: &Candidate| {
        ["reading:", "position:", "step(", "exp("].iter().position(|prefix| c.regressor.starts_with(prefix))
    };
    let single: Vec<&(Candidate, f64)> = visible.iter().filter(|(c, _)| family(c).is_none()).collect();
    let pick = random(generator, 0.0, (single.len() + 4) as f64) as usize;
    if let Some(own) = single.get(pick) {
        return own;
    }
    let members: Vec<&(Candidate, f64)> =
        visible.iter().filter(|(c, _)| family(c) == Some(pick - single.len())).collect();
    members[random(generator, 0.0, members.len() as f64) as usize % members.len()]
}

/// The linear model of a campaign at its exact fit.
pub fn fitted(campaign: &Campaign) -> Fit {
    fit(campaign, &fit::Settings::default()).unwrap()
}

/// Cosines between columns outside the model.
pub fn cosines(model: &Fit, columns: &[&Vec<f64>]) -> faer::Mat<f64> {
    let rows = model.estimate.residuals.len();
    let matrix = faer::Mat::from_fn(rows, columns.len(), |i, j| columns[j].get(i).copied().unwrap_or(0.0));
    Pool::new(matrix, model.estimate.factor.thin_q(), &model.estimate.residuals).all_cosines()
}

/// Norm of a column outside the model for coefficient one, over the square root of the rows: what the model leaves of it, rms.
pub fn left_of(model: &Fit, column: &[f64]) -> f64 {
    let matrix = faer::Mat::from_fn(column.len(), 1, |i, _| column[i]);
    let share = Pool::new(matrix, model.estimate.factor.thin_q(), &model.estimate.residuals).visible()[0];
    let norm = column.iter().map(|v| v * v).sum::<f64>().sqrt();
    share * norm / (column.len() as f64).sqrt()
}
