//! Published data sets through `fit`, as campaigns without a chain: GUM H.3, Natrella 5-4.1, ISO/TS 28037, levelling nets, and the Xsens
//! static positions, a model line nonlinear in nine coefficients. Expected: rational arithmetic (tests/scripts/reference_campaigns.py)
//! and the digits as published.

use crate::support::*;
use serde_json::Value;
use tumble::fit::{Fit, Settings, Weighting};

/// Everything that the exact solution of a set says; `relative` is the tolerance of its estimates.
fn assert_as_solved_exactly(name: &str, fit: &Fit, expected: &Value, relative: f64) {
    let near = |found: f64, exact: &Value, relative: f64, size: f64, what: &str| {
        assert_within(found, number(exact), relative * number(exact).abs().max(size), &format!("{name}: {what}"));
    };
    assert_eq!(fit.estimate.dof as u64, expected["dof"].as_u64().expect("dof"), "{name}");
    for (id, exact) in entries(&expected["parameters"]) {
        near(value(fit, id), &exact["exact"], relative, 0.0, id);
        near(uncertainty(fit, id), &exact["u"], 1e2 * relative, 0.0, &format!("u of {id}"));
    }
    let sd = (fit.estimate.sum_of_squares / fit.estimate.dof as f64).sqrt();
    near(sd, &expected["residual_sd"], 1e2 * relative, 0.0, "residual sd");
    near(fit.estimate.sum_of_squares, &expected["sum_of_squares"], 1e2 * relative, 0.0, "sum of squares");
    let order = expected["covariance"]["order"].as_array().expect("names");
    let index = |id: &Value| fit.parameters.iter().position(|p| *id == p.id.as_str()).expect("a parameter");
    for (i, row) in expected["covariance"]["matrix"].as_array().expect("rows").iter().enumerate() {
        for (j, exact) in row.as_array().expect("a row").iter().enumerate() {
            let (a, b) = (index(&order[i]), index(&order[j]));
            let size = (fit.covariance[(a, a)] * fit.covariance[(b, b)]).sqrt();
            near(fit.covariance[(a, b)], exact, 1e2 * relative, size, "covariance");
        }
    }
    let readings = fit.design.rows.len();
    let largest =
        fit.campaign.readings.rows.iter().flat_map(|r| &r.observations).fold(0.0_f64, |m, o| m.max(o.value.abs()));
    for (row, i) in fit.quality().zip(0..readings) {
        near(row.residual, &expected["residuals"][i], relative, largest, "residual");
        near(row.leverage, &expected["leverages"][i], 1e2 * relative, 1.0, "leverage");
        near(row.redundancy, &expected["redundancy"][i], 1e2 * relative, 1.0, "redundancy number");
    }
}

/// Half a unit of the last digit of a published number.
fn half_digit(text: &str) -> f64 {
    let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, digits)| digits.len()) as i32;
    0.5 * 10_f64.powi(exponent.parse::<i32>().expect("an exponent") - decimals) * (1.0 + 1e-9)
}

#[track_caller]
fn assert_published(found: f64, published: &str, what: &str) {
    assert_within(found, published.parse().expect("a number"), half_digit(published), what);
}

fn solved(name: &str) -> Fit {
    let expected = json(&format!("{name}.expected.json"));
    let fit = fitted(&campaign(&format!("{name}.campaign.json")));
    // condition numbers up to 1e3 before scaling; 13 digits is what is left
    assert_as_solved_exactly(name, &fit, &expected, 1e-13);
    fit
}

#[test]
fn gum_h3_thermometer() {
    let fit = solved("gum/h3");
    assert_published(value(&fit, "y1"), "-0.1712", "y1");
    assert_published(uncertainty(&fit, "y1"), "0.0029", "s(y1)");
    assert_published(value(&fit, "y2"), "0.00218", "y2");
    assert_published(uncertainty(&fit, "y2"), "0.00067", "s(y2)");
    let correlation = fit.covariance[(0, 1)] / (uncertainty(&fit, "y1") * uncertainty(&fit, "y2"));
    assert_published(correlation, "-0.930", "r(y1, y2)");
    assert_published((fit.estimate.sum_of_squares / fit.estimate.dof as f64).sqrt(), "0.0035", "s");
    assert_published(value(&fit, "b30"), "-0.1494", "b(30)");
    assert_published(uncertainty(&fit, "b30"), "0.0041", "u of b(30)");
}

#[test]
fn natrella_5_4_1() {
    let fit = solved("gum/natrella-5-4-1");
    assert_published(value(&fit, "slope"), "-0.44985482", "slope");
    assert_published(value(&fit, "intercept"), "4654.9846", "intercept");
    // the handbook's variances come from hand calculation with rounded sums: 6 digits of them are right
    assert!(digits(fit.covariance[(0, 0)], 19.879452) > 6.0 && digits(fit.covariance[(1, 1)], 2.5649045e-5) > 6.0);
}

#[test]
fn iso_ts_28037_lines() {
    let fit = solved("iso28037/p13-equal-weights");
    for (id, published, u) in [("a", "1.866667", "0.4654747"), ("b", "1.757143", "0.1195229")] {
        assert_published(value(&fit, id), published, id);
        assert_published(uncertainty(&fit, id), u, id);
    }
    assert_published(fit.covariance[(0, 1)], "-0.050", "cov(a, b)");
    let test = fit.global_test.expect("stated uncertainties");
    assert_published(test.chi_square, "1.665", "chi-square");
    assert!(!test.rejected);
    let fit = solved("iso28037/p14-unequal-weights");
    for (id, published, u) in [("a", "0.8852", "0.5297081"), ("b", "2.0570", "0.177892")] {
        assert_published(value(&fit, id), published, id);
        assert_published(uncertainty(&fit, id), u, id);
    }
    assert_published(fit.covariance[(0, 1)], "-0.08227848", "cov(a, b)");
    assert_published(fit.global_test.expect("stated uncertainties").chi_square, "4.131", "chi-square");
    let fit = solved("iso28037/pearson-york-x-only");
    assert_published(value(&fit, "a"), "9.4302", "a");
    assert_published(value(&fit, "b"), "-1.5862", "b");
    assert_published(fit.covariance[(0, 1)], "-0.002211235", "cov(a, b)");
    assert!(fit.global_test.expect("stated uncertainties").rejected, "chi-square 544 with 8 degrees of freedom");
}

/// Heights to 0.1 mm and their a-posteriori standard deviations to 0.01 mm, every line as published.
#[test]
fn levelling_nets() {
    let mut compared = 0;
    for net in ["krumm", "baumann", "ghilani12-6", "niemeier"] {
        let name = format!("levelling/{net}");
        solved(&name);
        let expected = json(&format!("{name}.expected.json"));
        let relative = fit_with(
            &campaign(&format!("{name}.campaign.json")),
            Settings { weighting: Weighting::Relative, ..Settings::default() },
        );
        assert!(relative.global_test.is_none(), "a variance that was estimated cannot be tested");
        for (id, u) in entries(&expected["u_a_posteriori"]) {
            assert!(digits(uncertainty(&relative, id), number(u)) > 11.0, "{net}: a-posteriori u of {id}");
        }
        let (_, published) = entries(&expected["published"]).next().expect("a table");
        for line in published.as_array().expect("lines") {
            let line = line.as_str().expect("a line");
            if line.starts_with('#') {
                continue;
            }
            let cells: Vec<&str> = line.split_whitespace().collect();
            let [station, height, _, sd_mm] = cells[..] else { panic!("{line}") };
            let id = format!("H{station}");
            assert_published(value(&relative, &id), height, &format!("{net}: {id}"));
            assert_published(uncertainty(&relative, &id) * 1e3, sd_mm, &format!("{net}: sd of {id}, mm"));
            compared += 1;
        }
    }
    println!("{compared} published heights with their standard deviations");
    assert_eq!(compared, 21);
}

/// The global test of Niemeier's net with its stated weights rejects (46 with 4 degrees of freedom); of Krumm's it does not.
#[test]
fn the_global_test_of_a_net() {
    let rejected = |net: &str| fitted(&campaign(&format!("levelling/{net}.campaign.json"))).is_rejected();
    assert!(rejected("niemeier") && !rejected("krumm"));
}

/// The field's self-calibration by the norm of gravity, from a start without misalignment.
#[test]
fn xsens_static_positions() {
    let expected = json("xsens/static-positions.expected.json");
    let fit = exact(&campaign("xsens/static-positions.campaign.json"));
    let record = fit.convergence.as_ref().expect("a record");
    assert!(record.converged && record.iterations.len() <= 8, "{record:?}");
    assert_eq!((fit.design.rows.len(), fit.parameters.len()), (38, 9));
    // biases of 3e4 counts against a signal of 4e3: two digits fewer than usual
    assert_as_solved_exactly("xsens", &fit, &expected, 1e-10);
    let sd = (fit.estimate.sum_of_squares / fit.estimate.dof as f64).sqrt();
    assert_published(sd, "1.16e-3", "s, m/s^2");
    for (i, id) in expected["reference_fit"]["names"].as_array().expect("names").iter().enumerate() {
        let id = id.as_str().expect("a name");
        assert!(digits(value(&fit, id), number(&expected["reference_fit"]["value"][i])) > 8.0, "{id}");
        assert!(digits(uncertainty(&fit, id), number(&expected["reference_fit"]["std_error"][i])) > 6.0, "u of {id}");
    }
}
