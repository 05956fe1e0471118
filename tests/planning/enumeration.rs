//! The search against full enumeration: plain rows by every criterion, mountings of the published bench, budgets. Every expectation is computed
//! here from definitions, by elimination and cofactors.

use crate::draws::draws;
use crate::plan_support::*;
use tumble::campaign::Campaign;
use tumble::plan::{self, Costs, Criterion, Noise, Offer, Request, Unit};

/// Inverse by cofactors, independent of the crate.
fn inverse(m: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = m.len();
    let whole = determinant(m.to_vec());
    let minor = |a: usize, b: usize| {
        let rows = (0..n).filter(|i| *i != a);
        determinant(rows.map(|i| (0..n).filter(|j| *j != b).map(|j| m[i][j]).collect()).collect())
    };
    let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    (0..n).map(|i| (0..n).map(|j| sign(i + j) * minor(j, i) / whole).collect()).collect()
}

/// The criterion of a choice of rows from its definition; infinite where it is singular. A has each unknown in units of its uncertainty from all rows.
fn by_definition(rows: &[Vec<Vec<f64>>], criterion: &Criterion, chosen: &[usize]) -> f64 {
    let m = information(rows, chosen);
    let whole = determinant(m.clone());
    if whole < 1e-9 {
        return f64::INFINITY;
    }
    let (n, c) = (m.len(), inverse(&m));
    let quadratic = |x: &[f64]| -> f64 { (0..n).map(|i| (0..n).map(|j| x[i] * c[i][j] * x[j]).sum::<f64>()).sum() };
    match criterion {
        Criterion::D => -whole.ln(),
        Criterion::A => {
            let all = inverse(&information(rows, &(0..rows.len()).collect::<Vec<_>>()));
            (0..n).map(|k| c[k][k] / all[k][k]).sum()
        }
        Criterion::C(_) => quadratic(&(0..n).map(|k| (k + 1) as f64).collect::<Vec<_>>()),
        Criterion::G => rows.iter().flatten().map(|x| quadratic(x)).fold(0.0, f64::max),
        _ => unreachable!("compared with numpy in optima.rs and linked.rs"),
    }
}

/// All multisets of `count` out of `of`, each at most `repeats` times.
fn multisets(of: usize, count: usize, repeats: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for _ in 0..count {
        all = all
            .iter()
            .flat_map(|s: &Vec<usize>| {
                (s.last().copied().unwrap_or(0)..of)
                    .filter(|j| s.iter().filter(|k| *k == j).count() < repeats)
                    .map(|j| s.iter().copied().chain([j]).collect())
                    .collect::<Vec<Vec<usize>>>()
            })
            .collect();
    }
    all
}

/// Rows without symmetry, so that the optimum is one design only.
fn uneven(count: usize, rows: usize, n: usize) -> Vec<Vec<Vec<f64>>> {
    let element = |j: usize, r: usize, c: usize| {
        let angle = (j * (r + 2)) as f64 * 0.7 + 0.3 * r as f64;
        (c as f64 * angle).cos() + 0.3 * (angle * 1.7 + c as f64).sin()
    };
    (0..count).map(|j| (0..rows).map(|r| (0..n).map(|c| element(j, r, c)).collect()).collect()).collect()
}

/// Every criterion, with and without a limit on repeats, portions of one row and of several: the exchange ends at the best of all designs.
#[test]
fn exchange_finds_what_full_enumeration_finds() {
    println!("{:>24} {:>9} {:>12} {:>12} {:>12} {:>12}", "case", "designs", "D", "A", "c", "G");
    for (count, rows, n, choose, repeats) in [
        (9, 1, 3, 4, 9),
        (9, 1, 3, 5, 1),
        (7, 2, 3, 3, 7),
        (8, 2, 4, 3, 1),
        (10, 1, 4, 6, 2),
        (6, 4, 3, 3, 6),
        (7, 3, 5, 4, 2),
    ] {
        let candidates = uneven(count, rows, n);
        let all = multisets(count, choose, repeats);
        let weighted: Vec<String> = (0..n).map(|k| format!("{}*p{k}", k + 1)).collect();
        let (campaign, offer) = plain(&candidates, &weighted.join(" + "));
        let mut line = format!("{choose:>2} of {count:>2} x {rows}, {n} unknowns {:>9}", all.len());
        for criterion in [Criterion::D, Criterion::A, Criterion::C("c".into()), Criterion::G] {
            let value = |s: &Vec<usize>| by_definition(&candidates, &criterion, s);
            let best = all.iter().map(value).fold(f64::INFINITY, f64::min);
            let request = Request {
                readings: choose * rows,
                unit: if rows == 1 { Unit::Reading } else { Unit::Mounting },
                most_repeats: repeats,
                criterion: criterion.clone(),
                starts: 60,
                ..Request::default()
            };
            let found = plan::improve(&campaign, &offer, &request).unwrap();
            let chosen: Vec<usize> = places(&found.schedule).into_iter().step_by(rows).collect();
            assert!(
                (value(&chosen) - best).abs() <= 1e-9 * best.abs().max(1.0),
                "{choose} of {count} x {rows}: {best}"
            );
            assert_eq!((found.search.enumerated, found.search.efficiency), (Some(all.len() as u64), Some(1.0)));
            line.push_str(&format!(" {best:>12.6}"));
        }
        println!("{line}");
    }
}

/// Efficiencies on the shipped bench, 30 readings in each case, and the reason of every shortfall: the bound is never loose by more than a few
/// 1e-5, and on 16 and 25 mountings all 15,504 and 118,755 choices of five are tried, so the search is not at fault either. What is left is
/// that five mountings cannot follow the best weights; pairs and single readings of the same rates can, but for G, where 30 of them end at
/// 0.97 (not enumerated: search or rounding).
#[test]
fn efficiencies_and_why_they_fall_short() {
    let campaign = published();
    let noise = Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let criteria = [Criterion::D, Criterion::A, Criterion::G, Criterion::C("dtheta_z2".into())];
    println!("30 readings as     step  criterion        efficiency  bound loose by  same by enumeration");
    for (unit, step) in [
        (Unit::Mounting, 36.0),
        (Unit::Mounting, 45.0),
        (Unit::Mounting, 72.0),
        (Unit::Mounting, 90.0),
        (Unit::Pair, 36.0),
        (Unit::Reading, 36.0),
    ] {
        for criterion in &criteria {
            let offer = offer(&campaign, noise.clone(), step);
            let starts = draws(40, 100);
            let request = Request { readings: 30, unit, criterion: criterion.clone(), starts, ..Request::default() };
            let best = plan::improve(&campaign, &offer, &request).unwrap();
            let (efficiency, gap) = (best.search.efficiency.unwrap(), best.search.bound_gap.unwrap());
            let enumerated = if unit == Unit::Mounting && step >= 72.0 {
                let found = enumerated(&campaign, &noise, step, criterion);
                let own = criterion_of(&campaign, &noise, step, criterion, &best.schedule);
                assert!((own / found - 1.0).abs() < 1e-7, "{criterion:?} at {step}: {own} against {found}");
                "yes"
            } else {
                "-"
            };
            println!(
                "{unit:>14?} {step:>6} deg  {:<15} {efficiency:>11.4} {gap:>15.1e}  {enumerated}",
                format!("{criterion:?}")
            );
            assert!(gap < 2e-4, "the bound is loose by {gap}");
            assert!(best.check.unwrap() < 1e-9, "fresh QR: {:?}", best.check);
            let promised = match (unit, criterion) {
                // the example that ships
                (Unit::Mounting, Criterion::C(_)) => 0.75,
                (Unit::Mounting, _) if step == 36.0 || step == 72.0 => 0.999,
                (Unit::Mounting, _) => 0.8,
                (_, Criterion::G) => 0.97,
                _ => 0.99,
            };
            assert!(efficiency >= promised, "{unit:?} {criterion:?}: {efficiency}");
        }
    }
}

/// Rows over their noise at the mountings of a sweep: one matrix for each mounting.
fn mounting_rows(campaign: &Campaign, noise: &Noise, step: f64) -> Vec<Vec<Vec<f64>>> {
    let candidates = campaign.with_readings(plan::sweep(campaign, step).unwrap());
    let model = tumble::design::Model::new(&candidates).unwrap();
    let design = tumble::design::assemble(&candidates, &model, &candidates.reference_point()).unwrap();
    let mut by_place: std::collections::BTreeMap<String, Vec<Vec<f64>>> = std::collections::BTreeMap::new();
    for (i, origin) in design.rows.iter().enumerate() {
        let key = format!("{:?}", &candidates.readings.rows[origin.reading].joints[1..]);
        let row = (0..campaign.unknowns()).map(|j| design.jacobian[(i, j)] / noise.sensors[0].sd).collect();
        by_place.entry(key).or_default().push(row);
    }
    by_place.into_values().collect()
}

/// The criterion by its definition, from rows.
fn of_rows(rows: &[&Vec<f64>], predicted: &[Vec<f64>], criterion: &Criterion) -> f64 {
    let n = 6;
    // in units of each unknown's own information, so that a pivot near zero is a combination that the choice leaves open
    let size: Vec<f64> = (0..n).map(|k| rows.iter().map(|x| x[k] * x[k]).sum::<f64>().sqrt()).collect();
    let mut l = [[0.0_f64; 6]; 6];
    for i in 0..n {
        for j in 0..=i {
            let m = rows.iter().map(|x| x[i] / size[i] * x[j] / size[j]).sum::<f64>();
            let left = m - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            l[i][j] = if i == j { left.max(0.0).sqrt() } else { left / l[j][j] };
        }
        if !(l[i][i] > 1e-5) {
            return f64::INFINITY;
        }
    }
    let log_det: f64 = (0..n).map(|k| 2.0 * (l[k][k] * size[k]).ln()).sum();
    if *criterion == Criterion::D {
        return (-log_det / n as f64).exp();
    }
    // y = L^-1 x, so that x' M^-1 x = y'y
    let spread = |x: &[f64]| {
        let mut y = [0.0; 6];
        for i in 0..n {
            y[i] = (x[i] / size[i] - (0..i).map(|k| l[i][k] * y[k]).sum::<f64>()) / l[i][i];
        }
        y.iter().map(|v| v * v).sum::<f64>()
    };
    let unit = |k: usize| (0..n).map(|j| f64::from(u8::from(j == k))).collect::<Vec<f64>>();
    match criterion {
        Criterion::A => (1..n).map(|k| spread(&unit(k))).sum(),
        Criterion::G => predicted.iter().map(|x| spread(x)).fold(0.0, f64::max),
        _ => spread(&unit(5)),
    }
}

fn criterion_of(campaign: &Campaign, noise: &Noise, step: f64, criterion: &Criterion, schedule: &Campaign) -> f64 {
    let model = tumble::design::Model::new(schedule).unwrap();
    let design = tumble::design::assemble(schedule, &model, &schedule.reference_point()).unwrap();
    let row = |i: usize| (0..6).map(|j| design.jacobian[(i, j)] / noise.sensors[0].sd).collect::<Vec<f64>>();
    let rows: Vec<Vec<f64>> = (0..design.rows.len()).map(row).collect();
    let predicted: Vec<Vec<f64>> = mounting_rows(campaign, noise, step).concat();
    of_rows(&rows.iter().collect::<Vec<_>>(), &predicted, criterion)
}

/// The best criterion over all choices of five mountings.
fn enumerated(campaign: &Campaign, noise: &Noise, step: f64, criterion: &Criterion) -> f64 {
    let places = mounting_rows(campaign, noise, step);
    let predicted = places.concat();
    let all = multisets(places.len(), 5, 5);
    assert!(all.len() == if step == 90.0 { 15_504 } else { 118_755 });
    let value = |s: &Vec<usize>| {
        let rows: Vec<&Vec<f64>> = s.iter().flat_map(|p| &places[*p]).collect();
        of_rows(&rows, &predicted, criterion)
    };
    all.iter().map(value).fold(f64::INFINITY, f64::min)
}

/// Within a budget the best of all schedules is found: every multiset of readings at four places with two states is priced and judged.
#[test]
fn budgets_buy_the_best_that_they_can() {
    // a line read at four places, each in two states of a switch; a place costs 5, a reading 1, a change of the switch 2
    let campaign = campaign(
        r#"{ "bench": { "id": "head", "units": { "force": "g" }, "chain": [ { "joint": "beta", "about": "x" }, { "joint": "turn", "about": "z" } ],
               "sensors": { "y": { "unit": "V", "axes": { "I": "y" }, "model": "a + b*sin(beta) + c*cos(beta) + d*turn_deg_s" } } },
             "estimate": { "a": {}, "b": {}, "c": {}, "d": {} },
             "readings": [ { "beta_deg": [0, 80, 170, 250], "turn_deg_s": [10, -10] } ] }"#,
    );
    let noise = Noise::new(&campaign, &[("y".into(), 0.1)], &[]).unwrap();
    let candidates = campaign.readings.clone();
    let costs = Costs { reading: 1.0, rate_change: 2.0, mounting: 5.0, index: 0.0 };
    let offer = Offer { kept: none(&campaign), candidates: candidates.clone(), noise: noise.clone(), costs };
    let model = tumble::design::Model::new(&campaign).unwrap();
    let design = tumble::design::assemble(&campaign, &model, &campaign.reference_point()).unwrap();
    let rows: Vec<Vec<f64>> = (0..8).map(|i| (0..4).map(|j| design.jacobian[(i, j)] / 0.1).collect()).collect();
    let place = |k: usize| candidates.rows[k].joints[0];
    // with 29 no schedule that determines all four has more than twelve readings
    for budget in [22.0, 26.0, 29.0] {
        for (criterion, weight) in
            [(Criterion::D, None), (Criterion::C("d".into()), Some(3)), (Criterion::C("b".into()), Some(1))]
        {
            let mut best = f64::INFINITY;
            for count in 4..=12 {
                for s in multisets(8, count, 12) {
                    let mut cost = 0.0;
                    for k in 0..8 {
                        if (0..k).any(|other| place(other) == place(k)) {
                            continue;
                        }
                        let own: Vec<usize> = s.iter().copied().filter(|j| place(*j) == place(k)).collect();
                        if !own.is_empty() {
                            let mixed = own.iter().any(|j| *j != own[0]);
                            cost += 5.0 + own.len() as f64 + if mixed { 2.0 } else { 0.0 };
                        }
                    }
                    if cost <= budget {
                        let m: Vec<Vec<f64>> = (0..4)
                            .map(|a| (0..4).map(|b| s.iter().map(|j| rows[*j][a] * rows[*j][b]).sum()).collect())
                            .collect();
                        let whole = determinant(m.clone());
                        let scale: f64 = (0..4).map(|k| m[k][k]).product();
                        if whole > 1e-9 * scale {
                            best = best.min(weight.map_or(-whole.ln(), |k| inverse(&m)[k][k]));
                        }
                    }
                }
            }
            let request =
                Request { budget: Some(budget), criterion: criterion.clone(), starts: 60, ..Request::default() };
            let found = plan::improve(&campaign, &offer, &request).unwrap();
            assert!(found.judgement.work.cost <= budget + 1e-9, "{} of {budget}", found.judgement.work.cost);
            let covariance = &found.judgement.covariance;
            let own = match weight {
                Some(k) => covariance[(k, k)],
                None => {
                    let c = (0..4).map(|i| (0..4).map(|j| covariance[(i, j)]).collect()).collect();
                    determinant(c).ln()
                }
            };
            println!(
                "budget {budget}, {criterion:?}: {own:.6e} by search, {best:.6e} by enumeration, {} readings",
                found.chosen
            );
            assert!((own - best).abs() <= 1e-7 * best.abs(), "{criterion:?} with {budget}: {own} against {best}");
        }
    }
    let poor = Request { budget: Some(11.0), ..Request::default() };
    let error = plan::improve(&campaign, &offer, &poor).unwrap_err().to_string();
    assert!(error.contains("budget"), "{error}");
}
