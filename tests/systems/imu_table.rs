//! A six-sensor IMU on a three-axis table.

use crate::support::*;
use serde_json::{Value, json};
use tumble::campaign::Campaign;
use tumble::compare;
use tumble::fit::{self, Settings};

const FOLDER: &str = "examples/10-imu-three-axis-table";
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
        "Egyx + mount_x",
        "Egzx - mount_x",
        "Eayx + mount_x",
        "Eazx - mount_x",
        "Egxy - inner_zero - mount_y",
        "Egzy + inner_zero + mount_y",
        "Eaxy - inner_zero - mount_y",
        "Eazy + inner_zero + mount_y",
        "Egxz + mount_z",
        "Egyz - mount_z",
        "Eaxz + mount_z",
        "Eayz - mount_z",
    ] {
        assert!(only.contains(&expected), "{expected}");
    }
    assert_eq!(fit.estimate.unknowns.rank, fit.campaign.unknowns() - 4);
    // which table tilt hides in which installation error, two or three names at a time
    let report = tumble::report::fit_report(&fit);
    let hides = |own: &Option<tumble::language::Sentence>| own.as_ref().map_or(String::new(), ToString::to_string);
    let free: Vec<(&str, String)> = report.not_estimable.iter().map(|d| (d.text.as_str(), hides(&d.hides))).collect();
    let mut free: Vec<(&str, &str)> = free.iter().map(|(text, hides)| (*text, hides.as_str())).collect();
    free.sort_unstable();
    println!("{free:#?}");
    assert_eq!(
        free,
        [
            ("Egxy + mount_y", "mount_y is absorbed by Egxy, Egzy, Eaxy and Eazy"),
            ("Egxz - mount_z", "mount_z is absorbed by Egxz, Egyz, Eaxz and Eayz"),
            ("Egyx - mount_x", "mount_x is absorbed by Egyx, Egzx, Eayx and Eazx"),
            ("inner_zero - mount_y", ""),
        ]
    );
    for defect in &report.not_estimable {
        let size = |own: &f64| (own.abs() - 1.0).abs() < 1e-9;
        assert!(defect.direction.values().all(size) && defect.combination.values().all(size), "{defect:?}");
    }
    // these two show only through Earth rate: tens of arcseconds, where the estimable ones have tenths
    for (id, least) in [("outer_zero", 20.0), ("square_mi", 20.0)] {
        let p = fit.parameters.iter().find(|p| p.id == id).unwrap();
        assert!(p.uncertainty.as_ref().unwrap().u * ARCSEC > least, "{id}");
    }
}

/// Away from the reference point the second-order terms of the accelerometers separate the mounting from the installation errors by a
/// hair: to radians. Gauss-Newton must not follow that.
#[test]
fn gauss_newton_ends_soon_where_installation_errors_hide_the_mounting() {
    let campaign = campaign(&format!("{FOLDER}/everything.campaign.json"));
    let fit = fit::fit(&campaign, &exact()).unwrap();
    let record = fit.convergence.as_ref().unwrap();
    println!("{} iterations, {:?}, held {:?}", record.iterations.len(), record.stop, record.held);
    let trials: f64 = record.iterations.iter().map(|own| 1.0 - own.share.log2()).sum();
    // hundreds of iterations and halvings once
    assert!(record.iterations.len() < 30 && trials < 60.0, "{trials}");
    assert!(record.converged && fit.is_rejected());
    let held: Vec<&str> = record.held.iter().map(|k| campaign.parameters[*k].id.as_str()).collect();
    assert_eq!(held, ["inner_zero", "mount_x", "mount_y", "mount_z"]);
    assert_eq!(fit.not_estimable.len(), 4);
    let truth = truth("tests/data/simulated/imu-table-tilted.truth.json");
    for id in ["level_x", "level_y", "square_om", "middle_zero", "middle_linear", "inner_linear", "Kgx", "Kaz"] {
        let p = fit.parameters.iter().find(|p| p.id == id).unwrap();
        let u = p.uncertainty.as_ref().unwrap().u;
        assert!((p.value.unwrap() - truth[id]).abs() < 5.0 * u, "{id}: {:?} {}", p.value, truth[id]);
    }
}

/// A campaign without noise says so: a scale at the level of rounding for each sensor, and converged.
#[test]
fn a_noiseless_campaign_whose_scales_are_estimated_has_uncertainties_at_the_level_of_rounding() {
    for name in ["imu-table", "imu-table-tilted"] {
        let campaign = campaign(&format!("tests/data/simulated/{name}.campaign.json"));
        let truth = truth(&format!("tests/data/simulated/{name}.truth.json"));
        let settings = Settings { weighting: fit::Weighting::Relative, ..exact() };
        let fit = fit::fit(&campaign, &settings).unwrap();
        let record = fit.convergence.as_ref().unwrap();
        println!(
            "{name}: scales {:?}, {:?}, {} iterations",
            fit.estimate.group_scale,
            record.stop,
            record.iterations.len()
        );
        assert!(!fit.is_rejected() && record.converged);
        for (id, p) in fit.parameters.iter().map(|p| (&p.id, p)) {
            let u = p.uncertainty.as_ref().unwrap().u;
            // readings of 2e4 are rounded to 4e-12: 2e-16 of themselves, and of what they are multiplied by
            let size = if id.starts_with('E') || !id.contains(|c| "KAD".contains(c)) { 1.0 } else { 2e4 };
            println!("{id} {u:.1e} {:.1e}", p.value.unwrap() - truth[id]);
            assert!(u > 1e-18 * size && u < 1e-14 * size, "{id}: {u}");
            assert!((p.value.unwrap() - truth[id]).abs() <= 20.0 * u, "{id}");
        }
    }
}

/// Gauss-Newton steps on compressed rows; the last step, with all diagnostics, on all of them.
#[test]
fn a_step_on_compressed_rows_is_the_adjustment_of_all_rows() {
    for path in ["perfect-table", "table-errors"] {
        let campaign = campaign(&format!("{FOLDER}/{path}.campaign.json"));
        let model = tumble::design::Model::new(&campaign).unwrap();
        let design = tumble::design::assemble(&campaign, &model, &campaign.reference_point()).unwrap();
        let system = fit::weigh(&campaign, &design, fit::Weighting::AsStated).unwrap();
        let settings = tumble::estimate::Settings::default();
        let all = tumble::estimate::adjust(&system, &settings).unwrap();
        let short = tumble::estimate::solve(&system, &Default::default(), &settings).unwrap();
        assert_eq!(all.unknowns.rank, short.rank);
        for (j, (a, b)) in all.unknowns.solution.iter().zip(&short.solution).enumerate() {
            let u = all.unknowns.standard_uncertainty[j].unwrap();
            assert!((a - b).abs() < 1e-12 * a.abs().max(u), "{path} {j}: {a} {b}");
        }
        for (a, b) in all.group_scale.iter().zip(&short.group_scale) {
            // the iteration ends at 1e-11
            assert!((a.unwrap() / b - 1.0).abs() < 1e-11);
        }
    }
}

#[test]
fn intervals_hold_what_they_promise() {
    let truth = truth("tests/data/simulated/imu-table-tilted.truth.json");
    let campaign = campaign("tests/data/simulated/imu-table-tilted.campaign.json");
    // near enough to the truth that one linear step is exact to a thousandth of an uncertainty
    let near = started_at(&campaign, &truth, 1e-6);
    coverage("24 positions, 36 rate runs", &near, &truth, &|_, u| u.unwrap(), 2000, &Settings::default(), 0.0);
    // scatters of six sensors estimated, the table's tilts common to all: weights that are estimated must not make intervals short
    let near = started_at(&self::campaign(&format!("{FOLDER}/table-errors.campaign.json")), &truth, 1e-6);
    let sd = |sensor: usize, _: Option<f64>| if sensor < 3 { 0.02 } else { 0.1 };
    coverage("the same, scatters estimated", &near, &truth, &sd, 2000, &Settings::default(), 0.0);
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
            let squares = |id: &str| value(&fit, id);
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
