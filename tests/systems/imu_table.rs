//! A six-sensor IMU on a three-axis table.

use crate::support::*;
use serde_json::{Value, json};
use tumble::campaign::Campaign;
use tumble::compare;
use tumble::fit::{self, Settings};

const FOLDER: &str = "examples/20-imu-three-axis-table";
const ARCSEC: f64 = 648_000.0 / std::f64::consts::PI;
const TABLE: [&str; 6] = ["level_x", "level_y", "square_om", "middle_zero", "middle_linear", "inner_linear"];

#[test]
fn noiseless_truth_comes_back_with_a_perfect_table_and_with_table_errors_estimated_jointly() {
    for name in ["imu-table", "imu-table-tilted"] {
        let campaign = campaign(&format!("tests/data/simulated/{name}.campaign.json"));
        let truth = truth(&format!("tests/data/simulated/{name}.truth.json"));
        let fit = fit::fit(&campaign, &exact()).unwrap();
        assert!(fit.convergence.as_ref().unwrap().converged);
        // tilts and installation errors of less than 1e-3: readings of 2e4 carry them to 1e-16 * 2e4 / 2e4 / 1e-5 at best
        let (error, id) = worst_relative(&fit, &truth, 1e-5);
        println!("{name}: {id} {error:.1e}");
        assert!(error < 1e-9, "{name}: {id} {error:.1e}");
    }
}

#[test]
fn the_discrete_calibration_is_least_squares_on_the_24_positions_and_36_rate_runs() {
    let forms = compare::closed_forms("imu-three-axis-table").unwrap();
    for path in
        ["tests/data/simulated/imu-table.campaign.json".to_string(), format!("{FOLDER}/perfect-table.campaign.json")]
    {
        let comparison = compare::compare(&campaign(&path), &forms, &Settings::default()).unwrap();
        let group = &comparison.groups[0];
        assert_eq!(comparison.quantities.len(), 27);
        let u = |id: &str| {
            let p = comparison.all.parameters.iter().find(|p| p.id == id);
            p.and_then(|p| p.uncertainty.as_ref()).map(|u| u.u).unwrap()
        };
        for (k, id) in comparison.quantities.iter().enumerate() {
            let (closed, square) = (group.closed_form[k].unwrap(), group.like_for_like[k].unwrap());
            // without Earth rate in the rows the schedule is orthogonal: the same numbers, to the rounding of 252 readings
            assert!((closed - square).abs() < 1e-9 * closed.abs().max(1e-3), "{id}: {closed} {square}");
            // with it they part by less than a thousandth of an uncertainty
            assert!((closed - group.least_squares[k].unwrap()).abs() < 1e-3 * u(id), "{id}");
        }
    }
}

#[test]
fn installation_errors_hide_what_no_position_separates_and_it_is_named() {
    let fit = fit::fit(&campaign(&format!("{FOLDER}/everything.campaign.json")), &Settings::default()).unwrap();
    let mut only: Vec<&str> = fit.not_estimable.iter().flat_map(|s| &s.estimable).map(|c| c.text.as_str()).collect();
    only.sort_unstable();
    only.dedup();
    println!("{only:#?}");
    for expected in [
        "Egyz + mount_x",
        "Egzy - mount_x",
        "Eayz + mount_x",
        "Eazy - mount_x",
        "Egxz - inner_zero - mount_y",
        "Egzx + inner_zero + mount_y",
        "Eaxz - inner_zero - mount_y",
        "Eazx + inner_zero + mount_y",
        "Egxy + mount_z",
        "Egyx - mount_z",
        "Eaxy + mount_z",
        "Eayx - mount_z",
    ] {
        assert!(only.contains(&expected), "{expected}");
    }
    assert_eq!(fit.estimate.rank, fit.campaign.unknowns() - 4);
    // these two show only through Earth rate: tens of arcseconds, where the estimable ones have tenths
    for (id, least) in [("outer_zero", 20.0), ("square_mi", 20.0)] {
        let p = fit.parameters.iter().find(|p| p.id == id).unwrap();
        assert!(p.uncertainty.as_ref().unwrap().u * ARCSEC > least, "{id}");
    }
}

#[test]
fn intervals_hold_what_they_promise() {
    let truth = truth("tests/data/simulated/imu-table-tilted.truth.json");
    let campaign = campaign("tests/data/simulated/imu-table-tilted.campaign.json");
    // near enough to the truth that one linear step is exact to a thousandth of an uncertainty
    let near = started_at(&campaign, &truth, 1e-6);
    coverage("24 positions, 36 rate runs", &near, &truth, &|_, u| u.unwrap(), 2000, &Settings::default(), 0.0);
}

/// The same campaign with every estimate starting this relative distance from the truth.
fn started_at(campaign: &Campaign, truth: &Truth, away: f64) -> Campaign {
    use tumble::campaign::Role;
    let mut near = campaign.clone();
    for p in &mut near.parameters {
        if let Role::Estimated { start, .. } = &mut p.role {
            *start = Some(truth[&p.id] * (1.0 + away));
        }
    }
    near
}

/// Root mean square errors of one calibration: gyro and accelerometer installation (arcsec), scale factors (ppm), accelerometer zero (ug).
fn errors(value: &dyn Fn(&str) -> f64, truth: &Truth) -> [f64; 4] {
    let mut sums = [(0.0, 0.0); 4];
    for (id, own) in truth {
        let error = value(id) - own;
        let (k, scaled) = match id.as_bytes() {
            [b'E', b'g', ..] => (0, error * ARCSEC),
            [b'E', b'a', ..] => (1, error * ARCSEC),
            [b'K', b'g' | b'a', ..] => (2, error / own * 1e6),
            [b'A', _, b'0'] => (3, error / 2e4 * 1e6),
            _ => continue,
        };
        sums[k].0 += scaled * scaled;
        sums[k].1 += 1.0;
    }
    sums.map(|(sum, count)| sum / count)
}

/// `TUMBLE_WRITE=1` rewrites the table that the example shows; otherwise it must agree with what is committed.
#[test]
fn larger_table_errors_harm_the_discrete_calibration_and_not_the_joint_fit() {
    let forms = compare::closed_forms("imu-three-axis-table").unwrap();
    let joint = campaign("tests/data/simulated/imu-table-tilted.campaign.json");
    let plain = campaign("tests/data/simulated/imu-table.campaign.json");
    let sensors = truth("tests/data/simulated/imu-table.truth.json");
    let sizes = [0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];
    let draws = 12;
    let mut rows: Vec<Value> = Vec::new();
    for size in sizes {
        let mut random = random(20); // the same draws at every size
        let (mut closed_ms, mut joint_ms) = ([0.0; 4], [0.0; 4]);
        for _ in 0..draws {
            let mut all = sensors.clone();
            for id in TABLE {
                // linear errors: an arcsecond for each radian is as large as a zero error of an arcsecond
                all.insert(id.into(), size / ARCSEC * normal(&mut random));
            }
            let measured = simulated(&joint, &point(&joint, &all), &|_, u| u.unwrap(), &mut random);
            let discrete = plain.with_readings(measured.readings.clone());
            let values = compare::evaluate(&discrete, &forms, None, &discrete.readings).unwrap();
            let closed = |id: &str| {
                forms.formulas.iter().zip(&values).find(|((own, _), _)| own == id).and_then(|(_, v)| *v).unwrap()
            };
            let fit = fit::fit(&measured, &exact()).unwrap();
            let squares = |id: &str| compare::value_of(&fit, id).unwrap();
            for (sum, new) in closed_ms.iter_mut().zip(errors(&closed, &sensors)) {
                *sum += new / draws as f64;
            }
            for (sum, new) in joint_ms.iter_mut().zip(errors(&squares, &sensors)) {
                *sum += new / draws as f64;
            }
        }
        let named = |ms: [f64; 4]| {
            let [g, a, k, z] = ms.map(|v| (v.sqrt() * 1e4).round() / 1e4);
            json!({ "gyro_installation_arcsec": g, "accelerometer_installation_arcsec": a, "scale_factor_ppm": k, "accelerometer_zero_ug": z })
        };
        rows.push(json!({ "table_error_arcsec": size, "discrete": named(closed_ms), "joint": named(joint_ms) }));
    }
    for row in &rows {
        println!("{row}");
    }
    for key in ["gyro_installation_arcsec", "accelerometer_installation_arcsec"] {
        let of = |k: usize, way: &str| rows[k][way][key].as_f64().unwrap();
        for k in 2..sizes.len() {
            assert!(of(k, "discrete") > of(k - 1, "discrete"), "{key}: {k}");
        }
        assert!(of(7, "discrete") > 20.0 * of(0, "discrete"), "{key}");
        for k in 0..sizes.len() {
            let ratio = of(k, "joint") / of(0, "joint");
            assert!((0.9..1.1).contains(&ratio), "{key}: {ratio}");
        }
    }
    let path = format!("{FOLDER}/study.json");
    if std::env::var_os("TUMBLE_WRITE").is_some() {
        std::fs::write(&path, serde_json::to_string_pretty(&rows).unwrap() + "\n").unwrap();
    }
    let committed: Vec<Value> = serde_json::from_str(&read(&path)).unwrap();
    for (row, own) in rows.iter().zip(&committed) {
        for way in ["discrete", "joint"] {
            for (key, value) in own[way].as_object().unwrap() {
                let (a, b) = (row[way][key].as_f64().unwrap(), value.as_f64().unwrap());
                assert!((a - b).abs() <= 2e-4 + 1e-6 * b, "{way} {key}: {a} {b}");
            }
        }
    }
}
