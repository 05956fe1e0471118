//! Monte Carlo against JCGM 101 and 102, and where the first order fails.

use crate::support::{ARCSEC, campaign, fitted};
use faer::Mat;
use tumble::algebra::{Expression, Tape};
use tumble::campaign::{Distribution, Known};
use tumble::fit;
use tumble::uncertainty::monte_carlo::{KnownInput, Model, Output, Scatter, monte_carlo};

/// JCGM 101, 9.2.3: the sum of four rectangular quantities of standard deviation 1 lies within +- 3.88 in 95 % (9.2.2: normal, +- 3.92).
#[test]
fn sum_of_four() {
    let line = Expression::parse("a + b + c + d").unwrap();
    let names = ["a", "b", "c", "d"];
    for (distribution, expected) in [(Distribution::Rectangular, 3.88), (Distribution::Normal, 3.92)] {
        let known = (0..4)
            .map(|parameter| KnownInput {
                parameter,
                known: Known { value: 0.0, u: 1.0, dof: f64::INFINITY, distribution },
                sensitivity: Vec::new(),
            })
            .collect();
        let outputs = vec![Output::Line(Tape::compile(&line, &names).unwrap())];
        let model = Model { point: vec![0.0; 4], scatter: Vec::new(), known, correlation: Vec::new(), outputs };
        let found = monte_carlo(&model, 1_000_000, 1, 0, 0.95, &|_| ()).unwrap();
        let own = found.outputs[0];
        assert!((own.sd - 2.0).abs() < 0.01);
        assert!((own.symmetric.0 + expected).abs() < 0.02 && (own.symmetric.1 - expected).abs() < 0.02, "{own:?}");
        assert!((own.shortest.1 - own.shortest.0 - 2.0 * expected).abs() < 0.04);
    }
}

/// JCGM 102, 6.5.2.3: two independent normal outputs have k_p = 2.45.
#[test]
fn coverage_ellipse() {
    let scatter = vec![Scatter { factor: Mat::identity(2, 2), dof: f64::INFINITY }];
    let outputs = vec![Output::Parameter(0), Output::Parameter(1)];
    let model = Model { point: vec![1.0, 2.0], scatter, known: Vec::new(), correlation: Vec::new(), outputs };
    let found = monte_carlo(&model, 400_000, 2, 2, 0.95, &|_| ()).unwrap();
    assert!((found.ellipsoid_factor.unwrap() - 2.4477).abs() < 0.01);
    assert_eq!(found, monte_carlo(&model, 400_000, 2, 2, 0.95, &|_| ()).unwrap());
}

/// A total misalignment near zero is not normal: the warning comes, and the interval does not reach below zero.
#[test]
fn gamma_near_zero() {
    let fit = fitted(&campaign("li2012/li2012-table2.campaign.json"));
    let drawn = fit::draw(&fit, 200_000, 1, &|_| ()).unwrap().unwrap();
    let gamma = drawn.names.iter().position(|n| n == "gamma").unwrap();
    assert_eq!(drawn.agrees[gamma], Some(false));
    assert!(drawn.trials.outputs[gamma].symmetric.0 > 0.0);
    assert!((0..drawn.parameters).all(|k| drawn.agrees[k] == Some(true)));
    // far from zero the first order holds
    let fit = fitted(&campaign("li2012/li2012-table1.campaign.json"));
    let drawn = fit::draw(&fit, 200_000, 1, &|_| ()).unwrap().unwrap();
    assert!(drawn.agrees.iter().all(|a| *a == Some(true)));
    let gamma = drawn.names.iter().position(|n| n == "gamma").unwrap();
    assert!((drawn.trials.outputs[gamma].mean / ARCSEC - 171.48).abs() < 0.05);
    assert!(fit::draw(&fit, 10, 1, &|_| ()).is_err());
}

/// A linear model with a normal or t distributed estimate: the first order is exact, and no seed makes the sampling error of the trials a
/// reason to say otherwise.
#[test]
fn a_linear_model_is_described_by_the_first_order_whatever_the_seed() {
    let h3 = fitted(&campaign("gum/h3.campaign.json"));
    for seed in 1..=40 {
        let drawn = fit::draw(&h3, 10_000, seed, &|_| ()).expect("drawn").expect("known uncertainties");
        assert!(drawn.agrees.iter().all(|a| *a == Some(true)), "seed {seed}: {:?}", drawn.agrees);
    }
}
