//! Questions at the edge of what numbers say: readings without scatter, bounds that contradict, numbers beyond a square, lines without a value.

use crate::support::*;
use tumble::Campaign;
use tumble::design::{self, DesignMatrix};
use tumble::fit::{self, Constraints, Settings};
use tumble::report::fit_report;

fn line(readings: &[(f64, f64)], more: &str) -> String {
    let readings: Vec<String> = readings.iter().map(|(x, y)| format!("{{\"x\": {x:e}, \"y\": {y:e}}}")).collect();
    format!(
        r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "model": "b0 + b1*x" }} }} }},
            "estimate": {{ "b0": {{}}, "b1": {{}} }}, {more} "readings": [ {} ] }}"#,
        readings.join(", ")
    )
}

fn refused(text: &str) -> tumble::error::Malformed {
    fit::fit(&parse(text), &Settings::default()).expect_err("refused")
}

/// `d sqrt(b + x)/db = 1/(2 sqrt(b + x))` is infinite at b = x = 0: the fit says where, and does not go on as if the reading knew nothing of b.
#[test]
fn an_infinite_derivative_is_no_zero() {
    let text = |start: f64| {
        let readings: Vec<String> =
            (0..5).map(|x| format!("{{\"x\": {x}, \"y\": {}}}", 2.0 * (0.25 + f64::from(x)).sqrt())).collect();
        format!(
            r#"{{ "bench": {{ "id": "root", "sensors": {{ "y": {{ "model": "k*sqrt(b + x)" }} }} }},
                "estimate": {{ "k": {{ "start": 1 }}, "b": {{ "start": {start} }} }}, "readings": [ {} ] }}"#,
            readings.join(", ")
        )
    };
    let error = refused(&text(0.0));
    assert!(error.to_string().contains("no finite derivative by 'b'"), "{error}");
    assert!(error.place().path.starts_with("readings[0]"), "{}", error.place().path);
    let fit = fitted(&parse(&text(1.0)));
    assert_within(value(&fit, "k"), 2.0, 1e-10, "k");
    assert_within(value(&fit, "b"), 0.25, 1e-10, "b");
}

/// Readings that are all 1.25 are known to half a hundredth, not to 1e-92: u of their mean is 0.01/sqrt 12/sqrt 4.
#[test]
fn readings_without_scatter_have_the_uncertainty_of_their_last_digit() {
    let text = |values: [&str; 4]| {
        let readings: Vec<String> = values.iter().map(|y| format!("{{\"y\": {y}}}")).collect();
        format!(
            r#"{{ "bench": {{ "id": "mean", "sensors": {{ "y": {{ "model": "m" }} }} }}, "estimate": {{ "m": {{}} }}, "readings": [ {} ] }}"#,
            readings.join(", ")
        )
    };
    let fit = fitted(&parse(&text(["1.25"; 4])));
    assert_within(uncertainty(&fit, "m"), 0.01 / 48f64.sqrt(), 1e-15, "u of equal readings");
    assert_eq!(fit_report(&fit).fit.resolution.get("y"), Some(&0.01));
    // a scatter that the digits do show is left as it is: 1.2 and 1.3 twice each
    let fit = fitted(&parse(&text(["1.2", "1.3", "1.2", "1.3"])));
    assert_within(uncertainty(&fit, "m"), (0.01_f64 / 3.0 / 4.0).sqrt(), 1e-15, "u of a scatter");
    assert_eq!(fit_report(&fit).fit.resolution.get("y"), None);
}

/// 3 <= b0 <= 4 and b0 <= 2.9999999: no solver's tolerance decides, and the printed bound is the one that was asked.
#[test]
fn bounds_that_contradict_by_little_are_contradictory() {
    let more = r#""constraints": [ { "of": { "b0": 1 }, "between": [3, 4] }, { "of": { "b0": -2 }, "between": [-5.9999998, 10] } ],"#;
    let fit = fitted(&parse(&line(&[(0.0, 1.1), (1.0, 3.0), (2.0, 4.2)], more)));
    assert!(matches!(&fit.constraints, Constraints::Contradictory(named) if *named == [0, 1]), "{:?}", fit.constraints);
    let report = fit_report(&fit).constraints.expect("constraints");
    assert_eq!(report.list[1].text, "-5.9999998 <= -2*b0 <= 10");
}

/// A bound far from the readings is a rejected answer; one that they hardly mind is not.
#[test]
fn a_bound_that_the_readings_contradict_is_rejected() {
    let fit = |bound: f64| {
        let more = format!(r#""constraints": [ {{ "of": {{ "b1": 1 }}, "between": [{bound}, 1000] }} ],"#);
        fitted(&parse(&line(&[(0.0, 1.1), (1.0, 2.9), (2.0, 5.2), (3.0, 6.9), (4.0, 9.1)], &more)))
    };
    let bounds_p = |fit: &fit::Fit| fit_report(fit).constraints.and_then(|own| own.p).expect("active");
    let far = fit(100.0);
    assert!(far.is_rejected() && bounds_p(&far) < 1e-6);
    let near = fit(2.01);
    assert!(!near.is_rejected() && bounds_p(&near) > 0.05, "{:?}", bounds_p(&near));
}

/// Squares of 1e-200 are zero: refused, with the reading.
#[test]
fn numbers_beyond_a_square_are_refused_with_their_place() {
    let small = refused(&line(&[(0.0, 1e-200), (1.0, 3e-200), (2.0, 4e-200)], ""));
    assert!(small.what().contains("largest reading of y") && small.place().path == "readings[2]", "{small:?}");
    let large = refused(&line(&[(0.0, 1.0), (1e150, 3.0), (2.0, 4.0)], ""));
    assert!(large.what().contains("column x") && large.place().path == "readings[1]", "{large:?}");
    let known = line(&[(0.0, 1.0), (1.0, 3.0), (2.0, 4.0)], r#""known": { "c": { "value": 1e300 } },"#)
        .replace("b0 + b1*x", "b0 + b1*x + c");
    assert_eq!(refused(&known).place().path, "known.c");
}

/// b1/x at x = 0: which reading, which term, which inputs.
#[test]
fn a_term_without_a_value_is_named() {
    let text = line(&[(1.0, 1.0), (2.0, 3.0), (0.0, 4.0)], "").replace("b0 + b1*x", "b0 + (b1 + 1)/x");
    let error = refused(&text);
    assert_eq!(error.place().path, "readings[2]");
    assert!(error.what().contains("model line of y has no value"), "{error:?}");
    assert_eq!(error.finding(), Some("(b1 + 1)/x with b1 = 0, x = 0"));
}

/// Radians in a column of degrees are remarked; degrees are not.
#[test]
fn radians_under_degrees_are_remarked() {
    let campaign = |scale: f64| {
        let readings: Vec<String> = (0..8)
            .map(|k| {
                let degrees = 45.0 * f64::from(k);
                let value = 1.3 * degrees.to_radians().sin() + 0.01 + 1e-4 * f64::from(k % 3);
                format!("{{\"beta_deg\": {:.4}, \"V\": {value:.5}}}", degrees * scale)
            })
            .collect();
        parse(&format!(
            r#"{{ "bench": "accelerometer-plumb-plane", "estimate": {{ "kI": {{}}, "V0": {{}} }}, "readings": [ {} ] }}"#,
            readings.join(", ")
        ))
    };
    assert!(fitted(&campaign(1.0)).remarks().is_empty());
    let remarks = fitted(&campaign(1f64.to_radians())).remarks();
    assert!(
        remarks.iter().any(|remark| remark.to_string().contains("beta_deg") && remark.to_string().contains("radians")),
        "{remarks:?}"
    );
}

/// A design and a campaign that do not belong together: what the campaign does not have is an error, never left out and never zero.
#[test]
fn a_design_of_another_campaign_is_refused() {
    let campaign = parse(&line(&[(0.0, 1.0), (1.0, 3.0), (2.0, 4.0)], ""));
    let model = design::Model::new(&campaign).unwrap();
    let full = design::assemble(&campaign, &model, &campaign.reference_point()).unwrap();
    let weigh = |campaign: &Campaign, design: &DesignMatrix| fit::weigh(campaign, design, fit::Weighting::AsStated);
    assert_eq!(weigh(&campaign, &full).unwrap().observed.len(), 3);
    // a reading without the value that the design has a row for
    let mut other = campaign.clone();
    other.readings.rows[1].observations = Vec::new().into();
    let error = weigh(&other, &full).expect_err("a row without its value").to_string();
    assert!(error.contains("a row of the design has no value of y") && error.contains("reading 2 of 3"), "{error}");
    // fewer readings than the design has
    let mut other = campaign.clone();
    other.readings.rows.truncate(2);
    let error = weigh(&other, &full).expect_err("a row without its reading").to_string();
    assert!(error.contains("nothing in reading 3 of 2"), "{error}");
    // a design at fewer values than there are unknowns
    let mut short = full.clone();
    short.point.truncate(1);
    let error = weigh(&campaign, &short).expect_err("a short point").to_string();
    assert!(error.contains("a design matrix at 1 values") && error.contains("each of the 2 unknowns"), "{error}");
}

/// What a model line cannot take its value from: another sensor's axis, an unknown name, a column that a reading lacks.
#[test]
fn a_line_without_its_inputs_is_refused() {
    let two = |model: &str| {
        format!(
            r#"{{ "bench": {{ "id": "two", "chain": [ {{ "joint": "t", "about": "x" }} ],
                "sensors": {{ "A": {{ "axes": {{ "I": "z" }}, "model": "a0 + a_I" }}, "B": {{ "axes": {{ "O": "y" }}, "model": "{model}" }} }} }},
              "estimate": {{ "a0": {{}} }}, "readings": [ {{ "t_deg": 0, "A": 1, "B": 2 }}, {{ "t_deg": 90, "A": 1, "B": 2 }} ] }}"#
        )
    };
    let error = |model: &str| {
        Campaign::from_json(&two(model))
            .and_then(|own| fit::fit(&own, &Settings::default()))
            .err()
            .map_or(String::new(), |error| error.to_string())
    };
    let said = error("a0 + a_I");
    assert!(said.contains("sensor B has no axis 'I'") && said.contains("an axis of another sensor"), "{said}");
    // a coefficient that is neither known nor estimated is zero, and listed as assumed
    assert_eq!(error("a0 + c9*a_O"), "");
    // the same lines bound to a campaign whose columns or parameters were taken away
    let columns = r#"{ "bench": { "id": "line", "sensors": { "y": { "model": "b0 + b1*x" } } },
        "estimate": { "b0": {}, "b1": {} }, "readings": [ {"x": 0, "y": 1}, {"x": 1, "y": 3}, {"x": 2, "y": 4} ] }"#;
    let campaign = parse(columns);
    let model = design::Model::new(&campaign).unwrap();
    let mut lacking = campaign.clone();
    lacking.readings.rows[2].columns[0] = None;
    let said = design::assemble(&lacking, &model, &campaign.reference_point()).expect_err("no x").to_string();
    assert!(said.contains('x'), "{said}");
    let mut without = campaign.clone();
    without.readings.columns.clear();
    let said = design::Model::new(&without).expect_err("no column x").to_string();
    assert!(said.contains("'x' is not an input, column or parameter here"), "{said}");
    let mut without = campaign;
    without.parameters.remove(1);
    let said = design::Model::new(&without).expect_err("no parameter b1").to_string();
    assert!(said.contains("'b1' is not an input, column or parameter here"), "{said}");
}

/// Readings without noise: their residuals are rounding, and nothing of them is tested.
#[test]
fn residuals_of_rounding_are_not_tested() {
    let path = data("noise_free/pressure.campaign.json");
    let fit = fitted(&tumble::Campaign::from_path(path).unwrap());
    assert!(fit.checks.snooping.iter().all(|found| found.suspects.is_empty()), "{:?}", fit.checks.snooping);
    assert!(fit.checks.normality.is_none() && fit.checks.runs.is_empty() && fit.checks.lack_of_fit.is_none());
    // one wrong reading among them is seen, and nothing else
    let mut wrong = fit.campaign.clone();
    wrong.readings.rows[4].observations[0].value += 0.25;
    let found = fitted(&wrong).checks.snooping.unwrap();
    let rows: Vec<usize> = found.suspects.iter().map(|own| own.row).collect();
    assert_eq!(rows, [4]);
}

/// `Y = 1 + 1e-3 t + 2e-2 T` without any noise, t = 0, 1, 4, .. 81 s: what two ways of summing differ by is rounding, and no sign of a model that is not linear.
#[test]
fn rounding_is_not_taken_for_curvature() {
    let rows: Vec<String> = (0..10)
        .map(|k| {
            let y = 1000 + k * k + 20 * k;
            format!(r#"{{ "time_s": {}, "temperature_c": {k}, "Y": {}.{:03} }}"#, k * k, y / 1000, y % 1000)
        })
        .collect();
    let text = format!(
        r#"{{ "bench": {{ "id": "q", "chain": [], "sensors": {{ "Y": {{ "unit": "V", "model": "a + q*time_s + p*temperature_c" }} }} }},
            "estimate": {{ "a": {{}}, "p": {{}}, "q": {{}} }}, "readings": [ {} ] }}"#,
        rows.join(", ")
    );
    let campaign = tumble::Campaign::from_json(&text).unwrap();
    let found = fitted(&campaign);
    assert!((found.parameters[0].value.unwrap() - 1.0).abs() < 1e-14);
    assert_eq!(
        found.nonlinearity.iter().map(|share| share.unwrap()).fold(0.0_f64, |most, share| most.max(share.abs())),
        0.0
    );
}

/// At rest on an axis along which the gyro measures, every angle gives the same reading: none need be stated. Where a tilt makes the angle matter, it must.
#[test]
fn a_reading_at_rest_needs_an_angle_only_where_it_matters() {
    let table = |bench: &str, rest: &str| {
        let turning =
            [50.0, -50.0, 100.0].map(|rate| format!(r#"{{ "gamma_deg_s": {rate}, "V": {} }}"#, 0.002 + 0.02 * rate));
        format!(
            r#"{{ "bench": {bench}, "site": {{ "latitude_deg": 45 }}, "estimate": {{ "V0": {{}}, "K": {{}} }},
                  "readings": [ {}, {{ "gamma_deg_s": 0{rest}, "V": 0.0021 }} ] }}"#,
            turning.join(", ")
        )
    };
    let steps = r#""gyro-rate-steps""#;
    let [without, with] = ["", r#", "gamma_deg": 77"#].map(|rest| fitted(&parse(&table(steps, rest))));
    for id in ["V0", "K"] {
        assert_within(value(&without, id), value(&with, id), 1e-15, id);
        assert_within(uncertainty(&without, id), uncertainty(&with, id), 1e-15, id);
    }
    let tilted = r#"{ "id": "tilted", "chain": [ { "joint": "gamma", "about": "z" }, { "tilt": "m", "about": "x" } ],
                      "sensors": { "V": { "axes": { "I": "z" }, "model": "V0 + K*w_I" } } }"#;
    let source = tumble::wire::Source { name: "test".into(), text: table(tilted, "") };
    let error =
        tumble::wire::read_campaign(&source, &mut |name| panic!("refers to {name}")).expect_err("a missing angle");
    assert!(error.to_string().contains("angle is missing"), "{error}");
}
