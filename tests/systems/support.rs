//! Shared by the tests of the published systems: campaigns from files, truths, seeded readings, coverage.
#![allow(dead_code)]

use crate::draws::draws;
use rand_distr::{Distribution as _, StandardNormal, Uniform};
use rand_pcg::{Pcg64Mcg, rand_core::SeedableRng};
use std::collections::BTreeMap;
use std::path::Path;
use tumble::campaign::{Campaign, Distribution, Role};
use tumble::design::Model;
use tumble::error::{Malformed, Result};
use tumble::fit::{self, Fit, Settings};
use tumble::wire::{self, Source};

pub type Truth = BTreeMap<String, f64>;

pub fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

pub fn parse(name: &str, text: &str) -> Result<Campaign> {
    let source = Source { name: name.into(), text: text.into() };
    wire::read_campaign(&source, &mut |other| {
        Err(Malformed::new(tumble::error::Fault::File, format!("'{other}' is not here")))
    })
}

pub fn campaign(path: &str) -> Campaign {
    parse(path, &read(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

pub fn truth(path: &str) -> Truth {
    let value: serde_json::Value = serde_json::from_str(&read(path)).unwrap();
    value["truth"].as_object().unwrap().iter().map(|(k, v)| (k.clone(), v.as_f64().unwrap())).collect()
}

pub fn exact() -> Settings {
    Settings::default()
}

/// The truth as values of all parameters of a campaign.
pub fn point(campaign: &Campaign, truth: &Truth) -> Vec<f64> {
    campaign.parameters.iter().map(|p| truth.get(&p.id).copied().unwrap_or(0.0)).collect()
}

pub fn random(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

pub fn normal(random: &mut Pcg64Mcg) -> f64 {
    StandardNormal.sample(random)
}

/// The campaign's readings as this truth would give them, with noise of standard deviation `sd(sensor, stated u)`.
/// Known parameters with an uncertainty are drawn from their distribution.
pub fn simulated(
    campaign: &Campaign,
    point: &[f64],
    sd: &dyn Fn(usize, Option<f64>) -> f64,
    random: &mut Pcg64Mcg,
) -> Campaign {
    let mut point = point.to_vec();
    for (parameter, value) in campaign.parameters.iter().zip(&mut point) {
        if let Role::Known(known) = parameter.role {
            let draw = match known.distribution {
                Distribution::Rectangular => {
                    let half = 3f64.sqrt();
                    Uniform::new(-half, half).unwrap().sample(random)
                }
                _ => normal(random),
            };
            *value += known.u * draw;
        }
    }
    let model = Model::new(campaign).unwrap();
    let mut work = model.workspace();
    let mut gradient = vec![0.0; campaign.parameters.len()];
    let mut filled = campaign.clone();
    for (k, row) in filled.readings.rows.iter_mut().enumerate() {
        for o in row.observations.iter_mut() {
            let value = model.predict(campaign, k, o.sensor, &point, &mut gradient, &mut work).unwrap();
            o.value = value + sd(o.sensor, o.u) * normal(random);
        }
    }
    filled
}

/// Largest `|estimate - truth| / max(|truth|, floor)` over the estimated parameters.
pub fn worst_relative(fit: &Fit, truth: &Truth, floor: f64) -> (f64, String) {
    let mut worst = (0.0, String::new());
    for p in &fit.parameters {
        let own = truth.get(&p.id).copied().unwrap_or(0.0);
        let error = (p.value.expect("estimable") - own).abs() / own.abs().max(floor);
        if !(error <= worst.0) {
            worst = (error, p.id.clone());
        }
    }
    worst
}

/// How often the 95 % intervals hold the truth, over seeded campaigns; every parameter within five standard errors of what is promised.
/// Where a part of the uncertainty is rectangular, the interval holds a little more: `most` says how much.
pub fn coverage(
    name: &str,
    campaign: &Campaign,
    truth: &Truth,
    sd: &dyn Fn(usize, Option<f64>) -> f64,
    count: usize,
    settings: &Settings,
    most: f64,
) {
    let count = draws(count / 5, count);
    let mut random = random(20120143);
    let point = point(campaign, truth);
    let mut inside: BTreeMap<String, usize> = BTreeMap::new();
    for _ in 0..count {
        let fit = fit::fit(&simulated(campaign, &point, sd, &mut random), settings).unwrap();
        for p in &fit.parameters {
            let u = p.uncertainty.as_ref().expect("an uncertainty").expanded;
            let held = (p.value.unwrap() - truth.get(&p.id).copied().unwrap_or(0.0)).abs() <= u;
            *inside.entry(p.id.clone()).or_default() += usize::from(held);
        }
    }
    println!("{name}: share of {count} campaigns whose 95 % interval holds the truth");
    let slack = 5.0 * (0.95f64 * 0.05 / count as f64).sqrt();
    for (id, held) in &inside {
        let share = *held as f64 / count as f64;
        println!("  {id:12} {share:.4}");
        assert!(share > 0.95 - slack && share < most.max(0.95 + slack), "{id}: {share}");
    }
}

/// The value of a parameter or derived quantity.
pub fn value(fit: &Fit, id: &str) -> f64 {
    let own = fit.parameters.iter().find(|p| p.id == id).and_then(|p| p.value);
    own.or_else(|| fit.derived.iter().find(|d| d.id == id).and_then(|d| d.value)).unwrap_or_else(|| panic!("{id}"))
}
