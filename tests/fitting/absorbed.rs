//! Deviations that the unknowns take up: nothing shows how large they are, so what follows them has no u, and the report says what to measure.

use crate::draws::draws;
use crate::support::{assert_within, campaign, fitted, parse, uncertainty};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
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

/// Campaigns like that one, 1,000 in full and 200 by default: 2 to 9 positions over a turn or at random, 1 to 6 readings each, noise beside
/// a scatter of positions from none to thirty times it, one to three lines of scatter, linear and quadratic models, at the drawn truth. Each with
/// one line settles. With several, two variances that both fall to nothing may go on falling: at most 5 in 100 do not settle, and say so.
#[test]
fn drawn_campaigns_settle() {
    let uniform = |random: &mut Pcg64Mcg| (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let normal = |random: &mut Pcg64Mcg| -> f64 { StandardNormal.sample(random) };
    let (count, mut random) = (draws(200, 1000), Pcg64Mcg::seed_from_u64(2911));
    let (mut unsettled, mut several) = (Vec::new(), 0);
    for number in 0..count {
        let (positions, repeats) =
            (2 + (uniform(&mut random) * 8.0) as usize, 1 + (uniform(&mut random) * 6.0) as usize);
        let even = uniform(&mut random) < 0.5;
        let model =
            ["b + k*a_z", "k*a_z + c*a_y + b", "k*a_z + c*a_y + b + q*a_z^2"][(uniform(&mut random) * 3.0) as usize];
        let estimate: Vec<String> = ["k", "c", "b", "q"]
            .iter()
            .filter(|id| model.contains(**id))
            .map(|id| format!(r#""{id}": {{}}"#))
            .collect();
        let noise = 10f64.powf(-6.0 + 2.0 * uniform(&mut random));
        let scatter =
            if uniform(&mut random) < 0.3 { 0.0 } else { noise * 10f64.powf(-1.0 + 2.5 * uniform(&mut random)) };
        let mut lines = vec![r#"{ "of": "A", "per": "position", "u": "estimate" }"#];
        let days = 2 + (uniform(&mut random) * 2.0) as usize;
        // a day of each reading is no line
        let shared = uniform(&mut random) < 0.3 && positions > days;
        lines.extend(shared.then_some(r#"{ "of": "A", "per": "day", "u": "estimate" }"#));
        lines.extend((uniform(&mut random) < 0.2).then_some(r#"{ "of": "b", "per": "position", "u": "estimate" }"#));
        let truth = [
            1.0 + 1e-3 * (uniform(&mut random) - 0.5),
            2e-3 * (uniform(&mut random) - 0.5),
            1e-3 * (uniform(&mut random) - 0.5),
            2e-4 * (uniform(&mut random) - 0.5),
        ];
        let angles: Vec<f64> = (0..positions)
            .map(|p| if even { 360.0 * p as f64 / positions as f64 } else { (uniform(&mut random) * 360.0).round() })
            .collect();
        let mut rows = Vec::new();
        for (p, angle) in angles.iter().enumerate() {
            let (sin, cos) = angle.to_radians().sin_cos();
            let shift = scatter * normal(&mut random);
            for _ in 0..repeats {
                let own = shift + noise * normal(&mut random);
                let value = truth[0] * cos + truth[1] * sin + truth[2] + truth[3] * cos * cos + own;
                rows.push(format!(
                    r#"{{ "position": "{p}", "day": "d{}", "t_deg": {angle}, "A": {value} }}"#,
                    p % days
                ));
            }
        }
        let text = format!(
            r#"{{ "bench": {{ "id": "g", "chain": [ {{ "joint": "t", "about": "x" }} ], "sensors": {{ "A": {{ "unit": "g", "model": "{model}" }} }} }},
                "estimate": {{ {} }}, "scatter": [ {} ], "readings": [ {} ] }}"#,
            estimate.join(", "),
            lines.join(", "),
            rows.join(", ")
        );
        let fit = fitted(&parse(&text));
        several += usize::from(lines.len() > 1);
        let converged = fit.convergence.as_ref().is_none_or(|own| own.converged);
        if !fit.settled || !converged {
            // what does not settle is no answer: exit code 2
            assert!(fit.is_rejected(), "{number}");
            unsettled.push((number, positions, repeats, model, noise, scatter, lines.len()));
        }
        // a parameter with a u has degrees of freedom
        for own in fit.parameters.iter().filter_map(|own| own.uncertainty) {
            assert!(own.dof > 0.0 && own.u >= 0.0 && own.u.is_finite(), "{number}: {own:?}");
        }
    }
    println!("{} of {count} campaigns ({several} with several lines) did not settle: {unsettled:?}", unsettled.len());
    assert!(unsettled.iter().all(|own| own.6 > 1), "{unsettled:?}");
    assert!(unsettled.len() * 100 <= 5 * several, "{unsettled:?}");
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
