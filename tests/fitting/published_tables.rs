//! Li, Ren, Zhao 2012: every printed digit of Tables 1 and 2, and the least-squares figures of an independent script.

use crate::support::*;
use serde_json::Value;
use tumble::campaign::Campaign;
use tumble::fit::Fit;
use tumble::{compare, fit};

/// Table 1 leaves more between positions than the readings of each scatter (numpy on the small-angle rows: tests/scripts/lack_of_fit.py).
#[test]
fn table_1_lacks_fit_by_position() {
    let campaign = tumble::wire::read_campaign(
        &tumble::wire::Source {
            name: "table 1".into(),
            text: include_str!("../../data/campaigns/li2012-table1.campaign.json").into(),
        },
        &mut |_| unreachable!(),
    )
    .unwrap();
    let expected = json("li2012/lack_of_fit.json");
    let found = linear(&campaign).checks.between_positions.expect("a test");
    assert_eq!(found.between_dof, expected["between_dof"]);
    assert_eq!(found.pure_error_dof, expected["within_dof"]);
    // rows of the small angles in both
    assert!((found.f.unwrap() / number(&expected["f"]) - 1.0).abs() < 1e-6, "{}", found.f.unwrap());
    assert!((found.p / number(&expected["p"]) - 1.0).abs() < 1e-4, "{}", found.p);
}

/// Readings of one rate (both senses) or one run.
fn group(campaign: &Campaign, column: &str, size: f64) -> Campaign {
    let k = campaign.readings.columns.iter().position(|c| c == column).expect("the column");
    subset(campaign, |reading| reading.columns[k].is_some_and(|v| v.abs() == size))
}

/// Half a unit of the last printed digit, 0.1 arcsec, in radians; a hair more for the rounding of the comparison.
const HALF_DIGIT: f64 = 0.05 * ARCSEC * (1.0 + 1e-9);

fn assert_printed(campaign: &Campaign, column: &str, printed: &Value) {
    let mut compared = 0;
    for (size, row) in entries(printed) {
        let group = group(campaign, column, size.parse().expect("a number"));
        // the paper's one step, and the exact rotations that are fitted by default, print the same digits
        for (how, fit) in [("linear", linear(&group)), ("exact", fitted(&group))] {
            assert!(fit.nonlinearity.iter().all(|share| share.is_none_or(|share| share.abs() < 0.1)), "{how} {size}");
            for (id, print) in entries(row) {
                assert_within(value(&fit, id), number(print) * ARCSEC, HALF_DIGIT, &format!("{id} at {size}, {how}"));
                compared += 1;
            }
        }
    }
    println!("{compared} printed values agree to half of their last digit");
    assert!(compared >= 18);
}

#[test]
fn every_printed_digit_of_table_1() {
    let published = json("li2012/li2012-published.json");
    let campaign = campaign("li2012/li2012-table1.campaign.json");
    assert_printed(&campaign, "gamma_deg_s", &published["table1"]["per_rate"]);
}

#[test]
fn every_printed_digit_of_table_2() {
    let published = json("li2012/li2012-published.json");
    let campaign = campaign("li2012/li2012-table2.campaign.json");
    assert_printed(&campaign, "run", &published["table2"]["per_run"]);
}

/// Against numpy QR and 40-digit arithmetic (tests/scripts/li2012_fits.py).
fn assert_as_the_script(fit: &Fit, expected: &Value, what: &str) {
    let count = |key: &str| expected[key].as_u64().expect("a count") as usize;
    assert_eq!(
        (fit.design.rows.len(), fit.estimate.unknowns.rank, fit.estimate.dof),
        (count("readings"), count("rank"), count("dof"))
    );
    // solved in double precision on both sides, with a condition number near 3
    let near = |found: f64, key: &Value, relative: f64, what: &str| {
        assert_within(found, number(key), relative * number(key).abs(), what);
    };
    near(fit.estimate.sum_of_squares, &expected["sum_of_squares"], 1e-11, what);
    let sd = (fit.estimate.sum_of_squares / fit.estimate.dof as f64).sqrt();
    near(sd, &expected["residual_sd"], 1e-11, what);
    for (id, parameter) in entries(&expected["parameters"]) {
        let exact = number(parameter.get("value_40").unwrap_or(&parameter["value"]));
        // a small angle is a difference of large readings, and its own size is no measure of its rounding
        assert_within(value(fit, id), exact, 1e-11 * exact.abs().max(1e-4), &format!("{what}: {id}"));
        near(uncertainty(fit, id), &parameter["u"], 1e-9, &format!("{what}: u of {id}"));
    }
    near(value(fit, "gamma"), &expected["gamma"]["value"], 1e-10, &format!("{what}: gamma"));
    near(uncertainty(fit, "gamma"), &expected["gamma"]["u"], 1e-8, &format!("{what}: u of gamma"));
}

#[test]
fn table_1_as_an_independent_script_solves_it() {
    let expected = &json("li2012/fits.json")["table1"];
    let turning = campaign("li2012/li2012-table1.campaign.json");
    for (key, campaign) in [("with_earth_rate", &turning), ("without_earth_rate", &without_earth_rate(&turning))] {
        assert_as_the_script(&linear(campaign), &expected[key]["all"], key);
        for (rate, expected) in entries(&expected[key]["per_rate"]) {
            let fit = linear(&group(campaign, "gamma_deg_s", rate.parse().expect("a rate")));
            assert_as_the_script(&fit, expected, &format!("{key}, {rate} deg/s"));
        }
    }
}

#[test]
fn table_2_as_an_independent_script_solves_it() {
    let expected = &json("li2012/fits.json")["table2"];
    let campaign = campaign("li2012/li2012-table2.campaign.json");
    assert_as_the_script(&linear(&campaign), &expected["all"], "table 2");
    for (run, expected) in entries(&expected["per_run"]) {
        assert_as_the_script(&linear(&group(&campaign, "run", run.parse().expect("a run"))), expected, run);
    }
}

/// All 30 readings of Table 1 at once, in arcseconds.
#[test]
fn table_1_all_readings() {
    let fit = linear(&campaign("li2012/li2012-table1.campaign.json"));
    let exact = fitted(&campaign("li2012/li2012-table1.campaign.json"));
    let expected = [
        ("dtheta_y0", -7.46, 0.594961),
        ("dtheta_x0", 2.39, 1.030503),
        ("dtheta_y1", -53.78, 0.594961),
        ("dtheta_y2", -162.07, 0.594961),
        ("dtheta_z2", 56.02, 1.030503),
    ];
    for (id, angle, u) in expected {
        println!("{id:10} {:9.3} arcsec, u {:.3}", value(&fit, id) / ARCSEC, uncertainty(&fit, id) / ARCSEC);
        assert_within(value(&fit, id) / ARCSEC, angle, 0.0051, id);
        assert_within(value(&exact, id) / ARCSEC, angle, 0.0075, id);
        // of li2012_fits.py, to half of the last digit shown (without Earth rate in the rows it would be 0.595503)
        assert_within(uncertainty(&fit, id) / ARCSEC, u, 0.5e-6 * (1.0 + 1e-9), id);
    }
    let sd = (fit.estimate.sum_of_squares / fit.estimate.dof as f64).sqrt();
    assert_eq!(fit.estimate.dof, 24);
    assert_within(sd, 0.90783e-3, 0.5e-8, "residual sd, V");
}

/// The misprints that the comparison finds by itself are those that reading the paper by eye found.
#[test]
fn the_papers_misprints_are_found() {
    let found = |name: &str, bench: &str| -> Vec<String> {
        let forms = compare::closed_forms(bench).expect("closed forms");
        let comparison = compare::compare(&campaign(name), &forms, &fit::Settings::default()).expect("a comparison");
        assert!(comparison.printed.is_some(), "{name} is recognised as the published table");
        comparison.misprints.iter().map(|m| m.what.to_string()).collect()
    };
    assert_eq!(
        found("li2012/li2012-table1.campaign.json", "gyro-turntable"),
        ["mean of dtheta_y0", "mean of dtheta_y2", "mean of dtheta_z2"]
    );
    assert_eq!(
        found("li2012/li2012-table2.campaign.json", "accelerometer-plumb-plane"),
        ["mean of gamma", "coefficient of dtheta_y0 in the printed equation", "dtheta_y1 in the printed equation"]
    );
}

/// The benches that ship with the program are the published ones.
#[test]
fn built_in_benches_are_the_papers() {
    for id in ["gyro-turntable", "accelerometer-plumb-plane"] {
        let own: Value = serde_json::from_str(tumble::bench::built_in(id).expect("built in").text).expect("JSON");
        let paper = json(&format!("benches/{id}.bench.json"));
        for key in ["site", "units", "chain", "sensors"] {
            assert_eq!(own[key], paper[key], "{id}: {key}");
        }
    }
}
