//! What scatters: whitening, REML and Kenward-Roger against whole matrices in numpy, exact fractions and published variance components.

use crate::support::{json, number, numbers};
use faer::Mat;
use serde_json::Value;
use tumble::estimate::{
    Felt, Group, LineState, Memory, Pattern, ScatterLine, Settings, System, Whitening, adjust, adjust_scattered,
};

#[track_caller]
fn near(own: f64, other: f64, relative: f64, what: &str) {
    assert!((own - other).abs() <= relative * other.abs().max(1e-9), "{what}: {own:e} is not {other:e}");
}

fn matrix(value: &Value) -> Mat<f64> {
    let rows: Vec<Vec<f64>> = value.as_array().unwrap().iter().map(numbers).collect();
    Mat::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

fn line(value: &Value, variance: Option<f64>) -> ScatterLine {
    let level = numbers(&value["level"]);
    let by = numbers(&value["by"]);
    let felt = level.iter().zip(&by).enumerate();
    let felt = felt.map(|(row, (level, by))| Felt { row, level: *level as usize, by: *by }).collect();
    let memory = value.get("tau").map(|tau| Memory {
        time: numbers(&value["time"]),
        run: numbers(&value["run"]).iter().map(|r| *r as usize).collect(),
        tau: tau.as_f64(),
    });
    ScatterLine { felt, variance, memory }
}

/// Nested, crossed and chained lines, small and large blocks: solution, covariance, chi-square and determinant to 1e-9.
#[test]
fn stated_scatter_is_dense_generalised_least_squares() {
    for case in json("scatter/dense.json")["cases"].as_array().unwrap() {
        let name = case["name"].as_str().unwrap();
        let u = numbers(&case["u"]);
        let m = u.len();
        let system =
            System { rows: matrix(&case["a"]), observed: numbers(&case["y"]), u, group: vec![Group::Known; m] };
        let lines: Vec<ScatterLine> =
            case["lines"].as_array().unwrap().iter().map(|l| line(l, l["variance"].as_f64())).collect();
        let found = adjust_scattered(&system, &lines, None, &[], &Settings::default()).unwrap();
        for (own, other) in found.estimate.unknowns.solution.iter().zip(numbers(&case["solution"])) {
            near(*own, other, 1e-9, name);
        }
        let covariance = matrix(&case["covariance"]);
        let shared: Mat<f64> =
            found.shares.iter().fold(Mat::zeros(covariance.nrows(), covariance.nrows()), |a, b| a + b);
        for i in 0..covariance.nrows() {
            for j in 0..covariance.nrows() {
                near(found.estimate.unknowns.covariance[(i, j)], covariance[(i, j)], 1e-9, name);
                // the parts of the readings and of the lines make up the whole
                let rows: f64 = (0..m)
                    .map(|k| found.sensitivities[(i, k)] * found.sensitivities[(j, k)] * system.u[k] * system.u[k])
                    .sum();
                near(rows + shared[(i, j)], covariance[(i, j)], 1e-9, name);
            }
        }
        near(found.estimate.sum_of_squares, case["chi_square"].as_f64().unwrap(), 1e-9, name);
        near(found.whitening.log_determinant(), case["log_determinant"].as_f64().unwrap(), 1e-9, name);
        // what tests one wrong reading
        let expected = numbers(&case["studentized"]).into_iter().zip(numbers(&case["redundancy"]));
        for ((own, standardized), (studentized, redundancy)) in
            found.redundancy.iter().zip(&found.standardized).zip(expected)
        {
            near(*own, redundancy, 1e-9, name);
            let own = standardized / own.sqrt();
            assert!((own - studentized).abs() < 1e-9 * studentized.abs().max(1.0), "{name}");
        }
        // sensitivities are those of the estimate
        let moved: f64 = (0..m).map(|k| found.sensitivities[(0, k)] * system.observed[k]).sum();
        near(moved, found.estimate.unknowns.solution[0], 1e-9, name);
        // redundancies of rows and deviations sum to the degrees of freedom
        let carried = found.whitening.carry_back(&found.whitening.whiten(&system.observed));
        let square: f64 = carried.iter().zip(&system.observed).map(|(a, b)| a * b).sum();
        let white: f64 = found.whitening.whiten(&system.observed).iter().map(|v| v * v).sum();
        near(square, white, 1e-9, name);
    }
}

/// A deviation that one row alone feels is noise of that row: the tests of single readings are those of independent rows with the root of the sum of squares, also
/// where the rest of the noise is too small to be seen beside it.
#[test]
fn a_deviation_of_each_row_is_its_noise() {
    let observed = vec![0.3, 1.4, 1.7, 3.2, 4.4, 4.6, 6.5, 6.9];
    let m = observed.len();
    for own in [1e-9, 1.0, 3.0] {
        let felt = (0..m).map(|row| Felt { row, level: row, by: if row % 2 == 0 { 2.0 } else { -2.0 } }).collect();
        let line = ScatterLine { felt, variance: Some(0.25), memory: None };
        let rows = Mat::from_fn(m, 2, |i, j| (i as f64).powi(j as i32));
        let system = |u: f64| System {
            rows: rows.clone(),
            observed: observed.clone(),
            u: vec![u; m],
            group: vec![Group::Known; m],
        };
        let settings = Settings::default();
        let found = adjust_scattered(&system(own), &[line], None, &[], &settings).unwrap();
        let u = own.hypot(1.0);
        let expected = adjust(&system(u), &settings).unwrap();
        // rounding of projections, and of 1e-18 beside 1
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        for (row, (place, sd)) in found.alone.iter().enumerate() {
            let (ours, plain) = (found.redundancy[*place].sqrt(), expected.redundancy[row].sqrt());
            near(found.standardized[*place] * sd.signum() / ours, expected.residuals[row] / u / plain);
            near(sd.abs() / ours, u / plain);
        }
    }
}

/// Two groups of readings and two lines, unbalanced: variances, their spread, Kenward and Roger's covariance.
#[test]
fn estimated_scatter_is_restricted_likelihood() {
    let all = &json("scatter/dense.json")["estimated"];
    let group = numbers(&all["group"]);
    let m = group.len();
    let system = System {
        rows: matrix(&all["a"]),
        observed: numbers(&all["y"]),
        u: vec![1.0; m],
        group: group.iter().map(|g| Group::Estimated(*g as usize)).collect(),
    };
    let felt = |level: &[f64], by: &[f64]| -> Vec<Felt> {
        let pairs = level.iter().zip(by).enumerate();
        pairs.map(|(row, (level, by))| Felt { row, level: *level as usize, by: *by }).collect()
    };
    let ones = vec![1.0; m];
    let lines = [
        ScatterLine { felt: felt(&numbers(&all["level"]), &numbers(&all["by"])), variance: None, memory: None },
        ScatterLine { felt: felt(&numbers(&all["other"]), &ones), variance: None, memory: None },
    ];
    let found = adjust_scattered(&system, &lines, None, &[], &Settings::default()).unwrap();
    assert!(found.converged, "{}", found.iterations);
    let theta = numbers(&all["theta"]);
    let own =
        [found.group_variance[0].unwrap(), found.group_variance[1].unwrap(), found.variance[0], found.variance[1]];
    for (own, other) in own.iter().zip(&theta) {
        near(*own, *other, 1e-9, "variance");
    }
    let (spread, correction, covariance) =
        (matrix(&all["spread"]), matrix(&all["correction"]), matrix(&all["covariance"]));
    for g in 0..4 {
        for h in 0..4 {
            near(found.spread[(g, h)] * theta[g] * theta[h], spread[(g, h)], 1e-8, "spread");
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            near(found.estimate.unknowns.covariance[(i, j)], covariance[(i, j)], 1e-9, "covariance");
            near(found.correction[(i, j)], correction[(i, j)], 1e-8, "correction");
        }
    }
}

/// Offsets of five positions from as large as the noise to 1e12 times it, in exact fractions.
#[test]
fn offsets_of_any_size_keep_their_digits() {
    for case in json("scatter/dense.json")["exact"].as_array().unwrap() {
        let (x, y) = (numbers(&case["x"]), numbers(&case["y"]));
        let sd: f64 = case["sd"].as_str().unwrap().parse().unwrap();
        let system = System {
            rows: Mat::from_fn(15, 2, |i, j| if j == 0 { 1.0 } else { x[i] }),
            observed: y,
            u: vec![1.0; 15],
            group: vec![Group::Known; 15],
        };
        let felt = (0..15).map(|row| Felt { row, level: row / 3, by: 1.0 }).collect();
        let lines = [ScatterLine { felt, variance: Some(sd * sd), memory: None }];
        let found = adjust_scattered(&system, &lines, None, &[], &Settings::default()).unwrap();
        let name = case["sd"].as_str().unwrap();
        near(found.estimate.unknowns.solution[1], number(&case["b1"]), 1e-12, name);
        // the offsets decide b0 alone: as a share of its uncertainty, which they make as large as they are
        let share = (found.estimate.unknowns.solution[0] - number(&case["b0"])).abs() / number(&case["u0"]);
        assert!(share < 1e-5, "{name}: b0 is off by {share:e} of its u");
        near(found.estimate.unknowns.covariance[(1, 1)].sqrt(), number(&case["u1"]), 1e-12, name);
        near(found.estimate.unknowns.covariance[(0, 0)].sqrt(), number(&case["u0"]), 1e-6, name);
        near(found.estimate.sum_of_squares, number(&case["chi_square"]), 1e-11, name);
        if sd > 1e6 {
            // the offsets are all there is to the uncertainty of b0, to the digits of (u/sd)^2
            near(found.shares[0][(0, 0)].sqrt(), number(&case["u0"]), 1e-6, name);
        }
    }
}

/// A whitening alone, without an adjustment: what a diagnosis or a plan needs.
#[test]
fn rows_without_deviations_are_divided_by_their_noise() {
    let lines = [ScatterLine { felt: vec![Felt { row: 1, level: 0, by: 2.0 }], variance: Some(4.0), memory: None }];
    let whitening = Whitening::new(&Pattern::new(3, &lines), &[2.0, 3.0, 0.5], &lines, &[4.0]);
    let white = whitening.whiten(&[4.0, 10.0, 1.0]);
    assert_eq!((white[0], white[2]), (2.0, 2.0));
    assert!((white[1].abs() - 10.0 / 25f64.sqrt()).abs() < 1e-14);
    let nothing = adjust_scattered(
        &System {
            rows: Mat::from_fn(3, 1, |_, _| 1.0),
            observed: vec![1.0, 2.0, 4.0],
            u: vec![1.0; 3],
            group: vec![Group::Estimated(0); 3],
        },
        &[ScatterLine { felt: Vec::new(), variance: None, memory: None }],
        None,
        &[],
        &Settings::default(),
    );
    assert_eq!(nothing.unwrap().state, [LineState::NotFelt]);
}

/// lme4's Dyestuff and crossed Penicillin, nlme's Rail: as published, and lme4's own digits (tests/scripts/variance_components.R).
#[test]
fn published_variance_components() {
    let published: [(&str, &[(&str, f64, f64)], f64, f64, f64, f64); 3] = [
        // name, (source, sd, half of the last printed digit), intercept, its half digit, standard error, its half digit
        ("Dyestuff", &[("Batch", 42.00, 5e-3), ("Residual", 49.51, 5e-3)], 1527.50, 5e-3, 19.38, 5e-3),
        ("Rail", &[("Rail", 24.80547, 5e-6), ("Residual", 4.020779, 5e-7)], 66.5, 5e-6, 10.17104, 5e-6),
        (
            "Penicillin",
            &[("plate", 0.8467, 5e-5), ("sample", 1.9316, 5e-5), ("Residual", 0.5499, 5e-5)],
            22.9722,
            5e-5,
            0.8086,
            5e-5,
        ),
    ];
    let cases = json("scatter/lme4.json");
    for (case, (name, parts, mean, mean_digit, se, se_digit)) in cases.as_array().unwrap().iter().zip(published) {
        assert_eq!(case["name"].as_str(), Some(name));
        let y = numbers(&case["y"]);
        let m = y.len();
        let system = System {
            rows: Mat::from_fn(m, 1, |_, _| 1.0),
            observed: y,
            u: vec![1.0; m],
            group: vec![Group::Estimated(0); m],
        };
        let factor = |name: &str| {
            let level = numbers(&case["factors"][name]);
            let felt = level.iter().enumerate().map(|(row, l)| Felt { row, level: *l as usize, by: 1.0 }).collect();
            ScatterLine { felt, variance: None, memory: None }
        };
        let names: Vec<&str> = parts.iter().map(|(name, ..)| *name).filter(|name| *name != "Residual").collect();
        let lines: Vec<ScatterLine> = names.iter().map(|name| factor(name)).collect();
        let found = adjust_scattered(&system, &lines, None, &[], &Settings::default()).unwrap();
        assert!(found.converged);
        for (source, sd, digit) in parts {
            let own = match names.iter().position(|n| n == source) {
                Some(k) => found.variance[k].sqrt(),
                None => found.group_variance[0].unwrap().sqrt(),
            };
            assert!((own - sd).abs() <= *digit, "{name} {source}: {own} {sd}");
            // lme4 stops at about 1e-7 of the likelihood's width
            near(own, case["sd"][*source].as_f64().unwrap(), 1e-5, name);
        }
        assert!((found.estimate.unknowns.solution[0] - mean).abs() <= mean_digit, "{name}");
        let own = found.estimate.unknowns.covariance[(0, 0)].sqrt();
        assert!((own - se).abs() <= se_digit, "{name}: {own} {se}");
    }
}

/// GUM H.5: a voltage standard on ten days, five observations each; table H.9 prints means and standard deviations of the days.
#[test]
fn gum_h5_days_of_a_zener_standard() {
    let mean = [172.0, 116.0, 13.0, 144.0, 106.0, 31.0, 60.0, 125.0, 163.0, 41.0];
    let sd = [60.0, 77.0, 111.0, 101.0, 67.0, 93.0, 80.0, 73.0, 88.0, 86.0];
    // five values of mean zero and unit standard deviation, from any pattern
    let pattern = [-1.5_f64, -0.25, 0.0, 0.5, 1.25];
    let size = (pattern.iter().map(|p| p * p).sum::<f64>() / 4.0).sqrt();
    let observed: Vec<f64> = (0..50).map(|i| mean[i / 5] + sd[i / 5] * pattern[i % 5] / size).collect();
    let system = System {
        rows: Mat::from_fn(50, 1, |_, _| 1.0),
        observed,
        u: vec![1.0; 50],
        group: vec![Group::Estimated(0); 50],
    };
    let felt = (0..50).map(|row| Felt { row, level: row / 5, by: 1.0 }).collect();
    let lines = [ScatterLine { felt, variance: None, memory: None }];
    let found = adjust_scattered(&system, &lines, None, &[], &Settings::default()).unwrap();
    // H.5.2: mean 10.000097 V, s_b = 85 uV within days, s_B = 43 uV between days, u = 18 uV
    assert!((found.estimate.unknowns.solution[0] - 97.0).abs() <= 0.5);
    assert!((found.group_variance[0].unwrap().sqrt() - 85.0).abs() <= 0.5);
    assert!((found.variance[0].sqrt() - 43.0).abs() <= 0.5);
    assert!((found.estimate.unknowns.covariance[(0, 0)].sqrt() - 18.0).abs() <= 0.5);
}

/// Numbers between -1 and 1 without a pattern.
fn wiggles(count: usize) -> Vec<f64> {
    let mut state = 12345_u64;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

/// Fifty readings at each of 24 positions: the variances of many readings are sought on few rows, and are those of the analysis of variance.
#[test]
fn many_readings_balanced_are_the_analysis_of_variance() {
    let (positions, each) = (24, 50);
    let m = positions * each;
    let (noise, offset) = (wiggles(m), wiggles(m + positions));
    // another order than position by position
    let of = |row: usize| row % positions;
    let observed: Vec<f64> = (0..m).map(|row| 5.0 + noise[row] + 3.0 * offset[m + of(row)]).collect();
    let mean: f64 = observed.iter().sum::<f64>() / m as f64;
    let own = |p: usize| (0..m).filter(move |row| of(*row) == p);
    let means: Vec<f64> = (0..positions).map(|p| own(p).map(|row| observed[row]).sum::<f64>() / each as f64).collect();
    let within: f64 = (0..m).map(|row| (observed[row] - means[of(row)]).powi(2)).sum::<f64>() / (m - positions) as f64;
    let between = each as f64 * means.iter().map(|own| (own - mean).powi(2)).sum::<f64>() / (positions - 1) as f64;
    let system = System { rows: Mat::full(m, 1, 1.0), observed, u: vec![1.0; m], group: vec![Group::Estimated(0); m] };
    let felt = (0..m).map(|row| Felt { row, level: of(row), by: 1.0 }).collect();
    let lines = [ScatterLine { felt, variance: None, memory: None }];
    let found = adjust_scattered(&system, &lines, None, &[], &Settings::default()).unwrap();
    assert!(found.converged);
    near(found.group_variance[0].unwrap(), within, 1e-9, "within");
    near(found.variance[0], (between - within) / each as f64, 1e-9, "between");
    near(found.estimate.unknowns.solution[0], mean, 1e-12, "mean");
    let u = found.estimate.unknowns.covariance[(0, 0)].sqrt();
    near(u, (between / m as f64).sqrt(), 1e-9, "u");
    // 2 / spread are the degrees of freedom of the mean square within, alone in its component
    near(2.0 / found.spread[(0, 0)], (m - positions) as f64, 1e-9, "degrees of freedom");
}

/// A thousand readings of two sensors at positions of very different numbers within days, standard uncertainties from 1e-5 to 1, and a prior: the
/// variances that were sought on few rows are where the restricted likelihood of all rows, whose variances are stated in turn, has no slope.
#[test]
fn many_readings_unbalanced_are_at_the_top_of_the_likelihood() {
    let m = 1000;
    let noise = wiggles(2 * m + 40);
    let position = |row: usize| (row * row / 90_000).min(11);
    let x = |row: usize| (row % 17) as f64 / 17.0 + 0.1 * position(row) as f64;
    let group = |row: usize| if row + 1 == m { Group::Known } else { Group::Estimated(row % 2) };
    // some rows are hardly noisy; the last is a prior and feels nothing
    let u: Vec<f64> = (0..m).map(|row| if row % 250 == 3 { 1e-5 } else { 1.0 }).collect();
    let deviation = |row: usize| 2.0 * noise[m + position(row)] * x(row) + 1.5 * noise[m + 20 + position(row) / 3];
    let of_day = |row: usize| position(row) / 3;
    let observed: Vec<f64> = (0..m)
        .map(|row| match row + 1 == m {
            true => 0.3,
            false => 1.0 + x(row) + deviation(row) + noise[row] * u[row] * (1.0 + (row % 2) as f64),
        })
        .collect();
    let rows = Mat::from_fn(m, 3, |row, j| match (row + 1 == m, j) {
        (true, 1) => 1.0,
        (true, _) => 0.0,
        (false, j) => x(row).powi(j as i32),
    });
    let felt = |level: &dyn Fn(usize) -> usize, by: &dyn Fn(usize) -> f64| -> Vec<Felt> {
        (0..m - 1).map(|row| Felt { row, level: level(row), by: by(row) }).collect()
    };
    let line = |k: usize, variance: Option<f64>| match k {
        0 => ScatterLine { felt: felt(&position, &x), variance, memory: None },
        _ => ScatterLine { felt: felt(&of_day, &|_| 1.0), variance, memory: None },
    };
    let system = System { rows, observed, u, group: (0..m).map(group).collect() };
    let found = adjust_scattered(&system, &[line(0, None), line(1, None)], None, &[], &Settings::default()).unwrap();
    assert!(found.converged && found.state == [LineState::Estimated; 2], "{:?}", found.state);
    let theta: Vec<f64> =
        found.group_variance.iter().map(|v| v.unwrap()).chain(found.variance.iter().copied()).collect();
    let deviance = |theta: &[f64]| {
        let known = System {
            u: system
                .u
                .iter()
                .enumerate()
                .map(|(row, u)| if row + 1 == m { *u } else { u * theta[row % 2].sqrt() })
                .collect(),
            group: vec![Group::Known; m],
            ..system.clone()
        };
        let lines = [line(0, Some(theta[2])), line(1, Some(theta[3]))];
        adjust_scattered(&known, &lines, None, &[], &Settings::default()).unwrap().deviance
    };
    near(deviance(&theta), found.deviance, 1e-9, "deviance");
    for k in 0..theta.len() {
        let at = |factor: f64| {
            let mut moved = theta.clone();
            moved[k] *= factor;
            deviance(&moved)
        };
        let h: f64 = 1e-3;
        let (less, here, more) = (at((-h).exp()), at(1.0), at(h.exp()));
        let (slope, bend) = ((more - less) / (2.0 * h), (more - 2.0 * here + less) / (h * h));
        // a difference of numbers of 1e3 to rounding leaves 1e-9 of a slope, and the third order 1e-6 of the bend
        assert!(bend > 0.1 && (slope / bend).abs() < 1e-5, "{k}: slope {slope:e}, bend {bend:e}");
    }
}
