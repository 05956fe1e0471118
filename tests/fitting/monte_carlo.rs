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
        let model =
            Model { point: vec![0.0; 4], scatter: Vec::new(), known, correlation: Vec::new(), outputs, bounds: None };
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
    let model =
        Model { point: vec![1.0, 2.0], scatter, known: Vec::new(), correlation: Vec::new(), outputs, bounds: None };
    let found = monte_carlo(&model, 400_000, 2, 2, 0.95, &|_| ()).unwrap();
    assert!((found.ellipsoid_factor.unwrap() - 2.4477).abs() < 0.01);
    assert_eq!(found, monte_carlo(&model, 400_000, 2, 2, 0.95, &|_| ()).unwrap());
}

/// A total misalignment near zero is not normal: the warning comes, and the interval does not reach below zero.
#[test]
fn gamma_near_zero() {
    let fit = fitted(&campaign("li2012/li2012-table2.campaign.json"));
    let drawn = fit::draw(&fit, 200_000, 1, &|_| ()).unwrap().unwrap();
    let gamma = drawn.outputs.iter().find(|output| output.id == "gamma").unwrap();
    assert_eq!(gamma.first_order_agrees, Some(false));
    assert!(gamma.interval[0] > 0.0);
    let mut parameters = drawn.outputs.iter().filter(|output| fit.parameters.iter().any(|p| p.id == output.id));
    assert!(parameters.all(|output| output.first_order_agrees == Some(true)));
    // far from zero the first order holds
    let fit = fitted(&campaign("li2012/li2012-table1.campaign.json"));
    let drawn = fit::draw(&fit, 200_000, 1, &|_| ()).unwrap().unwrap();
    assert!(drawn.outputs.iter().all(|output| output.first_order_agrees == Some(true)));
    let gamma = drawn.outputs.iter().find(|output| output.id == "gamma").unwrap();
    assert!((gamma.mean / ARCSEC - 171.48).abs() < 0.05);
    assert!(fit::draw(&fit, 10, 1, &|_| ()).is_err());
}

/// A linear model with a normal or t distributed estimate: the first order is exact, and no seed makes the sampling error of the trials a
/// reason to say otherwise.
#[test]
fn a_linear_model_is_described_by_the_first_order_whatever_the_seed() {
    let h3 = fitted(&campaign("gum/h3.campaign.json"));
    for seed in 1..=40 {
        let drawn = fit::draw(&h3, 10_000, seed, &|_| ()).expect("drawn").expect("known uncertainties");
        assert!(drawn.outputs.iter().all(|o| o.first_order_agrees == Some(true)), "seed {seed}: {:?}", drawn.outputs);
    }
}

/// All trials of a model of two parameters with one source of scatter, drawn here as the module says: normal deviates through the factor, widened by
/// `sqrt(nu / chi^2_nu)`, in blocks of 10,000 with streams of their own.
fn trials(model: &Model, count: u64, seed: u64, outputs: impl Fn(f64, f64) -> [f64; 3]) -> Vec<[f64; 3]> {
    use rand_distr::{ChiSquared, Distribution as _, StandardNormal};
    use rand_pcg::rand_core::SeedableRng;
    let source = &model.scatter[0];
    let chi = ChiSquared::new(source.dof).unwrap();
    let mut all = Vec::new();
    for block in 0..count / 10_000 {
        let stream = seed.wrapping_add(block.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(stream);
        for _ in 0..10_000 {
            let widen = (source.dof / chi.sample(&mut random)).sqrt();
            let (mut a, mut b) = (model.point[0], model.point[1]);
            for k in 0..2 {
                let z: f64 = StandardNormal.sample(&mut random);
                a += source.factor[(0, k)] * z * widen;
                b += source.factor[(1, k)] * z * widen;
            }
            all.push(outputs(a, b));
        }
    }
    all.retain(|own| own.iter().all(|x| x.is_finite()));
    all
}

/// Intervals, sampling errors and ellipsoid from the tails are those of all trials kept and sorted, at any level; a skew output, one that
/// is not always finite, and two that depend on each other but for a little.
#[test]
fn tails_say_what_all_trials_say() {
    let names = ["a", "b"];
    let line = |text: &str| Tape::compile(&Expression::parse(text).unwrap(), &names).unwrap();
    let factor = Mat::from_fn(2, 2, |i, j| if i >= j { 1.0 } else { 0.0 });
    let model = Model {
        point: vec![1.0, 2.0],
        scatter: vec![Scatter { factor, dof: 5.0 }],
        known: Vec::new(),
        correlation: Vec::new(),
        outputs: vec![Output::Parameter(0), Output::Line(line("a^2 + b")), Output::Line(line("sqrt(b + 4)"))],
        bounds: None,
    };
    let all = trials(&model, 200_000, 7, |a, b| [a, a.powi(2) + b, (b + 4.0).sqrt()]);
    let m = all.len();
    for level in [0.3, 0.6827, 0.95, 0.9973, 0.99999] {
        let found = monte_carlo(&model, 200_000, 7, 3, level, &|_| ()).unwrap();
        assert!(m == found.trials && m < 200_000, "{m}");
        for (k, own) in found.outputs.iter().enumerate() {
            let mut sorted: Vec<f64> = all.iter().map(|trial| trial[k]).collect();
            let mean = sorted.iter().sum::<f64>() / m as f64;
            let sd = (sorted.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (m as f64 - 1.0)).sqrt();
            assert!((own.mean - mean).abs() < 1e-12 * sd && (own.sd / sd - 1.0).abs() < 1e-12);
            sorted.sort_by(f64::total_cmp);
            // JCGM 101, 7.7: q trials between the ends, those left out in equal numbers, or where the ends are nearest
            let q = (level * m as f64 + 0.5) as usize;
            let first = (m - q).div_ceil(2) - 1;
            assert_eq!(own.symmetric, (sorted[first], sorted[first + q]), "output {k} at {level}");
            let shortest = (0..m - q)
                .map(|r| (sorted[r], sorted[r + q]))
                .reduce(|best, own| if own.1 - own.0 < best.1 - best.0 { own } else { best });
            assert_eq!(Some(own.shortest), shortest, "output {k} at {level}");
            // places in the order follow a binomial distribution: 3.9 standard deviations and one place to either side
            let end = |p: f64| {
                let (place, reach) = (m as f64 * p, 1.0 + 3.9 * (m as f64 * p * (1.0 - p)).sqrt());
                let at = |place: f64| sorted[(place.max(0.0) as usize).min(m - 1)];
                (at((place - reach).floor()), at((place + reach).ceil()))
            };
            assert_eq!(own.ends, [end(0.5 * (1.0 - level)), end(0.5 * (1.0 + level))], "output {k} at {level}");
        }
        let inverse = {
            use faer::linalg::solvers::DenseSolveCore;
            Mat::from_fn(3, 3, |i, j| found.covariance[i][j]).partial_piv_lu().inverse()
        };
        let mut squares: Vec<f64> = all
            .iter()
            .map(|trial| {
                let off: Vec<f64> = trial.iter().zip(&found.outputs).map(|(x, own)| x - own.mean).collect();
                (0..3).map(|i| (0..3).map(|j| off[i] * inverse[(i, j)] * off[j]).sum::<f64>()).sum()
            })
            .collect();
        squares.sort_by(f64::total_cmp);
        let expected = squares[(level * m as f64).ceil() as usize - 1].sqrt();
        assert!((found.ellipsoid_factor.unwrap() / expected - 1.0).abs() < 1e-9, "{level}");
    }
}
