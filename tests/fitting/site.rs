//! The site: normal gravity against the exact potential of the ellipsoid, and what gravity, latitude and table rates put into budgets.

use crate::support::*;
use tumble::bench::{STANDARD_GRAVITY_M_S2, normal_gravity};
use tumble::fit::Fit;
use tumble::report::{FitReport, fit_document, fit_report};
use tumble::wire::{BenchRef, Source, campaign_file, read_campaign};

/// Contribution of a source to the uncertainty of a parameter.
fn part(fit: &Fit, id: &str, source: &str) -> f64 {
    let parameter = fit.parameters.iter().find(|p| p.id == id).expect("a parameter");
    parameter.budget.iter().find(|line| line.source == source).map_or(f64::NAN, |line| line.u)
}

/// Values of tests/scripts/site_and_conformity.py. The published series drops f^2 of the free-air gradient: 1e-10 m/s^2 for each metre is more.
#[test]
fn normal_gravity_is_that_of_the_level_ellipsoid() {
    for (latitude, altitude, expected, tolerance) in [
        (0.0, 0.0, 9.7803253359039, 1e-10),
        (45.0, 0.0, 9.8061977693774, 2e-10),
        (45.75, 0.0, 9.8068765676634, 2e-10),
        (45.75, 150.0, 9.8064137529783, 150.0e-10),
        (52.3, 75.0, 9.8125061118192, 75.0e-10),
        (-33.9, 1700.0, 9.7911638392361, 1700.0e-10),
        (80.0, 4000.0, 9.8182919480199, 4000.0e-10),
    ] {
        assert_within(
            normal_gravity(latitude, altitude),
            expected,
            tolerance,
            &format!("{latitude} deg, {altitude} m"),
        );
    }
}

fn head(site: &str) -> String {
    format!(
        r#"{{ "bench": {{ "id": "head", "units": {{ "force": "m/s^2" }}, "chain": [ {{ "joint": "theta", "about": "x" }} ],
                "sensors": {{ "A": {{ "unit": "V", "axes": {{ "I": "y" }}, "model": "K0 + K1*a_I" }} }} }},
            {site} "estimate": {{ "K0": {{}}, "K1": {{}} }},
            "readings": [ {{"theta_deg": 0, "A": 0.1, "A_u": 1e-6}}, {{"theta_deg": 90, "A": 1.6, "A_u": 1e-6}},
                          {{"theta_deg": 180, "A": 0.1, "A_u": 1e-6}}, {{"theta_deg": 270, "A": -1.4, "A_u": 1e-6}} ] }}"#
    )
}

/// K1 = 1.5 V / g, so dK1/dg = -K1/g, and gravity does not touch K0.
#[test]
fn gravity_is_in_the_budget_of_a_scale_factor() {
    let fit = fitted(&parse(&head(r#""site": { "gravity": { "value": 980687, "unit": "mGal", "u": 50 } },"#)));
    let k1 = 1.5 / 9.80687;
    assert_within(value(&fit, "K1"), k1, 1e-15, "K1");
    assert_within(part(&fit, "K1", "site.gravity"), k1 * 5e-4 / 9.80687, 1e-7 * k1 * 5e-5, "its part of gravity");
    assert!(part(&fit, "K0", "site.gravity") < 1e-12);
    let readings = 1e-6 / 2f64.sqrt() / 9.80687;
    assert_within(uncertainty(&fit, "K1"), readings.hypot(k1 * 5e-4 / 9.80687), 1e-14, "u of K1");
    let report = fit_report(&fit);
    assert_eq!((report.site.gravity.from.name(), report.site.warnings.len()), ("stated", 0));
    assert!(report.known.iter().any(|k| k.id == "site.gravity" && k.unit == "m/s^2"));
}

#[test]
fn normal_gravity_is_used_and_named_and_an_unsaid_one_is_warned_of() {
    let fit = fitted(&parse(&head(r#""site": { "latitude_deg": 45.75, "altitude_m": 150 },"#)));
    assert_within(value(&fit, "K1"), 1.5 / 9.8064137529783, 1e-9, "K1");
    assert_within(
        part(&fit, "K1", "site.gravity"),
        1.5 / 9.8064137529783f64.powi(2) * 5e-4,
        1e-10,
        "its part of gravity",
    );
    let report = fit_report(&fit);
    assert!(printed(&report).contains("Somigliana"), "{}", printed(&report));
    assert!(report.site.warnings.is_empty());
    for unsaid in ["", r#""site": { "latitude_deg": 45.75 },"#] {
        let fit = fitted(&parse(&head(unsaid)));
        assert_within(value(&fit, "K1"), 1.5 / STANDARD_GRAVITY_M_S2, 1e-15, "K1");
        let report = fit_report(&fit);
        assert!(printed(&report).contains("ravity is not stated"), "{}", printed(&report));
    }
    // in units of g nothing rests on it
    let campaign = parse(&head("").replace("m/s^2", "g"));
    assert!(fit_report(&fitted(&campaign)).site.warnings.is_empty());
}

/// The horizontal Earth rate is W cos(lat): kI = 0.5 V / (W cos(lat)), dkI/dlat = kI tan(lat).
#[test]
fn latitude_is_in_the_budget_of_a_gyro_that_sees_the_earth_turn() {
    let text = r#"{ "bench": { "id": "north", "units": { "rate": "deg/h" }, "site": { "latitude_deg": 45.75, "latitude_u_deg": 0.01 },
            "chain": [ { "joint": "az", "about": "z" } ],
            "sensors": { "V": { "unit": "V", "axes": { "I": "y" }, "model": "V0 + kI*w_I" } } },
        "estimate": { "V0": {}, "kI": {} },
        "readings": [ {"az_deg": 0, "V": 0.5, "V_u": 1e-5}, {"az_deg": 90, "V": 0, "V_u": 1e-5}, {"az_deg": 180, "V": -0.5, "V_u": 1e-5} ] }"#;
    let fit = fitted(&parse(text));
    let latitude = 45.75_f64.to_radians();
    let k = 0.5 / (15.041067 * latitude.cos());
    assert_within(value(&fit, "kI"), k, 1e-15, "kI");
    assert_within(
        part(&fit, "kI", "site.latitude"),
        k * latitude.tan() * 0.01_f64.to_radians(),
        1e-12,
        "its part of the latitude",
    );
}

/// kI = 58.444 V / (20 deg/s), and a rate that is wrong by a part in a million makes it wrong by as much.
#[test]
fn the_table_rate_is_in_the_budget_of_a_scale_factor() {
    let text = r#"{ "bench": { "id": "table", "chain": [ { "joint": "gamma", "about": "z" } ],
            "sensors": { "V": { "unit": "V", "axes": { "I": "z" }, "model": "V0 + kI*w_I" } } },
        "rate_u_ppm": { "gamma": 5 }, "estimate": { "V0": {}, "kI": {} },
        "readings": [ {"gamma_deg_s": 20, "V": 58.444, "V_u": 1e-5}, {"gamma_deg_s": -20, "V": -58.444, "V_u": 1e-5}, {"gamma_deg": 0, "V": 0, "V_u": 1e-5} ] }"#;
    let fit = fitted(&parse(text));
    assert_within(part(&fit, "kI", "rate.gamma"), 2.9222 * 5e-6, 1e-12, "its part of the rate");
    assert!(part(&fit, "V0", "rate.gamma") < 1e-12);
}

#[test]
fn a_campaign_says_the_site_of_a_built_in_bench_and_files_keep_it() {
    let text = r#"{ "bench": "gyro-turntable", "site": { "latitude_deg": 30, "gravity": { "value": 9.793, "unit": "m/s^2", "u": 1e-5 } },
        "rate_u_ppm": { "gamma": 2 }, "known": { "kI": { "value": 2.9 } }, "estimate": { "V0": {} },
        "unit": { "serial": "007", "type": "G-1" }, "date": "2026-11-21", "environment": { "temperature_c": 23.1 },
        "instruments": [ { "name": "table", "certificate": "C-5" } ], "limits": { "V0": { "between": [-50, 50], "unit": "mV" } },
        "decision": "guard-u",
        "readings": [ {"alpha_deg": 0, "beta_deg": 0, "gamma_deg_s": [20, -20]} ] }"#;
    let campaign = parse(text);
    let site = campaign.bench.site.expect("a site");
    assert_eq!((site.latitude_deg, site.earth_rate_deg_h), (30.0, 15.041067));
    assert_within(site.gravity_g * STANDARD_GRAVITY_M_S2, 9.793, 1e-15, "gravity");
    let written =
        serde_json::to_string(&campaign_file(&campaign, BenchRef::Named("gyro-turntable".into()))).expect("JSON");
    let again = parse(&written);
    assert_eq!(again.bench.site, campaign.bench.site);
    assert_eq!(
        (&again.identity, &again.limits, again.decision),
        (&campaign.identity, &campaign.limits, campaign.decision)
    );
    assert_eq!(again.limits[0].upper, 0.05);
    assert_within(again.bench.rate_u[0].1, 2e-6, 1e-20, "rate");
    assert_eq!(again.parameters.len(), campaign.parameters.len());
}

#[test]
fn a_site_that_contradicts_itself_is_refused() {
    let refused = |site: &str, path: &str| {
        let error =
            read_campaign(&Source { name: "c".into(), text: head(site) }, &mut |_| unreachable!()).expect_err(site);
        assert_eq!(error.place().path, path, "{error}");
    };
    refused(r#""site": { "latitude_deg": 45, "gravity_g": 1, "altitude_m": 5 },"#, "site");
    refused(r#""site": { "altitude_m": 5 },"#, "site");
    refused(r#""site": { "gravity": { "value": 9.8, "unit": "m/s" } },"#, "site.gravity.unit");
    refused(r#""site": { "gravity": { "value": -9.8, "unit": "m/s^2" } },"#, "site.gravity.value");
    // m/s^2 where g is meant, and the other way round
    refused(r#""site": { "gravity_g": 9.81 },"#, "site.gravity_g");
    refused(r#""site": { "gravity": { "value": 1, "unit": "m/s^2" } },"#, "site.gravity.value");
    refused(r#""rate_u_ppm": { "gamma": 5 },"#, "rate_u_ppm.gamma");
}

/// A bench that reads the rate of rotation is told that the Earth's is missing; a column whose name merely holds `w_` is none.
#[test]
fn the_note_of_the_earth_rate_is_for_lines_that_read_a_rate() {
    let told = |model: &str, column: &str| {
        let campaign = parse(&format!(
            r#"{{ "bench": {{ "id": "one", "chain": [ {{ "joint": "theta", "about": "x" }} ],
                    "sensors": {{ "A": {{ "unit": "V", "axes": {{ "I": "y" }}, "model": "{model}" }} }} }},
                "estimate": {{ "b0": {{}}, "b1": {{}} }},
                "readings": [ {{"theta_deg": 0, {column}: 1, "A": 0.1}}, {{"theta_deg": 90, {column}: 2, "A": 1.6}},
                              {{"theta_deg": 180, {column}: 3, "A": 2.1}} ] }}"#
        ));
        let report = fit_report(&fitted(&campaign));
        let table = tumble::document::terminal::brief(&tumble::report::fit_document(
            &report,
            &Default::default(),
            tumble::language::Language::English,
        ));
        table.split_whitespace().collect::<String>().contains("Earthrateassumedzero")
    };
    assert!(told("b0 + b1*w_I", "\"theta_deg_s\""));
    assert!(!told("b0 + b1*flow_x", "\"flow_x\""));
}

/// The document of a report with all its blocks, in one line.
fn printed(report: &FitReport) -> String {
    let document = fit_document(report, &Default::default(), tumble::language::Language::English);
    let text = tumble::document::terminal::render(&document, tumble::document::Detail::Full);
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
