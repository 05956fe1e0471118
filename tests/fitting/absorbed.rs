//! Deviations that the unknowns take up: nothing shows how large they are, so what follows them has no u, and the report says what to measure.

use crate::support::{assert_within, campaign, fitted, uncertainty};
use serde_json::Value;
use tumble::campaign::Campaign;
use tumble::estimate::LineState;
use tumble::report;

/// Which parameters of each campaign follow the deviations, by hand: the unknowns that make up for a shift of a position (day, campaign).
#[test]
fn what_follows_absorbed_deviations_has_no_u() {
    let tilts = ["dtheta_x0", "dtheta_y0", "dtheta_y1", "dtheta_y2", "dtheta_z2"];
    for (name, without, levels, sentence) in [
        // two positions, a line through both
        ("saturated_line", &["a", "s"][..], 2, "at least one new mounting (a position measured again) is needed"),
        // five mountings, five tilts; V0 is the mean of both senses of rotation
        ("gyro_remounted", &tilts[..], 5, "at least one new mounting (a position measured again) is needed"),
        ("table1_remount", &tilts[..], 5, "at least one new mounting (a position measured again) is needed"),
        // one campaign: the offset is b and its deviation
        ("confounded_campaign", &["b"][..], 1, "readings of at least one more campaign are needed"),
        // two days, and an unknown for each
        ("confounded_day", &["b", "step2"][..], 2, "readings with at least one more value of day are needed"),
    ] {
        let campaign = campaign(&format!("absorbed/{name}.campaign.json"));
        let fit = fitted(&campaign);
        let source = fit.noise.sources.last().unwrap();
        assert_eq!((source.state, source.levels), (LineState::Absorbed, levels), "{name}");
        assert!(fit.is_rejected(), "{name}");
        let report: Value = serde_json::to_value(report::fit_report(&fit)).unwrap();
        let parameters = report["parameters"].as_array().unwrap();
        for (k, own) in parameters.iter().enumerate() {
            let id = own["id"].as_str().unwrap();
            let has_u = !without.contains(&id);
            for key in ["u", "U", "interval"] {
                assert_eq!(own[key].is_null(), !has_u, "{name}: {id}.{key}");
            }
            assert!(own["value"].is_number() && own["state"] == "free", "{name}: {own}");
            assert_eq!(report["covariance"]["matrix"][k][k].is_null(), !has_u, "{name}: {id}");
        }
        let own = report["scatter"].as_array().unwrap().last().unwrap();
        let mut named: Vec<&str> = own["without_u"].as_array().unwrap().iter().map(|id| id.as_str().unwrap()).collect();
        named.sort_unstable();
        assert_eq!(named, without, "{name}");
        assert!(own["sd"].is_null(), "{name}: {own}");
        let table = tumble::document::terminal::brief(&tumble::report::fit_document(
            &report::fit_report(&fit),
            &Default::default(),
            tumble::language::Language::English,
        ));
        let text: Vec<&str> = table.split_whitespace().collect();
        assert!(text.join(" ").contains(sentence), "{name}: {table}");
    }
}

/// What does not follow the deviations keeps its uncertainty: that of a campaign in which nothing else scatters.
#[test]
fn what_does_not_follow_absorbed_deviations_keeps_its_u() {
    for (name, with_u) in [("confounded_campaign", ["k", "c", "q"]), ("confounded_day", ["k", "c", "q"])] {
        let whole = campaign(&format!("absorbed/{name}.campaign.json"));
        let plain = fitted(&Campaign { scatter: Vec::new(), ..whole.clone() });
        let fit = fitted(&whole);
        for id in with_u {
            assert_within(uncertainty(&fit, id), uncertainty(&plain, id), 1e-9 * uncertainty(&plain, id), id);
        }
    }
}

/// One position measured again is enough: its two means differ by two deviations and the noise alone.
#[test]
fn one_more_mounting_is_enough() {
    let mut line = campaign("absorbed/saturated_line.campaign.json");
    let again: Vec<_> = line.readings.rows.iter().filter(|reading| reading.position == "p0").cloned().collect();
    for (k, mut reading) in again.into_iter().enumerate() {
        reading.position = "p0 again".into();
        reading.observations[0].value += 0.3 + 0.01 * (k as f64);
        line.readings.rows.push(reading);
    }
    let fit = fitted(&line);
    assert_eq!(fit.noise.sources[1].state, LineState::Estimated);
    assert!(!fit.is_rejected());
    // the difference of the means of two positions at x = 0 has one degree of freedom, and so has all that follows the deviations alone
    let dof = fit.parameters[0].uncertainty.unwrap().dof;
    assert_within(dof, 1.0, 1e-6, "dof of a");
}

/// Five positions and four unknowns: the positions agree better than their readings scatter, so the variance is zero, and what follows the
/// means of positions has their one degree of freedom.
#[test]
fn a_variance_at_its_floor_settles() {
    let fit = fitted(&campaign("absorbed/pos_few_none.campaign.json"));
    assert!(fit.settled && !fit.is_rejected());
    assert_eq!(fit.noise.sources[1].state, LineState::AtZero);
    for own in &fit.parameters {
        assert_within(own.uncertainty.unwrap().dof, 1.0, 1e-6, &own.id);
    }
}

/// The residual standard deviation is that of the residuals, in the unit of the readings, also where lines scatter.
#[test]
fn residual_sd_is_that_of_the_residuals() {
    for name in ["table1_remount", "pos_few_none", "saturated_line"] {
        let report = report::fit_report(&fitted(&campaign(&format!("absorbed/{name}.campaign.json"))));
        let squares: f64 = report.readings.iter().map(|own| own.residual * own.residual).sum();
        assert_within(report.fit.sum_of_squares, squares, 1e-9 * squares, name);
        let sd = (squares / report.fit.dof as f64).sqrt();
        assert_within(report.fit.residual_sd.unwrap(), sd, 1e-9 * sd, name);
    }
}
