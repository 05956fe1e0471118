//! Samples as rows: the fit of a record that is streamed.
//!
//! Against dense generalised least squares and restricted maximum likelihood in numpy (`tests/scripts/streamed_dense.py`), against the fit of the same
//! readings at hand, and by coverage of its intervals.

use crate::draws::draws;
use crate::support::*;
use nalgebra::{DMatrix, DVector};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use std::path::Path;
use tumble::campaign::{Campaign, Readings};
use tumble::estimate::LineState;
use tumble::fit::streamed::{self, Held};
use tumble::fit::{Fit, Settings};
use tumble::wire;

fn fitted_rows(name: &str) -> Fit {
    fit_rows(&data(&format!("streamed/{name}.campaign.json"))).unwrap()
}

fn fit_rows(path: &Path) -> tumble::Result<Fit> {
    let text = std::fs::read_to_string(path).expect("a campaign");
    let source = wire::Source { name: path.display().to_string(), text };
    wire::fit_rows_beside(&source, path.parent().expect("a folder"), &Settings::default())
}

/// The readings of a campaign as a record.
fn stream(campaign: &Campaign, settings: &Settings) -> Fit {
    let mut rows = Held::new(campaign.readings.clone());
    let sample = streamed::sample(&mut rows).unwrap();
    let own = Campaign { readings: sample.readings.clone(), ..campaign.clone() };
    streamed::fit(own, &mut rows, &sample, settings).unwrap_or_else(|error| panic!("{error}"))
}

fn numbers(list: &serde_json::Value) -> Vec<f64> {
    list.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// Estimates in units of u, and covariances relative, as dense matrices say them.
#[test]
fn dense_least_squares() {
    let dense = json("streamed/dense.json");
    for name in ["stated", "rotating"] {
        let (own, fit) = (&dense[name], fitted_rows(name));
        let covariance: Vec<Vec<f64>> = own["covariance"].as_array().unwrap().iter().map(numbers).collect();
        for (j, x) in numbers(&own["x"]).iter().enumerate() {
            let u = covariance[j][j].sqrt();
            assert!((fit.point[j] - x).abs() < 1e-9 * u, "{name} {j}: {} {x}", fit.point[j]);
            assert!((fit.parameters[j].uncertainty.unwrap().u / u - 1.0).abs() < 1e-9, "{name} {j}");
            for (k, c) in covariance[j].iter().enumerate() {
                assert!((fit.covariance[(j, k)] - c).abs() < 1e-9 * u * covariance[k][k].sqrt(), "{name} {j} {k}");
            }
        }
        let chi_square = own["chi_square"].as_f64().unwrap();
        assert!((fit.global_test.unwrap().chi_square / chi_square - 1.0).abs() < 1e-9, "{name}");
    }
}

/// What is estimated of the noise, and what that costs. Digits are those of the minimum and of the difference quotients in numpy.
#[test]
fn dense_restricted_likelihood() {
    let (dense, fit) = (&json("streamed/dense.json")["estimated"], fitted_rows("estimated"));
    assert!(fit.settled);
    let number = |key: &str| dense[key].as_f64().unwrap();
    let near = |own: f64, key: &str, relative: f64| assert!((own / number(key) - 1.0).abs() < relative, "{key}: {own}");
    let line = fit.noise.sources.iter().find(|source| source.line == Some(0)).unwrap();
    let white = fit.noise.sources.iter().find(|source| source.name == "readings of V").unwrap();
    near(white.variance.sqrt(), "white", 1e-6);
    near(line.variance.sqrt(), "deviation", 1e-6);
    let (tau, u_tau) = line.tau.unwrap();
    near(tau, "tau", 1e-6);
    near(u_tau.unwrap(), "u_tau", 1e-3);
    for (j, ((x, u), dof)) in
        numbers(&dense["x"]).iter().zip(numbers(&dense["u"])).zip(numbers(&dense["dof"])).enumerate()
    {
        let own = fit.parameters[j].uncertainty.unwrap();
        assert!((fit.point[j] - x).abs() < 1e-5 * u, "{j}");
        assert!((own.u / u - 1.0).abs() < 2e-6, "{j}: {} {u}", own.u);
        assert!((own.dof / dof - 1.0).abs() < 2e-3, "{j}: {} {dof}", own.dof);
    }
}

/// The same numbers as from readings in memory, noise stated or estimated: estimates, u, degrees of freedom, every line of the budget.
fn same(held: &Fit, streamed: &Fit) {
    if held.campaign.bench.sensors.len() == 1 {
        let (a, b) = (held.residual_sd().unwrap(), streamed.residual_sd().unwrap());
        assert!((a / b - 1.0).abs() < 1e-7, "standard deviation of the residuals {a} {b}");
    }
    for (a, b) in held.parameters.iter().zip(&streamed.parameters) {
        let (u, v) = (a.uncertainty.unwrap(), b.uncertainty.unwrap());
        let apart = (a.value.unwrap() - b.value.unwrap()).abs() / u.u;
        assert!(apart < 1e-9, "{}: {apart} u, {} {}", a.id, u.u, v.u);
        assert!((u.u / v.u - 1.0).abs() < 1e-9, "{}: {} {}", a.id, u.u, v.u);
        assert!(u.dof == v.dof || (u.dof / v.dof - 1.0).abs() < 1e-7, "{}: {} {}", a.id, u.dof, v.dof);
        for line in &a.budget {
            // a source that does not act on the unknown has no line, or zero
            let own = b.budget.iter().find(|own| own.source == line.source);
            let part = own.map_or(0.0, |own| own.u);
            // u of the whole: a part may be small
            assert!((part - line.u).abs() < 1e-7 * u.u, "{}: {part} {}", line.source, line.u);
            assert!(own.is_none_or(|own| own.evaluation == line.evaluation), "{}", line.source);
        }
    }
}

#[test]
fn readings_at_hand_say_the_same() {
    for name in ["stated", "estimated"] {
        let campaign = |readings: &str| {
            let text = text(&format!("streamed/{name}.campaign.json"));
            let mut file: serde_json::Value = serde_json::from_str(&text).unwrap();
            file["readings"] = readings.into();
            let source = wire::Source { name: name.into(), text: file.to_string() };
            wire::read_campaign_beside(&source, &data("streamed")).unwrap()
        };
        let (held, streamed) = (fitted(&campaign(&format!("{name}.csv"))), fitted_rows(name));
        same(&held, &streamed);
        let chi_square = |fit: &Fit| fit.global_test.map(|test| test.chi_square);
        match (chi_square(&held), chi_square(&streamed)) {
            (Some(a), Some(b)) => assert!(name == "stated" && (a / b - 1.0).abs() < 1e-9),
            (a, b) => assert!(name == "estimated" && a.is_none() && b.is_none()),
        }
    }
}

/// Without a line of scatter: the ordinary fit, of several sensors whose noise is estimated, exactly.
#[test]
fn white_noise_is_the_ordinary_fit() {
    let campaign = campaign("streamed/plain.json");
    let (held, streamed) = (fitted(&campaign), stream(&campaign, &Settings::default()));
    same(&held, &streamed);
    let (a, b) = (held.estimate.group_scale[0].unwrap(), streamed.estimate.group_scale[0].unwrap());
    assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
}

/// `y = a + b x` in every row and `z = c + b x` in those of `every`, white noise of 0.1 and 0.05, and correlated noise of y where asked for.
fn two_sensors(
    (rows, unknown): (usize, &str),
    every: &dyn Fn(usize) -> bool,
    z_u: &str,
    scatter: &str,
    correlated: f64,
    seed: u64,
) -> Campaign {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let (keeps, mut deviation) = ((-0.1f64).exp(), 0.0);
    let readings: Vec<String> = (0..rows)
        .map(|k| {
            deviation = keeps * deviation + correlated * (1.0 - keeps * keeps).sqrt() * normal();
            let x = normal();
            let y = 1.0 + 2.0 * x + deviation + 0.1 * normal();
            let z = if every(k) { format!(", \"z\": {}{z_u}", 3.0 + 2.0 * x + 0.05 * normal()) } else { String::new() };
            format!("{{\"time_s\": {}, \"x\": {x}, \"y\": {y}{z}}}", 0.1 * k as f64)
        })
        .collect();
    parse(&format!(
        r#"{{ "bench": {{ "id": "two", "sensors": {{ "y": {{ "model": "a + b*x" }}, "z": {{ "model": "c + b*x" }} }} }},
            {unknown}, "scatter": [{scatter}], "readings": [{}] }}"#,
        readings.join(",")
    ))
}

const ALL_UNKNOWN: &str = r#""estimate": { "a": {}, "b": {}, "c": {} }"#;

/// Two sensors of different noise, one of them read rarely (and in no row of the sample), in few rows, or beside correlated noise of the other: the
/// numbers of readings in memory.
#[test]
fn a_second_sensor() {
    const OVER_Y: &str = r#"{ "of": "y", "over": "time_s", "tau": "estimate", "u": "estimate" }"#;
    let all = |_: usize| true;
    let rarely = |k: usize| k % 2000 == 1001;
    for (rows, every, z_u, scatter, correlated) in [
        (300, &all as &dyn Fn(usize) -> bool, "", "", 0.0),
        (300, &|k| k < 3, "", "", 0.0),
        (20_000, &rarely, "", "", 0.0),
        (20_000, &rarely, ", \"z_u\": 0.05", "", 0.0),
        (400, &all, "", OVER_Y, 0.3),
        (400, &|k| k % 3 == 0, ", \"z_u\": 0.05", OVER_Y, 0.3),
    ] {
        println!("{rows} rows{z_u} {scatter}");
        let campaign = two_sensors((rows, ALL_UNKNOWN), every, z_u, scatter, correlated, 11);
        same(&fitted(&campaign), &stream(&campaign, &Settings::default()));
        // a known input 0.4 of its u off, which the readings determine better than it is stated
        let known = r#""known": { "b": { "value": 2.12, "u": 0.3 } }, "estimate": { "a": {}, "c": {} }"#;
        let campaign = two_sensors((rows, known), every, z_u, scatter, correlated, 11);
        let (held, streamed) = (fitted(&campaign), stream(&campaign, &Settings::default()));
        same(&held, &streamed);
        let p = streamed.streamed.as_ref().unwrap().sensors.iter().filter_map(|own| own.lags_p);
        p.for_each(|p| assert!(p > 1e-4, "{p}"));
    }
}

/// Data without noise: its scale is that of the rounding of the numbers, as of readings in memory.
#[test]
fn exact_data_have_the_noise_of_their_rounding() {
    let readings: Vec<String> =
        (0..50).map(|k| format!("{{\"x\": {k}, \"y\": {}}}", 1.0 / 3.0 + 0.7 * f64::from(k))).collect();
    let campaign = parse(&format!(
        r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "model": "a + b*x" }} }} }},
            "estimate": {{ "a": {{}}, "b": {{}} }}, "readings": [{}] }}"#,
        readings.join(",")
    ));
    let (held, streamed) = (fitted(&campaign), stream(&campaign, &Settings::default()));
    for (a, b) in held.parameters.iter().zip(&streamed.parameters) {
        let (u, v) = (a.uncertainty.unwrap().u, b.uncertainty.unwrap().u);
        assert!(v > 1e-17 && v < 1e-13 && (u / v - 1.0).abs() < 1e-9, "{}: {u} {v}", a.id);
    }
}

/// A line in time, its noise white and correlated.
fn line(rows: usize, step: f64, (white, sd, tau): (f64, f64, f64), seed: u64, scatter: &str) -> Campaign {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let keeps = (-step / tau).exp();
    let mut deviation = sd * normal();
    let readings: Vec<String> = (0..rows)
        .map(|k| {
            let t = k as f64 * step;
            if k > 0 {
                deviation = keeps * deviation + sd * (1.0 - keeps * keeps).sqrt() * normal();
            }
            format!("{{\"time_s\": {t}, \"y\": {}}}", 2.0 + 0.01 * t + deviation + white * normal())
        })
        .collect();
    parse(&format!(
        r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "unit": "V", "model": "a + b*time_s" }} }} }},
            "estimate": {{ "a": {{}}, "b": {{}} }}, "scatter": [{scatter}], "readings": [{}] }}"#,
        readings.join(",")
    ))
}

/// Deviations over time and no white noise: about every second record has the top of its likelihood where the white noise is zero. There the rows less what is left
/// of those before them are independent and of one variance, and ordinary least squares with `n - 2` degrees of freedom is exact.
#[test]
fn white_noise_at_zero_beside_deviations() {
    const ROWS: usize = 60;
    const TAU: f64 = 10.0;
    let scatter = r#"{ "of": "y", "over": "time_s", "tau": 10, "u": "estimate" }"#;
    let keeps = (-1.0 / TAU).exp();
    let mut at_zero = 0;
    for seed in 1..=20 {
        let campaign = line(ROWS, 1.0, (0.0, 0.8, TAU), seed, scatter);
        let (held, streamed) = (fitted(&campaign), stream(&campaign, &Settings::default()));
        let is_zero = |fit: &Fit| fit.noise.sources.iter().any(|s| s.line.is_none() && s.state == LineState::AtZero);
        assert_eq!(is_zero(&held), is_zero(&streamed), "{seed}");
        same(&held, &streamed);
        if !is_zero(&held) {
            continue;
        }
        at_zero += 1;
        let observed: Vec<f64> = campaign.readings.rows.iter().map(|row| row.observations[0].value).collect();
        let whitened = |column: &dyn Fn(usize) -> f64| {
            let own = |k: usize| (column(k) - keeps * column(k - 1)) / (1.0 - keeps * keeps).sqrt();
            DVector::from_fn(ROWS, |k, _| if k == 0 { column(0) } else { own(k) })
        };
        let a = DMatrix::from_columns(&[whitened(&|_| 1.0), whitened(&|k| k as f64)]);
        let y = whitened(&|k| observed[k]);
        let cofactor = (a.transpose() * &a).try_inverse().unwrap();
        let x = &cofactor * a.transpose() * &y;
        let dof = ROWS as f64 - 2.0;
        let variance = (&y - &a * &x).norm_squared() / dof;
        for (j, own) in held.parameters.iter().enumerate() {
            let (expected, u) = ((variance * cofactor[(j, j)]).sqrt(), own.uncertainty.unwrap());
            assert!((own.value.unwrap() - x[j]).abs() < 1e-6 * expected, "{seed} {}", own.id);
            assert!((u.u / expected - 1.0).abs() < 1e-6, "{seed} {}: {} {expected}", own.id, u.u);
            assert!((u.dof / dof - 1.0).abs() < 1e-6, "{seed} {}: {}", own.id, u.dof);
        }
    }
    assert!((5..=15).contains(&at_zero), "{at_zero} of 20");
}

/// 95 % intervals of a line's offset and slope: correlation stated, estimated, and forgotten.
///
/// 100 records a row by default; 1,000 with `TUMBLE_LONG=1 cargo test --release --test fitting streamed -- --nocapture`, which prints the table.
#[test]
fn coverage() {
    const STATED: &str = r#"{ "of": "y", "over": "time_s", "tau": 5, "u": 1 }"#;
    const ESTIMATED: &str = r#"{ "of": "y", "over": "time_s", "tau": "estimate", "u": "estimate" }"#;
    let count = draws(100, 1000);
    println!("rows  tau/record  noise      a %   b %   chi-square or scatter/true");
    // what is stated is exact; estimated parts cost the t distribution's degrees of freedom by an approximation: one percent more
    for (rows, step, scatter, name, allowed) in [
        (500, 0.4, STATED, "stated", Some(0.0)),
        (500, 0.4, ESTIMATED, "estimated", Some(0.01)),
        (2000, 0.2, ESTIMATED, "estimated", Some(0.01)),
        (500, 0.4, "", "forgotten", None),
    ] {
        let (mut hits, mut ratio) = ([0_usize; 2], 0.0);
        for k in 0..count {
            let fit = stream(&line(rows, step, (0.5, 1.0, 5.0), 1000 + k as u64, scatter), &Settings::default());
            for (j, truth) in [2.0, 0.01].into_iter().enumerate() {
                let own = fit.parameters[j].uncertainty.unwrap();
                hits[j] += usize::from((fit.point[j] - truth).abs() <= own.expanded);
            }
            let sd =
                fit.noise.sources.iter().find(|own| own.line == Some(0)).map_or(f64::NAN, |own| own.variance.sqrt());
            ratio += sd / count as f64;
        }
        let share = hits.map(|hits| hits as f64 / count as f64);
        let part = 5.0 / (rows as f64 * step);
        println!(
            "{rows:>4}  {part:>10.3}  {name:<9}  {:>4.1}  {:>4.1}  {ratio:.3}",
            100.0 * share[0],
            100.0 * share[1]
        );
        // four standard errors of the count
        let chance = 4.0 * (0.95 * 0.05 / count as f64).sqrt();
        let right = |share: &f64| match allowed {
            Some(more) => (share - 0.95).abs() <= more + chance,
            None => *share < 0.75,
        };
        assert!(share.iter().all(right), "{name} {rows}: {share:?}");
    }
}

/// White noise alone: a line that is to be estimated comes out at zero, and u is that of white noise.
#[test]
fn nothing_correlated() {
    let scatter = r#"{ "of": "y", "over": "time_s", "tau": 5, "u": "estimate" }"#;
    let mut zeros = 0;
    for seed in 0..6 {
        let fit = stream(&line(800, 0.5, (1.0, 0.0, 5.0), seed, scatter), &Settings::default());
        let own = fit.noise.sources.iter().find(|own| own.line == Some(0)).unwrap();
        zeros += usize::from(own.state == LineState::AtZero);
        assert!(own.variance.sqrt() < 0.3, "{}", own.variance.sqrt());
    }
    assert!(zeros >= 1, "{zeros}");
}

/// Residuals tell a curve that the model has not, correlation that is not stated, and a spike.
#[test]
fn residuals_tell() {
    let words = |fit: &Fit| {
        let report = tumble::report::fit_report(fit);
        report.checks.verdict.iter().map(|line| line.to_string()).collect::<Vec<_>>().join("\n")
    };
    let quiet = line(3000, 0.1, (1.0, 0.0, 1.0), 4, "");
    let said = words(&stream(&line(3000, 0.1, (1.0, 1.0, 2.0), 3, ""), &Settings::default()));
    assert!(said.contains("NOT INDEPENDENT"), "{said}");
    let bent = |change: &dyn Fn(usize, f64) -> f64| {
        let mut own = quiet.clone();
        for (k, reading) in own.readings.rows.iter_mut().enumerate() {
            let t = reading.columns[0].unwrap();
            reading.observations[0].value += change(k, t);
        }
        stream(&own, &Settings::default())
    };
    let curved = bent(&|_, t| 4e-5 * (t - 150.0).powi(2));
    assert!(words(&curved).contains("LACK OF FIT over time_s"), "{}", words(&curved));
    let spiked = bent(&|k, _| if k == 1233 { 12.0 } else { 0.0 });
    assert!(words(&spiked).contains("row 1234 of y"), "{}", words(&spiked));
    let own = spiked.streamed.as_ref().unwrap();
    assert_eq!((own.sensors[0].largest[0].number, own.rows, own.values), (1234, 3000, 3000));
}

/// Tests of residuals say what they promise where nothing is wrong: with white noise, and with correlation that is stated.
///
/// 200 records a row, 2,000 with `TUMBLE_LONG=1 ... -- --nocapture`, which prints the table.
#[test]
fn quiet_residuals() {
    let count = draws(200, 2000);
    println!("noise        p < 0.05 of: lack of fit  means (any, Bonferroni)  lags  largest");
    for (name, noise, scatter) in [
        ("white", (1.0, 0.0, 2.0), ""),
        ("correlated", (0.5, 1.0, 2.0), r#"{ "of": "y", "over": "time_s", "tau": 2, "u": 1 }"#),
    ] {
        let mut rejected = [0_usize; 4];
        for k in 0..count {
            let fit = stream(&line(1000, 0.1, noise, 50_000 + k as u64, scatter), &Settings::default());
            let own = fit.streamed.as_ref().unwrap();
            let sensor = &own.sensors[0];
            let all = sensor.means.len() as f64;
            rejected[0] += usize::from(own.bins[0].p < 0.05);
            rejected[1] += usize::from(sensor.means.iter().any(|test| test.p * all < 0.05));
            rejected[2] += usize::from(sensor.lags_p.unwrap() < 0.05);
            rejected[3] += usize::from(sensor.largest[0].p < 0.05);
        }
        let share = rejected.map(|n| n as f64 / count as f64);
        println!("{name:<11}  {share:?}");
        // 5 % and four standard errors of a few hundred records; tests of an estimated scale keep below
        assert!(share.iter().all(|share| *share < 0.05 + 4.0 * (0.05 * 0.95 / count as f64).sqrt()), "{share:?}");
    }
}

/// Records of linear models with white noise, of several blocks, with absent values, stated uncertainties, units and rows outside of the segments: read
/// twice, and the numbers of the same readings at hand.
#[test]
fn linear_records_are_read_twice() {
    use std::fmt::Write;
    let folder = tempfile::tempdir().expect("a folder");
    let mut rng = Pcg64Mcg::seed_from_u64(3101);
    for case in 0..draws(12, 60) {
        let (stated, absent, marked) = (case % 2 == 0, case % 3 == 0, case % 4 < 2);
        let terms = 2 + case % 5;
        let model = (0..terms).fold("c".to_string(), |line, k| match k % 3 {
            0 => line + &format!(" + b{k}*x{k}"),
            1 => line + &format!(" + b{k}*x{k}^2"),
            _ => line + &format!(" + b{k}*x{k}*x{}", k - 1),
        });
        let columns: String = (0..terms).map(|k| format!("x{k},")).collect();
        let mut table = format!(
            "time_s,{columns}y (mV){}{}\n",
            if stated { ",y_u" } else { "" },
            if marked { ",mark" } else { "" }
        );
        let mut used = table.replace(",mark", "");
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        for i in 0..3000 {
            let mut row = format!("{}", f64::from(i) * 0.01);
            for _ in 0..terms {
                write!(row, ",{}", draw()).expect("text");
            }
            let is_absent = absent && draw() > 1.5;
            let value = if is_absent { String::new() } else { (1e6 + 30.0 * draw()).to_string() };
            write!(row, ",{value}").expect("text");
            if stated {
                write!(row, ",{}", 0.01 + draw().abs()).expect("text");
            }
            let outside = marked && draw() > 1.0;
            if !outside && !is_absent {
                writeln!(used, "{row}").expect("text");
            }
            writeln!(table, "{row}{}", if marked { [",in", ",out"][usize::from(outside)] } else { "" }).expect("text");
        }
        std::fs::write(folder.path().join("log.csv"), table).expect("a table");
        std::fs::write(folder.path().join("used.csv"), used).expect("a table");
        let unknowns: String = (0..terms).map(|k| format!(r#", "b{k}": {{}}"#)).collect();
        let by = if marked { r#", "by": "mark", "positions": [{ "position": "in" }]"# } else { "" };
        let campaign = |readings: &str| {
            let path = folder.path().join("c.campaign.json");
            let text = format!(
                r#"{{ "bench": {{ "id": "q", "chain": [], "sensors": {{ "y": {{ "unit": "V", "model": "{model}" }} }} }},
                    "estimate": {{ "c": {{}}{unknowns} }}, "readings": {readings} }}"#
            );
            std::fs::write(&path, text).expect("a campaign");
            path
        };
        let path = campaign(&format!(r#"{{ "samples": "log.csv", "as": "rows"{by} }}"#));
        let rows = fit_rows(&path).unwrap_or_else(|error| panic!("{case}: {error}"));
        let held = Campaign::from_path(campaign(r#""used.csv""#)).unwrap_or_else(|error| panic!("{case}: {error}"));
        let held = tumble::fit(&held, &Settings::default()).unwrap_or_else(|error| panic!("{case}: {error}"));
        assert_eq!(rows.streamed.as_ref().map(|own| own.passes), Some(2), "{case}");
        for (own, other) in rows.parameters.iter().zip(&held.parameters) {
            let (a, b) = (own.uncertainty.unwrap(), other.uncertainty.unwrap());
            let apart = (own.value.unwrap() - other.value.unwrap()).abs() / b.u;
            assert!(apart < 1e-9 && (a.u / b.u - 1.0).abs() < 1e-9, "{case} {}: {apart} {} {}", own.id, a.u, b.u);
        }
    }
}

/// A long record is thinned for its sample; numbers of rows are those of the record.
#[test]
fn sample_of_a_long_record() {
    let campaign = line(5000, 0.1, (1.0, 0.0, 1.0), 8, "");
    let fit = stream(&campaign, &Settings::default());
    let own = fit.streamed.as_ref().unwrap();
    assert_eq!((own.rows, own.numbers.len(), own.numbers[1]), (5000, 1250, 5));
    let report = tumble::report::fit_report(&fit);
    assert_eq!((report.fit.readings, report.fit.dof, report.readings.len()), (5000, 4998, 1250));
    assert_eq!(report.readings[1].index, 5);
    let held = fitted(&campaign);
    assert!((held.point[1] - fit.point[1]).abs() < 1e-9 * held.parameters[1].uncertainty.unwrap().u);
    assert!((held.estimate.sum_of_squares / fit.estimate.sum_of_squares - 1.0).abs() < 1e-12);
}

/// What is not to be had from streamed rows is refused, and why.
#[test]
fn refusals() {
    let settings = Settings::default();
    let refused = |campaign: Campaign, settings: &Settings| {
        let mut rows = Held::new(campaign.readings.clone());
        let sample = streamed::sample(&mut rows).unwrap();
        streamed::fit(campaign, &mut rows, &sample, settings).unwrap_err().to_string()
    };
    let plain = || line(40, 1.0, (1.0, 0.0, 1.0), 1, "");
    let robust = Settings { robust: Some(tumble::fit::RobustMethod::Huber), ..settings };
    assert!(refused(plain(), &robust).contains("weights belong to single rows"));
    let per = line(40, 1.0, (1.0, 0.0, 1.0), 1, r#"{ "of": "a", "per": "position", "u": 1 }"#);
    assert!(refused(per, &settings).contains("a per position scatters"));
    // times that fall
    let scatter = r#"{ "of": "y", "over": "time_s", "tau": 5, "u": 1 }"#;
    let mut back = line(40, 1.0, (1.0, 0.0, 1.0), 1, scatter);
    let rows: Vec<_> = back.readings.rows.iter().rev().cloned().collect();
    back.readings = Readings { rows, ..back.readings };
    assert!(refused(back, &settings).contains("the times of the rows do not rise"));
}

/// The fit of a line over `x`, or over time, whose readings are the rows of a record with this text.
fn of_log(log: &str, readings: &str) -> tumble::Result<Fit> {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("log.csv"), log).expect("a file");
    let path = folder.path().join("line.campaign.json");
    let input = if readings.contains("rate_hz") { "time_s" } else { "x" };
    let campaign = format!(
        r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "unit": "V", "model": "a + b*{input}" }} }} }},
            "estimate": {{ "a": {{}}, "b": {{}} }}, "readings": {{ "samples": "log.csv", "as": "rows", {readings} }} }}"#
    );
    std::fs::write(&path, campaign).expect("a file");
    fit_rows(&path)
}

/// Rows are dealt to positions by a column of labels or by times; rows of no position are not used.
///
/// Position A at x = 0 reads 1, 2, 3, position B at x = 2 reads 4, 8: a = 2, b = 2, squares 2 + 8 = 10 at 3 degrees of freedom.
#[test]
fn rows_of_positions() {
    let positions = r#""positions": [ { "position": "A", "x": 0 }, { "position": "B", "x": 2 } ]"#;
    let labelled = "t,mark,y\n0,A,1\n1,A,2\n2,A,3\n3,moving,50\n4,B,4\n5,B,8\n";
    let times = r#""times": [ { "position": "A", "start_s": 0, "end_s": 2.5 }, { "position": "B", "start_s": 3.5, "end_s": 9 } ]"#;
    for source in [r#""by": "mark""#, times] {
        let fit =
            of_log(labelled, &format!("{source}, {positions}")).unwrap_or_else(|error| panic!("{source}: {error}"));
        let own = fit.streamed.as_ref().expect("rows");
        assert!((fit.point[0] - 2.0).abs() < 1e-12 && (fit.point[1] - 2.0).abs() < 1e-12, "{source}: {:?}", fit.point);
        assert_eq!((own.rows, own.values), (5, 5), "{source}");
        // u(a)^2 = s^2/3
        let u = fit.parameters[0].uncertainty.expect("u").u;
        assert!((u - (10.0f64 / 3.0 / 3.0).sqrt()).abs() < 1e-12, "{source}: {u}");
    }
    let error = of_log(labelled, positions).expect_err("nothing says which rows belong to which").to_string();
    assert!(error.contains("several positions"), "{error}");
    let error = of_log(labelled, &format!(r#""by": "label", {positions}"#)).expect_err("no such column").to_string();
    assert!(error.contains("label") && error.contains("mark"), "{error}");
}

/// The k-th run of a label is of the k-th of its positions; another number of runs is an error, with the words that a reduction has for it.
#[test]
fn rows_of_runs() {
    let positions = r#""positions": [ { "position": "A", "x": 0 }, { "position": "A", "x": 2 } ], "by": "mark""#;
    let log = |runs: usize| {
        let first = "t,mark,y\n0,A,1\n1,A,2\n2,A,3\n";
        let next = ["3,moving,50\n4,A,4\n5,A,8\n", "6,,50\n7,A,50\n"];
        first.to_string() + &next[..runs - 1].concat()
    };
    let fit = of_log(&log(2), positions).expect("a fit");
    assert!((fit.point[0] - 2.0).abs() < 1e-12 && (fit.point[1] - 2.0).abs() < 1e-12, "{:?}", fit.point);
    for runs in [1, 3] {
        let error = of_log(&log(runs), positions).expect_err("runs of other positions").to_string();
        assert!(error.contains(&format!("has 2 of the position 'A', the record {runs} runs of rows")), "{error}");
    }
    // positions that differ in nothing are taken as often as one likes, unless another one is not taken at all
    let same = r#""positions": [ { "position": "A" }, { "position": "A" } ], "by": "mark""#;
    let with_x =
        |text: String| text.replace("mark,y", "mark,x,y").replace(",A,", ",A,1,").replace("A,1,1\n", "A,0,1\n");
    let with_x = |text: String| with_x(text).replace("moving,", "moving,0,").replace("6,,", "6,,0,");
    let fit = of_log(&with_x(log(3)), same).expect("a fit");
    assert_eq!(fit.streamed.as_ref().expect("rows").rows, 6);
    let error =
        of_log(&with_x(log(3)), &same.replace(" ]", r#", { "position": "B" } ]"#)).expect_err("no B").to_string();
    assert!(error.contains("'B' has none"), "{error}");
}

/// The times of a record without a column of times: two samples a second, y = 1, 2, 4: the slope is 3 per second, a = 5/6.
#[test]
fn rows_of_a_rate() {
    let fit = of_log("y\n1\n2\n4\n", r#""rate_hz": 2"#).expect("a fit");
    assert!((fit.point[1] - 3.0).abs() < 1e-12 && (fit.point[0] - 5.0 / 6.0).abs() < 1e-12, "{:?}", fit.point);
}

/// Whoever needs all readings at hand says so, and where.
#[test]
fn rows_are_no_readings_at_hand() {
    let error = tumble::Campaign::from_path(data("streamed/stated.campaign.json")).expect_err("rows");
    assert!(error.to_string().contains("never all in memory"), "{error}");
    assert_eq!(error.place().path, "readings.as");
}
