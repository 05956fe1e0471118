//! Adjustments with known answers: small rational systems, ISO/TS 28037, rank defects, variance components, bad input.

use faer::{Mat, mat};
use serde_json::Value;
use tumble::error::Fault;
use tumble::estimate::{Estimate, Fold, Group, Settings, System, adjust};

fn estimated(rows: Mat<f64>, observed: &[f64]) -> System {
    let m = rows.nrows();
    System { rows, observed: observed.to_vec(), u: vec![1.0; m], group: vec![Group::Estimated(0); m] }
}

fn fit(system: &System) -> Estimate {
    let estimate = adjust(system, &Settings::default()).expect("a well-posed system");
    assert_finite(&estimate);
    estimate
}

fn assert_finite(estimate: &Estimate) {
    let matrices = [&estimate.unknowns.cofactor, &estimate.unknowns.covariance].into_iter();
    let entries = matrices.flat_map(|matrix| (0..matrix.ncols()).flat_map(|j| matrix.col(j).iter()));
    let columns = [&estimate.unknowns.solution, &estimate.residuals, &estimate.leverage, &estimate.redundancy];
    let options = [&estimate.unknowns.standard_uncertainty, &estimate.group_scale];
    assert!(entries.chain(columns.into_iter().flatten()).all(|value| value.is_finite()));
    assert!(options.into_iter().flatten().flatten().all(|value| value.is_finite()));
    assert!(estimate.unknowns.condition().is_none_or(f64::is_finite) && estimate.sum_of_squares.is_finite());
    let terms =
        estimate.unknowns.not_estimable.iter().chain(&estimate.unknowns.estimable_combinations).flat_map(|c| &c.terms);
    assert!(terms.into_iter().all(|(_, c)| c.is_finite()));
}

#[track_caller]
fn assert_near(found: f64, exact: f64, tolerance: f64) {
    assert!((found - exact).abs() <= tolerance * exact.abs().max(1.0), "{found} is not {exact}");
}

fn numbers(value: &Value) -> Vec<f64> {
    let number = |value: &Value| value.as_f64().or_else(|| value.as_str()?.parse().ok()).expect("a number");
    value.as_array().expect("a list").iter().map(number).collect()
}

fn line(x: &[f64], y: &[f64], u: &[f64]) -> System {
    System {
        rows: Mat::from_fn(x.len(), 2, |i, j| if j == 0 { 1.0 } else { x[i] }),
        observed: y.to_vec(),
        u: u.to_vec(),
        group: vec![Group::Known; x.len()],
    }
}

/// A parabola through 0..=4 with observations 0, 1, 5, 8, 17: all of it by hand in rationals.
#[test]
fn a_parabola_in_rationals() {
    let rows = Mat::from_fn(5, 3, |i, j| (i as f64).powi(j as i32));
    let estimate = fit(&estimated(rows, &[0.0, 1.0, 5.0, 8.0, 17.0]));
    // By orthogonal polynomials: 31/5 + 41/10 (x - 2) + 15/14 ((x - 2)^2 - 2).
    for (found, exact) in estimate.unknowns.solution.iter().zip([1.0 / 7.0, -13.0 / 70.0, 15.0 / 14.0]) {
        assert_near(*found, exact, 4e-16);
    }
    for (found, exact) in estimate.leverage.iter().zip([31.0, 13.0, 17.0, 13.0, 31.0]) {
        // Leverages come from Q, which is not refined: the condition number, 20, times the rounding.
        assert_near(*found, exact / 35.0, 4e-15);
    }
    let squares = 92.0 / 35.0;
    assert_near(estimate.sum_of_squares, squares, 1e-15);
    assert_near(estimate.unknowns.covariance[(2, 2)], squares / 2.0 / 14.0, 1e-14);
    assert_near(estimate.group_scale[0].expect("a scale").powi(2), squares / 2.0, 1e-14);
    assert_eq!((estimate.unknowns.rank, estimate.dof, estimate.refinements), (3, 2, 1));
    assert!(estimate.unknowns.not_estimable.is_empty() && estimate.unknowns.estimable == [true; 3]);
}

/// ISO/TS 28037:2010, pages 13 and 14, recomputed in rational arithmetic.
#[test]
fn iso_ts_28037_weighted_lines() {
    let reference: Value = serde_json::from_str(include_str!("../data/reference/iso_ts_28037.json")).expect("JSON");
    let sets = reference["sets"].as_array().expect("sets");
    assert_eq!(sets.len(), 2);
    for set in sets {
        let exact = &set["exact_recomputed"];
        let exact_of = |key: &str| exact[key].as_f64().expect("a number");
        let estimate = fit(&line(&numbers(&set["x"]), &numbers(&set["y"]), &numbers(&set["u_y"])));
        assert_near(estimate.unknowns.solution[0], exact_of("a"), 1e-14);
        assert_near(estimate.unknowns.solution[1], exact_of("b"), 1e-14);
        assert_near(estimate.unknowns.standard_uncertainty[0].expect("u"), exact_of("u_a"), 1e-14);
        assert_near(estimate.unknowns.standard_uncertainty[1].expect("u"), exact_of("u_b"), 1e-14);
        assert_near(estimate.unknowns.covariance[(0, 1)], exact_of("cov_ab"), 1e-14);
        assert_near(estimate.sum_of_squares, exact_of("chi2"), 1e-14);
        for (found, exact) in estimate.redundancy.iter().zip(numbers(&exact["redundancy"])) {
            assert_near(*found, exact, 1e-14);
        }
        for (found, exact) in estimate.residuals.iter().zip(numbers(&exact["residuals"])) {
            assert_near(*found, exact, 1e-14);
        }
    }
}

/// The accelerometer on the plumb plane: `V0` and `-1.299 dtheta_y0` in every reading.
#[test]
fn what_cannot_be_separated_is_named() {
    let rows = Mat::from_fn(8, 3, |i, j| match j {
        0 => 1.0,
        1 => -1.299,
        _ => (i as f64 * 0.785).sin(),
    });
    let observed: Vec<f64> = (0..8).map(|i| 0.25 + 2.0 * rows[(i, 2)]).collect();
    let estimate = fit(&estimated(rows, &observed));
    assert_eq!((estimate.unknowns.rank, estimate.dof), (2, 6));
    assert_eq!(estimate.unknowns.estimable, [false, false, true]);
    let [free] = estimate.unknowns.not_estimable.as_slice() else {
        panic!("one defect, not {:?}", estimate.unknowns.not_estimable)
    };
    assert_terms(&free.terms, &[(0, 1.0), (1, 1.299)]);
    let [fixed] = estimate.unknowns.estimable_combinations.as_slice() else { panic!("one combination") };
    assert_terms(&fixed.terms, &[(0, 1.0), (1, -1.299)]);
    let unknowns = &estimate.unknowns;
    assert_near(fixed.terms.iter().map(|(j, c)| c * unknowns.solution[*j]).sum(), 0.25, 1e-14);
    assert_near(estimate.unknowns.solution[2], 2.0, 1e-14);
    assert_eq!(estimate.unknowns.solution[1], 0.0);
    assert_eq!(estimate.unknowns.standard_uncertainty[..2], [None, None]);
    assert!(estimate.unknowns.standard_uncertainty[2].is_some());
    let pairs = fixed.terms.iter().flat_map(|a| fixed.terms.iter().map(move |b| (a, b)));
    assert!(pairs.map(|((i, a), (j, b))| a * b * unknowns.cofactor[(*i, *j)]).sum::<f64>() > 0.1);
}

#[track_caller]
fn assert_terms(terms: &[(usize, f64)], exact: &[(usize, f64)]) {
    assert_eq!(terms.len(), exact.len(), "{terms:?}");
    for (&(j, c), &(exact_j, exact_c)) in terms.iter().zip(exact) {
        assert_eq!(j, exact_j);
        assert_near(c, exact_c, 1e-13);
    }
}

/// Copies of one column, exact and to 1e-9 and 1e-10: updated norms cannot order them, the rank must come out all the same.
#[test]
fn a_cluster_of_nearly_equal_columns() {
    let value =
        |seed: usize, i: usize, j: usize| ((seed * 31 + i * 7919 + j * 104_729) as f64 * 0.618_034).fract() - 0.5;
    for seed in 0..200 {
        let a = |i: usize| value(seed, i, 0);
        let shift = |i: usize, j: usize| match (j + seed) % 5 {
            0 | 3 => 0.0,
            1 => 1e-9 * value(seed, i, 1),
            2 => 1e-10 * value(seed, i, 2),
            _ => value(seed, i, 3),
        };
        let rows = Mat::from_fn(20, 5, |i, j| a(i) + shift(i, j));
        let estimate = fit(&estimated(rows, &(0..20).map(|i| value(seed, i, 9)).collect::<Vec<f64>>()));
        assert_eq!(estimate.unknowns.rank, 4, "seed {seed}");
        assert_eq!(estimate.unknowns.not_estimable.len(), 1);
        assert!((estimate.redundancy.iter().sum::<f64>() - 16.0).abs() < 1e-10);
    }
}

/// Two defects at once and a column of zeros; the later unknowns give way to the earlier.
#[test]
fn several_defects_and_a_column_of_zeros() {
    // Columns: a, b, a + b, 0, 2 a.
    let a = [1.0, 0.0, 2.0, -1.0, 3.0, 1.0];
    let b = [0.0, 1.0, 1.0, 4.0, -2.0, 1.0];
    let rows = Mat::from_fn(6, 5, |i, j| [a[i], b[i], a[i] + b[i], 0.0, 2.0 * a[i]][j]);
    let observed: Vec<f64> = (0..6).map(|i| 3.0 * a[i] - b[i]).collect();
    let estimate = fit(&estimated(rows, &observed));
    assert_eq!((estimate.unknowns.rank, estimate.dof), (2, 4));
    assert_eq!(estimate.unknowns.estimable, [false; 5]);
    assert_eq!(estimate.unknowns.solution[2..], [0.0; 3]);
    assert_near(estimate.unknowns.solution[0], 3.0, 1e-14);
    assert_near(estimate.unknowns.solution[1], -1.0, 1e-14);
    assert_eq!(estimate.unknowns.not_estimable.len(), 3);
    assert_terms(&estimate.unknowns.not_estimable[1].terms, &[(3, 1.0)]);
    let [first, second] = estimate.unknowns.estimable_combinations.as_slice() else { panic!("two combinations") };
    assert_terms(&first.terms, &[(0, 1.0), (2, 1.0), (4, 2.0)]);
    assert_terms(&second.terms, &[(1, 1.0), (2, 1.0)]);
}

#[test]
fn fewer_rows_than_unknowns() {
    let rows = mat![[1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 1.0, 1.0]];
    let estimate = fit(&estimated(rows, &[2.0, 3.0]));
    assert_eq!((estimate.unknowns.rank, estimate.dof), (2, 0));
    assert_eq!(estimate.unknowns.not_estimable.len(), 2);
    assert_eq!(estimate.group_scale, [None]);
    assert_eq!(estimate.residual_sd(), None);
    assert_eq!(estimate.unknowns.standard_uncertainty, [None; 4]);
    assert!(estimate.residuals.iter().all(|v| v.abs() < 1e-15));
}

#[test]
fn nothing_to_adjust() {
    for (m, n) in [(0, 0), (0, 3), (3, 0), (2, 2)] {
        let estimate = fit(&estimated(Mat::zeros(m, n), &vec![1.0; m]));
        assert_eq!((estimate.unknowns.rank, estimate.dof, estimate.unknowns.condition()), (0, m, None));
        assert_eq!(estimate.unknowns.estimable, vec![false; n]);
        assert_eq!(estimate.unknowns.not_estimable.len(), n);
        assert_eq!(estimate.residuals, vec![1.0; m]);
        assert_eq!(estimate.leverage, vec![0.0; m]);
    }
}

#[test]
fn a_perfect_fit_has_no_residuals_left() {
    let rows = Mat::from_fn(5, 2, |i, j| if j == 0 { 1.0 } else { i as f64 });
    let observed: Vec<f64> = (0..5).map(|i| 3.0 + 2.0 * i as f64).collect();
    let estimate = fit(&estimated(rows.clone(), &observed));
    assert_eq!(estimate.unknowns.solution, [3.0, 2.0]);
    assert!(estimate.residuals.iter().all(|v| v.abs() < 1e-28), "{:?}", estimate.residuals);
    assert!(estimate.unknowns.standard_uncertainty.iter().all(|u| u.is_some_and(|u| u < 1e-28)));
    // Exactly as many readings as unknowns: no scale, so no uncertainty, but the solution stands.
    let square = fit(&estimated(rows.get(..2, ..).to_owned(), &observed[..2]));
    assert_eq!((square.dof, square.residual_sd()), (0, None));
    assert_eq!(square.unknowns.solution, [3.0, 2.0]);
    assert_eq!(square.unknowns.standard_uncertainty, [None, None]);
    assert_eq!(square.redundancy.iter().sum::<f64>(), 0.0);
}

#[test]
fn priors_are_rows_of_known_uncertainty() {
    // Two readings of 10 and 12 with u = 1 and a prior 8 with u = 0.5: mean (10 + 12 + 4 * 8) / 6.
    let system = System {
        rows: mat![[1.0], [1.0], [1.0]],
        observed: vec![10.0, 12.0, 8.0],
        u: vec![1.0, 1.0, 0.5],
        group: vec![Group::Known; 3],
    };
    let estimate = fit(&system);
    assert_near(estimate.unknowns.solution[0], 9.0, 1e-15);
    assert_near(estimate.unknowns.standard_uncertainty[0].expect("u").powi(2), 1.0 / 6.0, 1e-15);
    assert!(estimate.group_scale.is_empty());
}

/// Koch 1999, 3.6.3: five observations in two groups; his two components after convergence.
#[test]
fn variance_components_of_koch() {
    let reference: Value =
        serde_json::from_str(include_str!("../data/variance_components_and_blunders.json")).expect("JSON");
    let koch = &reference["koch_vce"];
    let group = koch["group"].as_array().expect("groups").iter();
    let system = System {
        rows: Mat::from_fn(5, 1, |_, _| 1.0),
        observed: numbers(&koch["y"]),
        u: numbers(&koch["sigma2_prior"]).iter().map(|variance| variance.sqrt()).collect(),
        group: group.map(|g| Group::Estimated(g.as_u64().expect("a number") as usize)).collect(),
    };
    let estimate = fit(&system);
    assert!(estimate.group_converged && estimate.group_iterations < 30, "{}", estimate.group_iterations);
    // The reference stops after four iterations, at a relative change of 2e-3.
    let factors = numbers(&koch["recomputed"]["total_factors"]);
    for (scale, factor) in estimate.group_scale.iter().zip(&factors) {
        assert_near(scale.expect("a scale").powi(2), *factor, 1e-3);
    }
    assert_near(estimate.unknowns.solution[0], koch["recomputed"]["converged_mean"].as_f64().expect("a mean"), 1e-6);
    for g in 0..2 {
        let own = |i: &usize| system.group[*i] == Group::Estimated(g);
        let squares: f64 =
            (0..5).filter(own).map(|i| (estimate.residuals[i] * estimate.factor.weight()[i]).powi(2)).sum();
        assert_near(squares / estimate.group_redundancy[g], 1.0, 1e-9);
    }
}

/// Two sensors in different units that share one unknown: each finds its own scale.
#[test]
fn groups_in_different_units_find_their_scales() {
    let noise = |i: usize| ((i * 7919 + 13) % 101) as f64 / 50.5 - 1.0;
    let m = 60;
    let rows = Mat::from_fn(m, 3, |i, j| {
        let (first, angle) = (i < 30, i as f64 * 0.41);
        match j {
            0 => angle.sin() * if first { 1.0 } else { 1e-6 },
            1 => f64::from(u8::from(first)),
            _ => 1e-6 * f64::from(u8::from(!first)),
        }
    });
    let scale = |i: usize| if i < 30 { 2.0 } else { 0.5e-6 };
    let system = System {
        observed: (0..m).map(|i| 5.0 * rows[(i, 0)] + scale(i) * noise(i)).collect(),
        rows,
        u: vec![1.0; m],
        group: (0..m).map(|i| Group::Estimated(i / 30)).collect(),
    };
    let estimate = fit(&system);
    assert!(estimate.group_converged, "{} iterations", estimate.group_iterations);
    let ratio = estimate.group_scale[0].expect("s") / estimate.group_scale[1].expect("s");
    assert!((3e6..6e6).contains(&ratio), "{ratio}");
    // The unit of the second sensor changes its scale and nothing else.
    let mut other = system.clone();
    for i in 30..m {
        other.observed[i] *= 1e6;
        for j in 0..3 {
            other.rows[(i, j)] *= 1e6;
        }
    }
    let rescaled = fit(&other);
    for j in 0..3 {
        assert_near(rescaled.unknowns.solution[j], estimate.unknowns.solution[j], 1e-9);
        assert_near(rescaled.unknowns.covariance[(j, j)], estimate.unknowns.covariance[(j, j)], 1e-9);
    }
}

/// A group that one unknown swallows whole has no scale; only what depends on it goes without an uncertainty.
#[test]
fn a_group_without_redundancy() {
    let system = System {
        rows: mat![[1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0]],
        observed: vec![1.0, 2.0, 3.0, 7.0],
        u: vec![1.0; 4],
        group: vec![Group::Estimated(0), Group::Estimated(0), Group::Estimated(0), Group::Estimated(1)],
    };
    let estimate = fit(&system);
    assert_near(estimate.group_scale[0].expect("s"), 1.0, 1e-10);
    assert_eq!(estimate.group_scale[1], None);
    assert_near(estimate.unknowns.standard_uncertainty[0].expect("u"), (1.0_f64 / 3.0).sqrt(), 1e-10);
    assert_eq!(estimate.unknowns.standard_uncertainty[1], None);
}

#[test]
fn the_factor_serves_other_right_hand_sides() {
    let rows = Mat::from_fn(9, 3, |i, j| (i as f64 * 0.3).powi(j as i32));
    let mut system = estimated(rows, &[1.0, 4.0, 2.0, 8.0, 5.0, 7.0, 1.0, 0.0, 3.0]);
    system.u = (1..=9).map(|i| i as f64 / 5.0).collect();
    let estimate = fit(&system);
    let factor = &estimate.factor;
    let again = factor.solve(&system.observed).expect("nine values");
    let sensitivities = factor.sensitivities();
    for j in 0..3 {
        assert_near(again[j], estimate.unknowns.solution[j], 1e-13);
        let by_sensitivity: f64 = (0..9).map(|i| sensitivities[(j, i)] * system.observed[i]).sum();
        assert_near(by_sensitivity, estimate.unknowns.solution[j], 1e-12);
        let variance: f64 = (0..9).map(|i| (sensitivities[(j, i)] * system.u[i]).powi(2)).sum();
        assert_near(variance, estimate.unknowns.cofactor[(j, j)], 1e-12);
    }
    let rest = factor.project_out(&system.observed).expect("nine values");
    for (rest, (v, u)) in rest.iter().zip(estimate.residuals.iter().zip(&system.u)) {
        assert_near(*rest, v / u, 1e-13);
    }
    assert!(factor.solve(&[1.0]).is_err() && factor.project_out(&[]).is_err());
}

#[test]
fn weights_may_differ_by_many_orders() {
    // A prior so firm that it is nearly a constraint: x0 + x1 = 1 with u = 1e-9 beside readings with u = 1.
    let system = System {
        rows: mat![[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, -1.0]],
        observed: vec![0.3, 0.9, 1.0, -0.5],
        u: vec![1.0, 1.0, 1e-9, 1.0],
        group: vec![Group::Known; 4],
    };
    let estimate = fit(&system);
    // With the constraint x1 = 1 - x0: minimise (x0 - 0.3)^2 + (x0 - 0.1)^2 + (2 x0 - 1 + 0.5)^2.
    assert_near(estimate.unknowns.solution[0], 1.4 / 6.0, 1e-15);
    assert_near(estimate.unknowns.solution[0] + estimate.unknowns.solution[1], 1.0, 1e-15);
    let by_residuals: f64 = estimate.redundancy.iter().sum();
    assert_near(by_residuals, 2.0, 1e-14);
}

#[test]
fn folding_is_adjusting() {
    let m = 500;
    let rows = Mat::from_fn(m, 5, |i, j| (i as f64 * 0.013 * (j + 1) as f64).cos());
    let mut system = estimated(rows, &(0..m).map(|i| (i as f64 * 0.77).sin()).collect::<Vec<f64>>());
    system.u = (0..m).map(|i| 1.0 + (i % 3) as f64).collect();
    let estimate = fit(&system);
    let mut fold = Fold::new(5);
    for start in (0..m).step_by(37) {
        let end = (start + 37).min(m);
        let block = system.rows.get(start..end, ..);
        fold.push(block, &system.observed[start..end], &system.u[start..end]).expect("a block");
    }
    let folded = fold.finish(Group::Estimated(0), &Settings::default()).expect("an estimate");
    assert_eq!((folded.rows, folded.dof, folded.unknowns.rank), (m, estimate.dof, estimate.unknowns.rank));
    assert_near(folded.sum_of_squares, estimate.sum_of_squares, 1e-12);
    for j in 0..5 {
        assert_near(folded.unknowns.solution[j], estimate.unknowns.solution[j], 1e-12);
        assert_near(folded.unknowns.covariance[(j, j)], estimate.unknowns.covariance[(j, j)], 1e-12);
    }
    assert_near(folded.unknowns.condition().expect("columns"), estimate.unknowns.condition().expect("columns"), 1e-9);
}

#[test]
fn folding_knows_defects_and_refuses_bad_blocks() {
    let mut fold = Fold::new(2);
    assert!(fold.push(mat![[1.0]].as_ref(), &[1.0], &[1.0]).is_err());
    assert!(fold.push(mat![[1.0, f64::NAN]].as_ref(), &[1.0], &[1.0]).is_err());
    assert!(fold.push(mat![[1.0, 1.0]].as_ref(), &[], &[1.0]).is_err());
    fold.push(Mat::zeros(0, 2).as_ref(), &[], &[]).expect("nothing");
    let nothing = fold.finish(Group::Known, &Settings::default()).expect("no readings yet");
    assert_eq!((nothing.unknowns.rank, nothing.dof), (0, 0));
    for y in [1.0, 2.0, 3.0] {
        fold.push(mat![[2.0, -4.0]].as_ref(), &[y], &[0.5]).expect("a row");
    }
    let folded = fold.finish(Group::Known, &Settings::default()).expect("an estimate");
    assert_eq!((folded.unknowns.rank, folded.dof), (1, 2));
    assert_terms(&folded.unknowns.not_estimable[0].terms, &[(0, 1.0), (1, 2.0)]);
    assert_terms(&folded.unknowns.estimable_combinations[0].terms, &[(0, 1.0), (1, -2.0)]);
    assert_near(folded.unknowns.solution[0], 1.0, 1e-15);
}

#[test]
fn malformed_systems_are_refused_with_their_place() {
    let good = estimated(mat![[1.0, 2.0], [3.0, 5.0], [1.0, 0.0]], &[1.0, 2.0, 3.0]);
    let refused = |change: &dyn Fn(&mut System)| {
        let mut system = good.clone();
        change(&mut system);
        let error = adjust(&system, &Settings::default()).expect_err("malformed");
        assert_eq!(error.fault(), Fault::Value);
        error.place().path.clone()
    };
    assert_eq!(refused(&|s| s.rows[(2, 1)] = f64::NAN), "rows[2][1]");
    assert_eq!(refused(&|s| s.observed[1] = f64::INFINITY), "observed[1]");
    for u in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(refused(&move |s| s.u[0] = u), "u[0]");
    }
    assert_eq!(refused(&|s| s.u.truncate(1)), "u");
    assert_eq!(refused(&|s| s.observed.push(1.0)), "observed");
    assert_eq!(refused(&|s| s.group.clear()), "group");
    assert_eq!(refused(&|s| s.group[0] = Group::Estimated(usize::MAX)), "group[0]");
    assert_eq!(refused(&|s| s.u = vec![1e-320; 3]), "rows[..][0]");
}

/// Numbers near the ends of the range either give finite answers or are refused; they never give NaN.
#[test]
fn extreme_magnitudes() {
    for exponent in [-320, -300, -200, -160, -100, 0, 100, 150, 160, 200, 300, 307] {
        for observed_exponent in [-300, 0, 200, 307] {
            let (a, y) = (10.0_f64.powi(exponent), 10.0_f64.powi(observed_exponent));
            let rows = mat![[a, 1.0], [2.0 * a, 1.0], [-a, 1.0], [0.5 * a, 1.0]];
            let system = estimated(rows, &[y, 1.5 * y, -0.5 * y, 0.0]);
            if let Ok(estimate) = adjust(&system, &Settings::default()) {
                assert_finite(&estimate);
            }
        }
    }
}
