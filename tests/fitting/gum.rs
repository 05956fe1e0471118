//! The worked examples of the GUM (JCGM 100:2008) H.1 to H.3 and straight lines of ISO/TS 28037, to the last printed digit.

use crate::support::{campaign, fitted, json, parse};
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
    at_print(test.f, "11066");
    assert_eq!((test.between_dof, test.pure_error_dof), (1, 8));
    assert!(test.rejected);
    assert!(fitted(&campaign("li2012/li2012-table1.campaign.json")).checks.lack_of_fit.is_none());
}
