//! Units held by hand: a triad that is known by the norm of gravity, and the positions of Ferraris. What is applied is bias, scale and misalignment.

use crate::correction::example;
use crate::support::{exact, parse};
use tumble::correction::{Calibration, Corrector};

/// Tedaldi's line, every parameter known but one bias; the reading is the norm of (9, 2, 3) m/s^2.
pub fn by_its_norm() -> String {
    let raw = raw([9.0, 2.0, 3.0]);
    format!(
        r#"{{"bench": {{"id": "norm", "units": {{"force": "m/s^2"}}, "chain": [], "sensors": {{"norm": {{"unit": "m/s^2", "model":
            "sqrt((s_x*(ax - b_x) - mis_yz*s_y*(ay - b_y) + mis_zy*s_z*(az - b_z))^2 + (s_y*(ay - b_y) - mis_zx*s_z*(az - b_z))^2 + (s_z*(az - b_z))^2)"}}}}}},
            "known": {{"s_x": {{"value": 0.0024}}, "s_y": {{"value": 0.0025}}, "s_z": {{"value": 0.0026, "u": 1e-7}}, "mis_yz": {{"value": 0.003}},
                "mis_zy": {{"value": -0.009}}, "mis_zx": {{"value": 0.021}}, "b_y": {{"value": 33200}}, "b_z": {{"value": 32300, "u": 0.5}}}},
            "estimate": {{"b_x": {{"start": 33099}}}},
            "readings": [{{"ax": {:?}, "ay": {:?}, "az": {:?}, "norm": {:?}, "norm_u": 1e-6}}]}}"#,
        raw[0],
        raw[1],
        raw[2],
        f64::sqrt(94.0)
    )
}

/// Counts that this triad reads at a specific force: its line solved from z to x by hand.
fn raw([x, y, z]: [f64; 3]) -> [f64; 3] {
    let z_part = z; // s_z (az - b_z)
    let y_part = y + 0.021 * z_part; // s_y (ay - b_y)
    let x_part = x + 0.003 * y_part + 0.009 * z_part; // s_x (ax - b_x)
    [33100.0 + x_part / 0.0024, 33200.0 + y_part / 0.0025, 32300.0 + z_part / 0.0026]
}

/// A gyroscope as Ferraris calibrates it: turns over their time, and a drift by g.
pub const TURNED: &str = r#"{"bench": {"id": "turned", "units": {"rate": "deg/s", "force": "m/s^2"}, "chain": [],
    "in_use": {"turn_x": "w_x", "turn_y": "w_y", "turn_z": "w_z", "duration_s": "1", "f_x": "a_x"}, "sensors": {
    "x": {"unit": "count", "model": "b_x + (16*turn_x + 0.5*turn_y)/duration_s + k_x*f_x"}, "y": {"unit": "count", "model": "2 + (0.25*turn_x - 8*turn_y)/duration_s"},
    "z": {"unit": "count", "model": "-1 + (4*turn_z - 0.125*turn_y)/duration_s"}}}, "known": {"k_x": {"value": 0.5}}, "estimate": {"b_x": {}},
    "readings": [{"turn_x": 180, "turn_y": 0, "turn_z": 0, "duration_s": 2, "f_x": 0, "x": 1441, "y": 24.5, "z": -1}]}"#;

fn calibration(text: &str) -> Calibration {
    Calibration::of(&exact(&parse(text)))
}

#[test]
fn a_norm_gives_the_vector() {
    let calibration = calibration(&by_its_norm());
    let names: Vec<&str> = calibration.inputs.iter().map(|input| input.name.as_str()).collect();
    assert_eq!(names, ["a_x", "a_y", "a_z"]);
    let sensors: Vec<&str> = calibration.lines.iter().map(|line| line.sensor.as_str()).collect();
    assert_eq!(sensors, ["ax", "ay", "az"]);
    // the calibration covered the norm of its one reading
    assert!((calibration.span.force - f64::sqrt(94.0)).abs() < 1e-6);
    let corrector = Corrector::new(&calibration).unwrap();
    for truth in [[9.0, 2.0, 3.0], [0.0, 0.0, -9.8], [-1.5, 7.25, 0.125]] {
        let found = corrector.correct(&raw(truth), &[]);
        assert!(found.converged);
        for (found, truth) in found.inputs.iter().zip(truth) {
            // the bias is estimated from a norm of 15 digits: counts of 1e-9
            assert!((found - truth).abs() < 1e-9, "{found} for {truth}");
        }
        // a_z = s_z (az - b_z): u(a_z)^2 = s_z^2 u(b_z)^2 + (a_z/s_z)^2 u(s_z)^2
        let u = corrector.covariance(&found.inputs, &[]).unwrap()[(2, 2)].sqrt();
        let by_hand = f64::hypot(0.0026 * 0.5, truth[2] / 0.0026 * 1e-7);
        assert!((u - by_hand).abs() < 1e-8 * by_hand, "{u} for {by_hand}");
    }
}

/// In rad/s, or in a unit that says neither rate nor force, or with a square of a reading: not taken for a triad of accelerometers.
#[test]
fn what_is_no_triad_is_said() {
    for (from, to) in [("\"unit\": \"m/s^2\"", "\"unit\": \"uT\""), ("(s_z*(az - b_z))^2)", "(s_z*(az - b_z)^2)^2)")] {
        let calibration = calibration(&by_its_norm().replace(from, to));
        let error = Corrector::new(&calibration).unwrap_err().to_string();
        assert!(error.contains("corrects nothing") && error.contains("norm"), "{error}");
    }
}

#[test]
fn columns_that_are_rates_in_use_are_solved_for() {
    let calibration = calibration(TURNED);
    let inputs: Vec<(&str, bool)> = calibration.inputs.iter().map(|own| (own.name.as_str(), own.solved)).collect();
    let (solved, given) = (true, false);
    assert_eq!(inputs, [("w_x", solved), ("w_y", solved), ("w_z", solved), ("a_x", given)]);
    // 180 deg in 2 s
    assert!((calibration.span.rate - 90.0).abs() < 1e-9, "{}", calibration.span.rate);
    let corrector = Corrector::new(&calibration).unwrap();
    // b_x = 1441 - 16*90 = 1; at w = (10, -20, 30) deg/s, a_x = 2 m/s^2
    let readings = [1.0 + 160.0 - 10.0 + 1.0, 2.0 + 2.5 + 160.0, -1.0 + 120.0 + 2.5];
    let found = corrector.correct(&readings, &[2.0]);
    for (found, truth) in found.inputs.iter().zip([10.0, -20.0, 30.0]) {
        assert!((found - truth).abs() < 1e-12, "{found} for {truth}");
    }
}

/// The length of a corrected reading is what the line predicts: the reading less its residual.
#[test]
fn corrected_positions_are_as_long_as_their_norm() {
    let campaign = example("14-xsens-static-positions/xsens.campaign.json");
    let fit = exact(&campaign);
    let corrector = Corrector::new(&Calibration::of(&fit)).unwrap();
    for (row, residual) in campaign.readings.rows.iter().zip(&fit.estimate.residuals) {
        let raw: Vec<f64> = ["ax", "ay", "az"]
            .iter()
            .map(|name| row.columns[campaign.readings.columns.iter().position(|own| own == name).unwrap()].unwrap())
            .collect();
        let length = corrector.correct(&raw, &[]).inputs.iter().map(|a| a * a).sum::<f64>().sqrt();
        assert!((length - (9.81744 - residual)).abs() < 1e-9, "{length}");
    }
    for (name, expected) in [("accelerometer", ["a_x", "a_y", "a_z"]), ("gyroscope", ["w_x", "w_y", "w_z"])] {
        let text = std::fs::read_to_string(format!(
            "{}/examples/17-ferraris-session/{name}.campaign.json",
            env!("CARGO_MANIFEST_DIR")
        ));
        let bench: serde_json::Value = serde_json::from_str(&text.unwrap()).unwrap();
        let in_use = bench["bench"]["in_use"].as_object().unwrap();
        assert!(expected.iter().all(|name| in_use.values().any(|line| line == name)));
    }
}

/// A norm is a reference, not rounded in each row: its digits say nothing of the scatter. Twelve directions, counts that are off by up to one (0.0025 m/s^2; the last digit of 9.8 is 40 times that).
#[test]
fn digits_of_a_norm_are_not_rounding() {
    let us = |norm: &str| -> Vec<f64> {
        let mut state = 1_u32;
        let mut off = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 23) - 1.0
        };
        let row = |k: u32| {
            // a spiral from pole to pole
            let z = 1.0 - (2.0 * f64::from(k) + 1.0) / 12.0;
            let (sin, cos) = (2.4 * f64::from(k)).sin_cos();
            let counts = raw([(1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z].map(|own| 9.8 * own));
            let [x, y, z] = counts.map(|own| own + off());
            format!(r#"{{"ax": {x}, "ay": {y}, "az": {z}, "norm": {norm}}}"#)
        };
        let rows: Vec<String> = (0..12).map(row).collect();
        let start = by_its_norm();
        let (head, rest) = start.split_once(r#""known""#).expect("what is known");
        assert!(rest.contains("estimate"));
        let text = format!(
            r#"{head}"known": {{"mis_yz": {{"value": 0.003}}, "mis_zy": {{"value": -0.009}}, "mis_zx": {{"value": 0.021}}}},
            "estimate": {{"s_x": {{"start": 0.0024}}, "s_y": {{"start": 0.0025}}, "s_z": {{"start": 0.0026}}, "b_x": {{"start": 33100}}, "b_y": {{"start": 33200}}, "b_z": {{"start": 32300}}}},
            "readings": [{}]}}"#,
            rows.join(",")
        );
        let fit = exact(&parse(&text));
        fit.parameters.iter().map(|own| own.uncertainty.as_ref().expect("u").u).collect()
    };
    // a number of sixteen digits has no last place that is coarse
    for (short, long) in us("9.8").iter().zip(us("9.800000000000001")) {
        assert!((short / long - 1.0).abs() < 1e-6, "{short} {long}");
    }
}
