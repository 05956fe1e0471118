//! The worked examples of the GUM (JCGM 100:2008) H.1 to H.3 and straight lines of ISO/TS 28037, to the last printed digit.

use crate::support::{campaign, fitted, json, parse};
use serde_json::{Value, json};
use tumble::uncertainty::{Contribution, Evaluation, combine, quantiles};

fn at_print(value: f64, printed: &str) {
    let digits = printed.split('.').nth(1).map_or(0, str::len);
    let half = 0.5 * 10f64.powi(-(digits as i32)) * (1.0 + 1e-9);
    assert!((value - printed.parse::<f64>().unwrap()).abs() <= half, "{value} is not {printed}");
}

/// H.1: an end gauge; contributions in nm with their degrees of freedom (Table H.1).
#[test]
fn end_gauge() {
    let one = |source: &str, c: f64, u: f64, dof: f64| Contribution {
        source: source.into(),
        evaluation: Evaluation::TypeB,
        distribution: tumble::uncertainty::Shape::Normal,
        estimate: None,
        source_u: Some(u),
        sensitivity: Some(c),
        u: (c * u).abs(),
        dof,
    };
    let d = combine(&[one("d", 1.0, 5.8, 24.0), one("d1", 1.0, 3.9, 5.0), one("d2", 1.0, 6.7, 8.0)], 0.99).unwrap();
    at_print(d.u, "9.7");
    // the GUM goes on with 9.7, rounded
    let d_dof = d.dof * (9.7 / d.u).powi(4);
    at_print(d_dof, "25.6");
    let nominal = 50.000_623e6;
    let all = [
        one("l_S", 1.0, 25.0, 18.0),
        one("d", 1.0, 9.7, d_dof),
        one("delta alpha", -nominal * 0.1, 0.58e-6, 50.0),
        one("delta theta", -nominal * 11.5e-6, 0.029, 2.0),
    ];
    let combined = combine(&all, 0.99).unwrap();
    at_print(combined.u, "32");
    at_print(combined.dof, "16.7");
    // the GUM truncates to 16 degrees of freedom before it looks k up
    let k = quantiles::coverage_factor(0.99, combined.dof.floor()).unwrap();
    at_print(k, "2.92");
    assert_eq!((k * combined.u.round()).round(), 93.0);
}

/// H.2, second approach: R, X and Z from each of the five sets, then means (Table H.4).
#[test]
fn resistance_and_reactance() {
    let volt = [5.007, 4.994, 5.005, 4.990, 4.999];
    let ampere = [19.663e-3, 19.639e-3, 19.640e-3, 19.685e-3, 19.678e-3];
    let phase: [f64; 5] = [1.0456, 1.0438, 1.0468, 1.0428, 1.0433];
    let readings: Vec<String> = (0..5)
        .map(|k| {
            let z = volt[k] / ampere[k];
            format!(r#"{{"R": {}, "X": {}, "Z": {z}}}"#, z * phase[k].cos(), z * phase[k].sin())
        })
        .collect();
    let sensor = |id: &str, p: &str| format!(r#""{id}": {{"unit": "ohm", "model": "{p}"}}"#);
    let fit = fitted(&parse(&format!(
        r#"{{"bench": {{"id": "gum-h2", "sensors": {{{}, {}, {}}}}},
            "estimate": {{"r": {{}}, "x": {{}}, "z": {{}}}}, "readings": [{}]}}"#,
        sensor("R", "r"),
        sensor("X", "x"),
        sensor("Z", "z"),
        readings.join(",")
    )));
    for (k, (value, u)) in [("127.732", "0.071"), ("219.847", "0.295"), ("254.260", "0.236")].iter().enumerate() {
        at_print(fit.point[k], value);
        at_print(fit.parameters[k].uncertainty.unwrap().u, u);
    }
}

/// H.2, first approach: R, X and Z from the means of V, I and phi with their correlations, by equation (13) (Table H.3; tests/scripts/correlated_inputs.py).
#[test]
fn resistance_and_reactance_by_equation_13() {
    let expected = json("gum/h2-correlated.json");
    let campaign = |correlations: &serde_json::Value| {
        format!(
            r#"{{"bench": {{"id": "gum-h2", "sensors": {{"y": {{"model": "offset + V/I*cos(phi)"}}}}}},
                "known": {}, "correlations": {correlations}, "estimate": {{"offset": {{}}}},
                "derived": {{"R": "V/I*cos(phi)", "X": "V/I*sin(phi)", "Z": "V/I"}}, "readings": [{{"y": 0, "y_u": 1e-9}}]}}"#,
            expected["known"]
        )
    };
    let fit = fitted(&parse(&campaign(&expected["correlations"])));
    for (k, (id, printed)) in [("R", "0.071"), ("X", "0.295"), ("Z", "0.236")].iter().enumerate() {
        let (own, numpy) = (&fit.derived[k], &expected["expected"][id]);
        let u = own.uncertainty.unwrap().u;
        // the GUM rounds the means and coefficients before it goes on
        assert!((u - printed.parse::<f64>().unwrap()).abs() < 0.001, "{id}: {u}");
        assert!((own.value.unwrap() / numpy["value"].as_f64().unwrap() - 1.0).abs() < 1e-12, "{id}");
        assert!((u / numpy["u"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{id}");
        for (pair, digits) in [("r(V, I)", "01"), ("r(V, phi)", "02"), ("r(I, phi)", "12")] {
            let line = own.budget.iter().find(|line| line.source == pair).unwrap();
            assert!((line.u * line.u.abs() - numpy["pairs"][digits].as_f64().unwrap()).abs() < 1e-9, "{id} {pair}");
        }
    }
    // the estimate is the negative of R, through the readings
    let u = fit.parameters[0].uncertainty.unwrap().u;
    assert!((u / expected["expected"]["R"]["u"].as_f64().unwrap() - 1.0).abs() < 1e-9);
    assert!((fit.covariance[(0, 0)].sqrt() / u - 1.0).abs() < 1e-9);
    // trials about the first order: a standard deviation of 20,000 is known to 0.5 %, and nothing here is bent by that much
    let drawn = tumble::fit::draw(&fit, 20_000, 1, &|_| {}).unwrap().unwrap();
    for (k, id) in ["R", "X", "Z"].iter().enumerate() {
        let u = drawn.outputs[k + 1].u;
        assert!((u / expected["expected"][id]["u"].as_f64().unwrap() - 1.0).abs() < 0.02, "{id}: {u}");
    }
    let refused = |correlations: &str, what: &str| {
        let text = campaign(&serde_json::from_str(correlations).unwrap());
        let source = tumble::wire::Source { name: "c".into(), text };
        let error = tumble::wire::read_campaign(&source, &mut |_| unreachable!()).unwrap_err();
        assert!(error.to_string().contains(what), "{error}");
    };
    refused(r#"[["V", "I", 0.9], ["V", "phi", 0.9], ["I", "phi", -0.9]]"#, "positive semidefinite");
    refused(r#"[["V", "W", 0.9]]"#, "'W' is not known");
    refused(r#"[["V", "I", 0.1], ["I", "V", 0.1]]"#, "stated already");
    refused(r#"[["V", "I", 1.1]]"#, "-1 to 1");
}

/// Values, u and covariance of the line of an earlier fit: at x = 5 from readings at 0, 1 and 2, u^2 = u_y^2 (1/3 + 4^2/2).
#[test]
fn known_from_an_earlier_fit() {
    let line = r#"{"bench": {"id": "line", "sensors": {"y": {"model": "a + b*x"}}}, "estimate": {"a": {}, "b": {}},
        "readings": [{"x": 0, "y": 1, "y_u": 0.1}, {"x": 1, "y": 3, "y_u": 0.1}, {"x": 2, "y": 5, "y_u": 0.1}]}"#;
    let earlier = serde_json::to_string(&tumble::report::fit_report(&fitted(&parse(line)))).unwrap();
    let later = r#"{"bench": {"id": "later", "sensors": {"z": {"model": "c + a + b*x"}}}, "known": {"from": "earlier.fit.json"}, "estimate": {"c": {}},
        "derived": {"at_5": "a + 5*b"}, "readings": [{"x": 5, "z": 11, "z_u": 1e-9}]}"#;
    let source = tumble::wire::Source { name: "later".into(), text: later.into() };
    let campaign = tumble::wire::read_campaign(&source, &mut |name| {
        assert_eq!(name, "earlier.fit.json");
        Ok(tumble::wire::Source { name: name.into(), text: earlier.clone() })
    });
    let fit = fitted(&campaign.unwrap());
    let expected = 0.1 * (1.0_f64 / 3.0 + 8.0).sqrt();
    assert!((fit.derived[0].uncertainty.unwrap().u / expected - 1.0).abs() < 1e-9);
    assert!((fit.parameters[0].uncertainty.unwrap().u / expected - 1.0).abs() < 1e-9);
    assert!(fit.point[0].abs() < 1e-9);
}

/// H.3: calibration of a thermometer.
#[test]
fn thermometer() {
    let fit = fitted(&campaign("gum/h3.campaign.json"));
    at_print(fit.point[0], "-0.1712");
    at_print(fit.point[1], "0.00218");
    at_print(fit.parameters[0].uncertainty.unwrap().u, "0.0029");
    at_print(fit.parameters[1].uncertainty.unwrap().u, "0.00067");
    at_print(fit.estimate.residual_sd().unwrap(), "0.0035");
    at_print(fit.covariance[(0, 1)] / (fit.covariance[(0, 0)] * fit.covariance[(1, 1)]).sqrt(), "-0.930");
    at_print(fit.derived[0].value.unwrap(), "-0.1494");
    at_print(fit.derived[0].uncertainty.unwrap().u, "0.0041");
}

/// ISO/TS 28037:2010, clause 6: weighted straight lines, against exact arithmetic.
#[test]
fn straight_lines() {
    for name in ["p13-equal-weights", "p14-unequal-weights"] {
        let fit = fitted(&campaign(&format!("iso28037/{name}.campaign.json")));
        let expected = json(&format!("iso28037/{name}.expected.json"));
        for parameter in &fit.parameters {
            let own = &expected["parameters"][&parameter.id];
            let (value, u) = (own["value"].as_f64().unwrap(), own["u"].as_f64().unwrap());
            assert!((parameter.value.unwrap() / value - 1.0).abs() < 1e-12, "{name} {}", parameter.id);
            assert!((parameter.uncertainty.unwrap().u / u - 1.0).abs() < 1e-12, "{name} {}", parameter.id);
        }
    }
}

/// Table 2 of Li, Ren, Zhao (2012): three runs of four positions; the model leaves far more than they scatter.
#[test]
fn lack_of_fit_of_table_2() {
    let checks = fitted(&campaign("li2012/li2012-table2.campaign.json")).checks;
    let test = checks.lack_of_fit.unwrap();
    at_print(test.f.unwrap(), "11066");
    assert_eq!((test.between_dof, test.pure_error_dof), (1, 8));
    assert!(test.rejected);
    assert!(fitted(&campaign("li2012/li2012-table1.campaign.json")).checks.lack_of_fit.is_none());
}

/// Of two sensors whose scales are estimated each is tested by itself: its F is that of a fit of this sensor alone, and p that of the smaller of two.
#[test]
fn lack_of_fit_of_one_sensor_of_two() {
    // twice each of six settings; the second sensor bends, and its own scale is so large that all residuals together would agree with the replicates
    let readings: Vec<Value> = (0..12_i32)
        .map(|k| {
            let x = f64::from(k / 2);
            let noise = f64::from((7 * k * k + 3 * k) % 11 - 5) * 1e-3;
            json!({ "x": x, "A": 1.0 + 2.0 * x + noise, "B": 3.0 - x + 0.02 * x * x - noise })
        })
        .collect();
    let fitted_of = |ids: &[&str]| {
        let line = |id: &str| (id.to_string(), json!({ "model": format!("b_{id} + k_{id}*x") }));
        let sensors: serde_json::Map<String, Value> = ids.iter().map(|id| line(id)).collect();
        let names = ids.iter().flat_map(|id| [format!("b_{id}"), format!("k_{id}")]);
        let estimate: serde_json::Map<String, Value> = names.map(|name| (name, json!({}))).collect();
        let mut readings = readings.clone();
        for reading in &mut readings {
            reading.as_object_mut().unwrap().retain(|key, _| key == "x" || ids.contains(&key.as_str()));
        }
        fitted(&parse(
            &json!({ "bench": { "id": "lines", "sensors": sensors }, "estimate": estimate, "readings": readings })
                .to_string(),
        ))
    };
    let [a, b] = [["A"], ["B"]].map(|ids| fitted_of(&ids).checks.lack_of_fit.unwrap());
    assert!(b.p < 1e-3 && a.p > 0.05 && a.sensor.is_none(), "{a:?} {b:?}");
    let both = fitted_of(&["A", "B"]).checks.lack_of_fit.unwrap();
    assert_eq!(both.sensor.as_deref(), Some("B"));
    assert_eq!((both.between_dof, both.pure_error_dof, both.rejected), (4, 6, true));
    assert!((both.f.unwrap() / b.f.unwrap() - 1.0).abs() < 1e-9, "{both:?} {b:?}");
    assert!((both.p / (1.0 - (1.0 - b.p) * (1.0 - b.p)) - 1.0).abs() < 1e-6, "{both:?} {b:?}");
}
