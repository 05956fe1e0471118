//! Numbers of tests/scripts/system_fits.py (numpy; rows and solution of its own) for the noisy campaigns of the examples.

use crate::support::*;
use serde_json::Value;
use tumble::fit;

#[test]
fn estimates_and_uncertainties_agree_with_an_independent_program() {
    let expected: Value = serde_json::from_str(&read("tests/data/systems/fits.json")).unwrap();
    for (path, own) in expected.as_object().unwrap() {
        let fit = fit::fit(&campaign(path), &exact()).unwrap();
        for (id, numbers) in own["parameters"].as_object().unwrap() {
            let (value, u) = (numbers["value"].as_f64().unwrap(), numbers["u"].as_f64().unwrap());
            let p = fit.parameters.iter().find(|p| p.id == *id).unwrap();
            assert!((p.value.unwrap() - value).abs() < 1e-6 * u, "{path} {id}");
            assert!((p.uncertainty.as_ref().unwrap().u / u - 1.0).abs() < 1e-8, "{path} {id}");
        }
    }
}
