//! How estimates follow a known input: the sensitivity coefficient of its Type B line is the difference of two fits.

use crate::support::*;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use tumble::campaign::{Campaign, Role};
use tumble::fit::{Estimator, Fit, Settings};

/// The campaign with a known value moved, and with a standard uncertainty for it.
fn with_known(campaign: &Campaign, id: &str, by: f64, u: f64) -> Campaign {
    let mut changed = campaign.clone();
    let parameter = changed.parameters.iter_mut().find(|p| p.id == id).expect("a parameter");
    let Role::Known(known) = &mut parameter.role else { panic!("{id} is not known") };
    known.value += by;
    known.u = u;
    changed
}

fn assert_follows(campaign: &Campaign, id: &str, u: f64, settings: Settings) {
    let at = |by: f64| fit_with(&with_known(campaign, id, by, u), settings);
    let (fit, up, down): (Fit, Fit, Fit) = (at(0.0), at(u), at(-u));
    for parameter in &fit.parameters {
        let line = parameter.budget.iter().find(|line| line.source == id).unwrap_or_else(|| panic!("no line for {id}"));
        let difference = (value(&up, &parameter.id) - value(&down, &parameter.id)) / (2.0 * u);
        let own = line.sensitivity.expect("one source");
        // residuals (of the linear estimator: second order in tilts of 1e-3) and the curvature over +-u
        let tolerance = 2e-3 * difference.abs().max(1e-6);
        assert_within(own, difference, tolerance, &format!("d {} / d {id}", parameter.id));
        assert_within(line.u, (own * u).abs(), 1e-15, "c u");
        let own_u = parameter.uncertainty.as_ref().expect("an uncertainty");
        assert_within(own_u.type_b, line.u, 1e-15, "Type B");
    }
}

/// Misalignments are a voltage over kI: a scale factor wrong by 0.1 % makes them wrong by 0.1 %, from zero tilts as reference too.
#[test]
fn a_scale_factor_scales_the_angles() {
    for name in ["gyro-1", "gyro-2", "gyro-3", "accelerometer-1"] {
        let campaign = campaign(&format!("simulated/{name}.campaign.json"));
        for estimator in [Estimator::Linear, Estimator::Exact] {
            assert_follows(&campaign, "kI", 1e-3, Settings { estimator, ..Settings::default() });
        }
        let fit = fitted(&with_known(&campaign, "kI", 0.0, 1e-3));
        let angle = fit.parameters.iter().find(|p| p.id == "dtheta_y2").expect("a tilt");
        let kind = angle.uncertainty.as_ref().expect("an uncertainty").type_b;
        let kappa = campaign.parameters.iter().find(|p| p.id == "kI").map(|p| p.reference()).expect("kI");
        assert!(
            kind > 0.5 * (value(&fit, "dtheta_y2") * 1e-3 / kappa).abs(),
            "{name}: Type B of dtheta_y2 is {kind:e}"
        );
    }
}

/// A fixed height moves a levelling net as a whole.
#[test]
fn a_fixed_height_moves_the_net() {
    let campaign = campaign("levelling/krumm.campaign.json");
    assert_follows(&campaign, "H5", 1e-3, Settings::default());
    let fit = fitted(&with_known(&campaign, "H5", 0.0, 0.003));
    for parameter in &fit.parameters {
        let uncertainty = parameter.uncertainty.as_ref().expect("an uncertainty");
        assert_within(uncertainty.type_b, 0.003, 1e-15, &parameter.id);
        assert_within(uncertainty.u, uncertainty.type_a.hypot(0.003), 1e-15, &parameter.id);
    }
}

/// `u^2 = 9 + 4 + 2*0.5*3*2 = 19` through two inputs that both share, 16 of each one's own: what is shared leaves the difference with all of it.
#[test]
fn shared_inputs_that_are_correlated() {
    use nalgebra::DMatrix;
    use tumble::compare::calibrations::{Determination, InputShare, Quantity, changes};
    let input = |id: &str, u: f64| InputShare { id: id.into(), estimate: 1.0, u, c: 1.0 };
    let of = |value: f64, correlation: f64| Determination {
        quantities: vec![Quantity {
            id: "k".into(),
            unit: "ppm".into(),
            value,
            u: Some(35f64.sqrt()),
            dof: f64::INFINITY,
            inputs: vec![input("kI", 3.0), input("V0", 2.0)],
        }],
        covariance: DMatrix::from_element(1, 1, 35.0),
        correlations: vec![("kI".into(), "V0".into(), correlation)],
        ..Determination::default()
    };
    let found = changes(&of(10.0, 0.5), &of(20.0, 0.5), 0.95, true);
    assert!((found.changes[0].u.expect("judged") - 32f64.sqrt()).abs() < 1e-12);
    assert!((found.together.expect("a test").statistic - 100.0 / 32.0).abs() < 1e-12);
    // not the same inputs: their correlation is not shared
    let other = changes(&of(10.0, 0.5), &of(20.0, 0.4), 0.95, true);
    assert!((other.changes[0].u.expect("judged") - 44f64.sqrt()).abs() < 1e-12);
}

/// Three inputs of which two are one and the same: a semidefinite matrix, as good as any. One that no three inputs can have is refused.
#[test]
fn a_semidefinite_matrix_of_correlations_is_accepted_and_an_indefinite_one_is_not() {
    let campaign = |pairs: [f64; 3]| {
        let [ab, ac, bc] = pairs;
        let text = format!(
            r#"{{ "bench": {{ "id": "sum", "sensors": {{ "y": {{ "model": "m + a + b + c" }} }} }}, "estimate": {{ "m": {{}} }},
                "known": {{ "a": {{ "value": 1, "u": 3 }}, "b": {{ "value": 2, "u": 4 }}, "c": {{ "value": 3, "u": 5 }} }},
                "correlations": [ ["a", "b", {ab}], ["a", "c", {ac}], ["b", "c", {bc}] ],
                "readings": [ {{ "y": 10, "y_u": 1e-9 }} ] }}"#
        );
        let source = tumble::wire::Source { name: "sum".into(), text };
        tumble::wire::read_campaign(&source, &mut |name| panic!("refers to {name}"))
    };
    // c is a, and b follows both by 0.6: u^2 = 9 + 16 + 25 + 2 (0.6 12 + 15 + 0.6 20)
    let own = fitted(&campaign([0.6, 1.0, 0.6]).expect("a matrix that inputs can have"));
    let expected = (50.0 + 2.0 * (0.6 * 12.0 + 15.0 + 0.6 * 20.0_f64)).sqrt();
    assert_within(uncertainty(&own, "m"), expected, 1e-9, "u");
    // trials drawn with the matrix's triangle, (1), (0.6, 0.8), (1, 0, 0), say the same: 100,000 of them, sd of their sd 0.0022 of it
    let drawn = tumble::fit::draw(&own, 100_000, 1, &|_| ()).expect("a question").expect("trials");
    assert_within(drawn.outputs[0].u, expected, 0.01 * expected, "sd of trials");
    let error = campaign([0.9, -0.9, 0.9]).expect_err("a matrix that no inputs have").to_string();
    assert!(error.contains("not positive semidefinite"), "{error}");
}

fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    move || StandardNormal.sample(&mut rng)
}

/// A line whose slope is known to `u`, drawn `error` away, with readings at -10 to 10: `y = a + k x`, sd 1e-4.
fn line(seed: u64, stated: bool, u: f64, error: f64) -> (Campaign, Vec<f64>, Vec<f64>) {
    let mut draws = normal(seed);
    let x: Vec<f64> = (-10..=10).map(f64::from).collect();
    let y: Vec<f64> = x.iter().map(|x| 1.0 + (0.05 + error) * x + 1e-4 * draws()).collect();
    let own_u = if stated { r#", "y_u": 1e-4"# } else { "" };
    let readings: Vec<String> =
        x.iter().zip(&y).map(|(x, y)| format!(r#"{{ "x": {x}, "y": {y:.12}{own_u} }}"#)).collect();
    let text = format!(
        r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "model": "a + k*x" }} }} }}, "estimate": {{ "a": {{}} }},
            "known": {{ "k": {{ "value": 0.05, "u": {u} }} }}, "readings": [ {} ] }}"#,
        readings.join(", ")
    );
    let y = y.iter().map(|y| (y * 1e12).round() * 1e-12).collect();
    (parse(&text), x, y)
}

/// Squares of the residuals about the mean, their products with the known input's column about its mean, and the squares of this.
fn sums(x: &[f64], y: &[f64]) -> (f64, f64, f64) {
    let less: Vec<f64> = x.iter().zip(y).map(|(x, y)| y - 0.05 * x).collect();
    let mean = less.iter().sum::<f64>() / less.len() as f64;
    // the mean of x is zero
    let product = less.iter().zip(x).map(|(r, x)| (r - mean) * x).sum();
    (less.iter().map(|r| (r - mean).powi(2)).sum(), product, x.iter().map(|x| x * x).sum())
}

/// `chi^2 = r' (s^2 I + u^2 c c')^-1 r`, by Sherman and Morrison's formula for one column; the estimate is the mean, as if the input had no uncertainty. The
/// same from a record that is streamed.
#[test]
fn chi_square_is_that_of_residuals_that_share_the_error_of_an_input() {
    let (s, u) = (1e-4, 5e-5);
    for seed in 0..5 {
        let (campaign, x, y) = line(seed, true, u, 1.5 * u);
        let (squares, product, column) = sums(&x, &y);
        let expected = (squares - product.powi(2) * u * u / (s * s + u * u * column)) / (s * s);
        let fit = fitted(&campaign);
        let test = fit.global_test.expect("stated uncertainties");
        // differences of numbers near 1 with 12 decimals, squared
        assert_within(test.chi_square, expected, 1e-6 * expected, "chi^2");
        assert_eq!(test.dof, 20);
        assert_within(value(&fit, "a"), y.iter().sum::<f64>() / 21.0, 1e-14, "a");
        let mut rows = tumble::fit::streamed::Held::new(campaign.readings.clone());
        let sample = tumble::fit::streamed::sample(&mut rows).expect("a sample");
        let own = Campaign { readings: sample.readings.clone(), ..campaign };
        let streamed = tumble::fit::streamed::fit(own, &mut rows, &sample, &Settings::default()).expect("a fit");
        assert_within(streamed.global_test.expect("a test").chi_square, expected, 1e-6 * expected, "chi^2 of a record");
    }
}

/// Where the readings' scatter is estimated, the error of an input is no part of it: `s` is at the top of the restricted likelihood of residuals with the
/// covariance `s^2 I + u^2 c c'`, whose logarithm is written out here in the directions along c and across.
#[test]
fn the_scatter_is_estimated_beside_the_error_of_an_input() {
    for seed in 0..5 {
        let u = 5e-5;
        let (campaign, x, y) = line(seed, false, u, 1.5 * u);
        let (squares, product, column) = sums(&x, &y);
        let (along, gain) = (product.powi(2) / column, u * u * column);
        let deviance = |ln: f64| {
            let s = ln.exp();
            19.0 * ln + (squares - along) / s + (s + gain).ln() + along / (s + gain)
        };
        // golden section
        let (mut low, mut high) = ((1e-10_f64).ln(), (1e-6_f64).ln());
        while high - low > 1e-8 {
            let (a, b) = (high - 0.618034 * (high - low), low + 0.618034 * (high - low));
            if deviance(a) < deviance(b) { high = b } else { low = a }
        }
        let expected = (0.5 * low).exp();
        let fit = fitted(&campaign);
        let scale = fit.estimate.group_scale[0].expect("a scale");
        // the root of the rounding of the deviance
        assert_within(scale, expected, 1e-6 * expected, "s");
        let own = fit.parameters[0].uncertainty.expect("an uncertainty");
        assert_within(own.u, expected / 21f64.sqrt(), 1e-6 * own.u, "u");
        // of 20 the input's direction takes its share
        let dof = 20.0 - gain / (expected.powi(2) + gain);
        assert_within(own.dof, dof, 1e-5 * dof, "dof");
        let mut rows = tumble::fit::streamed::Held::new(campaign.readings.clone());
        let sample = tumble::fit::streamed::sample(&mut rows).expect("a sample");
        let own = Campaign { readings: sample.readings.clone(), ..campaign };
        let streamed = tumble::fit::streamed::fit(own, &mut rows, &sample, &Settings::default()).expect("a fit");
        assert_within(uncertainty(&streamed, "a"), expected / 21f64.sqrt(), 1e-6 * expected, "u of a record");
    }
}

/// Campaigns whose known input is drawn from its uncertainty are rejected as often as the level says, and an error of eight times that always is.
#[test]
fn honest_draws_of_an_input_pass_the_global_test() {
    let u = 5e-5;
    let mut draws = normal(1000);
    let rejected = (0..200).filter(|seed| fitted(&line(*seed, true, u, u * draws()).0).is_rejected()).count();
    println!("{rejected} of 200 rejected at 95 %");
    // 10 are expected; beyond 22 (four standard deviations) lie 1e-4
    assert!(rejected <= 22, "{rejected}");
    assert!((0..20).all(|seed| fitted(&line(seed, true, u, 8.0 * u).0).is_rejected()));
}
