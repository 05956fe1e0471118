//! What scatters is the noise floor of a diagnosis.

use super::draws::draws;
use super::support::parse;
use rayon::prelude::*;
use tumble::campaign::{Campaign, JointState, Size};
use tumble::diagnosis::{Diagnosis, Settings, Verdict, diagnose};
use tumble::simulate::{DrawnNoise, Hidden, Truth, simulate};
use tumble::wire;

/// Positions of a gyro on its table, four rates at each: `count` of the 24 with alpha and beta at multiples of 45 and 90 degrees.
fn table(count: usize, scatter: &str) -> Campaign {
    let mut readings = Vec::new();
    for k in 0..count {
        let (alpha, beta) = (90 * (k % 4), 45 * (k / 4) + 10 * (k % 3));
        for rate in [20, -20, 30, -30] {
            readings.push(format!(
                r#"{{"position": "{k}", "alpha_deg": {alpha}, "beta_deg": {beta}, "gamma_deg_s": {rate}}}"#
            ));
        }
    }
    parse(&format!(
        r#"{{"bench": "gyro-turntable", "known": {{"kI": {{"value": -2.9222}}}},
            "estimate": {{"V0": {{}}, "dtheta_y2": {{}}, "dtheta_z2": {{}}, "dtheta_y0": {{}}}},
            "scatter": [{scatter}], "readings": [{}]}}"#,
        readings.join(",")
    ))
}

const SD: f64 = 2e-4;

fn measured(plan: &Campaign, effects: &[(&str, f64)], stated: bool, seed: u64) -> Campaign {
    let mut point = plan.reference_point();
    point[..4].copy_from_slice(&[1.5e-3, -7.9e-4, 3e-4, -3.6e-5]);
    let effects = effects.iter().map(|(term, value)| Hidden::new(plan, term, *value, Some(0)).unwrap()).collect();
    let noise = vec![DrawnNoise { sd: SD, stated, decimals: None }];
    simulate(plan, &Truth { point, noise, effects, scatter: Vec::new() }, seed).unwrap()
}

fn diagnosed(campaign: &Campaign) -> Diagnosis {
    diagnose(campaign, &wire::built_in_effects().unwrap(), &Settings::default()).unwrap()
}

fn summary(found: &Diagnosis) -> String {
    let effects: Vec<String> = found
        .effects
        .iter()
        .map(|f| {
            let aliases: Vec<&str> = f.aliases.iter().take(3).map(|a| a.regressor.as_str()).collect();
            format!(
                "{} t={:.1} p={:.1e} ({} aliases {})",
                f.effect.regressor,
                f.t,
                f.p,
                f.aliases.len(),
                aliases.join(" ")
            )
        })
        .collect();
    let follows = found.unexplained.as_ref().map(|u| u.pattern.clone()).unwrap_or_default();
    format!("{} {} {follows}", found.verdict.name(), effects.join(" + "))
}

/// What is hidden, and what comes out of so many campaigns.
struct Row {
    positions: usize,
    /// Standard deviation of the positions, in V.
    sd: f64,
    stated: bool,
    estimated: bool,
    hidden: &'static [(&'static str, f64)],
}

struct Outcome {
    /// Every hidden effect is named or an alias, and nothing else is named.
    right: f64,
    /// Campaigns with a finding that is nothing of what is hidden.
    wrong: f64,
    verdicts: Vec<Verdict>,
}

fn outcome(row: &Row, count: usize) -> Outcome {
    let line = format!(r#"{{"of": "V", "per": "position", "u": {}}}"#, row.sd);
    let plan = table(row.positions, &line);
    let results: Vec<(bool, bool, Verdict)> = (0..count as u64)
        .into_par_iter()
        .map(|seed| {
            let mut campaign = measured(&plan, row.hidden, row.stated, seed);
            if row.estimated {
                campaign.scatter[0].size = Size::Estimated;
            }
            let found = diagnosed(&campaign);
            let is = |k: usize, term: &str| {
                let own = &found.effects[k];
                own.effect.regressor == term || own.aliases.iter().any(|a| a.regressor == term)
            };
            let all = 0..found.effects.len();
            let named = row.hidden.iter().all(|(term, _)| all.clone().any(|k| is(k, term)));
            let wrong = all.clone().any(|k| !row.hidden.iter().any(|(term, _)| is(k, term)));
            if std::env::var("SHOW").is_ok() && (wrong || !named || found.verdict == Verdict::Unexplained) {
                println!("   {seed}: {}", summary(&found));
            }
            (named && !wrong && found.effects.len() == row.hidden.len(), wrong, found.verdict)
        })
        .collect();
    let share = |f: &dyn Fn(&(bool, bool, Verdict)) -> bool| {
        100.0 * results.iter().filter(|own| f(own)).count() as f64 / count as f64
    };
    Outcome { right: share(&|r| r.0), wrong: share(&|r| r.1), verdicts: results.iter().map(|r| r.2).collect() }
}

#[test]
fn scatter_table() {
    let count = count(3, 1000);
    println!(
        "positions  sd/noise  noise      line       hidden                          right  wrong  nothing-missing, %"
    );
    for hidden in [&[][..], &[("a_S", 0.008)], &[("a_S", 0.008), ("cos(2*beta)", 0.006)]] {
        for positions in [12, 24] {
            for sd in [1e-4, 1e-3] {
                for (stated, estimated) in [(true, false), (true, true), (false, false), (false, true)] {
                    let row = Row { positions, sd, stated, estimated, hidden };
                    let found = outcome(&row, count);
                    let nothing = found.verdicts.iter().filter(|v| **v == Verdict::NothingMissing).count();
                    let of = |b: bool| if b { "estimated" } else { "stated" };
                    println!(
                        "{positions:9}  {:8.1}  {:9}  {:9}  {:30}  {:5.1}  {:5.1}  {:5.1}",
                        sd / SD,
                        of(!stated),
                        of(estimated),
                        hidden.iter().map(|h| h.0).collect::<Vec<_>>().join(" + "),
                        found.right,
                        found.wrong,
                        100.0 * nothing as f64 / count as f64,
                    );
                    let nothing = 100.0 * nothing as f64 / count as f64;
                    // four standard errors beside 99 %
                    let chance = 4.0 * (99.0 / count as f64).sqrt();
                    assert!(found.wrong <= 1.0 + chance, "{}", found.wrong);
                    match hidden.len() {
                        0 => assert!(nothing >= 99.0 - chance, "{nothing}"),
                        1 => assert!(found.right >= 98.0 - chance, "{}", found.right),
                        // of two effects that estimated scatter hides behind each other, twelve positions tell few
                        _ if positions == 24 || !estimated => assert!(found.right >= 90.0 - chance, "{}", found.right),
                        _ => {}
                    }
                }
            }
        }
    }
}

/// A few by default, the full count with `TUMBLE_LONG=1`; `TUMBLE_CAMPAIGNS` is any other.
fn count(few: usize, full: usize) -> usize {
    let asked = std::env::var("TUMBLE_CAMPAIGNS").ok().and_then(|n| n.parse().ok());
    asked.unwrap_or(draws(few, full))
}

/// Positions that scatter and no line that says so: named where settings were mounted again, told as a possibility where they were not.
#[test]
fn positions_that_scatter_are_found_where_settings_are_mounted_again() {
    let count = count(2, 500);
    println!("mountings  sd/noise  noise      hidden       found  alias or itself named  effect named, %");
    for mountings in [1, 2] {
        for sd in [0.0, 4e-4, 1e-3] {
            for stated in [true, false] {
                for hidden in [&[][..], &[("a_S", 0.008)]] {
                    let line = if sd > 0.0 {
                        format!(r#"{{"of": "V", "per": "position", "u": {sd}}}"#)
                    } else {
                        String::new()
                    };
                    let mut plan = table(24, &line);
                    for reading in plan.readings.rows.iter_mut() {
                        let k: usize = reading.position.parse().unwrap();
                        let like = k % (24 / mountings);
                        reading.joints[2] = JointState::Held { angle_deg: (90 * (like % 4)) as f64 };
                        reading.joints[1] = JointState::Held { angle_deg: (45 * (like / 4) + 10 * (like % 3)) as f64 };
                    }
                    let results: Vec<(bool, bool)> = (0..count as u64)
                        .into_par_iter()
                        .map(|seed| {
                            let mut campaign = measured(&plan, hidden, stated, seed);
                            campaign.scatter.clear();
                            let found = diagnosed(&campaign);
                            if std::env::var("SHOW").is_ok() {
                                println!("   {}", summary(&found));
                            }
                            let scatter = found.effects.iter().any(|f| f.effect.regressor == "scatter:position");
                            let named = |term: &str| {
                                found.effects.iter().any(|f| {
                                    f.effect.regressor == term || f.aliases.iter().any(|a| a.regressor == term)
                                })
                            };
                            (scatter, hidden.iter().all(|(term, _)| named(term)))
                        })
                        .collect();
                    let share = |f: &dyn Fn(&(bool, bool)) -> bool| {
                        100.0 * results.iter().filter(|r| f(r)).count() as f64 / count as f64
                    };
                    let (scatter, named) = (share(&|r| r.0), share(&|r| r.1));
                    let chance = 4.0 * (99.0 / count as f64).sqrt();
                    match (mountings, sd > 0.0) {
                        (2, true) => assert!(scatter >= 95.0 - chance, "{scatter}"),
                        _ => assert!(scatter <= 1.0 + chance, "{scatter}"),
                    }
                    assert!(named >= 80.0 - chance || mountings == 1, "{named}");
                    println!(
                        "{mountings:9}  {:8.1}  {:9}  {:10}  {scatter:5.1}  {named:5.1}",
                        sd / SD,
                        if stated { "stated" } else { "estimated" },
                        hidden.iter().map(|h| h.0).collect::<String>()
                    );
                }
            }
        }
    }
}

/// `--remount` is the same line, for a diagnosis as for a fit.
#[test]
fn remount_is_a_line_per_position() {
    let plan = table(24, r#"{"of": "V", "per": "position", "u": 0.001}"#);
    let with_line = measured(&plan, &[("a_S", 0.008)], true, 3);
    let mut without = with_line.clone();
    without.scatter.clear();
    let settings = Settings { remount: tumble::fit::Remount::Stated(1e-3), ..Settings::default() };
    let by_option = diagnose(&without, &wire::built_in_effects().unwrap(), &settings).unwrap();
    let by_line = diagnosed(&with_line);
    assert_eq!(by_option.effects[0].effect.regressor, "a_S");
    assert_eq!(by_option.effects[0].t, by_line.effects[0].t);
    assert_eq!(by_option.gap_after.chi_square, by_line.gap_after.chi_square);
}

/// The evidence is that of a dense generalised least squares: `t^2` is the fall of `r' V^-1 r` with the column in the model.
#[test]
fn evidence_is_that_of_generalised_least_squares() {
    let plan = table(12, r#"{"of": "beta", "per": "position", "u": 40, "unit": "arcsec"}"#);
    let campaign = measured(&plan, &[("a_S", 0.008)], true, 5);
    let found = diagnosed(&campaign);
    let own = &found.effects[0];
    let fit = tumble::fit::fit(&campaign, &tumble::fit::Settings::default()).unwrap();
    let m = fit.design.rows.len();
    let lines = tumble::fit::scatter_lines(&campaign, &fit.design, &vec![SD; m]);
    let mut v = faer::Mat::from_fn(m, m, |i, j| if i == j { SD * SD } else { 0.0 });
    for a in &lines[0].felt {
        for b in lines[0].felt.iter().filter(|b| b.level == a.level) {
            v[(a.row, b.row)] += a.by * b.by * lines[0].variance.unwrap();
        }
    }
    use faer::linalg::solvers::Solve;
    let chi_square = |columns: usize| {
        let all = faer::Mat::from_fn(m, 4 + columns, |i, j| match j {
            4 => own.effect.column[i],
            _ => fit.design.jacobian[(i, j)],
        });
        let y = faer::Mat::from_fn(m, 1, |i, _| fit.system.observed[i]);
        let factor = v.partial_piv_lu();
        let normal = all.transpose() * factor.solve(&all);
        let x = normal.partial_piv_lu().solve(all.transpose() * factor.solve(&y));
        let rest = &y - &all * x;
        (rest.transpose() * factor.solve(&rest))[(0, 0)]
    };
    let fall = chi_square(0) - chi_square(1);
    assert!((own.t * own.t / fall - 1.0).abs() < 1e-3, "{} {fall}", own.t * own.t);
}

/// What a plan promises of an effect is the `u` of a dense generalised least squares with its column.
#[test]
fn a_plan_foresees_effects_beside_what_scatters() {
    let plan = table(12, r#"{"of": "beta", "per": "position", "u": 40, "unit": "arcsec"}"#);
    let noise = tumble::plan::Noise::new(&plan, &[("V".into(), SD)], &[]).unwrap();
    let seen = tumble::diagnosis::foresee(&plan, &wire::built_in_effects().unwrap(), &noise).unwrap();
    let model = tumble::design::Model::new(&plan).unwrap();
    let design = tumble::design::assemble(&plan, &model, &plan.reference_point()).unwrap();
    let m = design.rows.len();
    let line = &tumble::fit::scatter_lines(&plan, &design, &vec![SD; m])[0];
    let mut v = faer::Mat::from_fn(m, m, |i, j| if i == j { SD * SD } else { 0.0 });
    for a in &line.felt {
        for b in line.felt.iter().filter(|b| b.level == a.level) {
            v[(a.row, b.row)] += a.by * b.by * line.variance.unwrap();
        }
    }
    use faer::linalg::solvers::Solve;
    let factor = v.partial_piv_lu();
    let mut compared = 0;
    for prospect in seen.prospects.iter().filter(|p| p.u.is_some() && p.left > 0.01) {
        let all =
            faer::Mat::from_fn(m, 5, |i, j| if j == 4 { prospect.effect.column[i] } else { design.jacobian[(i, j)] });
        let normal = all.transpose() * factor.solve(&all);
        let scale: Vec<f64> = (0..5).map(|j| normal[(j, j)].sqrt()).collect();
        let scaled = faer::Mat::from_fn(5, 5, |i, j| normal[(i, j)] / scale[i] / scale[j]);
        let mut unit = faer::Mat::zeros(5, 1);
        unit[(4, 0)] = 1.0;
        let u = scaled.partial_piv_lu().solve(&unit)[(4, 0)].sqrt() / scale[4];
        let own = prospect.u.unwrap();
        assert!((own / u - 1.0).abs() < 1e-6, "{}: {own} {u}", prospect.effect.regressor);
        compared += 1;
    }
    assert!(compared > 20, "{compared}");
}
