//! What must hold for any system: redundancy sums, invariance to order and units, scale removal, folding.

use faer::Mat;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use tumble::estimate::{Estimate, Fold, Group, Settings, System, adjust};

/// A random system, at times with dependent or zero columns, with `u` between 0.1 and 10.
fn systems() -> impl Strategy<Value = System> {
    (1_usize..14, 0_usize..6).prop_flat_map(|(m, n)| {
        let element = prop_oneof![8 => -10.0..10.0_f64, 1 => Just(0.0), 1 => Just(1.0)];
        let elements = proptest::collection::vec(element, m * n);
        let observed = proptest::collection::vec(-10.0..10.0_f64, m);
        let u = proptest::collection::vec(0.1..10.0_f64, m);
        (elements, observed, u, 0_u8..4).prop_map(move |(elements, observed, u, kind)| {
            let mut rows = Mat::from_fn(m, n, |i, j| elements[i * n + j]);
            if kind == 0 && n > 1 {
                for i in 0..m {
                    rows[(i, n - 1)] = 3.0 * rows[(i, 0)];
                }
            }
            System { rows, observed, u, group: vec![Group::Estimated(0); m] }
        })
    })
}

fn fit(system: &System) -> Estimate {
    adjust(system, &Settings::default()).expect("a well-posed system")
}

/// Equal to 1e-9 of the larger, or of `size`; looser than rounding by the condition numbers that are let through.
fn near(a: f64, b: f64, size: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs()).max(size)
}

fn benign(estimate: &Estimate) -> bool {
    estimate.unknowns.condition().is_none_or(|condition| condition < 1e4)
}

fn all_near(a: &[f64], b: &[f64]) -> bool {
    let size = a.iter().chain(b).fold(1e-3_f64, |most, x| most.max(x.abs()));
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| near(*a, *b, size))
}

proptest! {
    // seeded, so that every run draws the same cases
    #![proptest_config(ProptestConfig {
        cases: 400,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(20_261_121),
        ..ProptestConfig::default()
    })]

    #[test]
    fn redundancy_numbers_sum_to_the_degrees_of_freedom(system in systems()) {
        let estimate = fit(&system);
        prop_assert!((estimate.redundancy.iter().sum::<f64>() - estimate.dof as f64).abs() < 1e-10);
        prop_assert!(estimate.leverage.iter().all(|h| (0.0..=1.0).contains(h)));
        prop_assert_eq!(estimate.dof + estimate.unknowns.rank, system.observed.len());
        prop_assert_eq!(estimate.unknowns.not_estimable.len() + estimate.unknowns.rank, system.rows.ncols());
    }

    #[test]
    fn residuals_are_orthogonal_to_the_columns(system in systems()) {
        let estimate = fit(&system);
        for j in 0..system.rows.ncols() {
            let terms = (0..system.u.len()).map(|i| system.rows[(i, j)] * estimate.residuals[i] / system.u[i].powi(2));
            let (sum, size) = terms.fold((0.0, 0.0), |(sum, size): (f64, f64), t| (sum + t, size + t.abs()));
            prop_assert!(sum.abs() <= 1e-11 * size.max(1.0), "{} of {}", sum, size);
        }
        for i in 0..system.u.len() {
            let fitted: f64 = (0..system.rows.ncols()).map(|j| system.rows[(i, j)] * estimate.unknowns.solution[j]).sum();
            prop_assert!(near(fitted + estimate.residuals[i], system.observed[i], 10.0));
        }
    }

    #[test]
    fn the_order_of_rows_does_not_matter(system in systems(), shift in 0_usize..14) {
        let m = system.u.len();
        let from = |i: usize| (m - 1) - (i + shift) % m;
        let other = System {
            rows: Mat::from_fn(m, system.rows.ncols(), |i, j| system.rows[(from(i), j)]),
            observed: (0..m).map(|i| system.observed[from(i)]).collect(),
            u: (0..m).map(|i| system.u[from(i)]).collect(),
            group: system.group.clone(),
        };
        let (a, b) = (fit(&system), fit(&other));
        prop_assume!(benign(&a));
        prop_assert_eq!(&a.unknowns.estimable, &b.unknowns.estimable);
        // what is not estimable has no value of its own: which basic solution comes out is a matter of rounding
        let estimable = |estimate: &Estimate| -> Vec<f64> {
            estimate.unknowns.solution.iter().zip(&estimate.unknowns.estimable).map(|(x, own)| if *own { *x } else { 0.0 }).collect()
        };
        prop_assert!(all_near(&estimable(&a), &estimable(&b)));
        prop_assert!((0..m).all(|i| near(a.residuals[from(i)], b.residuals[i], 10.0)));
    }

    #[test]
    fn units_do_not_matter(system in systems(), row_unit in 1e-6..1e6_f64, column_unit in 1e-6..1e6_f64) {
        let (m, n) = system.rows.shape();
        // Readings in another unit, and the first unknown in another unit.
        let mut other = system.clone();
        for i in 0..m {
            other.observed[i] *= row_unit;
            for j in 0..n {
                other.rows[(i, j)] *= row_unit * if j == 0 { column_unit } else { 1.0 };
            }
        }
        let (a, b) = (fit(&system), fit(&other));
        prop_assume!(benign(&a));
        prop_assert_eq!(&a.unknowns.estimable, &b.unknowns.estimable);
        prop_assert_eq!(a.unknowns.rank, b.unknowns.rank);
        let back: Vec<f64> = b.unknowns.solution.iter().enumerate().map(|(j, x)| if j == 0 { x * column_unit } else { *x }).collect();
        prop_assert!(all_near(&a.unknowns.solution, &back), "{:?} {:?}", a.unknowns.solution, back);
        prop_assert!(all_near(&a.leverage, &b.leverage));
        if let (Some(a), Some(b)) = (a.unknowns.condition(), b.unknowns.condition()) {
            prop_assert!((a / b - 1.0).abs() < 1e-6);
        }
        if let (Some(Some(a)), Some(Some(b))) = (a.unknowns.standard_uncertainty.last(), b.unknowns.standard_uncertainty.last()) {
            let b = if n == 1 { b * column_unit } else { *b };
            prop_assert!(near(*a, b, 1e-3));
        }
    }

    #[test]
    fn the_scale_of_a_lone_group_drops_out(system in systems(), scale in 1e-4..1e4_f64) {
        let mut other = system.clone();
        other.u.iter_mut().for_each(|u| *u *= scale);
        let (a, b) = (fit(&system), fit(&other));
        prop_assume!(benign(&a));
        prop_assert!(all_near(&a.unknowns.solution, &b.unknowns.solution));
        for j in 0..a.unknowns.solution.len() {
            match (a.unknowns.standard_uncertainty[j], b.unknowns.standard_uncertainty[j]) {
                (Some(a), Some(b)) => prop_assert!(near(a, b, 1e-6)),
                (a, b) => prop_assert_eq!(a, b),
            }
        }
    }

    #[test]
    fn folding_equals_adjusting(system in systems(), block in 1_usize..6) {
        let estimate = fit(&system);
        prop_assume!(benign(&estimate));
        let (m, n) = system.rows.shape();
        let mut fold = Fold::new(n);
        for start in (0..m).step_by(block) {
            let end = (start + block).min(m);
            fold.push(system.rows.get(start..end, ..), &system.observed[start..end], &system.u[start..end]).expect("a block");
        }
        let folded = fold.finish(Group::Estimated(0), &Settings::default()).expect("an estimate");
        prop_assert_eq!((folded.unknowns.rank, folded.dof), (estimate.unknowns.rank, estimate.dof));
        prop_assert!(all_near(&folded.unknowns.solution, &estimate.unknowns.solution));
        prop_assert!(near(folded.sum_of_squares, estimate.sum_of_squares, 1.0));
        prop_assert_eq!(&folded.unknowns.estimable, &estimate.unknowns.estimable);
    }

    /// Whatever is said to be free does not change a fitted value, and estimable combinations are blind to it; what is called not
    /// estimable is not.
    #[test]
    fn combinations_are_what_they_say(system in systems()) {
        let estimate = fit(&system);
        prop_assume!(benign(&estimate));
        let scale = estimate.factor.scale();
        prop_assert_eq!(estimate.unknowns.free_directions.len(), estimate.unknowns.not_estimable.len());
        prop_assert_eq!(estimate.unknowns.free_directions.len(), system.rows.ncols() - estimate.unknowns.rank);
        for (free, named) in estimate.unknowns.free_directions.iter().zip(&estimate.unknowns.not_estimable) {
            let step = |j: usize| free.terms.iter().find(|(own, _)| *own == j).map_or(0.0, |(_, e)| *e);
            let largest = free.terms.iter().map(|&(j, e)| (e * scale[j]).abs()).fold(0.0, f64::max);
            for i in 0..system.u.len() {
                let moved: f64 = free.terms.iter().map(|&(j, e)| system.rows[(i, j)] * e).sum();
                prop_assert!(moved.abs() <= 1e-9 * largest.max(1e-3), "{}", moved);
            }
            for fixed in &estimate.unknowns.estimable_combinations {
                let size: f64 = fixed.terms.iter().map(|&(j, c)| (c * step(j)).abs()).sum();
                let blind: f64 = fixed.terms.iter().map(|&(j, c)| c * step(j)).sum();
                prop_assert!(blind.abs() <= 1e-7 * size.max(1e-3), "{}", blind);
            }
            prop_assert!(named.terms.len() <= 2);
            let (size, along) = named.terms.iter().fold((0.0, 0.0), |(s, a), &(j, c)| (s + (c * step(j)).abs(), a + c * step(j)));
            prop_assert!(along.abs() > 0.99 * size && size > 0.0);
        }
    }

    /// Several groups: the iteration ends with numbers, or says that it has not settled.
    #[test]
    fn any_grouping_gives_numbers(system in systems(), groups in proptest::collection::vec(0_usize..4, 14)) {
        let mut system = system;
        for (group, g) in system.group.iter_mut().zip(groups) {
            *group = if g == 3 { Group::Known } else { Group::Estimated(g) };
        }
        system.group.iter_mut().for_each(|g| if let Group::Estimated(k) = g && *k >= system.u.len() { *g = Group::Known });
        let estimate = fit(&system);
        prop_assert!((estimate.redundancy.iter().sum::<f64>() - estimate.dof as f64).abs() < 1e-8);
        prop_assert!(estimate.group_scale.iter().flatten().all(|s| s.is_finite() && *s >= 0.0));
    }
}
