//! Benches for the commonest tests, their examples and their derived lines, beside numpy (`tests/scripts/ready_benches.py`).

use serde_json::Value;
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
