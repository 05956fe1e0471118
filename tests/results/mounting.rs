//! Corrected inputs on the mounting face: their uncertainty is that of the sensors' parameters and of the mounting tilts together.
//!
//! A triad of accelerometers is calibrated in positions that this file turns itself; then the unit takes fresh attitudes. An interval holds where the force on the
//! mounting face, which is known, lies within 1.96 u.

use crate::draws::draws;
use crate::support::{fitted, parse};
use nalgebra::{Matrix3, Vector3};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use tumble::correction::{Calibration, Corrector, ToMount};
use tumble::wire;

const NOISE: f64 = 1e-4;

/// An active rotation about an axis (0 to 2 for x to z).
fn turn(axis: usize, angle: f64) -> Matrix3<f64> {
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut own = Matrix3::identity();
    (own[(i, i)], own[(i, j)], own[(j, i)], own[(j, j)]) = (angle.cos(), -angle.sin(), angle.sin(), angle.cos());
    own
}

struct Truth {
    mount: Matrix3<f64>,
    gain: Matrix3<f64>,
    bias: Vector3<f64>,
}

impl Truth {
    /// What the sensors read of a force on the mounting face.
    fn read(&self, force: Vector3<f64>) -> Vector3<f64> {
        self.gain * (self.mount.transpose() * force) + self.bias
    }
}

fn campaign(truth: &Truth, random: &mut Pcg64Mcg, known: &str) -> String {
    let angles = [(0, 0), (180, 0), (90, 0), (270, 0), (0, 90), (0, 270), (45, 0), (45, 120), (200, 60), (300, 250)];
    let rows: Vec<String> = angles
        .into_iter()
        .map(|(a, b)| {
            let table = turn(0, f64::from(a).to_radians()) * turn(1, f64::from(b).to_radians());
            let read = truth.read(table.transpose() * Vector3::z());
            let [x, y, z] = [0, 1, 2].map(|k| {
                let noise: f64 = StandardNormal.sample(random);
                read[k] + NOISE * noise
            });
            format!(
                r#"{{"a_deg": {a}, "b_deg": {b}, "X": {x}, "X_u": {NOISE}, "Y": {y}, "Y_u": {NOISE}, "Z": {z}, "Z_u": {NOISE}}}"#
            )
        })
        .collect();
    format!(
        r#"{{ "bench": {{ "id": "t", "chain": [ {{"joint": "a", "about": "x"}}, {{"joint": "b", "about": "y"}},
                {{"tilt": "mx", "about": "x"}}, {{"tilt": "my", "about": "y"}}, {{"tilt": "mz", "about": "z"}} ],
              "sensors": {{ "X": {{"model": "bx + kx*a_x"}}, "Y": {{"model": "by + sy*a_x + ky*a_y"}},
                            "Z": {{"model": "bz + sz*a_x + tz*a_y + kz*a_z"}} }} }},
            "estimate": {{ "bx": {{}}, "by": {{}}, "bz": {{}}, "kx": {{"start": 1}}, "ky": {{"start": 1}}, "kz": {{"start": 1}},
                           "sy": {{}}, "sz": {{}}, "tz": {{}}, "mx": {{}}, "my": {{}} {} }},
            {} "readings": [ {} ] }}"#,
        if known.is_empty() { r#", "mz": {}"# } else { "" },
        known,
        rows.join(", ")
    )
}

/// Of 200 calibrations (2000 in a long run), each applied in ten fresh attitudes, 93 to 97 % of the intervals hold; with the rotation taken as exact far fewer do.
/// The covariance survives the file, and a tilt that is known with a u takes part as an estimated one does.
#[test]
fn intervals_on_the_mounting_face_hold() {
    let truth = Truth {
        mount: turn(0, 0.02) * turn(1, -0.03) * turn(2, 0.015),
        gain: Matrix3::new(1.01, 0.0, 0.0, 0.004, 0.98, 0.0, -0.006, 0.003, 1.02),
        bias: Vector3::new(0.02, -0.01, 0.03),
    };
    let mut random = Pcg64Mcg::seed_from_u64(4107);
    for is_known in [false, true] {
        let (mut held, mut held_exact, mut all) = (0, 0, 0);
        for _ in 0..draws(200, 2000) {
            let error: f64 = StandardNormal.sample(&mut random);
            let known = format!(r#""known": {{"mz": {{"value": {}, "u": 1e-4}}}},"#, 0.015 + 1e-4 * error);
            let text = campaign(&truth, &mut random, if is_known { &known } else { "" });
            let file = wire::CorrectionFile::of(&Calibration::of(&fitted(&parse(&text)))).unwrap();
            let file: wire::CorrectionFile = serde_json::from_str(&serde_json::to_string(&file).unwrap()).unwrap();
            let mut earlier = file.clone();
            earlier.mounting.as_mut().unwrap().by_tilt.clear();
            earlier.mounting.as_mut().unwrap().covariance.clear();
            let (calibration, earlier) = (file.into_calibration().unwrap(), earlier.into_calibration().unwrap());
            let corrector = Corrector::new(&calibration).unwrap();
            let (to_mount, exact) = (ToMount::new(&calibration).unwrap(), ToMount::new(&earlier).unwrap());
            for _ in 0..10 {
                let force = Vector3::from_fn(|_, _| StandardNormal.sample(&mut random));
                let read = truth.read(force);
                let inputs = corrector.correct(read.as_slice(), &[]).inputs;
                let turned = to_mount.turned(&inputs);
                let own = to_mount.covariance(&corrector, &inputs, &[]).unwrap();
                let of_sensors = exact.covariance(&corrector, &inputs, &[]).unwrap();
                for k in 0..3 {
                    let error = (turned[k] - force[k]).abs();
                    all += 1;
                    held += u32::from(error < 1.96 * own[(k, k)].sqrt());
                    held_exact += u32::from(error < 1.96 * of_sensors[(k, k)].sqrt());
                }
            }
        }
        let [held, held_exact] = [held, held_exact].map(|own| 100.0 * f64::from(own) / f64::from(all));
        println!(
            "mz known: {is_known}; intervals that hold: {held:.1} %; with the rotation as exact: {held_exact:.1} %"
        );
        assert!((93.0..=97.0).contains(&held), "{held} %");
        assert!(held_exact < 90.0, "{held_exact} %");
    }
}

/// By hand: a quarter turn about x brings the sensor's y to the face's z; a small tilt about x more moves a force along y by f du along -y, so that u along it is f u(tilt).
#[test]
fn the_uncertainty_of_a_known_tilt_is_that_of_the_gum() {
    let text = r#"{ "bench": { "id": "b", "chain": [ {"joint": "t", "about": "x"}, {"tilt": "m", "about": "x"} ],
            "sensors": { "X": {"model": "c + a_x"}, "Y": {"model": "a_y"}, "Z": {"model": "a_z"} } },
          "known": { "m": { "value": 90, "unit": "deg", "u": 0.1 } }, "estimate": { "c": {} },
          "readings": [ {"t_deg": 0, "X": 0, "X_u": 1e-3, "Y": 1, "Y_u": 1, "Z": 0, "Z_u": 1} ] }"#;
    let calibration = Calibration::of(&fitted(&parse(text)));
    let (corrector, to_mount) = (Corrector::new(&calibration).unwrap(), ToMount::new(&calibration).unwrap());
    let inputs = corrector.correct(&[0.0, 2.0, 0.0], &[]).inputs;
    let turned = to_mount.turned(&inputs);
    assert!(turned[1].abs() < 1e-12 && (turned[2] - 2.0).abs() < 1e-12, "{turned:?}");
    let covariance = to_mount.covariance(&corrector, &inputs, &[]).unwrap();
    let by_hand = 2.0 * 0.1_f64.to_radians();
    assert!((covariance[(1, 1)].sqrt() - by_hand).abs() < 1e-9 * by_hand, "{covariance}");
    assert!(covariance[(2, 2)].sqrt() < 1e-9 && (covariance[(0, 0)].sqrt() - 1e-3).abs() < 1e-9, "{covariance}");
}
