//! Benches for the commonest tests, their examples and their derived lines, beside numpy (`tests/scripts/ready_benches.py`).

use crate::draws::draws;
use crate::support::normal;
use nalgebra::{Matrix3, Vector3};
use rand_pcg::{Pcg64Mcg, rand_core::SeedableRng};
use serde_json::{Value, json};
use tumble::{Campaign, fit};

fn expected() -> Value {
    serde_json::from_str(include_str!("../data/ready/expected.json")).expect("expected.json")
}

fn fitted(folder: &str, file: &str) -> tumble::Fit {
    let path = format!("{}/examples/{folder}/{file}", env!("CARGO_MANIFEST_DIR"));
    let campaign = Campaign::from_path(path).expect(folder);
    fit(&campaign, &Default::default()).expect(folder)
}

/// Every value and u to 1e-7 of its uncertainty: numpy's solution is in double precision, columns of 1e4 beside 1.
fn agrees(folder: &str, file: &str) {
    let found = fitted(folder, file);
    let expected = expected();
    let values = expected[folder].as_object().expect(folder);
    let mut seen = 0;
    for (name, pair) in values {
        let (value, u) = match found.parameters.iter().find(|own| own.id == *name) {
            Some(own) => (own.value, own.uncertainty),
            None => {
                let own =
                    found.derived.iter().find(|own| own.id == *name).unwrap_or_else(|| panic!("{folder}: {name}"));
                let unit = found.campaign.derived.iter().find(|own| own.id == *name).map(|own| own.unit.clone());
                println!("{folder}: {name} = {:?} {}", own.value, unit.unwrap_or_default());
                (own.value, own.uncertainty)
            }
        };
        let (value, u) = (value.expect(name), u.expect(name).u);
        let scale = if found.derived.iter().any(|own| own.id == *name && own.is_angle) { ARCSEC } else { 1.0 };
        assert!(
            (value * scale - pair[0].as_f64().unwrap()).abs() < 1e-6 * u * scale,
            "{folder}: {name} {value} {pair}"
        );
        if let Some(theirs) = pair[1].as_f64() {
            assert!((u * scale / theirs - 1.0).abs() < 1e-6, "{folder}: u of {name} {u} {pair}");
        }
        seen += 1;
    }
    assert_eq!(seen, values.len());
}

const ARCSEC: f64 = 648_000.0 / std::f64::consts::PI;

#[test]
fn six_positions() {
    agrees("22-six-positions", "triad.campaign.json");
}

/// Cases whose faces are out of square: the true force is turned about both level axes by vectors, not by the bench's chain, and lines of scatter on the two
/// level tilts give intervals that hold. On `pitch` and `roll`, which tilt nothing about one level axis with x up or down, those of Kyx do not.
#[test]
fn faces_out_of_square_are_in_the_uncertainties() {
    let faces = [
        (0, 0, [0., 0., 1.]),
        (0, 180, [0., 0., -1.]),
        (0, 90, [0., 1., 0.]),
        (0, 270, [0., -1., 0.]),
        (270, 0, [1., 0., 0.]),
        (90, 0, [-1., 0., 0.]),
    ];
    let matrix = Matrix3::new(16400., 20., -30., 15., 16350., 10., -12., 25., 16500.);
    let bias = Vector3::new(50., -40., 30.);
    let names = ["bx", "by", "bz", "Kx", "Kxy", "Kxz", "Ky", "Kyx", "Kyz", "Kz", "Kzx", "Kzy"];
    let truth = [50., -40., 30., 16400., 20., -30., 16350., 15., 10., 16500., -12., 25.];
    let estimate: serde_json::Map<String, Value> = names.iter().map(|name| (name.to_string(), json!({}))).collect();
    let (u, noise, count) = (30.0 / ARCSEC, 0.2, draws(400, 4000));
    let mut random = Pcg64Mcg::seed_from_u64(4100);
    let lines = [["level_x", "level_y"], ["pitch", "roll"]];
    let mut held = lines.map(|_| vec![0; names.len()]);
    for _ in 0..count {
        let mut readings = Vec::new();
        for (place, (pitch, roll, up)) in faces.iter().enumerate() {
            let up = Vector3::from(*up);
            // two tilts square to the vertical
            let tilt = Vector3::from_fn(|_, _| u * normal(&mut random));
            let force = (up + (tilt - up * tilt.dot(&up)).cross(&up)).normalize();
            for _ in 0..3 {
                let v = bias + matrix * force + Vector3::from_fn(|_, _| noise * normal(&mut random));
                readings.push(json!({
                    "position": place.to_string(), "pitch_deg": pitch, "roll_deg": roll, "ax": v.x, "ay": v.y, "az": v.z
                }));
            }
        }
        for (of, held) in lines.iter().zip(&mut held) {
            let campaign = json!({
                "bench": "accelerometer-six-positions",
                "site": {"gravity_g": 1},
                "estimate": estimate,
                "scatter": [{"of": of, "per": "position", "u": 30, "unit": "arcsec"}],
                "readings": readings
            });
            let found = fit(&Campaign::from_json(&campaign.to_string()).expect("campaign"), &Default::default());
            let found = found.expect("fit");
            for ((name, truth), held) in names.iter().zip(truth).zip(held) {
                let own = found.parameters.iter().find(|own| own.id == *name).expect(name);
                let half = own.uncertainty.as_ref().expect(name).expanded;
                *held += usize::from((own.value.expect(name) - truth).abs() < half);
            }
        }
    }
    let share = |held: usize| held as f64 * 100.0 / count as f64;
    for ((name, level), joints) in names.iter().zip(&held[0]).zip(&held[1]) {
        println!(
            "{name:4} {:5.1} % on the level, {:5.1} % on pitch and roll, of {count}",
            share(*level),
            share(*joints)
        );
    }
    // 95 % within four binomial standard deviations
    let far = 4.0 * (95.0 * 5.0 / count as f64).sqrt();
    assert!(held[0].iter().all(|held| (share(*held) - 95.0).abs() < far), "{held:?}");
    assert!(share(held[1][7]) < 50.0, "{held:?}");
}

#[test]
fn rate_steps() {
    agrees("23-rate-steps", "steps.campaign.json");
}

#[test]
fn temperature() {
    agrees("24-temperature", "chamber.campaign.json");
}

/// Input axes of a triad by the norm of gravity: misalignment with its azimuth, and the angles between the axes.
#[test]
fn triad_by_the_norm() {
    let path = format!("{}/tests/data/ready/triad-norm.campaign.json", env!("CARGO_MANIFEST_DIR"));
    let found = fit(&Campaign::from_path(path).expect("a campaign"), &Default::default()).expect("a fit");
    let report = serde_json::to_value(tumble::report::fit_report(&found)).expect("JSON");
    let expected = expected();
    for (name, pair) in expected["triad-norm"].as_object().expect("names") {
        let list = |key: &str| report[key].as_array().expect("a list").iter().find(|own| own["id"] == *name).cloned();
        let own = list("parameters").or_else(|| list("derived")).unwrap_or_else(|| panic!("{name}"));
        let of = |key: &str, arcsec: &str| own[arcsec].as_f64().or(own[key].as_f64()).expect(name);
        let (value, u) = (of("value", "arcsec"), of("u", "u_arcsec"));
        let [theirs, their_u] = [0, 1].map(|k| pair[k].as_f64().expect("a number"));
        // numpy differentiates numerically: six digits
        assert!((value - theirs).abs() < 1e-4 * their_u, "{name} {value} {theirs}");
        assert!((u / their_u - 1.0).abs() < 1e-4, "u of {name} {u} {their_u}");
    }
}

/// Balanced: the mean and its u by the analysis of variance, and the scatter between turn-ons.
#[test]
fn turn_on() {
    let found = fitted("25-turn-on", "turn-on.campaign.json");
    let expected = &expected()["25-turn-on"];
    let bias = found.parameter("B").unwrap();
    let uncertainty = bias.uncertainty.unwrap();
    assert!((bias.value.unwrap() - expected["B"][0].as_f64().unwrap()).abs() < 1e-6);
    assert!((uncertainty.u / expected["B"][1].as_f64().unwrap() - 1.0).abs() < 1e-6);
    assert!((uncertainty.dof - 9.0).abs() < 1e-6);
    let report = tumble::report::fit_report(&found);
    let json = serde_json::to_value(&report).unwrap();
    let sd = json["scatter"].as_array().unwrap().iter().find(|line| line["of"] == "B").unwrap()["sd"].as_f64().unwrap();
    assert!((sd / expected["repeatability"][0].as_f64().unwrap() - 1.0).abs() < 1e-6, "{sd}");
}

/// A bench's derived lines appear where what they need is estimated or known, and a campaign's own line takes their place.
#[test]
fn lines_of_the_bench_follow_what_is_estimated() {
    let text = |estimate: &str, derived: &str| {
        format!(
            r#"{{ "bench": "gyro-rate-steps", "estimate": {{ {estimate} }}, "derived": {{ {derived} }},
                 "readings": [ {{"gamma_deg_s": 10, "V": 0.2}}, {{"gamma_deg_s": -10, "V": -0.2}}, {{"gamma_deg_s": 20, "V": 0.4}} ] }}"#
        )
    };
    let names = |text: String| -> Vec<String> {
        Campaign::from_json(&text).unwrap().derived.iter().map(|own| own.id.clone()).collect()
    };
    assert_eq!(names(text(r#""V0": {}, "K": {}"#, "")), ["bias"]);
    assert_eq!(names(text(r#""K": {}"#, "")), Vec::<String>::new());
    assert_eq!(names(text(r#""V0": {}, "K": {}"#, r#""bias": "V0""#)), ["bias"]);
    let own = Campaign::from_json(&text(r#""V0": {}, "K": {}"#, r#""bias": "V0""#)).unwrap();
    assert_eq!(own.derived[0].line.to_string(), "V0");
}
