//! Inputs known from the bench's chain come back when a calibration is applied to the readings they cause.
//!
//! The readings and the inputs come from `design` (the exact chain of rotations), the correction knows neither: both must agree.

use crate::support::exact;
use std::path::Path;
use tumble::campaign::{Campaign, JointState};
use tumble::correction::{Calibration, Corrector, Quantity};
use tumble::design::{Instant, Kinematics, Model, kinematics};
use tumble::wire;

pub fn example(name: &str) -> Campaign {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name);
    let folder = path.parent().unwrap().to_path_buf();
    let source = wire::Source { name: name.into(), text: std::fs::read_to_string(&path).unwrap() };
    wire::read_campaign(&source, &mut |other| {
        let text = std::fs::read_to_string(folder.join(other)).unwrap();
        Ok(wire::Source { name: other.into(), text })
    })
    .unwrap()
}

/// Rate and force at the sensor while each joint passes an odd angle at an odd rate, and the readings that the lines give there.
fn sample(campaign: &Campaign, point: &[f64], k: usize) -> (Kinematics, Vec<f64>, Vec<Option<f64>>) {
    let bench = &campaign.bench;
    let joints: Vec<JointState> = bench
        .joints()
        .enumerate()
        .map(|(j, _)| JointState::Passing {
            angle_deg: (37.0 * (k + 1) as f64 + 71.0 * j as f64) % 360.0,
            rate_deg_s: 20.0 * ((k * 7 + j * 3) as f64).sin(),
        })
        .collect();
    let instant = Instant {
        angle_deg: joints.iter().map(|j| j.keys().0.unwrap()).collect(),
        rate_deg_s: joints.iter().map(JointState::rate_deg_s).collect(),
    };
    let tilts: Vec<f64> = bench.tilts().map(|name| point[campaign.parameter_index(name).unwrap()]).collect();
    let mut at = Kinematics::default();
    kinematics(bench, &tilts, &instant, &mut at);
    let mut own = campaign.clone();
    own.readings.rows.truncate(1);
    own.readings.rows[0].joints = joints.into();
    let columns = own.readings.rows[0].columns.clone();
    let model = Model::new(&own).unwrap();
    let (mut gradient, mut work) = (vec![0.0; own.parameters.len()], model.workspace());
    let readings =
        (0..bench.sensors.len()).map(|s| model.predict(&own, 0, s, point, &mut gradient, &mut work).unwrap()).collect();
    (at, readings, columns.to_vec())
}

fn inputs_return(name: &str) -> usize {
    let campaign = example(name);
    let fit = exact(&campaign);
    let calibration = Calibration::of(&fit);
    let corrector = Corrector::new(&calibration).unwrap();
    let places: Vec<usize> = calibration
        .lines
        .iter()
        .map(|line| campaign.bench.sensors.iter().position(|s| s.id == line.sensor).unwrap())
        .collect();
    let solved = || calibration.inputs.iter().filter(|input| input.solved);
    for k in 0..20 {
        let (at, all, columns) = sample(&campaign, &fit.point, k);
        let readings: Vec<f64> = places.iter().map(|s| all[*s]).collect();
        let given: Vec<f64> = calibration
            .inputs
            .iter()
            .filter(|input| !input.solved)
            .map(|input| match input.quantity {
                Quantity::Rate => input.direction().dot(&at.rate),
                Quantity::Force => input.direction().dot(&at.force),
                Quantity::Column => {
                    let column = campaign.readings.columns.iter().position(|c| *c == input.name).unwrap();
                    columns[column].unwrap()
                }
                _ => 0.0,
            })
            .collect();
        let corrected = corrector.correct(&readings, &given);
        assert!(corrected.converged, "{name}, sample {k}");
        for (input, found) in solved().zip(&corrected.inputs) {
            let vector = if input.quantity == Quantity::Rate { &at.rate } else { &at.force };
            let truth = input.direction().dot(vector);
            let size = vector.norm();
            assert!((found - truth).abs() <= 1e-12 * size.max(1e-3), "{name}, {}: {found} for {truth}", input.name);
        }
    }
    solved().count()
}

#[test]
fn inputs_return_for_every_bench_with_sensors_of_rate_or_force() {
    for (name, solved) in [
        ("01-gyro-table/table1.campaign.json", 1),
        ("02-accelerometer/table2.campaign.json", 1),
        ("03-your-own-positions/my-positions.campaign.json", 1),
        ("10-imu-three-axis-table/perfect-table.campaign.json", 6),
        ("10-imu-three-axis-table/table-errors.campaign.json", 6),
        ("11-gyro-skew-triad/direct.campaign.json", 3),
        ("13-accelerometer-dividing-head/head-24.campaign.json", 1),
    ] {
        assert_eq!(inputs_return(name), solved, "{name}");
    }
}

/// A cube's theodolites follow no rate and no force: there is nothing to correct, and the reason is said.
#[test]
fn what_follows_no_input_is_said() {
    let calibration = Calibration::of(&exact(&example("12-cube-mirror/attitude.campaign.json")));
    let error = Corrector::new(&calibration).unwrap_err();
    assert!(
        error.to_string().contains("corrects nothing") && error.to_string().contains("does not depend on a rate"),
        "{error}"
    );
}

/// A report's correction, written and read again, corrects alike.
#[test]
fn a_calibration_survives_its_file() {
    let calibration = Calibration::of(&exact(&example("10-imu-three-axis-table/perfect-table.campaign.json")));
    let file = wire::CorrectionFile::of(&calibration).unwrap();
    let text = serde_json::to_string(&file).unwrap();
    let read: wire::CorrectionFile = serde_json::from_str(&text).unwrap();
    let again = read.into_calibration().unwrap();
    let (a, b) = (Corrector::new(&calibration).unwrap(), Corrector::new(&again).unwrap());
    let readings: Vec<f64> = a.readings(&[1.0, -2.0, 3.0, 0.1, 0.2, -0.9], &[]);
    assert_eq!(a.correct(&readings, &[]), b.correct(&readings, &[]));
    assert_eq!(a.covariance(&[1.0; 6], &[]), b.covariance(&[1.0; 6], &[]));
}

/// A parabola whose slope at zero is small beside its curvature: the constant matrix does not contract there, Newton's steps do.
#[test]
fn strong_curvature_is_solved() {
    let text = r#"{ "bench": { "id": "b", "chain": [ {"joint": "t", "about": "x"} ],
          "sensors": { "V": { "axes": {"I": "z"}, "model": "V0 + 0.1*a_I + 0.5*a_I^2 + a_I^3" } } },
        "estimate": { "V0": {} }, "readings": [ {"t_deg": 90, "V": 0.25} ] }"#;
    let source = wire::Source { name: "b".into(), text: text.into() };
    let campaign = wire::read_campaign(&source, &mut |_| unreachable!()).unwrap();
    let corrector = Corrector::new(&Calibration::of(&exact(&campaign))).unwrap();
    // V = 0.25 + 0.1*0.9 + 0.5*0.81 + 0.729 at a = 0.9
    let corrected = corrector.correct(&[0.25 + 0.09 + 0.405 + 0.729], &[]);
    assert!(corrected.converged && (corrected.inputs[0] - 0.9).abs() < 1e-13, "{corrected:?}");
    // no real input gives this reading with a finite answer to a NaN
    assert!(!corrector.correct(&[f64::NAN], &[]).converged);
}

fn calibrated(text: &str) -> Calibration {
    Calibration::of(&exact(&crate::support::parse(text)))
}

/// Three gyros that each follow all rates, one of them on a skew axis: the case in which solving sensor by sensor is wrong.
#[test]
fn gyros_that_follow_all_rates_are_solved_together() {
    let calibration = calibrated(
        r#"{ "bench": { "id": "b", "units": {"rate": "deg/s", "force": "g"}, "chain": [ {"joint": "t", "about": "z"} ],
            "sensors": { "gx": { "model": "bx + 2*w_x + 0.01*w_y - 0.02*w_z" }, "gy": { "model": "0.5 - 0.03*w_x + 2.5*w_y + 0.01*w_y^2" },
                         "gz": { "model": "-1 + 0.1*w_x + 0.2*w_y + 3*w_z + k*a_x" } } },
          "known": { "k": { "value": 0.25 } }, "estimate": { "bx": {} }, "readings": [ {"t_deg": 0, "gx": 0.125} ] }"#,
    );
    let names: Vec<&str> = calibration.inputs.iter().map(|i| i.name.as_str()).collect();
    assert_eq!(names, ["w_x", "w_y", "w_z", "a_x"]);
    let corrector = Corrector::new(&calibration).unwrap();
    let truth = [10.0, -20.0, 30.0];
    let s = [
        0.125 + 2.0 * 10.0 - 0.01 * 20.0 - 0.02 * 30.0,
        0.5 - 0.03 * 10.0 - 2.5 * 20.0 + 0.01 * 400.0,
        -1.0 + 0.1 * 10.0 - 0.2 * 20.0 + 3.0 * 30.0 + 0.25 * 0.5,
    ];
    let corrected = corrector.correct(&s, &[0.5]);
    assert!(corrected.converged);
    for (q, truth) in corrected.inputs.iter().zip(truth) {
        assert!((q - truth).abs() < 1e-12 * truth.abs(), "{q} for {truth}");
    }
}

/// u by hand: V = V0 + k*a, so a = (V - V0)/k and u(a)^2 = (u(V0)^2 + a^2 u(k)^2)/k^2 for known, independent V0 and k.
#[test]
fn the_uncertainty_is_that_of_the_gum() {
    let calibration = calibrated(
        r#"{ "bench": { "id": "b", "chain": [ {"joint": "t", "about": "x"}, {"tilt": "m", "about": "x"} ],
            "sensors": { "V": { "axes": {"I": "z"}, "model": "V0 + k*a_I" }, "y": { "model": "c" } } },
          "known": { "V0": { "value": 0.5, "u": 0.003 }, "k": { "value": 2, "u": 0.004 } }, "estimate": { "c": {} },
          "readings": [ {"t_deg": 0, "y": 1, "y_u": 1} ] }"#,
    );
    assert_eq!(calibration.left_out.len(), 1);
    let corrector = Corrector::new(&calibration).unwrap();
    let a = corrector.correct(&[3.5], &[]).inputs;
    assert!((a[0] - 1.5).abs() < 1e-15);
    let u = corrector.covariance(&a, &[]).unwrap()[(0, 0)].sqrt();
    let by_hand = (0.003_f64.powi(2) + (1.5 * 0.004_f64).powi(2)).sqrt() / 2.0;
    assert!((u - by_hand).abs() < 1e-12 * by_hand, "{u}");
}
