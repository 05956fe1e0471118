//! What several tests share: fixtures as values, campaigns as the program reads them, and how many digits agree.
#![allow(dead_code, reason = "each test uses its part")]

use serde_json::Value;
use std::path::{Path, PathBuf};
use tumble::campaign::Campaign;
use tumble::fit::{Estimator, Fit, Settings};
use tumble::{fit, wire};

/// One arcsecond in radians.
pub const ARCSEC: f64 = std::f64::consts::PI / (180.0 * 3600.0);

/// A path below `tests/data`.
pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// The text of a fixture.
pub fn text(name: &str) -> String {
    std::fs::read_to_string(data(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// A fixture as JSON.
pub fn json(name: &str) -> Value {
    serde_json::from_str(&text(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// A campaign fixture.
pub fn campaign(name: &str) -> Campaign {
    parse(&text(name))
}

/// A campaign from its text; it may refer to built-in benches only.
pub fn parse(text: &str) -> Campaign {
    let source = wire::Source { name: "test".into(), text: text.into() };
    wire::read_campaign(&source, &mut |name| panic!("refers to {name}")).unwrap_or_else(|error| panic!("{error}"))
}

/// The fit of a campaign with default settings.
pub fn fitted(campaign: &Campaign) -> Fit {
    fit_with(campaign, Settings::default())
}

/// The fit of a campaign by Gauss-Newton, as by default.
pub fn exact(campaign: &Campaign) -> Fit {
    fit_with(campaign, Settings { estimator: Estimator::Exact, ..Settings::default() })
}

/// The fit of a campaign by one linear step from the reference point.
pub fn linear(campaign: &Campaign) -> Fit {
    fit_with(campaign, Settings { estimator: Estimator::Linear, ..Settings::default() })
}

/// The fit of a campaign.
pub fn fit_with(campaign: &Campaign, settings: Settings) -> Fit {
    fit::fit(campaign, &settings).unwrap_or_else(|error| panic!("{error}"))
}

/// The same campaign where the Earth does not turn.
pub fn without_earth_rate(campaign: &Campaign) -> Campaign {
    let mut still = campaign.clone();
    still.bench.site.as_mut().expect("a site").earth_rate_deg_h = 0.0;
    still
}

/// The readings of a campaign for which `keep` holds.
pub fn subset(campaign: &Campaign, keep: impl Fn(&tumble::campaign::Reading) -> bool) -> Campaign {
    let mut readings = campaign.readings.clone();
    readings.rows.retain(|reading| keep(reading));
    campaign.with_readings(readings)
}

/// Estimate of a parameter or derived quantity.
pub fn value(fit: &Fit, id: &str) -> f64 {
    let parameter = fit.parameters.iter().find(|p| p.id == id).map(|p| p.value);
    let derived = fit.derived.iter().find(|d| d.id == id).map(|d| d.value);
    parameter.or(derived).flatten().unwrap_or_else(|| panic!("no value for {id}"))
}

/// Standard uncertainty of a parameter or derived quantity.
pub fn uncertainty(fit: &Fit, id: &str) -> f64 {
    let parameter = fit.parameters.iter().find(|p| p.id == id).map(|p| p.uncertainty.as_ref());
    let derived = fit.derived.iter().find(|d| d.id == id).map(|d| d.uncertainty.as_ref());
    parameter.or(derived).flatten().unwrap_or_else(|| panic!("no uncertainty for {id}")).u
}

/// A number, also where a fixture writes it as text to keep its digits.
pub fn number(value: &Value) -> f64 {
    value.as_f64().or_else(|| value.as_str()?.parse().ok()).unwrap_or_else(|| panic!("{value} is no number"))
}

/// A list of numbers.
pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(number).collect()
}

/// Entries of an object.
pub fn entries(value: &Value) -> impl Iterator<Item = (&String, &Value)> {
    value.as_object().expect("an object").iter()
}

/// Log relative error, the number of correct digits; at most 15.9.
pub fn digits(found: f64, exact: f64) -> f64 {
    let error = if exact == 0.0 { found.abs() } else { ((found - exact) / exact).abs() };
    (-error.max(1.3e-16).log10()).max(0.0)
}

/// Fewest digits of a list.
pub fn worst(found: impl IntoIterator<Item = f64>, exact: &[f64]) -> f64 {
    found.into_iter().zip(exact).map(|(found, exact)| digits(found, *exact)).fold(16.0, f64::min)
}

/// Within `tolerance` of `expected`, absolutely.
#[track_caller]
pub fn assert_within(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found:e} is not {expected:e} within {tolerance:e}");
}
