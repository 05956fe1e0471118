//! Variance components against Koch's example and Krumm's correlated levelling.

use crate::support::json;
use faer::Mat;
use tumble::estimate::{Felt, Group, LineState, ScatterLine, Settings, System, adjust, adjust_scattered};

fn numbers(value: &serde_json::Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// K.-R. Koch (1999), 3.6.3: a mean of two groups.
#[test]
fn koch_two_groups() {
    let all = json("variance_components_and_blunders.json");
    let koch = &all["koch_vce"];
    let (y, prior, group) = (numbers(&koch["y"]), numbers(&koch["sigma2_prior"]), numbers(&koch["group"]));
    let system = System {
        rows: Mat::from_fn(5, 1, |_, _| 1.0),
        observed: y,
        u: prior.iter().map(|v| v.sqrt()).collect(),
        group: group.iter().map(|g| Group::Estimated(*g as usize)).collect(),
    };
    let found = adjust_scattered(&system, &[], None, &[], &Settings::default()).unwrap();
    assert!(found.converged);
    let variance: Vec<f64> = found.group_variance.iter().map(|v| v.unwrap()).collect();
    // three published iterations (and the fourth recomputed) leave 0.2 %; the mean is converged in the reference
    let total = numbers(&koch["recomputed"]["total_factors"]);
    for (variance, total) in variance.iter().zip(&total) {
        assert!((variance / total - 1.0).abs() < 5e-3, "{variance} {total}");
    }
    let mean = koch["recomputed"]["converged_mean"].as_f64().unwrap();
    assert!(
        (found.estimate.unknowns.solution[0] - mean).abs() < 1e-6,
        "{} {mean}",
        found.estimate.unknowns.solution[0]
    );
}

/// Offsets that rows share, `level(i)` each.
fn offsets(m: usize, level: impl Fn(usize) -> usize) -> ScatterLine {
    let felt = (0..m).map(|row| Felt { row, level: level(row), by: 1.0 }).collect();
    ScatterLine { felt, variance: None, memory: None }
}

/// One-way layout: REML of a balanced design is the analysis of variance, to 1e-10; below zero it is zero.
#[test]
fn balanced_offsets_are_the_analysis_of_variance() {
    for values in [[1.0, 1.2, 2.0, 2.1, 0.4, 0.7], [1.0, 2.0, 1.4, 1.7, 1.1, 1.95]] {
        let system = System {
            rows: Mat::from_fn(6, 1, |_, _| 1.0),
            observed: values.to_vec(),
            u: vec![1.0; 6],
            group: vec![Group::Estimated(0); 6],
        };
        let found = adjust_scattered(&system, &[offsets(6, |i| i / 2)], None, &[], &Settings::default()).unwrap();
        let means: Vec<f64> = values.chunks(2).map(|c| (c[0] + c[1]) / 2.0).collect();
        let grand = means.iter().sum::<f64>() / 3.0;
        let within = values.chunks(2).map(|c| (c[0] - c[1]).powi(2) / 2.0).sum::<f64>() / 3.0;
        let between = 2.0 * means.iter().map(|m| (m - grand).powi(2)).sum::<f64>() / 2.0;
        assert!(found.converged);
        let noise = found.group_variance[0].unwrap();
        if between > within {
            assert!((noise / within - 1.0).abs() < 1e-10, "{noise} {within}");
            assert!((found.variance[0] / ((between - within) / 2.0) - 1.0).abs() < 1e-10, "{:?}", found.variance);
            assert!((found.estimate.unknowns.covariance[(0, 0)] / (between / 6.0) - 1.0).abs() < 1e-10);
            assert!(found.correction[(0, 0)].abs() < 1e-8 * between);
            assert_eq!(found.state, [LineState::Estimated]);
        } else {
            let total = values.iter().map(|y| (y - grand).powi(2)).sum::<f64>() / 5.0;
            assert_eq!((found.variance[0], found.state[0]), (0.0, LineState::AtZero));
            // the floor is 1e-9 of the noise
            assert!((noise / total - 1.0).abs() < 1e-8, "{noise} {total}");
            // at zero the information of the offsets' variance is `2^2 (3 - 1)/noise^2`: one standard uncertainty above it is `noise/2 sqrt(2/2)`. It is asked where
            // the variance is a ten-thousandth of the noise's share, and the information less by about as much
            let could_be = found.could_be[0].unwrap();
            assert!((could_be * could_be / (total / 2.0) - 1.0).abs() < 1e-3, "{could_be} {total}");
            // u and dof do not take the zero for known: they are the mean square between the three and its two degrees of freedom
            let u2 = found.estimate.unknowns.covariance[(0, 0)];
            assert!((u2 / (between / 6.0) - 1.0).abs() < 1e-8, "{u2} {between}");
            let readings: f64 =
                (0..6).map(|i| found.sensitivities[(0, i)].powi(2)).sum::<f64>() * found.weighed_with[0];
            let parts = [readings, found.shares[0][(0, 0)]];
            assert!(parts[1] < 0.0 && ((parts[0] + parts[1]) / u2 - 1.0).abs() < 1e-8, "{parts:?}");
            let spread: f64 = (0..2)
                .flat_map(|g| (0..2).map(move |h| (g, h)))
                .map(|(g, h)| parts[g] * parts[h] * found.spread[(g, h)])
                .sum();
            assert!((2.0 * u2 * u2 / spread - 2.0).abs() < 1e-6, "{spread}");
        }
    }
}

/// One reading of each position: the offsets and the noise are one, the sum is kept and said.
#[test]
fn what_cannot_be_separated_keeps_the_sum() {
    let values = [1.0, 1.3, 0.8, 1.1, 0.7];
    let system = System {
        rows: Mat::from_fn(5, 1, |_, _| 1.0),
        observed: values.to_vec(),
        u: vec![1.0; 5],
        group: vec![Group::Estimated(0); 5],
    };
    let found = adjust_scattered(&system, &[offsets(5, |i| i)], None, &[], &Settings::default()).unwrap();
    assert_eq!((found.state[0], found.variance[0]), (LineState::Inseparable, 0.0));
    let mean = values.iter().sum::<f64>() / 5.0;
    let variance = values.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / 4.0;
    assert!((found.group_variance[0].unwrap() / variance - 1.0).abs() < 1e-10);
}

/// F. Krumm (2020), example 2.3: two correlated datum heights and five height differences, by whitened rows.
#[test]
fn krumm_correlated_datum() {
    let all = json("variance_components_and_blunders.json");
    let krumm = &all["krumm_gls"];
    let order = ["2", "3", "6", "7", "8"];
    let column = |id: &str| order.iter().position(|o| *o == id).unwrap();
    let text = |v: &serde_json::Value| v.as_str().unwrap().parse::<f64>().unwrap();
    let mut rows = Mat::<f64>::zeros(7, 5);
    let mut observed = vec![0.0; 7];
    // Cholesky factor of the datum's covariance
    let (a, b, c) = (0.0025_f64, -0.0015_f64, 0.0036_f64);
    let l11 = a.sqrt();
    let l21 = b / l11;
    let l22 = (c - l21 * l21).sqrt();
    let (h2, h3) = (text(&krumm["datum_obs"]["2"]), text(&krumm["datum_obs"]["3"]));
    rows[(0, 0)] = 1.0 / l11;
    rows[(1, 0)] = -l21 / (l11 * l22);
    rows[(1, 1)] = 1.0 / l22;
    observed[0] = h2 / l11;
    observed[1] = (h3 - l21 * h2 / l11) / l22;
    for (k, dh) in krumm["dh"].as_array().unwrap().iter().enumerate() {
        let u = text(&dh["var_m2"]).sqrt();
        rows[(k + 2, column(dh["to"].as_str().unwrap()))] = 1.0 / u;
        rows[(k + 2, column(dh["from"].as_str().unwrap()))] = -1.0 / u;
        observed[k + 2] = text(&dh["dh"]) / u;
    }
    let system = System { rows, observed, u: vec![1.0; 7], group: vec![Group::Estimated(0); 7] };
    let found = adjust(&system, &Settings::default()).unwrap();
    let heights = numbers(&krumm["recomputed"]["H"]);
    let sd = numbers(&krumm["recomputed"]["sd_mm"]);
    for j in 0..5 {
        assert!((found.unknowns.solution[j] - heights[j]).abs() < 1e-9);
        assert!((1000.0 * found.unknowns.standard_uncertainty[j].unwrap() - sd[j]).abs() < 1e-6);
    }
}

/// REML scales and what Kenward and Roger add for them, against whole matrices in numpy (tests/scripts/scale_uncertainty.py).
#[test]
fn scales_of_three_instruments_and_what_it_costs_to_estimate_them() {
    let all = json("systems/scale_uncertainty.json");
    let (x, y, u) = (numbers(&all["x"]), numbers(&all["y"]), numbers(&all["u"]));
    let group: Vec<Group> = numbers(&all["group"])
        .iter()
        .map(|g| if *g == 3.0 { Group::Known } else { Group::Estimated(*g as usize) })
        .collect();
    let rows = Mat::from_fn(x.len(), 2, |i, j| if j == 0 { 1.0 } else { x[i] });
    let system = System { rows, observed: y, u, group };
    let found = adjust(&system, &Settings::default()).unwrap();
    let cost = found.scale_uncertainty(&system).unwrap();
    let near = |own: f64, other: f64, what: &str| {
        // the scales are iterated to 1e-11
        assert!((own - other).abs() <= 1e-9 * other.abs().max(1e-6), "{what}: {own} {other}");
    };
    for (own, other) in found.unknowns.solution.iter().zip(numbers(&all["solution"])) {
        near(*own, other, "solution");
    }
    for (own, other) in found.group_scale.iter().zip(numbers(&all["scale"])) {
        near(own.unwrap(), other, "scale");
    }
    let tables = [
        (&found.unknowns.covariance, "covariance"),
        (&cost.relative, "relative_spread"),
        (&cost.correction, "correction"),
    ];
    for (own, key) in tables {
        for (i, row) in all[key].as_array().unwrap().iter().enumerate() {
            for (j, other) in numbers(row).into_iter().enumerate() {
                near(own[(i, j)], other, key);
            }
        }
    }
    // the same by the engine of scatter
    let whitened = adjust_scattered(&system, &[], None, &[], &Settings::default()).unwrap();
    for g in 0..3 {
        near(whitened.group_variance[g].unwrap().sqrt(), found.group_scale[g].unwrap(), "whitened scale");
    }
    near(whitened.correction[(1, 1)], cost.correction[(1, 1)], "whitened correction");
}
